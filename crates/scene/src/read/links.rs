//! The links of a scene file, and the articulation of its bodies and links.

use rigid::{Articulation, Joint, Link, RigidError};

use super::checks::Checks;
use super::joint;
use crate::body::Body;
use crate::error::SceneError;
use crate::file::LinkFile;
use crate::shape::Shape;
use crate::words::ArmsKind;

/// All links, with unique names, each between two bodies that no other link joins.
pub(super) fn links(
    checks: &Checks,
    files: &[LinkFile],
    bodies: &[Body],
) -> Result<Vec<Link>, SceneError> {
    let mut links: Vec<Link> = Vec::with_capacity(files.len());
    for (number, file) in files.iter().enumerate() {
        let key = |key: &str| format!("links[{number}].{key}");
        let name = checks.required(&key("name"), file.name.clone(), ": name every link")?;
        if let Some(first) = links.iter().position(|link| link.name == name) {
            let problem =
                format!("\"{name}\" is the name of links[{first}] too; names must differ");
            return Err(checks.bad_value(&key("name"), problem));
        }
        let end = |which: &str, name: &Option<String>| {
            let key = key(which);
            let name = checks.required(&key, name.as_deref(), ": a link joins two bodies")?;
            let names = bodies.iter().map(|body| &body.name[..]);
            checks.find(&key, name, "body", names)
        };
        let (body, to) = (end("body", &file.body)?, end("to", &file.to)?);
        if body == to {
            let problem = format!(
                "links body '{}' to itself; link it to another",
                bodies[to].name
            );
            return Err(checks.bad_value(&key("to"), problem));
        }
        let joins_same = |link: &Link| [(body, to), (to, body)].contains(&(link.body, link.to));
        if links.iter().any(joins_same) {
            let problem = format!(
                "links '{}' and '{}' a second time; remove one",
                bodies[body].name, bodies[to].name
            );
            return Err(checks.bad_value(&format!("links[{number}]"), problem));
        }
        let joint = joint::joint(checks, number, file, [&bodies[body], &bodies[to]])?;
        let start = match joint {
            Joint::Slide => (bodies[body].position - bodies[to].position).norm(),
            _ => 0.0,
        };
        let drive = joint::drive(checks, number, file, start)?;
        links.push(Link {
            name,
            body,
            to,
            joint,
            drive,
        });
    }
    Ok(links)
}

/// Bodies and links as an articulation; links need a direction, and points need a link.
///
/// Links in `start` have other values at the start than in the pose of the file: bodies of slides
/// are moved along the directions of the links, with the pivots of their other joints; joints that
/// turn start from their angles.
pub(super) fn articulation(
    checks: &Checks,
    bodies: &mut [Body],
    links: Vec<Link>,
    arms: ArmsKind,
    start: &[(usize, f64)],
) -> Result<Articulation, SceneError> {
    for (number, link) in links.iter().enumerate() {
        let is_slide = link.joint == Joint::Slide;
        if is_slide && bodies[link.body].position == bodies[link.to].position {
            let problem = format!(
                "has no direction: '{}' and '{}' are at the same place; move one",
                bodies[link.body].name, bodies[link.to].name
            );
            return Err(checks.bad_value(&format!("links[{number}]"), problem));
        }
    }
    for (number, body) in bodies.iter().enumerate() {
        let link = links
            .iter()
            .find(|link| link.body == number || link.to == number);
        if body.shape == Shape::Point && link.is_none() {
            let problem = "is a point that no link holds, so nothing determines its velocity; \
                           link it or remove it";
            return Err(checks.bad_value(&format!("bodies[{number}]"), problem));
        }
    }
    let fixed: Vec<usize> = (0..bodies.len()).filter(|&b| bodies[b].fixed).collect();
    for &number in &fixed {
        if let Some(link) = links.iter().find(|l| l.body == number || l.to == number) {
            let problem = format!(
                "cannot be true: link '{}' acts on the body; an obstacle has no links",
                link.name
            );
            return Err(checks.bad_value(&format!("bodies[{number}].fixed"), problem));
        }
    }
    let kinds: Vec<_> = bodies.iter().map(Body::kind).collect();
    let join = |links: Vec<Link>, bodies: &[Body]| {
        let positions: Vec<_> = bodies.iter().map(|body| body.position).collect();
        Articulation::new(&kinds, links, arms.into(), &positions)?.with_fixed(&fixed)
    };
    let set = join(links, bodies).map_err(|error| checks.bad_value("links", error.to_string()))?;
    let mut lengths = set.initial_lengths().to_vec();
    let mut angles = lengths.clone();
    for &(link, value) in start {
        // A length that the positions give is not changed by their rounding.
        if set.links()[link].joint.is_angle() {
            angles[link] = value;
        } else if (value - lengths[link]).abs() > SAME_LENGTH * lengths[link] {
            (lengths[link], angles[link]) = (value, value);
        }
    }
    let bad = |error: RigidError| checks.bad_value("gait", error.to_string());
    let set = match lengths == set.initial_lengths() {
        true => set,
        false => {
            let poses = set.place(&set.initial_state(), &lengths).map_err(bad)?;
            let mut links = set.links().to_vec();
            // Slides only change their lengths here, so that nothing turns.
            for link in &mut links {
                let shift = poses[link.to].translation.vector - bodies[link.to].position;
                link.joint = link.joint.translated(&shift);
            }
            for (body, pose) in bodies.iter_mut().zip(poses) {
                body.position = pose.translation.vector;
            }
            join(links, bodies).map_err(bad)?
        }
    };
    set.with_initial_values(&angles).map_err(bad)
}

/// Relative difference up to which a length at the start of a gait is that of the positions, which
/// are written with about as many digits.
const SAME_LENGTH: f64 = 1e-9;
