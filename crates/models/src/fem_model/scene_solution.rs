//! Finite-element solutions in the scene's units.

use nalgebra::Vector3;
use rigid::{Articulation, FlowSolution};
use stokes::Solution;

use crate::error::ModelError;
use crate::error_estimate::ErrorEstimate;
use crate::scaled_scene::ScaledScene;
use crate::solution::{BodySolution, InstantaneousSolution};

/// Converts a solution to the scene's units, with `flow` in place of its own.
///
/// `surfaced` are the bodies with surfaces.
///
/// `container_error` is the relative error of velocities caused by the container.
///
/// # Errors
/// A solution for another set of bodies.
pub fn to_scene(
    scaled: &ScaledScene,
    surfaced: impl Iterator<Item = usize>,
    solution: &Solution,
    flow: &FlowSolution,
    container_error: f64,
) -> Result<InstantaneousSolution, ModelError> {
    let (scale, set) = (&scaled.scale, &scaled.set);
    let mut bodies = vec![BodySolution::default(); set.kinds().len()];
    let layout = set.velocity_layout();
    let at = |first: usize| Vector3::from_fn(|axis, _| flow.generalised[first + axis]);
    for (body, entry) in bodies.iter_mut().enumerate() {
        entry.velocity = scale.velocity_to_scene(at(layout.bodies()[body]));
        entry.angular_velocity = flow.state.spins[body];
    }
    for (number, body) in surfaced.enumerate() {
        let part =
            |first: usize| Vector3::from_fn(|axis, _| flow.forces[6 * number + first + axis]);
        bodies[body].force = scale.force_to_scene(part(0));
        bodies[body].torque = scale.torque_to_scene(part(3));
    }
    let link_forces = (0..set.links().len())
        .map(|link| Ok(scale.force_to_scene(flow.link_force(link)?)))
        .collect::<Result<_, ModelError>>()?;
    let speed = largest_norm(bodies.iter().map(|b| b.velocity));
    let power = bodies.iter().map(BodySolution::power).sum::<f64>().abs();
    let bars = |size: f64| ErrorEstimate {
        container: Some(container_error * size),
        // The equations are those of Stokes flow without approximation.
        model: Some(0.0),
        algebraic: Some(solution.algebraic_error * size),
        ..ErrorEstimate::default()
    };
    Ok(InstantaneousSolution {
        dofs: solution.dofs,
        error_estimate: bars(speed),
        power_error: bars(power),
        checks: solution.checks,
        solver: solution.solver.clone(),
        seconds: solution.seconds,
        ..InstantaneousSolution::new(bodies, link_forces, scale.motion_to_scene(&flow.state))
    })
}

/// Adds a velocity to that of all bodies and of the fluid, which changes no force.
pub fn shift(set: &Articulation, correction: Vector3<f64>, flow: &mut FlowSolution) {
    flow.velocity.iter_mut().for_each(|u| *u += correction);
    let layout = set.velocity_layout();
    for body in 0..set.kinds().len() {
        let mut velocity = flow.generalised.fixed_rows_mut::<3>(layout.bodies()[body]);
        velocity += correction;
    }
    for frame in &mut flow.state.frames {
        frame.linear += correction;
    }
    for body in 0..flow.bodies.len() / 6 {
        let mut velocity = flow.bodies.fixed_rows_mut::<3>(6 * body);
        velocity += correction;
    }
}

fn largest_norm(vectors: impl Iterator<Item = Vector3<f64>>) -> f64 {
    vectors.fold(0.0, |m, v| m.max(v.norm()))
}
