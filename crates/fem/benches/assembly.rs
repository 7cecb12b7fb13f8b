//! Cells per second of the symbolic phase, of the assembly and of the passes of the error estimate,
//! on affine and on curved meshes.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use fem::{CubicExtension, SurplusSpace, TaylorHood};
use mesh::{LinearTets, TetMesh, Vec3};

fn matrices(group: &mut BenchmarkGroup<WallTime>, mesh: &TetMesh) {
    let space = TaylorHood::new(mesh).expect("a mesh of moderate size");
    group
        .throughput(Throughput::Elements(mesh.n_cells() as u64))
        .sample_size(10);
    group.bench_function("patterns", |b| b.iter(|| TaylorHood::new(mesh)));
    group.bench_function("stiffness", |b| b.iter(|| space.stiffness(mesh)));
    group.bench_function("divergence", |b| b.iter(|| space.divergence(mesh)));
    group.bench_function("vertex_stiffness", |b| {
        b.iter(|| space.vertex_stiffness(mesh))
    });
    group.bench_function("pressure_mass", |b| b.iter(|| space.pressure_mass(mesh)));
    let bubbles = SurplusSpace::new(mesh).expect("a mesh of moderate size");
    let cubic = CubicExtension::new(&bubbles, mesh).expect("no inverted cell");
    let (velocity, pressure) = (
        vec![Vec3::x(); mesh.n_points()],
        vec![1.0; mesh.n_vertices()],
    );
    let extension = vec![1.0; cubic.len()];
    group.bench_function("cubic_product", |b| {
        b.iter(|| cubic.product(&velocity, &pressure, &extension))
    });
    group.bench_function("cubic_coarse_rows", |b| {
        b.iter(|| cubic.coarse_rows(&extension))
    });
    let mut rows = extension.clone();
    group.bench_function("cubic_gradient", |b| b.iter(|| cubic.gradient(&mut rows)));
}

fn assembly(c: &mut Criterion) {
    for n in [12, 24] {
        let affine = TetMesh::straight(LinearTets::cube(n)).expect("the unit cube");
        matrices(
            &mut c.benchmark_group(format!("affine_{}", affine.n_cells())),
            &affine,
        );
        // The shear x + 0.1 y^2 bends every cell slightly.
        let bent = affine
            .points()
            .iter()
            .map(|x| x + Vec3::x() * (0.1 * x.y * x.y))
            .collect();
        let curved = affine
            .with_points(bent)
            .expect("no cell is inverted by a shear");
        matrices(
            &mut c.benchmark_group(format!("curved_{}", curved.n_cells())),
            &curved,
        );
    }
}

criterion_group!(benches, assembly);
criterion_main!(benches);
