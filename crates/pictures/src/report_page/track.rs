//! Poses of the bodies and values of the joints at the times of the player.

use nalgebra::{UnitQuaternion, Vector3};
use scene::spans;

use super::record::RunRecord;
use crate::error::PictureError;
use swimmer::Sample;

/// Largest number of times in a page; cycles that do not fit are left out.
const MAX_TIMES: usize = 3000;

/// Largest number of poses: about a megabyte.
const MAX_POSES: usize = 36_000;

/// The trajectory of the first cycles at increasing times.
pub struct Track {
    /// Number of cycles.
    pub cycles: usize,
    /// Times.
    pub times: Vec<f64>,
    /// Positions, by time and body.
    pub positions: Vec<Vec<Vector3<f64>>>,
    /// Rotations relative to the initial configuration, by time and body.
    pub rotations: Vec<Vec<UnitQuaternion<f64>>>,
    /// Values of the joints, by time and joint.
    pub joints: Vec<Vec<f64>>,
}

impl Track {
    /// The track of as many whole cycles as fit into the page, at least one.
    ///
    /// # Errors
    /// A gait that cannot be followed.
    pub fn new(record: &RunRecord) -> Result<Self, PictureError> {
        let (scene, outcome) = (&record.scene, &record.outcome);
        let gait = scene.gait();
        let cycle = gait.cycle_duration();
        let bodies = scene.bodies().len().max(1);
        let most = MAX_TIMES.min(MAX_POSES / bodies).max(2);
        let curve = &outcome.curve;
        // The sum of durations may differ from the time of the curve by rounding.
        let count_to = |cycles: usize| {
            let end = cycle * cycles as f64 * (1.0 + 1e-9);
            curve.partition_point(|(time, _)| *time <= end)
        };
        let all = (gait.cycles as usize).max(1);
        let cycles = (2..=all)
            .take_while(|cycles| count_to(*cycles) <= most)
            .last()
            .unwrap_or(1);
        let count = count_to(cycles);
        let stride = count.div_ceil(most).max(1);
        let mut steps: Vec<usize> = (0..count).step_by(stride).collect();
        if let Some(last) = count
            .checked_sub(1)
            .filter(|last| steps.last() != Some(last))
        {
            steps.push(last);
        }
        let times: Vec<f64> = steps.iter().map(|&k| curve[k].0).collect();
        let passive: Vec<usize> = (scene.articulation().passive_drives())
            .map(|(joint, _)| joint)
            .collect();
        let mut spans = spans(gait, scene.articulation().initial_shape())?.peekable();
        let (mut rotations, mut joints) = (Vec::new(), Vec::new());
        for &time in &times {
            let (before, after, share) = around(&outcome.samples, time);
            let pairs = before.poses.iter().zip(&after.poses);
            let turned = pairs.map(|(a, b)| {
                let middle = a.rotation.try_slerp(&b.rotation, share, 1e-12);
                middle.unwrap_or(a.rotation)
            });
            rotations.push(turned.collect());
            while let Some(span) = spans.peek()
                && time > span.start + span.duration * (1.0 + 1e-12)
            {
                spans.next();
            }
            let mut values = match spans.peek() {
                Some(span) => span.shape(((time - span.start) / span.duration).clamp(0.0, 1.0)),
                None => after.shape.clone(),
            };
            for &joint in &passive {
                let (a, b) = (before.shape[joint], after.shape[joint]);
                values[joint] = a + share * (b - a);
            }
            joints.push(values);
        }
        Ok(Self {
            cycles,
            positions: steps.iter().map(|&k| curve[k].1.clone()).collect(),
            times,
            rotations,
            joints,
        })
    }
}

/// The samples before and after a time, and the fraction of the interval at that time.
fn around(samples: &[Sample], time: f64) -> (&Sample, &Sample, f64) {
    let after = samples.partition_point(|sample| sample.time < time);
    let after = after.min(samples.len() - 1);
    let (before, after) = (&samples[after.saturating_sub(1)], &samples[after]);
    let width = after.time - before.time;
    let share = if width > 0.0 {
        (time - before.time) / width
    } else {
        1.0
    };
    (before, after, share.clamp(0.0, 1.0))
}
