//! Steps in time of bodies on the axis of a fluid with inertia.

use linalg::{StepControl, TimeDerivative, extrapolation};
use nalgebra::DMatrix;

use super::bodies::{AxialBody, check, check_growth, check_length, domain, motions, shapes};
use super::flow_system::{
    Balance, BoundaryVelocity, Fields, FlowSystem, MAX_CHORD_REDUCTION, Terms,
};
use super::flow_transfer::{FlowTransfer, Level};
use super::forcing::AxialForcing;
use super::mesh_motion::MeshMotion;
use super::momentum::Coefficients;
use super::nested_condensation::CondensedFactors;
use super::transient_parameters::{Convection, TransientParameters};
use super::viscosity::Viscosity;
use crate::curve::Point;
use crate::generate::generate;
use crate::meridian::Meridian;
use crate::solver::MAX_ORDER;
use crate::surface_modes::normal;
use crate::{AxialSpheroid, AxisymmetricError, Surroundings};

/// A step, before it is accepted.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct AxialStep {
    /// Time at its end.
    pub time: f64,
    /// Its length.
    pub length: f64,
    /// Position of the centre of each body at its end.
    pub positions: Vec<f64>,
    /// Velocity of each body along the axis at its end.
    pub velocities: Vec<f64>,
    /// Force that each body exerts on the fluid, with the inertia of the fluid in it.
    pub forces: Vec<f64>,
    /// Acceleration of each body along the axis, by the difference formula.
    pub accelerations: Vec<f64>,
    /// Rate of change of the momentum of each body.
    pub momentum_rates: Vec<f64>,
    /// Power of the slip of all surfaces on the fluid.
    pub slip_power: f64,
    /// Estimated error of the velocities in this step, relative to the largest velocity so far;
    /// infinite if there are too few levels for an estimate.
    pub error: f64,
    /// The same error, not relative; infinite as `error`.
    pub flow_error: f64,
    /// Estimated error of the velocities of bodies in this step; infinite as `error`.
    pub velocity_error: f64,
    /// Change of the momentum of the fluid over its density by a new mesh before this step, an
    /// error of the projection; none on the mesh of the step before.
    pub momentum_jump: Option<f64>,
    /// Iterations of the step.
    pub iterations: usize,
    level: Level,
}

/// Integrates the motion of bodies on the axis of a fluid with inertia, by BDF2 with variable
/// steps.
///
/// All terms of a step are assembled on the mesh at its end, where the velocities of earlier times
/// are carried by their nodes and the velocity of the mesh is the same difference formula of the
/// positions of the nodes (Fehn, Heinz, Wall, Kronbichler 2021). A step is solved by Newton's
/// method, in which the mesh follows the velocities of the bodies; its factors are kept for the
/// next steps as long as they serve. Fluid, bodies and their masses are one system: light bodies
/// need no other steps than heavy ones.
///
/// ```
/// use axisymmetric::{AxialBody, AxialForcing, AxialIntegrator, AxialSpheroid, Surroundings};
/// use axisymmetric::TransientParameters;
///
/// /// A constant force, the drag at speed 1 in unbounded Stokes flow.
/// struct Pull;
///
/// impl AxialForcing for Pull {
///     fn load(&self, _time: f64, _body: usize) -> f64 {
///         6.0 * std::f64::consts::PI
///     }
/// }
///
/// // A sphere of density 2 in fluid of density 1, before it has moved.
/// let sphere = AxialBody::free(AxialSpheroid::sphere(0.0, 1.0), 2.0, 0);
/// let parameters = TransientParameters::new(1.0).with_frozen_mesh();
/// let ball = Surroundings::Ball { radius: 10.0 };
/// let mut run = AxialIntegrator::from_rest(&[sphere], ball, &Pull, parameters, 0.0)?;
/// run.advance_to(0.1, 1e-4, 1e-5, |_| {})?;
/// // 0.1161 in unbounded fluid, with Basset's history force
/// assert!((run.velocities()[0] - 0.1159380123).abs() < 1e-4);
/// # Ok::<(), axisymmetric::AxisymmetricError>(())
/// ```
pub struct AxialIntegrator<'a> {
    /// The bodies where they were when the mesh was generated.
    pub(super) bodies: Vec<AxialBody>,
    pub(super) surroundings: Surroundings,
    forcing: &'a dyn AxialForcing,
    pub(super) parameters: TransientParameters<'a>,
    pub(super) system: FlowSystem,
    pub(super) motion: MeshMotion,
    motions: Vec<Option<usize>>,
    n_motions: usize,
    /// Displacements given when the mesh was generated.
    pub(super) start: Vec<f64>,
    /// The newest first, three at most.
    pub(super) levels: Vec<Level>,
    pub(super) factors: Option<CondensedFactors>,
    /// Coefficient of the newest level in the difference formula of the factors.
    factored_at: f64,
    /// Largest velocity of the fluid so far.
    pub(super) largest: f64,
    /// That of the projection onto the present mesh, until a step is accepted on it.
    pub(super) momentum_jump: Option<f64>,
    pub(super) meshes: usize,
}

