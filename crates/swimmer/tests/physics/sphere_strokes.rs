//! Strokes by the mesh-free models, against exact displacements.

use nalgebra::Vector3;
use scene::{FemOptions, SceneBuilder};
use swimmer::{Method, Outcome, Scene, choose, simulate, with_tables};

/// The three-sphere swimmer of Najafi & Golestanian (2004): arms of 10 close to 6 and open again.
pub fn three_spheres(domain: &str, model: &str, tolerance: f64) -> Scene {
    let phases: String = [("left", 6), ("right", 6), ("left", 10), ("right", 10)]
        .map(|(joint, length)| format!("[[gait.phases]]\nlink = \"{joint}\"\nlength = {length}\n"))
        .concat();
    Scene::parse(&format!(
        "domain = {domain}\n\
         bodies = [\n\
           {{ name = \"l\", radius = 1, position = [-10, 0, 0] }},\n\
           {{ name = \"c\", radius = 1, position = [0, 0, 0] }},\n\
           {{ name = \"r\", radius = 1, position = [10, 0, 0] }},\n\
         ]\n\
         links = [{{ name = \"left\", body = \"l\", to = \"c\" }}, \
         {{ name = \"right\", body = \"r\", to = \"c\" }}]\n\
         model = {{ kind = \"{model}\", tolerance = {tolerance:e} }}\n{phases}"
    ))
    .unwrap()
}

pub const UNBOUNDED: &str = "{ kind = \"unbounded\" }";

pub fn run(scene: &Scene) -> Outcome {
    let mut model = choose(scene).unwrap().model;
    simulate(scene, model.as_mut(), Method::Collocation, &mut ()).unwrap()
}

#[test]
fn the_three_sphere_stroke_by_every_model() {
    // Displacements of the centre sphere per phase: Oseen, RPY, exact (bispherical series and
    // collocation agree to 1e-12).
    for (model, steps, net) in [
        (
            "oseen",
            [-1.353092738366866, 1.4391384581513114],
            0.1720914395688904,
        ),
        (
            "rpy",
            [-1.3529873030998665, 1.435496826965346],
            0.16501904773095988,
        ),
        (
            "multipole",
            [-1.352634331801177, 1.4325370019952646],
            0.1598053403881754,
        ),
    ] {
        let outcome = run(&three_spheres(UNBOUNDED, model, 1e-8));
        for (span, step) in outcome.spans.iter().zip(steps) {
            assert!(
                (span.displacement[1].x - step).abs() < 1e-8,
                "{model}: {} {step}",
                span.displacement[1].x
            );
        }
        assert!(
            (outcome.displacement[1].x - net).abs() < 1e-8,
            "{model}: {}",
            outcome.displacement[1].x
        );
        assert!(outcome.tolerance_met);
        assert!(outcome.displacement[1].yz().norm() < 1e-12 && outcome.rotation.norm() < 1e-12);
    }
}

#[test]
fn the_three_sphere_stroke_in_balls() {
    for (radius, net) in [
        (25, 0.15973257986289502),
        (40, 0.1604180159643671),
        (80, 0.15993017649902952),
    ] {
        let domain = format!("{{ kind = \"ball\", radius = {radius} }}");
        let outcome = run(&three_spheres(&domain, "multipole", 1e-8));
        assert!(
            (outcome.displacement[1].x - net).abs() < 1e-8,
            "{radius}: {}",
            outcome.displacement[1].x
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
            let outcome = simulate(&scene, model.as_mut(), Method::Collocation, &mut ()).unwrap();
            let error = (outcome.work - f64::from(cycles) * exact).abs();
            let bar = outcome.work_error.total();
            // The exact values have nine digits.
            let rounding = f64::from(cycles) * 5e-7;
            assert!(
                error <= bar + rounding,
                "{open} {closed}: {error:e} {bar:e}"
            );
            // The tolerance is that of the displacement, which is a smaller part of the lengths
            // than the work is of the power, and both converge at the same rate.
            assert!(bar <= 100.0 * tolerance * exact, "{open} {closed}: {bar:e}");
        }
    }
}

#[test]
fn the_work_by_elements_in_space_and_in_the_meridian_plane_is_within_its_error_bar() {
    let (open, closed, exact) = WORK[3];
    for (model, largest) in [("axisymmetric", 1e-2), ("fem", 0.05)] {
        let mut coarse = FemOptions::default();
        coarse.size_factor = Some(1.5);
        let scene = stroke(open, closed, 1, model, 1e-2).fem(coarse).build();
        let outcome = run(&scene.unwrap());
        let (error, bar) = ((outcome.work - exact).abs(), outcome.work_error.total());
        assert!(
            error <= bar && bar <= largest * exact,
            "{model}: {error:e} {bar:e}"
        );
    }
}

