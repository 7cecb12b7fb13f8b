//! What the upper half of the plot shows, and the plane of the lower half.

use nalgebra::{UnitQuaternion, Vector3};
use scene::{Domain, Scene, Shape};

use swimmer::{Outcome, Sample};

use super::style::direction_name;

/// Displacements below this part of the smallest body are not shown if bodies turn more.
const MIN_DISPLACEMENT: f64 = 0.01;

/// A number for every body at every time.
pub enum Quantity {
    /// Displacement along a unit vector.
    Displacement(Vector3<f64>),
    /// Angle in radians by which bodies turned about a unit vector.
    Angle(Vector3<f64>),
}

impl Quantity {
    /// Displacements, or angles if bodies turn and hardly move.
    pub fn new(scene: &Scene, outcome: &Outcome) -> Self {
        let start = outcome.curve.first().map_or(&[][..], |(_, x)| x);
        let moved = largest(
            &mut outcome
                .curve
                .iter()
                .flat_map(|(_, x)| x.iter().zip(start).map(|(x, start)| x - start)),
        );
        let radii = scene.bodies().iter().map(|body| body.bounding_radius());
        let smallest = radii.filter(|r| *r > 0.0).fold(f64::INFINITY, f64::min);
        let rotation =
            Self::rotation(outcome).filter(|_| moved.norm() < MIN_DISPLACEMENT * smallest);
        rotation.unwrap_or_else(|| Quantity::Displacement(swimmer_axis(outcome)))
    }

    /// Angles about the axis of the largest rotation; `None` if bodies hardly turn.
    pub fn rotation(outcome: &Outcome) -> Option<Self> {
        let angles = angles(outcome).into_iter();
        let turned = largest(&mut angles.flat_map(|(_, angles)| angles));
        (turned.norm() > MIN_DISPLACEMENT).then(|| Quantity::Angle(positive(turned)))
    }

    /// Title of the plot.
    pub fn title(&self) -> String {
        match self {
            Quantity::Displacement(e) => {
                format!("displacement of the bodies along {}", direction_name(e))
            }
            Quantity::Angle(e) => format!("rotation of the bodies about {}", direction_name(e)),
        }
    }

    /// Label of the vertical axis.
    pub fn label(&self) -> &'static str {
        match self {
            Quantity::Displacement(_) => "displacement (the scene's unit of length)",
            Quantity::Angle(_) => "angle (radians)",
        }
    }

    /// Times and values of every body, for curves.
    pub fn curve(&self, outcome: &Outcome) -> Vec<(f64, Vec<f64>)> {
        match self {
            Quantity::Displacement(e) => {
                let start = &outcome.curve[0].1;
                let along = |x: &[Vector3<f64>]| {
                    x.iter()
                        .zip(start)
                        .map(|(x, start)| (x - start).dot(e))
                        .collect()
                };
                outcome
                    .curve
                    .iter()
                    .map(|(time, x)| (*time, along(x)))
                    .collect()
            }
            Quantity::Angle(e) => about(outcome, e),
        }
    }

    /// Times and values of every body at the solves, for points.
    pub fn points(&self, outcome: &Outcome) -> Vec<(f64, Vec<f64>)> {
        let all = match self {
            Quantity::Displacement(e) => {
                let start = &outcome.curve[0].1;
                let values = outcome.samples.iter().map(|sample| {
                    let along = sample.poses.iter().zip(start);
                    let along = along.map(|(pose, x)| (pose.translation.vector - x).dot(e));
                    (sample.time, along.collect())
                });
                values.collect()
            }
            Quantity::Angle(e) => about(outcome, e),
        };
        let solved = outcome.samples.iter().map(|sample| sample.bodies.is_some());
        let points = all.into_iter().zip(solved);
        points
            .filter_map(|(point, solved)| solved.then_some(point))
            .collect()
    }

    /// Unit vectors to the right and upwards in pictures of the bodies.
    pub fn plane(&self, scene: &Scene, outcome: &Outcome) -> [Vector3<f64>; 2] {
        match self {
            // A wall is seen from the side, below the bodies.
            Quantity::Displacement(axis) if matches!(scene.domain(), Domain::Wall) => {
                let along = Vector3::new(axis.x, axis.y, 0.0);
                let right = along.try_normalize(MIN_DISPLACEMENT);
                [right.unwrap_or_else(Vector3::x), Vector3::z()]
            }
            Quantity::Displacement(axis) => [*axis, side_axis(scene, outcome, axis)],
            Quantity::Angle(axis) => {
                let any = if axis.x.abs() < 0.9 {
                    Vector3::x()
                } else {
                    Vector3::y()
                };
                let right = (any - axis * any.dot(axis)).normalize();
                [right, axis.cross(&right)]
            }
        }
    }
}

