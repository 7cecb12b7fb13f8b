//! Incomplete LU without pivoting: a common default of general-purpose packages, which fails here.

use linalg::{Preconditioner, PreconditionerKind, SaddleSystem};

/// Factors `L U` of the whole system on its own sparsity pattern, in a given order of the dofs.
///
/// Source: Saad, Iterative Methods, 10.3.
pub struct Ilu0 {
    /// Position of each dof in the elimination.
    position: Vec<usize>,
    /// Rows of `L` (without its unit diagonal) and `U`, sorted by column, in the order of
    /// elimination.
    rows: Vec<Vec<(usize, f64)>>,
}

impl Ilu0 {
    /// Factorises the system; `order[k]` is the dof that is eliminated in step `k`.
    ///
    /// # Errors
    /// The dof whose pivot is zero or not finite.
    pub fn new(system: &SaddleSystem, order: &[usize]) -> Result<Self, String> {
        let mut position = vec![0; order.len()];
        for (k, &dof) in order.iter().enumerate() {
            position[dof] = k;
        }
        let natural = monolithic(system);
        let mut rows: Vec<Vec<(usize, f64)>> = order
            .iter()
            .map(|&dof| {
                let mut row: Vec<(usize, f64)> = natural[dof]
                    .iter()
                    .map(|&(j, v)| (position[j], v))
                    .collect();
                row.sort_unstable_by_key(|entry| entry.0);
                row
            })
            .collect();
        let mut at = vec![usize::MAX; rows.len()];
        for k in 0..rows.len() {
            let mut row = std::mem::take(&mut rows[k]);
            row.iter()
                .enumerate()
                .for_each(|(place, entry)| at[entry.0] = place);
            for place in 0..row.len() {
                let (j, value) = row[place];
                if j >= k {
                    break;
                }
                let pivot = entry(&rows[j], j);
                let factor = value / pivot;
                row[place].1 = factor;
                for &(column, upper) in rows[j].iter().filter(|entry| entry.0 > j) {
                    if at[column] != usize::MAX {
                        row[at[column]].1 -= factor * upper;
                    }
                }
            }
            row.iter().for_each(|entry| at[entry.0] = usize::MAX);
            let pivot = entry(&row, k);
            if pivot == 0.0 || !pivot.is_finite() {
                return Err(format!("pivot of dof {} is {pivot}", order[k]));
            }
            rows[k] = row;
        }
        Ok(Self { position, rows })
    }
}

impl Preconditioner for Ilu0 {
    fn size(&self) -> usize {
        self.rows.len()
    }

    fn apply(&mut self, r: &[f64], z: &mut [f64]) {
        let mut x = vec![0.0; r.len()];
        for (dof, &k) in self.position.iter().enumerate() {
            x[k] = r[dof];
        }
        for k in 0..x.len() {
            let lower = self.rows[k].iter().take_while(|entry| entry.0 < k);
            x[k] -= lower.map(|&(j, v)| v * x[j]).sum::<f64>();
        }
        for k in (0..x.len()).rev() {
            let upper = self.rows[k].iter().filter(|entry| entry.0 > k);
            x[k] = (x[k] - upper.map(|&(j, v)| v * x[j]).sum::<f64>()) / entry(&self.rows[k], k);
        }
        for (dof, &k) in self.position.iter().enumerate() {
            z[dof] = x[k];
        }
    }

    fn kind(&self) -> PreconditionerKind {
        PreconditionerKind::Linear
    }
}

fn entry(row: &[(usize, f64)], column: usize) -> f64 {
    row.binary_search_by_key(&column, |entry| entry.0)
        .map_or(0.0, |place| row[place].1)
}

/// All rows of a system as (column, value), with zeros on the diagonal stored.
fn monolithic(system: &SaddleSystem) -> Vec<Vec<(usize, f64)>> {
    let a = system.velocity_block();
    let (velocity, border) = (system.velocity_range().end, system.border_range());
    let mut rows = vec![Vec::new(); system.pressure_range().end];
    for (i, row) in a.stiffness().outer_iterator().enumerate() {
        for (j, &value) in row.iter() {
            (0..3).for_each(|axis| rows[3 * i + axis].push((3 * j + axis, value)));
        }
    }
    // Columns from `border` and `divergence`, rows from their left counterparts.
    for (i, row) in a.border().outer_iterator().enumerate() {
        row.iter()
            .for_each(|(j, &value)| rows[i].push((velocity + j, value)));
    }
    for (i, row) in a
        .border_left()
        .unwrap_or(a.border())
        .outer_iterator()
        .enumerate()
    {
        row.iter()
            .for_each(|(j, &value)| rows[velocity + j].push((i, value)));
    }
    for (i, row) in a.corner().row_iter().enumerate() {
        for (j, &value) in row.iter().enumerate() {
            if value != 0.0 || i == j {
                rows[velocity + i].push((velocity + j, value));
            }
        }
    }
    for (q, row) in system.divergence().outer_iterator().enumerate() {
        for (j, values) in row.iter() {
            for (axis, &value) in values.iter().enumerate() {
                rows[border.end + q].push((3 * j + axis, value));
                rows[3 * j + axis].push((border.end + q, value));
            }
        }
        rows[border.end + q].push((border.end + q, 0.0));
    }
    for (q, row) in system.border_divergence().outer_iterator().enumerate() {
        row.iter()
            .for_each(|(j, &value)| rows[border.end + q].push((velocity + j, value)));
    }
    let left = system
        .border_divergence_left()
        .unwrap_or(system.border_divergence());
    for (q, row) in left.outer_iterator().enumerate() {
        row.iter()
            .for_each(|(j, &value)| rows[velocity + j].push((border.end + q, value)));
    }
    rows
}
