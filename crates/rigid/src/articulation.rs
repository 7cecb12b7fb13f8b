//! Articulated sets: bodies connected by joints, and the graph that they form.

use nalgebra::Vector3;

use crate::RigidError;
use crate::error::{check_finite, check_length};
use crate::joint::{ArmVectors, Arms, Joint, PassiveDrive};
use crate::linkage::{Linkage, find_linkages};

/// The kind of a member of an articulated set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum BodyKind {
    /// A rigid body with a surface: three velocities and three angular velocities.
    Rigid,
    /// A massless point without a surface, such as a junction of arms: three velocities.
    Point,
}

/// Bodies, the joints between them, and the arms of the joints in the frames of their bodies.
#[derive(Clone, Debug)]
pub struct Articulation {
    kinds: Vec<BodyKind>,
    joints: Vec<Joint>,
    arms: Arms,
    arm_vectors: Vec<ArmVectors>,
    linkages: Vec<Linkage>,
    linkage_of: Vec<usize>,
    frame_of: Vec<usize>,
    /// Number of frames.
    frames: usize,
    /// For each body, whether its attitude is part of the state.
    own_attitude: Vec<bool>,
    initial_positions: Vec<Vector3<f64>>,
    initial_shape: Vec<f64>,
    /// For each body, whether its velocity is given.
    held_translation: Vec<bool>,
    /// For each body, whether its angular velocity is given.
    held_rotation: Vec<bool>,
    /// Numbers of the bodies in messages: those of the whole set for a part of one.
    body_numbers: Vec<usize>,
}

impl Articulation {
    /// Joins `kinds.len()` bodies at `positions` by `joints`.
    ///
    /// The positions give the directions and the initial lengths of the slides. Any graph is
    /// allowed: chains, stars, loops, several separate linkages, bodies without joints. The root
    /// of a linkage is its body with the lowest index, unless bodies are held.
    ///
    /// # Errors
    /// A joint to a body that does not exist, a slide between coincident bodies, a point without a
    /// joint, a position or a distance that is not finite, a joint or drive that is not valid,
    /// joints that turn with [`Arms::Lab`], balls with other arms than [`Arms::Clamped`].
    pub fn new(
        kinds: &[BodyKind],
        joints: Vec<Joint>,
        arms: Arms,
        positions: &[Vector3<f64>],
    ) -> Result<Self, RigidError> {
        let bodies = kinds.len();
        check_length("positions of the bodies", positions.len(), bodies)?;
        check_finite("a body's position", positions.iter().flatten())?;
        let mut arm_vectors = Vec::with_capacity(joints.len());
        let mut initial_shape = Vec::with_capacity(joints.len());
        for joint in &joints {
            for body in [joint.body, joint.to] {
                if body >= bodies {
                    return Err(RigidError::NoSuchBody {
                        joint: joint.name.clone(),
                        body,
                        bodies,
                    });
                }
            }
            joint.check(arms)?;
            let (arm, value) = joint.initial_arm(positions)?;
            arm_vectors.push(arm);
            initial_shape.push(value);
        }
        let free = vec![false; bodies];
        let (linkages, frames) = find_linkages(&free, &joints);
        let mut linkage_of = vec![0; bodies];
        for (number, linkage) in linkages.iter().enumerate() {
            if let [body] = linkage.bodies[..]
                && kinds[body] == BodyKind::Point
            {
                return Err(RigidError::LoosePoint { body });
            }
            for &body in &linkage.bodies {
                linkage_of[body] = number;
            }
        }
        let own_attitude = own_attitudes(kinds, &joints, arms, &linkages);
        Ok(Self {
            kinds: kinds.to_vec(),
            joints,
            arms,
            arm_vectors,
            linkages,
            linkage_of,
            frame_of: frames.of_body,
            frames: frames.count,
            own_attitude,
            initial_positions: positions.to_vec(),
            initial_shape,
            held_translation: free.clone(),
            held_rotation: free,
            body_numbers: (0..bodies).collect(),
        })
    }

