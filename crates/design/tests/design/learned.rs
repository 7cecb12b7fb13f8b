//! Learned strokes: rewards, optimal cycles and what learners find.
//!
//! Rewards by exact multipoles: spheres of radius 1, arms of 10 that contract by 4 (Tsang, Tong,
//! Nallan & Pak 2020).

use design::learn::{
    ArmStates, LearningOptions, Rewards, best_cycle, greedy_cycle, learn, rewards,
};
use swimmer::Scene;

/// A chain of spheres with arms of ten radii that contract to six.
fn chain(spheres: usize) -> Rewards {
    let mut text = "model = { kind = \"multipole\", tolerance = 1e-8 }\n\
                    learn.contracted = 6\n"
        .to_owned();
    for k in 0..spheres {
        text += &format!(
            "[[bodies]]\nname = \"{k}\"\nradius = 1\nposition = [{}, 0, 0]\n",
            10 * k
        );
    }
    for k in 1..spheres {
        text += &format!(
            "[[links]]\nname = \"arm-{k}\"\nbody = \"{k}\"\nto = \"{}\"\n",
            k - 1
        );
    }
    rewards(&Scene::parse(&text).unwrap(), &mut ()).unwrap()
}

fn options(discount: f64, is_double: bool) -> LearningOptions {
    LearningOptions {
        is_double,
        episodes: 100,
        steps: 100,
        discount,
        rate: 0.5,
        exploration: 0.3,
        seed: 1,
    }
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
        assert!((found - exact).abs() < 2e-9, "{state:b} {action}: {found}");
    }
    let best = best_cycle(&rewards);
    assert_eq!(best.states, [0b00, 0b01, 0b11, 0b10]);
    assert!((best.per_step() - 0.039_951_335_1).abs() < 1e-9);
    assert!((best.per_cycle - 0.159_805_340_4).abs() < 4e-9);
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
    assert!(per_cycle(0.27).abs() < 1e-12);
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
    assert!(
        (best.per_step() - 0.064_539_809_4).abs() < 2e-9,
        "{}",
        best.per_step()
    );
    assert!((best.per_cycle - 0.387_238_856_5).abs() < 1e-8);
    let learned = learn(&mut ArmStates::new(&rewards), &options(0.9, false));
    assert_eq!(greedy_cycle(&rewards, &learned.policy), best);
}
