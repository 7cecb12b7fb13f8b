//! Frames of surfaces, and motions of a program: what they are and what is refused.

use std::path::Path;
use std::sync::Arc;

use nalgebra::{Isometry3, Vector3};
use scene::{MaterialMotion, MaterialPoint, Scene, ShapeCoordinate};

const FACES: &str = "f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

/// An octahedron with these vertices on its axes.
fn octahedron(path: &Path, x: [f64; 2], y: [f64; 2], z: [f64; 2], faces: &str) {
    let axis = |k: usize, ends: [f64; 2]| {
        ends.map(|end| {
            let mut at = [0.0; 3];
            at[k] = end;
            format!("v {:?} {:?} {:?}\n", at[0], at[1], at[2])
        })
        .concat()
    };
    let text = axis(0, x) + &axis(1, y) + &axis(2, z) + faces;
    std::fs::write(path, text).unwrap();
}

const UNIT: [f64; 2] = [1.0, -1.0];

/// Frames: an octahedron, a longer one and a flatter one.
fn frames() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    octahedron(&path("0.obj"), UNIT, UNIT, UNIT, FACES);
    octahedron(&path("1.obj"), [1.5, -1.5], UNIT, UNIT, FACES);
    octahedron(&path("2.obj"), UNIT, UNIT, [0.7, -0.7], FACES);
    folder
}

fn scene(folder: &Path, deformation: &str, rest: &str) -> Result<Scene, String> {
    let text = format!(
        r#"
        [[bodies]]
        name = "a"
        shape = "surface"
        file = "0.obj"
        position = [0, 0, 0]
        deformation = {{ kind = "frames", {deformation} }}
        {rest}
        "#
    );
    let path = folder.join("scene.toml");
    std::fs::write(&path, text).unwrap();
    Scene::read(&path, &[]).map_err(|error| error.to_string())
}

/// The vertex of a scene's first body that is on the x axis in the first frame.
fn vertex(scene: &Scene, q: f64) -> Vector3<f64> {
    let deformation = scene.bodies()[0].deformation.as_ref().unwrap();
    let surface = deformation
        .surface(&[q], &Isometry3::identity(), 1.0)
        .unwrap();
    surface.triangulation().unwrap().points[0]
}

/// The natural spline through 1, 1.5, 1 has the values 1 + 3 u / 4 - u³ / 4 in its first interval,
/// the periodic one through 1, 1.5, 1 and again 1 is through all of them.
#[test]
fn vertices_move_along_splines() {
    let folder = frames();
    let natural = scene(folder.path(), "files = [\"1.obj\", \"2.obj\"]", "").unwrap();
    for q in [0.0, 0.3, 0.5, 1.0] {
        let expected = 1.0 + 0.75 * q - 0.25 * q * q * q;
        assert!((vertex(&natural, q).x - expected).abs() < 1e-14);
    }
    let keys = "files = [\"1.obj\", \"2.obj\"], periodic = true, at = [0, 1, 2, 4], frame = 0.5";
    let periodic = scene(folder.path(), keys, "").unwrap();
    assert_eq!(periodic.articulation().initial_shape(), [0.5]);
    for (q, expected) in [(0.0, 1.0), (1.0, 1.5), (2.0, 1.0), (4.0, 1.0)] {
        for turns in [-2.0, 0.0, 3.0] {
            assert!((vertex(&periodic, q + 4.0 * turns).x - expected).abs() < 1e-13);
        }
    }
    // Both ends join with two derivatives.
    let h = 1e-3;
    let x = |q: f64| vertex(&periodic, q).x;
    let second = |q: f64| (x(q + h) - 2.0 * x(q) + x(q - h)) / (h * h);
    assert!(
        (second(4.0 - h) - second(h)).abs() < 0.02,
        "{} {}",
        second(4.0 - h),
        second(h)
    );
    assert!(periodic.shape_changes(&[0.5], &[8.5]).is_empty());
    assert_eq!(periodic.shape_changes(&[0.5], &[5.5]), [(0, 1.0)]);
    // Written and read again it is the same.
    let text = periodic.to_toml().unwrap();
    let again = Scene::parse(&text).unwrap();
    assert_eq!(
        again.bodies()[0].deformation,
        periodic.bodies()[0].deformation
    );
}

