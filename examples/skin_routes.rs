//! Solid areas of a model by row spans and by the polygon library: the time and the area of either route.
//!
//! `cargo run --release --example skin_routes -- MODEL.stl [SETTINGS.ini]`. Runs on one thread. The area on
//! rows is taken from the solid lines that are laid, length times spacing, so it also holds the lines' links.
//! Skins are compared bare: without growth, without opening, without bridges.

use microtome::contour::{self, ExPolygon, TraceOptions};
use microtome::infill::{FillKind, FillLayer, FillPlan, fill};
use microtome::lattice::{self, area2};
use microtome::mesh::{self, Adjacency};
use microtome::region::{Island, areas, boolean, layers::all_walls, perimeters::WallPlan};
use microtome::settings::{Settings, load_file};
use microtome::slice::planes;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let model = words.first().ok_or("usage: skin_routes MODEL.stl [SETTINGS.ini]")?;
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut settings = Settings::default();
    if let Some(file) = words.get(1) {
        load_file(Path::new(file), &mut settings)?;
    }
    settings.infill.external_infill_margin = 0.0;
    settings.infill.solid_infill_below_area = 0.0;
    // Walls that reach further on slopes would differ between the routes' inputs.
    settings.perimeters.extra_perimeters = false;

    let mesh = mesh::load(Path::new(model))?.mesh;
    let adjacency = Adjacency::build(&mesh);
    let layers = planes::of_mesh(&mesh, &settings)?;
    let cuts = planes::plane_zs(&layers, mesh.origin[2]);
    let options = TraceOptions::new(&settings.slicing);
    let contours = contour::trace(&mesh, &adjacency, &cuts, &options)?;
    let outlines: Vec<Vec<ExPolygon>> = contours.iter().map(|c| areas::areas(&c.rings)).collect();
    let plans: Vec<WallPlan> =
        (0..).zip(&layers).map(|(i, z)| WallPlan::new(&settings, lattice::mm(z.height), i == 0)).collect();
    let begin = Instant::now();
    let islands = all_walls(outlines.clone(), &plans);
    println!("walls: {:.1} ms", 1e3 * begin.elapsed().as_secs_f64());

    let fill_layers: Vec<FillLayer<'_>> = islands
        .iter()
        .zip(&layers)
        .map(|(islands, z)| FillLayer { islands, print_z: z.print_z.into(), height: z.height.into() })
        .collect();
    let plan = FillPlan::new(&settings);
    let begin = Instant::now();
    let fills = fill(&fill_layers, &plan);
    let rows_ms = 1e3 * begin.elapsed().as_secs_f64();
    let spacing = |kind: FillKind| plan.spacing[kind as usize] / lattice::NM_PER_MM;
    let solid: f64 = fills
        .paths
        .iter()
        .flatten()
        .flatten()
        .filter(|f| f.kind != FillKind::Sparse)
        .map(|f| {
            f.points.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>() / lattice::NM_PER_MM
                * spacing(f.kind)
        })
        .sum();
    println!("rows, all infill laid: {rows_ms:.1} ms; solid lines cover {solid:.1} mm2");

    let (top, bottom) = (plan.top_layers as usize, plan.bottom_layers as usize);
    let begin = Instant::now();
    let by_polygons: f64 =
        (0..islands.len()).map(|i| area(&solid_area(i, &islands, &outlines, top, bottom))).sum();
    let polygons_ms = 1e3 * begin.elapsed().as_secs_f64();
    println!("polygons, solid areas alone: {polygons_ms:.1} ms; {by_polygons:.1} mm2");
    Ok(())
}

/// What of a layer's infill area is not covered by so many layers above and below.
fn solid_area(
    i: usize,
    islands: &[Vec<Island>],
    outlines: &[Vec<ExPolygon>],
    top: usize,
    bottom: usize,
) -> Vec<ExPolygon> {
    let own: Vec<ExPolygon> = islands[i].iter().flat_map(|island| island.infill.iter().cloned()).collect();
    if i + top >= outlines.len() || i < bottom {
        return own;
    }
    let mut covered = own.clone();
    for j in (i + 1..=i + top).chain(i - bottom..i) {
        covered = boolean::intersection(&covered, &outlines[j]);
    }
    boolean::difference(&own, &covered)
}

fn area(polygons: &[ExPolygon]) -> f64 {
    let sum: i128 = polygons.iter().flat_map(ExPolygon::rings).map(|r| area2(r)).sum();
    sum as f64 / 2.0 / (lattice::NM_PER_MM * lattice::NM_PER_MM)
}
