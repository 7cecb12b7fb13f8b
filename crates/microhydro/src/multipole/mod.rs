//! Multipole expansions: Stokes flow around spheres to any accuracy.
//!
//! The force densities on the spheres (and on a container) are the unknowns, expanded in the vector spherical harmonics that diagonalise
//! the single layer of a sphere. Testing with the same harmonics gives a symmetric positive definite
//! Galerkin system, the identity plus couplings known in closed form. It converges spectrally, from below for the resistance, and
//! the error of the resistance is the square of that of the flow. Spheres on an axis of their surroundings decouple by azimuthal number.

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

/// How accurate a multipole expansion shall be.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Accuracy {
    /// Error of the resistance relative to the drag of the spheres: the order is raised until the estimate is below it.
    pub tolerance: f64,
    /// The order of all expansions, instead of one found from the gaps and the tolerance.
    pub order: Option<usize>,
}

impl Default for Accuracy {
    /// `1e-8`: the couplings are summed to rounding, so the last digits cost little.
    fn default() -> Self {
        Self::relative(1e-8)
    }
}

impl Accuracy {
    /// A relative error of the resistance.
    pub fn relative(tolerance: f64) -> Self {
        Self {
            tolerance,
            order: None,
        }
    }

    /// A fixed order of all expansions; at least 2.
    pub fn order(order: usize) -> Self {
        Self {
            tolerance: f64::INFINITY,
            order: Some(order),
        }
    }
}

/// Mobilities in units where each rigid motion of a lone sphere has mobility 1, for the orders asked for and for two less.
///
/// Six rows a sphere: translation, then rotation, each with `m` = -1, 0, 1 (y, z, x); rotations have the sign of $n \times e$.
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

/// Axis of `m` = -1, 0, 1 among x, y, z.
const AXES: [usize; 3] = [1, 2, 0];

/// The grand resistance of spheres: forces and torques that they exert on the fluid for their velocities and angular velocities.
///
/// Six rows and columns a sphere: three of translation, three of rotation about its centre. Viscosity 1: multiply by the viscosity.
/// Spheres on one axis (which goes through the container's centre, or along the wall's normal) cost 0.1 ms for three spheres
/// with gaps of four radii; others `n^3/3` operations for `n` multipoles in all, and for many of them `O(L^3)` for each pair,
/// unknown motion and iteration. Narrow gaps in space are completed by
/// the exact two-sphere resistance.
///
/// # Errors
/// Spheres outside the medium; gaps so narrow that the accuracy is out of reach.
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
    // below this, rounding rules
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
        // the least orders do for goals far below those that ask for them: the same again would claim the same
        let mut raised = order::for_tolerance(&closeness, medium, goal);
        while raised == orders && goal > f64::MIN_POSITIVE {
            goal *= 0.1;
            raised = order::for_tolerance(&closeness, medium, goal);
        }
        orders = raised;
    }
}

/// An estimate that stays above the tolerance when orders aim so far below it is rounding.
const LEAST_GOAL: f64 = 1e-4;

/// What iterations and far couplings may err by when the order is given and no tolerance.
const FIXED_ORDER_TOLERANCE: f64 = 1e-14;

/// The resistance from expansions of given orders.
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
        // in narrow gaps the resistance is large as 1/xi^2, and the rest of the system as ill conditioned
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

/// The mobility of rigid motions without reflections, for a medium with a boundary: Rotne, Prager & Yamakawa's.
pub(crate) fn rigid_mobility(
    spheres: &Spheres,
    medium: &Medium,
) -> Result<DMatrix<f64>, HydroError> {
    spheres.check_inside(medium)?;
    let frame = frame::Frame::of(spheres, medium);
    // one force and one torque a sphere, and as much of the container's wall as they need
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

/// The resistance from a scaled mobility, in the axes of the frame.
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

/// A matrix over scaled modes in the units and axes of velocities or forces: each row and column times what `factor` makes of its unit.
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

/// Square roots of the drags of lone spheres, in the order of scaled mobilities; negative for rotations, whose harmonic $X_1$ is
/// $n \times e$ while a rotation is $e \times n$.
fn drag_units(radii: &[f64]) -> Vec<f64> {
    let of = |&a: &f64| {
        let (drag, torque) = ((6.0 * PI * a).sqrt(), (8.0 * PI * a.powi(3)).sqrt());
        [drag, drag, drag, -torque, -torque, -torque]
    };
    radii.iter().flat_map(of).collect()
}
