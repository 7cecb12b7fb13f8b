//! Invariance under translation, rotation and reflection of the scene with its mesh.

use mesh::{QuadraticTets, TetMesh};
use nalgebra::{Matrix3, Rotation3, Vector3};
use swimmer::Scene;

use crate::scenes::{bent, bodies, force_error, largest_differences, mesh, velocity_error};
use testkit::{start, within};

/// The bent swimmer in `mesh` (from a file in `folder`) under `x -> linear x + shift`.
fn mapped(
    folder: &std::path::Path,
    original: &TetMesh,
    linear: &Matrix3<f64>,
    shift: Vector3<f64>,
) -> Scene {
    let place = |x: &Vector3<f64>| linear * x + shift;
    // Reflection inverts the cells; the constructor of the mesh restores their orientation.
    let loose = QuadraticTets {
        points: original.points().iter().map(place).collect(),
        tets: original.cells().to_vec(),
        faces: original.facets().iter().map(|f| (f.nodes, f.tag)).collect(),
        tags: original.tags().to_vec(),
        ..QuadraticTets::default()
    };
    let file = folder.join("mapped.msh");
    TetMesh::quadratic(loose, &[])
        .unwrap()
        .write(&file)
        .unwrap();
    let wall = original.tags().last().unwrap();
    let domain = format!("{{ kind = \"mesh\", file = {file:?}, walls = [{wall:?}] }}");
    let scene = bodies().scene();
    let text = scene.bodies().iter().fold(bodies(), |text, body| {
        let key = |key: &str| format!("bodies.{}.{key}", body.name);
        text.with(
            &key("position"),
            format!("{:?}", place(&body.position).as_slice()),
        )
        .with(&key("surface"), &body.name)
    });
    let text = text.phases(&[("left-arm", 3.25)]).with("domain", domain);
    text.set(&["model.kind=fem", "fem.rtol=1e-10"]).scene()
}

fn check(linear: Matrix3<f64>, shift: Vector3<f64>) {
    let scene = bent(&[]);
    let original = mesh(&scene);
    let folder = tempfile::tempdir().unwrap();
    let reference = start(&scene);
    let answer = start(&mapped(folder.path(), &original, &linear, shift));
    assert_eq!(reference.dofs, answer.dofs);
    // Corrections agree to the accuracy of their iteration, a few percent of the correction; the
    // file does not tell that its wall is a ball, whose facets are then not corrected.
    let [before, after] = [&reference, &answer].map(|solution| solution.uncorrected());
    // Angular velocities and torques are axial vectors, which change sign under reflection.
    let axial = linear * linear.determinant();
    let map = |[u, w, f, t]: [Vector3<f64>; 4]| [linear * u, axial * w, linear * f, axial * t];
    let off = largest_differences(&reference, &answer, map);
    let correction = largest_differences(&reference, &before, |vectors| vectors);
    for k in 0..2 {
        within(
            off[k],
            0.05 * correction[k],
            "the iteration of the corrections",
        );
    }
    let [velocities, forces] = largest_differences(&before, &after, map);
    within(
        velocities,
        velocity_error(&before) + velocity_error(&after),
        "residuals",
    );
    within(
        forces,
        force_error(&before) + force_error(&after),
        "residuals",
    );
}

#[test]
fn a_mesh_from_a_file_gives_the_same_solution() {
    check(Matrix3::identity(), Vector3::zeros());
}

#[test]
fn a_rotated_scene_has_the_rotated_solution() {
    let turn = Rotation3::from_scaled_axis(Vector3::new(0.3, -1.1, 0.7));
    check(turn.into_inner(), Vector3::zeros());
}

#[test]
fn a_shifted_scene_has_the_same_solution() {
    check(Matrix3::identity(), Vector3::new(7.0, -3.0, 11.0));
}

#[test]
fn a_reflected_scene_has_the_reflected_solution() {
    check(
        Matrix3::from_diagonal(&Vector3::new(-1.0, 1.0, 1.0)),
        Vector3::zeros(),
    );
}
