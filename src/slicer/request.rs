//! What is asked for.

use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// How the print is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Technology {
    /// G-code for a filament printer.
    #[default]
    Filament,
    /// Layer masks for a resin printer.
    Resin,
}

/// One model to be sliced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Request {
    /// The model's file.
    pub model: PathBuf,
    /// Where the output goes; `None` only with `estimate`. Folders around it are made.
    pub output: Option<PathBuf>,
    /// How it is printed.
    pub technology: Technology,
    /// A resin printer by name, or a file that describes one.
    pub printer: Option<String>,
    /// Files of settings, later ones win.
    pub load: Vec<PathBuf>,
    /// Settings by key, over those of files. In JSON numbers, `true` and `false` need no quotes.
    #[serde(deserialize_with = "texts")]
    pub settings: BTreeMap<String, String>,
    /// How many of the model are laid on the bed.
    pub copies: u32,
    /// Which way facets face: `auto`, `winding`, `normals`, `repair`.
    pub orient: String,
    /// Gaps in open contours are closed up to this \[mm\].
    pub match_tolerance: Option<f64>,
    /// Vertices are rounded to multiples of this \[mm\].
    pub snap_grid: Option<f64>,
    /// Keep the model's coordinates.
    pub no_place: bool,
    /// Meshes in which all that hangs is supported; filament only.
    pub support_enforcers: Vec<PathBuf>,
    /// Meshes in which nothing is supported; filament only.
    pub support_blockers: Vec<PathBuf>,
    /// Turn about the vertical \[degrees\]; resin only.
    pub rotate: f64,
    /// Look for islands, cups and trapped resin; resin only.
    pub check: bool,
    /// Only say what would be printed: no output is written, a picture only if one is asked for.
    pub estimate: bool,
    /// A small picture of the middle layer goes here, as PNG.
    pub picture: Option<PathBuf>,
    /// CPU threads; `None` = the slicer's own number.
    pub threads: Option<u16>,
    /// The model's size \[bytes\] and time of modification \[ns since 1970\] as known to the caller; a file
    /// that has changed since is refused.
    pub expect: Option<[i64; 2]>,
    /// The date in the output, seconds since 1970-01-01 UTC.
    pub date: i64,
}

impl Default for Request {
    fn default() -> Self {
        Self {
            model: PathBuf::new(),
            output: None,
            technology: Technology::default(),
            printer: None,
            load: Vec::new(),
            settings: BTreeMap::new(),
            copies: 1,
            orient: "auto".to_owned(),
            match_tolerance: None,
            snap_grid: None,
            no_place: false,
            support_enforcers: Vec::new(),
            support_blockers: Vec::new(),
            rotate: 0.0,
            check: false,
            estimate: false,
            picture: None,
            threads: None,
            expect: None,
            date: 0,
        }
    }
}

/// For programs: a request step by step. All else is set by the fields.
impl Request {
    /// G-code of a model, with default settings.
    pub fn new(model: impl Into<PathBuf>) -> Self {
        Self { model: model.into(), ..Self::default() }
    }

    /// Where the output goes.
    #[must_use]
    pub fn output(self, path: impl Into<PathBuf>) -> Self {
        Self { output: Some(path.into()), ..self }
    }

    /// Masks for a resin printer, by its name or by a file that describes it, instead of G-code.
    #[must_use]
    pub fn resin(self, printer: impl Into<String>) -> Self {
        Self { technology: Technology::Resin, printer: Some(printer.into()), ..self }
    }

    /// One more file of settings; later ones win.
    #[must_use]
    pub fn load(mut self, path: impl Into<PathBuf>) -> Self {
        self.load.push(path.into());
        self
    }

    /// One setting, over those of files.
    #[must_use]
    pub fn set(mut self, key: impl Into<String>, value: impl Into<String>) -> Self {
        self.settings.insert(key.into(), value.into());
        self
    }

    /// So many of the model.
    #[must_use]
    pub fn copies(self, copies: u32) -> Self {
        Self { copies, ..self }
    }

    /// Writes nothing, only says what would be printed.
    #[must_use]
    pub fn estimate(self) -> Self {
        Self { estimate: true, ..self }
    }

    /// Draws the middle layer.
    #[must_use]
    pub fn picture(self, path: impl Into<PathBuf>) -> Self {
        Self { picture: Some(path.into()), ..self }
    }

    /// So many CPU threads.
    #[must_use]
    pub fn threads(self, threads: u16) -> Self {
        Self { threads: Some(threads), ..self }
    }
}

/// A value of a setting, as people write it in JSON.
#[derive(Deserialize)]
#[serde(untagged, expecting = "a setting's value must be a text, a number, true or false")]
enum Value {
    Text(String),
    Flag(bool),
    Whole(i64),
    Number(f64),
}

fn texts<'de, D: Deserializer<'de>>(deserializer: D) -> Result<BTreeMap<String, String>, D::Error> {
    let values = BTreeMap::<String, Value>::deserialize(deserializer)?;
    let text = |value| match value {
        Value::Text(text) => text,
        Value::Flag(on) => u8::from(on).to_string(),
        Value::Whole(n) => n.to_string(),
        Value::Number(n) => n.to_string(),
    };
    Ok(values.into_iter().map(|(key, value)| (key, text(value))).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn values_need_no_quotes() {
        let read = |text: &str| serde_json::from_str::<Request>(text);
        let request =
            read(r#"{"settings": {"a": 0.2, "b": 3, "c": true, "d": "15%", "e": -1e-3, "f": false}}"#)
                .unwrap();
        let values: Vec<&str> = request.settings.values().map(String::as_str).collect();
        assert_eq!(values, ["0.2", "3", "1", "15%", "-0.001", "0"]);
        let error = read(r#"{"settings": {"a": [1]}}"#).unwrap_err().to_string();
        assert!(error.contains("must be a text, a number, true or false"), "{error}");
        let error = read(r#"{"modle": "a"}"#).unwrap_err().to_string();
        assert!(error.contains("unknown field `modle`, expected one of `model`, `output`"), "{error}");
    }

    #[test]
    fn requests_survive_json() {
        let request = Request { rotate: 12.5, expect: Some([3, i64::MAX]), ..Request::new("ü/a b.stl") }
            .output("o.gcode")
            .load("a.ini")
            .load("b.toml")
            .set("layer_height", "0.2")
            .resin("prusa-sl1")
            .copies(7)
            .estimate()
            .picture("p.png")
            .threads(3);
        let text = serde_json::to_string(&request).unwrap();
        assert_eq!(serde_json::from_str::<Request>(&text).unwrap(), request);
        assert_eq!(request.load.len(), 2);
    }
}
