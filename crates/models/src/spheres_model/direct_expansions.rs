//! Solutions by expansions with a resistance matrix.

use std::time::Instant as Clock;

use microhydro::Medium;
use microhydro::multipole::SphereSlip;
use nalgebra::{DVector, Vector3};
use scene::ModelEstimatesKind;
use stokes::Seconds;

use super::SpheresModel;
use super::error_bars::{ModelErrors, SurfaceEffects, references};
use super::sphere_resistances::SphereResistances;
use crate::error::ModelError;
use crate::linked_bodies::{LargestDifferences, LinkedBodies};
use crate::query::{Configuration, Query};
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceMotion;

/// Part of [`SphereResistances::unbalanced_velocities`] below which no bar of a velocity is.
///
/// The changes of the forces on several spheres may give them nearly the same velocities by chance,
/// and their errors do not cancel as well: of linked pairs with similar radii, 7 % had velocity
/// errors above their bar, up to 165 times, and at most 0.074 of the unbalanced velocities.
pub(super) const UNBALANCED_PART: f64 = 0.08;

/// Factor on all bars beside slip in a ball.
///
/// Errors of three linked squirmers on its axis were 0.3 of the change between orders at some
/// orders, 0.9 to 1.0 (velocities, forces), 1.7 (stresslets) and 2.9 times it (powers) at others.
const SLIP_IN_BALL_FACTOR: f64 = 3.0;

impl SpheresModel {
    /// The solution for one set of rates by expansions with a resistance matrix.
    ///
    /// # Errors
    /// Those of the expansions; volumes that do not balance in a container.
    pub(super) fn direct_expansions(
        &mut self,
        query: &Query,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        let configuration = query.configuration;
        let clock = Clock::now();
        let resistances = self.resistance_at(configuration)?;
        let assembly = clock.elapsed().as_secs_f64();
        self.scaled.check_volume(configuration, rates)?;
        let surfaces = self.surface_effects((configuration, rates), &resistances)?;
        let effect = surfaces.as_ref().map(|effects| &effects.computed);
        let linked = LinkedBodies::new(&self.scaled, query, rates)?;
        let all = linked.all();
        let solved = all.by_resistance(&resistances.matrix, effect)?;
        let is_estimated = query.random_loads.is_none()
            && self.scaled.scene.model().estimates != ModelEstimatesKind::Off;
        let references = references(&resistances, surfaces.as_ref());
        let mut errors = match is_estimated {
            true => self.errors_by(&linked, &solved, &references)?,
            false => ModelErrors::default(),
        };
        let has_slip_in_ball = surfaces.is_some() && matches!(self.medium, Medium::Ball { .. });
        let beside_slip = if has_slip_in_ball {
            SLIP_IN_BALL_FACTOR
        } else {
            1.0
        };
        if let Some(bars) = &mut errors.bars {
            *bars = bars.times(&LargestDifferences::of_all(beside_slip));
            if !all.is_held() {
                let velocities = &self.scaled.set.surface_velocities();
                let mut velocities = solved.generalised.select_rows(velocities);
                if let Some(effect) = effect {
                    velocities -= &effect.velocities;
                }
                let unbalanced = resistances.unbalanced_velocities(&velocities);
                let [velocity, angular] = unbalanced.map(|largest| UNBALANCED_PART * largest);
                bars.velocity = bars.velocity.max(velocity);
                bars.angular_velocity = bars.angular_velocity.max(angular);
            }
            // Between two orders a rotation may change little by chance: its error was 2.5 times
            // its change. An error of the velocities may turn a linkage about its farthest point.
            let of_velocity = bars.velocity / self.scaled.shortest_lever;
            bars.angular_velocity = bars.angular_velocity.max(of_velocity);
        }
        // Errors of slip and background flow have no sign.
        errors.signed = errors.signed.filter(|_| surfaces.is_none());
        let total = clock.elapsed().as_secs_f64();
        let stresslets = match query.stresslets {
            true => {
                let none = || DVector::zeros(solved.generalised.len());
                let errors = errors.generalised.take().unwrap_or_else(none);
                let motion = [&solved.generalised, &errors];
                let found = self.stresslets((configuration, rates), &resistances, motion)?;
                found.map(|mut found| {
                    found.error = found.error.map(|bar| beside_slip * bar);
                    found
                })
            }
            false => None,
        };
        let mut solution = InstantaneousSolution {
            stresslets,
            seconds: Seconds {
                assembly,
                solve: total - assembly,
                total,
                ..Seconds::default()
            },
            ..InstantaneousSolution::solved_directly(
                linked.response(&solved)?,
                resistances.dofs,
                solved.residual,
            )
        };
        self.enter_errors(&mut solution, errors);
        Ok(solution)
    }

    /// Effects of slip, deformation and background flow, with those from which their errors follow.
    pub(super) fn surface_effects(
        &self,
        (configuration, rates): (Configuration, &[f64]),
        resistances: &SphereResistances,
    ) -> Result<Option<SurfaceEffects>, ModelError> {
        let poses = self.scaled.poses(configuration)?;
        let motion = SurfaceMotion::new(&self.scaled, &poses, configuration.shape);
        let Some(motion) = motion else {
            return Ok(None);
        };
        let spheres = self.spheres(configuration)?;
        let (centres, radii) = (spheres.centres(), spheres.radii());
        let slip = |sphere: usize, n: &Vector3<f64>| motion.slip(sphere, n);
        let background = |sphere: usize, n: &Vector3<f64>| {
            -motion.background(&(centres[sphere] + radii[sphere] * n))
        };
        let of_amplitude = |joint: usize| {
            let motion = &motion;
            move |sphere: usize, n: &Vector3<f64>| {
                motion.of_amplitude(sphere, &(radii[sphere] * n), joint)
            }
        };
        let amplitudes: Vec<_> = (motion.amplitudes().iter())
            .map(|&joint| of_amplitude(joint))
            .collect();
        let mut columns: Vec<&SphereSlip> = vec![&slip, &background];
        columns.extend(amplitudes.iter().map(|velocity| velocity as &SphereSlip));
        let rates = self.scaled.values(rates);
        let rates: Vec<f64> = motion
            .amplitudes()
            .iter()
            .map(|&joint| rates[joint])
            .collect();
        let medium = &self.medium;
        SurfaceEffects::by_expansions((&spheres, medium), &resistances.orders, &columns, &rates)
            .map(Some)
    }
}
