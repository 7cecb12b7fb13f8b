//! Restricted additive Schwarz with factorised subdomains.

mod partition;
mod subdomain;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::columns::assert_lengths;
use crate::csr::Rows;
use crate::node_kernel::long_row;
use crate::schur::SchurFactor;
use crate::vector::axpy;
use crate::{LinalgError, LinearOperator, Preconditioner, PreconditionerKind, SaddleSystem};
use subdomain::Subdomain;

/// Parameters of the decomposition into subdomains.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct SchwarzParams {
    /// Number of subdomains; 8 by default.
    pub subdomains: usize,
    /// Layers of neighbours by which subdomains are extended, in the graph of nodes and pressures;
    /// 1 by default.
    ///
    /// The velocities of all pressures in a subdomain are added as well.
    pub overlap: usize,
    /// Treatment of the border dofs; [`BorderPlacement::Eliminated`] by default.
    pub border: BorderPlacement,
}

/// Treatment of the border dofs, such as velocities of bodies and Lagrange multipliers.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum BorderPlacement {
    /// All are eliminated, so that they act as a coarse space.
    ///
    /// The Schur complement is `M - C_l^T N C` with the preconditioner `N`.
    Eliminated,
    /// Each belongs to the given subdomain, as in a partition by matrix rows.
    ///
    /// A multiplier without the border dofs that it couples makes its subdomain singular, which is
    /// an error.
    Assigned(Vec<usize>),
}

impl Default for SchwarzParams {
    fn default() -> Self {
        SchwarzParams {
            subdomains: 8,
            // overlap 0, 1, 2 with 283 000 dofs: 32, 20, 16 iterations to 1e-6, and 1.3, 2.1, 3.3
            // GB of factors
            overlap: 1,
            border: BorderPlacement::Eliminated,
        }
    }
}

/// Additive Schwarz preconditioner `sum_i R_i0^T A_i^-1 R_i` on overlapping subdomains.
///
/// `R_i` restricts to subdomain i with its overlap, `R_i0` to its part of the METIS partition:
/// *restricted* additive Schwarz (Cai, Sarkis, SIAM J. Sci. Comput. 21, 1999), which is also
/// PETSc's default. The shifted, quasi-definite `A_i` are factorised as `L D L^T` in f32. Linear,
/// but not symmetric: use [`fgmres`](crate::fgmres).
///
/// The number of iterations grows with that of subdomains. Meant for systems without a mesh
/// hierarchy, and for comparison with [`BlockTriangular`](crate::BlockTriangular). It shares the
/// matrices of its system.
pub struct Schwarz {
    system: SaddleSystem,
    subdomains: Vec<Subdomain>,
    /// The eliminated border; `None` if border dofs are assigned to subdomains.
    border: Option<EliminatedBorder>,
}

setters!(SchwarzParams {
    with_subdomains(subdomains: usize),
    with_overlap(overlap: usize),
    with_border(border: BorderPlacement),
});

impl Schwarz {
    /// Partitions the system and factorises its subdomains in parallel.
    ///
    /// # Errors
    /// [`LinalgError::Subdomain`] for a singular one, [`LinalgError::Parameter`],
    /// [`LinalgError::Shape`], [`LinalgError::ConstrainedDofs`], [`LinalgError::NotSymmetric`],
    /// [`LinalgError::Factorisation`] of the border.
    pub fn new(system: &SaddleSystem, params: &SchwarzParams) -> Result<Self, LinalgError> {
        let (velocity, method) = (system.velocity_block(), "additive Schwarz");
        velocity.constrained_dofs().refuse(method)?;
        velocity.require_symmetric_stiffness(method)?;
        let cut = partition::cut(system, params)?;
        let subdomains: Result<Vec<_>, _> = cut
            .par_iter()
            .enumerate()
            .map(|(subdomain, members)| {
                Subdomain::new(system, members).map_err(|cause| LinalgError::Subdomain {
                    subdomain,
                    cause: Box::new(cause),
                })
            })
            .collect::<Vec<_>>()
            .into_iter()
            .collect();
        let mut subdomains = subdomains?;
        let border = match params.border {
            BorderPlacement::Eliminated => Some(EliminatedBorder::new(system, &mut subdomains)?),
            BorderPlacement::Assigned(_) => None,
        };
        Ok(Schwarz {
            system: system.clone(),
            subdomains,
            border,
        })
    }

