//! Initial guesses from earlier solutions of similar systems.

use std::collections::VecDeque;
use std::sync::Arc;

use crate::csr::check_shape;
use crate::vector::{axpy, dot, for_each_chunk, norm, scale};
use crate::{LinalgError, LinearOperator};

/// Fraction of its length below which an orthogonalised product counts as dependent on the others.
///
/// Below this fraction a product would add only rounding errors: f64 leaves eight digits of the
/// coefficients.
const DEPENDENCE_TOLERANCE: f64 = 1e-8;

/// Initial guesses of *new* systems from the solutions of a few earlier ones.
///
/// The guess is the combination of solutions with the least residual.
///
/// For sequences of systems whose matrices and right-hand sides change little, such as time steps.
/// `min_c || b - A X c ||` over the last few solutions `X`, with the new `A` and `b`, gains several
/// digits, also where extrapolation in time fails. Method: Fischer, Comput. Methods Appl. Mech.
/// Engrg. 163 (1998), with the new matrix in place of the old one. Vectors with linearly dependent
/// products are omitted. The norm is that of the operator's
/// [weights](LinearOperator::residual_weights).
///
/// The tolerance of the solver must be relative to `||b||`, as in this crate: then the guess
/// affects the cost of a solve, and the answer only within the tolerance. A restarted run gives
/// *bitwise* the answers of an uninterrupted one if the checkpoint stores all digits of
/// [`solutions`](WarmStart::solutions) in their order, and [`remember`](WarmStart::remember)
/// receives them again.
///
/// Cost per stored solution: one product with `A` (several per pass,
/// [`LinearOperator::apply_columns`]) and one pass over the other solutions. Memory: 8 bytes per
/// dof and solution, another 16 while a guess is computed, and 8 per right-hand side. Clones share
/// the solutions.
///
/// ```
/// use linalg::{Bordered, Csr, LinearOperator, WarmStart};
/// let k = Csr::new((2, 2), vec![0, 2, 4], vec![0, 1, 0, 1], vec![2.0, -1.0, -1.0, 2.0]);
/// let a = Bordered::scalar(k)?;
/// let mut warm = WarmStart::new(3);
/// warm.remember(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
/// warm.remember(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
/// // A (4, 0, 0, 3, 0, 0) = (5, 0, 0, 2, 0, 0): a combination of the stored solutions
/// let mut x = [0.0; 6];
/// warm.guess(&a, &[5.0, 0.0, 0.0, 2.0, 0.0, 0.0], &mut x)?;
/// assert!((x[0] - 4.0).abs() < 1e-14 && (x[3] - 3.0).abs() < 1e-14);
/// # Ok::<(), linalg::LinalgError>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct WarmStart {
    capacity: usize,
    solutions: VecDeque<Arc<Vec<f64>>>,
}

impl WarmStart {
    /// Stores up to `capacity` solutions; five suffice for a smooth sequence, zero is a cold start.
    pub fn new(capacity: usize) -> Self {
        WarmStart {
            capacity,
            solutions: VecDeque::new(),
        }
    }

    /// Adds a solution and drops the oldest beyond the capacity.
    ///
    /// All are dropped if the number of dofs has changed, as on a new mesh. A solution that is not
    /// finite is ignored.
    pub fn remember(&mut self, solution: &[f64]) {
        if self
            .solutions
            .front()
            .is_some_and(|s| s.len() != solution.len())
        {
            self.solutions.clear();
        }
        if self.capacity == 0 || !solution.iter().all(|v| v.is_finite()) {
            return;
        }
        // reuse the memory of the oldest, unless a clone needs it
        let oldest = match self.solutions.len() == self.capacity {
            true => self.solutions.pop_front(),
            false => None,
        };
        let mut kept = oldest.and_then(Arc::into_inner).unwrap_or_default();
        kept.clear();
        kept.extend_from_slice(solution);
        self.solutions.push_back(Arc::new(kept));
    }

    /// Drops all solutions, as after remeshing, when dofs have another meaning.
    pub fn clear(&mut self) {
        self.solutions.clear();
    }

    /// The stored solutions, oldest first.
    pub fn solutions(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.solutions.iter().map(|solution| solution.as_slice())
    }

    /// Overwrites `x` with the guess and returns its relative residual `||b - A x|| / ||b||`.
    ///
    /// The guess is zero if no solution of this size is stored; the residual of `b = 0` is zero.
    ///
    /// Solutions are used newest first, so that old ones are omitted if they depend on newer ones.
    /// Bitwise the same on any number of threads.
    ///
    /// # Errors
    /// [`LinalgError::Shape`] if `b` or `x` do not fit the operator.
    pub fn guess(
        &self,
        operator: &dyn LinearOperator,
        b: &[f64],
        x: &mut [f64],
    ) -> Result<f64, LinalgError> {
        let residuals = self.guess_columns(operator, &[b], &mut [x])?;
        Ok(residuals.first().copied().unwrap_or_default())
    }

