//! Elements in a fluid whose viscosity depends on the shear rate: units, refusals.

use models::{
    AxisymmetricModel, FemModel, Hydrodynamics, InstantaneousSolution, NeglectedTerm, PathPoint,
};
use scene::Scene;
use testkit::{SceneText, contains, within};

use crate::scenes::solve_at_start;

/// A pair of spheres with a slide, in units of this length.
fn pair(length: f64, fluid: &str) -> SceneText {
    let at = |x: f64| [x * length, 0.0, 0.0];
    SceneText::new()
        .sphere("a", length, at(-1.6))
        .sphere("b", length, at(1.6))
        .slide("arm", "b", "a")
        .with("fluid", format!("{{ {fluid} }}"))
        .elements(1.2 * length)
}

fn in_ball(length: f64, fluid: &str) -> Scene {
    pair(length, fluid).ball(5.0 * length).scene()
}

fn carreau(viscosity: f64) -> String {
    format!(
        "law = \"carreau\", zero_shear_viscosity = {viscosity:?}, relaxation_time = 3, index = 0.5"
    )
}

const POWER_LAW: &str = "law = \"power-law\", consistency = 1, index = 0.5";

fn solution(scene: &Scene, rate: f64) -> InstantaneousSolution {
    solve_at_start(&mut FemModel::new(scene).unwrap(), &[rate])
}

/// Rates stay in the time of the scene: lengths and viscosities alone are scaled.
#[test]
fn thinning_is_the_same_in_other_units() {
    let (length, viscosity) = (1.0 / 1024.0, 4.0);
    let reference = solution(&in_ball(1.0, &carreau(1.0)), 0.7);
    let other = solution(&in_ball(length, &carreau(viscosity)), 0.7 * length);
    let force = viscosity * length * length;
    for (found, reference) in other.bodies.iter().zip(&reference.bodies) {
        let difference = found.force / force - reference.force;
        within(
            difference.norm(),
            1e-7 * reference.force.norm(),
            "the tolerance of the solver",
        );
    }
    let power = other.power() / (force * length) / reference.power() - 1.0;
    within(power, 1e-7, "the tolerance of the solver");
    // It thins: at the half rate the force is more than a half.
    let half = solution(&in_ball(1.0, &carreau(1.0)), 0.35);
    let ratio = half.bodies[1].force.x / reference.bodies[1].force.x;
    assert!((0.55..0.75).contains(&ratio), "{ratio}");
}

/// The bar is twice the change by the regularisation to first order.
#[test]
fn the_effect_of_the_regularisation_is_a_bar() {
    let bar = |regularisation: f64| {
        let scene = in_ball(
            1.0,
            &format!("{POWER_LAW}, regularisation = {regularisation}"),
        );
        let solution = solution(&scene, 1.0);
        (
            solution.bodies[1].force.x,
            solution.force_error.model.unwrap(),
        )
    };
    let [(coarse, bar_of_coarse), (fine, bar_of_fine)] = [0.1, 1e-3].map(bar);
    let difference = (coarse - fine).abs();
    assert!(bar_of_fine < 0.1 * bar_of_coarse);
    let ratio = bar_of_coarse / difference;
    assert!(
        (1.0..4.0).contains(&ratio),
        "{bar_of_coarse:e} {difference:e}"
    );
}

#[test]
fn what_needs_a_linear_flow_is_refused_with_its_key() {
    let scene = in_ball(1.0, &carreau(1.0));
    let state = scene.initial_state();
    let configuration = testkit::at(&state, scene.articulation().initial_shape());
    let mut model = FemModel::new(&scene).unwrap();
    let refusal = model.resistances().unwrap().resistance(configuration);
    contains(
        "refusal",
        &refusal.unwrap_err().to_string(),
        &["--set fluid=", "shear rate", "newtonian"],
    );
    let at = PathPoint {
        configuration,
        rates: &[1.0],
        accelerations: &[0.0],
    };
    let inertia = NeglectedTerm::Inertia;
    let refusal = (model.neglected(inertia).unwrap()).change(inertia, &at);
    contains(
        "refusal",
        &refusal.unwrap_err().to_string(),
        &["--set fluid=", "inertia"],
    );
    let scene = pair(1.0, POWER_LAW).scene();
    let state = scene.initial_state();
    let configuration = testkit::at(&state, scene.articulation().initial_shape());
    let refusal = FemModel::new(&scene)
        .unwrap()
        .solve_one(configuration, &[1.0]);
    contains(
        "refusal",
        &refusal.unwrap_err().to_string(),
        &["--set fluid=", "ball"],
    );
}

/// Below its yield stress a fluid does not flow.
#[test]
fn a_load_far_below_the_yield_stress_is_refused_with_a_remedy() {
    let scene = SceneText::new()
        .ball(5.0)
        .shape("s", "radius = 1, force = [1, 0, 0]", [0.0; 3])
        .with(
            "fluid",
            "{ law = \"herschel-bulkley\", consistency = 1, index = 0.5, yield_stress = 3 }",
        )
        .scene();
    let state = scene.initial_state();
    let solve = FemModel::new(&scene)
        .unwrap()
        .solve_one(testkit::at(&state, &[]), &[]);
    let error = solve.unwrap_err();
    assert!(!error.is_bad_input());
    let words = ["hardly moves", "unit", "yield stress", "regularisation"];
    contains("refusal", &error.to_string(), &words);
}

/// Viscosities from 1e6 at rest to 1: the force of elements in space is that of the meridian plane.
#[test]
fn viscosities_may_differ_by_a_million() {
    let text = SceneText::new()
        .ball(5.0)
        .shape(
            "s",
            "radius = 1, velocity = [1, 0, 0], angular_velocity = [0, 0, 0]",
            [0.0; 3],
        )
        .with(
            "fluid",
            "{ law = \"carreau\", zero_shear_viscosity = 1e6, infinite_shear_viscosity = 1, \
             relaxation_time = 1e9, index = 0.3 }",
        );
    let scene = text.scene();
    let found = solve_at_start(&mut FemModel::new(&scene).unwrap(), &[]);
    let exact = solve_at_start(&mut AxisymmetricModel::new(&scene).unwrap(), &[]);
    let [bar, exact_bar] = [&found, &exact].map(|s| s.force_error.total());
    let force = exact.bodies[0].force.x;
    assert!(
        bar < 0.01 * force && exact_bar < 1e-4 * force,
        "{bar:e} {exact_bar:e}"
    );
    within(
        found.bodies[0].force.x - force,
        bar + exact_bar,
        "the error bars",
    );
}

/// The power of given forces changes with the velocities: there was no bar for it.
#[test]
fn bug_the_power_of_given_forces_had_no_bar_for_the_regularisation() {
    let solve = |regularisation: f64| {
        let scene = SceneText::new()
            .ball(5.0)
            .shape("s", "radius = 1, force = [20, 0, 0]", [0.0; 3])
            .with(
                "fluid",
                format!("{{ {POWER_LAW}, regularisation = {regularisation} }}"),
            )
            .scene();
        solve_at_start(&mut FemModel::new(&scene).unwrap(), &[])
    };
    let [coarse, fine] = [0.1, 1e-3].map(solve);
    let difference = (coarse.power() - fine.power()).abs();
    let bars = [&coarse, &fine].map(|solution| solution.power_error.model.unwrap());
    assert!(difference > 1e-3 * fine.power(), "{difference:e}");
    within(difference, bars[0], "the bar of the regularisation");
    assert!(
        bars[0] < 10.0 * difference && bars[1] < 0.1 * bars[0],
        "{bars:?} {difference:e}"
    );
}
