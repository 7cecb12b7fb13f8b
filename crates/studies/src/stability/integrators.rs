//! Time integration: stability limits with inertia, drift of a reciprocal stroke, error over cost.

use anyhow::Result;
use nalgebra::Vector3;
use swimmer::models::{SphereModel, SpheresModel};
use swimmer::{Method, Outcome as Swum, Scene, SwimError, simulate};

use super::map::{Map, Outcome, Row};
use crate::chart::{LogLog, Series};
use crate::page::Page;
use crate::scenes::SceneText;
use crate::table::{Table, count, exp};

/// Result of a run with one integrator.
pub struct Point {
    pub integrator: &'static str,
    pub choice: String,
    pub tolerance: f64,
    pub solves: usize,
    /// Distance of the middle sphere from its exact position, in radii.
    pub error: f64,
}

/// All measurements of integrators.
pub struct Study {
    /// Stability limits and drifts.
    pub map: Map,
    /// Displacement by a reciprocal stroke, which is exactly zero.
    pub scallop: Vec<Point>,
    /// Error of a stroke with a net displacement and rotation.
    pub stroke: Vec<Point>,
}

/// Mass and moment of inertia of every sphere where inertia must be negligible.
///
/// The relaxation time is 5e-8 of a phase.
const LIGHT: f64 = 1e-6;

/// Three unequal spheres on a bent chain in unbounded fluid.
fn chain(mass: f64, tolerance: f64, phases: &[(&str, f64)]) -> Result<Scene> {
    let model = format!("model = {{ kind = \"rpy\", tolerance = {tolerance:e} }}");
    let inertia = format!("mass = {mass:e}\ninertia = {mass:e}");
    let mut text = SceneText::new(model).key("gait.arms", "clamped");
    for (name, radius, position) in [
        ("a", 1.0, [-5.0, 0.0, 0.0]),
        ("b", 1.3, [0.0, 0.0, 0.0]),
        ("c", 0.8, [2.0, 5.0, 0.5]),
    ] {
        text = text.sphere(name, radius, position).line(&inertia);
    }
    let text = text.joint("left", "a", "b").joint("right", "c", "b");
    text.phases(phases).parse()
}

/// Lengths of the chain's arms at the start.
fn arms() -> [f64; 2] {
    [5.0, Vector3::new(2.0, 5.0, 0.5).norm()]
}

