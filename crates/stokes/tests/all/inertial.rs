//! Systems with terms of inertia: iterations, formulations, forces.

use std::f64::consts::PI;

use linalg::WarmStart;
use mesh::TetMesh;
use mesher::Container;
use nalgebra::{Matrix3, Matrix6, Vector3};
use rheology::Law;
use rigid::{
    Arms, Articulation, BodyKind, Constraints, DirectRows, Drive, Eliminated, ExternalLoad,
    Formulation, Lagrange,
};
use stokes::{InertialTerms, Options, Problem, Solver, StokesError};

use crate::support::sphere_in_ball;

type Vec3 = Vector3<f64>;

/// A free sphere of radius 1.
fn free_sphere() -> Articulation {
    Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &[Vec3::zeros()]).unwrap()
}

/// Constraints with the inertia of a sphere of radius 1 and this density times `factor`.
fn with_mass(set: &Articulation, density: f64, factor: f64) -> Constraints {
    let mut constraints = set.constraints(&set.initial_state(), &[], &[]).unwrap();
    let mass = density * 4.0 * PI / 3.0;
    let mut matrix = Matrix6::zeros();
    (matrix.fixed_view_mut::<3, 3>(0, 0)).copy_from(&(mass * Matrix3::identity()));
    (matrix.fixed_view_mut::<3, 3>(3, 3)).copy_from(&(0.4 * mass * Matrix3::identity()));
    constraints.body_damping = vec![(0, factor * matrix)];
    constraints
}

/// Flow past a sphere that vanishes on it, with the velocity 1 along z far away.
fn wind(mesh: &TetMesh) -> Vec<Vec3> {
    mesh.points().iter().map(wind_at).collect()
}

fn wind_at(x: &Vec3) -> Vec3 {
    Vec3::z() * (1.0 - x.norm().powi(-3))
}

/// Iterations to 1e-8 for a free sphere under a force, from a zero guess.
fn iterations(mesh: &TetMesh, kappa: f64, ratio: f64, reynolds: f64) -> usize {
    let set = free_sphere();
    let constraints = with_mass(&set, ratio, kappa);
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &[ExternalLoad {
            force: Vec3::z(),
            torque: Vec3::zeros(),
        }],
    };
    let wind = wind(mesh);
    let terms = InertialTerms {
        density: reynolds / 2.0,
        coefficient: kappa,
        convecting: (reynolds > 0.0).then_some(&wind),
        ..InertialTerms::default()
    };
    let problem = Problem::new(mesh, &[("sphere", Vec3::zeros())], &[Container::TAG]).unwrap();
    let options = Options::default();
    let system = (problem.assemble_inertial(&drive, options.formulation, &terms)).unwrap();
    let (_, report) =
        (system.solve(mesh, &drive, &options, &mut WarmStart::new(0))).expect("convergence");
    report.iterations
}

/// Coefficients `κ` of steps of 1e3 to 1e-6 diffusion times, and of no step at all.
const COEFFICIENTS: [f64; 8] = [0.0, 1e-3, 0.1, 1.0, 1e1, 1e2, 1e4, 1e6];

/// Density ratios of the sphere and the fluid.
const RATIOS: [f64; 4] = [0.0, 1e-3, 1.0, 1e3];

#[test]
fn iterations_depend_neither_on_the_step_nor_on_the_mass_nor_on_the_mesh() {
    for size in [0.6, 0.3] {
        let mesh = sphere_in_ball(size, 5.0, [true, true, false]);
        for ratio in RATIOS {
            let row = COEFFICIENTS.map(|kappa| iterations(&mesh, kappa, ratio, 0.0));
            println!("size {size}, density ratio {ratio}: {row:?}");
            assert!(row.iter().all(|&iterations| iterations <= 30), "{row:?}");
        }
    }
}

