//! Surfaces that deform through frames, against spheres that breathe and rigid rotations.

use std::f64::consts::PI;
use std::fmt::Write as _;
use std::path::Path;

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use swimmer::{Outcome, Scene};
use testkit::{boxed, contains, run, solve_at, within};

use crate::deformation_properties::{check_instant, check_scallop, turns};

/// A sphere as an OBJ file: the faces of the octahedron, with `n` triangles per edge, moved.
fn write_obj(path: &Path, n: i32, moved: impl Fn(Vector3<f64>) -> Vector3<f64>) {
    let (mut points, mut faces) = (Vec::<[i32; 3]>::new(), String::new());
    let mut text = String::new();
    let mut vertex = |at: [i32; 3]| {
        let found = points.iter().position(|known| *known == at);
        1 + found.unwrap_or_else(|| {
            let x = moved(Vector3::from(at.map(f64::from)).normalize());
            writeln!(text, "v {:?} {:?} {:?}", x.x, x.y, x.z).unwrap();
            points.push(at);
            points.len() - 1
        })
    };
    for octant in 0..8 {
        let signs = [0, 1, 2].map(|axis| 1 - 2 * (octant >> axis & 1));
        let mut add = |corners: [[i32; 2]; 3]| {
            let mut face =
                corners.map(|[a, b]| vertex([signs[0] * a, signs[1] * b, signs[2] * (n - a - b)]));
            if signs.iter().product::<i32>() < 0 {
                face.swap(1, 2);
            }
            writeln!(faces, "f {} {} {}", face[0], face[1], face[2]).unwrap();
        };
        for i in 0..n {
            for j in 0..n - i {
                add([[i, j], [i + 1, j], [i, j + 1]]);
                if i + j + 2 <= n {
                    add([[i + 1, j], [i + 1, j + 1], [i, j + 1]]);
                }
            }
        }
    }
    std::fs::write(path, text + &faces).unwrap();
}

/// A folder with frames, and the keys of a body with their surfaces.
struct Frames {
    folder: tempfile::TempDir,
    count: usize,
}

impl Frames {
    fn new(n: i32, frames: &[&dyn Fn(Vector3<f64>) -> Vector3<f64>]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (k, frame) in frames.iter().enumerate() {
            write_obj(&folder.path().join(format!("{k}.obj")), n, frame);
        }
        Self {
            folder,
            count: frames.len(),
        }
    }

    fn path(&self, k: usize) -> String {
        self.folder
            .path()
            .join(format!("{k}.obj"))
            .display()
            .to_string()
    }

    /// The keys of a body, without name and position.
    fn keys(&self, keys: &str) -> String {
        let others: Vec<String> = (1..self.count)
            .map(|k| format!("{:?}", self.path(k)))
            .collect();
        format!(
            "shape = \"surface\"\nfile = {:?}\ncentre = [0, 0, 0]\n\
             deformation = {{ kind = \"frames\", files = [{}], {keys} }}",
            self.path(0),
            others.join(", "),
        )
    }
}

/// A sphere at `q` radii, by frames at 1, 1.2 and 1.6: positions are linear in `q`.
fn breathing(n: i32) -> Frames {
    Frames::new(n, &[&|x| x, &|x| 1.2 * x, &|x| 1.6 * x])
}

/// A breathing body beside a sphere that drifts in its flow.
fn with_drifter(body: &str, settings: &str, size: f64) -> Scene {
    let text = format!(
        r#"
        fem.surface_size = {size}
        {settings}
        [[bodies]]
        name = "ball"
        position = [0, 0, 0]
        {body}
        [[bodies]]
        name = "drifter"
        radius = 0.8
        position = [0, 3, 1]
        "#
    );
    Scene::parse(&text).unwrap()
}

