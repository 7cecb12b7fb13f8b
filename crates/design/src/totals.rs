//! Displacement, rotation and energy of a stroke from a table, with derivatives.

use models::{LocalGeometry, ModelError, ShapeGeometry};
use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3, Vector6};
use swimmer::Turning;

use super::quadrature::{GaussRule, POINTS};
use super::stroke_path::SampledPath;

/// Displacement, rotation and energy of a stroke, or the derivatives of a quantity with respect to
/// them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrokeTotals {
    /// Displacement of the frame, in the frame of the start.
    pub displacement: Vector3<f64>,
    /// Rotation vector of the frame, with full turns ([`swimmer::Turning`]).
    pub rotation: Vector3<f64>,
    /// Energy times duration, `T ∫ ds/dt · G ds/dt dt`.
    ///
    /// Independent of the duration. At constant power it is the smallest for the curve: the square
    /// of its length in the metric `G`.
    pub energy: f64,
}

/// Totals of a stroke, with what their derivatives need.
#[non_exhaustive]
pub struct Stroke {
    /// The totals.
    pub totals: StrokeTotals,
    /// Length of the curve in the metric; its square is the product of energy and period at
    /// constant power.
    pub length: f64,
    points: Vec<Point>,
    duration: f64,
}

struct Point {
    geometry: LocalGeometry,
    rates: DVector<f64>,
    weight: f64,
    attitude: UnitQuaternion<f64>,
    position: Vector3<f64>,
}

