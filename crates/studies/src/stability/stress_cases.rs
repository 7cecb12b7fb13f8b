//! Stress cases of finite elements, and the outcome that each must have.

use super::map::Expected;
use crate::scenes::SceneText;

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
    pub fn text(&self, formulation: &str, solver: &str) -> SceneText {
        let radii = self.bodies.iter().filter_map(|(radius, _)| *radius);
        let smallest = radii.fold(f64::INFINITY, f64::min);
        let mut text = SceneText::new(format!("domain = {}", self.domain))
            .key("fluid.viscosity", self.viscosity)
            .key("gait.arms", self.arms)
            .line("model.kind = \"fem\"\nfem.rtol = 1e-10\nfem.symmetry = \"off\"\nfem.estimates = \"off\"")
            .key("fem.formulation", formulation)
            .key("fem.solver", solver)
            .line(&self.more);
        if let Some(size) = self.size {
            text = text.line(format_args!("fem.surface_size = {:e}", size * smallest));
        }
        for (number, &(radius, position)) in self.bodies.iter().enumerate() {
            text = text.body(format_args!("b{number}"), position);
            text = match radius {
                Some(radius) => text.line(format_args!("radius = {radius:e}")),
                None => text.key("shape", "point"),
            };
            if let Some((body, force)) = self.pull
                && body == number
            {
                text = text.key("force", force);
            }
        }
        for (number, (body, to)) in self.joints.iter().enumerate() {
            let [name, body] = [format!("l{number}"), format!("b{body}")];
            text = text.joint(name, body, format_args!("b{to}"));
        }
        if let Some((joint, by)) = self.change {
            let (body, to) = self.joints[joint];
            let length: f64 = (0..3)
                .map(|axis| (self.bodies[body].1[axis] - self.bodies[to].1[axis]).powi(2))
                .sum::<f64>()
                .sqrt();
            text = text
                .phase(format_args!("l{joint}"), length + by)
                .line("duration = 1");
        }
        text
    }

    fn with_bodies<const N: usize>(self, bodies: [(f64, [f64; 3]); N]) -> Self {
        Self {
            bodies: bodies.map(|(radius, x)| (Some(radius), x)).to_vec(),
            ..self
        }
    }

    fn with_joints(self, joints: &[(usize, usize)]) -> Self {
        Self {
            joints: joints.to_vec(),
            ..self
        }
    }

    fn with_change(self, change: Option<(usize, f64)>) -> Self {
        Self { change, ..self }
    }

    fn with_pull(self, body: usize, force: [f64; 3]) -> Self {
        Self {
            pull: Some((body, force)),
            ..self
        }
    }

    fn with_viscosity(self, viscosity: f64) -> Self {
        Self { viscosity, ..self }
    }

    fn with_arms(self, arms: &'static str) -> Self {
        Self { arms, ..self }
    }

    fn with_size(self, size: f64) -> Self {
        Self {
            size: Some(size),
            ..self
        }
    }

    fn with_keys(self, more: &str) -> Self {
        Self {
            more: more.to_owned(),
            ..self
        }
    }

    fn in_domain(self, domain: &str) -> Self {
        Self {
            domain: domain.to_owned(),
            ..self
        }
    }
}

/// One stress case.
#[derive(Clone, Debug)]
pub struct StressCase {
    pub name: &'static str,
    pub setup: Setup,
    /// A similar scene in other units, whose velocities times a factor are the right ones; without
    /// it those of p-tilde with the direct solver on the same scene are.
    pub truth: Option<(Setup, f64)>,
    pub expected: Expected,
    /// Whether the tests run it.
    pub quick: bool,
}

impl StressCase {
    /// Sets larger elements, for the part that the tests run.
    pub fn coarsen(&mut self, size: f64) {
        self.setup.size = Some(size);
        if let Some((setup, _)) = &mut self.truth {
            setup.size = Some(size);
        }
    }
}

/// Factor on lengths, about micrometres instead of metres.
///
/// A power of two changes no rounding, so the mesh is the same. With 1e-6 the mesh is different,
/// and velocities differ by the discretisation error.
const MICRO: f64 = 1.0 / 1_048_576.0;

/// A star: `arms` spheres around a point, alternately on both sides of a plane so that there is no
/// symmetry.
fn star(arms: usize) -> Setup {
    let mut bodies = vec![(None, [0.0; 3])];
    let mut joints = Vec::new();
    for number in 0..arms {
        let angle = std::f64::consts::TAU * number as f64 / arms as f64;
        let height = if number % 2 == 0 { 1.0 } else { -0.7 };
        bodies.push((Some(0.8), [6.0 * angle.cos(), 6.0 * angle.sin(), height]));
        joints.push((number + 1, 0));
    }
    Setup {
        bodies,
        joints,
        ..Setup::bent_chain().with_size(1.0)
    }
}

/// A cube of spheres, each linked to the next one along a path: a long chain of dependent bodies.
fn snake(edge: usize) -> Setup {
    let mut bodies = Vec::new();
    for k in 0..edge {
        for j in 0..edge {
            for i in 0..edge {
                // The path goes back and forth, so that successive spheres are neighbours.
                let j = if k % 2 == 0 { j } else { edge - 1 - j };
                let i = if (j + k) % 2 == 0 { i } else { edge - 1 - i };
                bodies.push((
                    Some(0.8),
                    [i, j, k].map(|n| 4.0 * n as f64 - 2.0 * (edge - 1) as f64),
                ));
            }
        }
    }
    let joints = (1..bodies.len()).map(|n| (n, n - 1)).collect();
    Setup {
        bodies,
        joints,
        ..Setup::bent_chain().with_size(1.1).with_arms("clamped")
    }
}