/// What flat faces leave out of a sphere is what the file tells: the drag of the faces is that of a
/// sphere of their size, to first order in the difference of both.
#[test]
fn the_drag_of_facets_is_that_of_their_size() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.obj");
    write_obj(&path, 4, |x| x);
    let scene = |kind: &str| {
        let text = format!(
            "model.kind = \"fem\"\n[[bodies]]\nname = \"ball\"\nshape = \"surface\"\n\
             file = {:?}\nsurface_kind = \"{kind}\"\nposition = [0, 0, 0]\nforce = [1, 0, 0]",
            path.display().to_string()
        );
        Scene::parse(&text).unwrap()
    };
    assert!(scene("smooth").facet_errors().is_empty());
    let scene = scene("faceted");
    let [(0, error)] = scene.facet_errors()[..] else {
        panic!("{:?}", scene.facet_errors());
    };
    let solution = testkit::start(&scene);
    let (speed, bar) = (
        solution.bodies[0].velocity.x,
        solution.error_estimate.total(),
    );
    let radius = 1.0 / (6.0 * PI * speed);
    within(
        radius - 1.0 - error,
        bar / speed + 0.1 * error.abs(),
        "the error bar, and the differences of second order",
    );
    within(bar / speed, 0.3 * error.abs(), "the bar says something");
}

/// Frames of a sphere of several radii have the flow of the breathing sphere: within the bars for
/// curved triangles, with an error of second order for flat ones, by the flux through them.
#[test]
fn frames_of_spheres_breathe() {
    let exact = "radius = 1\ndeformation = { kind = \"radius\" }";
    let sphere = with_drifter(
        exact,
        "model = { kind = \"multipole\", tolerance = 1e-6 }",
        0.35,
    );
    let (radius, rate) = (1.3, [1.0]);
    let expected = solve_at(boxed(&sphere).as_mut(), &[radius], &rate);
    let keys = "at = [1, 1.2, 1.6]";
    let solve = |n: i32, kind: &str| {
        let frames = breathing(n);
        let body = format!("{}\nsurface_kind = \"{kind}\"", frames.keys(keys));
        let scene = with_drifter(&body, "model = { kind = \"fem\", tolerance = 0.1 }", 0.45);
        let found = solve_at(boxed(&scene).as_mut(), &[radius], &rate);
        let body = &scene.bodies()[0].deformation;
        (found, body.as_ref().unwrap().volume_rate(&[radius], 0))
    };
    let (smooth, flux) = solve(4, "smooth");
    let sphere_flux = 4.0 * PI * radius * radius;
    // Point-normal triangles of edges of 0.5 radii have the volume of the sphere to h^4 / 10.
    let triangles = 6e-3;
    within(flux / sphere_flux - 1.0, triangles, "curved triangles");
    for (found, expected) in smooth.bodies.iter().zip(&expected.bodies) {
        let error = (found.velocity - expected.velocity).norm();
        let bar = smooth.error_estimate.total() + triangles * expected.velocity.norm();
        within(error, bar, "the bar and the triangles");
    }
    let drift = expected.bodies[1].velocity;
    within(
        smooth.error_estimate.total(),
        0.05 * drift.norm(),
        "the bar says something",
    );
    within(
        smooth.power() / expected.power() - 1.0,
        0.01 + smooth.power_error.total() / expected.power(),
        "the bar and the triangles",
    );
    // The volume of the polyhedron is that of the sphere to second order.
    let [coarse, fine] = [2, 4].map(|n| solve(n, "faceted"));
    let defects = [&coarse, &fine].map(|(_, flux)| 1.0 - flux / sphere_flux);
    let order = (defects[0] / defects[1]).log2();
    assert!((1.7..2.1).contains(&order), "{order}");
    // The drifter follows the flux of the source to first order in its distance.
    for ((found, _), defect) in [(coarse, defects[0]), (fine, defects[1])] {
        let ratio = found.bodies[1].velocity.dot(&drift) / drift.norm_squared();
        let allowed = 0.3 * defect + found.error_estimate.total() / drift.norm();
        within(ratio - (1.0 - defect), allowed, "the flux of the source");
    }
}

