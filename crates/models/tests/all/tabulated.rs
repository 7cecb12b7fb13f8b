//! Queries with rates that a table covers and rates that it does not.

use std::sync::{Arc, Mutex};

use models::{
    Configuration, Hydrodynamics, InstantaneousSolution, ModelError, Query, SphereModel,
    SpheresModel, Tabulated,
};
use scene::Scene;

use crate::scenes::three_spheres;

/// A model that records the rates of its queries.
struct Recorded {
    model: SpheresModel,
    rates: Arc<Mutex<Vec<Vec<Vec<f64>>>>>,
}

impl Hydrodynamics for Recorded {
    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        self.rates.lock().unwrap().push(query.rates.to_vec());
        self.model.solve(query)
    }
}

#[test]
fn tabulated_and_untabulated_rates_are_solved_in_the_order_of_the_query() {
    let scene = three_spheres("");
    let spheres = || SpheresModel::new(&scene, SphereModel::Rpy).unwrap();
    let queries = Arc::new(Mutex::new(Vec::new()));
    let model = Recorded {
        model: spheres(),
        rates: queries.clone(),
    };
    // Only the left arm varies in the table.
    let ranges = vec![vec![(6.0, 10.0), (10.0, 10.0)]];
    let mut tabulated = Tabulated::new(&scene, Box::new(model), ranges, 1e-5);

    let state = scene.initial_state();
    let configuration = Configuration {
        state: &state,
        shape: &[7.3, 10.0],
    };
    let rates = [
        vec![1.0, 0.5],
        vec![-2.0, 0.0],
        vec![0.0, 1.0],
        vec![0.5, 0.0],
    ];
    let found = tabulated.solve(&Query::new(configuration, &rates)).unwrap();
    let exact = spheres().solve(&Query::new(configuration, &rates)).unwrap();
    assert_eq!(found.len(), rates.len());
    for (number, (found, exact)) in found.iter().zip(&exact).enumerate() {
        let is_tabulated = rates[number][1] == 0.0;
        assert_eq!(
            found.solver.solver == "table",
            is_tabulated,
            "rates {number}"
        );
        for (a, b) in found.bodies.iter().zip(&exact.bodies) {
            let difference = (a.velocity - b.velocity).norm();
            if is_tabulated {
                assert!(difference <= found.error_estimate.total(), "{difference:e}");
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
