//! Properties of all arrangements: symmetry, definiteness, invariance, units, error estimates.

use microhydro::{Accuracy, Medium, Spheres, multipole, oseen, rpy};
use nalgebra::{DMatrix, DVector, Rotation3, Unit, Vector3};
use proptest::prelude::*;

use super::distance;

/// Spheres with gaps of at least `gap` smaller radii; those that are too close are moved away.
fn separated(raw: &[(f64, f64, f64, f64)], gap: f64) -> Spheres {
    let mut centres: Vec<Vector3<f64>> = Vec::new();
    let radii: Vec<f64> = raw.iter().map(|s| s.3).collect();
    for (k, &(x, y, z, a)) in raw.iter().enumerate() {
        let mut centre = Vector3::new(x, y, z);
        let step = Vector3::new(x + 0.1, y - 0.05, z + 0.02).normalize() * 0.05;
        let clashes = |c: &Vector3<f64>| {
            centres
                .iter()
                .zip(&radii[..k])
                .any(|(other, b)| (c - other).norm() < a + b + gap * a.min(*b))
        };
        while clashes(&centre) {
            centre += step;
        }
        centres.push(centre);
    }
    Spheres::new(centres, radii).unwrap()
}

fn arrangement(most: usize) -> impl Strategy<Value = Vec<(f64, f64, f64, f64)>> {
    prop::collection::vec((-3.0..3.0, -3.0..3.0, -3.0..3.0, 0.4..1.6_f64), 1..=most)
}

/// A medium that contains all spheres within a distance of 12 from the origin.
fn medium() -> impl Strategy<Value = Medium> {
    prop_oneof![
        Just(Medium::Unbounded),
        Just(Medium::Ball {
            centre: Vector3::new(0.3, -0.2, 0.1),
            radius: 16.0
        }),
        Just(Medium::wall(Vector3::new(0.0, 0.0, -9.0), Vector3::new(0.1, 0.2, 1.0)).unwrap()),
    ]
}

