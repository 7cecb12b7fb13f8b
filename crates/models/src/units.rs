//! Scaled units, in which flows are computed: smallest radius 1, viscosity 1, time as in the scene.

use std::ops::{Div, Mul};

use mesh::{MeshError, Surface, TetMesh};
use mesher::GenerateError;
use nalgebra::{DMatrix, Isometry3, Matrix3, Matrix6, Vector3};
use rigid::{
    ExternalLoad, Joint, JointDrive, JointLoad, PassiveDrive, State, StateVelocity, Twist,
};

use scene::rheology::Law;
use scene::{Background, Scene, Shape};

/// Conversion between the units of a scene and scaled units.
///
/// With the smallest radius `L` and the viscosity `μ`, scaled quantities (primed) are
///
/// ```text
/// x' = x / L,   U' = U / L,   F' = F / (μ L^2),   T' = T / (μ L^3),   p' = p / μ
/// ```
///
/// Stokes flow has no time scale, so times are not converted. Scaled solutions do not depend on the
/// units of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    length: f64,
    viscosity: f64,
}

impl Scale {
    /// The scale of a scene: its smallest radius and its viscosity.
    pub fn new(scene: &Scene) -> Self {
        let smallest = (scene.bodies().iter())
            .map(scene::Body::bounding_radius)
            .filter(|&radius| radius > 0.0)
            .fold(f64::INFINITY, f64::min);
        Self {
            length: if smallest.is_finite() { smallest } else { 1.0 },
            viscosity: scene.viscosity(),
        }
    }

    /// Scaled length, position or velocity of one of the scene.
    pub fn length<T: Div<f64, Output = T>>(&self, length: T) -> T {
        length / self.length
    }

    /// Length, position or velocity in the scene of a scaled one.
    pub fn length_to_scene<T: Mul<f64, Output = T>>(&self, length: T) -> T {
        length * self.length
    }

    /// Surface of a shape at a scaled pose relative to the initial configuration; `None` for a
    /// point.
    pub fn surface(&self, shape: &Shape, pose: &Isometry3<f64>) -> Option<Box<dyn Surface>> {
        shape.surface(pose, self.length)
    }

    /// Mesh in the units of the scene from a scaled mesh.
    ///
    /// # Errors
    /// Points that overflow.
    pub fn mesh_to_scene(&self, mesh: &TetMesh) -> Result<TetMesh, MeshError> {
        let points = mesh.points().iter();
        mesh.with_points(points.map(|&x| self.length_to_scene(x)).collect())
    }

    /// An error of the mesh generator with its place and distances in the scene.
    pub fn error_to_scene(&self, mut error: GenerateError) -> GenerateError {
        match &mut error {
            GenerateError::Mesh(MeshError::InvertedCell { at, .. })
            | GenerateError::SurfaceNotRecovered { at, .. }
            | GenerateError::BoundaryNotRecovered { at, .. } => {
                at.iter_mut().for_each(|x| *x *= self.length);
            }
            GenerateError::BodiesTouch {
                distance, minimum, ..
            }
            | GenerateError::BodyAtWall {
                distance, minimum, ..
            } => {
                *distance *= self.length;
                *minimum *= self.length;
            }
            _ => {}
        }
        error
    }

