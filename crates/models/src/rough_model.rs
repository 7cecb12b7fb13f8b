//! A cheap model without error bars, to predict the size of displacements.

use microhydro::{Medium, PointMobility, PointModel, Spheres};
use rigid::StateVelocity;

use crate::error::ModelError;
use crate::hydrodynamics::Hydrodynamics;
use crate::linked_bodies::{self, LinkedBodies, MobilitySolution};
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

    /// The spheres in a configuration.
    fn spheres(&self, configuration: Configuration) -> Result<Spheres, ModelError> {
        let centres = self.scaled.centres(configuration)?;
        Ok(Spheres::new(centres, self.radii.clone())?)
    }
}

/// The solution by point forces in unbounded fluid.
fn solve(linked: &LinkedBodies, spheres: &Spheres) -> Result<MobilitySolution, ModelError> {
    let mobility = PointMobility::new(PointModel::Rpy, spheres, &Medium::Unbounded)?;
    let all = linked.all();
    let found = all.spheres(&mobility)?.solve(TOLERANCE)?;
    all.solution(&found.coordinates, found.forces, found.residual, 0.0)
}

/// Residual of the solutions, whose digits do not matter.
const TOLERANCE: f64 = 1e-10;

impl Hydrodynamics for RoughModel {
    fn scene(&self) -> &Scene {
        &self.scaled.scene
    }

    fn name(&self) -> &'static str {
        "rough"
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let spheres = self.spheres(query.configuration)?;
        let solution = |rates: &Vec<f64>| {
            let linked = LinkedBodies::new(&self.scaled, query, rates)?;
            Ok(linked.response(&solve(&linked, &spheres)?)?.into())
        };
        query.rates.iter().map(solution).collect()
    }

    fn joint_responses(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Option<Vec<StateVelocity>>, ModelError> {
        let spheres = self.spheres(configuration)?;
        let solve = |linked: &LinkedBodies| solve(linked, &spheres);
        linked_bodies::joint_responses(&self.scaled, configuration, solve).map(Some)
    }
}
