//! Coefficients of the Radau IIA method with three stages.

/// Number of stages.
pub(super) const STAGES: usize = 3;

/// Nodes `c` and weights `a` (Hairer & Wanner 1996, table IV.5.6).
pub(super) fn tableau() -> ([f64; STAGES], [[f64; STAGES]; STAGES]) {
    let s = 6.0_f64.sqrt();
    (
        [(4.0 - s) / 10.0, (4.0 + s) / 10.0, 1.0],
        [
            [
                (88.0 - 7.0 * s) / 360.0,
                (296.0 - 169.0 * s) / 1800.0,
                (-2.0 + 3.0 * s) / 225.0,
            ],
            [
                (296.0 + 169.0 * s) / 1800.0,
                (88.0 + 7.0 * s) / 360.0,
                (-2.0 - 3.0 * s) / 225.0,
            ],
            [(16.0 - s) / 36.0, (16.0 + s) / 36.0, 1.0 / 9.0],
        ],
    )
}

/// The lower factor of `A = L U` where the diagonal of `U` is one.
pub(super) fn crout(a: &[[f64; STAGES]; STAGES]) -> [[f64; STAGES]; STAGES] {
    let (mut l, mut u) = ([[0.0; STAGES]; STAGES], [[0.0; STAGES]; STAGES]);
    for j in 0..STAGES {
        for i in j..STAGES {
            l[i][j] = a[i][j] - (0..j).map(|k| l[i][k] * u[k][j]).sum::<f64>();
        }
        for k in j + 1..STAGES {
            u[j][k] = (a[j][k] - (0..j).map(|m| l[j][m] * u[m][k]).sum::<f64>()) / l[j][j];
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tableau_integrates_polynomials_and_its_lower_factor_has_a_positive_diagonal() {
        let (c, a) = tableau();
        for (i, row) in a.iter().enumerate() {
            for power in 0..STAGES as i32 {
                let sum: f64 = row.iter().zip(c).map(|(a, c)| a * c.powi(power)).sum();
                let exact = c[i].powi(power + 1) / f64::from(power + 1);
                assert!((sum - exact).abs() < 1e-15, "{i} {power}");
            }
        }
        let weights = a[STAGES - 1];
        for power in 0..5 {
            let sum: f64 = weights.iter().zip(c).map(|(b, c)| b * c.powi(power)).sum();
            assert!((sum - 1.0 / f64::from(power + 1)).abs() < 1e-15, "{power}");
        }
        let l = crout(&a);
        assert!((0..STAGES).all(|i| l[i][i] > 0.1));
    }
}
