//! Solutions of a model, interpolated over a box of shapes.

use nalgebra::DMatrix;
use rigid::{Joint, State, Twist};

use super::chebyshev::Interpolant;
use super::placement::Placement;
use super::record::{Layout, Record, Scales, scales};
use super::sampler::{MAX_DEGREE, Sampler, longest_arm};
use super::solved_shapes::{Bars, SolvedShapes, TablePart};
use crate::discretisation_error::{DiscretisationError, Uncertainty};
use crate::error::ModelError;
use crate::hydrodynamics::Hydrodynamics;
use crate::query::Configuration;
use crate::solution::{ErrorEstimate, InstantaneousSolution};
use scene::Scene;
use stokes::{Dofs, SolverReport};

/// An interpolation error that a finer grid does not reduce is attributed to noise of the model if
/// it is at most this factor times the error bar of the model.
const NOISE: f64 = 10.0;

/// Degree of the first grid in each variable.
const FIRST_DEGREE: usize = 4;

/// Maximum number of grid points: degree 8 in four variables has 6561, degree 4 in five 3125.
///
/// Larger tables take longer than they save.
const MAX_POINTS: usize = 7000;

/// Solutions of a model for a free swimmer, interpolated over a box of values of its joints.
///
/// The swimmer has the attitude of the start of the scene; [`ShapeSpace::solution`] rotates the
/// solution to other attitudes.
#[derive(Clone, Debug)]
pub struct ShapeSpace {
    start: State,
    /// Smallest and largest value of each joint.
    ranges: Vec<(f64, f64)>,
    /// Joints whose value varies in the box.
    variables: Vec<usize>,
    /// Numbers of one [`Record`] per variable, for a unit rate of it.
    records: Interpolant,
    layout: Layout,
    dofs: Dofs,
    solver: SolverReport,
    points: usize,
    /// Interpolation error of velocities for a unit rate.
    interpolation_error: f64,
    /// Interpolation error relative to the largest velocity and the largest force.
    relative_error: f64,
    /// Whether the next grid would have been too large.
    is_coarse: bool,
    bars: Bars,
    /// Longest distance of two joined bodies, by which errors of velocities and forces become those
    /// of angular velocities and torques.
    longest: f64,
    /// Change of velocities for a unit rate by the motion of the swimmer in its container.
    position_error: f64,
}

