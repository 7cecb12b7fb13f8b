//! Linear elasticity in the unit cube with tractions on five sides, and a known solution.
//!
//! `-∇·σ = f`, `σ = μ (∇u + ∇u^T) + λ (∇·u) I`; the displacement `u = e exp(k · x)` is prescribed
//! on the side `z = 0`, the traction `σ n` on the others. Theory: order 3 in L2, 2 in H1.

use std::error::Error;

use fem::nalgebra::{Matrix3, Vector3};
use fem::{
    DirichletCondition, TaylorHood, assemble_facet_load, field_error, interleaved, interpolate,
    load_vector,
};
use linalg::{Bordered, CsrOperator, KrylovParams, Multigrid, MultigridParams, cg};
use mesh::{LinearTets, TetMesh};

mod orders;

/// Lamé parameters.
const MU: f64 = 1.0;
const LAMBDA: f64 = 1.5;

const E: Vector3<f64> = Vector3::new(1.0, 0.5, -1.0);
const K: Vector3<f64> = Vector3::new(2.0, -1.0, 1.5);

/// Exact displacement and its gradient.
fn exact(x: Vector3<f64>) -> (Vector3<f64>, Matrix3<f64>) {
    let value = K.dot(&x).exp();
    (value * E, value * E * K.transpose())
}

/// `-∇·σ = -μ Δu - (λ + μ) ∇∇·u`.
fn body_force(x: Vector3<f64>) -> Vector3<f64> {
    -K.dot(&x).exp() * (MU * K.norm_squared() * E + (LAMBDA + MU) * E.dot(&K) * K)
}

fn stress(x: Vector3<f64>) -> Matrix3<f64> {
    let gradient = exact(x).1;
    MU * (gradient + gradient.transpose()) + Matrix3::identity() * (LAMBDA * gradient.trace())
}

/// Errors in L2 and H1 with `6 n^3` cells.
fn errors(n: u32) -> Result<[f64; 2], Box<dyn Error>> {
    let mesh = TetMesh::straight(LinearTets::cube(n))?;
    let space = TaylorHood::new(&mesh)?;
    // Rows of a block are the components of the test function v, columns those of u.
    let blocks = space.assemble(&mesh, 2, |point, matrix: &mut [[Matrix3<f64>; 10]; 10]| {
        point.add(matrix, |v, u| {
            let (a, b) = (v.gradient, u.gradient);
            MU * (Matrix3::from_diagonal_element(a.dot(&b)) + b * a.transpose())
                + LAMBDA * a * b.transpose()
        });
    })?;
    let mut load = load_vector(&mesh, body_force)?;
    let clamped = mesh.tag("z0")?;
    for tag in (0..mesh.tags().len() as u16).filter(|&tag| tag != clamped) {
        let of_side = assemble_facet_load(&mesh, tag, 6, |facet, load: &mut [_; 10]| {
            let traction = stress(facet.point.position()) * facet.normal;
            facet.point.add_load(load, |v| v.value * traction);
        })?;
        (load.iter_mut().zip(of_side)).for_each(|(sum, value)| *sum += value);
    }
    let condition = DirichletCondition::on_tags(&mesh, &[clamped])?;
    let mut u = interpolate::<_, 10>(&mesh, |x| exact(x).0)?;
    let (a, rhs) = condition.reduce(&interleaved(&blocks)?, &load, &u)?;

    // The Laplacian of each component is spectrally equivalent (Korn's inequality).
    let laplacian = condition.restrict_matrix(&space.stiffness(&mesh)?, 1)?;
    let laplacian = Bordered::scalar(laplacian)?;
    let mut multigrid = Multigrid::new(&laplacian, &MultigridParams::default())?;
    let mut solution = vec![0.0; rhs.len()];
    let (a, params) = (CsrOperator::new(a)?, KrylovParams::default());
    cg(&a, &mut multigrid, &rhs, &mut solution, &params)?;

    condition.expand(&solution, &mut u)?;
    let error = field_error(&mesh, &u, exact)?;
    Ok([error.l2, error.h1_seminorm])
}

/// Prints the errors and orders and checks the orders.
pub fn main() -> Result<(), Box<dyn Error>> {
    let [l2, h1] = orders::print_orders(["L2", "H1"], &[2, 4, 8], errors)?;
    assert!((l2 - 3.0).abs() < 0.2, "order in L2: {l2}");
    assert!((h1 - 2.0).abs() < 0.2, "order in H1: {h1}");
    Ok(())
}
