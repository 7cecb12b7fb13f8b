//! Curved triangles: cubic Bézier patches, and integrals over the volume that they enclose.

use mesh::Vec3;

/// Largest number of Newton steps to a closest point.
const STEPS: usize = 20;

/// Relative size of the last Newton step; distances then have errors of its square.
const ACCURACY: f64 = 1e-10;

/// Smallest barycentric coordinate down to which a search leaves the triangle.
const OUTSIDE: f64 = -0.2;

/// A cubic curve from `points[0]` to `points[3]` in Bézier form.
#[derive(Clone, Copy, Debug)]
pub(super) struct Curve {
    pub points: [Vec3; 4],
}

impl Curve {
    /// Position and the first two derivatives at `t`.
    fn at(&self, t: f64) -> [Vec3; 3] {
        let [a, b, c, d] = self.points;
        let s = 1.0 - t;
        [
            s * s * (s * a + 3.0 * t * b) + t * t * (3.0 * s * c + t * d),
            3.0 * (s * s * (b - a) + 2.0 * s * t * (c - b) + t * t * (d - c)),
            6.0 * (s * (c - 2.0 * b + a) + t * (d - 2.0 * c + b)),
        ]
    }

    /// Parameter of the closest point to `x`, and the point; the search starts at `t`.
    pub fn closest(&self, x: &Vec3, mut t: f64) -> (f64, Vec3) {
        t = t.clamp(0.0, 1.0);
        for _ in 0..STEPS {
            let [point, first, second] = self.at(t);
            let arm = point - x;
            let (slope, squared) = (arm.dot(&first), first.norm_squared());
            let curvature = squared + arm.dot(&second);
            // Where the distance is not convex, the step of a straight line.
            let bend = if curvature > 0.1 * squared {
                curvature
            } else {
                squared
            };
            let next = (t - slope / bend.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
            let change = (next - t).abs();
            t = next;
            if change.is_nan() || change <= ACCURACY {
                break;
            }
        }
        (t, self.at(t)[0])
    }
}

/// A triangle with corners `c_0, c_1, c_2`, curved as a point-normal triangle (Vlachos et al.
/// 2001).
///
/// `x(b) = sum_i c_i b_i^3 + 3 sum_ij e_ij b_i^2 b_j + 6 m b_0 b_1 b_2` with the barycentric
/// coordinates `b`, and the point `e_ij` of the edge from `i` to `j` next to `c_i`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    pub corners: [Vec3; 3],
    /// `e_01, e_10, e_12, e_21, e_20, e_02`.
    edges: [Vec3; 6],
    middle: Vec3,
    /// Largest distance between the patch and its flat triangle.
    pub bulge: f64,
}

/// Corners of the pair of edge points `2 k` and `2 k + 1`.
const ENDS: [[usize; 2]; 3] = [[0, 1], [1, 2], [2, 0]];

impl Patch {
    /// The patch with the given points on its edges, in the order of the fields.
    pub fn new(corners: [Vec3; 3], edges: [Vec3; 6]) -> Self {
        let mean = edges.iter().sum::<Vec3>() / 6.0;
        let centroid = corners.iter().sum::<Vec3>() / 3.0;
        let third = |i: usize, j: usize| (2.0 * corners[i] + corners[j]) / 3.0;
        let middle = mean + 0.5 * (mean - centroid);
        let offsets = (0..6).map(|k| {
            let [i, j] = ENDS[k / 2];
            let straight = if k % 2 == 0 { third(i, j) } else { third(j, i) };
            (edges[k] - straight).norm()
        });
        // The difference from the flat triangle is the same combination of the offsets.
        let bulge = offsets.fold((middle - centroid).norm(), f64::max);
        Self {
            corners,
            edges,
            middle,
            bulge,
        }
    }

    /// The flat triangle.
    pub fn flat(corners: [Vec3; 3]) -> Self {
        let [a, b, c] = corners;
        let edges = [(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)];
        let mut patch = Self::new(corners, edges.map(|(from, to)| (2.0 * from + to) / 3.0));
        // Exactly, without rounding.
        patch.bulge = 0.0;
        patch
    }

    /// The patch enlarged by a factor about the origin.
    pub fn scaled(&self, factor: f64) -> Self {
        Self {
            corners: self.corners.map(|x| factor * x),
            edges: self.edges.map(|x| factor * x),
            middle: factor * self.middle,
            bulge: factor * self.bulge,
        }
    }

    /// All points whose convex hull contains the patch.
    pub fn hull(&self) -> impl Iterator<Item = Vec3> {
        let inner = self.edges.into_iter().chain([self.middle]);
        self.corners.into_iter().chain(inner)
    }

    /// The edge opposite corner `i`, from corner `i + 1` to corner `i + 2`.
    pub fn edge(&self, i: usize) -> Curve {
        let k = (i + 1) % 3;
        let [a, b] = ENDS[k];
        Curve {
            points: [
                self.corners[a],
                self.edges[2 * k],
                self.edges[2 * k + 1],
                self.corners[b],
            ],
        }
    }

