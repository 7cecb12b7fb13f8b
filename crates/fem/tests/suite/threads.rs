//! Results are bitwise the same for one thread and for several.

use crate::support::meshes::{BODY, curved_shell};
use crate::support::{interleaved, noise_field, noise_vector};
use fem::{
    TaylorHood, consistent_load, continuity_residual, dissipation, load_vector, momentum_residual,
    stress_load,
};
use mesh::Vec3;

/// Bits of all parallel results of this crate, computed with `threads` threads.
fn everything(threads: usize) -> Vec<u64> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        // Enough cells for several tasks in every parallel loop.
        let mesh = curved_shell(5, 3.0);
        let space = TaylorHood::new(&mesh).unwrap();
        let (k, b) = (
            space.stiffness(&mesh).unwrap(),
            space.divergence(&mesh).unwrap(),
        );
        let (u, p) = (
            noise_field(1, mesh.n_points()),
            noise_vector(2, mesh.n_vertices()),
        );
        let residual = momentum_residual(&k, &b, &u, &p).unwrap();
        let mut numbers = vec![dissipation(&mesh, &u).unwrap()];
        for load in [
            consistent_load(&mesh, BODY, &residual, Vec3::x(), Vec3::y()).unwrap(),
            stress_load(&mesh, BODY, &u, &p, Vec3::x()).unwrap(),
        ] {
            numbers.extend(load.force.iter().chain(&load.torque));
        }
        numbers.extend(interleaved(&residual));
        numbers.extend(continuity_residual(&b, &u).unwrap());
        numbers.extend(interleaved(&load_vector(&mesh, |x| x * x.y).unwrap()));
        numbers.extend(b.data().as_flattened());
        for matrix in [
            k,
            space.vertex_stiffness(&mesh).unwrap(),
            space
                .vertex_elasticity(&mesh, &vec![1.5; mesh.n_cells()], 0.5)
                .unwrap(),
            space.pressure_mass(&mesh).unwrap(),
            space.velocity_mass(&mesh).unwrap(),
            space.viscous_block(&mesh).unwrap(),
        ] {
            numbers.extend(matrix.data());
            numbers.extend(matrix.indices().iter().map(|&column| f64::from(column)));
        }
        let all = space.matrices(&mesh).unwrap();
        assert_eq!(all.stiffness, space.stiffness(&mesh).unwrap());
        assert_eq!(all.divergence, space.divergence(&mesh).unwrap());
        assert_eq!(all.pressure_mass, space.pressure_mass(&mesh).unwrap());
        assert_eq!(all.vertex_stiffness, space.vertex_stiffness(&mesh).unwrap());
        assert_eq!(
            all.interpolation,
            space.vertex_interpolation(&mesh).unwrap()
        );
        numbers.into_iter().map(f64::to_bits).collect()
    })
}

#[test]
fn results_are_bitwise_the_same_for_any_number_of_threads() {
    let one = everything(1);
    for threads in [2, 3] {
        assert!(
            one == everything(threads),
            "{threads} threads differ from one"
        );
    }
}
