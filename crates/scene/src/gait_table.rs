//! Gaits as tables of times and joint values, in files of comma-separated values.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use mesh::InputFile;
use rigid::Joint;

use crate::checks::check_prescribed;
use crate::document::{MAX_TEXT_FILE, is_in_range};
use crate::gait::{Gait, Phase};
use crate::nearest::Names;
use crate::shape_path::ShapePath;
use crate::spline::second_derivatives;
use crate::spline_path::{SplineColumn, SplinePath, Splines};
use crate::words::InterpolationKind;

/// Values of joints at increasing times, from a file.
///
/// The first line has the names: `time`, then joints. Every other line has a time and a value for
/// each of these joints. Empty lines and lines that begin with `#` are left out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GaitTable {
    /// The file, relative to the working directory.
    pub file: PathBuf,
    /// Hash of its contents.
    pub hash: u64,
    /// Interpolation between the times.
    pub interpolation: InterpolationKind,
    joints: Vec<usize>,
    times: Vec<f64>,
    /// Values of one joint at all times, for each joint.
    shape: Vec<Vec<f64>>,
}

/// Largest number of rows; each may be a phase of the gait.
const MAX_ROWS: usize = 100_000;

/// Largest number of rows of a phase: each can be a step of its own, and a run has a checkpoint
/// after each phase.
const MAX_ROWS_PER_PHASE: usize = 4096;

/// Degree of the polynomial that the path of a phase resembles: about that of the lowest order with
/// which the integration is content.
const PHASE_DEGREE: usize = 4;

/// Largest distance from this polynomial, relative to the range of the joint. That of a sine is
/// 8e-5 over a quarter of its period and 2.5e-3 over a half: its phases are quarters, as those of a
/// harmonic gait.
const PHASE_ROUGHNESS: f64 = 1e-3;

/// Rounding of values that are evaluated by a few operations, relative to the largest one.
const ROUNDING: f64 = 1e-13;

impl GaitTable {
    /// Names of the columns of a file but for the time; none of a file that cannot be read.
    pub fn columns(file: &Path) -> Option<Vec<String>> {
        let text = (InputFile::read(file, MAX_TEXT_FILE).ok()?)
            .into_text()
            .ok()?;
        let mut lines = text.lines().map(str::trim);
        let header = lines.find(|line| !line.is_empty() && !line.starts_with('#'))?;
        let names = header.split(',').skip(1);
        Some(names.map(|name| name.trim().to_owned()).collect())
    }

    /// Reads a file.
    ///
    /// # Errors
    /// What is wrong with the file, with its line.
    pub fn read(
        file: &Path,
        interpolation: InterpolationKind,
        joints: &[Joint],
    ) -> Result<Self, String> {
        let unreadable =
            |error: std::io::Error| format!("cannot be read: {}: {error}", file.display());
        let contents = InputFile::read(file, MAX_TEXT_FILE).map_err(unreadable)?;
        let hash = contents.hash;
        let text = contents.into_text().map_err(unreadable)?;
        Self::parse(&text, (file, hash), interpolation, joints)
            .map_err(|problem| format!("names {}, {problem}", file.display()))
    }

    fn parse(
        text: &str,
        (file, hash): (&Path, u64),
        interpolation: InterpolationKind,
        joints: &[Joint],
    ) -> Result<Self, String> {
        let lines = text
            .lines()
            .enumerate()
            .map(|(number, line)| (number + 1, line.trim()));
        let mut lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
        let (number, header) = lines.next().ok_or("which has no rows")?;
        let mut names = header.split(',').map(str::trim);
        if names.next() != Some("time") {
            return Err(format!(
                "line {number}: the first line must have the names time, and then links"
            ));
        }
        let mut table = Self {
            file: file.to_owned(),
            hash,
            interpolation,
            joints: Vec::new(),
            times: Vec::new(),
            shape: Vec::new(),
        };
        let known = Names::new("link", joints.iter().map(|joint| &joint.name[..]));
        for name in names {
            let joint = (known.find(name))
                .map_err(|problem| format!("line {number}: a column {problem}"))?;
            if table.joints.contains(&joint) {
                return Err(format!("line {number}: \"{name}\" has two columns"));
            }
            check_prescribed(&joints[joint])
                .map_err(|problem| format!("line {number}: a column {problem}"))?;
            table.joints.push(joint);
            table.shape.push(Vec::new());
        }
        for (number, line) in lines {
            table
                .add_row(line, joints)
                .map_err(|problem| format!("line {number}: {problem}"))?;
        }
        match table.times.len() {
            0 | 1 => Err("which has less than two rows".to_owned()),
            rows if rows > MAX_ROWS => Err(format!("which has more than {MAX_ROWS} rows")),
            _ => Ok(table),
        }
    }

    fn add_row(&mut self, line: &str, joints: &[Joint]) -> Result<(), String> {
        let numbers = line.split(',').map(str::trim).map(|word| {
            let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
            let number = number.ok_or_else(|| format!("\"{word}\" is not a number"))?;
            match is_in_range(number) {
                true => Ok(number),
                false => Err(format!(
                    "\"{word}\" is neither zero nor 1e-50 to 1e50 in size"
                )),
            }
        });
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
        let expected = self.joints.len() + 1;
        if numbers.len() != expected {
            return Err(format!(
                "has {} columns instead of {expected}",
                numbers.len()
            ));
        }
        let (time, shape) = (numbers[0], &numbers[1..]);
        if let Some(before) = self.times.last().filter(|before| time <= **before) {
            return Err(format!("the time {time} is not after {before}"));
        }
        let is_bad =
            |(joint, value): &(&usize, &f64)| **value <= 0.0 && !joints[**joint].kind.is_signed();
        if let Some((_, length)) = self.joints.iter().zip(shape).find(is_bad) {
            return Err(format!("the value {length} is not positive"));
        }
        self.times.push(time);
        for (column, length) in self.shape.iter_mut().zip(shape) {
            column.push(*length);
        }
        Ok(())
    }

