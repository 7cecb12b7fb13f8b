//! Order of the expansions that a gap needs, and the error estimate of an order.
//!
//! With the bispherical coordinate `ξ` of a sphere of radius `a`, the flow reflected by its
//! neighbour has its nearest singularity at the focus inside the neighbour, at distance `a e^ξ`
//! from the centre of the sphere. The coefficients of degree `l` therefore decay as `e^(-ξ l)`,
//! and the Galerkin error of the resistance as `e^(-2 ξ L)` with the order `L`.

use std::collections::BTreeMap;

use super::orders::{GapOrders, MIN_ORDER, MIN_ORDER_IN_BALL, Orders, min_order};
use crate::{Medium, Spheres};

/// Highest order off an axis, outside narrow gaps.
pub(super) const MAX_ORDER_OFF_AXIS: usize = 28;

/// Highest order of the container off an axis.
pub(super) const MAX_ORDER_ON_CONTAINER: usize = 2 * MAX_ORDER_OFF_AXIS;

/// Smallest bispherical coordinate of each sphere and of the container over all their gaps.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GapCoordinates {
    /// Coordinate of each sphere.
    pub spheres: Vec<f64>,
    /// Coordinate of the container; infinite without one.
    pub container: f64,
}

/// Gap between two spheres, or between a sphere and the boundary.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    /// Indices of the spheres; the second is the number of spheres for the boundary.
    pub pair: (usize, usize),
    /// Bispherical coordinates of both surfaces; infinite for a wall.
    pub xi: [f64; 2],
}

impl Gap {
    /// The gap of two spheres, or of a sphere and an image, with the distance of their centres.
    pub fn between(spheres: &Spheres, pair: (usize, usize), distance: f64) -> Self {
        let [a, b] = [pair.0, pair.1].map(|sphere| spheres.radii()[sphere]);
        Self {
            pair,
            xi: outside(distance, a, b).into(),
        }
    }
}

/// All gaps of an arrangement.
pub(crate) fn gaps(spheres: &Spheres, medium: &Medium) -> Vec<Gap> {
    let n = spheres.len();
    let mut gaps = Vec::with_capacity(n * (n + 1) / 2);
    for j in 0..n {
        let (x, a) = (spheres.centres()[j], spheres.radii()[j]);
        for i in 0..j {
            let distance = (x - spheres.centres()[i]).norm();
            gaps.push(Gap::between(spheres, (i, j), distance));
        }
        let (first, second) = match medium {
            Medium::Unbounded => continue,
            Medium::Ball { centre, radius } => inside((x - centre).norm(), a, *radius),
            Medium::Wall { .. } => (acosh_1p((medium.distance(&x) - a) / a), f64::INFINITY),
        };
        gaps.push(Gap {
            pair: (j, n),
            xi: [first, second],
        });
    }
    gaps
}

/// Smallest bispherical coordinate of the container; infinite without one.
pub(crate) fn container_coordinate(spheres: &Spheres, medium: &Medium) -> f64 {
    let Medium::Ball { centre, radius } = medium else {
        return f64::INFINITY;
    };
    let all = spheres.centres().iter().zip(spheres.radii());
    all.map(|(x, &a)| inside((x - centre).norm(), a, *radius).1)
        .fold(f64::INFINITY, f64::min)
}

impl GapCoordinates {
    /// Smallest coordinates over all gaps, of `spheres` spheres and the container.
    pub fn narrowest_of(gaps: &[Gap], spheres: usize) -> Self {
        let mut all = vec![f64::INFINITY; spheres + 1];
        for Gap { pair, xi } in gaps {
            all[pair.0] = all[pair.0].min(xi[0]);
            all[pair.1] = all[pair.1].min(xi[1]);
        }
        let container = all.pop().unwrap_or(f64::INFINITY);
        Self {
            spheres: all,
            container,
        }
    }

