//! The bodies of a scene file.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use super::{flow, loads};
use crate::body::Body;
use crate::checks::Checks;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::flow::Background;
use crate::keys::BodyFile;
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
    (background, gait_period): (Option<&Background>, Option<f64>),
    surfaces: &mut SurfaceFiles,
) -> Result<Vec<Body>, SceneError> {
    let mut first_of = BTreeMap::new();
    let mut bodies = Vec::with_capacity(files.len());
    for (number, file) in files.iter().enumerate() {
        let mut body = body(checks, number, file, domain, surfaces, &mut first_of)?;
        loads::enter(checks, number, file, gait_period, &mut body)?;
        bodies.push(body);
    }
    check_obstacles(checks, &bodies, background)?;
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
        force: Vector3::zeros(),
        driving_force: None,
        torque: Vector3::zeros(),
        driving_torque: None,
        moment: file.moment.into(),
        weight: Vector3::zeros(),
        fixed: file.fixed,
        velocity: None,
        angular_velocity: None,
        density: file.density,
        slip: flow::slip(checks, number, file, has_surface)?,
        deformation: None,
        mass: file.mass,
        inertia: file.inertia,
    })
}

/// Refuses scenes in which all bodies are fixed and neither slip nor a background flow moves the
/// fluid, and those in which no body withstands a given pressure gradient.
fn check_obstacles(
    checks: &Checks,
    bodies: &[Body],
    background: Option<&Background>,
) -> Result<(), SceneError> {
    let is_held = |body: &Body| body.held_velocity().is_some();
    if let Some(Background::PressureGradient { .. }) = background
        && !bodies.iter().any(is_held)
    {
        let problem = "has no steady flow: the forces of the bodies on the fluid must add up to \
                       the pressure gradient times the volume of the box, but all bodies are free \
                       and their forces given, so that the fluid would accelerate; hold bodies by \
                       fixed = true or a velocity, or give the mean flow by kind = \"uniform\" \
                       and find the pressure gradient in the results";
        return Err(checks.bad_value("background", problem));
    }
    let has_obstacle = bodies.iter().any(|body| body.fixed);
    let mut surfaces = bodies.iter().filter(|body| body.shape.has_surface());
    let is_at_rest = |body: &Body| body.fixed && body.slip.is_none();
    if has_obstacle && background.is_none() && surfaces.all(is_at_rest) {
        let problem = "are all fixed, so nothing moves; leave one of them free";
        return Err(checks.bad_value("bodies", problem));
    }
    Ok(())
}

/// Keys of bodies that belong to some shapes, with these.
static OWNED_KEYS: LazyLock<Vec<(&str, Vec<ShapeKind>)>> = LazyLock::new(|| {
    let (all, prefix) = (shape_keys(), BodyFile::TABLE.prefix);
    let names = (BodyFile::TABLE.keys.iter()).map(|key| &key.path[prefix.len()..]);
    let owned = names.map(|name| {
        let owners = all.iter().filter(|(_, keys)| keys.contains(&name));
        (name, owners.map(|(owner, _)| *owner).collect::<Vec<_>>())
    });
    owned.filter(|(_, owners)| !owners.is_empty()).collect()
});

/// The shape of a body; keys that the shape does not have are refused.
fn shape(keys: &mut ShapeKeys) -> Result<Shape, SceneError> {
    let kind = keys.file.shape;
    let bad = |name: &str, problem: String| Err(keys.checks.bad_value(&keys.path(name), problem));
    if kind == ShapeKind::Point && keys.file.torque.is_some() {
        let problem = "cannot act on a point, which does not rotate; remove it";
        return bad("torque", problem.to_owned());
    }
    for (name, owners) in &*OWNED_KEYS {
        if owners.contains(&kind) || !keys.checks.0.has(&keys.path(name)) {
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
