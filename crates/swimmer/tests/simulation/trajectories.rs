//! Trajectories of few bodies that act on each other: sedimenting spheres and squirmers.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector3;
use swimmer::{Outcome, Scene};
use testkit::{resumed_after_one_phase, run, within};

/// Positions at the time of a row.
fn positions(outcome: &Outcome, row: usize) -> Vec<Vector3<f64>> {
    let poses = outcome.uniform_samples[row].poses.iter();
    poses.map(|pose| pose.translation.vector).collect()
}

/// Three point forces in a horizontal equilateral triangle of edge `d` fall side by side. Where
/// heights `z_i` differ, `Σ z_i = 0`, the flow `(F/8π) z r / r³` of each pair changes the edges,
/// and these the velocities `(F/8π) / r`:
/// ```text
/// d(r_12)/dt = 3/2 (g/d²) z_3     d(z_3)/dt = (g/d²) (r_31 + r_32)     g = F/8π
/// ```
/// so that with `Σ r_ij` constant heights oscillate with the frequency `(3/2)^(1/2) g/d²`.
#[test]
fn three_sedimenting_spheres_have_the_period_of_a_triangle() {
    let (d, height, force) = (10.0, 1.0, 6.0 * PI);
    let period = TAU * d * d * 8.0 * PI / force / 1.5_f64.sqrt();
    let body = |name: &str, angle: f64, z: f64| {
        let r = d / 3.0_f64.sqrt();
        let (y, x) = angle.sin_cos();
        format!(
            "[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{:?}, {:?}, {z:?}]\n\
             force = [0, 0, {:?}]\n",
            r * x,
            r * y,
            -force
        )
    };
    // The tolerance refers to the fall, some hundred times as long as the orbit.
    let text = format!(
        "model = {{ kind = \"oseen\", tolerance = 1e-6, estimates = \"off\" }}\noutput.samples = 4\n\
         gait.phases = [{{ duration = {period:?} }}]\n{}{}{}",
        body("a", 0.0, height),
        body("b", TAU / 3.0, -0.5 * height),
        body("c", -TAU / 3.0, -0.5 * height)
    );
    let outcome = run(&Scene::parse(&text).unwrap());
    let relative = |row: usize| {
        let x = positions(&outcome, row);
        let middle = (x[0] + x[1] + x[2]) / 3.0;
        x.into_iter().map(move |x| x - middle).collect::<Vec<_>>()
    };
    let start = relative(0);
    // Terms of second order in the height: phases are off by their part of a cycle in each half of
    // it, heights by the square of that and horizontal shifts by itself.
    let second = TAU * (height / d).powi(2) * height;
    for (row, halves, sign) in [(2, 1.0, -1.0), (4, 2.0, 1.0)] {
        for (x, y) in relative(row).iter().zip(&start) {
            within(
                x.z - sign * y.z,
                second,
                format!("heights at {row} quarters"),
            );
            within(
                (x.xy() - y.xy()).norm(),
                halves * second,
                format!("places at {row} quarters"),
            );
        }
    }
    // A quarter later the triangle is flat, and no longer equilateral.
    for x in relative(1) {
        within(x.z, second, "heights at a quarter");
    }
    assert!((relative(1)[0].xy().norm() - start[0].xy().norm()).abs() > 0.2 * height);
}

/// Squirmers at the corners of a triangle, which swim past each other in two parts of the gait.
fn squirmers(count: usize, model: &str) -> Scene {
    let bodies: String = (0..count)
        .map(|k| {
            let angle = TAU * k as f64 / 3.0 + 0.3;
            let (y, x) = angle.sin_cos();
            // inwards, past the centre
            let (dy, dx) = (angle + PI - 0.5).sin_cos();
            format!(
                "[[bodies]]\nname = \"{k}\"\nradius = 1\nposition = [{:?}, {:?}, {:?}]\n\
                 slip = {{ b1 = 1.5, b2 = {:?}, axis = [{dx:?}, {dy:?}, 0.1] }}\n",
                4.0 * x,
                4.0 * y,
                0.2 * k as f64,
                3.0 - 2.0 * k as f64
            )
        })
        .collect();
    let text = format!(
        "model = {{ kind = \"{model}\", tolerance = 1e-2 }}\n\
         gait.phases = [{{ duration = 1 }}, {{ duration = 1 }}]\n{bodies}"
    );
    Scene::parse(&text).unwrap()
}

#[test]
fn two_and_three_squirmers_move_alike_by_multipoles_and_by_rotne_prager_and_yamakawa() {
    for count in [2, 3] {
        let [multipole, rpy] = ["multipole", "rpy"].map(|model| run(&squirmers(count, model)));
        let bar = multipole.error_estimate.total() + rpy.error_estimate.total();
        for (a, b) in multipole.displacement.iter().zip(&rpy.displacement) {
            within((a - b).norm(), bar, format!("both bars, {count} squirmers"));
            // Alone each would have moved by two radii.
            assert!(a.norm() > 1.0 && bar < 1.0, "{} {bar}", a.norm());
        }
        // They turn each other, as both models say.
        let scene = squirmers(count, "rpy");
        let turned = |outcome: &Outcome| -> Vec<Vector3<f64>> {
            let swimmers = outcome.swimmers(&scene).into_iter();
            swimmers.map(|swimmer| swimmer.rotation).collect()
        };
        let bar = multipole.rotation_error.total() + rpy.rotation_error.total();
        for (a, b) in turned(&multipole).iter().zip(&turned(&rpy)) {
            // Of three squirmers 1.003 bars, of which the model rpy has nearly all.
            within(
                (a - b).norm(),
                1.1 * bar,
                format!("rotations of {count} squirmers"),
            );
            assert!(a.norm() > 1e-3);
        }
    }
}

#[test]
fn resumed_squirmers_have_the_bits_of_a_run_without_interruption() {
    for model in ["multipole", "rpy"] {
        let scene = || squirmers(3, model);
        let (whole, resumed) = (run(&scene()), resumed_after_one_phase(scene).outcome);
        assert_eq!(whole.displacement, resumed.displacement);
        let last = |outcome: &Outcome| outcome.samples.last().unwrap().poses.clone();
        assert_eq!(last(&whole), last(&resumed));
    }
}
