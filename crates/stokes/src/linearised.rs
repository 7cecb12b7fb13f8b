//! Equations of a generalised Newtonian fluid, linearised at a flow.

use fem::{VaryingViscosity, ViscosityOfRate};
use linalg::{CoupledOperator, LinearOperator};
use nalgebra::Vector3;
use rigid::{Articulation, Constrained, FlowSolution};

use crate::StokesError;
use crate::linear::has_convection;
use crate::viscous_stress::ViscousStress;

/// The equations of the flow, linearised at a velocity.
///
/// The scalar matrix `∫ η ∇u:∇v` is that of `system`, with all formulations and preconditioners.
/// The rest of the derivative acts on the velocities of all nodes, those of bodies included:
/// `A = A_s + T^T K_c T`, with `T` the velocities of nodes for the dofs of the system.
pub struct Linearised {
    /// The scalar matrix, its formulation and its preconditioners.
    pub system: Constrained,
    /// The rest of the derivative, over all nodes.
    pub coupling: CoupledOperator,
    /// Velocity at which the equations are linearised, background flow included.
    pub velocity: Vec<Vector3<f64>>,
}

/// A flow that was solved for, with the stress at it, for error estimates.
#[derive(Clone, Copy)]
pub struct VaryingFlow<'a> {
    pub equations: &'a Linearised,
    pub stress: ViscousStress<'a>,
    /// The same stress at the points of the error estimates.
    pub viscosity: &'a VaryingViscosity<'a>,
    /// The law of `stress` for facets.
    pub law: &'a ViscosityOfRate<'a>,
}

impl Linearised {
    /// Change of a flow by forces on the nodes; see [`Constrained::change`].
    pub fn change(
        &self,
        solution: &[f64],
        forces: &[Vector3<f64>],
        set: &Articulation,
    ) -> Result<FlowSolution, StokesError> {
        let (velocity, _) = self.system.flow_of_loads(solution)?;
        let balanced = self.coupled_forces(&velocity);
        let forces: Vec<_> = forces
            .iter()
            .zip(balanced)
            .map(|(f, own)| f - own)
            .collect();
        Ok(self.system.change(solution, &forces, set)?)
    }

    /// `K_c u`: forces on the nodes for velocities of the nodes.
    fn coupled_forces(&self, velocity: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let flat: Vec<f64> = velocity.iter().flatten().copied().collect();
        let mut forces = vec![0.0; flat.len()];
        self.coupling.apply(&flat, &mut forces);
        let nodes = forces.as_chunks::<3>().0.iter();
        nodes.map(|force| Vector3::from(*force)).collect()
    }

    /// Whether the scalar matrix has convection.
    pub fn has_convection(&self) -> bool {
        has_convection(&self.system)
    }

    fn multiply(&self, x: &[f64], y: &mut [f64]) -> Result<(), StokesError> {
        let (velocity, pressure) = self.system.flow_of_loads(x)?;
        let forces = self.coupled_forces(&velocity);
        let rows = self
            .system
            .rhs_of_forces(&forces, &vec![0.0; pressure.len()])?;
        self.system.system.apply(x, y);
        y.iter_mut().zip(rows).for_each(|(y, row)| *y += row);
        Ok(())
    }
}

impl LinearOperator for Linearised {
    fn rows(&self) -> usize {
        self.system.system.rows()
    }

    fn cols(&self) -> usize {
        self.system.system.cols()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        if self.multiply(x, y).is_err() {
            // Solvers report numbers that are not finite.
            y.fill(f64::NAN);
        }
    }

    fn residual_weights(&self) -> Option<&[f32]> {
        self.system.system.residual_weights()
    }

    fn is_symmetric(&self) -> bool {
        self.system.system.is_symmetric()
    }
}
