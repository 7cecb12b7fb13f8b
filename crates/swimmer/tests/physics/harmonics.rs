//! Spheres whose modes have no axis of symmetry: spherical harmonics with degree and order.

use std::f64::consts::{PI, TAU};

use nalgebra::{UnitQuaternion, Vector3};
use proptest::prelude::*;
use swimmer::Scene;
use swimmer::models::InstantaneousSolution;
use swimmer::scene::{Deformation, Harmonic};
use testkit::{boxed, run, solve_at, within};

/// A sphere with modes `a`, `b`, .. of these degrees and orders.
fn sphere(motion: &str, modes: &[(usize, i32)], keys: &str, settings: &str) -> Scene {
    let table = |number: &dyn Fn(&(usize, i32)) -> i32| {
        let named = modes.iter().zip('a'..);
        let entries = named.map(|(mode, name)| format!("{name} = {}", number(mode)));
        entries.collect::<Vec<_>>().join(", ")
    };
    let text = format!(
        r#"
        {settings}
        [[bodies]]
        name = "s"
        radius = 1
        position = [0, 0, 0]
        [bodies.deformation]
        motion = "{motion}"
        modes = {{ {degrees} }}
        orders = {{ {orders} }}
        {keys}
        [[gait.phases]]
        targets = {{ "s.a" = 0.01 }}
        "#,
        degrees = table(&|mode| mode.0 as i32),
        orders = table(&|mode| mode.1),
    );
    Scene::parse(&text).unwrap()
}

const ALONG_Z: &str = "axis = [0, 0, 1]";

fn solution(scene: &Scene, values: &[f64], rates: &[f64]) -> InstantaneousSolution {
    solve_at(boxed(scene).as_mut(), values, rates)
}

/// By the reciprocal theorem a free sphere of radius one with the velocity `s` of its surface moves
/// at `-<s>` and turns at `-(3/2) <n × s>` (Stone & Samuel 1996): the means over the sphere, by a
/// product rule that is exact for polynomials up to degree 59.
fn velocities_of_surface(scene: &Scene, values: &[f64], rates: &[f64]) -> [Vector3<f64>; 2] {
    const RINGS: usize = 60;
    let deformation = scene.bodies()[0].deformation.as_ref().unwrap();
    let body = deformation.at(values);
    let mut sums = [Vector3::zeros(); 2];
    for i in 0..RINGS {
        // Fejér's rule for the height, the cosine of equidistant angles.
        let angle = (i as f64 + 0.5) * PI / RINGS as f64;
        let terms = (1..=RINGS / 2).map(|k| {
            let k = k as f64;
            (2.0 * k * angle).cos() / (4.0 * k * k - 1.0)
        });
        let weight = (1.0 - 2.0 * terms.sum::<f64>()) / (RINGS * RINGS) as f64;
        for k in 0..RINGS {
            let (y, x) = (TAU * k as f64 / RINGS as f64).sin_cos();
            let n = Vector3::new(angle.sin() * x, angle.sin() * y, angle.cos());
            let speed = |(joint, rate): (usize, &f64)| *rate * body.velocity(&n, joint);
            let s: Vector3<f64> = rates.iter().enumerate().map(speed).sum();
            sums[0] -= weight * s;
            sums[1] -= 1.5 * weight * n.cross(&s);
        }
    }
    sums
}

/// Modes of degree one move material points like the sphere itself: gradients translate it by
/// -2/3 of their rates, the mean of `e - n n·e`, and curls turn it by -1, whatever the order, so
/// that a rotation by a curl moves nothing in the laboratory.
#[test]
fn curls_of_degree_one_move_nothing_and_gradients_two_thirds() {
    let directions = [(1, Vector3::x()), (-1, Vector3::y()), (0, Vector3::z())];
    for (order, e) in directions {
        let of = |motion: &str| {
            let scene = sphere(motion, &[(1, order)], ALONG_Z, "model.kind = \"multipole\"");
            let found = solution(&scene, &[0.0], &[1.0]).bodies[0];
            (found.velocity, found.angular_velocity)
        };
        let (velocity, spin) = of("gradient");
        within((velocity + e * (2.0 / 3.0)).norm(), 1e-11, "rounding");
        within(spin.norm(), 1e-11, "rounding");
        let (velocity, spin) = of("curl");
        within(velocity.norm(), 1e-11, "rounding");
        // n × ∇(n·e) = -e × n turns with -e, the body with e.
        within((spin - e).norm(), 1e-11, "rounding");
    }
}

