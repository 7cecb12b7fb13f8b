//! Loads on the bodies of a scene file, given velocities, and the magnetic field.

use nalgebra::Vector3;

use crate::body::Body;
use crate::checks::{Checks, check_angle};
use crate::contact::Repulsion;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::keys::{BodyFile, ContactFile, DriveFile, FieldFile, LoadFile, PhaseAngles};
use crate::loads::{DrivingLoad, VectorOscillation};
use crate::words::AxesKind;

/// Enters force, torque and given velocities of a body, and refuses loads and velocities that
/// contradict each other.
///
/// Periods are that of the gait unless they are given.
pub(super) fn enter(
    checks: &Checks,
    number: usize,
    file: &BodyFile,
    gait_period: Option<f64>,
    body: &mut Body,
) -> Result<(), SceneError> {
    let read = |name: &str, load: LoadFile| match load {
        LoadFile::Constant(vector) => Ok((vector.into(), None)),
        LoadFile::Driving(file) => {
            let key = format!("bodies[{number}].{name}");
            let load = driving(checks, &key, &file, gait_period)?;
            Ok::<_, SceneError>((Vector3::zeros(), Some(load)))
        }
    };
    (body.force, body.driving_force) = read("force", file.force)?;
    (body.torque, body.driving_torque) = read("torque", file.torque.unwrap_or_default())?;
    let given = |name: &str, file: Option<LoadFile>| {
        let (constant, oscillating) = match file {
            None => return Ok(None),
            Some(file) => read(name, file)?,
        };
        match oscillating {
            None => Ok(Some(VectorOscillation::constant(constant))),
            Some(DrivingLoad {
                vector,
                axes: AxesKind::Laboratory,
            }) => Ok(Some(vector)),
            Some(_) => {
                let problem = "is given in the axes of the laboratory; remove axes";
                Err(checks.bad_value(&format!("bodies[{number}].{name}"), problem))
            }
        }
    };
    body.velocity = given("velocity", file.velocity)?;
    body.angular_velocity = given("angular_velocity", file.angular_velocity)?;
    check(body)
        .map_err(|(name, problem)| checks.bad_value(&format!("bodies[{number}].{name}"), problem))
}

/// The first key of a body that contradicts another one, with the problem.
fn check(body: &Body) -> Result<(), (&'static str, &'static str)> {
    let has_force = body.force.amax() > 0.0 || body.driving_force.is_some();
    let has_torque =
        body.torque.amax() > 0.0 || body.driving_torque.is_some() || body.moment.amax() > 0.0;
    if !body.shape.has_surface() {
        let in_body = |load: DrivingLoad| load.axes == AxesKind::Body;
        return match body {
            Body { fixed: true, .. } => Err((
                "fixed",
                "makes no sense for a point, which has no surface and is no obstacle; remove it",
            )),
            Body {
                velocity: Some(_), ..
            } => Err((
                "velocity",
                "makes no sense for a point, which has no surface; give that of a body",
            )),
            Body {
                angular_velocity: Some(_),
                ..
            } => Err(("angular_velocity", "makes no sense for a point; remove it")),
            body if body.moment.amax() > 0.0 => Err((
                "moment",
                "cannot turn a point, which does not rotate; remove it",
            )),
            body if body.driving_force.is_some_and(in_body) => Err((
                "force",
                "has axes of a point, which has none; use axes = \"laboratory\"",
            )),
            _ => Ok(()),
        };
    }
    if body.fixed && (has_force || has_torque) {
        let problem = "holds the body against any load; remove its force, torque and moment";
        return Err(("fixed", problem));
    }
    for (name, is_given, is_loaded, problem) in [
        (
            "velocity",
            body.velocity.is_some(),
            has_force,
            "is given, so that the force is a result; remove force",
        ),
        (
            "angular_velocity",
            body.angular_velocity.is_some(),
            has_torque,
            "is given, so that the torque is a result; remove torque and moment",
        ),
    ] {
        if is_given && body.fixed {
            return Err((name, "contradicts fixed = true; remove one of them"));
        }
        if is_given && is_loaded {
            return Err((name, problem));
        }
    }
    Ok(())
}

