//! Objectives of the search for strokes.

use nalgebra::Vector3;

use super::error::DesignError;
use super::totals::StrokeTotals;

/// What a search for strokes minimises, under which condition.
///
/// Implement it for objectives of one's own: `cost` suffices. A search refuses an objective whose
/// derivatives contradict its values, before it begins; [`check_objective`] does so without a
/// table.
///
/// ```
/// use design::{Objective, StrokeTotals, check_objective};
///
/// /// Least energy, divided by the displacement along x.
/// struct Cost;
///
/// impl Objective for Cost {
///     fn cost(&self, totals: &StrokeTotals) -> f64 {
///         totals.energy / totals.displacement.x
///     }
/// }
///
/// let mut totals = StrokeTotals { energy: 3.0, ..StrokeTotals::default() };
/// totals.displacement.x = 2.0;
/// assert_eq!(Cost.cost(&totals), 1.5);
/// let derivatives = Cost.cost_derivatives(&totals);
/// assert!((derivatives.displacement.x + 0.75).abs() < 1e-10);
/// check_objective(&Cost, &totals)?;
/// # Ok::<(), design::DesignError>(())
/// ```
#[allow(unused_variables)]
pub trait Objective: Sync {
    /// The quantity to minimise. It should be of the order of one, or a logarithm.
    fn cost(&self, totals: &StrokeTotals) -> f64;

    /// Derivatives of the cost with respect to the totals.
    ///
    /// By default central differences of fourth order, whose relative error is about 1e-11 for a
    /// smooth cost. They take 28 evaluations.
    fn cost_derivatives(&self, totals: &StrokeTotals) -> StrokeTotals {
        differences(totals, |totals| self.cost(totals), DIFFERENCE_STEP)
    }

    /// A quantity that must be zero, of the order of one for strokes that are far from it.
    fn condition(&self, totals: &StrokeTotals) -> Option<f64> {
        None
    }

    /// Derivatives of the condition with respect to the totals; by default as those of the cost.
    fn condition_derivatives(&self, totals: &StrokeTotals) -> StrokeTotals {
        let condition = |totals: &StrokeTotals| self.condition(totals).unwrap_or(f64::NAN);
        differences(totals, condition, DIFFERENCE_STEP)
    }

    /// Direction of the displacement of small strokes from which to start; none for all of them.
    fn direction(&self) -> Option<Vector3<f64>> {
        None
    }

    /// Axis of the rotation of small strokes from which to start, instead of a displacement.
    fn axis(&self) -> Option<Vector3<f64>> {
        None
    }

    /// Displacement, or rotation, of the strokes from which to start; none if any size will do.
    fn size(&self) -> Option<f64> {
        None
    }
}

/// Names of the components of [`StrokeTotals`], in the order of [`components`].
const COMPONENTS: [&str; 7] = [
    "displacement.x",
    "displacement.y",
    "displacement.z",
    "rotation.x",
    "rotation.y",
    "rotation.z",
    "energy",
];

/// The components of totals.
fn components(totals: &StrokeTotals) -> [f64; 7] {
    let (d, r) = (totals.displacement, totals.rotation);
    [d.x, d.y, d.z, r.x, r.y, r.z, totals.energy]
}

/// Totals from their components.
fn from_components([x, y, z, rx, ry, rz, energy]: [f64; 7]) -> StrokeTotals {
    StrokeTotals {
        displacement: Vector3::new(x, y, z),
        rotation: Vector3::new(rx, ry, rz),
        energy,
    }
}

/// Sizes of the components, by which steps of differences and derivatives are scaled: that of the
/// vector, or one for a vector of zero.
fn sizes(totals: &StrokeTotals) -> [f64; 7] {
    let size = |norm: f64| if norm > 0.0 { norm } else { 1.0 };
    let [d, r] = [totals.displacement, totals.rotation].map(|v| size(v.norm()));
    [d, d, d, r, r, r, size(totals.energy.abs())]
}

/// Step of the differences relative to the size of a component: about `ε^(1/5)`, which balances
/// rounding and the error of a formula of fourth order.
const DIFFERENCE_STEP: f64 = 1.0 / 1024.0;

/// Central differences of fourth order with these steps relative to the sizes of the components.
fn differences(
    totals: &StrokeTotals,
    quantity: impl Fn(&StrokeTotals) -> f64,
    step: f64,
) -> StrokeTotals {
    let (at, sizes) = (components(totals), sizes(totals));
    from_components(std::array::from_fn(|k| {
        let step = step * sizes[k];
        let moved = |steps: f64| {
            let mut moved = at;
            moved[k] += steps * step;
            quantity(&from_components(moved))
        };
        (8.0 * (moved(1.0) - moved(-1.0)) - (moved(2.0) - moved(-2.0))) / (12.0 * step)
    }))
}

