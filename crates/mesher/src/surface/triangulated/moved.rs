//! The triangles of a surface with moved vertices.

use mesh::{SurfaceMesh, Vec3};

use super::patch::{Patch, integrals};
use super::vertex_normals;
use super::{Defect, Parts, TriangleKind, TriangulatedSurface};
use crate::GenerateError;

/// Curved triangles through vertices, without the checks and the search of closest points of a
/// [`TriangulatedSurface`].
///
/// Vertices that move take the points between them along: a point is known by its triangle and its
/// barycentric coordinates there.
#[derive(Clone, Debug)]
pub struct CurvedTriangles {
    patches: Vec<Patch>,
}

impl CurvedTriangles {
    /// The point of a triangle with these barycentric coordinates.
    pub fn at(&self, triangle: usize, barycentric: [f64; 3]) -> Vec3 {
        self.patches[triangle].at(barycentric)
    }

    /// The triangles enlarged by a factor about the origin.
    #[must_use]
    pub fn scaled(mut self, factor: f64) -> Self {
        let patches = self.patches.iter_mut();
        patches.for_each(|patch| *patch = patch.scaled(factor));
        self
    }

    /// Volume inside.
    pub fn volume(&self) -> f64 {
        let about = self.patches[0].corners[0];
        integrals(&self.patches, about).volume
    }

    /// Radius of a ball about the origin that contains the triangles.
    pub fn radius(&self) -> f64 {
        let points = self.patches.iter().flat_map(Patch::hull);
        points.map(|x| x.norm()).fold(0.0, f64::max)
    }
}

impl TriangulatedSurface {
    /// The vertices, in their order.
    pub fn vertices(&self) -> Vec<Vec3> {
        let points = self.parts.mesh.points.iter();
        points.map(|x| self.own(*x)).collect()
    }

    /// Vertex numbers of the triangles.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.parts.mesh.triangles
    }

    /// The triangle closest to a point, and the barycentric coordinates of the closest point there.
    pub fn locate(&self, x: Vec3) -> (usize, [f64; 3]) {
        let foot = self.parts.closest(&self.in_file(x));
        (foot.triangle, foot.at)
    }

    /// The same triangles through other vertices, curved as those of a surface through these
    /// vertices, with the sharp edges of this one.
    ///
    /// Other points of the triangles are smooth functions of the vertices.
    pub fn curved_through(&self, vertices: Vec<Vec3>) -> CurvedTriangles {
        let parts = &self.parts;
        let mesh = SurfaceMesh {
            points: vertices,
            ..parts.mesh.clone()
        };
        let patches = match parts.kind {
            TriangleKind::Faceted => vertex_normals::flat(&mesh),
            TriangleKind::Smooth => {
                let edges = parts.edges.moved(&mesh);
                let normals = vertex_normals::corner_normals(&mesh, &parts.neighbours, &edges);
                vertex_normals::curved(&mesh, &normals, &edges)
            }
        };
        CurvedTriangles { patches }
    }

    /// What is wrong with the surface of the same triangles through other vertices: folds, sharp
    /// edges where this one is smooth, triangles that meet elsewhere than at common vertices.
    ///
    /// # Errors
    /// [`GenerateError::BadSurface`] with the name, the triangle and the place.
    pub fn check_moved(&self, name: &str, vertices: Vec<Vec3>) -> Result<(), GenerateError> {
        let mesh = self.moved_mesh(name, vertices)?;
        let checked = Parts::checked(&mesh, self.parts.kind, Some(&self.parts.edges));
        checked.map(drop).map_err(|defect| defect.of(name))
    }

    /// The surface of the same triangles through other vertices in own coordinates, after all
    /// checks; its sharp edges are those of this one.
    ///
    /// # Errors
    /// As [`TriangulatedSurface::new`], and for sharp edges where this surface is smooth.
    pub fn with_vertices(&self, name: &str, vertices: Vec<Vec3>) -> Result<Self, GenerateError> {
        let mesh = self.moved_mesh(name, vertices)?;
        let parts = Parts::new(mesh, self.parts.kind, Some(&self.parts.edges))
            .map_err(|defect| defect.of(name))?;
        Ok(Self::from_parts(parts))
    }

    fn moved_mesh(&self, name: &str, vertices: Vec<Vec3>) -> Result<SurfaceMesh, GenerateError> {
        let mesh = &self.parts.mesh;
        if vertices.len() != mesh.points.len() {
            let (own, given) = (mesh.points.len(), vertices.len());
            let problem = format!("belongs to a surface of {given} vertices, not {own}");
            return Err(Defect::new(0, Vec3::zeros(), problem).of(name));
        }
        Ok(SurfaceMesh {
            points: vertices,
            triangles: mesh.triangles.clone(),
            ..SurfaceMesh::default()
        })
    }
}

