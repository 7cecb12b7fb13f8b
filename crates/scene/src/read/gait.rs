//! The gait of a scene file.

use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

use rigid::{Articulation, Freedom, Joint, JointKind};

use crate::checks::{Checks, check_angle, check_prescribed, check_value};
use crate::error::SceneError;
use crate::gait::{Gait, Phase};
use crate::gait_table::GaitTable;
use crate::keys::{GaitFile, HarmonicFile, PhaseFile};
use crate::nearest::Names;
use crate::shape_path::{ShapePath, Sine};
use crate::words::GaitKind;

/// The gait, with joints by number, and the table that it is from.
pub(super) fn gait(
    checks: &Checks,
    file: &GaitFile,
    joints: &[Joint],
) -> Result<(Gait, Option<GaitTable>), SceneError> {
    let GaitFile {
        phases, harmonics, ..
    } = file;
    let given = [
        (GaitKind::Phases, "phases", phases.is_some()),
        (GaitKind::Harmonic, "harmonics", harmonics.is_some()),
        (GaitKind::Table, "file", file.file.is_some()),
    ];
    let first = given.iter().find(|(.., is_given)| *is_given);
    let kind = file
        .kind
        .or(first.map(|(kind, ..)| *kind))
        .unwrap_or_default();
    for (other, key, is_given) in given {
        if is_given && other != kind {
            let problem = format!(
                "is no part of a gait of the kind {}; remove it",
                kind.word()
            );
            return Err(checks.bad_value(&format!("gait.{key}"), problem));
        }
        if file.kind == Some(other) && !is_given {
            let problem = format!("is {}, but there is no gait.{key}", kind.word());
            return Err(checks.bad_value("gait.kind", problem));
        }
    }
    let is_empty = |key: &str| {
        let problem = format!("is empty; give at least one [[{key}]] or remove the key");
        Err(checks.bad_value(key, problem))
    };
    for (owner, key, is_given) in [
        (GaitKind::Harmonic, "gait.period", file.period.is_some()),
        (
            GaitKind::Table,
            "gait.interpolation",
            file.interpolation.is_some(),
        ),
    ] {
        if is_given && owner != kind {
            let problem = format!("belongs to a gait of the kind {}", owner.word());
            return Err(checks.bad_value(key, problem));
        }
    }
    let names = Names::new("link", joints.iter().map(|joint| &joint.name[..]));
    let named = (joints, &names);
    let gait = match kind {
        GaitKind::Phases if phases.as_ref().is_some_and(Vec::is_empty) => {
            return is_empty("gait.phases");
        }
        GaitKind::Harmonic if harmonics.as_ref().is_some_and(Vec::is_empty) => {
            return is_empty("gait.harmonics");
        }
        GaitKind::Phases => {
            let files = phases.iter().flatten().enumerate();
            let phases = files.map(|(number, file)| phase(checks, number, file, named));
            Gait {
                cycles: file.cycles,
                phases: phases.collect::<Result<_, _>>()?,
            }
        }
        GaitKind::Harmonic => harmonic(checks, file, harmonics.iter().flatten(), named)?,
        GaitKind::Table => {
            let table = table(checks, file, joints)?;
            return Ok((table.gait(file.cycles), Some(table)));
        }
    };
    Ok((gait, None))
}

/// Path of the file of a table.
pub(super) fn table_path(checks: &Checks, name: &str) -> PathBuf {
    let folder = checks.0.path().parent().unwrap_or(Path::new(""));
    folder.join(name)
}

fn table(checks: &Checks, file: &GaitFile, joints: &[Joint]) -> Result<GaitTable, SceneError> {
    let key = "gait.file";
    let name = checks.required(key, file.file.as_ref(), ": a table needs a file")?;
    let path = table_path(checks, name);
    let interpolation = file.interpolation.unwrap_or_default();
    let table = GaitTable::read(&path, interpolation, joints)
        .map_err(|problem| checks.bad_value(key, problem))?;
    if file.cycles > 1 && !table.is_closed() {
        let problem = "cannot be repeated: the last row of gait.file differs from the first one";
        return Err(checks.bad_value("gait.cycles", problem));
    }
    Ok(table)
}

/// The joint of this name, whose value the gait can prescribe.
fn find(
    checks: &Checks,
    key: &str,
    name: &str,
    (joints, names): (&[Joint], &Names),
) -> Result<usize, SceneError> {
    let joint = checks.find(key, name, names)?;
    check_prescribed(&joints[joint]).map_err(|problem| checks.bad_value(key, problem))?;
    Ok(joint)
}

/// Refuses a periodic start if some passive joint has no spring, which would bring it back.
pub(super) fn check_periodic(checks: &Checks, set: &Articulation) -> Result<(), SceneError> {
    match set
        .passive_drives()
        .find(|(_, drive)| drive.stiffness == 0.0)
    {
        Some((joint, _)) => {
            let problem = format!(
                "needs springs: the link \"{}\" has none, so that its value has no periodic state",
                set.joints()[joint].name
            );
            Err(checks.bad_value("gait.periodic", problem))
        }
        None => Ok(()),
    }
}

