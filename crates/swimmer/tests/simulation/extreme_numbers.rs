//! Numbers of any size in every key, with every model: a right answer, or bad input with a place.

use swimmer::models::{InstantaneousSolution, ModelError};
use swimmer::{Scene, SwimError, choose, solve_start};

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
        let close = |name: &str, found: [f64; 3], expected: [f64; 3]| {
            for (found, expected) in found.iter().zip(expected) {
                // the solver stops at 1e-8; the scaled numbers are rounded
                let bound = 1e-6 * expected.abs();
                assert!(
                    (found - expected).abs() <= bound,
                    "{model:?} {name}: {found:e} {expected:e}"
                );
            }
        };
        let [u, _, f] = of_first(model, &ONES);
        let [forced, ..] = of_first(
            model,
            &Numbers {
                force: 1.0,
                duration: 4e8,
                ..ONES
            },
        );
        let [_, turned, _] = of_first(
            model,
            &Numbers {
                torque: 1.0,
                duration: 1e8,
                ..ONES
            },
        );
        for x in [1e-40, 1e40] {
            let [v, _, g] = of_first(
                model,
                &Numbers {
                    viscosity: x,
                    ..ONES
                },
            );
            close("viscosity", [v, g, 0.0], [u, f * x, 0.0]);
            let [v, _, g] = of_first(
                model,
                &Numbers {
                    duration: x,
                    ..ONES
                },
            );
            close("duration", [v, g, 0.0], [u / x, f / x, 0.0]);
            let [v, _, g] = of_first(model, &Numbers { length: x, ..ONES });
            close("length", [v, g, 0.0], [u * x, f * x * x, 0.0]);
            // on a mesh that is not symmetric the closing arm turns the bodies a little: it is slow
            let duration = (1e8 / x).min(1e45);
            let [_, spin, _] = of_first(
                model,
                &Numbers {
                    torque: x,
                    duration,
                    ..ONES
                },
            );
            close("torque", [spin, 0.0, 0.0], [turned * x, 0.0, 0.0]);
        }
        let [v, ..] = of_first(
            model,
            &Numbers {
                force: 2.0,
                duration: 4e8,
                ..ONES
            },
        );
        // the arm closes at 2.5e-9, a force of one moves the spheres at about 1/30
        close("force", [v, 0.0, 0.0], [2.0 * forced, 0.0, 0.0]);
    }
}

/// One number of a scene replaced: solved, or refused as bad input at a place.
#[test]
fn numbers_beyond_sense_are_bad_input_for_every_model() {
    let mut refused = 0;
    for model in MODELS {
        let sound = text(
            model,
            &Numbers {
                force: 1.0,
                torque: 1.0,
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
                        assert!(
                            text.contains("scene.toml:")
                                || matches!(
                                    error,
                                    SwimError::Model(ModelError::Unsupported { .. })
                                ),
                            "{model:?} {key} = {hostile}: {text}"
                        );
                        refused += 1;
                    }
                }
            }
        }
    }
    assert!(refused > 200, "{refused}");
}
