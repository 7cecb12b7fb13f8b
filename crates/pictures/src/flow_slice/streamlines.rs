//! Evenly spaced streamlines (Jobard & Lefer 1997).

use std::collections::{HashMap, VecDeque};

use super::grid::FlowSlice;

/// Distance from another line at which a line ends, relative to the distance of new lines.
const END_DISTANCE: f64 = 0.5;

/// Step along a line, in grid cells; interpolation is linear in a cell.
const STEP: f64 = 0.35;

/// Shortest line that is kept, relative to the distance of new lines.
const MIN_LENGTH: f64 = 1.5;

/// Largest number of steps in one direction.
const MAX_STEPS: usize = 4000;

/// Speed, relative to the largest one, below which the fluid counts as at rest.
const AT_REST: f64 = 1e-6;

/// A streamline: points in coordinates of the window, in the direction of the flow.
pub type Streamline = Vec<[f64; 2]>;

/// Streamlines of the in-plane velocity, about `distance` apart.
///
/// `distance` is in units of the width of the window. New lines start at this distance from
/// existing ones, and end where they are closer than half of it to another line or to an earlier
/// part of themselves. The first line starts where the flow is fastest. The result does not depend
/// on the number of threads.
pub fn streamlines(slice: &FlowSlice, distance: f64) -> Vec<Streamline> {
    let cells = [slice.columns - 1, slice.rows - 1].map(|n| n as f64);
    // In grid cells, which are square up to rounding.
    let distance = distance * cells[0];
    let mut tracer = Tracer {
        slice,
        least_speed: AT_REST * slice.largest_speed(),
        distance,
        near: HashMap::new(),
    };
    let mut lines = Vec::new();
    for seed in seeds(slice, distance) {
        let mut seeds = VecDeque::from([seed]);
        while let Some(seed) = seeds.pop_front() {
            let Some(line) = tracer.line(seed) else {
                continue;
            };
            let every = (0.5 * distance / STEP).ceil() as usize;
            for pair in line.windows(2).step_by(every.max(1)) {
                let [along, across] = [0, 1].map(|k| (pair[1][k] - pair[0][k]) / STEP);
                let [x, y] = pair[0];
                let beside = |d: f64| [x - d * across, y + d * along];
                seeds.extend([beside(distance), beside(-distance)]);
            }
            let to_window = |[x, y]: [f64; 2]| [x / cells[0], y / cells[1]];
            lines.push(line.into_iter().map(to_window).collect());
        }
    }
    lines
}

/// Starting points: that of largest speed, then a coarse grid for regions without a line.
fn seeds(slice: &FlowSlice, distance: f64) -> Vec<[f64; 2]> {
    let place = |k: usize| [(k % slice.columns) as f64, (k / slice.columns) as f64];
    let speed = |k: &usize| slice.values[*k].map_or(-1.0, |flow| flow.velocity.norm());
    let fastest = (0..slice.values.len())
        .filter(|k| slice.in_plane(place(*k)).is_some())
        .max_by(|a, b| speed(a).total_cmp(&speed(b)));
    let mut seeds: Vec<[f64; 2]> = fastest.into_iter().map(place).collect();
    let count = |points: usize| ((points - 1) as f64 / distance).ceil() as usize;
    let at = |k: usize| (k as f64 + 0.5) * distance;
    for row in 0..count(slice.rows) {
        seeds.extend((0..count(slice.columns)).map(|column| [at(column), at(row)]));
    }
    seeds
}

struct Tracer<'a> {
    slice: &'a FlowSlice,
    least_speed: f64,
    distance: f64,
    /// Points of all lines, by the square with side `distance` that contains them.
    near: HashMap<[i64; 2], Vec<[f64; 2]>>,
}

