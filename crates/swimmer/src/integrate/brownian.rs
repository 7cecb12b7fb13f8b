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
//! 69, 1527; Delong, Balboa Usabiaga & Donev 2015, J. Chem. Phys. 143, 144107). For this `Q` must
//! be conjugate to coordinates whose meaning does not depend on `q`: forces on the bodies of a
//! linkage would be projected onto its motions twice, at different places, and leave a drift of
//! their own. On rotations both steps are exponentials in the laboratory axes, to which `div N`
//! refers. In equilibrium all positions, all attitudes and all values of joints are then equally
//! probable but for the Boltzmann factor of their energy.

use std::f64::consts::PI;

use rigid::State;
use scene::{Background, Scene, ThermalNoise};

use super::piece::PathPiece;
use super::result::{Approximation, SpanResult, Stopped};
use super::span_evaluator::{SpanEvaluator, SpanSolution};
use super::step_size::largest_varying_loads;
use crate::error::SwimError;

/// Root mean square displacement of the smallest body in a step, in each direction, over its radius
/// or the range of the repulsion.
const DIFFUSION_PART: f64 = 0.05;

/// Displacement of a body by its load or slip in a step, over the same length; angle by its torque
/// or the background flow.
const MOTION_PART: f64 = 0.2;

/// Length of a step over the relaxation time of a spring: the variance of its value is then wrong
/// by a quarter of the square of that.
const RELAXATION_PART: f64 = 0.1;

/// Smallest number of steps in a phase, and in a period of loads, which the midpoint method follows
/// with an error of the order two.
const LEAST_STEPS: f64 = 20.0;

/// Largest number of steps in a phase times that of bodies: each keeps two to five kilobytes.
const MAX_STEPS: f64 = 1e6;

/// Number of equal steps in a phase of this duration.
///
/// They have at most the length `fluid.time_step`. Without that key they follow from the scene
/// alone, and not from the path, which would distort the statistics: see the constants here.
/// Diffusion is that of the smallest sphere alone.
///
/// # Errors
/// [`SwimError::NotApplicable`] for more than a million steps of one body.
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
    let allowed = MAX_STEPS / scene.bodies().len() as f64;
    if steps <= allowed {
        return Ok(steps as usize);
    }
    Err(SwimError::NotApplicable {
        place: scene.place("fluid.thermal_energy"),
        problem: format!(
            "a phase would take {steps:.1e} steps of the time {:.1e}, at most {allowed:.1e} are \
             allowed for this number of bodies; shorten the phases or set fluid.time_step",
            duration / steps
        ),
    })
}

/// Length of a step by the sizes, loads, flows and springs of a scene.
fn chosen_step(scene: &Scene, noise: &ThermalNoise) -> f64 {
    let bodies = || scene.bodies().iter();
    let radii = bodies().map(|body| body.bounding_radius());
    let radius = radii.filter(|a| *a > 0.0).fold(f64::INFINITY, f64::min);
    let range = scene
        .repulsion()
        .map_or(radius, |repulsion| repulsion.range);
    let length = radius.min(range);
    let mobility = 1.0 / (6.0 * PI * scene.viscosity() * radius);
    let rotational = 0.75 * mobility / radius.powi(2);
    let diffusion = 2.0 * noise.energy * mobility / (DIFFUSION_PART * length).powi(2);
    let loads = bodies().flat_map(|body| {
        let [force, torque] = largest_varying_loads(scene, body);
        let force = body.total_force().norm() + force;
        let torque = body.torque.norm() + torque;
        [force * mobility / length, torque * rotational]
    });
    let slips = bodies().filter_map(|body| body.slip);
    let slips = slips.map(|slip| slip.speed() / length);
    let shear = match scene.background() {
        Some(Background::Linear { gradient, .. }) => gradient.norm(),
        _ => 0.0,
    };
    let motions = loads.chain(slips).chain([shear]);
    let springs = scene.articulation().passive_joints().filter_map(|joint| {
        let stiffness = joint.passive_drive()?.stiffness;
        // Of two spheres against each other, or turning about their centres.
        let of_joint = match joint.kind.length_power() {
            0 => 2.0 * rotational,
            _ => 2.0 * mobility,
        };
        Some(stiffness * of_joint / RELAXATION_PART)
    });
    let periods = scene.shortest_period().map(|period| LEAST_STEPS / period);
    let rates = motions.map(|rate| rate / MOTION_PART);
    let fastest = rates
        .chain(springs)
        .chain(periods)
        .fold(diffusion, f64::max);
    1.0 / fastest
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
        let normal = &mut || normals.next();
        let (piece, solution) = match step(evaluator, &result.end, part, noise, normal) {
            Err(error) => return Err(result.stopped(evaluator, error)),
            Ok(step) => step,
        };
        let approximation = Approximation::new(piece, vec![solution], vec![1.0]);
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
    normal: &mut dyn FnMut() -> f64,
) -> Result<(PathPiece, SpanSolution), SwimError> {
    let set = evaluator.scene.articulation();
    let duration = evaluator.span.duration * (to - from);
    let power = 2.0 * noise.energy / duration;
    let loads = evaluator.random_loads(from, start, power, normal)?;
    let first = evaluator.solve_with_loads(from, start, &loads)?;
    let half = set.advance(start, &(&first.solution.motion * (0.5 * duration)))?;
    let solution = evaluator.solve_with_loads(middle, &half, &loads)?;
    let step = &solution.solution.motion * duration;
    let piece = PathPiece::new(set, start, (from, to), vec![step])?;
    evaluator.check_path(&piece)?;
    Ok((piece, solution))
}

