//! Borders with multipliers, and with rows that differ from columns.

use linalg::{Bordered, Csr, LinalgError, Prolongation, SaddleSystem};
use nalgebra::DMatrix;

use super::{Stokes, cube};

/// The system with another, possibly larger corner and scaled left borders.
pub fn with_border(
    stokes: &Stokes,
    corner: DMatrix<f64>,
    left_scale: Option<f64>,
) -> Result<SaddleSystem, LinalgError> {
    let (s, m) = (&stokes.system, corner.nrows());
    let a = s.velocity_block();
    let scaled = |matrix: Csr| left_scale.map(|f| matrix.map(|v| v * f));
    let (c, e) = (widen(a.border(), m), widen(s.border_divergence(), m));
    let a = Bordered::new(a.stiffness().clone(), c.clone(), scaled(c), corner)?;
    let mass = s.pressure_mass().clone();
    SaddleSystem::new(a, s.divergence().clone(), e.clone(), scaled(e), mass)
}

/// The prolongation for a border of `m` dofs; additional ones have no motion.
pub fn prolongation_for(stokes: &Stokes, m: usize) -> Prolongation {
    let border = widen(stokes.prolongation.border(), m);
    Prolongation::new(stokes.prolongation.nodes().clone(), border).expect("a prolongation")
}

/// Appends multipliers to the corner that keep neighbouring bodies at the same velocity.
pub fn chained(corner: &DMatrix<f64>) -> DMatrix<f64> {
    let m = corner.nrows();
    let bodies = m / 6;
    let mut all = corner
        .clone()
        .resize(m + 3 * (bodies - 1), m + 3 * (bodies - 1), 0.0);
    for joint in 0..bodies - 1 {
        for d in 0..3 {
            let row = m + 3 * joint + d;
            for (body, sign) in [(joint, 1.0), (joint + 1, -1.0)] {
                all[(row, 6 * body + d)] = sign;
                all[(6 * body + d, row)] = sign;
            }
        }
    }
    all
}

/// Two small bodies linked by multipliers, and the system without them.
pub fn linked_pair() -> (Stokes, SaddleSystem) {
    let stokes = Stokes::new(5, &[cube([1, 2, 2], 1), cube([3, 2, 2], 1)], 5.0);
    let corner = chained(stokes.system.velocity_block().corner());
    let system = with_border(&stokes, corner, None).expect("a sound system");
    (stokes, system)
}

/// The matrix with `m` columns, the additional ones empty.
fn widen(matrix: &Csr, m: usize) -> Csr {
    let (indptr, columns, values) = matrix.clone().into_raw_storage();
    Csr::new((matrix.rows(), m), indptr, columns, values)
}
