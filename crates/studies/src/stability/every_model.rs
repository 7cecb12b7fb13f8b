//! One instantaneous solution by every model: its error must be within its error bar.

use anyhow::{Context, Result};
use nalgebra::Vector3;
use swimmer::models::{AxisymmetricModel, InstantaneousSolution, SphereModel, SpheresModel};
use swimmer::{Scene, SwimError, solve_start};

use super::map::{Cell, Expected, Map, Outcome, Store};
use crate::scenes::{SceneText, solve};

const MODELS: [&str; 5] = ["oseen", "rpy", "multipole", "axisymmetric", "fem"];

/// Relative error of the reference expansion.
const REFERENCE_TOLERANCE: f64 = 1e-9;

/// Tolerance of the meridian plane where it is the reference.
const MERIDIAN_TOLERANCE: f64 = 1e-8;

/// Element size for finite elements, over the smallest radius.
const SIZE: f64 = 0.8;

/// A sphere: radius, position and force.
type Pulled = (f64, [f64; 3], [f64; 3]);

/// Spheres in a domain, with forces.
struct Setting {
    name: &'static str,
    /// The `domain` table, and further keys of the scene.
    keys: String,
    spheres: Vec<Pulled>,
    /// Torque on the last sphere.
    torque: [f64; 3],
    /// Modes of the slip of all spheres, along the x axis on which they are; the reference is then
    /// the meridian plane, because expansions are hard there.
    slip: Option<[f64; 2]>,
    /// Outcome that every model must have.
    expected: Expected,
    quick: bool,
}

impl Setting {
    fn new(name: &'static str, domain: &str, spheres: impl Into<Vec<Pulled>>) -> Self {
        Self {
            name,
            keys: format!("domain = {domain}\n"),
            spheres: spheres.into(),
            torque: NONE,
            slip: None,
            expected: Expected::NotWrong,
            quick: false,
        }
    }

    fn with(self, key: &str) -> Self {
        let keys = self.keys + key;
        Self { keys, ..self }
    }

    fn scene(&self, model: &str) -> Result<Scene, SwimError> {
        let radii = self.spheres.iter().map(|sphere| sphere.0);
        let size = SIZE * radii.fold(f64::INFINITY, f64::min);
        let mut text = SceneText::new(&self.keys)
            .key("model.kind", model)
            .line(format_args!("fem.surface_size = {size:e}"));
        for (number, &(radius, position, force)) in self.spheres.iter().enumerate() {
            text = text.sphere(format!("b{number}"), radius, position);
            text = text.key("force", force);
            if let Some([b1, b2]) = self.slip {
                text = text.line(format_args!("slip = {{ b1 = {b1:?}, b2 = {b2:?} }}"));
            }
        }
        Ok(Scene::parse(&text.key("torque", self.torque).0)?)
    }
}

const NONE: [f64; 3] = [0.0; 3];
/// Shear in a plane that contains no coordinate axis.
const SHEAR: &str = "background = { kind = \"shear\", \
     gradient = [[0.0, 0.5, 0.2], [0.0, 0.0, 0.3], [0.0, 0.0, 0.0]] }";
const UNBOUNDED: &str = "{ kind = \"unbounded\" }";
const WALL: &str = "{ kind = \"wall\" }";
const BALL: &str = "{ kind = \"ball\", radius = 12 }";
const SMALL_BALL: &str = "{ kind = \"ball\", radius = 1.5 }";
const LARGE_BALL: &str = "{ kind = \"ball\", radius = 500 }";
const MICRO_BALL: &str = "{ kind = \"ball\", radius = 2e-5 }";

/// Two spheres with a gap, one pulled.
fn pair_under(name: &'static str, gap: f64, domain: &'static str, force: [f64; 3]) -> Setting {
    let x = 1.0 + 0.5 * gap;
    let spheres = [(1.0, [-x, 0.0, 0.0], force), (1.0, [x, 0.0, 0.0], NONE)];
    Setting::new(name, domain, spheres)
}

