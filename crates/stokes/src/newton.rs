//! Newton's method for the flow of a generalised Newtonian fluid.

use fem::{StokesMatrices, TaylorHood};
use linalg::{LinalgError, LinearOperator, Preconditioner, WarmStart};
use nalgebra::{DVector, Vector3};
use rheology::{Law, ViscosityLaw};
use rigid::{
    Constrained, Drive, FlowSolution, FluidNodes, Inertia, NodeRole, RigidFluid, SurfaceBody,
};

use crate::StokesError;
use crate::inertial_terms::InertialTerms;
use crate::linear::{preconditioner, solve_near};
use crate::linearised::Linearised;
use crate::options::Options;
use crate::problem::Problem;
use crate::surface_flow::NodalSurfaceFlow;
use crate::viscous_stress::ViscousStress;

/// Largest number of steps; laws with indices from 0.3 take 3 to 10 (`docs/newton.md`).
const MAX_STEPS: usize = 40;

/// Relative residual of the first Newtonian flow and largest one of a linear solve.
pub(crate) const MAX_FORCING: f64 = 0.1;

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

/// Part of the residual that a step with inertia leaves from which on the equations are linearised
/// at its end: until then the matrices and the preconditioner of the last linearisation are kept.
const SLOW: f64 = 0.1;

/// Relative residual of linear solves from a flow nearby.
const FORCING_NEARBY: f64 = 1e-2;

/// Number of halvings of a step with inertia, whose residual need not decrease along it.
const MAX_HALVINGS_OF_RESIDUAL: usize = 8;

/// Largest number of damped steps: with a local exponent `n` of the stress each reduces the
/// residual by a factor of `(1 - n) / (1 + n)` only, which in plugs is nearly one.
const MAX_DAMPED: usize = 10;

/// How Newton's method converged.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct NewtonReport {
    /// The steps in their order.
    pub steps: Vec<NewtonStep>,
    /// Iterations of linear solves for the first flow, Newtonian or with the frozen viscosity of
    /// one; zero from an earlier solution. With inertia, those at the viscosity of the flow that is
    /// known nearby.
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
    /// Derivatives of the energy along the step, at its start and where it ends; zero with inertia,
    /// whose flow is the minimum of none.
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
pub(crate) struct Newton<'a> {
    pub problem: &'a Problem<'a>,
    pub law: &'a dyn ViscosityLaw,
    pub drive: &'a Drive<'a>,
    pub options: &'a Options,
    pub space: &'a TaylorHood,
    pub newtonian: StokesMatrices,
    /// Constant viscosity, for flows without motion.
    at_rest: Law,
    roles: Vec<NodeRole>,
    pub bodies: Vec<SurfaceBody>,
    permeability: Option<Vec<f64>>,
    pub surfaces: Option<NodalSurfaceFlow>,
    /// Loads on the generalised velocities.
    pub loads: DVector<f64>,
    /// Velocities of walls, one per node; none if all are at rest.
    wall_velocity: Option<&'a [Vector3<f64>]>,
    pub momentum: Option<Momentum<'a>>,
}

/// Terms of inertia, which add to the scalar matrix.
pub(crate) struct Momentum<'a> {
    inertia: Inertia,
    /// Known forces on the nodes.
    pub forces: Vec<Vector3<f64>>,
    /// A velocity near that of the flow.
    pub near: Option<&'a [Vector3<f64>]>,
    /// Whether the pressure is determined up to a constant only.
    is_enclosed: bool,
}

/// The equations with the scalar matrix of the viscosity at a velocity, without the rest of the
/// derivative: enough for a residual.
pub(crate) struct Scalar<'a> {
    pub law: &'a dyn ViscosityLaw,
    pub system: Constrained,
    pub velocity: Vec<Vector3<f64>>,
}

