//! The linear system of one configuration: how it is built, its right-hand sides, its solver.

use std::ops::Range;

use linalg::{
    BlockDiagonal, BlockTriangular, Bordered, Csr, Csr3, LinalgError, LinearOperator, Multigrid,
    MultigridParams, Prolongation, SaddleSystem, SchurInertia,
};
use nalgebra::{DMatrix, DVector, Vector3};

use crate::body_forces::Surfaces;
use crate::error::check_length;
use crate::fluid::{FluidBlocks, InertiaBlocks};
use crate::joint_loads::JointLoads;
use crate::mesh_part::Ownership;
use crate::{Drive, RigidError, RigidFluid, VelocityLayout};

/// The linear system of one configuration, with the data for its solvers and its solution.
///
/// Built by [`Formulation::constrain`](crate::Formulation::constrain). Solve
/// `system x = rhs` with any method of `linalg`, then read the answer with
/// [`flow`](Constrained::flow).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Constrained {
    /// The system `[velocity | border | pressure]`.
    pub system: SaddleSystem,
    /// Right-hand side.
    pub rhs: Vec<f64>,
    /// Prolongation from the functions of free vertices to those of all free nodes.
    pub prolongation: Prolongation,
    /// Stiffness of the free vertices: the coarse operator of `prolongation`.
    pub vertex_stiffness: Csr,
    pressure_stiffness: Option<Csr>,
    /// The mass matrix in the velocity block.
    inertia: Option<InertiaBlocks>,
    /// Generalised velocities from the border dofs: `q = columns v + offset`.
    pub(crate) border: Border,
    pub(crate) surface_rows: Vec<usize>,
    /// Meaning of the generalised velocities.
    pub(crate) layout: VelocityLayout,
    /// The couplings before the constraints were imposed: forces are computed from them.
    pub(crate) surfaces: Surfaces,
}

/// Velocities, constraints and multipliers that a formulation adds to the equations of the fluid.
#[derive(Clone, Debug)]
pub(crate) struct Border {
    /// Generalised velocities for each border dof; zero columns for multipliers.
    pub columns: DMatrix<f64>,
    /// Velocities with which each border row is tested, if they differ from `columns`; zero columns
    /// for rows that are constraints.
    pub rows: Option<DMatrix<f64>>,
    /// The velocities `W` that the joints impose: a particular solution of all constraints.
    pub offset: DVector<f64>,
    /// Entries of constraint rows and multiplier columns, added to the corner.
    pub constraints: Option<DMatrix<f64>>,
    /// Data for the loads of the joints; none without joints.
    pub joint_loads: Option<JointLoads>,
    /// The first border dof that is a multiplier.
    pub first_multiplier: Option<usize>,
}

impl Border {
    /// A symmetric border of the velocities `columns v + offset`, without constraints.
    pub fn new(columns: DMatrix<f64>, offset: DVector<f64>) -> Self {
        Self {
            columns,
            rows: None,
            offset,
            constraints: None,
            joint_loads: None,
            first_multiplier: None,
        }
    }

    /// Velocities with which the border rows are tested.
    fn tests(&self) -> &DMatrix<f64> {
        self.rows.as_ref().unwrap_or(&self.columns)
    }

    /// The rows and columns of the border itself, for bodies with these velocities and tests.
    fn corner(
        &self,
        surfaces: &Surfaces,
        drive: &Drive,
        trial: &DMatrix<f64>,
        test: &DMatrix<f64>,
    ) -> DMatrix<f64> {
        let mut corner = test.tr_mul(&(&surfaces.corner * trial));
        // Where symmetry planes cut bodies, the border has the forces on their parts.
        corner += drive.damping().projected(self.tests(), &self.columns)
            / surfaces.symmetry_planes.parts();
        if let Some(constraints) = &self.constraints {
            corner += constraints;
        }
        corner
    }
}

/// Right-hand side and velocities for one set of rates, from
/// [`Constrained::imposed`].
///
/// The matrix of a system depends on the configuration and on which joints there are, but not on
/// the rates of the joints: several rates are several right-hand sides of one matrix.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Imposed {
    /// Right-hand side.
    pub rhs: Vec<f64>,
    /// The velocities `W` that the joints impose.
    pub(crate) offset: DVector<f64>,
}

