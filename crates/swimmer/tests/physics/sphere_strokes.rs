//! Strokes by the mesh-free models, against exact displacements.

use nalgebra::Vector3;
use scene::{FemOptions, SceneBuilder};
use swimmer::{Method, Scene, choose, with_tables};
use testkit::exact::{
    STEPS, STEPS_OSEEN, STEPS_RPY, STROKE, STROKE_IN_BALL, STROKE_OSEEN, STROKE_RPY,
};
use testkit::{SceneText, run, run_by, three_spheres, within};

#[test]
fn the_three_sphere_stroke_by_every_model() {
    for (model, steps, net) in [
        ("oseen", STEPS_OSEEN, STROKE_OSEEN),
        ("rpy", STEPS_RPY, STROKE_RPY),
        ("multipole", STEPS, STROKE.value),
    ] {
        let outcome = run(&three_spheres().model(model, 1e-8).scene());
        for (span, step) in outcome.spans.iter().zip(steps) {
            let why = format!("the tolerance: {model}");
            within(span.displacement[1].x - step, 1e-8, why);
        }
        within(
            outcome.displacement[1].x - net,
            1e-8,
            format!("the tolerance: {model}"),
        );
        assert!(outcome.tolerance_met);
        within(outcome.displacement[1].yz().norm(), 1e-12, "rounding");
        within(outcome.rotation.norm(), 1e-12, "rounding");
    }
}

#[test]
fn the_three_sphere_stroke_in_balls() {
    for (radius, net) in STROKE_IN_BALL {
        let outcome = run(&three_spheres()
            .ball(radius)
            .model("multipole", 1e-8)
            .scene());
        net.check(
            outcome.displacement[1].x,
            1e-8,
            &format!("the tolerance: {radius}"),
        );
    }
}

/// The three-sphere stroke between two lengths at the arm speed 4.
fn stroke_between(open: f64, closed: f64, cycles: u32, model: &str, tolerance: f64) -> Scene {
    stroke(open, closed, cycles, model, tolerance)
        .build()
        .unwrap()
}

fn stroke(open: f64, closed: f64, cycles: u32, model: &str, tolerance: f64) -> SceneBuilder {
    let duration = (open - closed) / 4.0;
    let mut builder = Scene::builder()
        .sphere("l", 1.0, [-open, 0.0, 0.0])
        .sphere("c", 1.0, [0.0; 3])
        .sphere("r", 1.0, [open, 0.0, 0.0])
        .slide("left", "l", "c")
        .slide("right", "r", "c")
        .cycles(cycles)
        .model(serde_json::from_value(model.into()).unwrap())
        .tolerance(tolerance);
    for (joint, length) in [
        ("left", closed),
        ("right", closed),
        ("left", open),
        ("right", open),
    ] {
        builder = builder.phase(joint, length, duration);
    }
    builder
}

/// Work of a cycle at the arm speed 4: opened and closed length, and the exact value (spectral).
const WORK: [(f64, f64, f64); 5] = [
    (10.0, 6.0, 925.347074),
    (10.0, 9.0, 225.408096),
    (10.0, 4.0, 1432.321382),
    (6.0, 3.0, 817.414923),
    (20.0, 16.0, 852.151519),
];

#[test]
fn the_work_of_a_stroke_is_within_its_error_bar_of_the_exact_value() {
    for (open, closed, exact) in WORK {
        for (cycles, tolerance) in [(1, 1e-3), (1, 1e-8), (3, 1e-6)] {
            // Three cycles are tabulated.
            let scene = stroke_between(open, closed, cycles, "multipole", tolerance);
            let mut model = with_tables(&scene, choose(&scene).unwrap()).unwrap().model;
            let outcome = run_by(model.as_mut(), Method::Collocation);
            let error = outcome.work - f64::from(cycles) * exact;
            let bar = outcome.work_error.total();
            let digits = f64::from(cycles) * 5e-7;
            within(
                error,
                bar + digits,
                format!("bar and nine digits: {open} {closed}"),
            );
            // The tolerance is that of the displacement, which is a smaller part of the lengths
            // than the work is of the power, and both converge at the same rate.
            within(
                bar,
                100.0 * tolerance * exact,
                format!("as displacements: {open} {closed}"),
            );
        }
    }
}

