//! Steps in time of bodies in a fluid with inertia.

use std::sync::Arc;

use fem::TaylorHood;
use linalg::{StepControl, TimeDerivative, WarmStart, extrapolation};
use mesh::TetMesh;
use nalgebra::{Isometry3, Matrix6, Vector3, Vector6};
use rigid::{BodyKind, Drive, State, StateVelocity};
use stokes::{InertialTerms, Solution};

use crate::added_mass::added_mass_forces;
use crate::bodies::SlipAt;
use crate::error::check_length;
use crate::projection::{ProjectionJump, square_integral};
use crate::step::{Level, Step, StepReport};
use crate::{Bodies, Convection, Forcing, InertiaError, Meshes, Parameters, SuppliedMesh};

/// What earlier levels contribute to the rates of momentum of a step.
struct Known {
    /// Minus that of the fluid per volume, one per node.
    force: Vec<Vector3<f64>>,
    /// Those of the bodies.
    momenta: Vec<Vector6<f64>>,
}

/// Integrates the motion of bodies in a fluid with inertia, by BDF2 with variable steps.
///
/// All terms of a step are assembled on the mesh at its end, where the velocities of earlier times
/// are carried by their nodes and the velocity of the mesh is the same difference formula of the
/// positions of the nodes. A uniform flow then stays uniform however the mesh moves, and the order
/// on a fixed mesh is kept (Fehn, Heinz, Wall, Kronbichler 2021). The positions of bodies follow
/// from their velocities by the same formula, those of joints from their values, so that joints do
/// not open. Fluid, bodies and joints are one system: light bodies need no other steps than heavy
/// ones.
///
/// The convecting velocity is extrapolated, so that a step is linear and its matrix is one scalar
/// matrix for the three components. With a viscosity law the equations of a step are nonlinear in
/// the stress alone, and Newton's method starts at the extrapolated velocity.
pub struct Integrator<'a> {
    pub(crate) bodies: Bodies<'a>,
    pub(crate) forcing: &'a dyn Forcing,
    pub(crate) meshes: Box<dyn Meshes + 'a>,
    pub(crate) parameters: Parameters<'a>,
    /// The newest first, three at most.
    pub(crate) levels: Vec<Level>,
    pub(crate) mesh: TetMesh,
    pub(crate) space: Arc<TaylorHood>,
    pub(crate) warm: WarmStart,
    /// Largest velocities so far, of the fluid in L2 and of the bodies.
    pub(crate) largest: [f64; 2],
    pub(crate) jump: Option<ProjectionJump>,
}

/// Levels that BDF2 and its error estimate need.
pub(crate) const LEVELS: usize = 3;

impl<'a> Integrator<'a> {
    /// Starts from rest at time `time`, in the configuration given when the bodies were joined.
    ///
    /// # Errors
    /// A density that is negative or not finite, lists that do not fit the bodies, no mesh.
    pub fn from_rest(
        bodies: Bodies<'a>,
        forcing: &'a dyn Forcing,
        mut meshes: Box<dyn Meshes + 'a>,
        parameters: Parameters<'a>,
        time: f64,
    ) -> Result<Self, InertiaError> {
        if !(parameters.density >= 0.0 && parameters.density.is_finite()) {
            return Err(InertiaError::OutOfRange {
                what: "the density of the fluid",
                value: parameters.density,
                range: "zero or positive",
            });
        }
        let set = bodies.set;
        let surfaced = set.kinds().iter().filter(|kind| **kind == BodyKind::Rigid);
        for (what, expected, found) in [
            (
                "masses, one per body",
                set.kinds().len(),
                bodies.masses.len(),
            ),
            (
                "surfaces of bodies",
                surfaced.count(),
                bodies.surfaces.len(),
            ),
        ] {
            check_length(what, expected, found)?;
        }
        let (state, shape) = (set.initial_state(), forcing.shape(time));
        let poses = set.place(&state, &shape)?;
        let mesh = meshes.mesh(time, &bodies.surfaced(&poses))?;
        let (mesh, space) = mesh.ok_or(InertiaError::NoMesh { time })?.with_space()?;
        let layout = vec![0.0; set.velocity_layout().len()];
        let level = Level {
            time,
            points: mesh.points().to_vec(),
            velocity: vec![Vector3::zeros(); mesh.n_points()],
            rate: set.state_velocity(&layout)?,
            state,
            increment: None,
            shape,
            generalised: layout,
            momenta: vec![Vector6::zeros(); set.kinds().len()],
        };
        Ok(Self {
            space,
            bodies,
            forcing,
            meshes,
            parameters,
            levels: vec![level],
            mesh,
            // A step starts from a least-squares combination of as many earlier solutions.
            warm: WarmStart::new(5),
            largest: [0.0; 2],
            jump: None,
        })
    }

