//! Arrangements with known digits from the literature or from an independent spectral method.

use std::f64::consts::PI;

use microhydro::{Accuracy, HydroError, Medium, Resistance, Spheres, multipole, oseen, rpy};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

fn on_axis(z: &[f64], a: &[f64]) -> Spheres {
    let centres = z.iter().map(|&z| Vector3::new(0.0, 0.0, z)).collect();
    Spheres::new(centres, a.to_vec()).unwrap()
}

fn solve(spheres: &Spheres, medium: &Medium, tolerance: f64) -> Resistance {
    multipole::resistance(spheres, medium, &Accuracy::relative(tolerance)).unwrap()
}

/// Resistance functions of two equal spheres.
///
/// Columns: distance of the centres; drag of spheres that follow and that approach each other,
/// XA11, XA12, YA11, YA12 (all over 6 pi); YC11, YC12, XC11, XC12 (over 8 pi); torque of each
/// sphere for a transverse motion of the first. From the bispherical series of Stimson & Jeffery
/// (1926) and Maude (1961) and from boundary collocation, which agree to the digits given (1e-9 at
/// 2.01).
#[rustfmt::skip]
const TWO_SPHERES: [[f64; 13]; 7] = [
    [2.01, 0.6457220784694283, 53.422293653916505, 27.034007866189402, -26.38828578772003, 1.7669601661702743, -1.0414384235843006, 1.6350647188909804, 0.2055510790191471, 1.0467746330288854, -0.14419486273772844, 11.573346520607528, 14.536454293278666],
    [2.1, 0.6509001445148839, 7.413297606556761, 4.032098875535826, -3.381198731020948, 1.3930062706815185, -0.6598752547162995, 1.2330279322682758, 0.1017398793557104, 1.0283074795047022, -0.11682955555065416, 4.957514198404454, 7.755259208338534],
    [2.5, 0.672915513765167, 2.772418679559134, 1.7226670966621505, -1.0497515828969843, 1.1648646878418492, -0.4010789130179469, 1.0527378089611032, 0.04171539465173547, 1.0070156351185087, -0.06484679489849655, 1.5601029448205832, 3.7325978826509654],
    [3.0, 0.6983045602500371, 2.0386546439229005, 1.3684796020864693, -0.6701750418364307, 1.0921017532628983, -0.2971758580078487, 1.0179857150673868, 0.02166466501768628, 1.00195915423931, -0.03714535267810654, 0.713097351810985, 2.329656081973579],
    [4.0, 0.742258285069086, 1.5966819994959558, 1.169470142282521, -0.42721185721343546, 1.0433030159334888, -0.2044768580551124, 1.0042257330415876, 0.008458023398865207, 1.000296405873926, -0.015630696350013323, 0.2554921590327844, 1.2334178824242785],
    [6.0, 0.8047217606699637, 1.330153663951659, 1.0674377123108103, -0.26271595164084754, 1.017109476618295, -0.1295730650198114, 1.0006810036537768, 0.002392469279884549, 1.0000233242100898, -0.0046297474229262175, 0.06932504681598606, 0.5327954313229388],
    [10.0, 0.8706005028976204, 1.1756010168989648, 1.0231007598982924, -0.15250025700067213, 1.0058103307936865, -0.07594450032495256, 1.0000795418607156, 0.000505770665974052, 1.0000010306112477, -0.0010000010624835964, 0.014416400689443732, 0.1895992026819556],
];

#[test]
fn two_equal_spheres() {
    for row in TWO_SPHERES {
        let r = solve(
            &on_axis(&[0.0, row[0]], &[1.0; 2]),
            &Medium::Unbounded,
            1e-11,
        );
        let m = r.matrix();
        let (translation, rotation) = (6.0 * PI, 8.0 * PI);
        let found = [
            row[0],
            (m[(2, 2)] + m[(2, 8)]) / translation,
            (m[(2, 2)] - m[(2, 8)]) / translation,
            m[(2, 2)] / translation,
            m[(2, 8)] / translation,
            m[(0, 0)] / translation,
            m[(0, 6)] / translation,
            m[(4, 4)] / rotation,
            m[(4, 10)] / rotation,
            m[(5, 5)] / rotation,
            m[(5, 11)] / rotation,
            m[(4, 0)],
            m[(10, 0)],
        ];
        for (k, (found, exact)) in found.iter().zip(row).enumerate() {
            // at the narrowest gap the sources of the table agree to 3e-10 of its largest number
            let digits = if row[0] < 2.05 { 2e-9 } else { 1e-10 };
            assert!(
                (found - exact).abs() < digits * exact.abs().max(1.0),
                "s = {}, column {k}: {found} {exact}",
                row[0]
            );
        }
    }
}

