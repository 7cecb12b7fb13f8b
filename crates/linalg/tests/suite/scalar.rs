//! One-component systems: a sparse matrix as an operator, and multigrid for it.

use linalg::sprs::TriMatI;
use linalg::{
    Bordered, Csr, CsrOperator, LinalgError, LinearOperator, Multigrid, MultigridParams,
    Preconditioner, Prolongation, ScalarMultigrid, cg, fgmres, minres,
};

use super::support::{
    assert_same_on_one_and_two_threads, coarse_stiffness, noise, one_body, relative_difference,
    tolerance,
};

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

/// `-div k grad` in finite volumes on `cells`, with harmonic means of `k` and `u = 0` at the walls.
fn diffusion(cells: [usize; 3], k: impl Fn(usize) -> [f64; 3]) -> CsrOperator {
    let n: usize = cells.iter().product();
    let strides = [1, cells[0], cells[0] * cells[1]];
    let mut matrix = TriMatI::<f64, u32>::new((n, n));
    for i in 0..n {
        for d in (0..3).filter(|&d| cells[d] > 1) {
            let (place, own) = (i / strides[d] % cells[d], k(i)[d]);
            let walls = usize::from(place == 0) + usize::from(place + 1 == cells[d]);
            matrix.add_triplet(i, i, 2.0 * own * walls as f64);
            if place + 1 < cells[d] {
                let (j, other) = (i + strides[d], k(i + strides[d])[d]);
                let mean = 2.0 * own * other / (own + other);
                for (a, b, value) in [(i, i, mean), (j, j, mean), (i, j, -mean), (j, i, -mean)] {
                    matrix.add_triplet(a, b, value);
                }
            }
        }
    }
    CsrOperator::new(matrix.to_csr()).expect("finite")
}

/// The splitmix64 finaliser, in [0, 1).
fn random(i: usize) -> f64 {
    let mut z = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (z ^ (z >> 31)) as f64 / 2f64.powi(64)
}

/// Random coefficients from 1e-3 to 1e3, jumps, and anisotropy need at most 30 iterations; the
/// numbers measured on finer grids are in the documentation of `MultigridParams::heterogeneous`.
#[test]
fn coefficients_may_vary_by_orders_of_magnitude() {
    let smooth_random = |i| [10f64.powf(6.0 * random(i) - 3.0); 3];
    let jumps = |i| [if random(i) < 0.5 { 1e-3 } else { 1e3 }; 3];
    let problems = [
        ("random, 3-D", diffusion([20; 3], smooth_random)),
        ("random, 2-D", diffusion([64, 64, 1], smooth_random)),
        ("random, finer", diffusion([128, 128, 1], smooth_random)),
        ("jumps", diffusion([20; 3], jumps)),
        ("weak direction", diffusion([20; 3], |_| [1.0, 1.0, 1e-3])),
        ("strong direction", diffusion([20; 3], |_| [1.0, 1.0, 1e3])),
    ];
    let params = MultigridParams::heterogeneous();
    for (name, a) in problems {
        let mut amg = ScalarMultigrid::new(&a, &params).expect("set-up");
        let sizes = amg.level_sizes();
        let all: usize = sizes.iter().map(|size| size.nnz).sum();
        assert!(all < 4 * sizes[0].nnz, "{name}: operator complexity");
        let (b, mut x) = (noise(a.rows()), vec![0.0; a.rows()]);
        let report = cg(&a, &mut amg, &b, &mut x, &tolerance(1e-8)).expect("convergence");
        assert!(report.iterations <= 30, "{name}: {}", report.iterations);
    }
}

/// `-div k grad` in bilinear elements on `n^2` cells with `u = 0` on the boundary, where `k` is
/// `diag(1, 1e-3)` rotated by an angle.
fn rotated_diffusion(n: usize, degrees: f64) -> CsrOperator {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (strong, weak) = (1.0, 1e-3);
    let k_xx = strong * cos * cos + weak * sin * sin;
    let k_yy = strong * sin * sin + weak * cos * cos;
    let k_xy = (strong - weak) * sin * cos;
    // Integrals of products of hat functions and of their slopes, in one dimension.
    let masses = [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0];
    let stiffness = [-1.0, 2.0, -1.0];
    let slopes = [-0.5, 0.0, 0.5];
    let m = n - 1;
    let mut matrix = TriMatI::<f64, u32>::new((m * m, m * m));
    for (i, j) in (0..m * m).map(|node| (node % m, node / m)) {
        for (a, b) in (0..9).map(|k| (k % 3, k / 3)) {
            let (x, y) = (i + a, j + b);
            if (1..=m).contains(&x) && (1..=m).contains(&y) {
                let value = k_xx * stiffness[a] * masses[b] + k_yy * masses[a] * stiffness[b]
                    - 2.0 * k_xy * slopes[a] * slopes[b];
                matrix.add_triplet(i + m * j, x - 1 + m * (y - 1), value);
            }
        }
    }
    CsrOperator::new(matrix.to_csr()).expect("finite")
}

