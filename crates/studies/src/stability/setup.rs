//! Scenes of the stability map, as text like that of a scene file.

use std::fmt::Write;

/// Spheres and points with joints in a ball, with a gait or forces.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The `domain` table.
    pub domain: String,
    pub viscosity: f64,
    /// Radius (none for a point) and position of each body.
    pub bodies: Vec<(Option<f64>, [f64; 3])>,
    /// Pairs (`body`, `to`).
    pub joints: Vec<(usize, usize)>,
    pub arms: &'static str,
    /// Joint whose length changes in the first phase, and by how much; a phase has one joint.
    pub change: Option<(usize, f64)>,
    /// Body with an external force, and the force.
    pub pull: Option<(usize, [f64; 3])>,
    /// Element size on every sphere over the smallest radius.
    ///
    /// `None` gives each sphere the default size for its radius, scaled by keys in `more`.
    pub size: Option<f64>,
    /// More TOML.
    pub more: String,
}

impl Setup {
    /// Three unequal spheres on a bent chain, off the centre of a ball, one arm closing.
    pub fn bent_chain() -> Self {
        Self {
            domain: "{ kind = \"ball\", radius = 12 }".to_owned(),
            viscosity: 1.0,
            bodies: vec![
                (Some(1.0), [-4.0, 0.0, 0.0]),
                (Some(1.3), [0.5, 0.0, 0.0]),
                (Some(0.8), [1.0, 4.0, 0.5]),
            ],
            joints: vec![(0, 1), (2, 1)],
            arms: "free",
            change: Some((0, -0.5)),
            pull: None,
            size: Some(1.2),
            more: String::new(),
        }
    }

    /// The same scene with all lengths multiplied by `length`; durations stay the same.
    pub fn scaled(mut self, length: f64) -> Self {
        self.domain = self.domain.replace("12", &format!("{:e}", 12.0 * length));
        for (radius, position) in &mut self.bodies {
            *radius = radius.map(|r| r * length);
            position.iter_mut().for_each(|x| *x *= length);
        }
        self.change = self.change.map(|(joint, by)| (joint, by * length));
        self
    }

    /// Text of the scene, for the whole fluid, so that all solvers have the same mesh.
    pub fn toml(&self, formulation: &str, solver: &str) -> String {
        let smallest = self
            .bodies
            .iter()
            .filter_map(|(radius, _)| *radius)
            .fold(f64::INFINITY, f64::min);
        let mut text = format!(
            "fluid.viscosity = {:e}\ndomain = {}\ngait.arms = \"{}\"\nmodel.kind = \"fem\"\n\
             fem.formulation = \"{formulation}\"\nfem.solver = \"{solver}\"\nfem.rtol = 1e-10\n\
             fem.symmetry = \"off\"\nfem.estimates = \"off\"\n{}\n",
            self.viscosity, self.domain, self.arms, self.more
        );
        // Writing to a String cannot fail.
        if let Some(size) = self.size {
            let _ = writeln!(text, "fem.surface_size = {:e}", size * smallest);
        }
        for (number, (radius, [x, y, z])) in self.bodies.iter().enumerate() {
            let _ = writeln!(text, "[[bodies]]\nname = \"b{number}\"");
            let _ = match radius {
                Some(radius) => writeln!(text, "radius = {radius:e}"),
                None => writeln!(text, "shape = \"point\""),
            };
            let _ = writeln!(text, "position = [{x:e}, {y:e}, {z:e}]");
            if let Some((body, [fx, fy, fz])) = self.pull
                && body == number
            {
                let _ = writeln!(text, "force = [{fx:e}, {fy:e}, {fz:e}]");
            }
        }
        for (number, (body, to)) in self.joints.iter().enumerate() {
            let _ = writeln!(
                text,
                "[[links]]\nname = \"l{number}\"\nbody = \"b{body}\"\nto = \"b{to}\""
            );
        }
        if let Some((joint, by)) = self.change {
            let (body, to) = self.joints[joint];
            let length: f64 = (0..3)
                .map(|axis| (self.bodies[body].1[axis] - self.bodies[to].1[axis]).powi(2))
                .sum::<f64>()
                .sqrt();
            let _ = writeln!(
                text,
                "[[gait.phases]]\nlink = \"l{joint}\"\nlength = {:e}\nduration = 1",
                length + by
            );
        }
        text
    }
}
