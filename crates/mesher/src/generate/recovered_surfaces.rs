//! Delaunay tets that have the triangles of surfaces with sharp edges as faces.

use super::layout::{Layout, is_flat};
use super::surface_refinement::circumcircle;
use crate::GenerateError;
use crate::delaunay::{LinkedTets, carve, delaunay, linked_delaunay};
use std::collections::{BTreeMap, HashSet};

/// Part of the radius of a ball by which the vertices on its surface may be inside.
const ROUNDING: f64 = 1e-10;

/// A designed triangle that is not a face of the tets.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Missing {
    /// The body, or the number of bodies for the container.
    pub part: usize,
    /// The triangle, by its number before symmetry planes cut the surface.
    pub triangle: usize,
    /// A missing neighbour with which it exchanges the diagonal for two faces of the tets.
    pub with: Option<usize>,
}

/// The tets in the fluid, or the triangles that are missing.
///
/// Vertices of the fluid in the smallest balls through the corners of missing triangles are removed
/// from the layout, if there are no others in these balls.
///
/// # Errors
/// Those of [`delaunay`].
pub(super) fn recovered(
    layout: &mut Layout<'_>,
) -> Result<Result<LinkedTets, Vec<Missing>>, GenerateError> {
    let given = layout.given_faces();
    if given.is_empty() {
        let mut tets = linked_delaunay(&layout.points, layout.centres.clone())?;
        tets.retain(|tet| layout.is_fluid(tet));
        return Ok(Ok(tets));
    }
    loop {
        let tets = delaunay(&layout.points, layout.centres.clone())?;
        let missing = match carve(layout.points.len(), tets.clone(), &given) {
            Ok(mut tets) => {
                tets.retain(|tet| layout.is_fluid(tet));
                let tets = without_flat(layout, tets, &given);
                // From now on the faces of the tets decide.
                layout.is_given.fill(false);
                return Ok(Ok(LinkedTets::new(layout.points.len(), tets)));
            }
            Err(missing) => missing,
        };
        let mut in_the_way: Vec<usize> = Vec::new();
        let mut is_blocked = false;
        for &index in &missing {
            let corners = given[index].map(|v| layout.points[v as usize]);
            let (centre, radius) = circumcircle(corners);
            let inside: Vec<usize> = (0..layout.points.len())
                .filter(|&v| (layout.points[v] - centre).norm() <= radius * (1.0 - ROUNDING))
                .collect();
            is_blocked |= inside.is_empty() || inside.iter().any(|&v| !layout.free[v]);
            in_the_way.extend(inside);
        }
        // Where vertices of surfaces are in the way, the triangles must change first.
        if is_blocked {
            return Ok(Err(explained(layout, &tets, &given, &missing)));
        }
        in_the_way.sort_unstable();
        in_the_way.dedup();
        layout.remove(&in_the_way);
    }
}

/// The tets without flat ones between two given triangles, of which they exchange the diagonal.
///
/// Four vertices in a plane or on a smooth part of a surface may lie nearly on a circle, and the
/// tet between them then has no or little volume. Diagonals that are sharp edges stay.
fn without_flat(layout: &Layout<'_>, mut tets: Vec<[u32; 4]>, given: &[[u32; 3]]) -> Vec<[u32; 4]> {
    let mut surface: HashSet<[u32; 3]> = given.iter().map(|face| sorted(*face)).collect();
    let mut is_dropped = |tet: &[u32; 4]| {
        let owner = tet.map(|v| layout.owner[v as usize]);
        if owner.iter().any(|&part| part != owner[0])
            || layout.is_given.get(owner[0] as usize) != Some(&true)
            || !is_flat(tet.map(|v| layout.points[v as usize]))
        {
            return false;
        }
        let faces = [0, 1, 2, 3].map(|i| sorted([1, 2, 3].map(|k| tet[(i + k) % 4])));
        let given = faces.map(|face| surface.contains(&face));
        // The vertices opposite two given faces are the ends of the other diagonal.
        let shared: Vec<u32> = (0..4).filter(|&i| !given[i]).map(|i| tet[i]).collect();
        let &[a, b] = shared.as_slice() else {
            return false;
        };
        if layout.sharp.contains(&[a.min(b), a.max(b)]) {
            return false;
        }
        for (face, given) in faces.iter().zip(given) {
            match given {
                true => surface.remove(face),
                false => surface.insert(*face),
            };
        }
        true
    };
    loop {
        let before = tets.len();
        tets.retain(|tet| !is_dropped(tet));
        if tets.len() == before {
            return tets;
        }
    }
}

/// The vertices of a triangle in ascending order.
fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

/// The missing ones of the given triangles, in pairs where the tets have the other diagonal.
fn explained(
    layout: &Layout<'_>,
    tets: &[[u32; 4]],
    given: &[[u32; 3]],
    missing: &[usize],
) -> Vec<Missing> {
    let owner = |v: u32| layout.owner[v as usize];
    let faces: HashSet<[u32; 3]> = (tets.iter())
        .flat_map(|&[a, b, c, d]| [[a, b, c], [a, b, d], [a, c, d], [b, c, d]])
        .filter(|face| face.iter().all(|&v| owner(v) == owner(face[0])))
        .map(sorted)
        .collect();
    // Parts with given triangles, in the order of these.
    let numbers: Vec<(usize, usize)> = (layout.designed.iter().enumerate())
        .filter(|(part, _)| layout.is_given[*part])
        .flat_map(|(part, numbers)| numbers.iter().map(move |&number| (part, number)))
        .collect();
    let mut beside: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for &index in missing {
        let [a, b, c] = given[index];
        for [a, b] in [[a, b], [b, c], [c, a]] {
            beside.entry([a.min(b), a.max(b)]).or_default().push(index);
        }
    }
    let mut partner: BTreeMap<usize, usize> = BTreeMap::new();
    for (edge, pair) in beside {
        let &[s, t] = pair.as_slice() else { continue };
        let [a, d] = [s, t].map(|index| given[index].into_iter().find(|v| !edge.contains(v)));
        let (Some(a), Some(d)) = (a, d) else { continue };
        let exist = edge.iter().all(|&v| faces.contains(&sorted([a, d, v])));
        if exist && !partner.contains_key(&s) && !partner.contains_key(&t) {
            partner.insert(s, t);
            partner.insert(t, s);
        }
    }
    let missing = missing.iter().map(|index| Missing {
        part: numbers[*index].0,
        triangle: numbers[*index].1,
        with: partner.get(index).map(|&other| numbers[other].1),
    });
    missing.collect()
}
