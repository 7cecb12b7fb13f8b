//! Which model computes a scene, and why.

use crate::model::{FemModel, Hydrodynamics, ModelError};
use crate::scene::{DomainKind, ModelKind, Scene};

/// The model taken for a scene, with the reasons.
pub struct Choice {
    /// The model.
    pub model: Box<dyn Hydrodynamics>,
    /// What was found out about the scene and what follows from it, one sentence each.
    pub reasons: Vec<String>,
}

/// Takes the model that the scene names, or for `auto` the least one that exists for the scene.
///
/// # Errors
/// [`ModelError::NotBuilt`] for models, domains and options that do not exist yet, naming what to use instead.
pub fn choose(scene: &Scene) -> Result<Choice, ModelError> {
    let not_built = |key: &str, value: &str, instead: &str| {
        Err(ModelError::NotBuilt {
            what: format!("{}: {key} = {value}", scene.place(key)),
            instead: instead.to_owned(),
        })
    };
    for (number, body) in scene.bodies.iter().enumerate() {
        for (name, value) in [("mass", body.mass), ("inertia", body.inertia)] {
            if value > 0.0 {
                let key = format!("bodies[{number}].{name}");
                return not_built(
                    &key,
                    &value.to_string(),
                    "remove it: bodies without inertia are exact for slow, small swimmers",
                );
            }
        }
    }
    match scene.model.kind {
        ModelKind::Auto | ModelKind::Fem => {}
        kind => {
            return not_built(
                "model.kind",
                &format!("\"{}\"", kind.word()),
                "use model.kind = \"fem\"",
            );
        }
    }
    match scene.domain.kind() {
        DomainKind::Ball | DomainKind::Box | DomainKind::Mesh => {}
        kind => {
            let instead = "use domain.kind = \"ball\"; a swimmer without external force in a ball of ten times \
                           its length moves as in unbounded fluid to about a thousandth";
            return not_built("domain.kind", &format!("\"{}\"", kind.word()), instead);
        }
    }
    let reason = match scene.model.kind {
        ModelKind::Auto => {
            "finite elements in space: the lesser models of the ladder are not built yet"
        }
        _ => "asked for by model.kind",
    };
    let reasons = vec![reason.to_owned(), scene.arrangement().describe().to_owned()];
    Ok(Choice {
        model: Box::new(FemModel::new(scene)?),
        reasons,
    })
}
