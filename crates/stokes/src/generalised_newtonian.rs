//! Flow of generalised Newtonian fluids: Newton's method on the convex energy of the flow.

use std::time::Instant;

use fem::{StokesMatrices, SurplusSpace, TaylorHood, VaryingViscosity};
use linalg::{ERROR_OVER_RESIDUAL, LinalgError, LinearOperator, Preconditioner, WarmStart};
use nalgebra::{DVector, Vector3};
use rheology::{Law, ViscosityLaw};
use rigid::{
    Constrained, Drive, ExternalLoad, FlowSolution, FluidNodes, NodeRole, RigidError, RigidFluid,
    SurfaceBody,
};

use crate::StokesError;
use crate::adjoint::ADJOINT_RTOL;
use crate::equations::Equations;
use crate::linear::{Solver, preconditioner, solve_near};
use crate::linearised::{Linearised, VaryingFlow};
use crate::options::Options;
use crate::problem::{Problem, fluid_matrices};
use crate::solution::{Dofs, Regularisation, Seconds, Solution, SolverReport};
use crate::solve::{InitialGuesses, Solvers};
use crate::surface_flow::NodalSurfaceFlow;
use crate::viscous_stress::{FrozenViscosity, ViscousStress, thinning};

/// Largest number of steps; laws with indices from 0.3 take 3 to 10 (`docs/newton.md`).
const MAX_STEPS: usize = 40;

/// Relative residual of the first Newtonian flow and largest one of a linear solve.
const MAX_FORCING: f64 = 0.1;

/// Factor of the squared ratio of residuals in the forcing terms, of Eisenstat & Walker (1996),
/// choice 2, for quadratic convergence.
const FORCING_FACTOR: f64 = 0.9;

/// Fraction of the tolerance to which the last linear system is solved: a smaller residual is lost
/// on the terms of second order.
const LAST_FORCING: f64 = 0.3;

/// Fraction of the predicted decrease of the energy that a step must reach (Armijo 1966).
const SUFFICIENT_DECREASE: f64 = 1e-4;

/// Number of halvings of a step before the search along it is given up.
const MAX_HALVINGS: usize = 30;

/// Slope of the energy along a step, relative to the dissipation, below which it is rounding.
const SLOPE_OF_ROUNDING: f64 = 1e-11;

/// Relative residual above which an earlier solution is no better start than a Newtonian flow.
const MAX_WARM_RESIDUAL: f64 = 0.5;

/// Ratio of viscosities from which on the first Newtonian flow is repeated, if loads move bodies.
const VISCOSITY_RATIO: f64 = 2.0;

/// Largest number of repetitions of the first Newtonian flow.
const MAX_NEWTONIAN_FLOWS: usize = 4;

/// Mean of `|d log η / d log g|` from which on a step with frozen viscosity follows the first
/// Newtonian flow: below it Newton's method takes as many steps with it.
const STEEP_EXPONENT: f64 = 0.4;

/// Relative residual above which a step has [`DAMPED_PART`] of the change of the viscosity.
///
/// Where the first flow is too fast for its stress, as far from a body in a fluid that thins,
/// Newton's method for an index n ends at `1 - 1/n` times a large rate, frozen viscosity at its
/// power `1 - n`; with half of the change their errors cancel for the most part. Steps and all
/// linear iterations for power laws of 0.5, 0.4, 0.3, 0.2, 0.1 (a sphere in a ball of ten radii, a
/// regularisation of 1e-3): 4 (51), 4 (61), 10 (90), 12 (119), 17 (347) without and 4 (51), 5 (63),
/// 5 (76), 7 (98), 9 (157) with damping on edges of 0.4, 4 (56), 5 (70), 10 (109), 10 (134), 17
/// (301) and 4 (56), 5 (68), 6 (85), 7 (112), 16 (235) on edges of 0.2. Bounds of 0.2 and 0.3 are
/// equal, 0.1 and 0.5 take a step more for 0.1, 1.0 four for 0.3. A part of 0.4 takes up to a step
/// more, 0.6 up to three times the steps, frozen viscosity one to three steps more. Damping also
/// after steps that leave over 0.4 of the residual does not end: damped steps leave as much. The
/// idea is that of Fraters, Bangerth, Thieulot, Glerum & Spakman (Geophys. J. Int. 218, 2019).
const DAMPED_RESIDUAL: f64 = 0.25;
const DAMPED_PART: f64 = 0.5;

