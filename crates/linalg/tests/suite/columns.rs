//! Several right-hand sides solved together give the results of single solves, to the last bit.

use super::support::{
    Stokes, assert_same_on_one_and_two_threads, body_forces, noise, tolerance, two_bodies,
};
use linalg::{
    BlockDiagonal, BlockTriangular, Bordered, Identity, KrylovParams, LinalgError, LinearOperator,
    Multigrid, MultigridParams, Preconditioner, SaddleSystem, SolveReport, fgmres, fgmres_columns,
};

/// Right-hand sides in the range of the system: forces on the bodies, random, zero, and tiny.
fn right_hand_sides(system: &SaddleSystem, count: usize) -> Vec<Vec<f64>> {
    let product = |seed: usize| {
        let x = &noise(system.rows() + seed)[seed..];
        let mut b = vec![0.0; x.len()];
        system.apply(x, &mut b);
        b
    };
    let column = |c: usize| match c % 4 {
        0 => body_forces(system)
            .iter()
            .map(|v| v.powi(c as i32 + 1))
            .collect(),
        1 => product(c),
        2 => vec![0.0; system.rows()],
        _ => product(c).iter().map(|v| 1e-30 * v).collect(),
    };
    (0..count).map(column).collect()
}

/// Flat vectors as columns.
fn columns(vectors: &mut [Vec<f64>]) -> Vec<&mut [f64]> {
    vectors.iter_mut().map(Vec::as_mut_slice).collect()
}

type Solved = (Vec<Vec<f64>>, Vec<SolveReport>);

fn together(stokes: &Stokes, b: &[Vec<f64>], params: &KrylovParams) -> Solved {
    let system = &stokes.system;
    let mut block =
        BlockTriangular::with_prolongation(system, &stokes.prolongation).expect("set-up");
    let mut x: Vec<_> = (0..b.len()).map(|_| vec![0.0; system.rows()]).collect();
    let b: Vec<&[f64]> = b.iter().map(Vec::as_slice).collect();
    let reports = fgmres_columns(system, &mut block, &b, &mut columns(&mut x), params);
    (x, reports.expect("convergence"))
}

fn one_by_one(stokes: &Stokes, b: &[Vec<f64>], params: &KrylovParams) -> Solved {
    let system = &stokes.system;
    let mut block =
        BlockTriangular::with_prolongation(system, &stokes.prolongation).expect("set-up");
    let solve = |b: &Vec<f64>| {
        let mut x = vec![0.0; system.rows()];
        let report = fgmres(system, &mut block, b, &mut x, params).expect("convergence");
        (x, report)
    };
    b.iter().map(solve).unzip()
}

#[test]
fn solving_together_equals_solving_one_by_one() {
    let stokes = two_bodies(1);
    for (count, params) in [
        (1, tolerance(1e-8)),
        (3, tolerance(1e-4)),
        (7, tolerance(1e-8)),
        // columns that restart in different iterations
        (5, tolerance(1e-6).with_restart(4)),
    ] {
        let b = right_hand_sides(&stokes.system, count);
        assert!(together(&stokes, &b, &params) == one_by_one(&stokes, &b, &params));
    }
}

#[test]
fn solving_together_is_bitwise_the_same_on_one_and_two_threads() {
    let stokes = two_bodies(1);
    let b = right_hand_sides(&stokes.system, 4);
    assert_same_on_one_and_two_threads(|| together(&stokes, &b, &tolerance(1e-8)));
}

/// Every operator and preconditioner, after a pass of another width, so that buffers contain old
/// data.
#[test]
fn passes_for_several_columns_equal_single_passes() {
    let stokes = two_bodies(1);
    let system = &stokes.system;
    let a = system.velocity_block();
    let scalar = Bordered::scalar(a.stiffness().clone()).expect("positive");
    let params = MultigridParams::default();
    let prolongation = &stokes.prolongation;
    let block = BlockTriangular::with_prolongation(system, prolongation).expect("set-up");
    let gaps = block
        .with_pressure_laplacian(system.pressure_mass())
        .expect("positive");
    let mut preconditioners: [Box<dyn Preconditioner>; 5] = [
        Box::new(gaps),
        Box::new(Multigrid::with_prolongation(a, prolongation, None, &params).expect("set-up")),
        Box::new(Multigrid::new(&scalar, &MultigridParams::direct()).expect("set-up")),
        Box::new(BlockTriangular::with_prolongation(system, prolongation).expect("set-up")),
        Box::new(BlockDiagonal::with_prolongation(system, prolongation).expect("set-up")),
    ];
    for count in [2, 6, 1, 4, 13, 3] {
        for operator in [a as &dyn LinearOperator, &scalar, system] {
            let n = operator.rows();
            let x: Vec<_> = (0..count).map(|c| noise(n + c)[c..].to_vec()).collect();
            let x: Vec<&[f64]> = x.iter().map(Vec::as_slice).collect();
            let [mut y, mut alone] = [(); 2].map(|()| vec![vec![0.0; n]; count]);
            operator.apply_columns(&x, &mut columns(&mut y));
            x.iter()
                .zip(&mut alone)
                .for_each(|(x, y)| operator.apply(x, y));
            assert!(y == alone);
        }
        for preconditioner in &mut preconditioners {
            let n = preconditioner.size();
            // columns of different sizes, since each is scaled separately
            let column = |c: usize| {
                noise(n + c)[c..]
                    .iter()
                    .map(|v| v * 10_f64.powi(c as i32))
                    .collect()
            };
            let r: Vec<Vec<f64>> = (0..count).map(column).collect();
            let r: Vec<&[f64]> = r.iter().map(Vec::as_slice).collect();
            let [mut z, mut alone] = [(); 2].map(|()| vec![vec![0.0; n]; count]);
            preconditioner.apply_columns(&r, &mut columns(&mut z));
            r.iter()
                .zip(&mut alone)
                .for_each(|(r, z)| preconditioner.apply(r, z));
            assert!(z == alone);
        }
    }
}

#[test]
fn one_failing_column_is_an_error() {
    let a = Bordered::scalar(linalg::Csr::eye(2)).expect("positive");
    let good: &[f64] = &[1.0; 6];
    let bad: &[f64] = &[1.0, 1.0, f64::NAN, 1.0, 1.0, 1.0];
    let mut x = vec![vec![0.0; 6]; 2];
    let params = KrylovParams::default();
    let found = fgmres_columns(
        &a,
        &mut Identity(6),
        &[good, bad],
        &mut columns(&mut x),
        &params,
    );
    assert!(matches!(
        found,
        Err(LinalgError::NotFinite { index: 2, .. })
    ));
    let found = fgmres_columns(&a, &mut Identity(6), &[good], &mut columns(&mut x), &params);
    assert!(matches!(found, Err(LinalgError::Shape { .. })));
    let none = fgmres_columns(&a, &mut Identity(6), &[], &mut [], &params);
    assert!(none.expect("nothing to do").is_empty());
}
