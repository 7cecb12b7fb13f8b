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
        "{what} leave a gap of {gap:.3e} smaller radii, where an expansion to {tolerance:.0e} needs order {needed}; \
         the most is {most}: widen the gap, or ask for less accuracy"
    )]
    TooClose {
        /// Which surfaces.
        what: String,
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
    /// A mobility that is not positive definite: the model does not hold for spheres so close.
    #[error(
        "the {model} mobility of these spheres is not positive definite; they are too close for it: use {instead}"
    )]
    Indefinite {
        /// Name of the model.
        model: &'static str,
        /// A model that holds.
        instead: &'static str,
    },
    /// Surroundings that a model does not treat.
    #[error("{model} is not built for a {medium}; use {instead}")]
    NotBuilt {
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
