//! The units in which the flow is computed: lengths by the smallest radius, viscosity 1, time as in the scene.

use mesh::{MeshError, TetMesh};
use nalgebra::{DMatrix, Isometry3, Translation3, Vector3};
use rigid::{ExternalLoad, State, StateVelocity, Twist};

use scene::Scene;

/// Conversion between a scene's units and those of the flow.
///
/// With length $L$ and viscosity $\mu$: $x' = x/L$, $U' = U/L$, $F' = F/(\mu L^2)$, $T' = T/(\mu L^3)$, $p' = p/\mu$. Stokes flow has no
/// scale of time of its own, so times stay as they are. Nothing that follows depends on the scene's units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    length: f64,
    viscosity: f64,
}

impl Scale {
    /// The scale of a scene: its smallest radius and its viscosity.
    pub fn of(scene: &Scene) -> Self {
        let smallest = scene
            .bodies()
            .iter()
            .map(scene::Body::bounding_radius)
            .filter(|&radius| radius > 0.0)
            .fold(f64::INFINITY, f64::min);
        Self {
            length: if smallest.is_finite() { smallest } else { 1.0 },
            viscosity: scene.viscosity(),
        }
    }

    /// A length of the scene in units of the flow.
    pub fn length(&self, length: f64) -> f64 {
        length / self.length
    }

    /// A point of the scene in units of the flow.
    pub fn point(&self, point: Vector3<f64>) -> Vector3<f64> {
        point / self.length
    }

    /// A point of the flow in units of the scene.
    pub fn point_back(&self, point: Vector3<f64>) -> Vector3<f64> {
        point * self.length
    }

    /// A mesh of the flow in units of the scene.
    ///
    /// # Errors
    /// Points that lie outside the numbers.
    pub fn mesh_back(&self, mesh: &TetMesh) -> Result<TetMesh, MeshError> {
        let points = mesh.points().iter().map(|&x| self.point_back(x)).collect();
        mesh.with_points(points)
    }

    /// A state of the scene in units of the flow.
    pub fn state(&self, state: &State) -> State {
        State {
            frames: state
                .frames
                .iter()
                .map(|frame| {
                    Isometry3::from_parts(
                        Translation3::from(self.point(frame.translation.vector)),
                        frame.rotation,
                    )
                })
                .collect(),
            attitudes: state.attitudes.clone(),
        }
    }

    /// An external load of the scene in units of the flow.
    pub fn load(&self, force: Vector3<f64>, torque: Vector3<f64>) -> ExternalLoad {
        ExternalLoad {
            force: force / self.force_unit(),
            torque: torque / (self.force_unit() * self.length),
        }
    }

    /// Velocity of the scene for a velocity of the flow.
    pub fn velocity_back(&self, velocity: Vector3<f64>) -> Vector3<f64> {
        velocity * self.length
    }

    /// Speed of the scene for a speed of the flow.
    pub fn speed_back(&self, speed: f64) -> f64 {
        speed * self.length
    }

    /// Force of the scene for a force of the flow.
    pub fn force_back(&self, force: Vector3<f64>) -> Vector3<f64> {
        force * self.force_unit()
    }

    /// Torque of the scene for a torque of the flow.
    pub fn torque_back(&self, torque: Vector3<f64>) -> Vector3<f64> {
        torque * (self.force_unit() * self.length)
    }

    /// Grand resistance of the scene for that of the flow: $\mu L$ for translations, a factor $L$ more for each rotation.
    pub fn resistance_back(&self, resistance: DMatrix<f64>) -> DMatrix<f64> {
        let unit = |entry: usize| if entry % 6 < 3 { 1.0 } else { self.length };
        let (rows, columns) = resistance.shape();
        DMatrix::from_fn(rows, columns, |i, j| {
            resistance[(i, j)] * self.viscosity * self.length * unit(i) * unit(j)
        })
    }

    /// Pressure of the scene for a pressure of the flow.
    pub fn pressure_back(&self, pressure: f64) -> f64 {
        pressure * self.viscosity
    }

    /// The motion of a flow in the scene's units.
    pub fn motion_back(&self, motion: &StateVelocity) -> StateVelocity {
        StateVelocity {
            frames: motion
                .frames
                .iter()
                .map(|twist| Twist {
                    linear: self.velocity_back(twist.linear),
                    angular: twist.angular,
                })
                .collect(),
            spins: motion.spins.clone(),
        }
    }

    fn force_unit(&self) -> f64 {
        self.viscosity * self.length * self.length
    }
}
