//! Solutions of a rigid body in a linear flow, superposed from a few orientations.
//!
//! Consider one rigid body in unbounded fluid. In the axes of the body, the flow around it is
//! linear in a vector `d` of few components: the external forces and torques, the rate of strain of
//! the background flow, and the slip. The solution depends on the position and the rotation `R` of
//! the body only through `d` and the background velocity:
//!
//! ```text
//! R^T (U - u(x)), R^T (ω - curl u / 2), R^T forces = linear functions of d
//! d = (R^T F, R^T T, R^T E R, slip)
//! ```
//!
//! with the undisturbed flow `u` and its rate of strain `E` (Brenner 1964; Kim & Karrila 1991,
//! section 5.2). A model solves for as many orientations `R` as `d` has independent components, at
//! most 15; the solution for any other orientation is a linear combination. A body that tumbles in
//! shear takes five solutions, and one more as a check, instead of hundreds. A model that uses
//! symmetry planes keeps the body in them: one plane leaves rotations about its normal, two none,
//! and `d` has fewer independent components.

mod drives;
mod solved;
mod superposed;

pub use superposed::Superposed;
