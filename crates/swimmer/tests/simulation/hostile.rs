//! Programs that pass what was not meant: refused, never answered in silence, never a panic.

use nalgebra::{UnitQuaternion, Vector3};
use rigid::State;
use swimmer::models::{
    AccumulatedError, Configuration, FemModel, History, Hydrodynamics, ModelError, ShapeSpace,
    SphereModel, SpheresModel, Tabulated,
};
use swimmer::output::trajectory_csv;
use swimmer::{
    Integrator, Interim, Method, Scene, SwimError, choose, continue_from, simulate, solve_start,
    spans, start_flow, start_resistance,
};

use testkit::{Recording, three_spheres};

use crate::support::{Tensor, TestModel};

fn rpy() -> Scene {
    three_spheres().with("model.kind", "rpy").scene()
}

fn in_ball() -> Scene {
    three_spheres().with("model.kind", "rpy").ball(30.0).scene()
}

fn spheres(scene: &Scene) -> SpheresModel {
    SpheresModel::new(scene, SphereModel::Rpy).unwrap()
}

const RANGES: [(f64, f64); 2] = [(6.0, 10.0), (10.0, 10.0)];

fn empty_state() -> State {
    State {
        frames: vec![],
        attitudes: vec![],
        joints: vec![],
    }
}

fn is_other_scene<T>(result: Result<T, SwimError>) -> bool {
    matches!(result.map(|_| ()), Err(error @ SwimError::OtherScene { .. }) if error.exit_code() == 2)
}

#[test]
fn bug_the_model_of_another_scene_gave_a_wrong_displacement() {
    let (own, other) = (rpy(), in_ball());
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
        let continued = continue_from(&own, model, Method::RungeKutta, &mut (), interim);
        assert!(is_other_scene(continued));
        let mut spans = spans(own.gait(), own.articulation().initial_shape()).unwrap();
        let (span, state) = (spans.next().unwrap(), own.initial_state());
        let mut integrator = Integrator::new(&own, model, Method::Collocation);
        assert!(is_other_scene(integrator.span(
            &span,
            &state,
            &mut |_, _| Ok(())
        )));
        drop(integrator);
        let table = ShapeSpace::tabulate(&own, model, &RANGES, 1e-3).map(|_| ());
        assert!(matches!(table, Err(ModelError::ShapeSpace { .. })));
    }
}

#[test]
fn every_part_of_the_flow_problem_is_compared() {
    let text = three_spheres().ball(30.0);
    let own = text.scene();
    for settings in [
        &["fluid.viscosity=2"][..],
        &["domain.radius=31"],
        &["bodies.left.radius=1.5"],
        &["bodies.right.position=[10, 0, 1]"],
        &["bodies.right.force=[1, 0, 0]"],
        &["bodies.right.torque=[1, 0, 0]"],
        &["links.left-arm.body=centre", "links.left-arm.to=left"],
        &["gait.arms=free"],
    ] {
        let other = text.clone().set(settings).scene();
        let key = own.differing_key(&other).expect(settings[0]);
        assert_eq!(other.differing_key(&own), Some(key));
    }
    let same = text.set(&["gait.phases.0.length=7", "gait.phases.1.length=7"]);
    let arm = [
        "gait.phases.0.link=arm",
        "gait.phases.2.link=arm",
        "links.left-arm.name=arm",
    ];
    assert_eq!(own.differing_key(&same.set(&arm).scene()), None);
}

#[test]
fn bug_methods_without_steps_took_one_step() {
    let scene = rpy();
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
fn faulty(scene: &Scene, fault: usize) -> Recording<'_> {
    Recording::changing(spheres(scene), move |_, solutions| {
        if let Some(solution) = solutions.first_mut() {
            match fault {
                0 => solution.bodies.truncate(1),
                1 => solution.motion.frames.clear(),
                2 => solution.motion.spins.clear(),
                3 => solution.motion.frames[0].linear.x = f64::NAN,
                4 => solution.bodies[1].force.y = f64::INFINITY,
                _ => solutions.clear(),
            }
        }
    })
}

