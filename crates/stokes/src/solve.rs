//! Solving a problem, for one or several drives, with error estimates.

use std::iter::once;
use std::time::Instant;

use fem::SurplusSpace;
use linalg::{Preconditioner, WarmStart};
use rigid::{Constrained, Drive, FlowSolution, Imposed};

use crate::StokesError;
use crate::adjoint::AdjointSolutions;
use crate::checks::{Checks, checks};
use crate::equations::{Equations, PartEquations};
use crate::estimate::{Estimate, Estimator};
use crate::linear::solve_system;
use crate::options::Options;
use crate::problem::Problem;
use crate::solution::{Dofs, Seconds, Solution, SolvedBatch, SolverReport};
use crate::surface_flow::NodalSurfaceFlow;

/// Earlier solutions on the same mesh connectivity, from which the next solves start.
#[derive(Clone)]
pub struct InitialGuesses {
    pub(crate) flows: WarmStart,
    pub(crate) adjoints: AdjointSolutions,
}

impl InitialGuesses {
    /// An empty set that will keep up to `capacity` flows, at 8 bytes per degree of freedom each.
    pub fn new(capacity: usize) -> Self {
        Self {
            flows: WarmStart::new(capacity),
            adjoints: AdjointSolutions::default(),
        }
    }

    /// Discards all guesses.
    ///
    /// Required if the degrees of freedom change, or if solutions must not depend on earlier ones.
    pub fn clear(&mut self) {
        self.flows.clear();
        self.adjoints = AdjointSolutions::default();
    }

    /// Adds the newest solution of a copy that another solve has used since.
    pub fn remember_newest_of(&mut self, other: Self) {
        if let Some(newest) = other.flows.solutions().last() {
            self.flows.remember(newest);
        }
        self.adjoints = other.adjoints;
    }
}

/// Preconditioner and initial guesses of the solves of an estimate.
pub(crate) type Solvers<'a> = (&'a mut dyn Preconditioner, &'a mut AdjointSolutions);

