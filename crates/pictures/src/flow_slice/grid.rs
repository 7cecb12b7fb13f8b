//! Velocity and pressure on a regular grid in a plane.

use models::{FlowField, Hydrodynamics, ModelError, PointFlow};
use nalgebra::{Matrix3, Vector3};
use scene::Scene;
use scene::rheology::ViscosityLaw;
use swimmer::start_flow_at;

use super::plane::{SliceFrame, SlicePlane};
use crate::error::PictureError;

/// Velocity and pressure on a regular grid in a plane, in the scene's units and laboratory frame.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct FlowSlice {
    /// The window.
    pub plane: SlicePlane,
    /// Number of grid points along the width of the window, at least two.
    pub columns: usize,
    /// Number of grid points along the height of the window, at least two.
    pub rows: usize,
    /// Values at the grid points by row, from the bottom row upwards, each row from left to right.
    ///
    /// `None` inside bodies and outside the fluid.
    pub values: Vec<Option<PointFlow>>,
    /// Viscosities at the same points, in a fluid with a viscosity law.
    pub viscosities: Option<Vec<Option<f64>>>,
}

/// Distance of the points of a difference quotient, in grid cells: small enough for two digits, as
/// the colours need, and large enough for jumps between elements, whose maps are inverted
/// iteratively.
const DIFFERENCE: f64 = 0.02;

impl FlowSlice {
    /// The slice of a flow on a grid of about `points` points, at which `evaluate` computes it.
    ///
    /// # Errors
    /// Those of `evaluate`; [`ModelError::WrongCount`] if it does not return one value per point.
    pub fn sample<E: From<ModelError>>(
        plane: SlicePlane,
        points: usize,
        evaluate: impl FnOnce(&[Vector3<f64>]) -> Result<Vec<Option<PointFlow>>, E>,
    ) -> Result<Self, E> {
        let columns = (points as f64 * plane.width / plane.height).sqrt().round() as usize;
        let columns = columns.clamp(2, points.max(2));
        let rows = (points / columns).max(2);
        let at = |k: usize, count: usize| k as f64 / (count - 1) as f64;
        let points: Vec<Vector3<f64>> = (0..rows * columns)
            .map(|k| plane.point([at(k % columns, columns), at(k / columns, rows)]))
            .collect();
        let values = evaluate(&points)?;
        if values.len() != points.len() {
            return Err(E::from(ModelError::WrongCount {
                model: "flow",
                what: "points of a slice",
                found: values.len(),
                expected: points.len(),
            }));
        }
        Ok(Self {
            plane,
            columns,
            rows,
            values,
            viscosities: None,
        })
    }

    /// The same with the viscosities of a law, by differences of velocities close to each point.
    ///
    /// # Errors
    /// As [`FlowSlice::sample`].
    pub fn sample_with_law<E: From<ModelError>>(
        plane: SlicePlane,
        points: usize,
        law: &dyn ViscosityLaw,
        evaluate: impl FnOnce(&[Vector3<f64>]) -> Result<Vec<Option<PointFlow>>, E>,
    ) -> Result<Self, E> {
        let axes = [plane.right, plane.up, plane.normal()];
        let step = DIFFERENCE * (plane.width * plane.height / points.max(1) as f64).sqrt();
        let mut shifted = Vec::new();
        let mut slice = Self::sample(plane, points, |points| -> Result<_, E> {
            let of_point = |x: &Vector3<f64>| axes.map(|axis| x + step * axis);
            let all: Vec<Vector3<f64>> = (points.iter().copied())
                .chain(points.iter().flat_map(of_point))
                .collect();
            let mut values = evaluate(&all)?;
            shifted = values.split_off(points.len().min(values.len()));
            Ok(values)
        })?;
        let viscosities =
            (slice.values.iter().zip(shifted.chunks(axes.len()))).map(|(at, near)| {
                let at = at.as_ref()?;
                let mut gradient = Matrix3::zeros();
                for (axis, near) in axes.iter().zip(near) {
                    gradient += (near.as_ref()?.velocity - at.velocity) / step * axis.transpose();
                }
                let twice = gradient + gradient.transpose();
                Some(law.viscosity((0.5 * twice.dot(&twice)).sqrt()))
            });
        slice.viscosities = Some(viscosities.collect());
        Ok(slice)
    }

    /// The slice of a flow on a mesh.
    ///
    /// # Errors
    /// None: [`FlowField::at`] returns as many values as points.
    pub fn from_field(
        plane: SlicePlane,
        points: usize,
        field: &FlowField,
    ) -> Result<Self, ModelError> {
        Self::sample(plane, points, |points| Ok(field.at(points)))
    }

    /// Largest speed at a grid point; zero without fluid.
    pub fn largest_speed(&self) -> f64 {
        let flows = self.values.iter().flatten();
        flows.map(|flow| flow.velocity.norm()).fold(0.0, f64::max)
    }

