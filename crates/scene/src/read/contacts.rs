//! Checks that bodies do not touch: in the initial configuration and along the whole stroke.

use nalgebra::{Isometry3, Vector3};

use crate::contact::{Contact, closest_contact, smallest_gap};
use crate::error::SceneError;
use crate::gait::{Gait, spans};
use crate::phase_span::PhaseSpan;
use crate::scene::Scene;

/// Refuses bodies that touch each other or a wall in the initial configuration.
pub(super) fn check_initial(scene: &Scene) -> Result<(), SceneError> {
    let poses = scene
        .articulation
        .place(&scene.initial_state(), scene.articulation.initial_shape())?;
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
/// Their relative positions depend on the values of the joints alone, so that no flow is needed
/// unless it determines some of them.
pub(super) fn check_stroke(scene: &Scene) -> Result<(), SceneError> {
    if scene.has_passive_joints() {
        return Ok(());
    }
    // All cycles after the second one repeat the shapes of the second one.
    let gait = Gait {
        cycles: scene.gait.cycles.min(2),
        phases: scene.gait.phases.clone(),
    };
    spans(&gait, scene.articulation.initial_shape())?.try_for_each(|span| check_span(scene, &span))
}

/// Number of lines that stand for the curved path of a phase span.
const PARTS_OF_CURVE: u32 = 64;

fn check_span(scene: &Scene, span: &PhaseSpan) -> Result<(), SceneError> {
    let set = &scene.articulation;
    let length_key = match (&scene.gait_table, span.is_linear()) {
        (Some(_), _) => "gait.file".to_owned(),
        (None, true) => format!("gait.phases[{}].length", span.phase),
        (None, false) => "gait.harmonics".to_owned(),
    };
    // Lines stand for the values along a curved path, which they leave by a ten-thousandth.
    let joints = scene.articulation.joints();
    let turns = span.joints.iter().any(|&joint| joints[joint].kind.turns());
    let parts: u32 = match span.is_linear() && !turns {
        true => 1,
        false => PARTS_OF_CURVE,
    };
    let state = scene.initial_state();
    let place = |lengths: &[f64]| {
        set.place(&state, lengths)
            .map_err(|error| SceneError::BadValue {
                place: scene.place(&length_key),
                key: length_key.clone(),
                problem: format!("fails: {error}"),
            })
    };
    for part in 0..parts {
        let at = |k: u32| f64::from(k) / f64::from(parts);
        let (begin, end) = (at(part), at(part + 1));
        let to = place(&span.shape(end))?;
        // Lines do not follow bodies that turn: these are checked at points of the phase span.
        let from = match turns {
            true => to.clone(),
            false => place(&span.shape(begin))?,
        };
        check_part(scene, span, &length_key, (begin, &from), (end, &to))?;
    }
    Ok(())
}

/// Refuses contact on the line between two placements at two positions of a phase span.
fn check_part(
    scene: &Scene,
    span: &PhaseSpan,
    length_key: &str,
    (begin, from): (f64, &[Isometry3<f64>]),
    (end, to): (f64, &[Isometry3<f64>]),
) -> Result<(), SceneError> {
    for linkage in scene.articulation.linkages() {
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
                let (s, gap) = smallest_gap(pair, &apart(from), &apart(to));
                let size = (pair.iter())
                    .map(|(shape, _)| shape.bounding_radius())
                    .sum();
                let contact = Contact {
                    body: other,
                    other: Some(one),
                    gap,
                };
                if contact.touches(size) {
                    let s = begin + s * (end - begin);
                    return Err(SceneError::Touching {
                        place: scene.place(length_key),
                        first: scene.bodies[other].name.clone(),
                        second: scene.bodies[one].name.clone(),
                        when: format!("in phase {} at {:.0} % of it", span.phase + 1, 100.0 * s),
                        gap: contact.gap,
                        remedy: "let the link change less",
                    });
                }
            }
        }
    }
    Ok(())
}
