//! The lines of a journal.

use crate::batch::event::{Row, Status};
use crate::batch::key::Key;
use crate::batch::shard::Shard;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// The format that is written, and the only one read.
pub(super) const FORMAT: u32 = 1;

/// Begins a run: the first line, and again whenever a process opens the journal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Head {
    /// The format, [`FORMAT`].
    pub journal: u32,
    /// Tells the order of runs: milliseconds since 1970, or one more than the latest run that was read, if
    /// that is later. So a clock that is wrong does not turn the order of runs that knew of each other (a
    /// hybrid logical clock: Kulkarni and others, "Logical physical clocks", 2014).
    pub run: u64,
    /// The program's version.
    pub version: String,
    /// Whose journal it is.
    pub shard: Shard,
}

/// All lines but heads, as written.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Entry<'a> {
    /// `{"started":{"name":"a.gcode","key":"…","attempt":1}}`
    Started { name: &'a str, key: &'a Key, attempt: u32 },
    /// `{"ended":{…}}`
    Ended(&'a Row),
    /// `{"checkpoint":{}}`: all outputs of the lines above, and these lines, have reached the disk.
    Checkpoint {},
    /// `{"closed":{}}`: the run has come to its end in order; what was in hand was given up.
    Closed {},
}

/// The same, as read; of rows only what tells which.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Record<'a> {
    Started {
        #[serde(borrow)]
        name: Cow<'a, str>,
        key: Key,
    },
    Ended {
        #[serde(borrow)]
        name: Cow<'a, str>,
        key: Key,
        status: Status,
    },
    Checkpoint {},
    Closed {},
}

/// A line with a row.
#[derive(Debug, Deserialize)]
pub(super) struct Ended {
    pub ended: Row,
}

/// A line as read.
#[derive(Debug)]
pub(super) enum Line<'a> {
    Head(Head),
    Record(Record<'a>),
}

/// Of a head, what every format has.
#[derive(Deserialize)]
struct Format {
    journal: u32,
}

/// Why a line is none.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Wrong {
    /// Torn or garbled.
    Damaged(String),
    /// Sound, but of another format; never to be cut off.
    OtherFormat(u32),
}

impl<'a> Line<'a> {
    /// Reads a line without its line feed.
    pub(super) fn parse(line: &'a [u8]) -> Result<Self, Wrong> {
        let damaged = |e: serde_json::Error| Wrong::Damaged(e.to_string());
        if !line.starts_with(br#"{"journal""#) {
            return serde_json::from_slice(line).map(Self::Record).map_err(damaged);
        }
        match serde_json::from_slice::<Format>(line).map_err(damaged)?.journal {
            FORMAT => serde_json::from_slice(line).map(Self::Head).map_err(damaged),
            other => Err(Wrong::OtherFormat(other)),
        }
    }
}

/// A line with its line feed. JSON escapes line feeds inside texts, so that there is no other.
pub(super) fn line(record: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec(record)?;
    bytes.push(b'\n');
    Ok(bytes)
}
