//! The best sizes for a gait, against symmetry, a formula and scans by multipoles.

use design::{BestSizes, best_sizes};
use testkit::{SceneText, pair, within};

use crate::three_sphere;

fn found(settings: &[&str]) -> BestSizes {
    best_sizes(&three_sphere().set(settings).scene(), &mut ()).unwrap()
}

/// `Δ ~ a1 a2 a3 / (a1 + a2 + a3)^2` for small strokes of spheres far apart (Golestanian & Ajdari
/// 2008): equal radii are best for a given volume.
#[test]
fn equal_radii_are_best_for_small_strokes_of_spheres_far_apart() {
    let found = found(&[
        "bodies.left.position=[-200, 0, 0]",
        "bodies.right.position=[200, 0, 0]",
        "bodies.left.radius=0.8",
        "bodies.centre.radius=1.1",
        "bodies.right.radius=1.2",
        "gait={ period = 4, harmonics = [{ link = \"left-arm\", amplitude = 2 }, \
         { link = \"right-arm\", amplitude = 2, phase = 1.5707963267948966 }] }",
        "optimise.objective=displacement",
        "optimise.radii=[0.5, 2]",
    ]);
    let radius = ((0.8_f64.powi(3) + 1.1_f64.powi(3) + 1.2_f64.powi(3)) / 3.0).cbrt();
    for value in &found.values {
        let why = "the formula neglects terms of the order of radius over length";
        within(value / radius - 1.0, 1.0 / 200.0, why);
    }
    assert!(found.at_limits.is_empty());
    assert!(found.best.displacement > found.before.displacement);
}

const BALL: &str = "domain={ kind = \"ball\", radius = 30 }";

/// A square stroke is the same seen from the other side and backwards in time, so that both outer
/// spheres have the same best radius; the ratio to the inner one is that of a scan.
#[test]
fn the_best_radii_of_the_square_stroke_are_those_of_a_scan() {
    for domain in ["domain.kind=unbounded", BALL] {
        let settings = [
            domain,
            "bodies.left.radius=0.9",
            "bodies.right.radius=1.15",
            "optimise.radii=[0.3, 3]",
        ];
        let found = found(&settings);
        let [left, centre, right] = found.values[..] else {
            panic!("three radii");
        };
        let bars = &found.errors;
        within(left - right, bars[0] + bars[2], "both error bars");
        assert!(bars.iter().all(|bar| *bar < 5e-3), "{bars:?}");
        // The volume is kept.
        let cubes = |radii: [f64; 3]| radii.map(|r| r.powi(3)).iter().sum::<f64>();
        let volume = cubes([0.9, 1.0, 1.15]);
        within(
            cubes([left, centre, right]) / volume - 1.0,
            1e-12,
            "rounding",
        );
        // A scan over the inner radius, with equal outer ones.
        let efficiency = |inner: f64| {
            let outer = ((volume - inner.powi(3)) / 2.0).cbrt();
            let text = SceneText::file(&found.scene.to_toml().unwrap());
            let text = text
                .with("bodies.left.radius", outer)
                .with("bodies.right.radius", outer);
            let scene = text.with("bodies.centre.radius", inner).scene();
            let time = scene.gait().cycle_duration();
            let run = swimmer::run_without_files(scene, &mut ()).unwrap().outcome;
            let drag = 6.0 * std::f64::consts::PI * (inner + 2.0 * outer);
            drag * run.net().powi(2) / (run.work * time)
        };
        let step = 0.05;
        let scan = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| efficiency(centre + k * step));
        let best = scan.iter().fold(0.0_f64, |best, value| best.max(*value));
        assert_eq!(best, scan[2], "{scan:?}");
        within(
            best / found.best.efficiency - 1.0,
            1e-3,
            "the tolerance of the search",
        );
        // The maximum of the polynomial of degree four through the scan.
        let slope = (8.0 * (scan[3] - scan[1]) - (scan[4] - scan[0])) / (12.0 * step);
        let curvature = (16.0 * (scan[3] + scan[1]) - 30.0 * scan[2] - (scan[4] + scan[0]))
            / (12.0 * step * step);
        let distance = -slope / curvature;
        within(
            distance,
            2.0 * bars[1],
            "the error bar, and that of the scan",
        );
    }
}

