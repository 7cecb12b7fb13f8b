//! Stress cases of finite elements, and the outcome that each must have.

use std::f64::consts::TAU;

use swimmer::scene::Document;
use swimmer::{Scene, SwimError};

use super::map::Expected;
use crate::scenes::in_ball;

/// Spheres and points with joints in a ball, with a gait or forces.
#[derive(Clone, Debug)]
pub struct Setup {
    /// Radius of the ball.
    ball: f64,
    /// Radius (none for a point) and position of each body `b0`, `b1`, ...
    bodies: Vec<(Option<f64>, [f64; 3])>,
    /// Pairs (`body`, `to`).
    joints: Vec<(usize, usize)>,
    /// Joint whose length changes in the first phase, and by how much; a phase has one joint.
    change: Option<(usize, f64)>,
    /// Element size on every sphere over the smallest radius.
    ///
    /// `None` gives each sphere the default size for its radius, scaled by other keys.
    pub size: Option<f64>,
    /// Further keys, `key=value`.
    keys: Vec<&'static str>,
}

impl Setup {
    /// Three unequal spheres on a bent chain, off the centre of a ball, one arm closing.
    pub fn bent_chain() -> Self {
        Self {
            ball: 12.0,
            bodies: vec![
                (Some(1.0), [-4.0, 0.0, 0.0]),
                (Some(1.3), [0.5, 0.0, 0.0]),
                (Some(0.8), [1.0, 4.0, 0.5]),
            ],
            joints: vec![(0, 1), (2, 1)],
            change: Some((0, -0.5)),
            size: Some(1.2),
            keys: Vec::new(),
        }
    }

