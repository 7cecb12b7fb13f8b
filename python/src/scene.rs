//! The class `Scene`: a scene, and the calls that compute with it.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use ::design::{Connection, DesignError, connection};
use numpy::{AllowTypeChange, PyArrayLike1, PyArrayLike2};
use pictures::RunPictures;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use swimmer::models::rigid::Twist;
use swimmer::models::{Configuration, Hydrodynamics};
use swimmer::scene::Document;
use swimmer::{
    Choice, Scene, SceneError, choose, choose_for_run, choose_for_start, run_without_files,
    solve_start_with_terms, solve_steady, start_flow, start_flow_at, start_resistance,
    start_resistance_errors,
};

use crate::convert::{
    array, body_names, flow_dict, joint_names, matrix, mesh_dict, point_flows, points, report_dict,
    rows, solution_dict,
};
use crate::design;
use crate::errors::{SceneException, exception, run_stopped, tolerance_missed};
use crate::job;
use crate::motion::PyMotion;

/// Longest time of a connection, in seconds, after which the next one is computed in the calling
/// thread: a thread takes some ten microseconds, and Ctrl-C waits until the call ends.
const BRIEF: f64 = 0.05;

/// A model that successive connections share, with its meshes and factorisations.
#[derive(Default)]
struct Kept {
    model: Option<Box<dyn Hydrodynamics>>,
    /// Duration of the last connection; none before the first.
    seconds: Option<f64>,
}

/// A scene that passed all checks.
#[pyclass(frozen, name = "Scene", module = "swimmer._swimmer")]
pub struct PyScene {
    scene: Scene,
    kept: Arc<Mutex<Kept>>,
}

impl PyScene {
    fn new(scene: Result<Scene, SceneError>) -> PyResult<Self> {
        Ok(Self {
            scene: scene.map_err(exception)?,
            kept: Arc::default(),
        })
    }
}

/// The scene of a text; `path` is where the files that it names are, and its name.
fn parse(text: &str, path: &Path, overrides: &[String]) -> Result<Scene, SceneError> {
    let mut document = Document::parse(text, path)?;
    overrides
        .iter()
        .try_for_each(|assignment| document.set(assignment))?;
    Scene::from_document(document)
}

/// A connection and the seconds that it took.
fn timed_connection(
    scene: &Scene,
    kept: &Mutex<Kept>,
    shape: &[f64],
) -> Result<(Connection, f64), DesignError> {
    let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
    let clock = Instant::now();
    // Taken, so that a model is not used again after an error.
    let mut model = match kept.model.take() {
        Some(model) => model,
        None => choose(scene)?.model,
    };
    let found = connection(scene, model.as_mut(), shape)?;
    let seconds = clock.elapsed().as_secs_f64();
    *kept = Kept {
        model: Some(model),
        seconds: Some(seconds),
    };
    Ok((found, seconds))
}

#[pymethods]
impl PyScene {
    #[staticmethod]
    fn read(path: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        Self::new(Scene::read(&path, &overrides))
    }

    #[staticmethod]
    fn parse(text: &str, path: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        Self::new(parse(text, &path, &overrides))
    }

    /// A scene from its keys as JSON; keys with dots are those of groups, such as
    /// `fluid.viscosity`.
    #[staticmethod]
    fn from_json(json: &str, path: PathBuf, overrides: Vec<String>) -> PyResult<Self> {
        let refused =
            |problem: String| SceneException::new_err(format!("{}: {problem}", path.display()));
        let table = serde_json::from_str::<toml::Table>(json);
        let table = table.map_err(|error| refused(error.to_string()))?;
        let (dotted, nested): (toml::Table, toml::Table) =
            table.into_iter().partition(|(key, _)| key.contains('.'));
        let text = toml::to_string(&nested).map_err(|error| refused(error.to_string()))?;
        let scene = || {
            let mut document = Document::parse(&text, &path)?;
            for (key, value) in dotted {
                document.add(&key, value)?;
            }
            (overrides.iter()).try_for_each(|assignment| document.set(assignment))?;
            Scene::from_document(document)
        };
        Self::new(scene())
    }

    fn to_toml(&self) -> PyResult<String> {
        (self.scene.to_toml()).map_err(exception)
    }

    #[getter]
    fn name(&self) -> &str {
        self.scene.name()
    }

    #[getter]
    fn bodies(&self) -> Vec<&str> {
        body_names(&self.scene)
    }

    #[getter]
    fn links(&self) -> Vec<&str> {
        joint_names(&self.scene)
    }

