//! Coefficients that make small elements stiffer than large ones.

use mesh::TetMesh;
use rayon::prelude::*;

/// The coefficient `c` of `∇·(c ∇d) = 0` on each cell, from its volume `V_e`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Stiffening {
    /// `c = 1`, the Laplace equation; for comparison only.
    ///
    /// Motions as large as a body invert small cells.
    None,
    /// `c = 1 + τ_e`, `τ_e = (1 - V_min / V_max) / (V_e / V_max)` (Kanchi & Masud 2007; equation
    /// (2) of Berti et al. 2021).
    #[default]
    KanchiMasud,
    /// `c = V_max / V_e`, the limit of [`Stiffening::KanchiMasud`] for strongly graded meshes.
    InverseVolume,
}

impl Stiffening {
    /// The coefficient of each cell. Cost: one pass over the cells.
    pub fn coefficients(self, mesh: &TetMesh) -> Vec<f64> {
        let volumes: Vec<f64> = (0..mesh.n_cells())
            .into_par_iter()
            .map(|cell| mesh.cell_volume(cell))
            .collect();
        let largest = volumes.par_iter().copied().reduce(|| 0.0, f64::max);
        let smallest = volumes
            .par_iter()
            .copied()
            .reduce(|| f64::INFINITY, f64::min);
        volumes
            .into_iter()
            .map(|volume| match self {
                Self::None => 1.0,
                Self::KanchiMasud => 1.0 + (1.0 - smallest / largest) / (volume / largest),
                Self::InverseVolume => largest / volume,
            })
            .collect()
    }
}
