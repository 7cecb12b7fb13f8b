//! Scene files of the project.

use std::path::Path;

use anyhow::{Context, Result};
use swimmer::Scene;

/// Scene from the project's folder `scenes`; `overrides` have the form `key=value`.
pub fn read(name: &str, overrides: &[String]) -> Result<Scene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    Scene::read(&folder.join(name), overrides).with_context(|| format!("scene {name}"))
}

/// `overrides`, and the one that gives unit rate to the first phase of the three-sphere scenes.
///
/// The first phase changes a length by 4, so that the rate is one if it takes a time of 4.
pub fn with_unit_rate(overrides: &[String]) -> Vec<String> {
    let mut all = overrides.to_vec();
    all.push("gait.phases.0.duration=4".to_owned());
    all
}