fn rotated(matrix: &DMatrix<f64>, q: &Rotation3<f64>) -> DMatrix<f64> {
    let n = matrix.nrows();
    let mut big = DMatrix::zeros(n, n);
    for k in (0..n).step_by(3) {
        big.fixed_view_mut::<3, 3>(k, k).copy_from(q.matrix());
    }
    &big * matrix * big.transpose()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    #[test]
    fn resistance_is_symmetric_positive_and_grows_with_the_order(raw in arrangement(3), medium in medium()) {
        let spheres = separated(&raw, 0.3);
        let r = multipole::resistance(&spheres, &medium, &Accuracy::order(6)).unwrap();
        let m = r.matrix();
        let size = m.amax();
        prop_assert!((m - m.transpose()).amax() < 1e-12 * size);
        prop_assert!(m.clone().cholesky().is_some());
        // Galerkin: a higher order allows more force densities and dissipates no less
        let growth = (m - r.coarser()).symmetric_eigenvalues().min();
        prop_assert!(growth > -1e-11 * size, "{growth}");
    }

    #[test]
    fn resistance_is_invariant_under_rigid_motions(
        raw in arrangement(3), medium in medium(),
        axis in (-1.0..1.0, -1.0..1.0, 0.1..1.0_f64), angle in -3.0..3.0_f64, shift in (-5.0..5.0, -5.0..5.0, -5.0..5.0),
    ) {
        let spheres = separated(&raw, 0.3);
        let q = Rotation3::from_axis_angle(&Unit::new_normalize(Vector3::new(axis.0, axis.1, axis.2)), angle);
        let d = Vector3::new(shift.0, shift.1, shift.2);
        let there = Spheres::new(spheres.centres().iter().map(|x| q * x + d).collect(), spheres.radii().to_vec()).unwrap();
        let moved = match medium {
            Medium::Unbounded => Medium::Unbounded,
            Medium::Ball { centre, radius } => Medium::Ball { centre: q * centre + d, radius },
            Medium::Wall { point, normal } => Medium::wall(q * point + d, q * normal.into_inner()).unwrap(),
        };
        let accuracy = Accuracy::order(5);
        let here = multipole::resistance(&spheres, &medium, &accuracy).unwrap();
        let found = multipole::resistance(&there, &moved, &accuracy).unwrap();
        prop_assert!((rotated(here.matrix(), &q) - found.matrix()).amax() < 1e-11 * here.matrix().amax());
    }

    #[test]
    fn resistance_scales_with_the_unit_of_length(raw in arrangement(3), medium in medium(), unit in prop_oneof![Just(1e-6), Just(1e5)]) {
        let spheres = separated(&raw, 0.3);
        let small = Spheres::new(
            spheres.centres().iter().map(|x| x * unit).collect(),
            spheres.radii().iter().map(|a| a * unit).collect(),
        ).unwrap();
        let scaled = match medium {
            Medium::Unbounded => Medium::Unbounded,
            Medium::Ball { centre, radius } => Medium::Ball { centre: centre * unit, radius: radius * unit },
            Medium::Wall { point, normal } => Medium::Wall { point: point * unit, normal },
        };
        let here = multipole::resistance(&spheres, &medium, &Accuracy::order(5)).unwrap();
        let there = multipole::resistance(&small, &scaled, &Accuracy::order(5)).unwrap();
        let power = |k: usize| if k % 6 < 3 { 0 } else { 1 };
        for i in 0..here.matrix().nrows() {
            for j in 0..here.matrix().nrows() {
                let back = there.matrix()[(i, j)] / unit.powi(1 + power(i) + power(j));
                let scale = (here.matrix()[(i, i)] * here.matrix()[(j, j)]).sqrt();
                prop_assert!((back - here.matrix()[(i, j)]).abs() < 1e-11 * scale);
            }
        }
    }

    #[test]
    fn the_estimated_error_bounds_the_true_one(raw in arrangement(3), medium in medium(), digits in 2.0..4.5_f64) {
        let spheres = separated(&raw, 0.8);
        let tolerance = 10.0_f64.powf(-digits);
        let r = multipole::resistance(&spheres, &medium, &Accuracy::relative(tolerance)).unwrap();
        let exact = multipole::resistance(&spheres, &medium, &Accuracy::relative(0.03 * tolerance)).unwrap();
        prop_assert!(r.relative_error() <= tolerance);
        let error = distance(r.matrix(), exact.matrix());
        prop_assert!(error <= r.relative_error() + 0.03 * tolerance, "{error} {}", r.relative_error());
    }

    #[test]
    fn oseen_and_rpy_agree_with_multipoles_at_large_distances(raw in arrangement(3), medium in medium()) {
        // Radii of 0.1 at distances above 1: reflections are of the order of 1e-4, effects of the
        // finite size of 1e-2.
        let spheres = separated(&raw, 0.5);
        let small = Spheres::new(spheres.centres().to_vec(), vec![0.1; spheres.len()]).unwrap();
        let exact = multipole::resistance(&small, &medium, &Accuracy::relative(1e-8)).unwrap();
        let exact = exact.matrix().clone().cholesky().unwrap().inverse();
        let error = |m: &DMatrix<f64>| distance(m, &exact);
        let finite = rpy::mobility(&small, &medium).unwrap();
        prop_assert!((&finite - finite.transpose()).amax() < 1e-12 * finite.amax());
        prop_assert!(error(&finite) < 2e-3, "{}", error(&finite));
        if !matches!(medium, Medium::Ball { .. }) {
            let points = oseen::mobility(&small, &medium).unwrap();
            prop_assert!((&points - points.transpose()).amax() < 1e-12 * points.amax());
            prop_assert!(error(&points) < 2e-2, "{}", error(&points));
        }
    }

    /// Each velocity is a sum of `6n` products, in another order.
    #[test]
    fn products_without_a_matrix_are_those_with_it(raw in arrangement(6), medium in medium()) {
        let spheres = separated(&raw, 0.3);
        let forces = DVector::from_fn(6 * raw.len(), |k, _| (1.7 * k as f64).sin());
        let check = |found: DVector<f64>, matrix: DMatrix<f64>| {
            let exact = &matrix * &forces;
            let terms = matrix.abs() * forces.abs();
            for k in 0..exact.len() {
                let bound = 1e-14 * (1.0 + raw.len() as f64) * terms.amax();
                prop_assert!((found[k] - exact[k]).abs() < bound, "{} {}", found[k], exact[k]);
            }
            Ok(())
        };
        let matrix = rpy::mobility(&spheres, &medium).unwrap();
        check(rpy::apply(&spheres, &medium, &forces).unwrap(), matrix)?;
        if !matches!(medium, Medium::Ball { .. }) {
            let matrix = oseen::mobility(&spheres, &medium).unwrap();
            check(oseen::apply(&spheres, &medium, &forces).unwrap(), matrix)?;
        }
        let short = DVector::zeros(6 * raw.len() - 1);
        prop_assert!(rpy::apply(&spheres, &medium, &short).is_err());
        prop_assert!(rpy::apply(&spheres, &medium, &(&forces * f64::NAN)).is_err());
    }
}

