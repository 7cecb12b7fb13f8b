//! Gauss quadrature of three points, and the integrals inside an interval that attitudes need.

use nalgebra::{UnitQuaternion, Vector3};

/// Number of points per interval.
pub const POINTS: usize = 3;

/// Rule of order six on intervals of width one.
pub struct GaussRule {
    /// Positions of the points in the interval.
    pub nodes: [f64; POINTS],
    /// Weights of the points.
    pub weights: [f64; POINTS],
    /// Integrals of the Lagrange polynomial `j` from 0 to node `k` (to 1 in the last row).
    pub inner: [[f64; POINTS]; POINTS + 1],
    /// Double integrals `∫_0^{c_k} l_i(t) ∫_0^t l_j(r) dr dt`, with `c_k = 1` in the last row.
    double: [[[f64; POINTS]; POINTS]; POINTS + 1],
}

impl GaussRule {
    /// The rule.
    pub fn new() -> Self {
        let offset = 15_f64.sqrt() / 10.0;
        let nodes = [0.5 - offset, 0.5, 0.5 + offset];
        let ends = [nodes[0], nodes[1], nodes[2], 1.0];
        let basis = [0, 1, 2].map(|i| lagrange(&nodes, i));
        let mut inner = [[0.0; POINTS]; POINTS + 1];
        let mut double = [[[0.0; POINTS]; POINTS]; POINTS + 1];
        for (k, &end) in ends.iter().enumerate() {
            for i in 0..POINTS {
                inner[k][i] = value(&integral(&basis[i]), end);
                for j in 0..POINTS {
                    let product = product(&basis[i], &integral(&basis[j]));
                    double[k][i][j] = value(&integral(&product), end);
                }
            }
        }
        Self {
            nodes,
            weights: [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0],
            inner,
            double,
        }
    }

    /// Rotation from the start of an interval to its point `k`, or to its end for `k = 3`.
    ///
    /// `spins` are the angular velocities at the points, in the rotating frame, times the width of
    /// the interval. Magnus expansion to second order: exact for a constant axis.
    pub fn rotation(&self, spins: &[Vector3<f64>; POINTS], k: usize) -> UnitQuaternion<f64> {
        let mut vector = Vector3::zeros();
        for i in 0..POINTS {
            vector += self.inner[k][i] * spins[i];
            for j in 0..POINTS {
                // The frame rotates with the body, hence the sign.
                vector -= 0.5 * self.double[k][i][j] * spins[i].cross(&spins[j]);
            }
        }
        UnitQuaternion::from_scaled_axis(vector)
    }
}

/// Coefficients of a Lagrange polynomial, constant first.
fn lagrange(nodes: &[f64; POINTS], i: usize) -> Vec<f64> {
    (0..POINTS).filter(|&j| j != i).fold(vec![1.0], |p, j| {
        let scale = 1.0 / (nodes[i] - nodes[j]);
        product(&p, &[-nodes[j] * scale, scale])
    })
}

fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            product[i + j] += x * y;
        }
    }
    product
}

/// The integral from zero.
fn integral(p: &[f64]) -> Vec<f64> {
    let terms = p.iter().enumerate().map(|(k, c)| c / (k + 1) as f64);
    std::iter::once(0.0).chain(terms).collect()
}

fn value(p: &[f64], x: f64) -> f64 {
    p.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_about_a_turning_axis_converge_with_the_fourth_order() {
        let rule = GaussRule::new();
        let spin = |t: f64| Vector3::new(t.cos(), (2.0 * t).sin(), 0.3 + t);
        let end = |intervals: usize| {
            let width = 1.0 / intervals as f64;
            (0..intervals).fold(UnitQuaternion::identity(), |q, number| {
                let at = |k: usize| width * spin(width * (number as f64 + rule.nodes[k]));
                q * rule.rotation(&[at(0), at(1), at(2)], POINTS)
            })
        };
        let exact = end(256);
        let [coarse, fine] = [8, 16].map(|n| end(n).angle_to(&exact));
        assert!(
            (14.0..18.0).contains(&(coarse / fine)),
            "{coarse:e} {fine:e}"
        );
    }
}