/// Largest difference between derivatives and differences, relative to the largest derivative, with
/// respect to components divided by their sizes, beyond the error of the differences.
const MAX_CONTRADICTION: f64 = 1e-6;

/// Refuses an objective whose derivatives contradict its values at the totals of a stroke.
///
/// A search calls it with a stroke from which it starts.
///
/// # Errors
/// [`DesignError::WrongDerivative`], also for values or derivatives that are not finite.
pub fn check_objective(
    objective: &dyn Objective,
    totals: &StrokeTotals,
) -> Result<(), DesignError> {
    let cost = |totals: &StrokeTotals| objective.cost(totals);
    contradiction("cost", totals, cost, objective.cost_derivatives(totals))?;
    if objective.condition(totals).is_none() {
        return Ok(());
    }
    let condition = |totals: &StrokeTotals| objective.condition(totals).unwrap_or(f64::NAN);
    let given = objective.condition_derivatives(totals);
    contradiction("condition", totals, condition, given)
}

fn contradiction(
    what: &'static str,
    totals: &StrokeTotals,
    quantity: impl Fn(&StrokeTotals) -> f64,
    given: StrokeTotals,
) -> Result<(), DesignError> {
    let [fine, coarse] = [1.0, 2.0]
        .map(|factor| components(&differences(totals, &quantity, factor * DIFFERENCE_STEP)));
    let sizes = sizes(totals);
    let largest =
        (fine.iter().zip(sizes)).fold(0.0, |most: f64, (d, size)| most.max((d * size).abs()));
    let rounding = 64.0 * f64::EPSILON * quantity(totals).abs() / DIFFERENCE_STEP;
    for (k, given) in components(&given).into_iter().enumerate() {
        let allowed =
            MAX_CONTRADICTION * largest + (fine[k] - coarse[k]).abs() * sizes[k] + rounding;
        let difference = (given - fine[k]).abs() * sizes[k];
        if difference.is_nan() || difference > allowed {
            return Err(DesignError::WrongDerivative {
                what,
                component: COMPONENTS[k],
                given,
                by_differences: fine[k],
            });
        }
    }
    Ok(())
}

/// Which displacement counts.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DisplacementMeasure {
    /// Its length.
    Length,
    /// Its component along a unit vector.
    Along(Vector3<f64>),
}

impl DisplacementMeasure {
    /// The displacement that counts, and its derivatives with respect to the totals.
    pub fn of(&self, totals: &StrokeTotals) -> (f64, StrokeTotals) {
        let (value, direction) = match *self {
            Self::Along(direction) => (totals.displacement.dot(&direction), direction),
            Self::Length => {
                let length = totals.displacement.norm();
                let direction = totals.displacement.try_normalize(0.0);
                (length, direction.unwrap_or(Vector3::x()))
            }
        };
        let derivatives = StrokeTotals {
            displacement: direction,
            ..StrokeTotals::default()
        };
        (value, derivatives)
    }

    fn direction(&self) -> Option<Vector3<f64>> {
        match *self {
            Self::Along(direction) => Some(direction),
            Self::Length => None,
        }
    }
}

/// The stroke of the highest Lighthill efficiency, `6 π μ r Δ² / (E T)` with any drag `6 π μ r`.
#[derive(Clone, Copy, Debug)]
pub struct HighestEfficiency {
    /// Which displacement counts.
    pub measure: DisplacementMeasure,
}

/// The stroke of the least energy for a displacement.
#[derive(Clone, Copy, Debug)]
pub struct LeastEnergy {
    /// Which displacement counts.
    pub measure: DisplacementMeasure,
    /// The displacement.
    pub displacement: f64,
}

/// The stroke of the least energy for a rotation.
#[derive(Clone, Copy, Debug)]
pub struct LeastEnergyRotation {
    /// Unit vector of the axis.
    pub axis: Vector3<f64>,
    /// The component of the rotation vector along the axis.
    pub angle: f64,
}

/// Derivatives multiplied by a factor.
fn scaled(factor: f64, derivatives: StrokeTotals) -> StrokeTotals {
    StrokeTotals {
        displacement: factor * derivatives.displacement,
        rotation: factor * derivatives.rotation,
        energy: factor * derivatives.energy,
    }
}

/// Derivatives of the logarithm of the energy, by which steps do not depend on its size.
fn of_log_energy(totals: &StrokeTotals) -> StrokeTotals {
    StrokeTotals {
        energy: 1.0 / totals.energy,
        ..StrokeTotals::default()
    }
}

