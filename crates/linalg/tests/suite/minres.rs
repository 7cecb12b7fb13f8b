//! MINRES with the block-diagonal preconditioner, compared with the direct solver.

use super::support::{
    assert_same_on_one_and_two_threads, assert_velocities_agree, body_forces, chained,
    direct_solution, dot, linked_pair, noise, one_body, prolongation_for, three_spheres, tolerance,
    true_residual, two_bodies, with_border,
};
use linalg::{
    BlockDiagonal, LinalgError, LinearOperator, Multigrid, MultigridParams, Preconditioner,
    PreconditionerKind, Prolongation, SaddleSystem, minres,
};

fn solve(
    system: &SaddleSystem,
    prolongation: &Prolongation,
    b: &[f64],
    rel_tol: f64,
) -> (Vec<f64>, usize) {
    let mut pre = BlockDiagonal::with_prolongation(system, prolongation).expect("set-up");
    let mut x = vec![0.0; b.len()];
    let report = minres(system, &mut pre, b, &mut x, &tolerance(rel_tol)).expect("convergence");
    assert!(true_residual(system, b, &x) <= rel_tol);
    (x, report.iterations)
}

/// Definite borders, and borders with multipliers, to the accuracy of the direct solver.
#[test]
fn agrees_with_the_direct_solver() {
    let plain = two_bodies(1);
    let (stokes, constrained) = linked_pair();
    let prolongation = prolongation_for(&stokes, constrained.border_range().len());
    for (system, prolongation) in [
        (&plain.system, &plain.prolongation),
        (&constrained, &prolongation),
    ] {
        let b = body_forces(system);
        let (x, iterations) = solve(system, prolongation, &b, 1e-11);
        println!("{iterations} iterations");
        assert_velocities_agree(system, &x, &direct_solution(system, &b), 1e-9);
    }
}

/// Other meshes took 60 to 75 iterations to 1e-8 in another norm.
#[test]
fn iterations_are_flat_under_refinement() {
    let [coarse, fine] = [one_body(2), one_body(4)]
        .map(|s| solve(&s.system, &s.prolongation, &body_forces(&s.system), 1e-8).1);
    println!("{coarse} at 10 000 dofs, {fine} at 92 000");
    assert!(fine <= coarse + coarse / 5 && fine <= 100);
}

/// Eigenvalues near 1 and -1 instead of 1 cost at most a factor of two: MINRES then acts as CG on
/// the square of the operator.
#[test]
fn three_spheres_with_and_without_multipliers() {
    let stokes = three_spheres(0.3, 0.3);
    let plain = &stokes.system;
    let constrained = with_border(&stokes, chained(plain.velocity_block().corner()), None);
    let constrained = constrained.expect("a sound system");
    let prolongation = prolongation_for(&stokes, constrained.border_range().len());
    let start = std::time::Instant::now();
    let (_, without) = solve(plain, &stokes.prolongation, &body_forces(plain), 1e-8);
    let between = start.elapsed();
    let (_, with) = solve(
        &constrained,
        &prolongation,
        &body_forces(&constrained),
        1e-8,
    );
    println!(
        "{without} without ({between:.1?}), {with} with multipliers ({:.1?})",
        start.elapsed() - between
    );
    assert!(without <= 100 && with <= 2 * without);
}

/// `<N x, y> = <x, N y>` up to the rounding errors of the cycle in f32, and `<x, N x> > 0`, though
/// the border makes the system indefinite.
#[test]
fn the_preconditioner_is_positive_definite_with_multipliers() {
    let (stokes, constrained) = linked_pair();
    let prolongation = prolongation_for(&stokes, constrained.border_range().len());
    let mut pre = BlockDiagonal::with_prolongation(&constrained, &prolongation).expect("set-up");
    assert_eq!(pre.kind(), PreconditionerKind::PositiveDefinite);
    let x = noise(constrained.rows());
    let y: Vec<f64> = x.iter().map(|v| (3.0 * v + 0.5).cos()).collect();
    let [mut nx, mut ny] = [(); 2].map(|()| vec![0.0; x.len()]);
    pre.apply(&x, &mut nx);
    pre.apply(&y, &mut ny);
    let size = (dot(&x, &nx) * dot(&y, &ny)).sqrt();
    let defect = (dot(&nx, &y) - dot(&x, &ny)).abs();
    // as for the cycle alone: about ten roundings per level on the way down and up, three levels
    assert!(
        defect < 60.0 * f64::from(f32::EPSILON) * size,
        "{defect:e} {size:e}"
    );
    // an indefinite inverse would show in a vector of multipliers
    let mut multipliers = vec![0.0; x.len()];
    multipliers[constrained.border_range()][12..].fill(1.0);
    pre.apply(&multipliers, &mut nx);
    assert!(dot(&multipliers, &nx) > 0.0 && dot(&x, &x) > 0.0);
}

#[test]
fn unsuitable_input_is_refused() {
    let (stokes, constrained) = linked_pair();
    let plain = stokes.system.velocity_block().corner();
    let nonsymmetric = with_border(&stokes, plain * 1.1, Some(1.1)).expect("a sound system");
    let refusal = BlockDiagonal::with_prolongation(&nonsymmetric, &stokes.prolongation).map(|_| ());
    assert!(matches!(refusal, Err(LinalgError::NotSymmetric { .. })));
    // a corner that is not symmetric is refused like a left border
    let mut tilted = plain.clone();
    tilted[(0, 1)] += 1.0;
    let tilted = with_border(&stokes, tilted, None).expect("a sound system");
    assert!(!tilted.is_symmetric());
    // the exact inverse of an indefinite border is refused
    let params = MultigridParams::default();
    let prolongation = prolongation_for(&stokes, constrained.border_range().len());
    let cycle =
        Multigrid::with_prolongation(constrained.velocity_block(), &prolongation, None, &params);
    let refusal = BlockDiagonal::new(&constrained, cycle.expect("set-up")).map(|_| ());
    assert!(matches!(
        refusal,
        Err(LinalgError::UnsuitablePreconditioner { .. })
    ));
    // the method refuses as well, with any preconditioner
    let b = body_forces(&nonsymmetric);
    let mut x = vec![0.0; b.len()];
    let error = minres(
        &nonsymmetric,
        &mut linalg::Identity(b.len()),
        &b,
        &mut x,
        &tolerance(1e-8),
    );
    assert!(matches!(
        error,
        Err(LinalgError::NotSymmetric { method: "MINRES" })
    ));
}

#[test]
fn bitwise_the_same_on_one_and_two_threads() {
    let stokes = two_bodies(1);
    let b = body_forces(&stokes.system);
    assert_same_on_one_and_two_threads(|| solve(&stokes.system, &stokes.prolongation, &b, 1e-6).0);
}
