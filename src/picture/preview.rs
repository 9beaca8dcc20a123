//! The part as it is shown on a printer's display: shaded, seen from above, the front and the right.
//!
//! Depth and shade of a pixel are one number and the greatest wins, so that the picture does not depend on
//! the order of triangles. Triangles between pixel centres, most of those of a fine mesh, cost a few
//! comparisons. Corners are rounded to 1/1024 of a pixel once; coverage is exact from there on, with no
//! gaps and no pixel drawn twice along common edges.

use crate::lattice::Point3;
use crate::mesh::Mesh;
use crate::resin::Preview;

/// Pixels are drawn this much finer in each direction and then averaged.
const SUPERSAMPLING: u32 = 2;

/// Fraction bits of picture coordinates.
const BITS: u32 = 10;

/// Greatest depth; a pixel keeps it in 24 bits, above 8 of shade.
const DEEPEST: f64 = ((1 << 24) - 3) as f64;

/// Longest side of a picture \[pixels\].
pub const LARGEST: u32 = 1 << 14;

/// Share of the picture that the part fills along the tighter direction.
const FILL: f64 = 0.9;

/// What is behind the part, at the top and at the bottom of the picture: dark, as displays of printers are.
pub const DARK: [[u8; 3]; 2] = [[66, 70, 78], [36, 38, 43]];

/// Colours of the part from darkest to brightest.
const COLORS: [[f64; 3]; 4] =
    [[34.0, 30.0, 44.0], [150.0, 78.0, 36.0], [246.0, 152.0, 62.0], [255.0, 240.0, 214.0]];

/// Draws a mesh, z up, scaled to fill the picture but for a margin. Facets that show their inner side are
/// drawn darker. Width and height are at most [`LARGEST`].
pub fn render(mesh: &Mesh, width: u32, height: u32) -> Preview {
    render_on(&[mesh], width, height, DARK)
}

/// Draws several meshes as they stand beside each other, before another background.
pub fn render_on(meshes: &[&Mesh], width: u32, height: u32, behind: [[u8; 3]; 2]) -> Preview {
    let (width, height) = (width.min(LARGEST), height.min(LARGEST));
    let size = [width * SUPERSAMPLING, height * SUPERSAMPLING];
    let mut canvas = Canvas { size, pixels: vec![0; size[0] as usize * size[1] as usize] };
    if let Some(view) = View::fit(meshes, size) {
        // The areas of a closed surface cancel out; then no inner side can be seen.
        if canvas.draw(meshes, &view, false) != 0 {
            canvas.draw(meshes, &view, true);
        }
    }
    Preview { width, height, rgb: canvas.colors(behind) }
}

/// A corner in the picture: x to the right and y up \[1/1024 pixel\], z towards the eye \[1/DEEPEST\].
#[derive(Clone, Copy, Debug)]
struct Corner {
    x: i32,
    y: i32,
    z: i32,
}

/// An isometric view: all three axes are equally long, z points up.
struct View {
    /// Picture units a step of each sum of [`axes`].
    scale: [f64; 3],
    /// Added afterwards.
    offset: [f64; 3],
    /// Length in the picture of a step of depth.
    depth_to_width: f64,
}

/// Sums of coordinates \[nm\] that are multiples of the view's axes: right `(x + y) / √2`, up
/// `(y - x + 2 z) / √6`, towards the eye `(x - y + z) / √3`.
fn axes(p: Point3, origin: [i64; 3]) -> [i64; 3] {
    let [x, y, z] = [i64::from(p.x) + origin[0], i64::from(p.y) + origin[1], i64::from(p.z) + origin[2]];
    [x + y, y - x + 2 * z, x - y + z]
}

impl View {
    /// The view that shows all of the meshes; `None` where there is nothing to show.
    fn fit(meshes: &[&Mesh], size: [u32; 2]) -> Option<Self> {
        let (mut lo, mut hi) = ([i64::MAX; 3], [i64::MIN; 3]);
        for mesh in meshes {
            for v in &mesh.vertices {
                let sums = axes(*v, mesh.origin);
                for ((lo, hi), s) in lo.iter_mut().zip(&mut hi).zip(sums) {
                    (*lo, *hi) = ((*lo).min(s), (*hi).max(s));
                }
            }
        }
        if lo[0] > hi[0] || size.contains(&0) {
            return None;
        }
        let length = [1.0 / 2f64.sqrt(), 1.0 / 6f64.sqrt(), 1.0 / 3f64.sqrt()];
        let range: [f64; 3] = std::array::from_fn(|i| ((hi[i] - lo[i]) as f64).max(1.0));
        let unit = f64::from(1u32 << BITS);
        let full = size.map(|s| f64::from(s) * unit);
        let per_nm = FILL * (full[0] / (range[0] * length[0])).min(full[1] / (range[1] * length[1]));
        let scale = [per_nm * length[0], per_nm * length[1], DEEPEST / range[2]];
        let middle = |i: usize| (lo[i] as f64 + hi[i] as f64) / 2.0;
        let offset = [
            full[0] / 2.0 - middle(0) * scale[0],
            full[1] / 2.0 - middle(1) * scale[1],
            2.0 - lo[2] as f64 * scale[2],
        ];
        Some(Self { scale, offset, depth_to_width: per_nm * length[2] / scale[2] })
    }

