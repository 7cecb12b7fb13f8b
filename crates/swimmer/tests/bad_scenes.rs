//! Malformed scenes: each is refused with the place, the key and what to do, and with exit code 2.

use swimmer::Scene;

/// A scene that is right; cases replace a part of it.
const GOOD: &str = r#"[fluid]
viscosity = 1

[domain]
kind = "ball"
radius = 40

[[bodies]]
name = "left"
radius = 1
position = [-10, 0, 0]

[[bodies]]
name = "centre"
radius = 1
position = [0, 0, 0]

[[links]]
name = "arm"
body = "left"
to = "centre"

[gait]
cycles = 2

[[gait.phases]]
link = "arm"
length = 6
duration = 1

[[gait.phases]]
link = "arm"
length = 10
duration = 1

[model]
kind = "fem"
tolerance = 1e-3

[fem]
rtol = 1e-8
"#;

/// What to replace, what by, and what the message must contain.
const CASES: &[(&str, &str, &[&str])] = &[
    // Not TOML.
    (
        "viscosity = 1",
        "viscosity = ",
        &["scene.toml:2", "not valid TOML"],
    ),
    ("[fluid]", "[fluid", &["scene.toml:1", "not valid TOML"]),
    (
        "radius = 40",
        "radius = 40\nradius = 41",
        &["scene.toml:7", "duplicate key"],
    ),
    (
        "radius = 40",
        "radius = 4O",
        &["scene.toml:6", "not valid TOML"],
    ),
    ("[model]", "\u{0}", &["not valid TOML"]),
    // Unknown keys.
    (
        "viscosity",
        "viscocity",
        &[
            "scene.toml:2",
            "'fluid.viscocity'",
            "did you mean 'fluid.viscosity'?",
        ],
    ),
    (
        "[fluid]",
        "[fluids]",
        &["scene.toml:1", "did you mean 'fluid'?"],
    ),
    (
        "cycles",
        "cycle",
        &["scene.toml:24", "did you mean 'gait.cycles'?"],
    ),
    (
        "radius = 40",
        "temperature = 3\nradius = 40",
        &["scene.toml:6", "domain has kind, radius, size, file, walls"],
    ),
    (
        "[fem]",
        "rtol = 1e-3\n[fem]",
        &["'model.rtol'", "did you mean 'fem.rtol'?"],
    ),
    (
        "kind = \"fem\"",
        "kind.fem = 1",
        &[
            "scene.toml:37",
            "model.kind must be one of auto, oseen",
            "not a table",
        ],
    ),
    (
        "name = \"arm\"",
        "name = \"arm\"\nlenght = 3",
        &["scene.toml:20", "'links[0].lenght'", "has name, body, to"],
    ),
    // Wrong types.
    (
        "viscosity = 1",
        "viscosity = \"1\"",
        &[
            "scene.toml:2",
            "fluid.viscosity must be a number greater than zero",
            "the text \"1\"",
        ],
    ),
    (
        "position = [0, 0, 0]",
        "position = [0, 0]",
        &["scene.toml:16", "bodies[1].position must be three numbers"],
    ),
    (
        "position = [0, 0, 0]",
        "position = [0, nan, 0]",
        &["scene.toml:16", "bodies[1].position must be three numbers"],
    ),
    (
        "position = [0, 0, 0]",
        "position = [0, 0, \"a\"]",
        &["bodies[1].position must be three numbers"],
    ),
    (
        "cycles = 2",
        "cycles = 2.5",
        &["scene.toml:24", "gait.cycles must be a whole number", "2.5"],
    ),
    (
        "cycles = 2",
        "cycles = 0",
        &["gait.cycles must be a whole number of at least 1"],
    ),
    (
        "cycles = 2",
        "cycles = 99999999999",
        &["gait.cycles must be a whole number"],
    ),
    (
        "[gait]\ncycles = 2",
        "[gait]\ncycles = true",
        &["gait.cycles must be a whole number", "true"],
    ),
    (
        "[fluid]\nviscosity = 1",
        "fluid = 3",
        &["scene.toml:1", "fluid must be a table, written as [fluid]"],
    ),
    (
        "[[links]]",
        "[links]",
        &[
            "scene.toml:18",
            "links must be a list of tables, written as [[links]]",
        ],
    ),
    (
        "name = \"left\"",
        "name = \"\"",
        &[
            "scene.toml:9",
            "bodies[0].name must be a text that is not empty",
        ],
    ),
    (
        "name = \"left\"",
        "name = 7",
        &["bodies[0].name must be a text"],
    ),
    // Numbers out of range.
    (
        "viscosity = 1",
        "viscosity = 0",
        &["fluid.viscosity must be a number greater than zero, not 0"],
    ),
    (
        "viscosity = 1",
        "viscosity = -2.5",
        &["fluid.viscosity", "not -2.5"],
    ),
    (
        "viscosity = 1",
        "viscosity = nan",
        &["fluid.viscosity", "not nan"],
    ),
    (
        "viscosity = 1",
        "viscosity = inf",
        &["fluid.viscosity", "not inf"],
    ),
    (
        "radius = 40",
        "radius = -40",
        &[
            "scene.toml:6",
            "domain.radius must be a number greater than zero",
        ],
    ),
    (
        "radius = 1\nposition = [0",
        "radius = 0\nposition = [0",
        &["scene.toml:15", "bodies[1].radius"],
    ),
    (
        "duration = 1\n\n[model]",
        "duration = 0\n\n[model]",
        &["gait.phases[1].duration"],
    ),
    (
        "length = 6",
        "length = -6",
        &["scene.toml:28", "gait.phases[0].length"],
    ),
    (
        "tolerance = 1e-3",
        "tolerance = 2",
        &["model.tolerance must be below 1"],
    ),
    (
        "rtol = 1e-8",
        "rtol = 1e-30",
        &["scene.toml:41", "fem.rtol", "at least 1e-14"],
    ),
    (
        "[fem]\nrtol = 1e-8",
        "[fem]\nsurface_size = -1",
        &["fem.surface_size"],
    ),
    // Words.
    (
        "kind = \"ball\"",
        "kind = \"bal\"",
        &[
            "scene.toml:5",
            "domain.kind cannot be \"bal\"; did you mean \"ball\"?",
        ],
    ),
    (
        "kind = \"fem\"",
        "kind = \"magic\"",
        &["model.kind cannot be \"magic\"; it is one of auto, oseen, rpy"],
    ),
    (
        "cycles = 2",
        "arms = \"clampd\"",
        &["did you mean \"clamped\"?"],
    ),
    (
        "radius = 1\nposition = [-10",
        "shape = \"cube\"\nradius = 1\nposition = [-10",
        &["bodies[0].shape cannot be \"cube\""],
    ),
    // Missing things.
    (
        "radius = 1\nposition = [0",
        "position = [0",
        &[
            "scene.toml:13",
            "bodies[1].radius is missing: a sphere needs a radius",
        ],
    ),
    (
        "position = [0, 0, 0]",
        "",
        &["bodies[1].position is missing"],
    ),
    ("name = \"centre\"", "", &["bodies[1].name is missing"]),
    (
        "radius = 40",
        "",
        &[
            "scene.toml:4",
            "domain.radius is missing: a ball needs a radius",
        ],
    ),
    ("kind = \"ball\"", "", &["domain.kind is missing"]),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"box\"",
        &["domain.size is missing"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"",
        &["domain.file is missing"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"no/such.msh\"",
        &["scene.toml:6", "domain.file cannot be read: no/such.msh"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"src\"\nwalls = [\"outer\"]",
        &["domain.file names src, which is not a file"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"Cargo.toml\"",
        &["domain.walls is missing"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"Cargo.toml\"\nwalls = []",
        &["domain.walls is empty"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"mesh\"\nfile = \"Cargo.toml\"\nwalls = [\"outer\"]",
        &["bodies[0].surface is missing"],
    ),
    ("length = 6\n", "", &["gait.phases[0].length is missing"]),
    (
        "link = \"arm\"\nlength = 6",
        "length = 6",
        &["gait.phases[0].link is missing"],
    ),
    // Names.
    (
        "name = \"centre\"",
        "name = \"left\"",
        &["scene.toml:14", "\"left\" is the name of bodies[0] too"],
    ),
    (
        "[gait]",
        "[[links]]\nname = \"arm\"\nbody = \"centre\"\nto = \"left\"\n[gait]",
        &["\"arm\" is the name of links[0] too"],
    ),
    (
        "[gait]",
        "[[links]]\nname = \"arm-2\"\nbody = \"centre\"\nto = \"left\"\n[gait]",
        &["links[1]", "a second time"],
    ),
    (
        "to = \"centre\"",
        "to = \"center\"",
        &[
            "scene.toml:21",
            "links[0].to names no body: \"center\"; did you mean \"centre\"?",
        ],
    ),
    (
        "to = \"centre\"",
        "to = \"moon\"",
        &["names no body: \"moon\"; there are left, centre"],
    ),
    (
        "to = \"centre\"",
        "to = \"left\"",
        &["scene.toml:21", "links body 'left' to itself"],
    ),
    (
        "link = \"arm\"\nlength = 6",
        "link = \"amr\"\nlength = 6",
        &[
            "scene.toml:27",
            "names no link: \"amr\"; did you mean \"arm\"?",
        ],
    ),
    // Geometry.
    (
        "position = [-10, 0, 0]",
        "position = [0, 0, 0]",
        &["links[0] has no direction", "at the same place"],
    ),
    (
        "position = [-10, 0, 0]",
        "position = [-1.5, 0, 0]",
        &["'left' and 'centre' touch or overlap at the start: gap -0.5"],
    ),
    (
        "position = [-10, 0, 0]",
        "position = [-2, 0, 0]",
        &["touch or overlap at the start: gap 0"],
    ),
    (
        "position = [-10, 0, 0]",
        "position = [-39, 0, 0]",
        &[
            "scene.toml:11",
            "'left' is outside the domain",
            "clearance 0",
        ],
    ),
    (
        "position = [-10, 0, 0]",
        "position = [-90, 0, 0]",
        &["'left' is outside the domain", "clearance -51"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"box\"\nsize = [19, 40, 40]",
        &["'left' is outside the domain", "clearance -1.5"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"wall\"",
        &["is outside the domain", "clearance -1"],
    ),
    (
        "kind = \"ball\"\nradius = 40",
        "kind = \"cylinder\"\nradius = 1",
        &["is outside the domain", "clearance 0"],
    ),
    (
        "length = 6",
        "length = 1.5",
        &[
            "scene.toml:28",
            "touch or overlap in phase 1 at 100 %",
            "gap -0.5",
        ],
    ),
    (
        "length = 6",
        "length = 2",
        &["touch or overlap in phase 1", "gap 0"],
    ),
    // Points.
    (
        "radius = 1\nposition = [0",
        "shape = \"point\"\nradius = 1\nposition = [0",
        &["bodies[1].radius makes no sense for a point"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"point\"\ntorque = [1, 0, 0]\nposition = [0",
        &["bodies[1].torque cannot act on a point"],
    ),
    (
        "[gait]",
        "[[bodies]]\nname = \"p\"\nshape = \"point\"\nposition = [5, 0, 0]\n[gait]",
        &["bodies[2] is a point that no link holds"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"spheroid\"\nradius = 1\nposition = [0",
        &["scene.toml:", "bodies[1].half_length is missing"],
    ),
    (
        "radius = 1\nposition = [0",
        "shape = \"spheroid\"\nradius = 1\nhalf_length = 2\naxis = [0, 0, 0]\nposition = [0",
        &["bodies[1].axis must not be zero"],
    ),
    (
        "radius = 1\nposition = [0",
        "half_length = 2\nradius = 1\nposition = [0",
        &["bodies[1].half_length belongs to shape = \"spheroid\""],
    ),
];

#[test]
fn the_good_scene_is_good() {
    Scene::parse(GOOD).unwrap();
}

#[test]
fn nesting_without_end_is_refused() {
    for open in ["[", "{a=", "[{a="] {
        let text = format!("{GOOD}\nx = {}", open.repeat(50_000));
        let error = Scene::parse(&text).unwrap_err();
        assert!(error.to_string().len() < 1000);
        assert_eq!(swimmer::SwimError::from(error).exit_code(), 2);
    }
}

#[test]
fn malformed_scenes_are_refused_with_place_and_remedy() {
    for (part, by, fragments) in CASES {
        assert!(GOOD.contains(part), "no such part: {part}");
        let text = GOOD.replacen(part, by, 1);
        let error = Scene::parse(&text).expect_err(&format!("accepted: {by}"));
        let message = error.to_string();
        for fragment in *fragments {
            assert!(
                message.contains(fragment),
                "for {by:?}: {fragment:?} is not in: {message}"
            );
        }
        assert!(!message.contains('\n'), "more than one line: {message}");
        assert_eq!(swimmer::SwimError::from(error).exit_code(), 2, "{message}");
    }
}

#[test]
fn scenes_without_bodies_or_phases_are_refused() {
    for (text, fragment) in [
        ("", "bodies is empty"),
        ("bodies = []", "bodies is empty"),
        ("[fluid]", "bodies is empty"),
        ("bodies = 3", "bodies must be a list of tables"),
        ("bodies = [3]", "bodies must be a list of tables"),
        (
            "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }]\ngait.phases = []",
            "gait.phases is empty",
        ),
        ("\u{feff}\u{feff}", "not valid TOML"),
    ] {
        let error = Scene::parse(text).expect_err(text);
        assert!(error.to_string().contains(fragment), "{text}: {error}");
        assert_eq!(swimmer::SwimError::from(error).exit_code(), 2);
    }
}

#[test]
fn a_second_cycle_that_starts_closer_is_checked_too() {
    let chain = GOOD
        .replace(
            "[gait]",
            "[[bodies]]\nname = \"right\"\nradius = 1\nposition = [-4, 0, 0]\n\
            [[links]]\nname = \"b\"\nbody = \"right\"\nto = \"centre\"\n[gait]",
        )
        .replace("length = 6", "length = 6.5")
        .replace(
            "[model]",
            "[[gait.phases]]\nlink = \"b\"\nlength = 6\n[model]",
        );
    // 'left' comes to 2.5 from 'right' in the first cycle; 'right' then moves out by 2 and stays there.
    Scene::parse(&chain.replace("cycles = 2", "cycles = 1")).unwrap();
    let error = Scene::parse(&chain).unwrap_err().to_string();
    assert!(
        error.contains("'left' and 'right' touch or overlap in phase 1"),
        "{error}"
    );
}

#[test]
fn models_and_domains_that_are_not_built_are_named_with_what_to_use() {
    for (part, by, fragment) in [
        (
            "[[bodies]]",
            "[[bodies]]\nname = \"long\"\nshape = \"spheroid\"\nhalf_length = 2\nradius = 1\nposition = [0, 9, 0]\n[[bodies]]",
            "is not built yet; use model.kind = \"axisymmetric\"",
        ),
        (
            "radius = 1\nposition = [0",
            "mass = 2\nradius = 1\nposition = [0",
            "bodies[1].mass = 2 is not built yet; remove it",
        ),
    ] {
        let scene = Scene::parse(&GOOD.replacen(part, by, 1)).unwrap();
        let error = swimmer::choose(&scene).err().expect("not built");
        assert!(error.to_string().contains(fragment), "{error}");
        assert!(error.is_bad_input());
    }
}
