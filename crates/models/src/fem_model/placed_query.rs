//! Queries with the meshes of their configurations, of which several can be solved concurrently.

use std::borrow::Cow;
use std::sync::Arc;
use std::time::Instant as Clock;

use fem::{SurplusSpace, TaylorHood};
use mesh::{NamedSurface, Surface, TetMesh};
use nalgebra::{Isometry3, Vector3};
use rayon::prelude::*;
use rigid::{Constraints, Drive, ExternalLoad};
use scene::rheology::{Law, ViscosityLaw};
use stokes::{Estimate, InitialGuesses, Options, Problem, Solution, SurfaceFlow};

use super::far_field::{self, FarField, FixedBodies};
use super::mesh_generator::{Placement, Surfaced};
use super::meshes::{Meshes, PlacedMesh};
use super::moving_frame::MovingFrame;
use super::scene_solution::{ScaledFlow, ToScene};
use super::{FemModel, MAX_GUESSES, MeshAt, law_in_space};
use crate::error::ModelError;
use crate::hydrodynamics::Hydrodynamics;
use crate::query::{Configuration, Query};
use crate::solution::InstantaneousSolution;
use crate::surface_motion::SurfaceMotion;

/// A query with all that its solution needs besides the model, in scaled units.
pub(super) struct PlacedQuery {
    pub placed: PlacedMesh,
    pub placement: Placement,
    time: f64,
    /// Function spaces on the mesh; none if a solve creates its own.
    space: Option<Arc<TaylorHood>>,
    /// Space for error estimates, if they are requested.
    surplus: Option<Arc<SurplusSpace>>,
    /// One entry per set of rates.
    pub constraints: Vec<Constraints>,
    /// Scaled rates of the amplitudes of deformations, one entry per set.
    amplitude_rates: Vec<Vec<f64>>,
    loads: Vec<ExternalLoad>,
    pub frame: Option<MovingFrame>,
    container_error: f64,
    /// Whether solutions carry their flow.
    flows: bool,
    /// Time to move or generate the mesh.
    seconds: f64,
}

/// A mesh with placed bodies, and the error estimate of the last solution on it until it is
/// used to adapt the mesh.
pub(super) struct Adaptable {
    pub mesh: Arc<TetMesh>,
    pub placement: Placement,
    pub estimate: Option<Estimate>,
}

/// The solutions for the rates of a query, and what the next mesh can be adapted to.
type Solved = (Vec<InstantaneousSolution>, Option<Adaptable>);

/// Largest number of degrees of freedom of a configuration that is solved together with others.
///
/// The solve of one small system leaves threads idle, those of several do not. Large systems use
/// all threads by themselves, and several would need several times the memory.
///
/// Above it, spaces are created for each assembly and freed before the solve: they take a tenth of
/// the memory of a corrected solution, and two percent of its time.
const MAX_DOFS: usize = 200_000;

/// Upper bound of the number of degrees of freedom on a mesh.
fn dofs(mesh: &TetMesh) -> usize {
    3 * mesh.n_points() + mesh.n_vertices()
}

impl PlacedQuery {
    /// Whether the cells of its mesh are other ones than those of the query before.
    pub fn has_other_cells(&self) -> bool {
        self.placed.has_other_cells
    }

    /// Upper bound of the number of degrees of freedom.
    pub fn dofs(&self) -> usize {
        dofs(&self.placed.mesh)
    }

    /// The problem with the space of the query, if it has one.
    pub fn with_space<'a>(&'a self, problem: Problem<'a>) -> Problem<'a> {
        match &self.space {
            Some(space) => problem.with_space(space),
            None => problem,
        }
    }
}

impl FemModel {
    /// Moves or generates the mesh for a query.
    ///
    /// # Errors
    /// Bodies around which no mesh can be generated; constraints that contradict each other.
    pub(super) fn place(&mut self, query: &Query<'_>) -> Result<PlacedQuery, ModelError> {
        self.place_by(query, Meshes::at)
    }

