//! Incremental construction by cavities (Bowyer 1981, Watson 1981).
//!
//! Tets are stored in flat arrays with their four neighbours. Ghost tets, which share one vertex at
//! infinity, close the hull. Cospherical points need no perturbation: with exact signs, and points
//! on a sphere counted as outside, every cavity is star-shaped with respect to the new point (see
//! [`Builder::find_cavity`]).

use super::hilbert::insertion_order;
use super::linked_tets::FACE;
use super::predicates::{in_sphere, orientation};
use crate::{MeshError, Vec3};

/// The vertex at infinity.
const GHOST: u32 = u32::MAX;
/// Flag in the neighbour array of a cavity tet: the face is on the boundary of the cavity.
///
/// The other bits are the index of the new tet behind the face.
const NEW: u32 = 1 << 31;

/// Delaunay tets of `points`, positively oriented.
///
/// The open circumball of every tet contains no point. Among cospherical points there are several
/// valid choices; the insertion order determines one, the same on every machine. Cost: O(n log n)
/// for the points of a graded mesh, some microseconds per point.
///
/// # Errors
/// [`MeshError::NotFinite`], [`MeshError::DuplicateVertices`], and [`MeshError::FlatPoints`] if all
/// points lie in one plane.
pub(crate) fn delaunay(points: &[Vec3]) -> Result<Vec<[u32; 4]>, MeshError> {
    if let Some(i) = points.iter().position(|p| !p.iter().all(|c| c.is_finite())) {
        return Err(MeshError::NotFinite { point: i });
    }
    let order = insertion_order(points);
    let start = first_tet(points, &order).ok_or(MeshError::FlatPoints {
        points: points.len(),
    })?;
    let mut builder = Builder::new(points, start);
    for &p in &order {
        if !start.contains(&p) {
            builder.insert(p)?;
        }
    }
    Ok(builder.finish())
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
    tets: Vec<[u32; 4]>,
    /// Neighbour across the face opposite each vertex.
    neighbours: Vec<[u32; 4]>,
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
    /// Boundary faces of the cavity: a cavity tet and one of its local faces.
    boundary: Vec<(u32, u32)>,
}

impl<'a> Builder<'a> {
    fn new(points: &'a [Vec3], start: [u32; 4]) -> Self {
        // Tet 0 is the start; ghost 1 + i is the neighbour across its face i.
        let mut tets = vec![start];
        let mut neighbours = vec![[1, 2, 3, 4]];
        for face in &FACE {
            let [a, b, c] = face.map(|k| start[k]);
            tets.push([a, c, b, GHOST]);
            // The neighbours across the faces opposite a, c, b are the ghosts across the faces of
            // the start tet opposite the same vertices.
            neighbours.push([
                1 + face[0] as u32,
                1 + face[2] as u32,
                1 + face[1] as u32,
                0,
            ]);
        }
        Builder {
            points,
            tets,
            neighbours,
            marks: vec![0; 5],
            stamp: 0,
            free: Vec::new(),
            last: 0,
            cavity: Vec::new(),
            boundary: Vec::new(),
        }
    }

