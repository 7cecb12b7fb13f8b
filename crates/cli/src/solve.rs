//! `swim solve`: the instantaneous solution at the start.

use std::path::Path;

use nalgebra::Vector3;
use pictures::start_slice;
use swimmer::models::{BodySolution, ErrorEstimate, Hydrodynamics, InstantaneousSolution};
use swimmer::output::{matrix_json, peak_rss_mib, solution_json, write_flow};
use swimmer::{Scene, SwimError, choose, solve_start, start_flow, start_resistance};

use super::arguments::SceneArguments;
use super::error::CliError;
use super::text::{
    count, duration, entry, error, error_estimates, measured, percent, print, rounded, warn,
};

pub fn solve(
    arguments: &SceneArguments,
    json: bool,
    resistance: bool,
    flow: Option<&Path>,
    picture: Option<&Path>,
) -> Result<String, CliError> {
    if let Some(path) = picture {
        require_svg(path)?;
    }
    let scene = arguments.read()?;
    let mut model = choose(&scene)?.model;
    let solution = solve_start(&scene, model.as_mut())?;
    // What fails after the solution does not lose its numbers.
    let written = write_files(&scene, model.as_mut(), flow, picture);
    let resistance = resistance
        .then(|| start_resistance(&scene, model.as_mut()))
        .transpose()?;
    warn_about_target(&scene, &solution);
    if json {
        let mut answer = solution_json(&scene, model.name(), &solution);
        if let Some(resistance) = &resistance {
            answer["resistance"] = matrix_json(resistance);
        }
        return and_then(format!("{answer}\n"), written);
    }
    let mut text = entry("scene", scene.name());
    text += &entry("model", model.name());
    text += "\n";
    text += &motion(&scene, &solution);
    text += "\n";
    text += &accuracy(&solution);
    text += &cost(&solution);
    if let Some(resistance) = resistance {
        text += "\ngrand resistance matrix: rows (F, T) of each body, columns (U, omega)\n";
        for row in resistance.row_iter() {
            let cells: Vec<String> = row.iter().map(|entry| format!("{entry:>13.6e}")).collect();
            text += &cells.join(" ");
            text += "\n";
        }
    }
    and_then(text, written)
}

/// The text, which is printed at once if the files that belong to it were not written.
fn and_then(text: String, written: Result<(), CliError>) -> Result<String, CliError> {
    if written.is_err() {
        print(&text)?;
    }
    written.map(|()| text)
}

/// Writes the flow and its picture, where they are wanted.
fn write_files(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    flow: Option<&Path>,
    picture: Option<&Path>,
) -> Result<(), CliError> {
    if let Some(path) = flow {
        write_flow(&start_flow(scene, model)?, path)?;
    }
    match picture {
        Some(path) => draw_flow(scene, model, path),
        None => Ok(()),
    }
}

/// Refuses a picture in another format.
fn require_svg(path: &Path) -> Result<(), CliError> {
    if path.extension().is_some_and(|extension| extension == "svg") {
        return Ok(());
    }
    Err(CliError::NotApplicable {
        place: format!("--picture {}", path.display()),
        problem: "pictures are written as SVG; end the name with .svg".to_owned(),
    })
}

/// Number of points of the slice: a colour per three pixels, and streamlines without corners.
const PICTURE_POINTS: usize = 30_000;

/// Writes the picture of the flow in a plane.
fn draw_flow(scene: &Scene, model: &mut dyn Hydrodynamics, path: &Path) -> Result<(), CliError> {
    let set = scene.articulation();
    let poses = set
        .place(&scene.initial_state(), set.initial_shape())
        .map_err(SwimError::from)?;
    let slice = start_slice(scene, model, PICTURE_POINTS)?;
    let svg = pictures::flow_svg(scene, &poses, &slice)?;
    let write = |file: &mut dyn std::io::Write| file.write_all(svg.as_bytes());
    mesh::write_atomically(path, write).map_err(|source| SwimError::Write {
        path: path.to_owned(),
        source,
    })?;
    Ok(())
}

/// Sizes below which velocities, angular velocities, forces and torques are rounding.
struct Rounding {
    velocity: f64,
    angular_velocity: f64,
    force: f64,
    torque: f64,
}

impl Rounding {
    /// The rounding of the largest numbers, and of those that would be as large: a force `μ R U`
    /// for velocities `U` of bodies of the radius `R`.
    fn new(scene: &Scene, solution: &InstantaneousSolution) -> Self {
        let largest =
            |of: fn(&BodySolution) -> f64| solution.bodies.iter().map(of).fold(0.0, f64::max);
        let radii = scene.bodies().iter().map(|body| body.bounding_radius());
        let radius = radii.fold(f64::MIN_POSITIVE, f64::max);
        let speed =
            largest(|b| b.velocity.norm()).max(radius * largest(|b| b.angular_velocity.norm()));
        let force = largest(|b| b.force.norm())
            .max(largest(|b| b.torque.norm()) / radius)
            .max(scene.viscosity() * radius * speed);
        Self {
            velocity: ROUNDING * speed,
            angular_velocity: ROUNDING * speed / radius,
            force: ROUNDING * force,
            torque: ROUNDING * force * radius,
        }
    }
}

