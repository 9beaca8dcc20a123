//! The settings of resin printers: one struct per stage.
//!
//! Names, units and meanings are PrusaSlicer's where it has them; the others are this crate's own.

use super::types::{PrinterTechnology, Settings};

/// A length along the plate: in millimetres (`0.05`), or in pixels of the panel (`2px`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LengthOrPixels {
    /// Millimetres.
    Length(f64),
    /// Pixels, each as long as the panel's pitch in the direction at hand.
    Pixels(f64),
}

impl LengthOrPixels {
    /// The length \[nm\] in a direction in which pixels are `pitch` \[nm\] apart.
    pub fn nm(self, pitch: i64) -> i64 {
        match self {
            Self::Length(mm) => crate::lattice::nm(mm),
            Self::Pixels(pixels) => (pixels * pitch as f64).round() as i64,
        }
    }
}

/// How long and how brightly layers are lit.
#[derive(Clone, Debug, PartialEq)]
pub struct ExposureSettings {
    /// Thickness of the first layer \[mm\]; 0 = `layer_height`.
    pub initial_layer_height: f64,
    /// Exposure of normal layers \[s\].
    pub exposure_time: f64,
    /// Exposure of bottom layers \[s\].
    pub initial_exposure_time: f64,
    /// Layers with the full `initial_exposure_time`.
    pub bottom_layers: u32,
    /// Layers behind them whose exposure falls linearly to the normal one.
    pub transition_layers: u32,
    /// PrusaSlicer's number of transition layers, behind three bottom layers; 0 = `bottom_layers` and
    /// `transition_layers` rule.
    pub faded_layers: u32,
    /// Light of normal layers, 0..=255.
    pub light: u32,
    /// Light of bottom layers, 0..=255.
    pub bottom_light: u32,
}

impl ExposureSettings {
    /// Bottom layers and transition layers in force: `faded_layers` above 0 means PrusaSlicer's three
    /// bottom layers with so many transition layers behind them.
    pub fn bottom_and_transition(&self) -> (u32, u32) {
        match self.faded_layers {
            0 => (self.bottom_layers, self.transition_layers),
            faded => (3, faded),
        }
    }
}

impl Default for ExposureSettings {
    fn default() -> Self {
        Self {
            initial_layer_height: 0.0,
            exposure_time: 2.5,
            initial_exposure_time: 30.0,
            bottom_layers: 5,
            transition_layers: 0,
            faded_layers: 0,
            light: 255,
            bottom_light: 255,
        }
    }
}

/// How the plate parts a layer from the film. Lengths \[mm\], speeds \[mm/min\], times \[s\].
#[derive(Clone, Debug, PartialEq)]
pub struct LiftSettings {
    /// First stage of the lift.
    pub lift_height: f64,
    /// Its speed.
    pub lift_speed: f64,
    /// Second stage of the lift; 0 = none.
    pub lift_height2: f64,
    /// Its speed.
    pub lift_speed2: f64,
    /// Speed of the way back, or of its first stage.
    pub lift_retract_speed: f64,
    /// Length of the last stage of the way back; 0 = none.
    pub lift_retract_height2: f64,
    /// Its speed.
    pub lift_retract_speed2: f64,
    /// As `lift_height`, of bottom layers.
    pub bottom_lift_height: f64,
    /// As `lift_speed`, of bottom layers.
    pub bottom_lift_speed: f64,
    /// As `lift_height2`, of bottom layers.
    pub bottom_lift_height2: f64,
    /// As `lift_speed2`, of bottom layers.
    pub bottom_lift_speed2: f64,
    /// As `lift_retract_speed`, of bottom layers.
    pub bottom_lift_retract_speed: f64,
    /// As `lift_retract_height2`, of bottom layers.
    pub bottom_lift_retract_height2: f64,
    /// As `lift_retract_speed2`, of bottom layers.
    pub bottom_lift_retract_speed2: f64,
    /// Rest after the exposure.
    pub rest_before_lift: f64,
    /// Rest at the top.
    pub rest_after_lift: f64,
    /// Rest before the exposure.
    pub rest_after_retract: f64,
    /// As `rest_before_lift`, of bottom layers.
    pub bottom_rest_before_lift: f64,
    /// As `rest_after_lift`, of bottom layers.
    pub bottom_rest_after_lift: f64,
    /// As `rest_after_retract`, of bottom layers.
    pub bottom_rest_after_retract: f64,
    /// The vat tilts instead of the plate lifting.
    pub tilt: bool,
    /// Time of a tilt where the layer is small.
    pub fast_tilt_time: f64,
    /// Time of a tilt where it is large.
    pub slow_tilt_time: f64,
    /// Share of the panel \[%\] from which on a layer is large.
    pub area_fill: f64,
}

