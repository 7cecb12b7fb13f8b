//! Reads a Gmsh file with two regions.

use mesh::{MeshError, MshFile};

/// Two tets on the same triangle, one in each region; the boundary is one physical group.
const FILE: &str = r#"$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
3
2 1 "wall"
3 2 "water"
3 3 "oil"
$EndPhysicalNames
$Nodes
5
1 0 0 0
2 1 0 0
3 0 1 0
4 0 0 1
5 0 0 -2
$EndNodes
$Elements
8
1 4 2 2 1 1 2 3 4
2 4 2 3 2 1 2 3 5
3 2 2 1 1 1 2 4
4 2 2 1 1 2 3 4
5 2 2 1 1 3 1 4
6 2 2 1 1 1 2 5
7 2 2 1 1 2 3 5
8 2 2 1 1 3 1 5
$EndElements
"#;

pub(crate) fn main() -> Result<(), MeshError> {
    // `MshFile::read(path)` reads a file from disk.
    let file = MshFile::parse("two_tets.msh", FILE.as_bytes())?;
    let mesh = file.into_mesh(&[])?;

    println!("boundary parts  {}", mesh.tags().join(", "));
    let regions = mesh.regions();
    let mut volumes = vec![0.0; regions.names.len()];
    for (cell, &region) in regions.of_cells.iter().enumerate() {
        volumes[usize::from(region)] += mesh.cell_volume(cell);
    }
    for (name, volume) in regions.names.iter().zip(&volumes) {
        println!("{name:<14}  volume {volume:.6}");
    }

    assert_eq!(mesh.tags(), ["wall"]);
    assert_eq!(regions.names, ["water", "oil"]);
    assert!((volumes[0] - 1.0 / 6.0).abs() < 1e-15 && (volumes[1] - 1.0 / 3.0).abs() < 1e-15);
    Ok(())
}
