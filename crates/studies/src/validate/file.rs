//! E on a mesh from Gmsh, when there is one beside the project.

use std::f64::consts::PI;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use swimmer::choose;
use swimmer::models::Hydrodynamics;
use swimmer::{Scene, solve_start};

use super::reference::INSTANTANEOUS;
use super::swimmer::{SPEED, compare};
use super::table::{Basis, Cost, Row};

/// Bar for the forces on this mesh, curved.
const FORCE: f64 = 1e-3;

/// Three unit spheres in a ball of radius 40, first order, 12 598 vertices.
fn mesh() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/meshes/ball_311k.msh")
}

/// What the footnote says when there is no mesh.
pub fn note() -> Option<String> {
    let missing = !mesh().exists();
    missing.then(|| "E, mesh file: skipped, ball_311k.msh is not there.".to_owned())
}

/// The first instant of the stroke, curved and straight-sided; no rows without the file.
pub fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    if mesh().exists() {
        for geometry in ["curved", "straight"] {
            rows.extend(first_instant(geometry)?);
        }
    }
    Ok(rows)
}

fn first_instant(geometry: &str) -> Result<[Row; 2]> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/three-sphere-mesh.toml");
    // The scene's first phase moves by four: at unit speed when it takes four.
    let overrides = [
        format!("domain.file={}", mesh().display()),
        format!("fem.geometry={geometry}"),
        "gait.phases.0.duration=4".to_owned(),
    ];
    let scene = Scene::read(&file, &overrides)?;
    let mut model = choose(&scene)?.model;
    let instant = solve_start(&scene, model.as_mut())?;
    let cost = Cost::of(&instant);
    let tolerances = match geometry {
        "curved" => [(SPEED, Basis::Required), (FORCE, Basis::Required)],
        _ => [(2.0 * radius_deficit(model.as_ref())?, Basis::Flat); 2],
    };
    let name = format!("mesh file, {geometry}");
    Ok(compare(
        &name,
        &INSTANTANEOUS[0],
        &instant,
        tolerances,
        cost,
    ))
}

/// How much smaller the ball of the same volume is than the sphere that the flat facets stand for.
fn radius_deficit(model: &dyn Hydrodynamics) -> Result<f64> {
    let mesh = model
        .last_flow()
        .context("the model has no flow after a solve")?
        .mesh;
    let volume = fem::surface_measures(&mesh, mesh.tag("sphere1")?)?.volume;
    Ok(1.0 - (volume / (4.0 / 3.0 * PI)).cbrt())
}
