//! Quantities of a solution, uncorrected and corrected, and their errors against exact ones.

use nalgebra::{DVector, Matrix3, Vector3};
use serde::{Deserialize, Serialize};
use swimmer::models::{BodySolution, ErrorEstimate, InstantaneousSolution};
use swimmer::{Outcome, Scene};

/// Size below which a quantity is zero but for rounding, relative to what it is compared with.
const NEGLIGIBLE: f64 = 1e-9;

/// Error bar of the exact value, over the smaller one of the errors measured with it, above which
/// the comparison is dropped.
const MAX_EXACT_BAR: f64 = 0.05;

/// A case and what became of it.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub struct Case {
    /// `instant`, `squirmer` or `stroke`.
    pub kind: String,
    /// The seed from which it is drawn again.
    pub seed: u64,
    pub model: String,
    /// Names of the groups that it belongs to.
    pub groups: Vec<String>,
    /// Smallest gap, in radii of the smaller neighbour.
    pub gap: f64,
    /// What was drawn.
    pub description: String,
    pub end: End,
}

/// Result of a case.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
pub enum End {
    Compared {
        comparisons: Vec<Comparison>,
        dofs: usize,
        seconds: f64,
    },
    Refused(String),
}

impl Case {
    /// All comparisons.
    pub fn comparisons(&self) -> &[Comparison] {
        match &self.end {
            End::Compared { comparisons, .. } => comparisons,
            End::Refused(_) => &[],
        }
    }

    /// Comparisons without those whose exact value is not exact enough.
    pub fn exact_comparisons(&self) -> impl Iterator<Item = &Comparison> {
        self.comparisons().iter().filter(|c| !c.is_dropped())
    }
}

/// Errors of a quantity, relative to its scale.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Comparison {
    pub name: String,
    /// Largest norm over the bodies of the exact vectors.
    pub scale: f64,
    /// Largest error over the bodies.
    pub uncorrected: f64,
    pub corrected: f64,
    pub bar: Option<f64>,
    /// Part of the bar that does not belong to the mesh.
    pub bar_without_mesh: f64,
    /// Largest estimated error over the bodies.
    pub estimate: f64,
    /// Estimated over true error: `(e_h · e) / (e · e)` over all components; `None` for no error.
    pub effectivity: Option<f64>,
    /// Error bar of the exact value.
    pub exact_bar: f64,
}

impl Comparison {
    /// Whether the exact value is not exact enough to measure an error.
    pub fn is_dropped(&self) -> bool {
        self.exact_bar > MAX_EXACT_BAR * self.uncorrected.min(self.corrected)
    }
}

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
    bar_without_mesh: f64,
    /// Size below which the quantity is rounding.
    negligible: f64,
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
            bar_without_mesh: 0.0,
            negligible: 0.0,
        }
    }

    fn with_bar(mut self, bars: &ErrorEstimate) -> Self {
        self.bar = Some(bars.total());
        self.bar_without_mesh = bars.total() - bars.mesh.unwrap_or(0.0);
        self
    }

    fn negligible_below(mut self, size: f64) -> Self {
        self.negligible = size;
        self
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
            bar_without_mesh: self.bar_without_mesh / scale,
            estimate,
            effectivity: (square > 0.0).then_some(product / square),
            exact_bar,
        })
    }
}

fn norm_of_largest(vectors: &[DVector<f64>]) -> f64 {
    vectors.iter().fold(0.0, |m, v| m.max(v.norm()))
}

/// Quantities of an instantaneous solution.
///
/// Forces, torques and joint forces are given loads where there are no joints, and left out.
pub fn of_instant(scene: &Scene, solution: &InstantaneousSolution) -> Vec<Quantity> {
    let before = solution.uncorrected();
    let quantity = |name, of: fn(&BodySolution) -> Vector3<f64>| {
        let values = |solution: &InstantaneousSolution| solution.bodies.iter().map(of).collect();
        Quantity::new(name, values(&before), values(solution))
    };
    let size = |of: fn(&BodySolution) -> f64| solution.bodies.iter().map(of).fold(0.0, f64::max);
    let (speed, force) = (size(|b| b.velocity.norm()), size(|b| b.force.norm()));
    let radius = scene.bodies().iter().map(|b| b.bounding_radius());
    let radius = radius.fold(0.0, f64::max);
    let power = |power: f64| vec![Vector3::x() * power];
    let mut quantities = vec![
        quantity("velocity", |b| b.velocity).with_bar(&solution.error_estimate),
        quantity("angular velocity", |b| b.angular_velocity)
            .negligible_below(NEGLIGIBLE * speed / radius),
        Quantity::new("power", power(before.power()), power(solution.power()))
            .with_bar(&solution.power_error),
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
        quantities.push(quantity("force", |b| b.force).with_bar(bars));
        quantities
            .push(quantity("torque", |b| b.torque).negligible_below(NEGLIGIBLE * force * radius));
        let (before, after) = (before.response.joint_forces, solution.joint_forces.clone());
        quantities.push(Quantity::new("link force", before, after).with_bar(bars));
    }
    quantities
}

/// Quantities of a stroke.
pub fn of_stroke(outcome: &Outcome) -> Vec<Quantity> {
    let count = outcome.displacement.len().max(1) as f64;
    let mean = |vectors: &[Vector3<f64>]| vectors.iter().sum::<Vector3<f64>>() / count;
    let accumulated = outcome.accumulated_error.as_ref();
    let quantity = |name, value: Vector3<f64>, error: Option<Vector3<f64>>| {
        let uncorrected = error.map_or(value, |error| value + error);
        Quantity::new(name, vec![uncorrected], vec![value])
    };
    let displacement = mean(&outcome.displacement);
    let removed = outcome.mesh_error.as_deref().map(mean);
    let rotation = accumulated.and_then(|e| e.rotation.first().copied());
    let work = accumulated.map(|e| Vector3::x() * e.work);
    vec![
        quantity("displacement", displacement, removed).with_bar(&outcome.error_estimate),
        // A stroke turns by a few degrees unless its symmetry forbids it.
        quantity("rotation", outcome.rotation, rotation).negligible_below(NEGLIGIBLE),
        quantity("work", Vector3::x() * outcome.work, work).with_bar(&outcome.work_error),
    ]
}
