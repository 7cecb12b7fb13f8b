//! `swim new` and `swim check`: writes an example scene, validates a scene and predicts the cost of
//! its simulation.

use std::fs::OpenOptions;
use std::io::Write;
use std::path::PathBuf;

use swimmer::models::Configuration;
use swimmer::scene::closest_contact;
use swimmer::{
    Choice, NoiseNumbers, Scene, SwimError, TEMPLATES, TYPICAL_SOLVES_PER_SPAN, choose_for_run,
    spans,
};

use super::arguments::SceneArguments;
use super::error::CliError;
use super::progress::Waiting;
use super::text::{count, duration, entry};

pub fn check(arguments: &SceneArguments, quiet: bool) -> Result<String, CliError> {
    let scene = arguments.read(quiet)?;
    let mut text = describe(&scene)?;
    let waiting = Waiting::new("choosing the model", quiet);
    let Choice {
        mut model, reasons, ..
    } = choose_for_run(&scene, &mut &waiting)?;
    text += &entry("model", model.name());
    for reason in &reasons {
        text += &entry("  reason", reason);
    }
    if let Some(planes) = symmetry_planes(&scene).filter(|_| model.capabilities().has_mesh) {
        text += &entry("symmetry planes", &planes);
    }
    let state = scene.initial_state();
    let shape = scene.articulation().initial_shape();
    waiting.says("predicting the cost of a solve");
    let cost = model.cost(Configuration::new(&state, shape))?;
    drop(waiting);
    text += &entry("degrees of freedom", cost.dofs.total);
    let seconds = duration(cost.seconds);
    let cost_of_solve = match cost.mib.ceil() {
        // Where nothing as large as a matrix is stored, nothing is predicted.
        0.0 => format!("{seconds} (estimate)"),
        mib => format!("{seconds}, {mib:.0} MiB (estimate)"),
    };
    text += &entry("cost per solve", cost_of_solve);
    let solves = TYPICAL_SOLVES_PER_SPAN * scene.gait().phases.len() * scene.gait().cycles as usize;
    if let Some(noise) = NoiseNumbers::new(&scene)? {
        let NoiseNumbers {
            steps, time_step, ..
        } = noise;
        // Two solutions and the random loads, which take about as long as one.
        let seconds = duration(3.0 * cost.seconds * steps as f64);
        let cost =
            format!("{steps} steps of thermal noise of {time_step:.3e}, {seconds} (estimate)");
        text += &entry("cost of the gait", cost);
    } else if scene.inertia().is_kept() {
        let steps = "one solve per step in time, whose error decides on its length";
        text += &entry("cost of the gait", steps);
    } else if solves > 0 {
        let seconds = duration(cost.seconds * solves as f64);
        let cost = format!("{solves} solves, {seconds} (estimate, without mesh generation)");
        text += &entry("cost of the gait", cost);
    }
    Ok(text)
}

/// The symmetry planes of a scene and whether the finite-element model uses them.
fn symmetry_planes(scene: &Scene) -> Option<String> {
    let words = |planes: [bool; 3]| {
        let normals: Vec<&str> = ["x", "y", "z"]
            .into_iter()
            .zip(planes)
            .filter_map(|(name, plane)| plane.then_some(name))
            .collect();
        let part = ["", "one half", "one quarter", "one eighth"][normals.len()];
        (!normals.is_empty()).then(|| (normals.join(" and "), part))
    };
    match (
        words(scene.fem_symmetry_planes()),
        words(scene.symmetry_planes()),
    ) {
        (Some((normals, part)), _) => Some(format!(
            "normal to {normals}; {part} of the fluid is meshed"
        )),
        (None, Some((normals, _))) => Some(format!(
            "normal to {normals}, not used (fem.symmetry = \"auto\" uses them)"
        )),
        (None, None) => None,
    }
}

