//! The joints of a scene file, and the articulation of its bodies and joints.

use std::collections::{HashMap, HashSet};

use rigid::{
    Articulation, Freedom, Joint, JointDrive, JointKind, PassiveDrive, Reduction, RigidError,
};

use crate::body::{Body, with_held_velocities};
use crate::checks::{Checks, check_angle};
use crate::error::SceneError;
use crate::gait::{Gait, spans};
use crate::joints::{JointKeys, JointWord};
use crate::keys::{ForceFile, JointFile};
use crate::loads::VectorOscillation;
use crate::nearest::Names;
use crate::shape_path::{JointForce, Sine};
use crate::words::{ArmsKind, DriveKind};

/// All joints, with unique names, each between two bodies that no other joint joins.
pub(super) fn joints(
    checks: &Checks,
    files: &[JointFile],
    bodies: &[Body],
) -> Result<Vec<Joint>, SceneError> {
    let mut joints: Vec<Joint> = Vec::with_capacity(files.len());
    let known = Names::new("body", bodies.iter().map(|body| &body.name[..]));
    let mut names: HashMap<String, usize> = HashMap::new();
    let mut joined: HashSet<(bool, [usize; 2])> = HashSet::new();
    for (number, file) in files.iter().enumerate() {
        let key = |key: &str| format!("links[{number}].{key}");
        let name = checks.required(&key("name"), file.name.clone(), ": name every link")?;
        if let Some(first) = names.insert(name.clone(), number) {
            let problem =
                format!("\"{name}\" is the name of links[{first}] too; names must differ");
            return Err(checks.bad_value(&key("name"), problem));
        }
        let end = |which: &str, name: &Option<String>| {
            let key = key(which);
            let name = checks.required(&key, name.as_deref(), ": a link joins two bodies")?;
            checks.find(&key, name, &known)
        };
        let (body, to) = (end("body", &file.body)?, end("to", &file.to)?);
        if body == to {
            let problem = format!(
                "links body '{}' to itself; link it to another",
                bodies[to].name
            );
            return Err(checks.bad_value(&key("to"), problem));
        }
        let exchanges = file.joint == JointWord::Exchange;
        if !joined.insert((exchanges, [body.min(to), body.max(to)])) {
            let problem = format!(
                "links '{}' and '{}' a second time; remove one",
                bodies[body].name, bodies[to].name
            );
            return Err(checks.bad_value(&format!("links[{number}]"), problem));
        }
        let keys = JointKeys {
            word: file.joint,
            axis: file.axis,
            pivot: file.pivot,
            pitch: file.pitch,
        };
        let kind = (keys.kind(bodies[body].position, bodies[to].position))
            .map_err(|(name, problem)| checks.bad_value(&key(name), problem))?;
        let start = match kind.freedom() {
            Freedom::Distance => (bodies[body].position - bodies[to].position).norm(),
            Freedom::Angle | Freedom::Rotation | Freedom::Nothing | Freedom::Amplitude => 0.0,
        };
        let drive = drive(checks, number, file, (kind, start))?;
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
/// turn start from their angles, amplitudes of deformations from theirs.
pub(super) fn articulation(
    checks: &Checks,
    bodies: &mut [Body],
    joints: Vec<Joint>,
    arms: ArmsKind,
    start: &[(usize, f64)],
) -> Result<Articulation, SceneError> {
    for (number, joint) in joints.iter().enumerate() {
        let is_slide = joint.kind.freedom() == Freedom::Distance;
        if is_slide && bodies[joint.body].position == bodies[joint.to].position {
            let problem = format!(
                "has no direction: '{}' and '{}' are at the same place; move one",
                bodies[joint.body].name, bodies[joint.to].name
            );
            return Err(checks.bad_value(&format!("links[{number}]"), problem));
        }
    }
    let mut is_linked = vec![false; bodies.len()];
    for joint in joints.iter().filter(|joint| !joint.kind.is_deformation()) {
        is_linked[joint.body] = true;
        is_linked[joint.to] = true;
    }
    for (number, body) in bodies.iter().enumerate() {
        if !body.shape.has_surface() && !is_linked[number] {
            let problem = "is a point that no link holds, so nothing determines its velocity; \
                           link it or remove it";
            return Err(checks.bad_value(&format!("bodies[{number}]"), problem));
        }
    }
    let held = |velocity: fn(&Body) -> Option<VectorOscillation>| -> Vec<usize> {
        (0..bodies.len())
            .filter(|&body| velocity(&bodies[body]).is_some())
            .collect()
    };
    let translations = held(Body::held_velocity);
    let rotations = held(Body::held_angular_velocity);
    let kinds: Vec<_> = bodies.iter().map(Body::kind).collect();
    let join = |joints: Vec<Joint>, bodies: &[Body]| {
        let positions: Vec<_> = bodies.iter().map(|body| body.position).collect();
        Articulation::new(&kinds, joints, arms.into(), &positions)?
            .with_held(&translations, &rotations)
    };
    let set = join(joints, bodies).map_err(|error| checks.bad_value("links", error.to_string()))?;
    let mut lengths = set.initial_shape().to_vec();
    let mut angles = lengths.clone();
    for &(joint, value) in start {
        let kind = &set.joints()[joint].kind;
        // A length that the positions give is not changed by their rounding.
        if kind.is_deformation() {
            (lengths[joint], angles[joint]) = (value, value);
        } else if kind.is_angle() {
            angles[joint] = value;
        } else if (value - lengths[joint]).abs() > SAME_LENGTH * lengths[joint] {
            (lengths[joint], angles[joint]) = (value, value);
        }
    }
    let bad = |error: RigidError| checks.bad_value("gait", error.to_string());
    let moves = |joint: usize| !set.joints()[joint].kind.is_deformation();
    let are_moved = (0..lengths.len())
        .any(|joint| moves(joint) && lengths[joint] != set.initial_shape()[joint]);
    let set = match !are_moved {
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

/// Refuses given velocities of bodies that their links and the gait contradict.
pub(super) fn check_held(
    checks: &Checks,
    bodies: &[Body],
    set: &Articulation,
    gait: &Gait,
) -> Result<(), SceneError> {
    let Some(held) = set.held_bodies().last() else {
        return Ok(());
    };
    let shape = set.initial_shape();
    let at_rest = (shape.to_vec(), vec![0.0; shape.len()]);
    let phases = spans(gait, shape)?.take(gait.phases.len());
    let moments = phases.map(|span| (span.shape(0.5), span.rates(0.5)));
    let moments: Vec<_> = std::iter::once(at_rest).chain(moments).collect();
    // What oscillates contradicts at nearly all times, if it contradicts at all.
    let periods = bodies.iter().flat_map(|body| {
        let given = [body.velocity, body.angular_velocity];
        (given.into_iter().flatten()).filter_map(|v| v.oscillates().then_some(v.period))
    });
    let times: Vec<f64> = std::iter::once(0.0)
        .chain(periods.flat_map(|period| [0.19 * period, 0.37 * period]))
        .collect();
    let at = |time| moments.iter().map(move |moment| (time, moment));
    for (time, (shape, rates)) in times.into_iter().flat_map(at) {
        let Ok(constraints) = set.constraints(&set.initial_state(), shape, rates) else {
            // A loop that does not close is refused elsewhere.
            continue;
        };
        let constraints = with_held_velocities(constraints, set, bodies, time)
            .map_err(|error| checks.bad_value("bodies", error.to_string()))?;
        if let Err(error) = Reduction::new(set, &constraints) {
            let body = &bodies[held];
            let key = match (body.fixed, body.velocity) {
                (true, _) => "fixed",
                (false, Some(_)) => "velocity",
                (false, None) => "angular_velocity",
            };
            let problem = format!("contradicts the links and the other given velocities: {error}");
            return Err(checks.bad_value(&format!("bodies[{held}].{key}"), problem));
        }
    }
    Ok(())
}

/// Relative difference up to which a length at the start of a gait is that of the positions, which
/// are written with about as many digits.
const SAME_LENGTH: f64 = 1e-9;

/// What drives a joint of this kind whose value is `start` at the start.
fn drive(
    checks: &Checks,
    number: usize,
    file: &JointFile,
    (joint, start): (JointKind, f64),
) -> Result<JointDrive, SceneError> {
    let key = |key: &str| format!("links[{number}].{key}");
    let kind = match (joint.freedom(), file.drive) {
        (Freedom::Distance | Freedom::Angle, kind) => kind.unwrap_or_default(),
        (Freedom::Rotation, None | Some(DriveKind::Free)) => DriveKind::Free,
        (Freedom::Nothing, None) | (Freedom::Amplitude, None | Some(DriveKind::Prescribed)) => {
            DriveKind::Prescribed
        }
        (Freedom::Rotation | Freedom::Nothing | Freedom::Amplitude, Some(other)) => {
            let why = match joint.freedom() {
                Freedom::Amplitude => "is prescribed",
                _ => "has no value",
            };
            let problem = format!(
                "cannot be \"{}\": a joint \"{}\" {why}; remove the key",
                other.word(),
                file.joint.word()
            );
            return Err(checks.bad_value(&key("drive"), problem));
        }
    };
    let is_passive = kind != DriveKind::Prescribed && joint.has_value();
    let (is_spring, is_force) = (kind == DriveKind::Spring, kind == DriveKind::Force);
    checks.refuse_strangers(
        &format!("links[{number}]"),
        [
            ("stiffness", file.stiffness.is_some(), is_spring),
            ("rest", file.rest.is_some(), is_spring),
            ("force", file.force.is_some(), is_force),
            ("damping", file.damping.is_some(), is_passive),
        ],
        &format!("is no part of the drive \"{}\"; remove it", kind.word()),
    )?;
    let mut passive = PassiveDrive {
        damping: file.damping.unwrap_or(0.0),
        ..PassiveDrive::default()
    };
    match kind {
        DriveKind::Prescribed => return Ok(JointDrive::Prescribed),
        DriveKind::Free => {}
        DriveKind::Spring => {
            passive.stiffness = checks.required(
                &key("stiffness"),
                file.stiffness,
                ": force per change of the value",
            )?;
            passive.rest = file.rest.unwrap_or(start);
        }
        DriveKind::Force => {
            let force = checks.required(
                &key("force"),
                file.force,
                ": the force on the joint, a torque for joints that turn",
            )?;
            passive.force = match force {
                ForceFile::Constant(force) => force,
                ForceFile::Harmonic(harmonic) => harmonic.mean,
            };
        }
    }
    Ok(JointDrive::Passive(passive))
}

/// The oscillating parts of the forces on joints; their period is that of the gait unless given.
pub(super) fn oscillating(
    checks: &Checks,
    files: &[JointFile],
    gait_period: Option<f64>,
) -> Result<Vec<JointForce>, SceneError> {
    let mut forces = Vec::new();
    for (joint, file) in files.iter().enumerate() {
        let Some(ForceFile::Harmonic(harmonic)) = file.force else {
            continue;
        };
        let key = format!("links[{joint}].force");
        let missing = |name: &str| checks.bad_value(&key, format!("has no {name}"));
        check_angle(checks, &key, harmonic.phase)?;
        let amplitude = harmonic.amplitude.ok_or_else(|| missing("amplitude"))?;
        let period = harmonic.period.or(gait_period);
        forces.push(JointForce {
            sine: Sine {
                joint,
                amplitude,
                phase: harmonic.phase,
                order: harmonic.order,
            },
            period: period.ok_or_else(|| missing("period, and the gait has none either"))?,
        });
    }
    Ok(forces)
}
