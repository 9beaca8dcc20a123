//! What of an overhang holds itself as a bridge.

use super::carry::carry;
use crate::infill::Bridge;
use crate::span::algebra::{and, dilate, or, sub};
use crate::span::{RowFrame, Rows, RowsBuilder, Span};
use crate::support::SupportPlan;

/// The longest line over air that counts as a bridge \[nm\].
const LONGEST: f64 = 60e6;
/// The walls around a bridge reach so far beyond its infill \[widths of a wall\].
const WALLS: f64 = 3.0;
/// Room around a bridge for what its lines rest on \[nm\].
const ROOM: f64 = 5e6;

/// The part of `own` beyond `below` that the bridges `laid` by the infill, on the rows of the frame beside
/// them, and the walls around them span.
///
/// A bridge counts along those of its lines that rest on `below` at both ends, by half a wall at least, and
/// are over air for at most 60 mm. Walls count where they run straight along the bridge from one end to the
/// other; where a wall curves over air, it does not hold itself.
pub fn bridged(
    own: &Rows,
    below: &Rows,
    frame: &RowFrame,
    (laid, laid_on): (&[Bridge], &RowFrame),
    plan: &SupportPlan,
) -> Rows {
    let hanging = sub(own, below);
    if hanging.is_empty() {
        return hanging;
    }
    let span = |bridge: &Bridge| {
        let lines = lines(frame, bridge.degrees);
        let area = carry(&bridge.rows, laid_on, &lines);
        let around = Window::of(&bridge.rows, laid_on, frame, WALLS * 2.0 * plan.half_wall + ROOM);
        let [own, below] = [own, below].map(|rows| carry(&around.crop(rows), frame, &lines));
        let rules = Rules::new(&lines, laid_on, plan);
        carry(&rules.held(&own, &below, &area), &lines, frame)
    };
    let all =
        laid.iter().filter(|b| !b.rows.is_empty()).map(span).fold(Rows::default(), |all, one| or(&all, &one));
    // What has been carried over and back may lack half a row at its border.
    and(&hanging, &dilate(&all, 1, frame.pitch().min(1 << 30) as i32))
}

/// Rows in the direction of a bridge \[degrees\], as close as those of `frame`: its own where they run so.
fn lines(frame: &RowFrame, degrees: f64) -> RowFrame {
    let pitch = frame.pitch() as f64 / frame.scale();
    let turned = RowFrame::new(degrees, 0.0, pitch);
    let same = turned.st(PROBE) == frame.st(PROBE);
    if same { *frame } else { turned }
}

/// A point by whose coordinates two directions are told apart.
const PROBE: crate::lattice::Point2 = crate::lattice::Point2 { x: 1 << 29, y: 1 << 28 };

/// Lengths on the rows of a bridge's lines \[units\].
#[derive(Clone, Copy, Debug)]
struct Rules {
    /// A line rests on at least as much.
    rest: i64,
    longest: i64,
    /// Infill goes on over gaps up to this, which come from its own, wider rows.
    gap: i64,
    /// The walls' width, and in rows.
    walls: i64,
    wall_rows: u32,
}

impl Rules {
    fn new(lines: &RowFrame, laid_on: &RowFrame, plan: &SupportPlan) -> Self {
        let wall = 2.0 * plan.half_wall;
        let row = laid_on.pitch() as f64 / laid_on.scale();
        let walls = lines.units(WALLS * wall);
        Self {
            rest: lines.units(plan.half_wall).max(1),
            longest: lines.units(LONGEST),
            gap: lines.units(2.0 * row.max(plan.half_wall)),
            walls,
            wall_rows: (walls / lines.pitch()).clamp(0, 1000) as u32,
        }
    }

    /// What of `own` is held over air, on the rows of the bridge's lines. `area` is its infill.
    fn held(&self, own: &Rows, below: &Rows, area: &Rows) -> Rows {
        let zone = dilate(area, self.wall_rows, self.walls as i32);
        let mut out = RowsBuilder::new(own.first());
        for (k, row) in own.iter() {
            for whole in row.iter().filter(|_| !zone.row(k).is_empty()) {
                let mut last: Option<Span> = None;
                for rest in overlaps(*whole, below.row(k)).filter(|r| r.length() >= self.rest) {
                    if let Some(last) = last.replace(rest) {
                        let air = Span { start: last.end, end: rest.start };
                        self.line(air, area.row(k), zone.row(k), &mut out);
                    }
                }
            }
            out.end_row();
        }
        out.finish()
    }

    /// What holds itself of a stretch of a line between two supports.
    fn line(&self, air: Span, area: &[Span], zone: &[Span], out: &mut RowsBuilder) {
        if air.length() <= 0 || air.length() > self.longest {
            return;
        }
        let mut laid: Option<Span> = None;
        for mut s in overlaps(air, area) {
            if i64::from(s.start) - i64::from(air.start) <= self.gap {
                s.start = air.start;
            }
            if i64::from(air.end) - i64::from(s.end) <= self.gap {
                s.end = air.end;
            }
            match &mut laid {
                Some(last) if i64::from(s.start) - i64::from(last.end) <= self.gap => last.end = s.end,
                _ => {
                    if let Some(done) = laid.replace(s) {
                        out.push(done.start, done.end);
                    }
                }
            }
        }
        match laid {
            Some(last) => out.push(last.start, last.end),
            // Nothing but walls, from one end to the other.
            None if zone.iter().any(|z| z.start <= air.start && air.end <= z.end) => {
                out.push(air.start, air.end);
            }
            None => {}
        }
    }
}

/// What of a row lies within a span.
fn overlaps(within: Span, row: &[Span]) -> impl Iterator<Item = Span> {
    let first = row.partition_point(|r| r.end <= within.start);
    row[first..]
        .iter()
        .take_while(move |r| r.start < within.end)
        .map(move |r| Span { start: r.start.max(within.start), end: r.end.min(within.end) })
}

/// A rectangle along the rows of a frame.
#[derive(Clone, Copy, Debug)]
struct Window {
    s: Span,
    rows: [i32; 2],
}

impl Window {
    /// Around an area on the rows of another frame, with `room` \[nm\] on all sides.
    fn of(area: &Rows, on: &RowFrame, frame: &RowFrame, room: f64) -> Self {
        let (mut s, mut t) = ([i32::MAX, i32::MIN], [i64::MAX, i64::MIN]);
        for (k, row) in area.iter() {
            if let (Some(first), Some(last)) = (row.first(), row.last()) {
                for end in [first.start, last.end] {
                    let (x, y) = frame.st(on.xy(end, on.t(k)));
                    s = [s[0].min(x), s[1].max(x)];
                    t = [t[0].min(y.into()), t[1].max(y.into())];
                }
            }
        }
        let room = frame.units(room) + on.pitch();
        let by = room.min(1 << 30) as i32;
        Self {
            s: Span { start: s[0].saturating_sub(by), end: s[1].saturating_add(by) },
            rows: [frame.row_below(t[0] - room), frame.row_below(t[1] + room) + 1],
        }
    }

    fn crop(&self, area: &Rows) -> Rows {
        let (first, end) = (self.rows[0].max(area.first()), self.rows[1].min(area.end()));
        let mut out = RowsBuilder::new(first);
        for k in first..end {
            overlaps(self.s, area.row(k)).for_each(|s| out.push(s.start, s.end));
            out.end_row();
        }
        out.finish()
    }
}
