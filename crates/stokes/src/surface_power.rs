//! Powers of slip, deformation and other prescribed velocities of surfaces, computed and corrected.

use fem::{BoundaryFlow, CubicFlow, SurfaceVelocity};
use nalgebra::Vector3;
use rigid::FlowSolution;

use crate::StokesError;
use crate::cubic::{Change, Correction};
use crate::problem::Problem;
use crate::surface_flow::NodalSurfaceFlow;
use crate::viscous_stress::ViscousStress;

/// Powers of the velocities of surfaces on the fluid, in addition to those of rigid motions.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SurfacePowers {
    /// Power of the slip.
    pub slip: f64,
    /// Power of the deformation for a rate of one of each shape coordinate: the force on its
    /// amplitude.
    pub rates: Vec<f64>,
}

impl SurfacePowers {
    /// The powers of the slip and each coordinate after it.
    fn of_parts(mut powers: Vec<f64>) -> Self {
        let rates = powers.split_off(powers.len().min(1));
        Self {
            slip: powers.first().copied().unwrap_or_default(),
            rates,
        }
    }

    /// Adds other powers times a factor.
    pub fn accumulate(&mut self, factor: f64, other: &Self) {
        self.slip += factor * other.slip;
        let rates = self.rates.iter_mut().zip(&other.rates);
        rates.for_each(|(own, other)| *own += factor * other);
    }
}

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
        surfaces.map_or(Ok(0.0), |nodal| {
            self.power_in((&flow.velocity, &flow.pressure), stress, &nodal.velocity)
        })
    }

    /// Power of a flow in given velocities of surfaces, by `stress` if the viscosity varies.
    ///
    /// # Errors
    /// A flow that is not finite.
    fn power_in(
        &self,
        (velocity, pressure): (&[Vector3<f64>], &[f64]),
        stress: Option<ViscousStress>,
        of_surfaces: &[Vector3<f64>],
    ) -> Result<f64, StokesError> {
        let power = match stress {
            Some(stress) => stress.power(pressure, of_surfaces)?,
            None => fem::power(self.mesh, velocity, pressure, of_surfaces)?,
        };
        Ok(self.parts() * power)
    }

    /// Powers of the slip, and of the deformation for a rate of one of each shape coordinate, on
    /// the fluid: `∮ d · f dS` with the forces `f` of the whole flow.
    ///
    /// # Errors
    /// A flow that is not finite.
    pub(crate) fn surface_powers(
        &self,
        flow: &FlowSolution,
        surfaces: Option<&NodalSurfaceFlow>,
        stress: Option<ViscousStress>,
    ) -> Result<SurfacePowers, StokesError> {
        let Some(nodal) = surfaces else {
            return Ok(SurfacePowers::default());
        };
        let whole;
        let of_flow: (&[_], &[_]) = match stress {
            // The stress is that of the whole flow already.
            Some(_) => (&flow.velocity, &flow.pressure),
            None => {
                whole = nodal.whole(flow);
                (&whole.0, &whole.1)
            }
        };
        let powers = (nodal.parts.iter()).map(|part| self.power_in(of_flow, stress, part));
        Ok(SurfacePowers::of_parts(powers.collect::<Result<_, _>>()?))
    }

    /// The powers of surfaces on a corrected flow, in cubic elements and on the true surfaces.
    ///
    /// `flow` is the computed disturbance, `change` its correction by `correction`. The velocities
    /// of surfaces, which are the test functions, are interpolated in cubic elements too.
    ///
    /// # Errors
    /// A flow that is not finite.
    pub(crate) fn corrected_surface_powers(
        &self,
        correction: &Correction<'_>,
        flow: &FlowSolution,
        change: &Change,
        nodal: &NodalSurfaceFlow,
    ) -> Result<SurfacePowers, StokesError> {
        let (extension, equations) = (&correction.extension, correction.equations);
        let mut corrected = flow.clone();
        corrected.add(&change.flow)?;
        let (velocity, pressure) = nodal.whole(&corrected);
        let (velocity, pressure) = (
            equations.restricted(&velocity),
            equations.restricted(&pressure),
        );
        let computed = nodal.whole(flow);
        let power = |(part, of_part): (usize, &Vec<Vector3<f64>>)| {
            let Some(own) = self.surface_part(part) else {
                return Ok(0.0);
            };
            let own: &SurfaceVelocity<'_> = &*own;
            let mut bubbles = vec![0.0; extension.len()];
            correction.interpolate(nodal, own, of_part, &mut bubbles)?;
            let power = extension.power(
                CubicFlow {
                    velocity: &velocity,
                    pressure: &pressure,
                    extension: &change.extension,
                },
                CubicFlow {
                    velocity: &equations.restricted(of_part),
                    pressure: &[],
                    extension: &bubbles,
                },
            )?;
            let on_surface = |velocity| BoundaryFlow {
                velocity,
                surface_velocity: Some(own),
            };
            let of_facets = (correction.geometry)
                .power((on_surface(&computed.0), &computed.1), on_surface(of_part))?;
            Ok(self.parts() * (power + of_facets))
        };
        let powers = nodal.parts.iter().enumerate().map(power);
        let powers = powers.collect::<Result<_, StokesError>>()?;
        Ok(SurfacePowers::of_parts(powers))
    }
}
