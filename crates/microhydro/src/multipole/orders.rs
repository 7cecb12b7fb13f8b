//! The requested accuracy, and the orders of all expansions of an arrangement, fixed or chosen for
//! a tolerance.

use std::collections::BTreeMap;

use super::modes::Modes;
use crate::{HydroError, Medium};

/// Requested accuracy of a multipole expansion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Accuracy {
    /// Relative error of the resistance: the order is raised until the estimate is below it.
    ///
    /// Between `1e-13`, below which rounding errors dominate, and 1.
    pub tolerance: f64,
    /// Fixed order of all expansions; `None` derives the orders from the gaps and the tolerance.
    pub order: Option<usize>,
}

/// Lowest relative error that can be requested.
const MIN_TOLERANCE: f64 = 1e-13;

impl Default for Accuracy {
    /// A tolerance of `1e-8`: convergence is spectral, so the last digits cost little.
    fn default() -> Self {
        Self::relative(1e-8)
    }
}

impl Accuracy {
    /// Checks the tolerance.
    ///
    /// # Errors
    /// [`HydroError::BadTolerance`].
    pub(super) fn check(&self) -> Result<(), HydroError> {
        // The comparison also rejects NaN.
        match (MIN_TOLERANCE..=1.0).contains(&self.tolerance) {
            true => Ok(()),
            false => Err(HydroError::BadTolerance {
                tolerance: self.tolerance,
                lowest: MIN_TOLERANCE,
            }),
        }
    }

    /// Accuracy given by a relative error of the resistance.
    pub fn relative(tolerance: f64) -> Self {
        Self {
            tolerance,
            order: None,
        }
    }

    /// Accuracy given by a fixed order of all expansions, at least 2; the tolerance does not apply.
    pub fn order(order: usize) -> Self {
        Self {
            tolerance: f64::INFINITY,
            order: Some(order),
        }
    }
}

/// Lowest order: rigid motions and stresslets.
///
/// Two orders lower is the Rotne-Prager-Yamakawa mobility.
pub(crate) const MIN_ORDER: usize = 2;

/// Lowest order of many spheres: that below it by two has the stresslets.
pub(super) const LOWEST_ORDER: usize = 4;

/// Lowest order in a ball.
///
/// A container and a sphere reflect each other's source modes even when concentric, and the
/// expansion that is two orders lower must contain these modes.
pub(crate) const MIN_ORDER_IN_BALL: usize = 4;

/// Lowest order in a medium.
pub(crate) fn min_order(medium: &Medium) -> usize {
    match medium {
        Medium::Ball { .. } => MIN_ORDER_IN_BALL,
        _ => MIN_ORDER,
    }
}

/// Highest number of multipoles with `m = 1` on an axis; their elimination takes about a second.
const MAX_AXIAL_DOFS: usize = 3000;

/// Orders of the two surfaces of a narrow gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct GapOrders {
    /// Orders for the azimuthal numbers 0 and 1 about the axis of the gap.
    ///
    /// The surfaces' own motions drive these flows, and they are singular in the width of the gap.
    pub singular: [usize; 2],
    /// Orders for higher azimuthal numbers, which only third bodies drive.
    pub regular: [usize; 2],
}

impl GapOrders {
    /// The higher orders of both.
    fn at_least(self, other: Self) -> Self {
        let higher = |a: [usize; 2], b: [usize; 2]| [a[0].max(b[0]), a[1].max(b[1])];
        Self {
            singular: higher(self.singular, other.singular),
            regular: higher(self.regular, other.regular),
        }
    }

    fn limited(self, most: usize) -> Self {
        Self {
            singular: self.singular.map(|order| order.min(most)),
            regular: self.regular.map(|order| order.min(most)),
        }
    }
}

/// Orders of the expansions on all spheres, on the container, and in the narrow gaps.
///
/// With fixed orders the resistance is a smooth function of the positions. Orders chosen for a
/// tolerance change with the gaps, and each change moves the resistance by an amount of the order
/// of the tolerance. Where a smooth function is needed, choose the orders once for all
/// configurations ([`super::orders_for`]) and use them in each one ([`super::resistance_at`]):
///
/// ```
/// use microhydro::{Medium, Spheres, multipole};
/// use nalgebra::Vector3;
/// let at = |arm: f64| {
///     let centres = vec![Vector3::zeros(), Vector3::x() * arm, Vector3::y() * 6.0];
///     Spheres::new(centres, vec![1.0; 3])
/// };
/// let ends = [at(6.0)?, at(3.0)?];
/// let orders = multipole::orders_for(&ends, &Medium::Unbounded, 1e-4)?;
/// let middle = multipole::resistance_at(&at(4.5)?, &Medium::Unbounded, &orders)?;
/// assert!(middle.relative_error() <= 1e-4);
/// # Ok::<(), microhydro::HydroError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Orders {
    /// Order of each sphere.
    pub(crate) spheres: Vec<usize>,
    /// Order of the container; zero without one.
    pub(crate) container: usize,
    /// Orders of the two surfaces of a narrow gap, where they exceed those above.
    ///
    /// The second index is the number of spheres for the boundary of the medium; a wall has the
    /// order zero.
    pub(crate) gaps: BTreeMap<(usize, usize), GapOrders>,
    /// Whether spheres on one axis are treated as spheres at any positions.
    ///
    /// Set if one of the configurations that gave the orders is not on an axis: on an axis, where
    /// the azimuthal numbers decouple, the expansions have the orders of the gaps throughout.
    pub(crate) off_axis: bool,
}