/// Frames that rotate do not move in space: the body turns back, whatever its shape, and does no
/// work. The spline of 9 frames over 0.8 radians has an error of (h^4 / 384) q'''' at most.
#[test]
fn frames_of_a_rotation_are_a_rotation_of_the_body() {
    let ellipsoid = |x: Vector3<f64>| x.component_mul(&Vector3::new(1.5, 1.0, 0.7));
    let axis = nalgebra::Unit::new_normalize(Vector3::new(1.0, 2.0, -1.0));
    let frame = |k: usize| {
        let turn = Rotation3::from_axis_angle(&axis, 0.1 * k as f64);
        move |x: Vector3<f64>| turn * ellipsoid(x)
    };
    let frames: Vec<_> = (0..9).map(frame).collect();
    let frames: Vec<&dyn Fn(Vector3<f64>) -> Vector3<f64>> = frames
        .iter()
        .map(|frame| frame as &dyn Fn(_) -> _)
        .collect();
    let frames = Frames::new(4, &frames);
    let at: Vec<f64> = (0..9).map(|k| 0.1 * f64::from(k)).collect();
    let text = format!(
        "fem.surface_size = 0.5\nmodel.tolerance = 0.1\n[[bodies]]\nname = \"a\"\nposition = [0, 0, 0]\n{}",
        frames.keys(&format!("at = {at:?}, frame = 0.4"))
    );
    let scene = Scene::parse(&text).unwrap();
    let found = solve_at(boxed(&scene).as_mut(), &[0.43], &[1.0]);
    let spin = found.bodies[0].angular_velocity;
    // The velocity of a natural spline has the relative error h^3 / 24 and that of its ends.
    let spline = 1e-3;
    within(
        (spin + axis.into_inner()).norm(),
        spline + found.angular_velocity_error.total(),
        "spin",
    );
    within(
        found.bodies[0].velocity.norm(),
        spline + found.error_estimate.total(),
        "at rest",
    );
    within(
        found.power(),
        20.0 * spline * spline + found.power_error.total(),
        "no work",
    );
}

fn stroke(body: &str, settings: &str, targets: &[f64]) -> Outcome {
    let phases: String = (targets.iter())
        .map(|q| format!("[[gait.phases]]\ntargets = {{ \"ball.frame\" = {q} }}\n"))
        .collect();
    let scene = with_drifter(body, settings, 0.6).to_toml().unwrap();
    run(&Scene::parse(&(scene + &phases)).unwrap())
}

/// One coordinate leads nowhere.
#[test]
fn strokes_of_frames_lead_nowhere() {
    let frames = Frames::new(
        3,
        &[&|x| x, &|x| x.component_mul(&Vector3::new(1.4, 1.0, 0.9))],
    );
    let settings = "model = { kind = \"fem\", tolerance = 0.5 }";
    let outcome = stroke(&frames.keys(""), settings, &[1.0, 0.0]);
    let largest = outcome.spans[0].displacement[1].norm();
    let net = outcome
        .displacement
        .iter()
        .map(|d| d.norm())
        .fold(0.0, f64::max);
    assert!(largest > 1e-3, "{largest}");
    within(net, outcome.error_estimate.total(), "the bar");
    within(net, 0.1 * largest, "a small part of the stroke");
}

/// The motion of a path that is run backwards is the reverse.
#[test]
fn frames_run_backwards_undo_their_motion() {
    let bend = |x: Vector3<f64>| Vector3::new(1.2 * x.x, x.y + 0.2 * x.x * x.x, 0.9 * x.z);
    let frames = Frames::new(5, &[&|x| x, &bend]);
    let body = frames.keys("");
    let scene = with_drifter(&body, "model = { kind = \"fem\", tolerance = 0.1 }", 0.6);
    let [forth, back] = [1.0, -1.0].map(|rate| solve_at(boxed(&scene).as_mut(), &[0.4], &[rate]));
    for (forth, back) in forth.bodies.iter().zip(&back.bodies) {
        // Rounding, and the residual of the solver.
        let sum = (forth.velocity + back.velocity).norm();
        within(sum, 1e-6 * forth.velocity.norm(), "linear in the rate");
    }
}

