//! The mean flow through a periodic box, integrated and averaged in time.

use models::{ErrorEstimate, InstantaneousSolution, MeanFlow};
use scene::Scene;
use serde::{Deserialize, Serialize};

/// The mean flow through a periodic box and its pressure gradient: their integrals in time, or
/// their means over a time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[non_exhaustive]
pub struct MeanFlowInTime {
    /// Flow and pressure gradient, of which the scene gives one.
    pub flow: MeanFlow,
    /// Error bars of the other one.
    pub error: ErrorEstimate,
}

impl MeanFlowInTime {
    /// The integrals of solutions, each with the time for which it stands; none outside of periodic
    /// boxes.
    pub(crate) fn integrals<'a>(
        solutions: impl Iterator<Item = (&'a InstantaneousSolution, f64)>,
    ) -> Option<Self> {
        let mut sum: Option<Self> = None;
        for (solution, time) in solutions {
            let flow = solution.mean_flow?;
            let error = solution.mean_flow_error;
            sum.get_or_insert_default()
                .accumulate(time, &Self { flow, error });
        }
        sum
    }

    /// Adds `weight` times another one, whose error bars count as sizes.
    pub(crate) fn accumulate(&mut self, weight: f64, other: &Self) {
        self.flow.velocity += weight * other.flow.velocity;
        self.flow.pressure_gradient += weight * other.flow.pressure_gradient;
        self.error.accumulate(weight.abs(), &other.error);
    }

    /// Adds another one of a later time, to none at first.
    pub(crate) fn append(sum: &mut Option<Self>, later: Option<&Self>) {
        if let Some(later) = later {
            sum.get_or_insert_default().accumulate(1.0, later);
        }
    }

    /// Size of the difference from another one, of what the scene does not give.
    pub(crate) fn difference(&self, other: &Self, scene: &Scene) -> f64 {
        let [a, b] = [&self.flow, &other.flow];
        match scene.finds_mean_flow() {
            true => (a.velocity - b.velocity).norm(),
            false => (a.pressure_gradient - b.pressure_gradient).norm(),
        }
    }

    /// The means of integrals over a time.
    pub(crate) fn over(&self, time: f64) -> Self {
        let mut means = Self::default();
        means.accumulate(1.0 / time, self);
        means
    }
}