/// Levels that BDF2 and its error estimate need.
pub(super) const LEVELS: usize = 3;

impl<'a> AxialIntegrator<'a> {
    /// Starts from rest at time `time`, with the bodies where their shapes are.
    ///
    /// A cylinder is closed by plane ends 4.5 radii beyond the bodies at the start.
    ///
    /// # Errors
    /// [`AxisymmetricError::NoContainer`], numbers out of range, and domains that cannot be meshed.
    pub fn from_rest(
        bodies: &[AxialBody],
        surroundings: Surroundings,
        forcing: &'a dyn AxialForcing,
        parameters: TransientParameters<'a>,
        time: f64,
    ) -> Result<Self, AxisymmetricError> {
        check("the density of the fluid", parameters.density)?;
        check_growth(parameters.growth)?;
        if !(parameters.tolerance > 0.0 && parameters.tolerance < 1.0) {
            return Err(AxisymmetricError::InvalidNumber {
                what: "the tolerance of a step",
                value: parameters.tolerance,
                range: "between 0 and 1",
            });
        }
        if !(2..=MAX_ORDER).contains(&parameters.order) {
            return Err(AxisymmetricError::InvalidNumber {
                what: "the order of the elements",
                value: parameters.order as f64,
                range: "between 2 and 10",
            });
        }
        let (motions, n_motions) = motions(bodies);
        let system = system_around(bodies, surroundings, &parameters)?;
        let start: Vec<f64> = (0..bodies.len())
            .map(|body| forcing.displacement(time, body))
            .collect();
        let level = Level {
            time,
            nodes: system.positions(),
            fields: system.rest(),
            displacements: vec![0.0; n_motions],
            given: start.clone(),
            velocities: vec![0.0; bodies.len()],
        };
        Ok(Self {
            motion: MeshMotion::new(&system, bodies.len())?,
            bodies: bodies.to_vec(),
            surroundings,
            forcing,
            parameters,
            system,
            motions,
            n_motions,
            start,
            levels: vec![level],
            factors: None,
            factored_at: 0.0,
            largest: 0.0,
            momentum_jump: None,
            meshes: 1,
        })
    }

    /// Replaces the velocity at the present time by that without inertia of fluid and bodies,
    /// Stokes flow with these rates of the given displacements. Earlier levels are forgotten.
    ///
    /// # Errors
    /// A list of the wrong length, those of a step.
    pub fn start_from_stokes(&mut self, rates: &[f64]) -> Result<(), AxisymmetricError> {
        check_length("rates of displacements", self.bodies.len(), rates.len())?;
        self.restart();
        let time = self.time();
        let boundary = BoundaryVelocity {
            bodies: rates.to_vec(),
            slip: self.slip(time)?,
            wall: self.forcing.wall_velocity(time),
        };
        let mut balance = self.no_balance();
        for (number, g) in self.motions.iter().enumerate() {
            if let Some(g) = g {
                balance.load[*g] += self.forcing.load(time, number);
            }
        }
        let mut fields = self.system.rest();
        self.system.set_boundary(&boundary, &mut fields);
        let (nodes, tolerance) = (&self.levels[0].nodes, self.parameters.tolerance);
        let newtonian = Terms::default();
        let (_, mut change) = (self.system).solve(
            nodes,
            &mut fields,
            &newtonian,
            &balance,
            &mut None,
            tolerance,
        )?;
        if self.parameters.law.is_some() {
            let terms = Terms {
                coefficients: Coefficients {
                    viscosity: self.viscosity(),
                    ..Coefficients::default()
                },
                ..newtonian
            };
            (_, change, _) =
                (self.system).minimise(nodes, &mut fields, &terms, &balance, true, tolerance)?;
        }
        if change > tolerance {
            return Err(AxisymmetricError::StepFailed {
                time,
                step: 0.0,
                change,
            });
        }
        let level = &mut self.levels[0];
        level.velocities = self.system.body_velocities(&fields, &boundary);
        level.fields = fields;
        Ok(())
    }

