//! Resistance matrices against exact values, and the accuracy of their error estimates.

use std::f64::consts::PI;

use axisymmetric::{AxialResistance, AxialSpheroid, ResistanceSolver, Surroundings};
use axisymmetric::{axial_resistance, spin_resistance};
use nalgebra::DMatrix;
use proptest::prelude::*;

const UNBOUNDED: Surroundings = Surroundings::Unbounded;

fn ball(radius: f64) -> Surroundings {
    Surroundings::Ball { radius }
}

fn tube(radius: f64) -> Surroundings {
    Surroundings::Cylinder { radius }
}

fn sphere(centre: f64, radius: f64) -> AxialSpheroid {
    AxialSpheroid::sphere(centre, radius)
}

fn spheroid(axial: f64, equatorial: f64) -> AxialSpheroid {
    AxialSpheroid {
        centre: 0.0,
        axial,
        equatorial,
    }
}

/// Drag of a sphere at the centre of a ball; Happel & Brenner (1983), 4-22.
fn concentric(l: f64) -> f64 {
    6.0 * PI * (1.0 - l.powi(5)) / (1.0 - 2.25 * l + 2.5 * l.powi(3) - 2.25 * l.powi(5) + l.powi(6))
}

/// Drag along the long axis; Happel & Brenner (1983), 4-26; Kim & Karrila (1991), table 3.4.
fn prolate(a: f64, b: f64) -> f64 {
    let e = (1.0 - (b / a).powi(2)).sqrt();
    let l = ((1.0 + e) / (1.0 - e)).ln();
    6.0 * PI * a * (8.0 / 3.0) * e.powi(3) / (-2.0 * e + (1.0 + e * e) * l)
}

/// Drag along the short axis `a`; Happel & Brenner (1983), 4-26.
fn oblate(a: f64, b: f64) -> f64 {
    let t = a / (b * b - a * a).sqrt();
    8.0 * PI * (b * b - a * a).sqrt() / (t - (t * t - 1.0) * (1.0 / t).atan())
}

struct Case {
    name: &'static str,
    bodies: Vec<AxialSpheroid>,
    surroundings: Surroundings,
    /// Upper triangle of the resistance matrix, row by row.
    exact: Vec<f64>,
}

/// Cases with closed-form values, or spectral ones (bispherical coordinates, multipoles and
/// fundamental solutions, which agree to 1e-12).
fn cases() -> Vec<Case> {
    let case = |name, bodies: &[AxialSpheroid], surroundings, exact: &[f64]| Case {
        name,
        bodies: bodies.to_vec(),
        surroundings,
        exact: exact.to_vec(),
    };
    vec![
        case(
            "concentric 10",
            &[sphere(0.0, 1.0)],
            ball(10.0),
            &[concentric(0.1)],
        ),
        case(
            "concentric 2",
            &[sphere(0.0, 1.0)],
            ball(2.0),
            &[concentric(0.5)],
        ),
        case(
            "eccentric 4 in 10",
            &[sphere(4.0, 1.0)],
            ball(10.0),
            &[25.59443285590934],
        ),
        case(
            "eccentric 2 in 5",
            &[sphere(2.0, 1.0)],
            ball(5.0),
            &[37.96695415767978],
        ),
        case(
            "two in 8",
            &[sphere(-3.0, 1.0), sphere(2.0, 1.0)],
            ball(8.0),
            &[28.053090742016554, -2.5710663381106063, 27.052609255108717],
        ),
        case(
            // bodies not sorted along the axis
            "unequal in 12",
            &[sphere(1.0, 1.5), sphere(-5.0, 1.0), sphere(6.0, 0.7)],
            ball(12.0),
            &[
                40.92828880750805,
                -3.983214481689879,
                -3.713430263928663,
                24.878061711608638,
                0.004052731170952731,
                16.49840851801843,
            ],
        ),
        case(
            "tube 10",
            &[sphere(0.0, 1.0)],
            tube(10.0),
            &[6.0 * PI * 1.2632139052745492],
        ),
        case(
            "tube 2",
            &[sphere(3.0, 1.0)],
            tube(2.0),
            &[6.0 * PI * 5.947374245718559],
        ),
        case("sphere", &[sphere(5.0, 2.0)], UNBOUNDED, &[12.0 * PI]),
        case(
            "prolate 2",
            &[spheroid(2.0, 1.0)],
            UNBOUNDED,
            &[prolate(2.0, 1.0)],
        ),
        case(
            "prolate 4",
            &[spheroid(4.0, 1.0)],
            UNBOUNDED,
            &[prolate(4.0, 1.0)],
        ),
        case(
            "oblate 3",
            &[spheroid(1.0, 3.0)],
            UNBOUNDED,
            &[oblate(1.0, 3.0)],
        ),
        case(
            "pair 2.1",
            &[sphere(0.0, 1.0), sphere(2.1, 1.0)],
            UNBOUNDED,
            &[76.0032732355861, -63.73409456221525, 76.0032732355861],
        ),
    ]
}

