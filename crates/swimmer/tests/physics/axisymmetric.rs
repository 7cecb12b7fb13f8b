//! The axisymmetric model, against exact instantaneous solutions and strokes.

use nalgebra::{Rotation3, Vector3};
use swimmer::{Scene, choose};
use testkit::exact::{
    CYLINDER_5, Exact, INSTANT_IN_BALL_40, SPHEROID_2, STROKE, STROKE_IN_BALL_40,
};
use testkit::{SceneText, run, start, start_by, three_spheres, within};

const EIGHT_PI: f64 = 8.0 * std::f64::consts::PI;
const SIX_PI: f64 = 6.0 * std::f64::consts::PI;

/// Spectral, ball of radius 40: velocity of the centre sphere and forces while the left arm closes
/// at unit rate.
#[test]
fn an_instant_in_a_ball_is_exact_within_its_error_bar() {
    // Not along a coordinate axis.
    let axis = Rotation3::from_euler_angles(0.3, 0.4, 0.5) * Vector3::x();
    for tolerance in [1e-2, 1e-4] {
        let text = three_spheres().ball(40.0).model("axisymmetric", tolerance);
        let text = [("left", -10.0), ("right", 10.0)]
            .iter()
            .fold(text, |text, (name, x)| {
                let key = format!("bodies.{name}.position");
                text.with(&key, format!("{:?}", (axis * *x).as_slice()))
            });
        let mut choice = choose(&text.scene()).expect("collinear in a ball");
        assert_eq!(choice.model.name(), "axisymmetric");
        let instant = start_by(choice.model.as_mut());
        // The arm closes by 4 per unit of time.
        let speed = INSTANT_IN_BALL_40.velocity;
        let off = (instant.bodies[1].velocity / 4.0 - axis * speed).norm();
        let bar = instant.error_estimate.mesh.expect("always estimated") / 4.0;
        within(off, tolerance * 0.34, "the tolerance");
        within(off, bar, "the error bar");
        let exact = INSTANT_IN_BALL_40.forces;
        let error = instant.mesh_error.as_ref().expect("always estimated");
        let bar = error.force_error_bar() / 4.0;
        for (body, force) in instant.bodies.iter().zip(exact) {
            let off = (body.force / 4.0 - axis * force).norm();
            within(off, 2.0 * bar, "bars of forces are within a factor of two");
            within(body.angular_velocity.norm(), 1e-12, "rounding");
        }
        // What was subtracted has the sign of the error before, which the velocity may show by a
        // part of its bar alone; the forces add up to zero, so the power is the force of the left
        // sphere times the rate of its arm.
        let before = instant.uncorrected();
        let off = before.bodies[1].velocity - axis * 4.0 * speed;
        let of_velocity = instant.error_estimate.mesh.expect("always estimated");
        assert!(off.norm() <= of_velocity || off.dot(&error.bodies[1].velocity) > 0.0);
        let signed = [
            (before.bodies[0].force - axis * 4.0 * exact[0]).dot(&error.bodies[0].force),
            (before.power() - 16.0 * exact[0]) * (before.power() - instant.power()),
        ];
        assert!(signed.iter().all(|product| *product > 0.0), "{signed:?}");
        // All bodies of a linkage have the velocity of its frame, and the rates of the arms.
        let frame = error.motion.frames[0].linear;
        for of_body in &error.bodies {
            within((of_body.velocity - frame).norm(), 1e-12, "rounding");
        }
        let off = (instant.joint_loads[0].force / 4.0 - axis * exact[0]).norm();
        within(off, 2.0 * bar, "bars of forces are within a factor of two");
        assert!(instant.error_estimate.container.is_none());
    }
}

fn check_stroke(text: SceneText, tolerance: f64, net: Exact) {
    let outcome = run(&text.model("axisymmetric", tolerance).scene());
    let off = (outcome.displacement[1] - Vector3::x() * net.value).norm();
    within(off, tolerance * net.value, "the tolerance");
    within(off, outcome.error_estimate.total(), "the error bar");
    assert!(outcome.tolerance_met);
    within(outcome.displacement[1].yz().norm(), 1e-12, "rounding");
}

