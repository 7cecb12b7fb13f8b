//! What a mesh is generated from: bodies, container, parameters.

use super::geodesic::geodesic_sphere;
use crate::{BoxSurface, Capsule, GenerateError, Sphere, TriangulatedSurface};
use mesh::{Surface, Vec3};

/// Largest edge on a ball or cylinder, as a fraction of its radius, and on other smooth shapes as a
/// fraction of the radius of curvature and of that of the largest ball inside.
///
/// Quadratic edges then stay within `0.4^4 / 384` radii, below 1e-4, of the surface.
const OF_RADIUS: f64 = 0.4;

/// Largest edge in a box, as a fraction of its shortest side: three layers of cells between
/// opposite walls.
const OF_SIDE: f64 = 1.0 / 3.0;

/// A body around which a mesh is generated.
#[derive(Clone, Copy)]
pub struct MeshedBody<'a> {
    /// Name, which becomes the tag of its facets.
    pub name: &'a str,
    /// Surface.
    pub surface: &'a dyn Surface,
    /// Edge length on the surface.
    ///
    /// Edges are shorter where the surface is strongly curved: at most 0.7 of the smaller radius of
    /// curvature, and less in proportion if `size` is less than 0.4 of the radius of the largest
    /// ball inside the body. They are at most 1.2 of this radius, so that opposite sides of a thin
    /// body stay separate.
    pub size: f64,
}

impl<'a> MeshedBody<'a> {
    /// The body with this name, surface and edge length.
    pub fn new(name: &'a str, surface: &'a dyn Surface, size: f64) -> Self {
        Self {
            name,
            surface,
            size,
        }
    }
}

/// The container of the fluid; its facets are tagged [`Container::TAG`].
#[derive(Clone, Debug, PartialEq)]
pub enum Container {
    /// The inside of a sphere.
    Ball(Sphere),
    /// The inside of a box with sides along the axes.
    Box(BoxSurface),
    /// The inside of a cylinder closed by hemispheres.
    ///
    /// All edges on its wall have the same length, the smallest needed anywhere on it: one body
    /// close to the wall makes the whole wall fine.
    Capsule(Capsule),
    /// The inside of a closed surface of triangles.
    Surface(TriangulatedSurface),
}

impl Container {
    /// Tag of the container's facets.
    pub const TAG: &'static str = "outer";

