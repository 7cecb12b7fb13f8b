//! Checks that the numbers of a scene can be computed with: their sizes relative to the bodies.

use nalgebra::Vector3;
use rigid::{Joint, JointDrive};

use crate::body::Body;
use crate::checks::Checks;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::flow::Background;
use crate::gait::Gait;
use crate::gait_table::GaitTable;
use crate::joints::JointKeys;
use crate::keys::SceneFile;
use crate::loads::{DrivingLoad, VectorOscillation};
use crate::shape_path::{JointForce, ShapePath};

/// Largest length of a scene over the smallest length of a body.
///
/// Positions are rounded to 1.1e-16 of their size. At this distance that is 1e-7 of the smallest
/// body: less than the error of the finest mesh, and less than a thousandth of the smallest gap
/// that a mesh resolves, 1e-3 radii. Far beyond this ratio symmetry planes, points inside bodies
/// and gaps are lost in rounding.
const LARGEST_RATIO: f64 = 1e9;

/// Largest distance of linked bodies over the smallest length of a body.
///
/// A constraint turns forces into torques with the arm `d`, so that the matrix that determines the
/// loads of the links has a condition number of the order of `d^2`, which reaches `1 / 2.2e-16`
/// near this distance: there they are lost in rounding, and chains are taken for loops that stay
/// open.
const LARGEST_LINK: f64 = 1e8;

/// A scene as it is known before its bodies are placed.
pub(super) struct Unplaced<'a> {
    pub checks: &'a Checks<'a>,
    pub file: &'a SceneFile,
    pub viscosity: f64,
    pub domain: &'a Domain,
    pub background: Option<&'a Background>,
    pub bodies: &'a [Body],
    pub gait: &'a Gait,
    pub gait_table: Option<&'a GaitTable>,
    pub joints: &'a [Joint],
    pub joint_forces: &'a [JointForce],
    pub field: Option<&'a VectorOscillation>,
}

