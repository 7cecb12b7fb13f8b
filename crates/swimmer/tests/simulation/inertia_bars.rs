//! Error bars and decisions in fluids with inertia, with and without a viscosity law.

use scene::Scene;
use swimmer::{Outcome, run_without_files, solve_start_with_terms, solve_steady};
use testkit::within;

fn parsed(text: &str) -> Scene {
    Scene::parse(text).unwrap()
}

fn outcome(text: &str) -> Outcome {
    let report = run_without_files(parsed(text), &mut ()).unwrap();
    report.completed().unwrap().outcome
}

/// A sphere in a ball of five radii with these keys, of the fluid and of the sphere.
fn in_ball(kind: &str, fluid: &str, sphere: &str) -> String {
    format!(
        "fluid = {{ {fluid} }}\ndomain = {{ kind = \"ball\", radius = 5 }}\n\
         model = {{ kind = \"{kind}\", tolerance = 1e-2, accept = \"best\" }}\n\
         bodies = [{{ name = \"s\", radius = 1, position = [0, 0, 0], {sphere} }}]\n"
    )
}

/// The prediction of the net displacement was rounding, and no step was short enough for the
/// tolerance that followed.
#[test]
fn bug_a_sphere_that_oscillates_with_inertia_could_not_be_integrated() {
    let scene = in_ball(
        "axisymmetric",
        "density = 2, inertia = \"full\"",
        "velocity = { amplitude = [0.5, 0, 0], period = 0.4 }",
    );
    let found = outcome(&format!("{scene}gait.phases = [{{ duration = 0.4 }}]"));
    let error = found.displacement[0].x;
    let bar = found.error_estimate.total();
    within(error, bar, "displacement after a period");
    // the tolerance is relative to the radius
    assert!(bar < 1e-2, "{bar}");
}

/// Where the layer of vorticity was thinner than the elements, errors were 2.3, 2.0 and 1.1 times
/// their bars.
#[test]
fn bug_bars_of_starts_shorter_than_layers_grow_through_elements_were_too_small() {
    for duration in [1e-4, 1e-3, 1e-2] {
        let [plane, space] = ["axisymmetric", "fem"].map(|kind| {
            let step = duration / 20.0;
            let fluid = format!("density = 1, inertia = \"full\", time_step = {step:e}");
            let scene = in_ball(kind, &fluid, "force = [10, 0, 0]");
            outcome(&format!(
                "{scene}gait.phases = [{{ duration = {duration:e} }}]"
            ))
        });
        let [exact, found] = [&plane, &space].map(|outcome| outcome.displacement[0].x);
        // Both have the same steps, so that only the error of the mesh differs.
        let bar = space.error_estimate.mesh.unwrap() + plane.error_estimate.mesh.unwrap();
        println!("{duration:e}: {:.2}", (found - exact).abs() / bar);
        within(
            found - exact,
            bar,
            format!("displacement after {duration:e}"),
        );
        assert!(bar < exact, "{bar}");
    }
}

/// The bar of a force that is given was the relative error of all velocities and forces.
#[test]
fn bug_given_forces_of_steady_states_in_the_meridian_plane_had_bars() {
    let fluid = "law = \"herschel-bulkley\", consistency = 1, index = 0.7, yield_stress = 1, \
                 regularisation = 1e-2, density = 1";
    let steady = solve_steady(
        &parsed(&in_ball("axisymmetric", fluid, "force = [1, 0, 0]")),
        &mut (),
    );
    let solution = steady.unwrap().solution;
    let force = solution.bodies[0].force.x;
    within(force - 1.0, 1e-6, "the given force");
    // The residual of Newton's method.
    assert!(
        solution.force_error.total() < 1e-6,
        "{:?}",
        solution.force_error
    );
    assert!(solution.error_estimate.total() > 0.0);
    assert_eq!(solution.error_estimate.model, Some(0.0));
}

const POWER_LAW: &str = "law = \"power-law\", consistency = 1, index = 0.6, regularisation = 1e-2";

