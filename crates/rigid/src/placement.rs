//! Poses of all bodies from frames and joint values: the product of exponentials along trees.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::error::{check_finite, check_length};
use crate::joint::JointKind;
use crate::{Articulation, Joint, RigidError, State};

/// Positions of all bodies and rotations of all frames.
pub(crate) struct Placement {
    pub positions: Vec<Vector3<f64>>,
    pub rotations: Vec<UnitQuaternion<f64>>,
    /// Values of all joints, those of the state included.
    pub values: Vec<f64>,
}

impl Articulation {
    /// Directions of the joints in the laboratory axes: from `to` to `body` for slides, along the
    /// axis for joints that have one, zero for others.
    ///
    /// # Errors
    /// As [`Articulation::place`].
    pub fn directions(
        &self,
        state: &State,
        shape: &[f64],
    ) -> Result<Vec<Vector3<f64>>, RigidError> {
        let placement = self.placement(state, shape)?;
        let numbers = 0..self.joints().len();
        Ok(numbers
            .map(|joint| self.direction(&placement, joint))
            .collect())
    }

    pub(crate) fn direction(&self, placement: &Placement, joint: usize) -> Vector3<f64> {
        let frame = self.frame_of()[self.joints()[joint].to];
        placement.rotations[frame] * self.arm_vectors()[joint].direction
    }

    /// Values of all joints: those of the passive ones from the state, with closed loops, of others
    /// from `shape`.
    ///
    /// # Errors
    /// As [`Articulation::place`].
    pub fn joint_values(&self, state: &State, shape: &[f64]) -> Result<Vec<f64>, RigidError> {
        Ok(self.placement(state, shape)?.values)
    }

    /// Poses of all bodies, points included, for given values of the joints: the lengths of slides,
    /// the angles of others.
    ///
    /// With `Q` the rotation of the frame of `to` and `Q'` that of `body`, along the spanning tree
    /// of each linkage:
    ///
    /// ```text
    /// slide of the length l:  x_body = x_to + l Q e,  Q' = Q
    /// turn by the angle v:    x_body = x_to + Q (r + h v a) - Q' r',  Q' = Q exp(v a)
    /// ```
    ///
    /// with the unit vectors `e` and `a`, the vectors `r` and `r'` from the centres to the pivot at
    /// the start, and the advance `h`. Values of passive joints are those of the state, projected
    /// so that loops close ([`Articulation::closed`]); their entries in `shape` have no effect.
    ///
    /// # Errors
    /// A length that is not positive, or values that do not close a loop to 1e-9 of the longest
    /// arm; a state that does not fit the set, is not finite or not rigid; positions that overflow.
    pub fn place(&self, state: &State, shape: &[f64]) -> Result<Vec<Isometry3<f64>>, RigidError> {
        let open = self.open_placement(state, shape)?;
        let closed = self.close(state, shape, &open)?;
        let (state, placement) = match &closed {
            Some((state, placement)) => (state, placement),
            None => (state, &open),
        };
        let pose = |(body, x): (usize, &Vector3<f64>)| {
            let attitude = match self.has_own_attitude(body) {
                true => state.attitudes[body],
                false => placement.rotations[self.frame_of()[body]],
            };
            Isometry3::from_parts(Translation3::from(*x), attitude)
        };
        Ok(placement.positions.iter().enumerate().map(pose).collect())
    }

    /// Positions of the bodies and rotations of the frames, with closed loops.
    pub(crate) fn placement(&self, state: &State, shape: &[f64]) -> Result<Placement, RigidError> {
        let open = self.open_placement(state, shape)?;
        Ok(match self.close(state, shape, &open)? {
            Some((_, closed)) => closed,
            None => open,
        })
    }

