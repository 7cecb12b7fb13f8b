//! The flow in a plane at the start of a scene.

use models::Hydrodynamics;
use scene::Scene;
use swimmer::start_flow_at;

use super::{FlowSlice, SliceFrame};
use crate::error::PictureError;

/// The flow in the plane of [`SliceFrame`] at the start of the scene, at about `points` points.
///
/// # Errors
/// As [`start_flow`].
pub fn start_slice(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    points: usize,
) -> Result<FlowSlice, PictureError> {
    let set = scene.articulation();
    let poses = set.place(&scene.initial_state(), set.initial_shape())?;
    let plane = SliceFrame::of(scene)?.around(scene, &poses);
    Ok(FlowSlice::sample(plane, points, |points| {
        start_flow_at(scene, model, points)
    })?)
}
