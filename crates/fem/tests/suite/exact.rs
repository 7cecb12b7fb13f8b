//! Flows in the finite element space are reproduced to rounding; integrals of polynomials are
//! exact.

use crate::support::meshes::{BODY, curved_shell, random_affine, straight_shell};
use crate::support::{noise, stokes};
use fem::{
    TaylorHood, field_error, load_vector, mean_pressure, pressure_error, stress_load,
    surface_measures,
};
use mesh::{LinearTets, TetMesh, Vec3};
use nalgebra::Matrix3;

/// Divergence-free quadratic velocity and linear pressure with random coefficients.
///
/// `u_c = a_c + G_ck x_k + x · Q_c x` with symmetric `Q_c`, so that `Δu_c = 2 tr Q_c`. The entries
/// `G_zz` and `(Q_z)_zk` make the divergence `tr G + 2 sum_ck (Q_c)_ck x_k` zero.
struct Polynomial {
    constant: Vec3,
    linear: Matrix3<f64>,
    quadratic: [Matrix3<f64>; 3],
    pressure_gradient: Vec3,
}

impl Polynomial {
    fn random(seed: u64) -> Self {
        let vector = |at: usize| Vec3::from_fn(|i, _| noise(seed, at + i));
        let matrix = |at: usize| Matrix3::from_fn(|i, j| noise(seed, at + 3 * i + j));
        let mut linear = matrix(10);
        linear[(2, 2)] = -linear[(0, 0)] - linear[(1, 1)];
        let mut quadratic = [20, 30, 40].map(|at| matrix(at) + matrix(at).transpose());
        for k in 0..3 {
            let value = -quadratic[0][(0, k)] - quadratic[1][(1, k)];
            quadratic[2][(2, k)] = value;
            quadratic[2][(k, 2)] = value;
        }
        Self {
            constant: vector(0),
            linear,
            quadratic,
            pressure_gradient: vector(50),
        }
    }

    fn velocity(&self, x: Vec3) -> (Vec3, Matrix3<f64>) {
        let mut u = self.constant + self.linear * x;
        let mut gradient = self.linear;
        for c in 0..3 {
            let qx = self.quadratic[c] * x;
            u[c] += x.dot(&qx);
            for k in 0..3 {
                gradient[(c, k)] += 2.0 * qx[k];
            }
        }
        (u, gradient)
    }

    fn pressure(&self, x: Vec3) -> f64 {
        self.pressure_gradient.dot(&x)
    }

    /// Divergence of the stress, `Δu - ∇p`, which is constant.
    fn stress_divergence(&self) -> Vec3 {
        Vec3::from_fn(|c, _| 2.0 * self.quadratic[c].trace()) - self.pressure_gradient
    }

    fn nodal_velocity(&self, mesh: &TetMesh) -> Vec<Vec3> {
        mesh.points().iter().map(|&x| self.velocity(x).0).collect()
    }

    fn nodal_pressure(&self, mesh: &TetMesh) -> Vec<f64> {
        mesh.points()[..mesh.n_vertices()]
            .iter()
            .map(|&x| self.pressure(x))
            .collect()
    }
}

#[test]
fn quadratic_velocity_and_linear_pressure_are_reproduced_on_random_affine_meshes() {
    for (n, seed) in [(2, 1), (2, 2), (3, 3)] {
        let mesh = random_affine(n, seed);
        let exact = Polynomial::random(seed);
        // -Δu + ∇p = f: the load vector of the constant f is f ∫ N_i.
        let mass = TaylorHood::new(&mesh)
            .unwrap()
            .velocity_mass(&mesh)
            .unwrap();
        let mut loads = Vec::new();
        for row in mass.outer_iterator() {
            let integral: f64 = row.data().iter().sum();
            loads.push(-integral * exact.stress_divergence());
        }
        let flow = stokes::solve(&mesh, exact.nodal_velocity(&mesh), &loads);
        let error = field_error(&mesh, &flow.velocity, |x| exact.velocity(x)).unwrap();
        assert!(error.l2 < 1e-10 && error.h1_seminorm < 1e-10, "{error:?}");
        let error = pressure_error(&mesh, &flow.pressure, |x| exact.pressure(x)).unwrap();
        assert!(error < 1e-10, "{error}");
    }
}

