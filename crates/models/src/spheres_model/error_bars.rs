//! Error bars by other models: differences between solutions with successive references.

use microhydro::multipole::{self, Orders, SphereSlip};
use microhydro::{Medium, Spheres};
use nalgebra::{DMatrix, DVector};

use super::SpheresModel;
use super::sphere_resistances::SphereResistances;
use crate::error::ModelError;
use crate::linked_bodies::{LargestDifferences, LinkedBodies, MobilitySolution, SomeLinkages};
use crate::response::Response;
use crate::scaled_scene::MeanFlowCondition;
use crate::solution::{ErrorEstimate, InstantaneousSolution};
use crate::surface_motion::SurfaceEffect;

/// Errors of a solution.
#[derive(Default)]
pub(super) struct ModelErrors {
    /// Largest errors of any body; none if they are not estimated.
    pub bars: Option<LargestDifferences>,
    /// The error, computed minus exact.
    pub signed: Option<Response>,
    /// That of the generalised velocities, exact minus computed; none if nothing has its sign.
    pub generalised: Option<DVector<f64>>,
}

/// Effects of slip and background flow on the spheres.
pub(super) struct SurfaceEffects {
    pub computed: SurfaceEffect,
    /// The effect that differs by rounding.
    rounded: SurfaceEffect,
    /// The effect at the orders below; the difference times `tail` is the error.
    coarser: SurfaceEffect,
    tail: f64,
}

impl SurfaceEffects {
    /// The effects by expansions of these orders. The columns are the slip, the negative background
    /// flow, and a unit rate of each amplitude.
    ///
    /// # Errors
    /// Those of [`multipole::surface_flow`].
    pub fn by_expansions(
        (spheres, medium): (&Spheres, &Medium),
        orders: &Orders,
        columns: &[&SphereSlip],
        rates: &[f64],
    ) -> Result<Self, ModelError> {
        let flow = multipole::surface_flow(spheres, medium, orders, columns)?;
        // The traction of the background flow on a sphere is that of the flow inside with its
        // velocity on the surface.
        let of_flow = flow.inner_powers.column(1).into_owned();
        let effect = |velocities: &DMatrix<f64>, powers: &DMatrix<f64>| {
            SurfaceEffect::from_columns(velocities, powers, &of_flow, rates)
        };
        Ok(Self {
            computed: effect(&flow.velocities, &flow.powers),
            rounded: effect(&flow.rounded_velocities, &flow.rounded_powers),
            coarser: effect(&flow.coarser_velocities, &flow.coarser_powers),
            tail: flow.tail,
        })
    }
}

/// A resistance and an effect of surfaces whose solution differs from another one by a part of the
/// error.
pub(super) struct Reference<'a> {
    resistance: &'a DMatrix<f64>,
    effect: Option<SurfaceEffect>,
    /// Factor from the difference to the error.
    factor: f64,
}

impl Reference<'_> {
    /// The solution of some linkages.
    fn solution(&self, all: &SomeLinkages) -> Result<MobilitySolution, ModelError> {
        all.by_resistance(self.resistance, self.effect.as_ref())
    }
}

/// References of a solution: its error is the sum of the differences between successive ones,
/// starting with the solution, each times the factor of the later one.
///
/// The effect of the surfaces has its lower orders where the resistance has: in a narrow gap the
/// velocities `U_0` of force-free bodies change with the resistance `R`, and the force
/// `R (U - U_0)` changes far less than by one of both. Off an axis the gaps of the resistance are
/// the first of two coarser references and have all of that effect: the change of the expansions
/// comes after it, and bars are wider than they need be.
pub(super) fn references<'a>(
    resistances: &'a SphereResistances,
    surfaces: Option<&SurfaceEffects>,
) -> Vec<Reference<'a>> {
    let reference = |effect: Option<SurfaceEffect>| {
        move |(resistance, factor): &'a (DMatrix<f64>, f64)| Reference {
            resistance,
            effect: effect.clone(),
            factor: *factor,
        }
    };
    let factor = resistances.coarser.first().map_or(1.0, |first| first.1);
    let rounded = surfaces.map(|effects| effects.rounded.clone());
    let coarser = surfaces.map(|effects| {
        // Without gaps both factors are zero.
        let factor = if factor > 0.0 {
            effects.tail / factor
        } else {
            0.0
        };
        (effects.rounded).changed(factor, [&effects.computed, &effects.coarser])
    });
    let references = resistances.references.iter().map(reference(rounded));
    references
        .chain(resistances.coarser.iter().map(reference(coarser)))
        .collect()
}

/// Visits successive solutions, the first of them `solved`, with the factor of the later one.
pub(super) fn follow(
    references: &[Reference],
    all: &SomeLinkages,
    solved: MobilitySolution,
    mut visit: impl FnMut(f64, [&MobilitySolution; 2]) -> Result<(), ModelError>,
) -> Result<(), ModelError> {
    let mut previous = solved;
    for reference in references {
        let solution = reference.solution(all)?;
        visit(reference.factor, [&previous, &solution])?;
        previous = solution;
    }
    Ok(())
}

impl SpheresModel {
    /// Errors that are found by other models: the differences of successive solutions, the first of
    /// them `computed`, each times the factor of the later one.
    ///
    /// # Errors
    /// Bodies that are too close.
    pub(super) fn errors_by(
        &self,
        linked: &LinkedBodies,
        computed: &MobilitySolution,
        references: &[Reference],
    ) -> Result<ModelErrors, ModelError> {
        let all = linked.all();
        let mut bars = LargestDifferences::default();
        let mut signed: Option<Response> = None;
        let mut generalised = DVector::zeros(computed.generalised.len());
        follow(references, &all, computed.clone(), |factor, [from, to]| {
            bars.add(factor, &all.largest_differences(from, to));
            generalised += factor * (&to.generalised - &from.generalised);
            let change = &linked.response(from)? - &linked.response(to)?;
            let change = &change * factor;
            signed = Some(match signed.take() {
                Some(sum) => sum + &change,
                None => change,
            });
            Ok(())
        })?;
        Ok(ModelErrors {
            bars: Some(bars),
            signed,
            generalised: Some(generalised),
        })
    }

    /// Enters the error bars of the model, in the units of the scene.
    pub(super) fn enter_errors(&self, solution: &mut InstantaneousSolution, errors: ModelErrors) {
        solution.model_error = errors.signed;
        let Some(bars) = errors.bars else { return };
        let scale = &self.scaled.scale;
        solution.error_estimate = ErrorEstimate::of_model(scale.length_to_scene(bars.velocity));
        solution.angular_velocity_error = ErrorEstimate::of_model(bars.angular_velocity);
        solution.force_error = ErrorEstimate::of_model(scale.force_to_scene(bars.force));
        solution.torque_error = ErrorEstimate::of_model(scale.torque_to_scene(bars.torque));
        solution.power_error = ErrorEstimate::of_model(scale.power_to_scene(bars.power));
        solution.linkage_power_error = Some(bars.linkage_power);
        if let Some(size) = self.scaled.scene.domain().period() {
            let of_flow = match self.scaled.mean_flow() {
                MeanFlowCondition::TotalForce(_) => scale.length_to_scene(bars.mean_flow),
                MeanFlowCondition::Velocity(_) => {
                    scale.force_to_scene(bars.total_force) / size.product()
                }
            };
            solution.mean_flow_error = ErrorEstimate::of_model(of_flow);
        }
    }
}
