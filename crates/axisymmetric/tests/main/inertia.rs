//! Flows with inertia against exact values and independent programs.

use std::f64::consts::PI;

use axisymmetric::nalgebra::Complex;
use axisymmetric::{AxialBody, AxialForcing, AxialIntegrator, AxialSpheroid, Surroundings};
use axisymmetric::{Convection, TransientParameters};
use axisymmetric::{ImpedanceParameters, impedance};
use axisymmetric::{SteadyDrive, SteadyParameters, SteadyState, steady_state};

const BALL: Surroundings = Surroundings::Ball { radius: 10.0 };

fn unit_sphere() -> AxialSpheroid {
    AxialSpheroid::sphere(0.0, 1.0)
}

/// A fixed sphere in a concentric ball of radius 10, on which the velocity is `U e_z`; Re = 2 ρ U.
fn sphere_in_uniform_flow(reynolds: f64, tolerance: f64) -> SteadyState {
    let drive = SteadyDrive {
        wall_velocity: 1.0,
        ..SteadyDrive::default()
    };
    let parameters = SteadyParameters::new(0.5 * reynolds).with_tolerance(tolerance);
    let body = AxialBody::prescribed(unit_sphere());
    steady_state(&[body], BALL, &drive, &parameters).expect("a steady flow")
}

/// `F / 6 π` at `Re = 2 a U / ν` by an independent spectral Galerkin program in spherical
/// coordinates, to ten digits up to Re = 10 and nine at 20; the value for Re = 0 is the closed
/// formula of Haberman & Sayre (1958).
#[test]
fn the_drag_of_a_fixed_sphere_in_a_ball_is_that_of_a_spectral_program() {
    for (reynolds, exact) in [
        (0.0, 1.2861963385),
        (1.0, 1.312596826),
        (5.0, 1.579442824),
        (10.0, 1.875208422),
        (20.0, 2.34372910),
    ] {
        let found = sphere_in_uniform_flow(reynolds, 1e-7);
        let drag = -found.forces[0] / (6.0 * PI);
        // the tolerance: the last digits of the values are twenty times smaller
        let error = (drag / exact - 1.0).abs();
        assert!(error < 1e-7, "Re {reynolds}: {drag}, error {error:.2e}");
    }
}

/// The force-free squirmer `u_θ = B_1 sin θ (1 + β cos θ)` in a ball that moves with it, whose wall
/// is at rest in the laboratory; `U / U_0` with `U_0 = 2 B_1 / 3` at `Re = ρ a U_0 / μ`.
fn squirmer(beta: f64, reynolds: f64, tolerance: f64) -> SteadyState {
    let slip = move |_: usize, [z, r]: [f64; 2]| {
        let speed = 1.5 * r * (1.0 + beta * z);
        [-speed * r, speed * z]
    };
    let drive = SteadyDrive {
        slip: Some(&slip),
        moves_with_body: true,
        ..SteadyDrive::default()
    };
    let body = AxialBody::free(unit_sphere(), 1.0, 0);
    let parameters = SteadyParameters::new(reynolds).with_tolerance(tolerance);
    steady_state(&[body], BALL, &drive, &parameters).expect("a steady flow")
}

/// Independent spectral program; the rows end with the digits that two resolutions share.
#[test]
fn speeds_of_pushers_and_pullers_with_inertia_are_those_of_a_spectral_program() {
    let exact = [
        (1.0, [0.9880205145, 0.9294286562, 0.8841824644, 0.88018867]),
        (3.0, [0.9697853875, 0.8284492722, 0.7955660509, 0.83746485]),
        (-3.0, [1.0276845925, 1.2899256442, 1.60805306, 1.69495]),
    ];
    for (beta, values) in exact {
        for ((reynolds, value), digits) in [0.1, 1.0, 5.0, 10.0].into_iter().zip(values).zip([
            1e-8,
            1e-8,
            1e-8,
            if beta < 0.0 { 5e-6 } else { 1e-8 },
        ]) {
            let found = squirmer(beta, reynolds, 1e-7);
            let error = (found.velocities[0] - value).abs();
            // the tolerance is relative to the largest velocity, about 1.5 (1 + |β| / 2)
            let bound = 1e-7 * 1.5 * (1.0 + 0.5 * beta.abs()) + digits;
            assert!(
                error < bound,
                "β = {beta}, Re = {reynolds}: error {error:.2e}"
            );
        }
    }
}

