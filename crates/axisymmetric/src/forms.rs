//! The weak form of Stokes flow without swirl, in cylindrical coordinates.
//!
//! With velocity $(u_z, u_r)$ and $\int \cdot = 2\pi \int \cdot\, r\, dr\, dz$,
//!
//! $$a(u, v) = \int \nabla u_z \cdot \nabla v_z + \nabla u_r \cdot \nabla v_r + \frac{u_r v_r}{r^2}, \qquad
//!   b(v, q) = -\int q \Big( \frac{\partial v_z}{\partial z} + \frac{\partial v_r}{\partial r} + \frac{v_r}{r} \Big)$$
//!
//! which are $\int \nabla u : \nabla v$ and $-\int q \operatorname{div} v$ of the flow in space. Forces on bodies that do not turn are those of the form
//! with the symmetric gradient. On the axis $u_r = 0$. (Bernardi, Dauge & Maday, Spectral Methods for Axisymmetric Domains, 1999.)

use nalgebra::DMatrix;

use crate::element::Table;
use crate::shape::MapPoint;

/// The matrices of one element.
pub(crate) struct ElementMatrices {
    /// Of the velocity along the axis.
    pub axial: DMatrix<f64>,
    /// Of the velocity away from the axis.
    pub radial: DMatrix<f64>,
    /// Rows pressures, columns velocities along the axis.
    pub divergence_axial: DMatrix<f64>,
    /// Rows pressures, columns velocities away from the axis.
    pub divergence_radial: DMatrix<f64>,
    /// Diagonal of the pressures' mass matrix.
    pub pressure_mass: Vec<f64>,
}

impl ElementMatrices {
    pub fn new(points: &[MapPoint], velocity: &Table, pressure: &Table) -> Self {
        let (n, m) = (velocity.values.nrows(), points.len());
        // derivatives in space, one function a row
        let derivative = |d: usize| {
            let [by_x, by_y] = &velocity.gradients;
            DMatrix::from_fn(n, m, |i, q| {
                let inverse = &points[q].inverse;
                inverse[(d, 0)] * by_x[(i, q)] + inverse[(d, 1)] * by_y[(i, q)]
            })
        };
        let [along, away] = [derivative(0), derivative(1)];
        let over_radius = scaled(&velocity.values, |q| 1.0 / points[q].radius);
        let measure = |q: usize| points[q].measure;
        let axial = &along * scaled(&along, measure).transpose()
            + &away * scaled(&away, measure).transpose();
        let radial = &axial + &over_radius * scaled(&over_radius, measure).transpose();
        let weighed = scaled(&pressure.values, |q| -points[q].measure);
        let pressure_mass = (0..pressure.values.nrows())
            .map(|i| {
                (0..m)
                    .map(|q| measure(q) * pressure.values[(i, q)].powi(2))
                    .sum()
            })
            .collect();
        Self {
            divergence_axial: &weighed * along.transpose(),
            divergence_radial: &weighed * (away + over_radius).transpose(),
            axial,
            radial,
            pressure_mass,
        }
    }
}

/// Columns times factors.
fn scaled(matrix: &DMatrix<f64>, factor: impl Fn(usize) -> f64) -> DMatrix<f64> {
    let mut scaled = matrix.clone();
    for (q, mut column) in scaled.column_iter_mut().enumerate() {
        column *= factor(q);
    }
    scaled
}
