//! The wall around the infill, as lines end on it: links and anchors run along it, and no stretch of it
//! is used twice.

use crate::lattice::Point2;

/// Where a line ends on the wall.
#[derive(Clone, Copy, Debug)]
pub struct Place {
    /// Index of the ring.
    pub ring: u32,
    /// Index of the edge's first vertex in the ring.
    pub edge: u32,
    /// Distance from that vertex \[nm\].
    pub along: f64,
    /// The end itself \[nm\].
    pub point: Point2,
}

impl Place {
    /// A point on an edge.
    pub fn new(rings: &[&[Point2]], ring: u32, edge: u32, point: Point2) -> Self {
        let from = rings[ring as usize][edge as usize];
        Self { ring, edge, along: from.distance(point), point }
    }
}

/// How lines hold on to the wall, lengths in nanometres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Anchors {
    /// The longest way along the wall from one line to another; 0 = lines are not linked.
    pub link: f64,
    /// Length along the wall of a line's end that is not linked; 0 = lines end at the wall.
    pub anchor: f64,
    /// What an anchor keeps clear of the next line's end or anchor.
    pub gap: f64,
}

/// Anchors shorter than this share of the gap are left out.
const SHORTEST: f64 = 0.5;

/// Rings with the places where lines end; a *stretch* is the way from one of them to the next, and has
/// the index of the place where it begins.
#[derive(Debug)]
pub struct Wall<'a> {
    rings: &'a [&'a [Point2]],
    /// Ring by ring, in walking order.
    places: Vec<Place>,
    /// Per ring its first place; the last entry is the total.
    first: Vec<u32>,
    /// What is used of each stretch at its beginning and at its end \[nm\].
    used: Vec<[f64; 2]>,
}

impl<'a> Wall<'a> {
    /// `places` go ring by ring in walking order.
    pub fn new(rings: &'a [&'a [Point2]], places: Vec<Place>) -> Self {
        let mut first = vec![0; rings.len() + 1];
        for p in &places {
            first[p.ring as usize + 1] += 1;
        }
        for r in 0..rings.len() {
            first[r + 1] += first[r];
        }
        Self { rings, used: vec![[0.0; 2]; places.len()], places, first }
    }

    /// The place after another on its ring.
    pub fn next(&self, i: u32) -> u32 {
        let ring = self.places[i as usize].ring as usize;
        if i + 1 < self.first[ring + 1] { i + 1 } else { self.first[ring] }
    }

    fn before(&self, i: u32) -> u32 {
        let ring = self.places[i as usize].ring as usize;
        if i > self.first[ring] { i - 1 } else { self.first[ring + 1] - 1 }
    }

    /// The ring's vertices on a stretch \[nm\] in walking order.
    pub fn vertices(&self, stretch: u32) -> impl DoubleEndedIterator<Item = Point2> + '_ {
        let to = self.next(stretch);
        let (a, b) = (self.places[stretch as usize], self.places[to as usize]);
        let ring = self.rings[a.ring as usize];
        let n = ring.len();
        let count = if to > stretch { b.edge - a.edge } else { b.edge + n as u32 - a.edge } as usize;
        (0..count).map(move |i| ring[(a.edge as usize + 1 + i) % n])
    }

    /// A stretch's length \[nm\], or any value above `limit` if that is less.
    pub fn length(&self, stretch: u32, limit: f64) -> f64 {
        let mut at = self.places[stretch as usize].point;
        let end = self.places[self.next(stretch) as usize].point;
        let mut length = 0.0;
        for p in self.vertices(stretch).chain([end]) {
            length += at.distance(p);
            at = p;
            if length > limit {
                break;
            }
        }
        length
    }

    /// True when `open` holds all along a stretch.
    pub fn is_open(&self, stretch: u32, open: &impl Open) -> bool {
        if open.is_all() {
            return true;
        }
        let mut at = self.places[stretch as usize].point;
        let end = self.places[self.next(stretch) as usize].point;
        self.vertices(stretch).chain([end]).all(|p| {
            let from = std::mem::replace(&mut at, p);
            open.reach(from, p) >= from.distance(p)
        })
    }

    /// Marks a stretch as used from one end to the other.
    pub fn take(&mut self, stretch: u32) {
        self.used[stretch as usize] = [f64::INFINITY; 2];
    }

    /// True for a stretch that a link uses.
    pub fn is_taken(&self, stretch: u32) -> bool {
        self.used[stretch as usize][0].is_infinite()
    }

    /// The way that a line which ends at a place goes on along the wall, on the side where it gets
    /// farther; marks it as used.
    pub fn anchor(&mut self, place: u32, rules: &Anchors, open: &impl Open) -> Vec<Point2> {
        if rules.anchor <= 0.0 {
            return Vec::new();
        }
        let [onwards, back] = [true, false].map(|onwards| self.walk(place, onwards, rules, open));
        let is_onwards = onwards.0 >= back.0;
        let (length, points) = if is_onwards { onwards } else { back };
        if length < SHORTEST * rules.gap {
            return Vec::new();
        }
        if is_onwards {
            self.used[place as usize][0] = length;
        } else {
            let stretch = self.before(place);
            self.used[stretch as usize][1] = length;
        }
        points
    }

    /// Length and points of an anchor in one direction.
    fn walk(&self, place: u32, onwards: bool, rules: &Anchors, open: &impl Open) -> (f64, Vec<Point2>) {
        let stretch = if onwards { place } else { self.before(place) };
        let used = self.used[stretch as usize];
        // Nothing is taken on this side but by a link, which takes all.
        let taken = used[0].max(used[1]) + rules.gap;
        if taken.is_infinite() {
            return (0.0, Vec::new());
        }
        let room = self.length(stretch, rules.anchor + taken) - taken;
        let mut rest = room.min(rules.anchor);
        if rest <= 0.0 {
            return (0.0, Vec::new());
        }
        let end = self.places[self.next(stretch) as usize].point;
        let begin = self.places[stretch as usize].point;
        let corners: Vec<Point2> = if onwards {
            self.vertices(stretch).chain([end]).collect()
        } else {
            self.vertices(stretch).rev().chain([begin]).collect()
        };
        let (mut at, mut length, mut points) = (self.places[place as usize].point, 0.0, Vec::new());
        for p in corners {
            let whole = at.distance(p);
            let step = open.reach(at, p).min(whole).min(rest);
            if step > 0.0 {
                points.push(if step < whole { at.toward(p, step / whole) } else { p });
                length += step;
                rest -= step;
            }
            if step < whole || rest <= 0.0 {
                break;
            }
            at = p;
        }
        (length, points)
    }
}

/// Which parts of the wall may be used.
pub trait Open {
    /// True when nothing is excluded.
    fn is_all(&self) -> bool;

    /// How far one may go from `a` towards `b` \[nm\].
    fn reach(&self, a: Point2, b: Point2) -> f64;
}

/// All of it.
#[derive(Clone, Copy, Debug)]
pub struct Everywhere;

impl Open for Everywhere {
    fn is_all(&self) -> bool {
        true
    }

    fn reach(&self, _: Point2, _: Point2) -> f64 {
        f64::INFINITY
    }
}
