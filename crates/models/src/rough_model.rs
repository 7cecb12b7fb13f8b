//! A cheap model without error bars, to predict the size of displacements.

use microhydro::{Medium, Spheres, rpy};
use rigid::StateVelocity;

use crate::error::ModelError;
use crate::hydrodynamics::{Configuration, Cost, Hydrodynamics, Query};
use crate::mobility::{self, MobilitySolution};
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
}

impl Hydrodynamics for RoughModel {
    fn name(&self) -> &'static str {
        "rough"
    }

    fn scene(&self) -> &Scene {
        &self.scaled.scene
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let ScaledScene { scale, set, .. } = &self.scaled;
        let loads = &self.scaled.loads(query.configuration, query.inertia)?;
        let centres = self.scaled.centres(query.configuration)?;
        let spheres = Spheres::new(centres, self.radii.clone())?;
        let resistance = rpy::resistance(&spheres, &Medium::Unbounded)?;
        let solution = |rates: &Vec<f64>| {
            let constraints = self.scaled.query_constraints(query, rates)?;
            let solved = MobilitySolution::new(&resistance, set, &constraints, loads, None)?;
            let motion = set.state_velocity(solved.generalised.as_slice())?;
            Ok(InstantaneousSolution::new(
                solved.bodies(set, scale)?,
                solved.joint_forces(set, &constraints, loads, scale)?,
                self.scaled.motion_to_scene(&motion),
            ))
        };
        query.rates.iter().map(solution).collect()
    }

    fn joint_responses(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Vec<StateVelocity>, ModelError> {
        let spheres = Spheres::new(self.scaled.centres(configuration)?, self.radii.clone())?;
        let resistance = rpy::resistance(&spheres, &Medium::Unbounded)?;
        mobility::joint_responses(&self.scaled, configuration, &resistance)
    }

    fn cost(&mut self, _: Configuration<'_>) -> Result<Cost, ModelError> {
        Ok(Cost::default())
    }
}