/// Spheres on arms of 6 from a junction; the first two arms close to 4 and open again.
fn star(directions: &[Vector3<f64>], arms: &str) -> Scene {
    let bodies: String = directions
        .iter()
        .enumerate()
        .map(|(k, e)| {
            let x = 6.0 * e;
            format!(
                "[[bodies]]\nname = \"s{k}\"\nradius = 1\nposition = [{:?}, {:?}, {:?}]\n\
                 [[links]]\nname = \"a{k}\"\nbody = \"s{k}\"\nto = \"j\"\n",
                x.x, x.y, x.z
            )
        })
        .collect();
    let phases: String = [("a0", 4), ("a1", 4), ("a0", 6), ("a1", 6)]
        .map(|(joint, length)| format!("[[gait.phases]]\nlink = \"{joint}\"\nlength = {length}\n"))
        .concat();
    Scene::parse(&format!(
        "domain.kind = \"unbounded\"\nmodel = {{ kind = \"multipole\", tolerance = 1e-6 }}\n\
         gait.arms = \"{arms}\"\n\
         [[bodies]]\nname = \"j\"\nshape = \"point\"\nposition = [0, 0, 0]\n{bodies}{phases}"
    ))
    .unwrap()
}

fn check_star(directions: &[Vector3<f64>], arms: &str, net: [f64; 3], rotation: [f64; 3]) {
    let outcome = run(&star(directions, arms));
    let (net, rotation) = (Vector3::from(net), Vector3::from(rotation));
    let error = (outcome.displacement[0] - net).norm();
    assert!(
        error < 1e-7,
        "{arms}: {error:e}, {:?}",
        outcome.displacement[0]
    );
    let error = (outcome.rotation - rotation).norm();
    assert!(error < 1e-7, "{arms}: {error:e}, {:?}", outcome.rotation);
}

// Lefebvre-Lepot & Merlet (2009); collocation and a method of fundamental solutions agree to 1e-11.
#[test]
fn the_planar_swimmer_has_the_exact_displacement_and_rotation() {
    let directions = [0.0, 1.0, 2.0].map(|k| {
        let angle = k * std::f64::consts::TAU / 3.0;
        Vector3::new(angle.cos(), angle.sin(), 0.0)
    });
    check_star(
        &directions,
        "clamped",
        [0.004791832418980625, -0.0026805960395928506, 0.0],
        [0.0, 0.0, 0.027120360738385564],
    );
    check_star(
        &directions,
        "free",
        [0.004667202336353144, -0.002607693358089058, 0.0],
        [0.0, 0.0, 0.02815968765431789],
    );
    check_star(
        &directions,
        "lab",
        [0.007340621150791131, -0.004238109597428583, 0.0],
        [0.0, 0.0, 0.0],
    );
}

// Alouges et al. (2013); collocation and a method of fundamental solutions agree to 1e-11.
#[test]
fn the_tetrahedral_swimmer_has_the_exact_displacement_and_rotation() {
    let directions = [
        (1.0, 1.0, 1.0),
        (1.0, -1.0, -1.0),
        (-1.0, 1.0, -1.0),
        (-1.0, -1.0, 1.0),
    ]
    .map(|(x, y, z)| Vector3::new(x, y, z) / 3.0_f64.sqrt());
    check_star(
        &directions,
        "clamped",
        [
            7.608613702185518e-05,
            0.0045765204228767975,
            0.004576520422876715,
        ],
        [0.0, 0.016624558666787786, -0.016624558666787737],
    );
    check_star(
        &directions,
        "free",
        [
            7.758427939318449e-05,
            0.0044049086287823325,
            0.004404908628781979,
        ],
        [0.0, 0.017612231013913925, -0.01761223101391386],
    );
    check_star(
        &directions,
        "lab",
        [0.0, 0.006762950325282432, 0.0067629503252824175],
        [0.0, 0.0, 0.0],
    );
}

#[test]
fn templates_have_the_documented_displacements() {
    for (text, body, net) in [
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
        (
            include_str!("../../templates/scallop.toml"),
            1,
            [0.0, 0.0, 0.0],
        ),
    ] {
        let scene = Scene::parse(text).unwrap();
        let found = run(&scene).displacement[body];
        let exact = Vector3::from(net);
        // The tolerance applies to the mean of the bodies, about which the junction rotates.
        let tolerance = 2.0 * scene.model().tolerance * exact.norm();
        assert!((found - exact).norm() < tolerance + 1e-7, "{found} {exact}");
    }
    let chain = run(&Scene::parse(include_str!("../../templates/chain.toml")).unwrap());
    assert!(chain.net() > 0.01);
}
