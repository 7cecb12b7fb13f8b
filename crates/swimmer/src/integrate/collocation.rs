//! Gauss collocation on the group of states, with increasing order.
//!
//! In coordinates `sigma` about the middle of the step, `X(t) = exp(sigma(t)) X_m`, the equation of
//! motion is `sigma' = dexp^-1_sigma V(X)`. The polynomial through the rates at `n` Gauss points
//! has order `2n` (Hairer, Lubich & Wanner 2006, II.1), and the method is symmetric because the
//! coordinates are centred (Zanna, Engø & Munthe-Kaas 2001). The velocity of a swimmer depends
//! strongly on its shape and weakly on its position. Therefore the Gauss points of each order are
//! placed on the path of the order before: every increase of the order improves the quadrature and
//! the positions at once, and the change of the step measures the error of both. Along a table,
//! steps go over many rows where the splines through them are as smooth as the tolerance needs.

use models::{AccumulatedError, DiscretisationError, ErrorEstimates, HoldingLoad};
use nalgebra::Vector3;
use rigid::{State, StateVelocity};
use scene::AcceptKind;

use super::inverse_dexp::coordinate_rate;
use super::order_errors::{SignedError, expected_error, is_smooth, is_stalled, remaining_error};
use super::piece::{PathPiece, combination};
use super::result::{Accumulated, Approximation, IntegralErrors, SpanResult, Stopped};
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use super::step_size::{
    MAX_PARTS, allowed_load_errors, allowed_mean_flow_error, expected_ratio, first_parts,
    largest_displacement, largest_rotation, rounding, step_tolerance, unseen_displacement,
};
use crate::error::SwimError;
use crate::gauss::{Gauss, lagrange};
use crate::holding_loads::HoldingLoads;

/// Number of points whose solutions have corrections that serve all higher orders.
///
/// Corrections are small, so they need fewer points than the velocities ([`ErrorInterpolant`]).
const CORRECTED: usize = 2;

/// Ratio of the expected error of an order to the tolerance, up to which its solutions are
/// requested with corrections. Corrections in vain cost less than the same points once more.
const MAY_SUFFICE: f64 = 2.0;

/// Part of the tolerance of a step below which a single change between orders says nothing of the
/// error: it may be small by chance, as where it turns its sign.
const SINGLE_CHANGE_SHARE: f64 = 0.1;

/// Largest number of points: beyond it, halving the step gains more.
const MAX_POINTS: usize = 8;

/// Largest ratio of the errors of a half and of a whole step that counts as a reduction.
///
/// Halving reduces an error of the integration by `2^-3` or more, and noise, which is proportional
/// to the length of the step, by 2. Where only the best result is requested, noise is accepted.
const REDUCTION_BY_HALVING: f64 = 0.25;

/// Part of the error bar of a table to which the motion through it is integrated at most.
///
/// A smaller error of the integration makes the whole error bar smaller by less than this part, and
/// a table of solutions with noise is a polynomial of high degree, which takes many steps.
pub(crate) const TABLE_SHARE: f64 = 0.1;

/// Integrates a phase span to the tolerance, or as well as possible if the scene accepts that.
pub(super) fn span(evaluator: &mut SpanEvaluator, start: &State) -> Result<SpanResult, Stopped> {
    match in_parts(evaluator, start, false) {
        Err(Stopped { error, .. })
            if matches!(*error, SwimError::NotIntegrated { .. })
                && evaluator.scene.model().accept == AcceptKind::Best =>
        {
            in_parts(evaluator, start, true)
        }
        result => result,
    }
}

