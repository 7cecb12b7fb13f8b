//! What the sizes of a swimmer are chosen for.

use nalgebra::Vector3;
use scene::{ObjectiveKind, Scene};
use serde::Serialize;

use crate::error::DesignError;
use crate::limits::drag_of_bodies;
use crate::sensitivities::net_displacement;

/// A run with some sizes.
#[derive(Clone, Copy, Debug, Serialize)]
#[non_exhaustive]
pub struct SizeRun {
    /// What is maximised: the efficiency or the displacement.
    #[serde(skip)]
    pub objective: f64,
    /// Its error bar.
    #[serde(skip)]
    pub error: f64,
    /// Net displacement along its direction.
    pub displacement: f64,
    /// Its error bar.
    pub displacement_error: f64,
    /// Work on the fluid.
    pub work: f64,
    /// Its error bar.
    pub work_error: f64,
    /// Lighthill efficiency `6 π μ r Δ² / (E T)` with the sum `r` of the bounding radii of
    /// the bodies, negative for a swimmer that goes backwards.
    pub efficiency: f64,
    /// Its error bar.
    pub efficiency_error: f64,
}

/// The objective of a scene.
#[derive(Clone, Copy, Debug)]
pub struct SizeObjective {
    kind: ObjectiveKind,
    direction: Vector3<f64>,
}

impl SizeObjective {
    /// The objective `optimise.objective`.
    ///
    /// # Errors
    /// [`DesignError::NotApplicable`] for an objective that asks for another stroke.
    pub fn from_scene(scene: &Scene) -> Result<Self, DesignError> {
        let options = scene.optimise();
        match options.objective {
            kind @ (ObjectiveKind::Efficiency | ObjectiveKind::Displacement) => Ok(Self {
                kind,
                direction: options.direction.map_or(Vector3::zeros(), Vector3::from),
            }),
            kind => {
                let problem = format!(
                    "sizes are chosen for \"efficiency\" or \"displacement\", not for \"{}\"; \
                     `swim optimise` searches such strokes",
                    kind.word()
                );
                Err(DesignError::not_applicable(
                    scene,
                    "optimise.objective",
                    problem,
                ))
            }
        }
    }

    /// The objective with a direction where the scene gives none.
    pub fn along(self, direction: Vector3<f64>) -> Self {
        Self {
            direction: self.direction.try_normalize(0.0).unwrap_or(direction),
            ..self
        }
    }

    /// Runs a scene.
    ///
    /// # Errors
    /// Those of the run; [`DesignError::NotApplicable`] for a gait that does no work.
    pub fn run(&self, scene: &Scene) -> Result<SizeRun, DesignError> {
        let net = net_displacement(scene)?;
        let displacement = net.vector.dot(&self.direction);
        let time = scene.gait().cycle_duration() * f64::from(scene.gait().cycles);
        let power = net.work / time;
        if !(power > 0.0 && power.is_finite()) {
            let problem =
                format!("the efficiency requires a gait that does work, and the power is {power}");
            return Err(DesignError::not_applicable(scene, "gait", problem));
        }
        let factor = drag_of_bodies(scene) / (net.work * time);
        let efficiency = factor * displacement * displacement.abs();
        let efficiency_error = 2.0 * factor * displacement.abs() * net.bar
            + efficiency.abs() * net.work_bar / net.work;
        let (objective, error) = match self.kind {
            ObjectiveKind::Displacement => (displacement, net.bar),
            _ => (efficiency, efficiency_error),
        };
        Ok(SizeRun {
            objective,
            error,
            displacement,
            displacement_error: net.bar,
            work: net.work,
            work_error: net.work_bar,
            efficiency,
            efficiency_error,
        })
    }
}
