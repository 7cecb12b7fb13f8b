//! Flows of moving surfaces at several orders, from which their errors are estimated.
//!
//! Surface velocities are in the low degrees, so the elimination of the high degrees of a narrow
//! gap (`narrow_gap`) serves them as it serves rigid motions: the boundary values of the
//! eliminated degrees are zero.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::frame::{Frame, Surroundings};
use super::memory;
use super::modes::{Family, Modes};
use super::narrow_gap::{Block, Eliminated, NarrowGap};
use super::orders::Orders;
use super::system::{MultiVector, System};
use super::three_spheres;
use super::truncation::{self, GapCoordinates, MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER};
use crate::{HydroError, Medium, Spheres};

/// Accuracy of the couplings of surface velocities.
const COUPLING_TOLERANCE: f64 = 1e-14;

/// Highest order of the container beside narrow gaps, where its block is a dense matrix.
const MAX_ORDER_BESIDE_GAPS: usize = MAX_ORDER_OFF_AXIS + 4;

/// Matrices that follow from the solution of a system.
pub(super) type Matrices = Vec<DMatrix<f64>>;

/// Computes matrices from a system, from the modes for which the condition holds; the last
/// argument is the initial guess and is left at the solution.
pub(super) type OfSystem<'a> = dyn Fn(
        &System,
        &dyn Fn(Modes, Family, usize) -> bool,
        &mut MultiVector,
    ) -> Result<Matrices, HydroError>
    + 'a;

/// Matrices with coarser ones: `tail` times the difference estimates the error.
pub(super) struct Estimated {
    pub values: Matrices,
    pub coarser: Matrices,
    pub tail: f64,
}

/// Spheres whose surfaces move, with the orders of their expansions.
pub(super) struct SurfaceOrders<'a> {
    pub spheres: &'a Spheres,
    pub medium: &'a Medium,
    pub frame: &'a Frame,
    /// Orders of the resistance of the spheres.
    pub of_resistance: &'a Orders,
    /// Lowest orders for the surface velocities and for the two orders below them.
    pub lowest: &'a Orders,
    /// Number of right-hand sides.
    pub columns: usize,
}