/// Integrates a phase span; halves the step where increasing the order does not converge.
///
/// With `accepts_best`, a step is also accepted if halving no longer reduces its error.
fn in_parts(
    evaluator: &mut SpanEvaluator,
    start: &State,
    accepts_best: bool,
) -> Result<SpanResult, Stopped> {
    let mut result = SpanResult::empty(start);
    // Parts of the phase span in reverse order, each with the error of the step that was halved.
    let parts = first_parts(evaluator).into_iter();
    let mut todo: Vec<_> = parts.map(|part| (part, f64::INFINITY)).collect();
    while let Some((span, halved_error)) = todo.pop() {
        let middle = evaluator.span.middle(span);
        let halves = |error: f64| [((middle, span.1), error), ((span.0, middle), error)];
        let may_halve = span.1 - span.0 > 1.0 / MAX_PARTS as f64;
        let step = match step(evaluator, &result.end, span) {
            Err(error) if error.is_overshoot() && may_halve => {
                todo.extend(halves(halved_error));
                continue;
            }
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok(step) => step,
        };
        let is_best = accepts_best && step.error > REDUCTION_BY_HALVING * halved_error;
        if !step.is_accepted && !is_best {
            if may_halve {
                todo.extend(halves(step.error));
                continue;
            }
            let error = evaluator.not_integrated(step.error, step.tolerance, MAX_PARTS);
            return Err(result.stopped(evaluator, error));
        }
        match evaluator.check_path(&step.approximation.piece) {
            Err(error) if error.is_overshoot() && may_halve => {
                todo.extend(halves(halved_error));
                continue;
            }
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok(()) => {}
        }
        let duration = evaluator.span.duration * (span.1 - span.0);
        let mut accumulated = step.approximation.accumulated_error(duration);
        if let Some(accumulated) = &mut accumulated {
            accumulated.uncertainty += step.mesh_change;
        }
        let mut error = step.integration_error;
        error.uncertainty += unseen_displacement(evaluator, span);
        let approximation = step.approximation;
        result.append(
            evaluator,
            approximation,
            Some(error),
            accumulated.as_ref().map(Accumulated::Independent),
        )?;
    }
    Ok(result.with_totals(evaluator))
}

/// The motion over a phase span with a fixed number of Gauss points, without control of the error.
pub(super) fn fixed_order(
    evaluator: &mut SpanEvaluator,
    start: &State,
    points: usize,
) -> Result<Approximation, SwimError> {
    let span = (0.0, 1.0);
    let guess = initial_guess(evaluator, start, span)?;
    let coarse = collocate(evaluator, start, &guess, 1, Corrections::None)?;
    collocate(evaluator, start, &coarse.piece, points, Corrections::None)
}

/// One part of a phase span at the highest order tried.
struct Step {
    approximation: Approximation,
    /// Upper bound of the integration error of the displacement, which decides on the step.
    error: f64,
    /// Estimated integration errors.
    integration_error: AccumulatedError,
    /// Largest error of the displacement allowed.
    tolerance: f64,
    /// Change of the step by another mesh, an uncertainty of the discretisation.
    mesh_change: f64,
    is_accepted: bool,
}

