//! Queries without rates, and the error estimates that a query requests.

use models::{
    AxisymmetricModel, Configuration, FemModel, Hydrodynamics, Query, SphereModel, SpheresModel,
};

use crate::scenes::{three_spheres, three_spheres_in_ball};

#[test]
fn a_query_without_rates_has_no_solutions() {
    let scene = three_spheres("");
    let state = scene.initial_state();
    let configuration = Configuration {
        state: &state,
        lengths: &[10.0, 10.0],
    };
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
    let configuration = Configuration {
        state: &state,
        lengths: &[10.0, 10.0],
    };
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
