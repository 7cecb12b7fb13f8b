//! Models without a mesh: spheres by point forces, Rotne-Prager-Yamakawa, or multipole expansions.

mod picture;

use std::time::Instant as Clock;

use microhydro::{Accuracy, Medium, Resistance, Spheres, multipole, oseen, rpy};
use nalgebra::{DMatrix, Vector3};

use crate::error::ModelError;
use crate::error_estimate::ErrorEstimate;
use crate::hydrodynamics::{Configuration, Cost, Hydrodynamics, Query};
use crate::mobility::MobilitySolution;
use crate::scaled::ScaledScene;
use crate::solution::{FlowField, InstantaneousSolution};
use scene::{Domain, Scene, Shape};
use stokes::{Dofs, Seconds, SolverReport};

/// Which of the models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SphereModel {
    /// Point forces.
    Oseen,
    /// Rotne-Prager-Yamakawa.
    Rpy,
    /// Multipole expansions whose resistance errs by this relative error.
    Multipole(f64),
}

impl SphereModel {
    /// The expansion for the tolerance that a scene asks of its net displacement.
    ///
    /// The net displacement is a small difference of the legs', and amplifies errors of the resistance: by 8 for the
    /// three-sphere swimmer, by up to 100 for the planar one.
    pub fn for_displacement(scene: &Scene) -> Self {
        Self::Multipole((0.01 * scene.model().tolerance).clamp(1e-12, 1e-3))
    }

    /// In words.
    pub fn describe(self) -> String {
        match self {
            Self::Oseen => "oseen".to_owned(),
            Self::Rpy => "rpy".to_owned(),
            Self::Multipole(tolerance) => format!("multipole to {tolerance:.0e}"),
        }
    }
}

/// Spheres in unbounded fluid, in a ball, or beside a wall.
pub struct SpheresModel {
    kind: SphereModel,
    scaled: ScaledScene,
    radii: Vec<f64>,
    /// Names of the bodies with surfaces.
    names: Vec<String>,
    medium: Medium,
    /// The last answer: other rates of the same shape ask for the same resistance.
    last: Option<(Spheres, Judged)>,
}

/// Orders of the expansions that judge the lesser models, from the cheapest on. Not tolerances: close to contact these would need orders in
/// the hundreds, to tell what a lesser model misses by most of itself.
const JUDGES: [usize; 4] = [4, 8, 16, 28];

/// A judge will do if it errs by less than this part of the error it finds.
const JUDGE_SHARE: f64 = 0.3;

/// Resistance and how to tell its error: other resistances, each compared with the one before; the error is the sum of the differences
/// times their factors.
#[derive(Clone)]
struct Judged {
    matrix: DMatrix<f64>,
    others: Vec<(DMatrix<f64>, f64)>,
    unknowns: usize,
}

impl SpheresModel {
    /// The model of a scene.
    ///
    /// # Errors
    /// A domain that these models do not treat.
    pub fn new(scene: &Scene, kind: SphereModel) -> Result<Self, ModelError> {
        if let Some(number) = scene.first_spheroid() {
            return Err(ModelError::Unsupported {
                what: format!(
                    "{}: shape = \"spheroid\" for models of spheres",
                    scene.place(&format!("bodies[{number}].shape"))
                ),
                instead: "use model.kind = \"axisymmetric\" with all bodies on one axis".to_owned(),
            });
        }
        let scaled = ScaledScene::new(scene)?;
        let scale = scaled.scale;
        let medium = match *scene.domain() {
            Domain::Unbounded => Medium::Unbounded,
            Domain::Ball { radius } => Medium::Ball {
                centre: Vector3::zeros(),
                radius: scale.length(radius),
            },
            Domain::Wall => Medium::wall(Vector3::zeros(), Vector3::z())?,
            _ => {
                return Err(ModelError::Unsupported {
                    what: format!(
                        "{}: domain.kind = \"{}\" for models of spheres",
                        scene.place("domain.kind"),
                        scene.domain().kind().word()
                    ),
                    instead: "use model.kind = \"fem\", or the domain unbounded, ball or wall"
                        .to_owned(),
                });
            }
        };
        Ok(Self {
            kind,
            radii: scene
                .bodies()
                .iter()
                .filter_map(|body| match body.shape {
                    Shape::Sphere { radius } => Some(scale.length(radius)),
                    // refused above
                    Shape::Spheroid { .. } | Shape::Point => None,
                })
                .collect(),
            names: scene
                .bodies()
                .iter()
                .filter(|body| body.shape != Shape::Point)
                .map(|body| body.name.clone())
                .collect(),
            medium,
            scaled,
            last: None,
        })
    }

    fn spheres(&self, configuration: Configuration) -> Result<Spheres, ModelError> {
        let centres = self.scaled.centres(configuration)?;
        Ok(Spheres::new(centres, self.radii.clone())?)
    }