/// Resistance functions of one sphere above a wall.
///
/// Columns: height of the centre; drag normal and parallel to the wall (over 6 pi); torque about a
/// parallel axis and about the normal, torque per parallel velocity (over 8 pi). Brenner (1961),
/// Goldman, Cox & Brenner (1967), Blake images; they agree to 1e-10.
#[rustfmt::skip]
const WALL: [[f64; 6]; 5] = [
    [1.1, 11.459157203409546, 2.264303035388026, 1.4548512100169821, 1.1170647529452848, -0.08876334417411287],
    [1.5, 3.2053903153526253, 1.5957066189809064, 1.110495493338138, 1.0391045069174167, -0.0165739619041207],
    [2.0, 2.125535566760041, 1.3827523824112227, 1.0417835548066172, 1.0159271022239393, -0.005024711229088071],
    [3.0, 1.569205393549496, 1.2271551100425808, 1.011795785318925, 1.0046530716330164, -0.0010202265436175893],
    [5.0, 1.2850865628620107, 1.125861064510994, 1.002510084828852, 1.0010010316737312, -0.00013850219243060157],
];

#[test]
fn a_sphere_near_a_wall() {
    // an oblique wall: the result must not depend on its direction
    let normal = Vector3::new(0.3, -0.8, 0.4).normalize();
    let across = normal.cross(&Vector3::x()).normalize();
    let third = normal.cross(&across);
    let point = Vector3::new(5.0, 1.0, -2.0);
    let wall = Medium::wall(point, normal).unwrap();
    for [h, perp, par, rot_par, rot_normal, coupling] in WALL {
        let spheres = Spheres::new(vec![point + normal * h + across * 3.0], vec![1.0]).unwrap();
        let r = solve(&spheres, &wall, 1e-11);
        let block = |i: usize, j: usize, u: Vector3<f64>, v: Vector3<f64>| {
            (u.transpose() * r.matrix().fixed_view::<3, 3>(3 * i, 3 * j) * v)[0]
        };
        for (found, exact) in [
            (block(0, 0, normal, normal) / (6.0 * PI), perp),
            (block(0, 0, across, across) / (6.0 * PI), par),
            (block(1, 1, across, across) / (8.0 * PI), rot_par),
            (block(1, 1, normal, normal) / (8.0 * PI), rot_normal),
            // x, y, z of the table are `across`, `third` and `normal`, up to the sign of a rotation
            (
                block(1, 0, across.cross(&normal) * -1.0, across) / (8.0 * PI),
                coupling,
            ),
            (block(1, 0, third, across) / (8.0 * PI), coupling),
        ] {
            assert!(
                (found - exact).abs() < 2e-10 * exact.abs().max(1.0),
                "h = {h}: {found} {exact}"
            );
        }
    }
}

/// Cases of a reference file: names and rows of numbers.
fn cases(text: &str) -> Vec<(String, Vec<Vec<f64>>)> {
    let mut cases: Vec<(String, Vec<Vec<f64>>)> = Vec::new();
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        match line.strip_prefix("case ") {
            Some(name) => cases.push((name.to_owned(), Vec::new())),
            None => {
                let row = line
                    .split_whitespace()
                    .map(|x| x.parse().unwrap())
                    .collect();
                cases.last_mut().unwrap().1.push(row);
            }
        }
    }
    cases
}

#[test]
fn collinear_spheres_unbounded_and_in_a_ball() {
    let all = cases(include_str!("reference/collinear.txt"));
    assert_eq!(all.len(), 23);
    for (name, rows) in all {
        let (z, a, container) = (&rows[0], &rows[1], rows[2][0]);
        let medium = match container {
            0.0 => Medium::Unbounded,
            radius => Medium::Ball {
                centre: Vector3::zeros(),
                radius,
            },
        };
        let r = solve(&on_axis(z, a), &medium, 1e-11);
        for i in 0..z.len() {
            for j in 0..z.len() {
                let (found, exact) = (r.matrix()[(6 * i + 2, 6 * j + 2)], rows[3 + i][j]);
                assert!(
                    (found - exact).abs() < 1e-9,
                    "{name} ({i}, {j}): {found} {exact}"
                );
            }
        }
    }
}

