//! Spheres on one axis that deform: their shapes, and the effect of their rates.

use axisymmetric::{AxialResistance, DeformationRates, DeformedSphere, RADIAL_DEGREES};
use nalgebra::{DMatrix, DVector, Vector3};
use scene::Deformation;

use super::AxisymmetricModel;
use super::axial_surfaces::{across, spatial};
use crate::error::ModelError;
use crate::query::Configuration;
use crate::scaled_scene::ScaledScene;
use crate::surface_motion::{SurfaceEffect, SurfaceMotion};

/// Velocities of the surfaces of spheres on an axis for rates of one of all amplitudes.
pub(super) struct AxialRates {
    motion: SurfaceMotion,
    axis: Vector3<f64>,
    /// A direction perpendicular to the axis.
    across: Vector3<f64>,
}

impl AxialRates {
    /// The velocities in a configuration; none if no body deforms.
    ///
    /// # Errors
    /// Values of joints for which a loop does not close.
    pub fn new(
        scaled: &ScaledScene,
        configuration: Configuration,
        axis: &Vector3<f64>,
    ) -> Result<Option<Self>, ModelError> {
        if !scaled.scene.deforms() {
            return Ok(None);
        }
        let poses = scaled.poses(configuration)?;
        let motion = SurfaceMotion::new(scaled, &poses, configuration.shape);
        Ok(motion.map(|motion| Self {
            motion,
            axis: *axis,
            across: across(axis),
        }))
    }

    /// The effect on the bodies with these scaled rates of all joints, by a resistance `power` of
    /// bodies and amplitudes.
    ///
    /// # Errors
    /// [`ModelError::Singular`].
    pub fn effect(&self, power: &DMatrix<f64>, rates: &[f64]) -> Result<SurfaceEffect, ModelError> {
        let amplitudes = self.motion.amplitudes();
        let rates: Vec<f64> = amplitudes.iter().map(|&joint| rates[joint]).collect();
        let (count, bodies) = (rates.len(), power.nrows() - rates.len());
        let own = power.view((0, 0), (bodies, bodies)).into_owned();
        let coupling = power.view((0, bodies), (bodies, count)).into_owned();
        let factor = own.cholesky().ok_or(ModelError::Singular {
            matrix: "axial resistance",
            size: bodies,
        })?;
        // Force-free bodies move so that the forces of all rates on them vanish.
        let force_free = -factor.solve(&coupling);
        let along = |speeds: DVector<f64>| spatial(&self.axis, speeds.as_slice());
        let given = DVector::from_column_slice(&rates);
        let speeds = &force_free * &given;
        let forces =
            coupling.tr_mul(&speeds) + power.view((bodies, bodies), (count, count)) * &given;
        let mut parts = vec![DVector::zeros(6 * bodies)];
        parts.extend(
            force_free
                .column_iter()
                .map(|column| along(column.into_owned())),
        );
        Ok(SurfaceEffect {
            velocities: along(speeds),
            of_parts: DMatrix::from_columns(&parts),
            // There is no slip.
            powers: forces.insert_row(0, 0.0),
            rates,
            hidden: DVector::zeros(0),
        })
    }
}

impl DeformationRates for AxialRates {
    fn count(&self) -> usize {
        self.motion.amplitudes().len()
    }

    fn velocity(&self, column: usize, body: usize, [z, r]: [f64; 2]) -> [f64; 2] {
        let x = self.axis * z + self.across * r;
        let joint = self.motion.amplitudes()[column];
        let velocity = self.motion.of_amplitude(body, &x, joint);
        [velocity.dot(&self.axis), velocity.dot(&self.across)]
    }

    fn volume_rate(&self, column: usize, body: usize) -> f64 {
        self.motion
            .volume_rate(body, self.motion.amplitudes()[column])
    }
}

impl AxisymmetricModel {
    /// Resistance to motions along the axis and to the rates of all amplitudes.
    ///
    /// # Errors
    /// Bodies that left the axis; values at which a body cannot be; failures of the solver.
    pub(super) fn deforming_resistance(
        &self,
        configuration: Configuration,
        rates: &AxialRates,
        tolerance: f64,
    ) -> Result<AxialResistance, ModelError> {
        let scene = &self.scaled.scene;
        scene
            .check_deformations(configuration.shape)
            .map_err(Box::new)?;
        let positions = self.on_axis(configuration)?;
        let surfaced = self.scaled.surfaced().map(|body| &scene.bodies()[body]);
        let sphere = |(body, position): (&scene::Body, &axisymmetric::AxialSpheroid)| {
            let mut sphere = DeformedSphere {
                centre: position.centre,
                radius: position.axial,
                power: 1.0,
                amplitudes: [0.0; RADIAL_DEGREES],
            };
            // Tubes are refused.
            if let Some(deformation) = body.deformation.as_ref().and_then(Deformation::sphere) {
                let profile = deformation.profile(configuration.shape);
                sphere.radius = self.scaled.scale.length(profile.radius);
                sphere.power = profile.power;
                let axis = deformation.axis().unwrap_or(self.axis);
                let sign = axis.dot(&self.axis).signum();
                let amplitudes = sphere
                    .amplitudes
                    .iter_mut()
                    .zip(profile.legendre_amplitudes());
                for (degree, (own, amplitude)) in amplitudes.enumerate() {
                    *own = amplitude * sign.powi(degree as i32);
                }
            }
            sphere
        };
        let spheres: Vec<_> = surfaced.zip(&positions).map(sphere).collect();
        let surroundings = self.surroundings;
        Ok(axisymmetric::deforming_resistance(
            &spheres,
            surroundings,
            rates,
            tolerance,
        )?)
    }
}
