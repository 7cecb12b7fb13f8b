//! The two bases of flexible GMRES.

use rayon::prelude::*;

use crate::vector::{CHUNK, dot, max_abs, norm, power_of_two_below};

/// Reorthogonalise when more than this part of a vector cancels: Daniel, Gragg, Kaufman, Stewart (1976).
const CANCELLATION: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Orthonormal vectors in f64.
///
/// Vectors are made as they are needed and kept over restarts.
pub(super) struct Orthonormal {
    vectors: Vec<Vec<f64>>,
}

impl Orthonormal {
    pub fn new() -> Self {
        Orthonormal {
            vectors: Vec::new(),
        }
    }

    /// Vector `j`, made if it is the next one.
    pub fn slot(&mut self, j: usize, n: usize) -> &mut [f64] {
        if j == self.vectors.len() {
            self.vectors.push(vec![0.0; n]);
        }
        &mut self.vectors[j]
    }

    pub fn vector(&self, j: usize) -> &[f64] {
        &self.vectors[j]
    }

    /// Makes vector `k` orthogonal to those before it; `h[..k]` receives the coefficients. Returns its norm.
    ///
    /// Classical Gram-Schmidt: two sweeps through memory, once more where rounding would cost orthogonality.
    pub fn orthogonalise(&mut self, k: usize, h: &mut [f64]) -> f64 {
        let (basis, rest) = self.vectors.split_at_mut(k);
        let w = &mut rest[0];
        h[..k].fill(0.0);
        let mut before = norm(w);
        for _ in 0..2 {
            let coefficients: Vec<f64> = basis.iter().map(|v| dot(v, w)).collect();
            w.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, w)| {
                let start = chunk * CHUNK;
                for (v, c) in basis.iter().zip(&coefficients) {
                    for (w, v) in w.iter_mut().zip(&v[start..]) {
                        *w -= c * v;
                    }
                }
            });
            for (h, c) in h.iter_mut().zip(&coefficients) {
                *h += c;
            }
            let after = norm(w);
            if after > CANCELLATION * before {
                return after;
            }
            before = after;
        }
        before
    }
}

/// A vector in f32 with a power of two for its size: half the memory of the preconditioned basis.
struct Rounded {
    scale: f64,
    values: Vec<f32>,
}

/// The preconditioned vectors.
///
/// Rounding counts as part of the preconditioner: the operator is applied to the *rounded* vector, so the method loses
/// nothing (flexible GMRES admits any preconditioner, and the solution is combined from the very same vectors).
pub(super) struct RoundedBasis {
    vectors: Vec<Rounded>,
}

impl RoundedBasis {
    pub fn new() -> Self {
        RoundedBasis {
            vectors: Vec::new(),
        }
    }

    /// Stores `z` as vector `j` and rounds it in place.
    pub fn store(&mut self, j: usize, z: &mut [f64]) {
        if j == self.vectors.len() {
            self.vectors.push(Rounded {
                scale: 1.0,
                values: vec![0.0; z.len()],
            });
        }
        let vector = &mut self.vectors[j];
        let scale = power_of_two_below(max_abs(z));
        vector.scale = scale;
        vector
            .values
            .par_chunks_mut(CHUNK)
            .zip(z.par_chunks_mut(CHUNK))
            .for_each(|(short, z)| {
                for (short, z) in short.iter_mut().zip(z) {
                    *short = (*z / scale) as f32;
                    *z = f64::from(*short) * scale;
                }
            });
    }

    /// `x <- x + sum_j y_j z_j`.
    pub fn add_combination(&self, y: &[f64], x: &mut [f64]) {
        x.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, x)| {
            let start = chunk * CHUNK;
            for (vector, y) in self.vectors.iter().zip(y) {
                let factor = y * vector.scale;
                for (x, z) in x.iter_mut().zip(&vector.values[start..]) {
                    *x += factor * f64::from(*z);
                }
            }
        });
    }
}

/// `v <- v / norm` is written once here: a zero norm is the caller's to exclude.
pub(super) fn normalise(v: &mut [f64], norm: f64) {
    crate::vector::scale(norm.recip(), v);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::axpy;

    #[test]
    fn nearly_dependent_vectors_come_out_orthogonal() {
        let n = 10_000;
        let mut basis = Orthonormal::new();
        let mut h = [0.0; 3];
        for j in 0..3 {
            let slot = basis.slot(j, n);
            for (i, v) in slot.iter_mut().enumerate() {
                // vectors that differ in the ninth digit
                *v = 1.0 + 1e-9 * ((j * i) as f64).sin();
            }
            let size = basis.orthogonalise(j, &mut h);
            normalise(basis.slot(j, n), size);
        }
        for (i, j) in [(0, 1), (0, 2), (1, 2)] {
            let overlap = dot(basis.vector(i), basis.vector(j));
            assert!(overlap.abs() < 1e-12, "{i} {j}: {overlap:e}");
        }
    }

    #[test]
    fn rounding_is_recorded_exactly() {
        let mut z = vec![1e-20, -3.3e-20, 7.7e-21];
        let mut basis = RoundedBasis::new();
        basis.store(0, &mut z);
        let mut x = vec![0.0; 3];
        basis.add_combination(&[1.0], &mut x);
        assert_eq!(x, z);
        let mut y = vec![0.0; 3];
        axpy(1.0, &z, &mut y);
        assert_eq!(x, y);
    }
}
