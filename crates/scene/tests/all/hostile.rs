//! Numbers beyond sense in every key: refused with the key and its line, or a valid scene.

use scene::keys::{Kind, all, find};
use scene::{Domain, FemOptions, Gait, Phase, PointShape, Scene, Shape, closest_contact, spans};

/// Numbers that are refused in every key, except for zero where it is allowed.
const BEYOND: [&str; 8] = [
    "1e300", "-1e300", "1e-300", "-1e-300", "1e-320", "5e-324", "1e60", "1e-60",
];

/// Numbers that some keys allow.
const ODD: [&str; 9] = [
    "0", "-0.0", "-1", "1e40", "-1e40", "1e-40", "1e12", "1e-12", "7",
];

/// Scenes that together have every key with numbers; `; ` is the end of a line, an empty line that
/// of a scene.
const SCENES: &str = r#"
fluid.viscosity = 1; model.tolerance = 1e-3; model.tolerance_factor = 0.5
fem.rtol = 1e-8; fem.surface_size = 0.4
fem.size_factor = 1; fem.target = 1e-2; fem.subdomains = 8; fem.overlap = 1
output.samples = 100
[domain]; kind = "ball"; radius = 40
[[bodies]]; name = "left"; radius = 1; position = [-10, 0, 0]; force = [1, 0, 0]
torque = [1, 0, 0]; mass = 1; inertia = 1
[[bodies]]; name = "right"; radius = 1; position = [0, 0, 0]
[[links]]; name = "arm"; body = "left"; to = "right"
[gait]; cycles = 2
[[gait.phases]]; link = "arm"; length = 6; duration = 1
[optimise]; displacement = 0.1; rotation = 0.1; direction = [1, 0, 0]; axis = [0, 0, 1]
lower = 5; upper = { arm = 9 }; gap = 0.1; period = 1; power = 1; terms = 8
tolerance = 1e-3
[learn]; contracted = 6; extended = { arm = 10 }; direction = [1, 0, 0]; episodes = 10
steps = 10; discount = 0.9; rate = 0.5; exploration = 0.1; seed = 1

[[bodies]]; name = "left"; radius = 1; position = [-10, 0, 0]
[[copies]]; of = "left"; count = 3; size = [30, 20, 20]; centre = [1, 0, 0]; gap = 0.5; seed = 2
[[copies]]; of = "left"; positions = [[0, 40, 0]]; orientations = [[0, 1, 0]]

[domain]; kind = "box"; size = [30, 20, 20]
[[bodies]]; name = "spheroid"; shape = "spheroid"; radius = 1; half_length = 2
axis = [0, 0, 1]; position = [1, 0, 0]; force = [1, 0, 0]

[[bodies]]; name = "amoeba"; radius = 1; position = [1, 0, 0]
[bodies.deformation]; modes = { p = 2 }; axis = [0, 0, 1]

[[bodies]]; name = "wavy"; radius = 1; position = [1, 0, 0]
[bodies.deformation]; modes = { arm = 2 }; orders = { arm = 1 }; meridian = [0, 1, 0]

[[bodies]]; name = "worm"; shape = "tube"; length = 8; radius = 0.5; end_radius = 0.4
head_radius = 1; orientation = [0.1, 0.2, 0.3]; position = [1, 0, 0]
[bodies.deformation]; kind = "undulation"; waves = 1.5; amplitude = 0.5; phase = 0.3
[optimise]; waves = [0.5, 2]
[gait]; period = 2
[[gait.harmonics]]; link = "worm.phase"; turn = 6.283185307179586

[[bodies]]; name = "ellipsoid"; shape = "ellipsoid"; semi_axes = [3, 2, 1]
orientation = [0.1, 0.2, 0.3]; position = [1, 0, 0]
[[bodies]]; name = "helix"; shape = "helix"; radius = 1; tube_radius = 0.2; pitch = 2
turns = 3; position = [9, 0, 0]

[domain]; kind = "cylinder"; radius = 5
[[bodies]]; name = "ball"; radius = 1; position = [1, 0, 0]

