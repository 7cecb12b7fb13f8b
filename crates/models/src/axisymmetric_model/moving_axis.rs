//! A scene on one axis in scaled units, for integrations in time that keep the velocity of the
//! fluid.

use axisymmetric::{AxialBody, AxialMotion, AxialStep, Surroundings};
use nalgebra::Vector3;
use rigid::{Articulation, BodyKind, Drive, JointKind, Reduction, State, StateVelocity};

use super::AxisymmetricModel;
use super::axial_surfaces::{across, spatial};
use crate::error::ModelError;
use crate::response::BodySolution;
use crate::scaled_scene::{ScaledResponse, ScaledScene};
use crate::solution::{ErrorEstimate, InstantaneousSolution};
use scene::rheology::Law;
use scene::{Domain, Scene, VectorOscillation};

/// Bodies, loads and slip of a scene on one axis, for an integration in time of fluid and bodies
/// together in the meridian plane.
///
/// In scaled units: lengths are divided by the smallest radius, the viscosity is 1, and times are
/// those of the scene. It is to that plane what [`MovingScene`](crate::MovingScene) is to space.
pub struct MovingAxis {
    scaled: ScaledScene,
    axis: Vector3<f64>,
    surroundings: Surroundings,
    law: Option<Law>,
    bodies: Vec<AxialBody>,
    /// Positions along the axis at the start.
    start: Vec<f64>,
}

/// Motion and loads of the bodies along the axis at one time, in scaled units.
pub struct AxialFlow<'a> {
    /// The time.
    pub time: f64,
    /// Positions of the bodies.
    pub positions: &'a [f64],
    /// Velocities of the bodies.
    pub velocities: &'a [f64],
    /// Forces of the bodies on the fluid.
    pub forces: &'a [f64],
    /// Mass times acceleration of the bodies; empty in a steady flow.
    pub momentum_rates: &'a [f64],
    /// Power of the slip on the fluid.
    pub slip_power: f64,
}

impl<'a> From<&'a AxialStep> for AxialFlow<'a> {
    fn from(step: &'a AxialStep) -> Self {
        Self {
            time: step.time,
            positions: &step.positions,
            velocities: &step.velocities,
            forces: &step.forces,
            momentum_rates: &step.momentum_rates,
            slip_power: step.slip_power,
        }
    }
}

impl MovingAxis {
    /// Refuses a scene that the plane does not have, with the key and the remedy.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`].
    pub fn check(scene: &Scene) -> Result<(), ModelError> {
        let bodies = || scene.bodies().iter();
        let is_ball = matches!(scene.domain(), Domain::Ball { .. });
        let obstacles = [
            (
                !AxisymmetricModel::supports(scene) || !is_ball,
                "bodies",
                "anything but spheres and spheroids on an axis of a ball",
            ),
            (
                bodies().any(|body| body.kind() == BodyKind::Point),
                "bodies",
                "a point without a surface",
            ),
            (
                AxisymmetricModel::has_swirl(scene),
                "bodies",
                "a rotation about the axis",
            ),
            (
                scene.has_passive_joints(),
                "links",
                "a joint that forces or springs move",
            ),
            (
                scene.repulsion().is_some(),
                "contact",
                "a repulsion of surfaces",
            ),
        ];
        match obstacles.into_iter().find(|(is_there, ..)| *is_there) {
            None => Ok(()),
            Some((_, key, obstacle)) => {
                let place = scene.place(key);
                let what = format!(
                    "{place}: {key}: {obstacle} in the meridian plane of a fluid with inertia"
                );
                let instead = "set model.kind = \"fem\" or \"auto\"";
                Err(ModelError::unsupported(what, instead))
            }
        }
    }