/// An anisotropy of 1e3 needs at most 30 iterations in any direction, on finer grids too.
#[test]
fn bug_anisotropy_across_the_grid_took_more_than_30_iterations() {
    let params = MultigridParams::anisotropic();
    for cells in [64, 128] {
        for degrees in [0.0, 15.0, 30.0, 45.0, 60.0, 120.0] {
            let a = rotated_diffusion(cells, degrees);
            let mut amg = ScalarMultigrid::new(&a, &params).expect("set-up");
            let (b, mut x) = (noise(a.rows()), vec![0.0; a.rows()]);
            let report = cg(&a, &mut amg, &b, &mut x, &tolerance(1e-8)).expect("convergence");
            let count = report.iterations;
            assert!(count <= 30, "{cells} cells, {degrees} degrees: {count}");
        }
    }
}

/// The cycle for varying coefficients is symmetric, and the same on one and two threads.
#[test]
fn the_cycle_for_varying_coefficients_is_symmetric() {
    let a = diffusion([48, 48, 1], |i| [10f64.powf(6.0 * random(i) - 3.0); 3]);
    let params = MultigridParams::heterogeneous();
    let cycle = |r: &[f64]| {
        let mut amg = ScalarMultigrid::new(&a, &params).expect("set-up");
        let mut z = vec![0.0; r.len()];
        amg.apply(r, &mut z);
        z
    };
    let (r, s) = (
        noise(a.rows()),
        (0..a.rows()).map(random).collect::<Vec<_>>(),
    );
    let (z, y) = (cycle(&r), cycle(&s));
    let product = |x: &[f64], y: &[f64]| -> f64 { x.iter().zip(y).map(|(a, b)| a * b).sum() };
    let scale = (product(&r, &z) * product(&s, &y)).sqrt();
    // roundings of f32, 6e-8 each, in sums over a few dozen terms per level
    assert!((product(&s, &z) - product(&r, &y)).abs() < 1e-4 * scale);
    assert_same_on_one_and_two_threads(|| cycle(&r));
}

/// A level that cannot be aggregated is an error instead of a large factorisation.
#[test]
fn stalled_coarsening_is_an_error() {
    // no connection of the seven-point Laplacian exceeds 1/6 of the diagonal
    let a = diffusion([24; 3], |_| [1.0; 3]);
    let params = MultigridParams::default().with_strength(0.3);
    match ScalarMultigrid::new(&a, &params).map(|_| ()) {
        Err(LinalgError::CoarseningStalled {
            level: 0,
            nodes: 13_824,
            limit: 10_000,
            ..
        }) => {}
        other => panic!("{other:?}"),
    }
    let allowed = params.with_max_factorised_nodes(13_824);
    let amg = ScalarMultigrid::new(&a, &allowed).expect("a factorisation");
    assert_eq!(amg.level_sizes().len(), 1);
}

/// With the interpolation from P1 to P2, the scalar cycle is a component of that for three.
#[test]
fn a_given_prolongation_is_the_first_one() {
    let stokes = one_body(2);
    let (block, p) = (stokes.system.velocity_block(), stokes.prolongation.nodes());
    let a = CsrOperator::new(block.stiffness().clone()).expect("finite");
    let prolongation = Prolongation::scalar(p.clone()).expect("finite");
    let params = MultigridParams::default();
    let mut scalar = ScalarMultigrid::with_prolongation(&a, &prolongation, None, &params)
        .expect("positive definite");
    assert_eq!(scalar.level_sizes()[1].nodes, p.cols());
    let (b, mut x) = (noise(a.rows()), vec![0.0; a.rows()]);
    let report = cg(&a, &mut scalar, &b, &mut x, &tolerance(1e-10)).expect("convergence");
    assert!(report.iterations <= 30, "{}", report.iterations);
    let short = Prolongation::scalar(Csr::eye(3)).expect("finite");
    let refused = ScalarMultigrid::with_prolongation(&a, &short, None, &params).map(|_| ());
    assert!(matches!(refused, Err(LinalgError::Shape { .. })));
}

/// The symmetric part of a symmetric matrix gives the same cycle.
#[test]
fn the_symmetric_part_of_a_symmetric_matrix() {
    let a = diffusion([12; 3], |_| [1.0; 3]);
    let params = MultigridParams::default();
    let apply = |mut amg: ScalarMultigrid| {
        let (r, mut z) = (noise(a.rows()), vec![0.0; a.rows()]);
        amg.apply(&r, &mut z);
        z
    };
    let direct = apply(ScalarMultigrid::new(&a, &params).expect("set-up"));
    let part = apply(ScalarMultigrid::from_symmetric_part(&a, &params).expect("set-up"));
    assert_eq!(direct, part);
}