    /// As [`FemModel::place`], with the mesh by one of the ways to get it.
    ///
    /// # Errors
    /// Those of [`FemModel::place`].
    pub(super) fn place_by(
        &mut self,
        query: &Query<'_>,
        mesh_at: MeshAt,
    ) -> Result<PlacedQuery, ModelError> {
        let clock = Clock::now();
        if self.scaled.scene.inertia().is_kept() {
            return Err(ModelError::Unsupported {
                what: "Stokes flow of a fluid with inertia".to_owned(),
                instead: "set fluid.inertia = \"none\"".to_owned(),
            });
        }
        let frame = MovingFrame::new(&self.scaled.scene, query.configuration.state);
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
        for rates in query.rates {
            self.scaled.check_volume(configuration, rates)?;
        }
        let amplitude_rates = (query.rates.iter())
            .map(|rates| {
                let rates = self.scaled.values(rates);
                self.scaled.amplitudes().map(|joint| rates[joint]).collect()
            })
            .collect();
        let constraints = (query.rates.iter())
            .map(|rates| (self.scaled).query_constraints(&turned, rates))
            .collect::<Result<_, _>>()?;
        if let Some(last) = &mut self.last {
            last.estimate = None;
        }
        let (placed, placement) = self.mesh_by(configuration, mesh_at)?;
        let space = match self.scaled.law().is_some() || dofs(&placed.mesh) <= MAX_DOFS {
            true => Some(self.meshes.space()?),
            false => None,
        };
        let estimates = (self.capabilities().error_estimates).given(query.estimates);
        if estimates {
            self.meshes.prepare_estimates()?;
        }
        Ok(PlacedQuery {
            space,
            surplus: self.meshes.surplus_space().filter(|_| estimates),
            constraints,
            amplitude_rates,
            loads: self.scaled.loads(configuration, query.inertia)?,
            frame,
            container_error: self.meshes.container_error(&placement),
            flows: query.flows,
            placed,
            placement,
            time: configuration.time,
            seconds: clock.elapsed().as_secs_f64(),
        })
    }

    /// Solutions of independent queries: concurrently if they share cells, one by one otherwise.
    ///
    /// # Errors
    /// The first error of a query.
    pub(super) fn solve_independent(
        &mut self,
        queries: &[Query<'_>],
    ) -> Result<Vec<Vec<InstantaneousSolution>>, ModelError> {
        let (mut solved, mut group) = (Vec::new(), Vec::new());
        for query in queries {
            let query = self.place(query)?;
            let is_large = query.dofs() > MAX_DOFS;
            if query.has_other_cells() || is_large {
                solved.extend(self.solve_group(std::mem::take(&mut group))?);
            }
            group.push(query);
        }
        solved.extend(self.solve_group(group)?);
        Ok(solved)
    }

    /// Solutions of queries with the same cells, concurrently.
    ///
    /// All start from the same earlier solutions, so they do not depend on the number of threads.
    ///
    /// # Errors
    /// The first error of a query; initial guesses are discarded then.
    pub(super) fn solve_group(
        &mut self,
        mut group: Vec<PlacedQuery>,
    ) -> Result<Vec<Vec<InstantaneousSolution>>, ModelError> {
        let mut guesses = std::mem::replace(&mut self.guesses, InitialGuesses::new(MAX_GUESSES));
        if group.first().is_some_and(PlacedQuery::has_other_cells) {
            // Solutions on another mesh have other degrees of freedom.
            guesses.clear();
        }
        let mut solved = Vec::with_capacity(group.len());
        if group.len() > 1 {
            let solve = |query| {
                let mut guesses = guesses.clone();
                let solved = self.solve_placed(query, &mut guesses)?;
                Ok((solved, guesses))
            };
            let all: Vec<Result<_, ModelError>> = group.into_par_iter().map(solve).collect();
            for one in all {
                let ((solutions, last), of_query) = one?;
                guesses.remember_newest_of(of_query);
                self.last = last;
                solved.push(solutions);
            }
        } else if let Some(query) = group.pop() {
            let (solutions, last) = self.solve_placed(query, &mut guesses)?;
            self.last = last;
            solved.push(solutions);
        }
        self.guesses = guesses;
        Ok(solved)
    }

    /// Solutions of a query: one assembly and one preconditioner for all rates.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    fn solve_placed(
        &self,
        query: PlacedQuery,
        guesses: &mut InitialGuesses,
    ) -> Result<Solved, ModelError> {
        let clock = Clock::now();
        let (mut solved, motion) = self.flows(&query, &self.solver_options(), guesses)?;
        let PlacedQuery {
            placed,
            placement,
            time,
            frame,
            amplitude_rates,
            ..
        } = query;
        let (mesh, mut remeshed) = (placed.mesh, placed.remeshed);
        let of_others: f64 = solved.iter().skip(1).map(|other| other.seconds.total).sum();
        if let Some(first) = solved.first_mut() {
            first.seconds.mesh = query.seconds;
            first.seconds.total = query.seconds + clock.elapsed().as_secs_f64() - of_others;
        }
        let converter = ToScene {
            scaled: &self.scaled,
            time,
            far_field: self.meshes.far_field(),
            container_error: query.container_error,
        };
        let mut solutions = Vec::with_capacity(solved.len());
        let mut estimate = None;
        for (mut solved, rates) in solved.into_iter().zip(amplitude_rates) {
            let mut solution = converter.answer(&mut solved, &rates)?;
            solution.remeshed = remeshed.take();
            if let Some(frame) = &frame {
                solution.rotate(&frame.rotation());
            }
            if query.flows {
                let flow = ScaledFlow {
                    mesh: mesh.clone(),
                    flow: solved.flow,
                    motion: motion.clone(),
                    frame,
                    scale: self.scaled.scale,
                };
                solution.flow = Some(flow.into());
            }
            solutions.push(solution);
            estimate = solved.estimate;
        }
        let last = (!solutions.is_empty()).then_some(Adaptable {
            mesh,
            placement,
            estimate,
        });
        Ok((solutions, last))
    }