/// With convection the iterations hardly grow where neither viscosity nor the mass matrix
/// dominates; without the diffusion of the pressures along it they were 47 at Re 50.
///
/// At Re 50, `ρ = 25`, `κ = 1` is a step of four times the time in which the fluid moves by a
/// diameter.
#[test]
fn iterations_with_convection() {
    let mesh = sphere_in_ball(0.4, 5.0, [true, true, false]);
    for (reynolds, most) in [(10.0, [30; 8]), (50.0, [36, 36, 36, 36, 32, 28, 28, 28])] {
        for ratio in RATIOS {
            let row = COEFFICIENTS.map(|kappa| iterations(&mesh, kappa, ratio, reynolds));
            println!("Re {reynolds}, density ratio {ratio}: {row:?}");
            assert!(
                row.iter().zip(&most).all(|(found, most)| found <= most),
                "{row:?}"
            );
        }
    }
}

/// Diagonal entries contain `-ρ/2 ∫ (∇·c) N_i²`: a convecting velocity that spreads, as a discrete
/// flow does in large cells, made some of them negative and the velocity block was refused.
#[test]
fn bug_a_convecting_velocity_with_a_divergence_made_the_velocity_block_negative() {
    let mesh = sphere_in_ball(0.6, 5.0, [true, true, false]);
    let set = free_sphere();
    let constraints = with_mass(&set, 1.0, 0.0);
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &[ExternalLoad::default()],
    };
    let problem = Problem::new(&mesh, &[("sphere", Vec3::zeros())], &[Container::TAG]).unwrap();
    let spreading: Vec<Vec3> = (mesh.points().iter())
        .map(|x| 0.2 * x + wind_at(x))
        .collect();
    let options = Options::default();
    let system = |divergence_of| {
        let terms = InertialTerms {
            density: 100.0,
            convecting: Some(&spreading),
            divergence_of,
            ..InertialTerms::default()
        };
        problem.assemble_inertial(&drive, options.formulation, &terms)
    };
    let refused = |error: rigid::RigidError| error.to_string();
    match system(None) {
        Err(error) => assert!(error.to_string().contains("diagonal"), "{error}"),
        Ok(system) => {
            let error = system.system.preconditioner().map(|_| ()).map_err(refused);
            assert!(
                error.as_ref().is_err_and(|e| e.contains("diagonal")),
                "{error:?}"
            );
        }
    }
    let system = system(Some(&spreading)).unwrap();
    system.system.preconditioner().unwrap();
}

