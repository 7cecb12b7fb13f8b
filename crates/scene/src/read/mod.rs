//! Construction of a scene from the keys of a document, with all checks.

mod articulation;
mod bodies;
mod change;
mod contacts;
mod copies;
mod deformations;
mod domain;
mod extent;
mod flow;
mod fluid;
mod fold_search;
mod gait;
pub(crate) mod limits;
mod loads;
mod triangles;

use std::path::Path;

use crate::checks::Checks;
use crate::document::Document;
use crate::error::SceneError;
use crate::keys::SceneFile;
use crate::scene::Scene;
use crate::surface_shape::SurfaceFiles;
use crate::words::InertiaKind;

impl Scene {
    /// Reads and checks a scene file, with overrides written `key=value` (as for `--set`).
    ///
    /// # Errors
    /// The first problem found, with file, line, key and remedy.
    pub fn read(path: impl AsRef<Path>, overrides: &[String]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        let mut document = Document::read(path)?;
        overrides
            .iter()
            .try_for_each(|assignment| document.set(assignment))?;
        Self::from_document(document)
    }

    /// Checks the text of a scene; files that it names are searched in the current folder.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn parse(text: &str) -> Result<Self, SceneError> {
        Self::from_document(Document::parse(text, "scene.toml")?)
    }

    /// Builds a scene from the keys and values of a document.
    ///
    /// # Errors
    /// As [`Scene::read`].
    pub fn from_document(document: Document) -> Result<Self, SceneError> {
        let scene = scene(document)?;
        contacts::check_initial(&scene)?;
        contacts::check_stroke(&scene)?;
        Ok(scene)
    }
}

/// The scene of a document, before the check for bodies that touch.
fn scene(mut document: Document) -> Result<Scene, SceneError> {
    copies::expand(&mut document)?;
    let checks = Checks(&document);
    let file: SceneFile =
        document
            .values()
            .clone()
            .try_into()
            .map_err(|error: toml::de::Error| SceneError::Syntax {
                place: document.path().display().to_string(),
                message: error.message().to_owned(),
            })?;
    let mut surfaces = SurfaceFiles::default();
    let domain = domain::domain(&checks, &file.domain, &mut surfaces)?;
    let background = flow::background(&checks, file.background.as_ref(), &domain)?;
    let has_background = background.is_some();
    let mut bodies = bodies::bodies(
        &checks,
        &file.bodies,
        &domain,
        (background.as_ref(), file.gait.period),
        &mut surfaces,
    )?;
    let field = loads::field(&checks, file.field.as_ref(), file.gait.period, &bodies)?;
    let repulsion = loads::repulsion(&checks, file.contact.as_ref(), &domain)?;
    let (gravity, density) = (file.gravity.into(), file.fluid.density.unwrap_or(0.0));
    flow::enter_weights(&checks, &gravity, density, &mut bodies)?;
    let (viscosity, rheology) = fluid::viscosity(&checks, &file.fluid, has_background)?;
    let inertia = flow::inertia(&checks, &file, (&domain, has_background), &bodies)?;
    let mut joints = articulation::joints(&checks, &file.links, &bodies)?;
    deformations::enter(&checks, &file, &mut bodies, &mut joints, &mut surfaces)?;
    deformations::check_bodies(&checks, &file, &domain, &bodies)?;
    let joint_forces = articulation::oscillating(&checks, &file.links, file.gait.period)?;
    let (gait, gait_table) = gait::gait(&checks, &file.gait, &joints)?;
    let unplaced = extent::Unplaced {
        checks: &checks,
        file: &file,
        viscosity,
        domain: &domain,
        background: background.as_ref(),
        bodies: &bodies,
        gait: &gait,
        gait_table: gait_table.as_ref(),
        joints: &joints,
        joint_forces: &joint_forces,
        field: field.as_ref(),
    };
    unplaced.check_extent()?;
    let from = (&gait, gait_table.as_ref());
    let mut start = deformations::initial_values(&bodies);
    start.extend(gait::initial_shape(&checks, &file.gait, from, &joints)?);
    let articulation =
        articulation::articulation(&checks, &mut bodies, joints, file.gait.arms, &start)?;
    let noise = fluid::thermal_noise(&checks, &file, &bodies, &articulation)?;
    articulation::check_held(&checks, &bodies, &articulation, &gait)?;
    deformations::check_gait(&checks, (&domain, &bodies), from, &articulation)?;
    if file.gait.periodic {
        gait::check_periodic(&checks, &articulation)?;
    }
    limits::check_model(&checks, &file.model)?;
    limits::check_fem(&checks, &file.fem)?;
    limits::check_output(&checks, &file.output)?;
    limits::check_design(&checks, &file.optimise, &file.learn, articulation.joints())?;
    let stem = document.path().file_stem();
    let name = stem.map(|stem| stem.to_string_lossy().into_owned());
    // Names of dots alone, as of the file `...toml`, are those of other folders.
    let name = name.filter(|name| name.chars().any(|c| c != '.'));
    document.warn(domain::without_effect(&document, &file.domain));
    document.warn(surfaces.warnings);
    let scene = Scene {
        name: name.unwrap_or_else(|| "scene".to_owned()),
        viscosity,
        rheology,
        density,
        inertia,
        noise,
        gravity,
        background,
        domain,
        bodies,
        articulation,
        field,
        repulsion,
        joint_forces,
        gait,
        gait_table,
        starts_periodic: file.gait.periodic,
        model: file.model,
        fem: file.fem,
        optimise: file.optimise,
        learn: file.learn,
        output: file.output,
        sources: surfaces.sources,
        document,
    };
    if scene.starts_periodic && scene.inertia.kind != InertiaKind::None {
        scene.check_periodic_flow()?;
    }
    Ok(scene)
}
