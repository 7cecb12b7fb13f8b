//! Contact along the path of the bodies, and steps that would overshoot it.

use scene::Scene;
use swimmer::{Integrator, Method, SwimError, choose, simulate, spans};
use testkit::within;

/// A small sphere that is pulled head-on into a fixed one, at the distance 10.35 of the surfaces.
fn pulled(model: &str) -> Scene {
    pulled_for(model, 4.0)
}

fn pulled_for(model: &str, duration: f64) -> Scene {
    let text = r#"
        model.kind = "MODEL"
        bodies = [
            { name = "small", radius = 0.01, position = [0, 0, 0], force = [1, 0, 0] },
            { name = "fixed", radius = 0.01, position = [10.37, 0, 0], fixed = true },
        ]
        gait.phases = [{ duration = DURATION }]
    "#;
    let text = text.replace("DURATION", &format!("{duration:?}"));
    Scene::parse(&text.replace("MODEL", model)).unwrap()
}

#[test]
fn bug_a_pulled_sphere_passed_through_another() {
    // `10.35 6 π μ a / F` without the other sphere, which slows it down over its last radii alone.
    let time = 10.35 * 6.0 * std::f64::consts::PI * 0.01;
    for model in ["oseen", "rpy"] {
        let scene = pulled(model);
        for method in [
            Method::Collocation,
            Method::RungeKutta,
            Method::Euler { steps: 3 },
            Method::Euler { steps: 1000 },
        ] {
            let mut flow = choose(&scene).unwrap().model;
            match simulate(&scene, flow.as_mut(), method, &mut ()) {
                Err(SwimError::Collision { time: found, .. }) => {
                    let why = format!("a hundredth of the way: {model} {method:?}");
                    within(found - time, 0.01 * time, why);
                }
                other => panic!("{model} {method:?}: {:?}", other.map(|o| o.net())),
            }
        }
    }
}

#[test]
fn a_run_that_stops_at_contact_leaves_its_results_up_to_there() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let stopped = swimmer::run(pulled("rpy"), &out, false, &mut (), &mut ()).unwrap();
    let in_memory = swimmer::run_without_files(pulled("rpy"), &mut ()).unwrap();
    assert_eq!(in_memory.outcome.displacement, stopped.outcome.displacement);
    let stopped = stopped.completed();
    assert!(matches!(stopped, Err(SwimError::Collision { .. })));
    let summary = std::fs::read_to_string(out.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    assert!(
        summary["stopped"]
            .as_str()
            .unwrap()
            .contains("'small' and 'fixed' touch")
    );
    let moved = summary["displacement"]["small"][0].as_f64().unwrap();
    // Steps are halved down to 1/16384 of the phase, in which the sphere moves by 1.3e-3.
    assert!((10.34..10.35).contains(&moved), "{moved}");
    let trajectory = std::fs::read_to_string(out.join("trajectory.csv")).unwrap();
    let last = trajectory.lines().last().unwrap();
    let end: f64 = last.split(',').nth(3).unwrap().parse().unwrap();
    assert_eq!(end, moved);
}

/// A massless sphere above a wall, pressed to it by a force that moves it by thousands of radii in
/// unbounded fluid.
#[test]
fn bug_a_sphere_pressed_to_a_wall_gave_no_result() {
    let text = r#"
        model.kind = "multipole"
        domain.kind = "wall"
        bodies = [{ name = "ball", radius = 1, position = [0, 0, 3], force = [0, 0, -1000] }]
        gait.phases = [{ duration = 100 }]
    "#;
    let report = swimmer::run_without_files(Scene::parse(text).unwrap(), &mut ()).unwrap();
    let reached = report.outcome.displacement[0].z;
    let error = report.completed().unwrap_err();
    assert_eq!(error.exit_code(), 3);
    let SwimError::Approach {
        gap,
        speed,
        decay,
        time,
        until,
        ..
    } = error
    else {
        panic!("{error}");
    };
    assert!(gap < 1e-2 && gap > 1e-3, "{gap}");
    within(
        2.0 + reached - gap,
        1e-12,
        "the gap is that of the position",
    );
    // Cox & Brenner (1967): `F = 6 π μ a U (a / h + ln(a / h) / 5 + 0.9713)` up to terms of h ln h.
    let resistance = 6.0 * std::f64::consts::PI * (1.0 / gap - gap.ln() / 5.0 + 0.9713);
    let exact = 1000.0 / resistance;
    within(
        speed - exact,
        2e-3 * exact,
        "the change of the speed over a thousandth of the step",
    );
    within(speed * decay - gap, 1e-12 * gap, "by definition");
    let expected = time + decay * (gap / 1e-3).ln();
    within(until - expected, 1e-12 * expected, "rounding");
}

