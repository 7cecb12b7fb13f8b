//! Single components constrained to zero: solutions, convergence, and methods that refuse them.

use super::support::{
    Stokes, body_forces, noise, one_body, relative_difference, tolerance, true_residual,
};
use linalg::{
    BlockDiagonal, BlockTriangular, Bordered, Csr, LinalgError, LinearOperator, Multigrid,
    MultigridParams, SaddleLdlt, SaddleSystem, Schwarz, SchwarzParams, cg, fgmres, minres,
};

/// Constrains the first component of every fifth node, the last two of every seventh.
fn scattered(nodes: usize) -> Vec<(u32, [bool; 3])> {
    let constrained = |i: usize| [5, 7, 7].map(|k| i.is_multiple_of(k));
    (0..nodes)
        .filter(|&i| constrained(i).contains(&true))
        .map(|i| (i as u32, constrained(i)))
        .collect()
}

fn with_constrained_dofs(
    stokes: &Stokes,
    constrained: &[(u32, [bool; 3])],
) -> Result<SaddleSystem, LinalgError> {
    let s = &stokes.system;
    SaddleSystem::new(
        s.velocity_block()
            .clone()
            .with_constrained_dofs(constrained)?,
        s.divergence().clone(),
        s.border_divergence().clone(),
        None,
        s.pressure_mass().clone(),
    )
}

/// Positions of the constrained components in a vector of the system.
fn positions(constrained: &[(u32, [bool; 3])]) -> Vec<usize> {
    let of = |(node, constrained): &(u32, [bool; 3])| {
        let (node, constrained) = (*node as usize, *constrained);
        (0..3)
            .filter(move |&d| constrained[d])
            .map(move |d| 3 * node + d)
    };
    constrained.iter().flat_map(of).collect()
}

#[test]
fn free_dofs_satisfy_the_unconstrained_equations() {
    let stokes = one_body(2);
    let constrained = scattered(stokes.system.velocity_block().nodes());
    let system = with_constrained_dofs(&stokes, &constrained).expect("sound");
    let b = body_forces(&system);
    let mut x = vec![0.0; b.len()];
    let mut preconditioner =
        BlockTriangular::with_prolongation(&system, &stokes.prolongation).expect("multigrid");
    fgmres(&system, &mut preconditioner, &b, &mut x, &tolerance(1e-10)).expect("a solution");
    assert!(positions(&constrained).iter().all(|&i| x[i] == 0.0));
    // in the unconstrained operator only the constrained rows may have residuals
    let mut ax = vec![0.0; b.len()];
    stokes.system.apply(&x, &mut ax);
    let largest = positions(&constrained)
        .iter()
        .fold(0.0_f64, |m, &i| m.max((b[i] - ax[i]).abs()));
    assert!(largest > 1e-3);
    positions(&constrained).iter().for_each(|&i| ax[i] = b[i]);
    assert!(relative_difference(&ax, &b) <= 1e-10);

    let mut y = vec![0.0; b.len()];
    let mut preconditioner =
        BlockDiagonal::with_prolongation(&system, &stokes.prolongation).expect("definite");
    minres(&system, &mut preconditioner, &b, &mut y, &tolerance(1e-10)).expect("a solution");
    // both errors are at most the condition number of the system times the residuals
    assert!(relative_difference(&y, &x) <= 1e-6);
}

/// The seven-point Laplacian of a cube with a symmetry plane on one side.
///
/// The normal derivative is zero on the plane, and the normal component is constrained.
fn half_cube(n: usize) -> (Csr, Vec<(u32, [bool; 3])>) {
    let index = |i: usize, j: usize, k: usize| (i * n + j) * n + k;
    let mut t = sprs::TriMatI::<f64, u32>::new((n * n * n, n * n * n));
    for i in 0..n {
        for j in 0..n {
            for k in 0..n {
                // rows on the plane have half the weight
                let half = if i == 0 { 0.5 } else { 1.0 };
                let diagonal = 4.0 * half + if i == 0 { 1.0 } else { 2.0 };
                let mut add = |to: usize, value: f64| t.add_triplet(index(i, j, k), to, value);
                if i > 0 {
                    add(index(i - 1, j, k), -1.0);
                }
                if i + 1 < n {
                    add(index(i + 1, j, k), -1.0);
                }
                for (at, lower, upper) in [
                    (
                        j,
                        index(i, j.max(1) - 1, k),
                        index(i, (j + 1).min(n - 1), k),
                    ),
                    (
                        k,
                        index(i, j, k.max(1) - 1),
                        index(i, j, (k + 1).min(n - 1)),
                    ),
                ] {
                    if at > 0 {
                        add(lower, -half);
                    }
                    if at + 1 < n {
                        add(upper, -half);
                    }
                }
                add(index(i, j, k), diagonal);
            }
        }
    }
    let plane = (0..n * n)
        .map(|i| (i as u32, [true, false, false]))
        .collect();
    (t.to_csr(), plane)
}

/// Conjugate gradients take about as many iterations with a symmetry plane as without, also with
/// eight times as many nodes.
#[test]
fn a_symmetry_plane_costs_multigrid_no_iterations() {
    for n in [16, 32] {
        let (k, plane) = half_cube(n);
        let free = Bordered::scalar(k).expect("sound");
        let constrained = free.clone().with_constrained_dofs(&plane).expect("sound");
        let iterations = [&free, &constrained].map(|a| {
            let mut b = noise(3 * n * n * n);
            if std::ptr::eq(a, &constrained) {
                positions(&plane).iter().for_each(|&i| b[i] = 0.0);
            }
            let mut x = vec![0.0; b.len()];
            let mut multigrid = Multigrid::new(a, &MultigridParams::default()).expect("definite");
            let report = cg(a, &mut multigrid, &b, &mut x, &tolerance(1e-10)).expect("a solution");
            assert!(true_residual(a, &b, &x) <= 1e-10);
            report.iterations
        });
        assert!(iterations[1] <= iterations[0] + 3, "{n}: {iterations:?}");
    }
}

#[test]
fn an_empty_constraint_changes_no_bit() {
    let stokes = one_body(1);
    let system = with_constrained_dofs(&stokes, &[(3, [false; 3])]).expect("sound");
    let b = body_forces(&system);
    let [x, y] = [&stokes.system, &system].map(|s| {
        let mut x = vec![0.0; b.len()];
        let mut preconditioner =
            BlockTriangular::with_prolongation(s, &stokes.prolongation).expect("multigrid");
        fgmres(s, &mut preconditioner, &b, &mut x, &tolerance(1e-8)).expect("a solution");
        x
    });
    assert_eq!(x, y);
}

#[test]
fn methods_without_support_for_constraints_refuse() {
    let stokes = one_body(1);
    let system = with_constrained_dofs(&stokes, &[(3, [true, false, false])]).expect("sound");
    let refused = |error: Option<LinalgError>| {
        matches!(error, Some(LinalgError::ConstrainedDofs { nodes: 1, .. }))
    };
    assert!(refused(
        SaddleLdlt::factor(&system, &Default::default()).err()
    ));
    assert!(refused(
        Schwarz::new(&system, &SchwarzParams::default()).err()
    ));
    assert!(system.velocity_block().has_constrained_dofs());
}
