//! The flow in a plane: speed or viscosity as colour, streamlines, bodies.

use std::ops::Range;

use nalgebra::{Isometry3, Point3, Translation3, Vector3};
use plotters::prelude::*;
use scene::{Body, Scene};

use super::canvas::{self, Raster};
use super::colour_bar::{BarSpace, draw_colour_bar, logarithmic_labels};
use super::style::{Area, GRID_COLOUR, INK, at, direction_name, font, px, short, viridis};
use crate::error::PictureError;
use crate::flow_slice::{
    FlowSlice, SlicePlane, Streamline, body_surface, is_beyond_wall, is_inside, section,
    streamlines, wall_lines, walls_of_file,
};

/// Width of the picture in pixels.
const WIDTH: u32 = 960;

/// Space for title, axes and colour bar in pixels: left, right, above, below.
const SPACE: [u32; 4] = [76, 124, 52, 48];

/// Distance of streamlines relative to the width of the window.
const LINE_DISTANCE: f64 = 0.022;

/// Largest number of characters of the name of a scene in the title.
const MAX_NAME_LENGTH: usize = 48;

/// Colour of streamlines and their outlines.
const LINE_COLOUR: RGBColor = RGBColor(255, 255, 255);

/// Bodies with their shapes and poses at one time.
#[derive(Clone, Copy)]
pub struct PlacedBodies<'a> {
    pub bodies: &'a [Body],
    pub poses: &'a [Isometry3<f64>],
}

/// The quantity whose values are colours.
struct Colours {
    name: &'static str,
    /// Its values at the grid points.
    values: Vec<Option<f64>>,
    /// Values of the first and the last colour.
    range: [f64; 2],
    /// Whether equal ratios are equal steps of colours.
    is_logarithmic: bool,
}

impl Colours {
    /// Speeds up to the largest one.
    fn of_speed(slice: &FlowSlice, largest: f64) -> Self {
        Self {
            name: "speed",
            values: slice.extrapolated(slice.speeds()),
            // A flow at rest needs some axis.
            range: [0.0, if largest > 0.0 { largest } else { 1.0 }],
            is_logarithmic: false,
        }
    }

    /// Viscosities from the smallest to the largest one; none if there are none or one only.
    fn of_viscosity(slice: &FlowSlice) -> Option<Self> {
        let viscosities = slice.viscosities.as_ref()?;
        let all = || viscosities.iter().flatten().copied();
        let range = [
            all().fold(f64::INFINITY, f64::min),
            all().fold(0.0, f64::max),
        ];
        (range[0] > 0.0 && range[0] < range[1] && range[1].is_finite()).then(|| Self {
            name: "viscosity",
            values: slice.extrapolated(viscosities.clone()),
            range,
            is_logarithmic: true,
        })
    }

    /// Coordinate of a value on the axis of the colour bar, which has colours at even distances.
    fn coordinate(&self, value: f64) -> f64 {
        match self.is_logarithmic {
            true => value.log10(),
            false => value,
        }
    }

    /// Value at a coordinate.
    fn value(&self, coordinate: f64) -> f64 {
        match self.is_logarithmic {
            true => 10_f64.powf(coordinate),
            false => coordinate,
        }
    }

    /// Place of a value between both ends of the colours, from 0 to 1.
    fn place(&self, value: f64) -> f64 {
        let [low, high] = self.range.map(|end| self.coordinate(end));
        (self.coordinate(value) - low) / (high - low)
    }
}

/// Draws the flow in a plane as SVG text: as colour the speed, or the viscosity where it varies,
/// streamlines of the velocity in the plane, and the bodies at these poses.
///
/// # Errors
/// [`PictureError::Plot`] with the reason given by the plotting library.
pub fn flow_svg(
    scene: &Scene,
    poses: &[Isometry3<f64>],
    slice: &FlowSlice,
) -> Result<String, PictureError> {
    let (name, plane) = (shortened(scene.name()), plane_name(&slice.plane));
    let title = format!("{name}: flow at the start, plane {plane}");
    let bodies = scene.bodies_at(scene.articulation().initial_shape());
    let placed = PlacedBodies {
        bodies: &bodies,
        poses,
    };
    let colours = Colours::of_viscosity(slice)
        .unwrap_or_else(|| Colours::of_speed(slice, slice.largest_speed()));
    draw(scene, placed, slice, &title, &colours)
}

