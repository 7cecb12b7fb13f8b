//! Optimal strokes, and the rewards of steps between shapes.

use std::path::PathBuf;

use ::design::{DesignedStroke, design_stroke, learn};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use swimmer::{Scene, SwimError};

use crate::convert::{array, estimate, joint_names, table};
use crate::job;

/// The best stroke of a scene; its files are written into the folder `out`, if there is one.
pub fn optimise<'py>(
    py: Python<'py>,
    scene: Scene,
    out: Option<PathBuf>,
    report: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let found = job::run(py, report, move |mut watch| {
        let Some(out) = out else {
            let folder = tempfile::tempdir().map_err(|source| SwimError::Write {
                path: std::env::temp_dir(),
                source,
            })?;
            return design_stroke(&scene, folder.path(), &mut watch);
        };
        design_stroke(&scene, &out, &mut watch)
    })?;
    optimum_dict(py, &found)
}

fn optimum_dict<'py>(py: Python<'py>, found: &DesignedStroke) -> PyResult<Bound<'py, PyDict>> {
    let (optimum, outcome) = (&found.optimum, &found.outcome);
    let dict = PyDict::new(py);
    dict.set_item("objective", found.scene.optimise().objective.word())?;
    dict.set_item("model", found.model)?;
    dict.set_item("links", joint_names(&found.scene))?;
    dict.set_item("displacement", optimum.totals.displacement.norm())?;
    dict.set_item("displacement_error", found.table_error)?;
    dict.set_item(
        "displacement_vector",
        array(py, optimum.totals.displacement.as_slice()),
    )?;
    dict.set_item("rotation", array(py, optimum.totals.rotation.as_slice()))?;
    dict.set_item("run_displacement", found.run_displacement)?;
    dict.set_item("run_errors", estimate(py, &outcome.error_estimate)?)?;
    dict.set_item("energy", outcome.work)?;
    dict.set_item("energy_errors", estimate(py, &outcome.work_error)?)?;
    dict.set_item("period", found.period)?;
    dict.set_item("period_energy_product", optimum.period_energy_product)?;
    dict.set_item("efficiency", found.efficiency)?;
    dict.set_item("refinement_error", optimum.refinement_error)?;
    dict.set_item("at_limits", optimum.at_limits)?;
    dict.set_item("lengths", table(py, &found.shapes)?)?;
    let toml = found.scene.to_toml().map_err(crate::errors::exception)?;
    dict.set_item("toml", toml)?;
    Ok(dict)
}

/// Rewards: table with a row per state and a column per joint, names of the joints, error bar,
/// model.
#[allow(clippy::type_complexity)]
pub fn rewards<'py>(
    py: Python<'py>,
    scene: Scene,
    report: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyAny>, Vec<String>, f64, &'static str)> {
    let found = job::run(py, report, move |mut watch| {
        learn::rewards(&scene, &mut watch)
    })?;
    let states = 0..found.states();
    let joints = found.joints.len();
    let rows: Vec<Vec<f64>> = states
        .map(|state| (0..joints).map(|joint| found.of(state, joint)).collect())
        .collect();
    Ok((table(py, &rows)?, found.names, found.error, found.model))
}
