//! Names of boundary parts, and the agreement of one and several drives.

use mesh::{LinearTets, MeshError, TetMesh};
use mesher::Container;
use nalgebra::Vector3;
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad};
use stokes::{InitialGuesses, Options, Problem, Seconds, StokesError};

use crate::support::{SPHERE, sphere_in_ball};

fn is_unknown(result: Result<Problem, StokesError>, name: &str) -> bool {
    match result {
        Err(StokesError::Mesh(MeshError::UnknownTag { name: found, .. })) => found == name,
        _ => false,
    }
}

#[test]
fn unknown_names_of_bodies_walls_and_spheres_are_refused() {
    let mesh = TetMesh::straight(LinearTets::cube(1)).unwrap();
    let origin = Vector3::zeros();
    assert!(is_unknown(
        Problem::new(&mesh, &[("sphere", origin)], &["z0"]),
        "sphere"
    ));
    assert!(is_unknown(Problem::new(&mesh, &[], &["z0", "lid"]), "lid"));
    let problem = Problem::new(&mesh, &[("z1", origin)], &["z0"]).unwrap();
    assert!(is_unknown(
        problem.with_surfaces(&[("ball", &SPHERE)]),
        "ball"
    ));
}

/// A sphere that a unit force drags through a concentric ball, by `solve` and by `solve_all`.
#[test]
fn velocity_of_a_dragged_sphere_is_force_times_mobility() {
    let mesh = sphere_in_ball(0.8, 10.0, [false; 3]);
    let problem = Problem::new(&mesh, &[("sphere", SPHERE.centre)], &[Container::TAG]).unwrap();

    let set = Articulation::new(
        &[BodyKind::Rigid],
        Vec::new(),
        Arms::Clamped,
        &[SPHERE.centre],
    )
    .unwrap();
    let load = ExternalLoad {
        force: Vector3::x(),
        torque: Vector3::zeros(),
    };
    let constraints = set.constraints(&set.initial_state(), &[], &[]).unwrap();
    let drive = || Drive {
        set: &set,
        constraints: &constraints,
        loads: std::slice::from_ref(&load),
    };
    let options = Options::default();
    let solution = problem.solve(&drive(), &options).unwrap();
    // Residuals of 1e-8 leave an asymmetry of that size, which the mean of both halves removes.
    let resistance = problem.resistance(1e-8).unwrap();
    assert!(
        (1e-16..1e-6).contains(&resistance.asymmetry),
        "{:e}",
        resistance.asymmetry
    );
    let mobility = resistance.mobility;
    assert_eq!(mobility, mobility.transpose());
    assert!((solution.flow.bodies[0] / mobility[(0, 0)] - 1.0).abs() < 1e-6);
    assert!((solution.flow.forces[0] - 1.0).abs() < 1e-6);
    assert!(solution.estimate.is_none() && solution.checks.is_none());
    // The pressure of an enclosed flow has zero mean, up to rounding of pressures of order 1/10.
    let mean = fem::mean_pressure(&mesh, &solution.flow.pressure).unwrap();
    assert!(mean.abs() < 1e-14, "{mean:e}");
    // The bar of the algebraic error is twice a residual below 1e-8.
    assert!(
        (1e-13..=1e-8).contains(&solution.algebraic_error),
        "{:e}",
        solution.algebraic_error
    );

    let mut guesses = InitialGuesses::new(1);
    let surplus = fem::SurplusSpace::new(&mesh).unwrap();
    let mut solutions = problem
        .solve_all(&[drive(), drive()], &options, &mut guesses, Some(&surplus))
        .unwrap();
    assert_eq!(solutions.len(), 2);
    for other in solutions.drain(..) {
        assert!((other.flow.bodies[0] / solution.flow.bodies[0] - 1.0).abs() < 1e-8);
        let estimate = other.estimate.unwrap();
        // The computed velocity is too small, because finite elements are too stiff.
        let change = estimate.change.state.frames[0].linear.x;
        assert!(0.0 < change && change < 0.05 * solution.flow.bodies[0]);
        assert!(estimate.uncertainty < change && estimate.relative_uncertainty < 1.0);
        // The load is given.
        assert_eq!(estimate.change.forces.amax(), 0.0);
        let mut corrected = other.flow.clone();
        corrected.add(&estimate.change).unwrap();
        assert_eq!(corrected.bodies[0], other.flow.bodies[0] + change);
        assert!(other.checks.unwrap().dissipation.abs() < 0.1);
        let seconds = other.seconds;
        let parts = [
            seconds.assembly,
            seconds.setup,
            seconds.solve,
            seconds.estimate,
        ];
        let sum: f64 = parts.iter().sum();
        assert!((seconds.total / sum - 1.0).abs() < 1e-12, "{seconds:?}");
        assert!(seconds.solve > 0.0 && seconds.estimate > 0.0);
    }
}

#[test]
fn no_drives_have_no_solutions() {
    let mesh = TetMesh::straight(LinearTets::cube(1)).unwrap();
    let problem = Problem::new(&mesh, &[], &["z0"]).unwrap();
    let mut guesses = InitialGuesses::new(0);
    let solutions = problem.solve_all(&[], &Options::default(), &mut guesses, None);
    assert!(solutions.unwrap().is_empty());
}

#[test]
fn seconds_of_several_solutions_are_added_part_by_part() {
    let seconds = |unit: f64| Seconds {
        mesh: unit,
        assembly: 2.0 * unit,
        setup: 3.0 * unit,
        solve: 4.0 * unit,
        estimate: 5.0 * unit,
        total: 15.0 * unit,
    };
    let mut sum = seconds(1.0);
    sum += seconds(0.5);
    assert_eq!(sum, seconds(1.5));
}
