//! Matrices of 3 x 3 blocks: products, and multigrid for linear elasticity.

use linalg::sprs::TriMatI;
use linalg::{
    CoupledMultigrid, CoupledOperator, Csr, CsrOperator, LinalgError, LinearOperator,
    MultigridParams, Preconditioner, cg, fgmres,
};
use proptest::prelude::*;

use super::support::{assert_same_on_one_and_two_threads, dot, noise, tolerance};

/// `∫ 2 mu D(u):D(v) + lambda div u div v` in trilinear elements on `n^3` cells of the unit cube.
///
/// One face is clamped, the others are free. Returns the interleaved matrix and the free nodes.
fn elasticity(n: usize, mu: impl Fn([f64; 3]) -> f64, lambda: f64) -> (Csr, Vec<[f64; 3]>) {
    let (m, h) = (n + 1, 1.0 / n as f64);
    let node = |p: [usize; 3]| (p[0].checked_sub(1)).map(|x| x + n * (p[1] + m * p[2]));
    let free = 3 * n * m * m;
    let mut matrix = TriMatI::<f64, u32>::new((free, free));
    let products = products_of_gradients();
    for cell in 0..n * n * n {
        let low = [cell % n, cell / n % n, cell / n / n];
        let mu = mu(low.map(|l| (l as f64 + 0.5) * h));
        let corner = |a: usize| node([low[0] + a % 2, low[1] + a / 2 % 2, low[2] + a / 4]);
        for (a, b) in (0..64).map(|k| (k / 8, k % 8)) {
            let (Some(i), Some(j)) = (corner(a), corner(b)) else {
                continue;
            };
            let g = &products[a][b];
            let trace = g[0][0] + g[1][1] + g[2][2];
            for (d, e) in (0..9).map(|k| (k / 3, k % 3)) {
                let same = if d == e { mu * trace } else { 0.0 };
                let value = same + mu * g[e][d] + lambda * g[d][e];
                matrix.add_triplet(3 * i + d, 3 * j + e, h * value);
            }
        }
    }
    let mut positions = vec![[0.0; 3]; n * m * m];
    for z in 0..m {
        for y in 0..m {
            for x in 1..m {
                let i = x - 1 + n * (y + m * z);
                positions[i] = [x, y, z].map(|c| c as f64 * h);
            }
        }
    }
    (matrix.to_csr(), positions)
}

/// `∫ d_d phi_a d_e phi_b` over the unit cube, exact by two Gauss points in each direction.
fn products_of_gradients() -> [[[[f64; 3]; 3]; 8]; 8] {
    let points = [0.5 - 0.5 / 3f64.sqrt(), 0.5 + 0.5 / 3f64.sqrt()];
    let mut sums = [[[[0.0; 3]; 3]; 8]; 8];
    for q in 0..8 {
        let at = [points[q % 2], points[q / 2 % 2], points[q / 4]];
        let gradient = |a: usize| {
            let high = [a % 2, a / 2 % 2, a / 4].map(|bit| bit == 1);
            [0, 1, 2].map(|d| {
                let others = (0..3).filter(|&e| e != d);
                let rest: f64 = others
                    .map(|e| if high[e] { at[e] } else { 1.0 - at[e] })
                    .product();
                if high[d] { rest } else { -rest }
            })
        };
        for (a, b) in (0..64).map(|k| (k / 8, k % 8)) {
            let (ga, gb) = (gradient(a), gradient(b));
            for (d, e) in (0..9).map(|k| (k / 3, k % 3)) {
                sums[a][b][d][e] += ga[d] * gb[e] / 8.0;
            }
        }
    }
    sums
}

/// Lame's constants for a modulus of one and Poisson's ratio 0.3.
fn steel_like() -> (f64, f64) {
    (1.0 / 2.6, 0.3 / (1.3 * 0.4))
}

/// Iterations with rigid motions do not grow with the number of cells: elasticity with Poisson's
/// ratio 0.3, and a viscous term whose viscosity varies by a factor of 10^4.
#[test]
fn iterations_do_not_depend_on_the_mesh() {
    let viscosity = |[x, y, z]: [f64; 3]| {
        10f64.powf(2.0 * (6.0 * x).sin() * (5.0 * y).cos() * (4.0 * z + 1.0).sin())
    };
    let (mu, lambda) = steel_like();
    for name in ["elasticity", "variable viscosity"] {
        let mut found = Vec::new();
        for n in [8, 12, 16] {
            let (k, positions) = match name {
                "elasticity" => elasticity(n, |_| mu, lambda),
                _ => elasticity(n, viscosity, 0.0),
            };
            let a = CoupledOperator::from_interleaved(&k).expect("finite");
            let params = MultigridParams::default().with_coarsest_nodes(100);
            let mut amg =
                CoupledMultigrid::with_rigid_motions(&a, &positions, &params).expect("set-up");
            let (b, mut x) = (vec![1.0; a.rows()], vec![0.0; a.rows()]);
            let report = cg(&a, &mut amg, &b, &mut x, &tolerance(1e-10)).expect("convergence");
            found.push(report.iterations);
        }
        assert!(
            found[2] <= found[0] + 4 && found[2] <= 40,
            "{name}: {found:?}"
        );
    }
}

