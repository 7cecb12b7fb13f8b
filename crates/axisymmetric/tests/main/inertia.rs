//! Flows with inertia against exact values and independent programs.

use std::f64::consts::PI;

use axisymmetric::nalgebra::Complex;
use axisymmetric::{AxialBody, AxialForcing, AxialIntegrator, AxialSpheroid, Surroundings};
use axisymmetric::{Convection, TransientParameters};
use axisymmetric::{ImpedanceParameters, added_mass, axial_resistance, impedance};
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

/// Dissipation `2 ∫ D:D` by the same spectral program for the speed `U_0 = 1` without inertia. In a
/// steady state it is the power of the slip: the slip is no rigid motion, whose power any of the
/// viscous forms gives.
#[test]
fn bug_the_power_of_slip_with_inertia_lacked_a_part() {
    for (beta, reynolds, exact) in [
        (3.0, 0.1, 208.03864601),
        (3.0, 1.0, 212.43271915),
        (3.0, 5.0, 240.65347275),
        (-3.0, 1.0, 214.96586022),
    ] {
        let found = squirmer(beta, reynolds, 1e-7);
        for (name, value) in [
            ("dissipation", found.dissipation),
            ("power", found.power),
            ("power of the slip", found.slip_power),
        ] {
            let error = (value / exact - 1.0).abs();
            assert!(
                error < 2e-7,
                "β = {beta}, Re = {reynolds}: {name} {value}, error {error:.1e}"
            );
        }
    }
}

/// Force on an oscillating sphere in a fixed concentric ball of radius 10, from the closed solution
/// with stream function `(A r^2 + B / r + C (ch - sh / (α r)) + D e^(-α r) (1 + 1 / (α r))) sin^2
/// θ` and `α^2 = -i S`.
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

