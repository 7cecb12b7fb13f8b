//! Spheres with mass that change their size: the balances of momentum, by hand.

use std::f64::consts::PI;

use swimmer::models::Hydrodynamics;
use swimmer::{Outcome, Scene};
use testkit::{boxed, contains, run, solve_at, within};

/// Steps of the classical Runge-Kutta method by hand, whose errors are far below the bounds.
const STEPS: usize = 400;

/// `y(1)` of `y' = f(t, y)`.
fn integrated<const N: usize>(
    start: [f64; N],
    mut f: impl FnMut(f64, [f64; N]) -> [f64; N],
) -> [f64; N] {
    let h = 1.0 / STEPS as f64;
    let moved = |y: [f64; N], k: [f64; N], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    let mut y = start;
    for step in 0..STEPS {
        let t = step as f64 * h;
        let a = f(t, y);
        let b = f(t + 0.5 * h, moved(y, a, 0.5 * h));
        let c = f(t + 0.5 * h, moved(y, b, 0.5 * h));
        let d = f(t + h, moved(y, c, h));
        y = std::array::from_fn(|i| y[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    y
}

/// A sphere of the radius `a = 1 + a' t` under a force and a torque: `m U' = F - 6 π a U` and
/// `(I ω)' = T - 8 π a^3 ω` with `I = 2/5 m a^2`. Work on the fluid is that of the drags and of
/// breathing, `16 π a a'^2`, without what the mass gives off when it moves outwards.
#[test]
fn momentum_of_a_sphere_that_changes_its_size_follows_its_loads() {
    let mass = 30.0;
    for rate in [1.0, -0.6] {
        let scene = Scene::parse(&format!(
            "model = {{ kind = \"multipole\", tolerance = 1e-8 }}\n[[bodies]]\nname = \"b\"\n\
             radius = 1\nposition = [0, 0, 0]\nmass = {mass}\nforce = [1, 0, 0]\n\
             torque = [0, 0, 9]\ndeformation = {{ kind = \"radius\" }}\n\
             [[gait.phases]]\ntargets = {{ \"b.radius\" = {} }}\nduration = 1",
            1.0 + rate
        ))
        .unwrap();
        let outcome = run(&scene);
        let exact = integrated([0.0; 5], |t, [velocity, _, momentum, _, _]| {
            let a = 1.0 + rate * t;
            let spin = momentum / (0.4 * mass * a * a);
            let [drag, torque] = [6.0 * PI * a * velocity, 8.0 * PI * a.powi(3) * spin];
            let power = drag * velocity + torque * spin + 16.0 * PI * a * rate * rate;
            [(1.0 - drag) / mass, velocity, 9.0 - torque, spin, power]
        });
        let [_, displacement, _, angle, work] = exact;
        let bar = outcome.error_estimate.total();
        within(
            outcome.displacement[0].x - displacement,
            bar + 1e-9,
            "the bar",
        );
        within(bar, 1e-4 * displacement, "the bar says something");
        let bar = outcome.rotation_error.total();
        within(outcome.rotation.z - angle, bar + 1e-8, "the bar");
        within(bar, 1e-3 * angle, "the bar says something");
        let bar = outcome.work_error.total();
        within(outcome.work - work, bar + 1e-8 * work, "the bar");
        within(bar, 1e-4 * work, "the bar says something");
    }
}

/// The same balance of momentum in the meridian plane, without a torque about the axis.
#[test]
fn momentum_of_a_sphere_that_changes_its_size_in_the_meridian_plane() {
    let (mass, rate) = (30.0, 0.8);
    let scene = Scene::parse(&format!(
        "model = {{ kind = \"axisymmetric\", tolerance = 1e-5 }}\n[[bodies]]\nname = \"b\"\n\
         radius = 1\nposition = [0, 0, 0]\nmass = {mass}\nforce = [1, 0, 0]\n\
         deformation = {{ kind = \"radius\" }}\n\
         [[gait.phases]]\ntargets = {{ \"b.radius\" = {} }}\nduration = 1",
        1.0 + rate
    ))
    .unwrap();
    let outcome = run(&scene);
    let [_, displacement, work] = integrated([0.0; 3], |t, [velocity, ..]| {
        let a = 1.0 + rate * t;
        let drag = 6.0 * PI * a * velocity;
        let power = drag * velocity + 16.0 * PI * a * rate * rate;
        [(1.0 - drag) / mass, velocity, power]
    });
    let bar = outcome.error_estimate.total();
    within(
        outcome.displacement[0].x - displacement,
        bar + 1e-9,
        "the bar",
    );
    within(bar, 1e-3 * displacement, "the bar says something");
    let bar = outcome.work_error.total();
    within(outcome.work - work, bar + 1e-8 * work, "the bar");
    within(bar, 1e-3 * work, "the bar says something");
}

/// Two massive spheres in a ball exchange volume while their arm closes: multipoles, the meridian
/// plane and elements in space agree.
fn exchange_of_massive_spheres(model: &str) -> Outcome {
    let text = format!(
        r#"
        model = {{ {model} }}
        domain = {{ kind = "ball", radius = 8 }}
        bodies = [
            {{ name = "a", radius = 1, position = [-2, 0, 0], mass = 20, force = [30, 0, 0] }},
            {{ name = "b", radius = 1.3, position = [2, 0, 0], mass = 50 }},
        ]
        links = [
            {{ name = "arm", body = "b", to = "a" }},
            {{ name = "flow", body = "a", to = "b", joint = "exchange" }},
        ]
        gait.phases = [{{ targets = {{ arm = 3.5, flow = 8 }}, duration = 1 }}]
        "#
    );
    run(&Scene::parse(&text).unwrap())
}

fn check_exchange_of_massive_spheres(model: &str, share: f64) {
    let exact = exchange_of_massive_spheres("kind = \"multipole\", tolerance = 1e-6");
    let found = exchange_of_massive_spheres(model);
    let bars = exact.error_estimate.total() + found.error_estimate.total();
    let norms = exact.displacement.iter().map(|x| x.norm());
    let largest = norms.fold(0.0, f64::max);
    within(bars, share * largest, "the bars say something");
    for (found, exact) in found.displacement.iter().zip(&exact.displacement) {
        within((found - exact).norm(), bars, "both error bars");
    }
    let bars = exact.work_error.total() + found.work_error.total();
    within(found.work - exact.work, bars, "both error bars");
    within(bars, share * exact.work, "the bars say something");
}

#[test]
#[ignore = "slow: 60 s"]
fn massive_spheres_exchange_volume_in_the_meridian_plane_as_by_multipoles() {
    check_exchange_of_massive_spheres("kind = \"axisymmetric\", tolerance = 1e-4", 1e-2);
}

#[test]
#[ignore = "slow: 2 min"]
fn massive_spheres_exchange_volume_by_elements_as_by_multipoles() {
    check_exchange_of_massive_spheres("kind = \"fem\", tolerance = 0.01", 3e-2);
}

/// Two spheres on an arm that closes while one of them grows: `m_a U_a' + m_b U_b'` is the force of
/// the fluid, which depends linearly on the velocity and vanishes at that of massless spheres. The
/// impulse of the arm at the start conserves the momentum.
#[test]
fn momentum_of_a_linked_sphere_that_grows_is_that_of_the_force_of_the_fluid() {
    let scene = |keys: [&str; 2], gait: &str| {
        let [a, b] = keys;
        Scene::parse(&format!(
            "model = {{ kind = \"multipole\", tolerance = 1e-7 }}\n[[bodies]]\nname = \"a\"\n\
             radius = 1\nposition = [0, 0, 0]\ndeformation = {{ kind = \"radius\" }}\n{a}\n\
             [[bodies]]\nname = \"b\"\nradius = 1\nposition = [5, 0, 0]\n{b}\n\
             [[links]]\nname = \"arm\"\nbody = \"b\"\nto = \"a\"\n{gait}"
        ))
        .unwrap()
    };
    let masses = [20.0, 50.0];
    let gait = "[[gait.phases]]\ntargets = { arm = 4, \"a.radius\" = 1.4 }\nduration = 1";
    let massive = scene(["mass = 20", "mass = 50"], gait);
    let outcome = run(&massive);

    let [mut free, mut pulled] =
        ["", "force = [1, 0, 0]"].map(|load| boxed(&scene([load, ""], "")));
    let joints = massive.articulation().joints();
    let arm = joints.iter().position(|joint| joint.name == "arm").unwrap();
    let ordered = |of_arm: f64, of_radius: f64| match arm {
        0 => [of_arm, of_radius],
        _ => [of_radius, of_arm],
    };
    let all = masses[0] + masses[1];
    let start = masses[1] / all;
    let [_, displacement] = integrated([start, 0.0], |t, [velocity, _]| {
        let (values, rates) = (ordered(5.0 - t, 1.0 + 0.4 * t), ordered(-1.0, 0.4));
        let at = |model: &mut Box<dyn Hydrodynamics>| {
            solve_at(model.as_mut(), &values, &rates).bodies[0]
                .velocity
                .x
        };
        let (free, pulled) = (at(&mut free), at(&mut pulled));
        // A force of one changes the velocity by the mobility.
        [(free - velocity) / (pulled - free) / all, velocity]
    });
    let bar = outcome.error_estimate.total();
    within(
        outcome.displacement[0].x - displacement,
        bar + 1e-7,
        "the bar",
    );
    within(bar, 1e-3 * displacement.abs(), "the bar says something");
}

/// Masses beside deformations whose inside the surface does not tell are refused.
#[test]
fn masses_of_other_deformations_are_refused() {
    let refusal = |keys: &str, settings: &str| {
        let text = format!(
            "{settings}\n[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\nmass = 1\n{keys}"
        );
        Scene::parse(&text).unwrap_err().to_string()
    };
    let modes = "deformation = { modes = { p = 2 }, axis = [1, 0, 0] }";
    contains(
        "modes",
        &refusal(modes, ""),
        &["bodies[0].mass", "more than its size"],
    );
    let size = "deformation = { kind = \"radius\" }";
    let heavy = "gravity = [0, 0, -1]\nfluid.density = 1";
    contains(
        "gravity",
        &refusal(size, heavy),
        &["bodies[0].mass", "buoyancy"],
    );
    let rigid = "[[bodies]]\nname = \"b\"\nradius = 1\nposition = [4, 0, 0]\n";
    assert!(
        Scene::parse(&format!(
            "[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n{modes}\n{rigid}mass = 1"
        ))
        .is_ok()
    );
}
