//! Chebyshev iterations with Jacobi scaling: the smoother and the mass inverse.

use std::mem::swap;
use std::ops::Range;

use crate::columns::{assert_lengths, in_passes, of_buffer};
use crate::csr::{Rows, check_finite, check_shape, into_rows, positive_diagonal};
use crate::lanczos::jacobi_spectrum;
use crate::row_blocks::RowBlocks;
use crate::vector::map_rows;
use crate::{Csr, LinalgError, Preconditioner, PreconditionerKind};

/// Safety factor of the largest eigenvalue, which Lanczos approaches from below.
///
/// Outside the interval Chebyshev polynomials grow fast.
const UPPER_MARGIN: f64 = 1.05;

/// Safety factor of the smallest eigenvalue, which Lanczos approaches from above.
///
/// For a mass matrix the estimate is close. Error components with eigenvalues below the interval do
/// not grow.
const LOWER_MARGIN: f64 = 0.9;

/// Largest degree of a Chebyshev polynomial.
///
/// The error falls by `2 exp(-2 degree / sqrt(range))`: a thousand steps invert any matrix that
/// Jacobi scaling leaves with a condition number below 10^3 to rounding. More are a mistake.
pub(crate) const MAX_DEGREE: usize = 1000;

/// Diagonal matrix `D` of the damped Jacobi steps, with a bound on the spectrum of `D^-1 K`.
pub(crate) struct JacobiScaling {
    /// The entries `d_i = sum_j |k_ij|`.
    pub diagonal: Vec<f64>,
    /// Upper bound on the eigenvalues of `D^-1 K`.
    pub upper: f64,
}

impl JacobiScaling {
    /// The l1 scaling of a symmetric matrix with positive diagonal entries.
    ///
    /// Rows with large off-diagonal entries, those of poor cells, are damped more than by the
    /// diagonal of `K`, and all others less, because they no longer share the bound on the spectrum
    /// with them. Iterations of FGMRES on meshes of Gmsh: 27 to 29 instead of 29 to 32. Source:
    /// Baker, Falgout, Kolev, Yang, SIAM J. Sci. Comput. 33, 2011.
    pub fn new(k: &Csr) -> Result<Self, LinalgError> {
        let rows = Rows::new(k);
        let row_sum = |i: usize| rows.entries(i).1.iter().map(|v| v.abs()).sum::<f64>();
        let diagonal = map_rows(k.rows(), &row_sum);
        // by Gershgorin's circles no eigenvalue is above one
        let upper = (UPPER_MARGIN * jacobi_spectrum(k, &diagonal)?.1).min(1.0);
        Ok(JacobiScaling { diagonal, upper })
    }

    /// Factor of the Jacobi step that smooths a tentative prolongation, `4 / (3 upper)`.
    ///
    /// It minimises the bound on the energy (Vanek, Mandel, Brezina 1996).
    pub fn prolongation_factor(&self) -> f64 {
        4.0 / (3.0 * self.upper)
    }
}

/// Relaxation factors `w_k` of a Chebyshev smoother made of `degree` damped Jacobi sweeps.
///
/// A sweep is `x <- x + w_k D^-1 (b - A x)`.
///
/// All sweeps together multiply the error at eigenvalue `t` of `D^-1 A` by `prod (1 - w_k t)`. The
/// factors `w_k` are the reciprocal roots of the Chebyshev polynomial on `[upper / range, upper]`,
/// so the product is `T((a - t) / d) / T(a / d)` with the midpoint a and the half-width d of the
/// interval.
pub(crate) fn sweeps(upper: f64, range: f64, degree: usize) -> Vec<f64> {
    let lower = upper / range;
    let (a, d) = (0.5 * (upper + lower), 0.5 * (upper - lower));
    (0..degree)
        .map(|k| {
            let angle = std::f64::consts::PI * (k as f64 + 0.5) / degree as f64;
            (a + d * angle.cos()).recip()
        })
        .collect()
}

/// Approximate inverse of a mass matrix: a few Chebyshev-Jacobi steps from zero.
///
/// After Jacobi scaling a mass matrix is well conditioned (eigenvalues from 1/2 to 5/2 for linear
/// tetrahedra: Wathen 1987): three steps leave about a tenth of the error. Linear, symmetric and
/// positive definite. Reference: Saad, Iterative Methods for Sparse Linear Systems, algorithm 12.1.
///
/// Cost: `degree - 1` passes over the matrix; allocates nothing.
#[derive(Debug, Clone)]
pub struct MassInverse {
    mass: Csr,
    inverse_diagonal: Vec<f64>,
    blocks: RowBlocks,
    factors: Vec<f64>,
    /// Second buffer, with which `z` alternates as the result of a step; one column after another.
    next: Vec<f64>,
}

