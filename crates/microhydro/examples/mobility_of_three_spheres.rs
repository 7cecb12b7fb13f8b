//! Three equal spheres at the corners of a triangle settle faster than one alone.
//!
//! Compares the three models: point forces, Rotne-Prager-Yamakawa and multipole expansions.

use std::error::Error;
use std::f64::consts::PI;

use microhydro::nalgebra::{DMatrix, DVector, Vector3};
use microhydro::{Accuracy, Medium, Spheres, multipole, oseen, rpy};

/// Runs the comparison.
pub fn main() -> Result<(), Box<dyn Error>> {
    // Radius 1, side 3, in the plane z = 0.
    let corners = vec![
        Vector3::zeros(),
        Vector3::new(3.0, 0.0, 0.0),
        Vector3::new(1.5, 1.5 * 3.0_f64.sqrt(), 0.0),
    ];
    let spheres = Spheres::new(corners, vec![1.0; 3])?;
    let medium = Medium::Unbounded;

    let resistance = multipole::resistance(&spheres, &medium, &Accuracy::relative(1e-9))?;
    let exact = resistance
        .matrix()
        .clone()
        .try_inverse()
        .ok_or("singular")?;
    let speeds = [
        (
            "oseen",
            settling_speed(&oseen::mobility(&spheres, &medium)?),
        ),
        ("rpy", settling_speed(&rpy::mobility(&spheres, &medium)?)),
        ("multipole", settling_speed(&exact)),
    ];
    println!("speed of three torque-free spheres relative to one alone");
    for (model, speed) in speeds {
        println!("{model:<10} {speed:.6}");
    }
    println!("error      {:.0e} (estimate)", resistance.relative_error());

    // Far field: each neighbour at distance d adds 3/4 a/d.
    assert!((speeds[0].1 - 1.5).abs() < 1e-14);
    // Finite size adds 1/2 (a/d)^3 per neighbour.
    assert!((speeds[1].1 - (1.5 + 1.0 / 27.0)).abs() < 1e-14);
    // Spheres that do not rotate: force per velocity, by boundary collocation (to 1.5e-9).
    let mut together = DVector::zeros(18);
    (0..3).for_each(|sphere| together[6 * sphere + 2] = 1.0);
    let force = resistance.forces(&together)?[2];
    assert!((force - 12.49387889059).abs() < 2e-8, "{force}");
    Ok(())
}

/// Speed of the first sphere along z for equal forces along z and no torques, over that of a lone
/// sphere.
fn settling_speed(mobility: &DMatrix<f64>) -> f64 {
    let speed: f64 = (0..3).map(|sphere| mobility[(2, 6 * sphere + 2)]).sum();
    speed * 6.0 * PI
}
