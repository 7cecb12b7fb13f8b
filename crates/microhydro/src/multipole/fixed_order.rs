//! Resistance and rigid-motion mobility from expansions of given orders.

use nalgebra::DMatrix;

use super::frame::Frame;
use super::order::{self, GapCoordinates, MAX_ORDER_ON_CONTAINER, Orders};
use super::scaled::{unscaled, unscaled_inverse};
use super::{collinear, spatial};
use crate::{HydroError, Medium, Resistance, Spheres};

/// Tolerance of iterations and of neglected couplings when the order is prescribed.
pub(super) const FIXED_ORDER_TOLERANCE: f64 = 1e-14;

/// Resistance matrix from expansions of given orders, in the laboratory frame.
pub(super) fn resistance(
    spheres: &Spheres,
    medium: &Medium,
    xi: &GapCoordinates,
    orders: &Orders,
    tolerance: f64,
) -> Result<Resistance, HydroError> {
    let frame = Frame::of(spheres, medium);
    let radii = spheres.radii();
    let scaled = if frame.collinear {
        let z: Vec<f64> = frame.centres.iter().map(|x| x.z).collect();
        collinear::mobility(&z, radii, frame.surroundings, orders)?
    } else {
        // In narrow gaps the resistance grows as 1/xi^2, and so does the condition number of the
        // system.
        let residual = 0.03 * tolerance.sqrt() * order::narrowest(xi).min(1.0).powi(2);
        spatial::mobility(&frame, radii, orders, (tolerance, residual))?
    };
    let invert =
        |mobility: &DMatrix<f64>| Ok(frame.to_laboratory(&unscaled_inverse(mobility, radii)?));
    Ok(Resistance::new(
        invert(&scaled.full)?,
        invert(&scaled.lower)?,
        order::tail(xi, orders),
        orders.dofs(),
    ))
}

/// Rotne-Prager-Yamakawa mobility in a medium with a boundary: no reflections between spheres.
pub(crate) fn rigid_mobility(
    spheres: &Spheres,
    medium: &Medium,
) -> Result<DMatrix<f64>, HydroError> {
    spheres.check_inside(medium)?;
    let frame = Frame::of(spheres, medium);
    // One force and one torque per sphere (the modes of order 2 with l = 1), and the order of the
    // container that they need.
    let orders = Orders {
        spheres: vec![2; spheres.len()],
        container: order::for_tolerance(&order::gap_coordinates(spheres, medium), medium, 1e-10)
            .container
            .min(MAX_ORDER_ON_CONTAINER),
    };
    let scaled = spatial::rigid_mobility(&frame, spheres.radii(), &orders);
    let inverse = |units: f64| 1.0 / units;
    Ok(frame.to_laboratory(&unscaled(&scaled, spheres.radii(), inverse)))
}