    /// The same set with some bodies held, with or without joints: the velocities of the bodies
    /// `translations` and the angular velocities of the bodies `rotations` are given. They are zero
    /// unless [`Constraints::with_held_velocity`](crate::Constraints::with_held_velocity) enters
    /// others.
    ///
    /// A body whose translation is held is the root of its linkage.
    ///
    /// # Errors
    /// [`RigidError::HeldBody`] for a body that does not exist or is a point.
    pub fn with_held(
        mut self,
        translations: &[usize],
        rotations: &[usize],
    ) -> Result<Self, RigidError> {
        for (bodies, held) in [
            (translations, &mut self.held_translation),
            (rotations, &mut self.held_rotation),
        ] {
            for &body in bodies {
                let problem = match self.kinds.get(body) {
                    None => "there is no such body",
                    Some(BodyKind::Point) => "it is a point, which has no surface",
                    Some(BodyKind::Rigid) => {
                        held[body] = true;
                        continue;
                    }
                };
                return Err(RigidError::HeldBody { body, problem });
            }
        }
        let (linkages, frames) = find_linkages(&self.held_translation, &self.joints);
        self.own_attitude = own_attitudes(&self.kinds, &self.joints, self.arms, &linkages);
        (self.linkages, self.frame_of, self.frames) = (linkages, frames.of_body, frames.count);
        Ok(self)
    }

    /// The same set with other values of the joints at the start; poses, axes and pivots stay those
    /// given to [`Articulation::new`].
    ///
    /// # Errors
    /// A list of the wrong length, values that [`Articulation::place`] refuses.
    pub fn with_initial_values(mut self, values: &[f64]) -> Result<Self, RigidError> {
        check_length(
            "initial values of the joints",
            values.len(),
            self.joints.len(),
        )?;
        self.initial_shape = values.to_vec();
        self.placement(&self.initial_state(), values)?;
        Ok(self)
    }

    /// Whether the velocity of each body is given.
    pub fn held_translation(&self) -> &[bool] {
        &self.held_translation
    }

    /// Whether the angular velocity of each body is given.
    pub fn held_rotation(&self) -> &[bool] {
        &self.held_rotation
    }

    /// The bodies whose velocity or angular velocity is given.
    pub fn held_bodies(&self) -> impl Iterator<Item = usize> {
        let held = self.held_translation.iter().zip(&self.held_rotation);
        held.enumerate()
            .filter(|(_, (translation, rotation))| **translation || **rotation)
            .map(|(body, _)| body)
    }

    /// Kind of each body.
    pub fn kinds(&self) -> &[BodyKind] {
        &self.kinds
    }

    /// The joints.
    pub fn joints(&self) -> &[Joint] {
        &self.joints
    }

    /// Attachment of the bodies to their arms.
    pub fn arms(&self) -> Arms {
        self.arms
    }

    /// The connected sets of bodies.
    pub fn linkages(&self) -> &[Linkage] {
        &self.linkages
    }

    /// Index of the linkage that each body belongs to.
    pub fn linkage_of(&self) -> &[usize] {
        &self.linkage_of
    }

    /// Number of the frame that each body belongs to; a frame is a set of bodies that joints
    /// without rotation connect.
    pub fn frame_of(&self) -> &[usize] {
        &self.frame_of
    }

    /// The joints whose values are part of the state, with the forces on them.
    pub fn passive_drives(&self) -> impl Iterator<Item = (usize, &PassiveDrive)> {
        let numbered = self.joints.iter().enumerate();
        numbered.filter_map(|(number, joint)| Some((number, joint.passive_drive()?)))
    }

    /// Whether the attitude of a body is part of the state, and not that of its frame.
    ///
    /// Bodies that are clamped to a frame have its rotation, but for the first of a frame that a
    /// ball joins: its attitude is the rotation of the frame.
    pub fn has_own_attitude(&self, body: usize) -> bool {
        self.own_attitude.get(body) == Some(&true)
    }

    /// Largest distance of the two bodies of a joint at a value; zero for a joint that does not
    /// exist.
    pub fn arm_length(&self, joint: usize, value: f64) -> f64 {
        match self.joints.iter().zip(&self.arm_vectors).nth(joint) {
            Some((joint, arm)) => joint.kind.arm_length(value, arm),
            None => 0.0,
        }
    }

    /// Largest displacement of one body of a joint relative to the other where its value
    /// changes by `change`; zero for a joint that does not exist.
    pub fn arm_displacement(&self, joint: usize, change: f64) -> f64 {
        match self.joints.iter().zip(&self.arm_vectors).nth(joint) {
            Some((joint, arm)) => change.abs() * joint.kind.lever(arm),
            None => 0.0,
        }
    }