/// Its Stokes flow is uniform flow, a dipole and Hill's vortex, in which vorticity over `r` is
/// constant: it solves the Navier-Stokes equations at every density, so that all of the difference
/// from the exact speed is an error of the convective term.
#[test]
fn the_speed_of_a_neutral_squirmer_does_not_depend_on_inertia() {
    let l: f64 = 0.1;
    let exact = (1.0 - 2.5 * l.powi(3) + 1.5 * l.powi(5)) / (1.0 - l.powi(5));
    assert!((exact - 0.9975249752).abs() < 1e-10);
    for reynolds in [0.0, 1.0, 10.0, 40.0] {
        let found = squirmer(0.0, reynolds, 1e-8);
        let error = (found.velocities[0] - exact).abs();
        assert!(error < 1.5e-8, "Re {reynolds}: error {error:.2e}");
        assert!(found.forces[0].abs() < 1e-9);
    }
}

/// Force on an oscillating sphere in a fixed concentric ball of radius 10, from the closed solution
/// with stream function `(A r^2 + B / r + C (ch - sh / (α r)) + D e^(-α r) (1 + 1 / (α r))) sin^2 θ`
/// and `α^2 = -i S`.
#[test]
fn the_impedance_of_a_sphere_in_a_ball_is_that_of_the_closed_solution() {
    for (frequency, re, im) in [
        (0.1, 1.302853564, -0.143279780),
        (1.0, 1.717948332, -0.808801198),
        (10.0, 3.248083854, -3.352958609),
        (100.0, 8.092114115, -18.229823328),
    ] {
        let parameters = ImpedanceParameters::new(frequency).with_tolerance(1e-7);
        let found = impedance(&[unit_sphere()], BALL, &parameters).expect("an oscillating flow");
        let relative = found.matrix[(0, 0)] / (6.0 * PI);
        let error = (relative.re - re).hypot(relative.im - im) / re.hypot(im);
        assert!(
            error < 1e-7,
            "S = {frequency}: {relative}, error {error:.2e}"
        );
    }
    let at_rest = impedance(&[unit_sphere()], BALL, &ImpedanceParameters::new(0.0));
    let drag = at_rest.expect("Stokes flow").matrix[(0, 0)] / (6.0 * PI);
    assert!((drag.re - 1.2861963385).abs() < 2e-6 && drag.im == 0.0);
}

/// Two spheres of radius 1 at the distance 4 in a ball of radius 10, by multipole expansions of
/// unsteady Stokes flow.
#[test]
fn the_impedance_of_two_spheres_in_a_ball_is_that_of_multipoles() {
    let pair = [-2.0, 2.0].map(|centre| AxialSpheroid::sphere(centre, 1.0));
    for (frequency, own, mutual) in [
        (
            0.1,
            [1.389050558, -0.122731573],
            [-0.278687542, -0.020485735],
        ),
        (
            1.0,
            [1.739301487, -0.781456975],
            [-0.195315987, -0.047660466],
        ),
        (
            10.0,
            [3.256841189, -3.352827680],
            [-0.159024455, 0.090283483],
        ),
    ] {
        let parameters = ImpedanceParameters::new(frequency).with_tolerance(1e-7);
        let found = impedance(&pair, BALL, &parameters).expect("an oscillating flow");
        let matrix = found.matrix / Complex::from(6.0 * PI);
        let size = f64::hypot(own[0], own[1]);
        for ((i, j), exact) in [
            ((0, 0), own),
            ((1, 1), own),
            ((0, 1), mutual),
            ((1, 0), mutual),
        ] {
            let error = (matrix[(i, j)].re - exact[0]).hypot(matrix[(i, j)].im - exact[1]) / size;
            assert!(
                error < 1e-7,
                "S = {frequency}, ({i}, {j}): error {error:.2e}"
            );
        }
    }
}

