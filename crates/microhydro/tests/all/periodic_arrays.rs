//! Multipole expansions in periodic boxes: cubic arrays, translations, cells of several sizes.

use std::f64::consts::PI;

use microhydro::multipole::{MultipoleMobility, Variant};
use microhydro::nalgebra::{DVector, Vector3};
use microhydro::{Accuracy, HydroError, LinkedSpheres, Mobility, Spheres};

use super::{free, held, total_force};

/// Velocities of free unit spheres at places in units of `edge`, in boxes of `cells` edges, by the
/// force of Stokes for a unit velocity along x.
fn settled(places: &[[f64; 3]], edge: f64, cells: [f64; 3], tolerance: f64) -> Vec<Vector3<f64>> {
    let centres = places.iter().map(|place| edge * Vector3::from(*place));
    let spheres = Spheres::new(centres.collect(), vec![1.0; places.len()]).unwrap();
    let size = edge * Vector3::from(cells);
    let accuracy = Accuracy::relative(tolerance);
    let mobility = MultipoleMobility::new(&spheres, Some(&size), &accuracy, None).unwrap();
    let mut load = DVector::zeros(6);
    load[0] = 6.0 * PI;
    let linkages = (0..places.len()).map(|sphere| free(sphere, load.clone()));
    let linkages = linkages.collect();
    let linked = LinkedSpheres::new(&mobility, linkages).unwrap();
    let found = linked.solve(1e-3 * tolerance).unwrap();
    let velocities = found.coordinates.iter();
    velocities
        .map(|v| v.fixed_rows::<3>(0).into_owned())
        .collect()
}

const SIMPLE: &[[f64; 3]] = &[[0.0; 3]];
const BODY_CENTRED: &[[f64; 3]] = &[[0.0; 3], [0.5; 3]];
const FACE_CENTRED: &[[f64; 3]] = &[[0.0; 3], [0.5, 0.5, 0.0], [0.5, 0.0, 0.5], [0.0, 0.5, 0.5]];

/// Zick & Homsy (1982), Table 2: the drag of a simple cubic array relative to that of Stokes, to
/// three or four digits.
const DRAG_OF_SIMPLE_ARRAY: [(f64, f64, f64); 6] = [
    (0.027, 2.008, 0.0005),
    (0.064, 2.810, 0.0005),
    (0.125, 4.292, 0.0005),
    (0.216, 7.442, 0.0005),
    (0.343, 15.4, 0.05),
    (0.45, 28.1, 0.05),
];

/// Drag relative to that of Stokes of the spheres at `places` in a cube.
fn drag(places: &[[f64; 3]], fraction: f64, tolerance: f64) -> f64 {
    let volume = places.len() as f64 * 4.0 / 3.0 * PI / fraction;
    let velocities = settled(places, volume.cbrt(), [1.0; 3], tolerance);
    for velocity in &velocities {
        assert!((velocity - velocities[0]).norm() < tolerance * velocities[0].norm());
    }
    1.0 / velocities[0].x
}

/// Drag relative to that of Stokes by the flow past spheres that are held, whose total force is
/// given: the inverse of the permeability.
fn drag_of_held(places: &[[f64; 3]], fraction: f64, tolerance: f64) -> f64 {
    let count = places.len() as f64;
    let edge = (count * 4.0 / 3.0 * PI / fraction).cbrt();
    let centres = places.iter().map(|place| edge * Vector3::from(*place));
    let spheres = Spheres::new(centres.collect(), vec![1.0; places.len()]).unwrap();
    let accuracy = Accuracy::relative(tolerance);
    let mobility = MultipoleMobility::new(&spheres, Some(&Vector3::repeat(edge)), &accuracy, None);
    let mobility = mobility.unwrap();
    let linkages = (0..places.len()).map(|sphere| held(sphere, DVector::zeros(6)));
    let linked = LinkedSpheres::new(&mobility, linkages.collect()).unwrap();
    let total = -6.0 * PI * count * Vector3::new(0.48, 0.6, 0.64);
    let linked = linked.with_total_force(total).unwrap();
    let found = linked.solve(1e-3 * tolerance).unwrap();
    assert!((total_force(&found.forces) - total).norm() < 1e-12 * total.norm());
    // Cubic arrays are isotropic: the flow is along the force of the fluid on the spheres.
    let flow = found.mean_flow;
    let expected = -total.normalize() * flow.norm();
    assert!((flow - expected).norm() < tolerance * flow.norm());
    1.0 / flow.norm()
}

