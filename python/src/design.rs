//! Optimal strokes, rewards of steps between shapes, sweeps, sensitivities, best frequencies and
//! sizes.

use std::path::{Path, PathBuf};

use ::design::{
    DesignError, DesignedStroke, RandomPoints, StrokeMap, SweepOptions, Values, VariedKey,
    best_frequency, best_sizes, best_wave, design_stroke, learn, sensitivities, stroke_map, sweep,
    wave_variables,
};
use numpy::{AllowTypeChange, PyArray1, PyArrayLike2, PyArrayMethods};
use pyo3::exceptions::PyIndexError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::json;
use swimmer::models::TablePart;
use swimmer::output::Folder;
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
        in_folder(out, |out| design_stroke(&scene, out, &mut watch))
    })?;
    optimum_dict(py, &found)
}

/// What is done in the folder `out`, or in a temporary one.
fn in_folder<T>(
    out: Option<PathBuf>,
    work: impl FnOnce(&Path) -> Result<T, DesignError>,
) -> Result<T, DesignError> {
    let Some(out) = out else {
        let folder = tempfile::tempdir().map_err(|source| SwimError::Write {
            path: std::env::temp_dir(),
            source,
        })?;
        return work(folder.path());
    };
    work(&out)
}

/// The best wave of a tube, as in `optimum.json` of the command line with the scene.
pub fn wave(
    py: Python<'_>,
    scene: Scene,
    out: Option<PathBuf>,
    report: Option<Py<PyAny>>,
) -> PyResult<String> {
    let found = job::run(py, report, move |mut watch| {
        let variables = wave_variables(&scene)?;
        in_folder(out, |out| best_wave(&scene, &variables, out, &mut watch))
    })?;
    let mut json = found.json();
    let toml = found.report.scene.to_toml();
    json["toml"] = json!(toml.map_err(crate::errors::exception)?);
    Ok(json.to_string())
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
    let joints = found.scene.articulation().joints().len();
    dict.set_item("lengths", table(py, &found.shapes, joints)?)?;
    let toml = found.scene.to_toml().map_err(crate::errors::exception)?;
    dict.set_item("toml", toml)?;
    Ok(dict)
}

/// Connection, metric and curvature over the shapes of a scene.
#[pyclass(frozen, name = "StrokeMap", module = "swimmer._swimmer")]
pub struct PyStrokeMap(StrokeMap);

#[pymethods]
impl PyStrokeMap {
    /// The map as `swim map --json` prints it.
    fn json(&self) -> String {
        self.0.json().to_string()
    }

    /// Shapes along one cycle of the gait, one row each.
    fn stroke<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        table(py, &self.0.stroke, self.0.names.len())
    }

    /// At shapes, one row each: connection, metric, and the curvature for the joints with the
    /// numbers `first` and `second`.
    fn at<'py>(
        &self,
        py: Python<'py>,
        shapes: PyArrayLike2<'py, f64, AllowTypeChange>,
        first: usize,
        second: usize,
    ) -> PyResult<[Bound<'py, PyAny>; 3]> {
        let joints = self.0.names.len();
        if first.max(second) >= joints {
            return Err(PyIndexError::new_err(format!("there are {joints} links")));
        }
        let (mut connections, mut metrics) = (Vec::new(), Vec::new());
        let mut curvatures = Vec::new();
        for shape in shapes.as_array().rows() {
            let shape = shape.to_vec();
            let local = (self.0.table.geometry.at(&shape)).map_err(crate::errors::exception)?;
            for row in 0..6 {
                connections.extend(local.connection.iter().map(|column| column[row]));
            }
            metrics.extend_from_slice(local.metric.transpose().as_slice());
            curvatures.push(local.curvature(first, second).as_slice().to_vec());
        }
        let count = curvatures.len();
        Ok([
            PyArray1::from_vec(py, connections)
                .reshape([count, 6, joints])?
                .into_any(),
            PyArray1::from_vec(py, metrics)
                .reshape([count, joints, joints])?
                .into_any(),
            table(py, &curvatures, 6)?,
        ])
    }
}

