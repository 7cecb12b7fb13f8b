//! Solutions of many spheres by multipole expansions without a resistance matrix, and their error
//! bars.

use std::f64::consts::PI;
use std::time::Instant as Clock;

use microhydro::multipole::{ExpansionCost, MultipoleMobility, SlipModes, Variant};
use microhydro::{Accuracy, HydroError, LinkedMotion, Medium, Mobility, Spheres};
use nalgebra::{DVector, Matrix3, Vector3};
use scene::ModelEstimatesKind;
use stokes::{Seconds, SolverReport};

use super::direct_expansions::UNBALANCED_PART;
use super::error_bars::ModelErrors;
use super::{SphereModel, SpheresModel};
use crate::error::ModelError;
use crate::linked_bodies::{LargestDifferences, LinkedBodies, MobilitySolution};
use crate::query::{Configuration, Query};
use crate::response::Response;
use crate::solution::{InstantaneousSolution, Stresslets};
use crate::surface_motion::SurfaceEffect;

/// Largest number of spheres whose resistance matrix is computed: its cost of hundredths of a
/// second serves all rates of the joints in a configuration.
const FEW: usize = 16;

/// Bispherical coordinate below which gaps are narrow, 0.0225 radii between equal spheres: errors
/// over residuals grow in narrower ones, whose softest flow has an eigenvalue of about its square.
const NARROW: f64 = 0.15;

/// Largest relative error of a solution over its residual in gaps that are not [`NARROW`], with a
/// margin.
const RESIDUAL_FACTOR: f64 = 10.0;

/// How accurately solutions are computed, and their errors estimated.
struct Control {
    /// Residual of the equations over the tolerance of the expansions.
    residual: f64,
    /// Residual of changes from which errors are estimated.
    of_change: f64,
    /// Largest factor on the changes of motions by [`Variant::Lowered`].
    most_tail: f64,
}

/// With joints or given velocities, which open or close gaps at given rates.
const WITH_JOINTS: Control = Control {
    residual: 1e-5,
    of_change: 1e-2,
    most_tail: f64::INFINITY,
};

/// Where all forces are given.
///
/// Among 125 spheres at gaps of 0.05 and 0.1, errors of velocities were a twentieth of the
/// residual, and a residual of 0.1 gave their changes within 8 %; changes of forces between spheres
/// that are held converge more slowly. Errors of the motions were at most 0.8 of the changes by
/// [`Variant::Neglecting`], among 64 spheres in a cube at gaps of 0.05, and 0.63 of those by
/// [`Variant::Lowered`] with the smaller one of its factor and that of the gap: cubes and random
/// arrangements of 27 spheres, gaps of 0.025 to 8 radii, tolerances of 1e-2 to 1e-4. The power has
/// the factor of the gap: its terms are all of one sign.
const GIVEN_FORCES: Control = Control {
    residual: 1e-3,
    of_change: 3e-2,
    most_tail: 0.8,
};

/// Where all forces are given, and gaps are [`NARROW`]: with the factors of wider gaps errors were
/// up to 1.3 times the bars at gaps of 0.01 and 0.015.
const GIVEN_FORCES_IN_NARROW_GAPS: Control = Control {
    residual: 1e-4,
    ..WITH_JOINTS
};

/// Least bars of spheres with slip over what couplings neglect, relative to the speed of the slip,
/// the forces and the power.
///
/// Points on the surfaces replace distant images. Their errors are as large as what is neglected,
/// and fewer degrees have them too: the velocity of a squirmer without a stresslet, alone in a box,
/// had errors of up to 2000 bars, and the force on one that is held of up to 1100. In cubic
/// lattices the sum over images that drives the fifth degree is small, so that lower orders change
/// less than higher ones do. With this factor such errors were at most 0.7 of the bars at gaps of a
/// radius.
const NEGLECTED_TIMES: f64 = 25.0;

