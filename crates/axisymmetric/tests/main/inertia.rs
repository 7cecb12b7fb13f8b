//! Flows with inertia against exact values and independent programs.

use std::f64::consts::PI;

use axisymmetric::{AxialBody, AxialSpheroid, Surroundings};
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
