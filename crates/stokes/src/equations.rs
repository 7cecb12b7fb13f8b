//! The equations by which errors are estimated: those of a mesh, or the part of one process.

use std::borrow::Cow;

use fem::{Surplus, SurplusSpace};
use linalg::LinearOperator;
use mesh::{Submesh, TetMesh};
use nalgebra::Vector3;
use rigid::{Articulation, Constrained, FlowSolution};

use crate::StokesError;
use crate::linearised::VaryingFlow;

/// Fields of the whole mesh from those of the processes that divide it.
///
/// Every process makes the same calls in the same order. Values of nodes and cells that belong to
/// other processes are not read.
pub trait Gather: Sync {
    /// A velocity per node of the mesh, from one per node of the part.
    ///
    /// # Errors
    /// A failed exchange: [`StokesError::Engine`].
    fn nodes(&self, part: &[Vector3<f64>]) -> Result<Vec<Vector3<f64>>, StokesError>;

    /// A number per vertex of the mesh, from one per vertex of the part.
    ///
    /// # Errors
    /// A failed exchange: [`StokesError::Engine`].
    fn vertices(&self, part: &[f64]) -> Result<Vec<f64>, StokesError>;

    /// A number per cell of the mesh, from one per cell of the part.
    ///
    /// # Errors
    /// A failed exchange: [`StokesError::Engine`].
    fn cells(&self, part: &[f64]) -> Result<Vec<f64>, StokesError>;
}

/// The equations of one process, for [`Problem::estimate_part`](crate::Problem::estimate_part).
#[derive(Clone, Copy)]
pub struct PartEquations<'a> {
    /// All cells around the nodes of this process.
    pub submesh: &'a Submesh,
    /// Bubbles of the submesh, with the part of this process ([`SurplusSpace::with_part`]).
    pub space: &'a SurplusSpace,
    /// The system of [`Problem::assemble_part`](crate::Problem::assemble_part), with an exchange of
    /// vectors ([`rigid::MeshPart::with_ghosts`]). Its matrices are not used.
    pub system: &'a Constrained,
    /// Products with the matrix of the whole system, on vectors that are divided between processes
    /// ([`LinearOperator::sum_over_processes`]).
    pub operator: &'a dyn LinearOperator,
    /// Fields of the whole mesh.
    pub gather: &'a dyn Gather,
}

/// The equations of a mesh or of a part of it.
#[derive(Clone, Copy)]
pub(crate) struct Equations<'a> {
    pub mesh: &'a TetMesh,
    pub space: &'a SurplusSpace,
    pub system: &'a Constrained,
    pub operator: &'a dyn LinearOperator,
    /// The flow that was solved for, if its viscosity varies with the shear rate.
    pub varying: Option<VaryingFlow<'a>>,
    /// Numbers of the nodes in the whole mesh, and the exchange; none if the mesh is the whole one.
    part: Option<(&'a [u32], &'a dyn Gather)>,
}

impl<'a> Equations<'a> {
    /// The equations of a whole mesh.
    pub fn whole(mesh: &'a TetMesh, space: &'a SurplusSpace, system: &'a Constrained) -> Self {
        Self {
            mesh,
            space,
            system,
            operator: &system.system,
            varying: None,
            part: None,
        }
    }

    /// The equations of a whole mesh, linearised at a flow of a generalised Newtonian fluid.
    pub fn linearised(mesh: &'a TetMesh, space: &'a SurplusSpace, flow: VaryingFlow<'a>) -> Self {
        Self {
            operator: flow.equations,
            varying: Some(flow),
            ..Self::whole(mesh, space, &flow.equations.system)
        }
    }

    /// Surplus of a flow that was solved for, without its background flow.
    pub fn surplus_of_flow(&self, flow: &FlowSolution) -> Result<Surplus, StokesError> {
        let velocity = &*self.restricted(&flow.velocity);
        let pressure = &*self.restricted(&flow.pressure);
        let (mesh, space) = (self.mesh, self.space);
        Ok(match self.varying {
            None => space.surplus(mesh, velocity, pressure)?,
            Some(flow) => space.surplus_of_flow(mesh, (velocity, pressure), flow.viscosity)?,
        })
    }

    /// Surplus of a solution of the linear equations, such as an adjoint solution.
    pub fn surplus_of_change(
        &self,
        velocity: &[Vector3<f64>],
        pressure: &[f64],
    ) -> Result<Surplus, StokesError> {
        let (mesh, space) = (self.mesh, self.space);
        Ok(match self.varying {
            None => space.surplus(mesh, velocity, pressure)?,
            Some(flow) => space.surplus_of_change(mesh, (velocity, pressure), flow.viscosity)?,
        })
    }

    /// Change of a flow by forces on the nodes, whose solution is `solution`.
    pub fn change(
        &self,
        solution: &[f64],
        forces: &[Vector3<f64>],
        set: &Articulation,
    ) -> Result<FlowSolution, StokesError> {
        match self.varying {
            None => Ok(self.system.change(solution, forces, set)?),
            Some(flow) => flow.equations.change(solution, forces, set),
        }
    }

    /// Number of a node in the whole mesh.
    pub fn number(&self, node: u32) -> u32 {
        self.part.map_or(node, |(nodes, _)| nodes[node as usize])
    }

    /// Values of the nodes, or of the vertices, from those of the whole mesh.
    pub fn restricted<'v, T: Copy>(&self, whole: &'v [T]) -> Cow<'v, [T]> {
        let Some((nodes, _)) = self.part else {
            return Cow::Borrowed(whole);
        };
        let nodes = nodes.iter().map(|&node| node as usize);
        // Vertices come first, so that values of vertices end with the last vertex.
        let values = nodes.map_while(|node| whole.get(node).copied());
        Cow::Owned(values.collect())
    }

    /// Velocities of all nodes of the whole mesh.
    pub fn of_all_nodes(
        &self,
        values: Vec<Vector3<f64>>,
    ) -> Result<Vec<Vector3<f64>>, StokesError> {
        match self.part {
            None => Ok(values),
            Some((_, gather)) => gather.nodes(&values),
        }
    }

    /// Numbers of all cells of the whole mesh.
    pub fn of_all_cells(&self, values: Vec<f64>) -> Result<Vec<f64>, StokesError> {
        match self.part {
            None => Ok(values),
            Some((_, gather)) => gather.cells(&values),
        }
    }

    /// The flow with velocities and pressures of the whole mesh.
    pub fn of_whole_mesh(&self, mut flow: FlowSolution) -> Result<FlowSolution, StokesError> {
        if let Some((_, gather)) = self.part {
            flow.velocity = gather.nodes(&flow.velocity)?;
            flow.pressure = gather.vertices(&flow.pressure)?;
        }
        Ok(flow)
    }
}

impl<'a> From<PartEquations<'a>> for Equations<'a> {
    fn from(part: PartEquations<'a>) -> Self {
        Self {
            mesh: &part.submesh.mesh,
            space: part.space,
            system: part.system,
            operator: part.operator,
            varying: None,
            part: Some((&part.submesh.nodes, part.gather)),
        }
    }
}
