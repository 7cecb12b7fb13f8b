//! Element sizes on bodies and their growth with the distance.

use scene::FemOptions;

/// Element size on the surface of a body relative to its radius, if the scene gives none.
const DEFAULT_SURFACE_SIZE: f64 = 0.4;

/// Largest growth of the element size with the distance; a larger one makes poor cells.
const MAX_GROWTH: f64 = 0.3;

/// Growth of the element size in adapted meshes.
///
/// Where the flow is smooth, elements should become large within a short distance. This costs some
/// quality: a mean ratio of 0.87 instead of 0.89.
pub const ADAPTED_GROWTH: f64 = 0.4;

/// Factor on default element sizes for the coarsest mesh whose facets follow a sphere.
pub const COARSEST_FACTOR: f64 = 1.75;

/// Element size on the surface of a body with the given radius.
pub fn surface_size(options: &FemOptions, radius: f64) -> f64 {
    let factor = options.size_factor.unwrap_or(match options.target {
        None => 1.0,
        Some(_) => COARSEST_FACTOR,
    });
    factor
        * options
            .surface_size
            .unwrap_or(DEFAULT_SURFACE_SIZE * radius)
}

/// Growth of the element size with the distance, for elements of `size` radii on a body.
///
/// Around a sphere the third derivatives of the flow decrease as `r^-4`, so the error of quadratic
/// elements of size `h` is `∫ h^4 r^-8 r^2 dr`. For a given number of elements, `∫ h^-3 r^2 dr`, it
/// is smallest for `h = h_s r^(8/7)`: over one radius the size grows by 8/7 of the size on the
/// surface. A growth independent of `size` would leave an error that smaller surface elements do
/// not remove.
pub fn growth(size: f64) -> f64 {
    (8.0 / 7.0 * size).min(MAX_GROWTH)
}
