//! Runs with joints, springs, loops, corners, masses and contacts: displacements, or rotations
//! where nothing else moves, must be within their bars.

use std::f64::consts::{PI, TAU};

use anyhow::{Context, Result};
use nalgebra::Vector3;
use swimmer::{Method, Outcome as Swum, Scene, SwimError, choose, simulate};

use super::map::{Cell, Expected, Map, Outcome, Store};
use crate::scenes::SceneText;

/// Tolerances of the runs.
const TOLERANCES: [f64; 2] = [1e-2, 1e-4];

/// Tolerance of the run that a case without an exact value is compared with.
const REFERENCE_TOLERANCE: f64 = 1e-7;

/// Displacements or a rotation, and their error bar.
type Measured = (Vec<Vector3<f64>>, f64);

/// A scene without its tolerance.
#[derive(Clone)]
struct Case {
    name: String,
    text: SceneText,
    /// Exact displacement of the first body, or the rotation; `None` for that of a run to
    /// [`REFERENCE_TOLERANCE`].
    exact: Option<Vector3<f64>>,
    /// Whether the rotation is compared instead of displacements.
    turns: bool,
    /// Outcome that every tolerance must have.
    expected: Expected,
    quick: bool,
}

impl Case {
    fn new(name: impl Into<String>, text: SceneText) -> Self {
        Self {
            name: name.into(),
            text,
            exact: None,
            turns: false,
            expected: Expected::Right,
            quick: false,
        }
    }

    /// What is compared, and its error bar without that of the model, which is the same in all
    /// runs.
    fn measured(&self, swum: &Swum) -> Measured {
        let (vectors, bars) = match self.turns {
            true => (vec![swum.rotation], &swum.rotation_error),
            false => (swum.displacement.clone(), &swum.error_estimate),
        };
        (vectors, bars.integration.unwrap_or(f64::INFINITY))
    }

    fn scene(&self, tolerance: f64) -> Result<Scene, SwimError> {
        // A model of constant cost: the cases are hard for the integration.
        // The run to compare with has a bar of its own, whatever it reaches.
        let accept = if tolerance == REFERENCE_TOLERANCE {
            "best"
        } else {
            "tolerance"
        };
        let model =
            format!("[model]\nkind = \"rpy\"\ntolerance = {tolerance:e}\naccept = \"{accept}\"\n");
        Ok(Scene::parse(&(model + &self.text.0))?)
    }
}

/// Three unit spheres on a line at this distance, without joints.
fn row_of_spheres(distance: f64, keys: &str) -> SceneText {
    let places = [("l", -distance), ("c", 0.0), ("r", distance)].into_iter();
    places.fold(SceneText::default(), |text, (name, x)| {
        text.sphere(name, 1.0, [x, 0.0, 0.0]).line(keys)
    })
}

/// Three spheres on a line with these keys of the bodies and of the right joint.
fn chain(body: &str, right: &str) -> SceneText {
    let text = row_of_spheres(5.0, body).joint("left", "l", "c");
    text.joint("right", "r", "c").line(right)
}

/// Adds phases with these targets of both joints, at unequal rates.
fn with_phases(text: SceneText, targets: &[[f64; 2]]) -> SceneText {
    let targets = targets.iter().enumerate();
    targets.fold(text, |text, (number, [left, right])| {
        let targets = format!("{{ left = {left:?}, right = {right:?} }}");
        text.line(format_args!("[[gait.phases]]\ntargets = {targets}"))
            .key("duration", 1.0 + 0.3 * (number % 3) as f64)
    })
}

/// Keys of a hinge about the z axis.
fn hinge(x: f64, y: f64) -> String {
    format!("joint = \"hinge\"\naxis = [0, 0, 1]\npivot = [{x:?}, {y:?}, 0]")
}

