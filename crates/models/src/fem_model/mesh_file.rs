//! Meshes from Gmsh files, and new meshes between their walls and moved bodies.

use std::path::Path;

use mesh::{MshFile, NamedSurface, Surface, TetMesh};
use mesher::{GenerateError, GenerateParams, MovedBody};
use nalgebra::{Isometry3, Translation3};

use super::element_size::ADAPTED_GROWTH;
use super::mesh_generator::Surfaced;
use crate::ModelError;
use crate::units::Scale;
use scene::{GeometryKind, MesherKind};

/// Reads a mesh file in scaled units.
///
/// `surfaces` are those of the bodies with the names of their boundary parts, in scaled units;
/// nodes on these parts are moved onto the surfaces. `known` are the names of all bodies and walls.
///
/// # Errors
/// A file that cannot be read; [`ModelError::OpenBoundary`]; parts of the boundary that are not on
/// them.
pub fn read_mesh(
    file: &Path,
    surfaces: &[NamedSurface<'_>],
    known: &[&String],
    geometry: GeometryKind,
    scale: &Scale,
) -> Result<TetMesh, ModelError> {
    let mut read = MshFile::read(file)?;
    let points = match &mut read {
        MshFile::Linear(tets) => &mut tets.points,
        MshFile::Quadratic(tets) => &mut tets.points,
    };
    points.iter_mut().for_each(|x| *x = scale.point(*x));
    if let Some(tag) = read.tags().iter().find(|tag| !known.contains(tag)) {
        return Err(ModelError::OpenBoundary {
            file: file.display().to_string(),
            tag: tag.clone(),
        });
    }
    // Also if cells are straight: this checks that the boundary is on the surfaces of the scene.
    let curved = read.clone().into_mesh(surfaces)?;
    Ok(match geometry {
        GeometryKind::Curved => curved,
        GeometryKind::Straight => read.into_mesh(&[])?,
    })
}

/// The motion of a body from its initial pose to another one.
///
/// Rotations do not change spheres, whose surface meshes are translated.
pub fn motion(body: &Surfaced, pose: &Isometry3<f64>) -> Isometry3<f64> {
    match body.shape.is_isotropic() {
        true => Translation3::from(pose.translation.vector - body.pose.translation.vector).into(),
        false => pose * body.pose.inverse(),
    }
}

/// A new mesh between the walls of the mesh of a file and the moved bodies.
///
/// `bodies` have their names, motions and surfaces in their new places. Walls keep their facets;
/// the surfaces of the bodies are triangulated again.
///
/// Where there is no such mesh and `mesher` is the command `gmsh`, this makes a mesh with the
/// facets of the file on the bodies too.
///
/// # Errors
/// Those of [`mesher::remesh`] and [`mesher::remesh_by_gmsh`].
pub fn remesh(
    file: &TetMesh,
    bodies: &[(&str, Isometry3<f64>, &dyn Surface, f64)],
    geometry: GeometryKind,
    mesher: MesherKind,
) -> Result<TetMesh, GenerateError> {
    let moved: Vec<MovedBody> = (bodies.iter())
        .map(|&(name, motion, surface, size)| MovedBody {
            name,
            motion,
            surface: Some((surface, size)),
        })
        .collect();
    let surfaces: Vec<NamedSurface> = match geometry {
        GeometryKind::Curved => bodies.iter().map(|b| (b.0, b.2)).collect(),
        GeometryKind::Straight => Vec::new(),
    };
    let mut parameters = GenerateParams::default();
    // The sizes of the file decide where it grows less.
    parameters.growth = ADAPTED_GROWTH;
    match mesher::remesh(file, &moved, &parameters, &surfaces) {
        // No program has a mesh around bodies that touch.
        Err(error @ (GenerateError::BodiesTouch { .. } | GenerateError::BodyAtWall { .. })) => {
            Err(error)
        }
        Err(_) if mesher == MesherKind::Gmsh => {
            mesher::remesh_by_gmsh(Path::new("gmsh"), file, &moved, &surfaces)
        }
        done => done,
    }
}
