//! How many multipoles a gap needs.
//!
//! The flow that a neighbour reflects has its nearest singularity at the inner focus of the pair's bispherical coordinates, at
//! $a e^{\xi}$ from the centre: the coefficients of degree $l$ fall as $e^{-\xi l}$, and the Galerkin error of the resistance as $e^{-2 \xi L}$.

use super::modes::Modes;
use crate::{Medium, Spheres};

/// Orders of the expansions on each sphere, and on the container if there is one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Orders {
    /// One a sphere.
    pub spheres: Vec<usize>,
    /// That of the container's wall; zero without one.
    pub container: usize,
}

impl Orders {
    /// Number of multipoles of all expansions.
    pub fn dofs(&self) -> usize {
        let orders = self.spheres.iter().copied().chain(Some(self.container));
        orders.map(|order| Modes { order }.len()).sum()
    }

    /// The same orders, but none above these.
    pub(crate) fn cut(&self, spheres: usize, container: usize) -> Self {
        Self {
            spheres: self.spheres.iter().map(|&l| l.min(spheres)).collect(),
            container: self.container.min(container),
        }
    }

    /// The same order everywhere, at least 2.
    pub fn all(spheres: usize, medium: &Medium, order: usize) -> Self {
        let order = order.max(least(medium));
        Self {
            spheres: vec![order; spheres],
            container: match medium {
                Medium::Ball { .. } => order,
                _ => 0,
            },
        }
    }
}

/// The first order beyond rigid motions: the stresslet and its kin. Two less is then Rotne, Prager & Yamakawa's mobility.
pub(crate) const LEAST: usize = 2;

/// A container and a sphere reflect with their first source modes already, even when concentric; two less must not be without.
const LEAST_IN_A_BALL: usize = 4;

/// The least order in a medium.
fn least(medium: &Medium) -> usize {
    match medium {
        Medium::Ball { .. } => LEAST_IN_A_BALL,
        _ => LEAST,
    }
}

/// Smallest bispherical coordinate of each sphere with its neighbours and the boundary, then that of the container.
pub(crate) fn closeness(spheres: &Spheres, medium: &Medium) -> (Vec<f64>, f64) {
    let n = spheres.len();
    let mut xi = vec![f64::INFINITY; n];
    let mut container = f64::INFINITY;
    for j in 0..n {
        let (x, a) = (spheres.centres()[j], spheres.radii()[j]);
        for i in 0..j {
            let pair = outside((x - spheres.centres()[i]).norm(), spheres.radii()[i], a);
            xi[i] = xi[i].min(pair.0);
            xi[j] = xi[j].min(pair.1);
        }
        match medium {
            Medium::Unbounded => {}
            Medium::Ball { centre, radius } => {
                let pair = inside((x - centre).norm(), a, *radius);
                xi[j] = xi[j].min(pair.0);
                container = container.min(pair.1);
            }
            Medium::Wall { .. } => xi[j] = xi[j].min(acosh_1p((medium.distance(&x) - a) / a)),
        }
    }
    (xi, container)
}

/// The order for a bispherical coordinate at which $e^{-2 \xi L}$ is the tolerance, times $\xi^2$ in narrow gaps, where the
/// resistance grows as the inverse of that.
fn terms(xi: f64, tolerance: f64) -> usize {
    let terms = -(tolerance * xi.min(1.0).powi(2)).ln() / (2.0 * xi);
    // beyond any use; a cast of what is larger would be the largest integer
    LEAST.max(terms.min(1e6).ceil() as usize + 1)
}

/// Orders that two spheres at a distance need of each other.
pub(crate) fn of_pair(distance: f64, a: f64, b: f64, tolerance: f64) -> (usize, usize) {
    let (first, second) = outside(distance, a, b);
    (terms(first, tolerance), terms(second, tolerance))
}

/// What to aim at first for the estimate to come out below `tolerance`.
///
/// [`terms`] is right for narrow gaps. Spheres apart feel of each other's reflections what is left of them on the way back and forth:
/// estimates were about $n e^{-4\xi}$ times the goal for `n` spheres; a third is left as margin.
pub(crate) fn first_goal(closeness: &(Vec<f64>, f64), spheres: usize, tolerance: f64) -> f64 {
    let reflected = spheres as f64 * (-4.0 * narrowest(closeness)).exp();
    tolerance * (0.3 / reflected).clamp(1.0, (1.0 / tolerance).max(1.0))
}