#[cfg(test)]
mod tests {
    use mesh::Surface;

    use super::*;

    fn octahedron() -> SurfaceMesh {
        SurfaceMesh {
            points: [1.0, -1.0]
                .into_iter()
                .flat_map(|s| [s * Vec3::x(), s * Vec3::y(), s * Vec3::z()])
                .collect(),
            triangles: vec![
                [0, 1, 2],
                [1, 3, 2],
                [3, 4, 2],
                [4, 0, 2],
                [1, 0, 5],
                [3, 1, 5],
                [4, 3, 5],
                [0, 4, 5],
            ],
            ..SurfaceMesh::default()
        }
    }

    /// The octahedron, its triangles divided into four and moved onto the unit sphere three times.
    fn sphere() -> SurfaceMesh {
        let mut mesh = octahedron();
        for _ in 0..3 {
            let mut middles = std::collections::BTreeMap::new();
            let old = std::mem::take(&mut mesh.triangles);
            for [a, b, c] in old {
                let mut middle = |i: u32, j: u32| {
                    *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                        let sum = mesh.points[i as usize] + mesh.points[j as usize];
                        mesh.points.push(sum.normalize());
                        mesh.points.len() as u32 - 1
                    })
                };
                let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
                mesh.triangles
                    .extend([[a, d, f], [d, b, e], [f, e, c], [d, e, f]]);
            }
        }
        mesh
    }

    /// Vertices of an affine image give the same surface as its triangles, and points keep their
    /// barycentric coordinates.
    #[test]
    fn moved_vertices_give_the_surface_of_the_moved_triangles() {
        let mesh = sphere();
        let own = TriangulatedSurface::new("sphere", mesh.clone(), TriangleKind::Smooth).unwrap();
        let stretch = |x: &Vec3| x.component_mul(&Vec3::new(1.4, 1.0, 0.8));
        let points: Vec<Vec3> = mesh.points.iter().map(stretch).collect();
        let direct = SurfaceMesh {
            points: points.clone(),
            ..mesh
        };
        let direct = TriangulatedSurface::new("ellipsoid", direct, TriangleKind::Smooth).unwrap();
        let moved = own.with_vertices("moved", points.clone()).unwrap();
        assert_eq!(moved, direct);
        let curved = own.curved_through(points);
        assert!((curved.volume() / moved.volume() - 1.0).abs() < 1e-14);
        for x in [Vec3::new(1.0, 0.3, 0.2), Vec3::new(-0.5, 0.7, -0.6)] {
            let (triangle, at) = moved.locate(x);
            let foot = moved.closest_point(x);
            assert!((curved.at(triangle, at) - foot).norm() < 1e-14);
        }
    }

    /// The faces of a sphere with its vertices on it are smaller than the sphere by what the smooth
    /// surface tells; an octahedron has sharp edges and no smooth surface but itself.
    #[test]
    fn the_smooth_surface_tells_what_faces_leave_out() {
        let faces = |mesh| TriangulatedSurface::new("a", mesh, TriangleKind::Faceted).unwrap();
        let ball = faces(sphere());
        let exact = (4.0 / 3.0 * std::f64::consts::PI / ball.volume()).cbrt();
        let size = ball.smooth_size().unwrap();
        assert!(exact > 1.004, "{exact}");
        assert!(
            (size - exact).abs() < 0.05 * (exact - 1.0),
            "{size} {exact}"
        );
        let smooth = TriangulatedSurface::new("a", sphere(), TriangleKind::Smooth).unwrap();
        assert_eq!(smooth.smooth_size(), None);
        assert!((smooth.volume() / ball.volume() / size.powi(3) - 1.0).abs() < 1e-12);
        let size = faces(octahedron()).smooth_size().unwrap();
        assert!((size - 1.0).abs() < 1e-14, "{size}");
    }

    #[test]
    fn edges_that_become_sharp_and_surfaces_that_cross_themselves_are_refused() {
        let mesh = sphere();
        let own = TriangulatedSurface::new("sphere", mesh.clone(), TriangleKind::Smooth).unwrap();
        let flat = mesh.points.iter();
        let flat = flat.map(|x| x.component_mul(&Vec3::new(1.0, 1.0, 0.1)));
        let error = own.check_moved("flat", flat.collect()).unwrap_err();
        assert!(error.to_string().contains("smooth"), "{error}");
        // The poles change places, and nothing else.
        let crossed = mesh.points.iter().map(|x| match x.z.abs() > 0.99 {
            true => -x,
            false => *x,
        });
        assert!(own.check_moved("crossed", crossed.collect()).is_err());
        assert!(own.check_moved("few", vec![Vec3::zeros()]).is_err());
    }
}