impl Default for LiftSettings {
    fn default() -> Self {
        Self {
            lift_height: 6.0,
            lift_speed: 65.0,
            lift_height2: 0.0,
            lift_speed2: 0.0,
            lift_retract_speed: 150.0,
            lift_retract_height2: 0.0,
            lift_retract_speed2: 0.0,
            bottom_lift_height: 6.0,
            bottom_lift_speed: 65.0,
            bottom_lift_height2: 0.0,
            bottom_lift_speed2: 0.0,
            bottom_lift_retract_speed: 150.0,
            bottom_lift_retract_height2: 0.0,
            bottom_lift_retract_speed2: 0.0,
            rest_before_lift: 0.0,
            rest_after_lift: 0.0,
            rest_after_retract: 0.0,
            bottom_rest_before_lift: 0.0,
            bottom_rest_after_lift: 0.0,
            bottom_rest_after_retract: 0.0,
            tilt: false,
            fast_tilt_time: 5.0,
            slow_tilt_time: 8.0,
            area_fill: 50.0,
        }
    }
}

/// How sections become pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageSettings {
    /// Sub-rows of a pixel: 1 (none), 2, 4, 8 or 16.
    pub anti_aliasing: u32,
    /// Greys that are neither black nor white are raised to this, 0..=255.
    pub minimum_grey: u32,
    /// Exponent of the grey curve: 1, as covered; 0, black and white at a half.
    pub gamma_correction: f64,
    /// Grows (+) or shrinks (-) every layer's outline.
    pub absolute_correction: LengthOrPixels,
    /// Factor on the model's x.
    pub relative_correction_x: f64,
    /// Factor on the model's y.
    pub relative_correction_y: f64,
    /// Factor on the model's z.
    pub relative_correction_z: f64,
    /// Layers over which that falls linearly to nothing.
    pub elefant_foot_compensation_layers: u32,
}

impl Default for ImageSettings {
    fn default() -> Self {
        Self {
            anti_aliasing: 1,
            minimum_grey: 0,
            gamma_correction: 1.0,
            absolute_correction: LengthOrPixels::Length(0.0),
            relative_correction_x: 1.0,
            relative_correction_y: 1.0,
            relative_correction_z: 1.0,
            elefant_foot_compensation_layers: 1,
        }
    }
}

/// The panel. It has no default: 0 means unknown.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DisplaySettings {
    /// Length of the lit area along its pixels x \[mm\].
    pub display_width: f64,
    /// Length of the lit area along its pixels y \[mm\].
    pub display_height: f64,
    /// Pixels along the plate's x.
    pub display_pixels_x: u32,
    /// Pixels along the plate's y.
    pub display_pixels_y: u32,
    /// How pixels are stored.
    pub display_orientation: DisplayOrientation,
    /// Left and right are exchanged.
    pub display_mirror_x: bool,
    /// Top and bottom are exchanged.
    pub display_mirror_y: bool,
}

/// How the pixels of a panel are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DisplayOrientation {
    /// Rows of the stored image run along the plate's x.
    #[default]
    Landscape,
    /// Rows of the stored image run along the plate's y.
    Portrait,
}