#[test]
fn spheres_in_space() {
    let all = cases(include_str!("reference/grand.txt"));
    assert_eq!(all.len(), 4);
    for (name, rows) in all {
        let a = &rows[1];
        let n = a.len();
        let centres = rows[0].chunks(3).map(Vector3::from_column_slice).collect();
        let r = solve(
            &Spheres::new(centres, a.clone()).unwrap(),
            &Medium::Unbounded,
            1e-9,
        );
        let place = |k: usize| 6 * (k % (3 * n) / 3) + 3 * (k / (3 * n)) + k % 3;
        for i in 0..6 * n {
            for j in 0..6 * n {
                let (found, exact) = (r.matrix()[(place(i), place(j))], rows[2 + i][j]);
                // the table is converged to 1.5e-9
                assert!(
                    (found - exact).abs() < 2e-8,
                    "{name} ({i}, {j}): {found} {exact}"
                );
            }
        }
    }
}

#[test]
fn one_sphere_has_stokes_drag_and_in_a_concentric_ball_that_of_haberman_and_sayre() {
    let alone = Spheres::new(vec![Vector3::new(1.0, 2.0, 3.0)], vec![0.5]).unwrap();
    let r = solve(&alone, &Medium::Unbounded, 1e-12);
    let exact =
        DMatrix::from_diagonal(&DVector::from_column_slice(&[3.0, 3.0, 3.0, 1.0, 1.0, 1.0])) * PI;
    assert!((r.matrix() - exact).amax() < 1e-14);
    // Haberman & Sayre (1958): concentric spheres
    for ratio in [0.05, 0.1, 0.2, 0.3, 0.5_f64] {
        let medium = Medium::Ball {
            centre: Vector3::new(1.0, 2.0, 3.0),
            radius: 0.5 / ratio,
        };
        let r = solve(&alone, &medium, 1e-12);
        let k = (1.0 - ratio.powi(5))
            / (1.0 - 9.0 / 4.0 * ratio + 5.0 / 2.0 * ratio.powi(3) - 9.0 / 4.0 * ratio.powi(5)
                + ratio.powi(6));
        for axis in 0..3 {
            assert!((r.matrix()[(axis, axis)] / (3.0 * PI) - k).abs() < 1e-12);
            let torque = 1.0 / (1.0 - ratio.powi(3));
            assert!((r.matrix()[(axis + 3, axis + 3)] / PI - torque).abs() < 1e-12);
        }
    }
}

#[test]
fn no_spheres_give_an_empty_resistance() {
    let none = Spheres::new(vec![], vec![]).unwrap();
    assert_eq!(solve(&none, &Medium::Unbounded, 1e-8).matrix().len(), 0);
}

#[test]
fn touching_spheres_and_narrow_gaps_are_errors() {
    let centres = vec![
        Vector3::zeros(),
        Vector3::new(5.0, 0.0, 0.0),
        Vector3::new(2.0, 0.0, 0.0),
    ];
    assert_eq!(
        Spheres::new(centres, vec![1.0; 3]),
        Err(HydroError::Touching {
            first: 0,
            second: 2,
            gap: 0.0
        })
    );
    let spheres = on_axis(&[0.0, 4.0], &[1.0; 2]);
    let ball = Medium::Ball {
        centre: Vector3::zeros(),
        radius: 5.0,
    };
    let error = multipole::resistance(&spheres, &ball, &Accuracy::default()).unwrap_err();
    assert!(
        matches!(error, HydroError::OutsideMedium { sphere: 1, .. }),
        "{error}"
    );
    // Beyond the orders that are allowed for a narrow gap, the order is in the message.
    let close = on_axis(&[0.0, 2.001, 4.002, 6.003], &[1.0; 4]);
    let error =
        multipole::resistance(&close, &Medium::Unbounded, &Accuracy::relative(1e-13)).unwrap_err();
    assert!(matches!(error, HydroError::TooClose { .. }), "{error}");
}

