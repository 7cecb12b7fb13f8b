//! Runs with joints, springs, loops, corners and masses: displacements must be within their bars.

use std::f64::consts::{PI, TAU};
use std::time::Instant;

use anyhow::{Context, Result};
use nalgebra::Vector3;
use swimmer::{Method, Outcome as Swum, Scene, SwimError, choose, simulate};

use super::map::{Cell, Map, Outcome};
use super::store::Store;
use super::stress_cases::Expected;

/// Tolerances of the runs.
const TOLERANCES: [f64; 2] = [1e-2, 1e-4];

/// Tolerance of the run that a case without an exact value is compared with.
const TRUTH: f64 = 1e-7;

/// A scene without its tolerance.
struct Case {
    name: String,
    text: String,
    /// Exact displacement of the first body; `None` for that of a run to [`TRUTH`].
    exact: Option<Vector3<f64>>,
    /// Outcome that every tolerance must have; `None` if a solution or a refusal is accepted.
    expected: Option<Expected>,
    quick: bool,
}

impl Case {
    fn new(name: impl Into<String>, text: String) -> Self {
        Self {
            name: name.into(),
            text,
            exact: None,
            expected: Some(Expected::Right),
            quick: false,
        }
    }

    fn scene(&self, tolerance: f64) -> Result<Scene, SwimError> {
        // A model of constant cost: the cases are hard for the integration.
        // The run to compare with has a bar of its own, whatever it reaches.
        let accept = if tolerance == TRUTH {
            "best"
        } else {
            "tolerance"
        };
        let model =
            format!("[model]\nkind = \"rpy\"\ntolerance = {tolerance:e}\naccept = \"{accept}\"\n");
        let text = model + &self.text;
        Ok(Scene::parse(&text)?)
    }
}

fn sphere(name: &str, position: [f64; 3], keys: &str) -> String {
    format!("[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = {position:?}\n{keys}")
}

fn joint(name: &str, body: &str, to: &str, keys: &str) -> String {
    format!("[[links]]\nname = \"{name}\"\nbody = \"{body}\"\nto = \"{to}\"\n{keys}")
}

/// Targets of both joints after each phase.
fn phases(targets: &[[f64; 2]]) -> String {
    let phase = |(number, [left, right]): (usize, &[f64; 2])| {
        // Unequal rates.
        let duration = 1.0 + 0.3 * (number % 3) as f64;
        format!(
            "[[gait.phases]]\ntargets = {{ left = {left:?}, right = {right:?} }}\nduration = {duration:?}\n"
        )
    };
    targets.iter().enumerate().map(phase).collect()
}

/// Three spheres with hinges halfway between them, which bend until a gap is this wide.
fn hinges(gap: f64) -> Case {
    // The distance of the centres is 3 cos(angle / 2).
    let angle = 2.0 * ((2.0 + gap) / 3.0).acos();
    let hinge = |x: f64| format!("joint = \"hinge\"\naxis = [0, 0, 1]\npivot = [{x:?}, 0, 0]\n");
    let text = [
        sphere("l", [-3.0, 0.0, 0.0], ""),
        sphere("c", [0.0; 3], ""),
        sphere("r", [3.0, 0.0, 0.0], ""),
        joint("left", "l", "c", &hinge(-1.5)),
        joint("right", "r", "c", &hinge(1.5)),
        phases(&[[angle, 0.0], [angle, angle], [0.0, angle], [0.0, 0.0]]),
    ];
    Case {
        expected: None,
        ..Case::new(format!("hinges bend to a gap of {gap:?}"), text.concat())
    }
}

/// Three spheres on a line with these keys of the bodies and of the right joint.
fn chain(body: &str, right: &str) -> String {
    [
        sphere("l", [-5.0, 0.0, 0.0], body),
        sphere("c", [0.0; 3], body),
        sphere("r", [5.0, 0.0, 0.0], body),
        joint("left", "l", "c", ""),
        joint("right", "r", "c", right),
    ]
    .concat()
}

