//! The instantaneous solution at the start of a scene.

use models::{
    Configuration, FlowField, Hydrodynamics, InstantaneousSolution, ModelError, PointFlow,
};
use nalgebra::{DMatrix, Vector3};
use scene::Scene;

use crate::error::SwimError;
use crate::moment::Moment;

/// The solution at the start of the first phase of the gait, or with constant shape for a scene
/// without a gait ([`Moment::solve`]).
///
/// # Errors
/// [`SwimError::OtherScene`] for a model of another scene; those of the model.
pub fn solve_start(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
) -> Result<InstantaneousSolution, SwimError> {
    Moment::start(scene)?.solve(scene, model)
}

/// The grand resistance matrix of the bodies at the start of the scene.
///
/// # Errors
/// [`SwimError::OtherScene`] for a model of another scene; those of the model.
pub fn start_resistance(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
) -> Result<DMatrix<f64>, SwimError> {
    at_start(scene, model, |model, configuration, _| {
        Ok(model.resistances()?.resistance(configuration)?.matrix)
    })
}

/// Error bars of the entries of [`start_resistance`]; `None` if the model does not estimate them.
///
/// # Errors
/// As [`start_resistance`].
pub fn start_resistance_errors(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
) -> Result<Option<DMatrix<f64>>, SwimError> {
    at_start(scene, model, |model, configuration, _| {
        Ok(model.resistances()?.resistance(configuration)?.errors)
    })
}

/// The flow field at the start of the scene.
///
/// # Errors
/// [`SwimError::OtherScene`] for a model of another scene; those of the model.
pub fn start_flow(scene: &Scene, model: &mut dyn Hydrodynamics) -> Result<FlowField, SwimError> {
    Moment::start(scene)?.flow(scene, model)
}

/// Velocity and pressure at points, at the start of the scene; `None` for a point outside the
/// fluid, or outside the mesh.
///
/// # Errors
/// As [`start_flow`].
pub fn start_flow_at(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    points: &[Vector3<f64>],
) -> Result<Vec<Option<PointFlow>>, SwimError> {
    Moment::start(scene)?.flow_at(scene, model, points)
}

/// Evaluates the model for the configuration and the rates at the start.
pub(crate) fn at_start<T>(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    evaluate: impl FnOnce(&mut dyn Hydrodynamics, Configuration<'_>, &[f64]) -> Result<T, ModelError>,
) -> Result<T, SwimError> {
    Moment::start(scene)?.evaluate(scene, model, evaluate)
}
