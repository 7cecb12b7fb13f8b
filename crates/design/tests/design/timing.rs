//! Strokes within bounds on rates and power are as fast as the bounds allow, and no faster.

use design::{DesignedStroke, design_stroke};
use swimmer::models::{Configuration, Query};
use swimmer::spans;
use testkit::{boxed, within};

/// The best stroke of three spheres with these settings, and the share of the period after which
/// the largest rate or the power is below 95 % of its bound, by the model without a table.
fn designed(settings: &[&str], rates: [f64; 2], power: f64) -> (DesignedStroke, f64) {
    let limits = ["lower=6", "upper=10", "terms=8", "tolerance=1e-2"];
    let scene = [&limits, settings]
        .concat()
        .iter()
        .fold(crate::two_arms(1e-6), |text, setting| {
            text.set(&[&format!("optimise.{setting}")])
        });
    let scene = scene.scene();
    let folder = tempfile::tempdir().unwrap();
    let found = design_stroke(&scene, folder.path(), &mut ()).unwrap();
    let mut model = boxed(&found.scene);
    let state = found.scene.initial_state();
    let start = found.scene.articulation().initial_shape();
    let mut slow = 0.0;
    for span in spans(found.scene.gait(), start).unwrap() {
        for s in [0.0, 0.5] {
            let (shape, rate) = (span.shape(s), [span.rates(s)]);
            let (state, shape) = (&state, &shape);
            let configuration = Configuration::new(state, shape);
            let solved = model.solve(&Query::new(configuration, &rate)).unwrap();
            let used = solved[0].power() / power;
            within(
                used,
                1.0 + 1e-4,
                "the table has the tolerance 1e-5 of the largest force",
            );
            let mut largest = used.sqrt();
            for (rate, bound) in rate[0].iter().zip(rates) {
                within(*rate, bound, "the bound on the rate");
                largest = largest.max(rate.abs() / bound);
            }
            if largest < 0.95 {
                slow += 0.5 * span.duration / found.period;
            }
        }
    }
    (found, slow)
}

/// At constant power `T = L / sqrt(P)`, and the displacement per time is largest for the stroke of
/// the highest efficiency.
#[test]
fn a_bound_on_the_power_is_reached_at_all_times() {
    let (found, slow) = designed(&["max_power=2"], [f64::INFINITY; 2], 2.0);
    let shortest = (found.optimum.period_energy_product / 2.0).sqrt();
    within(
        found.period / shortest - 1.0,
        5e-3,
        "half of the tolerance of the search",
    );
    within(slow, 0.01, "steps of the time");
    within(
        found.outcome.work / found.energy - 1.0,
        1e-3,
        "the tolerance of the model",
    );
}

#[test]
fn bounds_on_rates_and_power_hold_along_the_stroke() {
    let bounds = ["max_rate={ a = 0.5, b = 0.3 }", "max_power=6"];
    let (found, slow) = designed(&bounds, [0.5, 0.3], 6.0);
    within(slow, 0.01, "steps of the time");
    assert!(found.peaks.rates[0] <= 0.5 && found.peaks.rates[1] <= 0.3);
    assert!(found.peaks.power <= 6.0);
    // Each of them alone is exceeded by nobody and reached by one.
    let rate = (found.peaks.rates[0] / 0.5).max(found.peaks.rates[1] / 0.3);
    assert!(rate.max((found.peaks.power / 6.0).sqrt()) > 0.999);
}

/// Sides of 4 at a rate of 1: the square takes a time of 16.
#[test]
fn a_bound_on_rates_gives_the_period_of_the_square() {
    let settings = ["objective=displacement", "max_rate=1"];
    let (found, slow) = designed(&settings, [1.0 + 1e-9; 2], f64::INFINITY);
    within(
        found.period - 16.0,
        1e-6,
        "rounding of the times of corners",
    );
    assert_eq!(slow, 0.0);
}

/// At all times some joint moves at its largest rate, and away from the limits both do.
#[test]
fn the_fastest_stroke_is_a_scene_that_runs() {
    let settings = ["objective=speed", "max_rate={ a = 0.5, b = 0.3 }"];
    let rates = [0.5, 0.3].map(|v| v * (1.0 + 1e-9));
    let (found, slow) = designed(&settings, rates, f64::INFINITY);
    assert_eq!(slow, 0.0);
    let start = found.scene.articulation().initial_shape();
    for span in spans(found.scene.gait(), start).unwrap() {
        let (middle, rates) = (span.shape(0.5), span.rates(0.5));
        let is_at_limit = middle.iter().any(|x| (x - 6.0).min(10.0 - x) < 0.01);
        let loads = [rates[0].abs() / 0.5, rates[1].abs() / 0.3];
        assert!(
            is_at_limit || loads.iter().all(|load| *load > 0.99),
            "{middle:?} {rates:?}"
        );
    }
    let table = found.optimum.totals.displacement.norm();
    let bars = found.table_error + found.outcome.error_estimate.total();
    within(table - found.run_displacement, bars, "both error bars");
    within(
        found.outcome.work / found.energy - 1.0,
        1e-3,
        "the tolerance of the model",
    );
}