#[test]
fn bad_frames_are_refused_with_file_number_and_remedy() {
    let folder = frames();
    let path = |name: &str| folder.path().join(name);
    let fewer = FACES.trim_end().rsplit_once('\n').unwrap().0.to_owned() + "\n";
    octahedron(&path("open.obj"), UNIT, UNIT, UNIT, &fewer);
    let turned = FACES.replace("f 1 3 5", "f 3 5 1");
    octahedron(&path("other.obj"), UNIT, UNIT, UNIT, &turned);
    octahedron(&path("inside.obj"), [-1.0, 1.0], UNIT, UNIT, FACES);
    // A bipyramid whose tip came through its base.
    octahedron(&path("folded.obj"), UNIT, UNIT, [-0.999, -1.0], FACES);
    std::fs::write(
        path("four.obj"),
        "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    )
    .unwrap();
    for (keys, parts) in [
        (
            "files = []",
            &["deformation.files has 0 files", "1 frames", "add files"][..],
        ),
        ("frame = 1", &["deformation.files is missing"]),
        (
            "files = [\"1.obj\"], periodic = true",
            &["for periodic = true 3", "add files"],
        ),
        (
            "files = [\"no.obj\"]",
            &["frame 2 (no.obj)", "No such file"],
        ),
        (
            "files = [\"1.obj\", \"open.obj\"]",
            &["frame 3 (open.obj)", "open.obj: triangle"],
        ),
        (
            "files = [\"four.obj\"]",
            &[
                "frame 2 (four.obj)",
                "has 4 triangles, and the first frame has 8",
                "one mesh",
            ],
        ),
        (
            "files = [\"other.obj\"]",
            &[
                "frame 2 (other.obj)",
                "triangle 1 has the vertices",
                "same order",
            ],
        ),
        (
            "files = [\"inside.obj\"]",
            &["frame 2 (inside.obj)", "inside out"],
        ),
        (
            "files = [\"folded.obj\"]",
            &["frame 2 (folded.obj)", "folded"],
        ),
        (
            "files = [\"1.obj\"], at = [0, 1, 2]",
            &["deformation.at has 3 values, and 2 are needed"],
        ),
        (
            "files = [\"1.obj\"], at = [1, 1]",
            &["must increase, and 1 follows 1"],
        ),
        (
            "files = [\"1.obj\"], waves = 2",
            &["deformation.waves does not belong to kind = \"frames\""],
        ),
        (
            "files = [\"1.obj\"], frame = 1.5",
            &[
                "impossible at the start",
                "has the value 1.5",
                "from 0 to 1",
                "periodic = true",
            ],
        ),
    ] {
        let error = scene(folder.path(), keys, "").expect_err(keys);
        for part in parts {
            assert!(error.contains(part), "{keys}: {part:?} is not in: {error}");
        }
    }
    let sphere = "[[bodies]]\nname = \"a\"\nradius = 1\nposition = [0, 0, 0]\n\
                  deformation = { kind = \"frames\", files = [\"a\"] }";
    let error = Scene::parse(sphere).unwrap_err().to_string();
    assert!(error.contains("use shape = \"surface\""), "{error}");
}

/// Two frames with flat tips close to each other: between them the splines bring the tips closer
/// still, at 0.5 to 1 % of the phase. Sixty-five samples of the phase were all of other shapes.
#[test]
fn bug_folds_between_the_samples_of_a_phase_were_accepted() {
    let folder = frames();
    let path = |name: &str| folder.path().join(name);
    octahedron(&path("flat.obj"), UNIT, UNIT, [0.21, -0.21], FACES);
    let gait = "[[gait.phases]]\ntargets = { \"a.frame\" = 1 }";
    let keys = |flat: &str| {
        // Six equal frames after them end the oscillation of the splines.
        let files = [flat, flat]
            .into_iter()
            .chain([&"0.obj"; 7].map(|name| &**name));
        let files: Vec<_> = files.map(|name| format!("\"{name}\"")).collect();
        let at: Vec<_> = (0..9).map(|k| (0.005 * f64::from(k)).to_string()).collect();
        format!(
            "files = [{}], at = [{}, 1]",
            files.join(", "),
            at.join(", ")
        )
    };
    assert!(scene(folder.path(), &keys("2.obj"), gait).is_ok());
    let error = scene(folder.path(), &keys("flat.obj"), gait).unwrap_err();
    for part in [
        "in phase 1 at 0.5 % of it",
        "is folded onto triangle",
        "near",
    ] {
        assert!(error.contains(part), "{error}");
    }
    for sample in 0..=64 {
        let at = format!(
            "{}, frame = {:?}",
            keys("flat.obj"),
            f64::from(sample) / 64.0
        );
        assert!(scene(folder.path(), &at, "").is_ok(), "{sample}");
    }
}

/// What the gait makes impossible is known before the run, with its phase.
#[test]
fn gaits_beyond_the_frames_are_refused() {
    let folder = frames();
    let gait = |q: f64| format!("[[gait.phases]]\ntargets = {{ \"a.frame\" = {q} }}");
    let keys = "files = [\"1.obj\", \"2.obj\"]";
    assert!(scene(folder.path(), keys, &gait(2.0)).is_ok());
    let error = scene(folder.path(), keys, &gait(2.4)).unwrap_err();
    for part in ["gait.phases[0]", "in phase 1 at 83.3 %", "from 0 to 2"] {
        assert!(error.contains(part), "{part}: {error}");
    }
    let error = scene(folder.path(), keys, &gait(2.0).replace("frame", "shape")).unwrap_err();
    assert!(
        error.contains("no shape coordinate of 'a', which has a.frame"),
        "{error}"
    );
    // Between two frames that are far apart the surface turns inside out.
    octahedron(
        &folder.path().join("back.obj"),
        [0.2, -3.0],
        [-1.0, 1.0],
        [-1.0, 1.0],
        FACES,
    );
    let error = scene(folder.path(), "files = [\"back.obj\"]", &gait(1.0)).unwrap_err();
    assert!(error.contains("is no body: surface: triangle"), "{error}");
}

/// A bend of the x axis by a program.
#[derive(Debug)]
struct Bend {
    speed: f64,
    factor: f64,
}

impl MaterialMotion for Bend {
    fn coordinates(&self) -> Vec<ShapeCoordinate> {
        vec![ShapeCoordinate {
            name: "bend".to_owned(),
            start: 0.1,
            period: None,
        }]
    }

    fn position(&self, point: &MaterialPoint, amplitudes: &[f64]) -> Vector3<f64> {
        let x = point.position;
        x + amplitudes[0].powi(2) * x.x * x.x * Vector3::z()
    }

    fn velocity(&self, point: &MaterialPoint, amplitudes: &[f64], _: usize) -> Vector3<f64> {
        self.factor * 2.0 * amplitudes[0] * point.position.x.powi(2) * Vector3::z()
    }

    fn largest_speed(&self, _: usize) -> f64 {
        self.speed
    }
}

#[test]
fn motions_of_a_program_are_built_and_checked() {
    let folder = frames();
    let file = folder.path().join("1.obj");
    let text = format!(
        "[[bodies]]\nname = \"a\"\nshape = \"surface\"\nfile = {:?}\nposition = [0, 0, 0]\n",
        file.display().to_string()
    );
    let shape = Scene::parse(&text).unwrap().bodies()[0].shape.clone();
    let build = |body: &str, speed: f64, factor: f64| {
        let builder = Scene::builder()
            .shaped("a", shape.clone(), [0.0; 3])
            .deformation(body, Arc::new(Bend { speed, factor }))
            .phase("a.bend", 0.3, 1.0)
            .phase("a.bend", 0.1, 1.0);
        builder.build().map_err(|error| error.to_string())
    };
    let scene = build("a", 2.0, 1.0).unwrap();
    assert_eq!(scene.articulation().initial_shape(), [0.1]);
    let deformation = scene.bodies()[0].deformation.as_ref().unwrap();
    let at = deformation.at(&[0.3]);
    // The material point of the vertex at x = 1.5.
    let x = Vector3::new(1.5, 0.0, 0.3 * 0.3 * 2.25);
    assert!((at.velocity(&x, 0).z - 2.0 * 0.3 * 2.25).abs() < 1e-10);
    let error = scene.to_toml().unwrap_err().to_string();
    assert!(error.contains("motion of a program"), "{error}");
    for (body, speed, factor, part) in [
        ("b", 2.0, 1.0, "no body: \"b\""),
        ("a", 2.0, 1.1, "contradicts itself"),
        ("a", 0.1, 1.0, "faster than its largest speed 0.1"),
        ("a", f64::NAN, 1.0, "give finite numbers"),
    ] {
        let error = build(body, speed, factor).unwrap_err();
        assert!(error.contains(part), "{part}: {error}");
    }
}
