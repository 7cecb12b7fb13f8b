//! Flips that make tets Delaunay again after their vertices have moved (Lawson 1977; Joe 1991).
//!
//! A face whose neighbours' circumballs contain the vertices beyond is replaced by an edge (two
//! tets become three), or an edge with three tets around it by a face. On a symmetry plane two tets
//! exchange the diagonal of their two faces. Every flip lowers the interpolant of `|x|^2`, so the
//! flips end. In three dimensions they may end before all tets are Delaunay.

use super::linked_tets::{FACE, LinkedTets, NONE, face_number, position, split};
use super::predicates::{circumcentre, in_sphere, orientation};
use mesh::Vec3;
use rayon::prelude::*;

/// Tets per parallel task; fixed, so that the work is divided equally for any number of threads.
const CHUNK: usize = 2048;

/// Largest number of checks of faces per tet.
///
/// After a smoothing sweep there is less than one (measured).
const MOST_CHECKS: usize = 100;

/// Rules for flips, beyond those of geometry. A function of the new tets is a rule by itself.
pub(crate) trait FlipRules {
    /// Whether a flip may create this tet.
    fn allows(&self, tet: &[u32; 4]) -> bool;

    /// Whether two boundary faces in one plane, with these vertices, may exchange their diagonal.
    fn exchanges_diagonal(&self, _quadrilateral: &[u32; 4]) -> bool {
        true
    }
}

impl<F: Fn(&[u32; 4]) -> bool> FlipRules for F {
    fn allows(&self, tet: &[u32; 4]) -> bool {
        self(tet)
    }
}

/// The two tets at a face and what a flip needs to know about them.
struct Bipyramid {
    /// The tets on both sides.
    tets: [usize; 2],
    /// Vertices of the face, such that `(face, apex 0)` is positively oriented.
    face: [u32; 3],
    /// The vertices beyond.
    apexes: [u32; 2],
    /// For each vertex of the face, the outer faces opposite it: in the neighbours of both tets.
    beyond: [[u32; 2]; 3],
}

