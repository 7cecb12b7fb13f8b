//! Finite elements: P2-P1 on a body-fitted mesh that follows the shape.

mod adapt;
mod answer;
mod checks;
mod estimate;
mod far_field;
mod mesh_file;
mod mesher;
mod meshes;
mod solve;
mod tube;

use std::time::Instant as Clock;

use fem::TaylorHood;
use linalg::WarmStart;
use mesh::TetMesh;
use nalgebra::{DMatrix, Isometry3};
use rigid::{Constrained, Constraints, Drive, Formulation, State};

use self::estimate::{AdjointSolutions, Estimate};
pub use self::mesher::{COARSEST_FACTOR, growth};
use self::meshes::{Meshes, ShapeMesh};
use self::solve::Boundary;
use crate::model::scaled::ScaledScene;
use crate::model::{Cost, Dofs, Flow, Hydrodynamics, Instant, ModelError, Placement};
use scene::{Domain, EstimatesKind, FemOptions, Scene};

/// Taylor-Hood finite elements with curved surfaces, on meshes generated and moved as the shape asks.
pub struct FemModel {
    scaled: ScaledScene,
    meshes: Meshes,
    options: FemOptions,
    estimates: bool,
    adjoint_solutions: AdjointSolutions,
    /// Solutions of the leg on the mesh in use. Forgotten between legs, where checkpoints are taken, so that these need not carry them: the
    /// first solves of a leg gained nothing from them, for another link moves.
    warm: WarmStart,
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
        if let (Domain::Unbounded, Some(&body)) = (&scene.domain, scene.fixed_bodies().first()) {
            // Infinity would be answered by a uniform flow, which moves what is held.
            return Err(ModelError::NotBuilt {
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
            options: scene.fem,
            estimates: scene.fem.estimates == EstimatesKind::On,
            adjoint_solutions: AdjointSolutions::default(),
            warm: WarmStart::new(REMEMBERED),
            last: None,
        })
    }

    /// The placement's mesh in units of the flow, with the poses of all bodies.
    fn shape_mesh(
        &mut self,
        placement: &Placement,
    ) -> Result<(ShapeMesh, Vec<Isometry3<f64>>), ModelError> {
        let mut poses = self.scaled.poses(placement)?;
        self.meshes.onto_mirrors(&mut poses);
        let shape = self.meshes.at(&poses)?;
        Ok((shape, poses))
    }

    /// The system of one placement in units of the flow, for solvers of one's own.
    ///
    /// # Errors
    /// As [`Hydrodynamics::instant`], up to the solve.
    pub fn system(
        &mut self,
        placement: &Placement<'_>,
        formulation: &dyn Formulation,
    ) -> Result<Constrained, ModelError> {
        let (ShapeMesh { mesh, .. }, poses) = self.shape_mesh(placement)?;
        let constraints = self.scaled.constraints(placement)?;
        let drive = self.drive(&constraints);
        let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
        solve::assemble(
            space,
            &mesh,
            &self.boundary(&mesh, &poses),
            &drive,
            formulation,
        )
    }

    fn drive<'a>(&'a self, constraints: &'a Constraints) -> Drive<'a> {
        Drive {
            set: &self.scaled.set,
            constraints,
            loads: &self.scaled.loads,
        }
    }

    fn boundary(&self, mesh: &TetMesh, poses: &[Isometry3<f64>]) -> Boundary<'_> {
        let surfaced = self.meshes.surfaced_bodies();
        let centres: Vec<_> = surfaced
            .map(|body| poses[body].translation.vector)
            .collect();
        Boundary {
            bodies: self.meshes.tags().collect(),
            chords: self.meshes.chords(&centres),
            centres,
            walls: self.meshes.wall_tags(),
            permeability: self.meshes.permeability(mesh, poses),
        }
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

impl Hydrodynamics for FemModel {
    fn name(&self) -> &'static str {
        "fem"
    }

    fn want_estimates(&mut self, wanted: bool) -> bool {
        self.estimates = wanted && self.options.estimates == EstimatesKind::On;
        self.estimates
    }

    fn begin_leg(&mut self) {
        self.warm.clear();
        self.adjoint_solutions = AdjointSolutions::default();
    }

    fn instant(&mut self, placement: &Placement<'_>) -> Result<Instant, ModelError> {
        let rates = [placement.rates.to_vec()];
        let mut answers = self.instants(placement.state, placement.lengths, &rates)?;
        answers.pop().ok_or(ModelError::NoMesh)
    }

