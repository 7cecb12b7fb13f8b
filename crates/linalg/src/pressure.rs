//! Approximate inverse of the Schur complement of the pressure.

use crate::{
    Bordered, Csr, LinalgError, MassInverse, MultigridParams, SaddleSystem, ScalarMultigrid, csr,
};

/// Chebyshev steps on the pressure mass matrix.
///
/// Two or three need the same iterations, one needs three more (methods note 1.2).
pub(crate) const MASS_STEPS: usize = 3;

/// Multiple of the mass matrix that is added to the Laplacian, whose null space is the constants.
///
/// Residuals of the divergence sum to zero, so that the shift acts on rounding errors only.
const SHIFT: f64 = 1e-3;

/// `M_p^-1`, or `M_p^-1 + L^-1` with a Laplacian `L`.
///
/// See
/// [`BlockTriangular::with_pressure_laplacian`](crate::BlockTriangular::with_pressure_laplacian).
pub(crate) struct PressureInverse {
    mass: MassInverse,
    laplacian: Option<ScalarMultigrid>,
}

impl PressureInverse {
    /// Uses the mass matrix alone.
    pub fn new(system: &SaddleSystem) -> Result<Self, LinalgError> {
        Ok(PressureInverse {
            mass: MassInverse::new(system.pressure_mass(), MASS_STEPS)?,
            laplacian: None,
        })
    }

    /// Adds the inverse of `laplacian`, a symmetric positive semidefinite matrix.
    pub fn with_pressure_laplacian(
        mut self,
        system: &SaddleSystem,
        laplacian: &Csr,
    ) -> Result<Self, LinalgError> {
        let mass = system.pressure_mass();
        csr::check_shape("pressure Laplacian", laplacian.shape(), mass.shape())?;
        let shifted = laplacian + &mass.map(|v| SHIFT * v);
        let shifted = Bordered::scalar(shifted)?;
        let cycle = ScalarMultigrid::of(&shifted, &MultigridParams::default())?;
        self.laplacian = Some(cycle);
        Ok(self)
    }

    /// Overwrites the columns `z` with the approximate solutions for `r`.
    pub fn pass<const S: usize>(&mut self, r: [&[f64]; S], mut z: [&mut [f64]; S]) {
        self.mass.pass(r, z.each_mut().map(|z| &mut **z));
        // one by one: as the three components of one cycle, columns might be rounded differently
        if let Some(cycle) = &mut self.laplacian {
            for (r, z) in r.iter().zip(z) {
                cycle.solve_into(r, z, |z, v| *z += v);
            }
        }
    }
}

#[cfg(feature = "roofline")]
impl PressureInverse {
    /// The inverse of the mass matrix.
    pub fn mass(&mut self) -> &mut MassInverse {
        &mut self.mass
    }

    /// Lower bound on the bytes moved by one application.
    pub fn bytes(&self) -> usize {
        self.mass.bytes() + self.laplacian.as_ref().map_or(0, |cycle| cycle.bytes())
    }
}