impl ShapeSpace {
    /// Tabulates velocities and forces of a model to the relative error `tolerance`.
    ///
    /// The model is sampled at Chebyshev points of the box `ranges`, the smallest and largest
    /// value of each joint. A range of width zero keeps the value constant. Grids are refined
    /// until the interpolation error is below the tolerance or below the error bar of the mesh,
    /// which changes from shape to shape, or until other noise of the model prevents a further
    /// decrease.
    ///
    /// In a container the mean of the bodies is at its place at the start for all shapes. The
    /// change of the velocities by the motion of the swimmer in its container is an error bar,
    /// [`ShapeSpace::position_error`].
    ///
    /// Cost: 5, 9, 17, ... points in each variable, with one call of [`Hydrodynamics::solve`] each.
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] if the motion does not depend on the shape alone, if no length
    /// varies, if the model is that of another scene, or if the table would be too large; errors of
    /// the model.
    pub fn tabulate(
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        ranges: &[(f64, f64)],
        tolerance: f64,
    ) -> Result<Self, ModelError> {
        let solved = (SolvedShapes::default(), TablePart::Whole);
        let space = Self::tabulate_from(scene, model, ranges, tolerance, solved, &mut |_| Ok(()))?;
        match space.is_coarse {
            true => Err(too_large()),
            false => Ok(space),
        }
    }

    /// As [`ShapeSpace::tabulate`], from shapes that were solved before for the same scene, model
    /// and ranges, by solving a part of the others.
    ///
    /// A table that would be too large ends at the last grid that is not, with its larger error
    /// bar, see [`ShapeSpace::is_coarse`].
    ///
    /// `observe` is called with all solved shapes after each solve, or after several solves in
    /// parallel. An interrupted table that continues is bitwise the one that was not interrupted.
    ///
    /// # Errors
    /// As [`ShapeSpace::tabulate`], shapes that do not fit the scene, and errors of `observe`,
    /// which end the computation; [`ModelError::MissingShapes`] if the part does not complete the
    /// table.
    pub fn tabulate_from(
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        ranges: &[(f64, f64)],
        tolerance: f64,
        solved: (SolvedShapes, TablePart),
        observe: &mut dyn FnMut(&SolvedShapes) -> Result<(), ModelError>,
    ) -> Result<Self, ModelError> {
        let variables = varying_joints(scene, model, ranges, tolerance)?;
        let placement = Placement::new(scene)?;
        let mut sampler = Sampler::new(scene, model, &placement, ranges, &variables, solved)?;
        let longest = longest_arm(scene, ranges);
        let box_ranges: Vec<(f64, f64)> = variables.iter().map(|&k| ranges[k]).collect();
        let mut degrees = vec![FIRST_DEGREE; variables.len()];
        if !fits(&degrees) {
            return Err(too_large());
        }
        let mut previous_tail = f64::INFINITY;
        loop {
            let values = sampler.grid(&degrees, observe)?;
            let layout = sampler.layout();
            let bars = sampler.solved.bars;
            let scales = scales(&values, variables.len(), layout, longest, tolerance, &bars);
            let Scales {
                weights,
                speed,
                tolerance: wanted,
            } = scales;
            let width = weights.len();
            let records = Interpolant::new(box_ranges.clone(), degrees.clone(), width, values);
            let tails = records.tails(&weights);
            let tail: f64 = tails.iter().sum();
            // The error of the model is not smooth: it jumps with the order of its expansions.
            let is_noise = tail > 0.5 * previous_tail
                && tail * speed <= NOISE * bars.total().max(tolerance * speed);
            let is_fine = tail <= wanted || is_noise;
            let finer = refined(&degrees, &tails, wanted);
            if is_fine || !fits(&finer) {
                let position_error = match placement.is_fixed() {
                    true => sampler.position_error(&degrees)?,
                    false => 0.0,
                };
                let (dofs, solver) = sampler.solved.last.clone().unwrap_or_default();
                return Ok(Self {
                    start: scene.initial_state(),
                    ranges: ranges.to_vec(),
                    records,
                    layout,
                    dofs,
                    solver: SolverReport {
                        solver: "table".to_owned(),
                        ..solver
                    },
                    points: points(&degrees),
                    interpolation_error: tail * speed,
                    relative_error: tail,
                    is_coarse: !is_fine,
                    bars,
                    longest,
                    position_error,
                    variables,
                });
            }
            previous_tail = tail;
            degrees = finer;
        }
    }

    /// Whether the shape is in the box and the rates of constant values are zero.
    pub fn contains(&self, shape: &[f64], rates: &[f64]) -> bool {
        covers(&self.ranges, shape, rates)
    }

    /// Degrees and ranges of the grid, with one entry per varying joint.
    pub(super) fn grid(&self) -> (&[usize], &[(f64, f64)]) {
        (self.records.degrees(), self.records.ranges())
    }

    /// Joints whose value varies.
    pub(super) fn variables(&self) -> &[usize] {
        &self.variables
    }

    /// The smallest value of every joint.
    pub(super) fn smallest_lengths(&self) -> Vec<f64> {
        self.ranges.iter().map(|range| range.0).collect()
    }

    /// Number of shapes at which the model was sampled.
    pub fn points(&self) -> usize {
        self.points
    }

    /// Estimated errors of velocities for a unit rate: of the interpolation, and of the model.
    pub fn errors(&self) -> (f64, f64) {
        (self.interpolation_error, self.bars.total())
    }

    /// Whether the interpolation error is above the tolerance, because the next grid would have had
    /// too many points.
    pub fn is_coarse(&self) -> bool {
        self.is_coarse
    }

    /// Estimated change of velocities for a unit rate by the motion of the swimmer in its
    /// container.
    ///
    /// The largest change at the corners of the box, if the swimmer moves as far from its place, or
    /// turns as far, as it does when all joints pass their ranges once. Zero in unbounded fluid.
    pub fn position_error(&self) -> f64 {
        self.position_error
    }

    /// The connection `A(s)`: twist of the frame for a unit rate of each varying length.
    ///
    /// The frame has the attitude of the start; varying joints are in the order of the scene. Cost:
    /// microseconds.
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] for shapes outside the box.
    pub fn connection(&self, shape: &[f64]) -> Result<Vec<Twist>, ModelError> {
        let records = self.records(shape)?.into_iter();
        Ok(records
            .map(|record| record.response.motion.frames[0])
            .collect())
    }

    /// The dissipation metric `G(s)`: the power of the swimmer on the fluid is `ds/dt · G ds/dt`.
    ///
    /// Rows and columns are the varying joints. Symmetric up to the errors of the table. Cost:
    /// microseconds.
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] for shapes outside the box.
    pub fn metric(&self, shape: &[f64]) -> Result<DMatrix<f64>, ModelError> {
        let records = self.records(shape)?;
        let n = records.len();
        Ok(DMatrix::from_fn(n, n, |i, j| {
            let [loads, motion] = [i, j].map(|k| &records[k].response);
            loads.power_in(motion)
        }))
    }

    /// The interpolated solution for a configuration in the box. Cost: microseconds.
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] for shapes outside the box, rates of constant values, and a
    /// state without a frame.
    pub fn solution(
        &self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<InstantaneousSolution, ModelError> {
        if !self.contains(configuration.shape, rates) {
            return Err(outside());
        }
        let [frame, start] = [configuration.state, &self.start]
            .map(|state| state.frames.first().map(|frame| frame.rotation));
        let rotation = frame.zip(start).map(|(q, start)| q * start.inverse());
        let rotation = rotation.ok_or_else(outside)?;
        let rates: Vec<f64> = self.variables.iter().map(|&k| rates[k]).collect();
        let rows = self.rows(configuration.shape);
        let width = rows.first().map_or(0, Vec::len);
        let mut sum = vec![0.0; width];
        for (row, rate) in rows.iter().zip(&rates) {
            for (sum, value) in sum.iter_mut().zip(row) {
                *sum += rate * value;
            }
        }
        let mut record = Record::new(&sum, self.layout);
        for response in record.mesh_error.iter_mut().chain([&mut record.response]) {
            response.rotate(&rotation);
        }
        let speed: f64 = rates.iter().map(|r| r.abs()).sum();
        let response = record.response;
        let power = response.power();
        let forces = response.bodies.iter().map(|b| b.force.norm());
        let force = forces.fold(0.0, f64::max);
        // The error of a product of two interpolated numbers.
        let sizes = response.bodies.iter();
        let of_bodies: f64 = sizes.map(|b| b.force.norm() * b.velocity.norm()).sum();
        let rates = response.drives().zip(&response.amplitude_rates);
        let of_deformations: f64 = rates.map(|(drive, rate)| (drive * rate).abs()).sum();
        let product = of_bodies + of_deformations;
        let torques = response.bodies.iter().map(|b| b.torque.norm());
        let torque = torques.fold(force * self.longest, f64::max);
        let mesh_error = record.mesh_error.map(|response| DiscretisationError {
            response,
            uncertainty: Uncertainty {
                velocity: speed * self.bars.mesh_uncertainty.velocity,
                angular_velocity: speed * self.bars.mesh_uncertainty.angular_velocity,
                force: speed * self.bars.mesh_uncertainty.force,
                torque: speed * self.bars.mesh_uncertainty.torque,
                power: power.abs() * self.bars.mesh_uncertainty.power,
                ..self.bars.mesh_uncertainty
            },
        });
        let mut solution = InstantaneousSolution {
            dofs: self.dofs,
            solver: self.solver.clone(),
            error_estimate: ErrorEstimate::of_model(
                speed * (self.interpolation_error + self.bars.velocity + self.position_error),
            ),
            angular_velocity_error: ErrorEstimate::of_model(
                speed
                    * (self.bars.angular_velocity
                        + (self.interpolation_error + self.position_error) / self.longest),
            ),
            force_error: ErrorEstimate::of_model(
                speed * self.bars.force + self.relative_error * force,
            ),
            torque_error: ErrorEstimate::of_model(
                speed * self.bars.torque + self.relative_error * torque,
            ),
            power_error: ErrorEstimate::of_model(
                self.bars.power * power.abs() + 2.0 * self.relative_error * product,
            ),
            ..response.into()
        };
        if let Some(error) = mesh_error {
            solution.set_mesh_error(error);
        }
        Ok(solution)
    }

    /// For each varying joint, the numbers of the record for a unit rate.
    fn rows(&self, shape: &[f64]) -> Vec<Vec<f64>> {
        let point: Vec<f64> = self.variables.iter().map(|&k| shape[k]).collect();
        let values = self.records.evaluate(&point);
        values
            .chunks(values.len() / self.variables.len())
            .map(<[f64]>::to_vec)
            .collect()
    }

    /// For each varying joint, the record for a unit rate.
    ///
    /// # Errors
    /// [`ModelError::ShapeSpace`] for shapes outside the box.
    fn records(&self, shape: &[f64]) -> Result<Vec<Record>, ModelError> {
        if !self.contains(shape, &vec![0.0; self.ranges.len()]) {
            return Err(outside());
        }
        let rows = self.rows(shape);
        let record = |row: &Vec<f64>| Record::new(row, self.layout);
        Ok(rows.iter().map(record).collect())
    }
}