/// An iterate: dofs, and the flow that they stand for.
pub(crate) struct Iterate {
    pub x: Vec<f64>,
    /// Velocity of each node without the background flow.
    pub disturbance: Vec<Vector3<f64>>,
    /// Velocity of each node.
    pub whole: Vec<Vector3<f64>>,
    pub pressure: Vec<f64>,
    pub generalised: DVector<f64>,
    /// Loads of the joints, as far as they are dofs.
    pub joint_loads: DVector<f64>,
}

/// The first iterate, the linear iterations that it took, and its residual by these equations.
pub(crate) struct First<'a> {
    pub iterate: Iterate,
    pub iterations: usize,
    pub scalar: Scalar<'a>,
    pub residual: Residual,
}

/// Residual of the equations at an iterate.
pub(crate) struct Residual {
    /// Right-hand side minus products, for all dofs.
    pub rows: Vec<f64>,
    /// Its norm over that of the right-hand side, and the same with the weights of the operator.
    relative: [f64; 2],
    /// Forces on the nodes that complete the scalar matrix to the stress.
    pub forces: Vec<Vector3<f64>>,
}

impl Residual {
    pub fn largest(&self) -> f64 {
        self.relative[0].max(self.relative[1])
    }
}

impl<'a> Newton<'a> {
    /// The equations of a law for one drive, with inertia if there are `terms` of it.
    ///
    /// # Errors
    /// A velocity of surfaces or terms of inertia that are not finite.
    pub fn new(
        problem: &'a Problem<'a>,
        (law, drive): (&'a dyn ViscosityLaw, &'a Drive<'a>),
        options: &'a Options,
        space: &'a TaylorHood,
        terms: Option<&InertialTerms<'a>>,
    ) -> Result<Self, StokesError> {
        let newtonian = space.matrices(problem.mesh)?;
        let roles = problem.roles();
        let momentum = |terms: &InertialTerms<'a>| {
            let (inertia, forces) = terms.assemble(space, problem.mesh, &newtonian)?;
            Ok::<_, StokesError>(Momentum {
                inertia,
                forces,
                near: terms.near,
                is_enclosed: problem.is_closed(),
            })
        };
        let inertial = terms.filter(|terms| !terms.are_zero());
        Ok(Self {
            momentum: inertial.map(momentum).transpose()?,
            wall_velocity: terms.and_then(|terms| terms.wall_velocity),
            permeability: problem.permeability_of(&roles, &newtonian)?,
            at_rest: Law::Newtonian {
                viscosity: law.viscosity(1.0),
            },
            bodies: problem.surface_bodies()?,
            surfaces: problem.nodal_surface_flow()?,
            loads: drive.generalised_loads()?,
            problem,
            law,
            drive,
            options,
            space,
            newtonian,
            roles,
        })
    }
}

