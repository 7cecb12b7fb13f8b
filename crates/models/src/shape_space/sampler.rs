//! Solutions of a model at the points of nested grids.

use std::collections::BTreeMap;

use rigid::State;
use stokes::{Dofs, SolverReport};

use super::chebyshev::node;
use super::record::{Layout, numbers};
use crate::error::ModelError;
use crate::error_estimate::ErrorEstimate;
use crate::hydrodynamics::{Configuration, Hydrodynamics, Query};
use crate::mesh_error::Uncertainty;
use crate::solution::InstantaneousSolution;

/// Highest degree in a variable; spheres with gaps of a hundredth of a radius need more.
pub const MAX_DEGREE: usize = 64;

/// Largest error bars of several solutions, each for a unit rate.
#[derive(Clone, Copy, Debug, Default)]
pub struct Bars {
    /// Error bar of velocities without that for the discretisation.
    pub velocity: f64,
    /// Error bar of the power without the discretisation error, relative to the power.
    pub power: f64,
    /// Uncertainty of discretisation errors.
    pub mesh_uncertainty: Uncertainty,
}

impl Bars {
    /// Error bar of velocities by all sources.
    pub fn total(&self) -> f64 {
        self.velocity + self.mesh_uncertainty.velocity
    }

    fn include(&mut self, solution: &InstantaneousSolution) {
        let untabulated = |bars: &ErrorEstimate| match &solution.mesh_error {
            Some(_) => bars.total() - bars.mesh.unwrap_or(0.0),
            None => bars.total(),
        };
        let power = solution.power().abs().max(f64::MIN_POSITIVE);
        self.velocity = self.velocity.max(untabulated(&solution.error_estimate));
        self.power = self.power.max(untabulated(&solution.power_error) / power);
        if let Some(error) = &solution.mesh_error {
            let (largest, bars) = (&mut self.mesh_uncertainty, error.uncertainty);
            largest.velocity = largest.velocity.max(bars.velocity);
            largest.relative = largest.relative.max(bars.relative);
        }
    }
}

/// Samples a model at grid points, each at most once.
pub struct Sampler<'a> {
    state: State,
    /// Length of each link that does not vary.
    lengths: Vec<f64>,
    /// Links whose length varies.
    variables: &'a [usize],
    model: &'a mut dyn Hydrodynamics,
    /// What the records contain; whether they have discretisation errors is known after the first
    /// sample.
    pub layout: Layout,
    /// Numbers of the solutions by their indices in the finest grid.
    known: BTreeMap<Vec<usize>, Vec<f64>>,
    /// Largest error bars of a solution.
    pub bars: Bars,
    /// Size and solver of the last solution.
    pub last: Option<(Dofs, SolverReport)>,
}

impl<'a> Sampler<'a> {
    /// A sampler of a model in the state `state`; `lengths` has one entry per link.
    pub fn new(
        model: &'a mut dyn Hydrodynamics,
        state: State,
        lengths: Vec<f64>,
        variables: &'a [usize],
        layout: Layout,
    ) -> Self {
        Self {
            state,
            lengths,
            variables,
            model,
            layout,
            known: BTreeMap::new(),
            bars: Bars::default(),
            last: None,
        }
    }

    /// Number of shapes that were solved.
    pub fn points(&self) -> usize {
        self.known.len()
    }

    /// Numbers of the solutions at a grid point: one record per variable, for a unit rate of it.
    ///
    /// `ranges` and `degrees` have one entry per variable.
    ///
    /// # Errors
    /// Those of the model; [`ModelError::NoSolution`] for a list of another length, or with other
    /// numbers of bodies and links.
    pub fn at(
        &mut self,
        ranges: &[(f64, f64)],
        degrees: &[usize],
        index: &[usize],
    ) -> Result<&[f64], ModelError> {
        let key: Vec<usize> = index
            .iter()
            .zip(degrees)
            .map(|(i, n)| i * (MAX_DEGREE / n))
            .collect();
        if !self.known.contains_key(&key) {
            let mut lengths = self.lengths.clone();
            for (variable, &link) in self.variables.iter().enumerate() {
                lengths[link] = node(ranges[variable], degrees[variable], index[variable]);
            }
            let unit_rate = |&link: &usize| {
                let mut rates = vec![0.0; lengths.len()];
                rates[link] = 1.0;
                rates
            };
            let rates: Vec<Vec<f64>> = self.variables.iter().map(unit_rate).collect();
            let configuration = Configuration {
                state: &self.state,
                lengths: &lengths,
            };
            let query = Query::new(configuration, &rates);
            let mut values = Vec::new();
            let solutions = self.model.solve(&query)?;
            let model = self.model.name();
            if solutions.len() != rates.len() {
                return Err(ModelError::NoSolution { model });
            }
            for solution in solutions {
                solution.check(self.model)?;
                if self.known.is_empty() {
                    self.layout.mesh_errors = solution.mesh_error.is_some();
                }
                self.bars.include(&solution);
                let numbers = numbers(&solution);
                if numbers.len() != self.layout.numbers() {
                    return Err(ModelError::NoSolution { model });
                }
                values.extend(numbers);
                self.last = Some((solution.dofs, solution.solver));
            }
            self.known.insert(key.clone(), values);
        }
        Ok(self.known.get(&key).map_or(&[], Vec::as_slice))
    }
}
