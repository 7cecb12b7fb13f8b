//! Heat conduction in the unit cube with Neumann and Robin data, by the Crank-Nicolson method.
//!
//! `∂u/∂t - Δu = f`, with `∂u/∂n = g` on five sides and `∂u/∂n + α u = r` on the side `z = 1`.
//! Theory: order 2 in time, 3 in L2 in space. Each is measured with a solution `u = T(t) X(x)` for
//! which the other error is zero: a quadratic `X`, and a linear `T`.

use std::error::Error;

use fem::nalgebra::Vector3;
use fem::{FemError, TaylorHood, assemble_facet_load, field_error, interpolate, load_vector};
use linalg::{CsrOperator, KrylovParams, MultigridParams, ScalarMultigrid, cg};
use mesh::{LinearTets, TetMesh};

mod orders;

/// Heat transfer coefficient of the Robin condition.
const ALPHA: f64 = 2.0;

/// A solution `T(t) X(x)`.
struct Exact {
    /// `T` and its derivative.
    time: fn(f64) -> [f64; 2],
    /// `X`, its gradient and its Laplacian.
    space: fn(Vector3<f64>) -> (f64, Vector3<f64>, f64),
}

impl Exact {
    /// Load vector of `f`, `g` and `r` at time `t`.
    fn load(&self, mesh: &TetMesh, t: f64) -> Result<Vec<f64>, FemError> {
        let [value, rate] = (self.time)(t);
        let mut load = load_vector(mesh, |x| {
            let (u, _, laplacian) = (self.space)(x);
            rate * u - value * laplacian
        })?;
        for (tag, name) in (0u16..).zip(mesh.tags()) {
            let alpha = if name == "z1" { ALPHA } else { 0.0 };
            let of_side = assemble_facet_load(mesh, tag, 6, |facet, load: &mut [f64; 10]| {
                let (u, gradient, _) = (self.space)(facet.point.position());
                let data = value * (gradient.dot(&facet.normal) + alpha * u);
                facet.point.add_load(load, |v| data * v.value);
            })?;
            (load.iter_mut().zip(of_side)).for_each(|(sum, value)| *sum += value);
        }
        Ok(load)
    }

    /// Error in L2 at time 1 with `6 n^3` cells and this number of time steps.
    fn error(&self, n: u32, steps: u32) -> Result<f64, Box<dyn Error>> {
        let mesh = TetMesh::straight(LinearTets::cube(n))?;
        let space = TaylorHood::new(&mesh)?;
        let robin = space.assemble_facets(
            &mesh,
            mesh.tag("z1")?,
            4,
            |facet, matrix: &mut [[f64; 10]; 10]| {
                facet.point.add(matrix, |v, u| ALPHA * v.value * u.value);
            },
        )?;
        let (mass, conduction) = (
            space.velocity_mass(&mesh)?,
            &space.stiffness(&mesh)? + &robin,
        );
        // (M + dt/2 A) u_1 = (M - dt/2 A) u_0 + dt/2 (f_0 + f_1)
        let half = 0.5 / f64::from(steps);
        let implicit = CsrOperator::new(&mass + &conduction.map(|a| half * a))?;
        let explicit = &mass - &conduction.map(|a| half * a);
        let mut multigrid = ScalarMultigrid::new(&implicit, &MultigridParams::default())?;
        let params = KrylovParams::default().with_rel_tol(1e-10);

        let at_start = (self.time)(0.0)[0];
        let mut u = interpolate::<_, 10>(&mesh, |x| at_start * (self.space)(x).0)?;
        let mut load = self.load(&mesh, 0.0)?;
        for step in 1..=steps {
            let next_load = self.load(&mesh, f64::from(step) * 2.0 * half)?;
            let rhs: Vec<f64> = (explicit.outer_iterator().enumerate())
                .map(|(i, row)| row.dot(&u) + half * (load[i] + next_load[i]))
                .collect();
            cg(&implicit, &mut multigrid, &rhs, &mut u, &params)?;
            load = next_load;
        }
        let at_end = (self.time)(1.0)[0];
        let exact = |x| {
            let (u, gradient, _) = (self.space)(x);
            (at_end * u, at_end * gradient)
        };
        Ok(field_error(&mesh, &u, exact)?.l2)
    }
}

/// Prints the errors and orders in time and in space and checks the orders.
pub fn main() -> Result<(), Box<dyn Error>> {
    let quadratic = Exact {
        time: |t| [(2.0 * t).cos(), -2.0 * (2.0 * t).sin()],
        space: |x| {
            (
                x.x * x.x + x.y * x.z,
                Vector3::new(2.0 * x.x, x.z, x.y),
                2.0,
            )
        },
    };
    let [time] = orders::print_orders(["L2"], &[4, 8, 16], |steps| {
        Ok([quadratic.error(2, steps)?])
    })?;
    assert!((time - 2.0).abs() < 0.1, "order in time: {time}");

    let linear = Exact {
        time: |t| [1.0 + t, 1.0],
        space: |x| {
            let (k, u) = (
                Vector3::new(2.0, -1.0, 3.0),
                (2.0 * x.x - x.y + 3.0 * x.z).exp(),
            );
            (u, u * k, u * k.norm_squared())
        },
    };
    let [space] = orders::print_orders(["L2"], &[2, 4, 8], |n| Ok([linear.error(n, 2)?]))?;
    assert!((space - 3.0).abs() < 0.2, "order in space: {space}");
    Ok(())
}
