//! Every solver on hard cases: each gives a right answer or an error that names the cause.

use super::support::{
    Stokes, body_forces, cube, linked_pair, prolongation_for, relative_difference, tolerance,
    true_residual, with_border,
};
use linalg::{
    BlockDiagonal, BlockTriangular, Bordered, Csr, Csr3, DirectParams, KrylovParams, LinalgError,
    LinearOperator, Prolongation, SaddleLdlt, SaddleSystem, Schwarz, SchwarzParams, SolveReport,
    fgmres, minres,
};
use nalgebra::DMatrix;

#[derive(Debug, Clone, Copy, PartialEq)]
enum Solver {
    Block,
    Minres,
    Schwarz,
    DirectSingle,
    DirectDouble,
}

const ALL: [Solver; 5] = [
    Solver::Block,
    Solver::Minres,
    Solver::Schwarz,
    Solver::DirectSingle,
    Solver::DirectDouble,
];

impl Solver {
    fn solve(
        self,
        system: &SaddleSystem,
        prolongation: &Prolongation,
        b: &[f64],
        params: &KrylovParams,
    ) -> Result<(Vec<f64>, SolveReport), LinalgError> {
        let mut x = vec![0.0; b.len()];
        let report = match self {
            Solver::Block => {
                let mut pre = BlockTriangular::with_prolongation(system, prolongation)?;
                fgmres(system, &mut pre, b, &mut x, params)
            }
            Solver::Minres => {
                let mut pre = BlockDiagonal::with_prolongation(system, prolongation)?;
                minres(system, &mut pre, b, &mut x, params)
            }
            Solver::Schwarz => {
                let cut = SchwarzParams::default().with_subdomains(2);
                let mut pre = Schwarz::new(system, &cut)?;
                fgmres(system, &mut pre, b, &mut x, params)
            }
            Solver::DirectSingle => {
                SaddleLdlt::factor(system, &DirectParams::default())?.solve(b, &mut x)
            }
            Solver::DirectDouble => {
                SaddleLdlt::factor(system, &DirectParams::double())?.solve(b, &mut x)
            }
        }?;
        // the reported residual is not trusted
        assert!(x.iter().all(|v| v.is_finite()), "{self:?}");
        assert!(
            b.iter().all(|v| *v == 0.0) || true_residual(system, b, &x) <= params.rel_tol,
            "{self:?} marked a wrong answer converged"
        );
        Ok((x, report))
    }
}

fn small() -> Stokes {
    Stokes::new(5, &[cube([2; 3], 1)], 5.0)
}

#[test]
fn zero_right_hand_sides_have_the_zero_solution() {
    let stokes = small();
    let b = vec![0.0; stokes.system.rows()];
    for solver in ALL {
        let solved = solver.solve(&stokes.system, &stokes.prolongation, &b, &tolerance(1e-8));
        let (x, report) = solved.expect("zero");
        assert!(report.iterations == 0 && x.iter().all(|v| *v == 0.0));
    }
}

/// The blocks of a system, to be corrupted one at a time.
#[derive(Clone)]
struct Parts {
    k: Csr,
    c: Csr,
    corner: DMatrix<f64>,
    b: Csr3,
    e: Csr,
    mass: Csr,
}

impl Parts {
    fn of(system: &SaddleSystem) -> Self {
        let a = system.velocity_block();
        Parts {
            k: a.stiffness().clone(),
            c: a.border().clone(),
            corner: a.corner().clone(),
            b: system.divergence().clone(),
            e: system.border_divergence().clone(),
            mass: system.pressure_mass().clone(),
        }
    }

    fn system(self) -> Result<SaddleSystem, LinalgError> {
        let a = Bordered::new(self.k, self.c, None, self.corner)?;
        SaddleSystem::new(a, self.b, self.e, None, self.mass)
    }
}

#[test]
fn nan_and_infinity_are_found_in_every_block() {
    let sound = Parts::of(&small().system);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let spoils: [fn(&mut Parts, f64); 6] = [
            |p, v| p.k.data_mut()[3] = v,
            |p, v| p.c.data_mut()[3] = v,
            |p, v| p.corner[(2, 1)] = v,
            |p, v| p.b.data_mut()[3][1] = v,
            |p, v| p.e.data_mut()[3] = v,
            |p, v| p.mass.data_mut()[3] = v,
        ];
        for spoil in spoils {
            let mut parts = sound.clone();
            spoil(&mut parts, bad);
            let error = parts.system().map(|_| ());
            assert!(
                matches!(error, Err(LinalgError::NotFinite { .. })),
                "{error:?}"
            );
        }
    }
    let stokes = small();
    let mut b = body_forces(&stokes.system);
    b[17] = f64::NAN;
    for solver in ALL {
        let error = solver.solve(&stokes.system, &stokes.prolongation, &b, &tolerance(1e-8));
        let error = error.map(|_| ());
        assert!(
            matches!(error, Err(LinalgError::NotFinite { index: 17, .. })),
            "{error:?}"
        );
    }
}