/// The flow with another title, and the colours of speeds up to `largest`.
///
/// # Errors
/// As [`flow_svg`].
pub fn flow_frame(
    scene: &Scene,
    placed: PlacedBodies,
    slice: &FlowSlice,
    title: &str,
    largest: f64,
) -> Result<String, PictureError> {
    draw(
        scene,
        placed,
        slice,
        title,
        &Colours::of_speed(slice, largest),
    )
}

fn draw(
    scene: &Scene,
    placed: PlacedBodies,
    slice: &FlowSlice,
    title: &str,
    colours: &Colours,
) -> Result<String, PictureError> {
    let plane = &slice.plane;
    let inner = WIDTH - SPACE[0] - SPACE[1];
    let height = f64::from(inner) * plane.height / plane.width;
    let size = (WIDTH, height.round() as u32 + SPACE[2] + SPACE[3]);
    let mut window = (0..1, 0..1);
    let svg = canvas::transparent_svg(size, |root| {
        let (left, right) = root.split_horizontally(px(WIDTH - SPACE[1]));
        window = draw_window(&left, scene, placed, slice, title)?;
        draw_bar(&right, colours)
    })?;
    canvas::over_raster(&svg, &raster(scene, slice, colours), window)
}

/// A name with as many characters as fit into a title.
pub fn shortened(name: &str) -> String {
    let mut short: String = name.chars().take(MAX_NAME_LENGTH).collect();
    if short.len() < name.len() {
        short.push_str("...");
    }
    short
}

/// Axes, streamlines and bodies; returns the pixels of the window.
fn draw_window(
    area: &Area,
    scene: &Scene,
    placed: PlacedBodies,
    slice: &FlowSlice,
    title: &str,
) -> Result<(Range<i32>, Range<i32>), Box<dyn std::error::Error>> {
    let plane = &slice.plane;
    let [right, up] = [plane.right, plane.up].map(|e| match direction_name(&e) {
        name if name.len() == 1 => name,
        vector => format!("along {vector}"),
    });
    let title = Text::new(title.to_owned(), at(SPACE[0], 14), font(18, &INK));
    area.draw(&title)?;
    area.draw(&Text::new(up, at(14, SPACE[2] - 20), font(14, &INK)))?;
    let (_, area) = area.split_vertically(px(SPACE[2]));
    let range = |e: &Vector3<f64>, side: f64| {
        let middle = plane.centre.dot(e);
        middle - 0.5 * side..middle + 0.5 * side
    };
    let (x, y) = (
        range(&plane.right, plane.width),
        range(&plane.up, plane.height),
    );
    let mut chart = ChartBuilder::on(&area)
        .x_label_area_size(px(SPACE[3]))
        .y_label_area_size(px(SPACE[0]))
        .build_cartesian_2d(x.clone(), y.clone())?;
    chart
        .configure_mesh()
        .disable_mesh()
        .axis_style(INK.stroke_width(px(1)))
        .set_all_tick_mark_size(px(5))
        .label_style(font(14, &INK))
        .x_desc(format!("{right} (the scene's unit of length)"))
        .x_label_formatter(&|v| short(*v))
        .y_label_formatter(&|v| short(*v))
        .draw()?;
    let place = |[a, b]: [f64; 2]| (x.start + a * plane.width, y.start + b * plane.height);
    for line in streamlines(slice, LINE_DISTANCE) {
        let points = || line.iter().map(|p| place(*p));
        let outline = INK.mix(0.35).stroke_width(px(2));
        chart.draw_series(LineSeries::new(points(), outline))?;
        chart.draw_series(LineSeries::new(points(), LINE_COLOUR.stroke_width(px(1))))?;
        if let Some(head) = arrow_head(&line, plane) {
            chart.draw_series([Polygon::new(head.map(place).to_vec(), LINE_COLOUR.filled())])?;
        }
    }
    for piece in wall_lines(scene.domain(), plane) {
        let line = LineSeries::new(piece.map(place), INK.stroke_width(px(2)));
        chart.draw_series(line)?;
    }
    // Tubes that wind out of the plane, in front of the flow.
    let per_length = f64::from(px(WIDTH - SPACE[0] - SPACE[1])) / plane.width;
    for (body, pose) in placed.bodies.iter().zip(placed.poses) {
        let centreline = body.shape.centreline();
        // Heads of tubes are cut where their tails are.
        let radius = centreline
            .iter()
            .fold(f64::INFINITY, |r, (_, radius)| r.min(*radius));
        if centreline.is_empty() {
            continue;
        }
        let points = centreline
            .iter()
            .map(|(x, _)| (pose * Point3::from(*x)).coords);
        let points = points.map(|x| place(plane.coordinates(&x)));
        let width = (2.0 * radius * per_length).round() as u32;
        let style = GRID_COLOUR.mix(0.5).stroke_width(width);
        chart.draw_series(LineSeries::new(points, style))?;
    }
    for (body, pose) in placed.bodies.iter().zip(placed.poses) {
        let Some(surface) = body_surface(&body.shape) else {
            continue;
        };
        let shifts = images(scene, plane, pose, body.bounding_radius());
        let poses = shifts.map(|shift| Translation3::from(shift) * pose);
        for curve in poses.flat_map(|pose| section(&surface, &pose, plane)) {
            let mut corners: Vec<_> = curve.into_iter().map(place).collect();
            chart.draw_series([Polygon::new(corners.clone(), GRID_COLOUR.filled())])?;
            corners.extend(corners.first().copied());
            chart.draw_series(LineSeries::new(corners, INK.stroke_width(px(1))))?;
        }
    }
    Ok(chart.plotting_area().get_pixel_range())
}

