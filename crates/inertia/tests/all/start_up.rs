//! Starts from rest: light and heavy bodies at the same steps.

use inertia::{Convection, Forcing, FrozenMesh, Integrator, Parameters};
use nalgebra::Isometry3;
use rigid::ExternalLoad;

use crate::support::{QUARTER, STOKES, Vec3, bodies, free_sphere, sphere_in_ball};

/// Surface velocity `B sin θ` along the meridians about z, so that the speed in unbounded fluid is
/// 1.
struct Squirmer;

impl Forcing for Squirmer {
    fn has_slip(&self) -> bool {
        true
    }
    fn slip(&self, _: f64, _: usize, x: &Vec3) -> Vec3 {
        let n = x.normalize();
        1.5 * (n.z * n - Vec3::z())
    }
}

/// A constant force of 6π.
struct Pull;

impl Forcing for Pull {
    fn load(&self, _: f64, _: usize, _: &Isometry3<f64>) -> ExternalLoad {
        ExternalLoad {
            force: Vec3::z() * STOKES,
            torque: Vec3::zeros(),
        }
    }
}

/// Speeds at the given times, fluid of density 1, small displacements.
fn speeds(
    forcing: &dyn Forcing,
    (size, b): (f64, f64),
    density: f64,
    tolerance: f64,
    times: &[f64],
) -> Vec<f64> {
    let set = free_sphere(Vec3::zeros());
    let mesh = Box::new(FrozenMesh(sphere_in_ball(size, b, QUARTER)));
    let parameters = Parameters::new(1.0).with_convection(Convection::Neglected);
    let mut run =
        Integrator::from_rest(bodies(&set, density), forcing, mesh, parameters, 0.0).unwrap();
    let (mut found, mut steps) = (Vec::new(), 0);
    let mut first = 1e-5;
    for &time in times {
        let mut speed = 0.0;
        run.advance_to(time, tolerance, first, |step| {
            speed = step.solved.flow.bodies[2];
            first = step.length;
            steps += 1;
        })
        .unwrap();
        found.push(speed);
    }
    println!("{steps} steps");
    found
}

#[test]
fn a_squirmer_that_is_switched_on_has_the_exact_speed_with_and_without_mass() {
    // multipoles in time by Laplace inversion, in a ball of radius 3; limit 0.9173553719
    let times = [0.1, 0.5, 1.0];
    for (density, exact) in [
        (1.0, [0.64241456818, 0.87490006873, 0.91189925632]),
        (0.0, [0.83173606268, 0.91111961866, 0.91691856233]),
    ] {
        let computed = speeds(&Squirmer, (0.4, 3.0), density, 1e-3, &times);
        println!("ρ_s = {density}: {computed:?}, exact {exact:?}");
        for (computed, exact) in computed.iter().zip(exact) {
            // discretisation 5e-3 at this size (steady limit), 1e-3 per step in time
            assert!((computed / exact - 1.0).abs() < 1e-2, "{computed} {exact}");
        }
    }
}

#[test]
#[ignore = "slow: 30 s"]
fn a_sphere_that_is_released_has_the_exact_speed_with_and_without_mass() {
    // closed form by Laplace inversion, ball of radius 10
    let times = [0.1, 0.5, 1.0, 2.0, 5.0, 10.0];
    let exact = [
        0.1159380123,
        0.3412379413,
        0.4744134599,
        0.6014484922,
        0.7239314716,
        0.7675594301,
    ];
    let heavy = speeds(&Pull, (0.25, 10.0), 2.0, 3e-4, &times);
    println!("{heavy:?} {exact:?}");
    for (computed, exact) in heavy.iter().zip(exact) {
        assert!((computed / exact - 1.0).abs() < 5e-3, "{computed} {exact}");
    }
    // the massless sphere at the same tolerance: it is faster at all times, and tends to the same
    // speed
    let light = speeds(&Pull, (0.25, 10.0), 0.0, 3e-4, &times);
    assert!(
        light.iter().zip(&heavy).all(|(light, heavy)| light > heavy),
        "{light:?}"
    );
}