    /// Forgets all levels but the present one: for corners of a motion, after which derivatives
    /// jump.
    pub fn restart(&mut self) {
        self.levels.truncate(1);
    }

    /// The present time.
    pub fn time(&self) -> f64 {
        self.levels[0].time
    }

    /// Present positions of the centres of the bodies.
    pub fn positions(&self) -> Vec<f64> {
        self.centres(&self.levels[0].displacements, &self.levels[0].given)
    }

    /// The bodies with their centres at these positions.
    pub(super) fn bodies_at(&self, centres: &[f64]) -> Vec<AxialBody> {
        let mut bodies = self.bodies.clone();
        for (body, centre) in bodies.iter_mut().zip(centres) {
            body.shape.centre = *centre;
        }
        bodies
    }

    /// Number of meshes so far.
    pub fn meshes(&self) -> usize {
        self.meshes
    }

    /// Number of degrees of freedom of a step.
    pub fn dofs(&self) -> usize {
        self.system.n_dofs()
    }

    /// Present velocities of the bodies.
    pub fn velocities(&self) -> &[f64] {
        &self.levels[0].velocities
    }

    /// Kinetic energy of the fluid at the present time, `ρ/2 ∫ |u|²`, and of the bodies.
    ///
    /// # Errors
    /// None for a step that was accepted.
    pub fn kinetic_energy(&self) -> Result<[f64; 2], AxisymmetricError> {
        let level = &self.levels[0];
        let square = (self.system).square_integral(&level.nodes, &level.fields)?;
        let bodies = self.bodies.iter().zip(&level.velocities);
        let bodies: f64 = bodies.map(|(body, u)| 0.5 * body.mass * u * u).sum();
        Ok([0.5 * self.parameters.density * square, bodies])
    }

    /// Part of the forces that the bodies exert on the fluid which is due to their accelerations at
    /// the end of a step: see [`added_mass`](crate::added_mass).
    ///
    /// Cost: a factorisation with a number per velocity node, a tenth of that of a step.
    ///
    /// # Errors
    /// None for a step of this integrator.
    pub fn added_mass_forces(&self, step: &AxialStep) -> Result<Vec<f64>, AxisymmetricError> {
        let accelerations =
            DMatrix::from_column_slice(step.accelerations.len(), 1, &step.accelerations);
        let forces = self.system.added_mass(&step.level.nodes, &accelerations)?;
        Ok(forces
            .iter()
            .map(|force| self.parameters.density * force)
            .collect())
    }

    /// Smallest semi-axis of a body.
    fn smallest(&self) -> f64 {
        (self.bodies.iter())
            .map(|body| body.shape.axial.min(body.shape.equatorial))
            .fold(f64::INFINITY, f64::min)
    }

    /// Displacements of the bodies from where they were when the mesh was generated.
    fn displacements(&self, free: &[f64], given: &[f64]) -> Vec<f64> {
        let of_motion = |g: &Option<usize>| g.map_or(0.0, |g| free[g]);
        (self.motions.iter().zip(given).zip(&self.start))
            .map(|((g, given), start)| of_motion(g) + given - start)
            .collect()
    }

    fn centres(&self, free: &[f64], given: &[f64]) -> Vec<f64> {
        (self.bodies.iter().zip(self.displacements(free, given)))
            .map(|(body, displacement)| body.shape.centre + displacement)
            .collect()
    }

