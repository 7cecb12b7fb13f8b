//! Quantities of a solution, uncorrected and corrected, and their errors against exact ones.

use nalgebra::{DVector, Matrix3, Vector3};
use swimmer::models::{BodySolution, InstantaneousSolution};
use swimmer::{Outcome, Scene};

/// Size below which a quantity is zero but for rounding, relative to what it is compared with.
const NEGLIGIBLE: f64 = 1e-9;

/// A quantity of one solution; scalars have one vector along x, stresslets vectors of nine
/// components.
pub struct Quantity {
    pub name: &'static str,
    /// Value of the discrete problem.
    uncorrected: Vec<DVector<f64>>,
    /// The answer: this value minus its estimated discretisation error, if there is an estimate.
    corrected: Vec<DVector<f64>>,
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
    pub name: String,
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
    fn new(
        name: &'static str,
        uncorrected: Vec<Vector3<f64>>,
        corrected: Vec<Vector3<f64>>,
    ) -> Self {
        let arrays = |vectors: Vec<Vector3<f64>>| -> Vec<DVector<f64>> {
            let slices = vectors.iter().map(Vector3::as_slice);
            slices.map(DVector::from_column_slice).collect()
        };
        Self {
            name,
            uncorrected: arrays(uncorrected),
            corrected: arrays(corrected),
            bar: None,
            beside_mesh: 0.0,
            negligible: 0.0,
        }
    }

    /// Errors against the same quantity of an exact solution, with its relative error bar.
    ///
    /// `None` for a quantity that is zero by symmetry.
    pub fn compare(&self, exact: &Self, exact_bar: f64) -> Option<Comparison> {
        let scale = norm_of_largest(&exact.uncorrected);
        if scale <= exact.negligible {
            return None;
        }
        let error = |values: &[DVector<f64>]| -> Vec<DVector<f64>> {
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
            name: self.name.to_owned(),
            scale,
            uncorrected: norm_of_largest(&before),
            corrected: norm_of_largest(&after),
            bar: self.bar.map(|bar| bar / scale),
            beside_mesh: self.beside_mesh / scale,
            estimate,
            effectivity: product / square,
            exact_bar,
        })
    }
}

fn norm_of_largest(vectors: &[DVector<f64>]) -> f64 {
    vectors.iter().fold(0.0, |m, v| m.max(v.norm()))
}

fn largest(vectors: impl Iterator<Item = Vector3<f64>>) -> f64 {
    vectors.fold(0.0, |m, v| m.max(v.norm()))
}

fn with(vectors: &[Vector3<f64>], errors: Option<&[Vector3<f64>]>) -> Vec<Vector3<f64>> {
    match errors {
        Some(errors) => vectors.iter().zip(errors).map(|(v, e)| v + e).collect(),
        None => vectors.to_vec(),
    }
}

/// Quantities of an instantaneous solution: this function alone knows what a solution holds.
///
/// Forces, torques and joint forces are given loads where there are no joints, and left out.
pub fn of_instant(scene: &Scene, solution: &InstantaneousSolution) -> Vec<Quantity> {
    let before = solution.uncorrected();
    let quantity = |name, of: fn(&BodySolution) -> Vector3<f64>| {
        let values = |solution: &InstantaneousSolution| solution.bodies.iter().map(of).collect();
        Quantity::new(name, values(&before), values(solution))
    };
    let bars = &solution.error_estimate;
    let size = |of: fn(&BodySolution) -> Vector3<f64>| largest(solution.bodies.iter().map(of));
    let (speed, force) = (size(|b| b.velocity), size(|b| b.force));
    let radius = scene.bodies().iter().map(|b| b.bounding_radius());
    let radius = radius.fold(0.0, f64::max);
    let power = |power: f64| vec![Vector3::x() * power];
    let mut quantities = vec![
        Quantity {
            bar: Some(bars.total()),
            beside_mesh: bars.total() - bars.mesh.unwrap_or(0.0),
            ..quantity("velocity", |b| b.velocity)
        },
        Quantity {
            negligible: NEGLIGIBLE * speed / radius,
            ..quantity("angular velocity", |b| b.angular_velocity)
        },
        Quantity {
            bar: Some(solution.power_error.total()),
            beside_mesh: solution.power_error.total() - solution.power_error.mesh.unwrap_or(0.0),
            ..Quantity::new("power", power(before.power()), power(solution.power()))
        },
    ];
    if let Some(stresslets) = &solution.stresslets {
        let arrays = |matrices: &[Matrix3<f64>]| -> Vec<DVector<f64>> {
            let slices = matrices.iter().map(Matrix3::as_slice);
            slices.map(DVector::from_column_slice).collect()
        };
        quantities.push(Quantity {
            uncorrected: arrays(&stresslets.uncorrected),
            corrected: arrays(&stresslets.bodies),
            bar: stresslets.error,
            ..Quantity::new("stresslet", vec![], vec![])
        });
    }
    if !scene.articulation().joints().is_empty() {
        let bars = &solution.force_error;
        let (bar, beside_mesh) = (Some(bars.total()), bars.total() - bars.mesh.unwrap_or(0.0));
        quantities.push(Quantity {
            bar,
            beside_mesh,
            ..quantity("force", |b| b.force)
        });
        quantities.push(Quantity {
            negligible: NEGLIGIBLE * force * radius,
            ..quantity("torque", |b| b.torque)
        });
        let (before, after) = (before.response.joint_forces, solution.joint_forces.clone());
        quantities.push(Quantity {
            bar,
            beside_mesh,
            ..Quantity::new("link force", before, after)
        });
    }
    quantities
}

/// Quantities of a stroke: this function alone knows what an outcome holds.
pub fn of_stroke(outcome: &Outcome) -> Vec<Quantity> {
    let count = outcome.displacement.len().max(1) as f64;
    let mean = |vectors: &[Vector3<f64>]| vec![vectors.iter().sum::<Vector3<f64>>() / count];
    let accumulated = outcome.accumulated_error.as_ref();
    let quantity = |name, value: Vec<Vector3<f64>>, error: Option<Vec<Vector3<f64>>>| {
        Quantity::new(name, with(&value, error.as_deref()), value)
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