#[test]
fn a_stroke_in_a_ball_has_the_exact_net_displacement() {
    check_stroke(three_spheres().ball(40.0), 1e-2, STROKE_IN_BALL_40);
}

#[test]
#[ignore = "slow: 1 min, strokes to four and five digits"]
fn strokes_have_the_exact_net_displacement() {
    check_stroke(three_spheres(), 1e-4, STROKE);
    check_stroke(three_spheres().ball(40.0), 1e-5, STROKE_IN_BALL_40);
}

/// Haberman & Sayre (1958), by a collocation of their series to 1e-9: a cylinder with five times
/// the radius of the sphere.
#[test]
fn auto_chooses_the_axisymmetric_model_in_a_cylinder_and_gives_reasons() {
    let text = SceneText::new().shape("s", "radius = 0.5, force = [3, 0, 0]", [7, 0, 0]);
    let text = text.set(&[
        "domain.kind=cylinder",
        "domain.radius=2.5",
        "fluid.viscosity=2",
    ]);
    let mut choice = choose(&text.scene()).expect("a sphere on the axis");
    assert_eq!(choice.model.name(), "axisymmetric");
    let chosen = "chosen: finite elements in the meridian plane";
    let fragments = ["axis of the domain", "cylinder", "resistance", chosen];
    testkit::contains("reasons", &choice.reasons.join("; "), &fragments);
    let instant = start_by(choice.model.as_mut());
    let exact = 3.0 / (SIX_PI * 2.0 * 0.5 * CYLINDER_5.value);
    let off = instant.bodies[0].velocity.x - exact;
    within(off, 5e-5 * exact, "a twentieth of the tolerance");
    within(off, instant.error_estimate.total(), "the error bar");
}

/// Happel & Brenner (1983): torque factor `1 / (1 - 2^-3)` in a ball of twice the radius.
#[test]
fn a_torque_about_the_axis_gives_the_exact_angular_velocity() {
    let keys = "radius = 1, torque = [0, 0, 5], force = [0, 0, 1]";
    let text = SceneText::new().shape("s", keys, [0; 3]).ball(2.0);
    let text = text.with("model.kind", "axisymmetric");
    let instant = start(&text.scene());
    let exact = Vector3::z() * 5.0 * 0.875 / EIGHT_PI;
    let off = (instant.bodies[0].angular_velocity - exact).norm();
    within(off, 5e-5 * exact.norm(), "a twentieth of the tolerance");
    within(instant.bodies[0].torque.z - 5.0, 1e-10, "rounding");
    assert!(instant.bodies[0].velocity.z > 0.0);
    // The angular velocity has an estimated error, and dofs of its own.
    let error = instant.mesh_error.as_ref().expect("always estimated");
    let bar = 4.0 * error.motion.frames[0].angular.norm();
    within(off, bar + 1e-13, "the order of the estimated error");
    let without = start(&text.with("bodies.s.torque", "[0, 0, 0]").scene());
    assert!(without.dofs.total < instant.dofs.total);
}

/// Kim & Karrila (1991), table 3.4: drag `6 pi a X_A` along the long semi-axis, aspect 2.
#[test]
fn a_spheroid_along_any_axis_has_the_exact_velocity() {
    for (axis, force) in [([2.0, 1.0, 2.0], 3.0), ([0.0, 1.0, 0.0], -1.0)] {
        let direction = Vector3::from(axis).normalize();
        let load = direction * force;
        let (load_keys, shape) = (
            load.as_slice(),
            "shape = \"spheroid\", radius = 0.5, half_length = 1",
        );
        let keys = format!("{shape}, axis = {axis:?}, force = {load_keys:?}");
        let scene = SceneText::new().shape("s", &keys, [1, 2, 3]).scene();
        let mut choice = choose(&scene).expect("a lone spheroid");
        testkit::contains("reason", &choice.reasons[1], &["spheroid"]);
        let instant = start_by(choice.model.as_mut());
        let exact = load / (SIX_PI * SPHEROID_2.value);
        let off = (instant.bodies[0].velocity - exact).norm();
        within(off, 5e-5 * exact.norm(), "a twentieth of the tolerance");
        within(off, instant.error_estimate.total(), "the error bar");
        let again = SceneText::file(&scene.to_toml().expect("TOML")).scene();
        assert_eq!(again.bodies(), scene.bodies());
    }
}

