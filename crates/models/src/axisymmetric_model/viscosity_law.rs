//! Motions along the axis in a fluid whose viscosity depends on the shear rate.

use std::time::Instant as Clock;

use axisymmetric::{
    AxialBody, AxialChange, AxialForceSolver, AxialForces, AxialSpheroid, SteadyDrive, law_change,
};
use nalgebra::{DMatrix, DVector};
use scene::Scene;
use scene::rheology::{Law, ViscosityLaw};
use stokes::Seconds;

use super::axial_surfaces::{AxialSurfaces, grand_resistance, spatial};
use super::{AxisymmetricModel, LOWEST_ACCURACY};
use crate::discretisation_error::{DiscretisationError, REGULARISATION_FACTOR, Uncertainty};
use crate::error::ModelError;
use crate::linked_bodies::{LinkedBodies, MobilitySolution};
use crate::neglected_terms::{FirstOrderChange, PathPoint};
use crate::query::Query;
use crate::response::{BodySolution, Response};
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceEffect;

/// Bounds of the error of the highest order, relative to its difference from the order before.
///
/// Orders divide differences by less than two (power laws) to fifty. Ratios of two differences are
/// no surer than the lower bound. The upper one is for differences that do not decrease: an
/// algebraic error `p^-k` of first order is `p = 10` times the last difference, and twice that is
/// the bar.
const UNCERTAINTY: [f64; 2] = [0.3, 20.0];

/// The same after a single difference, as if the next one were two thirds of it.
const UNCERTAINTY_OF_ONE: f64 = 4.0;

/// The lower bound for laws without a viscosity at rest, whose flows are not smooth where they are
/// at rest: an error `p^-k` at the order `p` is `p / k` of its difference from the order before,
/// and algebraic orders `k` are not above those of the elements.
const ALGEBRAIC_UNCERTAINTY: f64 = 1.0;

/// Factor on the remainder of a geometric series of differences.
const REMAINDER_FACTOR: f64 = 2.0;

/// Largest number of linearised balances of forces for one set of rates.
const MAX_BALANCES: usize = 40;

/// Largest number of balances whose step is shortened because it would reverse the motion.
const MAX_SHORTENED: usize = 20;

/// Change of the order, over the effect of the regularisation of the law, that is small enough.
const SHARE_OF_LAW: f64 = 0.1;

/// Relative error of a first-order change by the law: more is lost by the terms of second order.
const CHANGE_TOLERANCE: f64 = 1e-3;