/// Two coarser meshes were solved on, and the error of a law by its regularisation was said to be
/// zero where it was not estimated.
#[test]
fn bug_steady_states_had_estimates_that_were_off() {
    let text = in_ball(
        "fem",
        &format!("{POWER_LAW}, density = 1"),
        "velocity = [1, 0, 0]",
    );
    let off = format!("{text}fem = {{ size_factor = 1.75, estimates = \"off\" }}");
    let solution = solve_steady(&parsed(&off), &mut ()).unwrap().solution;
    assert_eq!(solution.force_error.mesh, None);
    // The effect of the regularisation costs one solve, and is estimated always.
    assert!(solution.force_error.model.is_some_and(|bar| bar > 0.0));
    let stokes = off.replace(", density = 1", "");
    let start =
        solve_start_with_terms(parsed(&stokes), &swimmer::choose_for_start, &mut ()).unwrap();
    assert_eq!(start.solution.force_error.model, None);
}

/// Ten times the regularisation changes a run by more than the rest of the regularisation.
#[test]
#[ignore = "slow: 60 s"]
fn bug_runs_with_inertia_had_no_bar_of_the_regularisation() {
    for law in ["power-law", "herschel-bulkley"] {
        let fall = |kind: &str, regularisation: f64| {
            let stress = if law == "power-law" {
                ""
            } else {
                "yield_stress = 0.1, "
            };
            let fluid = format!(
                "law = \"{law}\", {stress}consistency = 1, index = 0.6, density = 1, \
                 inertia = \"unsteady\", regularisation = {regularisation:?}"
            );
            let scene = in_ball(kind, &fluid, "density = 2");
            let gait = "gravity = [4.5, 0, 0]\n";
            let found = outcome(&format!(
                "{gait}{scene}gait.phases = [{{ duration = 0.5 }}]"
            ));
            assert!(
                found.error_estimate.model.is_some(),
                "{:?}",
                found.error_estimate
            );
            (found.displacement[0].x, found.error_estimate.total())
        };
        let (exact, _) = fall("axisymmetric", 1e-4);
        for (kind, regularisation) in [
            ("axisymmetric", 2e-2),
            ("axisymmetric", 5e-3),
            ("fem", 2e-2),
        ] {
            let (found, bar) = fall(kind, regularisation);
            let what = format!("{law} in {kind} at {regularisation}");
            println!("{what}: {found} {bar} {exact}");
            within(found - exact, bar, what);
        }
    }
}

/// At velocities that are given a viscosity law was neglected whatever it did to the forces, and
/// steady states neglected it silently.
#[test]
fn bug_auto_neglected_laws_where_velocities_are_given() {
    let fluid = "law = \"carreau\", zero_shear_viscosity = 1, relaxation_time = 1, index = 0.5, \
                 rheology = \"auto\"";
    let text = in_ball("axisymmetric", fluid, "velocity = [1, 0, 0]");
    let start = solve_start_with_terms(parsed(&text), &swimmer::choose_for_start, &mut ()).unwrap();
    assert!(start.decision.unwrap().contains("kept"));
    let full = text.replace("auto", "full");
    let full = solve_start_with_terms(parsed(&full), &swimmer::choose_for_start, &mut ()).unwrap();
    let [auto, full] = [start.solution, full.solution].map(|s| s.bodies[0].force.x);
    assert_eq!(auto, full);
    let steady = text.replace("rheology", "density = 1, rheology");
    let error = solve_steady(&parsed(&steady), &mut ()).unwrap_err();
    assert!(error.to_string().contains("fluid.rheology"), "{error}");
}

/// The remedies were words of the library and of meshes with errors.
#[test]
fn bug_steady_states_without_a_solution_had_no_remedy() {
    for (density, keys, remedy) in [
        (1e4, "", "smaller elements"),
        (1.0, "solver = \"minres\",", "fem.solver = \"block\""),
    ] {
        let text = in_ball(
            "fem",
            &format!("density = {density:?}"),
            "velocity = [1, 0, 0]",
        );
        let text = format!("{text}fem = {{ {keys} size_factor = 1.75 }}");
        let error = solve_steady(&parsed(&text), &mut ())
            .unwrap_err()
            .to_string();
        assert!(error.contains(remedy), "{error}");
    }
}