/// One arm oscillates and the other one is a spring.
fn spring(stiffness: f64) -> Case {
    let drive = format!("drive = \"spring\"\nstiffness = {stiffness:e}\n");
    let gait =
        "[gait]\nperiod = 6\n[[gait.harmonics]]\nlink = \"left\"\namplitude = 1\n".to_owned();
    Case {
        // The displacement falls as the inverse of the stiffness, and the tolerance with it.
        expected: (stiffness < 1e6).then_some(Expected::Right),
        quick: stiffness == 1.0,
        ..Case::new(
            format!("a spring of stiffness {stiffness:e}"),
            chain("", &drive) + &gait,
        )
    }
}

/// Both arms move along polygons with corners at these points.
fn corners(name: &str, count: usize) -> Case {
    let corner = |k: usize| {
        let angle = TAU * k as f64 / count as f64;
        [5.0 - 1.2 * (1.0 - angle.cos()), 5.0 - 1.5 * angle.sin()]
    };
    let targets: Vec<[f64; 2]> = (1..=count).map(corner).collect();
    Case::new(name, chain("", "") + &phases(&targets))
}

/// Both arms oscillate, the right one also with a multiple of the frequency.
fn overtones(order: usize) -> Case {
    let harmonic = |joint: &str, amplitude: f64, phase: f64, order: usize| {
        format!(
            "[[gait.harmonics]]\nlink = \"{joint}\"\namplitude = {amplitude:?}\nphase = {phase:?}\norder = {order}\n"
        )
    };
    let gait = [
        "[gait]\nperiod = 2\n".to_owned(),
        harmonic("left", 1.0, 0.0, 1),
        harmonic("right", 1.0, 1.2, 1),
        harmonic("right", 0.3, 0.4, order),
    ];
    Case::new(
        format!("smooth gait with the harmonic {order}"),
        chain("", "") + &gait.concat(),
    )
}

/// A sphere of this mass that is pulled: `m dU/dt = F - R U` from rest.
fn pulled(mass: f64) -> Case {
    let (drag, time) = (6.0 * PI, 2.0);
    let text = format!(
        "[[gait.phases]]\nduration = {time:?}\n{}",
        sphere(
            "s",
            [0.0; 3],
            &format!("force = [0, 3, 0]\nmass = {mass:e}\n")
        )
    );
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
        ..Case::new(format!("a pulled sphere of mass {mass:e}"), text)
    }
}

/// A stroke of three spheres of these masses.
fn massive(mass: f64) -> Case {
    let body = format!("mass = {mass:e}\n");
    let stroke = phases(&[[3.5, 5.0], [3.5, 3.5], [5.0, 3.5], [5.0, 5.0]]);
    Case::new(
        format!("a stroke of spheres of mass {mass:e}"),
        chain(&body, "") + &stroke,
    )
}