/// Values at the start that the gait determines: of joints with means or in a table.
pub(super) fn initial_shape(
    checks: &Checks,
    file: &GaitFile,
    (gait, table): (&Gait, Option<&GaitTable>),
    joints: &[Joint],
) -> Result<Vec<(usize, f64)>, SceneError> {
    if let Some(table) = table {
        return Ok(table.initial_shape());
    }
    let harmonics = file.harmonics.iter().flatten();
    let Some(ShapePath::Harmonic { sines, .. }) = gait.phases.first().map(|phase| &phase.path)
    else {
        return Ok(Vec::new());
    };
    let mut means: Vec<(usize, f64)> = Vec::new();
    let terms = harmonics
        .enumerate()
        .filter(|(_, file)| file.turn.is_none());
    for ((number, file), sine) in terms.zip(sines) {
        let Some(mean) = file.mean else { continue };
        let key = format!("gait.harmonics[{number}].mean");
        check_value(checks, &key, &joints[sine.joint], mean)?;
        match means.iter().find(|(joint, _)| *joint == sine.joint) {
            Some((_, other)) if *other != mean => {
                let problem = format!("is {mean}, but another entry for the link has {other}");
                return Err(checks.bad_value(&key, problem));
            }
            Some(_) => {}
            None => means.push((sine.joint, mean)),
        }
    }
    let at_start = |(joint, mean): (usize, f64)| {
        let terms = sines.iter().filter(|sine| sine.joint == joint);
        (joint, mean + terms.map(|sine| sine.at(0.0)).sum::<f64>())
    };
    Ok(means.into_iter().map(at_start).collect())
}

/// What is wrong with a turn in a gait of harmonics, with its key; none if nothing is.
fn turn_problem(
    file: &HarmonicFile,
    turn: f64,
    joint: &Joint,
    is_second: bool,
) -> Option<(&'static str, &'static str)> {
    let strangers = [
        ("mean", file.mean.is_some()),
        ("amplitude", file.amplitude.is_some()),
        ("phase", file.phase != 0.0),
        ("order", file.order != 1),
    ];
    if let Some((stranger, _)) = strangers.into_iter().find(|(_, is_given)| *is_given) {
        let problem = "does not belong to a `turn`; give it in another entry for the link";
        return Some((stranger, problem));
    }
    let problem = match (joint.kind.freedom(), joint.kind) {
        _ if is_second => "is the second one of the joint",
        // Coordinates of deformations are checked with their periods.
        (Freedom::Amplitude, _) => return None,
        (Freedom::Angle, JointKind::Turn { advance: 0.0, .. }) if is_whole(turn, TAU) => {
            return None;
        }
        (Freedom::Angle, JointKind::Turn { advance: 0.0, .. }) => "must be whole turns of 2π",
        (Freedom::Angle, _) => {
            "is unsupported for screws, which advance in all turns; use amplitude"
        }
        _ => "is unsupported for distances, which cannot grow in all cycles; use amplitude",
    };
    Some(("turn", problem))
}

/// Whether a change is a whole number of periods.
pub(super) fn is_whole(change: f64, period: f64) -> bool {
    let periods = change / period;
    periods.abs() < 1e6 && (periods - periods.round()).abs() < 1e-9
}

fn harmonic<'f>(
    checks: &Checks,
    file: &GaitFile,
    harmonics: impl Iterator<Item = &'f HarmonicFile>,
    (joints, names): (&[Joint], &Names),
) -> Result<Gait, SceneError> {
    let Some(period) = file.period else {
        return Err(checks.bad_value("gait.period", "is missing: the period of gait.harmonics"));
    };
    let (mut sines, mut turns) = (Vec::new(), Vec::<(usize, f64)>::new());
    for (number, file) in harmonics.enumerate() {
        let key = |key: &str| format!("gait.harmonics[{number}].{key}");
        let missing = |name: &str| checks.bad_value(&key(name), "is missing");
        let name = file.link.as_ref().ok_or_else(|| missing("link"))?;
        let joint = find(checks, &key("link"), name, (joints, names))?;
        if let Some(turn) = file.turn {
            let is_second = turns.iter().any(|(other, _)| *other == joint);
            if let Some((word, problem)) = turn_problem(file, turn, &joints[joint], is_second) {
                return Err(checks.bad_value(&key(word), problem));
            }
            turns.push((joint, turn));
            continue;
        }
        check_angle(checks, &key("phase"), file.phase)?;
        sines.push(Sine {
            joint,
            amplitude: file.amplitude.ok_or_else(|| missing("amplitude"))?,
            phase: file.phase,
            order: file.order,
        });
    }
    Ok(Gait::harmonic_with_turns(file.cycles, sines, turns, period))
}

fn phase(
    checks: &Checks,
    number: usize,
    file: &PhaseFile,
    (joints, names): (&[Joint], &Names),
) -> Result<Phase, SceneError> {
    let key = |key: &str| format!("gait.phases[{number}].{key}");
    let missing = |name: &str, problem: &str| Err(checks.bad_value(&key(name), problem));
    let one = match (&file.link, file.length) {
        (None, None) => None,
        (None, Some(_)) => return missing("link", "is missing: say which link gets this length"),
        (Some(_), None) => return missing("length", "is missing: the link's length at the end"),
        (Some(name), Some(length)) => {
            Some((find(checks, &key("link"), name, (joints, names))?, length))
        }
    };
    let mut changes: Vec<(usize, f64)> = one.into_iter().collect();
    if let Some(targets) = &file.targets {
        if !changes.is_empty() {
            let problem = "cannot be combined with link; put all links into targets";
            return missing("targets", problem);
        }
        for (name, length) in targets {
            changes.push((
                find(checks, &key("targets"), name, (joints, names))?,
                *length,
            ));
        }
        changes.sort_by_key(|(joint, _)| *joint);
    }
    let value_key = match file.targets.is_some() {
        true => "targets",
        false => "length",
    };
    for &(joint, value) in &changes {
        check_value(checks, &key(value_key), &joints[joint], value)?;
    }
    Ok(Phase {
        path: ShapePath::Linear(changes),
        duration: file.duration,
    })
}