/// Joints whose value varies in the box, if a table over it is possible for the scene and the
/// model.
///
/// # Errors
/// [`ModelError::ShapeSpace`], as [`ShapeSpace::tabulate`].
fn varying_joints(
    scene: &Scene,
    model: &dyn Hydrodynamics,
    ranges: &[(f64, f64)],
    tolerance: f64,
) -> Result<Vec<usize>, ModelError> {
    let refuse = |problem: &str| {
        Err(ModelError::ShapeSpace {
            problem: problem.to_owned(),
        })
    };
    if !scene.is_driven_by_shape() {
        return refuse(
            "tables require a motion that the joints determine: one linkage without external \
             loads, masses, slip, background flow and passive joints, in a fluid of constant \
             viscosity",
        );
    }
    let set = scene.articulation();
    let joints = set.joints().len();
    let is_valid = |(range, joint): (&(f64, f64), &Joint)| {
        let is_positive = 0.0 < range.0 || joint.kind.is_signed();
        range.0.is_finite() && range.1.is_finite() && is_positive && range.0 <= range.1
    };
    if ranges.len() != joints || !ranges.iter().zip(set.joints()).all(is_valid) {
        return refuse(
            "every link needs a range of positive lengths or of angles, the smaller one first",
        );
    }
    let variables: Vec<usize> = (0..joints).filter(|&k| ranges[k].0 < ranges[k].1).collect();
    if variables.is_empty() {
        return refuse("no length varies; give at least one range a positive width");
    }
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return refuse("the tolerance must be positive");
    }
    if let Some(key) = scene.differing_key(model.scene()) {
        return refuse(&format!("the model is that of a scene with another {key}"));
    }
    Ok(variables)
}

