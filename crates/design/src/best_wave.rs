//! The best wave of a tube: amplitude and number of waves, in a table of runs.

use std::path::Path;

use models::{Interpolant, chebyshev_node};
use scene::{Deformation, Document, JointValues, ObjectiveKind, Scene};
use serde_json::{Value, json};
use swimmer::{Folder, Report};

use crate::error::{DesignError, DesignProgress, check_interruption};
use crate::sweep::{Sweep, SweepOptions, SweepResult, sweep};
use crate::swept_points::{Values, VariedKey};

/// Number of runs per variable: the extrema of a Chebyshev polynomial and the ends of the range.
///
/// An analytic function is interpolated with an error that decreases geometrically in their number
/// (Trefethen 2013, theorem 8.2).
const NODES: usize = 5;

/// Number of values per variable at which the interpolant is looked up, before the largest is
/// refined.
const SAMPLES: usize = 201;

/// Halvings of the distance between these values: to the rounding of the interpolant.
const HALVINGS: usize = 30;

/// Distance from the end of a range, over its width, at which an optimum is at the end.
const AT_END: f64 = 1e-6;

/// A property of a wave that may vary.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct WaveVariable {
    /// Key of the scene, such as `bodies.worm.deformation.waves`.
    pub key: String,
    /// Smallest and largest value.
    pub range: [f64; 2],
}

/// The best wave of a tube that undulates.
#[derive(Debug)]
#[non_exhaustive]
pub struct BestWave {
    /// What varied.
    pub variables: Vec<WaveVariable>,
    /// The runs of the table.
    pub table: Sweep,
    /// The values of the best wave.
    pub values: Vec<f64>,
    /// Error bars of these values: so far away the objective is smaller by its own error; none at
    /// the end of a range, and of an objective without a bar.
    pub errors: Vec<Option<f64>>,
    /// The objective by the interpolant of the table.
    pub by_table: f64,
    /// The objective by the run of the best wave.
    pub objective: f64,
    /// Its error bar, if the model has one.
    pub error: Option<f64>,
    /// The run of the best wave, whose scene is `optimum.toml`.
    pub report: Report,
}

/// The variables of the wave that `optimise.waves`, `optimise.lower` and `optimise.upper` name;
/// none in a scene whose strokes are optimised, such as one with limits of the phase too.
///
/// # Errors
/// [`DesignError::NotApplicable`] for several tubes that undulate, one limit without the other, or
/// limits of other joints beside those of the waves.
pub fn wave_variables(scene: &Scene) -> Result<Vec<WaveVariable>, DesignError> {
    let options = scene.optimise();
    let undulates =
        |body: &&scene::Body| matches!(body.deformation, Some(Deformation::Undulation(_)));
    let tubes: Vec<&scene::Body> = scene.bodies().iter().filter(undulates).collect();
    let refuse = |key: &str, problem: String| Err(DesignError::not_applicable(scene, key, problem));
    let Some(tube) = tubes.first() else {
        return match options.waves {
            None => Ok(Vec::new()),
            Some(_) => refuse(
                "optimise.waves",
                "no tube undulates; remove the key, or give one the deformation".to_owned(),
            ),
        };
    };
    let [amplitude, phase] = ["amplitude", "phase"].map(|word| format!("{}.{word}", tube.name));
    let limit = |values: &Option<JointValues>, name: &String| match values {
        Some(JointValues::Named(values)) => values.get(name).copied(),
        _ => None,
    };
    let limits = |name: &String| (limit(&options.lower, name), limit(&options.upper, name));
    let limited = [&options.lower, &options.upper].into_iter().flatten();
    let limited = limited.flat_map(|values| match values {
        JointValues::Named(values) => values.keys().collect(),
        // Of all joints.
        _ => vec![&phase],
    });
    let other = limited.into_iter().find(|name| **name != amplitude);
    match (other, options.waves) {
        // A stroke in the space of several coordinates.
        (Some(_), None) => return Ok(Vec::new()),
        (Some(other), Some(_)) => {
            return refuse(
                "optimise.waves",
                format!(
                    "is given beside limits of \"{other}\": the gait turns the phase and moves \
                     joints as it does, while the wave is optimised; remove these limits, or \
                     optimise.waves"
                ),
            );
        }
        (None, _) => {}
    }
    let of_amplitude = match limits(&amplitude) {
        (Some(low), Some(high)) if low < high => Some([low, high]),
        (None, None) => None,
        (low, high) => {
            return refuse(
                "optimise.lower",
                format!(
                    "\"{amplitude}\" is from {low:?} to {high:?}; give the smaller one in \
                     optimise.lower and the larger one in optimise.upper"
                ),
            );
        }
    };
    let key = |word: &str| format!("bodies.{}.deformation.{word}", tube.name);
    let variable = |word: &str, range: Option<[f64; 2]>| {
        let key = key(word);
        range.map(|range| WaveVariable { key, range })
    };
    let variables: Vec<WaveVariable> = [
        variable("amplitude", of_amplitude),
        variable("waves", options.waves),
    ]
    .into_iter()
    .flatten()
    .collect();
    if tubes.len() > 1 && !variables.is_empty() {
        let names: Vec<&str> = tubes.iter().map(|tube| &tube.name[..]).collect();
        return refuse(
            "optimise",
            format!(
                "{} undulate, and the wave of one tube can be optimised; make others rigid",
                names.join(", ")
            ),
        );
    }
    Ok(variables)
}

