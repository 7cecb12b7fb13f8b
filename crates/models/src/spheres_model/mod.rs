//! Models of spheres without a mesh: Oseen, Rotne-Prager-Yamakawa, multipole expansions.

mod iterated_expansions;
mod point_forces;
mod sphere_flow;
mod sphere_resistances;

use std::time::Instant as Clock;

use microhydro::multipole::{self, Orders, SphereSlip};
use microhydro::{Accuracy, Medium, PointModel, Spheres, Squirmer};
use nalgebra::{DMatrix, DVector, Vector3};
use rigid::StateVelocity;

use self::point_forces::ModelErrors;
use self::sphere_flow::MovingSpheres;
use self::sphere_resistances::{REFERENCE_ORDERS, SphereResistances};
use crate::error::ModelError;
use crate::flow_field::{FlowField, PointFlow};
use crate::hydrodynamics::{
    Capabilities, Flows, Fluctuations, Hydrodynamics, PredictedCost, Resistances, SceneResistance,
};
use crate::linked_bodies::{
    self, LargestDifferences, LinkedBodies, MobilitySolution, SomeLinkages,
};
use crate::query::{Configuration, Query};
use crate::scaled_scene::{MeanFlowCondition, ScaledScene};
use crate::solution::{ErrorEstimate, InstantaneousSolution};
use crate::surface_motion::{SurfaceEffect, SurfaceMotion};
use scene::{Background, Body, Deformation, Domain, ModelEstimatesKind, ModelKind, Scene, Slip};
use stokes::{Dofs, Seconds};

/// Approximation of the interactions between spheres.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum SphereModel {
    /// Point forces (Oseen tensor).
    Oseen,
    /// Rotne-Prager-Yamakawa.
    Rpy,
    /// Multipole expansions with this relative error of the resistance.
    Multipole(f64),
}

impl SphereModel {
    /// The model of point forces, if it is one.
    fn point_model(self) -> Option<PointModel> {
        match self {
            Self::Oseen => Some(PointModel::Oseen),
            Self::Rpy => Some(PointModel::Rpy),
            Self::Multipole(_) => None,
        }
    }

    /// Name of the model, with its tolerance.
    pub fn describe(self) -> String {
        match self {
            Self::Oseen => "oseen".to_owned(),
            Self::Rpy => "rpy".to_owned(),
            Self::Multipole(tolerance) => format!("multipole to {tolerance:.0e}"),
        }
    }
}

/// Error of the references for models of point forces: [`REFERENCE_ACCURACY`] of an error of 0.3 %.
///
/// [`REFERENCE_ACCURACY`]: sphere_resistances
const POINT_FORCE_ERROR: f64 = 1e-3;

/// Part of [`SphereResistances::unbalanced_velocities`] below which no bar of a velocity is.
///
/// The changes of the forces on several spheres may give them nearly the same velocities by chance,
/// and their errors do not cancel as well: of linked pairs with similar radii, 7 % had velocity
/// errors above their bar, up to 165 times, and at most 0.074 of the unbalanced velocities.
const UNBALANCED_PART: f64 = 0.08;

/// Factor on all bars beside slip in a ball.
///
/// Errors of three linked squirmers on its axis were 0.3 of the change between orders at some
/// orders, 0.9 to 1.0 (velocities, forces), 1.7 (stresslets) and 2.9 times it (powers) at others.
const SLIP_IN_BALL_FACTOR: f64 = 3.0;

/// Predicted seconds of a solution above which its cost is not found by solving.
const MAX_MEASURED_SECONDS: f64 = 0.5;

