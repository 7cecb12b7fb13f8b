//! Bodies on an axis of the domain that move along it: finite elements in the meridian half-plane.

use std::f64::consts::PI;
use std::time::Instant as Clock;

use axisymmetric::{AxialResistance, Spheroid, Surroundings, axial_resistance, spin_resistance};
use mesh::TetMesh;
use nalgebra::{DMatrix, Matrix3, Vector3};
use rigid::Twist;

use crate::error::ModelError;
use crate::error_estimate::ErrorEstimate;
use crate::hydrodynamics::{Configuration, Cost, ErrorEstimates, Hydrodynamics, Query};
use crate::mesh_error::MeshError;
use crate::mobility::MobilitySolution;
use crate::scaled::ScaledScene;
use crate::solution::InstantaneousSolution;
use scene::{Arrangement, Domain, Scene, Shape};
use stokes::{Dofs, Seconds, SolverReport};

/// FlowField around bodies on one axis that move along it and turn about it.
///
/// Its resistance knows motions and forces along the axis and, where there are torques, about it. All others are at rest by symmetry: they
/// stand in the equations with some positive resistance of their own and come out as zero.
pub struct AxisymmetricModel {
    scaled: ScaledScene,
    /// The bodies with surfaces, at the origin.
    shapes: Vec<Spheroid>,
    surroundings: Surroundings,
    /// Unit vector along the axis.
    axis: Vector3<f64>,
    /// Whether some body is turned about the axis: flow with swirl, which is computed apart.
    turns: bool,
    /// Relative error asked of resistances.
    tolerance: f64,
}

/// Distance from the axis, over the smallest radius, that counts as rounding along a stroke.
const OFF_AXIS: f64 = 1e-6;

/// What the estimate of a velocity's error may err by, as a part of it: it continues the orders' changes as a geometric series, whose
/// factor varies by about this much from order to order.
const UNSURE: f64 = 0.5;

