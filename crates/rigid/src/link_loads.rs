//! The loads that links put on bodies: multipliers of the constraints, whichever formulation imposed them.

use nalgebra::{DMatrix, DVector};

use crate::{Drive, NullSpace, RigidError};

/// What determines the loads of the links: `C^T lambda` is what the fluid takes and nothing outside gives.
#[derive(Clone, Debug)]
pub(crate) struct LinkLoads {
    /// Independent rows of `C`, gauge rows below them.
    held: DMatrix<f64>,
    /// The rows of `C` that are held; the others are redundant and carry nothing.
    independent: Vec<usize>,
    /// Number of rows of `C`.
    constraints: usize,
    /// External loads, conjugate of the generalised velocities.
    external: DVector<f64>,
    /// Generalised velocities of bodies with surfaces.
    surface_rows: Vec<usize>,
}

impl LinkLoads {
    pub(crate) fn new(all: &NullSpace, drive: &Drive) -> Result<Self, RigidError> {
        Ok(Self {
            held: all.held_rows(drive.constraints),
            independent: all.independent.clone(),
            constraints: drive.constraints.matrix.nrows(),
            external: drive.generalised_loads()?,
            surface_rows: drive.set.surface_velocities(),
        })
    }

    /// Loads from the multipliers `alpha` of the held rows, `M q + C^T alpha = F`: `lambda = -alpha`.
    pub(crate) fn of_multipliers(&self, multipliers: &[f64]) -> DVector<f64> {
        let mut loads = DVector::zeros(self.constraints);
        for (&row, alpha) in self.independent.iter().zip(multipliers) {
            loads[row] = -alpha;
        }
        loads
    }

    /// Loads that balance the forces `(F, T)` of the rigid bodies on the fluid: `C^T lambda = forces - external`.
    ///
    /// The held rows are independent, so there is one least-squares solution, and its residual is that of the balances of
    /// the free motions.
    ///
    /// # Errors
    /// Held rows that depend on each other to rounding.
    pub(crate) fn balancing(&self, forces: &DVector<f64>) -> Result<DVector<f64>, RigidError> {
        let mut unbalanced = -&self.external;
        for (&row, force) in self.surface_rows.iter().zip(forces.iter()) {
            unbalanced[row] += force;
        }
        let normal =
            (&self.held * self.held.transpose())
                .cholesky()
                .ok_or(RigidError::NotFinite {
                    what: "a load of a link",
                })?;
        let held = normal.solve(&(&self.held * unbalanced));
        let mut loads = DVector::zeros(self.constraints);
        for (&row, &load) in self.independent.iter().zip(held.iter()) {
            loads[row] = load;
        }
        Ok(loads)
    }
}
