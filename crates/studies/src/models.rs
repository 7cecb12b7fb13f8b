//! Every model on every scene with an exact answer: error bar, true error, seconds.

use std::f64::consts::PI;
use std::path::Path;
use std::time::Instant;

use anyhow::{Result, bail};
use nalgebra::Vector3;
use swimmer::models::Hydrodynamics;
use swimmer::{Method, Scene, SwimError, choose, simulate, solve_start};

use crate::page::{self, Page};
use crate::reference::{
    COMMON_MOTION, NORMAL_TO_WALL, OPPOSITE_MOTION, PARALLEL_TO_WALL, STARS, STROKES,
    UNBOUNDED_STROKES, concentric_drag,
};
use crate::scenes::SceneText;
use crate::table::{Table, exp, fixed};

/// A scene with the exact value of one quantity.
#[derive(Clone)]
struct Case {
    /// Name in the table.
    name: String,
    /// The scene without its model.
    text: SceneText,
    exact: Exact,
}

/// A quantity with its exact value.
#[derive(Clone, Copy, Debug)]
enum Exact {
    /// Velocity of the first body at the start.
    Velocity(Vector3<f64>),
    /// Net displacement of the mean of the bodies' centres.
    Net(Vector3<f64>),
}

/// Result of a model.
#[derive(Debug, Default)]
struct Measured {
    /// The model that was used, for `auto` with the reason of the choice.
    used: String,
    /// Error bar, relative to the exact value.
    bar: f64,
    /// Whether an estimated discretisation error was subtracted.
    is_corrected: bool,
    /// True error, relative to the exact value.
    error: f64,
    seconds: f64,
}

impl Measured {
    /// Whether the error bar holds.
    ///
    /// Bars are upper bounds to six digits: those of simpler models are nearly exact. Those of
    /// corrected values are estimates, which hold to a factor of two. Errors up to 1e-12 are
    /// rounding errors.
    fn holds(&self) -> bool {
        let bars = if self.is_corrected { 2.0 } else { 1.0 + 1e-6 };
        self.error <= bars * self.bar + 1e-12
    }
}

/// Models with their tolerances.
const MODELS: &[(&str, f64)] = &[
    ("oseen", 1e-3),
    ("rpy", 1e-3),
    ("multipole", 1e-3),
    ("multipole", 1e-8),
    ("auto", 1e-1),
    ("auto", 1e-2),
    ("auto", 1e-4),
    ("auto", 1e-8),
    ("axisymmetric", 1e-4),
    ("fem", 1e-3),
];

/// Computes the table and writes `models.md` and `models.csv`.
///
/// # Errors
/// A model whose true error is larger than its error bar allows.
pub fn run(quick: bool, out: &Path) -> Result<()> {
    let mut page = Page::new(
        "Models",
        "models",
        "Every model on every scene with an exact solution: velocity of the first body, or net \
         displacement of the stroke; the error bar that the model gives and its true error, both relative to the exact value; seconds from \
         the scene to the result, for `auto` including the choice. The number behind a model is `model.tolerance`.",
    );
    page.text(
        "Models without a mesh add up the error bars of all solves of a stroke; the errors of its phase spans mostly cancel. Elements subtract \
         their estimated discretisation error; their bars, for what is left of it, hold to a factor of two.",
    );
    let mut table = Table::new(["scene", "model", "used", "bar", "error", "seconds"]);
    let mut violated = Vec::new();
    for case in cases() {
        for &(model, tolerance) in MODELS.iter().filter(|(model, _)| !quick || *model != "fem") {
            let name = match model {
                "oseen" | "rpy" | "fem" => model.to_owned(),
                _ => format!("{model}, {tolerance:.0e}"),
            };
            let line = format!("{}, {name}", case.name);
            let names = [case.name.clone().into(), name.into()].into_iter();
            match measure(&case, model, tolerance) {
                Ok(m) => {
                    let line = format!("{line}: error {:.1e}, bar {:.1e}", m.error, m.bar);
                    eprintln!("{line}");
                    let values = [exp(m.bar, 1), exp(m.error, 1), fixed(m.seconds, 4)];
                    let holds = m.holds();
                    let cells = names.chain([m.used.into()]).chain(values);
                    table.push_marked(!holds, cells);
                    violated.extend((!holds).then_some(line));
                }
                Err(error) => {
                    let reason = match error.downcast_ref::<SwimError>() {
                        Some(error) => error.to_string(),
                        None => format!("{error:#}"),
                    };
                    // The message begins with a place in the generated scene, which readers do not
                    // see.
                    let reason = reason.rsplit(": ").next().unwrap_or_default();
                    eprintln!("{line}: {reason}");
                    table.push(names.chain([reason.into()]));
                }
            }
        }
    }
    page::write(out, "models.csv", &table.csv())?;
    page.table(table);
    page.write(out, "models")?;
    if !violated.is_empty() {
        let lines = violated.join("\n");
        bail!("errors are larger than their bars allow:\n{lines}");
    }
    Ok(())
}

