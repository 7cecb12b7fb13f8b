//! Multipole expansions: Stokes flow around spheres to any requested accuracy.
//!
//! Notation: `Y_lm` are real orthonormal spherical harmonics, `n` the outward normal of a sphere of
//! radius `a`, `∇_S` the surface gradient of the unit sphere.
//!
//! 1. *Unknowns* (`modes`). The force density on each sphere (and on the container) is expanded in
//! the vector spherical harmonics `W_lm`, `X_lm`, `V_lm`, the eigenfunctions of the single-layer
//! operator of a sphere (Corona & Veerapaneni 2018). Outside the sphere they drive the three
//! families of Lamb's solution: `W` those with pressure (force, stresslet, ...), `X` those with
//! radial vorticity (torque, ...), `V` the potential flows (source multipoles).
//! 2. *Translation* (`axial_translation`, `lamb`). The outgoing flow of one sphere is expanded
//! about the centre of another in Lamb's general solution for the interior of a sphere (Lamb 1932,
//! art. 336; Happel & Brenner 1983, section 3-2). Along the line of centres the coefficients have
//! closed forms for each azimuthal number; `rotation` turns other directions onto it.
//! 3. *Boundary* (`reflection`, `wall_image`). A wall adds the image of each sphere by Lorentz's
//! reflection (Lorentz 1907; Kim & Karrila 1991, section 12.1). A container is one more expansion,
//! whose flow is regular inside.
//! 4. *Galerkin system* (`collinear`, or `coupling` and `system`). Testing the velocity on each
//! sphere with the same harmonics, scaled by the square roots of their self energies, gives the
//! identity plus the couplings: a symmetric positive definite matrix.
//! 5. *Mobility* (`elimination`, `dense`, `spatial`). A rigid motion is `W_1` and `X_1`; the Schur
//! complement of all other modes is the mobility matrix of the spheres, its inverse the resistance.
//!
//! The resistance converges spectrally with the order, and from below; its error is the square of
//! the error of the velocity field. Spheres on an axis of symmetry of their medium decouple by
//! azimuthal number. `order` predicts the order that a gap needs and estimates the error;
//! `lubrication` adds pair corrections where that order would be too high.

mod axial;
mod collinear;
mod dense;
mod elimination;
mod frame;
mod lamb;
mod link;
mod lubrication;
mod modes;
mod order;
mod reflection;
mod rotation;
mod spatial;
mod system;
mod velocity_field;
mod wall_block;

use std::f64::consts::PI;

use nalgebra::DMatrix;

use self::order::Orders;
pub use self::velocity_field::VelocityField;
use crate::{HydroError, Medium, Resistance, Spheres};

/// Requested accuracy of a multipole expansion.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Accuracy {
    /// Relative error of the resistance: the order is raised until the estimate is below it.
    pub tolerance: f64,
    /// Fixed order of all expansions; `None` derives the orders from the gaps and the tolerance.
    pub order: Option<usize>,
}

impl Default for Accuracy {
    /// A tolerance of `1e-8`: convergence is spectral, so the last digits cost little.
    fn default() -> Self {
        Self::relative(1e-8)
    }
}

impl Accuracy {
    /// Accuracy given by a relative error of the resistance.
    pub fn relative(tolerance: f64) -> Self {
        Self {
            tolerance,
            order: None,
        }
    }

    /// Accuracy given by a fixed order of all expansions, at least 2.
    pub fn order(order: usize) -> Self {
        Self {
            tolerance: f64::INFINITY,
            order: Some(order),
        }
    }
}

/// Scaled mobility matrices for the requested orders and for orders lower by two.
///
/// In these units each rigid motion of a lone sphere has mobility 1. Six rows per sphere:
/// translation, then rotation, each with `m = -1, 0, 1` (the axes y, z, x). Rotations have the sign
/// of the harmonic `X_1 = n × e`.
struct Scaled {
    full: DMatrix<f64>,
    lower: DMatrix<f64>,
}

impl Scaled {
    fn zeros(spheres: usize) -> Self {
        Self {
            full: DMatrix::zeros(6 * spheres, 6 * spheres),
            lower: DMatrix::zeros(6 * spheres, 6 * spheres),
        }
    }
}

/// Index of the Cartesian axis (x, y, z) that belongs to `m = -1, 0, 1`.
const AXES: [usize; 3] = [1, 2, 0];

