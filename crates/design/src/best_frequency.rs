//! The frequency at which a gait moves farthest per cycle.
//!
//! Without springs and masses the displacement does not depend on the frequency. With an elastic
//! arm it is largest near the relaxation rate of the spring (Montino & DeSimone 2015).

use nalgebra::Vector3;
use scene::{Scene, ShapePath};
use serde_json::{Value, json};

use crate::error::{DesignError, DesignProgress, check_interruption};
use crate::sensitivities::{comparable, net_displacement, with_keys};

/// Ratio of neighbouring frequencies while an interval with a maximum is searched.
const STEP_RATIO: f64 = 2.0;

/// Largest ratio of a frequency to that of the scene: outside, the search ends without a maximum.
const MAX_FREQUENCY_RATIO: f64 = 1e4;

/// Width of the interval in the logarithm of the frequency at which the search ends. At a maximum
/// the displacement then differs by the order of its square, 1e-6.
const MIN_LOGARITHM_WIDTH: f64 = 1e-3;

/// Share of the golden section.
const GOLDEN_SHARE: f64 = 0.381_966_011_250_105_1;

/// A run at one frequency.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct FrequencyRun {
    /// Cycles per time.
    pub frequency: f64,
    /// Net displacement along its direction at the frequency of the scene.
    pub displacement: f64,
    /// Error bar of the displacement.
    pub error: f64,
}

/// The frequency at which the displacement of the gait is largest.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BestFrequency {
    /// The run at this frequency.
    pub best: FrequencyRun,
    /// Error bar of the frequency: at this distance the displacement is smaller by its error bar.
    /// At least the width of the last interval of the search.
    pub frequency_error: f64,
    /// All runs, by frequency.
    pub runs: Vec<FrequencyRun>,
}

impl BestFrequency {
    /// The answer as `swim frequency --json` prints it.
    pub fn json(&self) -> Value {
        let run = |run: &FrequencyRun| [run.frequency, run.displacement, run.error];
        json!({
            "frequency": self.best.frequency,
            "frequency_error": self.frequency_error,
            "period": self.best.frequency.recip(),
            "displacement": self.best.displacement,
            "displacement_error": self.best.error,
            "runs": self.runs.iter().map(run).collect::<Vec<_>>(),
        })
    }
}

/// Searches for the frequency of the gait at which the net displacement is largest.
///
/// The displacement is that along its direction at the frequency of the scene. An interval with a
/// maximum is searched in steps of a factor of two, and divided by golden sections. Another, higher
/// maximum outside this interval is not found.
///
/// Cost: about 20 runs.
///
/// # Errors
/// [`DesignError::NotApplicable`] if the displacement does not depend on the frequency, has no
/// maximum, or if loads oscillate with a period of their own; errors of the runs,
/// [`DesignError::Stopped`].
pub fn best_frequency(
    scene: &Scene,
    progress: &mut dyn DesignProgress,
) -> Result<BestFrequency, DesignError> {
    let refuse = |problem: &str| Err(DesignError::not_applicable(scene, "gait", problem));
    if scene.depends_on_time() {
        return refuse("forces, torques or the field oscillate with periods of their own");
    }
    let period = scene.gait().cycle_duration();
    if !(period > 0.0 && period.is_finite()) {
        return refuse("a gait whose cycle takes a time is required");
    }
    let (fixed, direction) = comparable(scene)?;
    let mut search = FrequencySearch {
        scene: fixed,
        period,
        direction,
        runs: Vec::new(),
        progress,
    };
    // Three logarithms, to be moved until the largest displacement is in the middle.
    let step = STEP_RATIO.ln();
    let runs = [search.run(-step)?, search.run(0.0)?, search.run(step)?];
    let values = runs.map(|run| run.displacement).into_iter();
    let spread =
        values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min);
    if spread <= runs[0].error + runs[2].error {
        return refuse(
            "the net displacement does not depend on the frequency; springs or masses would make \
             it depend",
        );
    }
    let Some((x, y)) = search.bracket([-step, 0.0, step], runs)? else {
        return refuse(&format!(
            "the displacement has no maximum between the frequencies {:.3e} and {:.3e}",
            (-MAX_FREQUENCY_RATIO.ln()).exp() / period,
            MAX_FREQUENCY_RATIO / period
        ));
    };
    let (best, width) = search.narrowed(x, y)?;
    let mut runs = search.runs;
    runs.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    Ok(BestFrequency {
        frequency_error: best.frequency * width.max(uncertain_width(&runs, &best)),
        best,
        runs,
    })
}

