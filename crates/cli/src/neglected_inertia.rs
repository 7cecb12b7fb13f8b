//! Lines on what neglecting inertia costs, of `swim run` and `swim solve`.

use nalgebra::Vector3;
use swimmer::models::InstantaneousSolution;
use swimmer::scene::Domain;
use swimmer::{InertiaNumbers, NeglectedInertia, Report, Scene, fastest_body, mean_effect};

use super::text::{entry, percent, two_digits, warn};

/// Relative effect of inertia above which Stokes flow is doubtful: at a Reynolds number of 0.5 the
/// first order overestimates effects of 10 % by a fifth to a half.
const LARGE: f64 = 0.1;

/// The lines of a run; empty for a fluid without density.
pub fn of_run(report: &Report) -> String {
    let Some(neglected) = &report.neglected_inertia else {
        return String::new();
    };
    let outcome = &report.outcome;
    let reference = Reference {
        name: "the net displacement",
        direction: outcome.net_vector(),
        size: outcome.resolved_net(),
    };
    lines(&report.scene, neglected, &reference, |effect| {
        mean_effect(outcome, effect)
    })
}

/// The lines of a solution, of the body that moves fastest; empty for a fluid without density.
pub fn of_solution(
    scene: &Scene,
    neglected: Option<&NeglectedInertia>,
    solution: &InstantaneousSolution,
) -> String {
    let Some(neglected) = neglected else {
        return String::new();
    };
    let body = fastest_body(&solution.bodies).unwrap_or(0);
    let velocity = solution.bodies.get(body).map(|body| body.velocity);
    let velocity = velocity.unwrap_or_default();
    let name = scene.bodies().get(body).map_or("", |body| &body.name);
    let reference = Reference {
        name: &format!("the velocity of {name}"),
        direction: velocity,
        size: velocity.norm(),
    };
    lines(scene, neglected, &reference, |effect| {
        effect.get(body).copied().unwrap_or_default()
    })
}

/// A vector to which effects are compared.
struct Reference<'a> {
    name: &'a str,
    direction: Vector3<f64>,
    /// Its norm, zero if that is rounding.
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

/// The numbers of the scene and the effects, along the reference and relative to it.
fn lines(
    scene: &Scene,
    neglected: &NeglectedInertia,
    reference: &Reference,
    vector: impl Fn(&[Vector3<f64>]) -> Vector3<f64>,
) -> String {
    let numbers = inertia_words(&neglected.numbers);
    let effect = match &neglected.effect {
        Ok(effect) => effect,
        Err(reason) => {
            return entry("neglected inertia", numbers)
                + &entry("  effect", expected(scene))
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
        true => format!("{numbers}: change (relative to {})", reference.name),
        false => format!("{numbers}: change of {}", reference.name),
    };
    let value = |v: &Vector3<f64>| {
        let along = v.dot(&direction);
        match is_resolved && along != 0.0 {
            true => format!("{along:.1e} ({})", percent(along / reference.size)),
            false => format!("{along:.1e}"),
        }
    };
    let mut text = entry("neglected inertia", what);
    for (cause, vectors) in effect.causes() {
        text += &entry(&format!("  {cause}"), value(&vector(vectors)));
    }
    text += &entry("  sum", value(&total));
    if is_resolved && total.norm() > LARGE * reference.size {
        warn(&format!(
            "inertia would change {} by {} to first order, so that Stokes flow is no model of this \
             scene; the density of the fluid is {}",
            reference.name,
            percent(total.norm() / reference.size),
            scene.fluid_density(),
        ));
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
