//! Strokes from which a search starts: the best small ellipses about several shapes.

use std::f64::consts::{PI, TAU};

use models::{LocalGeometry, ShapeGeometry};
use nalgebra::{DMatrix, DVector, Vector3};

use super::objective::Objective;
use super::stroke_path::Series;

/// Sizes of the initial ellipses, relative to the largest ellipse within the limits.
const SIZES: [f64; 2] = [0.3, 0.85];

/// An ellipse of shapes `centre + a cos + b sin` of least energy for its area.
struct Ellipse {
    a: DVector<f64>,
    b: DVector<f64>,
    /// Displacement, or rotation, of the stroke.
    yields: f64,
}

/// Coefficients of the strokes from which to start, all inside the limits.
pub fn starts(
    geometry: &ShapeGeometry,
    objective: &dyn Objective,
    series: &Series,
    limits: &[(f64, f64)],
) -> Vec<Vec<f64>> {
    match series {
        Series::Closed { .. } => closed(geometry, objective, series, limits),
        Series::FromStart { start, .. } => from_start(series, start, limits),
    }
}

fn closed(
    geometry: &ShapeGeometry,
    objective: &dyn Objective,
    series: &Series,
    limits: &[(f64, f64)],
) -> Vec<Vec<f64>> {
    let at = |share: f64| {
        limits
            .iter()
            .map(|r| r.0 + share * (r.1 - r.0))
            .collect::<Vec<f64>>()
    };
    // The middle, and shapes towards the smallest and the largest values.
    let centres = [at(0.5), at(0.25), at(0.75)];
    let mut starts = Vec::new();
    for centre in centres {
        let Ok(local) = geometry.at(&centre) else {
            continue;
        };
        let room = |ellipse: &Ellipse| {
            let joints = (0..centre.len()).map(|k| {
                let extent = ellipse.a[k].hypot(ellipse.b[k]);
                (centre[k] - limits[k].0).min(limits[k].1 - centre[k]) / extent
            });
            joints.fold(f64::INFINITY, f64::min)
        };
        for ellipse in ellipses(&local, objective) {
            let room = room(&ellipse);
            let sizes: Vec<f64> = match objective.size() {
                Some(size) => vec![(size / ellipse.yields).sqrt().min(SIZES[1] * room)],
                None => SIZES.iter().map(|size| size * room).collect(),
            };
            for size in sizes {
                let mut coefficients = vec![0.0; series.functions() * centre.len()];
                for (joint, c) in coefficients.chunks_mut(series.functions()).enumerate() {
                    // The order of the functions is 1, sin, cos.
                    c[0] = centre[joint];
                    (c[1], c[2]) = (size * ellipse.b[joint], size * ellipse.a[joint]);
                }
                starts.push(coefficients);
            }
        }
    }
    starts
}

/// The best ellipses about one shape, one per direction that counts.
///
/// A small ellipse yields `π a · F b` with the curvature `F` and needs the energy
/// `4 π sqrt(det G) |yield| / |F|` in the plane of two joints. Among all planes, the best one is
/// that of the largest singular value of `G^(-1/2) F G^(-1/2)`.
fn ellipses(local: &LocalGeometry, objective: &dyn Objective) -> Vec<Ellipse> {
    let n = local.connection.len();
    let (first, directions) = match (objective.axis(), objective.direction()) {
        (Some(axis), _) => (3, vec![axis]),
        (None, Some(direction)) => (0, vec![direction]),
        (None, None) => (0, vec![Vector3::x(), Vector3::y(), Vector3::z()]),
    };
    let Some(factor) = local.metric.clone().cholesky() else {
        return Vec::new();
    };
    // G = L L^T; shapes are L^-T times orthonormal coordinates.
    let Some(inverse) = factor.l().transpose().try_inverse() else {
        return Vec::new();
    };
    let mut ellipses = Vec::new();
    for direction in directions {
        let curvature = DMatrix::from_fn(n, n, |i, j| match i == j {
            true => 0.0,
            false => local.curvature(i, j).fixed_rows::<3>(first).dot(&direction),
        });
        let scaled = inverse.tr_mul(&curvature) * &inverse;
        let Some((vector, image)) = largest_plane(&scaled) else {
            continue;
        };
        let strength = image.norm();
        // The rotation from `vector` to `image` gives a positive yield.
        let (a, b) = (&inverse * &vector, &inverse * (&image / strength));
        ellipses.push(Ellipse {
            yields: PI * (a.dot(&(&curvature * &b))).abs(),
            a,
            b,
        });
    }
    ellipses
}

/// A unit vector of the plane of the largest singular value of a skew matrix, and its image under
/// the transposed matrix.
fn largest_plane(skew: &DMatrix<f64>) -> Option<(DVector<f64>, DVector<f64>)> {
    let eigen = skew.tr_mul(skew).symmetric_eigen();
    let largest = eigen.eigenvalues.imax();
    let vector = eigen.eigenvectors.column(largest).into_owned();
    let image = skew.tr_mul(&vector);
    let scale = skew.amax();
    (scale > 0.0 && image.norm() > 1e-9 * scale).then_some((vector, image))
}

/// Loops from the start into the box: `p sin πu + q sin 2πu`.
fn from_start(series: &Series, start: &[f64], limits: &[(f64, f64)]) -> Vec<Vec<f64>> {
    let n = start.len();
    let mut starts = Vec::new();
    // Towards the middle of the box, and towards the end of each range that is farther away.
    let far = |k: usize| match start[k] - limits[k].0 > limits[k].1 - start[k] {
        true => limits[k].0 - start[k],
        false => limits[k].1 - start[k],
    };
    for number in 0..=n {
        let towards: Vec<f64> = (0..n)
            .map(|k| match number == n || k == number {
                true => far(k),
                false => 0.3 * far(k),
            })
            .collect();
        for size in [0.15, 0.5] {
            for sign in [1.0, -1.0] {
                let mut coefficients = vec![0.0; series.functions() * n];
                for (joint, c) in coefficients.chunks_mut(series.functions()).enumerate() {
                    let alternating = if joint % 2 == 0 { sign } else { -sign };
                    c[0] = size * towards[joint];
                    // Below a half, so that the loop stays on the inner side.
                    c[1] = 0.3 * alternating * size * towards[joint];
                }
                starts.push(coefficients);
            }
        }
    }
    starts
}

/// Period times energy of the best small stroke about a shape, divided by its displacement:
/// `4 π / σ`, with the largest singular value `σ` of `G^(-1/2) F G^(-1/2)`.
///
/// For two joints `σ = |F| / sqrt(det G)`. None where no small stroke has a displacement in the
/// direction.
pub fn small_stroke_cost(local: &LocalGeometry, objective: &dyn Objective) -> Option<f64> {
    let ellipses = ellipses(local, objective);
    // The energy of `a cos + b sin` with unit vectors in the metric is (2π)² / 2 · 2.
    let cost = |ellipse: &Ellipse| TAU * TAU / ellipse.yields;
    ellipses.iter().map(cost).reduce(f64::min)
}
