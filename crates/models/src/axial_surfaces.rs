//! Effect of slip and background flows on bodies of revolution on one axis.

use axisymmetric::{BodyVelocity, SurfaceMode, SurfaceResistance};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::axial_resistance::Resistances;
use crate::error::ModelError;
use crate::hydrodynamics::Configuration;
use crate::scaled_scene::ScaledScene;
use crate::surface_motion::{SurfaceEffect, SurfaceMotion};

/// Amplitudes of the velocities of all bodies and modes along an axis.
pub(crate) struct AxialSurfaces<'a> {
    surfaces: &'a SurfaceResistance,
    axis: &'a Vector3<f64>,
    bodies: usize,
    of_slip: DVector<f64>,
    /// Those of minus the background flow.
    of_background: DVector<f64>,
}

impl<'a> AxialSurfaces<'a> {
    /// The amplitudes in a configuration; none if all surfaces are rigid and the fluid is at rest.
    ///
    /// # Errors
    /// Values of joints for which a loop does not close.
    pub fn new(
        scaled: &ScaledScene,
        configuration: Configuration,
        resistances: &'a Resistances,
        axis: &'a Vector3<f64>,
    ) -> Result<Option<Self>, ModelError> {
        let motion = SurfaceMotion::new(scaled, &scaled.poses(configuration)?);
        let (Some(motion), Some(surfaces)) = (motion, &resistances.surfaces) else {
            return Ok(None);
        };
        let centres = scaled.centres(configuration)?;
        let zero = DVector::zeros(surfaces.power().matrix().nrows());
        let (mut of_slip, mut of_background) = (zero.clone(), zero);
        for (body, centre) in centres.iter().enumerate() {
            let row = |mode| surfaces.row(body, mode);
            if let Some(slip) = motion.slip_of(body) {
                // The second mode is the same for opposite axes.
                of_slip[row(SurfaceMode::FirstSlip)] = slip.b1 * slip.axis.dot(axis).signum();
                of_slip[row(SurfaceMode::SecondSlip)] = slip.b2;
            }
            // Near a point of the axis the flow along it is u + g z - c r^2.
            let rate = axis.dot(&(motion.background_gradient(centre) * axis));
            let laplacian = motion.background_laplacian().dot(axis);
            of_background[body] = -motion.background(centre).dot(axis);
            of_background[row(SurfaceMode::Extension)] = -rate;
            of_background[row(SurfaceMode::Parabola)] = -0.25 * laplacian;
        }
        Ok(Some(Self {
            surfaces,
            axis,
            bodies: centres.len(),
            of_slip,
            of_background,
        }))
    }

    /// Amplitudes of all modes of a body, and of its own velocity relative to the flow without it.
    pub fn of_body(&self, body: usize, speed: f64) -> BodyVelocity {
        let amplitude = |row: usize| self.of_slip[row] + self.of_background[row];
        let modes = [
            SurfaceMode::FirstSlip,
            SurfaceMode::SecondSlip,
            SurfaceMode::Extension,
            SurfaceMode::Parabola,
        ];
        BodyVelocity {
            axial: speed + amplitude(body),
            angular: 0.0,
            modes: modes.map(|mode| amplitude(self.surfaces.row(body, mode))),
        }
    }

    /// The effect on the bodies, by a resistance `power` of bodies and modes.
    ///
    /// # Errors
    /// [`ModelError::Singular`].
    pub fn effect(&self, power: &DMatrix<f64>) -> Result<SurfaceEffect, ModelError> {
        let bodies = self.bodies;
        let own = power.view((0, 0), (bodies, bodies)).into_owned();
        let singular = || ModelError::Singular {
            matrix: "axial resistance",
            size: bodies,
        };
        let factor = own.cholesky().ok_or_else(singular)?;
        // Force-free bodies move so that the forces of all amplitudes on them vanish.
        let force_free = |amplitudes: &DVector<f64>| {
            let forces = power * amplitudes;
            -factor.solve(&forces.rows(0, bodies).into_owned())
        };
        let all = &self.of_slip + &self.of_background;
        let velocities = force_free(&all);
        let mut moving = all;
        let mut own = moving.rows_mut(0, bodies);
        own += &velocities;
        let in_flow = self.surfaces.powers_in_flows() * &self.of_background;
        let slip_power = self.of_slip.dot(&(power * moving)) + self.of_slip.dot(&in_flow);
        let spatial = |axial: DVector<f64>| {
            let mut velocities = DVector::zeros(6 * bodies);
            for (body, speed) in axial.iter().enumerate() {
                velocities
                    .fixed_rows_mut::<3>(6 * body)
                    .copy_from(&(self.axis * *speed));
            }
            velocities
        };
        Ok(SurfaceEffect {
            velocities: spatial(velocities),
            of_slip: spatial(force_free(&self.of_slip)),
            slip_power,
        })
    }
}