    /// Computes the guesses of [`WarmStart::guess`] for several right-hand sides, to the last bit.
    ///
    /// The right-hand sides share the products with `A`.
    ///
    /// # Errors
    /// Those of [`WarmStart::guess`]; [`LinalgError::Shape`] if the numbers of solutions and
    /// right-hand sides differ.
    pub fn guess_columns(
        &self,
        operator: &dyn LinearOperator,
        b: &[&[f64]],
        x: &mut [&mut [f64]],
    ) -> Result<Vec<f64>, LinalgError> {
        let n = operator.rows();
        check_shape("operator (columns)", (operator.cols(), 1), (n, 1))?;
        check_shape("solutions", (x.len(), 1), (b.len(), 1))?;
        // residual and products in the operator's norm: rows times square roots of weights
        let weights = operator.residual_weights();
        let mut columns = Vec::with_capacity(b.len());
        for (b, x) in b.iter().zip(x) {
            check_shape("right-hand side", (b.len(), 1), (n, 1))?;
            check_shape("solution vector", (x.len(), 1), (n, 1))?;
            x.fill(0.0);
            let mut residual = b.to_vec();
            scale_rows(weights, &mut residual);
            let norm_b = norm(&residual);
            let is_open = norm_b > 0.0 && norm_b.is_finite();
            columns.push((is_open.then_some(norm_b), residual, &mut **x));
        }
        if columns.iter().any(|(norm_b, ..)| norm_b.is_some()) {
            for (direction, product) in self.basis(operator) {
                for (_, residual, x) in columns.iter_mut().filter(|column| column.0.is_some()) {
                    let c = dot(&product, residual);
                    axpy(-c, &product, residual);
                    axpy(c, &direction, x);
                }
            }
        }
        let relative = |(norm_b, residual, _): (Option<f64>, Vec<f64>, _)| {
            norm_b.map_or(0.0, |norm_b| norm(&residual) / norm_b)
        };
        Ok(columns.into_iter().map(relative).collect())
    }

    /// Pairs `(u, A u)` with orthonormal `A u` that span the solutions (modified Gram-Schmidt).
    fn basis(&self, operator: &dyn LinearOperator) -> Vec<(Vec<f64>, Vec<f64>)> {
        let n = operator.rows();
        let weights = operator.residual_weights();
        let newest_first = self.solutions.iter().rev();
        let solutions: Vec<&[f64]> = (newest_first.filter(|s| s.len() == n))
            .map(|solution| solution.as_slice())
            .collect();
        let mut products = vec![vec![0.0; n]; solutions.len()];
        let mut into: Vec<_> = products.iter_mut().map(Vec::as_mut_slice).collect();
        operator.apply_columns(&solutions, &mut into);
        let mut basis: Vec<(Vec<f64>, Vec<f64>)> = Vec::with_capacity(solutions.len());
        for (solution, mut product) in solutions.into_iter().zip(products) {
            let mut direction = solution.to_vec();
            scale_rows(weights, &mut product);
            let before = norm(&product);
            // twice is enough (Giraud, Langou, Rozloznik 2005)
            for _ in 0..2 {
                for (other, image) in &basis {
                    let c = -dot(image, &product);
                    axpy(c, image, &mut product);
                    axpy(c, other, &mut direction);
                }
            }
            let size = norm(&product);
            if !(size > DEPENDENCE_TOLERANCE * before && size.is_finite()) {
                continue;
            }
            for vector in [&mut direction, &mut product] {
                scale(size.recip(), vector);
            }
            basis.push((direction, product));
        }
        basis
    }
}

