//! Bodies with mass: the Radau IIA method with three stages, order 5.
//!
//! The equations of motion `dp/dt = F + C^T λ - R U` for the momenta `p = M U` of the bodies hold
//! with the constraints `C U = w` of the joints: a differential-algebraic system of index 2, for
//! which the velocities of Radau IIA converge with order 5 (Hairer & Wanner 1996, VII.4). In the
//! limit of no mass it is the collocation of the massless motion. The stages
//!
//! ```text
//! p_i = p_0 + h sum_j a_ij f_j,   f = F + C^T λ - R U
//! ```
//!
//! are solved one after the other with the lower triangle L of the Crout factorisation `A = L U` in
//! place of A, until they converge (van der Houwen & de Swart 1997, SIAM J. Sci. Comput. 18): an
//! instantaneous solution with the resistance `M / (h l_ii)` in addition to that of the fluid, in
//! any model and formulation. The error decreases by a factor of 0.15 or better per iteration, for
//! any ratio of mass and resistance.
//!
//! The work on the fluid is that of all other forces minus the change of the kinetic energy `E`:
//! the quadrature of its power misses the rapid changes of light bodies, whose momenta are right
//! nevertheless. With the weights `b` of the stages it is
//!
//! ```text
//! h sum_i b_i (P_i + f_i · U_i) - (E_1 - E_0)
//! ```

use nalgebra::Vector6;
use rigid::{State, StateVelocity};

use super::inverse_dexp::coordinate_rate;
use super::masses::{
    Velocities, after_impulse, at_rest, implicit_terms, mass_matrices, momenta, numbers_of,
    power_of_growth, velocities_of,
};
use super::piece::{PathPiece, combination};
use super::result::{
    Accumulated, Approximation, IntegralErrors, IntegrationError, SpanResult, Stopped,
};
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use super::step_size::{
    MAX_PARTS, first_parts, largest_displacement, largest_rotation, step_tolerance,
    unseen_displacement,
};
use crate::error::SwimError;
use crate::holding_loads::HoldingLoads;
use crate::mean_flow::MeanFlowInTime;

/// Largest number of steps of a part of a phase span.
const MAX_STEPS: usize = 1 << 12;

/// Factor by which an iteration of the stages reduces their error, at most.
const CONTRACTION: f64 = 0.15;

/// Largest number of iterations of a step: 0.15^20 is rounding.
const MAX_ITERATIONS: usize = 20;

/// Part of the tolerance of a step to which its stages are iterated.
const ITERATION_SHARE: f64 = 0.01;

/// Least factor by which halving the steps reduces the error. Steps that are short compared with
/// all time scales have a factor of 32; where they are long, as for light bodies, it is at least
/// that of stage order 3.
const REDUCTION: f64 = 8.0;

/// Integrates a phase span; halves it where a trial step meets contact or impossible lengths.
///
/// `velocities` are those of the bodies at the start on entry and at the end on return; none for
/// bodies at rest. Where the rates of the joints jump, the joints transmit an impulse.
pub(super) fn span(
    evaluator: &mut SpanEvaluator,
    start: &State,
    velocities: &mut Option<Velocities>,
) -> Result<SpanResult, Stopped> {
    let before = velocities
        .take()
        .unwrap_or_else(|| at_rest(evaluator.scene));
    let mut before = after_impulse(evaluator, start, &before)?;
    let mut result = SpanResult::empty(start).with_velocities(&before);
    // Parts of the phase span in reverse order.
    let mut todo = first_parts(evaluator);
    while let Some(span) = todo.pop() {
        match part(evaluator, &result.end, &before, span) {
            Err(error) if error.is_overshoot() && span.1 - span.0 > 1.0 / MAX_PARTS as f64 => {
                let middle = evaluator.span.middle(span);
                todo.extend([(middle, span.1), (span.0, middle)]);
            }
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok((run, error)) => {
                before.clone_from(&run.velocities);
                evaluator.moved += largest_displacement(evaluator, &run.whole(&result.end));
                run.append_to(&mut result, evaluator, span, error)?;
            }
        }
    }
    *velocities = Some(before);
    Ok(result.with_totals(evaluator))
}