impl AxisymmetricModel {
    /// The solution for one set of rates.
    ///
    /// Forces depend on velocities nonlinearly: Newton's method finds the velocities for which the
    /// forces and the loads on the joints balance, from those in a Newtonian fluid. The order of
    /// the elements is raised until velocities and forces change by less than the tolerance, on a
    /// finer mesh if the changes let expect that no order does.
    ///
    /// # Errors
    /// Bodies that left the axis; flows that Newton's method does not find.
    pub(super) fn law_solution(
        &mut self,
        query: &Query,
        rates: &[f64],
        law: &Law,
        tolerance: f64,
    ) -> Result<InstantaneousSolution, ModelError> {
        let clock = Clock::now();
        let configuration = query.configuration;
        let bodies = self.on_axis(configuration)?;
        // the start of Newton's method needs no accuracy
        let resistances = self.resistances_at(configuration, LOWEST_ACCURACY)?;
        let linked = LinkedBodies::new(&self.scaled, query, rates)?;
        let surfaces = AxialSurfaces::new(&self.scaled, configuration, &resistances, &self.axis)?;
        let at_rest: Vec<_> = (0..bodies.len())
            .map(|body| surfaces.as_ref().map(|s| s.of_body(body, 0.0)))
            .collect();
        let slip = |body: usize, x: [f64; 2]| {
            at_rest[body]
                .as_ref()
                .map_or([0.0, 0.0], |surface| surface.slip(&bodies[body], x))
        };
        let resistance = resistances.axial.matrix();
        let n = bodies.len();
        let along = resistance.view((0, 0), (n, n)).into_owned();
        let effect = surfaces
            .as_ref()
            .map(|s| s.effect(resistance))
            .transpose()?;
        let mut velocities = self.newtonian_velocities(law, &along, &linked, effect.as_ref())?;
        let mut solver = AxialForceSolver::new(
            &bodies,
            self.surroundings,
            surfaces.is_some().then_some(&slip),
            law,
            tolerance,
        )?;
        // What the next balance changes is of the order of the square of the last change, but the
        // power of slip is known at the velocities before it.
        let balance_tolerance = match surfaces.is_some() {
            true => 0.1 * tolerance,
            false => (0.1 * tolerance).sqrt(),
        };
        let mut before: Option<Balanced> = None;
        let mut changes: Vec<f64> = Vec::new();
        loop {
            let last = self.balanced(&mut solver, &linked, &mut velocities, balance_tolerance)?;
            changes.extend(before.as_ref().map(|before| last.change_from(before)));
            // The effect of the regularisation is in the bar: no order reduces it.
            let enough = tolerance.max(SHARE_OF_LAW * last.forces.regularised);
            let is_accurate = changes.len() >= 2 && changes.last().is_some_and(|c| *c <= enough);
            let left = solver.orders_left();
            if !is_accurate && needs_refinement(law, &changes, left, enough) && solver.refine() {
                (before, changes) = (None, Vec::new());
                continue;
            }
            let is_highest = !solver.raise_order();
            if let Some(before) = before.filter(|_| is_accurate || is_highest) {
                let forces = DVector::from_vec(solver.change_by_regularisation()?);
                let at_rest = LinkedBodies::at_rest(&self.scaled, configuration, None)?;
                let regularised =
                    self.balanced_change(&last.forces.derivatives, &forces, &at_rest)?;
                let remainder = remainder(law, &changes);
                let change = changes.last().copied().unwrap_or_default();
                let error =
                    self.error_of(&before.response, (&last, &regularised), (remainder, change));
                let total = clock.elapsed().as_secs_f64();
                let (dofs, residual) = (last.forces.dofs, last.residual);
                let mut solution = InstantaneousSolution {
                    seconds: Seconds {
                        solve: total,
                        total,
                        ..Seconds::default()
                    },
                    ..InstantaneousSolution::solved_directly(before.response, dofs, residual)
                };
                solution.solver.iterations = last.forces.iterations;
                solution.correct(error);
                return Ok(solution);
            }
            before = Some(last);
        }
    }

