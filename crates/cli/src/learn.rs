//! `swim learn`: what reinforcement learning finds, compared with the best possible cycle.

use design::learn::{LearnedStroke, learn_stroke};
use pictures::{Policy, learning_curve_svg, policy_svg};
use swimmer::output::Folder;

use super::arguments::DesignArguments;
use super::design_files::{folder_of, write};
use super::error::CliError;
use super::progress::DesignSpinner;
use super::text::{count, entry, measured, two_digits, warn};

pub fn learn_strokes(arguments: DesignArguments, quiet: bool) -> Result<String, CliError> {
    let DesignArguments { scene, out, json } = arguments;
    let scene = scene.read(quiet)?;
    let (folder, _lock) = folder_of(&scene, out)?;
    let options = scene.learn();
    let found = learn_stroke(&scene, &mut DesignSpinner::new(quiet))?;
    draw(&folder, &found)?;
    if !found.is_optimal() {
        let [gained, possible] =
            [&found.cycle, &found.best].map(|cycle| two_digits(cycle.per_step()));
        warn(&format!(
            "the learned policy gains {gained} per step, the best cycle {possible}; increase \
             learn.discount = {}, learn.episodes or learn.exploration",
            options.discount,
        ));
    }
    let answer = found.json();
    write(&folder, "learned.json", &format!("{answer:#}\n"))?;
    if json {
        return Ok(format!("{answer}\n"));
    }
    let mut text = entry("scene", scene.name()) + &entry("model", found.rewards.model);
    let method = format!(
        "{}, {} of {}, discount {}, seed {}",
        options.method.word(),
        count(options.episodes as usize, "episode"),
        count(options.steps as usize, "step"),
        options.discount,
        options.seed
    );
    text += &entry("method", method);
    for (label, cycle) in [("learned", &found.cycle), ("best possible", &found.best)] {
        let error = found.rewards.error;
        text += &entry(label, found.state_names(cycle).join(" -> "));
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
fn draw(folder: &Folder, found: &LearnedStroke) -> Result<(), CliError> {
    let (rewards, learned) = (&found.rewards, &found.learned);
    let curve = learning_curve_svg(&learned.curve, found.best.per_step())?;
    write(folder, "learning.svg", &curve)?;
    let names: Vec<String> = (0..rewards.states()).map(|k| rewards.name(k)).collect();
    let policy = policy_svg(&Policy {
        names: &names,
        actions: &learned.policy,
        cycle: &found.cycle.states,
    })?;
    write(folder, "policy.svg", &policy)
}
