//! One worker process and the threads that listen to it.

use crate::job::FailureKind;
use crate::slicer::protocol::{Answer, News as Line};
use crate::slicer::{Failure, Outcome};
use std::ffi::OsString;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{self, ChildStdin, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::Duration;

/// Where news go; called from several threads.
pub type Post = Arc<dyn PostBox>;

/// Receives news.
pub trait PostBox: Send + Sync + std::fmt::Debug {
    /// Takes them.
    fn post(&self, news: News);
}

/// What a worker lets us know.
#[derive(Debug)]
pub struct News {
    /// Number of the worker, and the running number of its process.
    pub place: (usize, u64),
    /// What.
    pub said: Said,
}

/// What a worker says.
#[derive(Debug)]
pub enum Said {
    /// It can work.
    Ready {
        /// Its version.
        version: String,
    },
    /// A job is done.
    Done {
        /// Which.
        ticket: u64,
        /// What came of it.
        outcome: Box<Outcome>,
    },
    /// A job failed.
    Failed {
        /// Which.
        ticket: u64,
        /// Why.
        failure: Failure,
    },
    /// Nothing of interest.
    Nothing,
    /// Something that no worker says.
    Nonsense,
    /// Its output has ended.
    Closed,
}

/// Stack of a thread that only listens \[bytes\].
const STACK: usize = 256 << 10;

/// A longer line on a worker's standard error is cut \[bytes\].
const LONGEST_COMPLAINT: usize = 400;

/// How long we wait for the last words of a process that has ended.
const LAST_WORDS: Duration = Duration::from_millis(200);

#[derive(Debug)]
pub(super) struct Child {
    process: process::Child,
    input: Option<ChildStdin>,
    last_words: Receiver<String>,
    serial: u64,
}

impl Child {
    pub(super) fn start(
        program: &Path,
        arguments: &[OsString],
        place: (usize, u64),
        post: &Post,
    ) -> io::Result<Self> {
        let mut command = Command::new(program);
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        // Ctrl-C goes to a terminal's whole group; it is for us to say when workers end.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut process = command.spawn()?;
        let (output, errors) = (process.stdout.take(), process.stderr.take());
        let (sender, last_words) = channel();
        let child = Self { input: process.stdin.take(), process, last_words, serial: place.1 };
        let post = Arc::clone(post);
        let listen = || thread::Builder::new().stack_size(STACK);
        listen().name(format!("worker {}", place.0)).spawn(move || {
            if let Some(output) = output {
                read_answers(BufReader::new(output), |said| post.post(News { place, said }));
            }
            post.post(News { place, said: Said::Closed });
        })?;
        listen().name(format!("complaints {}", place.0)).spawn(move || read_complaints(errors, &sender))?;
        Ok(child)
    }

    pub(super) const fn serial(&self) -> u64 {
        self.serial
    }

    pub(super) fn pid(&self) -> u32 {
        self.process.id()
    }

    /// Writes a line. If the process is dead, news of that are on their way.
    pub(super) fn write(&mut self, line: &str) {
        if let Some(input) = &mut self.input {
            let mut bytes = line.as_bytes().to_vec();
            bytes.push(b'\n');
            drop(input.write_all(&bytes));
        }
    }

    pub(super) fn kill(&mut self) {
        // It may have ended by itself.
        drop(self.process.kill());
    }

    pub(super) fn wait(&mut self) {
        drop(self.process.wait());
    }

    /// Why a process ended whose output has ended, and whether somebody had asked it to.
    pub(super) fn epitaph(&mut self) -> (String, bool) {
        self.kill();
        let status = self.process.wait();
        let words = self.last_words.recv_timeout(LAST_WORDS).unwrap_or_default();
        let words = if words.is_empty() { words } else { format!(": {words}") };
        match status {
            Ok(status) => (format!("{}{words}", cause(status)), was_asked(status)),
            Err(e) => (format!("ended for reasons unknown ({e}){words}"), false),
        }
    }
}

impl Drop for Child {
    fn drop(&mut self) {
        self.kill();
        self.wait();
    }
}

/// How a process ended, as part of a sentence.
fn cause(status: ExitStatus) -> String {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return match signal {
            9 => "was killed (signal 9), perhaps for lack of memory".to_owned(),
            _ => format!("crashed (signal {signal})"),
        };
    }
    match status.code() {
        Some(code) => format!("ended with exit code {code}"),
        None => "ended for reasons unknown".to_owned(),
    }
}