    /// Lengths of the steps between the levels, the last one first.
    fn steps_before(&self) -> Vec<f64> {
        let pairs = self.levels.windows(2);
        pairs.map(|pair| pair[0].time - pair[1].time).collect()
    }

    /// Sum over the older levels of the formula, `sum_k c_k v_k / Δt`, of several values.
    fn known<T>(&self, formula: &TimeDerivative, values: impl Fn(&Level) -> Vec<T>) -> Vec<T>
    where
        T: Copy + std::ops::Mul<f64, Output = T> + std::ops::AddAssign,
    {
        self.sum(&[formula.older(1), formula.older(2)], values)
    }

    /// Sum over the levels with these weights, the newest first.
    fn sum<T>(&self, weights: &[f64], values: impl Fn(&Level) -> Vec<T>) -> Vec<T>
    where
        T: Copy + std::ops::Mul<f64, Output = T> + std::ops::AddAssign,
    {
        let mut levels = self.levels.iter().zip(weights);
        let Some((first, weight)) = levels.next() else {
            return Vec::new();
        };
        let mut sum: Vec<T> = values(first).into_iter().map(|v| v * *weight).collect();
        for (level, weight) in levels {
            for (sum, v) in sum.iter_mut().zip(values(level)) {
                *sum += v * *weight;
            }
        }
        sum
    }

    /// Takes a step of this length from the present time, without accepting it.
    ///
    /// Where the mesh cannot follow the bodies any further, there is a new one.
    ///
    /// # Errors
    /// [`AxisymmetricError::StepFailed`], a length that is not positive, bodies that meet, a step
    /// so long that a new mesh cannot follow it ([`AxisymmetricError::MeshLost`]).
    pub fn try_step(&mut self, length: f64) -> Result<AxialStep, AxisymmetricError> {
        if !(length > 0.0 && length.is_finite()) {
            return Err(AxisymmetricError::InvalidNumber {
                what: "the length of a step",
                value: length,
                range: "positive",
            });
        }
        let is_lost = |error: &AxisymmetricError| {
            use AxisymmetricError::{InvertedTriangle, MeshLost};
            matches!(error, MeshLost { .. } | InvertedTriangle { .. })
        };
        match self.step_on_mesh(length) {
            Err(error) if is_lost(&error) => self.renew_mesh()?,
            result => return result,
        }
        match self.step_on_mesh(length) {
            Err(error) if is_lost(&error) => Err(AxisymmetricError::MeshLost {
                time: self.time(),
                step: length,
            }),
            result => result,
        }
    }

