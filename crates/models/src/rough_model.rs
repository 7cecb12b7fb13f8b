//! A cheap model without error bars, to predict the size of displacements.

use microhydro::{Medium, PointMobility, PointModel, Spheres};
use nalgebra::DVector;
use rigid::StateVelocity;

use crate::error::ModelError;
use crate::hydrodynamics::Hydrodynamics;
use crate::linked_bodies::{self, LinkedBodies};
use crate::query::{Configuration, Query};
use crate::scaled_scene::ScaledScene;
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceEffect;
use scene::{Deformation, Scene};

/// Spheres in unbounded fluid with the Rotne-Prager-Yamakawa mobility, whatever the scene has.
///
/// Another shape is replaced by the sphere with the mean of its half extents as radius, and walls,
/// slip and background flow are ignored, and so are modes of deformation and undulations. Spheres
/// whose radii change push each other by the flow of their sources. The displacements of a stroke
/// have the right order of magnitude, which is what tolerances of its parts need. Cost:
/// microseconds for a few bodies.
pub struct RoughModel {
    scaled: ScaledScene,
}

impl RoughModel {
    /// Creates the model of a scene.
    ///
    /// # Errors
    /// Joints or fixed bodies that contradict each other.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let scaled = ScaledScene::new(scene)?;
        Ok(Self { scaled })
    }

    /// The spheres in a configuration.
    fn spheres(&self, configuration: Configuration) -> Result<Spheres, ModelError> {
        let values = configuration.shape;
        let surfaced = self
            .scaled
            .surfaced()
            .map(|body| &self.scaled.scene.bodies()[body]);
        let radii = surfaced.map(|body| match &body.deformation {
            Some(Deformation::Sphere(sphere)) if body.shape.is_isotropic() => {
                sphere.sphere_radius(values)
            }
            _ => body.shape.mean_radius(),
        });
        let radii = radii
            .map(|radius| self.scaled.scale.length(radius))
            .collect();
        Ok(Spheres::new(self.scaled.centres(configuration)?, radii)?)
    }

    /// Velocities of point-like spheres in the flow of the sources of all others.
    fn of_sources(
        &self,
        configuration: Configuration,
        rates: &[f64],
    ) -> Result<Option<SurfaceEffect>, ModelError> {
        let ScaledScene { scene, scale, .. } = &self.scaled;
        if !scene.deforms() {
            return Ok(None);
        }
        let centres = self.scaled.centres(configuration)?;
        let unit = scale.length(1.0);
        let strength = |body: usize| {
            let size = scene.bodies()[body].deformation.as_ref()?.sphere()?.size?;
            let values = configuration.shape;
            let rate = rates[size.joint()] * size.radius_rate(values);
            Some(size.radius(values).powi(2) * rate * unit.powi(3))
        };
        let strengths: Vec<f64> = (self.scaled.surfaced())
            .map(|body| strength(body).unwrap_or_default())
            .collect();
        let mut velocities = DVector::zeros(6 * centres.len());
        for (number, x) in centres.iter().enumerate() {
            let others =
                (centres.iter().zip(&strengths).enumerate()).filter(|(other, _)| *other != number);
            for (_, (source, strength)) in others {
                let arm = x - source;
                let mut velocity = velocities.fixed_rows_mut::<3>(6 * number);
                velocity += arm * (strength / arm.norm().powi(3));
            }
        }
        Ok(Some(SurfaceEffect::of_velocities(velocities)))
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
        let spheres = self.spheres(query.configuration)?;
        let mobility = PointMobility::new(PointModel::Rpy, &spheres, &Medium::Unbounded)?;
        let solution = |rates: &Vec<f64>| {
            let linked = LinkedBodies::new(&self.scaled, query, rates)?;
            let effect = self.of_sources(query.configuration, rates)?;
            let solved = linked.all().by_point_forces(&mobility, effect.as_ref())?;
            Ok(linked.response(&solved.solution)?.into())
        };
        query.rates.iter().map(solution).collect()
    }

    fn joint_responses(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Option<Vec<StateVelocity>>, ModelError> {
        let spheres = self.spheres(configuration)?;
        let mobility = PointMobility::new(PointModel::Rpy, &spheres, &Medium::Unbounded)?;
        let solve =
            |linked: &LinkedBodies| Ok(linked.all().by_point_forces(&mobility, None)?.solution);
        linked_bodies::joint_responses(&self.scaled, configuration, solve).map(Some)
    }
}
