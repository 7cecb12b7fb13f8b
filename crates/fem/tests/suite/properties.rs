//! Properties for every mesh and field: symmetry, null spaces, adjointness, identities of matrices.

use crate::support::meshes::{BODY, curved_shell, random_affine};
use crate::support::{dot, interleaved, nodal, noise, noise_field, noise_vector};
use fem::{TaylorHood, continuity_residual, dissipation, momentum_residual, surface_measures};
use linalg::Csr;
use mesh::{TetMesh, Vec3};
use proptest::prelude::*;

/// Shell whose cells are all curved: each coordinate of each node is moved by up to 0.02.
fn bent_shell(seed: u64) -> TetMesh {
    let mesh = curved_shell(2, 3.0);
    let points = mesh.points().iter().enumerate();
    let moved = points.map(|(i, x)| x + Vec3::from_fn(|c, _| 0.02 * noise(seed, 3 * i + c)));
    mesh.with_points(moved.collect()).unwrap()
}

/// Strategy for affine, mixed and curved meshes.
fn meshes() -> impl Strategy<Value = TetMesh> {
    prop_oneof![
        any::<u64>().prop_map(|seed| random_affine(2, seed)),
        Just(curved_shell(2, 3.0)),
        any::<u64>().prop_map(bent_shell),
    ]
}

fn product(matrix: &Csr, x: &[f64]) -> Vec<f64> {
    let row = |row: sprs::CsVecViewI<f64, u32>| row.iter().map(|(j, a)| a * x[j]).sum();
    matrix.outer_iterator().map(row).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |a, b| b.abs().max(a))
}

/// Largest entry of `a - b` relative to the largest of `a`; the patterns must be equal.
fn difference(a: &Csr, b: &Csr) -> f64 {
    assert_eq!(
        (a.indptr().raw_storage(), a.indices()),
        (b.indptr().raw_storage(), b.indices())
    );
    let gap: Vec<f64> = a.data().iter().zip(b.data()).map(|(a, b)| a - b).collect();
    largest(&gap) / largest(a.data())
}

fn is_symmetric(a: &Csr) -> bool {
    difference(a, &a.transpose_view().to_csr()) < 1e-14
}

fn on_boundary(mesh: &TetMesh) -> Vec<bool> {
    let mut boundary = vec![false; mesh.n_points()];
    for node in mesh.facets().iter().flat_map(|facet| facet.nodes) {
        boundary[node as usize] = true;
    }
    boundary
}

