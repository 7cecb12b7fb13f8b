//! Surfaces that deform, against exact values.

use std::f64::consts::PI;

use nalgebra::Vector3;
use stokes::{Options, Solution, SurfaceFlow};

use crate::support::{solve_free_sphere, sphere_in_ball};

type Vec3 = Vector3<f64>;

/// Radius of the container, a part of the fluid around the sphere.
const WALL: f64 = 2.0;

/// A unit sphere that grows and whose surface is displaced along z, in a container that the fluid
/// passes as in unbounded fluid.
struct Growing {
    rates: [f64; 2],
}

impl SurfaceFlow for Growing {
    fn slip(&self, _: usize, _: &Vec3) -> Vec3 {
        Vec3::zeros()
    }

    fn rates(&self) -> &[f64] {
        &self.rates
    }

    fn of_rate(&self, coordinate: usize, _: usize, x: &Vec3) -> Vec3 {
        [x.normalize(), Vec3::z()][coordinate]
    }

    fn volume_rate(&self, coordinate: usize, _: usize) -> f64 {
        [4.0 * PI, 0.0][coordinate]
    }

    fn at_wall(&self, x: &Vec3) -> Vec3 {
        self.rates[0] * x / x.norm().powi(3)
    }

    fn background(&self, _: &Vec3) -> Vec3 {
        Vec3::zeros()
    }

    fn background_pressure(&self, _: &Vec3) -> f64 {
        0.0
    }
}

fn solve(size: f64, symmetry_planes: [bool; 3], flow: &Growing) -> Solution {
    let mesh = sphere_in_ball(size, WALL, symmetry_planes);
    solve_free_sphere(&mesh, WALL, flow, &Options::default()).unwrap()
}

/// A sphere that grows at the rate `a'` is a source, `u = a' a² x / |x|³` without pressure: the
/// power of its surface is `16 π μ a a'²` and the dissipation within the wall that without the part
/// outside.
#[test]
fn a_sphere_that_grows_has_the_power_of_a_source() {
    let rate = 0.7;
    let exact = 16.0 * PI * rate;
    for (size, planes, largest) in [
        (0.6, [false; 3], 3e-2),
        (0.4, [false; 3], 1e-2),
        (0.4, [true, false, true], 1e-2),
    ] {
        let flow = Growing { rates: [rate, 0.0] };
        let solved = solve(size, planes, &flow);
        let estimate = solved.estimate.unwrap();
        let (computed, change) = (solved.powers.rates[0], estimate.powers.rates[0]);
        let (error, bar) = (
            computed + change - exact,
            estimate.relative_uncertainty * change.abs(),
        );
        println!(
            "{size} {planes:?} {} {} {bar:e}",
            computed / exact - 1.0,
            error / exact
        );
        assert!(
            (computed - exact).abs() < largest * exact,
            "{computed} {exact}"
        );
        assert!(error.abs() < bar, "{error:e} {bar:e}");
        assert_eq!(solved.powers.slip, 0.0);
        let checks = solved.checks.unwrap();
        println!("{checks:?} {}", solved.flow.bodies.amax());
        assert!(checks.dissipation.abs() < 0.05, "{checks:?}");
        assert!(solved.flow.forces.amax() < 1e-6);
        assert!(solved.flow.bodies.amax() < 1e-2);
    }
}

/// A deformation that is a translation is undone by the motion of the body, on any mesh.
#[test]
fn a_displaced_surface_moves_the_body_back() {
    let flow = Growing { rates: [0.0, 1.5] };
    let solved = solve(0.6, [false; 3], &flow);
    let expected = Vec3::new(0.0, 0.0, -1.5);
    assert!((solved.flow.bodies.fixed_rows::<3>(0) - expected).norm() < 1e-6);
    assert!(solved.flow.bodies.rows(3, 3).amax() < 1e-6);
    assert!(solved.powers.rates.iter().all(|power| power.abs() < 1e-5));
}
