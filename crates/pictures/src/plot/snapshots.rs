//! The lower half of the plot: the bodies at the ends of phases, or at some times of a single one.

use nalgebra::{Isometry3, Point3, Vector3};
use plotters::prelude::*;
use scene::{Scene, Shape};
use swimmer::{Outcome, Sample};

use super::quantity::Quantity;
use super::style::{Area, COLOURS, GREY, INK, at, font, px, short};
use crate::flow_slice::{SlicePlane, wall_lines};

/// Largest number of snapshots: more would be too small.
const MAX_SNAPSHOTS: usize = 5;

/// Draws the start, the ends of the first phases and the end, all with the same scale.
pub(super) fn draw(
    area: &Area,
    scene: &Scene,
    outcome: &Outcome,
    quantity: &Quantity,
) -> Result<(), Box<dyn std::error::Error>> {
    let Some(shots) = shots(scene, outcome) else {
        return Ok(());
    };
    let plane = match scene.domain().period() {
        Some(_) => along_edges(quantity.plane(scene, outcome)),
        None => quantity.plane(scene, outcome),
    };
    let shots: Vec<(String, Sample)> = shots
        .into_iter()
        .map(|(name, sample)| (name, in_box(scene, sample)))
        .collect();
    let flat = |x: &Vector3<f64>| (x.dot(&plane[0]), x.dot(&plane[1]));
    // Bounding rectangle of the bodies in all snapshots.
    let (mut left, mut right, mut low, mut high) = (f64::MAX, f64::MIN, f64::MAX, f64::MIN);
    for (_, sample) in &shots {
        for (body, pose) in scene.bodies_at(&sample.shape).iter().zip(&sample.poses) {
            let ((x, y), r) = (flat(&pose.translation.vector), body.bounding_radius());
            (left, right) = (left.min(x - r), right.max(x + r));
            (low, high) = (low.min(y - r), high.max(y + r));
        }
    }
    let walls = walls_around(scene, &shots, &plane, [[left, right], [low, high]]);
    for x in walls.iter().flatten() {
        let (x, y) = flat(x);
        (left, right) = (left.min(x), right.max(x));
        (low, high) = (low.min(y), high.max(y));
    }
    let (width, height) = area.dim_in_pixel();
    let (top, label) = (f64::from(px(34)), f64::from(px(24)));
    let (width, height) = (f64::from(width), f64::from(height) - top);
    // Side by side or one above the other, for the larger scale; each with a line of text above.
    let scale_of = |columns: usize, rows: usize| {
        let cell = (width / columns as f64, height / rows as f64 - label);
        (0.9 * cell.0 / (right - left)).min(0.9 * cell.1 / (high - low))
    };
    let count = shots.len();
    let is_beside = scale_of(count, 1) > scale_of(1, count);
    let (columns, lines) = if is_beside { (count, 1) } else { (1, count) };
    let scale = scale_of(columns, lines);
    let (cell_width, cell_height) = (width / columns as f64, height / lines as f64);
    area.draw(&Text::new(
        "the bodies, to scale",
        at(14, 8),
        font(16, &INK),
    ))?;
    for (number, (name, sample)) in shots.iter().enumerate() {
        let corner = (
            cell_width * (number % columns) as f64,
            top + cell_height * (number / columns) as f64,
        );
        let centre = (
            corner.0 + 0.5 * cell_width,
            corner.1 + label + 0.5 * (cell_height - label),
        );
        let pixel = |x: &Vector3<f64>| {
            let (x, y) = flat(x);
            (
                (centre.0 + scale * (x - 0.5 * (left + right))).round() as i32,
                (centre.1 - scale * (y - 0.5 * (low + high))).round() as i32,
            )
        };
        let (x, y) = at(14, 4);
        let place = (corner.0 as i32 + x, corner.1 as i32 + y);
        area.draw(&Text::new(name.clone(), place, font(13, &GREY)))?;
        for piece in &walls {
            let ends = [pixel(&piece[0]), pixel(&piece[1])];
            area.draw(&PathElement::new(ends, INK.stroke_width(px(1))))?;
        }
        // In a periodic box the paths leave the picture.
        let with_paths = match scene.domain().period() {
            Some(_) => 0,
            None => scene.bodies().len(),
        };
        for body in 0..with_paths {
            let path = outcome
                .curve
                .iter()
                .take_while(|(time, _)| *time <= sample.time);
            let path = path.filter_map(|(_, centres)| Some(pixel(centres.get(body)?)));
            let colour = COLOURS[body % COLOURS.len()].mix(0.5);
            let mut path: Vec<_> = path.collect();
            path.dedup();
            area.draw(&PathElement::new(path, colour.stroke_width(px(1))))?;
        }
        draw_shot(area, scene, sample, &plane, scale, pixel)?;
    }
    Ok(())
}

