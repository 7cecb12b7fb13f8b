//! The inf-sup constant of a pair of velocity and pressure spaces, measured.

use anyhow::{Result, anyhow, ensure};
use linalg::{SaddleSystem, ShiftedLdlt};
use nalgebra::{DMatrix, DVector};

/// Largest number of pressure dofs; the dense eigenproblem of 2000 takes about half a minute.
const MAX_PRESSURES: usize = 2000;

/// Relative size up to which an eigenvalue of the Schur complement counts as zero.
///
/// In enclosed flow the eigenvalue of the constant pressure is below it.
const ZERO_EIGENVALUE: f64 = 1e-10;

/// Constants of the inf-sup condition of a pair of velocity and pressure spaces.
///
/// ```text
/// β^2 q^T M_p q <= q^T B K^-1 B^T q <= γ^2 q^T M_p q
/// ```
#[derive(Debug)]
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
    /// None or more than 2000 pressure dofs; single components that are constrained to zero; `K` or
    /// the mass matrix cannot be factorised.
    pub fn new(system: &SaddleSystem) -> Result<Self> {
        let (b, mass) = (system.divergence(), system.pressure_mass());
        let (pressures, nodes) = b.shape();
        ensure!(
            (1..=MAX_PRESSURES).contains(&pressures) && nodes > 0,
            "the inf-sup constant of {pressures} pressures and {nodes} nodes: the dense eigenproblem \
             takes 1 to {MAX_PRESSURES} pressures, with at least one node"
        );
        ensure!(
            !system.velocity_block().has_constrained_dofs(),
            "the inf-sup constant of a system with single components constrained to zero"
        );
        let schur = schur_complement(system)?;
        let mut dense_mass = DMatrix::zeros(pressures, pressures);
        for (p, row) in mass.outer_iterator().enumerate() {
            for (q, &value) in row.iter() {
                dense_mass[(p, q)] = value;
            }
        }
        let failed = |detail: &str| anyhow!("the pressure mass matrix is {detail}");
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
        let zeros = eigenvalues
            .iter()
            .filter(|e| **e <= ZERO_EIGENVALUE * largest);
        let null_space_dimension = zeros.count();
        // In enclosed flow the constant pressure is in the null space; a second dimension is
        // spurious.
        let smallest = eigenvalues.get(null_space_dimension.min(1)).copied();
        let smallest = smallest.unwrap_or(largest).max(0.0);
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
    /// A constant below `least`.
    pub fn require(&self, least: f64) -> Result<()> {
        let constant = self.constant;
        ensure!(
            constant >= least,
            "the inf-sup constant is {constant:.1e}, below {least:.1e}: the pressure space is too \
             rich for the velocity space; use quadratic velocities with linear pressures"
        );
        Ok(())
    }
}

/// The dense matrix `B K^-1 B^T`.
fn schur_complement(system: &SaddleSystem) -> Result<DMatrix<f64>> {
    let (b, stiffness) = (system.divergence(), system.velocity_block().stiffness());
    let (pressures, nodes) = b.shape();
    let groups: Vec<u32> = (0..nodes as u32).collect();
    let mut factor = ShiftedLdlt::factor(stiffness.clone(), &vec![0.0; nodes], &groups)?;
    let mut schur = DMatrix::zeros(pressures, pressures);
    let (mut rhs, mut column) = (vec![0.0; nodes], vec![0.0; nodes]);
    for axis in 0..3 {
        for (q, row) in b.outer_iterator().enumerate() {
            rhs.fill(0.0);
            row.iter().for_each(|(j, entry)| rhs[j] = entry[axis]);
            factor.solve(&rhs, &mut column)?;
            for (p, row) in b.outer_iterator().enumerate() {
                let product = row.iter().map(|(j, entry)| entry[axis] * column[j]);
                schur[(p, q)] += product.sum::<f64>();
            }
        }
    }
    Ok(schur)
}

