//! The periodic state of a gait in a fluid with inertia, by cycles one after the other.
//!
//! The state is the velocity of the whole fluid, and what remains of its start decays with the
//! diffusion of vorticity. That needs no search: cycles are run until one moves the bodies as the
//! cycle before.

use models::Hydrodynamics;
use rigid::{Articulation, State};
use scene::{Scene, SceneError, spans};

use crate::error::SwimError;
use crate::integrate::{Integrator, Method, ObserveSolution, UnsteadyScene};
use crate::outcome::{Interim, Outcome, PeriodicStart};

/// Part of the allowed error of a cycle that may remain of the start.
const TOLERANCE_SHARE: f64 = 0.1;

/// Largest number of cycles. What decays as the power -3/2 of time, the velocity of a free body
/// after an impulse (Hinch 1975), is 1 part in 250 of that of the first cycle after 40.
const MAX_CYCLES: usize = 40;

/// Bound of the sum of all later differences between cycles, `n d` after the difference `d` between
/// the cycles `n` and `n - 1`.
///
/// Differences of what decays as `n^(-p)` have the sum `n d / p` at most. Nothing in a fluid decays
/// by a smaller power than `p = 1`: the velocity of a body after an impulse has `p = 3/2`. In a
/// container the slowest part decays by a factor `e` in `N` cycles, and its differences have the
/// sum `N d`; until `n = N` vorticity does not know of the walls and decays as without them.
fn remainder(cycles: usize, residual: f64) -> f64 {
    cycles as f64 * residual
}

