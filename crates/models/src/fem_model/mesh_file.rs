//! Meshes from Gmsh files, and new meshes between their walls and moved bodies.

use std::path::Path;

use mesh::{MshFile, NamedSurface, TetMesh};
use mesher::{GenerateError, GenerateParams, MovedBody};

use super::element_size::ADAPTED_GROWTH;
use crate::ModelError;
use crate::units::Scale;
use scene::{GeometryKind, MesherKind};

/// Reads a mesh file in scaled units.
///
/// `surfaces` are those of the bodies with the names of their boundary parts, in scaled units;
/// nodes on these parts are moved onto the surfaces. `known` are the names of all bodies and walls.
///
/// # Errors
/// A file that cannot be read; [`ModelError::OpenBoundary`]; [`ModelError::MeshFile`] for points
/// that are not finite, inverted cells, and parts of the boundary that are not on the surfaces.
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
    points.iter_mut().for_each(|x| *x = scale.length(*x));
    if let Some(tag) = read.tags().iter().find(|tag| !known.contains(tag)) {
        return Err(ModelError::OpenBoundary {
            file: file.display().to_string(),
            tag: tag.clone(),
            missing: (known.iter())
                .filter(|name| !read.tags().contains(**name))
                .map(|name| (*name).clone())
                .collect(),
        });
    }
    // Also if cells are straight: this checks that the boundary is on the surfaces of the scene.
    let curved = read.clone().into_mesh(surfaces);
    let mesh = match geometry {
        GeometryKind::Curved => curved,
        GeometryKind::Straight => curved.and_then(|_| read.into_mesh(&[])),
    };
    mesh.map_err(|source| ModelError::MeshFile {
        file: file.display().to_string(),
        source: Box::new(source),
    })
}

/// A new mesh between the walls of the mesh of a file and the moved bodies.
///
/// `bodies` have their surfaces in their new places. Walls keep their facets; the surfaces of the
/// bodies are triangulated again.
///
/// Where there is no such mesh and `mesher` is the command `gmsh`, this makes a mesh with the
/// facets of the file on the bodies too.
///
/// # Errors
/// Those of [`mesher::remesh`] and [`mesher::remesh_by_gmsh`].
pub fn remesh<'a>(
    file: &TetMesh,
    bodies: &[MovedBody<'a>],
    geometry: GeometryKind,
    mesher: MesherKind,
) -> Result<TetMesh, GenerateError> {
    let surface = |body: &MovedBody<'a>| body.surface.map(|(surface, _)| (body.name, surface));
    let surfaces: Vec<NamedSurface> = match geometry {
        GeometryKind::Curved => bodies.iter().filter_map(surface).collect(),
        GeometryKind::Straight => Vec::new(),
    };
    let mut parameters = GenerateParams::default();
    // The sizes of the file decide where it grows less.
    parameters.growth = ADAPTED_GROWTH;
    match mesher::remesh(file, bodies, &parameters, &surfaces) {
        // No program has a mesh around bodies that touch.
        Err(error @ (GenerateError::BodiesTouch { .. } | GenerateError::BodyAtWall { .. })) => {
            Err(error)
        }
        Err(_) if mesher == MesherKind::Gmsh => {
            mesher::remesh_by_gmsh(Path::new("gmsh"), file, bodies, &surfaces)
        }
        done => done,
    }
}