#[cfg(test)]
mod tests {
    use linalg::{Bordered, Csr, Csr3, LinalgError};

    use super::*;

    /// One node with the stiffness `k`, and pressures with the mass `m` whose divergence is one row
    /// each.
    fn try_one_node(k: f64, m: f64, rows: &[[f64; 3]]) -> Result<SaddleSystem, LinalgError> {
        let n = rows.len();
        let diagonal = |value: f64, n: usize| {
            Csr::new(
                (n, n),
                (0..=n).collect(),
                (0..n as u32).collect(),
                vec![value; n],
            )
        };
        let divergence = Csr3::new((n, 1), (0..=n).collect(), vec![0; n], rows.to_vec());
        let velocity = Bordered::scalar(diagonal(k, 1))?;
        let border = Csr::zero((n, 0));
        SaddleSystem::new(velocity, divergence, border, None, diagonal(m, n))
    }

    fn one_node(k: f64, m: f64, rows: &[[f64; 3]]) -> SaddleSystem {
        try_one_node(k, m, rows).unwrap()
    }

    #[test]
    fn inf_sup_constants_are_roots_of_the_eigenvalues_of_the_schur_complement() {
        // B K^-1 B^T / M = diag(1, 4, 9) / (k m).
        let rows = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
        let found = InfSup::new(&one_node(2.0, 8.0, &rows)).unwrap();
        assert!((found.constant - 1.0 / 4.0).abs() < 1e-14, "{found:?}");
        assert!((found.largest - 3.0 / 4.0).abs() < 1e-14, "{found:?}");
        assert_eq!(found.null_space_dimension, 0);
        found.require(0.24).unwrap();
        let refused = found.require(0.26).unwrap_err().to_string();
        assert!(refused.contains("is 2.5e-1, below 2.6e-1"), "{refused}");

        // A pressure without divergence is the constant one of enclosed flow, a second is spurious.
        let found = InfSup::new(&one_node(2.0, 8.0, &[rows[1], [0.0; 3], rows[2]])).unwrap();
        assert_eq!(found.null_space_dimension, 1);
        assert!((found.constant - 2.0 / 4.0).abs() < 1e-14, "{found:?}");
        let found = InfSup::new(&one_node(2.0, 8.0, &[[0.0; 3], [0.0; 3], rows[2]])).unwrap();
        assert_eq!(found.null_space_dimension, 2);
        assert!(
            found.constant < 1e-7 && found.require(1e-6).is_err(),
            "{found:?}"
        );
    }
    #[test]
    fn numbers_without_a_meaning_are_refused_or_give_a_constant() {
        let (infinity, nan) = (f64::INFINITY, f64::NAN);
        let numbers = [0.0, -1.0, 1.0, nan, infinity, 1e300, 1e-300, 5e-324];
        let mut answers = 0;
        for (k, m) in numbers.iter().flat_map(|&k| numbers.map(|m| (k, m))) {
            for b in numbers {
                let Ok(system) = try_one_node(k, m, &[[b, 0.0, 1.0]]) else {
                    continue;
                };
                if let Ok(found) = InfSup::new(&system) {
                    answers += 1;
                    assert!(
                        found.constant >= 0.0 && found.largest.is_finite(),
                        "{found:?}"
                    );
                    assert!(found.require(f64::NAN).is_err());
                }
            }
        }
        assert!(answers > 0);
    }

    #[test]
    fn constrained_components_are_refused() {
        let velocity = Bordered::scalar(Csr::eye(1)).unwrap();
        let velocity = velocity.with_constrained_dofs(&[(0, [true, false, false])]);
        let divergence = Csr3::new((1, 1), vec![0, 1], vec![0], vec![[0.0, 1.0, 1.0]]);
        let border = Csr::zero((1, 0));
        let system = SaddleSystem::new(velocity.unwrap(), divergence, border, None, Csr::eye(1));
        assert!(InfSup::new(&system.unwrap()).is_err());
    }
}