#[test]
#[ignore = "slow: 6 s"]
fn the_work_by_elements_in_space_and_in_the_meridian_plane_is_within_its_error_bar() {
    let (open, closed, exact) = WORK[3];
    for (model, largest) in [("axisymmetric", 1e-2), ("fem", 0.05)] {
        let mut coarse = FemOptions::default();
        coarse.size_factor = Some(1.5);
        let scene = stroke(open, closed, 1, model, 1e-2).fem(coarse).build();
        let outcome = run(&scene.unwrap());
        let bar = outcome.work_error.total();
        within(outcome.work - exact, bar, format!("the error bar: {model}"));
        within(
            bar,
            largest * exact,
            format!("the bar says something: {model}"),
        );
    }
}

/// Spheres on arms of 6 from a junction; the first two arms close to 4 and open again.
fn star(directions: &[Vector3<f64>]) -> SceneText {
    let text = SceneText::new().point("j", [0; 3]);
    let text = directions.iter().enumerate().fold(text, |text, (k, e)| {
        let (sphere, arm) = (format!("s{k}"), format!("a{k}"));
        text.sphere(&sphere, 1.0, (6.0 * e).as_slice())
            .slide(&arm, &sphere, "j")
    });
    text.phases(&[("a0", 4.0), ("a1", 4.0), ("a0", 6.0), ("a1", 6.0)])
}

/// Displacement and rotation for arms that are clamped, free, or keep the rotations of the lab.
type OfArms = [[[f64; 3]; 2]; 3];

fn check_star(text: &SceneText, exact: OfArms) {
    for (arms, [net, rotation]) in ["clamped", "free", "lab"].iter().zip(exact) {
        let text = text
            .clone()
            .with("gait.arms", arms)
            .model("multipole", 1e-6);
        let outcome = run(&text.scene());
        let why = format!("a tenth of the tolerance: {arms}");
        within(
            (outcome.displacement[0] - Vector3::from(net)).norm(),
            1e-7,
            &why,
        );
        let error = (outcome.rotation - Vector3::from(rotation)).norm();
        within(error, 1e-7, &why);
        // The exact values have 18 digits.
        let bar = outcome.rotation_error.total() + 1e-15;
        within(error, bar, format!("the error bar of the rotation: {arms}"));
        within(bar, 1e-6, format!("the tolerance, in radians: {arms}"));
    }
}

// Lefebvre-Lepot & Merlet (2009); collocation and a method of fundamental solutions agree to 1e-11.
#[test]
fn the_planar_swimmer_has_the_exact_displacement_and_rotation() {
    let clamped = [0.004791832418980625, -0.0026805960395928506, 0.0];
    let free = [0.004667202336353144, -0.002607693358089058, 0.0];
    let lab = [0.007340621150791131, -0.004238109597428583, 0.0];
    let exact = [
        [clamped, [0.0, 0.0, 0.027120360738385564]],
        [free, [0.0, 0.0, 0.02815968765431789]],
        [lab, [0.0; 3]],
    ];
    check_star(&testkit::planar(|x| x), exact);
}

// Alouges et al. (2013); collocation and a method of fundamental solutions agree to 1e-11.
#[test]
fn the_tetrahedral_swimmer_has_the_exact_displacement_and_rotation() {
    let corners = [
        [1.0, 1.0, 1.0],
        [1.0, -1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, -1.0, 1.0],
    ];
    let directions = corners.map(|corner| Vector3::from(corner) / 3.0_f64.sqrt());
    let clamped = [
        7.608613702185518e-05,
        0.0045765204228767975,
        0.004576520422876715,
    ];
    let free = [
        7.758427939318449e-05,
        0.0044049086287823325,
        0.004404908628781979,
    ];
    let lab = [0.0, 0.006762950325282432, 0.0067629503252824175];
    let exact = [
        [clamped, [0.0, 0.016624558666787786, -0.016624558666787737]],
        [free, [0.0, 0.017612231013913925, -0.01761223101391386]],
        [lab, [0.0; 3]],
    ];
    check_star(&star(&directions), exact);
}

