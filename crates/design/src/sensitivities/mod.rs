//! Sensitivities: derivatives of the net displacement of a gait with respect to parameters.
//!
//! They are central differences of whole runs, by the model and the integration of the scene. Steps
//! of two sizes give the extrapolated derivative and its error bar (Richardson 1911). This works
//! for every model and for springs in the periodic state; adjoint solutions would need the
//! derivatives of meshes and expansions with respect to sizes.

pub(crate) mod parameter;

use nalgebra::Vector3;
use scene::{Document, ModelKind, Scene};
use serde::Serialize;

pub(crate) use parameter::with_values;
pub use parameter::{Parameter, parameters};

use crate::error::{DesignError, DesignProgress, check_interruption};
use swimmer::{Method, choose, continue_from, mean_of_moving, start_of_gait};

/// The larger step, relative to the parameter. Its extrapolated error is of the order of its fourth
/// power, and error bars of runs are divided by the half of it.
const STEP: f64 = 0.04;

/// Tolerance of the runs relative to that of the scene, because their errors are divided by steps.
const TOLERANCE: f64 = 1e-2;

/// A derivative of the net displacement.
#[derive(Clone, Debug, Serialize)]
#[non_exhaustive]
pub struct Sensitivity {
    /// The parameter.
    #[serde(flatten)]
    pub parameter: Parameter,
    /// Derivative of the component of the net displacement along its direction in the scene.
    pub derivative: f64,
    /// Its error bar: of the extrapolation, and of the runs.
    pub error: f64,
}

/// The net displacement of a run and its work on the fluid, with their error bars.
pub(crate) struct Net {
    pub vector: Vector3<f64>,
    pub bar: f64,
    pub work: f64,
    pub work_bar: f64,
}

/// Derivatives of the net displacement of all cycles of a scene with respect to its [`parameters`].
///
/// Cost: four runs per parameter, and one.
///
/// # Errors
/// As [`sensitivity`].
pub fn sensitivities(
    scene: &Scene,
    progress: &mut dyn DesignProgress,
) -> Result<Vec<Sensitivity>, DesignError> {
    let parameters = parameters(scene)?;
    let (scene, direction) = comparable(scene)?;
    let mut found = Vec::new();
    let all = parameters.len();
    progress.counted("sensitivities", 0, all);
    for parameter in parameters {
        progress.begins(&format!("sensitivity to the {}", parameter.name));
        found.push(derivative(&scene, &direction, parameter)?);
        progress.counted("sensitivities", found.len(), all);
        check_interruption(progress, || format!("{} sensitivities", found.len()))?;
    }
    Ok(found)
}

/// Derivative of the net displacement with respect to one parameter.
///
/// ```text
/// D(h) = (x(p + h) - x(p - h)) / 2h,   x' = (4 D(h/2) - D(h)) / 3
/// ```
///
/// The error bar is `|x' - D(h/2)|` and the error bars of the four runs with their weights.
///
/// # Errors
/// A net displacement that cannot be distinguished from zero, changed scenes in which bodies touch,
/// errors of the model and the integration.
pub fn sensitivity(scene: &Scene, parameter: Parameter) -> Result<Sensitivity, DesignError> {
    let (scene, direction) = comparable(scene)?;
    derivative(&scene, &direction, parameter)
}

/// Derivative of the component of the net displacement along `direction`.
fn derivative(
    scene: &Scene,
    direction: &Vector3<f64>,
    parameter: Parameter,
) -> Result<Sensitivity, DesignError> {
    let difference = |step: f64| -> Result<(f64, f64), DesignError> {
        let at = |value: f64| net_displacement(&parameter.set(scene, value)?);
        let (above, below) = (at(parameter.value + step)?, at(parameter.value - step)?);
        let change = (above.vector - below.vector).dot(direction);
        Ok((
            change / (2.0 * step),
            (above.bar + below.bar) / (2.0 * step),
        ))
    };
    // Only angles can be zero: the rest value of a spring in a hinge. Their unit is the radian.
    let step = match parameter.value == 0.0 {
        true => STEP,
        false => STEP * parameter.value.abs(),
    };
    let (coarse, fine) = (difference(step)?, difference(0.5 * step)?);
    let derivative = (4.0 * fine.0 - coarse.0) / 3.0;
    Ok(Sensitivity {
        error: (derivative - fine.0).abs() + (4.0 * fine.1 + coarse.1) / 3.0,
        parameter,
        derivative,
    })
}

/// The scene with a tighter tolerance and a fixed model, which changes with parameters otherwise,
/// and the direction of its net displacement.
pub(crate) fn comparable(scene: &Scene) -> Result<(Scene, Vector3<f64>), DesignError> {
    let tolerance = (TOLERANCE * scene.model().tolerance).max(1e-9);
    let mut fixed = scene.with_tolerance(tolerance)?;
    if scene.model().kind == ModelKind::Auto {
        let kind = match choose(&fixed)?.model.name() {
            // Their errors would be error bars.
            "oseen" | "rpy" => "multipole",
            name => name,
        };
        let assignment = format!("model.kind={kind}");
        fixed = with_keys(&fixed, std::slice::from_ref(&assignment), &assignment)?;
    }
    let net = net_displacement(&fixed)?;
    if net.vector.norm() <= net.bar {
        let problem = format!(
            "the net displacement, {:.1e} +- {:.1e}, has no direction in which it could change",
            net.vector.norm(),
            net.bar
        );
        return Err(DesignError::not_applicable(&fixed, "gait", problem));
    }
    Ok((fixed, net.vector.normalize()))
}

/// The net displacement of a run of the scene, in the periodic state if the scene says so.
pub(crate) fn net_displacement(scene: &Scene) -> Result<Net, DesignError> {
    let mut model = choose(scene)?.model;
    let method = Method::from_scene(scene);
    let start = start_of_gait(scene, model.as_mut(), method, &mut ())?;
    let outcome = continue_from(scene, model.as_mut(), method, &mut (), start)?;
    Ok(Net {
        vector: mean_of_moving(&outcome.displacement),
        bar: outcome.error_estimate.total(),
        work: outcome.work,
        work_bar: outcome.work_error.total(),
    })
}

/// The scene with other values of some keys, `key=value`; `place` stands for file and line in
/// messages.
pub(crate) fn with_keys(
    scene: &Scene,
    assignments: &[String],
    place: &str,
) -> Result<Scene, DesignError> {
    let mut document = Document::parse(&scene.to_toml()?, "scene")?.located(place);
    for assignment in assignments {
        document.set_at(assignment, place)?;
    }
    Ok(Scene::from_document(document)?)
}