/// Searches for the wave with the largest objective in the ranges of its [`wave_variables`], by a
/// table of runs of the gait, and runs it.
///
/// The table has five values per variable, at which polynomials interpolate the objective: by
/// `optimise.objective` Lighthill's efficiency ([`swimmer::Efficiency`]), or the net displacement,
/// per time for `speed`. Its error bar is that of the run of the best wave, and how far this run is
/// from the interpolant counts for the bars of the values. Rows are written into the folder as by
/// [`sweep`], and `optimum.toml`.
///
/// # Errors
/// No variables; other objectives; runs that fail or do not swim, with the values;
/// [`DesignError::Stopped`].
pub fn best_wave(
    scene: &Scene,
    variables: &[WaveVariable],
    out: &Path,
    progress: &mut dyn DesignProgress,
) -> Result<BestWave, DesignError> {
    if variables.is_empty() {
        let problem = "is missing, and limits of an amplitude too: no wave may vary; give one of \
                       them for a tube that undulates"
            .to_owned();
        let key = "optimise.waves";
        return Err(DesignError::not_applicable(scene, key, problem));
    }
    let objective = scene.optimise().objective;
    if !matches!(
        objective,
        ObjectiveKind::Efficiency | ObjectiveKind::Displacement | ObjectiveKind::Speed
    ) {
        let problem = format!(
            "\"{}\" is unsupported for waves; use efficiency, displacement or speed",
            objective.word()
        );
        let key = "optimise.objective";
        return Err(DesignError::not_applicable(scene, key, problem));
    }
    let folder = Folder::create(out)?;
    let keys: Vec<VariedKey> = variables.iter().map(WaveVariable::nodes).collect();
    let options = SweepOptions {
        jobs: None,
        folder: Some(&folder),
        resume: false,
    };
    progress.begins("running the waves of the table");
    let table = sweep(scene, &keys, None, options, progress)?;
    let duration = scene.gait().duration();
    let mut values = Vec::with_capacity(table.rows.len());
    for row in &table.rows {
        let of_row = |problem: String| {
            DesignError::no_stroke(format!(
                "the run at {} = {} {problem}",
                table.keys.join(", "),
                row.values.join(", ")
            ))
        };
        let result = (row.result.as_ref())
            .map_err(|reason| of_row(format!("failed: {reason}; change the ranges of optimise")))?;
        let (value, _) = objective_of(result, objective, duration).ok_or_else(|| {
            of_row(
                "does not swim, or not by more than its error bar; change the ranges of \
                    optimise, or reduce model.tolerance"
                    .to_owned(),
            )
        })?;
        values.push(value);
    }
    check_interruption(progress, || "the table".to_owned())?;
    let interpolant = Objective::new(values, variables.len());
    let shares = interpolant.largest(variables.len());
    let found: Vec<f64> = (variables.iter().zip(&shares))
        .map(|(variable, share)| variable.at(*share))
        .collect();
    let mut document = Document::parse(&scene.to_toml()?, "scene")?;
    for (variable, value) in variables.iter().zip(&found) {
        document.set(&format!("{}={value:?}", variable.key))?;
    }
    let best = Scene::from_document(document)?;
    let text = best.to_toml_in(folder.path())?;
    folder.write("optimum.toml", |file| file.write_all(text.as_bytes()))?;
    progress.begins("running the best wave");
    let report = swimmer::run_without_files(best, &mut ())?;
    let result = SweepResult::from_report(&report);
    let Some((value, error)) = objective_of(&result, objective, duration) else {
        return Err(DesignError::no_stroke(
            "the best wave of the table does not swim; change the ranges of optimise",
        ));
    };
    let by_table = interpolant.at(&shares);
    let uncertainty = error.map(|error| error + (by_table - value).abs());
    let errors = (0..variables.len()).map(|k| {
        let is_inside = (AT_END..=1.0 - AT_END).contains(&shares[k]);
        let [low, high] = variables[k].range;
        let curvature = interpolant.curvature(&shares, k);
        uncertainty
            .filter(|_| is_inside && curvature < 0.0)
            .map(|uncertainty| (high - low) * (2.0 * uncertainty / -curvature).sqrt())
    });
    Ok(BestWave {
        errors: errors.collect(),
        variables: variables.to_vec(),
        table,
        values: found,
        by_table,
        objective: value,
        error,
        report,
    })
}

