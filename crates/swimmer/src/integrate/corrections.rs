//! Where the corrections of discretisation errors along a step come from.

use models::DiscretisationError;

use super::span_solution::SpanSolution;

/// Source of the corrections of all solutions of one order.
#[derive(Clone, Copy)]
pub(super) enum Corrections<'a> {
    /// The solutions are requested without corrections.
    None,
    /// Every solution is requested with its own.
    Computed,
    /// Interpolated from solutions at fewer points.
    Interpolated(&'a FewPoints),
}

/// Discretisation errors at a few points of a step.
///
/// They are small, and on one moving mesh they are as smooth as the velocities. A quadrature over
/// few points therefore has about the relative error for them that it has for the velocities; with
/// two points it is 1e-2 of the correction.
pub(super) struct FewPoints(Vec<(f64, DiscretisationError)>);

impl FewPoints {
    /// The errors that were subtracted from solutions; none if one of them has no estimate.
    pub fn of(solutions: &[SpanSolution]) -> Option<Self> {
        let error = |s: &SpanSolution| Some((s.s, s.solution.mesh_error.clone()?));
        Some(Self(solutions.iter().map(error).collect::<Option<_>>()?))
    }

    /// The error at the position `s` on the phase span, by the polynomial through the points.
    pub fn at(&self, s: f64) -> Option<DiscretisationError> {
        let weight = |i: usize| {
            let others = self.0.iter().enumerate().filter(|(j, _)| *j != i);
            others.fold(1.0, |weight, (_, (other, _))| {
                weight * (s - other) / (self.0[i].0 - other)
            })
        };
        let terms = self.0.iter().enumerate();
        DiscretisationError::combination(terms.map(|(i, (_, error))| (weight(i), error)))
    }
}
