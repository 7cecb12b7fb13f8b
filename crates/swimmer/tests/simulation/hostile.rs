//! Programs that pass what was not meant: refused, never answered in silence, never a panic.

use nalgebra::{UnitQuaternion, Vector3};
use rigid::State;
use swimmer::models::{
    AccumulatedError, Configuration, FemModel, History, Hydrodynamics, InstantaneousSolution,
    ModelError, Query, ShapeSpace, SphereModel, SpheresModel, Tabulated,
};
use swimmer::output::trajectory_csv;
use swimmer::{
    Integrator, Interim, Method, Scene, SwimError, choose, continue_from, simulate, solve_start,
    spans, start_flow, start_resistance,
};

use crate::support::{Tensor, TestModel, scene, three_spheres};

fn rpy(text: &str) -> Scene {
    scene(&three_spheres("model.kind = \"rpy\"", text))
}

fn spheres(scene: &Scene) -> SpheresModel {
    SpheresModel::new(scene, SphereModel::Rpy).unwrap()
}

const UNBOUNDED: &str = "{ kind = \"unbounded\" }";
const BALL: &str = "{ kind = \"ball\", radius = 30 }";

fn is_other_scene<T>(result: Result<T, SwimError>) -> bool {
    matches!(result.map(|_| ()), Err(error @ SwimError::OtherScene { .. }) if error.exit_code() == 2)
}

#[test]
fn bug_the_model_of_another_scene_gave_a_wrong_displacement() {
    let (own, other) = (rpy(UNBOUNDED), rpy(BALL));
    let simulated = |model: &mut dyn Hydrodynamics| {
        simulate(&own, model, Method::Collocation, &mut ()).map(|outcome| outcome.net())
    };
    assert!(simulated(&mut spheres(&own)).is_ok());
    // options may differ: they change error bars only
    let sharper = own.with_tolerance(1e-5).unwrap();
    assert!(simulated(&mut spheres(&sharper)).is_ok());
    let mut models: [Box<dyn Hydrodynamics>; 3] = [
        choose(&other).unwrap().model,
        Box::new(TestModel::new(&other, Tensor::Rpy)),
        Box::new(Tabulated::new(
            &own,
            Box::new(spheres(&other)),
            vec![],
            1e-5,
        )),
    ];
    for model in &mut models {
        let model = model.as_mut();
        assert!(is_other_scene(simulated(model)));
        assert!(is_other_scene(solve_start(&own, model)));
        assert!(is_other_scene(start_resistance(&own, model)));
        assert!(is_other_scene(start_flow(&own, model)));
        let interim = Interim::start(&own).unwrap();
        assert!(is_other_scene(continue_from(
            &own,
            model,
            Method::RungeKutta,
            &mut (),
            interim
        )));
        let span = spans(own.gait(), own.articulation().initial_shape())
            .unwrap()
            .next()
            .unwrap();
        let mut integrator = Integrator::new(&own, model, Method::Collocation);
        assert!(is_other_scene(integrator.span(
            &span,
            &own.initial_state(),
            &mut |_, _| Ok(())
        )));
        let table = ShapeSpace::tabulate(&own, model, &[(6.0, 10.0), (10.0, 10.0)], 1e-3);
        assert!(matches!(
            table.map(|_| ()),
            Err(ModelError::ShapeSpace { .. })
        ));
    }
}

/// The first joint of [`three_spheres`].
const LINK: &str = "body = \"left\"\n        to = \"centre\"";