/// The objective of a run with its error bar; none of one that does not swim.
fn objective_of(
    result: &SweepResult,
    objective: ObjectiveKind,
    duration: f64,
) -> Option<(f64, Option<f64>)> {
    let (net, bar) = (result.displacement.norm(), result.displacement_error);
    match objective {
        ObjectiveKind::Efficiency => Some((result.efficiency?, result.efficiency_error)),
        _ if net <= bar.unwrap_or(0.0) => None,
        ObjectiveKind::Speed => Some((net / duration, bar.map(|bar| bar / duration))),
        _ => Some((net, bar)),
    }
}

/// Positions of the values in a range, from 0 to 1.
fn node(k: usize) -> f64 {
    // The points of a grid descend.
    chebyshev_node((0.0, 1.0), NODES - 1, NODES - 1 - k)
}

impl WaveVariable {
    /// The value at a share of the range.
    fn at(&self, share: f64) -> f64 {
        let [low, high] = self.range;
        low * (1.0 - share) + high * share
    }

    fn nodes(&self) -> VariedKey {
        let value = |k| format!("{:?}", self.at(node(k)));
        VariedKey {
            key: self.key.clone(),
            values: Values::List((0..NODES).map(value).collect()),
        }
    }
}

/// The polynomial through values at all combinations of [`node`]s.
struct Objective(Interpolant);

impl Objective {
    /// Through values of which the last variable changes fastest.
    fn new(values: Vec<f64>, variables: usize) -> Self {
        let (unit, degree) = (vec![(0.0, 1.0); variables], vec![NODES - 1; variables]);
        // In a grid the first variable changes fastest, and points descend.
        let descending = values.into_iter().rev().collect();
        Self(Interpolant::new(unit, degree, 1, descending))
    }

    fn at(&self, shares: &[f64]) -> f64 {
        let shares: Vec<f64> = shares.iter().rev().copied().collect();
        self.0.evaluate(&shares)[0]
    }

    /// Where the polynomial is largest in the cube.
    fn largest(&self, variables: usize) -> Vec<f64> {
        let last = (SAMPLES - 1) as f64;
        let count = SAMPLES.pow(variables as u32);
        let shares = |number: usize| -> Vec<f64> {
            let digit = |k: usize| number / SAMPLES.pow(k as u32) % SAMPLES;
            (0..variables).map(|k| digit(k) as f64 / last).collect()
        };
        // The first of equal ones.
        let best = (0..count).map(|number| (number, self.at(&shares(number))));
        let best = best.reduce(|a, b| if b.1 > a.1 { b } else { a });
        let mut at = shares(best.map_or(0, |best| best.0));
        let mut step = 1.0 / last;
        for _ in 0..HALVINGS {
            for k in 0..variables {
                let moved = |by: f64| {
                    let mut moved = at.clone();
                    moved[k] = (moved[k] + by).clamp(0.0, 1.0);
                    moved
                };
                let candidates = [at.clone(), moved(-step), moved(step)];
                let values = candidates.each_ref().map(|shares| self.at(shares));
                let best = (0..3).fold(0, |a, b| if values[b] > values[a] { b } else { a });
                at.clone_from(&candidates[best]);
            }
            step *= 0.5;
        }
        at
    }

