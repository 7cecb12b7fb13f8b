//! Explicit Euler, the method to be compared with.

use rigid::State;

use super::oracle::Oracle;
use super::piece::PathPiece;
use super::result::{LegResult, Rung};
use crate::SwimError;

/// Integrates a leg in equal steps, each at the velocity of its start.
pub(super) fn leg(
    oracle: &mut Oracle,
    start: &State,
    steps: usize,
) -> Result<LegResult, SwimError> {
    let mut result = LegResult::at(start);
    oracle.want_estimates(false);
    for k in 0..steps {
        let span = (k as f64 / steps as f64, (k + 1) as f64 / steps as f64);
        let solved = oracle.solve(span.0, &result.end)?;
        let rate = &solved.instant.motion * (oracle.leg.duration * (span.1 - span.0));
        let piece = PathPiece::new(&oracle.scene.articulation, &result.end, span, vec![rate])?;
        result.append(
            oracle,
            Rung {
                piece,
                solved: vec![solved],
                weights: vec![1.0],
            },
            None,
            None,
        )?;
    }
    Ok(result.closed(oracle))
}