    /// The same coordinates, with gaps widened to those that the expansions of the spheres resolve
    /// outside the narrow gaps.
    pub fn widened(&self) -> Self {
        Self {
            spheres: self.spheres.iter().map(|xi| xi.max(MIN_WIDE_GAP)).collect(),
            container: self.container,
        }
    }
}

/// Order that a bispherical coordinate needs for a relative error of the resistance.
///
/// The order `L` at which `e^(-2 ξ L)` equals `tolerance · min(ξ, 1)²`: in narrow gaps the
/// resistance grows as `1/ξ²`.
fn order_for(xi: f64, tolerance: f64) -> usize {
    order_of_decay(xi, tolerance * xi.min(1.0).powi(2))
}

/// The order `L` at which `e^(-2 ξ L)` equals `tolerance`.
pub(super) fn order_of_decay(xi: f64, tolerance: f64) -> usize {
    let terms = -tolerance.ln() / (2.0 * xi);
    // An order beyond any use; larger values would saturate the cast to an integer.
    MIN_ORDER.max(terms.min(1e6).ceil() as usize + 1)
}

/// Relative error of the resistance at given orders: the inverse of the function that chooses
/// orders, for the expansion with the largest error.
pub(crate) fn error(xi: &GapCoordinates, orders: &Orders) -> f64 {
    let spheres = xi.spheres.iter().zip(&orders.spheres);
    spheres
        .chain(Some((&xi.container, &orders.container)))
        .filter(|(_, order)| **order > 0)
        .map(|(&xi, &order)| (-2.0 * xi * (order as f64 - 1.0)).exp() / xi.min(1.0).powi(2))
        .fold(0.0, f64::max)
}

/// Orders at which two spheres at a distance represent their interaction to a tolerance.
pub(crate) fn for_pair(distance: f64, a: f64, b: f64, tolerance: f64) -> (usize, usize) {
    let (first, second) = outside(distance, a, b);
    (order_for(first, tolerance), order_for(second, tolerance))
}

/// Relative errors of the couplings of many spheres.
#[derive(Clone, Copy)]
pub(super) struct Neglected {
    /// Of pairs of spheres.
    pub of_spheres: f64,
    /// Of the truncated expansions of cells.
    pub of_cells: f64,
}

/// Part of the tolerance below which couplings of pairs are neglected.
const NEGLECTED: f64 = 1e-2;

/// Factor on the tolerance of the truncation of cells.
///
/// Errors of velocities were 0.01 to 0.06 of the truncation among 343 free spheres in a cube at
/// gaps of 0.1 to 4, errors of forces 0.02 to 2 of it among 216 that are held, whose changes by
/// [`MORE_TRUNCATED`] were 10 to 60 times as large.
const TRUNCATED: f64 = 3.0;

/// Factor on the tolerance of couplings from which their error is estimated.
///
/// The change is then larger than what is neglected. Couplings of orders below those of their
/// spheres lose at least one degree.
const MORE_NEGLECTED: f64 = 30.0;

/// The same of the truncation of cells.
const MORE_TRUNCATED: f64 = 10.0;

impl Neglected {
    /// For the gaps and the tolerance of an arrangement.
    ///
    /// The lowest eigenvalue falls with the narrowest gap. Distant cells hardly drive the soft
    /// flows in gaps, so that a lower power suffices for them.
    pub fn of(xi: &GapCoordinates, tolerance: f64) -> Self {
        let xi = narrowest(xi).min(1.0);
        Self {
            of_spheres: NEGLECTED * tolerance * xi.powi(3),
            of_cells: TRUNCATED * tolerance * xi,
        }
    }

    /// What is neglected to estimate the error.
    pub fn more(self) -> Self {
        Self {
            of_spheres: MORE_NEGLECTED * self.of_spheres,
            of_cells: MORE_TRUNCATED * self.of_cells,
        }
    }
}