    /// Tags of the lower and the upper side of a box normal to x, y and z, if
    /// [`GenerateParams::box_sides`] is set: those of [`LinearTets::cube`](mesh::LinearTets::cube).
    pub const BOX_TAGS: [&'static str; 6] = ["x0", "x1", "y0", "y1", "z0", "z1"];

    /// Surface of the container; distances are negative inside, where the fluid is.
    pub fn surface(&self) -> &dyn Surface {
        match self {
            Self::Ball(sphere) => sphere,
            Self::Box(surface) => surface,
            Self::Capsule(capsule) => capsule,
            Self::Surface(surface) => surface,
        }
    }

    /// Longest edge with which the container is resolved.
    pub(super) fn largest_size(&self) -> f64 {
        match self {
            Self::Ball(sphere) => OF_RADIUS * sphere.radius,
            Self::Capsule(capsule) => OF_RADIUS * capsule.radius,
            Self::Box(surface) => OF_SIDE * (surface.max - surface.min).min(),
            Self::Surface(surface) => OF_RADIUS * surface.inradius(),
        }
    }

    /// Longest edge at a point that the curvature and the narrow parts of the container allow, if
    /// they vary.
    pub(super) fn local_size(&self, point: Vec3, growth: f64) -> f64 {
        match self {
            Self::Surface(surface) => surface.curvature_size(point, OF_RADIUS, growth),
            Self::Ball(_) | Self::Capsule(_) | Self::Box(_) => f64::INFINITY,
        }
    }
}

/// Parameters of mesh generation: grading of the edge lengths, symmetry planes, effort.
///
/// ```
/// use mesher::GenerateParams;
/// let params = GenerateParams::default().with_growth(0.4).with_sweeps(6);
/// assert_eq!((params.growth, params.sweeps, params.gap), (0.4, 6, 0.6));
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GenerateParams {
    /// Growth of the edge length per unit of distance from the nearest body, above 0 and at most
    /// 0.6; 0.3 by default.
    ///
    /// Vertices and mean quality for three spheres of size 0.3 in a ball of radius 40: 0.2: 12147,
    /// 0.901; 0.25: 7775, 0.896; 0.3: 5256, 0.889; 0.35: 3804, 0.879; 0.4: 2819, 0.866;
    /// 0.5: 1900, 0.833.
    pub growth: f64,
    /// Largest ratio of the edge length in a gap to the sum of the distances from its two surfaces;
    /// 0.6 by default.
    ///
    /// 0.6 puts one layer of vertices into the middle of a gap, with regular tets on both sides,
    /// whose height is 0.816 edges. From 0.83 on, tets extend from surface to surface: their
    /// velocities are those of the bodies, and their angles cannot be improved.
    pub gap: f64,
    /// Longest edge anywhere; infinite by default.
    pub max_size: f64,
    /// Smallest allowed distance between bodies and to the wall, as a fraction of the (smaller)
    /// radius; 1e-3 by default.
    ///
    /// The edges in a gap are about as long as its width, and the number of triangles around it
    /// grows inversely with the width.
    pub min_gap: f64,
    /// The axes whose coordinate planes are symmetry planes; none by default.
    ///
    /// Only the part of the fluid with positive coordinates is meshed.
    ///
    /// The container must be symmetric about each plane, and every body too unless it lies on the
    /// positive side. The faces on the planes are
    /// tagged [`SYMMETRY_PLANE_TAGS`](mesh::SYMMETRY_PLANE_TAGS), and
    /// [`TetMesh::unfolded`](mesh::TetMesh::unfolded) returns the whole mesh. Spheres are then
    /// triangulated from the octahedron, whose triangles do not cross the planes.
    pub symmetry_planes: [bool; 3],
    /// Number of smoothing sweeps; 10 by default.
    ///
    /// In the example of [`growth`](Self::growth) the mean quality after 4, 6, 8, 10, 20 sweeps is
    /// 0.856, 0.880, 0.885, 0.889, 0.891. With fewer sweeps hill climbing takes longer.
    pub sweeps: usize,
    /// Target of the worst dihedral angle, in degrees; 22 by default.
    ///
    /// Single vertices move until all angles are between `target_dihedral` and 180 minus
    /// `target_dihedral`, or no longer improve.
    pub target_dihedral: f64,
    /// Largest number of vertices, 4 million by default; generation fails if more are needed.
    pub max_vertices: usize,
    /// Whether the sides of a [`Container::Box`] are tagged apart, by [`Container::BOX_TAGS`].
    ///
    /// By default all of them have the tag [`Container::TAG`]. The mesh is the same. Other
    /// containers must not have this.
    pub box_sides: bool,
}

setters!(GenerateParams {
    with_growth(growth: f64),
    with_gap(gap: f64),
    with_max_size(max_size: f64),
    with_min_gap(min_gap: f64),
    with_symmetry_planes(symmetry_planes: [bool; 3]),
    with_sweeps(sweeps: usize),
    with_target_dihedral(target_dihedral: f64),
    with_max_vertices(max_vertices: usize),
    with_box_sides(box_sides: bool),
});

impl Default for GenerateParams {
    fn default() -> Self {
        GenerateParams {
            growth: 0.3,
            gap: 0.6,
            max_size: f64::INFINITY,
            min_gap: 1e-3,
            symmetry_planes: [false; 3],
            sweeps: 10,
            target_dihedral: 22.0,
            max_vertices: 4_000_000,
            box_sides: false,
        }
    }
}

/// For each body, the first body of which it is a translated copy, or itself.
pub(crate) fn first_copies(bodies: &[MeshedBody<'_>]) -> Vec<usize> {
    let mut firsts: Vec<usize> = Vec::with_capacity(bodies.len());
    for (i, body) in bodies.iter().enumerate() {
        // Comparing with bodies that are not copies themselves is enough.
        let first = (0..i).find(|&j| firsts[j] == j && is_copy(body, &bodies[j]));
        firsts.push(first.unwrap_or(i));
    }
    firsts
}

/// Whether two bodies differ by a translation only, according to the distances of points around
/// them.
fn is_copy(a: &MeshedBody<'_>, b: &MeshedBody<'_>) -> bool {
    let ((_, r_a), (_, r_b)) = (a.surface.bounding_ball(), b.surface.bounding_ball());
    // Tolerance for the rounding of positions, which may be large compared with the radius.
    let largest = a
        .surface
        .centre()
        .norm()
        .max(b.surface.centre().norm())
        .max(r_a);
    let rounding = 64.0 * f64::EPSILON * largest;
    let same = |x: f64, y: f64| (x - y).abs() <= rounding;
    a.size == b.size
        && same(r_a, r_b)
        && geodesic_sphere(0.5).points.iter().all(|d| {
            let arm = 1.5 * r_a * d;
            same(
                a.surface.signed_distance(a.surface.centre() + arm),
                b.surface.signed_distance(b.surface.centre() + arm),
            )
        })
}

/// Fails with [`GenerateError::BadParameter`] unless a requirement is met.
pub(super) fn demand(
    is_met: bool,
    what: &str,
    value: f64,
    requirement: &'static str,
) -> Result<(), GenerateError> {
    if is_met {
        return Ok(());
    }
    Err(GenerateError::BadParameter {
        what: what.into(),
        value,
        requirement,
    })
}

/// Fails unless a length is positive and finite.
pub(super) fn length(what: &str, value: f64) -> Result<(), GenerateError> {
    let is_met = value > 0.0 && value.is_finite();
    demand(is_met, what, value, "it must be positive and finite")
}

/// Fails unless a point is finite.
pub(super) fn finite(what: &str, x: Vec3) -> Result<(), GenerateError> {
    let mut components = x.iter();
    components.try_for_each(|&c| demand(c.is_finite(), what, c, "it must be finite"))
}
