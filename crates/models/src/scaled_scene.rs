//! Bodies, links and loads of a scene in scaled units: the input of every model.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use rigid::{Articulation, BodyKind, Constraints, ExternalLoad};

use crate::error::ModelError;
use crate::hydrodynamics::Configuration;
use crate::units::Scale;
use scene::{Body, Scene};

/// Bodies, links and loads of a scene in scaled units.
pub(crate) struct ScaledScene {
    /// The scene, in its own units.
    pub scene: Scene,
    pub scale: Scale,
    /// Bodies and links.
    pub set: Articulation,
    /// External loads, one per body.
    pub loads: Vec<ExternalLoad>,
}

impl ScaledScene {
    /// Scales the bodies, links and loads of a scene.
    ///
    /// # Errors
    /// Links or fixed bodies that contradict each other.
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
            scene: scene.clone(),
            scale,
            set,
            loads: bodies()
                .map(|b| scale.load(b.total_force(), b.torque))
                .collect(),
        })
    }

    /// Enters the external loads of the scene, turned into another frame.
    pub fn turn_loads(&mut self, rotation: &UnitQuaternion<f64>) {
        let load = |body: &Body| {
            let (force, torque) = (body.total_force(), body.torque);
            self.scale.load(rotation * force, rotation * torque)
        };
        self.loads = self.scene.bodies().iter().map(load).collect();
    }

    /// Poses of all bodies in a configuration.
    ///
    /// # Errors
    /// Lengths of links for which a loop does not close.
    pub fn poses(&self, configuration: Configuration) -> Result<Vec<Isometry3<f64>>, ModelError> {
        let state = self.scale.state(configuration.state);
        Ok(self
            .set
            .place(&state, &self.lengths(configuration.lengths))?)
    }

    /// Centres of the bodies with surfaces in a configuration.
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

    /// Constraints of the links in a configuration, for one rate per link.
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
