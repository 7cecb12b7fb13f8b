//! Stokes flow with Dirichlet data.
//!
//! The stiffness matrix is factorised (sparse Cholesky); conjugate gradients solve for the pressure
//! with its Schur complement.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::Llt;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use fem::{DirichletCondition, TaylorHood, continuity_residual, momentum_residual};
use linalg::{Csr, Csr3};
use mesh::{TetMesh, Vec3};

use super::dot;

/// A discrete flow and the matrices over all nodes.
pub struct Flow {
    pub stiffness: Csr,
    pub divergence: Csr3,
    pub velocity: Vec<Vec3>,
    pub pressure: Vec<f64>,
}

/// Discrete flow with the boundary values of `velocity`, driven by nodal loads.
pub fn solve(mesh: &TetMesh, mut velocity: Vec<Vec3>, loads: &[Vec3]) -> Flow {
    let space = TaylorHood::new(mesh).unwrap();
    let stiffness = space.stiffness(mesh).unwrap();
    let divergence = space.divergence(mesh).unwrap();
    let mass = space.pressure_mass(mesh).unwrap().diag().to_dense();

    let condition = DirichletCondition::on_boundary(mesh);
    condition.lift(&mut velocity).unwrap();
    let interior = Interior::new(&stiffness, &condition);

    // u = u_D + K^-1 (g - B^T p) with g = f - K u_D. Then B u = 0 reads
    // (B K^-1 B^T) p = B (u_D + K^-1 g).
    let zero = vec![0.0; mesh.n_vertices()];
    let image = momentum_residual(&stiffness, &divergence, &velocity, &zero).unwrap();
    let mut particular = interior.solve(&condition.rhs(loads, &image).unwrap());
    particular
        .iter_mut()
        .zip(&velocity)
        .for_each(|(u, v)| *u += v);
    let at_rest = vec![Vec3::zeros(); velocity.len()];
    let gradient = |p: &[f64]| {
        let image = momentum_residual(&stiffness, &divergence, &at_rest, p).unwrap();
        condition.restrict(&image).unwrap()
    };
    let apply = |u: &[Vec3]| continuity_residual(&divergence, u).unwrap();

    let mut r = apply(&particular);
    let mut pressure = zero;
    let precondition =
        |r: &[f64]| -> Vec<f64> { r.iter().zip(mass.iter()).map(|(r, m)| r / m).collect() };
    let mut z = precondition(&r);
    let mut d = z.clone();
    let mut rho = dot(&r, &z);
    let first = rho;
    for iteration in 0.. {
        // The error of the velocity is of the size of the square root of this number, 1e-14.
        if rho <= 1e-28 * first {
            break;
        }
        assert!(
            iteration < 300,
            "pressure iteration stagnates at {:e}",
            rho / first
        );
        let s = apply(&interior.solve(&gradient(&d)));
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
    let correction = interior.solve(&gradient(&pressure));
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

/// Flow in a container at rest around a body with the velocity `translation + rotation × x`.
pub fn solve_rigid(mesh: &TetMesh, body: u16, translation: Vec3, rotation: Vec3) -> Flow {
    let mut velocity = vec![Vec3::zeros(); mesh.n_points()];
    for node in mesh.nodes_on(body) {
        let node = node as usize;
        velocity[node] = translation + rotation.cross(&mesh.points()[node]);
    }
    let loads = vec![Vec3::zeros(); velocity.len()];
    solve(mesh, velocity, &loads)
}

/// Factorised stiffness matrix of the free nodes.
struct Interior<'a> {
    condition: &'a DirichletCondition,
    n_nodes: usize,
    factor: Llt<usize, f64>,
}

impl<'a> Interior<'a> {
    fn new(stiffness: &Csr, condition: &'a DirichletCondition) -> Self {
        let mut triplets = Vec::new();
        for (&value, (i, j)) in condition.restrict_matrix(stiffness, 1).unwrap().iter() {
            if j <= i {
                triplets.push(Triplet::new(i as usize, j as usize, value));
            }
        }
        let n = condition.n_free();
        let matrix = SparseColMat::try_new_from_triplets(n, n, &triplets).unwrap();
        Self {
            condition,
            n_nodes: stiffness.rows(),
            factor: matrix.sp_cholesky(Side::Lower).unwrap(),
        }
    }

    /// `K^-1` at the free nodes, zero at the others.
    fn solve(&self, rhs: &[f64]) -> Vec<Vec3> {
        let n = self.condition.n_free();
        let mut x = Mat::from_fn(n, 3, |k, c| rhs[3 * k + c]);
        self.factor.solve_in_place(x.as_mut());
        let values: Vec<f64> = (0..3 * n).map(|i| x[(i / 3, i % 3)]).collect();
        let mut result = vec![Vec3::zeros(); self.n_nodes];
        self.condition.expand(&values, &mut result).unwrap();
        result
    }
}
