//! Strokes from which a search starts: the best small ellipses about several shapes, and waves that
//! travel through the joints.

use std::f64::consts::{PI, TAU};

use models::{LocalGeometry, ShapeGeometry};
use nalgebra::{DMatrix, DVector, Vector3};

use super::objective::Objective;
use super::stroke_path::Series;

/// Sizes of the initial ellipses, relative to the largest ellipse within the limits.
const SIZES: [f64; 2] = [0.3, 0.85];

/// Number of travelling waves among the starts of three or more joints.
const WAVES: usize = 8;

/// An ellipse of shapes `centre + a cos + b sin`.
struct Ellipse {
    a: DVector<f64>,
    b: DVector<f64>,
    /// Displacement, or rotation, of the stroke.
    yields: f64,
}

/// The component of the curvature along a direction, or about an axis, of small strokes.
struct Yield(DMatrix<f64>);

impl Yield {
    /// One per direction that counts.
    fn along_all(local: &LocalGeometry, objective: &dyn Objective) -> Vec<Self> {
        let n = local.connection.len();
        let (first, directions) = match (objective.axis(), objective.direction()) {
            (Some(axis), _) => (3, vec![axis]),
            (None, Some(direction)) => (0, vec![direction]),
            (None, None) => (0, vec![Vector3::x(), Vector3::y(), Vector3::z()]),
        };
        let along = |direction: Vector3<f64>| {
            Self(DMatrix::from_fn(n, n, |i, j| match i == j {
                true => 0.0,
                false => local.curvature(i, j).fixed_rows::<3>(first).dot(&direction),
            }))
        };
        directions.into_iter().map(along).collect()
    }

    /// The ellipse in the sense of rotation in which it yields more than zero: `π a · F b`.
    fn ellipse(&self, a: DVector<f64>, b: DVector<f64>) -> Ellipse {
        let yields = PI * a.dot(&(&self.0 * &b));
        let (a, b) = if yields < 0.0 { (b, a) } else { (a, b) };
        Ellipse {
            a,
            b,
            yields: yields.abs(),
        }
    }
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
        let small = ellipses(&local, objective).into_iter();
        let waves = match starts.is_empty() {
            true => waves(&local, objective, limits),
            false => Vec::new(),
        };
        let sized = small.map(|ellipse| (ellipse, &SIZES[..]));
        for (ellipse, shares) in sized.chain(waves.into_iter().map(|wave| (wave, &SIZES[1..]))) {
            let room = room(&ellipse);
            let sizes: Vec<f64> = match objective.size() {
                Some(size) => vec![(size / ellipse.yields).sqrt().min(SIZES[1] * room)],
                None => shares.iter().map(|share| share * room).collect(),
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
    let Some(factor) = local.metric.clone().cholesky() else {
        return Vec::new();
    };
    // G = L L^T; shapes are L^-T times orthonormal coordinates.
    let Some(inverse) = factor.l().transpose().try_inverse() else {
        return Vec::new();
    };
    let mut ellipses = Vec::new();
    for of_strokes in Yield::along_all(local, objective) {
        let scaled = inverse.tr_mul(&of_strokes.0) * &inverse;
        let Some((vector, image)) = largest_plane(&scaled) else {
            continue;
        };
        let strength = image.norm();
        ellipses.push(of_strokes.ellipse(&inverse * &vector, &inverse * (&image / strength)));
    }
    ellipses
}

/// Waves that travel through three or more joints with amplitudes that are shares of their ranges:
/// `a_k = w_k cos φ_k`, `b_k = w_k sin φ_k`.
///
/// The best small ellipses of symmetric swimmers are symmetric themselves, and so are all the
/// strokes to which they lead; the best large stroke need not be. The phases are those of the
/// additive sequence of low discrepancy `φ_k = 2π m / x^k` with `x^(n+1) = x + 1` (Roberts 2018,
/// "The unreasonable effectiveness of quasirandom sequences"), so that any orders and signs of the
/// joints are among the first few.
fn waves(local: &LocalGeometry, objective: &dyn Objective, limits: &[(f64, f64)]) -> Vec<Ellipse> {
    let n = limits.len();
    if n < 3 {
        return Vec::new();
    }
    // Errors shrink by a factor of more than four in each iteration.
    let next = |root: f64| (1.0 + root).powf(1.0 / (n as f64 + 1.0));
    let root = (0..32).fold(1.0, |root, _| next(root));
    let yields = Yield::along_all(local, objective);
    let mut waves = Vec::with_capacity(WAVES * yields.len());
    for number in 1..=WAVES {
        let component = |k: usize, of_phase: fn(f64) -> f64| {
            let phase = TAU * number as f64 / root.powi(k as i32 + 1);
            0.5 * (limits[k].1 - limits[k].0) * of_phase(phase)
        };
        let a = DVector::from_fn(n, |k, _| component(k, f64::cos));
        let b = DVector::from_fn(n, |k, _| component(k, f64::sin));
        waves.extend(yields.iter().map(|of| of.ellipse(a.clone(), b.clone())));
    }
    waves.retain(|wave| wave.yields > 0.0);
    waves
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