/// Runs at logarithms of the frequency relative to that of the scene.
struct FrequencySearch<'a> {
    scene: Scene,
    period: f64,
    direction: Vector3<f64>,
    runs: Vec<FrequencyRun>,
    progress: &'a mut dyn DesignProgress,
}

/// Logarithms of three frequencies relative to that of the scene, and their runs.
type Bracket = ([f64; 3], [FrequencyRun; 3]);

impl FrequencySearch<'_> {
    fn run(&mut self, logarithm: f64) -> Result<FrequencyRun, DesignError> {
        let factor = logarithm.exp();
        let frequency = factor / self.period;
        self.progress.begins(&format!("frequency {frequency:.6}"));
        check_interruption(self.progress, || format!("{} frequencies", self.runs.len()))?;
        let net = net_displacement(&faster(&self.scene, factor)?)?;
        let run = FrequencyRun {
            frequency,
            displacement: net.vector.dot(&self.direction),
            error: net.bar,
        };
        self.runs.push(run);
        Ok(run)
    }

    /// Moves three points until the middle one is the highest; none beyond [`MAX_FREQUENCY_RATIO`].
    fn bracket(
        &mut self,
        mut x: [f64; 3],
        mut y: [FrequencyRun; 3],
    ) -> Result<Option<Bracket>, DesignError> {
        let step = STEP_RATIO.ln();
        while y[1].displacement <= y[0].displacement.max(y[2].displacement) {
            if x[0].abs().max(x[2].abs()) > MAX_FREQUENCY_RATIO.ln() {
                return Ok(None);
            }
            if y[2].displacement > y[0].displacement {
                let next = x[2] + step;
                (x, y) = ([x[1], x[2], next], [y[1], y[2], self.run(next)?]);
            } else {
                let next = x[0] - step;
                (x, y) = ([next, x[0], x[1]], [self.run(next)?, y[0], y[1]]);
            }
        }
        Ok(Some((x, y)))
    }

    /// The maximum and the width of its interval, by golden sections.
    fn narrowed(
        &mut self,
        mut x: [f64; 3],
        mut y: [FrequencyRun; 3],
    ) -> Result<(FrequencyRun, f64), DesignError> {
        while x[2] - x[0] > MIN_LOGARITHM_WIDTH {
            // Each point leaves this share of the interval.
            let left = 1.0 - GOLDEN_SHARE;
            let steps = (MIN_LOGARITHM_WIDTH / (x[2] - x[0])).ln() / left.ln();
            let done = self.runs.len();
            self.progress
                .counted("frequencies", done, done + steps.ceil() as usize);
            // A point in the larger of both parts.
            let is_right = x[2] - x[1] > x[1] - x[0];
            let end = if is_right { x[2] } else { x[0] };
            let new = x[1] + GOLDEN_SHARE * (end - x[1]);
            let run = self.run(new)?;
            match (is_right, run.displacement > y[1].displacement) {
                (true, true) => (x, y) = ([x[1], new, x[2]], [y[1], run, y[2]]),
                (true, false) => (x[2], y[2]) = (new, run),
                (false, true) => (x, y) = ([x[0], new, x[1]], [y[0], run, y[1]]),
                (false, false) => (x[0], y[0]) = (new, run),
            }
        }
        Ok((y[1], x[2] - x[0]))
    }
}

