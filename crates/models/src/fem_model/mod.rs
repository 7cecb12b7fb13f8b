//! Finite elements in space: P2-P1 on a body-fitted mesh that follows the shape.

mod adapt;
mod answer;
mod far_field;
mod mesh_file;
mod mesher;
mod meshes;
mod options;
mod tube;

use std::time::Instant as Clock;

use mesh::TetMesh;
use nalgebra::{DMatrix, Isometry3};
use rigid::{Constrained, Constraints, Drive, Formulation};
use scene::{Domain, EstimatesKind, FemOptions, Scene};
use stokes::{Dofs, Estimate, InitialGuesses, Problem};

pub use self::mesher::{COARSEST_FACTOR, growth};
use self::meshes::{Meshes, ShapeMesh};
use self::options::options;
use crate::error::ModelError;
use crate::hydrodynamics::{Configuration, Cost, ErrorEstimates, History, Hydrodynamics, Query};
use crate::scaled::ScaledScene;
use crate::solution::{FlowField, InstantaneousSolution};

/// Taylor-Hood finite elements with curved surfaces, on meshes generated and moved as the shape asks.
pub struct FemModel {
    scaled: ScaledScene,
    meshes: Meshes,
    options: FemOptions,
    /// Solutions on the mesh in use. They are no part of the history: the first solves of a leg
    /// gained nothing from those of the leg before, because another link moves.
    guesses: InitialGuesses,
    last: Option<Last>,
}

/// The last answer, in units of the flow.
struct Last {
    mesh: TetMesh,
    poses: Vec<Isometry3<f64>>,
    flow: rigid::FlowSolution,
    /// Its errors, until they are used to adapt the mesh.
    estimate: Option<Estimate>,
}

/// Solutions that the next solve starts from: a leg has six Gauss points, and each takes 8 bytes an unknown.
const REMEMBERED: usize = 5;

/// Rounds of adapting: two or three reach a thousandth from the coarsest mesh, and one more each next digit.
const MOST_ADAPTATIONS: usize = 8;

/// Seconds a dof for assembly, set-up and solve to 1e-8 on two cores, from the three-sphere scene.
const SECONDS_PER_DOF: f64 = 4e-6;

/// Kibibytes a dof at the peak, from the three-sphere scene.
const KIB_PER_DOF: f64 = 1.2;

impl FemModel {
    /// The model of a scene; meshes are made when the first shape is asked for.
    ///
    /// # Errors
    /// A domain or an option that is not built yet.
    pub fn new(scene: &Scene) -> Result<Self, ModelError> {
        if let (Domain::Unbounded, Some(&body)) = (scene.domain(), scene.fixed_bodies().first()) {
            // Infinity would be answered by a uniform flow, which moves what is held.
            return Err(ModelError::Unsupported {
                what: format!(
                    "{}: finite elements in unbounded fluid around a fixed body",
                    scene.place(&format!("bodies[{body}].fixed"))
                ),
                instead: "use model.kind = \"multipole\" or domain.kind = \"ball\"".to_owned(),
            });
        }
        let scaled = ScaledScene::new(scene)?;
        Ok(Self {
            meshes: Meshes::new(scene, &scaled.scale)?,
            scaled,
            options: *scene.fem(),
            guesses: InitialGuesses::new(REMEMBERED),
            last: None,
        })
    }

    /// The configuration's mesh in units of the flow, with the poses of all bodies.
    fn shape_mesh(
        &mut self,
        configuration: Configuration,
    ) -> Result<(ShapeMesh, Vec<Isometry3<f64>>), ModelError> {
        let mut poses = self.scaled.poses(configuration)?;
        self.meshes.onto_mirrors(&mut poses);
        let shape = self.meshes.at(&poses)?;
        Ok((shape, poses))
    }

    /// The system of one configuration in scaled units, for solvers of one's own.
    ///
    /// # Errors
    /// As [`Hydrodynamics::solve`], up to the solve.
    pub fn system(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
        formulation: &dyn Formulation,
    ) -> Result<Constrained, ModelError> {
        let (ShapeMesh { mesh, .. }, poses) = self.shape_mesh(configuration)?;
        let constraints = self.scaled.constraints(configuration, rates)?;
        let drive = self.drive(&constraints);
        let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
        let problem = self.problem(&mesh, &poses)?.with_space(space);
        Ok(problem.assemble(&drive, formulation)?)
    }