/// Shifts to the places at which a body with a ball of this radius around it may be seen in the
/// window: none but zero, or those of all of its images in a periodic box.
fn images(
    scene: &Scene,
    plane: &SlicePlane,
    pose: &Isometry3<f64>,
    radius: f64,
) -> impl Iterator<Item = Vector3<f64>> {
    let period = scene.domain().period();
    let offset = pose.translation.vector - plane.centre;
    let normal = plane.normal();
    let reach = radius + 0.5 * plane.width.hypot(plane.height);
    let along = |axis: usize| match period {
        Some(size) => {
            let [least, most] = [-reach, reach].map(|end| (end - offset[axis]) / size[axis]);
            least.ceil() as i64..=most.floor() as i64
        }
        None => 0..=0,
    };
    let size = period.unwrap_or_default();
    let [x, y, z] = [0, 1, 2].map(along);
    let numbers = x.flat_map(move |i| {
        let z = z.clone();
        y.clone()
            .flat_map(move |j| z.clone().map(move |k| [i, j, k]))
    });
    let shifts = numbers.map(move |n| Vector3::from(n.map(|n| n as f64)).component_mul(&size));
    shifts.filter(move |shift| period.is_none() || (offset + shift).dot(&normal).abs() <= radius)
}

/// The colour bar below the name of the quantity.
fn draw_bar(area: &Area, colours: &Colours) -> Result<(), Box<dyn std::error::Error>> {
    let [low, high] = colours.range.map(|end| colours.coordinate(end));
    area.draw(&Text::new(colours.name, at(24, 18), font(14, &INK)))?;
    let (_, area) = area.split_vertically(px(SPACE[2]));
    let space = BarSpace {
        left: 24,
        above: 0,
        below: SPACE[3],
        labels: 76,
        font: 14,
    };
    let label = |coordinate: f64| short(colours.value(coordinate));
    let labels = match colours.is_logarithmic {
        true => logarithmic_labels(&(low..high)),
        false => None,
    };
    draw_colour_bar(&area, &space, low..high, viridis, (&label, labels))
}

