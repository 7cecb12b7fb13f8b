//! Resistances of bodies of revolution on one axis, and the effect of slip and background flows.

use std::f64::consts::PI;

use axisymmetric::{AxialResistance, AxialSpheroid, BodyVelocity, SurfaceMode, SurfaceResistance};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::error::ModelError;
use crate::query::Configuration;
use crate::scaled_scene::ScaledScene;
use crate::surface_motion::{SurfaceEffect, SurfaceMotion};

/// Resistances of one configuration.
pub(super) struct AxialResistances {
    /// To motions along the axis, and to the modes of the surfaces if there are `surfaces`.
    pub axial: AxialResistance,
    /// Modes of the surfaces, with slip or a background flow.
    pub surfaces: Option<SurfaceResistance>,
    /// To rotations about the axis, with torques.
    pub spin: Option<AxialResistance>,
}

/// Velocities or forces along the axis as those of bodies in space, six rows per body.
pub(super) fn spatial(axis: &Vector3<f64>, along: &[f64]) -> DVector<f64> {
    let mut vectors = DVector::zeros(6 * along.len());
    for (body, value) in along.iter().enumerate() {
        let mut rows = vectors.fixed_rows_mut::<3>(6 * body);
        rows.copy_from(&(axis * *value));
    }
    vectors
}

/// A unit vector away from the axis.
pub(super) fn across(axis: &Vector3<f64>) -> Vector3<f64> {
    axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize()
}

/// Grand resistance matrix from the resistances along and about the axis.
///
/// For motions that are zero by symmetry it has the entries of single spheres.
pub(super) fn grand_resistance(
    shapes: &[AxialSpheroid],
    axis: &Vector3<f64>,
    axial: &DMatrix<f64>,
    spin: Option<&DMatrix<f64>>,
) -> DMatrix<f64> {
    let n = shapes.len();
    let along: Matrix3<f64> = axis * axis.transpose();
    let across = Matrix3::identity() - along;
    let mut matrix = DMatrix::zeros(6 * n, 6 * n);
    for i in 0..n {
        for j in 0..n {
            let block = along * axial[(i, j)];
            matrix
                .fixed_view_mut::<3, 3>(6 * i, 6 * j)
                .copy_from(&block);
        }
        let size = shapes[i].axial.max(shapes[i].equatorial);
        let (drag, torque) = (6.0 * PI * size, 8.0 * PI * size.powi(3));
        let mut forces = matrix.fixed_view_mut::<3, 3>(6 * i, 6 * i);
        forces += across * drag;
        let mut torques = matrix.fixed_view_mut::<3, 3>(6 * i + 3, 6 * i + 3);
        torques += match spin {
            Some(_) => across * torque,
            None => Matrix3::identity() * torque,
        };
        for j in 0..n {
            let about = spin.map_or(0.0, |spin| spin[(i, j)]);
            let mut block = matrix.fixed_view_mut::<3, 3>(6 * i + 3, 6 * j + 3);
            block += along * about;
        }
    }
    matrix
}

/// Amplitudes of the velocities of all bodies and modes along an axis.
pub(super) struct AxialSurfaces<'a> {
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
        resistances: &'a AxialResistances,
        axis: &'a Vector3<f64>,
    ) -> Result<Option<Self>, ModelError> {
        let poses = scaled.poses(configuration)?;
        let motion = SurfaceMotion::new(scaled, &poses, configuration.shape);
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
        let spatial = |axial: DVector<f64>| spatial(self.axis, axial.as_slice());
        Ok(SurfaceEffect {
            velocities: spatial(velocities),
            of_parts: DMatrix::from_columns(&[spatial(force_free(&self.of_slip))]),
            powers: DVector::from_element(1, slip_power),
            rates: Vec::new(),
            hidden: DVector::zeros(0),
        })
    }
}
