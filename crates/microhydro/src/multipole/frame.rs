//! The frame in which expansions are made: the axis of collinear spheres, the wall's normal, along z; the container's centre at the origin.

use nalgebra::{DMatrix, UnitQuaternion, Vector3};

use super::collinear::Around;
use crate::{Medium, Spheres};

/// Centres and surroundings in the expansion's frame.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    /// From the laboratory's axes to the frame's.
    pub turn: UnitQuaternion<f64>,
    /// The frame's origin in the laboratory.
    pub origin: Vector3<f64>,
    /// Centres in the frame.
    pub centres: Vec<Vector3<f64>>,
    /// The surroundings.
    pub around: Around,
    /// Whether the z axis is one of spheres and surroundings.
    pub collinear: bool,
}

/// Centres this much of the arrangement's extent off the axis are on it: the rounding of positions that were turned.
const OFF_AXIS: f64 = 1e-13;

impl Frame {
    /// The frame of spheres in a medium.
    pub fn of(spheres: &Spheres, medium: &Medium) -> Self {
        let centres = spheres.centres();
        let (origin, around) = match medium {
            Medium::Unbounded => (
                centres.first().copied().unwrap_or_default(),
                Around::Nothing,
            ),
            Medium::Ball { centre, radius } => (*centre, Around::Ball(*radius)),
            Medium::Wall { point, .. } => (*point, Around::Wall),
        };
        let farthest = centres
            .iter()
            .map(|x| x - origin)
            .max_by(|a, b| a.norm().total_cmp(&b.norm()))
            .and_then(|x| x.try_normalize(0.0));
        let (axis, origin) = match medium {
            // above the first sphere, so that spheres on one normal lie on the axis
            Medium::Wall { normal, .. } => {
                let foot = centres.first().copied().unwrap_or(origin) - origin;
                (
                    normal.into_inner(),
                    origin + foot - normal.dot(&foot) * normal.into_inner(),
                )
            }
            _ => (farthest.unwrap_or_else(Vector3::z), origin),
        };
        let turn = UnitQuaternion::rotation_between(&axis, &Vector3::z()).unwrap_or_else(|| {
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
        });
        let centres: Vec<Vector3<f64>> = centres.iter().map(|x| turn * (x - origin)).collect();
        let extent = centres.iter().fold(0.0_f64, |m, x| m.max(x.norm()));
        let collinear = centres.iter().all(|x| x.xy().norm() <= OFF_AXIS * extent);
        Self {
            turn,
            origin,
            centres,
            around,
            collinear,
        }
    }

    /// A matrix over velocities of the frame's axes, three rows and columns a vector, in the laboratory's axes.
    pub fn to_laboratory(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let q = self.turn.to_rotation_matrix();
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