    /// The joints whose values are part of the state.
    pub fn passive_joints(&self) -> impl Iterator<Item = &Joint> {
        self.joints.iter().filter(|joint| joint.is_passive())
    }

    /// Values of the joints at the start: those at the positions given to [`Articulation::new`]
    /// (lengths of slides, zero for others) or [`Articulation::with_initial_values`].
    pub fn initial_shape(&self) -> &[f64] {
        &self.initial_shape
    }

    /// Positions given to [`Articulation::new`].
    pub(crate) fn initial_positions(&self) -> &[Vector3<f64>] {
        &self.initial_positions
    }

    /// Arms of the joints, in the axes of the frames.
    pub(crate) fn arm_vectors(&self) -> &[ArmVectors] {
        &self.arm_vectors
    }

    /// Whether the frames have angular velocities of their own.
    pub(crate) fn has_frame(&self, linkage: &Linkage) -> bool {
        self.arms != Arms::Lab && linkage.bodies.len() > 1
    }

    /// The set of some bodies, ascending, with all of their joints; `own_joints` are these joints
    /// with the new numbers of the bodies.
    pub(crate) fn subset(
        &self,
        bodies: &[usize],
        joints: &[usize],
        own_joints: Vec<Joint>,
    ) -> Self {
        let kinds = selected(&self.kinds, bodies);
        let held_translation = selected(&self.held_translation, bodies);
        let (linkages, frames) = find_linkages(&held_translation, &own_joints);
        let mut linkage_of = vec![0; bodies.len()];
        for (number, linkage) in linkages.iter().enumerate() {
            for &body in &linkage.bodies {
                linkage_of[body] = number;
            }
        }
        Self {
            own_attitude: own_attitudes(&kinds, &own_joints, self.arms, &linkages),
            kinds,
            joints: own_joints,
            arms: self.arms,
            arm_vectors: selected(&self.arm_vectors, joints),
            linkages,
            linkage_of,
            frame_of: frames.of_body,
            frames: frames.count,
            initial_positions: selected(&self.initial_positions, bodies),
            initial_shape: selected(&self.initial_shape, joints),
            held_translation,
            held_rotation: selected(&self.held_rotation, bodies),
            body_numbers: selected(&self.body_numbers, bodies),
        }
    }

    /// Number of a body in messages.
    pub(crate) fn body_number(&self, body: usize) -> usize {
        self.body_numbers[body]
    }

    /// Number of frames, of bodies without joints too.
    pub(crate) fn frames(&self) -> usize {
        self.frames
    }
}

/// Some entries of a list; indices beyond its end are left out.
pub(crate) fn selected<T: Clone>(all: &[T], some: &[usize]) -> Vec<T> {
    some.iter().filter_map(|&k| all.get(k)).cloned().collect()
}

/// For each body, whether its attitude is part of the state ([`Articulation::has_own_attitude`]).
fn own_attitudes(
    kinds: &[BodyKind],
    joints: &[Joint],
    arms: Arms,
    linkages: &[Linkage],
) -> Vec<bool> {
    let mut own: Vec<bool> = (kinds.iter())
        .map(|kind| arms != Arms::Clamped && *kind == BodyKind::Rigid)
        .collect();
    for linkage in linkages {
        if let [body] = linkage.bodies[..] {
            own[body] = true;
        }
        for edge in &linkage.tree {
            // Balls need clamped arms.
            own[edge.child] |= joints[edge.joint].kind.has_attitude();
        }
    }
    own
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separate_linkages_and_loose_points_are_found() {
        let x = [Vector3::zeros(), Vector3::x(), 5.0 * Vector3::y()];
        let joint = || vec![Joint::slide("0-1", 0, 1)];
        let set = Articulation::new(&[BodyKind::Rigid; 3], joint(), Arms::Free, &x).unwrap();
        assert_eq!(set.linkages().len(), 2);
        assert_eq!(set.linkage_of(), &[0, 0, 1]);
        let kinds = [BodyKind::Rigid, BodyKind::Rigid, BodyKind::Point];
        let loose = Articulation::new(&kinds, joint(), Arms::Free, &x);
        assert_eq!(loose.unwrap_err(), RigidError::LoosePoint { body: 2 });
    }
}
