//! Random strokes of three spheres against multipoles.

use std::fmt::Write;
use std::time::Instant;

use anyhow::{Context, Result};
use swimmer::{Method, Outcome, Scene, choose, simulate};

use super::arrangement::log_uniform;
use super::case::{Case, End};
use super::quantity::of_stroke;
use crate::accuracy::strokes::Largest;
use crate::random::Random;

/// Tolerance of the multipoles that are compared with.
const EXACT: f64 = 1e-8;

/// Gaps to which arms close, in radii of the smaller neighbour.
const GAPS: [f64; 2] = [0.05, 3.0];

/// Set-ups, one per seed in turn; two thirds are collinear, unbounded, curved, one cycle.
const SETUPS: [&str; 12] = [
    "plain",
    "plain",
    "ball",
    "plain",
    "plain",
    "straight",
    "plain",
    "plain",
    "two cycles",
    "plain",
    "plain",
    "angle",
];

/// A stroke that was drawn.
struct Stroke {
    setup: &'static str,
    radii: [f64; 3],
    open: [f64; 2],
    /// Gap to which each arm closes, in radii of the smaller neighbour.
    gaps: [f64; 2],
    /// Angle in degrees between the second arm and the continuation of the first.
    angle: f64,
}

impl Stroke {
    fn draw(seed: u64) -> Self {
        let random = &mut Random(seed);
        let setup = SETUPS[(seed % SETUPS.len() as u64) as usize];
        loop {
            let drawn = Self {
                setup,
                radii: [(); 3].map(|()| random.within(0.6, 1.6)),
                open: [(); 2].map(|()| random.within(5.0, 10.0)),
                gaps: [(); 2].map(|()| log_uniform(random, GAPS)),
                // Up to this angle the outer spheres cannot touch each other.
                angle: random.within(20.0, 60.0),
            };
            let closed = drawn.closed();
            if (0..2).all(|arm| closed[arm] < 0.9 * drawn.open[arm]) {
                return drawn;
            }
        }
    }

    /// Lengths of the closed arms.
    fn closed(&self) -> [f64; 2] {
        [0, 1].map(|arm| {
            let [a, b] = [self.radii[arm], self.radii[arm + 1]];
            a + b + self.gaps[arm] * a.min(b)
        })
    }

    fn text(&self, model: &str) -> String {
        let mut text = format!("model = {{ {model} }}\n");
        let angle = match self.setup {
            "angle" => self.angle.to_radians(),
            _ => 0.0,
        };
        match self.setup {
            "ball" => text.push_str("domain = { kind = \"ball\", radius = 40 }\n"),
            "straight" => text.push_str("fem.geometry = \"straight\"\n"),
            "two cycles" => text.push_str("gait.cycles = 2\n"),
            _ => (),
        }
        let [left, right] = self.open;
        let positions = [
            [-left, 0.0],
            [0.0, 0.0],
            [right * angle.cos(), right * angle.sin()],
        ];
        let names = ["left", "centre", "right"];
        for ((name, radius), [x, y]) in names.iter().zip(self.radii).zip(positions) {
            let _ = writeln!(
                text,
                "[[bodies]]\nname = \"{name}\"\nradius = {radius:?}\nposition = [{x:?}, {y:?}, 0]"
            );
        }
        for name in ["left", "right"] {
            let _ = writeln!(
                text,
                "[[links]]\nname = \"{name}-arm\"\nbody = \"{name}\"\nto = \"centre\""
            );
        }
        for lengths in [self.closed(), self.open] {
            for (name, length) in ["left", "right"].iter().zip(lengths) {
                let _ = writeln!(
                    text,
                    "[[gait.phases]]\nlink = \"{name}-arm\"\nlength = {length:?}"
                );
            }
        }
        text
    }

    fn description(&self) -> String {
        let numbers = |list: &[f64]| {
            let numbers: Vec<String> = list.iter().map(|x| format!("{x:.3}")).collect();
            numbers.join(" ")
        };
        let angle = match self.setup {
            "angle" => format!(" of {:.1} degrees", self.angle),
            _ => String::new(),
        };
        format!(
            "{}{angle}; radii {}; arms {}; gaps {}",
            self.setup,
            numbers(&self.radii),
            numbers(&self.open),
            numbers(&self.gaps)
        )
    }

    fn groups(&self, gap: f64) -> Vec<&'static str> {
        let mut groups = vec!["all", self.setup];
        groups.extend((gap < 0.5).then_some("gap below 0.5"));
        groups.extend((gap < 0.2).then_some("gap below 0.2"));
        groups
    }
}

/// The stroke of a seed.
///
/// # Errors
/// A stroke for which there are no exact values.
pub fn case(seed: u64) -> Result<Case> {
    let drawn = Stroke::draw(seed);
    let exact = stroke(&drawn.text(&format!("kind = \"multipole\", tolerance = {EXACT:e}")))
        .context("no exact value")?
        .0;
    let clock = Instant::now();
    let computed = stroke(&drawn.text("kind = \"fem\""));
    let seconds = clock.elapsed().as_secs_f64();
    let gap = drawn.gaps[0].min(drawn.gaps[1]);
    let mut groups = drawn.groups(gap);
    let end = match computed {
        Ok((outcome, dofs)) => {
            groups.extend((!outcome.tolerance_met).then_some("tolerance missed"));
            let displacement_bar = exact.error_estimate.total() / exact.net();
            let work_bar = exact.work_error.total() / exact.work.abs();
            let bars = [displacement_bar, displacement_bar, work_bar];
            let quantities = of_stroke(&outcome);
            let exact = of_stroke(&exact);
            End::Compared {
                comparisons: quantities
                    .iter()
                    .zip(&exact)
                    .zip(bars)
                    .filter_map(|((quantity, exact), bar)| quantity.compare(exact, bar))
                    .collect(),
                dofs,
                seconds,
            }
        }
        Err(error) => End::Refused(format!("{error:#}")),
    };
    Ok(Case {
        kind: "stroke".to_owned(),
        seed,
        model: "fem".to_owned(),
        groups: groups.join(" "),
        gap,
        description: drawn.description(),
        end,
    })
}

/// Outcome of a scene file, and the largest number of dofs.
fn stroke(text: &str) -> Result<(Outcome, usize)> {
    let scene = Scene::parse(text)?;
    let mut model = choose(&scene)?.model;
    let mut largest = Largest::default();
    let outcome = simulate(&scene, &mut *model, Method::Collocation, &mut largest)?;
    Ok((outcome, largest.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_give_valid_strokes() {
        for seed in 0..24 {
            let drawn = Stroke::draw(seed);
            let scene = Scene::parse(&drawn.text("kind = \"fem\"")).unwrap();
            scene.require_gait().unwrap();
            assert_eq!(scene.gait().phases.len(), 4);
        }
    }
}
