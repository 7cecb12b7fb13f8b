//! Quantities of a solution, uncorrected and corrected, and their errors against exact ones.

use nalgebra::Vector3;
use swimmer::models::{BodySolution, InstantaneousSolution};
use swimmer::{Outcome, Scene};

/// Size below which a quantity is zero but for rounding, relative to what it is compared with.
const NEGLIGIBLE: f64 = 1e-9;

/// A quantity of one solution; scalars have one vector along x.
pub struct Quantity {
    pub name: &'static str,
    /// Value of the discrete problem.
    uncorrected: Vec<Vector3<f64>>,
    /// This value minus its estimated discretisation error; the same if there is no estimate.
    corrected: Vec<Vector3<f64>>,
    /// Error bar, the largest over the bodies; `None` if there is none.
    bar: Option<f64>,
    /// Part of the bar that does not belong to the mesh.
    beside_mesh: f64,
    /// Size below which the quantity is rounding.
    negligible: f64,
}

/// Errors of a quantity, relative to its scale.
#[derive(Clone, Debug)]
pub struct Comparison {
    pub name: &'static str,
    /// Largest norm over the bodies of the exact vectors.
    pub scale: f64,
    /// Largest error over the bodies.
    pub uncorrected: f64,
    pub corrected: f64,
    pub bar: Option<f64>,
    /// Part of the bar that does not belong to the mesh.
    pub beside_mesh: f64,
    /// Largest estimated error over the bodies.
    pub estimate: f64,
    /// Estimated over true error: `(e_h · e) / (e · e)` over all components.
    pub effectivity: f64,
    /// Error bar of the exact value.
    pub exact_bar: f64,
}

impl Quantity {
    /// Errors against the same quantity of an exact solution, with its relative error bar.
    ///
    /// `None` for a quantity that is zero by symmetry.
    pub fn compare(&self, exact: &Self, exact_bar: f64) -> Option<Comparison> {
        let scale = largest(exact.uncorrected.iter().copied());
        if scale <= exact.negligible {
            return None;
        }
        let error = |values: &[Vector3<f64>]| -> Vec<Vector3<f64>> {
            let pairs = values.iter().zip(&exact.uncorrected);
            pairs
                .map(|(value, exact)| (value - exact) / scale)
                .collect()
        };
        let (before, after) = (error(&self.uncorrected), error(&self.corrected));
        let (mut product, mut square, mut estimate) = (0.0, 0.0, 0.0_f64);
        for (before, after) in before.iter().zip(&after) {
            let estimated = before - after;
            product += estimated.dot(before);
            square += before.norm_squared();
            estimate = estimate.max(estimated.norm());
        }
        Some(Comparison {
            name: self.name,
            scale,
            uncorrected: largest(before.into_iter()),
            corrected: largest(after.into_iter()),
            bar: self.bar.map(|bar| bar / scale),
            beside_mesh: self.beside_mesh / scale,
            estimate,
            effectivity: product / square,
            exact_bar,
        })
    }
}

fn largest(vectors: impl Iterator<Item = Vector3<f64>>) -> f64 {
    vectors.fold(0.0, |m, v| m.max(v.norm()))
}

fn sum_of(vectors: &[Vector3<f64>], errors: Option<&[Vector3<f64>]>) -> Vec<Vector3<f64>> {
    match errors {
        Some(errors) => vectors.iter().zip(errors).map(|(v, e)| v - e).collect(),
        None => vectors.to_vec(),
    }
}

