//! Operators and preconditioners without the properties that a method needs, or that they claim.
//!
//! Residuals are computed, so that a false claim never gives a wrong answer.

use super::support::{Method, noise, relative_difference, tolerance, true_residual};
use linalg::{
    Identity, LinalgError, LinearOperator, Preconditioner, PreconditionerKind, cg, fgmres, minres,
};
use nalgebra::{DMatrix, DVector};

#[test]
fn bug_minres_took_a_large_right_hand_side_for_a_singular_operator() {
    let mut x = [0.0; 2];
    let identity = Claims::new(DMatrix::identity(2, 2), true);
    let b = [3e40, 4e40];
    minres(&identity, &mut Identity(2), &b, &mut x, &tolerance(1e-8)).expect("one step");
    assert!(relative_difference(&x, &b) < 1e-14);
}

/// A dense operator that claims the properties a test gives it.
struct Claims {
    matrix: DMatrix<f64>,
    symmetric: bool,
    weights: Option<Vec<f32>>,
}

impl Claims {
    fn new(matrix: DMatrix<f64>, symmetric: bool) -> Self {
        Self {
            matrix,
            symmetric,
            weights: None,
        }
    }
}

impl LinearOperator for Claims {
    fn rows(&self) -> usize {
        self.matrix.nrows()
    }

    fn cols(&self) -> usize {
        self.matrix.ncols()
    }

    fn apply(&self, x: &[f64], y: &mut [f64]) {
        let product = &self.matrix * DVector::from_column_slice(x);
        y.copy_from_slice(product.as_slice());
    }

    fn residual_weights(&self) -> Option<&[f32]> {
        self.weights.as_deref()
    }

    fn is_symmetric(&self) -> bool {
        self.symmetric
    }
}

/// The norm that FGMRES minimises had converged and the Euclidean one had not. After the next
/// evaluation of both, a single step that raised the Euclidean norm was taken for stagnation. The
/// second half of the dofs hardly counts in the minimised norm, and lies outside the interval over
/// which it is minimised. Found with symmetry planes and two spheres a tenth of a radius apart in a
/// ball of radius 400.
#[test]
fn bug_fgmres_reported_stagnation_of_a_residual_outside_its_norm() {
    let half = 20;
    let seen = (0..half).map(|k| 1.0 + k as f64 / 19.0);
    let diagonal = seen.chain(std::iter::repeat_n(3.5, half)).collect();
    let operator = Claims {
        matrix: DMatrix::from_diagonal(&DVector::from_vec(diagonal)),
        symmetric: false,
        weights: Some([1.0, 1e-12].map(|w| vec![w; half]).concat()),
    };
    let b = vec![1.0; 2 * half];
    let mut x = vec![0.0; 2 * half];
    let report = fgmres(
        &operator,
        &mut Identity(2 * half),
        &b,
        &mut x,
        &tolerance(1e-8),
    );
    assert!(report.unwrap().true_rel_residual <= 1e-8);
}

/// `z = factor r`, claimed to be positive definite.
struct Multiple(usize, f64);

impl Preconditioner for Multiple {
    fn size(&self) -> usize {
        self.0
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        for (z, r) in z.iter_mut().zip(r) {
            *z = self.1 * r;
        }
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::PositiveDefinite
    }
}

#[test]
fn symmetric_methods_refuse_other_operators() {
    let rotation = DMatrix::from_row_slice(2, 2, &[0.0, -1.0, 1.0, 0.0]);
    let honest = Claims::new(rotation.clone(), false);
    for method in [cg as Method, minres] {
        let error = method(
            &honest,
            &mut Identity(2),
            &[1.0, 2.0],
            &mut [0.0; 2],
            &tolerance(1e-8),
        );
        assert!(matches!(error, Err(LinalgError::NotSymmetric { .. })));
    }
    let mut x = [0.0; 2];
    fgmres(
        &honest,
        &mut Identity(2),
        &[1.0, 2.0],
        &mut x,
        &tolerance(1e-8),
    )
    .expect("two steps");
    assert!(relative_difference(&x, &[2.0, -1.0]) < 1e-8);
}

/// False claims lead to an error or to the right answer, since residuals are computed.
#[test]
fn false_claims_never_give_wrong_answers() {
    let n = 30;
    let numbers = noise(n * n);
    let wild = DMatrix::from_fn(n, n, |i, j| {
        numbers[n * i + j] + if i == j { 4.0 } else { 0.0 }
    });
    let b = noise(n);
    for matrix in [
        wild.clone(),
        -wild,
        DMatrix::zeros(n, n),
        DMatrix::from_element(n, n, 1.0),
    ] {
        let liar = Claims::new(matrix, true);
        for method in [cg as Method, minres, fgmres] {
            for factor in [1.0, -1.0, 0.0, f64::NAN, 1e200, 1e-200] {
                let mut x = vec![0.0; n];
                let solved = method(
                    &liar,
                    &mut Multiple(n, factor),
                    &b,
                    &mut x,
                    &tolerance(1e-8),
                );
                assert!(solved.is_err() || true_residual(&liar, &b, &x) <= 1e-8);
                let is_nan = factor.is_nan();
                assert!(!is_nan || matches!(solved, Err(LinalgError::Breakdown { .. })));
            }
        }
    }
}

/// NaN that the operator returns.
#[test]
fn operators_that_return_nan_are_reported() {
    let operator = Claims::new(DMatrix::from_diagonal_element(3, 3, f64::NAN), true);
    for method in [cg as Method, minres, fgmres] {
        let mut x = [1.0; 3];
        let error = method(
            &operator,
            &mut Identity(3),
            &[1.0; 3],
            &mut x,
            &tolerance(1e-8),
        );
        assert!(matches!(error, Err(LinalgError::Breakdown { .. })));
    }
}
