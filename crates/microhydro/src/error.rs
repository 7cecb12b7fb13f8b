//! Errors of the sphere models.

/// Arrangements of spheres, media or accuracies that cannot be computed, with the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HydroError {
    /// Lists of different lengths, or a list of velocities of the wrong length.
    #[error("{what}: expected {expected}, found {found}")]
    Length {
        /// Which list.
        what: &'static str,
        /// Expected number of entries.
        expected: usize,
        /// Number of entries found.
        found: usize,
    },
    /// A radius that is not positive and finite.
    #[error("sphere {sphere} has radius {radius}; radii must be positive and finite")]
    BadRadius {
        /// Index of the sphere.
        sphere: usize,
        /// Its radius.
        radius: f64,
    },
    /// A NaN or infinite number.
    #[error("{what} is not finite")]
    NotFinite {
        /// Which number.
        what: &'static str,
    },
    /// Two spheres that touch or overlap.
    #[error(
        "spheres {first} and {second} touch or overlap (gap {gap:.3e}); move them apart or make them smaller"
    )]
    Touching {
        /// Index of one sphere.
        first: usize,
        /// Index of the other sphere.
        second: usize,
        /// Distance between the surfaces; negative when the spheres overlap.
        gap: f64,
    },
    /// A sphere that touches the container or the wall, or lies beyond it.
    #[error(
        "sphere {sphere} touches the {boundary} or lies beyond it (clearance {clearance:.3e}); move it inside"
    )]
    OutsideMedium {
        /// Index of the sphere.
        sphere: usize,
        /// Name of the boundary: container or wall.
        boundary: &'static str,
        /// Distance from the sphere's surface to the boundary, negative beyond it.
        clearance: f64,
    },
    /// A gap so narrow that the expansion would need more terms than are allowed.
    #[error(
        "{surfaces} leave a gap of {gap:.3e} smaller radii, where an expansion to {tolerance:.0e} needs order {needed}; \
         the most is {most}: widen the gap, or ask for less accuracy"
    )]
    TooClose {
        /// The surfaces with the narrowest gap.
        surfaces: String,
        /// Distance of the surfaces over the smaller radius.
        gap: f64,
        /// The relative error requested.
        tolerance: f64,
        /// Order that would meet the tolerance.
        needed: usize,
        /// Highest order that is allowed.
        most: usize,
    },
    /// A point outside the fluid, where the velocity field cannot be evaluated.
    #[error(
        "the point ({x:.4}, {y:.4}, {z:.4}) is not in the fluid; ask outside the spheres and inside the container"
    )]
    NotInFluid {
        /// Coordinates of the point.
        x: f64,
        /// Coordinates of the point.
        y: f64,
        /// Coordinates of the point.
        z: f64,
    },
    /// An approximate mobility that is not positive definite, so that it has no resistance.
    #[error(
        "the {model} mobility is not positive definite (smallest over largest eigenvalue \
         {eigenvalue_ratio:.1e}): {surfaces} leave a gap of {gap:.3e} smaller radii, too narrow for \
         this approximation; use {instead}"
    )]
    NotPositiveDefinite {
        /// Name of the model.
        model: &'static str,
        /// Smallest eigenvalue of the scaled mobility over its largest.
        eigenvalue_ratio: f64,
        /// The surfaces with the narrowest gap.
        surfaces: String,
        /// Distance of these surfaces over the smaller radius.
        gap: f64,
        /// A model that remains positive definite.
        instead: &'static str,
    },
    /// A multipole system whose Cholesky factorisation failed.
    ///
    /// The exact system is positive definite: this is rounding in an expansion of high order.
    #[error(
        "the Cholesky factorisation of the {matrix} ({size} x {size}) of the multipole expansion \
         failed: it is not positive definite to rounding; widen the narrowest gap, or lower the \
         order or the accuracy"
    )]
    FactorisationFailed {
        /// Which matrix.
        matrix: &'static str,
        /// Number of its rows.
        size: usize,
    },
    /// A medium that a model does not support.
    #[error("the {model} model does not support a {medium}; use {instead}")]
    Unsupported {
        /// Name of the model.
        model: &'static str,
        /// The unsupported medium.
        medium: &'static str,
        /// What to use instead.
        instead: &'static str,
    },
    /// Conjugate gradients that did not converge.
    #[error(
        "conjugate gradients left a relative residual of {residual:.1e} after {iterations} steps, {target:.1e} was asked; \
         widen the narrowest gap or ask for less accuracy"
    )]
    NotConverged {
        /// Number of iterations.
        iterations: usize,
        /// Largest norm of a residual over all right-hand sides.
        residual: f64,
        /// Norm of the residual that was requested.
        target: f64,
    },
}