/// Change of the logarithm of the frequency by which the displacement falls by its error bar.
///
/// The curvature is that of the parabola through the best run and the nearest ones on both sides
/// whose displacement is smaller by more than ten error bars.
fn uncertain_width(runs: &[FrequencyRun], best: &FrequencyRun) -> f64 {
    let is_lower = |run: &&FrequencyRun| {
        best.displacement - run.displacement > 10.0 * (run.error + best.error)
    };
    let below = (runs.iter().rev()).filter(|run| run.frequency < best.frequency);
    let above = runs.iter().filter(|run| run.frequency > best.frequency);
    let (Some(below), Some(above)) = (below.clone().find(is_lower), above.clone().find(is_lower))
    else {
        return 0.0;
    };
    let curvature = |run: &FrequencyRun| {
        let distance = (run.frequency / best.frequency).ln();
        (best.displacement - run.displacement) / (distance * distance)
    };
    let smallest = curvature(below).min(curvature(above));
    (2.0 * best.error / smallest).sqrt()
}

/// The scene with a gait that is faster by a factor.
fn faster(scene: &Scene, factor: f64) -> Result<Scene, DesignError> {
    let phases = &scene.gait().phases;
    let assignments = match (phases.iter()).any(|phase| matches!(phase.path, ShapePath::Linear(_)))
    {
        true => (phases.iter().enumerate())
            .map(|(k, phase)| format!("gait.phases[{k}].duration={:?}", phase.duration / factor))
            .collect(),
        false => {
            let period = scene.gait().cycle_duration() / factor;
            vec![format!("gait.period={period:?}")]
        }
    };
    with_keys(scene, &assignments, &format!("a gait faster by {factor:?}"))
}

#[cfg(test)]
mod tests {
    use scene::Document;

    use super::*;

    const ELASTIC_ARM: &str = include_str!("../../swimmer/templates/elastic-arm.toml");

    #[test]
    #[ignore = "slow: 8 s"]
    fn the_displacement_is_largest_at_the_best_frequency() {
        // The search begins at a fifth of the best frequency.
        let text = ELASTIC_ARM.replace("period = 87.96237592", "period = 400");
        let scene = Scene::parse(&text).unwrap();
        let found = best_frequency(&scene, &mut ()).unwrap();
        let BestFrequency { best, runs, .. } = &found;
        let step = 10.0 * found.frequency_error / best.frequency;
        assert!(step < 0.05, "{step}");
        for factor in [1.0 - step, 1.0 + step] {
            let other = faster(&scene, factor * best.frequency * 400.0).unwrap();
            let other = net_displacement(&comparable(&other).unwrap().0).unwrap();
            assert!(other.vector.norm() < best.displacement, "{factor}");
        }
        let is_best = |run: &FrequencyRun| run.displacement <= best.displacement;
        assert!(runs.iter().all(is_best) && runs.is_sorted_by_key(|run| run.frequency));
    }

    #[test]
    fn scenes_without_a_best_frequency_are_refused_with_the_reason() {
        let refusal = |scene: &Scene| best_frequency(scene, &mut ()).unwrap_err().to_string();
        let text = include_str!("../../swimmer/templates/three-sphere.toml");
        let mut document = Document::parse(text, "three-sphere").unwrap();
        document.set("model.kind=oseen").unwrap();
        let reason = refusal(&Scene::from_document(document).unwrap());
        assert!(
            reason.contains("does not depend on the frequency"),
            "{reason}"
        );
        let at_rest = ELASTIC_ARM.replace("periodic = true", "periodic = false");
        let forced = at_rest.replace(
            "drive = \"spring\"\nstiffness = 1",
            "drive = \"force\"\nforce = { amplitude = 0.1, period = 10 }",
        );
        let reason = refusal(&Scene::parse(&forced).unwrap());
        assert!(reason.contains("periods of their own"), "{reason}");
    }
}
