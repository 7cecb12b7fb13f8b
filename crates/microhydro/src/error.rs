//! What keeps spheres from having a resistance.

/// Spheres, surroundings or accuracies that cannot be computed, with what to change.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HydroError {
    /// Numbers of centres and radii, or of velocities, that differ.
    #[error("{what}: expected {expected}, found {found}")]
    Length {
        /// What was counted.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A radius that is not positive and finite.
    #[error("sphere {sphere} has radius {radius}; radii must be positive and finite")]
    BadRadius {
        /// The sphere.
        sphere: usize,
        /// Its radius.
        radius: f64,
    },
    /// A number that is not finite.
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
        /// One sphere.
        first: usize,
        /// The other.
        second: usize,
        /// Distance of their surfaces, negative when they overlap.
        gap: f64,
    },
    /// A sphere that touches the container or the wall, or lies behind it.
    #[error(
        "sphere {sphere} touches the {boundary} or lies beyond it (clearance {clearance:.3e}); move it inside"
    )]
    OutsideMedium {
        /// The sphere.
        sphere: usize,
        /// The container or the wall.
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
        /// The relative error asked for.
        tolerance: f64,
        /// The order that would do.
        needed: usize,
        /// The most that is allowed.
        most: usize,
    },
    /// A point where the flow is asked for that is not in the fluid.
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
    /// Surroundings that a model does not treat.
    #[error("the {model} model does not support a {medium}; use {instead}")]
    Unsupported {
        /// Name of the model.
        model: &'static str,
        /// The surroundings.
        medium: &'static str,
        /// What to use instead.
        instead: &'static str,
    },
    /// An iteration that did not converge.
    #[error(
        "conjugate gradients left a relative residual of {residual:.1e} after {iterations} steps, {target:.1e} was asked; \
         widen the narrowest gap or ask for less accuracy"
    )]
    NotConverged {
        /// Steps taken.
        iterations: usize,
        /// What is left.
        residual: f64,
        /// What was asked for.
        target: f64,
    },
}
