//! Solutions for the orientations of the basis, and their combinations.

use nalgebra::{DMatrix, DVector};

use crate::discretisation_error::{DiscretisationError, Uncertainty};
use crate::error_estimate::ErrorEstimate;
use crate::record::{Layout, Record};
use crate::solution::{FlowField, InstantaneousSolution};

/// Solutions for the orientations of the basis, in the axes of the body.
pub(super) struct Solved {
    pub shape: Vec<f64>,
    pub layout: Layout,
    /// Inverse of the matrix whose columns are the vectors `d` of the orientations.
    pub inverse: DMatrix<f64>,
    pub solutions: Vec<Response>,
    /// Largest difference between superposed and direct velocities at one further orientation.
    pub deviation: f64,
}

/// One solution of the basis, without the background flow.
pub(super) struct Response {
    pub solution: InstantaneousSolution,
    pub numbers: Vec<f64>,
    pub flow: Option<FlowField>,
}

impl Solved {
    /// The linear combination of the solutions, in the axes of the body, with its error bars.
    pub fn combination(&self, coefficients: &DVector<f64>) -> InstantaneousSolution {
        let mut sum = vec![0.0; self.layout.numbers()];
        let mut error_estimate = ErrorEstimate::default();
        let (mut force_error, mut power_error) =
            (ErrorEstimate::default(), ErrorEstimate::default());
        let mut uncertainty = Uncertainty::default();
        let (mut slip_power, mut slip_power_error) = (0.0, 0.0);
        // Powers are quadratic: roots of their uncertainties are summed.
        let mut root_of_power = 0.0;
        for (response, &c) in self.solutions.iter().zip(coefficients) {
            for (sum, value) in sum.iter_mut().zip(&response.numbers) {
                *sum += c * value;
            }
            let solution = &response.solution;
            error_estimate.accumulate(c.abs(), &solution.error_estimate);
            force_error.accumulate(c.abs(), &solution.force_error);
            power_error.accumulate(c.abs(), &solution.power_error);
            slip_power += c * solution.slip_power;
            if let Some(error) = &solution.mesh_error {
                uncertainty.relative = uncertainty.relative.max(error.uncertainty.relative);
                uncertainty.velocity += c.abs() * error.uncertainty.velocity;
                root_of_power += c.abs() * error.uncertainty.power.sqrt();
                slip_power_error += c * error.slip_power;
            }
        }
        uncertainty.power = root_of_power * root_of_power;
        error_estimate.model = Some(error_estimate.model.unwrap_or(0.0) + self.deviation);
        let record = Record::new(&sum, self.layout);
        let first = &self.solutions[0].solution;
        let mut solution = InstantaneousSolution {
            dofs: first.dofs,
            solver: first.solver.clone(),
            slip_power,
            error_estimate,
            force_error,
            power_error,
            ..InstantaneousSolution::new(record.bodies, record.joint_forces, record.motion)
        };
        if let Some(error) = record.mesh_error {
            solution.set_mesh_error(DiscretisationError {
                uncertainty,
                slip_power: slip_power_error,
                ..error
            });
        }
        solution
    }
}
