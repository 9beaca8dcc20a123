//! Failures that devices play, for trying out what follows from them.

use crate::gpu::{Fault, FaultKind};
use std::str::FromStr;

/// A failure that the next few devices play, each in its own life, which may span many jobs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FaultPlan {
    /// The failure.
    pub fault: Fault,
    /// How many devices, opened one after the other, play it.
    pub devices: u32,
}

impl FromStr for FaultPlan {
    type Err = String;

    /// `KIND@SUBMISSION` or `KIND@SUBMISSIONxDEVICES`, such as `lost@5` or `timeout@0x3`.
    fn from_str(text: &str) -> Result<Self, String> {
        let plan = || {
            let (kind, place) = text.split_once('@')?;
            let kind = match kind {
                "lost" => FaultKind::Lost,
                "timeout" => FaultKind::Timeout,
                "memory" => FaultKind::OutOfMemory,
                "validation" => FaultKind::Validation,
                _ => return None,
            };
            let (submission, devices) = place.split_once('x').unwrap_or((place, "1"));
            let fault = Fault { submission: submission.parse().ok()?, kind };
            Some(Self { fault, devices: devices.parse().ok()? })
        };
        plan().ok_or_else(|| {
            format!("`{text}` is no fault; give lost, timeout, memory or validation with @SUBMISSION or @SUBMISSIONxDEVICES")
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plans_are_read() {
        let plan = |submission, kind, devices| Ok(FaultPlan { fault: Fault { submission, kind }, devices });
        assert_eq!("lost@5".parse(), plan(5, FaultKind::Lost, 1));
        assert_eq!("timeout@0x3".parse(), plan(0, FaultKind::Timeout, 3));
        for wrong in ["", "lost", "lost@", "lost@-1", "lost@2x", "gone@1", "lost@1x2x3"] {
            assert!(wrong.parse::<FaultPlan>().is_err(), "{wrong}");
        }
    }
}
