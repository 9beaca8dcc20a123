//! Text → value → text, in PrusaSlicer's syntax.

use super::kind::Kind;
use super::types::{FloatOrPercent, GcodeFlavor, PrinterTechnology};
use super::types_part::{FillPattern, OnePerimeter, SeamPosition, VerticalShell};
use super::types_resin::{ContainerFormat, DisplayOrientation, LengthOrPixels};
use super::types_support::{BrimType, DraftShield, InterfacePattern, SupportPattern, SupportStyle};

/// Why a text is not a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Problem {
    /// What is wrong, as the rest of a sentence: "is not a number".
    Wrong(String),
    /// PrusaSlicer would take it; it is not supported here yet.
    NotYet,
}

impl From<&str> for Problem {
    fn from(what: &str) -> Self {
        Self::Wrong(what.to_owned())
    }
}

/// A type that settings are made of.
pub trait Value: Sized {
    /// Reads a text of the given syntax and range.
    ///
    /// # Errors
    /// [`Problem`] where the text has another syntax or the value is out of range.
    fn read(text: &str, kind: &Kind) -> Result<Self, Problem>;

    /// The text that `read` turns into the same value.
    fn write(&self, kind: &Kind) -> String;
}

/// Undoes [`escape`]: `\n` and `\r` are control characters, any other escaped character is itself.
///
/// # Errors
/// A text that ends in the middle of an escape.
pub fn unescape(text: &str) -> Result<String, Problem> {
    let mut out = String::with_capacity(text.len());
    let mut chars = text.chars();
    while let Some(c) = chars.next() {
        out.push(match c {
            '\\' => match chars.next() {
                Some('n') => '\n',
                Some('r') => '\r',
                Some(other) => other,
                None => return Err("ends in a lone backslash".into()),
            },
            c => c,
        });
    }
    Ok(out)
}

/// Text on one line, as PrusaSlicer stores it.
pub fn escape(text: &str) -> String {
    text.replace('\\', "\\\\").replace('\n', "\\n").replace('\r', "\\r")
}

fn finite(text: &str) -> Result<f64, Problem> {
    match text.trim().parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        Ok(_) => Err("is not a finite number".into()),
        Err(_) if text.trim().is_empty() => Err("is empty".into()),
        Err(_) => Err("is not a number".into()),
    }
}

fn within<T: PartialOrd>(v: T, min: T, max: T) -> Result<T, Problem> {
    if v < min {
        Err("is too small".into())
    } else if v > max {
        Err("is too large".into())
    } else {
        Ok(v)
    }
}

/// Shortest decimal text that reads back as the same number, without an exponent and without "-0".
fn decimal(v: f64) -> String {
    format!("{}", v + 0.0)
}

impl Value for bool {
    fn read(text: &str, _: &Kind) -> Result<Self, Problem> {
        match text {
            "1" | "true" => Ok(true),
            "0" | "false" => Ok(false),
            _ => Err("is neither 0 nor 1".into()),
        }
    }

    fn write(&self, _: &Kind) -> String {
        u8::from(*self).to_string()
    }
}

impl Value for u32 {
    fn read(text: &str, kind: &Kind) -> Result<Self, Problem> {
        let (min, max) = match *kind {
            Kind::Count(min, max) => (min, max),
            Kind::Choice(names, _) if !names.contains(&text) => return Err("is not a choice here".into()),
            _ => (Self::MIN, Self::MAX),
        };
        // Through f64, so that "-3" and "99999999999" are called out of range and not malformed.
        let v = finite(text)?;
        if v != v.trunc() {
            return Err("is not a whole number".into());
        }
        // In range, hence exact.
        Ok(within(v, f64::from(min), f64::from(max))? as Self)
    }

    fn write(&self, _: &Kind) -> String {
        self.to_string()
    }
}

