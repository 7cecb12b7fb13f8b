//! `swim learn`: what reinforcement learning finds, compared with the best possible cycle.

use design::learn::{
    ArmStates, Cycle, Learned, LearningOptions, Rewards, best_cycle, greedy_cycle, learn, rewards,
};
use pictures::{Policy, learning_curve_svg, policy_svg};
use serde_json::{Value, json};
use swimmer::output::Folder;

use super::arguments::DesignArguments;
use super::design_files::{folder_of, write};
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::{count, entry, measured, two_digits, warn};

pub fn learn_strokes(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read()?;
    let (folder, _lock) = folder_of(&scene, out)?;
    let options = scene.learn();
    let rewards = rewards(&scene, &mut DesignSpinner::new(quiet))?;
    let learned = learn(
        &mut ArmStates::new(&rewards),
        &LearningOptions::from(options),
    );
    let cycle = greedy_cycle(&rewards, &learned.policy);
    let best = best_cycle(&rewards);
    draw(&folder, &rewards, &learned, &cycle, &best)?;
    let is_optimal = cycle.per_step() >= best.per_step() - 1e-9 * best.per_step().abs();
    if !is_optimal {
        let [gained, possible] = [&cycle, &best].map(|cycle| two_digits(cycle.per_step()));
        warn(&format!(
            "the learned policy gains {gained} per step, the best cycle {possible}; increase \
             learn.discount = {}, learn.episodes or learn.exploration",
            options.discount,
        ));
    }
    let mut answer = cycle_json(&rewards, &cycle);
    for (key, value) in [
        ("model", json!(rewards.model)),
        ("joints", json!(rewards.names)),
        ("optimum", cycle_json(&rewards, &best)),
        ("is_optimal", json!(is_optimal)),
        ("reward_error", json!(rewards.error)),
        ("curve", json!(learned.curve)),
        ("values", json!(learned.values)),
    ] {
        answer[key] = value;
    }
    write(&folder, "learned.json", &format!("{answer:#}\n"))?;
    if json {
        return Ok(format!("{answer}\n"));
    }
    let mut text = entry("scene", scene.name()) + &entry("model", rewards.model);
    let method = format!(
        "{}, {} of {}, discount {}, seed {}",
        options.method.word(),
        count(options.episodes as usize, "episode"),
        count(options.steps as usize, "step"),
        options.discount,
        options.seed
    );
    text += &entry("method", method);
    for (label, cycle) in [("learned", &cycle), ("best possible", &best)] {
        let error = rewards.error;
        text += &entry(label, state_names(&rewards, cycle).join(" -> "));
        text += &measured("  per step", cycle.per_step(), error);
        text += &measured(
            "  per cycle",
            cycle.per_cycle,
            error * cycle.states.len() as f64,
        );
    }
    Ok(text + &entry("results", folder.path().display()))
}

/// Draws the learning curve and the policy.
fn draw(
    folder: &Folder,
    rewards: &Rewards,
    learned: &Learned,
    cycle: &Cycle,
    best: &Cycle,
) -> Result<(), CliError> {
    let curve = learning_curve_svg(&learned.curve, best.per_step())?;
    write(folder, "learning.svg", &curve)?;
    let names: Vec<String> = (0..rewards.states()).map(|k| rewards.name(k)).collect();
    let policy = policy_svg(&Policy {
        names: &names,
        actions: &learned.policy,
        cycle: &cycle.states,
    })?;
    write(folder, "policy.svg", &policy)
}

fn state_names(rewards: &Rewards, cycle: &Cycle) -> Vec<String> {
    cycle.states.iter().map(|&k| rewards.name(k)).collect()
}

fn cycle_json(rewards: &Rewards, cycle: &Cycle) -> Value {
    let actions = cycle.actions.iter().map(|&k| &rewards.names[k][..]);
    json!({
        "policy": state_names(rewards, cycle),
        "actions": actions.collect::<Vec<_>>(),
        "per_step": cycle.per_step(),
        "per_cycle": cycle.per_cycle,
    })
}
