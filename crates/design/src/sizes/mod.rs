//! The best sizes of a swimmer for its gait: radii of spheres and lengths of arms.
//!
//! A larger swimmer goes farther, so that sizes have an optimum only if something is kept: the sum
//! of the volumes of the spheres that vary, and the sum of the lengths of the arms that vary. The
//! search is over the shares in these sums. The gait stays: arms change by the same amounts at the
//! same times.
//!
//! Each run of the gait gives one value of the objective. A quadratic function is interpolated in
//! the runs around a centre, and minimised within the limits and a trust region, which grows and
//! shrinks with the success of the prediction (Conn, Scheinberg & Vicente 2009, chapter 10).

mod polytope;
mod shares;
mod size_objective;
mod slices;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use scene::Scene;
use serde_json::{Map, Value, json};
use swimmer::SwimError;

use crate::error::{DesignError, DesignProgress, check_interruption};
use crate::sensitivities::{Parameter, comparable};
use polytope::{Quadratic, STENCIL_RADIUS, stencil};
use shares::SizeSpace;
use size_objective::SizeObjective;
pub use size_objective::SizeRun;
pub use slices::{SizeSlice, size_slices};

/// First step of the interpolation, relative to a share.
const FIRST_STEP: f64 = 0.15;

/// Largest step; shares then change by at most three quarters.
const MAX_STEP: f64 = 0.25;

/// Size of the trust region relative to the step. At the largest step it reaches the limits from a
/// centre around which the interpolation stays inside them.
const TRUST_FACTOR: f64 = 3.0;

/// Smallest step; differences of closer runs would be rounding errors of mesh sizes.
const MIN_STEP: f64 = 0.01;

/// Decrease of the objective by a further step, relative to `optimise.tolerance`, at which the
/// search ends. At an optimum the objective changes by the square of the sizes.
const SEARCH_SHARE: f64 = 1e-2;

/// Largest number of quadratic functions; a search takes about eight.
const MAX_ROUNDS: usize = 60;

/// Number of runs in parallel between two looks at signals.
const BATCH: usize = 8;

/// Distance from a limit, relative to the size, below which a size counts as at the limit.
const ACTIVE_DISTANCE: f64 = 1e-3;

/// The best sizes for a gait.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct BestSizes {
    /// The sizes that vary, with their values in the scene.
    pub parameters: Vec<Parameter>,
    /// Their best values.
    pub values: Vec<f64>,
    /// Error bars of the values: where the objective is lower by its error bar. Zero at a limit.
    pub errors: Vec<f64>,
    /// Limits that are active, in words.
    pub at_limits: Vec<String>,
    /// The scene with the best sizes.
    pub scene: Scene,
    /// The run of that scene, by its own model and tolerance.
    pub best: SizeRun,
    /// The run of the scene with its own sizes.
    pub before: SizeRun,
    /// All sizes that were tried, with the value of the objective.
    pub runs: Vec<(Vec<f64>, f64)>,
}

impl BestSizes {
    /// The answer as `swim sizes --json` prints it.
    pub fn json(&self) -> Value {
        let values = self.values.iter().zip(&self.errors);
        let sizes: Map<String, Value> = (self.parameters.iter().zip(values))
            .map(|(parameter, (value, error))| {
                let size = json!({ "value": value, "error": error, "scene": parameter.value });
                (parameter.name.clone(), size)
            })
            .collect();
        json!({
            "objective": self.scene.optimise().objective.word(),
            "sizes": sizes,
            "at_limits": self.at_limits,
            "best": self.best,
            "scene": self.before,
            "runs": self.runs.len(),
        })
    }
}