/// Orders at which the resistance errs by about `tolerance`.
pub(crate) fn for_tolerance(
    closeness: &(Vec<f64>, f64),
    medium: &Medium,
    tolerance: f64,
) -> Orders {
    let order = |xi: f64| terms(xi, tolerance).max(least(medium));
    Orders {
        spheres: closeness.0.iter().map(|&xi| order(xi)).collect(),
        container: match medium {
            Medium::Ball { .. } => order(closeness.1),
            _ => 0,
        },
    }
}

/// What a change from order `n - 2` to `n` says about the error of order `n`: the error is at most the change times this.
///
/// The largest of all expansions: each adds to the change what it adds to the dissipation, and that part tells what it still misses.
pub(crate) fn tail(closeness: &(Vec<f64>, f64), orders: &Orders) -> f64 {
    let lowest = match orders.container {
        0 => LEAST,
        _ => LEAST_IN_A_BALL,
    };
    let spheres = closeness.0.iter().zip(&orders.spheres);
    spheres
        .chain(Some((&closeness.1, &orders.container)))
        .filter(|(_, order)| **order > 0)
        .map(|(&xi, &order)| tail_of_one(xi, order, lowest))
        .fold(0.0, f64::max)
}

/// [`tail`] of one expansion.
///
/// A geometric series with ratio $e^{-4\xi}$, and $((n+2)/n)^2$ for the powers of the order that stand beside the exponential.
/// Three times that: many spheres reflect more than a pair does. The true error was 0.2 to 0.8 of the estimate for pairs, chains
/// and spheres near walls and in containers, at orders 2 to 10 and errors from 0.3 to 1e-13.
fn tail_of_one(xi: f64, order: usize, lowest: usize) -> f64 {
    let (n, ratio) = (order as f64, (-4.0 * xi).exp());
    let general = 3.0 * ((n + 2.0) / n).powi(2) * ratio / (1.0 - ratio);
    if order > lowest {
        return general;
    }
    // two less than the least order lacks the first reflections: the change is that of one degree, and the next is $e^{-2\xi}$ of it
    let step = ratio.sqrt();
    general.max(3.0 * step / (1.0 - step))
}

/// The smallest bispherical coordinate.
pub(crate) fn narrowest(closeness: &(Vec<f64>, f64)) -> f64 {
    closeness.0.iter().fold(closeness.1, |m, &xi| m.min(xi))
}

/// Bispherical coordinates of two spheres that exclude each other: $\xi$ of each.
fn outside(distance: f64, a: f64, b: f64) -> (f64, f64) {
    // cosh(xi) - 1 as a product, exact in narrow gaps
    let gap = distance - a - b;
    let excess = |own: f64, other: f64| gap * (gap + 2.0 * other) / (2.0 * own * distance);
    (acosh_1p(excess(a, b)), acosh_1p(excess(b, a)))
}

/// $\xi$ of a sphere of radius `a` at `offset` from the centre of a container of radius `b`, and of the container;
/// infinite for a concentric sphere, which one degree describes.
fn inside(offset: f64, a: f64, b: f64) -> (f64, f64) {
    let gap = b - a - offset;
    (
        acosh_1p(gap * (b + a + offset) / (2.0 * a * offset)),
        acosh_1p(gap * (b + a - offset) / (2.0 * b * offset)),
    )
}

/// $\mathrm{acosh}(1 + x)$ without loss for small `x`.
fn acosh_1p(x: f64) -> f64 {
    (x + (x * (x + 2.0)).sqrt()).ln_1p()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_of_equal_spheres_are_those_of_the_text_books() {
        let (a, b) = outside(3.0, 1.0, 1.0);
        assert!((a - 1.5_f64.acosh()).abs() < 1e-14 && a == b);
        // a huge sphere is a wall
        let (near, _) = outside(1e9 + 2.0, 1.0, 1e9);
        assert!((near - 2.0_f64.acosh()).abs() < 1e-6);
        let (within, _) = inside(1e9 - 2.0, 1.0, 1e9);
        assert!((within - 2.0_f64.acosh()).abs() < 1e-6);
    }
}
