//! The plane of a slice and the window in it.

use std::slice::from_ref;

use nalgebra::{Isometry3, Point3, Vector3};
use scene::{Body, Domain, Scene, spans};
use serde::{Deserialize, Serialize};

use crate::error::PictureError;

/// Margin around the bodies on each side, relative to the mean side of their bounding rectangle.
const MARGIN: f64 = 0.25;

/// Least margin, relative to half the smaller side of the largest body in the plane.
const LEAST_MARGIN: f64 = 1.6;

/// The same in domains from files, whose walls are to be seen and whose extent is not known.
const LEAST_MARGIN_IN_FILES: f64 = 3.2;

/// Least side of a window relative to the diameter of the largest body, which may turn.
const LEAST_SIDE: f64 = 1.2;

/// Bounds on the ratio of width to height of a window.
const ASPECT: [f64; 2] = [0.75, 2.2];

/// Width of the strip beyond a wall that a window shows, relative to its width: that of the strokes
/// which mark walls.
const BEYOND_WALL: f64 = 0.02;

/// Distance of a window from a wall, relative to the margin around the bodies, up to which the
/// window is shifted to show the wall.
const NEAR_WALL: f64 = 0.4;

/// Positions along a phase span at which the extent of the swimmer is measured.
const POSITIONS: [f64; 5] = [0.0, 0.25, 0.5, 0.75, 1.0];

/// Directions and size of the windows of a scene; the windows follow the swimmer.
///
/// The plane contains the longest vector between two centres. Its second direction is the largest
/// component normal to this vector of the other vectors between centres; if all centres are on one
/// line, it is that of the displacements by the joints, else of forces, weights and slip, else of
/// the long axes of bodies. Planes normal to a coordinate axis have coordinate axes as directions.
#[derive(Clone, Debug)]
pub struct SliceFrame {
    right: Vector3<f64>,
    up: Vector3<f64>,
    width: f64,
    height: f64,
    /// Width of the strip beyond a wall.
    strip: f64,
}

/// A rectangle in space.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
pub struct SlicePlane {
    /// Middle of the rectangle.
    pub centre: Vector3<f64>,
    /// Unit vector to the right.
    pub right: Vector3<f64>,
    /// Unit vector upwards, normal to `right`.
    pub up: Vector3<f64>,
    /// Length along `right`.
    pub width: f64,
    /// Length along `up`.
    pub height: f64,
}

impl SliceFrame {
    /// The frame of a scene, whose windows contain the bodies at all shapes of the gait.
    ///
    /// # Errors
    /// A loop that does not close at some shape.
    pub fn from_scene(scene: &Scene) -> Result<Self, PictureError> {
        let (set, state) = (scene.articulation(), scene.initial_state());
        let initial = set.initial_shape();
        let mut shapes = vec![initial.to_vec()];
        let phases = scene.gait().phases.len();
        for span in spans(scene.gait(), initial)?.take(phases) {
            shapes.extend(POSITIONS.map(|s| span.shape(s)));
        }
        let poses = shapes.iter().map(|shape| set.place(&state, shape));
        let poses = poses.collect::<Result<Vec<_>, _>>()?;
        let [right, up] = directions(scene, &poses);
        let (mut size, mut largest) = ([0.0_f64; 2], 0.0_f64);
        for (shape, poses) in shapes.iter().zip(&poses) {
            let bodies = scene.bodies_at(shape);
            let extents = [right, up].map(|e| extent(&bodies, poses, &e));
            for (size, (low, high)) in size.iter_mut().zip(extents) {
                *size = size.max(high - low);
            }
        }
        let mut longest = 0.0_f64;
        for (body, pose) in scene.bodies_at(initial).iter().zip(&poses[0]) {
            let sides = [right, up].map(|e| extent(from_ref(body), from_ref(pose), &e));
            let [first, second] = sides.map(|(low, high)| 0.5 * (high - low));
            largest = largest.max(first.min(second));
            longest = longest.max(body.bounding_radius());
        }
        let least = match scene.domain() {
            Domain::Surface(_) | Domain::Mesh { .. } => LEAST_MARGIN_IN_FILES,
            _ => LEAST_MARGIN,
        };
        let margin = (MARGIN * 0.5 * (size[0] + size[1])).max(least * largest);
        let [mut width, mut height] =
            size.map(|side| (side + 2.0 * margin).max(2.0 * LEAST_SIDE * longest));
        width = width.max(ASPECT[0] * height);
        height = height.max(width / ASPECT[1]);
        let strip = BEYOND_WALL * width;
        let limit = |side: f64, e: &Vector3<f64>| {
            let (low, high) = domain_extent(scene.domain(), e);
            // From wall to wall, if little is missing.
            match side + 2.0 * strip > high - low {
                true => high - low + 2.0 * strip,
                false => side,
            }
        };
        Ok(Self {
            right,
            up,
            width: limit(width, &right),
            height: limit(height, &up),
            strip,
        })
    }

