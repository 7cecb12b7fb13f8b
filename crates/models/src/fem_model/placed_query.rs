//! One query with the mesh of its configuration; several can be solved concurrently.

use std::sync::Arc;
use std::time::Instant as Clock;

use fem::{SurplusSpace, TaylorHood};
use mesh::{NamedSurface, Surface, TetMesh};
use nalgebra::Isometry3;
use rigid::{Constraints, Drive, ExternalLoad};
use stokes::{InitialGuesses, Problem};

use super::FemModel;
use super::body_flows::BodyFlows;
use super::far_field;
use super::last_solution::Last;
use super::meshes::PlacedMesh;
use super::moving_frame::MovingFrame;
use super::scene_solution::ToScene;
use crate::error::ModelError;
use crate::hydrodynamics::{Configuration, Hydrodynamics, Query};
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceMotion;

/// A query with all that its solution needs besides the model, in scaled units.
pub(super) struct PlacedQuery {
    placed: PlacedMesh,
    poses: Vec<Isometry3<f64>>,
    space: Arc<TaylorHood>,
    /// Space for error estimates, if they are requested.
    surplus: Option<Arc<SurplusSpace>>,
    /// One entry per set of rates.
    constraints: Vec<Constraints>,
    loads: Vec<ExternalLoad>,
    frame: Option<MovingFrame>,
    container_error: f64,
    /// Time to move or generate the mesh.
    seconds: f64,
}

impl PlacedQuery {
    /// Whether the cells of its mesh are other ones than those of the query before.
    pub fn has_other_cells(&self) -> bool {
        self.placed.has_other_cells
    }

    /// Upper bound of the number of degrees of freedom.
    pub fn dofs(&self) -> usize {
        3 * self.placed.mesh.n_points() + self.placed.mesh.n_vertices()
    }
}

impl FemModel {
    /// Moves or generates the mesh for a query.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated; constraints that contradict each other.
    pub(super) fn place(&mut self, query: &Query<'_>) -> Result<PlacedQuery, ModelError> {
        let clock = Clock::now();
        let frame = MovingFrame::of(&self.scaled.scene, query.configuration.state);
        let state = frame.map(|frame| frame.state(query.configuration.state));
        let configuration = Configuration {
            state: state.as_ref().unwrap_or(query.configuration.state),
            ..query.configuration
        };
        if let Some(frame) = &frame {
            self.scaled.turn_loads(&frame.rotation().inverse());
        }
        let turned = Query {
            configuration,
            ..*query
        };
        let constraints = (query.rates.iter())
            .map(|rates| (self.scaled).query_constraints(&turned, rates))
            .collect::<Result<_, _>>()?;
        for last in self.last.iter_mut().flatten() {
            last.estimate = None;
        }
        let (placed, poses) = self.placed_mesh(configuration)?;
        let estimates = self.error_estimates().given(query.estimates);
        if estimates {
            self.meshes.prepare_estimates()?;
        }
        Ok(PlacedQuery {
            space: self.meshes.space().ok_or(ModelError::NoMesh)?,
            surplus: self.meshes.surplus_space().filter(|_| estimates),
            constraints,
            loads: self.scaled.loads(configuration, query.inertia)?,
            frame,
            container_error: self.meshes.container_error(&poses),
            placed,
            poses,
            seconds: clock.elapsed().as_secs_f64(),
        })
    }

    /// Solutions of a query: one assembly and one preconditioner for all rates.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    pub(super) fn solve_placed(
        &self,
        query: PlacedQuery,
        guesses: &mut InitialGuesses,
    ) -> Result<(Vec<InstantaneousSolution>, Option<Last>), ModelError> {
        let clock = Clock::now();
        let PlacedQuery {
            placed,
            poses,
            mut constraints,
            frame,
            ..
        } = query;
        let (mesh, mut remeshed) = (placed.mesh, placed.remeshed);
        let surfaces = self.meshes.boundary_surfaces(&poses);
        let mut problem = (self.problem(&mesh, &poses, &surfaces)?).with_space(&query.space);
        let to_laboratory = frame.map(|frame| frame.to_laboratory(self.scaled.scale.length(1.0)));
        let flows = SurfaceMotion::new(&self.scaled, &poses).map(|motion| BodyFlows {
            motion: motion.in_frame(to_laboratory),
            surfaces: &surfaces,
        });
        if let Some(flows) = &flows {
            problem = problem.with_surface_flow(flows);
        }
        let options = self.solver_options();
        let has_fixed = self.scaled.set.fixed().contains(&true);
        if let (Some(far), true) = (self.meshes.far_field(), has_fixed) {
            constraints = far_field::in_moving_frame(
                &problem,
                mesh.symmetry_planes(),
                (&self.scaled, &query.loads),
                far,
                constraints,
                &options,
                guesses,
            )?;
        }
        let drive = |constraints| self.drive(constraints, &query.loads);
        let drives: Vec<Drive> = constraints.iter().map(drive).collect();
        let surplus = query.surplus.as_deref();
        let mut solved = problem.solve_all(&drives, &options, guesses, surplus)?;
        let of_others: f64 = solved.iter().skip(1).map(|other| other.seconds.total).sum();
        if let Some(first) = solved.first_mut() {
            first.seconds.mesh = query.seconds;
            first.seconds.total = query.seconds + clock.elapsed().as_secs_f64() - of_others;
        }
        let mut solutions = Vec::with_capacity(solved.len());
        let mut last = None;
        let converter = ToScene {
            scaled: &self.scaled,
            surfaced: self.meshes.surfaced_bodies().collect(),
            far_field: self.meshes.far_field(),
            container_error: query.container_error,
        };
        for mut solved in solved {
            let mut solution = converter.answer(&mut solved)?;
            solution.remeshed = remeshed.take();
            if let Some(frame) = &frame {
                solution.rotate(&frame.rotation());
            }
            solutions.push(solution);
            last = Some((solved.flow, solved.estimate));
        }
        let last = last.map(|(flow, estimate)| Last {
            mesh,
            poses,
            motion: flows.map(|flows| flows.motion),
            frame,
            flow,
            estimate,
        });
        Ok((solutions, last))
    }

    pub(super) fn drive<'a>(
        &'a self,
        constraints: &'a Constraints,
        loads: &'a [ExternalLoad],
    ) -> Drive<'a> {
        Drive {
            set: &self.scaled.set,
            constraints,
            loads,
        }
    }

    /// The problem on a mesh with the bodies at `poses`, in scaled units.
    ///
    /// `surfaces` are those of `Meshes::boundary_surfaces` at the same poses.
    pub(super) fn problem<'m>(
        &self,
        mesh: &'m TetMesh,
        poses: &[Isometry3<f64>],
        surfaces: &'m [(&str, Box<dyn Surface>)],
    ) -> Result<Problem<'m>, ModelError> {
        let centres: Vec<_> = (self.meshes.surfaced_bodies())
            .map(|body| poses[body].translation.vector)
            .collect();
        let bodies: Vec<_> = self.meshes.tags().zip(centres.iter().copied()).collect();
        let surfaces: Vec<NamedSurface> = surfaces.iter().map(|(name, s)| (*name, &**s)).collect();
        let problem =
            Problem::new(mesh, &bodies, &self.meshes.wall_tags())?.with_surfaces(&surfaces)?;
        Ok(match self.meshes.permeability(mesh, poses) {
            Some(permeability) => problem.with_permeability(permeability),
            None => problem,
        })
    }
}
