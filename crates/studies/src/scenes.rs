//! Scenes of the studies: files of the project with changes, and texts built body by body.

use std::fmt::{Debug, Display};
use std::path::Path;

use anyhow::{Context, Result};
use swimmer::models::InstantaneousSolution;
use swimmer::{Scene, choose, solve_start};

/// Scene from the project's folder `scenes`; `overrides` have the form `key=value`.
pub fn read<S: AsRef<str>>(name: &str, overrides: &[S]) -> Result<Scene> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let overrides: Vec<String> = overrides.iter().map(|o| o.as_ref().to_owned()).collect();
    Scene::read(folder.join(name), &overrides).with_context(|| format!("scene {name}"))
}

/// The override that gives unit rate to the first phase of the three-sphere scenes.
///
/// The first phase changes a length by 4, so that the rate is one if it takes a time of 4.
pub const UNIT_RATE: &str = "gait.phases.0.duration=4";

/// Solves a scene at its start with the model that it chooses.
pub fn solve(scene: &Scene) -> Result<InstantaneousSolution, swimmer::SwimError> {
    let mut model = choose(scene)?.model;
    solve_start(scene, model.as_mut())
}

/// The lines of a scene that choose finite elements of this size on the spheres.
pub fn by_elements(size: f64) -> String {
    format!("model.kind = \"fem\"\nfem.surface_size = {size:?}")
}

/// Text of a scene in a ball around the origin; `model` are the lines that choose the model.
pub fn in_ball(container: f64, model: &str) -> SceneText {
    let domain = format!("domain = {{ kind = \"ball\", radius = {container:?} }}");
    SceneText::new(domain).line(model)
}

/// A unit sphere at the centre of a ball of radius `1 / lambda`, under a unit force along x and a
/// unit torque about z.
pub fn loaded_sphere(lambda: f64, size: f64) -> Result<Scene> {
    let text = in_ball(1.0 / lambda, &by_elements(size)).sphere("s0", 1.0, [0.0; 3]);
    text.line("force = [1, 0, 0]\ntorque = [0, 0, 1]").parse()
}

/// The text of a scene, built from keys, bodies, joints and phases in this order.
#[derive(Clone, Debug, Default)]
pub struct SceneText(pub String);

impl SceneText {
    /// A text that begins with these lines.
    pub fn new(lines: impl Display) -> Self {
        Self::default().line(lines)
    }

    /// Adds lines: keys of the scene at the beginning, or of the last body, joint or phase.
    pub fn line(mut self, lines: impl Display) -> Self {
        self.0 += &format!("{lines}\n");
        self
    }

    /// Adds one key of the scene or of the last table.
    pub fn key(self, name: &str, value: impl Debug) -> Self {
        self.line(format_args!("{name} = {value:?}"))
    }

    /// Adds a sphere.
    pub fn sphere(self, name: impl Display, radius: f64, position: [f64; 3]) -> Self {
        self.body(name, position).key("radius", radius)
    }

    /// Adds a body, whose shape follows as further keys.
    pub fn body(self, name: impl Display, position: [f64; 3]) -> Self {
        self.line(format_args!("[[bodies]]\nname = \"{name}\""))
            .key("position", position)
    }

    /// Adds a joint between two bodies.
    pub fn joint(self, name: impl Display, body: impl Display, to: impl Display) -> Self {
        self.line(format_args!(
            "[[links]]\nname = \"{name}\"\nbody = \"{body}\"\nto = \"{to}\""
        ))
    }

    /// Adds a phase that moves one joint to this length.
    pub fn phase(self, joint: impl Display, length: f64) -> Self {
        let table = format!("[[gait.phases]]\nlink = \"{joint}\"");
        self.line(table).key("length", length)
    }

    /// Adds phases, each of which moves one joint to a length.
    pub fn phases(self, phases: &[(&str, f64)]) -> Self {
        let phases = phases.iter();
        phases.fold(self, |text, (joint, length)| text.phase(joint, *length))
    }

    /// Adds spheres `s0`, `s1`, ... on the x axis.
    pub fn spheres_on_axis(self, radii: &[f64], places: impl IntoIterator<Item = f64>) -> Self {
        let spheres = radii.iter().zip(places).enumerate();
        spheres.fold(self, |text, (k, (&radius, x))| {
            text.sphere(format_args!("s{k}"), radius, [x, 0.0, 0.0])
        })
    }

    /// Adds three spheres on the x axis, the middle one at the origin, with the joints `left` and
    /// `right` between the centres.
    pub fn swimmer(self, radii: [f64; 3], [left, right]: [f64; 2]) -> Self {
        let text = self.spheres_on_axis(&radii, [-left, 0.0, right]);
        text.joint("left", "s0", "s1").joint("right", "s2", "s1")
    }

    /// Adds the four phases of a stroke: the left and then the right joint close, then both open.
    pub fn stroke(self, names: [&str; 2], closed: [f64; 2], open: [f64; 2]) -> Self {
        let lengths = closed.into_iter().chain(open);
        let phases = names.into_iter().cycle().zip(lengths);
        phases.fold(self, |text, (name, length)| text.phase(name, length))
    }

    /// The scene of this text.
    pub fn parse(&self) -> Result<Scene> {
        Scene::parse(&self.0).with_context(|| format!("the scene\n{}", self.0))
    }
}