fn symmetric(upper: &[f64], n: usize) -> DMatrix<f64> {
    let mut matrix = DMatrix::zeros(n, n);
    let indices = (0..n).flat_map(|i| (i..n).map(move |j| (i, j)));
    for ((i, j), &value) in indices.zip(upper) {
        matrix[(i, j)] = value;
        matrix[(j, i)] = value;
    }
    matrix
}

/// Largest error of an entry, in the norm of [`AxialResistance::relative_error`].
fn relative_error(found: &AxialResistance, exact: &DMatrix<f64>) -> f64 {
    let n = exact.nrows();
    let each = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    each.map(|(i, j)| {
        let size = (exact[(i, i)] * exact[(j, j)]).sqrt();
        (found.matrix()[(i, j)] - exact[(i, j)]).abs() / size
    })
    .fold(0.0, f64::max)
}

#[test]
fn errors_meet_the_tolerance_and_their_estimates() {
    for case in cases() {
        let exact = symmetric(&case.exact, case.bodies.len());
        for tolerance in [1e-3, 1e-6] {
            let found =
                axial_resistance(&case.bodies, case.surroundings, tolerance).expect(case.name);
            let (error, estimate) = (relative_error(&found, &exact), found.relative_error());
            assert!(error < 2.0 * tolerance, "{}: error {error:e}", case.name);
            let effectivity = estimate / error;
            assert!(
                (0.7..2.0).contains(&effectivity),
                "{} to {tolerance:e}: error {error:e}, estimated {effectivity:.2} times this",
                case.name
            );
            assert!(found.dofs() < 3_000, "{}: {} dofs", case.name, found.dofs());
        }
    }
}

/// Happel & Brenner (1983); Kim & Karrila (1991), table 3.4; for the pair, spectral values of the
/// functions of Jeffrey & Onishi.
#[test]
fn torques_of_rotating_bodies_match_exact_values() {
    let pair = [sphere(0.0, 1.0), sphere(2.1, 1.0)];
    let about_pair = [25.844185785947275, -2.936246987520766, 25.844185785947257];
    for (bodies, surroundings, exact) in [
        (
            &[sphere(0.0, 1.0)][..],
            ball(2.0),
            &[8.0 * PI / (1.0 - 0.125)][..],
        ),
        (&[spheroid(2.0, 1.0)], UNBOUNDED, &[40.547993478379844]),
        (&[spheroid(4.0, 1.0)], UNBOUNDED, &[72.48666264134553]),
        (&pair, UNBOUNDED, &about_pair),
    ] {
        let exact = symmetric(exact, bodies.len());
        let found = spin_resistance(bodies, surroundings, 1e-6).expect("solvable");
        let (error, estimate) = (relative_error(&found, &exact), found.relative_error());
        assert!(error < 1e-6, "error {error:e}");
        // the error may be smaller than estimated: that of pure swirl falls faster with the order
        assert!(
            error < 1.5 * estimate,
            "error {error:e}, estimate {estimate:e}"
        );
    }
}

