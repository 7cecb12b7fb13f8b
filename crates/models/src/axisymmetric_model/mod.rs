//! Bodies that move along an axis of the domain: finite elements in the meridian half-plane.

mod axial_stresslets;
mod axial_surfaces;
mod deforming_bodies;
mod meridian_flow;
mod moving_axis;
mod viscosity_law;

pub use moving_axis::{AxialFlow, MovingAxis};

use std::time::Instant as Clock;

use axisymmetric::{AxialResistance, AxialSpheroid, ResistanceSolver, Surroundings};
use mesh::TetMesh;
use nalgebra::{DMatrix, Vector3};

use self::axial_surfaces::{AxialResistances, AxialSurfaces, grand_resistance};
use self::deforming_bodies::AxialRates;
use crate::discretisation_error::{DiscretisationError, Uncertainty};
use crate::error::ModelError;
use crate::flow_field::{FlowField, PointFlow};
use crate::hydrodynamics::{
    Capabilities, ErrorEstimates, Flows, Hydrodynamics, PredictedCost, Resistances,
};
use crate::linked_bodies::LinkedBodies;
use crate::neglected_terms::{FirstOrderChange, NeglectedTerm, NeglectedTerms, PathPoint};
use crate::query::{Configuration, Query};
use crate::response::BodySolution;
use crate::scaled_scene::ScaledScene;
use crate::solution::InstantaneousSolution;
use scene::rheology::Law;
use scene::{Arrangement, Domain, Scene, Shape};
use stokes::Seconds;

/// Model of bodies on one axis that move along it and rotate about it.
///
/// The resistance is computed for motions along the axis and, if there are torques or rotors, for
/// rotations about it. By symmetry all other velocities are zero. In the equations they have an
/// arbitrary positive resistance.
#[derive(Clone)]
pub struct AxisymmetricModel {
    scaled: ScaledScene,
    /// Shapes of the bodies with surfaces, centred at the origin.
    shapes: Vec<AxialSpheroid>,
    surroundings: Surroundings,
    /// Unit vector along the axis.
    axis: Vector3<f64>,
    /// Whether torques or joints turn some body, so that the flow with swirl is computed.
    has_swirl: bool,
    /// Viscosity law of the fluid in scaled units; none for a Newtonian fluid.
    law: Option<Law>,
    /// Requested relative error of resistances.
    tolerance: f64,
    /// Keeps what successive configurations have in common.
    ///
    /// Its results do not depend on earlier ones, so they are no part of the history.
    solver: ResistanceSolver,
}

/// Distance from the axis, in smallest radii, that counts as rounding error along a stroke.
const OFF_AXIS: f64 = 1e-6;

/// Smallest tolerance of [`ResistanceSolver`].
const MIN_TOLERANCE: f64 = 1e-11;

/// Relative uncertainty of the estimated error of a velocity.
///
/// The estimate continues the changes from order to order as a geometric series, whose ratio varies
/// between orders. With an uncertainty of 0.5, one of 54 random rows had an error of 2.8 bars
/// (`docs/figures/random_cases.py`).
const UNCERTAINTY: f64 = 0.75;

/// The same where bodies deform.
///
/// The velocity of a wave is a small difference, whose changes from order to order are less
/// regular: of ten lone spheres the estimate was 0.3 to 1.4 times the error, and with 0.75 one
/// error was 1.6 bars (`docs/figures/random_cases.py`, waves of the seeds 131001 to 131016).
const DEFORMING_UNCERTAINTY: f64 = 2.0;

/// Uncertainty of velocities relative to the largest one, per relative error of the resistance.
///
/// The estimated errors of linked bodies cancel in their velocities; their uncertainties do not.
const UNCANCELLED_FACTOR: f64 = 0.1;

