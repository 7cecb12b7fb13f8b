//! Loads of the links on bodies: multipliers of the constraints, in every formulation.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::error::check_length;
use crate::{Constraints, Drive, NullSpace, Reduction, RigidError, SymmetryPlanes};

/// Data for the loads `λ` of the links: `C^T λ` balances the fluid's forces and the external loads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct LinkLoads {
    /// Independent rows of `C`, gauge rows below them.
    rows: DMatrix<f64>,
    /// Indices of the independent rows of `C`; the other rows are redundant and carry no load.
    independent: Vec<usize>,
    /// Number of rows of `C`.
    constraints: usize,
    /// External loads, conjugate to the generalised velocities.
    external: DVector<f64>,
    /// Generalised velocities of bodies with surfaces.
    surface_rows: Vec<usize>,
    /// Velocities of bodies with surfaces that the links allow, one column per dof.
    surface_basis: DMatrix<f64>,
    /// Vectors along the links.
    ///
    /// They do not affect the loads, but distinguish drives at different lengths: with
    /// [`Arms::Lab`](crate::Arms::Lab) `rows` contain no lengths.
    link_vectors: Vec<Vector3<f64>>,
}

impl Drive<'_> {
    /// The velocities that links and symmetry planes allow, and data for the loads of the links.
    ///
    /// Only [`NullSpace::offset`] depends on the rates of the links.
    ///
    /// # Errors
    /// Links that contradict each other, loads that are not symmetric about the planes, not finite
    /// or of the wrong number, constraints of another set.
    pub(crate) fn reduced(
        &self,
        symmetry_planes: SymmetryPlanes,
    ) -> Result<(NullSpace, LinkLoads), RigidError> {
        self.check()?;
        let constraints = Constraints::with_symmetry(self, symmetry_planes)?;
        let Reduction {
            all, surface_basis, ..
        } = Reduction::of(self.set, &constraints)?;
        let loads = LinkLoads {
            rows: all.constraint_rows(&constraints),
            independent: all.independent.clone(),
            constraints: constraints.matrix.nrows(),
            external: self.generalised_loads()?,
            surface_rows: self.set.surface_velocities(),
            surface_basis,
            link_vectors: constraints.link_vectors.clone(),
        };
        Ok((all, loads))
    }

    /// Loads of the links that balance given forces `(F, T)` of the rigid bodies on the fluid.
    ///
    /// For flow models that provide resistances only. The layout is that of
    /// [`FlowSolution::link_loads`](crate::FlowSolution::link_loads).
    ///
    /// # Errors
    /// Links that contradict each other, lists of the wrong length.
    pub fn link_loads(&self, forces: &DVector<f64>) -> Result<DVector<f64>, RigidError> {
        check_length(
            "forces and torques of the rigid bodies",
            forces.len(),
            self.set.surface_velocities().len(),
        )?;
        self.reduced(SymmetryPlanes::default())?.1.balancing(forces)
    }
}

impl LinkLoads {
    /// Independent rows of `C`, gauge rows below them.
    pub(crate) fn rows(&self) -> &DMatrix<f64> {
        &self.rows
    }

    /// External loads, conjugate to the generalised velocities.
    pub(crate) fn external(&self) -> &DVector<f64> {
        &self.external
    }

    /// Loads from the multipliers `α` of the independent rows: `M q + C^T α = F`, so `λ = -α`.
    pub(crate) fn of_multipliers(&self, multipliers: &[f64]) -> DVector<f64> {
        let mut loads = DVector::zeros(self.constraints);
        for (&row, alpha) in self.independent.iter().zip(multipliers) {
            loads[row] = -alpha;
        }
        loads
    }

    /// Loads that balance the forces `(F, T)` of the bodies on the fluid.
    ///
    /// `C^T λ = forces - external`. The rows are independent, so the least-squares solution is
    /// unique. Its residual is the residual of the force balances of the motions that the links
    /// allow.
    ///
    /// # Errors
    /// [`RigidError::DependentConstraints`] for rows that are linearly dependent to rounding.
    pub(crate) fn balancing(&self, forces: &DVector<f64>) -> Result<DVector<f64>, RigidError> {
        let multipliers = self.multipliers(forces, -&self.external)?;
        Ok(self.of_independent(&multipliers))
    }

    /// Change of the loads for a change of the forces `(F, T)`, and the forces that it balances.
    ///
    /// The external loads do not change. The forces returned are the part of the given ones that
    /// does no work on motions that the links allow, `f - S (S^T S)^-1 S^T f`.
    ///
    /// # Errors
    /// Those of [`LinkLoads::balancing`].
    pub(crate) fn change(
        &self,
        forces: &DVector<f64>,
    ) -> Result<(DVector<f64>, DVector<f64>), RigidError> {
        let basis = &self.surface_basis;
        let gram = (basis.tr_mul(basis))
            .cholesky()
            .ok_or(RigidError::DependentConstraints)?;
        let balanced = forces - basis * gram.solve(&basis.tr_mul(forces));
        let multipliers = self.multipliers(&balanced, DVector::zeros(self.external.len()))?;
        Ok((self.of_independent(&multipliers), balanced))
    }

    /// Loads of all rows from those of the independent ones.
    fn of_independent(&self, multipliers: &DVector<f64>) -> DVector<f64> {
        let mut loads = DVector::zeros(self.constraints);
        for (&row, &load) in self.independent.iter().zip(multipliers.iter()) {
            loads[row] = load;
        }
        loads
    }

    /// Least-squares solution of `C^T λ = forces + others`, gauge rows included.
    fn multipliers(
        &self,
        forces: &DVector<f64>,
        others: DVector<f64>,
    ) -> Result<DVector<f64>, RigidError> {
        let mut unbalanced = others;
        for (&row, force) in self.surface_rows.iter().zip(forces.iter()) {
            unbalanced[row] += force;
        }
        let normal = (&self.rows * self.rows.transpose())
            .cholesky()
            .ok_or(RigidError::DependentConstraints)?;
        Ok(normal.solve(&(&self.rows * unbalanced)))
    }
}
