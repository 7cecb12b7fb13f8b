//! `swim learn`: what reinforcement learning finds, beside the best possible cycle.

use design::learn::{ArmStates, LearningOptions, best_cycle, greedy_cycle, learn, rewards};
use serde_json::json;
use swimmer::scene::LearnKind;

use super::arguments::DesignArguments;
use super::design_files::{folder_of, write};
use super::design_progress::Progress;
use super::error::CliError;
use super::text::{count, entry, two_digits, warn, with_uncertainty};

pub fn learn_strokes(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read()?;
    let options = scene.learn();
    let rewards = rewards(&scene, &mut Progress::new(quiet))?;
    let learned = learn(
        &mut ArmStates::new(&rewards),
        &LearningOptions {
            is_double: options.method == LearnKind::DoubleQ,
            episodes: options.episodes as usize,
            steps: options.steps as usize,
            discount: options.discount,
            rate: options.rate,
            exploration: options.exploration,
            seed: u64::from(options.seed),
        },
    );
    let cycle = greedy_cycle(&rewards, &learned.policy);
    let best = best_cycle(&rewards);
    let folder = folder_of(&scene, out)?;
    {
        use pictures::{Policy, learning_curve_svg, policy_svg};
        let curve = learning_curve_svg(&learned.curve, best.per_step())?;
        write(&folder, "learning.svg", &curve)?;
        let names: Vec<String> = (0..rewards.states())
            .map(|state| rewards.name(state))
            .collect();
        let policy = policy_svg(&Policy {
            names: &names,
            actions: &learned.policy,
            cycle: &cycle.states,
        })?;
        write(&folder, "policy.svg", &policy)?;
    }
    let states = |states: &[usize]| -> Vec<String> {
        states.iter().map(|&state| rewards.name(state)).collect()
    };
    let actions = |actions: &[usize]| -> Vec<String> {
        actions
            .iter()
            .map(|&action| rewards.names[action].clone())
            .collect()
    };
    let is_optimal = cycle.per_step() >= best.per_step() - 1e-9 * best.per_step().abs();
    if !is_optimal {
        warn(&format!(
            "the learned policy gains {} per step, the best cycle {}; increase learn.discount = \
             {}, learn.episodes or learn.exploration",
            two_digits(cycle.per_step()),
            two_digits(best.per_step()),
            options.discount,
        ));
    }
    let answer = json!({
        "model": rewards.model,
        "joints": rewards.names,
        "policy": states(&cycle.states),
        "actions": actions(&cycle.actions),
        "per_step": cycle.per_step(),
        "per_cycle": cycle.per_cycle,
        "optimum": {
            "policy": states(&best.states),
            "actions": actions(&best.actions),
            "per_step": best.per_step(),
            "per_cycle": best.per_cycle,
        },
        "is_optimal": is_optimal,
        "reward_error": rewards.error,
        "curve": learned.curve,
        "values": learned.values,
    });
    write(&folder, "learned.json", &format!("{answer:#}\n"))?;
    if json {
        return Ok(format!("{answer}\n"));
    }
    let mut text = entry("scene", scene.name());
    text += &entry("model", rewards.model);
    text += &entry(
        "method",
        &format!(
            "{}, {} of {}, discount {}, seed {}",
            options.method.word(),
            count(options.episodes as usize, "episode"),
            count(options.steps as usize, "step"),
            options.discount,
            options.seed
        ),
    );
    for (label, cycle) in [("learned", &cycle), ("best possible", &best)] {
        text += &entry(label, &states(&cycle.states).join(" -> "));
        text += &entry(
            "  per step",
            &with_uncertainty(cycle.per_step(), rewards.error),
        );
        text += &entry(
            "  per cycle",
            &with_uncertainty(cycle.per_cycle, rewards.error * cycle.states.len() as f64),
        );
    }
    text += &entry("results", &folder.path().display().to_string());
    Ok(text)
}
