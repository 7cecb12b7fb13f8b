//! Random strokes of three spheres against multipoles.

use std::time::Instant;

use anyhow::{Context, Result};
use swimmer::{Method, Outcome, choose, simulate};

use super::comparison::{Case, End, of_stroke};
use crate::accuracy::net::Largest;
use crate::random::Random;
use crate::scenes::SceneText;

/// Tolerance of the multipoles that are compared with.
const EXACT: f64 = 1e-8;

/// Gaps to which arms close, in radii of the smaller neighbour.
const GAPS: [f64; 2] = [0.05, 3.0];

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
    /// The stroke of a seed; two thirds are collinear, unbounded, curved, one cycle.
    fn draw(seed: u64) -> Self {
        let random = &mut Random(seed);
        let setup = match seed % 12 {
            2 => "ball",
            5 => "straight",
            8 => "two cycles",
            11 => "angle",
            _ => "plain",
        };
        loop {
            let drawn = Self {
                setup,
                radii: [(); 3].map(|()| random.within(0.6, 1.6)),
                open: [(); 2].map(|()| random.within(5.0, 10.0)),
                gaps: [(); 2].map(|()| random.log_within(GAPS)),
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

    fn text(&self, model: &str) -> SceneText {
        let text = SceneText::new(format!("model = {{ {model} }}"));
        let text = match self.setup {
            "ball" => text.line("domain = { kind = \"ball\", radius = 40 }"),
            "straight" => text.line("fem.geometry = \"straight\""),
            "two cycles" => text.line("gait.cycles = 2"),
            _ => text,
        };
        let angle = match self.setup {
            "angle" => self.angle.to_radians(),
            _ => 0.0,
        };
        let [left, right] = self.open;
        let end = [right * angle.cos(), right * angle.sin(), 0.0];
        text.sphere("left", self.radii[0], [-left, 0.0, 0.0])
            .sphere("centre", self.radii[1], [0.0; 3])
            .sphere("right", self.radii[2], end)
            .joint("left-arm", "left", "centre")
            .joint("right-arm", "right", "centre")
            .stroke(["left-arm", "right-arm"], self.closed(), self.open)
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
        let (radii, gaps) = (numbers(&self.radii), numbers(&self.gaps));
        let arms = numbers(&self.open);
        format!(
            "{}{angle}; radii {radii}; arms {arms}; gaps {gaps}",
            self.setup
        )
    }
}

/// The stroke of a seed.
///
/// # Errors
/// A stroke for which there are no exact values.
pub fn case(seed: u64) -> Result<Case> {
    let drawn = Stroke::draw(seed);
    let exact = stroke(&drawn.text(&format!("kind = \"multipole\", tolerance = {EXACT:e}")));
    let exact = exact.context("no exact value")?.0;
    let clock = Instant::now();
    let computed = stroke(&drawn.text("kind = \"fem\""));
    let seconds = clock.elapsed().as_secs_f64();
    let gap = drawn.gaps[0].min(drawn.gaps[1]);
    let mut groups = vec!["all", drawn.setup];
    groups.extend((gap < 0.5).then_some("gap below 0.5"));
    groups.extend((gap < 0.2).then_some("gap below 0.2"));
    let end = match computed {
        Ok((outcome, dofs)) => {
            groups.extend((!outcome.tolerance_met).then_some("tolerance missed"));
            let displacement_bar = exact.error_estimate.total() / exact.net();
            let work_bar = exact.work_error.total() / exact.work.abs();
            let bars = [displacement_bar, displacement_bar, work_bar];
            let (found, exact) = (of_stroke(&outcome), of_stroke(&exact));
            let pairs = found.iter().zip(&exact).zip(bars);
            let compared = pairs.filter_map(|((found, exact), bar)| found.compare(exact, bar));
            End::Compared {
                comparisons: compared.collect(),
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
        groups: groups.into_iter().map(str::to_owned).collect(),
        gap,
        description: drawn.description(),
        end,
    })
}

/// Outcome of a scene, and the largest number of dofs.
fn stroke(text: &SceneText) -> Result<(Outcome, usize)> {
    let scene = text.parse()?;
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
            let scene = Stroke::draw(seed).text("kind = \"fem\"").parse().unwrap();
            scene.require_gait().unwrap();
            assert_eq!(scene.gait().phases.len(), 4);
        }
    }
}
