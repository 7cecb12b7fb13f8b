//! What every model of a scene starts from: its bodies, links and loads in units of the flow.

use nalgebra::{Isometry3, Vector3};
use rigid::{Articulation, BodyKind, Constraints, ExternalLoad};

use crate::error::ModelError;
use crate::hydrodynamics::Configuration;
use crate::scale::Scale;
use scene::Scene;

/// The bodies, links and loads of a scene in units of the flow.
pub(crate) struct ScaledScene {
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
        let bodies = || scene.bodies().iter();
        let kinds: Vec<_> = bodies().map(|b| b.kind()).collect();
        let positions: Vec<_> = bodies().map(|b| scale.point(b.position)).collect();
        let set = Articulation::new(
            &kinds,
            scene.articulation().links().to_vec(),
            scene.articulation().arms(),
            &positions,
        )?
        .with_fixed(&scene.fixed_bodies())?;
        Ok(Self {
            scale,
            set,
            loads: bodies().map(|b| scale.load(b.force, b.torque)).collect(),
        })
    }

    /// Poses of all bodies at a configuration.
    ///
    /// # Errors
    /// Lengths that do not close a loop.
    pub fn poses(&self, configuration: Configuration) -> Result<Vec<Isometry3<f64>>, ModelError> {
        let state = self.scale.state(configuration.state);
        Ok(self
            .set
            .place(&state, &self.lengths(configuration.lengths))?)
    }

    /// Centres of the bodies with surfaces at a configuration.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn centres(&self, configuration: Configuration) -> Result<Vec<Vector3<f64>>, ModelError> {
        let poses = self.poses(configuration)?;
        let surfaced = poses.iter().zip(self.set.kinds());
        Ok(surfaced
            .filter(|(_, kind)| **kind == BodyKind::Rigid)
            .map(|(pose, _)| pose.translation.vector)
            .collect())
    }

    /// The links' constraints at a configuration, for one rate per link.
    ///
    /// # Errors
    /// As [`ScaledScene::poses`].
    pub fn constraints(
        &self,
        configuration: Configuration,
        rates: &[f64],
    ) -> Result<Constraints, ModelError> {
        let state = self.scale.state(configuration.state);
        let [lengths, rates] = [configuration.lengths, rates].map(|list| self.lengths(list));
        Ok(self.set.constraints(&state, &lengths, &rates)?)
    }

    fn lengths(&self, list: &[f64]) -> Vec<f64> {
        list.iter().map(|&l| self.scale.length(l)).collect()
    }
}
