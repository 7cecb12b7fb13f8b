//! The problem of one step in time, or of a steady flow: Stokes flow with terms of inertia.

use std::time::Instant;

use linalg::{SolveReport, WarmStart};
use mesh::TetMesh;
use nalgebra::Vector3;
use rheology::ViscosityLaw;
use rigid::{Constrained, Drive, FlowSolution, Formulation};

use crate::StokesError;
use crate::generalised_newtonian::GeneralisedNewtonianSolution;
use crate::inertial_terms::InertialTerms;
use crate::linear::solve_system;
use crate::options::Options;
use crate::problem::Problem;
use crate::solution::{Dofs, Seconds, Solution, SolverReport};
use crate::solve::InitialGuesses;
use crate::surface_flow::NodalSurfaceFlow;
use crate::surface_power::SurfacePowers;
use crate::viscous_stress::ViscousStress;

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
    /// The pressure has zero mean over the fluid. Forces of the bodies on the fluid are residuals
    /// of the whole momentum equation, inertia included.
    ///
    /// # Errors
    /// [`StokesError::Linalg`] without convergence, or for a solver that needs a symmetric system
    /// if there is convection.
    pub fn solve(
        &self,
        mesh: &TetMesh,
        drive: &Drive,
        options: &Options,
        warm: &mut WarmStart,
    ) -> Result<(FlowSolution, SolveReport), StokesError> {
        let rhs = [self.system.rhs.as_slice()];
        let method = (options.solver, options.rtol);
        let mut solved = solve_system(&self.system, &rhs, method, warm, &mut None)?;
        // one right-hand side has one solution
        let (solution, report) = solved.columns.swap_remove(0);
        warm.remember(&solution);
        let mut flow = (self.system).flow_with_forces(&solution, &self.forces, drive.set)?;
        let mean = fem::mean_pressure(mesh, &flow.pressure)?;
        flow.pressure.iter_mut().for_each(|p| *p -= mean);
        Ok((flow, report))
    }
}

impl Problem<'_> {
    /// Solves for one drive with terms of inertia, from the solutions that `warm` has, which
    /// remembers the new one.
    ///
    /// # Errors
    /// Those of [`Problem::assemble_inertial`] and [`InertialSystem::solve`].
    pub fn solve_inertial(
        &self,
        drive: &Drive,
        options: &Options,
        terms: &InertialTerms,
        warm: &mut WarmStart,
    ) -> Result<Solution, StokesError> {
        if let Some(law) = terms.law {
            let flow = self.solve_inertial_by_law((drive, law), options, terms, warm)?;
            return Ok(flow.solution);
        }
        let clock = Instant::now();
        let system = self.assemble_inertial(drive, options.formulation, terms)?;
        let assembly = clock.elapsed().as_secs_f64();
        let (flow, report) = system.solve(self.mesh(), drive, options, warm)?;
        let total = clock.elapsed().as_secs_f64();
        let surfaces = self.nodal_surface_flow()?;
        let (name, residual) = (options.solver.name().to_owned(), report.true_rel_residual);
        Ok(Solution {
            powers: self.inertial_powers(&flow, surfaces.as_ref(), terms, None)?,
            flow,
            estimate: None,
            checks: None,
            regularisation: None,
            dofs: Dofs::of(&system.system),
            solver: SolverReport::new(options.formulation, name, report.iterations, residual),
            algebraic_error: report.error_estimate(),
            seconds: Seconds {
                assembly,
                solve: total - assembly,
                total,
                ..Seconds::default()
            },
        })
    }

    /// Assembles the system of one drive with terms of inertia.
    ///
    /// The matrix is that of [`Problem::assemble`] with `κ M + ρ N(c)` added, in the same
    /// formulations. With convection it is not symmetric: of the solvers only
    /// [`Solver::Block`](crate::Solver::Block) treats it.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`]; fields of the wrong length, a coefficient that is negative
    /// or not finite; [`StokesError::NotLinear`] for a viscosity law.
    pub fn assemble_inertial(
        &self,
        drive: &Drive,
        formulation: &dyn Formulation,
        terms: &InertialTerms,
    ) -> Result<InertialSystem, StokesError> {
        terms.check(self.mesh().n_points())?;
        if terms.law.is_some() {
            return Err(StokesError::NotLinear);
        }
        let surfaces = self.nodal_surface_flow()?;
        let (mut system, forces) =
            self.assemble_terms(drive, formulation, surfaces.as_ref(), Some(terms))?;
        system.add_forces(&forces)?;
        Ok(InertialSystem { system, forces })
    }

    /// As [`Problem::solve_inertial`], by a law in place of that of the terms, with the steps of
    /// Newton's method.
    ///
    /// ```text
    /// κ u + ρ ((c · ∇) u + (∇·d) u / 2) - ∇·(2 η(g) D(u)) + ∇p = g,   ∇·u = 0
    /// ```
    ///
    /// The equations are linearised at `near`, and again where a step leaves more than a tenth of
    /// the residual: the last matrices and their preconditioner serve until then. The steps start
    /// from the combination of earlier solutions with the least residual. `options.rtol` bounds the
    /// residual of the nonlinear equations, over the right-hand side. The effect of a
    /// regularisation of the law is not estimated: see [`Problem::effect_of_regularisation`].
    ///
    /// # Errors
    /// Those of [`Problem::assemble_inertial`] and of [`Problem::solve_generalised_newtonian`].
    pub fn solve_inertial_by_law(
        &self,
        (drive, law): (&Drive, &dyn ViscosityLaw),
        options: &Options,
        terms: &InertialTerms,
        warm: &mut WarmStart,
    ) -> Result<GeneralisedNewtonianSolution, StokesError> {
        terms.check(self.mesh().n_points())?;
        let mut guesses = InitialGuesses::new(0);
        guesses.flows = std::mem::take(warm);
        let solved = self.solve_by_law((drive, law), options, Some(terms), &mut guesses, None);
        *warm = guesses.flows;
        solved
    }

    /// Power of the slip on the fluid, `∮ s · f dS` with the forces `f` of a flow with these terms,
    /// whose stress is `stress` if the viscosity varies.
    ///
    /// By the residual of the momentum equation with the slip as the test function, so that the
    /// power of all surfaces is dissipation and rate of kinetic energy exactly.
    ///
    /// # Errors
    /// A flow that is not finite.
    pub(crate) fn inertial_powers(
        &self,
        flow: &FlowSolution,
        surfaces: Option<&NodalSurfaceFlow>,
        terms: &InertialTerms,
        stress: Option<ViscousStress>,
    ) -> Result<SurfacePowers, StokesError> {
        let Some(slip) = surfaces.and_then(|nodal| nodal.parts.first()) else {
            return Ok(SurfacePowers::default());
        };
        let u = flow.velocity.as_slice();
        // quadratic functions, and the gradient of one
        let inertia = fem::integrate(self.mesh(), 5, |point| {
            let mut rate = terms.coefficient * point.value(u);
            if let Some(convecting) = terms.convecting {
                let convected = point.gradient(u) * point.value(convecting);
                rate += terms.density * (convected + terms.half_divergence(point) * point.value(u));
            }
            if let Some(force) = terms.force {
                rate -= point.value(force);
            }
            rate.dot(&point.value(slip.as_slice()))
        })?;
        let of_stress = self.surface_powers(flow, surfaces, stress)?.slip;
        Ok(SurfacePowers {
            slip: of_stress + self.parts() * inertia,
            ..SurfacePowers::default()
        })
    }
}
