//! Properties of all meshes, on random input.

use crate::shapes::{ball, curved_ball};
use mesh::{
    LinearTets, TET_EDGES, TetMesh, Vec3, dihedral_angles, mean_ratio, scaled_jacobian_bound,
};
use proptest::prelude::*;

fn vector(size: f64) -> impl Strategy<Value = Vec3> {
    (-size..size, -size..size, -size..size).prop_map(|(x, y, z)| Vec3::new(x, y, z))
}

/// A cube or ball, and the same with shuffled vertices, tets and faces and rotated tets.
fn shuffled() -> impl Strategy<Value = (LinearTets, LinearTets)> {
    let mesh = prop_oneof![
        (1_u32..4).prop_map(LinearTets::cube),
        (1_u32..4).prop_map(ball)
    ];
    mesh.prop_flat_map(|mesh| {
        let order = Just((0..mesh.points.len()).collect::<Vec<_>>()).prop_shuffle();
        let tets = Just(mesh.tets.clone()).prop_shuffle();
        let faces = Just(mesh.faces.clone()).prop_shuffle();
        (Just(mesh), order, tets, faces, any::<u64>())
    })
    .prop_map(|(mesh, order, tets, faces, rotations)| {
        let mut new = vec![0; order.len()];
        for (number, &old) in order.iter().enumerate() {
            new[old] = number as u32;
        }
        let shuffled = LinearTets {
            points: order.iter().map(|&old| mesh.points[old]).collect(),
            tets: tets
                .iter()
                .enumerate()
                .map(|(i, tet)| {
                    let mut tet = tet.map(|v| new[v as usize]);
                    tet.rotate_left((rotations >> (i % 62)) as usize & 3);
                    tet
                })
                .collect(),
            faces: faces
                .iter()
                .map(|(face, tag)| (face.map(|v| new[v as usize]), *tag))
                .collect(),
            tags: mesh.tags.clone(),
            ..LinearTets::default()
        };
        (mesh, shuffled)
    })
}

