//! Custom G-code with placeholders: `[name]` and `{name}`.
//!
//! As in PrusaSlicer, `[` and `{` start a placeholder everywhere, in comments too, and cannot be escaped; a
//! `]` or `}` that closes nothing is plain text. PrusaSlicer's conditions and arithmetic are refused.

/// Why a template could not be expanded. One line each.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TemplateError {
    /// A bracket that never closes.
    #[error("{template}, line {line}: \"{text}\" is never closed; a [ or {{ starts a name, in comments too")]
    Unclosed {
        /// The setting that holds the template.
        template: String,
        /// Line of the opening bracket, from 1.
        line: usize,
        /// The beginning of what was opened.
        text: String,
    },
    /// An expression.
    #[error(
        "{template}, line {line}: \"{expression}\" is not supported; only plain names are, such as [layer_num], \
         {{layer_z}} or {{temperature[0]}}"
    )]
    NotAName {
        /// The setting that holds the template.
        template: String,
        /// Line of the opening bracket, from 1.
        line: usize,
        /// The placeholder, brackets included.
        expression: String,
    },
    /// A name that stands for nothing here.
    #[error("{template}, line {line}: \"{expression}\" names no setting or value of this print")]
    Unknown {
        /// The setting that holds the template.
        template: String,
        /// Line of the opening bracket, from 1.
        line: usize,
        /// The placeholder, brackets included.
        expression: String,
    },
}

/// Replaces every placeholder of `text` by its value.
///
/// `lookup` is asked for `name`, and for `name[0]` where the template says `{name[0]}` or `[name_0]` (the index
/// may be another number); where it has no answer for index 0, it is asked for `name` alone. Values are inserted as they are:
/// brackets within them start no placeholder.
///
/// # Errors
/// [`TemplateError`], naming `template_name`, the line and the placeholder.
pub fn expand(
    template_name: &str,
    text: &str,
    lookup: &dyn Fn(&str) -> Option<String>,
) -> Result<String, TemplateError> {
    let mut out = String::with_capacity(text.len());
    let (mut rest, mut line) = (text, 1);
    while let Some(open) = rest.find(['[', '{']) {
        let (plain, from) = rest.split_at(open);
        out.push_str(plain);
        line += newlines(plain);
        let template = || template_name.to_owned();
        let Some(length) = placeholder_length(from) else {
            return Err(TemplateError::Unclosed { template: template(), line, text: brief(from) });
        };
        let (expression, after) = from.split_at(length);
        let Some(names) = candidates(expression) else {
            return Err(TemplateError::NotAName {
                template: template(),
                line,
                expression: brief(expression),
            });
        };
        match names.iter().find_map(|n| lookup(n)) {
            Some(value) => out.push_str(&value),
            None => {
                return Err(TemplateError::Unknown {
                    template: template(),
                    line,
                    expression: brief(expression),
                });
            }
        }
        line += newlines(expression);
        rest = after;
    }
    out.push_str(rest);
    Ok(out)
}

/// Length of the placeholder at the start of `text`, up to the bracket that closes it; `None` if none does.
fn placeholder_length(text: &str) -> Option<usize> {
    let mut open = Vec::new();
    for (i, c) in text.char_indices() {
        match c {
            '[' => open.push(']'),
            '{' => open.push('}'),
            ']' | '}' if open.last() == Some(&c) => {
                open.pop();
                if open.is_empty() {
                    return Some(i + c.len_utf8());
                }
            }
            // Crossed brackets such as `{a]` close nothing.
            ']' | '}' => return None,
            _ => {}
        }
    }
    None
}

/// The names to look up for a placeholder, best first; `None` if it is not a plain name.
fn candidates(expression: &str) -> Option<Vec<String>> {
    let legacy = expression.starts_with('[');
    let inner = expression.get(1..expression.len() - 1)?.trim();
    if !legacy && let Some((name, index)) = inner.strip_suffix(']').and_then(|i| i.split_once('[')) {
        let (name, index) = (name.trim(), index.trim());
        return (is_name(name) && is_index(index)).then(|| indexed(name, index));
    }
    if !is_name(inner) {
        return None;
    }
    let mut names = vec![inner.to_owned()];
    if legacy && let Some((name, index)) = inner.rsplit_once('_').filter(|(n, i)| is_name(n) && is_index(i)) {
        names.extend(indexed(name, index));
    }
    Some(names)
}

fn indexed(name: &str, index: &str) -> Vec<String> {
    let mut names = vec![format!("{name}[{index}]")];
    if index == "0" {
        names.push(name.to_owned());
    }
    names
}

fn is_index(text: &str) -> bool {
    !text.is_empty() && text.len() < 4 && text.bytes().all(|b| b.is_ascii_digit())
}

fn is_name(text: &str) -> bool {
    text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_')
        && text.bytes().next().is_some_and(|b| !b.is_ascii_digit())
        // Words of PrusaSlicer's language that look like names.
        && !matches!(text, "if" | "else" | "elsif" | "endif" | "local" | "global" | "true" | "false" | "not")
}

fn newlines(text: &str) -> usize {
    text.bytes().filter(|b| *b == b'\n').count()
}

/// At most 60 characters on one line.
fn brief(text: &str) -> String {
    let short: String = text.chars().take(60).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(60).is_some() { short + "..." } else { short }
}