/// Increases the order over one part of a phase span until the estimated error is below the
/// tolerance.
///
/// Where the changes between orders stop to decrease, the step is accepted only if the cause is
/// known and measured: rounding, the error bars of a model that controls its own error, or a change
/// of the mesh within the step, because discretisation errors on two meshes differ.
fn step(evaluator: &mut SpanEvaluator, start: &State, span: (f64, f64)) -> Result<Step, SwimError> {
    let width = span.1 - span.0;
    let duration = evaluator.span.duration * width;
    let guess = initial_guess(evaluator, start, span)?;
    let ratio = expected_ratio(evaluator, &guess)?;
    let mut previous = collocate(evaluator, start, &guess, 1, Corrections::None)?;
    // The first solution may change the mesh; later changes are counted from here.
    let mesh_changes = evaluator.mesh_changes;
    let mut all = Changes::default();
    let on_request = evaluator.capabilities().error_estimates == ErrorEstimates::OnRequest;
    let mut interpolant = None;
    let holds_bodies = evaluator.scene.has_held_bodies();
    // Errors of a lower order that were accepted, while those of loads are not yet small.
    let mut settled = None;
    let mut points = 2;
    loop {
        let left = TABLE_SHARE * previous.table_error_bar(duration);
        let tolerance = step_tolerance(evaluator, &previous.piece.step(), width).max(left);
        let may_suffice = expected_error(&all.displacements, ratio) <= MAY_SUFFICE * tolerance;
        let has_new_mesh = evaluator.mesh_changes > mesh_changes;
        let corrections = match (
            is_smooth(&all.displacements, ratio) && !has_new_mesh,
            &interpolant,
        ) {
            (true, Some(interpolant)) => Corrections::Interpolated(interpolant),
            (true, None) if on_request => Corrections::Computed,
            (false, _) if points > CORRECTED && (may_suffice || has_new_mesh) => {
                Corrections::Computed
            }
            _ => Corrections::None,
        };
        let mut current = collocate(evaluator, start, &previous.piece, points, corrections)?;
        // The order before may have none, so both are compared without corrections, unless all
        // solutions have them: what errors of the mesh change from one point to the next is less.
        let both = [&current, &previous];
        let [last, before] = both.map(|approximation| match on_request {
            true => approximation.uncorrected_step(duration),
            false => approximation.piece.step(),
        });
        let difference = &last + &(&before * -1.0);
        let change = largest_displacement(evaluator, &difference);
        // The errors of these do not decide whether the order suffices.
        let [last, before] = both.map(|approximation| approximation.uncorrected_work(duration));
        let work = last - before;
        let [last, before] = both.map(|approximation| approximation.uncorrected_holding(duration));
        let holding = last.minus(&before);
        let [last, before] = both
            .map(|approximation| approximation.uncorrected_integrals(evaluator.scene, duration));
        let integrals = last.change_from(&before, evaluator.scene);
        all.push(change, difference, work, holding);
        all.integrals.push(integrals);
        let error = remaining_error(&all.displacements, ratio);
        let mut accepted = (error <= tolerance).then_some((error, 0.0));
        let stalled = matches!(all.displacements[..], [.., a, b] if is_stalled(a, b));
        let is_converged = accepted.is_some();
        if accepted.is_none() && stalled {
            let has_new_mesh = evaluator.mesh_changes > mesh_changes;
            accepted = explained_stall(evaluator, both, change, duration, has_new_mesh);
        }
        accepted = accepted.or(settled);
        let is_accepted = accepted.is_some();
        // If this order changed the mesh, the next order decides, with corrections.
        let has_new_mesh = evaluator.mesh_changes > mesh_changes;
        let is_smooth = is_smooth(&all.displacements, ratio) && !has_new_mesh;
        let are_final = match corrections {
            Corrections::None => !on_request,
            Corrections::Computed => true,
            Corrections::Interpolated(_) => is_smooth,
        };
        let improves_loads = is_accepted && holds_bodies && {
            let allowed = allowed_load_errors(evaluator, &current.holding(duration));
            let flow = current.mean_flow(duration);
            let allowed_flow = flow.map(|flow| allowed_mean_flow_error(evaluator, &flow));
            all.loads_may_improve(allowed, allowed_flow, ratio)
        };
        let is_last = match is_accepted {
            true => !improves_loads,
            false => stalled && (are_final || !has_new_mesh),
        };
        if is_last || points == MAX_POINTS {
            if is_accepted && !are_final {
                let path = &previous.piece;
                current = collocate(evaluator, start, path, points, Corrections::Computed)?;
            }
            current.integral_errors = Some(all.integral_errors(ratio));
            let (error, mesh_change) = accepted.unwrap_or((error.max(change), 0.0));
            let of_displacement = match is_converged || settled.is_some() {
                true if points == 2 && change > rounding(evaluator, &current.piece.step()) => {
                    SignedError::unsigned(change.max(SINGLE_CHANGE_SHARE * tolerance))
                }
                true => SignedError::of_motion(&all.displacements, ratio),
                false => SignedError::unsigned(error),
            };
            return Ok(Step {
                approximation: current,
                error,
                integration_error: all.error(evaluator, of_displacement, ratio),
                tolerance,
                mesh_change,
                is_accepted,
            });
        }
        settled = accepted;
        if points == CORRECTED && is_smooth {
            interpolant = ErrorInterpolant::new(&current.solutions).filter(|_| on_request);
        }
        previous = current;
        points += 1;
    }
}

