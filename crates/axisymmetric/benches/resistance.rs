//! Time of an axial resistance matrix, including the mesh and the error estimate.

use axisymmetric::{AxialSpheroid, Surroundings, axial_resistance};
use criterion::{Criterion, criterion_group, criterion_main};

fn resistance(c: &mut Criterion) {
    let three = [-10.0, 0.0, 10.0].map(|z| AxialSpheroid::sphere(z, 1.0));
    let ball = Surroundings::Ball { radius: 40.0 };
    let mut group = c.benchmark_group("axial_resistance");
    group.sample_size(10);
    for tolerance in [1e-4, 1e-6, 1e-8] {
        group.bench_function(format!("one_in_unbounded_{tolerance:e}"), |b| {
            b.iter(|| axial_resistance(&three[..1], Surroundings::Unbounded, tolerance))
        });
        group.bench_function(format!("three_in_ball_{tolerance:e}"), |b| {
            b.iter(|| axial_resistance(&three, ball, tolerance))
        });
    }
    group.finish();
}

criterion_group!(benches, resistance);
criterion_main!(benches);
