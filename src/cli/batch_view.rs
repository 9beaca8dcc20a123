//! What is seen of a running batch: a bar on a terminal, lines elsewhere, or JSON for programs; and a file
//! for Prometheus beside any of them.

mod lines;
mod stream;
mod terminal;

use super::exit::CliError;
use crate::batch::event::{Event, Observer, Totals};
use crate::batch::prometheus::TextFile;
use crate::batch::report;
use crate::batch::shard::Shard;
use crate::batch::tally::Tally;
use std::io::{self, IsTerminal, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Instant, SystemTime, UNIX_EPOCH};
use stream::Stream;
use terminal::Terminal;

/// Seconds between two lines where there is no terminal.
const LINE_EVERY: f64 = 10.0;

/// What is to be seen.
#[derive(Clone, Debug)]
pub struct ViewOptions {
    /// Nothing but errors.
    pub quiet: bool,
    /// Events as lines of JSON on standard output.
    pub json: bool,
    /// The output folder.
    pub folder: PathBuf,
    /// Which part of the batch is ours.
    pub shard: Shard,
    /// The file for Prometheus.
    pub prometheus: Option<PathBuf>,
}

/// Shows how a batch is getting on.
#[derive(Debug)]
pub struct View {
    options: ViewOptions,
    tally: Tally,
    begun: Instant,
    terminal: Option<Terminal>,
    stream: Option<Stream<io::Stdout>>,
    prometheus: Option<TextFile>,
    /// When the last line was printed \[s\].
    line: f64,
    /// Set from outside when the batch is to stop.
    stop: Arc<AtomicBool>,
    /// Whether that has been said.
    stopping: bool,
    /// Whether it has been said that the file for Prometheus cannot be written.
    complained: bool,
}

impl View {
    /// Begins to watch. The batch ends early once `stop` is set.
    ///
    /// # Errors
    /// [`CliError::Batch`] when the file for Prometheus cannot be written.
    pub fn new(options: ViewOptions, stop: Arc<AtomicBool>) -> Result<Self, CliError> {
        // A bar and lines of JSON on one terminal would tear each other apart.
        let beside = options.json && io::stdout().is_terminal();
        let shown = !options.quiet && !beside && io::stderr().is_terminal();
        let mut prometheus =
            options.prometheus.as_ref().map(|path| TextFile::new(path, &options.folder, options.shard));
        if let Some(file) = &mut prometheus {
            file.update(&Tally::default(), 0.0, since_1970())?;
        }
        Ok(Self {
            tally: Tally::default(),
            begun: Instant::now(),
            terminal: shown.then(Terminal::default),
            stream: options.json.then(|| Stream::new(io::stdout())),
            prometheus,
            line: 0.0,
            stop,
            stopping: false,
            complained: false,
            options,
        })
    }

    /// Takes the bar away and says what the batch came to.
    ///
    /// # Errors
    /// [`CliError::Stdout`] when the events could not be written; no failure where only their reader has gone.
    pub fn finish(mut self, totals: &Totals) -> Result<(), CliError> {
        drop(self.terminal.take());
        if !self.options.quiet && !self.options.json {
            let page = report::page(&self.options.folder, self.options.shard);
            let text = lines::summary(&self.tally, totals, &page);
            // Nobody is left to tell when stderr is closed.
            drop(io::stderr().lock().write_all(text.as_bytes()));
        }
        match self.stream.and_then(Stream::into_error) {
            Some(error) => Err(error.into()),
            None => Ok(()),
        }
    }

    fn now(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }

    /// A line on stderr, above the bar if there is one.
    fn say(&self, line: &str) {
        match &self.terminal {
            Some(terminal) => terminal.print(line),
            None => drop(writeln!(io::stderr().lock(), "{line}")),
        }
    }
}

impl Observer for View {
    fn event(&mut self, event: &Event<'_>) {
        if matches!(event, Event::Begun { .. }) {
            self.begun = Instant::now();
        }
        let now = self.now();
        self.tally.event(event, now);
        if let Some(stream) = &mut self.stream {
            stream.event(event);
        } else if let Some(line) = lines::event(event, self.options.quiet) {
            self.say(&line);
        }
        self.tick();
    }

    fn tick(&mut self) {
        let now = self.now();
        if let Some(stream) = &mut self.stream {
            stream.tick(&self.tally, now);
        }
        if let Some(file) = &mut self.prometheus
            && let Err(error) = file.update(&self.tally, now, since_1970())
            && !self.complained
        {
            self.complained = true;
            self.say(&format!("warning: {}", report::plain(&error.to_string())));
        }
        if let Some(terminal) = &mut self.terminal {
            terminal.draw(&self.tally, now);
        } else if !self.options.quiet
            && !self.options.json
            && !self.tally.is_over()
            && now - self.line >= LINE_EVERY
        {
            self.line = now;
            self.say(&lines::status(&self.tally, now));
        }
        if !self.stopping && self.stop.load(Ordering::Relaxed) {
            self.stopping = true;
            if !self.options.quiet && !self.options.json {
                self.say("stopping; --resume goes on where this ends");
            }
        }
    }

    fn stop(&mut self) -> bool {
        self.stop.load(Ordering::Relaxed) || self.stream.as_ref().is_some_and(Stream::is_closed)
    }
}

fn since_1970() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64())
}