    /// Inserts point `p`.
    fn insert(&mut self, p: u32) -> Result<(), MeshError> {
        let start = self.locate(p);
        let at = self.points[p as usize];
        for &v in &self.tets[start as usize] {
            if v != GHOST && self.points[v as usize] == at {
                return Err(MeshError::DuplicateVertices {
                    first: v as usize,
                    second: p as usize,
                    at: at.into(),
                });
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
        let mut here = self.last;
        if let Some(k) = self.tets[here as usize].iter().position(|&v| v == GHOST) {
            here = self.neighbours[here as usize][k];
        }
        let mut from = u32::MAX;
        'walk: loop {
            let tet = self.tets[here as usize];
            if tet.contains(&GHOST) {
                return here;
            }
            for i in 0..4 {
                let next = self.neighbours[here as usize][i];
                if next != from && self.side(&tet, i, at) < 0.0 {
                    from = here;
                    here = next;
                    continue 'walk;
                }
            }
            return here;
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
    fn conflicts(&self, t: u32, at: &Vec3) -> bool {
        let tet = &self.tets[t as usize];
        if let Some(k) = tet.iter().position(|&v| v == GHOST) {
            let side = self.side(tet, k, at);
            return side > 0.0 || side == 0.0 && self.conflicts(self.neighbours[t as usize][k], at);
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
            let t = self.cavity[next];
            next += 1;
            for i in 0..4 {
                let n = self.neighbours[t as usize][i];
                if self.marks[n as usize] < outside {
                    let hit = self.conflicts(n, at);
                    self.marks[n as usize] = if hit { inside } else { outside };
                    if hit {
                        self.cavity.push(n);
                    }
                }
                if self.marks[n as usize] == outside {
                    self.boundary.push((t, i as u32));
                }
            }
        }
    }

    /// Fills the cavity with the tets that join its boundary faces to `p`.
    fn fill_cavity(&mut self, p: u32) {
        let boundary = std::mem::take(&mut self.boundary);
        for &(t, i) in &boundary {
            let (t, i) = (t as usize, i as usize);
            let mut tet = self.tets[t];
            tet[i] = p;
            let beyond = self.neighbours[t][i];
            let mut around = [u32::MAX; 4];
            around[i] = beyond;
            let new = match self.free.pop() {
                Some(slot) => {
                    self.tets[slot as usize] = tet;
                    self.neighbours[slot as usize] = around;
                    self.marks[slot as usize] = 0;
                    slot
                }
                None => {
                    self.tets.push(tet);
                    self.neighbours.push(around);
                    self.marks.push(0);
                    (self.tets.len() - 1) as u32
                }
            };
            let back = slot_of(&self.neighbours[beyond as usize], t as u32);
            self.neighbours[beyond as usize][back] = new;
            self.neighbours[t][i] = NEW | new;
        }
        for &(t, i) in &boundary {
            let new = (self.neighbours[t as usize][i as usize] & !NEW) as usize;
            for j in 0..4 {
                if j != i as usize {
                    self.neighbours[new][j] = self.new_neighbour(t as usize, i as usize, j);
                }
            }
        }
        self.last = self.neighbours[boundary[0].0 as usize][boundary[0].1 as usize] & !NEW;
        self.free.append(&mut self.cavity);
        self.boundary = boundary;
    }

    /// Neighbour of the new tet on boundary face `(t, i)` across its face opposite vertex `j`.
    ///
    /// Rotates through the cavity about the edge common to the faces `i` and `j` of `t`, until the
    /// next boundary face.
    fn new_neighbour(&self, t: usize, i: usize, j: usize) -> u32 {
        let (mut t, mut i, mut j) = (t, i, j);
        loop {
            let next = self.neighbours[t][j];
            if next & NEW != 0 {
                return next & !NEW;
            }
            let next = next as usize;
            // Cross face j. Vertex i of `t` is also a vertex of `next`; the next face is opposite
            // to it.
            let pivot = slot_of(&self.tets[next], self.tets[t][i]);
            i = slot_of(&self.neighbours[next], t as u32);
            (t, j) = (next, pivot);
        }
    }

    /// The tets without ghosts and unused slots.
    fn finish(mut self) -> Vec<[u32; 4]> {
        for &slot in &self.free {
            self.tets[slot as usize] = [GHOST; 4];
        }
        self.tets.retain(|tet| !tet.contains(&GHOST));
        self.tets
    }
}

/// Position of `value`, which must be in `slots`.
#[inline]
fn slot_of(slots: &[u32; 4], value: u32) -> usize {
    (0..3).find(|&k| slots[k] == value).unwrap_or(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks orientation, empty circumballs (against every point), and the volume of the hull.
    fn check(points: &[Vec3], volume: f64) {
        let tets = delaunay(points).expect("points span a volume");
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
    fn octahedron_with_and_without_its_centre() {
        let axes = [Vec3::x(), Vec3::y(), Vec3::z()];
        let mut points: Vec<Vec3> = axes.iter().flat_map(|&a| [a, -a]).collect();
        check(&points, 4.0 / 3.0);
        points.push(Vec3::zeros());
        check(&points, 4.0 / 3.0);
    }

    #[test]
    fn flat_duplicate_and_nan_points_are_errors() {
        let plane: Vec<Vec3> = (0..20)
            .map(|i| Vec3::new(f64::from(i % 5), f64::from(i / 5), 1.0))
            .collect();
        assert!(matches!(
            delaunay(&plane),
            Err(MeshError::FlatPoints { points: 20 })
        ));
        assert!(matches!(
            delaunay(&[]),
            Err(MeshError::FlatPoints { points: 0 })
        ));
        let mut solid = plane.clone();
        solid.push(Vec3::zeros());
        assert!(delaunay(&solid).is_ok());
        solid.push(solid[7]);
        assert!(matches!(
            delaunay(&solid),
            Err(MeshError::DuplicateVertices { .. })
        ));
        solid[3].x = f64::NAN;
        assert!(matches!(
            delaunay(&solid),
            Err(MeshError::NotFinite { point: 3 })
        ));
    }
}
