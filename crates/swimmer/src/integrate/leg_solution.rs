//! Solutions along a leg.

use models::InstantaneousSolution;
use rigid::State;

/// The model's solution at a point of a leg.
#[derive(Clone, Debug)]
pub struct LegSolution {
    /// Number of the solve from zero, over the whole simulation.
    pub number: usize,
    /// Where on the leg.
    pub s: f64,
    /// The state that it was computed for.
    pub state: State,
    /// The solution.
    pub solution: InstantaneousSolution,
}
