//! The axisymmetric model, against exact instantaneous solutions and strokes.

use nalgebra::{Rotation3, Vector3};
use swimmer::choose;
use swimmer::{Method, Scene, simulate, solve_start};

/// The three-sphere swimmer of Najafi & Golestanian (2004) along `axis`: arms close from 10 to 6
/// and open again.
fn three_spheres(domain: &str, model: &str, tolerance: f64, axis: Vector3<f64>) -> Scene {
    let phases: String = [("left", 6), ("right", 6), ("left", 10), ("right", 10)]
        .map(|(joint, length)| format!("[[gait.phases]]\nlink = \"{joint}\"\nlength = {length}\n"))
        .concat();
    let bodies: String = [("l", -10.0), ("c", 0.0), ("r", 10.0)]
        .map(|(name, at)| {
            let x = at * axis;
            format!(
                "[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{:?}, {:?}, {:?}]\n",
                x.x, x.y, x.z
            )
        })
        .concat();
    Scene::parse(&format!(
        "domain = {domain}\n\
         links = [{{ name = \"left\", body = \"l\", to = \"c\" }}, \
         {{ name = \"right\", body = \"r\", to = \"c\" }}]\n\
         model = {{ kind = \"{model}\", tolerance = {tolerance:e} }}\n{bodies}{phases}"
    ))
    .expect("a scene")
}

const BALL: &str = "{ kind = \"ball\", radius = 40 }";

/// Spectral, ball of radius 40: velocity of the centre sphere and forces while the left arm closes
/// at unit rate.
#[test]
fn an_instant_in_a_ball_is_exact_within_its_error_bar() {
    // Not along a coordinate axis.
    let axis = Rotation3::from_euler_angles(0.3, 0.4, 0.5) * Vector3::x();
    for tolerance in [1e-2, 1e-4] {
        let scene = three_spheres(BALL, "axisymmetric", tolerance, axis);
        let mut choice = choose(&scene).expect("collinear in a ball");
        assert_eq!(choice.model.name(), "axisymmetric");
        let instant = solve_start(&scene, choice.model.as_mut()).expect("a solution");
        // The arm closes by 4 per unit of time.
        let off = (instant.bodies[1].velocity / 4.0 - axis * -0.3428979021151601).norm();
        let bar = instant.error_estimate.mesh.expect("always estimated") / 4.0;
        assert!(off < tolerance * 0.34 && off < bar, "{off:e} {bar:e}");
        let exact = [14.122932964125914, -7.611261032148927, -6.5116719319769825];
        let error = instant.mesh_error.as_ref().expect("always estimated");
        let bar = error.force_error_bar() / 4.0;
        for (body, force) in instant.bodies.iter().zip(exact) {
            let off = (body.force / 4.0 - axis * force).norm();
            assert!(off < 2.0 * bar, "{off:e} {bar:e}");
            assert!(body.angular_velocity.norm() < 1e-12);
        }
        // What was subtracted has the sign of the error before; the forces add up to zero, so the
        // power is the force of the left sphere times the rate of its arm.
        let before = instant.uncorrected();
        let signed = [
            (before.bodies[1].velocity - axis * 4.0 * -0.3428979021151601)
                .dot(&error.bodies[1].velocity),
            (before.bodies[0].force - axis * 4.0 * exact[0]).dot(&error.bodies[0].force),
            (before.power() - 16.0 * exact[0]) * (before.power() - instant.power()),
        ];
        assert!(signed.iter().all(|product| *product > 0.0), "{signed:?}");
        // All bodies of a linkage have the velocity of its frame, and the rates of the arms.
        let frame = error.motion.frames[0].linear;
        for of_body in &error.bodies {
            let off = (of_body.velocity - frame).norm();
            assert!(off < 1e-12, "{} {frame}", of_body.velocity);
        }
        assert!((instant.joint_forces[0] / 4.0 - axis * exact[0]).norm() < 2.0 * bar);
        assert!(instant.error_estimate.container.is_none());
    }
}

fn check_stroke(domain: &str, tolerance: f64, net: f64) {
    let scene = three_spheres(domain, "axisymmetric", tolerance, Vector3::x());
    let mut model = choose(&scene).expect("collinear").model;
    let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).expect("a stroke");
    let off = (outcome.displacement[1] - Vector3::x() * net).norm();
    let bar = outcome.error_estimate.total();
    assert!(off < tolerance * net && off < bar, "{off:e} {bar:e}");
    assert!(outcome.tolerance_met);
    assert!(outcome.displacement[1].yz().norm() < 1e-12);
}

/// Spectral, the swimmer starting at the centre.
#[test]
fn a_stroke_in_a_ball_has_the_exact_net_displacement() {
    check_stroke(BALL, 1e-2, 0.1604180159643671);
}

