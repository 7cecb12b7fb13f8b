//! Checks of the groups `optimise` and `learn`.

use rigid::Joint;

use super::checks::Checks;
use super::gait::{check_prescribed, check_value};
use crate::design::{JointValues, LearnOptions, OptimiseOptions};
use crate::error::SceneError;
use crate::nearest::find_name;

/// Largest number of terms: more need more memory than a search can use.
const MOST_TERMS: u32 = 128;

/// Refuses values of joints that do not fit the joints, and numbers outside their bounds.
pub(super) fn check(
    checks: &Checks,
    optimise: &OptimiseOptions,
    learn: &LearnOptions,
    joints: &[Joint],
) -> Result<(), SceneError> {
    for (key, values) in [
        ("optimise.lower", &optimise.lower),
        ("optimise.upper", &optimise.upper),
        ("learn.contracted", &learn.contracted),
        ("learn.extended", &learn.extended),
    ] {
        let Some(values) = values else { continue };
        let values = by_joint(values, joints).map_err(|problem| checks.bad_value(key, problem))?;
        for (joint, value) in joints.iter().zip(values) {
            value.map_or(Ok(()), |value| check_value(checks, key, joint, value))?;
        }
    }
    if let Some(values) = &optimise.max_rate {
        let key = "optimise.max_rate";
        let values = by_joint(values, joints).map_err(|problem| checks.bad_value(key, problem))?;
        if let Some(value) = values.into_iter().flatten().find(|value| *value <= 0.0) {
            return Err(checks.bad_value(key, format!("must be greater than zero, not {value}")));
        }
    }
    if optimise.power.is_some() && (optimise.max_rate.is_some() || optimise.max_power.is_some()) {
        let problem = "cannot be given with optimise.max_rate or optimise.max_power, which \
                       determine the period; remove it";
        return Err(checks.bad_value("optimise.power", problem));
    }
    for (key, vector) in [
        ("optimise.direction", optimise.direction),
        ("optimise.axis", Some(optimise.axis)),
        ("learn.direction", Some(learn.direction)),
    ] {
        if vector == Some([0.0; 3]) {
            return Err(checks.bad_value(key, "must not be zero"));
        }
    }
    if optimise.terms > MOST_TERMS {
        let problem = format!("must be at most {MOST_TERMS}, not {}", optimise.terms);
        return Err(checks.bad_value("optimise.terms", problem));
    }
    for (key, value) in [
        ("optimise.tolerance", optimise.tolerance),
        ("learn.discount", learn.discount),
    ] {
        if value >= 1.0 {
            return Err(checks.bad_value(key, format!("must be below 1, not {value}")));
        }
    }
    for (key, value) in [
        ("learn.rate", learn.rate),
        ("learn.exploration", learn.exploration),
    ] {
        if value > 1.0 {
            return Err(checks.bad_value(key, format!("must be at most 1, not {value}")));
        }
    }
    Ok(())
}

/// The value for each joint; none where no value is given.
///
/// # Errors
/// What is wrong with the values.
pub(crate) fn by_joint(values: &JointValues, joints: &[Joint]) -> Result<Vec<Option<f64>>, String> {
    match values {
        JointValues::All(value) => Ok((joints.iter())
            .map(|joint| check_prescribed(joint).is_ok().then_some(*value))
            .collect()),
        JointValues::List(list) if list.len() == joints.len() => {
            Ok(list.iter().copied().map(Some).collect())
        }
        JointValues::List(list) => Err(format!(
            "has {} values, and the scene has {} links",
            list.len(),
            joints.len()
        )),
        JointValues::Named(values) => {
            let mut found = vec![None; joints.len()];
            for (name, value) in values {
                let names = joints.iter().map(|joint| &joint.name[..]);
                let joint = find_name(name, "link", names)?;
                check_prescribed(&joints[joint])?;
                found[joint] = Some(*value);
            }
            Ok(found)
        }
    }
}
