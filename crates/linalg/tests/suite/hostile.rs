//! Every public function on hostile arguments: a right answer or an error, never a panic.
//!
//! `LinearOperator::apply` and `Preconditioner::apply` are the exception: vectors of a wrong length
//! are a documented panic there, never a quiet answer.

use std::panic::{AssertUnwindSafe, catch_unwind};

use linalg::{
    BlockDiagonal, BlockTriangular, BorderInverse, BorderPlacement, Bordered, Csr, Csr3,
    CsrOperator, DirectParams, Identity, KrylovParams, LinalgError, LinearOperator, MassInverse,
    Multigrid, MultigridParams, NullVectors, OMITTED, Preconditioner, Prolongation, SaddleLdlt,
    SaddleSystem, ScalarMultigrid, Schwarz, SchwarzParams, ShiftedLdlt, SolveReport, WarmStart, cg,
    fgmres, fgmres_columns, minres, submatrix,
};
use nalgebra::DMatrix;
use proptest::prelude::*;
use sprs::CsMatI;

use super::support::{true_residual, two_bodies};

const NUMBERS: [f64; 12] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.5,
    5e-324,
    1e-300,
    -1e300,
    f64::MAX,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];

/// Mostly ordinary numbers, so that a single bad one is not hidden by another.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![8 => -1.0..1.0, 1 => proptest::sample::select(&NUMBERS[..])]
}

fn count() -> impl Strategy<Value = usize> {
    proptest::sample::select(&[0, 1, 2, 7, 1000, 1 << 40, usize::MAX][..])
}

/// A source of numbers that never ends.
struct Pool<'a> {
    numbers: &'a [f64],
    next: usize,
}

impl Pool<'_> {
    fn number(&mut self) -> f64 {
        self.next += 1;
        self.numbers[self.next % self.numbers.len()]
    }

    fn matrix(&mut self, rows: usize, cols: usize) -> Csr {
        self.sparse(rows, cols, |pool| pool.number())
    }

    fn sparse<T: Clone>(
        &mut self,
        rows: usize,
        cols: usize,
        entry: impl Fn(&mut Self) -> T,
    ) -> CsMatI<T, u32, usize> {
        let values = (0..rows * cols).map(|_| entry(self)).collect();
        let columns = (0..rows).flat_map(|_| 0..cols as u32).collect();
        CsMatI::new(
            (rows, cols),
            (0..=rows).map(|i| i * cols).collect(),
            columns,
            values,
        )
    }

    /// A symmetric matrix with a large diagonal, and by columns instead of rows now and then.
    fn stiffness(&mut self, n: usize) -> Csr {
        let lower: Vec<Vec<f64>> = (0..n)
            .map(|i| (0..=i).map(|_| self.number()).collect())
            .collect();
        let mut matrix = self.sparse(n, n, |_| 0.0);
        for i in 0..n {
            for j in 0..n {
                let entry = lower[i.max(j)][i.min(j)];
                let diagonal = if i == j { 4.0 } else { 0.0 };
                if let Some(value) = matrix.get_mut(i, j) {
                    *value = entry + diagonal;
                }
            }
        }
        if self.number() > 0.8 {
            matrix = matrix.to_csc();
        }
        matrix
    }

    fn vector(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.number()).collect()
    }
}

