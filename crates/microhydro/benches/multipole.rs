//! Times of whole resistance computations, by arrangement and tolerance.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use microhydro::{Accuracy, Medium, Spheres, multipole};
use nalgebra::Vector3;

fn arrangements() -> Vec<(&'static str, Spheres, Medium)> {
    let on_line = |x: &[f64]| {
        Spheres::new(
            x.iter().map(|&x| Vector3::new(x, 0.0, 0.0)).collect(),
            vec![1.0; x.len()],
        )
        .unwrap()
    };
    let planar = (0..3).map(|k| {
        let angle = f64::from(k) * std::f64::consts::TAU / 3.0;
        Vector3::new(angle.cos(), angle.sin(), 0.0) * 5.0
    });
    let lattice = (0..27)
        .map(|k| Vector3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)) * 4.0);
    let all = |centres: Vec<Vector3<f64>>| {
        let n = centres.len();
        Spheres::new(centres, vec![1.0; n]).unwrap()
    };
    let ball = Medium::Ball {
        centre: Vector3::zeros(),
        radius: 40.0,
    };
    vec![
        ("two", on_line(&[0.0, 3.0]), Medium::Unbounded),
        (
            "three_collinear",
            on_line(&[-10.0, 0.0, 6.0]),
            Medium::Unbounded,
        ),
        ("three_collinear_in_ball", on_line(&[-10.0, 0.0, 6.0]), ball),
        ("three_planar", all(planar.collect()), Medium::Unbounded),
        ("twenty_seven", all(lattice.collect()), Medium::Unbounded),
    ]
}

fn resistances(criterion: &mut Criterion) {
    for (name, spheres, medium) in arrangements() {
        let mut group = criterion.benchmark_group(name);
        group.sample_size(10);
        for tolerance in [1e-2, 1e-4, 1e-8] {
            let accuracy = Accuracy::relative(tolerance);
            group.bench_with_input(
                BenchmarkId::from_parameter(tolerance),
                &accuracy,
                |b, accuracy| {
                    b.iter(|| multipole::resistance(&spheres, &medium, accuracy));
                },
            );
        }
        group.finish();
    }
}

criterion_group!(benches, resistances);
criterion_main!(benches);