/// 110 spheres: the factorisation of their 660 rows uses threads.
#[test]
fn rpy_does_not_depend_on_the_number_of_threads_and_inverts_its_mobility() {
    let centre = |k: usize| {
        let steps = Vector3::new((k % 5) as f64, (k / 5 % 5) as f64, (k / 25) as f64);
        2.5 * steps + Vector3::new(0.0, 0.0, 1.5)
    };
    let spheres = Spheres::new((0..110).map(centre).collect(), vec![1.0; 110]).unwrap();
    let forces = DVector::from_fn(660, |k, _| (0.3 * k as f64).cos());
    let wall = Medium::wall(Vector3::zeros(), Vector3::z()).unwrap();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(|| {
            let resistance = rpy::resistance(&spheres, &Medium::Unbounded).unwrap();
            let beside = rpy::apply(&spheres, &wall, &forces).unwrap();
            let alone = rpy::apply(&spheres, &Medium::Unbounded, &forces).unwrap();
            (resistance, beside, alone)
        })
    };
    let (one, three) = (run(1), run(3));
    assert!(one == three);
    // Rounding of sums of 660 products, times the condition number of some hundreds.
    let back = &one.0 * &one.2 - &forces;
    assert!(back.amax() < 1e-11, "{:e}", back.amax());
}

#[test]
fn pair_corrections_add_what_a_bounded_order_misses() {
    // Three spheres off a line, one gap of 0.02: 1e-4 needs an order above the highest one.
    let centres = vec![
        Vector3::zeros(),
        Vector3::new(2.02, 0.0, 0.0),
        Vector3::new(1.0, 3.2, 0.4),
    ];
    let spheres = Spheres::new(centres.clone(), vec![1.0; 3]).unwrap();
    let pair = Spheres::new(centres[..2].to_vec(), vec![1.0; 2]).unwrap();
    let solve = |spheres: &Spheres, accuracy: Accuracy| {
        multipole::resistance(spheres, &Medium::Unbounded, &accuracy).unwrap()
    };
    let quick = solve(&spheres, Accuracy::relative(1e-4));
    // Reference: a far higher order, plus what it still misses, computed for the pair alone.
    let order = Accuracy::order(44);
    let mut exact = solve(&spheres, order).matrix().clone();
    let missed = solve(&pair, Accuracy::relative(1e-8)).matrix() - solve(&pair, order).matrix();
    let mut block = exact.view_mut((0, 0), (12, 12));
    block += missed;
    let error = distance(quick.matrix(), &exact);
    assert!(error < 3e-4, "{error:e}");
    assert!(
        error < quick.relative_error(),
        "{error:e} {:e}",
        quick.relative_error()
    );
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let spheres = separated(
        &[
            (0.0, 0.0, 0.0, 1.0),
            (3.0, 0.5, 0.0, 0.7),
            (0.0, 3.0, 1.0, 1.2),
            (-3.0, 0.0, 0.0, 1.0),
        ],
        0.3,
    );
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            multipole::resistance(&spheres, &Medium::Unbounded, &Accuracy::relative(1e-6)).unwrap()
        })
    };
    assert_eq!(run(1).matrix(), run(3).matrix());
}

/// Found by [`the_estimated_error_bounds_the_true_one`]: the lowest orders gave an estimate above
/// the tolerance and were never raised.
#[test]
fn a_small_sphere_far_from_its_container_meets_the_tolerance() {
    let sphere = Spheres::new(
        vec![Vector3::new(0.0, 0.0, -0.23520989352722405)],
        vec![0.4],
    );
    let medium = Medium::Ball {
        centre: Vector3::new(0.3, -0.2, 0.1),
        radius: 16.0,
    };
    let tolerance = 10.0_f64.powf(-4.074811330178636);
    let r = multipole::resistance(&sphere.unwrap(), &medium, &Accuracy::relative(tolerance));
    assert!(r.unwrap().relative_error() <= tolerance);
}
