//! Fluids with inertia whose viscosity depends on the shear rate.

use inertia::{Forcing, FrozenMesh, Integrator, Parameters, StepReport};
use mesh::TetMesh;
use stokes::Options;
use stokes::rheology::Law;

use crate::support::{QUARTER, Vec3, bodies, free_sphere, sphere_in_ball};

fn carreau(relaxation_time: f64, index: f64) -> Law {
    Law::Carreau {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity: 0.0,
        relaxation_time,
        index,
    }
}

/// The container moves to and fro around a sphere that is held.
struct Shaken;

impl Forcing for Shaken {
    fn has_moving_walls(&self) -> bool {
        true
    }
    fn wall_velocity(&self, time: f64, _: &Vec3) -> Vec3 {
        Vec3::z() * (std::f64::consts::TAU * time).sin()
    }
}

/// Steps around a sphere that is held in a container that is shaken, at a Reynolds number of 1.
fn shaken(mesh: &TetMesh, law: Option<&Law>, steps: usize, options: Options) -> Vec<StepReport> {
    let set = free_sphere(Vec3::zeros()).with_held(&[0], &[0]).unwrap();
    let mut parameters = Parameters::new(1.0).with_options(options);
    if let Some(law) = law {
        parameters = parameters.with_law(law);
    }
    let meshes = Box::new(FrozenMesh(mesh.clone()));
    let bodies = bodies(&set, 1.0);
    let mut run = Integrator::from_rest(bodies, &Shaken, meshes, parameters, 0.0).unwrap();
    (0..steps).map(|_| run.step(0.05).unwrap()).collect()
}

/// Largest difference of forces along the axis, over the largest of them.
fn difference(a: &[StepReport], b: &[StepReport]) -> f64 {
    let largest = a
        .iter()
        .fold(0.0, |m: f64, step| m.max(step.forces[2].abs()));
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |m: f64, (a, b)| {
        m.max((a.forces[2] - b.forces[2]).abs())
    }) / largest
}

/// The terms of the law vanish, and what is left is the form `2 D:D` of constant viscosity. That of
/// a Newtonian step, `∇u:∇v`, differs by the divergence of discrete flows.
#[test]
fn laws_without_thinning_have_the_steps_of_constant_viscosity() {
    let differences = [0.5, 0.35].map(|size| {
        let mesh = sphere_in_ball(size, 4.0, QUARTER);
        let steps = |law: Option<&Law>| shaken(&mesh, law, 3, Options::default());
        let constant = steps(Some(&Law::Newtonian { viscosity: 1.0 }));
        for law in [carreau(2.0, 1.0), carreau(0.0, 0.5)] {
            assert_eq!(difference(&steps(Some(&law)), &constant), 0.0, "{law:?}");
        }
        difference(&steps(None), &constant)
    });
    println!("{differences:?}");
    // both converge to one flow, in the layers of the first steps with the first order at least
    assert!(differences[0] < 5e-3, "{differences:?}");
    assert!(differences[1] < 0.7 * differences[0], "{differences:?}");
}

/// At shear numbers of about 1 and 10 the iterations of all linear solves of a step are two to
/// three times those of the one solve of a Newtonian step.
#[test]
fn a_step_of_a_fluid_that_thins_takes_few_iterations() {
    let mesh = sphere_in_ball(0.4, 10.0, QUARTER);
    let steps = |law: Option<&Law>| {
        let steps = shaken(&mesh, law, 12, Options::default());
        steps.iter().map(|step| step.iterations).sum::<usize>()
    };
    let newtonian = steps(None);
    for law in [carreau(1.0, 0.5), carreau(10.0, 0.5), carreau(10.0, 0.3)] {
        let found = steps(Some(&law));
        println!("{law:?}: {found}, Newtonian {newtonian}");
        assert!(
            found <= 3 * newtonian,
            "{law:?}: {found}, Newtonian {newtonian}"
        );
    }
}