#[test]
fn every_part_of_the_flow_problem_is_compared() {
    let text = three_spheres("fluid.viscosity = 1", BALL);
    let own = scene(&text);
    for (before, after) in [
        ("viscosity = 1", "viscosity = 2"),
        ("radius = 30", "radius = 31"),
        ("radius = 1\n", "radius = 1.5\n"),
        ("position = [10, 0, 0]", "position = [10, 0, 1]"),
        (
            "position = [10, 0, 0]",
            "position = [10, 0, 0]\n        force = [1, 0, 0]",
        ),
        (
            "position = [10, 0, 0]",
            "position = [10, 0, 0]\n        torque = [1, 0, 0]",
        ),
        (LINK, "body = \"centre\"\n        to = \"left\""),
        ("fluid.viscosity = 1", "gait.arms = \"free\""),
    ] {
        let other = scene(&text.replacen(before, after, 1));
        let key = own.differing_key(&other).expect(after);
        assert_eq!(other.differing_key(&own), Some(key));
    }
    let same = scene(
        &text
            .replace("length = 6", "length = 7")
            .replace("left-arm", "arm"),
    );
    assert_eq!(own.differing_key(&same), None);
}

#[test]
fn bug_methods_without_steps_took_one_step() {
    let scene = rpy(UNBOUNDED);
    for method in [
        Method::Euler { steps: 0 },
        Method::BackwardEuler { steps: 0 },
        Method::ExplicitInertia { steps: 0 },
    ] {
        let refused = simulate(&scene, &mut spheres(&scene), method, &mut ()).map(|_| ());
        assert!(matches!(refused, Err(SwimError::NoSteps)), "{method:?}");
    }
}

/// A model that returns other numbers of solutions, bodies or frames than it should, or NaN.
struct Faulty {
    model: SpheresModel,
    fault: usize,
}

impl Hydrodynamics for Faulty {
    fn name(&self) -> &'static str {
        "faulty"
    }

    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        let mut solutions = self.model.solve(query)?;
        if let Some(solution) = solutions.first_mut() {
            match self.fault {
                0 => solution.bodies.truncate(1),
                1 => solution.motion.frames.clear(),
                2 => solution.motion.spins.clear(),
                3 => solution.motion.frames[0].linear.x = f64::NAN,
                4 => solution.bodies[1].force.y = f64::INFINITY,
                _ => solutions.clear(),
            }
        }
        Ok(solutions)
    }
}

#[test]
fn faulty_models_are_refused() {
    let scene = rpy(UNBOUNDED);
    for fault in 0..6 {
        for method in [
            Method::Collocation,
            Method::RungeKutta,
            Method::Euler { steps: 2 },
        ] {
            let mut model = Faulty {
                model: spheres(&scene),
                fault,
            };
            assert!(
                simulate(&scene, &mut model, method, &mut ()).is_err(),
                "{fault} {method:?}"
            );
        }
        let mut model = Faulty {
            model: spheres(&scene),
            fault,
        };
        let ranges = [(6.0, 10.0), (10.0, 10.0)];
        assert!(
            ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-3).is_err(),
            "{fault}"
        );
        assert!(solve_start(&scene, &mut model).is_err(), "{fault}");
    }
}

#[test]
fn hostile_configurations_are_refused_by_every_model() {
    let scene = rpy(BALL);
    let fem = scene_with_coarse_mesh();
    let state = scene.initial_state();
    let mut lost = state.clone();
    lost.frames[0].translation.vector = Vector3::repeat(f64::NAN);
    let mut twisted = state.clone();
    twisted.attitudes[0] =
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(2.0, 0.0, 0.0, 0.0));
    let empty = State {
        frames: vec![],
        attitudes: vec![],
        joints: vec![],
    };
    let models: [Box<dyn Hydrodynamics>; 3] = [
        Box::new(spheres(&scene)),
        Box::new(SpheresModel::new(&scene, SphereModel::Multipole(1e-4)).unwrap()),
        Box::new(FemModel::new(&fem).unwrap()),
    ];
    let (sound, rates) = (vec![10.0, 10.0], vec![1.0, 0.0]);
    for mut model in models {
        let name = model.name();
        let mut refuses = |state: &State, shape: &[f64], rates: &[f64]| {
            let configuration = Configuration { state, shape };
            assert!(
                model.solve_one(configuration, rates).is_err(),
                "{name} {shape:?} {rates:?}"
            );
        };
        for state in [&lost, &twisted, &empty] {
            refuses(state, &sound, &rates);
        }
        for x in [0.0, -1.0, 1e-320, 1e300, f64::NAN, f64::INFINITY] {
            refuses(&state, &[x, 10.0], &rates);
        }
        refuses(&state, &[10.0], &rates);
        refuses(&state, &[], &[]);
        refuses(&state, &sound, &[f64::NAN, 0.0]);
        refuses(&state, &sound, &[]);
        assert!(model.restore(&History::new(&"noise").unwrap()).is_err());
    }
}