#[test]
fn tolerance_1e_9_is_not_limited_by_rounding() {
    let found = axial_resistance(&[sphere(2.0, 1.0)], ball(5.0), 1e-9).expect("solvable");
    let error = (found.matrix()[(0, 0)] / 37.96695415767978 - 1.0).abs();
    assert!(error < 2e-9);
}

/// Reference values: multipole expansions of order 300.
#[test]
fn spheres_with_a_gap_of_a_hundredth_match_exact_values() {
    let [together, opposite] = [0.6457220784694283, 53.422293653916505].map(|f| 6.0 * PI * f);
    let found = axial_resistance(&[sphere(0.0, 1.0), sphere(2.01, 1.0)], UNBOUNDED, 1e-6)
        .expect("solvable");
    let r = found.matrix();
    let (sum, difference) = (r[(0, 0)] + r[(0, 1)], r[(0, 0)] - r[(0, 1)]);
    assert!((difference / opposite - 1.0).abs() < 2e-6);
    // the sum of a row is a small difference of large entries
    assert!((sum - together).abs() < 2e-6 * r[(0, 0)]);
}

#[test]
fn radii_may_differ_by_a_factor_of_a_hundred() {
    let found = axial_resistance(&[sphere(0.0, 1.0), sphere(1.03, 0.01)], UNBOUNDED, 1e-5)
        .expect("solvable");
    // the small sphere hardly changes the drag of the large one
    let both = found.matrix().sum();
    assert!((found.matrix()[(0, 0)] / (6.0 * PI) - 1.0).abs() < 0.03);
    assert!((both / (6.0 * PI) - 1.0).abs() < 1e-2);
}

#[test]
fn invalid_input_is_refused_with_the_reason() {
    for (bodies, surroundings, tolerance, reason) in [
        (vec![], UNBOUNDED, 1e-3, "no body"),
        (vec![sphere(0.0, -1.0)], UNBOUNDED, 1e-3, "positive"),
        (vec![sphere(f64::NAN, 1.0)], UNBOUNDED, 1e-3, "finite"),
        (
            vec![sphere(0.0, 1.0), sphere(1.9, 1.0)],
            UNBOUNDED,
            1e-3,
            "apart",
        ),
        (vec![sphere(0.0, 1.0)], ball(1.0), 1e-3, "wall"),
        (vec![sphere(0.0, 1.0)], ball(f64::NAN), 1e-3, "wall"),
        (vec![spheroid(1.0, 2.0)], tube(1.5), 1e-3, "wall"),
        (vec![sphere(0.0, 1.0)], ball(2.0), 0.0, "tolerance"),
    ] {
        let error = axial_resistance(&bodies, surroundings, tolerance).expect_err(reason);
        assert!(error.to_string().contains(reason), "{error}");
    }
}

#[test]
fn result_is_the_same_bits_for_any_number_of_threads() {
    let solve = || axial_resistance(&[sphere(-2.0, 1.0), sphere(2.0, 0.5)], ball(6.0), 1e-4);
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(solve).expect("solvable")
    });
    assert_eq!(one, three);
}

/// Neither collars nor results that are kept change a bit, whatever was computed before.
#[test]
fn results_do_not_depend_on_earlier_ones() {
    let swimmer = |left: f64, right: f64| [-left, 0.0, right].map(|z| sphere(z, 1.0));
    let solver = ResistanceSolver::new();
    for surroundings in [UNBOUNDED, ball(40.0)] {
        for bodies in [swimmer(10.0, 7.0), swimmer(6.0, 10.0), swimmer(2.5, 4.0)] {
            let found = solver.axial(&bodies, surroundings, 1e-5);
            assert_eq!(found, axial_resistance(&bodies, surroundings, 1e-5));
            let spin = solver.spin(&bodies, surroundings, 1e-5);
            assert_eq!(spin, spin_resistance(&bodies, surroundings, 1e-5));
        }
    }
}

