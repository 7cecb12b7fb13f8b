//! Errors of the displacements of bodies, from those of the frames of their linkages.

use models::{AccumulatedError, ErrorEstimate, UncorrectedBars};
use nalgebra::Vector3;
use rigid::Articulation;

/// Error bars of displacements by the accumulated errors of mesh, model and integration, of which
/// `largest` is the largest of a body; other sources have their given bars.
pub(crate) fn displacement_bars(
    bars: &ErrorEstimate,
    (mesh, model, integration): (
        Option<&AccumulatedError>,
        &AccumulatedError,
        Option<&AccumulatedError>,
    ),
    largest: impl Fn(&AccumulatedError) -> f64,
) -> ErrorEstimate {
    let uncorrected =
        |error: &AccumulatedError| error.uncorrected_error_bars(largest(error)).displacement;
    ErrorEstimate {
        mesh: mesh.map(|error| error.displacement_error_bar(largest(error))),
        model: bars.model.map(|_| uncorrected(model)),
        integration: integration.map(uncorrected),
        ..*bars
    }
}

/// Error bar of displacements from which an accumulated error was subtracted.
pub(super) fn corrected_bar(
    set: &Articulation,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> f64 {
    error.displacement_error_bar(largest_error(set, error, positions))
}

/// Error bars by the model or the integration, whose errors are not subtracted.
pub(super) fn uncorrected_bars(
    set: &Articulation,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> UncorrectedBars {
    error.uncorrected_error_bars(largest_error(set, error, positions))
}

pub(super) fn largest_error(
    set: &Articulation,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> f64 {
    let linkages = 0..set.linkages().len();
    linkages.fold(0.0, |largest, number| {
        largest.max(largest_error_of(set, number, error, positions))
    })
}

/// Largest error of the displacement of a body of a linkage.
pub(crate) fn largest_error_of(
    set: &Articulation,
    number: usize,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> f64 {
    let errors = errors_of_linkage(set, number, error, positions);
    errors.fold(0.0, |largest, (_, error)| largest.max(error.norm()))
}

/// Errors of the displacements of the bodies, from the errors of the frames of their linkages.
pub(super) fn errors_of_bodies(
    set: &Articulation,
    error: &AccumulatedError,
    positions: &[Vector3<f64>],
) -> Vec<Vector3<f64>> {
    let mut errors = vec![Vector3::zeros(); positions.len()];
    for number in 0..set.linkages().len() {
        for (body, error) in errors_of_linkage(set, number, error, positions) {
            errors[body] = error;
        }
    }
    errors
}

/// The bodies of a linkage with the errors of their displacements.
fn errors_of_linkage<'a>(
    set: &'a Articulation,
    number: usize,
    error: &'a AccumulatedError,
    positions: &'a [Vector3<f64>],
) -> impl Iterator<Item = (usize, Vector3<f64>)> + 'a {
    let linkage = &set.linkages()[number];
    let arm = move |body: usize| positions[body] - positions[linkage.root];
    (linkage.bodies.iter()).map(move |&body| (body, error.of_body(number, &arm(body))))
}
