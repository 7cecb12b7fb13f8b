//! The bodies of a scene file.

use std::collections::BTreeMap;

use super::flow;
use crate::body::Body;
use crate::checks::Checks;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::keys::{BodyFile, DEFAULT_TORQUE};
use crate::shape::{Shape, shape_keys};
use crate::shapes::ShapeKeys;
use crate::surface_shape::SurfaceFiles;
use crate::words::ShapeKind;
use nalgebra::Vector3;

/// All bodies, with unique names, of which at least one has a surface and can move.
pub(super) fn bodies(
    checks: &Checks,
    files: &[BodyFile],
    domain: &Domain,
    has_background: bool,
    surfaces: &mut SurfaceFiles,
) -> Result<Vec<Body>, SceneError> {
    let mut first_of = BTreeMap::new();
    let mut bodies = Vec::with_capacity(files.len());
    for (number, file) in files.iter().enumerate() {
        let body = body(checks, number, file, domain, surfaces, &mut first_of)?;
        bodies.push(body);
    }
    check_obstacles(checks, &bodies, has_background)?;
    if !bodies.iter().any(|body| body.shape.has_surface()) {
        return Err(checks.bad_value(
            "bodies",
            "is empty: a scene needs at least one [[bodies]] with a surface",
        ));
    }
    Ok(bodies)
}

/// One body; `first_of` maps the names of the previous bodies to their numbers.
fn body(
    checks: &Checks,
    number: usize,
    file: &BodyFile,
    domain: &Domain,
    surfaces: &mut SurfaceFiles,
    first_of: &mut BTreeMap<String, usize>,
) -> Result<Body, SceneError> {
    let key = |key: &str| format!("bodies[{number}].{key}");
    let name = checks.required(&key("name"), file.name.clone(), ": name every body")?;
    if let Some(first) = first_of.insert(name.clone(), number) {
        let problem = format!("\"{name}\" is the name of bodies[{first}] too; names must differ");
        return Err(checks.bad_value(&key("name"), problem));
    }
    let mesh = match domain {
        Domain::Mesh { file, .. } => Some(file.as_path()),
        _ => None,
    };
    let shape = shape(&mut ShapeKeys {
        checks,
        number,
        file,
        mesh,
        surfaces,
    })?;
    let has_surface = shape.has_surface();
    if mesh.is_some() && has_surface && file.surface.is_none() {
        let problem = "is missing: name the part of the mesh's boundary that is this body";
        return Err(checks.bad_value(&key("surface"), problem));
    }
    if file.mass > 0.0 && file.inertia == 0.0 && shape.inertia_per_mass().is_none() {
        let problem = format!(
            "is missing: the moment of inertia of a {} has no formula",
            shape.kind().word()
        );
        return Err(checks.bad_value(&key("inertia"), problem));
    }
    if !has_surface && (file.mass > 0.0 || file.inertia > 0.0) {
        let problem = "makes no sense for a point, which has no surface; remove it";
        return Err(checks.bad_value(&key("mass"), problem));
    }
    let position = match &shape {
        // It is where the mesh has it.
        Shape::File(part) => part.shape.centre.into(),
        _ => checks.required(&key("position"), file.position, ": place every body")?,
    };
    Ok(Body {
        name,
        shape,
        position: position.into(),
        surface: file.surface.clone(),
        force: file.force.into(),
        torque: file.torque.unwrap_or(DEFAULT_TORQUE).into(),
        weight: Vector3::zeros(),
        fixed: file.fixed,
        density: file.density,
        slip: flow::slip(checks, number, file, has_surface)?,
        mass: file.mass,
        inertia: file.inertia,
    })
}

/// Refuses fixed points, fixed bodies with loads, and scenes in which all bodies are fixed and
/// neither slip nor a background flow moves the fluid.
fn check_obstacles(
    checks: &Checks,
    bodies: &[Body],
    has_background: bool,
) -> Result<(), SceneError> {
    for (number, body) in bodies.iter().enumerate().filter(|(_, body)| body.fixed) {
        let problem = if !body.shape.has_surface() {
            "makes no sense for a point, which has no surface and is no obstacle; remove it"
        } else if body.force.amax() > 0.0 || body.torque.amax() > 0.0 {
            "holds the body against any load; remove its force and torque"
        } else {
            continue;
        };
        return Err(checks.bad_value(&format!("bodies[{number}].fixed"), problem));
    }
    let has_obstacle = bodies.iter().any(|body| body.fixed);
    let mut surfaces = bodies.iter().filter(|body| body.shape.has_surface());
    let is_at_rest = |body: &Body| body.fixed && body.slip.is_none();
    if has_obstacle && !has_background && surfaces.all(is_at_rest) {
        let problem = "are all fixed, so nothing moves; leave one of them free";
        return Err(checks.bad_value("bodies", problem));
    }
    Ok(())
}

/// The shape of a body; keys that the shape does not have are refused.
fn shape(keys: &mut ShapeKeys) -> Result<Shape, SceneError> {
    let kind = keys.file.shape;
    let bad = |name: &str, problem: String| Err(keys.checks.bad_value(&keys.path(name), problem));
    if kind == ShapeKind::Point && keys.file.torque.is_some() {
        let problem = "cannot act on a point, which does not rotate; remove it";
        return bad("torque", problem.to_owned());
    }
    let all = shape_keys();
    let prefix = BodyFile::TABLE.prefix;
    for name in BodyFile::TABLE
        .keys
        .iter()
        .map(|key| &key.path[prefix.len()..])
    {
        let owners: Vec<ShapeKind> = (all.iter())
            .filter(|(_, keys)| keys.contains(&name))
            .map(|(owner, _)| *owner)
            .collect();
        let is_given = keys.checks.0.has(&keys.path(name));
        if !is_given || owners.is_empty() || owners.contains(&kind) {
            continue;
        }
        let problem = match kind {
            ShapeKind::Point => "makes no sense for a point; remove it".to_owned(),
            _ => {
                let words: Vec<_> = owners.iter().map(|s| format!("\"{}\"", s.word())).collect();
                let words = words.join(", ");
                format!("belongs to shape = {words}; remove it or set the shape")
            }
        };
        return bad(name, problem);
    }
    Shape::read(keys)
}
