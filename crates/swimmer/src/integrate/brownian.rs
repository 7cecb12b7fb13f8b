//! Thermal motion: steps of the midpoint method of Fixman.
//!
//! With the coordinates `q` of the state (positions, attitudes, values of passive joints), their
//! mobility `N`, the deterministic velocity `V` and white noise `W`, bodies move by the equation of
//! Itô (Ermak & McCammon 1978, J. Chem. Phys. 69, 1352)
//!
//! ```text
//! dq = (V + k_B T div N) dt + (2 k_B T)^(1/2) N^(1/2) dW
//! ```
//!
//! A step draws loads `Q` of covariance `2 k_B T / dt N^-1` at its start
//! ([`models::Fluctuations`]), and moves by the velocities with these loads at two places:
//!
//! ```text
//! q' = q + dt/2 (V + N Q)(q),      q <- q + dt (V + N Q)(q')
//! ```
//!
//! The mean of the second velocity contains the drift `k_B T div N` (Fixman 1978, J. Chem. Phys.
//! 69, 1527; Delong, Balboa Usabiaga & Donev 2015, J. Chem. Phys. 143, 144107, section II B). For
//! this `Q` must be conjugate to coordinates whose meaning does not depend on `q`: forces on the
//! bodies of a linkage would be projected onto its motions twice, at different places, and leave a
//! drift of their own. On rotations both steps are exponentials in the laboratory axes, to which
//! div N refers. In equilibrium all positions, all attitudes and all values of joints are then
//! equally probable but for the Boltzmann factor of their energy.

use std::f64::consts::PI;

use rigid::State;
use scene::{Scene, ThermalNoise};

use super::piece::PathPiece;
use super::result::{Approximation, SpanResult, Stopped};
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use crate::error::SwimError;

/// Root mean square displacement of the smallest body in a step, in each direction, over its radius
/// or the range of the repulsion.
const DIFFUSION_PART: f64 = 0.05;

/// Displacement of a body by its load or slip in a step, over the same length.
const MOTION_PART: f64 = 0.2;

/// Length of a step over the relaxation time of a spring: the variance of its value is then wrong
/// by a quarter of the square of that.
const RELAXATION_PART: f64 = 0.1;

/// Smallest number of steps in a phase, whose gait the midpoint method follows with an error of the
/// order two.
const LEAST_STEPS: f64 = 20.0;

/// Largest number of steps in a phase: each keeps about a kilobyte per body.
const MAX_STEPS: f64 = 1e6;

/// Number of equal steps in a phase of this duration.
///
/// They have at most the length `fluid.time_step`. Without that key they follow from the scene
/// alone, and not from the path, which would distort the statistics: see the constants here.
/// Diffusion is that of the smallest sphere alone.
///
/// # Errors
/// [`SwimError::NotApplicable`] for more than a million steps.
pub(crate) fn noise_steps(
    scene: &Scene,
    noise: &ThermalNoise,
    duration: f64,
) -> Result<usize, SwimError> {
    let steps = match noise.time_step {
        Some(step) => duration / step,
        None => (duration / chosen_step(scene, noise)).max(LEAST_STEPS),
    };
    // Durations that are multiples of the step up to rounding.
    let steps = (steps - 1e-9 * steps).ceil().max(1.0);
    if steps <= MAX_STEPS {
        return Ok(steps as usize);
    }
    Err(SwimError::NotApplicable {
        place: scene.place("fluid.thermal_energy"),
        problem: format!(
            "a phase would take {steps:.1e} steps of the time {:.1e}, at most {MAX_STEPS:.0e} are \
             allowed; shorten the phases or set fluid.time_step",
            duration / steps
        ),
    })
}

