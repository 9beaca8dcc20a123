//! The lines of a journal.

use crate::batch::event::Row;
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
    /// Number of the run: above those of all runs whose journals lay in the folder when it began. Tells the
    /// order of runs of several journals without a clock (Lamport, 1978).
    pub run: u64,
    /// The program's version.
    pub version: String,
    /// Whose journal it is.
    pub shard: Shard,
}

/// A try begins.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Started<'a> {
    pub name: Cow<'a, str>,
    pub key: Cow<'a, Key>,
    pub attempt: u32,
}

/// All lines but heads.
#[expect(clippy::large_enum_variant, reason = "there is one at a time")]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Record<'a> {
    /// `{"started":{"name":"a.gcode","key":"…","attempt":1}}`
    Started(Started<'a>),
    /// `{"ended":{…}}`: a row.
    Ended(Cow<'a, Row>),
    /// `{"checkpoint":{}}`: all outputs of the lines above, and these lines, have reached the disk.
    Checkpoint {},
    /// `{"closed":{}}`: the run has come to its end in order; what was in hand was given up.
    Closed {},
}

/// A line as read.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Line {
    Head(Head),
    Record(Box<Record<'static>>),
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

impl Line {
    /// Reads a line without its line feed.
    pub(super) fn parse(line: &[u8]) -> Result<Self, Wrong> {
        let damaged = |e: serde_json::Error| Wrong::Damaged(e.to_string());
        if !line.starts_with(br#"{"journal""#) {
            return serde_json::from_slice(line).map(|r| Self::Record(Box::new(r))).map_err(damaged);
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