/// Tolerance for the first choice of orders, such that the error estimate comes out below
/// `tolerance`.
///
/// [`order_for`] is accurate for narrow gaps. Between distant spheres the flow decays on the way to
/// the neighbour and back, which [`order_for`] ignores: with `n` spheres the error estimates were
/// about `n e^(-4ξ)` times the tolerance given to [`order_for`]. A factor of three is left as
/// margin.
pub(crate) fn first_target(xi: &GapCoordinates, spheres: usize, tolerance: f64) -> f64 {
    let reflected = spheres as f64 * (-4.0 * narrowest(xi)).exp();
    tolerance * (0.3 / reflected).clamp(1.0, (1.0 / tolerance).max(1.0))
}

/// Coordinate of the narrowest gap that the expansions of the spheres resolve by themselves.
///
/// A gap of a quarter of a radius between equal spheres. In narrower gaps the high degrees of both
/// spheres are eliminated for the pair alone.
pub(crate) const MIN_WIDE_GAP: f64 = 0.5;

/// Targets of the relative error of the resistance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Targets {
    /// Error due to the expansions of the spheres.
    pub expansions: f64,
    /// Error due to the expansions in narrow gaps.
    pub gaps: f64,
}

/// Orders at which the relative error of the resistance is about that of the targets.
///
/// Outside narrow gaps the orders of the spheres are at most `highest`, which is at least the
/// lowest order of the medium.
pub(crate) fn for_targets(
    gaps: &[Gap],
    spheres: usize,
    medium: &Medium,
    targets: Targets,
    highest: usize,
) -> Orders {
    let xi = GapCoordinates::narrowest_of(gaps, spheres);
    let own = for_tolerance(&xi.widened(), medium, targets.expansions);
    let mut orders = own.limited(highest.max(min_order(medium)), MAX_ORDER_ON_CONTAINER);
    let order = |index: usize| orders.of_expansion(index);
    let surfaces = |gap: &Gap, order: &dyn Fn(f64) -> usize| {
        gap.xi.map(|xi| if xi.is_finite() { order(xi) } else { 0 })
    };
    let narrow = |gap: &Gap| {
        let singular = surfaces(gap, &|xi| order_for(xi, targets.gaps));
        let (first, second) = gap.pair;
        let beyond = singular[0] > order(first) || singular[1] > order(second);
        beyond.then(|| {
            let regular = surfaces(gap, &|xi| order_of_decay(xi, targets.gaps));
            (gap.pair, GapOrders { singular, regular })
        })
    };
    orders.gaps = gaps.iter().filter_map(narrow).collect();
    orders
}

/// Orders at which the relative error of the resistance is about `tolerance`, without treating
/// narrow gaps apart.
pub(crate) fn for_tolerance(xi: &GapCoordinates, medium: &Medium, tolerance: f64) -> Orders {
    let order = |xi: f64| order_for(xi, tolerance).max(min_order(medium));
    Orders {
        spheres: xi.spheres.iter().map(|&xi| order(xi)).collect(),
        container: match medium {
            Medium::Ball { .. } => order(xi.container),
            _ => 0,
        },
        gaps: BTreeMap::new(),
        off_axis: false,
    }
}

/// Factor of the error estimate: error of order `n` over the change from order `n - 2` to `n`.
///
/// The largest factor of all expansions. Each expansion contributes to the change its own part of
/// the dissipation, and that part determines its remaining error.
pub(crate) fn tail(xi: &GapCoordinates, orders: &Orders) -> f64 {
    let lowest = match orders.container {
        0 => MIN_ORDER,
        _ => MIN_ORDER_IN_BALL,
    };
    let spheres = xi.spheres.iter().zip(&orders.spheres);
    spheres
        .chain(Some((&xi.container, &orders.container)))
        .filter(|(_, order)| **order > 0)
        .map(|(&xi, &order)| tail_of_one(xi, order, lowest))
        .fold(0.0, f64::max)
}