/// Viscous flow with convection along y at a speed of `speed` viscosities per side of the cube: the
/// hierarchy of the symmetric part preconditions the whole, on all meshes alike.
#[test]
fn convection_is_preconditioned_by_the_symmetric_part() {
    let solve = |n: usize, speed: f64| {
        let (viscous, positions) = elasticity(n, |_| 1.0, 0.0);
        let h = 1.0 / n as f64;
        // Central differences of `speed d/dy`: skew, with a cell Peclet number of `speed h / 2`.
        let mut skew = TriMatI::<f64, u32>::new(viscous.shape());
        let index = |p: [usize; 3]| p[0] - 1 + n * (p[1] + (n + 1) * p[2]);
        for i in 0..positions.len() {
            let at = positions[i].map(|x| (x / h).round() as usize);
            if at[1] < n {
                let j = index([at[0], at[1] + 1, at[2]]);
                for d in 0..3 {
                    skew.add_triplet(3 * i + d, 3 * j + d, 0.5 * h * h * speed);
                    skew.add_triplet(3 * j + d, 3 * i + d, -0.5 * h * h * speed);
                }
            }
        }
        let a = &viscous + &skew.to_csr::<usize>();
        let a = CoupledOperator::from_interleaved(&a).expect("finite");
        let params = MultigridParams::default().with_coarsest_nodes(100);
        if speed > 0.0 {
            let refused = CoupledMultigrid::new(&a, &params).map(|_| ());
            assert!(matches!(refused, Err(LinalgError::NotSymmetric { .. })));
        }
        let mut amg = CoupledMultigrid::from_symmetric_part(&a, &params).expect("set-up");
        let (b, mut x) = (vec![1.0; a.rows()], vec![0.0; a.rows()]);
        let report = fgmres(&a, &mut amg, &b, &mut x, &tolerance(1e-10)).expect("convergence");
        report.iterations
    };
    let alone = solve(8, 0.0);
    let found = [8, 12, 16].map(|n| solve(n, 10.0));
    // 28 without convection, and 79, 78, 71 with it.
    assert!(found[2] <= found[0] + 4, "{found:?}");
    assert!(
        found.iter().all(|&count| count <= 3 * alone),
        "{alone} {found:?}"
    );
}

/// The cycle is symmetric, positive, and bitwise the same for columns and numbers of threads.
#[test]
fn the_coupled_cycle_is_symmetric_and_reproducible() {
    let (mu, lambda) = steel_like();
    let (k, positions) = elasticity(9, |_| mu, lambda);
    let a = CoupledOperator::from_interleaved(&k).expect("finite");
    let params = MultigridParams::default().with_coarsest_nodes(60);
    let cycle = |r: &[&[f64]]| {
        let mut amg =
            CoupledMultigrid::with_rigid_motions(&a, &positions, &params).expect("set-up");
        assert!(amg.level_sizes().len() > 1);
        let mut z = vec![vec![0.0; a.rows()]; r.len()];
        let mut columns: Vec<&mut [f64]> = z.iter_mut().map(Vec::as_mut_slice).collect();
        amg.apply_columns(r, &mut columns);
        z
    };
    let (r, s) = (noise(a.rows()), vec![1.0; a.rows()]);
    let both = cycle(&[&r, &s]);
    assert_eq!(both, [cycle(&[&r]).remove(0), cycle(&[&s]).remove(0)]);
    let [z, y] = &both[..] else {
        panic!("two columns")
    };
    let scale = (dot(&r, z) * dot(&s, y)).sqrt();
    // roundings of f32, 6e-8 each, in sums over a few dozen terms per level
    assert!((dot(&s, z) - dot(&r, y)).abs() < 1e-4 * scale);
    assert_same_on_one_and_two_threads(|| cycle(&[&r]));
    assert_same_on_one_and_two_threads(|| {
        let mut y = vec![0.0; a.rows()];
        a.apply(&r, &mut y);
        y
    });
}