    #[inline]
    fn project(&self, p: Point3, origin: [i64; 3]) -> Corner {
        let sums = axes(p, origin);
        let [x, y, z] = std::array::from_fn(|i| (sums[i] as f64 * self.scale[i] + self.offset[i]) as i32);
        Corner { x, y, z }
    }
}

/// The picture, enlarged: per pixel depth << 8 | shade, 0 = nothing; the lowest row first.
struct Canvas {
    size: [u32; 2],
    pixels: Vec<u32>,
}

impl Canvas {
    /// Draws the facets that show their outer or their inner side; the sum of all areas as seen, with their
    /// signs, exact but for multiples of 2^64.
    fn draw(&mut self, meshes: &[&Mesh], view: &View, inner: bool) -> i64 {
        let mut sum = 0i64;
        let mut corners = Vec::new();
        for mesh in meshes {
            corners.clear();
            corners.extend(mesh.vertices.iter().map(|v| view.project(*v, mesh.origin)));
            for t in &mesh.triangles {
                let corner = |i: usize| corners.get(t[i] as usize).copied();
                let (Some(a), Some(b), Some(c)) = (corner(0), corner(1), corner(2)) else { continue };
                let p = [a, b, c];
                let area = cross(p[0], p[1], p[2].x, p[2].y);
                sum = sum.wrapping_add(area);
                if !inner && area > 0 {
                    self.triangle(p, view.depth_to_width, inner);
                } else if inner && area < 0 {
                    self.triangle([p[0], p[2], p[1]], view.depth_to_width, inner);
                }
            }
        }
        sum
    }

    /// Draws a triangle that is counter-clockwise in the picture.
    #[inline]
    fn triangle(&mut self, p: [Corner; 3], depth_to_width: f64, inner: bool) {
        // First and last column and row whose pixels' centres are within the bounds.
        let first = |a: i32, b: i32, c: i32| (a.min(b).min(c).max(0) + (1 << (BITS - 1)) - 1) >> BITS;
        let last = |a: i32, b: i32, c: i32, size: u32| {
            ((a.max(b).max(c) - (1 << (BITS - 1))) >> BITS).min(size as i32 - 1)
        };
        let (x0, x1) = (first(p[0].x, p[1].x, p[2].x), last(p[0].x, p[1].x, p[2].x, self.size[0]));
        let (y0, y1) = (first(p[0].y, p[1].y, p[2].y), last(p[0].y, p[1].y, p[2].y, self.size[1]));
        if x0 > x1 || y0 > y1 {
            return;
        }
        // A pixel is inside where all three are not negative; on an edge it belongs to the triangle to the
        // right of a left edge and below an upper one.
        let edges = [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])];
        let center = |i: i32| (i << BITS) + (1 << (BITS - 1));
        let start = edges.map(|(a, b)| {
            let owns = b.y < a.y || (b.y == a.y && b.x < a.x);
            cross(a, b, center(x0), center(y0)) - i64::from(!owns)
        });
        if x0 == x1 && y0 == y1 {
            // Most triangles of a fine mesh that meet a pixel at all meet one.
            if (start[0] | start[1] | start[2]) >= 0
                && let Some(pixel) = self.pixels.get_mut(y0 as usize * self.size[0] as usize + x0 as usize)
            {
                let plane = Plane::new(&p);
                let depth = plane.depth(center(x0), center(y0)).clamp(1.0, DEEPEST) as u32;
                if depth >= *pixel >> 8 {
                    *pixel = (*pixel).max(depth << 8 | u32::from(plane.shade(depth_to_width, inner)));
                }
            }
            return;
        }
        let along_x = edges.map(|(a, b)| -((i64::from(b.y) - i64::from(a.y)) << BITS));
        let along_y = edges.map(|(a, b)| (i64::from(b.x) - i64::from(a.x)) << BITS);
        let plane = Plane::new(&p);
        let shade = u32::from(plane.shade(depth_to_width, inner));
        // Steps of depth in 1/2^16; between two pixels of a triangle none is larger than the whole range.
        let step = (plane.slope[0] * f64::from(1 << BITS)).clamp(-DEEPEST, DEEPEST);
        let step = (step * 65536.0) as i64;
        let mut row = start;
        for y in y0..=y1 {
            if let Some((from, to)) = inside(row, along_x, x1 - x0) {
                let depth = plane.depth(center(x0 + from), center(y)).clamp(1.0, DEEPEST);
                let mut depth = (depth * 65536.0) as i64;
                let line = y as usize * self.size[0] as usize + x0 as usize;
                let pixels = self.pixels.get_mut(line + from as usize..=line + to as usize);
                for pixel in pixels.unwrap_or_default() {
                    *pixel = (*pixel).max(((depth >> 16) as u32) << 8 | shade);
                    depth += step;
                }
            }
            row = [row[0] + along_y[0], row[1] + along_y[1], row[2] + along_y[2]];
        }
    }

    /// Averages to the final size: red, green, blue from the top left.
    fn colors(&self, behind: [[u8; 3]; 2]) -> Vec<u8> {
        let [width, height] = self.size.map(|s| (s / SUPERSAMPLING) as usize);
        let table = color_table();
        let n = SUPERSAMPLING as usize;
        let mut rgb = Vec::with_capacity(3 * width * height);
        for y in 0..height {
            let share = |i: usize| {
                let [top, bottom] = [behind[0][i], behind[1][i]].map(usize::from);
                (top * (height - y) + bottom * y) / height
            };
            let empty = [share(0), share(1), share(2)].map(|c| c as u16);
            for x in 0..width {
                let mut sum = [0u16; 3];
                for dy in 0..n {
                    let line = (height * n - 1 - (y * n + dy)) * width * n + x * n;
                    for sample in &self.pixels[line..line + n] {
                        let color = if *sample == 0 { empty } else { table[(sample & 255) as usize] };
                        sum = [sum[0] + color[0], sum[1] + color[1], sum[2] + color[2]];
                    }
                }
                rgb.extend(sum.map(|s| (s / (SUPERSAMPLING * SUPERSAMPLING) as u16) as u8));
            }
        }
        rgb
    }
}