impl Constrained {
    /// Joins the equations of the fluid and a border; the right-hand side is [`imposed_rhs`].
    pub(crate) fn build(
        fluid: RigidFluid,
        border: Border,
        drive: &Drive,
        loads: &DVector<f64>,
    ) -> Result<Self, RigidError> {
        let RigidFluid { blocks, surfaces } = fluid;
        let surface_rows = drive.set.surface_velocities();
        check_length(
            "velocities of rigid surfaces",
            surface_rows.len(),
            surfaces.corner.nrows(),
        )?;
        surfaces.check_positions(&drive.constraints.rigid_positions)?;
        surfaces.check_determined()?;
        let rhs = imposed_rhs(
            &surfaces,
            border.tests(),
            &surface_rows,
            &(loads - drive.damping().times(&border.offset)),
            &border.offset,
        );
        let trial = border.columns.select_rows(&surface_rows);
        let test = border.tests().select_rows(&surface_rows);
        let corner = border.corner(&surfaces, drive, &trial, &test);
        let trial = to_csr(&trial);
        let test = border.rows.is_some().then(|| to_csr(&test));
        let FluidBlocks {
            stiffness,
            divergence,
            pressure_mass,
            interpolation,
            interpolation_border,
            vertex_stiffness,
            pressure_stiffness,
            inertia,
        } = blocks;
        let (a, prolongation) = rayon::join(
            || {
                let left = match (&surfaces.border_left, &test) {
                    (Some(left), test) => Some(left * test.as_ref().unwrap_or(&trial)),
                    (None, test) => test.as_ref().map(|test| &surfaces.border * test),
                };
                let a = Bordered::new(stiffness, &surfaces.border * &trial, left, corner)?
                    .with_constrained_dofs(&surfaces.constrained)?;
                Ok::<_, LinalgError>(match surfaces.border_left {
                    Some(_) => a.with_unsymmetric_stiffness(),
                    None => a,
                })
            },
            || with_border(interpolation, &interpolation_border, &trial, test.as_ref()),
        );
        drop(interpolation_border);
        let system = SaddleSystem::new(
            a?,
            divergence,
            &surfaces.rigid_divergence * &trial,
            test.as_ref().map(|test| &surfaces.rigid_divergence * test),
            pressure_mass,
        )?;
        Ok(Self {
            system,
            rhs,
            prolongation: prolongation?,
            vertex_stiffness,
            pressure_stiffness,
            inertia,
            border,
            surface_rows,
            layout: drive.constraints.layout.clone(),
            surfaces,
        })
    }

    /// Right-hand side and imposed velocities for other rates of the joints, for the same matrix.
    ///
    /// Bitwise those of a system built with these rates. Cost: an elimination of the small dense
    /// constraints and a pass over the border.
    ///
    /// # Errors
    /// [`RigidError::OtherJoints`] for a drive with other joints, values or loads, and for
    /// independent bodies, which have no rates; [`RigidError::Misplaced`] for bodies that are not
    /// where their surfaces are; rates that contradict each other.
    pub fn imposed(&self, drive: &Drive) -> Result<Imposed, RigidError> {
        let (all, joint_loads) = drive.reduced(self.surfaces.symmetry_planes)?;
        // The joint loads contain the independent constraint rows and the vectors along the joints:
        // everything in the matrix that joints and their values determine.
        if self.border.joint_loads.as_ref() != Some(&joint_loads) {
            return Err(RigidError::OtherJoints);
        }
        self.surfaces
            .check_positions(&drive.constraints.rigid_positions)?;
        let loads = joint_loads.external();
        Ok(Imposed {
            rhs: imposed_rhs(
                &self.surfaces,
                self.border.tests(),
                &self.surface_rows,
                &(loads - drive.damping().times(&all.offset)),
                &all.offset,
            ),
            offset: all.offset,
        })
    }

    /// Right-hand side for generalised loads alone, all rates and wall velocities zero.
    ///
    /// Its solution is the adjoint solution of a velocity: in a symmetric system the error of the
    /// velocity that is conjugate to `loads` is the solution times the residual.
    ///
    /// # Errors
    /// Loads of the wrong length.
    pub fn rhs_of_loads(&self, loads: &DVector<f64>) -> Result<Vec<f64>, RigidError> {
        let tests = self.border.tests();
        check_length("generalised loads", loads.len(), tests.nrows())?;
        let mut rhs = vec![0.0; self.dofs()];
        let loads = tests.tr_mul(loads) / self.surfaces.symmetry_planes.parts();
        if self.surfaces.part.owns_border() {
            rhs[self.border_range()].copy_from_slice(loads.as_slice());
        }
        Ok(rhs)
    }