/// Two multipliers for one constraint, and a border dof without any coupling.
#[test]
fn rank_deficient_borders_are_reported() {
    let stokes = small();
    let plain = stokes.system.velocity_block().corner();
    let mut redundant = plain.clone().resize(8, 8, 0.0);
    for row in [6, 7] {
        redundant[(row, 0)] = 1.0;
        redundant[(0, row)] = 1.0;
    }
    for corner in [redundant, plain.clone().resize(7, 7, 0.0)] {
        let m = corner.nrows();
        let system = with_border(&stokes, corner, None).expect("shapes are sound");
        let b = body_forces(&system);
        for solver in ALL {
            let error = solver.solve(&system, &prolongation_for(&stokes, m), &b, &tolerance(1e-8));
            let error = error.map(|_| ()).expect_err("singular");
            assert!(error.to_string().contains("border"), "{solver:?} {error}");
        }
    }
}

/// Right-hand sides from 1e-140 to 1e140, and systems scaled by powers of two outside the range of
/// f32.
#[test]
fn solvers_do_not_depend_on_scaling() {
    let stokes = small();
    let b = body_forces(&stokes.system);
    let params = tolerance(1e-8);
    for solver in ALL {
        let solve = |system: &SaddleSystem, b: &[f64]| {
            let (x, _) = solver
                .solve(system, &stokes.prolongation, b, &params)
                .expect("solved");
            x[..system.pressure_range().start].to_vec()
        };
        let unit = solve(&stokes.system, &b);
        for size in [1e-140, 1e140] {
            let large: Vec<f64> = b.iter().map(|v| v * size).collect();
            let scaled: Vec<f64> = unit.iter().map(|v| v * size).collect();
            // two solves to 1e-8, amplified by the condition number of the resistance, about ten
            assert!(relative_difference(&solve(&stokes.system, &large), &scaled) < 1e-6);
        }
        for exponent in [-300, 300] {
            let s = 2f64.powi(exponent);
            let mut parts = Parts::of(&stokes.system);
            for matrix in [&mut parts.k, &mut parts.c, &mut parts.e, &mut parts.mass] {
                matrix.data_mut().iter_mut().for_each(|v| *v *= s);
            }
            parts.corner *= s;
            parts
                .b
                .data_mut()
                .as_flattened_mut()
                .iter_mut()
                .for_each(|v| *v *= s);
            let system = parts.system().expect("a sound system");
            let scaled: Vec<f64> = unit.iter().map(|v| v / s).collect();
            assert!(
                relative_difference(&solve(&system, &b), &scaled) < 1e-6,
                "{solver:?}"
            );
        }
    }
    // squares underflow: there is no norm for relative residuals
    let tiny: Vec<f64> = b.iter().map(|v| v * 1e-200).collect();
    for solver in ALL {
        let error = solver.solve(&stokes.system, &stokes.prolongation, &tiny, &params);
        assert!(matches!(error, Err(LinalgError::Parameter { .. })));
    }
}

/// A stiffness much larger than the divergence: a small residual would not bound the divergence, so
/// the system is refused.
#[test]
fn bug_a_huge_viscosity_hid_the_divergence_from_the_residual() {
    let mut parts = Parts::of(&small().system);
    for matrix in [&mut parts.k, &mut parts.c] {
        matrix.data_mut().iter_mut().for_each(|v| *v *= 1e9);
    }
    parts.corner *= 1e9;
    parts.mass.data_mut().iter_mut().for_each(|v| *v *= 1e-9);
    let error = parts.system().map(|_| ());
    assert!(
        matches!(error, Err(LinalgError::Unbalanced { .. })),
        "{error:?}"
    );
}

/// A tiny viscosity requires a divergence below rounding: the solver converges or stagnates.
#[test]
fn a_tiny_viscosity_is_solved_or_stagnates() {
    let unit = small();
    let tiny = Stokes::with_viscosity(5, &[cube([2; 3], 1)], 5.0, 1e-9);
    let b = body_forces(&unit.system);
    for solver in ALL {
        let params = tolerance(1e-8);
        let (exact, _) = solver
            .solve(&unit.system, &unit.prolongation, &b, &params)
            .expect("solved");
        match solver.solve(&tiny.system, &tiny.prolongation, &b, &params) {
            Ok((x, _)) => {
                let border = unit.system.border_range();
                let scaled: Vec<f64> = x[border.clone()].iter().map(|v| v * 1e-9).collect();
                assert!(
                    relative_difference(&scaled, &exact[border]) < 1e-6,
                    "{solver:?}"
                );
            }
            Err(LinalgError::Stagnated { .. } | LinalgError::NotConverged { .. }) => {}
            Err(error) => panic!("{solver:?} {error}"),
        }
    }
}

