//! Flow of generalised Newtonian fluids, with error estimates and the effect of a regularisation.

use std::time::Instant;

use fem::{SurplusSpace, VaryingViscosity};
use linalg::{ERROR_OVER_RESIDUAL, LinalgError, Preconditioner};
use nalgebra::Vector3;
use rheology::ViscosityLaw;
use rigid::{Drive, FlowSolution, RigidError};

use crate::StokesError;
use crate::adjoint::ADJOINT_RTOL;
use crate::equations::Equations;
use crate::inertial_terms::InertialTerms;
use crate::linear::{Solver, solve_near};
use crate::linearised::{Linearised, VaryingFlow};
use crate::newton::{Converged, Newton, NewtonReport};
use crate::options::Options;
use crate::problem::Problem;
use crate::solution::{Dofs, Regularisation, Seconds, Solution, SolverReport};
use crate::solve::{InitialGuesses, Solvers};
use crate::viscous_stress::thinning;

impl Newton<'_> {
    /// First-order change of the converged flow by the part of the stress that the law lacks
    /// because of its regularisation; none if it has none.
    fn regularisation(
        &self,
        at: &Linearised,
        whole: &[Vector3<f64>],
        preconditioner: &mut dyn Preconditioner,
    ) -> Result<Option<Regularisation>, StokesError> {
        let missing = |rate: f64| {
            let missing = self.law.unregularised_viscosity(rate) - self.law.viscosity(rate);
            // The stress is what is bounded at rest, where a power law has no viscosity.
            if rate > 0.0 && missing.is_finite() {
                missing
            } else {
                0.0
            }
        };
        let stress = self.stress(whole);
        let forces = stress.forces_of(&missing)?;
        if forces.iter().all(|force| *force == Vector3::zeros()) {
            return Ok(None);
        }
        let no_sources = vec![0.0; at.system.system.pressure_range().len()];
        let rhs = at.system.rhs_of_forces(&forces, &no_sources)?;
        let mut x = vec![0.0; rhs.len()];
        let method = (Solver::Block, ADJOINT_RTOL);
        solve_near(
            (at, at.has_convection()),
            preconditioner,
            (&rhs, &mut x),
            method,
        )?;
        Ok(Some(Regularisation {
            change: at.change(&x, &forces, self.drive.set)?,
            power: self.problem.parts() * stress.power_of(&|rate| missing(rate).abs())?,
        }))
    }
}

/// The flow of a generalised Newtonian fluid, with the steps that led to it.
#[non_exhaustive]
pub struct GeneralisedNewtonianSolution {
    /// Velocities, forces, pressure; the iterations of its solver are those of all steps.
    pub solution: Solution,
    /// The steps of Newton's method.
    pub newton: NewtonReport,
    /// Dissipation `∫ η g^2` in the whole fluid, with the background flow.
    pub dissipation: f64,
}

