//! Checks of the options: bounds that are narrower than the kind of their keys.

use rigid::Joint;

use crate::checks::{Checks, check_prescribed, check_value};
use crate::error::SceneError;
use crate::keys::{
    FemOptions, JointValues, LearnOptions, ModelOptions, OptimiseOptions, OutputOptions,
};
use crate::nearest::Names;

/// Largest number of terms: more need more memory than a search can use.
const MAX_TERMS: u32 = 128;

/// Largest number of samples: their poses and loads are kept, 200 bytes a body, and written to
/// checkpoints.
const MAX_SAMPLES: u32 = 100_000;

/// Refuses values of joints that do not fit the joints, and numbers outside their bounds.
pub(super) fn check_design(
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
    if optimise.terms > MAX_TERMS {
        let problem = format!("must be at most {MAX_TERMS}, not {}", optimise.terms);
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
            let names = Names::new("link", joints.iter().map(|joint| &joint.name[..]));
            for (name, value) in values {
                let joint = names.find(name)?;
                check_prescribed(&joints[joint])?;
                found[joint] = Some(*value);
            }
            Ok(found)
        }
    }
}

/// Refuses a tolerance outside its bounds.
pub(super) fn check_model(checks: &Checks, model: &ModelOptions) -> Result<(), SceneError> {
    match model.tolerance_factor {
        // Smaller factors ask for less than rounding; larger ones miss the tolerance.
        Some(factor) if !(1e-6..=1.0).contains(&factor) => {
            let problem = format!("must be between 1e-6 and 1, not {factor}");
            return Err(checks.bad_value("model.tolerance_factor", problem));
        }
        _ => {}
    }
    check_below_one(checks, "model.tolerance", model.tolerance, 1e-12)
}

/// Refuses tolerances and size factors outside their bounds.
pub(super) fn check_fem(checks: &Checks, fem: &FemOptions) -> Result<(), SceneError> {
    // Below 1e-14 the residual itself is dominated by rounding.
    check_below_one(checks, "fem.rtol", fem.rtol, 1e-14)?;
    if let Some(target) = fem.target {
        // A smaller error needs meshes that exceed any memory.
        check_below_one(checks, "fem.target", target, 1e-7)?;
    }
    match fem.size_factor {
        // Outside these bounds no sphere can be meshed, or the mesh exceeds any memory.
        Some(factor) if !(1e-3..=10.0).contains(&factor) => Err(checks.bad_value(
            "fem.size_factor",
            format!("must be between 1e-3 and 10, not {factor}"),
        )),
        _ => Ok(()),
    }
}

/// Refuses more samples than a run can keep.
pub(super) fn check_output(checks: &Checks, output: &OutputOptions) -> Result<(), SceneError> {
    match output.samples {
        Some(count) if count > MAX_SAMPLES => {
            let problem = format!("must be at most {MAX_SAMPLES}, not {count}");
            Err(checks.bad_value("output.samples", problem))
        }
        _ => Ok(()),
    }
}

fn check_below_one(checks: &Checks, key: &str, value: f64, minimum: f64) -> Result<(), SceneError> {
    if (minimum..1.0).contains(&value) {
        return Ok(());
    }
    let problem = format!("must be below 1 and at least {minimum:e}, not {value}");
    Err(checks.bad_value(key, problem))
}