/// Three spheres with hinges halfway between them, which bend until a gap is this wide.
fn hinges(gap: f64) -> Case {
    // The distance of the centres is 3 cos(angle / 2).
    let angle = 2.0 * ((2.0 + gap) / 3.0).acos();
    let text = row_of_spheres(3.0, "")
        .joint("left", "l", "c")
        .line(hinge(-1.5, 0.0));
    let text = text.joint("right", "r", "c").line(hinge(1.5, 0.0));
    let targets = [[angle, 0.0], [angle, angle], [0.0, angle], [0.0, 0.0]];
    Case {
        expected: Expected::NotWrong,
        ..Case::new(
            format!("hinges bend to a gap of {gap:?}"),
            with_phases(text, &targets),
        )
    }
}

/// Adds a harmonic motion of a joint.
fn with_harmonic(
    text: SceneText,
    joint: &str,
    amplitude: f64,
    phase: f64,
    order: usize,
) -> SceneText {
    let text = text.line("[[gait.harmonics]]").key("link", joint);
    text.key("amplitude", amplitude)
        .key("phase", phase)
        .key("order", order)
}

/// One arm oscillates and the other one is a spring.
fn spring(stiffness: f64) -> Case {
    let drive = format!("drive = \"spring\"\nstiffness = {stiffness:e}");
    let text = chain("", &drive).line("[gait]\nperiod = 6");
    Case {
        // The displacement falls as the inverse of the stiffness, and the tolerance with it.
        expected: match stiffness < 1e6 {
            true => Expected::Right,
            false => Expected::NotWrong,
        },
        quick: stiffness == 1.0,
        ..Case::new(
            format!("a spring of stiffness {stiffness:e}"),
            with_harmonic(text, "left", 1.0, 0.0, 1),
        )
    }
}

/// Both arms move along polygons with this number of corners.
fn corners(count: usize) -> Case {
    let corner = |k: usize| {
        let angle = TAU * k as f64 / count as f64;
        [5.0 - 1.2 * (1.0 - angle.cos()), 5.0 - 1.5 * angle.sin()]
    };
    let targets: Vec<[f64; 2]> = (1..=count).map(corner).collect();
    let text = with_phases(chain("", ""), &targets);
    Case::new(format!("a gait with {count} corners"), text)
}

/// Both arms oscillate, the right one also with a multiple of the frequency.
fn overtones(order: usize) -> Case {
    let text = chain("", "").line("[gait]\nperiod = 2");
    let text = with_harmonic(text, "left", 1.0, 0.0, 1);
    let text = with_harmonic(text, "right", 1.0, 1.2, 1);
    let text = with_harmonic(text, "right", 0.3, 0.4, order);
    Case::new(format!("smooth gait with the harmonic {order}"), text)
}

/// A sphere of this mass that is pulled: `m dU/dt = F - R U` from rest.
fn pulled(mass: f64) -> Case {
    let (drag, time) = (6.0 * PI, 2.0);
    let text = SceneText::new("[[gait.phases]]").key("duration", time);
    let text = text.sphere("s", 1.0, [0.0; 3]).line("force = [0, 3, 0]");
    let relaxation = mass / drag;
    let moved = time + relaxation * (-time / relaxation).exp_m1();
    // For heavy bodies the difference cancels: F t^2 / (2 m) with the next two terms.
    let ratio = time / relaxation;
    let moved = match ratio < 1e-3 {
        true => relaxation * ratio * ratio * (0.5 - ratio / 6.0 + ratio * ratio / 24.0),
        false => moved,
    };
    Case {
        exact: Some(Vector3::new(0.0, 3.0 / drag * moved, 0.0)),
        quick: mass == 1.0,
        ..Case::new(
            format!("a pulled sphere of mass {mass:e}"),
            text.line(format_args!("mass = {mass:e}")),
        )
    }
}

