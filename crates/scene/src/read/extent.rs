//! Checks that the numbers of a scene can be computed with: their sizes relative to the bodies.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rigid::{Joint, JointDrive, JointKind};

use crate::body::Body;
use crate::checks::Checks;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::flow::Background;
use crate::gait::Gait;
use crate::gait_table::GaitTable;
use crate::keys::FemOptions;
use crate::keys::GaitFile;
use crate::shape_path::JointForce;
use crate::shape_path::ShapePath;

/// Largest length of a scene over the smallest length of a body.
///
/// Positions are rounded to 1.1e-16 of their size. At this distance that is 1e-7 of the smallest
/// body: less than the error of the finest mesh, and less than a thousandth of the smallest gap
/// that a mesh resolves, 1e-3 radii. Far beyond this ratio symmetry planes, points inside bodies
/// and gaps are lost in rounding.
const LARGEST_RATIO: f64 = 1e9;

/// Refuses lengths that are too large for the smallest body, and loads that move bodies too far.
pub(super) fn check(
    checks: &Checks,
    viscosity: f64,
    (domain, background): (&Domain, Option<&Background>),
    bodies: &[Body],
    (gait, gait_file, gait_table): (&Gait, &GaitFile, Option<&GaitTable>),
    (joints, joint_forces): (&[Joint], &[JointForce]),
    fem: &FemOptions,
) -> Result<(), SceneError> {
    let all = (bodies.iter()).flat_map(|body| body.shape.lengths().into_iter().map(|l| l.1));
    let smallest = all.fold(f64::INFINITY, f64::min);
    let demand = |key: String, length: f64| {
        if length <= LARGEST_RATIO * smallest {
            return Ok(());
        }
        let problem = format!(
            "is too large: at {:.1e} times the smallest radius of the bodies ({smallest:e}) \
             rounding errors reach the size of the gaps between bodies; the limit is \
             {LARGEST_RATIO:e} times",
            length / smallest
        );
        Err(checks.bad_value(&key, problem))
    };
    match domain {
        Domain::Ball { radius } | Domain::Cylinder { radius } => {
            demand("domain.radius".to_owned(), *radius)?;
        }
        Domain::Box { size } => demand("domain.size".to_owned(), size.amax())?,
        Domain::Surface(shape) => demand("domain.file".to_owned(), shape.bounding_radius())?,
        Domain::Unbounded | Domain::Wall | Domain::Mesh { .. } => {}
    }
    for (number, body) in bodies.iter().enumerate() {
        let key = |key: &str| format!("bodies[{number}].{key}");
        demand(key("position"), body.position.amax())?;
        for (name, length) in body.shape.lengths() {
            demand(key(name), length)?;
        }
    }
    let is_length = |joint: usize| !joints[joint].kind.is_angle();
    if let Some(table) = gait_table {
        demand("gait.file".to_owned(), table.largest(joints))?;
    }
    for (number, phase) in gait.phases.iter().enumerate() {
        match &phase.path {
            ShapePath::Cubic(_) | ShapePath::Own(_) => {}
            ShapePath::Linear(changes) => {
                let of_slides = changes.iter().filter(|(joint, _)| is_length(*joint));
                for (_, length) in of_slides {
                    demand(format!("gait.phases[{number}].length"), *length)?;
                }
            }
            ShapePath::Harmonic { sines, .. } => {
                let numbered = sines.iter().zip(gait_file.harmonics.iter().flatten());
                for (number, (sine, file)) in numbered.enumerate() {
                    if is_length(sine.joint) {
                        let key = |name: &str| format!("gait.harmonics[{number}].{name}");
                        demand(key("amplitude"), sine.amplitude)?;
                        demand(key("mean"), file.mean.unwrap_or(0.0))?;
                    }
                }
            }
        }
    }
    for (number, joint) in joints.iter().enumerate() {
        let key = |key: &str| format!("links[{number}].{key}");
        match joint.kind {
            JointKind::Slide | JointKind::Fixed => {}
            JointKind::Ball { pivot } => demand(key("pivot"), pivot.amax())?,
            JointKind::Turn { pivot, advance, .. } => {
                demand(key("pivot"), pivot.amax())?;
                demand(key("pitch"), TAU * advance.abs())?;
            }
        }
    }
    if let Some(size) = fem.surface_size {
        let radii = bodies.iter().map(Body::bounding_radius);
        let (low, high) = (4e-4 * smallest, 4.0 * radii.fold(0.0, f64::max));
        if !(low..=high).contains(&size) {
            let problem = format!(
                "must be between {low:e} and {high:e}: 4e-4 times the smallest and 4 times the \
                 largest radius of the bodies, not {size:e}"
            );
            return Err(checks.bad_value("fem.surface_size", problem));
        }
    }
    check_drives(checks, (joints, joint_forces), viscosity, smallest)?;
    // A body under a load moves at about load / (viscosity size).
    for (number, body) in bodies.iter().enumerate() {
        let unit = viscosity * smallest * smallest;
        let distance = |load: &Vector3<f64>, unit: f64| gait.duration() * load.amax() / unit;
        let loads = [
            ("force", distance(&body.force, unit)),
            ("density", distance(&body.weight, unit)),
            ("torque", distance(&body.torque, unit * smallest)),
        ];
        for (name, radii) in loads {
            if radii.is_nan() || radii > LARGEST_RATIO {
                let problem = format!(
                    "is too large: it would move a body by about {radii:.1e} times the smallest \
                     radius during the gait; the limit is {LARGEST_RATIO:e} times"
                );
                return Err(checks.bad_value(&format!("bodies[{number}].{name}"), problem));
            }
        }
    }
    check_flows(checks, background, bodies, gait.duration(), smallest)
}

/// Refuses slip and background flows that move bodies too far.
fn check_flows(
    checks: &Checks,
    background: Option<&Background>,
    bodies: &[Body],
    duration: f64,
    smallest: f64,
) -> Result<(), SceneError> {
    let demand = |key: &str, speed: f64| {
        let radii = duration * speed / smallest;
        if radii <= LARGEST_RATIO {
            return Ok(());
        }
        let problem = format!(
            "is too large: it would move a body by about {radii:.1e} times the smallest radius \
             during the gait; the limit is {LARGEST_RATIO:e} times"
        );
        Err(checks.bad_value(key, problem))
    };
    for (number, body) in bodies.iter().enumerate() {
        if let Some(slip) = &body.slip {
            demand(&format!("bodies[{number}].slip"), slip.speed())?;
        }
        if let Some(flow) = background {
            let size = flow.gradient(&body.position).norm() * body.bounding_radius();
            demand("background", flow.velocity(&body.position).norm() + size)?;
        }
    }
    Ok(())
}

/// Refuses drives of joints that are far from the resistance of the smallest body.
fn check_drives(
    checks: &Checks,
    (joints, joint_forces): (&[Joint], &[JointForce]),
    viscosity: f64,
    smallest: f64,
) -> Result<(), SceneError> {
    for (number, joint) in joints.iter().enumerate() {
        let JointDrive::Passive(drive) = &joint.drive else {
            continue;
        };
        // Resistance to a rotation, or to a translation of the joint.
        let (resistance, unit) = match joint.kind.is_angle() {
            true => (viscosity * smallest.powi(3), 1.0),
            false => (viscosity * smallest, smallest),
        };
        let oscillating = joint_forces.iter().find(|force| force.sine.joint == number);
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
                return Err(checks.bad_value(&format!("links[{number}].{name}"), problem));
            }
        }
    }
    Ok(())
}