/// Factor from the relative error of the power to that of velocities, over the speed of the slip.
///
/// By symmetry the velocity of a squirmer alone in a cube, or those in a lattice that all have one
/// direction, may change by less than their error; the power does not. With a factor of zero such
/// errors were at most 0.7 of the bars.
const PART_OF_POWER: f64 = 0.3;

/// Factors on the changes of forces on spheres with slip and of the power.
///
/// Where few spheres are held, changes of their forces may cancel: errors were up to 0.85 of the
/// bars without this factor. The power changed little by symmetry in arrangements of four and eight
/// at gaps of 0.02 and 0.4: errors were 1.7 and 1.1 bars, in all others of 470 at most 0.73.
const OF_FORCES: f64 = 1.3;
const OF_POWER: f64 = 1.75;

impl Control {
    fn of(linked: &LinkedBodies, mobility: &MultipoleMobility) -> &'static Self {
        // The factors of given forces were not measured with slip.
        let has_given_forces = linked.all().has_given_forces() && mobility.slip().is_none();
        match (has_given_forces, mobility.narrowest() < NARROW) {
            (true, false) => &GIVEN_FORCES,
            (true, true) => &GIVEN_FORCES_IN_NARROW_GAPS,
            (false, _) => &WITH_JOINTS,
        }
    }
}

/// The motion of all bodies, without error bars, with an effect of their surfaces.
///
/// # Errors
/// An iteration that does not converge; joints that contradict each other.
pub(super) fn solution(
    mobility: &MultipoleMobility,
    accuracy: &Accuracy,
    linked: &LinkedBodies,
    effect: Option<&SurfaceEffect>,
) -> Result<MobilitySolution, ModelError> {
    let control = Control::of(linked, mobility);
    let residual = control.residual * accuracy.tolerance;
    Ok(linked
        .all()
        .by_mobility(mobility, effect, residual)?
        .solution)
}

/// The effect of slip; none without.
pub(super) fn effect_of_slip(mobility: &MultipoleMobility) -> Option<SurfaceEffect> {
    mobility.slip().map(SurfaceEffect::of_multipoles)
}

impl SpheresModel {
    /// The accuracy of expansions by iteration; none for few spheres, and where walls, deformation
    /// or background flow need a resistance matrix.
    fn iterates(&self) -> Option<Accuracy> {
        let SphereModel::Multipole(tolerance) = self.kind else {
            return None;
        };
        let scene = &self.scaled.scene;
        let at_rest = scene.background().is_none() && !scene.deforms();
        let many = self.names.len() > FEW && self.medium == Medium::Unbounded && at_rest;
        // Nothing else knows the images.
        (many || self.period.is_some()).then_some(Accuracy::relative(tolerance))
    }

    /// Slip in the modes of expansions by iteration; none without.
    ///
    /// # Errors
    /// Values of joints for which a loop does not close.
    fn slip_modes(
        &self,
        configuration: Configuration,
        spheres: &Spheres,
    ) -> Result<Option<SlipModes>, ModelError> {
        let squirmers = self.squirmers(configuration)?;
        if squirmers.is_empty() {
            return Ok(None);
        }
        let slip = |sphere: usize, n: &Vector3<f64>| squirmers[sphere].slip(n);
        Ok(Some(SlipModes::new(spheres, &slip)?))
    }

    /// Predicted cost of a solution by iteration; none where a resistance matrix is needed.
    ///
    /// # Errors
    /// A tolerance that is not between `1e-13` and 1.
    pub(super) fn cost_by_iteration(
        &self,
        configuration: Configuration,
        spheres: &Spheres,
    ) -> Result<Option<ExpansionCost>, ModelError> {
        let Some(accuracy) = self.iterates() else {
            return Ok(None);
        };
        let scene = &self.scaled.scene;
        let slip = self.slip_modes(configuration, spheres)?;
        let is_held = !scene.articulation().joints().is_empty() || scene.has_held_bodies();
        let given = !is_held && slip.is_none();
        let control = if given { GIVEN_FORCES } else { WITH_JOINTS };
        let residual = control.residual * accuracy.tolerance;
        let (period, slip) = (self.period.as_ref(), slip.as_ref());
        let cost = MultipoleMobility::cost(spheres, period, &accuracy, residual, slip);
        Ok(self.resolved(cost)?)
    }

