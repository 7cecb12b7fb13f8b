//! What a formulation is: a way to turn the fluid block and the constraints into one system, and back.

use linalg::{Bordered, Csr, SaddleSystem, Transfer};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::articulation::check_length;
use crate::{Articulation, BodyKind, Constraints, RigidError, RigidFluid, StateVelocity};

/// What drives an articulated set at one instant.
#[derive(Clone, Debug)]
pub struct Drive<'a> {
    /// The bodies and their links.
    pub set: &'a Articulation,
    /// The constraints of the links at this instant.
    pub constraints: &'a Constraints,
    /// External force and torque on each body (points take a force only).
    pub loads: &'a [Load],
}

/// External force and torque on a body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Force.
    pub force: Vector3<f64>,
    /// Torque about the body's centre.
    pub torque: Vector3<f64>,
}

impl Drive<'_> {
    /// External loads as work-conjugate of the generalised velocities.
    ///
    /// # Errors
    /// A list of loads of the wrong length.
    pub fn generalised_loads(&self) -> Result<DVector<f64>, RigidError> {
        check_length(
            "loads on the bodies",
            self.loads.len(),
            self.set.kinds().len(),
        )?;
        let layout = &self.constraints.layout;
        let mut loads = DVector::zeros(layout.len());
        for (body, load) in self.loads.iter().enumerate() {
            let first = layout.body(body);
            loads.fixed_rows_mut::<3>(first).copy_from(&load.force);
            if self.set.kinds()[body] == BodyKind::Rigid {
                loads.fixed_rows_mut::<3>(first + 3).copy_from(&load.torque);
            }
        }
        Ok(loads)
    }

    /// Rows of the generalised velocities that belong to bodies with surfaces: six a body.
    pub fn surface_rows(&self) -> Vec<usize> {
        let layout = &self.constraints.layout;
        (0..self.set.kinds().len())
            .filter(|&body| self.set.kinds()[body] == BodyKind::Rigid)
            .flat_map(|body| layout.body(body)..layout.body(body) + 6)
            .collect()
    }
}

/// A way to impose the links' constraints on the flow around rigid bodies.
pub trait Formulation: Sync {
    /// Name for reports and scene files.
    fn name(&self) -> &'static str;

    /// Builds the system of one instant.
    ///
    /// # Errors
    /// Constraints that contradict each other, or sizes that do not fit.
    fn constrain(&self, fluid: RigidFluid, drive: &Drive) -> Result<Constrained, RigidError>;
}

/// The system of one instant, with the multigrid transfer it needs and the way back to velocities and forces.
#[derive(Clone, Debug)]
pub struct Constrained {
    /// The system `[velocity | border | pressure]`.
    pub system: SaddleSystem,
    /// Right-hand side.
    pub right: Vec<f64>,
    /// From the free vertices' functions to those of all free nodes.
    pub transfer: Transfer,
    /// Stiffness of the free vertices: the coarse operator of `transfer`.
    pub vertex_stiffness: Csr,
    /// Generalised velocities from the border unknowns: `q = basis v + offset`.
    velocities: (DMatrix<f64>, DVector<f64>),
    surface_rows: Vec<usize>,
    /// What forces are computed from: the unreduced border.
    surfaces: RigidFluid,
}

/// Velocities, forces and pressure of one instant.
#[derive(Clone, Debug)]
pub struct Flow {
    /// Velocity at every node.
    pub velocity: Vec<Vector3<f64>>,
    /// Pressure at every pressure unknown, mean removed with the given weights.
    pub pressure: Vec<f64>,
    /// Generalised velocities (see [`crate::VelocityLayout`]).
    pub generalised: DVector<f64>,
    /// `(U, omega)` of each rigid body.
    pub bodies: DVector<f64>,
    /// `(F, T)` that each rigid body exerts on the fluid.
    pub forces: DVector<f64>,
    /// Rate of change of the articulated set's state.
    pub state: StateVelocity,
}

