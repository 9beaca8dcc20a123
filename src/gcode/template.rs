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

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn lookup(name: &str) -> Option<String> {
        let value = match name {
            "layer_height" => "0.2",
            "temperature" | "temperature[0]" => "210",
            "layer_num" => "7",
            "first_layer_print_min[0]" => "10.5",
            "first_layer_print_min[1]" => "20.5",
            "note" => "[not] {expanded}",
            "speed_2" => "fast",
            _ => return None,
        };
        Some(value.to_owned())
    }

    fn expanded(text: &str) -> Result<String, TemplateError> {
        expand("start_gcode", text, &lookup)
    }

    #[test]
    fn names_become_values() {
        for (text, value) in [
            ("", ""),
            ("G28 ; home\n", "G28 ; home\n"),
            ("M104 S[temperature]", "M104 S210"),
            ("M104 S{ temperature }|{temperature[0]}|[temperature_0]", "M104 S210|210|210"),
            ("[ layer_height ]{layer_height[0]}", "0.20.2"),
            ("X{first_layer_print_min[0]} Y{first_layer_print_min[ 1 ]}", "X10.5 Y20.5"),
            ("X[first_layer_print_min_0] Y[first_layer_print_min_1]", "X10.5 Y20.5"),
            ("[speed_2]", "fast"),
            ("; a ] and a } alone, layer [layer_num]", "; a ] and a } alone, layer 7"),
            ("[note]", "[not] {expanded}"),
            ("M117 größer {layer_num}\r\n", "M117 größer 7\r\n"),
        ] {
            assert_eq!(expanded(text).as_deref(), Ok(value), "{text}");
        }
    }

    #[test]
    fn anything_else_is_an_error_with_its_place() {
        let not_a_name = |expression: &str| TemplateError::NotAName {
            template: "start_gcode".to_owned(),
            line: 3,
            expression: expression.to_owned(),
        };
        for expression in [
            "{if layer_num > 0}",
            "{endif}",
            "{layer_num+1}",
            "{temperature[initial_tool]}",
            "[temperature[0]]",
            "[]",
            "{}",
            "{ }",
            "{-1}",
            "[7]",
            "{\"a\":1}",
            "{a b}",
            "{1 < 2}",
            "{[x]}",
            "{temperature[0][0]}",
            "{temperature[-1]}",
            "{größe}",
        ] {
            assert_eq!(
                expanded(&format!("G28\n; [layer_num]\nG1 {expression} X")),
                Err(not_a_name(expression))
            );
        }
        let error = expanded("G28\n; M117 [x]").unwrap_err();
        assert_eq!(error.to_string(), "start_gcode, line 2: \"[x]\" names no setting or value of this print");
        let error = expanded("\n\n{temperature[1]}").unwrap_err();
        assert!(matches!(error, TemplateError::Unknown { line: 3, .. }), "{error}");
        for text in ["[layer_num", "{", "{layer_num]", "[layer_num}", "{a[0}", "{a\n[0]\n"] {
            assert!(matches!(expanded(text), Err(TemplateError::Unclosed { line: 1, .. })), "{text}");
        }
    }

    #[test]
    fn an_expression_over_several_lines_is_reported_on_one() {
        let error = expanded("{if a\nthen b\nendif}").unwrap_err().to_string();
        assert_eq!(error.lines().count(), 1);
        assert!(error.contains("only plain names"), "{error}");
    }

    #[test]
    fn random_text_never_panics() {
        let alphabet: Vec<char> = "[]{}_0189aé \n\\;\"".chars().collect();
        for seed in 0..2000_u64 {
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let text: String = (0..30)
                .filter_map(|_| {
                    state ^= state << 13;
                    state ^= state >> 7;
                    state ^= state << 17;
                    alphabet.get((state % alphabet.len() as u64) as usize)
                })
                .collect();
            match expanded(&text) {
                Ok(out) => assert!(!out.contains('['), "seed {seed}: {text}"),
                Err(error) => assert_eq!(error.to_string().lines().count(), 1, "seed {seed}: {text}"),
            }
        }
    }
}