    /// What expansions by iteration find, with their mobility; none where a resistance matrix is
    /// needed.
    ///
    /// It is also where what couplings neglect is too much in a narrow gap, or the forces cancel
    /// that the residual is relative to.
    pub(super) fn by_iteration<T>(
        &mut self,
        configuration: Configuration,
        find: impl FnOnce(&mut Self, MultipoleMobility, &Accuracy) -> Result<T, ModelError>,
    ) -> Result<Option<T>, ModelError> {
        let Some(accuracy) = self.iterates() else {
            return Ok(None);
        };
        let spheres = self.spheres(configuration)?;
        let slip = self.slip_modes(configuration, &spheres)?;
        let period = self.period.as_ref();
        let mobility = MultipoleMobility::new(&spheres, period, &accuracy, slip.as_ref());
        let Some(mobility) = self.resolved(mobility)? else {
            return Ok(None);
        };
        let found = find(self, mobility, &accuracy);
        self.definite(found)
    }

    /// The solution for one set of rates by expansions without a resistance matrix.
    ///
    /// Its time is counted from `clock`.
    ///
    /// # Errors
    /// Those of the iterations.
    pub(super) fn iterated_expansions(
        &mut self,
        (mut mobility, accuracy): (MultipoleMobility, &Accuracy),
        (query, rates): (&Query, &[f64]),
        clock: Clock,
    ) -> Result<InstantaneousSolution, ModelError> {
        let linked = LinkedBodies::new(&self.scaled, query, rates)?;
        let all = linked.all();
        let assembly = clock.elapsed().as_secs_f64();
        let control = Control::of(&linked, &mobility);
        let effect = effect_of_slip(&mobility);
        let residual = control.residual * accuracy.tolerance;
        let solved = all.by_mobility(&mobility, effect.as_ref(), residual)?;
        let (solution, found) = (solved.solution, solved.found);
        let solve = clock.elapsed().as_secs_f64() - assembly;
        let is_estimated = query.random_loads.is_none()
            && self.scaled.scene.model().estimates != ModelEstimatesKind::Off;
        let response = linked.response(&solution)?;
        let stresslets = query.stresslets.then(|| mobility.stresslets(&found.hidden));
        let estimated = match is_estimated {
            true => {
                let solved = (&solution, &found, &response, stresslets.as_deref());
                let by = (control, effect.as_ref());
                let errors = self.errors_by_variants(&mut mobility, by, &linked, solved);
                self.definite(errors)?
            }
            false => None,
        };
        let (errors, of_stresslets) = estimated.unzip();
        let errors = errors.unwrap_or_default();
        let stresslets = stresslets.map(|values| Stresslets {
            error: of_stresslets.map(|size| self.stresslets_of_size(size)),
            ..self.scaled.stresslets_to_scene(&values)
        });
        let total = clock.elapsed().as_secs_f64();
        let mut solution = InstantaneousSolution {
            stresslets,
            seconds: Seconds {
                assembly,
                solve,
                estimate: total - assembly - solve,
                total,
                ..Seconds::default()
            },
            ..InstantaneousSolution::from(response)
        };
        solution.dofs.total = mobility.dofs();
        solution.solver = SolverReport {
            formulation: "p-tilde".to_owned(),
            solver: "conjugate gradients".to_owned(),
            iterations: found.iterations,
            true_relative_residual: found.residual,
        };
        self.enter_errors(&mut solution, errors);
        Ok(solution)
    }