/// Changes of a step from each order to the next one.
#[derive(Default)]
struct Changes {
    displacements: Vec<f64>,
    rotations: Vec<f64>,
    works: Vec<f64>,
    forces: Vec<f64>,
    torques: Vec<f64>,
    /// Of works of linkages and mean flows.
    integrals: Vec<IntegralErrors>,
    /// The last change of the motion and of the impulses that hold bodies.
    last: Option<(StateVelocity, HoldingLoads)>,
}

impl Changes {
    fn push(&mut self, displacement: f64, motion: StateVelocity, work: f64, holding: HoldingLoads) {
        let [force, torque] = holding.largest();
        self.displacements.push(displacement);
        self.rotations.push(largest_rotation(&motion));
        self.works.push(work.abs());
        self.forces.push(force);
        self.torques.push(torque);
        self.last = Some((motion, holding));
    }

    /// Whether errors of the loads that hold bodies, or of the mean flow past them, exceed those
    /// `allowed` and still decrease.
    fn loads_may_improve(
        &self,
        [force, torque]: [f64; 2],
        mean_flow: Option<f64>,
        least_ratio: f64,
    ) -> bool {
        let flows: Vec<f64> = self
            .integrals
            .iter()
            .map(|change| change.mean_flow)
            .collect();
        [
            (&self.forces, Some(force)),
            (&self.torques, Some(torque)),
            (&flows, mean_flow),
        ]
        .into_iter()
        .any(|(changes, allowed)| {
            let stalled = matches!(changes[..], [.., a, b] if is_stalled(a, b));
            let size = SignedError::of_load(changes, least_ratio).size(changes);
            !stalled && allowed.is_some_and(|allowed| size > allowed)
        })
    }

    /// The errors of works of linkages and of mean flows at the last order.
    fn integral_errors(&self, least_ratio: f64) -> IntegralErrors {
        let remaining = |of: &dyn Fn(&IntegralErrors) -> f64| {
            let changes: Vec<f64> = self.integrals.iter().map(of).collect();
            remaining_error(&changes, least_ratio)
        };
        let linkages = self.integrals.first().map_or(0, |first| first.works.len());
        IntegralErrors {
            works: (0..linkages)
                .map(|k| remaining(&|change| change.works[k]))
                .collect(),
            mean_flow: remaining(&|change| change.mean_flow),
        }
    }

    /// The error of the last order, with that of the displacement as it was estimated.
    fn error(
        &self,
        evaluator: &SpanEvaluator,
        of_displacement: SignedError,
        least_ratio: f64,
    ) -> AccumulatedError {
        let Some((motion, holding)) = &self.last else {
            return AccumulatedError::default();
        };
        let of_rotation = SignedError::of_motion(&self.rotations, least_ratio);
        let [of_force, of_torque] =
            [&self.forces, &self.torques].map(|changes| SignedError::of_load(changes, least_ratio));
        // With signs, the bars of random works held in 85 % only.
        let of_work = SignedError::unsigned(remaining_error(&self.works, least_ratio));
        // Attitudes of single bodies and values of passive joints have no sum with a sign.
        let set = evaluator.scene.articulation();
        let has_joints = set.passive_joints().next().is_some();
        let has_attitudes = (0..motion.spins.len()).any(|body| set.has_own_attitude(body));
        let uncertainty = |estimate: SignedError, changes: &[f64], has_more: bool| match has_more {
            true => estimate.size(changes),
            false => estimate.uncertainty,
        };
        let error_of_load = |load: &HoldingLoad| HoldingLoad {
            body: load.body,
            force: of_force.ratio * load.force,
            torque: of_torque.ratio * load.torque,
        };
        let frames = motion.frames.iter();
        AccumulatedError {
            displacement: (frames.clone())
                .map(|frame| of_displacement.ratio * frame.linear)
                .collect(),
            rotation: frames
                .map(|frame| of_rotation.ratio * frame.angular)
                .collect(),
            uncertainty: uncertainty(of_displacement, &self.displacements, has_joints),
            rotation_uncertainty: uncertainty(
                of_rotation,
                &self.rotations,
                has_joints || has_attitudes,
            ),
            work_uncertainty: of_work.uncertainty,
            holding: holding.bodies.iter().map(error_of_load).collect(),
            holding_uncertainty: [of_force.uncertainty, of_torque.uncertainty],
            ..AccumulatedError::default()
        }
    }
}