/// First and last `k` in `0..=most` where all three of `at + k * step` are not negative.
#[inline]
fn inside(at: [i64; 3], step: [i64; 3], most: i32) -> Option<(i32, i32)> {
    let (mut from, mut to) = (0, most);
    if most < 6 {
        // Quicker than three divisions.
        let within = |k: i32| {
            let k = i64::from(k);
            ((at[0] + k * step[0]) | (at[1] + k * step[1]) | (at[2] + k * step[2])) >= 0
        };
        while from <= to && !within(from) {
            from += 1;
        }
        while from < to && !within(to) {
            to -= 1;
        }
        return (from <= to).then_some((from, to));
    }
    for (at, step) in at.into_iter().zip(step) {
        if step == 0 {
            if at < 0 {
                return None;
            }
            continue;
        }
        // Exact: the quotient of numbers below 2^44 and 2^33 that is no whole number is further from one
        // than an f64 of its size is rounded.
        let zero = -(at as f64) / step as f64;
        let whole = zero as i32;
        if step > 0 {
            from = from.max(whole + i32::from(f64::from(whole) < zero));
        } else {
            to = to.min(whole - i32::from(f64::from(whole) > zero));
        }
    }
    (from <= to).then_some((from, to))
}

/// Twice the area of the triangle from `a` over `b` to (x, y); positive when counter-clockwise.
#[inline]
fn cross(a: Corner, b: Corner, x: i32, y: i32) -> i64 {
    let (dx, dy) = (i64::from(b.x) - i64::from(a.x), i64::from(b.y) - i64::from(a.y));
    dx * (i64::from(y) - i64::from(a.y)) - dy * (i64::from(x) - i64::from(a.x))
}

/// The plane of a triangle that is counter-clockwise in the picture.
struct Plane {
    normal: [f64; 3],
    at: Corner,
    /// Depth a step along x and y.
    slope: [f64; 2],
}

impl Plane {
    #[inline]
    fn new(p: &[Corner; 3]) -> Self {
        let edge = |to: Corner| {
            [
                f64::from(to.x) - f64::from(p[0].x),
                f64::from(to.y) - f64::from(p[0].y),
                f64::from(to.z - p[0].z),
            ]
        };
        let (u, v) = (edge(p[1]), edge(p[2]));
        let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let part = -1.0 / normal[2];
        Self { normal, at: p[0], slope: [normal[0] * part, normal[1] * part] }
    }

    #[inline]
    fn depth(&self, x: i32, y: i32) -> f64 {
        f64::from(self.at.z)
            + self.slope[0] * f64::from(x - self.at.x)
            + self.slope[1] * f64::from(y - self.at.y)
    }