/// Equal arms are the worst ones of their sum: `1/l1² + 1/l2² - 1/(l1 + l2)²` is smallest there
/// (Golestanian & Ajdari 2008). The search leaves them, although the derivative is zero, and ends
/// at a limit of the length or of the gap.
#[test]
fn unequal_arms_are_better_than_equal_ones_up_to_the_limit() {
    for (setting, shortest, words) in [
        ("optimise.arms=[4, 30]", 8.0, "smallest allowed"),
        ("optimise.arms=[1, 30]", 7.0, "optimise.gap"),
    ] {
        let found = found(&[setting, "optimise.gap=1", "model.tolerance=1e-4"]);
        let arms = &found.values;
        within(arms[0] + arms[1] - 20.0, 1e-9, "rounding");
        let short = arms[0].min(arms[1]);
        assert!(shortest < short && short < shortest + 0.01, "{arms:?}");
        assert!(found.at_limits.iter().any(|limit| limit.contains(words)));
        // At no time of the gait are spheres closer than allowed: arms contract by four.
        assert!(short - 4.0 - 2.0 >= 1.0);
        let mut all = found.runs.iter().map(|(arms, _)| arms[0].min(arms[1]));
        assert!(all.all(|arm| arm > shortest));
        // Both sides of equal arms are better, and the limit is best.
        let of = |arm: f64| {
            let distance = |arms: &[f64]| (arms[0] - arm).abs();
            let runs = found.runs.iter();
            runs.min_by(|(a, _), (b, _)| distance(a).total_cmp(&distance(b)))
                .unwrap()
                .1
        };
        assert!(of(9.0) > of(10.0) && of(11.0) > of(10.0));
        assert!(found.best.efficiency > 1.1 * found.before.efficiency);
    }
}

/// The optimum does not depend on where the search starts, and radii and arms may vary together.
#[test]
fn radii_and_arms_vary_together() {
    let limits = [
        "optimise.radii=[0.5, 2]",
        "optimise.arms=[4.5, 30]",
        "model.tolerance=1e-2",
    ];
    let of = |settings: &[&str]| found(&[&limits[..], settings].concat());
    let first = of(&["bodies.left.radius=1.2", "bodies.right.radius=0.7636"]);
    let second = of(&["bodies.centre.radius=1.2", "bodies.left.radius=0.7636"]);
    assert_eq!(first.values.len(), 5);
    let relative = first.best.efficiency / second.best.efficiency - 1.0;
    within(
        relative,
        1e-3,
        format!("the tolerance: {:?} {:?}", first.values, second.values),
    );
    assert!(!first.at_limits.is_empty());
}

#[test]
fn sizes_without_an_optimum_are_refused_with_the_reason() {
    for (settings, words) in [
        (&[][..], "optimise.radii = [0.5, 2]"),
        (
            &["optimise.radii=[1.5, 2]"],
            "must be strictly between 1.5 and 2",
        ),
        (&["optimise.arms=[7, 20]"], "along the gait"),
        (
            &["optimise.radii=[0.5, 2]", "optimise.gap=5"],
            "come as close as 4.0000",
        ),
        (
            &["optimise.radii=[0.5, 2]", "optimise.objective=energy"],
            "\"efficiency\" or \"displacement\"",
        ),
        (
            &["optimise.radii=[0.5, 2]", "optimise.direction=[-1, 0, 0]"],
            "turn the direction round",
        ),
    ] {
        let error = best_sizes(&three_sphere().set(settings).scene(), &mut ()).unwrap_err();
        testkit::contains(settings, &error.to_string(), &[words]);
    }
    // The sum of one length leaves nothing to vary.
    let two = pair(0.0, 9.0)
        .phases(&[("arm", 8.0)])
        .with("optimise.arms", "[4, 20]");
    let error = best_sizes(&two.scene(), &mut ()).unwrap_err();
    assert!(error.to_string().contains("at least two arms"), "{error}");
}

/// The same optimum by finite elements in a ball, where meshes change with the sizes.
#[test]
#[ignore = "slow: 3 min"]
fn finite_elements_in_a_ball_find_the_radii_of_multipoles() {
    let settings = [
        BALL,
        "bodies.left.radius=0.9",
        "bodies.right.radius=1.15",
        "optimise.radii=[0.3, 3]",
    ];
    let exact = found(&settings);
    let fem = found(&[&settings[..], &["model.kind=fem"]].concat());
    for k in 0..3 {
        let bar = exact.errors[k] + fem.errors[k];
        within(
            exact.values[k] - fem.values[k],
            bar,
            format!("both error bars: {k}"),
        );
    }
}