impl SurfaceOrders<'_> {
    /// Matrices at the orders of the resistance, and their error estimates.
    ///
    /// Where the orders of a narrow gap exceed the highest order of an expansion, its high degrees
    /// are eliminated: on one axis for all surfaces, elsewhere for the two surfaces alone; where
    /// that fails, among three surfaces close to each other, the expansions keep their highest
    /// order.
    ///
    /// # Errors
    /// [`HydroError::TooLarge`]; those of `of`.
    pub fn estimate(&self, of: &OfSystem) -> Result<Estimated, HydroError> {
        let all = self.of_resistance.without_gaps();
        if all != all.limited(MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER) {
            let orders = self.beside_gaps();
            let narrow = match self.frame.collinear {
                true => {
                    let gaps = self.of_resistance;
                    vec![NarrowGap::on_axis(self.spheres, self.medium, gaps, &orders)]
                }
                false => NarrowGap::all(self.spheres, self.medium, &orders)?,
            };
            match self.with_narrow_gaps(&orders, &narrow, of) {
                Err(HydroError::FactorisationFailed { .. } | HydroError::NotConverged { .. }) => {}
                found => return found,
            }
        }
        self.by_order(of)
    }

    /// The expansions resolve all gaps, or have their highest order.
    fn by_order(&self, of: &OfSystem) -> Result<Estimated, HydroError> {
        let orders = (self.of_resistance.without_gaps())
            .limited(MAX_ORDER_OFF_AXIS, MAX_ORDER_ON_CONTAINER)
            .at_least(self.lowest);
        self.check_memory(&orders)?;
        let radii = self.spheres.radii();
        let system = System::new(self.frame, radii, &orders, COUPLING_TOLERANCE).store_couplings();
        let mut x = system.zeros(self.columns);
        let coarser = of(
            &system,
            &|modes, family, l| modes.in_lower_order(family, l),
            &mut x,
        )?;
        Ok(Estimated {
            values: of(&system, &|_, _, _| true, &mut x)?,
            coarser,
            tail: truncation::tail(&self.coordinates(), &orders),
        })
    }

    /// Orders beside narrow gaps: those of the resistance; for surfaces on one axis, where the
    /// elimination is exact, the lowest ones.
    fn beside_gaps(&self) -> Orders {
        let orders = self.of_resistance;
        let own = match self.frame.collinear {
            true => orders.limited(0, 0),
            false => orders.limited(MAX_ORDER_OFF_AXIS, MAX_ORDER_BESIDE_GAPS),
        };
        own.at_least(self.lowest)
    }

    /// The high degrees of narrow gaps are eliminated for their two surfaces.
    ///
    /// The coarser matrices are extrapolated by the changes with the order of the expansions and
    /// with the orders of the gaps, so that they differ by the estimated error.
    fn with_narrow_gaps(
        &self,
        orders: &Orders,
        narrow: &[NarrowGap],
        of: &OfSystem,
    ) -> Result<Estimated, HydroError> {
        self.check_memory(orders)?;
        let (frame, radii) = (self.frame, self.spheres.radii());
        let highest = match frame.collinear {
            true => self.lowest.highest(),
            false => usize::MAX,
        };
        let stages = [
            Eliminated::All,
            Eliminated::LoweredExpansions,
            Eliminated::LoweredGap,
        ];
        let blocks: Vec<[Vec<Block>; 3]> = narrow
            .par_iter()
            .map(|gap| gap.blocks(frame, orders, highest, stages))
            .collect::<Result<_, _>>()?;
        let mut of_stages: [Vec<Block>; 3] = Default::default();
        for (stage, block) in blocks.into_iter().flat_map(|all| (0..3).zip(all)) {
            of_stages[stage].extend(block);
        }
        let [full, lowered, lowered_gap] = of_stages;
        let matrices = |orders: &Orders, blocks: Vec<Block>| {
            let mut system = System::new(frame, radii, orders, COUPLING_TOLERANCE);
            system.add_blocks(blocks);
            if !frame.collinear {
                system.add_blocks(three_spheres::blocks(frame, radii, orders));
            }
            let system = system.store_couplings();
            let mut x = system.zeros(self.columns);
            of(&system, &|_, _, _| true, &mut x)
        };
        let values = matrices(orders, full)?;
        let lowered = matrices(&orders.lowered(), lowered)?;
        let lowered_gap = matrices(orders, lowered_gap)?;
        let of_gap = |gap: &NarrowGap| {
            let gaps = truncation::gaps(&gap.spheres, &gap.medium);
            let xi = GapCoordinates::narrowest_of(&gaps, gap.spheres.len());
            truncation::tail(&xi, &gap.orders)
        };
        let tail = truncation::tail(&self.coordinates().widened(), orders);
        let gap_tail = narrow.iter().map(of_gap).fold(0.0, f64::max);
        let coarser = (values.iter().zip(&lowered).zip(&lowered_gap))
            .map(|((value, lowered), lowered_gap)| {
                let (change, of_gaps) =
                    (tail * (lowered - value), gap_tail * (lowered_gap - value));
                value
                    + change.zip_map(&of_gaps, |change: f64, of_gaps: f64| {
                        (change.abs() + of_gaps.abs()).copysign(change + of_gaps)
                    })
            })
            .collect();
        Ok(Estimated {
            values,
            coarser,
            tail: 1.0,
        })
    }

    fn coordinates(&self) -> GapCoordinates {
        let gaps = truncation::gaps(self.spheres, self.medium);
        GapCoordinates::narrowest_of(&gaps, self.spheres.len())
    }

    fn check_memory(&self, orders: &Orders) -> Result<(), HydroError> {
        memory::check_one_solution(orders, self.frame.surroundings == Surroundings::Wall)
    }
}
