//! First guesses of Newton's method for a generalised Newtonian fluid.

use linalg::WarmStart;
use nalgebra::Vector3;
use rigid::{Constrained, Drive, ExternalLoad, RigidFluid};

use crate::StokesError;
use crate::linear::{has_convection, preconditioner, solve_near};
use crate::newton::{First, Iterate, MAX_FORCING, Momentum, Newton};
use crate::problem::fluid_matrices;
use crate::viscous_stress::{FrozenViscosity, ViscousStress};

/// Relative residual above which an earlier solution is no better start than a Newtonian flow.
const MAX_WARM_RESIDUAL: f64 = 0.5;

/// Ratio of viscosities from which on the first Newtonian flow is repeated, if loads move bodies.
const VISCOSITY_RATIO: f64 = 2.0;

/// Largest number of repetitions of the first Newtonian flow.
const MAX_NEWTONIAN_FLOWS: usize = 4;

/// Mean of `|d log η / d log g|` from which on a step with frozen viscosity follows the first
/// Newtonian flow: below it Newton's method takes as many steps with it.
const STEEP_EXPONENT: f64 = 0.4;

/// Number of bisections for the logarithm of the factor on a flow, from this largest magnitude.
const BISECTIONS: usize = 20;
const MAX_LOGARITHM: f64 = 50.0;