    /// Second derivative along a variable, by differences; the polynomial has degree four.
    fn curvature(&self, shares: &[f64], variable: usize) -> f64 {
        const STEP: f64 = 1e-2;
        let value = |by: f64| {
            let mut moved = shares.to_vec();
            moved[variable] += by;
            self.at(&moved)
        };
        (value(STEP) - 2.0 * value(0.0) + value(-STEP)) / (STEP * STEP)
    }
}

impl BestWave {
    /// The answer for other programs, as in `optimum.json`.
    pub fn json(&self) -> Value {
        let of_variable = |k: usize| {
            json!({
                "key": self.variables[k].key,
                "range": self.variables[k].range,
                "value": self.values[k],
                "error": self.errors[k],
            })
        };
        json!({
            "variables": (0..self.variables.len()).map(of_variable).collect::<Vec<_>>(),
            "objective": self.report.scene.optimise().objective.word(),
            "value": self.objective,
            "error": self.error,
            "by_table": self.by_table,
            "table": self.table.json(),
            "run": self.report.summary(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Limits of other coordinates belong to strokes; beside the number of waves they were ignored.
    #[test]
    fn bug_limits_of_the_phase_were_ignored_beside_those_of_waves() {
        let found = |options: &str| {
            let text = format!(
                "bodies = [{{ name = \"worm\", shape = \"tube\", length = 10, radius = 0.5, \
                 position = [0, 0, 0], \
                 deformation = {{ kind = \"undulation\", amplitude = 0.4 }} }}]\n\
                 gait.phases = [{{ targets = {{ \"worm.phase\" = 6.283185307179586 }} }}]\n\
                 [optimise]\n{options}\n"
            );
            wave_variables(&Scene::parse(&text).unwrap()).map_err(|error| error.to_string())
        };
        let waves = "waves = [0.7, 1.5]\n";
        let amplitude = "\"worm.amplitude\" = ";
        let limits = |more: [&str; 2]| {
            let [low, high] = more;
            format!("lower = {{ {amplitude}0.2{low} }}\nupper = {{ {amplitude}0.6{high} }}\n")
        };
        let phase = [", \"worm.phase\" = 0", ", \"worm.phase\" = 1"];
        assert_eq!(found(waves).unwrap().len(), 1);
        assert_eq!(found(&limits(["", ""])).unwrap().len(), 1);
        assert_eq!(
            found(&format!("{waves}{}", limits(["", ""])))
                .unwrap()
                .len(),
            2
        );
        assert!(found(&limits(phase)).unwrap().is_empty());
        let scene = Scene::parse("bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }]");
        let nothing = best_wave(&scene.unwrap(), &[], Path::new("unused"), &mut ());
        assert!(
            nothing
                .unwrap_err()
                .to_string()
                .contains("no wave may vary")
        );
        for limits in [limits(phase), "upper = 2\n".to_owned()] {
            let error = found(&format!("{waves}{limits}")).unwrap_err();
            assert!(error.contains("limits of \"worm.phase\""), "{error}");
        }
    }

    /// Polynomials up to the fourth degree in each variable are interpolated exactly.
    #[test]
    fn polynomials_have_their_maximum_where_it_is() {
        let f = |x: f64, y: f64| 2.0 - (x - 0.3).powi(2) * (1.0 + x) - (x * y - 0.2).powi(2);
        let values: Vec<f64> = (0..NODES * NODES)
            .map(|k| f(node(k / NODES), node(k % NODES)))
            .collect();
        let interpolant = Objective::new(values, 2);
        for (x, y) in [(0.1, 0.7), (0.5, 0.0), (1.0, 0.33)] {
            assert!((interpolant.at(&[x, y]) - f(x, y)).abs() < 1e-14);
        }
        let found = interpolant.largest(2);
        // The maximum is flat to the square of the distance: half of the digits.
        assert!(
            (found[0] - 0.3).abs() < 1e-6 && (found[1] - 2.0 / 3.0).abs() < 1e-6,
            "{found:?}"
        );
        // d²f/dy² = -2 x²
        let curvature = interpolant.curvature(&found, 1);
        assert!((curvature + 0.18).abs() < 1e-6, "{curvature}");
        // A slope leads to the end.
        let values: Vec<f64> = (0..NODES).map(|k| 3.0 * node(k)).collect();
        assert_eq!(Objective::new(values, 1).largest(1), [1.0]);
    }
}
