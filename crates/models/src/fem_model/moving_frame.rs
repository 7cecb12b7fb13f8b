//! Frame that moves with a body: in unbounded fluid, one mesh serves all its positions.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use rigid::State;
use scene::{Domain, Scene};

/// Rigid motion of the first body from its initial pose, in the scene's units.
///
/// A body that tumbles in a background flow would shear its mesh until it is remeshed, and each new
/// mesh has other discretisation errors. In the frame that moves with the body, the mesh of a
/// single body never changes; loads and background flow turn instead.
#[derive(Clone, Copy, Debug)]
pub struct MovingFrame {
    rotation: UnitQuaternion<f64>,
    position: Vector3<f64>,
    initial: Vector3<f64>,
}

impl MovingFrame {
    /// Whether a moving frame serves a scene: flows, slip and gravity in unbounded fluid.
    pub fn serves(scene: &Scene) -> bool {
        let is_driven = scene.has_surface_velocity() || scene.gravity() != Vector3::zeros();
        *scene.domain() == Domain::Unbounded && is_driven
    }

    /// The frame in a state of a scene; none for a scene that it does not serve.
    pub fn new(scene: &Scene, state: &State) -> Option<Self> {
        if !Self::serves(scene) {
            return None;
        }
        let set = scene.articulation();
        let (root, frame) = (set.linkages().first()?.root, state.frames.first()?);
        Some(Self {
            rotation: match set.has_own_attitude(root) {
                true => *state.attitudes.get(root)?,
                false => frame.rotation,
            },
            position: frame.translation.vector,
            initial: scene.bodies().get(root)?.position,
        })
    }

    /// Rotation from the moving frame to the laboratory frame.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        self.rotation
    }

    /// The map from the moving frame to the laboratory frame, with lengths times `factor`.
    pub fn to_laboratory(self, factor: f64) -> Isometry3<f64> {
        let shift = self.position - self.rotation * self.initial;
        Isometry3::from_parts(Translation3::from(shift * factor), self.rotation)
    }

    /// A state in the moving frame.
    pub fn state(&self, state: &State) -> State {
        let to_frame = self.to_laboratory(1.0).inverse();
        State {
            frames: state.frames.iter().map(|frame| to_frame * frame).collect(),
            attitudes: (state.attitudes.iter())
                .map(|attitude| self.rotation.inverse() * attitude)
                .collect(),
            joints: state.joints.clone(),
        }
    }
}
