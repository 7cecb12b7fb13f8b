//! Bodies, joints and loads of a scene in scaled units: the input of every model.

use std::borrow::Cow;

use nalgebra::{DVector, Isometry3, Matrix3, Matrix6, UnitQuaternion, Vector3};
use rigid::{Articulation, BodyKind, Constraints, ExternalLoad, JointLoad, State, StateVelocity};

use crate::error::ModelError;
use crate::query::{BodyInertia, Configuration, Query};
use crate::response::{BodySolution, Response};
use crate::solution::Stresslets;
use crate::units::Scale;
use scene::{Body, Scene};

/// Bodies, joints and loads of a scene in scaled units.
#[derive(Clone)]
pub(crate) struct ScaledScene {
    /// The scene, in its own units.
    pub scene: Scene,
    pub scale: Scale,
    /// Bodies and joints.
    pub set: Articulation,
    /// External loads, one per body, in a frame with this rotation from the laboratory, without
    /// torques of weights.
    loads: Vec<ExternalLoad>,
    /// The rotation.
    to_frame: UnitQuaternion<f64>,
    /// Distance from the root of a linkage to its farthest point, of the smallest linkage, or the
    /// radius of a body with an attitude of its own if that is shorter: errors of velocities over it
    /// are errors of angular velocities.
    pub shortest_lever: f64,
}

/// Motion and loads of the bodies in scaled units.
pub(crate) struct ScaledResponse<'a> {
    pub motion: &'a StateVelocity,
    /// Generalised velocities of all bodies.
    pub generalised: &'a DVector<f64>,
    /// Forces and torques of the bodies with surfaces, six numbers each.
    pub forces: &'a DVector<f64>,
    pub joint_loads: Vec<JointLoad>,
    pub slip_power: f64,
}

