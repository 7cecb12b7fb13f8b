//! The flow at points in space, from that in the meridian plane.

use axisymmetric::{BodyVelocity, MeridianFlow};
use nalgebra::Vector3;

use super::AxisymmetricModel;
use super::axial_surfaces::AxialSurfaces;
use crate::error::ModelError;
use crate::flow_field::PointFlow;
use crate::hydrodynamics::Hydrodynamics;
use crate::query::Configuration;
use crate::response::BodySolution;
use crate::surface_motion::SurfaceMotion;

impl AxisymmetricModel {
    /// Velocity and pressure at points, to a few thousandths of the velocities of the bodies.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`]; failures of the mesh of the meridian plane.
    pub(super) fn flow_in_meridian_plane(
        &mut self,
        configuration: Configuration,
        rates: &[f64],
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<PointFlow>>, ModelError> {
        let solution = self.solve_one(configuration, rates)?;
        let resistances = self.resistances_at(configuration, self.tolerance)?;
        let surfaces = AxialSurfaces::new(&self.scaled, configuration, &resistances, &self.axis)?;
        let scale = self.scaled.scale;
        let velocities = self.body_velocities(&solution.bodies, surfaces.as_ref());
        let bodies = self.on_axis(configuration)?;
        let flow = match &self.law {
            Some(law) => MeridianFlow::with_law(&bodies, self.surroundings, &velocities, law)?,
            None => MeridianFlow::new(&bodies, self.surroundings, &velocities)?,
        };
        let origin = self.origin(&self.scaled.centres(configuration)?);
        let motion = SurfaceMotion::new(
            &self.scaled,
            &self.scaled.poses(configuration)?,
            configuration.shape,
        );
        // The position along the axis, the distance from it, and the unit vector away from it.
        let place = |x: &Vector3<f64>| {
            let arm = x - origin;
            let along = arm.dot(&self.axis);
            let away = arm - along * self.axis;
            (along, away.norm(), away.try_normalize(0.0))
        };
        let scaled: Vec<Vector3<f64>> = (points.iter()).map(|x| scale.length(*x)).collect();
        let places: Vec<_> = scaled.iter().map(place).collect();
        let in_plane: Vec<[f64; 2]> = places.iter().map(|(z, r, _)| [*z, *r]).collect();
        let values = flow.at_points(&in_plane).into_iter();
        let at_point = |((value, (_, _, away)), x): ((Option<_>, _), &Vector3<f64>)| {
            let value: axisymmetric::MeridianValue = value?;
            let away: Vector3<f64> = Option::unwrap_or_default(away);
            let (background, pressure) = motion.as_ref().map_or((Vector3::zeros(), 0.0), |m| {
                (m.background(x), m.background_pressure(x))
            });
            let velocity = self.axis * value.axial
                + away * value.radial
                + self.axis.cross(&away) * value.azimuthal
                + background;
            Some(PointFlow {
                velocity: scale.length_to_scene(velocity),
                pressure: Some(scale.pressure_to_scene(value.pressure + pressure)),
            })
        };
        Ok(values.zip(places).zip(&scaled).map(at_point).collect())
    }

    /// Scaled velocities of the bodies with surfaces relative to the background flow.
    pub(super) fn body_velocities(
        &self,
        bodies: &[BodySolution],
        surfaces: Option<&AxialSurfaces>,
    ) -> Vec<BodyVelocity> {
        let surfaced = self.scaled.surfaced().map(|body| &bodies[body]);
        surfaced
            .enumerate()
            .map(|(body, solved)| {
                let speed = self.scaled.scale.length(solved.velocity.dot(&self.axis));
                let moving = match surfaces {
                    Some(surfaces) => surfaces.of_body(body, speed),
                    None => BodyVelocity {
                        axial: speed,
                        ..BodyVelocity::default()
                    },
                };
                BodyVelocity {
                    angular: solved.angular_velocity.dot(&self.axis),
                    ..moving
                }
            })
            .collect()
    }
}