fn driving(
    checks: &Checks,
    key: &str,
    file: &DriveFile,
    gait_period: Option<f64>,
) -> Result<DrivingLoad, SceneError> {
    let phase = match file.phase {
        PhaseAngles::All(angle) => [angle; 3],
        PhaseAngles::Each(angles) => angles,
    };
    let vector = VectorOscillation {
        mean: file.mean.into(),
        amplitude: file.amplitude.into(),
        phase: phase.into(),
        order: file.order,
        period: period(checks, key, &file.amplitude, file.period.or(gait_period))?,
    };
    check_phase(checks, key, &vector)?;
    Ok(DrivingLoad {
        vector,
        axes: file.axes,
    })
}

/// The magnetic field; it needs a body with a moment, as moments need a field.
pub(super) fn field(
    checks: &Checks,
    file: Option<&FieldFile>,
    gait_period: Option<f64>,
    bodies: &[Body],
) -> Result<Option<VectorOscillation>, SceneError> {
    let with_moment = bodies.iter().position(|body| body.moment.amax() > 0.0);
    match (file, with_moment) {
        (None, None) => Ok(None),
        (None, Some(body)) => {
            let problem = "has no effect without a magnetic field; add [field], or remove it";
            Err(checks.bad_value(&format!("bodies[{body}].moment"), problem))
        }
        (Some(_), None) => {
            let problem = "acts on no body: none has a moment; give bodies[].moment, or remove it";
            Err(checks.bad_value("field", problem))
        }
        (Some(file), Some(_)) => {
            let amplitude = file.amplitude.unwrap_or_default();
            let given = file.period.or(gait_period);
            let vector = VectorOscillation {
                mean: file.mean.unwrap_or_default().into(),
                amplitude: amplitude.into(),
                phase: file.phase.unwrap_or_default().into(),
                order: file.order.unwrap_or(1),
                period: period(checks, "field", &amplitude, given)?,
            };
            check_phase(checks, "field.phase", &vector)?;
            Ok(Some(vector))
        }
    }
}

/// Largest range of a repulsion over the shortest edge of a periodic box.
const LARGEST_RANGE: f64 = 0.1;

/// The repulsion between surfaces; walls from files have no normal here.
pub(super) fn repulsion(
    checks: &Checks,
    file: Option<&ContactFile>,
    domain: &Domain,
) -> Result<Option<Repulsion>, SceneError> {
    let Some(file) = file else { return Ok(None) };
    let range = checks.required("contact.range", file.range, "")?;
    let strength = checks.required("contact.strength", file.strength, "")?;
    if matches!(domain, Domain::Surface(_) | Domain::Mesh { .. }) {
        let problem = "does not act at walls from files; use another domain, or remove it";
        return Err(checks.bad_value("contact", problem));
    }
    if let Some(size) = domain.period()
        && range > LARGEST_RANGE * size.min()
    {
        let problem = "must be at most a tenth of the shortest edge of the periodic box: all \
                       images within 37 ranges repel each other";
        return Err(checks.bad_value("contact.range", problem));
    }
    Ok(Some(Repulsion { range, strength }))
}

/// The period of an oscillation; a constant vector needs none.
fn period(
    checks: &Checks,
    key: &str,
    amplitude: &[f64; 3],
    period: Option<f64>,
) -> Result<f64, SceneError> {
    match (period, *amplitude == [0.0; 3]) {
        (Some(period), _) => Ok(period),
        (None, true) => Ok(1.0),
        (None, false) => Err(checks.bad_value(
            key,
            "has no period, and the gait has none either; give period",
        )),
    }
}

fn check_phase(checks: &Checks, key: &str, vector: &VectorOscillation) -> Result<(), SceneError> {
    (vector.phase.iter()).try_for_each(|phase| check_angle(checks, key, *phase))
}
