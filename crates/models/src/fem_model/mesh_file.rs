//! Meshes from files.

use std::path::Path;

use mesh::{MshFile, NamedSurface, Sphere, Surface, TetMesh};

use crate::ModelError;
use crate::scale::Scale;
use scene::GeometryKind;

/// The mesh of a file in units of the flow, its bodies' surfaces put on the spheres of the scene.
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
    // Also for straight sides: it is the check that the file's surfaces are where the scene says.
    let curved = read.clone().into_mesh(&surfaces)?;
    Ok(match geometry {
        GeometryKind::Curved => curved,
        GeometryKind::Straight => read.into_mesh(&[])?,
    })
}
