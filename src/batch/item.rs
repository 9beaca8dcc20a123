//! The jobs of a batch, from what was typed.

use super::BatchError;
use crate::slicer::Request;
use std::path::PathBuf;

/// One job of a batch.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    /// What is asked of a worker; its output is a path inside the output folder.
    pub request: Request,
    /// The output's name relative to the output folder, with `/`; unique in the batch. Stands for the job in reports.
    pub name: String,
    /// Size of the model's file \[bytes\]; 0 where it cannot be told.
    pub size: u64,
    /// Where the manifest names it: file and line; `None` for plain files.
    pub place: Option<(PathBuf, u64)>,
    /// What is wrong with it already: the job fails without a try.
    pub refused: Option<crate::slicer::Failure>,
}

/// What a batch is made from.
#[derive(Clone, Debug)]
pub struct Input<'a> {
    /// Files, folders, patterns, manifests (`.jsonl`, `.csv`), as typed.
    pub inputs: &'a [String],
    /// What holds for every job that a manifest does not say otherwise.
    pub base: &'a Request,
    /// The output folder.
    pub folder: &'a std::path::Path,
    /// Extension of outputs; `None` = `gcode`, or what the printer reads.
    pub extension: Option<&'a str>,
}

/// All jobs, in the order given; files of folders and patterns by name.
///
/// # Errors
/// [`BatchError`]: an input that is not there, a manifest that cannot be understood, nothing to do. A model of
/// a manifest that is not there is no error here; its job fails.
pub fn items(input: &Input<'_>) -> Result<Vec<Item>, BatchError> {
    let _ = input;
    Ok(Vec::new())
}
