//! What the rates of links put into a system: velocities that they impose, and the right-hand side these make.

use linalg::Csr;
use nalgebra::{DMatrix, DVector};

use crate::RigidFluid;

/// Right-hand side and velocities of one set of rates, from [`Constrained::imposed`](crate::Constrained::imposed).
///
/// The matrix of a system knows where bodies are and which links hold them, not how fast the links change: several rates at one shape are
/// several right-hand sides of one matrix.
#[derive(Clone, Debug)]
pub struct Imposed {
    /// Right-hand side.
    pub rhs: Vec<f64>,
    /// The velocities that the links impose, `W`.
    pub(crate) offset: DVector<f64>,
}

/// The right-hand side for loads `F` and imposed velocities `W` = `offset`, which satisfy every constraint.
///
/// It is `-C W` for the flow, `L^T (F - M W)` for the border (`L` = `tests`; zero where a row is a constraint) and `-E W` for
/// incompressibility. It is the same for all formulations, and so is what a relative residual means.
pub(crate) fn imposed_rhs(
    fluid: &RigidFluid,
    tests: &DMatrix<f64>,
    surface_rows: &[usize],
    loads: &DVector<f64>,
    offset: &DVector<f64>,
) -> Vec<f64> {
    let of_surfaces = offset.select_rows(surface_rows);
    let surface_tests = tests.select_rows(surface_rows);
    let mut rhs = negated_product(&fluid.border, &of_surfaces);
    clear(&fluid.held, &mut rhs);
    let border = tests.tr_mul(loads) / fluid.symmetry_planes().parts()
        - surface_tests.tr_mul(&(&fluid.corner * &of_surfaces));
    rhs.extend(border.iter());
    rhs.extend(negated_product(&fluid.rigid_divergence, &of_surfaces));
    rhs
}

/// Zeroes the components that mirror planes hold.
pub(crate) fn clear(held: &[(u32, [bool; 3])], velocity: &mut [f64]) {
    for (node, planes) in held {
        for axis in (0..3).filter(|&axis| planes[axis]) {
            velocity[3 * *node as usize + axis] = 0.0;
        }
    }
}

fn negated_product(matrix: &Csr, x: &DVector<f64>) -> Vec<f64> {
    matrix
        .outer_iterator()
        .map(|row| -row.iter().map(|(j, &a)| a * x[j]).sum::<f64>())
        .collect()
}
