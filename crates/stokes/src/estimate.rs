//! Discretisation errors of velocities and forces, estimated by elements of the next degree.

use fem::{BoundaryFlow, FacetGeometry, SurfaceVelocity, Surplus};
use linalg::Preconditioner;
use nalgebra::{DVector, Vector3};
use rigid::{Drive, FlowSolution};

use crate::StokesError;
use crate::adjoint::{ADJOINT_RTOL, AdjointSolutions, DistinctLoads, UnitLoad};
use crate::cubic::{Change, Correction};
use crate::equations::Equations;
use crate::problem::Problem;
use crate::surface_flow::NodalSurfaceFlow;
use crate::surface_power::SurfacePowers;
use crate::viscous_stress::ViscousStress;

/// Relative uncertainty of the contribution of one cell, independent of that of other cells.
///
/// With it the corrected velocities of linked spheres, in which errors of the bodies cancel, are
/// within their bars in 29 of 30 random arrangements, and within 1.2 bars in all
/// (`docs/figures/random_cases.py`).
const CELL_UNCERTAINTY: f64 = 0.3;

/// Relative uncertainty of a correction that remains on fine meshes, from the accuracy to which the
/// system of cubic elements is solved.
const SOLVE_UNCERTAINTY: f64 = 0.015;

/// Relative uncertainty of a correction, divided by the relative error of the energy.
///
/// The part of the error that cubic elements do not resolve is of higher order: 4, 2.5 and 1.6
/// percent for spheres with edges of 0.5, 0.4 and 0.3 radii, 9 times the relative error of the
/// energy. The factor is half as large again, to cover drag, torque and mobility between bodies:
/// errors of 31 random arrangements are at most 0.6 bars.
const ENERGY_UNCERTAINTY: f64 = 14.0;

/// Relative uncertainty of the effect of the facets, which is of first order in their distance from
/// the surface.
///
/// With straight facets the effect is up to a quarter too small. With an uncertainty of a quarter
/// the bars of forces were 1.2 times the error at the median of 28 random arrangements, and 1.0
/// times at least (`docs/figures/random_cases.py`, seeds 401 to 500): 0.4 makes it twice the error.
const FACET_UNCERTAINTY: f64 = 0.4;

/// The same with slip or a background flow.
///
/// With an uncertainty of a half, errors of stresslets were up to 1.8 bars, of velocities up to 1.4
/// bars (random squirmers, seeds 601 to 620): the effect may have an error of its own size.
const FACET_UNCERTAINTY_IN_FLOW: f64 = 1.0;

/// The same of stresslets, of whose errors cubic elements resolve a fifth to a half.
///
/// With 1, three of six stresslets of squirmers with straight facets were outside of their bars, up
/// to 1.21 bars (`docs/figures/random_cases.py`, squirmers of the seeds 160001 to 160008).
const FACET_STRESSLET_UNCERTAINTY_IN_FLOW: f64 = 2.0;

/// The same of the power, whose errors were at most 0.4 bars with it.
const FACET_POWER_UNCERTAINTY_IN_FLOW: f64 = 0.5;

/// Relative uncertainty of the contribution of straight facets on walls.
///
/// The elements there are large: the measured effect is 0.3 to 0.9 of the estimate.
const WALL_UNCERTAINTY: f64 = 0.5;

/// Relative uncertainty of velocities and forces beside bodies whose volume changes, divided by the
/// relative error of the energy.
///
/// The flow of a source has the same flux through all cells at one distance. They conserve it
/// approximately, and cubic elements miss a part of this error, which has one sign: of the velocity
/// of a sphere at distances of 3 to 8 radii from one that grows they leave 3e-4 of 3e-4. That is
/// 0.03 to 0.1 times the relative error of the energy. Without it, errors of 11 random arrangements
/// were up to 2.7 bars, with 0.25 up to 1.3; with 0.4 one force of 23 other arrangements was 1.2
/// bars (`docs/figures/random_cases.py`, growths of the seeds 150101 to 150130 and 150201 to
/// 150230).
const SOURCE_UNCERTAINTY: f64 = 0.5;

