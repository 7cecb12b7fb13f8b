//! Iterations of the block solver for Oseen flow around a sphere.

use linalg::WarmStart;
use mesh::TetMesh;
use mesher::Container;
use nalgebra::Vector3;
use rigid::{Arms, Articulation, BodyKind, Drive, ExternalLoad};
use stokes::{InertialTerms, Options, Problem};

use crate::support::sphere_in_ball;

type Vec3 = Vector3<f64>;

/// Iterations to 1e-8 for the Oseen flow around a sphere of radius 1 in a ball that moves with it,
/// from a zero guess; `ρ U a / μ` is the Reynolds number at the speed `U` of Stokes flow.
fn iterations(mesh: &TetMesh, is_fixed: bool, reynolds: f64) -> usize {
    let free = Articulation::new(&[BodyKind::Rigid], vec![], Arms::Clamped, &[Vec3::zeros()]);
    let mut set = free.unwrap();
    if is_fixed {
        set = set.with_held(&[0], &[0]).unwrap();
    }
    let drive = Drive {
        set: &set,
        constraints: &set.constraints(&set.initial_state(), &[], &[]).unwrap(),
        loads: &[ExternalLoad {
            force: Vec3::z(),
            torque: Vec3::zeros(),
        }],
    };
    let walls = vec![-Vec3::z(); mesh.n_points()];
    let wall_velocity = is_fixed.then_some(walls.as_slice());
    let problem = Problem::new(mesh, &[("sphere", Vec3::zeros())], &[Container::TAG]).unwrap();
    let options = Options::default();
    let stokes = InertialTerms {
        wall_velocity,
        ..InertialTerms::default()
    };
    let solve = |terms: &InertialTerms| {
        let mut warm = WarmStart::new(0);
        problem
            .solve_inertial(&drive, &options, terms, &mut warm)
            .expect("convergence")
    };
    let flow = solve(&stokes).flow;
    let velocity = Vec3::new(flow.bodies[0], flow.bodies[1], flow.bodies[2]);
    let wind: Vec<Vec3> = flow.velocity.iter().map(|u| u - velocity).collect();
    let speed = if is_fixed { 1.0 } else { velocity.norm() };
    let terms = InertialTerms {
        density: reynolds / speed,
        convecting: Some(&wind),
        ..stokes
    };
    solve(&terms).solver.iterations
}

#[test]
fn iterations_of_oseen_flow() {
    for size in [0.6, 0.3, 0.2] {
        let mesh = sphere_in_ball(size, 10.0, [true, true, false]);
        for is_fixed in [true, false] {
            let numbers = [1.0, 5.0, 10.0, 18.0, 30.0, 50.0];
            let row = numbers.map(|reynolds| iterations(&mesh, is_fixed, reynolds));
            println!(
                "size {size}, {} nodes, fixed {is_fixed}: {row:?}",
                mesh.n_points()
            );
        }
    }
}
