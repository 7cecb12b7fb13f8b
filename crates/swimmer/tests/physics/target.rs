//! Meshes adapted to a target error, compared with exact values.

use std::f64::consts::PI;

use approx::assert_relative_eq;
use swimmer::models::FemModel;
use swimmer::{Interim, Method, Outcome, Scene, SizeSearch, simulate_to_target, solve_start};

/// Two unit spheres pushed towards each other along their line of centres in a ball of radius 60.
fn pair(distance: f64, more: &str) -> Scene {
    let sphere = |name: &str, x: f64| {
        format!(
            "[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{x:?}, 0, 0]\nforce = [{:?}, 0, 0]\n",
            -x.signum()
        )
    };
    let text = format!(
        "domain = {{ kind = \"ball\", radius = 60 }}\nmodel.kind = \"fem\"\n{more}\n{}{}",
        sphere("a", -0.5 * distance),
        sphere("b", 0.5 * distance)
    );
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Degrees of freedom and true relative error of the speed of two approaching spheres at a distance
/// of 2.5.
fn approach(more: &str) -> (usize, f64) {
    // Stimson & Jeffery 1926, Maude 1961: force over 6 pi U. The forces are opposite, so the effect
    // of the wall is below (2.5 / 60)^3.
    let exact = 1.0 / (6.0 * PI * 2.772418679559134);
    let scene = pair(2.5, more);
    let instant = solve_start(&scene, &mut FemModel::new(&scene).unwrap()).unwrap();
    let speed = 0.5 * (instant.bodies[0].velocity.x - instant.bodies[1].velocity.x);
    (instant.dofs.total, (speed / exact - 1.0).abs())
}

#[test]
fn adapted_meshes_meet_their_target_with_fewer_dofs_than_uniform_growth() {
    let target = 5e-4;
    let (adapted, error) = approach(&format!("fem.target = {target:?}"));
    // Within a factor two, on either side.
    assert!(
        (0.25 * target..=target).contains(&error),
        "{adapted} degrees of freedom, {error:.2e}"
    );
    // The coarsest equally accurate mesh whose sizes grow from the bodies at the best rate for a
    // sphere.
    let graded = [0.6, 0.5, 0.4, 0.3]
        .map(|size| approach(&format!("fem.surface_size = {size:?}")))
        .into_iter()
        .find(|(_, graded)| *graded <= error);
    assert!(
        graded.is_none_or(|(dofs, _)| adapted < dofs),
        "{adapted} against {graded:?}"
    );
}

#[test]
fn a_given_size_factor_is_kept() {
    let fixed = approach("fem = { target = 1e-6, size_factor = 1.5 }");
    let plain = approach("fem.size_factor = 1.5");
    assert_eq!(fixed, plain);
    let scene = pair(4.0, "fem = { target = 1e-6, size_factor = 1.5 }");
    assert!(SizeSearch::new(&scene).unwrap().is_none());
}

#[test]
#[ignore = "slow: 2 min, strokes on four meshes"]
fn strokes_meet_their_target_error() {
    // Spectral, ball of 40.
    let exact = 0.1604180159643671;
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/three-sphere.toml"
    ))
    .unwrap();
    for target in [1e-2, 1e-3, 1e-4] {
        let scene = Scene::parse(&format!("{text}\n[fem]\ntarget = {target:?}\n")).unwrap();
        let (_, outcome) = simulate_to_target(&scene, Method::Collocation, &mut ()).unwrap();
        let error = (outcome.displacement[1].x / exact - 1.0).abs();
        let bars = &outcome.error_estimate;
        let mesh = bars.mesh.unwrap() / outcome.net();
        assert!(mesh <= target, "{target:e}: {mesh:.2e}");
        let bar = bars.total() / outcome.net();
        assert!(error <= bar, "{target:e}: {error:.2e} {bar:.2e}");
    }
}