impl Problem<'_> {
    /// Solves for one drive in a generalised Newtonian fluid, from the newest earlier solution.
    ///
    /// ```text
    /// -∇·(2 η(g) D(u)) + ∇p = 0,   ∇·u = 0,   g = sqrt(2 D:D)
    /// ```
    ///
    /// The flow is the minimum of the convex energy `∫ W(g) - F·q` over velocities free of
    /// divergence that satisfy the joints, with the potential `W` of the law. Newton's method
    /// starts from the newest of `guesses`, or from a Newtonian flow; where viscosities vary much,
    /// a step with frozen viscosity comes first, at rates between those of this flow and those at
    /// which the law has its stresses, and steps far from the solution have half of the change of
    /// the viscosity. A step is shortened until it decreases the energy. Linear
    /// systems are solved as accurately as the convergence is quadratic (Eisenstat & Walker 1996),
    /// with the preconditioner of the isotropic part. `options.rtol` bounds the residual of the
    /// nonlinear equations, over the right-hand side. Forces are residuals of the momentum equation
    /// with the stress of the law.
    ///
    /// Cost: per step an assembly of 3 x 3 blocks, and 2 to 20 iterations.
    ///
    /// # Errors
    /// Those of [`Problem::assemble`]; [`StokesError::NewtonNotConverged`],
    /// [`StokesError::EnergyNotDecreasing`], [`StokesError::Linalg`] without convergence;
    /// [`StokesError::SlowFlow`], [`StokesError::EngineOfNewtonianFluids`].
    pub fn solve_generalised_newtonian(
        &self,
        drive: &Drive,
        law: &dyn ViscosityLaw,
        options: &Options,
        guesses: &mut InitialGuesses,
        surplus: Option<&SurplusSpace>,
    ) -> Result<GeneralisedNewtonianSolution, StokesError> {
        self.solve_by_law((drive, law), options, None, guesses, surplus)
    }

    /// The flow of a law without or with terms of inertia, with error estimates without.
    pub(crate) fn solve_by_law(
        &self,
        (drive, law): (&Drive, &dyn ViscosityLaw),
        options: &Options,
        terms: Option<&InertialTerms>,
        guesses: &mut InitialGuesses,
        surplus: Option<&SurplusSpace>,
    ) -> Result<GeneralisedNewtonianSolution, StokesError> {
        if options.engine.is_some() {
            return Err(StokesError::EngineOfNewtonianFluids);
        }
        let clock = Instant::now();
        let mut new_space = None;
        let space = self.space_or_new(&mut new_space)?;
        let newton = Newton::new(self, (law, drive), options, space, terms)?;
        let Converged {
            linearised,
            preconditioner: last,
            flow,
            whole,
            relative_residual: [residual, weighted],
            report,
        } = (newton.solve(&mut guesses.flows)).map_err(|error| match error {
            // The stiffness has the viscosity as a factor, the divergence has not.
            StokesError::Rigid(RigidError::Linalg(LinalgError::Unbalanced { ratio })) => {
                StokesError::SlowFlow {
                    viscosity: ratio.recip(),
                }
            }
            other => other,
        })?;
        let solved = clock.elapsed().as_secs_f64();
        let stress = newton.stress(&whole);
        let surfaces = newton.surfaces.as_ref();
        let powers = match terms {
            None => self.surface_powers(&flow, surfaces, Some(stress))?,
            Some(terms) => self.inertial_powers(&flow, surfaces, terms, Some(stress))?,
        };
        let mut flows = vec![flow];
        let (mut estimates, mut regularisation) = (Vec::new(), None);
        if let Some(space) = surplus {
            // As for Newtonian fluids, adjoint solves need few digits.
            let mut block = match last {
                Some(block) if options.solver == Solver::Block => block,
                _ => Box::new(linearised.system.preconditioner()?),
            };
            let of_rate = |rate: f64| [law.viscosity(rate), thinning(law, rate)];
            let viscosity = VaryingViscosity::new(self.mesh, &whole, &of_rate)?;
            let at = VaryingFlow {
                equations: &linearised,
                stress,
                viscosity: &viscosity,
                law: &of_rate,
            };
            let equations = Equations::linearised(self.mesh, space, at);
            let solvers: Solvers = (&mut *block, &mut guesses.adjoints);
            let rtol = options.estimate_rtol;
            estimates = self.estimates(drive, &flows, surfaces, equations, solvers, rtol)?;
            regularisation = newton.regularisation(&linearised, &whole, &mut *block)?;
        }
        let (estimate, checks) = estimates.pop().unzip();
        let flow = flows.swap_remove(0);
        let dissipation = self.parts() * stress.dissipation()?;
        let (name, iterations) = (options.solver.name().to_owned(), report.iterations());
        let total = clock.elapsed().as_secs_f64();
        let solution = Solution {
            powers,
            flow,
            estimate,
            checks,
            regularisation,
            dofs: Dofs::of(&linearised.system),
            solver: SolverReport::new(options.formulation, name, iterations, residual),
            algebraic_error: ERROR_OVER_RESIDUAL * weighted,
            seconds: Seconds {
                solve: solved,
                estimate: total - solved,
                total,
                ..Seconds::default()
            },
        };
        Ok(GeneralisedNewtonianSolution {
            solution,
            newton: report,
            dissipation,
        })
    }

    /// First-order effect of the regularisation of a law on a steady flow with terms of inertia;
    /// none of a law without one, or where nothing moves.
    ///
    /// The equations are linearised at `flow`, their convecting velocity is that of `terms`. Cost:
    /// an assembly and a solve.
    ///
    /// # Errors
    /// Those of [`Problem::assemble_inertial`]; [`StokesError::Linalg`] without convergence.
    pub fn effect_of_regularisation(
        &self,
        (drive, law): (&Drive, &dyn ViscosityLaw),
        options: &Options,
        terms: &InertialTerms,
        flow: &FlowSolution,
    ) -> Result<Option<Regularisation>, StokesError> {
        terms.check(self.mesh.n_points())?;
        let mut new_space = None;
        let space = self.space_or_new(&mut new_space)?;
        let newton = Newton::new(self, (law, drive), options, space, Some(terms))?;
        let whole = newton.whole(&flow.velocity);
        let at = newton.linearised(newton.scalar(whole.clone())?, 1.0)?;
        let mut block = at.system.preconditioner()?;
        newton.regularisation(&at, &whole, &mut block)
    }
}