impl Newton<'_> {
    /// The first iterate and the scalar equations at it.
    pub fn first(&self, warm: &WarmStart) -> Result<First<'_>, StokesError> {
        let at = |(iterate, iterations): (Iterate, usize)| {
            let scalar = self.scalar(iterate.whole.clone())?;
            Ok(First {
                residual: self.residual(&scalar.system, &scalar.velocity, &iterate)?,
                iterate,
                iterations,
                scalar,
            })
        };
        let first: First<'_> = at(self.start(warm)?)?;
        match first.iterations == 0 && first.residual.largest() > MAX_WARM_RESIDUAL {
            true => at(self.start(&WarmStart::new(0))?),
            false => Ok(first),
        }
    }

    /// The first iterate with inertia, and the scalar equations at the velocity nearby.
    ///
    /// It has the viscosity of that velocity and its stress `η ∇u^T`: the combination of earlier
    /// solutions with the least residual, or if that is large, a solution of these equations.
    pub fn first_with_inertia(
        &self,
        momentum: &Momentum<'_>,
        warm: &WarmStart,
    ) -> Result<First<'_>, StokesError> {
        let near = match momentum.near {
            Some(near) => near.to_vec(),
            None => vec![Vector3::zeros(); self.problem.mesh.n_points()],
        };
        let scalar = self.scalar(near)?;
        let system = &scalar.system;
        let stress = ViscousStress {
            law: scalar.law,
            ..self.stress(&scalar.velocity)
        };
        let forces = stress.forces(&stress, &scalar.velocity)?;
        let no_sources = vec![0.0; system.system.pressure_range().len()];
        let mut rhs = system.rhs_of_forces(&forces, &no_sources)?;
        rhs.iter_mut()
            .zip(&system.rhs)
            .for_each(|(b, own)| *b += own);
        let (mut x, mut iterations) = (vec![0.0; rhs.len()], 0);
        if warm.guess(&system.system, &rhs, &mut x)? > MAX_FORCING {
            let solver = self.options.solver;
            let mut preconditioner = preconditioner(system, solver)?;
            let vectors = (rhs.as_slice(), x.as_mut_slice());
            let method = (solver, MAX_FORCING);
            iterations = solve_near(
                (&system.system, has_convection(system)),
                &mut *preconditioner,
                vectors,
                method,
            )?
            .iterations;
        }
        let iterate = self.iterate(system, x)?;
        Ok(First {
            residual: self.residual(system, &scalar.velocity, &iterate)?,
            iterate,
            iterations,
            scalar,
        })
    }

    /// The first iterate, an earlier solution or a guess, and the iterations it took.
    fn start(&self, warm: &WarmStart) -> Result<(Iterate, usize), StokesError> {
        if let Some(x) = warm.solutions().last() {
            let system = self.newtonian_system(1.0)?;
            if x.len() == system.rhs.len() {
                return Ok((self.iterate(&system, x.to_vec())?, 0));
            }
        }
        let (newtonian, iterations) = self.newtonian_flow()?;
        let stress = self.stress(&newtonian.whole);
        if stress.mean_exponent()? < STEEP_EXPONENT {
            return Ok((newtonian, iterations));
        }
        let law = FrozenViscosity {
            law: self.law,
            newtonian: stress.mean_viscosity()?,
        };
        // A guess: where its matrix cannot be solved with, the Newtonian flow is the start.
        match self.frozen_step(&law, &newtonian) {
            Ok((x, more)) => Ok((x, iterations + more)),
            Err(_) => Ok((newtonian, iterations)),
        }
    }

    /// The flow after a step with frozen viscosity from a flow, and its iterations.
    fn frozen_step(
        &self,
        law: &FrozenViscosity,
        from: &Iterate,
    ) -> Result<(Iterate, usize), StokesError> {
        let frozen = self.scalar_by(law, from.whole.clone())?;
        let residual = self.residual_by([law, law], &frozen.system, &frozen.velocity, from)?;
        let frozen = self.linearised(frozen, 1.0)?;
        let mut x = vec![0.0; from.x.len()];
        let solver = self.options.solver;
        let mut preconditioner = preconditioner(&frozen.system, solver)?;
        let vectors = (residual.rows.as_slice(), x.as_mut_slice());
        let method = (solver, MAX_FORCING);
        let report = solve_near((&frozen, false), &mut *preconditioner, vectors, method)?;
        (x.iter_mut().zip(&from.x)).for_each(|(x, before)| *x += before);
        Ok((self.iterate(&frozen.system, x)?, report.iterations))
    }

    /// A Newtonian flow, and its iterations.
    ///
    /// Where loads alone drive the flow, flows of all viscosities are multiples of one, and that of
    /// the least energy by the law is the start. Where loads and rates do, the flow is repeated
    /// with the mean viscosity until this changes little.
    fn newtonian_flow(&self) -> Result<(Iterate, usize), StokesError> {
        let constraints = self.drive.constraints;
        let is_loaded = self.loads.iter().any(|load| *load != 0.0)
            || constraints.joint_damping.iter().any(|d| *d != 0.0);
        let has_rates = self.surfaces.is_some() || constraints.rates.iter().any(|r| *r != 0.0);
        // at a rate of one per time unit, until a flow is known
        let mut viscosity = self.law.viscosity(1.0);
        if !(viscosity > 0.0 && viscosity.is_finite()) {
            return Err(StokesError::Viscosity { viscosity });
        }
        let (mut flows, mut iterations) = (0, 0);
        loop {
            let system = self.newtonian_system(viscosity)?;
            let mut x = vec![0.0; system.rhs.len()];
            let solver = self.options.solver;
            let mut preconditioner = preconditioner(&system, solver)?;
            let vectors = (system.rhs.as_slice(), x.as_mut_slice());
            let method = (solver, MAX_FORCING);
            let report = solve_near(
                (&system.system, false),
                &mut *preconditioner,
                vectors,
                method,
            )?;
            flows += 1;
            iterations += report.iterations;
            let pressure = system.system.pressure_range();
            x[pressure.clone()].iter_mut().for_each(|p| *p *= viscosity);
            let iterate = self.iterate(&system, x)?;
            if is_loaded && !has_rates {
                let factor = self.factor_of_least_energy(&iterate)?;
                let of_velocities = |(row, value): (usize, f64)| match pressure.contains(&row) {
                    true => value,
                    false => factor * value,
                };
                let x = iterate.x.into_iter().enumerate().map(of_velocities);
                return Ok((self.iterate(&system, x.collect())?, iterations));
            }
            let ratio = self.stress(&iterate.whole).mean_viscosity()? / viscosity;
            viscosity *= ratio;
            let is_near = ratio.max(ratio.recip()) <= VISCOSITY_RATIO;
            if !is_loaded || is_near || flows == MAX_NEWTONIAN_FLOWS {
                return Ok((iterate, iterations));
            }
        }
    }

    /// The positive factor on a flow by which its energy `∫ W(g) - F·q + q·Dq / 2` is least.
    fn factor_of_least_energy(&self, flow: &Iterate) -> Result<f64, StokesError> {
        let parts = self.problem.parts();
        let damping = flow
            .generalised
            .dot(&self.drive.damping_times(&flow.generalised)?);
        let power = self.loads.dot(&flow.generalised);
        let (mut low, mut high) = (-MAX_LOGARITHM, MAX_LOGARITHM);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let factor = f64::exp(middle);
            let velocity: Vec<_> = flow.whole.iter().map(|u| factor * u).collect();
            let of_fluid = self.stress(&velocity).dissipation()? / factor;
            // The energy is convex.
            match of_fluid + (factor * damping - power) / parts > 0.0 {
                true => high = middle,
                false => low = middle,
            }
        }
        Ok(f64::exp(0.5 * (low + high)))
    }

    /// Stokes flow of a viscosity: that of viscosity 1 with all loads divided by it.
    fn newtonian_system(&self, viscosity: f64) -> Result<Constrained, StokesError> {
        let mut constraints = self.drive.constraints.clone();
        constraints
            .joint_forces
            .iter_mut()
            .for_each(|force| *force /= viscosity);
        constraints
            .joint_damping
            .iter_mut()
            .for_each(|damping| *damping /= viscosity);
        (constraints.body_damping.iter_mut()).for_each(|(_, damping)| *damping /= viscosity);
        let load = |load: &ExternalLoad| ExternalLoad {
            force: load.force / viscosity,
            torque: load.torque / viscosity,
        };
        let loads: Vec<ExternalLoad> = self.drive.loads.iter().map(load).collect();
        let drive = Drive {
            set: self.drive.set,
            constraints: &constraints,
            loads: &loads,
        };
        let fluid = RigidFluid::new(
            fluid_matrices(self.newtonian.clone()),
            self.fluid_nodes(),
            &self.bodies,
        )?;
        Ok(self.options.formulation.constrain(fluid, &drive)?)
    }
}
