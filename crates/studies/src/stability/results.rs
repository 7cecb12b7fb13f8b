//! Results of the whole study.

use super::integration::Study;
use super::map::{Map, Tried};

/// Results of the study.
pub struct Results {
    pub maps: Vec<Map>,
    pub algebra: Vec<Tried>,
    pub integrators: Study,
    pub seconds: f64,
}

impl Results {
    /// Tests of whole systems and of integrators.
    pub fn tried(&self) -> impl Iterator<Item = &Tried> {
        self.algebra.iter().chain(&self.integrators.tried)
    }

    /// Number of stress cases.
    pub fn stress_cases(&self) -> usize {
        self.maps.iter().map(|map| map.rows.len()).sum::<usize>() + self.tried().count()
    }

    /// Number of cells.
    pub fn cells(&self) -> usize {
        self.maps.iter().flat_map(Map::cells).count() + self.tried().count()
    }

    /// Number of wrong solutions without an error message.
    pub fn wrong(&self) -> usize {
        let cells = self.maps.iter().flat_map(Map::cells);
        cells.filter(|cell| cell.outcome.is_wrong()).count()
            + self
                .tried()
                .filter(|tried| tried.outcome.contains("WRONG"))
                .count()
    }

    /// Number of cells that are not as expected.
    pub fn unexpected(&self) -> usize {
        let cells = self.maps.iter().flat_map(Map::cells);
        cells.filter(|cell| !cell.as_expected).count()
            + self.tried().filter(|tried| !tried.as_expected).count()
    }
}
