//! Lines of JSON between a worker and whoever employs it.
//!
//! Each line in is a [`Message`]; each gets one [`Answer`] with its `id`, in the order in which the work
//! ends, beside news of requests that asked for them.

use super::{Failure, Outcome, Request};
use serde::{Deserialize, Serialize};

/// A line to the worker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Message {
    /// Comes back with the answer; any JSON value.
    pub id: serde_json::Value,
    /// What to do.
    #[serde(flatten)]
    pub order: Order,
}

/// What to do.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// `{"id": 1, "slice": {"model": "a.stl", "output": "a.gcode"}}`
    Slice(Box<Request>),
    /// The same, with news on the way.
    Follow(Box<Request>),
    /// `{"id": 2, "cancel": 1}`: the request with that id is to stop; it is answered as cancelled.
    Cancel(serde_json::Value),
    /// `{"id": 3, "ping": null}`
    Ping(()),
    /// No more requests: what is in hand is finished, then the worker ends. The end of its input means the same.
    Quit(()),
}

/// A line from the worker.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The message's.
    pub id: serde_json::Value,
    /// What there is to say.
    #[serde(flatten)]
    pub news: News,
}

/// What a worker says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum News {
    /// First line of all, with `"id": null`.
    Ready {
        /// The program's version.
        version: String,
        /// The process.
        pid: u32,
    },
    /// Work on a followed request begins.
    Started(()),
    /// A stage of a followed request begins.
    Stage(String),
    /// A request is done.
    Done(Box<Outcome>),
    /// A request failed.
    Failed(Failure),
    /// To a ping, and to a cancel that found its request.
    Ok(()),
    /// The line was not understood; `id` is null where it could not be read.
    Refused(String),
}