impl LinkedTets {
    /// Flips faces that are not locally Delaunay, as far as the `rules` allow it.
    ///
    /// The boundary is kept, except for diagonals in planes. All tets must be positively oriented,
    /// and stay so. Serial after a parallel search, with the same result for any number of threads.
    pub fn flip_to_delaunay(&mut self, points: &[Vec3], rules: &impl FlipRules) {
        let mut faces: Vec<u32> = (0..self.tets.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .flat_map_iter(|t| self.suspects(t, points))
            .collect();
        // Flips end by themselves, except where numbers underflow or overflow.
        let mut left = MOST_CHECKS * (self.tets.len() + 1);
        while let Some(face) = faces.pop().filter(|_| left > 0) {
            left -= 1;
            // A flip may have removed the last tets.
            if split(face).0 < self.tets.len() && !self.is_delaunay(face, points) {
                self.flip(face, points, rules, &mut faces);
            }
        }
    }

    /// Pairs of neighbours whose common face is not locally Delaunay.
    pub fn pairs_not_delaunay(&self, points: &[Vec3]) -> Vec<[usize; 2]> {
        (0..self.tets.len())
            .into_par_iter()
            .with_min_len(CHUNK)
            .flat_map_iter(|t| self.suspects(t, points))
            .filter(|&face| !self.is_delaunay(face, points))
            .map(|face| [face, self.across[split(face).0][split(face).1]].map(|f| split(f).0))
            .collect()
    }

    /// Faces of a tet that are probably not locally Delaunay.
    ///
    /// Each face is tested from one side only, by the distance of the vertex beyond from the
    /// circumcentre, which is faster than the exact predicate.
    fn suspects(&self, t: usize, points: &[Vec3]) -> impl Iterator<Item = u32> {
        let x = self.tets[t].map(|v| points[v as usize]);
        let (centre, _) = circumcentre(x);
        let squared_radius = (centre - x[0]).norm_squared();
        let across = self.across[t];
        let inside = [0, 1, 2, 3].map(|i| {
            let other = across[i];
            if other == NONE || other < face_number(t, i) {
                return false;
            }
            let (u, j) = split(other);
            let beyond = points[self.tets[u][j] as usize];
            // Written so that faces of flat tets, with NaN, are suspect.
            let is_outside = (beyond - centre).norm_squared() >= squared_radius;
            !is_outside
        });
        (0..4)
            .filter(move |&i| inside[i])
            .map(move |i| face_number(t, i))
    }

    /// Whether the open circumball of the tet of a face does not contain the vertex beyond.
    fn is_delaunay(&self, face: u32, points: &[Vec3]) -> bool {
        let (t, i) = split(face);
        let other = self.across[t][i];
        if other == NONE {
            return true;
        }
        let (u, j) = split(other);
        let [a, b, c, d] = self.tets[t].map(|v| &points[v as usize]);
        in_sphere(a, b, c, d, &points[self.tets[u][j] as usize]) <= 0.0
    }

    fn bipyramid(&self, face: u32) -> Bipyramid {
        let (t, i) = split(face);
        let (u, j) = split(self.across[t][i]);
        let corners = FACE[i].map(|k| self.tets[t][k]);
        let beyond = [0, 1, 2].map(|k| {
            let in_other = position(&self.tets[u], corners[k]);
            [self.across[t][FACE[i][k]], self.across[u][in_other]]
        });
        Bipyramid {
            tets: [t, u],
            face: corners,
            apexes: [self.tets[t][i], self.tets[u][j]],
            beyond,
        }
    }

    /// Flips a face or one of its edges, if a flip is possible; adds faces to be checked.
    fn flip(&mut self, face: u32, points: &[Vec3], rules: &impl FlipRules, changed: &mut Vec<u32>) {
        let mut pyramid = self.bipyramid(face);
        let Bipyramid { face, apexes, .. } = pyramid;
        // The tets around the edge between the apexes, each with one edge of the face.
        let around = [0, 1, 2].map(|k| [face[k], face[(k + 1) % 3], apexes[1], apexes[0]]);
        let sides = around.map(|tet| {
            let [a, b, c, d] = tet.map(|v| &points[v as usize]);
            orientation(a, b, c, d)
        });
        let mut outside = (0..3).filter(|&k| sides[k] <= 0.0);
        match (outside.next(), outside.next()) {
            (None, _) if around.iter().all(|tet| rules.allows(tet)) => {
                self.replace_face(&pyramid, changed)
            }
            (Some(k), None) => {
                // Rotated such that the edge to be replaced comes first.
                pyramid.face.rotate_left(k);
                pyramid.beyond.rotate_left(k);
                let new = [around[(k + 1) % 3], around[(k + 2) % 3]];
                let [p, q, _] = pyramid.face;
                let may_exchange =
                    sides[k] == 0.0 && rules.exchanges_diagonal(&[p, q, apexes[0], apexes[1]]);
                if new.iter().all(|tet| rules.allows(tet)) {
                    self.replace_edge(&pyramid, new, may_exchange, changed);
                }
            }
            _ => {}
        }
    }

    /// Replaces a face by the edge between its apexes: two tets become three.
    fn replace_face(&mut self, pyramid: &Bipyramid, changed: &mut Vec<u32>) {
        let [p, q, r] = pyramid.face;
        let [a, e] = pyramid.apexes;
        let slots = [pyramid.tets[0], pyramid.tets[1], self.tets.len()];
        self.tets.push([NONE; 4]);
        self.across.push([NONE; 4]);
        for (k, (tet, opposite)) in [([p, q], 2), ([q, r], 0), ([r, p], 1)].iter().enumerate() {
            let t = slots[k];
            self.tets[t] = [tet[0], tet[1], e, a];
            self.across[t][0] = face_number(slots[(k + 1) % 3], 1);
            self.across[t][1] = face_number(slots[(k + 2) % 3], 0);
            for side in 0..2 {
                self.link(t, 2 + side, pyramid.beyond[*opposite][side]);
                changed.push(face_number(t, 2 + side));
            }
        }
    }

    /// Replaces the edge of the first two vertices of the face, if three tets are around it, by the
    /// face with the apexes: three tets become two.
    ///
    /// On the boundary, if it `may_exchange` diagonals, the edge with two tets is replaced by the
    /// other diagonal of a plane quadrilateral.
    fn replace_edge(
        &mut self,
        pyramid: &Bipyramid,
        new: [[u32; 4]; 2],
        may_exchange: bool,
        changed: &mut Vec<u32>,
    ) {
        let [p, q, _] = pyramid.face;
        let [across_0, across_1] = pyramid.beyond[2];
        let (third, ends) = if across_0 == NONE || across_1 == NONE {
            if across_0 != across_1 || !may_exchange {
                return;
            }
            (None, [NONE; 2])
        } else {
            let third = split(across_0).0;
            if third != split(across_1).0 {
                return;
            }
            let ends = [p, q].map(|v| self.across[third][position(&self.tets[third], v)]);
            (Some(third), ends)
        };
        let [t, u] = pyramid.tets;
        (self.tets[t], self.tets[u]) = (new[0], new[1]);
        self.across[t][0] = face_number(u, 1);
        self.across[u][1] = face_number(t, 0);
        self.link(t, 1, ends[0]);
        self.link(u, 0, ends[1]);
        for side in 0..2 {
            self.link(t, 2 + side, pyramid.beyond[0][side]);
            self.link(u, 2 + side, pyramid.beyond[1][side]);
        }
        changed.extend([1, 2, 3].map(|i| face_number(t, i)));
        changed.extend([0, 2, 3].map(|i| face_number(u, i)));
        if let Some(third) = third {
            self.remove(third, changed);
        }
    }

    /// Removes a tet without neighbours; the last tet takes its place and is checked again.
    fn remove(&mut self, t: usize, changed: &mut Vec<u32>) {
        self.tets.swap_remove(t);
        self.across.swap_remove(t);
        if t < self.tets.len() {
            for i in 0..4 {
                self.link(t, i, self.across[t][i]);
                changed.push(face_number(t, i));
            }
        }
    }

    /// Makes two faces one.
    #[inline]
    fn link(&mut self, t: usize, i: usize, other: u32) {
        self.across[t][i] = other;
        if other != NONE {
            let (u, j) = split(other);
            self.across[u][j] = face_number(t, i);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::delaunay::delaunay;
    use crate::delaunay::linked_tets::volume;

    /// Points of a cubic lattice in the cube `[0, n - 1]^3`, with the inner ones displaced by up to
    /// `amplitude` times a fixed sequence that depends on `phase`.
    fn lattice(n: u32, amplitude: f64, phase: f64) -> Vec<Vec3> {
        let grid = (0..n * n * n).map(|k| [k % n, k / n % n, k / n / n]);
        let points = grid.enumerate().map(|(k, at)| {
            let inner = at.iter().all(|&c| c > 0 && c < n - 1);
            let t = k as f64 + phase;
            let shift = Vec3::new((12.9 * t).sin(), (78.2 * t).sin(), (37.7 * t).sin());
            let scale = if inner { amplitude } else { 0.0 };
            Vec3::from(at.map(f64::from)) + scale * shift
        });
        points.collect()
    }

    fn faces(linked: &LinkedTets) -> impl Iterator<Item = u32> {
        (0..linked.tets.len()).flat_map(|t| (0..4).map(move |i| face_number(t, i)))
    }

    fn assert_linked(linked: &LinkedTets) {
        for face in faces(linked) {
            let (t, i) = split(face);
            let across = linked.across[t][i];
            if across == NONE {
                continue;
            }
            let (u, j) = split(across);
            assert_eq!(linked.across[u][j], face);
            let corners = |t: usize, i: usize| {
                let mut corners = FACE[i].map(|k| linked.tets[t][k]);
                corners.sort_unstable();
                corners
            };
            assert_eq!(corners(t, i), corners(u, j));
        }
    }

    #[test]
    fn moved_vertices_have_delaunay_tets_again() {
        let before = lattice(9, 0.3, 0.0);
        let tets = delaunay(&before, 0..0).unwrap();
        let mut linked = LinkedTets::new(before.len(), tets);
        let boundary = sorted_corners(linked.boundary_faces());
        // A twentieth of the way to other positions leaves no tet inverted.
        let other = lattice(9, 0.3, 1000.0);
        let mut moved = before.clone();
        for (p, q) in moved.iter_mut().zip(&other) {
            *p += 0.05 * (q - *p);
        }
        let is_positive = |tet: &[u32; 4]| {
            let [a, b, c, d] = tet.map(|v| &moved[v as usize]);
            orientation(a, b, c, d) > 0.0
        };
        linked.tets.iter().for_each(|t| assert!(is_positive(t)));
        let bad = |linked: &LinkedTets| {
            let faces = faces(linked);
            faces.filter(|&f| !linked.is_delaunay(f, &moved)).count()
        };
        let first = bad(&linked);
        assert!(first > 100, "{first} faces");
        linked.flip_to_delaunay(&moved, &|_: &[u32; 4]| true);
        assert_eq!(bad(&linked), 0);
        assert_linked(&linked);
        linked.tets.iter().for_each(|t| assert!(is_positive(t)));
        assert!(sorted_corners(linked.boundary_faces()) == boundary);
        // The cube has the side 8; each term rounds by less than a unit of the sum.
        let rounding = linked.tets.len() as f64 * f64::EPSILON * 512.0;
        assert!((volume(&linked.tets, &moved) - 512.0).abs() < rounding);
        // With all faces locally Delaunay, the tets are those of a new tetrahedralisation.
        let mut own: Vec<[u32; 4]> = linked.tets.clone();
        let mut new = delaunay(&moved, 0..0).unwrap();
        let inner = |tet: &[u32; 4]| tet.iter().any(|&v| moved[v as usize] != lattice_point(v));
        for list in [&mut own, &mut new] {
            list.retain(inner);
            list.iter_mut().for_each(|tet| tet.sort_unstable());
            list.sort_unstable();
        }
        assert!(own == new);
    }

    /// The faces with their vertices in ascending order.
    fn sorted_corners(mut faces: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
        faces.iter_mut().for_each(|face| face.sort_unstable());
        faces
    }

    /// Vertex of the undisplaced lattice.
    fn lattice_point(v: u32) -> Vec3 {
        Vec3::new(f64::from(v % 9), f64::from(v / 9 % 9), f64::from(v / 81))
    }

    #[test]
    fn diagonals_in_a_plane_are_exchanged() {
        // A quadrilateral in the plane z = 0, divided along its longer diagonal, and an apex.
        let points = [
            Vec3::new(-2.0, 0.0, 0.0),
            Vec3::new(0.0, -1.0, 0.0),
            Vec3::new(2.0, 0.0, 0.0),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(0.0, 0.0, 1.0),
        ];
        let tets = vec![[0, 1, 2, 4], [0, 2, 3, 4]];
        let mut linked = LinkedTets::new(5, tets.clone());
        linked.flip_to_delaunay(&points, &|tet: &[u32; 4]| !tet.contains(&3));
        assert_eq!(linked.tets, tets);
        linked.flip_to_delaunay(&points, &|_: &[u32; 4]| true);
        assert_eq!(linked.tets.len(), 2);
        assert!(linked.tets.iter().all(|t| t.contains(&1) && t.contains(&3)));
        assert_linked(&linked);
        assert!((volume(&linked.tets, &points) - 4.0 / 3.0).abs() < 1e-15);
        // The same quadrilateral bent along its diagonal keeps it.
        let mut bent = points;
        bent[1].z = -0.1;
        bent[3].z = -0.1;
        let mut linked = LinkedTets::new(5, tets.clone());
        linked.flip_to_delaunay(&bent, &|_: &[u32; 4]| true);
        assert_eq!(linked.tets, tets);
    }
}
