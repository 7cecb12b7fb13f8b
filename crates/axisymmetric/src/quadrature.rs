//! Quadrature on the reference triangle, and Lobatto points on the unit interval.

use std::f64::consts::PI;

/// A quadrature point of the reference triangle. The weights of a rule add up to 1/2.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RulePoint {
    pub barycentric: [f64; 3],
    pub weight: f64,
}

/// Collapsed Gauss rule with `n^2` points, exact for polynomials of degree `2 n - 2`.
///
/// All points are in the interior of the triangle.
pub(crate) fn triangle_rule(n: usize) -> Vec<RulePoint> {
    let line = gauss(n);
    let mut points = Vec::with_capacity(n * n);
    for &(s, along) in &line {
        for &(t, across) in &line {
            // x = s (1 - t), y = t; the Jacobian of this map is 1 - t
            points.push(RulePoint {
                barycentric: [(1.0 - s) * (1.0 - t), s * (1.0 - t), t],
                weight: along * across * (1.0 - t),
            });
        }
    }
    points
}

/// Gauss-Legendre points and weights on [0, 1].
pub(crate) fn gauss(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let guess = -((i as f64 + 0.75) / (n as f64 + 0.5) * PI).cos();
            let x = newton(guess, |x| {
                let [p, dp, _] = legendre(n, x);
                p / dp
            });
            let [_, dp, _] = legendre(n, x);
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * dp * dp))
        })
        .collect()
}

/// The `n + 1` Lobatto points on [0, 1]: both ends and the zeros of the derivative of the Legendre
/// polynomial of degree `n`.
pub(crate) fn lobatto(n: usize) -> Vec<f64> {
    (0..=n)
        .map(|i| match i {
            0 => 0.0,
            _ if i == n => 1.0,
            _ => {
                let guess = -(PI * i as f64 / n as f64).cos();
                let x = newton(guess, |x| {
                    let [_, dp, ddp] = legendre(n, x);
                    dp / ddp
                });
                0.5 * (1.0 + x)
            }
        })
        .collect()
}

/// Newton's method from a close initial guess, which converges to rounding in a few steps.
fn newton(guess: f64, step: impl Fn(f64) -> f64) -> f64 {
    let mut x = guess;
    for _ in 0..50 {
        let change = step(x);
        x -= change;
        if change.abs() < 1e-16 {
            break;
        }
    }
    x
}

/// The Legendre polynomial of degree `n` and its first two derivatives at `x` in [-1, 1].
pub(crate) fn legendre(n: usize, x: f64) -> [f64; 3] {
    let (mut previous, mut p) = ([0.0; 3], [1.0, 0.0, 0.0]);
    for k in 0..n {
        // P_(k+1)' = P_(k-1)' + (2 k + 1) P_k, and its derivative, also at the ends
        let factor = (2 * k + 1) as f64;
        let next = [
            (factor * x * p[0] - k as f64 * previous[0]) / (k + 1) as f64,
            previous[1] + factor * p[0],
            previous[2] + factor * p[1],
        ];
        (previous, p) = (p, next);
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn collapsed_rules_are_exact_up_to_their_degree() {
        for n in 1..8 {
            let rule = triangle_rule(n);
            for a in 0..2 * n {
                for b in 0..2 * n - 1 - a.min(2 * n - 2) {
                    if a + b > 2 * n - 2 {
                        continue;
                    }
                    let sum: f64 = rule
                        .iter()
                        .map(|p| {
                            p.weight
                                * p.barycentric[1].powi(a as i32)
                                * p.barycentric[2].powi(b as i32)
                        })
                        .sum();
                    let factorial = |k: usize| (1..=k).map(|i| i as f64).product::<f64>();
                    let exact = factorial(a) * factorial(b) / factorial(a + b + 2);
                    assert!((sum - exact).abs() < 1e-14, "n {n}: {a} {b}");
                }
            }
        }
    }

    #[test]
    fn lobatto_points_of_degree_four() {
        let expected = [
            0.0,
            0.5 - (3.0_f64 / 28.0).sqrt(),
            0.5,
            0.5 + (3.0_f64 / 28.0).sqrt(),
            1.0,
        ];
        for (x, e) in lobatto(4).iter().zip(expected) {
            assert!((x - e).abs() < 1e-15);
        }
        assert_eq!(lobatto(1), [0.0, 1.0]);
    }
}
