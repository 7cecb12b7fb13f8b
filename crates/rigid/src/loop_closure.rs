//! Closure of loops by the joints whose values are not prescribed.
//!
//! In a loop the values of the joints depend on each other: `g(z) = 0`, with the misfits `g` of the
//! joints outside the spanning trees. Velocities keep `g` at zero, but errors of the integration
//! let it drift. Every placement therefore projects the state onto the manifold `g = 0` (Hairer,
//! Lubich & Wanner 2006, Geometric Numerical Integration, section IV.4): with the derivative `G =
//! dg/dz` and its pseudo-inverse,
//!
//! ```text
//! z <- z - G^+ g(z)
//! ```
//!
//! until rounding. This is the smallest change of the passive values that closes the loops, if
//! values are measured by the displacements that they cause.

use nalgebra::{DMatrix, DVector, Vector3};

use crate::placement::Placement;
use crate::{Articulation, RigidError, State, StateVelocity, Twist};

/// Largest misfit of a closed loop relative to its longest arm: rounding along any realistic loop
/// is far below it, and a real misfit far above.
const MAX_MISFIT: f64 = 1e-9;

/// Misfit relative to the longest arm at which the projection ends: the sum of a few lengths has
/// this rounding error.
const ROUNDING_MISFIT: f64 = 1e-15;

/// Step of the differences for `G`, as a displacement relative to the longest arm. The error of a
/// central difference is its square, and rounding over it: both below 1e-10.
const DIFFERENCE_STEP: f64 = 1e-5;

/// Relative singular value of `G` below which a motion does not change the misfits: redundant
/// constraints, as those of planar loops in space, have singular values of the error of `G`.
const MIN_SINGULAR_VALUE: f64 = 1e-7;

/// Largest number of projections; they converge quadratically.
const MAX_PROJECTIONS: usize = 30;

/// Largest number of times that a projection which does not reduce the misfit is halved.
const MAX_HALVINGS: usize = 12;

/// A part of the state that can close a loop.
#[derive(Clone, Copy)]
enum Coordinate {
    /// The value of a passive joint, by its place in the state.
    Joint(usize),
    /// Rotation of the body of a ball about a laboratory axis.
    Attitude(usize, usize),
}

impl Articulation {
    /// The state with the values of passive joints that close all loops, next to those of `state`;
    /// the same state for sets without loops or without passive joints in them.
    ///
    /// # Errors
    /// [`RigidError::OpenLoop`] for a loop that they cannot close; those of
    /// [`Articulation::place`].
    pub fn closed(&self, state: &State, shape: &[f64]) -> Result<State, RigidError> {
        let open = self.open_placement(state, shape)?;
        Ok(match self.close(state, shape, &open)? {
            Some((closed, _)) => closed,
            None => state.clone(),
        })
    }

    /// The closed state and its placement, from the placement of a state; none if the loops are
    /// closed already.
    pub(crate) fn close(
        &self,
        state: &State,
        shape: &[f64],
        open: &Placement,
    ) -> Result<Option<(State, Placement)>, RigidError> {
        let longest = self.longest_arm(open);
        let mut gaps = self.misfits(open, longest);
        let coordinates = match gaps.amax() > ROUNDING_MISFIT * longest {
            true => self.loop_coordinates(longest),
            false => Vec::new(),
        };
        let mut closed = None;
        for _ in 0..MAX_PROJECTIONS {
            if coordinates.is_empty() || gaps.norm() <= ROUNDING_MISFIT * longest {
                break;
            }
            let from = closed.as_ref().map_or(state, |(state, _)| state);
            let derivative = self.misfit_derivative(from, shape, &coordinates, longest)?;
            let change = -minimal_solution(derivative, &gaps);
            let halved = (0..MAX_HALVINGS).map(|k| 0.5_f64.powi(k as i32));
            let better = halved.into_iter().find_map(|part| {
                let next = self.changed(from, &coordinates, &(part * &change)).ok()?;
                let placement = self.open_placement(&next, shape).ok()?;
                let misfits = self.misfits(&placement, longest);
                (misfits.norm() < gaps.norm()).then_some((next, placement, misfits))
            });
            // No further reduction: rounding, or a loop that does not close.
            let Some((next, placement, misfits)) = better else {
                break;
            };
            gaps = misfits;
            closed = Some((next, placement));
        }
        self.check_loops(closed.as_ref().map_or(open, |(_, placement)| placement))?;
        Ok(closed)
    }

    /// Refuses positions or rotations that do not fit a joint outside the spanning trees.
    fn check_loops(&self, placement: &Placement) -> Result<(), RigidError> {
        let longest = self.longest_arm(placement);
        let joints = self.joints().iter().enumerate();
        for (number, joint) in joints.filter(|(_, joint)| !joint.kind.is_deformation()) {
            let [translation, rotation] = self.misfit(placement, number);
            // An angle counts like a distance at the longest arm.
            let gap = translation.norm().max(rotation.norm() * longest);
            if gap.is_nan() || gap > MAX_MISFIT * longest {
                return Err(RigidError::OpenLoop {
                    joint: joint.name.clone(),
                    gap,
                });
            }
        }
        Ok(())
    }

