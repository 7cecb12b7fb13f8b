//! Finite-element solutions in the scene's units.

use std::sync::Arc;

use mesh::TetMesh;
use nalgebra::Vector3;
use rigid::{Articulation, FlowSolution};
use stokes::{Regularisation, Solution, SurfacePowers};

use super::far_field::{FarField, total_force};
use super::moving_frame::MovingFrame;
use crate::discretisation_error::{DiscretisationError, REGULARISATION_FACTOR, Uncertainty};
use crate::error::ModelError;
use crate::flow_field::{FlowField, SolutionFlow};
use crate::response::BodySolution;
use crate::scaled_scene::{ScaledResponse, ScaledScene};
use crate::solution::{ErrorEstimate, InstantaneousSolution};
use crate::surface_motion::SurfaceMotion;
use crate::units::Scale;

/// Relative uncertainty of the correction of a stresslet, in addition to that of the energy.
///
/// A stresslet is no power of the flow, so cubic elements resolve less of its error: 85 to 98
/// percent for spheres at gaps of 0.05 to 2 radii from a wall (`docs/figures/random_cases.py`, lone
/// bodies of the seeds 5001 to 5024). Without it a quarter of these errors was above the bar, up to
/// 3.7 bars; with 0.15, 3 of 13 beside walls (seeds 6001 to 6032), up to 1.19 bars.
const STRESSLET_UNCERTAINTY: f64 = 0.25;

/// Uncertainty of forces beside bodies whose volume changes, relative to their correction.
///
/// Cubic elements resolved 91 percent of the error of a link between two spheres that grow, whose
/// uncorrected force was wrong by a tenth; without this the error was 1.84 bars
/// (`docs/figures/random_cases.py`, growth of the seed 160002; five others of the seeds 160001 to
/// 160006 and 16 of 17 before were within their bars).
const FORCE_OF_SOURCES: f64 = 0.1;

/// What the conversion of a solution to the scene's units needs.
pub struct ToScene<'a> {
    pub scaled: &'a ScaledScene,
    /// Time of the solution, on which given velocities of bodies depend.
    pub time: f64,
    /// The ball that replaces unbounded fluid.
    pub far_field: Option<FarField>,
    /// Relative error of velocities caused by the container.
    pub container_error: f64,
}

