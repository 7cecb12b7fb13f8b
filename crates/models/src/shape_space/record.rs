//! Responses as numbers in a fixed order, which tables interpolate, and the scales of the numbers.

use nalgebra::Vector3;
use rigid::{JointLoad, StateVelocity, Twist};

use super::solved_shapes::Bars;
use crate::response::{BodySolution, Response};
use crate::solution::InstantaneousSolution;

/// Numbers of bodies and joints of a scene, which determine the length of a record.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    pub bodies: usize,
    pub joints: usize,
    /// Whether some joints are amplitudes of deformations.
    pub deforms: bool,
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
        records * self.record()
    }

    /// Length of the numbers of one response.
    fn record(self) -> usize {
        3 * (2 + 5 * self.bodies) + 7 * self.joints + self.rates()
    }

    /// Number of rates of amplitudes.
    fn rates(self) -> usize {
        if self.deforms { self.joints } else { 0 }
    }
}

impl Record {
    /// Reads a record from its numbers, the inverse of [`numbers`].
    pub fn new(numbers: &[f64], layout: Layout) -> Self {
        let response = |numbers: &[f64]| {
            let mut response = Response {
                motion: StateVelocity {
                    frames: vec![Twist::default()],
                    spins: vec![Vector3::zeros(); layout.bodies],
                    // Records are of scenes whose joints are all prescribed.
                    joints: Vec::new(),
                },
                bodies: vec![BodySolution::default(); layout.bodies],
                joint_loads: vec![JointLoad::default(); layout.joints],
                // Bodies of free swimmers are not held.
                holding: Vec::new(),
                mean_flow: None,
                slip_power: 0.0,
                amplitude_rates: numbers[numbers.len() - layout.rates()..].to_vec(),
            };
            let numbers = &numbers[..numbers.len() - layout.rates()];
            let vectors = numbers.chunks_exact(3).map(Vector3::from_column_slice);
            let read = response.vectors_mut().zip(vectors);
            read.for_each(|(vector, number)| *vector = number);
            let drives = &numbers[numbers.len() - layout.joints..];
            let read = response.drives_mut().zip(drives);
            read.for_each(|(drive, number)| *drive = *number);
            response
        };
        let (solution, error) = numbers.split_at(layout.record());
        Self {
            response: response(solution),
            mesh_error: layout.mesh_errors.then(|| response(error)),
        }
    }
}

/// Numbers of a solution in the order of [`Record::new`]: three per vector, one per drive, one per
/// rate of an amplitude.
pub fn numbers(solution: &InstantaneousSolution) -> Vec<f64> {
    let error = solution.mesh_error.as_ref().map(|error| &error.response);
    let responses = [Some(&solution.response), error].into_iter().flatten();
    let numbers = |response: &Response| -> Vec<f64> {
        let of_vectors = response.vectors().flatten().copied();
        let rates = response.amplitude_rates.iter().copied();
        of_vectors.chain(response.drives()).chain(rates).collect()
    };
    responses.flat_map(numbers).collect()
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
/// `values` are points of several records each, one per varying joint. Velocities are relative to
/// the largest velocity and forces to the largest force. Angular velocities are multiplied, and
/// torques divided, by the length `longest` of the longest joint. Drives have weight zero, because
/// they are components of forces and torques that have weights, but where bodies deform: there they
/// are relative to the largest one. Rates of amplitudes have weight zero, because they are given.
///
/// Discretisation errors change from shape to shape, so the tolerance is at least the error bar of
/// the mesh. Forces with a larger relative error bar have a smaller weight. The signed
/// discretisation errors themselves have weight zero: they vary as much as their own size.
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
        Drive,
        Rate,
        Discretisation,
    }
    use Kind::{Angular, Discretisation, Drive, Force, Rate, Torque, Velocity};
    let mut vectors = vec![Velocity, Angular];
    vectors.extend(vec![Angular; layout.bodies]);
    vectors.extend([Velocity, Angular, Force, Torque].repeat(layout.bodies));
    vectors.extend([Force, Torque].repeat(layout.joints));
    let mut kinds: Vec<Kind> = vectors.into_iter().flat_map(|kind| [kind; 3]).collect();
    kinds.extend(vec![Drive; layout.joints]);
    kinds.extend(vec![Rate; layout.rates()]);
    if layout.mesh_errors {
        kinds.extend(vec![Discretisation; kinds.len()]);
    }
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
        Drive if layout.deforms => of_force * force / largest(Drive),
        Drive | Rate | Discretisation => 0.0,
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
    use crate::discretisation_error::DiscretisationError;

    #[test]
    fn numbers_and_records_are_inverse() {
        let layout = Layout {
            bodies: 2,
            joints: 1,
            deforms: false,
            mesh_errors: true,
        };
        let written: Vec<f64> = (0..86).map(f64::from).collect();
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

    #[test]
    fn every_number_has_a_weight() {
        let layout = Layout {
            bodies: 2,
            joints: 1,
            deforms: true,
            mesh_errors: true,
        };
        let values = vec![1.0; layout.numbers()];
        let scales = scales(&values, 1, layout, 1.0, 1e-3, &Bars::default());
        assert_eq!(scales.weights.len(), values.len());
        assert_eq!(scales.tolerance, 1e-3);
    }
}
