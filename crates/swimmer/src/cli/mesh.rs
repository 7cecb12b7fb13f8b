//! `swim mesh`: the mesh of the starting shape.

use std::path::Path;

use mesh::MeshError;
use swimmer::models::{Configuration, ModelError};
use swimmer::{SwimError, choose};

use super::SceneArguments;

pub fn mesh(arguments: &SceneArguments, out: &Path) -> Result<String, SwimError> {
    let scene = arguments.read()?;
    let mut model = choose(&scene)?.model;
    let lengths = scene.articulation().initial_lengths();
    let Some(mesh) = model.mesh(Configuration {
        state: &scene.initial_state(),
        lengths,
    })?
    else {
        return Err(SwimError::NotApplicable {
            place: scene.place("model.kind"),
            problem: format!(
                "the model '{}' needs no mesh; use model.kind = \"fem\"",
                model.name()
            ),
        });
    };
    mesh.write(out).map_err(|error| match error {
        MeshError::Io { path, source } => SwimError::Write { path, source },
        MeshError::UnknownFormat { .. } => SwimError::NotApplicable {
            place: format!("--out {}", out.display()),
            problem: "cannot tell the format; end the name in .vtu (ParaView) or .msh (Gmsh)"
                .to_owned(),
        },
        error => ModelError::from(error).into(),
    })?;
    let quality = mesh.quality();
    Ok(format!(
        "{}: {} tetrahedra, {} vertices, {} nodes\n\
         dihedral angles {:.1} to {:.1} degrees, mean-ratio quality {:.3} at least and {:.3} on average, \
         smallest scaled Jacobian {:.3}\n",
        out.display(),
        quality.cells,
        mesh.n_vertices(),
        mesh.n_points(),
        quality.min_dihedral,
        quality.max_dihedral,
        quality.min_quality,
        quality.mean_quality,
        quality.min_jacobian,
    ))
}