/// Integrates a part of a phase span: halves the steps until the change is below the tolerance.
///
/// Returns the finest steps and their estimated errors.
fn part(
    evaluator: &mut SpanEvaluator,
    start: &State,
    before: &Velocities,
    span: (f64, f64),
) -> Result<(Run, IntegrationError), SwimError> {
    let width = span.1 - span.0;
    let mut coarser: Option<Run> = None;
    let mut steps = 1;
    loop {
        let mut run = run(evaluator, start, before, span, steps)?;
        let tolerance = step_tolerance(evaluator, &run.whole(start), width);
        let error = match &coarser {
            None => f64::INFINITY,
            Some(coarser) => {
                run.difference(coarser, evaluator, start) / (REDUCTION - 1.0)
                    + run.iteration_error.displacement
            }
        };
        if error <= tolerance {
            for step in &run.steps {
                evaluator.check_path(&step.piece)?;
            }
            let duration = evaluator.span.duration * width;
            let work = |run: &Run| run.work(duration / run.steps.len() as f64);
            let work_change = coarser.as_ref().map_or(0.0, |c| work(c) - work(&run));
            let holding = |run: &Run| run.holding(duration / run.steps.len() as f64);
            let changes = (coarser.as_ref())
                .map_or([0.0; 2], |c| holding(c).largest_differences(&holding(&run)));
            let holding: [f64; 2] = std::array::from_fn(|k| {
                changes[k] / (REDUCTION - 1.0) + run.iteration_error.holding[k]
            });
            let rotation_change = coarser
                .as_ref()
                .map_or(0.0, |coarser| largest_rotation(&run.change(coarser, start)));
            let error = IntegrationError {
                displacement: error + unseen_displacement(evaluator, span),
                rotation: rotation_change / (REDUCTION - 1.0) + run.iteration_error.rotation,
                work: work_change.abs() / (REDUCTION - 1.0) + run.iteration_error.work,
                holding,
            };
            let flow = |run: &Run| run.mean_flow(duration / run.steps.len() as f64);
            run.mean_flow_error =
                (coarser.as_ref().and_then(flow).zip(flow(&run))).map(|(coarse, fine)| {
                    let change = coarse.difference(&fine, evaluator.scene);
                    change / (REDUCTION - 1.0)
                });
            return Ok((run, error));
        }
        if steps == MAX_STEPS {
            return Err(evaluator.not_integrated(error, tolerance, MAX_STEPS));
        }
        coarser = Some(run);
        steps *= 2;
    }
}

/// A part of a phase span in equal steps.
struct Run {
    steps: Vec<Approximation>,
    /// What the quadrature of the power of each step lacks of the work.
    missing_works: Vec<f64>,
    velocities: Velocities,
    /// Iteration errors, summed over all steps.
    iteration_error: IntegrationError,
    /// Estimated error of the integral of the mean flow; none outside of periodic boxes.
    mean_flow_error: Option<f64>,
}

impl Run {
    /// The sum of all steps.
    fn whole(&self, start: &State) -> StateVelocity {
        let steps: Vec<StateVelocity> = self.steps.iter().map(|step| step.piece.step()).collect();
        combination(steps.iter().map(|step| (step, 1.0)), start)
    }

    /// The difference of the sums of all steps.
    fn change(&self, other: &Self, start: &State) -> StateVelocity {
        &self.whole(start) + &(&other.whole(start) * -1.0)
    }

    /// Difference of the displacements, and of those that follow from the final velocities.
    fn difference(&self, other: &Self, evaluator: &SpanEvaluator, start: &State) -> f64 {
        let change = self.change(other, start);
        let velocities = self.velocities.iter().zip(&other.velocities);
        let speed = velocities
            .map(|(a, b)| (a - b).fixed_rows::<3>(0).norm())
            .fold(0.0, f64::max);
        let time = evaluator.relaxation.min(evaluator.span.duration);
        largest_displacement(evaluator, &change).max(time * speed)
    }

    fn work(&self, duration: f64) -> f64 {
        let steps = self.steps.iter().zip(&self.missing_works);
        steps
            .map(|(step, missing)| step.work(duration) + missing)
            .sum()
    }

    /// Impulses of the loads that hold bodies.
    fn holding(&self, duration: f64) -> HoldingLoads {
        let mut sum = HoldingLoads::default();
        for step in &self.steps {
            sum.accumulate(1.0, &step.holding(duration));
        }
        sum
    }

    /// Integral of the mean flow through a periodic box.
    fn mean_flow(&self, duration: f64) -> Option<MeanFlowInTime> {
        let mut sum = None;
        for step in &self.steps {
            MeanFlowInTime::append(&mut sum, step.mean_flow(duration).as_ref());
        }
        sum
    }