/// The map of a scene.
pub fn map(
    py: Python<'_>,
    scene: Scene,
    out: Option<PathBuf>,
    report: Option<Py<PyAny>>,
) -> PyResult<PyStrokeMap> {
    let found = job::run(py, report, move |mut watch| {
        let folder = out.map(Folder::create).transpose()?;
        let _lock = folder.as_ref().map(Folder::lock).transpose()?;
        stroke_map(&scene, (folder.as_ref(), TablePart::Whole), &mut watch)
    })?;
    Ok(PyStrokeMap(found))
}

/// What learning finds for a scene.
pub fn learned(py: Python<'_>, scene: Scene, report: Option<Py<PyAny>>) -> PyResult<String> {
    let found = job::run(py, report, move |mut watch| {
        learn::learn_stroke(&scene, &mut watch)
    })?;
    Ok(found.json().to_string())
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
    Ok((
        table(py, &rows, joints)?,
        found.names,
        found.error,
        found.model,
    ))
}

/// The values of a key: as the command line has them, or a list.
#[derive(FromPyObject)]
pub enum Vary {
    /// `from:to:count`, `from:to` or a list with commas.
    Text(String),
    /// Values as they are written in a scene.
    List(Vec<String>),
}

/// What a sweep is asked for besides its keys.
pub struct SweepRequest {
    pub random: Option<usize>,
    pub seed: u64,
    pub jobs: Option<usize>,
    pub out: Option<PathBuf>,
    pub resume: bool,
}

/// The rows of a sweep.
pub fn sweep_rows(
    py: Python<'_>,
    scene: Scene,
    vary: Vec<(String, Vary)>,
    request: SweepRequest,
    report: Option<Py<PyAny>>,
) -> PyResult<String> {
    let key = |(key, values): (String, Vary)| match values {
        Vary::Text(text) => format!("{key}={text}").parse(),
        Vary::List(list) => Ok(VariedKey {
            key,
            values: Values::List(list),
        }),
    };
    let keys: Vec<VariedKey> =
        (vary.into_iter().map(key).collect::<Result<_, _>>()).map_err(crate::errors::exception)?;
    let found = job::run(py, report, move |mut watch| {
        let folder = request.out.map(Folder::create).transpose()?;
        let _lock = folder.as_ref().map(Folder::lock).transpose()?;
        let seed = request.seed;
        let random = request.random.map(|count| RandomPoints { count, seed });
        let options = SweepOptions {
            jobs: request.jobs,
            folder: folder.as_ref(),
            resume: request.resume,
        };
        sweep(&scene, &keys, random, options, &mut watch)
    })?;
    Ok(found.json().to_string())
}

/// Derivatives of the net displacement.
pub fn sensitivity_list(
    py: Python<'_>,
    scene: Scene,
    report: Option<Py<PyAny>>,
) -> PyResult<String> {
    let found = job::run(py, report, move |mut watch| {
        sensitivities::sensitivities(&scene, &mut watch)
    })?;
    Ok(json!(found).to_string())
}

/// The frequency of the largest net displacement per cycle.
pub fn frequency(py: Python<'_>, scene: Scene, report: Option<Py<PyAny>>) -> PyResult<String> {
    let found = job::run(py, report, move |mut watch| {
        best_frequency(&scene, &mut watch)
    })?;
    Ok(found.json().to_string())
}

/// The best radii and arm lengths.
pub fn sizes(py: Python<'_>, scene: Scene, report: Option<Py<PyAny>>) -> PyResult<String> {
    let found = job::run(py, report, move |mut watch| best_sizes(&scene, &mut watch))?;
    // A JSON object does not keep the order of its keys.
    let names = found.parameters.iter().map(|p| &p.name).collect::<Vec<_>>();
    let toml = found.scene.to_toml().map_err(crate::errors::exception)?;
    let mut json = found.json();
    json["names"] = json!(names);
    json["toml"] = json!(toml);
    Ok(json.to_string())
}
