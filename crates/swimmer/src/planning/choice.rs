//! Which model computes a scene, and why.

use models::{AxisymmetricModel, FemModel, Hydrodynamics, ModelError, SphereModel, SpheresModel};
use scene::{DomainKind, ModelKind, Scene};

use crate::planning::ladder;

/// The model taken for a scene, with the reasons.
pub struct Choice {
    /// The model.
    pub model: Box<dyn Hydrodynamics>,
    /// What was found out about the scene and what follows from it, one sentence each.
    pub reasons: Vec<String>,
}

/// Takes the model that the scene names, or for `auto` the least one that meets the scene's tolerance.
///
/// `auto` gives three reasons: the symmetry found, what each rung of the ladder errs and costs, and what it took.
///
/// # Errors
/// [`ModelError::Unsupported`] for models, domains and options that do not exist yet, naming what to use instead.
pub fn choose(scene: &Scene) -> Result<Choice, ModelError> {
    let unsupported = |key: &str, value: &str, instead: &str| {
        Err(ModelError::Unsupported {
            what: format!("{}: {key} = {value}", scene.place(key)),
            instead: instead.to_owned(),
        })
    };
    for (number, body) in scene.bodies().iter().enumerate() {
        for (name, value) in [("mass", body.mass), ("inertia", body.inertia)] {
            if value > 0.0 {
                let key = format!("bodies[{number}].{name}");
                return unsupported(
                    &key,
                    &value.to_string(),
                    "remove it: bodies without inertia are exact for slow, small swimmers",
                );
            }
        }
    }
    let without_mesh = matches!(
        scene.domain().kind(),
        DomainKind::Unbounded | DomainKind::Ball | DomainKind::Wall
    );
    let asked = || {
        vec![
            "asked for by model.kind".to_owned(),
            scene.arrangement().describe().to_owned(),
        ]
    };
    let spheres = |kind: SphereModel, reasons: Vec<String>| {
        Ok(Choice {
            model: Box::new(SpheresModel::new(scene, kind)?),
            reasons,
        })
    };
    match scene.model().kind {
        ModelKind::Oseen => return spheres(SphereModel::Oseen, asked()),
        ModelKind::Rpy => return spheres(SphereModel::Rpy, asked()),
        ModelKind::Multipole => return spheres(SphereModel::for_displacement(scene), asked()),
        ModelKind::Auto if AxisymmetricModel::suits(scene) => {
            let mut model = AxisymmetricModel::new(scene)?;
            let reasons = vec![
                scene.arrangement().describe().to_owned(),
                model.describe(scene)?,
                "took finite elements in the meridian plane".to_owned(),
            ];
            return Ok(Choice {
                model: Box::new(model),
                reasons,
            });
        }
        ModelKind::Auto if without_mesh => {
            let rung = ladder::climb(scene)?;
            return spheres(rung.kind, rung.reasons);
        }
        ModelKind::Axisymmetric => {
            return Ok(Choice {
                model: Box::new(AxisymmetricModel::new(scene)?),
                reasons: asked(),
            });
        }
        ModelKind::Auto | ModelKind::Fem => {}
    }
    match scene.domain().kind() {
        DomainKind::Unbounded
        | DomainKind::Ball
        | DomainKind::Box
        | DomainKind::Cylinder
        | DomainKind::Mesh => {}
        kind => {
            let instead = "use model.kind = \"auto\" for spheres beside a wall, or domain.kind = \"unbounded\" or \"ball\"";
            return unsupported("domain.kind", &format!("\"{}\"", kind.word()), instead);
        }
    }
    let reasons = match scene.model().kind {
        ModelKind::Auto => vec![
            scene.arrangement().describe().to_owned(),
            format!(
                "models without a mesh know no domain.kind = \"{}\"",
                scene.domain().kind().word()
            ),
            "took finite elements in space".to_owned(),
        ],
        _ => asked(),
    };
    Ok(Choice {
        model: Box::new(FemModel::new(scene)?),
        reasons,
    })
}