    /// Error bars from solutions by the variants of the expansions, and that of the stresslets.
    ///
    /// `solved` are the solution, its forces and multipoles, the response of the bodies and the
    /// stresslets that are asked for. Errors of slip have no sign.
    fn errors_by_variants(
        &self,
        mobility: &mut MultipoleMobility,
        (control, effect): (&Control, Option<&SurfaceEffect>),
        linked: &LinkedBodies,
        (solution, found, response, stresslets): (
            &MobilitySolution,
            &LinkedMotion,
            &Response,
            Option<&[Matrix3<f64>]>,
        ),
    ) -> Result<(ModelErrors, f64), ModelError> {
        let all = linked.all();
        let mut errors = ModelErrors::default();
        let mut of_stresslets = 0.0;
        let mut bars = LargestDifferences::default();
        let tail = mobility.tail();
        // Of motions, and of the power.
        let lowered = match mobility.slip() {
            Some(_) => [mobility.mean_tail(&found.hidden); 2],
            None => [tail.min(control.most_tail), tail],
        };
        let near = (found, control.of_change);
        for (variant, factor, [of_motions, of_power]) in [
            (Variant::Neglecting, 1.0, [1.0; 2]),
            (Variant::Lowered, tail, lowered),
        ] {
            mobility.set_variant(variant);
            let (other, of_other) = all.by_similar_mobility(mobility, effect, near)?;
            let factors = LargestDifferences {
                velocity: of_motions,
                angular_velocity: of_motions,
                power: of_power,
                mean_flow: of_motions,
                ..LargestDifferences::of_all(factor)
            };
            let mut errors_of_variant = all.largest_differences(solution, &other).times(&factors);
            if variant == Variant::Lowered && effect.is_some() {
                // A mean is too small for a sphere in a narrow gap that changes less than others.
                let pair = (solution, &other);
                let [velocity, angular_velocity] = all.largest_weighted(pair, mobility.tails());
                errors_of_variant.raise(&LargestDifferences {
                    velocity,
                    angular_velocity,
                    ..LargestDifferences::default()
                });
            }
            bars.add(1.0, &errors_of_variant);
            let change = response - &linked.response(&other)?;
            let change = &change * of_motions;
            errors.signed = Some(match errors.signed.take() {
                Some(sum) => sum + &change,
                None => change,
            });
            if let Some(stresslets) = stresslets {
                let others = mobility.stresslets(&of_other.hidden);
                let changes = stresslets.iter().zip(&others).map(|(a, b)| (a - b).norm());
                of_stresslets += factor * changes.fold(0.0, f64::max);
            }
        }
        let slower = (NARROW / mobility.narrowest()).max(1.0);
        let of_iteration = RESIDUAL_FACTOR * slower * found.residual;
        let [motion, load] = [&solution.generalised, &solution.forces].map(DVector::norm);
        // A sphere that others keep at rest, or that has no swimming mode, has slip all the same.
        let slip = mobility.slip();
        let speed = slip.map_or(0.0, |slip| slip.speed);
        let of_slip = slip.map_or(0.0, |slip| slip.hidden.norm() * found.hidden.norm());
        let count = mobility.spheres().len() as f64;
        let motion = motion + solution.mean_flow.norm() + count.sqrt() * speed;
        bars.add(
            of_iteration,
            &LargestDifferences {
                velocity: motion,
                angular_velocity: motion,
                force: load,
                torque: load,
                power: motion * load + of_slip,
                linkage_power: 1.0,
                mean_flow: motion,
                total_force: load,
            },
        );
        let sizes = stresslets.into_iter().flatten().map(Matrix3::norm);
        of_stresslets += of_iteration * sizes.fold(0.0, f64::max);
        if !all.is_held() && !all.has_given_forces() {
            let forces = all.forces_of_motion(solution, mobility, effect, near)?;
            let changes = tail * (&solution.forces - forces);
            let [velocity, angular] = unbalanced_velocities(mobility.spheres(), &changes);
            bars.velocity = bars.velocity.max(UNBALANCED_PART * velocity);
            bars.angular_velocity = bars.angular_velocity.max(UNBALANCED_PART * angular);
        }
        if effect.is_some() {
            bars.force *= OF_FORCES;
            bars.total_force *= OF_FORCES;
            bars.power *= OF_POWER;
            let power = all.power(solution).abs();
            let neglected = LargestDifferences {
                velocity: speed,
                angular_velocity: 0.0,
                force: load,
                torque: load,
                power,
                linkage_power: 1.0,
                mean_flow: speed,
                total_force: load,
            };
            let times = NEGLECTED_TIMES * mobility.neglected();
            bars.raise(&neglected.times(&LargestDifferences::of_all(times)));
            if power > 0.0 {
                let relative = PART_OF_POWER * bars.power / power;
                bars.velocity = bars.velocity.max(relative * speed);
            }
        }
        // As for a resistance matrix: a rotation may change little by chance.
        let of_velocity = bars.velocity / self.scaled.shortest_lever;
        bars.angular_velocity = bars.angular_velocity.max(of_velocity);
        errors.bars = Some(bars);
        errors.signed = errors.signed.filter(|_| effect.is_none());
        Ok((errors, of_stresslets))
    }

