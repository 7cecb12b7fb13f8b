//! Triangulated surfaces from files: STL, OBJ and the triangles of Gmsh files.

mod obj;
mod stl;

use std::path::Path;

use super::input_file::read_mesh_file;
use super::msh::surface_of_msh;
use crate::{FileLocation, MeshError, SurfaceMesh};

/// Formats of surface files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum SurfaceFormat {
    /// STL, text or binary. Corners closer than 1e-6 of the extent are one vertex.
    Stl,
    /// Wavefront OBJ; polygons with more than three corners are divided from their first corner.
    Obj,
    /// Gmsh MSH, of which all triangles are read. Those of second order become four each.
    Msh,
}

impl SurfaceFormat {
    /// The format to which the extension of a file name belongs.
    ///
    /// # Errors
    /// [`MeshError::UnknownSurfaceFormat`].
    pub fn from_path(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        match extension.to_ascii_lowercase().as_str() {
            "stl" => Ok(Self::Stl),
            "obj" => Ok(Self::Obj),
            "msh" => Ok(Self::Msh),
            _ => Err(MeshError::UnknownSurfaceFormat { path: path.into() }),
        }
    }

    /// Whether a file of this format with these contents has its coordinates in single precision,
    /// `2^-24` of their size: a surface far from the origin loses digits.
    pub fn has_single_precision(self, bytes: &[u8]) -> bool {
        self == Self::Stl && stl::is_binary(bytes)
    }
}

impl SurfaceMesh {
    /// Reads the triangles of the STL, OBJ or Gmsh file at `path`.
    ///
    /// Whether they are a closed surface is not checked here but by
    /// `mesher::TriangulatedSurface`.
    ///
    /// # Errors
    /// [`MeshError::UnknownSurfaceFormat`], [`MeshError::Io`], or as [`SurfaceMesh::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let format = SurfaceFormat::from_path(path)?;
        Self::parse(&path.display().to_string(), &read_mesh_file(path)?, format)
    }

    /// Reads the contents of a file; `name` is the name of the file in error messages.
    ///
    /// Triangles are in the order of the file.
    ///
    /// # Errors
    /// [`MeshError::Malformed`] with the line (text) or offset (binary) of anything that is not
    /// well-formed, and for a file without triangles.
    pub fn parse(name: &str, bytes: &[u8], format: SurfaceFormat) -> Result<Self, MeshError> {
        let mesh = match format {
            SurfaceFormat::Stl => stl::parse(name, bytes)?,
            SurfaceFormat::Obj => obj::parse(name, bytes)?,
            SurfaceFormat::Msh => surface_of_msh(name, bytes)?,
        };
        if mesh.triangles.is_empty() {
            let problem = "the file has no triangles; save the surface as triangles";
            return Err(malformed(name, FileLocation::Line(1), problem));
        }
        Ok(mesh)
    }
}

fn malformed(file: &str, location: FileLocation, problem: impl Into<String>) -> MeshError {
    MeshError::Malformed {
        file: file.into(),
        location,
        problem: problem.into(),
    }
}

/// The text of a file; `expected` names its format.
fn text<'a>(name: &str, bytes: &'a [u8], expected: &str) -> Result<&'a str, MeshError> {
    std::str::from_utf8(bytes).map_err(|error| {
        let location = FileLocation::Byte(error.valid_up_to());
        malformed(name, location, format!("this is not {expected}"))
    })
}

/// A finite number.
fn number(word: Option<&str>) -> Result<f64, String> {
    let Some(word) = word else {
        return Err("a coordinate is missing; each point needs three".to_owned());
    };
    match word.parse() {
        Ok(value) if f64::is_finite(value) => Ok(value),
        Ok(_) => Err(format!("the coordinate '{word}' is not finite")),
        Err(_) => {
            let word: String = word.chars().take(40).collect();
            Err(format!("'{word}' is not a number"))
        }
    }
}