impl Unplaced<'_> {
    /// Refuses lengths that are too large for the smallest body, and loads that move bodies too
    /// far.
    pub fn check_extent(&self) -> Result<(), SceneError> {
        let bodies = self.bodies.iter();
        let all = bodies.flat_map(|body| body.shape.lengths().into_iter().map(|l| l.1));
        let smallest = all.fold(f64::INFINITY, f64::min);
        self.check_lengths(smallest)?;
        self.check_gait(smallest)?;
        for (number, joint) in self.joints.iter().enumerate() {
            self.check_link(number, smallest)?;
            for (key, length) in JointKeys::from_kind(&joint.kind).lengths() {
                self.check_length(&format!("links[{number}].{key}"), length, smallest)?;
            }
        }
        self.check_surface_size(smallest)?;
        self.check_drives(smallest)?;
        self.check_loads(smallest)?;
        self.check_flows(smallest)
    }

    fn check_length(&self, key: &str, length: f64, smallest: f64) -> Result<(), SceneError> {
        if length <= LARGEST_RATIO * smallest {
            return Ok(());
        }
        let problem = format!(
            "is too large: at {:.1e} times the smallest radius of the bodies ({smallest:e}) \
             rounding errors reach the size of the gaps between bodies; the limit is \
             {LARGEST_RATIO:e} times",
            length / smallest
        );
        Err(self.checks.bad_value(key, problem))
    }

    /// Refuses bodies that are too far from the bodies that they are linked to.
    fn check_link(&self, number: usize, smallest: f64) -> Result<(), SceneError> {
        let joint = &self.joints[number];
        let [body, to] = [joint.body, joint.to].map(|body| &self.bodies[body]);
        let distance = (body.position - to.position).norm();
        if distance <= LARGEST_LINK * smallest {
            return Ok(());
        }
        let problem = format!(
            "is too far from '{}', to which a link joins '{}': at {:.1e} times the smallest radius \
             of the bodies ({smallest:e}) the loads of the link are lost in rounding; the limit is \
             {LARGEST_LINK:e} times",
            to.name,
            body.name,
            distance / smallest
        );
        let key = format!("bodies[{}].position", joint.body);
        Err(self.checks.bad_value(&key, problem))
    }

    /// Checks the lengths of the domain and the bodies.
    fn check_lengths(&self, smallest: f64) -> Result<(), SceneError> {
        let (key, length) = match self.domain {
            Domain::Ball { radius } | Domain::Cylinder { radius } => ("domain.radius", *radius),
            Domain::Box { size } | Domain::Periodic { size } => ("domain.size", size.amax()),
            Domain::Surface(shape) => ("domain.file", shape.bounding_radius()),
            Domain::Unbounded | Domain::Wall | Domain::Mesh { .. } => ("domain", 0.0),
        };
        self.check_length(key, length, smallest)?;
        for (number, body) in self.bodies.iter().enumerate() {
            let position = [("position", body.position.amax())];
            for (key, length) in position.into_iter().chain(body.shape.lengths()) {
                self.check_length(&format!("bodies[{number}].{key}"), length, smallest)?;
            }
        }
        Ok(())
    }

    /// Checks the lengths of slides.
    fn check_gait(&self, smallest: f64) -> Result<(), SceneError> {
        let check = |key: &str, length: f64| self.check_length(key, length, smallest);
        let is_length = |joint: usize| self.joints[joint].kind.length_power() == 1;
        if let Some(table) = self.gait_table {
            check("gait.file", table.largest(self.joints))?;
        }
        for (number, phase) in self.gait.phases.iter().enumerate() {
            match &phase.path {
                ShapePath::Spline(_) | ShapePath::Own(_) => {}
                ShapePath::Linear(changes) => {
                    for (_, length) in changes.iter().filter(|(joint, _)| is_length(*joint)) {
                        check(&format!("gait.phases[{number}].length"), *length)?;
                    }
                }
                ShapePath::Harmonic { sines, .. } => {
                    let files = self.file.gait.harmonics.iter().flatten().enumerate();
                    let terms = files.filter(|(_, file)| file.turn.is_none());
                    for ((number, file), sine) in terms.zip(sines) {
                        if !is_length(sine.joint) {
                            continue;
                        }
                        let key = |name: &str| format!("gait.harmonics[{number}].{name}");
                        check(&key("amplitude"), sine.amplitude)?;
                        check(&key("mean"), file.mean.unwrap_or(0.0))?;
                    }
                }
            }
        }
        Ok(())
    }

    fn check_surface_size(&self, smallest: f64) -> Result<(), SceneError> {
        let Some(size) = self.file.fem.surface_size else {
            return Ok(());
        };
        let radii = self.bodies.iter().map(Body::bounding_radius);
        let (low, high) = (4e-4 * smallest, 4.0 * radii.fold(0.0, f64::max));
        if (low..=high).contains(&size) {
            return Ok(());
        }
        let problem = format!(
            "must be between {low:e} and {high:e}: 4e-4 times the smallest and 4 times the largest \
             radius of the bodies, not {size:e}"
        );
        Err(self.checks.bad_value("fem.surface_size", problem))
    }

    /// Refuses a motion of a body during the gait by too many radii.
    fn check_distance(&self, key: &str, radii: f64) -> Result<(), SceneError> {
        if radii <= LARGEST_RATIO {
            return Ok(());
        }
        let problem = format!(
            "is too large: it would move a body by about {radii:.1e} times the smallest radius \
             during the gait; the limit is {LARGEST_RATIO:e} times"
        );
        Err(self.checks.bad_value(key, problem))
    }

    /// Checks the loads: a body under a load moves at about load / (viscosity size).
    fn check_loads(&self, smallest: f64) -> Result<(), SceneError> {
        let unit = self.viscosity * smallest * smallest;
        let duration = self.gait.duration();
        let distance = |load: &Vector3<f64>, unit: f64| duration * load.amax() / unit;
        let largest = |drive: Option<DrivingLoad>| {
            drive.map_or_else(Vector3::zeros, |drive| drive.vector.largest())
        };
        let field = self.field.map_or(0.0, |field| field.largest().norm());
        for (number, body) in self.bodies.iter().enumerate() {
            let force = body.force.abs() + largest(body.driving_force);
            let torque = body.torque.abs() + largest(body.driving_torque);
            let twist = body.largest_held_twist();
            for (name, radii) in [
                ("force", distance(&force, unit)),
                ("density", distance(&body.weight, unit)),
                ("torque", distance(&torque, unit * smallest)),
                ("moment", distance(&(field * body.moment), unit * smallest)),
                ("velocity", distance(&twist.linear, smallest)),
                ("angular_velocity", distance(&twist.angular, 1.0)),
            ] {
                self.check_distance(&format!("bodies[{number}].{name}"), radii)?;
            }
        }
        Ok(())
    }

    /// Checks slip and background flow.
    fn check_flows(&self, smallest: f64) -> Result<(), SceneError> {
        let duration = self.gait.duration();
        let check = |key: &str, speed: f64| self.check_distance(key, duration * speed / smallest);
        for (number, body) in self.bodies.iter().enumerate() {
            if let Some(slip) = &body.slip {
                check(&format!("bodies[{number}].slip"), slip.speed())?;
            }
            if let Some(Background::PressureGradient { gradient }) = self.background {
                // The flow past one body that is held.
                let volume = self.domain.period().map_or(0.0, |size| size.product());
                let speed = gradient.norm() * volume / (self.viscosity * smallest);
                check("background", speed)?;
            } else if let Some(flow) = self.background {
                let size = flow.gradient(&body.position).norm() * body.bounding_radius();
                check("background", flow.velocity(&body.position).norm() + size)?;
            }
        }
        Ok(())
    }

    /// Refuses drives of joints that are far from the resistance of the smallest body.
    fn check_drives(&self, smallest: f64) -> Result<(), SceneError> {
        for (number, joint) in self.joints.iter().enumerate() {
            let JointDrive::Passive(drive) = &joint.drive else {
                continue;
            };
            // Resistance to a rotation, or to a translation of the joint.
            let (resistance, unit) = match joint.kind.is_angle() {
                true => (self.viscosity * smallest.powi(3), 1.0),
                false => (self.viscosity * smallest, smallest),
            };
            let oscillating = self
                .joint_forces
                .iter()
                .find(|force| force.sine.joint == number);
            let amplitude = oscillating.map_or(0.0, |force| force.sine.amplitude);
            let sizes = [
                ("rest", drive.rest / unit),
                (
                    "force",
                    (drive.force.abs() + amplitude.abs()) / (resistance * unit),
                ),
                ("stiffness", drive.stiffness / resistance),
                ("damping", drive.damping / resistance),
            ];
            for (name, size) in sizes {
                if size.is_nan() || size.abs() > LARGEST_RATIO {
                    let problem = format!(
                        "is too large: {:.1e} in the units of the smallest radius and the viscosity; \
                         the limit is {LARGEST_RATIO:e}",
                        size.abs()
                    );
                    return Err(self
                        .checks
                        .bad_value(&format!("links[{number}].{name}"), problem));
                }
            }
        }
        Ok(())
    }
}
