//! Error bars by source.

use serde::{Deserialize, Serialize};

/// Error bars by source, in the units of the quantity; a source that was not estimated is absent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ErrorEstimate {
    /// Discretisation of the flow.
    pub mesh: Option<f64>,
    /// A finite container in place of unbounded fluid.
    pub container: Option<f64>,
    /// Approximations of the model to Stokes flow.
    pub model: Option<f64>,
    /// The algebraic solve.
    pub algebraic: Option<f64>,
    /// Integration along the gait.
    pub integration: Option<f64>,
}

impl ErrorEstimate {
    /// The sources in the order of the fields, with their names.
    pub fn sources(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("mesh", self.mesh),
            ("container", self.container),
            ("model", self.model),
            ("algebraic", self.algebraic),
            ("integration", self.integration),
        ]
    }

    /// The sum of the estimated sources.
    pub fn total(&self) -> f64 {
        self.sources().iter().filter_map(|(_, e)| *e).sum()
    }

    /// Adds `weight` times another estimate, source by source.
    pub fn accumulate(&mut self, weight: f64, other: &Self) {
        let add = |sum: &mut Option<f64>, term: Option<f64>| {
            if let Some(term) = term {
                *sum = Some(sum.unwrap_or(0.0) + weight * term);
            }
        };
        add(&mut self.mesh, other.mesh);
        add(&mut self.container, other.container);
        add(&mut self.model, other.model);
        add(&mut self.algebraic, other.algebraic);
        add(&mut self.integration, other.integration);
    }
}