/// Only finite elements in space take shapes without a common axis; the others name them.
#[test]
fn shapes_off_the_axis_are_left_to_elements_in_space() {
    let scene = |kind: &str, shape: &str| {
        let text = SceneText::new()
            .shape("a", shape, [0; 3])
            .sphere("b", 1.0, [4, 0, 0]);
        text.ball(40.0).with("model.kind", kind).scene()
    };
    let spheroid = "shape = \"spheroid\", radius = 1, half_length = 2, axis = [0, 1, 0]";
    let capsule = "shape = \"capsule\", radius = 1, half_length = 2";
    for shape in [spheroid, capsule] {
        for kind in ["multipole", "axisymmetric"] {
            let error = choose(&scene(kind, shape)).err().expect(kind);
            assert!(error.is_bad_input(), "{error}");
            assert!(
                error.to_string().contains("fem") || shape == spheroid,
                "{error}"
            );
        }
        for kind in ["auto", "fem"] {
            assert_eq!(choose(&scene(kind, shape)).expect(kind).model.name(), "fem");
        }
    }
}

/// A body longer than the width of a cylinder fits along the cylinder but not across it.
#[test]
fn clearance_depends_on_the_shape() {
    let text = |axis: &str| {
        let keys = "shape = \"spheroid\", radius = 1, half_length = 2.5, force = [1, 0, 0]";
        let text = SceneText::new()
            .shape("s", keys, [0; 3])
            .with("bodies.s.axis", axis);
        text.set(&["domain.kind=cylinder", "domain.radius=2"])
    };
    assert!(start(&text("[1, 0, 0]").scene()).bodies[0].velocity.x > 0.0);
    assert!(text("[0, 0, 1]").try_scene().is_err());
}

#[test]
fn scenes_without_axial_symmetry_are_refused_with_the_reason() {
    let text = testkit::chain(&["a", "b"], &[0.0, 4.0]).with("model.kind", "axisymmetric");
    let asymmetric = "about which shapes, loads or the domain are not symmetric";
    let in_box = text
        .clone()
        .with("domain", "{ kind = \"box\", size = [20, 20, 20] }");
    let in_ball = text.ball(40.0);
    for (text, setting, reason) in [
        (&in_box, "bodies.a.force=[1, 0, 0]", "domain.kind = \"box\""),
        (&in_ball, "bodies.a.force=[0, 1, 0]", asymmetric),
        (&in_ball, "bodies.a.torque=[0, 1, 0]", asymmetric),
    ] {
        let error = choose(&text.clone().set(&[setting]).scene())
            .err()
            .expect(reason);
        assert!(error.is_bad_input());
        testkit::contains(setting, &error.to_string(), &[reason]);
    }
    let scene = in_ball.with("bodies.a.force", "[1, 0, 0]").scene();
    let mut model = choose(&scene).expect("symmetric").model;
    let error = swimmer::start_resistance(&scene, model.as_mut()).expect_err("axial only");
    testkit::contains(
        "force",
        &error.to_string(),
        &["restricted to motions along the axis"],
    );
}

