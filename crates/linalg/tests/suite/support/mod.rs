//! Systems, right-hand sides and residuals shared by several tests.

mod borders;
pub mod system;
mod three_spheres;
mod vectors;

use linalg::Csr;

pub use borders::{chained, linked_pair, prolongation_for, with_border};
pub use system::{Stokes, body_forces, cube, one_body};
pub use three_spheres::three_spheres;
pub use vectors::{
    Method, assert_same_on_one_and_two_threads, assert_velocities_agree, direct_solution, dot,
    noise, relative_difference, tolerance, true_residual,
};

/// Two bodies, an eighth of the cube wide, in a cube of `8 k` cells per side.
pub fn two_bodies(k: usize) -> Stokes {
    let bodies = [[2, 3, 3], [5, 4, 4]].map(|low| cube(low.map(|l| l * k), k));
    Stokes::new(8 * k, &bodies, 8.0)
}

/// The P1 stiffness matrix of the free vertices, `P^T K P`.
pub fn coarse_stiffness(stokes: &Stokes) -> Csr {
    let (k, p) = (
        stokes.system.velocity_block().stiffness(),
        stokes.prolongation.nodes(),
    );
    &(&p.transpose_view().to_csr() * k) * p
}