    /// Replaces the velocity of the fluid at the present time, as for a start from another flow.
    ///
    /// `generalised` are the velocities of the bodies, as in [`rigid::FlowSolution::generalised`].
    /// Earlier levels are forgotten.
    ///
    /// # Errors
    /// Lists of the wrong length.
    pub fn set_flow(
        &mut self,
        velocity: Vec<Vector3<f64>>,
        generalised: &[f64],
    ) -> Result<(), InertiaError> {
        let nodes = self.mesh.n_points();
        check_length("velocities of the nodes", nodes, velocity.len())?;
        self.restart();
        let set = self.bodies.set;
        let poses = self.poses()?;
        let masses = self.mass_matrices(&poses);
        let rate = set.state_velocity(generalised)?;
        let momenta = self.momenta(&masses, generalised);
        let level = &mut self.levels[0];
        level.velocity = velocity;
        level.rate = rate;
        level.generalised = generalised.to_vec();
        level.momenta = momenta;
        Ok(())
    }

    /// Replaces the velocity at the present time by that without inertia of fluid and bodies,
    /// Stokes flow with these rates of the joints. Earlier levels are forgotten.
    ///
    /// # Errors
    /// Rates of another number of joints; those of assembly and linear solve.
    pub fn start_from_stokes(&mut self, rates: &[f64]) -> Result<Solution, InertiaError> {
        let (time, poses) = (self.time(), self.poses()?);
        let set = self.bodies.set;
        let level = &self.levels[0];
        let joints = set.constraints(&level.state, &level.shape, rates)?;
        let drive = Drive {
            set,
            constraints: &self.forcing.constraints(time, joints)?,
            loads: &self.forcing.loads(time, &poses),
        };
        let wall_velocity = self.wall_velocity(&self.mesh, time);
        let terms = InertialTerms {
            law: self.parameters.law,
            wall_velocity: wall_velocity.as_deref(),
            ..InertialTerms::default()
        };
        let mut warm = WarmStart::new(0);
        let solved = self.solve_terms((&self.mesh, &poses), time, &drive, &terms, &mut warm)?;
        let flow = &solved.flow;
        self.set_flow(flow.velocity.clone(), flow.generalised.as_slice())?;
        Ok(solved)
    }

    /// Kinetic energy of the fluid at the present time, `ρ/2 ∫ |u|²`, symmetry planes not
    /// multiplied.
    ///
    /// # Errors
    /// A velocity that is not finite.
    pub fn kinetic_energy(&self) -> Result<f64, InertiaError> {
        let square = square_integral(&self.mesh, &self.levels[0].velocity)?;
        Ok(0.5 * self.parameters.density * square)
    }

    /// Kinetic energy of the bodies at the present time, `sum_b (m U² + ω · I ω) / 2`.
    pub fn bodies_kinetic_energy(&self) -> f64 {
        let (level, layout) = (&self.levels[0], self.bodies.set.velocity_layout());
        let of_body = |(body, momentum): (usize, &Vector6<f64>)| {
            let first = layout.body(body)?;
            let twist = &level.generalised[first..first + 6];
            Some(0.5 * momentum.dot(&Vector6::from_column_slice(twist)))
        };
        let bodies = level.momenta.iter().enumerate();
        bodies.filter_map(of_body).sum()
    }