    /// A step on the present mesh.
    fn step_on_mesh(&mut self, length: f64) -> Result<AxialStep, AxisymmetricError> {
        let before = self.steps_before();
        let formula = TimeDerivative::new(length, &before);
        let (time, newest) = (self.time() + length, formula.newest());
        let n = self.bodies.len();
        let given: Vec<f64> = (0..n).map(|b| self.forcing.displacement(time, b)).collect();
        let known_given = self.known(&formula, |level| level.given.clone());
        let rates = (given.iter().zip(known_given)).map(|(d, known)| newest * d + known);
        let rates: Vec<f64> = rates.collect();
        if let Some(&value) = rates.iter().find(|rate| !rate.is_finite()) {
            return Err(AxisymmetricError::InvalidNumber {
                what: "the displacement of a body",
                value,
                range: "finite",
            });
        }
        let balance = self.balance(&formula, time, &rates);
        let density = self.parameters.density;
        let history: Vec<Point> = self
            .known(&formula, |level| level.fields.velocity.clone())
            .into_iter()
            .map(|u| density * u)
            .collect();
        let known_nodes = self.known(&formula, |level| level.nodes.clone());
        let known_displacements = self.known(&formula, |level| level.displacements.clone());
        let weights = extrapolation(length, &before);
        let predicted = Fields {
            velocity: self.sum(&weights, |level| level.fields.velocity.clone()),
            motions: self.sum(&weights, |level| level.fields.motions.clone()),
            pressure: self.levels[0].fields.pressure.clone(),
        };
        let predicted_velocities = self.sum(&weights, |level| level.velocities.clone());
        let boundary = BoundaryVelocity {
            bodies: rates,
            slip: self.slip(time)?,
            wall: self.forcing.wall_velocity(time),
        };
        let fixed_terms = Terms {
            coefficients: Coefficients {
                convection: match self.parameters.convection {
                    Convection::Full => density,
                    Convection::Neglected => 0.0,
                },
                mass: density * newest,
                viscosity: self.viscosity(),
            },
            mesh_velocity: None,
            history: Some(&history),
        };
        // x_new from the velocity, by the formula of the step
        let displaced = |fields: &Fields| -> Vec<f64> {
            let motions = fields.motions.iter().zip(&known_displacements);
            motions.map(|(u, known)| (u - known) / newest).collect()
        };
        let is_near = |at: f64| (newest / at).max(at / newest) <= MAX_COEFFICIENT_RATIO;
        let mut factors = (self.factors.take()).filter(|_| is_near(self.factored_at));
        if factors.is_none() {
            self.factored_at = newest;
        }
        let mut fields = predicted.clone();
        self.system.set_boundary(&boundary, &mut fields);
        let mut displacements = displaced(&fields);
        let (mut last, mut iterations) = (f64::INFINITY, 0);
        let smallest = self.smallest();
        let (nodes, mesh_velocity) = loop {
            let nodes = match self.parameters.frozen {
                true => self.levels[0].nodes.clone(),
                false => self.nodes(length, &displacements, &given)?,
            };
            let mesh_velocity: Vec<f64> = match self.parameters.frozen {
                true => vec![0.0; nodes.len()],
                false => (nodes.iter().zip(&known_nodes))
                    .map(|(x, known)| newest * x.x + known.x)
                    .collect(),
            };
            let terms = Terms {
                mesh_velocity: Some(&mesh_velocity),
                ..fixed_terms
            };
            let change =
                self.system
                    .iterate(&nodes, &mut fields, &terms, &balance, &mut factors)?;
            iterations += 1;
            let next = displaced(&fields);
            let shift = (next.iter().zip(&displacements))
                .map(|(new, old)| (new - old).abs() / smallest)
                .fold(0.0, f64::max);
            displacements = next;
            // What is left converges like this iteration at least (Hairer & Wanner 1996, IV.8).
            let rate = if last.is_finite() { change / last } else { 1.0 };
            let left = if rate < 0.5 { rate / (1.0 - rate) } else { 1.0 };
            let tolerance = self.parameters.tolerance;
            if left * change <= tolerance && (self.parameters.frozen || left * shift <= tolerance) {
                break (nodes, mesh_velocity);
            }
            if !change.is_finite() || iterations == MAX_ITERATIONS {
                return Err(AxisymmetricError::StepFailed {
                    time: self.time(),
                    step: length,
                    change,
                });
            }
            if change > MAX_CHORD_REDUCTION * last {
                factors = None;
                self.factored_at = newest;
            }
            last = change;
        };
        let terms = Terms {
            mesh_velocity: Some(&mesh_velocity),
            ..fixed_terms
        };
        let residual = self.system.residual(&nodes, &fields, &terms)?;
        let forces = self.system.forces(&residual);
        let slip_power = match boundary.slip.is_empty() {
            true => 0.0,
            false => (self.system)
                .surface_forces(residual, &nodes, &fields, &terms)?
                .power(&boundary.slip),
        };
        self.factors = factors;
        let velocities = self.system.body_velocities(&fields, &boundary);
        let largest =
            (fields.velocity.iter()).fold(self.largest, |largest, u| largest.max(u.amax()));
        let difference = (fields.velocity.iter().zip(&predicted.velocity))
            .map(|(u, p)| (u - p).amax())
            .fold(0.0, f64::max);
        let flow_error = match formula.error_factor {
            0.0 => f64::INFINITY,
            factor => factor * difference,
        };
        let error = if flow_error == 0.0 {
            0.0
        } else {
            flow_error / largest
        };
        let of_bodies = (velocities.iter().zip(&predicted_velocities))
            .map(|(u, p)| (u - p).abs())
            .fold(0.0, f64::max);
        let known_velocities = self.known(&formula, |level| level.velocities.clone());
        let accelerations = velocities.iter().zip(known_velocities);
        let accelerations: Vec<f64> = accelerations.map(|(u, known)| newest * u + known).collect();
        let momentum_rates = self.bodies.iter().zip(&accelerations);
        Ok(AxialStep {
            time,
            length,
            positions: self.centres(&displacements, &given),
            velocities: velocities.clone(),
            forces,
            momentum_rates: momentum_rates.map(|(body, a)| body.mass * a).collect(),
            accelerations,
            slip_power,
            error,
            flow_error,
            velocity_error: match formula.error_factor {
                0.0 => f64::INFINITY,
                factor => factor * of_bodies,
            },
            momentum_jump: self.momentum_jump,
            iterations,
            level: Level {
                time,
                nodes,
                fields,
                displacements,
                given,
                velocities,
            },
        })
    }

