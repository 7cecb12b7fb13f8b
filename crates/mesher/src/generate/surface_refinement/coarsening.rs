//! Coarsening of a surface triangulation: short edges collapse.

use super::{BENT, Refiner, SPLIT, sorted};
use crate::surface::triangles::neighbours;
use mesh::Vec3;
use std::collections::BTreeMap;

/// Ratio to the wanted length below which edges collapse; their neighbours then have at most
/// [`SPLIT`].
const COLLAPSE: f64 = 0.7;

/// Largest number of passes; each removes about a tenth of the vertices or more.
const MAX_PASSES: usize = 200;

/// Smallest quality of a triangle after a collapse, of which flips and smoothing make a good one:
/// twice the area over the squared longest edge, 0.87 for equal sides.
const LEAST_QUALITY: f64 = 0.1;

/// A collapse of an edge into its first vertex.
struct Collapse {
    kept: u32,
    removed: u32,
    /// New position of the first vertex.
    at: Vec3,
}

/// What a pass of collapses needs to know about the vertices.
struct Pass {
    /// Triangles around each vertex.
    around: Vec<Vec<u32>>,
    /// Other ends of the sharp edges at the vertices that have any.
    sharp: BTreeMap<u32, Vec<u32>>,
    /// Whether the triangles of a vertex change in this pass.
    touched: Vec<bool>,
}