impl Value for i32 {
    fn read(text: &str, kind: &Kind) -> Result<Self, Problem> {
        let (min, max) = match *kind {
            Kind::Integer(min, max) => (min, max),
            _ => (Self::MIN, Self::MAX),
        };
        let v = finite(text)?;
        if v != v.trunc() {
            return Err("is not a whole number".into());
        }
        Ok(within(v, f64::from(min), f64::from(max))? as Self)
    }

    fn write(&self, _: &Kind) -> String {
        self.to_string()
    }
}

impl Value for f64 {
    fn read(text: &str, kind: &Kind) -> Result<Self, Problem> {
        let (number, min, max) = match *kind {
            Kind::Percent(min, max) => (text.strip_suffix('%').unwrap_or(text), min, max),
            Kind::Number(min, max) => (text, min, max),
            _ => (text, Self::MIN, Self::MAX),
        };
        within(finite(number)?, min, max)
    }

    fn write(&self, kind: &Kind) -> String {
        decimal(*self) + if matches!(kind, Kind::Percent(..)) { "%" } else { "" }
    }
}

impl Value for FloatOrPercent {
    fn read(text: &str, kind: &Kind) -> Result<Self, Problem> {
        let (min, max, percent) = match *kind {
            Kind::NumberOrPercent(min, max, percent) => (min, max, percent),
            _ => (f64::MIN, f64::MAX, f64::MAX),
        };
        match text.strip_suffix('%') {
            // A least absolute value above 0 says that 0 % makes no sense either.
            Some(p) => Ok(Self::Percent(within(finite(p)?, if min > 0.0 { 1.0 } else { min }, percent)?)),
            None => Ok(Self::Float(within(finite(text)?, min, max)?)),
        }
    }

    fn write(&self, _: &Kind) -> String {
        match *self {
            Self::Float(v) => decimal(v),
            Self::Percent(p) => decimal(p) + "%",
        }
    }
}

impl Value for LengthOrPixels {
    fn read(text: &str, kind: &Kind) -> Result<Self, Problem> {
        let (min, max, pixels) = match *kind {
            Kind::LengthOrPixels(min, max, pixels) => (min, max, pixels),
            _ => (f64::MIN, f64::MAX, f64::MAX),
        };
        match text.strip_suffix("px") {
            Some(p) => {
                let least = if min < 0.0 { -pixels } else { 0.0 };
                Ok(Self::Pixels(within(finite(p)?, least, pixels)?))
            }
            None => Ok(Self::Length(within(finite(text)?, min, max)?)),
        }
    }

    fn write(&self, _: &Kind) -> String {
        match *self {
            Self::Length(v) => decimal(v),
            Self::Pixels(p) => decimal(p) + "px",
        }
    }
}

impl Value for String {
    fn read(text: &str, _: &Kind) -> Result<Self, Problem> {
        unescape(text)
    }

    fn write(&self, _: &Kind) -> String {
        escape(self)
    }
}

impl Value for Vec<[f64; 2]> {
    fn read(text: &str, kind: &Kind) -> Result<Self, Problem> {
        let (min, max) = match *kind {
            Kind::Points(min, max) => (min, max),
            _ => (f64::MIN, f64::MAX),
        };
        let coordinate = |t: &str| within(finite(t)?, min, max);
        let point = |t: &str| match t.split_once('x') {
            Some((x, y)) => Ok([coordinate(x)?, coordinate(y)?]),
            None => Err(Problem::from("is not a list of points")),
        };
        text.split(',').map(point).collect()
    }

    fn write(&self, _: &Kind) -> String {
        let points: Vec<_> = self.iter().map(|[x, y]| format!("{}x{}", decimal(*x), decimal(*y))).collect();
        points.join(",")
    }
}

