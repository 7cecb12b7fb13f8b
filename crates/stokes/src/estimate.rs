//! Discretisation errors of velocities and forces, estimated by adjoint solutions.
//!
//! Let `q_k` be a velocity of the bodies and `z` the flow of the unit load that is conjugate to it,
//! with the links at constant length. The discretisation error of `q_k` is
//!
//! ```text
//! q_h,k - q_k = -K(e_z, e)
//! ```
//!
//! with the discretisation errors `e_z` and `e` of both flows ([`fem::SurplusSpace`]). This is
//! linear in `z`, so a single solve with the functional `K(·, e)` as its load
//! ([`fem::ErrorFunctional`]) gives the errors of all velocities. Errors that equal bodies have in
//! common cancel in it, as they do in the velocities. The bound `√(K(e_z, e_z) K(e, e))` is forty
//! times too large for a three-sphere swimmer.
//!
//! Straight facets of curved boundaries cause an error of the opposite sign, which is a functional
//! `G` of the flow too ([`fem::FacetGeometry`]). Where there are straight facets, `K - G` replaces
//! `K` throughout.

use fem::{FacetGeometry, Surplus, SurplusSpace};
use linalg::BlockTriangular;
use mesh::TetMesh;
use nalgebra::{DVector, Vector3};
use rigid::{BodyKind, Constrained, Drive, FlowSolution, SymmetryPlanes, Twist};

use crate::StokesError;
use crate::adjoint::{AdjointSolutions, DistinctLoads, UnitLoad};

/// Relative uncertainty of the contribution of one cell, independent of that of other cells.
///
/// A choice, not a bound: estimated speeds of three-sphere swimmers have smaller errors, but on one
/// leg of the default stroke the estimate is wrong by three times its uncertainty.
const CELL_UNCERTAINTY: f64 = 0.5;

/// Relative uncertainty of the contribution of straight facets on walls.
///
/// The elements there are large: the measured effect is 0.3 to 0.9 of the estimate.
const WALL_UNCERTAINTY: f64 = 0.5;

/// Estimated discretisation errors of one solution, computed minus exact, in scaled units.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Error of the frame velocity of each linkage.
    pub frames: Vec<Twist>,
    /// Uncertainty of the linear part of `frames`.
    pub uncertainty: f64,
    /// `K(e, e) / power`, or `(K(e, e) - G(u, u)) / power` where facets are straight.
    ///
    /// With the power of the bodies, this is the relative error of their forces.
    pub relative_energy: f64,
    /// Hierarchical surplus of the flow.
    surplus: Surplus,
    /// Contribution of each cell to `uncertainty`.
    frame_indicators: Vec<f64>,
    /// Cell of each straight facet, and the contribution of the facet to `G(u, u)`.
    facet_indicators: Vec<(usize, f64)>,
}

impl Estimate {
    /// Error indicators for mesh refinement: of `K(e, e)` and of the uncertainty, one per cell.
    ///
    /// Cost: one pass over the cells.
    ///
    /// # Errors
    /// A mesh other than the one on which the errors were estimated.
    pub fn indicators(
        self,
        space: &SurplusSpace,
        mesh: &TetMesh,
    ) -> Result<[Vec<f64>; 2], StokesError> {
        let mut indicators = space.indicators(mesh, &self.surplus, &self.surplus)?;
        for (cell, indicator) in self.facet_indicators {
            indicators[cell] = indicators[cell].abs() + indicator.abs();
        }
        Ok([indicators, self.frame_indicators])
    }
}

/// Estimator of the discretisation errors of flows that were solved with one matrix.
pub struct Estimator<'a> {
    /// Mesh of the solution.
    pub mesh: &'a TetMesh,
    /// Hierarchical surplus space of the mesh.
    pub space: &'a SurplusSpace,
    /// Straight facets on curved boundaries; empty where facets are curved.
    pub facet_geometry: &'a FacetGeometry<'a>,
    /// Bodies, links and loads; the rates of the links are not used.
    pub drive: &'a Drive<'a>,
    /// The system that was solved.
    pub system: &'a Constrained,
}

/// Discretisation error of one flow.
struct DiscretisationError<'f> {
    velocity: &'f [Vector3<f64>],
    surplus: Surplus,
    /// Contribution of each straight facet to `G(u, u)`.
    facet_indicators: Vec<f64>,
    relative_energy: f64,
}

