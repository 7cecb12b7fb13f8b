//! Connection and dissipation metric over a box of shapes, with their derivatives.

use nalgebra::{DMatrix, Vector6};
use serde::{Deserialize, Serialize};

use super::chebyshev::{Interpolant, chebyshev_node, indices};
use super::space::ShapeSpace;
use crate::error::ModelError;

/// Connection and dissipation metric of a free swimmer over a box of joint values.
///
/// Smaller than a [`ShapeSpace`], with exact derivatives of the interpolating polynomials: what a
/// search over strokes needs. It can be stored.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ShapeGeometry {
    /// Per point: six numbers of the twist per variable, then the metric.
    values: Interpolant,
    /// Joints whose values vary in the box.
    variables: Vec<usize>,
    points: usize,
    errors: (f64, f64),
    position_error: f64,
    #[serde(default)]
    is_coarse: bool,
}

/// Connection and metric at one shape, with their derivatives.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LocalGeometry {
    /// Twist of the frame, linear part first, for a unit rate of each variable.
    pub connection: Vec<Vector6<f64>>,
    /// The dissipation metric `G`: the power on the fluid is `ds/dt · G ds/dt`.
    pub metric: DMatrix<f64>,
    /// Derivatives of the connection with respect to each variable.
    pub connection_slopes: Vec<Vec<Vector6<f64>>>,
    /// Derivatives of the metric with respect to each variable.
    pub metric_slopes: Vec<DMatrix<f64>>,
}

impl ShapeSpace {
    /// Connection and metric as a table of their own. Cost: one evaluation per point of the grid.
    ///
    /// # Errors
    /// None for a table that was computed.
    pub fn geometry(&self) -> Result<ShapeGeometry, ModelError> {
        let (degrees, ranges) = self.grid();
        let (degrees, ranges) = (degrees.to_vec(), ranges.to_vec());
        let variables = self.variables().to_vec();
        let n = variables.len();
        let mut values = Vec::new();
        for index in indices(&degrees) {
            let mut lengths = self.smallest_lengths();
            for (variable, &joint) in variables.iter().enumerate() {
                lengths[joint] =
                    chebyshev_node(ranges[variable], degrees[variable], index[variable]);
            }
            for twist in self.connection(&lengths)? {
                values.extend(twist.linear.iter().chain(twist.angular.iter()));
            }
            let metric = self.metric(&lengths)?;
            // Symmetric by Lorentz reciprocity, up to the errors of the table.
            values.extend((0.5 * (&metric + metric.transpose())).iter());
        }
        Ok(ShapeGeometry {
            values: Interpolant::new(ranges, degrees, n * (6 + n), values),
            variables,
            points: self.points(),
            errors: self.errors(),
            position_error: self.position_error(),
            is_coarse: self.is_coarse(),
        })
    }
}

impl ShapeGeometry {
    /// Joints whose values vary in the box, in the order of the scene.
    pub fn variables(&self) -> &[usize] {
        &self.variables
    }

    /// Smallest and largest value of each variable.
    pub fn ranges(&self) -> &[(f64, f64)] {
        self.values.ranges()
    }

    /// Degree of the interpolating polynomial in each variable.
    pub fn degrees(&self) -> &[usize] {
        self.values.degrees()
    }

    /// Number of shapes at which the model was sampled.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Estimated errors of velocities for a unit rate: of the interpolation, and of the model.
    pub fn errors(&self) -> (f64, f64) {
        self.errors
    }

    /// Estimated change of velocities for a unit rate by the motion of the swimmer in its
    /// container, [`ShapeSpace::position_error`].
    pub fn position_error(&self) -> f64 {
        self.position_error
    }

    /// Whether the interpolation error is above the tolerance, [`ShapeSpace::is_coarse`].
    pub fn is_coarse(&self) -> bool {
        self.is_coarse
    }

    /// Connection and metric at a shape, with one value per variable. Cost: microseconds.
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] for a shape outside the box.
    pub fn at(&self, shape: &[f64]) -> Result<LocalGeometry, ModelError> {
        let n = self.variables.len();
        let is_inside = |(x, range): (&f64, &(f64, f64))| range.0 <= *x && *x <= range.1;
        if shape.len() != n || !shape.iter().zip(self.ranges()).all(is_inside) {
            return Err(ModelError::ShapeSpace {
                problem: format!("the shape {shape:?} is outside the box of the table"),
            });
        }
        let (values, slopes) = self.values.evaluate_with_derivatives(shape);
        let (connection, metric) = parts(&values, n);
        let (connection_slopes, metric_slopes) = slopes.iter().map(|slope| parts(slope, n)).unzip();
        Ok(LocalGeometry {
            connection,
            metric,
            connection_slopes,
            metric_slopes,
        })
    }
}

impl LocalGeometry {
    /// Curvature of the connection for two variables: twist per area of a small stroke in their
    /// plane, from `first` to `second`.
    ///
    /// ```text
    /// F_ij = ∂_i A_j - ∂_j A_i + [A_i, A_j]
    /// ```
    ///
    /// The commutator is that of twists in the moving frame (Kelly & Murray 1995; Hatton & Choset
    /// 2011): `[(v, w), (v', w')] = (w × v' - w' × v, w × w')`. Its components over the box are the
    /// height functions.
    pub fn curvature(&self, first: usize, second: usize) -> Vector6<f64> {
        let (a, b) = (&self.connection[first], &self.connection[second]);
        let [v, w] = [0, 3].map(|at| a.fixed_rows::<3>(at).into_owned());
        let [v_b, w_b] = [0, 3].map(|at| b.fixed_rows::<3>(at).into_owned());
        let (linear, angular) = (w.cross(&v_b) - w_b.cross(&v), w.cross(&w_b));
        let mut curvature =
            self.connection_slopes[first][second] - self.connection_slopes[second][first];
        for k in 0..3 {
            curvature[k] += linear[k];
            curvature[3 + k] += angular[k];
        }
        curvature
    }
}

/// The connection and the metric from the numbers of one point.
fn parts(values: &[f64], n: usize) -> (Vec<Vector6<f64>>, DMatrix<f64>) {
    let (twists, metric) = values.split_at(6 * n);
    (
        twists
            .chunks_exact(6)
            .map(Vector6::from_column_slice)
            .collect(),
        DMatrix::from_column_slice(n, n, metric),
    )
}
