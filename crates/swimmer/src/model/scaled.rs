//! What every model of a scene starts from: its bodies, links and loads in units of the flow.

use nalgebra::{Isometry3, Vector3};
use rigid::{Articulation, BodyKind, Constraints, ExternalLoad};

use super::scale::Scale;
use super::{ModelError, Placement};
use scene::Scene;

/// The bodies, links and loads of a scene in units of the flow.
pub(super) struct ScaledScene {
    pub scale: Scale,
    /// The bodies and links.
    pub set: Articulation,
    /// External loads, one a body.
    pub loads: Vec<ExternalLoad>,
}

impl ScaledScene {
    /// Those of a scene.
    ///
    /// # Errors
    /// Links or fixed bodies that make no sense.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let scale = Scale::of(scene);
        let bodies = || scene.bodies.iter();
        let kinds: Vec<_> = bodies().map(|b| b.kind()).collect();
        let positions: Vec<_> = bodies().map(|b| scale.point(b.position)).collect();
        let set = Articulation::new(
            &kinds,
            scene.articulation.links().to_vec(),
            scene.articulation.arms(),
            &positions,
        )?
        .with_fixed(&scene.fixed_bodies())?;
        Ok(Self {
            scale,
            set,
            loads: bodies().map(|b| scale.load(b.force, b.torque)).collect(),
        })
    }

    /// Poses of all bodies at a placement.
    ///
    /// # Errors
    /// Lengths that do not close a loop.
    pub fn poses(&self, placement: &Placement) -> Result<Vec<Isometry3<f64>>, ModelError> {
        let state = self.scale.state(placement.state);
        Ok(self.set.place(&state, &self.lengths(placement.lengths))?)
    }

    /// Centres of the bodies with surfaces at a placement.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn centres(&self, placement: &Placement) -> Result<Vec<Vector3<f64>>, ModelError> {
        let poses = self.poses(placement)?;
        let surfaced = poses.iter().zip(self.set.kinds());
        Ok(surfaced
            .filter(|(_, kind)| **kind == BodyKind::Rigid)
            .map(|(pose, _)| pose.translation.vector)
            .collect())
    }

    /// The links' constraints at a placement.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn constraints(&self, placement: &Placement) -> Result<Constraints, ModelError> {
        let state = self.scale.state(placement.state);
        let [lengths, rates] = [placement.lengths, placement.rates].map(|list| self.lengths(list));
        Ok(self.set.constraints(&state, &lengths, &rates)?)
    }

    fn lengths(&self, list: &[f64]) -> Vec<f64> {
        list.iter().map(|&l| self.scale.length(l)).collect()
    }
}