/// A rhombus of four bars with hinges at its corners, of which `free` are not prescribed.
fn rhombus(name: &str, free: usize, gait: &str, expected: Expected) -> Case {
    let corners = [[-3.0, -3.0], [3.0, -3.0], [3.0, 3.0], [-3.0, 3.0]];
    let mut text = String::new();
    for k in 0..4 {
        let [a, b] = [corners[k], corners[(k + 1) % 4]];
        let middle = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.0];
        text += &sphere(&format!("b{k}"), middle, "");
    }
    for k in 0..4 {
        let [x, y] = corners[(k + 1) % 4];
        let drive = match k >= 4 - free {
            true => "drive = \"free\"\n",
            false => "",
        };
        let keys =
            format!("joint = \"hinge\"\naxis = [0, 0, 1]\npivot = [{x:?}, {y:?}, 0]\n{drive}");
        let (body, to) = (format!("b{}", (k + 1) % 4), format!("b{k}"));
        text += &joint(&format!("h{k}"), &body, &to, &keys);
    }
    Case {
        expected: Some(expected),
        quick: true,
        ..Case::new(name, text + gait)
    }
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    cases.extend([1e-6, 1e-3, 1.0, 1e3, 1e6].map(spring));
    cases.push(rhombus(
        "a loop of hinges with contradictory angles",
        0,
        "[[gait.phases]]\ntargets = { h0 = 0.3, h1 = 0.2 }\n",
        Expected::Refused("loop"),
    ));
    cases.push(rhombus(
        "the same with one free hinge",
        1,
        "[[gait.phases]]\ntargets = { h0 = 0.3, h1 = 0.2 }\n",
        Expected::Refused("loop"),
    ));
    cases.push(rhombus(
        "the same with three free hinges",
        3,
        "[[gait.phases]]\ntargets = { h0 = 0.3 }\n[[gait.phases]]\ntargets = { h0 = -0.2 }\n",
        Expected::Right,
    ));
    cases.push(corners("a gait with 5 corners", 5));
    cases.push(corners("a gait with 24 corners", 24));
    cases.extend([3, 12].map(overtones));
    cases.extend([1e-8, 1e-4, 1.0, 1e4].map(pulled));
    cases.extend([1e-8, 1e-2, 1.0, 1e2, 1e4].map(massive));
    cases.extend([0.5, 0.1].map(hinges));
    cases
}

/// The map.
pub fn map(quick: bool, store: &mut Store) -> Result<Map> {
    let mut rows = Vec::new();
    for case in cases() {
        if !quick || case.quick {
            rows.push(store.row("drives", &case.name, || cells(&case))?);
        }
    }
    Ok(Map {
        key: "drives",
        title: "Joints, drives and masses",
        note: "Runs with Rotne-Prager-Yamakawa hydrodynamics, by tolerance: the largest error of a displacement against an exact value or a run to 1e-7, and the \
               error bar of the integration, both in radii. WRONG means an error of more than twice the bar.",
        columns: TOLERANCES
            .iter()
            .map(|t| format!("tolerance {t:e}"))
            .collect(),
        rows,
    })
}

fn cells(case: &Case) -> Result<Vec<Cell>> {
    let truth = match (case.expected, case.exact) {
        (Some(Expected::Refused(_)), _) => None,
        (_, Some(exact)) => Some((vec![exact], 0.0)),
        (_, None) => {
            let truth = run(&case.scene(TRUTH)?).with_context(|| case.name.clone())?;
            let bar = integration_bar(&truth);
            Some((truth.displacement, bar))
        }
    };
    let cell = |tolerance: f64| {
        let clock = Instant::now();
        let outcome = match case.scene(tolerance).and_then(|scene| run(&scene)) {
            Err(error) => Outcome::Refused(error.to_string()),
            Ok(swum) => match &truth {
                None => Outcome::Wrong { error: f64::NAN },
                Some((exact, bar)) => judge(&swum, exact, *bar),
            },
        };
        Cell {
            as_expected: match case.expected {
                Some(expected) => expected.is_met(&outcome),
                None => !outcome.is_wrong(),
            },
            outcome,
            seconds: clock.elapsed().as_secs_f64(),
        }
    };
    Ok(TOLERANCES.map(cell).to_vec())
}

fn run(scene: &Scene) -> Result<Swum, SwimError> {
    let mut model = choose(scene)?.model;
    simulate(scene, model.as_mut(), Method::of(scene), &mut ())
}

/// The error bar without that of the model, which is the same in all runs.
fn integration_bar(swum: &Swum) -> f64 {
    swum.error_estimate.integration.unwrap_or(f64::INFINITY)
}

fn judge(swum: &Swum, exact: &[Vector3<f64>], truth_bar: f64) -> Outcome {
    let pairs = swum.displacement.iter().zip(exact);
    let error = pairs.map(|(a, b)| (a - b).norm()).fold(0.0_f64, f64::max);
    let bar = integration_bar(swum);
    let mark = format!("{error:.0e}, {bar:.0e}");
    Outcome::against_bar(error, bar + truth_bar, 1e-12, mark)
}
