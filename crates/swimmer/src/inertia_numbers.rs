//! Dimensionless numbers of a motion in a fluid with inertia.

use std::f64::consts::TAU;

use models::BodySolution;
use scene::Scene;

use crate::outcome::Outcome;

/// How much the inertia of the fluid matters.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InertiaNumbers {
    /// Reynolds number `ρ (|U| + a |ω|) a / μ`: the largest of a body with the radius `a`.
    pub reynolds: f64,
    /// Frequency parameter `ρ Ω a² / μ` of the largest body, with a cycle of the gait, or the
    /// shortest period of loads, per `2π / Ω`; none without both.
    pub frequency: Option<f64>,
}

impl InertiaNumbers {
    /// The numbers of a run; `None` if its fluid has no inertia.
    pub fn new(scene: &Scene, outcome: &Outcome) -> Option<Self> {
        let samples = outcome.samples.iter();
        let velocities = samples.filter_map(|sample| sample.bodies.as_deref());
        (scene.inertia().is_kept()).then(|| Self::of_velocities(scene, velocities))
    }

    /// The numbers of a motion with these velocities.
    pub(crate) fn of_velocities<'a>(
        scene: &Scene,
        velocities: impl Iterator<Item = &'a [BodySolution]>,
    ) -> Self {
        let per_viscosity = scene.fluid_density() / scene.viscosity();
        let reynolds = velocities
            .flat_map(|bodies| scene.bodies().iter().zip(bodies))
            .map(|(body, motion)| {
                let radius = body.bounding_radius();
                let speed = motion.velocity.norm() + radius * motion.angular_velocity.norm();
                per_viscosity * speed * radius
            })
            .fold(0.0, f64::max);
        let radii = scene.bodies().iter().map(scene::Body::bounding_radius);
        let radius = radii.fold(0.0, f64::max);
        let period = match scene.gait().phases.is_empty() {
            true => scene.shortest_period(),
            false => Some(scene.gait().cycle_duration()),
        };
        Self {
            reynolds,
            frequency: period.map(|period| per_viscosity * TAU / period * radius * radius),
        }
    }
}