    /// The bent chain with these keys.
    fn with(keys: &[&'static str]) -> Self {
        Self {
            keys: keys.to_vec(),
            ..Self::bent_chain()
        }
    }

    /// Spheres on joints, of which one changes its length.
    fn linkage<const N: usize>(
        spheres: [(f64, [f64; 3]); N],
        joints: &[(usize, usize)],
        change: Option<(usize, f64)>,
    ) -> Self {
        Self {
            bodies: spheres.map(|(radius, x)| (Some(radius), x)).to_vec(),
            joints: joints.to_vec(),
            change,
            ..Self::bent_chain()
        }
    }

    /// A unit sphere without joints.
    fn one(position: [f64; 3], keys: &[&'static str]) -> Self {
        Self {
            keys: keys.to_vec(),
            ..Self::linkage([(1.0, position)], &[], None)
        }
    }

    /// The bent chain with all lengths multiplied by `length`; durations stay the same.
    fn scaled(length: f64, keys: &[&'static str]) -> Self {
        let mut setup = Self::with(keys);
        setup.ball *= length;
        for (radius, position) in &mut setup.bodies {
            *radius = radius.map(|r| r * length);
            position.iter_mut().for_each(|x| *x *= length);
        }
        setup.change = setup.change.map(|(joint, by)| (joint, by * length));
        setup
    }

    /// The scene, for the whole fluid, so that all solvers have the same mesh.
    pub fn scene(&self, formulation: &str, solver: &str) -> Result<Scene, SwimError> {
        let radii = self.bodies.iter().filter_map(|(radius, _)| *radius);
        let smallest = radii.fold(f64::INFINITY, f64::min);
        let fem = "fem.rtol = 1e-10\nfem.symmetry = \"off\"\nfem.estimates = \"off\"";
        let mut text = in_ball(self.ball, "model.kind = \"fem\"\ngait.arms = \"free\"")
            .line(fem)
            .key("fem.formulation", formulation)
            .key("fem.solver", solver);
        if let Some(size) = self.size {
            text = text.line(format_args!("fem.surface_size = {:e}", size * smallest));
        }
        for (number, &(radius, position)) in self.bodies.iter().enumerate() {
            text = text.body(format_args!("b{number}"), position);
            text = match radius {
                Some(radius) => text.line(format_args!("radius = {radius:e}")),
                None => text.key("shape", "point"),
            };
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
        let mut document = Document::parse(&text.0, "stress-case.toml")?;
        self.keys.iter().try_for_each(|key| document.set(key))?;
        Ok(Scene::from_document(document)?)
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

/// A case that must have the right solution.
fn case(name: &'static str, setup: Setup) -> StressCase {
    StressCase {
        name,
        setup,
        truth: None,
        expected: Expected::Right,
        quick: false,
    }
}

/// A case that must be refused with this message.
fn refused(name: &'static str, setup: Setup, message: &'static str) -> StressCase {
    StressCase {
        expected: Expected::Refused(message),
        quick: true,
        ..case(name, setup)
    }
}

/// All stress cases, the plain scene first.
pub fn all() -> Vec<StressCase> {
    [units(), linkages(), gaps(), surroundings()].concat()
}

/// Factor on lengths, about micrometres instead of metres.
///
/// A power of two changes no rounding, so the mesh is the same. With 1e-6 the mesh is different,
/// and velocities differ by the discretisation error.
const MICRO: f64 = 1.0 / 1_048_576.0;

/// The bent chain in other units.
fn units() -> Vec<StressCase> {
    let similar = |name, setup: Setup, factor| StressCase {
        truth: Some((Setup::bent_chain(), factor)),
        ..case(name, setup)
    };
    let thin = "fluid.viscosity=1e-9";
    let large = Setup::scaled(1.0 / MICRO, &[thin]);
    vec![
        case("bent chain of three", Setup::bent_chain()),
        similar("viscosity 1e-9", Setup::with(&[thin]), 1.0),
        similar("viscosity 1e9", Setup::with(&["fluid.viscosity=1e9"]), 1.0),
        similar("lengths times 2^-20", Setup::scaled(MICRO, &[]), MICRO),
        similar("viscosity 1e-9 and lengths times 2^20", large, 1.0 / MICRO),
        case("lengths times 1e-6", Setup::scaled(1e-6, &[])),
    ]
}

/// Joints, loops and many bodies.
fn linkages() -> Vec<StressCase> {
    let backwards = [
        (0.8, [6.0, 3.0, 0.0]),
        (1.0, [3.0, 0.0, 0.0]),
        (1.3, [-0.5, 0.5, 0.0]),
        (1.0, [-4.0, -1.0, 1.0]),
    ];
    let two_swimmers = [
        (1.0, [-5.0, 3.0, 0.0]),
        (1.0, [-1.0, 3.0, 1.0]),
        (0.8, [0.0, -3.0, 0.0]),
        (1.2, [4.0, -3.5, 0.0]),
    ];
    let triangle = Setup {
        joints: vec![(0, 1), (2, 1), (2, 0)],
        ..Setup::with(&["bodies.b0.force=[0, 1, 0]"])
    };
    let still = Setup {
        change: None,
        ..triangle.clone()
    };
    let backwards = Setup::linkage(backwards, &[(0, 1), (1, 2), (2, 3)], Some((1, -0.5)));
    let two_swimmers = Setup::linkage(two_swimmers, &[(0, 1), (2, 3)], Some((0, -0.5)));
    let pulled = Setup::one([3.0, 1.0, 0.0], &["bodies.b0.force=[1, 0, 0]"]);
    vec![
        case("arms clamped", Setup::with(&["gait.arms=clamped"])),
        case("arms lab", Setup::with(&["gait.arms=lab"])),
        case("one body, pulled", pulled),
        case(
            "pulled and swimming",
            Setup::with(&["bodies.b2.force=[0, 0, 5]"]),
        ),
        case("chain of dependent bodies, numbered backwards", backwards),
        StressCase {
            quick: true,
            ..case("closed loop, redundant", still)
        },
        refused("closed loop, contradictory", triangle, "loop"),
        case("two swimmers", two_swimmers),
        case("star of three around a point", star(3)),
        case("star of ten around a point", star(10)),
        case("snake of 27", snake(3)),
    ]
}

/// A star: `arms` spheres around a point, alternately on both sides of a plane so that there is no
/// symmetry.
fn star(arms: usize) -> Setup {
    let sphere = |number: usize| {
        let angle = TAU * number as f64 / arms as f64;
        let height = if number.is_multiple_of(2) { 1.0 } else { -0.7 };
        (Some(0.8), [6.0 * angle.cos(), 6.0 * angle.sin(), height])
    };
    Setup {
        bodies: std::iter::once((None, [0.0; 3]))
            .chain((0..arms).map(sphere))
            .collect(),
        joints: (1..=arms).map(|body| (body, 0)).collect(),
        size: Some(1.0),
        ..Setup::bent_chain()
    }
}

/// A cube of spheres, each linked to the next one along a path: a long chain of dependent bodies.
fn snake(edge: usize) -> Setup {
    let sphere = |n: usize| {
        let [k, j, i] = [n / edge / edge, n / edge % edge, n % edge];
        // The path goes back and forth, so that successive spheres are neighbours.
        let j = if k % 2 == 0 { j } else { edge - 1 - j };
        let i = if (j + k) % 2 == 0 { i } else { edge - 1 - i };
        let place = [i, j, k].map(|n| 4.0 * n as f64 - 2.0 * (edge - 1) as f64);
        (Some(0.8), place)
    };
    let bodies: Vec<_> = (0..edge.pow(3)).map(sphere).collect();
    Setup {
        joints: (1..bodies.len()).map(|n| (n, n - 1)).collect(),
        bodies,
        size: Some(1.1),
        ..Setup::with(&["gait.arms=clamped"])
    }
}

/// Different radii, narrow gaps and the wall.
fn gaps() -> Vec<StressCase> {
    let pair = |gap: f64| {
        let left = (1.0, [-1.0 - gap / 2.0, 0.0, 0.0]);
        let right = (1.0, [1.0 + gap / 2.0, 0.3, 0.0]);
        Setup::linkage([left, right], &[(0, 1)], Some((0, 0.5)))
    };
    let at_wall = |x: f64| {
        let mut setup = Setup::bent_chain();
        setup.bodies[0].1 = [x, 0.0, 0.0];
        setup.bodies[1].1 = [-6.0, 0.0, 0.0];
        setup.bodies[2].1 = [-5.0, 4.0, 0.5];
        setup
    };
    let radii = [
        (0.3, [-5.5, 0.0, 0.0]),
        (3.0, [0.0; 3]),
        (0.5, [1.0, 6.0, 0.5]),
    ];
    let unequal = Setup {
        size: None,
        keys: vec!["fem.size_factor=2"],
        ..Setup::linkage(radii, &[(0, 1), (2, 1)], Some((0, -0.5)))
    };
    let mut point = Setup::one([0.0; 3], &[]);
    point.bodies.push((None, [3.0, 0.0, 0.0]));
    vec![
        case("radii 1 to 10", unequal),
        case("gap of 0.5 radii", pair(0.5)),
        case("gap of 0.1 radii", pair(0.1)),
        case("gap of 0.03 radii", pair(0.03)),
        refused("spheres in contact", pair(-0.05), "overlap"),
        case("close to the wall", at_wall(-10.5)),
        refused("through the wall", at_wall(-11.5), "wall"),
        refused("a point without links", point, "point"),
    ]
}

/// Containers, values of keys and elements.
fn surroundings() -> Vec<StressCase> {
    let narrow = ["domain.radius=1.5", "bodies.b0.force=[1, 1, 0]"];
    let with = |key| Setup::with(&[key]);
    let a_box = "domain={ kind = \"box\", size = [24, 20, 16] }";
    let positive = "fluid.viscosity must be";
    let fine = Setup {
        size: Some(0.5),
        ..Setup::bent_chain()
    };
    vec![
        case("a ball of 1.5 radii", Setup::one([0.1, 0.0, 0.0], &narrow)),
        case("a ball of 500 radii", with("domain.radius=500")),
        case("a box", with(a_box)),
        case("nothing moves", Setup::one([3.0, 1.0, 0.0], &[])),
        case("no container", with("domain={ kind = \"unbounded\" }")),
        refused("a viscosity of zero", with("fluid.viscosity=0"), positive),
        refused(
            "a viscosity that is NaN",
            with("fluid.viscosity=nan"),
            positive,
        ),
        case("straight elements", with("fem.geometry=straight")),
        case("elements of half the radius", fine),
    ]
}
