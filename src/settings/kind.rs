//! What a setting's value looks like and which values it may have.

use super::types::PrinterTechnology;
use std::fmt;

/// The stage a setting belongs to; its name heads a group of flags and a table of a TOML file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Planes and contours.
    Slicing,
    /// Line widths.
    Widths,
    /// Walls.
    Perimeters,
    /// Skins and infill.
    Infill,
    /// Supports.
    Support,
    /// Skirt, brim and raft.
    Adhesion,
    /// Feed rates.
    Speed,
    /// Retraction and travel.
    Retraction,
    /// Fan and slow-down.
    Cooling,
    /// The filament loaded.
    Filament,
    /// The machine.
    Printer,
    /// G-code text.
    Output,
    /// How long layers of resin are lit.
    Exposure,
    /// How the plate parts layers of resin from the film.
    Lift,
    /// How sections become pixels.
    Image,
    /// The panel.
    Display,
    /// The resin.
    Material,
}

/// Which jobs a setting is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Technology {
    /// Filament printers.
    Filament,
    /// Resin printers.
    Resin,
    /// All printers.
    Both,
}

impl Technology {
    /// Whether a job of that kind has the setting.
    pub const fn fits(self, technology: PrinterTechnology) -> bool {
        match self {
            Self::Filament => matches!(technology, PrinterTechnology::Fff),
            Self::Resin => matches!(technology, PrinterTechnology::Sla),
            Self::Both => true,
        }
    }
}

impl Stage {
    /// All stages, in the order of the pipeline, those of resin alone last.
    pub const ALL: [Self; 17] = [
        Self::Slicing,
        Self::Widths,
        Self::Perimeters,
        Self::Infill,
        Self::Support,
        Self::Adhesion,
        Self::Speed,
        Self::Retraction,
        Self::Cooling,
        Self::Filament,
        Self::Printer,
        Self::Output,
        Self::Exposure,
        Self::Lift,
        Self::Image,
        Self::Display,
        Self::Material,
    ];

    /// The stage's name as a TOML table, e.g. `slicing`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Slicing => "slicing",
            Self::Widths => "widths",
            Self::Perimeters => "perimeters",
            Self::Infill => "infill",
            Self::Support => "support",
            Self::Adhesion => "adhesion",
            Self::Speed => "speed",
            Self::Retraction => "retraction",
            Self::Cooling => "cooling",
            Self::Filament => "filament",
            Self::Printer => "printer",
            Self::Output => "output",
            Self::Exposure => "exposure",
            Self::Lift => "lift",
            Self::Image => "image",
            Self::Display => "display",
            Self::Material => "material",
        }
    }

    /// The stage's name as a heading, e.g. `Slicing settings`.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Slicing => "Slicing settings",
            Self::Widths => "Line width settings",
            Self::Perimeters => "Perimeter settings",
            Self::Infill => "Infill settings",
            Self::Support => "Support settings",
            Self::Adhesion => "Skirt, brim and raft settings",
            Self::Speed => "Speed settings",
            Self::Retraction => "Retraction settings",
            Self::Cooling => "Cooling settings",
            Self::Filament => "Filament settings",
            Self::Printer => "Printer settings",
            Self::Output => "Output settings",
            Self::Exposure => "Exposure settings",
            Self::Lift => "Lift settings",
            Self::Image => "Image settings",
            Self::Display => "Panel settings",
            Self::Material => "Resin settings",
        }
    }
}

/// The syntax of a value and its range, both ends included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// `0` or `1`.
    Flag,
    /// A whole number.
    Count(u32, u32),
    /// A whole number that may be negative.
    Integer(i32, i32),
    /// A number.
    Number(f64, f64),
    /// A percentage, `20%`; the sign may be left out.
    Percent(f64, f64),
    /// A number up to the second value, or a percentage `50%` up to the third.
    NumberOrPercent(f64, f64, f64),
    /// A length up to the second value, or pixels `2px` up to the third; negative ones too where the first is below 0.
    LengthOrPixels(f64, f64, f64),
    /// Text, C-escaped on one line (`\n` for a new line).
    Text,
    /// Points `0x0,200x0,...`, every coordinate within the range.
    Points(f64, f64),
    /// One of some names; the second list holds names PrusaSlicer knows and this crate does not yet.
    Choice(&'static [&'static str], &'static [&'static str]),
}

impl Kind {
    /// What may be written, with the unit, e.g. `a number (mm) from 0.01 to 10`.
    pub fn allowed(&self, unit: &str) -> String {
        let of = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
        match *self {
            Self::Flag => "0 or 1".to_owned(),
            Self::Count(min, max) => format!("a whole number{of} from {min} to {max}"),
            Self::Integer(min, max) => format!("a whole number{of} from {min} to {max}"),
            Self::Number(min, max) => format!("a number{of} from {min} to {max}"),
            Self::Percent(min, max) => format!("a percentage from {min}% to {max}%"),
            Self::NumberOrPercent(min, max, percent) => {
                format!("a number{of} from {min} to {max}, or a percentage up to {percent}%")
            }
            Self::LengthOrPixels(min, max, pixels) => {
                format!("a number{of} from {min} to {max}, or up to {pixels} pixels such as 2px")
            }
            Self::Text => "text on one line, \\n for a new line".to_owned(),
            Self::Points(min, max) => {
                format!("points such as 0x0,200x0,200x200{of}, coordinates from {min} to {max}")
            }
            Self::Choice(names, _) => names.join(", "),
        }
    }
}

/// The range in brief, for tables: `0.01..10`; empty where there is none.
impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Flag => write!(f, "0, 1"),
            Self::Count(min, max) => write!(f, "{min}..{max}"),
            Self::Integer(min, max) => write!(f, "{min}..{max}"),
            Self::Number(min, max) => write!(f, "{min}..{max}"),
            Self::Percent(min, max) => write!(f, "{min}%..{max}%"),
            Self::NumberOrPercent(min, max, percent) => write!(f, "{min}..{max} or ..{percent}%"),
            Self::LengthOrPixels(min, max, pixels) => write!(f, "{min}..{max} or ..{pixels}px"),
            Self::Text => Ok(()),
            Self::Points(min, max) => write!(f, "{min}..{max} each"),
            Self::Choice(names, _) => write!(f, "{}", names.join(", ")),
        }
    }
}