    /// Joints and their values at the first time.
    pub fn initial_shape(&self) -> Vec<(usize, f64)> {
        let first = self.shape.iter().map(|column| column[0]);
        self.joints.iter().copied().zip(first).collect()
    }

    /// Whether the last row has the values of the first one.
    pub fn is_closed(&self) -> bool {
        (self.shape.iter()).all(|column| column.first() == column.last())
    }

    /// The largest length of a slide.
    pub fn largest(&self, joints: &[Joint]) -> f64 {
        (self.joints.iter().zip(&self.shape))
            .filter(|(joint, _)| joints[**joint].kind.length_power() == 1)
            .flat_map(|(_, column)| column)
            .fold(0.0, |largest, length| length.max(largest))
    }

    /// The gait: along splines phases over as many rows as resemble a simple curve, otherwise one
    /// phase between each two rows.
    pub fn gait(&self, cycles: u32) -> Gait {
        let phases = match self.interpolation {
            InterpolationKind::Linear => {
                (1..self.times.len()).map(|row| self.linear(row)).collect()
            }
            InterpolationKind::Cubic => self.along_splines(self.is_closed()),
            InterpolationKind::Corner => self.along_splines(false),
        };
        Gait { cycles, phases }
    }

    /// The phase to a row at constant rates.
    fn linear(&self, row: usize) -> Phase {
        let ends = self.joints.iter().zip(&self.shape);
        let changes = ends.map(|(&joint, column)| (joint, column[row]));
        Phase {
            path: ShapePath::Linear(changes.collect()),
            duration: self.times[row] - self.times[row - 1],
        }
    }

    /// The phases along splines.
    fn along_splines(&self, is_periodic: bool) -> Vec<Phase> {
        let ends = self.joints.iter().zip(&self.shape);
        let columns = ends.map(|(&joint, column)| SplineColumn {
            joint,
            values: column.clone(),
            bends: second_derivatives(&self.times, column, is_periodic),
        });
        let splines = Arc::new(Splines {
            times: self.times.clone(),
            columns: columns.collect(),
        });
        let allowed: Vec<f64> = (self.shape.iter())
            .map(|column| {
                let high = column.iter().copied().fold(f64::MIN, f64::max);
                let low = column.iter().copied().fold(f64::MAX, f64::min);
                PHASE_ROUGHNESS * (high - low) + ROUNDING * high.abs().max(low.abs())
            })
            .collect();
        let mut phases = Vec::new();
        // Parts of the table in reverse order.
        let mut todo = vec![(0, self.times.len() - 1)];
        while let Some((from, to)) = todo.pop() {
            let path = SplinePath::new(splines.clone(), from, to);
            let distances = path.distances((0.0, 1.0), PHASE_DEGREE);
            let is_simple = (distances.iter().zip(&allowed)).all(|((_, d), allowed)| d <= allowed);
            match path.middle_row((0.0, 1.0)) {
                Some(row) if !is_simple || path.intervals() > MAX_ROWS_PER_PHASE => {
                    todo.extend([(row, to), (from, row)]);
                }
                _ => phases.push(Phase {
                    duration: path.duration(),
                    path: ShapePath::Spline(path),
                }),
            }
        }
        phases
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn table(rows: usize, value: impl Fn(usize) -> f64) -> GaitTable {
        GaitTable {
            file: PathBuf::new(),
            hash: 0,
            interpolation: InterpolationKind::Cubic,
            joints: vec![0],
            times: (0..=rows).map(|k| k as f64).collect(),
            shape: vec![(0..=rows).map(value).collect()],
        }
    }

    #[test]
    fn rows_of_a_smooth_table_are_few_phases_and_outliers_stay_alone() {
        let rows = 10_000;
        let sine = |k: usize| 8.0 + 2.0 * (TAU * (k % rows) as f64 / rows as f64).sin();
        let smooth = table(rows, sine).gait(1);
        assert_eq!(smooth.phases.len(), 4);
        let lengths = |gait: &Gait| -> Vec<usize> {
            let intervals = |phase: &Phase| match &phase.path {
                ShapePath::Spline(path) => path.intervals(),
                other => panic!("{other:?}"),
            };
            gait.phases.iter().map(intervals).collect()
        };
        assert_eq!(lengths(&smooth), [2500; 4]);
        // A jump of a tenth of the amplitude in one row.
        let outlier = table(rows, |k| sine(k) + if k == 3333 { 0.2 } else { 0.0 }).gait(1);
        let all = lengths(&outlier);
        assert_eq!(all.iter().sum::<usize>(), rows);
        assert!(all.len() < 60 && all.contains(&1), "{all:?}");
        // Noise: only neighbours may lie on one simple curve.
        let noise = |k: usize| 8.0 + ((k * k * 37 + 11 * k) % 64) as f64 / 32.0;
        let all = lengths(&table(64, noise).gait(1));
        assert!(
            all.iter().all(|&rows| rows <= 2) && all.len() > 48,
            "{all:?}"
        );
        // A constant is no reason for phases.
        assert_eq!(table(5000, |_| 0.1).gait(1).phases.len(), 2);
    }
}
