//! What happens to the tolerance that a scene asks for.

use swimmer::models::{
    Capabilities, DiscretisationError, ErrorEstimate, ErrorEstimates, SphereModel, SpheresModel,
    Tabulated, Uncertainty,
};
use swimmer::{Method, Outcome, SwimError};
use testkit::exact::STROKE_RPY;
use testkit::{Recording, SceneText, planar, run_by, three_spheres, within};

use crate::support::{Tensor, TestModel};

fn outcome(text: &SceneText) -> Outcome {
    let mut model = TestModel::new(&text.scene(), Tensor::Rpy);
    run_by(&mut model, Method::Collocation)
}

/// A rapidly oscillating function of the lengths is noise for any quadrature that does not resolve
/// it, like that of a new mesh; of the size 1e-3 relative to one.
fn noise(lengths: &[f64]) -> f64 {
    1.0 + 1e-3 * (1e7 * lengths.iter().sum::<f64>()).sin()
}

#[test]
fn a_tolerance_below_the_noise_of_a_model_is_refused_and_the_best_result_has_an_honest_bar() {
    // Velocities with noise of 1e-3: each step of a phase span is uncertain by up to 1e-3 of its
    // 1.4, the net displacement of 0.165 by 2e-2 to 3e-2 of itself.
    let with_noise = |text: &SceneText| {
        let scene = text.scene();
        let model = TestModel::new(&scene, Tensor::Rpy);
        let mut model = Recording::changing(model, |query, solutions| {
            for frame in solutions.iter_mut().flat_map(|s| &mut s.motion.frames) {
                frame.linear *= noise(query.configuration.shape);
            }
        });
        swimmer::simulate(&scene, &mut model, Method::Collocation, &mut ())
    };
    let text = three_spheres().tolerance(1e-4);
    let refused = with_noise(&text);
    assert!(matches!(refused, Err(SwimError::NotIntegrated { .. })));
    let outcome = with_noise(&text.with("model.accept", "best")).unwrap();
    let bar = outcome.limited_error.unwrap();
    assert!(!outcome.tolerance_met);
    within(outcome.net() - STROKE_RPY, bar, "the error bar");
    within(
        bar,
        0.3 * STROKE_RPY,
        "ten times the noise of the net displacement",
    );
}

#[test]
fn the_net_displacement_meets_the_tolerance_also_where_it_is_small() {
    // The net displacement of the planar swimmer is 1/370 of the change of length of an arm.
    let at = |tolerance: f64| outcome(&planar(|x| x).tolerance(tolerance));
    let (loose, tight) = (at(0.03), at(1e-7));
    let error = (loose.displacement[0] - tight.displacement[0]).norm();
    within(
        error,
        loose.error_estimate.integration.unwrap(),
        "the error bar",
    );
    within(error, 0.03 * tight.net(), "the tolerance");
    assert!(loose.tolerance_met);
    let swimmer = outcome(&three_spheres().tolerance(1e-3));
    assert!(swimmer.tolerance_met);
    within(
        swimmer.net() - STROKE_RPY,
        1e-3 * STROKE_RPY,
        "the tolerance",
    );
    // Per phase span, orders of one, two and three points, of which the last is accepted, and the
    // end.
    assert_eq!((swimmer.spans.len(), swimmer.solves), (4, 24));
    assert_eq!(swimmer.samples.len(), 1 + 4 * (3 + 1));
}

#[test]
fn differences_between_meshes_are_an_uncertainty_of_the_mesh_and_not_of_the_integration() {
    let model = TestModel::new(&three_spheres().tolerance(1e-4).scene(), Tensor::Rpy);
    let mut solves = 0;
    // A mesh that changes with every solve, with an error bar of 5e-3 of the velocity of the frame.
    let mut model = Recording::changing(model, |query, solutions| {
        for solution in solutions {
            let mut largest = 0.0_f64;
            for frame in &mut solution.motion.frames {
                frame.linear *= noise(query.configuration.shape);
                largest = largest.max(frame.linear.norm());
            }
            let uncertainty = Uncertainty {
                velocity: 5e-3 * largest,
                ..Uncertainty::default()
            };
            let response = &solution.response * 0.0;
            solution.correct(DiscretisationError {
                response,
                uncertainty,
            });
            solution.dofs.total = 1000 + solves % 2;
            solves += 1;
        }
    });
    let error_estimates = ErrorEstimates::Always;
    model.capabilities = Capabilities {
        error_estimates,
        ..Capabilities::default()
    };
    let outcome = run_by(&mut model, Method::Collocation);
    let bar = outcome.error_estimate.mesh.unwrap();
    within(outcome.net() - STROKE_RPY, bar, "the error bar");
    within(
        bar,
        0.3 * STROKE_RPY,
        "ten times the noise of the net displacement",
    );
    assert!(outcome.tolerance_met);
}

