//! Checks that bodies do not touch: in the initial configuration and along the whole stroke.

use nalgebra::{Isometry3, Vector3};

use crate::contact::{Contact, closest_contact, smallest_gap};
use crate::error::SceneError;
use crate::gait::{Gait, Leg, legs};
use crate::scene::Scene;

/// Refuses bodies that touch each other or a wall in the initial configuration.
pub(super) fn check_initial(scene: &Scene) -> Result<(), SceneError> {
    let poses = scene
        .articulation
        .place(&scene.initial_state(), scene.articulation.initial_lengths())?;
    let Some(contact) = closest_contact(&scene.bodies, &scene.domain, &poses) else {
        return Ok(());
    };
    let size = scene.bodies[contact.body].bounding_radius();
    if !contact.touches(size) {
        return Ok(());
    }
    let name = |body: usize| scene.bodies[body].name.clone();
    Err(match contact.other {
        Some(other) => SceneError::Touching {
            place: scene.place(&format!("bodies[{other}].position")),
            first: name(contact.body),
            second: name(other),
            when: "at the start".to_owned(),
            gap: contact.gap,
            remedy: "move them apart or make them smaller",
        },
        None => SceneError::OutsideDomain {
            place: scene.place(&format!("bodies[{}].position", contact.body)),
            body: name(contact.body),
            clearance: contact.gap,
        },
    })
}

/// Refuses a gait along which bodies of one linkage touch.
///
/// Their relative positions depend on the lengths of the links alone, so that no flow is needed.
pub(super) fn check_stroke(scene: &Scene) -> Result<(), SceneError> {
    // All cycles after the second one repeat the lengths of the second one.
    let gait = Gait {
        cycles: scene.gait.cycles.min(2),
        phases: scene.gait.phases.clone(),
    };
    legs(&gait, scene.articulation.initial_lengths())?.try_for_each(|leg| check_leg(scene, &leg))
}

fn check_leg(scene: &Scene, leg: &Leg) -> Result<(), SceneError> {
    let set = &scene.articulation;
    let length_key = format!("gait.phases[{}].length", leg.phase);
    let state = scene.initial_state();
    let place = |lengths: &[f64]| {
        set.place(&state, lengths)
            .map_err(|error| SceneError::BadValue {
                place: scene.place(&length_key),
                key: length_key.clone(),
                problem: format!("fails: {error}"),
            })
    };
    let (from, to) = (place(&leg.from)?, place(&leg.to)?);
    for linkage in set.linkages() {
        let solid = linkage
            .bodies
            .iter()
            .copied()
            .filter(|&body| scene.bodies[body].bounding_radius() > 0.0);
        let solid: Vec<usize> = solid.collect();
        for (k, &one) in solid.iter().enumerate() {
            for &other in &solid[..k] {
                let apart = |poses: &[Isometry3<f64>]| -> Vector3<f64> {
                    poses[one].translation.vector - poses[other].translation.vector
                };
                let pair = [one, other].map(|b| (&scene.bodies[b].shape, &from[b].rotation));
                let (s, gap) = smallest_gap(pair, &apart(&from), &apart(&to));
                let size = (pair.iter())
                    .map(|(shape, _)| shape.bounding_radius())
                    .sum();
                let contact = Contact {
                    body: other,
                    other: Some(one),
                    gap,
                };
                if contact.touches(size) {
                    return Err(SceneError::Touching {
                        place: scene.place(&length_key),
                        first: scene.bodies[other].name.clone(),
                        second: scene.bodies[one].name.clone(),
                        when: format!("in phase {} at {:.0} % of it", leg.phase + 1, 100.0 * s),
                        gap: contact.gap,
                        remedy: "let the link keep more of its length",
                    });
                }
            }
        }
    }
    Ok(())
}
