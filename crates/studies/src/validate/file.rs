//! Case E on a mesh from Gmsh.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use mesh::TetMesh;
use swimmer::choose;
use swimmer::models::InstantaneousSolution;
use swimmer::solve_start;

use super::flow::solve;
use super::row::{Basis, Cost, Row};
use super::swimmer::{SPEED, at, compare};
use crate::reference::INSTANTANEOUS;
use crate::scene_files;

/// Tolerance of the forces on this mesh with curved elements.
const FORCE: f64 = 1e-3;

/// Three unit spheres in a ball of radius 40, first order, 1519 vertices.
fn mesh() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../mesh/tests/fixtures/three-spheres-v41-binary.msh")
}

/// Rows at the start of the stroke, with curved and with straight elements.
pub fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for geometry in ["curved", "straight"] {
        rows.extend(at_start(geometry)?);
    }
    Ok(rows)
}

fn at_start(geometry: &str) -> Result<[Row; 2]> {
    let overrides = scene_files::with_unit_rate(&[
        format!("domain.file={}", mesh().display()),
        format!("fem.geometry={geometry}"),
    ]);
    let scene = scene_files::read("three-sphere-mesh.toml", &overrides)?;
    let mut model = choose(&scene)?.model;
    let instant = solve_start(&scene, model.as_mut())?;
    let cost = Cost::of(&instant);
    let [of_velocity, of_forces] = effect_of_wall(&instant)?;
    let tolerances = match geometry {
        "curved" => [(SPEED, Basis::Required), (FORCE, Basis::Required)],
        _ => [(2.0 * radius_deficit(&instant)?, Basis::Flat); 2],
    };
    let name = format!("mesh file, {geometry}");
    let [velocity, force] = compare(&name, &INSTANTANEOUS[0], &instant, tolerances, cost);
    Ok([
        velocity.with_exact_bar(of_velocity),
        force.with_exact_bar(of_forces),
    ])
}

fn mesh_of(solution: &InstantaneousSolution) -> Result<&TetMesh> {
    let flow = solution.flow.as_ref().context("the solution has no flow")?;
    Ok(&flow.field()?.mesh)
}

/// Relative changes of velocity and forces if the ball has the volume inside the wall's facets.
///
/// The file has a polyhedron for the ball of the exact values. Its shape is given, so solutions
/// are not corrected for it.
fn effect_of_wall(solution: &InstantaneousSolution) -> Result<[f64; 2]> {
    let mesh = mesh_of(solution)?;
    let volume = fem::surface_measures(mesh, mesh.tag("outer")?)?.volume;
    let radius = (volume.abs() / (4.0 / 3.0 * PI)).cbrt();
    let case = &INSTANTANEOUS[0];
    let (inside, _) = solve(&at(case, radius, "model.kind = \"multipole\"")?)?;
    let change = |body: usize| (inside.bodies[body].force.x - case.forces[body]).abs();
    let largest = case.forces.iter().fold(0.0, |m: f64, f| m.max(f.abs()));
    Ok([
        (inside.bodies[1].velocity.x / case.centre_velocity - 1.0).abs(),
        (0..case.forces.len()).map(change).fold(0.0, f64::max) / largest,
    ])
}

/// Radius of the unit sphere minus that of the ball with the volume inside the flat facets.
fn radius_deficit(solution: &InstantaneousSolution) -> Result<f64> {
    let mesh = mesh_of(solution)?;
    let volume = fem::surface_measures(mesh, mesh.tag("sphere1")?)?.volume;
    Ok(1.0 - (volume / (4.0 / 3.0 * PI)).cbrt())
}
