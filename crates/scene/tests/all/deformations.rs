//! Bodies that deform: their shape coordinates, and what is refused.

use std::f64::consts::PI;

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use scene::{Deformation, Harmonic, ModeMotion, Scene, SphereDeformation, spans};

/// Two spheres on an arm, with settings before the bodies and a gait after them.
fn pair(before: &str, gait: &str) -> String {
    format!(
        r#"
        {before}
        bodies = [
            {{ name = "left", radius = 1, position = [-2, 0, 0] }},
            {{ name = "right", radius = 1.5, position = [2, 0, 0] }},
        ]
        {gait}
        "#
    )
}

const ARM: &str = r#"links = [{ name = "arm", body = "right", to = "left" }]"#;

fn parse(before: &str, gait: &str) -> Result<Scene, String> {
    Scene::parse(&pair(before, gait)).map_err(|error| error.to_string())
}

#[track_caller]
fn refused(before: &str, gait: &str, part: &str) {
    let error = parse(before, gait).unwrap_err();
    assert!(error.contains(part), "{error}");
    assert!(error.contains("scene.toml:"), "no place: {error}");
}

#[test]
fn radius_and_volume_are_shape_coordinates_beside_the_joints() {
    let gait = r#"
        [[gait.phases]]
        targets = { "left.radius" = 1.2, arm = 5, "right.volume" = 10.0 }
    "#;
    let scene = parse(ARM, gait).unwrap();
    let names: Vec<_> = (scene.articulation().joints().iter())
        .map(|joint| &joint.name[..])
        .collect();
    assert_eq!(names, ["arm", "left.radius", "right.volume"]);
    let volume = 4.0 / 3.0 * PI * 1.5_f64.powi(3);
    assert_eq!(scene.articulation().initial_shape()[..2], [4.0, 1.0]);
    assert!((scene.articulation().initial_shape()[2] - volume).abs() < 1e-14);
    let span = spans(scene.gait(), scene.articulation().initial_shape())
        .unwrap()
        .next()
        .unwrap();
    assert_eq!(span.to, [5.0, 1.2, 10.0]);
    // What is written reads back, also without the gait that names the coordinates.
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.gait(), scene.gait());
    assert_eq!(again.differing_key(&scene), None);
    assert_eq!(again.bodies(), scene.bodies());
}

#[test]
fn coordinates_that_nothing_names_are_absent() {
    let scene = parse(ARM, "gait.phases = [{ link = \"arm\", length = 6 }]").unwrap();
    assert_eq!(scene.articulation().joints().len(), 1);
    assert!(!scene.deforms());
}

#[test]
fn an_exchange_keeps_the_sum_of_the_volumes() {
    let links = r#"links = [
        { name = "arm", body = "right", to = "left" },
        { name = "flow", body = "left", to = "right", joint = "exchange" },
    ]
    domain = { kind = "ball", radius = 9 }"#;
    let scene = parse(links, "gait.phases = [{ targets = { flow = 9, arm = 6 } }]").unwrap();
    let start = scene.articulation().initial_shape();
    let total: f64 = scene.bodies().iter().map(|body| body.shape.volume()).sum();
    let volume = |values: &[f64]| -> f64 {
        let deformations = scene.bodies().iter().filter_map(|b| b.deformation.as_ref());
        let spheres = deformations.filter_map(Deformation::sphere);
        spheres.map(|of| of.volume(values)).sum()
    };
    for values in [start, &[6.0, 9.0]] {
        assert!((volume(values) / total - 1.0).abs() < 1e-14);
    }
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.differing_key(&scene), None);
}

