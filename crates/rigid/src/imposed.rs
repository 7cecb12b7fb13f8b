//! Right-hand sides of prescribed velocities: rates of joints, moving walls, moving surfaces.

use linalg::Csr;
use nalgebra::{DMatrix, DVector};

use crate::body_forces::Surfaces;

/// Right-hand side and velocities for one set of rates, from
/// [`Constrained::imposed`](crate::Constrained::imposed).
///
/// The matrix of a system depends on the configuration and on which joints there are, but not on
/// the rates of the joints: several rates are several right-hand sides of one matrix.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Imposed {
    /// Right-hand side.
    pub rhs: Vec<f64>,
    /// The velocities `W` that the joints impose.
    pub(crate) offset: DVector<f64>,
}

/// Right-hand side for loads `F` and imposed velocities `W` (`offset`).
///
/// The velocities `W` satisfy every constraint. The blocks are `-C W` for the flow, `L^T (F - M W)`
/// for the border (`L` = `tests`; zero where a row is a constraint) and `-E W` for
/// incompressibility, each minus the terms of prescribed velocities. They are the same for all
/// formulations, so that relative residuals are comparable.
pub(crate) fn imposed_rhs(
    surfaces: &Surfaces,
    tests: &DMatrix<f64>,
    surface_rows: &[usize],
    loads: &DVector<f64>,
    offset: &DVector<f64>,
) -> Vec<f64> {
    let of_surfaces = offset.select_rows(surface_rows);
    let surface_tests = tests.select_rows(surface_rows);
    let mut rhs = negated_product(&surfaces.border, &of_surfaces);
    let mut border = tests.tr_mul(loads) / surfaces.symmetry_planes.parts()
        - surface_tests.tr_mul(&(&surfaces.corner * &of_surfaces));
    let mut flux = negated_product(&surfaces.rigid_divergence, &of_surfaces);
    if let Some(prescribed) = &surfaces.prescribed {
        subtract(&mut rhs, &prescribed.momentum);
        border -= surface_tests.tr_mul(&prescribed.loads);
        subtract(&mut flux, &prescribed.flux);
    }
    surfaces.zero_constrained(&mut rhs);
    rhs.extend(border.iter());
    rhs.extend(flux);
    rhs
}

fn negated_product(matrix: &Csr, x: &DVector<f64>) -> Vec<f64> {
    matrix
        .outer_iterator()
        .map(|row| -row.iter().map(|(j, &a)| a * x[j]).sum::<f64>())
        .collect()
}

fn subtract(from: &mut [f64], other: &[f64]) {
    from.iter_mut().zip(other).for_each(|(a, b)| *a -= b);
}