/// Spectral.
#[test]
#[ignore = "slow: 1 min, strokes to four and five digits"]
fn strokes_have_the_exact_net_displacement() {
    check_stroke("{ kind = \"unbounded\" }", 1e-4, 0.1598053403881754);
    check_stroke(BALL, 1e-5, 0.1604180159643671);
}

/// Haberman & Sayre (1958), by a collocation of their series to 1e-9: a cylinder with five times
/// the radius of the sphere.
#[test]
fn auto_chooses_the_axisymmetric_model_in_a_cylinder_and_gives_reasons() {
    let scene = Scene::parse(
        "domain = { kind = \"cylinder\", radius = 2.5 }\nfluid.viscosity = 2\n\
         bodies = [{ name = \"s\", radius = 0.5, position = [7, 0, 0], force = [3, 0, 0] }]",
    )
    .expect("a scene");
    let mut choice = choose(&scene).expect("a sphere on the axis");
    assert_eq!(choice.model.name(), "axisymmetric");
    let reasons = choice.reasons.join("; ");
    for fragment in [
        "axis of the domain",
        "cylinder",
        "resistance",
        "chosen: finite elements in the meridian plane",
    ] {
        assert!(reasons.contains(fragment), "{reasons}");
    }
    let instant = solve_start(&scene, choice.model.as_mut()).expect("a solution");
    let exact = 3.0 / (6.0 * std::f64::consts::PI * 2.0 * 0.5 * 1.679478884847892);
    let off = (instant.bodies[0].velocity.x - exact).abs();
    assert!(
        off < 5e-5 * exact && off < instant.error_estimate.total(),
        "{off:e}"
    );
}

/// Happel & Brenner (1983): torque factor `1 / (1 - 2^-3)` in a ball of twice the radius.
#[test]
fn a_torque_about_the_axis_gives_the_exact_angular_velocity() {
    let scene = Scene::parse(
        "model.kind = \"axisymmetric\"\ndomain = { kind = \"ball\", radius = 2 }\n\
         bodies = [{ name = \"s\", radius = 1, position = [0, 0, 0], torque = [0, 0, 5], force = [0, 0, 1] }]",
    )
    .expect("a scene");
    let mut model = choose(&scene).expect("symmetric").model;
    let instant = solve_start(&scene, model.as_mut()).expect("a solution");
    let exact = Vector3::z() * 5.0 * 0.875 / (8.0 * std::f64::consts::PI);
    let off = (instant.bodies[0].angular_velocity - exact).norm();
    assert!(off < 5e-5 * exact.norm(), "{off:e}");
    assert!((instant.bodies[0].torque.z - 5.0).abs() < 1e-10);
    assert!(instant.bodies[0].velocity.z > 0.0);
    // The angular velocity has an estimated error, and dofs of its own.
    let error = instant
        .mesh_error
        .as_ref()
        .expect("always estimated")
        .motion
        .frames[0]
        .angular;
    assert!(off <= 4.0 * error.norm() + 1e-13, "{off:e} {error}");
    let pulled = scene.to_toml().expect("TOML").replace("5.0", "0.0");
    let pulled = Scene::parse(&pulled).expect("a scene");
    let mut model = choose(&pulled).expect("symmetric").model;
    let without = solve_start(&pulled, model.as_mut()).expect("a solution");
    assert!(without.dofs.total < instant.dofs.total);
}

/// Kim & Karrila (1991), table 3.4: drag `6 pi a X_A` along the long semi-axis, aspect 2.
#[test]
fn a_spheroid_along_any_axis_has_the_exact_velocity() {
    for (axis, force) in [([2.0, 1.0, 2.0], 3.0), ([0.0, 1.0, 0.0], -1.0)] {
        let direction = Vector3::from(axis).normalize();
        let load = direction * force;
        let scene = Scene::parse(&format!(
            "domain.kind = \"unbounded\"\n\
             bodies = [{{ name = \"s\", shape = \"spheroid\", radius = 0.5, half_length = 1, axis = {axis:?}, position = [1, 2, 3], force = {:?} }}]",
            load.as_slice()
        ))
        .expect("a scene");
        let mut choice = choose(&scene).expect("a lone spheroid");
        assert!(
            choice.reasons[1].contains("spheroid"),
            "{:?}",
            choice.reasons
        );
        let instant = solve_start(&scene, choice.model.as_mut()).expect("a solution");
        let exact = load / (6.0 * std::f64::consts::PI * 0.6019704948941008);
        let off = (instant.bodies[0].velocity - exact).norm();
        assert!(
            off < 5e-5 * exact.norm() && off < instant.error_estimate.total(),
            "{off:e}"
        );
        assert_eq!(
            Scene::parse(&scene.to_toml().expect("TOML"))
                .expect("a scene")
                .bodies(),
            scene.bodies()
        );
    }
}