impl Orders {
    /// One order for all expansions, raised to the lowest order that the medium allows.
    pub(crate) fn all(spheres: usize, medium: &Medium, order: usize) -> Self {
        let order = order.max(min_order(medium));
        Self {
            spheres: vec![order; spheres],
            container: match medium {
                Medium::Ball { .. } => order,
                _ => 0,
            },
            gaps: BTreeMap::new(),
            off_axis: false,
        }
    }

    /// The higher of these orders and `other`, sphere by sphere and gap by gap.
    ///
    /// Spheres that only one of them has keep their order.
    #[must_use]
    pub fn at_least(&self, other: &Self) -> Self {
        let (long, short) = match self.spheres.len() >= other.spheres.len() {
            true => (self, other),
            false => (other, self),
        };
        let mut joined = long.clone();
        for (order, &other) in joined.spheres.iter_mut().zip(&short.spheres) {
            *order = (*order).max(other);
        }
        joined.container = long.container.max(short.container);
        joined.off_axis |= short.off_axis;
        for (&gap, orders) in &short.gaps {
            let joined = joined.gaps.entry(gap).or_insert(*orders);
            *joined = joined.at_least(*orders);
        }
        joined
    }

    /// Whether all spheres have the lowest order and there is no expansion of a container: the
    /// change to lower orders is that to the mobility of Rotne, Prager and Yamakawa.
    pub fn are_lowest(&self) -> bool {
        self.container == 0 && self.gaps.is_empty() && self.spheres.iter().all(|&l| l == MIN_ORDER)
    }

    /// Order of a sphere, or of the container for all other indices.
    pub(crate) fn of_expansion(&self, index: usize) -> usize {
        self.spheres.get(index).copied().unwrap_or(self.container)
    }

    /// Number of degrees of freedom: multipoles of all expansions outside the narrow gaps.
    pub fn dofs(&self) -> usize {
        let orders = self.spheres.iter().copied().chain(Some(self.container));
        orders.map(|order| Modes { order }.len()).sum()
    }

    /// Orders that represent the narrow gaps by the expansions themselves.
    pub(crate) fn without_gaps(&self) -> Self {
        self.with_gaps_in_expansions(|gap| gap.singular)
    }

    /// [`Orders::without_gaps`] with some of the orders of the gaps.
    pub(crate) fn with_gaps_in_expansions(&self, of: fn(&GapOrders) -> [usize; 2]) -> Self {
        let n = self.spheres.len();
        let mut orders = Self {
            gaps: BTreeMap::new(),
            ..self.clone()
        };
        for (&(first, second), gap) in &self.gaps {
            let [of_first, of_second] = of(gap);
            orders.spheres[first] = orders.spheres[first].max(of_first);
            let other = match second == n {
                true => &mut orders.container,
                false => &mut orders.spheres[second],
            };
            *other = (*other).max(of_second);
        }
        orders
    }

    /// Orders lower by two outside the narrow gaps, with at least the rigid motions.
    pub(crate) fn lowered(&self) -> Self {
        let lower = |order: usize| order.saturating_sub(2).max(order.min(1));
        Self {
            spheres: self.spheres.iter().copied().map(lower).collect(),
            container: lower(self.container),
            ..self.clone()
        }
    }

    /// Highest order of all.
    pub(crate) fn highest(&self) -> usize {
        let gaps = self.gaps.values().flat_map(|gap| &gap.singular);
        let all = self.spheres.iter().chain(gaps).copied();
        all.fold(self.container, usize::max)
    }

    /// These orders, with those of the narrow gaps limited to what [`MAX_AXIAL_DOFS`] allows.
    pub(crate) fn affordable(&self, on_axis: bool) -> Self {
        let mut orders = self.clone();
        if on_axis {
            let all = self.without_gaps();
            let highest = |order: &usize| {
                let limited = all.limited(*order, *order);
                3 * (limited.spheres.iter().sum::<usize>() + limited.container) <= MAX_AXIAL_DOFS
            };
            let most = (0..=all.highest()).rev().find(highest).unwrap_or_default();
            orders = orders.limited(most, most);
            for gap in orders.gaps.values_mut() {
                *gap = gap.limited(most);
            }
        } else {
            let most = MAX_AXIAL_DOFS / 6;
            for gap in orders.gaps.values_mut() {
                *gap = gap.limited(most);
            }
        }
        orders
    }

    /// These orders, limited by a highest order for spheres and one for the container.
    pub(crate) fn limited(&self, spheres: usize, container: usize) -> Self {
        Self {
            spheres: self.spheres.iter().map(|&l| l.min(spheres)).collect(),
            container: self.container.min(container),
            ..self.clone()
        }
    }
}