#[test]
fn a_swimmer_among_too_many_bodies_for_a_prediction_meets_the_tolerance_of_its_spans() {
    let text = (0..29).fold(three_spheres().tolerance(1e-3), |text, k| {
        text.sphere(&format!("far-{k}"), 1.0, [50 * k, 1000, 0])
    });
    let outcome = outcome(&text);
    for span in &outcome.spans {
        let bar = span.error_estimate.integration.unwrap();
        within(
            bar,
            1e-3 / 160.0 * 4.0,
            "relative to the change of an arm's length",
        );
    }
    let net = outcome.displacement[1].norm();
    within(net - STROKE_RPY, 1e-3 * STROKE_RPY, "the tolerance");
}

#[test]
fn bug_a_table_with_noise_was_integrated_to_a_tolerance_far_below_its_own_bar() {
    let text = three_spheres().model("rpy", 1e-8).with("gait.cycles", 3);
    let scene = text.scene();
    let model = SpheresModel::new(&scene, SphereModel::Rpy).unwrap();
    // Noise of 1e-4 of the velocities, as of meshes, with an error bar that is ten times as wide.
    let mut model = Recording::changing(model, |query, solutions| {
        for solution in solutions {
            let mut largest = 0.0_f64;
            for frame in &mut solution.motion.frames {
                frame.linear *= 1.0 + 0.1 * (noise(query.configuration.shape) - 1.0);
                largest = largest.max(frame.linear.norm());
            }
            solution.error_estimate = ErrorEstimate {
                model: Some(1e-3 * largest),
                ..ErrorEstimate::default()
            };
        }
    });
    model.capabilities = Capabilities::default();
    let boxes = vec![vec![(6.0, 10.0), (6.0, 10.0)]];
    let mut model = Tabulated::new(&scene, Box::new(model), boxes, 1e-8);
    let outcome = run_by(&mut model, Method::Collocation);
    assert_eq!(outcome.lookups, outcome.solves);
    assert_eq!(outcome.model_solves(), outcome.tables[0]);
    // Twelve phases with orders of one to eight points.
    assert!(outcome.lookups <= 12 * 36, "{}", outcome.lookups);
    let bars = &outcome.error_estimate;
    let [integration, model] = [bars.integration, bars.model].map(Option::unwrap);
    within(integration, 0.1 * model, "the share of the table's bar");
    within(
        outcome.net() - 3.0 * STROKE_RPY,
        bars.total(),
        "the error bar",
    );
    assert!(outcome.tolerance_met);
}