    /// Position.
    pub fn at(&self, b: [f64; 3]) -> Vec3 {
        let mut x = 6.0 * (b[0] * b[1] * b[2]) * self.middle;
        for k in 0..3 {
            let [i, j] = ENDS[k];
            x += b[k].powi(3) * self.corners[k];
            x += (3.0 * b[i] * b[j]) * (b[i] * self.edges[2 * k] + b[j] * self.edges[2 * k + 1]);
        }
        x
    }

    /// Derivatives of the position by the second and the third barycentric coordinate; the first
    /// one is one minus both.
    pub fn tangents(&self, b: [f64; 3]) -> [Vec3; 2] {
        let mut by = [0, 1, 2].map(|k| {
            let [i, j] = [(k + 1) % 3, (k + 2) % 3];
            3.0 * b[k] * b[k] * self.corners[k] + (6.0 * b[i] * b[j]) * self.middle
        });
        for k in 0..3 {
            let [i, j] = ENDS[k];
            let (near, far) = (self.edges[2 * k], self.edges[2 * k + 1]);
            by[i] += 3.0 * b[j] * (2.0 * b[i] * near + b[j] * far);
            by[j] += 3.0 * b[i] * (b[i] * near + 2.0 * b[j] * far);
        }
        [by[1] - by[0], by[2] - by[0]]
    }

    /// Unit normal, which points outwards; zero where the patch has none.
    pub fn normal(&self, b: [f64; 3]) -> Vec3 {
        let [u, v] = self.tangents(b);
        u.cross(&v).try_normalize(0.0).unwrap_or_default()
    }

    /// Second derivatives: `uu`, `uv`, `vv`.
    fn bends(&self, b: [f64; 3]) -> [Vec3; 3] {
        let mut by = [[Vec3::zeros(); 3]; 3];
        for k in 0..3 {
            let [i, j] = ENDS[k];
            let (near, far) = (self.edges[2 * k], self.edges[2 * k + 1]);
            by[k][k] += 6.0 * b[k] * self.corners[k];
            by[i][i] += 6.0 * b[j] * near;
            by[j][j] += 6.0 * b[i] * far;
            let mixed = 6.0 * (b[i] * near + b[j] * far + b[3 - i - j] * self.middle);
            by[i][j] += mixed;
            by[j][i] += mixed;
        }
        [
            by[1][1] - 2.0 * by[0][1] + by[0][0],
            by[1][2] - by[0][1] - by[0][2] + by[0][0],
            by[2][2] - 2.0 * by[0][2] + by[0][0],
        ]
    }

    /// Barycentric coordinates of a point close to `x`, the closest one if it is inside.
    ///
    /// Newton's method from `start`. If it leaves the triangle, the closest point of an edge.
    pub fn closest(&self, x: &Vec3, start: [f64; 3]) -> ([f64; 3], Vec3) {
        let mut b = start;
        for _ in 0..STEPS {
            let arm = self.at(b) - x;
            let [u, v] = self.tangents(b);
            let (gu, gv) = (arm.dot(&u), arm.dot(&v));
            let [uu, uv, vv] = self.bends(b);
            let (a, m, c) = (u.norm_squared(), u.dot(&v), v.norm_squared());
            let [ha, hm, hc] = [a + arm.dot(&uu), m + arm.dot(&uv), c + arm.dot(&vv)];
            let (flat, curved) = (a * c - m * m, ha * hc - hm * hm);
            // Where the distance is not convex, the step of a flat triangle.
            let (a, m, c, d) = match ha > 0.1 * a && hc > 0.1 * c && curved > 0.01 * flat {
                true => (ha, hm, hc, curved),
                false => (a, m, c, flat),
            };
            let (du, dv) = ((m * gv - c * gu) / d, (m * gu - a * gv) / d);
            b = [b[0] - du - dv, b[1] + du, b[2] + dv];
            let is_outside = b.iter().any(|b| *b < OUTSIDE || b.is_nan());
            if is_outside || du.abs().max(dv.abs()) <= ACCURACY {
                break;
            }
        }
        if b.iter().all(|b| *b >= 0.0) {
            return (b, self.at(b));
        }
        self.closest_on_edges(x, b)
    }

    /// The closest point of the edges on the other side of which `b` is, or of all for NaN.
    fn closest_on_edges(&self, x: &Vec3, b: [f64; 3]) -> ([f64; 3], Vec3) {
        let is_nan = b.iter().any(|b| b.is_nan());
        let mut best = ([1.0, 0.0, 0.0], self.corners[0]);
        let mut distance = f64::INFINITY;
        for i in (0..3).filter(|&i| is_nan || b[i] < 0.0) {
            let [j, k] = [(i + 1) % 3, (i + 2) % 3];
            let start = if is_nan { 0.5 } else { b[k] / (b[j] + b[k]) };
            let (t, point) = self.edge(i).closest(x, start);
            let squared = (point - x).norm_squared();
            if squared < distance {
                distance = squared;
                let mut on = [0.0; 3];
                (on[j], on[k]) = (1.0 - t, t);
                best = (on, point);
            }
        }
        best
    }
}

