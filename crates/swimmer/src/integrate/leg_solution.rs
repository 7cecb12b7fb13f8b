//! Solutions along a leg.

use models::InstantaneousSolution;
use rigid::State;

/// The model's solution at a point of a leg.
#[derive(Clone, Debug)]
pub struct LegSolution {
    /// Number of the solve from zero, over the whole simulation.
    pub number: usize,
    /// Position on the leg, from 0 at its start to 1 at its end.
    pub s: f64,
    /// The state for which the solution was computed.
    pub state: State,
    /// The solution.
    pub solution: InstantaneousSolution,
}
