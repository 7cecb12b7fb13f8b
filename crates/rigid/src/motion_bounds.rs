//! Bounds on the motion of the bodies of an articulated set along a path.
//!
//! A path has a parameter from 0 to 1, and all derivatives are with respect to it. The bounds
//! follow from those of frames, attitudes and values of joints along the spanning trees: a point at
//! the constant distance `r` from the origin of axes that turn with the angular velocity `ω` has
//! the speed `r |ω|` and at most the acceleration `r (|ω'| + |ω|²)`.

use nalgebra::Vector3;

use crate::error::check_length;
use crate::joint::{ArmVectors, JointKind};
use crate::{Articulation, RigidError};

/// Bounds on the norms of the first two derivatives of a vector along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DerivativeBounds {
    /// Largest norm of the first derivative; for rotations, of the angular velocity.
    pub first: f64,
    /// Largest norm of the second derivative; for rotations, of the angular acceleration.
    pub second: f64,
}

/// Bounds on the value of a joint along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ValueBounds {
    /// Largest absolute value.
    pub size: f64,
    /// Bounds on its derivatives.
    pub derivatives: DerivativeBounds,
}

/// Bounds on the motion of a body or a frame along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotionBounds {
    /// Of the position of the centre or origin.
    pub linear: DerivativeBounds,
    /// Of the rotation.
    pub angular: DerivativeBounds,
}

impl DerivativeBounds {
    /// The bounds with respect to a parameter that runs from 0 to 1 over a part of the path.
    fn over_part(self, width: f64) -> Self {
        Self {
            first: width * self.first,
            second: width * width * self.second,
        }
    }
}

impl MotionBounds {
    /// Largest speed of a point of the body at most `distance` from the centre.
    pub fn speed(&self, distance: f64) -> f64 {
        self.linear.first + distance * self.angular.first
    }

    /// Largest acceleration of a point of the body at most `distance` from the centre.
    pub fn acceleration(&self, distance: f64) -> f64 {
        let DerivativeBounds { first, second } = self.angular;
        self.linear.second + distance * (second + first * first)
    }
}

/// Bounds on the motion of a [`State`](crate::State) and on the values of all joints along a path.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StateBounds {
    /// Of the frame of each linkage.
    pub frames: Vec<MotionBounds>,
    /// Of the attitude of each body; without effect for bodies whose attitude follows from a frame.
    pub attitudes: Vec<DerivativeBounds>,
    /// Of the values of all joints, prescribed or not.
    pub joints: Vec<ValueBounds>,
}

impl StateBounds {
    /// The bounds of a state at rest: no motion of frames and attitudes, these bounds of joints.
    pub fn at_rest(set: &Articulation, joints: Vec<ValueBounds>) -> Self {
        Self {
            frames: vec![MotionBounds::default(); set.linkages().len()],
            attitudes: vec![DerivativeBounds::default(); set.kinds().len()],
            joints,
        }
    }

    /// The bounds along a part of the path whose parameter runs from 0 to 1 again; `width` is the
    /// width of the part.
    #[must_use]
    pub fn over_part(&self, width: f64) -> Self {
        let frames = self.frames.iter().map(|frame| MotionBounds {
            linear: frame.linear.over_part(width),
            angular: frame.angular.over_part(width),
        });
        let joints = self.joints.iter().map(|joint| ValueBounds {
            derivatives: joint.derivatives.over_part(width),
            ..*joint
        });
        let attitudes = self.attitudes.iter();
        Self {
            frames: frames.collect(),
            attitudes: attitudes.map(|bounds| bounds.over_part(width)).collect(),
            joints: joints.collect(),
        }
    }

    /// The bounds of the motion that an observer in the frame of each linkage sees.
    ///
    /// Attitudes turn with `ω - ω_f`, whose derivative in the axes of the frame has at most the
    /// norm `|ω'| + |ω_f'| + |ω_f| |ω|`.
    #[must_use]
    pub fn relative_to_frames(&self, set: &Articulation) -> Self {
        let relative = |(body, own): (usize, &DerivativeBounds)| {
            let linkage = set.linkage_of().get(body);
            let frame = linkage.and_then(|&linkage| self.frames.get(linkage));
            let frame = frame.copied().unwrap_or_default().angular;
            DerivativeBounds {
                first: own.first + frame.first,
                second: own.second + frame.second + own.first * frame.first,
            }
        };
        Self {
            attitudes: self.attitudes.iter().enumerate().map(relative).collect(),
            ..Self::at_rest(set, self.joints.clone())
        }
    }
}