/// A swimmer with short arms in a small ball that closes one of them, which takes a fifth of a
/// second on a coarse mesh.
fn swimmer_with_target(target: f64, surface_size: f64) -> Scene {
    Scene::parse(&format!(
        r#"
        domain = {{ kind = "ball", radius = 12 }}
        model = {{ kind = "fem", tolerance = 0.1 }}
        fem = {{ target = {target:?}, surface_size = {surface_size} }}
        bodies = [
            {{ name = "l", radius = 1, position = [-4, 0, 0] }},
            {{ name = "c", radius = 1, position = [0, 0, 0] }},
            {{ name = "r", radius = 1, position = [4, 0, 0] }},
        ]
        links = [
            {{ name = "left", body = "l", to = "c" }},
            {{ name = "right", body = "r", to = "c" }},
        ]
        gait.phases = [{{ link = "left", length = 3 }}]
        "#
    ))
    .unwrap()
}

#[test]
fn a_stroke_that_misses_its_target_is_repeated_with_smaller_elements() {
    let run = |target: f64, surface_size: f64| {
        let scene = swimmer_with_target(target, surface_size);
        let first = SizeSearch::new(&scene).unwrap().unwrap().size_factor();
        let (sized, outcome) = simulate_to_target(&scene, Method::Collocation, &mut ()).unwrap();
        let error = outcome.error_estimate.mesh.unwrap() / outcome.net();
        assert!(error <= target, "{error:.2e} for {target:e}");
        [first, sized.fem().size_factor.unwrap()]
    };
    // The coarsest mesh, whatever the target above its error.
    assert_eq!(run(0.9, 0.4), [FemModel::COARSEST_SIZE_FACTOR; 2]);
    // The first factor is that for a surface size of 0.4, so the error of 0.7 is nine times as
    // large.
    let [first, last] = run(1e-3, 0.7);
    assert!(last < 0.9 * first, "{first} {last}");
}

/// The outcome of a stroke with a net displacement of 2 and an estimated error.
fn outcome(scene: &Scene, error: Option<f64>) -> Outcome {
    let mut outcome = Interim::start(scene).unwrap().outcome;
    outcome.displacement = vec![nalgebra::Vector3::x() * 2.0; 3];
    outcome.error_estimate.mesh = error;
    outcome
}

#[test]
fn sizes_for_a_target_follow_from_the_error_of_the_stroke_before() {
    let target = 1e-3;
    let scene = swimmer_with_target(target, 0.4);
    let start = SizeSearch::new(&scene).unwrap().unwrap();
    // 0.6 of the target, where default sizes have an error of 3e-4 and the order is 4.
    assert_relative_eq!(
        start.size_factor(),
        2.0_f64.powf(0.25),
        max_relative = 1e-14
    );
    // Met, or unknown.
    for error in [Some(2.0 * target), Some(0.0), Some(f64::NAN), None] {
        let mut search = start.clone();
        assert_eq!(search.refine(&outcome(&scene, error)), None, "{error:?}");
        assert_eq!(search.size_factor(), start.size_factor());
    }
    // Missed by a factor of two: 0.6 of the target with the order 4.
    let mut search = start.clone();
    let missed = search.refine(&outcome(&scene, Some(4.0 * target))).unwrap();
    assert_eq!(missed.size_factor, start.size_factor());
    assert_relative_eq!(missed.relative_error, 2.0 * target, max_relative = 1e-14);
    let ratio = search.size_factor() / start.size_factor();
    assert_relative_eq!(ratio, 0.3_f64.powf(0.25), max_relative = 1e-14);
    // Missed by far: half the sizes, four times at most.
    let mut search = start.clone();
    let far = outcome(&scene, Some(1e3 * target));
    for k in 1..=4 {
        assert!(search.refine(&far).is_some());
        let ratio = search.size_factor() / start.size_factor();
        assert_relative_eq!(ratio, 0.5_f64.powi(k), max_relative = 1e-14);
    }
    assert_eq!(search.refine(&far), None);
    // A scallop has no net displacement: the error is relative to that of a phase.
    let mut scallop = outcome(&scene, Some(0.5 * target));
    scallop.displacement = vec![nalgebra::Vector3::zeros(); 3];
    scallop.spans = vec![
        serde_json::from_value(serde_json::json!({
            "joints": [0], "displacement": [[1.0, 0.0, 0.0]], "solves": 1, "error_estimate": {},
        }))
        .unwrap(),
    ];
    assert_eq!(start.clone().refine(&scallop), None);
}