    /// Scales a scene.
    ///
    /// # Errors
    /// Those of [`MovingAxis::check`]; joints or fixed bodies that contradict each other.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        Self::check(scene)?;
        let AxisymmetricModel {
            scaled,
            shapes,
            surroundings,
            axis,
            law,
            ..
        } = AxisymmetricModel::new(scene)?;
        let set = &scaled.set;
        let poses = set.place(&set.initial_state(), set.initial_shape())?;
        let start: Vec<f64> = (poses.iter())
            .map(|pose| pose.translation.vector.dot(&axis))
            .collect();
        let body = |(number, mut shape): (usize, axisymmetric::AxialSpheroid)| {
            shape.centre = start[number];
            let (mass, inertia) =
                (scene.bodies()[number].mass_matrix_by_density()).unwrap_or_default();
            let linkage = set.linkage_of()[number];
            AxialBody {
                shape,
                mass: scaled.scale.mass(mass, &inertia).0,
                motion: match set.held_translation()[set.linkages()[linkage].root] {
                    true => AxialMotion::Prescribed,
                    false => AxialMotion::Free(linkage),
                },
            }
        };
        Ok(Self {
            bodies: shapes.into_iter().enumerate().map(body).collect(),
            start,
            scaled,
            axis,
            surroundings,
            law,
        })
    }

    /// The scene, in its own units.
    pub fn scene(&self) -> &Scene {
        &self.scaled.scene
    }

    /// The bodies at the start.
    pub fn bodies(&self) -> &[AxialBody] {
        &self.bodies
    }

    /// The walls.
    pub fn surroundings(&self) -> Surroundings {
        self.surroundings
    }

    /// Density of the fluid, `ρ L² / μ`, as in [`MovingScene`](crate::MovingScene).
    pub fn density(&self) -> f64 {
        self.scaled.scale.density(self.scene().fluid_density())
    }

    /// The same with the regularisation of the viscosity law multiplied by a factor, for an
    /// estimate of its effect.
    #[must_use]
    pub fn regularised(self, factor: f64) -> Self {
        Self {
            law: self.law.map(|law| law.regularised(factor)),
            ..self
        }
    }

    /// Viscosity law of the fluid; none for a Newtonian fluid.
    pub fn law(&self) -> Option<&Law> {
        self.law.as_ref()
    }

    /// A length or velocity in the units of the scene.
    pub fn length_to_scene(&self, length: f64) -> f64 {
        self.scaled.scale.length_to_scene(length)
    }

    fn set(&self) -> &Articulation {
        &self.scaled.set
    }

    /// A force in the units of the scene.
    pub fn force_to_scene(&self, force: f64) -> f64 {
        self.scaled.scale.force_to_scene(force)
    }

    /// Forces and torques of the bodies in the units of the scene, from forces along the axis.
    pub fn forces_to_scene(&self, forces: &[f64]) -> Vec<[Vector3<f64>; 2]> {
        let spatial = |force: &f64| self.axis * self.force_to_scene(*force);
        let forces = forces.iter().map(spatial);
        forces.map(|force| [force, Vector3::zeros()]).collect()
    }

    /// A power or an energy in the units of the scene, whose times are kept.
    pub fn power_to_scene(&self, power: f64) -> f64 {
        self.scaled.scale.power_to_scene(power)
    }

    /// Displacement of a body with these values of the joints, in the units of the scene: relative
    /// to the root of its linkage, or in the laboratory if the velocity of the root is given.
    ///
    /// NaN for values of joints for which a loop does not close.
    pub fn displacement(&self, time: f64, shape: &[f64], body: usize) -> f64 {
        let set = self.set();
        let Ok(poses) = set.place(&set.initial_state(), &self.scaled.values(shape)) else {
            return f64::NAN;
        };
        poses[body].translation.vector.dot(&self.axis)
            + self.given(body, |velocity| velocity.integral(time))
    }

    /// Rate of the displacement of a body with these rates of the joints.
    pub fn displacement_rate(&self, time: f64, shape: &[f64], rates: &[f64], body: usize) -> f64 {
        // Displacements on a line are linear in the values of slides.
        let changed: Vec<f64> = shape.iter().zip(rates).map(|(q, rate)| q + rate).collect();
        let of = |shape: &[f64]| self.displacement(0.0, shape, body);
        of(&changed) - of(shape) + self.given(body, |velocity| velocity.at(time))
    }

    /// Component along the axis of what `of` takes from the velocity of the root of a body's
    /// linkage, if it is given; else zero.
    fn given(&self, body: usize, of: impl Fn(&VectorOscillation) -> Vector3<f64>) -> f64 {
        let set = self.set();
        let root = set.linkages()[set.linkage_of()[body]].root;
        let velocity = self.scene().bodies()[root].held_velocity();
        velocity.map_or(0.0, |v| self.scaled.scale.length(of(&v).dot(&self.axis)))
    }

    /// External force along the axis on a body at a time.
    pub fn load(&self, time: f64, body: usize) -> f64 {
        self.scaled.loads_at(time, &[])[body].force.dot(&self.axis)
    }

    /// Whether surfaces move relative to their bodies.
    pub fn has_slip(&self) -> bool {
        self.scene().has_surface_velocity()
    }

    /// Slip of a body along the axis and away from it, at a point relative to its centre.
    pub fn slip(&self, body: usize, [z, r]: [f64; 2]) -> [f64; 2] {
        let Some(slip) = self.scene().bodies()[body].slip else {
            return [0.0; 2];
        };
        let shape = &self.bodies[body].shape;
        let [along, away] = [z / shape.axial.powi(2), r / shape.equatorial.powi(2)];
        let radial = self.radial();
        let normal = (along * self.axis + away * radial).normalize();
        let velocity = self.scaled.scale.length(slip.velocity(&normal));
        [velocity.dot(&self.axis), velocity.dot(&radial)]
    }

    /// A unit vector away from the axis.
    fn radial(&self) -> Vector3<f64> {
        across(&self.axis)
    }

    /// The change of the state between positions of the bodies along the axis, in the units of the
    /// scene.
    pub fn increment(&self, before: &[f64], after: &[f64]) -> StateVelocity {
        let set = self.set();
        let still = rigid::Twist::default();
        let frames = set.linkages().iter().map(|linkage| rigid::Twist {
            linear: self.axis * (after[linkage.root] - before[linkage.root]),
            ..still
        });
        self.scaled.motion_to_scene(&StateVelocity {
            frames: frames.collect(),
            spins: vec![Vector3::zeros(); set.kinds().len()],
            joints: Vec::new(),
        })
    }

    /// Motion and loads in the units of the scene, for these values of the joints; `dofs` is the
    /// number of unknowns, `tolerance` the relative error of the iteration.
    ///
    /// # Errors
    /// Joints that contradict each other.
    pub fn answer(
        &self,
        step: &AxialFlow,
        shape: &[f64],
        (dofs, tolerance): (usize, f64),
    ) -> Result<InstantaneousSolution, ModelError> {
        let set = self.set();
        let mut state: State = set.initial_state();
        for (frame, linkage) in state.frames.iter_mut().zip(set.linkages()) {
            frame.translation.vector = self.axis * step.positions[linkage.root];
        }
        let rate = |joint: &rigid::Joint| match joint.kind {
            JointKind::Slide => {
                let [body, to] = [joint.body, joint.to];
                let direction = (self.start[body] - self.start[to]).signum();
                direction * (step.velocities[body] - step.velocities[to])
            }
            _ => 0.0,
        };
        let rates: Vec<f64> = set.joints().iter().map(rate).collect();
        let joints = set.constraints(&state, &self.scaled.values(shape), &rates)?;
        let constraints = self.scaled.with_drives(step.time, joints)?;
        let mut loads = self.scaled.loads_at(step.time, &[]);
        for (load, rate) in loads.iter_mut().zip(step.momentum_rates) {
            load.force -= self.axis * *rate;
        }
        let spatial = |along: &[f64]| spatial(&self.axis, along);
        // The coefficients of the motions that the joints leave free, from the velocities.
        let reduction = Reduction::new(set, &constraints)?;
        let (basis, velocities) = (&reduction.surface_basis, spatial(step.velocities));
        let free = basis.tr_mul(&(&velocities - &reduction.surface_offset));
        let coefficients = match basis.ncols() {
            0 => free,
            size => {
                let gram = basis.tr_mul(basis).cholesky();
                let matrix = "motions that the links leave free";
                gram.ok_or(ModelError::Singular { matrix, size })?
                    .solve(&free)
            }
        };
        let generalised = reduction.velocities(&coefficients)?;
        let forces = spatial(step.forces);
        let drive = Drive {
            set,
            constraints: &constraints,
            loads: &loads,
        };
        let response = self.scaled.response_to_scene(
            step.time,
            ScaledResponse {
                motion: &set.state_velocity(generalised.as_slice())?,
                generalised: &generalised,
                forces: &forces,
                joint_loads: drive.joint_loads(&forces, &generalised)?,
                holding: drive.holding_loads(&forces, &generalised)?,
                mean_flow: Vector3::zeros(),
                slip_power: step.slip_power,
                amplitudes: Vec::new(),
            },
        );
        let largest = |of: fn(&BodySolution) -> Vector3<f64>| {
            (response.bodies.iter()).fold(0.0_f64, |m, body| m.max(of(body).norm()))
        };
        let is_regularised = self.law.is_some_and(|law| law.is_regularised());
        let bars = |size: f64| ErrorEstimate {
            // The walls and the equations are those of the scene, but for a regularised law.
            container: Some(0.0),
            model: (!is_regularised).then_some(0.0),
            algebraic: Some(tolerance * size),
            ..ErrorEstimate::default()
        };
        let sizes = [largest(|body| body.velocity), largest(|body| body.force)];
        let power = response.power().abs();
        Ok(InstantaneousSolution {
            error_estimate: bars(sizes[0]),
            angular_velocity_error: bars(0.0),
            force_error: bars(sizes[1]),
            torque_error: bars(0.0),
            power_error: bars(power),
            ..InstantaneousSolution::solved_directly(response, dofs, tolerance)
        })
    }
}