    /// Time in which vorticity diffuses over half the distance `d` between nodes on the bodies: `ρ
    /// d²/4` at viscosity 1. Elements do not resolve a layer that is younger.
    ///
    /// The nodes are those of equilateral triangles with the area of the surfaces.
    ///
    /// # Errors
    /// A boundary part without facets.
    pub fn age_of_resolved_layers(&self) -> Result<f64, InertiaError> {
        let (mut area, mut nodes) = (0.0, 0);
        for part in &self.bodies.surfaces {
            let tag = self.mesh.tag(part)?;
            area += fem::integrate_facets(&self.mesh, tag, 2, |_| 1.0)?;
            nodes += self.mesh.nodes_on(tag).len();
        }
        // two triangles of the area 3^(1/2) d^2 / 4 per node
        let square = 2.0 / 3.0_f64.sqrt() * area / nodes.max(1) as f64;
        Ok(self.parameters.density * square / 4.0)
    }

    /// Forgets all levels but the present one: for corners of a motion, after which derivatives
    /// jump.
    pub fn restart(&mut self) {
        self.levels.truncate(1);
        self.levels[0].increment = None;
    }

    /// The present time.
    pub fn time(&self) -> f64 {
        self.levels[0].time
    }

    /// The present mesh.
    pub fn mesh(&self) -> &TetMesh {
        &self.mesh
    }

    /// The present velocity of each node.
    pub fn velocity(&self) -> &[Vector3<f64>] {
        &self.levels[0].velocity
    }

    /// The present state of the bodies.
    pub fn state(&self) -> &State {
        &self.levels[0].state
    }

    /// The present poses of all bodies.
    ///
    /// # Errors
    /// None for a state that was reached.
    pub fn poses(&self) -> Result<Vec<Isometry3<f64>>, InertiaError> {
        let level = &self.levels[0];
        Ok(self.bodies.set.place(&level.state, &level.shape)?)
    }

    /// Jumps of momentum and energy by the last change of the mesh, of the newest level.
    pub fn last_jump(&self) -> Option<ProjectionJump> {
        self.jump
    }

    /// Lengths of the steps between the levels, the last one first.
    fn steps_before(&self) -> Vec<f64> {
        self.levels
            .windows(2)
            .map(|pair| pair[0].time - pair[1].time)
            .collect()
    }

    fn mass_matrices(&self, poses: &[Isometry3<f64>]) -> Vec<Matrix6<f64>> {
        let masses = self.bodies.masses.iter().zip(poses);
        masses.map(|(mass, pose)| mass.matrix(pose)).collect()
    }

    /// Momenta of all bodies with these generalised velocities.
    fn momenta(&self, masses: &[Matrix6<f64>], generalised: &[f64]) -> Vec<Vector6<f64>> {
        let set = self.bodies.set;
        let layout = set.velocity_layout();
        let momentum = |(body, mass): (usize, &Matrix6<f64>)| match layout.body(body) {
            Some(first) if set.kinds()[body] == BodyKind::Rigid => {
                mass * Vector6::from_column_slice(&generalised[first..first + 6])
            }
            _ => Vector6::zeros(),
        };
        masses.iter().enumerate().map(momentum).collect()
    }

    /// Rates of change of the velocities of bodies with a surface, by the formula of a step.
    fn accelerations(&self, formula: &TimeDerivative, generalised: &[f64]) -> Vec<Vector6<f64>> {
        let known = self.known(formula, |level| &level.generalised);
        let rows = self.bodies.set.surface_velocities();
        let rate = |row: usize| formula.newest() * generalised[row] + known[row];
        (rows.chunks_exact(6))
            .map(|rows| Vector6::from_fn(|k, _| rate(rows[k])))
            .collect()
    }

