//! A cheap model without error bars, to predict the size of displacements.

use microhydro::{Medium, Spheres, rpy};
use nalgebra::DMatrix;
use rigid::StateVelocity;

use crate::error::ModelError;
use crate::hydrodynamics::Hydrodynamics;
use crate::mobility::{self, MobilitySolution};
use crate::query::{Configuration, Query};
use crate::scaled_scene::ScaledScene;
use crate::solution::InstantaneousSolution;
use scene::Scene;

/// Spheres in unbounded fluid with the Rotne-Prager-Yamakawa mobility, whatever the scene has.
///
/// Another shape is replaced by the sphere with the mean of its half extents as radius, and walls,
/// slip and background flow are ignored. The displacements of a stroke have the right order of
/// magnitude, which is what tolerances of its parts need. Cost: microseconds for a few bodies.
pub struct RoughModel {
    scaled: ScaledScene,
    radii: Vec<f64>,
}

impl RoughModel {
    /// Creates the model of a scene.
    ///
    /// # Errors
    /// Joints or fixed bodies that contradict each other.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let scaled = ScaledScene::new(scene)?;
        let radii = (scene.bodies().iter())
            .filter(|body| body.shape.has_surface())
            .map(|body| body.shape.mean_radius());
        Ok(Self {
            radii: radii.map(|radius| scaled.scale.length(radius)).collect(),
            scaled,
        })
    }

    fn resistance(&self, configuration: Configuration) -> Result<DMatrix<f64>, ModelError> {
        let spheres = Spheres::new(self.scaled.centres(configuration)?, self.radii.clone())?;
        Ok(rpy::resistance(&spheres, &Medium::Unbounded)?)
    }
}

impl Hydrodynamics for RoughModel {
    fn scene(&self) -> &Scene {
        &self.scaled.scene
    }

    fn name(&self) -> &'static str {
        "rough"
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let loads = &self.scaled.loads(query.configuration, query.inertia)?;
        let resistance = self.resistance(query.configuration)?;
        let solution = |rates: &Vec<f64>| {
            let constraints = self.scaled.query_constraints(query, rates)?;
            let set = &self.scaled.set;
            let solved = MobilitySolution::new(&resistance, set, &constraints, loads, None)?;
            let time = query.configuration.time;
            let response = solved.response(&self.scaled, time, &constraints, loads)?;
            Ok(response.into())
        };
        query.rates.iter().map(solution).collect()
    }

    fn joint_responses(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Option<Vec<StateVelocity>>, ModelError> {
        let resistance = self.resistance(configuration)?;
        mobility::joint_responses(&self.scaled, configuration, &resistance).map(Some)
    }
}
