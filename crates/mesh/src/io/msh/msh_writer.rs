//! Writer of MSH 4.1 text files of second order.

use std::io::Write;
use std::ops::Range;
use std::path::Path;

use super::super::atomic_file::write_file;
use crate::{MeshError, TetMesh};

/// Writes `mesh` as MSH 4.1, text, second order.
///
/// Boundary parts are the physical groups 1, 2, ... of surfaces. The regions follow as groups of
/// one volume each; without named regions all cells are in the group `fluid`. Coordinates have
/// enough digits to read back as the same bits.
///
/// # Errors
/// [`MeshError::Io`].
pub(crate) fn write_msh(mesh: &TetMesh, path: &Path) -> Result<(), MeshError> {
    write_file(path, |out| {
        let n_tags = mesh.tags().len();
        let [low, high] = mesh.bounding_box();
        let bounds = format!(
            "{} {} {} {} {} {}",
            low.x, low.y, low.z, high.x, high.y, high.z
        );
        writeln!(out, "$MeshFormat\n4.1 0 8\n$EndMeshFormat")?;
        let fluid = [String::from("fluid")];
        let regions = match &mesh.regions().names[..] {
            [] => &fluid[..],
            names => names,
        };
        let n_regions = regions.len();
        writeln!(out, "$PhysicalNames\n{}", n_tags + n_regions)?;
        for (tag, name) in mesh.tags().iter().enumerate() {
            writeln!(out, "2 {} \"{name}\"", tag + 1)?;
        }
        for (region, name) in regions.iter().enumerate() {
            writeln!(out, "3 {} \"{name}\"", n_tags + 1 + region)?;
        }
        writeln!(out, "$EndPhysicalNames")?;
        writeln!(out, "$Entities\n0 0 {n_tags} {n_regions}")?;
        for surface in 1..=n_tags {
            writeln!(out, "{surface} {bounds} 1 {surface} 0")?;
        }
        for volume in 1..=n_regions {
            write!(out, "{volume} {bounds} 1 {} {n_tags}", n_tags + volume)?;
            for surface in 1..=n_tags {
                write!(out, " {surface}")?;
            }
            writeln!(out)?;
        }
        writeln!(out, "$EndEntities")?;

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
        let runs = region_runs(mesh);
        let n_blocks = n_tags + runs.len();
        writeln!(out, "$Elements\n{n_blocks} {n_elements} 1 {n_elements}")?;
        let mut element = 0;
        // Facets are sorted by tag, and each tag has at least one.
        for facets in mesh.facets().chunk_by(|a, b| a.tag == b.tag) {
            writeln!(out, "2 {} 9 {}", facets[0].tag + 1, facets.len())?;
            for facet in facets {
                element += 1;
                line(out, element, &facet.nodes)?;
            }
        }
        for (region, cells) in runs {
            writeln!(out, "3 {} 11 {}", region + 1, cells.len())?;
            for cell in &mesh.cells()[cells] {
                element += 1;
                let mut nodes = *cell;
                // The last two midside nodes are those of edges 13 and 23 in VTK, 23 and 13 in
                // Gmsh.
                nodes.swap(8, 9);
                line(out, element, &nodes)?;
            }
        }
        writeln!(out, "$EndElements")
    })
}

/// Consecutive cells of one region, in the order of the cells.
fn region_runs(mesh: &TetMesh) -> Vec<(u16, Range<usize>)> {
    let of_cells = &mesh.regions().of_cells;
    if of_cells.is_empty() {
        return vec![(0, 0..mesh.n_cells())];
    }
    let mut end = 0;
    let run = |cells: &[u16]| {
        let start = end;
        end += cells.len();
        (cells[0], start..end)
    };
    of_cells.chunk_by(|a, b| a == b).map(run).collect()
}

/// Writes the line of one element.
fn line(out: &mut dyn Write, element: usize, nodes: &[u32]) -> std::io::Result<()> {
    write!(out, "{element}")?;
    for node in nodes {
        write!(out, " {}", node + 1)?;
    }
    writeln!(out)
}
