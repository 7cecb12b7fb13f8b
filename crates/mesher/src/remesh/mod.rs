//! A new mesh between the walls of a given mesh and its moved bodies.

mod bisection;
mod front;
mod gmsh;
mod join;
mod kept_cells;
mod recovered_fronts;
mod sizes;

use crate::GenerateError;
use crate::delaunay::LinkedTets;
use crate::generate::input::{GenerateParams, MeshedBody, first_copies};
use crate::generate::layout::Layout;
use crate::generate::size_field::SizeField;
use crate::generate::size_map::SizeMap;
use crate::generate::symmetry_planes::SymmetryPlanes;
use crate::generate::triangulations::triangulate_bodies;
use crate::generate::{assemble, improve, input_checks, odt_smoothing};
use crate::surface::FlatTriangles;
use bisection::{Edge, bisected, long_in_gaps, longest_edge};
use front::Fronts;
pub use gmsh::remesh_by_gmsh;
use kept_cells::{KeptCells, MovedPart};
use mesh::{Facet, NamedSurface, Surface, SurfaceMesh, TetMesh, Vec3};
use nalgebra::Isometry3;
use recovered_fronts::{BadFace, Recovery, recovered};

/// Largest number of times that the cells that stay are changed.
const MAX_CHANGES: usize = 40;

/// Largest number of times that edges of the mesh are divided.
///
/// Most placements need none to three; each takes as long as a mesh.
const MAX_DIVISIONS: usize = 20;

/// A body around which a mesh is generated again.
#[derive(Clone, Copy)]
pub struct MovedBody<'a> {
    /// Name of its boundary part.
    pub name: &'a str,
    /// Motion from its place in the mesh to its new place.
    pub motion: Isometry3<f64>,
    /// Its surface in the new place and the edge length on it, as [`MeshedBody::size`].
    ///
    /// The surface is triangulated again, with edges about as long as in the mesh. `None` if the
    /// surface is known by the facets of the mesh only, which are then kept or divided.
    pub surface: Option<(&'a dyn Surface, f64)>,
}

