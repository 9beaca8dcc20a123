//! What was counted while writing.

use crate::path::Role;
use crate::settings::FilamentSettings;
use std::f64::consts::PI;

/// Figures of a written file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Summary {
    /// Filament fed, net of retractions \[mm\].
    pub filament_mm: f64,
    /// The same as a volume \[cm³\].
    pub filament_cm3: f64,
    /// The same as a weight \[g\]; 0 when the density is unknown.
    pub filament_g: f64,
    /// Its price \[the unit of `filament_cost`\]; 0 when unknown.
    pub cost: f64,
    /// Filament by [`Role::index`] \[mm\].
    pub role_mm: [f64; Role::COUNT],
    /// Length of all extruded lines \[mm\].
    pub extruded_mm: f64,
    /// XY travel \[mm\].
    pub travel_mm: f64,
    /// Number of retractions.
    pub retractions: u64,
    /// Number of layers.
    pub layers: usize,
    /// Corner of the box of all extruded centre lines with the least coordinates, in the machine's
    /// frame \[mm\].
    pub low: [f64; 3],
    /// The opposite corner \[mm\].
    pub high: [f64; 3],
    /// Duration at full speed everywhere, without any acceleration: a lower bound \[s\].
    pub seconds_at_least: f64,
    /// Its part by [`Role::index`] \[s\].
    pub role_seconds: [f64; Role::COUNT],
    /// Its part of XY travel \[s\].
    pub travel_seconds: f64,
    /// Its part of moves of the filament alone \[s\].
    pub retraction_seconds: f64,
    /// Bytes written.
    pub bytes: u64,
}

impl Summary {
    /// Fills in what follows from `filament_mm`.
    pub(super) fn weigh(&mut self, filament: &FilamentSettings) {
        self.filament_cm3 = self.filament_mm * section(filament) / 1000.0;
        self.filament_g = self.filament_cm3 * filament.filament_density;
        self.cost = self.filament_g * filament.filament_cost / 1000.0;
    }

    /// The statistics at the end of the file, in PrusaSlicer's words.
    pub(super) fn comments(&self) -> String {
        let (mm, cm3, g, cost) = (self.filament_mm, self.filament_cm3, self.filament_g, self.cost);
        let mut text = format!("; filament used [mm] = {mm:.2}\n; filament used [cm3] = {cm3:.2}\n");
        if g > 0.0 {
            text += &format!("; filament used [g] = {g:.2}\n");
        }
        if cost > 0.0 {
            text += &format!("; filament cost = {cost:.2}\n");
        }
        text += &format!("; total filament used [g] = {g:.2}\n; total filament cost = {cost:.2}\n");
        text + &format!("; total layers count = {}\n", self.layers)
    }
}

/// Cross-section of the filament \[mm²\].
pub(super) fn section(filament: &FilamentSettings) -> f64 {
    PI / 4.0 * filament.filament_diameter * filament.filament_diameter
}
