//! Sets of symmetry planes; the part of the fluid with positive coordinates is meshed.

use mesh::{SurfaceMesh, Vec3, used_points};

/// A set of planes through the origin normal to coordinate axes.
///
/// A point is on a plane if its coordinate is exactly zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct SymmetryPlanes(pub [bool; 3]);

impl SymmetryPlanes {
    /// Whether there is no plane.
    pub fn is_empty(self) -> bool {
        self == SymmetryPlanes::default()
    }

    /// Whether the plane normal to `axis` is one of these.
    pub fn normal_to(self, axis: usize) -> bool {
        self.0[axis]
    }

    /// The planes on which the point lies.
    pub fn at(self, p: Vec3) -> SymmetryPlanes {
        SymmetryPlanes([0, 1, 2].map(|axis| self.0[axis] && p[axis] == 0.0))
    }

    /// The planes on which all points lie.
    pub fn through(self, points: &[Vec3]) -> SymmetryPlanes {
        points.iter().fold(self, |planes, p| planes.at(*p))
    }

    /// Whether these planes include all `others`.
    pub fn include(self, others: SymmetryPlanes) -> bool {
        (0..3).all(|axis| self.0[axis] || !others.0[axis])
    }

    /// The first axis to which one of these planes is normal.
    pub fn axis(self) -> Option<usize> {
        self.0.iter().position(|&plane| plane)
    }

    /// Number of planes.
    pub fn len(self) -> usize {
        self.0.iter().filter(|&&plane| plane).count()
    }

    /// Component of a vector parallel to all these planes.
    pub fn along(self, mut v: Vec3) -> Vec3 {
        for axis in 0..3 {
            if self.0[axis] {
                v[axis] = 0.0;
            }
        }
        v
    }

    /// Distance to the nearest of these planes that is not in `except`, negative beyond it.
    pub fn distance(self, p: Vec3, except: SymmetryPlanes) -> f64 {
        (0..3)
            .filter(|&axis| self.0[axis] && !except.0[axis])
            .fold(f64::INFINITY, |nearest, axis| nearest.min(p[axis]))
    }

    /// All non-empty subsets, those with more planes first: lines before planes.
    pub fn intersections(self) -> Vec<SymmetryPlanes> {
        let mut all: Vec<SymmetryPlanes> = (1..8usize)
            .map(|bits| SymmetryPlanes([0, 1, 2].map(|axis| bits >> axis & 1 == 1)))
            .filter(|planes| self.include(*planes))
            .collect();
        all.sort_by_key(|planes| std::cmp::Reverse(planes.len()));
        all
    }

    /// Unit steps to neighbours in the intersection of these planes: two on a line, six in a plane.
    pub fn steps(self) -> Vec<Vec3> {
        let free: Vec<Vec3> = (0..3)
            .filter(|&axis| !self.0[axis])
            .map(|axis| Vec3::ith(axis, 1.0))
            .collect();
        match free[..] {
            [a] => vec![a, -a],
            [a, b] => (0..6)
                .map(|k| {
                    let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_3).sin_cos();
                    cos * a + sin * b
                })
                .collect(),
            _ => Vec::new(),
        }
    }

    /// The part of a surface with positive coordinates; its triangles must not cross the planes.
    ///
    /// The second value has the former number of each triangle.
    pub fn cut(self, mesh: SurfaceMesh) -> (SurfaceMesh, Vec<usize>) {
        if self.is_empty() {
            let all = 0..mesh.triangles.len();
            return (mesh, all.collect());
        }
        let is_kept = |triangle: &&[u32; 3]| {
            let centroid: Vec3 = triangle.iter().map(|&v| mesh.points[v as usize]).sum();
            self.distance(centroid, SymmetryPlanes::default()) > 0.0
        };
        let (kept, triangles): (Vec<usize>, Vec<[u32; 3]>) = (mesh.triangles.iter().enumerate())
            .filter(|(_, triangle)| is_kept(triangle))
            .unzip();
        // The order of the points is kept, so that neighbours stay close in memory.
        let (points, number) = used_points(&mesh.points, triangles.iter().flatten().copied());
        let mesh = SurfaceMesh {
            points,
            triangles: triangles
                .iter()
                .map(|t| t.map(|v| number[v as usize]))
                .collect(),
            sharp_edges: (mesh.sharp_edges.iter())
                .map(|edge| edge.map(|v| number[v as usize]))
                .filter(|edge| edge.iter().all(|&v| v != u32::MAX))
                .collect(),
            ..SurfaceMesh::default()
        };
        (mesh, kept)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_before_planes() {
        let sets = SymmetryPlanes([false, true, true]).intersections();
        let line = SymmetryPlanes([false, true, true]);
        assert_eq!(sets.len(), 3);
        assert_eq!(sets[0], line);
        assert_eq!(line.steps(), [Vec3::x(), -Vec3::x()]);
        assert!(
            sets[1]
                .steps()
                .iter()
                .all(|s| (s.norm() - 1.0).abs() < 1e-15)
        );
        assert_eq!(SymmetryPlanes([true; 3]).intersections().len(), 7);
    }

    #[test]
    fn an_octahedral_sphere_is_cut_into_equal_parts() {
        let whole = super::super::geodesic::octahedral_sphere(0.3);
        for planes in [[false, true, false], [true, true, false], [true; 3]] {
            let (part, _) = SymmetryPlanes(planes).cut(whole.clone());
            let parts = 1 << SymmetryPlanes(planes).len();
            assert_eq!(parts * part.triangles.len(), whole.triangles.len());
            // Euler's formula of a disc.
            let edges = 3 * part.triangles.len();
            let on_rim = part
                .triangles
                .iter()
                .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
                .filter(|e| {
                    !SymmetryPlanes(planes)
                        .through(&e.map(|v| part.points[v as usize]))
                        .is_empty()
                })
                .count();
            assert_eq!(
                part.points.len() + part.triangles.len(),
                (edges + on_rim) / 2 + 1
            );
        }
    }
}