    /// Flows for the rates of a query in scaled units, and the motion of the surfaces.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    pub(super) fn flows(
        &self,
        query: &PlacedQuery,
        options: &Options,
        guesses: &mut InitialGuesses,
    ) -> Result<(Vec<Solution>, Option<SurfaceMotion>), ModelError> {
        let placement = &query.placement;
        let surfaces = self.meshes.boundary_surfaces(placement);
        let problem = self.problem(&query.placed.mesh, placement, &surfaces)?;
        let problem = query.with_space(problem);
        let centres = self.centres(placement);
        let to_laboratory = (query.frame).map(|frame| self.to_laboratory(frame));
        let motion = SurfaceMotion::new(&self.scaled, &placement.poses, &placement.values);
        let motion = motion.map(|motion| motion.in_frame(to_laboratory));
        // Surfaces that deform have the velocities of one set of rates: each has a right-hand side
        // of its own, and is solved by itself.
        let at_once = match self.scaled.scene.deforms() {
            true => 1,
            false => query.constraints.len().max(1),
        };
        let mut solved = Vec::with_capacity(query.constraints.len());
        let sets = query.constraints.chunks(at_once);
        for (constraints, rates) in sets.zip(query.amplitude_rates.chunks(at_once)) {
            let flows = motion.as_ref().map(|motion| BodyFlows {
                motion,
                rates: rates.first().map_or(&[][..], Vec::as_slice),
                surfaces: &surfaces,
                sources: self.meshes.generator.far_field,
                centres: &centres,
            });
            let mut problem = problem.clone();
            if let Some(flows) = &flows {
                problem = problem.with_surface_flow(flows);
            }
            solved.extend(self.flows_of_rates(query, &problem, constraints, options, guesses)?);
        }
        Ok((solved, motion))
    }

    /// Centres of the bodies with surfaces.
    fn centres(&self, placement: &Placement) -> Vec<Vector3<f64>> {
        let surfaced = self.meshes.generator.surfaced.iter();
        let centre = |s: &Surfaced| placement.poses[s.body].translation.vector;
        surfaced.map(centre).collect()
    }

    /// Flows for some rates of a query, for which the surfaces of the problem have the same
    /// velocities relative to the bodies.
    ///
    /// # Errors
    /// Those of [`Hydrodynamics::solve`].
    fn flows_of_rates(
        &self,
        query: &PlacedQuery,
        problem: &Problem<'_>,
        constraints: &[Constraints],
        options: &Options,
        guesses: &mut InitialGuesses,
    ) -> Result<Vec<Solution>, ModelError> {
        let has_fixed = self.scaled.set.held_translation().contains(&true);
        let law = self.law_in_domain(has_fixed)?;
        let mut constraints = Cow::Borrowed(constraints);
        if let (Some(far), true) = (self.meshes.far_field(), has_fixed) {
            let fixed = FixedBodies {
                problem,
                symmetry_planes: query.placed.mesh.symmetry_planes(),
                set: &self.scaled.set,
                loads: &query.loads,
                options,
            };
            let all = constraints.into_owned();
            constraints = Cow::Owned(far_field::in_moving_frame(&fixed, far, all, guesses)?);
        }
        let drive = |constraints| self.drive(constraints, &query.loads);
        let drives: Vec<Drive> = constraints.iter().map(drive).collect();
        let surplus = query.surplus.as_deref();
        Ok(match &law {
            None => problem.solve_all(&drives, options, guesses, surplus)?,
            Some(law) => {
                let solve = |drive| -> Result<Solution, ModelError> {
                    let flow = (problem)
                        .solve_generalised_newtonian(drive, law, options, guesses, surplus)?;
                    Ok(flow.solution)
                };
                drives.iter().map(solve).collect::<Result<_, _>>()?
            }
        })
    }

    /// The scaled viscosity law of the scene.
    ///
    /// # Errors
    /// [`ModelError::Unsupported`] in unbounded fluid for a law that is not Newtonian far away, and
    /// for held bodies, whose force a fluid at rest far away does not balance linearly; those of
    /// [`law_in_space`].
    fn law_in_domain(&self, has_fixed: bool) -> Result<Option<Law>, ModelError> {
        let law = law_in_space(&self.scaled)?;
        let at_rest = law.as_ref().map(|law| law.unregularised_viscosity(0.0));
        let is_newtonian_at_rest =
            at_rest.is_none_or(|viscosity| viscosity > 0.0 && viscosity.is_finite());
        let is_unbounded = self.meshes.far_field().is_some();
        if law.is_some() && is_unbounded && (has_fixed || !is_newtonian_at_rest) {
            let what = match has_fixed {
                true => "held bodies in unbounded fluid with a viscosity law",
                false => "unbounded fluid with a power law, which has no viscosity at rest",
            };
            return Err(ModelError::unsupported(
                format!("{}: {what}", self.scaled.scene.place("fluid.law")),
                "set domain.kind = \"ball\" with a large radius",
            ));
        }
        Ok(law)
    }

    /// The map from a moving frame to the laboratory, in scaled units.
    pub(super) fn to_laboratory(&self, frame: MovingFrame) -> Isometry3<f64> {
        frame.to_laboratory(self.scaled.scale.length(1.0))
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

    /// The problem on a mesh with placed bodies, in scaled units.
    ///
    /// `surfaces` are those of `Meshes::boundary_surfaces` in the same placement.
    pub(super) fn problem<'m>(
        &self,
        mesh: &'m TetMesh,
        placement: &Placement,
        surfaces: &'m [(&str, Box<dyn Surface>)],
    ) -> Result<Problem<'m>, ModelError> {
        let bodies: Vec<_> = (self.meshes.generator.tags())
            .zip(self.centres(placement))
            .collect();
        let surfaces: Vec<NamedSurface> = surfaces.iter().map(|(name, s)| (*name, &**s)).collect();
        let problem = Problem::new(mesh, &bodies, &self.meshes.generator.wall_tags())?
            .with_surfaces(&surfaces)?;
        Ok(match self.meshes.permeability(mesh, placement) {
            Some(permeability) => problem.with_permeability(permeability),
            None => problem,
        })
    }
}

