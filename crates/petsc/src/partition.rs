//! Which process owns which nodes.

use linalg::partition;
use mesh::{TET_EDGES, TetMesh};

use crate::PetscError;

/// Owners of the nodes of a mesh, the same on every process.
///
/// Vertices are divided by METIS so that processes have equally many degrees of freedom and few
/// edges between them. A midside node belongs to the owner of the end of its edge that has the
/// lower number. A cell is assembled by every owner of one of its vertices.
pub struct Partition {
    /// Owner of each vertex.
    of_vertex: Vec<u32>,
    /// The end with the lower number of the edge of each midside node, the vertex itself for
    /// vertices.
    lower_end: Vec<u32>,
}

impl Partition {
    /// Divides the vertices of `mesh` between `ranks` processes.
    ///
    /// `dofs` is the number of velocity components of each node that are degrees of freedom.
    /// Cost: METIS on the graph of the vertices, on every process.
    ///
    /// # Errors
    /// [`PetscError::TooManyProcesses`], and those of METIS.
    pub fn new(mesh: &TetMesh, dofs: &[u8], ranks: usize) -> Result<Self, PetscError> {
        let vertices = mesh.n_vertices();
        let mut lower_end: Vec<u32> = (0..mesh.n_points() as u32).collect();
        for nodes in mesh.cells() {
            for (k, [i, j]) in TET_EDGES.into_iter().enumerate() {
                lower_end[nodes[4 + k] as usize] = nodes[i].min(nodes[j]);
            }
        }
        if ranks == 1 {
            return Ok(Self {
                of_vertex: vec![0; vertices],
                lower_end,
            });
        }
        // The pressure of a vertex, and the velocities that it owns with it.
        let mut weights = vec![1; vertices];
        for (&vertex, &count) in lower_end.iter().zip(dofs) {
            weights[vertex as usize] += u32::from(count);
        }
        let of_vertex: Vec<u32> = partition(&neighbours(mesh), &weights, ranks)?
            .into_iter()
            .map(|rank| rank as u32)
            .collect();
        let is_empty = |rank: &usize| !of_vertex.contains(&(*rank as u32));
        match (0..ranks).find(is_empty) {
            Some(rank) => Err(PetscError::TooManyProcesses { ranks, rank }),
            None => Ok(Self {
                of_vertex,
                lower_end,
            }),
        }
    }

    /// Owner of a node.
    pub fn owner(&self, node: u32) -> usize {
        self.of_vertex[self.lower_end[node as usize] as usize] as usize
    }

    /// All nodes, each vertex followed by the midside nodes of which it is the lower end.
    ///
    /// This is the order in which the crate `rigid` numbers free nodes.
    pub fn nodes_by_vertex(&self) -> Vec<u32> {
        let mut next = vec![0; self.of_vertex.len() + 1];
        for &vertex in &self.lower_end {
            next[vertex as usize + 1] += 1;
        }
        for vertex in 1..next.len() {
            next[vertex] += next[vertex - 1];
        }
        let mut order = vec![0; self.lower_end.len()];
        for (node, &vertex) in self.lower_end.iter().enumerate() {
            let place: &mut usize = &mut next[vertex as usize];
            order[*place] = node as u32;
            *place += 1;
        }
        order
    }

    /// Whether a process assembles a cell: whether it owns one of its vertices.
    pub fn assembles(&self, rank: usize, cell: &[u32; 10]) -> bool {
        let vertices = cell[..4].iter();
        let mut owners = vertices.map(|&vertex| self.of_vertex[vertex as usize] as usize);
        owners.any(|owner| owner == rank)
    }
}

/// Neighbours of each vertex along the edges of the mesh, ascending.
fn neighbours(mesh: &TetMesh) -> Vec<Vec<u32>> {
    let mut neighbours = vec![Vec::new(); mesh.n_vertices()];
    for nodes in mesh.cells() {
        for [i, j] in TET_EDGES {
            neighbours[nodes[i] as usize].push(nodes[j]);
            neighbours[nodes[j] as usize].push(nodes[i]);
        }
    }
    for list in &mut neighbours {
        list.sort_unstable();
        list.dedup();
    }
    neighbours
}
