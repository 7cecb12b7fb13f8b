//! The joints of a scene file, and the articulation of its bodies and joints.

use rigid::{Articulation, Joint, JointKind, RigidError};

use super::joint;
use crate::body::Body;
use crate::checks::Checks;
use crate::error::SceneError;
use crate::keys::JointFile;
use crate::words::ArmsKind;

/// All joints, with unique names, each between two bodies that no other joint joins.
pub(super) fn joints(
    checks: &Checks,
    files: &[JointFile],
    bodies: &[Body],
) -> Result<Vec<Joint>, SceneError> {
    let mut joints: Vec<Joint> = Vec::with_capacity(files.len());
    for (number, file) in files.iter().enumerate() {
        let key = |key: &str| format!("links[{number}].{key}");
        let name = checks.required(&key("name"), file.name.clone(), ": name every link")?;
        if let Some(first) = joints.iter().position(|joint| joint.name == name) {
            let problem =
                format!("\"{name}\" is the name of links[{first}] too; names must differ");
            return Err(checks.bad_value(&key("name"), problem));
        }
        let end = |which: &str, name: &Option<String>| {
            let key = key(which);
            let name = checks.required(&key, name.as_deref(), ": a link joins two bodies")?;
            let names = bodies.iter().map(|body| &body.name[..]);
            checks.find(&key, name, "body", names)
        };
        let (body, to) = (end("body", &file.body)?, end("to", &file.to)?);
        if body == to {
            let problem = format!(
                "links body '{}' to itself; link it to another",
                bodies[to].name
            );
            return Err(checks.bad_value(&key("to"), problem));
        }
        let joins_same = |joint: &Joint| [(body, to), (to, body)].contains(&(joint.body, joint.to));
        if joints.iter().any(joins_same) {
            let problem = format!(
                "links '{}' and '{}' a second time; remove one",
                bodies[body].name, bodies[to].name
            );
            return Err(checks.bad_value(&format!("links[{number}]"), problem));
        }
        let kind = joint::kind(checks, number, file, [&bodies[body], &bodies[to]])?;
        let start = match kind {
            JointKind::Slide => (bodies[body].position - bodies[to].position).norm(),
            _ => 0.0,
        };
        let drive = joint::drive(checks, number, file, start)?;
        joints.push(Joint {
            name,
            body,
            to,
            kind,
            drive,
        });
    }
    Ok(joints)
}

/// Bodies and joints as an articulation; joints need a direction, and points need a joint.
///
/// Joints in `start` have other values at the start than in the pose of the file: bodies of slides
/// are moved along the directions of the joints, with the pivots of their other joints; joints that
/// turn start from their angles.
pub(super) fn articulation(
    checks: &Checks,
    bodies: &mut [Body],
    joints: Vec<Joint>,
    arms: ArmsKind,
    start: &[(usize, f64)],
) -> Result<Articulation, SceneError> {
    for (number, joint) in joints.iter().enumerate() {
        let is_slide = joint.kind == JointKind::Slide;
        if is_slide && bodies[joint.body].position == bodies[joint.to].position {
            let problem = format!(
                "has no direction: '{}' and '{}' are at the same place; move one",
                bodies[joint.body].name, bodies[joint.to].name
            );
            return Err(checks.bad_value(&format!("links[{number}]"), problem));
        }
    }
    for (number, body) in bodies.iter().enumerate() {
        let joint = joints
            .iter()
            .find(|joint| joint.body == number || joint.to == number);
        if !body.shape.has_surface() && joint.is_none() {
            let problem = "is a point that no link holds, so nothing determines its velocity; \
                           link it or remove it";
            return Err(checks.bad_value(&format!("bodies[{number}]"), problem));
        }
    }
    let fixed: Vec<usize> = (0..bodies.len()).filter(|&b| bodies[b].fixed).collect();
    for &number in &fixed {
        if let Some(joint) = joints.iter().find(|l| l.body == number || l.to == number) {
            let problem = format!(
                "cannot be true: link '{}' acts on the body; an obstacle has no links",
                joint.name
            );
            return Err(checks.bad_value(&format!("bodies[{number}].fixed"), problem));
        }
    }
    let kinds: Vec<_> = bodies.iter().map(Body::kind).collect();
    let join = |joints: Vec<Joint>, bodies: &[Body]| {
        let positions: Vec<_> = bodies.iter().map(|body| body.position).collect();
        Articulation::new(&kinds, joints, arms.into(), &positions)?.with_fixed(&fixed)
    };
    let set = join(joints, bodies).map_err(|error| checks.bad_value("links", error.to_string()))?;
    let mut lengths = set.initial_shape().to_vec();
    let mut angles = lengths.clone();
    for &(joint, value) in start {
        // A length that the positions give is not changed by their rounding.
        if set.joints()[joint].kind.is_angle() {
            angles[joint] = value;
        } else if (value - lengths[joint]).abs() > SAME_LENGTH * lengths[joint] {
            (lengths[joint], angles[joint]) = (value, value);
        }
    }
    let bad = |error: RigidError| checks.bad_value("gait", error.to_string());
    let set = match lengths == set.initial_shape() {
        true => set,
        false => {
            let poses = set.place(&set.initial_state(), &lengths).map_err(bad)?;
            let mut joints = set.joints().to_vec();
            // Slides only change their lengths here, so that nothing turns.
            for joint in &mut joints {
                let shift = poses[joint.to].translation.vector - bodies[joint.to].position;
                joint.kind = joint.kind.translated(&shift);
            }
            for (body, pose) in bodies.iter_mut().zip(poses) {
                body.position = pose.translation.vector;
            }
            join(joints, bodies).map_err(bad)?
        }
    };
    set.with_initial_values(&angles).map_err(bad)
}

/// Relative difference up to which a length at the start of a gait is that of the positions, which
/// are written with about as many digits.
const SAME_LENGTH: f64 = 1e-9;
