//! The values that the joints take along a gait.

use scene::{Gait, Scene, spans};

use crate::error::DesignError;

/// Smallest and largest value of each joint in a cycle of the gait, the start included.
///
/// # Errors
/// A gait that cannot be followed.
pub fn joint_ranges(scene: &Scene) -> Result<Vec<(f64, f64)>, DesignError> {
    let start = scene.articulation().initial_shape();
    let mut ranges: Vec<(f64, f64)> = start.iter().map(|&x| (x, x)).collect();
    // The first cycle may begin elsewhere than all later ones.
    let gait = Gait {
        cycles: scene.gait().cycles.min(2),
        phases: scene.gait().phases.clone(),
    };
    for span in spans(&gait, start)? {
        for (range, part) in ranges.iter_mut().zip(span.ranges()) {
            *range = (range.0.min(part.0), range.1.max(part.1));
        }
    }
    Ok(ranges)
}