/// Speeds at these times of a free sphere that starts from rest in a fluid of density 1, on a mesh
/// that stands still.
///
/// The first `12 n` steps end at `t_1 (j / 12 n)^4`: a solution that begins like `t^(1/2)` then has
/// the order of the formula. From one time to the next steps about double.
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
    let end = |j: usize, steps: usize| times[0] * (j as f64 / steps as f64).powi(4);
    for j in 0..12 * n {
        run.step(end(j + 1, 12 * n) - end(j, 12 * n))
            .expect("a step");
    }
    let mut speeds = vec![run.velocities()[0]];
    // that of the coarsest run, so that all runs halve the steps of each other
    let mut length = end(12, 12) - end(11, 12);
    for pair in times.windows(2) {
        let steps = ((pair[1] - pair[0]) / (2.0 * length)).ceil();
        length = (pair[1] - pair[0]) / steps;
        for _ in 0..n * steps as usize {
            run.step(length / n as f64).expect("a step");
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
        [1, 2, 4].map(|n| speeds_after_start(density, radius, forcing, &times, n));
    for (k, (time, exact)) in exact.iter().enumerate() {
        let order = ((middle[k] - coarse[k]) / (fine[k] - middle[k])).log2();
        assert!((1.5..2.5).contains(&order), "t = {time}: order {order}");
        let [before, limit] = [(coarse[k], middle[k]), (middle[k], fine[k])]
            .map(|(coarse, fine)| fine + (fine - coarse) / 3.0);
        let (error, change) = ((limit - exact).abs(), (limit - before).abs());
        assert!(
            error < change,
            "t = {time}: error {error:.2e}, change {change:.2e}"
        );
        assert!(change < 1e-4, "t = {time}: change {change:.2e}");
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
#[ignore = "slow: 20 s"]
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

/// The squirmer `u_θ = 1.5 sin θ`, whose speed in unbounded Stokes flow is 1, switched on at time
/// 0.
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
#[ignore = "slow: 20 s"]
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
    let parameters = TransientParameters::new(3.0)
        .with_order(5)
        .with_tolerance(1e-12);
    let mut run = AxialIntegrator::from_rest(&[body], ball, &Uniform, parameters, 0.0)
        .expect("a start from rest");
    let displaced = 3.0 * 4.0 / 3.0 * PI;
    for (number, length) in [0.2, 0.3, 0.25, 0.5, 0.4].into_iter().enumerate() {
        let step = run.step(length).expect("a step");
        // the velocity jumps at the start: the level before belongs to another motion
        let expected = match number {
            0 => -displaced / length,
            _ => 0.0,
        };
        if number == 0 {
            run.restart();
        }
        let error = (step.forces[0] - expected).abs();
        // On curved triangles the linear pressure of the first step is not in the space of degree
        // four, and surfaces are polynomials of degree five: both are accurate to 1e-9.
        let bound = 1e-9 * displaced / 0.2;
        assert!(
            error < bound,
            "step {number}: error of the force {error:.2e}"
        );
    }
    assert!((run.positions()[0] - 0.65).abs() < 1e-12);
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

/// First-order change of the velocity of three spheres at -10, 0, 10 in a ball of radius 20 by the
/// inertia of the fluid and of the bodies, while one link changes at the rate 1 (velocities of the
/// spheres `V + w_i`), from the reciprocal theorem with multipoles:
/// `ρ (-.02629507985 + .001485913904) - ρ_s .000532333222` for `w = (1, 0, 0)`, the time derivative
/// and the convection of the Stokes flow, and the opposite for `w = (0, 0, 1)`.
#[test]
fn the_first_order_of_inertia_of_a_three_sphere_swimmer_is_that_of_the_reciprocal_theorem() {
    let ball = Surroundings::Ball { radius: 20.0 };
    // Time from the start, in which the transient decays by `exp(-4.49^2 t / (ρ b^2))`, less than
    // 1e-10: 4.49 is the first root of tan x = x.
    let start = -0.5;
    let density = 1e-3;
    let change = |rates: [f64; 2], of_bodies: f64| {
        let forcing = Links { rates };
        // the mean velocity of the swimmer, with which it ends at the centre
        let drift = if rates[0] > 0.0 { -0.34450 } else { -0.34307 };
        let centres = [-10.0 + rates[0] * start, 0.0, 10.0 + rates[1] * start];
        let velocity = |centres: [f64; 3], density: f64, mass: f64, (from, steps): (f64, u32)| {
            let bodies =
                centres.map(|centre| AxialBody::free(AxialSpheroid::sphere(centre, 1.0), mass, 0));
            let parameters = TransientParameters::new(density);
            let mut run = AxialIntegrator::from_rest(&bodies, ball, &forcing, parameters, from)
                .expect("a start from rest");
            for _ in 0..steps {
                run.step(-from / f64::from(steps)).expect("a step");
            }
            (run.velocities()[1], run.positions())
        };
        let centres = centres.map(|centre| centre + drift * start);
        let (with_inertia, reached) = velocity(centres, density, of_bodies * density, (start, 16));
        // Stokes flow in the configuration that is reached: one tiny step without inertia
        let reached = [reached[0], reached[1], reached[2]];
        let (without, _) = velocity(reached, 0.0, 0.0, (-1e-9, 1));
        (with_inertia - without) / density
    };
    for (of_bodies, exact) in [
        (0.0, -0.02629507985 + 0.001485913904),
        (1.0, -0.02629507985 + 0.001485913904 - 0.000532333222),
    ] {
        // even orders are the same for both links
        let odd = 0.5 * (change([1.0, 0.0], of_bodies) - change([0.0, 1.0], of_bodies));
        // Half the density changes it by 3e-7, elements of order 8 by 5e-7, half the steps by 1e-7.
        let error = (odd - exact).abs();
        assert!(error < 1e-6, "mass {of_bodies}: {odd}, error {error:.2e}");
    }
}

/// Without density a step is Stokes flow at the positions that it reaches: the velocity of a
/// force-free swimmer follows from the resistance, by another solver and another mesh.
#[test]
fn without_inertia_steps_are_stokes_flow_at_the_positions_reached() {
    let ball = Surroundings::Ball { radius: 10.0 };
    let rates = [0.7, -0.4];
    let forcing = Links { rates };
    let bodies =
        [-4.0, 0.0, 3.5].map(|centre| AxialBody::free(AxialSpheroid::sphere(centre, 1.0), 0.0, 0));
    let parameters = TransientParameters::new(0.0).with_order(7);
    let mut run = AxialIntegrator::from_rest(&bodies, ball, &forcing, parameters, 0.0)
        .expect("a start from rest");
    for length in [0.2, 0.5, 0.3] {
        let step = run.step(length).expect("a step");
        let moved: Vec<AxialSpheroid> = (step.positions.iter())
            .map(|centre| AxialSpheroid::sphere(*centre, 1.0))
            .collect();
        let resistance = axial_resistance(&moved, ball, 1e-8).expect("Stokes flow");
        let total = resistance.matrix().row_sum();
        let own = [rates[0], 0.0, rates[1]];
        let driven: f64 = total.iter().zip(own).map(|(r, w)| r * w).sum();
        let exact = -driven / total.sum();
        // elements of order seven have errors of 1e-7 here
        let error = (step.velocities[1] - exact).abs();
        assert!(error < 1e-6, "{:?}: error {error:.2e}", step.positions);
        let sum: f64 = step.forces.iter().sum();
        assert!(sum.abs() < 1e-6, "total force {sum:.2e}");
        // links have the lengths that are given
        let link = step.positions[1] - step.positions[0];
        assert!((link - (4.0 - rates[0] * step.time)).abs() < 1e-12);
    }
}

/// The flow of a sphere that is released goes on across a new mesh, which no motion makes
/// necessary: velocities change by the error of elements of order six, momentum is kept.
#[test]
fn a_new_mesh_in_mid_flight_changes_the_motion_by_the_error_of_the_elements() {
    let run = |renews: bool| {
        let sphere = AxialBody::free(AxialSpheroid::sphere(-1.0, 1.0), 2.0, 0);
        let ball = Surroundings::Ball { radius: 5.0 };
        let parameters = TransientParameters::new(1.0);
        let mut run = AxialIntegrator::from_rest(&[sphere], ball, &Pull, parameters, 0.0)
            .expect("a start from rest");
        for _ in 0..6 {
            run.step(0.1).expect("a step");
        }
        if renews {
            run.renew_mesh().expect("a new mesh");
        }
        assert_eq!(run.meshes(), 1 + usize::from(renews));
        [0.01, 0.1].map(|length| run.step(length).expect("a step"))
    };
    let (kept, renewed) = (run(false), run(true));
    for (kept, renewed) in kept.iter().zip(&renewed) {
        // Elements of order six have errors of 1e-6 of the velocity in steady flow at these
        // Reynolds numbers; layers that are 0.5 thick after 0.6 are as well resolved.
        let error = (kept.velocities[0] - renewed.velocities[0]).abs();
        assert!(error < 1e-5 * kept.velocities[0], "velocity: {error:.2e}");
        let error = (kept.positions[0] - renewed.positions[0]).abs();
        assert!(error < 1e-6, "position: {error:.2e}");
    }
    let jump = renewed[0].momentum_jump.expect("a new mesh");
    // Per volume of the sphere it is a velocity.
    assert!(jump.abs() < 1e-5 * 4.0 / 3.0 * PI, "momentum: {jump:.2e}");
    assert_eq!(
        (renewed[1].momentum_jump, kept[0].momentum_jump),
        (None, None)
    );
}

/// A sphere that is driven across a ball at a constant velocity.
struct Crossing;

impl AxialForcing for Crossing {
    fn displacement(&self, time: f64, _: usize) -> f64 {
        time
    }
}

/// A stroke of four radii is longer than any mesh can follow. Without density a step is Stokes flow
/// where it ends, so that the force tells whether the mesh there is a good one.
#[test]
fn a_long_way_takes_several_meshes() {
    let sphere = AxialBody::prescribed(AxialSpheroid::sphere(-2.0, 1.0));
    let ball = Surroundings::Ball { radius: 5.0 };
    let parameters = TransientParameters::new(0.0).with_order(5);
    let mut run = AxialIntegrator::from_rest(&[sphere], ball, &Crossing, parameters, 0.0)
        .expect("a start from rest");
    for _ in 0..8 {
        let step = run.step(0.5).expect("a step");
        let at = AxialSpheroid::sphere(step.positions[0], 1.0);
        let resistance = axial_resistance(&[at], ball, 1e-7).expect("Stokes flow");
        let error = step.forces[0] / resistance.matrix()[(0, 0)] - 1.0;
        // Forces are of twice the order of velocities, 1e-4 on a mesh whose quality has halved.
        assert!(error.abs() < 1e-5, "{:?}: {error:.2e}", step.positions);
    }
    assert!(run.meshes() > 1, "{}", run.meshes());
}

/// Stokes flow at the start is that of the resistance.
#[test]
fn a_start_from_stokes_flow_has_its_velocities() {
    let ball = Surroundings::Ball { radius: 5.0 };
    let sphere = AxialSpheroid::sphere(1.0, 1.0);
    let body = AxialBody::free(sphere, 2.0, 0);
    let parameters = TransientParameters::new(1.0);
    let mut run = AxialIntegrator::from_rest(&[body], ball, &Pull, parameters, 0.0)
        .expect("a start from rest");
    run.start_from_stokes(&[0.0]).expect("Stokes flow");
    let resistance = axial_resistance(&[sphere], ball, 1e-8).expect("Stokes flow");
    let exact = 6.0 * PI / resistance.matrix()[(0, 0)];
    // of elements of order six
    assert!((run.velocities()[0] / exact - 1.0).abs() < 1e-6);
    let wrong = run.start_from_stokes(&[0.0, 1.0]);
    assert!(matches!(
        wrong,
        Err(axisymmetric::AxisymmetricError::Length { .. })
    ));
}

#[test]
fn invalid_flows_with_inertia_are_refused() {
    use axisymmetric::AxisymmetricError as Error;
    let body = AxialBody::free(unit_sphere(), 1.0, 0);
    let at_rest = SteadyDrive::default();
    let steady = |bodies: &[AxialBody], surroundings, drive: &SteadyDrive, parameters| {
        steady_state(bodies, surroundings, drive, &parameters).expect_err("invalid")
    };
    let valid = SteadyParameters::new(1.0);
    let unbounded = Surroundings::Unbounded;
    assert_eq!(
        steady(&[body], unbounded, &at_rest, valid),
        Error::NoContainer
    );
    assert_eq!(steady(&[], BALL, &at_rest, valid), Error::NoBodies);
    let list = [0.0, 1.0];
    let two = SteadyDrive {
        velocities: &list,
        ..at_rest
    };
    assert!(matches!(
        steady(&[body], BALL, &two, valid),
        Error::Length { found: 2, .. }
    ));
    let list = [f64::NAN];
    let unknown = SteadyDrive {
        loads: &list,
        ..at_rest
    };
    let refused = steady(&[body], BALL, &unknown, valid);
    assert!(matches!(refused, Error::InvalidNumber { .. }), "{refused}");
    let slip = |_: usize, _: [f64; 2]| [f64::NAN, 0.0];
    let unknown = SteadyDrive {
        slip: Some(&slip),
        ..at_rest
    };
    let refused = steady(&[body], BALL, &unknown, valid);
    assert!(matches!(refused, Error::InvalidNumber { .. }), "{refused}");
    for parameters in [
        SteadyParameters::new(-1.0),
        SteadyParameters::new(f64::NAN),
        valid.with_growth(0.0),
        valid.with_growth(1.5),
    ] {
        let refused = steady(&[body], BALL, &at_rest, parameters);
        assert!(matches!(refused, Error::InvalidNumber { .. }), "{refused}");
    }
    for tolerance in [0.0, 1e-12, 1.0, f64::NAN] {
        let refused = steady(&[body], BALL, &at_rest, valid.with_tolerance(tolerance));
        assert!(
            matches!(refused, Error::InvalidTolerance { .. }),
            "{refused}"
        );
    }
    let heavy = AxialBody {
        mass: f64::INFINITY,
        ..body
    };
    let refused = steady(&[heavy], BALL, &at_rest, valid);
    assert!(matches!(refused, Error::InvalidNumber { .. }), "{refused}");
    let start =
        |parameters| AxialIntegrator::from_rest(&[body], BALL, &(), parameters, 0.0).map(|_| ());
    for order in [0, 1, 11] {
        let refused = start(TransientParameters::new(1.0).with_order(order));
        assert!(matches!(refused, Err(Error::InvalidNumber { .. })));
    }
    let mut run =
        AxialIntegrator::from_rest(&[body], BALL, &(), TransientParameters::new(1.0), 0.0)
            .expect("a start from rest");
    for length in [0.0, -1.0, f64::NAN] {
        assert!(matches!(run.step(length), Err(Error::InvalidNumber { .. })));
    }
    // nothing drives it
    run.step(1.0).expect("a step at rest");
    assert_eq!(run.velocities(), [0.0]);
}

/// Spheres whose link closes at the rate 1.
#[test]
fn bodies_that_meet_are_refused() {
    let forcing = Links { rates: [1.0, 0.0] };
    let bodies =
        [-2.5, 0.0].map(|centre| AxialBody::free(AxialSpheroid::sphere(centre, 1.0), 1.0, 0));
    let parameters = TransientParameters::new(0.1).with_order(4);
    let mut run = AxialIntegrator::from_rest(&bodies, BALL, &forcing, parameters, 0.0)
        .expect("a start from rest");
    run.step(0.1).expect("a step");
    let refused = run.step(0.5).map(|step| step.positions);
    assert!(matches!(
        refused,
        Err(axisymmetric::AxisymmetricError::BodiesTooClose { .. })
    ));
    assert!((run.time() - 0.1).abs() < 1e-15);
}

#[test]
fn flows_with_inertia_are_the_same_on_any_number_of_threads() {
    let on_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| squirmer(3.0, 1.0, 1e-4))
    };
    assert_eq!(on_threads(1), on_threads(3));
}

/// A sphere in a concentric ball has the added mass `2/3 π a^3 (b^3 + 2 a^3) / (b^3 - a^3)` (Lamb
/// 1932, section 93), a spheroid with the semi-axis `1` along the axis and `1/2` across it in
/// unbounded fluid has `4/3 π / 4` times `α / (2 - α)`, `α = 2 (1 - e^2) / e^3 (artanh e - e)`
/// (section 114).
#[test]
fn added_masses_are_those_of_closed_formulas() {
    for b in [1.5, 2.0, 10.0] {
        let ball = Surroundings::Ball { radius: b };
        let found = added_mass(&[unit_sphere()], ball, 1e-9).expect("an added mass");
        let b3 = f64::powi(b, 3);
        let exact = 2.0 / 3.0 * PI * (b3 + 2.0) / (b3 - 1.0);
        let error = (found.matrix[(0, 0)] / exact - 1.0).abs();
        assert!(error < 1e-9, "ball of {b}: {error:.1e}");
    }
    let spheroid = AxialSpheroid {
        centre: 0.0,
        axial: 1.0,
        equatorial: 0.5,
    };
    let e = f64::sqrt(0.75);
    let alpha = 2.0 * (1.0 - e * e) / e.powi(3) * (e.atanh() - e);
    let exact = 4.0 / 3.0 * PI * 0.25 * alpha / (2.0 - alpha);
    let radius = 100.0;
    let found = added_mass(&[spheroid], Surroundings::Ball { radius }, 1e-8).expect("one");
    // The ball changes it by less than the dipole of a sphere of radius 1, `3 / b^3`.
    let error = (found.matrix[(0, 0)] / exact - 1.0).abs();
    assert!(error < 1e-8 + 3.0 * radius.powi(-3), "{error:.1e}");
}

/// Two spheres of the radii `a`, `b` at a distance `c`: `2/3 π a^3 (1 + 3 a^3 b^3 / c^6)` and `-2 π
/// a^3 b^3 / c^3` for accelerations in the same direction (Lamb 1932, section 138), up to terms of
/// the order `c^-8`.
#[test]
fn the_added_mass_of_two_spheres_is_that_of_lamb() {
    let (a, b, c, radius) = (1.0_f64, 1.5_f64, 8.0_f64, 200.0_f64);
    let spheres = [
        AxialSpheroid::sphere(-4.0, a),
        AxialSpheroid::sphere(4.0, b),
    ];
    let ball = Surroundings::Ball { radius };
    let found = added_mass(&spheres, ball, 1e-8)
        .expect("an added mass")
        .matrix;
    let product = (a * b).powi(3);
    let own = |r: f64| 2.0 / 3.0 * PI * r.powi(3) * (1.0 + 3.0 * product / c.powi(6));
    let coupling = -2.0 * PI * product / c.powi(3);
    // the next image, and the ball
    let bound = own(b) * (10.0 * (b / c).powi(8) + 10.0 * (b / radius).powi(3));
    for (i, j, exact) in [(0, 0, own(a)), (1, 1, own(b)), (0, 1, coupling)] {
        let error = (found[(i, j)] - exact).abs();
        assert!(error < bound, "{i} {j}: {error:.1e}, {bound:.1e}");
    }
    assert!((found[(0, 1)] - found[(1, 0)]).abs() < 1e-10 * own(b));
}

/// A sphere that is set in motion: the force of a first step of the length `h` is the added mass
/// over `h` and Basset's force `6 π (1 + h^(-1/2))` of a sudden start, up to a factor of the
/// implicit Euler step, which has `K = 1 + α + α^2 / 9` with `α = h^(-1/2)`.
#[test]
fn the_force_of_a_sudden_start_is_that_of_the_added_mass_and_a_history_force() {
    /// At rest until the first step, whose displacement is that of the speed 1.
    struct Start;
    impl AxialForcing for Start {
        fn displacement(&self, time: f64, _: usize) -> f64 {
            time
        }
    }
    let h = 1e-2;
    let sphere = AxialBody::prescribed(unit_sphere());
    let parameters = (TransientParameters::new(1.0).with_frozen_mesh())
        .with_convection(Convection::Neglected)
        .with_order(8);
    let mut run =
        AxialIntegrator::from_rest(&[sphere], BALL, &Start, parameters, 0.0).expect("a mesh");
    let step = run.try_step(h).expect("a step");
    let added = run.added_mass_forces(&step).expect("an added mass")[0];
    let b3 = 1e3;
    let exact = 2.0 / 3.0 * PI * (b3 + 2.0) / (b3 - 1.0) / h;
    assert!((added / exact - 1.0).abs() < 1e-6, "{added}");
    let rest = (step.forces[0] - added) / (6.0 * PI);
    // the ball, of which the layer of thickness 0.1 feels the added mass alone: `3 / b^3`
    let expected = 1.0 + h.powf(-0.5);
    assert!((rest / expected - 1.0).abs() < 3e-3, "{rest} {expected}");
}
