//! Surfaces of triangles that deform by the motion of their vertices: between frames, or by a
//! program.

use std::collections::{BTreeMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use mesh::Surface;
use mesher::{CurvedTriangles, Placed, TriangulatedSurface};
use nalgebra::{Isometry3, UnitQuaternion, Vector3};

use crate::frames::Frames;
use crate::material_motion::{MaterialMotion, MaterialPoint, ShapeCoordinate};

/// Where the motion of vertices comes from.
#[derive(Clone, Debug)]
pub(crate) enum MotionSource {
    /// Frames of a scene file.
    Frames(Arc<Frames>),
    /// A program.
    Own(Arc<dyn MaterialMotion>),
}

/// Whether the frames are the same, or the motion is the same object.
impl PartialEq for MotionSource {
    fn eq(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Frames(own), Self::Frames(other)) => own == other,
            (Self::Own(own), Self::Own(other)) => Arc::ptr_eq(own, other),
            _ => false,
        }
    }
}

/// A surface of triangles whose vertices move.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct TriangleDeformation {
    /// The undeformed surface about the position of the body, in its own axes.
    pub surface: TriangulatedSurface,
    /// Rotation of the own axes into the initial configuration.
    pub orientation: UnitQuaternion<f64>,
    /// Joints whose values are the amplitudes.
    pub joints: Vec<usize>,
    /// The coordinates.
    pub coordinates: Vec<ShapeCoordinate>,
    pub(crate) source: MotionSource,
    points: Arc<[MaterialPoint]>,
    recent: Arc<Recent>,
}

impl PartialEq for TriangleDeformation {
    fn eq(&self, other: &Self) -> bool {
        (&self.surface, self.orientation, &self.joints, &self.source)
            == (
                &other.surface,
                other.orientation,
                &other.joints,
                &other.source,
            )
    }
}

/// What was found at amplitudes, by their bits; the same is found again without it.
#[derive(Debug, Default)]
struct Recent {
    shapes: Mutex<VecDeque<(Vec<u64>, Arc<TriangleShape>)>>,
    problems: Mutex<BTreeMap<Vec<u64>, Option<String>>>,
}

/// Share of its volume to which no surface shrinks before the volume is kept: the bound of a radius
/// is then at most a thousand times the radius, and of use after a halving of the path.
const LEAST_VOLUME: f64 = 1e-9;

/// Number of shapes that are remembered: more than a step in time has stages.
const SHAPES: usize = 16;

/// Number of amplitudes whose problems are remembered: more than the check of a gait has.
const PROBLEMS: usize = 1 << 14;

/// A surface of triangles at some amplitudes.
#[derive(Debug)]
pub struct TriangleShape {
    /// The triangles; the same as those of the surface, without its search.
    triangles: CurvedTriangles,
    radius: f64,
    /// Factor by which a kept volume enlarged the shape; one without.
    factor: f64,
    /// The whole surface, once it is needed; what is wrong with it otherwise.
    surface: OnceLock<Result<TriangulatedSurface, String>>,
    vertices: Vec<Vector3<f64>>,
    /// For each coordinate, the triangles with displaced vertices.
    moved: OnceLock<Vec<Moved>>,
}

/// Triangles with vertices displaced along their velocities for a rate of one of a coordinate.
#[derive(Debug)]
struct Moved {
    /// With weights: the derivative of a quantity of the triangles is their weighted sum.
    triangles: [(CurvedTriangles, f64); 4],
    /// Derivative of the volume, which is needed at all points of the surface.
    volume_rate: f64,
}

/// Displacements of vertices along their velocities, over the radius by the largest speed, by which
/// velocities of other points of the triangles are differences of fourth order: truncation and
/// rounding are both about 1e-12.
pub(crate) const STEP: f64 = 1e-3;

