//! A model that records its queries and may change the solutions.

use std::sync::{Arc, Mutex};

use models::{Capabilities, Hydrodynamics, InstantaneousSolution, ModelError, Query};
use scene::Scene;

type Change<'a> = Box<dyn FnMut(&Query<'_>, &mut Vec<InstantaneousSolution>) + Send + 'a>;

/// Records the rates of all queries to a model, and changes its solutions.
///
/// It has no capabilities but its own, and hides flows, meshes and copies of the model.
pub struct Recording<'a> {
    model: Box<dyn Hydrodynamics + 'a>,
    change: Change<'a>,
    /// What the model says that it can do; nothing by default.
    pub capabilities: Capabilities,
    /// The rates of all queries; clones of the pointer survive the model.
    pub rates: Arc<Mutex<Vec<Vec<Vec<f64>>>>>,
}

impl<'a> Recording<'a> {
    /// Records without changes.
    pub fn new(model: impl Hydrodynamics + 'a) -> Self {
        Self::changing(model, |_, _| ())
    }

    /// Records, and changes the solutions of each query.
    pub fn changing(
        model: impl Hydrodynamics + 'a,
        change: impl FnMut(&Query<'_>, &mut Vec<InstantaneousSolution>) + Send + 'a,
    ) -> Self {
        Self {
            model: Box::new(model),
            change: Box::new(change),
            capabilities: Capabilities::default(),
            rates: Arc::default(),
        }
    }

    /// Number of rates in each query.
    pub fn queries(&self) -> Vec<usize> {
        self.rates
            .lock()
            .expect("rates")
            .iter()
            .map(Vec::len)
            .collect()
    }
}

impl Hydrodynamics for Recording<'_> {
    fn scene(&self) -> &Scene {
        self.model.scene()
    }

    fn name(&self) -> &'static str {
        self.model.name()
    }

    fn capabilities(&self) -> Capabilities {
        self.capabilities
    }

    fn solve(&mut self, query: &Query<'_>) -> Result<Vec<InstantaneousSolution>, ModelError> {
        (self.rates.lock().expect("rates")).push(query.rates.to_vec());
        let mut solutions = self.model.solve(query)?;
        (self.change)(query, &mut solutions);
        Ok(solutions)
    }
}
