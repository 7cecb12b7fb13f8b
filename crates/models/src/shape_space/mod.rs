//! Tables over the shapes of a free swimmer, from which solutions are interpolated.
//!
//! In unbounded fluid without external loads the velocity of a swimmer without inertia depends only
//! on its shape `s`, and linearly on the rates of the joints:
//!
//! ```text
//! ξ = A(s) ds/dt         velocity in the frame of the swimmer
//! P = ds/dt · G(s) ds/dt   power
//! ```
//!
//! (Shapere & Wilczek 1989). A [`ShapeSpace`] interpolates the solutions of a model over a box of
//! lengths; every gait in the box then costs microseconds per solution.
//!
//! In a container the velocity also depends on the position of the swimmer. All shapes of a table
//! have the same mean of the centres of the bodies, that of the start. A stroke moves this mean by
//! a few per cent of the changes of length only; the effect of this motion is an error bar.
//!
//! A table saves solutions of the model only if a gait returns to the same shapes. One cycle along
//! lines in shape space takes six solutions per phase, and a table at least five for the same line.

mod chebyshev;
mod geometry;
mod placement;
mod record;
mod sampler;
mod solved_shapes;
mod space;
mod tabulated;

pub use chebyshev::{Interpolant, chebyshev_node};
pub use geometry::{LocalGeometry, ShapeGeometry};
pub use solved_shapes::{SolvedShapes, TablePart};
pub use space::ShapeSpace;
pub use tabulated::Tabulated;
