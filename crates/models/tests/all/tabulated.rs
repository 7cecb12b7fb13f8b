//! Queries with rates that a table covers and rates that it does not.

use models::{Configuration, Hydrodynamics, Query, SphereModel, SpheresModel, Tabulated};
use testkit::{Recording, within};

use crate::scenes::three_spheres;

#[test]
fn tabulated_and_untabulated_rates_are_solved_in_the_order_of_the_query() {
    let scene = three_spheres().scene();
    let spheres = || SpheresModel::new(&scene, SphereModel::Rpy).unwrap();
    let model = Recording::new(spheres());
    let queries = model.rates.clone();
    // Only the left arm varies in the table.
    let ranges = vec![vec![(6.0, 10.0), (10.0, 10.0)]];
    let mut tabulated = Tabulated::new(&scene, Box::new(model), ranges, 1e-5);

    let state = scene.initial_state();
    let (state, shape) = (&state, &[7.3, 10.0]);
    let configuration = Configuration::new(state, shape);
    let rates = [[1.0, 0.5], [-2.0, 0.0], [0.0, 1.0], [0.5, 0.0]].map(Vec::from);
    let found = tabulated.solve(&Query::new(configuration, &rates)).unwrap();
    let exact = spheres().solve(&Query::new(configuration, &rates)).unwrap();
    assert_eq!(found.len(), rates.len());
    for (number, (found, exact)) in found.iter().zip(&exact).enumerate() {
        let is_tabulated = rates[number][1] == 0.0;
        let is_found_so = found.solver.solver == "table";
        assert_eq!(is_found_so, is_tabulated, "rates {number}");
        for (a, b) in found.bodies.iter().zip(&exact.bodies) {
            let difference = (a.velocity - b.velocity).norm();
            if is_tabulated {
                within(difference, found.error_estimate.total(), "the error bar");
            } else {
                assert_eq!(a, b);
            }
        }
    }
    // The model solves for both untabulated rates in one query, after those of the table.
    let queries = queries.lock().unwrap();
    let (last, table) = queries.split_last().unwrap();
    assert_eq!(*last, [rates[0].clone(), rates[2].clone()]);
    assert!(table.len() >= 5 && table.iter().all(|rates| *rates == [[1.0, 0.0]]));
}
