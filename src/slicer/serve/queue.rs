//! Requests in hand: those that wait, and those that are worked on.

use crate::slicer::{Cancel, Request};
use serde_json::Value;
use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

/// Requests that wait at most; whoever brings more waits too.
const LONGEST: usize = 4096;

/// A request in hand.
#[derive(Debug)]
pub struct Task {
    pub id: Value,
    pub request: Box<Request>,
    /// Whether there is to be news of it.
    pub follow: bool,
    pub cancel: Cancel,
}

impl Task {
    pub fn new(id: Value, request: Box<Request>, follow: bool) -> Self {
        Self { id, request, follow, cancel: Cancel::new() }
    }
}

/// Where a request was that is to stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    /// Worked on; it will be answered as cancelled, or as done if it was too late.
    Working,
    /// Waiting; it waits no longer and is not answered by those who work.
    Waiting,
    Nothing,
}

/// Requests in hand, first come first served.
#[derive(Debug, Default)]
pub struct Queue {
    state: Mutex<State>,
    changed: Condvar,
}

#[derive(Debug, Default)]
struct State {
    waiting: VecDeque<Task>,
    working: Vec<(Value, Cancel)>,
    closed: bool,
}

impl Queue {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Appends a request, after a while if there are very many. It comes back when its id is in hand already.
    /// After [`Self::close`] it is dropped.
    pub fn put(&self, task: Task) -> Result<(), Task> {
        let mut state = self.state();
        let known = |id: &Value| {
            state.waiting.iter().any(|t| t.id == *id) || state.working.iter().any(|(known, _)| known == id)
        };
        if known(&task.id) {
            return Err(task);
        }
        while state.waiting.len() >= LONGEST && !state.closed {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if !state.closed {
            state.waiting.push_back(task);
            self.changed.notify_all();
        }
        Ok(())
    }

    /// The next request; waits for one. `None` when there will be none.
    pub fn take(&self) -> Option<Task> {
        let mut state = self.state();
        loop {
            if let Some(task) = state.waiting.pop_front() {
                state.working.push((task.id.clone(), task.cancel.clone()));
                self.changed.notify_all();
                return Some(task);
            }
            if state.closed {
                return None;
            }
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// A request is no longer worked on.
    pub fn done(&self, id: &Value) {
        self.state().working.retain(|(known, _)| known != id);
    }

    /// Stops a request.
    pub fn cancel(&self, id: &Value) -> Found {
        let mut state = self.state();
        if let Some(at) = state.waiting.iter().position(|t| t.id == *id) {
            state.waiting.remove(at);
            self.changed.notify_all();
            return Found::Waiting;
        }
        match state.working.iter().find(|(known, _)| known == id) {
            Some((_, cancel)) => {
                cancel.cancel();
                Found::Working
            }
            None => Found::Nothing,
        }
    }

    /// No more requests come; those that wait are done.
    pub fn close(&self) {
        self.state().closed = true;
        self.changed.notify_all();
    }

    /// No more requests come, those that wait are dropped and those worked on are stopped.
    pub fn give_up(&self) {
        let mut state = self.state();
        state.closed = true;
        state.waiting.clear();
        state.working.iter().for_each(|(_, cancel)| cancel.cancel());
        self.changed.notify_all();
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use serde_json::json;

    fn task(id: usize) -> Task {
        Task::new(json!(id), Box::new(Request::new("m.stl")), false)
    }

    #[test]
    fn requests_are_taken_in_order_and_stopped_wherever_they_are() {
        let queue = Queue::default();
        for id in 1..=3 {
            queue.put(task(id)).unwrap();
        }
        assert_eq!(queue.put(task(2)).unwrap_err().id, 2, "an id is there once");
        let first = queue.take().unwrap();
        assert_eq!((first.id.clone(), first.cancel.is_cancelled()), (json!(1), false));
        assert!(queue.put(task(1)).is_err(), "worked on is in hand too");
        assert_eq!(
            [1, 2, 7].map(|id| queue.cancel(&json!(id))),
            [Found::Working, Found::Waiting, Found::Nothing]
        );
        assert!(first.cancel.is_cancelled());
        queue.done(&first.id);
        queue.put(task(1)).unwrap();
        queue.close();
        queue.put(task(9)).unwrap();
        assert_eq!([3, 1].map(|_| queue.take().unwrap().id), [json!(3), json!(1)]);
        assert!(queue.take().is_none());
    }

    #[test]
    fn giving_up_wakes_everyone() {
        let queue = Queue::default();
        queue.put(task(0)).unwrap();
        let first = queue.take().unwrap();
        for id in 1..=LONGEST {
            queue.put(task(id)).unwrap();
        }
        std::thread::scope(|scope| {
            let put = scope.spawn(|| queue.put(task(LONGEST + 1)));
            queue.give_up();
            assert!(put.join().unwrap().is_ok());
        });
        assert!(first.cancel.is_cancelled() && queue.take().is_none());
    }
}