/// Two spheres with a gap, one pulled along and across the line of centres.
fn pair(name: &'static str, gap: f64, domain: &'static str) -> Setting {
    Setting {
        quick: domain == UNBOUNDED && gap > 0.05,
        ..pair_under(name, gap, domain, [10.0, 3.0, 0.0])
    }
}

/// Two spheres with a gap, one pulled along the line of centres.
fn along(name: &'static str, gap: f64, domain: &'static str) -> Setting {
    pair_under(name, gap, domain, [10.0, 0.0, 0.0])
}

/// Two squirmers with a gap on their axis, one pulled along it.
fn squirmers(name: &'static str, gap: f64, domain: &'static str) -> Setting {
    Setting {
        slip: Some([1.0, 1.5]),
        ..along(name, gap, domain)
    }
}

fn one(name: &'static str, domain: &'static str, position: [f64; 3], force: [f64; 3]) -> Setting {
    Setting::new(name, domain, [(1.0, position, force)])
}

/// A cube of 27 spheres four radii apart, alternately pulled.
fn crowd() -> Vec<Pulled> {
    let sphere = |n: i32| {
        let place = [n / 9, n / 3 % 3, n % 3];
        let sign = if place.iter().sum::<i32>() % 2 == 0 {
            1.0
        } else {
            -0.5
        };
        (1.0, place.map(|n| 4.0 * f64::from(n)), [sign, 0.3, 0.0])
    };
    (0..27).map(sphere).collect()
}

fn settings() -> Vec<Setting> {
    let (near_wall, above) = ([10.9, 0.0, 0.0], [0.0, 0.0, 1.1]);
    let clear = "clearance 0.1 from the wall of a ball";
    let off_centre = [3.0, 0.0, 0.0];
    let unequal = [
        (1.0, [0.0; 3], [1.0, 0.0, 0.0]),
        (0.01, [1.2, 0.0, 0.0], NONE),
    ];
    let micrometres = [
        (1e-6, [-2e-6, 0.0, 0.0], [1e-15, 0.0, 0.0]),
        (2e-6, [2e-6, 0.0, 0.0], NONE),
    ];
    let narrow = "pulled along the line of centres, gap 0.02, in a ball";
    let sheared = "shear, clearance 0.1 from the wall of a ball";
    vec![
        pair("two spheres, gap 8", 8.0, UNBOUNDED),
        pair("gap 1", 1.0, UNBOUNDED),
        pair("gap 0.1", 0.1, UNBOUNDED),
        pair("gap 0.02", 0.02, UNBOUNDED),
        pair("gap 0.001", 0.001, UNBOUNDED),
        Setting {
            expected: Expected::Refused("touch"),
            quick: true,
            ..pair("contact", 0.0, UNBOUNDED)
        },
        pair("gap 1 in a ball", 1.0, BALL),
        pair("gap 0.1 in a ball", 0.1, BALL),
        pair("gap 0.02 in a ball", 0.02, BALL),
        squirmers("slip, gap 0.02", 0.02, UNBOUNDED),
        squirmers("slip, gap 0.001", 0.001, UNBOUNDED),
        squirmers("slip, gap 0.02 in a ball", 0.02, BALL),
        along("pulled along the line of centres, gap 0.1", 0.1, UNBOUNDED),
        along(narrow, 0.02, BALL),
        one(
            "clearance 0.1 from a plane wall",
            WALL,
            above,
            [1.0, 0.0, -1.0],
        ),
        one(clear, BALL, near_wall, [1.0, 1.0, 0.0]),
        one(
            "a ball of 1.5 radii",
            SMALL_BALL,
            [0.1, 0.0, 0.0],
            [1.0, 1.0, 0.0],
        ),
        one(
            "a ball of 500 radii",
            LARGE_BALL,
            off_centre,
            [1.0, 0.0, 0.0],
        ),
        Setting {
            torque: [0.0, 0.0, 1.0],
            ..one("torque without force", BALL, off_centre, NONE)
        },
        one("shear in a ball", BALL, [6.0, 3.0, 1.0], NONE).with(SHEAR),
        pair("shear in a ball, gap 0.1", 0.1, BALL).with(SHEAR),
        one(sheared, BALL, near_wall, NONE).with(SHEAR),
        one("nothing moves", BALL, off_centre, NONE),
        Setting::new("radii 1 to 0.01", UNBOUNDED, unequal),
        Setting {
            torque: [0.0, 1e-21, 0.0],
            ..Setting::new("micrometres and viscosity 1e-9", MICRO_BALL, micrometres)
                .with("fluid.viscosity = 1e-9")
        },
        Setting::new("27 spheres", UNBOUNDED, crowd()),
    ]
}

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    // The tests leave out models with a mesh.
    let models = if quick { &MODELS[..3] } else { &MODELS[..] };
    let mut map = Map {
        key: "models",
        title: "Models: every error within its own error bar",
        note: "Velocities against multipole expansions to 1e-9: the true error and, after it, the error bar that the model gives, both relative to the fastest \
               sphere; with slip against the meridian plane to 1e-8. WRONG means an error of more than twice the bar.",
        columns: models.iter().map(|&model| model.to_owned()).collect(),
        ..Map::default()
    };
    for setting in settings().iter().filter(|setting| !quick || setting.quick) {
        map.add(store, setting.name, || cells(setting, models))?;
    }
    Ok(map)
}

