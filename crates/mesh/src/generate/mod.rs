//! Generation of tet meshes around bodies in a container: designed points, Delaunay, smoothing, hill climbing.

mod capsule_mesh;
mod climb;
mod container;
mod copies;
mod geodesic;
mod layout;
mod odt;
mod packing;
mod planes;
mod refine;
mod size;
mod size_map;
mod surface_mesh;
mod verify;

pub use container::Container;
pub use size_map::SizeMap;

use crate::delaunay::delaunay;
use crate::{LinearTets, MeshError, Surface, Vec3};
use layout::Layout;
use size::{Background, SizeField};
use std::time::Instant;

/// A body to be meshed around.
#[derive(Clone, Copy)]
pub struct MeshedBody<'a> {
    /// Name, which becomes the tag of its facets.
    pub name: &'a str,
    /// Its surface, convex.
    pub surface: &'a dyn Surface,
    /// Wanted edge length on it; at most 0.7 of the smallest radius of curvature is used where that is.
    pub size: f64,
}

/// How edge lengths spread from the bodies into the fluid, and how hard to try.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct GenerateParams {
    /// Growth of the edge length with the distance to the nearest body, above 0 and at most 0.6.
    ///
    /// Three spheres of size 0.3 in a ball of radius 40, vertices and mean quality: 0.2: 12147, 0.892; 0.25: 7775, 0.888;
    /// 0.3: 5256, 0.880; 0.35: 3804, 0.871; 0.4: 2819, 0.851; 0.5: 1900, 0.817.
    pub growth: f64,
    /// In gaps, edges are at most this times the sum of the distances to the two surfaces.
    ///
    /// 0.6 puts one layer of vertices into the middle of a gap, with regular tets on both sides of it (each `0.816 h` high). From
    /// 0.83 on tets reach from surface to surface: their velocity is that of the bodies, their angles cannot be improved.
    pub gap: f64,
    /// Longest edge anywhere.
    pub max_size: f64,
    /// Bodies must be this times the (smaller) radius away from each other and from the wall.
    ///
    /// The edges in a gap are as long as it is wide, and the number of triangles around it grows like one over its width.
    pub min_gap: f64,
    /// Mesh only the part of the fluid where coordinates are positive, on one side of mirror planes through the origin normal to these axes.
    ///
    /// Every body and the container must be its own image in each plane. The planes' faces are tagged [`SYMMETRY_PLANE_TAGS`](crate::SYMMETRY_PLANE_TAGS);
    /// [`TetMesh::unfolded`](crate::TetMesh::unfolded) gives the whole. Spheres are then triangulated from the octahedron, which no plane cuts.
    pub symmetry_planes: [bool; 3],
    /// Smoothing sweeps; the mean quality of that mesh is 0.865, 0.878, 0.880, 0.886 after 4, 8, 10, 20.
    pub sweeps: usize,
    /// Dihedral angles below this (or above 180 minus it), degrees, are improved by moving single vertices.
    pub target_dihedral: f64,
    /// Give up when more vertices than this would be needed.
    pub max_vertices: usize,
}

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
        }
    }
}

/// A generated mesh and how it came about.
#[derive(Clone, Debug)]
pub struct Generated {
    /// Tets and tagged faces: tag `i` is body `i`, the last tag is [`Container::TAG`].
    pub mesh: LinearTets,
    /// Seconds for each stage.
    pub seconds: StageSeconds,
}

/// Seconds spent by [`generate`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StageSeconds {
    /// Surface triangulations and packing of vertices.
    pub points: f64,
    /// Smoothing, with a Delaunay tetrahedralisation a sweep.
    pub smoothing: f64,
    /// Hill climbing.
    pub hill_climbing: f64,
    /// Checks and boundary faces.
    pub checking: f64,
}

