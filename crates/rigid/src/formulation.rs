//! What a formulation is: a way to turn the fluid block and the constraints into one system, and back.

use linalg::{
    BlockTriangular, Bordered, Csr, Multigrid, MultigridParams, Prolongation, SaddleSystem,
};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::articulation::check_length;
use crate::imposed::{clear, imposed_rhs};
use crate::link_loads::LinkLoads;
use crate::{Articulation, Drive, Imposed, RigidError, RigidFluid, StateVelocity};

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

/// What a formulation puts around the flow's equations.
pub(crate) struct Border {
    /// Generalised velocities for each border unknown; zero columns for multipliers.
    pub columns: DMatrix<f64>,
    /// The velocities that test each border row, where they differ from `columns`; zero columns for rows that
    /// are constraints.
    pub rows: Option<DMatrix<f64>>,
    /// The velocities that the links impose, `W`: they satisfy every constraint.
    pub offset: DVector<f64>,
    /// Entries of constraint rows and multiplier columns, added to the corner.
    pub constraints: Option<DMatrix<f64>>,
    /// What the loads of the links are found from; none without links.
    pub link_loads: Option<LinkLoads>,
    /// The first border unknown that is a multiplier.
    pub first_multiplier: Option<usize>,
}

/// The system of one instant, with the multigrid prolongation it needs and the way back to velocities and forces.
#[derive(Clone, Debug)]
pub struct Constrained {
    /// The system `[velocity | border | pressure]`.
    pub system: SaddleSystem,
    /// Right-hand side.
    pub rhs: Vec<f64>,
    /// From the free vertices' functions to those of all free nodes.
    pub prolongation: Prolongation,
    /// Stiffness of the free vertices: the coarse operator of `prolongation`.
    pub vertex_stiffness: Csr,
    /// Stiffness of narrow gaps, [`BlockTriangular::with_pressure_laplacian`], for the preconditioner; none where no gap is narrow.
    pub gap_stiffness: Option<Csr>,
    /// Generalised velocities from the border unknowns: `q = columns v + offset`.
    columns: DMatrix<f64>,
    /// The velocities that test the border rows; none if those of `columns`.
    tests: Option<DMatrix<f64>>,
    offset: DVector<f64>,
    surface_rows: Vec<usize>,
    link_loads: Option<LinkLoads>,
    first_multiplier: Option<usize>,
    /// What forces are computed from: the unreduced border.
    surfaces: RigidFluid,
}

/// A solution split by what its unknowns are.
struct Parts<'s> {
    /// Velocities of the free nodes.
    free: &'s [f64],
    border: DVector<f64>,
    pressure: &'s [f64],
}

/// Velocities, forces and pressure of one instant.
#[derive(Clone, Debug)]
pub struct FlowSolution {
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
    /// The loads that links put on bodies, one a row of [`Constraints::matrix`](crate::Constraints::matrix): bodies get `C^T link_loads` besides the
    /// external loads. Redundant rows carry zero. Rows 3l, 3l+1, 3l+2 are the force of link l on its `body`, its opposite
    /// acts on `to`; after the links come the torques of clamps.
    pub link_loads: DVector<f64>,
    /// Rate of change of the articulated set's state.
    pub state: StateVelocity,
}

impl FlowSolution {
    /// The force of a link on the body that its key `body` names; the opposite acts on the body `to`.
    ///
    /// Every formulation gives it: the multipliers of Berti et al. (2021), equations (16)-(18), up to sign, or what balances the
    /// bodies afterwards where velocities were eliminated.
    pub fn link_force(&self, link: usize) -> Vector3<f64> {
        Vector3::from_fn(|axis, _| self.link_loads[3 * link + axis])
    }
}