#[test]
fn nonsense_is_refused_with_its_place() {
    let phase = |target: &str| format!("[[gait.phases]]\ntargets = {{ {target} }}");
    refused(ARM, &phase(r#""left.radus" = 2"#), "left.radius");
    refused(
        ARM,
        &phase(r#""left.radius" = 2, "left.volume" = 9"#),
        "use one of them",
    );
    refused(ARM, &phase(r#""left.radius" = -1"#), "greater than zero");
    refused(ARM, &phase(r#""left.volume" = 0"#), "greater than zero");
    // The spheres touch where 4 = r + 1.5.
    refused(ARM, &phase(r#""left.radius" = 2.6"#), "'left' and 'right'");
    let ball = format!("{ARM}\ndomain = {{ kind = \"ball\", radius = 9 }}");
    refused(&ball, &phase(r#""left.radius" = 1.1"#), "in phase 1 at 0 %");
    // The sum of the volumes stays, but not of the radii on the way.
    let radii = r#""left.radius" = 1.5, "right.radius" = 1.0"#;
    refused(&ball, &phase(radii), "grows at the rate");
    let density = "fluid.density = 1\ngravity = [0, 0, -1]";
    let heavy = Scene::parse(&format!(
        "{density}\nbodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0], density = 2 }}]\n\
         {}",
        phase(r#""a.radius" = 2"#)
    ));
    assert!(heavy.unwrap_err().to_string().contains("density"));
}

fn sphere_with(deformation: &str, gait: &str) -> Result<Scene, String> {
    let text = format!(
        "{gait}\n[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n\
         deformation = {deformation}\n"
    );
    Scene::parse(&text).map_err(|error| error.to_string())
}

#[test]
fn modes_are_read_and_those_that_fold_are_refused() {
    let scene = sphere_with(
        "{ modes = { p2 = 2, p3 = 3 }, motion = \"isochoric\", axis = [0, 0, 2] }",
        "gait.phases = [{ targets = { \"a.p2\" = 0.1, \"a.p3\" = -0.2 } }]",
    )
    .unwrap();
    let modes = scene.bodies()[0]
        .deformation
        .as_ref()
        .and_then(Deformation::sphere)
        .unwrap()
        .modes
        .as_ref()
        .unwrap();
    assert_eq!(
        (modes.motion, modes.axis),
        (ModeMotion::Isochoric, Vector3::z())
    );
    let harmonic = |degree| Harmonic { degree, order: 0 };
    assert_eq!(modes.coordinates, [(harmonic(2), 0), (harmonic(3), 1)]);
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.differing_key(&scene), None);
    for (deformation, amplitude, part) in [
        ("{ modes = { p = 2.5 } }", 0.1, "whole degree"),
        ("{ modes = { p = 40 } }", 0.1, "whole degree"),
        ("{ modes = {} }", 0.1, "is empty"),
        ("{ modes = { radius = 2 } }", 0.1, "every sphere has"),
        (
            "{ modes = { p = 2 }, axis = [0, 0, 0] }",
            0.1,
            "no direction",
        ),
        (
            "{ kind = \"radius\", motion = \"radial\" }",
            0.1,
            "does not belong",
        ),
        // r = 1 + 2.1 P_2 at the equator is -0.05; the angle turns back where 1 < 2 * 0.6.
        ("{ modes = { p = 2 } }", 2.1, "reach its centre"),
        (
            "{ modes = { p = 2 }, motion = \"tangential\" }",
            0.6,
            "fold",
        ),
    ] {
        let gait = format!("gait.phases = [{{ targets = {{ \"a.p\" = {amplitude} }} }}]");
        let error = sphere_with(deformation, &gait).unwrap_err();
        assert!(error.contains(part), "{deformation}: {error}");
    }
}

/// A sphere with two modes about a tilted axis, with orders or none.
fn deformation(motion: &str, orders: [i32; 2]) -> SphereDeformation {
    let orders = match motion {
        "tangential" => String::new(),
        _ => format!(
            "orders = {{ p = {}, q = {} }}, meridian = [0, 1, 0], ",
            orders[0], orders[1]
        ),
    };
    let scene = sphere_with(
        &format!(
            "{{ modes = {{ p = 2, q = 3 }}, {orders}motion = \"{motion}\", axis = [1, 2, -2] }}"
        ),
        "gait.phases = [{ targets = { \"a.p\" = 0.1, \"a.volume\" = 5 } }]",
    );
    let scene = scene.unwrap();
    let deformation = scene.bodies()[0].deformation.as_ref();
    deformation.and_then(Deformation::sphere).unwrap().clone()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 96, ..ProptestConfig::default() })]

    /// Velocities and rates of the volume are derivatives, by central differences whose error is
    /// their step squared; material directions are inverse to points. The same for spheroids.
    #[test]
    fn velocities_are_derivatives_of_material_points(
        motion in prop_oneof![
            Just("radial"), Just("isochoric"), Just("tangential"), Just("gradient"), Just("curl"),
        ],
        orders in (-2..=2_i32, -3..=3_i32),
        n in prop::array::uniform3(-1.0..1.0_f64).prop_filter("a direction", |n| {
            Vector3::from(*n).norm() > 0.1
        }),
        amplitudes in prop::array::uniform2(-0.1..0.1_f64),
        volume in 2.0..9.0_f64,
        aspect in prop_oneof![Just(1.0), 0.3..3.0_f64],
    ) {
        let n = Vector3::from(n).normalize();
        let mut deformation = deformation(motion, orders.into());
        deformation.elongation = aspect - 1.0;
        // The volume is the first coordinate of the body.
        let values = [volume, amplitudes[0], amplitudes[1]];
        prop_assert!(deformation.problem(&values).is_none());
        let point = deformation.point(&n, &values);
        prop_assert!(point.norm() < deformation.bounding_radius(&values) * (1.0 + 1e-14));
        let direction = deformation.material_direction(&point, &values);
        prop_assert!((direction - n).norm() < 1e-12);
        for joint in 0..3 {
            const STEP: f64 = 1e-5;
            let moved = |sign: f64| {
                let mut values = values;
                values[joint] += sign * STEP;
                (deformation.point(&n, &values), deformation.volume(&values))
            };
            let [(before, less), (after, more)] = [moved(-1.0), moved(1.0)];
            let velocity = deformation.velocity(&n, &values, joint);
            prop_assert!((velocity - (after - before) / (2.0 * STEP)).norm() < 1e-8);
            let rate = deformation.volume_rate(&values, joint);
            prop_assert!((rate - (more - less) / (2.0 * STEP)).abs() < 1e-7);
        }
        if motion != "radial" {
            prop_assert!((deformation.volume(&values) / (aspect * volume) - 1.0).abs() < 1e-13);
        }
    }

    /// The harmonics of a degree with the amplitudes `a Y_nm(k)` are the Legendre mode about the
    /// axis `k` with the amplitude `a`, by the addition theorem: the same surface and points.
    #[test]
    fn all_orders_of_a_degree_are_the_mode_about_another_axis(
        motion in prop_oneof![Just("radial"), Just("isochoric"), Just("gradient"), Just("curl")],
        axis in prop::array::uniform3(-1.0..1.0_f64).prop_filter("a direction", |n| {
            Vector3::from(*n).norm() > 0.1
        }),
        degree in 1..=4_usize,
        amplitude in -0.04..0.04_f64,
    ) {
        let axis = Vector3::from(axis).normalize();
        let n = degree as i32;
        let modes: Vec<String> = (-n..=n).map(|m| format!("m{} = {degree}", m + n)).collect();
        let orders: Vec<String> = (-n..=n).map(|m| format!("m{} = {m}", m + n)).collect();
        let parse = |keys: &str| {
            let text = format!("{{ {keys}, motion = \"{motion}\" }}");
            let scene = sphere_with(&text, "").unwrap();
            let deformation = scene.bodies()[0].deformation.as_ref();
            deformation.and_then(Deformation::sphere).unwrap().clone()
        };
        let all = parse(&format!(
            "axis = [0, 0, 1], modes = {{ {} }}, orders = {{ {} }}", modes.join(", "),
            orders.join(", ")
        ));
        let [x, y, z]: [f64; 3] = axis.into();
        let tilted = parse(&format!("axis = [{x:?}, {y:?}, {z:?}], modes = {{ p = {degree} }}"));
        // Joints are in the order of the names; the meridian is along x.
        let mut values = vec![0.0; 2 * degree + 1];
        for (harmonic, joint) in &all.modes.as_ref().unwrap().coordinates {
            values[*joint] = amplitude * harmonic.at(&axis);
        }
        for n in [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.3, -0.7, 0.2]] {
            let n = Vector3::from(n).normalize();
            let apart = all.point(&n, &values) - tilted.point(&n, &[amplitude]);
            prop_assert!(apart.norm() < 1e-14, "{apart}");
        }
        // Rates: the sum over all orders of dX/da_m Y_m(k) is dX/da.
        let n = Vector3::new(0.3, -0.7, 0.2).normalize();
        let sum: Vector3<f64> = (all.modes.as_ref().unwrap().coordinates.iter())
            .map(|(harmonic, joint)| harmonic.at(&axis) * all.velocity(&n, &values, *joint))
            .sum();
        prop_assert!((sum - tilted.velocity(&n, &[amplitude], 0)).norm() < 1e-13);
        let volumes = [all.volume(&values), tilted.volume(&[amplitude])];
        prop_assert!((volumes[0] / volumes[1] - 1.0).abs() < 1e-13, "{volumes:?}");
    }
}

/// A mode of order 2 is symmetric about the planes of its meridian, and a curl about none of them.
#[test]
fn harmonics_keep_the_planes_that_mirror_them() {
    let planes = |keys: &str| {
        let scene = sphere_with(&format!("{{ {keys} }}"), "").unwrap();
        assert!(scene.axis().is_none(), "no axis of symmetry: {keys}");
        scene.fem_symmetry_planes()
    };
    let mode = "axis = [0, 0, 1], modes = { p = 2 }, orders";
    assert_eq!(
        planes(&format!("{mode} = {{ p = 2 }}")),
        [false, true, true]
    );
    assert_eq!(
        planes(&format!("{mode} = {{ p = -2 }}")),
        [false, false, true]
    );
    assert_eq!(
        planes(&format!("{mode} = {{ p = 1 }}")),
        [false, true, false]
    );
    let curl = format!("motion = \"curl\", {mode}");
    assert_eq!(
        planes(&format!("{curl} = {{ p = -2 }}")),
        [true, true, false]
    );
    let tilted = "axis = [3, 4, 0], meridian = [0, 0, 1], modes = { p = 2 }, orders = { p = 2 }";
    assert_eq!(planes(tilted), [false, false, true]);
}

#[test]
fn orders_that_cannot_be_are_refused_with_the_remedy() {
    for (keys, part) in [
        ("modes = { p = 2 }, orders = { p = 3 }", "from -2 to 2"),
        ("modes = { p = 2 }, orders = { p = 0.5 }", "whole numbers"),
        ("modes = { p = 2 }, orders = { q = 1 }", "no mode of p"),
        (
            "modes = { p = 2, q = 2 }, orders = { p = 1, q = 1 }",
            "the order 1 twice",
        ),
        (
            "motion = \"tangential\", modes = { p = 2 }, orders = { p = 1 }",
            "motion = \"gradient\"",
        ),
        (
            "axis = [1, 1, 0], modes = { p = 2 }, orders = { p = 1 }",
            "meridian is missing",
        ),
        (
            "modes = { p = 2 }, orders = { p = 1 }, meridian = [2, 0, 0]",
            "no direction across",
        ),
        ("kind = \"radius\", orders = { p = 1 }", "does not belong"),
    ] {
        let error = sphere_with(&format!("{{ {keys} }}"), "").unwrap_err();
        assert!(
            error.contains(part) && error.contains("scene.toml:"),
            "{keys}: {error}"
        );
    }
    for (motion, amplitude, part) in [
        ("radial", 1.3, "reach its centre"),
        ("gradient", 0.7, "fold"),
        ("curl", 5.0, "fold"),
    ] {
        let keys =
            format!("{{ motion = \"{motion}\", modes = {{ p = 2 }}, orders = {{ p = 2 }} }}");
        let gait = format!("gait.phases = [{{ targets = {{ \"a.p\" = {amplitude} }} }}]");
        let error = sphere_with(&keys, &gait).unwrap_err();
        assert!(error.contains(part), "{motion}: {error}");
    }
    let scene = sphere_with(
        "{ modes = { p = 3, q = 2 }, orders = { p = -2 }, axis = [1, 2, -2], meridian = [0, 1, 0] }",
        "",
    );
    let scene = scene.unwrap();
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.differing_key(&scene), None);
    assert_eq!(again.bodies(), scene.bodies());
}

/// A spheroid with the axis (0, 0.6, 0.8) and a deformation.
fn spheroid(deformation: &str) -> Result<Scene, String> {
    let text = format!(
        r#"
        [[bodies]]
        name = "a"
        shape = "spheroid"
        radius = 1
        half_length = 2
        axis = [0, 3, 4]
        position = [0, 0, 0]
        deformation = {deformation}
        [[gait.phases]]
        targets = {{ "a.p" = 0.1 }}
        "#
    );
    Scene::parse(&text).map_err(|error| error.to_string())
}

#[test]
fn modes_of_a_spheroid_are_about_its_axis() {
    let axis = Vector3::new(0.0, 0.6, 0.8);
    for (given, sign) in [("", 1.0_f64), (", axis = [0, -3, -4]", -1.0)] {
        let scene = spheroid(&format!("{{ modes = {{ p = 3 }}{given} }}")).unwrap();
        let deformation = scene.bodies()[0].deformation.as_ref();
        let modes = deformation.and_then(Deformation::sphere).unwrap();
        assert!((modes.axis().unwrap() - sign * axis).norm() < 1e-15);
        // Both ends of the axis move in the direction of the odd mode.
        for end in [1.0, -1.0] {
            let (length, velocity) = (2.0 + 2.0 * 0.1 * end * sign, 2.0 * sign);
            let (n, values) = (end * axis, [0.1]);
            assert!((modes.point(&n, &values) - end * length * axis).norm() < 1e-14);
            assert!((modes.velocity(&n, &values, 0) - velocity * axis).norm() < 1e-14);
        }
        let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
        assert_eq!(again.differing_key(&scene), None);
    }
    for (deformation, part) in [
        (
            "{ modes = { p = 2 }, axis = [0, 0, 1] }",
            "axis of the spheroid",
        ),
        ("{ modes = { p = 2 }, axis = [0, 0, 0] }", "no direction"),
        ("{ kind = \"radius\" }", "is a spheroid and no sphere"),
        (
            "{ kind = \"undulation\", amplitude = 1 }",
            "use shape = \"tube\"",
        ),
    ] {
        let error = spheroid(deformation).unwrap_err();
        assert!(
            error.contains(part) && error.contains("scene.toml:"),
            "{error}"
        );
    }
}

/// A worm with a deformation, in a domain and with a gait.
fn worm(deformation: &str, before: &str, gait: &str) -> Result<Scene, String> {
    let text = format!(
        r#"
        {before}
        [[bodies]]
        name = "worm"
        shape = "tube"
        length = 10
        radius = 0.5
        position = [0, 0, 0]
        deformation = {{ kind = "undulation", {deformation} }}
        [[gait.phases]]
        targets = {{ {gait} }}
        "#
    );
    Scene::parse(&text).map_err(|error| error.to_string())
}

#[test]
fn undulations_have_an_amplitude_and_a_phase_whose_turns_close() {
    let wave = "wave = \"displacement\", envelope = \"linear\", amplitude = 0.4, waves = 1.5";
    let scene = worm(wave, "", "\"worm.phase\" = 6.283185307179586").unwrap();
    let joints = scene.articulation().joints();
    let names: Vec<_> = joints.iter().map(|joint| &joint.name[..]).collect();
    assert_eq!(names, ["worm.amplitude", "worm.phase"]);
    assert_eq!(scene.articulation().initial_shape(), [0.4, 0.0]);
    assert!(
        scene
            .shape_changes(&[0.4, 0.0], &[0.4, -4.0 * PI])
            .is_empty()
    );
    assert_eq!(scene.shape_changes(&[0.4, 0.0], &[0.4, 1.0]), [(1, 1.0)]);
    // The volume is that of a straight tube, at any amplitude.
    let volume = PI * 0.25 * (10.0 + 4.0 / 3.0 * 0.5);
    let deformation = scene.bodies()[0].deformation.as_ref().unwrap();
    for values in [[0.4, 0.0], [0.7, 2.0]] {
        assert!((deformation.outline(&values).volume() / volume - 1.0).abs() < 1e-14);
    }
    let again = Scene::parse(&scene.to_toml().unwrap()).unwrap();
    assert_eq!(again.differing_key(&scene), None);
    assert_eq!(again.bodies(), scene.bodies());
}

#[test]
fn undulations_that_cannot_be_are_refused_with_place_and_time() {
    let refused = |deformation: &str, before: &str, gait: &str, parts: &[&str]| {
        let error = worm(deformation, before, gait).unwrap_err();
        assert!(error.contains("scene.toml:"), "no place: {error}");
        for part in parts {
            assert!(error.contains(part), "{error}");
        }
    };
    let turn = "\"worm.phase\" = 6.3";
    let folds = ["phase 1 at", "folds or touches itself", "smaller amplitude"];
    // Curvature 2 π a / 10 of the radius 0.5: folds at a = 3.2; before it the ends meet.
    refused("amplitude = 1", "", "\"worm.amplitude\" = 3.4", &folds);
    let bow = "amplitude = 1, waves = 0.5, phase = 1.5707963";
    refused(bow, "", "\"worm.amplitude\" = 3.1", &folds);
    refused("amplitude = 4", "", turn, &["at the start", "folds"]);
    let stretches = ["would have to stretch", "slope 1.200"];
    refused("wave = \"helix\", amplitude = 1.2", "", turn, &stretches);
    refused(
        "amplitude = 1, waves = 30",
        "",
        turn,
        &["waves", "from 0.1 to 20"],
    );
    refused("waves = 1", "", turn, &["amplitude is missing"]);
    refused(
        "amplitude = 1, modes = { p = 2 }",
        "",
        turn,
        &["does not belong"],
    );
    let channel = "domain = { kind = \"cylinder\", radius = 1.4 }";
    refused("amplitude = 1.5", channel, turn, &["outside the domain"]);
    let ball = "domain = { kind = \"ball\", radius = 5.4 }";
    refused("amplitude = 0.1", ball, turn, &["outside the domain"]);
    refused(
        "amplitude = 0.1",
        "fluid = { law = \"carreau\" }",
        turn,
        &["fluid."],
    );
    let error = sphere_with("{ kind = \"undulation\", amplitude = 1 }", "").unwrap_err();
    assert!(error.contains("use shape = \"tube\""), "{error}");
}

/// The phase of a wave turns while its amplitude oscillates: each cycle continues the one before.
#[test]
fn phases_of_waves_turn_beside_oscillations() {
    let scene = |turn: &str| {
        let gait = format!(
            "[gait]\nperiod = 2\ncycles = 3\nharmonics = [{{ link = \"worm.phase\", {turn} }}, \
             {{ link = \"worm.amplitude\", mean = 0.4, amplitude = 0.1 }}]\n"
        );
        Scene::parse(&format!(
            "{gait}[[bodies]]\nname = \"worm\"\nshape = \"tube\"\nlength = 10\nradius = 0.5\n\
             position = [0, 0, 0]\ndeformation = {{ kind = \"undulation\", amplitude = 0.4, \
             phase = 0.3 }}\n"
        ))
        .map_err(|error| error.to_string())
    };
    let whole = 2.0 * PI;
    let turning = scene(&format!("turn = {whole:?}")).unwrap();
    let all: Vec<_> = spans(turning.gait(), turning.articulation().initial_shape())
        .unwrap()
        .collect();
    assert_eq!(all.len(), 12);
    for (number, span) in all.iter().enumerate() {
        let value = |s: f64| 0.3 + 0.25 * whole * (number as f64 + s);
        for s in [0.0, 0.4, 1.0] {
            assert!((span.shape(s)[1] - value(s)).abs() < 1e-12, "{number} {s}");
            assert!((span.rates(s)[1] - PI).abs() < 1e-12);
        }
        assert!((span.shape(1.0)[0] - [0.5, 0.4, 0.3, 0.4][number % 4]).abs() < 1e-12);
    }
    let end = &all[11].to;
    assert!(
        turning.shape_changes(&all[0].from, end).is_empty(),
        "{end:?}"
    );
    let again = Scene::parse(&turning.to_toml().unwrap()).unwrap();
    assert_eq!(again.gait(), turning.gait());
    assert_eq!(
        again.articulation().initial_shape(),
        turning.articulation().initial_shape()
    );
    for (turn, part) in [
        ("turn = 3", "whole periods"),
        (
            "turn = 6.283185307179586, amplitude = 1",
            "does not belong to a `turn`",
        ),
        ("phase = 0.1", "amplitude is missing"),
    ] {
        let error = scene(turn).unwrap_err();
        assert!(
            error.contains(part) && error.contains("scene.toml:"),
            "{turn}: {error}"
        );
    }
    let growing = sphere_with(
        "{ modes = { p = 2 } }",
        "gait = { period = 1, harmonics = [{ link = \"a.p\", turn = 0.1 }] }",
    );
    let error = growing.unwrap_err();
    assert!(error.contains("has no period"), "{error}");
}

/// A wave bends a tube in its plane of x and y, unless it is a helix or the tube is rolled.
#[test]
fn the_plane_of_a_wave_is_a_symmetry_plane() {
    let planes = |deformation: &str, orientation: &str| {
        let scene = Scene::parse(&format!(
            "bodies = [{{ name = \"worm\", shape = \"tube\", length = 10, radius = 0.5, \
             position = [0, 0, 0], orientation = {orientation}, \
             deformation = {{ kind = \"undulation\", amplitude = 0.4, {deformation} }} }}]"
        ));
        scene.unwrap().fem_symmetry_planes()
    };
    let plane = [false, false, true];
    assert_eq!(planes("wave = \"curvature\"", "[0, 0, 0]"), plane);
    assert_eq!(planes("wave = \"displacement\"", "[0, 0, 0.7]"), plane);
    assert_eq!(planes("wave = \"helix\"", "[0, 0, 0]"), [false; 3]);
    assert_eq!(planes("wave = \"curvature\"", "[0.1, 0, 0]"), [false; 3]);
}

/// Targets are absolute: from the second cycle on the wave stood still, without a word.
#[test]
fn bug_waves_rested_from_the_second_cycle_on() {
    let turns = |cycles: u32, target: f64| {
        let gait = format!("\"worm.phase\" = {target:?}");
        worm("amplitude = 0.4", &format!("gait.cycles = {cycles}"), &gait)
    };
    assert!(turns(1, 4.0 * PI).is_ok());
    let error = turns(2, 2.0 * PI).unwrap_err();
    assert!(
        error.contains("cycles") && error.contains("phase of 'worm'"),
        "{error}"
    );
    // An amplitude of the body that the gait does not start from was ignored.
    let harmonic = Scene::parse(
        "gait = { period = 1, harmonics = [{ link = \"worm.amplitude\", mean = 0.3, \
         amplitude = 0.1 }] }\n\
         [[bodies]]\nname = \"worm\"\nshape = \"tube\"\nlength = 10\nradius = 0.5\n\
         position = [0, 0, 0]\ndeformation = { kind = \"undulation\", amplitude = 0.4 }\n",
    );
    let error = harmonic.unwrap_err().to_string();
    assert!(error.contains("the gait starts at 0.3"), "{error}");
}

/// A taper bulges out of the convex hull of its end balls: gaps to walls were too large.
#[test]
fn bug_gaps_of_tapered_tubes_were_too_large() {
    let text = "bodies = [{ name = \"t\", shape = \"tube\", length = 8, radius = 0.5, \
                end_radius = 0.1, position = [0, 0, 0] }]";
    let scene = Scene::parse(text).unwrap();
    let shape = &scene.bodies()[0].shape;
    let n = Vector3::new(0.0489, 0.0, 1.0).normalize();
    let support = shape.support_point(&UnitQuaternion::identity(), &n).dot(&n);
    // Points of the circles of the radius a + (b - a) (3 x² - 2 x³).
    let of_circle = |k: u32| {
        let x = f64::from(k) / 1000.0;
        let radius = 0.5 - 0.4 * (3.0 * x * x - 2.0 * x * x * x);
        (8.0 * x - 4.0) * n.x + radius * n.z
    };
    let most = (0..=1000).map(of_circle).fold(f64::NEG_INFINITY, f64::max);
    assert!(support >= most - 1e-6, "{support} {most}");
}

/// Between two gaps of the same width through the faces of a box the repulsion of the nearest image
/// alone was not zero, and jumped.
#[test]
fn bug_repulsion_knew_one_image() {
    let scene = Scene::parse(
        "domain = { kind = \"periodic\", size = [4.2, 9, 9] }\n\
         contact = { range = 0.05, strength = 1 }\n\
         bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }, \
         { name = \"b\", radius = 1, position = [2.1, 0, 0] }]",
    )
    .unwrap();
    let poses = scene
        .articulation()
        .place(&scene.initial_state(), &[])
        .unwrap();
    for load in scene.loads(0.0, &poses) {
        assert!(load.force.norm() < 1e-12, "{}", load.force);
    }
}

/// A worm off the centre of a ball: its straight ends are at √(4² + 2²) = 4.472 and reach 4.972.
#[test]
fn bug_worms_that_fit_into_a_ball_were_refused_with_the_ball_around_them() {
    let scene = |radius: f64| {
        Scene::parse(&format!(
            r#"
            domain = {{ kind = "ball", radius = {radius} }}
            bodies = [{{ name = "worm", shape = "tube", length = 8, radius = 0.5,
                         position = [0, 2, 0],
                         deformation = {{ kind = "undulation", amplitude = 0.02 }} }}]
            gait.phases = [{{ targets = {{ "worm.phase" = 6.283185307179586 }} }}]
            "#
        ))
        .map(drop)
        .map_err(|error| error.to_string())
    };
    assert_eq!(scene(5.1), Ok(()));
    let refused = scene(4.8).unwrap_err();
    assert!(refused.contains("outside the domain"), "{refused}");
}

/// Where more parts of the sphere were needed than are divided, no smaller part of a phase helped:
/// the search ended at its shortest part and called that a fold.
#[test]
fn bug_gaits_of_high_degrees_came_close_to_folds_that_are_none() {
    let text = |amplitude: f64| {
        format!(
            "model.kind = \"fem\"\n\
             domain = {{ kind = \"ball\", radius = 4 }}\n\
             bodies = [{{ name = \"a\", radius = 1, position = [0, 0, 0], deformation = {{ \
             kind = \"modes\", motion = \"gradient\", modes = {{ p = 12, q = 11 }}, \
             orders = {{ p = 5, q = 3 }} }} }}]\n\
             gait.phases = [{{ targets = {{ \"a.p\" = {amplitude}, \"a.q\" = 0.004 }} }}]\n"
        )
    };
    Scene::parse(&text(0.012)).unwrap();
    let error = Scene::parse(&text(0.2)).unwrap_err().to_string();
    assert!(error.contains("would fold at its point"), "{error}");
}
