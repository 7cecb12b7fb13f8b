//! Scenes with other options, which pass the same checks as those of a file.

use std::collections::BTreeMap;

use super::{contacts, limits};
use crate::checks::{Checks, check_prescribed};
use crate::error::SceneError;
use crate::gait::{Gait, spans};
use crate::keys::{FemOptions, ModelOptions};
use crate::scene::Scene;
use crate::words::{InertiaKind, RheologyKind};

/// Replaces file and line in messages about an option that a program sets.
const ORIGIN: &str = "option set by a program";

impl Scene {
    /// The scene with other options of the model.
    ///
    /// # Errors
    /// [`SceneError::BadValue`], as for a file.
    pub fn with_model(&self, model: ModelOptions) -> Result<Self, SceneError> {
        let mut scene = self.clone();
        scene
            .document
            .replace("model", &self.model, &model, ORIGIN)?;
        limits::check_model(&Checks(&scene.document), &model)?;
        scene.model = model;
        Ok(scene)
    }

    /// The scene with other options of the finite-element model.
    ///
    /// # Errors
    /// [`SceneError::BadValue`], as for a file.
    pub fn with_fem(&self, fem: FemOptions) -> Result<Self, SceneError> {
        let mut scene = self.clone();
        scene.document.replace("fem", &self.fem, &fem, ORIGIN)?;
        limits::check_fem(&Checks(&scene.document), &fem)?;
        scene.fem = fem;
        Ok(scene)
    }

    /// The scene with another `fluid.inertia`.
    ///
    /// # Errors
    /// None for a scene that has inertia already.
    pub fn with_inertia(&self, kind: InertiaKind) -> Result<Self, SceneError> {
        let mut scene = self.clone();
        (scene.document).set(&format!("fluid.inertia={}", kind.word()))?;
        scene.inertia.kind = kind;
        Ok(scene)
    }

    /// The scene with another `fluid.rheology`; without a viscosity law the scene as it is.
    ///
    /// # Errors
    /// None for a scene that has a law.
    pub fn with_rheology(&self, kind: RheologyKind) -> Result<Self, SceneError> {
        let mut scene = self.clone();
        if let Some(rheology) = &mut scene.rheology {
            (scene.document).set(&format!("fluid.rheology={}", kind.word()))?;
            rheology.kind = kind;
        }
        Ok(scene)
    }

    /// The scene with another `model.tolerance`.
    ///
    /// # Errors
    /// As [`Scene::with_model`].
    pub fn with_tolerance(&self, tolerance: f64) -> Result<Self, SceneError> {
        self.with_model(ModelOptions {
            tolerance,
            ..self.model
        })
    }

    /// The scene with another `model.tolerance_factor`, or without one.
    ///
    /// # Errors
    /// As [`Scene::with_model`].
    pub fn with_tolerance_factor(&self, tolerance_factor: Option<f64>) -> Result<Self, SceneError> {
        self.with_model(ModelOptions {
            tolerance_factor,
            ..self.model
        })
    }

    /// The tolerance from which those of single solutions and steps follow:
    /// `model.tolerance` times `model.tolerance_factor`.
    pub fn working_tolerance(&self) -> f64 {
        self.model.tolerance * self.model.tolerance_factor.unwrap_or(1.0)
    }

    /// The scene with another `fem.size_factor`, or without one.
    ///
    /// # Errors
    /// As [`Scene::with_fem`].
    pub fn with_size_factor(&self, size_factor: Option<f64>) -> Result<Self, SceneError> {
        self.with_fem(FemOptions {
            size_factor,
            ..self.fem
        })
    }

    /// The scene with another gait, such as one with paths of a program
    /// ([`JointPath`](crate::JointPath)).
    ///
    /// # Errors
    /// As [`spans`](crate::spans); [`SceneError::BadValue`] for joints that are not
    /// prescribed, [`SceneError::Touching`] for bodies that touch on the way.
    pub fn with_gait(&self, gait: Gait) -> Result<Self, SceneError> {
        let mut scene = self.clone();
        let _ = spans(&gait, scene.articulation.initial_shape())?;
        for joint in gait.phases.iter().flat_map(|phase| phase.path.joints()) {
            let joint = &scene.articulation.joints()[joint];
            check_prescribed(joint).map_err(|problem| SceneError::BadValue {
                place: ORIGIN.to_owned(),
                key: "gait".to_owned(),
                problem,
            })?;
        }
        (scene.gait, scene.gait_table) = (gait, None);
        contacts::check_stroke(&scene)?;
        Ok(scene)
    }

    /// The scene with another `gait.cycles`.
    ///
    /// # Errors
    /// [`SceneError::BadValue`] for zero, [`SceneError::Touching`] if bodies touch in the second
    /// cycle only.
    pub fn with_cycles(&self, cycles: u32) -> Result<Self, SceneError> {
        let mut scene = self.clone();
        let value = |cycles: u32| BTreeMap::from([("cycles", cycles)]);
        let (before, after) = (value(self.gait.cycles), value(cycles));
        scene.document.replace("gait", &before, &after, ORIGIN)?;
        scene.gait.cycles = cycles;
        contacts::check_stroke(&scene)?;
        Ok(scene)
    }
}
