//! Meshes from Gmsh files.

use std::path::Path;

use mesh::{MshFile, NamedSurface, Sphere, Surface, TetMesh};

use crate::ModelError;
use crate::units::Scale;
use scene::GeometryKind;

/// Reads a mesh file in scaled units.
///
/// `spheres` are the bodies with the names of their boundary parts, in scaled units; nodes on these
/// parts are moved onto the spheres.
///
/// # Errors
/// A file that cannot be read; [`ModelError::OpenBoundary`]; surfaces that are not on the spheres.
pub fn read_mesh(
    file: &Path,
    spheres: &[(&str, Sphere)],
    walls: &[String],
    geometry: GeometryKind,
    scale: &Scale,
) -> Result<TetMesh, ModelError> {
    let mut read = MshFile::read(file)?;
    let points = match &mut read {
        MshFile::Linear(tets) => &mut tets.points,
        MshFile::Quadratic(tets) => &mut tets.points,
    };
    points.iter_mut().for_each(|x| *x = scale.point(*x));
    let known = |tag: &String| walls.contains(tag) || spheres.iter().any(|(name, _)| name == tag);
    if let Some(tag) = read.tags().iter().find(|tag| !known(tag)) {
        return Err(ModelError::OpenBoundary {
            file: file.display().to_string(),
            tag: tag.clone(),
        });
    }
    let surfaces: Vec<NamedSurface> = spheres
        .iter()
        .map(|(name, s)| (*name, s as &dyn Surface))
        .collect();
    // Also if cells are straight: this checks that the surfaces are on the spheres of the scene.
    let curved = read.clone().into_mesh(&surfaces)?;
    Ok(match geometry {
        GeometryKind::Curved => curved,
        GeometryKind::Straight => read.into_mesh(&[])?,
    })
}
