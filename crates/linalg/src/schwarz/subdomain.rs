//! One subdomain: its dofs and its factors.

use nalgebra::DMatrix;

use crate::csr::{Csr, Csr3, Rows};
use crate::direct::{Precision, SaddleFactor};
use crate::product::build_rows;
use crate::{Bordered, LinalgError, Preconditioner, SaddleSystem};

/// Pressure shift of local factors, that of [`DirectParams`](crate::DirectParams) for f32.
const PRESSURE_SHIFT: f64 = 1e-4;

/// The nodes, border dofs and pressures of a subdomain, in ascending order.
///
/// `owned` marks those that no other subdomain updates.
pub(super) struct Members {
    pub nodes: Vec<u32>,
    pub border: Vec<u32>,
    pub pressures: Vec<u32>,
    /// Whether the node, then the pressure, belongs to the subdomain rather than to its overlap.
    pub owned: Vec<bool>,
}

/// The factors of the system restricted to the members.
pub(super) struct Subdomain {
    /// Positions of the local dofs in the whole system.
    dofs: Vec<u32>,
    owned: Vec<bool>,
    factor: SaddleFactor,
    residual: Vec<f64>,
    solution: Vec<f64>,
}

impl Subdomain {
    /// Restricts the system to the members and factorises it.
    ///
    /// # Errors
    /// [`LinalgError::Factorisation`] for a singular restriction.
    pub fn new(system: &SaddleSystem, members: &Members) -> Result<Self, LinalgError> {
        let local = restrict(system, members)?;
        if let Some(c) = uncoupled(&local) {
            let detail = format!(
                "border dof {} has no coupling in it (a multiplier without its bodies); assign both to one subdomain, or eliminate the border",
                members.border[c]
            );
            let what = "the restricted system";
            return Err(LinalgError::Factorisation { what, detail });
        }
        let (border, pressure) = (system.border_range().start, system.pressure_range().start);
        let velocities = members.nodes.iter().flat_map(|i| 3 * i..3 * i + 3);
        let dofs = velocities
            .chain(members.border.iter().map(|c| border as u32 + c))
            .chain(members.pressures.iter().map(|q| pressure as u32 + q));
        let dofs: Vec<u32> = dofs.collect();
        let (nodes, pressures) = members.owned.split_at(members.nodes.len());
        let owned = nodes.iter().flat_map(|o| [*o; 3]);
        let owned = owned
            .chain(members.border.iter().map(|_| true))
            .chain(pressures.iter().copied());
        Ok(Subdomain {
            owned: owned.collect(),
            residual: vec![0.0; dofs.len()],
            solution: vec![0.0; dofs.len()],
            dofs,
            factor: SaddleFactor::new(&local, PRESSURE_SHIFT, Precision::Single)?,
        })
    }

    /// Solves for the residual `r` of the whole system.
    pub fn solve(&mut self, r: &[f64]) {
        for (local, i) in self.residual.iter_mut().zip(&self.dofs) {
            *local = r[*i as usize];
        }
        self.factor.apply(&self.residual, &mut self.solution);
    }

    /// Writes the last solution to the dofs of `z` that the subdomain owns.
    pub fn write_owned(&self, z: &mut [f64]) {
        for ((i, owned), v) in self.dofs.iter().zip(&self.owned).zip(&self.solution) {
            if *owned {
                z[*i as usize] = *v;
            }
        }
    }

    /// Number of dofs, the overlap included.
    pub fn dofs(&self) -> usize {
        self.dofs.len()
    }

    /// Bytes of the factors.
    pub fn bytes(&self) -> usize {
        self.factor.bytes()
    }
}

/// The system restricted to the members.
fn restrict(system: &SaddleSystem, members: &Members) -> Result<SaddleSystem, LinalgError> {
    let a = system.velocity_block();
    let Members {
        nodes,
        border,
        pressures,
        ..
    } = members;
    let velocities: Vec<u32> = nodes.iter().flat_map(|i| 3 * i..3 * i + 3).collect();
    let left = |matrix: Option<&Csr>, rows: &[u32]| matrix.map(|m| submatrix(m, rows, border));
    let local = Bordered::new(
        submatrix(a.stiffness(), nodes, nodes),
        submatrix(a.border(), &velocities, border),
        left(a.border_left(), &velocities),
        DMatrix::from_fn(border.len(), border.len(), |c, d| {
            a.corner()[(border[c] as usize, border[d] as usize)]
        }),
    )?;
    SaddleSystem::new(
        local,
        submatrix3(system.divergence(), pressures, nodes),
        submatrix(system.border_divergence(), pressures, border),
        left(system.border_divergence_left(), pressures),
        submatrix(system.pressure_mass(), pressures, pressures),
    )
}

/// The first border dof whose row is zero.
fn uncoupled(local: &SaddleSystem) -> Option<usize> {
    let a = local.velocity_block();
    let (u, p) = (
        Rows::new(a.border_rows()),
        Rows::new(local.border_gradient()),
    );
    (0..a.border_len()).find(|&c| {
        u.row(c).all(|(_, v)| v == 0.0)
            && p.row(c).all(|(_, v)| v == 0.0)
            && a.corner().row(c).iter().all(|v| *v == 0.0)
    })
}

/// Positions of `members` in a list of `size`, `u32::MAX` for the others.
fn positions(members: &[u32], size: usize) -> Vec<u32> {
    let mut positions = vec![u32::MAX; size];
    for (local, i) in members.iter().enumerate() {
        positions[*i as usize] = local as u32;
    }
    positions
}

fn submatrix(matrix: &Csr, rows: &[u32], cols: &[u32]) -> Csr {
    let (all, local) = (Rows::new(matrix), positions(cols, matrix.cols()));
    build_rows(rows.len(), cols.len(), |i, row| {
        for (j, v) in all.row(rows[i] as usize) {
            if local[j] != u32::MAX {
                row.add(local[j] as usize, v);
            }
        }
    })
}

fn submatrix3(matrix: &Csr3, rows: &[u32], cols: &[u32]) -> Csr3 {
    let (all, local) = (Rows::new(matrix), positions(cols, matrix.cols()));
    let (mut indptr, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for i in rows {
        // `cols` are in ascending order, hence the restricted columns too
        for (j, v) in all.row(*i as usize).filter(|(j, _)| local[*j] != u32::MAX) {
            columns.push(local[j]);
            values.push(v);
        }
        indptr.push(columns.len());
    }
    Csr3::new((rows.len(), cols.len()), indptr, columns, values)
}
