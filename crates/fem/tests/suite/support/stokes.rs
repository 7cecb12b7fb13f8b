//! Stokes flow with Dirichlet data: sparse Cholesky of the stiffness, conjugate gradients on the pressure Schur complement.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use fem::TaylorHood;
use linalg::{Csr, Csr3};
use mesh::{TetMesh, Vec3};

use super::dot;

pub struct Flow {
    pub stiffness: Csr,
    pub divergence: Csr3,
    pub velocity: Vec<f64>,
    pub pressure: Vec<f64>,
}

/// The discrete flow with `velocity` kept on the boundary, driven by the nodal loads (`3 n_points`).
pub fn solve(mesh: &TetMesh, mut velocity: Vec<f64>, loads: &[f64]) -> Flow {
    let space = TaylorHood::new(mesh).unwrap();
    let stiffness = space.stiffness(mesh).unwrap();
    let divergence = space.divergence(mesh).unwrap();
    let mass = space.pressure_mass(mesh).unwrap().diag().to_dense();

    let mut fixed = vec![false; mesh.n_points()];
    for node in mesh.facets().iter().flat_map(|facet| facet.nodes) {
        fixed[node as usize] = true;
    }
    let free: Vec<usize> = (0..mesh.n_points()).filter(|&i| !fixed[i]).collect();
    for &i in &free {
        velocity[3 * i..3 * i + 3].fill(0.0);
    }
    let inner = Inner::new(&stiffness, &free);

    // u = u_D + K^-1 (g - B^T p) with g = f - K u_D, and B u = 0: (B K^-1 B^T) p = B (u_D + K^-1 g).
    let zero = vec![0.0; mesh.n_vertices()];
    let mut g = fem::momentum_residual(&stiffness, &divergence, &velocity, &zero).unwrap();
    g.iter_mut().zip(loads).for_each(|(g, f)| *g = f - *g);
    let mut particular = inner.solve(&g);
    particular
        .iter_mut()
        .zip(&velocity)
        .for_each(|(u, v)| *u += v);
    let still = vec![0.0; velocity.len()];
    let gradient = |p: &[f64]| fem::momentum_residual(&stiffness, &divergence, &still, p).unwrap();

    let mut r = apply(&divergence, &particular);
    let mut pressure = zero;
    let precondition =
        |r: &[f64]| -> Vec<f64> { r.iter().zip(mass.iter()).map(|(r, m)| r / m).collect() };
    let mut z = precondition(&r);
    let mut d = z.clone();
    let mut rho = dot(&r, &z);
    let first = rho;
    for iteration in 0.. {
        // The velocity's defect is the square root of this: 1e-14.
        if rho <= 1e-28 * first {
            break;
        }
        assert!(
            iteration < 300,
            "pressure iteration stalls at {:e}",
            rho / first
        );
        let s = apply(&divergence, &inner.solve(&gradient(&d)));
        let alpha = rho / dot(&d, &s);
        for q in 0..r.len() {
            pressure[q] += alpha * d[q];
            r[q] -= alpha * s[q];
        }
        z = precondition(&r);
        let next = dot(&r, &z);
        for q in 0..r.len() {
            d[q] = z[q] + next / rho * d[q];
        }
        rho = next;
    }
    let correction = inner.solve(&gradient(&pressure));
    let velocity = particular
        .iter()
        .zip(&correction)
        .map(|(u, c)| u - c)
        .collect();
    Flow {
        stiffness,
        divergence,
        velocity,
        pressure,
    }
}

/// The flow in a container at rest around a body that moves with `translation + rotation x r`.
pub fn solve_rigid(mesh: &TetMesh, body: u16, translation: Vec3, rotation: Vec3) -> Flow {
    let mut velocity = vec![0.0; 3 * mesh.n_points()];
    for node in mesh.nodes_on(body) {
        let u = translation + rotation.cross(&mesh.points()[node as usize]);
        velocity[3 * node as usize..][..3].copy_from_slice(u.as_slice());
    }
    let loads = vec![0.0; velocity.len()];
    solve(mesh, velocity, &loads)
}

pub fn apply(divergence: &Csr3, velocity: &[f64]) -> Vec<f64> {
    let row = |row: sprs::CsVecViewI<[f64; 3], u32>| -> f64 {
        row.iter()
            .map(|(j, b)| dot(b, &velocity[3 * j..3 * j + 3]))
            .sum()
    };
    divergence.outer_iterator().map(row).collect()
}

/// The factored stiffness of the free nodes.
struct Inner<'a> {
    free: &'a [usize],
    factor: Llt<usize, f64>,
}

impl<'a> Inner<'a> {
    fn new(stiffness: &Csr, free: &'a [usize]) -> Self {
        let mut number = vec![None; stiffness.rows()];
        for (k, &i) in free.iter().enumerate() {
            number[i] = Some(k);
        }
        let mut triplets = Vec::new();
        for (&value, (i, j)) in stiffness.iter() {
            if let (Some(i), Some(j)) = (number[i as usize], number[j as usize])
                && j <= i
            {
                triplets.push(Triplet::new(i, j, value));
            }
        }
        let matrix =
            SparseColMat::try_new_from_triplets(free.len(), free.len(), &triplets).unwrap();
        Self {
            free,
            factor: matrix.sp_cholesky(Side::Lower).unwrap(),
        }
    }

    /// `K^-1` on the free nodes, zero on the others.
    fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let mut x = Mat::from_fn(self.free.len(), 3, |k, c| rhs[3 * self.free[k] + c]);
        self.factor.solve_in_place(x.as_mut());
        let mut result = vec![0.0; rhs.len()];
        for (k, &i) in self.free.iter().enumerate() {
            for c in 0..3 {
                result[3 * i + c] = x[(k, c)];
            }
        }
        result
    }
}
