//! Inf-sup constants of systems with known spectra, and the reports of solvers.

use linalg::{Bordered, Csr, Csr3, InfSup, LinalgError, LinearOperator, SaddleLdlt, SaddleSystem};

use super::support::system::{body_forces, one_body};

/// One node with the stiffness `k`, and pressures with the mass `m` whose divergence is one row
/// each.
fn one_node(k: f64, m: f64, rows: &[[f64; 3]]) -> SaddleSystem {
    let n = rows.len();
    let diagonal = |value: f64, n: usize| {
        Csr::new(
            (n, n),
            (0..=n).collect(),
            (0..n as u32).collect(),
            vec![value; n],
        )
    };
    let divergence = Csr3::new((n, 1), (0..=n).collect(), vec![0; n], rows.to_vec());
    let velocity = Bordered::scalar(diagonal(k, 1)).unwrap();
    let border = Csr::zero((n, 0));
    SaddleSystem::new(velocity, divergence, border, None, diagonal(m, n)).unwrap()
}

#[test]
fn inf_sup_constants_are_roots_of_the_eigenvalues_of_the_schur_complement() {
    // B K^-1 B^T / M = diag(1, 4, 9) / (k m).
    let rows = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
    let found = InfSup::of(&one_node(2.0, 8.0, &rows)).unwrap();
    assert!((found.constant - 1.0 / 4.0).abs() < 1e-14, "{found:?}");
    assert!((found.largest - 3.0 / 4.0).abs() < 1e-14, "{found:?}");
    assert_eq!(found.null_space_dimension, 0);
    found.require(0.24).unwrap();
    let refused = found.require(0.26).unwrap_err();
    assert!(matches!(
        refused,
        LinalgError::NotInfSupStable { least: 0.26, .. }
    ));

    // A pressure without divergence is the constant one of enclosed flow, a second is spurious.
    let found = InfSup::of(&one_node(2.0, 8.0, &[rows[1], [0.0; 3], rows[2]])).unwrap();
    assert_eq!(found.null_space_dimension, 1);
    assert!((found.constant - 2.0 / 4.0).abs() < 1e-14, "{found:?}");
    let found = InfSup::of(&one_node(2.0, 8.0, &[[0.0; 3], [0.0; 3], rows[2]])).unwrap();
    assert_eq!(found.null_space_dimension, 2);
    assert!(
        found.constant < 1e-7 && found.require(1e-6).is_err(),
        "{found:?}"
    );
}

#[test]
fn reports_of_the_direct_solver_are_those_of_its_solution() {
    let system = one_body(1).system;
    let b = body_forces(&system);
    let mut x = vec![0.0; b.len()];
    let mut factor = SaddleLdlt::factor(&system, &Default::default()).unwrap();
    // The factor has at least the diagonal, in numbers of four bytes.
    assert!(factor.nnz() > system.rows());
    assert!(factor.bytes() >= 4 * factor.nnz());
    let report = factor.solve(&b, &mut x).unwrap();
    let mut product = vec![0.0; b.len()];
    system.apply(&x, &mut product);
    let norm = |v: &mut dyn Iterator<Item = f64>| v.map(|x| x * x).sum::<f64>().sqrt();
    let residual = norm(&mut b.iter().zip(&product).map(|(b, p)| b - p));
    let residual = residual / norm(&mut b.iter().copied());
    // Rounding of the products is of the size of the residual itself.
    assert!(residual <= 1e-14, "{residual:e}");
    assert!(
        (report.true_rel_residual - residual).abs() <= 2e-15,
        "{report:?} {residual:e}"
    );
    // Iterations, the start, and a step of polishing.
    assert_eq!(report.history.len(), report.iterations + 1);
    assert_eq!(report.history.last(), Some(&report.true_rel_residual));
}
