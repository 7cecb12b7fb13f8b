//! Writing of a scene as a file in which every key is written out.

use crate::body::Body;
use crate::domain::Domain;
use crate::error::SceneError;
use crate::file::{BodyFile, DomainFile, FluidFile, GaitFile, LinkFile, PhaseFile, SceneFile};
use crate::gait::Phase;
use crate::scene::Scene;
use crate::shape::Shape;

impl Scene {
    /// The scene as TOML with every key written out, overrides and defaults included.
    ///
    /// # Errors
    /// [`SceneError::Unwritable`]. No scene is known for which this happens.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        Ok(toml::to_string(&scene_file(self))?)
    }
}

fn scene_file(scene: &Scene) -> SceneFile {
    let links = scene.articulation.links();
    let name = |body: usize| scene.bodies[body].name.clone();
    let phase = |phase: &Phase| PhaseFile {
        link: phase.change.map(|(link, _)| links[link].name.clone()),
        length: phase.change.map(|(_, length)| length),
        duration: phase.duration,
    };
    SceneFile {
        fluid: FluidFile {
            viscosity: scene.viscosity,
        },
        domain: domain_file(&scene.domain),
        bodies: scene.bodies.iter().map(body_file).collect(),
        links: links
            .iter()
            .map(|link| LinkFile {
                name: Some(link.name.clone()),
                body: Some(name(link.body)),
                to: Some(name(link.to)),
            })
            .collect(),
        gait: GaitFile {
            arms: scene.articulation.arms().into(),
            cycles: scene.gait.cycles,
            phases: Some(scene.gait.phases.iter().map(phase).collect())
                .filter(|list: &Vec<_>| !list.is_empty()),
        },
        model: scene.model,
        fem: scene.fem,
    }
}

/// The group `domain` of a scene file.
pub(crate) fn domain_file(domain: &Domain) -> DomainFile {
    let mut file = DomainFile {
        kind: Some(domain.kind()),
        ..DomainFile::default()
    };
    match domain {
        Domain::Unbounded | Domain::Wall => {}
        Domain::Ball { radius } | Domain::Cylinder { radius } => file.radius = Some(*radius),
        Domain::Box { size } => file.size = Some((*size).into()),
        Domain::Mesh { file: path, walls } => {
            file.file = Some(path.display().to_string());
            file.walls = Some(walls.clone());
        }
    }
    file
}

fn body_file(body: &Body) -> BodyFile {
    let (radius, half_length, axis) = match body.shape {
        Shape::Sphere { radius } => (Some(radius), None, None),
        Shape::Spheroid {
            radius,
            half_length,
            axis,
        } => (Some(radius), Some(half_length), Some(axis.into())),
        Shape::Point => (None, None, None),
    };
    BodyFile {
        name: Some(body.name.clone()),
        shape: body.shape.kind(),
        radius,
        half_length,
        axis,
        position: Some(body.position.into()),
        surface: body.surface.clone(),
        force: body.force.into(),
        torque: Some(body.torque.into()).filter(|_| body.shape != Shape::Point),
        fixed: body.fixed,
        mass: body.mass,
        inertia: body.inertia,
    }
}