impl Constrained {
    /// Joins the fluid block and a border; the right-hand side is [`imposed_rhs`].
    pub(crate) fn build(
        mut fluid: RigidFluid,
        border: Border,
        surface_rows: Vec<usize>,
        loads: &DVector<f64>,
    ) -> Result<Self, RigidError> {
        check_length(
            "velocities of rigid surfaces",
            surface_rows.len(),
            fluid.corner.nrows(),
        )?;
        fluid.check_determined()?;
        let Border {
            columns,
            rows,
            offset,
            constraints,
            link_loads,
            first_multiplier,
        } = border;
        let surface_columns = columns.select_rows(&surface_rows);
        let tests = rows.as_ref().unwrap_or(&columns);
        let surface_tests = tests.select_rows(&surface_rows);
        let rhs = imposed_rhs(&fluid, tests, &surface_rows, loads, &offset);
        let mut corner = surface_tests.tr_mul(&(&fluid.corner * &surface_columns));
        if let Some(constraints) = &constraints {
            corner += constraints;
        }
        let trial = to_csr(&surface_columns);
        let test = rows.is_some().then(|| to_csr(&surface_tests));
        let take = |matrix: &mut Csr| std::mem::replace(matrix, Csr::zero((0, 0)));
        let stiffness = take(&mut fluid.stiffness);
        let interpolation = take(&mut fluid.interpolation);
        let interpolation_border = take(&mut fluid.interpolation_border);
        let (a, prolongation) = rayon::join(
            || {
                let left = test.as_ref().map(|test| &fluid.border * test);
                Bordered::new(stiffness, &fluid.border * &trial, left, corner)?
                    .with_constrained_dofs(&fluid.held)
            },
            || {
                let prolongation =
                    Prolongation::new(interpolation, &interpolation_border * &trial)?;
                match &test {
                    Some(test) => prolongation.with_left_border(&interpolation_border * test),
                    None => Ok(prolongation),
                }
            },
        );
        drop(interpolation_border);
        let system = SaddleSystem::new(
            a?,
            std::mem::replace(&mut fluid.divergence, linalg::Csr3::zero((0, 0))),
            &fluid.rigid_divergence * &trial,
            test.as_ref().map(|test| &fluid.rigid_divergence * test),
            take(&mut fluid.pressure_mass),
        )?;
        let vertex_stiffness = take(&mut fluid.vertex_stiffness);
        Ok(Self {
            system,
            rhs,
            prolongation: prolongation?,
            vertex_stiffness,
            gap_stiffness: None,
            columns,
            tests: rows,
            offset,
            surface_rows,
            link_loads,
            first_multiplier,
            surfaces: fluid,
        })
    }

    /// The right-hand side and the velocities that links impose at other rates than the system was built for, its matrix being the same.
    ///
    /// Bitwise those of a system built anew. Cost: an elimination of the small dense constraints and a pass over the border.
    ///
    /// # Errors
    /// [`RigidError::OtherLinks`] for a drive whose constraint rows or loads are others (that bodies are where the matrix has them is the caller's
    /// part), and for independent bodies, which have no rates; rates that contradict each other.
    pub fn imposed(&self, drive: &Drive) -> Result<Imposed, RigidError> {
        let (all, link_loads) = drive.reduced(self.surfaces.symmetry_planes())?;
        // The reduced rows are those of the matrix: all of it that links and their lengths determine.
        if self.link_loads.as_ref() != Some(&link_loads) {
            return Err(RigidError::OtherLinks);
        }
        let tests = self.tests.as_ref().unwrap_or(&self.columns);
        let loads = link_loads.external();
        Ok(Imposed {
            rhs: imposed_rhs(
                &self.surfaces,
                tests,
                &self.surface_rows,
                loads,
                &all.offset,
            ),
            offset: all.offset,
        })
    }

    /// The right-hand side for generalised loads alone, with all links held at their lengths.
    ///
    /// Its solution is the flow that answers for a velocity: in a symmetric system the error of the velocity conjugate to
    /// `loads` is the solution times the residual.
    ///
    /// # Errors
    /// Loads of the wrong length.
    pub fn rhs_of_loads(&self, loads: &DVector<f64>) -> Result<Vec<f64>, RigidError> {
        let tests = self.tests.as_ref().unwrap_or(&self.columns);
        check_length("generalised loads", loads.len(), tests.nrows())?;
        let mut rhs = vec![0.0; self.rhs.len()];
        let loads = tests.tr_mul(loads) / self.surfaces.symmetry_planes().parts();
        rhs[self.system.border_range()].copy_from_slice(loads.as_slice());
        Ok(rhs)
    }

    /// The right-hand side for forces on the nodes and sources of volume, with all links held at their lengths.
    ///
    /// Shapes: `velocity` three entries a node of the mesh, those on walls of no effect; `pressure` one entry a pressure unknown, which add up to zero in enclosed flow. In a symmetric
    /// system it is the transpose of [`Constrained::flow_of_loads`].
    ///
    /// # Errors
    /// Arrays of the wrong length.
    pub fn rhs_of_forces(
        &self,
        velocity: &[f64],
        pressure: &[f64],
    ) -> Result<Vec<f64>, RigidError> {
        check_length(
            "forces on the nodes",
            velocity.len(),
            3 * self.surfaces.nodes(),
        )?;
        let pressures = self.system.pressure_range();
        check_length("sources of volume", pressure.len(), pressures.len())?;
        let tests = self.tests.as_ref().unwrap_or(&self.columns);
        let on_surfaces = self.surfaces.loads_of_forces(velocity);
        let border = tests.select_rows(&self.surface_rows).tr_mul(&on_surfaces);
        let nodes = self
            .surfaces
            .free_nodes
            .iter()
            .map(|&node| 3 * node as usize);
        let mut rhs: Vec<f64> = nodes
            .flat_map(|first| &velocity[first..first + 3])
            .copied()
            .collect();
        clear(&self.surfaces.held, &mut rhs);
        rhs.extend(border.iter());
        rhs.extend(pressure);
        Ok(rhs)
    }

