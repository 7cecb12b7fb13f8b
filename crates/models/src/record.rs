//! The numbers of a solution that depend linearly on what drives it, in a fixed order.

use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};

use crate::discretisation_error::{DiscretisationError, Uncertainty};
use crate::solution::{BodySolution, InstantaneousSolution};

/// Numbers of bodies and joints of a scene, which determine the length of a record.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    pub bodies: usize,
    pub joints: usize,
    /// Whether records contain discretisation errors.
    pub mesh_errors: bool,
}

/// The linear quantities of one solution: motion, and velocities and forces of bodies and joints.
pub struct Record {
    pub motion: StateVelocity,
    pub bodies: Vec<BodySolution>,
    pub joint_forces: Vec<Vector3<f64>>,
    /// Discretisation errors that were subtracted; their uncertainty and the power of slip are not
    /// part of it.
    pub mesh_error: Option<DiscretisationError>,
}

impl Layout {
    /// Length of the numbers of one record.
    pub fn numbers(self) -> usize {
        let records = if self.mesh_errors { 2 } else { 1 };
        records * 3 * (2 + 5 * self.bodies + self.joints)
    }
}

impl Record {
    /// Reads a record from its numbers, the inverse of [`numbers`].
    pub fn new(numbers: &[f64], layout: Layout) -> Self {
        let mut vectors = numbers
            .chunks_exact(3)
            .map(|v| Vector3::new(v[0], v[1], v[2]));
        let mut quantities = || {
            let mut next = || vectors.next().unwrap_or_default();
            let frames = vec![Twist {
                linear: next(),
                angular: next(),
            }];
            let spins = (0..layout.bodies).map(|_| next()).collect();
            let bodies = (0..layout.bodies)
                .map(|_| BodySolution {
                    velocity: next(),
                    angular_velocity: next(),
                    force: next(),
                    torque: next(),
                })
                .collect();
            let joint_forces = (0..layout.joints).map(|_| next()).collect();
            // Records are of scenes whose joints are all prescribed.
            let motion = StateVelocity {
                frames,
                spins,
                joints: Vec::new(),
            };
            (motion, bodies, joint_forces)
        };
        let (motion, bodies, joint_forces) = quantities();
        let mesh_error = layout.mesh_errors.then(|| {
            let (motion, bodies, joint_forces) = quantities();
            DiscretisationError {
                motion,
                bodies,
                joint_forces,
                slip_power: 0.0,
                uncertainty: Uncertainty::default(),
            }
        });
        Self {
            motion,
            bodies,
            joint_forces,
            mesh_error,
        }
    }
}

/// Numbers of a solution in the order of [`Record::new`], three per vector.
pub fn numbers(solution: &InstantaneousSolution) -> Vec<f64> {
    let mut numbers = quantities(&solution.motion, &solution.bodies, &solution.joint_forces);
    if let Some(error) = &solution.mesh_error {
        numbers.extend(quantities(
            &error.motion,
            &error.bodies,
            &error.joint_forces,
        ));
    }
    numbers
}

fn quantities(
    motion: &StateVelocity,
    bodies: &[BodySolution],
    joint_forces: &[Vector3<f64>],
) -> Vec<f64> {
    let frame = motion.frames.first().copied().unwrap_or_default();
    let mut vectors = vec![&frame.linear, &frame.angular];
    vectors.extend(&motion.spins);
    vectors.extend(bodies.iter().flat_map(BodySolution::vectors));
    vectors.extend(joint_forces);
    vectors.into_iter().flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_records_are_inverse() {
        let layout = Layout {
            bodies: 2,
            joints: 1,
            mesh_errors: true,
        };
        let written: Vec<f64> = (0..78).map(f64::from).collect();
        let Record {
            motion,
            bodies,
            joint_forces,
            mesh_error,
        } = Record::new(&written, layout);
        let solution = InstantaneousSolution {
            mesh_error,
            ..InstantaneousSolution::new(bodies, joint_forces, motion)
        };
        assert_eq!(numbers(&solution), written);
    }
}
