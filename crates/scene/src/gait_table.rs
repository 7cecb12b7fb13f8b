//! Gaits as tables of times and lengths, in files of comma-separated values.

use std::path::{Path, PathBuf};

use rigid::Link;

use crate::gait::{Gait, Phase};
use crate::length_path::{CubicLength, LengthPath};
use crate::nearest::find_name;
use crate::read::check_prescribed;
use crate::spline::second_derivatives;
use crate::words::InterpolationKind;

/// Lengths of links at increasing times, from a file.
///
/// The first line has the names: `time`, then links. Every other line has a time and a length for
/// each of these links. Empty lines and lines that begin with `#` are left out.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GaitTable {
    /// The file, relative to the working directory.
    pub file: PathBuf,
    /// Interpolation between the times.
    pub interpolation: InterpolationKind,
    links: Vec<usize>,
    times: Vec<f64>,
    /// Lengths of one link at all times, for each link.
    lengths: Vec<Vec<f64>>,
}

/// Largest number of rows; each is a phase of the gait.
const MOST_ROWS: usize = 100_000;

impl GaitTable {
    /// Reads a file.
    ///
    /// # Errors
    /// What is wrong with the file, with its line.
    pub fn read(
        file: &Path,
        interpolation: InterpolationKind,
        links: &[Link],
    ) -> Result<Self, String> {
        let text = std::fs::read_to_string(file)
            .map_err(|error| format!("cannot be read: {}: {error}", file.display()))?;
        Self::parse(&text, file, interpolation, links)
            .map_err(|problem| format!("names {}, {problem}", file.display()))
    }

    fn parse(
        text: &str,
        file: &Path,
        interpolation: InterpolationKind,
        links: &[Link],
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
            interpolation,
            links: Vec::new(),
            times: Vec::new(),
            lengths: Vec::new(),
        };
        for name in names {
            let known = links.iter().map(|link| &link.name[..]);
            let link = find_name(name, "link", known)
                .map_err(|problem| format!("line {number}: a column {problem}"))?;
            if table.links.contains(&link) {
                return Err(format!("line {number}: \"{name}\" has two columns"));
            }
            check_prescribed(&links[link])
                .map_err(|problem| format!("line {number}: a column {problem}"))?;
            table.links.push(link);
            table.lengths.push(Vec::new());
        }
        for (number, line) in lines {
            table
                .add_row(line, links)
                .map_err(|problem| format!("line {number}: {problem}"))?;
        }
        match table.times.len() {
            0 | 1 => Err("which has less than two rows".to_owned()),
            rows if rows > MOST_ROWS => Err(format!("which has more than {MOST_ROWS} rows")),
            _ => Ok(table),
        }
    }

    fn add_row(&mut self, line: &str, links: &[Link]) -> Result<(), String> {
        let numbers = line.split(',').map(str::trim).map(|word| {
            let number = word.parse::<f64>().ok().filter(|x| x.is_finite());
            number.ok_or_else(|| format!("\"{word}\" is not a number"))
        });
        let numbers: Vec<f64> = numbers.collect::<Result<_, _>>()?;
        let expected = self.links.len() + 1;
        if numbers.len() != expected {
            return Err(format!(
                "has {} columns instead of {expected}",
                numbers.len()
            ));
        }
        let (time, lengths) = (numbers[0], &numbers[1..]);
        if let Some(before) = self.times.last().filter(|before| time <= **before) {
            return Err(format!("the time {time} is not after {before}"));
        }
        let is_bad =
            |(link, value): &(&usize, &f64)| **value <= 0.0 && !links[**link].joint.is_angle();
        if let Some((_, length)) = self.links.iter().zip(lengths).find(is_bad) {
            return Err(format!("the length {length} is not positive"));
        }
        self.times.push(time);
        for (column, length) in self.lengths.iter_mut().zip(lengths) {
            column.push(*length);
        }
        Ok(())
    }

    /// Links and their lengths at the first time.
    pub fn initial_lengths(&self) -> Vec<(usize, f64)> {
        let first = self.lengths.iter().map(|column| column[0]);
        self.links.iter().copied().zip(first).collect()
    }

    /// Whether the last row has the lengths of the first one.
    pub fn is_closed(&self) -> bool {
        (self.lengths.iter()).all(|column| column.first() == column.last())
    }

    /// The largest length of a slide.
    pub fn largest(&self, links: &[Link]) -> f64 {
        (self.links.iter().zip(&self.lengths))
            .filter(|(link, _)| !links[**link].joint.is_angle())
            .flat_map(|(_, column)| column)
            .fold(0.0, |largest, length| length.max(largest))
    }

    /// The gait, with one phase between each two rows.
    pub fn gait(&self, cycles: u32) -> Gait {
        let is_periodic = self.interpolation == InterpolationKind::Cubic && self.is_closed();
        let bends: Vec<Vec<f64>> = match self.interpolation {
            InterpolationKind::Linear => Vec::new(),
            InterpolationKind::Cubic | InterpolationKind::Corner => (self.lengths.iter())
                .map(|column| second_derivatives(&self.times, column, is_periodic))
                .collect(),
        };
        let phase = |k: usize| {
            let duration = self.times[k + 1] - self.times[k];
            let ends = self.links.iter().zip(&self.lengths);
            let path = match self.interpolation {
                InterpolationKind::Linear => {
                    LengthPath::Linear(ends.map(|(&link, column)| (link, column[k + 1])).collect())
                }
                InterpolationKind::Cubic | InterpolationKind::Corner => {
                    let pieces = ends.zip(&bends).map(|((&link, column), bend)| CubicLength {
                        link,
                        end: column[k + 1],
                        square: 0.5 * duration * duration * bend[k],
                        cube: duration * duration * (bend[k + 1] - bend[k]) / 6.0,
                    });
                    LengthPath::Cubic(pieces.collect())
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
