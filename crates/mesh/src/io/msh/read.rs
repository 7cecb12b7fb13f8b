//! Reading MSH files, section by section.

use std::path::Path;

use super::super::input_file::read_mesh_file;
use super::MshFile;
use super::gather::Gather;
use super::scan::{Encoding, Scanner};
use super::{version2, version4};
use crate::{MeshError, SurfaceMesh};

impl MshFile {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`MeshError::Io`], or as [`MshFile::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, MeshError> {
        let path = path.as_ref();
        Self::parse(&path.display().to_string(), &read_mesh_file(path)?)
    }

    /// Reads the contents of a file; `name` is the name of the file in error messages.
    ///
    /// Cost: one pass. Memory is bounded by a multiple of the file's size, regardless of the counts
    /// that the file announces.
    ///
    /// # Errors
    /// [`MeshError::Malformed`] with the line (text) or offset (binary) of anything that is not
    /// well-formed MSH 4.1 or 2, of volume elements other than tets, of mixed orders, and of a
    /// surface in two groups.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Self, MeshError> {
        let mut scanner = Scanner::new(name, bytes);
        gather(&mut scanner)?.finish(&scanner)
    }
}

/// The triangles of a file, with or without tets.
pub(in crate::io) fn surface_of_msh(name: &str, bytes: &[u8]) -> Result<SurfaceMesh, MeshError> {
    let mut scanner = Scanner::new(name, bytes);
    Ok(gather(&mut scanner)?.surface())
}

/// Reads all sections.
fn gather(scanner: &mut Scanner) -> Result<Gather, MeshError> {
    let mut gather = Gather::default();
    let mut version = None;
    let mut groups = None;
    while let Some(section) = scanner.open()? {
        match (section.as_str(), version) {
            ("MeshFormat", None) => version = Some(format(scanner)?),
            ("MeshFormat", Some(_)) => {
                return scanner.error("a second $MeshFormat; keep one mesh per file");
            }
            ("PhysicalNames", Some(_)) => physical_names(scanner, &mut gather)?,
            ("Entities", Some(Version::Four)) => groups = version4::entities(scanner)?,
            ("PartitionedEntities", Some(Version::Four)) => {
                return scanner.error("the mesh is partitioned; save it unpartitioned");
            }
            ("ParametricNodes", Some(Version::Two)) => {
                return scanner
                    .error("$ParametricNodes cannot be read; save with Mesh.SaveParametric = 0");
            }
            ("Nodes", Some(Version::Two)) => version2::nodes(scanner, &mut gather)?,
            ("Nodes", Some(Version::Four)) => version4::nodes(scanner, &mut gather)?,
            ("Elements", Some(Version::Two)) => version2::elements(scanner, &mut gather)?,
            ("Elements", Some(Version::Four)) => version4::elements(scanner, &mut gather, &groups)?,
            ("NOD" | "ELM", None) => {
                return scanner.error(format!(
                    "section ${section} belongs to MSH version 1, which is too old; {SAVE_AGAIN}"
                ));
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
        Some(_) => Ok(gather),
        None => scanner.error("no $MeshFormat section: this is not a Gmsh mesh"),
    }
}

/// Remedy for files of other versions.
const SAVE_AGAIN: &str = "save it as version 4.1 or 2.2 (Gmsh: Mesh.MshFileVersion)";

/// Version of the file format: 2 or 4.1.
#[derive(Clone, Copy)]
enum Version {
    Two,
    Four,
}

/// Reads `$MeshFormat`: version, text or binary, width of `size_t`.
///
/// In binary files the number 1 follows, which shows the byte order.
fn format(scanner: &mut Scanner) -> Result<Version, MeshError> {
    let word = scanner.word()?;
    let version = match word.as_str() {
        "4.1" => Version::Four,
        "2" | "2.0" | "2.1" | "2.2" => Version::Two,
        "1" | "1.0" | "1.1" => {
            return scanner.error(format!("MSH version '{word}' is too old; {SAVE_AGAIN}"));
        }
        _ => {
            return scanner.error(format!("MSH version '{word}' cannot be read; {SAVE_AGAIN}"));
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

/// Reads `$PhysicalNames`, which is text in binary files too.
///
/// Each line has the dimension, the number and, in quotes, the name of a group.
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
            Some(name) => gather.name_group(dimension, group, name.into()),
            None => return scanner.error(format!("physical group {group} needs a name in quotes")),
        }
    }
    Ok(())
}
