//! What the arrangement of bodies allows a model to leave out.

use nalgebra::Vector3;

use crate::scene::{Domain, Scene};
use crate::shape::Shape;
use crate::words::{GeometryKind, MeshMotionKind, MirrorKind, SolverKind};

/// How the bodies, their loads and the domain lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Arrangement {
    /// On one line, which is an axis of the domain, with loads along it: the flow is axisymmetric.
    Axisymmetric,
    /// On one line, but the domain or the loads are not symmetric about it.
    Collinear,
    /// In one plane.
    Planar,
    /// In space.
    Spatial,
}

/// A line through bodies.
struct Line {
    /// From the first body to each.
    arms: Vec<Vector3<f64>>,
    axis: Vector3<f64>,
    /// Distances that count as none.
    off: f64,
    is_straight: bool,
}

impl Scene {
    /// How the bodies lie at the start; links keep it so, unless walls or loads turn the bodies away.
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
            .all(|arm| arm.dot(&normal).abs() <= line.off)
        {
            true => Arrangement::Planar,
            false => Arrangement::Spatial,
        }
    }

    /// The direction of the axis about which everything is symmetric, for [`Arrangement::Axisymmetric`]; it runs through the bodies.
    pub fn axis(&self) -> Option<Vector3<f64>> {
        let line = self.line();
        (line.is_straight && self.is_axis(&line)).then_some(line.axis)
    }

    /// The coordinate planes through the origin, by the axes they are normal to, that mirror everything for the whole run.
    ///
    /// All centres are on them and so is what links do; forces lie in them, torques are normal to all of them, and the domain is its own
    /// image. Nothing can then leave them.
    pub fn mirror_planes(&self) -> [bool; 3] {
        let domain = matches!(
            self.domain,
            Domain::Unbounded | Domain::Ball { .. } | Domain::Box { .. }
        );
        let of_body = |axis: usize| {
            self.bodies.iter().all(|body| {
                let turned = match body.shape {
                    Shape::Sphere { .. } | Shape::Point => false,
                    Shape::Spheroid { .. } => true,
                };
                let across = (0..3).filter(|&other| other != axis);
                body.position[axis] == 0.0
                    && body.force[axis] == 0.0
                    && across.map(|other| body.torque[other]).all(|t| t == 0.0)
                    && !turned
            })
        };
        [0, 1, 2].map(|axis| domain && of_body(axis))
    }

    /// The planes of [`Scene::mirror_planes`] that `fem.mirror` asks for and the options of `fem` can use.
    ///
    /// Factorisations do not know of them, elastic mesh motion would leave them, what flat facets cut off is known for whole surfaces only,
    /// and inertia asks for the resistance to all motions.
    pub fn fem_mirrors(&self) -> [bool; 3] {
        let is_able = matches!(self.fem.solver, SolverKind::Block | SolverKind::Minres)
            && self.fem.mesh_motion != MeshMotionKind::Elastic
            && self.fem.geometry == GeometryKind::Curved
            && self
                .bodies
                .iter()
                .all(|body| body.mass == 0.0 && body.inertia == 0.0);
        if self.fem.mirror == MirrorKind::Auto && is_able {
            match self.mirror_planes() {
                // One body at the origin: of all its motions one is left for a load to come.
                [true, true, true] => [false, true, true],
                planes => planes,
            }
        } else {
            [false; 3]
        }
    }

    /// The line through the first body and the farthest from it.
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
        // Positions are typed with a few digits: farther off than this is meant to be off.
        let off = 1e-9 * longest.norm();
        let axis = longest
            .try_normalize(0.0)
            .unwrap_or_else(|| self.lone_axis());
        Line {
            is_straight: arms.iter().all(|arm| arm.cross(&axis).norm() <= off),
            arms,
            axis,
            off,
        }
    }

    /// Whether domain and loads are symmetric about a line that the bodies are on.
    fn is_axis(&self, line: &Line) -> bool {
        let (origin, axis, off) = (self.bodies[0].position, line.axis, line.off);
        let is_along = |v: &Vector3<f64>| v.cross(&axis).norm() <= 1e-9 * v.norm();
        let loads_along = self
            .bodies
            .iter()
            .all(|body| is_along(&body.force) && is_along(&body.torque));
        let turned_along = self.bodies.iter().all(|body| match body.shape {
            Shape::Spheroid { axis: own, .. } => is_along(&own),
            Shape::Sphere { .. } | Shape::Point => true,
        });
        loads_along
            && turned_along
            && match self.domain {
                Domain::Unbounded => true,
                Domain::Ball { .. } => origin.cross(&axis).norm() <= off.max(1e-9 * origin.norm()),
                Domain::Cylinder { .. } => axis.yz().norm() <= 1e-9 && origin.yz().norm() <= off,
                Domain::Wall => axis.xy().norm() <= 1e-9,
                Domain::Box { .. } | Domain::Mesh { .. } => false,
            }
    }

    /// The axis of a single body: along its load, or else through the middle of the domain.
    fn lone_axis(&self) -> Vector3<f64> {
        let body = &self.bodies[0];
        let own = match body.shape {
            Shape::Spheroid { axis, .. } => axis,
            Shape::Sphere { .. } | Shape::Point => Vector3::zeros(),
        };
        let candidates = [own, body.force, body.torque, body.position];
        candidates
            .iter()
            .find_map(|v| v.try_normalize(0.0))
            .unwrap_or_else(Vector3::x)
    }
}

impl Arrangement {
    /// In words.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Axisymmetric => {
                "bodies on one line that is an axis of the domain: the flow is axisymmetric"
            }
            Self::Collinear => {
                "bodies on one line, in surroundings that are not symmetric about it"
            }
            Self::Planar => "bodies in one plane: one mirror plane",
            Self::Spatial => "bodies in space: no symmetry found",
        }
    }
}