/// Uncertainty of forces relative to the largest one, per relative error of the resistance, where
/// slip or a background flow exerts a part of them.
///
/// The errors of that part and of the drag cancel, their uncertainties do not: in one of five
/// random chains of squirmers the error was 2.3 times the bar without it (seed 617).
const SLIP_FORCE_FACTOR: f64 = 0.3;

/// The same relative to the largest force that would hold a body alone against its slip.
///
/// The forces between two linked squirmers may nearly cancel: their error was 0.012 of that force
/// per relative error of the resistance, and 3.0 bars without it (seed 167002).
const HELD_FORCE_FACTOR: f64 = 0.03;

/// Relative error of resistances that the lowest order of the elements reaches.
const LOWEST_ACCURACY: f64 = 1e-4;

impl AxisymmetricModel {
    /// Largest ratio of the semi-axes of a spheroid.
    pub const MAX_ASPECT: f64 = axisymmetric::MAX_ASPECT;

    /// Creates the model of a scene.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for arrangements, domains and loads without rotational symmetry,
    /// and for shapes other than spheres and spheroids.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let refuse = |key: &str, problem: String, instead: &str| {
            let place = scene.place(key);
            let what = format!("{place}: {problem} for model.kind = \"axisymmetric\"");
            Err(ModelError::unsupported(what, instead))
        };
        if let Some(number) = scene.first_not_spheroidal() {
            return refuse(
                &format!("bodies[{number}].shape"),
                format!("shape = \"{}\"", scene.bodies()[number].shape.kind().word()),
                "use model.kind = \"fem\", or spheres and spheroids",
            );
        }
        let scaled = ScaledScene::new(scene)?;
        let scale = scaled.scale;
        let surroundings = match *scene.domain() {
            Domain::Unbounded => Surroundings::Unbounded,
            Domain::Ball { radius } => Surroundings::Ball {
                radius: scale.length(radius),
            },
            Domain::Cylinder { radius } => Surroundings::Cylinder {
                radius: scale.length(radius),
            },
            _ => {
                return refuse(
                    "domain.kind",
                    format!("domain.kind = \"{}\"", scene.domain().kind().word()),
                    "use the domain unbounded, ball or cylinder, or model.kind = \"auto\"",
                );
            }
        };
        let Some(axis) = scene.axis() else {
            return refuse(
                "bodies",
                scene.describe_arrangement(),
                "put bodies, their forces and axes of rotation on one axis of the domain, or use \
                 model.kind = \"auto\"",
            );
        };
        let has_swirl = Self::has_swirl(scene);
        if scene.deforms() && (has_swirl || scene.has_surface_velocity()) {
            return refuse(
                "bodies",
                "bodies that deform in a background flow, beside bodies with slip or with rotation \
                 about the axis,"
                    .to_owned(),
                "use model.kind = \"fem\" or \"auto\"",
            );
        }
        if scene.deforms()
            && let Some(number) = scene.bodies().iter().position(|b| !b.shape.is_isotropic())
        {
            let shape = scene.bodies()[number].shape.kind().word();
            return refuse(
                &format!("bodies[{number}].shape"),
                format!("shape = \"{shape}\" beside bodies that deform"),
                "use spheres, or model.kind = \"fem\"",
            );
        }
        let law = scaled.law();
        if law.is_some() && has_swirl {
            return refuse(
                "fluid.law",
                "rotation about the axis in a fluid with a viscosity law".to_owned(),
                "use model.kind = \"fem\"",
            );
        }
        if law.is_some() && scene.deforms() {
            return refuse(
                "fluid.law",
                "bodies that deform in a fluid with a viscosity law".to_owned(),
                "use model.kind = \"fem\" or \"auto\"",
            );
        }
        Ok(Self {
            law,
            has_swirl,
            shapes: (scene.bodies().iter())
                .filter_map(|body| match &body.shape {
                    Shape::Sphere(shape) => {
                        Some(AxialSpheroid::sphere(0.0, scale.length(shape.radius)))
                    }
                    Shape::Spheroid(shape) => Some(AxialSpheroid {
                        centre: 0.0,
                        axial: scale.length(shape.half_length),
                        equatorial: scale.length(shape.radius),
                    }),
                    // Other shapes are refused above.
                    _ => None,
                })
                .collect(),
            surroundings,
            axis,
            // The net displacement is a small difference of the displacements of the phase spans,
            // which amplifies relative errors: by 8 for the three-sphere swimmer.
            tolerance: (0.05 * scene.working_tolerance()).clamp(MIN_TOLERANCE, LOWEST_ACCURACY),
            solver: ResistanceSolver::new(),
            scaled,
        })
    }

    /// The same model with resistances to another relative error, within the limits of the method.
    #[must_use]
    pub fn with_accuracy(self, relative_error: f64) -> Self {
        Self {
            tolerance: relative_error.clamp(MIN_TOLERANCE, LOWEST_ACCURACY),
            ..self
        }
    }

    /// The same model for velocities with this uncertainty relative to the largest one, within the
    /// limits of the method.
    ///
    /// Where the joints of one linkage alone drive the motion, the estimated errors of resistances
    /// cancel in the velocities, and a tenth of their uncertainty remains. Error bars of forces,
    /// torques and power are then up to ten times those by [`AxisymmetricModel::with_accuracy`].
    #[must_use]
    pub fn with_velocity_accuracy(self, relative_error: f64) -> Self {
        let scene = &self.scaled.scene;
        let remains = match scene.is_driven_by_shape() && !scene.deforms() {
            true => UNCANCELLED_FACTOR,
            false => 1.0,
        };
        self.with_accuracy(relative_error / remains)
    }

    /// Whether `model.kind = "auto"` selects this model without a comparison with others.
    ///
    /// It does if models without a mesh do not support the domain or a body. Three-dimensional
    /// elements would cost a thousand times as much.
    pub fn suits(scene: &Scene) -> bool {
        let is_needed = matches!(scene.domain(), Domain::Cylinder { .. })
            || scene.first_nonspherical().is_some();
        is_needed && Self::supports(scene)
    }

    /// Whether the model supports the domain, the shapes and the arrangement of a scene.
    pub fn supports(scene: &Scene) -> bool {
        let can_deform = || {
            !Self::has_swirl(scene)
                && !scene.has_surface_velocity()
                && scene.viscosity_law().is_none()
                && scene.bodies().iter().all(|body| body.shape.is_isotropic())
        };
        scene.first_not_spheroidal().is_none()
            && (!scene.deforms() || can_deform())
            && matches!(
                scene.domain(),
                Domain::Unbounded | Domain::Ball { .. } | Domain::Cylinder { .. }
            )
            && scene.arrangement() == Arrangement::Axisymmetric
    }

    /// Whether torques, joints or given velocities turn some body.
    fn has_swirl(scene: &Scene) -> bool {
        scene.bodies().iter().any(|body| {
            body.torque != Vector3::zeros()
                || body.driving_torque.is_some()
                || (body.held_angular_velocity()).is_some_and(|v| v.largest() != Vector3::zeros())
        }) || (scene.articulation().joints().iter()).any(|joint| joint.kind.turns())
    }

    /// Cost and error of the initial configuration in words.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    pub fn describe(&mut self, scene: &Scene) -> Result<String, ModelError> {
        let lengths = scene.articulation().initial_shape();
        let state = scene.initial_state();
        let configuration = Configuration::new(&state, lengths);
        let clock = Clock::now();
        let bodies = self.on_axis(configuration)?;
        let axial = self
            .solver
            .axial_best(&bodies, self.surroundings, self.tolerance)?;
        Ok(format!(
            "axisymmetric: relative error of the resistance {:.1e}, {} degrees of freedom, {:.0} \
             ms per solution",
            axial.relative_error(),
            axial.dofs(),
            1e3 * clock.elapsed().as_secs_f64()
        ))
    }

    /// The point of the axis at zero: the first body, or the centre of the domain.
    fn origin(&self, centres: &[Vector3<f64>]) -> Vector3<f64> {
        match self.surroundings {
            Surroundings::Unbounded => centres[0],
            Surroundings::Ball { .. } | Surroundings::Cylinder { .. } => Vector3::zeros(),
        }
    }

    /// The bodies with surfaces at their positions on the axis.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for a body that is not on the axis.
    fn on_axis(&self, configuration: Configuration) -> Result<Vec<AxialSpheroid>, ModelError> {
        let centres = self.scaled.centres(configuration)?;
        let origin = self.origin(&centres);
        (centres.iter().zip(&self.shapes).enumerate())
            .map(|(number, (centre, &shape))| {
                let from_origin = centre - origin;
                let along = from_origin.dot(&self.axis);
                let distance = (from_origin - along * self.axis).norm();
                if distance <= OFF_AXIS {
                    return Ok(AxialSpheroid {
                        centre: along,
                        ..shape
                    });
                }
                let what = format!(
                    "model.kind = \"axisymmetric\" for body {number} at a distance of \
                     {distance:e} smallest radii from the axis"
                );
                Err(ModelError::unsupported(what, "use model.kind = \"auto\""))
            })
            .collect()
    }

    /// The resistances to the motions that the scene has, to a relative tolerance.
    ///
    /// If the tolerance is out of reach, those with the smallest error: the error bars of the
    /// solution are those of the resistance, and whoever integrates a stroke decides whether they
    /// are small enough.
    ///
    /// # Errors
    /// Bodies that left the axis; failures of the solver.
    fn resistances_at(
        &mut self,
        configuration: Configuration,
        tolerance: f64,
    ) -> Result<AxialResistances, ModelError> {
        if let Some(rates) = AxialRates::new(&self.scaled, configuration, &self.axis)? {
            return Ok(AxialResistances {
                axial: self.deforming_resistance(configuration, &rates, tolerance)?,
                surfaces: None,
                spin: None,
            });
        }
        let bodies = self.on_axis(configuration)?;
        let surfaces = match self.scaled.scene.has_surface_velocity() {
            true => Some(
                self.solver
                    .surfaces(&bodies, self.surroundings, tolerance)?,
            ),
            false => None,
        };
        let axial = match &surfaces {
            Some(surfaces) => surfaces.power().clone(),
            None => self
                .solver
                .axial_best(&bodies, self.surroundings, tolerance)?,
        };
        let spin = match self.has_swirl {
            true => Some(
                self.solver
                    .spin_best(&bodies, self.surroundings, tolerance)?,
            ),
            false => None,
        };
        Ok(AxialResistances {
            axial,
            surfaces,
            spin,
        })
    }

    /// Solution for one set of rates, from the resistances of the configuration.
    ///
    /// Its time is counted from `clock`.
    fn solution(
        &self,
        query: &Query,
        rates: &[f64],
        resistances: &AxialResistances,
        clock: Clock,
    ) -> Result<InstantaneousSolution, ModelError> {
        let configuration = query.configuration;
        let (axial, spin) = (&resistances.axial, resistances.spin.as_ref());
        let set = &self.scaled.set;
        let linked = LinkedBodies::new(&self.scaled, query, rates)?;
        let surfaces = AxialSurfaces::new(&self.scaled, configuration, resistances, &self.axis)?;
        let deformation = AxialRates::new(&self.scaled, configuration, &self.axis)?;
        if deformation.is_some() {
            self.scaled.check_volume(configuration, rates)?;
        }
        let scaled_rates = self.scaled.values(rates);
        let n = self.shapes.len();
        let solve = |of: fn(&AxialResistance) -> DMatrix<f64>| {
            let along = of(axial);
            let effect = match (&deformation, &surfaces) {
                (Some(deformation), _) => Some(deformation.effect(&along, &scaled_rates)?),
                (None, surfaces) => surfaces.as_ref().map(|s| s.effect(&along)).transpose()?,
            };
            let along = along.view((0, 0), (n, n)).into_owned();
            let matrix = grand_resistance(&self.shapes, &self.axis, &along, spin.map(of).as_ref());
            let solved = linked.all().by_resistance(&matrix, effect.as_ref())?;
            let held = effect.map_or(0.0, |effect| {
                let speeds = effect.velocities.as_slice().chunks_exact(6);
                let speeds = speeds.map(|six| Vector3::from_row_slice(&six[..3]).dot(&self.axis));
                let drags = speeds.enumerate().map(|(k, u)| along[(k, k)] * u);
                drags.fold(0.0_f64, |most, drag| most.max(drag.abs()))
            });
            Ok::<_, ModelError>((linked.response(&solved)?, solved.residual, held))
        };
        let (computed, residual, _) = solve(|resistance| resistance.matrix().clone())?;
        let (corrected, _, held) = solve(AxialResistance::extrapolated)?;
        let largest = |of: fn(&BodySolution) -> Vector3<f64>| {
            (corrected.bodies.iter()).fold(0.0_f64, |m, body| m.max(of(body).norm()))
        };
        let speed = largest(|body| body.velocity);
        let spin_speed = largest(|body| body.angular_velocity);
        let uncancelled =
            |resistance: &AxialResistance| UNCANCELLED_FACTOR * resistance.relative_error();
        let uncertainty = Uncertainty {
            relative: match deformation.is_some() {
                true => DEFORMING_UNCERTAINTY,
                false => UNCERTAINTY,
            },
            velocity: uncancelled(axial) * speed,
            angular_velocity: spin.map_or(0.0, uncancelled) * spin_speed,
            torque: 0.0,
            // Without joints the forces are the given loads.
            force: match (surfaces.is_some() || deformation.is_some()) && !set.joints().is_empty() {
                true => {
                    let force = SLIP_FORCE_FACTOR * largest(|body| body.force);
                    axial.relative_error() * force.max(HELD_FORCE_FACTOR * held)
                }
                false => 0.0,
            },
            power: axial.relative_error()
                * match deformation.is_some() {
                    true => corrected.power().abs(),
                    false => corrected.slip_power.abs(),
                },
        };
        let error = DiscretisationError::between(&computed, &corrected, uncertainty);
        let total = clock.elapsed().as_secs_f64();
        let mut solution = InstantaneousSolution {
            seconds: Seconds {
                solve: total,
                total,
                ..Seconds::default()
            },
            ..InstantaneousSolution::solved_directly(
                computed,
                axial.dofs() + spin.map_or(0, AxialResistance::dofs),
                residual.max(axial.residual()),
            )
        };
        solution.correct(error);
        Ok(solution)
    }
}

