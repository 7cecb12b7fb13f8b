//! Lighthill's efficiency of runs, against squirmers and of what does not swim.

use swimmer::{Report, Scene, run_without_files};
use testkit::within;

fn report(text: &str) -> Report {
    run_without_files(Scene::parse(text).unwrap(), &mut ()).unwrap()
}

/// A squirmer with the modes `b1` and `b2 = β b1` has the velocity `2 b1 / 3` and the power
/// `(8 π / 3) μ a b1² (2 + β²)`, so that `η = 1 / (2 + β²)` (Lighthill 1952, Blake 1971).
#[test]
fn squirmers_have_the_efficiency_of_lighthill_and_blake() {
    for beta in [0.0, 3.0] {
        let b2 = 0.7 * beta;
        let found = report(&format!(
            "fluid.viscosity = 3\n[model]\nkind = \"multipole\"\ntolerance = 1e-6\n[[bodies]]\n\
             name = \"a\"\nradius = 1.3\nposition = [0, 0, 0]\nslip = {{ b1 = 0.7, b2 = {b2} }}\n\
             [[gait.phases]]\nduration = 2"
        ));
        let efficiency = found.efficiency.unwrap();
        let bar = efficiency.error.unwrap();
        within(
            efficiency.value - 1.0 / (2.0 + beta * beta),
            bar + 1e-12,
            "the bar",
        );
        within(bar, 1e-4, "the bar says something");
        let drag = 6.0 * std::f64::consts::PI * 3.0 * 1.3;
        within(efficiency.drag / drag - 1.0, 1e-9, "Stokes's drag");
        assert_eq!(found.summary()["efficiency"]["value"], efficiency.value);
    }
}

const SWIMMER: &str = "
    model = { kind = \"multipole\", tolerance = 1e-3 }
    bodies = [
        { name = \"a\", radius = 1, position = [-10, 0, 0] },
        { name = \"b\", radius = 1, position = [0, 0, 0] },
        { name = \"c\", radius = 1, position = [10, 0, 0] },
    ]
    links = [
        { name = \"left\", body = \"a\", to = \"b\" },
        { name = \"right\", body = \"c\", to = \"b\" },
    ]
    gait.phases = [
        { link = \"left\", length = 6 },
        { link = \"right\", length = 6 },
        { link = \"left\", length = 10 },
        { link = \"right\", length = 10 },
    ]
";

/// Efficiency is the power of towing over that of the stroke; one of a faster stroke is the same.
#[test]
fn efficiencies_are_powers_over_powers_and_do_not_depend_on_the_time() {
    let slow = report(SWIMMER);
    let efficiency = slow.efficiency.unwrap();
    let (net, work) = (slow.outcome.net(), slow.outcome.work);
    let expected = efficiency.drag * (net / 4.0).powi(2) / (work / 4.0);
    within(efficiency.value / expected - 1.0, 1e-12, "rounding");
    // Three spheres along a line have less drag together than apart, and more than one.
    let alone = 6.0 * std::f64::consts::PI;
    assert!(
        (alone..3.0 * alone).contains(&efficiency.drag),
        "{}",
        efficiency.drag
    );
    let fast = report(
        &SWIMMER
            .replace("length = 6", "length = 6, duration = 0.5")
            .replace("length = 10", "length = 10, duration = 0.5"),
    );
    let ratio = fast.efficiency.unwrap().value / efficiency.value;
    within(ratio - 1.0, 4e-3, "the tolerance, of displacement and work");
}

/// Tables do not have the load that finds the drag.
#[test]
fn bug_the_efficiency_of_a_run_by_tables_was_infinite() {
    let [one, many] =
        ["", "gait.cycles = 20"].map(|cycles| report(&format!("{SWIMMER}\n{cycles}")));
    assert!(many.outcome.lookups > 0);
    let [one, many] = [one, many].map(|report| report.efficiency.unwrap());
    within(many.drag / one.drag - 1.0, 1e-12, "the same shape");
    within(many.value / one.value - 1.0, 2e-3, "twice the tolerance");
}

/// The body that is kept from rotating is the first one; its torque has the lever of all others.
#[test]
fn bug_the_drag_of_a_long_arm_depended_on_the_order_of_the_bodies() {
    let far = "{ name = \"d\", radius = 1, position = [0, 300, 0] },";
    let links = "{ name = \"up\", body = \"d\", to = \"b\" },\n    ]\n    gait";
    let text = SWIMMER.replace("]\n    gait", links);
    let [last, first] = [
        ("]\n    links", format!("{far}\n    ]\n    links")),
        ("bodies = [", format!("bodies = [\n{far}")),
    ]
    .map(|(from, to)| {
        report(&text.replacen(from, &to, 1))
            .efficiency
            .unwrap()
            .drag
    });
    // the inverse of the resistance that holds, and rounding by it
    within(first / last - 1.0, 1e-6, "the order of bodies");
}

#[test]
fn runs_that_do_not_swim_have_no_efficiency() {
    let dragged = "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0], force = [1, 0, 0] }]\n\
                   [[gait.phases]]\nduration = 1";
    let open = SWIMMER
        .rsplit_once("{ link = \"right\", length = 10 },")
        .unwrap();
    let reciprocal = SWIMMER
        .replace("\"right\", length = 6", "\"left\", length = 10")
        .replace("\"right\", length = 10", "\"left\", length = 10");
    for text in [dragged, &format!("{}{}", open.0, open.1), &reciprocal] {
        let report = report(text);
        assert_eq!(report.efficiency, None);
        assert!(report.summary()["efficiency"].is_null());
    }
}
