//! Errors of the crate.

/// Bodies whose flow cannot be computed, with the offending numbers and the remedy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AxisymmetricError {
    /// An empty list of bodies.
    #[error("there is no body on the axis; give at least one")]
    NoBodies,
    /// A body whose centre or semi-axes are not usable numbers.
    #[error(
        "body {body} has its centre at {centre} and semi-axes {semi_axes:?}; \
         all must be finite, and the semi-axes positive"
    )]
    InvalidBody {
        /// Index of the body.
        body: usize,
        /// Position of its centre on the axis.
        centre: f64,
        /// Semi-axes along the axis and perpendicular to it.
        semi_axes: [f64; 2],
    },
    /// A container whose radius is not a positive finite number.
    #[error("the wall has radius {radius}; it must be positive and finite")]
    InvalidWall {
        /// Radius of the ball or the cylinder.
        radius: f64,
    },
    /// A requested relative error that rounding prevents, or that is not below one.
    #[error("the tolerance {tolerance:e} must be at least {limit:e} and less than 1")]
    InvalidTolerance {
        /// The requested relative error.
        tolerance: f64,
        /// Smallest tolerance.
        limit: f64,
    },
    /// A body that is too slender or too flat.
    #[error(
        "the semi-axes of body {body} differ by a factor of {aspect:e}, more than the limit of \
         {limit}; make the body less slender"
    )]
    TooSlender {
        /// Index of the body.
        body: usize,
        /// The longer semi-axis over the shorter one.
        aspect: f64,
        /// Largest ratio supported.
        limit: f64,
    },
    /// Lengths that differ too much.
    #[error(
        "the largest length is {ratio:e} times the smallest semi-axis, more than the limit of \
         {limit:e}; make bodies more alike, or move them and the wall closer together"
    )]
    SizesTooDifferent {
        /// Distance between the ends of the bodies, or radius of the wall, over the smallest
        /// semi-axis.
        ratio: f64,
        /// Largest ratio supported.
        limit: f64,
    },
    /// Resistances that floating-point numbers do not represent.
    #[error(
        "a resistance of bodies with a semi-axis of {semi_axis:e} is not a normal floating-point \
         number; use another unit of length"
    )]
    OutOfRange {
        /// Smallest semi-axis of a body.
        semi_axis: f64,
    },
    /// An estimated error above the tolerance at the highest order.
    #[error(
        "the resistance was requested to {tolerance:e}, but elements of the highest order {order} \
         reach {reached:e}; use a larger tolerance, make gaps wider or bodies less slender"
    )]
    NotConverged {
        /// The requested relative error.
        tolerance: f64,
        /// The estimated relative error.
        reached: f64,
        /// Polynomial degree of the velocities.
        order: usize,
    },
    /// Two neighbouring bodies that overlap, touch or nearly touch.
    #[error(
        "bodies {} and {} are {gap:e} apart, less than {limit:e} of the smaller one's radius; \
         move them apart", bodies[0], bodies[1]
    )]
    BodiesTooClose {
        /// Indices of the two bodies.
        bodies: [usize; 2],
        /// Gap between their surfaces; negative if they overlap.
        gap: f64,
        /// Smallest gap supported, relative to the smaller radius.
        limit: f64,
    },
    /// A body that intersects, touches or nearly touches the wall.
    #[error(
        "body {body} is {gap:e} from the wall, less than {limit:e} of its radius; \
         make the body smaller or the surroundings larger"
    )]
    WallTooClose {
        /// Index of the body.
        body: usize,
        /// Gap between its surface and the wall; negative if it intersects the wall.
        gap: f64,
        /// Smallest gap supported, relative to the radius.
        limit: f64,
    },
    /// A domain that needs too many triangles.
    #[error(
        "the mesh of the meridian plane has {found} triangles, more than the limit of {limit}; \
         make gaps wider or bodies less slender"
    )]
    TooManyTriangles {
        /// Triangles when meshing stopped.
        found: usize,
        /// Largest number supported.
        limit: usize,
    },
    /// A domain that could not be triangulated.
    #[error("the meridian plane cannot be triangulated; make gaps wider or bodies less slender")]
    MeshFailed,
    /// A triangle with a Jacobian that is not positive.
    #[error(
        "triangle {triangle} of the meridian plane near ({:.4}, {:.4}) is inverted or flat: \
         Jacobian {jacobian:.3e}; make gaps wider or bodies less slender", at[0], at[1]
    )]
    InvertedTriangle {
        /// Index of the triangle.
        triangle: usize,
        /// The point, along the axis and away from it.
        at: [f64; 2],
        /// The Jacobian determinant there.
        jacobian: f64,
    },
    /// An element order whose nodal basis cannot be computed.
    #[error("elements of order {order} have no nodal basis; use a lower order")]
    NoNodalBasis {
        /// Polynomial degree.
        order: usize,
    },
    /// A triangle whose interior degrees of freedom cannot be eliminated.
    #[error(
        "triangle {triangle} of the meridian plane has a singular matrix; \
         make gaps wider or bodies less slender"
    )]
    SingularElement {
        /// Index of the triangle.
        triangle: usize,
    },
    /// Unbounded fluid with inertia.
    #[error(
        "flows with inertia need a container, because the flow far away is not known beforehand; \
         put the bodies into a large ball or cylinder"
    )]
    NoContainer,
    /// A number that is out of range.
    #[error("{what} is {value}; it must be {range}")]
    InvalidNumber {
        /// Name of the number.
        what: &'static str,
        /// Its value.
        value: f64,
        /// Values that it may have.
        range: &'static str,
    },
    /// A list of the wrong length.
    #[error("expected {expected} {what}, one per body, found {found}")]
    Length {
        /// Name of the items that are counted.
        what: &'static str,
        /// Number required.
        expected: usize,
        /// Number found.
        found: usize,
    },
    /// A steady state that Newton's method does not find.
    #[error(
        "no steady state at density {density}: the last one found is at {reached}, and beyond it \
         Newton's method does not converge (last relative change {change:.3e}); the flow may be \
         unsteady there, otherwise use a finer mesh (a smaller growth), a viscosity that varies \
         less, or elements in space"
    )]
    NotSteady {
        /// Density required.
        density: f64,
        /// Largest density at which a steady state was found.
        reached: f64,
        /// Relative change of the velocity in the last iteration.
        change: f64,
    },
    /// Unbounded fluid whose viscosity far from the bodies is not known.
    #[error(
        "in unbounded fluid the viscosity far away must be that at rest, which is {viscosity} by \
         this law, and the fluid must reach it; put the bodies into a ball, of 1e3 to 1e4 radii \
         for the limit of unbounded fluid"
    )]
    NoPlateau {
        /// Viscosity at zero shear rate.
        viscosity: f64,
    },
    /// A flow that the viscosity law makes too stiff for Newton's method.
    #[error(
        "the flow of the viscosity law is not found: after {iterations} iterations of Newton's \
         method velocities still change by {change:.3e} of the largest; raise the \
         infinite-shear viscosity, the index or the regularisation of the law"
    )]
    LawNotSolved {
        /// Iterations.
        iterations: usize,
        /// Relative change of the velocity in the last one.
        change: f64,
    },
    /// A flow with inertia whose estimated error is above the tolerance at the highest order.
    #[error(
        "the flow was requested to {tolerance:e}, but elements of the highest order {order} reach \
         {reached:e}; use a larger tolerance or a finer mesh (a smaller growth)"
    )]
    FlowNotConverged {
        /// The requested relative error.
        tolerance: f64,
        /// The estimated relative error.
        reached: f64,
        /// Polynomial degree of the velocities.
        order: usize,
    },
    /// A step in time whose equations are not solved.
    #[error(
        "the step of {step:.3e} from time {time} is not solved: its last iteration still changes \
         the velocity by {change:.3e} of itself; take a shorter step"
    )]
    StepFailed {
        /// Time before the step.
        time: f64,
        /// Length of the step.
        step: f64,
        /// Relative change in the last iteration.
        change: f64,
    },
    /// A step along which no mesh can follow the bodies.
    #[error(
        "at time {time} even a new mesh cannot follow the bodies over a step of {step:.3e}; take a \
         shorter one"
    )]
    MeshLost {
        /// Time before the step.
        time: f64,
        /// Length of the step.
        step: f64,
    },
    /// A point of a new mesh outside the old one.
    #[error(
        "the point ({:.6}, {:.6}) of a new mesh is outside the old one of the same domain",
        at[0], at[1]
    )]
    OutsideMesh {
        /// The point.
        at: [f64; 2],
    },
    /// An adaptive step that would have to be shorter than rounding allows.
    #[error(transparent)]
    StepTooShort(#[from] linalg::StepTooShort),
    /// A factorisation or a solve that failed.
    #[error(transparent)]
    Linalg(#[from] linalg::LinalgError),
}
