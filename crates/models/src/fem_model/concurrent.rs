//! Solutions for one or several configurations, and the earlier solutions they start from.

use rayon::prelude::*;
use stokes::InitialGuesses;

use super::last_solution::Last;
use super::moving_frame::MovingFrame;
use super::placed_query::PlacedQuery;
use super::{FemModel, MAX_GUESSES};
use crate::error::ModelError;
use crate::hydrodynamics::Query;
use crate::solution::InstantaneousSolution;

/// Largest number of degrees of freedom of a configuration that is solved beside others.
///
/// The solve of one small system leaves threads idle, those of several do not. Large systems use
/// all threads by themselves, and several would need several times the memory.
const MAX_DOFS: usize = 200_000;

/// The solutions for the rates of a query, and the data of the last one.
type Solved = (Vec<InstantaneousSolution>, Option<Last>);

impl FemModel {
    /// Whether the solutions of queries do not depend on one another, except as initial guesses.
    ///
    /// Queries that adapt the mesh, or that have loads in a moving frame, change the model itself.
    pub(super) fn are_independent(&self, queries: &[Query<'_>]) -> bool {
        let is_independent = |query: &Query| {
            let frame = MovingFrame::of(&self.scaled.scene, query.configuration.state);
            query.accuracy.is_none() && frame.is_none() && !query.rates.is_empty()
        };
        self.engine.is_none() && queries.iter().all(is_independent)
    }

    /// Solutions of independent queries: concurrently if they share cells, one by one otherwise.
    ///
    /// # Errors
    /// The first error of a query.
    pub(super) fn solve_independent(
        &mut self,
        queries: &[Query<'_>],
    ) -> Result<Vec<Solved>, ModelError> {
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
    ) -> Result<Vec<Solved>, ModelError> {
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
                let (solution, of_query) = one?;
                guesses.remember_newest_of(of_query);
                solved.push(solution);
            }
        } else if let Some(query) = group.pop() {
            solved.push(self.solve_placed(query, &mut guesses)?);
        }
        self.guesses = guesses;
        Ok(solved)
    }
}
