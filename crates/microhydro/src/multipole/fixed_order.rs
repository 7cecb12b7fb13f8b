//! Resistance and rigid-motion mobility from expansions of given orders.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::boundary_product::container_order;
use super::frame::Frame;
use super::memory;
use super::narrow_gap::{Block, Eliminated, NarrowGap};
use super::orders::Orders;
use super::scaled::{ScaledMobility, unscaled, unscaled_inverse};
use super::truncation::{self, GapCoordinates};
use super::{collinear, spatial, three_spheres};
use crate::error::check_finite;
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
///
/// # Errors
/// [`HydroError::TooLarge`], failed solves, [`HydroError::NotFinite`].
pub(super) fn resistance(
    spheres: &Spheres,
    medium: &Medium,
    orders: &Orders,
    tolerance: f64,
) -> Result<Reached, HydroError> {
    memory::check_spheres(spheres.len())?;
    let reached = unchecked_resistance(spheres, medium, orders, tolerance)?;
    let error = reached.resistance.relative_error();
    check_finite("the resistance of the spheres", &[error])?;
    Ok(reached)
}

fn unchecked_resistance(
    spheres: &Spheres,
    medium: &Medium,
    orders: &Orders,
    tolerance: f64,
) -> Result<Reached, HydroError> {
    let gaps = truncation::gaps(spheres, medium);
    let arrangement = Arrangement {
        frame: Frame::new(spheres, medium),
        radii: spheres.radii(),
        xi: GapCoordinates::narrowest_of(&gaps, spheres.len()),
        orders,
        tolerance,
    };
    let frame = &arrangement.frame;
    if frame.collinear && !orders.off_axis {
        let used = orders.without_gaps();
        memory::check_on_axis(&used)?;
        let z: Vec<f64> = frame.centres.iter().map(|x| x.z).collect();
        let scaled = collinear::mobility(&z, spheres.radii(), frame.surroundings, &used)?;
        return arrangement.by_order(scaled, &used);
    }
    let narrow = NarrowGap::all(spheres, medium, orders)?;
    if narrow.is_empty() {
        return arrangement.by_order(arrangement.mobility()?, orders);
    }
    arrangement.with_narrow_gaps(&narrow)
}

/// Spheres in the frame in which they are solved, with the requested orders.
struct Arrangement<'a> {
    frame: Frame,
    radii: &'a [f64],
    xi: GapCoordinates,
    orders: &'a Orders,
    tolerance: f64,
}

impl Arrangement<'_> {
    /// Resistance in the laboratory frame from a scaled mobility.
    fn invert(&self, mobility: &DMatrix<f64>) -> Result<DMatrix<f64>, HydroError> {
        let inverse = unscaled_inverse(mobility, self.radii)?;
        Ok(self.frame.to_laboratory(&inverse))
    }

    /// Tolerances of neglected couplings and of the residuals of iterations.
    ///
    /// In narrow gaps the resistance grows as 1/xi^2, and so does the condition number of the
    /// system; a neglected coupling is amplified as much.
    fn accuracy(&self) -> (f64, f64) {
        let amplified = truncation::narrowest(&self.xi).min(1.0).powi(2);
        let tolerance = self.tolerance;
        (tolerance * amplified, 0.03 * tolerance.sqrt() * amplified)
    }

    /// Mobility for the orders of the spheres alone.
    fn mobility(&self) -> Result<ScaledMobility, HydroError> {
        spatial::mobility(&self.frame, self.radii, self.orders, self.accuracy())
    }

    /// The resistance whose error is estimated from lower orders alone.
    fn by_order(&self, scaled: ScaledMobility, used: &Orders) -> Result<Reached, HydroError> {
        let [full, lower] = [self.invert(&scaled.full)?, self.invert(&scaled.lower)?];
        let (tail, orders) = (truncation::tail(&self.xi, used), self.orders.clone());
        let resistance = Resistance::new(full, lower, tail, orders, self.radii, used.dofs());
        Ok(Reached {
            expansions: resistance.truncation_error(),
            gaps: 0.0,
            resistance,
        })
    }

    /// The resistance with the high degrees of narrow gaps.
    fn with_narrow_gaps(&self, narrow: &[NarrowGap]) -> Result<Reached, HydroError> {
        let size = 6 * self.radii.len();
        let mut of_gaps = DMatrix::zeros(size, size);
        // Higher orders of the expansions leave less to the sum over pairs; those of gaps do not.
        let mut of_pairs = of_gaps.clone();
        let [matrix, lowered] = match self.gaps_eliminated(narrow) {
            // Among three spheres close to each other the sum over the gaps may eliminate too much.
            Err(HydroError::FactorisationFailed { .. }) => {
                self.gaps_added(narrow, &mut of_pairs)?
            }
            other => other?,
        };
        for gap in narrow {
            let alone = gap.resistance(&gap.orders, self.tolerance)?;
            gap.add(
                &mut of_gaps,
                &((alone.matrix() - alone.coarser()) * alone.tail()),
            );
        }
        let new = |matrix: DMatrix<f64>, coarser: DMatrix<f64>, tail: f64| {
            Resistance::new(
                matrix,
                coarser,
                tail,
                self.orders.clone(),
                self.radii,
                self.orders.dofs(),
            )
        };
        let tail = truncation::tail(&self.xi.widened(), self.orders);
        let of_expansions = new(matrix, lowered, tail);
        let matrix = of_expansions.matrix();
        let change = (matrix - of_expansions.coarser()) * tail;
        let coarser_gaps = matrix - &of_gaps - &of_pairs;
        Ok(Reached {
            expansions: of_expansions.truncation_error()
                + of_expansions.relative_difference(&(matrix + of_pairs)),
            gaps: of_expansions.relative_difference(&(matrix + of_gaps)),
            resistance: new(matrix.clone(), &coarser_gaps - change, 1.0)
                .with_coarser_gaps(coarser_gaps),
        })
    }

    /// Resistances for the orders and for lower ones, with the high degrees of the narrow gaps
    /// eliminated from the Galerkin matrix.
    fn gaps_eliminated(&self, narrow: &[NarrowGap]) -> Result<[DMatrix<f64>; 2], HydroError> {
        let (frame, orders) = (&self.frame, self.orders);
        let blocks: Vec<[Vec<Block>; 2]> = narrow
            .par_iter()
            .map(|gap| {
                let wanted = [Eliminated::All, Eliminated::LoweredExpansions];
                gap.blocks(frame, orders, usize::MAX, wanted)
            })
            .collect::<Result<_, _>>()?;
        let (of_full, of_lowered): (Vec<_>, Vec<_>) = blocks
            .into_iter()
            .map(|[full, lowered]| (full, lowered))
            .unzip();
        let resistance = |orders: &Orders, blocks: Vec<Vec<Block>>| {
            let mut blocks: Vec<Block> = blocks.into_iter().flatten().collect();
            blocks.extend(three_spheres::blocks(frame, self.radii, orders));
            let accuracy = self.accuracy();
            self.invert(&spatial::mobility_with_blocks(
                frame, self.radii, orders, blocks, accuracy,
            )?)
        };
        let lowered = resistance(&orders.lowered(), of_lowered)?;
        Ok([resistance(orders, of_full)?, lowered])
    }

    /// The same by adding what the orders miss of the resistances of two surfaces; its uncertainty
    /// is added to `of_pairs`.
    fn gaps_added(
        &self,
        narrow: &[NarrowGap],
        of_pairs: &mut DMatrix<f64>,
    ) -> Result<[DMatrix<f64>; 2], HydroError> {
        let scaled = self.mobility()?;
        let mut matrices = [self.invert(&scaled.full)?, self.invert(&scaled.lower)?];
        for gap in narrow {
            let missed = gap.missed(self.orders, self.tolerance)?;
            for (matrix, missed) in matrices.iter_mut().zip(&missed) {
                gap.add(matrix, missed);
            }
            gap.add(of_pairs, &(&missed[0] * PAIR_UNCERTAINTY));
        }
        Ok(matrices)
    }
}

