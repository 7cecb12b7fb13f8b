//! Errors of an instant by the mesh, from one flow more with the same matrix, and of several instants of one shape at once.
//!
//! A velocity $q_k$ answers to its own load: with the flow `z` of a unit load on it, links held, its error by the mesh is
//! $q_{h,k} - q_k = -K(e_z, e)$ (`fem::SurplusSpace`). That is linear in `z`, so one solve with the functional as its load
//! (`fem::ErrorFunctional`) gives the errors of all velocities. Errors common to equal bodies cancel in it as they do in the
//! velocities; the bound $\sqrt{K(e_z, e_z) K(e, e)}$ would be forty times too wide for a three-sphere swimmer.
//!
//! Straight facets cut off what they stand for, which errs the other way and is a functional of the flow too (`fem::FacetGeometry`): with
//! them $K$ is $K - G$ throughout.

use fem::{FacetGeometry, Surplus, SurplusSpace};
use linalg::{BlockTriangular, KrylovParams, SaddleSystem};
use mesh::TetMesh;
use nalgebra::{DVector, Vector3};
use rigid::{BodyKind, Constrained, Drive, FlowSolution, SymmetryPlanes, Twist};

use crate::StokesError;
use crate::linear::in_groups;

/// Estimated errors of one instant, in units of the flow, computed less exact.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Of each linkage's frame velocity.
    pub frames: Vec<Twist>,
    /// What the linear part of `frames` may err by itself.
    pub uncertainty: f64,
    /// $K(e, e)$, less `G` where facets are straight, over the power of the bodies: the relative error of their forces, computed less exact.
    pub relative_energy: f64,
    /// What the flow lacks on its mesh, and each cell's share in the spread.
    surplus: Surplus,
    of_frames: Vec<f64>,
    /// Each cell's share in $G(u, u)$.
    of_facets: Vec<(usize, f64)>,
}

impl Estimate {
    /// Each cell's share in $K(e, e)$, and in the spread: what to refine.
    ///
    /// Cost: a pass over the cells.
    /// # Errors
    /// Another mesh than the one that was estimated on.
    pub fn indicators(
        self,
        space: &SurplusSpace,
        mesh: &TetMesh,
    ) -> Result<[Vec<f64>; 2], StokesError> {
        let mut indicators = space.indicators(mesh, &self.surplus, &self.surplus)?;
        for (cell, indicator) in self.of_facets {
            indicators[cell] = indicators[cell].abs() + indicator.abs();
        }
        Ok([indicators, self.of_frames])
    }
}

/// Residual at which the flows of estimates are good enough, relative: against 1e-6 the estimated error of the default stroke's net
/// displacement changes by 0.2 percent, with 3e-3 by one.
const ADJOINT_RTOL: f64 = 1e-3;

/// A cell's share in an estimate is trusted to half of itself, independently of the others'. A choice, not a bound: estimated speeds of
/// three-sphere swimmers miss by less, but one leg of the default stroke misses by three times its spread.
const CELL_TRUST: f64 = 0.5;

/// What straight walls take is trusted to half of it: their elements are long, and measured effects of them 0.3 to 0.9 of the estimate.
const WALL_TRUST: f64 = 0.5;

/// Flows of the last estimates, where those of the next start; of other lengths they are not used.
#[derive(Default)]
pub struct AdjointSolutions {
    /// For the errors of velocities, one a flow that was estimated.
    errors: Vec<Vec<f64>>,
    /// For their spreads, one a load.
    uncertainties: Vec<Vec<f64>>,
}

impl AdjointSolutions {
    /// Solves for the flows of estimates, each from that of the instant before, several a pass.
    fn solve(
        &mut self,
        system: &SaddleSystem,
        preconditioner: &mut BlockTriangular,
        errors: &[Vec<f64>],
        uncertainties: &[Vec<f64>],
    ) -> Result<(), StokesError> {
        let parameters = KrylovParams::default().with_rel_tol(ADJOINT_RTOL);
        self.errors.resize(errors.len(), Vec::new());
        self.uncertainties.resize(uncertainties.len(), Vec::new());
        let flows = self.errors.iter_mut().chain(&mut self.uncertainties);
        let (rhs, mut flows): (Vec<&[f64]>, Vec<&mut [f64]>) = errors
            .iter()
            .chain(uncertainties)
            .zip(flows)
            .map(|(rhs, flow)| {
                if flow.len() != rhs.len() {
                    *flow = vec![0.0; rhs.len()];
                }
                (rhs.as_slice(), flow.as_mut_slice())
            })
            .unzip();
        in_groups(system, preconditioner, &rhs, &mut flows, &parameters)?;
        Ok(())
    }
}

