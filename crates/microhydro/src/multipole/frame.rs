//! Frame of the expansions.
//!
//! The z axis is the axis of collinear spheres or the normal of the wall; the origin is the centre
//! of the container, or a point on the wall or the first sphere.

use nalgebra::{DMatrix, UnitQuaternion, Vector3};

use super::rotation::rotation_to_z;
use crate::{Medium, Spheres};

/// Boundary of the fluid in the frame of the expansions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Surroundings {
    /// No boundary.
    Unbounded,
    /// A container of the given radius about the origin.
    Ball(f64),
    /// The wall `z = 0`, with the fluid above it.
    Wall,
}

/// Centres and boundary in the frame of the expansions.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// Rotation from the laboratory frame to this frame.
    pub to_axes: UnitQuaternion<f64>,
    /// Origin of this frame in the laboratory frame.
    pub origin: Vector3<f64>,
    /// Centres of the spheres in this frame.
    pub centres: Vec<Vector3<f64>>,
    /// Boundary of the fluid in this frame.
    pub surroundings: Surroundings,
    /// Whether spheres and boundary are symmetric about the z axis.
    pub collinear: bool,
}

/// Largest distance of a centre on the axis from the axis, relative to the extent of all spheres.
///
/// It covers the rounding of rotated positions.
const AXIS_TOLERANCE: f64 = 1e-13;

impl Frame {
    /// Frame of spheres in a medium.
    pub fn new(spheres: &Spheres, medium: &Medium) -> Self {
        let centres = spheres.centres();
        let (origin, surroundings) = match medium {
            Medium::Unbounded => (
                centres.first().copied().unwrap_or_default(),
                Surroundings::Unbounded,
            ),
            Medium::Ball { centre, radius } => (*centre, Surroundings::Ball(*radius)),
            Medium::Wall { point, .. } => (*point, Surroundings::Wall),
        };
        let farthest = centres
            .iter()
            .map(|x| x - origin)
            .max_by(|a, b| a.norm().total_cmp(&b.norm()))
            .and_then(|x| x.try_normalize(0.0));
        let (axis, origin) = match medium {
            // below the first sphere, so that spheres on one normal lie on the axis
            Medium::Wall { normal, .. } => {
                let foot = centres.first().copied().unwrap_or(origin) - origin;
                (
                    normal.into_inner(),
                    origin + foot - normal.dot(&foot) * normal.into_inner(),
                )
            }
            _ => (farthest.unwrap_or_else(Vector3::z), origin),
        };
        let to_axes = rotation_to_z(&axis);
        let centres: Vec<Vector3<f64>> = centres.iter().map(|x| to_axes * (x - origin)).collect();
        let extent = centres.iter().fold(0.0_f64, |m, x| m.max(x.norm()));
        let collinear = centres
            .iter()
            .all(|x| x.xy().norm() <= AXIS_TOLERANCE * extent);
        Self {
            to_axes,
            origin,
            centres,
            surroundings,
            collinear,
        }
    }

    /// The axes of the laboratory, without a boundary.
    pub fn laboratory(spheres: &Spheres) -> Self {
        Self {
            to_axes: UnitQuaternion::identity(),
            origin: Vector3::zeros(),
            centres: spheres.centres().to_vec(),
            surroundings: Surroundings::Unbounded,
            collinear: false,
        }
    }

    /// Transforms a matrix over vectors, three rows and columns each, from this frame to the
    /// laboratory frame.
    pub fn to_laboratory(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let q = self.to_axes.to_rotation_matrix();
        let mut result = matrix.clone();
        for first in (0..matrix.ncols()).step_by(3) {
            let block = result.columns(first, 3) * q.matrix();
            result.columns_mut(first, 3).copy_from(&block);
        }
        for first in (0..matrix.nrows()).step_by(3) {
            let block = q.matrix().transpose() * result.rows(first, 3);
            result.rows_mut(first, 3).copy_from(&block);
        }
        result
    }
}
