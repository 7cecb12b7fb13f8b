//! Smooth gaits in which several joints change their values at once.

use std::f64::consts::{FRAC_PI_2, TAU};

use testkit::{SceneText, three_spheres, within};

use crate::support::follow;

/// Two arms of the initial length 10 with the phase angles of their oscillations.
fn harmonic(amplitude: f64, [left, right]: [f64; 2]) -> SceneText {
    let terms = [
        ("left-arm", amplitude, left),
        ("right-arm", amplitude, right),
    ];
    swimmer().harmonics(8.0, &terms)
}

fn swimmer() -> SceneText {
    three_spheres().without_phases().tolerance(1e-7)
}

/// Lengths of both arms on the path.
fn lengths(amplitude: f64, phases: [f64; 2], angle: f64) -> [f64; 2] {
    phases.map(|phase| 10.0 + amplitude * ((angle + phase).sin() - phase.sin()))
}

/// The same path as a polygon of phases that move both arms.
fn polygon(amplitude: f64, phases: [f64; 2], corners: u32) -> SceneText {
    (1..=corners).fold(swimmer(), |text, k| {
        let angle = TAU * f64::from(k) / f64::from(corners);
        let [left, right] = lengths(amplitude, phases, angle);
        text.phase(&format!(
            "targets = {{ left-arm = {left:?}, right-arm = {right:?} }}"
        ))
    })
}

#[test]
fn a_harmonic_gait_is_the_limit_of_polygons() {
    // Both arms start from their largest length and shorten, as in the stroke of phases.
    let phases = [FRAC_PI_2, FRAC_PI_2 + 1.0];
    let smooth = follow(&harmonic(1.5, phases)).net(1).x;
    assert!(smooth.abs() > 0.01, "{smooth}");
    let [coarse, middle, fine] =
        [16, 32, 64].map(|corners| follow(&polygon(1.5, phases, corners)).net(1).x);
    // The displacement of a closed path is an integral over the enclosed shapes: the errors of
    // polygons decrease with the squared, those of the extrapolation with the fourth power.
    let extrapolated = [(4.0 * middle - coarse) / 3.0, (4.0 * fine - middle) / 3.0];
    let change = (extrapolated[1] - extrapolated[0]).abs();
    let bound = 0.1 * change + 3e-7 * smooth.abs();
    within(
        smooth - extrapolated[1],
        bound,
        "a fifteenth by theory, and three tolerances",
    );
}

/// A file with a table of the path at `rows` times of a period.
fn table(amplitude: f64, phases: [f64; 2], rows: u32, folder: &std::path::Path) -> SceneText {
    let file = folder.join("stroke.csv");
    let mut text = "time, left-arm, right-arm\n".to_owned();
    for k in 0..=rows {
        let time = 8.0 * f64::from(k) / f64::from(rows);
        // The last row is the first one to the last digit.
        let angle = TAU * f64::from(k % rows) / f64::from(rows);
        let [left, right] = lengths(amplitude, phases, angle);
        text += &format!("{time:?}, {left:?}, {right:?}\n");
    }
    std::fs::write(&file, text).unwrap();
    swimmer().with("gait.file", format!("{:?}", file.display().to_string()))
}

#[test]
fn a_table_of_a_smooth_gait_converges_with_the_fourth_power_of_its_rows() {
    let phases = [FRAC_PI_2, FRAC_PI_2 + 1.0];
    let smooth = follow(&harmonic(1.5, phases)).net(1).x;
    let folder = tempfile::tempdir().unwrap();
    let error = |rows: u32| {
        let net = follow(&table(1.5, phases, rows, folder.path())).net(1).x;
        (net / smooth - 1.0).abs()
    };
    let (coarse, fine) = (error(8), error(16));
    // Splines of the path err with the fourth power; 16 with a margin for the next order.
    assert!(fine < coarse / 12.0 && coarse < 1e-2, "{coarse:e} {fine:e}");
    // The same rows as phases at constant rates: a polygon inside, with less area.
    let linear = table(1.5, phases, 16, folder.path()).with("gait.interpolation", "linear");
    let polygon = follow(&polygon(1.5, phases, 16)).net(1).x;
    let of_table = follow(&linear).net(1).x;
    within(of_table / polygon - 1.0, 1e-7, "the tolerance");
}

/// 20 000 rows took three solves each.
#[test]
fn bug_each_row_of_a_smooth_table_was_a_phase_of_its_own() {
    let phases = [FRAC_PI_2, FRAC_PI_2 + 1.0];
    let folder = tempfile::tempdir().unwrap();
    let smooth = follow(&harmonic(1.5, phases));
    let of_table = follow(&table(1.5, phases, 20_000, folder.path()));
    assert!(
        of_table.solves() <= 2 * smooth.solves(),
        "{} solves instead of {}",
        of_table.solves(),
        smooth.solves()
    );
    let bars = smooth.integration_error() + of_table.integration_error();
    within(
        (of_table.net(1) - smooth.net(1)).norm(),
        bars,
        "both error bars",
    );
}

/// Both arms jump, one after the other, in a few of the rows of a smooth table.
#[test]
fn steps_over_many_rows_do_not_miss_a_jump_of_a_few() {
    let rows = 4000;
    let folder = tempfile::tempdir().unwrap();
    let text = table(1.5, [FRAC_PI_2, FRAC_PI_2 + 1.0], rows, folder.path());
    let file = folder.path().join("stroke.csv");
    let smooth = follow(&text).net(1).x;
    let moved = |(number, line): (usize, &str)| {
        let numbers: Vec<f64> = (line.split(','))
            .filter_map(|x| x.trim().parse().ok())
            .collect();
        let [time, mut left, mut right] = numbers[..] else {
            return line.to_owned();
        };
        left -= if (1201..1205).contains(&number) {
            0.5
        } else {
            0.0
        };
        right -= if (1203..1207).contains(&number) {
            0.5
        } else {
            0.0
        };
        format!("{time:?}, {left:?}, {right:?}")
    };
    let table = std::fs::read_to_string(&file).unwrap();
    let lines: Vec<String> = table.lines().enumerate().map(moved).collect();
    std::fs::write(&file, lines.join("\n")).unwrap();
    let coarse = follow(&text.clone().tolerance(1e-3));
    let fine = follow(&text.tolerance(1e-8));
    let error = (coarse.net(1) - fine.net(1)).norm();
    within(error, coarse.integration_error(), "the error bar");
    assert!(
        (fine.net(1).x - smooth).abs() > 10.0 * coarse.integration_error(),
        "the jump matters: {smooth} {:?}",
        fine.net(1)
    );
}

#[test]
fn arms_that_oscillate_in_phase_go_nowhere_and_small_strokes_go_with_the_square() {
    let net = |amplitude: f64, phase: f64| follow(&harmonic(amplitude, [0.0, phase])).net(1).x;
    let full = net(0.4, FRAC_PI_2);
    within(
        net(0.4, 0.0),
        1e-7 * full.abs(),
        "the shapes trace the same line forth and back",
    );
    // The next term is of the fourth power, (amplitude / length)^2 relative to the first; the
    // shapes start at the same values, whose means differ by the amplitude.
    within(full / net(0.2, FRAC_PI_2) / 4.0 - 1.0, 0.2, "the next term");
}
