//! Links and anchors run along walls, each stretch of which is used once.

use super::*;

/// Where a segment runs along an edge of the rings: ring, edge and the part of it \[nm\].
fn on_wall(a: Point2, b: Point2, rings: &[Vec<Point2>]) -> Option<(usize, usize, f64, f64)> {
    for (r, ring) in rings.iter().enumerate() {
        for e in 0..ring.len() {
            let (p, q) = (ring[e], ring[(e + 1) % ring.len()]);
            let long = p.distance(q);
            let at = |x: Point2| {
                let ((ux, uy), (vx, vy)) = (q.minus(p), x.minus(p));
                let along = (ux * vx + uy * vy) as f64 / long;
                let off = (ux * vy - uy * vx) as f64 / long;
                (off.abs() <= 3.0 && along > -3.0 && along < long + 3.0).then_some(along)
            };
            if let (Some(s), Some(t)) = (at(a), at(b))
                && (s - t).abs() > 20.0
            {
                return Some((r, e, s.min(t), s.max(t)));
            }
        }
    }
    None
}

/// All runs along walls, sorted; and the number of paths whose ends do so.
fn runs(paths: &[FillPath], island: &Island) -> (Vec<(usize, usize, f64, f64)>, usize) {
    let rings: Vec<Vec<Point2>> = island.infill.iter().flat_map(|e| e.rings().cloned()).collect();
    let mut found = Vec::new();
    let mut anchored = 0;
    for p in paths.iter().filter(|p| p.kind == FillKind::Sparse) {
        let own: Vec<_> = p.points.windows(2).map(|w| on_wall(w[0], w[1], &rings)).collect();
        anchored += usize::from(own[0].is_some()) + usize::from(own[own.len() - 1].is_some());
        found.extend(own.into_iter().flatten());
    }
    found.sort_by(|a, b| (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2)));
    (found, anchored)
}

/// How far runs overlap at most \[nm\].
fn overlap(runs: &[(usize, usize, f64, f64)]) -> f64 {
    let of = |w: &[(usize, usize, f64, f64)]| {
        if (w[0].0, w[0].1) == (w[1].0, w[1].1) { w[0].3 - w[1].2 } else { 0.0 }
    };
    runs.windows(2).map(of).fold(0.0, f64::max)
}

#[test]
fn no_stretch_of_wall_is_used_twice() {
    for pattern in ALL {
        let (mut count, mut anchored) = (0, 0);
        for seed in 1..4 {
            let (layers, plan) = random_job(seed, pattern);
            let fills = fill(&stack(&layers), &plan);
            for i in [4, 5, 6] {
                let (mut runs, ends) = runs(&fills[i][0], &layers[i][0]);
                let most = overlap(&runs);
                assert!(most < 20.0, "{pattern:?}, seed {seed}, layer {i}: {most} nm");
                count += runs.len();
                anchored += ends;
                // The check can fail.
                if let Some(&again) = runs.first() {
                    runs.insert(0, again);
                    assert!(overlap(&runs) >= 20.0);
                }
            }
        }
        match pattern {
            FillPattern::MonotonicLines => assert_eq!((count, anchored), (0, 0)),
            _ => assert!(count > 50 && anchored > 20, "{pattern:?}: {count} {anchored}"),
        }
    }
}

#[test]
fn without_links_and_anchors_lines_end_at_the_wall() {
    for pattern in ALL.into_iter().filter(|p| *p != FillPattern::ZigZag) {
        let layers = vec![vec![island(circle(0.0, 0.0, 17.0, 77), vec![square(1.0, 2.0, 5.0)])]; 9];
        let fills = fill(&stack(&layers), &FillPlan::new(&lines_of(pattern, 15.0)));
        assert!(runs(&fills[4][0], &layers[4][0]).0.is_empty(), "{pattern:?}");
        if pattern != FillPattern::Honeycomb {
            assert!(fills[4][0].iter().all(|p| p.points.len() == 2), "{pattern:?}");
        }
    }
}

#[test]
fn anchors_are_as_long_as_asked() {
    let layers = vec![vec![island(square(0.1, 0.2, 60.0), vec![])]; 9];
    let mut s = with(FillPattern::Line, 10.0);
    for anchor in [0.0, 1.5, 4.0] {
        s.infill.infill_anchor = Float(anchor);
        let fills = fill(&stack(&layers), &FillPlan::new(&s));
        let (runs, anchored) = runs(&fills[4][0], &layers[4][0]);
        if anchor == 0.0 {
            assert!(runs.is_empty());
            continue;
        }
        let whole = runs.iter().filter(|r| (r.3 - r.2 - anchor * 1e6).abs() < 10.0).count();
        // Lines' ends are 5.8 mm apart; around corners an anchor has two runs.
        assert!(anchored >= 2 * fills[4][0].len() - 2 && whole + 8 >= anchored, "{anchor}: {whole}");
        assert!(runs.iter().all(|r| r.3 - r.2 < anchor * 1e6 + 10.0));
    }
}