impl Refiner<'_> {
    /// Collapses edges that are too short, each time with flips and smoothing, until none is left.
    pub(super) fn coarsen(&mut self) {
        for _ in 0..MAX_PASSES {
            let before = self.mesh.triangles.len();
            self.collapse_short();
            let after = self.mesh.triangles.len();
            self.flip_all();
            self.smooth();
            self.flip_all();
            // The last few short edges do no harm.
            if before - after <= before / 1000 {
                break;
            }
        }
    }

    /// Collapses short edges, the shortest first, as long as their surroundings do not overlap.
    fn collapse_short(&mut self) {
        let mut short: Vec<(f64, [u32; 2])> = Vec::new();
        let mut around = vec![Vec::new(); self.mesh.points.len()];
        for (t, triangle) in self.mesh.triangles.iter().enumerate() {
            for i in 0..3 {
                around[triangle[i] as usize].push(t as u32);
                let (a, b) = (triangle[(i + 1) % 3], triangle[(i + 2) % 3]);
                if a < b {
                    let stretch = self.stretch(t, i);
                    if stretch < COLLAPSE {
                        short.push((stretch, [a, b]));
                    }
                }
            }
        }
        short.sort_by(|x, y| x.0.total_cmp(&y.0).then(x.1.cmp(&y.1)));
        let mut pass = Pass {
            around,
            sharp: self.sharp_neighbours(),
            touched: vec![false; self.mesh.points.len()],
        };
        let mut into: Vec<u32> = (0..self.mesh.points.len() as u32).collect();
        for (_, edge) in short {
            if let Some(collapse) = self.collapse(&pass, edge) {
                let Collapse { kept, removed, at } = collapse;
                for v in [kept, removed] {
                    for &t in &pass.around[v as usize] {
                        for v in self.mesh.triangles[t as usize] {
                            pass.touched[v as usize] = true;
                        }
                    }
                }
                into[removed as usize] = kept;
                self.mesh.points[kept as usize] = at;
            }
        }
        self.merge(&into);
    }

    /// The collapse of an edge, if it is allowed.
    fn collapse(&self, pass: &Pass, [a, b]: [u32; 2]) -> Option<Collapse> {
        let stars = [a, b].map(|v| &pass.around[v as usize]);
        let ring = |star: &[u32]| {
            let mut ring: Vec<u32> = (star.iter())
                .flat_map(|&t| self.mesh.triangles[t as usize])
                .collect();
            ring.sort_unstable();
            ring.dedup();
            ring
        };
        let rings = stars.map(|star| ring(star));
        if rings.iter().flatten().any(|&v| pass.touched[v as usize]) {
            return None;
        }
        // Two triangles have the edge; a third common neighbour would make a fold.
        let common = rings[0]
            .iter()
            .filter(|v| rings[1].binary_search(v).is_ok());
        let opposite: Vec<u32> = common.copied().filter(|v| ![a, b].contains(v)).collect();
        if opposite.len() != 2 || opposite.iter().any(|&v| pass.around[v as usize].len() < 4) {
            return None;
        }
        let (kept, at) = self.position(pass, [a, b], &opposite)?;
        let removed = a + b - kept;
        let size = (self.size)(at);
        let is_long = |v: &u32| (self.mesh.points[*v as usize] - at).norm() > SPLIT * size;
        if rings.iter().flatten().any(is_long) {
            return None;
        }
        for &t in stars.into_iter().flatten() {
            let triangle = self.mesh.triangles[t as usize];
            if triangle.contains(&a) && triangle.contains(&b) {
                continue;
            }
            let [p, q, r] = triangle.map(|v| match v == a || v == b {
                true => at,
                false => self.mesh.points[v as usize],
            });
            let (before, after) = (self.normal(t as usize), (q - p).cross(&(r - p)));
            let longest = (q - p)
                .norm_squared()
                .max((r - q).norm_squared())
                .max((p - r).norm_squared());
            let bends = after.dot(&before) < BENT * after.norm() * before.norm();
            if bends || after.norm() < LEAST_QUALITY * longest {
                return None;
            }
        }
        Some(Collapse { kept, removed, at })
    }

    /// The vertex of an edge that remains and its position: the middle of the edge, but on sharp
    /// edges and at corners.
    fn position(&self, pass: &Pass, [a, b]: [u32; 2], opposite: &[u32]) -> Option<(u32, Vec3)> {
        let is_corner = |v: u32| self.mesh.corners.binary_search(&v).is_ok();
        let is_on_edge = |v: u32| pass.sharp.contains_key(&v);
        let point = |v: u32| self.mesh.points[v as usize];
        let is_sharp = |a: u32, b: u32| self.sharp.contains(&sorted([a, b]));
        if opposite.iter().any(|&c| is_sharp(a, c) && is_sharp(b, c)) {
            return None;
        }
        match ([is_corner(a), is_corner(b)], [is_on_edge(a), is_on_edge(b)]) {
            ([true, true], _) => None,
            (_, [true, true]) if !is_sharp(a, b) => None,
            ([true, _], _) | (_, [true, false]) => Some((a, point(a))),
            ([_, true], _) | (_, [false, true]) => Some((b, point(b))),
            (_, [true, true]) => Some((a, self.on_sharp_edge([a, b]))),
            (_, [false, false]) => {
                let middle = 0.5 * (point(a) + point(b));
                Some((a, self.surface.closest_point(middle)))
            }
        }
    }

    /// Replaces each vertex by the one into which it collapsed, and numbers what is left.
    fn merge(&mut self, into: &[u32]) {
        let mut number = vec![u32::MAX; into.len()];
        let mut points = Vec::new();
        for v in 0..into.len() {
            if into[v] as usize == v {
                number[v] = points.len() as u32;
                points.push(self.mesh.points[v]);
            }
        }
        let new = |v: u32| number[into[v as usize] as usize];
        let triangles = self.mesh.triangles.iter().map(|t| t.map(new));
        self.mesh.triangles = triangles
            .filter(|[a, b, c]| a != b && b != c && c != a)
            .collect();
        let sharp = self.sharp.iter().map(|edge| sorted(edge.map(new)));
        self.sharp = sharp.filter(|[a, b]| a != b).collect();
        self.mesh.corners.iter_mut().for_each(|v| *v = new(*v));
        self.mesh.corners.sort_unstable();
        self.mesh.points = points;
        self.neighbours = neighbours(&self.mesh);
    }
}
