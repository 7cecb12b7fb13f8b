//! The weak form of the Navier-Stokes equations without swirl on one element.
//!
//! With the notation of [`crate::forms`], the viscous form `s` of [`super::viscosity`], the density
//! `ρ` and the velocity `w` of the mesh along the axis, the residuals of the equations are
//!
//! ```text
//! s(u, v) + b(v, p) + ∫ (α u + h + ρ ((u - w e_z) · ∇) u) · v,    b(u, q)
//! ```
//!
//! `α u + h` is the density times the time derivative by a difference formula: `h` is known from
//! earlier times.

use nalgebra::{DMatrix, DVector};

use super::viscosity::{Strain, Viscosity, tangent};
use crate::AxisymmetricError;
use crate::curve::Point;
use crate::element::{Lagrange, Table};
use crate::forms::{derivatives, divergences, enter_divergences, scaled, transposed};
use crate::geometry_map::MapPoint;
use crate::quadrature::{RulePoint, triangle_rule};

/// A quadrature rule with the basis functions at its points.
pub(crate) struct Rule {
    points: Vec<RulePoint>,
    velocity: Table,
    pressure: Table,
    /// Values and derivatives of `velocity` side by side: all of an element are one product.
    values_and_gradients: DMatrix<f64>,
}

impl Rule {
    pub fn new(points: usize, velocity: &Lagrange, pressure: &Lagrange) -> Self {
        let points = triangle_rule(points);
        let velocity = velocity.tabulate(&points);
        Self {
            pressure: pressure.tabulate(&points),
            values_and_gradients: side_by_side([
                &velocity.values,
                &velocity.gradients[0],
                &velocity.gradients[1],
            ]),
            velocity,
            points,
        }
    }
}

/// Three matrices of the same shape side by side.
fn side_by_side(parts: [&DMatrix<f64>; 3]) -> DMatrix<f64> {
    let (n, m) = parts[0].shape();
    let mut whole = DMatrix::zeros(n, 3 * m);
    for (k, part) in parts.into_iter().enumerate() {
        whole.columns_mut(k * m, m).copy_from(part);
    }
    whole
}

/// Coefficients of the momentum equation.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Coefficients<'a> {
    /// The viscosity.
    pub viscosity: Viscosity<'a>,
    /// Density `ρ` in the convective term; zero without it.
    pub convection: f64,
    /// Coefficient `α`, the density over the time that the difference formula gives the new value.
    pub mass: f64,
}

/// Nodal values on one element.
pub(crate) struct LocalValues {
    /// One node per row: position along the axis and away from it, axial and radial velocity, `w`,
    /// axial and radial part of `h`.
    at_nodes: DMatrix<f64>,
    pressure: DVector<f64>,
}

impl LocalValues {
    /// Of the values of each node: position, velocity, `w` and `h`.
    pub fn new(
        nodes: usize,
        at: impl Fn(usize) -> (Point, Point, f64, Point),
        pressure: DVector<f64>,
    ) -> Self {
        let mut at_nodes = DMatrix::zeros(nodes, H + 2);
        for (node, mut row) in at_nodes.row_iter_mut().enumerate() {
            let (x, u, w, h) = at(node);
            row.copy_from_slice(&[x.x, x.y, u.x, u.y, w, h.x, h.y]);
        }
        Self { at_nodes, pressure }
    }
}

/// An element with its geometry and the flow at its quadrature points.
pub(crate) struct MomentumElement<'a> {
    rule: &'a Rule,
    points: Vec<MapPoint>,
    coefficients: Coefficients<'a>,
    /// Per point and column of [`LocalValues::at_nodes`].
    values: DMatrix<f64>,
    /// `∂u_i/∂z` and `∂u_i/∂r`, per point, at `[i][derivative]`.
    gradients: Vec<[[f64; 2]; 2]>,
    pressure: DVector<f64>,
}

/// First columns of [`LocalValues::at_nodes`] of velocities, of `w` and of `h`.
const U: usize = 2;
const W: usize = 4;
const H: usize = 5;

