//! Manifests: a job a line, as JSON or CSV.

use super::BatchError;
use super::names;
use crate::settings::{nearest_of, printers};
use crate::slicer::Technology;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::{Path, PathBuf};

/// A line of a manifest. Files are relative to the manifest's folder already.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Line {
    /// From 1.
    pub line: u64,
    /// The model.
    pub model: PathBuf,
    /// Files of settings.
    pub profile: Vec<PathBuf>,
    /// Settings by key.
    pub settings: BTreeMap<String, String>,
    /// Name in the output folder.
    pub output: Option<String>,
    /// Copies on the bed.
    pub copies: Option<u32>,
    /// How it is printed.
    pub technology: Option<Technology>,
    /// A resin printer.
    pub printer: Option<String>,
    /// Extension of the output; empty for a folder of pictures.
    pub format: Option<String>,
    /// Which way facets face.
    pub orient: Option<String>,
    /// Gaps are closed up to this \[mm\].
    pub match_tolerance: Option<f64>,
    /// Vertices are rounded to this \[mm\].
    pub snap_grid: Option<f64>,
    /// Keep the model's coordinates.
    pub no_place: Option<bool>,
    /// Where all that hangs is supported.
    pub support_enforcers: Option<Vec<PathBuf>>,
    /// Where nothing is.
    pub support_blockers: Option<Vec<PathBuf>>,
    /// Turn about the vertical \[degrees\].
    pub rotate: Option<f64>,
    /// Look for islands, cups and trapped resin.
    pub check: Option<bool>,
    /// SHA-256 of the model, so that other shards need not read it.
    pub sha256: Option<String>,
}

/// A row of a table is never longer \[bytes\].
const LONGEST_ROW: usize = 1 << 20;

