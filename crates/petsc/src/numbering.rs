//! Numbers of the degrees of freedom over all processes.

use std::ops::Range;

use mesh::TetMesh;
use rigid::NodeRole;

use crate::PetscError;
use crate::ffi::Int;
use crate::partition::Partition;

/// Numbers of velocities, pressures and border dofs in PETSc's matrices.
///
/// There are three fields: `motion` (velocities of free nodes, and the border with the bodies),
/// `coarse` (the same for linear elements: velocities of free vertices, and the border) and
/// `pressure`. In each of them a process has consecutive numbers; the border comes last on the
/// first process. Velocities that symmetry planes prescribe have no number. Every process has the
/// numbers of all nodes: 5 bytes per node and 8 per vertex, with 32-bit integers.
pub struct Numbering {
    /// Bit `d` of a node: component `d` of its velocity is a degree of freedom.
    components: Vec<u8>,
    motion: Vec<Int>,
    coarse: Vec<Int>,
    pressure: Vec<Int>,
    /// First numbers of the processes, and the end.
    starts: Starts,
    border: usize,
    rank: usize,
}

/// First numbers of the processes in each field, and the end.
struct Starts {
    motion: Vec<usize>,
    coarse: Vec<usize>,
    pressure: Vec<usize>,
}

/// Which velocity components of each node are degrees of freedom, one bit each.
///
/// `on_planes` lists nodes on symmetry planes with the axes that the planes are normal to.
pub fn components(roles: &[NodeRole], on_planes: &[(u32, [bool; 3])]) -> Vec<u8> {
    let all = |role: &NodeRole| if *role == NodeRole::Free { 0b111 } else { 0 };
    let mut components: Vec<u8> = roles.iter().map(all).collect();
    for (node, axes) in on_planes {
        for axis in (0..3).filter(|&axis| axes[axis]) {
            components[*node as usize] &= !(1 << axis);
        }
    }
    components
}

impl Numbering {
    /// Numbers the degrees of freedom of `mesh` with `border` border dofs.
    ///
    /// # Errors
    /// [`PetscError::TooLarge`].
    pub fn new(
        mesh: &TetMesh,
        components: Vec<u8>,
        partition: &Partition,
        border: usize,
        [rank, ranks]: [usize; 2],
    ) -> Result<Self, PetscError> {
        let vertices = mesh.n_vertices();
        let order = partition.nodes_by_vertex();
        let is_vertex = |node: u32| (node as usize) < vertices;
        let count = |node: u32| components[node as usize].count_ones() as usize;
        let number = |what, sizes: &dyn Fn(u32) -> usize, first_extra: usize, len: usize| {
            number(what, &order, partition, sizes, first_extra, len, ranks)
        };
        let of_vertex = |node| if is_vertex(node) { count(node) } else { 0 };
        let of_pressure = |node| usize::from(is_vertex(node));
        let (motion, motion_starts) = number("velocities", &count, border, mesh.n_points())?;
        let (coarse, coarse_starts) = number("velocities", &of_vertex, border, vertices)?;
        let (pressure, pressure_starts) = number("pressures", &of_pressure, 0, vertices)?;
        Ok(Self {
            components,
            motion,
            coarse,
            pressure,
            starts: Starts {
                motion: motion_starts,
                coarse: coarse_starts,
                pressure: pressure_starts,
            },
            border,
            rank,
        })
    }

    /// Number of a velocity component of a node; none where it is prescribed.
    pub fn velocity(&self, node: u32, axis: usize) -> Option<Int> {
        self.component(node, axis, &self.motion)
    }

    /// Number of a velocity component of a vertex among those of linear elements.
    pub fn coarse_velocity(&self, vertex: u32, axis: usize) -> Option<Int> {
        self.component(vertex, axis, &self.coarse)
    }

    fn component(&self, node: u32, axis: usize, first: &[Int]) -> Option<Int> {
        let bits = self.components[node as usize];
        let before = (bits & ((1 << axis) - 1)).count_ones() as Int;
        (bits >> axis & 1 == 1).then(|| first[node as usize] + before)
    }

    /// Velocity components of a node that are degrees of freedom, one bit each.
    pub fn components(&self, node: u32) -> u8 {
        self.components[node as usize]
    }

    /// Number of the pressure of a vertex.
    pub fn pressure(&self, vertex: u32) -> Int {
        self.pressure[vertex as usize]
    }

    /// Number of a border dof in the field `motion`.
    pub fn border(&self, border: usize) -> Int {
        (self.starts.motion[1] - self.border + border) as Int
    }

    /// Number of a border dof in the field `coarse`.
    pub fn coarse_border(&self, border: usize) -> Int {
        (self.starts.coarse[1] - self.border + border) as Int
    }

    /// Number of border dofs.
    pub fn border_len(&self) -> usize {
        self.border
    }

    /// Number of border dofs on this process: all on the first, none on the others.
    pub fn own_border(&self) -> usize {
        if self.rank == 0 { self.border } else { 0 }
    }

    /// Numbers of this process in the field `motion`.
    pub fn own_motion(&self) -> Range<usize> {
        self.starts.motion[self.rank]..self.starts.motion[self.rank + 1]
    }

    /// Numbers of this process in the field `coarse`.
    pub fn own_coarse(&self) -> Range<usize> {
        self.starts.coarse[self.rank]..self.starts.coarse[self.rank + 1]
    }

    /// Numbers of this process in the field `pressure`.
    pub fn own_pressure(&self) -> Range<usize> {
        self.starts.pressure[self.rank]..self.starts.pressure[self.rank + 1]
    }
}

/// First number of each node below `len`, and the first numbers of the processes.
///
/// `sizes` is how many numbers a node has; the first process has `extra` more at its end.
fn number(
    what: &'static str,
    order: &[u32],
    partition: &Partition,
    sizes: &dyn Fn(u32) -> usize,
    extra: usize,
    len: usize,
    ranks: usize,
) -> Result<(Vec<Int>, Vec<usize>), PetscError> {
    let mut starts = vec![0; ranks + 1];
    for &node in order {
        starts[partition.owner(node) + 1] += sizes(node);
    }
    starts[1] += extra;
    for rank in 0..ranks {
        starts[rank + 1] += starts[rank];
    }
    let found = starts[ranks];
    let bits = Int::BITS;
    Int::try_from(found).map_err(|_| PetscError::TooLarge { what, found, bits })?;
    let mut next = starts.clone();
    let mut first = vec![0; len];
    for &node in order.iter().filter(|&&node| (node as usize) < len) {
        let place = &mut next[partition.owner(node)];
        first[node as usize] = *place as Int;
        *place += sizes(node);
    }
    Ok((first, starts))
}
