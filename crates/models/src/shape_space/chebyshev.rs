//! Polynomial interpolation in several variables on tensor grids of Chebyshev points.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

/// Interpolating polynomial of a vector-valued function (Trefethen 2013, chapters 3 and 4).
///
/// ```text
/// p(x) = sum_k c_k prod_a T_{k_a}(x_a)
/// ```
///
/// with each variable `x_a` mapped to [-1, 1]. For functions that are analytic in a neighbourhood
/// of the box, the error and the coefficients decrease geometrically with the degree, so the last
/// coefficients estimate the error.
///
/// ```
/// use models::{Interpolant, chebyshev_node};
///
/// let values = (0..=4).map(|k| chebyshev_node((1.0, 3.0), 4, k).powi(4)).collect();
/// let found = Interpolant::new(vec![(1.0, 3.0)], vec![4], 1, values).evaluate(&[1.5]);
/// assert!((found[0] - 5.0625).abs() < 1e-13);
/// ```
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Interpolant {
    ranges: Vec<(f64, f64)>,
    degrees: Vec<usize>,
    /// Number of components of the function.
    width: usize,
    /// `width` numbers per grid index, with the index of the first variable running fastest.
    coefficients: Vec<f64>,
}

/// Chebyshev point number `index` of the `degree + 1` points on a range.
///
/// The points of a degree are among those of twice the degree.
pub fn chebyshev_node((from, to): (f64, f64), degree: usize, index: usize) -> f64 {
    // Measured from the nearer end, so that ends are exact and the grid is symmetric.
    let half = 0.5 * (to - from);
    if 2 * index <= degree {
        to - half * (1.0 - (PI * index as f64 / degree as f64).cos())
    } else {
        from + half * (1.0 - (PI * (degree - index) as f64 / degree as f64).cos())
    }
}

/// All grid indices, with the index of the first variable running fastest.
pub(super) fn indices(degrees: &[usize]) -> impl Iterator<Item = Vec<usize>> + use<> {
    let degrees = degrees.to_vec();
    let count = degrees.iter().map(|n| n + 1).product();
    (0..count).map(move |mut flat: usize| {
        degrees
            .iter()
            .map(|n| {
                let index = flat % (n + 1);
                flat /= n + 1;
                index
            })
            .collect()
    })
}

impl Interpolant {
    /// Interpolates `width` values per grid point, of which the index of the first variable runs
    /// fastest; the points are [`chebyshev_node`]s.
    ///
    /// Degrees are at least 1. Cost: the number of values times the degree.
    pub fn new(
        ranges: Vec<(f64, f64)>,
        degrees: Vec<usize>,
        width: usize,
        values: Vec<f64>,
    ) -> Self {
        let mut coefficients = values;
        let mut stride = width;
        for &n in &degrees {
            coefficients = transformed(&coefficients, n, stride);
            stride *= n + 1;
        }
        Self {
            ranges,
            degrees,
            width,
            coefficients,
        }
    }

    /// Values at a point, which should be in the box. Cost: one multiplication per coefficient.
    pub fn evaluate(&self, point: &[f64]) -> Vec<f64> {
        let basis: Vec<Vec<f64>> = self
            .ranges
            .iter()
            .zip(&self.degrees)
            .zip(point)
            .map(|((&(from, to), &n), &x)| chebyshev(n, (2.0 * x - from - to) / (to - from)))
            .collect();
        let mut values = vec![0.0; self.width];
        for (index, coefficients) in
            indices(&self.degrees).zip(self.coefficients.chunks(self.width))
        {
            let weight: f64 = index.iter().zip(&basis).map(|(&k, t)| t[k]).product();
            for (value, c) in values.iter_mut().zip(coefficients) {
                *value += weight * c;
            }
        }
        values
    }

    /// Values at a point and their derivatives with respect to each variable.
    ///
    /// The derivative of `T_k` is `k U_{k-1}`. Cost: two multiplications per coefficient.
    pub fn evaluate_with_derivatives(&self, point: &[f64]) -> (Vec<f64>, Vec<Vec<f64>>) {
        let mut values = self.coefficients.clone();
        let mut derivatives: Vec<Vec<f64>> = Vec::new();
        // The last variable has the largest stride: each sum leaves an array of one variable less.
        for variable in (0..self.degrees.len()).rev() {
            let ((from, to), n) = (self.ranges[variable], self.degrees[variable]);
            let scale = 2.0 / (to - from);
            let x = 0.5 * scale * (2.0 * point[variable] - from - to);
            let basis = chebyshev(n, x);
            let slopes: Vec<f64> = slopes(n, x).iter().map(|t| scale * t).collect();
            for derivative in &mut derivatives {
                *derivative = contracted(derivative, &basis);
            }
            derivatives.insert(0, contracted(&values, &slopes));
            values = contracted(&values, &basis);
        }
        (values, derivatives)
    }

    /// Number of grid points in each variable, less one.
    pub fn degrees(&self) -> &[usize] {
        &self.degrees
    }

    /// Smallest and largest value of each variable.
    pub fn ranges(&self) -> &[(f64, f64)] {
        &self.ranges
    }