    fn drive<'a>(&'a self, constraints: &'a Constraints) -> Drive<'a> {
        Drive {
            set: &self.scaled.set,
            constraints,
            loads: &self.scaled.loads,
        }
    }

    /// The problem on a mesh with the bodies at `poses`.
    fn problem<'m>(
        &self,
        mesh: &'m TetMesh,
        poses: &[Isometry3<f64>],
    ) -> Result<Problem<'m>, ModelError> {
        let centres: Vec<_> = (self.meshes.surfaced_bodies())
            .map(|body| poses[body].translation.vector)
            .collect();
        let bodies: Vec<_> = self.meshes.tags().zip(centres.iter().copied()).collect();
        let problem = Problem::new(mesh, &bodies, &self.meshes.wall_tags())?
            .with_spheres(&self.meshes.straight_spheres(&centres))?;
        Ok(match self.meshes.permeability(mesh, poses) {
            Some(permeability) => problem.with_permeability(permeability),
            None => problem,
        })
    }

    /// Meshes the last shape anew, so that both relative errors become at most `allowed`; false if meshes cannot be made here.
    fn adapt(&mut self, errors: [f64; 2], allowed: f64) -> Result<bool, ModelError> {
        let (Some(last), Some(space)) = (&mut self.last, self.meshes.surplus_space()) else {
            return Ok(false);
        };
        let Some(estimate) = last.estimate.take() else {
            return Ok(false);
        };
        let shares = estimate.indicators(space, &last.mesh)?;
        // Both count by how far they are off, and cells by their part in each.
        let mut of_cells = vec![0.0; last.mesh.n_cells()];
        for (shares, error) in shares.iter().zip(errors) {
            let sum: f64 = shares.iter().map(|share| share.abs()).sum();
            if sum > 0.0 {
                for (cell, share) in of_cells.iter_mut().zip(shares) {
                    *cell += error / allowed * share.abs() / sum;
                }
            }
        }
        let wanted = adapt::wanted_sizes(&last.mesh, &of_cells);
        self.meshes.adapt(&last.poses, wanted)
    }
}

impl FemModel {
    /// Solutions on the usual mesh: one mesh, one assembly and one preconditioner for all rates.
    fn solve_rates(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let clock = Clock::now();
        let configuration = query.configuration;
        if query.rates.is_empty() {
            return Ok(Vec::new());
        }
        let constraints: Vec<Constraints> = (query.rates.iter())
            .map(|rates| self.scaled.constraints(configuration, rates))
            .collect::<Result<_, _>>()?;
        if let Some(last) = &mut self.last {
            last.estimate = None;
        }
        let (shape, poses) = self.shape_mesh(configuration)?;
        let (mesh, mut remeshed) = (shape.mesh, shape.remeshed);
        let mesh_seconds = clock.elapsed().as_secs_f64();
        // Taken out while the rest of `self` is borrowed; lost if the solve fails.
        let mut guesses = std::mem::replace(&mut self.guesses, InitialGuesses::new(REMEMBERED));
        if shape.other_cells {
            // Solutions on another mesh have other degrees of freedom.
            guesses.clear();
        }
        let estimates = self.error_estimates().given(query.estimates);
        if estimates {
            self.meshes.prepare_estimates()?;
        }
        let drives: Vec<Drive> = constraints.iter().map(|c| self.drive(c)).collect();
        let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
        let surplus = self.meshes.surplus_space().filter(|_| estimates);
        let problem = self.problem(&mesh, &poses)?.with_space(space);
        let options = options(&self.options);
        let mut solved = problem.solve_all(&drives, &options, &mut guesses, surplus)?;
        self.guesses = guesses;
        let of_others: f64 = solved.iter().skip(1).map(|other| other.seconds.total).sum();
        if let Some(first) = solved.first_mut() {
            first.seconds.mesh = mesh_seconds;
            first.seconds.total = clock.elapsed().as_secs_f64() - of_others;
        }
        let mut solutions = Vec::with_capacity(solved.len());
        let mut last = None;
        for mut solved in solved {
            if let Some(far) = self.meshes.far_field() {
                self.add_taken(far, &mut solved.flow);
            }
            let mut solution = self.in_scene_units(&solved, remeshed.take(), &poses);
            if let Some(estimate) = &solved.estimate {
                self.enter_errors(&mut solution, estimate, &poses);
            }
            solutions.push(solution);
            last = Some((solved.flow, solved.estimate));
        }
        self.last = last.map(|(flow, estimate)| Last {
            mesh,
            poses,
            flow,
            estimate,
        });
        Ok(solutions)
    }
}