    fn append_to(
        self,
        result: &mut SpanResult,
        evaluator: &SpanEvaluator,
        span: (f64, f64),
        error: IntegrationError,
    ) -> Result<(), SwimError> {
        let count = self.steps.len() as f64;
        let duration = evaluator.span.duration * (span.1 - span.0) / count;
        for (mut step, missing_work) in self.steps.into_iter().zip(self.missing_works) {
            step.integral_errors = self.mean_flow_error.map(|error| IntegralErrors {
                mean_flow: error / count,
                ..IntegralErrors::default()
            });
            let accumulated = step.accumulated_error(duration);
            let share = IntegrationError {
                displacement: error.displacement / count,
                rotation: error.rotation / count,
                work: error.work / count,
                holding: error.holding.map(|error| error / count),
            };
            result.append(
                evaluator,
                step,
                Some(share.unsigned()),
                accumulated.as_ref().map(Accumulated::Independent),
            )?;
            result.work += missing_work;
        }
        result.velocities = numbers_of(&self.velocities);
        Ok(())
    }
}

fn run(
    evaluator: &mut SpanEvaluator,
    start: &State,
    before: &Velocities,
    (from, to): (f64, f64),
    steps: usize,
) -> Result<Run, SwimError> {
    let set = evaluator.scene.articulation();
    let mut run = Run {
        steps: Vec::with_capacity(steps),
        missing_works: Vec::with_capacity(steps),
        velocities: before.clone(),
        iteration_error: IntegrationError::default(),
        mean_flow_error: None,
    };
    let mut state = start.clone();
    for k in 0..steps {
        let at = |k: usize| from + (to - from) * (k as f64 / steps as f64);
        let span = (at(k), at(k + 1));
        let step = step(evaluator, &state, &mut run.velocities, span)?;
        run.iteration_error += step.iteration_error;
        state = step.approximation.piece.state(set, span.1)?;
        run.steps.push(step.approximation);
        run.missing_works.push(step.missing_work);
    }
    Ok(run)
}

/// One step.
struct Step {
    approximation: Approximation,
    /// What the quadrature of its power lacks of the work.
    missing_work: f64,
    iteration_error: IntegrationError,
}

/// Kinetic energy of bodies with these momenta.
fn kinetic_energy(momenta: &[Vector6<f64>], velocities: &[Vector6<f64>]) -> f64 {
    let pairs = momenta.iter().zip(velocities);
    pairs.map(|(p, u)| 0.5 * p.dot(u)).sum()
}

/// One step from `state`.
///
/// `velocities` are those before it on entry and after it on return.
fn step(
    evaluator: &mut SpanEvaluator,
    state: &State,
    velocities: &mut Velocities,
    span: (f64, f64),
) -> Result<Step, SwimError> {
    let scene = evaluator.scene;
    let set = scene.articulation();
    let width = span.1 - span.0;
    let h = evaluator.span.duration * width;
    let (nodes, a) = tableau();
    let l = crout(&a);
    let momentum_before = momenta(evaluator, span.0, state, velocities)?;
    let zero = vec![Vector6::zeros(); velocities.len()];
    let mut forces = [(); STAGES].map(|()| zero.clone());
    let at_rest = combination(std::iter::empty(), state);
    let mut rates = vec![at_rest; STAGES];
    let mut piece = PathPiece::through(set, state, span, &nodes, &rates)?;
    let mut stages: Vec<SpanSolution> = Vec::new();
    let weights = a[STAGES - 1];
    let energy_before = kinetic_energy(&momentum_before, velocities);
    let mut iteration_error = IntegrationError::default();
    let (mut work, mut missing_work) = (0.0, 0.0);
    let mut holding = HoldingLoads::default();
    for _ in 0..MAX_ITERATIONS {
        let old_forces = forces.clone();
        let old_rates = rates.clone();
        stages.clear();
        let (mut power, mut gain, mut energy) = (0.0, 0.0, 0.0);
        for i in 0..STAGES {
            let s = span.0 + nodes[i] * width;
            let at = piece.state(set, s)?;
            let masses = mass_matrices(evaluator, s, &at)?;
            let known = |body: usize| -> Vector6<f64> {
                let mut known = momentum_before[body];
                for j in 0..STAGES {
                    let new = if j < i { l[i][j] } else { 0.0 };
                    known += h * new * forces[j][body];
                    known += h * (a[i][j] - l[i][j]) * old_forces[j][body];
                }
                known
            };
            let known: Velocities = (0..masses.len()).map(known).collect();
            let time = h * l[i][i];
            let inertia = implicit_terms(&masses, &known, time);
            let solution = evaluator.solve(s, &at, true, Some(&inertia))?;
            let moving = velocities_of(&solution);
            let reached: Velocities = (masses.iter().zip(&moving)).map(|(m, u)| m * u).collect();
            for (body, momentum) in reached.iter().enumerate() {
                forces[i][body] = (momentum - known[body]) / time;
            }
            let gains = forces[i].iter().zip(&moving).map(|(f, u)| f.dot(u));
            power += h * weights[i] * solution.solution.power();
            let growth = power_of_growth(evaluator, s, &masses, &moving);
            gain += h * weights[i] * (gains.sum::<f64>() - growth);
            // The last stage is the end of the step.
            energy = kinetic_energy(&reached, &moving);
            let sigma = piece.coordinates(nodes[i]);
            rates[i] = &coordinate_rate(set, &sigma, &solution.solution.motion) * h;
            stages.push(solution);
        }
        let (mut change, mut turn) = (0.0_f64, 0.0_f64);
        for (new, old) in rates.iter().zip(&old_rates) {
            let difference = new + &(old * -1.0);
            change = change.max(largest_displacement(evaluator, &difference));
            turn = turn.max(largest_rotation(&difference));
        }
        missing_work = gain - (energy - energy_before);
        let old_work = std::mem::replace(&mut work, power + missing_work);
        let solutions = stages.iter().map(|stage| &stage.solution);
        let impulses = HoldingLoads::impulses(solutions.zip(weights.map(|b| h * b)));
        let old_holding = std::mem::replace(&mut holding, impulses);
        // The sum of all further changes.
        let further = CONTRACTION / (1.0 - CONTRACTION);
        iteration_error = IntegrationError {
            displacement: further * change,
            rotation: further * turn,
            work: further * (work - old_work).abs(),
            holding: (holding.largest_differences(&old_holding)).map(|change| further * change),
        };
        piece = PathPiece::through(set, state, span, &nodes, &rates)?;
        let allowed = ITERATION_SHARE * step_tolerance(evaluator, &piece.step(), width);
        if change <= allowed {
            break;
        }
    }
    if let Some(last) = stages.last() {
        *velocities = velocities_of(last);
    }
    let approximation = Approximation::new(piece, stages, weights.to_vec());
    Ok(Step {
        approximation,
        missing_work,
        iteration_error,
    })
}