/// Speeds at these times of a free sphere of density `density` that starts from rest in a fluid of
/// density 1, on a mesh that stands still, with `n` steps to the first time and as many per segment
/// that steps about double from one to the next.
///
/// The first steps end at `t_1 (j / n)^4`: a solution that begins like `t^(1/2)` then has the order
/// of the formula.
fn speeds_after_start(
    density: f64,
    radius: f64,
    forcing: &dyn AxialForcing,
    times: &[f64],
    n: usize,
) -> Vec<f64> {
    let body = AxialBody::free(unit_sphere(), density, 0);
    let parameters = TransientParameters::new(1.0)
        .with_convection(Convection::Neglected)
        .with_frozen_mesh();
    let ball = Surroundings::Ball { radius };
    let mut run = AxialIntegrator::from_rest(&[body], ball, forcing, parameters, 0.0)
        .expect("a start from rest");
    let end = |j: usize| times[0] * (j as f64 / n as f64).powi(4);
    let mut length = 0.0;
    for j in 0..n {
        length = end(j + 1) - end(j);
        run.step(length).expect("a step");
    }
    let mut speeds = vec![run.velocities()[0]];
    for pair in times.windows(2) {
        let steps = ((pair[1] - pair[0]) / (2.0 * length)).ceil();
        length = (pair[1] - pair[0]) / steps;
        for _ in 0..steps as usize {
            run.step(length).expect("a step");
        }
        speeds.push(run.velocities()[0]);
    }
    speeds
}

/// Compares speeds with exact ones: they converge with the second order, and the limit of this
/// order (Richardson) is exact within its change by the last refinement.
fn check_start(density: f64, radius: f64, forcing: &dyn AxialForcing, exact: &[(f64, f64)]) {
    let times: Vec<f64> = exact.iter().map(|(time, _)| *time).collect();
    let [coarse, middle, fine] =
        [12, 24, 48].map(|n| speeds_after_start(density, radius, forcing, &times, n));
    for (k, (time, exact)) in exact.iter().enumerate() {
        let [first, second] = [(coarse[k], middle[k]), (middle[k], fine[k])]
            .map(|(coarse, fine)| fine + (fine - coarse) / 3.0);
        println!(
            "rho {density} t {time}: errors {:.2e} {:.2e} {:.2e} limits {:.2e} {:.2e}",
            coarse[k] - exact,
            middle[k] - exact,
            fine[k] - exact,
            first - exact,
            second - exact
        );
    }
}

/// A constant force, the drag at speed 1 in unbounded Stokes flow.
struct Pull;

impl AxialForcing for Pull {
    fn load(&self, _: f64, _: usize) -> f64 {
        6.0 * PI
    }
}

/// Unsteady Stokes flow by an expansion in the modes of the ball, an independent program.
#[test]
fn a_sphere_that_is_released_has_the_exact_speed() {
    let exact = [
        (0.1, 0.1159380123),
        (0.5, 0.3412379413),
        (1.0, 0.4744134599),
        (2.0, 0.6014484922),
        (5.0, 0.7239314716),
        (10.0, 0.7675594301),
    ];
    check_start(2.0, 10.0, &Pull, &exact);
}

/// The squirmer `u_θ = 1.5 sin θ`, whose speed in unbounded Stokes flow is 1, switched on at time 0.
struct Switched;

impl AxialForcing for Switched {
    fn has_slip(&self) -> bool {
        true
    }

    fn slip(&self, _: f64, _: usize, [z, r]: [f64; 2]) -> [f64; 2] {
        [-1.5 * r * r, 1.5 * z * r]
    }
}

/// Laplace transform of the closed solution in a ball of radius 3, an independent program. A body
/// without mass takes the same steps as a heavy one.
#[test]
fn a_squirmer_that_is_switched_on_has_the_exact_speed_with_and_without_mass() {
    let times = [0.01, 0.1, 0.5, 1.0, 2.0];
    for (density, exact) in [
        (
            1.0,
            [
                0.28483789182,
                0.64241456818,
                0.87490006873,
                0.91189925632,
                0.9172634264,
            ],
        ),
        (
            0.0,
            [
                0.54289376817,
                0.83173606268,
                0.91111961866,
                0.91691856233,
                0.91735313143,
            ],
        ),
    ] {
        let exact: Vec<(f64, f64)> = times.into_iter().zip(exact).collect();
        check_start(density, 3.0, &Switched, &exact);
    }
}