/// In a ball a kept volume is enough, and without it the gait is refused with the excess.
#[test]
fn frames_in_a_ball_keep_their_volume() {
    let stretch = |x: Vector3<f64>| x.component_mul(&Vector3::new(1.4, 0.9, 0.9));
    let frames = Frames::new(3, &[&|x| x, &stretch]);
    let text = |keys: &str| {
        format!(
            "domain = {{ kind = \"ball\", radius = 4 }}\nmodel.tolerance = 0.5\n\
             fem.surface_size = 0.5\n[[bodies]]\nname = \"a\"\nposition = [0.5, 0, 0.3]\n{}\n\
             [[gait.phases]]\ntargets = {{ \"a.frame\" = 1 }}",
            frames.keys(keys)
        )
    };
    let refused = Scene::parse(&text("frame = 0")).unwrap_err().to_string();
    contains(
        "refusal",
        &refused,
        &["grows at the rate", "keep_volume = true", "phase 1"],
    );
    let scene = Scene::parse(&text("keep_volume = true")).unwrap();
    let deformation = scene.bodies()[0].deformation.as_ref().unwrap();
    let surface = |q: f64| deformation.surface(&[q], &nalgebra::Isometry3::identity(), 1.0);
    let volumes = [0.0, 0.37, 1.0].map(|q| surface(q).unwrap().volume());
    within(volumes[1] / volumes[0] - 1.0, 1e-13, "rounding");
    within(volumes[2] / volumes[0] - 1.0, 1e-13, "rounding");
    let outcome = run(&scene);
    assert!(outcome.displacement[0].norm() > 1e-4);
}

/// Frames of a sphere of several radii in a fluid of Carreau have the flow of the sphere that
/// breathes in it, which is not that in a Newtonian fluid.
#[test]
#[ignore = "slow: 20 s"]
fn frames_of_spheres_breathe_in_a_fluid_of_carreau() {
    let (radius, rate) = (1.3, [1.0]);
    let model = "model = { kind = \"fem\", tolerance = 0.1 }";
    let law = "fluid = { law = \"carreau\", zero_shear_viscosity = 1, relaxation_time = 1, \
               index = 0.4 }";
    let solve = |body: &str, law: &str| {
        let scene = with_drifter(body, &format!("{law}\n{model}"), 0.45);
        solve_at(boxed(&scene).as_mut(), &[radius], &rate)
    };
    let sphere = "radius = 1\ndeformation = { kind = \"radius\" }";
    let frames = breathing(4);
    let [found, expected] = [&frames.keys("at = [1, 1.2, 1.6]"), sphere].map(|b| solve(b, law));
    // Of curved triangles, as in a Newtonian fluid.
    let triangles = 6e-3;
    for (one, other) in found.bodies.iter().zip(&expected.bodies) {
        let error = (one.velocity - other.velocity).norm();
        let bars = found.error_estimate.total() + expected.error_estimate.total();
        let allowed = bars + triangles * other.velocity.norm();
        within(error, allowed, "the bars and the triangles");
    }
    let bars = found.power_error.total() + expected.power_error.total();
    within(
        found.power() / expected.power() - 1.0,
        0.01 + bars / expected.power(),
        "the bars and the triangles",
    );
    within(bars / expected.power(), 0.05, "the bars say something");
    let newtonian = solve(sphere, "");
    assert!(found.power() < 0.8 * newtonian.power());
}

