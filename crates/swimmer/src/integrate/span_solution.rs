//! Solutions along a phase span.

use models::InstantaneousSolution;
use rigid::State;

/// The model's solution at a point of a phase span.
#[derive(Clone, Debug)]
pub struct SpanSolution {
    /// Number of the solve from zero, over the whole simulation.
    pub number: usize,
    /// Position on the phase span, from 0 at its start to 1 at its end.
    pub s: f64,
    /// The state for which the solution was computed.
    pub state: State,
    /// The solution.
    pub solution: InstantaneousSolution,
}