impl<'a> MomentumElement<'a> {
    /// The element with these values at its nodes.
    ///
    /// # Errors
    /// [`AxisymmetricError::InvertedTriangle`].
    pub fn new(
        triangle: usize,
        rule: &'a Rule,
        coefficients: Coefficients<'a>,
        local: &LocalValues,
    ) -> Result<Self, AxisymmetricError> {
        let values = transposed(&rule.values_and_gradients) * &local.at_nodes;
        let m = rule.points.len();
        let mut points = Vec::with_capacity(m);
        let mut gradients = Vec::with_capacity(m);
        for (q, point) in rule.points.iter().enumerate() {
            let by = |k: usize, column: usize| values[((k + 1) * m + q, column)];
            let position = Point::new(values[(q, 0)], values[(q, 1)]);
            let tangents = [0, 1].map(|k| Point::new(by(k, 0), by(k, 1)));
            let point = MapPoint::new(triangle, position, tangents, point)?;
            gradients.push([0, 1].map(|i| point.derivatives([by(0, U + i), by(1, U + i)])));
            points.push(point);
        }
        Ok(Self {
            pressure: rule.pressure.values.tr_mul(&local.pressure),
            values,
            rule,
            points,
            coefficients,
            gradients,
        })
    }

    /// Velocity relative to the mesh at a point.
    fn relative(&self, q: usize) -> [f64; 2] {
        [
            self.values[(q, U)] - self.values[(q, W)],
            self.values[(q, U + 1)],
        ]
    }

    /// Stretching of circles around the axis, `u_r / r`.
    fn hoop(&self, q: usize) -> f64 {
        self.values[(q, U + 1)] / self.points[q].radius
    }

    fn strain(&self, q: usize) -> Strain {
        Strain::new(&self.gradients[q], self.hoop(q))
    }

    /// Residuals of the axial and the radial momentum and of the continuity equation.
    pub fn residual(&self) -> DVector<f64> {
        let viscosity = &self.coefficients.viscosity;
        let constant = viscosity.constant;
        let momentum = self.momentum_residual(|q| {
            let [to_z, to_r] = self.relative(q);
            let gradient = &self.gradients[q];
            let hoop = self.hoop(q);
            let (excess, pressure) = match viscosity.law {
                Some(_) => (
                    viscosity.excess(self.strain(q).rate()),
                    self.pressure[q] - constant * self.divergence(q),
                ),
                None => (0.0, self.pressure[q]),
            };
            let mut flux = [0, 1].map(|i| {
                [0, 1]
                    .map(|d| constant * gradient[i][d] + excess * (gradient[i][d] + gradient[d][i]))
            });
            let mut value = [0, 1].map(|i| {
                let convection = to_z * gradient[i][0] + to_r * gradient[i][1];
                self.coefficients.mass * self.values[(q, U + i)]
                    + self.values[(q, H + i)]
                    + self.coefficients.convection * convection
            });
            for i in 0..2 {
                flux[i][i] -= pressure;
            }
            value[1] += ((constant + 2.0 * excess) * hoop - pressure) / self.points[q].radius;
            (flux, value)
        });
        let by_pressure = DVector::from_fn(self.points.len(), |q, _| {
            -self.points[q].measure * self.divergence(q)
        });
        let continuity = &self.rule.pressure.values * by_pressure;
        let (n, k) = (momentum.nrows(), continuity.nrows());
        DVector::from_iterator(2 * n + k, momentum.iter().chain(continuity.iter()).copied())
    }

    /// What the form of the constant viscosity omits of the stress, `c ∫ (∇u^T:∇v - ∇·u ∇·v)`; one
    /// basis function per row, axial and radial.
    pub fn omitted_stress(&self) -> DMatrix<f64> {
        let constant = self.coefficients.viscosity.constant;
        self.momentum_residual(|q| {
            let (gradient, divergence) = (&self.gradients[q], self.divergence(q));
            let mut flux = [0, 1].map(|i| [0, 1].map(|d| constant * gradient[d][i]));
            for i in 0..2 {
                flux[i][i] -= constant * divergence;
            }
            let of_hoop = constant * (self.hoop(q) - divergence) / self.points[q].radius;
            (flux, [0.0, of_hoop])
        })
    }

    fn divergence(&self, q: usize) -> f64 {
        self.gradients[q][0][0] + self.gradients[q][1][1] + self.hoop(q)
    }

