//! Gmsh MSH files: reader of versions 4.1 and 2, text and binary, first and second order; writer of 4.1 text.
//!
//! Our own, because the one crate for it (mshio 0.4) reads 4.1 only, skips the names of groups and says of an
//! error neither line nor offset.

mod gather;
mod scan;
mod version2;
mod version4;
mod write;

use std::path::Path;

pub(super) use self::write::write_msh;

use self::gather::Gather;
use self::scan::{Encoding, Scanner};
use crate::{LinearTets, MeshError, NamedSurface, QuadraticTets, TetMesh};

/// A mesh as a MSH file has it: tets and tagged boundary triangles of first or second order.
///
/// Boundary parts are the physical groups of surfaces, in order of their numbers, by name (by number if a group has no name;
/// `surface 7` if geometric surface 7 is in no group). All tets count as fluid; points, curves and nodes that
/// no tet or triangle has are dropped. Nodes come in order of their numbers.
#[derive(Clone, Debug, PartialEq)]
pub enum MshFile {
    /// 4-node tets and 3-node triangles.
    Linear(LinearTets),
    /// 10-node tets and 6-node triangles.
    Quadratic(QuadraticTets),
}

impl MshFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`MeshError::Io`], or as [`MshFile::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        let bytes = std::fs::read(path).map_err(|source| MeshError::Io {
            path: path.into(),
            source,
        })?;
        Self::parse(&path.display().to_string(), &bytes)
    }

    /// Reads the bytes of a file; `name` is what errors call it.
    ///
    /// Cost: one pass; memory is bounded by a multiple of the file's size, whatever counts it announces.
    ///
    /// # Errors
    /// [`MeshError::Malformed`] with line (text) or offset (binary) for anything that is not well-formed MSH 4.1 or 2,
    /// for other volume elements than tets, for mixed orders, for a surface in two groups.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Self, MeshError> {
        let mut scanner = Scanner::new(name, bytes);
        let scanner = &mut scanner;
        let mut gather = Gather::default();
        let mut version = None;
        let mut groups = None;
        while let Some(section) = scanner.open()? {
            match (section.as_str(), version) {
                ("MeshFormat", None) => version = Some(format(scanner)?),
                ("MeshFormat", Some(_)) => {
                    return scanner.error("a second $MeshFormat; keep one mesh a file");
                }
                ("PhysicalNames", Some(_)) => physical_names(scanner, &mut gather)?,
                ("Entities", Some(Version::Four)) => groups = version4::entities(scanner)?,
                ("PartitionedEntities", Some(Version::Four)) => {
                    return scanner.error("the mesh is partitioned; save it unpartitioned");
                }
                ("ParametricNodes", Some(Version::Two)) => {
                    return scanner.error(
                        "$ParametricNodes cannot be read; save with Mesh.SaveParametric = 0",
                    );
                }
                ("Nodes", Some(Version::Two)) => version2::nodes(scanner, &mut gather)?,
                ("Nodes", Some(Version::Four)) => version4::nodes(scanner, &mut gather)?,
                ("Elements", Some(Version::Two)) => version2::elements(scanner, &mut gather)?,
                ("Elements", Some(Version::Four)) => {
                    version4::elements(scanner, &mut gather, &groups)?
                }
                ("Nodes" | "Elements" | "Entities" | "PhysicalNames", None) => {
                    return scanner.error(
                        "$MeshFormat must come first; is this a Gmsh mesh of version 4.1 or 2?",
                    );
                }
                _ => {
                    scanner.skip()?;
                    continue;
                }
            }
            scanner.close()?;
        }
        match version {
            Some(_) => gather.finish(scanner),
            None => scanner.error("no $MeshFormat section: this is no Gmsh mesh"),
        }
    }

    /// Names of the boundary parts.
    pub fn tags(&self) -> &[String] {
        match self {
            Self::Linear(tets) => &tets.tags,
            Self::Quadratic(tets) => &tets.tags,
        }
    }

    /// The mesh, with the nodes of the named parts put on their true surfaces.
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

#[derive(Clone, Copy)]
enum Version {
    Two,
    Four,
}

/// `$MeshFormat`: version, text or binary, width of `size_t`; in binary files a 1 that shows the byte order.
fn format(scanner: &mut Scanner) -> Result<Version, MeshError> {
    let word = scanner.word()?;
    let version = match word.as_str() {
        "4.1" => Version::Four,
        "2" | "2.0" | "2.1" | "2.2" => Version::Two,
        _ => {
            return scanner.error(format!(
                "MSH version '{word}' cannot be read; save as 4.1 or 2.2 (Gmsh: Mesh.MshFileVersion)"
            ));
        }
    };
    let binary = match scanner.number()? {
        0 => false,
        1 => true,
        other => {
            return scanner.error(format!(
                "the file type must be 0 (text) or 1 (binary), not {other}"
            ));
        }
    };
    scanner.size_width = match (scanner.number()?, version) {
        (4, Version::Four) => 4,
        (8, _) => 8,
        (other, _) => return scanner.error(format!("the data size must be 8, not {other}")),
    };
    scanner.line();
    if binary {
        scanner.encoding = Encoding::LittleEndian;
        scanner.encoding = match scanner.int()?.to_le_bytes() {
            [1, 0, 0, 0] => Encoding::LittleEndian,
            [0, 0, 0, 1] => Encoding::BigEndian,
            _ => return scanner.error("the byte order mark is not the number 1"),
        };
    }
    Ok(version)
}

/// `$PhysicalNames`, text in binary files too: dimension, number and name in quotes, a group a line.
fn physical_names(scanner: &mut Scanner, gather: &mut Gather) -> Result<(), MeshError> {
    let count: u64 = scanner.number()?;
    for _ in 0..count {
        let dimension: i32 = scanner.number()?;
        let group: i32 = scanner.number()?;
        let line = scanner.line();
        let name = line
            .strip_prefix('"')
            .and_then(|rest| rest.strip_suffix('"'));
        match name {
            Some(name) if dimension == 2 => gather.name_group(group, name.into()),
            Some(_) => {}
            None => return scanner.error(format!("physical group {group} needs a name in quotes")),
        }
    }
    Ok(())
}
