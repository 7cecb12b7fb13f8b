//! Checks of the options: bounds that are narrower than the kind of their keys.

use super::checks::Checks;
use crate::error::SceneError;
use crate::options::{FemOptions, ModelOptions};

/// Refuses a tolerance outside its bounds.
pub(super) fn check_model(checks: &Checks, model: &ModelOptions) -> Result<(), SceneError> {
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

fn check_below_one(checks: &Checks, key: &str, value: f64, minimum: f64) -> Result<(), SceneError> {
    if (minimum..1.0).contains(&value) {
        return Ok(());
    }
    let problem = format!("must be below 1 and at least {minimum:e}, not {value}");
    Err(checks.bad_value(key, problem))
}
