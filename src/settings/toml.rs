//! Settings as TOML: the same keys, at the top or in tables named after the stages.
//!
//! Numbers, booleans and texts are TOML's own, so a G-code template is a multi-line text; points are
//! `[[0, 0], [200, 0], ...]` and lists per extruder `[0.4, 0.4]`. Any value may also be a text in
//! PrusaSlicer's syntax, such as `"20%"`.

use super::assign::{brief, quote};
use super::keys;
use super::kind::{Kind, Stage};
use super::load::{Entry, Malformed};
use super::value::escape;
use ::toml::Spanned;
use ::toml::de::{DeTable, DeValue};

/// The assignments of a TOML text, in the order of the file.
///
/// # Errors
/// Broken TOML, a table that is no stage, a value that cannot be a setting.
pub fn entries(text: &str) -> Result<Vec<Entry>, Malformed> {
    let starts: Vec<usize> = text.match_indices('\n').map(|(i, _)| i).collect();
    let line_of = |offset: usize| starts.partition_point(|s| *s < offset) + 1;
    let table = DeTable::parse(text).map_err(|e| Malformed {
        line: e.span().map_or(1, |s| line_of(s.start)),
        message: format!("is not TOML: {}", e.message().lines().collect::<Vec<_>>().join(", ")),
    })?;
    let mut found = Vec::new();
    for (key, value) in table.get_ref() {
        let Some(stage) = value.get_ref().as_table() else {
            found.push((key, value));
            continue;
        };
        let name = key.get_ref();
        if Stage::ALL.iter().all(|s| s.name() != name) {
            let names: Vec<_> = Stage::ALL.iter().map(|s| s.name()).collect();
            let message = format!("there is no table [{}]; tables: {}", brief(name), names.join(", "));
            return Err(Malformed { line: line_of(key.span().start), message });
        }
        found.extend(stage);
    }
    found.sort_by_key(|(key, _)| key.span().start);
    let entry = |(key, value): (&Spanned<std::borrow::Cow<'_, str>>, &Spanned<DeValue<'_>>)| {
        let (line, key) = (line_of(key.span().start), key.get_ref().to_string());
        match written(&key, value.get_ref()) {
            Some(value) => Ok(Entry { line, key, value }),
            None => Err(Malformed {
                line,
                message: format!(
                    "{} has a {} for its value, which no setting has",
                    brief(&key),
                    value.get_ref().type_str()
                ),
            }),
        }
    };
    found.into_iter().map(entry).collect()
}

/// The value in PrusaSlicer's syntax; `None` for a date or a table.
fn written(key: &str, value: &DeValue<'_>) -> Option<String> {
    let row = keys::find(key);
    Some(match value {
        DeValue::String(s) => match row {
            Some(row) if row.kind == Kind::Text && row.per_extruder => quote(s),
            Some(row) if row.kind == Kind::Text => escape(s),
            _ => s.to_string(),
        },
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(v) => v.to_string(),
            Err(_) => i.as_str().to_owned(),
        },
        DeValue::Float(f) => f.as_str().to_owned(),
        DeValue::Boolean(b) => u8::from(*b).to_string(),
        DeValue::Array(items) => {
            let points = row.is_some_and(|r| matches!(r.kind, Kind::Points(..)));
            let texts = row.is_some_and(|r| r.kind == Kind::Text);
            let item = |v: &Spanned<DeValue<'_>>| match v.get_ref() {
                DeValue::Array(pair) if points => {
                    let numbers: Option<Vec<_>> = pair.iter().map(|n| scalar(key, n.get_ref())).collect();
                    numbers.map(|n| n.join("x"))
                }
                v => scalar(key, v),
            };
            let items: Option<Vec<_>> = items.iter().map(item).collect();
            items?.join(if texts { ";" } else { "," })
        }
        DeValue::Datetime(_) | DeValue::Table(_) => return None,
    })
}

/// As [`written`], but no list within a list.
fn scalar(key: &str, value: &DeValue<'_>) -> Option<String> {
    if value.is_array() { None } else { written(key, value) }
}