/// Standard normal numbers, the same for a seed and a phase span of one version of the program.
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

#[cfg(test)]
mod tests {
    use super::*;
    use models::{Configuration, Hydrodynamics, Query, SphereModel, SpheresModel};
    use nalgebra::DVector;
    use rigid::{Articulation, StateVelocity};
    use scene::{PhaseSpan, spans};

    const ENERGY: f64 = 0.7;

    fn scene(text: &str) -> Scene {
        let gait = "[[gait.phases]]\nduration = 1\n";
        Scene::parse(&format!("fluid.thermal_energy = {ENERGY}\n{text}\n{gait}")).unwrap()
    }

    fn only_span(scene: &Scene) -> PhaseSpan {
        let mut all = spans(scene.gait(), scene.articulation().initial_shape()).unwrap();
        all.next().unwrap()
    }

    /// The coordinates of the state in the order of `Articulation::state_velocities`.
    fn coordinates(set: &Articulation, motion: &StateVelocity) -> DVector<f64> {
        let mut vectors = Vec::new();
        for (linkage, frame) in set.linkages().iter().zip(&motion.frames) {
            vectors.push(frame.linear);
            if linkage.bodies.len() > 1 {
                vectors.push(frame.angular);
            }
        }
        let own = (0..set.kinds().len()).filter(|&body| set.has_own_attitude(body));
        vectors.extend(own.map(|body| motion.spins[body]));
        let entries = vectors.iter().flatten().chain(&motion.joints).copied();
        DVector::from_vec(entries.collect())
    }

    /// The first step of length `dt` from a state, in coordinates of the state, for these normal
    /// numbers (zeros beyond them), and how many there are.
    fn first_step(
        scene: &Scene,
        kind: SphereModel,
        (state, dt): (&State, f64),
        normals: &[f64],
    ) -> (DVector<f64>, usize) {
        let mut model = SpheresModel::new(scene, kind).unwrap();
        let span = only_span(scene);
        let mut observe = |_: &SpanSolution, _: &dyn Hydrodynamics| Ok(());
        let mut evaluator = SpanEvaluator::new(scene, &mut model, &span, None, &mut observe);
        let part = [0.0, 0.5, 1.0].map(|t| t * dt / span.duration);
        let mut taken = 0;
        let normal = &mut || {
            taken += 1;
            normals.get(taken - 1).copied().unwrap_or(0.0)
        };
        let noise = scene.noise().unwrap();
        let (piece, _) = step(&mut evaluator, state, part, noise, normal).unwrap();
        (coordinates(scene.articulation(), &piece.step()), taken)
    }

    /// The mean of a step over the noise: exact to third order in the normal numbers, which a
    /// quadrature with two points per number integrates exactly.
    fn mean_step(scene: &Scene, kind: SphereModel, dt: f64) -> DVector<f64> {
        let state = scene.initial_state();
        let (still, count) = first_step(scene, kind, (&state, dt), &[]);
        let mut mean = 0.0 * still;
        for one in 0..count {
            for sign in [-1.0, 1.0] {
                let mut normals = vec![0.0; count];
                normals[one] = sign * (count as f64).sqrt();
                mean += first_step(scene, kind, (&state, dt), &normals).0 / (2 * count) as f64;
            }
        }
        mean
    }