impl ToScene<'_> {
    /// Converts a solution: corrected, if errors were estimated, and with the far-field correction.
    ///
    /// The flow of `solved` is replaced by the corrected one. `rates` are the scaled rates of the
    /// amplitudes of deformations.
    ///
    /// # Errors
    /// A solution for another set of bodies.
    pub fn answer(
        &self,
        solved: &mut Solution,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        let set = &self.scaled.set;
        let far_field = |flow: &FlowSolution| {
            let velocity = |far: FarField| far.velocity_correction(total_force(flow));
            self.far_field.map_or_else(Vector3::zeros, velocity)
        };
        let before = far_field(&solved.flow);
        let unshifted = solved.estimate.as_ref().map(|_| solved.flow.clone());
        shift(set, before, &mut solved.flow);
        let computed = self.convert(solved, &solved.flow, (&solved.powers, rates))?;
        let (Some(estimate), Some(mut corrected)) = (&solved.estimate, unshifted) else {
            return Ok(computed);
        };
        corrected.add(&estimate.change)?;
        let after = far_field(&corrected);
        // The solve gave held bodies the velocity `-before` in addition to their own, so that
        // `before` brings them to their own. The effect of `after - before` on the other bodies is
        // part of the container error.
        let has_fixed = set.held_translation().contains(&true);
        shift(set, if has_fixed { before } else { after }, &mut corrected);
        let mut powers = solved.powers.clone();
        powers.accumulate(1.0, &estimate.powers);
        let mut answer = self.convert(solved, &corrected, (&powers, rates))?;
        if let (true, Some(bar)) = (has_fixed, &mut answer.error_estimate.container) {
            *bar += self.scaled.scale.length_to_scene((after - before).norm());
        }
        let (scale, shortest_lever) = (&self.scaled.scale, self.scaled.shortest_lever);
        let (bodies, holding) = (|| answer.bodies.iter(), || answer.holding.iter());
        let of_sources = |largest: f64| estimate.source_uncertainty * largest;
        let force =
            largest_norm((bodies().map(|b| b.force)).chain(holding().map(|load| load.force)));
        let torque =
            largest_norm((bodies().map(|b| b.torque)).chain(holding().map(|load| load.torque)));
        let lever = scale.length_to_scene(shortest_lever);
        let pairs = (computed
            .bodies
            .iter()
            .zip(bodies())
            .map(|(a, b)| a.force - b.force))
        .chain((computed.holding.iter().zip(holding())).map(|(a, b)| a.force - b.force));
        let of_correction = match estimate.source_uncertainty > 0.0 {
            true => FORCE_OF_SOURCES * largest_norm(pairs),
            false => 0.0,
        };
        let uncertainty = Uncertainty {
            relative: estimate.relative_uncertainty,
            velocity: (scale.length_to_scene(estimate.uncertainty))
                .hypot(of_sources(largest_norm(bodies().map(|b| b.velocity)))),
            angular_velocity: (estimate.uncertainty / shortest_lever).hypot(of_sources(
                largest_norm(bodies().map(|b| b.angular_velocity)),
            )),
            force: of_sources(force).hypot(of_correction),
            // An error of a force on a part of a surface has a lever.
            torque: of_sources(torque.max(lever * force)),
            power: self.scaled.scale.power_to_scene(estimate.power_uncertainty),
        };
        let of_facets = (self.scaled.scale).torque_to_scene(estimate.stresslet_uncertainty);
        answer.stresslets = (answer.stresslets.take().zip(computed.stresslets.as_ref())).map(
            |(corrected, computed)| {
                let relative = uncertainty.relative.hypot(STRESSLET_UNCERTAINTY);
                corrected.correcting(computed, relative, of_facets)
            },
        );
        answer.set_mesh_error(DiscretisationError::between(
            &computed,
            &answer,
            uncertainty,
        ));
        solved.flow = corrected;
        Ok(answer)
    }

    /// The largest effects of the regularisation of a viscosity law, as bars.
    ///
    /// # Errors
    /// A change for another set of bodies.
    fn effects(&self, regularisation: &Regularisation) -> Result<Effects, ModelError> {
        let change =
            ScaledResponse::of_flow(&regularisation.change, 0.0, Vec::new(), &self.scaled.set)?;
        let bodies = self.scaled.change_to_scene(change).bodies;
        let bar = |of: fn(&BodySolution) -> Vector3<f64>| {
            REGULARISATION_FACTOR * largest_norm(bodies.iter().map(of))
        };
        let power = self.scaled.scale.power_to_scene(regularisation.power);
        Ok(Effects {
            speed: bar(|b| b.velocity),
            spin: bar(|b| b.angular_velocity),
            force: bar(|b| b.force),
            torque: bar(|b| b.torque),
            power: REGULARISATION_FACTOR * power,
        })
    }

    /// Converts a solution with `flow` and `powers` in place of its own.
    fn convert(
        &self,
        solution: &Solution,
        flow: &FlowSolution,
        (powers, rates): (&SurfacePowers, &[f64]),
    ) -> Result<InstantaneousSolution, ModelError> {
        let (scale, set) = (&self.scaled.scale, &self.scaled.set);
        let amplitudes = rates.iter().copied().zip(powers.rates.iter().copied());
        let scaled = ScaledResponse::of_flow(flow, powers.slip, amplitudes.collect(), set)?;
        let response = self.scaled.response_to_scene(self.time, scaled);
        let bodies = &response.bodies;
        let holding = || response.holding.iter();
        let mut speed = largest_norm(bodies.iter().map(|b| b.velocity));
        if self.scaled.scene.has_surface_velocity() || self.scaled.scene.deforms() {
            // Bodies at rest disturb a background flow too, and by their deformation.
            let fastest = largest_norm(flow.velocity.iter().copied());
            speed = speed.max(scale.length_to_scene(fastest));
        }
        // Errors of the velocity turn a linkage about its farthest point.
        let lever = self.scaled.shortest_lever;
        let spin = largest_norm(bodies.iter().map(|b| b.angular_velocity))
            .max(scale.length(speed) / lever);
        // Without joints or held bodies the forces are the given loads.
        let are_given = set.joints().is_empty() && set.held_bodies().next().is_none();
        let [force, torque] = match are_given {
            true => [0.0; 2],
            false => [
                largest_norm((bodies.iter().map(|b| b.force)).chain(holding().map(|h| h.force))),
                largest_norm((bodies.iter().map(|b| b.torque)).chain(holding().map(|h| h.torque))),
            ],
        };
        let power = response.power().abs();
        // The equations have no approximation but the regularisation of a viscosity law, which
        // matters where something moves.
        let is_regularised = self.scaled.law().is_some_and(|law| law.is_regularised());
        let (is_known, effects) = match &solution.regularisation {
            Some(regularisation) => (true, self.effects(regularisation)?),
            None => (!is_regularised || speed == 0.0, Effects::default()),
        };
        let bars = |size: f64, effect: f64| ErrorEstimate {
            container: Some(self.container_error * size),
            model: is_known.then_some(effect),
            algebraic: Some(solution.algebraic_error * size),
            ..ErrorEstimate::default()
        };
        Ok(InstantaneousSolution {
            stresslets: Some(self.scaled.stresslets_to_scene(&flow.stresslets)),
            dofs: solution.dofs,
            error_estimate: bars(speed, effects.speed),
            angular_velocity_error: bars(spin, effects.spin),
            force_error: bars(force, effects.force),
            torque_error: bars(torque, effects.torque),
            // At given velocities the power changes by that of the stress, at given forces in
            // proportion to the velocities.
            power_error: bars(
                power,
                [(effects.force, force), (effects.speed, speed)]
                    .into_iter()
                    .map(|(effect, size)| {
                        if size > 0.0 {
                            power * effect / size
                        } else {
                            0.0
                        }
                    })
                    .fold(effects.power, f64::max),
            ),
            checks: solution.checks,
            solver: solution.solver.clone(),
            seconds: solution.seconds,
            ..response.into()
        })
    }
}

