//! The weak form of the Navier-Stokes equations without swirl on one element.
//!
//! With the notation of [`crate::forms`], the density `ρ`, viscosity 1 and the velocity `w` of the
//! mesh along the axis, the residuals of the equations are
//!
//! ```text
//! a(u, v) + b(v, p) + ∫ (α u + h + ρ ((u - w e_z) · ∇) u) · v,    b(u, q)
//! ```
//!
//! `α u + h` is the density times the time derivative by a difference formula: `h` is known from
//! earlier times.

use nalgebra::{DMatrix, DVector};

use crate::AxisymmetricError;
use crate::curve::Point;
use crate::element::{Lagrange, Table};
use crate::forms::{ElementMatrices, derivatives, scaled};
use crate::geometry_map::{MapPoint, map_points};
use crate::quadrature::{RulePoint, triangle_rule};
use crate::stokes::saddle_point_matrix;

/// A quadrature rule with the basis functions at its points.
pub(crate) struct Rule {
    points: Vec<RulePoint>,
    velocity: Table,
    pressure: Table,
}

impl Rule {
    pub fn new(points: usize, velocity: &Lagrange, pressure: &Lagrange) -> Self {
        let points = triangle_rule(points);
        Self {
            velocity: velocity.tabulate(&points),
            pressure: pressure.tabulate(&points),
            points,
        }
    }
}

/// Coefficients of the momentum equation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Coefficients {
    /// Density `ρ` in the convective term; zero without it.
    pub convection: f64,
    /// Coefficient `α`, the density over the time that the difference formula gives the new value.
    pub mass: f64,
}

/// Nodal values on one element.
pub(crate) struct LocalValues {
    /// One node per row: axial and radial velocity, `w`, axial and radial part of `h`.
    pub at_nodes: DMatrix<f64>,
    pub pressure: DVector<f64>,
}

/// An element with its geometry and the flow at its quadrature points.
pub(crate) struct MomentumElement<'a> {
    rule: &'a Rule,
    points: Vec<MapPoint>,
    coefficients: Coefficients,
    /// Per point and row of [`LocalValues::at_nodes`].
    values: DMatrix<f64>,
    /// `∂u_i/∂z` and `∂u_i/∂r`, per point, at `[i][derivative]`.
    gradients: Vec<[[f64; 2]; 2]>,
    pressure: DVector<f64>,
}