/// The displacements of the differences in steps, with their weights.
pub(crate) const STEPS: [(f64, f64); 4] = [
    (1.0, 8.0 / 12.0),
    (-1.0, -8.0 / 12.0),
    (2.0, -1.0 / 12.0),
    (-2.0, 1.0 / 12.0),
];

impl TriangleDeformation {
    pub(crate) fn new(
        surface: TriangulatedSurface,
        orientation: UnitQuaternion<f64>,
        source: MotionSource,
        first_joint: usize,
    ) -> Self {
        let vertices = surface.vertices();
        let point = |(vertex, position)| MaterialPoint { vertex, position };
        let mut own = Self {
            orientation,
            points: vertices.into_iter().enumerate().map(point).collect(),
            surface,
            joints: Vec::new(),
            coordinates: Vec::new(),
            source,
            recent: Arc::default(),
        };
        own.coordinates = own.motion().coordinates();
        own.joints = (0..own.coordinates.len())
            .map(|k| first_joint + k)
            .collect();
        own
    }

    /// The motion of the vertices.
    pub fn motion(&self) -> &dyn MaterialMotion {
        match &self.source {
            MotionSource::Frames(frames) => &**frames,
            MotionSource::Own(own) => &**own,
        }
    }

    /// The amplitudes; not a number for joints that do not exist.
    fn amplitudes(&self, values: &[f64]) -> Vec<f64> {
        let value = |joint: &usize| values.get(*joint).copied().unwrap_or(f64::NAN);
        self.joints.iter().map(value).collect()
    }

    /// The shape at these values of all joints.
    pub(crate) fn shape(&self, values: &[f64]) -> Arc<TriangleShape> {
        let amplitudes = self.amplitudes(values);
        let bits = bits(&amplitudes);
        let found =
            |(of, shape): &(Vec<u64>, Arc<TriangleShape>)| (*of == bits).then(|| shape.clone());
        if let Some(found) = lock(&self.recent.shapes).iter().find_map(found) {
            return found;
        }
        // Another thread may find the same numbers meanwhile.
        let mut vertices = self.positions(&amplitudes);
        let (triangles, factor) = self.triangles(vertices.clone());
        vertices.iter_mut().for_each(|x| *x *= factor);
        let shape = Arc::new(TriangleShape {
            radius: triangles.radius(),
            factor,
            triangles,
            surface: OnceLock::new(),
            vertices,
            moved: OnceLock::new(),
        });
        let mut shapes = lock(&self.recent.shapes);
        shapes.truncate(SHAPES - 1);
        shapes.push_front((bits, shape.clone()));
        shape
    }

    /// Positions of the vertices, before volumes are kept.
    pub(crate) fn positions(&self, amplitudes: &[f64]) -> Vec<Vector3<f64>> {
        let position = |point: &MaterialPoint| self.motion().position(point, amplitudes);
        self.points.iter().map(position).collect()
    }

    /// Velocities of the vertices for a rate of one of a coordinate, before volumes are kept.
    pub(crate) fn velocities(&self, amplitudes: &[f64], coordinate: usize) -> Vec<Vector3<f64>> {
        let velocity =
            |point: &MaterialPoint| self.motion().velocity(point, amplitudes, coordinate);
        self.points.iter().map(velocity).collect()
    }

    /// The triangles through vertices, and the factor by which the kept volume enlarges them.
    fn triangles(&self, vertices: Vec<Vector3<f64>>) -> (CurvedTriangles, f64) {
        let triangles = self.surface.curved_through(vertices);
        if self.changes_volume() {
            return (triangles, 1.0);
        }
        let factor = (self.surface.volume() / triangles.volume()).cbrt();
        (triangles.scaled(factor), factor)
    }

