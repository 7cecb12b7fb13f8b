//! Boundary faces of a set of tets.

/// Faces that belong to exactly one tet, with the normal out of the tet, sorted by their vertices.
pub(super) fn boundary_faces(tets: &[[u32; 4]]) -> Vec<[u32; 3]> {
    let mut all: Vec<([u32; 3], [u32; 3])> = Vec::with_capacity(4 * tets.len());
    for &[a, b, c, d] in tets {
        for face in [[b, c, d], [a, d, c], [a, b, d], [a, c, b]] {
            let mut key = face;
            key.sort_unstable();
            all.push((key, face));
        }
    }
    all.sort_unstable();
    let single = |i: usize| {
        (i == 0 || all[i - 1].0 != all[i].0) && (i + 1 == all.len() || all[i + 1].0 != all[i].0)
    };
    (0..all.len())
        .filter(|&i| single(i))
        .map(|i| all[i].1)
        .collect()
}