    /// Values of the joints that can change theirs, at the start.
    #[getter]
    fn shape(&self) -> Vec<f64> {
        let set = self.scene.articulation();
        let joints = set.joints().iter().zip(set.initial_shape());
        joints
            .filter(|(joint, _)| joint.kind.has_value())
            .map(|(_, value)| *value)
            .collect()
    }

    /// Name of the model, and the reasons for its choice.
    fn choose(&self, py: Python<'_>) -> PyResult<(&'static str, Vec<String>)> {
        let scene = self.scene.clone();
        job::run(py, None, move |_| {
            let Choice { model, reasons, .. } = choose_for_run(&scene, &mut ())?;
            Ok((model.name(), reasons))
        })
    }

    fn run<'py>(
        &self,
        py: Python<'py>,
        out: Option<PathBuf>,
        resume: bool,
        report: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let scene = self.scene.clone();
        let (mut found, motion) = job::run(py, report, move |mut watch| {
            let found = match out {
                Some(out) => {
                    let pictures = &mut RunPictures::new();
                    swimmer::run(scene, &out, resume, pictures, &mut watch)?
                }
                None => run_without_files(scene, &mut watch)?,
            };
            Ok((found, watch.into_motion()))
        })?;
        let result = report_dict(py, &found)?;
        result.set_item("_motion", PyMotion::new(found.scene.clone(), motion))?;
        if let Some(stopped) = found.stopped.take() {
            return Err(run_stopped(&stopped, &result));
        }
        match found.check_tolerance() {
            Ok(()) => Ok(result),
            Err(missed) => Err(tolerance_missed(&missed, &result)),
        }
    }

    /// The instantaneous solution at the start, or the steady state with inertia.
    fn solve<'py>(&self, py: Python<'py>, steady: bool) -> PyResult<Bound<'py, PyDict>> {
        let scene = self.scene.clone();
        if steady {
            let found = job::run(py, None, move |_| Ok(solve_steady(&scene, &mut ())?))?;
            let dict = solution_dict(py, &self.scene, found.model, &found.solution)?;
            dict.set_item("reynolds", found.reynolds)?;
            return Ok(dict);
        }
        let start = job::run(py, None, move |_| {
            Ok(solve_start_with_terms(scene, &choose_for_start, &mut ())?)
        })?;
        solution_dict(py, &start.scene, start.model.name(), &start.solution)
    }

    /// Names of the bodies, grand resistance matrix, its error bars or None, model.
    #[allow(clippy::type_complexity)]
    fn resistance<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(
        Vec<&str>,
        Bound<'py, PyAny>,
        Option<Bound<'py, PyAny>>,
        &'static str,
    )> {
        let scene = self.scene.clone();
        let (name, found, errors) = job::run(py, None, move |_| {
            let mut model = choose(&scene)?.model;
            let found = start_resistance(&scene, model.as_mut())?;
            let errors = start_resistance_errors(&scene, model.as_mut())?;
            Ok((model.name(), found, errors))
        })?;
        let bodies = self.scene.bodies().iter();
        let names = bodies
            .filter(|body| body.shape.has_surface())
            .map(|body| &body.name[..]);
        let errors = errors.map(|errors| matrix(py, &errors)).transpose()?;
        Ok((names.collect(), matrix(py, &found)?, errors, name))
    }

    /// Columns of the connection with their error bars, metric with its error bars, names of the
    /// joints and of the body that is the origin of the frame, seconds.
    #[allow(clippy::type_complexity)]
    fn connection<'py>(
        &self,
        py: Python<'py>,
        shape: PyArrayLike1<'py, f64, AllowTypeChange>,
    ) -> PyResult<([Bound<'py, PyAny>; 4], Vec<&str>, &str, f64)> {
        let shape: Vec<f64> = shape.as_array().to_vec();
        let last = self.kept.try_lock().ok().and_then(|kept| kept.seconds);
        let (found, seconds) = if last.is_some_and(|seconds| seconds <= BRIEF) {
            job::run_here(py, || timed_connection(&self.scene, &self.kept, &shape))?
        } else {
            let (scene, kept) = (self.scene.clone(), self.kept.clone());
            job::run(py, None, move |_| timed_connection(&scene, &kept, &shape))?
        };
        let twist = |twist: &Twist| {
            let (v, w) = (twist.linear, twist.angular);
            [v.x, v.y, v.z, w.x, w.y, w.z]
        };
        let joints = self.scene.articulation().joints();
        let names = found.variables.iter().map(|&joint| &joints[joint].name[..]);
        Ok((
            [
                rows(py, found.twists.iter().map(twist))?,
                array(py, &found.velocity_errors),
                matrix(py, &found.metric)?,
                matrix(py, &found.metric_errors)?,
            ],
            names.collect(),
            body_names(&self.scene)[self.scene.articulation().linkages()[0].root],
            seconds,
        ))
    }

    fn mesh<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let scene = self.scene.clone();
        let mesh = job::run(py, None, move |_| {
            let mut model = choose(&scene)?.model;
            let state = scene.initial_state();
            let shape = scene.articulation().initial_shape();
            let configuration = Configuration::new(&state, shape);
            let mesh = model.mesh(configuration)?;
            mesh.ok_or_else(|| DesignError::NotApplicable {
                place: scene.place("model.kind"),
                problem: format!(
                    "the model '{}' has no mesh; use model.kind = \"fem\"",
                    model.name()
                ),
            })
        })?;
        mesh_dict(py, &mesh)
    }

    /// The flow on the nodes of a mesh.
    fn flow<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let scene = self.scene.clone();
        let flow = job::run(py, None, move |_| {
            let mut model = choose(&scene)?.model;
            Ok(start_flow(&scene, model.as_mut())?)
        })?;
        flow_dict(py, &flow)
    }

    /// Velocities and pressures at points, one row each; NaN where there is no fluid.
    fn flow_at<'py>(
        &self,
        py: Python<'py>,
        at: PyArrayLike2<'py, f64, AllowTypeChange>,
    ) -> PyResult<[Bound<'py, PyAny>; 2]> {
        let (scene, points) = (self.scene.clone(), points(&at.as_array())?);
        let found = job::run(py, None, move |_| {
            let mut model = choose(&scene)?.model;
            Ok(start_flow_at(&scene, model.as_mut(), &points)?)
        })?;
        point_flows(py, &found)
    }

    fn optimise<'py>(
        &self,
        py: Python<'py>,
        out: Option<PathBuf>,
        report: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        design::optimise(py, self.scene.clone(), out, report)
    }

    /// The best wave of a tube as JSON.
    fn best_wave(
        &self,
        py: Python<'_>,
        out: Option<PathBuf>,
        report: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        design::wave(py, self.scene.clone(), out, report)
    }

    /// The rows of a sweep as JSON: `keys`, and `rows` with `values`, `status`, `result`.
    #[allow(clippy::too_many_arguments)]
    fn sweep(
        &self,
        py: Python<'_>,
        vary: Vec<(String, design::Vary)>,
        random: Option<usize>,
        seed: u64,
        jobs: Option<usize>,
        out: Option<PathBuf>,
        resume: bool,
        report: Option<Py<PyAny>>,
    ) -> PyResult<String> {
        let request = design::SweepRequest {
            random,
            seed,
            jobs,
            out,
            resume,
        };
        design::sweep_rows(py, self.scene.clone(), vary, request, report)
    }

    /// Derivatives of the net displacement as JSON.
    fn sensitivities(&self, py: Python<'_>, report: Option<Py<PyAny>>) -> PyResult<String> {
        design::sensitivity_list(py, self.scene.clone(), report)
    }

    /// The best frequency as JSON.
    fn best_frequency(&self, py: Python<'_>, report: Option<Py<PyAny>>) -> PyResult<String> {
        design::frequency(py, self.scene.clone(), report)
    }

    /// The best sizes as JSON.
    fn best_sizes(&self, py: Python<'_>, report: Option<Py<PyAny>>) -> PyResult<String> {
        design::sizes(py, self.scene.clone(), report)
    }

    /// The map over the shapes; its table is stored in the folder `out`, if there is one.
    fn map(
        &self,
        py: Python<'_>,
        out: Option<PathBuf>,
        report: Option<Py<PyAny>>,
    ) -> PyResult<design::PyStrokeMap> {
        design::map(py, self.scene.clone(), out, report)
    }

    /// What learning finds, as `learned.json` of the command line.
    fn learn(&self, py: Python<'_>, report: Option<Py<PyAny>>) -> PyResult<String> {
        design::learned(py, self.scene.clone(), report)
    }

    /// Rewards of all steps between contracted and extended joints: table, names of the joints,
    /// error bar, model.
    #[allow(clippy::type_complexity)]
    fn rewards<'py>(
        &self,
        py: Python<'py>,
        report: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyAny>, Vec<String>, f64, &'static str)> {
        design::rewards(py, self.scene.clone(), report)
    }
}
