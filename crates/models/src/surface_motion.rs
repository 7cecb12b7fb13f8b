//! Motion of the surfaces of the bodies relative to the bodies, and background flow, in one
//! configuration and in scaled units.

use mesh::Surface;
use microhydro::multipole::SlipDrive;
use nalgebra::{DMatrix, DVector, Isometry3, Matrix3, Point3, UnitQuaternion, Vector3};
use rigid::BodyKind;
use scene::{Background, Deformation, DeformedBody, Slip};

use crate::scaled_scene::ScaledScene;

/// Slip and deformation of the bodies at their poses, and the background flow, in scaled units.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfaceMotion {
    /// Slip of each body with a surface, with the axis at its pose.
    slips: Vec<Option<Slip>>,
    /// Deformation of each body with a surface.
    deformations: Vec<Option<PosedDeformation>>,
    /// Joints that are amplitudes of deformations.
    amplitudes: Vec<usize>,
    background: Option<Background>,
    /// Map to the frame in which the background flow is given.
    to_laboratory: Isometry3<f64>,
}

/// Deformation of a body with a rotation, at values of the joints in the units of the scene.
#[derive(Clone, Debug, PartialEq)]
struct PosedDeformation {
    deformation: Deformation,
    body: DeformedBody,
    rotation: UnitQuaternion<f64>,
    values: Vec<f64>,
    /// Scaled length that is one in the scene.
    unit: f64,
    /// For each joint, the scaled rate of one in the scene.
    rates: Vec<f64>,
}

impl PosedDeformation {
    /// Velocity of the surface at `x`, relative to the centre, for a scaled rate of one.
    fn velocity(&self, x: &Vector3<f64>, joint: usize) -> Vector3<f64> {
        let own = self.rotation.inverse_transform_vector(x) / self.unit;
        let velocity = self.body.velocity(&own, joint);
        self.rotation * velocity * (self.unit / self.rates[joint])
    }
}

/// Effect of surface velocities on bodies with the grand resistance `R`: `F = R (U - U_0)`.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SurfaceEffect {
    /// Velocities `U_0` of force-free bodies.
    pub velocities: DVector<f64>,
    /// Velocities of force-free bodies by the slip alone, then by a rate of one of each amplitude.
    pub of_parts: DMatrix<f64>,
    /// Powers of the slip on the fluid around force-free bodies, and of rates of one.
    pub powers: DVector<f64>,
    /// Rates of the amplitudes.
    pub rates: Vec<f64>,
    /// Right-hand side by the slip of the further degrees of freedom of a mobility, if it has them.
    pub hidden: DVector<f64>,
}

impl SurfaceEffect {
    /// The effect of velocities of force-free bodies that no slip and no deformation causes.
    pub fn of_velocities(velocities: DVector<f64>) -> Self {
        Self {
            of_parts: DMatrix::zeros(velocities.len(), 1),
            velocities,
            powers: DVector::zeros(1),
            rates: Vec::new(),
            hidden: DVector::zeros(0),
        }
    }

    /// Powers `∮ s · f dS` of the slip, and of rates of one of all amplitudes, while the bodies
    /// exert the forces `F` on the fluid.
    ///
    /// `P = P_0 - F · U_s`, with the power `P_0` of the velocity `s` of the surfaces of force-free
    /// bodies and their velocities `U_s` due to it. The flow that the forces add is that of rigid
    /// bodies, and the reciprocal theorem gives the power of `s` on it. `hidden` are the values of
    /// the further degrees of freedom, on which the slip has its power too.
    pub fn powers(&self, forces: &DVector<f64>, hidden: &DVector<f64>) -> DVector<f64> {
        let mut powers = &self.powers - self.of_parts.tr_mul(forces);
        if !self.hidden.is_empty() {
            powers[0] += self.hidden.dot(hidden);
        }
        powers
    }

    /// The effect of slip alone: the velocities of force-free bodies, and its power around them.
    pub fn of_slip(velocities: DVector<f64>, power: f64) -> Self {
        Self {
            of_parts: DMatrix::from_columns(std::slice::from_ref(&velocities)),
            velocities,
            powers: DVector::from_element(1, power),
            rates: Vec::new(),
            hidden: DVector::zeros(0),
        }
    }

    /// The effect of slip where the multipoles of the spheres are degrees of freedom: without
    /// forces and multipoles the spheres move against the rigid motions in their slip.
    pub fn of_multipoles(slip: &SlipDrive) -> Self {
        Self {
            hidden: slip.hidden.clone(),
            ..Self::of_slip(-&slip.velocities, -slip.inner_power)
        }
    }

    /// The effect with a factor times the change from one effect of the same surfaces to another.
    pub fn changed(&self, factor: f64, [from, to]: [&Self; 2]) -> Self {
        Self {
            velocities: &self.velocities + factor * (&to.velocities - &from.velocities),
            of_parts: &self.of_parts + factor * (&to.of_parts - &from.of_parts),
            powers: &self.powers + factor * (&to.powers - &from.powers),
            rates: self.rates.clone(),
            hidden: self.hidden.clone(),
        }
    }

