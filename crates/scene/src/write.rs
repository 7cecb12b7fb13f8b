//! From a scene back to its file, with every key written out.

use crate::file::{
    BodyFile, DomainFile, FemFile, FluidFile, GaitFile, LinkFile, ModelFile, PhaseFile, SceneFile,
};
use crate::gait::Phase;
use crate::scene::{Body, Domain, Scene};
use crate::shape::Shape;
use crate::words::{ArmsKind, ShapeKind};

impl Scene {
    /// The scene as TOML with every key written out, overrides and defaults included.
    pub fn to_toml(&self) -> String {
        to_toml(self)
    }
}

fn to_toml(scene: &Scene) -> String {
    let links = scene.articulation.links();
    let name = |body: usize| scene.bodies[body].name.clone();
    let (radius, size, file, walls) = match &scene.domain {
        Domain::Unbounded | Domain::Wall => (None, None, None, None),
        Domain::Ball { radius } | Domain::Cylinder { radius } => (Some(*radius), None, None, None),
        Domain::Box { size } => (None, Some((*size).into()), None, None),
        Domain::Mesh { file, walls } => (
            None,
            None,
            Some(file.display().to_string()),
            Some(walls.clone()),
        ),
    };
    let arms = match scene.articulation.arms() {
        rigid::Arms::Clamped => ArmsKind::Clamped,
        rigid::Arms::Free => ArmsKind::Free,
        rigid::Arms::Lab => ArmsKind::Lab,
    };
    let text = |word: &str| Some(word.to_owned());
    let body = |body: &Body| BodyFile {
        name: Some(body.name.clone()),
        shape: text(match body.shape {
            Shape::Sphere { .. } => ShapeKind::Sphere.word(),
            Shape::Spheroid { .. } => ShapeKind::Spheroid.word(),
            Shape::Point => ShapeKind::Point.word(),
        }),
        radius: match body.shape {
            Shape::Sphere { radius } | Shape::Spheroid { radius, .. } => Some(radius),
            Shape::Point => None,
        },
        half_length: match body.shape {
            Shape::Spheroid { half_length, .. } => Some(half_length),
            Shape::Sphere { .. } | Shape::Point => None,
        },
        axis: match body.shape {
            Shape::Spheroid { axis, .. } => Some(axis.into()),
            Shape::Sphere { .. } | Shape::Point => None,
        },
        position: Some(body.position.into()),
        surface: body.surface.clone(),
        force: Some(body.force.into()),
        torque: Some(body.torque.into()).filter(|_| body.shape != Shape::Point),
        fixed: Some(body.fixed).filter(|&fixed| fixed),
        mass: Some(body.mass),
        inertia: Some(body.inertia),
    };
    let phase = |phase: &Phase| PhaseFile {
        link: phase.change.map(|(link, _)| links[link].name.clone()),
        length: phase.change.map(|(_, length)| length),
        duration: Some(phase.duration),
    };
    let file = SceneFile {
        fluid: FluidFile {
            viscosity: Some(scene.viscosity),
        },
        domain: DomainFile {
            kind: text(scene.domain.kind().word()),
            radius,
            size,
            file,
            walls,
        },
        bodies: scene.bodies.iter().map(body).collect(),
        links: links
            .iter()
            .map(|link| LinkFile {
                name: Some(link.name.clone()),
                body: Some(name(link.body)),
                to: Some(name(link.to)),
            })
            .collect(),
        gait: GaitFile {
            arms: text(arms.word()),
            cycles: Some(scene.gait.cycles),
            phases: Some(scene.gait.phases.iter().map(phase).collect())
                .filter(|list: &Vec<_>| !list.is_empty()),
        },
        model: ModelFile {
            kind: text(scene.model.kind.word()),
            tolerance: Some(scene.model.tolerance),
        },
        fem: FemFile {
            formulation: text(scene.fem.formulation.word()),
            solver: text(scene.fem.solver.word()),
            subdomains: Some(scene.fem.subdomains),
            overlap: Some(scene.fem.overlap),
            rtol: Some(scene.fem.rtol),
            surface_size: scene.fem.surface_size,
            size_factor: scene.fem.size_factor,
            target: scene.fem.target,
            estimates: text(scene.fem.estimates.word()),
            geometry: text(scene.fem.geometry.word()),
            mesh_motion: text(scene.fem.mesh_motion.word()),
            mirror: text(scene.fem.mirror.word()),
        },
    };
    // Every field is a number, a text or a list of them: nothing that TOML cannot hold.
    toml::to_string(&file).unwrap_or_default()
}
