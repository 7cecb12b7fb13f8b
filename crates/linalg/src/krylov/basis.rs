//! The two bases of flexible GMRES.

use rayon::prelude::*;

use crate::SumOverProcesses;
use crate::vector::{CHUNK, for_each_chunk, lanes_dot, max_abs, power_of_two_below};

/// Vector entries per parallel task: enough that the cost of its partial sums is negligible.
const ENTRIES_PER_TASK: usize = 16 * CHUNK;

/// Fraction of its length below which an orthogonalised vector is orthogonalised a second time.
///
/// The second orthogonalisation costs as much as the first; a reduction of the length by a factor
/// of ten costs one of sixteen digits of orthogonality (Hoffmann, Computing 41, 1989).
const MAX_CANCELLATION: f64 = 0.1;

/// A basis vector in the precision it needs.
enum Vector {
    Double(Vec<f64>),
    Single(Vec<f32>),
}

/// Vectors that are orthonormal in `x · y = sum w_i x_i y_i`, with `w = 1` unless given.
///
/// Vectors are allocated on demand and kept over restarts. Orthogonalisation reads each of them
/// twice: for the coefficients, then for the differences.
pub struct OrthonormalBasis<'a> {
    weights: Option<&'a [f32]>,
    sum: Option<&'a SumOverProcesses<'a>>,
    vectors: Vec<Vector>,
    /// Partial sums of all tasks, in the order in which they are added.
    partial: Vec<f64>,
}

impl<'a> OrthonormalBasis<'a> {
    /// An empty basis for the inner product with these weights.
    pub fn new(weights: Option<&'a [f32]>) -> Self {
        OrthonormalBasis {
            weights,
            sum: None,
            vectors: Vec::new(),
            partial: Vec::new(),
        }
    }

    /// The same for vectors that are divided between processes.
    pub(super) fn with_sum(mut self, sum: Option<&'a SumOverProcesses<'a>>) -> Self {
        self.sum = sum;
        self
    }

    /// Stores `w / norm` as vector `j`, in f32 if `single`.
    ///
    /// `j` is at most the number of vectors; later ones in another precision are dropped.
    pub fn store(&mut self, j: usize, w: &[f64], norm: f64, single: bool) {
        let factor = norm.recip();
        // a vector from before a restart is reused if it has the right precision
        self.vectors.truncate(j.max(self.reusable(j, single)));
        if j == self.vectors.len() {
            self.vectors.push(if single {
                Vector::Single(vec![0.0; w.len()])
            } else {
                Vector::Double(vec![0.0; w.len()])
            });
        }
        match &mut self.vectors[j] {
            Vector::Double(v) => zip_chunks(v, w, |v, w| *v = factor * w),
            Vector::Single(v) => zip_chunks(v, w, |v, w| *v = (factor * w) as f32),
        }
    }

    /// Frees all vectors.
    pub(super) fn clear(&mut self) {
        self.vectors = Vec::new();
    }

    /// Number of vectors that may stay when vector `j` is stored again.
    fn reusable(&self, j: usize, single: bool) -> usize {
        match self.vectors.get(j) {
            Some(Vector::Double(_)) if !single => self.vectors.len(),
            Some(Vector::Single(_)) if single => self.vectors.len(),
            _ => j,
        }
    }

    /// Vector `j` in f64, written to `buffer` if it is stored in f32.
    pub(super) fn vector<'b>(&'b self, j: usize, buffer: &'b mut [f64]) -> &'b [f64] {
        match &self.vectors[j] {
            Vector::Double(v) => v,
            Vector::Single(v) => {
                zip_chunks(buffer, v, |b, v| *b = f64::from(*v));
                buffer
            }
        }
    }

    /// The norm of `w`.
    pub(super) fn norm(&mut self, w: &mut [f64]) -> f64 {
        self.sweep(0, w, &[], true);
        self.partial[0].sqrt()
    }

    /// Makes `w` orthogonal to the first `k` vectors and returns its norm.
    ///
    /// `h[..k]` receives the coefficients. Classical Gram-Schmidt with two passes over memory, and
    /// two more if cancellation would cost orthogonality.
    pub fn orthogonalise(&mut self, k: usize, w: &mut [f64], h: &mut [f64]) -> f64 {
        h[..k].fill(0.0);
        let mut coefficients = vec![0.0; k];
        let mut size = 0.0;
        for _ in 0..2 {
            self.sweep(k, w, &[], true);
            coefficients.copy_from_slice(&self.partial[1..=k]);
            let before = self.partial[0];
            for (h, c) in h.iter_mut().zip(&coefficients) {
                *h += c;
            }
            self.sweep(k, w, &coefficients, false);
            size = self.partial[0].sqrt();
            if size > MAX_CANCELLATION * before.sqrt() {
                break;
            }
        }
        size
    }

    /// `w <- sum_i c_i v_i` over the vectors from `first` on.
    pub(super) fn combine(&self, first: usize, c: &[f64], w: &mut [f64]) {
        for_each_chunk(w, &|start, w| {
            let here = start..start + w.len();
            w.fill(0.0);
            for (v, &c) in self.vectors[first..].iter().zip(c) {
                match v {
                    Vector::Double(v) => subtract(-c, &v[here.clone()], w),
                    Vector::Single(v) => subtract(-c, &v[here.clone()], w),
                }
            }
        });
    }