/// Error of a step whose changes between orders stop to decrease, and its change by another mesh;
/// none if the cause is not known.
fn explained_stall(
    evaluator: &SpanEvaluator,
    [current, previous]: [&Approximation; 2],
    change: f64,
    duration: f64,
    has_new_mesh: bool,
) -> Option<(f64, f64)> {
    let step = current.piece.step();
    let is_rounding = change <= rounding(evaluator, &step);
    let is_model_error =
        evaluator.capabilities().controls_error && change <= current.error_bar(duration);
    if is_rounding || is_model_error {
        return Some((change, 0.0));
    }
    let is_mesh_change = has_new_mesh && change <= current.uncorrected_mesh_error_bar(duration);
    is_mesh_change.then(|| {
        // The corrections remove most of the difference between the meshes.
        let corrected = &step + &(&previous.piece.step() * -1.0);
        (0.0, largest_displacement(evaluator, &corrected))
    })
}

/// The path of a step before the first solve.
fn initial_guess(
    evaluator: &SpanEvaluator,
    start: &State,
    span: (f64, f64),
) -> Result<PathPiece, SwimError> {
    let rate = fixed_centroids(evaluator, start, span)?;
    PathPiece::new(evaluator.scene.articulation(), start, span, vec![rate])
}

/// Collocation with `points` Gauss points on the path found so far, with corrected solutions.
///
/// Where springs determine values of joints, these are iterated to a part of the tolerance.
fn collocate(
    evaluator: &mut SpanEvaluator,
    start: &State,
    path: &PathPiece,
    points: usize,
    corrections: Corrections,
) -> Result<Approximation, SwimError> {
    let set = evaluator.scene.articulation();
    let span = (path.from, path.to);
    let width = span.1 - span.0;
    let duration = evaluator.span.duration * width;
    let gauss = Gauss::new(points);
    let middle = span.0 + 0.5 * width;
    let newton = evaluator.joint_newton(middle, &path.state(set, middle)?)?;
    let rates = |piece: &PathPiece, solutions: &[SpanSolution]| -> Vec<StateVelocity> {
        let rate = |(s, &t): (&SpanSolution, &f64)| {
            &coordinate_rate(set, &piece.coordinates(t), &s.solution.motion) * duration
        };
        solutions.iter().zip(&gauss.nodes).map(rate).collect()
    };
    let mut piece = path.clone();
    let mut iterations = 0;
    let mut solutions = loop {
        let solutions = solve_points(evaluator, &piece, &gauss, corrections)?;
        let mut rates = rates(&piece, &solutions);
        let joint_change = match &newton {
            None => 0.0,
            Some(newton) => {
                let values = solutions
                    .iter()
                    .map(|solution| solution.state.joints.clone());
                let values: Vec<_> = values.collect();
                let changes = newton.step(&start.joints, &values, &mut rates, duration);
                let displacements = changes.iter().flat_map(|changes| {
                    (set.passive_drives().zip(changes))
                        .map(|((joint, _), change)| set.arm_displacement(joint, *change))
                });
                displacements.fold(0.0, f64::max)
            }
        };
        piece = PathPiece::new(set, start, span, rates)?;
        iterations += 1;
        let allowed = JOINT_SHARE * step_tolerance(evaluator, &piece.step(), width);
        if joint_change <= allowed || points == 1 || iterations == MAX_JOINT_ITERATIONS {
            break solutions;
        }
    };
    if evaluator.scene.is_free() {
        // The motion depends on the shape alone, so the same solutions, rotated, hold on the
        // corrected path: iterate to rounding.
        for _ in 0..MAX_ROTATION_SWEEPS {
            for (solution, &t) in solutions.iter_mut().zip(&gauss.nodes) {
                *solution =
                    evaluator.rotated(solution, &piece.state(set, span.0 + t * (span.1 - span.0))?);
            }
            let next = PathPiece::new(set, start, span, rates(&piece, &solutions))?;
            let change = largest_displacement(evaluator, &(&next.step() + &(&piece.step() * -1.0)));
            piece = next;
            if change <= f64::EPSILON * largest_displacement(evaluator, &piece.step()) {
                break;
            }
        }
    }
    Ok(Approximation::new(piece, solutions, gauss.weights))
}

