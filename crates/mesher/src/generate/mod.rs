//! Generation of tet meshes around bodies in a container.
//!
//! Surface triangulations, packing of the vertices, Delaunay tetrahedralisation, smoothing, hill
//! climbing.

pub(crate) mod assemble;
mod capsule_mesh;
mod gap;
mod geodesic;
pub(crate) mod hill_climbing;
pub(crate) mod input;
pub(crate) mod input_checks;
pub(crate) mod layout;
pub(crate) mod odt_smoothing;
mod packing;
mod point_grid;
mod recovered_surfaces;
pub(crate) mod size_field;
pub(crate) mod size_map;
pub(crate) mod surface_refinement;
mod surface_triangulation;
pub(crate) mod symmetry_planes;
pub(crate) mod triangulations;

pub use gap::clearance;
pub use input::{Container, GenerateParams, MeshedBody};
pub use size_map::SizeMap;

use crate::GenerateError;
use crate::delaunay::LinkedTets;
use hill_climbing::HillClimbing;
use layout::Layout;
use mesh::{LinearTets, Vec3};
use recovered_surfaces::Missing;
use size_field::{Background, SizeField};
use std::collections::HashSet;
use std::time::Instant;
use triangulations::Triangulations;

/// A generated mesh, with the time it took.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Generated {
    /// Tets and tagged faces: tag `i` is body `i`, the next one is [`Container::TAG`], then come
    /// the symmetry planes. With [`GenerateParams::box_sides`] the sides of the box come last
    /// instead.
    pub mesh: LinearTets,
    /// Duration of each stage, in seconds.
    pub seconds: StageSeconds,
}

/// Duration of the stages of [`generate`], in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct StageSeconds {
    /// Surface triangulations and packing of vertices.
    pub points: f64,
    /// Delaunay tetrahedralisation and smoothing.
    pub smoothing: f64,
    /// Hill climbing.
    pub hill_climbing: f64,
    /// Checks and boundary faces.
    pub checking: f64,
}

/// Generates a mesh of the fluid between `bodies` and `container`.
///
/// Edges have the length [`MeshedBody::size`] on a body, grow by [`GenerateParams::growth`] per
/// unit of distance, and are shorter in gaps. Surface vertices lie on the true surfaces. Bodies of
/// the same shape and size get the same surface vertices, translated. Spheres also get the same
/// triangles; on other shapes, four vertices that lie nearly on a circle may be joined across
/// either diagonal. Deterministic: the mesh is the same for any number of threads.
///
/// Method: geodesic points on spheres, and points from splitting, flipping and smoothing where
/// sizes vary; a lattice-like packing of vertices between the surfaces; Delaunay tetrahedralisation
/// with exact predicates; sweeps of optimal-Delaunay smoothing, each followed by flips; hill
/// climbing on the worst angles.
/// A surface triangle is a face of a Delaunay tet because the body behind it contains a (nearly)
/// empty ball: edges are shorter than the [`reach`](mesh::Surface::reach) of the surface, and the
/// only vertex inside a convex body is its centre. Of the tets with all vertices on one body, those
/// whose circumcentre is inside belong to the body: their boundary is the restricted Delaunay
/// triangulation of the surface (Edelsbrunner & Shah 1997). The result is checked: the faces on
/// each body must form a closed surface through all its vertices, with the Euler characteristic of
/// the designed triangulation, and on spheres they must be the designed triangles.
///
/// # Errors
/// [`BadTag`](mesh::MeshError::BadTag) for a name used twice, [`GenerateError::BadParameter`],
/// [`GenerateError::NotSymmetric`], [`GenerateError::BodiesTouch`], [`GenerateError::BodyAtWall`],
/// [`GenerateError::TooManyVertices`], and [`GenerateError::SurfaceNotRecovered`] where the tets do
/// not follow a surface because the element size is too large for its shape.
///
/// ```
/// use mesh::Vec3;
/// use mesher::{Container, GenerateParams, MeshedBody, Sphere, generate};
/// let sphere = Sphere::new(Vec3::zeros(), 1.0);
/// let container = Container::Ball(Sphere::new(Vec3::zeros(), 10.0));
/// let body = MeshedBody::new("sphere", &sphere, 0.6);
/// let mesh = generate(&[body], &container, &GenerateParams::default())?.mesh;
/// assert_eq!(mesh.tags, ["sphere", "outer"]);
/// // An icosahedron with each face divided into four.
/// assert_eq!(mesh.faces.iter().filter(|f| f.1 == 0).count(), 80);
/// # Ok::<(), mesher::GenerateError>(())
/// ```
pub fn generate(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
) -> Result<Generated, GenerateError> {
    generate_with(bodies, container, params, None)
}

/// Generates a mesh as [`generate`] does, with a given edge length at every point.
///
/// `size` must grow by no more than [`GenerateParams::growth`] per unit of length. Where it is not
/// a positive number, sizes are those of [`generate`]. Gaps, curvature and the container remain
/// upper bounds. Bodies of the same shape and [`MeshedBody::size`] get the surface mesh of the
/// first of them, so `size` should be the same around all of them.
///
/// # Errors
/// As [`generate`].
pub fn generate_sized(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
    size: &(dyn Fn(Vec3) -> f64 + Sync),
) -> Result<Generated, GenerateError> {
    generate_with(bodies, container, params, Some(size))
}

