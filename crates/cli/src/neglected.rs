//! Lines on what neglected terms cost, of `swim run` and `swim solve`.

use nalgebra::Vector3;
use swimmer::models::{InstantaneousSolution, NeglectedTerm};
use swimmer::scene::Domain;
use swimmer::{InertiaNumbers, Neglected, Report, Scene, fastest_body, mean_effect, resolved_net};

use super::text::{entry, percent, two_digits, warn};

/// Relative effect above which flow without a term is doubtful: at a Reynolds number of 0.5 the
/// first order overestimates effects of 10 % by a fifth to a half.
const LARGE: f64 = 0.1;

/// The lines of a run; empty where nothing is neglected.
pub fn of_run(report: &Report) -> String {
    let outcome = &report.outcome;
    let reference = Reference {
        name: "the net displacement",
        direction: outcome.net_vector(),
        size: resolved_net(outcome),
    };
    let mean = |effect: &[Vector3<f64>]| mean_effect(outcome, effect);
    let costs = report.neglected.iter();
    costs
        .map(|cost| lines(&report.scene, cost, &reference, mean))
        .collect()
}

/// The lines of a solution, of the body that moves fastest; empty where nothing is neglected.
pub fn of_solution(
    scene: &Scene,
    neglected: &[Neglected],
    solution: &InstantaneousSolution,
) -> String {
    let body = fastest_body(&solution.bodies).unwrap_or(0);
    let velocity = solution.bodies.get(body).map(|body| body.velocity);
    let velocity = velocity.unwrap_or_default();
    let name = scene.bodies().get(body).map_or("", |body| &body.name);
    let reference = Reference {
        name: &format!("the velocity of {name}"),
        direction: velocity,
        size: velocity.norm(),
    };
    let of_body = |effect: &[Vector3<f64>]| effect.get(body).copied().unwrap_or_default();
    let costs = neglected.iter();
    costs
        .map(|cost| lines(scene, cost, &reference, of_body))
        .collect()
}

/// A vector to which effects are compared.
struct Reference<'a> {
    name: &'a str,
    direction: Vector3<f64>,
    /// Its norm, zero if that is rounding or below its error bar.
    size: f64,
}

/// Reynolds number and frequency parameter in words.
pub fn inertia_words(numbers: &InertiaNumbers) -> String {
    let reynolds = format!("Re = {}", two_digits(numbers.reynolds));
    match numbers.frequency {
        Some(frequency) => format!("{reynolds}, S = {}", two_digits(frequency)),
        None => reynolds,
    }
}

/// What is neglected, and the effects along the reference and relative to it.
fn lines(
    scene: &Scene,
    neglected: &Neglected,
    reference: &Reference,
    vector: impl Fn(&[Vector3<f64>]) -> Vector3<f64>,
) -> String {
    let is_inertia = neglected.term == NeglectedTerm::Inertia;
    let label = match neglected.term {
        NeglectedTerm::Inertia => "neglected inertia",
        NeglectedTerm::Rheology => "neglected viscosity law",
    };
    let numbers = neglected.numbers.as_ref().map(inertia_words);
    let effect = match &neglected.effect {
        Ok(effect) => effect,
        Err(reason) => {
            let order = entry("  effect", expected(scene));
            return entry(
                label,
                numbers.unwrap_or_else(|| "effect not known".to_owned()),
            ) + if is_inertia { &order } else { "" }
                + &entry("  not computed", reason);
        }
    };
    let total = vector(&effect.total());
    // Without a direction of the motion, that of the effect.
    let is_resolved = reference.size > 0.0;
    let direction = match is_resolved {
        true => reference.direction,
        false => total,
    };
    let direction = direction.try_normalize(0.0).unwrap_or_else(Vector3::x);
    let what = match is_resolved {
        true => format!("change (relative to {})", reference.name),
        false => format!("change of {}", reference.name),
    };
    let what = numbers.map_or(what.clone(), |numbers| format!("{numbers}: {what}"));
    let value = |v: &Vector3<f64>| {
        let along = v.dot(&direction);
        match is_resolved && along != 0.0 {
            true => format!("{along:.1e} ({})", percent(along / reference.size)),
            false => format!("{along:.1e}"),
        }
    };
    let mut text = entry(label, what);
    for (part, vectors) in effect.parts() {
        let part = match part {
            "viscosity" => "at its shear rates",
            "second_order" => "second order in them",
            other => other,
        };
        text += &entry(&format!("  {part}"), value(&vector(vectors)));
    }
    if neglected.term.adds_up() {
        text += &entry("  sum", value(&total));
    }
    let largest = effect.largest(vector);
    if is_resolved && largest > LARGE * reference.size {
        let size = percent(largest / reference.size);
        let name = reference.name;
        warn(&match neglected.term {
            NeglectedTerm::Inertia => format!(
                "inertia would change {name} by {size} to first order, so that Stokes flow is no \
                 model of this scene; the density of the fluid is {}",
                scene.fluid_density(),
            ),
            NeglectedTerm::Rheology => format!(
                "the viscosity law would change {name} by {size} to first order, so that a \
                 constant viscosity is no model of this scene; set fluid.rheology = \"full\""
            ),
        });
    }
    text
}

/// The order of the leading effect, where it is not computed.
fn expected(scene: &Scene) -> &'static str {
    let is_forced =
        scene.has_loads() || scene.has_held_bodies() || scene.gravity() != Vector3::zeros();
    match (is_forced, scene.domain()) {
        (false, _) => "of the order of S and Re, as for all bodies without external forces",
        (true, Domain::Unbounded) => {
            "of the order of sqrt(S), as in Basset's force, and of Re, as in Oseen's correction"
        }
        (true, _) => "of the order of S and Re times the size of the container in radii",
    }
}
