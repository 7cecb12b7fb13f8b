//! The class `Motion`: a finished run as a function of time, with the flow at any time of it.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use ::design::DesignError;
use numpy::{AllowTypeChange, PyArray1, PyArrayLike1, PyArrayLike2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use swimmer::models::Hydrodynamics;
use swimmer::scene::Document;
use swimmer::{Motion, Scene, SceneError, SwimError, choose};

use crate::convert::{flow_dict, point_flows, points, solution_dict, table};
use crate::errors::{SceneException, exception};
use crate::job;

/// A run that was completed, and the model of its last flow.
struct Moved {
    scene: Scene,
    motion: Motion,
    model: Mutex<Option<Box<dyn Hydrodynamics>>>,
}

impl Moved {
    /// What `evaluate` finds with a model that successive calls share, with its meshes.
    fn with_model<T>(
        &self,
        evaluate: impl FnOnce(&Self, &mut dyn Hydrodynamics) -> Result<T, SwimError>,
    ) -> Result<T, DesignError> {
        let mut kept = self.model.lock().unwrap_or_else(PoisonError::into_inner);
        // Taken, so that a model is not used again after an error.
        let mut model = match kept.take() {
            Some(model) => model,
            None => choose(&self.scene)?.model,
        };
        let found = evaluate(self, model.as_mut())?;
        *kept = Some(model);
        Ok(found)
    }
}

/// The motion of a finished run.
#[pyclass(frozen, name = "Motion", module = "swimmer._swimmer")]
pub struct PyMotion(Arc<Moved>);

impl PyMotion {
    /// The motion of a scene that was run.
    pub fn new(scene: Scene, motion: Motion) -> Self {
        Self(Arc::new(Moved {
            scene,
            motion,
            model: Mutex::default(),
        }))
    }
}

#[pymethods]
impl PyMotion {
    /// A motion from what [`PyMotion::__reduce__`] returns.
    #[staticmethod]
    fn restore(toml: &str, path: PathBuf, json: &str) -> PyResult<Self> {
        let scene = || Scene::from_document(Document::parse(toml, &path)?);
        let scene: Result<Scene, SceneError> = scene();
        let motion = serde_json::from_str(json);
        let motion = motion.map_err(|error| SceneException::new_err(error.to_string()))?;
        Ok(Self::new(scene.map_err(exception)?, motion))
    }

    fn __reduce__<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<(Bound<'py, PyAny>, (String, String, String))> {
        let restore = py.get_type::<Self>().getattr("restore")?;
        let moved = &self.0;
        let toml = moved.scene.to_toml().map_err(exception)?;
        let json = serde_json::to_string(&moved.motion);
        let json = json.map_err(|error| SceneException::new_err(error.to_string()))?;
        Ok((
            restore,
            (toml, format!("{}.toml", moved.scene.name()), json),
        ))
    }

    /// Values of the joints, rates, centres and attitudes of the bodies at times.
    fn at<'py>(
        &self,
        py: Python<'py>,
        times: PyArrayLike1<'py, f64, AllowTypeChange>,
    ) -> PyResult<[Bound<'py, PyAny>; 4]> {
        let Moved { scene, motion, .. } = &*self.0;
        let set = scene.articulation();
        let (mut lengths, mut rates) = (Vec::new(), Vec::new());
        let (mut places, mut turns) = (Vec::new(), Vec::new());
        for &time in times.as_array() {
            let moment = motion.at(scene, time).map_err(exception)?;
            let poses = set.place(&moment.state, &moment.shape);
            let values = set.joint_values(&moment.state, &moment.shape);
            for pose in poses.map_err(SwimError::from).map_err(exception)? {
                places.extend_from_slice(pose.translation.vector.as_slice());
                turns.extend_from_slice(pose.rotation.coords.as_slice());
            }
            lengths.push(values.map_err(SwimError::from).map_err(exception)?);
            rates.push(moment.rates);
        }
        let joints = set.joints().len();
        let shaped = |flat: Vec<f64>, width: usize| {
            let shape = [lengths.len(), scene.bodies().len(), width];
            Ok::<_, PyErr>(PyArray1::from_vec(py, flat).reshape(shape)?.into_any())
        };
        Ok([
            table(py, &lengths, joints)?,
            table(py, &rates, joints)?,
            shaped(places, 3)?,
            shaped(turns, 4)?,
        ])
    }

    /// The instantaneous solution at a time.
    fn solve<'py>(&self, py: Python<'py>, time: f64) -> PyResult<Bound<'py, PyDict>> {
        let moved = self.0.clone();
        let (name, solution) = job::run(py, None, move |_| {
            moved.with_model(|moved, model| {
                let solution = moved.motion.solve(&moved.scene, model, time)?;
                Ok((model.name(), solution))
            })
        })?;
        solution_dict(py, &self.0.scene, name, &solution)
    }

    /// The flow on the nodes of a mesh at a time.
    fn flow<'py>(&self, py: Python<'py>, time: f64) -> PyResult<Bound<'py, PyDict>> {
        let moved = self.0.clone();
        let flow = job::run(py, None, move |_| {
            moved.with_model(|moved, model| moved.motion.flow(&moved.scene, model, time))
        })?;
        flow_dict(py, &flow)
    }

    /// Velocities and pressures at points at a time, one row each; NaN where there is no fluid.
    fn flow_at<'py>(
        &self,
        py: Python<'py>,
        time: f64,
        at: PyArrayLike2<'py, f64, AllowTypeChange>,
    ) -> PyResult<[Bound<'py, PyAny>; 2]> {
        let (moved, points) = (self.0.clone(), points(&at.as_array())?);
        let found = job::run(py, None, move |_| {
            moved.with_model(|moved, model| {
                (moved.motion).flow_at(&moved.scene, model, time, &points)
            })
        })?;
        point_flows(py, &found)
    }
}
