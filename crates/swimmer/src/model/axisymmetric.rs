//! Bodies on an axis of the domain that move along it: finite elements in the meridian half-plane.

use std::f64::consts::PI;
use std::time::Instant as Clock;

use axisymmetric::{AxialResistance, Spheroid, Surroundings, axial_resistance, spin_resistance};
use mesh::TetMesh;
use nalgebra::{DMatrix, Matrix3, Vector3};
use rigid::{State, Twist};

use super::scaled::ScaledScene;
use super::spheres::Solved;
use crate::model::{
    Cost, Dofs, ErrorEstimate, Hydrodynamics, Instant, MeshError, ModelError, Placement, Seconds,
    SolverInfo,
};
use scene::{Arrangement, Domain, Scene, Shape};

/// Flow around bodies on one axis that move along it and turn about it.
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
    /// [`ModelError::NotBuilt`] for arrangements, domains and loads that are not symmetric about an axis.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        let refuse = |key: &str, problem: String, instead: &str| {
            Err(ModelError::NotBuilt {
                what: format!(
                    "{}: {problem} for model.kind = \"axisymmetric\"",
                    scene.place(key)
                ),
                instead: instead.to_owned(),
            })
        };
        let scaled = ScaledScene::new(scene)?;
        let scale = scaled.scale;
        let surroundings = match scene.domain {
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
                    format!("domain.kind = \"{}\"", scene.domain.kind().word()),
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
            shapes: (scene.bodies.iter())
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
            turns: scene.bodies.iter().any(|b| b.torque != Vector3::zeros()),
            surroundings,
            axis,
            // the net displacement is a small difference of the legs' and amplifies errors: by 8 for the three-sphere swimmer
            tolerance: (0.05 * scene.model.tolerance).clamp(1e-11, 1e-4),
            scaled,
        })
    }

    /// Whether `auto` takes this model: where models without a mesh know the domain or a body not, and elements in space would cost a
    /// thousand times as much.
    pub(super) fn suits(scene: &Scene) -> bool {
        let is_needed =
            matches!(scene.domain, Domain::Cylinder { .. }) || scene.first_spheroid().is_some();
        is_needed && scene.arrangement() == Arrangement::Axisymmetric
    }

    /// What the model costs and errs at the start, and why no other rung is there.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`].
    pub(super) fn describe(&mut self, scene: &Scene) -> Result<String, ModelError> {
        let lengths = scene.articulation.initial_lengths();
        let placement = Placement {
            state: &scene.initial_state(),
            lengths,
            rates: &vec![0.0; lengths.len()],
        };
        let clock = Clock::now();
        let axial = self.axial(&placement)?;
        let unknown = match scene.first_spheroid() {
            Some(_) => "shape = \"spheroid\"".to_owned(),
            None => format!("domain.kind = \"{}\"", scene.domain.kind().word()),
        };
        Ok(format!(
            "models without a mesh know no {unknown}; axisymmetric errs {:.1e} in the resistance with {} unknowns at {:.0} ms a solve",
            axial.relative_error(),
            axial.unknowns(),
            1e3 * clock.elapsed().as_secs_f64()
        ))
    }

    /// The bodies with surfaces as they lie on the axis.
    ///
    /// # Errors
    /// [`ModelError::NotBuilt`] when one has left it.
    fn on_axis(&self, placement: &Placement) -> Result<Vec<Spheroid>, ModelError> {
        let centres = self.scaled.centres(placement)?;
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
                Err(ModelError::NotBuilt {
                    what: format!(
                        "model.kind = \"axisymmetric\" for body {number} at {off:e} of the smallest radius from the axis"
                    ),
                    instead: "use model.kind = \"auto\"".to_owned(),
                })
            })
            .collect()
    }

    fn axial(&self, placement: &Placement) -> Result<AxialResistance, ModelError> {
        Ok(axial_resistance(
            &self.on_axis(placement)?,
            self.surroundings,
            self.tolerance,
        )?)
    }

    /// The resistance to turning about the axis, if anything turns.
    fn spin(&self, placement: &Placement) -> Result<Option<AxialResistance>, ModelError> {
        if !self.turns {
            return Ok(None);
        }
        let bodies = self.on_axis(placement)?;
        Ok(Some(spin_resistance(
            &bodies,
            self.surroundings,
            self.tolerance,
        )?))
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

    /// The answer for the rates of a placement whose resistances are known, begun at `clock`.
    fn answer(
        &self,
        placement: &Placement,
        axial: &AxialResistance,
        spin: Option<&AxialResistance>,
        clock: Clock,
    ) -> Result<Instant, ModelError> {
        let ScaledScene { scale, set, loads } = &self.scaled;
        let constraints = self.scaled.constraints(placement)?;
        let solve = |of: fn(&AxialResistance) -> &DMatrix<f64>| {
            let matrix = self.in_space(of(axial), spin.map(of));
            Solved::new(&matrix, set, &constraints, loads)
        };
        let solved = solve(AxialResistance::matrix)?;
        let coarser = solve(AxialResistance::coarser)?;
        let bodies = solved.bodies(set, scale)?;
        let coarser_bodies = coarser.bodies(set, scale)?;
        let motion = |solved: &Solved| -> Result<_, ModelError> {
            let motion = set.state_velocity(solved.generalised.as_slice())?;
            Ok(scale.motion_back(&motion))
        };
        let (moves, coarser_moves) = (motion(&solved)?, motion(&coarser)?);
        // computed less exact: what the order before errs more by, continued
        let tail = axial.tail();
        let tail_of_spin = spin.map_or(0.0, AxialResistance::tail);
        let velocities: Vec<Vector3<f64>> = (bodies.iter().zip(&coarser_bodies))
            .map(|(last, before)| tail * (before.velocity - last.velocity))
            .collect();
        let forces = (bodies.iter().zip(&coarser_bodies))
            .map(|(last, before)| tail * (before.force - last.force))
            .collect();
        let error = velocities.iter().fold(0.0_f64, |m, e| m.max(e.norm()));
        let fastest = bodies.iter().fold(0.0_f64, |m, b| m.max(b.velocity.norm()));
        let total = clock.elapsed().as_secs_f64();
        Ok(Instant {
            link_forces: solved.link_forces(set, &constraints, loads, scale)?,
            dofs: Dofs {
                total: axial.unknowns() + spin.map_or(0, AxialResistance::unknowns),
                ..Dofs::default()
            },
            solver: SolverInfo {
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
                    .then(|| axial.far_error() * fastest),
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
            checks: None,
            remeshed: None,
            motion: moves,
            bodies,
        })
    }
}

impl Hydrodynamics for AxisymmetricModel {
    fn name(&self) -> &'static str {
        "axisymmetric"
    }

    fn instant(&mut self, placement: &Placement<'_>) -> Result<Instant, ModelError> {
        let clock = Clock::now();
        let (axial, spin) = (self.axial(placement)?, self.spin(placement)?);
        self.answer(placement, &axial, spin.as_ref(), clock)
    }

    /// The resistances depend on the shape alone.
    fn instants(
        &mut self,
        state: &State,
        lengths: &[f64],
        rates: &[Vec<f64>],
    ) -> Result<Vec<Instant>, ModelError> {
        let mut clock = Clock::now();
        let mut placements = Placement::at_rates(state, lengths, rates).peekable();
        let Some(first) = placements.peek() else {
            return Ok(Vec::new());
        };
        let (axial, spin) = (self.axial(first)?, self.spin(first)?);
        placements
            .map(|placement| {
                let begin = std::mem::replace(&mut clock, Clock::now());
                self.answer(&placement, &axial, spin.as_ref(), begin)
            })
            .collect()
    }

    fn instant_within(
        &mut self,
        placement: &Placement<'_>,
        error: f64,
    ) -> Result<Instant, ModelError> {
        // velocities of linked bodies err by a few times what resistances do
        const SHARE: f64 = 0.2;
        let usual = self.tolerance;
        self.tolerance = usual.min(SHARE * error);
        let answer = self.instant(placement);
        self.tolerance = usual;
        answer
    }

    fn want_estimates(&mut self, _wanted: bool) -> bool {
        // they are there in any case
        true
    }

    fn resistance(&mut self, _placement: &Placement<'_>) -> Result<DMatrix<f64>, ModelError> {
        Err(ModelError::NotBuilt {
            what: "the grand resistance by the model 'axisymmetric', which knows motions along the axis only,".to_owned(),
            instead: "use model.kind = \"multipole\" or \"fem\"".to_owned(),
        })
    }

    fn mesh(&mut self, _placement: &Placement<'_>) -> Result<Option<TetMesh>, ModelError> {
        Err(ModelError::NotBuilt {
            what: "a file of the triangles in the meridian plane of the model 'axisymmetric'"
                .to_owned(),
            instead: "use model.kind = \"fem\" for a mesh in space".to_owned(),
        })
    }

    fn cost(&mut self, placement: &Placement<'_>) -> Result<Cost, ModelError> {
        /// Factors: about 250 numbers an unknown.
        const MIB_PER_UNKNOWN: f64 = 2e-3;
        // there is nothing cheaper to know than the answer
        let instant = self.instant(placement)?;
        Ok(Cost {
            dofs: instant.dofs,
            seconds: instant.seconds.total,
            mib: MIB_PER_UNKNOWN * instant.dofs.total as f64,
        })
    }
}
