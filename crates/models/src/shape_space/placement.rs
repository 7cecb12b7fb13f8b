//! The place of a swimmer at the shapes of a table.

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use rigid::State;
use scene::{Domain, Scene, Shape};

use crate::error::ModelError;

/// Places a swimmer such that the mean of its bodies with surfaces is where it is at the start.
///
/// In unbounded fluid the place has no effect, and the frame stays where it is at the start.
pub struct Placement<'a> {
    scene: &'a Scene,
    start: State,
    /// The mean of the bodies at the start; none in unbounded fluid.
    mean: Option<Vector3<f64>>,
}

impl<'a> Placement<'a> {
    /// The places of a scene.
    ///
    /// # Errors
    /// A start at which the bodies cannot be placed.
    pub fn new(scene: &'a Scene) -> Result<Self, ModelError> {
        let mut placement = Self {
            scene,
            start: scene.initial_state(),
            mean: None,
        };
        if *scene.domain() != Domain::Unbounded {
            let lengths = scene.articulation().initial_shape();
            placement.mean = Some(placement.mean_of(&placement.start, lengths)?);
        }
        Ok(placement)
    }

    /// Whether the place of the swimmer has an effect.
    pub fn is_fixed(&self) -> bool {
        self.mean.is_some()
    }

    /// The state with the mean of the bodies at its place.
    ///
    /// # Errors
    /// Shapes for which the bodies cannot be placed.
    pub fn state(&self, lengths: &[f64]) -> Result<State, ModelError> {
        let mut state = self.start.clone();
        if let Some(mean) = self.mean {
            let shift = mean - self.mean_of(&state, lengths)?;
            for frame in &mut state.frames {
                frame.translation.vector += shift;
            }
        }
        Ok(state)
    }

    /// The same state moved by `shift` and turned by `rotation` about the mean of the bodies.
    pub fn moved(
        &self,
        state: &State,
        shift: &Vector3<f64>,
        rotation: &UnitQuaternion<f64>,
    ) -> State {
        let mean = self.mean.unwrap_or_default();
        let mut moved = state.clone();
        for frame in &mut moved.frames {
            let arm = rotation * (frame.translation.vector - mean);
            frame.translation = Translation3::from(mean + shift + arm);
            frame.rotation = rotation * frame.rotation;
        }
        for attitude in &mut moved.attitudes {
            *attitude = rotation * *attitude;
        }
        moved
    }

    /// Whether a body has a surface, and so counts in the mean.
    pub fn counts(&self, body: usize) -> bool {
        self.scene.bodies()[body].shape != Shape::Point
    }

    fn mean_of(&self, state: &State, lengths: &[f64]) -> Result<Vector3<f64>, ModelError> {
        let poses = self.scene.articulation().place(state, lengths)?;
        let (mut sum, mut count) = (Vector3::zeros(), 0);
        for (_, pose) in poses.iter().enumerate().filter(|(k, _)| self.counts(*k)) {
            sum += pose.translation.vector;
            count += 1;
        }
        Ok(sum / f64::from(count.max(1)))
    }
}
