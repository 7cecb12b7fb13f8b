//! One instantaneous solution by every model: its error must be within its error bar.

use std::fmt::Write;
use std::time::Instant;

use anyhow::{Context, Result};
use nalgebra::Vector3;
use swimmer::choose;
use swimmer::models::{InstantaneousSolution, SphereModel, SpheresModel};
use swimmer::{Scene, SwimError, solve_start};

use super::map::{Cell, Map, Outcome};
use super::store::Store;
use super::stress_cases::Expected;

const MODELS: [&str; 5] = ["oseen", "rpy", "multipole", "axisymmetric", "fem"];

/// Relative error of the reference expansion.
const TRUTH: f64 = 1e-9;

/// Element size for finite elements, over the smallest radius.
const SIZE: f64 = 0.8;

/// Radius, position, force and torque of a sphere.
type Pulled = (f64, [f64; 3], [f64; 3], [f64; 3]);

/// Spheres in a domain, with forces and torques.
struct Setting {
    name: &'static str,
    domain: &'static str,
    /// Rows of the gradient of a shear flow; zero for fluid at rest.
    gradient: [[f64; 3]; 3],
    viscosity: f64,
    spheres: Vec<Pulled>,
    /// Outcome that every model must have; `None` if a solution or a refusal is accepted.
    expected: Option<Expected>,
    quick: bool,
}

impl Setting {
    fn toml(&self, model: &str) -> String {
        let smallest = self
            .spheres
            .iter()
            .map(|s| s.0)
            .fold(f64::INFINITY, f64::min);
        let mut text = format!(
            "fluid.viscosity = {:e}\ndomain = {}\nmodel.kind = \"{model}\"\nfem.surface_size = {:e}\n",
            self.viscosity,
            self.domain,
            SIZE * smallest
        );
        if self.gradient != REST {
            text += &format!(
                "background = {{ kind = \"shear\", gradient = {:?} }}\n",
                self.gradient
            );
        }
        // Writing to a String cannot fail.
        for (number, (radius, position, force, torque)) in self.spheres.iter().enumerate() {
            let _ = writeln!(
                text,
                "[[bodies]]\nname = \"b{number}\"\nradius = {radius:e}\nposition = {position:?}\nforce = {force:?}\ntorque = {torque:?}"
            );
        }
        text
    }
}

const NONE: [f64; 3] = [0.0; 3];
const REST: [[f64; 3]; 3] = [NONE; 3];
/// Shear in a plane that contains no coordinate axis.
const SHEAR: [[f64; 3]; 3] = [[0.0, 0.5, 0.2], [0.0, 0.0, 0.3], NONE];
const FREE: &str = "{ kind = \"unbounded\" }";
const WALL: &str = "{ kind = \"wall\" }";
const BALL: &str = "{ kind = \"ball\", radius = 12 }";

/// Two spheres with a gap, one pulled along and across the line of centres.
fn pair(name: &'static str, gap: f64, domain: &'static str) -> Setting {
    let x = 1.0 + 0.5 * gap;
    Setting {
        name,
        domain,
        gradient: REST,
        viscosity: 1.0,
        spheres: vec![
            (1.0, [-x, 0.0, 0.0], [10.0, 3.0, 0.0], NONE),
            (1.0, [x, 0.0, 0.0], NONE, NONE),
        ],
        expected: None,
        quick: domain == FREE && gap > 0.05,
    }
}

/// Two spheres with a gap, one pulled along the line of centres.
fn along(name: &'static str, gap: f64, domain: &'static str) -> Setting {
    let mut setting = pair(name, gap, domain);
    setting.spheres[0].2 = [10.0, 0.0, 0.0];
    Setting {
        quick: false,
        ..setting
    }
}

fn one(name: &'static str, domain: &'static str, position: [f64; 3], force: [f64; 3]) -> Setting {
    Setting {
        name,
        domain,
        gradient: REST,
        viscosity: 1.0,
        spheres: vec![(1.0, position, force, NONE)],
        expected: None,
        quick: false,
    }
}

/// A block of spheres four radii apart, alternately pulled.
fn crowd(edge: [i32; 3]) -> Vec<Pulled> {
    let mut spheres = Vec::new();
    for i in 0..edge[0] {
        for j in 0..edge[1] {
            for k in 0..edge[2] {
                let sign = if (i + j + k) % 2 == 0 { 1.0 } else { -0.5 };
                let place = [i, j, k].map(|n| 4.0 * f64::from(n));
                spheres.push((1.0, place, [sign, 0.3, 0.0], NONE));
            }
        }
    }
    spheres
}

