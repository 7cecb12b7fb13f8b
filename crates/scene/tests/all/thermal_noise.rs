//! Thermal noise: its keys, and what is refused beside it.

use scene::Scene;

const SPHERES: &str = "bodies = [\n    { name = \"a\", radius = 1, position = [0, 0, 0] },\n    \
                       { name = \"b\", radius = 1, position = [9, 0, 0] },\n    \
                       { name = \"c\", radius = 1, position = [0, 9, 0] },\n]\n";

fn scene(keys: &str) -> Result<Scene, String> {
    let text = format!("fluid.thermal_energy = 0.5\n{SPHERES}{keys}");
    Scene::parse(&text).map_err(|error| error.to_string())
}

#[test]
fn noise_has_an_energy_a_seed_and_the_largest_step() {
    let found = scene("fluid.seed = 7\nfluid.time_step = 0.25").unwrap();
    let noise = found.noise().unwrap();
    assert_eq!((noise.energy, noise.seed), (0.5, 7));
    assert_eq!(noise.time_step, Some(0.25));
    assert_eq!(found.inertia().time_step, None);
    let plain = scene("").unwrap();
    let noise = plain.noise().unwrap();
    assert_eq!((noise.seed, noise.time_step), (1, None));
    // A scene without energy has no noise, whatever its seed.
    let cold = format!("fluid = {{ thermal_energy = 0, seed = 7, time_step = 1 }}\n{SPHERES}");
    assert_eq!(Scene::parse(&cold).unwrap().noise(), None);
    // A scene that was written is the same scene.
    let again = Scene::parse(&found.to_toml().unwrap()).unwrap();
    assert_eq!(again.noise(), found.noise());
}

#[test]
fn what_has_no_thermal_motion_is_refused_with_its_place() {
    let arm = |body: &str, to: &str| {
        format!("[[links]]\nname = \"{body}{to}\"\nbody = \"{body}\"\nto = \"{to}\"\n")
    };
    let triangle = arm("a", "b") + &arm("b", "c") + &arm("c", "a");
    for (keys, place, part) in [
        ("model.kind = \"fem\"", 7, "model.kind has no thermal noise"),
        (
            "model.kind = \"axisymmetric\"",
            7,
            "model.kind has no thermal noise",
        ),
        (
            "fluid.law = \"carreau\"\nfluid.zero_shear_viscosity = 1\nfluid.relaxation_time = 1\n\
             fluid.index = 0.5",
            7,
            "fluid.law is unsupported with fluid.thermal_energy",
        ),
        (
            "fluid.inertia = \"full\"\nfluid.density = 1\ndomain = { kind = \"ball\", radius = 50 }",
            7,
            "fluid.inertia is unsupported with fluid.thermal_energy",
        ),
        (&triangle, 7, "links form a loop"),
        (
            "gait.arms = \"free\"\n[[links]]\nname = \"s\"\nbody = \"a\"\nto = \"b\"\n\
             drive = \"free\"\n",
            7,
            "gait.arms",
        ),
        (
            "gait.periodic = true\ngait.phases = [{ duration = 1 }]",
            7,
            "gait.periodic",
        ),
    ] {
        let error = scene(keys).expect_err(keys);
        assert!(error.contains(part), "{part} is not in {error}");
        assert!(error.contains(&format!("toml:{place}")), "{error}");
        // What is refused beside noise is a scene without it.
        if !keys.contains("periodic") {
            Scene::parse(&format!("{SPHERES}{keys}")).expect(keys);
        }
    }
    let heavy = "fluid.thermal_energy = 1\nbodies = [{ name = \"a\", radius = 1, mass = 1, \
                 position = [0, 0, 0] }]";
    let error = Scene::parse(heavy).unwrap_err().to_string();
    assert!(error.contains("bodies[0].mass is unsupported"), "{error}");
}
