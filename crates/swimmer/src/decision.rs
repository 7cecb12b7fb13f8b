//! Decisions about terms of the equations that a scene neglects while the tolerance allows it.

use models::{Hydrodynamics, InstantaneousSolution, NeglectedTerm};
use nalgebra::Vector3;
use scene::Scene;

use crate::error::SwimError;
use crate::neglected::{
    Neglected, fastest_body, is_automatic, mean_effect, start_neglected, with_term,
};
use crate::observer::Progress;
use crate::outcome::Outcome;
use crate::planning::ModelOfScene;
use crate::start::solve_start;

/// Whether the effect of a neglected term is so large that the term is kept.
pub(crate) struct Decision {
    pub keeps: bool,
    pub reason: String,
}

/// Largest Reynolds number at which the first-order effect of inertia is trusted: of squirmers it
/// is within 5 % of the true one at 0.1, and within a factor of 1.7 at 1.
const MAX_REYNOLDS: f64 = 0.5;

impl Decision {
    /// The decision after a completed run without a term, by what that costs.
    pub fn after_run(
        term: NeglectedTerm,
        costs: &[Neglected],
        scene: &Scene,
        outcome: &Outcome,
    ) -> Self {
        let left = outcome.allowed_error - outcome.limited_error.unwrap_or(0.0);
        let of = |effect: &[Vector3<f64>]| mean_effect(outcome, effect);
        Self::new(term, (costs, scene), left, "the net displacement", of)
    }

    /// The decision after a solution without a term, by its effect on the fastest body.
    fn after_solution(
        term: NeglectedTerm,
        costs: &[Neglected],
        scene: &Scene,
        solution: &InstantaneousSolution,
    ) -> Self {
        let body = fastest_body(&solution.bodies).unwrap_or(0);
        let velocity = |list: &[Vector3<f64>]| list.get(body).copied().unwrap_or_default();
        let velocities: Vec<_> = solution.bodies.iter().map(|body| body.velocity).collect();
        let allowed = scene.model().tolerance * velocity(&velocities).norm();
        let left = allowed - solution.error_estimate.total();
        Self::new(term, (costs, scene), left, "the largest velocity", velocity)
    }

    fn new(
        term: NeglectedTerm,
        (costs, scene): (&[Neglected], &Scene),
        left: f64,
        result: &str,
        of: impl Fn(&[Vector3<f64>]) -> Vector3<f64>,
    ) -> Self {
        let name = term.name();
        if scene
            .bodies()
            .iter()
            .all(|body| body.held_velocity().is_some())
        {
            let reason = "the velocities of all bodies are given, and its effect on forces is not \
                          known";
            return Self {
                keeps: true,
                reason: format!("{name} kept: {reason}"),
            };
        }
        let cost = costs.iter().find(|cost| cost.term == term);
        let numbers = cost.and_then(|cost| cost.numbers.as_ref());
        let reynolds = numbers.map(|numbers| numbers.reynolds);
        let (keeps, reason) = match cost.map(|cost| &cost.effect) {
            Some(Ok(effect)) => {
                let change = effect.largest(of);
                let at = reynolds.map_or(String::new(), |re| format!(", Re = {re:.1e}"));
                let words = format!(
                    "{name} would change {result} by {change:.1e} to first order, the tolerance \
                     leaves {left:.1e}{at}"
                );
                let is_large = reynolds.is_some_and(|reynolds| reynolds > MAX_REYNOLDS);
                (change > left || is_large, words)
            }
            Some(Err(unknown)) => {
                let words = format!("the effect of {name} is not known: {unknown}");
                (true, words)
            }
            None => (false, "the fluid has no density".to_owned()),
        };
        let decision = if keeps { "kept" } else { "neglected" };
        Self {
            keeps,
            reason: format!("{name} {decision}: {reason}"),
        }
    }
}

/// The instantaneous solution at the start of a scene whose viscosity law is decided.
pub struct StartSolution {
    /// The scene; with `fluid.rheology = "full"` if the law was kept.
    pub scene: Scene,
    /// The model of the solution.
    pub model: Box<dyn Hydrodynamics>,
    /// The solution.
    pub solution: InstantaneousSolution,
    /// What neglected terms cost, if the decision to neglect the law needed it.
    pub neglected: Option<Vec<Neglected>>,
    /// Why `fluid.rheology = "auto"` kept or neglected the law; none for another value.
    pub decision: Option<String>,
}

/// The solution at the start, as by [`solve_start`], with a model of the caller's choice.
///
/// With `fluid.rheology = "auto"` it is one at constant viscosity, if the viscosity law would
/// change the largest velocity by less than the tolerance leaves, and else one that follows the
/// law.
///
/// # Errors
/// As [`solve_start`]; those of `model`.
pub fn solve_start_with_terms(
    scene: Scene,
    model: ModelOfScene,
    progress: &mut dyn Progress,
) -> Result<StartSolution, SwimError> {
    let solve = |scene: Scene, decision: Option<String>, progress: &mut dyn Progress| {
        let mut model = model(&scene, progress)?.model;
        let solution = solve_start(&scene, model.as_mut())?;
        Ok::<_, SwimError>(StartSolution {
            scene,
            model,
            solution,
            neglected: None,
            decision,
        })
    };
    let mut start = solve(scene, None, progress)?;
    let term = NeglectedTerm::Rheology;
    if !is_automatic(&start.scene, term) {
        return Ok(start);
    }
    progress.works("what the viscosity law would change", 0.0, 0.0);
    let bodies = &start.solution.bodies;
    let costs = start_neglected(&start.scene, start.model.as_mut(), bodies)?;
    let decision = Decision::after_solution(term, &costs, &start.scene, &start.solution);
    if decision.keeps {
        return solve(
            with_term(&start.scene, term)?,
            Some(decision.reason),
            progress,
        );
    }
    (start.neglected, start.decision) = (Some(costs), Some(decision.reason));
    Ok(start)
}
