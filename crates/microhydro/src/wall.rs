//! Image system of a point force and a point torque at a plane no-slip wall.

use std::f64::consts::PI;

use nalgebra::{Matrix6, UnitVector3, Vector3};

use crate::HydroError;
use crate::multipole::rotation_to_z;

/// Correction to the point mobility due to a plane wall.
///
/// Velocity and angular velocity that the wall adds at `x` for a force (columns 0 to 2) and a
/// torque (columns 3 to 5) at `y`; viscosity 1. The wall goes through `point`; its `normal` points
/// into the fluid, which contains `x` and `y`. The two points may coincide.
///
/// The image system is that of Blake (1971), written in the form of Lorentz (1907). With the
/// velocity `w` and the pressure `q` of the reflected flow, the height `z` of `x` above the wall,
/// its normal `e_z`, and `J = diag(1, 1, -1)`:
/// ```text
/// u*     = -J w - 2 z ∇w_z + z² ∇q
/// curl u* = -curl w - 4 e_z × ∇w_z + 2 z e_z × ∇q
/// ```
///
/// # Errors
/// [`HydroError::NotInFluid`] for a point on the wall or beyond it; [`HydroError::NotFinite`] for
/// lengths whose powers overflow.
pub fn image(
    x: &Vector3<f64>,
    y: &Vector3<f64>,
    point: &Vector3<f64>,
    normal: &UnitVector3<f64>,
) -> Result<Matrix6<f64>, HydroError> {
    for x in [x, y] {
        // The comparison also rejects NaN.
        if (x - point).dot(normal) > 0.0 {
            continue;
        }
        return Err(HydroError::NotInFluid {
            x: x.x,
            y: x.y,
            z: x.z,
        });
    }
    let to_axes = rotation_to_z(normal);
    let (x, y) = (to_axes * (x - point), to_axes * (y - point));
    let mut matrix = Matrix6::zeros();
    for axis in 0..3 {
        let mut unit = Vector3::zeros();
        unit[axis] = 1.0;
        let unit = to_axes * unit;
        for (column, [velocity, spin]) in [
            (axis, image_at_z0(&x, &y, &unit, &Vector3::zeros())),
            (axis + 3, image_at_z0(&x, &y, &Vector3::zeros(), &unit)),
        ] {
            let from_axes = to_axes.inverse();
            matrix
                .fixed_view_mut::<3, 1>(0, column)
                .copy_from(&(from_axes * velocity));
            matrix
                .fixed_view_mut::<3, 1>(3, column)
                .copy_from(&(from_axes * spin));
        }
    }
    match matrix.iter().all(|x| x.is_finite()) {
        true => Ok(matrix),
        false => Err(HydroError::NotFinite {
            what: "the mobility due to the wall",
        }),
    }
}

/// Velocity and angular velocity of the image system for the wall `z = 0`.
fn image_at_z0(
    x: &Vector3<f64>,
    y: &Vector3<f64>,
    force: &Vector3<f64>,
    torque: &Vector3<f64>,
) -> [Vector3<f64>; 2] {
    let reflect = |v: &Vector3<f64>| Vector3::new(v.x, v.y, -v.z);
    // A torque is an axial vector: its reflection has the opposite sign.
    let (f, t) = (reflect(force), -reflect(torque));
    let r = x - reflect(y);
    let (d, z) = (r.norm(), x.z);
    let (d3, d5) = (d.powi(3), d.powi(5));
    let ez = Vector3::z();
    let (rf, rt) = (r.dot(&f), t.cross(&r));
    let w = (f / d + r * (rf / d3) + rt / d3) / (8.0 * PI);
    let normal_gradient = (ez * (rf / d3) + f * (r.z / d3)
        - r * (f.z / d3 + 3.0 * (r.z * rf + rt.z) / d5)
        + ez.cross(&t) / d3)
        / (8.0 * PI);
    let pressure_gradient = (f / d3 - r * (3.0 * rf / d5)) / (4.0 * PI);
    let vorticity =
        f.cross(&r) / (4.0 * PI * d3) + (r * (3.0 * r.dot(&t) / d5) - t / d3) / (8.0 * PI);
    let velocity = -reflect(&w) - normal_gradient * (2.0 * z) + pressure_gradient * (z * z);
    let curl =
        -vorticity - ez.cross(&normal_gradient) * 4.0 + ez.cross(&pressure_gradient) * (2.0 * z);
    [velocity, curl * 0.5]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pair_mobility::pair_mobility;

    #[test]
    fn velocity_vanishes_on_the_wall() {
        let normal = UnitVector3::new_normalize(Vector3::new(0.3, -0.5, 0.9));
        let origin = Vector3::new(0.2, 0.1, -0.4);
        let along = normal.cross(&Vector3::x()).normalize();
        let x = origin + along * 0.7 + normal.cross(&along) * 0.3;
        let y = origin + normal.into_inner() * 1.3 + along * 0.2;
        let total = image(&x, &y, &origin, &normal).unwrap() + pair_mobility(&(x - y), 0.0);
        assert!(total.rows(0, 3).amax() < 1e-15);
    }

    #[test]
    fn image_mobility_is_reciprocal() {
        let normal = UnitVector3::new_normalize(Vector3::new(0.3, -0.5, 0.9));
        let (x, y) = (Vector3::new(1.0, 0.2, 2.0), Vector3::new(-0.3, 0.4, 0.8));
        let forward = image(&x, &y, &Vector3::zeros(), &normal).unwrap();
        let backward = image(&y, &x, &Vector3::zeros(), &normal).unwrap();
        assert!((forward - backward.transpose()).amax() < 1e-15);
    }

    #[test]
    fn self_mobility_has_the_leading_wall_corrections() {
        // Leading corrections for the height h: translation -9/16 a/h parallel and -9/8 a/h normal
        // to the wall, relative to 1/(6 pi a); rotation -1/8 (a/h)^3 about the normal and -5/16
        // (a/h)^3 about a parallel axis, relative to 1/(8 pi a^3).
        let h = 3.0;
        let x = Vector3::new(0.0, 0.0, h);
        let m = image(&x, &x, &Vector3::zeros(), &Vector3::z_axis()).unwrap();
        assert!((m[(0, 0)] * 6.0 * PI + 9.0 / 16.0 / h).abs() < 1e-15);
        assert!((m[(2, 2)] * 6.0 * PI + 9.0 / 8.0 / h).abs() < 1e-15);
        assert!((m[(5, 5)] * 8.0 * PI + 1.0 / 8.0 / h.powi(3)).abs() < 1e-15);
        assert!((m[(3, 3)] * 8.0 * PI + 5.0 / 16.0 / h.powi(3)).abs() < 1e-15);
    }
}
