//! Surfaces that deform, against exact values.

use std::f64::consts::PI;

use nalgebra::Vector3;
use rheology::{Law, ViscosityLaw};
use stokes::{GeneralisedNewtonianSolution, Options, Solution, SurfaceFlow};

use crate::support::{solve_free_sphere, solve_free_sphere_in, sphere_in_ball};

type Vec3 = Vector3<f64>;

/// Radius of the container, a part of the fluid around the sphere.
const WALL: f64 = 2.0;

/// A unit sphere that grows and whose surface moves by another coordinate too, in a container that
/// the fluid passes as in unbounded fluid.
struct Growing {
    rates: [f64; 2],
    /// Velocity of the surface by the second coordinate.
    second: fn(&Vec3) -> Vec3,
}

impl Growing {
    /// The surface is displaced along z.
    fn displaced(rates: [f64; 2]) -> Self {
        Self {
            rates,
            second: |_| Vec3::z(),
        }
    }

    /// The surface flows along the sphere like that of a neutral squirmer.
    fn squirming(rates: [f64; 2]) -> Self {
        Self {
            rates,
            second: |x| {
                let n = x.normalize();
                n.z * n - Vec3::z()
            },
        }
    }
}

impl SurfaceFlow for Growing {
    fn slip(&self, _: usize, _: &Vec3) -> Vec3 {
        Vec3::zeros()
    }

    fn rates(&self) -> &[f64] {
        &self.rates
    }

    fn of_rate(&self, coordinate: usize, _: usize, x: &Vec3) -> Vec3 {
        [x.normalize(), (self.second)(x)][coordinate]
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
        let flow = Growing::displaced([rate, 0.0]);
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
    let flow = Growing::displaced([0.0, 1.5]);
    let solved = solve(0.6, [false; 3], &flow);
    let expected = Vec3::new(0.0, 0.0, -1.5);
    assert!((solved.flow.bodies.fixed_rows::<3>(0) - expected).norm() < 1e-6);
    assert!(solved.flow.bodies.rows(3, 3).amax() < 1e-6);
    assert!(solved.powers.rates.iter().all(|power| power.abs() < 1e-5));
}

fn solve_with_law(size: f64, law: &Law, rates: [f64; 2]) -> GeneralisedNewtonianSolution {
    let mesh = sphere_in_ball(size, WALL, [true, true, false]);
    let options = Options::default().with_rtol(1e-11);
    solve_free_sphere_in(&mesh, (WALL, law), &Growing::squirming(rates), &options).unwrap()
}

/// The flow of a sphere that grows is that of a source in any fluid, with the shear rate
/// `g = √12 a' a² / r³`: its dissipation is `∫ η(g) g² dV`, by Simpson's rule.
#[test]
fn a_sphere_that_grows_in_a_fluid_of_carreau_dissipates_by_its_shear_rate() {
    let rate = 0.7;
    let law = Law::Carreau {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity: 0.1,
        relaxation_time: 1.0,
        index: 0.4,
    };
    let density = |r: f64| {
        let g = 12.0_f64.sqrt() * rate / r.powi(3);
        4.0 * PI * r * r * law.viscosity(g) * g * g
    };
    const PARTS: usize = 200;
    let h = (WALL - 1.0) / PARTS as f64;
    let weight = |k: usize| match k {
        0 | PARTS => 1.0,
        _ if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    let exact: f64 = (0..=PARTS)
        .map(|k| h / 3.0 * weight(k) * density(1.0 + k as f64 * h))
        .sum();
    // The dissipation has an error of fourth order in size where cells resolve how the viscosity
    // changes. From a mesh of a few layers to one of twice as many it falls by the order 2.7, to
    // 0.15; second order would be 1/4.
    let [coarse, fine] = [0.5, 0.25].map(|size| {
        let solved = solve_with_law(size, &law, [rate, 0.0]);
        assert!(solved.solution.flow.bodies.amax() < 1e-3);
        (solved.dissipation / exact - 1.0).abs()
    });
    assert!(coarse < 1e-2 && fine < 0.2 * coarse, "{coarse:e} {fine:e}");
}

/// A law of the index one is Newtonian; in power laws velocities are proportional to the rates, and
/// powers to the rates to the index plus one, divided by a rate.
#[test]
fn laws_of_index_one_are_newtonian_and_power_laws_homogeneous_for_surfaces_that_deform() {
    let rates = [0.7, 1.5];
    let newtonian = solve_with_law(0.5, &Law::Newtonian { viscosity: 1.0 }, rates);
    let carreau = Law::Carreau {
        zero_shear_viscosity: 1.0,
        infinite_shear_viscosity: 0.0,
        relaxation_time: 3.0,
        index: 1.0,
    };
    let same = solve_with_law(0.5, &carreau, rates);
    let parts = |solved: &GeneralisedNewtonianSolution| {
        let powers = &solved.solution.powers.rates;
        [solved.solution.flow.bodies[2], powers[0], powers[1]]
    };
    let ratios = |a: &GeneralisedNewtonianSolution, b: &GeneralisedNewtonianSolution| {
        let (a, b) = (parts(a), parts(b));
        [0, 1, 2].map(|k| a[k] / b[k])
    };
    for ratio in ratios(&same, &newtonian) {
        assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
    }
    // The regularisation changes the flow by less than its share of the shear rates.
    let power_law = Law::PowerLaw {
        consistency: 1.0,
        index: 0.6,
        regularisation: 1e-9,
    };
    let [slow, fast] = [1.0, 8.0].map(|factor| {
        let rates = rates.map(|rate| factor * rate);
        solve_with_law(0.5, &power_law, rates)
    });
    let expected = [8.0, 8.0_f64.powf(0.6), 8.0_f64.powf(0.6)];
    for (ratio, expected) in ratios(&fast, &slow).into_iter().zip(expected) {
        assert!((ratio / expected - 1.0).abs() < 1e-7, "{ratio} {expected}");
    }
    // The growth thins the fluid around the squirmer, and so changes its speed.
    let alone = solve_with_law(0.5, &power_law, [0.0, rates[1]]);
    let change = parts(&slow)[0] / parts(&alone)[0] - 1.0;
    assert!(change.abs() > 1e-3, "{change}");
}
