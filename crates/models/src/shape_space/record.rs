//! The numbers of a solution that are tabulated, in a fixed order.

use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};

use super::solved_shapes::Bars;
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

/// Scales of tabulated numbers.
pub struct Scales {
    /// Weights that make the numbers of a point dimensionless.
    pub weights: Vec<f64>,
    /// The largest velocity.
    pub speed: f64,
    /// Interpolation error of weighted numbers that a table needs not go below.
    pub tolerance: f64,
}

/// Scales of tabulated numbers, for tables of the relative error `tolerance`.
///
/// `values` are points of several records each, one per varying link. Velocities are relative to
/// the largest velocity and forces to the largest force. Angular velocities are multiplied, and
/// torques divided, by the length `longest` of the longest link.
///
/// The errors of a mesh change from shape to shape: the tolerance is at least their error bar, and
/// forces count less if their bar is larger than that. Estimated discretisation errors do not
/// count, their changes are as large as they are.
pub fn scales(
    values: &[f64],
    records_per_point: usize,
    layout: Layout,
    longest: f64,
    tolerance: f64,
    bars: &Bars,
) -> Scales {
    #[derive(Clone, Copy, PartialEq)]
    enum Kind {
        Velocity,
        Angular,
        Force,
        Torque,
        Discretisation,
    }
    use Kind::{Angular, Discretisation, Force, Torque, Velocity};
    let mut kinds = vec![Velocity, Angular];
    kinds.extend(vec![Angular; layout.bodies]);
    kinds.extend([Velocity, Angular, Force, Torque].repeat(layout.bodies));
    kinds.extend(vec![Force; layout.links]);
    if layout.mesh_errors {
        kinds.extend(vec![Discretisation; kinds.len()]);
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
    let tolerance = tolerance.max(bars.mesh / speed);
    let of_force = (tolerance * force / bars.mesh_force).min(1.0) / force;
    let weight = |kind: &Kind| match kind {
        Velocity => 1.0 / speed,
        Angular => longest / speed,
        Force => of_force,
        Torque => of_force / longest,
        Discretisation => 0.0,
    };
    Scales {
        weights: kinds.iter().map(weight).collect(),
        speed,
        tolerance,
    }
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
        let scales = scales(&written, 1, layout, 1.0, 1e-3, &Bars::default());
        assert_eq!(scales.weights.len(), written.len());
        assert_eq!(scales.tolerance, 1e-3);
    }
}
