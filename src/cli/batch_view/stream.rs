//! Events as lines of JSON.

use crate::batch::event::Event;
use crate::batch::tally::Tally;
use serde::Serialize;
use std::io::{self, Write};

/// Seconds between two ticks.
const EVERY: f64 = 2.0;

/// Where a batch stands; comes between the events.
#[derive(Serialize)]
#[serde(tag = "event", rename = "tick")]
struct Tick {
    /// Since the begin \[s\].
    seconds: f64,
    jobs: usize,
    done: usize,
    skipped: usize,
    failed: usize,
    quarantined: usize,
    running: usize,
    waiting: usize,
    bytes: u64,
    bytes_done: u64,
    models_per_minute: f64,
    eta_seconds: Option<f64>,
}

/// Writes a line for each event, at once.
#[derive(Debug)]
pub(super) struct Stream<W> {
    out: W,
    last: f64,
    error: Option<io::Error>,
}

impl<W: Write> Stream<W> {
    pub(super) const fn new(out: W) -> Self {
        Self { out, last: 0.0, error: None }
    }

    pub(super) fn event(&mut self, event: &Event<'_>) {
        self.line(event);
    }

    /// Writes where the batch stands, if it is time.
    pub(super) fn tick(&mut self, tally: &Tally, now: f64) {
        if tally.is_over() || now - self.last < EVERY {
            return;
        }
        self.last = now;
        self.line(&Tick {
            seconds: now,
            jobs: tally.jobs,
            done: tally.done,
            skipped: tally.skipped,
            failed: tally.failed,
            quarantined: tally.quarantined,
            running: tally.running(),
            waiting: tally.waiting(),
            bytes: tally.bytes,
            bytes_done: tally.bytes_done,
            models_per_minute: tally.models_per_minute(now),
            eta_seconds: tally.eta(now),
        });
    }

    /// Whether nothing can be written any more.
    pub(super) const fn is_closed(&self) -> bool {
        self.error.is_some()
    }

    /// Why not.
    pub(super) fn into_error(self) -> Option<io::Error> {
        self.error
    }

    fn line(&mut self, record: &impl Serialize) {
        if self.error.is_some() {
            return;
        }
        let written = serde_json::to_vec(record).map_err(io::Error::from).and_then(|mut line| {
            line.push(b'\n');
            self.out.write_all(&line)?;
            self.out.flush()
        });
        self.error = written.err();
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::batch::event::Totals;
    use serde_json::Value;

    #[test]
    fn each_event_is_a_line() {
        let mut stream = Stream::new(Vec::new());
        let mut tally = Tally::default();
        let totals = Totals { done: 1, ..Totals::default() };
        for (event, now) in [
            (Event::Begun { jobs: 1, bytes: 5, workers: 2 }, 0.0),
            (Event::Started { name: "a\nb", attempt: 1, worker: 0 }, EVERY),
            (Event::Ended(&totals), 2.0 * EVERY),
        ] {
            tally.event(&event, now);
            stream.event(&event);
            stream.tick(&tally, now);
        }
        let text = String::from_utf8(stream.out).unwrap();
        let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let events: Vec<&str> = lines.iter().map(|line| line["event"].as_str().unwrap()).collect();
        assert_eq!(events, ["begun", "started", "tick", "ended"]);
        assert_eq!((&lines[2]["running"], &lines[2]["eta_seconds"]), (&1.into(), &Value::Null));
        assert_eq!((&lines[1]["name"], &lines[3]["done"]), (&"a\nb".into(), &1.into()));
    }

    /// A pipe without a reader.
    struct Broken;

    impl Write for Broken {
        fn write(&mut self, _: &[u8]) -> io::Result<usize> {
            Err(io::ErrorKind::BrokenPipe.into())
        }
        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_has_gone_is_noticed() {
        let mut stream = Stream::new(Broken);
        assert!(!stream.is_closed());
        stream.event(&Event::Begun { jobs: 0, bytes: 0, workers: 0 });
        assert!(stream.is_closed());
        assert_eq!(stream.into_error().unwrap().kind(), io::ErrorKind::BrokenPipe);
    }
}
