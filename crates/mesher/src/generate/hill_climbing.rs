//! Hill climbing on cell quality (Freitag & Ollivier-Gooch 1997).
//!
//! The vertices of the worst tets move to where the worst angle around them is best.

use super::symmetry_planes::SymmetryPlanes;
use mesh::{Grouped, TET_EDGES, Vec3, has_volume};
use rayon::prelude::*;
use std::collections::HashMap;

/// Lengths of the steps, as fractions of the wanted edge length.
const STEPS: [f64; 5] = [0.2, 0.1, 0.05, 0.025, 0.0125];

/// Tets per parallel task; fixed, so that the work is divided equally for any number of threads.
const CHUNK: usize = 2048;

/// Largest number of passes over the bad tets.
///
/// In gaps of 0.05 radii no vertex moved after the fifth pass.
const PASSES: usize = 8;

/// Weight of the scaled Jacobian of a curved tet in its quality.
///
/// A scaled Jacobian of 0.2, below which a moving mesh is remeshed (Jacobian guard), is then as bad
/// as an angle of 15 degrees, and the default target of 22 degrees asks for one of 0.43. Smallest
/// Jacobian for three spheres of size 0.6, 0.4, 0.3 in a ball of radius 40: 0.37, 0.39, 0.39 with a
/// weight of 0.25, 0.42, 0.49, 0.42 with 0.18, 0.49, 0.52, 0.51 with 0.15, at angles of 22 degrees.
const JACOBIAN_WEIGHT: f64 = 0.17;

/// Quality of a straight tet: one minus the largest `|cos|` of its dihedral angles.
///
/// Small and large angles are equally bad. 2/3 for a regular tet; `1 - cos(15 deg) = 0.034` if the
/// worst angle is 15 or 165 degrees; -1 for an inverted tet.
#[inline]
fn angle_quality(x: [Vec3; 4]) -> f64 {
    let [u, v, w] = [x[1] - x[0], x[2] - x[0], x[3] - x[0]];
    let (vw, wu, uv) = (v.cross(&w), w.cross(&u), u.cross(&v));
    if u.dot(&vw) <= 0.0 {
        return -1.0;
    }
    // Inward area vectors of the faces opposite vertices 1, 2, 3, and 0.
    let faces = [vw, wu, uv, -(vw + wu + uv)];
    let inverse = faces.map(|n| 1.0 / n.norm_squared());
    let mut worst = 0f64;
    for i in 0..4 {
        for j in i + 1..4 {
            let product = faces[i].dot(&faces[j]);
            worst = worst.max((product * inverse[i]) * (product * inverse[j]));
        }
    }
    1.0 - worst.sqrt()
}

/// Offsets of the midside nodes of curved edges from the midpoints.
///
/// Keys are the two vertices, the smaller number first.
pub(crate) type MidsideOffsets = HashMap<[u32; 2], Vec3>;

/// Smallest Jacobian at the vertices of a quadratic tet over that of the straight tet.
///
/// `offsets` are those of the midside nodes, in the order of [`TET_EDGES`]. The tangent at vertex
/// `i` of the edge to `j` is `4 m - 3 x_i - x_j = x_j - x_i + 4 offset`, where `m` is the midside
/// node.
fn vertex_jacobian(x: [Vec3; 4], offsets: &[Vec3; 6]) -> f64 {
    let mut tangents = [[Vec3::zeros(); 4]; 4];
    for (&[i, j], offset) in TET_EDGES.iter().zip(offsets) {
        let edge = x[j] - x[i];
        tangents[i][j] = edge + 4.0 * offset;
        tangents[j][i] = -edge + 4.0 * offset;
    }
    let straight = (x[1] - x[0]).cross(&(x[2] - x[0])).dot(&(x[3] - x[0]));
    // At each vertex, the others in the order of a positively oriented tet.
    [[0, 1, 2, 3], [1, 0, 3, 2], [2, 0, 1, 3], [3, 0, 2, 1]]
        .iter()
        .map(|&[i, a, b, c]| {
            let t = &tangents[i];
            t[a].cross(&t[b]).dot(&t[c]) / straight
        })
        .fold(f64::INFINITY, f64::min)
}

/// Tets whose vertices move, with the data for measuring their quality.
pub(crate) struct HillClimbing<'a> {
    tets: &'a [[u32; 4]],
    /// For tets with curved edges, the index into `offsets`.
    curved: Vec<Option<u32>>,
    offsets: Vec<[Vec3; 6]>,
    free: &'a [bool],
    planes: SymmetryPlanes,
    sizes: &'a [f64],
}

impl<'a> HillClimbing<'a> {
    /// Prepares the tets; `offsets` are those of the curved edges, `sizes` the wanted edge lengths
    /// at the vertices.
    ///
    /// The quality of a tet with a curved edge also depends on its Jacobian.
    pub fn new(
        tets: &'a [[u32; 4]],
        free: &'a [bool],
        offsets: &MidsideOffsets,
        planes: SymmetryPlanes,
        sizes: &'a [f64],
    ) -> Self {
        let mut of_curved = Vec::new();
        let curved = tets
            .iter()
            .map(|tet| {
                // Curved edges join vertices on surfaces.
                if tet.iter().filter(|&&v| !free[v as usize]).count() < 2 {
                    return None;
                }
                let of_tet = TET_EDGES.map(|[i, j]| {
                    offsets
                        .get(&[tet[i].min(tet[j]), tet[i].max(tet[j])])
                        .copied()
                        .unwrap_or_default()
                });
                (of_tet != [Vec3::zeros(); 6]).then(|| {
                    of_curved.push(of_tet);
                    of_curved.len() as u32 - 1
                })
            })
            .collect();
        HillClimbing {
            tets,
            curved,
            offsets: of_curved,
            free,
            planes,
            sizes,
        }
    }

