//! The kernels of an iteration, each with its throughput in dofs or bytes.

#[path = "../tests/suite/support/system/mod.rs"]
mod system;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use linalg::{
    BlockDiagonal, BlockTriangular, DirectParams, KrylovParams, LinearOperator, MassInverse,
    Multigrid, MultigridParams, Preconditioner, SaddleLdlt, Schwarz, SchwarzParams, fgmres, minres,
};

/// Bytes of a pass over a matrix with `nnz` values of `value` bytes, its columns, and vectors.
fn bytes(nnz: usize, value: usize, vector_entries: usize) -> Throughput {
    Throughput::Bytes((nnz * (value + 4) + 8 * vector_entries) as u64)
}

fn kernels(c: &mut Criterion) {
    for k in [3, 5] {
        let stokes = system::one_body(k);
        let (system, a) = (&stokes.system, stokes.system.velocity_block());
        let x: Vec<f64> = (0..system.cols()).map(|i| (i as f64).sin()).collect();
        let mut y = vec![0.0; x.len()];
        let mut group = c.benchmark_group(format!("{} dofs", x.len()));

        group.throughput(bytes(a.stiffness().nnz(), 8, 2 * a.rows()));
        let size = a.rows();
        group.bench_function("three components times K", |b| {
            b.iter(|| a.apply(&x[..size], &mut y[..size]));
        });

        let matrices = a.stiffness().nnz() * 12 + 2 * system.divergence().nnz() * 28;
        group.throughput(Throughput::Bytes((matrices + 16 * x.len()) as u64));
        group.bench_function("saddle-point operator", |b| {
            b.iter(|| system.apply(&x, &mut y))
        });

        let params = MultigridParams::default();
        let mut cycle =
            Multigrid::with_prolongation(a, &stokes.prolongation, None, &params).expect("set-up");
        group.throughput(Throughput::Elements(size as u64));
        group.bench_function("V-cycle", |b| {
            b.iter(|| cycle.apply(&x[..size], &mut y[..size]));
        });

        let mut block =
            BlockTriangular::with_prolongation(system, &stokes.prolongation).expect("set-up");
        group.throughput(Throughput::Elements(x.len() as u64));
        group.bench_function("block preconditioner", |b| {
            b.iter(|| block.apply(&x, &mut y))
        });

        let three = [&x[..]; 3];
        let mut products = vec![vec![0.0; x.len()]; 3];
        group.throughput(Throughput::Elements(3 * x.len() as u64));
        group.bench_function("saddle-point operator, three columns", |b| {
            let mut y: Vec<_> = products.iter_mut().map(Vec::as_mut_slice).collect();
            b.iter(|| system.apply_columns(&three, &mut y));
        });
        group.bench_function("block preconditioner, three columns", |b| {
            let mut y: Vec<_> = products.iter_mut().map(Vec::as_mut_slice).collect();
            b.iter(|| block.apply_columns(&three, &mut y));
        });

        group.throughput(Throughput::Elements(x.len() as u64));
        let mut diagonal =
            BlockDiagonal::with_prolongation(system, &stokes.prolongation).expect("set-up");
        group.bench_function("block-diagonal preconditioner", |b| {
            b.iter(|| diagonal.apply(&x, &mut y))
        });

        let mut schwarz = Schwarz::new(system, &SchwarzParams::default()).expect("set-up");
        group.bench_function("additive Schwarz, 8 subdomains", |b| {
            b.iter(|| schwarz.apply(&x, &mut y))
        });

        let np = system.pressure_range().len();
        let mut mass = MassInverse::new(system.pressure_mass(), 3).expect("a mass matrix");
        group.throughput(Throughput::Elements(np as u64));
        group.bench_function("mass matrix, three Chebyshev steps", |b| {
            b.iter(|| mass.apply(&x[..np], &mut y[..np]))
        });

        group.throughput(Throughput::Elements(x.len() as u64));
        group.sample_size(10);
        let forces = system::body_forces(system);
        let krylov = KrylovParams::default();
        group.bench_function("FGMRES to 1e-8", |b| {
            b.iter(|| {
                y.fill(0.0);
                fgmres(system, &mut block, &forces, &mut y, &krylov)
            })
        });
        group.bench_function("MINRES to 1e-8", |b| {
            b.iter(|| {
                y.fill(0.0);
                minres(system, &mut diagonal, &forces, &mut y, &krylov)
            })
        });
        group.bench_function("direct set-up", |b| {
            b.iter(|| SaddleLdlt::factor(system, &DirectParams::default()).map(|f| f.nnz()));
        });
        group.bench_function("multigrid set-up", |b| {
            b.iter(|| Multigrid::with_prolongation(a, &stokes.prolongation, None, &params));
        });
        group.finish();
    }
}

criterion_group!(benches, kernels);
criterion_main!(benches);