    fn longest_arm(&self, placement: &Placement) -> f64 {
        (0..self.joints().len()).fold(0.0, |longest, joint| {
            self.arm(placement, joint).norm().max(longest)
        })
    }

    /// Translation and rotation by which `body` of a joint is away from its place relative to `to`.
    fn misfit(&self, placement: &Placement, number: usize) -> [Vector3<f64>; 2] {
        let joint = &self.joints()[number];
        let [far, near] = [joint.body, joint.to].map(|body| placement.positions[body]);
        let translation = far - near - self.arm(placement, number);
        let rotation = match joint.kind.constrains_rotation() {
            true => {
                let [far, near] =
                    [joint.body, joint.to].map(|body| placement.rotations[self.frame_of()[body]]);
                let turned = near * joint.kind.rotation(placement.values[number]);
                (far * turned.inverse()).scaled_axis()
            }
            false => Vector3::zeros(),
        };
        [translation, rotation]
    }

    /// Misfits of all joints outside the spanning trees, as lengths.
    fn misfits(&self, placement: &Placement, longest: f64) -> DVector<f64> {
        let mut is_inside = vec![false; self.joints().len()];
        for edge in self.linkages().iter().flat_map(|linkage| &linkage.tree) {
            is_inside[edge.joint] = true;
        }
        let outside = (self.joints().iter().enumerate())
            .filter(|(joint, of)| !of.kind.is_deformation() && !is_inside[*joint])
            .map(|(joint, _)| joint);
        let misfits = outside.flat_map(|joint| {
            let [translation, rotation] = self.misfit(placement, joint);
            [translation, longest * rotation]
        });
        let entries: Vec<f64> = misfits.flat_map(|v| [v.x, v.y, v.z]).collect();
        DVector::from_vec(entries)
    }

    /// The coordinates of linkages with loops, each with the displacement per unit.
    fn loop_coordinates(&self, longest: f64) -> Vec<(Coordinate, f64)> {
        let mut coordinates = Vec::new();
        let has_loop = |body: usize| {
            let number = self.linkage_of()[body];
            let joints = self.joints().iter();
            let joints = joints.filter(|joint| {
                !joint.kind.is_deformation() && self.linkage_of()[joint.body] == number
            });
            joints.count() > self.linkages()[number].tree.len()
        };
        for (place, (joint, _)) in self.passive_drives().enumerate() {
            if has_loop(self.joints()[joint].body) {
                let scale = self.arm_displacement(joint, 1.0);
                let scale = if scale > 0.0 { scale } else { longest };
                coordinates.push((Coordinate::Joint(place), scale));
            }
        }
        for edge in self.linkages().iter().flat_map(|linkage| &linkage.tree) {
            if self.joints()[edge.joint].kind.has_attitude() && has_loop(edge.child) {
                coordinates.extend(
                    [0, 1, 2].map(|axis| (Coordinate::Attitude(edge.child, axis), longest)),
                );
            }
        }
        coordinates
    }

    /// The state after changes of the coordinates, measured as displacements.
    fn changed(
        &self,
        state: &State,
        coordinates: &[(Coordinate, f64)],
        changes: &DVector<f64>,
    ) -> Result<State, RigidError> {
        let mut step = StateVelocity {
            frames: vec![Twist::default(); state.frames.len()],
            spins: vec![Vector3::zeros(); state.attitudes.len()],
            joints: vec![0.0; state.joints.len()],
        };
        for ((coordinate, scale), change) in coordinates.iter().zip(changes.iter()) {
            match *coordinate {
                Coordinate::Joint(joint) => step.joints[joint] = change / scale,
                Coordinate::Attitude(body, axis) => step.spins[body][axis] = change / scale,
            }
        }
        self.advance(state, &step)
    }

    /// Derivative of the misfits with respect to the coordinates, by central differences.
    fn misfit_derivative(
        &self,
        state: &State,
        shape: &[f64],
        coordinates: &[(Coordinate, f64)],
        longest: f64,
    ) -> Result<DMatrix<f64>, RigidError> {
        let step = DIFFERENCE_STEP * longest;
        let mut columns = Vec::with_capacity(coordinates.len());
        for column in 0..coordinates.len() {
            let at = |change: f64| -> Result<DVector<f64>, RigidError> {
                let mut changes = DVector::zeros(coordinates.len());
                changes[column] = change;
                let state = self.changed(state, coordinates, &changes)?;
                Ok(self.misfits(&self.open_placement(&state, shape)?, longest))
            };
            columns.push((at(step)? - at(-step)?) / (2.0 * step));
        }
        Ok(DMatrix::from_columns(&columns))
    }
}

