//! Polygons of shapes with a time for each side.

use models::{ModelError, ShapeGeometry};
use nalgebra::DMatrix;

use crate::quadrature::{GaussRule, POINTS};
use crate::stroke_path::{SampledPath, StrokeCurve};
use crate::timing::MotionBounds;
use crate::totals::Stroke;

/// Number of intervals of the quadrature along a polygon, at least.
const INTERVALS: usize = 96;

/// Distance of the parts of a split corner from it, relative to the sides.
const SPLIT: f64 = 0.05;

/// A closed polygon of shapes, each side of which is passed at constant rates.
#[derive(Clone, Debug)]
pub struct TimedPolygon {
    /// The corners; the first one follows on the last one.
    pub corners: Vec<Vec<f64>>,
    /// Time of each side, the first one from the first corner to the second.
    pub durations: Vec<f64>,
}

impl TimedPolygon {
    /// The polygon with these corners and the shortest times within bounds: of each rate, and of
    /// the mean power of each side.
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] for corners outside the table.
    pub fn fastest(
        geometry: &ShapeGeometry,
        corners: Vec<Vec<f64>>,
        bounds: &MotionBounds,
    ) -> Result<Self, ModelError> {
        let count = corners.len();
        let stroke = Stroke::along(geometry, &path(&corners))?;
        let energies = side_energies(&stroke, count);
        let durations = (0..count)
            .map(|side| {
                let (from, to) = (&corners[side], &corners[(side + 1) % count]);
                let rates: Vec<f64> = from.iter().zip(to).map(|(a, b)| b - a).collect();
                bounds.load(&rates, energies[side])
            })
            .collect();
        Ok(Self { corners, durations })
    }

    /// The period.
    pub fn period(&self) -> f64 {
        self.durations.iter().sum()
    }

    /// The polygon with a corner in the middle of each side.
    pub fn halved(&self) -> Self {
        let count = self.corners.len();
        let mut corners = Vec::with_capacity(2 * count);
        for (side, from) in self.corners.iter().enumerate() {
            let to = &self.corners[(side + 1) % count];
            corners.push(from.clone());
            corners.push(from.iter().zip(to).map(|(a, b)| 0.5 * (a + b)).collect());
        }
        Self {
            corners,
            durations: (self.durations.iter())
                .flat_map(|t| [0.5 * t, 0.5 * t])
                .collect(),
        }
    }

    /// The polygon with two corners near each one, except near the first one if it is given.
    pub fn split(&self, is_first_given: bool) -> Self {
        let count = self.corners.len();
        let mut corners = Vec::with_capacity(2 * count);
        for (number, here) in self.corners.iter().enumerate() {
            if number == 0 && is_first_given {
                corners.push(here.clone());
                continue;
            }
            for other in [number + count - 1, number + 1] {
                let pairs = here.iter().zip(&self.corners[other % count]);
                corners.push(pairs.map(|(a, b)| a + SPLIT * (b - a)).collect());
            }
        }
        Self {
            // Times are those of the next search.
            durations: vec![self.period() / corners.len() as f64; corners.len()],
            corners,
        }
    }

    /// The polygon moved towards a shape by this part of the distance.
    pub fn moved_towards(&self, shape: &[f64], part: f64) -> Self {
        let moved = |corner: &Vec<f64>| {
            let pairs = corner.iter().zip(shape);
            pairs.map(|(x, to)| x + part * (to - x)).collect()
        };
        Self {
            corners: self.corners.iter().map(moved).collect(),
            durations: self.durations.clone(),
        }
    }

    /// The polygon as a curve, with parameters proportional to the times.
    ///
    /// Sides without a time are left out.
    pub fn curve(&self) -> StrokeCurve {
        let period = self.period();
        let (mut corners, mut times) = (Vec::new(), vec![0.0]);
        let mut time = 0.0;
        for (corner, duration) in self.corners.iter().zip(&self.durations) {
            let next = time + duration / period;
            if next > time {
                corners.push(corner.clone());
                times.push(next);
                time = next;
            }
        }
        // The last sum is 1 up to rounding.
        if let Some(last) = times.last_mut() {
            *last = 1.0;
        }
        StrokeCurve::Polygon { corners, times }
    }
}

/// Number of intervals of the quadrature per side.
fn intervals(sides: usize) -> usize {
    INTERVALS.div_ceil(sides)
}

/// The polygon with equal times for its sides, at the quadrature points.
pub fn path(corners: &[Vec<f64>]) -> SampledPath {
    let sides = corners.len();
    let times: Vec<f64> = (0..=sides).map(|k| k as f64 / sides as f64).collect();
    SampledPath::from_sides(corners, &times, intervals(sides))
}

/// `∫ Δq · G Δq ds` along each side, with the change `Δq` of the shape and `s` from 0 to 1: the
/// mean power in a time of one.
pub fn side_energies(stroke: &Stroke, sides: usize) -> Vec<f64> {
    let (energies, _, _) = stroke.dissipation();
    let per_side = energies.len() / sides;
    // Rates are those of a side that takes a time of 1 / sides.
    (energies.chunks(per_side))
        .map(|side| side.iter().sum::<f64>() / sides as f64)
        .collect()
}

/// Derivatives with respect to both ends of each side, one row per side, from those with respect to
/// shapes and rates at the points of [`path`].
pub fn to_ends(
    of_shapes: &DMatrix<f64>,
    of_rates: &DMatrix<f64>,
    sides: usize,
) -> [DMatrix<f64>; 2] {
    let nodes = GaussRule::new().nodes;
    let (intervals, joints) = (intervals(sides), of_shapes.ncols());
    let mut ends = [DMatrix::zeros(sides, joints), DMatrix::zeros(sides, joints)];
    for row in 0..of_shapes.nrows() {
        let (interval, node) = (row / POINTS, nodes[row % POINTS]);
        let side = interval / intervals;
        let s = ((interval % intervals) as f64 + node) / intervals as f64;
        for joint in 0..joints {
            let (shape, rate) = (of_shapes[(row, joint)], of_rates[(row, joint)]);
            ends[0][(side, joint)] += (1.0 - s) * shape - sides as f64 * rate;
            ends[1][(side, joint)] += s * shape + sides as f64 * rate;
        }
    }
    ends
}
