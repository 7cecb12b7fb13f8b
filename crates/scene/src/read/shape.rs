//! The shape of a body of a scene file.

use nalgebra::{UnitQuaternion, Vector3};

use super::checks::Checks;
use super::surface_file::{SurfaceFiles, SurfaceKeys};
use crate::domain::Domain;
use crate::error::SceneError;
use crate::file::{BodyFile, DEFAULT_AXIS, DEFAULT_ORIENTATION};
use crate::shape::Shape;
use crate::words::ShapeKind;

/// Largest number of turns of a helix; closest points are searched on all of them.
const MAX_TURNS: f64 = 1000.0;

/// The keys of a body that belong to shapes, with the shapes that have them.
fn shape_keys(file: &BodyFile) -> [(&'static str, bool, &'static [ShapeKind]); 12] {
    use ShapeKind::{Capsule, Disk, Ellipsoid, Helix, Sphere, Spheroid, Surface, Torus};
    const OF_REVOLUTION: &[ShapeKind] = &[Spheroid, Capsule, Disk, Torus];
    [
        (
            "radius",
            file.radius.is_some(),
            &[Sphere, Spheroid, Capsule, Disk, Torus, Helix],
        ),
        ("semi_axes", file.semi_axes.is_some(), &[Ellipsoid]),
        (
            "half_length",
            file.half_length.is_some(),
            &[Spheroid, Capsule, Disk],
        ),
        ("tube_radius", file.tube_radius.is_some(), &[Torus, Helix]),
        ("pitch", file.pitch.is_some(), &[Helix]),
        ("turns", file.turns.is_some(), &[Helix]),
        ("file", file.file.is_some(), &[Surface]),
        ("surface_kind", file.surface_kind.is_some(), &[Surface]),
        ("scale", file.scale.is_some(), &[Surface]),
        ("centre", file.centre.is_some(), &[Surface]),
        ("axis", file.axis.is_some(), OF_REVOLUTION),
        (
            "orientation",
            file.orientation.is_some(),
            &[Ellipsoid, Spheroid, Capsule, Disk, Torus, Helix, Surface],
        ),
    ]
}

/// The shape of a body; keys that the shape does not have are refused.
pub(super) fn shape(
    checks: &Checks,
    number: usize,
    file: &BodyFile,
    domain: &Domain,
    surfaces: &mut SurfaceFiles,
) -> Result<Shape, SceneError> {
    let bad = |name: &str, problem: String| checks.bad_value(&key(number, name), problem);
    if file.shape == ShapeKind::Point && file.torque.is_some() {
        let problem = "cannot act on a point, which does not rotate; remove it";
        return Err(bad("torque", problem.to_owned()));
    }
    for (name, is_given, shapes) in shape_keys(file) {
        if is_given && !shapes.contains(&file.shape) {
            let problem = match file.shape {
                ShapeKind::Point => "makes no sense for a point; remove it".to_owned(),
                _ => {
                    let words: Vec<_> =
                        shapes.iter().map(|s| format!("\"{}\"", s.word())).collect();
                    let words = words.join(", ");
                    format!("belongs to shape = {words}; remove it or set the shape")
                }
            };
            return Err(bad(name, problem));
        }
    }
    let shape = shape_of_keys(checks, number, file, domain, surfaces)?;
    // Proportions.
    let too_small = |name: &str, why: &str| Err(bad(name, format!("must be {why}")));
    match shape {
        Shape::Capsule {
            radius,
            half_length,
            ..
        } if half_length <= radius => too_small(
            "half_length",
            "larger than the radius: it includes the round ends; use shape = \"sphere\" for \
             equal lengths",
        ),
        Shape::Disk {
            radius,
            half_length,
            ..
        } if half_length >= radius => too_small(
            "half_length",
            "smaller than the radius: it is half the thickness of the disk, whose rim is round",
        ),
        Shape::Torus {
            radius,
            tube_radius,
            ..
        } if tube_radius >= radius => too_small(
            "tube_radius",
            "smaller than the radius of the torus, which would have no hole",
        ),
        Shape::Helix { pitch: 0.0, .. } => too_small(
            "pitch",
            "other than zero: positive for a right-handed helix, negative for a left-handed one",
        ),
        Shape::Helix { turns, .. } if turns > MAX_TURNS => {
            too_small("turns", &format!("at most {MAX_TURNS}"))
        }
        _ => Ok(shape),
    }
}

fn key(number: usize, name: &str) -> String {
    format!("bodies[{number}].{name}")
}