/// Rounding of the sum of a row: at most a few hundred entries, each from at most a few dozen
/// cells.
const ROUNDING: f64 = 1e-12;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn stiffness_is_symmetric_and_zero_for_constants(mesh in meshes()) {
        let space = TaylorHood::new(&mesh).unwrap();
        for k in [space.stiffness(&mesh).unwrap(), space.vertex_stiffness(&mesh).unwrap()] {
            prop_assert!(is_symmetric(&k));
            prop_assert!(largest(&product(&k, &vec![1.0; k.cols()])) < ROUNDING * largest(k.data()));
        }
    }

    #[test]
    fn vertex_elasticity_is_the_viscous_form_of_linear_fields_plus_the_divergence(mesh in meshes(), seed in any::<u64>()) {
        let space = TaylorHood::new(&mesh).unwrap();
        let ones = vec![1.0; mesh.n_cells()];
        let plain = space.vertex_elasticity(&mesh, &ones, 0.0).unwrap();
        let stiff = space.vertex_elasticity(&mesh, &vec![2.0; mesh.n_cells()], 0.7).unwrap();
        prop_assert!(is_symmetric(&plain) && is_symmetric(&stiff));
        let n = mesh.n_vertices();
        let spin = noise_vector(seed, 3);
        let rotation: Vec<f64> = mesh.points()[..n]
            .iter()
            .flat_map(|x| <[f64; 3]>::from(Vec3::from_column_slice(&spin).cross(x)))
            .collect();
        // On curved cells the midside nodes do not follow the rotation of the vertices.
        if (0..mesh.n_cells()).all(|cell| mesh.is_affine(cell)) {
            prop_assert!(largest(&product(&stiff, &rotation)) < ROUNDING * largest(stiff.data()));
        }
        // The energy is that of the viscous form for the interpolated field.
        let u = noise_vector(seed, 3 * n);
        let interpolation = space.vertex_interpolation(&mesh).unwrap();
        let mut fine = vec![0.0; 3 * mesh.n_points()];
        for c in 0..3 {
            let component: Vec<f64> = u.iter().skip(c).step_by(3).copied().collect();
            for (i, value) in product(&interpolation, &component).into_iter().enumerate() {
                fine[3 * i + c] = value;
            }
        }
        let viscous = space.viscous_block(&mesh).unwrap();
        let (energy, expected) = (dot(&u, &product(&plain, &u)), dot(&fine, &product(&viscous, &fine)));
        prop_assert!((energy - expected).abs() < ROUNDING * expected);
        // Uniform expansion: 2 D:D = 6 and (∇·u)^2 = 9.
        if (0..mesh.n_cells()).all(|cell| mesh.is_affine(cell)) {
            let x: Vec<f64> = mesh.points()[..n].iter().flat_map(|x| <[f64; 3]>::from(*x)).collect();
            let expected = 2.0 * (6.0 + 0.7 * 9.0) * mesh.volume();
            prop_assert!((dot(&x, &product(&stiff, &x)) - expected).abs() < ROUNDING * expected);
        }
    }

    #[test]
    fn vertex_stiffness_is_the_galerkin_product(mesh in meshes()) {
        let space = TaylorHood::new(&mesh).unwrap();
        let interpolation = space.vertex_interpolation(&mesh).unwrap();
        let k = space.stiffness(&mesh).unwrap();
        let vertex = space.vertex_stiffness(&mesh).unwrap();
        for seed in 0..3 {
            let x = noise_vector(seed, mesh.n_vertices());
            let long = product(&interpolation.transpose_view().to_csr(), &product(&k, &product(&interpolation, &x)));
            let short = product(&vertex, &x);
            let gap: Vec<f64> = long.iter().zip(&short).map(|(a, b)| a - b).collect();
            prop_assert!(largest(&gap) < ROUNDING * largest(k.data()));
        }
    }

    #[test]
    fn vertex_stiffness_is_linear_in_its_coefficient(mesh in meshes(), seed: u64) {
        let space = TaylorHood::new(&mesh).unwrap();
        let (c, d) = (noise_vector(seed, mesh.n_cells()), noise_vector(!seed, mesh.n_cells()));
        let weighted = |c: &[f64]| space.weighted_vertex_stiffness(&mesh, c).unwrap();
        let one = vec![1.0; mesh.n_cells()];
        prop_assert_eq!(weighted(&one), space.vertex_stiffness(&mesh).unwrap());
        let sum: Vec<f64> = c.iter().zip(&d).map(|(c, d)| c + 2.0 * d).collect();
        let (kc, kd) = (weighted(&c), weighted(&d));
        let mut expected = kc.clone();
        for (value, extra) in expected.data_mut().iter_mut().zip(kd.data()) {
            *value += 2.0 * extra;
        }
        prop_assert!(difference(&expected, &weighted(&sum)) < ROUNDING);
    }

    #[test]
    fn divergence_of_constants_and_interior_column_sums_are_zero(mesh in meshes()) {
        let space = TaylorHood::new(&mesh).unwrap();
        let b = space.divergence(&mesh).unwrap();
        let scale = b.data().iter().map(|b| largest(b)).fold(0.0, f64::max);
        let constant = vec![Vec3::new(1.0, -2.0, 0.5); mesh.n_points()];
        prop_assert!(largest(&continuity_residual(&b, &constant).unwrap()) < ROUNDING * scale);

        let mut sums = vec![[0.0; 3]; mesh.n_points()];
        for (value, (_, j)) in b.iter() {
            for c in 0..3 {
                sums[j as usize][c] += value[c];
            }
        }
        for (sum, boundary) in sums.iter().zip(on_boundary(&mesh)) {
            prop_assert!(boundary || largest(sum) < ROUNDING * scale);
        }
        // The divergence of the position is 3, so -B x is three times the integral of each pressure
        // function.
        let mass = space.pressure_mass(&mesh).unwrap();
        let integrals = product(&mass, &vec![1.0; mesh.n_vertices()]);
        for (b, integral) in continuity_residual(&b, mesh.points()).unwrap().iter().zip(&integrals) {
            prop_assert!((b + 3.0 * integral).abs() < ROUNDING);
        }
    }

    #[test]
    fn mass_matrices_are_symmetric_positive_definite_and_sum_to_the_volume(mesh in meshes(), seed: u64) {
        let space = TaylorHood::new(&mesh).unwrap();
        // On curved cells the rule of the quadratic mass matrix is one degree short, but the sum of
        // the entries is the integral of the Jacobian, of degree 3, and exact.
        for m in [space.pressure_mass(&mesh).unwrap(), space.velocity_mass(&mesh).unwrap()] {
            prop_assert!(is_symmetric(&m));
            let sum: f64 = m.data().iter().sum();
            prop_assert!((sum - mesh.volume()).abs() < ROUNDING * mesh.volume());
            let x = noise_vector(seed, m.rows());
            prop_assert!(dot(&x, &product(&m, &x)) > 0.0);
        }
    }

    #[test]
    fn viscous_matrix_is_symmetric_zero_for_rigid_motions_and_gives_the_dissipation(mesh in meshes(), seed: u64) {
        let space = TaylorHood::new(&mesh).unwrap();
        let viscous = space.viscous_block(&mesh).unwrap();
        prop_assert!(is_symmetric(&viscous));
        let motion = |x: &Vec3| <[f64; 3]>::from(Vec3::new(1.0, -2.0, 0.5) + Vec3::new(0.3, 0.7, -1.0).cross(x));
        let rigid: Vec<f64> = mesh.points().iter().flat_map(motion).collect();
        prop_assert!(largest(&product(&viscous, &rigid)) < ROUNDING * largest(viscous.data()) * largest(&rigid));
        let u = noise_vector(seed, viscous.rows());
        let power = dot(&u, &product(&viscous, &u));
        prop_assert!((dissipation(&mesh, &nodal(&u)).unwrap() / power - 1.0).abs() < ROUNDING);
    }

    /// `∫ 2 D(u):D(v) = ∫ ∇u:∇v + ∫ ∇·u ∇·v + 2 |B_h| ω · Ω` for all fields that are rigid on the
    /// body and zero on the container, on curved cells too.
    #[test]
    fn grad_grad_identity(seed: u64, bent: bool) {
        let mesh = if bent { bent_shell(seed) } else { curved_shell(2, 3.0) };
        let space = TaylorHood::new(&mesh).unwrap();
        let (k, viscous) = (space.stiffness(&mesh).unwrap(), space.viscous_block(&mesh).unwrap());
        let vector = |at: usize| Vec3::from_fn(|i, _| noise(seed, at + i));
        let field = |seed: u64, translation: Vec3, rotation: Vec3| {
            let mut u = noise_vector(seed, 3 * mesh.n_points());
            for (i, boundary) in on_boundary(&mesh).into_iter().enumerate() {
                if boundary {
                    u[3 * i..3 * i + 3].fill(0.0);
                }
            }
            for node in mesh.nodes_on(BODY) {
                let rigid = translation + rotation.cross(&mesh.points()[node as usize]);
                u[3 * node as usize..][..3].copy_from_slice(rigid.as_slice());
            }
            u
        };
        let (omega_u, omega_v) = (vector(3), vector(9));
        let (u, v) = (field(seed, vector(0), omega_u), field(!seed, vector(6), omega_v));

        let component = |u: &[f64], c: usize| u.iter().skip(c).step_by(3).copied().collect::<Vec<f64>>();
        let grad_grad: f64 = (0..3).map(|c| dot(&component(&v, c), &product(&k, &component(&u, c)))).sum();
        let twice_dd = dot(&v, &product(&viscous, &u));
        // Block (i, j) of the viscous matrix is k_ij I + ∇N_j ∇N_i^T; that of ∇·u ∇·v is ∇N_i
        // ∇N_j^T, the transpose minus the stiffness.
        let transposed: f64 = viscous
            .iter()
            .map(|(value, (row, column))| {
                let (i, c, j, d) = (row as usize / 3, row as usize % 3, column as usize / 3, column as usize % 3);
                v[3 * i + d] * value * u[3 * j + c]
            })
            .sum();
        let div_div = transposed - grad_grad;
        let volume = surface_measures(&mesh, BODY).unwrap().volume;
        let rotational = 2.0 * volume * omega_u.dot(&omega_v);
        let scale = (dot(&u, &product(&viscous, &u)) * dot(&v, &product(&viscous, &v))).sqrt();
        let gap = twice_dd - (grad_grad + div_div + rotational);
        prop_assert!(gap.abs() < 1e-12 * scale, "{} of {}", gap, scale);
        // The rotational term is far above the tolerance, so the identity fails without it.
        prop_assert!(rotational.abs() > 1e-8 * scale || omega_u.dot(&omega_v).abs() < 1e-6);
    }

    #[test]
    fn residual_is_the_product_of_the_matrices(mesh in meshes(), seed: u64) {
        let space = TaylorHood::new(&mesh).unwrap();
        let (k, b) = (space.stiffness(&mesh).unwrap(), space.divergence(&mesh).unwrap());
        let (u, p) = (noise_field(seed, mesh.n_points()), noise_vector(!seed, mesh.n_vertices()));
        let v = noise_field(seed / 2, mesh.n_points());
        let residual = momentum_residual(&k, &b, &u, &p).unwrap();
        // v · (K u + B^T p) = u · (K v) + p · (B v).
        let adjoint = momentum_residual(&k, &b, &v, &vec![0.0; p.len()]).unwrap();
        let inner = |a: &[Vec3], b: &[Vec3]| dot(&interleaved(a), &interleaved(b));
        let expected = inner(&u, &adjoint) + dot(&p, &continuity_residual(&b, &v).unwrap());
        let scale = largest(k.data()) * 3.0 * u.len() as f64;
        prop_assert!((inner(&v, &residual) - expected).abs() < ROUNDING * scale);
    }

    #[test]
    fn matrices_follow_scaling_and_rotation_of_the_mesh(mesh in meshes(), scale in 1e-6..1e6f64, angle in -3.0..3.0f64) {
        let rotation = nalgebra::Rotation3::from_axis_angle(&Vec3::z_axis(), angle);
        let moved = mesh.points().iter().map(|x| rotation * x * scale).collect();
        let moved = mesh.with_points(moved).unwrap();
        let space = TaylorHood::new(&mesh).unwrap();
        let mut k = space.stiffness(&mesh).unwrap();
        k.data_mut().iter_mut().for_each(|value| *value *= scale);
        prop_assert!(difference(&k, &space.stiffness(&moved).unwrap()) < ROUNDING);
        let (b, rotated) = (space.divergence(&mesh).unwrap(), space.divergence(&moved).unwrap());
        let entry = |b: &[f64; 3]| Vec3::from(*b);
        let size = b.data().iter().map(|b| entry(b).norm()).fold(0.0, f64::max);
        for (b, rotated) in b.data().iter().zip(rotated.data()) {
            prop_assert!((rotation * entry(b) - entry(rotated) / scale.powi(2)).norm() < ROUNDING * size);
        }
    }
}

#[test]
fn the_divergence_part_of_the_viscous_matrix_gives_the_squared_divergence() {
    // u = x has divergence 3, so with transposed blocks u · V' u - u · K u = 9 |Ω|.
    let mesh = curved_shell(2, 3.0);
    let space = TaylorHood::new(&mesh).unwrap();
    let (k, viscous) = (
        space.stiffness(&mesh).unwrap(),
        space.viscous_block(&mesh).unwrap(),
    );
    let u = interleaved(mesh.points());
    let transposed: f64 = viscous
        .iter()
        .map(|(value, (row, column))| {
            let (row, column) = (row as usize, column as usize);
            u[row - row % 3 + column % 3] * value * u[column - column % 3 + row % 3]
        })
        .sum();
    let residual = momentum_residual(
        &k,
        &space.divergence(&mesh).unwrap(),
        mesh.points(),
        &vec![0.0; mesh.n_vertices()],
    );
    let div_div = transposed - dot(&u, &interleaved(&residual.unwrap()));
    assert!((div_div / (9.0 * mesh.volume()) - 1.0).abs() < 1e-12);
}