impl ScaledScene {
    /// Scales the bodies, joints and loads of a scene.
    ///
    /// # Errors
    /// Joints or fixed bodies that contradict each other.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let scale = Scale::new(scene);
        let bodies = || scene.bodies().iter();
        let kinds: Vec<_> = bodies().map(|b| b.kind()).collect();
        let positions: Vec<_> = bodies().map(|b| scale.length(b.position)).collect();
        let joints = scene.articulation().joints();
        let set = Articulation::new(
            &kinds,
            joints.iter().map(|joint| scale.joint(joint)).collect(),
            scene.articulation().arms(),
            &positions,
        )?
        .with_fixed(&scene.fixed_bodies())?;
        let values = joints.iter().zip(scene.articulation().initial_shape());
        let values: Vec<f64> = values
            .map(|(joint, value)| scale.value(joint, *value))
            .collect();
        let set = set.with_initial_values(&values)?;
        let levers = set.linkages().iter().map(|linkage| {
            let reach = |&body: &usize| {
                let radius = scale.length(scene.bodies()[body].bounding_radius());
                (positions[body] - positions[linkage.root]).norm() + radius
            };
            linkage.bodies.iter().map(reach).fold(0.0, f64::max)
        });
        // Bodies with an attitude of their own turn about their centres.
        let radii = (0..scene.bodies().len())
            .filter(|&body| set.has_own_attitude(body))
            .map(|body| scale.length(scene.bodies()[body].bounding_radius()))
            .filter(|radius| *radius > 0.0);
        let shortest_lever = levers.chain(radii).fold(f64::INFINITY, f64::min);
        Ok(Self {
            scene: scene.clone(),
            scale,
            set,
            loads: bodies()
                .map(|b| scale.load(b.total_force(), b.torque))
                .collect(),
            to_frame: UnitQuaternion::identity(),
            shortest_lever,
        })
    }

    /// Enters the external loads of the scene, turned into another frame.
    pub fn turn_loads(&mut self, rotation: &UnitQuaternion<f64>) {
        let load = |body: &Body| {
            let (force, torque) = (body.total_force(), body.torque);
            self.scale.load(rotation * force, rotation * torque)
        };
        self.loads = self.scene.bodies().iter().map(load).collect();
        self.to_frame = *rotation;
    }

    /// Poses of all bodies in a configuration.
    ///
    /// # Errors
    /// Values of joints for which a loop does not close.
    pub fn poses(&self, configuration: Configuration) -> Result<Vec<Isometry3<f64>>, ModelError> {
        let state = self.state(configuration);
        Ok(self.set.place(&state, &self.values(configuration.shape))?)
    }

    /// Centres of the bodies with surfaces in a configuration.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn centres(&self, configuration: Configuration) -> Result<Vec<Vector3<f64>>, ModelError> {
        let poses = self.poses(configuration)?;
        let centres = self.surfaced().map(|body| poses[body].translation.vector);
        Ok(centres.collect())
    }

    /// Indices of the bodies with surfaces.
    pub fn surfaced(&self) -> impl Iterator<Item = usize> {
        let kinds = self.set.kinds().iter().enumerate();
        kinds
            .filter(|(_, kind)| **kind == BodyKind::Rigid)
            .map(|(body, _)| body)
    }

    /// Stresslets in the units of the scene from those of the bodies with surfaces, without
    /// correction and error bar.
    pub fn stresslets_to_scene(&self, scaled: &[Matrix3<f64>]) -> Stresslets {
        let mut bodies = vec![Matrix3::zeros(); self.set.kinds().len()];
        for (body, stresslet) in self.surfaced().zip(scaled) {
            bodies[body] = self.scale.torque_to_scene(*stresslet);
        }
        Stresslets {
            uncorrected: bodies.clone(),
            bodies,
            error: None,
        }
    }

    /// Constraints of the joints in the configuration of a query, for one rate per joint, with the
    /// inertia of the bodies and all forces on the joints.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`]; forces for another number of joints.
    pub fn query_constraints(
        &self,
        query: &Query,
        rates: &[f64],
    ) -> Result<Constraints, ModelError> {
        let mut constraints = self.constraints(query.configuration, rates)?;
        if let Some(forces) = query.joint_forces {
            let joints = self.set.passive_joints();
            if forces.len() != constraints.joint_forces.len() {
                return Err(ModelError::WrongCount {
                    model: "query",
                    what: "forces on passive joints",
                    found: forces.len(),
                    expected: constraints.joint_forces.len(),
                });
            }
            let sums = constraints.joint_forces.iter_mut().zip(joints).zip(forces);
            for ((sum, joint), force) in sums {
                *sum += self.scale.joint_force(joint, *force);
            }
        }
        for (body, inertia) in query.inertia.into_iter().flatten().enumerate() {
            let has_surface = self.set.kinds().get(body) == Some(&BodyKind::Rigid);
            if has_surface && inertia.damping != Matrix6::zeros() {
                let damping = self.scale.body_resistance(&inertia.damping);
                constraints.body_damping.push((body, damping));
            }
        }
        Ok(constraints)
    }

    /// Constraints of the joints in a configuration, for one rate per joint.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn constraints(
        &self,
        configuration: Configuration,
        rates: &[f64],
    ) -> Result<Constraints, ModelError> {
        let state = self.state(configuration);
        let [lengths, rates] = [configuration.shape, rates].map(|list| self.values(list));
        Ok(self.set.constraints(&state, &lengths, &rates)?)
    }

    /// External loads in a configuration, with those of the inertia of the bodies.
    ///
    /// Weights that act off the position of their body have torques that turn with it.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn loads(
        &self,
        configuration: Configuration,
        inertia: Option<&[BodyInertia]>,
    ) -> Result<Vec<ExternalLoad>, ModelError> {
        let mut loads = self.loads_of_inertia(inertia).into_owned();
        let off_position =
            |body: &Body| body.weight != Vector3::zeros() && body.weight_arm().is_some();
        if self.scene.bodies().iter().any(off_position) {
            let poses = self.poses(configuration)?;
            for ((load, body), pose) in loads.iter_mut().zip(self.scene.bodies()).zip(poses) {
                let from_start = self.to_frame.inverse() * pose.rotation;
                let torque = self.to_frame * body.weight_torque(&from_start);
                load.torque += self.scale.load(Vector3::zeros(), torque).torque;
            }
        }
        Ok(loads)
    }

    fn loads_of_inertia(&self, inertia: Option<&[BodyInertia]>) -> Cow<'_, [ExternalLoad]> {
        let Some(inertia) = inertia else {
            return Cow::Borrowed(&self.loads);
        };
        let sum = |(load, inertia): (&ExternalLoad, &BodyInertia)| {
            let own = self.scale.load(inertia.load.force, inertia.load.torque);
            ExternalLoad {
                force: load.force + own.force,
                torque: load.torque + own.torque,
            }
        };
        self.loads.iter().zip(inertia).map(sum).collect()
    }

    /// Motion and loads in the units of the scene.
    pub fn response_to_scene(&self, scaled: ScaledResponse) -> Response {
        let scale = &self.scale;
        let vector = |list: &DVector<f64>, first| list.fixed_rows::<3>(first).into_owned();
        let layout = self.set.velocity_layout();
        let mut bodies: Vec<BodySolution> = (scaled.motion.spins.iter().zip(layout.bodies()))
            .map(|(spin, &first)| BodySolution {
                velocity: scale.length_to_scene(vector(scaled.generalised, first)),
                angular_velocity: *spin,
                ..BodySolution::default()
            })
            .collect();
        for (number, body) in self.surfaced().enumerate() {
            let [force, torque] = [0, 3].map(|part| vector(scaled.forces, 6 * number + part));
            bodies[body].force = scale.force_to_scene(force);
            bodies[body].torque = scale.torque_to_scene(torque);
        }
        let joint_loads = self.set.joints().iter().zip(&scaled.joint_loads);
        Response {
            motion: self.motion_to_scene(scaled.motion),
            bodies,
            joint_loads: joint_loads
                .map(|(joint, load)| scale.joint_load_to_scene(joint, load))
                .collect(),
            slip_power: scale.power_to_scene(scaled.slip_power),
        }
    }

    /// Rate of change of the state in the units of the scene.
    pub fn motion_to_scene(&self, motion: &StateVelocity) -> StateVelocity {
        self.scale
            .motion_to_scene(motion, self.set.passive_joints())
    }

    fn state(&self, configuration: Configuration) -> State {
        self.scale
            .state(configuration.state, self.set.passive_joints())
    }

    /// Scaled values, or rates, of all joints.
    fn values(&self, list: &[f64]) -> Vec<f64> {
        let joints = self.set.joints().iter().zip(list);
        joints
            .map(|(joint, &value)| self.scale.value(joint, value))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The weight of a helix with a part of a turn has no torque about its centroid, however it is
    /// turned.
    #[test]
    fn the_weight_of_a_helix_acts_at_its_centroid() {
        let text = "gravity = [0.3, -2, -9.81]\nfluid = { viscosity = 3, density = 1 }\n\
             [[bodies]]\nname = \"h\"\nshape = \"helix\"\nradius = 0.6\ntube_radius = 0.2\n\
             pitch = 1.2\nturns = 1.4\ndensity = 2.5\nposition = [1, 2, 3]\n\
             orientation = [10, 40, -30]\ntorque = [0.1, 0, 0]\n";
        let scene = Scene::parse(text).unwrap();
        let body = &scene.bodies()[0];
        let mut scaled = ScaledScene::new(&scene).unwrap();
        let mut state = scene.initial_state();
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(0.7, -0.4, 1.1));
        for (to_frame, factor) in [(UnitQuaternion::identity(), 0.0), (turn.inverse(), 1.0)] {
            let rotation = turn.powf(1.0 - factor);
            // A single body has its own attitude.
            state.attitudes[0] = rotation;
            let configuration = Configuration {
                state: &state,
                shape: &[],
            };
            scaled.turn_loads(&to_frame);
            let load = scaled.loads(configuration, None).unwrap()[0];
            let weight = to_frame * body.weight;
            let arm = rotation * body.shape.centroid();
            assert!(arm.norm() > 0.05);
            let expected = scaled
                .scale
                .load(weight, arm.cross(&weight) + to_frame * body.torque);
            assert!((load.force - expected.force).norm() < 1e-12 * load.force.norm());
            assert!((load.torque - expected.torque).norm() < 1e-12 * load.torque.norm());
        }
    }
}