/// The pushmepullyou of which one sphere has frames, with its volume as coordinate: the exact
/// displacement of two spheres.
#[test]
#[ignore = "slow: 60 s"]
fn a_pushmepullyou_of_frames() {
    const EXACT: f64 = -0.650163426803;
    let volumes: Vec<f64> = (0..5)
        .map(|k| 4.0 * PI / 3.0 * (1.0 + 0.25 * f64::from(k)))
        .collect();
    let radius = |k: usize| (volumes[k] / (4.0 * PI / 3.0)).cbrt();
    let frames: Vec<_> = (0..5)
        .map(|k| move |x: Vector3<f64>| radius(k) * x)
        .collect();
    let frames: Vec<&dyn Fn(Vector3<f64>) -> Vector3<f64>> = frames
        .iter()
        .map(|frame| frame as &dyn Fn(_) -> _)
        .collect();
    let frames = Frames::new(6, &frames);
    let (small, large) = (volumes[0], volumes[4]);
    let text = format!(
        r#"
        [[bodies]]
        name = "left"
        radius = 1
        position = [-2, 0, 0]
        [[bodies]]
        name = "right"
        position = [2, 0, 0]
        {keys}
        [[links]]
        name = "arm"
        body = "right"
        to = "left"
        [[gait.phases]]
        link = "arm"
        length = 8
        [[gait.phases]]
        targets = {{ "left.volume" = {large:?}, "right.frame" = {small:?} }}
        [[gait.phases]]
        link = "arm"
        length = 4
        [[gait.phases]]
        targets = {{ "left.volume" = {small:?}, "right.frame" = {large:?} }}
        "#,
        keys = frames.keys(&format!("at = {volumes:?}, frame = {large:?}")),
    );
    let outcome = run(&Scene::parse(&text).unwrap());
    let bar = outcome.error_estimate.total();
    // The triangles have the radius of the sphere to 1e-4, and the spline to 1e-4.
    within(
        outcome.displacement[0].x - EXACT,
        bar + 1e-3 * EXACT.abs(),
        "the bar",
    );
    within(bar, 0.02 * EXACT.abs(), "the bar says something");
}

/// Frames of the sphere with two modes that keep the volume, `r = (1 + 3 ε (P_2 cos t + P_3 sin
/// t))^(1/3)` with ε = 0.1, in a ball of five radii.
#[test]
#[ignore = "slow: 2 min"]
fn frames_of_two_modes_swim_as_the_modes_do() {
    const EXACT: f64 = -2.906719955e-3;
    const FRAMES: usize = 12;
    let shape = |k: usize| {
        let (sine, cosine) = (2.0 * PI * k as f64 / FRAMES as f64).sin_cos();
        move |n: Vector3<f64>| {
            let x = n.z;
            let modes = [1.5 * x * x - 0.5, 2.5 * x.powi(3) - 1.5 * x];
            (1.0 + 0.3 * (modes[0] * cosine + modes[1] * sine)).cbrt() * n
        }
    };
    let shapes: Vec<_> = (0..FRAMES).map(shape).collect();
    let shapes: Vec<&dyn Fn(Vector3<f64>) -> Vector3<f64>> = shapes
        .iter()
        .map(|shape| shape as &dyn Fn(_) -> _)
        .collect();
    let frames = Frames::new(12, &shapes);
    let text = format!(
        "domain = {{ kind = \"ball\", radius = 5 }}\nmodel.tolerance = 0.05\n[[bodies]]\n\
         name = \"a\"\nposition = [0, 0, 0]\n{}\n\
         [[gait.phases]]\ntargets = {{ \"a.frame\" = {FRAMES} }}",
        frames.keys("periodic = true, keep_volume = true")
    );
    let outcome = run(&Scene::parse(&text).unwrap());
    let found = outcome.displacement[0].z;
    println!("{found:e} +- {:e}", outcome.error_estimate.total());
    // The splines have the modes to (2 π / 12)^4 / 384 = 2e-4. Points between vertices move along
    // the surface too, by about f' h² / 4 at the edge h = π / 24 for the displacement f, with
    // f' = 3 f.
    let bar = outcome.error_estimate.total();
    let triangles = 2.0 * (PI / 24.0).powi(2);
    within(
        found - EXACT,
        bar + triangles * EXACT.abs(),
        "the bar and the triangles",
    );
    within(bar, 0.2 * EXACT.abs(), "the bar says something");
}

