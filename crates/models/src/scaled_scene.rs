//! Bodies, joints and loads of a scene in scaled units: the input of every model.

use nalgebra::{DVector, Isometry3, Matrix3, Matrix6, UnitQuaternion, Vector3};
use rayon::prelude::*;
use rigid::{
    Arms, Articulation, BodyKind, Constraints, ExternalLoad, FlowSolution, JointLoad, LinkagePart,
    RigidError, State, StateVelocity, Twist,
};

use crate::error::ModelError;
use crate::query::{BodyInertia, Configuration, Query};
use crate::response::{BodySolution, HoldingLoad, MeanFlow, Response};
use crate::solution::Stresslets;
use crate::units::Scale;
use scene::rheology::Law;
use scene::{Background, Deformation, Scene};

/// Bodies, joints and loads of a scene in scaled units.
#[derive(Clone)]
pub(crate) struct ScaledScene {
    /// The scene, in its own units.
    pub scene: Scene,
    pub scale: Scale,
    /// Bodies and joints.
    pub set: Articulation,
    /// The linkages of the set.
    pub parts: Vec<LinkagePart>,
    /// External loads at the start, one per body, in a frame with the rotation `to_frame` from the
    /// laboratory; none if they depend on the time or on attitudes.
    constant_loads: Option<Vec<ExternalLoad>>,
    /// The rotation.
    to_frame: UnitQuaternion<f64>,
    /// Distance from the root of a linkage to its farthest point, of the smallest linkage, or the
    /// radius of a body with an attitude of its own if that is shorter: errors of velocities over
    /// it are errors of angular velocities.
    pub shortest_lever: f64,
}

/// What is given of the flow through a periodic box, in scaled units; the other one is a result.
#[derive(Clone, Copy)]
pub(crate) enum MeanFlowCondition {
    /// Its mean velocity; zero outside of periodic boxes.
    Velocity(Vector3<f64>),
    /// The total force of the bodies on the fluid: the mean pressure gradient times the volume.
    TotalForce(Vector3<f64>),
}

impl Default for MeanFlowCondition {
    fn default() -> Self {
        Self::Velocity(Vector3::zeros())
    }
}

/// Motion and loads of the bodies, or a change of them, in scaled units.
pub(crate) struct ScaledResponse<'a> {
    pub motion: &'a StateVelocity,
    /// Generalised velocities of all bodies.
    pub generalised: &'a DVector<f64>,
    /// Forces and torques of the bodies with surfaces, six numbers each.
    pub forces: &'a DVector<f64>,
    pub joint_loads: Vec<JointLoad>,
    /// Loads that hold bodies, with the indices of the bodies.
    pub holding: Vec<(usize, ExternalLoad)>,
    /// Mean flow of a periodic box; zero elsewhere.
    pub mean_flow: Vector3<f64>,
    pub slip_power: f64,
    /// Rates of the amplitudes of deformations and the forces on them, in the order of
    /// [`ScaledScene::amplitudes`].
    pub amplitudes: Vec<(f64, f64)>,
}

impl<'a> ScaledResponse<'a> {
    /// Motion and loads of a flow.
    ///
    /// # Errors
    /// A flow of other joints.
    pub fn of_flow(
        flow: &'a FlowSolution,
        slip_power: f64,
        amplitudes: Vec<(f64, f64)>,
        set: &Articulation,
    ) -> Result<Self, ModelError> {
        Ok(Self {
            motion: &flow.state,
            generalised: &flow.generalised,
            forces: &flow.forces,
            joint_loads: (0..set.joints().len())
                .map(|joint| flow.joint_load(joint))
                .collect::<Result<_, _>>()?,
            holding: flow.holding_loads(),
            mean_flow: Vector3::zeros(),
            slip_power,
            amplitudes,
        })
    }
}

