//! Approximate inverse of the Schur complement of the pressure.

use crate::csr::Rows;
use crate::{
    Bordered, Csr, LinalgError, MassInverse, MultigridParams, SaddleSystem, ScalarMultigrid, csr,
};

/// Chebyshev steps on the pressure mass matrix.
///
/// Two or three need the same iterations, one needs three more.
pub(crate) const MASS_STEPS: usize = 3;

/// Multiple of the mass matrix that is added to the Laplacian, whose null space is the constants.
///
/// Residuals of the divergence sum to zero, so that the shift acts on rounding errors only.
const MASS_SHIFT: f64 = 1e-3;

/// Multiple of `s_q` that approximates the Schur complement of a weak row.
///
/// Iterations with an exact velocity solve on Gmsh meshes of boxes, tubes and balls: equal within
/// one from 3.3 to 5, one or two more with 2.5.
const WEAK_ROW_FACTOR: f64 = 4.0;

/// Approximate inverse of the Schur complement: `M_p^-1 + W`, or `M_p^-1 + W + L^-1`.
///
/// `W` is a diagonal matrix, zero for most rows. A pressure at an edge or a corner of the fluid
/// acts on few free velocities, and its Schur complement is up to ten times smaller than the mass
/// matrix. With the diagonal `D` of the stiffness, `s_q = (B D^-1 B^T)_qq` tells such rows:
/// `W_qq = max(0, 1 / (4 s_q) - 1 / m_q)` for the diagonal `m` of the mass matrix. Inside the
/// fluid, `s_q` is 0.36 to 0.47 times `m_q`, at flat walls 0.23, at edges of 90 degrees 0.12 and at
/// corners 0.07 (medians on Gmsh meshes).
///
/// Symmetric and positive definite. For the Laplacian `L` see
/// [`BlockTriangular::with_pressure_laplacian`](crate::BlockTriangular::with_pressure_laplacian).
pub(crate) struct PressureInverse {
    mass: MassInverse,
    /// The nonzeros of `W`, with their rows.
    weak: Vec<(u32, f64)>,
    laplacian: Option<ScalarMultigrid>,
}

impl PressureInverse {
    /// Uses the mass matrix alone.
    pub fn new(system: &SaddleSystem) -> Result<Self, LinalgError> {
        Ok(PressureInverse {
            mass: MassInverse::new(system.pressure_mass(), MASS_STEPS)?,
            weak: weak_rows(system),
            laplacian: None,
        })
    }

    /// Adds the inverse of `laplacian`, a symmetric positive semidefinite matrix.
    pub fn with_pressure_laplacian(mut self, laplacian: &Csr) -> Result<Self, LinalgError> {
        let mass = self.mass.matrix();
        csr::check_shape("pressure Laplacian", laplacian.shape(), mass.shape())?;
        let shifted = laplacian + &mass.map(|v| MASS_SHIFT * v);
        let shifted = Bordered::scalar(shifted)?;
        let cycle = ScalarMultigrid::from_scalar(&shifted, &MultigridParams::default())?;
        self.laplacian = Some(cycle);
        Ok(self)
    }

    /// Overwrites the columns `z` with the approximate solutions for `r`.
    pub fn pass<const S: usize>(&mut self, r: [&[f64]; S], mut z: [&mut [f64]; S]) {
        self.mass.pass(r, z.each_mut().map(|z| &mut **z));
        for (r, z) in r.iter().zip(&mut z) {
            for &(q, w) in &self.weak {
                z[q as usize] += w * r[q as usize];
            }
        }
        // one by one: as the three components of one cycle, columns might be rounded differently
        if let Some(cycle) = &mut self.laplacian {
            for (r, z) in r.iter().zip(z) {
                cycle.solve_into(r, z, |z, v| *z += v);
            }
        }
    }
}

/// The nonzeros of the diagonal matrix `W` of [`PressureInverse`].
fn weak_rows(system: &SaddleSystem) -> Vec<(u32, f64)> {
    let stiffness = csr::diagonal(system.velocity_block().stiffness());
    let mass = csr::diagonal(system.pressure_mass());
    let divergence = Rows::new(system.divergence());
    let excess = |(q, m): (usize, &f64)| {
        let row = divergence.row(q);
        let schur: f64 = row
            .map(|(j, [x, y, z])| (x * x + y * y + z * z) / stiffness[j])
            .sum();
        let excess = (WEAK_ROW_FACTOR * schur).recip() - m.recip();
        // a row without free velocities has no Schur complement to approximate
        (excess > 0.0 && excess.is_finite()).then_some((q as u32, excess))
    };
    mass.iter().enumerate().filter_map(excess).collect()
}
