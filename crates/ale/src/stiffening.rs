//! Coefficients that make small elements stiffer than large ones in the extension of boundary motion.

use mesh::TetMesh;
use rayon::prelude::*;

/// The coefficient of $\nabla\cdot(c\,\nabla d) = 0$ on each cell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stiffening {
    /// $c = 1$: plain Laplace. Inverts small cells for motions of a body's size; for comparison only.
    None,
    /// $c = 1 + \tau_e$, $\tau_e = (1 - V_{min}/V_{max}) / (V_e / V_{max})$ (Kanchi & Masud 2007; equation (2) of
    /// Berti et al. 2021).
    #[default]
    KanchiMasud,
    /// $c = V_{max}/V_e$, which the former approaches for graded meshes.
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
