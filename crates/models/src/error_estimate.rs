//! Error bars of a quantity, by source.

use serde::{Deserialize, Serialize};

/// Error bars of a quantity by source, in its units; `None` for a source that was not estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct ErrorEstimate {
    /// Discretisation on a mesh.
    pub mesh: Option<f64>,
    /// Truncation of the domain: a ball for unbounded fluid, a part of an infinite cylinder.
    pub container: Option<f64>,
    /// Approximation by the model: truncated expansions or interactions, interpolation in tables,
    /// superposition.
    pub model: Option<f64>,
    /// Residual of the linear solve.
    pub algebraic: Option<f64>,
    /// Time integration along the gait.
    pub integration: Option<f64>,
}

impl ErrorEstimate {
    /// Names and error bars of the sources, in the order of the fields.
    pub fn sources(&self) -> [(&'static str, Option<f64>); 5] {
        [
            ("mesh", self.mesh),
            ("container", self.container),
            ("model", self.model),
            ("algebraic", self.algebraic),
            ("integration", self.integration),
        ]
    }

    /// Sum of the estimated error bars.
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