impl Stroke {
    /// Follows a path through a table.
    ///
    /// The frame moves by `x' = Q v`, `Q' = Q ω` with the twist `(v, ω) = A(s) s'`.
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] for a path that leaves the box of the table.
    pub fn along(geometry: &ShapeGeometry, path: &SampledPath) -> Result<Self, ModelError> {
        let rule = GaussRule::new();
        let mut attitude = UnitQuaternion::identity();
        let mut turning = Turning::default();
        let mut position = Vector3::zeros();
        let (mut energy, mut length) = (0.0, 0.0);
        let duration: f64 = path.widths.iter().sum();
        let mut points = Vec::with_capacity(path.shapes.len());
        for (interval, &width) in path.widths.iter().enumerate() {
            let mut locals = Vec::with_capacity(POINTS);
            let mut twists = [Vector6::zeros(); POINTS];
            for k in 0..POINTS {
                let local = geometry.at(&path.shapes[POINTS * interval + k])?;
                let rates = DVector::from_column_slice(&path.rates[POINTS * interval + k]);
                for (twist, rate) in local.connection.iter().zip(&rates) {
                    twists[k] += width * *rate * twist;
                }
                let power = rates.dot(&(&local.metric * &rates));
                energy += width * rule.weights[k] * power;
                length += width * rule.weights[k] * power.max(0.0).sqrt();
                locals.push((local, rates));
            }
            let spins = twists.map(|twist| Vector3::new(twist[3], twist[4], twist[5]));
            let attitudes: Vec<_> = (0..=POINTS)
                .map(|k| attitude * rule.rotation(&spins, k))
                .collect();
            let velocity =
                |k: usize| attitudes[k] * Vector3::from_iterator(twists[k].iter().copied());
            let velocities = [velocity(0), velocity(1), velocity(2)];
            let moved = |k: usize| {
                let parts = (0..POINTS).map(|j| rule.inner[k][j] * velocities[j]);
                position + parts.sum::<Vector3<f64>>()
            };
            for (k, (geometry, rates)) in locals.into_iter().enumerate() {
                points.push(Point {
                    geometry,
                    rates,
                    weight: width * rule.weights[k],
                    attitude: attitudes[k],
                    position: moved(k),
                });
            }
            position = moved(POINTS);
            for next in attitudes {
                turning.append(&(next * attitude.inverse()));
                attitude = next;
            }
        }
        Ok(Self {
            totals: StrokeTotals {
                displacement: position,
                rotation: turning.rotation_vector(&attitude),
                energy: duration * energy,
            },
            length,
            points,
            duration,
        })
    }

    /// Derivatives of `weights · totals` with respect to the shapes and rates at all points.
    ///
    /// Both matrices have one row per point. A change `(δv, δω)` of the twist at a time with
    /// attitude `Q` and position `x` moves the end by `Q δv + Q δω × (x_end - x)` and turns it by
    /// `Q δω`.
    pub fn derivatives(&self, weights: &StrokeTotals) -> (DMatrix<f64>, DMatrix<f64>) {
        let n = self.points.first().map_or(0, |point| point.rates.len());
        let mut of_shapes = DMatrix::zeros(self.points.len(), n);
        let mut of_rates = DMatrix::zeros(self.points.len(), n);
        let turn = turn_weights(&self.totals.rotation, &weights.rotation);
        let end = self.totals.displacement;
        for (row, point) in self.points.iter().enumerate() {
            let back = point.attitude.inverse();
            let linear = back * weights.displacement;
            let angular = back * ((end - point.position).cross(&weights.displacement) + turn);
            let twist = Vector6::from_iterator(linear.iter().chain(angular.iter()).copied());
            let local = &point.geometry;
            let force = &local.metric * &point.rates;
            let energy = self.duration * weights.energy;
            for i in 0..n {
                of_rates[(row, i)] =
                    point.weight * (twist.dot(&local.connection[i]) + 2.0 * energy * force[i]);
                let change = (local.connection_slopes[i].iter().zip(&point.rates))
                    .map(|(slope, rate)| rate * twist.dot(slope))
                    .sum::<f64>();
                let power = point.rates.dot(&(&local.metric_slopes[i] * &point.rates));
                of_shapes[(row, i)] = point.weight * (change + energy * power);
            }
        }
        (of_shapes, of_rates)
    }

    /// Energy at each point times its weight, with derivatives with respect to shapes and rates.
    ///
    /// The sum over the points is `∫ ds/dt · G ds/dt dt`. Both matrices have one row per point.
    pub fn dissipation(&self) -> (Vec<f64>, DMatrix<f64>, DMatrix<f64>) {
        let n = self.points.first().map_or(0, |point| point.rates.len());
        let mut energies = Vec::with_capacity(self.points.len());
        let mut of_shapes = DMatrix::zeros(self.points.len(), n);
        let mut of_rates = DMatrix::zeros(self.points.len(), n);
        for (row, point) in self.points.iter().enumerate() {
            let force = &point.geometry.metric * &point.rates;
            energies.push(point.weight * point.rates.dot(&force));
            for i in 0..n {
                let change = &point.geometry.metric_slopes[i] * &point.rates;
                of_shapes[(row, i)] = point.weight * point.rates.dot(&change);
                of_rates[(row, i)] = 2.0 * point.weight * force[i];
            }
        }
        (energies, of_shapes, of_rates)
    }

    /// Mean of the metric over the points, with their weights.
    pub fn mean_metric(&self) -> DMatrix<f64> {
        let n = self.points.first().map_or(0, |point| point.rates.len());
        let sum = (self.points.iter()).fold(DMatrix::zeros(n, n), |sum, point| {
            sum + point.weight * &point.geometry.metric
        });
        sum / self.duration
    }
}

/// Weights of a small rotation of the end that change a rotation vector by its `weights`.
///
/// The derivative of the rotation vector `r` is the inverse of the left Jacobian of the exponential
/// map (Chirikjian 2012), `I - [r]/2 + (1/θ² - (1 + cos θ) / (2 θ sin θ)) [r]²`.
fn turn_weights(rotation: &Vector3<f64>, weights: &Vector3<f64>) -> Vector3<f64> {
    let angle = rotation.norm();
    let cross: Matrix3<f64> = rotation.cross_matrix();
    let factor = match angle < 1e-3 {
        // The series of the bracket; the next term is below 1e-9 of it.
        true => 1.0 / 12.0 + angle * angle / 720.0,
        false => 1.0 / (angle * angle) - (1.0 + angle.cos()) / (2.0 * angle * angle.sin()),
    };
    weights + 0.5 * cross * weights + factor * cross * (cross * weights)
}