/// A stroke of three spheres of these masses.
fn massive(mass: f64) -> Case {
    let text = chain(&format!("mass = {mass:e}"), "");
    let stroke = [[3.5, 5.0], [3.5, 3.5], [5.0, 3.5], [5.0, 5.0]];
    let name = format!("a stroke of spheres of mass {mass:e}");
    Case::new(name, with_phases(text, &stroke))
}

/// A rhombus of four bars with hinges at its corners, of which `free` are not prescribed.
fn rhombus(name: &str, free: usize, gait: &str, expected: Expected) -> Case {
    let corners = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]];
    let mut text = SceneText::default();
    for k in 0..4 {
        let [a, b] = [corners[k], corners[(k + 1) % 4]];
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.0];
        text = text.sphere(format_args!("b{k}"), 1.0, middle);
    }
    for k in 0..4 {
        let next = (k + 1) % 4;
        let [x, y] = corners[next];
        let [name, body] = [format!("h{k}"), format!("b{next}")];
        text = text
            .joint(name, body, format_args!("b{k}"))
            .line(hinge(x, y));
        if k >= 4 - free {
            text = text.key("drive", "free");
        }
    }
    Case {
        expected,
        quick: true,
        ..Case::new(name, text.line(gait))
    }
}

/// A sphere that a torque turns by `T t / (8 pi)`, more than once around.
fn turned() -> Case {
    let (torque, time) = (10.0, 20.0);
    let text = SceneText::new("[[gait.phases]]").key("duration", time);
    let text = text.sphere("s", 1.0, [0.0; 3]);
    Case {
        exact: Some(Vector3::new(0.0, 0.0, torque * time / (8.0 * PI))),
        turns: true,
        quick: true,
        ..Case::new(
            "rotation only: a torque on a sphere",
            text.key("torque", [0.0, 0.0, torque]),
        )
    }
}

/// Two coaxial spheres that a motor turns relative to each other.
fn motor() -> Case {
    let text = SceneText::default().spheres_on_axis(&[1.0, 0.7], [0.0, 3.0]);
    let text = text.joint("motor", "s1", "s0").key("joint", "rotor");
    Case {
        turns: true,
        quick: true,
        ..Case::new(
            "rotation only: a motor between coaxial spheres",
            text.phase("motor", 8.0),
        )
    }
}

/// Spheres with mass that a stiff spring draws together, or through each other in one step.
fn overshoot(stiffness: f64) -> Case {
    let text = SceneText::new("[[gait.phases]]").key("duration", 4.0);
    let text = [("a", 0.0), ("b", 10.0)]
        .into_iter()
        .fold(text, |text, (name, x)| {
            text.sphere(name, 1.0, [x, 0.0, 0.0])
                .line("mass = 1\ninertia = 0.4")
        });
    let text = text.joint("spring", "b", "a").key("drive", "spring");
    Case {
        quick: stiffness > 100.0,
        ..Case::new(
            format!("overshoot: masses on a spring of stiffness {stiffness:?} from 10 to 4"),
            text.key("stiffness", stiffness).key("rest", 4.0),
        )
    }
}

/// A small sphere that is pulled into a fixed one; without lubrication they touch.
fn pulled_into() -> Case {
    let text = SceneText::new("[[gait.phases]]").key("duration", 4.0);
    let text = text
        .sphere("small", 0.01, [0.0; 3])
        .key("force", [1.0, 0.0, 0.0]);
    Case {
        expected: Expected::Refused("touch"),
        quick: true,
        ..Case::new(
            "contact along the path: a sphere pulled into a fixed one",
            text.sphere("fixed", 0.01, [10.37, 0.0, 0.0])
                .key("fixed", true),
        )
    }
}

