//! Numbers of the thermal noise of a scene.

use std::f64::consts::PI;

use scene::Scene;

use crate::error::SwimError;
use crate::integrate::noise_steps;

/// Steps of thermal noise, and the diffusion of the first body.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct NoiseNumbers {
    /// Number of steps in the whole gait.
    pub steps: usize,
    /// Length of the longest step.
    pub time_step: f64,
    /// Diffusion coefficient of the first sphere alone in unbounded fluid, `k_B T / (6π μ a)`
    /// (Einstein 1905).
    pub diffusion: f64,
    /// Its rotational diffusion coefficient `k_B T / (8π μ a³)`.
    pub rotational_diffusion: f64,
}

impl NoiseNumbers {
    /// The numbers of a scene; `None` without noise.
    ///
    /// # Errors
    /// [`SwimError::NotApplicable`] for too many steps.
    pub fn new(scene: &Scene) -> Result<Option<Self>, SwimError> {
        let Some(noise) = scene.noise() else {
            return Ok(None);
        };
        let (mut steps, mut time_step) = (0, 0.0_f64);
        for phase in &scene.gait().phases {
            let of_phase = noise_steps(scene, noise, phase.duration)?;
            steps += of_phase * scene.gait().cycles as usize;
            time_step = time_step.max(phase.duration / of_phase as f64);
        }
        let mut radii = scene.bodies().iter().map(|body| body.bounding_radius());
        let Some(radius) = radii.find(|a| *a > 0.0) else {
            return Ok(None);
        };
        let mobility = 1.0 / (PI * scene.viscosity() * radius);
        Ok(Some(Self {
            steps,
            time_step,
            diffusion: noise.energy * mobility / 6.0,
            rotational_diffusion: noise.energy * mobility / (8.0 * radius * radius),
        }))
    }
}
