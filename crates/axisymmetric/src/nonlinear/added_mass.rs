//! The added mass of bodies on the axis: forces that accelerate the fluid around them.
//!
//! If the bodies `b` accelerate by `A_b` along the axis, the fluid accelerates at once by the
//! gradient of a potential,
//!
//! ```text
//! Δφ = 0,   ∂φ/∂n = A_b n_z on bodies,   ∂φ/∂n = 0 on walls
//! ```
//!
//! whatever its viscosity and its velocity: vorticity diffuses from the surfaces only afterwards.
//! The pressure is `-ρ φ`, and the forces that the bodies exert on the fluid are (Lamb 1932,
//! section 118; Batchelor 1967, section 6.4)
//!
//! ```text
//! F_b = -ρ ∮_b φ n_z dS = sum_c m_bc A_c,   m = ρ G^T K^-1 G,   G_ib = -∮_b N_i n_z dS
//! ```
//!
//! with normals into the fluid and the stiffness matrix `K` of the basis functions `N_i`. The
//! matrix `m` is symmetric, its errors are those of an energy: of twice the order of the gradient.

use std::sync::Arc;

use nalgebra::DMatrix;

use super::bodies::{AxialBody, domain};
use super::flow_system::{FlowSystem, Terms};
use super::orders::{GROWTH, raise_order};
use crate::curve::Point;
use crate::generate::generate;
use crate::{AxialSpheroid, AxisymmetricError, Surroundings};

/// The added-mass matrix of bodies on one axis in a container.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AddedMass {
    /// Forces along the axis that the bodies exert on fluid of density 1, one column per unit
    /// acceleration of each body; symmetric.
    pub matrix: DMatrix<f64>,
    /// Largest change by the last order of the elements, relative to the largest entry.
    pub relative_error: f64,
    /// Number of degrees of freedom of the potential.
    pub dofs: usize,
}

/// Computes the added mass of bodies along their axis, by elements of increasing order on one mesh.
///
/// Cost: one scalar factorisation per order.
///
/// ```
/// use axisymmetric::{AxialSpheroid, Surroundings, added_mass};
///
/// let sphere = AxialSpheroid::sphere(0.0, 1.0);
/// let found = added_mass(&[sphere], Surroundings::Ball { radius: 2.0 }, 1e-8)?;
/// // `2/3 π a^3 (b^3 + 2 a^3) / (b^3 - a^3)` in a concentric ball (Lamb 1932, section 93)
/// let exact = 2.0 / 3.0 * std::f64::consts::PI * 10.0 / 7.0;
/// assert!((found.matrix[(0, 0)] / exact - 1.0).abs() < 1e-8);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
///
/// # Errors
/// [`AxisymmetricError::NoContainer`], [`AxisymmetricError::InvalidTolerance`],
/// [`AxisymmetricError::FlowNotConverged`], and domains that cannot be meshed.
pub fn added_mass(
    shapes: &[AxialSpheroid],
    surroundings: Surroundings,
    tolerance: f64,
) -> Result<AddedMass, AxisymmetricError> {
    let bodies: Vec<AxialBody> = shapes.iter().copied().map(AxialBody::prescribed).collect();
    let mesh = Arc::new(generate(&domain(&bodies, surroundings)?, GROWTH)?);
    let solve = |order: usize, _: Option<&(DMatrix<f64>, usize)>| {
        let roles = vec![None; bodies.len()];
        let system = FlowSystem::new(Arc::clone(&mesh), order, roles, 0, None, None)?;
        let positions = system.positions();
        let matrix =
            system.added_mass(&positions, &DMatrix::identity(bodies.len(), bodies.len()))?;
        Ok((matrix, positions.len()))
    };
    let difference = |(a, _): &(DMatrix<f64>, usize), (b, _): &(DMatrix<f64>, usize)| {
        let largest = b.amax();
        match largest > 0.0 {
            true => (a - b).amax() / largest,
            false => 0.0,
        }
    };
    let ((matrix, dofs), relative_error) = raise_order([tolerance; 2], solve, difference)?;
    Ok(AddedMass {
        matrix,
        relative_error,
        dofs,
    })
}

impl FlowSystem {
    /// Forces that bodies exert on fluid of density 1 by accelerations, one column each.
    ///
    /// Cost: one factorisation with a number per velocity node.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`], [`AxisymmetricError::SingularElement`].
    pub fn added_mass(
        &self,
        positions: &[Point],
        accelerations: &DMatrix<f64>,
    ) -> Result<DMatrix<f64>, AxisymmetricError> {
        let normals = self.axial_normals(positions)?;
        let at_rest = self.rest();
        let factors = self.potential_condensation().factor(&|t| {
            let element = self.element(t, positions, &at_rest, &Terms::default())?;
            Ok::<_, AxisymmetricError>(element.stiffness())
        })?;
        let mut forces = DMatrix::zeros(self.motions.len(), accelerations.ncols());
        for (acceleration, mut forces) in accelerations.column_iter().zip(forces.column_iter_mut())
        {
            let mut rhs = vec![0.0; positions.len()];
            for (node, body) in self.nodes_on_bodies() {
                rhs[node] = acceleration[body] * normals[node];
            }
            rhs[0] = 0.0;
            let potential = factors.solve(&rhs);
            for (node, body) in self.nodes_on_bodies() {
                forces[body] += potential[node] * normals[node];
            }
        }
        Ok(forces)
    }
}