    /// Tets without volume and those whose curved edges invert them.
    pub fn inverted(&self, points: &[Vec3]) -> impl Iterator<Item = &'a [u32; 4]> {
        self.tets
            .iter()
            .zip(&self.curved)
            .filter_map(|(tet, curved)| {
                let x = tet.map(|v| points[v as usize]);
                let is_valid = has_volume(x)
                    && curved.is_none_or(|k| vertex_jacobian(x, &self.offsets[k as usize]) > 0.0);
                (!is_valid).then_some(tet)
            })
    }

    /// Quality of tet `t` with vertex `v` moved to `position`.
    #[inline]
    fn quality(&self, points: &[Vec3], t: u32, v: u32, position: Vec3) -> f64 {
        let x = self.tets[t as usize].map(|w| if w == v { position } else { points[w as usize] });
        let straight = angle_quality(x);
        match self.curved[t as usize] {
            Some(k) if straight > 0.0 => {
                straight.min(JACOBIAN_WEIGHT * vertex_jacobian(x, &self.offsets[k as usize]))
            }
            _ => straight,
        }
    }

    /// Moves free vertices of tets with bad dihedral angles.
    ///
    /// Angles below `target` degrees or above 180 minus `target` are bad. Returns the quality of
    /// the worst tet afterwards.
    ///
    /// Vertices on symmetry planes move in them. The tets keep their vertices, and no move makes
    /// the worst tet around a vertex worse. Deterministic and serial, because few vertices move.
    pub fn run(&self, points: &mut [Vec3], target: f64) -> f64 {
        let bad = 1.0 - target.to_radians().cos();
        let tets = self.tets;
        let vertices = || (0..).zip(tets).flat_map(|(t, tet)| tet.map(|v| (v, t)));
        let around: Grouped<u32> = Grouped::new(points.len(), vertices);
        let at = |points: &[Vec3], t: u32| {
            let v = tets[t as usize][0];
            self.quality(points, t, v, points[v as usize])
        };
        let mut quality: Vec<f64> = (0..tets.len() as u32)
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|t| at(points, t))
            .collect();
        // Vertices without a better position, until something around them changes.
        let mut settled = vec![false; points.len()];
        let mut star = Vec::new();
        for _ in 0..PASSES {
            let mut worst: Vec<u32> = (0..tets.len() as u32)
                .filter(|&t| quality[t as usize] < bad)
                .collect();
            worst.sort_by(|&a, &b| {
                quality[a as usize]
                    .total_cmp(&quality[b as usize])
                    .then(a.cmp(&b))
            });
            let mut moved = false;
            for t in worst {
                for v in tets[t as usize] {
                    if !self.free[v as usize] || settled[v as usize] || quality[t as usize] >= bad {
                        continue;
                    }
                    star.clear();
                    star.extend_from_slice(around.of(v));
                    // Most trials fail at the worst tet, so it is tried first.
                    star.sort_unstable_by(|&a, &b| {
                        quality[a as usize]
                            .total_cmp(&quality[b as usize])
                            .then(a.cmp(&b))
                    });
                    let lowest = quality[star[0] as usize];
                    if self.move_vertex(points, v, &star, lowest) {
                        moved = true;
                        for &s in &star {
                            quality[s as usize] = at(points, s);
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
        quality.into_iter().fold(1.0, f64::min)
    }

    /// Moves vertex `v` by pattern search; returns whether it moved.
    ///
    /// At each step length the vertex moves in the best of 14 directions, as long as this improves
    /// the quality of the worst tet around it, which is `lowest` at the start.
    fn move_vertex(&self, points: &mut [Vec3], v: u32, star: &[u32], lowest: f64) -> bool {
        let start = points[v as usize];
        let h = self.sizes[v as usize];
        let planes = self.planes.at(start);
        let (mut position, mut best) = (start, lowest);
        for step in STEPS {
            for _ in 0..3 {
                let from = position;
                for direction in directions() {
                    let trial = from + (step * h) * planes.along(direction);
                    let mut low = 1f64;
                    for &s in star {
                        low = low.min(self.quality(points, s, v, trial));
                        if low <= best {
                            break;
                        }
                    }
                    if low > best {
                        (position, best) = (trial, low);
                    }
                }
                if position == from {
                    break;
                }
            }
        }
        points[v as usize] = position;
        position != start
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::dihedral_angles;

    #[test]
    fn angle_quality_is_that_of_the_worst_dihedral_angle() {
        let x = [
            Vec3::zeros(),
            Vec3::x(),
            Vec3::new(0.3, 0.8, 0.1),
            Vec3::new(0.4, 0.2, 0.5),
        ];
        let worst = dihedral_angles(x)
            .iter()
            .fold(180f64, |m, a| m.min(*a).min(180.0 - a));
        assert!((angle_quality(x) - (1.0 - worst.to_radians().cos())).abs() < 1e-14);
        assert_eq!(angle_quality([x[1], x[0], x[2], x[3]]), -1.0);
    }
}