    /// Bytes of all factors.
    pub fn bytes(&self) -> usize {
        self.subdomains.iter().map(Subdomain::bytes).sum()
    }
}

impl Preconditioner for Schwarz {
    fn size(&self) -> usize {
        self.system.rows()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let size = self.size();
        assert_lengths(&[r], size, &[&mut *z], size);
        solve_all(&mut self.subdomains, r, z);
        if let Some(border) = &mut self.border {
            border.correct(&self.system, r, z);
        }
    }

    /// Linear up to rounding errors, which the shifted pressure block amplifies to 1e-3 in f32.
    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::Variable
    }
}

/// `z <- sum_i R_i0^T A_i^-1 R_i r`; dofs in no subdomain are not changed.
fn solve_all(subdomains: &mut [Subdomain], r: &[f64], z: &mut [f64]) {
    subdomains.par_iter_mut().for_each(|s| s.solve(r));
    subdomains.iter().for_each(|s| s.write_owned(z));
}

/// The Schur complement of the border in the preconditioner of all other dofs.
struct EliminatedBorder {
    /// The columns `N [C; E]`, one after another, zero in the border.
    lifted: Vec<f64>,
    schur: SchurFactor,
    values: DVector<f64>,
}

impl EliminatedBorder {
    fn new(system: &SaddleSystem, subdomains: &mut [Subdomain]) -> Result<Self, LinalgError> {
        let (size, border) = (system.rows(), system.border_range());
        let m = border.len();
        let mut lifted = vec![0.0; size * m];
        let [mut unit, mut column] = [(); 2].map(|()| vec![0.0; size]);
        let mut schur = DMatrix::zeros(m, m);
        for (d, z) in lifted.chunks_exact_mut(size.max(1)).enumerate() {
            unit[border.start + d] = 1.0;
            system.apply(&unit, &mut column);
            unit[border.start + d] = 0.0;
            column[border.clone()].fill(0.0);
            // multipliers couple border dofs only
            if column.iter().any(|v| *v != 0.0) {
                solve_all(subdomains, &column, z);
            }
            for c in 0..m {
                schur[(c, d)] = system.velocity_block().corner()[(c, d)] - row(system, c, z);
            }
        }
        Ok(EliminatedBorder {
            lifted,
            schur: SchurFactor::new(schur)?,
            values: DVector::zeros(m),
        })
    }

    /// Corrects `z = N r`, computed without the border, to the solution with it.
    fn correct(&mut self, system: &SaddleSystem, r: &[f64], z: &mut [f64]) {
        let border = system.border_range();
        for (c, v) in self.values.iter_mut().enumerate() {
            *v = r[border.start + c] - row(system, c, z);
        }
        self.schur.solve(&mut self.values);
        z[border.clone()].fill(0.0);
        for (column, v) in self
            .lifted
            .chunks_exact(z.len().max(1))
            .zip(self.values.iter())
        {
            axpy(-v, column, z);
        }
        z[border].copy_from_slice(self.values.as_slice());
    }
}

/// `(C_l^T u + E_l^T p)_c`.
fn row(system: &SaddleSystem, c: usize, x: &[f64]) -> f64 {
    let (u, p) = (&x[system.velocity_range()], &x[system.pressure_range()]);
    let rows = Rows::new(system.velocity_block().border_rows());
    let [nodes] = long_row(rows, c, |j| [u[j]]);
    let [pressures] = long_row(Rows::new(system.border_gradient()), c, |q| [p[q]]);
    nodes + pressures
}
