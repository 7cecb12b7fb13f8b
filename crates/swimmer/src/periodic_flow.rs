//! The periodic state of a gait in a fluid with inertia, by cycles one after the other.
//!
//! The state is the velocity of the whole fluid, and what remains of its start decays with the
//! diffusion of vorticity. That needs no search: cycles are run until two in a row have moved the
//! bodies as the ones before.

use std::f64::consts::PI;

use models::{Hydrodynamics, UncorrectedBars};
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use rigid::{JointKind, State};
use scene::{Body, Scene, spans};

use crate::error::SwimError;
use crate::holding_loads::HoldingLoads;
use crate::integrate::{Integrator, Method, UnsteadyScene};
use crate::observer::{Progress, check_interruption};
use crate::outcome::{Interim, Outcome, PeriodicStart};

/// Part of the allowed error of a cycle that may remain of the start.
const TOLERANCE_SHARE: f64 = 0.1;

/// Largest number of cycles. What decays as the power -3/2 of time, the velocity of a free body
/// after an impulse (Hinch 1975), is 1 part in 250 of that of the first cycle after 40.
const MAX_CYCLES: usize = 40;

/// Bound of what remains after `n` cycles, and so of the sum of all later differences between
/// cycles: `2 (n + N) d` after the difference `d` between the cycles `n` and `n - 1`, with the
/// [`memory`] of `N` cycles.
///
/// What decays as `n^(-p)` has differences with the sum `n d / p` at most, and with a mean force
/// `p = 1/2`, the smallest power. While vorticity leaves the swimmer, the rest with a mean force is
/// `exp(n / N) erfc((n / N)^(1/2))`, of whose bound `2 (n + N) d` is the start of an asymptotic
/// series. What decays by a factor `e` in `N` cycles has the sum `N d`, and by the walls of a
/// container nothing decays before vorticity knows of them: its sum is `n d` at most.
fn remainder(cycles: usize, memory: f64, difference: f64) -> f64 {
    2.0 * (cycles as f64 + memory) * difference
}

/// Time in which the slowest swimmer forgets how it began, in unbounded fluid: `ρ L² / μ` of the
/// vorticity around it with the reach `L` from its root, `m / (6π μ a)` of its mass with its
/// largest body, and `6π μ L l² / k` of each spring with `l = L` for those that turn, since a body
/// has no more drag than a sphere around it.
fn memory(scene: &Scene) -> f64 {
    let (set, bodies, viscosity) = (scene.articulation(), scene.bodies(), scene.viscosity());
    let of_linkage = |linkage: &rigid::Linkage| {
        let root = bodies[linkage.root].position;
        let own = || linkage.bodies.iter().map(|&body| &bodies[body]);
        let reach = |body: &Body| (body.position - root).norm() + body.bounding_radius();
        let reach = own().map(reach).fold(0.0, f64::max);
        let largest = own().map(Body::bounding_radius).fold(0.0, f64::max);
        let mass = |body: &Body| body.mass_matrix_by_density().map_or(0.0, |(mass, _)| mass);
        let mass: f64 = own().map(mass).sum();
        let inertia = match largest > 0.0 {
            true => mass / (6.0 * PI * viscosity * largest),
            false => 0.0,
        };
        let springs = set.passive_drives().filter_map(|(joint, drive)| {
            let joint = &set.joints()[joint];
            let lever = match joint.kind {
                JointKind::Turn { .. } => reach,
                _ => 1.0,
            };
            let drag = 6.0 * PI * viscosity * reach * lever * lever + drive.damping;
            // those without stiffness have no periodic state
            let moves = drive.stiffness > 0.0 && linkage.bodies.contains(&joint.body);
            moves.then_some(drag / drive.stiffness)
        });
        let springs = springs.fold(0.0, f64::max);
        scene.fluid_density() * reach * reach / viscosity + inertia + springs
    };
    set.linkages().iter().map(of_linkage).fold(0.0, f64::max)
}