fn shape_of_keys(
    checks: &Checks,
    number: usize,
    file: &BodyFile,
    domain: &Domain,
    surfaces: &mut SurfaceFiles,
) -> Result<Shape, SceneError> {
    let required =
        |name: &str, value: Option<f64>, why: &str| checks.required(&key(number, name), value, why);
    let radius = |why: &str| required("radius", file.radius, why);
    let half_length = |why: &str| required("half_length", file.half_length, why);
    let tube = |why: &str| required("tube_radius", file.tube_radius, why);
    let orientation = file.orientation.unwrap_or(DEFAULT_ORIENTATION).into();
    let axis = || axis(checks, number, file);
    Ok(match file.shape {
        ShapeKind::Sphere => Shape::Sphere {
            radius: radius(": a sphere needs a radius")?,
        },
        ShapeKind::Ellipsoid => Shape::Ellipsoid {
            semi_axes: checks
                .required(
                    &key(number, "semi_axes"),
                    file.semi_axes,
                    ": an ellipsoid needs its three semi-axes",
                )?
                .into(),
            orientation,
        },
        ShapeKind::Spheroid => Shape::Spheroid {
            radius: radius(": a spheroid needs the radius of its equator")?,
            half_length: half_length(": a spheroid needs half its length along its axis")?,
            axis: axis()?,
        },
        ShapeKind::Capsule => Shape::Capsule {
            radius: radius(": a capsule needs the radius of its cylinder")?,
            half_length: half_length(": a capsule needs half its length, round ends included")?,
            axis: axis()?,
        },
        ShapeKind::Disk => Shape::Disk {
            radius: radius(": a disk needs its radius, rim included")?,
            half_length: half_length(": a disk needs half its thickness")?,
            axis: axis()?,
        },
        ShapeKind::Torus => Shape::Torus {
            radius: radius(": a torus needs the radius of the circle in its tube")?,
            tube_radius: tube(": a torus needs the radius of its tube")?,
            axis: axis()?,
        },
        ShapeKind::Helix => Shape::Helix {
            radius: radius(": a helix needs the radius of its centreline")?,
            tube_radius: tube(": a helix needs the radius of its tube")?,
            pitch: required("pitch", file.pitch, ": a helix needs its length per turn")?,
            turns: required("turns", file.turns, ": a helix needs its number of turns")?,
            orientation,
        },
        ShapeKind::Surface => {
            let keys = SurfaceKeys {
                group: &format!("bodies[{number}]"),
                file: &file.file,
                kind: file.surface_kind,
                scale: file.scale,
            };
            Shape::Surface {
                shape: surfaces
                    .read(checks, keys)?
                    .about(file.centre.map(Vector3::from)),
                orientation,
            }
        }
        ShapeKind::File => {
            let Domain::Mesh { file: mesh, .. } = domain else {
                let problem = "\"file\" is a part of the boundary of a mesh: it belongs to \
                               domain.kind = \"mesh\"; use shape = \"surface\" elsewhere";
                return Err(checks.bad_value(&key(number, "shape"), problem));
            };
            let tag = key(number, "surface");
            let why = ": name the part of the mesh's boundary that is this body";
            let part = checks.required(&tag, file.surface.as_deref(), why)?;
            let shape = surfaces.mesh_part(checks, mesh, part, &tag)?;
            Shape::Surface {
                shape: shape.about(file.position.map(Vector3::from)),
                orientation: DEFAULT_ORIENTATION.into(),
            }
        }
        ShapeKind::Point => Shape::Point,
    })
}

/// The axis of a body of revolution: given, or the x axis turned by the orientation.
fn axis(checks: &Checks, number: usize, file: &BodyFile) -> Result<Vector3<f64>, SceneError> {
    match (file.axis, file.orientation) {
        (Some(_), Some(_)) => Err(checks.bad_value(
            &key(number, "orientation"),
            "is given beside axis, and either determines the other; remove one of them",
        )),
        (None, Some(orientation)) => {
            Ok(UnitQuaternion::from_scaled_axis(orientation.into()) * Vector3::from(DEFAULT_AXIS))
        }
        (axis, None) => unit_axis(axis.unwrap_or(DEFAULT_AXIS)).ok_or_else(|| {
            checks.bad_value(&key(number, "axis"), "must not be zero: it is a direction")
        }),
    }
}

/// The direction of a vector; `None` for zero.
fn unit_axis(axis: [f64; 3]) -> Option<Vector3<f64>> {
    let axis = Vector3::from(axis);
    let unit = axis.try_normalize(0.0)?;
    // A written unit vector reads back to the last bit, without a second normalisation.
    let is_unit = (axis.norm() - 1.0).abs() <= 2.0 * f64::EPSILON;
    Some(if is_unit { axis } else { unit })
}
