//! Division of the edges of a mesh, which keeps the shape of its curved cells.

use super::kept_cells::MovedPart;
use crate::GenerateError;
use mesh::{Facet, LinearTets, Regions, TET_EDGES, TetMesh, Vec3};
use std::collections::{BTreeMap, HashMap};

/// Longest edge of the facets of a body, relative to the width of the gap that they bound.
///
/// Meshes whose edges in gaps are longer are generated again (`gap_ratio`), so new ones must not
/// have such edges.
const LONGEST_IN_GAP: f64 = 1.5;

/// An edge of a mesh, smaller vertex first.
pub(super) type Edge = [u32; 2];

/// The longest edge of a triangle; of equal ones that with the larger numbers.
pub(super) fn longest_edge(mesh: &TetMesh, [a, b, c]: [u32; 3]) -> Edge {
    let edges = [[a, b], [b, c], [c, a]].map(|[a, b]| [a.min(b), a.max(b)]);
    let length = |[a, b]: Edge| (mesh.points()[a as usize] - mesh.points()[b as usize]).norm();
    let longer = |x: Edge, y: &Edge| match (length(*y), *y) > (length(x), x) {
        true => *y,
        false => x,
    };
    edges[1..].iter().fold(edges[0], longer)
}

/// Edges of the facets of given bodies that are longer than [`LONGEST_IN_GAP`] gap widths.
///
/// From a facet with such an edge the path of longest edges (Rivara 1984) leads to one that is the
/// longest of both its facets: halving those bounds the angles of the facets.
pub(super) fn long_in_gaps(
    mesh: &TetMesh,
    parts: &[MovedPart<'_>],
    part_of_tags: &[u32],
) -> Vec<Edge> {
    let walls = parts.len() - 1;
    let part_of = |facet: &Facet| part_of_tags[usize::from(facet.tag)] as usize;
    let corners = |facet: &Facet| [facet.nodes[0], facet.nodes[1], facet.nodes[2]];
    let mut beside: HashMap<Edge, Vec<usize>> = HashMap::new();
    let longest: Vec<Edge> = (mesh.facets().iter())
        .map(|facet| longest_edge(mesh, corners(facet)))
        .collect();
    for (index, facet) in mesh.facets().iter().enumerate() {
        let [a, b, c] = corners(facet);
        for [a, b] in [[a, b], [b, c], [c, a]] {
            beside.entry([a.min(b), a.max(b)]).or_default().push(index);
        }
    }
    let mut edges = Vec::new();
    for (index, facet) in mesh.facets().iter().enumerate() {
        let part = part_of(facet);
        if part == walls || !parts[part].is_given {
            continue;
        }
        let [a, b] = longest[index].map(|v| mesh.points()[v as usize]);
        let width = |node: u32| {
            let x = parts[part].moved(mesh.points()[node as usize]);
            let others = (parts.iter().enumerate()).filter(|(k, _)| *k != part);
            let distances = others.map(|(_, other)| other.distance(x));
            distances.fold(f64::INFINITY, f64::min)
        };
        let narrowest = facet
            .nodes
            .map(width)
            .into_iter()
            .fold(f64::INFINITY, f64::min);
        if (a - b).norm() <= LONGEST_IN_GAP * narrowest {
            continue;
        }
        let mut at = index;
        while let Some(&next) =
            (beside[&longest[at]].iter()).find(|&&next| next != at && longest[next] != longest[at])
        {
            at = next;
        }
        edges.push(longest[at]);
    }
    edges
}

/// The mesh with these edges divided at their midside nodes.
///
/// Of the edges of one cell only the longest is divided. Each cell at a divided edge becomes two,
/// with the nodes that its quadratic map has there, so the shape of cells and facets stays the
/// same. Named regions of the volume are lost.
///
/// # Errors
/// Those of [`TetMesh::curved`].
pub(super) fn bisected(mesh: &TetMesh, edges: &[Edge]) -> Result<TetMesh, GenerateError> {
    let at = |node: u32| mesh.points()[node as usize];
    let divided = independent(mesh, edges);
    let new: BTreeMap<Edge, u32> = (divided.into_iter())
        .zip(mesh.n_vertices() as u32..)
        .collect();
    let mut tets = LinearTets {
        points: mesh.points()[..mesh.n_vertices()].to_vec(),
        tags: mesh.tags().to_vec(),
        regions: Regions::default(),
        ..LinearTets::default()
    };
    tets.points
        .resize(mesh.n_vertices() + new.len(), Vec3::zeros());
    let mut middles: HashMap<Edge, Vec3> = HashMap::new();
    let mut set = |a: u32, b: u32, x: Vec3| {
        middles.insert([a.min(b), a.max(b)], x);
    };
    for nodes in mesh.cells() {
        let tet = [nodes[0], nodes[1], nodes[2], nodes[3]];
        let sides = TET_EDGES.map(|[i, j]| [tet[i].min(tet[j]), tet[i].max(tet[j])]);
        let middle = |edge: Edge| {
            let side = sides.iter().position(|side| *side == edge).unwrap_or(0);
            at(nodes[4 + side])
        };
        let Some((edge, &m)) = sides.iter().find_map(|side| new.get_key_value(side)) else {
            sides.iter().for_each(|&[a, b]| set(a, b, middle([a, b])));
            tets.tets.push(tet);
            continue;
        };
        let &[a, b] = edge;
        sides
            .iter()
            .filter(|side| *side != edge)
            .for_each(|&[a, b]| set(a, b, middle([a, b])));
        // The quadratic map of the cell on its edges from the new vertex.
        tets.points[m as usize] = middle(*edge);
        set(a, m, 0.375 * at(a) + 0.75 * middle(*edge) - 0.125 * at(b));
        set(b, m, 0.375 * at(b) + 0.75 * middle(*edge) - 0.125 * at(a));
        for c in tet.into_iter().filter(|c| !edge.contains(c)) {
            let to = |v: u32| middle([v.min(c), v.max(c)]);
            let across = 0.5 * (to(a) + to(b)) + 0.25 * middle(*edge) - 0.125 * (at(a) + at(b));
            set(c, m, across);
        }
        tets.tets
            .extend([a, b].map(|old| tet.map(|v| if v == old { m } else { v })));
    }
    for facet in mesh.facets() {
        let face = [facet.nodes[0], facet.nodes[1], facet.nodes[2]];
        let sides = [[0, 1], [1, 2], [2, 0]].map(|[i, j]| [face[i], face[j]]);
        let edge = sides.into_iter().map(|[a, b]| [a.min(b), a.max(b)]);
        match edge
            .into_iter()
            .find_map(|edge| Some((edge, *new.get(&edge)?)))
        {
            None => tets.faces.push((face, facet.tag)),
            Some((edge, m)) => {
                let halves = edge.map(|old| face.map(|v| if v == old { m } else { v }));
                tets.faces.extend(halves.map(|half| (half, facet.tag)));
            }
        }
    }
    Ok(TetMesh::with_middles(tets, &middles, &[])?)
}

/// Some of the edges, the longest first, of which no cell has two; ascending.
fn independent(mesh: &TetMesh, edges: &[Edge]) -> Vec<Edge> {
    let mut cells: BTreeMap<Edge, Vec<usize>> = edges.iter().map(|e| (*e, Vec::new())).collect();
    for (cell, nodes) in mesh.cells().iter().enumerate() {
        for [i, j] in TET_EDGES {
            let (a, b) = (nodes[i], nodes[j]);
            if let Some(list) = cells.get_mut(&[a.min(b), a.max(b)]) {
                list.push(cell);
            }
        }
    }
    let length = |[a, b]: &Edge| (mesh.points()[*a as usize] - mesh.points()[*b as usize]).norm();
    let mut order: Vec<(Edge, Vec<usize>)> = cells.into_iter().collect();
    order.sort_by(|x, y| length(&y.0).total_cmp(&length(&x.0)).then(x.0.cmp(&y.0)));
    let mut is_changed = vec![false; mesh.n_cells()];
    order.retain(|(_, cells)| {
        let is_free = cells.iter().all(|&cell| !is_changed[cell]);
        if is_free {
            cells.iter().for_each(|&cell| is_changed[cell] = true);
        }
        is_free
    });
    let mut divided: Vec<Edge> = order.into_iter().map(|(edge, _)| edge).collect();
    divided.sort_unstable();
    divided
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Sphere;
    use mesh::NamedSurface;

    /// A cube with curved cells: its side `x1` is bulged by moving the midside nodes on it.
    #[test]
    fn divided_cells_keep_their_shape() {
        let bulge = Sphere::new(Vec3::new(-4.5, 0.5, 0.5), (5.5f64.powi(2) + 0.5).sqrt());
        let cube = LinearTets::cube(1);
        let surfaces: [NamedSurface; 1] = [("x1", &bulge)];
        let mesh = TetMesh::curved(cube, &surfaces).expect("curved");
        let edges: Vec<Edge> = (mesh.facets().iter())
            .map(|f| longest_edge(&mesh, [f.nodes[0], f.nodes[1], f.nodes[2]]))
            .collect();
        let halved = bisected(&mesh, &edges).expect("valid");
        assert!(halved.n_cells() > mesh.n_cells());
        // The volume of curved cells is that of the sum of their parts, up to rounding.
        assert!((halved.volume() - mesh.volume()).abs() < 1e-13);
        // Each old node is a node of the new mesh.
        for x in mesh.points() {
            assert!(halved.points().iter().any(|y| (x - y).norm() < 1e-15));
        }
    }
}
