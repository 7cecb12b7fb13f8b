//! Periodic states of fluids with inertia.

use scene::Scene;
use swimmer::{Outcome, SwimError, run_without_files};
use testkit::{contains, within};

/// A neutral squirmer in the middle of a ball, with the speed 1e-3 in unbounded fluid, so that it
/// hardly moves. In a fluid of density 1 what remains of a start decays by half in a cycle.
const SQUIRMER: &str = r#"
    fluid = { density = 1, inertia = "unsteady" }
    domain = { kind = "ball", radius = 3 }
    model.tolerance = 1e-2
    bodies = [{ name = "squirmer", radius = 1, density = 1, position = [0, 0, 0], slip = { b1 = 1.5e-3, axis = [0, 0, 1] } }]
    gait = { periodic = true, phases = [{ duration = 0.2 }] }
"#;

fn outcome(text: &str) -> Outcome {
    let report = run_without_files(Scene::parse(text).unwrap(), &mut ()).unwrap();
    report.completed().unwrap().outcome
}

/// The limit of the start-up of this squirmer in the tests of `inertia`, from a closed form.
#[test]
fn a_squirmer_in_its_periodic_state_has_its_steady_speed() {
    let exact = 0.2 * 0.917_355_371_9e-3;
    let found = outcome(SQUIRMER);
    let (moved, bar) = (found.displacement[0].z, found.error_estimate.total());
    within(moved - exact, bar, "displacement in the periodic state");
    let start = found.periodic_start.unwrap();
    // a tenth of the tolerance of 1e-2, and part of the bar
    assert!(
        start.remainder <= 1e-3 * exact && start.remainder <= bar,
        "{start:?}"
    );
    // Half remains in each cycle: of the first one 6e-2 of the displacement.
    assert!((6..20).contains(&start.cycles), "{start:?}");
    assert!(found.tolerance_met, "{found:?}");
    let from_rest = outcome(&SQUIRMER.replace("periodic = true, ", ""));
    let lost = exact - from_rest.displacement[0].z;
    assert!(lost > 10.0 * bar, "{lost} {bar}");
}

/// A run from the periodic state goes on as one from rest after the same cycles, in space too.
#[test]
fn a_periodic_state_is_that_of_many_cycles() {
    let in_space = SQUIRMER.replace(
        "model.tolerance = 1e-2",
        "model = { kind = \"fem\", tolerance = 5e-2 }\nfem = { size_factor = 1.75, estimates = \"off\" }",
    );
    for text in [SQUIRMER, &in_space] {
        let periodic = outcome(text);
        let cycles = periodic.periodic_start.unwrap().cycles;
        let many = format!("periodic = false, cycles = {}, ", cycles + 1);
        let transient = outcome(&text.replace("periodic = true, ", &many));
        let last = transient.spans.last().unwrap().displacement[0].z;
        let moved = periodic.displacement[0].z;
        // Times, and what steps of a phase are compared with, differ by rounding.
        within(moved - last, 1e-9 * last, "displacement in the last cycle");
        // Before it were the other cycles.
        let before = transient.displacement[0].z - last;
        let at = periodic.samples[0].poses[0].translation.z;
        within(at - before, 1e-9 * before, "place at the start");
    }
}

/// A sphere that sinks towards a wall is slower in each cycle, and a gait must close.
#[test]
fn motions_without_a_periodic_state_are_refused_with_a_remedy() {
    let sinking = r#"
        fluid = { density = 1, inertia = "unsteady", time_step = 0.1 }
        domain = { kind = "ball", radius = 3 }
        model.tolerance = 1e-3
        gravity = [0, 0, -1]
        bodies = [{ name = "ball", radius = 1, density = 1.5, position = [0, 0, 0] }]
        gait = { periodic = true, phases = [{ duration = 0.3 }] }
    "#;
    let error = error(sinking);
    assert!(
        matches!(error, SwimError::NotPeriodicFlow { cycles: 40, .. }),
        "{error}"
    );
    assert_eq!(error.exit_code(), 3);
    contains(
        "sinking",
        &error.to_string(),
        &["40 cycles", "larger domain", "several cycles"],
    );
    let open = r#"
        fluid = { density = 1, inertia = "unsteady" }
        domain = { kind = "ball", radius = 6 }
        bodies = [
            { name = "a", radius = 1, position = [-2, 0, 0] },
            { name = "b", radius = 1, position = [2, 0, 0] },
        ]
        links = [{ name = "arm", body = "b", to = "a" }]
        gait = { periodic = true, phases = [{ link = "arm", length = 3.5 }] }
    "#;
    let error = self::error(open);
    assert_eq!(error.exit_code(), 2);
    contains(
        "open",
        &error.to_string(),
        &["gait.periodic", "closes", "arm"],
    );
}

fn error(text: &str) -> SwimError {
    let report = run_without_files(Scene::parse(text).unwrap(), &mut ());
    report.expect_err("has no periodic state")
}