/// `y_i <- w_i^(1/2) y_i`.
fn scale_rows(weights: Option<&[f32]>, y: &mut [f64]) {
    if let Some(weights) = weights {
        for_each_chunk(y, &|start, y| {
            for (y, w) in y.iter_mut().zip(&weights[start..]) {
                *y *= f64::from(*w).sqrt();
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Bordered, Csr};

    /// A diagonal operator with `3 diagonal.len()` dofs.
    fn operator(diagonal: &[f64]) -> Bordered {
        let n = diagonal.len();
        let (starts, columns) = ((0..=n).collect(), (0..n as u32).collect());
        Bordered::scalar(Csr::new((n, n), starts, columns, diagonal.to_vec())).expect("positive")
    }

    fn vector(n: usize, seed: f64) -> Vec<f64> {
        (0..3 * n)
            .map(|i| ((i as f64 + 1.0) * seed).sin())
            .collect()
    }

    #[test]
    fn the_guess_has_the_smallest_residual() {
        let n = 40;
        let a = operator(&(0..n).map(|i| 1.0 + i as f64).collect::<Vec<_>>());
        let b = vector(n, 0.7);
        let mut warm = WarmStart::new(4);
        for seed in [0.11, 0.23, 0.31] {
            warm.remember(&vector(n, seed));
        }
        let mut x = vec![0.0; 3 * n];
        let relative = warm.guess(&a, &b, &mut x).expect("sizes fit");
        let mut r = vec![0.0; 3 * n];
        a.apply(&x, &mut r);
        crate::vector::subtract_from(&b, &mut r);
        assert!((dot(&r, &r) / dot(&b, &b)).sqrt() - relative < 1e-12 && relative < 1.0);
        // the residual is orthogonal to every product
        for solution in warm.solutions() {
            let mut product = vec![0.0; 3 * n];
            a.apply(solution, &mut product);
            let overlap = dot(&product, &r).abs();
            assert!(overlap < 1e-12 * (dot(&product, &product) * dot(&b, &b)).sqrt());
        }
    }

    #[test]
    fn dependent_solutions_are_harmless_and_the_oldest_is_forgotten() {
        let n = 30;
        let a = operator(&vec![2.0; n]);
        let x = vector(n, 0.4);
        let b: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
        let mut warm = WarmStart::new(3);
        warm.remember(&vector(n, 0.9));
        for factor in [1.0, -3.0, 1.0 + 1e-13] {
            warm.remember(&x.iter().map(|x| factor * x).collect::<Vec<_>>());
        }
        assert_eq!(warm.solutions().len(), 3);
        let mut guess = vec![0.0; 3 * n];
        let relative = warm.guess(&a, &b, &mut guess).expect("sizes fit");
        assert!(relative < 1e-14);
        let difference = guess.iter().zip(&x).map(|(a, b)| (a - b).abs());
        assert!(difference.fold(0.0, f64::max) < 1e-14);
    }

    #[test]
    fn no_memory_is_a_cold_start_and_other_sizes_are_forgotten() {
        let n = 10;
        let (a, b) = (operator(&vec![1.0; n]), vector(n, 0.3));
        let mut x = vec![5.0; 3 * n];
        let mut none = WarmStart::new(0);
        none.remember(&b);
        assert_eq!(none.guess(&a, &b, &mut x).expect("sizes fit"), 1.0);
        assert!(x.iter().all(|v| *v == 0.0));
        let mut warm = WarmStart::new(2);
        warm.remember(&[1.0; 12]);
        assert_eq!(warm.guess(&a, &b, &mut x).expect("sizes fit"), 1.0);
        assert!(warm.guess(&a, &b[1..], &mut x).is_err());
        warm.remember(&b);
        warm.remember(&vec![f64::NAN; 3 * n]);
        assert_eq!(warm.solutions().len(), 1);
        assert_eq!(
            warm.guess(&a, &vec![0.0; 3 * n], &mut x).expect("zero"),
            0.0
        );
    }

    #[test]
    fn clones_share_solutions_and_remember_their_own() {
        let mut warm = WarmStart::new(2);
        warm.remember(&[1.0; 3]);
        warm.remember(&[2.0; 3]);
        let mut other = warm.clone();
        let addresses =
            |warm: &WarmStart| -> Vec<_> { warm.solutions().map(<[f64]>::as_ptr).collect() };
        assert_eq!(addresses(&warm), addresses(&other));
        other.remember(&[3.0; 3]);
        let firsts = |warm: &WarmStart| -> Vec<f64> {
            warm.solutions().map(|solution| solution[0]).collect()
        };
        assert_eq!(
            (firsts(&warm), firsts(&other)),
            (vec![1.0, 2.0], vec![2.0, 3.0])
        );
    }

    #[test]
    fn guesses_for_several_right_hand_sides_are_those_of_each_alone() {
        let n = 40;
        let a = operator(&(0..n).map(|i| 1.0 + i as f64).collect::<Vec<_>>());
        let mut warm = WarmStart::new(4);
        for seed in [0.11, 0.23, 0.31] {
            warm.remember(&vector(n, seed));
        }
        let b = [vector(n, 0.7), vec![0.0; 3 * n], vector(n, 0.5)];
        let b: Vec<&[f64]> = b.iter().map(Vec::as_slice).collect();
        let mut x = vec![vec![1.0; 3 * n]; 3];
        let mut columns: Vec<_> = x.iter_mut().map(Vec::as_mut_slice).collect();
        let relative = warm.guess_columns(&a, &b, &mut columns).expect("they fit");
        assert!(warm.guess_columns(&a, &b, &mut columns[1..]).is_err());
        for ((b, x), relative) in b.iter().zip(&x).zip(relative) {
            let mut alone = vec![2.0; 3 * n];
            assert_eq!(warm.guess(&a, b, &mut alone), Ok(relative));
            assert_eq!(*x, alone);
        }
    }

    #[test]
    fn guesses_are_bitwise_the_same_on_one_and_two_threads() {
        let n = 20_000;
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            pool.expect("a pool").install(|| {
                let a = operator(&(0..n).map(|i| 1.0 + (i % 9) as f64).collect::<Vec<_>>());
                let mut warm = WarmStart::new(3);
                (1..4).for_each(|k| warm.remember(&vector(n, 0.1 * k as f64)));
                let mut x = vec![0.0; 3 * n];
                let relative = warm.guess(&a, &vector(n, 0.77), &mut x).expect("sizes fit");
                (relative.to_bits(), x)
            })
        };
        assert!(on(1) == on(2));
    }
}
