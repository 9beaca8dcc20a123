//! The loop of `microtome worker`.

mod lines;
mod output;
mod queue;

use super::protocol::{Answer, Message, News, Order};
use super::{Failure, Slicer};
use crate::job::JobError;
use crate::job::progress::Progress;
use lines::{Line, Lines};
use output::Output;
use queue::{Found, Queue, Task};
use serde_json::Value;
use std::io::{self, BufRead, Write};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

/// How a worker works.
#[derive(Clone, Debug)]
pub struct ServeOptions {
    /// Requests worked on at a time.
    pub jobs: usize,
    /// End at once, in the middle of everything, when the input ends without a `quit`: whoever employed the
    /// worker has died. Otherwise what is in hand is finished first.
    pub die_with_input: bool,
}

/// Stack of a thread \[bytes\]: as much as a main thread has.
const STACK: usize = 8 << 20;

/// Something that happened.
enum Event {
    Message(Message),
    /// A line that was not understood.
    Wrong(Answer),
    /// The input has ended.
    End,
    /// The input cannot be read any more.
    Unreadable(io::Error),
    /// The output cannot be written any more: a look at it is due.
    Unwritable,
}

/// Answers lines of requests until the input ends or a `quit` comes, and what is in hand is done. When nobody
/// reads the answers any more, what is in hand is given up; that is no error. The input is read by a thread of
/// its own, which may outlast this call if no further line comes.
///
/// # Errors
/// When the input cannot be read, the output cannot be written, or no thread can be started.
pub fn serve(
    slicer: &Slicer,
    options: &ServeOptions,
    input: impl BufRead + Send + 'static,
    output: impl Write + Send,
) -> io::Result<()> {
    // A line waits only while the one before is looked at, or while the queue is full.
    let (events, inbox) = sync_channel(1);
    let out = Output::new(output, events.clone());
    let queue = Queue::default();
    out.say(
        Value::Null,
        News::Ready { version: env!("CARGO_PKG_VERSION").to_owned(), pid: std::process::id() },
    );
    let die = options.die_with_input;
    thread::Builder::new().spawn(move || read(input, &events, die))?;
    let (asked, unreadable) = thread::scope(|scope| {
        let mut failed = None;
        for _ in 0..options.jobs.max(1) {
            let thread = thread::Builder::new().stack_size(STACK);
            if let Err(e) = thread.spawn_scoped(scope, || work(slicer, &queue, &out)) {
                failed = Some(e);
                break;
            }
        }
        let asked = match failed {
            None => listen(inbox, &queue, &out),
            Some(e) => (None, Some(e)),
        };
        if out.has_failed() {
            queue.give_up();
        }
        // Threads that wait for work go home when they have done what is there.
        queue.close();
        asked
    });
    if let Some(id) = asked {
        out.say(id, News::Ok(()));
    }
    let unwritable = out.failure().filter(|e| e.kind() != io::ErrorKind::BrokenPipe);
    unreadable.or(unwritable).map_or(Ok(()), Err)
}

/// Takes what happens until there is no more to come: the id of a `quit`, and what the input failed with.
fn listen<W: Write>(
    inbox: Receiver<Event>,
    queue: &Queue,
    out: &Output<W>,
) -> (Option<Value>, Option<io::Error>) {
    for event in inbox {
        match event {
            Event::Message(Message { id, order: Order::Quit(()) }) => return (Some(id), None),
            Event::Message(message) => obey(message, queue, out),
            Event::Wrong(answer) => out.say(answer.id, answer.news),
            Event::End => break,
            Event::Unreadable(e) => return (None, Some(e)),
            Event::Unwritable => {}
        }
        if out.has_failed() {
            break;
        }
    }
    (None, None)
}

/// Does what can be done at once, and puts requests into the queue.
fn obey<W: Write>(Message { id, order }: Message, queue: &Queue, out: &Output<W>) {
    let (request, follow) = match order {
        Order::Slice(request) => (request, false),
        Order::Follow(request) => (request, true),
        Order::Cancel(of) => {
            let news = match queue.cancel(&of) {
                Found::Working => News::Ok(()),
                Found::Waiting => {
                    out.say(of, News::Failed(Failure::from(&JobError::Cancelled)));
                    News::Ok(())
                }
                Found::Nothing => News::Refused(format!("cancel: no request with the id {of} is in hand")),
            };
            return out.say(id, news);
        }
        Order::Ping(()) | Order::Quit(()) => return out.say(id, News::Ok(())),
    };
    if let Err(task) = queue.put(Task::new(id, request, follow)) {
        let why = format!("a request with the id {} is in hand already; choose another id", task.id);
        out.say(task.id, News::Refused(why));
    }
}

/// Does one request after the other.
fn work<W: Write + Send>(slicer: &Slicer, queue: &Queue, out: &Output<W>) {
    while let Some(task) = queue.take() {
        if task.follow {
            out.say(task.id.clone(), News::Started(()));
        }
        let news = match slicer.slice(&task.request, &Followed { task: &task, out }) {
            Ok(outcome) => News::Done(Box::new(outcome)),
            Err(failure) => News::Failed(failure),
        };
        // Off the list first: whoever reads the answer may use the id again.
        queue.done(&task.id);
        out.say(task.id, news);
        if out.has_failed() {
            queue.give_up();
        }
    }
}

/// Tells of a request's stages where that is wanted.
struct Followed<'a, W> {
    task: &'a Task,
    out: &'a Output<W>,
}

impl<W: Write + Send> Progress for Followed<'_, W> {
    fn stage(&self, name: &'static str) {
        if self.task.follow {
            self.out.say(self.task.id.clone(), News::Stage(name.to_owned()));
        }
    }

    fn cancelled(&self) -> bool {
        self.task.cancel.is_cancelled() || self.out.has_failed()
    }
}

/// Reads lines until there are no more, or one says that there will be none.
fn read(input: impl BufRead, events: &SyncSender<Event>, die_with_input: bool) {
    let mut lines = Lines::new(input);
    loop {
        let event = match lines.next_line() {
            Ok(Some(Line::Whole(line))) => match Message::read(line) {
                Ok(message) => Event::Message(message),
                Err(answer) => Event::Wrong(answer),
            },
            Ok(Some(Line::TooLong)) => Event::Wrong(Answer {
                id: Value::Null,
                news: News::Refused(format!("a line of more than {} MiB", lines::LONGEST >> 20)),
            }),
            Ok(None) if die_with_input => end_at_once(),
            Ok(None) => Event::End,
            Err(e) => Event::Unreadable(e),
        };
        let last = matches!(
            event,
            Event::End | Event::Unreadable(_) | Event::Message(Message { order: Order::Quit(()), .. })
        );
        // Nobody listens any more when the output has failed.
        if events.send(event).is_err() || last {
            return;
        }
    }
}

/// Nothing that is under way is worth an orderly end: outputs have no name yet, and libraries that clean up while
/// others still work with them may hang.
fn end_at_once() -> ! {
    #[cfg(target_os = "linux")]
    let _ = rustix::process::kill_process(rustix::process::getpid(), rustix::process::Signal::KILL);
    std::process::exit(1)
}

#[cfg(test)]
mod tests;
