//! What is made hard, and what must come of it.

use super::map::Outcome;
use super::setup::Setup;

/// What every cell of a hardship must come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// The right answer.
    Right,
    /// An error whose message holds this.
    Refused(&'static str),
}

impl Expected {
    /// Whether an outcome is this.
    pub fn is_met(self, outcome: &Outcome) -> bool {
        match (outcome, self) {
            (Outcome::Right { .. }, Self::Right) => true,
            (Outcome::Refused(message), Self::Refused(part)) => message.contains(part),
            _ => false,
        }
    }
}

/// What an answer is right against.
#[derive(Clone, Debug)]
pub enum Truth {
    /// P-tilde with the direct solver on the same scene.
    Direct,
    /// The same of another scene, its velocities times a factor: Stokes flow knows no units.
    Similar(Box<Setup>, f64),
}

/// One hardship.
#[derive(Clone, Debug)]
pub struct Hardship {
    pub name: &'static str,
    pub setup: Setup,
    pub truth: Truth,
    pub expected: Expected,
    /// Whether the tests run it.
    pub quick: bool,
}

impl Hardship {
    /// Larger elements, for the part that the tests run.
    pub fn coarsen(&mut self, size: f64) {
        self.setup.size = Some(size);
        if let Truth::Similar(setup, _) = &mut self.truth {
            setup.size = Some(size);
        }
    }
}

/// Micrometres for metres, nearly: by a power of two everything is rounded alike and the mesh is the same. By 1e-6 the mesh is
/// another one, and velocities differ by the error of so coarse a mesh.
const MICRO: f64 = 1.0 / 1_048_576.0;

/// A star: `arms` spheres around a point, alternately on both sides of a plane so that nothing is symmetric.
fn star(arms: usize) -> Setup {
    let mut bodies = vec![(None, [0.0; 3])];
    let mut links = Vec::new();
    for number in 0..arms {
        let angle = std::f64::consts::TAU * number as f64 / arms as f64;
        let height = if number % 2 == 0 { 1.0 } else { -0.7 };
        bodies.push((Some(0.8), [6.0 * angle.cos(), 6.0 * angle.sin(), height]));
        links.push((number + 1, 0));
    }
    Setup {
        bodies,
        links,
        size: Some(1.0),
        ..Setup::bent_chain()
    }
}

/// A cube of spheres, each linked to its neighbour along a path: a chain in which everything is a slave of a slave.
fn snake(edge: usize) -> Setup {
    let mut bodies = Vec::new();
    for k in 0..edge {
        for j in 0..edge {
            for i in 0..edge {
                // Back and forth, so that neighbours in the list are neighbours in space.
                let j = if k % 2 == 0 { j } else { edge - 1 - j };
                let i = if (j + k) % 2 == 0 { i } else { edge - 1 - i };
                bodies.push((
                    Some(0.8),
                    [i, j, k].map(|n| 4.0 * n as f64 - 2.0 * (edge - 1) as f64),
                ));
            }
        }
    }
    let links = (1..bodies.len()).map(|n| (n, n - 1)).collect();
    Setup {
        bodies,
        links,
        size: Some(1.1),
        arms: "clamped",
        ..Setup::bent_chain()
    }
}

