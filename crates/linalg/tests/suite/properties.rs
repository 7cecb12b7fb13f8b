//! Invariants of random systems, compared with dense matrices built from the definitions.

use faer::linalg::solvers::Solve;
use linalg::{
    BlockTriangular, Bordered, Csr, Csr3, DirectParams, KrylovParams, LinearOperator, Multigrid,
    MultigridParams, Preconditioner, SaddleLdlt, SaddleSystem, cg, fgmres,
};
use nalgebra::DMatrix;
use proptest::collection::vec;
use proptest::prelude::*;

use super::support::{dot, noise};

/// Sizes, and a pool of entries from which a system is filled; about half of them are zero.
#[derive(Debug, Clone)]
struct Recipe {
    n: usize,
    m: usize,
    np: usize,
    pool: Vec<f64>,
    nonsymmetric: bool,
}

fn recipe() -> impl Strategy<Value = Recipe> {
    let entry = prop_oneof![Just(0.0), -1.0..1.0];
    (
        1..14usize,
        0..8usize,
        1..6usize,
        vec(entry, 997),
        any::<bool>(),
    )
        .prop_map(|(n, m, np, pool, nonsymmetric)| Recipe {
            n,
            m,
            np,
            pool,
            nonsymmetric,
        })
}

/// The blocks as dense matrices.
struct Blocks {
    k: DMatrix<f64>,
    c: DMatrix<f64>,
    c_left: DMatrix<f64>,
    corner: DMatrix<f64>,
    b: DMatrix<f64>,
    e: DMatrix<f64>,
    e_left: DMatrix<f64>,
    mass: DMatrix<f64>,
}

impl Recipe {
    fn blocks(&self) -> Blocks {
        let &Recipe { n, m, np, .. } = self;
        let mut next = self.pool.iter().copied().cycle();
        let mut random =
            |rows, cols| DMatrix::from_fn(rows, cols, |_, _| next.next().unwrap_or(0.0));
        // diagonally dominant, hence positive definite
        let mut definite = |size: usize, weight: f64| {
            let r = random(size, size);
            (&r + r.transpose()) * 0.5 + DMatrix::identity(size, size) * (weight * size as f64)
        };
        let (k, mass) = (definite(n, 1.1), definite(np, 1.1));
        // M dominates C^T K^-1 C, whose norm is below 3 n m / (n / 10)
        let corner = definite(m, 40.0 * (m + n) as f64);
        let (c, b, e) = (random(3 * n, m), random(np, 3 * n), random(np, m));
        let (c_left, e_left) = if self.nonsymmetric {
            (random(3 * n, m), random(np, m))
        } else {
            (c.clone(), e.clone())
        };
        Blocks {
            k,
            c,
            c_left,
            corner,
            b,
            e,
            e_left,
            mass,
        }
    }

    fn system(&self) -> (SaddleSystem, DMatrix<f64>) {
        let blocks = self.blocks();
        let left = |m: &DMatrix<f64>| self.nonsymmetric.then(|| sparse(m));
        let a = Bordered::new(
            sparse(&blocks.k),
            sparse(&blocks.c),
            left(&blocks.c_left),
            blocks.corner.clone(),
        );
        let system = SaddleSystem::new(
            a.expect("a sound block"),
            sparse3(&blocks.b),
            sparse(&blocks.e),
            left(&blocks.e_left),
            sparse(&blocks.mass),
        );
        (system.expect("a sound system"), blocks.assemble())
    }
}

impl Blocks {
    /// The matrix of the crate's documentation.
    fn assemble(&self) -> DMatrix<f64> {
        let (u, m, np) = (self.c.nrows(), self.corner.nrows(), self.b.nrows());
        let k3 = self.k.kronecker(&DMatrix::identity(3, 3));
        let mut all = DMatrix::zeros(u + m + np, u + m + np);
        for (row, col, block) in [
            (0, 0, k3),
            (0, u, self.c.clone()),
            (0, u + m, self.b.transpose()),
            (u, 0, self.c_left.transpose()),
            (u, u, self.corner.clone()),
            (u, u + m, self.e_left.transpose()),
            (u + m, 0, self.b.clone()),
            (u + m, u, self.e.clone()),
        ] {
            all.view_mut((row, col), block.shape()).copy_from(&block);
        }
        all
    }
}