/// The resin.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialSettings {
    /// Name of the resin's profile.
    pub sla_material_settings_id: String,
    /// Kind of resin, e.g. `Tough`.
    pub material_type: String,
    /// Density \[g/ml\]; 0 = unknown.
    pub material_density: f64,
    /// Price of a bottle \[money\]; 0 = unknown.
    pub bottle_cost: f64,
    /// Content of a bottle \[ml\].
    pub bottle_volume: f64,
}

impl Default for MaterialSettings {
    fn default() -> Self {
        Self {
            sla_material_settings_id: String::new(),
            material_type: String::new(),
            material_density: 0.0,
            bottle_cost: 0.0,
            bottle_volume: 1000.0,
        }
    }
}

/// The machine's name and its files.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineSettings {
    /// Full name, such as `ELEGOO Saturn 3 Ultra`, as printers compare it.
    pub machine_name: String,
    /// The model's code, such as `SL1S`, which a Prusa compares.
    pub printer_model: String,
    /// The files that the machine reads.
    pub container: ContainerFormat,
    /// Version of a `.ctb` file: 3 or 4.
    pub ctb_version: u32,
    /// PrusaSlicer's name of the container.
    pub sla_archive_format: String,
}

impl Default for MachineSettings {
    fn default() -> Self {
        Self {
            machine_name: String::new(),
            printer_model: String::new(),
            container: ContainerFormat::ZIP,
            ctb_version: 3,
            sla_archive_format: "SL1".to_owned(),
        }
    }
}

impl Settings {
    /// The defaults of resin printers. The panel is unknown still: it comes from a preset
    /// ([`super::printers`]), a file or flags.
    pub fn resin() -> Self {
        Self::of(PrinterTechnology::Sla)
    }

    /// The defaults of a technology.
    pub fn of(technology: PrinterTechnology) -> Self {
        let mut settings = Self::default();
        settings.printer.printer_technology = technology;
        if technology == PrinterTechnology::Sla {
            settings.slicing.layer_height = 0.05;
        }
        settings
    }

    /// Thickness of the first layer of a resin print \[mm\].
    pub fn initial_height(&self) -> f64 {
        match self.exposure.initial_layer_height {
            0.0 => self.slicing.layer_height,
            height => height,
        }
    }

    /// The technology that these settings are for.
    pub fn technology(&self) -> PrinterTechnology {
        self.printer.printer_technology
    }
}

/// The files that a resin printer reads, by their extension; encrypted `.ctb` files have a name of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContainerFormat(&'static str);

/// All names of containers.
pub(super) const CONTAINERS: &[&str] = &[
    "zip",
    "svg",
    "sl1",
    "sl1s",
    "goo",
    "prz",
    "ctb",
    "encrypted-ctb",
    "nanodlp",
    "pw0",
    "pwx",
    "dlp",
    "pwmo",
    "pwms",
    "pwmx",
    "pmsq",
    "pwma",
    "pm3",
    "pm3m",
    "pwmb",
    "dl2p",
    "pmx2",
    "pm3r",
    "pm3n",
    "px6s",
    "pm5",
    "pm5s",
    "m5sp",
];

/// Those of them that are only known: encrypted, or of a version that is not documented well enough.
const NOT_WRITTEN: &[&str] = &["encrypted-ctb", "pm5s", "m5sp"];

impl ContainerFormat {
    /// A stack of pictures in a zip.
    pub const ZIP: Self = Self("zip");

    /// The container of that name, as the settings have it.
    pub fn named(name: &str) -> Option<Self> {
        CONTAINERS.iter().find(|n| **n == name).map(|n| Self(n))
    }

    /// Its name in the settings.
    pub const fn name(self) -> &'static str {
        self.0
    }

    /// The extension of its files, without the dot.
    pub fn extension(self) -> &'static str {
        match self.0 {
            "encrypted-ctb" => "ctb",
            "svg" => "svg.zip",
            name => name,
        }
    }

    /// Whether files that the printer reads can be written.
    pub fn is_written(self) -> bool {
        !NOT_WRITTEN.contains(&self.0)
    }
}
