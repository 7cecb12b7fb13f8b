//! Closed surfaces from files, as bodies and as domains.

use std::path::{Path, PathBuf};

use mesh::{
    InputFile, MAX_MESH_FILE, MeshError, MshFile, Surface, SurfaceFormat, SurfaceMesh, TetMesh,
};
use mesher::{GenerateError, TriangulatedSurface};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::checks::Checks;
use crate::error::SceneError;
use crate::words::SurfaceKind;

/// A closed surface from a file, in the units of the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceShape {
    /// The surface: of a body about its centre and before its rotation, of a domain where it is.
    pub surface: TriangulatedSurface,
    /// The file; a relative path was resolved from the folder of the scene file.
    pub file: PathBuf,
    /// How its triangles are understood.
    pub kind: SurfaceKind,
    /// Length of the scene per length of the file.
    pub scale: f64,
    /// The point of the file that is the centre of the body, in coordinates of the file; zero for a
    /// domain.
    pub centre: Vector3<f64>,
    /// Name of the part of the boundary, if the file is the mesh of the domain.
    pub part: Option<String>,
}

impl SurfaceShape {
    /// Radius on which element sizes are based: three times the volume over the area, but at most
    /// 2.5 times the radius of the largest ball inside.
    ///
    /// The first is the radius of a ball, 1.5 radii of a long tube and 3 half thicknesses of a
    /// plate.
    pub fn size_radius(&self) -> f64 {
        let surface = &self.surface;
        (3.0 * surface.volume() / surface.area()).min(2.5 * surface.inradius())
    }

    /// Volume inside the surface.
    pub fn volume(&self) -> f64 {
        self.surface.volume()
    }

    /// Radius of the ball about the centre that contains the surface.
    pub fn bounding_radius(&self) -> f64 {
        self.surface.bounding_ball().1
    }

    /// The surface about a point of the file, or about the centroid of its volume.
    pub(crate) fn about(self, centre: Option<Vector3<f64>>) -> Self {
        let centre = centre.unwrap_or_else(|| self.surface.centroid() / self.scale);
        Self {
            surface: self.surface.about(centre * self.scale),
            centre,
            ..self
        }
    }
}

/// A file that a scene names, as it was when the scene was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SourceFile {
    /// The path; a relative one was resolved from the folder of the scene file.
    pub path: String,
    /// Hash of its contents ([`mesh::content_hash`]).
    pub hash: u64,
}

impl SourceFile {
    pub(crate) fn new(path: &Path, hash: u64) -> Self {
        Self {
            path: path.display().to_string(),
            hash,
        }
    }
}

/// The surfaces read so far; a file is read once for all bodies that have it.
#[derive(Default)]
pub(crate) struct SurfaceFiles {
    /// All files that were read.
    pub sources: Vec<SourceFile>,
    /// What the user is to be told about them.
    pub warnings: Vec<String>,
    read: Vec<(PathBuf, SurfaceKind, TriangulatedSurface)>,
    /// The mesh of the domain, once it is needed.
    mesh: Option<TetMesh>,
}

/// Keys that describe a surface.
pub(crate) struct SurfaceKeys<'a> {
    /// Group of the keys, such as `bodies[0]`.
    pub group: &'a str,
    pub file: &'a Option<String>,
    pub kind: Option<SurfaceKind>,
    pub scale: Option<f64>,
}

/// The warning about a surface in single precision that is far from the origin.
///
/// At the distance `d` coordinates are rounded to `2^-24 d`: of a surface with the extent `L` the
/// digits `log10(d / L)` are lost. One of the seven is no matter of a warning.
fn lost_digits(name: &str, mesh: &SurfaceMesh) -> Option<String> {
    let start = [f64::INFINITY, f64::NEG_INFINITY].map(Vector3::repeat);
    let [low, high] = (mesh.points.iter()).fold(start, |[l, h], x| [l.inf(x), h.sup(x)]);
    let (extent, distance) = ((high - low).amax(), low.amax().max(high.amax()));
    let lost = (distance / extent).log10();
    (extent > 0.0 && lost >= 2.0).then(|| {
        format!(
            "{name}: the surface is {distance:.1e} from the origin and {extent:.1e} wide: in single \
             precision {lost:.0} of 7 digits are lost, and its points are off by up to {:.1e} of its \
             width; save it near the origin",
            distance / extent * 2_f64.powi(-24)
        )
    })
}

impl SurfaceFiles {
    /// The surface of a file at its own place, checked.
    pub fn read(&mut self, checks: &Checks, keys: SurfaceKeys) -> Result<SurfaceShape, SceneError> {
        self.read_at(checks, &format!("{}.file", keys.group), keys)
    }

    /// The same for a file that another key names.
    pub fn read_at(
        &mut self,
        checks: &Checks,
        key: &str,
        keys: SurfaceKeys,
    ) -> Result<SurfaceShape, SceneError> {
        let why = ": give the STL, OBJ or Gmsh file of the surface";
        let name = checks.required(key, keys.file.as_ref(), why)?;
        let file = checks.0.path().parent().unwrap_or(Path::new("")).join(name);
        let kind = keys.kind.unwrap_or_default();
        let known = (self.read.iter()).find(|(path, of, _)| *path == file && *of == kind);
        let surface = match known {
            Some((.., surface)) => surface.clone(),
            None => {
                let surface = self
                    .surface_of_file(&file, kind)
                    .map_err(|error| checks.bad_value(key, format!("is refused: {error}")))?;
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

    fn surface_of_file(
        &mut self,
        file: &Path,
        kind: SurfaceKind,
    ) -> Result<TriangulatedSurface, GenerateError> {
        let format = SurfaceFormat::from_path(file)?;
        let bytes = self.bytes(file)?;
        let name = file.display().to_string();
        let mesh = SurfaceMesh::parse(&name, &bytes, format)?;
        if format.has_single_precision(&bytes) {
            self.warnings.extend(lost_digits(&name, &mesh));
        }
        TriangulatedSurface::new(&name, mesh, kind.into())
    }

    /// The bytes of a file, which is noted with their hash.
    pub fn bytes(&mut self, file: &Path) -> Result<Vec<u8>, MeshError> {
        let read = InputFile::read(file, MAX_MESH_FILE).map_err(|source| MeshError::Io {
            path: file.to_owned(),
            source,
        })?;
        let source = SourceFile::new(file, read.hash);
        if !self.sources.contains(&source) {
            self.sources.push(source);
        }
        Ok(read.bytes)
    }

    /// The domain's mesh, which is read once.
    pub fn mesh(&mut self, file: &Path) -> Result<&TetMesh, MeshError> {
        match &mut self.mesh {
            Some(mesh) => Ok(mesh),
            none => Ok(none.insert(MshFile::read(file)?.into_mesh(&[])?)),
        }
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
        let mesh = self.mesh(file).map_err(|error| refused(error.into()))?;
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
