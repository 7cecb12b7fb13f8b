//! Queries without rates, and the error estimates that a query requests.

use models::{
    AxisymmetricModel, Configuration, FemModel, FlowField, Hydrodynamics, InstantaneousSolution,
    Query, SphereModel, SpheresModel,
};

use testkit::{solve_at, within};

use crate::scenes::{three_spheres, three_spheres_in_ball};

#[test]
fn a_query_without_rates_has_no_solutions() {
    let scene = three_spheres().scene();
    let state = scene.initial_state();
    let (state, shape) = (&state, &[10.0, 10.0]);
    let configuration = Configuration::new(state, shape);
    let models: [Box<dyn Hydrodynamics>; 3] = [
        Box::new(SpheresModel::new(&scene, SphereModel::Oseen).unwrap()),
        Box::new(AxisymmetricModel::new(&scene).unwrap()),
        Box::new(FemModel::new(&three_spheres_in_ball()).unwrap()),
    ];
    for mut model in models {
        let query = Query::new(configuration, &[]).with_accuracy(Some(1e-3));
        assert!(model.solve(&query).unwrap().is_empty(), "{}", model.name());
    }
}

#[test]
fn finite_elements_estimate_errors_on_request_only() {
    let scene = three_spheres_in_ball();
    let state = scene.initial_state();
    let (state, shape) = (&state, &[10.0, 10.0]);
    let configuration = Configuration::new(state, shape);
    let rates = [vec![1.0, 0.0]];
    let query = Query::new(configuration, &rates);
    let mut model = FemModel::new(&scene).unwrap();
    for estimates in [false, true] {
        let solutions = model.solve(&query.with_estimates(estimates)).unwrap();
        assert_eq!(solutions[0].mesh_error.is_some(), estimates);
        assert_eq!(solutions[0].error_estimate.mesh.is_some(), estimates);
        assert_eq!(solutions[0].checks.is_some(), estimates);
    }
}

/// Shapes of three configurations, the last of which needs another mesh than the first.
const LENGTHS: [[f64; 2]; 3] = [[10.0, 10.0], [8.0, 10.0], [2.5, 9.0]];

/// Solutions for [`LENGTHS`] at once, and the flow of each.
fn solved_together() -> (Vec<InstantaneousSolution>, Vec<FlowField>) {
    let scene = three_spheres_in_ball();
    let state = scene.initial_state();
    let rates = [vec![1.0, 0.5]];
    let queries = LENGTHS.each_ref().map(|shape| {
        let state = &state;
        Query::new(Configuration::new(state, shape), &rates).with_flows(true)
    });
    let mut model = FemModel::new(&scene).unwrap();
    assert!(model.capabilities().solves_together);
    let solved = model.solve_all(&queries).unwrap();
    let flow = |mut solution: InstantaneousSolution| {
        let flow = solution.flow.take().unwrap().into_field().unwrap();
        (solution, flow)
    };
    solved.into_iter().flatten().map(flow).unzip()
}

#[test]
fn queries_that_are_solved_together_have_the_solutions_of_single_ones() {
    let scene = three_spheres_in_ball();
    let mut model = FemModel::new(&scene).unwrap();
    let (together, flows) = solved_together();
    assert!(together[2].remeshed.is_some() && together[1].remeshed.is_none());
    for ((shape, together), flow) in LENGTHS.iter().zip(&together).zip(&flows) {
        let single = solve_at(&mut model, shape, &[1.0, 0.5]);
        let algebraic = |solution: &InstantaneousSolution| solution.error_estimate.algebraic;
        let allowed = algebraic(together).unwrap() + algebraic(&single).unwrap();
        for (a, b) in together.bodies.iter().zip(&single.bodies) {
            let difference = (a.velocity - b.velocity).norm();
            within(
                difference,
                allowed,
                format!("the residuals of both: {shape:?}"),
            );
        }
        let of_single = single.flow.as_ref().unwrap().field().unwrap();
        assert_eq!(flow.mesh.points(), of_single.mesh.points(), "{shape:?}");
    }
}

#[test]
fn queries_that_are_solved_together_do_not_depend_on_the_number_of_threads() {
    let [one, three] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let (solutions, flows) = pool.unwrap().install(solved_together);
        let bodies = solutions
            .into_iter()
            .map(|solution| solution.response.bodies);
        let velocities = flows.into_iter().map(|flow| flow.velocity);
        (bodies.collect::<Vec<_>>(), velocities.collect::<Vec<_>>())
    });
    assert!(one == three, "one and three threads differ");
}
