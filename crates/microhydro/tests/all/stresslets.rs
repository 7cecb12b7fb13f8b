//! Stresslets of spheres against exact values, the far field of the flow, and in rotated
//! frames.

use std::f64::consts::PI;

use microhydro::multipole::{self, SphereSlip, SphereStresslets, VelocityField};
use microhydro::{Accuracy, HydroError, Medium, Spheres};
use nalgebra::{DVector, Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

type Vec3 = Vector3<f64>;

fn found(
    spheres: &Spheres,
    velocities: &DVector<f64>,
    surface: Option<&SphereSlip<'_>>,
) -> SphereStresslets {
    let medium = Medium::Unbounded;
    let resistance = multipole::resistance(spheres, &medium, &Accuracy::relative(1e-9)).unwrap();
    let motion = [velocities, &DVector::zeros(velocities.len())];
    multipole::stresslets(spheres, &medium, resistance.orders(), motion, surface).unwrap()
}

/// `S = 20π/3 a^3 E` for a free sphere in a linear flow (Einstein 1906; Batchelor 1970).
#[test]
fn a_sphere_in_a_linear_flow_has_the_stresslet_of_einstein() {
    let (radius, centre) = (1.3, Vec3::new(0.4, -1.0, 2.0));
    let sphere = Spheres::new(vec![centre], vec![radius]).unwrap();
    let gradient = Matrix3::new(0.3, -1.2, 0.5, 0.7, -0.4, 0.2, -0.9, 1.1, 0.1);
    let against = |_: usize, n: &Vec3| -(gradient * (centre + radius * n));
    let spin = 0.5 * Vec3::new(1.1 - 0.2, 0.5 + 0.9, 0.7 + 1.2);
    let velocity = gradient * centre;
    let free = DVector::from_iterator(6, velocity.iter().chain(spin.iter()).copied());
    let strain = 0.5 * (gradient + gradient.transpose());
    let exact = strain * (20.0 / 3.0 * PI * radius.powi(3));
    // A force and a torque have no stresslet: a sphere that is held has that of a free one.
    for velocities in [free, DVector::zeros(6)] {
        let found = found(&sphere, &velocities, Some(&against));
        assert!((found.values[0] - exact).norm() < 1e-12 * exact.norm());
    }
}

/// `S = 4π/3 a^2 B2 (3 e e^T - I)` for a squirmer (Ishikawa, Simmonds & Pedley 2006).
#[test]
fn squirmers_have_the_stresslet_of_their_second_mode() {
    let (radius, b1, b2) = (1.7, 0.8, -1.3);
    let axis = Vec3::new(2.0, -1.0, 2.0) / 3.0;
    let sphere = Spheres::new(vec![Vec3::new(0.2, -3.0, 1.0)], vec![radius]).unwrap();
    let slip = |_: usize, n: &Vec3| {
        let cosine = n.dot(&axis);
        (axis - cosine * n) * -(b1 + b2 * cosine)
    };
    let mut velocities = DVector::zeros(6);
    velocities
        .rows_mut(0, 3)
        .copy_from(&(axis * (2.0 * b1 / 3.0)));
    let found = found(&sphere, &velocities, Some(&slip));
    let strength = 4.0 * PI / 3.0 * radius * radius * b2;
    let exact = (3.0 * axis * axis.transpose() - Matrix3::identity()) * strength;
    assert!((found.values[0] - exact).norm() < 1e-12 * exact.norm());
}

/// Far from force-free spheres the velocity is `-3 x (x · S x) / (8π r^5)` with the sum `S` of
/// their stresslets (Batchelor 1970); relative terms of the order of their extent over `r` follow.
#[test]
fn the_far_field_of_two_close_squirmers_is_that_of_their_stresslets() {
    let centres = vec![Vec3::new(-0.7, 0.1, 0.3), Vec3::new(1.1, 0.4, -0.5)];
    let spheres = Spheres::new(centres, vec![1.0, 0.8]).unwrap();
    let slip = |sphere: usize, n: &Vec3| {
        let axis = [Vec3::x(), Vec3::new(0.0, 0.6, 0.8)][sphere];
        let cosine = n.dot(&axis);
        (axis - cosine * n) * -(0.5 + [2.0, -0.7][sphere] * cosine)
    };
    let resistance = multipole::resistance(&spheres, &Medium::Unbounded, &Accuracy::relative(1e-9));
    let orders = resistance.unwrap().orders().clone();
    let free = multipole::surface_flow(&spheres, &Medium::Unbounded, &orders, &[&slip]).unwrap();
    let velocities = DVector::from_column_slice(free.velocities.as_slice());
    let found = found(&spheres, &velocities, Some(&slip));
    let error = found.errors[0].norm();
    assert!(error < 1e-6, "{error:e}");
    let total: Matrix3<f64> = found.values.iter().sum();
    let field = VelocityField::with_surface_velocity(
        &spheres,
        &Medium::Unbounded,
        &velocities,
        Some(&slip),
        &Accuracy::relative(1e-11),
    );
    let field = field.unwrap();
    let distance = 1e4_f64;
    for direction in [
        Vec3::x(),
        Vec3::new(0.6, 0.0, -0.8),
        Vec3::new(0.0, 0.8, 0.6),
    ] {
        let stresslet = -3.0 * direction.dot(&(total * direction)) / (8.0 * PI * distance.powi(2));
        let velocity = field.velocity(&(distance * direction)).unwrap();
        let largest = total.norm() / (8.0 * PI * distance.powi(2));
        assert!((velocity - stresslet * direction).norm() < 10.0 / distance * largest);
    }
}

#[test]
fn velocities_of_the_wrong_length_and_nan_are_refused() {
    let sphere = Spheres::new(vec![Vec3::zeros()], vec![1.0]).unwrap();
    let medium = Medium::Unbounded;
    let orders = multipole::resistance(&sphere, &medium, &Accuracy::relative(1e-3)).unwrap();
    let result = |velocities: DVector<f64>, surface: Option<&SphereSlip<'_>>| {
        let motion = [&velocities, &DVector::zeros(6)];
        multipole::stresslets(&sphere, &medium, orders.orders(), motion, surface)
    };
    let short = result(DVector::zeros(3), None);
    assert!(matches!(
        short,
        Err(HydroError::Length {
            expected: 6,
            found: 3,
            ..
        })
    ));
    let nan = result(DVector::repeat(6, f64::NAN), None);
    assert!(matches!(nan, Err(HydroError::NotFinite { .. })));
    assert!(result(DVector::zeros(6), Some(&|_, n| n * f64::NAN)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Turned spheres with turned velocities have turned stresslets, on an axis and off it.
    #[test]
    fn stresslets_turn_with_the_spheres(
        y in prop_oneof![Just(0.0), -1.0..1.0_f64],
        velocities in prop::collection::vec(-1.0..1.0_f64, 12),
        turn in prop::array::uniform3(-2.0..2.0_f64),
    ) {
        let centres = [Vec3::new(0.0, 0.0, 1.5), Vec3::new(y, 0.0, -1.0)];
        let rotation = Rotation3::new(Vec3::from(turn));
        let of = |turned: &Rotation3<f64>| {
            let centres = centres.map(|x| turned * x).to_vec();
            let spheres = Spheres::new(centres, vec![1.0, 0.7]).unwrap();
            let mut moved = DVector::from_column_slice(&velocities);
            for first in (0..12).step_by(3) {
                let vector = turned * moved.fixed_rows::<3>(first).into_owned();
                moved.fixed_rows_mut::<3>(first).copy_from(&vector);
            }
            // The same order on the axis and off it: the modes of an order do not depend on the
            // frame.
            let accuracy = Accuracy::order(10);
            let medium = Medium::Unbounded;
            let resistance = multipole::resistance(&spheres, &medium, &accuracy).unwrap();
            let motion = [&moved, &DVector::zeros(12)];
            multipole::stresslets(&spheres, &medium, resistance.orders(), motion, None)
                .unwrap()
                .values
        };
        for (own, turned) in of(&Rotation3::identity()).iter().zip(of(&rotation)) {
            let expected = rotation.matrix() * own * rotation.matrix().transpose();
            let rounding = 1e-11 * (1.0 + expected.norm());
            prop_assert!((turned - expected).norm() < rounding, "{turned} {expected}");
            prop_assert!(turned.trace().abs() < rounding);
            prop_assert!((turned - turned.transpose()).norm() < rounding);
        }
    }
}
