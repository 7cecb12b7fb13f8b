//! One subdomain: its dofs and its factors.

use nalgebra::DMatrix;
use sprs::CsMatI;

use crate::csr::{Csr, Rows};
use crate::direct::{Precision, SaddleFactor};
use crate::{Bordered, LinalgError, OMITTED, Preconditioner, SaddleSystem, submatrix};

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
    let left = |matrix: Option<&Csr>, rows: &[u32]| {
        let left = matrix.map(|matrix| part(matrix, rows, border));
        left.transpose()
    };
    let local = Bordered::new(
        part(a.stiffness(), nodes, nodes)?,
        part(a.border(), &velocities, border)?,
        left(a.border_left(), &velocities)?,
        DMatrix::from_fn(border.len(), border.len(), |c, d| {
            a.corner()[(border[c] as usize, border[d] as usize)]
        }),
    )?;
    SaddleSystem::new(
        local,
        part(system.divergence(), pressures, nodes)?,
        part(system.border_divergence(), pressures, border)?,
        left(system.border_divergence_left(), pressures)?,
        part(system.pressure_mass(), pressures, pressures)?,
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

/// The given rows and columns of a matrix.
fn part<T: Copy + Default + Send + Sync>(
    matrix: &CsMatI<T, u32, usize>,
    rows: &[u32],
    columns: &[u32],
) -> Result<CsMatI<T, u32, usize>, LinalgError> {
    let mut numbers = vec![OMITTED; matrix.cols()];
    for (number, column) in columns.iter().enumerate() {
        numbers[*column as usize] = number as u32;
    }
    submatrix(matrix, rows, &numbers, columns.len())
}