/// All hardships, from the plain scene on.
pub fn all() -> Vec<Hardship> {
    let plain = Setup::bent_chain();
    let hardship = |name, setup: Setup, quick| Hardship {
        name,
        setup,
        truth: Truth::Direct,
        expected: Expected::Right,
        quick,
    };
    let similar = |name, setup: Setup, factor, quick| Hardship {
        truth: Truth::Similar(Box::new(plain.clone()), factor),
        ..hardship(name, setup, quick)
    };
    let refused = |name, setup: Setup, message| Hardship {
        expected: Expected::Refused(message),
        ..hardship(name, setup, true)
    };
    let viscosity = |viscosity| Setup {
        viscosity,
        ..plain.clone()
    };
    let alone = |position, force| Setup {
        bodies: vec![(Some(1.0), position)],
        links: Vec::new(),
        change: None,
        pull: Some((0, force)),
        ..plain.clone()
    };
    let triangle = Setup {
        links: vec![(0, 1), (2, 1), (2, 0)],
        change: None,
        pull: Some((0, [0.0, 1.0, 0.0])),
        ..plain.clone()
    };
    let pair = |gap: f64| Setup {
        bodies: vec![
            (Some(1.0), [-1.0 - gap / 2.0, 0.0, 0.0]),
            (Some(1.0), [1.0 + gap / 2.0, 0.3, 0.0]),
        ],
        links: vec![(0, 1)],
        change: Some((0, 0.5)),
        ..plain.clone()
    };
    vec![
        hardship("bent chain of three", plain.clone(), false),
        similar("viscosity 1e-9", viscosity(1e-9), 1.0, true),
        similar("viscosity 1e9", viscosity(1e9), 1.0, false),
        similar(
            "lengths times 2^-20",
            plain.clone().scaled(MICRO),
            MICRO,
            false,
        ),
        similar(
            "viscosity 1e-9 and lengths times 2^20",
            Setup {
                viscosity: 1e-9,
                ..plain.clone().scaled(1.0 / MICRO)
            },
            1.0 / MICRO,
            false,
        ),
        hardship("lengths times 1e-6", plain.clone().scaled(1e-6), false),
        hardship(
            "arms clamped",
            Setup {
                arms: "clamped",
                ..plain.clone()
            },
            false,
        ),
        hardship(
            "arms lab",
            Setup {
                arms: "lab",
                ..plain.clone()
            },
            false,
        ),
        hardship(
            "one body, pulled",
            alone([3.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
            false,
        ),
        hardship(
            "pulled and swimming",
            Setup {
                pull: Some((2, [0.0, 0.0, 5.0])),
                ..plain.clone()
            },
            false,
        ),
        hardship(
            "slave of a slave, numbered backwards",
            Setup {
                bodies: vec![
                    (Some(0.8), [6.0, 3.0, 0.0]),
                    (Some(1.0), [3.0, 0.0, 0.0]),
                    (Some(1.3), [-0.5, 0.5, 0.0]),
                    (Some(1.0), [-4.0, -1.0, 1.0]),
                ],
                links: vec![(0, 1), (1, 2), (2, 3)],
                change: Some((1, -0.5)),
                ..plain.clone()
            },
            true,
        ),
        hardship("closed loop, redundant", triangle.clone(), true),
        refused(
            "closed loop, contradictory",
            Setup {
                change: Some((0, -0.5)),
                ..triangle
            },
            "loop",
        ),
        hardship(
            "two swimmers",
            Setup {
                bodies: vec![
                    (Some(1.0), [-5.0, 3.0, 0.0]),
                    (Some(1.0), [-1.0, 3.0, 1.0]),
                    (Some(0.8), [0.0, -3.0, 0.0]),
                    (Some(1.2), [4.0, -3.5, 0.0]),
                ],
                links: vec![(0, 1), (2, 3)],
                ..plain.clone()
            },
            false,
        ),
        hardship("star of three around a point", star(3), false),
        hardship("star of ten around a point", star(10), false),
        hardship("snake of 27", snake(3), false),
        hardship(
            "radii 1 to 10",
            Setup {
                bodies: vec![
                    (Some(0.3), [-5.5, 0.0, 0.0]),
                    (Some(3.0), [0.0, 0.0, 0.0]),
                    (Some(0.5), [1.0, 6.0, 0.5]),
                ],
                size: None,
                more: "fem.size_factor = 2".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        hardship("gap of 0.5 radii", pair(0.5), false),
        hardship("gap of 0.1 radii", pair(0.1), false),
        hardship("gap of 0.03 radii", pair(0.03), false),
        refused("spheres in contact", pair(-0.05), "overlap"),
        hardship(
            "close to the wall",
            Setup {
                bodies: vec![
                    (Some(1.0), [-10.5, 0.0, 0.0]),
                    (Some(1.3), [-6.0, 0.0, 0.0]),
                    (Some(0.8), [-5.0, 4.0, 0.5]),
                ],
                ..plain.clone()
            },
            false,
        ),
        refused(
            "through the wall",
            Setup {
                bodies: vec![
                    (Some(1.0), [-11.5, 0.0, 0.0]),
                    (Some(1.3), [-6.0, 0.0, 0.0]),
                    (Some(0.8), [-5.0, 4.0, 0.5]),
                ],
                ..plain.clone()
            },
            "wall",
        ),
        refused(
            "a point that nothing holds",
            Setup {
                bodies: vec![(Some(1.0), [0.0; 3]), (None, [3.0, 0.0, 0.0])],
                links: Vec::new(),
                change: None,
                ..plain.clone()
            },
            "point",
        ),
        hardship(
            "a ball of 1.5 radii",
            Setup {
                domain: "{ kind = \"ball\", radius = 1.5 }".to_owned(),
                ..alone([0.1, 0.0, 0.0], [1.0, 1.0, 0.0])
            },
            false,
        ),
        hardship(
            "a ball of 500 radii",
            Setup {
                domain: "{ kind = \"ball\", radius = 500 }".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        hardship(
            "a box",
            Setup {
                domain: "{ kind = \"box\", size = [24, 20, 16] }".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        hardship("nothing moves", alone([3.0, 1.0, 0.0], [0.0; 3]), false),
        hardship(
            "no container",
            Setup {
                domain: "{ kind = \"unbounded\" }".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        refused(
            "a viscosity of nothing",
            viscosity(0.0),
            "fluid.viscosity must be",
        ),
        refused("a viscosity that is NaN", viscosity(f64::NAN), "float"),
        hardship(
            "straight elements",
            Setup {
                more: "fem.geometry = \"straight\"".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        hardship(
            "elements of half the radius",
            Setup {
                size: Some(0.5),
                ..plain.clone()
            },
            false,
        ),
    ]
}
