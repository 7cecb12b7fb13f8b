//! Elimination of velocity constraints: all solutions of `C q = w` as `q = S v + W`.

use nalgebra::{DMatrix, DVector};

use crate::error::check_length;
use crate::{Articulation, Constraints, RigidError};

/// All velocities that satisfy a set of constraints: `q = basis v + offset`.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct NullSpace {
    /// Basis of the null space of the constraints, of full column rank.
    ///
    /// Each column is a unit value of one velocity (of a root, a frame or a freely rotating body)
    /// and the values of the others that follow from it, as in the operator P-tilde of Berti et
    /// al. (2021).
    pub basis: DMatrix<f64>,
    /// A particular solution of the constraints.
    pub offset: DVector<f64>,
    /// Indices of a largest set of linearly independent rows; the other rows are redundant.
    pub independent: Vec<usize>,
    /// Gauge rows `g q = 0` for motions that neither constraints nor the fluid determine.
    ///
    /// An example is the rotation of a collinear free frame about its own axis.
    pub gauge: DMatrix<f64>,
    /// The motions that the gauge rows prescribe as zero, one per column.
    pub unresisted: DMatrix<f64>,
    /// Indices of the free velocities, before motions without resistance are removed.
    free: Vec<usize>,
}

/// Relative size below which an entry is rounding: constraint entries are 1 or arm lengths.
const RANK_TOLERANCE: f64 = 1e-10;

/// Factor on the size of a pivot in a column that should stay free.
const MASTER_WEIGHT: f64 = 1e-3;

/// Factor on the size of a pivot in a row that gives a single velocity. Beyond the ratio of the
/// entries of other rows, so that this velocity is given to the last bit and its row carries the
/// load.
const SINGLE_WEIGHT: f64 = 1e12;

impl NullSpace {
    /// Eliminates the constraints by Gauss-Jordan steps with complete pivoting.
    ///
    /// `masters[j]` marks velocities that should stay free (those of roots and frames); the others
    /// become functions of them. Rows with a single entry give a velocity and are never redundant
    /// with those of joints. Redundant constraints are dropped if they agree with the rest.
    /// Cost: `O(rows^2 columns)` for a small dense matrix.
    ///
    /// # Errors
    /// [`RigidError::IncompatibleJoints`] names a joint that contradicts the others;
    /// [`RigidError::Length`] for another number of masters than velocities,
    /// [`RigidError::OtherSet`] and [`RigidError::NotFinite`] for constraints that were changed.
    pub fn new(constraints: &Constraints, masters: &[bool]) -> Result<Self, RigidError> {
        constraints.check()?;
        let (rows, columns) = constraints.matrix.shape();
        check_length("masters", masters.len(), columns)?;
        let mut matrix = constraints.matrix.clone();
        let mut rhs = constraints.rates.clone();
        let mut labels: Vec<usize> = (0..rows).collect();
        let scale = matrix.amax();
        let rate_scale = rhs.amax();
        let single: Vec<bool> = (matrix.row_iter())
            .map(|row| row.iter().filter(|entry| **entry != 0.0).count() == 1)
            .collect();
        let weight = |row: usize, column: usize| match (single[row], masters[column]) {
            (true, _) => SINGLE_WEIGHT,
            (false, true) => MASTER_WEIGHT,
            (false, false) => 1.0,
        };
        let mut pivots = Vec::new();
        for step in 0..rows.min(columns) {
            let candidates = (step..rows).flat_map(|i| (0..columns).map(move |j| (i, j)));
            let Some((row, column)) = candidates
                .filter(|&(i, j)| matrix[(i, j)].abs() > RANK_TOLERANCE * scale)
                .reduce(|a, b| {
                    let size = |at: (usize, usize)| matrix[at].abs() * weight(labels[at.0], at.1);
                    if size(b) > size(a) { b } else { a }
                })
            else {
                break;
            };
            matrix.swap_rows(step, row);
            rhs.swap_rows(step, row);
            labels.swap(step, row);
            let pivot = matrix[(step, column)];
            matrix.row_mut(step).scale_mut(1.0 / pivot);
            rhs[step] /= pivot;
            for other in (0..rows).filter(|&i| i != step) {
                let factor = matrix[(other, column)];
                if factor != 0.0 {
                    for j in 0..columns {
                        matrix[(other, j)] -= factor * matrix[(step, j)];
                    }
                    rhs[other] -= factor * rhs[step];
                }
            }
            pivots.push(column);
        }
        for row in pivots.len()..rows {
            // A row without entries left is redundant if its right-hand side vanished too.
            if rhs[row].abs() > 1e-9 * rate_scale {
                return Err(RigidError::IncompatibleJoints {
                    joint: constraints.labels[labels[row]].clone(),
                    mismatch: rhs[row].abs(),
                });
            }
        }
        let free: Vec<usize> = (0..columns).filter(|j| !pivots.contains(j)).collect();
        let mut basis = DMatrix::zeros(columns, free.len());
        let mut offset = DVector::zeros(columns);
        for (k, &column) in free.iter().enumerate() {
            basis[(column, k)] = 1.0;
            for (row, &pivot) in pivots.iter().enumerate() {
                basis[(pivot, k)] = -matrix[(row, column)];
            }
        }
        for (row, &pivot) in pivots.iter().enumerate() {
            offset[pivot] = rhs[row];
        }
        labels.truncate(pivots.len());
        labels.sort_unstable();
        Ok(Self {
            basis,
            offset,
            independent: labels,
            gauge: DMatrix::zeros(0, columns),
            unresisted: DMatrix::zeros(columns, 0),
            free,
        })
    }

