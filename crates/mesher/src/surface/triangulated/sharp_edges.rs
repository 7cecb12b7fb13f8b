//! Sharp edges of a triangulation, and the directions in which they pass through vertices.

use crate::surface::triangles;
use std::collections::BTreeMap;

use super::Defect;
use mesh::{SurfaceMesh, Vec3};

/// Cosine between the normals at the sharpest edge around which cells fit: 30 degrees are left
/// between the two sides.
const SHARPEST: f64 = -0.866_025_403_784_438_6;

/// The sharp edges of a triangulation.
#[derive(Clone)]
pub(super) struct SharpEdges {
    /// For each triangle, whether the edge opposite each vertex is sharp.
    pub of_triangles: Vec<[bool; 3]>,
    /// Vertices with other than two sharp edges, or at which they turn sharply.
    pub corners: Vec<u32>,
    /// Ends of the two sharp edges at the vertices through which one passes smoothly.
    passing: BTreeMap<u32, [u32; 2]>,
    /// Unit tangent at the vertices through which a sharp edge passes smoothly.
    tangents: BTreeMap<u32, Vec3>,
}

impl SharpEdges {
    /// The edges at which the normals of the triangles differ by more than `angle` degrees.
    ///
    /// # Errors
    /// A defect where the two sides of an edge are folded onto each other.
    pub fn find(mesh: &SurfaceMesh, neighbours: &[[u32; 3]], angle: f64) -> Result<Self, Defect> {
        let normals: Vec<Vec3> = triangles::corners(mesh)
            .map(|[a, b, c]| (b - a).cross(&(c - a)).normalize())
            .collect();
        let limit = angle.to_radians().cos();
        let mut of_triangles = vec![[false; 3]; mesh.triangles.len()];
        let mut around: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            for i in 0..3 {
                let other = neighbours[t][i] as usize;
                let cosine = normals[t].dot(&normals[other]);
                if cosine < SHARPEST {
                    let problem = format!(
                        "is folded onto triangle {}: their edge is sharper than 30 degrees; make \
                         it blunt",
                        other + 1
                    );
                    return Err(Defect::in_middle(mesh, t, problem));
                }
                of_triangles[t][i] = cosine < limit;
                let (a, b) = (triangle[(i + 1) % 3], triangle[(i + 2) % 3]);
                if cosine < limit {
                    // The neighbour has this edge in the other direction.
                    around.entry(a).or_default().push(b);
                }
            }
        }
        let at = |v: u32| mesh.points[v as usize];
        let mut passing = BTreeMap::new();
        let mut corners = Vec::new();
        let is_smooth = |v: u32, ends: [u32; 2]| {
            let [back, forth] = ends.map(|end| at(end) - at(v));
            back.dot(&forth) <= -limit * back.norm() * forth.norm()
        };
        for (&v, ends) in &around {
            match ends[..] {
                [a, b] if is_smooth(v, [a, b]) => drop(passing.insert(v, [a, b])),
                _ => corners.push(v),
            }
        }
        let edges = Self {
            of_triangles,
            corners,
            passing,
            tangents: BTreeMap::new(),
        };
        Ok(edges.moved(mesh))
    }

    /// The same edges of a mesh with the same triangles.
    #[must_use]
    pub fn moved(&self, mesh: &SurfaceMesh) -> Self {
        let at = |v: u32| mesh.points[v as usize];
        let tangent = |(&v, ends): (&u32, &[u32; 2])| {
            let [back, forth] = ends.map(|end| at(end) - at(v));
            // The tangent of the circle through the three points.
            let tangent = forth / forth.norm_squared() - back / back.norm_squared();
            Some((v, tangent.try_normalize(0.0)?))
        };
        Self {
            tangents: self.passing.iter().filter_map(tangent).collect(),
            ..self.clone()
        }
    }

    /// Refuses other sharp edges than these of a mesh with the same triangles.
    ///
    /// Edges that are sharp here may be blunt there.
    pub fn check_others(&self, mesh: &SurfaceMesh, others: &Self) -> Result<(), Defect> {
        let both = self.of_triangles.iter().zip(&others.of_triangles);
        let is_new = |(own, other): (&[bool; 3], &[bool; 3])| (0..3).any(|i| other[i] && !own[i]);
        match both.map(is_new).position(|is_new| is_new) {
            None => Ok(()),
            Some(t) => {
                let problem = "has a sharp edge where the first surface is smooth; use finer \
                               triangles there, or deform the surface less";
                Err(Defect::in_middle(mesh, t, problem))
            }
        }
    }

    /// Point next to `v` on the curve of the sharp edge from `v` to another vertex.
    pub fn next_to(&self, mesh: &SurfaceMesh, v: u32, other: u32) -> Vec3 {
        let from = mesh.points[v as usize];
        let arm = (mesh.points[other as usize] - from) / 3.0;
        match self.tangents.get(&v) {
            Some(tangent) => from + tangent * tangent.dot(&arm),
            None => from + arm,
        }
    }

    /// Pairs of vertices, the smaller one first.
    pub fn pairs(&self, mesh: &SurfaceMesh) -> Vec<[u32; 2]> {
        let triangles = mesh.triangles.iter().zip(&self.of_triangles);
        let edges = triangles.flat_map(|(triangle, sharp)| {
            let sharp = (0..3).filter(|&i| sharp[i]);
            sharp.map(|i| [triangle[(i + 1) % 3], triangle[(i + 2) % 3]])
        });
        edges.filter(|[a, b]| a < b).collect()
    }
}
