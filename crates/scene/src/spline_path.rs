//! Paths along the cubic splines through the rows of a table.

use std::sync::Arc;

/// The cubic splines through the values of joints at the rows of a table.
///
/// Between two rows at the distance `h` a value with the second derivatives `m_0` and `m_1` there
/// is, at the part `u` of this interval,
///
/// ```text
/// y_0 + u (y_1 - y_0) + u (u - 1) (a + b (u + 1)),   a = h² m_0 / 2,   b = h² (m_1 - m_0) / 6
/// ```
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Splines {
    /// Times of the rows, increasing.
    pub times: Vec<f64>,
    /// One spline for each joint.
    pub columns: Vec<SplineColumn>,
}

/// The spline of one joint.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SplineColumn {
    /// The joint.
    pub joint: usize,
    /// Values at the rows.
    pub values: Vec<f64>,
    /// Second derivatives in time at the rows.
    pub bends: Vec<f64>,
}

/// Part of the splines through the rows of a table, from one row to a later one.
///
/// It is twice continuously differentiable in time.
#[derive(Clone, Debug, PartialEq)]
pub struct SplinePath {
    splines: Arc<Splines>,
    from: usize,
    to: usize,
}

/// Degree of the polynomial whose distance from a path says how rough it is: the path of a smooth
/// gait over a quarter of a period differs from it by 1e-9 of the amplitude.
const SMOOTH_DEGREE: usize = 8;

impl SplinePath {
    /// The splines from the row `from` to the row `to`.
    pub(crate) fn new(splines: Arc<Splines>, from: usize, to: usize) -> Self {
        Self { splines, from, to }
    }

    /// Number of rows after the first one.
    pub fn intervals(&self) -> usize {
        self.to - self.from
    }

    /// First and last row, from zero.
    pub fn rows(&self) -> (usize, usize) {
        (self.from, self.to)
    }

    pub(crate) fn joints(&self) -> impl Iterator<Item = usize> {
        self.splines.columns.iter().map(|column| column.joint)
    }

    pub(crate) fn is_finite(&self) -> bool {
        let numbers = |column: &SplineColumn| {
            let mut numbers = column.values.iter().chain(&column.bends);
            numbers.all(|x| x.is_finite())
        };
        self.splines.columns.iter().all(numbers)
    }

    pub(crate) fn duration(&self) -> f64 {
        self.splines.times[self.to] - self.splines.times[self.from]
    }

    /// The row that an interval begins with, and the part of this interval that is over.
    fn place(&self, s: f64) -> (usize, f64) {
        if self.intervals() == 1 {
            return (self.from, s);
        }
        let times = &self.splines.times[self.from..=self.to];
        let time = times[0] + s * self.duration();
        let after = times.partition_point(|&row| row <= time);
        let row = after.clamp(1, times.len() - 1) - 1;
        let u = (time - times[row]) / (times[row + 1] - times[row]);
        // `clamp` keeps what is not a number.
        (self.from + row, u.clamp(0.0, 1.0))
    }

    /// Enters the values at `s` in [0, 1] into the list of all joints.
    pub(crate) fn enter_values(&self, s: f64, all: &mut [f64]) {
        let (row, u) = self.place(s);
        let step = self.splines.times[row + 1] - self.splines.times[row];
        for column in &self.splines.columns {
            let (a, b) = column.bend(row, step);
            let [y, next] = [column.values[row], column.values[row + 1]];
            all[column.joint] = y + u * (next - y) + u * (u - 1.0) * (a + b * (u + 1.0));
        }
    }

    /// Enters the rates in time at `s` in [0, 1] into the list of all joints.
    pub(crate) fn enter_rates(&self, s: f64, all: &mut [f64]) {
        let (row, u) = self.place(s);
        let step = self.splines.times[row + 1] - self.splines.times[row];
        for column in &self.splines.columns {
            let (a, b) = column.bend(row, step);
            let [y, next] = [column.values[row], column.values[row + 1]];
            let bend = a * (2.0 * u - 1.0) + b * (3.0 * u * u - 1.0);
            all[column.joint] = (next - y + bend) / step;
        }
    }

    /// Enters the values at the last row into the list of all joints.
    pub(crate) fn enter_end(&self, all: &mut [f64]) {
        for column in &self.splines.columns {
            all[column.joint] = column.values[self.to];
        }
    }