    /// Part of the forces and torques of bodies with a surface on the fluid which is due to their
    /// accelerations at the end of a step, symmetry planes considered: see
    /// [`added_mass_forces`](crate::added_mass_forces).
    ///
    /// # Errors
    /// Those of [`added_mass_forces`](crate::added_mass_forces).
    pub fn added_mass_forces(&self, step: &Step) -> Result<Vec<Vector6<f64>>, InertiaError> {
        let surfaced = self.bodies.surfaced(&step.poses);
        let names = self.bodies.surfaces.iter().map(String::as_str);
        let bodies: Vec<_> = names
            .zip(surfaced.iter().map(|pose| pose.translation.vector))
            .collect();
        let forces = added_mass_forces(&step.mesh, &self.space, &bodies, &step.accelerations)?;
        Ok(forces
            .into_iter()
            .map(|force| self.parameters.density * force)
            .collect())
    }

    /// Sum over the older levels of the formula, `sum_k c_k v_k / Δt`.
    fn known<T>(&self, formula: &TimeDerivative, field: impl Fn(&Level) -> &[T]) -> Vec<T>
    where
        T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
    {
        let [first, rest @ ..] = self.levels.as_slice() else {
            return Vec::new();
        };
        let mut sum: Vec<T> = field(first).iter().map(|v| *v * formula.older(1)).collect();
        if let Some(second) = rest.first() {
            for (sum, v) in sum.iter_mut().zip(field(second)) {
                *sum = *sum + *v * formula.older(2);
            }
        }
        sum
    }

    /// Extrapolation of the velocities to the end of a step, from at most `levels` levels.
    fn extrapolated(&self, step: f64, levels: usize) -> Vec<Vector3<f64>> {
        let levels = &self.levels[..levels.min(self.levels.len())];
        let before = &self.steps_before()[..levels.len() - 1];
        let weights = extrapolation(step, before);
        let mut sum = vec![Vector3::zeros(); levels[0].velocity.len()];
        for (level, weight) in levels.iter().zip(weights) {
            for (sum, u) in sum.iter_mut().zip(&level.velocity) {
                *sum += weight * u;
            }
        }
        sum
    }

    /// Increment of the state by a step that ends with these velocities.
    ///
    /// `x_new - x_1 = (Δt U + c_2 (x_1 - x_2)) / c_0`, by the formula of the step.
    fn increment(&self, formula: &TimeDerivative, rate: &StateVelocity) -> StateVelocity {
        let [newest, _, oldest] = formula.coefficients;
        let step = rate * (formula.step / newest);
        match &self.levels[0].increment {
            Some(last) if oldest != 0.0 => &step + &(last * (oldest / newest)),
            _ => step,
        }
    }

    /// The state at the end of a step with these velocities, and its increment.
    fn advanced(
        &self,
        formula: &TimeDerivative,
        rate: &StateVelocity,
    ) -> Result<(State, StateVelocity), InertiaError> {
        let increment = self.increment(formula, rate);
        let state = &self.levels[0].state;
        match self.meshes.is_frozen() {
            true => Ok((state.clone(), increment)),
            false => Ok((self.bodies.set.advance(state, &increment)?, increment)),
        }
    }

    /// Takes a step of this length from the present time, without accepting it.
    ///
    /// # Errors
    /// A length that is not positive; a mesh that cannot follow the bodies and cannot be renewed;
    /// those of assembly and linear solve.
    pub fn try_step(&mut self, length: f64) -> Result<Step, InertiaError> {
        if !(length > 0.0 && length.is_finite()) {
            return Err(InertiaError::OutOfRange {
                what: "the length of a step",
                value: length,
                range: "positive",
            });
        }
        match self.step_on_meshes(length)? {
            Some(step) => return Ok(step),
            None if self.renew_mesh()? => {}
            None => return Err(InertiaError::NoMesh { time: self.time() }),
        }
        let step = self.step_on_meshes(length)?;
        step.ok_or(InertiaError::NoMesh { time: self.time() })
    }