    /// Scaled state of a state of the scene with the passive joints `passive`.
    pub fn state<'l>(&self, state: &State, passive: impl Iterator<Item = &'l Joint>) -> State {
        State {
            frames: (state.frames.iter())
                .map(|frame| {
                    let position = self.length(frame.translation.vector);
                    Isometry3::from_parts(position.into(), frame.rotation)
                })
                .collect(),
            attitudes: state.attitudes.clone(),
            joints: (state.joints.iter().zip(passive))
                .map(|(&value, joint)| self.value(joint, value))
                .collect(),
        }
    }

    /// Scaled joint of a joint of the scene: its kind, and what drives it.
    ///
    /// Forces of joints that turn are torques, and their values angles.
    pub fn joint(&self, joint: &Joint) -> Joint {
        let scaled = joint
            .clone()
            .with_kind(joint.kind.scaled(1.0 / self.length));
        let JointDrive::Passive(drive) = joint.drive else {
            return scaled;
        };
        // Stiffness and damping are forces per value and per rate.
        let per_value = |x: f64| self.joint_force(joint, x) * self.value_unit(joint);
        scaled.with_drive(JointDrive::Passive(PassiveDrive {
            force: self.joint_force(joint, drive.force),
            stiffness: per_value(drive.stiffness),
            rest: self.value(joint, drive.rest),
            damping: per_value(drive.damping),
        }))
    }

    /// Scaled force on a joint, a torque for joints that turn: power per rate of the value.
    pub fn joint_force(&self, joint: &Joint, force: f64) -> f64 {
        force * self.value_unit(joint) / (self.force_unit() * self.length)
    }

    /// Load of a joint in the scene of a scaled one.
    pub fn joint_load_to_scene(&self, joint: &Joint, load: &JointLoad) -> JointLoad {
        JointLoad::new(
            self.force_to_scene(load.force),
            self.torque_to_scene(load.torque),
            load.drive / self.joint_force(joint, 1.0),
        )
    }

    /// Scaled value, or rate, of a joint: a power of a length.
    pub fn value(&self, joint: &Joint, value: f64) -> f64 {
        value / self.value_unit(joint)
    }

    fn value_unit(&self, joint: &Joint) -> f64 {
        self.length.powi(joint.kind.length_power())
    }

    /// Scaled external load of a force and a torque of the scene.
    pub fn load(&self, force: Vector3<f64>, torque: Vector3<f64>) -> ExternalLoad {
        ExternalLoad {
            force: force / self.force_unit(),
            torque: torque / (self.force_unit() * self.length),
        }
    }

    /// Scaled background flow of a scene.
    pub(crate) fn background(&self, scene: &Scene) -> Option<Background> {
        let scaled = |flow: &Background| flow.in_units_of(self.length);
        scene.background().map(scaled)
    }

    /// Force in the scene of a scaled force, or its magnitude.
    pub fn force_to_scene<T: Mul<f64, Output = T>>(&self, force: T) -> T {
        force * self.force_unit()
    }

    /// Torque or stresslet in the scene of a scaled one.
    pub fn torque_to_scene<T: Mul<f64, Output = T>>(&self, torque: T) -> T {
        torque * (self.force_unit() * self.length)
    }

    /// Power in the scene of a scaled power.
    pub fn power_to_scene(&self, power: f64) -> f64 {
        power * self.force_unit() * self.length
    }

    /// Grand resistance in the scene of a scaled one.
    ///
    /// The factor is `μ L` for forces due to translations, and a further `L` for a torque instead
    /// of a force and for a rotation instead of a translation.
    pub fn resistance_to_scene(&self, resistance: DMatrix<f64>) -> DMatrix<f64> {
        let unit = |entry: usize| if entry % 6 < 3 { 1.0 } else { self.length };
        let (rows, columns) = resistance.shape();
        DMatrix::from_fn(rows, columns, |i, j| {
            resistance[(i, j)] * self.viscosity * self.length * unit(i) * unit(j)
        })
    }

    /// Scaled mass and moments of inertia: the rate of a momentum is a force like a resistance
    /// times a velocity.
    pub fn mass(&self, mass: f64, inertia: &Matrix3<f64>) -> (f64, Matrix3<f64>) {
        let mut matrix = Matrix6::identity() * mass;
        matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(inertia);
        let scaled = self.body_resistance(&matrix);
        (scaled[(0, 0)], scaled.fixed_view::<3, 3>(3, 3).into_owned())
    }

    /// Scaled resistance of one body to its velocities `(U, ω)`.
    pub fn body_resistance(&self, resistance: &Matrix6<f64>) -> Matrix6<f64> {
        let unit = |entry: usize| if entry < 3 { 1.0 } else { self.length };
        Matrix6::from_fn(|i, j| {
            resistance[(i, j)] / (self.viscosity * self.length * unit(i) * unit(j))
        })
    }

    /// Scaled density, `ρ' = ρ L^2 / μ`: the ratio of inertia to viscosity per time.
    pub fn density(&self, density: f64) -> f64 {
        density * self.length * self.length / self.viscosity
    }

    /// Scaled viscosity law of the scene: viscosities over that of the scale, times as they are.
    pub fn law(&self, law: Law) -> Law {
        law.scaled(1.0 / self.viscosity)
    }

    /// Pressure in the scene of a scaled pressure.
    pub fn pressure_to_scene(&self, pressure: f64) -> f64 {
        pressure * self.viscosity
    }

    /// Rate of change of the state in the scene of a scaled one, with its passive joints.
    pub fn motion_to_scene<'l>(
        &self,
        motion: &StateVelocity,
        passive: impl Iterator<Item = &'l Joint>,
    ) -> StateVelocity {
        StateVelocity {
            frames: (motion.frames.iter())
                .map(|twist| Twist {
                    linear: self.length_to_scene(twist.linear),
                    angular: twist.angular,
                })
                .collect(),
            spins: motion.spins.clone(),
            joints: (motion.joints.iter().zip(passive))
                .map(|(rate, joint)| rate * self.value_unit(joint))
                .collect(),
        }
    }

    fn force_unit(&self) -> f64 {
        self.viscosity * self.length * self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_of_the_mesh_generator_name_places_in_the_scene() {
        let scale = Scale {
            length: 2.0,
            viscosity: 1.0,
        };
        let error = |at: [f64; 3]| GenerateError::SurfaceNotRecovered {
            body: "helix".to_owned(),
            at,
        };
        let found = scale.error_to_scene(error([1.0, -2.0, 0.5]));
        assert_eq!(found.to_string(), error([2.0, -4.0, 1.0]).to_string());
        let found = scale.error_to_scene(GenerateError::BodiesTouch {
            first: "a".to_owned(),
            second: "b".to_owned(),
            distance: -0.25,
            minimum: 1e-3,
        });
        assert!(found.to_string().contains("is -5.000e-1"), "{found}");
    }
}
