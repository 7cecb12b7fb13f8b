//! Slip of the bodies and background flow in one configuration, in scaled units.

use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Point3, Vector3};
use rigid::BodyKind;
use scene::{Background, Slip};

use crate::scaled_scene::ScaledScene;

/// Slip of the bodies at their poses, and the background flow, in scaled units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfaceMotion {
    /// Slip of each body with a surface, with the axis at its pose.
    slips: Vec<Option<Slip>>,
    background: Option<Background>,
    /// Map to the frame in which the background flow is given.
    to_laboratory: Isometry3<f64>,
}

/// Effect of surface velocities on bodies with the grand resistance `R`: `F = R (U - U_0)`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfaceEffect {
    /// Velocities `U_0` of force-free bodies.
    pub velocities: DVector<f64>,
    /// Velocities of force-free bodies by the slip alone.
    pub of_slip: DVector<f64>,
    /// Power of the slip on the fluid around force-free bodies.
    pub slip_power: f64,
}

impl SurfaceEffect {
    /// Power `∮ s · f dS` of the slip `s` while the bodies exert the forces `F` on the fluid.
    ///
    /// `P = P_0 - F · U_s`, with the power `P_0` of the slip of force-free bodies and their
    /// velocities `U_s` due to the slip. The flow that the forces add is that of rigid bodies, and
    /// the reciprocal theorem gives the power of the slip on it.
    pub fn power(&self, forces: &DVector<f64>) -> f64 {
        self.slip_power - self.of_slip.dot(forces)
    }

    /// The effect from velocities and powers of two columns: slip, and minus the background flow.
    ///
    /// `slip_power` is the power of the slip in the sum of both.
    pub fn from_columns(velocities: &DMatrix<f64>, slip_power: f64) -> Self {
        let of_slip = velocities.column(0).into_owned();
        Self {
            velocities: &of_slip + velocities.column(1),
            of_slip,
            slip_power,
        }
    }
}

impl SurfaceMotion {
    /// The motion in a configuration; none if all surfaces are rigid and the fluid is at rest.
    pub fn new(scaled: &ScaledScene, poses: &[Isometry3<f64>]) -> Option<Self> {
        let (scene, scale) = (&scaled.scene, &scaled.scale);
        if !scene.has_surface_velocity() {
            return None;
        }
        let surfaced = (scene.bodies().iter().zip(poses).zip(scaled.set.kinds()))
            .filter(|(_, kind)| **kind == BodyKind::Rigid);
        let at_pose = |(slip, pose): (Slip, &Isometry3<f64>)| Slip {
            b1: scale.length(slip.b1),
            b2: scale.length(slip.b2),
            axis: pose.rotation * slip.axis,
        };
        Some(Self {
            slips: surfaced
                .map(|((body, pose), _)| body.slip.map(|slip| at_pose((slip, pose))))
                .collect(),
            background: scale.background(scene),
            to_laboratory: Isometry3::identity(),
        })
    }

    /// The motion in a frame with this map to the laboratory frame.
    ///
    /// The poses of the bodies are those in the frame.
    #[must_use]
    pub fn in_frame(self, to_laboratory: Option<Isometry3<f64>>) -> Self {
        Self {
            to_laboratory: to_laboratory.unwrap_or(self.to_laboratory),
            ..self
        }
    }

    /// Slip of a body with a surface where its outward unit normal is `normal`.
    pub fn slip(&self, body: usize, normal: &Vector3<f64>) -> Vector3<f64> {
        let velocity = |slip: &Slip| slip.velocity(normal);
        self.slip_of(body).map_or_else(Vector3::zeros, velocity)
    }

    /// Slip of a body with a surface.
    pub fn slip_of(&self, body: usize) -> Option<&Slip> {
        self.slips.get(body).and_then(Option::as_ref)
    }

    /// Velocity of the background flow.
    pub fn background(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let velocity = |flow: &Background| {
            let velocity = flow.velocity(&(self.to_laboratory * Point3::from(*x)).coords);
            self.to_laboratory.rotation.inverse() * velocity
        };
        self.background
            .as_ref()
            .map_or_else(Vector3::zeros, velocity)
    }

    /// Gradient of the background flow.
    pub fn background_gradient(&self, x: &Vector3<f64>) -> Matrix3<f64> {
        let gradient = |flow: &Background| {
            let rotation = self.to_laboratory.rotation.to_rotation_matrix();
            let gradient = flow.gradient(&(self.to_laboratory * Point3::from(*x)).coords);
            rotation.matrix().transpose() * gradient * rotation.matrix()
        };
        self.background
            .as_ref()
            .map_or_else(Matrix3::zeros, gradient)
    }

    /// Laplacian of the background flow, the gradient of its pressure.
    pub fn background_laplacian(&self) -> Vector3<f64> {
        let laplacian =
            |flow: &Background| self.to_laboratory.rotation.inverse() * flow.pressure_gradient();
        self.background
            .as_ref()
            .map_or_else(Vector3::zeros, laplacian)
    }

    /// Pressure of the background flow, zero at the origin of the frame.
    pub fn background_pressure(&self, x: &Vector3<f64>) -> f64 {
        self.background_laplacian().dot(x)
    }
}