#[test]
fn faulty_models_are_refused() {
    let scene = rpy();
    for fault in 0..6 {
        let euler = Method::Euler { steps: 2 };
        for method in [Method::Collocation, Method::RungeKutta, euler] {
            let outcome = simulate(&scene, &mut faulty(&scene, fault), method, &mut ());
            assert!(outcome.is_err(), "{fault} {method:?}");
        }
        let mut model = faulty(&scene, fault);
        let table = ShapeSpace::tabulate(&scene, &mut model, &RANGES, 1e-3);
        assert!(table.is_err(), "{fault}");
        assert!(solve_start(&scene, &mut model).is_err(), "{fault}");
    }
}

#[test]
fn hostile_configurations_are_refused_by_every_model() {
    let scene = in_ball();
    let fem = three_spheres().ball(30.0).elements(1.5).scene();
    let state = scene.initial_state();
    let mut lost = state.clone();
    lost.frames[0].translation.vector = Vector3::repeat(f64::NAN);
    let mut twisted = state.clone();
    twisted.attitudes[0] =
        UnitQuaternion::new_unchecked(nalgebra::Quaternion::new(2.0, 0.0, 0.0, 0.0));
    let empty = empty_state();
    let models: [Box<dyn Hydrodynamics>; 3] = [
        Box::new(spheres(&scene)),
        Box::new(SpheresModel::new(&scene, SphereModel::Multipole(1e-4)).unwrap()),
        Box::new(FemModel::new(&fem).unwrap()),
    ];
    let (sound, rates) = (vec![10.0, 10.0], vec![1.0, 0.0]);
    for mut model in models {
        let name = model.name();
        let mut refuses = |state: &State, shape: &[f64], rates: &[f64]| {
            let configuration = Configuration::new(state, shape);
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

#[test]
fn tables_outside_their_box_are_refused() {
    let scene = rpy();
    let mut model = spheres(&scene);
    for tolerance in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(ShapeSpace::tabulate(&scene, &mut model, &RANGES, tolerance).is_err());
    }
    for x in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
        let bad = [(6.0, x), (10.0, 10.0)];
        let table = ShapeSpace::tabulate(&scene, &mut model, &bad, 1e-2);
        assert!(table.is_err(), "{x}");
    }
    let space = ShapeSpace::tabulate(&scene, &mut model, &RANGES, 1e-2).unwrap();
    let state = scene.initial_state();
    let empty = empty_state();
    assert!(space.connection(&[7.0, 10.0]).is_ok() && space.metric(&[7.0, 10.0]).is_ok());
    let refuses = |state: &State, shape: &[f64], rates: &[f64]| {
        space
            .solution(Configuration::new(state, shape), rates)
            .is_err()
    };
    for shape in [
        &[5.0, 10.0][..],
        &[7.0],
        &[],
        &[f64::NAN, 10.0],
        &[7.0, 9.0],
    ] {
        assert!(space.connection(shape).is_err() && space.metric(shape).is_err());
        assert!(refuses(&state, shape, &[1.0, 0.0]));
    }
    for (state, rates) in [
        (&state, &[1.0][..]),
        (&state, &[1.0, 1.0]),
        (&empty, &[1.0, 0.0]),
    ] {
        assert!(refuses(state, &[7.0, 10.0], rates));
    }
}

#[test]
fn reports_of_incomplete_outcomes_do_not_panic() {
    let scene = rpy();
    let mut outcome = simulate(&scene, &mut spheres(&scene), Method::Collocation, &mut ()).unwrap();
    outcome.samples[1].bodies = Some(vec![]);
    outcome.samples[2].shape.clear();
    assert!(trajectory_csv(&scene, &outcome.samples).lines().count() > 4);
    assert_eq!(trajectory_csv(&scene, &[]).lines().count(), 1);
    outcome.displacement.clear();
    assert_eq!(outcome.net(), 0.0);
    let mut interim = Interim::start(&scene).unwrap();
    interim.state.frames.clear();
    let mut model = spheres(&scene);
    let resumed = continue_from(&scene, &mut model, Method::Collocation, &mut (), interim);
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
