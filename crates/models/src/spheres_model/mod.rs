//! Models of spheres without a mesh: Oseen, Rotne-Prager-Yamakawa, multipole expansions.

mod direct_expansions;
mod error_bars;
mod iterated_expansions;
mod point_forces;
mod sphere_flow;
mod sphere_resistances;

use std::time::Instant as Clock;

use microhydro::multipole;
use microhydro::{Accuracy, Medium, PointModel, Spheres, Squirmer};
use nalgebra::{DVector, Vector3};
use rigid::StateVelocity;

use self::sphere_flow::MovingSpheres;
use self::sphere_resistances::{REFERENCE_ORDERS, SphereResistances};
use crate::error::ModelError;
use crate::flow_field::{FlowField, PointFlow};
use crate::hydrodynamics::{
    Capabilities, Flows, Fluctuations, Hydrodynamics, PredictedCost, Resistances, SceneResistance,
};
use crate::linked_bodies::{self, LinkedBodies};
use crate::query::{Configuration, Query};
use crate::scaled_scene::ScaledScene;
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceMotion;
use scene::{Background, Body, Deformation, Domain, ModelEstimatesKind, ModelKind, Scene, Slip};
use stokes::Dofs;

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

/// Predicted seconds of a solution above which its cost is not found by solving.
const MAX_MEASURED_SECONDS: f64 = 0.5;

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
        self.direct_expansions(query, rates)
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
            None => match self.by_iteration(configuration, |own, mobility, _| {
                let linked = LinkedBodies::at_rest(&own.scaled, configuration, None)?;
                linked.all().random_loads_by_mobility(&mobility, normal)
            })? {
                Some(loads) => loads,
                None => {
                    let resistance = self.resistance_at(configuration)?.matrix;
                    let linked = LinkedBodies::at_rest(&self.scaled, configuration, None)?;
                    linked.all().random_loads(&resistance, normal)?
                }
            },
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