/// Generates a new mesh between the walls of a mesh and its moved bodies.
///
/// Walls are all boundary parts that are not bodies. Their facets are kept with their nodes, and so
/// are those of bodies without a known surface, except that facets that are too large are divided:
/// those of bodies whose edges exceed 1.5 times the width of a gap, and those that are not faces of
/// the new cells otherwise. The parts follow the same quadratic map, so the shape stays the same.
/// Edges are about as long as in `mesh`, shorter in gaps, and grow by at most
/// [`GenerateParams::growth`] per unit of length.
///
/// Method: cells of `mesh` near the walls and far from the bodies stay. The rest of the fluid is
/// meshed as by [`generate`](crate::generate()). Faces of the cells that stay are faces of the
/// Delaunay tets if the circumballs of these cells contain no other vertex: new vertices inside are
/// removed, and where other vertices are inside, the next cell stays too, or the cell does not
/// stay. Named regions of the volume are lost, and [`GenerateParams::symmetry_planes`] are ignored.
///
/// Midside nodes on the boundary parts named in `surfaces` are moved to them.
///
/// # Errors
/// [`BadTag`](mesh::MeshError::BadTag) for a body that is named twice,
/// [`UnknownTag`](mesh::MeshError::UnknownTag) for one that is not in the mesh,
/// [`GenerateError::BadParameter`], [`GenerateError::BodiesTouch`], [`GenerateError::BodyAtWall`],
/// [`GenerateError::TooManyVertices`], [`GenerateError::BoundaryNotRecovered`],
/// [`GenerateError::SurfaceNotRecovered`], and those of [`TetMesh::curved`].
pub fn remesh(
    mesh: &TetMesh,
    bodies: &[MovedBody<'_>],
    params: &GenerateParams,
    surfaces: &[NamedSurface],
) -> Result<TetMesh, GenerateError> {
    input_checks::check_params(params)?;
    input_checks::check_bodies(&known_bodies(bodies))?;
    let part_of_tags = part_of_tags(mesh, bodies)?;
    let mut divided: Option<TetMesh> = None;
    let mut divisions = 0;
    loop {
        let mesh = divided.as_ref().unwrap_or(mesh);
        match attempt(mesh, bodies, &part_of_tags, params, surfaces)? {
            Attempt::Done(new) => return Ok(new),
            Attempt::Divide { reason, .. } if divisions == MAX_DIVISIONS => return Err(reason),
            Attempt::Divide { edges, .. } => divided = Some(bisected(mesh, &edges)?),
        }
        divisions += 1;
    }
}

/// What comes of an attempt to generate a new mesh.
enum Attempt {
    /// The mesh.
    Done(TetMesh),
    /// Edges of the old mesh that are too long for it, and the error if they must stay.
    Divide {
        edges: Vec<Edge>,
        reason: GenerateError,
    },
}

/// Generates a new mesh, unless facets of the old one are too large for it.
///
/// # Errors
/// Those of [`remesh`].
fn attempt(
    mesh: &TetMesh,
    bodies: &[MovedBody<'_>],
    part_of_tags: &[u32],
    params: &GenerateParams,
    surfaces: &[NamedSurface],
) -> Result<Attempt, GenerateError> {
    let known = known_bodies(bodies);
    let names: Vec<&str> = bodies.iter().map(|body| body.name).collect();
    let given = given_surfaces(mesh, bodies, part_of_tags);
    let parts = moved_parts(bodies, &given);
    let copies = first_copies(&known);
    let mut sizes = sizes::moved_sizes(mesh, &parts);
    sizes.extend(sizes::gap_sizes(
        mesh,
        &parts,
        part_of_tags,
        &names,
        params,
    )?);
    let edges = long_in_gaps(mesh, &parts, part_of_tags);
    if !edges.is_empty() {
        let reason = not_recovered(mesh, &parts, &names, None);
        return Ok(Attempt::Divide { edges, reason });
    }
    sizes::share_among_copies(&mut sizes, &known, &copies);
    let mut params = params.clone();
    params.max_size = sizes.iter().map(|(_, size)| *size).fold(0.0, f64::max);
    let sizes = SizeMap::new(sizes, params.growth)?;
    let at = |x: Vec3| sizes.at(x);
    let field = SizeField::new(&known, None, &copies, &params)?.with_background(&at);
    let planes = SymmetryPlanes::default();
    let triangulated = triangulate_bodies(&known, &copies, &field, planes, params.max_vertices)?;

    let mut kept = KeptCells::near_walls(mesh, &parts, part_of_tags);
    for change in 0..=MAX_CHANGES {
        let fronts = Fronts::new(mesh, &parts, &kept);
        let layout_parts = fronts.layout_parts(&parts, &triangulated);
        let mut layout = Layout::new(layout_parts, planes, &field, params.max_vertices)?;
        let Recovery { tets, bad } = recovered(&mut layout, &fronts, &kept)?;
        let mut has_changed = false;
        for bad in bad.iter().filter(|_| change < MAX_CHANGES) {
            // Only missing triangles are worth giving up cells.
            let keeps_only = tets.is_some();
            has_changed |= kept.change(&bad.face, bad.part, bad.is_crowded, keeps_only);
        }
        if has_changed {
            continue;
        }
        let Some(tets) = tets else {
            let missing = bad.iter().map(|bad| longest_edge(mesh, bad.face.vertices));
            return Ok(Attempt::Divide {
                edges: missing.collect(),
                reason: not_recovered(mesh, &parts, &names, bad.first()),
            });
        };
        layout.given_offsets = fronts.offsets(mesh, &parts, &layout);
        let mut tets = LinkedTets::new(layout.points.len(), tets);
        tets.retain(|tet| layout.is_fluid(tet));
        let sizes = odt_smoothing::smooth(&mut layout, &mut tets, &field, params.sweeps);
        let tets = improve(&mut layout, tets, sizes, &field, &params);
        let new = assemble::assemble(&layout, &meshed(&names, &parts), &tets)?;
        let pieces = join::Pieces {
            old: mesh,
            kept: &kept,
            parts: &parts,
            part_of_tags,
            fronts: &fronts,
            layout: &layout,
        };
        return Ok(Attempt::Done(join::join(pieces, new, surfaces)?));
    }
    Err(not_recovered(mesh, &parts, &names, None))
}

/// For each tag of the mesh the number of its body; for walls the number of bodies.
///
/// # Errors
/// [`UnknownTag`](mesh::MeshError::UnknownTag); [`BadTag`](mesh::MeshError::BadTag) for a body that
/// is named twice.
fn part_of_tags(mesh: &TetMesh, bodies: &[MovedBody<'_>]) -> Result<Vec<u32>, GenerateError> {
    let walls = bodies.len() as u32;
    let mut parts = vec![walls; mesh.tags().len()];
    for (k, body) in bodies.iter().enumerate() {
        let part = &mut parts[usize::from(mesh.tag(body.name)?)];
        if *part != walls {
            return Err(input_checks::used_twice(body.name));
        }
        *part = k as u32;
    }
    Ok(parts)
}

/// The bodies with known surfaces.
fn known_bodies<'a>(bodies: &[MovedBody<'a>]) -> Vec<MeshedBody<'a>> {
    let known = bodies.iter().filter_map(|body| {
        let (surface, size) = body.surface?;
        Some(MeshedBody::new(body.name, surface, size))
    });
    known.collect()
}