    /// Subtracts `sum_i c_i v_i` from `w`, then sums products.
    ///
    /// The first partial sums receive `w · w` and, if `products` is set, `v_i · w` for the first
    /// `k` vectors.
    fn sweep(&mut self, k: usize, w: &mut [f64], coefficients: &[f64], products: bool) {
        let (width, vectors, weights) = (k + 1, &self.vectors, self.weights);
        let tasks = w.len().div_ceil(ENTRIES_PER_TASK).max(1);
        self.partial.clear();
        self.partial.resize(width * tasks, 0.0);
        w.par_chunks_mut(ENTRIES_PER_TASK)
            .zip(self.partial.par_chunks_mut(width))
            .enumerate()
            .for_each(|(task, (w, sums))| {
                let mut weighted = [0.0; CHUNK];
                for (chunk, w) in w.chunks_mut(CHUNK).enumerate() {
                    let here = task * ENTRIES_PER_TASK + chunk * CHUNK
                        ..task * ENTRIES_PER_TASK + chunk * CHUNK + w.len();
                    for (v, &c) in vectors.iter().zip(coefficients) {
                        match v {
                            Vector::Double(v) => subtract(c, &v[here.clone()], w),
                            Vector::Single(v) => subtract(c, &v[here.clone()], w),
                        }
                    }
                    let dual = match weights {
                        None => &*w,
                        Some(weights) => {
                            let dual = &mut weighted[..w.len()];
                            for ((t, w), s) in dual.iter_mut().zip(&*w).zip(&weights[here.clone()])
                            {
                                *t = f64::from(*s) * w;
                            }
                            dual
                        }
                    };
                    sums[0] += lanes_dot(w, dual);
                    if products {
                        for (sum, v) in sums[1..].iter_mut().zip(vectors) {
                            *sum += match v {
                                Vector::Double(v) => lanes_dot(&v[here.clone()], dual),
                                Vector::Single(v) => lanes_dot(&v[here.clone()], dual),
                            };
                        }
                    }
                }
            });
        for task in 1..tasks {
            for i in 0..width {
                self.partial[i] += self.partial[task * width + i];
            }
        }
        if let Some(sum) = self.sum {
            sum(&mut self.partial[..width]);
        }
    }
}

/// `w <- w - c v`.
fn subtract<T: Copy + Into<f64>>(c: f64, v: &[T], w: &mut [f64]) {
    for (w, &v) in w.iter_mut().zip(v) {
        *w -= c * v.into();
    }
}

/// Calls `f(&mut a_i, &b_i)` for all `i`.
fn zip_chunks<A: Send, B: Sync>(a: &mut [A], b: &[B], f: impl Fn(&mut A, &B) + Sync) {
    for_each_chunk(a, &|start, a| {
        a.iter_mut().zip(&b[start..]).for_each(|(a, b)| f(a, b));
    });
}

/// A vector in f32, scaled by a power of two: half the memory of f64.
struct Rounded {
    scale: f64,
    values: Vec<f32>,
}

/// The preconditioned basis vectors.
///
/// Rounding counts as a part of the preconditioner: the operator is applied to the *rounded*
/// vector, and the solution is combined from the same rounded vectors, so no accuracy is lost.
/// Flexible GMRES admits any preconditioner.
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
        let inverse = scale.recip();
        vector.scale = scale;
        vector
            .values
            .par_chunks_mut(ENTRIES_PER_TASK)
            .zip(z.par_chunks_mut(ENTRIES_PER_TASK))
            .for_each(|(short, z)| {
                for (short, z) in short.iter_mut().zip(z) {
                    *short = (*z * inverse) as f32;
                    *z = f64::from(*short) * scale;
                }
            });
    }

    /// `x <- x + sum_j y_j z_j`.
    pub fn add_combination(&self, y: &[f64], x: &mut [f64]) {
        for_each_chunk(x, &|start, x| {
            for (vector, y) in self.vectors.iter().zip(y) {
                subtract(-y * vector.scale, &vector.values[start..], x);
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::axpy;

    /// Three vectors that differ in the ninth digit, orthogonalised one after the other.
    fn nearly_dependent(n: usize, weights: Option<&[f32]>, single: bool) -> Vec<Vec<f64>> {
        let mut basis = OrthonormalBasis::new(weights);
        let mut h = [0.0; 3];
        for j in 0..3 {
            let mut w: Vec<f64> = (0..n)
                .map(|i| 1.0 + 1e-9 * ((j * i) as f64).sin())
                .collect();
            let size = basis.orthogonalise(j, &mut w, &mut h);
            basis.store(j, &w, size, single && j > 0);
        }
        let mut buffer = vec![0.0; n];
        (0..3)
            .map(|j| basis.vector(j, &mut buffer).to_vec())
            .collect()
    }

    #[test]
    fn nearly_dependent_vectors_come_out_orthogonal() {
        let n = 70_001;
        let weights: Vec<f32> = (0..n).map(|i| 1.0 + (i % 7) as f32).collect();
        for (weights, single, rounding) in [
            (None, false, 1e-12),
            (Some(&weights[..]), false, 1e-12),
            (Some(&weights[..]), true, 1e-6),
        ] {
            let v = nearly_dependent(n, weights, single);
            let product = |a: &[f64], b: &[f64]| -> f64 {
                (0..n)
                    .map(|i| weights.map_or(1.0, |w| f64::from(w[i])) * a[i] * b[i])
                    .sum()
            };
            for (i, j) in [(0, 1), (0, 2), (1, 2)] {
                let overlap = product(&v[i], &v[j]);
                assert!(overlap.abs() < rounding, "{i} {j}: {overlap:e}");
            }
            assert!((product(&v[1], &v[1]) - 1.0).abs() < rounding);
        }
    }

    #[test]
    fn bases_are_bitwise_the_same_on_one_and_two_threads() {
        let on = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("a pool")
                .install(|| nearly_dependent(200_003, None, true))
        };
        assert!(on(1) == on(2));
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