/// At finite amplitudes, by expansions.
#[test]
fn tangential_harmonics_swim_as_the_reciprocal_theorem_says() {
    let modes = [(2, 1), (3, -2), (1, 1)];
    let (values, rates) = ([0.04, -0.02, 0.05], [1.0, 0.7, -0.4]);
    for motion in ["gradient", "curl"] {
        let settings = "model = { kind = \"multipole\", tolerance = 1e-8 }";
        let scene = sphere(motion, &modes, ALONG_Z, settings);
        let found = solution(&scene, &values, &rates);
        let [velocity, spin] = velocities_of_surface(&scene, &values, &rates);
        within(
            (found.bodies[0].velocity - velocity).norm(),
            1e-9,
            "the tolerance",
        );
        within(
            (found.bodies[0].angular_velocity - spin).norm(),
            1e-9,
            "the tolerance",
        );
        assert!(
            velocity.norm() > 1e-2 && spin.norm() > 1e-5,
            "{velocity} {spin}"
        );
    }
}

/// The same by elements in space, within their bars, with the power by both models.
#[test]
fn tangential_harmonics_by_elements() {
    let modes = [(2, 1), (1, 1)];
    let (values, rates) = ([0.1, 0.08], [1.0, -0.4]);
    for motion in ["gradient", "curl"] {
        let of = |kind: &str| {
            let scene = sphere(motion, &modes, ALONG_Z, &format!("model.kind = \"{kind}\""));
            solution(&scene, &values, &rates)
        };
        let [found, exact] = ["fem", "multipole"].map(of);
        let [own, other] = [&found.bodies[0], &exact.bodies[0]];
        let bar = found.error_estimate.total() + exact.error_estimate.total();
        within((own.velocity - other.velocity).norm(), bar, "the error bar");
        within(bar, 0.02, "the bar says something");
        let bar = found.angular_velocity_error.total() + exact.angular_velocity_error.total();
        let apart = own.angular_velocity - other.angular_velocity;
        within(apart.norm(), bar, "the error bar");
        within(bar, 0.05, "the bar says something");
        let bar = found.power_error.total() + exact.power_error.total();
        within(found.power() - exact.power(), bar, "the error bar");
        within(bar, 0.05 * exact.power(), "the bar says something");
    }
}

/// A translation `e` is the radial mode `n·e` and the gradient `e - n n·e`: by elements the first
/// one moves the sphere by `-e/3`, so that both together move nothing in the laboratory.
#[test]
fn radial_modes_of_degree_one_move_a_third() {
    for (order, e) in [(1, Vector3::x()), (-1, Vector3::y())] {
        let scene = sphere("radial", &[(1, order)], ALONG_Z, "model.kind = \"fem\"");
        let found = solution(&scene, &[0.0], &[1.0]);
        let bar = found.error_estimate.total();
        within(
            (found.bodies[0].velocity + e / 3.0).norm(),
            bar,
            "the error bar",
        );
        within(bar, 5e-3, "the bar says something");
    }
}

