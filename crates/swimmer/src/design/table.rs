//! The table of connection and metric over the limits of a scene, stored on disk.

use std::io::Write as _;
use std::path::Path;

use models::{ModelError, ShapeGeometry, ShapeSpace};
use scene::Scene;
use serde::{Deserialize, Serialize};

use super::limits::StrokeLimits;
use super::progress::DesignProgress;
use crate::error::SwimError;
use crate::output::Folder;
use crate::planning::{Choice, choose};

/// Name of the file of a table.
const FILE: &str = "table.json";

/// A table with what it was computed from.
#[derive(Deserialize, Serialize)]
struct Stored {
    /// The scene as TOML.
    scene: String,
    ranges: Vec<(f64, f64)>,
    tolerance: f64,
    model: String,
    table: ShapeGeometry,
}

/// A table, and where it is from.
#[derive(Clone, Debug)]
pub struct StrokeTable {
    /// Connection and metric.
    pub geometry: ShapeGeometry,
    /// Name of the model.
    pub model: String,
    /// Whether it was read from the folder.
    pub is_stored: bool,
}

/// Tabulates connection and metric over the limits, or reads them from the folder of an earlier run
/// of the same flow problem.
///
/// # Errors
/// A scene whose motion depends on more than the shape, errors of the model, files that cannot be
/// written, [`SwimError::Stopped`].
pub fn tabulate(
    scene: &Scene,
    limits: &StrokeLimits,
    tolerance: f64,
    folder: Option<&Folder>,
    progress: &mut dyn DesignProgress,
) -> Result<StrokeTable, SwimError> {
    if let Some(stored) = folder.and_then(|folder| stored(folder.path(), scene, limits, tolerance))
    {
        return Ok(StrokeTable {
            geometry: stored.table,
            model: stored.model,
            is_stored: true,
        });
    }
    let Choice { mut model, .. } = choose(scene)?;
    let mut done = 0;
    let mut observe = |points: usize| {
        done = points;
        progress.tabulated(points);
        match progress.is_interrupted() {
            // Replaced below by an error of this crate.
            true => Err(ModelError::ShapeSpace {
                problem: "interrupted".to_owned(),
            }),
            false => Ok(()),
        }
    };
    let space = ShapeSpace::tabulate_observed(
        scene,
        model.as_mut(),
        &limits.ranges,
        tolerance,
        &mut observe,
    );
    if progress.is_interrupted() {
        return Err(SwimError::Stopped {
            what: format!("{done} shapes of the table"),
        });
    }
    let stored = Stored {
        scene: scene.to_toml()?,
        ranges: limits.ranges.clone(),
        tolerance,
        model: model.name().to_owned(),
        table: space?.geometry()?,
    };
    if let Some(folder) = folder {
        folder.write(FILE, |file| {
            serde_json::to_writer(&mut *file, &stored)?;
            writeln!(file)
        })?;
    }
    Ok(StrokeTable {
        geometry: stored.table,
        model: stored.model,
        is_stored: false,
    })
}

/// The table in a folder, if it is one of the same flow problem, limits and accuracy.
fn stored(folder: &Path, scene: &Scene, limits: &StrokeLimits, tolerance: f64) -> Option<Stored> {
    let text = std::fs::read_to_string(folder.join(FILE)).ok()?;
    let stored: Stored = serde_json::from_str(&text).ok()?;
    let other = Scene::parse(&stored.scene).ok()?;
    let is_same = scene.differing_key(&other).is_none()
        && other.initial_state() == scene.initial_state()
        && other.model() == scene.model()
        && other.fem() == scene.fem()
        && stored.ranges == limits.ranges
        && stored.tolerance <= tolerance;
    is_same.then_some(stored)
}
