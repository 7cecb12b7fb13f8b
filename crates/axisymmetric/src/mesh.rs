//! The triangle mesh of a meridian domain.

use std::collections::BTreeMap;

use crate::boundary_polygon::{BoundaryEdge, BoundaryPolygon};
use crate::point::Point;

/// A conforming triangulation with the curve on which each boundary edge lies.
pub(crate) struct MeridianMesh {
    pub points: Vec<Point>,
    /// Corners, counter-clockwise.
    pub triangles: Vec<[usize; 3]>,
    /// Edges of each triangle: edge `e` runs from its corner `e` to the next.
    pub edges: Vec<[usize; 3]>,
    /// The two ends of each edge, the smaller index first.
    pub ends: Vec<[usize; 2]>,
    /// The boundary curve of each edge; `None` in the interior.
    pub boundary: Vec<Option<BoundaryEdge>>,
}

impl MeridianMesh {
    /// Numbers the edges of a triangulation whose first points are those of `polygon`.
    pub fn connect(
        points: Vec<Point>,
        triangles: Vec<[usize; 3]>,
        polygon: &BoundaryPolygon,
    ) -> Self {
        let mut numbers = BTreeMap::new();
        let mut ends = Vec::new();
        let edges = triangles
            .iter()
            .map(|corners| {
                [0, 1, 2].map(|e| {
                    let pair = [corners[e], corners[(e + 1) % 3]];
                    let key = [pair[0].min(pair[1]), pair[0].max(pair[1])];
                    *numbers.entry(key).or_insert_with(|| {
                        ends.push(key);
                        ends.len() - 1
                    })
                })
            })
            .collect();
        let boundary = ends.iter().map(|&[a, b]| polygon.edge(a, b)).collect();
        Self {
            points,
            triangles,
            edges,
            ends,
            boundary,
        }
    }

    /// Whether a triangle has a curved edge.
    pub fn is_curved(&self, triangle: usize) -> bool {
        self.edges[triangle]
            .iter()
            .any(|&edge| self.boundary[edge].is_some_and(|b| b.curve.is_curved()))
    }
}
