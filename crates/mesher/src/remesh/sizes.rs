//! Edge lengths for a new mesh, from those of the old one.

use super::kept_cells::MovedPart;
use crate::GenerateError;
use crate::generate::{GenerateParams, MeshedBody};
use mesh::{TetMesh, Vec3};
use rayon::prelude::*;

/// Edge length that is asked for, as a fraction of that of the old mesh.
///
/// Generated edges are about a sixth longer than asked for.
const OF_MESH: f64 = 6.0 / 7.0;

/// Mean length of the edges at each vertex of a mesh.
pub(super) fn edge_lengths(mesh: &TetMesh) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); mesh.n_vertices()];
    for cell in 0..mesh.n_cells() {
        let x = mesh.cell_vertices(cell);
        let nodes = &mesh.cells()[cell];
        for &[i, j] in &mesh::TET_EDGES {
            let length = (x[i] - x[j]).norm();
            for k in [i, j] {
                let (sum, count) = &mut sums[nodes[k] as usize];
                *sum += length;
                *count += 1.0;
            }
        }
    }
    sums.into_iter()
        .map(|(sum, count)| OF_MESH * sum / count)
        .collect()
}

/// Edge lengths in the new mesh.
///
/// Vertices of the old mesh that are closer to a body than to the walls move with it, and take
/// their edge lengths with them.
pub(super) fn moved_sizes(mesh: &TetMesh, parts: &[MovedPart<'_>]) -> Vec<(Vec3, f64)> {
    let walls = parts.len() - 1;
    let nearest = |x: Vec3| {
        let distances = (parts.iter().enumerate()).map(|(k, part)| match k == walls {
            true => (k, part.surface.signed_distance(x).abs()),
            false => (k, part.surface.signed_distance(part.moved(x))),
        });
        distances
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map_or(walls, |(k, _)| k)
    };
    let points = &mesh.points()[..mesh.n_vertices()];
    (points.par_iter().zip(edge_lengths(mesh)))
        .map(|(&x, length)| (parts[nearest(x)].moved(x), length))
        .collect()
}

/// Edge lengths that gaps between triangulated surfaces allow, at the nodes on the bodies.
///
/// Gaps between two bodies whose triangles are not given are left out.
///
/// # Errors
/// [`GenerateError::BodiesTouch`] and [`GenerateError::BodyAtWall`].
pub(super) fn gap_sizes(
    mesh: &TetMesh,
    parts: &[MovedPart<'_>],
    part_of_tags: &[u32],
    names: &[&str],
    params: &GenerateParams,
) -> Result<Vec<(Vec3, f64)>, GenerateError> {
    let walls = parts.len() - 1;
    let mut sizes = Vec::new();
    for facet in mesh.facets() {
        let part = part_of_tags[usize::from(facet.tag)] as usize;
        if part == walls {
            continue;
        }
        let minimum = params.min_gap * parts[part].surface.bounding_ball().1;
        for x in facet
            .nodes
            .map(|node| parts[part].moved(mesh.points()[node as usize]))
        {
            for (k, other) in parts.iter().enumerate() {
                if k == part || !(parts[part].is_given || other.is_given) {
                    continue;
                }
                let distance = other.distance(x);
                if distance.is_nan() || distance <= minimum {
                    return Err(match names.get(k) {
                        Some(&second) => GenerateError::BodiesTouch {
                            first: names[part].into(),
                            second: second.into(),
                            distance,
                            minimum,
                        },
                        None => GenerateError::BodyAtWall {
                            body: names[part].into(),
                            distance,
                            minimum,
                        },
                    });
                }
                sizes.push((x, params.gap * distance));
            }
        }
    }
    Ok(sizes)
}

/// Repeats the edge lengths around each body around all of its copies, which get equal triangles.
///
/// `copies` has for each body the first one of which it is a copy.
pub(super) fn share_among_copies(
    sizes: &mut Vec<(Vec3, f64)>,
    bodies: &[MeshedBody<'_>],
    copies: &[usize],
) {
    for k in 0..sizes.len() {
        let (x, length) = sizes[k];
        for (body, first) in bodies.iter().zip(copies) {
            let arm = x - body.surface.centre();
            if arm.norm() > 2.0 * body.surface.bounding_ball().1 {
                continue;
            }
            for (other, other_first) in bodies.iter().zip(copies) {
                if other_first == first && other.name != body.name {
                    sizes.push((other.surface.centre() + arm, length));
                }
            }
        }
    }
}