    /// Positions of the bodies and rotations of the frames along the spanning trees.
    pub(crate) fn open_placement(
        &self,
        state: &State,
        shape: &[f64],
    ) -> Result<Placement, RigidError> {
        self.check_state(state)?;
        check_length("lengths of the links", shape.len(), self.joints().len())?;
        let mut values = shape.to_vec();
        for ((joint, _), value) in self.passive_drives().zip(&state.joints) {
            values[joint] = *value;
        }
        let bad = |(joint, value): &(usize, &f64)| match self.joints()[*joint].kind {
            JointKind::Slide => !(value.is_finite() && **value > 0.0),
            _ => !value.is_finite(),
        };
        if let Some((joint, length)) = values.iter().enumerate().find(bad) {
            return Err(RigidError::BadLength {
                joint: self.joints()[joint].name.clone(),
                length: *length,
            });
        }
        let identity = UnitQuaternion::identity();
        let mut placement = Placement {
            positions: vec![Vector3::zeros(); self.kinds().len()],
            rotations: vec![identity; self.frames()],
            values,
        };
        let mut is_placed = vec![false; self.frames()];
        for (linkage, frame) in self.linkages().iter().zip(&state.frames) {
            placement.positions[linkage.root] = frame.translation.vector;
            placement.rotations[linkage.first_frame] = frame.rotation;
            is_placed[linkage.first_frame] = true;
            for edge in &linkage.tree {
                let joint = &self.joints()[edge.joint];
                let [parent, child] = [edge.parent, edge.child].map(|body| self.frame_of()[body]);
                if !is_placed[child] {
                    is_placed[child] = true;
                    let turned = joint.kind.rotation(placement.values[edge.joint]);
                    placement.rotations[child] = match (&joint.kind, joint.body == edge.child) {
                        (JointKind::Ball { .. }, _) => state.attitudes[edge.child],
                        (_, true) => placement.rotations[parent] * turned,
                        (_, false) => placement.rotations[parent] * turned.inverse(),
                    };
                }
                let arm = self.arm(&placement, edge.joint);
                let outward = if joint.body == edge.child { arm } else { -arm };
                placement.positions[edge.child] = placement.positions[edge.parent] + outward;
            }
        }
        check_finite("a body's position", placement.positions.iter().flatten())?;
        Ok(placement)
    }

    /// Vector of a joint from the centre of `to` to that of `body`, from the frames and values.
    pub(crate) fn arm(&self, placement: &Placement, joint: usize) -> Vector3<f64> {
        let vectors = &self.arm_vectors()[joint];
        let value = placement.values[joint];
        let Joint { body, to, kind, .. } = &self.joints()[joint];
        let [far, near] = [body, to].map(|body| placement.rotations[self.frame_of()[*body]]);
        match kind {
            JointKind::Slide => value * (near * vectors.direction),
            JointKind::Fixed => near * vectors.near,
            JointKind::Turn { advance, .. } => {
                near * (vectors.near + advance * value * vectors.direction) - far * vectors.far
            }
            JointKind::Ball { .. } => near * vectors.near - far * vectors.far,
        }
    }
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::{Arms, BodyKind};

    fn joint(body: usize, to: usize) -> Joint {
        Joint::slide(&format!("{body}-{to}"), body, to)
    }

    #[test]
    fn a_chain_is_placed_along_its_joints() {
        let x = [
            Vector3::new(-10.0, 0.0, 0.0),
            Vector3::zeros(),
            Vector3::new(10.0, 0.0, 0.0),
        ];
        let set = Articulation::new(
            &[BodyKind::Rigid; 3],
            vec![joint(0, 1), joint(2, 1)],
            Arms::Clamped,
            &x,
        )
        .unwrap();
        let state = set.initial_state();
        let poses = set.place(&state, &[6.0, 10.0]).unwrap();
        // The root is body 0: its frame stays and the other bodies come closer.
        assert_relative_eq!(poses[0].translation.vector, x[0]);
        assert_relative_eq!(poses[1].translation.vector, Vector3::new(-4.0, 0.0, 0.0));
        assert_relative_eq!(poses[2].translation.vector, Vector3::new(6.0, 0.0, 0.0));
    }

    #[test]
    fn a_triangle_must_close() {
        let x = [Vector3::zeros(), Vector3::x(), Vector3::y()];
        let joints = vec![joint(1, 0), joint(2, 0), joint(2, 1)];
        let set = Articulation::new(&[BodyKind::Rigid; 3], joints, Arms::Clamped, &x).unwrap();
        let shape = set.initial_shape().to_vec();
        assert!(set.place(&set.initial_state(), &shape).is_ok());
        let longer = [shape[0], shape[1], shape[2] + 0.1];
        assert!(matches!(
            set.place(&set.initial_state(), &longer),
            Err(RigidError::OpenLoop { .. })
        ));
    }
}
