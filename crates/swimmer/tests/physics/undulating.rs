//! Tubes that undulate, against rigid bodies of the same shape and resistive-force theory.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};
use swimmer::Scene;
use swimmer::models::InstantaneousSolution;
use testkit::{boxed, run, solve_at, within};

/// A tube of length 6 and radius 0.3 with a wave, and other keys of the body and of the elements.
fn tube(wave: &str, amplitude: f64, body: &str, size: f64) -> Scene {
    let text = format!(
        r#"
        fem.surface_size = {size}
        [[bodies]]
        name = "worm"
        shape = "tube"
        length = 6
        radius = 0.3
        position = [0, 0, 0]
        deformation = {{ kind = "undulation", wave = "{wave}", amplitude = {amplitude} }}
        {body}
        [[gait.phases]]
        targets = {{ "worm.phase" = {TAU:?} }}
        "#
    );
    Scene::parse(&text).unwrap()
}

/// The solution at a phase for a rate of one of the phase or none.
fn solution(scene: &Scene, phase: f64, rate: f64) -> InstantaneousSolution {
    let amplitude = scene.articulation().initial_shape()[0];
    solve_at(boxed(scene).as_mut(), &[amplitude, phase], &[0.0, rate])
}

/// A helical wave that does not move is the rigid helix: with the slope a and the wave number
/// k = 2 π / 6 its radius is a / k and its pitch 6 √(1 - a²). It starts at the angle 90 degrees.
#[test]
fn a_wave_at_rest_is_the_rigid_helix() {
    let slope = 0.6_f64;
    let loads = "force = [1, 2, 0]\ntorque = [0, 0.5, -1]";
    let wave = tube("helix", slope, loads, 0.2);
    let (radius, pitch) = (slope * 6.0 / TAU, 6.0 * (1.0 - slope * slope).sqrt());
    let helix = Scene::parse(&format!(
        r#"
        fem.surface_size = 0.2
        [[bodies]]
        name = "worm"
        shape = "helix"
        radius = {radius:?}
        tube_radius = 0.3
        pitch = {pitch:?}
        turns = 1
        orientation = [{angle:?}, 0, 0]
        position = [0, 0, 0]
        {loads}
        "#,
        angle = 0.5 * PI,
    ))
    .unwrap();
    let bent = solution(&wave, 0.0, 0.0);
    let rigid = solve_at(boxed(&helix).as_mut(), &[], &[]);
    let bar = bent.error_estimate.total() + rigid.error_estimate.total();
    let difference = bent.bodies[0].velocity - rigid.bodies[0].velocity;
    within(difference.norm(), bar, "the error bars");
    within(
        bar,
        0.02 * rigid.bodies[0].velocity.norm(),
        "the bar says something",
    );
}

/// A phase turns a helical wave about -x, with all that it causes: exact kinematics.
#[test]
fn phases_of_helical_waves_turn_their_velocities() {
    let phase = 1.1;
    let wave = tube("helix", 0.6, "", 0.24);
    let [start, later] = [0.0, phase].map(|phase| solution(&wave, phase, 1.0));
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), -phase);
    let [from, to] = [&start.bodies[0], &later.bodies[0]];
    let bar = start.error_estimate.total() + later.error_estimate.total();
    let difference = to.velocity - turn * from.velocity;
    within(difference.norm(), bar, "the error bars");
    within(bar, 0.05 * from.velocity.norm(), "the bar says something");
    let bar = start.angular_velocity_error.total() + later.angular_velocity_error.total();
    let difference = to.angular_velocity - turn * from.angular_velocity;
    within(difference.norm(), bar, "the error bars");
}

/// Speed along the axis of a helical wave that does not rotate, by resistive-force theory with the
/// coefficients of Lighthill (1976).
fn resistive_speed(slope: f64) -> f64 {
    let (k, a) = (TAU / 6.0, 0.3);
    let cosine = (1.0 - slope * slope).sqrt();
    let logarithm = (0.18 * TAU / k / cosine / a).ln();
    let (along, across) = (2.0 * PI / logarithm, 4.0 * PI / (logarithm + 0.5));
    // The force along the axis of U e_x - e_x × X vanishes.
    let excess = along - across;
    excess * cosine * slope * slope / k / (across + excess * cosine * cosine)
}