/// A sphere on a hinge that sweeps past a post, at this gap; negative if it would pass through it.
fn sweep(gap: f64) -> Case {
    let text = SceneText::default()
        .sphere("base", 0.5, [0.0; 3])
        .sphere("sphere", 0.2, [4.0, 0.0, 0.0])
        .sphere("post", 0.3, [0.0, 4.0 + 0.5 + gap, 0.0])
        .joint("hinge", "sphere", "base")
        .line(hinge(0.0, 0.0))
        .joint("arm", "post", "base")
        .key("joint", "fixed")
        .phase("hinge", 2.0);
    let expected = match gap > 0.0 {
        true => Expected::Right,
        false => Expected::Refused("touch"),
    };
    Case {
        expected,
        quick: true,
        ..Case::new(
            format!("contact along the path: a hinge sweeps past a post, gap {gap:?}"),
            text,
        )
    }
}

fn cases() -> Vec<Case> {
    let contradictory = "[[gait.phases]]\ntargets = { h0 = 0.3, h1 = 0.2 }";
    let free = "[[gait.phases]]\ntargets = { h0 = 0.3 }\n[[gait.phases]]\ntargets = { h0 = -0.2 }";
    let refused = Expected::Refused("loop");
    let loops = [
        (
            "a loop of hinges with contradictory angles",
            0,
            contradictory,
            refused,
        ),
        ("the same with one free hinge", 1, contradictory, refused),
        ("the same with three free hinges", 3, free, Expected::Right),
    ];
    let mut cases = [1e-6, 1e-3, 1.0, 1e3, 1e6].map(spring).to_vec();
    cases.extend(loops.map(|(name, free, gait, expected)| rhombus(name, free, gait, expected)));
    cases.extend([5, 24].map(corners));
    cases.extend([3, 12].map(overtones));
    cases.extend([1e-8, 1e-4, 1.0, 1e4].map(pulled));
    cases.extend([1e-8, 1e-2, 1.0, 1e2, 1e4].map(massive));
    cases.extend([0.5, 0.1].map(hinges));
    cases.extend([turned(), motor()]);
    cases.extend([20.0, 200.0].map(overshoot));
    cases.push(pulled_into());
    cases.extend([0.1, -0.1, -0.4].map(sweep));
    cases
}

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    let mut map = Map {
        key: "drives",
        title: "Joints, drives, masses and contacts",
        note: "Runs with Rotne-Prager-Yamakawa hydrodynamics, by tolerance: the largest error of a displacement against an exact value or a run to 1e-7, and the \
               error bar of the integration, both in radii; in radians where only rotations are. WRONG means an error of more than twice the bar.",
        columns: TOLERANCES.map(|t| format!("tolerance {t:e}")).to_vec(),
        ..Map::default()
    };
    for case in cases().iter().filter(|case| !quick || case.quick) {
        map.add(store, &case.name, || cells(case))?;
    }
    Ok(map)
}

fn cells(case: &Case) -> Result<Vec<Cell>> {
    let truth = match (case.expected, case.exact) {
        (Expected::Refused(_), _) => None,
        (_, Some(exact)) => Some((vec![exact], 0.0)),
        (_, None) => {
            let truth =
                run(&case.scene(REFERENCE_TOLERANCE)?).with_context(|| case.name.clone())?;
            Some(case.measured(&truth))
        }
    };
    let compare = |swum: Swum| match &truth {
        None => Outcome::wrong(f64::NAN),
        Some(exact) => compare(case.measured(&swum), exact),
    };
    let cell = |tolerance| Cell::new(case.expected, || run(&case.scene(tolerance)?), compare);
    Ok(TOLERANCES.map(cell).to_vec())
}

fn run(scene: &Scene) -> Result<Swum, SwimError> {
    let mut model = choose(scene)?.model;
    simulate(scene, model.as_mut(), Method::from_scene(scene), &mut ())
}

fn compare((found, bar): Measured, (exact, exact_bar): &Measured) -> Outcome {
    let pairs = found.iter().zip(exact);
    let error = pairs.map(|(a, b)| (a - b).norm()).fold(0.0_f64, f64::max);
    let mark = format!("{error:.0e}, {bar:.0e}");
    Outcome::against_bar(error, bar + exact_bar, 1e-12, mark)
}
