//! Hill climbing: vertices of the worst tets move to where the worst angle around them is best (Freitag & Ollivier-Gooch 1997).

use super::planes::Planes;
use super::size::SizeField;
use crate::{TET_EDGES, Vec3};
use std::collections::HashMap;

/// Lengths of the steps, in wanted edge lengths.
const STEPS: [f64; 5] = [0.2, 0.1, 0.05, 0.025, 0.0125];

/// Passes over the bad tets at most; five were the most that still moved something in gaps of 0.05 radii.
const PASSES: usize = 8;

/// How good a tet is: one minus the largest `|cos|` of its dihedral angles, which are bad when small and when large.
///
/// 2/3 for a regular tet; `1 - cos(15 deg) = 0.034` when the worst angle is 15 or 165 degrees; -1 for an inverted tet.
#[inline]
pub(super) fn goodness(x: [Vec3; 4]) -> f64 {
    let [u, v, w] = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
    let (vw, wu, uv) = (v.cross(&w), w.cross(&u), u.cross(&v));
    if u.dot(&vw) <= 0.0 {
        return -1.0;
    }
    // Area vectors of the faces, inwards: opposite vertices 1, 2, 3, and 0.
    let faces = [vw, wu, uv, -(vw + wu + uv)];
    let inverse = faces.map(|n| 1.0 / n.norm());
    let mut worst = 0f64;
    for i in 0..4 {
        for j in i + 1..4 {
            worst = worst.max((faces[i].dot(&faces[j]) * (inverse[i] * inverse[j])).abs());
        }
    }
    1.0 - worst
}

/// A scaled Jacobian of a curved tet counts as this many times itself beside [`goodness`]: 0.2, below which a mesh that moves is
/// remeshed (Jacobian guard), is then as bad as an angle of 18 degrees.
const JACOBIAN_WEIGHT: f64 = 0.25;

/// How far the midside nodes of curved edges lie from the midpoints, by the two vertices (the smaller first).
pub(super) type Bulges = HashMap<[u32; 2], Vec3>;

/// Smallest Jacobian at the vertices of a quadratic tet over that of the straight one; `bulge` by [`TET_EDGES`].
///
/// The tangent at vertex i of the edge to j is `4 m - 3 x_i - x_j = x_j - x_i + 4 bulge`, m its midside node.
fn vertex_jacobian(x: [Vec3; 4], bulge: &[Vec3; 6]) -> f64 {
    let mut tangents = [[Vec3::zeros(); 4]; 4];
    for (&[i, j], b) in TET_EDGES.iter().zip(bulge) {
        let edge = x[j] - x[i];
        tangents[i][j] = edge + 4.0 * b;
        tangents[j][i] = -edge + 4.0 * b;
    }
    let straight = (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0]));
    // At each vertex, the others in the order that makes a positive tet.
    [[0, 1, 2, 3], [1, 0, 3, 2], [2, 0, 1, 3], [3, 0, 2, 1]]
        .iter()
        .map(|&[i, a, b, c]| {
            let t = &tangents[i];
            t[a].cross(&t[b]).dot(&t[c]) / straight
        })
        .fold(f64::INFINITY, f64::min)
}

/// Tets with what they need to be judged.
struct Judge<'a> {
    tets: &'a [[u32; 4]],
    /// Index into `bulges` for tets with curved edges.
    curved: Vec<Option<u32>>,
    bulges: Vec<[Vec3; 6]>,
    planes: Planes,
}

impl<'a> Judge<'a> {
    fn new(tets: &'a [[u32; 4]], edges: &Bulges, planes: Planes) -> Self {
        let mut bulges = Vec::new();
        let curved = tets
            .iter()
            .map(|tet| {
                let of = TET_EDGES.map(|[i, j]| {
                    edges
                        .get(&[tet[i].min(tet[j]), tet[i].max(tet[j])])
                        .copied()
                        .unwrap_or_default()
                });
                (of != [Vec3::zeros(); 6]).then(|| {
                    bulges.push(of);
                    bulges.len() as u32 - 1
                })
            })
            .collect();
        Judge {
            tets,
            curved,
            bulges,
            planes,
        }
    }

    /// Goodness of tet `t`, with vertex `v` moved to `place`.
    #[inline]
    fn score(&self, points: &[Vec3], t: u32, v: u32, place: Vec3) -> f64 {
        let x = self.tets[t as usize].map(|w| if w == v { place } else { points[w as usize] });
        let straight = goodness(x);
        match self.curved[t as usize] {
            Some(k) if straight > 0.0 => {
                straight.min(JACOBIAN_WEIGHT * vertex_jacobian(x, &self.bulges[k as usize]))
            }
            _ => straight,
        }
    }
}

