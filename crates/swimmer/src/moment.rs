//! A moment of the motion: what is computed from positions and rates alone.

use models::{
    Configuration, FlowField, Hydrodynamics, InstantaneousSolution, ModelError, PointFlow, Query,
};
use nalgebra::Vector3;
use rigid::State;
use scene::{Scene, spans};

use crate::error::SwimError;

/// Positions of the bodies and rates of the joints at a time.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Moment {
    /// The time.
    pub time: f64,
    /// State of the bodies.
    pub state: State,
    /// Values of the joints; those of passive joints are part of the state.
    pub shape: Vec<f64>,
    /// Rates of the prescribed joints.
    pub rates: Vec<f64>,
}

impl Moment {
    /// The start of the first phase of the gait; at constant shape for a scene without a gait.
    ///
    /// # Errors
    /// A gait that cannot be followed.
    pub fn start(scene: &Scene) -> Result<Self, SwimError> {
        let shape = scene.articulation().initial_shape();
        let first = spans(scene.gait(), shape)?.next();
        Ok(Self {
            time: 0.0,
            state: scene.initial_state(),
            rates: first.map_or(vec![0.0; shape.len()], |span| span.rates(0.0)),
            shape: shape.to_vec(),
        })
    }

    /// The instantaneous solution.
    ///
    /// The mesh is adapted to `fem.target`, if the scene has that key. The solution carries its
    /// flow, if the model has a mesh.
    ///
    /// # Errors
    /// [`SwimError::OtherScene`] for a model of another scene; those of the model.
    pub fn solve(
        &self,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
    ) -> Result<InstantaneousSolution, SwimError> {
        let solution = self.evaluate(scene, model, |model, configuration, rates| {
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

    /// The flow field, on the mesh of the model or on one generated for it.
    ///
    /// # Errors
    /// [`SwimError::OtherScene`] for a model of another scene; those of the model.
    pub fn flow(
        &self,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
    ) -> Result<FlowField, SwimError> {
        self.evaluate(scene, model, |model, configuration, rates| {
            model.flows()?.flow(configuration, rates)
        })
    }

    /// Velocity and pressure at points; `None` for a point outside the fluid, or outside the mesh.
    ///
    /// # Errors
    /// As [`Moment::flow`].
    pub fn flow_at(
        &self,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<PointFlow>>, SwimError> {
        self.evaluate(scene, model, |model, configuration, rates| {
            model.flows()?.flow_at(configuration, rates, points)
        })
    }

    /// Evaluates the model for the configuration and the rates.
    pub(crate) fn evaluate<T>(
        &self,
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        evaluate: impl FnOnce(
            &mut dyn Hydrodynamics,
            Configuration<'_>,
            &[f64],
        ) -> Result<T, ModelError>,
    ) -> Result<T, SwimError> {
        check_model(scene, model)?;
        let configuration = Configuration::new(&self.state, &self.shape).at_time(self.time);
        Ok(evaluate(model, configuration, &self.rates)?)
    }
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
