//! Scenes by a builder on the text of a scene file.

use std::fmt::{Debug, Display};

use scene::{Document, Scene, SceneError};

/// Bodies, joints and phases of a scene file, with settings by dotted keys as by `--set`.
///
/// A literal text would fix the order of the tables; settings may be given at any place, and the
/// same fixture serves with other settings.
#[must_use]
#[derive(Clone, Debug, Default)]
pub struct SceneText {
    text: String,
    bodies: Vec<String>,
    links: Vec<String>,
    phases: Vec<String>,
    settings: Vec<String>,
}

impl SceneText {
    /// A scene without bodies.
    pub fn new() -> Self {
        Self::default()
    }

    /// The text of a scene file, without further bodies.
    pub fn file(text: &str) -> Self {
        let text = text.to_owned();
        Self {
            text,
            ..Self::new()
        }
    }

    /// Sets a key such as `fem.rtol` or `bodies.left.force`; a number that is written as `1e-9`
    /// stays exact.
    pub fn with(mut self, key: &str, value: impl Display) -> Self {
        self.settings.push(format!("{key}={value}"));
        self
    }

    /// Sets the keys `key=value` of a list.
    pub fn set(mut self, settings: &[&str]) -> Self {
        let settings = settings.iter().map(|&setting| setting.to_owned());
        self.settings.extend(settings);
        self
    }

    /// Encloses the fluid in a ball.
    pub fn ball(self, radius: f64) -> Self {
        self.with(
            "domain",
            format!("{{ kind = \"ball\", radius = {radius:?} }}"),
        )
    }

    /// Sets the model and its tolerance.
    pub fn model(self, kind: &str, tolerance: f64) -> Self {
        self.with("model.kind", kind).tolerance(tolerance)
    }

    /// Sets the tolerance.
    pub fn tolerance(self, tolerance: f64) -> Self {
        self.with("model.tolerance", format!("{tolerance:?}"))
    }

    /// Finite elements of this size on the smallest body.
    pub fn elements(self, size: f64) -> Self {
        self.with("model.kind", "fem")
            .with("fem.surface_size", format!("{size:?}"))
    }

    /// Adds a sphere.
    pub fn sphere(self, name: &str, radius: f64, position: impl Debug) -> Self {
        self.shape(name, &format!("radius = {radius:?}"), position)
    }

    /// Adds a body by the keys of its shape, separated by commas.
    pub fn shape(mut self, name: &str, keys: &str, position: impl Debug) -> Self {
        let body = format!("{{ name = {name:?}, {keys}, position = {position:?} }}");
        self.bodies.push(body);
        self
    }

    /// Adds a point at which joints meet.
    pub fn point(self, name: &str, position: impl Debug) -> Self {
        self.shape(name, "shape = \"point\"", position)
    }

    /// Adds an arm between two bodies.
    pub fn slide(self, name: &str, body: &str, to: &str) -> Self {
        self.joint(name, body, to, "joint = \"slide\"")
    }

    /// Adds a joint by its further keys, separated by commas.
    pub fn joint(mut self, name: &str, body: &str, to: &str, keys: &str) -> Self {
        let joint = format!("{{ name = {name:?}, body = {body:?}, to = {to:?}, {keys} }}");
        self.links.push(joint);
        self
    }

    /// Adds a phase by its keys, separated by commas.
    pub fn phase(mut self, keys: &str) -> Self {
        self.phases.push(format!("{{ {keys} }}"));
        self
    }

    /// Adds a phase per joint and value at its end.
    pub fn phases(self, changes: &[(&str, f64)]) -> Self {
        changes.iter().fold(self, |text, (joint, value)| {
            text.phase(&format!("link = {joint:?}, length = {value:?}"))
        })
    }

    /// Removes all phases.
    pub fn without_phases(mut self) -> Self {
        self.phases.clear();
        self
    }

    /// Sets a harmonic gait by joints, amplitudes and phase angles.
    pub fn harmonics(self, period: f64, terms: &[(&str, f64, f64)]) -> Self {
        let terms: Vec<String> = (terms.iter())
            .map(|(joint, amplitude, phase)| {
                format!("{{ link = {joint:?}, amplitude = {amplitude:?}, phase = {phase:?} }}")
            })
            .collect();
        self.with("gait.period", format!("{period:?}"))
            .with("gait.harmonics", format!("[{}]", terms.join(", ")))
    }

