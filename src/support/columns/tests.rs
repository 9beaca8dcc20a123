#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::columns;
use crate::infill::Level;
use crate::settings::{Settings, SupportStyle};
use crate::span::{Rows, RowsBuilder};
use crate::support::overhang::Overhang;
use crate::support::{Part, SupportLayer, SupportPlan};
use std::sync::Arc;

const MM: f64 = 1e6;

/// A part of boxes, each from one corner to the other \[mm\], in layers of 0.2 mm.
struct Boxes {
    outlines: Vec<Arc<Rows>>,
    levels: Vec<Level>,
    overhangs: Vec<Overhang>,
}

fn rectangle([x0, y0]: [f64; 2], [x1, y1]: [f64; 2], plan: &SupportPlan) -> Rows {
    let (first, end) =
        (plan.frame.row_below((y0 * MM) as i64) + 1, plan.frame.row_below((y1 * MM) as i64) + 1);
    let mut out = RowsBuilder::new(first);
    for _ in first..end {
        out.push((x0 * MM) as i32, (x1 * MM) as i32);
        out.end_row();
    }
    out.finish()
}

impl Boxes {
    fn new(boxes: &[[[f64; 3]; 2]], plan: &SupportPlan) -> Self {
        let height = boxes.iter().map(|b| b[1][2]).fold(0.0, f64::max);
        let layers = (height / 0.2).round() as usize;
        let mut part = Self { outlines: Vec::new(), levels: Vec::new(), overhangs: Vec::new() };
        for i in 0..layers {
            let middle = 0.2 * (i as f64 + 0.5);
            let own = boxes.iter().filter(|b| b[0][2] < middle && middle < b[1][2]);
            let outline = own.fold(Rows::default(), |all, [a, b]| {
                crate::span::algebra::or(&all, &rectangle([a[0], a[1]], [b[0], b[1]], plan))
            });
            let below = part.outlines.last();
            part.overhangs.push(Overhang {
                area: below.map_or(Rows::default(), |below| crate::span::algebra::sub(&outline, below)),
                ..Overhang::default()
            });
            let same = below.filter(|b| ***b == outline).cloned();
            part.outlines.push(same.unwrap_or_else(|| Arc::new(outline)));
            let bottom = i64::from(plan.base_z) + 200_000 * i as i64;
            part.levels.push(Level { top: bottom + 200_000, bottom });
        }
        part
    }

    fn columns(&self, plan: &SupportPlan) -> Vec<SupportLayer> {
        let part = Part { outlines: &self.outlines, levels: &self.levels, frame: &plan.frame };
        columns(part, &self.overhangs, plan)
    }
}

fn plan(style: SupportStyle) -> SupportPlan {
    let mut settings = Settings::default();
    settings.support.support_material_style = style;
    settings.slicing.layer_height = 0.2;
    SupportPlan::new(&settings)
}

/// A bar of 50 x 20 mm, 20 mm above the bed, upon a stem.
const TEE: [[[f64; 3]; 2]; 2] =
    [[[-4.7, -10.0, 0.0], [4.7, 10.0, 20.0]], [[-25.0, -10.0, 20.0], [25.0, 10.0, 22.0]]];

#[test]
fn columns_of_a_tee_end_a_thread_and_a_gap_below_its_bar() {
    for style in [SupportStyle::Grid, SupportStyle::Snug] {
        let plan = plan(style);
        let layers = Boxes::new(&TEE, &plan).columns(&plan);
        let top = layers.last().unwrap();
        assert_eq!(top.print_z, 20_000_000 - plan.top_gap - plan.thread_drop, "{style:?}");
        assert!(top.base.is_empty() && !top.contact.is_empty());
        assert_eq!(layers[0].bottom_z(), 0);
        assert!(layers.windows(2).all(|w| w[0].print_z == w[1].bottom_z()));
        assert_eq!(layers.iter().filter(|l| !l.interface.is_empty()).count(), 3);
    }
}
