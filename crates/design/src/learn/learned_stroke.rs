//! What learning finds for a scene, compared with the best possible cycle.

use scene::Scene;
use serde_json::{Value, json};

use super::ArmStates;
use super::cycle::{Cycle, best_cycle, greedy_cycle};
use super::q_learning::{Learned, LearningOptions, learn};
use super::rewards::{Rewards, rewards};
use crate::error::{DesignError, DesignProgress};

/// Relative difference of mean rewards that is rounding.
const ROUNDING: f64 = 1e-9;

/// A learned cycle of steps, and the best one.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct LearnedStroke {
    /// Displacements of all steps.
    pub rewards: Rewards,
    /// Values of actions, policy and learning curve.
    pub learned: Learned,
    /// The cycle of the learned policy.
    pub cycle: Cycle,
    /// The cycle of the largest mean displacement of a step.
    pub best: Cycle,
}

/// Learns a stroke by the group `learn` of a scene, and finds the best possible one.
///
/// # Errors
/// Those of [`rewards`].
pub fn learn_stroke(
    scene: &Scene,
    progress: &mut dyn DesignProgress,
) -> Result<LearnedStroke, DesignError> {
    let rewards = rewards(scene, progress)?;
    let learned = learn(
        &mut ArmStates::new(&rewards),
        &LearningOptions::from(scene.learn()),
    );
    Ok(LearnedStroke {
        cycle: greedy_cycle(&rewards, &learned.policy),
        best: best_cycle(&rewards),
        learned,
        rewards,
    })
}

impl LearnedStroke {
    /// Whether the learned cycle moves as far per step as the best one.
    pub fn is_optimal(&self) -> bool {
        let [found, best] = [&self.cycle, &self.best].map(Cycle::per_step);
        found >= best - ROUNDING * best.abs()
    }

    /// Names of the states of a cycle ([`Rewards::name`]).
    pub fn state_names(&self, cycle: &Cycle) -> Vec<String> {
        cycle.states.iter().map(|&k| self.rewards.name(k)).collect()
    }

    /// The result as in `learned.json` of the command line.
    pub fn json(&self) -> Value {
        let of_cycle = |cycle: &Cycle| {
            let actions = cycle.actions.iter().map(|&k| &self.rewards.names[k][..]);
            json!({
                "policy": self.state_names(cycle),
                "actions": actions.collect::<Vec<_>>(),
                "per_step": cycle.per_step(),
                "per_cycle": cycle.per_cycle,
            })
        };
        let mut answer = of_cycle(&self.cycle);
        for (key, value) in [
            ("model", json!(self.rewards.model)),
            ("joints", json!(self.rewards.names)),
            ("optimum", of_cycle(&self.best)),
            ("is_optimal", json!(self.is_optimal())),
            ("reward_error", json!(self.rewards.error)),
            ("curve", json!(self.learned.curve)),
            ("values", json!(self.learned.values)),
        ] {
            answer[key] = value;
        }
        answer
    }
}