    /// For each variable, the sum of the coefficients of its two highest degrees.
    ///
    /// Of the `width` numbers of a coefficient, the largest counts after multiplication by
    /// `weights`. Two degrees are needed because for odd and even functions one of them vanishes.
    /// The interpolation error is at most twice the sum of all coefficients of higher degrees. If
    /// these decrease by a factor of two or more per degree, it is smaller than this sum.
    pub fn tails(&self, weights: &[f64]) -> Vec<f64> {
        let mut tails = vec![0.0; self.degrees.len()];
        for (index, coefficients) in
            indices(&self.degrees).zip(self.coefficients.chunks(self.width))
        {
            let size = coefficients
                .iter()
                .zip(weights)
                .fold(0.0_f64, |m, (c, w)| m.max((c * w).abs()));
            for ((tail, &k), &n) in tails.iter_mut().zip(&index).zip(&self.degrees) {
                if k + 1 >= n {
                    *tail += size;
                }
            }
        }
        tails
    }
}

/// Chebyshev polynomials `T_0, ..., T_n` at `x`.
fn chebyshev(n: usize, x: f64) -> Vec<f64> {
    let mut values = vec![1.0, x];
    for k in 2..=n {
        values.push(2.0 * x * values[k - 1] - values[k - 2]);
    }
    values.truncate(n + 1);
    values
}

/// Derivatives of the Chebyshev polynomials `T_0, ..., T_n` at `x`.
fn slopes(n: usize, x: f64) -> Vec<f64> {
    // T_k' = k U_{k-1}, with the recurrence of T for the polynomials U of the second kind.
    let mut second = vec![0.0, 1.0];
    for k in 2..=n {
        second.push(2.0 * x * second[k - 1] - second[k - 2]);
    }
    (second.iter().take(n + 1).enumerate())
        .map(|(k, u)| k as f64 * u)
        .collect()
}

/// Sum over the last variable of an array, with one weight per index of it.
fn contracted(array: &[f64], weights: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; array.len() / weights.len()];
    for (slice, weight) in array.chunks_exact(sum.len()).zip(weights) {
        for (sum, value) in sum.iter_mut().zip(slice) {
            *sum += weight * value;
        }
    }
    sum
}

/// Coefficients in one variable from the values at its `n + 1` points.
///
/// ```text
/// c_k = (2/n) sum_j f_j cos(π j k / n)
/// ```
///
/// where the first and the last term of the sum are halved, and so are `c_0` and `c_n`.
fn transformed(values: &[f64], n: usize, stride: usize) -> Vec<f64> {
    let halved = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
    let mut result = vec![0.0; values.len()];
    for (lines, line) in values
        .chunks(stride * (n + 1))
        .zip(result.chunks_mut(stride * (n + 1)))
    {
        for k in 0..=n {
            for j in 0..=n {
                // The product is reduced first, so that cosines are accurate where they are 0 or 1.
                let angle = PI * ((j * k) % (2 * n)) as f64 / n as f64;
                let weight = 2.0 / n as f64 * halved(k) * halved(j) * angle.cos();
                for i in 0..stride {
                    line[k * stride + i] += weight * lines[j * stride + i];
                }
            }
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn interpolant(degrees: &[usize], f: impl Fn(f64, f64) -> f64) -> Interpolant {
        let ranges = vec![(1.0, 3.0), (-2.0, 0.5)];
        let values = indices(degrees)
            .flat_map(|i| {
                let x = chebyshev_node(ranges[0], degrees[0], i[0]);
                let y = chebyshev_node(ranges[1], degrees[1], i[1]);
                [f(x, y), 2.0 * f(x, y)]
            })
            .collect();
        Interpolant::new(ranges, degrees.to_vec(), 2, values)
    }

    #[test]
    fn polynomials_of_the_degree_are_exact() {
        let f = |x: f64, y: f64| x.powi(3) * y - 2.0 * x * y * y + 0.5;
        let p = interpolant(&[3, 2], f);
        for (x, y) in [(1.0, 0.5), (2.2, -1.3), (3.0, -2.0)] {
            let found = p.evaluate(&[x, y]);
            assert!((found[0] - f(x, y)).abs() < 1e-13);
            assert!((found[1] - 2.0 * f(x, y)).abs() < 1e-13);
            let (values, slopes) = p.evaluate_with_derivatives(&[x, y]);
            let exact = [3.0 * x * x * y - 2.0 * y * y, x.powi(3) - 4.0 * x * y];
            for (value, found) in values.iter().zip(&found) {
                assert!((value - found).abs() < 1e-13);
            }
            for (slope, exact) in slopes.iter().zip(exact) {
                assert!((slope[0] - exact).abs() < 1e-12);
                assert!((slope[1] - 2.0 * exact).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn tails_bound_the_error_and_fall_geometrically() {
        let f = |x: f64, y: f64| 1.0 / (x + 0.3) + (0.4 * y).exp();
        let mut last = f64::INFINITY;
        for n in [4, 8, 16] {
            let p = interpolant(&[n, n], f);
            let tail: f64 = p.tails(&[1.0, 0.0]).iter().sum();
            let mut worst = 0.0_f64;
            for k in 0..200 {
                let (x, y) = (1.0 + 0.01 * f64::from(k), -2.0 + 0.0125 * f64::from(k));
                worst = worst.max((p.evaluate(&[x, y])[0] - f(x, y)).abs());
            }
            assert!(worst <= tail + 1e-14, "{n}: {worst:e} {tail:e}");
            assert!(tail < 0.1 * last, "{n}: {tail:e}");
            last = tail;
        }
    }

    #[test]
    fn grids_are_nested_and_end_on_the_ends() {
        for k in 0..=8 {
            assert_eq!(
                chebyshev_node((2.0, 7.3), 8, k),
                chebyshev_node((2.0, 7.3), 16, 2 * k)
            );
        }
        assert_eq!(chebyshev_node((2.0, 7.3), 8, 0), 7.3);
        assert_eq!(chebyshev_node((2.0, 7.3), 8, 8), 2.0);
    }
}
