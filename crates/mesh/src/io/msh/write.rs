//! Writer of MSH 4.1 text files of second order.

use std::io::Write;
use std::path::Path;

use super::super::atomic::write_atomically;
use crate::{MeshError, TetMesh};

/// Writes `mesh` as MSH 4.1, text, second order: boundary parts as physical groups 1, 2, ... of surfaces, all cells as
/// group `fluid` of one volume.
///
/// Coordinates are written with as many digits as bring back the same bits.
///
/// # Errors
/// [`MeshError::Io`].
pub(crate) fn write_msh(mesh: &TetMesh, path: &Path) -> Result<(), MeshError> {
    write_atomically(path, |out| {
        let n_tags = mesh.tags().len();
        let [low, high] = mesh.bounding_box();
        let bounds = format!(
            "{} {} {} {} {} {}",
            low.x, low.y, low.z, high.x, high.y, high.z
        );
        writeln!(out, "$MeshFormat\n4.1 0 8\n$EndMeshFormat")?;
        writeln!(out, "$PhysicalNames\n{}", n_tags + 1)?;
        for (tag, name) in mesh.tags().iter().enumerate() {
            writeln!(out, "2 {} \"{name}\"", tag + 1)?;
        }
        writeln!(out, "3 {} \"fluid\"\n$EndPhysicalNames", n_tags + 1)?;
        writeln!(out, "$Entities\n0 0 {n_tags} 1")?;
        for surface in 1..=n_tags {
            writeln!(out, "{surface} {bounds} 1 {surface} 0")?;
        }
        write!(out, "1 {bounds} 1 {} {n_tags}", n_tags + 1)?;
        for surface in 1..=n_tags {
            write!(out, " {surface}")?;
        }
        writeln!(out, "\n$EndEntities")?;

        let n_points = mesh.n_points();
        writeln!(out, "$Nodes\n1 {n_points} 1 {n_points}\n3 1 0 {n_points}")?;
        for node in 1..=n_points {
            writeln!(out, "{node}")?;
        }
        for p in mesh.points() {
            writeln!(out, "{} {} {}", p.x, p.y, p.z)?;
        }
        writeln!(out, "$EndNodes")?;

        let n_elements = mesh.facets().len() + mesh.n_cells();
        writeln!(out, "$Elements\n{} {n_elements} 1 {n_elements}", n_tags + 1)?;
        let mut element = 0;
        // Facets are sorted by tag, and each tag has some.
        for facets in mesh.facets().chunk_by(|a, b| a.tag == b.tag) {
            writeln!(out, "2 {} 9 {}", facets[0].tag + 1, facets.len())?;
            for facet in facets {
                element += 1;
                line(out, element, &facet.nodes)?;
            }
        }
        writeln!(out, "3 1 11 {}", mesh.n_cells())?;
        for cell in mesh.cells() {
            element += 1;
            let mut nodes = *cell;
            // VTK has the middles of edges 13 and 23 last, Gmsh those of 23 and 13.
            nodes.swap(8, 9);
            line(out, element, &nodes)?;
        }
        writeln!(out, "$EndElements")
    })
}

fn line(out: &mut dyn Write, element: usize, nodes: &[u32]) -> std::io::Result<()> {
    write!(out, "{element}")?;
    for node in nodes {
        write!(out, " {}", node + 1)?;
    }
    writeln!(out)
}