/// All orders of the degrees 2 and 3 with the amplitudes `Y_nm(k)` are the Legendre modes about
/// `k`: the velocity of second order by elements is that of the meridian plane, turned.
#[test]
fn all_orders_swim_as_the_modes_about_a_tilted_axis() {
    let k = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    let [p2, p3, of_p2, of_p3] = [0.12, -0.1, 0.5, 1.0];
    let orders = |n: i32| (-n..=n).map(move |m| (n as usize, m));
    let modes: Vec<_> = orders(2).chain(orders(3)).collect();
    let along = |amplitudes: [f64; 2]| -> Vec<f64> {
        let value = |&(degree, order): &(usize, i32)| {
            amplitudes[degree - 2] * Harmonic { degree, order }.at(&k)
        };
        modes.iter().map(value).collect()
    };
    let axis = format!("axis = [{:?}, {:?}, {:?}]", k.x, k.y, k.z);
    for motion in ["radial", "isochoric"] {
        let tilted = sphere(
            motion,
            &[(2, 0), (3, 0)],
            &axis,
            "model = { kind = \"axisymmetric\", tolerance = 1e-6 }",
        );
        let exact = solution(&tilted, &[p2, p3], &[of_p2, of_p3]);
        let scene = sphere(motion, &modes, ALONG_Z, "model.kind = \"fem\"");
        let found = solution(&scene, &along([p2, p3]), &along([of_p2, of_p3]));
        let velocity = exact.bodies[0].velocity;
        assert!(velocity.dot(&k).abs() > 1e-2, "{velocity}");
        let bar = found.error_estimate.total() + exact.error_estimate.total();
        within(
            (found.bodies[0].velocity - velocity).norm(),
            bar,
            "the error bar",
        );
        within(bar, 0.05 * velocity.norm(), "the bar says something");
        let bar = found.power_error.total() + exact.power_error.total();
        within(found.power() - exact.power(), bar, "the error bar");
        within(bar, 0.02 * exact.power(), "the bar says something");
    }
}

/// A mode that is mirrored by planes needs a quarter of the fluid, on meshes that move with it.
#[test]
fn harmonics_need_the_fluid_beside_their_planes() {
    let of = |symmetry: &str| {
        let settings = format!("model.kind = \"fem\"\nfem.symmetry = \"{symmetry}\"");
        let scene = sphere("isochoric", &[(2, 2), (3, 2), (1, 0)], ALONG_Z, &settings);
        assert_eq!(
            scene.fem_symmetry_planes(),
            [symmetry == "auto", symmetry == "auto", false]
        );
        let mut model = boxed(&scene);
        let rates = [1.0, -0.5, 0.3];
        [0.1, 0.12].map(|a| solve_at(model.as_mut(), &[a, 0.05, 0.0], &rates))
    };
    let [quarter, whole] = ["auto", "off"].map(of);
    assert!(quarter[1].remeshed.is_none(), "the second mesh is moved");
    for (quarter, whole) in quarter.iter().zip(&whole) {
        assert!(2 * quarter.dofs.total < whole.dofs.total);
        let bar = quarter.error_estimate.total() + whole.error_estimate.total();
        let apart = quarter.bodies[0].velocity - whole.bodies[0].velocity;
        within(apart.norm(), bar, "the error bars");
    }
}

