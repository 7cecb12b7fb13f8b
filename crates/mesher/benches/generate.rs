//! Generation of a mesh around three spheres in a ball, at two element sizes, in tets per second.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use mesh::Vec3;
use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
use std::hint::black_box;

fn three_spheres(criterion: &mut Criterion) {
    let shapes = [-10.0, 0.0, 10.0].map(|x| Sphere {
        centre: Vec3::new(x, 0.0, 0.0),
        radius: 1.0,
    });
    let container = Container::Ball(Sphere::new(Vec3::zeros(), 40.0));
    let params = GenerateParams::default();
    let mut group = criterion.benchmark_group("three spheres");
    group.sample_size(10);
    for size in [0.4, 0.15] {
        let names = ["left", "middle", "right"];
        let bodies: Vec<MeshedBody<'_>> = names
            .iter()
            .zip(&shapes)
            .map(|(name, surface)| MeshedBody {
                name,
                surface,
                size,
            })
            .collect();
        let run = || generate(&bodies, &container, &params).expect("a valid scene");
        group.throughput(Throughput::Elements(run().mesh.tets.len() as u64));
        group.bench_function(format!("size {size}"), |b| b.iter(|| black_box(run())));
    }
    group.finish();
}

criterion_group!(benches, three_spheres);
criterion_main!(benches);
