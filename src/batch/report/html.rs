//! The report for people: one page that needs nothing else.

use super::escape::{Html, link};
use super::page::{SCRIPT, STYLE, policy};
use super::pictures::{Budget, Picture};
use super::words::{bytes, duration, figure, kind, shortened, status};
use super::{Job, Report};
use crate::batch::event::{Row, Status};
use crate::slicer::Outcome;
use std::io::{self, Write};

/// Jobs in the table; the page of a million would open nowhere.
pub(super) const MOST_ROWS: usize = 5000;
/// Failures listed.
pub(super) const MOST_FAILURES: usize = 1000;
/// Pictures inside the page, and the bytes of their files.
pub(super) const MOST_PICTURES: (usize, u64) = (300, 8 << 20);
/// Warnings listed of a job, and their length \[characters\].
const MOST_WARNINGS: (usize, usize) = (20, 600);
/// Length of an error \[characters\].
const LONGEST_ERROR: usize = 2000;

/// Writes it.
pub(super) fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let title = Html(&report.title);
    write!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>microtome batch: {title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header><h1>Batch report</h1>\n<p>{title}</p></header>\n<main>\n",
        policy()
    )?;
    for note in report.notes {
        writeln!(out, "<p class=\"note\">{}</p>", Html(note))?;
    }
    tiles(report, out)?;
    failures(report, out)?;
    table(report, out)?;
    write!(
        out,
        "</main>\n<footer>microtome {}. All figures with all digits: report.json, report.csv.</footer>\n\
         <script>{SCRIPT}</script>\n</body>\n</html>\n",
        env!("CARGO_PKG_VERSION")
    )
}

/// The sums.
fn tiles(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let (totals, sums) = (report.totals, &report.sums);
    let mut tiles: Vec<(&str, String, String, &str)> = Vec::new();
    let skipped = match totals.skipped {
        0 => String::new(),
        n => format!("{} by an earlier run", figure(n as f64, 0)),
    };
    tiles.push(("Done", figure(sums.done as f64, 0), skipped, if sums.done > 0 { "good" } else { "" }));
    if sums.failed > 0 || sums.quarantined == 0 {
        let class = if sums.failed > 0 { "bad" } else { "" };
        tiles.push(("Failed", figure(sums.failed as f64, 0), String::new(), class));
    }
    if sums.quarantined > 0 {
        let why = "crashed, broke a limit or kept failing".to_owned();
        tiles.push(("In quarantine", figure(sums.quarantined as f64, 0), why, "bad"));
    }
    if totals.left > 0 {
        tiles.push(("Not reached", figure(totals.left as f64, 0), "--resume goes on".to_owned(), "bad"));
    }
    if sums.with_warnings > 0 {
        tiles.push(("With warnings", figure(sums.with_warnings as f64, 0), String::new(), "fair"));
    }
    if sums.filament_mm > 0.0 {
        let volume = format!("{} cm³", figure(sums.volume_cm3, 1));
        tiles.push(("Filament", format!("{} m", figure(sums.filament_mm / 1000.0, 1)), volume, ""));
    } else {
        tiles.push(("Material", format!("{} ml", figure(sums.volume_cm3, 1)), String::new(), ""));
    }
    let of = |n: usize| {
        if n == sums.done { String::new() } else { format!("known for {n} of {} jobs", sums.done) }
    };
    if let Some(g) = sums.mass_g {
        tiles.push(("Mass", format!("{} kg", figure(g / 1000.0, 3)), of(sums.jobs_with_mass), ""));
    }
    if let Some(cost) = sums.cost {
        tiles.push(("Price of the material", figure(cost, 2), of(sums.jobs_with_cost), ""));
    }
    let bound = "lengths over speeds, no acceleration".to_owned();
    tiles.push(("Print time, at least", duration(sums.time_lower_bound_s), bound, ""));
    tiles.push(("Layers", figure(sums.layers as f64, 0), String::new(), ""));
    if totals.seconds > 0.0 {
        let cpu = format!("{} of CPU time", duration(sums.cpu_seconds));
        tiles.push(("Wall time", duration(totals.seconds), cpu, ""));
        // Where earlier runs did a part, this run's wall time says nothing about them.
        let fresh = if totals.skipped > 0 { totals.done } else { sums.done };
        let rate = fresh as f64 * 60.0 / totals.seconds;
        let decimals = usize::from(rate < 100.0);
        tiles.push(("Rate", format!("{} / min", figure(rate, decimals)), String::new(), ""));
    }
    if totals.peak_bytes > 0 {
        tiles.push(("Most memory", bytes(totals.peak_bytes), "all workers together".to_owned(), ""));
    }
    if totals.retries + totals.workers_lost > 0 {
        let lost = format!("{} workers lost", totals.workers_lost);
        tiles.push(("Further tries", figure(totals.retries as f64, 0), lost, "fair"));
    }
    writeln!(out, "<dl class=\"tiles\">")?;
    for (label, value, more, class) in tiles {
        write!(out, "<div class=\"{class}\"><dt>{label}</dt><dd>{value}")?;
        if !more.is_empty() {
            write!(out, "<small>{}</small>", Html(&more))?;
        }
        writeln!(out, "</dd></div>")?;
    }
    writeln!(out, "</dl>")
}