/// Largest number of damped steps: with a local exponent `n` of the stress each reduces the
/// residual by a factor of `(1 - n) / (1 + n)` only, which in plugs is nearly one.
const MAX_DAMPED: usize = 10;

/// Number of bisections for the logarithm of the factor on a flow, from this largest magnitude.
const BISECTIONS: usize = 20;
const MAX_LOGARITHM: f64 = 50.0;

/// How Newton's method converged.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct NewtonReport {
    /// The steps in their order.
    pub steps: Vec<NewtonStep>,
    /// Iterations of linear solves for the first flow, Newtonian or with the frozen viscosity of
    /// one; zero from an earlier solution.
    pub first_iterations: usize,
}

/// One step of Newton's method.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct NewtonStep {
    /// Relative residual of the momentum and continuity equations before the step.
    pub residual: f64,
    /// Iterations of the linear solve.
    pub iterations: usize,
    /// Relative residual of the linear solve.
    pub linear_residual: f64,
    /// Fraction of the step that was taken.
    pub length: f64,
    /// Derivatives of the energy along the step, at its start and where it ends.
    pub slopes: [f64; 2],
}

impl NewtonReport {
    /// Iterations of all linear solves.
    pub fn iterations(&self) -> usize {
        let of_steps: usize = self.steps.iter().map(|step| step.iterations).sum();
        self.first_iterations + of_steps
    }
}

/// What does not change while the equations of one drive are solved.
struct Newton<'a> {
    problem: &'a Problem<'a>,
    law: &'a dyn ViscosityLaw,
    drive: &'a Drive<'a>,
    options: &'a Options,
    space: &'a TaylorHood,
    newtonian: StokesMatrices,
    /// Constant viscosity, for flows without motion.
    at_rest: Law,
    roles: Vec<NodeRole>,
    bodies: Vec<SurfaceBody>,
    permeability: Option<Vec<f64>>,
    surfaces: Option<NodalSurfaceFlow>,
    /// Loads on the generalised velocities.
    loads: DVector<f64>,
}

/// The equations with the scalar matrix of the viscosity at a velocity, without the rest of the
/// derivative: enough for a residual.
struct Scalar<'a> {
    law: &'a dyn ViscosityLaw,
    system: Constrained,
    velocity: Vec<Vector3<f64>>,
}

/// An iterate: dofs, and the flow that they stand for.
struct Iterate {
    x: Vec<f64>,
    /// Velocity of each node without the background flow.
    disturbance: Vec<Vector3<f64>>,
    /// Velocity of each node.
    whole: Vec<Vector3<f64>>,
    pressure: Vec<f64>,
    generalised: DVector<f64>,
    /// Loads of the joints, as far as they are dofs.
    joint_loads: DVector<f64>,
}

/// Residual of the equations at an iterate.
struct Residual {
    /// Right-hand side minus products, for all dofs.
    rows: Vec<f64>,
    /// Its norm over that of the right-hand side, and the same with the weights of the operator.
    relative: [f64; 2],
    /// Forces on the nodes that complete the scalar matrix to the stress.
    forces: Vec<Vector3<f64>>,
}

impl Residual {
    fn largest(&self) -> f64 {
        self.relative[0].max(self.relative[1])
    }
}