    /// The independent constraint rows, gauge rows below them.
    ///
    /// Their number and the number of force balances of the free motions add up to the number of
    /// velocities.
    pub(crate) fn constraint_rows(&self, constraints: &Constraints) -> DMatrix<f64> {
        let independent = constraints.matrix.select_rows(&self.independent);
        let mut rows = DMatrix::zeros(
            independent.nrows() + self.gauge.nrows(),
            independent.ncols(),
        );
        rows.rows_mut(0, independent.nrows())
            .copy_from(&independent);
        rows.rows_mut(independent.nrows(), self.gauge.nrows())
            .copy_from(&self.gauge);
        rows
    }

    /// Removes motions that move no surface: the fluid does not resist them.
    ///
    /// An example is the rotation of a collinear free frame about its own axis. The flow does not
    /// determine such motions; they are set to zero. `surface_rows` lists the generalised
    /// velocities of bodies with surfaces.
    fn drop_unresisted(&mut self, surface_rows: &[usize]) {
        let moved = self.basis.select_rows(surface_rows);
        // an empty matrix has no singular value decomposition; without dofs there is nothing to do
        if moved.is_empty() {
            return;
        }
        let decomposition = moved.svd(false, true);
        let Some(v_t) = decomposition.v_t else { return };
        let largest = decomposition.singular_values.amax();
        let kept: Vec<usize> = (0..decomposition.singular_values.len())
            .filter(|&k| decomposition.singular_values[k] > RANK_TOLERANCE * largest)
            .collect();
        if kept.len() < self.basis.ncols() {
            let kept = v_t.select_rows(&kept).transpose();
            // The dofs `v` are the free velocities themselves; each removed combination of them
            // becomes a gauge row.
            let dropped = orthonormal_columns(
                DMatrix::identity(kept.nrows(), kept.nrows()) - &kept * kept.transpose(),
            );
            self.gauge = DMatrix::zeros(dropped.ncols(), self.basis.nrows());
            for (k, &velocity) in self.free.iter().enumerate() {
                self.gauge.set_column(velocity, &dropped.row(k).transpose());
            }
            self.unresisted = &self.basis * dropped;
            self.basis = &self.basis * kept;
        }
    }
}

/// An orthonormal basis of the range of an orthogonal projector.
fn orthonormal_columns(projector: DMatrix<f64>) -> DMatrix<f64> {
    let decomposition = projector.svd(true, false);
    // Singular values of a projector are 0 or 1.
    let range: Vec<usize> = (0..decomposition.singular_values.len())
        .filter(|&k| decomposition.singular_values[k] > 0.5)
        .collect();
    decomposition
        .u
        .map(|u| u.select_columns(&range))
        .unwrap_or_else(|| DMatrix::zeros(0, 0))
}

/// The motions that joints allow: `U = S v + W` for bodies with surfaces, and all other velocities.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Reduction {
    /// `S`: velocities `(U, ω)` of the rigid bodies, six rows per body, full column rank.
    pub surface_basis: DMatrix<f64>,
    /// `W`: velocities of the rigid bodies that the rates impose.
    pub surface_offset: DVector<f64>,
    /// These motions in terms of all generalised velocities.
    pub all: NullSpace,
}

impl Reduction {
    /// Eliminates the joints' constraints from the velocities of an articulated set.
    ///
    /// # Errors
    /// Joints that contradict each other, constraints of another set.
    pub fn new(set: &Articulation, constraints: &Constraints) -> Result<Self, RigidError> {
        let layout = &constraints.layout;
        if *layout != set.velocity_layout() {
            return Err(RigidError::OtherSet);
        }
        let mut masters = vec![false; layout.len()];
        for linkage in set.linkages() {
            let root = layout.bodies()[linkage.root];
            masters[root..root + 3].fill(true);
            if let Some(frame) = layout.frame(linkage.first_frame) {
                masters[frame..frame + 3].fill(true);
            }
        }
        for joint in layout.joints() {
            masters[joint] = true;
        }
        let surface_rows = set.surface_velocities();
        let mut all = NullSpace::new(constraints, &masters)?;
        all.drop_unresisted(&surface_rows);
        Ok(Self {
            surface_basis: all.basis.select_rows(&surface_rows),
            surface_offset: all.offset.select_rows(&surface_rows),
            all,
        })
    }

    /// Number of dofs `v`.
    pub fn dofs(&self) -> usize {
        self.surface_basis.ncols()
    }

    /// All generalised velocities for the dofs `v`.
    ///
    /// # Errors
    /// A `v` of the wrong length.
    pub fn velocities(&self, v: &DVector<f64>) -> Result<DVector<f64>, RigidError> {
        let NullSpace { basis, offset, .. } = &self.all;
        check_length("dofs of the motion", v.len(), basis.ncols())?;
        check_length("rows of the basis", basis.nrows(), offset.len())?;
        Ok(basis * v + offset)
    }
}
