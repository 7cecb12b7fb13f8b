//! Slip on the surfaces of the bodies and the background flow, for the finite-element solver.

use mesh::Surface;
use nalgebra::Vector3;
use stokes::SurfaceFlow;

use crate::surface_motion::SurfaceMotion;

/// The motion of surfaces with the surfaces that it is on.
pub struct BodyFlows<'a> {
    pub motion: SurfaceMotion,
    /// Surfaces of the bodies; those of walls after them are not used.
    pub surfaces: &'a [(&'a str, Box<dyn Surface>)],
}

impl SurfaceFlow for BodyFlows<'_> {
    fn slip(&self, body: usize, x: &Vector3<f64>) -> Vector3<f64> {
        match self.surfaces.get(body) {
            Some((_, surface)) if self.motion.slip_of(body).is_some() => {
                self.motion.slip(body, &surface.normal(*x))
            }
            _ => Vector3::zeros(),
        }
    }

    fn background(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.motion.background(x)
    }

    fn background_pressure(&self, x: &Vector3<f64>) -> f64 {
        self.motion.background_pressure(x)
    }
}
