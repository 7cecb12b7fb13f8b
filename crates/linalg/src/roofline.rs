//! The kernels of an iteration one by one, each with the bytes that it has to move.

pub use crate::kernel::{Kernel, Measure};
use crate::krylov::visit_basis_kernels;
use crate::vector::axpy;
use crate::{BlockTriangular, Csr3, LinearOperator, Preconditioner, SaddleSystem};

/// Basis vectors in the measured Gram-Schmidt step: the mean over a solve of about twenty
/// iterations.
const BASIS: usize = 10;

/// Passes every kernel of the block solver on `system` to `measure`, which may run it repeatedly.
///
/// The ratio of bytes to time should equal the memory bandwidth: nothing else should limit a
/// kernel.
pub fn visit_kernels(
    system: &SaddleSystem,
    preconditioner: &mut BlockTriangular,
    measure: &mut Measure,
) {
    let dofs = system.rows();
    let x: Vec<f64> = (0..dofs).map(|i| (i as f64).sin()).collect();
    let mut y = vec![0.0; dofs];
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
    visit_basis_kernels(BASIS, dofs, system.residual_weights(), measure);
    measure(kernel("y + alpha x", 24 * dofs, 0.0), &mut || {
        axpy(1e-9, &x, &mut y);
    });
    let both = divergence(system.divergence()) + divergence(system.gradient());
    measure(
        kernel("whole operator", stiffness + both + 16 * dofs, 0.0),
        &mut || system.apply(&x, &mut y),
    );
    let bytes = preconditioner.bytes() + divergence(system.gradient()) + 16 * dofs;
    measure(kernel("whole preconditioner", bytes, 0.0), &mut || {
        preconditioner.apply(&x, &mut y);
    });
}