/// Draws joints and bodies; `pixel` gives the place of a point.
fn draw_shot(
    area: &Area,
    scene: &Scene,
    sample: &Sample,
    [axis, across]: &[Vector3<f64>; 2],
    scale: f64,
    pixel: impl Fn(&Vector3<f64>) -> (i32, i32),
) -> Result<(), Box<dyn std::error::Error>> {
    let at = |body: usize| pixel(&sample.poses[body].translation.vector);
    for joint in scene.articulation().joints() {
        let arm = [at(joint.body), at(joint.to)];
        area.draw(&PathElement::new(arm, GREY.stroke_width(px(2))))?;
    }
    let bodies = scene.bodies_at(&sample.shape);
    for (body, shape) in bodies.iter().map(|body| &body.shape).enumerate() {
        let colour = COLOURS[body % COLOURS.len()];
        let least = f64::from(px(2));
        let disc = |at: (i32, i32), radius: f64| {
            let radius = (scale * radius).max(least).round() as i32;
            area.draw(&Circle::new(at, radius, colour.filled()))
        };
        let (pose, centreline) = (&sample.poses[body], shape.centreline());
        if shape.is_isotropic() {
            disc(at(body), shape.bounding_radius())?;
        } else if centreline.is_empty() {
            let outline = outline(shape, pose, axis, across);
            let corners: Vec<_> = outline.map(|x| pixel(&x)).collect();
            area.draw(&Polygon::new(corners, colour.filled()))?;
        }
        for (x, radius) in centreline {
            disc(pixel(&(pose * Point3::from(x)).coords), radius)?;
        }
    }
    for (body, pose) in scene.bodies().iter().zip(&sample.poses) {
        let Some(slip) = &body.slip else { continue };
        // The axis of a squirmer, to the end at which it swims without others.
        let end = pose.rotation * slip.axis * (0.8 * slip.b1.signum() * body.shape.size_radius());
        let [from, to] = [-end, end].map(|x| pixel(&(pose.translation.vector + x)));
        let style = WHITE.stroke_width(px(2));
        area.draw(&PathElement::new([from, to], style))?;
        area.draw(&Circle::new(to, px(3) as i32, WHITE.filled()))?;
    }
    Ok(())
}

/// Coordinate axes near two directions, in the order of the directions.
fn along_edges([right, up]: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    let first = right.iamax();
    let mut rest = up.abs();
    rest[first] = -1.0;
    [first, rest.imax()].map(|axis| Vector3::ith(axis, 1.0))
}

/// A sample with each linkage shifted such that its first body is in the periodic box.
fn in_box(scene: &Scene, sample: &Sample) -> Sample {
    let mut sample = sample.clone();
    for linkage in scene.articulation().linkages() {
        let Some(first) = linkage.bodies.first() else {
            continue;
        };
        let place = sample.poses[*first].translation.vector;
        let shift = scene.domain().nearest_image(&place) - place;
        for &body in &linkage.bodies {
            sample.poses[body].translation.vector += shift;
        }
    }
    sample
}

/// Pieces of the walls of the domain, or the edges of a periodic box.
///
/// The walls are those beside the bodies, within a length of the rectangle
/// `[[left, right], [low, high]]` around them, in space.
fn walls_around(
    scene: &Scene,
    shots: &[(String, Sample)],
    [right, up]: &[Vector3<f64>; 2],
    [[left, end], [low, high]]: [[f64; 2]; 2],
) -> Vec<[Vector3<f64>; 2]> {
    if let Some(size) = scene.domain().period() {
        let [right, up] = [right, up].map(|e| 0.5 * size.component_mul(e));
        let corners = [-right - up, right - up, right + up, up - right];
        return [0, 1, 2, 3]
            .map(|k| [corners[k], corners[(k + 1) % 4]])
            .into();
    }
    let poses = shots.iter().flat_map(|(_, sample)| &sample.poses);
    let (count, sum) = poses.fold((0.0, Vector3::zeros()), |(count, sum), pose| {
        (count + 1.0, sum + pose.translation.vector)
    });
    let normal = right.cross(up);
    let depth = (sum / f64::max(count, 1.0)).dot(&normal);
    let margin = 0.5 * (end - left).max(high - low);
    let plane = SlicePlane {
        centre: 0.5 * (left + end) * right + 0.5 * (low + high) * up + depth * normal,
        right: *right,
        up: *up,
        width: end - left + 2.0 * margin,
        height: high - low + 2.0 * margin,
    };
    let in_space = |[a, b]: [f64; 2]| {
        let [a, b] = [(a - 0.5) * plane.width, (b - 0.5) * plane.height];
        plane.centre + a * right + b * up
    };
    let pieces = wall_lines(scene.domain(), &plane);
    pieces
        .into_iter()
        .map(|piece| piece.map(in_space))
        .collect()
}