impl Problem<'_> {
    /// Estimates the errors of flows that several processes have solved together.
    ///
    /// Every process calls it with the same problem, drive and flows, the latter on the whole mesh.
    /// Passes over the cells and iterations are divided between the processes; integrals over the
    /// boundary and [`Checks`] are computed by each of them. Other arguments as in
    /// [`Options::estimate_rtol`].
    ///
    /// # Errors
    /// Those of [`Problem::solve_all`].
    pub fn estimate_part(
        &self,
        drive: &Drive,
        flows: &[FlowSolution],
        part: PartEquations<'_>,
        preconditioner: &mut dyn Preconditioner,
        rtol: Option<f64>,
    ) -> Result<Vec<(Estimate, Checks)>, StokesError> {
        let surfaces = self.nodal_surface_flow()?;
        let mut adjoints = AdjointSolutions::default();
        let solvers: Solvers = (preconditioner, &mut adjoints);
        self.estimates(drive, flows, surfaces.as_ref(), part.into(), solvers, rtol)
    }

    /// Estimated errors and checks of flows, by these equations.
    pub(crate) fn estimates(
        &self,
        drive: &Drive,
        flows: &[FlowSolution],
        surfaces: Option<&NodalSurfaceFlow>,
        equations: Equations<'_>,
        (preconditioner, adjoints): Solvers,
        rtol: Option<f64>,
    ) -> Result<Vec<(Estimate, Checks)>, StokesError> {
        let surface_velocity = self.surface_velocity();
        let varying = equations.varying;
        let mut facet_geometry = self.facet_geometry()?;
        if let Some(flow) = &varying {
            facet_geometry = facet_geometry.with_viscosity(flow.stress.velocity, flow.law)?;
        }
        let estimator = Estimator {
            problem: self,
            surfaces: surfaces.zip(surface_velocity.as_deref()),
            equations,
            facet_geometry: &facet_geometry,
            drive,
            rtol,
        };
        let estimates = estimator.estimates(flows, preconditioner, adjoints)?;
        (estimates.into_iter().zip(flows))
            .map(|(estimate, flow)| {
                let stress = varying.map(|flow| flow.stress);
                Ok((estimate, checks(self, flow, surfaces, stress)?))
            })
            .collect()
    }

    /// The flow of a solution for a drive, its pressure with zero mean.
    ///
    /// `imposed` are the velocities of the drive, if they are not those of the system.
    fn flow_of(
        &self,
        system: &Constrained,
        solution: &[f64],
        imposed: Option<&Imposed>,
        drive: &Drive,
    ) -> Result<FlowSolution, StokesError> {
        let mut flow = match imposed {
            None => system.flow(solution, drive.set)?,
            Some(imposed) => system.flow_at(solution, imposed, drive.set)?,
        };
        let mean = fem::mean_pressure(self.mesh, &flow.pressure)?;
        flow.pressure.iter_mut().for_each(|p| *p -= mean);
        Ok(flow)
    }

    /// Solves for one drive, with zero initial guess and without error estimate.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`]; [`StokesError::Linalg`] without convergence.
    pub fn solve(&self, drive: &Drive, options: &Options) -> Result<Solution, StokesError> {
        let drives = std::slice::from_ref(drive);
        let mut solutions = self.solve_all(drives, options, &mut InitialGuesses::new(0), None)?;
        // One drive has one solution.
        Ok(solutions.swap_remove(0))
    }

    /// Solves for several drives that differ only in the rates of the joints.
    ///
    /// Discretisation errors are estimated if `surplus`, the hierarchical surplus space of the
    /// mesh, is given. All drives share one matrix and one preconditioner,
    /// whose time is counted for the first solution.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`]; drives with other joints, values or loads than the first;
    /// [`StokesError::Linalg`] without convergence.
    pub fn solve_all(
        &self,
        drives: &[Drive],
        options: &Options,
        guesses: &mut InitialGuesses,
        surplus: Option<&SurplusSpace>,
    ) -> Result<Vec<Solution>, StokesError> {
        let Some((drive, others)) = drives.split_first() else {
            return Ok(Vec::new());
        };
        if let Some(engine) = options.engine {
            return engine.solve_all(self, drives, options, surplus);
        }
        let clock = Instant::now();
        let surfaces = self.nodal_surface_flow()?;
        let surfaces = surfaces.as_ref();
        let mut system = self.assemble_with(drive, options.formulation, surfaces)?;
        let others: Vec<Imposed> = others
            .iter()
            .map(|drive| system.imposed(drive))
            .collect::<Result<_, _>>()?;
        let assembly = clock.elapsed().as_secs_f64();
        let rhs: Vec<&[f64]> = once(&system.rhs)
            .chain(others.iter().map(|other| &other.rhs))
            .map(Vec::as_slice)
            .collect();
        let mut block = None;
        let method = (options.solver, options.rtol);
        let solved = solve_system(&system, &rhs, method, &guesses.flows, &mut block)?;
        let (mut flows, mut reports) = (Vec::new(), Vec::new());
        let imposed = once(None).chain(others.iter().map(Some));
        for ((solution, report), imposed) in solved.columns.into_iter().zip(imposed) {
            guesses.flows.remember(&solution);
            flows.push(self.flow_of(&system, &solution, imposed, drive)?);
            let name = options.solver.name().to_owned();
            let (iterations, residual) = (report.iterations, report.true_rel_residual);
            let solver = SolverReport::new(options.formulation, name, iterations, residual);
            reports.push((solver, report.error_estimate()));
        }
        if block.is_some() {
            system.free_prolongation()?;
        }
        let clock = Instant::now();
        let estimates = match surplus {
            None => Vec::new(),
            Some(space) => {
                let equations = Equations::whole(self.mesh, space, &system);
                // The block solver is fast enough for all adjoint solves: they need few digits.
                let mut preconditioner = block.map_or_else(|| system.preconditioner(), Ok)?;
                let solvers: Solvers = (&mut preconditioner, &mut guesses.adjoints);
                let rtol = options.estimate_rtol;
                self.estimates(drive, &flows, surfaces, equations, solvers, rtol)?
            }
        };
        let batch = SolvedBatch {
            flows,
            reports,
            estimates,
            seconds: Seconds {
                assembly,
                setup: solved.setup,
                solve: solved.solve,
                estimate: surplus.map_or(0.0, |_| clock.elapsed().as_secs_f64()),
                ..Seconds::default()
            },
            dofs: Dofs::of(&system),
        };
        self.solutions_with(batch, surfaces)
    }

    /// The solutions of a batch, one per flow; the first has the times of assembly and set-up.
    ///
    /// # Errors
    /// A flow that is not finite.
    pub fn solutions(&self, batch: SolvedBatch) -> Result<Vec<Solution>, StokesError> {
        self.solutions_with(batch, self.nodal_surface_flow()?.as_ref())
    }

    fn solutions_with(
        &self,
        batch: SolvedBatch,
        surfaces: Option<&NodalSurfaceFlow>,
    ) -> Result<Vec<Solution>, StokesError> {
        let seconds = batch.seconds.shared(batch.flows.len());
        let mut estimates = batch.estimates.into_iter();
        let solved = batch.flows.into_iter().zip(batch.reports).zip(seconds);
        let solution = |((flow, (solver, algebraic_error)), seconds)| {
            let (estimate, checks) = estimates.next().unzip();
            Ok(Solution {
                powers: self.surface_powers(&flow, surfaces, None)?,
                flow,
                estimate,
                checks,
                regularisation: None,
                dofs: batch.dofs,
                solver,
                algebraic_error,
                seconds,
            })
        };
        solved.map(solution).collect()
    }
}
