//! Shapes at which a model has been solved, from which an interrupted table continues.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use stokes::{Dofs, SolverReport};

use crate::discretisation_error::Uncertainty;
use crate::hydrodynamics::History;
use crate::solution::{ErrorEstimate, InstantaneousSolution};

/// The shapes of a table that one computation solves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TablePart {
    /// All shapes.
    Whole,
    /// Of each grid those whose position is `number` modulo `count`, from 1 to `count`.
    ///
    /// A computation of a share ends with [`ModelError::MissingShapes`](crate::ModelError) at the
    /// first grid of which others are missing.
    Share {
        /// From 1 to `count`; other numbers have no shapes.
        number: usize,
        /// Number of shares.
        count: usize,
    },
    /// No shape: all must be known already.
    Known,
}

impl TablePart {
    /// Whether it contains the shape at a position of a grid.
    pub(super) fn contains(self, position: usize) -> bool {
        match self {
            Self::Whole => true,
            Self::Share { number, count } => {
                position.checked_rem(count).map(|rest| rest + 1) == Some(number)
            }
            Self::Known => false,
        }
    }
}

/// Solutions of a model at points of the grids of a table.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct SolvedShapes {
    /// Numbers of the solutions by the index of the point in the finest grid.
    pub(super) numbers: BTreeMap<usize, Vec<f64>>,
    /// Whether the numbers contain discretisation errors; known after the first solution.
    pub(super) mesh_errors: bool,
    pub(super) bars: Bars,
    /// Size and solver of the last solution.
    pub(super) last: Option<(Dofs, SolverReport)>,
    /// State of the model after the last solution.
    pub(super) history: History,
    /// Number of shapes when the part of the present grid is solved.
    #[serde(skip)]
    pub(super) wanted: usize,
}

impl SolvedShapes {
    /// Number of shapes.
    pub fn len(&self) -> usize {
        self.numbers.len()
    }

    /// Number of shapes that there will be when the grid that is being solved is complete; a finer
    /// one may follow.
    pub fn wanted(&self) -> usize {
        self.wanted.max(self.len())
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.numbers.is_empty()
    }

    /// Adds the shapes of another computation for the same scene, model and ranges.
    ///
    /// A shape that both have keeps its numbers, and the state of the model is that of `self`,
    /// unless it has no shapes.
    pub fn merge(&mut self, other: Self) {
        if self.is_empty() {
            *self = other;
            return;
        }
        for (key, numbers) in other.numbers {
            self.numbers.entry(key).or_insert(numbers);
        }
        self.bars = self.bars.with(&other.bars);
    }
}

/// Largest error bars of several solutions, each for a unit rate.
#[derive(Clone, Copy, Debug, Default, Deserialize, Serialize)]
pub struct Bars {
    /// Error bar of velocities without that for the discretisation.
    pub velocity: f64,
    /// Error bar of angular velocities without that for the discretisation.
    #[serde(default)]
    pub angular_velocity: f64,
    /// Error bar of forces without that for the discretisation.
    pub force: f64,
    /// Error bar of torques without that for the discretisation.
    #[serde(default)]
    pub torque: f64,
    /// Error bar of the power without the discretisation error, relative to the power.
    pub power: f64,
    /// Uncertainty of discretisation errors, of the power relative to the power.
    pub mesh_uncertainty: Uncertainty,
    /// Error bar of velocities for the discretisation.
    pub mesh: f64,
    /// Error bar of forces for the discretisation.
    pub mesh_force: f64,
}

impl Bars {
    /// Error bar of velocities by all sources.
    pub fn total(&self) -> f64 {
        self.velocity + self.mesh_uncertainty.velocity
    }

    /// The larger ones of two.
    pub fn with(&self, other: &Self) -> Self {
        let [a, b] = [self.mesh_uncertainty, other.mesh_uncertainty];
        Self {
            velocity: self.velocity.max(other.velocity),
            angular_velocity: self.angular_velocity.max(other.angular_velocity),
            force: self.force.max(other.force),
            torque: self.torque.max(other.torque),
            power: self.power.max(other.power),
            mesh_uncertainty: Uncertainty {
                relative: a.relative.max(b.relative),
                velocity: a.velocity.max(b.velocity),
                angular_velocity: a.angular_velocity.max(b.angular_velocity),
                force: a.force.max(b.force),
                torque: a.torque.max(b.torque),
                power: a.power.max(b.power),
            },
            mesh: self.mesh.max(other.mesh),
            mesh_force: self.mesh_force.max(other.mesh_force),
        }
    }

    /// Takes the bars of a solution into account.
    pub fn include(&mut self, solution: &InstantaneousSolution) {
        let untabulated = |bars: &ErrorEstimate| match &solution.mesh_error {
            Some(_) => bars.total() - bars.mesh.unwrap_or(0.0),
            None => bars.total(),
        };
        let power = solution.power().abs().max(f64::MIN_POSITIVE);
        self.velocity = self.velocity.max(untabulated(&solution.error_estimate));
        let spin = untabulated(&solution.angular_velocity_error);
        self.angular_velocity = self.angular_velocity.max(spin);
        self.force = self.force.max(untabulated(&solution.force_error));
        self.torque = self.torque.max(untabulated(&solution.torque_error));
        self.power = self.power.max(untabulated(&solution.power_error) / power);
        self.mesh = self.mesh.max(solution.error_estimate.mesh.unwrap_or(0.0));
        self.mesh_force = (self.mesh_force).max(solution.force_error.mesh.unwrap_or(0.0));
        if let Some(error) = &solution.mesh_error {
            let (largest, bars) = (&mut self.mesh_uncertainty, error.uncertainty);
            largest.velocity = largest.velocity.max(bars.velocity);
            largest.angular_velocity = largest.angular_velocity.max(bars.angular_velocity);
            largest.force = largest.force.max(bars.force);
            largest.torque = largest.torque.max(bars.torque);
            largest.relative = largest.relative.max(bars.relative);
            largest.power = largest.power.max(bars.power / power);
        }
    }
}
