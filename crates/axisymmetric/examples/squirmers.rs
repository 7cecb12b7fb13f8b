//! Speeds of squirmers in a fluid with inertia, against a spectral program.
//!
//! A pusher (`β < 0`) is faster with inertia and a puller slower; the speed of a neutral squirmer
//! does not change at all, because its Stokes flow solves the Navier-Stokes equations.
//!
//! ```text
//! cargo run -p microswim-axisymmetric --example squirmers
//! ```

use axisymmetric::{AxialBody, AxialSpheroid, AxisymmetricError, Surroundings};
use axisymmetric::{SteadyDrive, SteadyParameters, steady_state};

/// Requested error relative to the largest velocity of the fluid.
const TOLERANCE: f64 = 1e-6;

/// Speeds of squirmers `u_θ = 1.5 sin θ (1 + β cos θ)` in a ball of ten times their radius that
/// moves with them, at the Reynolds numbers 0.1, 1 and 5 (speed 1 in unbounded Stokes flow).
const SPEEDS: [(f64, [f64; 3]); 4] = [
    (-3.0, [1.0276845925, 1.2899256442, 1.60805306]),
    (0.0, [0.9975249752; 3]),
    (1.0, [0.9880205145, 0.9294286562, 0.8841824644]),
    (3.0, [0.9697853875, 0.8284492722, 0.7955660509]),
];

/// Prints a table of speeds and their errors.
pub fn main() -> Result<(), AxisymmetricError> {
    let squirmer = AxialBody::free(AxialSpheroid::sphere(0.0, 1.0), 1.0, 0);
    let ball = Surroundings::Ball { radius: 10.0 };
    println!("  β   Re   speed       error");
    for (beta, speeds) in SPEEDS {
        let slip = move |_: usize, [z, r]: [f64; 2]| {
            let along = 1.5 * r * (1.0 + beta * z);
            [-along * r, along * z]
        };
        let drive = SteadyDrive {
            slip: Some(&slip),
            moves_with_body: true,
            ..SteadyDrive::default()
        };
        for (reynolds, exact) in [0.1, 1.0, 5.0].into_iter().zip(speeds) {
            let parameters = SteadyParameters::new(reynolds).with_tolerance(TOLERANCE);
            let found = steady_state(&[squirmer], ball, &drive, &parameters)?;
            let error = found.velocities[0] - exact;
            println!(
                "{beta:>4}  {reynolds:<4} {:.8}  {error:+.1e}",
                found.velocities[0]
            );
            assert!(error.abs() < TOLERANCE * 1.5 * (1.0 + 0.5 * beta.abs()));
        }
    }
    Ok(())
}