/// Searches for the sizes `optimise.radii` and `optimise.arms` for which the gait is best: of the
/// highest Lighthill efficiency, or of the largest displacement, by `optimise.objective`.
///
/// The sums of the volumes of the spheres and of the arm lengths that vary stay the same. The
/// search starts from the sizes of the scene and finds a local optimum.
///
/// Cost: about `4 (n + 1) (n + 2)` runs for `n` ratios.
///
/// # Errors
/// [`DesignError::NotApplicable`] for limits that leave no room, another objective, a swimmer
/// without displacement, and sizes at which bodies touch; errors of the runs,
/// [`DesignError::Stopped`].
pub fn best_sizes(
    scene: &Scene,
    progress: &mut dyn DesignProgress,
) -> Result<BestSizes, DesignError> {
    DesignError::check_rheology(scene)?;
    let mut search = Search::new(scene, progress)?;
    let found = search.best(&search.space.start())?;
    let Search {
        objective,
        space,
        runs,
        progress,
        ..
    } = search;
    let best = space.scene(scene, &found.shares)?;
    progress.begins("running the best sizes by the full model");
    let errors = errors(&space, &found);
    Ok(BestSizes {
        values: space.values(&found.shares),
        at_limits: at_limits(&space, &found.shares),
        best: objective.run(&best)?,
        before: objective.run(scene)?,
        scene: best,
        errors,
        runs,
        parameters: space.parameters,
    })
}

/// The runs of a search.
struct Search<'a> {
    scene: Scene,
    objective: SizeObjective,
    space: SizeSpace,
    runs: Vec<(Vec<f64>, f64)>,
    progress: &'a mut dyn DesignProgress,
}

/// The optimum of a search.
struct Found {
    shares: Vec<f64>,
    /// The last quadratic function, for changes along `basis` of the shares around which it was
    /// interpolated.
    model: Quadratic,
    basis: DMatrix<f64>,
    /// Relative error bar of the objective.
    bar: f64,
}

impl<'a> Search<'a> {
    /// No runs of a scene yet, with a fixed model and a tighter tolerance.
    fn new(scene: &Scene, progress: &'a mut dyn DesignProgress) -> Result<Self, DesignError> {
        let space = SizeSpace::from_scene(scene)?;
        let objective = SizeObjective::from_scene(scene)?;
        let (scene, direction) = comparable(scene)?;
        Ok(Self {
            scene,
            objective: objective.along(direction),
            space,
            runs: Vec::new(),
            progress,
        })
    }

    /// Costs of points: minus the objective.
    fn costs(&mut self, points: &[Vec<f64>]) -> Result<Vec<SizeRun>, DesignError> {
        let mut found = Vec::new();
        for batch in points.chunks(BATCH) {
            let runs: Vec<Result<SizeRun, DesignError>> = (batch.par_iter())
                .map(|shares| {
                    let scene = self.space.scene(&self.scene, shares)?;
                    self.objective.run(&scene)
                })
                .collect();
            for (shares, run) in batch.iter().zip(runs) {
                let values = self.space.values(shares);
                let run = run.map_err(|error| self.explained(error, &values))?;
                self.runs.push((values, run.objective));
                found.push(run);
            }
            let done = self.runs.len();
            check_interruption(self.progress, || {
                format!("{done} runs with different sizes")
            })?;
        }
        Ok(found)
    }

    /// Says with which sizes bodies touch.
    fn explained(&self, error: DesignError, values: &[f64]) -> DesignError {
        match error {
            DesignError::Swim(SwimError::Collision { .. } | SwimError::Scene(_)) => {
                let sizes = self.space.parameters.iter().zip(values);
                let sizes: Vec<String> = sizes
                    .map(|(parameter, value)| format!("{} = {value:.4}", parameter.name))
                    .collect();
                let problem = format!(
                    "the sizes {} cannot be run: {error}; narrow optimise.radii or optimise.arms",
                    sizes.join(", ")
                );
                DesignError::not_applicable(&self.scene, "optimise", problem)
            }
            error => error,
        }
    }