/// The three spheres in a ball, with coarse finite elements.
fn scene_with_coarse_mesh() -> Scene {
    scene(&three_spheres(
        "model.kind = \"fem\"\n        fem.surface_size = 1.5",
        BALL,
    ))
}

#[test]
fn tables_outside_their_box_are_refused() {
    let scene = rpy(UNBOUNDED);
    let mut model = spheres(&scene);
    let ranges = [(6.0, 10.0), (10.0, 10.0)];
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(ShapeSpace::tabulate(&scene, &mut model, &ranges, tolerance).is_err());
    }
    for x in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
        let bad = [(6.0, x), (10.0, 10.0)];
        assert!(
            ShapeSpace::tabulate(&scene, &mut model, &bad, 1e-2).is_err(),
            "{x}"
        );
    }
    let space = ShapeSpace::tabulate(&scene, &mut model, &ranges, 1e-2).unwrap();
    let state = scene.initial_state();
    let empty = State {
        frames: vec![],
        attitudes: vec![],
        joints: vec![],
    };
    assert!(space.connection(&[7.0, 10.0]).is_ok() && space.metric(&[7.0, 10.0]).is_ok());
    for shape in [
        &[5.0, 10.0][..],
        &[7.0],
        &[],
        &[f64::NAN, 10.0],
        &[7.0, 9.0],
    ] {
        assert!(space.connection(shape).is_err() && space.metric(shape).is_err());
        let at = Configuration {
            state: &state,
            shape,
        };
        assert!(space.solution(at, &[1.0, 0.0]).is_err());
    }
    for (state, rates) in [
        (&state, &[1.0][..]),
        (&state, &[1.0, 1.0]),
        (&empty, &[1.0, 0.0]),
    ] {
        let at = Configuration {
            state,
            shape: &[7.0, 10.0],
        };
        assert!(space.solution(at, rates).is_err());
    }
}

#[test]
fn reports_of_incomplete_outcomes_do_not_panic() {
    let scene = rpy(UNBOUNDED);
    let mut outcome = simulate(&scene, &mut spheres(&scene), Method::Collocation, &mut ()).unwrap();
    outcome.samples[1].bodies = Some(vec![]);
    outcome.samples[2].shape.clear();
    assert!(trajectory_csv(&scene, &outcome.samples).lines().count() > 4);
    assert_eq!(trajectory_csv(&scene, &[]).lines().count(), 1);
    outcome.displacement.clear();
    assert_eq!(outcome.net(), 0.0);
    let mut interim = Interim::start(&scene).unwrap();
    interim.state.frames.clear();
    let resumed = continue_from(
        &scene,
        &mut spheres(&scene),
        Method::Collocation,
        &mut (),
        interim,
    );
    assert!(resumed.is_err());
    let mut sum = AccumulatedError {
        displacement: vec![Vector3::x()],
        ..AccumulatedError::default()
    };
    sum.append(&AccumulatedError::default(), &[]);
    assert_eq!(sum.displacement, [Vector3::x()]);
    let empty = nalgebra::DMatrix::zeros(0, 2);
    let _ = ModelError::not_positive_definite("empty matrix", &empty, "fill it").to_string();
}
