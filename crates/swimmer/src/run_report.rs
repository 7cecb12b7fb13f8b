//! What a run has reached.

use scene::{AcceptKind, Scene};
use serde_json::{Value, json};

use crate::efficiency::Efficiency;
use crate::error::SwimError;
use crate::neglected::Neglected;
use crate::outcome::Outcome;
use crate::output::summary_json;

/// A run that was completed, or that stopped where its motion ended.
#[derive(Debug)]
#[non_exhaustive]
pub struct Report {
    /// The scene as it was run, with the element sizes chosen for `fem.target`.
    pub scene: Scene,
    /// Name of the model.
    pub model: &'static str,
    /// Reasons for the choice of the model.
    pub reasons: Vec<String>,
    /// Outcome of the gait, or of its part before `stopped`.
    pub outcome: Outcome,
    /// What neglecting inertia or the viscosity law costs, where it is neglected.
    pub neglected: Vec<Neglected>,
    /// Lighthill's efficiency of a swimmer that was completed; none of runs that do not swim.
    pub efficiency: Option<Efficiency>,
    /// The error that ended the motion, such as contact; none for a completed run.
    pub stopped: Option<SwimError>,
    /// Wall-clock time of the whole run in seconds.
    pub seconds: f64,
}

impl Report {
    /// The summary of the run, as in `summary.json`.
    pub fn summary(&self) -> Value {
        let mut summary = summary_json(
            &self.scene,
            self.model,
            &self.reasons,
            &self.outcome,
            self.seconds,
        );
        for neglected in &self.neglected {
            summary[neglected.key()] = neglected.json(&self.scene);
        }
        summary["efficiency"] = json!(self.efficiency.as_ref().map(Efficiency::json));
        summary
    }

    /// The report of a run that was completed.
    ///
    /// # Errors
    /// The error at which the run stopped.
    pub fn completed(self) -> Result<Self, SwimError> {
        match self.stopped {
            Some(error) => Err(error),
            None => Ok(self),
        }
    }

    /// Whether the error bar is within the tolerance, or the scene accepts the best result.
    ///
    /// # Errors
    /// [`SwimError::ToleranceMissed`].
    pub fn check_tolerance(&self) -> Result<(), SwimError> {
        let (model, outcome) = (self.scene.model(), &self.outcome);
        if outcome.tolerance_met || model.accept == AcceptKind::Best {
            return Ok(());
        }
        Err(SwimError::ToleranceMissed {
            error: outcome.limited_error.unwrap_or(f64::INFINITY),
            tolerance: model.tolerance,
            allowed: outcome.allowed_error,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outcome::Interim;

    fn report(accept: &str, tolerance_met: bool) -> Report {
        let scene = Scene::parse(&format!(
            "model = {{ tolerance = 1e-4, accept = \"{accept}\" }}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0] }}]\n"
        ))
        .unwrap();
        let mut outcome = Interim::start(&scene).unwrap().outcome;
        outcome.displacement = vec![nalgebra::Vector3::x()];
        outcome.error_estimate.integration = Some(1e-3);
        outcome.limited_error = Some(1e-3);
        outcome.allowed_error = 1e-4;
        outcome.tolerance_met = tolerance_met;
        Report {
            scene,
            model: "rpy",
            reasons: Vec::new(),
            outcome,
            neglected: Vec::new(),
            efficiency: None,
            stopped: None,
            seconds: 0.0,
        }
    }

    #[test]
    fn a_missed_tolerance_is_an_error_with_what_was_reached_unless_the_best_is_accepted() {
        assert!(report("tolerance", true).check_tolerance().is_ok());
        assert!(report("best", false).check_tolerance().is_ok());
        let missed = report("tolerance", false);
        let error = missed.check_tolerance().unwrap_err();
        assert_eq!(error.exit_code(), 3);
        let text = error.to_string();
        for part in ["is 1.0e-3", "1e-4 allows 1.0e-4", "accept = \"best\""] {
            assert!(text.contains(part), "{text}");
        }
        assert!(matches!(error, SwimError::ToleranceMissed { error, .. } if error == 1e-3));
        assert_eq!(missed.outcome.net(), 1.0);
    }
}