    fn best(&mut self, start: &[f64]) -> Result<Found, DesignError> {
        let (inner, largest_step) = self.inner_point(start).ok_or_else(stuck)?;
        let mut step = FIRST_STEP.min(largest_step);
        let first = self.costs(&[start.to_vec()])?[0];
        if first.objective <= first.error {
            let problem = format!(
                "the displacement in this direction, {:.1e} +- {:.1e}, is not positive; turn the \
                 direction round or remove it",
                first.displacement, first.displacement_error
            );
            let key = "optimise.direction";
            return Err(DesignError::not_applicable(&self.scene, key, problem));
        }
        let bar = first.error / first.objective;
        // At this step the errors of differences by noise and by truncation are equal.
        let last_step = bar.cbrt().max(MIN_STEP).min(step);
        let wanted = bar.max(SEARCH_SHARE * self.scene.optimise().tolerance);
        let (mut shares, mut objective) = (start.to_vec(), first.objective);
        for _ in 0..MAX_ROUNDS {
            let done = self.runs.len();
            self.progress
                .begins(&format!("sizes: {done} runs, best {objective:.4e}"));
            let around = pulled(&self.space, &shares, &inner, step);
            let trial = self.trial(&around, step, objective)?;
            let reached = self.costs(std::slice::from_ref(&trial.shares))?[0].objective;
            // Relative to the best objective so far.
            let predicted = -1.0 - trial.cost;
            let gained = reached / objective - 1.0;
            let is_last = step <= last_step;
            // The minimum of the function is more accurate than the comparison of two runs.
            if gained > 0.0 || (is_last && gained > -wanted) {
                (shares, objective) = (trial.shares, reached);
            }
            let is_done = predicted <= wanted || gained <= 0.25 * predicted;
            if is_last && is_done {
                return Ok(Found {
                    shares,
                    model: trial.model,
                    basis: trial.basis,
                    bar,
                });
            }
            if is_done {
                step = (0.25 * step).max(last_step);
            } else if gained > 0.75 * predicted {
                step = (2.0 * step).min(largest_step);
            }
        }
        Err(DesignError::no_stroke(format!(
            "the search over sizes has not converged after {MAX_ROUNDS} steps; its runs have error bars \
             of {bar:.1e}; lower model.tolerance or raise optimise.tolerance"
        )))
    }

    /// A point far from all limits, towards which the points of the interpolation are moved, and
    /// the largest step.
    fn inner_point(&self, start: &[f64]) -> Option<(Vec<f64>, f64)> {
        let (space, basis) = (&self.space, self.space.basis(start));
        let centre = space.polytope(start, &basis, f64::INFINITY).centre()?;
        let inner = SizeSpace::moved(start, &basis, &centre);
        let widest = space.polytope(&inner, &space.basis(&inner), f64::INFINITY);
        let largest_step = MAX_STEP.min(0.25 * widest.depth() / STENCIL_RADIUS);
        Some((inner, largest_step))
    }

    /// The minimum of the quadratic function through runs around a point, whose costs are relative
    /// to `objective`.
    fn trial(&mut self, around: &[f64], step: f64, objective: f64) -> Result<Trial, DesignError> {
        let basis = self.space.basis(around);
        let depth = self.space.polytope(around, &basis, f64::INFINITY).depth();
        let inside = step.min(depth / STENCIL_RADIUS);
        let points = stencil(basis.ncols(), inside);
        let moved = |y: &DVector<f64>| SizeSpace::moved(around, &basis, y);
        let all: Vec<Vec<f64>> = points.iter().map(moved).collect();
        let costs: Vec<f64> = (self.costs(&all)?.iter())
            .map(|run| -run.objective / objective)
            .collect();
        let model = Quadratic::through(&costs, basis.ncols(), inside);
        let polytope = self.space.polytope(around, &basis, TRUST_FACTOR * step);
        // From several points, because the function may be concave.
        let minima = points.iter().filter_map(|y| polytope.minimum(&model, y));
        let best = minima.reduce(|a, b| if b.cost < a.cost { b } else { a });
        let best = best.ok_or_else(stuck)?;
        Ok(Trial {
            shares: moved(&best.x),
            cost: best.cost,
            model,
            basis,
        })
    }
}