/// What the errors of solved flows are estimated from.
pub struct Estimator<'a> {
    /// Mesh of the instant.
    pub mesh: &'a TetMesh,
    /// What its cells lack.
    pub space: &'a SurplusSpace,
    /// What its facets cut off; none where they are curved.
    pub facet_geometry: &'a FacetGeometry<'a>,
    /// What drove it, whatever the rates.
    pub drive: &'a Drive<'a>,
    /// Its system.
    pub system: &'a Constrained,
}

/// What a flow lacks on its mesh.
struct DiscretisationError<'f> {
    velocity: &'f [Vector3<f64>],
    surplus: Surplus,
    /// Each facet's share in $G(u, u)$.
    of_facets: Vec<f64>,
    relative_energy: f64,
}

/// A unit load on a linkage, for the spread of its velocity in the direction of motion.
struct UnitLoad {
    /// Where the linear velocities of its frame begin.
    row: usize,
    direction: Vector3<f64>,
}

impl UnitLoad {
    /// Whether the flow of one will do for the other: it is solved to no more digits.
    fn is_like(&self, other: &Self) -> bool {
        self.row == other.row && (self.direction - other.direction).norm() <= ADJOINT_RTOL
    }
}

impl Estimator<'_> {
    fn discretisation_error<'f>(
        &self,
        flow: &'f FlowSolution,
    ) -> Result<DiscretisationError<'f>, StokesError> {
        let surplus = self
            .space
            .surplus(self.mesh, &flow.velocity, &flow.pressure)?;
        let power = flow.forces.dot(&flow.bodies);
        let of_facets = self
            .facet_geometry
            .indicators(&flow.velocity, &flow.velocity)?;
        let energy = surplus.energy(&surplus)? - of_facets.iter().sum::<f64>();
        let relative_energy = match self.parts() * energy / power {
            ratio if ratio.is_finite() => ratio,
            // Nothing moves, nothing errs.
            _ => 0.0,
        };
        Ok(DiscretisationError {
            velocity: &flow.velocity,
            surplus,
            of_facets,
            relative_energy,
        })
    }

    /// Between mirror planes each cell stands for its images too.
    fn parts(&self) -> f64 {
        SymmetryPlanes {
            planes: self.mesh.symmetry_planes(),
        }
        .parts()
    }

    /// The load whose flow gives the errors of all velocities.
    fn rhs_of_errors(&self, error: &DiscretisationError) -> Result<Vec<f64>, StokesError> {
        let mut functional = self.space.functional(self.mesh, &error.surplus)?;
        let of_facets = self.facet_geometry.functional(error.velocity)?;
        for (value, of_facets) in functional.velocity.iter_mut().zip(of_facets) {
            *value -= of_facets;
        }
        Ok(self
            .system
            .rhs_of_forces(&functional.velocity, &functional.pressure)?)
    }

    /// The loads for the spreads of a flow's velocities, one a linkage.
    fn unit_loads(&self, flow: &FlowSolution) -> Vec<UnitLoad> {
        let set = self.drive.set;
        let numbered = set.linkages().iter().enumerate();
        numbered
            // Held still exactly: nothing to err.
            .filter(|(_, linkage)| !set.fixed()[linkage.root])
            .map(|(number, _)| {
                // The spread is that of the velocity in the direction of motion; bodies at rest may drift along x.
                let (row, _) = frame_rows(self.drive, number);
                let motion: Vector3<f64> = flow.generalised.fixed_rows::<3>(row).into();
                let direction = motion.try_normalize(0.0).unwrap_or_else(Vector3::x);
                // Forth or back is one spread, and one flow to start the next from.
                let sign = direction[direction.iamax()].signum();
                UnitLoad {
                    row,
                    direction: sign * direction,
                }
            })
            .collect()
    }

    fn rhs_of_unit_load(&self, unit_load: &UnitLoad) -> Result<Vec<f64>, StokesError> {
        let mut load = DVector::zeros(self.drive.set.velocity_layout().len());
        load.fixed_rows_mut::<3>(unit_load.row)
            .copy_from(&unit_load.direction);
        Ok(self.system.rhs_of_loads(&load)?)
    }

    /// Estimated errors of the frames' velocities.
    fn frames(&self, adjoint: &[f64]) -> Result<Vec<Twist>, StokesError> {
        let errors = -self.system.generalised_of_loads(adjoint)?;
        let rows = |first: usize| -> Vector3<f64> { errors.fixed_rows::<3>(first).into() };
        Ok((0..self.drive.set.linkages().len())
            .map(|number| {
                let (linear, angular) = frame_rows(self.drive, number);
                Twist {
                    linear: rows(linear),
                    angular: angular.map_or_else(Vector3::zeros, rows),
                }
            })
            .collect())
    }

    /// The velocity of a pull's flow and what it lacks.
    fn response(&self, adjoint: &[f64]) -> Result<(Vec<Vector3<f64>>, Surplus), StokesError> {
        let (velocity, pressure) = self.system.flow_of_loads(adjoint)?;
        let surplus = self.space.surplus(self.mesh, &velocity, &pressure)?;
        Ok((velocity, surplus))
    }

    /// The estimate of a flow from what it lacks, its errors, and the flows of its pulls.
    fn estimate(
        &self,
        error: DiscretisationError,
        frames: Vec<Twist>,
        responses: &[&(Vec<Vector3<f64>>, Surplus)],
    ) -> Result<Estimate, StokesError> {
        let parts = self.parts();
        let mut of_frames = vec![0.0; self.mesh.n_cells()];
        let mut unsure = 0.0_f64;
        for (its_velocity, its) in responses {
            let mut cells = self.space.indicators(self.mesh, its, &error.surplus)?;
            let of_facets = self
                .facet_geometry
                .indicators(its_velocity, error.velocity)?;
            let mut by_walls = 0.0;
            let facets = self
                .facet_geometry
                .cells()
                .zip(self.facet_geometry.is_wall());
            for ((cell, is_wall), indicator) in facets.zip(of_facets) {
                cells[cell] = cells[cell].hypot(indicator);
                by_walls += if is_wall { indicator } else { 0.0 };
            }
            unsure = (WALL_TRUST * parts * by_walls).hypot(unsure);
            for (sum, cell) in of_frames.iter_mut().zip(cells) {
                // the root of the sum over its images
                *sum = (parts.sqrt() * cell).hypot(*sum);
            }
        }
        let by_cells = of_frames.iter().map(|cell| cell * cell).sum::<f64>().sqrt();
        Ok(Estimate {
            frames,
            uncertainty: (CELL_TRUST * by_cells).hypot(unsure),
            relative_energy: error.relative_energy,
            surplus: error.surplus,
            of_frames,
            of_facets: self.facet_geometry.cells().zip(error.of_facets).collect(),
        })
    }

    /// Estimates the errors of each of several solved flows.
    ///
    /// Cost: up to six passes over the cells a flow, a loose solve for the errors of all its velocities, and one a linkage for their spread, which flows that move
    /// along one line share; all of them at once.
    /// # Errors
    /// Flows that cannot be solved for.
    pub fn estimates(
        &self,
        flows: &[FlowSolution],
        preconditioner: &mut BlockTriangular,
        adjoints: &mut AdjointSolutions,
    ) -> Result<Vec<Estimate>, StokesError> {
        let discretisation_errors = flows.iter().map(|flow| self.discretisation_error(flow));
        let discretisation_errors: Vec<DiscretisationError> =
            discretisation_errors.collect::<Result<_, _>>()?;
        // one flow for all pulls that are alike
        let mut unit_loads: Vec<UnitLoad> = Vec::new();
        let mut number_of = |unit_load: UnitLoad| {
            let known = unit_loads
                .iter()
                .position(|known| known.is_like(&unit_load));
            known.unwrap_or_else(|| {
                unit_loads.push(unit_load);
                unit_loads.len() - 1
            })
        };
        let unit_loads_of: Vec<Vec<usize>> = flows
            .iter()
            .map(|flow| {
                self.unit_loads(flow)
                    .into_iter()
                    .map(&mut number_of)
                    .collect()
            })
            .collect();
        let rhs = discretisation_errors
            .iter()
            .map(|error| self.rhs_of_errors(error));
        let errors: Vec<_> = rhs.collect::<Result<_, _>>()?;
        let rhs = unit_loads
            .iter()
            .map(|unit_load| self.rhs_of_unit_load(unit_load));
        let uncertainties: Vec<_> = rhs.collect::<Result<_, _>>()?;
        adjoints.solve(&self.system.system, preconditioner, &errors, &uncertainties)?;
        let responses = adjoints
            .uncertainties
            .iter()
            .map(|adjoint| self.response(adjoint));
        let responses: Vec<_> = responses.collect::<Result<_, _>>()?;
        (discretisation_errors
            .into_iter()
            .zip(&adjoints.errors)
            .zip(unit_loads_of))
        .map(|((error, adjoint), numbers)| {
            let responses: Vec<_> = numbers
                .into_iter()
                .map(|number| &responses[number])
                .collect();
            self.estimate(error, self.frames(adjoint)?, &responses)
        })
        .collect()
    }
}

/// Where the generalised velocities of a linkage's frame begin: linear ones, and angular ones if it turns.
fn frame_rows(drive: &Drive, number: usize) -> (usize, Option<usize>) {
    let linkage = &drive.set.linkages()[number];
    let layout = drive.set.velocity_layout();
    let linear = layout.body(linkage.root);
    let angular = layout.frame(number).or_else(|| {
        // A body alone is its own frame; arms in the laboratory's directions do not turn.
        let alone = linkage.bodies.len() == 1;
        (alone && drive.set.kinds()[linkage.root] == BodyKind::Rigid).then_some(linear + 3)
    });
    (linear, angular)
}
