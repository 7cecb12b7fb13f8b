//! Solutions of a rigid body in a linear flow, superposed from a few orientations.
//!
//! In the axes of a rigid body that is alone in unbounded fluid, the flow around it depends
//! linearly on a few numbers: the components of the external forces and torques, the rate of strain
//! of the background flow, and the slip. Its position and its rotation change nothing else
//!
//! ```text
//! U - u(x), ω - curl u / 2, forces = linear function of d
//! d = (R^T F, R^T T, R^T E R, slip)
//! ```
//!
//! (Brenner 1964; Kim & Karrila 1991, section 5.2). A model solves for as many orientations `R` as
//! there are independent components of `d`; every further orientation is a linear combination. A
//! tumbling body takes nine solutions instead of hundreds.

mod drives;
mod solved;
mod superposed;

pub use superposed::Superposed;
