//! Every public function on hostile arguments: an error or finite numbers, never a panic.

use microhydro::multipole::{self, VelocityField};
use microhydro::{Accuracy, HydroError, Medium, Spheres, oseen, rpy, wall};
use nalgebra::{DMatrix, DVector, UnitVector3, Vector3};
use proptest::prelude::*;

const HOSTILE: [f64; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    2.0,
    2.5,
    2.0 + 1e-15,
    3.0,
    1e-300,
    1e300,
    -1e300,
    5e-324,
    1e-20,
    1e20,
    f64::NAN,
    f64::INFINITY,
];

fn number() -> impl Strategy<Value = f64> {
    prop::sample::select(HOSTILE.to_vec())
}

fn vector() -> impl Strategy<Value = Vector3<f64>> {
    (number(), number(), number()).prop_map(|(x, y, z)| Vector3::new(x, y, z))
}

/// A radius, more often an ordinary one: otherwise few arrangements are valid.
fn radius() -> impl Strategy<Value = f64> {
    prop_oneof![3 => Just(1.0), 1 => Just(0.5), 1 => number()]
}

/// A centre: one in three ordinary.
fn centre() -> impl Strategy<Value = Vector3<f64>> {
    prop_oneof![
        2 => vector(),
        1 => (-6.0..6.0, -6.0..6.0, -6.0..6.0).prop_map(|(x, y, z)| Vector3::new(x, y, z)),
    ]
}

fn medium() -> impl Strategy<Value = Medium> {
    prop_oneof![
        Just(Medium::Unbounded),
        (vector(), number()).prop_map(|(centre, radius)| Medium::Ball { centre, radius }),
        (number()).prop_map(|radius| Medium::Ball {
            centre: Vector3::zeros(),
            radius
        }),
        (vector(), vector()).prop_map(|(point, normal)| Medium::Wall {
            point,
            normal: UnitVector3::new_unchecked(normal),
        }),
        number().prop_map(|z| Medium::Wall {
            point: Vector3::new(0.0, 0.0, z),
            normal: Vector3::z_axis(),
        }),
    ]
}

fn finite<'a>(what: &str, numbers: impl IntoIterator<Item = &'a f64>) -> Result<(), TestCaseError> {
    let all = numbers.into_iter().all(|x| x.is_finite());
    prop_assert!(all, "{what} returned a number that is not finite");
    Ok(())
}