/// Numbers in [0, 1) from a seed (Knuth 1997, section 3.3.4, table 1, line 26).
fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// A random stroke of three spheres along `axis` about `centre`, whose net displacement is about a
/// hundredth of the amplitude.
fn small_stroke(domain: &[&str], centre: [f64; 3], axis: [f64; 3], seed: u64) -> SceneText {
    let mut random = random(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * random();
    let arms = [between(5.0, 7.0), between(5.0, 7.0)];
    let at = |distance: f64| [0, 1, 2].map(|k| centre[k] + distance * axis[k]);
    let text = SceneText::new()
        .set(domain)
        .sphere("left", between(0.8, 1.2), at(-arms[0]))
        .sphere("centre", between(0.8, 1.2), at(0.0))
        .sphere("right", between(0.8, 1.2), at(arms[1]))
        .slide("left-arm", "left", "centre")
        .slide("right-arm", "right", "centre");
    let change = between(0.5, 0.8);
    text.phases(&[
        ("left-arm", arms[0] - change),
        ("right-arm", arms[1] - change),
        ("left-arm", arms[0]),
        ("right-arm", arms[1]),
    ])
}

/// Asserts that small random strokes end within the tolerance at default settings.
fn assert_small_strokes(domain: &[&str], centre: [f64; 3], axis: [f64; 3], seeds: u64) {
    for seed in 0..seeds {
        let text = small_stroke(domain, centre, axis, seed);
        let report = swimmer::run_without_files(text.scene(), &mut ()).unwrap();
        let outcome = &report.outcome;
        let longest = outcome.spans.iter().flat_map(|span| &span.displacement);
        let longest = longest.fold(0.0_f64, |longest, d| longest.max(d.norm()));
        let ratio = outcome.net() / longest;
        assert!((1e-3..3e-2).contains(&ratio), "{domain:?} {seed}: {ratio}");
        let met = report.check_tolerance();
        assert!(met.is_ok(), "{domain:?} {seed}: {met:?}\n{}", text.toml());
    }
}

#[test]
#[ignore = "slow: 8 s"]
fn small_random_strokes_meet_the_default_tolerance_in_all_domains_on_an_axis() {
    const X: [f64; 3] = [1.0, 0.0, 0.0];
    for (domain, centre, axis) in [
        (&["domain.kind=unbounded"][..], [0.0; 3], X),
        (
            &["domain.kind=ball", "domain.radius=25"],
            [1.0, 0.0, 0.0],
            X,
        ),
        (&["domain.kind=cylinder", "domain.radius=4"], [0.0; 3], X),
        (&["domain.kind=wall"], [0.0, 0.0, 12.0], [0.0, 0.0, 1.0]),
    ] {
        assert_small_strokes(domain, centre, axis, 3);
    }
}

#[test]
#[ignore = "slow: 9 min, 2 GB"]
fn small_random_strokes_meet_the_default_tolerance_in_all_domains() {
    const OBLIQUE: [f64; 3] = [0.8, 0.0, 0.6];
    for (domain, centre, seeds) in [
        (&["domain.kind=unbounded"][..], [0.0; 3], 20),
        (&["domain.kind=wall"], [0.0, 0.0, 10.0], 3),
        (
            &["domain.kind=ball", "domain.radius=25"],
            [0.0, 2.0, 0.0],
            1,
        ),
        (
            &["domain.kind=box", "domain.size=[30, 30, 30]"],
            [0.0; 3],
            1,
        ),
        (&["domain.kind=cylinder", "domain.radius=12"], [0.0; 3], 1),
    ] {
        assert_small_strokes(domain, centre, OBLIQUE, seeds);
    }
}

#[test]
#[ignore = "slow: 20 s"]
fn bug_a_swimmer_in_a_narrow_tube_missed_every_tolerance() {
    // Its net displacement is a thirtieth of that without a tube.
    for tolerance in [1e-3, 1e-4, 1e-5] {
        let text = SceneText::file(include_str!("../../../../scenes/three-sphere.toml"))
            .set(&["domain.kind=cylinder", "domain.radius=4", "model.kind=auto"])
            .tolerance(tolerance);
        let report = swimmer::run_without_files(text.scene(), &mut ()).unwrap();
        let met = report.check_tolerance();
        assert!(met.is_ok(), "{tolerance:e}: {met:?}");
    }
}

#[test]
fn bug_a_large_rotation_with_a_small_displacement_missed_the_tolerance() {
    // A rotating sphere far above a wall is pushed along it by (a/h)^4 / 8 of the speed of its
    // surface (Goldman, Cox & Brenner 1967): 3e-7.
    let text = SceneText::new()
        .set(&["domain.kind=wall"])
        .shape("a", "radius = 1, torque = [0, 25, 0]", [0, 0, 25])
        .phase("duration = 5");
    let report = swimmer::run_without_files(text.scene(), &mut ()).unwrap();
    let outcome = &report.outcome;
    let arc = outcome.net_arc;
    // `T t / (8 π μ a^3)`, as good as without a wall.
    within(
        arc - 125.0 / (8.0 * std::f64::consts::PI),
        1e-3,
        "the rotation",
    );
    assert!(outcome.net() > outcome.rounding() && outcome.net() < 1e-5 * arc);
    assert!(report.check_tolerance().is_ok());
}