/// The bodies, then the walls, which stay; `given` are their surfaces of [`given_surfaces`].
fn moved_parts<'a>(bodies: &[MovedBody<'a>], given: &'a [FlatTriangles]) -> Vec<MovedPart<'a>> {
    let part = |(k, given): (usize, &'a FlatTriangles)| {
        let body = bodies.get(k);
        let surface = body.and_then(|body| body.surface);
        MovedPart {
            surface: surface.map_or(given, |(surface, _)| surface),
            motion: body.map_or_else(Isometry3::identity, |body| body.motion),
            is_given: surface.is_none(),
            is_wall: body.is_none(),
        }
    };
    given.iter().enumerate().map(part).collect()
}

/// The bodies for the check of their surfaces.
fn meshed<'a>(names: &[&'a str], parts: &[MovedPart<'a>]) -> Vec<MeshedBody<'a>> {
    (names.iter().zip(parts))
        .map(|(name, part)| MeshedBody {
            name,
            surface: part.surface,
            size: 0.0,
        })
        .collect()
}

/// The surfaces of all parts as the facets of the mesh form them, in their new places: bodies,
/// then walls. Normals point out of the body or container.
fn given_surfaces(
    mesh: &TetMesh,
    bodies: &[MovedBody<'_>],
    part_of_tags: &[u32],
) -> Vec<FlatTriangles> {
    let n_bodies = bodies.len();
    let surface = |part: usize| {
        let of_part = |facet: &&Facet| part_of_tags[usize::from(facet.tag)] as usize == part;
        let triangles = mesh.facets().iter().filter(of_part).map(|facet| {
            let [a, b, c, ..] = facet.nodes;
            if part == n_bodies {
                [a, b, c]
            } else {
                [a, c, b]
            }
        });
        let points = mesh.points()[..mesh.n_vertices()].iter();
        let moved = |x: &Vec3| match bodies.get(part) {
            Some(body) => body.motion.transform_point(&(*x).into()).coords,
            None => *x,
        };
        FlatTriangles::new(SurfaceMesh {
            points: points.map(moved).collect(),
            triangles: triangles.collect(),
            ..SurfaceMesh::default()
        })
    };
    (0..=n_bodies).map(surface).collect()
}

/// The error for a given triangle that no tet has as a face.
fn not_recovered(
    mesh: &TetMesh,
    parts: &[MovedPart<'_>],
    names: &[&str],
    missing: Option<&BadFace>,
) -> GenerateError {
    let (part, at) = match missing {
        Some(&BadFace { part, face, .. }) => {
            let corners = face.vertices.map(|v| mesh.points()[v as usize]);
            let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
            (part as usize, parts[part as usize].moved(centroid))
        }
        None => (names.len(), Vec3::zeros()),
    };
    GenerateError::BoundaryNotRecovered {
        part: names.get(part).copied().unwrap_or("walls").into(),
        at: at.into(),
    }
}
