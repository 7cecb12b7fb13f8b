//! Meshes of files that are generated again inside their walls.

use std::path::Path;

use mesh::TetMesh;
use models::{FemModel, History, Hydrodynamics, Remesh};

use testkit::{forces, within};

use crate::mesh_files::{OTHER_MOTION, OWN_PARTS, file, mesh_at, own_mesh, scene, solve};

/// Number of configurations on a path for which the file's own cells are used.
fn followed(file: &Path, motion: &[&str], path: &[[f64; 2]]) -> usize {
    let scene = scene(file, OWN_PARTS, motion);
    let mut model = FemModel::new(&scene).unwrap();
    let mut cells = path.iter().map(|&lengths| {
        let mesh = mesh_at(&mut model, lengths).unwrap();
        mesh.cells().to_vec()
    });
    let first = cells.next().unwrap();
    1 + cells.take_while(|cells| *cells == first).count()
}

/// Once the run was refused where the mesh of the file could not follow the bodies.
#[test]
fn a_mesh_file_is_meshed_again_after_all_methods_of_motion() {
    let (_folder, file) = file();
    // The outer sphere leaves the ball of radius 20 at an arm of 19.
    let opening: Vec<[f64; 2]> = (10..19).map(|arm| [f64::from(arm), 10.0]).collect();
    let by_one = followed(&file, &["fem.mesh_motion=biharmonic"], &opening);
    let by_all = followed(&file, &[], &opening);
    assert!(
        by_one < by_all && by_all < opening.len(),
        "{by_one} {by_all}"
    );
}

/// The facets on the walls: positions of their vertices, as bits.
fn wall(mesh: &TetMesh) -> Vec<[[u64; 3]; 3]> {
    let tag = mesh.tag("outer").unwrap();
    let facets = mesh.facets().iter().filter(|facet| facet.tag == tag);
    let mut corners: Vec<[[u64; 3]; 3]> = facets
        .map(|facet| {
            let [a, b, c, ..] = facet.nodes;
            let bits = |node: u32| mesh.points()[node as usize].map(f64::to_bits).into();
            let mut corners = [a, b, c].map(bits);
            corners.sort_unstable();
            corners
        })
        .collect();
    corners.sort_unstable();
    corners
}

/// Arms that close to gaps of half a radius: the file is meshed again with its walls, and the
/// answer agrees with that of a mesh of our own.
#[test]
fn a_file_meshed_again_has_the_answer_of_our_own_mesh() {
    let (_folder, file) = file();
    let in_file = scene(&file, OWN_PARTS, &[]);
    let [mut model, mut other] = [in_file, own_mesh()].map(|scene| FemModel::new(&scene).unwrap());
    let before = mesh_at(&mut model, [10.0, 10.0]).unwrap();
    let gap = [2.5, 2.5];
    let found = solve(&mut model, gap);
    assert!(
        matches!(&found.remeshed, Some(Remesh::InsideFile { tried }) if tried.contains("rbf-linear: ")),
        "{:?}",
        found.remeshed
    );
    let after = mesh_at(&mut model, gap).unwrap();
    assert!(wall(&after) == wall(&before));
    let expected = solve(&mut other, gap);
    // The walls of the file are flat facets within a ten-thousandth of the ball's volume.
    let bars = found.error_estimate.total() + expected.error_estimate.total();
    for (a, b) in found.bodies.iter().zip(&expected.bodies) {
        let difference = (a.velocity - b.velocity).norm();
        within(difference, bars, "both error bars");
    }
    within(bars, 0.02, "the bars say something");
}

#[test]
fn straight_bodies_stay_straight_in_a_file_meshed_again() {
    let (_folder, file) = file();
    let scene = scene(&file, OWN_PARTS, &["fem.geometry=straight"]);
    let mut model = FemModel::new(&scene).unwrap();
    let mesh = mesh_at(&mut model, [2.5, 2.5]).unwrap();
    // The reference with the mesh of the file is followed by a new one.
    let history = model.history().unwrap();
    assert!(history != History::new(&[(); 0]).unwrap());
    // The walls have the curved facets of the second-order file.
    let walls = mesh.tag("outer").unwrap();
    for facet in mesh.facets().iter().filter(|facet| facet.tag != walls) {
        assert!(mesh.is_affine(facet.cell as usize));
    }
}

/// A body that moves around the others, so far that the fluid is meshed again ten times: each
/// time the forces are in balance.
#[test]
fn forces_are_in_balance_through_ten_new_meshes() {
    let (_folder, file) = file();
    let scene = scene(
        &file,
        OWN_PARTS,
        &["fem.mesh_motion=laplace", "fem.estimates=off"],
    );
    let mut model = FemModel::new(&scene).unwrap();
    let mut new_meshes = 0;
    for step in 0..24 {
        let lengths = match step % 4 {
            0 => [10.0, 10.0 - 0.2 * f64::from(step)],
            1 => [4.5, 10.0 - 0.2 * f64::from(step)],
            2 => [4.5 + 0.1 * f64::from(step), 4.0],
            _ => [14.0 - 0.1 * f64::from(step), 5.0],
        };
        let solution = solve(&mut model, lengths);
        new_meshes += usize::from(solution.remeshed.is_some());
        let (sum, largest) = forces(&solution);
        let why = format!("the linear solver stops at a residual of 1e-8: {lengths:?}");
        within(sum.norm(), 1e-6 * largest, why);
        if new_meshes == 10 {
            return;
        }
    }
    panic!("{new_meshes} new meshes");
}

/// Resumed runs have the new meshes of the run before.
#[test]
fn new_meshes_inside_a_file_are_restored_bitwise() {
    let (_folder, file) = file();
    let scene = scene(&file, OWN_PARTS, &[]);
    let mut model = FemModel::new(&scene).unwrap();
    let (start, end) = ([10.0, 10.0], [6.0, 6.0]);
    let shapes = [start, OTHER_MOTION, [2.5, 3.0], [3.0, 2.4], end];
    for shape in shapes {
        mesh_at(&mut model, shape).unwrap();
    }
    let history = model.history().unwrap();
    let mut other = FemModel::new(&scene).unwrap();
    other.restore(&history).unwrap();
    assert_eq!(other.history().unwrap(), history);
    for shape in shapes {
        let [expected, found] =
            [&mut model, &mut other].map(|model| mesh_at(model, shape).unwrap());
        assert!(found == expected, "{shape:?}");
    }
    assert_eq!(other.history().unwrap(), history);
}

#[test]
fn histories_with_more_meshes_than_there_can_be_are_refused() {
    let (_folder, file) = file();
    let scene = scene(&file, OWN_PARTS, &["fem.mesh_motion=biharmonic"]);
    let mut model = FemModel::new(&scene).unwrap();
    // One method of motion and three new meshes; the first method is not recorded.
    let state = scene.initial_state();
    let poses = scene.articulation().place(&state, &[10.0, 10.0]).unwrap();
    let poses_of = |meshes: usize| poses.repeat(meshes);
    assert!(model.restore(&History::new(&poses_of(4)).unwrap()).is_err());
    assert!(model.restore(&History::new(&poses_of(1)).unwrap()).is_ok());
}
