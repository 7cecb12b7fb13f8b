//! Delaunay tetrahedralisation of a point set, with exact predicates.
//!
//! Incremental construction by cavities (Bowyer 1981, Watson 1981).
//!
//! Tets are stored with their four neighbours, as in [`LinkedTets`]. Ghost tets, which share one
//! vertex at infinity, close the hull. Cospherical points need no perturbation: with exact signs,
//! and points on a sphere counted as outside, every cavity is star-shaped with respect to the new
//! point (see [`Builder::find_cavity`]).

mod carve;
mod hilbert;
mod linked_tets;
mod predicates;
mod tet_flips;

pub(crate) use carve::carve;
pub(crate) use hilbert::insertion_order;
pub(crate) use linked_tets::LinkedTets;
pub(crate) use predicates::{circumcentre, orientation};
pub(crate) use tet_flips::FlipRules;

use crate::GenerateError;
use linked_tets::{FACE, NONE, face_number, position, split};
use mesh::{MeshError, Vec3};
use predicates::in_sphere;
use std::ops::Range;

/// The vertex at infinity.
const GHOST: u32 = u32::MAX;
/// Position of the vertex at infinity in a ghost tet.
const GHOST_SLOT: usize = 3;
/// Flag in the list of neighbours of a cavity tet: the face is on the boundary of the cavity.
///
/// The other bits are the number of the same face in the new tet behind it.
const NEW: u32 = 1 << 31;

/// Delaunay tets of `points`, positively oriented.
///
/// The points `first` are inserted first. A point near the centre of others that lie on a sphere
/// saves most of their exact predicates: no tet has four of its vertices among them then.
///
/// Distances below `2^-160` of the largest coordinate count as zero (see [`scaled`]).
///
/// The open circumball of every tet contains no point. Among cospherical points there are several
/// valid choices; the insertion order determines one, the same on every machine. Cost: O(n log n)
/// for the points of a graded mesh, some microseconds per point.
///
/// # Errors
/// [`MeshError::NotFinite`], [`MeshError::DuplicateVertices`], and [`GenerateError::FlatPoints`] if
/// all points lie in one plane.
pub(crate) fn delaunay(points: &[Vec3], first: Range<u32>) -> Result<Vec<[u32; 4]>, GenerateError> {
    Ok(linked_delaunay(points, first)?.into_tets())
}

/// The same with the neighbours of the tets.
///
/// # Errors
/// Those of [`delaunay`].
pub(crate) fn linked_delaunay(
    points: &[Vec3],
    first: Range<u32>,
) -> Result<LinkedTets, GenerateError> {
    if let Some(i) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(MeshError::NotFinite { point: i }.into());
    }
    let scaled = scaled(points);
    let mut order = insertion_order(&scaled);
    order.sort_by_key(|p| !first.contains(p));
    let start = first_tet(&scaled, &order).ok_or(GenerateError::FlatPoints {
        points: points.len(),
    })?;
    let mut builder = Builder::new(&scaled, start);
    for &p in &order {
        if start.contains(&p) {
            continue;
        }
        builder.insert(p).map_err(|first| {
            let (first, second) = (first as usize, p as usize);
            let at = points[second].into();
            MeshError::DuplicateVertices { first, second, at }
        })?;
    }
    Ok(builder.finish())
}

/// Smallest coordinate relative to the largest that is not taken for zero, `2^-160`.
///
/// The exact predicates are sums of products of five coordinates. Coordinates below one with 53
/// digits, the last at least `2^-212`, have products whose last digit, `2^-1060`, is representable.
const SMALLEST_COORDINATE: f64 = 6.842277657836021e-49;

/// The points divided by a power of two, so that the predicates neither overflow nor underflow:
/// otherwise their signs contradict each other, and a walk does not end.
fn scaled(points: &[Vec3]) -> Vec<Vec3> {
    let largest = points
        .iter()
        .map(Vec3::amax)
        .fold(f64::MIN_POSITIVE, f64::max);
    // Two factors, since the inverse of the largest or smallest number may not be representable.
    let half = (-0.5 * largest.log2()).floor().exp2();
    points
        .iter()
        .map(|point| {
            (point * half * half).map(|x| {
                if x.abs() < SMALLEST_COORDINATE {
                    0.0
                } else {
                    x
                }
            })
        })
        .collect()
}

