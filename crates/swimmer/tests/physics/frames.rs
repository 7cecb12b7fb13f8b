//! Invariance under translation, rotation and reflection of the scene with its mesh.

use mesh::{QuadraticTets, TetMesh};
use nalgebra::{Matrix3, Rotation3, Vector3};
use swimmer::Scene;

use crate::scenes::{
    BODIES, COARSE, bent, force_error, largest_differences, mesh, parse, solve, velocity_error,
};

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
    let mut name = "";
    let bodies: String = BODIES
        .lines()
        .map(|line| match line.split_once(" = ") {
            Some(("position", x)) => {
                let c: Vec<f64> = x
                    .trim_matches(['[', ']'])
                    .split(',')
                    .map(|c| c.trim().parse().unwrap())
                    .collect();
                let x = place(&Vector3::from_column_slice(&c));
                format!("position = {:?}\nsurface = {name}\n", x.as_slice())
            }
            key => {
                if let Some(("name", value)) = key {
                    name = value;
                }
                format!("{line}\n")
            }
        })
        .collect();
    parse(
        &format!(
            "domain = {{ kind = \"mesh\", file = {:?}, walls = [{wall:?}] }}\n{COARSE}{bodies}\
         [[gait.phases]]\nlink = \"left-arm\"\nlength = 3.25\n",
            file.display().to_string()
        )
        .replace("fem.surface_size = 0.7\n", ""),
    )
}

fn check(linear: Matrix3<f64>, shift: Vector3<f64>) {
    let scene = bent(COARSE);
    let original = mesh(&scene);
    let folder = tempfile::tempdir().unwrap();
    let reference = solve(&scene);
    let answer = solve(&mapped(folder.path(), &original, &linear, shift));
    assert_eq!(reference.dofs, answer.dofs);
    // Corrections agree to the accuracy of their iteration, a few percent of the correction; the
    // file does not tell that its wall is a ball, whose facets are then not corrected.
    let [before, after] = [&reference, &answer].map(|solution| solution.uncorrected());
    let off = |k: usize, a: &models::InstantaneousSolution, b: &models::InstantaneousSolution| {
        let axial = linear * linear.determinant();
        largest_differences(a, b, |[u, w, f, t]| {
            [linear * u, axial * w, linear * f, axial * t]
        })[k]
    };
    for k in 0..2 {
        let correction = largest_differences(&reference, &before, |vectors| vectors)[k];
        let off = off(k, &reference, &answer);
        assert!(off < 0.05 * correction, "{off:e} {correction:e}");
    }
    let (reference, answer) = (before, after);
    // Angular velocities and torques are axial vectors, which change sign under reflection.
    let axial = linear * linear.determinant();
    let [velocities, forces] = largest_differences(&reference, &answer, |[u, w, f, t]| {
        [linear * u, axial * w, linear * f, axial * t]
    });
    let both =
        |error: fn(&models::InstantaneousSolution) -> f64| error(&reference) + error(&answer);
    assert!(velocities <= both(velocity_error), "{velocities:e}");
    assert!(forces <= both(force_error), "{forces:e}");
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