/// Number of stages.
const STAGES: usize = 3;

/// Nodes `c` and weights `a` (Hairer & Wanner 1996, table IV.5.6).
fn tableau() -> ([f64; STAGES], [[f64; STAGES]; STAGES]) {
    let s = 6.0_f64.sqrt();
    (
        [(4.0 - s) / 10.0, (4.0 + s) / 10.0, 1.0],
        [
            [
                (88.0 - 7.0 * s) / 360.0,
                (296.0 - 169.0 * s) / 1800.0,
                (-2.0 + 3.0 * s) / 225.0,
            ],
            [
                (296.0 + 169.0 * s) / 1800.0,
                (88.0 + 7.0 * s) / 360.0,
                (-2.0 - 3.0 * s) / 225.0,
            ],
            [(16.0 - s) / 36.0, (16.0 + s) / 36.0, 1.0 / 9.0],
        ],
    )
}

/// The lower factor of `A = L U` where the diagonal of `U` is one.
fn crout(a: &[[f64; STAGES]; STAGES]) -> [[f64; STAGES]; STAGES] {
    let (mut l, mut u) = ([[0.0; STAGES]; STAGES], [[0.0; STAGES]; STAGES]);
    for j in 0..STAGES {
        for i in j..STAGES {
            l[i][j] = a[i][j] - (0..j).map(|k| l[i][k] * u[k][j]).sum::<f64>();
        }
        for k in j + 1..STAGES {
            u[j][k] = (a[j][k] - (0..j).map(|m| l[j][m] * u[m][k]).sum::<f64>()) / l[j][j];
        }
    }
    l
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tableau_integrates_polynomials_and_its_lower_factor_has_a_positive_diagonal() {
        let (c, a) = tableau();
        for (i, row) in a.iter().enumerate() {
            for power in 0..STAGES as i32 {
                let sum: f64 = row.iter().zip(c).map(|(a, c)| a * c.powi(power)).sum();
                let exact = c[i].powi(power + 1) / f64::from(power + 1);
                assert!((sum - exact).abs() < 1e-15, "{i} {power}");
            }
        }
        let weights = a[STAGES - 1];
        for power in 0..5 {
            let sum: f64 = weights.iter().zip(c).map(|(b, c)| b * c.powi(power)).sum();
            assert!((sum - 1.0 / f64::from(power + 1)).abs() < 1e-15, "{power}");
        }
        let l = crout(&a);
        assert!((0..STAGES).all(|i| l[i][i] > 0.1));
    }
}