/// All stress cases, the plain scene first.
pub fn all() -> Vec<StressCase> {
    let plain = Setup::bent_chain;
    let case = |name, setup: Setup| StressCase {
        name,
        setup,
        truth: None,
        expected: Expected::Right,
        quick: false,
    };
    let similar = |name, setup: Setup, factor| StressCase {
        truth: Some((plain(), factor)),
        ..case(name, setup)
    };
    let refused = |name, setup: Setup, message| StressCase {
        expected: Expected::Refused(message),
        quick: true,
        ..case(name, setup)
    };
    let alone = |position, force| {
        let one = plain().with_bodies([(1.0, position)]).with_joints(&[]);
        one.with_change(None).with_pull(0, force)
    };
    let triangle = plain()
        .with_joints(&[(0, 1), (2, 1), (2, 0)])
        .with_change(None)
        .with_pull(0, [0.0, 1.0, 0.0]);
    let pair = |gap: f64| {
        let left = (1.0, [-1.0 - gap / 2.0, 0.0, 0.0]);
        let right = (1.0, [1.0 + gap / 2.0, 0.3, 0.0]);
        let pair = plain().with_bodies([left, right]).with_joints(&[(0, 1)]);
        pair.with_change(Some((0, 0.5)))
    };
    let at_wall = |x: f64| {
        let others = [(1.3, [-6.0, 0.0, 0.0]), (0.8, [-5.0, 4.0, 0.5])];
        plain().with_bodies([(1.0, [x, 0.0, 0.0]), others[0], others[1]])
    };
    let backwards = plain()
        .with_bodies([
            (0.8, [6.0, 3.0, 0.0]),
            (1.0, [3.0, 0.0, 0.0]),
            (1.3, [-0.5, 0.5, 0.0]),
            (1.0, [-4.0, -1.0, 1.0]),
        ])
        .with_joints(&[(0, 1), (1, 2), (2, 3)])
        .with_change(Some((1, -0.5)));
    let two_swimmers = plain()
        .with_bodies([
            (1.0, [-5.0, 3.0, 0.0]),
            (1.0, [-1.0, 3.0, 1.0]),
            (0.8, [0.0, -3.0, 0.0]),
            (1.2, [4.0, -3.5, 0.0]),
        ])
        .with_joints(&[(0, 1), (2, 3)]);
    let unequal = plain()
        .with_bodies([
            (0.3, [-5.5, 0.0, 0.0]),
            (3.0, [0.0, 0.0, 0.0]),
            (0.5, [1.0, 6.0, 0.5]),
        ])
        .with_keys("fem.size_factor = 2");
    let point = Setup {
        bodies: vec![(Some(1.0), [0.0; 3]), (None, [3.0, 0.0, 0.0])],
        ..plain().with_joints(&[]).with_change(None)
    };
    let large = plain().scaled(1.0 / MICRO).with_viscosity(1e-9);
    let off_centre = [3.0, 1.0, 0.0];
    let narrow = alone([0.1, 0.0, 0.0], [1.0, 1.0, 0.0]);
    vec![
        case("bent chain of three", plain()),
        similar("viscosity 1e-9", plain().with_viscosity(1e-9), 1.0),
        similar("viscosity 1e9", plain().with_viscosity(1e9), 1.0),
        similar("lengths times 2^-20", plain().scaled(MICRO), MICRO),
        similar("viscosity 1e-9 and lengths times 2^20", large, 1.0 / MICRO),
        case("lengths times 1e-6", plain().scaled(1e-6)),
        case("arms clamped", plain().with_arms("clamped")),
        case("arms lab", plain().with_arms("lab")),
        case("one body, pulled", alone(off_centre, [1.0, 0.0, 0.0])),
        case("pulled and swimming", plain().with_pull(2, [0.0, 0.0, 5.0])),
        case("chain of dependent bodies, numbered backwards", backwards),
        StressCase {
            quick: true,
            ..case("closed loop, redundant", triangle.clone())
        },
        refused(
            "closed loop, contradictory",
            triangle.with_change(Some((0, -0.5))),
            "loop",
        ),
        case("two swimmers", two_swimmers),
        case("star of three around a point", star(3)),
        case("star of ten around a point", star(10)),
        case("snake of 27", snake(3)),
        case(
            "radii 1 to 10",
            Setup {
                size: None,
                ..unequal
            },
        ),
        case("gap of 0.5 radii", pair(0.5)),
        case("gap of 0.1 radii", pair(0.1)),
        case("gap of 0.03 radii", pair(0.03)),
        refused("spheres in contact", pair(-0.05), "overlap"),
        case("close to the wall", at_wall(-10.5)),
        refused("through the wall", at_wall(-11.5), "wall"),
        refused("a point without links", point, "point"),
        case(
            "a ball of 1.5 radii",
            narrow.in_domain("{ kind = \"ball\", radius = 1.5 }"),
        ),
        case(
            "a ball of 500 radii",
            plain().in_domain("{ kind = \"ball\", radius = 500 }"),
        ),
        case(
            "a box",
            plain().in_domain("{ kind = \"box\", size = [24, 20, 16] }"),
        ),
        case("nothing moves", alone(off_centre, [0.0; 3])),
        case(
            "no container",
            plain().in_domain("{ kind = \"unbounded\" }"),
        ),
        refused(
            "a viscosity of zero",
            plain().with_viscosity(0.0),
            "fluid.viscosity must be",
        ),
        refused(
            "a viscosity that is NaN",
            plain().with_viscosity(f64::NAN),
            "float",
        ),
        case(
            "straight elements",
            plain().with_keys("fem.geometry = \"straight\""),
        ),
        case("elements of half the radius", plain().with_size(0.5)),
    ]
}