    /// Integrals `∫ flux_id ∂v_i/∂x_d + value_i v_i` over the element, with both factors at a
    /// point; one basis function per row, axial and radial.
    fn momentum_residual(
        &self,
        factors: impl Fn(usize) -> ([[f64; 2]; 2], [f64; 2]),
    ) -> DMatrix<f64> {
        // factors of the value of a test function, of its derivatives in the reference triangle
        let m = self.points.len();
        let mut by_test = DMatrix::zeros(3 * m, 2);
        for (q, point) in self.points.iter().enumerate() {
            let (weight, inverse) = (point.measure, &point.inverse);
            let (flux, value) = factors(q);
            for (i, flux) in flux.iter().enumerate() {
                by_test[(q, i)] = weight * value[i];
                for k in 0..2 {
                    by_test[((k + 1) * m + q, i)] =
                        weight * (inverse[(0, k)] * flux[0] + inverse[(1, k)] * flux[1]);
                }
            }
        }
        &self.rule.values_and_gradients * by_test
    }

    /// Derivatives of the residuals by the nodal values of the velocities and the pressure.
    pub fn jacobian(&self) -> DMatrix<f64> {
        let (velocity, pressure) = (&self.rule.velocity, &self.rule.pressure.values);
        let Coefficients {
            viscosity,
            convection,
            mass,
        } = self.coefficients;
        let (n, k, m) = (velocity.values.nrows(), pressure.nrows(), self.points.len());
        let measure = |q: usize| self.points[q].measure;
        let [by_z, by_r] = derivatives(&self.points, velocity);
        let tests = [&velocity.values, &by_z, &by_r].map(|table| scaled(table, measure));
        let tests = side_by_side(tests.each_ref());
        // what the values and derivatives of a test function are multiplied with
        let mut trials = side_by_side([&velocity.values, &by_z, &by_r]);
        trials.columns_mut(m, 2 * m).scale_mut(viscosity.constant);
        let mut matrix = DMatrix::zeros(2 * n + k, 2 * n + k);
        for i in 0..2 {
            for q in 0..m {
                let [to_z, to_r] = self.relative(q);
                let hoop = viscosity.constant / self.points[q].radius.powi(2);
                let own = mass + convection * self.gradients[q][i][i] + [0.0, hoop][i];
                let mut trial = trials.column_mut(q);
                trial.axpy(own, &velocity.values.column(q), 0.0);
                if convection != 0.0 {
                    trial.axpy(convection * to_z, &by_z.column(q), 1.0);
                    trial.axpy(convection * to_r, &by_r.column(q), 1.0);
                }
            }
            let mut block = matrix.view_mut((i * n, i * n), (n, n));
            block.gemm(1.0, &tests, &transposed(&trials), 0.0);
            if convection != 0.0 {
                let other = 1 - i;
                let by_gradient = scaled(&velocity.values, |q| {
                    convection * self.gradients[q][i][other]
                });
                let mut block = matrix.view_mut((i * n, other * n), (n, n));
                block.gemm(1.0, &tests.columns(0, m), &transposed(&by_gradient), 0.0);
            }
        }
        let over_radius = scaled(&velocity.values, |q| 1.0 / self.points[q].radius);
        let of_pressure = divergences(&self.points, pressure, &by_z, &by_r, &over_radius);
        enter_divergences(of_pressure.each_ref(), &mut matrix);
        if viscosity.law.is_some() {
            let strains: Vec<Strain> = (0..m).map(|q| self.strain(q)).collect();
            let rest = tangent(&viscosity, &self.points, velocity, &strains);
            let mut block = matrix.view_mut((0, 0), rest.shape());
            block += rest;
        }
        matrix
    }

    /// The scalar stiffness `∫ ∇N_i·∇N_j` of the basis functions of the velocity.
    pub fn stiffness(&self) -> DMatrix<f64> {
        let measure = |q: usize| self.points[q].measure;
        let [by_z, by_r] = derivatives(&self.points, &self.rule.velocity);
        &by_z * transposed(&scaled(&by_z, measure)) + &by_r * transposed(&scaled(&by_r, measure))
    }

    /// Energy whose derivative is the viscous form, the potential of the stress.
    pub fn energy(&self) -> f64 {
        let Viscosity { constant, law, .. } = self.coefficients.viscosity;
        let at = |q: usize| {
            let squares = self.gradients[q].iter().flatten().map(|g| g * g);
            let form = 0.5 * constant * (squares.sum::<f64>() + self.hoop(q).powi(2));
            let rate = self.strain(q).rate();
            let divergence = self.divergence(q);
            form + law.map_or(0.0, |law| {
                law.potential(rate) + 0.5 * constant * (divergence * divergence - rate * rate)
            })
        };
        (self.points.iter().enumerate())
            .map(|(q, point)| point.measure * at(q))
            .sum()
    }

