//! Order of the generalised velocities of an articulated set.

use crate::{Articulation, BodyKind};

/// Positions of the velocities of bodies, frames and joints in the vector of generalised velocities
/// `q`.
///
/// Order: the bodies one after the other (rigid: `U`, `ω`; point: `U`), then the angular velocities
/// of the frames of each linkage of two or more bodies, unless arms keep their direction
/// ([`Arms::Lab`](crate::Arms::Lab)), then the rates of the passive joints.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VelocityLayout {
    bodies: Vec<usize>,
    frames: Vec<Option<usize>>,
    /// Indices of the passive joints, with the positions of their rates.
    joints: Vec<(usize, usize)>,
    /// Number of velocities of bodies.
    end_of_bodies: usize,
    len: usize,
}

impl VelocityLayout {
    /// Number of generalised velocities.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no generalised velocities.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Index of the first velocity component of a body; for a rigid body `ω` follows `U`.
    ///
    /// `None` for a body that does not exist.
    pub fn body(&self, body: usize) -> Option<usize> {
        self.bodies.get(body).copied()
    }

    /// Index of the first component of a frame's angular velocity, if the frame has its own.
    ///
    /// Frames are numbered as in [`Articulation::frame_of`].
    pub fn frame(&self, frame: usize) -> Option<usize> {
        self.frames.get(frame).copied().flatten()
    }

    /// Index of the rate of a joint, if it is passive.
    pub fn joint(&self, joint: usize) -> Option<usize> {
        let mut joints = self.joints.iter();
        joints
            .find(|(number, _)| *number == joint)
            .map(|(_, column)| *column)
    }

    /// Indices of the rates of all passive joints.
    pub fn joints(&self) -> impl Iterator<Item = usize> {
        self.joints.iter().map(|(_, column)| *column)
    }

    /// Whether a body has velocities `U` and `ω`; points have `U` only.
    pub(crate) fn is_rigid(&self, body: usize) -> bool {
        let next = self.body(body + 1).unwrap_or(self.end_of_bodies);
        self.body(body).is_some_and(|first| first + 6 == next)
    }

    /// Index of the first velocity component of each body.
    pub fn bodies(&self) -> &[usize] {
        &self.bodies
    }
}

impl Articulation {
    /// Positions of all velocities in the vector of generalised velocities.
    pub fn velocity_layout(&self) -> VelocityLayout {
        let mut len = 0;
        let bodies = self
            .kinds()
            .iter()
            .map(|kind| {
                let first = len;
                len += if *kind == BodyKind::Rigid { 6 } else { 3 };
                first
            })
            .collect();
        let end_of_bodies = len;
        let mut frames = vec![None; self.frames()];
        for linkage in self
            .linkages()
            .iter()
            .filter(|linkage| self.has_frame(linkage))
        {
            for &body in &linkage.bodies {
                frames[self.frame_of()[body]] = Some(0);
            }
        }
        for frame in frames.iter_mut().flatten() {
            *frame = len;
            len += 3;
        }
        let joints = self.passive_drives().map(|(joint, _)| {
            len += 1;
            (joint, len - 1)
        });
        VelocityLayout {
            bodies,
            frames,
            joints: joints.collect(),
            end_of_bodies,
            len,
        }
    }

    /// Indices of the generalised velocities by which the [`State`](crate::State) changes, each
    /// once: of the roots of linkages, their first frames, the attitudes of bodies that have their
    /// own, and the passive joints.
    ///
    /// A load on them does not depend on the configuration: positions are vectors, and angular
    /// velocities are in the laboratory axes. All other velocities follow from these and from the
    /// rates of the joints.
    pub fn state_velocities(&self) -> Vec<usize> {
        let layout = self.velocity_layout();
        let spin = |body: usize| match self.kinds()[body] {
            BodyKind::Rigid => Some(layout.bodies[body] + 3),
            BodyKind::Point => layout.frame(self.frame_of()[body]),
        };
        let mut vectors = Vec::new();
        for linkage in self.linkages() {
            vectors.push(layout.bodies[linkage.root]);
            vectors.extend(layout.frame(linkage.first_frame));
        }
        let own = (0..self.kinds().len()).filter(|&body| self.has_own_attitude(body));
        vectors.extend(own.filter_map(spin));
        let entries = vectors.into_iter().flat_map(|first| first..first + 3);
        entries.chain(layout.joints()).collect()
    }

    /// Indices of the generalised velocities `(U, ω)` of bodies with surfaces, six per body.
    pub fn surface_velocities(&self) -> Vec<usize> {
        let layout = self.velocity_layout();
        (0..self.kinds().len())
            .filter(|&body| self.kinds()[body] == BodyKind::Rigid)
            .flat_map(|body| layout.bodies[body]..layout.bodies[body] + 6)
            .collect()
    }
}