/// [`tail`] of each of many spheres, whose orders are above the lowest one.
pub(super) fn tails_of_spheres(xi: &[f64], orders: &[usize]) -> Vec<f64> {
    let spheres = xi.iter().zip(orders);
    spheres
        .map(|(&xi, &order)| tail_of_one(xi, order, MIN_ORDER))
        .collect()
}

/// [`tail`] of one expansion.
///
/// The tail of a geometric series with ratio `e^(-4ξ)`, times `((n+2)/n)²` for the powers of the
/// order that multiply the exponential, times a safety factor of three, because many spheres
/// reflect more than a pair does. The true error was 0.2 to 0.8 of the estimate for pairs, chains
/// and spheres near walls and in containers, at orders 2 to 10 and errors from 0.3 to 1e-13.
fn tail_of_one(xi: f64, order: usize, lowest: usize) -> f64 {
    let (n, ratio) = (order as f64, (-4.0 * xi).exp());
    let general = 3.0 * ((n + 2.0) / n).powi(2) * ratio / (1.0 - ratio);
    if order > lowest {
        return general;
    }
    // The expansion two orders below the lowest one has no reflections at all: the change is that
    // of one degree, and the next degree is smaller by e^(-2 xi).
    let step = ratio.sqrt();
    general.max(3.0 * step / (1.0 - step))
}

/// Smallest bispherical coordinate of all spheres and the container.
pub(crate) fn narrowest(xi: &GapCoordinates) -> f64 {
    xi.spheres.iter().fold(xi.container, |m, &xi| m.min(xi))
}

/// Bispherical coordinates of two spheres outside each other, with radii `a` and `b`.
pub(super) fn outside(distance: f64, a: f64, b: f64) -> (f64, f64) {
    // cosh(xi) - 1 as a product, which has no cancellation in narrow gaps
    let gap = distance - a - b;
    let excess = |own: f64, other: f64| gap * (gap + 2.0 * other) / (2.0 * own * distance);
    (acosh_1p(excess(a, b)), acosh_1p(excess(b, a)))
}

/// Bispherical coordinates of a sphere inside a container, and of the container.
///
/// The sphere has radius `a` and lies at distance `offset` from the centre of the container of
/// radius `b`. Infinite for concentric spheres, whose flow has a single degree.
fn inside(offset: f64, a: f64, b: f64) -> (f64, f64) {
    let gap = b - a - offset;
    (
        acosh_1p(gap * (b + a + offset) / (2.0 * a * offset)),
        acosh_1p(gap * (b + a - offset) / (2.0 * b * offset)),
    )
}

/// `acosh(1 + x)` without cancellation for small `x`.
fn acosh_1p(x: f64) -> f64 {
    (x + (x * (x + 2.0)).sqrt()).ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_of_equal_spheres_are_those_of_the_textbooks() {
        let (a, b) = outside(3.0, 1.0, 1.0);
        assert!((a - 1.5_f64.acosh()).abs() < 1e-14 && a == b);
        // a sphere of very large radius acts as a wall
        let (near, _) = outside(1e9 + 2.0, 1.0, 1e9);
        assert!((near - 2.0_f64.acosh()).abs() < 1e-6);
        let (within, _) = inside(1e9 - 2.0, 1.0, 1e9);
        assert!((within - 2.0_f64.acosh()).abs() < 1e-6);
    }

    #[test]
    fn both_surfaces_of_a_gap_have_the_same_foci() {
        // The distance of the foci from the plane between them is a sinh(xi) for each surface.
        for [(first, a), (second, b)] in [
            {
                let (first, second) = outside(4.0, 1.0, 2.5);
                [(first, 1.0), (second, 2.5)]
            },
            {
                let (first, second) = inside(1.3, 1.0, 4.0);
                [(first, 1.0), (second, 4.0)]
            },
        ] {
            assert!((a * first.sinh() / (b * second.sinh()) - 1.0).abs() < 1e-13);
        }
    }
}
