//! Shape space: the motion of a free swimmer without inertia, tabulated once.
//!
//! In unbounded fluid without external loads the velocity depends on the shape alone and is linear in the rates of the
//! lengths: $\xi = A(s)\, \dot s$ in the swimmer's frame, with dissipation $\dot s \cdot G(s)\, \dot s$ (Shapere & Wilczek 1989). A
//! [`ShapeSpace`] interpolates the answers of a model over a box of lengths; any gait within it then costs microseconds a solve.
//!
//! It saves evaluations of the model when a gait comes by the same shapes again, and not otherwise: a gait of one cycle along
//! lines of shape space takes six solves a phase, a table at least five for the same line. So [`speed_up`] counts both first.

mod chebyshev;
mod space;
mod tabulated;

pub use space::ShapeSpace;
pub use tabulated::Tabulated;