/// A motor about the axis: angular velocities are those of multipoles, and hinges are left to them
/// with the joint's name.
#[test]
fn a_rotor_about_the_axis_turns_bodies_as_multipoles_do() {
    let text = |model: &str, joint: &str| {
        let text = SceneText::new()
            .sphere("a", 1.0, [0; 3])
            .sphere("b", 1.5, [2.8, 0.0, 0.0]);
        let text = text
            .joint("motor", "b", "a", joint)
            .phases(&[("motor", 2.0)]);
        text.model(model, 1e-6)
    };
    let [meridian, spheres] =
        ["axisymmetric", "multipole"].map(|model| start(&text(model, "joint = \"rotor\"").scene()));
    for (body, other) in meridian.bodies.iter().zip(&spheres.bodies) {
        assert!(other.angular_velocity.x.abs() > 0.1);
        let turned = (body.angular_velocity - other.angular_velocity).norm();
        within(turned, 1e-6, "the tolerance");
        within(
            (body.torque - other.torque).norm(),
            1e-5,
            "the tolerance, of torques of about ten",
        );
        within(body.velocity.norm(), 1e-9, "rounding");
    }
    // The relative rate is that of the gait.
    let [a, b] = [0, 1].map(|body| meridian.bodies[body].angular_velocity.x);
    within(b - a - 2.0, 1e-9, "rounding");
    let hinge = "joint = \"hinge\", axis = [0, 0, 1]";
    let reason = "the joint 'motor' can turn them";
    let error = choose(&text("axisymmetric", hinge).scene()).err().unwrap();
    testkit::contains("axisymmetric", &error.to_string(), &[reason]);
    let choice = choose(&text("auto", hinge).scene()).unwrap();
    testkit::contains("auto", &choice.reasons[0], &[reason]);
}

/// In a narrow tube the net displacement is a fourth of what the rough model predicts, on which
/// the tolerances of single solutions are based: the run is repeated with a smaller one.
#[test]
fn bug_a_swimmer_in_a_narrow_tube_missed_every_tolerance() {
    let text = r#"
        domain = { kind = "cylinder", radius = 4 }
        bodies = [
            { name = "left", radius = 1, position = [-10, 0, 0] },
            { name = "centre", radius = 1, position = [0, 0, 0] },
            { name = "right", radius = 1, position = [10, 0, 0] },
        ]
        links = [
            { name = "rear", body = "left", to = "centre" },
            { name = "front", body = "right", to = "centre" },
        ]
        gait.phases = [
            { link = "rear", length = 6 },
            { link = "front", length = 6 },
            { link = "rear", length = 10 },
            { link = "front", length = 10 },
        ]
    "#;
    let report = swimmer::run_without_files(Scene::parse(text).unwrap(), &mut ()).unwrap();
    assert!(report.outcome.tolerance_met);
    assert!(report.scene.model().tolerance_factor.unwrap() < 1.0);
    let bar = report.outcome.error_estimate.total();
    assert!(bar <= 1e-3 * report.outcome.net());
}

#[test]
fn bug_squirmers_in_narrow_gaps_had_errors_of_percents_by_multipoles() {
    for gap in [0.02, 0.005, 0.001] {
        let velocities = |model: &str| {
            let text = format!(
                "model = {{ kind = \"{model}\", tolerance = 1e-5 }}
                bodies = [
                    {{ name = \"a\", radius = 1, position = [0, 0, 0],
                       slip = {{ b1 = 1, b2 = 2, axis = [1, 0, 0] }} }},
                    {{ name = \"b\", radius = 1, position = [{}, 0, 0],
                       slip = {{ b1 = 1, b2 = -1, axis = [1, 0, 0] }} }},
                ]",
                2.0 + gap
            );
            let scene = Scene::parse(&text).unwrap();
            let mut model = choose(&scene).unwrap().model;
            let solution = swimmer::solve_start(&scene, model.as_mut()).unwrap();
            let bar = solution.error_estimate.total();
            assert!(bar < 1e-5, "{gap}: {bar:e}");
            (
                solution
                    .bodies
                    .iter()
                    .map(|body| body.velocity.x)
                    .collect::<Vec<_>>(),
                bar,
            )
        };
        let [(multipole, bar), (plane, bar_of_plane)] =
            ["multipole", "axisymmetric"].map(velocities);
        for (a, b) in multipole.iter().zip(&plane) {
            within(
                a - b,
                bar + bar_of_plane,
                format!("both error bars: gap {gap}"),
            );
        }
    }
}