/// Rotated by half a turn and shifted, bodies have the same resistance in all bits.
#[test]
fn mirror_images_have_the_same_resistance() {
    let bodies = [sphere(-10.0, 1.0), sphere(0.0, 1.5), sphere(6.25, 0.5)];
    let image = [0, 1, 2].map(|i| sphere(3.0 - bodies[i].centre, bodies[i].axial));
    let [one, other] = [&bodies, &image].map(|bodies| {
        let found = axial_resistance(bodies, UNBOUNDED, 1e-4);
        found.expect("solvable").matrix().clone()
    });
    assert_eq!(one, other);
}

/// The answers to close shapes differ as little as those of a smooth function, though their meshes
/// may differ: an integrator must not find noise above its tolerance.
#[test]
fn resistances_are_smooth_functions_of_the_shape() {
    let tolerance = 1e-6;
    let solver = ResistanceSolver::new();
    let entry = |arm: f64| {
        let bodies = [-arm, 0.0, 10.0].map(|z| sphere(z, 1.0));
        let found = solver
            .axial(&bodies, UNBOUNDED, tolerance)
            .expect("solvable");
        found.matrix()[(0, 1)] / found.matrix()[(0, 0)]
    };
    // the fourth difference of 1 / arm is 24 h^4 / arm^5
    let h = 0.1;
    for k in 0..8 {
        let at = |j: usize| 6.0 + h * (5 * k + j) as f64;
        let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|j| entry(at(j)));
        let difference = a - 4.0 * b + 6.0 * c - 4.0 * d + e;
        let smooth = 24.0 * h.powi(4) / at(0).powi(5);
        assert!(
            difference.abs() < 2.0 * smooth + tolerance,
            "{difference:e} {smooth:e}"
        );
    }
}

/// One to three spheroids with aspect ratios 1/3 to 3 and gaps from 0.02 to 3, centred at the
/// origin.
fn chain() -> impl Strategy<Value = Vec<AxialSpheroid>> {
    let body = (0.3_f64..1.5, 0.33_f64..3.0, -1.7_f64..0.5);
    prop::collection::vec(body, 1..=3).prop_map(|list| {
        let mut bodies = Vec::new();
        let mut at = 0.0;
        for (equatorial, aspect, log_gap) in list {
            let axial = aspect * equatorial;
            bodies.push(AxialSpheroid {
                centre: at + axial,
                axial,
                equatorial,
            });
            at += 2.0 * axial + 10f64.powf(log_gap);
        }
        bodies.iter_mut().for_each(|body| body.centre -= 0.5 * at);
        bodies
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    /// A wall can only increase the dissipation, so the resistance with it minus the resistance
    /// without it is positive semidefinite.
    #[test]
    fn walls_increase_the_resistance(bodies in chain(), clearance in 0.05_f64..3.0) {
        let tolerance = 1e-3;
        let ends = bodies.iter().map(|b| (b.centre.abs() + b.axial).hypot(b.equatorial));
        let radius = ends.fold(0.0, f64::max) + clearance;
        let widest = bodies.iter().map(|b| b.equatorial).fold(0.0, f64::max);
        let free = axial_resistance(&bodies, UNBOUNDED, tolerance)?;
        for surroundings in [ball(radius), tube(widest + clearance)] {
            let found = axial_resistance(&bodies, surroundings, tolerance)?;
            prop_assert!(found.relative_error() < tolerance, "{:e}", found.relative_error());
            prop_assert!(found.matrix().clone().cholesky().is_some());
            let added = found.matrix() - free.matrix();
            let smallest = added.symmetric_eigenvalues().min();
            prop_assert!(smallest > -2.0 * tolerance * found.matrix().amax(), "{smallest:e}");
        }
    }
}
