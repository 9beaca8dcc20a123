//! What becomes of a job that failed.

use crate::batch::event::Status;
use crate::batch::pool::{Death, Sentence};
use crate::job::FailureKind;
use crate::slicer::Failure;
use std::path::Path;

/// A panic that was caught is given one more try: it comes again, unless the memory was at fault.
const DEFECT_TRIES: u32 = 2;

/// What becomes of a job that failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// It is tried again.
    Again,
    /// That was all.
    Final(Status),
    /// Others would fail too: the batch stops, and the job is as if it had not been tried.
    Stop,
}

/// Judges the failure of try number `attempt`, counted from 1.
pub(super) fn verdict(failure: &Failure, attempt: u32, retries: u32) -> Verdict {
    use FailureKind as Kind;
    let tries = retries.saturating_add(1);
    let bound = |tries| if attempt < tries { Verdict::Again } else { Verdict::Final(Status::Quarantined) };
    match failure.kind {
        _ if failure.disk_full => Verdict::Stop,
        Kind::Defect => bound(tries.min(DEFECT_TRIES)),
        Kind::Crashed | Kind::TimeLimit | Kind::MemoryLimit | Kind::Cancelled => bound(tries),
        _ if failure.transient => bound(tries),
        Kind::Model | Kind::Settings | Kind::Device | Kind::Output => Verdict::Final(Status::Failed),
    }
}

/// The failure of the job that a worker had in hand when it died.
pub(super) fn failure_of(death: &Death, model: &Path, seconds: f64, bytes: u64) -> Failure {
    let model = model.display();
    match death.sentence {
        Some(Sentence::Time) => Failure::new(
            FailureKind::TimeLimit,
            format!(
                "{model}: took longer than {seconds} s; give it more with --job-time, or a simpler model"
            ),
        ),
        Some(Sentence::Memory | Sentence::Crowd) => Failure::new(
            FailureKind::MemoryLimit,
            format!(
                "{model}: took more than {} MiB of memory; give it more with --job-memory and --memory, or a simpler model",
                bytes >> 20
            ),
        ),
        None => Failure {
            transient: true,
            ..Failure::new(
                FailureKind::Crashed,
                format!(
                    "{model}: its worker {}; try it alone with `microtome slice`, and report a crash with the model",
                    death.reason
                ),
            )
        },
    }
}

/// The failure of a job that was in hand at the death of so many supervisors.
pub(super) fn deadly(model: &Path, deaths: u32) -> Failure {
    Failure::new(
        FailureKind::Crashed,
        format!(
            "{}: was in work each of the {deaths} times that the batch was killed or the machine went down; try it alone with `microtome slice`, or run again with --resume --retry-failed",
            model.display()
        ),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_may_pass_is_tried_again_and_what_will_not_is_not() {
        let of = |kind| Failure::new(kind, String::new());
        for kind in [FailureKind::Model, FailureKind::Settings, FailureKind::Output, FailureKind::Device] {
            assert_eq!(verdict(&of(kind), 1, 2), Verdict::Final(Status::Failed), "{kind:?}");
            let passing = Failure { transient: true, ..of(kind) };
            assert_eq!(verdict(&passing, 2, 2), Verdict::Again, "{kind:?}");
            assert_eq!(verdict(&passing, 3, 2), Verdict::Final(Status::Quarantined), "{kind:?}");
            let full = Failure { disk_full: true, ..passing };
            assert_eq!(verdict(&full, 9, 2), Verdict::Stop, "{kind:?}");
        }
        for kind in [FailureKind::Crashed, FailureKind::TimeLimit, FailureKind::MemoryLimit] {
            assert_eq!(verdict(&of(kind), 2, 2), Verdict::Again, "{kind:?}");
            assert_eq!(verdict(&of(kind), 3, 2), Verdict::Final(Status::Quarantined), "{kind:?}");
            assert_eq!(verdict(&of(kind), 1, 0), Verdict::Final(Status::Quarantined), "{kind:?}");
        }
        assert_eq!(verdict(&of(FailureKind::Defect), 1, 5), Verdict::Again);
        assert_eq!(verdict(&of(FailureKind::Defect), 2, 5), Verdict::Final(Status::Quarantined));
    }
}