/// The solutions at the Gauss points of a path.
fn solve_points(
    evaluator: &mut SpanEvaluator,
    path: &PathPiece,
    gauss: &Gauss,
    corrections: Corrections,
) -> Result<Vec<SpanSolution>, SwimError> {
    let set = evaluator.scene.articulation();
    let point = |&t: &f64| {
        let s = path.from + t * (path.to - path.from);
        Ok((s, path.state(set, s)?))
    };
    let points = gauss.nodes.iter().map(point);
    let points = points.collect::<Result<_, SwimError>>()?;
    let computed = matches!(corrections, Corrections::Computed);
    let mut solutions = evaluator.solve_points(points, computed)?;
    if let Corrections::Interpolated(interpolant) = corrections {
        for solution in &mut solutions {
            if let Some(error) = interpolant.at(solution.s) {
                solution.solution.correct(error);
            }
        }
    }
    Ok(solutions)
}

/// Part of the tolerance of a step to which the values of passive joints are iterated.
const JOINT_SHARE: f64 = 0.01;

/// Largest number of iterations for the values of passive joints. They converge by the error of the
/// derivative, 0.3 at worst; what is left is part of the change to the next order.
const MAX_JOINT_ITERATIONS: usize = 6;

/// Largest number of fixed-point iterations for the rotation of a free swimmer; each reduces the
/// error by a factor of the rotation angle of a phase span, below 0.3.
const MAX_ROTATION_SWEEPS: usize = 40;

/// Initial guess of the motion over a span: the mean position of the bodies of every linkage stays,
/// or its root has its given velocity.
fn fixed_centroids(
    evaluator: &SpanEvaluator,
    start: &State,
    span: (f64, f64),
) -> Result<StateVelocity, SwimError> {
    let set = evaluator.scene.articulation();
    let before = set.place(start, &evaluator.span.shape(span.0))?;
    let after = set.place(start, &evaluator.span.shape(span.1))?;
    let mut guess = combination(std::iter::empty(), start);
    for (frame, linkage) in guess.frames.iter_mut().zip(set.linkages()) {
        if let Some(velocity) = evaluator.scene.bodies()[linkage.root].held_velocity() {
            let [from, to] = [span.0, span.1].map(|s| evaluator.span.time(s));
            frame.linear = velocity.integral(to) - velocity.integral(from);
            continue;
        }
        let shift =
            |&body: &usize| before[body].translation.vector - after[body].translation.vector;
        frame.linear =
            linkage.bodies.iter().map(shift).sum::<Vector3<f64>>() / linkage.bodies.len() as f64;
    }
    Ok(guess)
}

/// Source of the corrections of all solutions of one order.
#[derive(Clone, Copy)]
enum Corrections<'a> {
    /// The solutions are requested without corrections.
    None,
    /// Every solution is requested with its own.
    Computed,
    /// Interpolated from solutions at fewer points.
    Interpolated(&'a ErrorInterpolant),
}

/// Discretisation errors at a few points of a step.
///
/// They are small, and on one moving mesh they are as smooth as the velocities. A quadrature over
/// few points therefore has about the relative error for them that it has for the velocities; with
/// two points it is 1e-2 of the correction.
struct ErrorInterpolant(Vec<(f64, DiscretisationError)>);

impl ErrorInterpolant {
    /// The errors that were subtracted from solutions; none if one of them has no estimate.
    fn new(solutions: &[SpanSolution]) -> Option<Self> {
        let error = |s: &SpanSolution| Some((s.s, s.solution.mesh_error.clone()?));
        Some(Self(solutions.iter().map(error).collect::<Option<_>>()?))
    }

    /// The error at the position `s` on the phase span, by the polynomial through the points.
    fn at(&self, s: f64) -> Option<DiscretisationError> {
        let positions: Vec<f64> = self.0.iter().map(|(s, _)| *s).collect();
        let terms = self.0.iter().enumerate();
        DiscretisationError::combination(
            terms.map(|(i, (_, error))| (lagrange(&positions, i, s), error)),
        )
    }
}