impl Constrained {
    /// Joins the fluid block and a border whose columns are combinations of rigid motions:
    /// body velocities `U = S v + W` with `S` = `basis` and `W` = `offset` on `surface_rows`.
    ///
    /// The right-hand side is `-C W` for the flow, `S^T (F - M W)` for the bodies (`loads` = `S^T F`) and `-E W` for
    /// incompressibility.
    pub(crate) fn eliminated(
        mut fluid: RigidFluid,
        basis: DMatrix<f64>,
        offset: DVector<f64>,
        surface_rows: Vec<usize>,
        loads: &DVector<f64>,
    ) -> Result<Self, RigidError> {
        let surface_basis = basis.select_rows(&surface_rows);
        let surface_offset = offset.select_rows(&surface_rows);
        check_length(
            "velocities of rigid surfaces",
            surface_rows.len(),
            fluid.corner.nrows(),
        )?;
        let mut right: Vec<f64> = negated_product(&fluid.border, &surface_offset);
        right.extend((loads - surface_basis.tr_mul(&(&fluid.corner * &surface_offset))).iter());
        right.extend(negated_product(&fluid.rigid_divergence, &surface_offset));
        let columns = to_csr(&surface_basis);
        let a = Bordered::new(
            std::mem::replace(&mut fluid.stiffness, Csr::zero((0, 0))),
            &fluid.border * &columns,
            None,
            surface_basis.tr_mul(&(&fluid.corner * &surface_basis)),
        )?;
        let system = SaddleSystem::new(
            a,
            std::mem::replace(&mut fluid.divergence, linalg::Csr3::zero((0, 0))),
            &fluid.rigid_divergence * &columns,
            None,
            std::mem::replace(&mut fluid.pressure_mass, Csr::zero((0, 0))),
        )?;
        let transfer = Transfer::new(
            std::mem::replace(&mut fluid.interpolation, Csr::zero((0, 0))),
            &fluid.interpolation_border * &columns,
        )?;
        let vertex_stiffness = std::mem::replace(&mut fluid.vertex_stiffness, Csr::zero((0, 0)));
        Ok(Self {
            system,
            right,
            transfer,
            vertex_stiffness,
            velocities: (basis, offset),
            surface_rows,
            surfaces: fluid,
        })
    }

    /// Velocities, forces and pressure from a solution of the system.
    ///
    /// # Errors
    /// A solution of the wrong length.
    pub fn flow(&self, solution: &[f64], set: &Articulation) -> Result<Flow, RigidError> {
        check_length("entries of the solution", solution.len(), self.right.len())?;
        let (basis, offset) = &self.velocities;
        let (free, rest) = solution.split_at(3 * self.surfaces.free_nodes.len());
        let (border, pressure) = rest.split_at(basis.ncols());
        let generalised = basis * DVector::from_column_slice(border) + offset;
        let bodies = generalised.select_rows(&self.surface_rows);
        Ok(Flow {
            velocity: self.surfaces.all_velocities(free, &bodies),
            forces: self.surfaces.forces(free, &bodies, pressure),
            pressure: pressure.to_vec(),
            state: set.state_velocity(generalised.as_slice())?,
            generalised,
            bodies,
        })
    }
}

fn negated_product(matrix: &Csr, x: &DVector<f64>) -> Vec<f64> {
    matrix
        .outer_iterator()
        .map(|row| -row.iter().map(|(j, &a)| a * x[j as usize]).sum::<f64>())
        .collect()
}

/// The nonzeros of a small dense matrix.
fn to_csr(dense: &DMatrix<f64>) -> Csr {
    let (mut pointers, mut indices, mut values) = (vec![0], Vec::new(), Vec::new());
    for row in dense.row_iter() {
        for (column, &value) in row.iter().enumerate().filter(|(_, v)| **v != 0.0) {
            indices.push(column as u32);
            values.push(value);
        }
        pointers.push(indices.len());
    }
    Csr::new(dense.shape(), pointers, indices, values)
}