impl AxisymmetricModel {
    /// The model of a scene.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] for arrangements, domains and loads that are not symmetric about an axis.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let refuse = |key: &str, problem: String, instead: &str| {
            Err(ModelError::Unsupported {
                what: format!(
                    "{}: {problem} for model.kind = \"axisymmetric\"",
                    scene.place(key)
                ),
                instead: instead.to_owned(),
            })
        };
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
            let problem = match scene.arrangement() {
                Arrangement::Collinear => {
                    "a domain, loads or spheroids that are not symmetric about the line of the bodies"
                }
                _ => "an arrangement of bodies that are not on one line",
            };
            return refuse(
                "bodies",
                problem.to_owned(),
                "put bodies and their forces on one axis of the domain, or use model.kind = \"auto\"",
            );
        };
        Ok(Self {
            shapes: (scene.bodies().iter())
                .filter_map(|body| match body.shape {
                    Shape::Sphere { radius } => Some(Spheroid::sphere(0.0, scale.length(radius))),
                    Shape::Spheroid {
                        radius,
                        half_length,
                        ..
                    } => Some(Spheroid {
                        centre: 0.0,
                        axial: scale.length(half_length),
                        equatorial: scale.length(radius),
                    }),
                    Shape::Point => None,
                })
                .collect(),
            turns: scene.bodies().iter().any(|b| b.torque != Vector3::zeros()),
            surroundings,
            axis,
            // the net displacement is a small difference of the legs' and amplifies errors: by 8 for the three-sphere swimmer
            tolerance: (0.05 * scene.model().tolerance).clamp(1e-11, 1e-4),
            scaled,
        })
    }

    /// Whether `auto` takes this model: where models without a mesh know the domain or a body not, and elements in space would cost a
    /// thousand times as much.
    pub fn suits(scene: &Scene) -> bool {
        let is_needed =
            matches!(scene.domain(), Domain::Cylinder { .. }) || scene.first_spheroid().is_some();
        is_needed && scene.arrangement() == Arrangement::Axisymmetric
    }

    /// What the model costs and errs at the start, and why no other rung is there.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`].
    pub fn describe(&mut self, scene: &Scene) -> Result<String, ModelError> {
        let lengths = scene.articulation().initial_lengths();
        let configuration = Configuration {
            state: &scene.initial_state(),
            lengths,
        };
        let clock = Clock::now();
        let axial = axial_resistance(
            &self.on_axis(configuration)?,
            self.surroundings,
            self.tolerance,
        )?;
        let unknown = match scene.first_spheroid() {
            Some(_) => "shape = \"spheroid\"".to_owned(),
            None => format!("domain.kind = \"{}\"", scene.domain().kind().word()),
        };
        Ok(format!(
            "models without a mesh know no {unknown}; axisymmetric errs {:.1e} in the resistance with {} unknowns at {:.0} ms a solve",
            axial.relative_error(),
            axial.dofs(),
            1e3 * clock.elapsed().as_secs_f64()
        ))
    }

    /// The bodies with surfaces as they lie on the axis.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] when one has left it.
    fn on_axis(&self, configuration: Configuration) -> Result<Vec<Spheroid>, ModelError> {
        let centres = self.scaled.centres(configuration)?;
        let origin = match self.surroundings {
            Surroundings::Unbounded => centres[0],
            Surroundings::Ball { .. } | Surroundings::Cylinder { .. } => Vector3::zeros(),
        };
        (centres.iter().zip(&self.shapes).enumerate())
            .map(|(number, (centre, &shape))| {
                let from_origin = centre - origin;
                let along = from_origin.dot(&self.axis);
                let off = (from_origin - along * self.axis).norm();
                if off <= OFF_AXIS {
                    return Ok(Spheroid {
                        centre: along,
                        ..shape
                    });
                }
                Err(ModelError::Unsupported {
                    what: format!(
                        "model.kind = \"axisymmetric\" for body {number} at {off:e} of the smallest radius from the axis"
                    ),
                    instead: "use model.kind = \"auto\"".to_owned(),
                })
            })
            .collect()
    }

    /// The matrix for motions in space: entries along and about the axis as computed, and Stokes's for motions that symmetry keeps at rest.
    fn in_space(&self, axial: &DMatrix<f64>, spin: Option<&DMatrix<f64>>) -> DMatrix<f64> {
        let n = self.shapes.len();
        let along: Matrix3<f64> = self.axis * self.axis.transpose();
        let across = Matrix3::identity() - along;
        let mut matrix = DMatrix::zeros(6 * n, 6 * n);
        for i in 0..n {
            for j in 0..n {
                let block = along * axial[(i, j)];
                matrix
                    .fixed_view_mut::<3, 3>(6 * i, 6 * j)
                    .copy_from(&block);
            }
            let size = self.shapes[i].axial.max(self.shapes[i].equatorial);
            let (drag, torque) = (6.0 * PI * size, 8.0 * PI * size.powi(3));
            let mut own = matrix.fixed_view_mut::<3, 3>(6 * i, 6 * i);
            own += across * drag;
            let mut own = matrix.fixed_view_mut::<3, 3>(6 * i + 3, 6 * i + 3);
            own += match spin {
                Some(_) => across * torque,
                None => Matrix3::identity() * torque,
            };
            for j in 0..n {
                let about = spin.map_or(0.0, |spin| spin[(i, j)]);
                let mut block = matrix.fixed_view_mut::<3, 3>(6 * i + 3, 6 * j + 3);
                block += along * about;
            }
        }
        matrix
    }

    /// The answer for the rates of a configuration whose resistances are known, begun at `clock`.
    fn answer(
        &self,
        configuration: Configuration,
        rates: &[f64],
        axial: &AxialResistance,
        spin: Option<&AxialResistance>,
        clock: Clock,
    ) -> Result<InstantaneousSolution, ModelError> {
        let ScaledScene { scale, set, loads } = &self.scaled;
        let constraints = self.scaled.constraints(configuration, rates)?;
        let solve = |of: fn(&AxialResistance) -> &DMatrix<f64>| {
            let matrix = self.in_space(of(axial), spin.map(of));
            MobilitySolution::new(&matrix, set, &constraints, loads)
        };
        let solved = solve(AxialResistance::matrix)?;
        let coarser = solve(AxialResistance::lower_order)?;
        let bodies = solved.bodies(set, scale)?;
        let coarser_bodies = coarser.bodies(set, scale)?;
        let motion = |solved: &MobilitySolution| -> Result<_, ModelError> {
            let motion = set.state_velocity(solved.generalised.as_slice())?;
            Ok(scale.motion_back(&motion))
        };
        let (moves, coarser_moves) = (motion(&solved)?, motion(&coarser)?);
        // computed less exact: what the order before errs more by, continued
        let tail = axial.error_factor();
        let tail_of_spin = spin.map_or(0.0, AxialResistance::error_factor);
        let velocities: Vec<Vector3<f64>> = (bodies.iter().zip(&coarser_bodies))
            .map(|(last, before)| tail * (before.velocity - last.velocity))
            .collect();
        let forces = (bodies.iter().zip(&coarser_bodies))
            .map(|(last, before)| tail * (before.force - last.force))
            .collect();
        let error = velocities.iter().fold(0.0_f64, |m, e| m.max(e.norm()));
        let fastest = bodies.iter().fold(0.0_f64, |m, b| m.max(b.velocity.norm()));
        let total = clock.elapsed().as_secs_f64();
        let link_forces = solved.link_forces(set, &constraints, loads, scale)?;
        Ok(InstantaneousSolution {
            dofs: Dofs {
                total: axial.dofs() + spin.map_or(0, AxialResistance::dofs),
                ..Dofs::default()
            },
            solver: SolverReport {
                formulation: "p-tilde".to_owned(),
                solver: "direct".to_owned(),
                iterations: 0,
                true_relative_residual: solved.residual.max(axial.residual()),
            },
            seconds: Seconds {
                solve: total,
                total,
                ..Seconds::default()
            },
            error_estimate: ErrorEstimate {
                mesh: Some(error.hypot(UNSURE * error)),
                container: (self.surroundings == Surroundings::Unbounded)
                    .then(|| axial.truncation_error() * fastest),
                ..ErrorEstimate::default()
            },
            mesh_error: Some(MeshError {
                frames: (moves.frames.iter().zip(&coarser_moves.frames))
                    .map(|(last, before)| Twist {
                        linear: tail * (before.linear - last.linear),
                        angular: tail_of_spin * (before.angular - last.angular),
                    })
                    .collect(),
                bodies: velocities,
                uncertainty: UNSURE * error,
                forces,
            }),
            ..InstantaneousSolution::new(bodies, link_forces, moves)
        })
    }
}