/// The colours of the values, from above; none beyond walls, where values are extrapolated.
fn raster(scene: &Scene, slice: &FlowSlice, colours: &Colours) -> Raster {
    let of_file = walls_of_file(scene.domain(), &slice.plane);
    let place = |k: usize, count: usize| k as f64 / (count.max(2) - 1) as f64;
    let pixels = (0..slice.rows)
        .rev()
        .flat_map(|row| (0..slice.columns).map(move |c| (row, c)));
    let pixels = pixels.flat_map(|(row, column)| {
        let at = [place(column, slice.columns), place(row, slice.rows)];
        let number = row * slice.columns + column;
        let is_fluid = || slice.values[number].is_some() || is_inside(&of_file, at);
        let is_shown = !is_beyond_wall(scene.domain(), &slice.plane.point(at))
            && (of_file.is_empty() || is_fluid());
        match colours.values[number].filter(|_| is_shown) {
            Some(value) => {
                let RGBColor(red, green, blue) = viridis(colours.place(value));
                [red, green, blue, 255]
            }
            None => [255, 255, 255, 0],
        }
    });
    Raster {
        columns: slice.columns,
        rows: slice.rows,
        colours: pixels.collect(),
    }
}

/// An arrow head in the middle of a streamline; none for a line without a direction there.
fn arrow_head(line: &Streamline, plane: &SlicePlane) -> Option<[[f64; 2]; 3]> {
    // Half of its width, relative to the width of the window: three pixels.
    const HALF_WIDTH: f64 = 0.0042;
    let middle = line.len() / 2;
    let [from, to] = [line.get(middle.checked_sub(1)?)?, line.get(middle)?];
    let aspect = plane.height / plane.width;
    let along =
        Vector3::new(to[0] - from[0], (to[1] - from[1]) * aspect, 0.0).try_normalize(0.0)?;
    let corner = |ahead: f64, aside: f64| {
        let [ahead, aside] = [ahead, aside].map(|length| length * HALF_WIDTH);
        [
            to[0] + ahead * along.x - aside * along.y,
            to[1] + (ahead * along.y + aside * along.x) / aspect,
        ]
    };
    Some([corner(2.2, 0.0), corner(-1.2, 1.0), corner(-1.2, -1.0)])
}

/// The name of a plane: `z = 0`, or a normal and the distance from the origin.
fn plane_name(plane: &SlicePlane) -> String {
    let normal = plane.normal();
    let normal = normal * normal[normal.iamax()].signum();
    let mut height = plane.centre.dot(&normal);
    if height.abs() < 1e-6 * plane.width {
        height = 0.0;
    }
    match direction_name(&normal) {
        name if name.len() == 1 => format!("{name} = {}", short(height)),
        vector => format!("normal to {vector}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bug_periodic_images_of_bodies_were_holes_in_the_flow() {
        let plane = SlicePlane {
            centre: Vector3::zeros(),
            right: Vector3::x(),
            up: Vector3::y(),
            width: 8.0,
            height: 8.0,
        };
        let shifts = |domain: &str, height: f64| {
            let scene = Scene::parse(&format!(
                "domain = {domain}\nbodies = [{{ name = \"a\", radius = 1, \
                 position = [4.5, 0, {height:?}], force = [1, 0, 0] }}]"
            ));
            let scene = scene.unwrap();
            let pose = Isometry3::translation(4.5, 0.0, height);
            images(&scene, &plane, &pose, 1.0).collect::<Vec<_>>()
        };
        let periodic = "{ kind = \"periodic\", size = [10, 10, 10] }";
        let left = Vector3::new(-10.0, 0.0, 0.0);
        assert_eq!(shifts(periodic, 0.5), [left, Vector3::zeros()]);
        // Neither the body nor an image of it reaches the plane.
        assert!(shifts(periodic, 2.0).is_empty());
        let once = [Vector3::zeros()];
        assert_eq!(shifts("{ kind = \"unbounded\" }", 2.0), once);
    }
}