/// Two spheres that a stiff spring draws from 10 to 4 in a hundredth of the phase.
#[test]
fn bug_runs_with_masses_aborted_on_an_overshooting_first_step() {
    let text = r#"
        model.kind = "rpy"
        bodies = [
            { name = "a", radius = 1, position = [0, 0, 0], mass = 1, inertia = 0.4 },
            { name = "b", radius = 1, position = [10, 0, 0], mass = 1, inertia = 0.4 },
        ]
        links = [{ name = "s", body = "b", to = "a", drive = "spring", stiffness = 200, rest = 4 }]
    "#;
    let run = |gait: &str| {
        let scene = Scene::parse(&format!("{gait}\n{text}")).unwrap();
        let mut model = choose(&scene).unwrap().model;
        simulate(&scene, model.as_mut(), Method::Inertia, &mut ()).unwrap()
    };
    let whole = run("gait.phases = [{ duration = 4 }]");
    let short = run("gait = { cycles = 24, phases = [{ duration = 0.16666666666666666 }] }");
    for (a, b) in whole.displacement.iter().zip(&short.displacement) {
        let bars = [&whole, &short].map(|o| o.error_estimate.integration.unwrap());
        within((a - b).norm(), bars.iter().sum(), "both error bars");
    }
    within(
        whole.displacement[0].x - 3.0,
        1e-3 * 3.0,
        "the tolerance: the spring is at rest",
    );
}

/// Lubrication lets a narrow gap `h` decrease as `h' = -h F / (3/2 π μ a²)`: by a factor of eight
/// in 1e-3.
#[test]
fn a_body_that_lubrication_stops_is_no_collision() {
    let mut before = 0.0;
    for duration in [1.954, 1.955] {
        let scene = pulled_for("auto", duration);
        let mut model = choose(&scene).unwrap().model;
        let outcome = simulate(&scene, model.as_mut(), Method::from_scene(&scene), &mut ());
        let outcome = outcome.unwrap_or_else(|error| panic!("{duration}: {error}"));
        let gap = 10.35 - outcome.displacement[0].x;
        assert!(
            gap > 0.0 && (before == 0.0 || gap < 0.5 * before),
            "{duration}: {gap:e}"
        );
        before = gap;
    }
}

/// A sphere with mass that a stiff spring pushes towards a wall, at half a radius from it.
#[test]
fn bug_runs_with_masses_aborted_where_the_first_step_touches_the_wall() {
    let text = r#"
        domain.kind = "wall"
        model.kind = "rpy"
        bodies = [
            { name = "a", radius = 1, position = [0, 0, 1.6], mass = 1, inertia = 0.4 },
            { name = "b", radius = 1, position = [0, 0, 7.6], mass = 1, inertia = 0.4 },
        ]
        links = [{ name = "s", body = "b", to = "a", drive = "spring", stiffness = 500, rest = 6.8 }]
    "#;
    let scene = |gait: &str| Scene::parse(&format!("{gait}\n{text}")).unwrap();
    let run = |scene: &Scene, method: Method| {
        let mut model = choose(scene).unwrap().model;
        simulate(scene, model.as_mut(), method, &mut ())
    };
    let whole = scene("gait.phases = [{ duration = 4 }]");
    // One step of another method says what a first step meets.
    let one = run(&whole, Method::BackwardEuler { steps: 1 });
    let message = one.map(|o| o.net()).expect_err("it overshoots").to_string();
    assert!(message.contains("'a' touches the wall"), "{message}");
    let whole = run(&whole, Method::Inertia).unwrap();
    let short = scene("gait = { cycles = 24, phases = [{ duration = 0.16666666666666666 }] }");
    let short = run(&short, Method::Inertia).unwrap();
    for (a, b) in whole.displacement.iter().zip(&short.displacement) {
        let bars = [&whole, &short].map(|o| o.error_estimate.integration.unwrap());
        within((a - b).norm(), bars.iter().sum(), "both error bars");
    }
    assert!(whole.displacement[0].z > -0.6);
}

/// A heavy ball that flies at a wall and touches it within the first of the smallest steps.
#[test]
fn bug_a_run_with_masses_that_touches_in_its_first_part_had_no_velocities() {
    let text = r#"
        domain.kind = "wall"
        model.kind = "rpy"
        bodies = [{ name = "a", radius = 1, position = [0, 0, 1.00001], mass = 1000, inertia = 400 }]
        gait.phases = [{ duration = 1 }]
    "#;
    let scene = Scene::parse(text).unwrap();
    let given = [0.0, 0.0, -1.0, 0.0, 0.0, 0.5];
    let span = spans(scene.gait(), &[]).unwrap().next().unwrap();
    let mut model = choose(&scene).unwrap().model;
    for method in [Method::Inertia, Method::BackwardEuler { steps: 3 }] {
        let mut integrator =
            Integrator::new(&scene, model.as_mut(), method).with_velocities(&given);
        let result = integrator.span(&span, &scene.initial_state(), &mut |_, _| Ok(()));
        assert!(
            matches!(result, Err(SwimError::Collision { .. })),
            "{method:?}"
        );
        let so_far = integrator.take_so_far().expect("the start");
        assert_eq!(so_far.reached(), 0.0, "{method:?}");
        assert_eq!(so_far.velocities.len(), 6, "{method:?}");
        for (found, given) in so_far.velocities.iter().zip(given) {
            within(found - given, 1e-12, "rounding of the impulse of no joint");
        }
    }
}