/// Largest changes of velocities and forces of bodies and of the power, in the units of the scene.
#[derive(Default)]
struct Effects {
    speed: f64,
    spin: f64,
    force: f64,
    torque: f64,
    power: f64,
}

/// Adds a velocity to that of all bodies and of the fluid, which changes no force.
fn shift(set: &Articulation, correction: Vector3<f64>, flow: &mut FlowSolution) {
    flow.velocity.iter_mut().for_each(|u| *u += correction);
    let layout = set.velocity_layout();
    for body in 0..set.kinds().len() {
        let mut velocity = flow.generalised.fixed_rows_mut::<3>(layout.bodies()[body]);
        velocity += correction;
    }
    for frame in &mut flow.state.frames {
        frame.linear += correction;
    }
    for body in 0..flow.bodies.len() / 6 {
        let mut velocity = flow.bodies.fixed_rows_mut::<3>(6 * body);
        velocity += correction;
    }
}

fn largest_norm(vectors: impl Iterator<Item = Vector3<f64>>) -> f64 {
    vectors.fold(0.0, |m, v| m.max(v.norm()))
}

/// The flow of a solution in scaled units, with all that its conversion needs.
pub(super) struct ScaledFlow {
    pub mesh: Arc<TetMesh>,
    pub flow: FlowSolution,
    /// Motion of the surfaces; `flow` is the disturbance of the background flow.
    pub motion: Option<SurfaceMotion>,
    /// The frame of mesh and flow, if it moves.
    pub frame: Option<MovingFrame>,
    pub scale: Scale,
}

impl From<ScaledFlow> for SolutionFlow {
    fn from(flow: ScaledFlow) -> Self {
        Self::new(move || flow.field())
    }
}

impl ScaledFlow {
    /// The flow with the background flow, in the units of the scene and the laboratory frame.
    ///
    /// # Errors
    /// Points that overflow.
    fn field(&self) -> Result<FlowField, ModelError> {
        let Self {
            mesh,
            flow,
            motion,
            frame,
            scale,
        } = self;
        let background = |node: usize| {
            let of_node = |motion: &SurfaceMotion| motion.background(&mesh.points()[node]);
            motion.as_ref().map_or_else(Vector3::zeros, of_node)
        };
        let background_pressure = |node: usize| {
            let of_node = |motion: &SurfaceMotion| motion.background_pressure(&mesh.points()[node]);
            motion.as_ref().map_or(0.0, of_node)
        };
        // A mesh that ends at symmetry planes is unfolded to the whole domain.
        let whole = scale.mesh_to_scene(mesh)?.unfolded()?;
        let velocity = whole.sources.iter().map(|(node, signs)| {
            let node = *node as usize;
            let velocity = flow.velocity[node] + background(node);
            scale.length_to_scene(velocity.component_mul(signs))
        });
        let of_vertices = whole.sources.iter().take(whole.mesh.n_vertices());
        let pressure = of_vertices.map(|(vertex, _)| {
            let vertex = *vertex as usize;
            flow.pressure[vertex] + background_pressure(vertex)
        });
        let mut field = FlowField {
            velocity: velocity.collect(),
            pressure: pressure.map(|p| scale.pressure_to_scene(p)).collect(),
            mesh: whole.mesh,
        };
        if let Some(frame) = frame {
            field.move_by(&frame.to_laboratory(1.0))?;
        }
        Ok(field)
    }
}