/// Grand resistance matrix of spheres to a given accuracy.
///
/// Forces and torques (about the centres) that the spheres exert on the fluid for their velocities
/// and angular velocities: six rows and columns per sphere, translation, then rotation. Viscosity
/// 1: multiply by the viscosity.
///
/// Cost: spheres on one axis (through the container's centre, or along the wall's normal) take 0.1
/// ms for three spheres with gaps of four radii. Other arrangements take `n^3/3` operations for `n`
/// multipoles in all; large ones are solved by iteration, with `O(L^3)` operations per pair, rigid
/// motion and iteration for the order `L`. Off an axis, the orders are bounded, and narrow gaps are
/// corrected by the exact two-sphere resistance (Durlofsky, Brady & Bossis 1987).
///
/// # Errors
/// Spheres outside the medium; gaps so narrow that the accuracy is out of reach; failed solves.
pub fn resistance(
    spheres: &Spheres,
    medium: &Medium,
    accuracy: &Accuracy,
) -> Result<Resistance, HydroError> {
    spheres.check_inside(medium)?;
    let closeness = order::closeness(spheres, medium);
    if let Some(order) = accuracy.order {
        let orders = Orders::all(spheres.len(), medium, order);
        return at_orders(spheres, medium, &closeness, &orders, FIXED_ORDER_TOLERANCE);
    }
    // Below this tolerance rounding errors dominate.
    let tolerance = accuracy.tolerance.max(1e-13);
    let mut goal = order::first_goal(&closeness, spheres.len(), tolerance);
    let mut orders = order::for_tolerance(&closeness, medium, goal);
    loop {
        let (result, completed) =
            lubrication::completed(spheres, medium, &closeness, &orders, goal.min(tolerance))?;
        let claimed = result.relative_error();
        let no_more = goal <= tolerance && completed;
        if no_more || claimed <= tolerance || goal < LEAST_GOAL * tolerance {
            return Ok(result);
        }
        goal *= (0.5 * tolerance / claimed).clamp(0.01, 0.5);
        // The lowest orders suffice for targets far below the one that selected them. The same
        // orders would give the same estimate, so the target is lowered until the orders rise.
        let mut raised = order::for_tolerance(&closeness, medium, goal);
        while raised == orders && goal > f64::MIN_POSITIVE {
            goal *= 0.1;
            raised = order::for_tolerance(&closeness, medium, goal);
        }
        orders = raised;
    }
}

/// Lowest target over the tolerance. An estimate still above the tolerance there is rounding.
const LEAST_GOAL: f64 = 1e-4;

/// Tolerance of iterations and of neglected couplings when the order is prescribed.
const FIXED_ORDER_TOLERANCE: f64 = 1e-14;

/// Resistance matrix from expansions of given orders, in the laboratory frame.
fn at_orders(
    spheres: &Spheres,
    medium: &Medium,
    closeness: &(Vec<f64>, f64),
    orders: &Orders,
    tolerance: f64,
) -> Result<Resistance, HydroError> {
    let frame = frame::Frame::of(spheres, medium);
    let radii = spheres.radii();
    let scaled = if frame.collinear {
        let z: Vec<f64> = frame.centres.iter().map(|x| x.z).collect();
        collinear::mobility(&z, radii, frame.around, orders)?
    } else {
        // In narrow gaps the resistance grows as 1/xi^2, and so does the condition number of the
        // system.
        let residual = 0.03 * tolerance.sqrt() * order::narrowest(closeness).min(1.0).powi(2);
        spatial::mobility(&frame, radii, orders, (tolerance, residual))?
    };
    let invert =
        |mobility: &DMatrix<f64>| Ok(frame.to_laboratory(&unscaled_inverse(mobility, radii)?));
    Ok(Resistance::new(
        invert(&scaled.full)?,
        invert(&scaled.lower)?,
        order::tail(closeness, orders),
        orders.dofs(),
    ))
}

/// Rotne-Prager-Yamakawa mobility in a medium with a boundary: no reflections between spheres.
pub(crate) fn rigid_mobility(
    spheres: &Spheres,
    medium: &Medium,
) -> Result<DMatrix<f64>, HydroError> {
    spheres.check_inside(medium)?;
    let frame = frame::Frame::of(spheres, medium);
    // One force and one torque per sphere (the modes of order 2 with l = 1), and the order of the
    // container that they need.
    let orders = Orders {
        spheres: vec![2; spheres.len()],
        container: order::for_tolerance(&order::closeness(spheres, medium), medium, 1e-10)
            .container
            .min(lubrication::MOST_ON_CONTAINER),
    };
    let scaled = spatial::rigid_mobility(&frame, spheres.radii(), &orders);
    let inverse = |units: f64| 1.0 / units;
    Ok(frame.to_laboratory(&unscaled(&scaled, spheres.radii(), inverse)))
}

/// Resistance matrix from a scaled mobility matrix, along the axes of the frame.
fn unscaled_inverse(mobility: &DMatrix<f64>, radii: &[f64]) -> Result<DMatrix<f64>, HydroError> {
    let inverse = mobility
        .clone()
        .cholesky()
        .ok_or(HydroError::FactorisationFailed {
            matrix: "mobility matrix",
            size: mobility.nrows(),
        })?
        .inverse();
    Ok(unscaled(&inverse, radii, |unit| unit))
}

/// Converts a matrix over scaled modes to physical units and to x, y, z order; rows and columns are
/// multiplied by `factor` of their [`drag_units`].
fn unscaled(matrix: &DMatrix<f64>, radii: &[f64], factor: impl Fn(f64) -> f64) -> DMatrix<f64> {
    let n = matrix.nrows();
    let units: Vec<f64> = drag_units(radii).into_iter().map(factor).collect();
    let place = |row: usize| 3 * (row / 3) + AXES[row % 3];
    let mut result = DMatrix::zeros(n, n);
    for i in 0..n {
        for j in 0..n {
            result[(place(i), place(j))] = units[i] * units[j] * matrix[(i, j)];
        }
    }
    result
}

/// Square roots of the drag coefficients of lone spheres, in the order of [`ScaledMobility`].
///
/// Negative for rotations: the harmonic `X_1` is `n × e`, whereas a rotation about `e` is `e × n`.
fn drag_units(radii: &[f64]) -> Vec<f64> {
    let of = |&a: &f64| {
        let (drag, torque) = ((6.0 * PI * a).sqrt(), (8.0 * PI * a.powi(3)).sqrt());
        [drag, drag, drag, -torque, -torque, -torque]
    };
    radii.iter().flat_map(of).collect()
}