    /// One mesh, one assembly and one preconditioner for all rates.
    fn instants(
        &mut self,
        state: &State,
        lengths: &[f64],
        rates: &[Vec<f64>],
    ) -> Result<Vec<Instant>, ModelError> {
        let clock = Clock::now();
        let placements = Placement::at_rates(state, lengths, rates);
        let Some(first) = placements.clone().next() else {
            return Ok(Vec::new());
        };
        let constraints: Vec<Constraints> = placements
            .map(|placement| self.scaled.constraints(&placement))
            .collect::<Result<_, _>>()?;
        if let Some(last) = &mut self.last {
            last.estimate = None;
        }
        let (shape, poses) = self.shape_mesh(&first)?;
        let (mesh, mut remeshed) = (shape.mesh, shape.remeshed);
        // taken out while the rest of `self` is borrowed, and lost if the solve fails
        let mut adjoint_solutions = std::mem::take(&mut self.adjoint_solutions);
        let mesh_seconds = clock.elapsed().as_secs_f64();
        let mut warm = std::mem::replace(&mut self.warm, WarmStart::new(REMEMBERED));
        if shape.other_cells {
            // solutions on another mesh have other unknowns
            adjoint_solutions = AdjointSolutions::default();
            warm.clear();
        }
        if self.estimates {
            self.meshes.prepare_estimates()?;
        }
        let drives: Vec<Drive> = constraints.iter().map(|c| self.drive(c)).collect();
        let boundary = self.boundary(&mesh, &poses);
        let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
        let mut solved = solve::solve(
            space,
            &mesh,
            &boundary,
            &drives,
            &self.options,
            &mut warm,
            self.meshes
                .surplus_space()
                .filter(|_| self.estimates)
                .map(|surplus| (surplus, &mut adjoint_solutions)),
        )?;
        self.warm = warm;
        self.adjoint_solutions = adjoint_solutions;
        let of_others: f64 = solved.iter().skip(1).map(|other| other.seconds.total).sum();
        if let Some(first) = solved.first_mut() {
            first.seconds.mesh = mesh_seconds;
            first.seconds.total = clock.elapsed().as_secs_f64() - of_others;
        }
        let mut answers = Vec::with_capacity(solved.len());
        let mut last = None;
        for mut solved in solved {
            if let Some(far) = self.meshes.far_field() {
                self.add_taken(far, &mut solved.flow);
            }
            let mut instant = self.in_scene_units(&solved, remeshed.take(), &poses);
            if let Some(estimate) = &solved.estimate {
                self.enter_errors(&mut instant, estimate, &poses);
            }
            answers.push(instant);
            last = Some((solved.flow, solved.estimate));
        }
        self.last = last.map(|(flow, estimate)| Last {
            mesh,
            poses,
            flow,
            estimate,
        });
        Ok(answers)
    }

    fn instant_within(
        &mut self,
        placement: &Placement<'_>,
        error: f64,
    ) -> Result<Instant, ModelError> {
        self.want_estimates(true);
        let mut instant = self.instant(placement)?;
        if self.options.size_factor.is_some() {
            return Ok(instant);
        }
        for _ in 0..MOST_ADAPTATIONS {
            let errors = instant.relative_mesh_errors();
            if errors.iter().all(|own| *own <= error) || !self.adapt(errors, error)? {
                break;
            }
            instant = self.instant(placement)?;
        }
        Ok(instant)
    }

    fn resistance(&mut self, placement: &Placement<'_>) -> Result<DMatrix<f64>, ModelError> {
        let (ShapeMesh { mesh, .. }, poses) = self.shape_mesh(placement)?;
        let rtol = self.options.rtol;
        let grand = if mesh.symmetry_planes() == [false; 3] {
            let boundary = self.boundary(&mesh, &poses);
            let space = self.meshes.space().ok_or(ModelError::NoMesh)?;
            solve::resistance(space, &mesh, &boundary, rtol)?
        } else {
            // Parts between mirror planes answer for motions along them only.
            let mesh = mesh.unfolded()?.mesh;
            let boundary = self.boundary(&mesh, &poses);
            solve::resistance(&TaylorHood::new(&mesh)?, &mesh, &boundary, rtol)?
        };
        let resistance = match self.meshes.far_field() {
            Some(far) => far.corrected(grand.resistance)?,
            None => grand.resistance,
        };
        Ok(self.scaled.scale.resistance_back(resistance))
    }

    fn history(&self) -> Vec<Isometry3<f64>> {
        self.meshes.reference_poses()
    }

    fn restore(&mut self, history: &[Isometry3<f64>]) -> Result<(), ModelError> {
        self.meshes.restore(history)
    }

    fn cost(&mut self, placement: &Placement<'_>) -> Result<Cost, ModelError> {
        let (ShapeMesh { mesh, .. }, _) = self.shape_mesh(placement)?;
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

    fn mesh(&mut self, placement: &Placement<'_>) -> Result<Option<TetMesh>, ModelError> {
        let (ShapeMesh { mesh, .. }, _) = self.shape_mesh(placement)?;
        Ok(Some(self.scaled.scale.mesh_back(&mesh)?.unfolded()?.mesh))
    }

    fn flow(&self) -> Option<Flow> {
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
        Some(Flow {
            velocity: velocity.collect(),
            pressure: pressure.map(|p| scale.pressure_back(p)).collect(),
            mesh: whole.mesh,
        })
    }
}
