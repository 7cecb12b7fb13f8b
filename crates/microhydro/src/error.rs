//! Errors of the sphere models.

/// Arrangements of spheres, media or accuracies that cannot be computed, with the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HydroError {
    /// Lists of different lengths, or a list of velocities of the wrong length.
    #[error("{what}: expected {expected} entries, found {found}")]
    Length {
        /// Name of the list.
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
    #[error("{what} is NaN or infinite; check positions, radii and units")]
    NotFinite {
        /// Name of the number.
        what: &'static str,
    },
    /// A length whose powers overflow or vanish.
    #[error(
        "{what} is {length:e}; lengths must be between {lowest:e} and {highest:e}: \
         choose another unit of length"
    )]
    OutOfRange {
        /// Name of the length.
        what: &'static str,
        /// The length.
        length: f64,
        /// Lowest length other than zero.
        lowest: f64,
        /// Highest length.
        highest: f64,
    },
    /// A periodic box in which no sums are computed.
    #[error("periodic box with the edges {size:?}: {problem}")]
    PeriodicBox {
        /// Edges of the box.
        size: [f64; 3],
        /// What is wrong.
        problem: &'static str,
    },
    /// A total force on spheres that are free to move.
    #[error(
        "the total force is given, but all spheres are free to move along a direction, so that any \
         mean flow carries them; hold a sphere, or give the mean flow"
    )]
    NothingHeld,
    /// Two spheres that touch or overlap.
    #[error(
        "spheres {first} and {second} touch or overlap (gap {gap:.3e}); \
         move them apart or reduce their radii"
    )]
    Touching {
        /// Index of one sphere.
        first: usize,
        /// Index of the other sphere.
        second: usize,
        /// Distance between the surfaces; negative when the spheres overlap.
        gap: f64,
    },
    /// A sphere that touches its own image in a periodic box.
    #[error(
        "sphere {sphere} touches its own periodic image (gap {gap:.3e}); enlarge the box or make the \
         sphere smaller"
    )]
    TouchingImage {
        /// Index of the sphere.
        sphere: usize,
        /// Distance between the surfaces; negative when they overlap.
        gap: f64,
    },
    /// A sphere that touches the container or the wall, or lies beyond it.
    #[error(
        "sphere {sphere} touches the {boundary} or lies beyond it (clearance {clearance:.3e}); \
         move it into the fluid"
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
        "{surfaces} leave a gap of {gap:.3e} smaller radii, which needs an expansion of order \
         {needed} for a tolerance of {tolerance:.0e}; the highest order is {highest}: \
         widen the gap or increase the tolerance"
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
        highest: usize,
    },
    /// A gap below those for which multipole expansions are verified.
    #[error(
        "{surfaces} leave a gap of {gap:.3e} smaller radii; multipole expansions are verified down \
         to {lowest}: widen the gap or end the motion before it"
    )]
    GapTooNarrow {
        /// The surfaces with the narrowest gap.
        surfaces: String,
        /// Distance of the surfaces over the smaller radius.
        gap: f64,
        /// Narrowest gap that is accepted.
        lowest: f64,
    },
    /// A requested relative error outside the range that can be met.
    #[error(
        "the tolerance {tolerance:e} is not a number between {lowest:e} and 1; \
         below {lowest:e} rounding errors dominate"
    )]
    BadTolerance {
        /// The requested tolerance.
        tolerance: f64,
        /// Lowest tolerance.
        lowest: f64,
    },
    /// An expansion that would take too much memory.
    #[error(
        "{dofs:.0} multipoles would take {mib:.0} MiB, at most {highest:.0} MiB are allowed: \
         use fewer spheres, a lower order or a higher tolerance"
    )]
    TooLarge {
        /// Number of multipoles.
        dofs: f64,
        /// Memory that they would take, in MiB.
        mib: f64,
        /// Memory that is allowed, in MiB.
        highest: f64,
    },
    /// A solution by expansions that would take too much memory or time.
    #[error(
        "{dofs} multipoles would take {mib:.0} MiB and {seconds:.0} s on two cores, or more; at \
         most {most_mib:.0} MiB and {longest:.0} s are allowed: use fewer spheres, wider gaps, a \
         higher tolerance, or the model of Rotne, Prager and Yamakawa"
    )]
    TooCostly {
        /// Number of multipoles.
        dofs: usize,
        /// Memory that they would take, in MiB.
        mib: f64,
        /// Predicted time in seconds.
        seconds: f64,
        /// Memory that is allowed, in MiB.
        most_mib: f64,
        /// Time that is allowed, in seconds.
        longest: f64,
    },
    /// An estimated error above the tolerance at the highest orders that are allowed.
    #[error(
        "the resistance was computed to a relative error of {reached:.1e}, {tolerance:.1e} was \
         requested; {surfaces} have the narrowest gap ({gap:.3e} smaller radii): widen it or \
         increase the tolerance"
    )]
    ToleranceNotReached {
        /// The requested relative error.
        tolerance: f64,
        /// The smallest estimated relative error.
        reached: f64,
        /// The surfaces with the narrowest gap.
        surfaces: String,
        /// Distance of these surfaces over the smaller radius.
        gap: f64,
    },
    /// A point outside the fluid, where the velocity field cannot be evaluated.
    #[error(
        "the point ({x:.4}, {y:.4}, {z:.4}) is not in the fluid; \
         evaluate the velocity outside the spheres and inside the container"
    )]
    NotInFluid {
        /// Coordinates of the point.
        x: f64,
        /// Coordinates of the point.
        y: f64,
        /// Coordinates of the point.
        z: f64,
    },
    /// A surface velocity that the expansions do not represent.
    #[error(
        "the surface velocity of sphere {sphere} has a part of {remainder:.1e} (relative, root mean \
         square) that polynomials of degree {degree} in the normal do not represent; at most \
         {highest:.0e} is allowed: make it smoother, or expand it in squirming modes and pass \
         their sum"
    )]
    SlipNotResolved {
        /// Index of the sphere.
        sphere: usize,
        /// Degree up to which all polynomials are represented.
        degree: usize,
        /// Root mean square of the part that is not represented, relative to the largest root mean
        /// square of the surface velocities of all spheres.
        remainder: f64,
        /// Largest remainder that is accepted.
        highest: f64,
    },
    /// A surface velocity that changes the volume of a sphere beside a plane wall, or of many
    /// spheres in unbounded fluid or in a periodic box.
    #[error(
        "the surface velocity of sphere {sphere} has the net flux {flux:.3e} through it (mean normal \
         component over root mean square; above {highest:.0e}), for which expansions have no source \
         beside a plane wall, in a periodic box and of many spheres: subtract the mean normal \
         component times the normal"
    )]
    NetFlux {
        /// Index of the sphere.
        sphere: usize,
        /// Mean normal component, positive outwards, relative to the largest root mean square of
        /// the surface velocities of all spheres.
        flux: f64,
        /// Largest flux that is taken for rounding or for an error of the expansion.
        highest: f64,
    },
    /// An approximate mobility that is not positive definite, so that it has no resistance.
    #[error(
        "the Cholesky factorisation of the {model} mobility failed: the matrix is not positive \
         definite (smallest over largest eigenvalue {eigenvalue_ratio:.1e}); {surfaces} leave a \
         gap of {gap:.3e} smaller radii, too narrow for this approximation; use {instead}"
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
        "the Cholesky factorisation of the {matrix} of the multipole expansion failed: the matrix \
         ({size} x {size}) is not positive definite to rounding; widen the narrowest gap, lower \
         the order or increase the tolerance"
    )]
    FactorisationFailed {
        /// Name of the matrix.
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
        /// Model to use instead.
        instead: &'static str,
    },
    /// Conjugate gradients that did not converge.
    #[error(
        "conjugate gradients reached a residual of {residual:.1e} in {iterations} iterations, \
         {target:.1e} was requested; widen the narrowest gap or increase the tolerance"
    )]
    NotConverged {
        /// Number of iterations.
        iterations: usize,
        /// Largest norm of a residual over all right-hand sides.
        residual: f64,
        /// Norm of the residual that was requested.
        target: f64,
    },
    /// An inverse square root of the mobility that did not converge.
    #[error(
        "the inverse square root of the mobility still changes by {change:.1e} (relative) after \
         {steps} steps, {target:.0e} was requested; widen the narrowest gap"
    )]
    RootNotConverged {
        /// Number of steps.
        steps: usize,
        /// Relative change of the result by the last step.
        change: f64,
        /// The change that was requested.
        target: f64,
    },
}

/// Checks that numbers are neither NaN nor infinite.
///
/// # Errors
/// [`HydroError::NotFinite`] with the name `what`.
pub(crate) fn check_finite<'n>(
    what: &'static str,
    numbers: impl IntoIterator<Item = &'n f64>,
) -> Result<(), HydroError> {
    match numbers.into_iter().all(|number| number.is_finite()) {
        true => Ok(()),
        false => Err(HydroError::NotFinite { what }),
    }
}

/// Checks the length of `what`.
///
/// # Errors
/// [`HydroError::Length`].
pub(crate) fn check_entries(
    what: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), HydroError> {
    match expected == found {
        true => Ok(()),
        false => Err(HydroError::Length {
            what,
            expected,
            found,
        }),
    }
}
