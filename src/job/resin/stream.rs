//! Layers from many threads to one writer, in order and with bounded memory.

use crate::job::threads;
use std::sync::mpsc::{SyncSender, sync_channel};

/// The end of a stream at which batches go in.
pub(super) struct Sender<T>(SyncSender<Vec<T>>);

impl<T> Sender<T> {
    /// Hands a batch on; waits while the writer has one lying ready. `false` when the writer has given up.
    pub(super) fn send(&self, batch: Vec<T>) -> bool {
        self.0.send(batch).is_ok()
    }
}

/// Runs `produce` on a thread of its own, or on one of the job's, which sends batches, and `receive` here for every item in
/// order. Besides the batch being made and the one being received at most one more exists.
///
/// # Errors
/// The receiver's first error, which ends the stream; else the producer's, after all that it sent has
/// been received.
pub(super) fn stream<T: Send, P: Send, E: Send>(
    produce: impl FnOnce(&Sender<T>) -> Result<P, E> + Send,
    mut receive: impl FnMut(T) -> Result<(), E>,
) -> Result<P, E> {
    std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel(1);
        let pool = threads::pool();
        let producer = scope.spawn(move || threads::on(pool.as_deref(), || produce(&Sender(sender))));
        let received = receiver.into_iter().flatten().try_for_each(&mut receive);
        let produced = match producer.join() {
            Ok(produced) => produced,
            Err(panic) => std::panic::resume_unwind(panic),
        };
        received.and(produced)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_arrive_in_order() {
        let mut seen = Vec::new();
        let produced: Result<_, ()> = stream(
            |sender| {
                for i in 0..100 {
                    assert!(sender.send(vec![3 * i, 3 * i + 1, 3 * i + 2]));
                }
                Ok("done")
            },
            |item| {
                seen.push(item);
                Ok(())
            },
        );
        assert_eq!(produced, Ok("done"));
        assert!(seen.iter().copied().eq(0..300));
    }

    #[test]
    fn a_writer_that_gives_up_stops_the_producer() {
        let mut seen = 0;
        let result = stream(
            |sender| {
                let sent = (0..1000).take_while(|&i| sender.send(vec![i])).count();
                assert!(sent < 10, "{sent}");
                Ok(())
            },
            |item| {
                seen += 1;
                if item == 2 { Err("full") } else { Ok(()) }
            },
        );
        assert_eq!((result, seen), (Err("full"), 3));
    }

    #[test]
    fn what_was_sent_before_a_failure_is_received() {
        let mut seen = 0;
        let result: Result<(), _> = stream(
            |sender| {
                sender.send(vec![1, 2]);
                Err("lost")
            },
            |_| {
                seen += 1;
                Ok(())
            },
        );
        assert_eq!((result, seen), (Err("lost"), 2));
    }
}