/// Spheres in concentric balls with these gaps had bars of exactly 0; at a gap of 1e-4 the error
/// was 6e-4. Haberman & Sayre (1958), in a form without cancellation.
#[test]
fn bug_bars_of_concentric_spheres_were_zero_beside_errors() {
    let alone = Spheres::new(vec![Vector3::zeros()], vec![1.0]).unwrap();
    let in_ball = |gap: f64| {
        let medium = Medium::Ball {
            centre: Vector3::zeros(),
            radius: 1.0 + gap,
        };
        (
            medium,
            multipole::resistance_best(&alone, &medium, &Accuracy::relative(1e-12)),
        )
    };
    for gap in [1e-1, 3e-2, 1e-2, 3e-3, 1.001e-3] {
        let (medium, found) = in_ball(gap);
        let found = found.unwrap();
        let Medium::Ball { radius, .. } = medium else {
            unreachable!()
        };
        let l = 1.0 / radius;
        // 1 - l, exact in the rounded radius
        let d = (radius - 1.0) / radius;
        let sum = |n: i32| (0..n).map(|k| l.powi(k)).sum::<f64>();
        let drag = 6.0 * PI * sum(5) / (d.powi(3) * (1.0 + 1.75 * l + l * l));
        let torque = 8.0 * PI / (d * sum(3));
        let bars = found.error();
        for axis in 0..3 {
            for (row, exact) in [(axis, drag), (axis + 3, torque)] {
                let error = (found.matrix()[(row, row)] - exact).abs();
                let bar = bars[(row, row)];
                assert!(bar > 0.0, "gap {gap}: no bar");
                assert!(
                    error <= bar,
                    "gap {gap}, row {row}: {:e} {:e} ({} roundings)",
                    error / exact,
                    bar / exact,
                    error / exact / (f64::EPSILON * exact / (6.0 * PI))
                );
            }
        }
        assert!(found.relative_error() > 0.0);
    }
    for gap in [9e-4, 1e-4] {
        let error = in_ball(gap).1.unwrap_err();
        assert!(matches!(error, HydroError::GapTooNarrow { .. }), "{error}");
        assert!(error.to_string().contains("widen the gap"), "{error}");
    }
}

#[test]
fn gaps_below_the_documented_limit_are_refused_in_every_medium() {
    let wall = Medium::wall(Vector3::zeros(), Vector3::z()).unwrap();
    let pair = |gap: f64| on_axis(&[0.0, 2.0 + gap], &[1.0; 2]);
    let above = |gap: f64| on_axis(&[1.0 + gap], &[1.0]);
    for (at, medium) in [
        (&pair as &dyn Fn(f64) -> Spheres, Medium::Unbounded),
        (&above, wall),
    ] {
        // What is written as 0.001 is accepted, whatever its rounding.
        assert!(multipole::resistance_best(&at(1e-3), &medium, &Accuracy::relative(1e-4)).is_ok());
        let error = multipole::resistance_best(&at(9.9e-4), &medium, &Accuracy::relative(1e-4))
            .unwrap_err();
        assert!(matches!(error, HydroError::GapTooNarrow { .. }), "{error}");
        // Fixed orders have no tolerance to meet, and a bar that says so.
        let fixed = multipole::resistance(&at(9.9e-4), &medium, &Accuracy::order(20)).unwrap();
        assert!(fixed.relative_error() > 1e-2);
    }
}

#[test]
fn a_mobility_that_is_not_positive_definite_names_the_narrowest_gap() {
    // point forces give a normal mobility of 1 - 9/8 a/h < 0 for h < 1.125 a
    let wall = Medium::wall(Vector3::zeros(), Vector3::z()).unwrap();
    let error = oseen::resistance(&on_axis(&[1.05], &[1.0]), &wall).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("sphere 0 and the wall leave a gap of 5.000e-2"),
        "{error}"
    );
    assert!(
        matches!(error, HydroError::NotPositiveDefinite { eigenvalue_ratio, .. } if eigenvalue_ratio < 0.0),
        "{error}"
    );
}