impl Tracer<'_> {
    /// Traces and records the line through a seed; `None` if it is too short.
    fn line(&mut self, seed: [f64; 2]) -> Option<Vec<[f64; 2]>> {
        if self.is_near(seed, self.distance * (1.0 - 1e-9)) {
            return None;
        }
        self.direction(seed, 1.0)?;
        let forwards = self.trace(seed, 1.0, &[]);
        let mut line = self.trace(seed, -1.0, &forwards);
        line.reverse();
        line.push(seed);
        line.extend(forwards);
        if (line.len() as f64) * STEP < MIN_LENGTH * self.distance {
            return None;
        }
        for point in &line {
            self.near
                .entry(self.square(*point))
                .or_default()
                .push(*point);
        }
        Some(line)
    }

    /// Points after the seed, downstream or upstream; `other` is the half that is already traced.
    fn trace(&self, seed: [f64; 2], sign: f64, other: &[[f64; 2]]) -> Vec<[f64; 2]> {
        let end = END_DISTANCE * self.distance;
        // Points at least this many steps back along the line count as another line.
        let behind = (2.0 * self.distance / STEP) as usize;
        let mut points: Vec<[f64; 2]> = Vec::new();
        let mut at = seed;
        for step in 0..MAX_STEPS {
            let Some(next) = self.step(at, sign) else {
                break;
            };
            let own = points.len().saturating_sub(behind);
            let meets = |points: &[[f64; 2]]| points.iter().any(|p| squared(*p, next) < end * end);
            let meets_itself = meets(&points[..own])
                || step > behind && (squared(seed, next) < end * end)
                || other.len() > behind && meets(&other[behind..]);
            if self.is_near(next, end) || meets_itself {
                break;
            }
            points.push(next);
            at = next;
        }
        points
    }

    /// The next point, by the classical Runge-Kutta method along unit directions.
    fn step(&self, [x, y]: [f64; 2], sign: f64) -> Option<[f64; 2]> {
        let ahead = |d: [f64; 2], h: f64| [x + h * d[0], y + h * d[1]];
        let k1 = self.direction([x, y], sign)?;
        let k2 = self.direction(ahead(k1, 0.5 * STEP), sign)?;
        let k3 = self.direction(ahead(k2, 0.5 * STEP), sign)?;
        let k4 = self.direction(ahead(k3, STEP), sign)?;
        let mean = |k: usize| (k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]) / 6.0;
        Some(ahead([mean(0), mean(1)], STEP))
    }

    /// Unit vector along the flow in the plane; `None` outside the fluid and at rest.
    fn direction(&self, at: [f64; 2], sign: f64) -> Option<[f64; 2]> {
        let [u, v] = self.slice.in_plane(at)?;
        let speed = u.hypot(v);
        (speed > self.least_speed).then(|| [sign * u / speed, sign * v / speed])
    }

    fn square(&self, at: [f64; 2]) -> [i64; 2] {
        at.map(|x| (x / self.distance).floor() as i64)
    }

    /// Whether a recorded line is closer than `distance`.
    fn is_near(&self, at: [f64; 2], distance: f64) -> bool {
        let [column, row] = self.square(at);
        let squares = (-1..2).flat_map(|up| (-1..2).map(move |right| [column + right, row + up]));
        (squares.filter_map(|square| self.near.get(&square)))
            .flatten()
            .any(|p| squared(*p, at) < distance * distance)
    }
}

fn squared(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).powi(2) + (a[1] - b[1]).powi(2)
}

#[cfg(test)]
mod tests {
    use models::{ModelError, PointFlow};
    use nalgebra::Vector3;

    use super::super::SlicePlane;
    use super::*;

    fn slice(velocity: impl Fn(&Vector3<f64>) -> Option<Vector3<f64>>) -> FlowSlice {
        let plane = SlicePlane {
            centre: Vector3::zeros(),
            right: Vector3::x(),
            up: Vector3::y(),
            width: 2.0,
            height: 2.0,
        };
        let pressure = None;
        FlowSlice::sample(plane, 81 * 81, |points| {
            let value = |x| velocity(x).map(|velocity| PointFlow { velocity, pressure });
            Ok::<_, ModelError>(points.iter().map(value).collect())
        })
        .unwrap()
    }

    #[test]
    fn streamlines_of_a_rotation_are_circles_at_even_distances() {
        let slice = slice(|x| Some(Vector3::z().cross(x)));
        let lines = streamlines(&slice, 0.05);
        let mut radii = Vec::new();
        for line in &lines {
            let radius = |p: &[f64; 2]| (2.0 * p[0] - 1.0).hypot(2.0 * p[1] - 1.0);
            let first = radius(&line[0]);
            assert!(line.iter().all(|p| (radius(p) - first).abs() < 1e-3));
            radii.push(first);
        }
        radii.sort_by(f64::total_cmp);
        radii.retain(|r| *r < 0.95);
        // Complete circles inside the window are 0.1 apart, at least half of it.
        let gaps: Vec<f64> = radii
            .windows(2)
            .map(|r| r[1] - r[0])
            .filter(|d| *d > 1e-3)
            .collect();
        assert!(gaps.len() >= 6, "{radii:?}");
        assert!(
            gaps.iter().all(|gap| (0.049..0.21).contains(gap)),
            "{gaps:?}"
        );
    }

    #[test]
    fn streamlines_end_outside_the_fluid_and_are_none_in_fluid_at_rest() {
        let outside = |x: &Vector3<f64>| x.norm() > 0.5;
        let around = slice(|x| outside(x).then(Vector3::x));
        let lines = streamlines(&around, 0.04);
        assert!(lines.len() > 20);
        let is_outside = |p: &[f64; 2]| outside(&around.plane.point(*p));
        assert!(lines.iter().flatten().all(is_outside));
        assert!(streamlines(&slice(|_| Some(Vector3::zeros())), 0.04).is_empty());
        assert!(streamlines(&slice(|_| None), 0.04).is_empty());
    }
}