    /// The effect from columns: slip, minus the background flow, then a rate of one of each
    /// amplitude.
    ///
    /// `powers` are those of all columns on the flows of all columns, `of_flow` those on the flow
    /// in the absence of the bodies, whose traction is that of the flow with minus its velocity
    /// inside.
    pub fn from_columns(
        velocities: &DMatrix<f64>,
        powers: &DMatrix<f64>,
        of_flow: &DVector<f64>,
        rates: &[f64],
    ) -> Self {
        let amplitudes = [1.0, 1.0].iter().chain(rates).copied();
        let amplitudes = DVector::from_iterator(2 + rates.len(), amplitudes);
        Self {
            velocities: velocities * &amplitudes,
            of_parts: velocities.clone().remove_column(1),
            powers: (powers * &amplitudes + of_flow).remove_row(1),
            rates: rates.to_vec(),
            hidden: DVector::zeros(0),
        }
    }
}

impl SurfaceMotion {
    /// The motion in a configuration; none if all surfaces are rigid and the fluid is at rest.
    ///
    /// `values` are those of the joints, in the units of the scene.
    pub fn new(scaled: &ScaledScene, poses: &[Isometry3<f64>], values: &[f64]) -> Option<Self> {
        let (scene, scale) = (&scaled.scene, &scaled.scale);
        if !scene.has_surface_velocity() && !scene.deforms() {
            return None;
        }
        let joints = scaled.set.joints();
        let rates: Vec<f64> = joints.iter().map(|joint| scale.value(joint, 1.0)).collect();
        let surfaced = (scene.bodies().iter().zip(poses).zip(scaled.set.kinds()))
            .filter(|(_, kind)| **kind == BodyKind::Rigid);
        let slip_at = |(slip, pose): (Slip, &Isometry3<f64>)| Slip {
            b1: scale.length(slip.b1),
            b2: scale.length(slip.b2),
            axis: pose.rotation * slip.axis,
        };
        let deformation_at = |deformation: &Deformation, pose: &Isometry3<f64>| PosedDeformation {
            deformation: deformation.clone(),
            body: deformation.at(values),
            rotation: pose.rotation,
            values: values.to_vec(),
            unit: scale.length(1.0),
            rates: rates.clone(),
        };
        Some(Self {
            slips: (surfaced.clone())
                .map(|((body, pose), _)| body.slip.map(|slip| slip_at((slip, pose))))
                .collect(),
            deformations: surfaced
                .map(|((body, pose), _)| Some(deformation_at(body.deformation.as_ref()?, pose)))
                .collect(),
            amplitudes: scaled.amplitudes().collect(),
            background: scale.background(scene),
            to_laboratory: Isometry3::identity(),
        })
    }

    /// Joints that are amplitudes of deformations.
    pub fn amplitudes(&self) -> &[usize] {
        &self.amplitudes
    }

    /// Velocity of the surface of a body at `x`, a position on it relative to its centre, for a
    /// rate of one of an amplitude; relative to the motion of the body.
    pub fn of_amplitude(&self, body: usize, x: &Vector3<f64>, joint: usize) -> Vector3<f64> {
        let velocity = |of: &PosedDeformation| of.velocity(x, joint);
        (self.deformed_by(body, joint)).map_or_else(Vector3::zeros, velocity)
    }

    /// The point by which a deformation finds the material point near `x`: the closest one of the
    /// surface, which tubes and triangles find by themselves.
    pub fn on_surface(&self, body: usize, x: &Vector3<f64>, surface: &dyn Surface) -> Vector3<f64> {
        let deformation = self.deformations.get(body).and_then(Option::as_ref);
        match deformation.map(|of| &of.body) {
            Some(DeformedBody::Tube(..) | DeformedBody::Triangles(..)) => *x,
            _ => surface.closest_point(*x),
        }
    }

    /// Whether an amplitude deforms a body.
    pub fn deforms(&self, body: usize, joint: usize) -> bool {
        self.deformed_by(body, joint).is_some()
    }

    /// Deformation of a body, if the amplitude is one of its own.
    fn deformed_by(&self, body: usize, joint: usize) -> Option<&PosedDeformation> {
        let deformation = self.deformations.get(body).and_then(Option::as_ref);
        deformation.filter(|of| of.deformation.joints().any(|own| own == joint))
    }

    /// Rate of the volume of a body for a rate of one of an amplitude.
    pub fn volume_rate(&self, body: usize, joint: usize) -> f64 {
        self.deformed_by(body, joint).map_or(0.0, |of| {
            let rate = of.deformation.volume_rate(&of.values, joint);
            rate * of.unit.powi(3) / of.rates[joint]
        })
    }

    /// Velocity of the deforming surface of a body at `x` for scaled rates of all joints.
    pub fn of_deformation(&self, body: usize, x: &Vector3<f64>, rates: &[f64]) -> Vector3<f64> {
        let moving = self.amplitudes.iter().filter(|joint| rates[**joint] != 0.0);
        moving
            .map(|&joint| rates[joint] * self.of_amplitude(body, x, joint))
            .sum()
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