impl MassInverse {
    /// Prepares `degree` steps, from 1 to 1000, for a symmetric positive definite matrix.
    ///
    /// # Errors
    /// [`LinalgError::NotPositive`], [`LinalgError::Parameter`], [`LinalgError::Factorisation`] for
    /// a matrix with an eigenvalue that is not positive, [`LinalgError::Breakdown`] for overflow.
    pub fn new(mass: &Csr, degree: usize) -> Result<Self, LinalgError> {
        if !(1..=MAX_DEGREE).contains(&degree) {
            return Err(LinalgError::Parameter {
                name: "degree of the mass inverse",
                value: degree as f64,
                range: "from 1 to 1000",
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
            blocks: RowBlocks::new(Rows::new(&mass).indptr),
            factors: sweeps(upper, upper / lower, degree),
            next: Vec::new(),
            mass,
        })
    }

    /// The mass matrix.
    pub(crate) fn matrix(&self) -> &Csr {
        &self.mass
    }

    /// Overwrites the columns `z` with the approximate solutions for `r`.
    pub(crate) fn pass<const S: usize>(&mut self, r: [&[f64]; S], z: [&mut [f64]; S]) {
        let (mass, scale, n) = (
            Rows::new(&self.mass),
            &self.inverse_diagonal,
            self.mass.rows(),
        );
        assert_lengths(&r, n, &z, n);
        self.next.resize(self.next.len().max(S * n), 0.0);
        // steps alternate between two buffers; the last one must end in `z`
        let (mut from, mut to) = (z, of_buffer(&mut self.next, n));
        if self.factors.len().is_multiple_of(2) {
            swap(&mut from, &mut to);
        }
        let first = self.factors[0];
        let start = |rows: Range<usize>, mut x: [&mut [f64]; S]| {
            for (at, i) in rows.enumerate() {
                for (x, r) in x.iter_mut().zip(r) {
                    x[at] = first * scale[i] * r[i];
                }
            }
        };
        self.blocks
            .for_each_block(from.each_mut().map(|x| &mut **x), &start);
        for &factor in &self.factors[1..] {
            let x = from.each_ref().map(|x| &**x);
            let step = |rows: Range<usize>, next: [&mut [f64]; S]| {
                for (at, i) in rows.enumerate() {
                    let mut product = [0.0; S];
                    for (j, m) in mass.row(i) {
                        for (sum, x) in product.iter_mut().zip(x) {
                            *sum += m * x[j];
                        }
                    }
                    for s in 0..S {
                        next[s][at] = x[s][i] + factor * scale[i] * (r[s][i] - product[s]);
                    }
                }
            };
            self.blocks
                .for_each_block(to.each_mut().map(|x| &mut **x), &step);
            swap(&mut from, &mut to);
        }
    }
}

impl Preconditioner for MassInverse {
    fn size(&self) -> usize {
        self.mass.rows()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        self.pass([r], [z]);
    }

    fn apply_columns(&mut self, r: &[&[f64]], z: &mut [&mut [f64]]) {
        in_passes!(self.pass(r, z));
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error polynomial of the smoother is the Chebyshev polynomial, whose extrema on the
    /// interval have equal size.
    #[test]
    fn smoother_ripples_equally() {
        let (upper, range) = (2.0, 8.0);
        for degree in 1..6 {
            let sweeps = sweeps(upper, range, degree);
            let error = |t: f64| sweeps.iter().map(|w| 1.0 - w * t).product::<f64>();
            let ripple = error(upper / range);
            let (a, d) = (9.0 / 8.0, 7.0 / 8.0);
            for k in 0..=degree {
                let extremum = a + d * (std::f64::consts::PI * k as f64 / degree as f64).cos();
                let sign = if (degree - k) % 2 == 0 { 1.0 } else { -1.0 };
                approx::assert_relative_eq!(error(extremum), sign * ripple, epsilon = 1e-14);
            }
            assert_eq!(error(0.0), 1.0);
        }
    }

    /// The error obeys the Chebyshev bound `1 / T3` on a circulant matrix.
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
        let rows = Rows::new(&mass);
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
        // eigenvalues `1 ± cos(2 pi k / n) / 2`, with the safety factors of the bounds
        let (upper, lower) = (1.5 * UPPER_MARGIN, 0.5 * LOWER_MARGIN);
        let s = (upper + lower) / (upper - lower);
        assert!(error <= size / (4.0 * s.powi(3) - 3.0 * s) && error > 0.0);
    }
}
