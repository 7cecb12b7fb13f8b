//! The same solution with other solvers, numbers of threads and units.

use swimmer::Scene;
use swimmer::models::InstantaneousSolution;

use crate::scenes::{
    BALL, BODIES, COARSE, bent, force_error, largest_differences, parse, solve, solve_with_flow,
    velocity_error,
};

fn same(v: [nalgebra::Vector3<f64>; 4]) -> [nalgebra::Vector3<f64>; 4] {
    v
}

#[test]
fn direct_and_block_solver_agree() {
    let block = solve(&bent(COARSE));
    let direct = solve(&bent(&format!("{COARSE}fem.solver = \"direct\"\n")));
    assert_eq!(
        [block.solver.solver.as_str(), &direct.solver.solver],
        ["block", "direct"]
    );
    let [velocities, forces] = largest_differences(&block, &direct, same);
    assert!(velocities <= 1e-8, "{velocities:e}");
    assert!(
        velocities <= velocity_error(&block) + velocity_error(&direct),
        "{velocities:e}"
    );
    assert!(
        forces <= force_error(&block) + force_error(&direct),
        "{forces:e}"
    );
}

#[test]
fn solutions_are_bitwise_equal_for_any_number_of_threads() {
    for solver in ["block", "direct"] {
        let scene = bent(&format!("{COARSE}fem.solver = \"{solver}\"\n"));
        let answers = [1, 2, 3].map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let (instant, flow) = solve_with_flow(&scene);
                (instant.response.bodies, flow.velocity, flow.pressure)
            })
        });
        assert!(
            answers[0] == answers[1],
            "{solver}: one and two threads differ"
        );
        assert!(
            answers[0] == answers[2],
            "{solver}: one and three threads differ"
        );
    }
}

/// The bent swimmer with other units of length and viscosity.
fn in_units(length: f64, viscosity: f64) -> Scene {
    let shape = |text: &str| -> String {
        text.lines()
            .map(|line| match line.split_once(" = ") {
                Some(("radius", r)) => {
                    format!("radius = {:?}\n", r.parse::<f64>().unwrap() * length)
                }
                Some(("position", x)) => {
                    let x = x
                        .trim_matches(['[', ']'])
                        .split(',')
                        .map(|c| c.trim().parse::<f64>().unwrap() * length);
                    format!("position = {:?}\n", x.collect::<Vec<_>>())
                }
                _ => format!("{line}\n"),
            })
            .collect()
    };
    let options = COARSE.replace("0.7", &format!("{:?}", 0.7 * length));
    parse(&format!(
        "domain = {{ kind = \"ball\", radius = {:?} }}\nfluid.viscosity = {viscosity:?}\n{options}{}\
         [[gait.phases]]\nlink = \"left-arm\"\nlength = {:?}\n",
        9.0 * length,
        shape(BODIES),
        3.25 * length
    ))
}

/// Differences of two solutions in other units: velocities scale with the length, forces with
/// viscosity and length squared.
fn scaled(
    unit: &InstantaneousSolution,
    other: &InstantaneousSolution,
    length: f64,
    viscosity: f64,
) -> [f64; 2] {
    let force = viscosity * length * length;
    let mut differences = largest_differences(unit, other, |[u, w, f, t]| {
        [u * length, w, f * force, t * (force * length)]
    });
    differences[1] /= force;
    differences
}

#[test]
fn units_of_the_scene_do_not_matter() {
    assert!(BALL.contains("9") && COARSE.contains("0.7"));
    let unit = solve(&in_units(1.0, 1.0));
    // A power of two changes no digit.
    let length = 0.5_f64.powi(20);
    let other = solve(&in_units(length, 2.0));
    assert_eq!(scaled(&unit, &other, length, 2.0), [0.0, 0.0]);
    // Micrometres and water change the last digits, also those of the mesh: as two different
    // solves.
    let (length, viscosity) = (1e-6, 1e-3);
    let other = solve(&in_units(length, viscosity));
    let [velocities, forces] = scaled(&unit, &other, length, viscosity);
    // Rates are lengths per time as well; angular velocities keep their size.
    assert!(velocities <= 2.0 * velocity_error(&unit), "{velocities:e}");
    assert!(forces <= 2.0 * force_error(&unit), "{forces:e}");
}