/// The periodic state of the gait of a scene whose fluid has inertia, before its first phase span.
///
/// The bodies start where the last of the cycles before has moved them. Its error bar by what
/// remains of the start is part of the integration error of the outcome.
///
/// # Errors
/// [`SwimError::NotPeriodicFlow`] if forty cycles do not suffice; a gait that is not closed; errors
/// of the integration.
pub(crate) fn periodic_flow(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    observe: ObserveSolution,
) -> Result<Interim, SwimError> {
    let unsteady = UnsteadyScene::new(scene)?.ok_or(SwimError::NoFlow)?;
    check_closed(scene)?;
    let mut integrator =
        Integrator::new(scene, model, Method::Unsteady).with_unsteady_scene(&unsteady)?;
    let set = scene.articulation();
    let mut present = Interim::start(scene)?;
    let mut energy = 0.0;
    let mut last: Option<CycleMotion> = None;
    let mut solves = 0;
    let mut found = None;
    for cycles in 1..=MAX_CYCLES {
        let before = present.state.clone();
        present.outcome = Interim::start(scene)?.outcome;
        let origin = present.positions(scene, set.initial_shape())?;
        for span in spans(scene.gait(), set.initial_shape())?.take(scene.gait().phases.len()) {
            let result = integrator.span(&span, &present.state, observe)?;
            present.append(scene, &origin, &span, &result)?;
        }
        let fluid = present.fluid.as_mut().ok_or(SwimError::NoFlow)?;
        integrator.begin_again(fluid)?;
        let outcome = &mut present.outcome;
        solves += outcome.solves;
        let controls_error = integrator.model().capabilities().controls_error;
        outcome.check_tolerance(scene, controls_error);
        let allowed = TOLERANCE_SHARE * outcome.allowed_error;
        let (now, largest) = energies(outcome);
        let energy_residual = (now - energy).abs() / largest;
        energy = now;
        let motion = CycleMotion::new(&before, &present.state);
        let Some(last) = last.replace(motion.clone()) else {
            continue;
        };
        let residual = motion.difference(&last, scene);
        let start = PeriodicStart {
            cycles,
            residual,
            energy_residual,
            remainder: remainder(cycles, residual),
            rotation: present.state.frames[0].rotation,
        };
        let of_energy = remainder(cycles, energy_residual);
        if start.remainder <= allowed && of_energy <= scene.model().tolerance {
            found = Some(start);
            break;
        }
        if cycles == MAX_CYCLES {
            return Err(SwimError::NotPeriodicFlow {
                cycles,
                residual,
                energy_residual,
                allowed: allowed / cycles as f64,
                energy_allowed: scene.model().tolerance / cycles as f64,
            });
        }
    }
    let mut interim = Interim::from_state(scene, present.state)?;
    interim.fluid = present.fluid;
    let outcome = &mut interim.outcome;
    outcome.velocities = present.outcome.velocities;
    outcome.solves = solves;
    if let (Some(start), Some(error)) = (found, &mut outcome.accumulated_integration_error) {
        error.uncertainty += f64::from(scene.gait().cycles) * start.remainder;
    }
    outcome.periodic_start = found;
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

/// Refuses a gait whose cycle does not end with the shape at its start.
fn check_closed(scene: &Scene) -> Result<(), SwimError> {
    let shape = scene.articulation().initial_shape();
    let cycle = spans(scene.gait(), shape)?.take(scene.gait().phases.len());
    let end = cycle.last().map_or(shape.to_vec(), |span| span.to);
    let Some((joint, change)) = scene.shape_changes(shape, &end).first().copied() else {
        return Ok(());
    };
    let key = "gait.periodic".to_owned();
    Err(SwimError::Scene(SceneError::BadValue {
        place: scene.place(&key),
        problem: format!(
            "needs a gait that closes: over a cycle the value of \"{}\" changes by {change}; add a \
             phase that brings it back",
            scene.articulation().joints()[joint].name
        ),
        key,
    }))
}

/// The motion over a cycle, in the axes of the bodies at its start.
#[derive(Clone)]
struct CycleMotion {
    frames: Vec<nalgebra::Isometry3<f64>>,
    /// Changes of the values of passive joints.
    joints: Vec<f64>,
}

impl CycleMotion {
    fn new(before: &State, after: &State) -> Self {
        let frames = before.frames.iter().zip(&after.frames);
        let joints = before.joints.iter().zip(&after.joints);
        Self {
            frames: frames
                .map(|(before, after)| before.inverse() * after)
                .collect(),
            joints: joints.map(|(before, after)| after - before).collect(),
        }
    }

    /// Largest displacement of a body by which this motion differs from another; passive joints
    /// that do not return count with their whole change.
    fn difference(&self, other: &Self, scene: &Scene) -> f64 {
        let set: &Articulation = scene.articulation();
        let radii = scene.bodies().iter().map(scene::Body::bounding_radius);
        let radius = radii.fold(0.0, f64::max);
        let of_frames = self.frames.iter().zip(&other.frames).map(|(a, b)| {
            let distance = (a.translation.vector - b.translation.vector).norm();
            distance + radius * a.rotation.angle_to(&b.rotation)
        });
        let joints = set.passive_drives().zip(&self.joints);
        let of_joints = joints.map(|((joint, _), change)| set.arm_displacement(joint, *change));
        of_frames.chain(of_joints).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Displacements `1 + n^(-p)` in the cycle `n`, of which `remainder` sees two.
    #[test]
    fn what_remains_is_within_its_bound_for_powers_and_exponentials() {
        for cycles in 2..60 {
            let n = cycles as f64;
            let rest = [1.0_f64, 1.5, 2.5]
                .map(|p| Box::new(move |n: f64| n.powf(-p)) as Box<dyn Fn(f64) -> f64>)
                .into_iter()
                .chain([1.0_f64, 3.0, 20.0].map(|life| {
                    // without walls until vorticity reaches them
                    Box::new(move |n: f64| match n < life {
                        true => n.powf(-1.5),
                        false => life.powf(-1.5) * (1.0 - n / life).exp(),
                    }) as Box<dyn Fn(f64) -> f64>
                }));
            for (number, rest) in rest.enumerate() {
                let bound = remainder(cycles, rest(n - 1.0) - rest(n));
                assert!(rest(n) <= bound * (1.0 + 1e-12), "{number} {cycles}");
            }
        }
    }
}
