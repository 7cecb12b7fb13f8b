//! Every public function with arguments that make no sense: an error or a right answer, no panic.

use std::f64::consts::PI;

use axisymmetric::{AxialSpheroid, AxisymmetricError, ResistanceSolver, Surroundings};
use axisymmetric::{axial_resistance, spin_resistance};
use proptest::prelude::*;

const HOSTILE: [f64; 15] = [
    0.0,
    -0.0,
    -1.0,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    1e300,
    -1e300,
    f64::MAX,
    1e-300,
    1e-320,
    5e-324,
    f64::MIN_POSITIVE,
    1e9,
    1e-9,
];

/// Mostly sizes and positions that go together, so that one bad number meets good ones.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => prop::sample::select(vec![0.5, 1.0, 2.0, 3.0, 7.0]),
        1 => prop::sample::select(HOSTILE.to_vec()),
    ]
}

fn surroundings() -> impl Strategy<Value = Surroundings> {
    (0..3, number()).prop_map(|(kind, radius)| match kind {
        0 => Surroundings::Unbounded,
        1 => Surroundings::Ball { radius },
        _ => Surroundings::Cylinder { radius },
    })
}

fn bodies() -> impl Strategy<Value = Vec<AxialSpheroid>> {
    let body =
        (number(), number(), number()).prop_map(|(centre, axial, equatorial)| AxialSpheroid {
            centre,
            axial,
            equatorial,
        });
    prop::collection::vec(body, 0..4)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn hostile_numbers_are_refused_or_solved(
        bodies in bodies(),
        surroundings in surroundings(),
        tolerance in prop_oneof![4 => Just(1e-2), 1 => number()],
    ) {
        let solver = ResistanceSolver::new();
        for found in [
            axial_resistance(&bodies, surroundings, tolerance),
            spin_resistance(&bodies, surroundings, tolerance),
            solver.axial(&bodies, surroundings, tolerance),
            solver.spin(&bodies, surroundings, tolerance),
        ] {
            let Ok(found) = found else { continue };
            prop_assert!(found.relative_error() <= tolerance);
            prop_assert!(found.matrix().iter().all(|r| r.is_finite()));
            prop_assert!(found.matrix().clone().cholesky().is_some());
            prop_assert!(found.lower_order().iter().all(|r| r.is_finite()));
            prop_assert!(found.residual() < 1e-10 && found.error_factor().is_finite());
            prop_assert!(found.dofs() > 0 && found.order() >= 5 && found.triangles() > 0);
        }
    }
}

#[test]
fn the_unit_of_length_does_not_matter() {
    for unit in [1.0, 1e-300, 1e300, 1e-12] {
        let sphere = AxialSpheroid::sphere(3.0 * unit, unit);
        let drag = axial_resistance(&[sphere], Surroundings::Unbounded, 1e-6).expect("a sphere");
        let off = drag.matrix()[(0, 0)] / (6.0 * PI * unit) - 1.0;
        assert!(off.abs() < 1e-6, "{unit:e}: {off:e}");
    }
    // the drag of a subnormal sphere has few digits, the torque of a huge one is infinite
    for radius in [1e-320, 1e300] {
        let sphere = [AxialSpheroid::sphere(0.0, radius)];
        let error = spin_resistance(&sphere, Surroundings::Unbounded, 1e-3).expect_err("range");
        assert!(
            matches!(error, AxisymmetricError::OutOfRange { .. }),
            "{error}"
        );
    }
}

#[test]
fn lengths_that_differ_by_many_orders_of_magnitude_are_refused() {
    let error = |bodies: &[AxialSpheroid], surroundings| {
        axial_resistance(bodies, surroundings, 1e-3).expect_err("too different")
    };
    let small = AxialSpheroid::sphere(0.0, 1.0);
    for error in [
        error(
            &[small, AxialSpheroid::sphere(1e8, 1.0)],
            Surroundings::Unbounded,
        ),
        error(&[small], Surroundings::Ball { radius: 1e300 }),
        error(&[small], Surroundings::Cylinder { radius: 1e7 }),
    ] {
        assert!(
            matches!(error, AxisymmetricError::SizesTooDifferent { .. }),
            "{error}"
        );
    }
}

/// A spheroid of aspect 1000 used to be meshed for ten seconds before it was refused.
#[test]
fn needles_and_discs_are_refused_at_once() {
    for (axial, equatorial) in [(1000.0, 1.0), (1e-4, 1.0)] {
        let body = AxialSpheroid {
            centre: 0.0,
            axial,
            equatorial,
        };
        let error = axial_resistance(&[body], Surroundings::Unbounded, 1e-2).expect_err("slender");
        assert!(
            matches!(error, AxisymmetricError::TooSlender { .. }),
            "{error}"
        );
    }
}

/// A tolerance that the highest order misses used to be answered as if it was met.
#[test]
fn a_missed_tolerance_is_an_error_and_the_best_result_can_be_had() {
    let pair = [
        AxialSpheroid::sphere(0.0, 1.0),
        AxialSpheroid::sphere(2.01, 1.0),
    ];
    let solver = ResistanceSolver::new();
    let error = solver
        .axial(&pair, Surroundings::Unbounded, 1.1e-11)
        .expect_err("too tight");
    let best = solver
        .axial_best(&pair, Surroundings::Unbounded, 1.1e-11)
        .expect("kept");
    let AxisymmetricError::NotConverged {
        tolerance,
        reached,
        order,
    } = &error
    else {
        panic!("{error}");
    };
    assert_eq!((*tolerance, *order), (1.1e-11, best.order()));
    assert!(*reached > 1.1e-11 && *reached == best.relative_error() && *reached < 1e-6);
    assert!(error.to_string().contains("larger tolerance"), "{error}");
}

#[test]
fn tolerances_below_rounding_errors_are_refused() {
    let sphere = [AxialSpheroid::sphere(0.0, 1.0)];
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, 1.0, 9e-12] {
        let error = axial_resistance(&sphere, Surroundings::Unbounded, tolerance);
        assert!(matches!(
            error,
            Err(AxisymmetricError::InvalidTolerance { .. })
        ));
    }
}