/// The drag of Zick & Homsy (1982) is the inverse permeability too; that of the other lattices is
/// the one of spheres that settle, at the higher order of their test.
#[test]
fn cubic_arrays_have_their_permeability() {
    for (fraction, exact, rounding) in DRAG_OF_SIMPLE_ARRAY {
        let found = drag_of_held(SIMPLE, fraction, 1e-5);
        assert!(
            (found - exact).abs() < 1.01 * rounding,
            "{fraction}: {found}"
        );
    }
    for places in [BODY_CENTRED, FACE_CENTRED] {
        for fraction in [0.001, 0.2, 0.45] {
            let [found, fine] = [
                drag_of_held(places, fraction, 2e-4),
                drag(places, fraction, 1e-5),
            ];
            assert!(
                (found / fine - 1.0).abs() < 1e-3,
                "{fraction}: {found} {fine}"
            );
        }
    }
}

#[test]
fn simple_arrays_have_the_drag_of_zick_and_homsy() {
    for (fraction, exact, rounding) in DRAG_OF_SIMPLE_ARRAY {
        let [coarse, fine] = [1e-3, 1e-5].map(|tolerance| drag(SIMPLE, fraction, tolerance));
        assert!((fine - exact).abs() < 1.01 * rounding, "{fraction}: {fine}");
        assert!(
            (coarse / fine - 1.0).abs() < 1e-3,
            "{fraction}: {coarse} {fine}"
        );
    }
}

/// Hasimoto (1959) with the constants of Sangani & Acrivos (1982):
/// `1/K = 1 - c φ^(1/3) + φ - d φ²` up to terms of the order `φ^(8/3)`.
#[test]
fn dilute_arrays_have_the_drag_of_hasimoto() {
    for (places, c, d) in [
        (SIMPLE, 1.7601, 1.5593),
        (BODY_CENTRED, 1.7918, 0.329),
        (FACE_CENTRED, 1.7917, 0.302),
    ] {
        for fraction in [0.001, 0.01, 0.03] {
            let cube = f64::cbrt(fraction);
            let exact = 1.0 - c * cube + fraction - d * fraction.powi(2);
            let found = 1.0 / drag(places, fraction, 1e-4);
            // a digit of the constant, and terms of the next order
            let rounding = 1e-4 * cube + 4.0 * cube.powi(8);
            assert!(
                (found - exact).abs() < rounding,
                "{fraction}: {found} {exact}"
            );
        }
    }
}

/// Higher orders are the reference up to volume fractions of 0.45, and a box with twice as many
/// spheres, whose images are other ones. Tolerances are relative to velocities of lone spheres,
/// which are up to 33 times as fast.
#[test]
fn all_cubic_arrays_have_their_drag_to_a_thousandth() {
    for places in [SIMPLE, BODY_CENTRED, FACE_CENTRED] {
        for fraction in [0.001, 0.2, 0.45] {
            let [coarse, fine] = [2e-4, 1e-5].map(|tolerance| drag(places, fraction, tolerance));
            assert!(
                (coarse / fine - 1.0).abs() < 1e-3,
                "{fraction}: {coarse} {fine}"
            );
            let second = places.iter().map(|[x, y, z]| [x + 1.0, *y, *z]);
            let both: Vec<[f64; 3]> = places.iter().copied().chain(second).collect();
            let volume = places.len() as f64 * 4.0 / 3.0 * PI / fraction;
            let doubled = settled(&both, volume.cbrt(), [2.0, 1.0, 1.0], 2e-4)[0].x;
            assert!(
                (doubled * fine - 1.0).abs() < 1e-3,
                "{fraction}: {doubled} {fine}"
            );
        }
    }
}