[[bodies]]; name = "left"; radius = 1; position = [-10, 0, 0]
[[bodies]]; name = "right"; radius = 1; position = [0, 0, 0]
[[links]]; name = "arm"; body = "left"; to = "right"
[[gait.phases]]; targets = { arm = 6 }
[optimise]; objective = "speed"; max_rate = 0.5; max_power = 10; radii = [0.5, 2]
arms = [4, 20]

[[bodies]]; name = "left"; radius = 1; position = [-10, 0, 0]
[[bodies]]; name = "right"; radius = 1; position = [0, 0, 0]
[[links]]; name = "arm"; body = "left"; to = "right"
[gait]; period = 8
[[gait.harmonics]]; link = "arm"; mean = 9; amplitude = 2; phase = 0.5; order = 2

[[bodies]]; name = "left"; radius = 1; position = [-10, 0, 0]
[[bodies]]; name = "right"; radius = 1; position = [0, 0, 0]
[[bodies]]; name = "tail"; radius = 1; position = [10, 0, 0]
[[links]]; name = "screw"; body = "left"; to = "right"; joint = "screw"; axis = [0, 0, 1]
pivot = [1, 0, 0]; pitch = 2; drive = "spring"; stiffness = 1; rest = 1; damping = 1
[[links]]; name = "spring"; body = "tail"; to = "right"; drive = "force"; force = 1

gravity = [0, 0, -1]
[fluid]; density = 1
[background]; kind = "uniform"; velocity = [1, 0, 0]
[[bodies]]; name = "squirmer"; radius = 1; density = 2; position = [1, 0, 0]
[bodies.slip]; b1 = 1; b2 = 2; axis = [0, 0, 1]

[background]; kind = "pressure-gradient"; pressure_gradient = [0, 0, -1]
[domain]; kind = "periodic"; size = [8, 9, 10]
[[bodies]]; name = "a"; radius = 1; position = [1, 0, 0]; fixed = true

[background]; kind = "shear"; gradient = [[0, 1, 0], [0, 0, 0], [0, 0, 0]]
[[bodies]]; name = "a"; radius = 1; position = [1, 0, 0]

fluid.density = 1; fluid.inertia = "full"; fluid.time_step = 0.1
domain.kind = "ball"; domain.radius = 9
[[bodies]]; name = "heavy"; radius = 1; density = 2; position = [1, 0, 0]

fluid.thermal_energy = 0.1; fluid.seed = 3; fluid.time_step = 0.1
[[bodies]]; name = "colloid"; radius = 1; position = [1, 0, 0]

fluid.law = "carreau-yasuda"; fluid.zero_shear_viscosity = 1
fluid.infinite_shear_viscosity = 0.1; fluid.relaxation_time = 1; fluid.index = 0.5
fluid.transition = 2
[[bodies]]; name = "thinned"; radius = 1; position = [1, 0, 0]

fluid.law = "herschel-bulkley"; fluid.consistency = 1; fluid.index = 0.5
fluid.yield_stress = 0.1; fluid.regularisation = 1e-6
domain.kind = "ball"; domain.radius = 9
[[bodies]]; name = "mud"; radius = 1; position = [1, 0, 0]

[contact]; range = 0.1; strength = 1
[[bodies]]; name = "held"; radius = 1; position = [1, 0, 0]; velocity = [1, 0, 0]
angular_velocity = [0, 0, 1]
[[bodies]]; name = "free"; radius = 1; position = [9, 0, 0]

[field]; mean = [0, 0, 1]; amplitude = [1, 1, 0]; phase = [0, 0.5, 0]; order = 2; period = 3
[[bodies]]; name = "magnet"; radius = 1; position = [1, 0, 0]; moment = [1, 0, 0]

[domain]; kind = "surface"; file = "tests/all/tetrahedron.obj"; scale = 100
[[bodies]]; name = "part"; shape = "surface"; file = "tests/all/tetrahedron.obj"; scale = 1
centre = [1, 1, 1]; position = [50, 50, 50]