/// Area vectors of the straight boundary parts.
fn area_vectors(mesh: &TetMesh) -> Vec<Vec3> {
    let mut areas = vec![Vec3::zeros(); mesh.tags().len()];
    for facet in mesh.facets() {
        let [a, b, c, ..] = facet.nodes.map(|node| mesh.points()[node as usize]);
        areas[facet.tag as usize] += 0.5 * (b - a).cross(&(c - a));
    }
    areas
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// The numbering of the input affects the numbering of the mesh only.
    #[test]
    fn renumbering_keeps_volume_counts_and_boundary((ordered, shuffled) in shuffled()) {
        let a = TetMesh::straight(ordered).unwrap();
        let b = TetMesh::straight(shuffled).unwrap();
        prop_assert_eq!(
            (a.n_vertices(), a.n_points(), a.n_cells(), a.facets().len()),
            (b.n_vertices(), b.n_points(), b.n_cells(), b.facets().len())
        );
        prop_assert!((a.volume() - b.volume()).abs() < 1e-13);
        for (p, q) in area_vectors(&a).iter().zip(area_vectors(&b)) {
            prop_assert!((p - q).norm() < 1e-13);
        }
        // The set of nodes is the same, in any order.
        let places = |mesh: &TetMesh| {
            let mut places: Vec<[u64; 3]> = mesh.points().iter().map(|p| [p.x, p.y, p.z].map(|x| (x + 0.0).to_bits())).collect();
            places.sort_unstable();
            places
        };
        prop_assert_eq!(places(&a), places(&b));
        // The boundary is closed: the area vectors of all facets cancel.
        prop_assert!(area_vectors(&b).iter().sum::<Vec3>().norm() < 1e-13);
    }

    /// No sample of the Jacobian is below its bound.
    #[test]
    fn jacobian_bound_is_below_all_samples(
        corners in prop::array::uniform4(vector(1.0)),
        bends in prop::array::uniform6(vector(0.15)),
    ) {
        let volume = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).dot(&(corners[3] - corners[0])).abs();
        prop_assume!(volume > 0.1);
        let mut nodes = [Vec3::zeros(); 10];
        nodes[..4].copy_from_slice(&corners);
        for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
            nodes[4 + k] = 0.5 * (corners[i] + corners[j]) + bends[k];
        }
        let bound = scaled_jacobian_bound(&nodes);
        let n = 12;
        let mut smallest = f64::INFINITY;
        for i in 0..=n {
            for j in 0..=n - i {
                for k in 0..=n - i - j {
                    let l = [n - i - j - k, i, j, k].map(|c| f64::from(c) / f64::from(n));
                    let mut slopes = [Vec3::zeros(); 4];
                    for v in 0..4 {
                        slopes[v] += (4.0 * l[v] - 1.0) * nodes[v];
                    }
                    for (e, [v, w]) in TET_EDGES.into_iter().enumerate() {
                        slopes[v] += 4.0 * l[w] * nodes[4 + e];
                        slopes[w] += 4.0 * l[v] * nodes[4 + e];
                    }
                    let [a, b, c] = [1, 2, 3].map(|v| slopes[v] - slopes[0]);
                    smallest = smallest.min(a.cross(&b).dot(&c) / volume);
                }
            }
        }
        // About thirty rounded products of numbers below ten, over a volume of at least 0.1.
        prop_assert!(bound <= smallest + 1e-11, "{} {}", bound, smallest);
    }

    /// Shape measures are invariant under translation, rotation, scaling and, up to the sign of the
    /// mean ratio, the order of the vertices.
    #[test]
    fn quality_is_invariant(
        corners in prop::array::uniform4(vector(1.0)),
        shift in vector(1.0),
        (roll, pitch, yaw) in (-3.0..3.0, -1.5..1.5, -3.0..3.0),
        scale in 0.1..10.0_f64,
        (i, j) in (0_usize..4, 0_usize..4),
    ) {
        let q = mean_ratio(corners);
        prop_assume!(q.abs() > 0.05);
        let rotation = nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw);
        let moved = corners.map(|p| scale * (rotation * p + shift));
        // About ten roundings in lengths, amplified by at most 1/q.
        prop_assert!((mean_ratio(moved) - q).abs() < 1e-12);
        let sorted = |mut angles: [f64; 6]| {
            angles.sort_unstable_by(f64::total_cmp);
            angles
        };
        let angles = sorted(dihedral_angles(corners));
        for (a, b) in angles.iter().zip(sorted(dihedral_angles(moved))) {
            prop_assert!((a - b).abs() < 1e-9, "{} {}", a, b);
        }
        let mut swapped = corners;
        swapped.swap(i, j);
        let sign = if i == j { 1.0 } else { -1.0 };
        prop_assert!((mean_ratio(swapped) - sign * q).abs() < 1e-12);
        for (a, b) in angles.iter().zip(sorted(dihedral_angles(swapped))) {
            prop_assert!((a - b).abs() < 1e-9, "{} {}", a, b);
        }
    }

    /// The Jacobian bound of a mesh is invariant under translation, rotation and scaling.
    #[test]
    fn rigid_motion_and_scaling_keep_volume_and_jacobian(
        shift in vector(10.0),
        (roll, pitch, yaw) in (-3.0..3.0, -1.5..1.5, -3.0..3.0),
        scale in 0.1..10.0_f64,
    ) {
        let mesh = curved_ball(2);
        let rotation = nalgebra::Rotation3::from_euler_angles(roll, pitch, yaw);
        let moved = mesh.with_points(mesh.points().iter().map(|p| scale * (rotation * p) + shift).collect()).unwrap();
        // Coordinates up to 27 are rounded to 4e-15; elements are no smaller than 0.03.
        prop_assert!((moved.volume() / (scale.powi(3) * mesh.volume()) - 1.0).abs() < 1e-11);
        prop_assert!((moved.quality().min_jacobian - mesh.quality().min_jacobian).abs() < 1e-11);
    }
}

/// The volume error is of second order with straight facets and of fourth order with curved ones.
#[test]
fn enclosed_volume_converges_at_the_order_of_the_facets() {
    let exact = 4.0 / 3.0 * std::f64::consts::PI;
    let errors = |mesh: fn(u32) -> TetMesh| [4, 8].map(|n| (mesh(n).volume() / exact - 1.0).abs());
    let order = |[coarse, fine]: [f64; 2]| (coarse / fine).log2();
    let straight = errors(|n| TetMesh::straight(ball(n)).unwrap());
    let curved = errors(curved_ball);
    // Observed orders of a smooth error expansion have an error of O(h^2), with h = 1/4.
    assert!((order(straight) - 2.0).abs() < 0.1, "{straight:?}");
    assert!((order(curved) - 4.0).abs() < 0.2, "{curved:?}");
    // Over an arc t the chord is t^2 / 8 too low; the error of the parabola through its middle is
    // less than (t^2 / 8)^2.
    assert!(curved[0] < straight[0].powi(2), "{curved:?} {straight:?}");
}
