//! Times of whole resistance computations, by arrangement and tolerance, and of products with the
//! mobility of thousands of spheres.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use microhydro::{Accuracy, Medium, Spheres, multipole, rpy};
use nalgebra::{DVector, Vector3};

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

/// Spheres of radius 1 at about three radii from each other, on a lattice that is pushed out of
/// order.
fn products(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("rpy_product");
    group.sample_size(10);
    for edge in [14_u32, 31, 67] {
        let place = |k: u32| Vector3::new(k % edge, k / edge % edge, k / edge.pow(2));
        let shifted = |k: u32| {
            let wave = f64::from(k) * Vector3::new(0.7, 1.3, 2.9);
            place(k).map(f64::from) * 3.0 + wave.map(f64::sin) * 0.4
        };
        let centres: Vec<_> = (0..edge.pow(3)).map(shifted).collect();
        let spheres = Spheres::new(centres, vec![1.0; edge.pow(3) as usize]).unwrap();
        let forces = DVector::from_fn(6 * spheres.len(), |row, _| (row as f64).sin());
        group.bench_function(BenchmarkId::from_parameter(spheres.len()), |b| {
            b.iter(|| rpy::apply(&spheres, &Medium::Unbounded, &forces));
        });
    }
    group.finish();
}

criterion_group!(benches, resistances, products);
criterion_main!(benches);