/// A prescribed component keeps its row of the identity; the others are solved for.
#[test]
fn single_components_may_be_prescribed() {
    let (mu, lambda) = steel_like();
    let (k, positions) = elasticity(8, |_| mu, lambda);
    // no normal displacement at y = 0
    let prescribed = |dof: usize| dof % 3 == 1 && positions[dof / 3][1] == 0.0;
    let mut matrix = TriMatI::<f64, u32>::new(k.shape());
    for (&value, (i, j)) in k.iter() {
        let (i, j) = (i as usize, j as usize);
        if i == j || !prescribed(i) && !prescribed(j) {
            matrix.add_triplet(i, j, value);
        }
    }
    let a = CoupledOperator::from_interleaved(&matrix.to_csr()).expect("finite");
    let params = MultigridParams::default();
    let mut amg = CoupledMultigrid::with_rigid_motions(&a, &positions, &params).expect("set-up");
    let b: Vec<f64> = (0..a.rows())
        .map(|i| f64::from(u8::from(!prescribed(i))))
        .collect();
    let mut x = vec![0.0; a.rows()];
    let report = cg(&a, &mut amg, &b, &mut x, &tolerance(1e-10)).expect("convergence");
    assert!(report.iterations <= 40, "{}", report.iterations);
    assert!(
        (0..a.rows())
            .filter(|&i| prescribed(i))
            .all(|i| x[i] == 0.0)
    );
}

#[test]
fn matrices_and_positions_that_do_not_fit_are_refused() {
    let params = MultigridParams::default();
    let odd = CoupledOperator::from_interleaved(&Csr::eye(4)).map(|_| ());
    assert!(matches!(odd, Err(LinalgError::Shape { .. })));
    let a = CoupledOperator::from_interleaved(&Csr::eye(6)).expect("finite");
    let few = CoupledMultigrid::with_rigid_motions(&a, &[[0.0; 3]], &params).map(|_| ());
    assert!(matches!(few, Err(LinalgError::Shape { .. })));
    let nan = CoupledMultigrid::with_rigid_motions(&a, &[[f64::NAN; 3]; 2], &params).map(|_| ());
    assert!(matches!(nan, Err(LinalgError::NotFinite { .. })));
    let mut matrix = TriMatI::<f64, u32>::new((3, 3));
    for (i, j) in [(0, 0), (1, 1), (2, 2), (0, 1)] {
        matrix.add_triplet(i, j, 1.0);
    }
    let a = CoupledOperator::from_interleaved(&matrix.to_csr()).expect("finite");
    let refused = CoupledMultigrid::new(&a, &params).map(|_| ());
    assert!(matches!(refused, Err(LinalgError::NotSymmetric { .. })));
}

proptest! {
    /// The blocks of an interleaved matrix have the same products, for one and several columns.
    #[test]
    fn products_equal_those_of_the_interleaved_matrix(
        rows in 1..5usize, cols in 1..5usize,
        values in proptest::collection::vec(prop_oneof![Just(0.0), -1.0..1.0], 144),
    ) {
        let mut matrix = TriMatI::<f64, u32>::new((3 * rows, 3 * cols));
        for i in 0..3 * rows {
            for j in (0..3 * cols).filter(|j| values[12 * i + j] != 0.0) {
                matrix.add_triplet(i, j, values[12 * i + j]);
            }
        }
        let matrix = matrix.to_csr();
        let blocks = CoupledOperator::from_interleaved(&matrix).expect("finite");
        let scalar = CsrOperator::new(matrix).expect("finite");
        prop_assert_eq!(blocks.is_symmetric(), scalar.is_symmetric());
        let x = noise(6 * cols);
        let columns = [&x[..3 * cols], &x[3 * cols..]];
        let (mut y, mut z) = (vec![1.0; 3 * rows], vec![2.0; 3 * rows]);
        blocks.apply_columns(&columns, &mut [&mut y, &mut z]);
        for (x, y) in columns.into_iter().zip([&y, &z]) {
            let (mut alone, mut expected) = (vec![0.0; 3 * rows], vec![0.0; 3 * rows]);
            blocks.apply(x, &mut alone);
            prop_assert_eq!(&alone, y);
            scalar.apply(x, &mut expected);
            // sums of at most twelve products below one
            let difference = alone.iter().zip(&expected).map(|(a, b)| (a - b).abs());
            prop_assert!(difference.fold(0.0, f64::max) <= 12.0 * 12.0 * f64::EPSILON);
        }
    }
}