[[bodies]]; name = "frames"; shape = "surface"; file = "tests/all/tetrahedron.obj"
position = [0, 0, 0]
[bodies.deformation]; kind = "frames"; files = ["tests/all/tetrahedron.obj"]; at = [0, 20]
frame = 0.7
"#;

/// The texts in which one number is replaced, with the line, the key and the number.
fn changed() -> impl Iterator<Item = (String, usize, &'static str, &'static str)> {
    let scenes = SCENES
        .trim()
        .split("\n\n")
        .map(|scene| scene.replace("; ", "\n"));
    let lines = scenes.flat_map(|text| {
        let mut group = String::new();
        let mut numbers = Vec::new();
        for (number, line) in text.lines().enumerate() {
            if line.starts_with('[') {
                group = line.trim_matches(['[', ']']).to_owned();
                continue;
            }
            let (name, value) = line.split_once(" = ").expect("a key and its value");
            let path = match group.as_str() {
                "" => name.to_owned(),
                "bodies" | "links" | "copies" | "gait.phases" | "gait.harmonics" => {
                    format!("{group}[].{name}")
                }
                "bodies.slip" => format!("bodies[].slip.{name}"),
                "bodies.deformation" => format!("bodies[].deformation.{name}"),
                group => format!("{group}.{name}"),
            };
            let key = find(&path).expect("a key");
            let is_text = matches!(key.kind, Kind::Text | Kind::Texts | Kind::Word(_));
            if !is_text && key.kind != Kind::Flag {
                let [name, value] = [name, value].map(str::to_owned);
                numbers.push((text.clone(), number, name, value, key.path));
            }
        }
        numbers
    });
    lines.flat_map(|(text, number, name, value, path)| {
        BEYOND.into_iter().chain(ODD).map(move |hostile| {
            let value = match value.as_bytes()[0] {
                b'[' if value.starts_with("[[") => {
                    format!("[[0, {hostile}, 0], [0, 0, 0], [0, 0, 0]]")
                }
                // another end of a range each time
                b'[' if value.matches(',').count() == 1 => match hostile.len() % 2 == 0 {
                    true => format!("[0.5, {hostile}]"),
                    false => format!("[{hostile}, 20]"),
                },
                // another component of a vector each time
                b'[' if hostile.len() % 2 == 0 => format!("[0, 0, {hostile}]"),
                b'[' => format!("[{hostile}, 0, 0]"),
                b'{' => format!("{{ arm = {hostile} }}"),
                _ => hostile.to_owned(),
            };
            let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
            lines[number] = format!("{name} = {value}");
            (lines.join("\n"), number + 1, path, hostile)
        })
    })
}

#[test]
fn numbers_beyond_sense_are_refused_with_key_and_line() {
    let mut accepted = 0;
    let mut keys = std::collections::BTreeSet::new();
    for (text, line, path, hostile) in changed() {
        keys.insert(path);
        let name = path.rsplit('.').next().expect("a name");
        let error = match Scene::parse(&text) {
            Ok(scene) => {
                accepted += 1;
                assert!(
                    !BEYOND.contains(&hostile),
                    "{path} = {hostile} was accepted"
                );
                // the scene reads back
                Scene::parse(&scene.to_toml().expect("text")).expect("the same scene");
                continue;
            }
            Err(error) => error,
        };
        let message = error.to_string();
        // Other numbers may be wrong together with those of another key, whose place is named then.
        let has_place = match BEYOND.contains(&hostile) {
            true => message.contains(&format!("scene.toml:{line}:")) && message.contains(name),
            false => message.contains("scene.toml:"),
        };
        assert!(has_place, "{path} = {hostile}: {message}");
    }
    // zero, negative and moderate numbers are right in some keys
    assert!(accepted > 60, "{accepted}");
    let numeric = all().filter(|key| {
        !matches!(
            key.kind,
            Kind::Text | Kind::Texts | Kind::Word(_) | Kind::Flag
        )
    });
    let missing: Vec<&str> = numeric
        .map(|key| key.path)
        .filter(|path| !keys.contains(path))
        .collect();
    assert_eq!(missing, [""; 0]);
}