fn finite_matrix(
    what: &str,
    matrix: Result<DMatrix<f64>, HydroError>,
) -> Result<(), TestCaseError> {
    matrix.map_or(Ok(()), |matrix| finite(what, matrix.iter()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn every_function_of_spheres_returns_errors_or_finite_numbers(
        centres in prop::collection::vec(centre(), 0..4),
        radii in prop::collection::vec(radius(), 0..4),
        same_length in prop::bool::weighted(0.9),
        medium in medium(),
        tolerance in prop_oneof![Just(1e-2), Just(1e-1), number()],
        order in prop::sample::select(vec![0, 1, 3, 100_000, usize::MAX]),
        point in centre(),
        speeds in prop::collection::vec(number(), 0..25),
    ) {
        let mut radii = radii;
        if same_length {
            radii.resize(centres.len(), 1.0);
        }
        let Ok(spheres) = Spheres::new(centres, radii) else {
            return Ok(());
        };
        let n = spheres.len();
        for (first, second) in [(0, 1), (n, 0), (0, 0), (usize::MAX, usize::MAX)] {
            let gap = spheres.gap(first, second);
            prop_assert!(gap.is_none_or(|gap| gap > 0.0));
        }
        let inside = spheres.check_inside(&medium).is_ok();
        finite_matrix("oseen::mobility", oseen::mobility(&spheres, &medium))?;
        finite_matrix("oseen::resistance", oseen::resistance(&spheres, &medium))?;
        finite_matrix("rpy::mobility", rpy::mobility(&spheres, &medium))?;
        finite_matrix("rpy::resistance", rpy::resistance(&spheres, &medium))?;
        let forces = DVector::from_fn(6 * n, |k, _| speeds.get(k).copied().unwrap_or(1.0));
        for product in [oseen::apply, rpy::apply] {
            if let Ok(product) = product(&spheres, &medium, &forces) {
                finite("apply", product.iter())?;
            }
        }
        let velocities = DVector::from_fn(6 * n, |k, _| speeds.get(k).copied().unwrap_or(1.0));
        for accuracy in [Accuracy::relative(tolerance), Accuracy::order(order)] {
            let result = multipole::resistance(&spheres, &medium, &accuracy);
            if let Ok(r) = &result {
                prop_assert!(inside);
                finite("multipole::resistance", r.matrix().iter().chain(r.error().iter()))?;
                prop_assert!(accuracy.order.is_some() || r.relative_error() <= tolerance);
                prop_assert!(r.forces(&DVector::zeros(6 * n + 1)).is_err());
                if let Ok(forces) = r.forces(&velocities) {
                    finite("forces", forces.iter())?;
                }
                prop_assert!(r.relative_difference(&DMatrix::zeros(1, 2)).is_infinite());
                let again = multipole::resistance_at(&spheres, &medium, r.orders());
                prop_assert!(again.is_ok_and(|again| again.relative_error().is_finite()));
            }
            let field = VelocityField::new(&spheres, &medium, &velocities, &accuracy);
            if let Ok(field) = field
                && let Ok(velocity) = field.velocity(&point)
            {
                prop_assert!(point.iter().all(|x| x.is_finite()));
                finite("VelocityField::velocity", velocity.iter())?;
            }
        }
        let short = DVector::zeros(6 * n + 1);
        prop_assert!(VelocityField::new(&spheres, &medium, &short, &Accuracy::default()).is_err());
        if let Ok(orders) = multipole::orders_for(&[spheres.clone(), spheres.clone()], &medium, tolerance) {
            prop_assert_eq!(&orders.at_least(&orders), &orders);
            let more = Spheres::new(vec![Vector3::zeros(); 1], vec![1.0]).unwrap();
            prop_assert!(n == 1 || multipole::resistance_at(&more, &medium, &orders).is_err());
            prop_assert!(n == 1 || multipole::orders_for(&[spheres, more], &medium, 1e-2).is_err());
        }
    }

    #[test]
    fn walls_and_points_return_errors_or_finite_numbers(
        x in vector(), y in vector(), point in vector(), normal in vector(),
    ) {
        if let Ok(medium) = Medium::wall(point, normal) {
            let Medium::Wall { normal, .. } = medium else {
                panic!("not a wall");
            };
            prop_assert!((normal.norm() - 1.0).abs() < 1e-14);
            if let Ok(image) = wall::image(&x, &y, &point, &normal) {
                finite("wall::image", image.iter())?;
            }
        }
        if let Ok(image) = wall::image(&x, &y, &point, &UnitVector3::new_unchecked(normal)) {
            finite("wall::image", image.iter())?;
        }
    }
}

#[test]
fn tolerances_that_cannot_be_met_are_refused() {
    let pair = Spheres::new(vec![Vector3::zeros(), Vector3::x() * 3.0], vec![1.0; 2]).unwrap();
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-300, 2.0] {
        let error =
            multipole::resistance(&pair, &Medium::Unbounded, &Accuracy::relative(tolerance));
        assert!(
            matches!(error, Err(HydroError::BadTolerance { .. })),
            "{tolerance}"
        );
        let error =
            multipole::orders_for(std::slice::from_ref(&pair), &Medium::Unbounded, tolerance);
        assert!(
            matches!(error, Err(HydroError::BadTolerance { .. })),
            "{tolerance}"
        );
    }
}

/// Order 100000 panicked.
#[test]
fn expansions_beyond_the_memory_are_refused_with_their_size() {
    let lengths = [
        vec![Vector3::zeros(), Vector3::x() * 3.0],
        vec![Vector3::zeros(), Vector3::x() * 3.0, Vector3::y() * 4.0],
    ];
    for centres in lengths {
        let n = centres.len();
        let spheres = Spheres::new(centres, vec![1.0; n]).unwrap();
        for order in [100_000, usize::MAX] {
            let accuracy = Accuracy::order(order);
            let error = multipole::resistance(&spheres, &Medium::Unbounded, &accuracy);
            let error = error.unwrap_err();
            assert!(error.to_string().contains("MiB"), "{error}");
            let still = DVector::zeros(6 * n);
            let error = VelocityField::new(&spheres, &Medium::Unbounded, &still, &accuracy);
            assert!(matches!(error.err(), Some(HydroError::TooLarge { .. })));
        }
    }
}