    /// A step on the present mesh; none if it cannot follow the bodies.
    fn step_on_meshes(&mut self, length: f64) -> Result<Option<Step>, InertiaError> {
        let formula = TimeDerivative::new(length, &self.steps_before());
        let (set, forcing) = (self.bodies.set, self.forcing);
        let time = self.time() + length;
        let shape = forcing.shape(time);
        let (frozen, present) = (self.meshes.is_frozen(), self.levels[0].shape.clone());
        let rates: Vec<f64> = {
            let known = self.known(&formula, |level| &level.shape);
            (shape.iter().zip(known))
                .map(|(q, known)| formula.newest() * q + known)
                .collect()
        };
        let predicted_rate = match self.levels.as_slice() {
            [first, second, ..] => {
                let weights = extrapolation(length, &[first.time - second.time]);
                &(&first.rate * weights[0]) + &(&second.rate * weights[1])
            }
            levels => levels[0].rate.clone(),
        };
        let (mut state, _) = self.advanced(&formula, &predicted_rate)?;
        let density = self.parameters.density;
        let mut force = self.known(&formula, |level| &level.velocity);
        force.iter_mut().for_each(|u| *u *= -density);
        let known = Known {
            force,
            momenta: self.known(&formula, |level| &level.momenta),
        };
        let (mut solves, mut warm) = (0, self.warm.clone());
        let (step, warm) = loop {
            // frozen joints still have rates, but their values do not count
            let placed = if frozen { &present } else { &shape };
            let poses = set.place(&state, placed)?;
            let Some(mesh) = self.mesh_at(time, &poses)? else {
                return Ok(None);
            };
            let masses = self.mass_matrices(&poses);
            let solved = self.solve(
                (&mesh, &poses),
                &formula,
                (&state, placed, &rates),
                &known,
                &masses,
                &mut warm,
                time,
            )?;
            solves += 1;
            let flow = &solved.flow;
            let (next, increment) = self.advanced(&formula, &flow.state)?;
            let next_poses = set.place(&next, placed)?;
            let mesh_error = self.distance(&mesh, &poses, &next_poses)?;
            let good = mesh_error <= self.parameters.mesh_tolerance;
            if !good && solves <= self.parameters.max_corrections {
                state = next;
                continue;
            }
            let momenta = self.momenta(&masses, flow.generalised.as_slice());
            let accelerations = self.accelerations(&formula, flow.generalised.as_slice());
            let level = Level {
                time,
                points: mesh.points().to_vec(),
                velocity: flow.velocity.clone(),
                rate: flow.state.clone(),
                state: next,
                increment: Some(increment),
                shape,
                generalised: flow.generalised.as_slice().to_vec(),
                momenta,
            };
            let [error, velocity_error] = self.errors(&mesh, &level, &formula)?;
            let step = Step {
                time,
                length,
                poses: next_poses,
                error,
                velocity_error,
                accelerations,
                solves,
                solved,
                mesh_error,
                mesh,
                level,
            };
            break (step, warm);
        };
        self.warm = warm;
        Ok(Some(step))
    }

    /// The mesh around bodies with these poses, with the connectivity of the present one.
    fn mesh_at(
        &mut self,
        time: f64,
        poses: &[Isometry3<f64>],
    ) -> Result<Option<TetMesh>, InertiaError> {
        let supplied = self.meshes.mesh(time, &self.bodies.surfaced(poses))?;
        let Some(SuppliedMesh { mesh, .. }) = supplied else {
            return Ok(None);
        };
        let what = "nodes of a mesh that moves without being renewed";
        check_length(what, self.mesh.n_points(), mesh.n_points())?;
        Ok(Some(mesh))
    }

