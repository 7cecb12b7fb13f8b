//! `swim solve`: one solution.

use std::fmt::Write;
use std::path::Path;

use swimmer::models::ErrorEstimate;
use swimmer::output::{matrix_json, peak_rss_mib, solution_json, write_flow};
use swimmer::{SwimError, choose, solve_start, start_flow, start_resistance};

use super::{SceneArguments, duration, errors};

pub fn solve(
    arguments: &SceneArguments,
    json: bool,
    resistance: bool,
    flow: Option<&Path>,
) -> Result<String, SwimError> {
    let scene = arguments.read()?;
    let mut model = choose(&scene)?.model;
    let solution = solve_start(&scene, model.as_mut())?;
    if let Some(path) = flow {
        write_flow(&start_flow(&scene, model.as_mut())?, path)?;
    }
    let resistance = resistance
        .then(|| start_resistance(&scene, model.as_mut()))
        .transpose()?;
    if json {
        let mut answer = solution_json(&scene, model.name(), &solution);
        if let Some(resistance) = &resistance {
            answer["resistance"] = matrix_json(resistance);
        }
        return Ok(format!("{answer}\n"));
    }
    let mut text = format!("{} by {} at the start\n", scene.name(), model.name());
    for (body, motion) in scene.bodies().iter().zip(&solution.bodies) {
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
    for (link, force) in scene
        .articulation()
        .links()
        .iter()
        .zip(&solution.link_forces)
    {
        let _ = writeln!(
            text,
            "force of {} on {} {:>14.8} {:>14.8} {:>14.8}",
            link.name,
            scene.bodies()[link.body].name,
            force.x,
            force.y,
            force.z
        );
    }
    let bars = ErrorEstimate {
        // nothing is integrated
        integration: Some(0.0),
        ..solution.error_estimate
    };
    let _ = writeln!(text, "velocities: {}", errors(&bars));
    if let Some(error) = &solution.mesh_error {
        let _ = writeln!(text, "forces: error {:.1e} by the mesh", error.force());
    }
    if let Some(checks) = &solution.checks {
        let _ = writeln!(
            text,
            "checks: forces by the stress on surfaces differ by {:.1e}, dissipation and power by {:.1e}, relative",
            checks.force_by_stress, checks.dissipation
        );
    }
    let solver = &solution.solver;
    let _ = writeln!(
        text,
        "{} unknowns, {} {}: {} iterations to a true residual of {:.1e}, {}{}",
        solution.dofs.total,
        solver.formulation,
        solver.solver,
        solver.iterations,
        solver.true_relative_residual,
        duration(solution.seconds.total),
        peak_rss_mib().map_or(String::new(), |mib| format!(", {mib:.0} MiB")),
    );
    let [of_forces, of_velocities] = solution.relative_mesh_errors();
    if let Some(target) = scene.fem().target
        && of_forces.max(of_velocities) > target
    {
        let _ = writeln!(
            text,
            "warning: the mesh errs by {of_forces:.1e} in forces and {of_velocities:.1e} in velocities, more than fem.target = {target:e} allows"
        );
    }
    if let Some(resistance) = resistance {
        text.push_str("grand resistance, (F, T) of each body by rows for (U, omega) by columns\n");
        for row in resistance.row_iter() {
            let cells: Vec<String> = row.iter().map(|entry| format!("{entry:>13.6e}")).collect();
            let _ = writeln!(text, "{}", cells.join(" "));
        }
    }
    Ok(text)
}