fn settings() -> Vec<Setting> {
    let refused = Some(Expected::Refused("touch"));
    vec![
        pair("two spheres, gap 8", 8.0, FREE),
        pair("gap 1", 1.0, FREE),
        pair("gap 0.1", 0.1, FREE),
        pair("gap 0.02", 0.02, FREE),
        pair("gap 0.001", 0.001, FREE),
        Setting {
            expected: refused,
            quick: true,
            ..pair("contact", 0.0, FREE)
        },
        pair("gap 1 in a ball", 1.0, BALL),
        pair("gap 0.1 in a ball", 0.1, BALL),
        pair("gap 0.02 in a ball", 0.02, BALL),
        along("pulled along the line of centres, gap 0.1", 0.1, FREE),
        along(
            "pulled along the line of centres, gap 0.02, in a ball",
            0.02,
            BALL,
        ),
        one(
            "clearance 0.1 from a plane wall",
            WALL,
            [0.0, 0.0, 1.1],
            [1.0, 0.0, -1.0],
        ),
        one(
            "clearance 0.1 from the wall of a ball",
            BALL,
            [10.9, 0.0, 0.0],
            [1.0, 1.0, 0.0],
        ),
        one(
            "a ball of 1.5 radii",
            "{ kind = \"ball\", radius = 1.5 }",
            [0.1, 0.0, 0.0],
            [1.0, 1.0, 0.0],
        ),
        one(
            "a ball of 500 radii",
            "{ kind = \"ball\", radius = 500 }",
            [3.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
        ),
        Setting {
            spheres: vec![(1.0, [3.0, 0.0, 0.0], NONE, [0.0, 0.0, 1.0])],
            ..one("torque without force", BALL, [3.0, 0.0, 0.0], NONE)
        },
        Setting {
            gradient: SHEAR,
            ..one("shear in a ball", BALL, [6.0, 3.0, 1.0], NONE)
        },
        Setting {
            gradient: SHEAR,
            ..pair("shear in a ball, gap 0.1", 0.1, BALL)
        },
        Setting {
            gradient: SHEAR,
            ..one(
                "shear, clearance 0.1 from the wall of a ball",
                BALL,
                [10.9, 0.0, 0.0],
                NONE,
            )
        },
        one("nothing moves", BALL, [3.0, 0.0, 0.0], NONE),
        Setting {
            spheres: vec![
                (1.0, [0.0; 3], [1.0, 0.0, 0.0], NONE),
                (0.01, [1.2, 0.0, 0.0], NONE, NONE),
            ],
            ..one("radii 1 to 0.01", FREE, NONE, NONE)
        },
        Setting {
            viscosity: 1e-9,
            spheres: vec![
                (1e-6, [-2e-6, 0.0, 0.0], [1e-15, 0.0, 0.0], NONE),
                (2e-6, [2e-6, 0.0, 0.0], NONE, [0.0, 1e-21, 0.0]),
            ],
            ..one(
                "micrometres and viscosity 1e-9",
                "{ kind = \"ball\", radius = 2e-5 }",
                NONE,
                NONE,
            )
        },
        Setting {
            spheres: crowd([3, 3, 3]),
            ..one("27 spheres", FREE, NONE, NONE)
        },
    ]
}

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    // The tests leave out models with a mesh.
    let models = if quick { &MODELS[..3] } else { &MODELS[..] };
    let mut rows = Vec::new();
    for setting in settings() {
        if !quick || setting.quick {
            rows.push(store.row("models", setting.name, || cells(&setting, models))?);
        }
    }
    Ok(Map {
        key: "models",
        title: "Models: every error within its own error bar",
        note: "Velocities against multipole expansions to 1e-9: the true error and, after it, the error bar that the model gives, both relative to the fastest \
               sphere. WRONG means an error of more than twice the bar.",
        columns: models.iter().map(|&model| model.to_owned()).collect(),
        rows,
    })
}

fn cells(setting: &Setting, models: &[&str]) -> Result<Vec<Cell>> {
    let truth = match setting.expected {
        Some(Expected::Refused(_)) => None,
        _ => Some(truth(setting)?),
    };
    let mut cells = Vec::new();
    for model in models {
        let clock = Instant::now();
        let outcome = match solve(&setting.toml(model)) {
            Err(error) => Outcome::Refused(error.to_string()),
            Ok(instant) => judge(&instant, truth.as_ref()),
        };
        cells.push(Cell {
            as_expected: match setting.expected {
                Some(expected) => expected.is_met(&outcome),
                None => !outcome.is_wrong(),
            },
            outcome,
            seconds: clock.elapsed().as_secs_f64(),
        });
    }
    Ok(cells)
}

fn solve(text: &str) -> Result<InstantaneousSolution, SwimError> {
    let scene = Scene::parse(text)?;
    let mut model = choose(&scene)?.model;
    solve_start(&scene, model.as_mut())
}

/// Most accurate expansion.
///
/// Where a gap is too narrow for the tolerance, the tolerance is multiplied by a hundred,
/// repeatedly.
fn truth(setting: &Setting) -> Result<InstantaneousSolution> {
    let scene = Scene::parse(&setting.toml("multipole"))?;
    let mut tolerance = TRUTH;
    loop {
        let mut model = SpheresModel::new(&scene, SphereModel::Multipole(tolerance))?;
        match solve_start(&scene, &mut model) {
            Ok(instant) => return Ok(instant),
            Err(error) if tolerance > 1e-3 => {
                return Err(error).with_context(|| format!("{} has no reference", setting.name));
            }
            Err(_) => tolerance *= 100.0,
        }
    }
}

fn judge(instant: &InstantaneousSolution, truth: Option<&InstantaneousSolution>) -> Outcome {
    let Some(truth) = truth else {
        return Outcome::Wrong { error: f64::NAN };
    };
    let pairs = instant.bodies.iter().zip(&truth.bodies);
    let error = pairs
        .map(|(found, exact)| (found.velocity - exact.velocity).norm())
        .fold(0.0_f64, f64::max);
    let speeds = truth.bodies.iter().map(|body| body.velocity);
    let speed = speeds
        .map(|v: Vector3<f64>| v.norm())
        .fold(0.0_f64, f64::max);
    let bar = instant.error_estimate.total();
    let of_speed = |value: f64| if speed > 0.0 { value / speed } else { value };
    // If all speeds are zero, as for a sphere that only rotates, rounding is relative to its
    // rotation.
    let turning = truth
        .bodies
        .iter()
        .map(|body| body.angular_velocity.norm())
        .fold(0.0, f64::max);
    let mark = match speed > 0.0 {
        true => format!("{:.0e}, {:.0e}", of_speed(error), of_speed(bar)),
        false => "at rest".to_owned(),
    };
    // The expansions end at their largest order, with a bar of their own close to walls.
    let bar = bar + truth.error_estimate.total();
    Outcome::against_bar(error, bar, 1e-7 * speed.max(turning), mark)
}