    /// Brightness by Lambert's law: a main light from the upper left, a weak one from the right, light from
    /// all sides, and a little gloss.
    #[inline]
    fn shade(&self, depth_to_width: f64, inner: bool) -> u8 {
        let n = [self.normal[0] * depth_to_width, self.normal[1] * depth_to_width, self.normal[2]];
        let part = 1.0 / (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        let toward = |light: [f64; 3]| (n[0] * light[0] + n[1] * light[1] + n[2] * light[2]).max(0.0) * part;
        // Unit vectors.
        let (main, side, gloss) = ([-0.48, 0.64, 0.6], [0.8, 0.0, 0.6], [-0.268_328, 0.357_771, 0.894_427]);
        let shine = toward(gloss);
        let shine = shine * shine * shine * shine;
        let shine = shine * shine * shine * shine;
        let light = 0.2 + 0.58 * toward(main) + 0.14 * toward(side) + 0.16 * shine * shine;
        (255.0 * if inner { 0.4 * light } else { light }) as u8
    }
}

/// The colour of each shade.
fn color_table() -> Vec<[u16; 3]> {
    let parts = COLORS.len() - 1;
    let color = |shade: usize| {
        let at = shade as f64 / 255.0 * parts as f64;
        let part = (at as usize).min(parts - 1);
        let share = at - part as f64;
        std::array::from_fn(|i| {
            (COLORS[part][i] + (COLORS[part + 1][i] - COLORS[part][i]) * share).round() as u16
        })
    };
    (0..256).map(color).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::demo_part;

    /// A box from `lo` to `hi` \[mm\].
    fn block(lo: [i32; 3], hi: [i32; 3]) -> Mesh {
        let at = |i: usize, axis: usize| if i >> axis & 1 == 0 { lo[axis] } else { hi[axis] } * 1_000_000;
        let vertices = (0..8).map(|i| Point3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = sides.iter().flat_map(|s| [[s[0], s[1], s[2]], [s[0], s[2], s[3]]]).collect();
        Mesh { vertices, triangles, origin: [0; 3] }
    }

    fn at(picture: &Preview, x: u32, y: u32) -> [u8; 3] {
        let first = 3 * (y * picture.width + x) as usize;
        [picture.rgb[first], picture.rgb[first + 1], picture.rgb[first + 2]]
    }

    #[test]
    fn a_cube_shows_its_top_front_and_right_without_gaps() {
        let picture = render(&block([0; 3], [10; 3]), 100, 100);
        let [top, front, right] = [[50, 25], [30, 65], [70, 65]].map(|[x, y]| at(&picture, x, y));
        assert!(top > front && front > right, "{top:?} {front:?} {right:?}");
        // Every pixel of a face, and the seam between its triangles, has the face's colour.
        for (x, y) in (0..12).flat_map(|x| (0..12).map(move |y| (x, y))) {
            assert_eq!(at(&picture, 44 + x, 20 + y), top);
            assert_eq!(at(&picture, 24 + x, 60 + y), front);
            assert_eq!(at(&picture, 64 + x, 60 + y), right);
        }
        assert_eq!(at(&picture, 0, 0), DARK[0]);
    }

    #[test]
    fn the_picture_does_not_depend_on_the_order_of_triangles_nor_on_the_origin() {
        let mut mesh = demo_part();
        let picture = render(&mesh, 64, 48);
        assert_eq!(picture.rgb.len(), 3 * 64 * 48);
        mesh.triangles.reverse();
        for t in &mut mesh.triangles {
            t.rotate_left(1);
        }
        assert_eq!(render(&mesh, 64, 48), picture);
        mesh.origin = [mesh.origin[0] + 10_000_000, mesh.origin[1] - 7_000_000, mesh.origin[2]];
        let moved = render(&mesh, 64, 48);
        let differing = moved.rgb.iter().zip(&picture.rgb).filter(|(a, b)| a.abs_diff(**b) > 40).count();
        assert!(differing < 20, "{differing}");
        mesh.triangles.truncate(mesh.triangles.len() / 2);
        assert_ne!(render(&mesh, 64, 48), picture, "the comparison sees a missing half");
    }

    #[test]
    fn what_is_nearer_hides_what_is_behind() {
        let near = block([20, -20, 0], [30, -10, 10]);
        let far = block([0, 0, 0], [10, 10, 10]);
        let both = render_on(&[&far, &near], 80, 80, DARK);
        assert_eq!(both, render_on(&[&near, &far], 80, 80, DARK));
        assert_ne!(both, render(&near, 80, 80));
    }

    #[test]
    fn nothing_and_degenerate_meshes_are_background() {
        let empty = render(&Mesh::default(), 5, 4);
        assert_eq!((empty.width, empty.height, empty.rgb.len()), (5, 4, 60));
        assert!(render(&block([0; 3], [1; 3]), 0, 0).rgb.is_empty());
        let mut flat = block([0; 3], [0; 3]);
        assert_eq!(render(&flat, 5, 4), empty);
        flat.triangles.push([0, 1, 99]);
        assert_eq!(render(&flat, 5, 4).rgb.len(), 60, "a corner that is missing does no harm");
    }
}