    /// Solves the equations of a step on one mesh.
    fn solve(
        &self,
        (mesh, poses): (&TetMesh, &[Isometry3<f64>]),
        formula: &TimeDerivative,
        (state, shape, rates): (&State, &[f64], &[f64]),
        known: &Known,
        masses: &[Matrix6<f64>],
        warm: &mut WarmStart,
        time: f64,
    ) -> Result<Solution, InertiaError> {
        let (set, forcing) = (self.bodies.set, self.forcing);
        let joints = set.constraints(state, shape, rates)?;
        let mut constraints = forcing.constraints(time, joints)?;
        let massive = (masses.iter().zip(set.kinds()).enumerate())
            .filter(|(_, (mass, kind))| **kind == BodyKind::Rigid && mass.amax() > 0.0);
        constraints.body_damping = massive
            .map(|(body, (mass, _))| (body, formula.newest() * mass))
            .collect();
        let mut loads = forcing.loads(time, poses);
        for (load, momentum) in loads.iter_mut().zip(&known.momenta) {
            load.force -= momentum.fixed_rows::<3>(0);
            load.torque -= momentum.fixed_rows::<3>(3);
        }
        let drive = Drive {
            set,
            constraints: &constraints,
            loads: &loads,
        };
        let flow = self.extrapolated(formula.step, 2);
        let convecting = (self.parameters.convection == Convection::Full).then(|| {
            let known = self.known(formula, |level| &level.points);
            let mesh_velocity =
                (mesh.points().iter().zip(known)).map(|(x, known)| formula.newest() * x + known);
            flow.iter()
                .zip(mesh_velocity)
                .map(|(u, w)| u - w)
                .collect::<Vec<_>>()
        });
        let wall_velocity = self.wall_velocity(mesh, time);
        let terms = InertialTerms {
            density: self.parameters.density,
            coefficient: self.parameters.density * formula.newest(),
            force: Some(&known.force),
            convecting: convecting.as_deref(),
            law: self.parameters.law,
            near: Some(&flow),
            wall_velocity: wall_velocity.as_deref(),
            ..InertialTerms::default()
        };
        self.solve_terms((mesh, poses), time, &drive, &terms, warm)
    }

    /// Solves the equations with these terms of inertia, with the slip of a time.
    fn solve_terms(
        &self,
        (mesh, poses): (&TetMesh, &[Isometry3<f64>]),
        time: f64,
        drive: &Drive,
        terms: &InertialTerms,
        warm: &mut WarmStart,
    ) -> Result<Solution, InertiaError> {
        let forcing = self.forcing;
        let surfaced = self.bodies.surfaced(poses);
        let centres: Vec<Vector3<f64>> = surfaced.iter().map(|p| p.translation.vector).collect();
        let slip = SlipAt {
            forcing,
            time,
            poses: &surfaced,
        };
        let mut problem = self.bodies.problem(mesh, &self.space, &centres)?;
        if forcing.has_slip() {
            problem = problem.with_surface_flow(&slip);
        }
        let options = &self.parameters.options;
        Ok(problem.solve_inertial(drive, options, terms, warm)?)
    }

    /// Velocities of moving walls, one per node.
    fn wall_velocity(&self, mesh: &TetMesh, time: f64) -> Option<Vec<Vector3<f64>>> {
        let velocity = |x| self.forcing.wall_velocity(time, x);
        (self.forcing.has_moving_walls()).then(|| mesh.points().iter().map(velocity).collect())
    }

    /// Largest displacement of a body between two placements, and rotation, in body sizes.
    fn distance(
        &self,
        mesh: &TetMesh,
        from: &[Isometry3<f64>],
        to: &[Isometry3<f64>],
    ) -> Result<f64, InertiaError> {
        let (from, to) = (self.bodies.surfaced(from), self.bodies.surfaced(to));
        let mut largest: f64 = 0.0;
        for ((part, from), to) in self.bodies.surfaces.iter().zip(&from).zip(&to) {
            let nodes = mesh.nodes_on(mesh.tag(part)?);
            let arm = |n: &u32| (mesh.points()[*n as usize] - from.translation.vector).norm();
            let size = nodes.iter().map(arm).fold(0.0, f64::max);
            let shift = (to.translation.vector - from.translation.vector).norm() / size;
            largest = largest.max(shift).max(from.rotation.angle_to(&to.rotation));
        }
        Ok(largest)
    }

