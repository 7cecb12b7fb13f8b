//! The part of a tetrahedralisation inside closed surfaces.

use super::linked_tets::{FACE, LinkedTets, NONE, split};
use std::collections::HashMap;

/// The tets on the inner side of closed surfaces, whose `triangles` have normals to the outer side.
///
/// Cost: O(n).
///
/// # Errors
/// The indices of the triangles that are not faces of `tets`, ascending.
pub(crate) fn carve(
    n_points: usize,
    tets: Vec<[u32; 4]>,
    triangles: &[[u32; 3]],
) -> Result<Vec<[u32; 4]>, Vec<usize>> {
    let linked = LinkedTets::new(n_points, tets);
    let key = |mut face: [u32; 3]| {
        face.sort_unstable();
        face
    };
    let wanted: HashMap<[u32; 3], usize> = (triangles.iter().enumerate())
        .map(|(index, triangle)| (key(*triangle), index))
        .collect();
    let mut found = vec![false; triangles.len()];
    let mut is_surface = vec![[false; 4]; linked.tets.len()];
    let mut outside = vec![false; linked.tets.len()];
    let mut front = Vec::new();
    for (t, tet) in linked.tets.iter().enumerate() {
        for (i, corners) in FACE.iter().enumerate() {
            // The normal of this face points into the tet.
            let face = corners.map(|k| tet[k]);
            let Some(&index) = wanted.get(&key(face)) else {
                continue;
            };
            found[index] = true;
            is_surface[t][i] = true;
            if is_rotated(face, triangles[index]) && !outside[t] {
                outside[t] = true;
                front.push(t);
            }
        }
    }
    if found.contains(&false) {
        return Err((0..triangles.len()).filter(|&k| !found[k]).collect());
    }
    while let Some(t) = front.pop() {
        for (i, &across) in linked.across[t].iter().enumerate() {
            let (u, _) = split(across);
            if across != NONE && !is_surface[t][i] && !outside[u] {
                outside[u] = true;
                front.push(u);
            }
        }
    }
    let mut kept = linked.tets;
    let mut is_outside = outside.into_iter();
    kept.retain(|_| is_outside.next() == Some(false));
    Ok(kept)
}

/// Whether two triangles with the same vertices have the same orientation.
fn is_rotated(a: [u32; 3], b: [u32; 3]) -> bool {
    let shift = b.iter().position(|&v| v == a[0]).unwrap_or(0);
    b[(shift + 1) % 3] == a[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delaunay::delaunay;
    use crate::delaunay::linked_tets::volume;
    use mesh::Vec3;

    /// Points of an octahedron and of a larger one around it.
    fn octahedra() -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let corners: Vec<Vec3> = axes.iter().flat_map(|&a| [a, -a]).collect();
        let outer = corners.iter().map(|p| 3.0 * p);
        let points = corners.iter().copied().chain(outer).collect();
        let mut triangles = Vec::new();
        for octant in 0..8u32 {
            let [a, b, c] = [0, 1, 2].map(|axis| 2 * axis + (octant >> axis & 1));
            // An odd number of negative coordinates reverses the orientation.
            match octant.count_ones() % 2 {
                0 => triangles.push([a, b, c]),
                _ => triangles.push([a, c, b]),
            }
        }
        (points, triangles)
    }

    #[test]
    fn orientations_of_the_triangles_decide_on_the_side() {
        let (points, triangles) = octahedra();
        let tets = delaunay(&points, 0..0).unwrap();
        let inner = carve(points.len(), tets.clone(), &triangles).unwrap();
        assert!((volume(&inner, &points) - 4.0 / 3.0).abs() < 1e-14);
        let reversed: Vec<_> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
        let outer = carve(points.len(), tets.clone(), &reversed).unwrap();
        assert!((volume(&outer, &points) - 26.0 * 4.0 / 3.0).abs() < 1e-13);
        let mut other = triangles;
        other[3] = [0, 1, 6];
        assert_eq!(carve(points.len(), tets, &other), Err(vec![3]));
    }
}
