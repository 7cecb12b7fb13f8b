//! Malformed scenes: each is refused with the place, the key and the remedy.

use scene::Scene;

/// A valid scene; each case replaces a part of it.
const VALID: &str = r#"[fluid]
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

/// Rows `replacement -> part of the message | ...`; `==` names the part of the valid scene.
///
/// Long rows go on in the next line; `\n` is the end of a line of the scene, `\0` the character 0.
const CASES: &str = r#"
== viscosity = 1
viscosity =  -> scene.toml:2 | not valid TOML
viscosity = "1" -> scene.toml:2 | fluid.viscosity must be a number greater than zero | the text "1"
viscosity = 0 -> fluid.viscosity must be a number greater than zero, not 0
viscosity = -2.5 -> fluid.viscosity | not -2.5
viscosity = nan -> fluid.viscosity | not nan
viscosity = inf -> fluid.viscosity | not inf
thermal_energy = -1 -> scene.toml:2 | fluid.thermal_energy must be a number that is not negative
thermal_energy = 1 -> scene.toml:37 | model.kind has no thermal noise | "rpy"
seed = 3 -> scene.toml:2 | fluid.seed has no effect without fluid.thermal_energy
time_step = 3 -> fluid.time_step has no effect without fluid.inertia or fluid.thermal_energy
== [fluid]
[fluid -> scene.toml:1 | not valid TOML
[fluids] -> scene.toml:1 | did you mean 'fluid'?
== radius = 40
radius = 40\nradius = 41 -> scene.toml:7 | duplicate key
radius = 4O -> scene.toml:6 | not valid TOML
temperature = 3\nradius = 40
    -> scene.toml:6 | fluid.thermal_energy is k_B T
colour = 3\nradius = 40
    -> scene.toml:6 | domain has kind, radius, size, file, surface_kind, scale, walls
radius = -40 -> scene.toml:6 | domain.radius must be a number greater than zero
 -> scene.toml:4 | domain.radius is missing: a ball needs a radius
== kind = "ball"\nradius = 40
kind = "periodic"\nsize = [30, 0, 20] -> domain.size | numbers greater than zero
kind = "periodic" -> domain.size is missing: a periodic box needs [x, y, z] lengths
kind = "periodic"\nsize = [30, 2, 20] -> 'left' touches its own image
kind = "periodic"\nsize = [11, 9, 9] -> 'left' and 'centre' touch
== [model]
\0 -> not valid TOML
== viscosity
viscocity -> scene.toml:2 | 'fluid.viscocity' | did you mean 'fluid.viscosity'?
Reynolds = 1\nviscosity -> fluid.density | fluid.inertia = "full" keeps inertia
shear_thinning = true\nviscosity -> fluid.law = "carreau"
== cycles
cycle -> scene.toml:24 | did you mean 'gait.cycles'?
radius = 3\ncycles -> scene.toml:24 | gait has | radius is a key of domain, bodies[]
== [fem]
rtol = 1e-3\n[fem] -> 'model.rtol' | did you mean 'fem.rtol'?
== kind = "fem"
kind.fem = 1 -> scene.toml:37 | model.kind must be one of auto, oseen | not a table
kind = "magic" -> model.kind cannot be "magic"; it is one of auto, oseen, rpy
== name = "arm"
name = "arm"\nbending_stiffness = 3 -> links[].drive = "spring" makes a link elastic
name = "arm"\nlenght = 3 -> scene.toml:20 | 'links[0].lenght' | has name, body, to
== position = [0, 0, 0]
position = [0, 0] -> scene.toml:16 | bodies[1].position must be three numbers
position = [0, nan, 0] -> scene.toml:16 | bodies[1].position must be three numbers
position = [0, 0, "a"] -> bodies[1].position must be three numbers
 -> bodies[1].position is missing
== cycles = 2
cycles = 2.5 -> scene.toml:24 | gait.cycles must be a whole number | 2.5
cycles = 0 -> gait.cycles must be a whole number of at least 1
cycles = 99999999999 -> gait.cycles must be a whole number
arms = "clampd" -> did you mean "clamped"?
== [gait]\ncycles = 2
[gait]\ncycles = true -> gait.cycles must be a whole number | true
== [fluid]\nviscosity = 1
fluid = 3 -> scene.toml:1 | fluid must be a table, written as [fluid]
== [[links]]
[links] -> scene.toml:18 | links must be a list of tables, written as [[links]]
== name = "left"
name = "" -> scene.toml:9 | bodies[0].name must be a text that is not empty
name = 7 -> bodies[0].name must be a text
== radius = 1\nposition = [0
radius = 0\nposition = [0 -> scene.toml:15 | bodies[1].radius
shape = "surface"\nposition = [0
    -> scene.toml:13 | bodies[1].file is missing: give the STL, OBJ or Gmsh file
shape = "surface"\nfile = "no/such.stl"\nposition = [0
    -> scene.toml:16 | bodies[1].file is refused: no/such.stl
shape = "surface"\nfile = "Cargo.toml"\nposition = [0
    -> Cargo.toml: unknown file extension; use .stl, .obj or .msh
shape = "surface"\nradius = 1\nfile = "part.stl"\nposition = [0
    -> bodies[1].radius belongs to shape = "sphere"
radius = 1\nscale = 2\nposition = [0 -> bodies[1].scale belongs to shape = "surface"
shape = "surface"\nscale = 0\nposition = [0 -> bodies[1].scale must be a number greater than zero
shape = "surface"\nsurface_kind = "smoth"\nposition = [0 -> did you mean "smooth"?
shape = "file"\nsurface = "part"\nposition = [0
    -> bodies[1].shape "file" is a part of the boundary of a mesh
position = [0 -> scene.toml:13 | bodies[1].radius is missing: a sphere needs a radius
shape = "point"\nradius = 1\nposition = [0 -> bodies[1].radius makes no sense for a point
shape = "point"\ntorque = [1, 0, 0]\nposition = [0 -> bodies[1].torque cannot act on a point
shape = "spheroid"\nradius = 1\nposition = [0 -> scene.toml: | bodies[1].half_length is missing
shape = "spheroid"\nradius = 1\nhalf_length = 2\naxis = [0, 0, 0]\nposition = [0
    -> bodies[1].axis must not be zero
half_length = 2\nradius = 1\nposition = [0
    -> bodies[1].half_length belongs to shape = "spheroid", "capsule", "disk"
shape = "ellipsoid"\nradius = 1\nposition = [0 -> bodies[1].radius belongs to shape = "sphere"
shape = "ellipsoid"\nposition = [0 -> scene.toml: | bodies[1].semi_axes is missing
shape = "elipsoid"\nposition = [0 -> did you mean "ellipsoid"?
shape = "capsule"\nradius = 1\nhalf_length = 0.5\nposition = [0
    -> bodies[1].half_length must be larger than the radius
shape = "disk"\nradius = 1\nhalf_length = 2\nposition = [0
    -> bodies[1].half_length must be smaller than the radius
shape = "torus"\nradius = 1\ntube_radius = 1\nposition = [0
    -> bodies[1].tube_radius must be smaller than the radius
shape = "helix"\nradius = 1\ntube_radius = 0.1\npitch = 0\nturns = 2\nposition = [0
    -> bodies[1].pitch must be other than zero
shape = "helix"\nradius = 1\ntube_radius = 0.1\npitch = 1\nturns = 1e6\nposition = [0
    -> bodies[1].turns must be at most 1000
shape = "capsule"\nradius = 1\nhalf_length = 2\naxis = [0, 0, 1]\norientation = [0, 90, 0]\nposition = [0
    -> bodies[1].orientation is given beside axis
== duration = 1\n\n[model]
duration = 0\n\n[model] -> gait.phases[1].duration
== length = 6
length = -6 -> scene.toml:28 | gait.phases[0].length
length = 1.5 -> scene.toml:28 | touch or overlap in phase 1 at 100 % | gap -0.5
length = 2 -> touch or overlap in phase 1 | gap 0
== tolerance = 1e-3
tolerance = 2 -> model.tolerance must be below 1
== rtol = 1e-8
rtol = 1e-30 -> scene.toml:41 | fem.rtol | at least 1e-14
== [fem]\nrtol = 1e-8
[fem]\nsurface_size = -1 -> fem.surface_size
== kind = "ball"
kind = "bal" -> scene.toml:5 | domain.kind cannot be "bal"; did you mean "ball"?
 -> domain.kind is missing
== radius = 1\nposition = [-10
shape = "cube"\nradius = 1\nposition = [-10 -> bodies[0].shape cannot be "cube"
== kind = "ball"\nradius = 40
kind = "surface" -> domain.file is missing
kind = "ball"\nradius = 40\nscale = 2 -> scene.toml:7 | domain.scale belongs to kind = "surface"
kind = "box" -> domain.size is missing
kind = "mesh" -> domain.file is missing
kind = "mesh"\nfile = "no/such.msh" -> scene.toml:6 | domain.file cannot be read: no/such.msh
kind = "mesh"\nfile = "src"\nwalls = ["outer"] -> domain.file cannot be read: src: it is a folder
kind = "mesh"\nfile = "Cargo.toml" -> domain.walls is missing
kind = "mesh"\nfile = "Cargo.toml"\nwalls = [] -> domain.walls is empty
kind = "mesh"\nfile = "Cargo.toml"\nwalls = ["outer"] -> bodies[0].surface is missing
kind = "box"\nsize = [19, 40, 40] -> 'left' is outside the domain | clearance -1.5
kind = "wall" -> is outside the domain | clearance -1
kind = "cylinder"\nradius = 1 -> is outside the domain | clearance 0
kind = "ball"\nradius = 40\n[background]\nkind = "pressure-gradient"
    -> background.kind "pressure-gradient" needs domain.kind = "periodic"
kind = "periodic"\nsize = [40, 40, 40]\n[background]\nkind = "pressure-gradient"
    -> background.pressure_gradient is missing
kind = "periodic"\nsize = [40, 40, 40]\n[background]\nkind = "uniform"\nvelocity = [1, 0, 0]\npressure_gradient = [1, 0, 0]
    -> background.pressure_gradient does not belong to kind = "uniform"
kind = "periodic"\nsize = [40, 40, 40]\n[background]\nkind = "pressure-gradient"\npressure_gradient = [1, 0, 0]
    -> background has no steady flow | hold bodies by fixed = true
== name = "centre"
 -> bodies[1].name is missing
name = "left" -> scene.toml:14 | "left" is the name of bodies[0] too
== length = 6\n
 -> gait.phases[0].length is missing
== link = "arm"\nlength = 6
length = 6 -> gait.phases[0].link is missing
link = "amr"\nlength = 6 -> scene.toml:27 | names no link: "amr"; did you mean "arm"?
== [gait]
[[links]]\nname = "arm"\nbody = "centre"\nto = "left"\n[gait] -> "arm" is the name of links[0] too
[[links]]\nname = "arm-2"\nbody = "centre"\nto = "left"\n[gait] -> links[1] | a second time
[[bodies]]\nname = "p"\nshape = "point"\nposition = [5, 0, 0]\n[gait]
    -> bodies[2] is a point that no link holds
== to = "centre"
to = "center" -> scene.toml:21 | links[0].to names no body: "center"; did you mean "centre"?
to = "moon" -> names no body: "moon"; there are left, centre
to = "left" -> scene.toml:21 | links body 'left' to itself
== position = [-10, 0, 0]
position = [0, 0, 0] -> links[0] has no direction | at the same place
position = [-1.5, 0, 0] -> 'left' and 'centre' touch or overlap at the start: gap -0.5
position = [-2, 0, 0] -> touch or overlap at the start: gap 0
position = [-39, 0, 0] -> scene.toml:11 | 'left' is outside the domain | clearance 0
position = [-90, 0, 0] -> 'left' is outside the domain | clearance -51
== [fluid]\nviscosity = 1\n\n[domain]\nkind = "ball"\nradius = 40\n\n[[bodies]]\n
gravity = [0, 0, -1]\n[[bodies]]\ndensity = 2\nmass = 3\n
    -> bodies[0].density is given beside a mass | remove one
"#;

/// The cases as part, replacement and fragments.
fn cases() -> Vec<(String, String, Vec<&'static str>)> {
    let text = |row: &str| row.replace("\\n", "\n").replace("\\0", "\0");
    let (mut part, mut by, mut cases) = ("", "", Vec::new());
    for line in CASES.trim().lines() {
        if let Some(next) = line.strip_prefix("== ") {
            part = next;
        } else if let Some((here, fragments)) = line.split_once("-> ") {
            let by = format!("{}{}", std::mem::take(&mut by), here.trim());
            cases.push((text(part), text(&by), fragments.split(" | ").collect()));
        } else {
            by = line;
        }
    }
    cases
}

#[test]
fn the_valid_scene_is_accepted() {
    Scene::parse(VALID).unwrap();
}

#[test]
fn deep_nesting_is_refused() {
    for open in ["[", "{a=", "[{a="] {
        let text = format!("{VALID}\nx = {}", open.repeat(50_000));
        let error = Scene::parse(&text).unwrap_err();
        assert!(error.to_string().len() < 1000);
    }
}

#[test]
fn malformed_scenes_are_refused_with_place_and_remedy() {
    let cases = cases();
    assert_eq!(cases.len(), 113);
    for (part, by, fragments) in cases {
        assert!(VALID.contains(&part), "no such part: {part}");
        let text = VALID.replacen(&part, &by, 1);
        let error = Scene::parse(&text).expect_err(&format!("accepted: {by}"));
        let message = error.to_string();
        for fragment in fragments {
            assert!(
                message.contains(fragment),
                "for {by:?}: {fragment:?} is not in: {message}"
            );
        }
        assert!(!message.contains('\n'), "more than one line: {message}");
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
    }
}

#[test]
fn a_second_cycle_that_starts_closer_is_checked_too() {
    let chain = VALID
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
    // In the first cycle the distance of 'left' and 'right' decreases to 2.5. Then 'right' moves
    // outwards by 2 and stays there.
    Scene::parse(&chain.replace("cycles = 2", "cycles = 1")).unwrap();
    let error = Scene::parse(&chain).unwrap_err().to_string();
    assert!(
        error.contains("'left' and 'right' touch or overlap in phase 1"),
        "{error}"
    );
}
