//! The new mesh, joined from the cells that stay and those generated around them.

use super::front::{Fronts, edges_of};
use super::kept_cells::{KeptCells, MovedPart};
use crate::GenerateError;
use crate::generate::layout::Layout;
use mesh::{LinearTets, NamedSurface, TetMesh, Vec3, used_points};
use std::collections::HashMap;

/// Numbers of points in the new mesh, and midside nodes of its edges, while it is joined.
struct Joined<'a> {
    old: &'a TetMesh,
    parts: &'a [MovedPart<'a>],
    tets: LinearTets,
    /// New numbers of vertices of the old mesh.
    numbers: HashMap<u32, u32>,
    /// Midside nodes of edges that are known, smaller vertex first.
    middles: HashMap<[u32; 2], Vec3>,
}

impl Joined<'_> {
    /// Number in the new mesh of a vertex of the old one that moves with a part.
    fn vertex(&mut self, vertex: u32, part: u32) -> u32 {
        *self.numbers.entry(vertex).or_insert_with(|| {
            let x = self.old.points()[vertex as usize];
            self.tets.points.push(self.parts[part as usize].moved(x));
            self.tets.points.len() as u32 - 1
        })
    }

    /// Records the midside node of an edge of the old mesh that moves with a part.
    fn middle(&mut self, edge: [u32; 2], node: u32, part: u32) {
        let [v, w] = edge.map(|vertex| self.vertex(vertex, part));
        let x = self.old.points()[node as usize];
        let moved = self.parts[part as usize].moved(x);
        self.middles.insert([v.min(w), v.max(w)], moved);
    }
}

/// What is joined with the generated tets.
pub(super) struct Pieces<'a> {
    pub old: &'a TetMesh,
    pub kept: &'a KeptCells<'a>,
    pub parts: &'a [MovedPart<'a>],
    pub part_of_tags: &'a [u32],
    pub fronts: &'a Fronts,
    pub layout: &'a Layout<'a>,
}

/// Joins the cells that stay with the generated tets `new`.
///
/// # Errors
/// Those of [`TetMesh::curved`].
pub(super) fn join(
    pieces: Pieces<'_>,
    new: LinearTets,
    surfaces: &[NamedSurface],
) -> Result<TetMesh, GenerateError> {
    let Pieces {
        old,
        kept,
        parts,
        part_of_tags,
        fronts,
        layout,
    } = pieces;
    let generated = new.faces.clone();
    let mut joined = Joined {
        old,
        parts,
        tets: new,
        numbers: fronts.numbers(layout),
        middles: HashMap::new(),
    };
    joined.tets.faces.clear();
    joined.tets.tags = old.tags().to_vec();
    for (cell, part) in kept.cells() {
        let nodes = &old.cells()[cell];
        let tet = [nodes[0], nodes[1], nodes[2], nodes[3]].map(|v| joined.vertex(v, part));
        joined.tets.tets.push(tet);
        for (edge, node) in edges_of(old, cell) {
            joined.middle(edge, node, part);
        }
    }
    for facet in old.facets() {
        let part = part_of_tags[usize::from(facet.tag)];
        if parts[part as usize].is_given {
            let [a, b, c, ab, bc, ca] = facet.nodes;
            let face = [a, b, c].map(|v| joined.vertex(v, part));
            joined.tets.faces.push((face, facet.tag));
            for (edge, node) in [([a, b], ab), ([b, c], bc), ([c, a], ca)] {
                joined.middle(edge, node, part);
            }
        }
    }
    for (tag, part) in part_of_tags.iter().enumerate() {
        if !parts[*part as usize].is_given {
            let of_part = generated
                .iter()
                .filter(|(_, owner)| u32::from(*owner) == *part);
            joined
                .tets
                .faces
                .extend(of_part.map(|(face, _)| (*face, tag as u16)));
        }
    }
    joined.drop_unused();
    Ok(TetMesh::with_middles(
        joined.tets,
        &joined.middles,
        surfaces,
    )?)
}

impl Joined<'_> {
    /// Removes vertices that belong to no tet, and renumbers the others.
    fn drop_unused(&mut self) {
        let tets = &mut self.tets;
        let used = tets.tets.iter().flatten().copied();
        let (points, number) = used_points(&tets.points, used);
        if points.len() == tets.points.len() {
            return;
        }
        tets.points = points;
        let new = |v: u32| number[v as usize];
        tets.tets.iter_mut().for_each(|tet| *tet = tet.map(new));
        tets.faces
            .iter_mut()
            .for_each(|(face, _)| *face = face.map(new));
        let middles = std::mem::take(&mut self.middles).into_iter();
        self.middles = middles.map(|(edge, x)| (edge.map(new), x)).collect();
    }
}