#[test]
fn a_large_ball_approaches_a_plane_wall() {
    // Two radii from the wall of a ball of radius b: the resistance beside a plane wall, up to
    // terms of the order of the sphere's radius over b.
    let factor = |b: f64| {
        let offset = Vector3::new(b - 2.0, 0.0, 0.0);
        let ball = Medium::Ball {
            centre: Vector3::zeros(),
            radius: b,
        };
        let sphere = Spheres::new(vec![offset], vec![1.0]).unwrap();
        let r = multipole::resistance(&sphere, &ball, &Accuracy::order(140)).unwrap();
        let m = r.matrix();
        [
            m[(1, 1)] / (6.0 * PI),
            m[(0, 0)] / (6.0 * PI),
            m[(4, 4)] / (8.0 * PI),
        ]
    };
    // Doubling the ball halves the difference: extrapolate to an infinite ball.
    let (near, far) = (factor(20.0), factor(40.0));
    for ((near, far), exact) in
        near.iter()
            .zip(far)
            .zip([1.3827523824112227, 2.1255355667600404, 1.0417835548066172])
    {
        assert!((near - exact).abs() < 0.1 * exact);
        assert!(
            (2.0 * far - near - exact).abs() < 1e-2 * exact,
            "{near} {far} {exact}"
        );
    }
}

#[test]
fn errors_are_those_of_the_entries_and_forces_those_of_the_matrix() {
    // Unequal spheres off an axis, so that entries have different units.
    let centres = vec![
        Vector3::zeros(),
        Vector3::new(3.0, 0.5, 0.0),
        Vector3::new(0.0, 3.5, 1.0),
    ];
    let spheres = Spheres::new(centres, vec![1.0, 0.3, 2.0]).unwrap();
    let found = multipole::resistance(&spheres, &Medium::Unbounded, &Accuracy::order(4)).unwrap();
    let exact = multipole::resistance(&spheres, &Medium::Unbounded, &Accuracy::order(12)).unwrap();
    let matrix = found.matrix();
    let size = |i: usize, j: usize| (matrix[(i, i)] * matrix[(j, j)]).sqrt();
    let error = found.error();
    let (mut largest, mut largest_true) = (0.0_f64, 0.0_f64);
    for i in 0..18 {
        for j in 0..18 {
            let change = |other: &DMatrix<f64>| (matrix[(i, j)] - other[(i, j)]).abs();
            let rounding = change(found.rounded());
            assert!(rounding < 1e-13 * size(i, j));
            let expected = found.tail() * change(found.coarser()) + rounding;
            assert!((error[(i, j)] - expected).abs() <= 1e-15 * size(i, j));
            largest = largest.max(error[(i, j)] / size(i, j));
            let difference = (matrix[(i, j)] - exact.matrix()[(i, j)]).abs();
            largest_true = largest_true.max(difference / size(i, j));
        }
    }
    // The largest parts by truncation and by rounding may be those of different entries.
    assert!((found.relative_error() / largest - 1.0).abs() < 1e-13 / largest);
    for i in 0..18 {
        assert!(found.rounded()[(i, i)] < matrix[(i, i)]);
    }
    assert!(largest_true <= largest && largest_true > 0.0);
    let velocities = DVector::from_fn(18, |i, _| 0.1 * i as f64 - 0.7);
    assert_eq!(found.forces(&velocities).unwrap(), matrix * &velocities);
    assert_ne!(matrix, found.coarser());
}

/// Rotne & Prager 1969 with unequal radii (Jeffrey & Onishi 1984), for a pair along a diagonal.
#[test]
fn the_rpy_mobility_of_an_unequal_pair_has_its_closed_form() {
    let (a, b, r) = (1.0, 0.4, Vector3::new(2.0, 1.0, -2.0));
    let spheres = Spheres::new(vec![r, Vector3::zeros()], vec![a, b]).unwrap();
    let found = rpy::mobility(&spheres, &Medium::Unbounded).unwrap();
    let (distance, along) = (3.0, r * r.transpose() / 9.0);
    let s = (a * a + b * b) / 9.0;
    let identity = Matrix3::identity();
    let translation = (identity * (1.0 + s / 3.0) + along * (1.0 - s)) / (8.0 * PI * distance);
    let rotation = (along * 3.0 - identity) / (16.0 * PI * distance * distance * distance);
    assert!((found.fixed_view::<3, 3>(0, 6) - translation).amax() < 1e-16);
    assert!((found.fixed_view::<3, 3>(3, 9) - rotation).amax() < 1e-16);
}