impl Hydrodynamics for AxisymmetricModel {
    fn name(&self) -> &'static str {
        "axisymmetric"
    }

    fn error_estimates(&self) -> ErrorEstimates {
        ErrorEstimates::Always
    }

    /// The resistances depend on the configuration alone; error estimates come in any case.
    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        // Velocities of linked bodies have a few times the relative error of resistances.
        const SHARE: f64 = 0.2;
        if query.rates.is_empty() {
            return Ok(Vec::new());
        }
        let mut clock = Clock::now();
        let tolerance = (query.accuracy).map_or(self.tolerance, |accuracy| {
            self.tolerance.min(SHARE * accuracy)
        });
        let bodies = self.on_axis(query.configuration)?;
        let axial = axial_resistance(&bodies, self.surroundings, tolerance)?;
        let spin = match self.turns {
            true => Some(spin_resistance(&bodies, self.surroundings, tolerance)?),
            false => None,
        };
        (query.rates.iter())
            .map(|rates| {
                let begin = std::mem::replace(&mut clock, Clock::now());
                self.answer(query.configuration, rates, &axial, spin.as_ref(), begin)
            })
            .collect()
    }

    fn resistance(
        &mut self,
        _configuration: Configuration<'_>,
    ) -> Result<DMatrix<f64>, ModelError> {
        Err(ModelError::Unsupported {
            what: "the grand resistance by the model 'axisymmetric', which knows motions along the axis only,".to_owned(),
            instead: "use model.kind = \"multipole\" or \"fem\"".to_owned(),
        })
    }

    fn mesh(&mut self, _configuration: Configuration<'_>) -> Result<Option<TetMesh>, ModelError> {
        Err(ModelError::Unsupported {
            what: "a file of the triangles in the meridian plane of the model 'axisymmetric'"
                .to_owned(),
            instead: "use model.kind = \"fem\" for a mesh in space".to_owned(),
        })
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError> {
        /// Factors: about 250 numbers an unknown.
        const MIB_PER_UNKNOWN: f64 = 2e-3;
        // there is nothing cheaper to know than the answer
        let rates = vec![0.0; configuration.lengths.len()];
        let solution = self.solve_one(configuration, &rates)?;
        Ok(Cost {
            dofs: solution.dofs,
            seconds: solution.seconds.total,
            mib: MIB_PER_UNKNOWN * solution.dofs.total as f64,
        })
    }
}