/// A short tube that is held against rotation is within a factor of two of resistive-force theory,
/// whose errors are of the order 1 / ln; the speed of small waves is quadratic in the slope up to
/// the fourth power, and finer elements stay within the bar.
#[test]
fn helical_waves_swim_as_resistive_force_theory_says() {
    let speed = |slope: f64, size: f64| {
        let held = "angular_velocity = [0, 0, 0]";
        let solved = solution(&tube("helix", slope, held, size), 0.0, 1.0);
        (solved.bodies[0].velocity.x, solved.error_estimate.total())
    };
    let (found, bar) = speed(0.4, 0.3);
    let ratio = found / resistive_speed(0.4);
    assert!(
        (0.5..2.0).contains(&ratio),
        "{found} of {}",
        resistive_speed(0.4)
    );
    let (finer, finer_bar) = speed(0.4, 0.17);
    within(finer - found, bar + finer_bar, "the error bars");
    let (finest, finest_bar) = speed(0.4, 0.14);
    within(finest - finer, finer_bar + finest_bar, "the error bars");
    within(finest - found, bar, "inside the bar of the coarsest");
    within(finest_bar, 0.05 * found.abs(), "the bar says something");
    within(bar, 0.1 * found.abs(), "the bar says something");
    let (small, small_bar) = speed(0.2, 0.3);
    let allowed = 0.25 * small.abs() * 4.0 + bar + 4.0 * small_bar;
    within(
        found - 4.0 * small,
        allowed,
        "slopes squared are small compared with one",
    );
}

/// One half of the fluid beside the plane of a wave is enough: motions, power and stresslet are
/// those of the whole, also of a worm that has turned in the plane, on meshes that move.
#[test]
fn a_wave_in_a_plane_needs_half_of_the_fluid() {
    let [half, whole] = ["auto", "off"].map(|symmetry| {
        let text = tube("curvature", 0.8, "orientation = [0, 0, 0.4]", 0.24)
            .to_toml()
            .unwrap();
        let set = format!("symmetry = \"{symmetry}\"");
        let text = text.replace("symmetry = \"auto\"", &set);
        let scene = Scene::parse(&text).unwrap();
        assert_eq!(
            scene.fem_symmetry_planes(),
            [false, false, symmetry == "auto"]
        );
        let mut model = boxed(&scene);
        [0.7, 0.75].map(|phase| solve_at(model.as_mut(), &[0.8, phase], &[0.0, 1.0]))
    });
    assert!(half[1].remeshed.is_none(), "the second mesh is moved");
    for (half, whole) in half.iter().zip(&whole) {
        assert!(2 * half.dofs.total < whole.dofs.total + whole.dofs.total / 4);
        let bar = half.error_estimate.total() + whole.error_estimate.total();
        let velocities = [half, whole].map(|solution| solution.bodies[0].velocity);
        within(
            (velocities[0] - velocities[1]).norm(),
            bar,
            "the error bars",
        );
        within(bar, 0.02 * velocities[1].norm(), "the bar says something");
        let spins = [half, whole].map(|solution| solution.bodies[0].angular_velocity);
        let bar = half.angular_velocity_error.total() + whole.angular_velocity_error.total();
        within((spins[0] - spins[1]).norm(), bar, "the error bars");
        let bar = half.power_error.total() + whole.power_error.total();
        within(half.power() - whole.power(), bar, "the error bars");
        within(bar, 0.05 * whole.power(), "the bar says something");
    }
}

/// A beat of the template of the sperm, with the bar of its mesh against finer elements.
#[test]
#[ignore = "slow: 40 s"]
fn the_sperm_swims_head_first() {
    let scene = Scene::parse(include_str!("../../templates/sperm.toml")).unwrap();
    let outcome = run(&scene);
    let found = outcome.displacement[0];
    // By elements of 0.25 in the whole fluid: (-0.09412, -0.00863), with the bar 7.4e-4.
    let finer = Vector3::new(-0.094_12, -0.008_63, 0.0);
    let bar = outcome.error_estimate.total();
    within((found - finer).norm(), bar + 7.4e-4, "the error bars");
    within(bar, 0.02 * found.norm(), "the bar says something");
}

