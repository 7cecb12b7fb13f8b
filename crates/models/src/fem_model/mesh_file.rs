//! Meshes from Gmsh files.

use std::path::Path;

use mesh::{MshFile, NamedSurface, TetMesh};

use crate::ModelError;
use crate::units::Scale;
use scene::GeometryKind;

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
