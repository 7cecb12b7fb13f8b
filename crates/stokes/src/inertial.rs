//! The problem of one step in time, or of a steady flow: Stokes flow with terms of inertia.

use fem::TaylorHood;
use linalg::WarmStart;
use mesh::TetMesh;
use nalgebra::Vector3;
use rigid::{Constrained, Drive, FlowSolution, Formulation, Inertia};

use crate::linear::solve_system;
use crate::{Options, Problem, SolverReport, StokesError};

/// Terms of inertia in the momentum equation, with known velocities, at viscosity 1.
///
/// ```text
/// κ u + ρ (c · ∇) u - Δu + ∇p = g,   ∇·u = 0
/// ```
///
/// For a step in time, `κ = ρ c_0 / Δt` with the coefficient `c_0` of the new velocity in its
/// derivative, and `g = -ρ (c_1 u_1 + c_2 u_2) / Δt` has the earlier velocities, as nodal values on
/// the new mesh. For a steady flow both are zero. Masses of bodies enter by the drive:
/// [`body_damping`](rigid::Constraints::body_damping) and loads.
#[derive(Clone, Copy, Debug, Default)]
pub struct InertialTerms<'a> {
    /// Density of the fluid `ρ`.
    pub density: f64,
    /// Coefficient `κ` of the velocity.
    pub coefficient: f64,
    /// Force per volume `g` at each node.
    pub force: Option<&'a [Vector3<f64>]>,
    /// Integrated forces `∫ N_i g` at each node, in addition to `force`.
    pub load: Option<&'a [Vector3<f64>]>,
    /// Velocity `c` relative to the mesh at each node; without it the equation is linear.
    pub convecting: Option<&'a [Vector3<f64>]>,
    /// Velocity of the walls, one per node, of which those on walls are used; none if at rest.
    pub wall_velocity: Option<&'a [Vector3<f64>]>,
}

impl InertialTerms<'_> {
    /// The matrices of inertia of a space, and the forces `∫ N_i g` on the nodes.
    pub(crate) fn assemble(
        &self,
        space: &TaylorHood,
        mesh: &TetMesh,
        pressure_laplacian: linalg::Csr,
    ) -> Result<(Inertia, Vec<Vector3<f64>>), StokesError> {
        let mass = space.velocity_mass(mesh)?;
        let mut forces = match self.load {
            Some(load) => load.to_vec(),
            None => vec![Vector3::zeros(); mesh.n_points()],
        };
        if let Some(field) = self.force {
            for (force, row) in forces.iter_mut().zip(mass.outer_iterator()) {
                *force += row
                    .iter()
                    .map(|(column, m)| *m * field[column])
                    .sum::<Vector3<f64>>();
            }
        }
        let inertia = Inertia::new(self.coefficient, mass, pressure_laplacian);
        let Some(c) = self.convecting else {
            return Ok((inertia, forces));
        };
        // N_i, c and ∇N_j are of degree 2, 2 and 1
        let convection = space.assemble(mesh, 5, |point, matrix: &mut [[f64; 10]; 10]| {
            let c = self.density * point.value(c);
            point.add(matrix, |v, u| v.value * c.dot(&u.gradient));
        })?;
        let of_pressure = space.assemble(mesh, 4, |point, matrix: &mut [[f64; 4]; 4]| {
            let c = self.density * point.value(c);
            point.add(matrix, |q, p| q.value * c.dot(&p.gradient));
        })?;
        Ok((inertia.with_convection(convection, of_pressure), forces))
    }

    /// Refuses fields of another length than the nodes.
    pub(crate) fn check(&self, nodes: usize) -> Result<(), StokesError> {
        for field in [self.force, self.load, self.convecting, self.wall_velocity] {
            let found = field.map_or(nodes, <[_]>::len);
            if found != nodes {
                return Err(rigid::RigidError::Length {
                    what: "nodal values of the terms of inertia",
                    expected: nodes,
                    found,
                }
                .into());
            }
        }
        Ok(())
    }
}

/// The assembled system of a problem with inertia; see [`Problem::assemble_inertial`].
pub struct InertialSystem {
    /// The system; its right-hand side contains the forces on the nodes.
    pub system: Constrained,
    /// Forces on the nodes: the known momentum.
    pub forces: Vec<Vector3<f64>>,
}

impl InertialSystem {
    /// Solves the system, from the solutions that `warm` has.
    ///
    /// The pressure has zero mean over the fluid. Forces of the bodies on the fluid are residuals of
    /// the whole momentum equation, inertia included.
    ///
    /// # Errors
    /// [`StokesError::Linalg`] without convergence, or for a solver that needs a symmetric system if
    /// there is convection.
    pub fn solve(
        &self,
        mesh: &TetMesh,
        drive: &Drive,
        options: &Options,
        warm: &mut WarmStart,
    ) -> Result<(FlowSolution, SolverReport), StokesError> {
        let rhs = [self.system.rhs.as_slice()];
        let method = (options.solver, options.rtol);
        let mut solved = solve_system(&self.system, &rhs, method, warm, &mut None)?;
        // one right-hand side has one solution
        let (solution, report) = solved.columns.swap_remove(0);
        warm.remember(&solution);
        let mut flow = (self.system).flow_with_forces(&solution, &self.forces, drive.set)?;
        let mean = fem::mean_pressure(mesh, &flow.pressure)?;
        flow.pressure.iter_mut().for_each(|p| *p -= mean);
        let (name, residual) = (options.solver.name().to_owned(), report.true_rel_residual);
        let report = SolverReport::new(options.formulation, name, report.iterations, residual);
        Ok((flow, report))
    }
}

impl Problem<'_> {
    /// Assembles the system of one drive with terms of inertia.
    ///
    /// The matrix is that of [`Problem::assemble`] with `κ M + ρ N(c)` added, in the same
    /// formulations. With convection it is not symmetric: of the solvers only
    /// [`Solver::Block`](crate::Solver::Block) treats it.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`]; fields of the wrong length, a coefficient that is negative or
    /// not finite.
    pub fn assemble_inertial(
        &self,
        drive: &Drive,
        formulation: &dyn Formulation,
        terms: &InertialTerms,
    ) -> Result<InertialSystem, StokesError> {
        terms.check(self.mesh().n_points())?;
        let surfaces = self.nodal_surface_flow()?;
        let (mut system, forces) =
            self.assemble_terms(drive, formulation, surfaces.as_ref(), Some(terms))?;
        let no_sources = vec![0.0; self.mesh().n_vertices()];
        let of_forces = system.rhs_of_forces(&forces, &no_sources)?;
        for (rhs, force) in system.rhs.iter_mut().zip(of_forces) {
            *rhs += force;
        }
        Ok(InertialSystem { system, forces })
    }
}