/// A value as it stands in the manifest.
#[derive(Clone, Copy, Debug)]
enum Cell<'a> {
    Text(&'a str),
    Json(&'a Value),
}

/// Puts a value into a line; the path is the manifest's folder.
type Put = fn(&mut Line, Cell<'_>, &Path) -> Result<(), String>;

/// All columns.
const COLUMNS: [(&str, Put); 17] = [
    ("model", |l, c, at| c.text().map(|t| l.model = at.join(t))),
    ("profile", |l, c, at| c.files(at).map(|v| l.profile = v)),
    ("settings", |l, c, _| c.settings().map(|v| l.settings = v)),
    ("output", |l, c, _| names::checked(&c.text()?).map(|v| l.output = Some(v))),
    ("copies", |l, c, _| c.count().map(|v| l.copies = Some(v))),
    ("technology", |l, c, _| c.technology().map(|v| l.technology = Some(v))),
    ("printer", |l, c, at| {
        let name = c.text()?;
        let file = || at.join(&name).to_string_lossy().into_owned();
        l.printer = Some(if printers::is_file(&name) { file() } else { name });
        Ok(())
    }),
    ("format", |l, c, _| names::extension_of_format(&c.text()?).map(|v| l.format = Some(v))),
    ("orient", |l, c, _| c.orient().map(|v| l.orient = Some(v))),
    ("match_tolerance", |l, c, _| c.number("mm", 0.0, 1000.0).map(|v| l.match_tolerance = Some(v))),
    ("snap_grid", |l, c, _| c.number("mm", 0.0, 10.0).map(|v| l.snap_grid = Some(v))),
    ("no_place", |l, c, _| c.flag().map(|v| l.no_place = Some(v))),
    ("support_enforcers", |l, c, at| c.files(at).map(|v| l.support_enforcers = Some(v))),
    ("support_blockers", |l, c, at| c.files(at).map(|v| l.support_blockers = Some(v))),
    ("rotate", |l, c, _| c.number("degrees", -3600.0, 3600.0).map(|v| l.rotate = Some(v))),
    ("check", |l, c, _| c.flag().map(|v| l.check = Some(v))),
    ("sha256", |l, c, _| c.sha256().map(|v| l.sha256 = Some(v))),
];

/// Takes a line, or says what is wrong with it.
pub type Each<'a> = &'a mut dyn FnMut(Line) -> Result<(), String>;

/// Reads a manifest, `.csv` as CSV and all else as lines of JSON, from a file or, for `-`, from standard input.
///
/// # Errors
/// [`BatchError::Input`] where it cannot be read, [`BatchError::Manifest`] with the line that cannot be understood.
pub fn read(path: &Path, each: Each<'_>) -> Result<(), BatchError> {
    if path == Path::new(super::inputs::STDIN) {
        return json(path, io::stdin().lock(), each);
    }
    let file = File::open(path).map_err(|source| BatchError::Input { path: path.to_owned(), source })?;
    let is_csv = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("csv"));
    let file = BufReader::new(file);
    if is_csv { csv(path, file, each) } else { json(path, file, each) }
}

/// A line of JSON a job.
fn json(path: &Path, mut input: impl BufRead, each: Each<'_>) -> Result<(), BatchError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut bytes = Vec::new();
    for number in 1.. {
        bytes.clear();
        let count = input.read_until(b'\n', &mut bytes);
        if count.map_err(|source| BatchError::Input { path: path.to_owned(), source })? == 0 {
            break;
        }
        let wrong = |problem| BatchError::Manifest { path: path.to_owned(), line: number, problem };
        let text = if number == 1 { without_mark(&bytes) } else { &bytes }.trim_ascii();
        if text.is_empty() {
            continue;
        }
        let value: Value = serde_json::from_slice(text).map_err(|e| wrong(json_problem(&e)))?;
        let Value::Object(object) = &value else {
            return Err(wrong(
                "not a JSON object; write a job a line, such as {\"model\": \"a.stl\"}".to_owned(),
            ));
        };
        let mut line = Line { line: number, ..Line::default() };
        for (key, value) in object {
            let put = column(key).map_err(wrong)?;
            if !value.is_null() {
                put(&mut line, Cell::Json(value), folder).map_err(|e| wrong(within(key, &e)))?;
            }
        }
        complete(line).and_then(&mut *each).map_err(wrong)?;
    }
    Ok(())
}

/// A table whose first line names the columns.
fn csv(path: &Path, mut input: impl BufRead, each: Each<'_>) -> Result<(), BatchError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut puts: Vec<(String, Put)> = Vec::new();
    let (mut bytes, mut next) = (Vec::new(), 1);
    loop {
        bytes.clear();
        let number = next;
        let wrong = |problem| BatchError::Manifest { path: path.to_owned(), line: number, problem };
        // A cell in quotes may hold line ends; its quotes come in pairs.
        while bytes.is_empty() || bytes.iter().filter(|b| **b == b'"').count() % 2 == 1 {
            let count = input.read_until(b'\n', &mut bytes);
            if count.map_err(|source| BatchError::Input { path: path.to_owned(), source })? == 0 {
                break;
            }
            next += 1;
            if bytes.len() > LONGEST_ROW {
                return Err(wrong("a quote is never closed; double it inside of cells".to_owned()));
            }
        }
        if bytes.is_empty() {
            return Ok(());
        }
        let row = if number == 1 { without_mark(&bytes) } else { &bytes };
        let cells = cells(row).map_err(wrong)?;
        if cells.iter().all(String::is_empty) {
            continue;
        }
        if puts.is_empty() {
            for (i, name) in cells.iter().enumerate() {
                let put = column(name).map_err(wrong)?;
                if cells[..i].contains(name) {
                    return Err(wrong(format!("the column \"{name}\" comes twice; leave one")));
                }
                puts.push((name.clone(), put));
            }
            continue;
        }
        if cells.len() != puts.len() {
            let (has, wants) = (cells.len(), puts.len());
            return Err(wrong(format!(
                "has {has} cells where the first line names {wants} columns; put cells with commas in quotes"
            )));
        }
        let mut line = Line { line: number, ..Line::default() };
        for ((name, put), cell) in puts.iter().zip(cells) {
            if !cell.is_empty() {
                put(&mut line, Cell::Text(&cell), folder).map_err(|e| wrong(within(name, &e)))?;
            }
        }
        complete(line).and_then(&mut *each).map_err(wrong)?;
    }
}

/// The cells of one row.
fn cells(row: &[u8]) -> Result<Vec<String>, String> {
    let text = std::str::from_utf8(row).map_err(|_| "is not UTF-8 text; save the table as UTF-8")?;
    let mut builder = csv::ReaderBuilder::new();
    builder.has_headers(false).flexible(true).trim(csv::Trim::All).buffer_capacity(row.len().max(16));
    let mut rows = builder.from_reader(text.as_bytes()).into_records();
    let first = rows.next().transpose().map_err(|e| format!("not a row of CSV: {e}"))?;
    // Quotes inside of a cell without quotes are odd in number.
    if rows.next().is_some() {
        return Err("a quote stands alone; put its cell in quotes and double it there".to_owned());
    }
    Ok(first.map_or(Vec::new(), |record| record.iter().map(str::to_owned).collect()))
}

fn complete(line: Line) -> Result<Line, String> {
    if line.model.as_os_str().is_empty() {
        return Err("names no model; give model, such as \"model\": \"a.stl\"".to_owned());
    }
    Ok(line)
}

fn column(name: &str) -> Result<Put, String> {
    let known = || COLUMNS.iter().map(|(n, _)| *n);
    COLUMNS.iter().find(|(n, _)| *n == name).map(|(_, put)| *put).ok_or_else(|| {
        let short: String = name.chars().take(60).flat_map(char::escape_debug).collect();
        match nearest_of(name, known(), '_') {
            Some(near) => format!("there is no column \"{short}\"; did you mean {near}?"),
            None => format!(
                "there is no column \"{short}\"; there are {}",
                known().collect::<Vec<_>>().join(", ")
            ),
        }
    })
}

/// Names the column, where the message does not yet.
fn within(column: &str, problem: &str) -> String {
    if problem.starts_with(column) { problem.to_owned() } else { format!("{column}: {problem}") }
}

/// What a parser of JSON says, in one line and without its own count of lines.
fn json_problem(error: &serde_json::Error) -> String {
    let text = error.to_string();
    let what = text.rsplit_once(" at line ").map_or(text.as_str(), |(what, _)| what);
    format!(
        "not JSON: {what} at character {}; write a job a line, such as {{\"model\": \"a.stl\"}}",
        error.column()
    )
}

fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

impl Cell<'_> {
    fn text(self) -> Result<String, String> {
        match self {
            Self::Text(text) => Ok(text.to_owned()),
            Self::Json(Value::String(text)) => Ok(text.clone()),
            Self::Json(other) => Err(format!("{} is not a text in quotes", short(other))),
        }
    }

    /// A text, or a number or flag as text.
    fn plain(self) -> Result<String, String> {
        match self {
            Self::Json(Value::Bool(flag)) => Ok(u8::from(*flag).to_string()),
            Self::Json(Value::Number(number)) => Ok(number.to_string()),
            other => other.text(),
        }
    }

    fn number(self, unit: &str, lowest: f64, highest: f64) -> Result<f64, String> {
        let text = self.plain()?;
        let value = text.parse::<f64>().ok().filter(|v| (lowest..=highest).contains(v));
        value.ok_or_else(|| {
            format!("\"{}\" is not a number from {lowest} to {highest} ({unit})", text.escape_debug())
        })
    }

    fn count(self) -> Result<u32, String> {
        let text = self.plain()?;
        let value = text.parse::<u32>().ok().filter(|v| (1..=1000).contains(v));
        value.ok_or_else(|| format!("\"{}\" is not a whole number from 1 to 1000", text.escape_debug()))
    }

    fn flag(self) -> Result<bool, String> {
        let text = self.plain()?;
        match text.to_ascii_lowercase().as_str() {
            "1" | "true" => Ok(true),
            "0" | "false" => Ok(false),
            _ => Err(format!("\"{}\" is neither true (1) nor false (0)", text.escape_debug())),
        }
    }

    fn technology(self) -> Result<Technology, String> {
        match self.text()?.as_str() {
            "filament" => Ok(Technology::Filament),
            "resin" => Ok(Technology::Resin),
            other => Err(format!("\"{}\" is neither filament nor resin", other.escape_debug())),
        }
    }

    fn orient(self) -> Result<String, String> {
        let text = self.text()?;
        let known = ["auto", "winding", "normals", "repair"].contains(&text.as_str());
        let wrong = || format!("\"{}\" is none of auto, winding, normals, repair", text.escape_debug());
        if known { Ok(text) } else { Err(wrong()) }
    }

    /// Sixty-four hexadecimal digits, as `sha256sum` prints them.
    fn sha256(self) -> Result<String, String> {
        let text = self.text()?.to_ascii_lowercase();
        let known = text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit());
        let wrong = || format!("\"{}\" is no SHA-256: 64 hexadecimal digits", text.escape_debug());
        if known { Ok(text) } else { Err(wrong()) }
    }

    /// One file, or several: an array in JSON, behind semicolons in CSV.
    fn files(self, folder: &Path) -> Result<Vec<PathBuf>, String> {
        match self {
            Self::Text(text) => {
                let names = text.split(';').map(str::trim).filter(|n| !n.is_empty());
                Ok(names.map(|n| folder.join(n)).collect())
            }
            Self::Json(Value::Array(names)) => {
                names.iter().map(|n| Ok(folder.join(Cell::Json(n).text()?))).collect()
            }
            other => Ok(vec![folder.join(other.text()?)]),
        }
    }

    fn settings(self) -> Result<BTreeMap<String, String>, String> {
        match self {
            Self::Json(Value::Object(object)) => object
                .iter()
                .filter(|(_, value)| !value.is_null())
                .map(|(key, value)| Ok((key.trim().to_owned(), Cell::Json(value).plain()?)))
                .collect(),
            Self::Text(text) => {
                let pairs = text.split(';').filter(|p| !p.trim().is_empty());
                let split = |pair: &str| match pair.split_once('=') {
                    Some((key, value)) => Ok((key.trim().to_owned(), value.trim().to_owned())),
                    None => Err(format!(
                        "\"{}\" is not of the form key=value; values with semicolons need a manifest of JSON lines",
                        pair.trim().escape_debug()
                    )),
                };
                pairs.map(split).collect()
            }
            Self::Json(other) => {
                Err(format!("{} is not an object such as {{\"layer_height\": 0.2}}", short(other)))
            }
        }
    }
}

