//! Power of slip and other prescribed velocities of surfaces, computed and corrected.

use fem::{BoundaryFlow, CubicFlow, SurfaceVelocity};
use nalgebra::Vector3;
use rigid::FlowSolution;

use crate::StokesError;
use crate::cubic::{Change, Correction};
use crate::problem::Problem;
use crate::surface_flow::NodalSurfaceFlow;
use crate::viscous_stress::ViscousStress;

impl Problem<'_> {
    /// Power of a disturbance flow in the prescribed velocities of surfaces.
    ///
    /// With `stress` it is that of the whole flow, whose viscosity varies.
    /// The dissipation of the disturbance is this power and that of the rigid motions. On a mesh
    /// that ends at symmetry planes, it is the power of whole surfaces.
    ///
    /// # Errors
    /// A flow that is not finite.
    pub(crate) fn power_of_surfaces(
        &self,
        flow: &FlowSolution,
        surfaces: Option<&NodalSurfaceFlow>,
        stress: Option<ViscousStress>,
    ) -> Result<f64, StokesError> {
        Ok(match (surfaces, stress) {
            (Some(nodal), Some(stress)) => {
                self.parts() * stress.power(&flow.pressure, &nodal.velocity)?
            }
            (Some(nodal), None) => {
                let (velocity, pressure) = (&flow.velocity, &flow.pressure);
                self.parts() * fem::power(self.mesh, velocity, pressure, &nodal.velocity)?
            }
            (None, _) => 0.0,
        })
    }

    /// Power of the slip on the fluid, `∮ s · f dS` with the forces `f` of the whole flow.
    ///
    /// # Errors
    /// A flow that is not finite.
    pub(crate) fn slip_power(
        &self,
        flow: &FlowSolution,
        surfaces: Option<&NodalSurfaceFlow>,
        stress: Option<ViscousStress>,
    ) -> Result<f64, StokesError> {
        let Some(nodal) = surfaces else {
            return Ok(0.0);
        };
        if let Some(stress) = stress {
            return Ok(self.parts() * stress.power(&flow.pressure, &nodal.slip)?);
        }
        let (velocity, pressure) = nodal.whole(flow);
        Ok(self.parts() * fem::power(self.mesh, &velocity, &pressure, &nodal.slip)?)
    }

    /// The power of slip of a corrected flow, in cubic elements and on the true surfaces.
    ///
    /// `flow` is the computed disturbance, `change` its correction by `correction`. The slip, which
    /// is the test function, is interpolated in cubic elements too.
    ///
    /// # Errors
    /// A flow that is not finite.
    pub(crate) fn corrected_slip_power(
        &self,
        correction: &Correction<'_>,
        flow: &FlowSolution,
        change: &Change,
        nodal: &NodalSurfaceFlow,
    ) -> Result<f64, StokesError> {
        let Some(surface_flow) = self.surface_flow else {
            return Ok(0.0);
        };
        let slip = |tag: u16, x: Vector3<f64>| {
            let body = nodal.tags.iter().position(|body| *body == tag);
            body.map_or_else(Vector3::zeros, |body| surface_flow.slip(body, &x))
        };
        let slip: &SurfaceVelocity<'_> = &slip;
        let extension = &correction.extension;
        let mut bubbles = vec![0.0; extension.len()];
        correction.interpolate(nodal, slip, &nodal.slip, &mut bubbles)?;
        let mut corrected = flow.clone();
        corrected.add(&change.flow)?;
        let (velocity, pressure) = nodal.whole(&corrected);
        let equations = correction.equations;
        let power = extension.power(
            CubicFlow {
                velocity: &equations.restricted(&velocity),
                pressure: &equations.restricted(&pressure),
                extension: &change.extension,
            },
            CubicFlow {
                velocity: &equations.restricted(&nodal.slip),
                pressure: &[],
                extension: &bubbles,
            },
        )?;
        let (velocity, pressure) = nodal.whole(flow);
        let with_slip = |velocity| BoundaryFlow {
            velocity,
            surface_velocity: Some(slip),
        };
        let of_facets = (correction.geometry)
            .power((with_slip(&velocity), &pressure), with_slip(&nodal.slip))?;
        Ok(self.parts() * (power + of_facets))
    }
}
