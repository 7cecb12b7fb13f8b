//! The inf-sup constant of a pair of velocity and pressure spaces, measured.

use nalgebra::{DMatrix, DVector};

use crate::csr::Rows;
use crate::direct::{Definiteness, Precision, SparseFactor};
use crate::{LinalgError, SaddleSystem};

/// Largest number of pressure dofs; the dense eigenproblem of 2000 takes about half a minute.
const MOST_PRESSURES: usize = 2000;

/// Relative size up to which an eigenvalue of the Schur complement counts as zero.
///
/// In enclosed flow the eigenvalue of the constant pressure is below it.
const ZERO: f64 = 1e-10;

/// Constants of the inf-sup condition of a pair of velocity and pressure spaces.
///
/// ```text
/// β^2 q^T M_p q <= q^T B K^-1 B^T q <= γ^2 q^T M_p q
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct InfSup {
    /// Inf-sup constant `β`, not counting the constant pressure.
    ///
    /// From 0.4 to 0.5 for P2-P1 elements on good meshes, near zero for unstable pairs.
    pub constant: f64,
    /// Upper bound `γ`, at most 1 if `K` is the stiffness matrix of the full gradient.
    pub largest: f64,
    /// Dimension of the null space of `B^T`, the constant pressure included.
    pub null_space_dimension: usize,
}

impl InfSup {
    /// Computes the constants for the spaces of a system, with the border fixed to zero.
    ///
    /// Cost: `O(np^3)` for a dense eigenproblem, and `np` solves with `K`; meant for small meshes
    /// of the same kind as the large ones. References: Brezzi (1974); Elman, Silvester & Wathen
    /// (2014), section 3.3.
    ///
    /// # Errors
    /// [`LinalgError::Parameter`] for none or more than 2000 pressure dofs,
    /// [`LinalgError::Factorisation`] of `K` or of the mass matrix,
    /// [`LinalgError::ConstrainedDofs`].
    pub fn of(system: &SaddleSystem) -> Result<Self, LinalgError> {
        system
            .velocity_block()
            .constrained_dofs()
            .refuse("the inf-sup constant")?;
        let (b, mass) = (system.divergence(), system.pressure_mass());
        let (pressures, nodes) = b.shape();
        if !(1..=MOST_PRESSURES).contains(&pressures) || nodes == 0 {
            return Err(LinalgError::Parameter {
                name: "number of pressures",
                value: pressures as f64,
                range: "from 1 to 2000 for the dense eigenproblem of the inf-sup constant, with at least one node",
            });
        }
        let stiffness = system.velocity_block().stiffness();
        let order: Vec<usize> = (0..nodes).collect();
        let mut factor = SparseFactor::new(
            "the stiffness",
            stiffness,
            &order,
            Definiteness::Positive,
            Precision::Double,
            pressures.max(1),
        )?;
        let mut schur = DMatrix::zeros(pressures, pressures);
        let rows = Rows::of(b);
        for axis in 0..3 {
            let mut columns = vec![0.0; nodes * pressures];
            for q in 0..pressures {
                for (j, entry) in rows.row(q) {
                    columns[q * nodes + j] = entry[axis];
                }
            }
            factor.solve_in_place(&mut columns);
            for (q, column) in columns.chunks_exact(nodes).enumerate() {
                for p in 0..pressures {
                    schur[(p, q)] += rows
                        .row(p)
                        .map(|(j, entry)| entry[axis] * column[j])
                        .sum::<f64>();
                }
            }
        }
        let mut dense_mass = DMatrix::zeros(pressures, pressures);
        for (p, row) in mass.outer_iterator().enumerate() {
            for (q, &value) in row.iter() {
                dense_mass[(p, q)] = value;
            }
        }
        let failed = |detail: &str| LinalgError::Factorisation {
            what: "the pressure mass matrix",
            detail: detail.to_owned(),
        };
        let l = dense_mass
            .cholesky()
            .ok_or_else(|| failed("not positive definite"))?
            .unpack();
        let solve = |matrix: &DMatrix<f64>| l.solve_lower_triangular(matrix);
        let scaled = solve(&schur)
            .and_then(|half| solve(&half.transpose()))
            .ok_or_else(|| failed("singular"))?;
        let scaled = (&scaled + scaled.transpose()) / 2.0;
        let mut eigenvalues: DVector<f64> = scaled.symmetric_eigenvalues();
        eigenvalues.as_mut_slice().sort_unstable_by(f64::total_cmp);
        let largest = eigenvalues.iter().copied().fold(0.0, f64::max);
        let null_space_dimension = eigenvalues.iter().filter(|&&e| e <= ZERO * largest).count();
        // In enclosed flow the constant pressure is in the null space; a second dimension is
        // spurious.
        let smallest = eigenvalues
            .get(null_space_dimension.min(1))
            .copied()
            .unwrap_or(largest)
            .max(0.0);
        Ok(InfSup {
            constant: smallest.sqrt(),
            largest: largest.sqrt(),
            null_space_dimension,
        })
    }

    /// Refuses a pair of spaces whose inf-sup constant is below `least`.
    ///
    /// A value of 0.1 separates P2-P1 elements (0.4) from equal orders (0.08 on coarse meshes, less
    /// on fine ones).
    ///
    /// # Errors
    /// [`LinalgError::NotInfSupStable`].
    pub fn require(&self, least: f64) -> Result<(), LinalgError> {
        if self.constant >= least {
            return Ok(());
        }
        Err(LinalgError::NotInfSupStable {
            constant: self.constant,
            least,
        })
    }
}
