//! Decisions before a run: the model, the element sizes, tables over shapes.

mod sphere_model;
mod tables;
mod target;
mod trial;

use models::{
    AxisymmetricModel, FemModel, Hydrodynamics, ModelError, MovingAxis, SphereModel, SpheresModel,
};
use scene::{DomainKind, ModelKind, Scene, Shape};

use crate::integrate::velocity_tolerance;
use crate::observer::Progress;
use sphere_model::{
    ModelForSpheres, choose_for_spheres, expansion_for_tolerance, model_for_noise, model_in_box,
};

pub use tables::with_tables;
pub use target::{SizeSearch, simulate_to_target};

/// The model chosen for a scene, with the reasons.
#[non_exhaustive]
pub struct Choice {
    /// The model.
    pub model: Box<dyn Hydrodynamics>,
    /// Properties of the scene and conclusions from them, one sentence each.
    pub reasons: Vec<String>,
}

/// How a run or a solution gets the model of a scene.
pub type ModelOfScene<'a> = &'a dyn Fn(&Scene, &mut dyn Progress) -> Result<Choice, ModelError>;

impl Choice {
    /// The choice of a model, for one sentence per reason.
    pub fn new(model: Box<dyn Hydrodynamics>, reasons: Vec<String>) -> Self {
        Self { model, reasons }
    }
}

/// Chooses the model that the scene names, or for `auto` the cheapest one that meets the tolerance.
///
/// For `auto` there are three reasons: the symmetry of the scene, the error and the cost of each
/// candidate, and the choice.
///
/// # Errors
/// [`ModelError::Unsupported`] for combinations of model, domain and options that are not
/// supported, with the alternative; for a fluid with inertia or thermal noise, which has a motion
/// in time only ([`choose_for_run`]).
pub fn choose(scene: &Scene) -> Result<Choice, ModelError> {
    choose_for_start(scene, &mut ())
}

/// The model of [`choose`], with progress: trials of models are work.
///
/// # Errors
/// Those of [`choose`].
pub fn choose_for_start(scene: &Scene, progress: &mut dyn Progress) -> Result<Choice, ModelError> {
    check_no_inertia(scene)?;
    check_no_noise(scene)?;
    choose_checked(scene, progress)
}

fn choose_checked(scene: &Scene, progress: &mut dyn Progress) -> Result<Choice, ModelError> {
    let choice = choose_unchecked(scene, progress)?;
    let capabilities = choice.model.capabilities();
    capabilities.check_deformations(scene, choice.model.name())?;
    capabilities.check_rheology(scene, choice.model.name())?;
    capabilities.check_noise(scene, choice.model.name())?;
    Ok(choice)
}

