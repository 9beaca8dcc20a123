//! Sums over the jobs of a report.

use crate::batch::event::{Row, Status};
use serde::Serialize;

/// What all jobs come to. An outcome covers all copies on its plate, so nothing is multiplied here.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Sums {
    /// Jobs.
    pub jobs: usize,
    /// Jobs done, in this run or earlier.
    pub done: usize,
    /// Jobs that failed.
    pub failed: usize,
    /// Jobs in quarantine.
    pub quarantined: usize,
    /// Jobs done with warnings.
    pub with_warnings: usize,
    /// Warnings.
    pub warnings: usize,
    /// Layers.
    pub layers: u64,
    /// Triangles.
    pub triangles: u64,
    /// Bytes of all outputs.
    pub bytes: u64,
    /// Length of filament \[mm\].
    pub filament_mm: f64,
    /// Volume \[cm³ = ml\].
    pub volume_cm3: f64,
    /// Mass of the jobs whose density is known \[g\]; absent where it is known of none.
    pub mass_g: Option<f64>,
    /// How many these are.
    pub jobs_with_mass: usize,
    /// Price of the jobs for which it is known.
    pub cost: Option<f64>,
    /// How many these are.
    pub jobs_with_cost: usize,
    /// Lower bound of the print time \[s\].
    pub time_lower_bound_s: f64,
    /// Wall time of all jobs one after the other \[s\].
    pub seconds: f64,
    /// CPU time \[s\].
    pub cpu_seconds: f64,
    /// The most memory that a worker held \[bytes\].
    pub peak_bytes: u64,
}

impl Sums {
    /// Adds up, in order, so that the same rows give the same sums to the last digit.
    pub fn of<'a>(rows: impl IntoIterator<Item = &'a Row>) -> Self {
        let mut sums = Self::default();
        for row in rows {
            sums.jobs += 1;
            *(match row.status {
                Status::Done => &mut sums.done,
                Status::Failed => &mut sums.failed,
                Status::Quarantined => &mut sums.quarantined,
            }) += 1;
            let Some(outcome) = &row.outcome else { continue };
            sums.with_warnings += usize::from(!outcome.warnings.is_empty());
            sums.warnings += outcome.warnings.len();
            sums.layers += outcome.layers;
            sums.triangles += outcome.triangles;
            sums.bytes += outcome.bytes;
            sums.filament_mm += outcome.material.mm;
            sums.volume_cm3 += outcome.material.cm3;
            if let Some(g) = outcome.material.g {
                *sums.mass_g.get_or_insert_default() += g;
                sums.jobs_with_mass += 1;
            }
            if let Some(cost) = outcome.material.cost {
                *sums.cost.get_or_insert_default() += cost;
                sums.jobs_with_cost += 1;
            }
            sums.time_lower_bound_s += outcome.time_lower_bound_s;
            sums.seconds += outcome.seconds;
            sums.cpu_seconds += outcome.cpu_seconds;
            sums.peak_bytes = sums.peak_bytes.max(outcome.peak_bytes);
        }
        sums
    }
}
