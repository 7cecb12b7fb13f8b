//! Numbers of any size in every key, with every model: a right answer, or bad input with a place.

use swimmer::models::{InstantaneousSolution, ModelError};
use swimmer::{Scene, SwimError, choose, solve_start};
use testkit::within;

/// Two linked spheres on the x axis under a force, in units of `L` (length) and with other numbers.
struct Numbers {
    length: f64,
    viscosity: f64,
    force: f64,
    torque: f64,
    duration: f64,
}

const ONES: Numbers = Numbers {
    length: 1.0,
    viscosity: 1.0,
    force: 0.0,
    torque: 0.0,
    duration: 1.0,
};

/// Models with the domain that they are tested in.
const MODELS: [(&str, &str); 5] = [
    ("oseen", "unbounded"),
    ("rpy", "unbounded"),
    ("multipole", "unbounded"),
    ("axisymmetric", "ball"),
    ("fem", "ball"),
];

fn text((model, domain): (&str, &str), n: &Numbers) -> String {
    let l = n.length;
    let radius = match domain {
        "ball" => format!("radius = {:e}", 12.0 * l),
        _ => String::new(),
    };
    format!(
        r#"
fluid.viscosity = {viscosity:e}
model.kind = "{model}"
fem.surface_size = {size:e}
domain.kind = "{domain}"
domain.{radius}
[[bodies]]
name = "a"
radius = {l:e}
position = [0, 0, 0]
force = [{force:e}, 0, 0]
torque = [{torque:e}, 0, 0]
[[bodies]]
name = "b"
radius = {l:e}
position = [{x:e}, 0, 0]
[[links]]
name = "arm"
body = "b"
to = "a"
[[gait.phases]]
link = "arm"
length = {end:e}
duration = {duration:e}
"#,
        viscosity = n.viscosity,
        size = 1.2 * l,
        force = n.force,
        torque = n.torque,
        x = 5.0 * l,
        end = 4.0 * l,
        duration = n.duration,
    )
    .replace("domain.\n", "")
}

fn solution(text: &str) -> Result<InstantaneousSolution, SwimError> {
    let scene = Scene::parse(text)?;
    let mut model = choose(&scene)?.model;
    solve_start(&scene, model.as_mut())
}

/// Velocity, angular velocity and force of the first body along x.
fn of_first(model: (&str, &str), numbers: &Numbers) -> [f64; 3] {
    let text = text(model, numbers);
    let solution = solution(&text).unwrap_or_else(|error| panic!("{error}\n{text}"));
    let body = solution.bodies[0];
    [body.velocity.x, body.angular_velocity.x, body.force.x]
}

#[test]
fn solutions_are_proportional_to_the_units_of_the_scene() {
    for model in MODELS {
        let close = |name: &str, found: f64, expected: f64| {
            let why = format!("the solver stops at 1e-8, numbers are rounded: {model:?} {name}");
            within(found - expected, 1e-6 * expected.abs(), why);
        };
        let [u, _, f] = of_first(model, &ONES);
        let slow = |duration: f64| Numbers { duration, ..ONES };
        let pulled = |force: f64| of_first(model, &Numbers { force, ..slow(4e8) })[0];
        let turned = |torque: f64, duration: f64| {
            of_first(
                model,
                &Numbers {
                    torque,
                    ..slow(duration)
                },
            )[1]
        };
        for x in [1e-40, 1e40] {
            let [v, _, g] = of_first(
                model,
                &Numbers {
                    viscosity: x,
                    ..ONES
                },
            );
            close("viscosity", v, u);
            close("viscosity", g, f * x);
            let [v, _, g] = of_first(model, &slow(x));
            close("duration", v, u / x);
            close("duration", g, f / x);
            let [v, _, g] = of_first(model, &Numbers { length: x, ..ONES });
            close("length", v, u * x);
            close("length", g, f * x * x);
            // on a mesh that is not symmetric the closing arm turns the bodies a little: it is slow
            close(
                "torque",
                turned(x, (1e8 / x).min(1e45)),
                turned(1.0, 1e8) * x,
            );
        }
        // the arm closes at 2.5e-9, a force of one moves the spheres at about 1/30
        close("force", pulled(2.0), 2.0 * pulled(1.0));
    }
}

/// One number of a scene replaced: solved, or refused as bad input at a place.
#[test]
fn numbers_beyond_sense_are_bad_input_for_every_model() {
    let mut refused = 0;
    for model in MODELS {
        let (force, torque) = (1.0, 1.0);
        let sound = text(
            model,
            &Numbers {
                force,
                torque,
                ..ONES
            },
        );
        for (number, line) in sound.lines().enumerate() {
            let Some((key, value)) = line.split_once(" = ") else {
                continue;
            };
            if value.starts_with('"') {
                continue;
            }
            for hostile in ["0", "-1", "1e300", "1e-300", "1e-320", "1e40", "1e-40"] {
                let value = match value.starts_with('[') {
                    true => format!("[{hostile}, 0, 0]"),
                    false => hostile.to_owned(),
                };
                let mut lines: Vec<String> = sound.lines().map(str::to_owned).collect();
                lines[number] = format!("{key} = {value}");
                match solution(&lines.join("\n")) {
                    Ok(solution) => {
                        let speed = solution.bodies[0].velocity.norm();
                        assert!(speed.is_finite(), "{model:?} {key} = {hostile}");
                    }
                    Err(error) => {
                        let text = error.to_string();
                        assert_eq!(error.exit_code(), 2, "{model:?} {key} = {hostile}: {text}");
                        let unsupported =
                            matches!(error, SwimError::Model(ModelError::Unsupported { .. }));
                        let has_place = text.contains("scene.toml:") || unsupported;
                        assert!(has_place, "{model:?} {key} = {hostile}: {text}");
                        refused += 1;
                    }
                }
            }
        }
    }
    assert!(refused > 200, "{refused}");
}