/// Effects of slip and background flow on the spheres.
struct SurfaceEffects {
    computed: SurfaceEffect,
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
    fn by_expansions(
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
struct Reference<'a> {
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
fn references<'a>(
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
fn follow(
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

/// Model of spheres in unbounded fluid, in a ball, above a wall, or in a periodic box.
#[derive(Clone)]
pub struct SpheresModel {
    kind: SphereModel,
    /// Whether the model was chosen such that its error meets the tolerance of the scene.
    controls_error: bool,
    scaled: ScaledScene,
    /// Names of the bodies with surfaces.
    names: Vec<String>,
    medium: Medium,
    /// Edges of the box, in whose images the fluid is unbounded.
    period: Option<Vector3<f64>>,
    /// The last configuration, whose resistance serves other rates of the joints.
    last: Option<(Spheres, SphereResistances)>,
}

impl SpheresModel {
    /// A sphere above a plane wall whose radius changes, which the model does not support.
    pub fn changes_size_above_wall(scene: &Scene) -> Option<usize> {
        let has_size = |body: &Body| {
            let sphere = body.deformation.as_ref().and_then(Deformation::sphere);
            sphere.is_some_and(|sphere| sphere.size.is_some())
        };
        let position = || scene.bodies().iter().position(has_size);
        (*scene.domain() == Domain::Wall).then(position).flatten()
    }

    /// Creates the model of a scene.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for shapes that are not spheres and for other domains; in a
    /// periodic box for all but rigid spheres, with slip by `rpy` and `multipole`.
    pub fn new(scene: &Scene, kind: SphereModel) -> Result<Self, ModelError> {
        let refuse = |key: &str, what: &str, instead: &str| {
            let what = format!("{}: {what}", scene.place(key));
            Err(ModelError::unsupported(what, instead))
        };
        if scene.domain().period().is_some() {
            let elsewhere = "use rigid spheres without another background flow than kind = \
                             \"uniform\" or \"pressure-gradient\", or domain.kind = \
                             \"unbounded\"";
            if let Some(number) = scene.first_nonspherical() {
                let what = "bodies other than rigid spheres in a periodic box";
                return refuse(&format!("bodies[{number}]"), what, elsewhere);
            }
            let has_gradient = |flow: &Background| {
                matches!(
                    flow,
                    Background::Linear { .. } | Background::Poiseuille { .. }
                )
            };
            if scene.background().is_some_and(has_gradient) || scene.deforms() {
                let what = "deformation and background flow with a gradient in a periodic box";
                return refuse("domain.kind", what, elsewhere);
            }
            let is_multipole = matches!(kind, SphereModel::Multipole(_));
            if !is_multipole && scene.model().estimates == ModelEstimatesKind::Full {
                let what = "model.estimates = \"full\" in a periodic box";
                let instead = "use \"sampled\", which has the images nearest to some bodies";
                return refuse("model.estimates", what, instead);
            }
        }
        if let Some(number) = scene.bodies().iter().position(|b| !b.shape.is_isotropic()) {
            let word = scene.bodies()[number].shape.kind().word();
            return refuse(
                &format!("bodies[{number}].shape"),
                &format!("shape = \"{word}\" for models of spheres"),
                "use model.kind = \"fem\", or \"axisymmetric\" for spheroids on one axis",
            );
        }
        let modes = |body: &Body| {
            (body.deformation.as_ref()).is_some_and(|deformation| !deformation.is_sphere())
        };
        if let Some(number) = scene.bodies().iter().position(modes) {
            return refuse(
                &format!("bodies[{number}].deformation"),
                "a body whose modes change its shape, for models of spheres",
                "use model.kind = \"fem\", or \"axisymmetric\" for spheres on one axis",
            );
        }
        if let Some(number) = Self::changes_size_above_wall(scene) {
            return refuse(
                &format!("bodies[{number}]"),
                "a sphere whose radius changes above a plane wall, for models of spheres",
                "use model.kind = \"fem\"",
            );
        }
        if kind.point_model().is_some() {
            let has_background = scene.background().is_some() && scene.domain().period().is_none();
            if has_background || scene.deforms() {
                return refuse(
                    "model.kind",
                    "deformation and background flow for models of point forces",
                    "use model.kind = \"multipole\", or \"auto\"",
                );
            }
            let has_walls = matches!(scene.domain(), Domain::Ball { .. } | Domain::Wall);
            if scene.has_slip() && (has_walls || kind == SphereModel::Oseen) {
                return refuse(
                    "model.kind",
                    "slip of points, and slip by models of point forces in a ball or above a wall",
                    "use model.kind = \"rpy\" in unbounded fluid or in a periodic box, or \
                     \"multipole\" elsewhere",
                );
            }
        }
        let scaled = ScaledScene::new(scene)?;
        let scale = scaled.scale;
        let medium = match *scene.domain() {
            Domain::Unbounded | Domain::Periodic { .. } => Medium::Unbounded,
            Domain::Ball { radius } => Medium::Ball {
                centre: Vector3::zeros(),
                radius: scale.length(radius),
            },
            Domain::Wall => Medium::wall(Vector3::zeros(), Vector3::z())?,
            _ => {
                let word = scene.domain().kind().word();
                return refuse(
                    "domain.kind",
                    &format!("domain.kind = \"{word}\" for models of spheres"),
                    "use model.kind = \"fem\", or the domain unbounded, ball or wall",
                );
            }
        };
        Ok(Self {
            kind,
            // In a periodic box there is no other model to choose from.
            controls_error: matches!(kind, SphereModel::Multipole(_))
                || (scene.model().kind == ModelKind::Auto && scene.domain().period().is_none()),
            names: scene
                .bodies()
                .iter()
                .filter(|body| body.shape.has_surface())
                .map(|body| body.name.clone())
                .collect(),
            medium,
            period: scene.domain().period().map(|size| scale.length(size)),
            scaled,
            last: None,
        })
    }

    /// Predicted seconds of one solution on two cores, from the operations that it takes.
    ///
    /// Counted and not measured: the same on all machines. Cost: some hundred operations for each
    /// pair of spheres.
    ///
    /// # Errors
    /// Spheres that are too close.
    pub fn predicted_seconds(&self, configuration: Configuration) -> Result<f64, ModelError> {
        let spheres = self.spheres(configuration)?;
        if let Some(cost) = self.cost_by_iteration(configuration, &spheres)? {
            return Ok(cost.seconds);
        }
        let columns = match self.scaled.scene.has_surface_velocity() || self.scaled.scene.deforms()
        {
            // Slip, the background flow and each amplitude.
            true => 2 + self.scaled.amplitudes().count(),
            false => 0,
        };
        let seconds = |accuracy: Accuracy| {
            multipole::predicted_seconds(&spheres, &self.medium, &accuracy, columns)
        };
        match self.kind {
            SphereModel::Multipole(tolerance) => Ok(seconds(Accuracy::relative(tolerance))?),
            SphereModel::Oseen | SphereModel::Rpy => self.predicted_point_seconds(&spheres),
        }
    }

    /// Refuses what is not computed in a periodic box.
    fn check_not_periodic(&self, what: &str) -> Result<(), ModelError> {
        match self.period {
            None => Ok(()),
            Some(_) => Err(ModelError::unsupported(
                format!(
                    "{}: {what} in a periodic box",
                    self.scaled.scene.place("domain.kind")
                ),
                "use domain.kind = \"unbounded\"",
            )),
        }
    }

    fn spheres(&self, configuration: Configuration) -> Result<Spheres, ModelError> {
        let centres = self.scaled.centres(configuration)?;
        let radii = self.scaled.sphere_radii(configuration.shape)?;
        Ok(Spheres::new(centres, radii)?)
    }

    /// The spheres as squirmers; none if no body has slip.
    fn squirmers(&self, configuration: Configuration) -> Result<Vec<Squirmer>, ModelError> {
        if !self.scaled.scene.has_slip() {
            return Ok(Vec::new());
        }
        let poses = self.scaled.poses(configuration)?;
        let motion = SurfaceMotion::new(&self.scaled, &poses, configuration.shape);
        let of_body = |motion: &SurfaceMotion, body: usize| {
            let squirmer = |slip: &Slip| Squirmer {
                b1: slip.b1,
                b2: slip.b2,
                axis: slip.axis,
            };
            motion.slip_of(body).map_or(Squirmer::NONE, squirmer)
        };
        let all = motion.map(|motion| (0..self.names.len()).map(move |k| of_body(&motion, k)));
        Ok(all.into_iter().flatten().collect())
    }

    /// Resistance of a configuration; that of the last configuration is stored.
    fn resistance_at(
        &mut self,
        configuration: Configuration,
    ) -> Result<SphereResistances, ModelError> {
        let spheres = self.spheres(configuration)?;
        self.resistances_of(&spheres)
    }

    /// Resistances of spheres; those of the last ones are stored.
    fn resistances_of(&mut self, spheres: &Spheres) -> Result<SphereResistances, ModelError> {
        if let Some((known, resistances)) = &self.last
            && known == spheres
        {
            return Ok(resistances.clone());
        }
        let resistances = SphereResistances::new(self.kind, spheres, &self.medium)?;
        self.last = Some((spheres.clone(), resistances.clone()));
        Ok(resistances)
    }

    /// Effects of slip, deformation and background flow, with those from which their errors follow.
    fn surface_effects(
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

    /// The spheres of a configuration with their velocities.
    fn moving(
        &mut self,
        configuration: Configuration,
        rates: &[f64],
    ) -> Result<MovingSpheres, ModelError> {
        let all_rates = [rates.to_vec()];
        let query = Query::new(configuration, &all_rates);
        let solved = match self.kind.point_model() {
            Some(model) => {
                let spheres = self.spheres(configuration)?;
                let linked = LinkedBodies::new(&self.scaled, &query, rates)?;
                let squirmers = self.squirmers(configuration)?;
                self.point_solution(model, &linked, (&spheres, &squirmers))?
            }
            None => match self.by_iteration(configuration, |own, mobility, accuracy| {
                let linked = LinkedBodies::new(&own.scaled, &query, rates)?;
                let effect = iterated_expansions::effect_of_slip(&mobility);
                iterated_expansions::solution(&mobility, accuracy, &linked, effect.as_ref())
            })? {
                Some(solution) => solution,
                None => {
                    let resistances = self.resistance_at(configuration)?;
                    let surfaces = self.surface_effects((configuration, rates), &resistances)?;
                    let effect = surfaces.as_ref().map(|effects| &effects.computed);
                    let linked = LinkedBodies::new(&self.scaled, &query, rates)?;
                    linked.all().by_resistance(&resistances.matrix, effect)?
                }
            },
        };
        self.placed(configuration, rates, &solved.generalised)
    }

    /// The spheres of a configuration with these generalised velocities.
    fn placed(
        &self,
        configuration: Configuration,
        rates: &[f64],
        generalised: &DVector<f64>,
    ) -> Result<MovingSpheres, ModelError> {
        Ok(MovingSpheres {
            spheres: self.spheres(configuration)?,
            velocities: generalised.select_rows(&self.scaled.set.surface_velocities()),
            surfaces: SurfaceMotion::new(
                &self.scaled,
                &self.scaled.poses(configuration)?,
                configuration.shape,
            ),
            rates: self.scaled.values(rates),
        })
    }

    /// The solution for one set of rates.
    fn solve_rates(
        &mut self,
        query: &Query,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        if let Some(model) = self.kind.point_model() {
            return self.point_forces(model, query, rates);
        }
        let configuration = query.configuration;
        let clock = Clock::now();
        let found = self.by_iteration(configuration, |own, mobility, accuracy| {
            own.iterated_expansions((mobility, accuracy), (query, rates), clock)
        })?;
        if let Some(found) = found {
            return Ok(found);
        }
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

    /// Enters the error bars of the model, in the units of the scene.
    fn enter_errors(&self, solution: &mut InstantaneousSolution, errors: ModelErrors) {
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

impl Hydrodynamics for SpheresModel {
    fn scene(&self) -> &Scene {
        &self.scaled.scene
    }

    fn name(&self) -> &'static str {
        match self.kind {
            SphereModel::Oseen => "oseen",
            SphereModel::Rpy => "rpy",
            SphereModel::Multipole(_) => "multipole",
        }
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        (query.rates.iter())
            .map(|rates| self.solve_rates(query, rates))
            .collect()
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            controls_error: self.controls_error,
            // Models of point forces refuse scenes that deform.
            deforms: true,
            fluctuates: true,
            ..Capabilities::default()
        }
    }

    fn duplicate(&self) -> Option<Box<dyn Hydrodynamics>> {
        Some(Box::new(self.clone()))
    }

    fn predicted_seconds(&self, configuration: Configuration<'_>) -> Option<f64> {
        Self::predicted_seconds(self, configuration).ok()
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<PredictedCost, ModelError> {
        let predicted = self.predicted_seconds(configuration)?;
        if predicted > MAX_MEASURED_SECONDS {
            let spheres = self.spheres(configuration)?;
            let (dofs, mib) = match (self.kind, self.cost_by_iteration(configuration, &spheres)?) {
                (_, Some(cost)) => (cost.dofs, cost.mib),
                (SphereModel::Multipole(tolerance), None) => {
                    multipole::predicted_size(&spheres, &self.medium, tolerance)?
                }
                (SphereModel::Oseen | SphereModel::Rpy, None) => (6 * spheres.len(), 0.0),
            };
            return Ok(PredictedCost {
                dofs: Dofs {
                    total: dofs,
                    ..Dofs::default()
                },
                seconds: predicted,
                mib,
            });
        }
        let rates = vec![0.0; configuration.shape.len()];
        Ok(PredictedCost::of_solution(
            &self.solve_one(configuration, &rates)?,
        ))
    }

    fn flows(&mut self) -> Result<&mut dyn Flows, ModelError> {
        Ok(self)
    }

    fn resistances(&mut self) -> Result<&mut dyn Resistances, ModelError> {
        self.check_not_periodic("resistance matrices")?;
        Ok(self)
    }

    fn fluctuations(&mut self) -> Result<&mut dyn Fluctuations, ModelError> {
        Ok(self)
    }

    fn joint_responses(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<Option<Vec<StateVelocity>>, ModelError> {
        let responses = match self.kind.point_model() {
            Some(model) => {
                let spheres = self.spheres(configuration)?;
                let solve =
                    |linked: &LinkedBodies| self.point_solution(model, linked, (&spheres, &[]));
                linked_bodies::joint_responses(&self.scaled, configuration, solve)
            }
            None => match self.by_iteration(configuration, |own, mobility, accuracy| {
                let solve = |linked: &LinkedBodies| {
                    iterated_expansions::solution(&mobility, accuracy, linked, None)
                };
                linked_bodies::joint_responses(&own.scaled, configuration, solve)
            })? {
                Some(responses) => Ok(responses),
                None => {
                    let matrix = self.resistance_at(configuration)?.matrix;
                    let solve = |linked: &LinkedBodies| linked.all().by_resistance(&matrix, None);
                    linked_bodies::joint_responses(&self.scaled, configuration, solve)
                }
            },
        };
        responses.map(Some)
    }
}

impl Resistances for SpheresModel {
    fn resistance(
        &mut self,
        configuration: Configuration<'_>,
    ) -> Result<SceneResistance, ModelError> {
        let resistances = self.resistance_at(configuration)?;
        let (errors, scale) = (resistances.errors(), &self.scaled.scale);
        Ok(SceneResistance {
            matrix: scale.resistance_to_scene(resistances.matrix),
            errors: Some(scale.resistance_to_scene(errors)),
        })
    }
}

impl Fluctuations for SpheresModel {
    fn random_loads(
        &mut self,
        configuration: Configuration<'_>,
        power: f64,
        normal: &mut dyn FnMut() -> f64,
    ) -> Result<DVector<f64>, ModelError> {
        let loads = match self.kind.point_model() {
            Some(model) => {
                let spheres = self.spheres(configuration)?;
                let mobility = self.mobility(model, &spheres)?;
                let linked = LinkedBodies::at_rest(&self.scaled, configuration, None)?;
                linked.all().random_loads_by_mobility(&mobility, normal)?
            }
            None => {
                // The resistance matrix does not have the images.
                let in_box = match self.period {
                    Some(_) => self.by_iteration(configuration, |own, mobility, _| {
                        let linked = LinkedBodies::at_rest(&own.scaled, configuration, None)?;
                        linked.all().random_loads_by_mobility(&mobility, normal)
                    })?,
                    None => None,
                };
                match in_box {
                    Some(loads) => loads,
                    None => {
                        let resistance = self.resistance_at(configuration)?.matrix;
                        let linked = LinkedBodies::at_rest(&self.scaled, configuration, None)?;
                        linked.all().random_loads(&resistance, normal)?
                    }
                }
            }
        };
        let scaled = power / self.scaled.scale.power_to_scene(1.0);
        Ok(loads.component_mul(&self.scaled.load_units()) * scaled.sqrt())
    }
}

impl Flows for SpheresModel {
    fn flow(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<FlowField, ModelError> {
        self.check_not_periodic("the flow on a mesh")?;
        let moving = self.moving(configuration, rates)?;
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let (mesh, velocity) = sphere_flow::flow_field(&moving, &self.medium, &names)?;
        let scale = &self.scaled.scale;
        Ok(FlowField {
            mesh: scale.mesh_to_scene(&mesh)?,
            velocity: velocity
                .into_iter()
                .map(|u| scale.length_to_scene(u))
                .collect(),
            pressure: Vec::new(),
        })
    }

    fn flow_at(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<PointFlow>>, ModelError> {
        let scale = &self.scaled.scale;
        let scaled: Vec<_> = points.iter().map(|x| scale.length(*x)).collect();
        let velocities = match self.flow_of_point_forces(configuration, rates, &scaled)? {
            Some(velocities) => velocities,
            None => {
                let moving = self.moving(configuration, rates)?;
                sphere_flow::velocities_at(&moving, &self.medium, &scaled)?
            }
        };
        let scale = &self.scaled.scale;
        let in_scene = |velocity| PointFlow {
            velocity: scale.length_to_scene(velocity),
            pressure: None,
        };
        Ok(velocities.into_iter().map(|u| u.map(in_scene)).collect())
    }
}