    /// The window around bodies at these values of the joints and poses.
    ///
    /// It is centred on their bounding rectangle, and shifted to a wall that is near or that it
    /// crosses. Shifts change continuously with the positions, so that films do not jump.
    pub fn around(&self, scene: &Scene, values: &[f64], poses: &[Isometry3<f64>]) -> SlicePlane {
        let bodies = scene.bodies_at(values);
        let normal = self.right.cross(&self.up);
        let count = poses.len().max(1) as f64;
        let mean = poses
            .iter()
            .map(|pose| pose.translation.vector)
            .sum::<Vector3<f64>>()
            / count;
        let along = |e: &Vector3<f64>, side: f64| {
            let (low, high) = extent(&bodies, poses, e);
            let (from, to) = domain_extent(scene.domain(), e);
            let half = 0.5 * side;
            let (from, to) = (from - self.strip + half, to + self.strip - half);
            let middle = 0.5 * (low + high);
            let near = NEAR_WALL * (half - 0.5 * (high - low));
            let towards = |gap: f64| gap.min(2.0 * near - gap).max(0.0);
            let middle = middle + towards(to - middle) - towards(middle - from);
            // A window is at most as large as the domain, so the bounds are in order.
            middle.min(to).max(from)
        };
        let centre = normal * mean.dot(&normal)
            + self.right * along(&self.right, self.width)
            + self.up * along(&self.up, self.height);
        SlicePlane {
            centre,
            right: self.right,
            up: self.up,
            width: self.width,
            height: self.height,
        }
    }
}

impl SlicePlane {
    /// Unit normal, towards the viewer.
    pub fn normal(&self) -> Vector3<f64> {
        self.right.cross(&self.up)
    }

    /// Coordinates of a point in the window, both from 0 to 1, the second one upwards.
    pub fn coordinates(&self, x: &Vector3<f64>) -> [f64; 2] {
        let arm = x - self.centre;
        [
            0.5 + arm.dot(&self.right) / self.width,
            0.5 + arm.dot(&self.up) / self.height,
        ]
    }

    /// The point with these coordinates in the window.
    pub fn point(&self, coordinates: [f64; 2]) -> Vector3<f64> {
        let [a, b] = coordinates.map(|c| c - 0.5);
        self.centre + self.right * (a * self.width) + self.up * (b * self.height)
    }
}

/// Directions to the right and upwards.
fn directions(scene: &Scene, shapes: &[Vec<Isometry3<f64>>]) -> [Vector3<f64>; 2] {
    let poses = &shapes[0];
    let centre = |k: usize| poses[k].translation.vector;
    let apart = (0..poses.len()).flat_map(|i| (0..i).map(move |j| centre(i) - centre(j)));
    let moved = shapes.iter().flat_map(|shape| {
        let pairs = shape.iter().zip(poses);
        pairs.map(|(a, b)| a.translation.vector - b.translation.vector)
    });
    let bodies = scene.bodies();
    let acting = bodies.iter().flat_map(|body| {
        let slip = body.slip.as_ref().map(|slip| slip.axis);
        [body.force, body.weight, slip.unwrap_or_default()]
    });
    let long = bodies.iter().zip(poses).filter_map(|(body, pose)| {
        let axis = body.shape.axis()?;
        let length = body
            .shape
            .support_distance(&pose.rotation, &(pose.rotation * axis));
        (length >= body.bounding_radius()).then_some(pose.rotation * axis)
    });
    // In the order of priority.
    let groups: [Vec<Vector3<f64>>; 4] = [
        apart.collect(),
        moved.collect(),
        acting.collect(),
        long.collect(),
    ];
    let right = longest(&groups, Vector3::zeros()).unwrap_or_else(Vector3::x);
    let up = longest(&groups, right).unwrap_or_else(|| across(scene.domain(), &right));
    aligned(right, up)
}

