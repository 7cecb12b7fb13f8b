//! Singular systems whose null space is given.

use linalg::{
    BlockDiagonal, BlockTriangular, Csr, CsrOperator, Identity, LinalgError, LinearOperator,
    MultigridParams, NullVectors, Preconditioner, ScalarMultigrid, cg, fgmres, minres,
};
use sprs::TriMatI;

use super::support::{
    Method, Stokes, body_forces, cube, dot, noise, relative_difference, tolerance, true_residual,
};

/// The seven-point Laplacian of a cube of `n^3` cells with Neumann conditions on the whole
/// boundary.
fn neumann(n: usize) -> CsrOperator {
    let index = |p: [usize; 3]| (p[0] * n + p[1]) * n + p[2];
    let mut k = TriMatI::<f64, u32>::new((n * n * n, n * n * n));
    for i in 0..n * n * n {
        let p = [i / (n * n), i / n % n, i % n];
        for d in 0..3 {
            if p[d] + 1 < n {
                let mut next = p;
                next[d] += 1;
                let j = index(next);
                for (row, col, value) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                    k.add_triplet(row, col, value);
                }
            }
        }
    }
    CsrOperator::new(k.to_csr()).expect("finite")
}

fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len() as f64
}

/// 4913 dofs; CG reached 3.4e-3 in 300 iterations without the null space.
#[test]
fn a_pure_neumann_poisson_problem_is_solved() {
    for n in [17, 34] {
        let a = neumann(n);
        // a right-hand side with a tenth of its length along the constants
        let mut b = noise(a.rows());
        let shift = mean(&b);
        b.iter_mut().for_each(|b| *b -= shift);
        let size = (dot(&b, &b) / b.len() as f64).sqrt();
        b.iter_mut().for_each(|b| *b += 0.1 * size);
        let params =
            MultigridParams::default().with_coarsest_shift(MultigridParams::SINGULAR_SHIFT);
        let mut amg = ScalarMultigrid::new(&a, &params).expect("shifted");
        let krylov =
            tolerance(1e-10).with_null_vectors(NullVectors::constant(a.rows()).expect("in memory"));
        for method in [cg as Method, minres, fgmres] {
            let mut x = vec![1.0; b.len()];
            let report = method(&a, &mut amg, &b, &mut x, &krylov).expect("convergence");
            println!("{n}^3: {} iterations", report.iterations);
            assert!(report.iterations <= 30, "{}", report.iterations);
            let removed = 0.1 / 1.01_f64.sqrt();
            assert!((report.rhs_removed - removed).abs() < 1e-12);
            assert!(mean(&x).abs() < 1e-12 * dot(&x, &x).sqrt());
            let projected: Vec<f64> = b.iter().map(|b| b - 0.1 * size).collect();
            assert!(true_residual(&a, &projected, &x) <= 1.01e-10);
        }
    }
}

/// Velocities interpolated on the boundary leave a small net flux, and no pressure balances it.
#[test]
fn enclosed_flow_with_interpolated_boundary_data_is_solved() {
    let stokes = Stokes::new(5, &[cube([2; 3], 1)], 5.0);
    let system = &stokes.system;
    let mut b = body_forces(system);
    b[system.pressure_range()].fill(1e-4);
    let params = tolerance(1e-8);
    let null_vectors =
        NullVectors::constant_on(system.rows(), system.pressure_range()).expect("a range");
    let singular = params.clone().with_null_vectors(null_vectors);
    let mut triangular = BlockTriangular::with_prolongation(system, &stokes.prolongation);
    let triangular = triangular.as_mut().expect("set-up");
    let mut diagonal = BlockDiagonal::with_prolongation(system, &stokes.prolongation);
    let diagonal = diagonal.as_mut().expect("set-up");
    let solvers: [(Method, &mut dyn Preconditioner); 2] =
        [(fgmres, triangular), (minres, diagonal)];
    let mut flows = Vec::new();
    for (method, preconditioner) in solvers {
        let mut x = vec![0.0; b.len()];
        let error = method(system, preconditioner, &b, &mut x, &params).expect_err("no solution");
        assert!(
            matches!(
                error,
                LinalgError::Stagnated { .. } | LinalgError::NotConverged { .. }
            ),
            "{error}"
        );
        x.fill(0.0);
        let report = method(system, preconditioner, &b, &mut x, &singular).expect("projected");
        let flux: Vec<f64> = b[system.pressure_range()].to_vec();
        let removed = (dot(&flux, &flux) / dot(&b, &b)).sqrt();
        assert!((report.rhs_removed / removed - 1.0).abs() < 1e-10);
        let pressure = &x[system.pressure_range()];
        assert!(mean(pressure).abs() < 1e-12 * dot(pressure, pressure).sqrt());
        flows.push(x);
    }
    assert!(relative_difference(&flows[1], &flows[0]) < 1e-5);
}

/// `A = u v^T` complement: null vectors of `A` and of its transpose that differ.
#[test]
fn left_null_vectors_may_differ() {
    // [1 -1; 2 -2] has the null vector (1, 1) and the left null vector (2, -1)
    let matrix = Csr::new(
        (2, 2),
        vec![0, 2, 4],
        vec![0, 1, 0, 1],
        vec![1.0, -1.0, 2.0, -2.0],
    );
    let a = CsrOperator::new(matrix).expect("finite");
    let null_vectors = NullVectors::new(vec![vec![1.0, 1.0]]).expect("independent");
    let null_vectors = null_vectors
        .with_left(vec![vec![2.0, -1.0]])
        .expect("independent");
    let params = tolerance(1e-12).with_null_vectors(null_vectors);
    let mut x = [0.0; 2];
    // (1, 2) plus the left null vector
    let report = fgmres(&a, &mut Identity(2), &[3.0, 1.0], &mut x, &params).expect("projected");
    assert!(relative_difference(&x, &[0.5, -0.5]) < 1e-12);
    assert!((report.rhs_removed - 0.5_f64.sqrt()).abs() < 1e-14);
}

#[test]
fn a_right_hand_side_inside_the_null_space_has_the_zero_solution() {
    let a = neumann(3);
    let params = tolerance(1e-8).with_null_vectors(NullVectors::constant(27).expect("in memory"));
    let mut x = noise(27);
    let report = cg(&a, &mut Identity(27), &[0.7; 27], &mut x, &params).expect("zero");
    assert!(report.iterations == 0 && (report.rhs_removed - 1.0).abs() < 1e-14);
    assert_eq!(x, [0.0; 27]);
}

#[test]
fn vectors_that_are_not_null_vectors_are_refused() {
    let a = neumann(3);
    let mut slope = vec![1.0; 27];
    slope[0] = 2.0;
    let slope = NullVectors::new(vec![slope]).expect("independent");
    let mut x = vec![0.0; 27];
    let params = tolerance(1e-8).with_null_vectors(slope);
    let error = cg(&a, &mut Identity(27), &noise(27), &mut x, &params).expect_err("no null vector");
    assert!(
        matches!(error, LinalgError::NotNullVector { index: 0, .. }),
        "{error}"
    );
    let params = tolerance(1e-8).with_null_vectors(NullVectors::constant(26).expect("in memory"));
    let error = cg(&a, &mut Identity(27), &noise(27), &mut x, &params).expect_err("too short");
    assert!(matches!(error, LinalgError::Shape { .. }), "{error}");
}
