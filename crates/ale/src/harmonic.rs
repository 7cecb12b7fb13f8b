//! Harmonic extension: a scalar diffusion equation whose coefficient makes small cells stiff.

use fem::DirichletCondition;
use linalg::{Bordered, Multigrid, MultigridParams};
use mesh::{TetMesh, Vec3};
use rayon::prelude::*;

use crate::extension::{extend, krylov, scalar_product};
use crate::{AleError, MeshMotion, MovingMesh};

/// Harmonic extension: `∇·(c ∇d) = 0` for each component, with the coefficient of a [`Stiffening`].
///
/// Linear elements on the vertices. Cost: one scalar multigrid set-up per mesh and 10 to 15
/// iterations of CG per field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Harmonic(
    /// The coefficient `c`.
    pub Stiffening,
);

impl MeshMotion for Harmonic {
    fn name(&self) -> &'static str {
        match self.0 {
            Stiffening::None => "laplace",
            Stiffening::KanchiMasud => "kanchi-masud",
            Stiffening::InverseVolume => "inverse-volume",
        }
    }

    fn is_scalar(&self) -> bool {
        true
    }

    fn extend(&self, moving: &MovingMesh<'_>, fields: &mut [Vec<Vec3>]) -> Result<usize, AleError> {
        moving.check(fields)?;
        let condition = DirichletCondition::new(moving.prescribed);
        if condition.n_free() == 0 {
            return Ok(0);
        }
        let coefficients = self.0.coefficients(moving.mesh);
        let stiffness = moving
            .space
            .weighted_vertex_stiffness(moving.mesh, &coefficients)?;
        let operator = Bordered::scalar(condition.restrict_matrix(&stiffness, 1)?)?;
        let mut multigrid = Multigrid::new(&operator, &MultigridParams::default())?;
        let apply = |field: &[Vec3]| scalar_product(&stiffness, field);
        let params = krylov(300);
        extend(
            &condition,
            &apply,
            &operator,
            &mut multigrid,
            &params,
            fields,
        )
    }
}

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