/// What went wrong comes first.
fn failures(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let all = report.sums.failed + report.sums.quarantined;
    if all == 0 {
        return Ok(());
    }
    writeln!(
        out,
        "<section class=\"failures\">\n<h2>Not done <span>{}</span></h2>\n<ul>",
        figure(all as f64, 0)
    )?;
    let failed = report.jobs.iter().map(|job| job.row).filter(|row| row.status != Status::Done);
    for row in failed.take(MOST_FAILURES) {
        failure(row, out)?;
    }
    writeln!(out, "</ul>")?;
    rest(all, MOST_FAILURES, out)?;
    writeln!(out, "</section>")
}

fn failure(row: &Row, out: &mut dyn Write) -> io::Result<()> {
    let (what, message) = match &row.failure {
        Some(failure) => (kind(failure.kind).replace('_', " "), failure.message.as_str()),
        None => (String::new(), "no reason is known"),
    };
    let tries = if row.attempts > 1 { format!(", {} tries", row.attempts) } else { String::new() };
    let name = shortened(&row.name, 300);
    writeln!(
        out,
        "<li><p><b>{}</b> <span class=\"{}\">{}</span> <small>{what}{tries}</small></p>\n<p>{}</p></li>",
        Html(&name),
        status(row.status),
        status(row.status),
        Html(&shortened(message, LONGEST_ERROR)),
    )
}

/// Columns: heading, whether it is a number.
const COLUMNS: [(&str, bool); 10] = [
    ("Layer", false),
    ("Job", false),
    ("Layers", true),
    ("Height", true),
    ("Filament", true),
    ("Volume", true),
    ("Price", true),
    ("Time, at least", true),
    ("Took", true),
    ("Warnings", true),
];

fn table(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    if report.sums.done == 0 {
        return Ok(());
    }
    writeln!(
        out,
        "<section>\n<h2>Done <span>{}</span></h2>\n\
         <p class=\"tools\" hidden><label>Find <input type=\"search\"></label> \
         <label class=\"sort\">Sort by <select></select></label></p>\n<table>\n<thead><tr>",
        figure(report.sums.done as f64, 0)
    )?;
    for (index, (heading, number)) in COLUMNS.iter().enumerate() {
        let class = if *number { " class=\"number\"" } else { "" };
        if index == 0 {
            write!(out, "<th{class}>{heading}</th>")?;
        } else {
            write!(out, "<th{class} aria-sort=\"none\"><button type=\"button\">{heading}</button></th>")?;
        }
    }
    writeln!(out, "</tr></thead>\n<tbody>")?;
    let mut budget = Budget { count: MOST_PICTURES.0, bytes: MOST_PICTURES.1 };
    let done = report.jobs.iter().filter_map(|job| {
        let outcome = job.row.outcome.as_ref()?;
        (job.row.status == Status::Done).then_some((job, outcome))
    });
    for (job, outcome) in done.take(MOST_ROWS) {
        row(report, job, outcome, &mut budget, out)?;
    }
    writeln!(out, "</tbody>\n</table>")?;
    rest(report.sums.done, MOST_ROWS, out)?;
    writeln!(out, "</section>")
}

