//! A bar chart of a report.

use super::report::Report;
use std::fmt::Write as _;

const WIDTH: f64 = 960.0;
const LABEL: f64 = 300.0;
const BAR: f64 = 16.0;
const COLORS: [&str; 8] =
    ["#1b6ca8", "#d1603d", "#4a8f4d", "#8a5aa8", "#b8952f", "#3f9a97", "#a84664", "#6b6b6b"];

/// The wall time of every stage as an SVG picture, a scale of its own for each model.
pub fn plot(report: &Report) -> String {
    let rows: usize = report.models.iter().map(|m| m.stages.len() + 3).sum();
    let height = BAR * (rows as f64 + 2.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" \
         font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
    );
    let mut y = BAR;
    let mut engines: Vec<&str> = Vec::new();
    for model in &report.models {
        y += BAR;
        // Writing to a String cannot fail.
        let _ = writeln!(
            svg,
            "<text x=\"8\" y=\"{y}\" font-weight=\"bold\">{}: {} triangles x {} planes, {} segments; wall time, ms</text>",
            escaped(&model.model),
            model.triangles,
            model.planes,
            model.segments
        );
        y += BAR * 0.5;
        let longest = model.stages.iter().map(|r| r.seconds).fold(1e-9, f64::max);
        for row in &model.stages {
            let color = engines.iter().position(|e| *e == row.engine).unwrap_or_else(|| {
                engines.push(&row.engine);
                engines.len() - 1
            });
            let width = (WIDTH - LABEL - 90.0) * row.seconds / longest;
            let text = y + 0.75 * BAR;
            let _ = writeln!(
                svg,
                "<text x=\"{}\" y=\"{text}\" text-anchor=\"end\">{} {} ({})</text>\
                 <rect x=\"{LABEL}\" y=\"{}\" width=\"{width:.2}\" height=\"{}\" fill=\"{}\"/>\
                 <text x=\"{:.2}\" y=\"{text}\">{:.2}</text>",
                LABEL - 6.0,
                escaped(&row.engine),
                row.stage,
                row.threads,
                y + 1.0,
                BAR - 3.0,
                COLORS[color % COLORS.len()],
                LABEL + width + 4.0,
                row.seconds * 1e3,
            );
            y += BAR;
        }
        y += BAR * 0.5;
    }
    svg.push_str("</svg>\n");
    svg
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
