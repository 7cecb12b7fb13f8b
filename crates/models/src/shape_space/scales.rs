//! Scales that make tabulated numbers comparable.

use super::solved_shapes::Bars;
use crate::record::Layout;

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
/// torques divided, by the length `longest` of the longest joint.
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
        Discretisation,
    }
    use Kind::{Angular, Discretisation, Force, Torque, Velocity};
    let mut kinds = vec![Velocity, Angular];
    kinds.extend(vec![Angular; layout.bodies]);
    kinds.extend([Velocity, Angular, Force, Torque].repeat(layout.bodies));
    kinds.extend(vec![Force; layout.joints]);
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
    fn every_number_has_a_weight() {
        let layout = Layout {
            bodies: 2,
            joints: 1,
            mesh_errors: true,
        };
        let values = vec![1.0; layout.numbers()];
        let scales = scales(&values, 1, layout, 1.0, 1e-3, &Bars::default());
        assert_eq!(scales.weights.len(), values.len());
        assert_eq!(scales.tolerance, 1e-3);
    }
}