impl ScaledScene {
    /// What is given of the flow through a periodic box: no mean flow unless the scene says more.
    pub fn mean_flow(&self) -> MeanFlowCondition {
        let Some(size) = self.scene.domain().period() else {
            return MeanFlowCondition::default();
        };
        match self.scene.background() {
            Some(Background::Uniform { velocity }) => {
                MeanFlowCondition::Velocity(self.scale.length(*velocity))
            }
            Some(Background::PressureGradient { gradient }) => {
                let total = size.product() * gradient;
                MeanFlowCondition::TotalForce(self.scale.load(total, Vector3::zeros()).force)
            }
            _ => MeanFlowCondition::default(),
        }
    }

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
        .with_held(
            &held_bodies(scene.articulation().held_translation()),
            &held_bodies(scene.articulation().held_rotation()),
        )?;
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
        let mut scaled = Self {
            scene: scene.clone(),
            scale,
            parts: set.parts(),
            set,
            constant_loads: None,
            to_frame: UnitQuaternion::identity(),
            shortest_lever,
        };
        scaled.turn_loads(&UnitQuaternion::identity());
        Ok(scaled)
    }

    /// Enters the external loads and given velocities of the scene, turned into another frame.
    pub fn turn_loads(&mut self, rotation: &UnitQuaternion<f64>) {
        self.to_frame = *rotation;
        let are_constant = !self.scene.has_posed_loads() && !self.scene.depends_on_time();
        self.constant_loads = are_constant.then(|| self.scaled_loads(0.0, &[]));
    }

    /// The loads of the scene in the frame, at a time and for these poses of the bodies in the
    /// laboratory.
    fn scaled_loads(&self, time: f64, poses: &[Isometry3<f64>]) -> Vec<ExternalLoad> {
        let in_frame = |load: ExternalLoad| {
            let (force, torque) = (self.to_frame * load.force, self.to_frame * load.torque);
            self.scale.load(force, torque)
        };
        let loads = self.scene.loads(time, poses).into_iter();
        loads.map(in_frame).collect()
    }

    /// Scaled viscosity law that the flow follows; none at constant viscosity.
    pub fn law(&self) -> Option<Law> {
        self.scene.viscosity_law().map(|law| self.scale.law(*law))
    }

    /// Scaled viscosity law of the scene, whether the flow follows it or not.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for a Newtonian fluid.
    pub fn neglected_law(&self) -> Result<Law, ModelError> {
        let rheology = self.scene.rheology();
        let law = rheology.map(|rheology| self.scale.law(rheology.law));
        law.ok_or_else(|| {
            let what = "the effect of a viscosity law on a fluid without one";
            ModelError::unsupported(what, "set fluid.law")
        })
    }

    /// Refuses a viscosity that depends on the shear rate.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] with the place of the key.
    pub fn check_constant_viscosity(&self, what: &str) -> Result<(), ModelError> {
        match self.law() {
            None => Ok(()),
            Some(_) => Err(ModelError::unsupported(
                format!(
                    "{}: {what} of a fluid whose viscosity depends on the shear rate",
                    self.scene.place("fluid.law")
                ),
                "set fluid.rheology = \"newtonian\"",
            )),
        }
    }

    /// Joints that are amplitudes of deformations.
    pub fn amplitudes(&self) -> impl Iterator<Item = usize> + '_ {
        let joints = self.set.joints().iter().enumerate();
        joints
            .filter(|(_, joint)| joint.kind.is_deformation())
            .map(|(number, _)| number)
    }

    /// Scaled radii of the bodies with surfaces, which are spheres or, if they deform, spheres of
    /// the same size before their modes.
    ///
    /// # Errors
    /// Values of the joints at which a body cannot be.
    pub fn sphere_radii(&self, values: &[f64]) -> Result<Vec<f64>, ModelError> {
        self.scene.check_deformations(values).map_err(Box::new)?;
        let radius = |body: usize| {
            let body = &self.scene.bodies()[body];
            let sphere = body.deformation.as_ref().and_then(Deformation::sphere);
            let radius = match sphere {
                Some(sphere) => sphere.sphere_radius(values),
                None => body.shape.sphere_radius().unwrap_or(body.bounding_radius()),
            };
            self.scale.length(radius)
        };
        Ok(self.surfaced().map(radius).collect())
    }

    /// Refuses rates at which the volume of the bodies changes in a container.
    ///
    /// # Errors
    /// [`ModelError::Scene`] with the rate.
    pub fn check_volume(
        &self,
        configuration: Configuration,
        rates: &[f64],
    ) -> Result<(), ModelError> {
        let checked = self.scene.check_volume_rate(configuration.shape, rates);
        Ok(checked.map_err(Box::new)?)
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
    /// inertia of the bodies.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn query_constraints(
        &self,
        query: &Query,
        rates: &[f64],
    ) -> Result<Constraints, ModelError> {
        let mut constraints = self.constraints(query.configuration, rates)?;
        for (body, inertia) in query.inertia.into_iter().flatten().enumerate() {
            let damping = self.body_damping(body, inertia);
            constraints
                .body_damping
                .extend(damping.map(|block| (body, block)));
        }
        Ok(constraints)
    }

    /// Scaled resistance of a body to the time step of its inertia; none without one.
    fn body_damping(&self, body: usize, inertia: &BodyInertia) -> Option<Matrix6<f64>> {
        let has_surface = self.set.kinds().get(body) == Some(&BodyKind::Rigid);
        let resists = has_surface && inertia.damping != Matrix6::zeros();
        resists.then(|| self.scale.body_resistance(&inertia.damping))
    }

    /// [`ScaledScene::query_constraints`] of each linkage, one after the other.
    ///
    /// # Errors
    /// A state that does not fit; in each linkage as [`ScaledScene::poses`].
    pub fn part_constraints(
        &self,
        query: &Query,
        rates: &[f64],
    ) -> Result<Vec<Result<Constraints, ModelError>>, ModelError> {
        let configuration = query.configuration;
        let state = self.state(configuration);
        let [values, rates] = [configuration.shape, rates].map(|list| self.values(list));
        let forces = self.scene.joint_forces(configuration.time);
        if let Some(loads) = query.random_loads {
            let expected = self.load_units().len();
            if loads.len() != expected {
                return Err(ModelError::unsupported(
                    format!("{} random loads on {expected} velocities", loads.len()),
                    "use those of Fluctuations::random_loads for this scene",
                ));
            }
        }
        let random = (query.random_loads).map(|loads| loads.component_div(&self.load_units()));
        let of_part = |part: &LinkagePart| {
            let (own_values, own_rates) = (part.of_joints(&values), part.of_joints(&rates));
            let set = part.set();
            let mut constraints = set.constraints(&part.state(&state), &own_values, &own_rates)?;
            let sums = constraints.joint_forces.iter_mut();
            for ((sum, joint), &place) in sums.zip(set.passive_joints()).zip(part.passive_joints())
            {
                let force = forces.as_ref().and_then(|forces| forces.get(place));
                *sum += force.map_or(0.0, |force| self.scale.joint_force(joint, *force));
            }
            constraints.random_loads =
                (random.as_ref()).map(|loads| loads.select_rows(part.velocities()));
            for own in set.held_bodies() {
                let twist = self.scaled_held_twist(configuration.time, part.bodies()[own]);
                constraints = constraints.with_held_velocity(own, twist)?;
            }
            for (own, &body) in part.bodies().iter().enumerate() {
                let inertia = query.inertia.and_then(|all| all.get(body));
                let damping = inertia.and_then(|inertia| self.body_damping(body, inertia));
                constraints
                    .body_damping
                    .extend(damping.map(|block| (own, block)));
            }
            Ok(constraints)
        };
        Ok(self.parts.par_iter().map(of_part).collect())
    }

    /// Constraints of the joints in a configuration, for one rate per joint, with the given
    /// velocities of bodies and all forces on the joints.
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
        let joints = self.set.constraints(&state, &lengths, &rates)?;
        Ok(self.with_drives(configuration.time, joints)?)
    }

    /// Constraints of the joints with the given velocities of bodies and the forces on joints at a
    /// time.
    ///
    /// # Errors
    /// Those of [`Constraints::with_held_velocity`].
    pub fn with_drives(
        &self,
        time: f64,
        mut constraints: Constraints,
    ) -> Result<Constraints, RigidError> {
        if let Some(forces) = self.scene.joint_forces(time) {
            let sums = constraints.joint_forces.iter_mut();
            let joints = self.set.passive_joints().zip(forces);
            for (sum, (joint, force)) in sums.zip(joints) {
                *sum += self.scale.joint_force(joint, force);
            }
        }
        for body in self.set.held_bodies() {
            constraints =
                constraints.with_held_velocity(body, self.scaled_held_twist(time, body))?;
        }
        Ok(constraints)
    }

    /// Loads in the scene of scaled ones of one, conjugate to the generalised velocities.
    pub fn load_units(&self) -> DVector<f64> {
        let layout = self.set.velocity_layout();
        let (force, torque) = (
            self.scale.force_to_scene(1.0),
            self.scale.torque_to_scene(1.0),
        );
        let mut units = DVector::from_element(layout.len(), torque);
        for &first in layout.bodies() {
            units.rows_mut(first, 3).fill(force);
        }
        for (column, joint) in layout.joints().zip(self.set.passive_joints()) {
            units[column] = 1.0 / self.scale.joint_force(joint, 1.0);
        }
        units
    }

    /// Scaled given velocity of a body at a time in the frame.
    fn scaled_held_twist(&self, time: f64, body: usize) -> Twist {
        let twist = self.held_twist(time, body);
        Twist {
            linear: self.scale.length(twist.linear),
            ..twist
        }
    }

    /// Given velocity of a body at a time in the frame, in the units of the scene.
    fn held_twist(&self, time: f64, body: usize) -> Twist {
        let twist = self.scene.bodies()[body].held_twist(time);
        Twist {
            linear: self.to_frame * twist.linear,
            angular: self.to_frame * twist.angular,
        }
    }

    /// External loads in a configuration, with those of the inertia of the bodies.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn loads(
        &self,
        configuration: Configuration,
        inertia: Option<&[BodyInertia]>,
    ) -> Result<Vec<ExternalLoad>, ModelError> {
        let mut loads = match &self.constant_loads {
            Some(loads) => loads.clone(),
            None => self.loads_at(configuration.time, &self.poses(configuration)?),
        };
        for (load, inertia) in loads.iter_mut().zip(inertia.into_iter().flatten()) {
            let own = self.scale.load(inertia.load.force, inertia.load.torque);
            load.force += own.force;
            load.torque += own.torque;
        }
        Ok(loads)
    }

    /// External loads at a time on bodies with these scaled poses.
    pub fn loads_at(&self, time: f64, poses: &[Isometry3<f64>]) -> Vec<ExternalLoad> {
        let to_laboratory = self.to_frame.inverse();
        let in_scene = |pose: &Isometry3<f64>| {
            let mut pose = *pose;
            let position = &mut pose.translation.vector;
            *position = position.map(|x| self.scale.length_to_scene(x));
            to_laboratory * pose
        };
        self.scaled_loads(time, &poses.iter().map(in_scene).collect::<Vec<_>>())
    }

    /// Motion and loads at a time, in the units of the scene.
    pub fn response_to_scene(&self, time: f64, scaled: ScaledResponse) -> Response {
        let mut response = self.change_to_scene(scaled);
        self.enter_held_velocities(time, &mut response);
        // Forces have what is given up to rounding.
        if let (Some(flow), Some(Background::PressureGradient { gradient })) =
            (&mut response.mean_flow, self.scene.background())
        {
            flow.pressure_gradient = *gradient;
        }
        response
    }

    /// Change of motion and loads in the units of the scene.
    pub fn change_to_scene(&self, scaled: ScaledResponse) -> Response {
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
        let mean_flow = self.scene.domain().period().map(|size| MeanFlow {
            velocity: scale.length_to_scene(scaled.mean_flow),
            pressure_gradient: bodies.iter().map(|body| body.force).sum::<Vector3<f64>>()
                / size.product(),
        });
        let holding = scaled.holding.into_iter().map(|(body, load)| HoldingLoad {
            body,
            force: scale.force_to_scene(load.force),
            torque: scale.torque_to_scene(load.torque),
        });
        let joints = self.set.joints();
        let mut joint_loads = scaled.joint_loads;
        let mut amplitude_rates = match scaled.amplitudes.is_empty() {
            true => Vec::new(),
            false => vec![0.0; joints.len()],
        };
        for (joint, (rate, drive)) in self.amplitudes().zip(scaled.amplitudes) {
            amplitude_rates[joint] = rate / scale.value(&joints[joint], 1.0);
            joint_loads[joint].drive = drive;
        }
        Response {
            motion: self.motion_to_scene(scaled.motion),
            bodies,
            joint_loads: (joints.iter().zip(&joint_loads))
                .map(|(joint, load)| scale.joint_load_to_scene(joint, load))
                .collect(),
            amplitude_rates,
            holding: holding.collect(),
            mean_flow,
            slip_power: scale.power_to_scene(scaled.slip_power),
        }
    }

    /// Enters the given velocities, which solutions have up to the error of the solver alone.
    fn enter_held_velocities(&self, time: f64, response: &mut Response) {
        let (set, motion) = (&self.set, &mut response.motion);
        for body in set.held_bodies() {
            let twist = self.held_twist(time, body);
            let linkage = set.linkage_of()[body];
            let is_root = set.linkages()[linkage].root == body;
            if set.held_translation()[body] {
                response.bodies[body].velocity = twist.linear;
                if is_root {
                    motion.frames[linkage].linear = twist.linear;
                }
            }
            if set.held_rotation()[body] {
                response.bodies[body].angular_velocity = twist.angular;
                motion.spins[body] = twist.angular;
                let turns_frame =
                    set.arms() == Arms::Clamped || set.linkages()[linkage].bodies.len() == 1;
                if is_root && turns_frame {
                    motion.frames[linkage].angular = twist.angular;
                }
            }
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

    /// Scaled values, rates or accelerations of all joints.
    pub fn values(&self, list: &[f64]) -> Vec<f64> {
        let joints = self.set.joints().iter().zip(list);
        joints
            .map(|(joint, &value)| self.scale.value(joint, value))
            .collect()
    }
}

/// Indices of the bodies that are marked.
fn held_bodies(held: &[bool]) -> Vec<usize> {
    (0..held.len()).filter(|&body| held[body]).collect()
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
            let configuration = Configuration::new(&state, &[]);
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