    /// What was found; none, for the resistance matrix to find it, in gaps that expansions do not
    /// resolve without eliminations. In a periodic box, which the resistance matrix does not have,
    /// these are errors.
    fn resolved<T>(&self, found: Result<T, HydroError>) -> Result<Option<T>, HydroError> {
        match found {
            Err(HydroError::TooClose { .. }) if self.period.is_none() => Ok(None),
            found => found.map(Some),
        }
    }

    /// The same if what couplings neglect, or lower orders, made the matrix indefinite.
    fn definite<T>(&self, found: Result<T, ModelError>) -> Result<Option<T>, ModelError> {
        match found {
            Err(ModelError::Spheres(
                HydroError::FactorisationFailed { .. }
                | HydroError::NotConverged { .. }
                | HydroError::RootNotConverged { .. },
            )) if self.period.is_none() => Ok(None),
            found => found.map(Some),
        }
    }

    /// The norm of a stresslet in the scene's units.
    fn stresslets_of_size(&self, scaled: f64) -> f64 {
        let only = Matrix3::from_diagonal_element(scaled / 3.0_f64.sqrt());
        self.scaled.scale.torque_to_scene(only).norm()
    }
}

/// Largest velocity and angular velocity of single spheres, the others held, due to errors of
/// forces and torques.
///
/// The resistance of a sphere is that of a lone one, and in gaps the leading term `6π b^2 / h` of
/// lubrication along their axis, with `1/b = 1/a_1 + 1/a_2` and the gap `h`.
fn unbalanced_velocities(spheres: &Spheres, changes: &DVector<f64>) -> [f64; 2] {
    let (x, a) = (spheres.centres(), spheres.radii());
    let mut largest = [0.0_f64; 2];
    for i in 0..x.len() {
        let mut drag = Matrix3::from_diagonal_element(6.0 * PI * a[i]);
        for j in (0..x.len()).filter(|&j| j != i) {
            let (apart, b) = (x[j] - x[i], a[i] * a[j] / (a[i] + a[j]));
            let gap = apart.norm() - a[i] - a[j];
            if gap < b {
                let normal = apart.normalize();
                drag += 6.0 * PI * b * b / gap * normal * normal.transpose();
            }
        }
        let force = changes.fixed_rows::<3>(6 * i);
        // a sum of positive definite matrices
        let velocity = drag
            .try_inverse()
            .map_or(0.0, |mobility| (mobility * force).norm());
        let torque = changes.fixed_rows::<3>(6 * i + 3).norm() / (8.0 * PI * a[i].powi(3));
        largest = [largest[0].max(velocity), largest[1].max(torque)];
    }
    largest
}