/// One arm closes and opens again.
fn reciprocal() -> [(&'static str, f64); 2] {
    [("left", 3.0), ("left", arms()[0])]
}

/// The four-phase stroke.
fn swimming() -> [(&'static str, f64); 4] {
    [
        ("left", 3.0),
        ("right", 3.0),
        ("left", arms()[0]),
        ("right", arms()[1]),
    ]
}

fn run(scene: &Scene, method: Method) -> Result<Swum, SwimError> {
    // `choose` is not used, since masses concern the integrators only.
    let mut model = SpheresModel::new(scene, SphereModel::Rpy)?;
    simulate(scene, &mut model, method, &mut ())
}

/// Names of the integrators.
const INTEGRATORS: [&str; 4] = [
    "explicit Euler",
    "backward Euler, light bodies",
    "Runge-Kutta 5(4)",
    "Gauss collocation",
];

/// Integrators with their varied parameter: steps per phase, or the tolerance.
fn choices(quick: bool) -> Vec<(&'static str, String, f64, Method)> {
    let [explicit, implicit, adaptive, symmetric] = INTEGRATORS;
    let steps: &[usize] = if quick {
        &[10, 20]
    } else {
        &[5, 10, 20, 40, 80, 160]
    };
    let steps = steps.iter().flat_map(|&steps| {
        let label = format!("{steps} steps per phase");
        let euler = (explicit, label.clone(), 1e-3, Method::Euler { steps });
        [
            euler,
            (implicit, label, 1e-3, Method::BackwardEuler { steps }),
        ]
    });
    let tolerances: &[f64] = match quick {
        true => &[1e-4],
        false => &[1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-8],
    };
    let tolerances = tolerances.iter().flat_map(|&tolerance| {
        let label = format!("tolerance {tolerance:e}");
        let adaptive = (adaptive, label.clone(), tolerance, Method::RungeKutta);
        [adaptive, (symmetric, label, tolerance, Method::Collocation)]
    });
    steps.chain(tolerances).collect()
}

/// Measures everything.
pub fn study(quick: bool) -> Result<Study> {
    let mut scallop = Vec::new();
    let mut stroke = Vec::new();
    let exact = run(&chain(LIGHT, 1e-11, &swimming())?, Method::Collocation)?.displacement[1];
    for (integrator, choice, tolerance, method) in choices(quick) {
        eprintln!("{integrator}, {choice}");
        let point = |phases: &[(&str, f64)], goal: Vector3<f64>| -> Result<Point> {
            let outcome = run(&chain(LIGHT, tolerance, phases)?, method)?;
            Ok(Point {
                integrator,
                choice: choice.clone(),
                tolerance,
                solves: outcome.solves,
                error: (outcome.displacement[1] - goal).norm(),
            })
        };
        scallop.push(point(&reciprocal(), Vector3::zeros())?);
        stroke.push(point(&swimming(), exact)?);
    }
    let mut rows = limits()?;
    rows.extend(drifts(&scallop));
    Ok(Study {
        map: Map {
            key: "integrators",
            title: "Integrators",
            note: "Stability limits with inertia, and displacements by a reciprocal stroke.",
            columns: vec!["outcome".to_owned()],
            rows,
        },
        scallop,
        stroke,
    })
}

/// A sphere with a force, `m dU/dt + R U = F`, whose stability limit is known exactly.
fn pulled(mass: f64, duration: f64) -> Result<Scene> {
    Ok(Scene::parse(&format!(
        "model.kind = \"rpy\"\ngait.phases = [{{ duration = {duration:e} }}]\n[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n\
         force = [1, 0, 0]\nmass = {mass:e}\ninertia = {mass:e}\n"
    ))?)
}

/// Resistances of a sphere to translation and to rotation.
const DRAG: f64 = 6.0 * std::f64::consts::PI;
const TURN: f64 = 8.0 * std::f64::consts::PI;

fn limits() -> Result<Vec<Row>> {
    // The shortest relaxation time is that of the rotation: `1/(8 pi)` for `m = J = 1`.
    let limit = 2.0 / TURN;
    let steps = 100;
    let mut rows = Vec::new();
    for (part, refused) in [(0.99, false), (1.01, true)] {
        let scene = pulled(1.0, part * limit * steps as f64)?;
        let name = format!("explicit Euler with inertia, steps of {part} times 2m/R");
        let method = Method::ExplicitInertia { steps };
        rows.push(speed(name, &scene, method, refused));
    }
    let steps = 20;
    for mass in [1e-12, 1e-3] {
        let scene = pulled(mass, 1.0)?;
        let refused = 0.05 > 2.0 * mass / TURN;
        for (name, method, refused) in [
            ("explicit", Method::ExplicitInertia { steps }, refused),
            ("backward", Method::BackwardEuler { steps }, false),
        ] {
            let name = format!("{name} Euler, mass {mass:e}, 20 steps per phase");
            rows.push(speed(name, &scene, method, refused));
        }
    }
    // A phase lasts a millionth of the relaxation time: momentum is conserved, so the centre of
    // mass stays.
    let [coarse, fine] = [20, 80].map(|steps: usize| -> Result<f64> {
        let scene = chain(1e6, 1e-3, &[("left", 3.0)]);
        let heavy = run(&scene?, Method::BackwardEuler { steps })?;
        Ok(heavy.displacement.iter().sum::<Vector3<f64>>().norm() / 3.0)
    });
    let (coarse, fine) = (coarse?, fine?);
    rows.push(Row::test(
        "backward Euler, mass 1e6: the centre of mass stays",
        format!(
            "moves by {coarse:.0e} radii while the arm closes by 2 in 20 steps, by {fine:.0e} in 80"
        ),
        // Resistance reduces the momentum by `R t / m = 6e-5`; the rest is the error of a
        // first-order method.
        fine < 1.2e-4 + 0.25 * 1.1 * coarse,
    ));
    Ok(rows)
}

/// Runs a pulled sphere and compares its speed at the end with `F/R`.
fn speed(name: String, scene: &Scene, method: Method, refused: bool) -> Row {
    /// Largest relative error of the speed.
    const TOLERANCE: f64 = 1e-6;
    match run(scene, method) {
        Err(error) => {
            let is_unstable = matches!(error, SwimError::Unstable { .. });
            let outcome = Outcome::Refused(error.to_string());
            Row::one(name, outcome, refused && is_unstable)
        }
        Ok(outcome) => {
            let last = outcome.samples.iter().rev().find_map(|s| s.bodies.as_ref());
            let speed = last.map_or(f64::NAN, |bodies| bodies[0].velocity.x);
            let error = (speed * DRAG - 1.0).abs();
            Row::test(name, format!("{error:.0e}"), error < TOLERANCE && !refused)
        }
    }
}

/// Scallop drift of each integrator: displacement by a reciprocal stroke, which is exactly zero.
fn drifts(points: &[Point]) -> Vec<Row> {
    let of = |name: &str| -> Vec<&Point> {
        let points = points.iter().filter(|p| p.integrator == name);
        points.collect()
    };
    let mut rows = Vec::new();
    for name in &INTEGRATORS[..2] {
        if let [.., a, b] = &of(name)[..] {
            let order = (a.error / b.error).log2();
            let (coarse, fine) = (a.solves, b.solves);
            let mark = format!(
                "{:.1e} radii with {coarse} solves, {:.1e} with {fine}: order {order:.2}",
                a.error, b.error
            );
            let is_first = (order - 1.0).abs() < 0.15;
            rows.push(Row::test(
                format!("scallop drift of {name}"),
                mark,
                is_first,
            ));
        }
    }
    // The error of a phase span is its share of the tolerance, 1/160, times two radii; there are
    // two phase spans of a few steps each. Symmetric methods return exactly to the start, up to the
    // tolerance of their iteration.
    for (name, allowed) in INTEGRATORS[2..].iter().zip([0.05, 0.0]) {
        if let Some(point) = of(name).last() {
            let (error, solves, choice) = (point.error, point.solves, &point.choice);
            let mark = format!("{error:.1e} radii with {solves} solves, {choice}");
            let is_small = error < allowed * point.tolerance + 1e-10;
            rows.push(Row::test(
                format!("scallop drift of {name}"),
                mark,
                is_small,
            ));
        }
    }
    rows
}

impl Study {
    /// Adds the tests, charts and runs to a page.
    pub fn add_to(&self, page: &mut Page) -> Result<()> {
        self.map.add_to(page);
        let title = "Scallop drift: displacement after one arm closes and opens, exactly zero";
        let drift = chart(title, &self.scallop);
        page.chart("stability-scallop", "scallop drift", &drift)?;
        let title = "Error of a stroke of four phases that swims and turns";
        let stroke = chart(title, &self.stroke);
        page.chart("stability-integrators", "error of a stroke", &stroke)?;
        page.text(
            "Three unequal spheres on a bent chain in unbounded fluid (rpy), which rotate while they swim. Scallop drift: displacement after an arm closes and opens again, \
             exactly zero. Stroke: four phases, error of the middle sphere. Errors in radii.",
        );
        let headings = "integrator,choice,solves,scallop drift,stroke: solves,error";
        let mut table = Table::new(headings.split(','));
        for (scallop, stroke) in self.scallop.iter().zip(&self.stroke) {
            table.push([
                scallop.integrator.into(),
                scallop.choice.as_str().into(),
                count(scallop.solves),
                exp(scallop.error, 1),
                count(stroke.solves),
                exp(stroke.error, 1),
            ]);
        }
        page.table(table);
        Ok(())
    }
}

/// Chart of errors over solves, one curve per integrator.
fn chart(title: &str, points: &[Point]) -> LogLog {
    let series = INTEGRATORS.map(|name| {
        let points = points.iter().filter(|p| p.integrator == name);
        // Smaller errors are rounding errors.
        let points = points.map(|p| (p.solves as f64, p.error.max(1e-16)));
        Series::new(name, points)
    });
    LogLog::new(title, ["solves", "error in radii"], series, true)
}
