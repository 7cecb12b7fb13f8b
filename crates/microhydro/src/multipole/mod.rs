//! Multipole expansions: Stokes flow around spheres to any requested accuracy.
//!
//! Notation: `Y_lm` are real orthonormal spherical harmonics, `n` the outward normal of a sphere of
//! radius `a`, `∇_S` the surface gradient of the unit sphere.
//!
//! 1. *Unknowns* (`modes`). The force density on each sphere (and on the container) is expanded
//!    in the vector spherical harmonics `W_lm`, `X_lm`, `V_lm`, the eigenfunctions of the
//!    single-layer operator of a sphere (Corona & Veerapaneni 2018). Outside the sphere they
//!    drive the three families of Lamb's solution: `W` those with pressure (force, stresslet,
//!    ...), `X` those with radial vorticity (torque, ...), `V` the potential flows (source
//!    multipoles).
//! 2. *Translation* (`axial_translation`, `lamb`). The outgoing flow of one sphere is expanded
//!    about the centre of another in Lamb's general solution for the interior of a sphere (Lamb
//!    1932, art. 336; Happel & Brenner 1983, section 3-2). Along the line of centres the
//!    coefficients have closed forms for each azimuthal number; `rotation` turns other
//!    directions onto it.
//! 3. *Boundary* (`reflection`, `wall_image`). A wall adds the image of each sphere by
//!    Lorentz's reflection (Lorentz 1907; Kim & Karrila 1991, section 12.1). A container is one
//!    more expansion, whose flow is regular inside.
//! 4. *Galerkin system* (`collinear`, or `coupling` and `system`). Testing the velocity on each
//!    sphere with the same harmonics, scaled by the square roots of their self energies, gives
//!    the identity plus the couplings: a symmetric positive definite matrix.
//! 5. *Mobility* (`elimination`, `spatial`). A rigid motion is `W_1` and `X_1`; the
//!    Schur complement of all other modes is the mobility matrix of the spheres, its inverse
//!    the resistance.
//!
//! 6. *Surface velocities* (`slip_expansion`, `surface_flow`). Slip and background flows are
//!    boundary values in all three families (`vector_harmonics`), up to the order that they need;
//!    the same elimination gives the velocities of force-free spheres. `stresslet` has the
//!    stresslets, the moments of `W_2`.
//!
//! 7. *Many spheres* (`mobility`). The Galerkin system without a matrix: couplings of pairs by
//!    `pair_product`, in the orders of `expansion_plan`, and of distant spheres by `cells` around
//!    them, containers whose expansions `cell_shift` makes of theirs. Slip is the right-hand side
//!    of the multipoles.
//!
//! The resistance converges spectrally with the order, and from below; its error is the square of
//! the error of the velocity field. Spheres on an axis of symmetry of their medium decouple by
//! azimuthal number. `truncation` predicts the order that a gap needs and estimates the error;
//! `narrow_gap` (lubrication) eliminates the high degrees of two close surfaces for the pair alone.

mod adaptive;
mod axial_translation;
mod axis_turn;
mod boundary_product;
mod cell_shift;
mod cells;
mod collinear;
mod coupling;
mod elimination;
mod expansion_plan;
mod far_images;
mod fixed_order;
mod frame;
mod interior;
mod lamb;
mod line_of_centres;
mod memory;
mod mobility;
mod modes;
mod narrow_gap;
mod orders;
mod pair_preconditioner;
mod pair_product;
mod predicted_time;
mod reflection;
mod rotation;
mod scaled;
mod slip_expansion;
mod sources;
mod spatial;
mod stresslet;
mod surface_flow;
mod surface_orders;
mod system;
mod three_spheres;
mod truncation;
mod vector_harmonics;
mod velocity_field;
mod wall_image;

pub use self::adaptive::{orders_for, resistance, resistance_at, resistance_best};
pub(crate) use self::boundary_product::boundary_product;
pub(crate) use self::elimination::inverse;
pub use self::expansion_plan::ExpansionCost;
pub(crate) use self::fixed_order::rigid_mobility;
pub(crate) use self::memory::check_spheres;
pub use self::mobility::{MultipoleMobility, SlipDrive, Variant};
pub use self::orders::{Accuracy, Orders};
pub use self::predicted_time::{predicted_order, predicted_seconds, predicted_size};
pub(crate) use self::rotation::rotation_to_z;
pub use self::slip_expansion::{SlipModes, SphereSlip};
pub use self::stresslet::{SphereStresslets, stresslets};
pub use self::surface_flow::{SurfaceFlow, surface_flow};
pub use self::velocity_field::VelocityField;
