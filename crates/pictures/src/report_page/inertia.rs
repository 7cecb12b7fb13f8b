//! Kinetic energies and forces by added mass of a run in a fluid with inertia.

use nalgebra::Vector3;
use scene::{Body, Scene};

use crate::numbers::{vector_with_bar, with_uncertainty};
use crate::plot::direction_name;
use swimmer::{Outcome, Sample};

/// Part of a phase at its start whose forces are not drawn: after a jump of the velocities they
/// begin like the reciprocal of the first step, which would be all that the curves show.
const START_OF_PHASE: f64 = 0.02;

/// Components below this ratio to the largest force are rounding.
const ROUNDING: f64 = 1e-12;

/// Curves of one plot.
pub(super) struct Curves {
    pub title: String,
    pub unit: &'static str,
    pub names: Vec<String>,
    /// Times, with a value for each name.
    pub values: Vec<(f64, Vec<f64>)>,
}

/// Kinetic energies over time, and forces by added mass along the direction of the largest; empty
/// for fluids without inertia.
pub(super) fn curves(scene: &Scene, outcome: &Outcome) -> Vec<Curves> {
    let energy = |sample: &Sample| {
        let energy = sample.kinetic_energy?;
        Some((sample.time, vec![energy.fluid, energy.bodies]))
    };
    let energies = Curves {
        title: "kinetic energy".to_owned(),
        unit: "energy (the scene's unit)",
        names: ["fluid", "bodies"].map(str::to_owned).into(),
        values: outcome.samples.iter().filter_map(energy).collect(),
    };
    let forces = |sample: &Sample| -> Option<(f64, Vec<Vector3<f64>>)> {
        let all = &sample.added_mass.as_ref()?.bodies;
        let forces = with_surface(scene).filter_map(|(k, _)| Some(all.get(k)?[0]));
        let forces = forces.collect();
        (!is_at_start(scene, sample)).then_some((sample.time, forces))
    };
    let forces: Vec<_> = outcome.samples.iter().filter_map(forces).collect();
    let all = forces.iter().flat_map(|(_, forces)| forces);
    let largest = all.fold(Vector3::zeros(), |largest: Vector3<f64>, force| {
        if force.norm() > largest.norm() {
            *force
        } else {
            largest
        }
    });
    // The sign for which the largest component is positive, as for displacements.
    let along = largest.try_normalize(0.0).unwrap_or_else(Vector3::x);
    let along = along * along[along.iamax()].signum();
    let component = |(time, forces): (f64, Vec<Vector3<f64>>)| {
        (time, forces.iter().map(|force| force.dot(&along)).collect())
    };
    let forces = Curves {
        title: format!("forces by added mass along {}", direction_name(&along)),
        unit: "force on the fluid (the scene's unit)",
        names: with_surface(scene)
            .map(|(_, body)| body.name.clone())
            .collect(),
        values: forces.into_iter().map(component).collect(),
    };
    let mut all = vec![energies, forces];
    all.retain(|curves| !curves.values.is_empty());
    all
}

/// Numbers of the bodies that have a surface, and the bodies.
fn with_surface(scene: &Scene) -> impl Iterator<Item = (usize, &Body)> {
    let bodies = scene.bodies().iter().enumerate();
    bodies.filter(|(_, body)| body.shape.has_surface())
}

/// Whether a sample is in the first part of its phase.
fn is_at_start(scene: &Scene, sample: &Sample) -> bool {
    let gait = scene.gait();
    let (cycle, phase) = (
        sample.span / gait.phases.len(),
        sample.span % gait.phases.len(),
    );
    let before = gait.phases[..phase].iter().map(|phase| phase.duration);
    let start = cycle as f64 * gait.cycle_duration() + before.sum::<f64>();
    sample.time < start + START_OF_PHASE * gait.phases[phase].duration
}

/// Rows of the table of results: label, value with its bar, unit.
pub(super) fn results(scene: &Scene, outcome: &Outcome) -> Vec<(String, String, &'static str)> {
    let mut rows = Vec::new();
    if let Some(energy) = outcome.kinetic_energy() {
        let bars = energy.mesh_error.unwrap_or_default();
        let parts = [("fluid", energy.fluid), ("bodies", energy.bodies)];
        for ((name, value), bar) in parts.into_iter().zip(bars) {
            let label = format!("Kinetic energy of the {name} at the end");
            rows.push((label, with_uncertainty(value, bar), "energy"));
        }
    }
    let Some(added_mass) = outcome.added_mass() else {
        return rows;
    };
    let bar = added_mass.mesh_error.map(|[force, _]| force);
    let forces: Vec<&Vector3<f64>> = added_mass.bodies.iter().map(|[force, _]| force).collect();
    let largest = forces.iter().fold(0.0_f64, |m, force| m.max(force.norm()));
    for (number, body) in with_surface(scene) {
        let Some(force) = forces.get(number) else {
            continue;
        };
        let label = format!("Force by added mass of {} at the end", body.name);
        let value = vector_with_bar((**force).into(), bar, ROUNDING * largest);
        rows.push((label, value, "force"));
    }
    rows
}