    /// The viscosity of the fluid, which is enclosed.
    fn viscosity(&self) -> Viscosity<'a> {
        match self.parameters.law {
            Some(law) => Viscosity {
                law: Some(law),
                ..Viscosity::constant(0.0)
            },
            None => Viscosity::default(),
        }
    }

    fn no_balance(&self) -> Balance {
        Balance {
            matrix: DMatrix::zeros(self.n_motions, self.n_motions),
            load: vec![0.0; self.n_motions],
        }
    }

    /// The balance of forces of the free motions: `m (c_0 U + known) / Δt - load`.
    fn balance(&self, formula: &TimeDerivative, time: f64, rates: &[f64]) -> Balance {
        let mut balance = self.no_balance();
        let known = self.known(formula, |level| level.velocities.clone());
        for (number, body) in self.bodies.iter().enumerate() {
            let Some(g) = self.motions[number] else {
                continue;
            };
            balance.matrix[(g, g)] += formula.newest() * body.mass;
            balance.load[g] += self.forcing.load(time, number)
                - body.mass * (formula.newest() * rates[number] + known[number]);
        }
        balance
    }

    /// Positions of the nodes around displaced bodies, in a step of this length.
    fn nodes(
        &self,
        step: f64,
        free: &[f64],
        given: &[f64],
    ) -> Result<Vec<Point>, AxisymmetricError> {
        let moved = self.moved_shapes(free, given);
        // bodies that meet are an error of their own, before the mesh is inverted
        Meridian::new(&moved, self.surroundings)?;
        let positions = self.motion.positions(&self.displacements(free, given));
        match self.motion.quality(&positions) >= MIN_QUALITY {
            true => Ok(positions),
            false => Err(AxisymmetricError::MeshLost {
                time: self.time(),
                step,
            }),
        }
    }

    /// Replaces the mesh by a new one around the bodies at their present positions.
    ///
    /// Velocities of all levels are carried to it by an interpolation without divergence, earlier
    /// positions of its nodes are those of the old mesh at the same places.
    /// [`AxialStep::momentum_jump`] of the next step has the change of the momentum.
    ///
    /// # Errors
    /// Domains that cannot be meshed; those of the projection.
    pub fn renew_mesh(&mut self) -> Result<(), AxisymmetricError> {
        let present = self.levels[0].clone();
        let bodies = self.bodies_at(&self.positions());
        let system = system_around(&bodies, self.surroundings, &self.parameters)?;
        let (positions, placed) = (system.positions(), shapes(&bodies));
        let size = self.smallest();
        let transfer = FlowTransfer::new((&self.system, &present.nodes), &system, size)?;
        let mut levels = self.levels.clone();
        for (number, level) in levels.iter_mut().enumerate() {
            let boundary = BoundaryVelocity {
                bodies: level.velocities.clone(),
                slip: self.slip_on(&system, &positions, &placed, level.time)?,
                wall: self.forcing.wall_velocity(level.time),
            };
            let jump = transfer.carry(level, &present, &boundary)?;
            if number == 0 {
                self.momentum_jump = Some(self.momentum_jump.unwrap_or(0.0) + jump);
            }
            for (displacement, now) in level.displacements.iter_mut().zip(&present.displacements) {
                *displacement -= now;
            }
        }
        self.motion = MeshMotion::new(&system, bodies.len())?;
        (self.system, self.levels, self.bodies) = (system, levels, bodies);
        self.start = present.given;
        self.factors = None;
        self.meshes += 1;
        Ok(())
    }

    fn moved_shapes(&self, free: &[f64], given: &[f64]) -> Vec<AxialSpheroid> {
        let moved = |(shape, centre)| AxialSpheroid { centre, ..shape };
        let centres = self.centres(free, given);
        shapes(&self.bodies)
            .into_iter()
            .zip(centres)
            .map(moved)
            .collect()
    }

    /// Slip at the nodes; empty without slip.
    fn slip(&self, time: f64) -> Result<Vec<Point>, AxisymmetricError> {
        // nodes of a body move with it, so that those of any level serve
        let level = &self.levels[0];
        let shapes = match self.parameters.frozen {
            true => shapes(&self.bodies),
            false => self.moved_shapes(&level.displacements, &level.given),
        };
        self.slip_on(&self.system, &level.nodes, &shapes, time)
    }

    /// Slip at the nodes of a system, which are here, around these bodies; empty without slip.
    fn slip_on(
        &self,
        system: &FlowSystem,
        nodes: &[Point],
        shapes: &[AxialSpheroid],
        time: f64,
    ) -> Result<Vec<Point>, AxisymmetricError> {
        if !self.forcing.has_slip() {
            return Ok(Vec::new());
        }
        system.slip(nodes, |body, x| {
            let shape = &shapes[body];
            let slip = self.forcing.slip(time, body, [x.x - shape.centre, x.y]);
            [Point::from(slip), Point::from(normal(shape, x))]
        })
    }

    /// Accepts a step of this integrator from the present time.
    pub fn accept(&mut self, step: AxialStep) {
        let speeds = step.level.fields.velocity.iter().map(|u| u.amax());
        self.largest = speeds.fold(self.largest, f64::max);
        self.momentum_jump = None;
        self.levels.insert(0, step.level);
        self.levels.truncate(LEVELS);
    }

    /// Takes and accepts a step of this length, whatever its error.
    ///
    /// # Errors
    /// Those of [`AxialIntegrator::try_step`].
    pub fn step(&mut self, length: f64) -> Result<AxialStep, AxisymmetricError> {
        let step = self.try_step(length)?;
        self.accept(step.clone());
        Ok(step)
    }

    /// Integrates to `end` with steps whose estimated relative errors are below `tolerance`.
    ///
    /// Starts with steps of the length `first`, of the first of which no error is known. `observe`
    /// sees each accepted step.
    ///
    /// # Errors
    /// [`AxisymmetricError::StepTooShort`], and those of [`AxialIntegrator::try_step`].
    pub fn advance_to(
        &mut self,
        end: f64,
        tolerance: f64,
        first: f64,
        mut observe: impl FnMut(&AxialStep),
    ) -> Result<(), AxisymmetricError> {
        let mut steps = StepControl::between(first, self.time(), end);
        while self.time() < end {
            let taken = steps.next(end - self.time());
            let step = self.try_step(taken)?;
            if steps.accepts(self.time(), taken, step.error, tolerance)? {
                observe(&step);
                self.accept(step);
            }
        }
        Ok(())
    }
}

/// Ratio of the coefficients of the newest level above which factors of an earlier step do not
/// serve: the iteration reduces its change by no more than one minus the inverse of it.
const MAX_COEFFICIENT_RATIO: f64 = 1.3;

/// Iterations after which a step has failed; most take four.
const MAX_ITERATIONS: usize = 30;

/// Smallest quality of a triangle relative to its own when the mesh was generated, below which
/// there is a new mesh.
///
/// Constants of interpolation grow as the inverse of the quality.
const MIN_QUALITY: f64 = 0.4;

/// The degrees of freedom on a new mesh around bodies.
pub(super) fn system_around(
    bodies: &[AxialBody],
    surroundings: Surroundings,
    parameters: &TransientParameters,
) -> Result<FlowSystem, AxisymmetricError> {
    let mesh = generate(&domain(bodies, surroundings)?, parameters.growth)?;
    let (motions, n_motions) = motions(bodies);
    FlowSystem::new(mesh, parameters.order, motions, n_motions, None, None)
}