/// The motion of surfaces with the surfaces that it is on.
struct BodyFlows<'a> {
    motion: &'a SurfaceMotion,
    /// Scaled rates of the amplitudes of deformations.
    rates: &'a [f64],
    /// Surfaces of the bodies; those of walls after them are not used.
    surfaces: &'a [(&'a str, Box<dyn Surface>)],
    /// The ball in place of unbounded fluid, through whose wall bodies that grow push fluid.
    sources: Option<FarField>,
    /// Centres of the bodies.
    centres: &'a [Vector3<f64>],
}

impl SurfaceFlow for BodyFlows<'_> {
    fn slip(&self, body: usize, x: &Vector3<f64>) -> Vector3<f64> {
        match self.surfaces.get(body) {
            Some((_, surface)) if self.motion.slip_of(body).is_some() => {
                self.motion.slip(body, &surface.normal(*x))
            }
            _ => Vector3::zeros(),
        }
    }

    fn rates(&self) -> &[f64] {
        self.rates
    }

    fn of_rate(&self, coordinate: usize, body: usize, x: &Vector3<f64>) -> Vector3<f64> {
        let joint = self.motion.amplitudes()[coordinate];
        let Some((_, surface)) =
            (self.surfaces.get(body)).filter(|_| self.motion.deforms(body, joint))
        else {
            return Vector3::zeros();
        };
        let arm = self.motion.on_surface(body, x, &**surface) - self.centres[body];
        self.motion.of_amplitude(body, &arm, joint)
    }

    fn volume_rate(&self, coordinate: usize, body: usize) -> f64 {
        let joint = self.motion.amplitudes()[coordinate];
        self.motion.volume_rate(body, joint)
    }

    fn at_wall(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let Some(far) = &self.sources else {
            return Vector3::zeros();
        };
        let of_body = |(body, centre): (usize, &Vector3<f64>)| {
            let rates = self.rates.iter().enumerate();
            let flux: f64 = rates
                .map(|(k, rate)| rate * self.volume_rate(k, body))
                .sum();
            if flux == 0.0 {
                return Vector3::zeros();
            }
            far.flow_of_source(flux, centre, x)
        };
        self.centres.iter().enumerate().map(of_body).sum()
    }

    fn background(&self, x: &Vector3<f64>) -> Vector3<f64> {
        self.motion.background(x)
    }

    fn background_pressure(&self, x: &Vector3<f64>) -> f64 {
        self.motion.background_pressure(x)
    }
}