/// The scene of the book: eight frames of two modes with ε = 0.15 and edges of 0.3 radii. Its
/// displacement is that of second order, `(3 π / 35) ε²`, to the fourth power of ε and to `2 h²` by
/// its triangles; it swims against the side where P_3 is positive.
#[test]
#[ignore = "slow: 60 s"]
fn the_scene_of_frames_swims() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let scene = Scene::read(root.join("scenes/frames.toml"), &[]).unwrap();
    let outcome = run(&scene);
    let expected = -3.0 * PI / 35.0 * 0.15 * 0.15;
    let found = outcome.displacement[0];
    within(found.x / expected - 1.0, 0.25, "triangles and order");
    within(
        outcome.error_estimate.total() / found.x,
        0.03,
        "the bar says something",
    );
    within(
        found.yz().norm(),
        outcome.error_estimate.total(),
        "along its axis",
    );
}

/// A body of three frames, the second and third of which are bent and stretched at random, beside a
/// sphere, all turned.
fn random_frames(bends: &[[f64; 12]; 2], turn: &UnitQuaternion<f64>, gait: &str) -> Scene {
    let frame = |bend: Option<&[f64; 12]>| {
        let (turn, bend) = (*turn, bend.copied().unwrap_or_default());
        move |x: Vector3<f64>| {
            let stretch = Matrix3::identity() + Matrix3::from_column_slice(&bend[..9]);
            turn * (stretch * x + Vector3::from_column_slice(&bend[9..]) * x.x * x.y)
        }
    };
    let frames = [frame(None), frame(Some(&bends[0])), frame(Some(&bends[1]))];
    let frames = Frames::new(3, &[&frames[0], &frames[1], &frames[2]]);
    let other = turn * Vector3::new(0.5, 2.8, 0.3);
    let text = format!(
        "fem.surface_size = 0.6\nmodel = {{ kind = \"fem\", tolerance = 0.5 }}\n[[bodies]]\n\
         name = \"b\"\nposition = [0, 0, 0]\n{}\n[[bodies]]\nname = \"o\"\nradius = 0.7\n\
         position = [{:?}, {:?}, {:?}]\n{gait}",
        frames.keys(""),
        other.x,
        other.y,
        other.z,
    );
    Scene::parse(&text).unwrap()
}

/// Bends of two frames, which leave the surface in a ball of 1.6 radii.
fn bends() -> impl Strategy<Value = [[f64; 12]; 2]> {
    prop::array::uniform2(prop::array::uniform12(-0.15..0.15_f64))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4, ..ProptestConfig::default() })]

    #[test]
    #[ignore = "slow: 60 s"]
    fn frames_are_the_same_in_all_axes_and_reverse_with_their_rates(
        bends in bends(),
        turn in turns(),
        value in 0.1..1.9_f64,
        rate in -1.0..1.0_f64,
    ) {
        let scene = |turn: &UnitQuaternion<f64>| random_frames(&bends, turn, "");
        check_instant(&scene, turn, (&[value], &[rate]), "frames");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2, ..ProptestConfig::default() })]

    #[test]
    #[ignore = "slow: 90 s"]
    fn one_coordinate_of_frames_leads_nowhere(bends in bends(), slower in 0.3..6.0_f64) {
        let gait = format!(
            "[[gait.phases]]\ntargets = {{ \"b.frame\" = 1.7 }}\nduration = 1\n\
             [[gait.phases]]\ntargets = {{ \"b.frame\" = 0 }}\nduration = {slower:?}\n"
        );
        check_scallop(&random_frames(&bends, &UnitQuaternion::identity(), &gait), "frames");
    }
}
