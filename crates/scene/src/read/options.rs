//! Checks of the options: bounds that are narrower than the kind of their keys.
//!
//! Options that a program sets pass the same checks as those of a file.

use super::checks::Checks;
use crate::error::SceneError;
use crate::options::{FemOptions, ModelOptions};
use crate::scene::Scene;

/// Stands for file and line of an option that a program sets.
const ORIGIN: &str = "option set by a program";

impl Scene {
    /// The scene with other options of the model.
    ///
    /// # Errors
    /// [`SceneError::BadValue`], as for a file.
    pub fn with_model(&self, model: ModelOptions) -> Result<Self, SceneError> {
        let mut scene = self.clone();
        scene
            .document
            .replace("model", &self.model, &model, ORIGIN)?;
        check_model(&Checks(&scene.document), &model)?;
        scene.model = model;
        Ok(scene)
    }

    /// The scene with other options of the finite-element model.
    ///
    /// # Errors
    /// [`SceneError::BadValue`], as for a file.
    pub fn with_fem(&self, fem: FemOptions) -> Result<Self, SceneError> {
        let mut scene = self.clone();
        scene.document.replace("fem", &self.fem, &fem, ORIGIN)?;
        check_fem(&Checks(&scene.document), &fem)?;
        scene.fem = fem;
        Ok(scene)
    }

    /// The scene with another `model.tolerance`.
    ///
    /// # Errors
    /// As [`Scene::with_model`].
    pub fn with_tolerance(&self, tolerance: f64) -> Result<Self, SceneError> {
        self.with_model(ModelOptions {
            tolerance,
            ..self.model
        })
    }

    /// The scene with another `fem.size_factor`, or without one.
    ///
    /// # Errors
    /// As [`Scene::with_fem`].
    pub fn with_size_factor(&self, size_factor: Option<f64>) -> Result<Self, SceneError> {
        self.with_fem(FemOptions {
            size_factor,
            ..self.fem
        })
    }
}

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
