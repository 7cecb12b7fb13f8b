//! Configurations of an articulated set: from frames and link lengths to the poses of all bodies.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::error::check_length;
use crate::{Articulation, RigidError};

/// Position and attitude of an articulated set: one frame per linkage, one attitude per body.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct State {
    /// Pose of the frame of each linkage; its origin is the centre of the root body.
    pub frames: Vec<Isometry3<f64>>,
    /// Attitude of each body relative to the laboratory axes; the identity at the start.
    pub attitudes: Vec<UnitQuaternion<f64>>,
}

impl Articulation {
    /// The state of the positions given to [`Articulation::new`], all attitudes the identity.
    pub fn initial_state(&self) -> State {
        State {
            frames: self
                .linkages()
                .iter()
                .map(|linkage| {
                    Isometry3::from_parts(
                        Translation3::from(self.initial_positions()[linkage.root]),
                        UnitQuaternion::identity(),
                    )
                })
                .collect(),
            attitudes: vec![UnitQuaternion::identity(); self.kinds().len()],
        }
    }

    /// Direction of a link in the laboratory axes, from `to` to `body`.
    ///
    /// # Errors
    /// A link that does not exist; a state that does not fit the set, is not finite or not rigid.
    pub fn direction(&self, state: &State, link: usize) -> Result<Vector3<f64>, RigidError> {
        self.check_state(state)?;
        let links = self.links().len();
        if link >= links {
            return Err(RigidError::NoSuchLink { link, links });
        }
        Ok(self.rotated_direction(state, link))
    }

    /// [`Articulation::direction`] of a link that exists, in a state that fits.
    pub(crate) fn rotated_direction(&self, state: &State, link: usize) -> Vector3<f64> {
        let frame = &state.frames[self.linkage_of()[self.links()[link].body]];
        frame.rotation * self.directions()[link]
    }

    /// Poses of all bodies, points included, for given lengths of the links.
    ///
    /// `x_body = x_to + l Q e` along the spanning tree of each linkage, `Q` the rotation of its
    /// frame.
    ///
    /// # Errors
    /// A length that is not positive, or lengths that do not close a loop; a state that does not
    /// fit the set, is not finite or not rigid; positions that overflow. The tolerance of a loop is
    /// 1e-9 of the longest link: rounding along any realistic loop is far below it, and a real
    /// misfit far above.
    pub fn place(&self, state: &State, lengths: &[f64]) -> Result<Vec<Isometry3<f64>>, RigidError> {
        self.check_state(state)?;
        check_length("lengths of the links", lengths.len(), self.links().len())?;
        if let Some(bad) = lengths.iter().position(|l| !(l.is_finite() && *l > 0.0)) {
            return Err(RigidError::BadLength {
                link: self.links()[bad].name.clone(),
                length: lengths[bad],
            });
        }
        let mut positions = vec![Vector3::zeros(); self.kinds().len()];
        for (linkage, frame) in self.linkages().iter().zip(&state.frames) {
            positions[linkage.root] = frame.translation.vector;
            for edge in &linkage.tree {
                let arm = lengths[edge.link] * (frame.rotation * self.directions()[edge.link]);
                let outward = if self.links()[edge.link].body == edge.child {
                    arm
                } else {
                    -arm
                };
                positions[edge.child] = positions[edge.parent] + outward;
            }
        }
        if !positions.iter().all(is_finite) {
            return Err(RigidError::NotFinite {
                what: "a body's position",
            });
        }
        let longest = lengths.iter().fold(0.0_f64, |a, &b| a.max(b));
        for (number, link) in self.links().iter().enumerate() {
            let arm = lengths[number] * self.rotated_direction(state, number);
            let gap = (positions[link.body] - positions[link.to] - arm).norm();
            if gap.is_nan() || gap > 1e-9 * longest {
                return Err(RigidError::OpenLoop {
                    link: link.name.clone(),
                    gap,
                });
            }
        }
        Ok(positions
            .into_iter()
            .zip(&state.attitudes)
            .map(|(x, q)| Isometry3::from_parts(Translation3::from(x), *q))
            .collect())
    }

    /// Refuses a state with another number of frames or attitudes than this set has, positions that
    /// are not finite and orientations that are not rotations.
    pub(crate) fn check_state(&self, state: &State) -> Result<(), RigidError> {
        check_length(
            "frames of the linkages",
            state.frames.len(),
            self.linkages().len(),
        )?;
        check_length(
            "attitudes of the bodies",
            state.attitudes.len(),
            self.kinds().len(),
        )?;
        let positions = || state.frames.iter().map(|frame| &frame.translation.vector);
        if !positions().all(is_finite) {
            return Err(RigidError::NotFinite {
                what: "the position of a frame",
            });
        }
        let rotations = state.frames.iter().map(|frame| &frame.rotation);
        let mut lengths = rotations.chain(&state.attitudes).map(|q| q.norm());
        match lengths.find(|length| length.is_nan() || (length - 1.0).abs() > ROTATION) {
            Some(length) => Err(RigidError::NotRotation { length }),
            None => Ok(()),
        }
    }
}

/// Largest difference from 1 of the length of a quaternion that counts as a rotation.
///
/// [`Articulation::advance`] keeps it at the level of rounding; a text file with seven digits
/// reaches 1e-7.
const ROTATION: f64 = 1e-6;

/// Whether all components are finite.
pub(crate) fn is_finite(vector: &Vector3<f64>) -> bool {
    vector.iter().all(|component| component.is_finite())
}

#[cfg(test)]
mod tests {
    use approx::assert_relative_eq;

    use super::*;
    use crate::{Arms, BodyKind, Link};

    fn link(body: usize, to: usize) -> Link {
        Link {
            name: format!("{body}-{to}"),
            body,
            to,
        }
    }

    #[test]
    fn a_chain_is_placed_along_its_links() {
        let x = [
            Vector3::new(-10.0, 0.0, 0.0),
            Vector3::zeros(),
            Vector3::new(10.0, 0.0, 0.0),
        ];
        let set = Articulation::new(
            &[BodyKind::Rigid; 3],
            vec![link(0, 1), link(2, 1)],
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
        let links = vec![link(1, 0), link(2, 0), link(2, 1)];
        let set = Articulation::new(&[BodyKind::Rigid; 3], links, Arms::Clamped, &x).unwrap();
        let lengths = set.initial_lengths().to_vec();
        assert!(set.place(&set.initial_state(), &lengths).is_ok());
        let longer = [lengths[0], lengths[1], lengths[2] + 0.1];
        assert!(matches!(
            set.place(&set.initial_state(), &longer),
            Err(RigidError::OpenLoop { .. })
        ));
    }
}
