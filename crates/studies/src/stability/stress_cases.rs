//! Stress cases and the outcome that each must have.

use super::map::Outcome;
use super::setup::Setup;

/// Outcome that every cell of a stress case must have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Expected {
    /// The right solution.
    Right,
    /// An error whose message contains this text.
    Refused(&'static str),
}

impl Expected {
    /// Whether an outcome is the expected one.
    pub fn is_met(self, outcome: &Outcome) -> bool {
        match (outcome, self) {
            (Outcome::Right { .. }, Self::Right) => true,
            (Outcome::Refused(message), Self::Refused(part)) => message.contains(part),
            _ => false,
        }
    }
}

/// Reference solution of a stress case.
#[derive(Clone, Debug)]
pub enum Truth {
    /// P-tilde with the direct solver on the same scene.
    Direct,
    /// The same for a similar scene in other units, with velocities multiplied by a factor.
    Similar(Box<Setup>, f64),
}

/// One stress case.
#[derive(Clone, Debug)]
pub struct StressCase {
    pub name: &'static str,
    pub setup: Setup,
    pub truth: Truth,
    pub expected: Expected,
    /// Whether the tests run it.
    pub quick: bool,
}

impl StressCase {
    /// Sets larger elements, for the part that the tests run.
    pub fn coarsen(&mut self, size: f64) {
        self.setup.size = Some(size);
        if let Truth::Similar(setup, _) = &mut self.truth {
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
        size: Some(1.0),
        ..Setup::bent_chain()
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
        size: Some(1.1),
        arms: "clamped",
        ..Setup::bent_chain()
    }
}

/// All stress cases, the plain scene first.
pub fn all() -> Vec<StressCase> {
    let plain = Setup::bent_chain();
    let case = |name, setup: Setup, quick| StressCase {
        name,
        setup,
        truth: Truth::Direct,
        expected: Expected::Right,
        quick,
    };
    let similar = |name, setup: Setup, factor, quick| StressCase {
        truth: Truth::Similar(Box::new(plain.clone()), factor),
        ..case(name, setup, quick)
    };
    let refused = |name, setup: Setup, message| StressCase {
        expected: Expected::Refused(message),
        ..case(name, setup, true)
    };
    let viscosity = |viscosity| Setup {
        viscosity,
        ..plain.clone()
    };
    let alone = |position, force| Setup {
        bodies: vec![(Some(1.0), position)],
        joints: Vec::new(),
        change: None,
        pull: Some((0, force)),
        ..plain.clone()
    };
    let triangle = Setup {
        joints: vec![(0, 1), (2, 1), (2, 0)],
        change: None,
        pull: Some((0, [0.0, 1.0, 0.0])),
        ..plain.clone()
    };
    let pair = |gap: f64| Setup {
        bodies: vec![
            (Some(1.0), [-1.0 - gap / 2.0, 0.0, 0.0]),
            (Some(1.0), [1.0 + gap / 2.0, 0.3, 0.0]),
        ],
        joints: vec![(0, 1)],
        change: Some((0, 0.5)),
        ..plain.clone()
    };
    vec![
        case("bent chain of three", plain.clone(), false),
        similar("viscosity 1e-9", viscosity(1e-9), 1.0, false),
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
        case("lengths times 1e-6", plain.clone().scaled(1e-6), false),
        case(
            "arms clamped",
            Setup {
                arms: "clamped",
                ..plain.clone()
            },
            false,
        ),
        case(
            "arms lab",
            Setup {
                arms: "lab",
                ..plain.clone()
            },
            false,
        ),
        case(
            "one body, pulled",
            alone([3.0, 1.0, 0.0], [1.0, 0.0, 0.0]),
            false,
        ),
        case(
            "pulled and swimming",
            Setup {
                pull: Some((2, [0.0, 0.0, 5.0])),
                ..plain.clone()
            },
            false,
        ),
        case(
            "chain of dependent bodies, numbered backwards",
            Setup {
                bodies: vec![
                    (Some(0.8), [6.0, 3.0, 0.0]),
                    (Some(1.0), [3.0, 0.0, 0.0]),
                    (Some(1.3), [-0.5, 0.5, 0.0]),
                    (Some(1.0), [-4.0, -1.0, 1.0]),
                ],
                joints: vec![(0, 1), (1, 2), (2, 3)],
                change: Some((1, -0.5)),
                ..plain.clone()
            },
            false,
        ),
        case("closed loop, redundant", triangle.clone(), true),
        refused(
            "closed loop, contradictory",
            Setup {
                change: Some((0, -0.5)),
                ..triangle
            },
            "loop",
        ),
        case(
            "two swimmers",
            Setup {
                bodies: vec![
                    (Some(1.0), [-5.0, 3.0, 0.0]),
                    (Some(1.0), [-1.0, 3.0, 1.0]),
                    (Some(0.8), [0.0, -3.0, 0.0]),
                    (Some(1.2), [4.0, -3.5, 0.0]),
                ],
                joints: vec![(0, 1), (2, 3)],
                ..plain.clone()
            },
            false,
        ),
        case("star of three around a point", star(3), false),
        case("star of ten around a point", star(10), false),
        case("snake of 27", snake(3), false),
        case(
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
        case("gap of 0.5 radii", pair(0.5), false),
        case("gap of 0.1 radii", pair(0.1), false),
        case("gap of 0.03 radii", pair(0.03), false),
        refused("spheres in contact", pair(-0.05), "overlap"),
        case(
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
            "a point without links",
            Setup {
                bodies: vec![(Some(1.0), [0.0; 3]), (None, [3.0, 0.0, 0.0])],
                joints: Vec::new(),
                change: None,
                ..plain.clone()
            },
            "point",
        ),
        case(
            "a ball of 1.5 radii",
            Setup {
                domain: "{ kind = \"ball\", radius = 1.5 }".to_owned(),
                ..alone([0.1, 0.0, 0.0], [1.0, 1.0, 0.0])
            },
            false,
        ),
        case(
            "a ball of 500 radii",
            Setup {
                domain: "{ kind = \"ball\", radius = 500 }".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        case(
            "a box",
            Setup {
                domain: "{ kind = \"box\", size = [24, 20, 16] }".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        case("nothing moves", alone([3.0, 1.0, 0.0], [0.0; 3]), false),
        case(
            "no container",
            Setup {
                domain: "{ kind = \"unbounded\" }".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        refused(
            "a viscosity of zero",
            viscosity(0.0),
            "fluid.viscosity must be",
        ),
        refused("a viscosity that is NaN", viscosity(f64::NAN), "float"),
        case(
            "straight elements",
            Setup {
                more: "fem.geometry = \"straight\"".to_owned(),
                ..plain.clone()
            },
            false,
        ),
        case(
            "elements of half the radius",
            Setup {
                size: Some(0.5),
                ..plain.clone()
            },
            false,
        ),
    ]
}