/// The smallest least-squares solution of `matrix x = rhs`; zero without one.
fn minimal_solution(matrix: DMatrix<f64>, rhs: &DVector<f64>) -> DVector<f64> {
    let columns = matrix.ncols();
    let threshold = MIN_SINGULAR_VALUE * matrix.amax();
    let solution = matrix.svd(true, true).solve(rhs, threshold);
    solution.unwrap_or_else(|_| DVector::zeros(columns))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;
    use crate::{Arms, BodyKind, Joint, JointDrive, JointKind, PassiveDrive};

    /// A rhombus of four bars of the length 2 with hinges at its corners; the bodies are the
    /// middles of the bars.
    fn rhombus(passive: usize) -> Articulation {
        let corners = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let corner = |k: usize| Vector3::new(corners[k % 4][0], corners[k % 4][1], 0.0);
        let middles: Vec<_> = (0..4).map(|k| 0.5 * (corner(k) + corner(k + 1))).collect();
        let hinge = |k: usize| {
            let joint = JointKind::Turn {
                axis: Vector3::z(),
                pivot: corner(k + 1),
                advance: 0.0,
            };
            let drive = match k >= 4 - passive {
                true => JointDrive::Passive(PassiveDrive::default()),
                false => JointDrive::Prescribed,
            };
            Joint::slide(&format!("hinge {k}"), (k + 1) % 4, k)
                .with_kind(joint)
                .with_drive(drive)
        };
        let joints = (0..4).map(hinge).collect();
        Articulation::new(&[BodyKind::Rigid; 4], joints, Arms::Clamped, &middles).unwrap()
    }

    #[test]
    fn passive_hinges_close_a_rhombus_at_any_angle() {
        let set = rhombus(3);
        let start = set.initial_state();
        for angle in [1e-12, 1e-3, 0.4, -1.1] {
            let shape = [angle, 0.0, 0.0, 0.0];
            let closed = set.closed(&start, &shape).unwrap();
            for (value, exact) in closed.joints.iter().zip([-angle, angle, -angle]) {
                assert!((value - exact).abs() < 1e-14, "{value} {exact}");
            }
            // A state that is closed stays as it is.
            let again = set.closed(&closed, &shape).unwrap();
            assert!((again.joints[0] - closed.joints[0]).abs() < 1e-15);
            // All users of the open state see the closed one.
            let [one, other] = [&start, &closed].map(|state| set.place(state, &shape).unwrap());
            assert!((one[2].translation.vector - other[2].translation.vector).norm() < 1e-14);
        }
    }

    #[test]
    fn one_passive_hinge_cannot_close_a_loop_of_contradictory_angles() {
        let set = rhombus(1);
        let start = set.initial_state();
        // Consistent angles leave the value of the last joint to the loop.
        let closed = set.closed(&start, &[0.3, -0.3, 0.3, 0.0]).unwrap();
        assert!((closed.joints[0] + 0.3).abs() < 1e-14);
        for contradictory in [[0.3, 0.0, 0.0, 0.0], [0.3, -0.3, 0.3 + 1e-6, 0.0]] {
            match set.closed(&start, &contradictory) {
                Err(RigidError::OpenLoop { gap, .. }) => assert!(gap > 1e-7),
                other => panic!("{other:?}"),
            }
        }
        // Bars of this length do not reach.
        let set = rhombus(3);
        let mut far = set.initial_state();
        far.joints = vec![f64::NAN; 3];
        assert!(set.closed(&far, &[0.0; 4]).is_err());
    }

    #[test]
    fn a_ball_closes_a_loop_by_its_attitude() {
        // A hinge, a ball and a slide of prescribed lengths in a triangle.
        let x = [
            Vector3::zeros(),
            Vector3::new(2.0, 0.0, 0.0),
            Vector3::new(1.0, 1.5, 0.0),
        ];
        let ball = |body: usize, to: usize, pivot: Vector3<f64>| {
            Joint::slide(&format!("{body}-{to}"), body, to).with_kind(JointKind::Ball { pivot })
        };
        let hinge = JointKind::Turn {
            axis: Vector3::z(),
            pivot: x[0],
            advance: 0.0,
        };
        let joints = vec![
            Joint::slide("hinge", 1, 0).with_kind(hinge),
            ball(2, 1, x[1]),
            ball(0, 2, 0.5 * (x[0] + x[2])),
        ];
        let set = Articulation::new(&[BodyKind::Rigid; 3], joints, Arms::Clamped, &x).unwrap();
        let mut state = set.initial_state();
        // A rotation of the ball out of the loop, which a rotation back and no hinge closes.
        let tilt = Vector3::new(0.0, 0.0, 1e-3);
        state.attitudes[2] = nalgebra::UnitQuaternion::from_scaled_axis(tilt);
        let poses = set.place(&state, &[0.0; 3]).unwrap();
        let pivot = |body: usize| {
            let start = 0.5 * (x[0] + x[2]) - x[body];
            poses[body].translation.vector + poses[body].rotation * start
        };
        assert!((pivot(0) - pivot(2)).norm() < 1e-14);
        assert!((poses[2].rotation.angle()) < FRAC_PI_2);
    }
}