/// Relative uncertainty of the sum of two-sphere resistances, because other spheres change the flow
/// in the gap.
///
/// Measured with three spheres around a gap of 0.02: a sixth of this value (an error of 1.8e-4
/// where the correction was 0.1).
const PAIR_UNCERTAINTY: f64 = 0.01;

impl NarrowGap {
    /// Resistance of the two surfaces alone.
    fn resistance(&self, orders: &Orders, tolerance: f64) -> Result<Resistance, HydroError> {
        Ok(resistance(&self.spheres, &self.medium, orders, tolerance)?.resistance)
    }

    /// Resistances of the two surfaces alone that the orders of the whole arrangement miss, and
    /// that orders lower by two miss (Durlofsky, Brady & Bossis 1987).
    fn missed(&self, orders: &Orders, tolerance: f64) -> Result<[DMatrix<f64>; 2], HydroError> {
        let converged = self.resistance(&self.orders, tolerance)?;
        let own = Orders {
            spheres: self.indices.iter().map(|&k| orders.spheres[k]).collect(),
            container: match self.orders.container {
                0 => 0,
                _ => orders.container,
            },
            ..self.orders.clone()
        };
        let used = self.resistance(&own, tolerance)?;
        Ok([used.matrix(), used.coarser()].map(|used| converged.matrix() - used))
    }

    /// Adds a matrix over the spheres of the gap to one over all spheres.
    fn add(&self, all: &mut DMatrix<f64>, matrix: &DMatrix<f64>) {
        let rows: Vec<usize> = (self.indices.iter())
            .flat_map(|&k| 6 * k..6 * k + 6)
            .collect();
        for (i, &row) in rows.iter().enumerate() {
            for (j, &column) in rows.iter().enumerate() {
                all[(row, column)] += matrix[(i, j)];
            }
        }
    }
}

/// Rotne-Prager-Yamakawa mobility in a medium with a boundary: no reflections between spheres.
pub(crate) fn rigid_mobility(
    spheres: &Spheres,
    medium: &Medium,
) -> Result<DMatrix<f64>, HydroError> {
    spheres.check_inside(medium)?;
    memory::check_spheres(spheres.len())?;
    let frame = Frame::new(spheres, medium);
    // One force and one torque per sphere (the modes of order 2 with l = 1), and the order of the
    // container that they need.
    let orders = Orders {
        spheres: vec![2; spheres.len()],
        container: container_order(spheres, medium),
        ..Orders::all(spheres.len(), medium, 2)
    };
    let scaled = spatial::rigid_mobility(&frame, spheres.radii(), &orders);
    let inverse = |units: f64| 1.0 / units;
    let mobility = frame.to_laboratory(&unscaled(&scaled, spheres.radii(), inverse));
    check_finite("the mobility of the spheres", &mobility)?;
    Ok(mobility)
}