/// Enums by name. A name missing here would be a compile error in `write`.
macro_rules! named {
    ($type:ident: $($variant:ident = $name:literal),*) => {
        impl Value for $type {
            fn read(text: &str, kind: &Kind) -> Result<Self, Problem> {
                match (text, kind) {
                    $(($name, _) => Ok(Self::$variant),)*
                    (name, Kind::Choice(_, later)) if later.contains(&name) => Err(Problem::NotYet),
                    _ => Err("is not a choice here".into()),
                }
            }

            fn write(&self, _: &Kind) -> String {
                match self {
                    $(Self::$variant => $name,)*
                }
                .to_owned()
            }
        }
    };
}

named!(SeamPosition: Random = "random", Nearest = "nearest", Aligned = "aligned", Rear = "rear");
named!(OnePerimeter: None = "none", Top = "top", Topmost = "topmost");
named!(FillPattern: Rectilinear = "rectilinear", Monotonic = "monotonic", MonotonicLines = "monotoniclines",
    AlignedRectilinear = "alignedrectilinear", Line = "line", ZigZag = "zigzag", Grid = "grid", Triangles = "triangles",
    Stars = "stars", Cubic = "cubic", Honeycomb = "honeycomb");
named!(SupportPattern: Rectilinear = "rectilinear", RectilinearGrid = "rectilinear-grid", Honeycomb = "honeycomb");
named!(InterfacePattern: Auto = "auto", Rectilinear = "rectilinear", Concentric = "concentric");
named!(BrimType: NoBrim = "no_brim", OuterOnly = "outer_only", InnerOnly = "inner_only",
    OuterAndInner = "outer_and_inner");
named!(GcodeFlavor: Reprap = "reprap", Reprapfirmware = "reprapfirmware", Marlin = "marlin", Marlin2 = "marlin2",
    Klipper = "klipper");

named!(DisplayOrientation: Landscape = "landscape", Portrait = "portrait");
named!(PrinterTechnology: Fff = "FFF", Sla = "SLA");

/// A flag up to PrusaSlicer 2.5, a choice since 2.6.
impl Value for VerticalShell {
    fn read(text: &str, _: &Kind) -> Result<Self, Problem> {
        match text {
            "disabled" | "0" => Ok(Self::Disabled),
            "partial" => Ok(Self::Partial),
            "enabled" | "1" => Ok(Self::Enabled),
            _ => Err("is not a choice here".into()),
        }
    }

    fn write(&self, _: &Kind) -> String {
        match self {
            Self::Disabled => "disabled",
            Self::Partial => "partial",
            Self::Enabled => "enabled",
        }
        .to_owned()
    }
}

/// PrusaSlicer's two kinds of tree are one here.
impl Value for SupportStyle {
    fn read(text: &str, _: &Kind) -> Result<Self, Problem> {
        match text {
            "grid" => Ok(Self::Grid),
            "snug" => Ok(Self::Snug),
            "organic" | "tree" => Ok(Self::Organic),
            _ => Err("is not a choice here".into()),
        }
    }

    fn write(&self, _: &Kind) -> String {
        match self {
            Self::Grid => "grid",
            Self::Snug => "snug",
            Self::Organic => "organic",
        }
        .to_owned()
    }
}

/// A flag up to PrusaSlicer 2.4, a choice since 2.5.
impl Value for DraftShield {
    fn read(text: &str, _: &Kind) -> Result<Self, Problem> {
        match text {
            "disabled" | "0" => Ok(Self::Disabled),
            "limited" => Ok(Self::Limited),
            "enabled" | "1" => Ok(Self::Enabled),
            _ => Err("is not a choice here".into()),
        }
    }

    fn write(&self, _: &Kind) -> String {
        match self {
            Self::Disabled => "disabled",
            Self::Limited => "limited",
            Self::Enabled => "enabled",
        }
        .to_owned()
    }
}

impl Value for ContainerFormat {
    fn read(text: &str, _: &Kind) -> Result<Self, Problem> {
        Self::named(text).ok_or_else(|| "is not a choice here".into())
    }

    fn write(&self, _: &Kind) -> String {
        self.name().to_owned()
    }
}