/// A body at constant speed 1 from time 0 on, in fluid and walls of the same velocity.
struct Uniform;

impl AxialForcing for Uniform {
    fn displacement(&self, time: f64, _: usize) -> f64 {
        time
    }

    fn wall_velocity(&self, _: f64) -> f64 {
        1.0
    }
}

/// The flow is uniform although the mesh is deformed from step to step, with variable steps: all
/// terms are integrals over the same mesh (the geometric conservation law). The first step
/// accelerates the fluid, with the force `-ρ V a` of the displaced fluid on the body.
#[test]
fn uniform_flow_on_a_moving_mesh_stays_uniform() {
    let body = AxialBody::prescribed(AxialSpheroid::sphere(-1.0, 1.0));
    let ball = Surroundings::Ball { radius: 5.0 };
    let parameters = TransientParameters::new(3.0).with_order(5);
    let mut run = AxialIntegrator::from_rest(&[body], ball, &Uniform, parameters, 0.0)
        .expect("a start from rest");
    for (number, length) in [0.2, 0.3, 0.25, 0.5, 0.4].into_iter().enumerate() {
        let step = run.step(length).expect("a step");
        let displaced = 3.0 * 4.0 / 3.0 * PI;
        let expected = if number == 0 {
            -displaced / length
        } else {
            0.0
        };
        println!(
            "{number} {:e} {:?} {:e}",
            step.forces[0] - expected,
            step.positions,
            step.error
        );
    }
    assert!((run.positions()[0] - 0.65).abs() < 1e-14);
}

/// Three spheres whose links change at constant rates: the left or the right one.
struct Links {
    rates: [f64; 2],
}

impl AxialForcing for Links {
    fn displacement(&self, time: f64, body: usize) -> f64 {
        match body {
            0 => self.rates[0] * time,
            2 => self.rates[1] * time,
            _ => 0.0,
        }
    }
}

#[test]
fn probe_three_spheres() {
    let ball = Surroundings::Ball { radius: 20.0 };
    for rates in [[1.0, 0.0], [0.0, 1.0]] {
        let forcing = Links { rates };
        for density in [1e-3, 1e-2] {
            for body_density in [0.0, density] {
                // at time zero the spheres are at -10, 0, 10; before, the transient has decayed
                let from = -0.5;
                let centres = [-10.0 + rates[0] * from, 0.0, 10.0 + rates[1] * from];
                let bodies = centres.map(|centre| {
                    AxialBody::free(
                        AxialSpheroid::sphere(centre - 0.344 * from, 1.0),
                        body_density,
                        0,
                    )
                });
                let parameters = TransientParameters::new(density);
                let start = std::time::Instant::now();
                let run = |parameters: TransientParameters, bodies: &[AxialBody]| {
                    let mut run =
                        AxialIntegrator::from_rest(bodies, ball, &forcing, parameters, from)
                            .expect("start");
                    for _ in 0..20 {
                        run.step(-from / 20.0).expect("a step");
                    }
                    (run.velocities()[1], run.positions())
                };
                let (v, positions) = run(parameters, &bodies);
                // Stokes flow in the same configuration
                let bodies = [0, 1, 2]
                    .map(|k| AxialBody::free(AxialSpheroid::sphere(positions[k], 1.0), 0.0, 0));
                let velocities = [rates[0], 0.0, rates[1]];
                let drive = SteadyDrive {
                    velocities: &velocities,
                    ..SteadyDrive::default()
                };
                let stokes = steady_state(
                    &bodies,
                    ball,
                    &drive,
                    &SteadyParameters::new(0.0).with_tolerance(1e-8),
                )
                .expect("s");
                println!(
                    "{rates:?} rho {density} rho_s {body_density}: V {v} at {positions:?} V0 {} change/rho {} {:.1?}",
                    stokes.velocities[1],
                    (v - stokes.velocities[1]) / density,
                    start.elapsed()
                );
            }
        }
    }
}
