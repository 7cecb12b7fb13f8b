//! The numbers of a solution that are tabulated, in a fixed order.

use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};

use crate::mesh_error::{MeshError, Uncertainty};
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
    /// Discretisation errors that were subtracted; their uncertainty is not tabulated.
    pub mesh_error: Option<MeshError>,
}

impl Layout {
    /// Length of the numbers of one record.
    pub fn numbers(self) -> usize {
        let records = if self.mesh_errors { 2 } else { 1 };
        records * 3 * (2 + 5 * self.bodies + self.links)
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
            let link_forces = (0..layout.links).map(|_| next()).collect();
            // Tables are of scenes whose joints are all prescribed.
            let motion = StateVelocity {
                frames,
                spins,
                joints: Vec::new(),
            };
            (motion, bodies, link_forces)
        };
        let (motion, bodies, link_forces) = quantities();
        let mesh_error = layout.mesh_errors.then(|| {
            let (motion, bodies, link_forces) = quantities();
            MeshError {
                motion,
                bodies,
                link_forces,
                uncertainty: Uncertainty::default(),
            }
        });
        Self {
            motion,
            bodies,
            link_forces,
            mesh_error,
        }
    }
}

/// Numbers of a solution in the order of [`Record::new`], three per vector.
pub fn numbers(solution: &InstantaneousSolution) -> Vec<f64> {
    let mut numbers = quantities(&solution.motion, &solution.bodies, &solution.link_forces);
    if let Some(error) = &solution.mesh_error {
        numbers.extend(quantities(&error.motion, &error.bodies, &error.link_forces));
    }
    numbers
}

fn quantities(
    motion: &StateVelocity,
    bodies: &[BodySolution],
    link_forces: &[Vector3<f64>],
) -> Vec<f64> {
    let frame = motion.frames.first().copied().unwrap_or_default();
    let mut vectors = vec![&frame.linear, &frame.angular];
    vectors.extend(&motion.spins);
    vectors.extend(bodies.iter().flat_map(BodySolution::vectors));
    vectors.extend(link_forces);
    vectors.into_iter().flatten().copied().collect()
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
        kinds.extend_from_within(..);
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
        let written: Vec<f64> = (0..78).map(f64::from).collect();
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