    /// Estimated errors of the velocities of a new level: relative, and of the surfaces.
    fn errors(
        &self,
        mesh: &TetMesh,
        level: &Level,
        formula: &TimeDerivative,
    ) -> Result<[f64; 2], InertiaError> {
        if formula.error_factor == 0.0 {
            return Ok([f64::INFINITY; 2]);
        }
        let predicted = self.extrapolated(formula.step, LEVELS);
        let difference: Vec<Vector3<f64>> = level
            .velocity
            .iter()
            .zip(predicted)
            .map(|(u, p)| u - p)
            .collect();
        let of_bodies = |field: &[Vector3<f64>]| -> Result<f64, InertiaError> {
            let mut largest: f64 = 0.0;
            for part in &self.bodies.surfaces {
                for node in mesh.nodes_on(mesh.tag(part)?) {
                    largest = largest.max(field[node as usize].norm());
                }
            }
            Ok(largest)
        };
        let sizes = [
            square_integral(mesh, &level.velocity)?.sqrt(),
            of_bodies(&level.velocity)?,
        ];
        let errors = [
            square_integral(mesh, &difference)?.sqrt(),
            of_bodies(&difference)?,
        ];
        let relative = errors
            .into_iter()
            .zip(sizes)
            .zip(self.largest)
            .map(|((e, s), largest)| {
                let scale = s.max(largest);
                if e > 0.0 { e / scale } else { 0.0 }
            });
        let relative = relative.fold(0.0, f64::max);
        Ok([relative, errors[1]].map(|error| formula.error_factor * error))
    }

    /// Accepts a step.
    ///
    /// # Errors
    /// None for a step of this integrator.
    pub fn accept(&mut self, step: Step) -> Result<(), InertiaError> {
        let size = square_integral(&step.mesh, &step.level.velocity)?.sqrt();
        self.largest[0] = self.largest[0].max(size);
        for part in &self.bodies.surfaces {
            for node in step.mesh.nodes_on(step.mesh.tag(part)?) {
                let speed = step.level.velocity[node as usize].norm();
                self.largest[1] = self.largest[1].max(speed);
            }
        }
        self.mesh = step.mesh;
        self.levels.insert(0, step.level);
        self.levels.truncate(LEVELS);
        Ok(())
    }

    /// Takes and accepts a step of this length, whatever its error.
    ///
    /// # Errors
    /// Those of [`Integrator::try_step`].
    pub fn step(&mut self, length: f64) -> Result<StepReport, InertiaError> {
        let step = self.try_step(length)?;
        let report = StepReport::new(&step);
        self.accept(step)?;
        Ok(report)
    }

    /// Integrates to `end` with steps whose estimated relative errors are below `tolerance`.
    ///
    /// Starts with steps of the length `first`, of the first of which no error is known: take it as
    /// small as `tolerance` times the time in which the motion changes. `observe` sees each
    /// accepted step.
    ///
    /// # Errors
    /// [`InertiaError::StepTooShort`], and those of [`Integrator::try_step`].
    pub fn advance_to(
        &mut self,
        end: f64,
        tolerance: f64,
        first: f64,
        mut observe: impl FnMut(&Step),
    ) -> Result<(), InertiaError> {
        let mut steps = StepControl::between(first, self.time(), end);
        while self.time() < end {
            let taken = steps.next(end - self.time());
            let step = self.try_step(taken)?;
            if steps.accepts(self.time(), taken, step.error, tolerance)? {
                observe(&step);
                self.accept(step)?;
            }
        }
        Ok(())
    }
}
