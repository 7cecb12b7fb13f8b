//! Surfaces from files that a scene names.

use std::path::{Path, PathBuf};

use mesh::{MshFile, SurfaceMesh, TetMesh};
use mesher::{GenerateError, TriangulatedSurface};
use nalgebra::Vector3;

use super::checks::Checks;
use crate::error::SceneError;
use crate::surface_shape::SurfaceShape;
use crate::words::SurfaceKind;

/// The surfaces read so far; a file is read once for all bodies that have it.
#[derive(Default)]
pub(super) struct SurfaceFiles {
    read: Vec<(PathBuf, SurfaceKind, TriangulatedSurface)>,
    /// The mesh of the domain, once it is needed.
    mesh: Option<TetMesh>,
}

/// Keys that describe a surface.
pub(super) struct SurfaceKeys<'a> {
    /// Group of the keys, such as `bodies[0]`.
    pub group: &'a str,
    pub file: &'a Option<String>,
    pub kind: Option<SurfaceKind>,
    pub scale: Option<f64>,
}

impl SurfaceFiles {
    /// The surface of a file at its own place, checked.
    pub fn read(&mut self, checks: &Checks, keys: SurfaceKeys) -> Result<SurfaceShape, SceneError> {
        let key = format!("{}.file", keys.group);
        let why = ": give the STL, OBJ or Gmsh file of the surface";
        let name = checks.required(&key, keys.file.as_ref(), why)?;
        let file = checks.0.path().parent().unwrap_or(Path::new("")).join(name);
        let kind = keys.kind.unwrap_or_default();
        let known = (self.read.iter()).find(|(path, of, _)| *path == file && *of == kind);
        let surface = match known {
            Some((.., surface)) => surface.clone(),
            None => {
                let name = file.display().to_string();
                let surface = SurfaceMesh::read(&file)
                    .map_err(GenerateError::from)
                    .and_then(|mesh| TriangulatedSurface::new(&name, mesh, kind.into()))
                    .map_err(|error| checks.bad_value(&key, format!("is refused: {error}")))?;
                self.read.push((file.clone(), kind, surface.clone()));
                surface
            }
        };
        let scale = keys.scale.unwrap_or(1.0);
        Ok(SurfaceShape {
            surface: surface.scaled(scale),
            file,
            kind,
            scale,
            centre: Vector3::zeros(),
            part: None,
        })
    }

    /// A part of the boundary of the domain's mesh: its facets, and its curved cells where the file
    /// has them.
    pub fn mesh_part(
        &mut self,
        checks: &Checks,
        file: &Path,
        part: &str,
        key: &str,
    ) -> Result<SurfaceShape, SceneError> {
        let refused = |error: GenerateError| checks.bad_value(key, format!("is refused: {error}"));
        let mesh = match &self.mesh {
            Some(mesh) => mesh,
            None => {
                let read = MshFile::read(file).and_then(|file| file.into_mesh(&[]));
                self.mesh
                    .insert(read.map_err(|error| refused(error.into()))?)
            }
        };
        let (triangles, is_curved) =
            (mesh.boundary_part(part)).map_err(|error| refused(error.into()))?;
        let kind = match is_curved {
            true => SurfaceKind::Smooth,
            false => SurfaceKind::Faceted,
        };
        let surface = TriangulatedSurface::new(part, triangles, kind.into()).map_err(refused)?;
        Ok(SurfaceShape {
            surface,
            file: file.to_owned(),
            kind,
            scale: 1.0,
            centre: Vector3::zeros(),
            part: Some(part.to_owned()),
        })
    }
}

impl SurfaceShape {
    /// The surface about a point of the file, or about the centroid of its volume.
    pub(super) fn about(self, centre: Option<Vector3<f64>>) -> Self {
        let centre = centre.unwrap_or_else(|| self.surface.centroid() / self.scale);
        Self {
            surface: self.surface.about(centre * self.scale),
            centre,
            ..self
        }
    }
}
