//! The generic block preconditioner.

use linalg::{
    BlockForm, BlockPreconditionerBuilder, Csr, CsrOperator, ExplicitInverse, Identity,
    LinalgError, LinearOperator, MassInverse, Multigrid, MultigridParams, Preconditioner,
    PreconditionerKind, fgmres, minres,
};

use super::support::{body_forces, noise, one_body, relative_difference, tolerance};

/// A dense matrix, exact inverse or coupling.
fn dense(rows: usize, cols: usize, value: impl Fn(usize, usize) -> f64) -> CsrOperator {
    let starts = (0..=rows).map(|i| i * cols).collect();
    let columns = (0..rows).flat_map(|_| 0..cols as u32).collect();
    let values = (0..rows * cols)
        .map(|k| value(k / cols, k % cols))
        .collect();
    CsrOperator::new(Csr::new((rows, cols), starts, columns, values)).expect("finite")
}

fn diagonal_inverse(values: &[f64]) -> ExplicitInverse<CsrOperator> {
    let n = values.len();
    let inverse = dense(n, n, |i, j| if i == j { 1.0 / values[i] } else { 0.0 });
    ExplicitInverse::new(inverse, PreconditionerKind::PositiveDefinite).expect("symmetric")
}

/// With exact inverses, the triangular forms solve their triangular system to rounding.
#[test]
fn triangular_forms_solve_triangular_systems() {
    // [D1 C; L D2] with 2 and 3 rows, the second block in front of the vector
    let (d1, d2) = ([2.0, 4.0], [5.0, 8.0, 10.0]);
    let upper = dense(2, 3, |i, j| (1 + i + 2 * j) as f64);
    let lower = dense(3, 2, |i, j| (2 + 3 * i - j) as f64);
    let build = |form| {
        BlockPreconditionerBuilder::new(5)
            .block("first", 3..5, diagonal_inverse(&d1))
            .schur_complement("second", 0..3, diagonal_inverse(&d2))
            .coupling("first", "second", &upper)
            .coupling("second", "first", &lower)
            .build(form)
            .expect("blocks that fit")
    };
    let z = [1.0, -2.0, 3.0, 0.5, 7.0];
    for form in [BlockForm::Diagonal, BlockForm::Lower, BlockForm::Upper] {
        // r = P z with the matrix P of the form
        let sign = if form == BlockForm::Diagonal {
            1.0
        } else {
            -1.0
        };
        let mut r: Vec<f64> = (0..3).map(|i| sign * d2[i] * z[i]).collect();
        r.extend((0..2).map(|i| d1[i] * z[3 + i]));
        let mut product = [0.0; 3];
        if form == BlockForm::Lower {
            lower.apply(&z[3..], &mut product);
            r.iter_mut().zip(product).for_each(|(r, p)| *r += p);
        }
        if form == BlockForm::Upper {
            upper.apply(&z[..3], &mut product[..2]);
            r[3..].iter_mut().zip(product).for_each(|(r, p)| *r += p);
        }
        let mut preconditioner = build(form);
        let mut found = [0.0; 5];
        preconditioner.apply(&r, &mut found);
        // a few dozen roundings of numbers below 100
        assert!(
            relative_difference(&found, &z) < 1e-14,
            "{form:?} {found:?}"
        );
        let expected = if form == BlockForm::Diagonal {
            PreconditionerKind::PositiveDefinite
        } else {
            PreconditionerKind::Linear
        };
        assert_eq!(preconditioner.kind(), expected);
    }
}