/// The periodic state of the gait of a scene whose fluid has inertia, before its first phase span.
///
/// The bodies start where the last of the cycles before has moved them. Its error bar by what
/// remains of the start is part of the integration error of each cycle of the outcome.
///
/// # Errors
/// [`SwimError::NotPeriodicFlow`] if forty cycles do not suffice; those of
/// [`Scene::check_periodic_flow`]; errors of the integration.
pub(crate) fn periodic_flow(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    progress: &mut dyn Progress,
) -> Result<Interim, SwimError> {
    let unsteady = UnsteadyScene::new(scene)?.ok_or(SwimError::NoFlow)?;
    scene.check_periodic_flow()?;
    let mut integrator =
        Integrator::new(scene, model, Method::Unsteady).with_unsteady_scene(&unsteady)?;
    let set = scene.articulation();
    let memory = memory(scene) / scene.gait().cycle_duration();
    let all = scene.gait().phases.len() * scene.gait().cycles as usize;
    let mut present = Interim::start(scene)?;
    let mut energy = 0.0;
    let mut last_cycle: Option<CycleMotion> = None;
    let mut last_difference: Option<Difference> = None;
    let mut solves = 0;
    let mut cycles = 0;
    let start = loop {
        cycles += 1;
        present.outcome = Interim::start(scene)?.outcome;
        let origin = present.positions(scene, set.initial_shape())?;
        let mut motion = CycleMotion::default();
        let axes = Axes::new(scene, &present.state)?;
        for span in spans(scene.gait(), set.initial_shape())?.take(scene.gait().phases.len()) {
            let result = integrator.span(&span, &present.state, &mut |_, _| {
                check_interruption(progress, 0, all)
            })?;
            present.append(scene, &origin, &span, &result)?;
            let poses = set.place(&present.state, &span.to)?;
            motion.ends.push(PhaseEnd {
                poses: axes.seen(&poses),
                work: present.outcome.work,
                holding: present.outcome.holding.clone(),
            });
        }
        let fluid = present.fluid.as_mut().ok_or(SwimError::NoFlow)?;
        integrator.begin_again(fluid)?;
        let outcome = &mut present.outcome;
        solves += outcome.solves;
        let controls_error = integrator.model().capabilities().controls_error;
        outcome.check_tolerance(scene, controls_error);
        let allowed = TOLERANCE_SHARE * outcome.allowed_error;
        let (now, largest) = energies(outcome);
        let of_energy = (now - energy).abs() / largest;
        energy = now;
        let difference = last_cycle.as_ref().map(|last| Difference {
            energy: of_energy,
            ..motion.difference(last, scene.bodies())
        });
        last_cycle = Some(motion);
        let before = std::mem::replace(&mut last_difference, difference);
        let (Some(difference), Some(before)) = (difference, before) else {
            progress.searched_cycle(cycles, f64::INFINITY, allowed);
            continue;
        };
        // One difference vanishes where what remains of the start changes its sign.
        let difference = difference.larger(&before);
        let remains = |difference| remainder(cycles, memory, difference);
        let start = PeriodicStart {
            cycles,
            residual: difference.motion.displacement,
            energy_residual: difference.energy,
            remainder: UncorrectedBars {
                displacement: remains(difference.motion.displacement),
                rotation: remains(difference.motion.rotation),
                work: remains(difference.motion.work),
                holding: difference.motion.holding.map(remains),
            },
            rotation: present.state.frames[0].rotation,
        };
        progress.searched_cycle(cycles, start.remainder.displacement, allowed);
        let energy_allowed = scene.model().tolerance;
        // A reciprocal stroke in a fluid of little density leads nowhere, and cycles that differ by
        // no more than the error of their solves are the same; what may remain is in the bars.
        let algebraic = outcome.error_estimate.algebraic.unwrap_or(0.0);
        let is_periodic = start.remainder.displacement <= allowed || start.residual <= algebraic;
        if is_periodic && remains(difference.energy) <= energy_allowed {
            break start;
        }
        let is_finite = (start.residual + start.energy_residual).is_finite();
        if cycles == MAX_CYCLES || !is_finite {
            let factor = remains(1.0);
            return Err(SwimError::NotPeriodicFlow {
                cycles,
                residual: start.residual,
                energy_residual: start.energy_residual,
                allowed: allowed / factor,
                energy_allowed: energy_allowed / factor,
            });
        }
    };
    let mut interim = Interim::from_state(scene, present.state)?;
    interim.fluid = present.fluid;
    let outcome = &mut interim.outcome;
    outcome.velocities = present.outcome.velocities;
    outcome.solves = solves;
    outcome.periodic_start = Some(start);
    Ok(interim)
}

