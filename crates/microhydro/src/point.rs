//! Point forces and torques in unbounded fluid: Stokeslet, rotlet, and what they make of each other.

use std::f64::consts::PI;

use nalgebra::{DMatrix, Matrix3, Matrix6, Vector3};

use crate::Spheres;

/// Velocity and angular velocity at `r` from a force and a torque at the origin, viscosity 1.
///
/// $U = \frac{1}{8 \pi r}((1 + \frac{s}{3 r^2}) I + (1 - \frac{s}{r^2}) \hat r \hat r) F + \frac{1}{8 \pi r^3} T \times r$,
/// $\omega = \frac{1}{8 \pi r^3} F \times r + \frac{1}{16 \pi r^3}(3 \hat r \hat r - I) T$. With $s$ = 0 these are Oseen's tensor, the rotlet and their
/// vorticities; with $s = a_i^2 + a_j^2$ the mobility of two spheres after Rotne, Prager and Yamakawa.
pub(crate) fn pair(r: &Vector3<f64>, s: f64) -> Matrix6<f64> {
    let distance = r.norm();
    let unit = r / distance;
    let (identity, along) = (Matrix3::identity(), unit * unit.transpose());
    let squared = s / (distance * distance);
    let translation =
        (identity * (1.0 + squared / 3.0) + along * (1.0 - squared)) / (8.0 * PI * distance);
    // T x r = -[r] T
    let coupling = -r.cross_matrix() / (8.0 * PI * distance.powi(3));
    let rotation = (along * 3.0 - identity) / (16.0 * PI * distance.powi(3));
    let mut block = Matrix6::zeros();
    block.fixed_view_mut::<3, 3>(0, 0).copy_from(&translation);
    block.fixed_view_mut::<3, 3>(0, 3).copy_from(&coupling);
    block.fixed_view_mut::<3, 3>(3, 0).copy_from(&coupling);
    block.fixed_view_mut::<3, 3>(3, 3).copy_from(&rotation);
    block
}

/// Mobility of spheres from their own drag and [`pair`], with $s$ given for each pair of radii.
pub(crate) fn mobility(spheres: &Spheres, s: impl Fn(f64, f64) -> f64) -> DMatrix<f64> {
    let (x, a) = (spheres.centres(), spheres.radii());
    let n = spheres.len();
    let mut matrix = DMatrix::zeros(6 * n, 6 * n);
    for i in 0..n {
        for k in 0..3 {
            matrix[(6 * i + k, 6 * i + k)] = 1.0 / (6.0 * PI * a[i]);
            matrix[(6 * i + 3 + k, 6 * i + 3 + k)] = 1.0 / (8.0 * PI * a[i].powi(3));
        }
        for j in (0..n).filter(|&j| j != i) {
            matrix
                .fixed_view_mut::<6, 6>(6 * i, 6 * j)
                .copy_from(&pair(&(x[i] - x[j]), s(a[i], a[j])));
        }
    }
    matrix
}
