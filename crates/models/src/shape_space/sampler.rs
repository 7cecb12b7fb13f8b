//! Solutions of a model at the points of nested grids.

use std::collections::BTreeMap;

use rigid::State;
use stokes::{Dofs, SolverReport};

use super::chebyshev::node;
use super::record::{Layout, numbers};
use crate::error::ModelError;
use crate::hydrodynamics::{Configuration, Hydrodynamics, Query};

/// Highest degree in a variable; spheres with gaps of a hundredth of a radius need more.
pub const MAX_DEGREE: usize = 64;

/// Samples a model at grid points, each at most once.
pub struct Sampler<'a> {
    state: State,
    /// Length of each link that does not vary.
    lengths: Vec<f64>,
    /// Links whose length varies.
    variables: &'a [usize],
    model: &'a mut dyn Hydrodynamics,
    estimates: bool,
    layout: Layout,
    /// Numbers of the solutions by their indices in the finest grid.
    known: BTreeMap<Vec<usize>, Vec<f64>>,
    /// Largest error bar of a solution.
    pub model_error: f64,
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
        estimates: bool,
        layout: Layout,
    ) -> Self {
        Self {
            state,
            lengths,
            variables,
            model,
            estimates,
            layout,
            known: BTreeMap::new(),
            model_error: 0.0,
            last: None,
        }
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
            let query = Query::new(configuration, &rates).with_estimates(self.estimates);
            let mut values = Vec::new();
            let solutions = self.model.solve(&query)?;
            let model = self.model.name();
            if solutions.len() != rates.len() {
                return Err(ModelError::NoSolution { model });
            }
            for solution in solutions {
                solution.check(self.model)?;
                self.model_error = self.model_error.max(solution.error_estimate.total());
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