/// Cells follow the true surface of a bent tube to the error bar, also where their edges are nearly
/// a radius long: values of each mesh are within the bars of the others. Bars of flat facets, a
/// tenth of a radius inside it, are of the first order in this depth: a fifth more is allowed.
#[test]
#[ignore = "slow: 20 s"]
fn the_bars_of_a_bent_tube_contain_its_facets() {
    let solve = |size: f64, geometry: &str| {
        let keys = format!("surface_size = {size:?}\ngeometry = \"{geometry}\"");
        let text = include_str!("../../templates/sperm.toml").replace("surface_size = 0.45", &keys);
        let scene = Scene::parse(&text).unwrap();
        solve_at(boxed(&scene).as_mut(), &[1.0, 0.7], &[0.0, 1.0])
    };
    let meshes = [
        solve(0.45, "straight"),
        solve(0.45, "curved"),
        solve(0.35, "curved"),
        solve(0.25, "curved"),
    ];
    let finest = &meshes[3];
    let speed = finest.bodies[0].velocity.norm();
    for (number, one) in meshes.iter().enumerate() {
        let (allowed, factor) = match number {
            0 => (0.05, 1.2),
            _ => (5e-3, 1.0),
        };
        let bar = factor * one.error_estimate.total();
        within(bar, allowed * speed, "the bar says something");
        for other in &meshes[number..] {
            let difference = one.bodies[0].velocity - other.bodies[0].velocity;
            let bars = bar + other.error_estimate.total();
            within(difference.norm(), bars, "both error bars");
            let difference = one.power() - other.power();
            let bars = factor * one.power_error.total() + other.power_error.total();
            within(difference, bars, "both error bars of power");
        }
    }
}

/// Bodies that deform have no steady state: refused with the place, before a mesh is made.
#[test]
fn steady_states_refuse_bodies_that_deform() {
    let text = "fluid.density = 1\n\
        bodies = [{ name = \"worm\", shape = \"tube\", length = 6, radius = 0.3, \
        position = [0, 0, 0], deformation = { kind = \"undulation\", amplitude = 0.5 } }]";
    let scene = Scene::parse(text).unwrap();
    let refused = swimmer::solve_steady(&scene, &mut ())
        .map(|_| ())
        .unwrap_err();
    assert_eq!(refused.exit_code(), 2);
    let refused = refused.to_string();
    assert!(
        refused.contains("bodies") && refused.contains("deforms"),
        "{refused}"
    );
}

/// The velocities of a turned worm are turned.
#[test]
fn undulations_are_the_same_in_all_frames() {
    let turn = Vector3::new(0.4, -0.9, 0.7);
    let body = format!("orientation = [{}, {}, {}]", turn.x, turn.y, turn.z);
    let [own, turned] =
        ["", &body[..]].map(|body| solution(&tube("curvature", 0.8, body, 0.24), 0.7, 1.0));
    let rotation = UnitQuaternion::from_scaled_axis(turn);
    let difference = turned.bodies[0].velocity - rotation * own.bodies[0].velocity;
    let bar = own.error_estimate.total() + turned.error_estimate.total();
    within(difference.norm(), bar, "the error bars");
    within(
        bar,
        0.02 * own.bodies[0].velocity.norm(),
        "the bar says something",
    );
}

/// A standing wave has one coordinate: it leads nowhere, by Purcell's theorem.
#[test]
#[ignore = "slow: 40 s"]
fn standing_waves_lead_nowhere() {
    let text = r#"
        fem.surface_size = 0.24
        model.tolerance = 0.1
        [[bodies]]
        name = "worm"
        shape = "tube"
        length = 6
        radius = 0.3
        end_radius = 0.2
        position = [0, 0, 0]
        deformation = { kind = "undulation", envelope = "linear", amplitude = 0.2 }
        [[gait.phases]]
        targets = { "worm.amplitude" = 1 }
        duration = 1
        [[gait.phases]]
        targets = { "worm.amplitude" = 0.2 }
        duration = 3
    "#;
    let outcome = run(&Scene::parse(text).unwrap());
    let there = outcome.spans[0].displacement[0].norm();
    let bar = outcome.error_estimate.total();
    within(outcome.displacement[0].norm(), bar, "the error bar");
    within(bar, 0.5 * there, "the bar says something");
}

/// Models of spheres, of points and in the meridian plane refuse tubes with place and remedy.
#[test]
fn other_models_refuse_tubes() {
    for kind in ["oseen", "rpy", "multipole", "axisymmetric"] {
        let text = tube("curvature", 0.5, "", 0.3).to_toml().unwrap();
        let scene = Scene::parse(&text.replace("kind = \"auto\"", &format!("kind = \"{kind}\"")));
        let scene = scene.unwrap();
        assert_eq!(format!("{:?}", scene.model().kind).to_lowercase(), kind);
        let refused = swimmer::choose(&scene).map(|_| ()).unwrap_err().to_string();
        assert!(
            refused.contains("tube") || refused.contains("bodies"),
            "{refused}"
        );
        assert!(refused.contains("model.kind"), "{refused}");
    }
}