#[test]
fn templates_have_the_documented_displacements() {
    let displacements = [
        (
            include_str!("../../templates/three-sphere.toml"),
            1,
            [0.1598053404, 0.0, 0.0],
        ),
        (
            include_str!("../../templates/smooth.toml"),
            1,
            [0.1238046711583, 0.0, 0.0],
        ),
        (
            include_str!("../../templates/planar.toml"),
            0,
            [0.0047918, -0.0026806, 0.0],
        ),
        (
            include_str!("../../templates/tetrahedral.toml"),
            0,
            [0.0000761, 0.0045765, 0.0045765],
        ),
        (include_str!("../../templates/scallop.toml"), 1, [0.0; 3]),
    ];
    for (text, body, net) in displacements {
        let scene = SceneText::file(text).scene();
        let exact = Vector3::from(net);
        let error = (run(&scene).displacement[body] - exact).norm();
        let tolerance = 2.0 * scene.model().tolerance * exact.norm();
        let why = "the tolerance applies to the mean of the bodies, about which junctions rotate";
        within(error, tolerance + 1e-7, why);
    }
    let chain = SceneText::file(include_str!("../../templates/chain.toml"));
    assert!(run(&chain.scene()).net() > 0.01);
}

/// A sphere under a torque, a motor between coaxial spheres, a spheroid under a torque: nothing is
/// displaced, and the tolerance is relative to the path of the surfaces.
#[test]
fn bug_scenes_that_only_rotate_met_no_tolerance() {
    let sphere = r#"
        bodies = [{ name = "ball", radius = 1, position = [0, 0, 0], torque = [0, 0, 100] }]
        gait.phases = [{ duration = 1 }, { duration = 2 }]
    "#;
    let outcome = run(&Scene::parse(sphere).unwrap());
    assert!(outcome.tolerance_met);
    // `ω = T / (8 π μ a^3)` for three units of time: almost two turns.
    let angle = 3.0 * 100.0 / (8.0 * std::f64::consts::PI);
    within(outcome.rotation.z - angle, 1e-12, "rounding");
    let last = outcome.samples.last().unwrap();
    within(last.turnings[0].vector.z - angle, 1e-12, "rounding");
    within(outcome.longest_arc - angle, 1e-12, "rounding");

    let motor = r#"
        bodies = [
            { name = "tail", radius = 1, position = [0, 0, 0] },
            { name = "head", radius = 2, position = [4, 0, 0] },
        ]
        links = [{ name = "m", joint = "rotor", body = "tail", to = "head", axis = [1, 0, 0] }]
        gait.phases = [{ link = "m", length = 6 }]
    "#;
    let outcome = run(&Scene::parse(motor).unwrap());
    assert!(outcome.tolerance_met);
    let turnings = &outcome.samples.last().unwrap().turnings;
    let rotations = [0, 1].map(|body: usize| turnings[body].vector);
    within(rotations[0].x - rotations[1].x - 6.0, 1e-12, "rounding");
    // The torques balance, and those of the far smaller sphere are an eighth.
    assert!(rotations[0].x * rotations[1].x < 0.0);

    let spheroid = r#"
        bodies = [{ name = "egg", shape = "spheroid", radius = 1, half_length = 2,
                    position = [0, 0, 0], torque = [0, 0, 1] }]
        gait.phases = [{ duration = 1 }]
    "#;
    let scene = Scene::parse(spheroid).unwrap();
    let Ok(report) = swimmer::run_without_files(scene, &mut ()) else {
        panic!("not integrated");
    };
    assert!(report.outcome.tolerance_met);
    // Chwang & Wu (1974): `T = 8 π μ a^3 Y^C ω`; with `e = √3/2` and `L = ln((1+e)/(1-e))`,
    // `Y^C = (4/3) e^3 (2 - e^2) / (-2 e + (1 + e^2) L)` for the half length `a`.
    let e = 0.75_f64.sqrt();
    let l = ((1.0 + e) / (1.0 - e)).ln();
    let y = 4.0 / 3.0 * e.powi(3) * (2.0 - e * e) / (-2.0 * e + (1.0 + e * e) * l);
    let exact = 1.0 / (8.0 * std::f64::consts::PI * 8.0 * y);
    within(
        report.outcome.rotation.z - exact,
        1e-3 * exact,
        "the tolerance of elements",
    );
}