/// Relative uncertainty of a correction in a fluid whose viscosity varies, divided by `sqrt(m e)`:
/// `m` is the mean of `|d log η / d log g|`, `e` the relative error of the energy.
///
/// A correction has all terms of second order in the error of the flow. Those of third order are
/// smaller by the relative error of the flow, which is `sqrt(e)`, where the viscosity depends on
/// the rates. Of the drag of a sphere, with the laws of Carreau and power laws of indices 0.3 to
/// 0.8, shear numbers of 1 and 10 and edges of 0.6 to 0.2 radii, a factor of 1.7 and the
/// uncertainty of constant viscosity cover what corrections leave.
const VISCOSITY_UNCERTAINTY: f64 = 2.0;

/// Estimated discretisation error of one solution, in scaled units.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// Change of the flow that removes the error: exact minus computed.
    pub change: FlowSolution,
    /// Changes of the powers of slip and deformation that remove their errors.
    pub powers: SurfacePowers,
    /// Uncertainty of the linear velocities of the frames: the contributions of the cells are
    /// independent, so their squares are summed.
    pub uncertainty: f64,
    /// Relative uncertainty of every part of the change.
    pub relative_uncertainty: f64,
    /// Uncertainty of the power because parts of its change may cancel: effects of straight facets
    /// and of elements, or of a viscosity that varies.
    pub power_uncertainty: f64,
    /// Uncertainty of the effect of straight facets on stresslets.
    pub stresslet_uncertainty: f64,
    /// Uncertainty of velocities and forces relative to the largest ones, because volumes of bodies
    /// change; zero if they do not.
    pub source_uncertainty: f64,
    /// Contribution of each cell to the energy of the error.
    energy_indicators: Vec<f64>,
    /// Contribution of each cell to `uncertainty`.
    frame_indicators: Vec<f64>,
    /// Cell of each straight facet, and its contribution to the geometry error of the energy.
    facet_indicators: Vec<(usize, f64)>,
}

impl Estimate {
    /// Error indicators for mesh refinement: of `K(e, e)` and of the uncertainty, one per cell.
    pub fn indicators(self) -> [Vec<f64>; 2] {
        let mut indicators = self.energy_indicators;
        for (cell, indicator) in self.facet_indicators {
            indicators[cell] = indicators[cell].abs() + indicator.abs();
        }
        [indicators, self.frame_indicators]
    }
}

/// Estimator of the discretisation errors of flows that were solved with one matrix.
pub struct Estimator<'a> {
    /// The problem that was solved.
    pub problem: &'a Problem<'a>,
    /// Velocities of surfaces, if they do not move rigidly.
    pub surfaces: Option<(&'a NodalSurfaceFlow, &'a SurfaceVelocity<'a>)>,
    /// The equations that were solved.
    pub equations: Equations<'a>,
    /// Straight facets on curved boundaries; empty where facets are curved.
    pub facet_geometry: &'a FacetGeometry<'a>,
    /// Bodies, joints and loads; the rates of the joints are not used.
    pub drive: &'a Drive<'a>,
    /// Relative residual to which systems are solved, if not as the uncertainty requires.
    pub rtol: Option<f64>,
}

/// Indicators of the discretisation error of one flow.
struct Indicators<'f> {
    velocity: &'f [Vector3<f64>],
    surplus: Surplus,
    /// Contribution of each facet to the geometry error of the energy.
    of_facets: Vec<f64>,
    relative_uncertainty: f64,
    /// Part of it because the viscosity varies.
    of_viscosity: f64,
    /// Part of the correction that Newton's method leaves.
    left: f64,
    power_uncertainty: f64,
    source_uncertainty: f64,
}

/// Flow of a unit load, with its surplus.
struct Response {
    velocity: Vec<Vector3<f64>>,
    surplus: Surplus,
}

