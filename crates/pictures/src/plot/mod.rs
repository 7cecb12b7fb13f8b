//! Plots: `trajectory.svg` (displacements or angles against time above, the bodies at some times
//! below), the flow in a plane, and those of the design of strokes.

mod canvas;
mod colour_bar;
mod curves;
mod flow_picture;
mod height_map;
mod learning;
mod movie;
mod quantity;
mod sizes;
mod snapshots;
mod style;
mod sweep;

pub use flow_picture::flow_svg;
pub use height_map::height_map_svg;
pub use learning::{Policy, learning_curve_svg, policy_svg};
pub(crate) use movie::{MovieFrame, movie_svg};
pub(crate) use quantity::Quantity;
pub use sizes::{SliceCurve, size_slices_svg};
pub(crate) use snapshots::nearest_in_time;
pub(crate) use style::body_colour;
pub use style::direction_name;
pub use sweep::{SweptPoints, sweep_svg};

use scene::Scene;

use crate::error::PictureError;
use style::{Area, SIZE, px};
use swimmer::Outcome;

/// Draws the trajectory as SVG text.
///
/// # Errors
/// [`PictureError::Plot`] with the reason given by the plotting library.
pub fn trajectory_svg(scene: &Scene, outcome: &Outcome) -> Result<String, PictureError> {
    canvas::svg(SIZE, |root| draw(root, scene, outcome))
}

fn draw(root: &Area, scene: &Scene, outcome: &Outcome) -> Result<(), Box<dyn std::error::Error>> {
    let (above, below) = root.split_vertically(px(460));
    let quantity = Quantity::new(scene, outcome);
    curves::draw(&above, scene, outcome, &quantity)?;
    snapshots::draw(&below, scene, outcome, &quantity)?;
    Ok(())
}