impl Hydrodynamics for AxisymmetricModel {
    fn scene(&self) -> &Scene {
        &self.scaled.scene
    }

    fn name(&self) -> &'static str {
        "axisymmetric"
    }

    // The resistances are computed once and serve all rates.
    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        // Relative error of resistances over the resulting relative error of velocities.
        const SHARE: f64 = 0.2;
        if query.rates.is_empty() {
            return Ok(Vec::new());
        }
        let mut clock = Clock::now();
        let tolerance = (query.accuracy).map_or(self.tolerance, |accuracy| {
            self.tolerance.min(SHARE * accuracy).max(MIN_TOLERANCE)
        });
        if let Some(law) = self.law {
            return (query.rates.iter())
                .map(|rates| self.law_solution(query, rates, &law, tolerance))
                .collect();
        }
        let resistances = self.resistances_at(query.configuration, tolerance)?;
        let mut solutions: Vec<_> = (query.rates.iter())
            .map(|rates| {
                let begin = std::mem::replace(&mut clock, Clock::now());
                self.solution(query, rates, &resistances, begin)
            })
            .collect::<Result<_, _>>()?;
        if query.stresslets && !self.scaled.scene.deforms() {
            self.add_stresslets(query.configuration, &resistances, tolerance, &mut solutions)?;
        }
        Ok(solutions)
    }

    fn capabilities(&self) -> Capabilities {
        Capabilities {
            error_estimates: ErrorEstimates::Always,
            controls_error: true,
            follows_rheology: true,
            deforms: true,
            solves_together: true,
            ..Capabilities::default()
        }
    }

    fn duplicate(&self) -> Option<Box<dyn Hydrodynamics>> {
        Some(Box::new(self.clone()))
    }

    fn neglected(&mut self, term: NeglectedTerm) -> Result<&mut dyn NeglectedTerms, ModelError> {
        match term {
            NeglectedTerm::Rheology => Ok(self),
            NeglectedTerm::Inertia => Err(no_inertia()),
        }
    }

    fn flows(&mut self) -> Result<&mut dyn Flows, ModelError> {
        let scene = &self.scaled.scene;
        if scene.deforms() {
            let what = "the flow at points around bodies that deform in the meridian plane";
            return Err(ModelError::unsupported(
                what,
                "use model.kind = \"fem\", or \"multipole\" for spheres",
            ));
        }
        if scene.inertia().is_kept() {
            let what = format!(
                "{}: the flow at points of a fluid with inertia in the meridian plane",
                scene.place("fluid.inertia")
            );
            return Err(ModelError::unsupported(what, "use model.kind = \"fem\""));
        }
        Ok(self)
    }

    fn resistances(&mut self) -> Result<&mut dyn Resistances, ModelError> {
        let what = "the grand resistance by the model 'axisymmetric', which is restricted to \
                    motions along the axis,";
        let instead = "use model.kind = \"multipole\" or \"fem\"";
        Err(ModelError::unsupported(what, instead))
    }

    fn mesh(&mut self, _configuration: Configuration<'_>) -> Result<Option<TetMesh>, ModelError> {
        let what = "a mesh file of the meridian plane of the model 'axisymmetric'";
        let instead = "use model.kind = \"fem\" for a three-dimensional mesh";
        Err(ModelError::unsupported(what, instead))
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<PredictedCost, ModelError> {
        /// Matrix factors take about 250 numbers per degree of freedom.
        const MIB_PER_DOF: f64 = 2e-3;
        // Solving is the cheapest way to find its cost.
        let rates = vec![0.0; configuration.shape.len()];
        let solution = self.solve_one(configuration, &rates)?;
        Ok(PredictedCost {
            dofs: solution.dofs,
            seconds: solution.seconds.total,
            mib: MIB_PER_DOF * solution.dofs.total as f64,
        })
    }
}

impl NeglectedTerms for AxisymmetricModel {
    fn change(
        &mut self,
        term: NeglectedTerm,
        at: &PathPoint<'_>,
    ) -> Result<FirstOrderChange, ModelError> {
        match term {
            NeglectedTerm::Rheology => self.law_change(at),
            NeglectedTerm::Inertia => Err(no_inertia()),
        }
    }

    fn jump(
        &mut self,
        _: Configuration<'_>,
        _: &[f64],
        _: &[f64],
    ) -> Result<FirstOrderChange, ModelError> {
        Err(no_inertia())
    }
}

/// The refusal of the effect of inertia.
fn no_inertia() -> ModelError {
    let what = "the effect of inertia by the model 'axisymmetric'";
    ModelError::unsupported(what, "use model.kind = \"fem\"")
}

impl Flows for AxisymmetricModel {
    fn flow(&mut self, _: Configuration<'_>, _: &[f64]) -> Result<FlowField, ModelError> {
        Err(ModelError::NoMesh)
    }

    fn flow_at(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
        points: &[Vector3<f64>],
    ) -> Result<Vec<Option<PointFlow>>, ModelError> {
        self.flow_in_meridian_plane(configuration, rates, points)
    }
}
