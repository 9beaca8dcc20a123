//! What a job will take, from the size of its model and from the jobs before it.

use crate::slicer::{Outcome, Request, Technology};

/// What a job will take.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Claim {
    /// Time on one thread \[s\].
    pub seconds: f64,
    /// Memory \[bytes\].
    pub bytes: u64,
}

/// A facet in a binary file of STL \[bytes\].
const BINARY: u64 = 50;
/// A facet in a text of STL, about \[bytes\].
const TEXT: u64 = 250;

/// Memory of a worker without a model \[bytes\].
const BASE_BYTES: f64 = 25e6;
/// Time that a job takes in any case \[s\].
const BASE_SECONDS: f64 = 0.004;

/// Per triangle of a filament print: scans and scanned-like surfaces take a third of it, tall
/// prisms of thin triangles many times as much.
const FILAMENT: (f64, f64) = (1.5e-6, 120.0);
/// Per triangle of a resin print; the panel takes more than the triangles.
const RESIN: (f64, f64) = (1.0e-6, 120.0);
/// The panel of a resin print: time \[s\] and memory \[bytes\].
const PANEL: (f64, f64) = (0.5, 60e6);

/// Part of the time that is left where nothing is written.
const ESTIMATE_ONLY: f64 = 0.4;

/// How much a new outcome counts against all before it.
const WEIGHT: f64 = 0.1;

/// Foretells what jobs take, and learns from what they took.
#[derive(Clone, Debug)]
pub struct Estimator {
    /// By technology: what was taken over what was foretold, time and memory.
    scale: [(f64, f64); 2],
}

impl Default for Estimator {
    fn default() -> Self {
        Self { scale: [(1.0, 1.0); 2] }
    }
}

impl Estimator {
    /// What a job will take whose model is a file of this size \[bytes\], a text or binary.
    pub fn claim(&self, request: &Request, size: u64, text: bool) -> Claim {
        let (seconds, bytes) = first_guess(request, size, text);
        let (slower, larger) = self.scale[request.technology as usize];
        Claim { seconds: BASE_SECONDS + seconds * slower, bytes: (BASE_BYTES + bytes * larger) as u64 }
    }

    /// Learns from a job of that size. The outcome's memory tells something only where no job before it in
    /// the same process took more (`highest`).
    pub fn learn(&mut self, request: &Request, size: u64, text: bool, outcome: &Outcome, highest: bool) {
        let (seconds, bytes) = first_guess(request, size, text);
        let (slower, larger) = &mut self.scale[request.technology as usize];
        // Jobs of a few milliseconds say more about the machine than about models.
        if outcome.cpu_seconds > 0.02 {
            follow(slower, (outcome.cpu_seconds - BASE_SECONDS) / seconds.max(1e-3), (0.2, 20.0));
        }
        if highest && bytes > 0.1 * BASE_BYTES {
            follow(larger, (outcome.peak_bytes as f64 - BASE_BYTES) / bytes, (0.5, 8.0));
        }
    }
}

/// Moves a mean towards a new value.
fn follow(mean: &mut f64, value: f64, (low, high): (f64, f64)) {
    *mean += WEIGHT * (value.clamp(low, high) - *mean);
}

/// Time \[s\] and memory \[bytes\] over what every job takes.
fn first_guess(request: &Request, size: u64, text: bool) -> (f64, f64) {
    let triangles = (size / if text { TEXT } else { BINARY }) as f64;
    let copies = f64::from(request.copies.max(1));
    let (seconds, bytes) = match request.technology {
        Technology::Filament => (FILAMENT.0 * triangles * copies, FILAMENT.1 * triangles),
        Technology::Resin => (RESIN.0 * triangles * copies + PANEL.0, RESIN.1 * triangles * copies + PANEL.1),
    };
    (if request.estimate { seconds * ESTIMATE_ONLY } else { seconds }, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_models_claim_more() {
        let e = Estimator::default();
        let r = Request::default();
        let claims: Vec<Claim> =
            [684, 1_000_000, 50_000_084].iter().map(|size| e.claim(&r, *size, false)).collect();
        assert!(claims.is_sorted_by(|a, b| a.seconds < b.seconds && a.bytes < b.bytes), "{claims:?}");
        assert!(e.claim(&r, 1_000_000, true).seconds < claims[1].seconds);
        let resin = Request { technology: Technology::Resin, ..r };
        assert!(e.claim(&resin, 684, false).seconds > claims[0].seconds);
    }

    #[test]
    fn claims_follow_what_jobs_took() {
        let mut e = Estimator::default();
        let r = Request::default();
        let first = e.claim(&r, 50_000_084, false);
        let took = Outcome { cpu_seconds: 6.0, peak_bytes: 400_000_000, ..Outcome::default() };
        for _ in 0..60 {
            e.learn(&r, 50_000_084, false, &took, true);
        }
        let now = e.claim(&r, 50_000_084, false);
        assert!(first.seconds < 2.0 && (now.seconds - 6.0).abs() < 0.1, "{first:?} {now:?}");
        assert!(first.bytes < 200_000_000 && (now.bytes as f64 - 4e8).abs() < 1e7, "{first:?} {now:?}");
    }
}