    /// Right-hand side for nodal forces and volume sources, all rates and wall velocities zero.
    ///
    /// Shapes: `velocity` one force per node of the mesh, of which those on walls have no
    /// effect; `pressure` one entry per pressure dof, with zero sum in enclosed flow. In a
    /// symmetric system this is the transpose of [`Constrained::flow_of_loads`].
    ///
    /// # Errors
    /// Arrays of the wrong length.
    pub fn rhs_of_forces(
        &self,
        velocity: &[Vector3<f64>],
        pressure: &[f64],
    ) -> Result<Vec<f64>, RigidError> {
        check_length("forces on the nodes", velocity.len(), self.surfaces.nodes())?;
        let pressures = self.surfaces.rigid_divergence.rows();
        check_length("volume sources", pressure.len(), pressures)?;
        let on_surfaces = self.surfaces.loads_of_forces(velocity);
        let surface_tests = self.border.tests().select_rows(&self.surface_rows);
        let mut border = surface_tests.tr_mul(&on_surfaces);
        if !self.surfaces.part.owns_border() {
            border.fill(0.0);
        }
        let owned = |node: usize, value| match self.surfaces.part.owns(node) {
            true => value,
            false => Vector3::zeros(),
        };
        let free = self.surfaces.free_nodes.iter().map(|&node| node as usize);
        let mut rhs = Vec::with_capacity(self.dofs());
        rhs.extend(free.flat_map(|node| <[f64; 3]>::from(owned(node, velocity[node]))));
        self.surfaces.zero_constrained(&mut rhs);
        rhs.extend(border.iter());
        let owned = |(node, p): (usize, &f64)| {
            if self.surfaces.part.owns(node) {
                self.surfaces.pressure_scale * *p
            } else {
                0.0
            }
        };
        rhs.extend(pressure.iter().enumerate().map(owned));
        Ok(rhs)
    }

    /// Adds forces on the nodes to the right-hand side; see [`Constrained::rhs_of_forces`].
    ///
    /// # Errors
    /// Forces of the wrong length.
    pub fn add_forces(&mut self, forces: &[Vector3<f64>]) -> Result<(), RigidError> {
        let no_sources = vec![0.0; self.surfaces.rigid_divergence.rows()];
        let of_forces = self.rhs_of_forces(forces, &no_sources)?;
        (self.rhs.iter_mut().zip(of_forces)).for_each(|(rhs, force)| *rhs += force);
        Ok(())
    }

    /// Block-triangular preconditioner with multigrid for velocities and border.
    ///
    /// For [`linalg::fgmres`] and every formulation: the border dofs are part of every level of the
    /// multigrid. With inertia the pressure has its Schur complement. Where convection dominates,
    /// all levels have it ([`Multigrid::with_prolongation`]); elsewhere only the finest one.
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
        self.preconditioner_with(multigrid)
    }

    /// As [`Constrained::preconditioner`], with another hierarchy for velocities and border.
    ///
    /// # Errors
    /// A hierarchy of another size than the velocities and the border.
    pub fn preconditioner_with(&self, velocity: Multigrid) -> Result<BlockTriangular, RigidError> {
        let block = BlockTriangular::new(&self.system, velocity)?;
        let block = match &self.pressure_stiffness {
            Some(stiffness) => block.with_pressure_laplacian(stiffness)?,
            None => block,
        };
        Ok(match &self.inertia {
            Some(inertia) => block.with_inertia(&SchurInertia {
                coefficient: inertia.factors.0,
                scale: inertia.factors.1,
                mass_diagonal: &inertia.mass_diagonal,
                laplacian: &inertia.pressure_laplacian,
                convection: inertia
                    .pressure_convection
                    .as_ref()
                    .map(|both| both.each_ref()),
            })?,
            None => block,
        })
    }

    /// Block-diagonal preconditioner, symmetric positive definite, for [`linalg::minres`].
    ///
    /// # Errors
    /// A formulation that is not symmetric, a matrix that multigrid cannot treat.
    pub fn symmetric_preconditioner(&self) -> Result<BlockDiagonal, RigidError> {
        if !self.system.is_symmetric() {
            let method = "the block-diagonal preconditioner";
            return Err(LinalgError::NotSymmetric { method }.into());
        }
        let block = BlockDiagonal::with_prolongation(&self.system, &self.prolongation)?;
        Ok(match &self.pressure_stiffness {
            Some(stiffness) => block.with_pressure_laplacian(stiffness)?,
            None => block,
        })
    }

    /// The same without the matrices of the system and its preconditioners.
    ///
    /// For solvers outside this workspace, which have copied them: most of the memory is freed. All
    /// conversions between vectors and flows remain; the field `system` has no rows.
    ///
    /// # Errors
    /// None for a system that was built.
    pub fn without_matrices(self) -> Result<Self, RigidError> {
        let empty = || Csr::zero((0, 0));
        let (none, divergence) = (Bordered::scalar(empty())?, Csr3::zero((0, 0)));
        Ok(Self {
            prolongation: Prolongation::new(empty(), empty())?,
            system: SaddleSystem::new(none, divergence, empty(), None, empty())?,
            vertex_stiffness: empty(),
            pressure_stiffness: None,
            inertia: None,
            ..self
        })
    }

    /// Frees what only preconditioners are made of: a system that has one needs no other.
    ///
    /// # Errors
    /// None for a system that was built.
    pub fn free_prolongation(&mut self) -> Result<(), RigidError> {
        let empty = || Csr::zero((0, 0));
        self.prolongation = Prolongation::new(empty(), empty())?;
        self.vertex_stiffness = empty();
        self.pressure_stiffness = None;
        Ok(())
    }

    /// Number in the mesh of each free node, in the order of the dofs.
    pub fn free_nodes(&self) -> &[u32] {
        &self.surfaces.free_nodes
    }

    /// Pressures of a flow over those of a solution vector: one without inertia.
    pub fn pressure_scale(&self) -> f64 {
        self.surfaces.pressure_scale
    }

    /// Number of dofs of the system that was built.
    pub(crate) fn dofs(&self) -> usize {
        self.border_range().end + self.surfaces.rigid_divergence.rows()
    }

    /// Positions of the border dofs in the system that was built.
    pub(crate) fn border_range(&self) -> Range<usize> {
        let first = 3 * self.surfaces.free_nodes.len();
        first..first + self.border.columns.ncols()
    }

    /// Number of border dofs in formulation P: the velocities of all bodies and nothing else.
    pub(crate) fn independent_velocities(&self) -> Result<usize, RigidError> {
        let velocities = self.border.columns.nrows();
        let is_independent = self.border.joint_loads.is_none()
            && velocities == self.border.columns.ncols()
            && velocities == 6 * self.surfaces.bodies();
        is_independent
            .then_some(velocities)
            .ok_or(RigidError::NotIndependent)
    }
}

