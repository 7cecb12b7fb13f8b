//! `swim solve`: one instant.

use std::fmt::Write;

use swimmer::model::choose;
use swimmer::output::{instant_json, peak_rss_mib};
use swimmer::{SwimError, solve_start};

use super::{SceneArguments, duration};

pub fn solve(arguments: &SceneArguments, json: bool) -> Result<String, SwimError> {
    let scene = arguments.read()?;
    let mut model = choose(&scene)?.model;
    let instant = solve_start(&scene, model.as_mut())?;
    if json {
        return Ok(format!(
            "{}\n",
            instant_json(&scene, model.name(), &instant)
        ));
    }
    let mut text = format!("{} by {} at the start\n", scene.name, model.name());
    for (body, motion) in scene.bodies.iter().zip(&instant.bodies) {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{}", body.name);
        for (what, v) in [
            ("velocity", motion.velocity),
            ("angular velocity", motion.angular_velocity),
            ("force on the fluid", motion.force),
            ("torque on the fluid", motion.torque),
        ] {
            let _ = writeln!(
                text,
                "  {what:<19} {:>14.8} {:>14.8} {:>14.8}",
                v.x, v.y, v.z
            );
        }
    }
    let solver = &instant.solver;
    let _ = writeln!(
        text,
        "{} unknowns, {} {}: {} iterations to a true residual of {:.1e}, {}{}",
        instant.dofs.total,
        solver.formulation,
        solver.solver,
        solver.iterations,
        solver.true_relative_residual,
        duration(instant.seconds.total),
        peak_rss_mib().map_or(String::new(), |mib| format!(", {mib:.0} MiB")),
    );
    Ok(text)
}
