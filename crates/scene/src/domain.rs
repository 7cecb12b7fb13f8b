//! The region that the fluid fills.

use std::path::PathBuf;

use nalgebra::{Isometry3, Vector3};

use crate::body::Body;
use crate::farthest_point::farthest_distance;
use crate::surface_shape::SurfaceShape;
use crate::wall_facets::WallFacets;
use crate::words::DomainKind;

/// The region that the fluid fills. There is no slip on its walls.
#[derive(Clone, Debug, PartialEq)]
pub enum Domain {
    /// The whole space.
    Unbounded,
    /// A ball centred at the origin.
    Ball {
        /// Radius.
        radius: f64,
    },
    /// A box centred at the origin.
    Box {
        /// Edge lengths.
        size: Vector3<f64>,
    },
    /// An infinite circular cylinder about the x axis.
    Cylinder {
        /// Radius.
        radius: f64,
    },
    /// The half-space above the wall `z = 0`.
    Wall,
    /// The inside of a closed surface from a file.
    Surface(SurfaceShape),
    /// A box without walls that is centred at the origin and repeated in all directions with its
    /// bodies.
    Periodic {
        /// Edge lengths.
        size: Vector3<f64>,
    },
    /// The volume of a mesh.
    Mesh {
        /// Gmsh file; a relative path was resolved from the folder of the scene file.
        file: PathBuf,
        /// Names of the parts of the boundary that are walls.
        walls: Vec<String>,
        /// The facets of the walls; none if the file cannot be used, which the models report.
        facets: Option<WallFacets>,
    },
}

impl Domain {
    /// Kind of the domain, as in the scene file.
    pub fn kind(&self) -> DomainKind {
        match self {
            Self::Unbounded => DomainKind::Unbounded,
            Self::Ball { .. } => DomainKind::Ball,
            Self::Box { .. } => DomainKind::Box,
            Self::Cylinder { .. } => DomainKind::Cylinder,
            Self::Wall => DomainKind::Wall,
            Self::Surface(_) => DomainKind::Surface,
            Self::Mesh { .. } => DomainKind::Mesh,
            Self::Periodic { .. } => DomainKind::Periodic,
        }
    }

    /// Whether walls enclose the fluid on all sides.
    pub fn is_container(&self) -> bool {
        match self {
            Self::Ball { .. } | Self::Box { .. } | Self::Surface(_) | Self::Mesh { .. } => true,
            Self::Unbounded | Self::Cylinder { .. } | Self::Wall | Self::Periodic { .. } => false,
        }
    }

    /// Whether the volume of the bodies in it must stay: in containers, in a periodic box, and in a
    /// tube, in which an endless column of fluid would have to move.
    pub fn keeps_volume(&self) -> bool {
        self.is_container() || matches!(self, Self::Cylinder { .. } | Self::Periodic { .. })
    }

    /// The edge lengths of a periodic box.
    pub fn period(&self) -> Option<Vector3<f64>> {
        match self {
            Self::Periodic { size } => Some(*size),
            _ => None,
        }
    }