/// Four points that do not lie in one plane, positively oriented, early in the order.
fn first_tet(points: &[Vec3], order: &[u32]) -> Option<[u32; 4]> {
    let at = |i: u32| &points[i as usize];
    let (&a, rest) = order.split_first()?;
    let b = *rest.iter().find(|&&i| at(i) != at(a))?;
    // Three points are collinear if all projections of their triangle have no area.
    let collinear = |c: u32| {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        axes.iter()
            .all(|axis| orientation(at(a), at(b), at(c), &(at(a) + axis)) == 0.0)
    };
    let c = *rest.iter().find(|&&i| !collinear(i))?;
    let d = *rest
        .iter()
        .find(|&&i| orientation(at(a), at(b), at(c), at(i)) != 0.0)?;
    if orientation(at(a), at(b), at(c), at(d)) > 0.0 {
        Some([a, b, c, d])
    } else {
        Some([a, c, b, d])
    }
}

/// A Delaunay triangulation under construction.
struct Builder<'a> {
    points: &'a [Vec3],
    /// All tets with their neighbours, and unused slots.
    linked: LinkedTets,
    /// State of each tet in the current insertion.
    ///
    /// `2 stamp + 1` for tets in the cavity, `2 stamp` for tested tets outside it, smaller values
    /// for all other tets.
    marks: Vec<u32>,
    /// Number of the current insertion.
    stamp: u32,
    /// Unused slots of the arrays.
    free: Vec<u32>,
    /// A tet of the last insertion, where the next walk starts.
    last: u32,
    cavity: Vec<u32>,
    /// Boundary faces of the cavity, by their numbers in the cavity tets.
    boundary: Vec<u32>,
}

impl<'a> Builder<'a> {
    fn new(points: &'a [Vec3], start: [u32; 4]) -> Self {
        // The ghosts are the neighbours across the faces of the start tet.
        let ghosts = FACE.map(|face| {
            let [a, b, c] = face.map(|k| start[k]);
            [a, c, b, GHOST]
        });
        let tets: Vec<[u32; 4]> = [start].into_iter().chain(ghosts).collect();
        // The neighbour across the face opposite a vertex is opposite the same vertex in it.
        let across = (tets.iter().enumerate())
            .map(|(t, tet)| {
                [0, 1, 2, 3].map(|i| match (t, tet[i]) {
                    (0, _) => face_number(i + 1, GHOST_SLOT),
                    (_, GHOST) => face_number(0, t - 1),
                    (_, v) => {
                        let other = position(&start, v) + 1;
                        face_number(other, position(&tets[other], start[t - 1]))
                    }
                })
            })
            .collect();
        Builder {
            points,
            linked: LinkedTets { tets, across },
            marks: vec![0; 5],
            stamp: 0,
            free: Vec::new(),
            last: 0,
            cavity: Vec::new(),
            boundary: Vec::new(),
        }
    }

    /// Inserts point `p`.
    ///
    /// # Errors
    /// The vertex at the same place.
    fn insert(&mut self, p: u32) -> Result<(), u32> {
        let start = self.locate(p);
        let at = self.points[p as usize];
        for &v in &self.linked.tets[start as usize] {
            if v != GHOST && self.points[v as usize] == at {
                return Err(v);
            }
        }
        self.find_cavity(start, &at);
        self.fill_cavity(p);
        Ok(())
    }

