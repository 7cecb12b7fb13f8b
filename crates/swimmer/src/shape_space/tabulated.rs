//! A model that answers from tables where it has them.

use std::time::Instant as Clock;

use nalgebra::{DMatrix, Isometry3};
use rigid::State;

use super::plan::boxes;
use super::space::{ShapeSpace, covers};
use crate::SwimError;
use crate::model::{Choice, Cost, Flow, Hydrodynamics, Instant, ModelError, Placement};
use scene::Scene;

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

/// Puts tables before a model where that saves solves: free swimmers whose gait comes by the same shapes again.
///
/// The reasons say so. Answers come with the errors of both the tables and the model. The same scene gives the same tables, so that
/// interrupted runs end in the same bits.
pub fn speed_up(scene: &Scene, choice: Choice) -> Choice {
    let Some(boxes) = boxes(scene) else {
        return choice;
    };
    let mut reasons = choice.reasons;
    reasons.push(match boxes.len() {
        1 => "tabulated over the shapes of the gait, which come again in every cycle".to_owned(),
        n => format!("tabulated along {n} lines of shape space, which come again in every cycle"),
    });
    let table = |ranges| Table {
        ranges,
        state: Made::NotYet,
    };
    Choice {
        model: Box::new(Tabulated {
            scene: scene.clone(),
            model: choice.model,
            tables: boxes.into_iter().map(table).collect(),
        }),
        reasons,
    }
}

impl Tabulated {
    /// The table for a placement, made if need be; none where there is none.
    fn table(&mut self, placement: &Placement<'_>) -> Option<&ShapeSpace> {
        let table = self.tables.iter_mut().find(|table| {
            covers(&table.ranges, placement.lengths, placement.rates)
                && !matches!(table.state, Made::Never)
        })?;
        if let Made::NotYet = table.state {
            let tolerance = SHARE * self.scene.model.tolerance;
            let made: Result<ShapeSpace, SwimError> =
                ShapeSpace::tabulate(&self.scene, self.model.as_mut(), &table.ranges, tolerance);
            // without a table the model itself answers, or says what is wrong, where it is asked
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

    fn instant(&mut self, placement: &Placement<'_>) -> Result<Instant, ModelError> {
        let clock = Clock::now();
        if let Some(space) = self.table(placement) {
            let mut instant = space.instant(placement);
            instant.seconds.solve = clock.elapsed().as_secs_f64();
            instant.seconds.total = instant.seconds.solve;
            return Ok(instant);
        }
        self.model.instant(placement)
    }

    fn instants(
        &mut self,
        state: &State,
        lengths: &[f64],
        rates: &[Vec<f64>],
    ) -> Result<Vec<Instant>, ModelError> {
        let placements = Placement::at_rates(state, lengths, rates);
        // without a table the model itself has all of them at once
        if placements.clone().all(|p| self.table(&p).is_none()) {
            return self.model.instants(state, lengths, rates);
        }
        placements
            .map(|placement| self.instant(&placement))
            .collect()
    }

    fn want_estimates(&mut self, wanted: bool) -> bool {
        self.model.want_estimates(wanted)
    }

    fn resistance(&mut self, placement: &Placement<'_>) -> Result<DMatrix<f64>, ModelError> {
        self.model.resistance(placement)
    }

    fn begin_leg(&mut self) {
        self.model.begin_leg();
    }

    fn history(&self) -> Vec<Isometry3<f64>> {
        self.model.history()
    }

    fn restore(&mut self, history: &[Isometry3<f64>]) -> Result<(), ModelError> {
        self.model.restore(history)
    }

    fn picture(&mut self, placement: &Placement<'_>) -> Result<Flow, ModelError> {
        self.model.picture(placement)
    }

    fn cost(&mut self, placement: &Placement<'_>) -> Result<Cost, ModelError> {
        self.model.cost(placement)
    }
}
