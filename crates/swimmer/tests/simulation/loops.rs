//! Loops with joints that are not prescribed.

use nalgebra::{Isometry3, Vector3};
use swimmer::{Method, Outcome, Scene, simulate};
use testkit::{SceneText, boxed, run, within};

/// Corners of a four-bar chain whose bars have the lengths 4, 3, 5 and 2.5 or so.
const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [6.0, 0.0], [5.0, 4.0], [-1.0, 5.0]];

fn corner(k: usize) -> Vector3<f64> {
    let [x, y] = CORNERS[k % 4];
    Vector3::new(x, y, 0.0)
}

/// A closed chain of four spheres, the middles of the bars, with hinges at its corners.
///
/// `drives` are the lines of the four hinges.
fn four_bars(drives: [&str; 4], gait: &str) -> Scene {
    let mut text = SceneText::file(gait).model("rpy", 1e-5);
    for k in 0..4 {
        let middle = 0.5 * (corner(k) + corner(k + 1));
        text = text.sphere(&format!("bar {k}"), 0.8, middle.as_slice());
    }
    for (k, drive) in drives.iter().enumerate() {
        let (pivot, other) = (corner(k + 1), (k + 1) % 4);
        let [name, body, to] = [
            format!("hinge {k}"),
            format!("bar {other}"),
            format!("bar {k}"),
        ];
        let pivot = pivot.as_slice();
        let keys = format!("joint = \"hinge\", axis = [0, 0, 1], pivot = {pivot:?}{drive}");
        text = text.joint(&name, &body, &to, &keys);
    }
    text.scene()
}

/// Largest distance between the two ends that meet at a corner.
fn largest_gap(outcome: &Outcome) -> f64 {
    let end = |poses: &[Isometry3<f64>], bar: usize, k: usize| {
        let arm = corner(k) - 0.5 * (corner(bar) + corner(bar + 1));
        poses[bar].translation.vector + poses[bar].rotation * arm
    };
    let gaps = outcome.samples.iter().flat_map(|sample| {
        (0..4)
            .map(|k| (end(&sample.poses, k, k + 1) - end(&sample.poses, (k + 1) % 4, k + 1)).norm())
    });
    gaps.fold(0.0, f64::max)
}

const FREE_DRIVE: &str = ", drive = \"free\"";

/// One hinge is driven and the loop determines the others: after each cycle they have the values
/// of the start, up to rounding and not up to the tolerance.
#[test]
fn a_driven_four_bar_chain_stays_closed_over_ten_cycles() {
    let gait = "[gait]\nperiod = 1\ncycles = 10\n\
                [[gait.harmonics]]\nlink = \"hinge 0\"\namplitude = 0.4\n";
    let outcome = run(&four_bars(["", FREE_DRIVE, FREE_DRIVE, FREE_DRIVE], gait));
    within(
        largest_gap(&outcome),
        1e-12,
        "rounding, and not the tolerance",
    );
    let values = outcome.samples.iter().map(|sample| sample.shape[2].abs());
    assert!(values.fold(0.0, f64::max) > 0.1);
    let end = outcome.samples.last().unwrap();
    for angle in &end.shape {
        within(*angle, 1e-12, "rounding, and not the tolerance");
    }
}

/// A spring in the loop relaxes to its rest value, and the loop stays closed on the way.
#[test]
fn a_four_bar_chain_with_a_spring_relaxes() {
    let spring = ", drive = \"spring\", stiffness = 1000, rest = 0.3";
    let gait = "[[gait.phases]]\nduration = 10\n";
    let outcome = run(&four_bars(
        [spring, FREE_DRIVE, FREE_DRIVE, FREE_DRIVE],
        gait,
    ));
    within(
        largest_gap(&outcome),
        1e-12,
        "rounding, and not the tolerance",
    );
    let end = outcome.samples.last().unwrap();
    within(end.shape[0] - 0.3, 1e-5, "the tolerance");
    // No external force or torque: a reciprocal motion would return, this one stays.
    assert!(end.shape[2].abs() > 0.05);
}

/// Hinges with angles that contradict each other are refused with the loop's name.
#[test]
fn contradictory_angles_of_a_loop_are_refused() {
    let text = "[[gait.phases]]\ntargets = { \"hinge 0\" = 0.3, \"hinge 1\" = 0.2 }\n";
    let scene = four_bars(["", "", "", FREE_DRIVE], text);
    let mut model = boxed(&scene);
    let error = simulate(&scene, model.as_mut(), Method::from_scene(&scene), &mut ()).unwrap_err();
    testkit::contains("loop", &error.to_string(), &["loop closed by link 'hinge"]);
}
