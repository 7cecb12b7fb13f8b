//! The kind of a joint and what drives it.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use rigid::{JointDrive, JointKind, PassiveDrive};

use crate::body::Body;
use crate::checks::Checks;
use crate::error::SceneError;
use crate::keys::{ForceFile, JointFile};
use crate::shape_path::JointForce;
use crate::shape_path::Sine;
use crate::words::{DriveKind, JointWord};

/// The relative motion that a joint between two bodies allows.
///
/// Hinges and balls turn about the centre of the body `to` unless a pivot is given, rotors and
/// screws about an axis through the centre of `body`, from `to` to `body` unless one is given.
pub(super) fn kind(
    checks: &Checks,
    number: usize,
    file: &JointFile,
    [body, to]: [&Body; 2],
) -> Result<JointKind, SceneError> {
    let key = |key: &str| format!("links[{number}].{key}");
    let kind = file.joint;
    let given = [
        ("axis", file.axis.is_some(), has_axis(kind)),
        (
            "pivot",
            file.pivot.is_some(),
            has_axis(kind) || kind == JointWord::Ball,
        ),
        ("pitch", file.pitch.is_some(), kind == JointWord::Screw),
    ];
    for (name, is_given, belongs) in given {
        if is_given && !belongs {
            let problem = format!("is no part of the joint \"{}\"; remove it", kind.word());
            return Err(checks.bad_value(&key(name), problem));
        }
    }
    let pivot = |default: Vector3<f64>| file.pivot.map_or(default, Vector3::from);
    let axis = |default: Option<Vector3<f64>>| -> Result<Vector3<f64>, SceneError> {
        let given = file.axis.map(Vector3::from);
        let axis = checks.required(&key("axis"), given.or(default), ": the axis of rotation")?;
        axis.try_normalize(0.0)
            .ok_or_else(|| checks.bad_value(&key("axis"), "has no direction; it must not be zero"))
    };
    let turn = |axis, pivot, advance| JointKind::Turn {
        axis,
        pivot,
        advance,
    };
    let line = (body.position - to.position)
        .try_normalize(0.0)
        .filter(|line| line.iter().all(|x| x.is_finite()));
    Ok(match kind {
        JointWord::Slide => JointKind::Slide,
        JointWord::Fixed => JointKind::Fixed,
        JointWord::Hinge => turn(axis(None)?, pivot(to.position), 0.0),
        JointWord::Rotor => turn(axis(line)?, pivot(body.position), 0.0),
        JointWord::Screw => {
            let pitch = checks.required(
                &key("pitch"),
                file.pitch,
                ": the translation along the axis per turn",
            )?;
            turn(axis(line)?, pivot(body.position), pitch / TAU)
        }
        JointWord::Ball => JointKind::Ball {
            pivot: pivot(to.position),
        },
    })
}

fn has_axis(kind: JointWord) -> bool {
    matches!(kind, JointWord::Hinge | JointWord::Rotor | JointWord::Screw)
}

/// What drives a joint whose value is `start` at the start.
pub(super) fn drive(
    checks: &Checks,
    number: usize,
    file: &JointFile,
    start: f64,
) -> Result<JointDrive, SceneError> {
    let key = |key: &str| format!("links[{number}].{key}");
    let kind = match (file.joint, file.drive) {
        (JointWord::Ball, None | Some(DriveKind::Free)) => DriveKind::Free,
        (JointWord::Fixed, None) => DriveKind::Prescribed,
        (JointWord::Ball | JointWord::Fixed, Some(other)) => {
            let problem = format!(
                "cannot be \"{}\": a joint \"{}\" has no value; remove the key",
                other.word(),
                file.joint.word()
            );
            return Err(checks.bad_value(&key("drive"), problem));
        }
        (_, kind) => kind.unwrap_or_default(),
    };
    let is_passive = kind != DriveKind::Prescribed && file.joint != JointWord::Ball;
    let given = [
        (
            "stiffness",
            file.stiffness.is_some(),
            kind == DriveKind::Spring,
        ),
        ("rest", file.rest.is_some(), kind == DriveKind::Spring),
        ("force", file.force.is_some(), kind == DriveKind::Force),
        ("damping", file.damping.is_some(), is_passive),
    ];
    for (name, is_given, belongs) in given {
        if is_given && !belongs {
            let problem = format!("is no part of the drive \"{}\"; remove it", kind.word());
            return Err(checks.bad_value(&key(name), problem));
        }
    }
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
