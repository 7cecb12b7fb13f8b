//! Gaits as tables of times and joint values, in files of comma-separated values.

use std::path::{Path, PathBuf};

use mesh::InputFile;
use rigid::Joint;

use crate::checks::check_prescribed;
use crate::document::MAX_TEXT_FILE;
use crate::gait::{Gait, Phase};
use crate::nearest::find_name;
use crate::shape_path::{CubicLength, ShapePath};
use crate::spline::second_derivatives;
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

/// Largest number of rows; each is a phase of the gait.
const MAX_ROWS: usize = 100_000;

impl GaitTable {
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
        for name in names {
            let known = joints.iter().map(|joint| &joint.name[..]);
            let joint = find_name(name, "link", known)
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
            number.ok_or_else(|| format!("\"{word}\" is not a number"))
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
            |(joint, value): &(&usize, &f64)| **value <= 0.0 && !joints[**joint].kind.is_angle();
        if let Some((_, length)) = self.joints.iter().zip(shape).find(is_bad) {
            return Err(format!("the length {length} is not positive"));
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
            .filter(|(joint, _)| !joints[**joint].kind.is_angle())
            .flat_map(|(_, column)| column)
            .fold(0.0, |largest, length| length.max(largest))
    }

    /// The gait, with one phase between each two rows.
    pub fn gait(&self, cycles: u32) -> Gait {
        let is_periodic = self.interpolation == InterpolationKind::Cubic && self.is_closed();
        let bends: Vec<Vec<f64>> = match self.interpolation {
            InterpolationKind::Linear => Vec::new(),
            InterpolationKind::Cubic | InterpolationKind::Corner => (self.shape.iter())
                .map(|column| second_derivatives(&self.times, column, is_periodic))
                .collect(),
        };
        let phase = |k: usize| {
            let duration = self.times[k + 1] - self.times[k];
            let ends = self.joints.iter().zip(&self.shape);
            let path = match self.interpolation {
                InterpolationKind::Linear => ShapePath::Linear(
                    ends.map(|(&joint, column)| (joint, column[k + 1]))
                        .collect(),
                ),
                InterpolationKind::Cubic | InterpolationKind::Corner => {
                    let pieces = ends
                        .zip(&bends)
                        .map(|((&joint, column), bend)| CubicLength {
                            joint,
                            end: column[k + 1],
                            square: 0.5 * duration * duration * bend[k],
                            cube: duration * duration * (bend[k + 1] - bend[k]) / 6.0,
                        });
                    ShapePath::Cubic(pieces.collect())
                }
            };
            Phase { path, duration }
        };
        Gait {
            cycles,
            phases: (0..self.times.len() - 1).map(phase).collect(),
        }
    }
}