/// A line with a label and a vector, with eight decimals where they show its digits and else with
/// an exponent; components up to `rounding` are zero.
fn row(label: &str, v: &Vector3<f64>, rounding: f64) -> String {
    let v = v.map(|x| if x.abs() > rounding { x } else { 0.0 });
    let is_fixed = v.amax() == 0.0 || FIXED_POINT.contains(&v.amax());
    let words = v.map(|x| match is_fixed {
        true => format!("{:.8}", rounded(x, 8)),
        false if x == 0.0 => "0".to_owned(),
        false => format!("{x:.7e}"),
    });
    format!(
        "{label:<24}{:>14} {:>14} {:>14}\n",
        words.x, words.y, words.z
    )
}

/// Sizes of vectors that are printed with eight decimals.
const FIXED_POINT: std::ops::Range<f64> = 1e-3..1e5;

/// Rounding of a number that was solved for, relative to the largest one.
const ROUNDING: f64 = 1e-14;

/// Velocities and forces of the bodies, and forces of the joints.
fn motion(scene: &Scene, solution: &InstantaneousSolution) -> String {
    let rounding = Rounding::new(scene, solution);
    let mut text = "vectors (x, y, z) in the scene's units\n".to_owned();
    for (number, (body, motion)) in scene.bodies().iter().zip(&solution.bodies).enumerate() {
        text += &entry("body", &body.name);
        text += &row("  velocity", &motion.velocity, rounding.velocity);
        text += &row(
            "  angular velocity",
            &motion.angular_velocity,
            rounding.angular_velocity,
        );
        text += &row("  force on the fluid", &motion.force, rounding.force);
        text += &row("  torque on the fluid", &motion.torque, rounding.torque);
        if let Some(load) = solution.holding.iter().find(|load| load.body == number) {
            text += &row("  force that holds it", &load.force, rounding.force);
            text += &row("  torque that holds it", &load.torque, rounding.torque);
        }
        let stresslets = solution.stresslets.as_ref();
        if let Some(stresslet) = stresslets.and_then(|s| s.bodies.get(number)) {
            for (label, column) in ["  stresslet", "", ""]
                .into_iter()
                .zip(stresslet.column_iter())
            {
                text += &row(label, &column.into_owned(), rounding.torque);
            }
        }
    }
    for (joint, force) in scene
        .articulation()
        .joints()
        .iter()
        .zip(&solution.joint_forces)
    {
        text += &entry("link", &joint.name);
        text += &row(
            &format!("  force on {}", scene.bodies()[joint.body].name),
            force,
            rounding.force,
        );
    }
    text
}

/// Error estimates and independent checks.
fn accuracy(solution: &InstantaneousSolution) -> String {
    let largest = |of: fn(&BodySolution) -> f64| solution.bodies.iter().map(of).fold(0.0, f64::max);
    let velocities = ErrorEstimate {
        // Nothing is integrated.
        integration: Some(0.0),
        ..solution.error_estimate
    };
    let mut text = error_estimates(
        "error of velocities",
        &velocities,
        largest(|body| body.velocity.norm()),
        "the largest velocity",
    );
    let forces = largest(|body| body.force.norm());
    text += &entry(
        "error of forces",
        error(solution.force_error.total(), forces),
    );
    // Of what is zero there is nothing to say.
    for (label, size, bars) in [
        (
            "error of ang. velocity",
            largest(|body| body.angular_velocity.norm()),
            solution.angular_velocity_error.total(),
        ),
        (
            "error of torques",
            largest(|body| body.torque.norm()),
            solution.torque_error.total(),
        ),
    ] {
        if size > bars && bars > 0.0 {
            text += &entry(label, error(bars, size));
        }
    }
    let (power, of_power) = (solution.power(), solution.power_error.total());
    text += &measured("power on the fluid", power, of_power);
    if let Some((stresslets, bar)) =
        (solution.stresslets.as_ref()).and_then(|s| Some((s, s.error?)))
    {
        text += &entry("error of stresslets", error(bar, stresslets.largest()));
    }
    if let Some(checks) = &solution.checks {
        // The ratio to a force that is zero says nothing.
        if forces > solution.force_error.total() {
            let difference = percent(checks.force_by_stress);
            let words = format!("{difference} difference from the integral of the stress");
            text += &entry("check of forces", words);
        }
        let power = percent(checks.dissipation);
        text += &entry(
            "check of power",
            format!("{power} difference from the dissipation"),
        );
    }
    text
}

/// Size, solver, time and memory.
fn cost(solution: &InstantaneousSolution) -> String {
    let solver = &solution.solver;
    let method = format!(
        "{} {}, {}, true relative residual {:.1e}",
        solver.formulation,
        solver.solver,
        count(solver.iterations, "iteration"),
        solver.true_relative_residual
    );
    let mut text = entry("degrees of freedom", solution.dofs.total)
        + &entry("solver", method)
        + &entry("time", duration(solution.seconds.total));
    if let Some(mib) = peak_rss_mib() {
        text += &entry("peak memory", format!("{mib:.0} MiB"));
    }
    text
}

/// Warns if the discretisation error exceeds `fem.target`.
fn warn_about_target(scene: &Scene, solution: &InstantaneousSolution) {
    let [forces, velocities] = solution.relative_mesh_errors();
    if let Some(target) = scene.fem().target
        && forces.max(velocities) > target
    {
        warn(&format!(
            "fem.target = {target:e} allows a discretisation error of {}, the estimate is {} of \
             the largest force and {} of the largest velocity; reduce fem.surface_size",
            percent(target),
            percent(forces),
            percent(velocities),
        ));
    }
}
