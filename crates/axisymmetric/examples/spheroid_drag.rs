//! Drag of a spheroid along its axis in unbounded fluid, against the exact formula.
//!
//! ```text
//! cargo run -p microswim-axisymmetric --example spheroid_drag
//! ```

use std::f64::consts::PI;

use axisymmetric::{AxialSpheroid, AxisymmetricError, Surroundings, axial_resistance};

/// Requested relative error.
const TOLERANCE: f64 = 1e-6;

/// Drag over `6 π` of a spheroid with semi-axis `a` along the motion and `b` perpendicular to it
/// (Oberbeck 1876; Happel & Brenner 1983, section 4-26).
fn exact(a: f64, b: f64) -> f64 {
    if a > b {
        let e = (1.0 - (b / a).powi(2)).sqrt();
        let l = ((1.0 + e) / (1.0 - e)).ln();
        a * (8.0 / 3.0) * e.powi(3) / (-2.0 * e + (1.0 + e * e) * l)
    } else if a < b {
        let c = (b * b - a * a).sqrt();
        let t = a / c;
        (4.0 / 3.0) * c / (t - (t * t - 1.0) * (1.0 / t).atan())
    } else {
        a
    }
}

/// Prints a table of drags and their errors for oblate and prolate spheroids.
pub fn main() -> Result<(), AxisymmetricError> {
    println!("axial  drag / 6 π   exact        error    order  dofs");
    for axial in [0.25, 0.5, 1.0, 2.0, 4.0] {
        let spheroid = AxialSpheroid {
            centre: 0.0,
            axial,
            equatorial: 1.0,
        };
        let resistance = axial_resistance(&[spheroid], Surroundings::Unbounded, TOLERANCE)?;
        let drag = resistance.matrix()[(0, 0)] / (6.0 * PI);
        let error = drag / exact(axial, 1.0) - 1.0;
        println!(
            "{axial:<5}  {drag:.9}  {:.9}  {error:+.1e}  {:<5}  {}",
            exact(axial, 1.0),
            resistance.order(),
            resistance.dofs()
        );
        assert!(error.abs() < TOLERANCE);
    }
    Ok(())
}