    /// `k_B T div N` by central differences of mobilities.
    fn drift(scene: &Scene, kind: SphereModel) -> DVector<f64> {
        let set = scene.articulation();
        let mut model = SpheresModel::new(scene, kind).unwrap();
        let (places, count) = (set.state_velocities(), set.velocity_layout().len());
        let unit = |place: usize, size: f64| {
            let mut q = DVector::zeros(count);
            q[place] = size;
            q
        };
        let rates = [vec![0.0; set.joints().len()]];
        let mut column = |place: usize, size: f64| {
            let motion = set.state_velocity(unit(place, size).as_slice()).unwrap();
            let state = set.advance(&scene.initial_state(), &motion).unwrap();
            let query = Query::new(Configuration::new(&state, set.initial_shape()), &rates);
            let load = unit(place, 1.0);
            let solution = model
                .solve(&query.with_random_loads(&load))
                .unwrap()
                .remove(0);
            coordinates(set, &solution.motion)
        };
        let mut sum = DVector::zeros(places.len());
        for &place in &places {
            sum += (column(place, 1e-4) - column(place, -1e-4)) * (ENERGY / 2e-4);
        }
        sum
    }

    const CHAIN: &str = r#"
bodies = [
    { name = "a", radius = 1, position = [0, 0, 3] },
    { name = "b", radius = 0.7, position = [4, 0, 3] },
    { name = "c", radius = 1.3, position = [7, 2, 4] },
]
[[links]]
name = "ab"
body = "b"
to = "a"
drive = "free"
[[links]]
name = "bc"
body = "c"
to = "b"
"#;

    #[test]
    fn the_mean_of_a_step_is_the_drift_by_the_divergence_of_the_mobility() {
        let sphere = "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 1.6] }]";
        let wall = "domain.kind = \"wall\"\n";
        let hinge = "joint = \"hinge\"\naxis = [0, 1, 0]\npivot = [5, 0, 3]\ndrive = \"free\"";
        let ball = "joint = \"ball\"\npivot = [5, 0, 3]";
        for (text, kind) in [
            (format!("{wall}{sphere}"), SphereModel::Rpy),
            (format!("{wall}{sphere}"), SphereModel::Multipole(1e-3)),
            (format!("{CHAIN}{hinge}"), SphereModel::Rpy),
            (format!("{CHAIN}{ball}"), SphereModel::Rpy),
            (
                format!("{wall}{CHAIN}{hinge}"),
                SphereModel::Multipole(1e-2),
            ),
            (
                // Slides of arms that turn freely are refused.
                format!(
                    "gait.arms = \"free\"\n{}",
                    CHAIN.replace("drive = \"free\"", "")
                ),
                SphereModel::Rpy,
            ),
        ] {
            let scene = scene(&text);
            let dt = 1e-4;
            let found = mean_step(&scene, kind, dt) / dt;
            let exact = drift(&scene, kind);
            assert!(exact.amax() > 1e-3, "no drift: {text}");
            // Steps of root mean square sqrt(2 k_B T N dt) = 0.003 change the mobility by this part
            // of the distances, and the remainder is of second order.
            let error = (&found - &exact).amax() / exact.amax();
            assert!(
                error < 1e-3,
                "{kind:?}: {error:.1e}, {text}\n{found}{exact}"
            );
        }
    }