/// The error for a box whose grid does not fit.
fn too_large() -> ModelError {
    ModelError::ShapeSpace {
        problem: "the table would be too large; take a smaller box".to_owned(),
    }
}

/// The error for a query that a table does not answer.
fn outside() -> ModelError {
    ModelError::ShapeSpace {
        problem: "the lengths are outside the box of the table, a length that it keeps constant \
                  has a rate, or the state has no frame"
            .to_owned(),
    }
}

/// Whether a shape is in a box of `ranges`, and the rates of constant values are zero.
pub(super) fn covers(ranges: &[(f64, f64)], shape: &[f64], rates: &[f64]) -> bool {
    let inside = |((range, length), rate): ((&(f64, f64), &f64), &f64)| {
        range.0 <= *length && *length <= range.1 && (range.0 < range.1 || *rate == 0.0)
    };
    shape.len() == ranges.len()
        && rates.len() == ranges.len()
        && ranges.iter().zip(shape).zip(rates).all(inside)
}

/// Degrees of the grid after one with these sums of highest coefficients, [`Interpolant::tails`].
///
/// The degree is doubled in the variables with more than half of an equal share of the error
/// `wanted`.
fn refined(degrees: &[usize], tails: &[f64], wanted: f64) -> Vec<usize> {
    let share = 0.5 * wanted / tails.len() as f64;
    (degrees.iter().zip(tails))
        .map(|(&degree, &tail)| if tail > share { 2 * degree } else { degree })
        .collect()
}

/// Whether a grid is small enough to be computed.
fn fits(degrees: &[usize]) -> bool {
    points(degrees) <= MAX_POINTS && degrees.iter().all(|&n| n <= MAX_DEGREE)
}

/// Number of points of a grid.
fn points(degrees: &[usize]) -> usize {
    degrees.iter().map(|n| n + 1).product()
}
