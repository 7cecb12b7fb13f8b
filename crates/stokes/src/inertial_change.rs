//! What inertia would change about a Stokes flow, to first order in the densities.

use fem::PointValues;
use nalgebra::Vector3;
use rigid::{Drive, FlowSolution};

use crate::StokesError;
use crate::linear::solve_system;
use crate::options::Options;
use crate::problem::Problem;

/// A Stokes flow and how it changes in time, on a mesh that moves; one vector per node.
#[derive(Clone, Copy, Debug)]
pub struct ChangingFlow<'a> {
    /// Velocity `u_0`.
    pub velocity: &'a [Vector3<f64>],
    /// Rate of change of the velocity at the nodes, which move with the mesh.
    pub derivative: &'a [Vector3<f64>],
    /// Velocity `w` of the nodes.
    pub mesh_velocity: &'a [Vector3<f64>],
}

/// First-order changes of a Stokes flow by the inertia that it neglects, by cause.
///
/// The flow with inertia has their sum in addition, up to terms of the second order in the
/// densities.
#[derive(Clone, Debug)]
pub struct InertialChange {
    /// By the unsteady acceleration of the fluid, `ρ ∂u_0/∂t` at fixed points.
    pub unsteady: FlowSolution,
    /// By the convective acceleration of the fluid, `ρ (u_0 · ∇) u_0`.
    pub convective: FlowSolution,
    /// By the inertia of the bodies.
    pub bodies: FlowSolution,
}

impl ChangingFlow<'_> {
    /// Forces `-ρ ∫ N_i ∂u_0/∂t` and `-ρ ∫ N_i (u_0 · ∇) u_0` on the nodes.
    ///
    /// The gradients are those of the quadratic elements at the quadrature points: a gradient that
    /// is interpolated from nodes would have half the order.
    fn forces(
        &self,
        problem: &Problem,
        density: f64,
    ) -> Result<[Vec<Vector3<f64>>; 2], StokesError> {
        let force = |acceleration: &(dyn Fn(&PointValues) -> Vector3<f64> + Sync)| {
            // N_i, the velocities and their gradients are of degree 2, 2 and 1
            fem::assemble_load(problem.mesh(), 5, |point, load: &mut [_; 10]| {
                let force = -density * acceleration(point);
                point.add_load(load, |v| v.value * force);
            })
        };
        // at fixed points, from the derivative at points that move with the mesh
        let unsteady = force(&|point| {
            let carried = point.gradient(self.velocity) * point.value(self.mesh_velocity);
            point.value(self.derivative) - carried
        })?;
        let convective =
            force(&|point| point.gradient(self.velocity) * point.value(self.velocity))?;
        Ok([unsteady, convective])
    }
}

impl Problem<'_> {
    /// First-order changes of a flow by the inertia of the fluid and of the bodies.
    ///
    /// ```text
    /// -Δu_1 + ∇p_1 = -ρ (∂u_0/∂t + (u_0 · ∇) u_0),   ∇·u_1 = 0
    /// ```
    ///
    /// with rigid motions on the bodies, the same joints and surface velocities as `u_0`. By the
    /// reciprocal theorem the change of a velocity is that of its adjoint solution `z`,
    ///
    /// ```text
    /// V_1 = -ρ ∫ (∂u_0/∂t + (u_0 · ∇) u_0) · z dV - sum_b m_b A_b · Z_b
    /// ```
    ///
    /// which the solution of the symmetric discrete equations is to rounding, for all velocities
    /// and forces at once and in every formulation. In `drive` all rates are zero and the loads are
    /// minus the rates of momentum of the bodies. Cost: an assembly, two passes over the cells, and
    /// one solve for three right-hand sides, to the tolerance of `options`.
    ///
    /// The fluid must be bounded, or the bodies free of a total force: otherwise the change is not
    /// of first order, and the integral grows with the domain.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`]; fields of the wrong length; [`StokesError::Linalg`] without
    /// convergence.
    pub fn inertial_change(
        &self,
        drive: &Drive,
        flow: &ChangingFlow,
        density: f64,
        options: &Options,
    ) -> Result<InertialChange, StokesError> {
        let forces = flow.forces(self, density)?;
        let system = self.assemble_with(drive, options.formulation, None)?;
        let no_sources = vec![0.0; self.mesh().n_vertices()];
        let [unsteady, convective] = [
            system.rhs_of_forces(&forces[0], &no_sources)?,
            system.rhs_of_forces(&forces[1], &no_sources)?,
        ];
        let rhs: [&[f64]; 3] = [&unsteady, &convective, &system.rhs];
        let method = (options.solver, options.rtol);
        let solved = solve_system(&system, &rhs, method, &Default::default(), &mut None)?;
        let solution = |number: usize| solved.columns[number].0.as_slice();
        Ok(InertialChange {
            unsteady: system.change(solution(0), &forces[0], drive.set)?,
            convective: system.change(solution(1), &forces[1], drive.set)?,
            bodies: system.flow(solution(2), drive.set)?,
        })
    }
}