/// The minimum of a quadratic function, for changes along `basis`.
struct Trial {
    shares: Vec<f64>,
    cost: f64,
    model: Quadratic,
    basis: DMatrix<f64>,
}

fn stuck() -> DesignError {
    DesignError::no_stroke(
        "rounding has closed the limits of the sizes; widen optimise.radii or optimise.arms",
    )
}

/// The point next to `shares` from which steps of the interpolation stay inside the limits.
///
/// `inner` is a point far from all limits; it is the answer if rounding prevents another one.
fn pulled(space: &SizeSpace, shares: &[f64], inner: &[f64], step: f64) -> Vec<f64> {
    // A step is relative to the share: at the distance `d` from a lower limit `l` it has the length
    // `step (l + d)`, so `d = r step (l + d)` for a stencil of the radius `r`.
    let depth = STENCIL_RADIUS * step / (1.0 - STENCIL_RADIUS * step);
    let basis = space.basis(shares);
    let polytope = space.polytope(shares, &basis, f64::INFINITY).shrunk(depth);
    if polytope.depth() > 0.0 {
        return shares.to_vec();
    }
    let relative = inner.iter().zip(shares).map(|(a, b)| a / b - 1.0);
    let start = basis.tr_mul(&DVector::from_iterator(shares.len(), relative));
    let nearest = polytope.minimum(&Quadratic::distance(basis.ncols()), &start);
    nearest.map_or(inner.to_vec(), |nearest| {
        SizeSpace::moved(shares, &basis, &nearest.x)
    })
}

/// Limits that are active, in words.
fn at_limits(space: &SizeSpace, shares: &[f64]) -> Vec<String> {
    let values = space.values(shares);
    let mut found = Vec::new();
    for ((parameter, value), limit) in space.parameters.iter().zip(values).zip(space.limits()) {
        for (bound, word) in [(limit.0, "smallest"), (limit.1, "largest")] {
            if (value - bound).abs() < ACTIVE_DISTANCE * value {
                found.push(format!("the {} is the {word} allowed", parameter.name));
            }
        }
    }
    for names in space.closed_gaps(shares, ACTIVE_DISTANCE) {
        found.push(format!("{names} come as close as optimise.gap allows"));
    }
    found
}

/// Error bars of the values: where the objective is lower by its error bar.
///
/// ```text
/// δ_k^2 = 2 bar (B H^+ B^T)_kk
/// ```
///
/// with the Hessian `H` and the basis `B`, for changes that keep the active limits.
fn errors(space: &SizeSpace, found: &Found) -> Vec<f64> {
    let values = space.values(&found.shares);
    let basis = space.basis(&found.shares);
    let free = space
        .polytope(&found.shares, &basis, f64::INFINITY)
        .free_directions(ACTIVE_DISTANCE);
    if free.ncols() == 0 {
        return vec![0.0; values.len()];
    }
    // Both bases span the same space up to the distance of the points.
    let along = found.basis.tr_mul(&basis) * &free;
    let hessian = along.tr_mul(&(&found.model.hessian * &along));
    let eigen = hessian.symmetric_eigen();
    let directions = &basis * free * &eigen.eigenvectors;
    (values.iter().enumerate())
        .map(|(k, value)| {
            let pairs = directions.row(k).into_iter().zip(&eigen.eigenvalues);
            let square: f64 = pairs
                .map(|(part, curvature)| 2.0 * found.bar * part * part / curvature.max(found.bar))
                .sum();
            let relative = space.elasticity(k) * square.sqrt();
            // Rounding of the free directions at a limit.
            if relative > 1e-9 {
                value * relative
            } else {
                0.0
            }
        })
        .collect()
}
