//! Which extension belongs to which machine, and the file version written for it.

/// An extension of the family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Machine {
    /// The extension, lower case, without the dot.
    pub extension: &'static str,
    /// The machine's name as its own slicer writes it.
    pub name: &'static str,
    /// The file version that is written; `None` = files are only read.
    pub writes: Option<u32>,
    /// The highest file version that the machine takes.
    pub highest: u32,
}

const fn row(extension: &'static str, name: &'static str, writes: u32, highest: u32) -> Machine {
    Machine { extension, name, writes: if writes == 0 { None } else { Some(writes) }, highest }
}

/// All extensions. The highest versions are those that UVtools lists; of them the highest is written that
/// is known well enough.
pub const MACHINES: &[Machine] = &[
    // One bit a pixel, unlike all others.
    row("pws", "Photon S", 0, 1),
    row("pw0", "Photon Zero", 1, 1),
    row("pwx", "Photon X", 1, 1),
    row("dlp", "Photon Ultra", 516, 516),
    row("pwmo", "Photon Mono", 516, 516),
    row("pwms", "Photon Mono SE", 516, 516),
    row("pwmx", "Photon Mono X", 516, 516),
    row("pmsq", "Photon Mono SQ", 516, 516),
    row("pwma", "Photon Mono 4K", 516, 516),
    row("pm3", "Photon M3", 516, 516),
    row("pm3m", "Photon M3 Max", 516, 516),
    row("pwmb", "Photon Mono X 6K / M3 Plus", 516, 517),
    row("dl2p", "Photon D2", 516, 517),
    row("pmx2", "Photon Mono X2", 516, 517),
    row("pm3r", "Photon M3 Premium", 516, 517),
    row("pm3n", "Photon Mono 2", 517, 517),
    row("px6s", "Photon Mono X 6Ks", 517, 517),
    row("pm5", "Photon Mono M5", 517, 517),
    row("pm5s", "Photon Mono M5s", 0, 518),
    row("m5sp", "Photon Mono M5s Pro", 0, 518),
];

/// The machine of an extension (without the dot, in any case).
pub fn machine(extension: &str) -> Option<&'static Machine> {
    MACHINES.iter().find(|m| m.extension.eq_ignore_ascii_case(extension))
}
