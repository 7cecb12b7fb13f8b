//! A model that answers from tables where it has them.

use std::time::Instant as Clock;

use nalgebra::DMatrix;
use scene::Scene;

use super::space::{ShapeSpace, covers};
use crate::error::ModelError;
use crate::hydrodynamics::{Configuration, Cost, ErrorEstimates, History, Hydrodynamics, Query};
use crate::solution::{FlowField, InstantaneousSolution};

/// A model with tables over parts of its shape space, made when they are first asked for.
pub struct Tabulated {
    scene: Scene,
    model: Box<dyn Hydrodynamics>,
    tables: Vec<Table>,
}

struct Table {
    ranges: Vec<(f64, f64)>,
    state: Made,
}

enum Made {
    NotYet,
    Yes(Box<ShapeSpace>),
    /// The model cannot be asked everywhere in the box: bodies touch there, or a table would be too large.
    Never,
}

/// Velocities are interpolated to this part of the tolerance: the net displacement is a small difference of the legs'.
const SHARE: f64 = 0.01;

impl Tabulated {
    /// Puts tables before a model: over each of these boxes of lengths, one range per link.
    ///
    /// A table is made when a configuration in its box is first asked for. Solutions come with the
    /// errors of both the tables and the model. The same scene gives the same tables, so that
    /// interrupted runs end in the same bits.
    pub fn new(scene: &Scene, model: Box<dyn Hydrodynamics>, boxes: Vec<Vec<(f64, f64)>>) -> Self {
        let table = |ranges| Table {
            ranges,
            state: Made::NotYet,
        };
        Self {
            scene: scene.clone(),
            model,
            tables: boxes.into_iter().map(table).collect(),
        }
    }

    /// The table for a configuration and rates, made if need be; none where there is none.
    fn table(
        &mut self,
        configuration: Configuration,
        rates: &[f64],
        estimates: bool,
    ) -> Option<&ShapeSpace> {
        let table = self.tables.iter_mut().find(|table| {
            covers(&table.ranges, configuration.lengths, rates)
                && !matches!(table.state, Made::Never)
        })?;
        if let Made::NotYet = table.state {
            let tolerance = SHARE * self.scene.model().tolerance;
            let model = self.model.as_mut();
            let made = ShapeSpace::sample(&self.scene, model, &table.ranges, tolerance, estimates);
            // Without a table the model itself answers, or reports the error, where it is asked.
            table.state = made.map_or(Made::Never, |space| Made::Yes(Box::new(space)));
        }
        match &table.state {
            Made::Yes(space) => Some(space),
            _ => None,
        }
    }
}

impl Hydrodynamics for Tabulated {
    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let configuration = query.configuration;
        let mut solutions = Vec::with_capacity(query.rates.len());
        let mut untabulated = Vec::new();
        for rates in query.rates {
            let clock = Clock::now();
            if let Some(space) = self.table(configuration, rates, query.estimates) {
                let mut solution = space.solution(configuration, rates);
                solution.seconds.solve = clock.elapsed().as_secs_f64();
                solution.seconds.total = solution.seconds.solve;
                solutions.push(Some(solution));
            } else {
                solutions.push(None);
                untabulated.push(rates.clone());
            }
        }
        // What no table covers, the model itself solves, all rates at once.
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

    fn error_estimates(&self) -> ErrorEstimates {
        self.model.error_estimates()
    }

    fn resistance(&mut self, configuration: Configuration<'_>) -> Result<DMatrix<f64>, ModelError> {
        self.model.resistance(configuration)
    }

    fn history(&self) -> Result<History, ModelError> {
        self.model.history()
    }

    fn restore(&mut self, history: &History) -> Result<(), ModelError> {
        self.model.restore(history)
    }

    fn flow(
        &mut self,
        configuration: Configuration<'_>,
        rates: &[f64],
    ) -> Result<FlowField, ModelError> {
        self.model.flow(configuration, rates)
    }

    fn cost(&mut self, configuration: Configuration<'_>) -> Result<Cost, ModelError> {
        self.model.cost(configuration)
    }
}