/// Length of a step by the sizes, loads and springs of a scene.
fn chosen_step(scene: &Scene, noise: &ThermalNoise) -> f64 {
    let bodies = || scene.bodies().iter();
    let radii = bodies().map(|body| body.bounding_radius());
    let radius = radii.filter(|a| *a > 0.0).fold(f64::INFINITY, f64::min);
    let range = scene
        .repulsion()
        .map_or(radius, |repulsion| repulsion.range);
    let length = radius.min(range);
    let mobility = 1.0 / (6.0 * PI * scene.viscosity() * radius);
    let diffusion = noise.energy * mobility;
    let diffusive = (DIFFUSION_PART * length).powi(2) / (2.0 * diffusion);
    let slips = bodies()
        .filter_map(|body| body.slip)
        .map(|slip| slip.speed());
    let loads = scene.loads(0.0, &[]).into_iter();
    let speeds = loads.map(|load| load.force.norm() * mobility).chain(slips);
    let motion = MOTION_PART * length / speeds.fold(0.0, f64::max);
    let springs = scene.articulation().passive_joints().filter_map(|joint| {
        let stiffness = joint.passive_drive()?.stiffness;
        // The mobility of two spheres against each other, of an angle by rotation about a centre.
        let of_joint = match joint.kind.length_power() {
            0 => 2.0 / (8.0 * PI * scene.viscosity() * radius.powi(3)),
            _ => 2.0 * mobility,
        };
        Some(RELAXATION_PART / (stiffness * of_joint))
    });
    springs.fold(diffusive.min(motion), f64::min)
}

/// Integrates a phase span in equal steps.
pub(super) fn span(
    evaluator: &mut SpanEvaluator,
    start: &State,
    noise: &ThermalNoise,
) -> Result<SpanResult, Stopped> {
    let mut result = SpanResult::empty(start);
    let steps = noise_steps(evaluator.scene, noise, evaluator.span.duration)?;
    let mut normals = Normals::new(noise.seed, evaluator.span.number);
    for k in 0..steps {
        let part = [0.0, 0.5, 1.0].map(|t| (k as f64 + t) / steps as f64);
        let (piece, solution) = match step(evaluator, &result.end, part, noise, &mut normals) {
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok(step) => step,
        };
        let approximation = Approximation {
            piece,
            solutions: vec![solution],
            weights: vec![1.0],
        };
        result.append(evaluator, approximation, None, None)?;
    }
    Ok(result.with_totals(evaluator))
}

/// One step from a state, with the solution at its middle.
fn step(
    evaluator: &mut SpanEvaluator,
    start: &State,
    [from, middle, to]: [f64; 3],
    noise: &ThermalNoise,
    normals: &mut Normals,
) -> Result<(PathPiece, SpanSolution), SwimError> {
    let set = evaluator.scene.articulation();
    let duration = evaluator.span.duration * (to - from);
    let power = 2.0 * noise.energy / duration;
    let loads = evaluator.random_loads(from, start, power, &mut || normals.next())?;
    let first = evaluator.solve_with_loads(from, start, &loads)?;
    let half = set.advance(start, &(&first.solution.motion * (0.5 * duration)))?;
    let solution = evaluator.solve_with_loads(middle, &half, &loads)?;
    let step = &solution.solution.motion * duration;
    let piece = PathPiece::new(set, start, (from, to), vec![step])?;
    evaluator.check_path(&piece)?;
    Ok((piece, solution))
}

/// Standard normal numbers, the same for a seed and a phase span on all machines.
struct Normals {
    random: fastrand::Rng,
    /// The second number of a pair.
    spare: Option<f64>,
}

impl Normals {
    /// A sequence for each phase span: a run that is resumed has the numbers of one without
    /// interruption.
    fn new(seed: u32, span: usize) -> Self {
        let key = fastrand::Rng::with_seed(u64::from(seed)).u64(..);
        // Multiples of the golden ratio spread consecutive numbers over all bits (Knuth, volume 3,
        // section 6.4).
        let spread = (span as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        Self {
            random: fastrand::Rng::with_seed(key ^ spread).fork(),
            spare: None,
        }
    }

    /// The next number, by the polar method (Marsaglia & Bray 1964, SIAM Review 6, 260).
    fn next(&mut self) -> f64 {
        if let Some(spare) = self.spare.take() {
            return spare;
        }
        loop {
            let [x, y] = [(); 2].map(|()| 2.0 * self.random.f64() - 1.0);
            let square = x * x + y * y;
            if square > 0.0 && square < 1.0 {
                let factor = (-2.0 * square.ln() / square).sqrt();
                self.spare = Some(factor * y);
                return factor * x;
            }
        }
    }
}