fn choose_unchecked(scene: &Scene, progress: &mut dyn Progress) -> Result<Choice, ModelError> {
    let is_mesh_free = matches!(
        scene.domain().kind(),
        DomainKind::Unbounded | DomainKind::Ball | DomainKind::Wall
    );
    let is_periodic = scene.domain().period().is_some();
    let serves_spheres = (is_mesh_free || is_periodic)
        && scene.first_nonspherical().is_none()
        && SpheresModel::changes_size_above_wall(scene).is_none();
    let requested = || {
        vec![
            "given by model.kind".to_owned(),
            scene.describe_arrangement(),
        ]
    };
    let spheres = |kind: SphereModel, reasons: Vec<String>| {
        Ok(Choice {
            model: Box::new(SpheresModel::new(scene, kind)?),
            reasons,
        })
    };
    let axisymmetric = || -> Result<AxisymmetricModel, ModelError> {
        check_slenderness(scene)?;
        Ok(AxisymmetricModel::new(scene)?.with_velocity_accuracy(velocity_tolerance(scene)))
    };
    match scene.model().kind {
        ModelKind::Oseen => spheres(SphereModel::Oseen, requested()),
        ModelKind::Rpy => spheres(SphereModel::Rpy, requested()),
        ModelKind::Multipole => spheres(expansion_for_tolerance(scene), requested()),
        ModelKind::Axisymmetric => Ok(Choice {
            model: Box::new(axisymmetric()?),
            reasons: requested(),
        }),
        ModelKind::Fem => elements(scene, requested()),
        ModelKind::Auto if scene.noise().is_some() && serves_spheres && !is_periodic => {
            let (kind, reason) = model_for_noise(scene)?;
            spheres(kind, vec![scene.describe_arrangement(), reason])
        }
        ModelKind::Auto if scene.viscosity_law().is_some() => {
            let reasons = |elements: &str| {
                vec![
                    scene.describe_arrangement(),
                    "the viscosity of the fluid depends on the shear rate".to_owned(),
                    format!("chosen: finite elements in {elements}"),
                ]
            };
            match AxisymmetricModel::supports(scene).then(axisymmetric) {
                Some(Ok(model)) => Ok(Choice {
                    model: Box::new(model),
                    reasons: reasons("the meridian plane"),
                }),
                // Rotation about the axis is unsupported there.
                _ => elements(scene, reasons("three dimensions")),
            }
        }
        ModelKind::Auto if AxisymmetricModel::suits(scene) => {
            let mut model = axisymmetric()?;
            let unsupported = match scene.first_nonspherical() {
                Some(body) if scene.bodies()[body].shape.is_isotropic() => {
                    "modes that change the shape of a sphere".to_owned()
                }
                Some(_) => "shape = \"spheroid\"".to_owned(),
                None => format!("domain.kind = \"{}\"", scene.domain().kind().word()),
            };
            let described = model.describe(scene)?;
            let reasons = vec![
                scene.describe_arrangement(),
                format!("models without a mesh do not support {unsupported}; {described}"),
                "chosen: finite elements in the meridian plane".to_owned(),
            ];
            Ok(Choice {
                model: Box::new(model),
                reasons,
            })
        }
        ModelKind::Auto if scene.domain().period().is_some() => {
            let (kind, reason) = model_in_box(scene);
            spheres(kind, vec![scene.describe_arrangement(), reason])
        }
        ModelKind::Auto if serves_spheres => {
            let choice = choose_for_spheres(scene, progress)?;
            match choice.model {
                ModelForSpheres::MeshFree(kind) => spheres(kind, choice.reasons),
                ModelForSpheres::MeridianPlane => Ok(Choice {
                    model: Box::new(axisymmetric()?),
                    reasons: choice.reasons,
                }),
                ModelForSpheres::Elements => elements(scene, choice.reasons),
            }
        }
        ModelKind::Auto => {
            let unsupported = match scene.first_nonspherical() {
                Some(body) if scene.bodies()[body].shape.is_isotropic() => {
                    "deformation.kind = \"modes\"".to_owned()
                }
                Some(body) => {
                    format!("shape = \"{}\"", scene.bodies()[body].shape.kind().word())
                }
                None if is_mesh_free => "radii that change above a wall".to_owned(),
                None => format!("domain.kind = \"{}\"", scene.domain().kind().word()),
            };
            let reasons = vec![
                scene.describe_arrangement(),
                format!("mesh-free models do not support {unsupported}"),
                "chosen: finite elements in three dimensions".to_owned(),
            ];
            elements(scene, reasons)
        }
    }
}

/// The model of a run: that of [`choose_for_start`], or elements whose flow is integrated in time
/// if the fluid has inertia.
///
/// # Errors
/// Those of [`choose`]; a model without elements for a fluid with inertia.
pub fn choose_for_run(scene: &Scene, progress: &mut dyn Progress) -> Result<Choice, ModelError> {
    if !scene.inertia().is_kept() {
        return choose_checked(scene, progress);
    }
    let mut reasons = vec![
        scene.describe_arrangement(),
        "the fluid has inertia: its flow is integrated in time".to_owned(),
    ];
    let model: Box<dyn Hydrodynamics> = match discretisation(scene)? {
        Discretisation::Meridian => {
            reasons.push("chosen: finite elements in the meridian plane".to_owned());
            check_slenderness(scene)?;
            Box::new(AxisymmetricModel::new(scene)?)
        }
        Discretisation::Spatial => {
            reasons.push("chosen: finite elements in three dimensions".to_owned());
            Box::new(FemModel::new(scene)?)
        }
    };
    Ok(Choice::new(model, reasons))
}