fn generate_with(
    bodies: &[MeshedBody<'_>],
    container: &Container,
    params: &GenerateParams,
    background: Option<Background<'_>>,
) -> Result<Generated, GenerateError> {
    input_checks::check(bodies, container, params)?;
    let mut seconds = StageSeconds::default();
    let mut clock = Instant::now();
    let mut lap = |stage: &mut f64| {
        *stage += clock.elapsed().as_secs_f64();
        clock = Instant::now();
    };

    let copies = input::first_copies(bodies);
    let mut field = SizeField::new(bodies, Some(container), &copies, params)?;
    if let Some(background) = background {
        field = field.with_background(background);
    }
    if let Container::Capsule(capsule) = container {
        let edge = capsule_mesh::smallest_edge(capsule, &|x| field.at(x));
        field = field.with_wall(capsule, edge);
    }
    let mut surfaces = Triangulations::new(bodies, container, &copies, field, params)?;
    let mut layout = surfaces.layout()?;
    lap(&mut seconds.points);

    let mut changes = 0;
    let mut tets = loop {
        let missing = match recovered_surfaces::recovered(&mut layout)? {
            Ok(tets) => break tets,
            Err(missing) => missing,
        };
        if changes == MAX_CHANGES {
            let Missing { part, triangle, .. } = missing[0];
            return Err(surfaces.not_recovered(part, triangle));
        }
        changes += 1;
        surfaces.change(&missing)?;
        layout = surfaces.layout()?;
    };
    let sizes = odt_smoothing::smooth(&mut layout, &mut tets, surfaces.field(), params.sweeps);
    lap(&mut seconds.smoothing);

    let tets = improve(&mut layout, tets, sizes, surfaces.field(), params);
    lap(&mut seconds.hill_climbing);

    let mut mesh = assemble::assemble(&layout, bodies, &tets)?;
    if params.box_sides {
        mesh = assemble::with_box_sides(mesh);
    }
    lap(&mut seconds.checking);
    Ok(Generated { mesh, seconds })
}

/// Largest number of times that triangles of surfaces with sharp edges are changed.
///
/// A faceted cylinder of 32 sides needs up to 5.
const MAX_CHANGES: usize = 40;

/// Largest number of rounds of hill climbing and flips.
///
/// One or two reach the target in most scenes, and later ones lower the mean quality.
const ROUNDS: usize = 4;

/// Largest number of edges that are divided because of inverted tets.
const MAX_DIVISIONS: usize = 50;

/// Improves the worst tets, and divides edges of those that still have no volume or are inverted by
/// their curved edges.
///
/// Several such tets at one vertex can be such that no move of a single vertex improves all of
/// them; a new vertex in the middle of an edge can move out of their planes.
pub(crate) fn improve(
    layout: &mut Layout,
    mut tets: LinkedTets,
    mut sizes: Vec<f64>,
    field: &SizeField<'_>,
    params: &GenerateParams,
) -> LinkedTets {
    for _ in 0..MAX_DIVISIONS {
        (layout.points, tets) = climbed(layout, tets, &sizes, params);
        let faces = tets.boundary_faces();
        let offsets = layout.midside_offsets(&faces);
        let cells = HillClimbing::new(tets.tets(), &layout.free, &offsets, layout.planes, &sizes);
        let edges = faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let boundary: HashSet<[u32; 2]> = edges.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let edge = (cells.inverted(&layout.points))
            .find_map(|tet| layout.longest_inner_edge(tet, &boundary));
        let Some(edge) = edge else { break };
        let middle = layout.divide(edge);
        sizes.push(field.at(layout.points[middle as usize]));
        let halves = |tet: &[u32; 4]| match edge.iter().all(|v| tet.contains(v)) {
            true => edge
                .map(|end| tet.map(|v| if v == end { middle } else { v }))
                .to_vec(),
            false => vec![*tet],
        };
        let divided = tets.tets().iter().flat_map(halves).collect();
        tets = LinkedTets::new(layout.points.len(), divided);
    }
    tets
}

/// Alternates hill climbing with flips to Delaunay tets.
///
/// Returns the points and tets of the round whose worst tet has the highest quality.
fn climbed(
    layout: &mut Layout,
    mut tets: LinkedTets,
    sizes: &[f64],
    params: &GenerateParams,
) -> (Vec<Vec3>, LinkedTets) {
    let offsets = layout.midside_offsets(&tets.boundary_faces());
    let mut best = (f64::NEG_INFINITY, layout.points.clone(), tets.clone());
    for _ in 0..ROUNDS {
        let climbing = HillClimbing::new(tets.tets(), &layout.free, &offsets, layout.planes, sizes);
        let quality = climbing.run(&mut layout.points, params.target_dihedral);
        if quality > best.0 {
            best = (quality, layout.points.clone(), tets.clone());
        }
        if quality >= 1.0 - params.target_dihedral.to_radians().cos() {
            break;
        }
        tets.flip_to_delaunay(&layout.points, layout);
    }
    (best.1, best.2)
}