    fn judged(&mut self, configuration: Configuration) -> Result<Judged, ModelError> {
        let spheres = self.spheres(configuration)?;
        if let Some((known, judged)) = &self.last
            && *known == spheres
        {
            return Ok(judged.clone());
        }
        let judged = self.judge(&spheres)?;
        self.last = Some((spheres, judged.clone()));
        Ok(judged)
    }

    fn judge(&self, spheres: &Spheres) -> Result<Judged, ModelError> {
        let expansion = |accuracy: Accuracy| -> Result<Resistance, ModelError> {
            Ok(multipole::resistance(spheres, &self.medium, &accuracy)?)
        };
        let matrix = match self.kind {
            SphereModel::Multipole(tolerance) => {
                let found = expansion(Accuracy::relative(tolerance))?;
                return Ok(Judged {
                    unknowns: found.dofs(),
                    others: vec![(found.coarser().clone(), found.tail())],
                    matrix: found.matrix().clone(),
                });
            }
            SphereModel::Oseen => oseen::resistance(spheres, &self.medium)?,
            SphereModel::Rpy => rpy::resistance(spheres, &self.medium)?,
        };
        let unknowns = matrix.nrows();
        let mut judge = expansion(Accuracy::order(JUDGES[0]))?;
        for &order in &JUDGES[1..] {
            if judge.relative_error() <= JUDGE_SHARE * judge.relative_difference(&matrix) {
                break;
            }
            judge = expansion(Accuracy::order(order))?;
        }
        Ok(Judged {
            matrix,
            others: vec![
                (judge.matrix().clone(), 1.0),
                (judge.coarser().clone(), judge.tail()),
            ],
            unknowns,
        })
    }

    /// The solution for one set of rates; the resistance of the last configuration is kept.
    fn solve_rates(
        &mut self,
        configuration: Configuration,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        let clock = Clock::now();
        let judged = self.judged(configuration)?;
        let assembly = clock.elapsed().as_secs_f64();
        let ScaledScene { scale, set, loads } = &self.scaled;
        let constraints = self.scaled.constraints(configuration, rates)?;
        let solved = MobilitySolution::new(&judged.matrix, set, &constraints, loads)?;
        let mut error = 0.0;
        let mut before = solved.clone();
        for (other, factor) in &judged.others {
            let other = MobilitySolution::new(other, set, &constraints, loads)?;
            error += factor * before.fastest_difference(&other, set);
            before = other;
        }
        let total = clock.elapsed().as_secs_f64();
        let motion = scale.motion_back(&set.state_velocity(solved.generalised.as_slice())?);
        let link_forces = solved.link_forces(set, &constraints, loads, scale)?;
        Ok(InstantaneousSolution {
            dofs: Dofs {
                total: judged.unknowns,
                ..Dofs::default()
            },
            solver: SolverReport {
                formulation: "p-tilde".to_owned(),
                solver: "direct".to_owned(),
                iterations: 0,
                true_relative_residual: solved.residual,
            },
            seconds: Seconds {
                assembly,
                solve: total - assembly,
                total,
                ..Seconds::default()
            },
            error_estimate: ErrorEstimate {
                model: Some(scale.velocity_back(Vector3::x() * error).x),
                ..ErrorEstimate::default()
            },
            ..InstantaneousSolution::new(solved.bodies(set, scale)?, link_forces, motion)
        })
    }
}

impl Hydrodynamics for SpheresModel {
    fn name(&self) -> &'static str {
        match self.kind {
            SphereModel::Oseen => "oseen",
            SphereModel::Rpy => "rpy",
            SphereModel::Multipole(_) => "multipole",
        }
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        (query.rates.iter())
            .map(|rates| self.solve_rates(query.configuration, rates))
            .collect()
    }

    fn resistance(&mut self, configuration: Configuration<'_>) -> Result<DMatrix<f64>, ModelError> {
        let judged = self.judged(configuration)?;
        Ok(self.scaled.scale.resistance_back(judged.matrix))
    }

    fn flow(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<FlowField, ModelError> {
        let judged = self.judged(configuration)?;
        let ScaledScene { scale, set, loads } = &self.scaled;
        let constraints = self.scaled.constraints(configuration, rates)?;
        let solved = MobilitySolution::new(&judged.matrix, set, &constraints, loads)?;
        let spheres = self.spheres(configuration)?;
        let names: Vec<&str> = self.names.iter().map(String::as_str).collect();
        let velocities = solved.generalised.select_rows(&set.surface_velocities());
        let (mesh, velocity) = picture::picture(&spheres, &self.medium, &names, &velocities)?;
        Ok(FlowField {
            mesh: scale.mesh_back(&mesh)?,
            velocity: velocity
                .into_iter()
                .map(|u| scale.velocity_back(u))
                .collect(),
            pressure: Vec::new(),
        })
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError> {
        // there is nothing cheaper to know than the answer
        let rates = vec![0.0; configuration.lengths.len()];
        let solution = self.solve_one(configuration, &rates)?;
        Ok(Cost {
            dofs: solution.dofs,
            seconds: solution.seconds.total,
            mib: 0.0,
        })
    }
}