impl Estimator<'_> {
    /// Indicators of a flow, of whose correction at least the part `left` is uncertain.
    fn indicators<'f>(
        &self,
        flow: &'f FlowSolution,
        left: f64,
    ) -> Result<Indicators<'f>, StokesError> {
        let (velocity, equations) = (&flow.velocity, &self.equations);
        let surplus = equations.surplus_of_flow(flow)?;
        let of_flow = self.boundary_flow(velocity);
        let of_facets = self.facet_geometry.indicators(of_flow, of_flow)?;
        let energy = equations.space.energy(&surplus, &surplus)?;
        let geometry = of_facets.iter().sum::<f64>();
        let surfaces = self.surfaces.map(|(nodal, _)| nodal);
        let of_surfaces = (self.problem).power_of_surfaces(flow, surfaces, self.stress())?;
        let power = (flow.forces.dot(&flow.bodies) + of_surfaces) / self.problem.parts();
        let uncertain_geometry = self.facet_uncertainty(FACET_UNCERTAINTY_IN_FLOW) * geometry.abs();
        let relative_energy = (energy / power).abs();
        let of_viscosity = self.viscosity_uncertainty(relative_energy)?;
        let uncertain = (SOLVE_UNCERTAINTY + ENERGY_UNCERTAINTY * relative_energy + of_viscosity)
            * energy.abs()
            + uncertain_geometry;
        let source_uncertainty = match surfaces {
            Some(nodal) if nodal.has_sources => SOURCE_UNCERTAINTY * relative_energy,
            _ => 0.0,
        };
        // Bodies at rest have neither power nor error.
        let ratio = uncertain / (energy - geometry).abs();
        let relative_uncertainty = if ratio.is_finite() {
            // Where the viscosity varies, cubic elements may leave more than they remove.
            let largest = if self.stress().is_some() { 2.0 } else { 1.0 };
            ratio.min(largest).max(left)
        } else {
            left
        };
        let of_facets_on_power =
            self.facet_uncertainty(FACET_POWER_UNCERTAINTY_IN_FLOW) * geometry.abs();
        // Where the viscosity varies the power is not the energy: its correction has parts of both
        // signs, each of the size of that of the energy.
        let of_viscosity_on_power = match self.stress() {
            Some(_) => relative_uncertainty * energy.abs(),
            None => 0.0,
        };
        Ok(Indicators {
            velocity,
            surplus,
            of_facets,
            relative_uncertainty,
            of_viscosity,
            left,
            power_uncertainty: self.problem.parts() * of_facets_on_power.max(of_viscosity_on_power),
            source_uncertainty,
        })
    }

    /// The stress of the flow, if its viscosity varies.
    fn stress(&self) -> Option<ViscousStress<'_>> {
        self.equations.varying.map(|flow| flow.stress)
    }

    /// Relative uncertainty of a correction because the viscosity varies, by the relative error of
    /// the energy.
    fn viscosity_uncertainty(&self, energy: f64) -> Result<f64, StokesError> {
        (self.stress()).map_or(Ok(0.0), |stress| {
            Ok(VISCOSITY_UNCERTAINTY * (stress.mean_exponent()? * energy).sqrt())
        })
    }

    /// Relative uncertainty of an effect of straight facets, which is this one with slip or a
    /// background flow.
    fn facet_uncertainty(&self, in_flow: f64) -> f64 {
        match self.surfaces {
            None => FACET_UNCERTAINTY,
            Some(_) => in_flow,
        }
    }

    fn boundary_flow<'f>(&'f self, velocity: &'f [Vector3<f64>]) -> BoundaryFlow<'f> {
        BoundaryFlow {
            velocity,
            surface_velocity: self.surfaces.map(|(_, velocity)| velocity),
        }
    }

    /// One unit load per linkage that may move, along the velocity that it has in a flow.
    fn unit_loads(&self, flow: &FlowSolution) -> Vec<UnitLoad> {
        let set = self.drive.set;
        let numbered = set.linkages().iter().enumerate();
        numbered
            // A linkage whose root is held has no error of its velocity.
            .filter(|(_, linkage)| !set.held_translation()[linkage.root])
            .map(|(number, _)| {
                let row = frame_row(self.drive, number);
                UnitLoad::along(flow.generalised.fixed_rows::<3>(row).into(), row)
            })
            .collect()
    }

    fn rhs_of_unit_load(&self, unit_load: &UnitLoad) -> Result<Vec<f64>, StokesError> {
        let mut load = DVector::zeros(self.drive.set.velocity_layout().len());
        load.fixed_rows_mut::<3>(unit_load.row)
            .copy_from(&unit_load.direction);
        Ok(self.equations.system.rhs_of_loads(&load)?)
    }

    /// Flow and surplus of a unit load, from its adjoint solution.
    fn response(&self, adjoint: &[f64]) -> Result<Response, StokesError> {
        let equations = &self.equations;
        let (velocity, pressure) = equations.system.flow_of_loads(adjoint)?;
        let surplus = equations.surplus_of_change(&velocity, &pressure)?;
        let velocity = equations.of_all_nodes(velocity)?;
        Ok(Response { velocity, surplus })
    }

    /// The estimate of one flow, with its uncertainty from the responses to its unit loads.
    ///
    /// `of_facets` is the largest effect of straight facets on a stresslet.
    fn estimate(
        &self,
        error: Indicators,
        (change, powers, of_facets): (FlowSolution, SurfacePowers, f64),
        responses: &[&Response],
    ) -> Result<Estimate, StokesError> {
        let (parts, equations) = (self.problem.parts(), &self.equations);
        let indicators = |of: &Surplus| {
            let of_part = (equations.space).indicators(equations.mesh, of, &error.surplus)?;
            equations.of_all_cells(of_part)
        };
        let mut frame_indicators = vec![0.0; self.problem.mesh.n_cells()];
        // Images of a cell have the same error. Of bodies that deform and keep their volume the
        // velocities consist of parts that cancel, for which the sum of all images counts: of a
        // spheroid that a mode does not move the error was 1.05 bars without it. Of other flows
        // the root of the sum of squares is what random arrangements were compared with.
        let of_images = match self.surfaces {
            Some((nodal, _)) if nodal.deforms && !nodal.has_sources => parts,
            _ => parts.sqrt(),
        };
        // Effects of straight facets on velocities, which may cancel those of elements: the
        // relative uncertainty of the correction has no part for that.
        let (mut of_walls, mut of_bodies) = (0.0_f64, 0.0_f64);
        let of_body_facets = match self.surfaces {
            Some(_) => FACET_UNCERTAINTY_IN_FLOW * parts,
            None => 0.0,
        };
        for response in responses {
            let mut cells = indicators(&response.surplus)?;
            let of_facets = self
                .facet_geometry
                .indicators(&response.velocity, self.boundary_flow(error.velocity))?;
            let (mut wall_sum, mut body_sum) = (0.0, 0.0);
            let facets = self
                .facet_geometry
                .cells()
                .zip(self.facet_geometry.is_wall());
            for ((cell, is_wall), indicator) in facets.zip(of_facets) {
                cells[cell] = cells[cell].hypot(indicator);
                match is_wall {
                    true => wall_sum += indicator,
                    false => body_sum += indicator,
                }
            }
            of_walls = (WALL_UNCERTAINTY * parts * wall_sum).hypot(of_walls);
            of_bodies = (of_body_facets * body_sum).hypot(of_bodies);
            for (sum, cell) in frame_indicators.iter_mut().zip(cells) {
                *sum = (of_images * cell).hypot(*sum);
            }
        }
        let of_cells = frame_indicators
            .iter()
            .map(|cell| cell * cell)
            .sum::<f64>()
            .sqrt();
        let of_one_cell = (CELL_UNCERTAINTY + error.of_viscosity)
            .min(1.0)
            .max(error.left);
        let cells = self.facet_geometry.cells();
        Ok(Estimate {
            change,
            powers,
            uncertainty: (of_one_cell * of_cells).hypot(of_walls).hypot(of_bodies),
            relative_uncertainty: error.relative_uncertainty,
            power_uncertainty: error.power_uncertainty,
            stresslet_uncertainty: self.facet_uncertainty(FACET_STRESSLET_UNCERTAINTY_IN_FLOW)
                * of_facets,
            source_uncertainty: error.source_uncertainty,
            energy_indicators: indicators(&error.surplus)?,
            frame_indicators,
            facet_indicators: cells.zip(error.of_facets).collect(),
        })
    }

    /// Estimates the errors of each of several flows.
    ///
    /// Cost per flow: that of its correction ([`Correction::changes`]), and one solve to
    /// [`ADJOINT_RTOL`] per linkage for the uncertainty, which flows along the same line share.
    ///
    /// [`ADJOINT_RTOL`]: crate::adjoint::ADJOINT_RTOL
    ///
    /// # Errors
    /// Solves that do not converge.
    pub fn estimates(
        &self,
        flows: &[FlowSolution],
        preconditioner: &mut dyn Preconditioner,
        adjoints: &mut AdjointSolutions,
    ) -> Result<Vec<Estimate>, StokesError> {
        let correction = Correction::new(
            self.problem.mesh,
            self.equations,
            self.facet_geometry,
            self.drive.set,
            self.surfaces,
            self.rtol,
        )?;
        let changes = correction.changes(flows, &mut *preconditioner)?;
        let change_of_powers = |flow: &FlowSolution, change: &Change| {
            let Some((nodal, _)) = self.surfaces else {
                return Ok(SurfacePowers::default());
            };
            let problem = self.problem;
            let mut powers = problem.corrected_surface_powers(&correction, flow, change, nodal)?;
            let computed = problem.surface_powers(flow, Some(nodal), self.stress())?;
            powers.accumulate(-1.0, &computed);
            Ok::<_, StokesError>(powers)
        };
        let mut unit_loads = DistinctLoads::default();
        let loads_of_flows: Vec<Vec<usize>> = flows
            .iter()
            .map(|flow| {
                let loads = self.unit_loads(flow).into_iter();
                loads.map(|load| unit_loads.position(load)).collect()
            })
            .collect();
        let rhs = unit_loads.0.iter().map(|load| self.rhs_of_unit_load(load));
        let rhs: Vec<_> = rhs.collect::<Result<_, _>>()?;
        let rtol = self.rtol.unwrap_or(ADJOINT_RTOL);
        adjoints.solve(self.equations.operator, preconditioner, &rhs, rtol)?;
        let responses = adjoints.0.iter();
        let responses: Vec<Response> = responses
            .map(|adjoint| self.response(adjoint))
            .collect::<Result<_, _>>()?;
        (flows.iter().zip(changes).zip(loads_of_flows))
            .map(|((flow, change), loads)| {
                let responses: Vec<_> = loads.into_iter().map(|load| &responses[load]).collect();
                let powers = change_of_powers(flow, &change)?;
                let indicators = self.indicators(flow, left_by_newton(change.reduction))?;
                let mut change = change.flow;
                let mut of_facets = 0.0_f64;
                let bodies = self.problem.bodies.iter();
                for (stresslet, (tag, _)) in change.stresslets.iter_mut().zip(bodies) {
                    let of_flow = self.boundary_flow(&flow.velocity);
                    let part = self.facet_geometry.stresslet(*tag, of_flow)?;
                    let part = self.problem.symmetry().whole_tensor(&part);
                    of_facets = of_facets.max(part.norm());
                    *stresslet += part;
                }
                self.estimate(indicators, (change, powers, of_facets), &responses)
            })
            .collect()
    }
}

/// What two steps of Newton's method with one matrix leave of a correction at least: nothing that
/// the other parts do not contain where the second step is smaller than the first, else the
/// correction times the squared ratio of both.
fn left_by_newton(reduction: f64) -> f64 {
    match reduction < 1.0 {
        true => 0.0,
        false => reduction * reduction,
    }
}

/// First row of the linear part of a frame's generalised velocities.
fn frame_row(drive: &Drive, linkage_number: usize) -> usize {
    let linkage = &drive.set.linkages()[linkage_number];
    drive.set.velocity_layout().bodies()[linkage.root]
}
