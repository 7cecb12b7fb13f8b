//! Public functions on hostile arguments: a right answer or an error, never a panic.
//!
//! Functions of one cell index a slice and panic for a cell that does not exist, as documented.

use mesh::{
    LinearTets, MshFile, Pvd, TetMesh, Vec3, dihedral_angles, mean_ratio, scaled_jacobian_bound,
};
use proptest::prelude::*;

use crate::shapes::as_quadratic;

fn number() -> impl Strategy<Value = f64> {
    let hostile = [0.0, -1.0, 5e-324, 1e-300, 1e-9, 1e9, 1e150, 1e300];
    let beyond = [f64::MAX, f64::NAN, f64::INFINITY];
    let hostile = [&hostile[..], &beyond].concat();
    prop_oneof![10 => -3.0..3.0, 1 => proptest::sample::select(hostile)]
}

fn vector() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(number()).prop_map(Vec3::from)
}

/// Numbers of items, most of which exist.
fn item() -> impl Strategy<Value = u32> {
    prop_oneof![20 => 0..8u32, 1 => any::<u32>()]
}

/// A valid mesh has finite points and cells with positive volumes.
fn check(mesh: &TetMesh) {
    assert!(
        mesh.points()
            .iter()
            .all(|p| p.iter().all(|x| x.is_finite()))
    );
    assert!((0..mesh.n_cells()).all(|cell| mesh.cell_volume(cell) > 0.0));
    assert!(mesh.volume() > 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    #[test]
    fn quadratic_meshes_of_hostile_arrays_are_valid_or_refused(
        (cell, local, node) in (0..6usize, 0..10usize, item()), (p, change) in (vector(), 0..3usize),
    ) {
        let mesh = TetMesh::straight(LinearTets::cube(1)).expect("a cube");
        let mut tets = as_quadratic(&mesh);
        match change {
            0 => tets.tets[cell][local] = node,
            1 => tets.points[node as usize % mesh.n_points()] = p,
            _ => tets.faces[cell].0[local % 6] = node,
        }
        let _ = TetMesh::quadratic(tets, &[]).map(|mesh| check(&mesh));
    }

    #[test]
    fn measures_of_hostile_tets_do_not_panic(x in prop::array::uniform10(vector())) {
        let [a, b, c, d, ..] = x;
        let (ratio, bound) = (mean_ratio([a, b, c, d]), scaled_jacobian_bound(&x));
        prop_assert!(ratio.is_nan() || ratio <= 1.0 + 1e-12, "{ratio}");
        prop_assert!(bound.is_nan() || bound <= 1.0 + 1e-12, "{bound}");
        let _ = dihedral_angles([a, b, c, d]);
    }

    #[test]
    fn text_that_is_no_mesh_is_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(MshFile::parse("noise", &bytes).is_err());
        let head = [b"$MeshFormat\n4.1 1 8\n\x01\0\0\0\n$EndMeshFormat\n$Nodes\n", &bytes[..]];
        prop_assert!(MshFile::parse("noise", &head.concat()).is_err());
    }
}

#[test]
fn a_cube_of_too_many_tets_is_no_mesh() {
    for n in [355, 1625, u32::MAX] {
        assert!(TetMesh::straight(LinearTets::cube(n)).is_err());
    }
    assert_eq!(LinearTets::cube(0), LinearTets::cube(1));
}

#[test]
fn a_time_that_is_not_finite_is_not_written() {
    let mut series = Pvd::new();
    series.push(f64::NAN, "a.vtu");
    assert!(
        series
            .write(std::env::temp_dir().join("never.pvd"))
            .is_err()
    );
}

#[test]
fn bug_a_jacobian_that_overflowed_was_valid() {
    let mesh = TetMesh::straight(LinearTets::cube(1)).expect("a cube");
    let mut points: Vec<Vec3> = mesh.points().iter().map(|p| 1e200 * p).collect();
    points[mesh.n_vertices()] += Vec3::repeat(1e199);
    assert!(mesh.with_points(points).is_err());
}