/// Prolongation of free nodes and of a border with these trial and test velocities of bodies.
fn with_border(
    interpolation: Csr,
    of_bodies: &Csr,
    trial: &Csr,
    test: Option<&Csr>,
) -> Result<Prolongation, LinalgError> {
    let prolongation = Prolongation::new(interpolation, of_bodies * trial)?;
    match test {
        Some(test) => prolongation.with_left_border(of_bodies * test),
        None => Ok(prolongation),
    }
}

/// Right-hand side for loads `F` and imposed velocities `W` (`offset`).
///
/// The velocities `W` satisfy every constraint. The blocks are `-C W` for the flow, `L^T (F - M W)`
/// for the border (`L` = `tests`; zero where a row is a constraint) and `-E W` for
/// incompressibility, each minus the terms of prescribed velocities. They are the same for all
/// formulations, so that relative residuals are comparable.
fn imposed_rhs(
    surfaces: &Surfaces,
    tests: &DMatrix<f64>,
    surface_rows: &[usize],
    loads: &DVector<f64>,
    offset: &DVector<f64>,
) -> Vec<f64> {
    let of_surfaces = offset.select_rows(surface_rows);
    let surface_tests = tests.select_rows(surface_rows);
    let mut rhs = negated_product(&surfaces.border, &of_surfaces);
    let mut border = tests.tr_mul(loads) / surfaces.symmetry_planes.parts()
        - surface_tests.tr_mul(&(&surfaces.corner * &of_surfaces));
    let mut flux = negated_product(&surfaces.rigid_divergence, &of_surfaces);
    if let Some(prescribed) = &surfaces.prescribed {
        subtract(&mut rhs, &prescribed.momentum);
        border -= surface_tests.tr_mul(&prescribed.loads);
        subtract(&mut flux, &prescribed.flux);
    }
    surfaces.zero_constrained(&mut rhs);
    rhs.reserve_exact(border.len() + flux.len());
    rhs.extend(border.iter());
    rhs.extend(flux);
    rhs
}

fn negated_product(matrix: &Csr, x: &DVector<f64>) -> Vec<f64> {
    matrix
        .outer_iterator()
        .map(|row| -row.iter().map(|(j, &a)| a * x[j]).sum::<f64>())
        .collect()
}

fn subtract(from: &mut [f64], other: &[f64]) {
    from.iter_mut().zip(other).for_each(|(a, b)| *a -= b);
}

/// The nonzeros of a small dense matrix.
pub(crate) fn to_csr(dense: &DMatrix<f64>) -> Csr {
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
