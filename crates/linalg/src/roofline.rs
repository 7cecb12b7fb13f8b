//! The kernels of an iteration one by one, each with the bytes it has to move.

use crate::krylov::visit_basis_kernels;
use crate::vector::axpy;
use crate::{BlockTriangular, Csr3, LinearOperator, Preconditioner, SaddleSystem};

/// A kernel of the block solver and what it costs at least.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kernel {
    /// What it computes.
    pub name: &'static str,
    /// Bytes that have to be read or written once: matrices with their columns and row pointers, vectors. A cache line that is written over counts
    /// once, as it does in STREAM (McCalpin 1995).
    pub bytes: usize,
    /// How often an iteration of [`fgmres`](crate::fgmres) runs it by itself; zero for sums of others.
    pub runs: f64,
}

/// Takes a kernel and a way to run it.
pub type Measure<'a> = dyn FnMut(Kernel, &mut dyn FnMut()) + 'a;

/// Basis vectors against which Gram-Schmidt is measured: the mean over a solve of some twenty iterations.
const BASIS: usize = 10;

/// Hands every kernel of the block solver on `system` to `measure`, to be run as often as it likes.
///
/// The time of a kernel over its bytes is to be compared with the bandwidth of memory: nothing else should limit it.
pub fn visit_kernels(
    system: &SaddleSystem,
    preconditioner: &mut BlockTriangular,
    measure: &mut Measure,
) {
    let unknowns = system.rows();
    let x: Vec<f64> = (0..unknowns).map(|i| (i as f64).sin()).collect();
    let mut y = vec![0.0; unknowns];
    let (nodes, vertices) = (
        system.velocity_block().nodes(),
        system.pressure_range().len(),
    );
    let stiffness = system.velocity_block().stiffness().nnz() * 12 + nodes * 8;
    let divergence = |matrix: &Csr3| matrix.nnz() * 28 + matrix.rows() * 8;
    let kernel = |name, bytes, runs| Kernel { name, bytes, runs };

    let a = system.velocity_block();
    measure(
        kernel("K, three components, f64", stiffness + 48 * nodes, 1.0),
        &mut || a.apply(&x[..a.cols()], &mut y[..a.rows()]),
    );
    let (u, rest) = x.split_at(3 * nodes);
    let (v, p) = rest.split_at(a.border_len());
    let vectors = 24 * nodes + 8 * vertices;
    measure(
        kernel("B, f64", divergence(system.divergence()) + vectors, 1.0),
        &mut || system.apply_divergence([u], [v], [&mut y[..vertices]]),
    );
    measure(
        kernel("B^T, f64", divergence(system.gradient()) + vectors, 2.0),
        &mut || system.apply_gradient(p, &mut y[..3 * nodes]),
    );
    preconditioner.visit_kernels(measure);
    visit_basis_kernels(BASIS, unknowns, system.residual_weights(), measure);
    measure(kernel("y + alpha x", 24 * unknowns, 0.0), &mut || {
        axpy(1e-9, &x, &mut y);
    });
    let both = divergence(system.divergence()) + divergence(system.gradient());
    measure(
        kernel("whole operator", stiffness + both + 16 * unknowns, 0.0),
        &mut || system.apply(&x, &mut y),
    );
    let bytes = preconditioner.bytes() + divergence(system.gradient()) + 16 * unknowns;
    measure(kernel("whole preconditioner", bytes, 0.0), &mut || {
        preconditioner.apply(&x, &mut y);
    });
}