fn sparse(matrix: &DMatrix<f64>) -> Csr {
    let mut t = sprs::TriMatI::<f64, u32>::new(matrix.shape());
    for (j, column) in matrix.column_iter().enumerate() {
        for (i, v) in column.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            t.add_triplet(i, j, *v);
        }
    }
    t.to_csr()
}

/// Rows of 3-vectors from a matrix with three columns per node.
fn sparse3(matrix: &DMatrix<f64>) -> Csr3 {
    let (rows, nodes) = (matrix.nrows(), matrix.ncols() / 3);
    let (mut indptr, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for q in 0..rows {
        for j in 0..nodes {
            let entry = [0, 1, 2].map(|d| matrix[(q, 3 * j + d)]);
            if entry != [0.0; 3] {
                columns.push(j as u32);
                values.push(entry);
            }
        }
        indptr.push(columns.len());
    }
    Csr3::new((rows, nodes), indptr, columns, values)
}

fn multiply(matrix: &DMatrix<f64>, x: &[f64]) -> Vec<f64> {
    (matrix * nalgebra::DVector::from_column_slice(x))
        .as_slice()
        .to_vec()
}

fn dense_solution(matrix: &DMatrix<f64>, b: &[f64]) -> Vec<f64> {
    let n = b.len();
    let lu = faer::Mat::from_fn(n, n, |i, j| matrix[(i, j)]).partial_piv_lu();
    let x = lu.solve(faer::Col::from_fn(n, |i| b[i]));
    (0..n).map(|i| x[i]).collect()
}

fn distance(x: &[f64], y: &[f64]) -> f64 {
    x.iter()
        .zip(y)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f64>()
        .sqrt()
}

/// Systems without nodes, border, pressures, or all three are solved without a panic.
#[test]
fn empty_blocks_are_solved() {
    let recipe = |n, m, np| Recipe {
        n,
        m,
        np,
        pool: vec![0.3, -0.2, 0.0, 0.7],
        nonsymmetric: false,
    };
    for (n, m, np) in [(0, 0, 0), (0, 2, 0), (2, 0, 0), (2, 2, 0), (2, 0, 1)] {
        let (system, matrix) = recipe(n, m, np).system();
        let b = noise(system.rows())
            .iter()
            .map(|v| v + 2.0)
            .collect::<Vec<_>>();
        let mut x = vec![0.0; b.len()];
        let mut direct = SaddleLdlt::factor(&system, &DirectParams::default()).expect("regular");
        direct.solve(&b, &mut x).expect("refinement");
        assert!(distance(&multiply(&matrix, &x), &b) <= 1e-11);
        let velocity = Multigrid::new(system.velocity_block(), &MultigridParams::default());
        let mut pre = BlockTriangular::new(&system, velocity.expect("regular")).expect("set-up");
        x.fill(0.0);
        fgmres(&system, &mut pre, &b, &mut x, &KrylovParams::default()).expect("convergence");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn apply_is_the_documented_matrix(recipe in recipe()) {
        let (system, matrix) = recipe.system();
        let x = noise(system.cols());
        let mut y = vec![f64::NAN; x.len()];
        system.apply(&x, &mut y);
        let expected = multiply(&matrix, &x);
        // a row sums at most 100 terms, of size 600 at most
        prop_assert!(distance(&y, &expected) < 1e-10 * (1.0 + dot(&y, &y).sqrt()));
    }

    #[test]
    fn gradient_is_the_adjoint_of_divergence(recipe in recipe()) {
        let (system, _) = recipe.system();
        let (velocity, pressure) = (system.velocity_range(), system.pressure_range());
        let (mut u, mut p) = (noise(system.cols()), noise(system.cols()));
        u[velocity.end..].fill(0.0);
        p[..pressure.start].fill(0.0);
        let [mut au, mut ap] = [(); 2].map(|()| vec![0.0; u.len()]);
        system.apply(&u, &mut au);
        system.apply(&p, &mut ap);
        let (divergence, gradient) = (dot(&au, &p), dot(&ap, &u));
        prop_assert!((divergence - gradient).abs() < 1e-12 * (1.0 + divergence.abs()));
    }

    /// A hierarchy of one level is an exact solver up to the rounding of its input and output to
    /// f32.
    #[test]
    fn a_single_level_inverts_exactly(recipe in recipe()) {
        let (system, _) = recipe.system();
        let a = system.velocity_block();
        let mut exact = Multigrid::new(a, &MultigridParams::default()).expect("regular");
        let r = noise(a.rows());
        let [mut z, mut az] = [(); 2].map(|()| vec![0.0; r.len()]);
        exact.apply(&r, &mut z);
        a.apply(&z, &mut az);
        // ||A|| of the node rows is below 3 n, that of M below 100 (m + n) m
        let growth = a.border_len().max(1) as f64 * 100.0;
        prop_assert!(distance(&az, &r) < growth * f64::from(f32::EPSILON) * (1.0 + dot(&r, &r).sqrt()));
    }

    #[test]
    fn krylov_methods_reach_the_dense_solution(recipe in recipe()) {
        let recipe = Recipe { nonsymmetric: false, ..recipe };
        let (system, matrix) = recipe.system();
        let a = system.velocity_block();
        let size = a.rows();
        let b = noise(size);
        let expected = dense_solution(&matrix.view((0, 0), (size, size)).into_owned(), &b);
        let params = KrylovParams::default().with_rel_tol(1e-11);
        let mut pre = Multigrid::new(a, &MultigridParams::default()).expect("regular");
        for method in [cg, fgmres] {
            let mut x = vec![0.0; size];
            let report = method(a, &mut pre, &b, &mut x, &params).expect("convergence");
            let mut ax = vec![0.0; size];
            a.apply(&x, &mut ax);
            let truth = distance(&ax, &b) / dot(&b, &b).sqrt();
            prop_assert!((report.true_rel_residual - truth).abs() < 1e-13);
            prop_assert!(distance(&x, &expected) < 1e-8 * (1.0 + dot(&expected, &expected).sqrt()));
        }
    }

    /// The shifted factors with refinement, compared with dense LU, for borders of either kind.
    #[test]
    fn direct_solves_every_regular_system(recipe in recipe()) {
        let (system, matrix) = recipe.system();
        let b = noise(system.rows());
        let mut x = vec![0.0; b.len()];
        let solved = SaddleLdlt::factor(&system, &DirectParams::default())
            .and_then(|mut direct| direct.solve(&b, &mut x));
        // a system with more pressures than velocities, or with border columns that cancel, is
        // singular, and an error is right
        let singular_values = matrix.singular_values();
        let regular = singular_values.min() > 1e-5 * singular_values.max();
        match solved {
            Ok(report) => {
                let residual = distance(&multiply(&matrix, &x), &b) / dot(&b, &b).sqrt();
                // each of the two products has rounding errors of n epsilon ||A|| ||x||; x is large
                // if A is nearly singular
                let rounding = 2.0 * b.len() as f64 * f64::EPSILON * matrix.norm() * dot(&x, &x).sqrt();
                let difference = (residual - report.true_rel_residual).abs();
                prop_assert!(difference <= rounding / dot(&b, &b).sqrt(), "{difference:e} {residual:e}");
                prop_assert!(report.true_rel_residual <= 1e-12);
            }
            Err(error) => prop_assert!(!regular, "{error}"),
        }
    }

    /// A matrix stored by columns gives the same operator.
    #[test]
    fn storage_order_does_not_matter(recipe in recipe()) {
        let blocks = recipe.blocks();
        let [k, c] = [&blocks.k, &blocks.c].map(sparse);
        let columns = Bordered::new(k.to_csc(), c.to_csc(), None, blocks.corner.clone()).expect("sound");
        let rows = Bordered::new(k, c, None, blocks.corner).expect("sound");
        let x = noise(rows.cols());
        let [mut y, mut z] = [(); 2].map(|()| vec![0.0; x.len()]);
        columns.apply(&x, &mut y);
        rows.apply(&x, &mut z);
        prop_assert_eq!(y, z);
    }

    /// Blocks of wrong shape or with infinite values are refused without a panic.
    #[test]
    fn bad_blocks_are_refused(recipe in recipe(), which in 0..4usize) {
        let blocks = recipe.blocks();
        let grown = |m: &DMatrix<f64>, grow: bool| {
            let (rows, cols) = m.shape();
            sparse(&m.clone().resize(rows + usize::from(grow), cols, 1.0))
        };
        let corner = blocks.corner.clone().resize(recipe.m, recipe.m + usize::from(which == 2), 1.0);
        let mut k = grown(&blocks.k, which == 0);
        if which == 3 {
            k.data_mut()[0] = f64::INFINITY;
        }
        prop_assert!(Bordered::new(k, grown(&blocks.c, which == 1), None, corner).is_err());
    }
}