/// Names and samples: the start, the ends of the first phases and the end, or, for a single phase,
/// times at about equal distances.
fn shots<'a>(scene: &Scene, outcome: &'a Outcome) -> Option<Vec<(String, &'a Sample)>> {
    let phases = scene.gait().phases.len();
    let is_end = |sample: &&Sample| sample.bodies.is_none();
    let ends: Vec<&Sample> = outcome.samples.iter().filter(is_end).collect();
    let (&last, first) = ends.split_last()?;
    let mut shots: Vec<(String, &Sample)> = if ends.len() > 2 {
        let first = first.iter().take(phases.min(MAX_SNAPSHOTS - 1)).enumerate();
        let name = |k| match k {
            0 => "start".to_owned(),
            k => format!("after phase {k}"),
        };
        first.map(|(k, sample)| (name(k), *sample)).collect()
    } else {
        let times =
            (0..MAX_SNAPSHOTS - 1).map(|k| last.time * k as f64 / (MAX_SNAPSHOTS - 1) as f64);
        let nearest = times.filter_map(|time| nearest_in_time(&outcome.samples, time));
        nearest
            .map(|sample| (format!("time {}", short(sample.time)), sample))
            .collect()
    };
    shots.dedup_by(|a, b| a.1.time == b.1.time);
    shots.push(("end".to_owned(), last));
    Some(shots)
}

/// The outline of a convex body projected onto the plane of `axis` and `across`.
fn outline<'a>(
    shape: &'a Shape,
    pose: &'a Isometry3<f64>,
    axis: &'a Vector3<f64>,
    across: &'a Vector3<f64>,
) -> impl Iterator<Item = Vector3<f64>> + 'a {
    const CORNERS: usize = 48;
    (0..CORNERS).map(move |k| {
        let angle = std::f64::consts::TAU * k as f64 / CORNERS as f64;
        let direction = axis * angle.cos() + across * angle.sin();
        pose.translation.vector + shape.support_point(&pose.rotation, &direction)
    })
}

/// The sample whose time is nearest to a time, the first of equal ones.
pub fn nearest_in_time(samples: &[Sample], time: f64) -> Option<&Sample> {
    let off = |sample: &&Sample| (sample.time - time).abs();
    let samples = samples.iter();
    samples.min_by(|a, b| off(a).total_cmp(&off(b)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linkages_are_shifted_into_a_periodic_box_as_wholes() {
        let text = "domain = { kind = \"periodic\", size = [10, 20, 30] }\n\
            bodies = [{ name = \"a\", radius = 1, position = [4, 0, 0] },\n\
            { name = \"b\", radius = 1, position = [7, 0, 0] },\n\
            { name = \"c\", radius = 1, position = [1, 11, -44] }]\n\
            links = [{ name = \"arm\", body = \"b\", to = \"a\" }]\n\
            gait.phases = [{ link = \"arm\", length = 3.1 }]";
        let scene = Scene::parse(text).unwrap();
        let run = swimmer::run_without_files(scene.clone(), &mut ()).unwrap();
        let start = in_box(&scene, &run.outcome.samples[0]);
        let x = start.poses.iter().map(|pose| pose.translation.vector);
        let expected = [[4.0, 0.0, 0.0], [7.0, 0.0, 0.0], [1.0, -9.0, -14.0]];
        assert_eq!(x.collect::<Vec<_>>(), expected.map(Vector3::from));
        let oblique = [Vector3::new(0.1, -0.9, 0.4), Vector3::new(0.1, 0.8, 0.6)];
        assert_eq!(along_edges(oblique), [Vector3::y(), Vector3::z()]);
    }
}