/// A JSON value as part of a sentence.
fn short(value: &Value) -> String {
    let text = value.to_string();
    let head: String = text.chars().take(60).collect();
    if head.len() < text.len() { head + "..." } else { head }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn lines(name: &str, text: impl AsRef<[u8]>) -> Result<Vec<Line>, String> {
        let mut lines = Vec::new();
        let (path, text) = (Path::new(name), text.as_ref());
        let mut each = |line| {
            lines.push(line);
            Ok(())
        };
        let read =
            if name.ends_with("csv") { csv(path, text, &mut each) } else { json(path, text, &mut each) };
        read.map_err(|e| e.to_string())?;
        Ok(lines)
    }

    #[test]
    fn json_and_csv_say_the_same() {
        let json = r#"
{"model": "a.stl", "profile": "fine.ini", "settings": {"layer_height": 0.2, "fill_density": "15%", "cooling": true}, "output": "x/a.gcode", "copies": 3}
{"model": "/abs/b.stl", "profile": ["p/1.ini", "/p/2.toml"], "technology": "resin", "printer": "prusa-sl1s", "format": "SL1", "rotate": -12.5, "check": true}

{"model": "c.stl", "orient": "repair", "match_tolerance": 0.1, "snap_grid": 0.01, "no_place": true, "support_enforcers": ["e.stl"], "support_blockers": "f.stl", "printer": "own.toml", "copies": null}
"#;
        let csv = "\u{feff}model,profile,settings,output,copies,technology,printer,format,rotate,check,orient,match_tolerance,snap_grid,no_place,support_enforcers,support_blockers\n\
a.stl,fine.ini,layer_height=0.2; fill_density = 15% ;cooling=1,x/a.gcode,3,,,,,,,,,,,\r\n\
 /abs/b.stl ,p/1.ini; /p/2.toml,,,,resin,prusa-sl1s,sl1,-12.5,true,,,,,,\n\
,,,,,,,,,,,,,,,\n\
\"c.stl\",,,,,,own.toml,,,,repair,0.1,0.01,1,e.stl,f.stl\n";
        let mut a = lines("in/jobs.jsonl", json).unwrap();
        let mut b = lines("in/jobs.csv", csv).unwrap();
        assert_eq!(a.iter().map(|l| l.line).collect::<Vec<_>>(), [2, 3, 5]);
        assert_eq!(b.iter().map(|l| l.line).collect::<Vec<_>>(), [2, 3, 5]);
        a.iter_mut().chain(&mut b).for_each(|l| l.line = 0);
        assert_eq!(a, b);
        assert_eq!((a[0].model.to_str(), a[0].copies), (Some("in/a.stl"), Some(3)));
        assert_eq!(a[0].settings["cooling"], "1");
        assert_eq!(a[1].profile, ["in/p/1.ini", "/p/2.toml"].map(PathBuf::from));
        assert_eq!(a[1].printer.as_deref(), Some("prusa-sl1s"));
        assert_eq!((a[2].printer.as_deref(), a[2].no_place), (Some("in/own.toml"), Some(true)));
    }

    #[test]
    fn lines_that_cannot_be_understood_are_named() {
        for (text, message) in [
            (
                "{\"model\": \"a.stl\"}\n{\"modle\": \"b.stl\"}",
                "j.jsonl:2: there is no column \"modle\"; did you mean model?",
            ),
            (
                "{\"model\": \"a.stl\", \"colour\": 1}",
                "j.jsonl:1: there is no column \"colour\"; there are model, profile",
            ),
            ("\n\n[1]", "j.jsonl:3: not a JSON object"),
            ("{\"model\": \"a.stl\"", "j.jsonl:1: not JSON: EOF while parsing an object at character 17"),
            ("{\"copies\": 1}", "j.jsonl:1: names no model"),
            ("{\"model\": \"\"}", "j.jsonl:1: names no model"),
            ("{\"model\": 5}", "j.jsonl:1: model: 5 is not a text in quotes"),
            ("{\"model\": \"a\", \"copies\": 0}", "copies: \"0\" is not a whole number from 1 to 1000"),
            (
                "{\"model\": \"a\", \"output\": \"../x\"}",
                "j.jsonl:1: output \"../x\" has a part that begins with a dot",
            ),
            ("{\"model\": \"a\", \"settings\": \"x\"}", "settings: \"x\" is not an object"),
            ("{\"model\": \"a\", \"settings\": {\"a\": [1]}}", "settings: [1] is not a text"),
            (
                "{\"model\": \"a\", \"technology\": \"laser\"}",
                "technology: \"laser\" is neither filament nor resin",
            ),
            ("{\"model\": \"a\", \"format\": \"stl\"}", "format: no format has the extension"),
            ("{\"model\": \"a\", \"orient\": \"up\"}", "orient: \"up\" is none of"),
            ("{\"model\": \"a\", \"rotate\": \"north\"}", "rotate: \"north\" is not a number from"),
            ("{\"model\": \"a\", \"check\": \"yes\"}", "check: \"yes\" is neither true"),
            ("{\"model\": \"a\", \"sha256\": \"12ab\"}", "sha256: \"12ab\" is no SHA-256"),
        ] {
            let error = lines("j.jsonl", text).unwrap_err();
            assert!(error.contains(message) && error.lines().count() == 1, "{text}\n{error}");
        }
        for (text, message) in [
            ("model,copys\na.stl,1", "j.csv:1: there is no column \"copys\"; did you mean copies?"),
            ("model;copies\na.stl;1", "j.csv:1: there is no column \"model;copies\""),
            ("model,model\na,b", "j.csv:1: the column \"model\" comes twice"),
            ("model,copies\na.stl,1\nb.stl", "j.csv:3: has 1 cells where the first line names 2 columns"),
            ("model,copies\n\na.stl,many", "j.csv:3: copies: \"many\" is not"),
            ("model,copies\n,1", "j.csv:2: names no model"),
            ("model,output\n\"a\n.stl\",x\n5\" b.stl,\nc.stl,\n", "j.csv:4: a quote stands alone"),
            ("model\na.stl\r\n\r\n,b.stl\r\n", "j.csv:4: has 2 cells"),
            ("model,settings\na.stl,layer_height", "j.csv:2: settings: \"layer_height\" is not of the form"),
        ] {
            let error = lines("j.csv", text).unwrap_err();
            assert!(error.contains(message) && error.lines().count() == 1, "{text}\n{error}");
        }
        assert!(lines("j.csv", b"model\na\xff.stl").unwrap_err().contains("j.csv:2: is not UTF-8"));
        assert!(lines("j.jsonl", b"{\"model\": \"a\xff.stl\"}").unwrap_err().contains("j.jsonl:1: not JSON"));
        assert!(lines("j.csv", "").unwrap().is_empty() && lines("j.jsonl", "\n").unwrap().is_empty());
    }
}
