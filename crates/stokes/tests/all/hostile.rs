//! Every public function on hostile arguments: a right answer or an error, never a panic.

use fem::TaylorHood;
use mesh::{LinearTets, TetMesh, Vec3};
use mesher::Container;
use rigid::{
    Arms, Articulation, BodyKind, DirectRows, Drive, Eliminated, ExternalLoad, Formulation,
    Independent, Lagrange,
};
use stokes::{InitialGuesses, Options, Problem, Solver, StokesError, solve_stokes};

use crate::support::sphere_in_ball;

const HOSTILE: [f64; 8] = [
    0.0,
    -1.0,
    5e-324,
    1e-300,
    1e300,
    f64::MAX,
    f64::NAN,
    f64::INFINITY,
];

/// A sphere in a concentric ball, as coarse as possible.
fn coarse_ball() -> TetMesh {
    sphere_in_ball(0.9, 4.0, [false; 3])
}

fn problem(mesh: &TetMesh) -> Problem<'_> {
    Problem::new(mesh, &[("sphere", Vec3::zeros())], &[Container::TAG]).unwrap()
}

/// Solves for a unit force on the body, and returns its velocity.
fn speed(problem: &Problem, x: Vec3, options: &Options) -> Result<f64, StokesError> {
    let set = Articulation::new(&[BodyKind::Rigid], Vec::new(), Arms::Clamped, &[x])?;
    let constraints = set.constraints(&set.initial_state(), &[], &[])?;
    let loads = [ExternalLoad {
        force: Vec3::x(),
        ..ExternalLoad::default()
    }];
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &loads,
    };
    Ok(problem.solve(&drive, options)?.flow.bodies[0])
}

#[test]
fn hostile_options_give_the_same_answer_or_are_refused() {
    let mesh = coarse_ball();
    let problem = problem(&mesh);
    let origin = Vec3::zeros();
    let right = speed(&problem, origin, &Options::default()).unwrap();
    for rtol in HOSTILE {
        assert!(
            speed(&problem, origin, &Options::default().with_rtol(rtol)).is_err(),
            "{rtol}"
        );
        assert!(problem.resistance(rtol).is_err(), "{rtol}");
    }
    let schwarz = [(0, 1), (1, usize::MAX), (2, 0), (usize::MAX, 1)];
    let schwarz = schwarz.map(|(subdomains, overlap)| Solver::Schwarz {
        subdomains,
        overlap,
    });
    let formulations: [&'static dyn Formulation; 4] =
        [&Eliminated, &Independent, &Lagrange, &DirectRows];
    for solver in schwarz
        .into_iter()
        .chain([Solver::Block, Solver::Direct, Solver::Minres])
    {
        for formulation in formulations {
            let options = Options::default()
                .with_solver(solver)
                .with_formulation(formulation);
            match speed(&problem, origin, &options) {
                Ok(found) => assert!((found / right - 1.0).abs() < 1e-5, "{solver:?}"),
                Err(error) => assert!(!matches!(solver, Solver::Block), "{solver:?} {error}"),
            }
        }
    }
}

#[test]
fn bodies_that_are_not_where_the_mesh_has_them_are_refused() {
    let mesh = coarse_ball();
    for x in HOSTILE.into_iter().filter(|x| x.abs() > 1e-300) {
        assert!(
            speed(&problem(&mesh), x * Vec3::x(), &Options::default()).is_err(),
            "{x}"
        );
        let centre = [("sphere", x * Vec3::x())];
        let moved = Problem::new(&mesh, &centre, &[Container::TAG]).unwrap();
        let found = speed(&moved, Vec3::zeros(), &Options::default());
        assert!(found.is_err(), "{x}");
        if !x.is_finite() {
            assert!(moved.resistance(1e-6).is_err(), "{x}");
        }
    }
}

#[test]
fn parts_that_are_given_twice_are_refused() {
    let mesh = coarse_ball();
    let x = Vec3::zeros();
    for (bodies, walls) in [
        (vec![("sphere", x), ("sphere", x)], vec![Container::TAG]),
        (vec![("sphere", x)], vec!["sphere"]),
        (vec![], vec![Container::TAG, Container::TAG]),
    ] {
        let refused = Problem::new(&mesh, &bodies, &walls).map(|_| ());
        assert!(matches!(refused, Err(StokesError::PartTwice { .. })));
    }
    // without a wall the flow is not unique; without a body there is nothing to move
    let free = Problem::new(&mesh, &[("sphere", x)], &[]).unwrap();
    assert!(speed(&free, x, &Options::default()).is_err());
    let empty = Problem::new(&mesh, &[], &[Container::TAG]).unwrap();
    assert!(speed(&empty, x, &Options::default()).is_err());
    let grand = empty.resistance(1e-6).unwrap();
    assert!(grand.resistance.is_empty() && grand.asymmetry == 0.0);
}

#[test]
fn data_of_another_mesh_and_hostile_data_are_refused() {
    let mesh = coarse_ball();
    let cube = TetMesh::straight(LinearTets::cube(1)).unwrap();
    let space = TaylorHood::new(&cube).unwrap();
    let origin = Vec3::zeros();
    let solve = |problem: Problem| speed(&problem, origin, &Options::default());
    assert!(solve(problem(&mesh).with_space(&space)).is_err());
    assert!(solve(problem(&mesh).with_permeability(vec![1.0])).is_err());
    assert!(solve(problem(&mesh).with_permeability(vec![f64::NAN; mesh.n_cells()])).is_err());
    InitialGuesses::new(usize::MAX).clear();
}

#[test]
fn flows_of_hostile_fields_are_finite_or_refused() {
    let mesh = TetMesh::straight(LinearTets::cube(2)).unwrap();
    for x in HOSTILE {
        let flow = solve_stokes(&mesh, &|at| x * Vec3::new(at.y, 0.0, 0.0), None, 1e-8);
        let forced = solve_stokes(&mesh, &|_| Vec3::zeros(), Some(&|at| x * at), 1e-8);
        if [0.0, -1.0].contains(&x) {
            assert!(flow.is_ok() && forced.is_ok(), "{x}");
        }
        for flow in [flow, forced].into_iter().flatten() {
            assert!(
                flow.velocity
                    .iter()
                    .all(|u| u.iter().all(|c| c.is_finite())),
                "{x}"
            );
            assert!(flow.pressure.iter().all(|p| p.is_finite()), "{x}");
        }
        assert!(solve_stokes(&mesh, &|at| at.yzx(), None, x).is_err(), "{x}");
    }
}