    /// Walks from the last new tet to one that contains point `p`, or to a ghost whose hull face is
    /// visible from `p`.
    ///
    /// Each step crosses a face that separates the tet from `p`. In a Delaunay triangulation such a
    /// walk cannot cycle (Edelsbrunner 1990).
    fn locate(&self, p: u32) -> u32 {
        let at = &self.points[p as usize];
        let LinkedTets { tets, across } = &self.linked;
        let mut here = self.last as usize;
        if tets[here][GHOST_SLOT] == GHOST {
            here = split(across[here][GHOST_SLOT]).0;
        }
        let mut from = NONE;
        'walk: loop {
            let tet = &tets[here];
            if tet[GHOST_SLOT] == GHOST {
                return here as u32;
            }
            for i in 0..4 {
                if face_number(here, i) != from && self.side(tet, i, at) < 0.0 {
                    from = across[here][i];
                    here = split(from).0;
                    continue 'walk;
                }
            }
            return here as u32;
        }
    }

    /// Orientation of `tet` with its vertex `i` moved to `at`: positive on the side of the vertex.
    #[inline]
    fn side(&self, tet: &[u32; 4], i: usize, at: &Vec3) -> f64 {
        let [a, b, c] = FACE[i].map(|k| &self.points[tet[k] as usize]);
        orientation(a, b, c, at)
    }

    /// Whether the open circumball of tet `t` contains `at`.
    ///
    /// The ball of a ghost is the open half-space beyond its hull face, together with the open
    /// circumdisc of that face. The balls of two neighbours intersect the plane of their common
    /// face in the same disc, so the new point never lies in the plane of a boundary face of the
    /// cavity.
    #[inline]
    fn conflicts(&self, t: usize, at: &Vec3) -> bool {
        let tet = &self.linked.tets[t];
        if tet[GHOST_SLOT] == GHOST {
            let side = self.side(tet, GHOST_SLOT, at);
            let behind = || split(self.linked.across[t][GHOST_SLOT]).0;
            return side > 0.0 || side == 0.0 && self.conflicts(behind(), at);
        }
        let [a, b, c, d] = tet.map(|v| &self.points[v as usize]);
        in_sphere(a, b, c, d, at) > 0.0
    }

    /// Collects the tets whose open circumball contains `at`, and the boundary faces of this
    /// cavity.
    fn find_cavity(&mut self, start: u32, at: &Vec3) {
        self.stamp += 1;
        let (outside, inside) = (2 * self.stamp, 2 * self.stamp + 1);
        self.cavity.clear();
        self.boundary.clear();
        self.cavity.push(start);
        self.marks[start as usize] = inside;
        let mut next = 0;
        while next < self.cavity.len() {
            let t = self.cavity[next] as usize;
            next += 1;
            let across = self.linked.across[t];
            for (i, face) in across.into_iter().enumerate() {
                let n = split(face).0;
                let mut mark = self.marks[n];
                if mark < outside {
                    mark = outside + u32::from(self.conflicts(n, at));
                    self.marks[n] = mark;
                    if mark == inside {
                        self.cavity.push(n as u32);
                    }
                }
                if mark == outside {
                    self.boundary.push(face_number(t, i));
                }
            }
        }
    }

    /// Fills the cavity with the tets that join its boundary faces to `p`.
    fn fill_cavity(&mut self, p: u32) {
        let LinkedTets { tets, across } = &mut self.linked;
        for &face in &self.boundary {
            let (t, i) = split(face);
            let slot = self.free.pop().map_or(tets.len(), |slot| slot as usize);
            if slot == tets.len() {
                tets.push([NONE; 4]);
                across.push([NONE; 4]);
                self.marks.push(0);
            }
            let beyond = across[t][i];
            let (u, j) = split(beyond);
            tets[slot] = tets[t];
            tets[slot][i] = p;
            across[slot] = [NONE; 4];
            across[slot][i] = beyond;
            across[u][j] = face_number(slot, i);
            self.marks[slot] = 0;
            across[t][i] = NEW | face_number(slot, i);
        }
        for &face in &self.boundary {
            let (t, i) = split(face);
            let new = split(across[t][i] & !NEW).0;
            for j in 0..4 {
                if across[new][j] == NONE {
                    let other = new_neighbour(tets, across, [t, i, j]);
                    let (u, k) = split(other);
                    across[new][j] = other;
                    across[u][k] = face_number(new, j);
                }
            }
            self.last = new as u32;
        }
        self.free.append(&mut self.cavity);
    }

    /// The tets without ghosts and unused slots.
    fn finish(mut self) -> LinkedTets {
        for &slot in &self.free {
            self.linked.tets[slot as usize] = [GHOST; 4];
        }
        self.linked.retain(|tet| tet[GHOST_SLOT] != GHOST);
        self.linked
    }
}

