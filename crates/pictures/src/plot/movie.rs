//! The flow in a plane over a cycle, as one animated picture.

use std::fmt::Write;

use nalgebra::Isometry3;
use scene::Scene;

use super::flow_picture::{PlacedBodies, flow_frame, shortened};
use super::style::short;
use crate::error::PictureError;
use crate::flow_slice::FlowSlice;

/// Duration of a cycle in seconds.
const SECONDS: f64 = 6.0;

/// The flow in a plane at one time.
pub struct MovieFrame {
    pub time: f64,
    pub poses: Vec<Isometry3<f64>>,
    pub slice: FlowSlice,
    /// Values of the joints.
    pub shape: Vec<f64>,
}

/// Draws frames as an SVG that shows one after the other, by rules of CSS and without a script.
///
/// Each frame is shown around its time, in proportion to the duration `cycle`, and all have the
/// same colours of speeds. Viewers without animation, and readers who prefer less motion, see the
/// first.
///
/// # Errors
/// Those of [`super::flow_picture::flow_svg`].
pub fn movie_svg(
    name: &str,
    scene: &Scene,
    frames: &[MovieFrame],
    cycle: f64,
) -> Result<String, PictureError> {
    let speeds = frames.iter().map(|frame| frame.slice.largest_speed());
    let largest = speeds.fold(0.0, f64::max);
    let (mut rules, mut pictures, mut size) = (String::new(), String::new(), String::new());
    let mut from = 0.0;
    for (k, frame) in frames.iter().enumerate() {
        let title = format!("{}: t = {}", shortened(name), short(frame.time));
        let bodies = scene.bodies_at(&frame.shape);
        let placed = PlacedBodies {
            bodies: &bodies,
            poses: &frame.poses,
        };
        let picture = flow_frame(scene, placed, &frame.slice, &title, largest)?;
        let to = match frames.get(k + 1) {
            Some(next) => 50.0 * (frame.time + next.time) / cycle,
            None => 100.0,
        };
        // Formatting into a string does not fail.
        let _ = writeln!(
            rules,
            "@keyframes f{k} {{ 0% {{ visibility: hidden }} {from:.3}% {{ visibility: visible }} \
             {to:.3}% {{ visibility: hidden }} 100% {{ visibility: hidden }} }}\n\
             .f{k} {{ animation-name: f{k} }}"
        );
        if k == 0 {
            let [width, height] = ["width", "height"].map(|name| number(&picture, name));
            size =
                format!("width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\"");
        }
        let _ = writeln!(pictures, "<g class=\"frame f{k}\">{picture}</g>");
        from = to;
    }
    Ok(format!(
        "<svg {size} xmlns=\"http://www.w3.org/2000/svg\">\n<style>\n\
         .frame {{ visibility: hidden; animation: {SECONDS}s step-end infinite }}\n\
         .f0 {{ visibility: visible }}\n{rules}\
         @media (prefers-reduced-motion: reduce) {{ .frame {{ animation-name: none }} }}\n\
         </style>\n{pictures}</svg>\n"
    ))
}

/// The value of an attribute of the first element of a picture.
fn number<'a>(picture: &'a str, name: &str) -> &'a str {
    let from = picture.split_once(&format!("{name}=\""));
    let value = from.and_then(|(_, rest)| rest.split_once('"'));
    value.map_or("", |(value, _)| value)
}
