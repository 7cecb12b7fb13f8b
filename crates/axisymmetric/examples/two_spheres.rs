//! Drag of two equal spheres that move at the same velocity along their line of centres, against
//! the series of Stimson & Jeffery (1926).
//!
//! ```text
//! cargo run -p microswim-axisymmetric --example two_spheres
//! ```

use std::f64::consts::PI;

use axisymmetric::{AxialSpheroid, AxisymmetricError, Surroundings, axial_resistance};

/// Requested relative error.
const TOLERANCE: f64 = 1e-6;

/// Drag of each sphere over that of a single one, for spheres of radius 1 at this distance
/// (Stimson & Jeffery 1926; Happel & Brenner 1983, section 6-1).
fn exact(distance: f64) -> f64 {
    let alpha = (0.5 * distance).acosh();
    let term = |n: u32| {
        let n = f64::from(n);
        let m = 2.0 * n + 1.0;
        let numerator = 4.0 * (0.5 * m * alpha).sinh().powi(2) - (m * alpha.sinh()).powi(2);
        let denominator = 2.0 * (m * alpha).sinh() + m * (2.0 * alpha).sinh();
        n * (n + 1.0) / ((2.0 * n - 1.0) * (2.0 * n + 3.0)) * (1.0 - numerator / denominator)
    };
    // terms decay as exp(-(2 n + 1) alpha)
    4.0 / 3.0 * alpha.sinh() * (1..80).map(term).sum::<f64>()
}

/// Prints a table of drags and their errors for several distances.
pub fn main() -> Result<(), AxisymmetricError> {
    println!("distance  drag / 6 π   exact        error");
    for distance in [2.1, 3.0, 5.0, 10.0] {
        let spheres = [0.0, distance].map(|z| AxialSpheroid::sphere(z, 1.0));
        let resistance = axial_resistance(&spheres, Surroundings::Unbounded, TOLERANCE)?;
        let drag = resistance.matrix().row(0).sum() / (6.0 * PI);
        let error = drag / exact(distance) - 1.0;
        println!(
            "{distance:<8}  {drag:.9}  {:.9}  {error:+.1e}",
            exact(distance)
        );
        // the sum of a row has larger relative errors than the diagonal entries
        assert!(error.abs() < 5.0 * TOLERANCE);
    }
    Ok(())
}
