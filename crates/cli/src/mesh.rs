//! `swim mesh`: the mesh of the initial shape.

use std::path::Path;

use mesh::MeshError;
use swimmer::models::{Configuration, ModelError};
use swimmer::{SwimError, choose_for_run};

use super::arguments::SceneArguments;
use super::error::CliError;
use super::progress::Waiting;
use super::text::entry;

pub fn mesh(arguments: &SceneArguments, out: &Path, quiet: bool) -> Result<String, CliError> {
    let scene = arguments.read(quiet)?;
    let waiting = Waiting::new("choosing the model", quiet);
    let mut model = choose_for_run(&scene, &mut &waiting)?.model;
    waiting.says("meshing");
    let shape = scene.articulation().initial_shape();
    let state = scene.initial_state();
    let Some(mesh) = model.mesh(Configuration::new(&state, shape))? else {
        return Err(CliError::NotApplicable {
            place: scene.place("model.kind"),
            problem: format!(
                "the model '{}' has no mesh; use model.kind = \"fem\"",
                model.name()
            ),
        });
    };
    waiting.says("writing the mesh");
    mesh.write(out).map_err(|error| match error {
        MeshError::Io { path, source } => SwimError::Write { path, source }.into(),
        MeshError::UnknownFormat { .. } => CliError::NotApplicable {
            place: format!("--out {}", out.display()),
            problem: "unknown file extension; use .vtu (ParaView) or .msh (Gmsh)".to_owned(),
        },
        error => ModelError::from(error).into(),
    })?;
    drop(waiting);
    let quality = mesh.quality();
    let [least, mean, jacobian] = [
        quality.min_quality,
        quality.mean_quality,
        quality.min_jacobian,
    ];
    let angles = format!(
        "{:.1} to {:.1} degrees",
        quality.min_dihedral, quality.max_dihedral
    );
    let ratio = format!("{least:.3} minimum, {mean:.3} mean (1 for a regular tetrahedron)");
    Ok(entry("mesh file", out.display())
        + &entry("tetrahedra", quality.cells)
        + &entry("vertices", mesh.n_vertices())
        + &entry("nodes", mesh.n_points())
        + &entry("dihedral angles", angles)
        + &entry("mean-ratio quality", ratio)
        + &entry("scaled Jacobian", format!("{jacobian:.3} minimum")))
}