impl Articulation {
    /// Bounds on the motion of all bodies along a path on which the state has these bounds.
    ///
    /// They hold for the placement along the spanning trees; the projection that closes loops
    /// ([`Articulation::closed`]) moves bodies by the error of the integration in addition.
    /// Cost: one pass over the bodies.
    ///
    /// # Errors
    /// Lists whose lengths do not fit the set.
    pub fn motion_bounds(&self, bounds: &StateBounds) -> Result<Vec<MotionBounds>, RigidError> {
        let linkages = self.linkages().len();
        check_length("bounds of the frames", bounds.frames.len(), linkages)?;
        let bodies = self.kinds().len();
        check_length("bounds of the attitudes", bounds.attitudes.len(), bodies)?;
        let joints = self.joints().len();
        check_length("bounds of the joints", bounds.joints.len(), joints)?;
        let mut centres = vec![DerivativeBounds::default(); bodies];
        let mut frames = vec![DerivativeBounds::default(); self.frames()];
        let mut is_bounded = vec![false; self.frames()];
        for (linkage, frame) in self.linkages().iter().zip(&bounds.frames) {
            centres[linkage.root] = frame.linear;
            frames[linkage.first_frame] = frame.angular;
            is_bounded[linkage.first_frame] = true;
            for edge in &linkage.tree {
                let joint = &self.joints()[edge.joint];
                let value = &bounds.joints[edge.joint];
                let [parent, child] = [edge.parent, edge.child].map(|body| self.frame_of()[body]);
                if !is_bounded[child] {
                    is_bounded[child] = true;
                    frames[child] = match joint.kind.has_attitude() {
                        true => bounds.attitudes[edge.child],
                        false => turned(frames[parent], value.derivatives),
                    };
                }
                let [far, near] = [joint.body, joint.to].map(|body| frames[self.frame_of()[body]]);
                let arm = arm_bounds(
                    &joint.kind,
                    value,
                    &self.arm_vectors()[edge.joint],
                    near,
                    far,
                );
                centres[edge.child] = sum(centres[edge.parent], arm);
            }
        }
        let of_body = |(body, linear): (usize, &DerivativeBounds)| MotionBounds {
            linear: *linear,
            angular: match self.has_own_attitude(body) {
                true => bounds.attitudes[body],
                false => frames[self.frame_of()[body]],
            },
        };
        Ok(centres.iter().enumerate().map(of_body).collect())
    }
}

fn sum(a: DerivativeBounds, b: DerivativeBounds) -> DerivativeBounds {
    DerivativeBounds {
        first: a.first + b.first,
        second: a.second + b.second,
    }
}

/// Of the frame beyond a joint that turns: `ω + v' a`, where the axis `a` turns with `ω`.
fn turned(frame: DerivativeBounds, angle: DerivativeBounds) -> DerivativeBounds {
    DerivativeBounds {
        first: frame.first + angle.first,
        second: frame.second + angle.second + frame.first * angle.first,
    }
}

/// Of a vector with a length of these bounds in axes that turn.
fn carried(length: &ValueBounds, axes: DerivativeBounds) -> DerivativeBounds {
    let DerivativeBounds { first, second } = length.derivatives;
    DerivativeBounds {
        first: first + length.size * axes.first,
        second: second
            + 2.0 * first * axes.first
            + length.size * (axes.second + axes.first * axes.first),
    }
}

