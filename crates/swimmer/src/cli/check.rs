//! `swim check`: what would happen, without doing it.

use std::fmt::Write;

use swimmer::models::Configuration;
use swimmer::scene::closest_contact;
use swimmer::{Choice, Scene, SwimError, choose, legs};

use super::{SceneArguments, duration};

/// Solves that a phase usually takes: rungs of one, two and three points.
const SOLVES_A_PHASE: usize = 6;

pub fn check(arguments: &SceneArguments) -> Result<String, SwimError> {
    let scene = arguments.read()?;
    let mut text = describe(&scene)?;
    let Choice { mut model, reasons } = choose(&scene)?;
    let mut line = |content: String| {
        text.push_str(&content);
        text.push('\n');
    };
    line(format!("model: {}: {}", model.name(), reasons.join("; ")));
    if let Some(mirrors) = mirrors(&scene).filter(|_| model.name() == "fem") {
        line(mirrors);
    }
    let lengths = scene.articulation().initial_lengths();
    let cost = model.cost(Configuration {
        state: &scene.initial_state(),
        lengths,
    })?;
    line(format!(
        "cost: {} unknowns, about {} and {:.0} MiB a solve",
        cost.dofs.total,
        duration(cost.seconds),
        cost.mib,
    ));
    let solves = SOLVES_A_PHASE * scene.gait().phases.len() * scene.gait().cycles as usize;
    if solves > 0 {
        let seconds = duration(cost.seconds * solves as f64);
        line(format!(
            "about {solves} solves for the gait, {seconds} and the meshes"
        ));
    }
    Ok(text)
}

/// What mirror planes a scene has and whether they are used.
fn mirrors(scene: &Scene) -> Option<String> {
    let words = |planes: [bool; 3]| {
        let normals: Vec<&str> = ["x", "y", "z"]
            .into_iter()
            .zip(planes)
            .filter_map(|(name, plane)| plane.then_some(name))
            .collect();
        let part = ["", "a half", "a quarter", "an eighth"][normals.len()];
        (!normals.is_empty()).then(|| (normals.join(" and "), part))
    };
    match (
        words(scene.fem_symmetry_planes()),
        words(scene.symmetry_planes()),
    ) {
        (Some((normals, part)), _) => Some(format!(
            "mirror planes normal to {normals}: {part} of the fluid is meshed"
        )),
        (None, Some((normals, _))) => Some(format!(
            "mirror planes normal to {normals}, not used: fem.mirror = \"auto\" would"
        )),
        (None, None) => None,
    }
}

fn describe(scene: &Scene) -> Result<String, SwimError> {
    let set = scene.articulation();
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = writeln!(
        text,
        "{}: {} bodies, {} links, {} domain, viscosity {}",
        scene.name(),
        scene.bodies().len(),
        set.links().len(),
        scene.domain().kind().word(),
        scene.viscosity(),
    );
    if scene.gait().phases.is_empty() {
        text.push_str("no gait: one instant can be solved\n");
        return Ok(text);
    }
    let mut gap = f64::INFINITY;
    for leg in legs(scene.gait(), set.initial_lengths()).take(scene.gait().phases.len()) {
        let poses = set.place(&scene.initial_state(), &leg.to)?;
        gap = gap.min(
            closest_contact(scene.bodies(), scene.domain(), &poses)
                .map_or(gap, |contact| contact.gap),
        );
    }
    let _ = writeln!(
        text,
        "gait: {} phases, {} cycles, duration {}{}",
        scene.gait().phases.len(),
        scene.gait().cycles,
        scene.gait().duration(),
        if gap.is_finite() {
            format!(", smallest gap at the end of a phase {gap:.4}")
        } else {
            String::new()
        },
    );
    Ok(text)
}
