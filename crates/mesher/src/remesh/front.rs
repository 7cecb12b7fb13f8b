//! The surfaces between the cells that stay and the fluid that is meshed again.

use super::kept_cells::{FrontFace, KeptCells, MovedPart};
use crate::generate::hill_climbing::MidsideOffsets;
use crate::generate::layout::{Layout, Part};
use crate::surface::FlatTriangles;
use mesh::{SurfaceMesh, TET_EDGES, TetMesh, Vec3};
use std::collections::HashMap;

/// The triangles of one part.
pub(super) struct Front {
    pub faces: Vec<FrontFace>,
    /// The vertices of the triangles, by their numbers in the old mesh, ascending.
    pub vertices: Vec<u32>,
    /// The triangles in their new places, with the normal out of the body or container.
    pub surface: FlatTriangles,
}

/// For each part, the triangles if they are given.
pub(super) struct Fronts(pub Vec<Option<Front>>);

impl Fronts {
    /// Finds the triangles and moves them to their new places.
    pub fn new(mesh: &TetMesh, parts: &[MovedPart<'_>], kept: &KeptCells<'_>) -> Self {
        let walls = parts.len() - 1;
        let front = |(k, part): (usize, &MovedPart)| {
            if !part.is_given {
                return None;
            }
            let faces = kept.front(k as u32);
            let mut vertices: Vec<u32> = faces.iter().flat_map(|face| face.vertices).collect();
            vertices.sort_unstable();
            vertices.dedup();
            let points = vertices
                .iter()
                .map(|&v| part.moved(mesh.points()[v as usize]));
            let number = |v: u32| vertices.partition_point(|&w| w < v) as u32;
            let triangles = faces.iter().map(|face| {
                let [a, b, c] = face.vertices.map(number);
                if k == walls { [a, b, c] } else { [a, c, b] }
            });
            let surface = FlatTriangles::new(SurfaceMesh {
                points: points.collect(),
                triangles: triangles.collect(),
                ..SurfaceMesh::default()
            });
            Some(Front {
                faces,
                vertices,
                surface: if k == walls {
                    surface.with_samples()
                } else {
                    surface
                },
            })
        };
        Self(parts.iter().enumerate().map(front).collect())
    }

    /// Bodies and walls for the layout; `triangulated` has the surfaces that are not given.
    pub fn layout_parts<'a>(
        &'a self,
        parts: &[MovedPart<'a>],
        triangulated: &[SurfaceMesh],
    ) -> Vec<Part<'a>> {
        let mut triangulated = triangulated.iter();
        let part = |(front, part): (&'a Option<Front>, &MovedPart<'a>)| match front {
            Some(front) => Part {
                surface: &front.surface,
                mesh: front.surface.mesh().clone(),
                is_given: true,
            },
            None => Part {
                surface: part.surface,
                mesh: triangulated.next().cloned().unwrap_or_default(),
                is_given: false,
            },
        };
        self.0.iter().zip(parts).map(part).collect()
    }

    /// The triangles, each with its part, in the order of [`Layout::given_faces`].
    pub fn faces(&self) -> impl Iterator<Item = (u32, &FrontFace)> {
        (self.0.iter().enumerate()).flat_map(|(k, front)| {
            let faces = front.iter().flat_map(|front| &front.faces);
            faces.map(move |face| (k as u32, face))
        })
    }

    /// New numbers of the vertices of the triangles.
    pub fn numbers(&self, layout: &Layout<'_>) -> HashMap<u32, u32> {
        let mut numbers = HashMap::new();
        for (front, range) in self.0.iter().zip(&layout.vertices) {
            let vertices = front.iter().flat_map(|front| &front.vertices);
            numbers.extend(vertices.copied().zip(range.clone()));
        }
        numbers
    }

    /// Offsets of the midside nodes of the triangles from the midpoints, where they are not zero.
    pub fn offsets(
        &self,
        mesh: &TetMesh,
        parts: &[MovedPart<'_>],
        layout: &Layout<'_>,
    ) -> MidsideOffsets {
        let numbers = self.numbers(layout);
        let mut offsets = MidsideOffsets::new();
        for (k, face) in self.faces() {
            for ([v, w], node) in edges_of(mesh, face.ahead) {
                if !(face.vertices.contains(&v) && face.vertices.contains(&w)) {
                    continue;
                }
                let [x, y, middle] =
                    [v, w, node].map(|node| parts[k as usize].moved(mesh.points()[node as usize]));
                let offset = middle - 0.5 * (x + y);
                if offset != Vec3::zeros() {
                    let [v, w] = [numbers[&v], numbers[&w]];
                    offsets.insert([v.min(w), v.max(w)], offset);
                }
            }
        }
        offsets
    }
}

/// The edges of a cell, each with its midside node.
pub(super) fn edges_of(mesh: &TetMesh, cell: usize) -> impl Iterator<Item = ([u32; 2], u32)> {
    let nodes = mesh.cells()[cell];
    (TET_EDGES.into_iter().enumerate()).map(move |(e, [i, j])| ([nodes[i], nodes[j]], nodes[4 + e]))
}