fn measure(case: &Case, model: &str, tolerance: f64) -> Result<Measured> {
    let text = format!("model = {{ kind = \"{model}\", tolerance = {tolerance:e} }}\n");
    let scene = Scene::parse(&(text + &case.text.0))?;
    let clock = Instant::now();
    let mut choice = choose(&scene).map_err(SwimError::from)?;
    let mut measured = compare(&scene, case.exact, choice.model.as_mut())?;
    measured.seconds = clock.elapsed().as_secs_f64();
    measured.used = match (model, choice.reasons.last()) {
        // The rest of the sentence says why, at length.
        ("auto", Some(reason)) => reason
            .split(", the cheapest")
            .next()
            .unwrap_or("")
            .to_owned(),
        _ => choice.model.name().to_owned(),
    };
    Ok(measured)
}

/// The answer of a model to a scene, compared with the exact one.
fn compare(
    scene: &Scene,
    exact: Exact,
    model: &mut dyn Hydrodynamics,
) -> Result<Measured, SwimError> {
    let (found, bar, is_corrected, exact) = match exact {
        Exact::Velocity(exact) => {
            let solution = solve_start(scene, model)?;
            let bar = solution.error_estimate.total();
            let velocity = solution.bodies[0].velocity;
            (velocity, bar, solution.mesh_error.is_some(), exact)
        }
        Exact::Net(exact) => {
            let outcome = simulate(scene, model, Method::Collocation, &mut ())?;
            let bodies = outcome.displacement.len() as f64;
            let mean = outcome.displacement.iter().sum::<Vector3<f64>>() / bodies;
            let bar = outcome.error_estimate.total();
            (mean, bar, outcome.mesh_error.is_some(), exact)
        }
    };
    let size = exact.norm();
    Ok(Measured {
        bar: bar / size,
        is_corrected,
        error: (found - exact).norm() / size,
        ..Measured::default()
    })
}

/// All scenes; the sources of the exact values are in [`crate::reference`].
fn cases() -> Vec<Case> {
    [forced_spheres(), strokes(), stars()].concat()
}

fn unbounded() -> SceneText {
    SceneText::new("domain.kind = \"unbounded\"")
}

fn ball(radius: f64) -> SceneText {
    SceneText::new(format!("domain = {{ kind = \"ball\", radius = {radius} }}"))
}

/// Single spheres and pairs under a force.
fn forced_spheres() -> Vec<Case> {
    let wall = || SceneText::new("domain.kind = \"wall\"");
    let pulled = |text: SceneText, at: [f64; 3], force: Vector3<f64>| {
        text.sphere("pulled", 1.0, at)
            .key("force", force.as_slice())
    };
    let (x, z, stokes) = (Vector3::x(), Vector3::z(), 6.0 * PI);
    let case = |name: String, text: SceneText, exact: Vector3<f64>| Case {
        name,
        text,
        exact: Exact::Velocity(exact),
    };
    let mut cases = vec![case(
        "a sphere pulled at the centre of a ball of 10".to_owned(),
        pulled(ball(10.0), [0.0; 3], x),
        x / (stokes * concentric_drag(0.1)),
    )];
    // A sphere that approaches a fixed one at speed U: half of the force if both approach each
    // other at speed U, plus half of the force if both move together.
    for (distance, together) in COMMON_MOTION {
        let Some(opposite) = OPPOSITE_MOTION.iter().find(|row| row.0 == distance) else {
            continue;
        };
        let own = 0.5 * (opposite.1 + together);
        let text = pulled(unbounded(), [0.0; 3], x).sphere("fixed", 1.0, [distance, 0.0, 0.0]);
        cases.push(case(
            format!("a sphere pulled to a fixed one, centres {distance} apart"),
            text.line("fixed = true"),
            x / (stokes * own),
        ));
    }
    let (height, normal) = NORMAL_TO_WALL;
    cases.push(case(
        format!("a sphere pulled from a wall, height {height}"),
        pulled(wall(), [0.0, 0.0, height], z),
        z / (stokes * normal),
    ));
    let (height, [along, turning, coupling]) = PARALLEL_TO_WALL;
    let free = stokes * along - (8.0 * PI * coupling).powi(2) / (8.0 * PI * turning);
    cases.push(case(
        format!("a sphere pulled along a wall, height {height}"),
        pulled(wall(), [0.0, 0.0, height], x),
        x / free,
    ));
    cases
}