/// Where the flow of a fluid with inertia is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Discretisation {
    /// On meshes of the meridian plane.
    Meridian,
    /// On meshes in space.
    Spatial,
}

/// The discretisation of a fluid with inertia: the model that the scene names, or for `auto` the
/// meridian plane where it has the scene.
///
/// A step in the plane has 4 to 20 thousand unknowns and a direct solver, one in space at least
/// ten times as many at a larger error: where there is a choice the plane is always cheaper.
///
/// # Errors
/// [`ModelError::Unsupported`] for a model without the inertia of the fluid, or that does not have
/// the scene.
pub(crate) fn discretisation(scene: &Scene) -> Result<Discretisation, ModelError> {
    match (scene.model().kind, MovingAxis::check(scene)) {
        (ModelKind::Auto | ModelKind::Axisymmetric, Ok(())) => Ok(Discretisation::Meridian),
        (ModelKind::Axisymmetric, Err(error)) => Err(error),
        (ModelKind::Auto | ModelKind::Fem, _) => Ok(Discretisation::Spatial),
        (kind, _) => Err(ModelError::Unsupported {
            what: format!(
                "{}: inertia of the fluid by the model {}",
                scene.place("fluid.inertia"),
                kind.word()
            ),
            instead: "set model.kind = \"fem\", \"axisymmetric\" or \"auto\"".to_owned(),
        }),
    }
}

/// Refuses a fluid with inertia where one instant is asked for.
fn check_no_inertia(scene: &Scene) -> Result<(), ModelError> {
    match scene.inertia().is_kept() {
        false => Ok(()),
        true => Err(ModelError::Unsupported {
            what: format!(
                "{}: the flow of one instant, or strokes by such flows, of a fluid with inertia",
                scene.place("fluid.inertia")
            ),
            instead: "use `swim run`, `swim solve --steady`, or fluid.inertia = \"none\""
                .to_owned(),
        }),
    }
}

/// Refuses thermal noise where one instant is asked for.
fn check_no_noise(scene: &Scene) -> Result<(), ModelError> {
    match scene.noise() {
        None => Ok(()),
        Some(_) => Err(ModelError::Unsupported {
            what: format!(
                "{}: the velocities of one instant, or strokes by such velocities, with thermal \
                 noise",
                scene.place("fluid.thermal_energy")
            ),
            instead: "use `swim run`, or fluid.thermal_energy = 0".to_owned(),
        }),
    }
}

/// Refuses spheroids that are too slender or too flat, with their place in the scene.
fn check_slenderness(scene: &Scene) -> Result<(), ModelError> {
    for (number, body) in scene.bodies().iter().enumerate() {
        let Shape::Spheroid(spheroid) = &body.shape else {
            continue;
        };
        let aspect = spheroid.half_length / spheroid.radius;
        let aspect = aspect.max(aspect.recip());
        if aspect > AxisymmetricModel::MAX_ASPECT {
            let place = scene.place(&format!("bodies[{number}].half_length"));
            return Err(ModelError::Unsupported {
                what: format!(
                    "{place}: a spheroid whose semi-axes differ by a factor of {aspect:.4}"
                ),
                instead: format!(
                    "the limit is {}; make '{}' less slender",
                    AxisymmetricModel::MAX_ASPECT,
                    body.name
                ),
            });
        }
    }
    Ok(())
}

/// The finite-element model, which does not support masses in unbounded fluid.
fn elements(scene: &Scene, reasons: Vec<String>) -> Result<Choice, ModelError> {
    let massive = (scene.bodies().iter()).position(|body| body.mass_matrix().is_some());
    let is_unbounded = matches!(
        scene.domain().kind(),
        DomainKind::Unbounded | DomainKind::Wall
    );
    if let Some(body) = massive.filter(|_| is_unbounded) {
        return Err(ModelError::Unsupported {
            what: format!(
                "{}: masses by finite elements in unbounded fluid",
                scene.place(&format!("bodies[{body}].mass"))
            ),
            instead: "use spheres, or a large ball as domain".to_owned(),
        });
    }
    Ok(Choice {
        model: Box::new(FemModel::new(scene)?),
        reasons,
    })
}