/// The size of the scene and of its gait.
fn describe(scene: &Scene) -> Result<String, CliError> {
    let (set, gait) = (scene.articulation(), scene.gait());
    let bodies = match scene.bodies().len() {
        1 => "1 body".to_owned(),
        bodies => format!("{bodies} bodies"),
    };
    let deformations = set
        .joints()
        .iter()
        .filter(|joint| joint.kind.is_deformation());
    let deformations = deformations.count();
    let links = count(set.joints().len() - deformations, "link");
    let coordinates = match deformations {
        0 => String::new(),
        some => format!(", {}", count(some, "shape coordinate")),
    };
    let mut text = entry("scene", scene.name())
        + &entry("  size", format!("{bodies}, {links}{coordinates}"))
        + &entry("  domain", scene.domain().kind().word())
        + &entry("  viscosity", scene.viscosity());
    if gait.phases.is_empty() {
        return Ok(text + &entry("gait", "none (swim solve computes the initial velocities)"));
    }
    let phases = count(gait.phases.len(), "phase");
    let cycles = count(gait.cycles as usize, "cycle");
    let motion = format!("{phases}, {cycles}, duration {}", gait.duration());
    text += &entry("gait", motion);
    // Several swimmers move apart or together meanwhile: only their start is known.
    let (shapes, when) = match set.linkages().len() > 1 {
        true => (vec![set.initial_shape().to_vec()], "at the start"),
        false => {
            let spans = spans(gait, set.initial_shape())?.take(gait.phases.len());
            (spans.map(|span| span.to).collect(), "at the ends of phases")
        }
    };
    let mut gap = f64::INFINITY;
    for shape in shapes {
        let poses = set
            .place(&scene.initial_state(), &shape)
            .map_err(SwimError::from)?;
        let contact = closest_contact(&scene.bodies_at(&shape), scene.domain(), &poses);
        gap = gap.min(contact.map_or(gap, |contact| contact.gap));
    }
    if gap.is_finite() {
        text += &entry("  smallest gap", format!("{gap:.4} {when}"));
    }
    Ok(text)
}

/// The names of the example scenes, each with the first sentence of its file.
pub fn examples() -> String {
    let describe = |(name, text): &(&str, &str)| {
        let comment = text.lines().take_while(|line| line.starts_with('#'));
        let words: Vec<&str> = comment
            .map(|line| line.trim_start_matches(['#', ' ']))
            .collect();
        let words = words.join(" ");
        // A sentence ends where a capital letter follows: not at "et al. (2010)".
        let mut ends = words.match_indices(". ").map(|(at, _)| at + 1);
        let end = ends.find(|&at| words[at..].trim_start().starts_with(char::is_uppercase));
        entry(name, &words[..end.unwrap_or(words.len())])
    };
    TEMPLATES.iter().map(describe).collect()
}

/// Writes an example scene to a file that must not exist yet.
pub fn new(name: &str, out: Option<PathBuf>) -> Result<String, CliError> {
    let Some((_, text)) = TEMPLATES.iter().find(|(known, _)| *known == name) else {
        let known: Vec<&str> = TEMPLATES.iter().map(|(known, _)| *known).collect();
        return Err(CliError::NotApplicable {
            place: format!("swim new {name}"),
            problem: format!("unknown example; choose one of {}", known.join(", ")),
        });
    };
    let path = out.unwrap_or_else(|| PathBuf::from(format!("{name}.toml")));
    let written = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&path)
        .and_then(|mut file| {
            file.write_all(text.as_bytes()).inspect_err(|_| {
                // No half of a scene stays.
                let _ = std::fs::remove_file(&path);
            })
        });
    written.map_err(|source| SwimError::Write {
        path: path.clone(),
        source,
    })?;
    let path = path.display();
    let command = match name {
        "optimal-stroke" => "optimise",
        "learning" => "learn",
        _ => "run",
    };
    Ok(entry("scene file", &path) + &entry("next", format!("swim {command} {path}")))
}
