//! Gauss quadrature of three points, and the integrals inside an interval that attitudes need.

use nalgebra::{UnitQuaternion, Vector3};

use swimmer::{Gauss, lagrange};

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
        let gauss = Gauss::new(POINTS);
        let nodes = [0, 1, 2].map(|i| gauss.nodes[i]);
        let inner = |end: f64| {
            let integrals = gauss.integrals(&nodes, end);
            [0, 1, 2].map(|i| integrals[i])
        };
        // The integrand has degree 5, for which the rule itself is exact.
        let double = |end: f64| {
            let mut double = [[0.0; POINTS]; POINTS];
            for (node, weight) in nodes.iter().zip(&gauss.weights) {
                let integrals = inner(end * node);
                for (i, row) in double.iter_mut().enumerate() {
                    let value = end * weight * lagrange(&nodes, i, end * node);
                    (row.iter_mut().zip(&integrals)).for_each(|(sum, l)| *sum += value * l);
                }
            }
            double
        };
        let ends = [nodes[0], nodes[1], nodes[2], 1.0];
        Self {
            nodes,
            weights: [0, 1, 2].map(|i| gauss.weights[i]),
            inner: ends.map(inner),
            double: ends.map(double),
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