/// The blocks of a saddle-point system, given one by one, are applied in their order, and suit
/// FGMRES and MINRES.
#[test]
fn a_saddle_point_system_by_its_blocks() {
    struct Gradient<'a>(&'a linalg::SaddleSystem);
    impl LinearOperator for Gradient<'_> {
        fn rows(&self) -> usize {
            self.0.velocity_block().rows()
        }
        fn cols(&self) -> usize {
            self.0.pressure_range().len()
        }
        fn apply(&self, p: &[f64], y: &mut [f64]) {
            let mut x = vec![0.0; self.0.rows()];
            x[self.0.pressure_range()].copy_from_slice(p);
            let mut product = vec![0.0; x.len()];
            self.0.apply(&x, &mut product);
            y.copy_from_slice(&product[..y.len()]);
        }
    }
    let stokes = one_body(2);
    let system = &stokes.system;
    let (a, split) = (system.velocity_block(), system.pressure_range().start);
    let params = MultigridParams::default();
    let velocity = || Multigrid::with_prolongation(a, &stokes.prolongation, None, &params);
    let mass = || MassInverse::new(system.pressure_mass(), 3).expect("a mass matrix");
    let build = |form| {
        BlockPreconditionerBuilder::new(system.rows())
            .block("velocity", 0..split, velocity().expect("set-up"))
            .schur_complement("pressure", split..system.rows(), mass())
            .coupling("velocity", "pressure", Gradient(system))
            .build(form)
            .expect("blocks that fit")
    };
    let b = body_forces(system);
    let iterations = |preconditioner: &mut dyn Preconditioner| {
        let mut x = vec![0.0; b.len()];
        let report = fgmres(system, preconditioner, &b, &mut x, &tolerance(1e-8));
        report.expect("convergence").iterations
    };
    let mut upper = build(BlockForm::Upper);
    assert!(iterations(&mut upper) <= 60);
    // by hand: `z_p = -N_p r_p`, `z_a = V (r_a - G z_p)`
    let (r, mut z, mut expected) = (noise(b.len()), vec![0.0; b.len()], vec![0.0; b.len()]);
    upper.apply(&r, &mut z);
    mass().apply(&r[split..], &mut expected[split..]);
    expected[split..].iter_mut().for_each(|z| *z = -*z);
    let mut residual = vec![0.0; split];
    Gradient(system).apply(&expected[split..], &mut residual);
    for (residual, r) in residual.iter_mut().zip(&r) {
        *residual = r - *residual;
    }
    let mut cycle = velocity().expect("set-up");
    cycle.apply(&residual, &mut expected[..split]);
    assert_eq!(z, expected);
    let mut x = vec![0.0; b.len()];
    minres(
        system,
        &mut build(BlockForm::Diagonal),
        &b,
        &mut x,
        &tolerance(1e-6),
    )
    .expect("the diagonal form is positive definite");
}

/// Every mistake is an error that names the block.
#[test]
fn blocks_that_do_not_fit_are_refused() {
    let builder = || BlockPreconditionerBuilder::new(5).block("velocity", 0..3, Identity(3));
    let full = || builder().block("pressure", 3..5, Identity(2));
    let square = || dense(2, 2, |_, _| 1.0);
    let cases = [
        (BlockPreconditionerBuilder::new(5), "", "0..5"),
        (builder(), "velocity", "3..5"),
        (
            builder().block("pressure", 4..5, Identity(1)),
            "pressure",
            "3..4",
        ),
        (
            builder().block("pressure", 2..5, Identity(3)),
            "pressure",
            "overlaps",
        ),
        (
            builder().block("pressure", 3..6, Identity(3)),
            "pressure",
            "0..5",
        ),
        (
            builder().block("pressure", 3..5, Identity(1)),
            "pressure",
            "1 rows",
        ),
        (
            builder().block("velocity", 3..5, Identity(2)),
            "velocity",
            "two blocks",
        ),
        (
            full().coupling("velocity", "salt", square()),
            "salt",
            "pressure",
        ),
        (
            full().coupling("velocity", "pressure", square()),
            "velocity",
            "(3, 2)",
        ),
        (
            full().coupling("pressure", "pressure", square()),
            "pressure",
            "itself",
        ),
        (full(), "velocity", "BlockForm::Diagonal"),
    ];
    for (builder, name, word) in cases {
        match builder.build(BlockForm::Upper).map(|_| ()) {
            Err(LinalgError::Block { block, problem }) => {
                assert!(
                    block == name && problem.contains(word),
                    "{block}: {problem}"
                );
            }
            other => panic!("{name}: {other:?}"),
        }
    }
    let twice = |b: BlockPreconditionerBuilder<'static>| {
        b.coupling("velocity", "pressure", dense(3, 2, |_, _| 1.0))
    };
    assert!(twice(twice(full())).build(BlockForm::Diagonal).is_err());
    assert!(full().build(BlockForm::Diagonal).is_ok());
    assert!(twice(full()).build(BlockForm::Upper).is_ok());
    // The only coupling lies in the other triangle.
    assert!(twice(full()).build(BlockForm::Lower).is_err());
    let unsymmetric = dense(2, 2, |i, _| i as f64);
    let kind = PreconditionerKind::PositiveDefinite;
    assert!(ExplicitInverse::new(unsymmetric, kind).is_err());
    assert!(ExplicitInverse::new(dense(2, 3, |_, _| 0.0), PreconditionerKind::Linear).is_err());
}
