//! Masses of bodies, and what drives them as functions of time.

use std::f64::consts::PI;

use nalgebra::{Isometry3, Matrix3, Matrix6, Vector3};
use rigid::{Constraints, ExternalLoad, RigidError};
use stokes::SurfaceFlow;

/// Mass and moment of inertia of a body about its centre.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyMass {
    /// Mass; zero for a body without.
    pub mass: f64,
    /// Moment of inertia in the axes of the body.
    pub inertia: Matrix3<f64>,
}

impl BodyMass {
    /// A homogeneous sphere.
    pub fn sphere(radius: f64, density: f64) -> Self {
        let mass = density * 4.0 * PI / 3.0 * radius.powi(3);
        Self {
            mass,
            inertia: Matrix3::from_diagonal_element(0.4 * mass * radius * radius),
        }
    }

    /// The matrix of `(U, ω) -> (momentum, angular momentum)` in the laboratory axes.
    pub fn matrix(&self, pose: &Isometry3<f64>) -> Matrix6<f64> {
        let rotation = pose.rotation.to_rotation_matrix();
        let inertia = rotation.matrix() * self.inertia * rotation.matrix().transpose();
        let mut matrix = Matrix6::zeros();
        let mass = self.mass * Matrix3::identity();
        matrix.fixed_view_mut::<3, 3>(0, 0).copy_from(&mass);
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&inertia);
        matrix
    }
}

/// What drives the bodies and the walls, as functions of time.
///
/// All of it is evaluated at the end of a step. Bodies without joints, loads and slip need no
/// method: `()` is the forcing of a flow that only decays.
pub trait Forcing: Sync {
    /// Values of the joints, in the order of the articulated set.
    ///
    /// Rates follow by the formula of the time step, so that values, velocities and the motion of
    /// the mesh belong to one scheme.
    fn shape(&self, _time: f64) -> Vec<f64> {
        Vec::new()
    }

    /// External forces and torques on all bodies, which have these poses: by default
    /// [`Forcing::load`] of each.
    fn loads(&self, time: f64, poses: &[Isometry3<f64>]) -> Vec<ExternalLoad> {
        let poses = poses.iter().enumerate();
        poses
            .map(|(body, pose)| self.load(time, body, pose))
            .collect()
    }

    /// The constraints of a time with given velocities of bodies and forces on joints, from those
    /// of the joints alone: by default the same.
    ///
    /// # Errors
    /// Velocities or forces that do not fit the set.
    fn constraints(&self, _time: f64, joints: Constraints) -> Result<Constraints, RigidError> {
        Ok(joints)
    }

    /// External force and torque on a body with this pose.
    fn load(&self, _time: f64, _body: usize, _pose: &Isometry3<f64>) -> ExternalLoad {
        ExternalLoad::default()
    }

    /// Whether surfaces move relative to their bodies; without it `slip` is not called.
    fn has_slip(&self) -> bool {
        false
    }

    /// Velocity of the surface of a body relative to its rigid motion, at the point `x` on it.
    ///
    /// `body` counts bodies with a surface; `x` is relative to the centre. Both vectors are in the
    /// axes of the body, which turn with it.
    fn slip(&self, _time: f64, _body: usize, _x: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    /// Whether walls move; without it `wall_velocity` is not called.
    fn has_moving_walls(&self) -> bool {
        false
    }

    /// Velocity of the wall at a point on it, without net flux.
    fn wall_velocity(&self, _time: f64, _x: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }
}

impl Forcing for () {}

/// The slip of a forcing at one time, on bodies with these poses.
pub(crate) struct SlipAt<'a> {
    pub forcing: &'a dyn Forcing,
    pub time: f64,
    pub poses: &'a [Isometry3<f64>],
}

impl SurfaceFlow for SlipAt<'_> {
    fn slip(&self, body: usize, x: &Vector3<f64>) -> Vector3<f64> {
        let Isometry3 {
            rotation,
            translation,
        } = &self.poses[body];
        let own = rotation.inverse() * (x - translation.vector);
        rotation * self.forcing.slip(self.time, body, &own)
    }

    fn background(&self, _: &Vector3<f64>) -> Vector3<f64> {
        Vector3::zeros()
    }

    fn background_pressure(&self, _: &Vector3<f64>) -> f64 {
        0.0
    }
}