/// Kinetic energy at the end of a cycle, and the largest one in it.
fn energies(outcome: &Outcome) -> (f64, f64) {
    let samples = outcome.samples.iter();
    let energies = samples.filter_map(|sample| Some(sample.kinetic_energy?.total()));
    energies.fold((0.0, f64::MIN_POSITIVE), |(_, largest), energy| {
        (energy, energy.max(largest))
    })
}

/// The axes of the linkages at the start of a cycle, and the attitudes of the bodies there.
struct Axes {
    /// Of the linkage of each body.
    of_body: Vec<Isometry3<f64>>,
    attitudes: Vec<UnitQuaternion<f64>>,
}

impl Axes {
    /// Those of the frame of a linkage, and of a lone body with slip, which carries its propulsion
    /// with it, its own.
    fn new(scene: &Scene, state: &State) -> Result<Self, SwimError> {
        let set = scene.articulation();
        let poses = set.place(state, set.initial_shape())?;
        let axes = |&linkage: &usize| {
            let Some([lone]) = (set.linkages().get(linkage)).map(|all| &all.bodies[..]) else {
                return state.frames[linkage];
            };
            match scene.bodies()[*lone].slip {
                Some(_) => poses[*lone],
                None => state.frames[linkage],
            }
        };
        Ok(Self {
            of_body: set.linkage_of().iter().map(axes).collect(),
            attitudes: poses.iter().map(|pose| pose.rotation).collect(),
        })
    }

    /// Places of the bodies and their rotations since the start of the cycle, in these axes.
    fn seen(&self, poses: &[Isometry3<f64>]) -> Vec<Isometry3<f64>> {
        let bodies = poses.iter().zip(&self.of_body).zip(&self.attitudes);
        let seen = bodies.map(|((pose, axes), start)| {
            let place = axes.inverse_transform_point(&pose.translation.vector.into());
            let rotation = pose.rotation * start.inverse();
            let rotation = axes.rotation.inverse() * rotation * axes.rotation;
            Isometry3::from_parts(Translation3::from(place.coords), rotation)
        });
        seen.collect()
    }
}

/// What a cycle has done up to the end of a phase.
struct PhaseEnd {
    /// Of all bodies, as seen from the start of the cycle ([`Axes::seen`]).
    poses: Vec<Isometry3<f64>>,
    work: f64,
    holding: HoldingLoads,
}

/// The motion over a cycle.
#[derive(Default)]
struct CycleMotion {
    ends: Vec<PhaseEnd>,
}

/// Differences between two cycles.
#[derive(Clone, Copy, Default)]
struct Difference {
    motion: UncorrectedBars,
    /// Of the kinetic energies, relative.
    energy: f64,
}

impl CycleMotion {
    /// Differences from another cycle, at the ends of phases the largest; those of displacements
    /// contain rotations times the radii of the bodies.
    fn difference(&self, other: &Self, bodies: &[Body]) -> Difference {
        let mut motion = UncorrectedBars::default();
        for (end, other) in self.ends.iter().zip(&other.ends) {
            for ((a, b), body) in end.poses.iter().zip(&other.poses).zip(bodies) {
                let distance = (a.translation.vector - b.translation.vector).norm();
                let angle = a.rotation.angle_to(&b.rotation);
                let moved = distance + body.bounding_radius() * angle;
                motion.displacement = larger(motion.displacement, moved);
                motion.rotation = larger(motion.rotation, angle);
            }
            motion.work = larger(motion.work, (end.work - other.work).abs());
            let holding = end.holding.largest_differences(&other.holding);
            motion.holding = std::array::from_fn(|k| larger(motion.holding[k], holding[k]));
        }
        Difference {
            motion,
            energy: 0.0,
        }
    }
}

impl Difference {
    /// The larger of two differences, each part for itself.
    fn larger(&self, other: &Self) -> Self {
        let (a, b) = (&self.motion, &other.motion);
        Self {
            motion: UncorrectedBars {
                displacement: larger(a.displacement, b.displacement),
                rotation: larger(a.rotation, b.rotation),
                work: larger(a.work, b.work),
                holding: std::array::from_fn(|k| larger(a.holding[k], b.holding[k])),
            },
            energy: larger(self.energy, other.energy),
        }
    }
}

