//! Every stage from the bytes of a model to its infill, on small generated bodies.
#![allow(missing_docs, clippy::unwrap_used)]

use criterion::{Criterion, criterion_group, criterion_main};
use microtome::contour::{self, TraceOptions};
use microtome::infill::{FillLayer, FillPlan, fill};
use microtome::mesh::{self, Adjacency, Mesh, shapes};
use microtome::region::perimeters::{Neighbours, WallPlan, walls};
use microtome::region::{Island, areas};
use microtome::settings::Settings;
use microtome::slice;
use microtome::slice::classic::{self, Algorithm};
use std::hint::black_box;
use std::path::Path;

fn bodies() -> [(&'static str, Mesh); 3] {
    [
        ("torus", shapes::torus(20.0, 6.0, 200, 100)),
        ("cylinder", shapes::cylinder(10.0, 30.0, 2_000)),
        ("part", mesh::demo_part()),
    ]
}

fn stages(criterion: &mut Criterion) {
    let settings = Settings::default();
    let options = TraceOptions::new(&settings.slicing);
    for (name, mesh) in bodies() {
        let mut group = criterion.benchmark_group(name);
        group.sample_size(20);

        let mut bytes = Vec::new();
        mesh::stl_write::write_stl_binary(&mesh, &mut bytes).unwrap();
        group.bench_function("parse+weld", |b| {
            b.iter(|| mesh::load_bytes(Path::new("memory.stl"), black_box(&bytes)).unwrap());
        });

        group.bench_function("adjacency", |b| b.iter(|| Adjacency::build(black_box(&mesh))));

        let adjacency = Adjacency::build(&mesh);
        let [low, high] = mesh.world_bounds().unwrap();
        let layers = slice::planes::layers(low[2], high[2], &settings.slicing).unwrap();
        let planes = slice::planes::plane_zs(&layers, mesh.origin[2]);
        group.bench_function("trace", |b| {
            b.iter(|| contour::trace(&mesh, &adjacency, black_box(&planes), &options).unwrap());
        });
        for algorithm in Algorithm::ALL {
            group.bench_function(format!("slice {algorithm}"), |b| {
                b.iter(|| classic::run(algorithm, &mesh, black_box(&planes)));
            });
        }

        let contours = contour::trace(&mesh, &adjacency, &planes, &options).unwrap();
        group.bench_function("areas", |b| {
            b.iter(|| contours.iter().map(|c| areas::areas(&c.rings)).collect::<Vec<_>>());
        });

        let plan = WallPlan::new(&settings, settings.slicing.layer_height, false);
        let areas: Vec<_> = contours.iter().map(|c| areas::areas(&c.rings)).collect();
        let islands = || {
            areas
                .iter()
                .map(|a| walls(a.clone(), &Neighbours::default(), &plan))
                .collect::<Vec<Vec<Island>>>()
        };
        group.bench_function("walls", |b| b.iter(islands));

        let islands = islands();
        let fill_layers: Vec<FillLayer<'_>> = islands
            .iter()
            .zip(&layers)
            .map(|(islands, z)| FillLayer { islands, print_z: z.print_z.into(), height: z.height.into() })
            .collect();
        let plan = FillPlan::new(&settings);
        group.bench_function("infill", |b| b.iter(|| fill(black_box(&fill_layers), &plan)));
        group.finish();
    }
}

criterion_group!(benches, stages);
criterion_main!(benches);
