//! Writes a mesh with a velocity and a pressure field as a VTU file for ParaView.

use std::error::Error;

use mesh::{LinearTets, TetMesh, Vtu};

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let mesh = TetMesh::straight(LinearTets::cube(4))?;

    // A P2 field has one value per node, a P1 field one per vertex.
    let velocity: Vec<f64> = mesh
        .points()
        .iter()
        .flat_map(|x| [x.y * (1.0 - x.y), 0.0, 0.0])
        .collect();
    let pressure: Vec<f64> = mesh.points()[..mesh.n_vertices()]
        .iter()
        .map(|x| -2.0 * x.x)
        .collect();

    let folder = tempfile::tempdir()?;
    let path = folder.path().join("channel.vtu");
    Vtu::cells(&mesh)
        .point_field("velocity", 3, &velocity)?
        .vertex_field("pressure", 1, &pressure)?
        .write(&path)?;

    let bytes = std::fs::metadata(&path)?.len();
    println!("{} has {bytes} bytes", path.display());
    // Positions and velocity have three numbers of 8 bytes per node, the pressure one; each cell
    // has ten node numbers and an offset of 8 bytes, and a type of one byte. Compressed, they take
    // less than half.
    let data = 7 * 8 * mesh.n_points() + (11 * 8 + 1) * mesh.n_cells();
    assert!(usize::try_from(bytes)? < data / 2);
    Ok(())
}
