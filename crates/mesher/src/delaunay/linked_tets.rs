//! Tets linked with their neighbours.

use mesh::Grouped;
#[cfg(test)]
use mesh::Vec3;

/// Vertices of the face opposite each vertex, ordered such that `(face, opposite vertex)` is a
/// positively oriented tet.
pub(super) const FACE: [[usize; 3]; 4] = [[1, 3, 2], [0, 2, 3], [0, 3, 1], [0, 1, 2]];

/// The neighbour across a face on the boundary.
pub(super) const NONE: u32 = u32::MAX;

/// Positively oriented tets, each with its neighbours.
///
/// A face has the number `4 t + i`, where `t` is the tet and `i` the position of the opposite
/// vertex. The same face has another number in the neighbour.
#[derive(Clone, Debug)]
pub(crate) struct LinkedTets {
    pub(super) tets: Vec<[u32; 4]>,
    /// For each face its number in the neighbour, or [`NONE`].
    pub(super) across: Vec<[u32; 4]>,
}

/// Tet and position of a face.
#[inline]
pub(super) fn split(face: u32) -> (usize, usize) {
    ((face >> 2) as usize, (face & 3) as usize)
}

/// Number of the face of tet `t` opposite its vertex `i`.
#[inline]
pub(super) fn face_number(t: usize, i: usize) -> u32 {
    (t as u32) << 2 | i as u32
}

impl LinkedTets {
    /// Links tets between `n_points` vertices by their common faces.
    ///
    /// Cost: O(n), by a list of the faces around each vertex.
    pub fn new(n_points: usize, tets: Vec<[u32; 4]>) -> Self {
        // Faces are sorted by their smallest vertex, and compared by the other two.
        let faces = || {
            let all = (0..tets.len()).flat_map(|t| [0, 1, 2, 3].map(|i| (t, i)));
            all.map(|(t, i)| {
                let mut face = FACE[i].map(|k| tets[t][k]);
                face.sort_unstable();
                (face[0], ([face[1], face[2]], face_number(t, i)))
            })
        };
        let mut faces = Grouped::new(n_points, faces);
        let mut across = vec![[NONE; 4]; tets.len()];
        for v in 0..n_points as u32 {
            let around = faces.of_mut(v);
            around.sort_unstable();
            for pair in around.windows(2) {
                if pair[0].0 == pair[1].0 {
                    for (face, other) in [(pair[0].1, pair[1].1), (pair[1].1, pair[0].1)] {
                        let (t, i) = split(face);
                        across[t][i] = other;
                    }
                }
            }
        }
        LinkedTets { tets, across }
    }

    /// Keeps the tets for which `is_kept` holds, in their order.
    ///
    /// Faces towards the others have no neighbour any more.
    pub fn retain(&mut self, is_kept: impl Fn(&[u32; 4]) -> bool) {
        let mut kept = 0;
        let numbers: Vec<u32> = (self.tets.iter())
            .map(|tet| match is_kept(tet) {
                true => {
                    kept += 1;
                    kept - 1
                }
                false => NONE,
            })
            .collect();
        for t in (0..numbers.len()).filter(|&t| numbers[t] != NONE) {
            let number = numbers[t] as usize;
            self.tets[number] = self.tets[t];
            self.across[number] = self.across[t].map(|face| match face {
                NONE => NONE,
                face => match numbers[split(face).0] {
                    NONE => NONE,
                    other => face_number(other as usize, split(face).1),
                },
            });
        }
        self.tets.truncate(kept as usize);
        self.across.truncate(kept as usize);
    }

    /// The tets without their neighbours.
    pub fn into_tets(self) -> Vec<[u32; 4]> {
        self.tets
    }

    /// The tets.
    pub fn tets(&self) -> &[[u32; 4]] {
        &self.tets
    }

    /// The neighbours of a tet across the faces opposite its vertices.
    pub fn neighbours(&self, tet: usize) -> [Option<usize>; 4] {
        self.across[tet].map(|face| (face != NONE).then(|| split(face).0))
    }

    /// The face of a tet opposite its vertex `i`, with the normal out of the tet.
    pub fn outward_face(&self, tet: usize, i: usize) -> [u32; 3] {
        let [a, b, c] = FACE[i].map(|k| self.tets[tet][k]);
        [a, c, b]
    }

    /// Faces without a neighbour, with the normal out of the tet, sorted by their vertices.
    pub fn boundary_faces(&self) -> Vec<[u32; 3]> {
        let mut faces: Vec<([u32; 3], [u32; 3])> = Vec::new();
        for (tet, across) in self.tets.iter().zip(&self.across) {
            for i in (0..4).filter(|&i| across[i] == NONE) {
                let [a, b, c] = FACE[i].map(|k| tet[k]);
                let mut key = [a, b, c];
                key.sort_unstable();
                faces.push((key, [a, c, b]));
            }
        }
        faces.sort_unstable();
        faces.into_iter().map(|(_, face)| face).collect()
    }
}

/// Position of a vertex, which must be one of the tet.
#[inline]
pub(super) fn position(tet: &[u32; 4], vertex: u32) -> usize {
    (0..3).find(|&k| tet[k] == vertex).unwrap_or(3)
}

/// Sum of the volumes of some tets.
#[cfg(test)]
pub(super) fn volume(tets: &[[u32; 4]], points: &[Vec3]) -> f64 {
    let of_tet = |tet: &[u32; 4]| {
        let [a, b, c, d] = tet.map(|v| points[v as usize]);
        (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
    };
    tets.iter().map(of_tet).sum()
}
