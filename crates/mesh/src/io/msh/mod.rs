//! Gmsh MSH files: reader and writer.
//!
//! The reader accepts versions 4.1 and 2, text and binary, first and second order. The writer
//! produces 4.1 text.
//!
//! The reader is our own because the only crate for it (mshio 0.4) reads 4.1 only, skips the names
//! of groups, and gives neither line nor offset of an error.

mod gather;
mod msh_writer;
mod read;
mod scan;
mod version2;
mod version4;

pub(super) use msh_writer::write_msh;
pub(super) use read::surface_of_msh;

use crate::{LinearTets, MeshError, NamedSurface, QuadraticTets, Regions, TetMesh};

/// Contents of a MSH file: tets and tagged boundary triangles of first or second order.
///
/// Boundary parts are the physical groups of surfaces, in the order of their numbers. A group
/// without a name is named by its number; geometric surface 7 is named `surface 7` if it is in no
/// group. All tets count as fluid. If they belong to several physical groups of volumes, these
/// become named [`Regions`]; a volume in several groups belongs to the first one, and volume 7
/// is named `volume 7` if it is in no group. Points, curves and unused nodes are dropped. Nodes
/// are in the order of their numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum MshFile {
    /// 4-node tets and 3-node triangles.
    Linear(LinearTets),
    /// 10-node tets and 6-node triangles.
    Quadratic(QuadraticTets),
}

impl MshFile {
    /// Names of the boundary parts.
    pub fn tags(&self) -> &[String] {
        match self {
            Self::Linear(tets) => &tets.tags,
            Self::Quadratic(tets) => &tets.tags,
        }
    }

    /// Named parts of the volume; empty unless there are several.
    pub fn regions(&self) -> &Regions {
        match self {
            Self::Linear(tets) => &tets.regions,
            Self::Quadratic(tets) => &tets.regions,
        }
    }

    /// The mesh, with the nodes of the named boundary parts moved to their true surfaces.
    ///
    /// # Errors
    /// As [`TetMesh::curved`] and [`TetMesh::quadratic`].
    pub fn into_mesh(self, surfaces: &[NamedSurface]) -> Result<TetMesh, MeshError> {
        match self {
            Self::Linear(tets) => TetMesh::curved(tets, surfaces),
            Self::Quadratic(tets) => TetMesh::quadratic(tets, surfaces),
        }
    }
}