/// Whether a signal to end has ended a process: SIGHUP, SIGINT or SIGTERM.
fn was_asked(status: ExitStatus) -> bool {
    #[cfg(unix)]
    return matches!(std::os::unix::process::ExitStatusExt::signal(&status), Some(1 | 2 | 15));
    #[cfg(not(unix))]
    {
        let _ = status;
        false
    }
}

fn read_answers(mut output: impl BufRead, mut post: impl FnMut(Said)) {
    let mut line = String::new();
    while output.read_line(&mut line).is_ok_and(|n| n > 0) {
        post(understand(&line));
        line.clear();
    }
}

fn understand(line: &str) -> Said {
    let Ok(Answer { id, news }) = serde_json::from_str::<Answer>(line) else { return Said::Nonsense };
    match (news, id.as_u64()) {
        (Line::Ready { version, .. }, _) => Said::Ready { version },
        (Line::Done(outcome), Some(ticket)) => Said::Done { ticket, outcome },
        (Line::Failed(failure), Some(ticket)) => Said::Failed { ticket, failure },
        (Line::Started(()) | Line::Stage(_) | Line::Ok(()), _) => Said::Nothing,
        // A cancel that came too late is refused; it has no ticket.
        (Line::Refused(_), None) => Said::Nothing,
        (Line::Refused(problem), Some(ticket)) => {
            Said::Failed { ticket, failure: Failure::new(FailureKind::Defect, problem) }
        }
        _ => Said::Nonsense,
    }
}

/// Keeps the last line that says anything.
fn read_complaints(errors: Option<impl Read>, last: &Sender<String>) {
    let mut kept = String::new();
    if let Some(errors) = errors {
        let mut errors = BufReader::new(errors);
        let mut line = Vec::new();
        while errors.read_until(b'\n', &mut line).is_ok_and(|n| n > 0) {
            let cut = line.get(..LONGEST_COMPLAINT).unwrap_or(&line);
            let text = String::from_utf8_lossy(cut);
            if !text.trim().is_empty() {
                kept = text.trim().to_owned();
            }
            line.clear();
        }
    }
    // Nobody may want to know.
    drop(last.send(kept));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_understood() {
        let of = |line: &str| format!("{:?}", understand(line));
        assert!(of(r#"{"id":null,"ready":{"version":"1.2","pid":3}}"#).contains("Ready"));
        assert!(of(r#"{"id":7,"done":{}}"#).starts_with("Done { ticket: 7"));
        let failed =
            r#"{"id":7,"failed":{"kind":"model","message":"m","transient":false,"disk_full":false}}"#;
        assert!(of(failed).starts_with("Failed { ticket: 7"));
        assert!(of(r#"{"id":7,"refused":"why"}"#).contains("Defect"));
        assert_eq!(of(r#"{"id":null,"refused":"no such request"}"#), "Nothing");
        for line in ["", "hello", "{}", r#"{"id":"x","done":{}}"#] {
            assert_eq!(of(line), "Nonsense", "{line}");
        }
    }

    #[test]
    fn of_complaints_the_last_is_kept() {
        let last = |text: &str| {
            let (sender, receiver) = channel();
            read_complaints(Some(text.as_bytes()), &sender);
            receiver.recv().unwrap_or_default()
        };
        assert_eq!(last(""), "");
        assert_eq!(last("one\ntwo \n\n"), "two");
        assert_eq!(last(&"x".repeat(9999)).len(), LONGEST_COMPLAINT);
    }
}
