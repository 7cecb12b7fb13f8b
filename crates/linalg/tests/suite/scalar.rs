//! One-component systems: a sparse matrix as an operator, and multigrid for it.

use linalg::{
    Bordered, Csr, CsrOperator, LinalgError, LinearOperator, Multigrid, MultigridParams,
    Preconditioner, ScalarMultigrid, cg, fgmres, minres,
};

use super::support::{coarse_stiffness, noise, one_body, relative_difference, tolerance};

/// Every symmetric method solves the P1 stiffness matrix in about as many iterations as for three
/// components at once.
#[test]
fn a_scalar_problem_is_one_problem() {
    let k = coarse_stiffness(&one_body(4));
    let a = CsrOperator::new(k.clone()).expect("finite");
    let mut amg = ScalarMultigrid::new(&a, &MultigridParams::default()).expect("positive definite");
    let b = noise(a.rows());
    let mut solutions = Vec::new();
    for method in [cg, minres, fgmres] {
        let mut x = vec![0.0; b.len()];
        let report = method(&a, &mut amg, &b, &mut x, &tolerance(1e-10)).expect("convergence");
        assert!(report.iterations <= 20, "{}", report.iterations);
        solutions.push(x);
    }
    for x in &solutions[1..] {
        assert!(relative_difference(x, &solutions[0]) < 1e-8);
    }
}

/// The scalar cycle is the first component of the cycle for three.
#[test]
fn the_scalar_cycle_is_a_component_of_the_other() {
    let k = coarse_stiffness(&one_body(2));
    let params = MultigridParams::default().with_coarsest_nodes(50);
    let a = CsrOperator::new(k.clone()).expect("finite");
    let mut scalar = ScalarMultigrid::new(&a, &params).expect("positive definite");
    let three = Bordered::scalar(k).expect("positive");
    let mut three = Multigrid::new(&three, &params).expect("positive definite");
    let r = noise(a.rows());
    let mut z = vec![0.0; r.len()];
    scalar.apply(&r, &mut z);
    let interleaved: Vec<f64> = r.iter().flat_map(|&r| [r, 0.0, 0.0]).collect();
    let mut y = vec![0.0; interleaved.len()];
    three.apply(&interleaved, &mut y);
    let first: Vec<f64> = y.iter().step_by(3).copied().collect();
    assert_eq!(z, first);
    assert_eq!(scalar.level_sizes(), three.level_sizes());
}

#[test]
fn nonsymmetric_matrices_are_refused_by_multigrid() {
    let matrix = Csr::new((2, 2), vec![0, 2, 3], vec![0, 1, 1], vec![2.0, 1.0, 2.0]);
    let a = CsrOperator::new(matrix).expect("finite");
    assert!(!a.is_symmetric());
    let refused = ScalarMultigrid::new(&a, &MultigridParams::default()).map(|_| ());
    assert!(matches!(refused, Err(LinalgError::NotSymmetric { .. })));
}