    /// Joints with their largest second derivatives with respect to `s`: they are linear between
    /// rows.
    pub(crate) fn second_derivatives(&self) -> impl Iterator<Item = (usize, f64)> {
        let squared = self.duration().powi(2);
        self.splines.columns.iter().map(move |column| {
            let bends = column.bends[self.from..=self.to].iter();
            let largest = bends.fold(0.0, |largest: f64, bend| largest.max(bend.abs()));
            (column.joint, squared * largest)
        })
    }

    /// Position `s` of a row.
    fn position(&self, row: usize) -> f64 {
        self.position_at(self.splines.times[row])
    }

    /// Position `s` at a time of the table.
    fn position_at(&self, time: f64) -> f64 {
        (time - self.splines.times[self.from]) / self.duration()
    }

    /// The row between two positions that is nearest to their middle; none between two rows.
    pub(crate) fn middle_row(&self, (from, to): (f64, f64)) -> Option<usize> {
        let rows = self.from..=self.to;
        let middle = 0.5 * (from + to);
        let times = &self.splines.times[rows.clone()];
        let after =
            self.from + times.partition_point(|&time| time < times[0] + middle * self.duration());
        let near = [after.saturating_sub(1), after].into_iter();
        near.filter(|row| rows.contains(row))
            .filter(|&row| self.position(row) > from && self.position(row) < to)
            .min_by(|&a, &b| {
                let off = |row: usize| (self.position(row) - middle).abs();
                off(a).total_cmp(&off(b))
            })
    }

    /// The position of [`SplinePath::middle_row`].
    pub(crate) fn middle(&self, ends: (f64, f64)) -> Option<f64> {
        self.middle_row(ends).map(|row| self.position(row))
    }

    /// Largest distance of the values of each joint between two positions from the polynomial of
    /// the degree eight through them at the Chebyshev points; zero between two rows.
    ///
    /// It is measured at all rows and in the middle between them. What a few points of a step see
    /// of a path is this polynomial. Cost: ten operations per row and joint.
    pub(crate) fn roughness(&self, ends: (f64, f64)) -> Vec<(usize, f64)> {
        let joints = self.joints().map(|joint| (joint, 0.0));
        if self.middle_row(ends).is_none() {
            return joints.collect();
        }
        self.distances(ends, SMOOTH_DEGREE)
    }

    /// The distances from the polynomial of this degree, as in [`SplinePath::roughness`].
    pub(crate) fn distances(&self, (from, to): (f64, f64), degree: usize) -> Vec<(usize, f64)> {
        let size = self.joints().fold(0, |size, joint| size.max(joint + 1));
        let at = |s: f64| {
            let mut all = vec![0.0; size];
            self.enter_values(s, &mut all);
            all
        };
        // Chebyshev points of the second kind and their weights in the barycentric formula
        // (Berrut & Trefethen 2004, SIAM Rev. 46, (5.4)).
        let angle = |j: usize| std::f64::consts::PI * j as f64 / degree as f64;
        let nodes: Vec<_> = (0..=degree)
            .map(|j| 0.5 * (from + to) - 0.5 * (to - from) * angle(j).cos())
            .map(|s| (s, at(s)))
            .collect();
        let weight = |j: usize| {
            let sign = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * if j == 0 || j == degree { 0.5 } else { 1.0 }
        };
        let first = self.splines.times[self.from..=self.to]
            .partition_point(|&time| self.position_at(time) < from);
        let rows = (self.from + first..=self.to)
            .map(|row| self.position(row))
            .take_while(|&s| s <= to);
        let mut places = vec![from];
        for s in rows.chain([to]) {
            let before = *places.last().unwrap_or(&from);
            places.extend([0.5 * (before + s), s]);
        }
        let mut largest: Vec<(usize, f64)> = self.joints().map(|joint| (joint, 0.0)).collect();
        for s in places {
            let terms = nodes.iter().enumerate();
            let weights: Vec<f64> = terms.map(|(j, (node, _))| weight(j) / (s - node)).collect();
            let sum: f64 = weights.iter().sum();
            if !sum.is_finite() {
                // At a node.
                continue;
            }
            let values = at(s);
            for (joint, largest) in &mut largest {
                let terms = nodes.iter().zip(&weights);
                let polynomial: f64 = terms.map(|((_, y), w)| w * y[*joint]).sum();
                *largest = largest.max((values[*joint] - polynomial / sum).abs());
            }
        }
        largest
    }
}

impl SplineColumn {
    /// The coefficients of degree two and three between a row and the next one.
    fn bend(&self, row: usize, step: f64) -> (f64, f64) {
        let [m, next] = [self.bends[row], self.bends[row + 1]];
        (0.5 * step * step * m, step * step * (next - m) / 6.0)
    }
}