fn cells(setting: &Setting, models: &[&str]) -> Result<Vec<Cell>> {
    let truth = match setting.expected {
        Expected::Refused(_) => None,
        _ => Some(truth(setting)?),
    };
    let cell = |model: &&str| {
        let compute = || solve(&setting.scene(model)?);
        Cell::new(setting.expected, compute, |found| {
            compare(&found, truth.as_ref())
        })
    };
    Ok(models.iter().map(cell).collect())
}

/// Most accurate expansion, or with slip the meridian plane.
///
/// Where a gap is too narrow for the tolerance of an expansion, the tolerance is multiplied by a
/// hundred, repeatedly.
fn truth(setting: &Setting) -> Result<InstantaneousSolution> {
    if setting.slip.is_some() {
        let scene = setting.scene("axisymmetric")?;
        let mut model = AxisymmetricModel::new(&scene)?.with_accuracy(MERIDIAN_TOLERANCE);
        return Ok(solve_start(&scene, &mut model)?);
    }
    let scene = setting.scene("multipole")?;
    let mut tolerance = REFERENCE_TOLERANCE;
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

fn compare(found: &InstantaneousSolution, truth: Option<&InstantaneousSolution>) -> Outcome {
    let Some(truth) = truth else {
        return Outcome::wrong(f64::NAN);
    };
    let largest = |norms: &mut dyn Iterator<Item = f64>| norms.fold(0.0_f64, f64::max);
    let pairs = found.bodies.iter().zip(&truth.bodies);
    let miss: Vec<Vector3<f64>> = pairs.map(|(a, b)| a.velocity - b.velocity).collect();
    let error = largest(&mut miss.iter().map(|miss| miss.norm()));
    let speed = largest(&mut truth.bodies.iter().map(|body| body.velocity.norm()));
    let bar = found.error_estimate.total();
    // If all speeds are zero, as for a sphere that only rotates, rounding is relative to its
    // rotation.
    let turning = largest(&mut truth.bodies.iter().map(|body| body.angular_velocity.norm()));
    let mark = match speed > 0.0 {
        true => format!("{:.0e}, {:.0e}", error / speed, bar / speed),
        false => "at rest".to_owned(),
    };
    // The expansions end at their largest order, with a bar of their own close to walls.
    let bar = bar + truth.error_estimate.total();
    Outcome::against_bar(error, bar, 1e-7 * speed.max(turning), mark)
}