impl Objective for HighestEfficiency {
    fn cost(&self, totals: &StrokeTotals) -> f64 {
        let (displacement, _) = self.measure.of(totals);
        totals.energy.ln() - 2.0 * displacement.ln()
    }

    fn cost_derivatives(&self, totals: &StrokeTotals) -> StrokeTotals {
        let (displacement, direction) = self.measure.of(totals);
        StrokeTotals {
            displacement: -2.0 / displacement * direction.displacement,
            ..of_log_energy(totals)
        }
    }

    fn direction(&self) -> Option<Vector3<f64>> {
        self.measure.direction()
    }
}

impl Objective for LeastEnergy {
    fn cost(&self, totals: &StrokeTotals) -> f64 {
        totals.energy.ln()
    }

    fn cost_derivatives(&self, totals: &StrokeTotals) -> StrokeTotals {
        of_log_energy(totals)
    }

    fn condition(&self, totals: &StrokeTotals) -> Option<f64> {
        Some(self.measure.of(totals).0 / self.displacement - 1.0)
    }

    fn condition_derivatives(&self, totals: &StrokeTotals) -> StrokeTotals {
        scaled(1.0 / self.displacement, self.measure.of(totals).1)
    }

    fn direction(&self) -> Option<Vector3<f64>> {
        self.measure.direction()
    }

    fn size(&self) -> Option<f64> {
        Some(self.displacement)
    }
}

impl Objective for LeastEnergyRotation {
    fn cost(&self, totals: &StrokeTotals) -> f64 {
        totals.energy.ln()
    }

    fn cost_derivatives(&self, totals: &StrokeTotals) -> StrokeTotals {
        of_log_energy(totals)
    }

    fn condition(&self, totals: &StrokeTotals) -> Option<f64> {
        Some(totals.rotation.dot(&self.axis) / self.angle - 1.0)
    }

    fn condition_derivatives(&self, _: &StrokeTotals) -> StrokeTotals {
        StrokeTotals {
            rotation: 1.0 / self.angle * self.axis,
            ..StrokeTotals::default()
        }
    }

    fn axis(&self) -> Option<Vector3<f64>> {
        Some(self.axis * self.angle.signum())
    }

    fn size(&self) -> Option<f64> {
        Some(self.angle.abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An objective of another one, whose derivatives with respect to the energy are multiplied.
    struct Wrong<'a>(&'a dyn Objective, f64);

    impl Objective for Wrong<'_> {
        fn cost(&self, totals: &StrokeTotals) -> f64 {
            self.0.cost(totals)
        }

        fn cost_derivatives(&self, totals: &StrokeTotals) -> StrokeTotals {
            let mut derivatives = self.0.cost_derivatives(totals);
            derivatives.energy *= self.1;
            derivatives
        }

        fn condition(&self, totals: &StrokeTotals) -> Option<f64> {
            self.0.condition(totals)
        }
    }

    /// The energy, if the displacement is along y, with a condition of the wrong sign.
    struct Sideways;

    impl Objective for Sideways {
        fn cost(&self, totals: &StrokeTotals) -> f64 {
            totals.energy
        }

        fn condition(&self, totals: &StrokeTotals) -> Option<f64> {
            Some(totals.displacement.x)
        }

        fn condition_derivatives(&self, _: &StrokeTotals) -> StrokeTotals {
            StrokeTotals {
                displacement: -Vector3::x(),
                ..StrokeTotals::default()
            }
        }
    }

    #[test]
    fn bug_objectives_whose_derivatives_contradict_their_values_are_refused() {
        let totals = StrokeTotals {
            displacement: Vector3::new(0.03, -0.01, 0.0),
            rotation: Vector3::new(0.0, 0.0, 0.2),
            energy: 140.0,
        };
        let measures = [
            DisplacementMeasure::Length,
            DisplacementMeasure::Along(Vector3::x()),
        ];
        for measure in measures {
            let displacement = 0.05;
            let axis = Vector3::z();
            let least = LeastEnergy {
                measure,
                displacement,
            };
            let rotation = LeastEnergyRotation { axis, angle: 0.3 };
            let objectives: [&dyn Objective; 3] =
                [&HighestEfficiency { measure }, &least, &rotation];
            for objective in objectives {
                check_objective(objective, &totals).unwrap();
                for factor in [-1.0, 0.0, 1.001, f64::NAN] {
                    let error = check_objective(&Wrong(objective, factor), &totals).unwrap_err();
                    let expected = "the cost with respect to energy";
                    assert!(error.to_string().contains(expected), "{error}");
                }
            }
        }
        let error = check_objective(&Sideways, &totals).unwrap_err();
        assert!(
            error
                .to_string()
                .contains("the condition with respect to displacement.x is -1")
        );
    }
}
