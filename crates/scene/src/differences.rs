//! Differences between the flow problems of two scenes.

use rigid::{JointDrive, JointKind};

use crate::scene::Scene;

impl Scene {
    /// The first key in which another scene has a different flow problem; `None` if it has the
    /// same.
    ///
    /// The flow problem is everything that velocities and forces at given values and rates of the
    /// joints depend on: fluid, domain, bodies and joints. Names, gaits and options may differ.
    ///
    /// ```
    /// use scene::Scene;
    /// let scene = |radius| Scene::builder().ball(radius).sphere("ball", 1.0, [0.0; 3]).build();
    /// assert_eq!(scene(10.0)?.differing_key(&scene(10.0)?), None);
    /// assert_eq!(scene(10.0)?.differing_key(&scene(20.0)?), Some("domain".to_owned()));
    /// # Ok::<(), scene::SceneError>(())
    /// ```
    pub fn differing_key(&self, other: &Self) -> Option<String> {
        let of_scene = [
            ("fluid.viscosity", self.viscosity == other.viscosity),
            ("background", self.background == other.background),
            ("domain", self.domain == other.domain),
            ("bodies", self.bodies.len() == other.bodies.len()),
            ("links", self.joints().eq(other.joints())),
            (
                "gait.arms",
                self.articulation.arms() == other.articulation.arms(),
            ),
        ];
        if let Some((key, _)) = of_scene.into_iter().find(|(_, is_same)| !is_same) {
            return Some(key.to_owned());
        }
        let mut bodies = self.bodies.iter().zip(&other.bodies).enumerate();
        bodies.find_map(|(number, (own, other))| {
            let keys = [
                ("shape", own.shape == other.shape),
                ("position", own.position == other.position),
                ("surface", own.surface == other.surface),
                ("force", own.force == other.force),
                ("torque", own.torque == other.torque),
                ("density", own.weight == other.weight),
                ("slip", own.slip == other.slip),
                ("fixed", own.fixed == other.fixed),
                ("mass", own.mass == other.mass),
                ("inertia", own.inertia == other.inertia),
            ];
            let (key, _) = keys.into_iter().find(|(_, is_same)| !is_same)?;
            Some(format!("bodies[{number}].{key}"))
        })
    }

    /// The two bodies of each joint, its kind and what drives it.
    fn joints(&self) -> impl Iterator<Item = (usize, usize, JointKind, JointDrive)> {
        let joints = self.articulation.joints().iter();
        joints.map(|l| (l.body, l.to, l.kind, l.drive))
    }
}
