//! Global node numbers of a continuous finite-element space.

use std::collections::BTreeMap;

use crate::curve::BoundaryPart;
use crate::element::Lagrange;
use crate::mesh::MeridianMesh;

/// The space of continuous functions of one polynomial order on a mesh.
pub(crate) struct Space {
    /// Number of nodes on vertices and edges.
    ///
    /// Vertices come first, then nodes inside edges, then inside triangles.
    pub first_inside: usize,
    /// Global nodes of each triangle in the order of [`Lagrange::nodes`].
    pub nodes: Vec<Vec<u32>>,
}

impl Space {
    /// Numbers the nodes of `element` on `mesh`.
    pub fn new(mesh: &MeridianMesh, element: &Lagrange) -> Self {
        let on_edge = element.n_edge_nodes();
        let first_on_edges = mesh.points.len();
        let first_inside = first_on_edges + on_edge * mesh.ends.len();
        let inside = element.n_inner_nodes();
        let nodes = (0..mesh.triangles.len()).map(|t| {
            let corners = mesh.triangles[t];
            let mut nodes: Vec<usize> = corners.to_vec();
            for (e, &edge) in mesh.edges[t].iter().enumerate() {
                // nodes of an edge are numbered from its end with the smaller index
                let forward = mesh.ends[edge][0] == corners[e];
                nodes.extend((0..on_edge).map(|m| {
                    let position = if forward { m } else { on_edge - 1 - m };
                    first_on_edges + on_edge * edge + position
                }));
            }
            nodes.extend((0..inside).map(|m| first_inside + inside * t + m));
            nodes.into_iter().map(|node| node as u32).collect()
        });
        Self {
            nodes: nodes.collect(),
            first_inside,
        }
    }

    /// Index of the mesh entity that each node on a vertex or edge is in: vertices first.
    pub fn entities(&self, mesh: &MeridianMesh, element: &Lagrange) -> Vec<u32> {
        let (vertices, edges) = (mesh.points.len(), mesh.ends.len());
        (0..vertices)
            .chain(
                (0..edges * element.n_edge_nodes()).map(|i| vertices + i / element.n_edge_nodes()),
            )
            .map(|entity| entity as u32)
            .collect()
    }

    /// The boundary part that each node on a vertex or edge is on; `None` in the interior.
    ///
    /// A node on both the axis and a body or wall counts as on the body or wall. A boundary in the
    /// fluid counts as the interior.
    pub fn parts(&self, mesh: &MeridianMesh, element: &Lagrange) -> Vec<Option<BoundaryPart>> {
        let mut parts: Vec<Option<BoundaryPart>> = vec![None; self.first_inside];
        let on_edge = element.n_edge_nodes();
        for (edge, boundary) in mesh.boundary.iter().enumerate() {
            let Some(boundary) = boundary else { continue };
            if boundary.part().is_in_fluid() {
                continue;
            }
            let inner = (0..on_edge).map(|m| mesh.points.len() + on_edge * edge + m);
            for node in mesh.ends[edge].into_iter().chain(inner) {
                // in the order of parts the axis comes first
                parts[node] = parts[node].max(Some(boundary.part()));
            }
        }
        parts
    }

    /// The nodes on each boundary in the fluid, from left to right.
    pub fn traces(
        &self,
        mesh: &MeridianMesh,
        element: &Lagrange,
    ) -> BTreeMap<BoundaryPart, Vec<u32>> {
        let on_edge = element.n_edge_nodes();
        let mut edges: BTreeMap<BoundaryPart, Vec<usize>> = BTreeMap::new();
        for (edge, boundary) in mesh.boundary.iter().enumerate() {
            if let Some(part) = boundary.map(|b| b.part()).filter(|part| part.is_in_fluid()) {
                edges.entry(part).or_default().push(edge);
            }
        }
        // positions along the axis increase along every such boundary
        let left_end = |edge: usize| {
            let [a, b] = mesh.ends[edge];
            match mesh.points[a].x < mesh.points[b].x {
                true => [a, b],
                false => [b, a],
            }
        };
        let trace = |mut edges: Vec<usize>| {
            edges.sort_by(|&one, &other| {
                let x = |edge: usize| mesh.points[left_end(edge)[0]].x;
                x(one).total_cmp(&x(other))
            });
            let mut nodes = Vec::with_capacity(edges.len() * (on_edge + 1) + 1);
            for &edge in &edges {
                let [left, _] = left_end(edge);
                let forward = mesh.ends[edge][0] == left;
                let first = mesh.points.len() + on_edge * edge;
                nodes.push(left);
                nodes.extend(
                    (0..on_edge).map(|m| first + if forward { m } else { on_edge - 1 - m }),
                );
            }
            nodes.extend(edges.last().map(|&edge| left_end(edge)[1]));
            nodes.into_iter().map(|node| node as u32).collect()
        };
        edges
            .into_iter()
            .map(|(part, edges)| (part, trace(edges)))
            .collect()
    }
}