/// Net flux out of an enclosed domain: no solution exists.
#[test]
fn incompatible_right_hand_sides_are_errors() {
    let stokes = small();
    let mut b = body_forces(&stokes.system);
    b[stokes.system.pressure_range()].fill(1.0);
    for solver in ALL {
        let error = solver.solve(&stokes.system, &stokes.prolongation, &b, &tolerance(1e-8));
        let stuck = matches!(
            error,
            Err(LinalgError::Stagnated { .. } | LinalgError::NotConverged { .. })
        );
        assert!(stuck, "{solver:?} {:?}", error.map(|_| ()));
    }
}

#[test]
fn iteration_limits_are_errors_with_the_residual() {
    let (stokes, constrained) = linked_pair();
    let prolongation = prolongation_for(&stokes, constrained.border_range().len());
    let b = body_forces(&constrained);
    let params = tolerance(1e-10).with_max_iterations(2);
    for solver in [Solver::Block, Solver::Minres, Solver::Schwarz] {
        let error = solver
            .solve(&constrained, &prolongation, &b, &params)
            .map(|_| ());
        let Err(LinalgError::NotConverged {
            iterations: 2,
            true_rel_residual,
            ..
        }) = error
        else {
            panic!("{solver:?} {error:?}");
        };
        assert!(true_rel_residual > 1e-10 && true_rel_residual.is_finite());
    }
}

/// With a shift of almost zero, the pressure pivots are rounding errors.
#[test]
fn factors_without_a_shift_are_refused_or_refined() {
    let system = small().system;
    let b = body_forces(&system);
    let factor = |shift| {
        let params = DirectParams::double().with_shift(shift);
        let mut x = vec![0.0; b.len()];
        let report = SaddleLdlt::factor(&system, &params)?.solve(&b, &mut x)?;
        assert!(true_residual(&system, &b, &x) <= 1e-12);
        Ok(report)
    };
    for shift in [0.0, -1e-8, f64::NAN, 1.0] {
        let refused = factor(shift);
        assert!(matches!(
            refused,
            Err(LinalgError::Parameter { name: "shift", .. })
        ));
    }
    let unshifted = factor(1e-300);
    assert!(
        matches!(
            unshifted,
            Ok(_)
                | Err(LinalgError::Factorisation { .. }
                    | LinalgError::Stagnated { .. }
                    | LinalgError::NotConverged { .. }
                    | LinalgError::Breakdown { .. })
        ),
        "{unshifted:?}"
    );
}

/// Stiffness matrices that are not symmetric positive definite.
#[test]
fn indefinite_or_unsymmetric_stiffness_is_reported() {
    let stokes = small();
    let b = body_forces(&stokes.system);
    let system = |change: &dyn Fn(usize, usize, f64) -> f64| {
        let mut parts = Parts::of(&stokes.system);
        let mut k = sprs::TriMatI::<f64, u32>::new(parts.k.shape());
        for (v, (i, j)) in parts.k.iter() {
            let value = change(i as usize, j as usize, *v);
            if value != 0.0 {
                k.add_triplet(i as usize, j as usize, value);
            }
        }
        parts.k = k.to_csr();
        parts.system()
    };
    // positive diagonal, negative eigenvalue
    let indefinite = system(&|i, j, v| if i == j { v } else { 3.0 * v }).expect("sound to look at");
    // an entry whose symmetric counterpart is missing
    let one_way = system(&|i, j, v| if i == 0 && j != 0 { 0.0 } else { v });
    let one_way = one_way.expect("sound to look at");
    for solver in ALL {
        let solve = |system| solver.solve(system, &stokes.prolongation, &b, &tolerance(1e-8));
        let preconditioned = matches!(solver, Solver::Block | Solver::Minres);
        // solvers that order a graph find the missing entry; others stagnate or get a right answer,
        // as checked by `solve`
        match solve(&one_way) {
            Ok(_) => assert!(preconditioned, "{solver:?}"),
            Err(LinalgError::Factorisation { .. }) => {}
            Err(LinalgError::Stagnated { .. } | LinalgError::NotConverged { .. }) => {
                assert!(preconditioned, "{solver:?}");
            }
            Err(error) => panic!("{solver:?} {error}"),
        }
        // factors may exist and are then refined: `solve` has checked the residual
        if let Err(error) = solve(&indefinite) {
            println!("{solver:?}: {error}");
        }
        if preconditioned {
            assert!(matches!(
                solve(&indefinite),
                Err(LinalgError::Factorisation { .. })
            ));
        }
    }
    let zero = system(&|i, j, v| if i == 5 && j == 5 { 0.0 } else { v }).map(|_| ());
    assert!(matches!(zero, Err(LinalgError::NotPositive { row: 5, .. })));
}

