//! Arrangement of the bodies, and the symmetry planes and axes that models can use.

use nalgebra::Vector3;
use rigid::Joint;

use crate::body::Body;
use crate::deformation::Deformation;
use crate::domain::Domain;
use crate::loads::{DrivingLoad, VectorOscillation};
use crate::scene::Scene;
use crate::words::{GeometryKind, MeshMotionKind, SolverKind, SymmetryKind};

/// Arrangement of the bodies, their loads and the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrangement {
    /// Bodies on one line that is an axis of the domain, with loads and axes of rotation along it:
    /// the flow is axisymmetric.
    Axisymmetric,
    /// Bodies on one line about which the domain or the loads are not symmetric.
    Collinear,
    /// Bodies in one plane.
    Planar,
    /// All other arrangements.
    Spatial,
}

/// The line through the first body and the body farthest from it.
struct Line {
    /// Difference of each body's position and that of the first body.
    arms: Vec<Vector3<f64>>,
    /// Direction of the line, a unit vector.
    axis: Vector3<f64>,
    /// Distances up to this length count as zero.
    tolerance: f64,
    /// Whether all bodies are on the line.
    is_straight: bool,
}

impl Scene {
    /// Arrangement of the bodies in the initial configuration.
    ///
    /// The joints preserve it, unless walls or loads rotate the bodies out of it.
    pub fn arrangement(&self) -> Arrangement {
        let line = self.line();
        if line.is_straight {
            return match self.is_axis(&line) {
                true => Arrangement::Axisymmetric,
                false => Arrangement::Collinear,
            };
        }
        let normals = line.arms.iter().map(|arm| line.axis.cross(arm));
        let normal = normals
            .max_by(|a, b| a.norm().total_cmp(&b.norm()))
            .unwrap_or_default()
            .normalize();
        match line
            .arms
            .iter()
            .all(|arm| arm.dot(&normal).abs() <= line.tolerance)
        {
            true => Arrangement::Planar,
            false => Arrangement::Spatial,
        }
    }

    /// Direction of the axis of symmetry, which runs through the bodies, for
    /// [`Arrangement::Axisymmetric`].
    pub fn axis(&self) -> Option<Vector3<f64>> {
        let line = self.line();
        (line.is_straight && self.is_axis(&line)).then_some(line.axis)
    }

    /// Symmetry planes of the whole run, among the coordinate planes normal to x, y and z.
    ///
    /// All centres, forces and given velocities lie in such a plane, torques and given angular
    /// velocities are normal to it, and the domain, the shapes, the slip of the bodies and the
    /// background flow are symmetric about it. No body can then leave
    /// the plane.
    pub fn symmetry_planes(&self) -> [bool; 3] {
        let domain = match self.domain {
            Domain::Unbounded
            | Domain::Ball { .. }
            | Domain::Box { .. }
            | Domain::Periodic { .. } => [true; 3],
            // The wall is the plane z = 0.
            Domain::Wall => [true, true, false],
            Domain::Cylinder { .. } | Domain::Surface(_) | Domain::Mesh { .. } => [false; 3],
        };
        let holds_for_bodies = |axis: usize| {
            self.bodies.iter().all(|body| {
                let is_in_plane = |v: &Vector3<f64>| v[axis] == 0.0;
                let is_normal =
                    |v: &Vector3<f64>| (0..3).all(|other| other == axis || v[other] == 0.0);
                let twist = body.largest_held_twist();
                let in_field = body.moment == Vector3::zeros()
                    || (is_in_plane(&body.moment)
                        && self.field.is_none_or(|field| is_in_plane(&field.largest())));
                body.position[axis] == 0.0
                    && is_in_plane(&body.total_force())
                    && is_in_plane(&largest(body.driving_force))
                    && is_normal(&body.torque)
                    && is_normal(&largest(body.driving_torque))
                    && in_field
                    && is_in_plane(&twist.linear)
                    && is_normal(&twist.angular)
                    && has_symmetric_shape(body, axis)
                    && body.slip.is_none_or(|slip| slip.is_symmetric(axis))
            })
        };
        let joints = self.articulation.joints();
        let background = self.background.as_ref();
        [0, 1, 2].map(|axis| {
            domain[axis]
                && background.is_none_or(|flow| flow.is_symmetric(axis))
                && holds_for_bodies(axis)
                && joints.iter().all(|joint| joint.kind.keeps_plane(axis))
        })
    }