impl<'a> MomentumElement<'a> {
    /// The element with these positions of its nodes.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn new(
        triangle: usize,
        positions: &[Point],
        rule: &'a Rule,
        coefficients: Coefficients,
        local: &LocalValues,
    ) -> Result<Self, AxisymmetricError> {
        let points = map_points(triangle, positions, &rule.velocity, &rule.points)?;
        let velocity = local.at_nodes.columns(0, 2);
        let [by_x, by_y] = (rule.velocity.gradients.each_ref()).map(|g| g.tr_mul(&velocity));
        let gradients = (points.iter().enumerate())
            .map(|(q, point)| {
                [0, 1].map(|i| {
                    [0, 1].map(|d| {
                        point.inverse[(d, 0)] * by_x[(q, i)] + point.inverse[(d, 1)] * by_y[(q, i)]
                    })
                })
            })
            .collect();
        Ok(Self {
            values: rule.velocity.values.tr_mul(&local.at_nodes),
            pressure: rule.pressure.values.tr_mul(&local.pressure),
            rule,
            points,
            coefficients,
            gradients,
        })
    }

    /// Velocity relative to the mesh at a point.
    fn relative(&self, q: usize) -> [f64; 2] {
        [
            self.values[(q, 0)] - self.values[(q, 2)],
            self.values[(q, 1)],
        ]
    }

    /// Residuals of the axial and the radial momentum and of the continuity equation.
    pub fn residual(&self) -> DVector<f64> {
        let m = self.points.len();
        // factors of the derivatives of a test function in the reference triangle, of its value,
        // and of a test function of the pressure
        let [mut by_x, mut by_y, mut by_value] = [0; 3].map(|_| DMatrix::zeros(m, 2));
        let mut by_pressure = DVector::zeros(m);
        for (q, point) in self.points.iter().enumerate() {
            let (weight, pressure) = (point.measure, self.pressure[q]);
            let [to_z, to_r] = self.relative(q);
            let gradient = &self.gradients[q];
            let radial_stretch = self.values[(q, 1)] / point.radius;
            for i in 0..2 {
                let mut flux = gradient[i];
                flux[i] -= pressure;
                let convection = to_z * gradient[i][0] + to_r * gradient[i][1];
                let mut value = self.coefficients.mass * self.values[(q, i)]
                    + self.values[(q, 3 + i)]
                    + self.coefficients.convection * convection;
                if i == 1 {
                    value += (radial_stretch - pressure) / point.radius;
                }
                let inverse = &point.inverse;
                by_x[(q, i)] = weight * (inverse[(0, 0)] * flux[0] + inverse[(1, 0)] * flux[1]);
                by_y[(q, i)] = weight * (inverse[(0, 1)] * flux[0] + inverse[(1, 1)] * flux[1]);
                by_value[(q, i)] = weight * value;
            }
            by_pressure[q] = -weight * (gradient[0][0] + gradient[1][1] + radial_stretch);
        }
        let velocity = &self.rule.velocity;
        let momentum = &velocity.gradients[0] * by_x
            + &velocity.gradients[1] * by_y
            + &velocity.values * by_value;
        let continuity = &self.rule.pressure.values * by_pressure;
        let (n, k) = (momentum.nrows(), continuity.nrows());
        DVector::from_iterator(2 * n + k, momentum.iter().chain(continuity.iter()).copied())
    }

    /// Derivatives of the residuals by the nodal values of the velocities and the pressure.
    pub fn jacobian(&self) -> DMatrix<f64> {
        let (velocity, pressure) = (&self.rule.velocity, &self.rule.pressure);
        let mut matrix =
            saddle_point_matrix(&ElementMatrices::new(&self.points, velocity, pressure));
        let Coefficients { convection, mass } = self.coefficients;
        if convection == 0.0 && mass == 0.0 {
            return matrix;
        }
        let (n, values) = (velocity.values.nrows(), &velocity.values);
        let weighted = scaled(values, |q| self.points[q].measure);
        let [by_z, by_r] = derivatives(&self.points, velocity);
        let mut transported = mass * values;
        for (q, mut column) in transported.column_iter_mut().enumerate() {
            let [to_z, to_r] = self.relative(q);
            column.axpy(convection * to_z, &by_z.column(q), 1.0);
            column.axpy(convection * to_r, &by_r.column(q), 1.0);
        }
        let common = &weighted * transported.transpose();
        for i in 0..2 {
            let mut own = matrix.view_mut((i * n, i * n), (n, n));
            own += &common;
        }
        if convection != 0.0 {
            for i in 0..2 {
                for j in 0..2 {
                    let by_gradient = scaled(values, |q| convection * self.gradients[q][i][j]);
                    let mut block = matrix.view_mut((i * n, j * n), (n, n));
                    block += &weighted * by_gradient.transpose();
                }
            }
        }
        matrix
    }

    /// The matrix `∫ u v` of one component of the velocity.
    pub fn mass(&self) -> DMatrix<f64> {
        let values = &self.rule.velocity.values;
        scaled(values, |q| self.points[q].measure) * values.transpose()
    }

    /// The momentum along the axis over the density, `∫ u_z`.
    pub fn momentum(&self) -> f64 {
        let points = self.points.iter().enumerate();
        points
            .map(|(q, point)| point.measure * self.values[(q, 0)])
            .sum()
    }

    /// Derivative of the residuals by the velocity of the mesh, if it is the same everywhere.
    pub fn by_mesh_velocity(&self) -> DVector<f64> {
        let (n, k) = (
            self.rule.velocity.values.nrows(),
            self.rule.pressure.values.nrows(),
        );
        let factors = DMatrix::from_fn(self.points.len(), 2, |q, i| {
            -self.points[q].measure * self.coefficients.convection * self.gradients[q][i][0]
        });
        let momentum = &self.rule.velocity.values * factors;
        let mut column = DVector::zeros(2 * n + k);
        column
            .rows_mut(0, 2 * n)
            .copy_from_slice(momentum.as_slice());
        column
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The Jacobian is the derivative of the residual: central differences of a quadratic function
    /// are exact up to rounding.
    #[test]
    fn the_jacobian_differentiates_the_residual() {
        let [velocity, pressure] = [3, 2].map(|k| Lagrange::new(k).expect("low order"));
        let rule = Rule::new(7, &velocity, &pressure);
        let corners = [(0.2, 0.1), (1.1, 0.3), (0.5, 0.9)].map(|(z, r)| Point::new(z, r));
        let positions: Vec<Point> = (velocity.nodes.iter())
            .map(|l| corners[0] * l[0] + corners[1] * l[1] + corners[2] * l[2])
            .collect();
        let (n, k) = (velocity.len(), pressure.len());
        let coefficients = Coefficients {
            convection: 1.7,
            mass: 0.6,
        };
        let local = LocalValues {
            at_nodes: DMatrix::from_fn(n, 5, |i, j| ((3 * i + 7 * j) as f64).sin()),
            pressure: DVector::from_fn(k, |i, _| (i as f64).cos()),
        };
        let element = |local: &LocalValues| {
            MomentumElement::new(0, &positions, &rule, coefficients, local).expect("not inverted")
        };
        let jacobian = element(&local).jacobian();
        let frame = element(&local).by_mesh_velocity();
        let difference = |change: &dyn Fn(&mut LocalValues, f64)| {
            let at = |step: f64| {
                let mut changed = LocalValues {
                    at_nodes: local.at_nodes.clone(),
                    pressure: local.pressure.clone(),
                };
                change(&mut changed, step);
                element(&changed).residual()
            };
            0.5 * (at(1.0) - at(-1.0))
        };
        for column in 0..2 * n + k {
            let found = difference(&|local, step| match column < 2 * n {
                true => local.at_nodes[(column % n, column / n)] += step,
                false => local.pressure[column - 2 * n] += step,
            });
            let error = (found - jacobian.column(column)).amax();
            assert!(
                error < 1e-12 * jacobian.amax(),
                "column {column}: {error:e}"
            );
        }
        let found = difference(&|local, step| local.at_nodes.column_mut(2).add_scalar_mut(step));
        assert!((found - &frame).amax() < 1e-12 * frame.amax());
    }
}
