//! What is said of a batch, in lines.

use crate::batch::event::{Event, Status, Totals};
use crate::batch::report::{count, duration, plain};
use crate::batch::tally::{Tally, verdict};
use std::path::Path;

/// What deserves a line at once: failures, and, unless only errors are wanted, further tries and lost workers.
pub(super) fn event(event: &Event<'_>, quiet: bool) -> Option<String> {
    match event {
        Event::Failed { name, failure, again: true, .. } if !quiet => {
            Some(format!("trying again: {}: {}", plain(name), plain(&failure.message)))
        }
        Event::Failed { name, failure, again: false, attempt, .. } => {
            let tries = if *attempt > 1 { format!(" (after {attempt} tries)") } else { String::new() };
            let what = match verdict(failure) {
                Status::Quarantined => "quarantined",
                Status::Done | Status::Failed => "failed",
            };
            Some(format!("{what}: {}: {}{tries}", plain(name), plain(&failure.message)))
        }
        Event::WorkerLost { worker, reason } if !quiet => {
            Some(format!("worker {} replaced: {}", worker + 1, plain(reason)))
        }
        Event::Warning { message } if !quiet => Some(format!("warning: {}", plain(message))),
        _ => None,
    }
}

/// Where it stands, in one line.
pub(super) fn status(tally: &Tally, now: f64) -> String {
    let mut line = format!("{} of {}", tally.ended(), count(tally.jobs, "model", "models"));
    line.push_str(&format!(", {}/min", rate(tally.models_per_minute(now))));
    if let Some(eta) = tally.eta(now) {
        line.push_str(&format!(", about {} left", duration(eta)));
    }
    let bad = tally.failed + tally.quarantined;
    if bad > 0 {
        line.push_str(&format!(", {bad} failed"));
    }
    line
}

/// What it came to.
pub(super) fn summary(tally: &Tally, totals: &Totals, page: &Path) -> String {
    let mut parts = vec![format!("{} done", totals.done)];
    let more = [
        (totals.skipped, "skipped (done earlier)"),
        (totals.failed, "failed"),
        (totals.quarantined, "quarantined"),
        (totals.left, "not reached"),
        (totals.elsewhere, "of other shards"),
    ];
    parts.extend(more.iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} {what}")));
    let minutes = totals.seconds / 60.0;
    let worked = if minutes > 0.0 { totals.done as f64 / minutes } else { 0.0 };
    let mut text =
        format!("{}\n{} at {} models/min", parts.join(", "), duration(totals.seconds), rate(worked));
    if tally.filament_mm > 0.0 {
        text.push_str(&format!("; filament {:.2} m", tally.filament_mm / 1000.0));
    }
    if tally.cm3 > 0.0 {
        text.push_str(&format!("{}{:.2} cm3", if tally.filament_mm > 0.0 { ", " } else { "; " }, tally.cm3));
    }
    if tally.g > 0.0 {
        text.push_str(&format!(", {:.2} g", tally.g));
    }
    if tally.cost > 0.0 {
        text.push_str(&format!(", price {:.2}", tally.cost));
    }
    if tally.with_warnings > 0 {
        text.push_str(&format!("; {} with warnings", count(tally.with_warnings, "model", "models")));
    }
    text.push_str(&format!("\nreport: {}\n", plain(&page.display().to_string())));
    if let Some(why) = &totals.stopped {
        text.push_str(&format!("stopped: {}; --resume goes on\n", plain(why)));
    }
    text
}

/// A rate with as many digits as mean something.
fn rate(value: f64) -> String {
    if value < 9.95 { format!("{value:.1}") } else { format!("{value:.0}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::FailureKind;
    use crate::slicer::Failure;

    #[test]
    fn a_failure_is_one_harmless_line() {
        let failure = Failure::new(FailureKind::Crashed, "died\nof \u{1b}[31mSIGKILL".to_owned());
        let news =
            |again| Event::Failed { name: "a\u{7}.gcode", size: 0, failure: &failure, attempt: 2, again };
        let line = event(&news(false), true).unwrap_or_default();
        assert_eq!(line, r"quarantined: a\u{7}.gcode: died\nof \u{1b}[31mSIGKILL (after 2 tries)");
        assert_eq!(event(&news(true), true), None);
        assert!(event(&news(true), false).is_some_and(|l| l.starts_with("trying again: ")));
    }

    #[test]
    fn the_summary_says_what_there_was() {
        let totals = Totals { done: 3, failed: 1, seconds: 1.5, ..Totals::default() };
        let mut tally = Tally::default();
        (tally.filament_mm, tally.cm3) = (1234.0, 2.5);
        let text = summary(&tally, &totals, Path::new("out/report.html"));
        assert_eq!(
            text,
            "3 done, 1 failed\n1.5s at 120 models/min; filament 1.23 m, 2.50 cm3\nreport: out/report.html\n"
        );
        let totals = Totals { left: 2, stopped: Some("no space".into()), ..totals };
        let text = summary(&tally, &totals, Path::new("r"));
        assert!(
            text.contains("2 not reached") && text.ends_with("stopped: no space; --resume goes on\n"),
            "{text}"
        );
    }

    #[test]
    fn the_status_has_what_is_known() {
        let mut tally = Tally::default();
        tally.event(&Event::Begun { jobs: 4, bytes: 0, workers: 1 }, 0.0);
        assert_eq!(status(&tally, 1.0), "0 of 4 models, 0.0/min");
        let failure = Failure::new(FailureKind::Model, String::new());
        tally.event(&Event::Failed { name: "a", size: 0, failure: &failure, attempt: 1, again: false }, 1.0);
        assert_eq!(status(&tally, 2.0), "1 of 4 models, 30/min, about 6.0s left, 1 failed");
    }
}