/// Unit vector of the longest component normal to `direction`, from the first group that has one.
fn longest(groups: &[Vec<Vector3<f64>>], direction: Vector3<f64>) -> Option<Vector3<f64>> {
    groups.iter().find_map(|group| {
        let size = group.iter().fold(0.0_f64, |m, v| m.max(v.norm()));
        let longest = group.iter().fold(Vector3::zeros(), |longest, v| {
            let v = v - direction * direction.dot(v);
            // Equal lengths up to rounding: the first one counts.
            match v.norm() > (1.0 + 1e-9) * longest.norm() {
                true => v,
                false => longest,
            }
        });
        (longest.norm() > 1e-6 * size).then(|| longest.normalize())
    })
}

/// A direction normal to `right`: that of a wall, or in a plane of two coordinate axes.
fn across(domain: &Domain, right: &Vector3<f64>) -> Vector3<f64> {
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let is_normal = |e: &Vector3<f64>| e.dot(right).abs() < 1e-6;
    if matches!(domain, Domain::Wall) && is_normal(&z) {
        return z;
    }
    match [z, y, x].into_iter().find(is_normal) {
        Some(normal) => normal.cross(right).normalize(),
        None => (y - right * right.y).normalize(),
    }
}

/// The directions of a plane, with signs for display.
///
/// Coordinate axes if the plane contains two of them; otherwise directions whose largest component
/// is positive.
fn aligned(right: Vector3<f64>, up: Vector3<f64>) -> [Vector3<f64>; 2] {
    let normal = right.cross(&up);
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let flat: Vec<Vector3<f64>> = (axes.into_iter())
        .filter(|e| e.dot(&normal).abs() < 1e-6)
        .collect();
    if let [first, second] = flat[..] {
        return [first, second];
    }
    let positive = |e: Vector3<f64>| e * e[e.iamax()].signum();
    [positive(right), positive(up)]
}

/// The bounds of all bodies along a unit vector.
fn extent(bodies: &[Body], poses: &[Isometry3<f64>], e: &Vector3<f64>) -> (f64, f64) {
    let bounds = bodies.iter().zip(poses).map(|(body, pose)| {
        let x = (pose * Point3::origin()).coords.dot(e);
        let support = |n: &Vector3<f64>| body.shape.support_distance(&pose.rotation, n);
        (x - support(&-e), x + support(e))
    });
    bounds.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (a, b)| {
        (low.min(a), high.max(b))
    })
}

/// The bounds of the domain along a unit vector; infinite where they are not known.
fn domain_extent(domain: &Domain, e: &Vector3<f64>) -> (f64, f64) {
    let free = (f64::NEG_INFINITY, f64::INFINITY);
    match domain {
        Domain::Ball { radius } => (-radius, *radius),
        Domain::Box { size } => {
            let half = 0.5 * size.component_mul(&e.abs()).sum();
            (-half, half)
        }
        Domain::Cylinder { radius } if e.x.abs() < 1e-9 => (-radius, *radius),
        Domain::Wall if e.z > 1.0 - 1e-9 => (0.0, f64::INFINITY),
        Domain::Wall if e.z < 1e-9 - 1.0 => (f64::NEG_INFINITY, 0.0),
        Domain::Surface(shape) => {
            let radius = shape.bounding_radius();
            (-radius, radius)
        }
        Domain::Cylinder { .. }
        | Domain::Wall
        | Domain::Unbounded
        | Domain::Periodic { .. }
        | Domain::Mesh { .. } => free,
    }
}