    /// The text without the settings.
    pub fn toml(&self) -> String {
        let lists = [
            ("bodies", &self.bodies),
            ("links", &self.links),
            ("gait.phases", &self.phases),
        ];
        let lists = lists.iter().filter(|(_, entries)| !entries.is_empty());
        let list = |(name, entries): &(&str, &Vec<String>)| {
            format!("{name} = [\n    {},\n]\n", entries.join(",\n    "))
        };
        lists.map(list).chain([self.text.clone()]).collect()
    }

    /// The scene, with the checks of a file.
    ///
    /// # Errors
    /// As for a file with overrides.
    pub fn try_scene(&self) -> Result<Scene, SceneError> {
        let mut document = Document::parse(&self.toml(), "scene.toml")?;
        (self.settings.iter()).try_for_each(|setting| document.set(setting))?;
        Scene::from_document(document)
    }

    /// The scene of a correct text.
    ///
    /// # Panics
    /// If the scene is refused.
    #[track_caller]
    pub fn scene(&self) -> Scene {
        match self.try_scene() {
            Ok(scene) => scene,
            Err(error) => panic!("{error}\n{}{:?}", self.toml(), self.settings),
        }
    }

    /// The message with which the scene is refused.
    ///
    /// # Panics
    /// If it is not.
    #[track_caller]
    pub fn refusal(&self) -> String {
        match self.try_scene() {
            Ok(_) => panic!("accepted: {}{:?}", self.toml(), self.settings),
            Err(error) => error.to_string(),
        }
    }
}

/// The swimmer of Najafi & Golestanian (2004) along x: spheres `left`, `centre` and `right` of
/// radius 1; the arms `left-arm` and `right-arm` close from 10 to 6 one after the other, and open.
pub fn three_spheres() -> SceneText {
    chain(&["left", "centre", "right"], &[-10.0, 0.0, 10.0])
        .slide("left-arm", "left", "centre")
        .slide("right-arm", "right", "centre")
        .phases(&STROKE)
}

/// Joints and lengths of the phases of [`three_spheres`].
pub const STROKE: [(&str, f64); 4] = [
    ("left-arm", 6.0),
    ("right-arm", 6.0),
    ("left-arm", 10.0),
    ("right-arm", 10.0),
];

/// Unit spheres on the x axis, without joints.
pub fn chain(names: &[&str], places: &[f64]) -> SceneText {
    let spheres = names.iter().zip(places);
    spheres.fold(SceneText::new(), |text, (name, &x)| {
        text.sphere(name, 1.0, [x, 0.0, 0.0])
    })
}

/// Unit spheres `a` and `b` on the x axis with the arm `arm` between them.
pub fn pair(a: f64, b: f64) -> SceneText {
    chain(&["a", "b"], &[a, b]).slide("arm", "b", "a")
}

/// The planar swimmer of Lefebvre-Lepot & Merlet (2009), each point moved by `place`: three arms
/// `a0`, `a1`, `a2` of length 6 from the point `joint` to the spheres `s0`, `s1`, `s2`; the first
/// two close to 4 and open.
pub fn planar(place: impl Fn([f64; 3]) -> [f64; 3]) -> SceneText {
    let mut text = SceneText::new().point("joint", place([0.0; 3]));
    for k in 0..3 {
        let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 3.0).sin_cos();
        let (sphere, arm) = (format!("s{k}"), format!("a{k}"));
        let at = place([6.0 * cos, 6.0 * sin, 0.0]);
        text = text.sphere(&sphere, 1.0, at).slide(&arm, &sphere, "joint");
    }
    text.phases(&[("a0", 4.0), ("a1", 4.0), ("a0", 6.0), ("a1", 6.0)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_come_after_the_text() {
        let scene = three_spheres()
            .ball(40.0)
            .tolerance(1e-9)
            .with("gait.cycles", 3);
        let scene = scene.with("bodies.left.force", "[1, 0, 0]").scene();
        assert_eq!((scene.gait().cycles, scene.gait().phases.len()), (3, 4));
        assert_eq!(
            (scene.model().tolerance, scene.bodies()[0].force.x),
            (1e-9, 1.0)
        );
        assert_eq!(scene.articulation().initial_shape(), [10.0, 10.0]);
        let wrong = pair(0.0, 4.0).with("bodies.a.radius", 5);
        crate::bounds::contains("radius", &wrong.refusal(), &["touch or overlap"]);
    }
}