/// Two spheres that a slide joins, with convection and masses, in all formulations.
#[test]
fn all_formulations_give_the_same_step() {
    let centres = [-1.6, 1.6].map(|z| Vec3::new(0.0, 0.0, z));
    let spheres = centres.map(|centre| mesher::Sphere {
        centre,
        radius: 1.0,
    });
    let ball = mesher::Sphere {
        centre: Vec3::zeros(),
        radius: 5.0,
    };
    let names = ["first", "second"];
    let parts: Vec<mesher::MeshedBody> = (names.iter().zip(&spheres))
        .map(|(name, surface)| mesher::MeshedBody {
            name,
            surface,
            size: 0.9,
        })
        .collect();
    let tets = mesher::generate(&parts, &Container::Ball(ball), &Default::default()).unwrap();
    let mesh = TetMesh::curved(
        tets.mesh,
        &[
            ("first", &spheres[0]),
            ("second", &spheres[1]),
            (Container::TAG, &ball),
        ],
    )
    .unwrap();
    let joint = rigid::Joint::slide("arm", 0, 1);
    let set = Articulation::new(&[BodyKind::Rigid; 2], vec![joint], Arms::Free, &centres).unwrap();
    let kappa = 8.0;
    let mut constraints = (set.constraints(&set.initial_state(), &[3.2], &[0.7])).unwrap();
    let mut mass = Matrix6::identity() * (3.0 * kappa);
    mass[(0, 0)] = 4.0 * kappa;
    constraints.body_damping = vec![(0, mass), (1, Matrix6::zeros())];
    let load = ExternalLoad {
        force: Vec3::new(0.3, -0.2, 1.0),
        torque: Vec3::new(0.1, 0.5, 0.0),
    };
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &[load, ExternalLoad::default()],
    };
    let field = |x: &Vec3| Vec3::new(x.y, x.z * x.z, 1.0 - x.x) * 0.2;
    let convecting: Vec<Vec3> = mesh.points().iter().map(field).collect();
    let known: Vec<Vec3> = mesh
        .points()
        .iter()
        .map(|x| 2.0 * field(&(x / 2.0)))
        .collect();
    let terms = InertialTerms {
        density: 6.0,
        coefficient: kappa,
        force: Some(&known),
        convecting: Some(&convecting),
        ..InertialTerms::default()
    };
    let bodies = [("first", centres[0]), ("second", centres[1])];
    let problem = Problem::new(&mesh, &bodies, &[Container::TAG]).unwrap();
    let solve = |formulation: &'static dyn Formulation, terms: &InertialTerms, solver| {
        let options = Options::default()
            .with_formulation(formulation)
            .with_solver(solver)
            .with_rtol(1e-12);
        let system = problem.assemble_inertial(&drive, formulation, terms)?;
        let (flow, report) = system.solve(&mesh, &drive, &options, &mut WarmStart::new(0))?;
        println!("{}: {} iterations", formulation.name(), report.iterations);
        Ok::<_, StokesError>(flow)
    };
    let formulations: [&'static dyn Formulation; 3] = [&Eliminated, &Lagrange, &DirectRows];
    let flows = formulations.map(|f| solve(f, &terms, Solver::Block).unwrap());
    let linear = InertialTerms {
        convecting: None,
        ..terms
    };
    let direct = formulations.map(|f| solve(f, &linear, Solver::Direct).unwrap());
    let iterative = solve(&Eliminated, &linear, Solver::Block).unwrap();
    for (flows, reference) in [(&flows, &flows[0]), (&direct, &iterative)] {
        for flow in flows.iter() {
            assert!((&flow.bodies - &reference.bodies).amax() < 1e-9);
            let size = reference.forces.amax();
            assert!((&flow.forces - &reference.forces).amax() < 1e-8 * size);
            let size = reference.joint_loads.amax();
            assert!((&flow.joint_loads - &reference.joint_loads).amax() < 1e-8 * size);
        }
    }
    // the loads on the linkage are balanced by the fluid and the rate of momentum
    let momentum = mass * flows[0].bodies.fixed_rows::<6>(0);
    for axis in 0..3 {
        let total = flows[0].forces[axis] + flows[0].forces[6 + axis] + momentum[axis];
        assert!((total - load.force[axis]).abs() < 1e-8 * load.force.norm());
    }
    // solvers for symmetric systems refuse convection
    for solver in [Solver::Direct, Solver::Minres] {
        let refused = solve(&Eliminated, &terms, solver).unwrap_err().to_string();
        assert!(refused.contains("symmetric"), "{refused}");
    }
}

/// With a law only the nonlinear solve is right.
#[test]
fn a_linear_system_of_a_fluid_with_a_law_is_refused() {
    let mesh = sphere_in_ball(0.8, 5.0, [true, true, false]);
    let set = free_sphere();
    let constraints = with_mass(&set, 1.0, 1.0);
    let drive = Drive {
        set: &set,
        constraints: &constraints,
        loads: &[ExternalLoad::default()],
    };
    let law = Law::Newtonian { viscosity: 2.0 };
    let terms = InertialTerms {
        law: Some(&law),
        ..InertialTerms::default()
    };
    let problem = Problem::new(&mesh, &[("sphere", Vec3::zeros())], &[Container::TAG]).unwrap();
    let assembled = problem.assemble_inertial(&drive, &Eliminated, &terms);
    assert!(matches!(assembled.err(), Some(StokesError::NotLinear)));
}
