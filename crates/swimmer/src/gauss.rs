//! Gauss-Legendre points on [0, 1] and the polynomials through them.

/// A Gauss-Legendre quadrature rule on [0, 1].
#[derive(Clone, Debug)]
pub struct Gauss {
    /// Points of the rule, increasing.
    pub nodes: Vec<f64>,
    /// Weights of the points; their sum is one.
    pub weights: Vec<f64>,
}

impl Gauss {
    /// The rule of `n` points, exact for polynomials up to degree `2n - 1`.
    ///
    /// Newton's method on the Legendre polynomial from Tricomi's starting values; accurate to
    /// rounding for the few points that a phase takes.
    pub fn new(n: usize) -> Self {
        let (mut nodes, mut weights) = (vec![0.0; n], vec![0.0; n]);
        for i in 0..n {
            let mut x = -(std::f64::consts::PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            // Quadratic convergence from an error below 0.1 reaches rounding in five steps.
            for _ in 0..8 {
                let (value, derivative) = legendre(n, x);
                slope = derivative;
                x -= value / derivative;
            }
            nodes[i] = 0.5 * (1.0 + x);
            weights[i] = 1.0 / ((1.0 - x * x) * slope * slope);
        }
        Self { nodes, weights }
    }

    /// The integrals from 0 to `s` of the Lagrange polynomials of `nodes`, exact to rounding.
    ///
    /// The rule integrates them exactly, because their degree is one below its number of points.
    pub fn integrals(&self, nodes: &[f64], s: f64) -> Vec<f64> {
        let integral = |i: usize| -> f64 {
            self.nodes
                .iter()
                .zip(&self.weights)
                .map(|(c, w)| s * w * lagrange(nodes, i, s * c))
                .sum()
        };
        (0..nodes.len()).map(integral).collect()
    }
}

/// The Lagrange polynomial at `x` that is one at `nodes[i]` and zero at the other nodes.
pub fn lagrange(nodes: &[f64], i: usize, x: f64) -> f64 {
    let others = nodes.iter().enumerate().filter(|&(j, _)| j != i);
    others
        .map(|(_, node)| (x - node) / (nodes[i] - node))
        .product()
}

/// Bernstein coefficients on [0, 1] of the Lagrange polynomials of `nodes`, one list for each node.
///
/// The values of a polynomial are convex combinations of its Bernstein coefficients, which
/// therefore bound it; times the degree, the differences of successive coefficients are those of
/// its derivative (Farouki 2012).
pub fn bernstein(nodes: &[f64]) -> Vec<Vec<f64>> {
    let of_node = |i: usize| {
        let others = nodes.iter().enumerate().filter(|&(j, _)| j != i);
        others.fold(vec![1.0], |product: Vec<f64>, (_, node)| {
            // Times the linear factor with the values a and b at the ends of [0, 1].
            let [a, b] = [-node, 1.0 - node].map(|x| x / (nodes[i] - node));
            let degree = product.len();
            let at = |k: usize| product.get(k).copied().unwrap_or(0.0);
            let coefficient = |k: usize| {
                let low = (degree - k) as f64 * at(k) * a;
                let high = if k > 0 { k as f64 * at(k - 1) * b } else { 0.0 };
                (low + high) / degree as f64
            };
            (0..=degree).map(coefficient).collect()
        })
    };
    (0..nodes.len()).map(of_node).collect()
}

/// Value and derivative of the Legendre polynomial of degree `n` at `x` inside (-1, 1).
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut previous, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        (previous, value) = (
            value,
            ((2.0 * k - 1.0) * x * value - (k - 1.0) * previous) / k,
        );
    }
    (value, n as f64 * (x * value - previous) / (x * x - 1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;

    #[test]
    fn a_rule_of_n_points_is_exact_to_degree_2n_minus_1_only() {
        for n in 1..=10 {
            let gauss = Gauss::new(n);
            let moment = |k: i32| -> f64 {
                gauss
                    .nodes
                    .iter()
                    .zip(&gauss.weights)
                    .map(|(x, w)| w * x.powi(k))
                    .sum()
            };
            for degree in 0..2 * n as i32 {
                assert_abs_diff_eq!(moment(degree), 1.0 / f64::from(degree + 1), epsilon = 1e-14);
            }
            assert!((moment(2 * n as i32) - 1.0 / (2 * n + 1) as f64).abs() > 1e-14);
        }
    }

    #[test]
    fn bernstein_coefficients_give_the_polynomials_and_their_derivatives() {
        let nodes = Gauss::new(5).nodes;
        // De Casteljau's algorithm.
        let value = |coefficients: &[f64], t: f64| {
            let mut row = coefficients.to_vec();
            while row.len() > 1 {
                row = row.windows(2).map(|w| w[0] + t * (w[1] - w[0])).collect();
            }
            row[0]
        };
        for (i, coefficients) in bernstein(&nodes).iter().enumerate() {
            let slopes: Vec<f64> = coefficients
                .windows(2)
                .map(|w| 4.0 * (w[1] - w[0]))
                .collect();
            for t in [0.0, 0.2, 0.9, 1.0] {
                let exact = lagrange(&nodes, i, t);
                assert_abs_diff_eq!(value(coefficients, t), exact, epsilon = 1e-13);
                // Central difference: error d^2 and rounding 1e-15 / d, times derivatives to 1e4.
                let d = 1e-5;
                let [before, after] = [t - d, t + d].map(|t| lagrange(&nodes, i, t));
                let slope = (after - before) / (2.0 * d);
                assert_abs_diff_eq!(value(&slopes, t), slope, epsilon = 1e-6);
            }
        }
    }

    #[test]
    fn integrals_of_lagrange_polynomials_reproduce_integrals_of_powers() {
        let gauss = Gauss::new(4);
        let nodes = gauss.nodes.clone();
        for s in [0.0, 0.3, 1.0] {
            let integrals = gauss.integrals(&nodes, s);
            let cubic: f64 = nodes
                .iter()
                .zip(&integrals)
                .map(|(x, l)| l * x.powi(3))
                .sum();
            assert_abs_diff_eq!(cubic, s.powi(4) / 4.0, epsilon = 1e-15);
        }
    }
}