    /// With what the effect of neglecting a viscosity law is unsupported; none if it is supported.
    pub fn without_law_change(scene: &Scene) -> Option<&'static str> {
        match (Self::has_swirl(scene), scene.deforms()) {
            (true, _) => Some("with rotation about the axis"),
            (_, true) => Some("with bodies that deform"),
            _ => None,
        }
    }

    /// The first-order change by the law that the flow neglects.
    ///
    /// The law changes the forces on the bodies at their velocities in the Newtonian fluid, and the
    /// velocities change so that the forces balance again.
    ///
    /// # Errors
    /// Bodies that left the axis; rotation about the axis; a law without a viscosity at rest.
    pub(super) fn law_change(
        &mut self,
        at: &PathPoint<'_>,
    ) -> Result<FirstOrderChange, ModelError> {
        let law = self.scaled.neglected_law()?;
        if let Some(what) = Self::without_law_change(&self.scaled.scene) {
            return Err(ModelError::unsupported(
                format!("the effect of neglecting the viscosity law {what} in the meridian plane"),
                "use model.kind = \"fem\"",
            ));
        }
        let bodies = self.on_axis(at.configuration)?;
        let resistances = self.resistances_at(at.configuration, LOWEST_ACCURACY)?;
        let rates = [at.rates.to_vec()];
        let query = Query::new(at.configuration, &rates);
        let linked = LinkedBodies::new(&self.scaled, &query, at.rates)?;
        let surfaces =
            AxialSurfaces::new(&self.scaled, at.configuration, &resistances, &self.axis)?;
        let amplitudes: Option<Vec<_>> = (surfaces.as_ref()).map(|surfaces| {
            (0..bodies.len())
                .map(|body| surfaces.of_body(body, 0.0))
                .collect()
        });
        let slip = |body: usize, x: [f64; 2]| {
            (amplitudes.as_ref()).map_or([0.0; 2], |of| of[body].slip(&bodies[body], x))
        };
        let (n, resistance) = (bodies.len(), resistances.axial.matrix());
        let along = resistance.view((0, 0), (n, n)).into_owned();
        let effect = surfaces
            .map(|surfaces| surfaces.effect(resistance))
            .transpose()?;
        let newtonian = self.mobility(&along, &linked, effect.as_ref())?;
        let rows = self.scaled.set.surface_velocities();
        let velocities = self.along_axis(&newtonian.generalised.select_rows(&rows));
        let moving: Vec<_> = bodies.iter().copied().map(AxialBody::prescribed).collect();
        let drive = SteadyDrive {
            velocities: &velocities,
            slip: amplitudes.is_some().then_some(&slip),
            ..SteadyDrive::default()
        };
        let found = law_change(&moving, self.surroundings, &drive, &law, CHANGE_TOLERANCE)?;
        let at_rest = LinkedBodies::at_rest(&self.scaled, at.configuration, None)?;
        let change = |change: &AxialChange| {
            let forces = DVector::from_column_slice(&change.forces);
            self.balanced_change(&along, &forces, &at_rest)
        };
        FirstOrderChange::by_law(&found.by_viscosity, found.by_square.as_ref(), change)
    }

    /// The change of motion and loads by a change of the forces at the same velocities.
    fn balanced_change(
        &self,
        along: &DMatrix<f64>,
        forces: &DVector<f64>,
        at_rest: &LinkedBodies,
    ) -> Result<Response, ModelError> {
        let effect = self.force_free(along, forces)?;
        at_rest.change(&self.mobility(along, at_rest, Some(&effect))?)
    }

    /// Velocities for which forces and loads balance, by elements of one order: the last balance
    /// changes them by at most `tolerance` of the largest one.
    fn balanced(
        &self,
        solver: &mut AxialForceSolver,
        linked: &LinkedBodies,
        velocities: &mut Vec<f64>,
        tolerance: f64,
    ) -> Result<Balanced, ModelError> {
        let (mut change, mut shortened) = (f64::INFINITY, 0);
        for _ in 0..MAX_BALANCES {
            let forces = solver.solve(velocities)?;
            let solved = self.linearised(&forces, velocities, linked)?;
            let next = self.along_axis(
                &solved
                    .generalised
                    .select_rows(&self.scaled.set.surface_velocities()),
            );
            let largest = (next.iter().zip(velocities.iter()))
                .map(|(new, old)| (new - old).abs())
                .fold(0.0, f64::max);
            let speed = forces.largest_speed.max(largest);
            change = if largest > 0.0 { largest / speed } else { 0.0 };
            let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let (along, square) = (dot(velocities, &next), dot(velocities, velocities));
            if change > tolerance && along < 0.0 && shortened < MAX_SHORTENED {
                // Where forces grow like `U^n`, Newton's step from a speed that is too large by
                // more than a factor of `(1 - n)^(-1 / n)` reverses it, and the next one again.
                shortened += 1;
                let length = 0.5 * square / (square - along);
                let towards = velocities.iter_mut().zip(&next);
                towards.for_each(|(old, new)| *old += length * (new - *old));
                continue;
            }
            *velocities = next;
            if change <= tolerance {
                return Ok(Balanced {
                    response: linked.response(&solved)?,
                    velocities: velocities.clone(),
                    on_fluid: self.along_axis(&solved.forces),
                    forces,
                    residual: solved.residual,
                });
            }
        }
        Err(ModelError::unsupported(
            format!(
                "the balance of forces in a fluid with this viscosity law, whose velocities still \
                 change by {change:.1e} of the largest after {MAX_BALANCES} iterations,"
            ),
            "raise fluid.index or fluid.infinite_shear_viscosity",
        ))
    }

    /// The balance with forces `F + J (U - U_old)`.
    fn linearised(
        &self,
        forces: &AxialForces,
        velocities: &[f64],
        linked: &LinkedBodies,
    ) -> Result<MobilitySolution, ModelError> {
        let derivatives = &forces.derivatives;
        let of_forces =
            self.force_free(derivatives, &DVector::from_column_slice(&forces.forces))?;
        let effect = SurfaceEffect {
            velocities: of_forces.velocities + spatial(&self.axis, velocities),
            powers: DVector::from_element(1, forces.slip_power),
            ..of_forces
        };
        self.mobility(derivatives, linked, Some(&effect))
    }

    /// The effect of forces on bodies with a resistance: the velocities at which they vanish.
    fn force_free(
        &self,
        along: &DMatrix<f64>,
        forces: &DVector<f64>,
    ) -> Result<SurfaceEffect, ModelError> {
        let factor = along.clone().cholesky().ok_or_else(|| {
            let name = "derivative of the forces by the velocities";
            let remedy = "raise fluid.index or fluid.infinite_shear_viscosity";
            ModelError::not_positive_definite(name, along, remedy)
        })?;
        let change = -factor.solve(forces);
        let velocities = spatial(&self.axis, change.as_slice());
        Ok(SurfaceEffect::of_velocities(velocities))
    }

    /// The solution of a balance with a resistance to motions along the axis.
    fn mobility(
        &self,
        along: &DMatrix<f64>,
        linked: &LinkedBodies,
        effect: Option<&SurfaceEffect>,
    ) -> Result<MobilitySolution, ModelError> {
        let matrix = grand_resistance(&self.shapes, &self.axis, along, None);
        linked.all().by_resistance(&matrix, effect)
    }

    /// Velocities in a Newtonian fluid whose viscosity is that of the law at the speed over the
    /// smallest semi-axis.
    fn newtonian_velocities(
        &self,
        law: &Law,
        along: &DMatrix<f64>,
        linked: &LinkedBodies,
        effect: Option<&SurfaceEffect>,
    ) -> Result<Vec<f64>, ModelError> {
        /// Steps to a viscosity of which Newton's method needs the magnitude only.
        const STEPS: usize = 20;
        let smallest = (self.shapes.iter())
            .map(|shape: &AxialSpheroid| shape.axial.min(shape.equatorial))
            .fold(f64::INFINITY, f64::min);
        let mut viscosity = 1.0;
        let mut velocities = Vec::new();
        for _ in 0..STEPS {
            let solved = self.mobility(&(along * viscosity), linked, effect)?;
            let rows = self.scaled.set.surface_velocities();
            velocities = self.along_axis(&solved.generalised.select_rows(&rows));
            let speed = velocities.iter().fold(0.0, |m: f64, u| m.max(u.abs()));
            let next = law.viscosity(speed / smallest);
            let ratio = next / viscosity;
            if !(next > 0.0 && next.is_finite()) || (0.8..1.25).contains(&ratio) {
                break;
            }
            viscosity = next;
        }
        Ok(velocities)
    }

    /// Components along the axis of velocities or forces of the bodies with surfaces.
    fn along_axis(&self, spatial: &DVector<f64>) -> Vec<f64> {
        (0..self.shapes.len())
            .map(|body| spatial.fixed_rows::<3>(6 * body).dot(&self.axis))
            .collect()
    }

    /// Error of the response by the order before, with the bars of the last one and its change by
    /// the regularisation; `relative` is the uncertainty of the last relative change.
    fn error_of(
        &self,
        before: &Response,
        (last, regularised): (&Balanced, &Response),
        (relative, change): (f64, f64),
    ) -> DiscretisationError {
        let response = &last.response;
        let outside = last.forces.error_outside;
        // Largest size of a quantity, and its largest change by the regularisation.
        let of_law = |of: fn(&BodySolution) -> f64| {
            [&response.bodies, &regularised.bodies]
                .map(|bodies| bodies.iter().fold(0.0, |m: f64, body| m.max(of(body))))
        };
        let sizes = [
            of_law(|body| body.velocity.norm()),
            of_law(|body| body.force.norm()),
        ];
        let [velocity, force] =
            sizes.map(|[size, change]| outside * size + REGULARISATION_FACTOR * change);
        // At given velocities the power changes by that of the stress, at given forces in
        // proportion to the velocities.
        let of_power = sizes
            .map(|[size, change]| if size > 0.0 { change / size } else { 0.0 })
            .into_iter()
            .fold(last.forces.regularised, f64::max);
        let uncertainty = Uncertainty {
            relative,
            velocity,
            angular_velocity: 0.0,
            force,
            torque: 0.0,
            // Errors of forces and of slip may cancel in the one number of the order before.
            power: (outside + REGULARISATION_FACTOR * of_power + relative * change)
                * response.power().abs(),
        };
        DiscretisationError::between(before, response, uncertainty)
    }
}