    /// The planes of [`Scene::symmetry_planes`] that the finite-element model uses.
    ///
    /// None if `fem.symmetry` is off or the other options do not support symmetry planes: sparse
    /// factorisations and additive Schwarz do not, elastic mesh motion does not keep nodes on the
    /// planes, the geometry error of flat facets is known for whole surfaces only, and inertia
    /// needs the resistance to all motions.
    pub fn fem_symmetry_planes(&self) -> [bool; 3] {
        let is_supported = matches!(self.fem.solver, SolverKind::Block | SolverKind::Minres)
            && self.fem.mesh_motion != MeshMotionKind::Elastic
            && self.fem.geometry == GeometryKind::Curved
            && !self.has_masses();
        if self.fem.symmetry == SymmetryKind::Auto && is_supported {
            match self.symmetry_planes() {
                // One body at the origin: a motion is left free for a load along x.
                [true, true, true] => [false, true, true],
                planes => planes,
            }
        } else {
            [false; 3]
        }
    }

    /// The line through the first body and the body farthest from it.
    fn line(&self) -> Line {
        let origin = self.bodies[0].position;
        let arms: Vec<Vector3<f64>> = self
            .bodies
            .iter()
            .map(|body| body.position - origin)
            .collect();
        let longest = arms
            .iter()
            .copied()
            .max_by(|a, b| a.norm().total_cmp(&b.norm()))
            .unwrap_or_default();
        // Positions are written with a few digits: larger deviations are intended.
        let tolerance = 1e-9 * longest.norm();
        let axis = longest
            .try_normalize(0.0)
            .unwrap_or_else(|| self.single_body_axis());
        Line {
            is_straight: arms.iter().all(|arm| arm.cross(&axis).norm() <= tolerance),
            arms,
            axis,
            tolerance,
        }
    }

    /// Whether shapes, loads, slip, background and domain are symmetric about a line on which the
    /// bodies are.
    fn is_axis(&self, line: &Line) -> bool {
        if self.turning_off(line).is_some() {
            return false;
        }
        let (origin, axis, tolerance) = (self.bodies[0].position, line.axis, line.tolerance);
        let is_along = |v: &Vector3<f64>| v.cross(&axis).norm() <= 1e-9 * v.norm();
        let vector_along = |given: Option<VectorOscillation>| {
            given.is_none_or(|v| is_along(&v.mean) && is_along(&v.amplitude))
        };
        let drive_along = |drive: Option<DrivingLoad>| vector_along(drive.map(|d| d.vector));
        let loads_along = self.bodies.iter().all(|body| {
            is_along(&body.total_force())
                && is_along(&body.torque)
                && drive_along(body.driving_force)
                && drive_along(body.driving_torque)
                && body.moment == Vector3::zeros()
                && vector_along(body.velocity)
                && vector_along(body.angular_velocity)
        });
        let shapes_along = self.bodies.iter().all(|body| match body.shape.axis() {
            Some(own) => is_along(&own),
            None => body.shape.is_isotropic(),
        });
        let slip_along = (self.bodies.iter())
            .filter_map(|body| body.slip)
            .all(|slip| is_along(&slip.axis));
        let deformation_along = (self.bodies.iter())
            .filter_map(|body| body.deformation.as_ref())
            .all(|of| of.is_axisymmetric() && of.axis().is_none_or(|axis| is_along(&axis)));
        let background = self.background.as_ref();
        loads_along
            && shapes_along
            && slip_along
            && deformation_along
            && background.is_none_or(|flow| flow.is_axisymmetric(&origin, &axis))
            && match self.domain {
                Domain::Unbounded => true,
                Domain::Ball { .. } => {
                    origin.cross(&axis).norm() <= tolerance.max(1e-9 * origin.norm())
                }
                Domain::Cylinder { .. } => {
                    axis.yz().norm() <= 1e-9 && origin.yz().norm() <= tolerance
                }
                Domain::Wall => axis.xy().norm() <= 1e-9,
                Domain::Box { .. }
                | Domain::Surface(_)
                | Domain::Mesh { .. }
                | Domain::Periodic { .. } => false,
            }
    }

