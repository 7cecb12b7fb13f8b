//! Plots: `trajectory.svg` (displacements against time above, the bodies at the ends of phases
//! below), and those of the design of strokes.

mod canvas;
mod curves;
mod height_map;
mod learning;
mod snapshots;
mod style;

pub use height_map::height_map_svg;
pub use learning::{learning_curve_svg, policy_svg};

use nalgebra::Vector3;
use plotters::prelude::*;
use scene::Scene;

use crate::error::SwimError;
use crate::outcome::Outcome;
use style::{Area, SIZE, px};

/// Draws the trajectory as SVG text.
///
/// # Errors
/// [`SwimError::Plot`] with the reason given by the plotting library.
pub fn trajectory_svg(scene: &Scene, outcome: &Outcome) -> Result<String, SwimError> {
    canvas::svg(SIZE, |root| draw(root, scene, outcome))
}

fn draw(root: &Area, scene: &Scene, outcome: &Outcome) -> Result<(), Box<dyn std::error::Error>> {
    root.fill(&WHITE)?;
    let (above, below) = root.split_vertically(px(460));
    let axis = swimmer_axis(outcome);
    curves::draw(&above, scene, outcome, &axis)?;
    snapshots::draw(&below, scene, outcome, &axis)?;
    root.present()?;
    Ok(())
}

/// The line of collinear bodies, or the direction of the net displacement.
fn swimmer_axis(outcome: &Outcome) -> Vector3<f64> {
    let start = outcome.curve.first().map_or(&[][..], |(_, x)| x);
    let longest = start
        .iter()
        .skip(1)
        .map(|x| x - start[0])
        .max_by(|a, b| a.norm().total_cmp(&b.norm()));
    let collinear = |e: &Vector3<f64>| {
        start
            .iter()
            .all(|x| (x - start[0]).cross(e).norm() <= 1e-9 * e.norm().powi(2))
    };
    let net = outcome.displacement.iter().sum::<Vector3<f64>>();
    let direction = match longest {
        Some(e) if collinear(&e) => e,
        _ => net,
    };
    // The largest component is positive, so that x points to the right.
    let sign = direction[direction.iamax()].signum();
    direction
        .try_normalize(0.0)
        .map_or(Vector3::x(), |e| sign * e)
}