/// The longest of some vectors.
fn largest(vectors: &mut dyn Iterator<Item = Vector3<f64>>) -> Vector3<f64> {
    vectors.fold(Vector3::zeros(), |largest: Vector3<f64>, v| {
        if v.norm() > largest.norm() {
            v
        } else {
            largest
        }
    })
}

/// Times and angles about an axis, of every body at every sample.
fn about(outcome: &Outcome, axis: &Vector3<f64>) -> Vec<(f64, Vec<f64>)> {
    let angles = angles(outcome).into_iter();
    let about = |angles: Vec<Vector3<f64>>| angles.iter().map(|a| a.dot(axis)).collect();
    angles.map(|(time, angles)| (time, about(angles))).collect()
}

/// Integrals of the angular velocities up to each sample: angles with all full turns about an axis
/// that stays.
fn angles(outcome: &Outcome) -> Vec<(f64, Vec<Vector3<f64>>)> {
    let of_sample = |sample: &Sample| {
        let turnings = sample.turnings.iter();
        (
            sample.time,
            turnings.map(|turning| turning.vector).collect(),
        )
    };
    outcome.samples.iter().map(of_sample).collect()
}

/// The line of collinear bodies, or the direction of the net displacement.
fn swimmer_axis(outcome: &Outcome) -> Vector3<f64> {
    let start = outcome.curve.first().map_or(&[][..], |(_, x)| x);
    let longest = start
        .iter()
        .skip(1)
        .map(|x| x - start[0])
        .max_by(|a, b| a.norm().total_cmp(&b.norm()));
    let collinear = |e: &Vector3<f64>| {
        start
            .iter()
            .all(|x| (x - start[0]).cross(e).norm() <= 1e-9 * e.norm().powi(2))
    };
    match longest {
        Some(e) if collinear(&e) => positive(e),
        _ => positive(outcome.displacement.iter().sum()),
    }
}

/// The unit vector along `e` or `-e` whose largest component is positive: x points to the right.
fn positive(e: Vector3<f64>) -> Vector3<f64> {
    let sign = e[e.iamax()].signum();
    e.try_normalize(0.0).map_or(Vector3::x(), |e| sign * e)
}

/// A unit vector normal to the axis: the direction in which bodies are apart, bend, are long, or
/// move.
fn side_axis(scene: &Scene, outcome: &Outcome, axis: &Vector3<f64>) -> Vector3<f64> {
    let start = &outcome.curve[0].1;
    let apart = start.iter().map(|x| x - start[0]);
    let poses = outcome
        .samples
        .first()
        .map_or(&[][..], |sample| &sample.poses);
    let long = scene
        .bodies()
        .iter()
        .zip(poses)
        .flat_map(|(body, pose)| elongations(&body.shape).map(|e| pose.rotation * e));
    let bent = outcome.samples.iter().flat_map(|sample| {
        let bodies = scene.bodies_at(&sample.shape).into_owned().into_iter();
        let bodies = bodies.zip(&sample.poses);
        bodies.flat_map(|(body, pose)| {
            let is_bent = body.deformation.is_some();
            let line = is_bent.then(|| body.shape.centreline()).into_iter();
            line.flatten().map(|(x, _)| pose.rotation * x)
        })
    });
    let moved = outcome.displacement.iter().copied();
    let across = |e: Vector3<f64>| e - axis * e.dot(axis);
    for vectors in [
        &mut apart.map(across) as &mut dyn Iterator<Item = Vector3<f64>>,
        &mut bent.map(across),
        &mut long.map(across),
        &mut moved.map(across),
    ] {
        let widest = vectors.max_by(|a, b| a.norm().total_cmp(&b.norm()));
        if let Some(e) = widest.filter(|e| e.norm() > 1e-9) {
            return positive(e);
        }
    }
    let any = if axis.y.abs() < 0.9 {
        Vector3::y()
    } else {
        Vector3::z()
    };
    across(any).normalize()
}

/// By how much a body is longer along its own axes than along the shortest of them, at the start.
fn elongations(shape: &Shape) -> [Vector3<f64>; 3] {
    let turn = shape.orientation();
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()].map(|e| turn * e);
    let lengths = axes.map(|e| shape.support_distance(&UnitQuaternion::identity(), &e));
    let shortest = lengths.into_iter().fold(f64::INFINITY, f64::min);
    [0, 1, 2].map(|k| (lengths[k] - shortest) * axes[k])
}