    /// The first joint that can turn bodies away from a line: a ball, or an axis that is another
    /// line.
    fn turning_off(&self, line: &Line) -> Option<&Joint> {
        let origin = self.bodies[0].position;
        let mut joints = self.articulation.joints().iter();
        joints.find(|joint| !joint.kind.keeps_line(&origin, &line.axis, line.tolerance))
    }

    /// The arrangement in words, with the joint that keeps bodies on one line from having an axis
    /// of symmetry.
    pub fn describe_arrangement(&self) -> String {
        let line = self.line();
        match (self.arrangement(), self.turning_off(&line)) {
            (Arrangement::Collinear, Some(joint)) => format!(
                "bodies on one line, from which the joint '{}' can turn them: no axis of symmetry",
                joint.name
            ),
            (arrangement, _) => arrangement.describe().to_owned(),
        }
    }

    /// Axis of a scene with one body: its axis of revolution, or else the direction of its load, or
    /// else the line through the centre of the domain.
    fn single_body_axis(&self) -> Vector3<f64> {
        let body = &self.bodies[0];
        let own = body.shape.axis().unwrap_or_default();
        let slip = body.slip.map(|slip| slip.axis).unwrap_or_default();
        let twist = body.largest_held_twist();
        let candidates = [
            own,
            slip,
            deformation_axis(body).unwrap_or_default(),
            body.total_force(),
            body.torque,
            largest(body.driving_force),
            largest(body.driving_torque),
            twist.linear,
            twist.angular,
            body.position,
        ];
        candidates
            .iter()
            .find_map(|v| v.try_normalize(0.0))
            .unwrap_or_else(Vector3::x)
    }
}

/// Whether the plane through the position of a body normal to a coordinate axis is a symmetry plane
/// of its shape, whatever the rotation about that axis and the deformation.
fn has_symmetric_shape(body: &Body, axis: usize) -> bool {
    let is_normal = |n: Vector3<f64>| (0..3).all(|other| other == axis || n[other] == 0.0);
    match &body.deformation {
        Some(Deformation::Undulation(tube)) => tube.plane_normal().is_some_and(is_normal),
        // A spheroid that deforms has the axis of its modes.
        Some(Deformation::Sphere(sphere)) => sphere
            .modes
            .as_ref()
            .is_none_or(|modes| modes.keeps_plane(axis)),
        Some(Deformation::Triangles(_)) | None => body.shape.is_isotropic(),
    }
}

/// Axis of the modes of a body; none without them.
fn deformation_axis(body: &Body) -> Option<Vector3<f64>> {
    body.deformation.as_ref()?.axis()
}

/// Largest size of each component of a load; zero without one.
fn largest(load: Option<DrivingLoad>) -> Vector3<f64> {
    load.map_or_else(Vector3::zeros, |load| load.vector.largest())
}

impl Arrangement {
    /// The arrangement in words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Axisymmetric => {
                "bodies on one line that is an axis of the domain: the flow is axisymmetric"
            }
            Self::Collinear => {
                "bodies on one line, about which shapes, loads or the domain are not symmetric"
            }
            Self::Planar => "bodies in one plane",
            Self::Spatial => "bodies in space: no symmetry found",
        }
    }
}