    /// The shortest of a difference of two places and those of their periodic images; the
    /// difference itself if the domain is not periodic.
    ///
    /// ```
    /// use nalgebra::Vector3;
    /// let domain = scene::Domain::Periodic { size: Vector3::new(10.0, 10.0, 20.0) };
    /// let nearest = domain.nearest_image(&Vector3::new(9.0, -14.0, 9.0));
    /// assert_eq!(nearest, Vector3::new(-1.0, -4.0, 9.0));
    /// ```
    pub fn nearest_image(&self, apart: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Self::Periodic { size } => apart.zip_map(size, |r, edge| r - edge * (r / edge).round()),
            _ => *apart,
        }
    }

    /// Shifts of the periodic box whose subtraction from a difference of two places gives the
    /// [nearest image](Self::nearest_image) and the 26 around it; zero alone if the domain is not
    /// periodic.
    pub fn shifts_near(&self, apart: &Vector3<f64>) -> Vec<Vector3<f64>> {
        let Self::Periodic { size } = self else {
            return vec![Vector3::zeros()];
        };
        let nearest = apart.zip_map(size, |r, edge| (r / edge).round());
        let steps = || [-1.0, 0.0, 1.0].into_iter();
        let all = steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| [x, y, z])));
        all.map(|step| (nearest + Vector3::from(step)).component_mul(size))
            .collect()
    }

    /// Shifts of the periodic box whose subtraction from a difference of two places can give a
    /// distance of at most `reach`, along each edge; zero alone if the domain is not periodic.
    ///
    /// Cost: a few operations where the reach is below half an edge.
    pub(crate) fn shifts_within(
        &self,
        apart: &Vector3<f64>,
        reach: f64,
    ) -> impl Iterator<Item = Vector3<f64>> + use<> {
        let (apart, size) = (*apart, self.period());
        let range = |axis: usize| match size {
            Some(size) => {
                let edge = size[axis];
                ((apart[axis] - reach) / edge).ceil() as i64
                    ..=((apart[axis] + reach) / edge).floor() as i64
            }
            None => 0..=0,
        };
        let [x, y, z] = [range(0), range(1), range(2)];
        let all = x.flat_map(move |i| {
            let z = z.clone();
            y.clone()
                .flat_map(move |j| z.clone().map(move |k| [i, j, k]))
        });
        all.map(move |number| match size {
            Some(size) => Vector3::from(number.map(|m| m as f64)).component_mul(&size),
            None => Vector3::zeros(),
        })
    }

    /// Clearance between a body and the nearest wall, negative if the body crosses the wall.
    ///
    /// Exact for spheres, a lower bound for other shapes; in a surface from a file, the distance of
    /// the closest points; in a mesh, from the facets of its walls. Infinite without walls.
    pub fn clearance(&self, body: &Body, pose: &Isometry3<f64>) -> f64 {
        match self {
            Self::Mesh { facets, .. } => facets
                .as_ref()
                .map_or(f64::INFINITY, |facets| facets.clearance(&body.shape, pose)),
            Self::Surface(domain) => match body.shape.surface(pose, 1.0) {
                Some(surface) => mesher::clearance(&*surface, &domain.surface),
                None => f64::INFINITY,
            },
            _ => {
                let gaps = self.wall_gaps(body, pose).into_iter();
                let gap = gaps.map(|(gap, _)| gap).fold(f64::INFINITY, f64::min);
                match self {
                    // Slender bodies fit where the balls around them do not; far from the wall
                    // the bound of the ball says enough.
                    Self::Ball { radius }
                        if !body.shape.is_isotropic() && gap < body.bounding_radius() =>
                    {
                        gap.max(radius - farthest_distance(&body.shape, pose))
                    }
                    _ => gap,
                }
            }
        }
    }

    /// Clearance between a body and each wall of simple shape, with the normal of the wall into the
    /// fluid; zero for a wall that is equally far in all directions. None for walls from files.
    pub(crate) fn wall_gaps(&self, body: &Body, pose: &Isometry3<f64>) -> Vec<(f64, Vector3<f64>)> {
        let (centre, rotation) = (&pose.translation.vector, &pose.rotation);
        let support = |direction: &Vector3<f64>| body.shape.support_distance(rotation, direction);
        let inwards = |v: Vector3<f64>| -v.try_normalize(0.0).unwrap_or_default();
        match self {
            Self::Unbounded | Self::Mesh { .. } | Self::Surface(_) | Self::Periodic { .. } => {
                Vec::new()
            }
            Self::Ball { radius } => {
                let gap = radius - centre.norm() - body.bounding_radius();
                vec![(gap, inwards(*centre))]
            }
            Self::Box { size } => {
                let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
                let faces = axes.into_iter().flat_map(|axis| [axis, -axis]);
                let gap = |normal: &Vector3<f64>| {
                    0.5 * size.dot(&normal.abs()) - centre.dot(normal) - support(normal)
                };
                faces.map(|normal| (gap(&normal), -normal)).collect()
            }
            Self::Cylinder { radius } => {
                let widest = body
                    .shape
                    .transverse_support_distance(rotation, &Vector3::x());
                let radial = Vector3::new(0.0, centre.y, centre.z);
                vec![(radius - radial.norm() - widest, inwards(radial))]
            }
            Self::Wall => vec![(centre.z - support(&-Vector3::z()), Vector3::z())],
        }
    }
}
