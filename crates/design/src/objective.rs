//! Objectives of the search for strokes.

use nalgebra::Vector3;

use super::totals::StrokeTotals;

/// A quantity with its derivatives with respect to the totals of a stroke.
pub type WithDerivatives = (f64, StrokeTotals);

/// What a search for strokes minimises, under which condition.
///
/// Implement it for objectives of one's own; the derivatives are exact ones.
///
/// ```
/// use design::{Objective, StrokeTotals, WithDerivatives};
/// use nalgebra::Vector3;
///
/// /// Least energy, divided by the displacement along x.
/// struct Cost;
///
/// impl Objective for Cost {
///     fn cost(&self, totals: &StrokeTotals) -> WithDerivatives {
///         let (x, energy) = (totals.displacement.x, totals.energy);
///         let derivatives = StrokeTotals {
///             displacement: Vector3::x() * (-energy / (x * x)),
///             energy: 1.0 / x,
///             ..StrokeTotals::default()
///         };
///         (energy / x, derivatives)
///     }
/// }
/// ```
#[allow(unused_variables)]
pub trait Objective: Sync {
    /// The quantity to minimise. It should be of the order of one, or a logarithm.
    fn cost(&self, totals: &StrokeTotals) -> WithDerivatives;

    /// A quantity that must be zero, of the order of one for strokes that are far from it.
    fn condition(&self, totals: &StrokeTotals) -> Option<WithDerivatives> {
        None
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

/// Which displacement counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DisplacementMeasure {
    /// Its length.
    Length,
    /// Its component along a unit vector.
    Along(Vector3<f64>),
}

impl DisplacementMeasure {
    /// The displacement that counts.
    pub fn of(&self, totals: &StrokeTotals) -> WithDerivatives {
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

/// A quantity and derivatives, multiplied by the derivative of a function of it.
fn scaled(value: f64, slope: f64, derivatives: StrokeTotals) -> WithDerivatives {
    let derivatives = StrokeTotals {
        displacement: slope * derivatives.displacement,
        rotation: slope * derivatives.rotation,
        energy: slope * derivatives.energy,
    };
    (value, derivatives)
}

const ENERGY: StrokeTotals = StrokeTotals {
    displacement: Vector3::new(0.0, 0.0, 0.0),
    rotation: Vector3::new(0.0, 0.0, 0.0),
    energy: 1.0,
};

/// The logarithm of the energy: steps then do not depend on its size.
fn log_energy(totals: &StrokeTotals) -> WithDerivatives {
    scaled(totals.energy.ln(), 1.0 / totals.energy, ENERGY)
}

impl Objective for HighestEfficiency {
    fn cost(&self, totals: &StrokeTotals) -> WithDerivatives {
        let (energy, mut derivatives) = log_energy(totals);
        let (displacement, direction) = self.measure.of(totals);
        derivatives.displacement = -2.0 / displacement * direction.displacement;
        (energy - 2.0 * displacement.ln(), derivatives)
    }

    fn direction(&self) -> Option<Vector3<f64>> {
        self.measure.direction()
    }
}

impl Objective for LeastEnergy {
    fn cost(&self, totals: &StrokeTotals) -> WithDerivatives {
        log_energy(totals)
    }

    fn condition(&self, totals: &StrokeTotals) -> Option<WithDerivatives> {
        let (displacement, derivatives) = self.measure.of(totals);
        let ratio = displacement / self.displacement;
        Some(scaled(ratio - 1.0, 1.0 / self.displacement, derivatives))
    }

    fn direction(&self) -> Option<Vector3<f64>> {
        self.measure.direction()
    }

    fn size(&self) -> Option<f64> {
        Some(self.displacement)
    }
}

impl Objective for LeastEnergyRotation {
    fn cost(&self, totals: &StrokeTotals) -> WithDerivatives {
        log_energy(totals)
    }

    fn condition(&self, totals: &StrokeTotals) -> Option<WithDerivatives> {
        let derivatives = StrokeTotals {
            rotation: self.axis,
            ..StrokeTotals::default()
        };
        let ratio = totals.rotation.dot(&self.axis) / self.angle;
        Some(scaled(ratio - 1.0, 1.0 / self.angle, derivatives))
    }

    fn axis(&self) -> Option<Vector3<f64>> {
        Some(self.axis * self.angle.signum())
    }

    fn size(&self) -> Option<f64> {
        Some(self.angle.abs())
    }
}
