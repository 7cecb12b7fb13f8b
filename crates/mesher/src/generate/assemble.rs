//! Assembly of the finished mesh, with a check of its boundary faces.

use super::input::{Container, MeshedBody};
use super::layout::Layout;
use crate::GenerateError;
use crate::delaunay::LinkedTets;
use crate::surface::{euler_characteristic, sphere_radius};
use mesh::{LinearTets, Regions, SYMMETRY_PLANE_TAGS, Vec3};
use std::ops::Range;

/// Numbers the vertices of the fluid, finds the boundary faces, and checks them.
///
/// # Errors
/// [`GenerateError::SurfaceNotRecovered`] for a body or container whose faces are not a closed
/// surface through all its vertices, and for a sphere whose faces are not the designed triangles.
pub(crate) fn assemble(
    layout: &Layout<'_>,
    bodies: &[MeshedBody<'_>],
    tets: &LinkedTets,
) -> Result<LinearTets, GenerateError> {
    let n_bodies = bodies.len();
    let mut faces: Vec<Vec<[u32; 3]>> = vec![Vec::new(); n_bodies + 1];
    let mut on_planes: [Vec<[u32; 3]>; 3] = Default::default();
    let not_recovered = |face: [u32; 3], part: usize| {
        let sum: Vec3 = face.iter().map(|&v| layout.points[v as usize]).sum();
        GenerateError::SurfaceNotRecovered {
            body: bodies.get(part).map_or(Container::TAG, |b| b.name).into(),
            at: (sum / 3.0).into(),
        }
    };
    for face in tets.boundary_faces() {
        if let Some(axis) = layout.plane_of(face) {
            on_planes[axis].push(face);
            continue;
        }
        let owner = face.map(|v| layout.owner[v as usize]);
        match faces.get_mut(owner[0] as usize) {
            Some(list) if owner[1] == owner[0] && owner[2] == owner[0] => list.push(face),
            _ => {
                let part = owner.iter().copied().min().unwrap_or(0) as usize;
                return Err(not_recovered(face, part));
            }
        }
    }
    for (part, list) in faces.iter().enumerate() {
        let is_sphere = |body: &MeshedBody| sphere_radius(body.surface).is_some();
        let is_sphere = bodies.get(part).is_some_and(is_sphere);
        if let Some(at) = first_difference_from_design(layout, part, list, is_sphere) {
            return Err(not_recovered(at, part));
        }
    }

    let shift = layout.centres.end - layout.centres.start;
    let number = |v: u32| {
        if v < layout.centres.start {
            v
        } else {
            v - shift
        }
    };
    let names = bodies.iter().map(|b| b.name).chain([Container::TAG]);
    let mut tags: Vec<String> = names.map(str::to_owned).collect();
    for (list, name) in on_planes.into_iter().zip(SYMMETRY_PLANE_TAGS) {
        if !list.is_empty() {
            faces.push(list);
            tags.push(name.to_owned());
        }
    }
    let mut points = layout.points.clone();
    points.drain(layout.centres.start as usize..layout.centres.end as usize);
    Ok(LinearTets {
        points,
        tets: tets.tets().iter().map(|t| t.map(number)).collect(),
        faces: faces
            .iter()
            .enumerate()
            .flat_map(|(part, list)| list.iter().map(move |f| (f.map(number), part as u16)))
            .collect(),
        tags,
        regions: Regions::default(),
    })
}

/// Gives the faces on each side of a box a tag of its own.
///
/// The tags come after all others; numbers of tags that have no faces left are closed up.
pub(crate) fn with_box_sides(mut mesh: LinearTets) -> LinearTets {
    let container = mesh.tags.iter().position(|tag| tag == Container::TAG);
    let first = mesh.tags.len() as u16;
    for (face, tag) in &mut mesh.faces {
        if Some(usize::from(*tag)) == container {
            let [a, b, c] = face.map(|v| mesh.points[v as usize]);
            // Out of the fluid: upwards at upper sides.
            let normal = (b - a).cross(&(c - a));
            let axis = normal.iamax();
            *tag = first + 2 * axis as u16 + u16::from(normal[axis] > 0.0);
        }
    }
    let names = mesh.tags.into_iter();
    let names: Vec<String> = names.chain(Container::BOX_TAGS.map(String::from)).collect();
    let mut numbers = vec![None; names.len()];
    mesh.faces
        .iter()
        .for_each(|face| numbers[usize::from(face.1)] = Some(0));
    mesh.tags = Vec::new();
    for (number, name) in numbers.iter_mut().zip(names) {
        if let Some(number) = number {
            *number = mesh.tags.len() as u16;
            mesh.tags.push(name);
        }
    }
    for (_, tag) in &mut mesh.faces {
        *tag = numbers[usize::from(*tag)].unwrap_or_default();
    }
    mesh
}

/// A triangle, or a vertex three times, at which the faces of a part are not as designed.
fn first_difference_from_design(
    layout: &Layout<'_>,
    part: usize,
    faces: &[[u32; 3]],
    is_sphere: bool,
) -> Option<[u32; 3]> {
    // Given triangles are faces from the start, and flips keep them.
    if layout.is_given[part] {
        return None;
    }
    let designed = &layout.triangles[part];
    if let Some(vertex) = defect(faces, designed, layout.vertices[part].clone(), layout) {
        return Some([vertex; 3]);
    }
    if !is_sphere {
        return None;
    }
    // On spheres the faces must be the designed triangles. The normals of faces point out of the
    // fluid, those of designed triangles out of the body.
    let found = sorted(faces.iter().map(|&[a, b, c]| [a, c, b]));
    first_difference(&found, &sorted(designed.iter().copied()))
}

/// A vertex at which the triangles are not a closed surface through all `vertices`, if there is
/// one.
///
/// The surface must have the Euler characteristic of the `designed` triangles and, if symmetry
/// planes cut it, a rim that lies on the planes.
fn defect(
    triangles: &[[u32; 3]],
    designed: &[[u32; 3]],
    vertices: Range<u32>,
    layout: &Layout<'_>,
) -> Option<u32> {
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .collect();
    edges.sort_unstable();
    // Each directed edge must occur once, and so must its reverse: every edge joins two triangles
    // of consistent orientation.
    if let Some(pair) = edges.windows(2).find(|pair| pair[0] == pair[1]) {
        return Some(pair[0][0]);
    }
    let on_plane = |edge: &[u32; 2]| {
        let ends = edge.map(|v| layout.points[v as usize]);
        !layout.planes.through(&ends).is_empty()
    };
    let is_matched = |edge: &[u32; 2]| edges.binary_search(&[edge[1], edge[0]]).is_ok();
    if let Some(edge) = edges.iter().find(|e| !is_matched(e) && !on_plane(e)) {
        return Some(edge[0]);
    }
    let mut starts: Vec<u32> = edges.iter().map(|e| e[0]).collect();
    starts.dedup();
    let mut missing = vertices
        .clone()
        .filter(|v| starts.binary_search(v).is_err());
    let is_other = euler_characteristic(triangles) != euler_characteristic(designed);
    missing.next().or(is_other.then_some(vertices.start))
}

/// Sorted list of the triangles, each rotated to begin with its smallest vertex.
fn sorted(triangles: impl Iterator<Item = [u32; 3]>) -> Vec<[u32; 3]> {
    let mut list: Vec<[u32; 3]> = triangles
        .map(|[a, b, c]| match a.min(b).min(c) {
            m if m == a => [a, b, c],
            m if m == b => [b, c, a],
            _ => [c, a, b],
        })
        .collect();
    list.sort_unstable();
    list
}

/// The first triangle that is in only one of two sorted lists.
fn first_difference(a: &[[u32; 3]], b: &[[u32; 3]]) -> Option<[u32; 3]> {
    let mut pairs = a.iter().zip(b);
    match pairs.find(|(x, y)| x != y) {
        Some((x, y)) => Some(*x.min(y)),
        None => a.get(b.len()).or(b.get(a.len())).copied(),
    }
}