/// Nodes and weights of the Gauss-Legendre rule of degree 11 on the unit interval (Abramowitz &
/// Stegun 1964, 25.4.30).
const GAUSS: [(f64, f64); 6] = [
    (0.033_765_242_898_423_99, 0.085_662_246_189_585_17),
    (0.169_395_306_766_867_74, 0.180_380_786_524_069_3),
    (0.380_690_406_958_401_56, 0.233_956_967_286_345_5),
    (0.619_309_593_041_598_4, 0.233_956_967_286_345_5),
    (0.830_604_693_233_132_3, 0.180_380_786_524_069_3),
    (0.966_234_757_101_576, 0.085_662_246_189_585_17),
];

/// Volume, first moments `int x dV` and area.
pub(super) struct Integrals {
    pub volume: f64,
    pub moments: Vec3,
    pub area: f64,
}

/// Integrals over the patches by the divergence theorem: `V = int x . n / 3 dA`,
/// `int x_i dV = int x_i^2 n_i / 2 dA`.
///
/// Exact but for rounding, except the area: the integrands are polynomials of degree 10. Moments
/// are taken about the point `about`, relative to it.
pub(super) fn integrals(patches: &[Patch], about: Vec3) -> Integrals {
    let mut sums = Integrals {
        volume: 0.0,
        moments: Vec3::zeros(),
        area: 0.0,
    };
    for patch in patches {
        for (s, ws) in GAUSS {
            for (t, wt) in GAUSS {
                // The square is mapped onto the triangle with one side becoming a corner.
                let at = [1.0 - s, s * (1.0 - t), s * t];
                let x = patch.at(at) - about;
                let [u, v] = patch.tangents(at);
                let normal = (ws * wt * s) * u.cross(&v);
                sums.volume += x.dot(&normal) / 3.0;
                sums.moments += 0.5 * x.component_mul(&x).component_mul(&normal);
                sums.area += normal.norm();
            }
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch() -> Patch {
        let corners = [Vec3::zeros(), Vec3::x(), Vec3::new(0.2, 0.9, 0.1)];
        let mut edges = [Vec3::zeros(); 6];
        for k in 0..6 {
            let [i, j] = ENDS[k / 2];
            let (i, j) = if k % 2 == 0 { (i, j) } else { (j, i) };
            edges[k] = (2.0 * corners[i] + corners[j]) / 3.0 + (0.05 + 0.01 * k as f64) * Vec3::z();
        }
        Patch::new(corners, edges)
    }

    #[test]
    fn derivatives_are_those_of_the_position() {
        let patch = patch();
        let (u, v, h) = (0.3, 0.25, 1e-5);
        let at = |u: f64, v: f64| [1.0 - u - v, u, v];
        let by_u = (patch.at(at(u + h, v)) - patch.at(at(u - h, v))) / (2.0 * h);
        let by_v = (patch.at(at(u, v + h)) - patch.at(at(u, v - h))) / (2.0 * h);
        let [tu, tv] = patch.tangents(at(u, v));
        assert!((by_u - tu).norm() < 1e-9 && (by_v - tv).norm() < 1e-9);
        let [uu, uv, vv] = patch.bends(at(u, v));
        let [forth, back] = [h, -h].map(|h| patch.tangents(at(u + h, v)));
        assert!(((forth[0] - back[0]) / (2.0 * h) - uu).norm() < 1e-8);
        assert!(((forth[1] - back[1]) / (2.0 * h) - uv).norm() < 1e-8);
        let [forth, back] = [h, -h].map(|h| patch.tangents(at(u, v + h)));
        assert!(((forth[1] - back[1]) / (2.0 * h) - vv).norm() < 1e-8);
    }

    #[test]
    fn closest_points_are_on_normals() {
        let patch = patch();
        for k in 0..50 {
            let k = f64::from(k);
            let (u, v) = (0.1 + 0.013 * k, 0.8 - 0.015 * k);
            let b = [1.0 - u - v, u, v];
            let (foot, normal) = (patch.at(b), patch.normal(b));
            for height in [-0.3, 0.0, 0.2] {
                let (_, found) = patch.closest(&(foot + height * normal), [1.0 / 3.0; 3]);
                assert!((found - foot).norm() < 1e-9, "{k} {height}");
            }
        }
        // Beyond an edge the closest point is on it.
        let edge = patch.edge(2);
        let on_edge = edge.at(0.4)[0];
        let (b, found) = patch.closest(&(on_edge - 0.2 * Vec3::y()), [0.3, 0.3, 0.4]);
        assert_eq!(b[2], 0.0);
        assert!((found - on_edge).norm() < 0.1);
    }
}