impl Newton<'_> {
    pub fn fluid_nodes(&self) -> FluidNodes<'_> {
        let mesh = self.problem.mesh;
        let mut nodes = FluidNodes::new(mesh.points(), &self.roles)
            .with_symmetry_planes(mesh.nodes_on_symmetry_planes());
        if let Some(surfaces) = &self.surfaces {
            nodes = surfaces.on_nodes(nodes, &surfaces.velocity);
        }
        match self.wall_velocity {
            Some(velocity) => nodes.with_wall_velocity(velocity),
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
    pub fn scalar(&self, velocity: Vec<Vector3<f64>>) -> Result<Scalar<'_>, StokesError> {
        let law = self.law_at(&velocity);
        self.scalar_by(law, velocity)
    }

    /// The same with another law.
    pub fn scalar_by<'l>(
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
        let inertia = self.momentum.as_ref().map(|m| m.inertia.clone());
        let mut fluid = RigidFluid::with_stress_on_nodes(matrices, inertia, nodes, &self.bodies)?;
        if let Some(permeability) = &self.permeability {
            let stiffness = stress.pressure_stiffness(self.space, permeability)?;
            fluid = fluid.with_pressure_stiffness(stiffness)?;
        }
        let mut system = self.options.formulation.constrain(fluid, self.drive)?;
        if let Some(momentum) = &self.momentum {
            system.add_forces(&momentum.forces)?;
        }
        Ok(Scalar {
            law,
            system,
            velocity,
        })
    }

    /// The linearised equations with the scalar ones and a part of the change of the viscosity,
    /// one for the derivative.
    pub fn linearised(
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

    pub fn stress<'s>(&'s self, velocity: &'s [Vector3<f64>]) -> ViscousStress<'s> {
        ViscousStress {
            mesh: self.problem.mesh,
            law: self.law,
            velocity,
        }
    }

    /// The flow of dofs of a system.
    pub fn iterate(&self, system: &Constrained, mut x: Vec<f64>) -> Result<Iterate, StokesError> {
        if self.momentum.as_ref().is_some_and(|m| m.is_enclosed) {
            // A constant that the equations do not determine would grow from step to step, and
            // residuals would drown in its rounding.
            let pressure = &mut x[system.system.pressure_range()];
            let mean = pressure.iter().sum::<f64>() / pressure.len() as f64;
            pressure.iter_mut().for_each(|p| *p -= mean);
        }
        let flow = system.flow(&x, self.drive.set)?;
        Ok(Iterate {
            x,
            whole: self.whole(&flow.velocity),
            disturbance: flow.velocity,
            pressure: flow.pressure,
            generalised: flow.generalised,
            joint_loads: flow.joint_loads,
        })
    }

    /// A velocity of the nodes with the background flow.
    pub fn whole(&self, disturbance: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        match &self.surfaces {
            None => disturbance.to_vec(),
            Some(surfaces) => (disturbance.iter().zip(&surfaces.background.0))
                .map(|(u, background)| u + background)
                .collect(),
        }
    }

    /// The residual at an iterate, by the scalar equations at any velocity.
    pub fn residual(
        &self,
        system: &Constrained,
        velocity: &[Vector3<f64>],
        iterate: &Iterate,
    ) -> Result<Residual, StokesError> {
        self.residual_by([self.law, self.law_at(velocity)], system, velocity, iterate)
    }

    /// The same with another law, and that of the scalar equations.
    pub fn residual_by(
        &self,
        [law, law_of_scalar]: [&dyn ViscosityLaw; 2],
        system: &Constrained,
        velocity: &[Vector3<f64>],
        iterate: &Iterate,
    ) -> Result<Residual, StokesError> {
        let stress = |law, velocity| ViscousStress {
            law,
            ..self.stress(velocity)
        };
        let scalar = stress(law_of_scalar, velocity);
        let forces = stress(law, &iterate.whole).forces(&scalar, &iterate.disturbance)?;
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

/// From the scale of the pressures in one system to that in another.
fn rescale(iterate: &mut Iterate, residual: &mut Residual, [from, to]: [&Constrained; 2]) {
    let ratio = from.pressure_scale() / to.pressure_scale();
    let pressure = to.system.pressure_range();
    iterate.x[pressure.clone()]
        .iter_mut()
        .for_each(|p| *p *= ratio);
    residual.rows[pressure]
        .iter_mut()
        .for_each(|row| *row /= ratio);
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
    pub fn solve(&self, warm: &mut WarmStart) -> Result<Converged, StokesError> {
        let (target, solver) = (self.options.rtol, self.options.solver);
        let First {
            mut iterate,
            iterations: first_iterations,
            scalar,
            mut residual,
        } = match &self.momentum {
            None => self.first(warm)?,
            Some(momentum) => self.first_with_inertia(momentum, warm)?,
        };
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
        let (mut forcing, mut last) = (self.first_forcing(), None);
        // Whether the equations are linearised at the iterate, and whether they must be.
        let (mut is_new, mut is_slow) = (self.momentum.is_none(), false);
        while residual.largest() > target {
            let relative = residual.largest();
            let steps = report.steps.len();
            let not_converged = || StokesError::NewtonNotConverged {
                steps,
                residual: relative,
                target,
            };
            if steps == MAX_STEPS || !relative.is_finite() {
                return Err(not_converged());
            }
            if steps > 0 && (self.momentum.is_none() || is_slow) {
                let scalar = self.scalar(iterate.whole.clone())?;
                rescale(
                    &mut iterate,
                    &mut residual,
                    [&linearised.system, &scalar.system],
                );
                linearised = self.linearised(scalar, part(&residual, steps))?;
                (last, is_new) = (None, true);
            }
            let system = &linearised.system;
            let preconditioner = match &mut last {
                Some(kept) => kept,
                None => last.insert(preconditioner(system, solver)?),
            };
            let rtol = forcing.max(LAST_FORCING * target / relative);
            let mut x = vec![0.0; residual.rows.len()];
            let vectors = (residual.rows.as_slice(), x.as_mut_slice());
            let method = (solver, rtol);
            let solved = solve_near(
                (&linearised, linearised.has_convection()),
                &mut **preconditioner,
                vectors,
                method,
            );
            let solved = solved.map_err(|error| match error {
                LinalgError::NotConverged { .. } | LinalgError::Stagnated { .. } => not_converged(),
                other => other.into(),
            })?;
            let towards = |length: f64| {
                let x = x
                    .iter()
                    .zip(&iterate.x)
                    .map(|(x, before)| before + length * x);
                self.iterate(system, x.collect())
            };
            let (length, slopes);
            (iterate, residual, length, slopes) = if self.momentum.is_none() {
                let full = towards(1.0)?;
                let (length, slopes) = self.length(&iterate, &full, (steps, relative))?;
                let next = if length == 1.0 {
                    full
                } else {
                    towards(length)?
                };
                let residual = self.residual(system, &linearised.velocity, &next)?;
                (next, residual, length, slopes)
            } else {
                match self.decreasing(&linearised, relative, &towards)? {
                    Some((next, residual, length)) => (next, residual, length, [0.0; 2]),
                    // equations linearised at another flow may lead nowhere
                    None if !is_new => (iterate, residual, 0.0, [0.0; 2]),
                    None => return Err(not_converged()),
                }
            };
            is_new = false;
            let ratio = residual.largest() / relative;
            is_slow = ratio > SLOW;
            forcing = self.forcing(ratio);
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
        let mut forces = residual.forces;
        if let Some(momentum) = &self.momentum {
            (forces.iter_mut().zip(&momentum.forces)).for_each(|(f, known)| *f += known);
        }
        let mut flow = system.flow_with_forces(&iterate.x, &forces, self.drive.set)?;
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

    fn first_forcing(&self) -> f64 {
        match self.momentum {
            None => MAX_FORCING,
            Some(_) => FORCING_NEARBY,
        }
    }

    /// Relative residual of the next linear solve after a step that left this part of the residual.
    fn forcing(&self, ratio: f64) -> f64 {
        let quadratic = FORCING_FACTOR * ratio * ratio;
        match self.momentum {
            None => quadratic.clamp(f64::MIN_POSITIVE, MAX_FORCING),
            Some(_) => quadratic.clamp(FORCING_NEARBY, MAX_FORCING),
        }
    }

    /// The iterate on the way of a step, from its end by halves, where the residual is smaller than
    /// `before`, with its residual and the fraction of the step.
    fn decreasing(
        &self,
        linearised: &Linearised,
        before: f64,
        towards: &dyn Fn(f64) -> Result<Iterate, StokesError>,
    ) -> Result<Option<(Iterate, Residual, f64)>, StokesError> {
        let mut length = 1.0;
        for _ in 0..MAX_HALVINGS_OF_RESIDUAL {
            let iterate = towards(length)?;
            let residual = self.residual(&linearised.system, &linearised.velocity, &iterate)?;
            if residual.largest() <= (1.0 - SUFFICIENT_DECREASE * length) * before {
                return Ok(Some((iterate, residual, length)));
            }
            length *= 0.5;
        }
        Ok(None)
    }
}