/// Strokes of three spheres on a line.
fn strokes() -> Vec<Case> {
    let case = |name: String, text: SceneText, [arm, closed]: [f64; 2], net: f64| Case {
        name,
        text: (text.swimmer([1.0; 3], [arm; 2])).stroke(["left", "right"], [closed; 2], [arm; 2]),
        exact: Exact::Net(net * Vector3::x()),
    };
    let unbounded = UNBOUNDED_STROKES.map(|(arm, closed, net)| {
        let name = format!("three spheres, arms {arm} to {closed}");
        case(name, unbounded(), [arm, closed], net)
    });
    let in_balls = STROKES.iter().map(|stroke| {
        let name = format!("three spheres in a ball of {}", stroke.container);
        case(name, ball(stroke.container), [10.0, 6.0], stroke.net)
    });
    unbounded.into_iter().chain(in_balls).collect()
}

/// Strokes of stars; after a closed stroke, the mean displacement of the spheres is that of the
/// junction.
fn stars() -> Vec<Case> {
    let planar = [0.0, 1.0, 2.0].map(|k| {
        let angle: f64 = 2.0 * PI * k / 3.0;
        [angle.cos(), angle.sin(), 0.0]
    });
    let third = 3.0_f64.sqrt().recip();
    let tetrahedral = [[1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0]];
    let tetrahedral = tetrahedral.map(|[y, z]| [y * z * third, y * third, z * third]);
    let case = |(shape, arms, exact): (&str, &str, [f64; 3])| {
        let directions = match shape {
            "planar" => &planar[..],
            _ => &tetrahedral[..],
        };
        let text = unbounded().key("gait.arms", arms);
        Case {
            name: format!("{shape} swimmer, {arms}"),
            text: star(text, directions),
            exact: Exact::Net(exact.into()),
        }
    };
    STARS.map(case).to_vec()
}

/// Unit spheres on arms of 6 from a junction; the first two arms close to 4 and open again.
fn star(text: SceneText, arms: &[[f64; 3]]) -> SceneText {
    let mut text = text.body("junction", [0.0; 3]).line("shape = \"point\"");
    for (k, e) in arms.iter().enumerate() {
        text = text.sphere(format!("s{k}"), 1.0, e.map(|c| 6.0 * c));
        text = text.joint(format!("a{k}"), format!("s{k}"), "junction");
    }
    text.stroke(["a0", "a1"], [4.0; 2], [6.0; 2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[ignore = "slow: 60 s"]
    fn all_bars_of_the_quick_table_hold() {
        run(true, &std::env::temp_dir().join("models-quick")).unwrap();
    }

    #[test]
    fn errors_of_the_automatic_choice_are_below_bar_and_tolerance() {
        for case in cases() {
            // A swimmer that moves in space takes seconds per tolerance; the command computes the
            // whole table.
            let tolerances: &[f64] = match case.name.contains("swimmer") {
                true => &[1e-3],
                false => &[1e-2, 1e-4, 1e-7],
            };
            for &tolerance in tolerances {
                let measured = measure(&case, "auto", tolerance).unwrap();
                assert!(measured.holds(), "{}: {measured:?}", case.name);
                assert!(!measured.used.contains(','), "{}", measured.used);
                assert!(measured.error <= tolerance, "{}: {measured:?}", case.name);
            }
        }
    }
}
