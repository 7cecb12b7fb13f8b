//! Checks that bodies do not touch: in the initial configuration and along the whole stroke.

use nalgebra::Isometry3;
use rigid::{Articulation, Freedom, Joint, RigidError, StateBounds};

use crate::contact::{Contact, closest_contact, contacts};
use crate::deformation::Deformation;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::gait::{Gait, spans};
use crate::path_contact::{BodyPath, first_contact_among};
use crate::phase_span::PhaseSpan;
use crate::scene::Scene;

/// Refuses bodies that touch each other or a wall in the initial configuration.
pub(super) fn check_initial(scene: &Scene) -> Result<(), SceneError> {
    let poses = scene
        .articulation
        .place(&scene.initial_state(), scene.articulation.initial_shape())?;
    let bodies = scene.bodies_at(scene.articulation.initial_shape());
    let Some(contact) = closest_contact(&bodies, &scene.domain, &poses) else {
        return Ok(());
    };
    let size = bodies[contact.body].bounding_radius();
    if !contact.touches(size) {
        return Ok(());
    }
    let name = |body: usize| scene.bodies[body].name.clone();
    Err(match contact.other {
        Some(other) if other == contact.body => SceneError::TouchingImage {
            place: scene.place(&format!("bodies[{other}].radius")),
            body: name(other),
            gap: contact.gap,
        },
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

/// Refuses a gait along which bodies touch whose relative position it prescribes.
///
/// These are the bodies that prescribed joints connect, and the wall and all of them whose group
/// has a fixed body: no flow is needed to know where they are.
pub(super) fn check_stroke(scene: &Scene) -> Result<(), SceneError> {
    let set = &scene.articulation;
    let groups = prescribed_groups(set);
    let initial = set.place(&scene.initial_state(), set.initial_shape())?;
    // All cycles after the second one repeat the shapes of the second one.
    let gait = Gait {
        cycles: scene.gait.cycles.min(2),
        phases: scene.gait.phases.clone(),
    };
    spans(&gait, set.initial_shape())?
        .try_for_each(|span| check_span(scene, &span, (&groups, &initial)))
}

/// For each body the number of its group: of the bodies that prescribed joints connect.
///
/// In a linkage with a loop and joints that are not prescribed, every body is a group of its own,
/// because the values of these joints follow from the loop.
fn prescribed_groups(set: &Articulation) -> Vec<usize> {
    let is_prescribed =
        |joint: &Joint| !joint.is_passive() && joint.kind.freedom() != Freedom::Rotation;
    let holds = |joint: &&Joint| !joint.kind.is_deformation();
    let linkage_of = set.linkage_of();
    let mut groups: Vec<usize> = (0..linkage_of.len()).collect();
    let mut joints_of: Vec<Vec<&Joint>> = vec![Vec::new(); set.linkages().len()];
    for joint in set.joints().iter().filter(holds) {
        joints_of[linkage_of[joint.body]].push(joint);
    }
    for (linkage, joints) in set.linkages().iter().zip(joints_of) {
        let has_loop = joints.len() >= linkage.bodies.len();
        if has_loop && !joints.iter().all(|joint| is_prescribed(joint)) {
            continue;
        }
        for joint in joints.iter().filter(|joint| is_prescribed(joint)) {
            let [from, to] = [joint.body, joint.to].map(|body| groups[body]);
            for &body in &linkage.bodies {
                if groups[body] == from {
                    groups[body] = to;
                }
            }
        }
    }
    groups
}

/// Distance that is rounding of positions, relative to the radius of a body.
const POSITION_ROUNDING: f64 = 1e-9;

/// Number of positions from which the deepest overlap along a phase span is reported.
const REPORTED_POSITIONS: u32 = 64;

/// Refuses contact along a phase span, for groups of bodies and their initial poses.
fn check_span(
    scene: &Scene,
    span: &PhaseSpan,
    (groups, initial): (&[usize], &[Isometry3<f64>]),
) -> Result<(), SceneError> {
    let length_key = match (&scene.gait_table, span.is_linear()) {
        (Some(_), _) => "gait.file".to_owned(),
        (None, true) => format!("gait.phases[{}].length", span.phase),
        (None, false) => "gait.harmonics".to_owned(),
    };
    let fails = |error: RigidError| SceneError::BadValue {
        place: scene.place(&length_key),
        key: length_key.clone(),
        problem: format!("fails: {error}"),
    };
    let set = &scene.articulation;
    let joints = span.value_bounds(&span.second_derivatives(), (0.0, 1.0));
    let bounds = StateBounds::at_rest(set, joints);
    let motions = set.motion_bounds(&bounds).map_err(fails)?;
    let is_constant =
        |joint: usize| (bounds.joints.get(joint)).is_none_or(|of| of.derivatives.first == 0.0);
    let is_still =
        |body: usize| motions[body].linear.first == 0.0 && motions[body].angular.first == 0.0;
    let stands: Vec<bool> = (scene.bodies.iter().enumerate())
        .map(|(number, body)| {
            let deformation = body.deformation.as_ref();
            let mut amplitudes = deformation.into_iter().flat_map(Deformation::joints);
            is_still(number) && amplitudes.all(is_constant)
        })
        .collect();
    let state = scene.initial_state();
    // Where the frame of a linkage is not at its fixed body, the placement moves that body, in this
    // phase or in an earlier one. Bodies that stand were checked before.
    let present = set.place(&state, &span.shape(0.0)).map_err(fails)?;
    let mut is_anchored = vec![false; groups.len()];
    for (body, (initial, present)) in initial.iter().zip(&present).enumerate() {
        let moved = (initial.translation.vector - present.translation.vector).norm()
            + initial.rotation.angle_to(&present.rotation) * scene.bodies[body].bounding_radius();
        let is_at_start = moved <= POSITION_ROUNDING * scene.bodies[body].bounding_radius();
        is_anchored[groups[body]] |= scene.bodies[body].fixed && is_still(body) && is_at_start;
    }
    let includes = |one: usize, other: usize| match one == other {
        true => is_anchored[groups[one]] && !stands[one],
        false => {
            let is_known = groups[one] == groups[other]
                || [one, other].iter().all(|&b| is_anchored[groups[b]]);
            is_known && !(stands[one] && stands[other])
        }
    };
    let domain = match scene.domain.period() {
        // The images of a linkage that turns freely are not prescribed.
        Some(_) => &Domain::Unbounded,
        None => &scene.domain,
    };
    let path = BodyPath {
        bodies: &scene.bodies,
        set,
        domain,
        at: &|s| Ok((state.clone(), span.shape(s))),
        bounds: &bounds,
    };
    // Where contact cannot be excluded, a run looks for it along its shorter steps.
    let Some(first) = first_contact_among(&path, &includes)
        .map_err(fails)?
        .filter(|found| found.is_certain)
    else {
        return Ok(());
    };
    let Contact { body, other, .. } = first.contact;
    let mut deepest = (first.at, first.contact.gap);
    for k in 0..=REPORTED_POSITIONS {
        let s = f64::from(k) / f64::from(REPORTED_POSITIONS);
        let poses = set.place(&state, &span.shape(s)).map_err(fails)?;
        let bodies = scene.bodies_at(&span.shape(s));
        let gap = contacts(&bodies, domain, &poses)
            .find(|contact| contact.body == body && contact.other == other)
            .map_or(f64::INFINITY, |contact| contact.gap);
        if gap < deepest.1 {
            deepest = (s, gap);
        }
    }
    let (s, gap) = deepest;
    let name = |body: usize| scene.bodies[body].name.clone();
    Err(SceneError::Touching {
        place: scene.place(&length_key),
        first: name(body),
        second: other.map_or_else(|| "the wall".to_owned(), name),
        when: format!("in phase {} at {:.0} % of it", span.phase + 1, 100.0 * s),
        gap,
        remedy: "let the link change less",
    })
}
