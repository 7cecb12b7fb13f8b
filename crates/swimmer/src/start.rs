//! The instantaneous solution at the start of a scene.

use models::{
    Configuration, FlowField, Hydrodynamics, InstantaneousSolution, ModelError, PointFlow, Query,
};
use nalgebra::{DMatrix, Vector3};
use scene::{Scene, spans};

use crate::error::SwimError;

/// The solution at the start of the first phase of the gait, or with constant shape for a scene
/// without a gait.
///
/// The mesh is adapted to `fem.target`, if the scene has that key. The solution carries its flow,
/// if the model has a mesh.
///
/// # Errors
/// [`SwimError::OtherScene`] for a model of another scene; those of the model.
pub fn solve_start(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
) -> Result<InstantaneousSolution, SwimError> {
    let solution = at_start(scene, model, |model, configuration, rates| {
        let rates = [rates.to_vec()];
        let query = Query::new(configuration, &rates)
            .with_accuracy(scene.fem().target)
            .with_stresslets()
            .with_flows(true);
        let mut solutions = model.solve(&query)?;
        solutions.pop().ok_or(ModelError::NoSolution {
            model: model.name(),
        })
    })?;
    solution.check(model)?;
    Ok(solution)
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
    at_start(scene, model, |model, configuration, rates| {
        model.flows()?.flow(configuration, rates)
    })
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
    at_start(scene, model, |model, configuration, rates| {
        model.flows()?.flow_at(configuration, rates, points)
    })
}

/// Evaluates the model for the configuration and the rates at the start.
pub(crate) fn at_start<T>(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    evaluate: impl FnOnce(&mut dyn Hydrodynamics, Configuration<'_>, &[f64]) -> Result<T, ModelError>,
) -> Result<T, SwimError> {
    check_model(scene, model)?;
    let shape = scene.articulation().initial_shape();
    let rates = spans(scene.gait(), shape)?
        .next()
        .map_or(vec![0.0; shape.len()], |span| span.rates(0.0));
    let state = scene.initial_state();
    Ok(evaluate(model, Configuration::new(&state, shape), &rates)?)
}

/// Refuses a model that was created for another flow problem.
///
/// # Errors
/// [`SwimError::OtherScene`].
pub fn check_model(scene: &Scene, model: &dyn Hydrodynamics) -> Result<(), SwimError> {
    match scene.differing_key(model.scene()) {
        Some(key) => Err(SwimError::OtherScene {
            model: model.name(),
            key,
        }),
        None => {
            let capabilities = model.capabilities();
            capabilities.check_deformations(scene, model.name())?;
            capabilities.check_noise(scene, model.name())?;
            Ok(capabilities.check_rheology(scene, model.name())?)
        }
    }
}