/// Only finite elements in space take shapes without a common axis; the others name them.
#[test]
fn shapes_off_the_axis_are_left_to_elements_in_space() {
    let scene = |kind: &str, shape: &str| {
        Scene::parse(&format!(
            "model.kind = \"{kind}\"\ndomain = {BALL}\n\
             bodies = [{{ name = \"a\", {shape}, position = [0, 0, 0] }}, \
             {{ name = \"b\", radius = 1, position = [4, 0, 0] }}]"
        ))
        .expect("a scene")
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
    let scene = |axis: &str| {
        Scene::parse(&format!(
            "domain = {{ kind = \"cylinder\", radius = 2 }}\n\
             bodies = [{{ name = \"s\", shape = \"spheroid\", radius = 1, half_length = 2.5, axis = {axis}, position = [0, 0, 0], force = [1, 0, 0] }}]"
        ))
    };
    let along = scene("[1, 0, 0]").expect("it fits");
    let mut model = choose(&along).expect("on the axis").model;
    assert!(
        solve_start(&along, model.as_mut())
            .expect("a solution")
            .bodies[0]
            .velocity
            .x
            > 0.0
    );
    assert!(scene("[0, 0, 1]").is_err());
}

#[test]
fn scenes_without_axial_symmetry_are_refused_with_the_reason() {
    let scene = |domain: &str, body: &str| {
        Scene::parse(&format!(
            "model.kind = \"axisymmetric\"\ndomain = {domain}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0], {body} }}, {{ name = \"b\", radius = 1, position = [4, 0, 0] }}]"
        ))
        .expect("a scene")
    };
    for (domain, body, reason) in [
        (
            "{ kind = \"box\", size = [20, 20, 20] }",
            "force = [1, 0, 0]",
            "domain.kind = \"box\"",
        ),
        (
            BALL,
            "force = [0, 1, 0]",
            "about which shapes, loads or the domain are not symmetric",
        ),
        (
            BALL,
            "torque = [0, 1, 0]",
            "about which shapes, loads or the domain are not symmetric",
        ),
    ] {
        let scene = scene(domain, body);
        let error = choose(&scene).err().expect(reason);
        assert!(
            error.is_bad_input() && error.to_string().contains(reason),
            "{error}"
        );
    }
    let scene = scene(BALL, "force = [1, 0, 0]");
    let mut model = choose(&scene).expect("symmetric").model;
    let error = swimmer::start_resistance(&scene, model.as_mut()).expect_err("axial only");
    assert!(
        error
            .to_string()
            .contains("restricted to motions along the axis"),
        "{error}"
    );
}

/// A motor about the axis: angular velocities are those of multipoles, and hinges are left to them
/// with the joint's name.
#[test]
fn a_rotor_about_the_axis_turns_bodies_as_multipoles_do() {
    let scene = |model: &str, joint: &str| {
        let text = format!(
            "model = {{ kind = \"{model}\", tolerance = 1e-6 }}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0] }}, \
             {{ name = \"b\", radius = 1.5, position = [2.8, 0, 0] }}]\n\
             links = [{{ name = \"motor\", body = \"b\", to = \"a\", {joint} }}]\n\
             gait.phases = [{{ link = \"motor\", length = 2 }}]\n"
        );
        Scene::parse(&text).expect("a scene")
    };
    let rotor = "joint = \"rotor\"";
    let [meridian, spheres] = ["axisymmetric", "multipole"].map(|model| {
        let scene = scene(model, rotor);
        solve_start(&scene, choose(&scene).unwrap().model.as_mut()).unwrap()
    });
    for (body, other) in meridian.bodies.iter().zip(&spheres.bodies) {
        assert!(other.angular_velocity.x.abs() > 0.1);
        assert!((body.angular_velocity - other.angular_velocity).norm() < 1e-6);
        assert!((body.torque - other.torque).norm() < 1e-5);
        assert!(body.velocity.norm() < 1e-9);
    }
    // The relative rate is that of the gait.
    let [a, b] = [0, 1].map(|body| meridian.bodies[body].angular_velocity.x);
    assert!((b - a - 2.0).abs() < 1e-9);
    let hinge = scene("axisymmetric", "joint = \"hinge\", axis = [0, 0, 1]");
    let error = choose(&hinge).err().unwrap().to_string();
    assert!(error.contains("the joint 'motor' can turn them"), "{error}");
    let reasons = choose(&scene("auto", "joint = \"hinge\", axis = [0, 0, 1]"));
    assert!(reasons.unwrap().reasons[0].contains("the joint 'motor' can turn them"));
}
