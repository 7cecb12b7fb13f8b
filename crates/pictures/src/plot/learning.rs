//! Learning curves, and policies as graphs.

use std::f64::consts::{FRAC_PI_2, TAU};

use plotters::prelude::*;

use super::canvas;
use super::style::{Area, COLOURS, GREY, INK, SIZE, font, grid_style, px};
use crate::error::PictureError;

/// Draws the mean reward of a step against the episode, with that of the best cycle.
///
/// # Errors
/// [`PictureError::Plot`].
pub fn learning_curve_svg(curve: &[f64], best: f64) -> Result<String, PictureError> {
    canvas::svg((SIZE.0, 420), |root| {
        let low = curve.iter().copied().fold(0.0, f64::min);
        let high = curve.iter().copied().fold(best, f64::max).max(1e-300);
        let (low, high) = (low - 0.05 * (high - low), high + 0.1 * (high - low));
        let mut chart = ChartBuilder::on(root)
            .margin(px(14))
            .margin_right(px(28))
            .caption(
                "mean reward of a step, random steps included",
                font(18, &INK),
            )
            .x_label_area_size(px(46))
            .y_label_area_size(px(80))
            .build_cartesian_2d(0.0..curve.len().max(1) as f64, low..high)?;
        let mut axes = chart.configure_mesh();
        grid_style(&mut axes);
        axes.x_desc("episode")
            .y_desc("displacement per step")
            .draw()?;
        let points = curve.iter().enumerate().map(|(k, y)| (k as f64 + 0.5, *y));
        chart.draw_series(LineSeries::new(points, COLOURS[0].stroke_width(px(2))))?;
        let ends = [(0.0, best), (curve.len() as f64, best)];
        chart.draw_series(LineSeries::new(ends, COLOURS[1].stroke_width(px(2))))?;
        // Above the line, and right of the axis.
        let place = (0.01 * curve.len() as f64, best + 0.06 * (high - low));
        chart.draw_series([Text::new("best cycle", place, font(13, &COLOURS[1]))])?;
        Ok(())
    })
}

/// A learned policy: states are the shapes whose joints are contracted or extended, one bit per
/// joint, and an action changes one joint.
#[derive(Clone, Debug)]
pub struct Policy<'a> {
    /// Names of the states.
    pub names: &'a [String],
    /// The joint that changes in each state.
    pub actions: &'a [usize],
    /// States of the cycle that the policy follows.
    pub cycle: &'a [usize],
}

/// Draws the states on a circle, with an arrow for the learned action of each; those of the learned
/// cycle in colour.
///
/// # Errors
/// [`PictureError::Plot`].
pub fn policy_svg(policy: &Policy) -> Result<String, PictureError> {
    canvas::svg((620, 620), |root| draw_policy(root, policy))
}

fn draw_policy(root: &Area, policy: &Policy) -> Result<(), Box<dyn std::error::Error>> {
    let (centre, radius) = (f64::from(px(310)), f64::from(px(240)));
    let states = policy.names.len();
    // In the order of a Gray code, in which neighbours differ by one joint.
    let place = |state: usize| {
        let position = (0..states).find(|k| k ^ (k >> 1) == state).unwrap_or(0);
        let angle = TAU * position as f64 / states as f64 - FRAC_PI_2;
        (centre + radius * angle.cos(), centre + radius * angle.sin())
    };
    let pixel = |(x, y): (f64, f64)| (x.round() as i32, y.round() as i32);
    // Arrows end outside the circles of the states.
    let gap = f64::from(px(24));
    for (state, &action) in policy.actions.iter().enumerate() {
        let ((x, y), (to_x, to_y)) = (place(state), place(state ^ 1 << action));
        let length = (to_x - x).hypot(to_y - y);
        let (along, across) = (((to_x - x) / length), ((to_y - y) / length));
        let is_in_cycle = policy.cycle.contains(&state);
        let colour = if is_in_cycle { COLOURS[1] } else { GREY };
        let style = colour.stroke_width(px(if is_in_cycle { 3 } else { 1 }));
        // Beside the line between the states, so that two opposite arrows are both seen.
        let side = f64::from(px(5));
        let at = |distance: f64, beside: f64| {
            let beside = beside + side;
            pixel((
                x + distance * along - beside * across,
                y + distance * across + beside * along,
            ))
        };
        let (tip, head) = (length - gap, f64::from(px(9)));
        root.draw(&PathElement::new(vec![at(gap, 0.0), at(tip, 0.0)], style))?;
        let arrow = vec![
            at(tip - head, 0.6 * head),
            at(tip, 0.0),
            at(tip - head, -0.6 * head),
        ];
        root.draw(&PathElement::new(arrow, style))?;
    }
    for state in 0..states {
        let (x, y) = pixel(place(state));
        root.draw(&Circle::new((x, y), px(20), WHITE.filled()))?;
        root.draw(&Circle::new((x, y), px(20), INK.stroke_width(px(1))))?;
        let name = &policy.names[state];
        let half = (px(4) as usize * name.len()) as i32;
        root.draw(&Text::new(
            name.as_str(),
            (x - half, y - px(7) as i32),
            font(14, &INK),
        ))?;
    }
    Ok(())
}