/// Flow of a unit load, with its surplus.
struct Response {
    velocity: Vec<Vector3<f64>>,
    surplus: Surplus,
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
        let facet_indicators = self
            .facet_geometry
            .indicators(&flow.velocity, &flow.velocity)?;
        let energy = surplus.energy(&surplus)? - facet_indicators.iter().sum::<f64>();
        let relative_energy = match self.parts() * energy / power {
            ratio if ratio.is_finite() => ratio,
            // Bodies at rest have neither power nor error.
            _ => 0.0,
        };
        Ok(DiscretisationError {
            velocity: &flow.velocity,
            surplus,
            facet_indicators,
            relative_energy,
        })
    }

    /// Number of images of each cell, itself included, under the reflections at symmetry planes.
    fn parts(&self) -> f64 {
        SymmetryPlanes {
            planes: self.mesh.symmetry_planes(),
        }
        .parts()
    }

    /// Right-hand side whose solution gives the errors of all velocities of a flow.
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

    /// One unit load per linkage that may move, along the velocity that it has in a flow.
    fn unit_loads(&self, flow: &FlowSolution) -> Vec<UnitLoad> {
        let set = self.drive.set;
        let numbered = set.linkages().iter().enumerate();
        numbered
            // A linkage that is fixed in space has no error.
            .filter(|(_, linkage)| !set.fixed()[linkage.root])
            .map(|(number, _)| {
                let (row, _) = frame_rows(self.drive, number);
                UnitLoad::along(flow.generalised.fixed_rows::<3>(row).into(), row)
            })
            .collect()
    }

    fn rhs_of_unit_load(&self, unit_load: &UnitLoad) -> Result<Vec<f64>, StokesError> {
        let mut load = DVector::zeros(self.drive.set.velocity_layout().len());
        load.fixed_rows_mut::<3>(unit_load.row)
            .copy_from(&unit_load.direction);
        Ok(self.system.rhs_of_loads(&load)?)
    }

    /// Estimated errors of the frame velocities, from the adjoint solution for the errors.
    fn frame_errors(&self, adjoint: &[f64]) -> Result<Vec<Twist>, StokesError> {
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

    /// Flow and surplus of a unit load, from its adjoint solution.
    fn response(&self, adjoint: &[f64]) -> Result<Response, StokesError> {
        let (velocity, pressure) = self.system.flow_of_loads(adjoint)?;
        let surplus = self.space.surplus(self.mesh, &velocity, &pressure)?;
        Ok(Response { velocity, surplus })
    }

    /// The estimate of one flow, with its uncertainty from the responses to its unit loads.
    fn estimate(
        &self,
        error: DiscretisationError,
        frames: Vec<Twist>,
        responses: &[&Response],
    ) -> Result<Estimate, StokesError> {
        let parts = self.parts();
        let mut frame_indicators = vec![0.0; self.mesh.n_cells()];
        let mut of_walls = 0.0_f64;
        for response in responses {
            let mut cells = self
                .space
                .indicators(self.mesh, &response.surplus, &error.surplus)?;
            let of_facets = self
                .facet_geometry
                .indicators(&response.velocity, error.velocity)?;
            let mut wall_sum = 0.0;
            let facets = self
                .facet_geometry
                .cells()
                .zip(self.facet_geometry.is_wall());
            for ((cell, is_wall), indicator) in facets.zip(of_facets) {
                cells[cell] = cells[cell].hypot(indicator);
                wall_sum += if is_wall { indicator } else { 0.0 };
            }
            of_walls = (WALL_UNCERTAINTY * parts * wall_sum).hypot(of_walls);
            for (sum, cell) in frame_indicators.iter_mut().zip(cells) {
                // Root of the sum of squares over the images of the cell.
                *sum = (parts.sqrt() * cell).hypot(*sum);
            }
        }
        let of_cells = frame_indicators
            .iter()
            .map(|cell| cell * cell)
            .sum::<f64>()
            .sqrt();
        let cells = self.facet_geometry.cells();
        Ok(Estimate {
            frames,
            uncertainty: (CELL_UNCERTAINTY * of_cells).hypot(of_walls),
            relative_energy: error.relative_energy,
            surplus: error.surplus,
            frame_indicators,
            facet_indicators: cells.zip(error.facet_indicators).collect(),
        })
    }

    /// Estimates the errors of each of several flows.
    ///
    /// Cost per flow: up to six passes over the cells, one solve to [`ADJOINT_RTOL`] for the errors
    /// of all velocities, and one per linkage for the uncertainty, which flows along the same line
    /// share. All systems are solved together.
    ///
    /// [`ADJOINT_RTOL`]: crate::adjoint::ADJOINT_RTOL
    ///
    /// # Errors
    /// Adjoint solves that do not converge.
    pub fn estimates(
        &self,
        flows: &[FlowSolution],
        preconditioner: &mut BlockTriangular,
        adjoints: &mut AdjointSolutions,
    ) -> Result<Vec<Estimate>, StokesError> {
        let errors = flows.iter().map(|flow| self.discretisation_error(flow));
        let errors: Vec<DiscretisationError> = errors.collect::<Result<_, _>>()?;
        let mut unit_loads = DistinctLoads::default();
        let loads_of_flows: Vec<Vec<usize>> = flows
            .iter()
            .map(|flow| {
                let loads = self.unit_loads(flow).into_iter();
                loads.map(|load| unit_loads.position(load)).collect()
            })
            .collect();
        let rhs = errors.iter().map(|error| self.rhs_of_errors(error));
        let error_rhs: Vec<_> = rhs.collect::<Result<_, _>>()?;
        let rhs = unit_loads.0.iter().map(|load| self.rhs_of_unit_load(load));
        let load_rhs: Vec<_> = rhs.collect::<Result<_, _>>()?;
        adjoints.solve(&self.system.system, preconditioner, &error_rhs, &load_rhs)?;
        let responses = adjoints.unit_loads.iter();
        let responses: Vec<Response> = responses
            .map(|adjoint| self.response(adjoint))
            .collect::<Result<_, _>>()?;
        (errors.into_iter().zip(&adjoints.errors).zip(loads_of_flows))
            .map(|((error, adjoint), loads)| {
                let responses: Vec<_> = loads.into_iter().map(|load| &responses[load]).collect();
                self.estimate(error, self.frame_errors(adjoint)?, &responses)
            })
            .collect()
    }
}

/// First rows of a frame's generalised velocities: linear, and angular if the frame rotates.
fn frame_rows(drive: &Drive, linkage_number: usize) -> (usize, Option<usize>) {
    let linkage = &drive.set.linkages()[linkage_number];
    let layout = drive.set.velocity_layout();
    let linear = layout.bodies()[linkage.root];
    let angular = layout.frame(linkage_number).or_else(|| {
        // A single body is its own frame; arms with directions fixed in space do not rotate.
        let is_single = linkage.bodies.len() == 1;
        (is_single && drive.set.kinds()[linkage.root] == BodyKind::Rigid).then_some(linear + 3)
    });
    (linear, angular)
}