/// A solution that was reported as found has the residual that was reported.
fn check(
    name: &str,
    operator: &dyn LinearOperator,
    b: &[f64],
    x: &[f64],
    solved: Result<SolveReport, LinalgError>,
) {
    let Ok(report) = solved else { return };
    assert!(x.iter().all(|v| v.is_finite()), "{name}");
    assert!(report.error_estimate().is_finite(), "{name}");
    if b.iter().any(|v| *v != 0.0) && report.rhs_removed == 0.0 {
        let residual = true_residual(operator, b, x);
        assert!(residual <= 1e-7, "{name}: {residual:e}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Every constructor, solver and preconditioner on small systems with a few bad entries.
    #[test]
    fn solvers_of_hostile_systems_answer_or_refuse(
        numbers in proptest::collection::vec(number(), 211),
        n in 0..6usize, m in 0..3usize, np in 0..4usize,
        [wrong, columns] in [0..12usize, 0..12usize],
        [few, many] in [count(), count()],
    ) {
        let mut pool = Pool { numbers: &numbers, next: 0 };
        let off = |size: usize, here: usize| if wrong == here { size + 1 } else { size };
        let corner = DMatrix::from_fn(off(m, 0), m, |i, j| if i == j { 3.0 } else { pool.number() });
        let a = Bordered::new(
            pool.stiffness(n),
            pool.matrix(3 * off(n, 1), m),
            (columns == 0).then(|| pool.matrix(3 * n, off(m, 2))),
            corner,
        );
        let params = MultigridParams::default()
            .with_sweeps(if columns == 1 { few } else { 1 })
            .with_coarse_sweeps(if columns == 2 { many } else { 2 })
            .with_smoothing_range(if columns == 3 { pool.number() } else { 7.0 })
            .with_strength(if columns == 4 { pool.number() } else { 0.02 })
            .with_coarsest_nodes(if columns == 5 { few } else { 2 })
            .with_coarsest_shift(if columns == 6 { pool.number() } else { 0.0 })
            .with_border(if columns == 7 { BorderInverse::Absolute } else { BorderInverse::Exact });
        let krylov = KrylovParams::default()
            .with_restart(if wrong == 3 { many } else { 60 })
            .with_max_iterations(if wrong == 4 { few.min(1000) } else { 100 })
            .with_rel_tol(if wrong == 5 { pool.number() } else { 1e-8 });
        let scalar = CsrOperator::new(pool.stiffness(n));
        if let Ok(scalar) = &scalar {
            let _ = scalar.matrix().nnz();
            let (b, mut x) = (pool.vector(n), vec![0.0; off(n, 6)]);
            let solved = cg(scalar, &mut Identity(n), &b, &mut x, &krylov);
            if wrong != 5 { check("cg", scalar, &b, &x, solved); }
            if let Ok(mut cycle) = ScalarMultigrid::new(scalar, &params) {
                let _ = cycle.level_sizes();
                let mut x = vec![0.0; n];
                let solved = cg(scalar, &mut cycle, &b, &mut x, &krylov);
                if wrong != 5 { check("cg, multigrid", scalar, &b, &x, solved); }
            }
        }
        let Ok(a) = a else { return Ok(()) };
        let a = match columns {
            8 => match a.with_constrained_dofs(&[(0, [true; 3]), (few as u32, [false, true, true])]) {
                Ok(a) => a,
                Err(_) => return Ok(()),
            },
            _ => a,
        };
        let (b, mut x) = (pool.vector(a.rows()), vec![0.0; a.rows()]);
        if let Ok(mut cycle) = Multigrid::new(&a, &params) {
            let _ = format!("{cycle} {:?} {}", cycle.level_sizes(), cycle.operator_complexity());
            let solved = fgmres(&a, &mut cycle, &b, &mut x, &krylov);
            if wrong != 5 && columns != 8 { check("fgmres", &a, &b, &x, solved); }
        }
        let prolongation = Prolongation::new(pool.matrix(off(n, 7), n / 2), pool.matrix(3 * n, m))
            .and_then(|p| match columns {
                9 => p.with_left_border(pool.matrix(3 * off(n, 8), m)),
                _ => Ok(p),
            });
        let divergence: Csr3 = pool.sparse(off(np, 9), n, |p| [p.number(), p.number(), p.number()]);
        let mass = pool.stiffness(np);
        let _ = MassInverse::new(&mass, if wrong == 10 { few } else { 3 });
        let laplacian = pool.stiffness(off(np, 11));
        let system = SaddleSystem::new(
            a.clone(),
            divergence,
            pool.matrix(np, m),
            (columns == 0).then(|| pool.matrix(np, off(m, 10))),
            mass,
        );
        let Ok(system) = system else { return Ok(()) };
        let (b, zero) = (pool.vector(system.rows()), vec![0.0; system.rows()]);
        let verify = |name, x: &[f64], solved| {
            if wrong != 5 && columns != 8 { check(name, &system, &b, x, solved); }
        };
        let coarse = (columns == 10).then(|| pool.stiffness(off(n / 2, 3)));
        if let Ok(prolongation) = &prolongation {
            let _ = (prolongation.nodes(), prolongation.border(), prolongation.border_left());
            if let Ok(cycle) = Multigrid::with_prolongation(&a, prolongation, coarse, &params)
                && let Ok(pre) = BlockTriangular::new(&system, cycle)
                && let Ok(mut pre) = match wrong {
                    11 => pre.with_pressure_laplacian(&laplacian),
                    _ => Ok(pre),
                }
            {
                let mut x = zero.clone();
                let solved = fgmres(&system, &mut pre, &b, &mut x, &krylov);
                verify("block", &x, solved);
            }
            if let Ok(mut pre) = BlockDiagonal::with_prolongation(&system, prolongation) {
                let mut x = zero.clone();
                let solved = minres(&system, &mut pre, &b, &mut x, &krylov);
                verify("minres", &x, solved);
            }
        }
        let direct = DirectParams::double()
            .with_shift(if wrong == 6 { pool.number() } else { 1e-8 })
            .with_rel_tol(if wrong == 7 { pool.number() } else { 1e-9 })
            .with_max_refinements(if wrong == 8 { few.min(100) } else { 30 });
        if let Ok(mut solver) = SaddleLdlt::factor(&system, &direct) {
            let mut x = vec![0.0; off(zero.len(), 9)];
            let solved = solver.solve(&b, &mut x);
            if wrong != 7 { verify("direct", &x, solved); }
            let _ = (solver.nnz(), solver.bytes());
        }
        let cut = SchwarzParams::default()
            .with_subdomains(if wrong == 0 { few } else { 2 })
            .with_overlap(many)
            .with_border(match columns {
                9 => BorderPlacement::Eliminated,
                _ => BorderPlacement::Assigned(vec![few; off(m, 1)]),
            });
        if let Ok(mut pre) = Schwarz::new(&system, &cut) {
            let mut x = zero.clone();
            let solved = fgmres(&system, &mut pre, &b, &mut x, &krylov);
            verify("schwarz", &x, solved);
        }
    }

    #[test]
    fn shifted_factors_answer_or_refuse(
        numbers in proptest::collection::vec(number(), 97),
        n in 0..7usize, lengths in [0..8usize, 0..8usize, 0..8usize, 0..8usize],
        group in proptest::collection::vec(prop_oneof![6 => 0..7u32, 1 => any::<u32>()], 8),
    ) {
        let mut pool = Pool { numbers: &numbers, next: 0 };
        let lengths = lengths.map(|l| if l > 3 { n } else { l });
        let matrix = pool.stiffness(n);
        let shift = pool.vector(lengths[0]);
        if let Ok(mut solver) = ShiftedLdlt::factor(matrix.clone(), &shift, &group[..lengths[1]]) {
            let (b, mut x) = (pool.vector(lengths[2]), vec![0.0; lengths[3]]);
            if let Ok(residual) = solver.solve(&b, &mut x) {
                let operator = CsrOperator::new(matrix).expect("factorised");
                prop_assert!(residual <= 1e-11 && x.iter().all(|v| v.is_finite()));
                if b.iter().any(|v| *v != 0.0) {
                    prop_assert!(true_residual(&operator, &b, &x) < 1e-10);
                }
            }
        }
    }

    #[test]
    fn null_vectors_and_warm_starts_answer_or_refuse(
        numbers in proptest::collection::vec(number(), 61),
        sizes in [0..5usize, 0..5usize, 0..5usize], [n, start, end] in [count(), count(), count()],
    ) {
        let mut pool = Pool { numbers: &numbers, next: 0 };
        let a = Bordered::scalar(Csr::eye(1)).expect("the identity");
        let mut vectors = |k: usize| (0..k).map(|i| pool.vector(sizes[i % 3])).collect::<Vec<_>>();
        if let Ok(null) = NullVectors::new(vectors(2)).and_then(|null| null.with_left(vectors(1))) {
            let mut x = vec![1.0; sizes[0]];
            let _ = (null.project_out(&mut x), null.dimension());
            let params = KrylovParams::default().with_null_vectors(null);
            let _ = fgmres(&a, &mut Identity(3), &[1.0; 3], &mut [0.0; 3], &params);
        }
        let small = |n: usize| if n > 1 << 20 { usize::MAX } else { n };
        let n = small(n);
        let _ = NullVectors::constant(n);
        if let Ok(null) = NullVectors::constant_on(n, start..end) {
            prop_assert!(start <= end && end <= n);
            prop_assert_eq!(null.project_out(&mut [1.0; 3]).is_ok(), n == 3 || start == end);
        }
        let mut warm = WarmStart::new(start);
        for _ in 0..3 {
            warm.remember(&pool.vector(sizes[0]));
        }
        let (b, mut x) = (pool.vector(sizes[1]), vec![0.0; sizes[2]]);
        prop_assert!(warm.guess(&a, &b, &mut x).is_err() || (sizes[1], sizes[2]) == (3, 3));
        prop_assert!(warm.guess_columns(&a, &[&b, &b], &mut [&mut x]).is_err());
        prop_assert!(x.iter().all(|v| v.is_finite()));
        prop_assert!(warm.solutions().all(|s| s.iter().all(|v| v.is_finite())));
        warm.clear();
        let _ = fgmres_columns(
            &a, &mut Identity(n), &[&b], &mut [&mut x], &KrylovParams::default(),
        );
    }

    #[test]
    fn submatrices_answer_or_refuse(
        rows in proptest::collection::vec(prop_oneof![4 => 0..4u32, 1 => any::<u32>()], 0..5),
        numbers in proptest::collection::vec(
            prop_oneof![4 => 0..4u32, 1 => Just(OMITTED), 1 => any::<u32>()], 0..6,
        ),
        n_columns in count(), by_columns in any::<bool>(),
    ) {
        let mut matrix = Csr::eye(4);
        if by_columns {
            matrix = matrix.to_csc();
        }
        let Ok(block) = submatrix(&matrix, &rows, &numbers, n_columns) else { return Ok(()) };
        let kept = rows.iter().filter(|&&row| numbers[row as usize] != OMITTED);
        prop_assert_eq!(block.nnz(), kept.count());
    }
}

/// Vectors of a wrong length and different numbers of columns panic in every `apply`.
#[test]
fn products_with_vectors_of_a_wrong_length_panic() {
    let stokes = two_bodies(1);
    let system = &stokes.system;
    let a = system.velocity_block();
    let n = 20;
    let (starts, columns) = ((0..=n).collect(), (0..n as u32).collect());
    let plain = Csr::new((n, n), starts, columns, vec![2.0; n]);
    let plain = CsrOperator::new(plain).expect("finite");
    let operators: [&dyn LinearOperator; 3] = [system, a, &plain];
    let panics = |call: &mut dyn FnMut()| catch_unwind(AssertUnwindSafe(call)).is_err();
    for (number, operator) in operators.into_iter().enumerate() {
        let n = operator.rows();
        for (x, y) in [(n + 1, n), (n - 1, n), (n, n + 1), (n, n - 1), (0, 0)] {
            let (x, mut y) = (vec![1.0; x], vec![0.0; y]);
            assert!(panics(&mut || operator.apply(&x, &mut y)), "{number}");
        }
        let (x, mut y) = (vec![1.0; n], vec![0.0; n]);
        assert!(panics(
            &mut || operator.apply_columns(&[&x, &x], &mut [&mut y])
        ));
    }
    let cycle = || Multigrid::new(a, &MultigridParams::default()).expect("a hierarchy");
    let block = BlockTriangular::new(system, cycle());
    let absolute = MultigridParams::default().with_border(BorderInverse::Absolute);
    let absolute = Multigrid::new(a, &absolute).expect("a hierarchy");
    let cut = SchwarzParams::default().with_subdomains(2);
    let mut preconditioners: [Box<dyn Preconditioner>; 7] = [
        Box::new(Identity(5)),
        Box::new(MassInverse::new(system.pressure_mass(), 3).expect("a mass matrix")),
        Box::new(cycle()),
        Box::new(ScalarMultigrid::new(&plain, &MultigridParams::default()).expect("definite")),
        Box::new(block.expect("they fit")),
        Box::new(BlockDiagonal::new(system, absolute).expect("they fit")),
        Box::new(Schwarz::new(system, &cut).expect("regular")),
    ];
    for (number, preconditioner) in preconditioners.iter_mut().enumerate() {
        let n = preconditioner.size();
        for (r, z) in [(n + 1, n), (n - 1, n), (n, n + 1), (n, n - 1), (0, 0)] {
            let (r, mut z) = (vec![1.0; r], vec![0.0; z]);
            assert!(panics(&mut || preconditioner.apply(&r, &mut z)), "{number}");
        }
        let (r, mut z) = (vec![1.0; n], vec![0.0; n]);
        let mut several = || preconditioner.apply_columns(&[&r, &r], &mut [&mut z]);
        assert!(panics(&mut several), "{number}");
    }
}
