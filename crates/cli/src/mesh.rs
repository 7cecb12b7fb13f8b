//! `swim mesh`: the mesh of the initial shape.

use std::path::Path;

use mesh::MeshError;
use swimmer::models::{Configuration, ModelError};
use swimmer::{SwimError, choose};

use super::arguments::SceneArguments;
use super::error::CliError;
use super::text::entry;

pub fn mesh(arguments: &SceneArguments, out: &Path) -> Result<String, CliError> {
    let scene = arguments.read()?;
    let mut model = choose(&scene)?.model;
    let shape = scene.articulation().initial_shape();
    let Some(mesh) = model.mesh(Configuration {
        state: &scene.initial_state(),
        shape,
    })?
    else {
        return Err(CliError::NotApplicable {
            place: scene.place("model.kind"),
            problem: format!(
                "the model '{}' has no mesh; use model.kind = \"fem\"",
                model.name()
            ),
        });
    };
    mesh.write(out).map_err(|error| match error {
        MeshError::Io { path, source } => SwimError::Write { path, source }.into(),
        MeshError::UnknownFormat { .. } => CliError::NotApplicable {
            place: format!("--out {}", out.display()),
            problem: "unknown file extension; use .vtu (ParaView) or .msh (Gmsh)".to_owned(),
        },
        error => ModelError::from(error).into(),
    })?;
    let quality = mesh.quality();
    let lines = [
        ("mesh file", out.display().to_string()),
        ("tetrahedra", quality.cells.to_string()),
        ("vertices", mesh.n_vertices().to_string()),
        ("nodes", mesh.n_points().to_string()),
        (
            "dihedral angles",
            format!(
                "{:.1} to {:.1} degrees",
                quality.min_dihedral, quality.max_dihedral
            ),
        ),
        (
            "mean-ratio quality",
            format!(
                "{:.3} minimum, {:.3} mean (1 for a regular tetrahedron)",
                quality.min_quality, quality.mean_quality
            ),
        ),
        (
            "scaled Jacobian",
            format!("{:.3} minimum", quality.min_jacobian),
        ),
    ];
    Ok(lines
        .iter()
        .map(|(label, value)| entry(label, value))
        .collect())
}