    /// Two spheres far apart on a spring are a linear system: a step is `x <- a x + sum_k b_k W_k`,
    /// with the variance `sum_k b_k² / (1 - a²)` in equilibrium.
    #[test]
    fn a_spring_has_half_the_thermal_energy() {
        let scene = scene(
            "bodies = [\n{ name = \"a\", radius = 1, position = [0, 0, 0] },\n\
             { name = \"b\", radius = 1, position = [1e5, 0, 0] },\n]\n[[links]]\nname = \"ab\"\n\
             body = \"b\"\nto = \"a\"\ndrive = \"spring\"\nstiffness = 3\n",
        );
        let kind = SphereModel::Rpy;
        let rest = scene.initial_state();
        let rate = 3.0 * 2.0 / (6.0 * PI);
        for y in [0.5, 0.1] {
            let dt = y / rate;
            let after = |value: f64, normals: &[f64]| {
                let mut state = rest.clone();
                state.joints[0] += value;
                let (step, count) = first_step(&scene, kind, (&state, dt), normals);
                (value + step[step.len() - 1], count)
            };
            let a = 0.5 * (after(1.0, &[]).0 - after(-1.0, &[]).0);
            let noise = (0..after(0.0, &[]).1).map(|one| {
                let mut normals = vec![0.0; one + 1];
                normals[one] = 1.0;
                after(0.0, &normals).0.powi(2)
            });
            let variance = noise.sum::<f64>() / (1.0 - a * a);
            // The same for the midpoint rule on a linear equation.
            let of_method = (1.0 - y + y * y / 4.0) / (1.0 - y + y * y / 2.0 - y.powi(3) / 8.0);
            let error = variance / (ENERGY / 3.0) - of_method;
            // Interactions at this distance are 1.5e-5 of the mobility.
            assert!(error.abs() < 1e-4, "{y}: {error:.1e}");
            assert!((of_method - 1.0).abs() < 0.5 * y * y);
        }
    }

    #[test]
    fn normal_numbers_have_their_moments_and_differ_between_seeds_and_phases() {
        let count = 20_000;
        let numbers = |seed: u32, span: usize| -> Vec<f64> {
            let mut normals = Normals::new(seed, span);
            (0..count).map(|_| normals.next()).collect()
        };
        let own = numbers(1, 0);
        assert_eq!(own, numbers(1, 0));
        let n = count as f64;
        // Four standard deviations of means of x^k: sqrt(1/n), sqrt(2/n), sqrt(96/n).
        let moment = |power: i32| own.iter().map(|x| x.powi(power)).sum::<f64>() / n;
        for (power, exact, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (4, 3.0, 96.0_f64)] {
            let error = moment(power) - exact;
            assert!(
                error.abs() < 4.0 * (variance / n).sqrt(),
                "{power}: {error}"
            );
        }
        for other in [numbers(2, 0), numbers(1, 1), numbers(2, 1)] {
            let product = own.iter().zip(&other).map(|(a, b)| a * b).sum::<f64>() / n;
            assert!(product.abs() < 4.0 / n.sqrt(), "{product}");
        }
    }

    #[test]
    fn steps_follow_from_sizes_springs_and_the_key() {
        let sphere = "bodies = [{ name = \"a\", radius = 2, position = [0, 0, 0] }]";
        let scene = scene(sphere);
        let noise = scene.noise().unwrap();
        // (0.05 a)² / (2 D) with D = k_B T / (6π μ a)
        let step = 0.01 / (2.0 * ENERGY / (12.0 * PI));
        let exact = (100.0 / step).ceil() as usize;
        assert_eq!(noise_steps(&scene, noise, 100.0).unwrap(), exact);
        assert_eq!(noise_steps(&scene, noise, 1e-3).unwrap(), 20);
        let text = format!("fluid = {{ thermal_energy = 1, time_step = 0.1 }}\n{sphere}");
        let given = Scene::parse(&text).unwrap();
        let steps = |duration| noise_steps(&given, given.noise().unwrap(), duration);
        assert_eq!([steps(0.3).unwrap(), steps(0.31).unwrap()], [3, 4]);
        let error = steps(1e6).unwrap_err().to_string();
        assert!(
            error.contains("1.0e7 steps") && error.contains("fluid.time_step"),
            "{error}"
        );
    }

    /// A moment along the field has no torque at the start, nor has a load that starts at zero.
    #[test]
    fn bug_steps_followed_from_loads_at_the_start_alone() {
        let body = |keys: &str| {
            format!("bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0], {keys} }}]")
        };
        let field = "field.mean = [1, 0, 0]\n";
        let cases = [
            format!("{field}{}", body("moment = [4000, 0, 0]")),
            body("torque = { amplitude = [4000, 0, 0], period = 100 }"),
        ];
        for text in cases {
            let scene = scene(&text);
            let steps = noise_steps(&scene, scene.noise().unwrap(), 1.0).unwrap();
            // Angles of 0.2 by a torque of 4000 over 8π.
            let exact = (4000.0 / (8.0 * PI) / 0.2).ceil() as usize;
            assert_eq!(steps, exact);
        }
    }
}
