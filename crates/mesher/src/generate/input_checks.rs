//! Checks of the scene and the parameters of mesh generation.

use super::gap::Gap;
use super::geodesic::geodesic_sphere;
use super::input::{Container, GenerateParams, MeshedBody, demand, finite, length};
use super::size_field::HALF_SPACES;
use super::symmetry_planes::SymmetryPlanes;
use crate::GenerateError;
use mesh::{MeshError, SYMMETRY_PLANE_TAGS, Surface};
use std::collections::HashSet;

/// Checks the numbers and names of the scene, the parameters, and the symmetry of the scene.
///
/// # Errors
/// [`GenerateError::BadParameter`], [`MeshError::BadTag`], [`GenerateError::NotSymmetric`].
pub(crate) fn check(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
) -> Result<(), GenerateError> {
    check_params(params)?;
    match container {
        Container::Ball(ball) => {
            finite("centre of the container", ball.centre)?;
            length("radius of the container", ball.radius)?;
        }
        Container::Box(sides) => {
            finite("corner of the container", sides.min)?;
            finite("corner of the container", sides.max)?;
            for side in (sides.max - sides.min).iter() {
                length("side of the container", *side)?;
            }
        }
        Container::Capsule(capsule) => {
            finite("centre of the container", capsule.centre)?;
            length("radius of the container", capsule.radius)?;
            length("length of the container", capsule.half_length)?;
        }
        Container::Surface(surface) => {
            let (centre, radius) = surface.bounding_ball();
            finite("centre of the container", centre)?;
            length("radius of the container", radius)?;
        }
    }
    let is_box = matches!(container, Container::Box(_));
    demand(
        is_box || !params.box_sides,
        "number of tags of the container's sides",
        Container::BOX_TAGS.len() as f64,
        "it must be 1 unless the container is a box",
    )?;
    let tags: &[&str] = match params.box_sides {
        true => &Container::BOX_TAGS,
        false => &[Container::TAG],
    };
    if let Some(body) = bodies.iter().find(|body| tags.contains(&body.name)) {
        return Err(used_twice(body.name));
    }
    check_bodies(bodies)?;
    check_symmetry(SymmetryPlanes(params.symmetry_planes), bodies, container)
}

/// Checks the parameters.
///
/// # Errors
/// [`GenerateError::BadParameter`].
pub(crate) fn check_params(params: &GenerateParams) -> Result<(), GenerateError> {
    demand(
        params.growth > 0.0 && params.growth <= 0.6,
        "growth",
        params.growth,
        "it must be above 0 and at most 0.6",
    )?;
    length("gap coefficient", params.gap)?;
    length("smallest gap", params.min_gap)?;
    demand(
        params.max_size > 0.0,
        "largest size",
        params.max_size,
        "it must be positive",
    )?;
    demand(
        (0.0..60.0).contains(&params.target_dihedral),
        "target dihedral angle",
        params.target_dihedral,
        "it must be at least 0 and below 60 degrees",
    )?;
    Ok(())
}

/// Checks the names, positions and lengths of bodies.
///
/// # Errors
/// [`GenerateError::BadParameter`], [`MeshError::BadTag`].
pub(crate) fn check_bodies(bodies: &[MeshedBody<'_>]) -> Result<(), GenerateError> {
    let mut names = HashSet::new();
    for body in bodies {
        if !names.insert(body.name) {
            return Err(used_twice(body.name));
        }
        let (centre, radius) = body.surface.bounding_ball();
        finite(&format!("position of '{}'", body.name), centre)?;
        length(&format!("radius of '{}'", body.name), radius)?;
        length(&format!("size of '{}'", body.name), body.size)?;
        length(
            &format!(
                "reach (radius of curvature, or half the gap to itself) of '{}'",
                body.name
            ),
            body.surface.reach(),
        )?;
    }
    Ok(())
}

/// The error for a name of two bodies, or of a body and the container.
pub(crate) fn used_twice(name: &str) -> GenerateError {
    GenerateError::Mesh(MeshError::BadTag {
        name: name.into(),
        problem: "is used twice; give every body its own name",
    })
}

/// Checks that the container is symmetric about every plane, and every body symmetric or beside it.
///
/// # Errors
/// [`GenerateError::NotSymmetric`]; [`GenerateError::BadParameter`] for a capsule or another
/// surface, whose triangles would cross the planes.
fn check_symmetry(
    planes: SymmetryPlanes,
    bodies: &[MeshedBody<'_>],
    container: &Container,
) -> Result<(), GenerateError> {
    let may_cross = matches!(container, Container::Capsule(_) | Container::Surface(_));
    if may_cross && !planes.is_empty() {
        return Err(GenerateError::BadParameter {
            what: "number of symmetry planes".into(),
            value: planes.len() as f64,
            requirement: "it must be zero in a capsule or another surface",
        });
    }
    let check = |name: &str, surface: &dyn Surface, may_be_beside: bool| {
        let fits =
            |axis: usize| is_symmetric(surface, axis) || may_be_beside && is_beside(surface, axis);
        match (0..3).find(|&axis| planes.normal_to(axis) && !fits(axis)) {
            None => Ok(()),
            Some(axis) => Err(GenerateError::NotSymmetric {
                part: name.into(),
                plane: SYMMETRY_PLANE_TAGS[axis],
            }),
        }
    };
    for body in bodies {
        check(body.name, body.surface, true)?;
    }
    check(Container::TAG, container.surface(), false)
}

/// Whether a surface lies on the positive side of the plane normal to `axis`, without contact.
fn is_beside(surface: &dyn Surface, axis: usize) -> bool {
    Gap::to_wall(surface, &HALF_SPACES[axis]).width > 0.0
}

/// Whether a surface is symmetric about the plane normal to `axis`, according to the distances of
/// points around it.
fn is_symmetric(surface: &dyn Surface, axis: usize) -> bool {
    let (centre, radius) = surface.bounding_ball();
    let rounding = 64.0 * f64::EPSILON * centre.norm().max(radius);
    centre[axis] == 0.0
        && geodesic_sphere(0.5).points.iter().all(|d| {
            let mut image = *d;
            image[axis] = -image[axis];
            let [a, b] = [*d, image].map(|d| surface.signed_distance(centre + 1.5 * radius * d));
            (a - b).abs() <= rounding
        })
}