/// Unit cube divided into `n` cubes in each direction.
fn cube(n: u32) -> TetMesh {
    TetMesh::straight(LinearTets::cube(n)).unwrap()
}

#[test]
fn error_norms_measure_a_known_difference() {
    // u_h = (x, 0, 0) against 0 on the unit cube: ∫ |u|^2 = 1/3, ∫ |∇u|^2 = 1. The variance of
    // p_h = x is 1/12.
    let mesh = cube(2);
    let u: Vec<Vec3> = mesh
        .points()
        .iter()
        .map(|x| Vec3::new(x.x, 0.0, 0.0))
        .collect();
    let p: Vec<f64> = mesh.points()[..mesh.n_vertices()]
        .iter()
        .map(|x| x.x)
        .collect();
    let zero = |_| (Vec3::zeros(), Matrix3::zeros());
    let error = field_error(&mesh, &u, zero).unwrap();
    assert!((error.l2 - (1f64 / 3.0).sqrt()).abs() < 1e-14);
    assert!((error.h1_seminorm - 1.0).abs() < 1e-14);
    assert!((pressure_error(&mesh, &p, |_| 0.0).unwrap() - (1f64 / 12.0).sqrt()).abs() < 1e-14);
    assert!((mean_pressure(&mesh, &p).unwrap() - 0.5).abs() < 1e-14);
    // 2 D:D of (x, 0, 0) is 2.
    assert!((fem::dissipation(&mesh, &u).unwrap() - 2.0).abs() < 1e-14);
}

#[test]
fn load_vectors_of_quartic_forces_are_exact_on_affine_cells() {
    let mesh = cube(2);
    let force = |x: Vec3| Vec3::new(x.x.powi(4), (x.x * x.y).powi(2), x.y * x.z.powi(3));
    let velocity = |x: &Vec3| Vec3::new(x.y * x.z, x.x * x.x, x.z * x.z);
    let load = load_vector(&mesh, force).unwrap();
    let powers = load
        .iter()
        .zip(mesh.points())
        .map(|(f, x)| f.dot(&velocity(x)));
    // ∫ x^4 y z = 1/20, ∫ x^4 y^2 = 1/15 and ∫ y z^5 = 1/12 on the unit cube.
    assert!((powers.sum::<f64>() - 0.2).abs() < 1e-14);
}

#[test]
fn load_vectors_of_smooth_forces_have_the_order_of_the_rule() {
    // The sum of the load vector is the integral of the force. A rule of degree 6 is of order 7; on
    // this mesh, which is symmetric about the centre of each cube, of order 8.
    let exact = (1f64.exp() - 1.0).powi(3);
    let error = |n: u32| {
        let force = |x: Vec3| Vec3::x() * (x.x + x.y + x.z).exp();
        let load = load_vector(&cube(n), force).unwrap();
        load.iter().map(|f| f.x).sum::<f64>() - exact
    };
    let order = (error(1) / error(2)).abs().log2();
    assert!((order - 8.0).abs() < 0.5, "order {order}");
}

#[test]
fn surface_stress_of_a_polynomial_flow_equals_the_integral_of_its_divergence() {
    // On flat facets, with n into the body: ∮ σ n = -|B_h| ∇·σ and
    // ∮ (x - c) × σ n = -|B_h| (x_B - c) × ∇·σ.
    let mesh = straight_shell(2, 3.0);
    let exact = Polynomial::random(7);
    let (u, p) = (exact.nodal_velocity(&mesh), exact.nodal_pressure(&mesh));
    let centre = Vec3::new(0.3, -0.2, 0.5);
    let load = stress_load(&mesh, BODY, &u, &p, centre).unwrap();
    let body = surface_measures(&mesh, BODY).unwrap();
    let force = -body.volume * exact.stress_divergence();
    assert!(
        (load.force - force).norm() < 1e-12,
        "{} {force}",
        load.force
    );
    let arm = body.centroid - centre;
    assert!((load.torque - arm.cross(&force)).norm() < 1e-12);
}

#[test]
fn the_container_volume_is_that_of_body_and_fluid_on_curved_cells() {
    let mesh = curved_shell(2, 3.0);
    let [body, container] = [0, 1].map(|tag| surface_measures(&mesh, tag).unwrap().volume);
    assert!((container - body - mesh.volume()).abs() < 1e-12 * container);
}
