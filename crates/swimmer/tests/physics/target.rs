//! Meshes adapted to a target error, compared with exact values.

use std::f64::consts::PI;

use approx::assert_relative_eq;
use swimmer::models::{FemModel, Hydrodynamics};
use swimmer::{
    Leg, LegResult, LegSolution, Method, Observer, Outcome, Scene, SwimError, Trial, TrialObserver,
    simulate, size_factor_for_target, solve_start,
};

/// Two unit spheres pushed towards each other along their line of centres in a ball of radius 60.
fn pair(distance: f64, more: &str) -> Scene {
    let sphere = |name: &str, x: f64| {
        format!(
            "[[bodies]]\nname = \"{name}\"\nradius = 1\nposition = [{x:?}, 0, 0]\nforce = [{:?}, 0, 0]\n",
            -x.signum()
        )
    };
    let text = format!(
        "domain = {{ kind = \"ball\", radius = 60 }}\nmodel.kind = \"fem\"\n{more}\n{}{}",
        sphere("a", -0.5 * distance),
        sphere("b", 0.5 * distance)
    );
    Scene::parse(&text).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

/// Degrees of freedom and true relative error of the speed of two approaching spheres at a distance
/// of 2.5.
fn approach(more: &str) -> (usize, f64) {
    // Stimson & Jeffery 1926, Maude 1961: force over 6 pi U. The forces are opposite, so the effect
    // of the wall is below (2.5 / 60)^3.
    let exact = 1.0 / (6.0 * PI * 2.772418679559134);
    let scene = pair(2.5, more);
    let instant = solve_start(&scene, &mut FemModel::new(&scene).unwrap()).unwrap();
    let speed = 0.5 * (instant.bodies[0].velocity.x - instant.bodies[1].velocity.x);
    (instant.dofs.total, (speed / exact - 1.0).abs())
}

#[test]
fn adapted_meshes_meet_their_target_with_fewer_dofs_than_uniform_growth() {
    let target = 5e-4;
    let (adapted, error) = approach(&format!("fem.target = {target:?}"));
    // Within a factor two, on either side.
    assert!(
        (0.25 * target..=target).contains(&error),
        "{adapted} degrees of freedom, {error:.2e}"
    );
    // The coarsest equally accurate mesh whose sizes grow from the bodies at the best rate for a
    // sphere.
    let graded = [0.6, 0.5, 0.4, 0.3]
        .map(|size| approach(&format!("fem.surface_size = {size:?}")))
        .into_iter()
        .find(|(_, graded)| *graded <= error);
    assert!(
        graded.is_none_or(|(dofs, _)| adapted < dofs),
        "{adapted} against {graded:?}"
    );
}

#[test]
fn a_given_size_factor_is_kept() {
    let fixed = approach("fem = { target = 1e-6, size_factor = 1.5 }");
    let plain = approach("fem.size_factor = 1.5");
    assert_eq!(fixed, plain);
    let scene = pair(4.0, "fem = { target = 1e-6, size_factor = 1.5 }");
    let chosen = size_factor_for_target(&scene, &mut NoStroke).unwrap();
    assert_eq!(chosen, None);
}

#[test]
#[ignore = "two minutes: strokes on four meshes"]
fn strokes_meet_their_target_error() {
    // Spectral, ball of 40.
    let exact = 0.1604180159643671;
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../../scenes/three-sphere.toml"
    ))
    .unwrap();
    for target in [1e-2, 1e-3] {
        let mut scene = Scene::parse(&format!("{text}\n[fem]\ntarget = {target:?}\n")).unwrap();
        let chosen = size_factor_for_target(&scene, &mut ()).unwrap();
        scene = scene.with_size_factor(chosen).unwrap();
        let mut model = FemModel::new(&scene).unwrap();
        let outcome = simulate(&scene, &mut model, Method::Collocation, &mut ()).unwrap();
        let error = (outcome.displacement[1].x / exact - 1.0).abs();
        let bar = outcome.error_estimate.mesh.unwrap() / outcome.net();
        assert!(
            error <= 1.4 * bar && bar <= 1.5 * target,
            "{target:e}: {error:.2e} {bar:.2e}"
        );
    }
}

/// Panics at the first trial stroke.
struct NoStroke;

impl Observer for NoStroke {}

impl TrialObserver for NoStroke {
    fn tried(&mut self, _: &Trial) {
        panic!("a stroke was tried");
    }
}

/// Keeps the first trial, and ends the simulation at the next one.
#[derive(Default)]
struct FirstTrial {
    trial: Option<Trial>,
    /// Relative error of the net displacement after the last leg.
    relative_error: f64,
}

impl Observer for FirstTrial {
    fn solved(&mut self, _: &Leg, _: &LegSolution, _: &dyn Hydrodynamics) -> Result<(), SwimError> {
        match self.trial {
            None => Ok(()),
            Some(_) => Err(SwimError::NoSteps),
        }
    }

    fn leg_done(
        &mut self,
        _: &Leg,
        _: &LegResult,
        so_far: &Outcome,
        _: &dyn Hydrodynamics,
    ) -> Result<(), SwimError> {
        self.relative_error = so_far.error_estimate.mesh.unwrap() / so_far.net();
        Ok(())
    }
}

impl TrialObserver for FirstTrial {
    fn tried(&mut self, trial: &Trial) {
        self.trial = Some(*trial);
    }
}

/// A swimmer with short arms in a small ball that closes one of them, which takes a fifth of a
/// second on a coarse mesh.
fn swimmer_with_target(target: f64) -> Scene {
    Scene::parse(&format!(
        r#"
        domain = {{ kind = "ball", radius = 12 }}
        model = {{ kind = "fem", tolerance = 0.1 }}
        fem.target = {target:?}
        bodies = [
            {{ name = "l", radius = 1, position = [-4, 0, 0] }},
            {{ name = "c", radius = 1, position = [0, 0, 0] }},
            {{ name = "r", radius = 1, position = [4, 0, 0] }},
        ]
        links = [
            {{ name = "left", body = "l", to = "c" }},
            {{ name = "right", body = "r", to = "c" }},
        ]
        gait.phases = [{{ link = "left", length = 3 }}]
        "#
    ))
    .unwrap()
}

#[test]
fn sizes_for_a_target_follow_from_the_error_of_the_coarsest_mesh() {
    let choose_with = |target: f64| {
        let mut observer = FirstTrial::default();
        let chosen = size_factor_for_target(&swimmer_with_target(target), &mut observer);
        (chosen, observer)
    };
    // A target above the error: the coarsest mesh meets it.
    let (chosen, observer) = choose_with(0.9);
    let trial = observer.trial.unwrap();
    assert_eq!(trial.size_factor, FemModel::COARSEST_SIZE_FACTOR);
    assert_eq!(trial.relative_error, observer.relative_error);
    assert!(trial.relative_error < 0.1, "{trial:?}");
    assert_eq!(chosen.unwrap(), Some(trial.size_factor));
    // Below the error, the sizes are extrapolated to 0.6 of the target with the order 4.
    let target = 0.5 * trial.relative_error;
    let (chosen, observer) = choose_with(target);
    let again = observer.trial.unwrap();
    let expected = again.size_factor * (0.6 * target / again.relative_error).powf(1.0 / 4.0);
    assert_relative_eq!(chosen.unwrap().unwrap(), expected, max_relative = 1e-14);
    // Far below the error, a second trial precedes the extrapolation.
    let (chosen, _) = choose_with(1e-3 * trial.relative_error);
    assert!(matches!(chosen, Err(SwimError::NoSteps)), "{chosen:?}");
}
