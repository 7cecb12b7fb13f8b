//! A model with tables over parts of its shape space.

use std::time::Instant as Clock;

use scene::Scene;

use super::space::{ShapeSpace, covers};
use crate::error::ModelError;
use crate::hydrodynamics::Hydrodynamics;
use crate::query::{Configuration, Query};
use crate::solution::{InstantaneousSolution, Lookup};

/// A model with tables over boxes of shapes, which are computed when they are first needed.
pub struct Tabulated {
    scene: Scene,
    model: Box<dyn Hydrodynamics>,
    tables: Vec<Table>,
    tolerance: f64,
}

struct Table {
    ranges: Vec<(f64, f64)>,
    state: TableState,
}

enum TableState {
    Pending,
    Computed(Box<ShapeSpace>),
    /// The model fails somewhere in the box, because bodies touch, or the table would be too large.
    Impossible,
}

impl Tabulated {
    /// Adds tables over boxes of shapes to a model, to the relative error `tolerance`.
    ///
    /// Each box has one range per joint.
    ///
    /// A table is computed at the first query in its box. Error bars of solutions include the
    /// errors of both the table and the model. The same scene gives bitwise the same tables, so
    /// resumed runs give bitwise the same results.
    pub fn new(
        scene: &Scene,
        model: Box<dyn Hydrodynamics>,
        boxes: Vec<Vec<(f64, f64)>>,
        tolerance: f64,
    ) -> Self {
        let table = |ranges| Table {
            ranges,
            state: TableState::Pending,
        };
        Self {
            scene: scene.clone(),
            model,
            tables: boxes.into_iter().map(table).collect(),
            tolerance,
        }
    }

    /// The table for a configuration and rates, computed if necessary; `None` if there is none.
    ///
    /// The number is that of the table.
    fn table(
        &mut self,
        configuration: Configuration,
        rates: &[f64],
    ) -> Option<(usize, &ShapeSpace)> {
        let (number, table) = self.tables.iter_mut().enumerate().find(|(_, table)| {
            covers(&table.ranges, configuration.shape, rates)
                && !matches!(table.state, TableState::Impossible)
        })?;
        if let TableState::Pending = table.state {
            let tolerance = self.tolerance;
            let model = self.model.as_mut();
            let space = ShapeSpace::tabulate(&self.scene, model, &table.ranges, tolerance);
            // An error is not reported here: without a table the model solves the query itself.
            table.state = space.map_or(TableState::Impossible, |space| {
                TableState::Computed(Box::new(space))
            });
        }
        match &table.state {
            TableState::Computed(space) => Some((number, space)),
            _ => None,
        }
    }
}

/// All but the solutions is that of the model. Solutions of a table are without their flow, which
/// the model computes on request ([`Hydrodynamics::flows`]).
impl Hydrodynamics for Tabulated {
    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn inner(&self) -> Option<&dyn Hydrodynamics> {
        Some(self.model.as_ref())
    }

    fn inner_mut(&mut self) -> Option<&mut dyn Hydrodynamics> {
        Some(self.model.as_mut())
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let configuration = query.configuration;
        let mut solutions = Vec::with_capacity(query.rates.len());
        let mut untabulated = Vec::new();
        // Tables are of the loads of the scene alone.
        let has_own_terms = query.inertia.is_some() || query.random_loads.is_some();
        for rates in query.rates {
            let clock = Clock::now();
            let found = match has_own_terms {
                true => None,
                false => self.table(configuration, rates),
            };
            if let Some((table, space)) = found {
                let mut solution = space.solution(configuration, rates)?;
                let solves = space.points();
                solution.lookup = Some(Lookup { table, solves });
                solution.seconds.solve = clock.elapsed().as_secs_f64();
                solution.seconds.total = solution.seconds.solve;
                solutions.push(Some(solution));
            } else {
                solutions.push(None);
                untabulated.push(rates.clone());
            }
        }
        // The model solves for all rates that no table covers together.
        let mut solved = match untabulated.is_empty() {
            true => Vec::new(),
            false => self.model.solve(&Query {
                rates: &untabulated,
                ..*query
            })?,
        }
        .into_iter();
        let solutions = solutions
            .into_iter()
            .map(|known| known.or_else(|| solved.next()));
        (solutions.collect::<Option<Vec<_>>>()).ok_or(ModelError::NoSolution {
            model: self.model.name(),
        })
    }
}