    /// In-plane velocity, to the right and upwards, by bilinear interpolation.
    ///
    /// The point `[x, y]` is in units of grid cells from the lower left corner. `None` in a cell
    /// with a corner outside the fluid.
    pub fn in_plane(&self, [x, y]: [f64; 2]) -> Option<[f64; 2]> {
        let inside = |x: f64, count: usize| x >= 0.0 && x <= (count - 1) as f64;
        if !inside(x, self.columns) || !inside(y, self.rows) {
            return None;
        }
        let (column, row) = (
            (x as usize).min(self.columns - 2),
            (y as usize).min(self.rows - 2),
        );
        let (s, t) = (x - column as f64, y - row as f64);
        let corner = |right: usize, up: usize| {
            let flow = self.values[(row + up) * self.columns + column + right]?;
            let plane = &self.plane;
            Some([
                flow.velocity.dot(&plane.right),
                flow.velocity.dot(&plane.up),
            ])
        };
        let corners = [corner(0, 0)?, corner(1, 0)?, corner(0, 1)?, corner(1, 1)?];
        let weights = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        Some([0, 1].map(|k| (corners.iter().zip(weights)).map(|(c, w)| w * c[k]).sum()))
    }

    /// Speeds at the grid points.
    pub fn speeds(&self) -> Vec<Option<f64>> {
        (self.values.iter())
            .map(|flow| flow.map(|flow| flow.velocity.norm()))
            .collect()
    }

    /// Values at the grid points, extrapolated to the points next to the fluid.
    ///
    /// A picture then has no gap along the outline of a body.
    pub fn extrapolated(&self, mut values: Vec<Option<f64>>) -> Vec<Option<f64>> {
        let before = values.clone();
        for (k, value) in values.iter_mut().enumerate().filter(|(_, v)| v.is_none()) {
            let (column, row) = ((k % self.columns) as isize, (k / self.columns) as isize);
            let (mut sum, mut count) = (0.0, 0.0);
            for (right, up) in (-1..2).flat_map(|up| (-1..2).map(move |right| (right, up))) {
                let (column, row) = (column + right, row + up);
                let exists = (0..self.columns as isize).contains(&column)
                    && (0..self.rows as isize).contains(&row);
                if let Some(near) = exists
                    .then(|| before[row as usize * self.columns + column as usize])
                    .flatten()
                {
                    (sum, count) = (sum + near, count + 1.0);
                }
            }
            if count > 0.0 {
                *value = Some(sum / count);
            }
        }
        values
    }
}

/// The flow in the plane of [`SliceFrame`] at the start of the scene, at about `points` points.
///
/// # Errors
/// As [`swimmer::start_flow`].
pub fn start_slice(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    points: usize,
) -> Result<FlowSlice, PictureError> {
    let set = scene.articulation();
    let values = set.initial_shape();
    let poses = set.place(&scene.initial_state(), values)?;
    let plane = SliceFrame::from_scene(scene)?.around(scene, values, &poses);
    let evaluate = |points: &[Vector3<f64>]| start_flow_at(scene, model, points);
    Ok(match scene.viscosity_law() {
        Some(law) => FlowSlice::sample_with_law(plane, points, law, evaluate)?,
        None => FlowSlice::sample(plane, points, evaluate)?,
    })
}

#[cfg(test)]
mod tests {
    use scene::rheology::Law;

    use super::*;

    /// Shear `g^2 = 2 D:D = (y / 2)^2 + 1` of the velocity `(y^2 / 4, 0, x)`, also across the
    /// plane.
    #[test]
    fn viscosities_are_those_of_the_shear_rates() {
        let plane = SlicePlane {
            centre: Vector3::zeros(),
            right: Vector3::x(),
            up: Vector3::y(),
            width: 2.0,
            height: 2.0,
        };
        let law = Law::PowerLaw {
            consistency: 2.0,
            index: 0.5,
            regularisation: 1e-12,
        };
        let flow = |x: &Vector3<f64>| {
            let velocity = Vector3::new(0.25 * x.y * x.y, 0.0, x.x);
            (x.x < 0.5).then_some(PointFlow {
                velocity,
                pressure: None,
            })
        };
        let slice = FlowSlice::sample_with_law(plane, 400, &law, |points| {
            Ok::<_, ModelError>(points.iter().map(flow).collect())
        })
        .unwrap();
        let viscosities = slice.viscosities.as_ref().unwrap();
        assert_eq!(viscosities.len(), slice.values.len());
        for (k, viscosity) in viscosities.iter().enumerate() {
            let at = |k: usize, count: usize| 2.0 * k as f64 / (count - 1) as f64 - 1.0;
            let (x, y) = (
                at(k % slice.columns, slice.columns),
                at(k / slice.columns, slice.rows),
            );
            assert_eq!(viscosity.is_some(), x < 0.5);
            let exact = 2.0 * (0.25 * y * y + 1.0_f64).powf(-0.25);
            // The error of the difference is its step, 0.002, times a quarter of the second
            // derivative.
            let error = viscosity.map_or(0.0, |viscosity| (viscosity / exact - 1.0).abs());
            assert!(error < 3e-4, "{error:e}");
        }
        // Beside the fluid the picture goes on.
        let filled = slice.extrapolated(viscosities.clone());
        assert!(filled.iter().flatten().count() > viscosities.iter().flatten().count());
    }
}