fn row(
    report: &Report<'_>,
    job: &Job<'_>,
    outcome: &Outcome,
    budget: &mut Budget,
    out: &mut dyn Write,
) -> io::Result<()> {
    write!(out, "<tr><td class=\"picture\">")?;
    match budget.picture(job) {
        Some(Picture::Inside(source)) => {
            write!(out, "<img src=\"{source}\" alt=\"\" loading=\"lazy\" decoding=\"async\">")?;
        }
        Some(Picture::Beside(path)) => {
            if let Some(url) = link(report.folder, &path) {
                write!(out, "<a href=\"{url}\">picture</a>")?;
            }
        }
        None => {}
    }
    let name = shortened(&job.row.name, 300);
    let output = (outcome.bytes > 0).then(|| link(report.folder, &job.folder.join(job.name))).flatten();
    write!(out, "</td><td class=\"job\"><b>")?;
    match output {
        Some(url) => write!(out, "<a href=\"{url}\">{}</a>", Html(&name))?,
        None => write!(out, "{}", Html(&name))?,
    }
    write!(out, "</b><small>{}", Html(&shortened(&job.row.model, 300)))?;
    if job.row.copies > 1 {
        write!(out, ", {} copies", job.row.copies)?;
    }
    if job.row.attempts > 1 {
        write!(out, ", {} tries", job.row.attempts)?;
    }
    write!(out, "</small></td>")?;
    let material = &outcome.material;
    let filament =
        if material.mm > 0.0 { format!("{} m", figure(material.mm / 1000.0, 2)) } else { String::new() };
    let price = material.cost.map_or(String::new(), |cost| figure(cost, 2));
    let cells = [
        (outcome.layers as f64, figure(outcome.layers as f64, 0)),
        (outcome.print_z_mm, format!("{} mm", figure(outcome.print_z_mm, 2))),
        (material.mm, filament),
        (material.cm3, format!("{} cm³", figure(material.cm3, 2))),
        (material.cost.unwrap_or_default(), price),
        (outcome.time_lower_bound_s, duration(outcome.time_lower_bound_s)),
        (outcome.seconds, format!("{} s", figure(outcome.seconds, 2))),
    ];
    for ((heading, _), (value, text)) in COLUMNS[2..].iter().zip(cells) {
        write!(out, "<td class=\"number\" data-label=\"{heading}\" data-value=\"{value}\">{text}</td>")?;
    }
    let count = outcome.warnings.len();
    write!(out, "<td class=\"warnings\" data-value=\"{count}\">")?;
    if count > 0 {
        write!(out, "<details><summary>{count}</summary><ul>")?;
        for warning in outcome.warnings.iter().take(MOST_WARNINGS.0) {
            write!(out, "<li>{}</li>", Html(&shortened(warning, MOST_WARNINGS.1)))?;
        }
        if count > MOST_WARNINGS.0 {
            write!(out, "<li>and {} more, in report.json</li>", count - MOST_WARNINGS.0)?;
        }
        write!(out, "</ul></details>")?;
    }
    writeln!(out, "</td></tr>")
}

/// Says where what is not on the page can be found.
fn rest(all: usize, shown: usize, out: &mut dyn Write) -> io::Result<()> {
    if all <= shown {
        return Ok(());
    }
    let (first, more) = (figure(shown as f64, 0), figure((all - shown) as f64, 0));
    writeln!(
        out,
        "<p class=\"rest\">These are the first {first}; the other {more} are in report.csv and report.json.</p>"
    )
}
