//! Chebyshev polynomials in a Jacobi-scaled matrix: smoother coefficients and the mass inverse.

use crate::csr::{Rows, check_finite, check_shape, into_rows, positive_diagonal};
use crate::lanczos::jacobi_spectrum;
use crate::row_blocks::RowBlocks;
use crate::{Csr, LinalgError, Preconditioner, PreconditionerKind};

/// Lanczos finds the largest eigenvalue from below; Chebyshev polynomials grow fast above their interval.
const UPPER_MARGIN: f64 = 1.05;

/// It finds the smallest eigenvalue from above, close for a mass matrix; slow modes below the interval stay bounded.
const LOWER_MARGIN: f64 = 0.9;

/// The largest eigenvalue of `D^-1 K` with its margin.
pub(crate) fn upper_bound(k: &Csr, diagonal: &[f64]) -> Result<f64, LinalgError> {
    Ok(UPPER_MARGIN * jacobi_spectrum(k, diagonal)?.1)
}

/// The two coefficients of a smoother `x <- x + (c0 - c1 D^-1 A) D^-1 (b - A x)`.
///
/// The error is multiplied by `1 - c0 t + c1 t^2` at eigenvalue `t` of `D^-1 A`: the Chebyshev polynomial of
/// degree two on `[upper / range, upper]`, `T2((a - t) / d) / T2(a / d)` with midpoint a, half-width d.
pub(crate) fn quadratic_smoother(upper: f64, range: f64) -> (f64, f64) {
    let lower = upper / range;
    let (a, d) = (0.5 * (upper + lower), 0.5 * (upper - lower));
    let scale = 2.0 * a * a - d * d;
    (4.0 * a / scale, 2.0 / scale)
}

/// An approximate inverse of a mass matrix: a few Chebyshev-Jacobi steps from zero.
///
/// A mass matrix is well conditioned after Jacobi scaling (1/2 .. 5/2 for linear tetrahedra: Wathen 1987):
/// three steps leave about a tenth of the error. Linear, symmetric and positive definite.
/// Reference: Saad, Iterative Methods for Sparse Linear Systems, algorithm 12.1.
///
/// Cost: `degree - 1` passes over the matrix, allocates nothing.
#[derive(Debug, Clone)]
pub struct MassInverse {
    mass: Csr,
    inverse_diagonal: Vec<f64>,
    blocks: RowBlocks,
    centre: f64,
    half_width: f64,
    degree: usize,
    residual: Vec<f64>,
    direction: Vec<f64>,
}

impl MassInverse {
    /// From a symmetric positive definite matrix and the number of steps, at least one.
    ///
    /// # Errors
    /// [`LinalgError::NotPositive`], [`LinalgError::Parameter`], or what the eigenvalue estimate reports.
    pub fn new(mass: &Csr, degree: usize) -> Result<Self, LinalgError> {
        if degree == 0 {
            return Err(LinalgError::Parameter {
                name: "degree of the mass inverse",
                value: 0.0,
                range: "at least 1",
            });
        }
        check_shape("mass matrix", mass.shape(), (mass.rows(), mass.rows()))?;
        check_finite("mass matrix", mass.data())?;
        let mass = into_rows(mass.clone());
        let diagonal = positive_diagonal("mass matrix", &mass)?;
        let (lower, upper) = jacobi_spectrum(&mass, &diagonal)?;
        if lower <= 0.0 {
            return Err(LinalgError::Factorisation {
                what: "mass matrix",
                detail: format!("it has the Jacobi-scaled eigenvalue {lower:e}"),
            });
        }
        let (lower, upper) = (LOWER_MARGIN * lower, UPPER_MARGIN * upper);
        Ok(MassInverse {
            inverse_diagonal: diagonal.iter().map(|d| d.recip()).collect(),
            blocks: RowBlocks::new(Rows::of(&mass).indptr),
            centre: 0.5 * (upper + lower),
            half_width: 0.5 * (upper - lower),
            degree,
            residual: vec![0.0; mass.rows()],
            direction: vec![0.0; mass.rows()],
            mass,
        })
    }
}

impl Preconditioner for MassInverse {
    fn size(&self) -> usize {
        self.mass.rows()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let mass = Rows::of(&self.mass);
        let (scaled, direction) = (&self.inverse_diagonal, &mut self.direction);
        self.residual.copy_from_slice(r);
        for ((d, z), (r, s)) in direction.iter_mut().zip(&mut *z).zip(r.iter().zip(scaled)) {
            *d = s * r / self.centre;
            *z = *d;
        }
        let sigma = self.centre / self.half_width;
        let mut rho = sigma.recip();
        for _ in 1..self.degree {
            self.blocks.for_each(&mut self.residual, &|i, ri| {
                *ri -= mass.row(i).map(|(j, m)| m * direction[j]).sum::<f64>();
            });
            let next = (2.0 * sigma - rho).recip();
            let (keep, add) = (next * rho, 2.0 * next / self.half_width);
            rho = next;
            let residual = self.residual.iter().zip(scaled);
            for ((d, z), (r, s)) in direction.iter_mut().zip(&mut *z).zip(residual) {
                *d = keep * *d + add * s * r;
                *z += *d;
            }
        }
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The residual polynomial of the smoother is the Chebyshev polynomial: equal ripples on the interval.
    #[test]
    fn smoother_ripples_equally() {
        let (upper, range) = (2.0, 8.0);
        let (c0, c1) = quadratic_smoother(upper, range);
        let error = |t: f64| 1.0 - c0 * t + c1 * t * t;
        let ripple = error(upper);
        approx::assert_relative_eq!(error(upper / range), ripple, epsilon = 1e-14);
        approx::assert_relative_eq!(
            error(0.5 * (upper + upper / range)),
            -ripple,
            epsilon = 1e-14
        );
        assert_eq!(error(0.0), 1.0);
    }

    /// On a diagonal matrix with spectrum inside the bounds the error obeys the Chebyshev bound `1 / T3`.
    #[test]
    fn mass_inverse_obeys_the_chebyshev_bound() {
        let n = 60;
        let mut t = sprs::TriMatI::<f64, u32>::new((n, n));
        for i in 0..n {
            t.add_triplet(i, i, 4.0);
            t.add_triplet(i, (i + 1) % n, 1.0);
            t.add_triplet((i + 1) % n, i, 1.0);
        }
        let mass: Csr = t.to_csr();
        let mut inverse = MassInverse::new(&mass, 3).expect("a mass matrix");
        let exact: Vec<f64> = (0..n).map(|i| (i as f64).sin()).collect();
        let mut r = vec![0.0; n];
        let rows = Rows::of(&mass);
        for (i, ri) in r.iter_mut().enumerate() {
            *ri = rows.row(i).map(|(j, m)| m * exact[j]).sum();
        }
        let mut z = vec![0.0; n];
        inverse.apply(&r, &mut z);
        let error: f64 = z
            .iter()
            .zip(&exact)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt();
        let size: f64 = exact.iter().map(|a| a * a).sum::<f64>().sqrt();
        let s = inverse.centre / inverse.half_width;
        assert!(error <= size / (4.0 * s.powi(3) - 3.0 * s) && error > 0.0);
    }
}