/// Face of a new tet that is also a face of the new tet on boundary face `i` of cavity tet `t`,
/// where it is opposite vertex `j`.
///
/// Rotates through the cavity about the edge common to the faces `i` and `j` of `t`, until the next
/// boundary face.
fn new_neighbour(tets: &[[u32; 4]], across: &[[u32; 4]], [t, i, j]: [usize; 3]) -> u32 {
    let (mut t, mut i, mut j) = (t, i, j);
    loop {
        let next = across[t][j];
        if next & NEW != 0 {
            // The new tet has the vertices of `t`, except `j`.
            return face_number(split(next & !NEW).0, i);
        }
        // Cross face j. Vertex i of `t` is also a vertex of the next tet; the next face is opposite
        // to it.
        let (neighbour, back) = split(next);
        j = position(&tets[neighbour], tets[t][i]);
        (t, i) = (neighbour, back);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks orientation, empty circumballs (against every point), and the volume of the hull.
    fn check(points: &[Vec3], volume: f64) {
        let tets = delaunay(points, 0..0).expect("points span a volume");
        let mut sum = 0.0;
        for tet in &tets {
            let [a, b, c, d] = tet.map(|v| &points[v as usize]);
            assert!(orientation(a, b, c, d) > 0.0);
            sum += (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0;
            assert!(points.iter().all(|e| in_sphere(a, b, c, d, e) <= 0.0));
        }
        // Each addition rounds by at most one unit in the last place of the total.
        let rounding = tets.len() as f64 * f64::EPSILON * volume;
        assert!((sum - volume).abs() <= rounding, "{sum} {volume}");
    }

    #[test]
    fn cospherical_points_of_a_lattice_fill_its_cube() {
        let mut points = Vec::new();
        for i in 0..6 {
            for j in 0..6 {
                for k in 0..6 {
                    points.push(Vec3::new(f64::from(i), f64::from(j), f64::from(k)));
                }
            }
        }
        check(&points, 125.0);
    }

    #[test]
    fn neighbours_of_the_construction_are_those_of_the_faces() {
        let points: Vec<Vec3> = (1..301)
            .map(|k| {
                let t = f64::from(k);
                Vec3::new((12.9 * t).sin(), (78.2 * t).sin(), (37.7 * t).sin())
            })
            .collect();
        let mut linked = linked_delaunay(&points, 0..0).unwrap();
        for _ in 0..2 {
            let by_faces = LinkedTets::new(points.len(), linked.tets.clone());
            assert_eq!(linked.across, by_faces.across);
            let before = linked.tets.len();
            linked.retain(|tet| tet.iter().any(|v| v % 7 < 2));
            assert!(linked.tets.len() > before / 2);
        }
    }

    #[test]
    fn octahedron_with_and_without_its_centre() {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let mut points: Vec<Vec3> = axes.iter().flat_map(|&a| [a, -a]).collect();
        check(&points, 4.0 / 3.0);
        points.push(Vec3::zeros());
        check(&points, 4.0 / 3.0);
    }

    /// The tets do not depend on the order of insertion if no five points lie on a sphere. A centre
    /// that is inserted first replaces the tets between points on its sphere.
    #[test]
    fn points_inserted_first_change_the_order_only() {
        let mut points: Vec<Vec3> = (1..201)
            .map(|k| {
                let t = f64::from(k);
                Vec3::new((12.9 * t).sin(), (78.2 * t).sin(), (37.7 * t).sin())
            })
            .collect();
        let sorted = |first| {
            let mut tets = delaunay(&points, first).unwrap();
            tets.iter_mut().for_each(|tet| tet.sort_unstable());
            tets.sort_unstable();
            tets
        };
        assert_eq!(sorted(0..0), sorted(150..170));
        points.iter_mut().for_each(|p| *p = p.normalize());
        points.push(Vec3::zeros());
        let tets = delaunay(&points, 200..201).unwrap();
        assert!(tets.iter().all(|tet| tet.contains(&200)));
    }

    /// The predicates once overflowed for a sphere in a box of side 1e150, and the walk to the next
    /// point did not end.
    #[test]
    fn points_at_extreme_distances_are_merged_and_all_scales_give_the_same_tets() {
        let mut points: Vec<Vec3> = (1..50)
            .map(|k| {
                let t = f64::from(k);
                Vec3::new((12.9 * t).sin(), (78.2 * t).sin(), (37.7 * t).sin())
            })
            .collect();
        let tets = delaunay(&points, 0..0).unwrap();
        for scale in [2.0_f64.powi(-900), 2.0_f64.powi(900)] {
            let points: Vec<Vec3> = points.iter().map(|p| p * scale).collect();
            assert_eq!(delaunay(&points, 0..0).unwrap(), tets);
        }
        points.push(Vec3::new(1e150, -2e149, 3e149));
        assert!(matches!(
            delaunay(&points, 0..0),
            Err(GenerateError::Mesh(MeshError::DuplicateVertices { .. })
                | GenerateError::FlatPoints { .. })
        ));
    }

    #[test]
    fn flat_duplicate_and_nan_points_are_errors() {
        let plane: Vec<Vec3> = (0..20)
            .map(|i| Vec3::new(f64::from(i % 5), f64::from(i / 5), 1.0))
            .collect();
        assert!(matches!(
            delaunay(&plane, 0..0),
            Err(GenerateError::FlatPoints { points: 20 })
        ));
        assert!(matches!(
            delaunay(&[], 0..0),
            Err(GenerateError::FlatPoints { points: 0 })
        ));
        let mut solid = plane.clone();
        solid.push(Vec3::zeros());
        assert!(delaunay(&solid, 0..0).is_ok());
        solid.push(solid[7]);
        assert!(matches!(
            delaunay(&solid, 0..0),
            Err(GenerateError::Mesh(MeshError::DuplicateVertices { .. }))
        ));
        solid[3].x = f64::NAN;
        assert!(matches!(
            delaunay(&solid, 0..0),
            Err(GenerateError::Mesh(MeshError::NotFinite { point: 3 }))
        ));
    }
}
