//! Models without a mesh: spheres by point forces, Rotne-Prager-Yamakawa, or multipole expansions.

mod instant;

use std::time::Instant as Clock;

use microhydro::{Accuracy, Medium, Resistance, Spheres, multipole, oseen, rpy};
use nalgebra::{DMatrix, Isometry3, Vector3};
use rigid::{Articulation, BodyKind, Constraints, Load};

pub(super) use self::instant::Solved;
use super::fem::scale::Scale;
use crate::model::{
    Cost, Dofs, ErrorEstimate, Hydrodynamics, Instant, ModelError, Placement, Seconds, SolverInfo,
};
use crate::scene::{Domain, Scene, Shape};

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
        Self::Multipole((0.01 * scene.model.tolerance).clamp(1e-12, 1e-3))
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
    scale: Scale,
    /// The bodies and links in units of the flow.
    set: Articulation,
    loads: Vec<Load>,
    radii: Vec<f64>,
    medium: Medium,
}

/// Accuracy of the expansion that judges the lesser models: they are wrong by more.
const JUDGE: f64 = 1e-3;

/// Resistance and how to tell its error: another resistance, whose difference times a factor is the error.
struct Judged {
    matrix: DMatrix<f64>,
    other: DMatrix<f64>,
    factor: f64,
    unknowns: usize,
}

impl SpheresModel {
    /// The model of a scene.
    ///
    /// # Errors
    /// A domain that these models do not treat.
    pub fn new(scene: &Scene, kind: SphereModel) -> Result<Self, ModelError> {
        if let Some(number) = scene.first_spheroid() {
            return Err(ModelError::NotBuilt {
                what: format!(
                    "{}: shape = \"spheroid\" for models of spheres",
                    scene.place(&format!("bodies[{number}].shape"))
                ),
                instead: "use model.kind = \"axisymmetric\" with all bodies on one axis".to_owned(),
            });
        }
        let scale = Scale::of(scene);
        let kinds: Vec<_> = scene.bodies.iter().map(|b| b.kind()).collect();
        let positions: Vec<_> = scene
            .bodies
            .iter()
            .map(|b| scale.point(b.position))
            .collect();
        let set = Articulation::new(
            &kinds,
            scene.articulation.links().to_vec(),
            scene.articulation.arms(),
            &positions,
        )?;
        let medium = match scene.domain {
            Domain::Unbounded => Medium::Unbounded,
            Domain::Ball { radius } => Medium::Ball {
                centre: Vector3::zeros(),
                radius: scale.length(radius),
            },
            Domain::Wall => Medium::wall(Vector3::zeros(), Vector3::z())?,
            _ => {
                return Err(ModelError::NotBuilt {
                    what: format!(
                        "{}: domain.kind = \"{}\" for models of spheres",
                        scene.place("domain.kind"),
                        scene.domain.kind().word()
                    ),
                    instead: "use model.kind = \"fem\", or the domain unbounded, ball or wall"
                        .to_owned(),
                });
            }
        };
        Ok(Self {
            kind,
            set,
            loads: scene
                .bodies
                .iter()
                .map(|b| scale.load(b.force, b.torque))
                .collect(),
            radii: scene
                .bodies
                .iter()
                .filter_map(|body| match body.shape {
                    Shape::Sphere { radius } => Some(scale.length(radius)),
                    // refused above
                    Shape::Spheroid { .. } | Shape::Point => None,
                })
                .collect(),
            medium,
            scale,
        })
    }

    fn scaled(&self, list: &[f64]) -> Vec<f64> {
        list.iter().map(|&l| self.scale.length(l)).collect()
    }

    /// Poses of all bodies in units of the flow.
    fn poses(&self, placement: &Placement) -> Result<Vec<Isometry3<f64>>, ModelError> {
        let state = self.scale.state(placement.state);
        Ok(self.set.place(&state, &self.scaled(placement.lengths))?)
    }

    fn spheres(&self, placement: &Placement) -> Result<Spheres, ModelError> {
        let poses = self.poses(placement)?;
        let centres = poses
            .iter()
            .zip(self.set.kinds())
            .filter(|(_, kind)| **kind == BodyKind::Rigid)
            .map(|(pose, _)| pose.translation.vector)
            .collect();
        Ok(Spheres::new(centres, self.radii.clone())?)
    }

    fn constraints(&self, placement: &Placement) -> Result<Constraints, ModelError> {
        let state = self.scale.state(placement.state);
        let (lengths, rates) = (self.scaled(placement.lengths), self.scaled(placement.rates));
        Ok(self.set.constraints(&state, &lengths, &rates)?)
    }

    fn judged(&self, spheres: &Spheres) -> Result<Judged, ModelError> {
        let expansion = |tolerance: f64| -> Result<Resistance, ModelError> {
            Ok(multipole::resistance(
                spheres,
                &self.medium,
                &Accuracy::relative(tolerance),
            )?)
        };
        let mobility = match self.kind {
            SphereModel::Multipole(tolerance) => {
                let found = expansion(tolerance)?;
                return Ok(Judged {
                    unknowns: found.unknowns(),
                    factor: found.tail(),
                    other: found.coarser().clone(),
                    matrix: found.matrix().clone(),
                });
            }
            SphereModel::Oseen => oseen::mobility(spheres, &self.medium)?,
            SphereModel::Rpy => rpy::mobility(spheres, &self.medium)?,
        };
        let unknowns = mobility.nrows();
        let factor = mobility
            .cholesky()
            .ok_or(microhydro::HydroError::Indefinite {
                model: self.name(),
                instead: "model.kind = \"multipole\"",
            })?;
        Ok(Judged {
            matrix: factor.inverse(),
            other: expansion(JUDGE)?.matrix().clone(),
            factor: 1.0,
            unknowns,
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

    fn instant(&mut self, placement: &Placement<'_>) -> Result<Instant, ModelError> {
        let clock = Clock::now();
        let spheres = self.spheres(placement)?;
        let judged = self.judged(&spheres)?;
        let assembly = clock.elapsed().as_secs_f64();
        let constraints = self.constraints(placement)?;
        let solved = Solved::new(&judged.matrix, &self.set, &constraints, &self.loads)?;
        let other = Solved::new(&judged.other, &self.set, &constraints, &self.loads)?;
        let error = judged.factor * solved.fastest_difference(&other, &self.set);
        let total = clock.elapsed().as_secs_f64();
        Ok(Instant {
            bodies: solved.bodies(&self.set, &self.scale)?,
            link_forces: solved.link_forces(&self.set, &constraints, &self.loads, &self.scale)?,
            motion: self
                .scale
                .motion_back(&self.set.state_velocity(solved.generalised.as_slice())?),
            dofs: Dofs {
                total: judged.unknowns,
                ..Dofs::default()
            },
            solver: SolverInfo {
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
                model: Some(self.scale.velocity_back(Vector3::x() * error).x),
                ..ErrorEstimate::default()
            },
            mesh_error: None,
            checks: None,
            remeshed: None,
        })
    }

    fn resistance(&mut self, placement: &Placement<'_>) -> Result<DMatrix<f64>, ModelError> {
        let judged = self.judged(&self.spheres(placement)?)?;
        Ok(self.scale.resistance_back(judged.matrix))
    }

    fn cost(&mut self, placement: &Placement<'_>) -> Result<Cost, ModelError> {
        // there is nothing cheaper to know than the answer
        let instant = self.instant(placement)?;
        Ok(Cost {
            dofs: instant.dofs,
            seconds: instant.seconds.total,
            mib: 0.0,
        })
    }
}