/// Quantities of an instantaneous solution: this function alone knows what a solution holds.
///
/// Forces, torques and link forces are given loads where there are no links, and left out.
pub fn of_instant(scene: &Scene, solution: &InstantaneousSolution) -> Vec<Quantity> {
    let set = scene.articulation();
    let of_bodies = |of: fn(&BodySolution) -> Vector3<f64>| -> Vec<Vector3<f64>> {
        solution.bodies.iter().map(of).collect()
    };
    let error = solution.mesh_error.as_ref();
    let angular_errors = error.map(|error| {
        let mut errors = vec![Vector3::zeros(); solution.bodies.len()];
        // Bodies keep their orientation relative to the frame of their linkage.
        for (linkage, frame) in set.linkages().iter().zip(&error.frames) {
            for &body in &linkage.bodies {
                errors[body] = frame.angular;
            }
        }
        errors
    });
    let quantity = |name, values: Vec<Vector3<f64>>, errors: Option<&[Vector3<f64>]>| Quantity {
        name,
        corrected: sum_of(&values, errors),
        uncorrected: values,
        bar: None,
        beside_mesh: 0.0,
        negligible: 0.0,
    };
    let bars = &solution.error_estimate;
    let velocities = of_bodies(|b| b.velocity);
    let speed = largest(velocities.iter().copied());
    let radius = scene.bodies().iter().map(|b| b.bounding_radius());
    let radius = radius.fold(0.0, f64::max);
    let power = solution.power();
    let mut quantities = vec![
        Quantity {
            bar: Some(bars.total()),
            beside_mesh: bars.total() - bars.mesh.unwrap_or(0.0),
            ..quantity("velocity", velocities, error.map(|e| &e.bodies[..]))
        },
        Quantity {
            negligible: NEGLIGIBLE * speed / radius,
            ..quantity(
                "angular velocity",
                of_bodies(|b| b.angular_velocity),
                angular_errors.as_deref(),
            )
        },
        Quantity {
            bar: Some(solution.power_error.total()),
            beside_mesh: solution.power_error.total() - solution.power_error.mesh.unwrap_or(0.0),
            ..quantity(
                "power",
                vec![Vector3::x() * power],
                error
                    .map(|e| [Vector3::x() * e.power])
                    .as_ref()
                    .map(|e| &e[..]),
            )
        },
    ];
    if !set.links().is_empty() {
        let forces = of_bodies(|b| b.force);
        let force = largest(forces.iter().copied());
        quantities.push(Quantity {
            bar: error.map(|e| e.force()),
            ..quantity("force", forces, error.map(|e| &e.forces[..]))
        });
        quantities.push(Quantity {
            negligible: NEGLIGIBLE * force * radius,
            ..quantity("torque", of_bodies(|b| b.torque), None)
        });
        quantities.push(quantity("link force", solution.link_forces.clone(), None));
    }
    quantities
}

/// Quantities of a stroke: this function alone knows what an outcome holds.
pub fn of_stroke(outcome: &Outcome) -> Vec<Quantity> {
    let count = outcome.displacement.len().max(1) as f64;
    let mean = |vectors: &[Vector3<f64>]| vec![vectors.iter().sum::<Vector3<f64>>() / count];
    let accumulated = outcome.accumulated_error.as_ref();
    let quantity = |name, value: Vec<Vector3<f64>>, error: Option<Vec<Vector3<f64>>>| Quantity {
        name,
        corrected: sum_of(&value, error.as_deref()),
        uncorrected: value,
        bar: None,
        beside_mesh: 0.0,
        negligible: 0.0,
    };
    let bars = &outcome.error_estimate;
    let work = &outcome.work_error;
    vec![
        Quantity {
            bar: Some(bars.total()),
            beside_mesh: bars.total() - bars.mesh.unwrap_or(0.0),
            ..quantity(
                "displacement",
                mean(&outcome.displacement),
                outcome.mesh_error.as_deref().map(mean),
            )
        },
        Quantity {
            // A stroke turns by a few degrees unless its symmetry forbids it.
            negligible: NEGLIGIBLE,
            ..quantity(
                "rotation",
                vec![outcome.rotation],
                accumulated.map(|e| e.rotation.iter().take(1).copied().collect()),
            )
        },
        Quantity {
            bar: Some(work.total()),
            beside_mesh: work.total() - work.mesh.unwrap_or(0.0),
            ..quantity(
                "work",
                vec![Vector3::x() * outcome.work],
                accumulated.map(|e| vec![Vector3::x() * e.work]),
            )
        },
    ]
}
