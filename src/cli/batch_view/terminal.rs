//! A bar for the batch, and a line for each worker.

use super::lines;
use crate::batch::report::{duration, plain};
use crate::batch::tally::{Doing, Tally};
use indicatif::{MultiProgress, ProgressBar, ProgressStyle};

/// Workers that have a line.
const MOST_WORKERS: usize = 12;
/// Seconds between two drawings.
const EVERY: f64 = 0.1;

/// Drawn on stderr; gone when dropped.
#[derive(Debug)]
pub(super) struct Terminal {
    all: MultiProgress,
    bar: ProgressBar,
    workers: Vec<ProgressBar>,
    drawn: f64,
}

impl Default for Terminal {
    fn default() -> Self {
        let all = MultiProgress::new();
        let bar = all.add(ProgressBar::new(1));
        if let Ok(style) = ProgressStyle::with_template("{bar:30} {percent:>3}%  {wide_msg}") {
            bar.set_style(style.progress_chars("█▉▊▋▌▍▎▏ "));
        }
        Self { all, bar, workers: Vec::new(), drawn: f64::NEG_INFINITY }
    }
}

impl Terminal {
    /// Prints a line above the bar.
    pub(super) fn print(&self, line: &str) {
        // Nobody is left to tell when stderr is closed.
        drop(self.all.println(line));
    }

    /// Draws anew, if it is time.
    pub(super) fn draw(&mut self, tally: &Tally, now: f64) {
        if now - self.drawn < EVERY {
            return;
        }
        self.drawn = now;
        while self.workers.len() < tally.workers.len().min(MOST_WORKERS) {
            let line = self.all.insert_before(&self.bar, ProgressBar::new(0));
            if let Ok(style) = ProgressStyle::with_template("{wide_msg}") {
                line.set_style(style);
            }
            self.workers.push(line);
        }
        for (index, (line, doing)) in self.workers.iter().zip(&tally.workers).enumerate() {
            line.set_message(worker(index, doing.as_ref(), now));
        }
        let (done, all) = tally.weight();
        self.bar.set_length(all.max(1));
        self.bar.set_position(done);
        self.bar.set_message(lines::status(tally, now));
    }
}

/// What a worker is at.
fn worker(index: usize, doing: Option<&Doing>, now: f64) -> String {
    let number = index + 1;
    let Some(doing) = doing else { return format!("{number:>4}  -") };
    let again = if doing.attempt > 1 { format!(" (try {})", doing.attempt) } else { String::new() };
    // Nobody needs tenths of seconds that flicker.
    let since = duration((now - doing.since).floor() + 1.0).replace(".0s", "s");
    format!("{number:>4}  {since:>6}  {}{again}", plain(&doing.name))
}

impl Drop for Terminal {
    fn drop(&mut self) {
        drop(self.all.clear());
    }
}