/// Of the vector between the centres of the two bodies of a joint.
fn arm_bounds(
    kind: &JointKind,
    value: &ValueBounds,
    vectors: &ArmVectors,
    near: DerivativeBounds,
    far: DerivativeBounds,
) -> DerivativeBounds {
    let constant = |arm: &Vector3<f64>, axes| {
        let length = ValueBounds {
            size: arm.norm(),
            ..ValueBounds::default()
        };
        carried(&length, axes)
    };
    match kind {
        JointKind::Slide => carried(value, near),
        JointKind::Fixed => constant(&vectors.near, near),
        // It has no arm, and is no edge of a spanning tree.
        JointKind::Deformation { .. } => DerivativeBounds::default(),
        JointKind::Ball { .. } => sum(constant(&vectors.near, near), constant(&vectors.far, far)),
        JointKind::Turn { advance, .. } => {
            let factor = advance.abs();
            let along_axis = ValueBounds {
                size: factor * value.size,
                derivatives: DerivativeBounds {
                    first: factor * value.derivatives.first,
                    second: factor * value.derivatives.second,
                },
            };
            let pivots = sum(constant(&vectors.near, near), constant(&vectors.far, far));
            sum(pivots, carried(&along_axis, near))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Arms, BodyKind, Joint, StateVelocity, Twist};

    /// Central differences of the positions of a chain with a hinge, a screw and a slide, all of
    /// which move at constant rates on a frame that turns at a constant rate.
    #[test]
    fn bodies_of_a_chain_stay_within_their_bounds_which_are_near_the_motion() {
        let turn = |axis, pivot, advance| JointKind::Turn {
            axis,
            pivot,
            advance,
        };
        let x = [0.0, 2.0, 4.0, 7.0].map(|x| Vector3::new(x, 0.0, 0.0));
        let pivots = [1.0, 3.0].map(|x| Vector3::new(x, 0.5, 0.0));
        let joints = vec![
            Joint::slide("hinge", 1, 0).with_kind(turn(Vector3::z(), pivots[0], 0.0)),
            Joint::slide("screw", 1, 2).with_kind(turn(Vector3::y(), pivots[1], 0.3)),
            Joint::slide("slide", 3, 2),
        ];
        let set =
            Articulation::new(&[BodyKind::Rigid; 4], joints, Arms::Clamped, &x).expect("a chain");
        let rates = [0.7, -1.1, 0.5];
        let spin = Vector3::new(0.2, 0.4, -0.3);
        let at = |t: f64| {
            let shape: Vec<f64> = (set.initial_shape().iter().zip(rates))
                .map(|(value, rate)| value + t * rate)
                .collect();
            let mut step = StateVelocity {
                frames: vec![Twist::default()],
                spins: vec![Vector3::zeros(); 4],
                joints: Vec::new(),
            };
            step.frames[0] = Twist {
                linear: t * Vector3::x(),
                angular: t * spin,
            };
            let state = set.advance(&set.initial_state(), &step).expect("a state");
            set.place(&state, &shape).expect("poses")
        };
        let joints = (set.initial_shape().iter().zip(rates)).map(|(value, rate)| ValueBounds {
            size: value.abs() + f64::abs(rate),
            derivatives: DerivativeBounds {
                first: f64::abs(rate),
                second: 0.0,
            },
        });
        let mut bounds = StateBounds::at_rest(&set, joints.collect());
        bounds.frames[0].linear.first = 1.0;
        bounds.frames[0].angular.first = spin.norm();
        let bounds = set.motion_bounds(&bounds).expect("bounds");
        // Rounding of second differences: eps times the positions over d^2 = 1e-8.
        let d = 1e-3;
        let mut largest = [0.0_f64; 4];
        for k in 1..100 {
            let t = 0.01 * f64::from(k);
            let [before, now, after] = [t - d, t, t + d].map(at);
            for body in 0..4 {
                for arm in [Vector3::zeros(), Vector3::new(0.0, 0.6, 0.8)] {
                    let [a, b, c] = [&before, &now, &after]
                        .map(|poses| poses[body].translation.vector + poses[body].rotation * arm);
                    let (speed, acceleration) =
                        ((c - a).norm() / (2.0 * d), (c - b - b + a).norm() / (d * d));
                    assert!(speed <= bounds[body].speed(arm.norm()) + 1e-5);
                    assert!(acceleration <= bounds[body].acceleration(arm.norm()) + 1e-5);
                    largest[body] = largest[body].max(acceleration);
                }
            }
        }
        // Adding the norms of up to seven terms per joint loses less than a factor of 16.
        for (bounds, largest) in bounds.iter().zip(largest) {
            let bound = bounds.acceleration(1.0);
            assert!(bound < 16.0 * largest, "{bound} {largest}");
        }
    }
}