/// A wave of tangential modes around the axis turns the sphere, by as much as the reciprocal
/// theorem says along the period.
#[test]
#[ignore = "slow: 30 s"]
fn a_wave_around_the_axis_turns_the_sphere() {
    let text = format!(
        r#"
        model = {{ kind = "multipole", tolerance = 1e-6 }}
        [[bodies]]
        name = "s"
        radius = 1
        position = [0, 0, 0]
        [bodies.deformation]
        motion = "gradient"
        axis = [0, 0, 1]
        modes = {{ a = 2, b = 2 }}
        orders = {{ a = 2, b = -2 }}
        [gait]
        period = {TAU:?}
        harmonics = [
            {{ link = "s.a", mean = 0, amplitude = 0.1, phase = {:?} }},
            {{ link = "s.b", mean = 0, amplitude = 0.1 }},
        ]
        "#,
        0.5 * PI
    );
    let scene = Scene::parse(&text).unwrap();
    // The wave turns steadily, and so does the sphere.
    let [_, spin] = velocities_of_surface(&scene, &[0.1, 0.0], &[0.0, 0.1]);
    let outcome = run(&scene);
    within(outcome.rotation.z - TAU * spin.z, 1e-6, "the tolerance");
    assert!(spin.z.abs() > 1e-3, "{spin}");
    within(
        outcome.displacement[0].norm(),
        1e-8,
        "the symmetry of the wave",
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 8, ..ProptestConfig::default() })]

    /// Velocities of tangential harmonics turn with their axis and meridian, and reverse with the
    /// rates; beside another sphere too.
    #[test]
    fn harmonics_are_the_same_in_all_frames_and_reversible(
        motion in prop_oneof![Just("gradient"), Just("curl")],
        turn in prop::array::uniform3(-2.0..2.0_f64),
        orders in (-2..=2_i32, -3..=3_i32),
        values in prop::array::uniform2(-0.02..0.02_f64),
        rates in prop::array::uniform2(-1.0..1.0_f64),
    ) {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::from(turn));
        let scene = |rotation: UnitQuaternion<f64>| {
            let [axis, meridian, other] = [Vector3::z(), Vector3::x(), Vector3::new(2.5, 0.5, 1.0)]
                .map(|v| {
                    let [x, y, z]: [f64; 3] = (rotation * v).into();
                    format!("[{x:?}, {y:?}, {z:?}]")
                });
            let keys = format!("axis = {axis}\nmeridian = {meridian}");
            let settings = format!(
                "model.kind = \"multipole\"\n[[bodies]]\nname = \"o\"\nradius = 0.8\n\
                 position = {other}"
            );
            sphere(motion, &[(2, orders.0), (3, orders.1)], &keys, &settings)
        };
        let solve = |rotation, sign: f64| {
            solution(&scene(rotation), &values, &rates.map(|rate| sign * rate))
        };
        let unit = UnitQuaternion::identity();
        let [own, back, turned] = [solve(unit, 1.0), solve(unit, -1.0), solve(rotation, 1.0)];
        let bar = own.error_estimate.total() + turned.error_estimate.total();
        for body in 0..2 {
            let [own, back, turned] = [&own, &back, &turned].map(|of| of.bodies[body].velocity);
            let apart = (rotation * own - turned).norm();
            prop_assert!(apart <= bar + 1e-9, "{apart} {bar}");
            prop_assert!((own + back).norm() < 1e-9);
        }
        let powers = [own.power(), back.power()];
        prop_assert!((powers[0] - powers[1]).abs() <= 1e-9 * powers[0]);
    }
}

/// One coordinate leads nowhere, with or without an axis: the body comes back with its rotation.
#[test]
fn one_harmonic_leads_nowhere() {
    for motion in ["gradient", "curl"] {
        let scene = sphere(
            motion,
            &[(2, 1)],
            ALONG_Z,
            "model = { kind = \"multipole\", tolerance = 1e-5 }\n[[bodies]]\nname = \"o\"\nradius = 0.8\nposition = [2.2, 0.5, 0.4]",
        );
        let text = scene.to_toml().unwrap();
        let back = "[[gait.phases]]\nduration = 5.0\n[gait.phases.targets]\n\"s.a\" = 0.0\n";
        let scene = Scene::parse(&format!("{}\n{back}", text.replace("0.01", "0.06"))).unwrap();
        let outcome = run(&scene);
        let there = outcome.spans[0].displacement[0].norm();
        assert!(there > 1e-5, "{there}");
        let bar = outcome.error_estimate.total().max(1e-7);
        within(
            outcome.displacement[0].norm(),
            bar.min(0.1 * there),
            "the error bar",
        );
    }
}

/// Other models than elements refuse shapes without an axis, with place and remedy.
#[test]
fn models_of_spheres_and_of_the_plane_refuse_other_shapes() {
    for (kind, motion) in [
        ("axisymmetric", "gradient"),
        ("multipole", "radial"),
        ("rpy", "curl"),
    ] {
        let scene = sphere(
            motion,
            &[(2, 1)],
            ALONG_Z,
            &format!("model.kind = \"{kind}\""),
        );
        let refused = swimmer::choose(&scene).map(|_| ()).unwrap_err().to_string();
        assert!(
            refused.contains("scene.toml:") && refused.contains("model.kind"),
            "{refused}"
        );
    }
    let scene = sphere("radial", &[(2, 1)], ALONG_Z, "");
    assert_eq!(swimmer::choose(&scene).unwrap().model.name(), "fem");
    let deformation = scene.bodies()[0].deformation.as_ref();
    assert!(deformation.is_some_and(|of| !Deformation::is_axisymmetric(of)));
}