/// Moves free vertices of tets whose worst angle is below `target` degrees (or above 180 minus it); returns the smallest
/// [`goodness`] of all tets then.
///
/// Vertices on `planes` move in them. Tets along the curved `edges` are judged by their Jacobian too. The tets stay the same; no move makes the worst tet around a vertex worse. Deterministic and serial: few vertices move.
pub(super) fn climb(
    points: &mut [Vec3],
    tets: &[[u32; 4]],
    free: &[bool],
    planes: Planes,
    edges: &Bulges,
    field: &SizeField<'_>,
    target: f64,
) -> f64 {
    let bad = 1.0 - target.to_radians().cos();
    let around = tets_around(points.len(), tets);
    let judge = Judge::new(tets, edges, planes);
    let at = |points: &[Vec3], t: u32| {
        let v = tets[t as usize][0];
        judge.score(points, t, v, points[v as usize])
    };
    let mut score: Vec<f64> = (0..tets.len() as u32).map(|t| at(points, t)).collect();
    // Vertices that found no better place, until something around them changes.
    let mut settled = vec![false; points.len()];
    for _ in 0..PASSES {
        let mut worst: Vec<u32> = (0..tets.len() as u32)
            .filter(|&t| score[t as usize] < bad)
            .collect();
        worst.sort_by(|&a, &b| {
            score[a as usize]
                .total_cmp(&score[b as usize])
                .then(a.cmp(&b))
        });
        let mut moved = false;
        for t in worst {
            for v in tets[t as usize] {
                if !free[v as usize] || settled[v as usize] || score[t as usize] >= bad {
                    continue;
                }
                let star = &around.tets[around.starts[v as usize]..around.starts[v as usize + 1]];
                let lowest = star.iter().fold(1.0, |m: f64, &s| m.min(score[s as usize]));
                if move_vertex(points, &judge, v, star, lowest, field) {
                    moved = true;
                    for &s in star {
                        score[s as usize] = at(points, s);
                        for w in tets[s as usize] {
                            settled[w as usize] = false;
                        }
                    }
                }
                settled[v as usize] = true;
            }
        }
        if !moved {
            break;
        }
    }
    score.into_iter().fold(1.0, f64::min)
}

/// Pattern search: the best of 14 directions at each step length, as long as the worst tet of the star improves.
fn move_vertex(
    points: &mut [Vec3],
    judge: &Judge<'_>,
    v: u32,
    star: &[u32],
    lowest: f64,
    field: &SizeField<'_>,
) -> bool {
    let start = points[v as usize];
    let h = field.at(start);
    let planes = judge.planes.at(start);
    let (mut place, mut best) = (start, lowest);
    for step in STEPS {
        for _ in 0..3 {
            let from = place;
            for direction in directions() {
                let trial = from + (step * h) * planes.along(direction);
                let mut low = 1f64;
                for &s in star {
                    low = low.min(judge.score(points, s, v, trial));
                    if low <= best {
                        break;
                    }
                }
                if low > best {
                    (place, best) = (trial, low);
                }
            }
            if place == from {
                break;
            }
        }
    }
    points[v as usize] = place;
    place != start
}

/// Unit vectors to the faces and corners of a cube.
fn directions() -> impl Iterator<Item = Vec3> {
    let faces = (0..6).map(|k| {
        let mut d = Vec3::zeros();
        d[k / 2] = if k % 2 == 0 { 1.0 } else { -1.0 };
        d
    });
    let corner = 1.0 / 3f64.sqrt();
    let corners = (0..8)
        .map(move |k| Vec3::from_fn(|axis, _| if k >> axis & 1 == 0 { corner } else { -corner }));
    faces.chain(corners)
}

/// The tets around each vertex, in compressed rows.
struct Stars {
    starts: Vec<usize>,
    tets: Vec<u32>,
}

fn tets_around(n_points: usize, tets: &[[u32; 4]]) -> Stars {
    let mut starts = vec![0; n_points + 1];
    for v in tets.iter().flatten() {
        starts[*v as usize + 1] += 1;
    }
    for i in 0..n_points {
        starts[i + 1] += starts[i];
    }
    let mut next = starts.clone();
    let mut list = vec![0; 4 * tets.len()];
    for (t, tet) in tets.iter().enumerate() {
        for &v in tet {
            list[next[v as usize]] = t as u32;
            next[v as usize] += 1;
        }
    }
    Stars { starts, tets: list }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dihedral_angles;

    #[test]
    fn goodness_is_the_worst_dihedral() {
        let x = [
            Vec3::zeros(),
            Vec3::x(),
            Vec3::new(0.3, 0.8, 0.1),
            Vec3::new(0.4, 0.2, 0.5),
        ];
        let worst = dihedral_angles(x)
            .iter()
            .fold(180f64, |m, a| m.min(*a).min(180.0 - a));
        assert!((goodness(x) - (1.0 - worst.to_radians().cos())).abs() < 1e-14);
        assert_eq!(goodness([x[1], x[0], x[2], x[3]]), -1.0);
    }
}