/// The smallest body sets the unit: lengths up to 1e9 times its radius are computed with.
#[test]
fn lengths_are_limited_relative_to_the_smallest_body() {
    let scene = |radius: f64, domain: f64| {
        let builder = Scene::builder().ball(domain).sphere("a", radius, [0.0; 3]);
        builder
            .build()
            .map(|_| ())
            .map_err(|error| error.to_string())
    };
    for unit in [1e-40, 1.0, 1e40] {
        assert_eq!(scene(unit, 0.99e9 * unit), Ok(()));
        let refused = scene(unit, 1.01e9 * unit).expect_err("too large");
        assert!(refused.contains("domain.radius is too large"), "{refused}");
    }
}

#[test]
fn bug_a_phase_of_a_joint_that_does_not_exist_ended_the_program() {
    let gait = |joint, length, duration| Gait {
        cycles: 2,
        phases: vec![Phase {
            path: scene::ShapePath::Linear(vec![(joint, length)]),
            duration,
        }],
    };
    assert_eq!(
        spans(&gait(0, 6.0, 1.0), &[5.0])
            .map(Iterator::count)
            .unwrap(),
        2
    );
    for bad in [
        gait(5, 6.0, 1.0),
        gait(1, 6.0, 1.0),
        gait(usize::MAX, 6.0, 1.0),
    ] {
        assert!(spans(&bad, &[5.0]).is_err());
    }
    for number in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(spans(&gait(0, 6.0, number), &[5.0]).is_err());
    }
    // Angles may be zero or negative.
    for number in [f64::NAN, f64::INFINITY] {
        assert!(spans(&gait(0, number, 1.0), &[5.0]).is_err());
        assert!(spans(&gait(0, 6.0, 1.0), &[number]).is_err());
    }
}

fn two_spheres() -> Scene {
    let builder = Scene::builder().sphere("a", 1.0, [0.0; 3]);
    builder
        .sphere("b", 1.0, [5.0, 0.0, 0.0])
        .build()
        .expect("a scene")
}

#[test]
fn options_of_a_program_are_checked_as_those_of_a_file() {
    let scene = two_spheres();
    for x in [0.0, -1.0, 1e-320, 1e300, f64::NAN, f64::INFINITY] {
        assert!(scene.with_tolerance(x).is_err(), "{x}");
        assert!(scene.with_size_factor(Some(x)).is_err(), "{x}");
        for set in [
            |fem: &mut FemOptions, x| fem.rtol = x,
            |fem: &mut FemOptions, x| fem.target = Some(x),
            |fem: &mut FemOptions, x| fem.surface_size = Some(x),
        ] {
            let mut fem = FemOptions::default();
            set(&mut fem, x);
            assert!(scene.with_fem(fem).is_err(), "{x}");
        }
    }
    assert!(scene.with_cycles(0).is_err());
    let mut fem = FemOptions::default();
    fem.subdomains = 0;
    assert!(scene.with_fem(fem).is_err());
}

#[test]
fn contacts_of_bodies_without_a_place_touch() {
    let scene = two_spheres();
    let set = scene.articulation();
    let poses = set.place(&scene.initial_state(), &[]).expect("two bodies");
    let touches = |poses: &[_]| {
        let contact = closest_contact(scene.bodies(), &Domain::Unbounded, poses);
        contact.expect("two bodies").touches(1.0)
    };
    assert!(!touches(&poses) && touches(&poses[..1]) && touches(&[]));
    let mut lost = poses;
    lost[1].translation.vector.x = f64::NAN;
    assert!(touches(&lost));
}

/// Neither the fields of a scene nor those of its bodies can be changed: only copies can.
#[test]
fn copies_of_the_parts_of_a_scene_do_not_change_it() {
    let scene = two_spheres();
    let mut copy = scene.bodies()[0].clone();
    copy.shape = PointShape.into();
    copy.position.x = 4.9;
    assert_eq!(scene.bodies()[0].shape, Shape::sphere(1.0));
    assert_eq!(
        scene.articulation().initial_state().frames[0].translation.x,
        0.0
    );
}