/// Five spheres of different sizes, two of them across a face of the box.
fn some() -> (Spheres, Vector3<f64>) {
    let centres = [
        [0.1, 0.3, 0.2],
        [6.8, 0.4, 0.5],
        [3.1, 4.2, 7.7],
        [-5.0, 12.3, 2.9],
        [2.2, 1.4, 3.3],
    ];
    let radii = vec![1.0, 0.7, 1.3, 0.5, 1.0];
    let spheres = Spheres::new(centres.map(Vector3::from).to_vec(), radii).unwrap();
    (spheres, Vector3::new(9.0, 8.0, 11.0))
}

fn vectors(mobility: &MultipoleMobility, seed: f64) -> [DVector<f64>; 2] {
    let rows = [30, mobility.dofs()];
    rows.map(|rows| DVector::from_fn(rows, |k, _| (seed * (k * k) as f64).sin()))
}

#[test]
fn the_operator_with_images_is_symmetric_and_the_same_for_all_numbers_of_threads() {
    let (spheres, size) = some();
    let mut mobility =
        MultipoleMobility::new(&spheres, Some(&size), &Accuracy::relative(1e-3), None).unwrap();
    for variant in [Variant::Full, Variant::Lowered, Variant::Neglecting] {
        mobility.set_variant(variant);
        let [x, y] = [0.3, 0.7].map(|seed| vectors(&mobility, seed));
        let of = |[f, h]: &[DVector<f64>; 2]| mobility.product(f, h).unwrap();
        let [mx, my] = [of(&x), of(&y)];
        let dot = |a: &[DVector<f64>; 2], b: &[DVector<f64>; 2]| a[0].dot(&b[0]) + a[1].dot(&b[1]);
        let size = |a: &[DVector<f64>; 2]| a[0].norm() + a[1].norm();
        // sums over some thousand waves and images
        assert!((dot(&mx, &y) - dot(&my, &x)).abs() < 1e-12 * size(&mx) * size(&y));
        let by = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| of(&x))
        };
        assert_eq!(by(1), by(3));
    }
}

#[test]
fn shifts_of_all_and_of_one_by_a_period_change_nothing() {
    let (spheres, size) = some();
    let shift = Vector3::new(2.3, -7.1, 0.4);
    let moved = spheres.centres().iter().enumerate().map(|(k, x)| match k {
        2 => x + shift + 2.0 * Vector3::new(size.x, -size.y, 0.0),
        _ => x + shift,
    });
    let moved = Spheres::new(moved.collect(), spheres.radii().to_vec()).unwrap();
    let [before, after] = [&spheres, &moved].map(|spheres| {
        let accuracy = Accuracy::relative(1e-3);
        let mobility = MultipoleMobility::new(spheres, Some(&size), &accuracy, None).unwrap();
        let [forces, hidden] = vectors(&mobility, 0.3);
        mobility.product(&forces, &hidden).unwrap()
    });
    for (before, after) in before.iter().zip(&after) {
        let change = (before - after).amax() / before.amax();
        assert!(change < 1e-12, "{change:e}");
    }
}

#[test]
fn bodies_that_touch_their_images_are_refused() {
    let (spheres, size) = some();
    let periodic = |size: Vector3<f64>| {
        MultipoleMobility::new(&spheres, Some(&size), &Accuracy::relative(1e-3), None).err()
    };
    assert!(periodic(size).is_none());
    let touching = periodic(Vector3::new(2.5, 8.0, 11.0));
    assert!(matches!(
        touching,
        Some(HydroError::TouchingImage { .. } | HydroError::Touching { .. })
    ));
    let flat = periodic(Vector3::new(9.0, -8.0, 11.0));
    assert!(matches!(flat, Some(HydroError::PeriodicBox { .. })));
}