    /// Positions of the quadrature points with the shear rates there.
    pub fn shear_rates(&self) -> impl Iterator<Item = (Point, f64)> + '_ {
        (self.points.iter().enumerate())
            .map(|(q, point)| (Point::new(point.axial, point.radius), self.strain(q).rate()))
    }

    /// Dissipation `∫ 2 η D:D`.
    pub fn dissipation(&self) -> f64 {
        let viscosity = &self.coefficients.viscosity;
        (self.points.iter().enumerate())
            .map(|(q, point)| {
                let rate = self.strain(q).rate();
                point.measure * viscosity.at(rate) * rate * rate
            })
            .sum()
    }

    /// Power `∫ |η - c| g^2` of the part of the viscosity that is not constant.
    pub fn excess(&self) -> f64 {
        let viscosity = &self.coefficients.viscosity;
        (self.points.iter().enumerate())
            .map(|(q, point)| {
                let rate = self.strain(q).rate();
                point.measure * viscosity.excess(rate).abs() * rate * rate
            })
            .sum()
    }

    /// Power `∫ |η_0 - η| g^2` of what the regularisation of the viscosity law changes.
    pub fn regularised(&self) -> f64 {
        let Some(law) = self.coefficients.viscosity.law else {
            return 0.0;
        };
        let at = |rate: f64| match rate > 0.0 {
            true => (law.unregularised_viscosity(rate) - law.viscosity(rate)).abs() * rate * rate,
            false => 0.0,
        };
        (self.points.iter().enumerate())
            .map(|(q, point)| point.measure * at(self.strain(q).rate()))
            .sum()
    }

    /// The matrix `∫ u v` of one component of the velocity.
    pub fn mass(&self) -> DMatrix<f64> {
        let values = &self.rule.velocity.values;
        scaled(values, |q| self.points[q].measure) * transposed(values)
    }

    /// The momentum along the axis over the density, `∫ u_z`.
    pub fn momentum(&self) -> f64 {
        let points = self.points.iter().enumerate();
        points
            .map(|(q, point)| point.measure * self.values[(q, U)])
            .sum()
    }

    /// The square of the velocity, `∫ |u|²`.
    pub fn square_integral(&self) -> f64 {
        let points = self.points.iter().enumerate();
        points
            .map(|(q, point)| {
                let (uz, ur) = (self.values[(q, U)], self.values[(q, U + 1)]);
                point.measure * (uz * uz + ur * ur)
            })
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

    /// An element with polynomial values at its nodes.
    struct Sample {
        rule: Rule,
        local: LocalValues,
    }

    impl Sample {
        fn new() -> Self {
            let [velocity, pressure] = [3, 2].map(|k| Lagrange::new(k).expect("low order"));
            let corners = [(0.2, 0.1), (1.1, 0.3), (0.5, 0.9)].map(|(z, r)| Point::new(z, r));
            let position = |l: &[f64; 3]| (0..3).map(|k| corners[k] * l[k]).sum::<Point>();
            Self {
                rule: Rule::new(7, &velocity, &pressure),
                local: LocalValues {
                    at_nodes: DMatrix::from_fn(velocity.len(), 7, |i, j| match j {
                        0 | 1 => position(&velocity.nodes[i])[j],
                        _ => ((3 * i + 7 * j) as f64).sin(),
                    }),
                    pressure: DVector::from_fn(pressure.len(), |i, _| (i as f64).cos()),
                },
            }
        }

        fn element<'a>(
            &'a self,
            coefficients: Coefficients<'a>,
            local: &LocalValues,
        ) -> MomentumElement<'a> {
            MomentumElement::new(0, &self.rule, coefficients, local).expect("not inverted")
        }

        /// The element after a change.
        fn changed<'a>(
            &'a self,
            coefficients: Coefficients<'a>,
            change: &dyn Fn(&mut LocalValues),
        ) -> MomentumElement<'a> {
            let mut local = LocalValues {
                at_nodes: self.local.at_nodes.clone(),
                pressure: self.local.pressure.clone(),
            };
            change(&mut local);
            self.element(coefficients, &local)
        }

        /// Central differences of the residual and of the energy by each nodal value.
        fn differences(
            &self,
            coefficients: Coefficients,
            step: f64,
        ) -> (DMatrix<f64>, DVector<f64>) {
            let (n, k) = (self.local.at_nodes.nrows(), self.local.pressure.len());
            let change = |column: usize, step: f64| {
                move |local: &mut LocalValues| match column < 2 * n {
                    true => local.at_nodes[(column % n, U + column / n)] += step,
                    false => local.pressure[column - 2 * n] += step,
                }
            };
            let at = |column: usize, step: f64| {
                let element = self.changed(coefficients, &change(column, step));
                (element.residual(), element.energy())
            };
            let mut jacobian = DMatrix::zeros(2 * n + k, 2 * n + k);
            let mut forces = DVector::zeros(2 * n + k);
            for column in 0..2 * n + k {
                let [(above, higher), (below, lower)] = [step, -step].map(|s| at(column, s));
                jacobian.set_column(column, &((above - below) / (2.0 * step)));
                forces[column] = (higher - lower) / (2.0 * step);
            }
            (jacobian, forces)
        }
    }

    /// The Jacobian is the derivative of the residual: central differences of a quadratic function
    /// are exact up to rounding.
    #[test]
    fn the_jacobian_differentiates_the_residual() {
        let sample = Sample::new();
        let coefficients = Coefficients {
            convection: 1.7,
            mass: 0.6,
            ..Coefficients::default()
        };
        let element = sample.element(coefficients, &sample.local);
        let jacobian = element.jacobian();
        let (found, _) = sample.differences(coefficients, 1.0);
        let error = (found - &jacobian).amax();
        assert!(error < 1e-12 * jacobian.amax(), "{error:e}");
        let frame = element.by_mesh_velocity();
        let residual = |step: f64| {
            let change =
                |local: &mut LocalValues| local.at_nodes.column_mut(W).add_scalar_mut(step);
            sample.changed(coefficients, &change).residual()
        };
        let found = 0.5 * (residual(1.0) - residual(-1.0));
        assert!((found - &frame).amax() < 1e-12 * frame.amax());
    }

    /// The stress of every law is the derivative of its potential, and the Jacobian that of the
    /// stress, with a constant part of the viscosity or without.
    #[test]
    fn the_jacobian_of_every_law_differentiates_the_residual_and_that_the_energy() {
        use rheology::Law;
        let sample = Sample::new();
        let laws = [
            Law::Carreau {
                zero_shear_viscosity: 1.3,
                infinite_shear_viscosity: 0.1,
                relaxation_time: 2.0,
                index: 0.4,
            },
            Law::Cross {
                zero_shear_viscosity: 1.0,
                infinite_shear_viscosity: 0.0,
                relaxation_time: 0.5,
                index: 0.3,
            },
            Law::PowerLaw {
                consistency: 2.0,
                index: 0.6,
                regularisation: 1e-3,
            },
            Law::HerschelBulkley {
                yield_stress: 0.7,
                consistency: 1.0,
                index: 1.5,
                regularisation: 1e-2,
            },
        ];
        for (law, constant) in laws.iter().zip([0.0, 1.0, 0.0, 0.4]) {
            let coefficients = Coefficients {
                viscosity: Viscosity {
                    law: Some(law),
                    ..Viscosity::constant(constant)
                },
                ..Coefficients::default()
            };
            let element = sample.element(coefficients, &sample.local);
            let (jacobian, forces) = sample.differences(coefficients, 1e-5);
            let exact = element.jacobian();
            // the square of the step over that of the velocities, and rounding over the step
            let error = (jacobian - &exact).amax() / exact.amax();
            assert!(error < 1e-8, "{law:?}: {error:e}");
            // without the pressure and the forces known from earlier times
            let n = sample.local.at_nodes.nrows();
            let alone = |local: &mut LocalValues| {
                local.pressure.fill(0.0);
                local.at_nodes.columns_mut(H, 2).fill(0.0);
            };
            let viscous = sample.changed(coefficients, &alone).residual();
            let error = (forces.rows(0, 2 * n) - viscous.rows(0, 2 * n)).amax() / viscous.amax();
            assert!(error < 1e-8, "{law:?}: {error:e}");
        }
    }
}