impl Hydrodynamics for FemModel {
    fn name(&self) -> &'static str {
        "fem"
    }

    fn error_estimates(&self) -> ErrorEstimates {
        match self.options.estimates {
            EstimatesKind::On => ErrorEstimates::OnRequest,
            EstimatesKind::Off => ErrorEstimates::Never,
        }
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let mut solutions = self.solve_rates(query)?;
        let Some(accuracy) = query.accuracy else {
            return Ok(solutions);
        };
        // Sizes that the scene gives are not changed.
        if self.options.size_factor.is_some() {
            return Ok(solutions);
        }
        for _ in 0..MOST_ADAPTATIONS {
            // The last solution is the one whose estimate adapts the mesh.
            let Some(solution) = solutions.last() else {
                break;
            };
            let errors = solution.relative_mesh_errors();
            if errors.iter().all(|own| *own <= accuracy) || !self.adapt(errors, accuracy)? {
                break;
            }
            solutions = self.solve_rates(query)?;
        }
        Ok(solutions)
    }

    fn resistance(&mut self, configuration: Configuration<'_>) -> Result<DMatrix<f64>, ModelError> {
        let (ShapeMesh { mesh, .. }, poses) = self.shape_mesh(configuration)?;
        let rtol = self.options.rtol;
        let grand = if mesh.symmetry_planes() == [false; 3] {
            let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
            self.problem(&mesh, &poses)?
                .with_space(space)
                .resistance(rtol)?
        } else {
            // A part between symmetry planes admits only motions that respect the symmetry.
            let mesh = mesh.unfolded()?.mesh;
            self.problem(&mesh, &poses)?.resistance(rtol)?
        };
        let resistance = match self.meshes.far_field() {
            Some(far) => far.corrected(grand.resistance)?,
            None => grand.resistance,
        };
        Ok(self.scaled.scale.resistance_back(resistance))
    }

    fn history(&self) -> Result<History, ModelError> {
        History::new(&self.meshes.reference_poses())
    }

    fn restore(&mut self, history: &History) -> Result<(), ModelError> {
        self.guesses.clear();
        self.meshes.restore(&history.contents::<Vec<_>>()?)
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError> {
        let (ShapeMesh { mesh, .. }, _) = self.shape_mesh(configuration)?;
        let on_boundary = {
            let walls = mesh
                .facets()
                .iter()
                .filter(|f| !mesh.is_symmetry_plane(f.tag));
            let mut nodes: Vec<u32> = walls.flat_map(|facet| facet.nodes).collect();
            nodes.sort_unstable();
            nodes.dedup();
            nodes.len()
        };
        let velocity = 3 * (mesh.n_points() - on_boundary);
        let dofs = Dofs {
            velocity,
            pressure: mesh.n_vertices(),
            total: velocity + mesh.n_vertices() + 6,
        };
        Ok(Cost {
            dofs,
            seconds: SECONDS_PER_DOF * dofs.total as f64,
            mib: KIB_PER_DOF * dofs.total as f64 / 1024.0,
        })
    }

    fn mesh(&mut self, configuration: Configuration<'_>) -> Result<Option<TetMesh>, ModelError> {
        let (ShapeMesh { mesh, .. }, _) = self.shape_mesh(configuration)?;
        Ok(Some(self.scaled.scale.mesh_back(&mesh)?.unfolded()?.mesh))
    }

    fn last_flow(&self) -> Option<FlowField> {
        let Last { mesh, flow, .. } = self.last.as_ref()?;
        let scale = &self.scaled.scale;
        // A part between mirror planes is shown as the whole that it stands for.
        let whole = scale.mesh_back(mesh).ok()?.unfolded().ok()?;
        let velocity = whole.sources.iter().map(|(node, signs)| {
            let own = flow.velocity[*node as usize];
            scale.velocity_back(own.component_mul(signs))
        });
        let of_vertices = whole.sources.iter().take(whole.mesh.n_vertices());
        let pressure = of_vertices.map(|(vertex, _)| flow.pressure[*vertex as usize]);
        Some(FlowField {
            velocity: velocity.collect(),
            pressure: pressure.map(|p| scale.pressure_back(p)).collect(),
            mesh: whole.mesh,
        })
    }
}