/// The larger of two numbers; NaN if one is.
fn larger(a: f64, b: f64) -> f64 {
    match a.is_nan() || a > b {
        true => a,
        false => b,
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::*;

    /// `exp(x) erfc(x^(1/2))`, by Simpson's rule for `2 π^(-1/2) ∫ exp(-s² - 2 s x^(1/2)) ds`.
    fn scaled_erfc(x: f64) -> f64 {
        let (parts, end) = (2000, 8.0);
        let step = end / f64::from(parts);
        let value = |k: i32| {
            let s = f64::from(k) * step;
            let weight = match k {
                0 | 2000 => 1.0,
                _ if k % 2 == 0 => 2.0,
                _ => 4.0,
            };
            weight * (-s * s - 2.0 * s * x.sqrt()).exp()
        };
        (0..=parts).map(value).sum::<f64>() * step / 3.0 * 2.0 / PI.sqrt()
    }

    /// Displacements that differ by `rest(n)` from the limit, of which `remainder` sees two.
    fn holds(memory: f64, rest: impl Fn(f64) -> f64) {
        for cycles in 2..60 {
            let n = cycles as f64;
            let bound = remainder(cycles, memory, rest(n - 1.0) - rest(n));
            assert!(rest(n) <= bound * (1.0 + 1e-9), "{memory} {cycles}");
        }
    }

    #[test]
    fn what_remains_is_within_its_bound_for_powers_and_in_containers() {
        for power in [0.5, 1.0, 1.5, 2.5] {
            holds(0.0, |n| n.powf(-power));
        }
        for life in [1.0_f64, 3.0, 20.0] {
            // without walls until vorticity reaches them
            holds(0.0, |n| match n < life {
                true => n.powf(-1.5),
                false => life.powf(-1.5) * (1.0 - n / life).exp(),
            });
        }
    }

    #[test]
    fn bug_what_remains_is_within_its_bound_for_slow_memory() {
        // the error of the rule is h^4 / 180 times 8 π^(-1/2), 6e-12
        assert!((scaled_erfc(1.0) - 0.427_583_576_155_807).abs() < 1e-11);
        for memory in [0.1, 0.5, 3.0, 20.0, 100.0] {
            holds(memory, |n| scaled_erfc(n / memory));
            // of heavy bodies and soft springs
            holds(memory, |n| (-n / memory).exp());
        }
    }

    fn cycle(poses: Vec<Isometry3<f64>>) -> CycleMotion {
        let end = PhaseEnd {
            poses,
            work: 0.0,
            holding: HoldingLoads::default(),
        };
        CycleMotion { ends: vec![end] }
    }

    fn bodies() -> Scene {
        let text = r#"
            bodies = [
                { name = "near", radius = 1, position = [0, 0, 0] },
                { name = "far", radius = 2, position = [10, 0, 0] },
            ]
            links = [{ name = "arm", body = "far", to = "near" }]
        "#;
        Scene::parse(text).unwrap()
    }

    /// A linkage that turns by 0.01 more moves its far end by 0.1.
    #[test]
    fn bug_differences_of_cycles_have_the_arms_of_linkages() {
        let scene = bodies();
        let turned = |angle: f64| {
            let rotation = UnitQuaternion::from_scaled_axis(angle * Vector3::z());
            let far = rotation * Vector3::new(10.0, 0.0, 0.0);
            let near = Isometry3::from_parts(Translation3::identity(), rotation);
            cycle(vec![
                near,
                Isometry3::from_parts(Translation3::from(far), rotation),
            ])
        };
        let difference = turned(0.01).difference(&turned(0.0), scene.bodies());
        let exact = 20.0 * (0.005_f64).sin() + 2.0 * 0.01;
        let [found, angle] = [difference.motion.displacement, difference.motion.rotation];
        assert!((found - exact).abs() < 1e-12, "{found}");
        assert!((angle - 0.01).abs() < 1e-12, "{angle}");
    }

    #[test]
    fn bug_cycles_that_are_not_finite_are_not_periodic() {
        let scene = bodies();
        let mut poses = vec![Isometry3::identity(); 2];
        let before = cycle(poses.clone());
        poses[0].translation.vector.x = f64::NAN;
        let difference = cycle(poses).difference(&before, scene.bodies());
        assert!(difference.motion.displacement.is_nan());
        let last = difference.larger(&Difference::default());
        assert!(last.motion.displacement.is_nan());
        assert!(
            Difference::default()
                .larger(&last)
                .motion
                .displacement
                .is_nan()
        );
    }
}