    /// For each coordinate, the triangles with vertices displaced along their velocities.
    fn moved<'s>(&self, shape: &'s TriangleShape, values: &[f64]) -> &'s [Moved] {
        shape.moved.get_or_init(|| {
            let amplitudes = self.amplitudes(values);
            let vertices = self.positions(&amplitudes);
            let of_coordinate = |coordinate: usize| {
                let speed = self.motion().largest_speed(coordinate);
                let step = match speed > 0.0 {
                    true => STEP * shape.radius / speed,
                    false => STEP,
                };
                let velocities = self.velocities(&amplitudes, coordinate);
                let triangles = STEPS.map(|(steps, weight)| {
                    let ends = vertices.iter().zip(&velocities);
                    let ends = ends.map(|(x, v)| x + steps * step * v);
                    (self.triangles(ends.collect()).0, weight / step)
                });
                let volumes = triangles.iter().map(|(of, weight)| weight * of.volume());
                Moved {
                    volume_rate: volumes.sum(),
                    triangles,
                }
            };
            (0..self.joints.len()).map(of_coordinate).collect()
        })
    }

    /// Number of the coordinate that is this joint.
    fn coordinate(&self, joint: usize) -> Option<usize> {
        self.joints.iter().position(|own| *own == joint)
    }

    pub(crate) fn bounding_radius(&self, values: &[f64]) -> f64 {
        self.shape(values).radius
    }

    /// Derivative of the volume with respect to the value of a joint.
    pub(crate) fn volume_rate(&self, values: &[f64], joint: usize) -> f64 {
        let Some(coordinate) = self.coordinate(joint).filter(|_| self.changes_volume()) else {
            return 0.0;
        };
        let shape = self.shape(values);
        self.moved(&shape, values)[coordinate].volume_rate
    }

    /// Whether the volume may change.
    pub(crate) fn changes_volume(&self) -> bool {
        !self.motion().keeps_volume()
    }

    /// Upper bound of the distance of points from the position of the body where joints differ from
    /// these values by at most the changes.
    ///
    /// Points move by at most `d`, twice the path of the vertices: those of curved triangles turn
    /// with the normals, which move by about the difference of the vertices beside them. A kept
    /// volume `V` enlarges what it has become, at least `V - d A`. The area `A` is at most the sum
    /// of `(|l x m| + 2 d (|l| + |m|) + 4 d²) / 2` over triangles with the edges `l` and `m`, which
    /// change by at most `2 d`.
    pub(crate) fn largest_radius(&self, values: &[f64], changes: &dyn Fn(usize) -> f64) -> f64 {
        let paths = self.joints.iter().enumerate();
        let paths = paths.map(|(own, joint)| self.motion().largest_speed(own) * changes(*joint));
        let shape = self.shape(values);
        // Lengths before the volume was kept are enlarged like the shape.
        let moved = 2.0 * shape.factor * paths.sum::<f64>();
        if self.changes_volume() || moved == 0.0 {
            return shape.radius + moved;
        }
        let of_triangle = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| shape.vertices[corner as usize]);
            let (l, m) = (b - a, c - a);
            let longer = 2.0 * moved;
            0.5 * (l.cross(&m).norm() + longer * (l.norm() + m.norm()) + longer * longer)
        };
        let area: f64 = self.surface.triangles().iter().map(of_triangle).sum();
        let volume = self.surface.volume();
        let least = (volume - moved * area).max(LEAST_VOLUME * volume);
        (volume / least).cbrt() * (shape.radius + moved)
    }

    /// Whether no edge folds at values that differ by at most the changes from these, at which
    /// normals on both sides of an edge differ by at most 150 degrees, and the motion has all of
    /// these values.
    ///
    /// Vertices that move by `d` change edges by at most `2 d`, and so the product `b h` of the
    /// longest edge and the height on it by at most `2 d (b + l) + 4 d²` with another edge
    /// `l <= b`. The normal turns by at most `asin(4 d / h + 4 d² / (b h))`. With
    /// `2 h <= 3^(1/2) b` that is below 15 degrees for `d <= h / 17`: its sine is at most 0.248.
    /// Parts that are no neighbours enter each other by `2 d` at most.
    pub(crate) fn keeps_sides_within(
        &self,
        values: &[f64],
        changes: &dyn Fn(usize) -> f64,
    ) -> bool {
        let amplitudes = self.amplitudes(values);
        let is_possible = self.joints.iter().enumerate().all(|(own, joint)| {
            [-1.0, 1.0].into_iter().all(|sign| {
                let mut amplitudes = amplitudes.clone();
                amplitudes[own] += sign * changes(*joint);
                self.motion().problem(&amplitudes).is_none()
            })
        });
        if !is_possible {
            return false;
        }
        let paths = self.joints.iter().enumerate();
        let paths = paths.map(|(own, joint)| self.motion().largest_speed(own) * changes(*joint));
        let shape = self.shape(values);
        let moved = shape.factor * paths.sum::<f64>();
        let height = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| shape.vertices[corner as usize]);
            let longest = [b - a, c - b, a - c].map(|edge| edge.norm());
            (b - a).cross(&(c - a)).norm() / longest.into_iter().fold(0.0, f64::max)
        };
        self.surface
            .triangles()
            .iter()
            .all(|of| moved <= height(of) / 17.0)
    }

    pub(crate) fn problem(&self, values: &[f64]) -> Option<String> {
        let amplitudes = self.amplitudes(values);
        if let Some(coordinate) = amplitudes.iter().position(|x| !x.is_finite()) {
            let name = &self.coordinates[coordinate].name;
            return Some(format!(
                "has a value of '{name}' that is not a finite number"
            ));
        }
        if let Some(problem) = self.motion().problem(&amplitudes) {
            return Some(problem);
        }
        let key = bits(&amplitudes);
        if let Some(found) = lock(&self.recent.problems).get(&key) {
            return found.clone();
        }
        let vertices = self.shape(values).vertices.clone();
        let checked = self.surface.check_moved("surface", vertices);
        let problem = checked.err().map(|error| {
            format!("is no body: {error}; use frames that differ less, or smaller amplitudes")
        });
        let mut problems = lock(&self.recent.problems);
        if problems.len() >= PROBLEMS {
            problems.clear();
        }
        problems.insert(key, problem.clone());
        problem
    }

    /// The surface at these values of the joints, at a pose relative to the initial configuration.
    pub(crate) fn surface(
        &self,
        values: &[f64],
        pose: &Isometry3<f64>,
        unit: f64,
    ) -> Option<Box<dyn Surface>> {
        let surface = self.own_surface(&self.shape(values)).ok()?;
        Some(Box::new(Placed {
            shape: surface.scaled(unit),
            pose: pose * self.orientation,
        }))
    }

    fn own_surface(&self, shape: &TriangleShape) -> Result<TriangulatedSurface, String> {
        let surface = || {
            let vertices = shape.vertices.clone();
            let surface = self.surface.with_vertices("surface", vertices);
            surface.map_err(|error| error.to_string())
        };
        shape.surface.get_or_init(surface).clone()
    }

    /// The triangle with the material point near `x`, and its barycentric coordinates there.
    fn locate(&self, shape: &TriangleShape, x: &Vector3<f64>) -> Option<(usize, [f64; 3])> {
        let own = self.orientation.inverse_transform_vector(x);
        Some(self.own_surface(shape).ok()?.locate(own))
    }

    /// Velocity of the material point near `x` for a rate of one of a joint; not a number where the
    /// surface is not that of a body.
    pub(crate) fn velocity(
        &self,
        shape: &TriangleShape,
        values: &[f64],
        x: &Vector3<f64>,
        joint: usize,
    ) -> Vector3<f64> {
        let Some(coordinate) = self.coordinate(joint) else {
            return Vector3::zeros();
        };
        let Some((triangle, at)) = self.locate(shape, x) else {
            return Vector3::repeat(f64::NAN);
        };
        let moved = &self.moved(shape, values)[coordinate].triangles;
        let terms = moved
            .iter()
            .map(|(of, weight)| *weight * of.at(triangle, at));
        self.orientation * terms.sum::<Vector3<f64>>()
    }

    /// Displacement of the material point near `x` from one shape to another.
    pub(crate) fn displacement(
        &self,
        [from, to]: [&TriangleShape; 2],
        x: &Vector3<f64>,
    ) -> Vector3<f64> {
        let Some((triangle, at)) = self.locate(from, x) else {
            return Vector3::repeat(f64::NAN);
        };
        let [start, end] = [from, to].map(|shape| shape.triangles.at(triangle, at));
        self.orientation * (end - start)
    }
}

