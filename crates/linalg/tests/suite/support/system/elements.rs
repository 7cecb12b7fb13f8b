//! Element matrices of straight ten-node tetrahedra, by a rule that integrates them exactly.

use nalgebra::{Matrix3, Vector3};

/// Ends of the midside nodes 4..10.
pub const EDGES: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// Barycentric coordinates of the four-point rule of degree two, `(5 ∓ sqrt 5) / 20` (Keast 1986,
/// rule 1).
const OTHER_COORDINATE: f64 = 0.138_196_601_125_010_5;
const OWN_COORDINATE: f64 = 1.0 - 3.0 * OTHER_COORDINATE;

/// The six tetrahedra of a cell, one for each order of the three directions (Kuhn).
pub fn kuhn_tets(cell: [usize; 3]) -> [[[usize; 3]; 4]; 6] {
    let orders = [
        [0, 1, 2],
        [0, 2, 1],
        [1, 0, 2],
        [1, 2, 0],
        [2, 0, 1],
        [2, 1, 0],
    ];
    orders.map(|order| {
        let mut vertices = [cell; 4];
        for step in 0..3 {
            vertices[step + 1] = vertices[step];
            vertices[step + 1][order[step]] += 1;
        }
        vertices
    })
}

/// Gradients of the barycentric coordinates, and the volume.
fn geometry(x: &[Vector3<f64>; 4]) -> ([Vector3<f64>; 4], f64) {
    let edges = Matrix3::from_columns(&[x[1] - x[0], x[2] - x[0], x[3] - x[0]]);
    let inverse = edges.try_inverse().expect("a tetrahedron with volume");
    let g = [0, 1, 2].map(|i| Vector3::from(inverse.row(i).transpose()));
    (
        [-(g[0] + g[1] + g[2]), g[0], g[1], g[2]],
        edges.determinant().abs() / 6.0,
    )
}

/// Gradients of the ten quadratic functions at barycentric coordinates `l`.
fn gradients(g: &[Vector3<f64>; 4], l: [f64; 4]) -> [Vector3<f64>; 10] {
    let mut all = [Vector3::zeros(); 10];
    for v in 0..4 {
        all[v] = g[v] * (4.0 * l[v] - 1.0);
    }
    for (e, [a, b]) in EDGES.iter().enumerate() {
        all[4 + e] = (g[*a] * l[*b] + g[*b] * l[*a]) * 4.0;
    }
    all
}

fn quadrature_points() -> [[f64; 4]; 4] {
    [0, 1, 2, 3].map(|k| {
        let mut l = [OTHER_COORDINATE; 4];
        l[k] = OWN_COORDINATE;
        l
    })
}

/// Stiffness matrix `∫ ∇phi_i · ∇phi_j`.
pub fn stiffness(x: &[Vector3<f64>; 4]) -> [[f64; 10]; 10] {
    let (g, volume) = geometry(x);
    let mut k = [[0.0; 10]; 10];
    for l in quadrature_points() {
        let d = gradients(&g, l);
        for i in 0..10 {
            for j in 0..10 {
                k[i][j] += 0.25 * volume * d[i].dot(&d[j]);
            }
        }
    }
    k
}

/// Divergence `-∫ psi_q ∇phi_j`.
pub fn divergence(x: &[Vector3<f64>; 4]) -> [[Vector3<f64>; 10]; 4] {
    let (g, volume) = geometry(x);
    let mut b = [[Vector3::zeros(); 10]; 4];
    for l in quadrature_points() {
        let d = gradients(&g, l);
        for q in 0..4 {
            for j in 0..10 {
                b[q][j] -= d[j] * (0.25 * volume * l[q]);
            }
        }
    }
    b
}

/// Mass matrix `∫ psi_p psi_q = V (1 + delta_pq) / 20`.
pub fn mass(x: &[Vector3<f64>; 4]) -> [[f64; 4]; 4] {
    let (_, volume) = geometry(x);
    let mut m = [[volume / 20.0; 4]; 4];
    for (q, row) in m.iter_mut().enumerate() {
        row[q] *= 2.0;
    }
    m
}
