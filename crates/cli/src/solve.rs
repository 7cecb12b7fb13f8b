//! `swim solve`: the instantaneous solution at the start.

use std::f64::consts::PI;
use std::path::Path;

use nalgebra::Vector3;
use pictures::start_slice;
use swimmer::models::{
    BodySolution, Configuration, ErrorEstimate, Hydrodynamics, InstantaneousSolution,
};
use swimmer::output::{ALL_ERRORS, matrix_json, peak_rss_mib, solution_json, write_flow};
use swimmer::scene::{AcceptKind, ModelKind};
use swimmer::{
    Progress, Scene, StartSolution, SteadySolution, SwimError, choose_for_start,
    solve_start_with_terms, solve_steady, start_flow, start_neglected, start_resistance,
};

use super::arguments::SceneArguments;
use super::error::CliError;
use super::neglected;
use super::progress::Waiting;
use super::text::{
    NO_ESTIMATE, count, duration, entry, error, error_estimates, measured, percent, print,
    significant, warn,
};

pub fn solve(
    arguments: &SceneArguments,
    json: bool,
    resistance: bool,
    flow: Option<&Path>,
    picture: Option<&Path>,
    quiet: bool,
) -> Result<String, CliError> {
    if let Some(path) = picture {
        require_svg(path)?;
    }
    let given = arguments.read(quiet)?;
    let waiting = Waiting::new("choosing the model", quiet);
    let StartSolution {
        scene,
        mut model,
        solution,
        neglected,
        decision,
    } = {
        let choose_and_predict = |scene: &Scene, progress: &mut dyn Progress| {
            let choice = choose_for_start(scene, progress)?;
            waiting.says("solving");
            // Among thousands of spheres a prediction takes seconds, which nobody would see.
            if !quiet {
                let state = scene.initial_state();
                let start = Configuration::new(&state, scene.articulation().initial_shape());
                let seconds = choice.model.predicted_seconds(start);
                seconds.inspect(|seconds| waiting.predicts(*seconds));
            }
            Ok(choice)
        };
        solve_start_with_terms(given, &choose_and_predict, &mut &waiting)?
    };
    // What fails after the solution does not lose its numbers.
    waiting.says("the flow in files");
    let written = write_files(&scene, model.as_mut(), flow, picture);
    waiting.says("the resistance matrix");
    let resistance = resistance
        .then(|| start_resistance(&scene, model.as_mut()))
        .transpose()?;
    waiting.says("what neglected terms would change");
    let neglected = match neglected {
        Some(costs) => costs,
        None => start_neglected(&scene, model.as_mut(), &solution.bodies)?,
    };
    drop(waiting);
    warn_about_target(&scene, &solution);
    let comparison = Comparison::new(&scene, model.as_ref(), &solution);
    let written = written.and(comparison.check(&scene));
    if json {
        let mut answer = solution_json(&scene, model.name(), &solution);
        answer["tolerance"] = comparison.tolerance.into();
        answer["tolerance_met"] = comparison.is_met().into();
        answer["tolerance_limits"] = match comparison.controls_error {
            true => ALL_ERRORS.into(),
            false => "the error of the integration".into(),
        };
        for neglected in &neglected {
            answer[neglected.key()] = neglected.json(&scene);
        }
        if let Some(decision) = decision {
            answer["decision"] = decision.into();
        }
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
    text += &accuracy(&scene, &solution);
    text += &comparison.line();
    text += &decision.map_or(String::new(), |decision| entry("decision", decision));
    text += &neglected::of_solution(&scene, &neglected, &solution);
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

/// `swim solve --steady`: the steady state in a fluid with inertia.
pub fn solve_steady_state(
    arguments: &SceneArguments,
    json: bool,
    flow: Option<&Path>,
    quiet: bool,
) -> Result<String, CliError> {
    let scene = arguments.read(quiet)?;
    let waiting = Waiting::new("the steady flow", quiet);
    let steady = solve_steady(&scene, &mut &waiting)?;
    drop(waiting);
    let SteadySolution {
        model,
        solution,
        reynolds,
        iterations,
        change,
        ..
    } = &steady;
    let written = match (flow, &solution.flow) {
        (Some(path), Some(flow)) => (flow.field().map_err(SwimError::from))
            .and_then(|field| write_flow(field, path))
            .map_err(CliError::from),
        (Some(_), None) => Err(CliError::NotApplicable {
            place: "--flow".to_owned(),
            problem: "a flow in the meridian plane has no mesh in space; set model.kind = \"fem\""
                .to_owned(),
        }),
        (None, _) => Ok(()),
    };
    if json {
        let mut answer = solution_json(&scene, model, solution);
        answer["steady"] = serde_json::json!({
            "reynolds": reynolds,
            "iterations": iterations,
            "change": change,
        });
        return and_then(format!("{answer}\n"), written);
    }
    let mut text = entry("scene", scene.name());
    text += &entry("model", model);
    text += &entry("inertia", format!("steady, Reynolds number {reynolds:.4}"));
    text += "\n";
    text += &motion(&scene, solution);
    text += "\n";
    text += &accuracy(&scene, solution);
    let iterated = count(*iterations, "iteration");
    text += &entry(
        "steady state",
        format!("{iterated}, the last changes {change:.1e}"),
    );
    text += &cost(solution);
    and_then(text, written)
}

/// The text, which is printed at once if the command ends with an error.
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

/// Sizes below which velocities, angular velocities, forces, torques and the power are rounding.
struct Rounding {
    velocity: f64,
    angular_velocity: f64,
    force: f64,
    torque: f64,
    power: f64,
}

impl Rounding {
    /// The rounding and the error of the linear solver, of the largest numbers, and of those that
    /// would be as large: a force `6 π μ R U` for velocities `U` of bodies of the radius
    /// `R`.
    fn new(scene: &Scene, solution: &InstantaneousSolution) -> Self {
        let largest =
            |of: fn(&BodySolution) -> f64| solution.bodies.iter().map(of).fold(0.0, f64::max);
        let radii = scene.bodies().iter().map(|body| body.bounding_radius());
        let radius = radii.fold(f64::MIN_POSITIVE, f64::max);
        let speed =
            largest(|b| b.velocity.norm()).max(radius * largest(|b| b.angular_velocity.norm()));
        let force = largest(|b| b.force.norm())
            .max(largest(|b| b.torque.norm()) / radius)
            .max(6.0 * PI * scene.viscosity() * radius * speed);
        let rounding = ROUNDING.max(RESIDUAL_FACTOR * solution.solver.true_relative_residual);
        Self {
            velocity: rounding * speed,
            angular_velocity: rounding * speed / radius,
            force: rounding * force,
            torque: rounding * force * radius,
            power: rounding * force * speed,
        }
    }
}

/// A line with a label and a vector, as [`numbers`].
fn row(label: &str, v: &Vector3<f64>, bar: f64, rounding: f64) -> String {
    numbers(label, v.as_slice(), bar, rounding)
}

/// A line with a label and numbers, with the digits that their error bar leaves.
fn numbers(label: &str, list: &[f64], bar: f64, rounding: f64) -> String {
    let words = list
        .iter()
        .map(|x| format!("{:<17}", significant(*x, bar, rounding)));
    let line = format!("{label:<24}{}", words.collect::<Vec<_>>().join(" "));
    line.trim_end().to_owned() + "\n"
}

/// The error bar of a solution compared with `model.tolerance`.
///
/// It is that of the velocities, relative to the fastest point of a surface; where nothing moves,
/// that of the forces, relative to the largest.
struct Comparison {
    quantity: &'static str,
    error: f64,
    size: f64,
    tolerance: f64,
    /// Whether the model keeps its error within the tolerance.
    controls_error: bool,
}

impl Comparison {
    fn new(scene: &Scene, model: &dyn Hydrodynamics, solution: &InstantaneousSolution) -> Self {
        let speeds = scene.bodies().iter().zip(&solution.bodies);
        let speed = speeds.fold(0.0_f64, |most, (body, motion)| {
            let arc = body.bounding_radius() * motion.angular_velocity.norm();
            most.max(motion.velocity.norm()).max(arc)
        });
        let forces = solution.bodies.iter().map(|body| body.force.norm());
        let (quantity, error, size) = match speed > 0.0 {
            true => ("velocities", solution.error_estimate.total(), speed),
            false => (
                "forces",
                solution.force_error.total(),
                forces.fold(0.0, f64::max),
            ),
        };
        Self {
            quantity,
            error,
            size,
            tolerance: scene.model().tolerance,
            controls_error: model.capabilities().controls_error,
        }
    }

    fn is_met(&self) -> bool {
        self.error <= self.tolerance * self.size
    }

    /// The line about a tolerance that was missed, or does not apply.
    fn line(&self) -> String {
        let Self {
            quantity,
            tolerance,
            ..
        } = self;
        let words = match self.controls_error {
            _ if self.is_met() => return String::new(),
            true => format!("{tolerance:e} of the {quantity} is not met"),
            false => format!(
                "{tolerance:e} of the {quantity} is not met: it does not limit the errors of this \
                 model"
            ),
        };
        entry("tolerance", words)
    }

    /// A missed tolerance is an error if the user asks for it, and else a warning of models that
    /// control their error.
    fn check(&self, scene: &Scene) -> Result<(), CliError> {
        if self.is_met() {
            return Ok(());
        }
        let missed = CliError::ToleranceMissed {
            place: scene.place("model.tolerance"),
            tolerance: self.tolerance,
            quantity: self.quantity,
            allowed: self.tolerance * self.size,
            error: self.error,
            remedy: match (self.controls_error, scene.model().kind) {
                (true, _) => "increase model.tolerance",
                // `auto` chooses rpy there where expansions take long.
                (false, _) if scene.domain().period().is_some() => "set model.kind = \"multipole\"",
                // Of models that do not control their error, `auto` chooses elements alone.
                (false, ModelKind::Fem | ModelKind::Auto) => {
                    "set fem.target or reduce fem.surface_size"
                }
                (false, _) => "let model.kind = \"auto\" choose",
            },
        };
        let is_asked = scene.is_written("model.tolerance");
        match is_asked && scene.model().accept != AcceptKind::Best {
            true => Err(missed),
            false => {
                if self.controls_error {
                    warn(&missed.to_string());
                }
                Ok(())
            }
        }
    }
}

/// Rounding of a number that was solved for, relative to the largest one.
const ROUNDING: f64 = 1e-14;

/// Error of an iterative solution relative to its residual: about the condition of the
/// preconditioned systems of elements, which converge by a factor of ten in a few iterations.
const RESIDUAL_FACTOR: f64 = 10.0;

/// What the mean pressure gradient of a periodic box is, in words.
const BALANCE: &str = "forces on the fluid = pressure gradient x volume";

/// Velocities and forces of the bodies, and forces of the joints.
fn motion(scene: &Scene, solution: &InstantaneousSolution) -> String {
    let rounding = Rounding::new(scene, solution);
    let mut text = "vectors (x, y, z) in the scene's units\n".to_owned();
    for (number, (body, motion)) in scene.bodies().iter().zip(&solution.bodies).enumerate() {
        text += &entry("body", &body.name);
        let (force, torque) = (&solution.force_error, &solution.torque_error);
        for (label, vector, bars, rounding) in [
            (
                "  velocity",
                &motion.velocity,
                &solution.error_estimate,
                rounding.velocity,
            ),
            (
                "  angular velocity",
                &motion.angular_velocity,
                &solution.angular_velocity_error,
                rounding.angular_velocity,
            ),
            ("  force on the fluid", &motion.force, force, rounding.force),
            (
                "  torque on the fluid",
                &motion.torque,
                torque,
                rounding.torque,
            ),
        ] {
            text += &row(label, vector, bars.total(), rounding);
        }
        if let Some(load) = solution.holding.iter().find(|load| load.body == number) {
            let (label, bar) = ("  force that holds it", force.total());
            text += &row(label, &load.force, bar, rounding.force);
            let (label, bar) = ("  torque that holds it", torque.total());
            text += &row(label, &load.torque, bar, rounding.torque);
        }
        let stresslets = solution.stresslets.as_ref();
        if let Some(stresslet) = stresslets.and_then(|s| s.bodies.get(number)) {
            for (label, column) in ["  stresslet", "", ""]
                .into_iter()
                .zip(stresslet.column_iter())
            {
                let bar = stresslets.and_then(|s| s.error).unwrap_or(0.0);
                text += &row(label, &column.into_owned(), bar, rounding.torque);
            }
        }
    }
    if let Some(flow) = &solution.mean_flow {
        let bar = solution.mean_flow_error.total();
        let [of_flow, of_gradient] = match scene.finds_mean_flow() {
            true => [bar, 0.0],
            false => [0.0, bar],
        };
        let relative = ROUNDING.max(RESIDUAL_FACTOR * solution.solver.true_relative_residual);
        let rounding_of = |size: f64| relative * size;
        text += &entry("periodic box", BALANCE);
        let (label, velocity) = ("  mean flow", &flow.velocity);
        text += &row(label, velocity, of_flow, rounding_of(velocity.norm()));
        // The forces nearly cancel where none is given.
        let forces: f64 = solution.bodies.iter().map(|body| body.force.norm()).sum();
        let volume = scene.domain().period().map_or(1.0, |size| size.product());
        let (label, gradient) = ("  pressure gradient", &flow.pressure_gradient);
        text += &row(label, gradient, of_gradient, rounding_of(forces / volume));
    }
    let joints = scene
        .articulation()
        .joints()
        .iter()
        .zip(&solution.joint_loads);
    // Their forces are not on one body; the JSON has them.
    let joints = joints.filter(|(joint, _)| !joint.kind.is_deformation());
    for (joint, load) in joints {
        let body = &scene.bodies()[joint.body].name;
        text += &entry("link", &joint.name);
        let (force, torque) = (solution.force_error.total(), solution.torque_error.total());
        let label = format!("  force on {body}");
        text += &row(&label, &load.force, force, rounding.force);
        // Only joints that turn transmit a torque by themselves.
        if joint.kind.turns() {
            let label = format!("  torque on {body}");
            text += &row(&label, &load.torque, torque, rounding.torque);
        }
        if joint.kind.is_angle() {
            text += &numbers(
                "  torque of the drive",
                &[load.drive],
                torque,
                rounding.torque,
            );
        } else if joint.kind.has_value() {
            text += &numbers("  force of the drive", &[load.drive], force, rounding.force);
        }
    }
    text
}

/// Label, size and error bar of the mean flow through a periodic box or of its pressure gradient:
/// of the one that is a result; zero in other domains.
fn of_mean_flow(scene: &Scene, solution: &InstantaneousSolution) -> (&'static str, f64, f64) {
    let flow = solution.mean_flow.unwrap_or_default();
    let bar = solution.mean_flow_error.total();
    match scene.finds_mean_flow() {
        true => ("error of mean flow", flow.velocity.norm(), bar),
        false => (
            "error of pressure grad.",
            flow.pressure_gradient.norm(),
            bar,
        ),
    }
}

/// Error estimates and independent checks.
fn accuracy(scene: &Scene, solution: &InstantaneousSolution) -> String {
    let rounding = Rounding::new(scene, solution);
    let largest = |of: fn(&BodySolution) -> f64| solution.bodies.iter().map(of).fold(0.0, f64::max);
    // Nothing is integrated.
    let is_estimated = solution.error_estimate.estimated().is_some();
    let velocities = ErrorEstimate {
        integration: is_estimated.then_some(0.0),
        ..solution.error_estimate
    };
    let mut text = error_estimates(
        "error of velocities",
        &velocities,
        largest(|body| body.velocity.norm()),
        "the largest velocity",
    );
    let forces = largest(|body| body.force.norm());
    let forces = if forces > rounding.force { forces } else { 0.0 };
    let of_forces = solution.force_error.estimated();
    text += &entry(
        "error of forces",
        of_forces.map_or(NO_ESTIMATE.to_owned(), |bar| error(bar, forces)),
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
        of_mean_flow(scene, solution),
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
        if forces > solution.force_error.total().max(rounding.force) {
            let difference = percent(checks.force_by_stress);
            let words = format!("{difference} difference from the integral of the stress");
            text += &entry("check of forces", words);
        }
        if power.abs() > of_power.max(rounding.power) {
            let difference = percent(checks.dissipation);
            let words = format!("{difference} difference from the dissipation");
            text += &entry("check of power", words);
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missed_tolerance_is_an_error_if_it_is_asked_for_and_the_best_is_not_accepted() {
        for (keys, controls_error, exit_code) in [
            ("", true, None),
            ("model.tolerance = 1e-3", true, Some(3)),
            (
                "model = { tolerance = 1e-3, accept = \"best\" }",
                true,
                None,
            ),
            ("model.tolerance = 1e-3", false, Some(3)),
            ("", false, None),
        ] {
            let bodies = "bodies = [{ name = \"a\", radius = 1, position = [0, 0, 0] }]";
            let scene = Scene::parse(&format!("{keys}\n{bodies}")).unwrap();
            let comparison = |error: f64| Comparison {
                quantity: "velocities",
                error,
                size: 0.5,
                tolerance: scene.model().tolerance,
                controls_error,
            };
            assert!(comparison(5e-4).check(&scene).is_ok());
            assert_eq!(comparison(5e-4).line(), "");
            let missed = comparison(6e-4);
            assert!(!missed.is_met() && missed.line().starts_with("tolerance "));
            let error = missed.check(&scene).err();
            assert_eq!(error.as_ref().map(CliError::exit_code), exit_code, "{keys}");
            if let Some(error) = error {
                let message = error.to_string();
                let place = "scene.toml:1: model.tolerance = 1e-3 allows an error bar of the \
                             velocities of 5.0e-4, 6.0e-4 was reached";
                assert!(message.starts_with(place), "{message}");
            }
        }
    }
}
