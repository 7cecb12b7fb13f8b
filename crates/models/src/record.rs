//! The response of a solution as numbers in a fixed order, which tables interpolate.

use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};

use crate::response::{BodySolution, Response};
use crate::solution::InstantaneousSolution;

/// Numbers of bodies and joints of a scene, which determine the length of a record.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    pub bodies: usize,
    pub joints: usize,
    /// Whether records contain discretisation errors.
    pub mesh_errors: bool,
}

/// The response of one solution.
pub struct Record {
    pub response: Response,
    /// Discretisation errors that were subtracted. The powers of slip are not part of a record.
    pub mesh_error: Option<Response>,
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
        let mut next = || vectors.next().unwrap_or_default();
        let mut response = || Response {
            motion: StateVelocity {
                frames: vec![Twist {
                    linear: next(),
                    angular: next(),
                }],
                spins: (0..layout.bodies).map(|_| next()).collect(),
                // Records are of scenes whose joints are all prescribed.
                joints: Vec::new(),
            },
            bodies: (0..layout.bodies)
                .map(|_| BodySolution {
                    velocity: next(),
                    angular_velocity: next(),
                    force: next(),
                    torque: next(),
                })
                .collect(),
            joint_forces: (0..layout.joints).map(|_| next()).collect(),
            slip_power: 0.0,
        };
        Self {
            response: response(),
            mesh_error: layout.mesh_errors.then(response),
        }
    }
}

/// Numbers of a solution in the order of [`Record::new`], three per vector.
pub fn numbers(solution: &InstantaneousSolution) -> Vec<f64> {
    let error = solution.mesh_error.as_ref().map(|error| &error.response);
    let vectors = [Some(&solution.response), error].into_iter().flatten();
    let vectors = vectors.flat_map(Response::vectors);
    vectors.flatten().copied().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::discretisation_error::DiscretisationError;

    #[test]
    fn numbers_and_records_are_inverse() {
        let layout = Layout {
            bodies: 2,
            joints: 1,
            mesh_errors: true,
        };
        let written: Vec<f64> = (0..78).map(f64::from).collect();
        let record = Record::new(&written, layout);
        let error = |response| DiscretisationError {
            response,
            uncertainty: Default::default(),
        };
        let solution = InstantaneousSolution {
            mesh_error: record.mesh_error.map(error),
            ..record.response.into()
        };
        assert_eq!(numbers(&solution), written);
    }
}
