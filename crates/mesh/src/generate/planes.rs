//! Mirror planes that cut bodies and container in halves: what is meshed is the part where coordinates are positive.

use super::geodesic::geodesic_sphere;
use super::surface_mesh::SurfaceMesh;
use super::{Container, MeshedBody};
use crate::{MeshError, SYMMETRY_PLANE_TAGS, Surface, Vec3};

/// Planes through the origin normal to coordinate axes. Points are on a plane if their coordinate is exactly zero.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Planes(pub [bool; 3]);

impl Planes {
    pub fn is_empty(self) -> bool {
        self == Planes::default()
    }

    /// The planes that a point is on.
    pub fn at(self, p: Vec3) -> Planes {
        Planes([0, 1, 2].map(|axis| self.0[axis] && p[axis] == 0.0))
    }

    /// The planes that all points are on.
    pub fn through(self, points: &[Vec3]) -> Planes {
        points.iter().fold(self, |planes, p| planes.at(*p))
    }

    /// Whether all `others` are among these.
    pub fn include(self, others: Planes) -> bool {
        (0..3).all(|axis| self.0[axis] || !others.0[axis])
    }

    /// The first axis that one of these is normal to.
    pub fn axis(self) -> Option<usize> {
        self.0.iter().position(|&plane| plane)
    }

    /// Number of planes.
    pub fn len(self) -> usize {
        self.0.iter().filter(|&&plane| plane).count()
    }

    /// The part of a vector along these planes.
    pub fn along(self, mut v: Vec3) -> Vec3 {
        for axis in 0..3 {
            if self.0[axis] {
                v[axis] = 0.0;
            }
        }
        v
    }

    /// Distance to the nearest plane that is not among `but`, negative beyond it.
    pub fn distance(self, p: Vec3, but: Planes) -> f64 {
        (0..3)
            .filter(|&axis| self.0[axis] && !but.0[axis])
            .fold(f64::INFINITY, |least, axis| least.min(p[axis]))
    }

    /// All sets of one or more of these, those of more planes first: lines before planes.
    pub fn intersections(self) -> Vec<Planes> {
        let mut all: Vec<Planes> = (1..8usize)
            .map(|bits| Planes([0, 1, 2].map(|axis| bits >> axis & 1 == 1)))
            .filter(|planes| self.include(*planes))
            .collect();
        all.sort_by_key(|planes| std::cmp::Reverse(planes.len()));
        all
    }

    /// Steps of one edge to neighbours along the intersection of these: two on a line, six in a plane.
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

    /// The part of a surface where coordinates are positive; its triangles must not cross the planes.
    pub fn cut(self, mesh: SurfaceMesh) -> SurfaceMesh {
        if self.is_empty() {
            return mesh;
        }
        let mut triangles = mesh.triangles;
        triangles.retain(|t| {
            let centroid: Vec3 = t.iter().map(|&v| mesh.points[v as usize]).sum();
            self.distance(centroid, Planes::default()) > 0.0
        });
        let mut number = vec![u32::MAX; mesh.points.len()];
        let mut points = Vec::new();
        // in the order of the points, so that they stay neighbours in memory
        triangles
            .iter()
            .flatten()
            .for_each(|&v| number[v as usize] = 0);
        for (number, point) in number.iter_mut().zip(&mesh.points) {
            if *number == 0 {
                *number = points.len() as u32;
                points.push(*point);
            }
        }
        SurfaceMesh {
            points,
            triangles: triangles
                .iter()
                .map(|t| t.map(|v| number[v as usize]))
                .collect(),
        }
    }

    /// That every plane maps every body and the container onto itself.
    ///
    /// # Errors
    /// [`MeshError::NotSymmetric`], [`MeshError::BadParameter`] for a container whose triangles planes would cut through.
    pub fn check(self, bodies: &[MeshedBody<'_>], container: &Container) -> Result<(), MeshError> {
        if let (false, Container::Capsule(_)) = (self.is_empty(), container) {
            return Err(MeshError::BadParameter {
                what: "number of mirror planes".into(),
                value: self.len() as f64,
                need: "it must be zero in a capsule",
            });
        }
        let own = (Container::TAG, container.surface());
        for (name, surface) in bodies.iter().map(|b| (b.name, b.surface)).chain([own]) {
            if let Some(axis) = (0..3).find(|&axis| self.0[axis] && !is_mirrored(surface, axis)) {
                return Err(MeshError::NotSymmetric {
                    part: name.into(),
                    plane: SYMMETRY_PLANE_TAGS[axis],
                });
            }
        }
        Ok(())
    }
}

/// Whether the plane normal to `axis` maps a surface onto itself, judged by the distances of points around it.
fn is_mirrored(surface: &dyn Surface, axis: usize) -> bool {
    let (centre, radius) = surface.bounding_ball();
    let rounding = 64.0 * f64::EPSILON * centre.norm().max(radius);
    centre[axis] == 0.0
        && geodesic_sphere(0.5).points.iter().all(|d| {
            let mut image = *d;
            image[axis] = -image[axis];
            let [a, b] = [*d, image].map(|d| surface.signed_distance(centre + 1.5 * radius * d));
            (a - b).abs() <= rounding
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_before_planes() {
        let sets = Planes([false, true, true]).intersections();
        let line = Planes([false, true, true]);
        assert_eq!(sets.len(), 3);
        assert_eq!(sets[0], line);
        assert_eq!(line.steps(), [Vec3::x(), -Vec3::x()]);
        assert!(
            sets[1]
                .steps()
                .iter()
                .all(|s| (s.norm() - 1.0).abs() < 1e-15)
        );
        assert_eq!(Planes([true; 3]).intersections().len(), 7);
    }

    #[test]
    fn an_octahedral_sphere_is_cut_into_equal_parts() {
        let whole = super::super::geodesic::octahedral_sphere(0.3);
        for planes in [[false, true, false], [true, true, false], [true; 3]] {
            let part = Planes(planes).cut(whole.clone());
            let parts = 1 << Planes(planes).len();
            assert_eq!(parts * part.triangles.len(), whole.triangles.len());
            // a disc
            let edges = 3 * part.triangles.len();
            let on_rim = part
                .triangles
                .iter()
                .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
                .filter(|e| {
                    !Planes(planes)
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
