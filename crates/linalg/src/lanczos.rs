//! Extreme eigenvalues of a Jacobi-scaled matrix.

use nalgebra::DMatrix;

use crate::csr::Rows;
use crate::row_blocks::RowBlocks;
use crate::vector::{axpy, dot, for_each_chunk, norm, scale};
use crate::{Csr, LinalgError};

/// Steps of the recurrence.
///
/// They give the largest eigenvalue within one or two per cent, as a Chebyshev smoother needs;
/// fewer steps cost iterations, more gain none.
const LANCZOS_STEPS: usize = 16;

/// Estimates the `(min, max)` eigenvalues of `D^-1 K`, `D = diag(K)`, for a positive definite `K`.
///
/// Lanczos iteration from a fixed pseudo-random vector. The Ritz values lie inside the spectrum, so
/// the largest is slightly too small and the smallest may be far too large. Reference: Saad,
/// Iterative Methods, 6.6.
pub(crate) fn jacobi_spectrum(k: &Csr, diagonal: &[f64]) -> Result<(f64, f64), LinalgError> {
    let n = k.rows();
    if n == 0 {
        return Ok((1.0, 1.0));
    }
    let rows = Rows::new(k);
    let blocks = RowBlocks::new(rows.indptr);
    let root: Vec<f64> = diagonal.iter().map(|d| d.sqrt().recip()).collect();
    let mut v: Vec<f64> = (0..n as u64).map(pseudo_random).collect();
    scale(norm(&v).recip(), &mut v);
    let mut previous = vec![0.0; n];
    let mut w = vec![0.0; n];
    let mut scaled = vec![0.0; n];
    let (mut alphas, mut betas) = (Vec::new(), Vec::new());
    let mut beta = 0.0;
    for _ in 0..LANCZOS_STEPS.min(n) {
        for_each_chunk(&mut scaled, &|start, scaled| {
            for (s, (v, root)) in scaled.iter_mut().zip(v[start..].iter().zip(&root[start..])) {
                *s = root * v;
            }
        });
        blocks.for_each(&mut w, &|i, wi| {
            let sum: f64 = rows.row(i).map(|(j, kij)| kij * scaled[j]).sum();
            *wi = root[i] * sum;
        });
        let alpha = dot(&w, &v);
        axpy(-alpha, &v, &mut w);
        axpy(-beta, &previous, &mut w);
        alphas.push(alpha);
        beta = norm(&w);
        // an invariant subspace: its Ritz values are exact
        if beta <= 1e-12 * alpha.abs() {
            break;
        }
        betas.push(beta);
        scale(beta.recip(), &mut w);
        std::mem::swap(&mut previous, &mut v);
        std::mem::swap(&mut v, &mut w);
    }
    let steps = alphas.len();
    if alphas.iter().chain(&betas).any(|a| !a.is_finite()) {
        return Err(LinalgError::Breakdown {
            method: "Lanczos eigenvalue estimate",
            iteration: steps,
            cause: "the matrix overflows; scale the problem to lengths and viscosities near one",
        });
    }
    let mut t = DMatrix::zeros(steps, steps);
    for i in 0..steps {
        t[(i, i)] = alphas[i];
        if i + 1 < steps {
            t[(i, i + 1)] = betas[i];
            t[(i + 1, i)] = betas[i];
        }
    }
    let ritz = t.symmetric_eigenvalues();
    let (min, max) = (ritz.min(), ritz.max());
    if max > 0.0 {
        return Ok((min, max));
    }
    Err(LinalgError::Factorisation {
        what: "stiffness matrix",
        detail: format!(
            "its Jacobi-scaled eigenvalues are at most {max:e}, it is not positive definite"
        ),
    })
}

/// A pseudo-random number in [-1/2, 1/2) from `i`: the splitmix64 finaliser (Steele, Lea, Flood
/// 2014).
pub(crate) fn pseudo_random(i: u64) -> f64 {
    let mut z = i.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / 2f64.powi(64) - 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 1-D Laplacian has eigenvalues `1 - cos(j pi / (n + 1))` after Jacobi scaling.
    #[test]
    fn spectrum_of_the_one_dimensional_laplacian() {
        let n = 400;
        let mut t = sprs::TriMatI::<f64, u32>::new((n, n));
        for i in 0..n {
            t.add_triplet(i, i, 2.0);
            if i > 0 {
                t.add_triplet(i, i - 1, -1.0);
                t.add_triplet(i - 1, i, -1.0);
            }
        }
        let (_, max) = jacobi_spectrum(&t.to_csr(), &vec![2.0; n]).expect("positive definite");
        let exact = 1.0 + (std::f64::consts::PI / (n + 1) as f64).cos();
        assert!(
            max <= exact * (1.0 + 1e-12) && max > 0.97 * exact,
            "{max} {exact}"
        );
    }

    #[test]
    fn small_matrices_are_exact() {
        let k = Csr::new(
            (2, 2),
            vec![0, 2, 4],
            vec![0, 1, 0, 1],
            vec![2.0, -1.0, -1.0, 2.0],
        );
        let (min, max) = jacobi_spectrum(&k, &[2.0, 2.0]).expect("positive definite");
        approx::assert_relative_eq!(min, 0.5, epsilon = 1e-14);
        approx::assert_relative_eq!(max, 1.5, epsilon = 1e-14);
    }
}
