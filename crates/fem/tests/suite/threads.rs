//! Results are bitwise the same for one thread and for several.

use crate::support::meshes::{BODY, curved_shell};
use crate::support::{interleaved, noise_field, noise_vector};
use fem::{
    TaylorHood, consistent_load, continuity_residual, dissipation, integrate, integrate_facets,
    load_vector, momentum_residual, stress_load,
};
use mesh::Vec3;
use nalgebra::Matrix3;

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
        // More cells than a batch of element matrices of one or two threads.
        let blocks = space.assemble(&mesh, 5, |q, m: &mut [[Matrix3<f64>; 10]; 10]| {
            let u = q.value(&u);
            q.add(m, |a, b| a.value * u * b.gradient.transpose());
        });
        numbers.extend(blocks.unwrap().data().as_flattened().as_flattened());
        let facets = space.assemble_facets(&mesh, BODY, 5, |f, m: &mut [[f64; 4]; 10]| {
            f.point.add(m, |a, b| a.gradient.x * b.value);
        });
        numbers.extend(facets.unwrap().data());
        numbers.push(integrate(&mesh, 8, |q| q.value(&p).exp()).unwrap());
        numbers.push(integrate_facets(&mesh, BODY, 8, |f| f.point.value(&p).exp()).unwrap());
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
