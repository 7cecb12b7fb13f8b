//! Dimensionless numbers of a run in a fluid with inertia.

use std::f64::consts::TAU;

use scene::Scene;

use crate::outcome::Outcome;

/// How much the inertia of the fluid matters in a run.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct InertiaNumbers {
    /// Reynolds number `ρ U a / μ`: the largest of a body with the radius `a` and the speed `U`.
    pub reynolds: f64,
    /// Frequency parameter `ρ ω a² / μ` of the largest body, with a cycle of the gait per `2π / ω`.
    pub frequency: f64,
}

impl InertiaNumbers {
    /// The numbers of a run; `None` if its fluid has no inertia.
    pub fn new(scene: &Scene, outcome: &Outcome) -> Option<Self> {
        if !scene.inertia().is_kept() {
            return None;
        }
        let per_length = scene.fluid_density() / scene.viscosity();
        let radii = || scene.bodies().iter().map(scene::Body::bounding_radius);
        let at_samples = outcome
            .samples
            .iter()
            .filter_map(|sample| sample.bodies.as_ref());
        let products = at_samples.flat_map(|bodies| {
            let pairs = bodies.iter().zip(radii());
            pairs.map(|(body, radius)| body.velocity.norm() * radius)
        });
        let largest = radii().fold(0.0, f64::max);
        let cycle = scene.gait().cycle_duration();
        Some(Self {
            reynolds: per_length * products.fold(0.0, f64::max),
            frequency: per_length * largest * largest * TAU / cycle,
        })
    }
}
