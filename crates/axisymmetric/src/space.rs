//! Where the nodes of elements of one order are among all nodes.

use crate::element::Lagrange;
use crate::meridian::Side;
use crate::mesh::MeridianMesh;

/// Continuous functions of one order on a mesh: node numbers by triangle.
pub(crate) struct Space {
    /// Number of nodes: vertices of the mesh, then nodes on edges, then inside triangles.
    pub len: usize,
    /// Nodes of each triangle in the order of [`Lagrange::nodes`].
    pub nodes: Vec<Vec<u32>>,
}

impl Space {
    pub fn new(mesh: &MeridianMesh, element: &Lagrange) -> Self {
        let on_edge = element.edge_nodes();
        let first_on_edges = mesh.points.len();
        let first_inside = first_on_edges + on_edge * mesh.ends.len();
        let inside = element.inner_nodes();
        let nodes = (0..mesh.triangles.len()).map(|t| {
            let corners = mesh.triangles[t];
            let mut nodes: Vec<usize> = corners.to_vec();
            for (e, &edge) in mesh.edges[t].iter().enumerate() {
                // nodes of an edge are numbered from its smaller end
                let forward = mesh.ends[edge][0] == corners[e];
                nodes.extend((0..on_edge).map(|m| {
                    let place = if forward { m } else { on_edge - 1 - m };
                    first_on_edges + on_edge * edge + place
                }));
            }
            nodes.extend((0..inside).map(|m| first_inside + inside * t + m));
            nodes.into_iter().map(|node| node as u32).collect()
        });
        Self {
            nodes: nodes.collect(),
            len: first_inside + inside * mesh.triangles.len(),
        }
    }

    /// The vertex, edge or triangle that each node is in, numbered in this order.
    pub fn entities(&self, mesh: &MeridianMesh, element: &Lagrange) -> Vec<u32> {
        let (vertices, edges) = (mesh.points.len(), mesh.ends.len());
        (0..vertices)
            .chain((0..edges * element.edge_nodes()).map(|i| vertices + i / element.edge_nodes()))
            .chain(
                (0..mesh.triangles.len() * element.inner_nodes())
                    .map(|i| vertices + edges + i / element.inner_nodes()),
            )
            .map(|entity| entity as u32)
            .collect()
    }

    /// The boundary that each node is on: the wall or a body before the axis.
    pub fn sides(&self, mesh: &MeridianMesh, element: &Lagrange) -> Vec<Option<Side>> {
        let mut sides: Vec<Option<Side>> = vec![None; self.len];
        let on_edge = element.edge_nodes();
        for (edge, boundary) in mesh.boundary.iter().enumerate() {
            let Some(boundary) = boundary else { continue };
            let inner = (0..on_edge).map(|m| mesh.points.len() + on_edge * edge + m);
            for node in mesh.ends[edge].into_iter().chain(inner) {
                // sides are ordered, the axis first
                sides[node] = sides[node].max(Some(boundary.side()));
            }
        }
        sides
    }
}