/// Nearly a rotation by 90 degrees in two large rows, which one iteration hardly improves.
struct LargeRotation;

impl LinearOperator for LargeRotation {
    fn rows(&self) -> usize {
        3
    }
    fn cols(&self) -> usize {
        3
    }
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        y[0] = x[0];
        y[1] = 1e8 * (0.05 * x[1] + x[2]);
        y[2] = 1e8 * (0.05 * x[2] - x[1]);
    }
    fn residual_weights(&self) -> Option<&[f32]> {
        Some(&[1.0, 1e-8, 1e-8])
    }
}

/// The start was converged in the weighted norm but not in the Euclidean one; the first cycle then
/// ended after one iteration, which counted as stagnation.
#[test]
fn bug_a_start_that_is_converged_in_one_norm_was_said_to_stagnate() {
    let (b, mut x) = ([1.0, 1.0, 0.0], vec![0.0; 3]);
    // the solution, with a residual of 1e-6 in the second row
    let determinant = 1e8 * (0.05_f64.powi(2) + 1.0);
    x[0] = 1.0;
    x[1] = 0.05 * (1.0 + 1e-6) / determinant;
    x[2] = (1.0 + 1e-6) / determinant;
    let mut identity = linalg::Identity(3);
    let report = fgmres(
        &LargeRotation,
        &mut identity,
        &b,
        &mut x,
        &KrylovParams::default(),
    )
    .expect("two more iterations");
    assert!(report.true_rel_residual <= 1e-8);
}

/// A preconditioner with inertia inverts `L / κ + E G^-1 E^T` for each mass of the border.
#[test]
fn inertia_in_the_schur_complement_contains_the_motions_of_the_border() {
    // One free node, one border dof, three pressures: K = 1 + κ M with κ M = 4.
    let csr = |rows: usize, cols: usize, dense: &[f64]| {
        let (mut pointers, mut indices, mut values) = (vec![0], vec![], vec![]);
        for row in dense.chunks(cols) {
            for (column, value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                indices.push(column as u32);
                values.push(*value);
            }
            pointers.push(indices.len());
        }
        Csr::new((rows, cols), pointers, indices, values)
    };
    let laplacian = DMatrix::from_row_slice(3, 3, &[2., -1., -1., -1., 2., -1., -1., -1., 2.]);
    let e = DMatrix::from_column_slice(3, 1, &[0.5, -0.5, 0.0]);
    for mass in [1e-6, 1.0, 1e6] {
        let corner = DMatrix::from_element(1, 1, mass);
        let border = Csr::zero((3, 1));
        let a = Bordered::new(csr(1, 1, &[5.0]), border, None, corner).expect("sound");
        let b = Csr3::new(
            (3, 1),
            vec![0, 1, 2, 3],
            vec![0, 0, 0],
            vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, -1.0, 0.0]],
        );
        let pressure_mass = csr(3, 3, &[0.5, 0., 0., 0., 0.5, 0., 0., 0., 0.5]);
        // the shift of the Laplacian is a multiple of the mass matrix
        let shifted = &laplacian + DMatrix::identity(3, 3) * 5e-4;
        let e_sparse = csr(3, 1, e.as_slice());
        let system = SaddleSystem::new(a, b, e_sparse, None, pressure_mass).expect("sound");
        let kappa = 4.0;
        let inertia = linalg::SchurInertia {
            coefficient: kappa,
            scale: 1.0,
            mass_diagonal: &[1.0],
            laplacian: &csr(3, 3, laplacian.as_slice()),
            convection: None,
        };
        let r = [0.0, 0.0, 0.0, 0.0, 1.0, -0.4, -0.6];
        let pressures = |inertia: Option<&linalg::SchurInertia>| {
            let a = system.velocity_block();
            let multigrid = linalg::Multigrid::new(a, &Default::default()).expect("sound");
            let mut block = BlockTriangular::new(&system, multigrid).expect("sound");
            if let Some(inertia) = inertia {
                block = block.with_inertia(inertia).expect("sound");
            }
            let mut z = [0.0; 7];
            linalg::Preconditioner::apply(&mut block, &r, &mut z);
            [4, 5, 6].map(|k| -z[k])
        };
        let (with, without) = (pressures(Some(&inertia)), pressures(None));
        let schur = shifted / kappa + &e * e.transpose() / mass;
        let expected = schur
            .lu()
            .solve(&nalgebra::DVector::from_column_slice(&r[4..]));
        let expected = expected.expect("regular");
        for k in 0..3 {
            let added = with[k] - without[k];
            // cycles run in f32, on a matrix with the condition 6e3
            assert!(
                (added - expected[k]).abs() < 1e-3 * expected.amax(),
                "{mass}: {added}"
            );
        }
    }
}
