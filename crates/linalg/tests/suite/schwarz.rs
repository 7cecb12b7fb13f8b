//! Additive Schwarz: solutions, iteration counts and failures.

use super::support::{
    assert_same_on_one_and_two_threads, assert_velocities_agree, body_forces, direct_solution,
    linked_pair, one_body, tolerance, true_residual, two_bodies, with_border,
};
use linalg::{BorderPlacement, LinalgError, SaddleSystem, Schwarz, SchwarzParams, fgmres, minres};

fn solve(system: &SaddleSystem, b: &[f64], params: &SchwarzParams, tol: f64) -> (Vec<f64>, usize) {
    let mut pre = Schwarz::new(system, params).expect("set-up");
    let mut x = vec![0.0; b.len()];
    let report = fgmres(system, &mut pre, b, &mut x, &tolerance(tol)).expect("convergence");
    assert!(true_residual(system, b, &x) <= tol);
    (x, report.iterations)
}

fn cut(subdomains: usize, overlap: usize) -> SchwarzParams {
    SchwarzParams::default()
        .with_subdomains(subdomains)
        .with_overlap(overlap)
}

/// Definite borders, and indefinite ones with multipliers.
#[test]
fn agrees_with_the_direct_solver() {
    let plain = two_bodies(1).system;
    let constrained = linked_pair().1;
    for system in [plain, constrained] {
        let b = body_forces(&system);
        let (x, iterations) = solve(&system, &b, &cut(3, 1), 1e-11);
        println!("{iterations} iterations");
        assert_velocities_agree(&system, &x, &direct_solution(&system, &b), 1e-9);
    }
}

/// One subdomain is the direct solver up to its shift and the rounding errors of f32.
#[test]
fn one_subdomain_is_the_direct_solver() {
    let system = two_bodies(1).system;
    let b = body_forces(&system);
    assert!(solve(&system, &b, &cut(1, 0), 1e-10).1 <= 6);
}

#[test]
fn overlap_saves_iterations_and_subdomains_cost_them() {
    let system = one_body(2).system;
    let b = body_forces(&system);
    let count = |subdomains, overlap| solve(&system, &b, &cut(subdomains, overlap), 1e-6).1;
    let (thin, thick, many) = (count(4, 0), count(4, 2), count(16, 2));
    println!("4 subdomains: {thin} without overlap, {thick} with two layers; 16: {many}");
    assert!(thick < thin && many >= thick);
}

/// A multiplier in a subdomain without its bodies has a zero row there.
#[test]
fn multipliers_without_their_bodies_are_reported() {
    let system = linked_pair().1;
    let m = system.border_range().len();
    let apart: Vec<usize> = (0..m).map(|c| usize::from(c >= 12)).collect();
    let params = |to: Vec<usize>| cut(2, 1).with_border(BorderPlacement::Assigned(to));
    let error = Schwarz::new(&system, &params(apart)).map(|_| ());
    let Err(LinalgError::Subdomain {
        subdomain: 1,
        cause,
    }) = &error
    else {
        panic!("{error:?}");
    };
    assert!(cause.to_string().contains("border dof 12"), "{cause}");
    // together with its bodies it is solved for
    let b = body_forces(&system);
    let together = solve(&system, &b, &params(vec![0; m]), 1e-8).1;
    let eliminated = solve(&system, &b, &cut(2, 1), 1e-8).1;
    println!("{together} with the border in one subdomain, {eliminated} eliminated");
    assert!(eliminated <= together);
}

/// Rows that differ from columns, as for bodies whose force rows are replaced.
#[test]
fn nonsymmetric_borders_are_solved() {
    let stokes = two_bodies(1);
    let corner = stokes.system.velocity_block().corner() * 1.1;
    let system = with_border(&stokes, corner, Some(1.1)).expect("a sound system");
    solve(&system, &body_forces(&system), &cut(4, 1), 1e-9);
}

#[test]
fn unsuitable_input_is_refused() {
    let system = two_bodies(1).system;
    let set_up = |params: &SchwarzParams| Schwarz::new(&system, params).map(|_| ());
    let none = set_up(&cut(0, 1));
    assert!(matches!(
        none,
        Err(LinalgError::Parameter {
            name: "subdomains",
            ..
        })
    ));
    let assigned = |to| cut(2, 1).with_border(BorderPlacement::Assigned(to));
    let short = set_up(&assigned(vec![0]));
    assert!(matches!(short, Err(LinalgError::Shape { .. })));
    let outside = set_up(&assigned(vec![2; 12]));
    assert!(matches!(outside, Err(LinalgError::Parameter { .. })));
    let mut pre = Schwarz::new(&system, &cut(2, 1)).expect("set-up");
    let b = body_forces(&system);
    let mut x = vec![0.0; b.len()];
    let symmetric = minres(&system, &mut pre, &b, &mut x, &tolerance(1e-8));
    assert!(matches!(
        symmetric,
        Err(LinalgError::UnsuitablePreconditioner { .. })
    ));
}

/// More subdomains than nodes: some are empty.
#[test]
fn empty_subdomains_are_allowed() {
    let system = one_body(1).system;
    let b = body_forces(&system);
    let vertices = system.velocity_block().nodes() + system.pressure_range().len();
    solve(&system, &b, &cut(vertices + 3, 1), 1e-8);
}

#[test]
fn bitwise_the_same_on_one_and_two_threads() {
    let system = two_bodies(1).system;
    let b = body_forces(&system);
    assert_same_on_one_and_two_threads(|| solve(&system, &b, &cut(4, 1), 1e-6).0);
}
