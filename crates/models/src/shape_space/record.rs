//! The numbers of a solution that are tabulated, in a fixed order.

use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};

use crate::mesh_error::MeshError;
use crate::solution::{BodySolution, InstantaneousSolution};

/// Numbers of bodies and links of a scene, which determine the length of a record.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    pub bodies: usize,
    pub links: usize,
    /// Whether records contain discretisation errors.
    pub mesh_errors: bool,
}

/// The tabulated quantities of one solution: motion, and velocities and forces of bodies and links.
pub struct Record {
    pub motion: StateVelocity,
    pub bodies: Vec<BodySolution>,
    pub link_forces: Vec<Vector3<f64>>,
    /// Discretisation errors; their uncertainty and that of the power are not tabulated.
    pub mesh_error: Option<MeshError>,
}

impl Layout {
    /// Length of the numbers of one record.
    pub fn numbers(self) -> usize {
        let errors = match self.mesh_errors {
            true => 2 + 2 * self.bodies,
            false => 0,
        };
        3 * (2 + 5 * self.bodies + self.links + errors)
    }
}

impl Record {
    /// Reads a record from its numbers, the inverse of [`numbers`].
    pub fn new(numbers: &[f64], layout: Layout) -> Self {
        let mut vectors = numbers
            .chunks_exact(3)
            .map(|v| Vector3::new(v[0], v[1], v[2]));
        let mut next = || vectors.next().unwrap_or_default();
        let frame = Twist {
            linear: next(),
            angular: next(),
        };
        let spins = (0..layout.bodies).map(|_| next()).collect();
        let bodies: Vec<BodySolution> = (0..layout.bodies)
            .map(|_| BodySolution {
                velocity: next(),
                angular_velocity: next(),
                force: next(),
                torque: next(),
            })
            .collect();
        Self {
            motion: StateVelocity {
                frames: vec![frame],
                spins,
            },
            bodies,
            link_forces: (0..layout.links).map(|_| next()).collect(),
            mesh_error: layout.mesh_errors.then(|| MeshError {
                frames: vec![Twist {
                    linear: next(),
                    angular: next(),
                }],
                bodies: (0..layout.bodies).map(|_| next()).collect(),
                forces: (0..layout.bodies).map(|_| next()).collect(),
                uncertainty: 0.0,
                power: 0.0,
            }),
        }
    }
}

/// Numbers of a solution in the order of [`Record::new`], three per vector.
pub fn numbers(solution: &InstantaneousSolution) -> Vec<f64> {
    let frame = solution.motion.frames.first().copied().unwrap_or_default();
    let mut vectors = vec![frame.linear, frame.angular];
    vectors.extend(&solution.motion.spins);
    for body in &solution.bodies {
        vectors.extend([
            body.velocity,
            body.angular_velocity,
            body.force,
            body.torque,
        ]);
    }
    vectors.extend(&solution.link_forces);
    if let Some(error) = &solution.mesh_error {
        vectors.extend(error.frames.iter().flat_map(|f| [f.linear, f.angular]));
        vectors.extend(error.bodies.iter().chain(&error.forces));
    }
    vectors.iter().flatten().copied().collect()
}

/// Weights that make tabulated numbers dimensionless, and the largest velocity.
///
/// `values` are points of several records each, one per varying link. Velocities are relative to
/// the largest velocity and forces to the largest force. Angular velocities are multiplied, and
/// torques divided, by the length `longest` of the longest link.
pub fn weights(
    values: &[f64],
    records_per_point: usize,
    layout: Layout,
    longest: f64,
) -> (Vec<f64>, f64) {
    #[derive(Clone, Copy, PartialEq)]
    enum Kind {
        Velocity,
        Angular,
        Force,
        Torque,
    }
    use Kind::{Angular, Force, Torque, Velocity};
    let mut kinds = vec![Velocity, Angular];
    kinds.extend(vec![Angular; layout.bodies]);
    kinds.extend([Velocity, Angular, Force, Torque].repeat(layout.bodies));
    kinds.extend(vec![Force; layout.links]);
    if layout.mesh_errors {
        kinds.extend([Velocity, Angular]);
        kinds.extend(vec![Velocity; layout.bodies]);
        kinds.extend(vec![Force; layout.bodies]);
    }
    let kinds: Vec<Kind> = kinds.into_iter().flat_map(|kind| [kind; 3]).collect();
    let kinds = kinds.repeat(records_per_point);
    let largest = |wanted: Kind| {
        values
            .chunks(kinds.len())
            .flat_map(|point| point.iter().zip(&kinds))
            .filter(|(_, kind)| **kind == wanted)
            .fold(f64::MIN_POSITIVE, |m, (x, _)| m.max(x.abs()))
    };
    let (speed, force) = (largest(Velocity), largest(Force));
    let weight = |kind: &Kind| match kind {
        Velocity => 1.0 / speed,
        Angular => longest / speed,
        Force => 1.0 / force,
        Torque => 1.0 / (force * longest),
    };
    (kinds.iter().map(weight).collect(), speed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_records_are_inverse() {
        let layout = Layout {
            bodies: 2,
            links: 1,
            mesh_errors: true,
        };
        let written: Vec<f64> = (0..57).map(f64::from).collect();
        let Record {
            motion,
            bodies,
            link_forces,
            mesh_error,
        } = Record::new(&written, layout);
        let solution = InstantaneousSolution {
            mesh_error,
            ..InstantaneousSolution::new(bodies, link_forces, motion)
        };
        assert_eq!(numbers(&solution), written);
        assert_eq!(weights(&written, 1, layout, 1.0).0.len(), written.len());
    }
}
