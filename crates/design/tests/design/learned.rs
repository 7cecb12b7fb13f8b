//! Learned strokes: rewards, optimal cycles and what learners find.
//!
//! Rewards by exact multipoles: spheres of radius 1, arms of 10 that contract by 4 (Tsang, Tong,
//! Nallan & Pak 2020).

use design::learn::{
    ArmStates, LearningOptions, Rewards, best_cycle, greedy_cycle, learn, rewards,
};
use testkit::exact::STROKE;
use testkit::{SceneText, within};

/// A chain of spheres with arms of ten radii that contract to six.
fn chain(spheres: usize) -> Rewards {
    let text = (0..spheres).fold(SceneText::new(), |text, k| {
        text.sphere(&k.to_string(), 1.0, [10 * k, 0, 0])
    });
    let text = (1..spheres).fold(text, |text, k| {
        text.slide(&format!("arm-{k}"), &k.to_string(), &(k - 1).to_string())
    });
    let scene = text
        .model("multipole", 1e-8)
        .with("learn.contracted", 6)
        .scene();
    rewards(&scene, &mut ()).unwrap()
}

fn options(discount: f64, is_double: bool) -> LearningOptions {
    LearningOptions::default()
        .with_is_double(is_double)
        .with_discount(discount)
}

#[test]
fn three_spheres_learn_the_optimal_cycle() {
    let rewards = chain(3);
    // State (left, right), 1 if contracted: displacement of the centroid.
    for (state, action, exact) in [
        (0b00, 0, -0.019_300_998_5),
        (0b01, 1, 0.099_203_668_7),
        (0b11, 0, 0.099_203_668_7),
        (0b10, 1, -0.019_300_998_5),
        (0b00, 1, 0.019_300_998_5),
    ] {
        let found = rewards.of(state, action);
        within(
            found - exact,
            2e-9,
            format!("the tolerance of 1e-8: {state:b} {action}"),
        );
    }
    let best = best_cycle(&rewards);
    assert_eq!(best.states, [0b00, 0b01, 0b11, 0b10]);
    within(
        best.per_step() - STROKE.value / 4.0,
        1e-9,
        "the tolerance of 1e-8",
    );
    within(
        best.per_cycle - STROKE.value,
        4e-9,
        "four times that of a step",
    );
    for is_double in [false, true] {
        let learned = learn(&mut ArmStates::new(&rewards), &options(0.9, is_double));
        assert_eq!(greedy_cycle(&rewards, &learned.policy), best);
        assert_eq!(learned.curve.len(), 100);
    }
}

/// The cycle is optimal from every state only for a discount above 0.274819: the first step of the
/// cycle has a negative reward.
#[test]
fn short_sighted_swimmers_go_back_and_forth() {
    let rewards = chain(3);
    let per_cycle = |discount: f64| {
        let learned = learn(&mut ArmStates::new(&rewards), &options(discount, false));
        greedy_cycle(&rewards, &learned.policy).per_cycle
    };
    within(per_cycle(0.27), 1e-12, "rounding");
    assert!(per_cycle(0.28) > 0.15);
}

#[test]
fn four_spheres_swim_best_by_a_travelling_wave() {
    let rewards = chain(4);
    let best = best_cycle(&rewards);
    let names: Vec<String> = best
        .states
        .iter()
        .map(|&state| rewards.name(state))
        .collect();
    assert_eq!(names, ["000", "100", "110", "111", "011", "001"]);
    within(
        best.per_step() - 0.064_539_809_4,
        2e-9,
        "the tolerance of 1e-8",
    );
    within(
        best.per_cycle - 0.387_238_856_5,
        1e-8,
        "the tolerance of 1e-8",
    );
    let learned = learn(&mut ArmStates::new(&rewards), &options(0.9, false));
    assert_eq!(greedy_cycle(&rewards, &learned.policy), best);
}