/// Meshes the fluid between `bodies` and `container`.
///
/// Edges have the length [`MeshedBody::size`] on a body, grow by [`GenerateParams::growth`] a unit of distance, and are shorter in
/// gaps. Bodies of the same shape and size get the same surface vertices, translated, and spheres the same triangles; on other
/// shapes four vertices that lie nearly on a circle may be joined across either diagonal. Surface vertices lie on the
/// true surfaces. Deterministic: the same mesh for any number of threads.
///
/// Method: geodesic points on spheres, or points spread by splitting, flipping and smoothing where sizes vary; a lattice-like
/// packing between; Delaunay tetrahedralisation with exact predicates; sweeps of optimal-Delaunay smoothing; hill climbing on
/// the worst angles. A surface triangle is a face of the Delaunay tets because its body, which holds no vertex but its
/// centre, is (nearly) an empty ball behind it; that the faces of the tets are closed surfaces through all vertices of the bodies
/// is checked at the end, and for spheres that they are the designed ones.
///
/// # Errors
/// Names used twice, numbers that make no sense, bodies that touch or leave the container, too many vertices, and a surface that
/// the tets do not follow (size too large for its shape).
///
/// ```
/// use mesh::{MeshedBody, Container, GenerateParams, Sphere, Vec3, generate};
/// let sphere = Sphere { centre: Vec3::zeros(), radius: 1.0 };
/// let container = Container::Ball(Sphere { centre: Vec3::zeros(), radius: 10.0 });
/// let body = MeshedBody { name: "sphere", surface: &sphere, size: 0.6 };
/// let mesh = generate(&[body], &container, &GenerateParams::default())?.mesh;
/// assert_eq!(mesh.tags, ["sphere", "outer"]);
/// assert_eq!(mesh.faces.iter().filter(|f| f.1 == 0).count(), 80); // an icosahedron, each face cut in four
/// # Ok::<(), mesh::MeshError>(())
/// ```
pub fn generate(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
) -> Result<Generated, MeshError> {
    generate_with(bodies, container, params, None)
}

/// As [`generate`], with the wanted edge length given everywhere instead of growing from the bodies.
///
/// `size` must grow by no more than [`GenerateParams::growth`] a unit of length; where it is not a positive number, sizes are
/// those of [`generate`]. Gaps, curvature and the container still bound it from above. Bodies of the same shape and [`MeshedBody::size`]
/// get the surface mesh of the first of them: give them equal sizes.
///
/// # Errors
/// As [`generate`].
pub fn generate_sized(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
    size: &(dyn Fn(Vec3) -> f64 + Sync),
) -> Result<Generated, MeshError> {
    generate_with(bodies, container, params, Some(size))
}

fn generate_with(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
    background: Option<Background<'_>>,
) -> Result<Generated, MeshError> {
    layout::check(bodies, container, params)?;
    let mut seconds = StageSeconds::default();
    let mut clock = Instant::now();
    let mut lap = |stage: &mut f64| {
        *stage += clock.elapsed().as_secs_f64();
        clock = Instant::now();
    };

    let copies = copies::first_copies(bodies);
    let mut field = SizeField::new(bodies, container, &copies, params)?;
    if let Some(background) = background {
        field = field.with_background(background);
    }
    if let Container::Capsule(capsule) = container {
        let edge = capsule_mesh::smallest_edge(capsule, &|x| field.at(x));
        field = field.with_wall(capsule, edge);
    }
    let mut layout = Layout::new(bodies, container, &copies, &field, params)?;
    lap(&mut seconds.points);

    for _ in 0..params.sweeps {
        let tets = layout.fluid(delaunay(&layout.points)?);
        let target = odt::smoothed(&layout.points, &tets, &field);
        layout.move_free(&target, &field);
    }
    lap(&mut seconds.smoothing);

    let (points, tets) = improve(&mut layout, &field, params)?;
    lap(&mut seconds.hill_climbing);

    layout.points = points;
    let mesh = verify::assemble(&layout, bodies, tets)?;
    lap(&mut seconds.checking);
    Ok(Generated { mesh, seconds })
}

/// Rounds of Delaunay and hill climbing at most: one or two reach the target on most scenes, and later ones lower the mean quality.
const ROUNDS: usize = 4;

/// Alternates Delaunay with hill climbing and keeps the best.
fn improve(
    layout: &mut Layout,
    field: &SizeField<'_>,
    params: &GenerateParams,
) -> Result<(Vec<Vec3>, Vec<[u32; 4]>), MeshError> {
    let mut best = (f64::NEG_INFINITY, Vec::new(), Vec::new());
    for _ in 0..ROUNDS {
        let tets = layout.fluid(delaunay(&layout.points)?);
        let edges = layout.bulges(&tets);
        let score = climb::climb(
            &mut layout.points,
            &tets,
            &layout.free,
            layout.planes,
            &edges,
            field,
            params.target_dihedral,
        );
        if score > best.0 {
            best = (score, layout.points.clone(), tets);
        }
        if score >= 1.0 - params.target_dihedral.to_radians().cos() {
            break;
        }
    }
    Ok((best.1, best.2))
}
