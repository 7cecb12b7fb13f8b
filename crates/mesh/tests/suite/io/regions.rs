//! Several regions in one file keep their names.

use mesh::{LinearTets, MeshError, MshFile, Regions, TetMesh};

use crate::shapes::as_quadratic;

/// A cube whose lower half is water and whose upper half is oil.
fn halves() -> LinearTets {
    let mut cube = LinearTets::cube(2);
    let of_cells = cube.tets.iter().map(|tet| {
        let z: f64 = tet.iter().map(|&v| cube.points[v as usize].z).sum();
        u16::from(z > 2.0)
    });
    cube.regions = Regions {
        of_cells: of_cells.collect(),
        names: vec!["water".into(), "oil".into()],
    };
    cube
}

#[test]
fn regions_follow_their_cells_through_renumbering() {
    let mesh = TetMesh::straight(halves()).unwrap();
    assert_eq!(mesh.regions().names, ["water", "oil"]);
    for (cell, &region) in mesh.regions().of_cells.iter().enumerate() {
        let z: f64 = mesh.cell_vertices(cell).iter().map(|x| x.z).sum();
        assert_eq!(region, u16::from(z > 2.0));
    }
}

#[test]
fn regions_read_back_as_written() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = TetMesh::straight(halves()).unwrap();
    let path = folder.path().join("halves.msh");
    mesh.write(&path).unwrap();
    let MshFile::Quadratic(read) = MshFile::read(&path).unwrap() else {
        panic!("written as second order");
    };
    assert_eq!(read, as_quadratic(&mesh));
}

#[test]
fn version_2_has_regions_by_group_or_volume() {
    let text = |groups: [u32; 2], names: &str| {
        format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n{names}$EndPhysicalNames\n\
             $Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1\n$EndNodes\n\
             $Elements\n2\n1 4 2 {} 1 1 2 3 4\n2 4 2 {} 2 1 2 3 5\n$EndElements\n",
            groups[0], groups[1]
        )
    };
    let names = |text: String| {
        let file = MshFile::parse("two.msh", text.as_bytes()).unwrap();
        assert_eq!(
            file.regions().of_cells.len(),
            2 * usize::from(!file.regions().is_empty())
        );
        file.regions().names.clone()
    };
    let named = "3\n2 4 \"surface\"\n3 4 \"water\"\n3 7 \"oil\"\n";
    assert_eq!(names(text([7, 4], named)), ["water", "oil"]);
    assert_eq!(names(text([7, 4], "0\n")), ["4", "7"]);
    assert_eq!(names(text([0, 0], "0\n")), ["volume 1", "volume 2"]);
    // One region needs no name.
    assert!(names(text([4, 4], named)).is_empty());
}

#[test]
fn bad_regions_are_refused() {
    let refused = |change: &dyn Fn(&mut Regions), message: &str| {
        let mut tets = halves();
        change(&mut tets.regions);
        let error = TetMesh::straight(tets).unwrap_err();
        assert!(error.to_string().contains(message), "{error}");
        error
    };
    refused(
        &|r| {
            r.of_cells.pop();
        },
        "list of the cells' regions has 47 entries, but the mesh needs 48",
    );
    refused(&|r| r.names.clear(), "has 48 entries, but the mesh needs 0");
    refused(&|r| r.of_cells[5] = 2, "region of tet 5 refers to number 2");
    let error = refused(&|r| r.names[1] = "water".into(), "'water' is named twice");
    assert!(matches!(error, MeshError::BadRegion { .. }));
}
