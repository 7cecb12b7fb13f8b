//! Spheres whose radii change, against exact values.

use std::f64::consts::PI;

use microhydro::multipole::{self, SurfaceFlow};
use microhydro::{Accuracy, Medium, Spheres};
use nalgebra::{DMatrix, Vector3};

type Vec3 = Vector3<f64>;

/// Two spheres on the x axis with the flow of both columns: the volume of the first grows at the
/// rate one while that of the second shrinks, and back.
struct Exchange {
    resistance: DMatrix<f64>,
    flow: SurfaceFlow,
}

impl Exchange {
    fn new(radii: [f64; 2], distance: f64, medium: &Medium) -> Self {
        let centres = [-0.5, 0.5].map(|s| Vec3::x() * (s * distance)).to_vec();
        let spheres = Spheres::new(centres, radii.to_vec()).unwrap();
        let found = multipole::resistance(&spheres, medium, &Accuracy::relative(1e-12)).unwrap();
        let rates = [1.0, -1.0].map(|rate| rate / (4.0 * PI));
        let exchange = move |sphere: usize, n: &Vec3| n * (rates[sphere] / radii[sphere].powi(2));
        let flow = multipole::surface_flow(&spheres, medium, found.orders(), &[&exchange]);
        Self {
            resistance: found.matrix().clone(),
            flow: flow.unwrap(),
        }
    }

    /// Velocities along x of spheres at a constant distance, or that move apart at the rate
    /// `apart`, without forces from outside.
    fn velocities(&self, apart: f64, exchange: f64) -> [f64; 2] {
        let r = |i: usize, j: usize| self.resistance[(6 * i, 6 * j)];
        let free = [0, 1].map(|i| exchange * self.flow.velocities[(6 * i, 0)]);
        // F_i = sum_j R_ij (U_j - U_j,free) and U_2 = U_1 + apart, with F_1 + F_2 = 0
        let sums = [0, 1].map(|j| r(0, j) + r(1, j));
        let given = sums[0] * free[0] + sums[1] * (free[1] - apart);
        let first = given / (sums[0] + sums[1]);
        [first, first + apart]
    }
}

/// Connection `dX_mid = A_l dl + A_v dV_1` at the radii 1 and 2^(1/3), computed for this project by
/// Lamb's solution with point sources and by the reciprocal theorem, which agree to 1e-10.
#[test]
fn connection_of_two_breathing_spheres() {
    let radii = [1.0, 2.0_f64.cbrt()];
    for (distance, of_length, of_volume) in [
        (4.0, -0.092_012_356_3, 0.004_466_633_9),
        (2.6, -0.115_530_140_6, 0.008_497_071_3),
        (8.0, -0.072_263_773_9, 0.001_226_096_3),
    ] {
        let pair = Exchange::new(radii, distance, &Medium::Unbounded);
        let middle = |[a, b]: [f64; 2]| 0.5 * (a + b);
        // Ten digits are known.
        let found = middle(pair.velocities(1.0, 0.0));
        assert!((found - of_length).abs() < 6e-11, "{distance}: {found}");
        let found = middle(pair.velocities(0.0, 1.0));
        assert!((found - of_volume).abs() < 6e-11, "{distance}: {found}");
    }
}

/// One sphere of radius `a` that grows at the rate `a'` dissipates `16π a a'^2`.
#[test]
fn a_breathing_sphere_has_the_power_of_a_source() {
    let (radius, rate) = (1.7, -0.3);
    let sphere = Spheres::new(vec![Vec3::new(1.0, 2.0, 3.0)], vec![radius]).unwrap();
    let medium = Medium::Unbounded;
    let orders = multipole::resistance(&sphere, &medium, &Accuracy::relative(1e-6)).unwrap();
    let grows = move |_: usize, n: &Vec3| rate * n;
    let flow = multipole::surface_flow(&sphere, &medium, orders.orders(), &[&grows]).unwrap();
    let exact = 16.0 * PI * radius * rate * rate;
    assert!((flow.powers[(0, 0)] / exact - 1.0).abs() < 1e-14);
    assert!(flow.velocities.amax() < 1e-14);
}

/// The power of an exchange of volume is that of the forces by the reciprocal theorem: the flow of
/// a stroke and the same stroke traversed in the opposite direction have the same power, and the
/// power of any motion is positive.
#[test]
fn powers_of_motion_and_exchange_are_positive() {
    for medium in [
        Medium::Unbounded,
        Medium::Ball {
            centre: Vec3::zeros(),
            radius: 5.0,
        },
    ] {
        let pair = Exchange::new([1.0, 1.3], 2.9, &medium);
        // The quadratic form over the velocities along x and the exchange: F = R (U - U_0 v) and
        // P = F·U + (P_0 v - F·U_0) v.
        let mut form = DMatrix::<f64>::zeros(3, 3);
        let free = [0, 1].map(|i| pair.flow.velocities[(6 * i, 0)]);
        for i in 0..2 {
            for j in 0..2 {
                let entry = pair.resistance[(6 * i, 6 * j)];
                form[(i, j)] += entry;
                form[(i, 2)] -= entry * free[j];
                form[(2, j)] -= entry * free[i];
                form[(2, 2)] += entry * free[i] * free[j];
            }
        }
        form[(2, 2)] += pair.flow.powers[(0, 0)];
        assert!((&form - form.transpose()).amax() < 1e-10 * form.amax());
        let least = form.symmetric_eigenvalues().min();
        assert!(least > 0.0, "{medium:?}: {least:e}");
    }
}
