//! The loads that links put on bodies: multipliers of the constraints, whichever formulation imposed them.

use nalgebra::{DMatrix, DVector};

use crate::{Constraints, Drive, NullSpace, Reduction, RigidError, SymmetryPlanes};

/// What determines the loads of the links: `C^T lambda` is what the fluid takes and nothing outside gives.
#[derive(Clone, Debug, PartialEq)]
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

impl Drive<'_> {
    /// The velocities that links and mirrors leave, and what determines the loads of the links.
    ///
    /// Of the two only [`NullSpace::offset`] depends on the links' rates.
    ///
    /// # Errors
    /// Links that contradict each other, loads that are not their own mirror images, a list of loads of the wrong length.
    pub(crate) fn reduced(
        &self,
        mirrors: SymmetryPlanes,
    ) -> Result<(NullSpace, LinkLoads), RigidError> {
        let constraints = Constraints::with_symmetry(self, mirrors)?;
        let Reduction { all, .. } = Reduction::of(self.set, &constraints)?;
        let loads = LinkLoads {
            held: all.constrained_rows(&constraints),
            independent: all.independent.clone(),
            constraints: constraints.matrix.nrows(),
            external: self.generalised_loads()?,
            surface_rows: self.set.surface_velocities(),
        };
        Ok((all, loads))
    }
}

impl LinkLoads {
    /// The rows of constraints that do not follow from each other, gauge rows below them.
    pub(crate) fn held(&self) -> &DMatrix<f64> {
        &self.held
    }

    /// External loads, conjugate of the generalised velocities.
    pub(crate) fn external(&self) -> &DVector<f64> {
        &self.external
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
