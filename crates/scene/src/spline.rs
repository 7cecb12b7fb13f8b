//! Cubic splines through the values of a table.

/// Second derivatives at the knots of the cubic spline through `values` at increasing `times`.
///
/// The spline is twice continuously differentiable (de Boor 2001, chapter IV). With `is_periodic`
/// the last value is the first one and both ends join with the same smoothness, otherwise the
/// second derivative is zero at the ends (natural spline). Cost: linear.
pub(crate) fn second_derivatives(times: &[f64], values: &[f64], is_periodic: bool) -> Vec<f64> {
    let steps: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
    let slopes: Vec<f64> = (values.windows(2).zip(&steps))
        .map(|(y, h)| (y[1] - y[0]) / h)
        .collect();
    let n = steps.len();
    // The row of a knot between two intervals: h M + 2 (h + k) M + k M = 6 (slope - slope).
    let row = |before: usize, after: usize| {
        let right = 6.0 * (slopes[after] - slopes[before]);
        (
            steps[before],
            2.0 * (steps[before] + steps[after]),
            steps[after],
            right,
        )
    };
    if n < 2 {
        return vec![0.0; n + 1];
    }
    if !is_periodic {
        let rows: Vec<_> = (1..n).map(|k| row(k - 1, k)).collect();
        let right: Vec<f64> = rows.iter().map(|row| row.3).collect();
        let inner = tridiagonal(&rows, right);
        return std::iter::once(0.0).chain(inner).chain([0.0]).collect();
    }
    // The corners of the periodic matrix are a correction of rank one (Sherman & Morrison 1950):
    // A = T + u v^T with u = (g, 0, .., corner), v = (1, 0, .., corner / g).
    let mut rows: Vec<_> = (0..n).map(|k| row((k + n - 1) % n, k)).collect();
    let corner = steps[n - 1];
    if n == 2 {
        // Both neighbours of a knot are the other one.
        let (a, b) = (rows[0], rows[1]);
        let (off_a, off_b) = (a.0 + a.2, b.0 + b.2);
        let determinant = a.1 * b.1 - off_a * off_b;
        let first = (a.3 * b.1 - off_a * b.3) / determinant;
        let second = (a.1 * b.3 - off_b * a.3) / determinant;
        return vec![first, second, first];
    }
    let g = -rows[0].1;
    rows[0].1 -= g;
    rows[n - 1].1 -= corner * corner / g;
    let right: Vec<f64> = rows.iter().map(|row| row.3).collect();
    let mut of_corner = vec![0.0; n];
    (of_corner[0], of_corner[n - 1]) = (g, corner);
    let solution = tridiagonal(&rows, right);
    let response = tridiagonal(&rows, of_corner);
    let project = |x: &[f64]| x[0] + corner / g * x[n - 1];
    let factor = project(&solution) / (1.0 + project(&response));
    let mut result: Vec<f64> = (solution.iter().zip(&response))
        .map(|(x, y)| x - factor * y)
        .collect();
    result.push(result[0]);
    result
}

/// Solves a tridiagonal system by elimination (Thomas 1949), stable for diagonally dominant rows.
///
/// Rows have the entries below, on and above the diagonal.
fn tridiagonal(rows: &[(f64, f64, f64, f64)], mut right: Vec<f64>) -> Vec<f64> {
    let n = rows.len();
    let mut diagonal: Vec<f64> = rows.iter().map(|row| row.1).collect();
    for k in 1..n {
        let factor = rows[k].0 / diagonal[k - 1];
        diagonal[k] -= factor * rows[k - 1].2;
        right[k] -= factor * right[k - 1];
    }
    for k in (0..n).rev() {
        if k + 1 < n {
            right[k] -= rows[k].2 * right[k + 1];
        }
        right[k] /= diagonal[k];
    }
    right
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Value and derivatives of a piece at its begin and end.
    fn ends(h: f64, y: [f64; 2], m: [f64; 2]) -> [[f64; 3]; 2] {
        let slope = (y[1] - y[0]) / h;
        [
            [y[0], slope - h * (2.0 * m[0] + m[1]) / 6.0, m[0]],
            [y[1], slope + h * (m[0] + 2.0 * m[1]) / 6.0, m[1]],
        ]
    }

    #[test]
    fn pieces_join_with_two_derivatives() {
        let times: [f64; 6] = [0.0, 0.5, 1.5, 1.7, 3.0, 3.2];
        for n in 2..times.len() {
            let times = &times[..=n];
            for is_periodic in [false, true] {
                let mut values: Vec<f64> = times.iter().map(|t| (2.0 * t).sin() + t * t).collect();
                if is_periodic {
                    values[n] = values[0];
                }
                let m = second_derivatives(times, &values, is_periodic);
                let pieces: Vec<_> = (0..n)
                    .map(|k| {
                        ends(
                            times[k + 1] - times[k],
                            [values[k], values[k + 1]],
                            [m[k], m[k + 1]],
                        )
                    })
                    .collect();
                let mut joints: Vec<_> = pieces.windows(2).map(|p| (p[0][1], p[1][0])).collect();
                if is_periodic {
                    joints.push((pieces[n - 1][1], pieces[0][0]));
                } else {
                    assert_eq!((m[0], m[n]), (0.0, 0.0));
                }
                for (before, after) in joints {
                    for (a, b) in before.iter().zip(after) {
                        // Second derivatives are up to a hundred, and the steps down to 0.2.
                        assert!((a - b).abs() < 1e-11, "{a} {b}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_periodic_spline_of_a_sine_has_its_second_derivatives_to_second_order() {
        let error = |n: usize| {
            let times: Vec<f64> = (0..=n).map(|k| k as f64 / n as f64).collect();
            let mut values: Vec<f64> = times.iter().map(|t| (TAU * t).sin()).collect();
            values[n] = values[0];
            let found = second_derivatives(&times, &values, true);
            let exact = times.iter().map(|t| -TAU * TAU * (TAU * t).sin());
            found
                .iter()
                .zip(exact)
                .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()))
        };
        let ratio = error(16) / error(32);
        assert!((3.8..4.2).contains(&ratio), "{ratio}");
    }
}