impl PartialEq for TriangleShape {
    fn eq(&self, other: &Self) -> bool {
        self.vertices == other.vertices
    }
}

fn bits(amplitudes: &[f64]) -> Vec<u64> {
    amplitudes.iter().map(|x| x.to_bits()).collect()
}

/// What a lock protects, which a panic elsewhere leaves whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use mesh::SurfaceMesh;
    use mesher::TriangleKind;

    use super::*;

    /// A body that becomes thinner in one direction, `1 - q`, and keeps its volume.
    #[derive(Debug)]
    struct Flattened;

    impl MaterialMotion for Flattened {
        fn coordinates(&self) -> Vec<ShapeCoordinate> {
            vec![ShapeCoordinate {
                name: "q".to_owned(),
                start: 0.0,
                period: None,
            }]
        }

        fn position(&self, point: &MaterialPoint, amplitudes: &[f64]) -> Vector3<f64> {
            point.position - amplitudes[0] * point.position.z * Vector3::z()
        }

        fn velocity(&self, point: &MaterialPoint, _: &[f64], _: usize) -> Vector3<f64> {
            -point.position.z * Vector3::z()
        }

        fn largest_speed(&self, _: usize) -> f64 {
            1.0
        }

        fn keeps_volume(&self) -> bool {
            true
        }
    }

    fn octahedron() -> TriangleDeformation {
        let unit = |k: usize| Vector3::from_fn(|row, _| f64::from(u8::from(row == k)));
        let points = (0..3).flat_map(|k| [unit(k), -unit(k)]).collect();
        let triangles = (0..8).map(|octant: u32| {
            let corners = [0, 1, 2].map(|axis| 2 * axis + (octant >> axis & 1));
            match octant.count_ones() % 2 {
                0 => corners,
                _ => [corners[0], corners[2], corners[1]],
            }
        });
        let mesh = SurfaceMesh {
            points,
            triangles: triangles.collect(),
            ..SurfaceMesh::default()
        };
        let surface = TriangulatedSurface::new("a", mesh, TriangleKind::Faceted).unwrap();
        let motion = MotionSource::Own(Arc::new(Flattened));
        TriangleDeformation::new(surface, UnitQuaternion::identity(), motion, 0)
    }

    /// The radius at `q` is `(1 - q)^(-1/3)` and grows without a bound: near the end it grows by
    /// more than the area and the volume of the undeformed surface tell.
    #[test]
    fn bug_the_radius_of_a_kept_volume_grows_by_more_than_its_bound() {
        let body = octahedron();
        for q in [0.0, 0.5, 0.9, 0.99] {
            let radius = body.bounding_radius(&[q]);
            assert!((radius * (1.0_f64 - q).cbrt() - 1.0).abs() < 1e-12);
            for change in [0.3, 1e-2, 1e-4, 1e-8] {
                let bound = body.largest_radius(&[q], &|_| change);
                if q + change < 1.0 {
                    assert!(bound >= body.bounding_radius(&[q + change]) - 1e-14);
                }
                assert!(bound >= body.bounding_radius(&[q - change]) - 1e-14);
            }
            // With the path it comes to the radius.
            let bound = body.largest_radius(&[q], &|_| 1e-8);
            assert!(bound - radius < 1e-4 * radius, "{q}: {bound} {radius}");
        }
    }
}