impl Newton<'_> {
    fn fluid_nodes(&self) -> FluidNodes<'_> {
        let mesh = self.problem.mesh;
        let nodes = FluidNodes::new(mesh.points(), &self.roles)
            .with_symmetry_planes(mesh.nodes_on_symmetry_planes());
        match &self.surfaces {
            Some(surfaces) => surfaces.on_nodes(nodes, &surfaces.velocity),
            None => nodes,
        }
    }

    /// The law at a velocity of all nodes.
    ///
    /// Without motion there is no stress, whatever the viscosity; that of a power law at rest may
    /// be too large for double precision.
    fn law_at(&self, velocity: &[Vector3<f64>]) -> &dyn ViscosityLaw {
        match velocity.iter().all(|u| *u == Vector3::zeros()) {
            true => &self.at_rest,
            false => self.law,
        }
    }

    /// The scalar equations of the viscosity at a velocity of all nodes.
    fn scalar(&self, velocity: Vec<Vector3<f64>>) -> Result<Scalar<'_>, StokesError> {
        let law = self.law_at(&velocity);
        self.scalar_by(law, velocity)
    }

    /// The same with another law.
    fn scalar_by<'l>(
        &self,
        law: &'l dyn ViscosityLaw,
        velocity: Vec<Vector3<f64>>,
    ) -> Result<Scalar<'l>, StokesError> {
        let stress = ViscousStress {
            law,
            ..self.stress(&velocity)
        };
        let matrices = stress.isotropic_matrices(self.space, &self.newtonian)?;
        let nodes = self.fluid_nodes();
        let mut fluid = RigidFluid::with_stress_on_nodes(matrices, nodes, &self.bodies)?;
        if let Some(permeability) = &self.permeability {
            let stiffness = stress.pressure_stiffness(self.space, permeability)?;
            fluid = fluid.with_pressure_stiffness(stiffness)?;
        }
        Ok(Scalar {
            law,
            system: self.options.formulation.constrain(fluid, self.drive)?,
            velocity,
        })
    }

    /// The linearised equations with the scalar ones and a part of the change of the viscosity,
    /// one for the derivative.
    fn linearised(
        &self,
        Scalar {
            law,
            system,
            velocity,
        }: Scalar<'_>,
        part: f64,
    ) -> Result<Linearised, StokesError> {
        let stress = ViscousStress {
            law,
            ..self.stress(&velocity)
        };
        Ok(Linearised {
            coupling: stress.coupling(self.space, part)?,
            system,
            velocity,
        })
    }

    fn stress<'s>(&'s self, velocity: &'s [Vector3<f64>]) -> ViscousStress<'s> {
        ViscousStress {
            mesh: self.problem.mesh,
            law: self.law,
            velocity,
        }
    }

    /// The flow of dofs of a system.
    fn iterate(&self, system: &Constrained, x: Vec<f64>) -> Result<Iterate, StokesError> {
        let flow = system.flow(&x, self.drive.set)?;
        let whole = match &self.surfaces {
            None => flow.velocity.clone(),
            Some(surfaces) => (flow.velocity.iter().zip(&surfaces.background.0))
                .map(|(u, background)| u + background)
                .collect(),
        };
        Ok(Iterate {
            x,
            disturbance: flow.velocity,
            whole,
            pressure: flow.pressure,
            generalised: flow.generalised,
            joint_loads: flow.joint_loads,
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
        let residual = self.residual_by(law, &frozen.system, &frozen.velocity, from)?;
        let frozen = self.linearised(frozen, 1.0)?;
        let mut x = vec![0.0; from.x.len()];
        let solver = self.options.solver;
        let mut preconditioner = preconditioner(&frozen.system, solver)?;
        let vectors = (residual.rows.as_slice(), x.as_mut_slice());
        let method = (solver, MAX_FORCING);
        let report = solve_near(&frozen, &mut *preconditioner, vectors, method)?;
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
            let report = solve_near(&system.system, &mut *preconditioner, vectors, method)?;
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

    /// The residual at an iterate, by the scalar equations at any velocity.
    fn residual(
        &self,
        system: &Constrained,
        velocity: &[Vector3<f64>],
        iterate: &Iterate,
    ) -> Result<Residual, StokesError> {
        self.residual_by(self.law, system, velocity, iterate)
    }

    /// The same with another law, also that of the scalar equations.
    fn residual_by(
        &self,
        law: &dyn ViscosityLaw,
        system: &Constrained,
        velocity: &[Vector3<f64>],
        iterate: &Iterate,
    ) -> Result<Residual, StokesError> {
        let stress = |velocity| ViscousStress {
            law,
            ..self.stress(velocity)
        };
        let scalar = stress(velocity);
        let forces = stress(&iterate.whole).forces(&scalar, &iterate.disturbance)?;
        let no_sources = vec![0.0; system.system.pressure_range().len()];
        let of_forces = system.rhs_of_forces(&forces, &no_sources)?;
        let rhs = &system.rhs;
        let mut rows = vec![0.0; rhs.len()];
        system.system.apply(&iterate.x, &mut rows);
        for ((row, b), force) in rows.iter_mut().zip(rhs).zip(of_forces) {
            *row = b + force - *row;
        }
        let relative = |square: &dyn Fn((usize, &f64)) -> f64| {
            let size: f64 = rhs.iter().enumerate().map(square).sum();
            let residual: f64 = rows.iter().enumerate().map(square).sum();
            // without a right-hand side everything is at rest
            if residual == 0.0 {
                0.0
            } else {
                (residual / size).sqrt()
            }
        };
        let plain = relative(&|(_, v)| v * v);
        let weighted = match system.system.residual_weights() {
            None => plain,
            Some(weights) => relative(&|(row, v)| f64::from(weights[row]) * v * v),
        };
        Ok(Residual {
            relative: [plain, weighted],
            rows,
            forces,
        })
    }

    /// Fraction of the step to `to`, and the slopes of the energy at its start and its end.
    ///
    /// The energy is `∫ W(g) - F·q + q·Dq / 2`, with the loads `F` and the dashpots `D`. The
    /// pressure and the loads of the joints after the step multiply the divergence and the
    /// constraints, so that the energy decreases along the step also where linear solves leave a
    /// part of them.
    fn length(
        &self,
        from: &Iterate,
        to: &Iterate,
        state: (usize, f64),
    ) -> Result<(f64, [f64; 2]), StokesError> {
        let parts = self.problem.parts();
        let change = Change {
            velocity: (to.whole.iter().zip(&from.whole))
                .map(|(a, b)| a - b)
                .collect(),
            generalised: &to.generalised - &from.generalised,
            pressure: &to.pressure,
        };
        let damped = self.drive.damping_times(&from.generalised)?;
        let curvature = change
            .generalised
            .dot(&self.drive.damping_times(&change.generalised)?);
        let mut of_loads = (damped - &self.loads).dot(&change.generalised) / parts;
        // On symmetry planes there are loads of other constraints, which linear solves satisfy.
        let constraints = &self.drive.constraints.matrix;
        if to.joint_loads.len() == constraints.nrows() {
            let of_joints = constraints * &change.generalised;
            of_loads -= to.joint_loads.dot(&of_joints) / parts;
        }
        let stress = self.stress(&from.whole);
        let slopes = |length: f64| -> Result<[f64; 2], StokesError> {
            let [start, end] = stress.slopes(&change.velocity, change.pressure, length)?;
            Ok([
                start + of_loads,
                end + of_loads + length * curvature / parts,
            ])
        };
        let rounding = SLOPE_OF_ROUNDING * stress.dissipation()?;
        let mut length = 1.0;
        for _ in 0..MAX_HALVINGS {
            let [start, end] = slopes(length)?;
            // The energy is convex: it has decreased if it still decreases at the end.
            if end <= 0.0 || start.abs() <= rounding {
                return Ok((length, [start, end]));
            }
            let of_fluid = stress.change_of_energy(&change.velocity, change.pressure, length)?;
            let of_bodies = length * (of_loads + 0.5 * length * curvature / parts);
            if of_fluid + of_bodies <= SUFFICIENT_DECREASE * length * start {
                return Ok((length, [start, end]));
            }
            length *= 0.5;
        }
        let (steps, residual) = state;
        Err(StokesError::EnergyNotDecreasing {
            steps,
            residual,
            target: self.options.rtol,
        })
    }
}

/// A step of Newton's method: change of the flow, and the pressure at its end.
struct Change<'a> {
    velocity: Vec<Vector3<f64>>,
    generalised: DVector<f64>,
    pressure: &'a [f64],
}

/// A converged flow of a generalised Newtonian fluid.
pub(crate) struct Converged {
    /// The equations of the last step.
    pub linearised: Linearised,
    /// That of the last step; none without steps.
    pub preconditioner: Option<Box<dyn Preconditioner>>,
    pub flow: FlowSolution,
    /// Velocity of each node with the background flow.
    pub whole: Vec<Vector3<f64>>,
    pub relative_residual: [f64; 2],
    pub report: NewtonReport,
}

impl Newton<'_> {
    fn solve(&self, warm: &mut WarmStart) -> Result<Converged, StokesError> {
        let (target, solver) = (self.options.rtol, self.options.solver);
        let (mut iterate, mut first_iterations) = self.start(warm)?;
        let mut scalar = self.scalar(iterate.whole.clone())?;
        let mut residual = self.residual(&scalar.system, &scalar.velocity, &iterate)?;
        if first_iterations == 0 && residual.largest() > MAX_WARM_RESIDUAL {
            (iterate, first_iterations) = self.start(&WarmStart::new(0))?;
            scalar = self.scalar(iterate.whole.clone())?;
            residual = self.residual(&scalar.system, &scalar.velocity, &iterate)?;
        }
        // The residual decides how much of the derivative the first step has.
        let part = |residual: &Residual, steps: usize| match residual.largest() > DAMPED_RESIDUAL
            && steps < MAX_DAMPED
        {
            true => DAMPED_PART,
            false => 1.0,
        };
        let mut linearised = self.linearised(scalar, part(&residual, 0))?;
        let mut report = NewtonReport {
            steps: Vec::new(),
            first_iterations,
        };
        let (mut forcing, mut last) = (MAX_FORCING, None);
        while residual.largest() > target {
            let relative = residual.largest();
            let steps = report.steps.len();
            if steps == MAX_STEPS || !relative.is_finite() {
                return Err(StokesError::NewtonNotConverged {
                    steps,
                    residual: relative,
                    target,
                });
            }
            if steps > 0 {
                let scalar = self.scalar(iterate.whole.clone())?;
                linearised = self.linearised(scalar, part(&residual, steps))?;
            }
            let system = &linearised.system;
            let preconditioner = last.insert(preconditioner(system, solver)?);
            let rtol = forcing.max(LAST_FORCING * target / relative);
            let mut x = vec![0.0; residual.rows.len()];
            let vectors = (residual.rows.as_slice(), x.as_mut_slice());
            let method = (solver, rtol);
            let solved = solve_near(&linearised, &mut **preconditioner, vectors, method);
            let solved = solved.map_err(|error| match error {
                LinalgError::NotConverged { .. } | LinalgError::Stagnated { .. } => {
                    StokesError::NewtonNotConverged {
                        steps,
                        residual: relative,
                        target,
                    }
                }
                other => other.into(),
            })?;
            let towards = |length: f64| {
                let x = x
                    .iter()
                    .zip(&iterate.x)
                    .map(|(x, before)| before + length * x);
                self.iterate(system, x.collect())
            };
            let full = towards(1.0)?;
            let (length, slopes) = self.length(&iterate, &full, (steps, relative))?;
            iterate = if length == 1.0 {
                full
            } else {
                towards(length)?
            };
            residual = self.residual(system, &linearised.velocity, &iterate)?;
            let ratio = residual.largest() / relative;
            forcing = (FORCING_FACTOR * ratio * ratio).clamp(f64::MIN_POSITIVE, MAX_FORCING);
            report.steps.push(NewtonStep {
                residual: relative,
                iterations: solved.iterations,
                linear_residual: solved.true_rel_residual,
                length,
                slopes,
            });
        }
        warm.remember(&iterate.x);
        let system = &linearised.system;
        let mut flow = system.flow_with_forces(&iterate.x, &residual.forces, self.drive.set)?;
        let mean = fem::mean_pressure(self.problem.mesh, &flow.pressure)?;
        flow.pressure.iter_mut().for_each(|p| *p -= mean);
        Ok(Converged {
            linearised,
            preconditioner: last,
            flow,
            whole: iterate.whole,
            relative_residual: residual.relative,
            report,
        })
    }
}

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
        solve_near(at, preconditioner, (&rhs, &mut x), method)?;
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
        if options.engine.is_some() {
            return Err(StokesError::EngineOfNewtonianFluids);
        }
        let clock = Instant::now();
        let new_space;
        let space = match self.space {
            Some(space) => space,
            None => {
                new_space = TaylorHood::new(self.mesh)?;
                &new_space
            }
        };
        let newtonian = space.matrices(self.mesh)?;
        let roles = self.roles();
        let newton = Newton {
            problem: self,
            law,
            drive,
            options,
            space,
            permeability: self.permeability_of(&roles, &newtonian)?,
            newtonian,
            at_rest: Law::Newtonian {
                viscosity: law.viscosity(1.0),
            },
            roles,
            bodies: self.surface_bodies()?,
            surfaces: self.nodal_surface_flow()?,
            loads: drive.generalised_loads()?,
        };
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
        let powers = self.surface_powers(&flow, surfaces, Some(stress))?;
        let mut flows = vec![flow];
        let (mut estimates, mut regularisation) = (Vec::new(), None);
        if let Some(space) = surplus {
            let of_rate = |rate: f64| [law.viscosity(rate), thinning(law, rate)];
            let viscosity = VaryingViscosity::new(self.mesh, &whole, &of_rate)?;
            let at = VaryingFlow {
                equations: &linearised,
                stress,
                viscosity: &viscosity,
                law: &of_rate,
            };
            // As for Newtonian fluids, adjoint solves need few digits.
            let mut block = match last {
                Some(block) if options.solver == Solver::Block => block,
                _ => Box::new(linearised.system.preconditioner()?),
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
}