    /// Generalised velocities of a solution for [`Constrained::rhs_of_loads`] or [`Constrained::rhs_of_forces`].
    ///
    /// # Errors
    /// A solution of the wrong length.
    pub fn generalised_of_loads(&self, solution: &[f64]) -> Result<DVector<f64>, RigidError> {
        Ok(&self.columns * self.parts(solution)?.border)
    }

    /// Velocity at every node and pressure of a solution for [`Constrained::rhs_of_loads`] or [`Constrained::rhs_of_forces`].
    ///
    /// # Errors
    /// A solution of the wrong length.
    pub fn flow_of_loads(
        &self,
        solution: &[f64],
    ) -> Result<(Vec<Vector3<f64>>, Vec<f64>), RigidError> {
        let Parts {
            free,
            border,
            pressure,
        } = self.parts(solution)?;
        let bodies = (&self.columns * border).select_rows(&self.surface_rows);
        Ok((
            self.surfaces.all_velocities(free, &bodies),
            pressure.to_vec(),
        ))
    }

    /// A solution split by what its unknowns are.
    fn parts<'s>(&self, solution: &'s [f64]) -> Result<Parts<'s>, RigidError> {
        check_length("entries of the solution", solution.len(), self.rhs.len())?;
        let (free, rest) = solution.split_at(3 * self.surfaces.free_nodes.len());
        let (border, pressure) = rest.split_at(self.columns.ncols());
        Ok(Parts {
            free,
            border: DVector::from_column_slice(border),
            pressure,
        })
    }

    /// The preconditioner that suits every formulation: block triangular, with body-aware multigrid for velocities and border.
    ///
    /// # Errors
    /// A matrix that multigrid cannot treat.
    pub fn preconditioner(&self) -> Result<BlockTriangular, RigidError> {
        let multigrid = Multigrid::with_prolongation(
            self.system.velocity_block(),
            &self.prolongation,
            Some(self.vertex_stiffness.clone()),
            &MultigridParams::default(),
        )?;
        let block = BlockTriangular::new(&self.system, multigrid)?;
        Ok(match &self.gap_stiffness {
            Some(stiffness) => block.with_pressure_laplacian(stiffness)?,
            None => block,
        })
    }

    /// The number of velocities when every one is an unknown of its own and nothing else is in the border.
    pub(crate) fn independent_velocities(&self) -> Result<usize, RigidError> {
        let velocities = self.columns.nrows();
        let is_independent = self.link_loads.is_none()
            && velocities == self.columns.ncols()
            && velocities == 6 * self.surfaces.bodies();
        is_independent
            .then_some(velocities)
            .ok_or(RigidError::NotIndependent)
    }

    /// Velocities, forces and pressure from a solution of the system.
    ///
    /// # Errors
    /// A solution of the wrong length.
    pub fn flow(&self, solution: &[f64], set: &Articulation) -> Result<FlowSolution, RigidError> {
        self.flow_with(solution, &self.offset, set)
    }

    /// As [`Constrained::flow`], from a solution for the right-hand side of other rates.
    ///
    /// # Errors
    /// A solution of the wrong length, or imposed velocities of another number.
    pub fn flow_at(
        &self,
        solution: &[f64],
        imposed: &Imposed,
        set: &Articulation,
    ) -> Result<FlowSolution, RigidError> {
        check_length(
            "imposed velocities",
            imposed.offset.len(),
            self.offset.len(),
        )?;
        self.flow_with(solution, &imposed.offset, set)
    }

    fn flow_with(
        &self,
        solution: &[f64],
        offset: &DVector<f64>,
        set: &Articulation,
    ) -> Result<FlowSolution, RigidError> {
        let Parts {
            free,
            border,
            pressure,
        } = self.parts(solution)?;
        let generalised = &self.columns * &border + offset;
        let bodies = generalised.select_rows(&self.surface_rows);
        let forces = self.surfaces.forces(free, &bodies, pressure);
        // Multipliers of parts of bodies hold them against their other parts too.
        let is_whole = self.surfaces.symmetry_planes().is_empty();
        let link_loads = match (&self.link_loads, self.first_multiplier.filter(|_| is_whole)) {
            (None, _) => DVector::zeros(0),
            (Some(loads), Some(first)) => loads.of_multipliers(&border.as_slice()[first..]),
            (Some(loads), None) => loads.balancing(&forces)?,
        };
        Ok(FlowSolution {
            velocity: self.surfaces.all_velocities(free, &bodies),
            forces,
            link_loads,
            pressure: pressure.to_vec(),
            state: set.state_velocity(generalised.as_slice())?,
            generalised,
            bodies,
        })
    }
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