/// Error of the last order over the last of these differences between orders.
///
/// Differences with the ratio `q` have the remainder `q / (1 - q)`. Ratios go up and down: `q` is
/// the larger of the last two.
fn remainder(law: &Law, changes: &[f64]) -> f64 {
    let [mut lower, upper] = UNCERTAINTY;
    if matches!(law, Law::PowerLaw { .. } | Law::HerschelBulkley { .. }) {
        lower = ALGEBRAIC_UNCERTAINTY;
    }
    let ratios = changes.windows(2).rev().take(2);
    let ratios = ratios.map(|pair| {
        if pair[1] > 0.0 {
            pair[1] / pair[0]
        } else {
            0.0
        }
    });
    match ratios.reduce(f64::max) {
        Some(q) if q < 1.0 => (REMAINDER_FACTOR * q / (1.0 - q)).clamp(lower, upper),
        Some(_) => upper,
        None => UNCERTAINTY_OF_ONE,
    }
}

/// Whether differences that go on to decrease by the larger of their last two ratios are above the
/// tolerance at the highest order, of the number of orders that are left.
///
/// At the edge of the fluid that does not flow orders and sizes of elements gain little, so that
/// what they reach is the answer.
fn needs_refinement(law: &Law, changes: &[f64], left: usize, tolerance: f64) -> bool {
    /// Fewer differences say nothing about how they decrease.
    const LEAST_DIFFERENCES: usize = 3;
    if matches!(law, Law::HerschelBulkley { .. }) || changes.len() < LEAST_DIFFERENCES {
        return false;
    }
    let ratio = changes
        .windows(2)
        .rev()
        .take(2)
        .map(|pair| pair[1] / pair[0]);
    let ratio = ratio.fold(0.0, f64::max).min(1.0);
    changes
        .last()
        .is_some_and(|last| last * ratio.powi(left as i32) > tolerance)
}

/// A motion whose forces balance, by elements of one order.
struct Balanced {
    response: Response,
    /// Velocities along the axis.
    velocities: Vec<f64>,
    /// Forces on the fluid along the axis.
    on_fluid: Vec<f64>,
    forces: AxialForces,
    residual: f64,
}

impl Balanced {
    /// Largest change of a velocity or a force relative to the largest one, or to the drag at the
    /// largest velocity.
    fn change_from(&self, before: &Self) -> f64 {
        let change = |a: &[f64], b: &[f64]| {
            (a.iter().zip(b)).fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()))
        };
        let speed = self.forces.largest_speed;
        let drag = speed * self.forces.derivatives.diagonal().amax();
        let ratio = |change: f64, size: f64| if change > 0.0 { change / size } else { 0.0 };
        let force = self.on_fluid.iter().fold(drag, |m, f| m.max(f.abs()));
        ratio(change(&self.velocities, &before.velocities), speed)
            .max(ratio(change(&self.on_fluid, &before.on_fluid), force))
    }
}
