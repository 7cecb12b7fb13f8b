//! Resistance and rigid-motion mobility from expansions of given orders.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::frame::Frame;
use super::narrow_gap::{Block, NarrowGap};
use super::order::{self, GapCoordinates, MAX_ORDER_ON_CONTAINER};
use super::orders::Orders;
use super::scaled::{ScaledMobility, unscaled, unscaled_inverse};
use super::{collinear, spatial};
use crate::{HydroError, Medium, Resistance, Spheres};

/// Tolerance of iterations and of neglected couplings when the order is prescribed.
pub(super) const FIXED_ORDER_TOLERANCE: f64 = 1e-14;

/// A resistance matrix with the two parts of its error estimate.
pub(super) struct Reached {
    pub resistance: Resistance,
    /// Relative error due to the expansions of the spheres.
    pub expansions: f64,
    /// Relative error due to the expansions in narrow gaps.
    pub gaps: f64,
}

/// Resistance matrix from expansions of given orders, in the laboratory frame.
pub(super) fn resistance(
    spheres: &Spheres,
    medium: &Medium,
    orders: &Orders,
    tolerance: f64,
) -> Result<Reached, HydroError> {
    let frame = Frame::of(spheres, medium);
    let radii = spheres.radii();
    let gaps = order::gaps(spheres, medium);
    let xi = GapCoordinates::narrowest_of(&gaps, spheres.len());
    let invert =
        |mobility: &DMatrix<f64>| Ok(frame.to_laboratory(&unscaled_inverse(mobility, radii)?));
    let by_order = |scaled: ScaledMobility, tail: f64, orders: Orders| {
        let resistance = Resistance::new(invert(&scaled.full)?, invert(&scaled.lower)?, tail, orders);
        Ok(Reached {
            expansions: resistance.relative_error(),
            gaps: 0.0,
            resistance,
        })
    };
    if frame.collinear && !orders.off_axis {
        let orders = orders.without_gaps();
        let z: Vec<f64> = frame.centres.iter().map(|x| x.z).collect();
        let scaled = collinear::mobility(&z, radii, frame.surroundings, &orders)?;
        return by_order(scaled, order::tail(&xi, &orders), orders);
    }
    let narrow = NarrowGap::all(spheres, medium, orders)?;
    // In narrow gaps the resistance grows as 1/xi^2, and so does the condition number of the
    // system.
    let residual = 0.03 * tolerance.sqrt() * order::narrowest(&xi).min(1.0).powi(2);
    let mobility = |orders: &Orders| {
        let blocks: Vec<Vec<Block>> = narrow
            .par_iter()
            .map(|gap| gap.blocks(&frame, orders))
            .collect::<Result<_, _>>()?;
        let blocks = blocks.into_iter().flatten().collect();
        spatial::mobility(&frame, radii, orders, blocks, (tolerance, residual))
    };
    if narrow.is_empty() {
        return by_order(mobility(orders)?, order::tail(&xi, orders), orders.clone());
    }
    let matrix = invert(&mobility(orders)?.full)?;
    let lowered = invert(&mobility(&orders.lowered())?.full)?;
    let tail = order::tail(&xi.widened(), orders);
    let of_expansions = Resistance::new(matrix, lowered, tail, orders.clone());
    let mut of_gaps = DMatrix::zeros(6 * spheres.len(), 6 * spheres.len());
    for gap in &narrow {
        let alone = resistance_of_gap(gap, tolerance)?;
        let rows: Vec<usize> = gap.indices.iter().flat_map(|&k| 6 * k..6 * k + 6).collect();
        let error = (alone.matrix() - alone.coarser()) * alone.tail();
        for (i, &row) in rows.iter().enumerate() {
            for (j, &column) in rows.iter().enumerate() {
                of_gaps[(row, column)] += error[(i, j)];
            }
        }
    }
    let matrix = of_expansions.matrix();
    let change = (matrix - of_expansions.coarser()) * tail;
    let expansions = of_expansions.relative_error();
    let gaps = of_expansions.relative_difference(&(matrix + &of_gaps));
    let coarser = matrix - change - of_gaps;
    Ok(Reached {
        resistance: Resistance::new(matrix.clone(), coarser, 1.0, orders.clone()),
        expansions,
        gaps,
    })
}

/// Resistance of the two surfaces of a narrow gap alone.
fn resistance_of_gap(gap: &NarrowGap, tolerance: f64) -> Result<Resistance, HydroError> {
    Ok(resistance(&gap.spheres, &gap.medium, &gap.orders, tolerance)?.resistance)
}

/// Rotne-Prager-Yamakawa mobility in a medium with a boundary: no reflections between spheres.
pub(crate) fn rigid_mobility(
    spheres: &Spheres,
    medium: &Medium,
) -> Result<DMatrix<f64>, HydroError> {
    spheres.check_inside(medium)?;
    let frame = Frame::of(spheres, medium);
    let xi = GapCoordinates::narrowest_of(&order::gaps(spheres, medium), spheres.len());
    // One force and one torque per sphere (the modes of order 2 with l = 1), and the order of the
    // container that they need.
    let orders = Orders {
        spheres: vec![2; spheres.len()],
        container: order::for_tolerance(&xi, medium, 1e-10)
            .container
            .min(MAX_ORDER_ON_CONTAINER),
        ..Orders::all(spheres.len(), medium, 2)
    };
    let scaled = spatial::rigid_mobility(&frame, spheres.radii(), &orders);
    let inverse = |units: f64| 1.0 / units;
    Ok(frame.to_laboratory(&unscaled(&scaled, spheres.radii(), inverse)))
}
