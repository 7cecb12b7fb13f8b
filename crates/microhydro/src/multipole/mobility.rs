//! Mobility of many spheres by multipole expansions without a matrix over all of them.
//!
//! Forces on the spheres are given or multipliers of joints, so that one right-hand side is solved
//! for instead of one for each rigid motion: [`crate::LinkedSpheres`] iterates over all multipoles
//! at once. Each pair couples the modes that its distance needs; near pairs have the orders of
//! their gap, which no elimination lowers, so that the matrix stays positive definite among any
//! number of neighbours.

use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::axis_turn::OfFamilies;
use super::coupling::Expansion;
use super::far_images::{FAR_ORDER, FarImages};
use super::memory;
use super::modes::{Family, Modes};
use super::orders::Accuracy;
use super::pair_preconditioner::{NarrowPair, PairPreconditioner};
use super::pair_product::{self, Couplings, Line, Pair, PairOrders, Workspace};
use super::rotation::AXIS_OF_M;
use super::scaled::drag_units;
use super::stresslet::stresslet_of_modes;
use super::truncation::{self, Gap, GapCoordinates};
use crate::error::{check_entries, check_finite};
use crate::periodic::{check_box, images_within, nearest_image};
use crate::{HydroError, Medium, Mobility, PointMobility, PointModel, Spheres};

/// The expansions that a product has: errors are estimated from solutions by fewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Variant {
    /// All.
    Full,
    /// Orders lower by two.
    Lowered,
    /// Couplings that neglect 30 times more.
    Neglecting,
}

/// Factor on the tolerance of couplings of [`Variant::Neglecting`].
///
/// The change is then larger than what is neglected. Couplings of orders below those of their
/// spheres lose at least one degree.
pub const MORE_NEGLECTED: f64 = 30.0;

/// Order of a coupling from the order that its pair needs: with four degrees orders lower by two
/// still contain the stresslets, and the change by them has the geometric decay of others.
fn pair_order(needed: usize, of_sphere: usize) -> usize {
    needed.max(LOWEST_ORDER).min(of_sphere)
}

/// Part of the tolerance below which couplings are neglected.
const NEGLECTED: f64 = 1e-2;

/// By how much [`Variant::Lowered`] is lower.
const LOWERED: usize = 2;

/// Part of the target of the flows about the axis of a gap that higher azimuthal numbers have.
///
/// Third spheres drive them, so that their errors are no squares. Among 27 spheres at gaps of 0.1
/// velocities changed by 3e-3 with the order instead of 2e-4 where they had the same target.
const REGULAR: f64 = 1e-2;

/// Highest order of an expansion: that of a gap of [`NARROWEST`] at a tolerance of 1e-5.
const MAX_ORDER: usize = 560;

/// Bispherical coordinate of the narrowest gap: that of the larger one of two spheres whose radii
/// are 1 and 2 at a gap of 0.001 smaller radii; between equal spheres it is 0.03.
///
/// The lowest eigenvalue falls with the gap. With lower orders the matrix of 27 spheres in a cube
/// at gaps of 0.003 was indefinite at a tolerance of 1e-2, at gaps of 0.01 it was not.
const NARROWEST: f64 = 0.018;

/// Lowest order: that below it by two has the stresslets.
const LOWEST_ORDER: usize = 4;

/// The orders of all spheres and pairs, before anything is computed.
struct Plan {
    /// Orders of the spheres.
    orders: Vec<usize>,
    /// Pairs with the orders of their coupling, similar ones next to each other.
    pairs: Vec<PlannedPair>,
    tail: f64,
    /// Bispherical coordinate of the narrowest gap.
    narrowest: f64,
    is_periodic: bool,
}

/// Size and time of a solution by expansions.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ExpansionCost {
    /// Number of multipoles.
    pub dofs: usize,
    /// Memory in MiB.
    pub mib: f64,
    /// Seconds on two cores, with the error bar. Counted and not measured: the same everywhere.
    pub seconds: f64,
}

/// Iterations for each digit, `e` as base, of the residual and for a bispherical coordinate of one.
///
/// Between equal spheres at gaps of 0.1 to 1 radii in cubes, they were 0.6 to 0.8.
const ITERATIONS: f64 = 0.7;

/// Most iterations for each digit: they were 2.1 to 3.6 in cubes at gaps of 0.1 to 0.01 and 3.1
/// among random neighbours whose gaps begin at 0.0012.
const MOST_ITERATIONS: f64 = 3.5;

/// Solutions from which errors are estimated take as long as the first one.
const SOLUTIONS: f64 = 2.0;

/// Multiplications and additions per second of products, on two cores.
const PRODUCT_RATE: f64 = 9e9;

/// Longest time of a solution that is begun.
const LONGEST_SECONDS: f64 = 3600.0;

impl ExpansionCost {
    /// # Errors
    /// [`HydroError::TooCostly`].
    fn check(&self) -> Result<(), HydroError> {
        if self.mib <= memory::MAX_MIB && self.seconds <= LONGEST_SECONDS {
            return Ok(());
        }
        Err(HydroError::TooCostly {
            dofs: self.dofs,
            mib: self.mib,
            seconds: self.seconds,
            most_mib: memory::MAX_MIB,
            longest: LONGEST_SECONDS,
        })
    }
}

struct PlannedPair {
    /// Source and target: the source has the higher order.
    ends: [usize; 2],
    /// From the source to the target.
    line: Line,
    /// Shift of the target, which is an image.
    shift: Vector3<f64>,
    orders: PairOrders,
    /// The same of [`Variant::Neglecting`].
    fewer: PairOrders,
    /// Highest degree with all azimuthal numbers.
    regular: usize,
}

/// Pairs that have the same highest degree with all azimuthal numbers: a multiple of the lanes of
/// all vector registers.
const ALIKE: usize = 8;

/// A sphere and another one, or an image, that couple as a pair.
struct Neighbours {
    gap: Gap,
    /// Shift of the second one.
    shift: Vector3<f64>,
}

impl Neighbours {
    /// All pairs of spheres in unbounded fluid.
    fn all(spheres: &Spheres) -> Vec<Self> {
        let gaps = truncation::gaps(spheres, &Medium::Unbounded).into_iter();
        let neighbours = gaps.map(|gap| Self {
            gap,
            shift: Vector3::zeros(),
        });
        neighbours.collect()
    }

    /// Spheres and images whose centres are within a distance, each pair once.
    fn within(reach: f64, spheres: &Spheres, size: &Vector3<f64>) -> Vec<Self> {
        let x = spheres.centres();
        let mut all = Vec::new();
        for (i, j) in (0..x.len()).flat_map(|j| (0..=j).map(move |i| (i, j))) {
            let apart = x[j] - x[i];
            images_within(
                reach,
                &nearest_image(&apart, size),
                size,
                |image, offset| {
                    // of a sphere and its images one half has the other one as their reverse
                    if i < j || image > [0; 3] {
                        all.push(Self {
                            gap: Gap::between(spheres, (i, j), offset.norm()),
                            shift: offset - apart,
                        });
                    }
                },
            );
        }
        all
    }

    fn offset(&self, spheres: &Spheres) -> Vector3<f64> {
        let (i, j) = self.gap.pair;
        spheres.centres()[j] + self.shift - spheres.centres()[i]
    }

    /// Distance of the surfaces over the smaller radius.
    fn clearance(&self, spheres: &Spheres) -> f64 {
        spheres.relative_gap_at(self.gap.pair, self.offset(spheres).norm())
    }
}

/// Distance of images in radii of the largest sphere from which the orders of the spheres follow.
const NEAR: f64 = 6.0;

/// Part of the tolerance below which couplings are neglected for the bispherical coordinates of all
/// spheres: the lowest eigenvalue falls with the narrowest gap.
fn neglected(xi: &GapCoordinates) -> f64 {
    NEGLECTED * truncation::narrowest(xi).min(1.0).powi(3)
}

impl Plan {
    fn new(
        spheres: &Spheres,
        period: Option<&Vector3<f64>>,
        accuracy: &Accuracy,
    ) -> Result<Self, HydroError> {
        accuracy.check()?;
        let (n, tolerance) = (spheres.len(), accuracy.tolerance);
        let neighbours = match period {
            None => {
                // before the list of all pairs
                memory::check(0.5 * (n as f64).powi(2) * PAIR, 11.0 * n as f64)?;
                Neighbours::all(spheres)
            }
            Some(size) => {
                check_box(spheres, size)?;
                let largest = spheres.radii().iter().fold(0.0_f64, |most, a| most.max(*a));
                let within = |reach: f64| {
                    // 4.2 is a little more than 4π/3
                    let images = (n as f64).powi(2) * 4.2 * reach.powi(3) / size.product();
                    memory::check(0.5 * images * PAIR, 11.0 * n as f64)?;
                    Ok(Neighbours::within(reach, spheres, size))
                };
                let nearest = within((NEAR * largest).max(1.001 * size.min()))?;
                let gaps: Vec<Gap> = nearest.iter().map(|near| near.gap).collect();
                let xi = GapCoordinates::narrowest_of(&gaps, n);
                // Beyond it the order of the far images suffices.
                let decay = -(neglected(&xi) * tolerance).ln() / (2.0 * (FAR_ORDER as f64 - 1.0));
                within((2.0 * largest * decay.cosh()).max(1.001 * size.min()))?
            }
        };
        let gaps: Vec<Gap> = neighbours.iter().map(|near| near.gap).collect();
        let xi = GapCoordinates::narrowest_of(&gaps, n);
        // spheres from which reflections come
        let others = match period {
            None => n,
            Some(_) => 1 + 2 * neighbours.len() / n.max(1),
        };
        let target = truncation::first_target(&xi, others, tolerance);
        let orders = truncation::for_tolerance(&xi, &Medium::Unbounded, target);
        let orders: Vec<usize> = (orders.spheres.iter())
            .map(|&order| order.max(LOWEST_ORDER))
            .collect();
        let highest = orders.iter().copied().max().unwrap_or_default();
        if highest > MAX_ORDER || truncation::narrowest(&xi) < NARROWEST {
            let closest = (neighbours.iter())
                .min_by(|one, other| (one.clearance(spheres)).total_cmp(&other.clearance(spheres)));
            let surfaces = |near: &Neighbours| match near.gap.pair {
                (i, j) if i == j => format!("sphere {i} and its image"),
                (i, j) => format!("spheres {i} and {j}"),
            };
            return Err(HydroError::TooClose {
                surfaces: closest.map(surfaces).unwrap_or_default(),
                gap: closest.map_or(f64::INFINITY, |near| near.clearance(spheres)),
                tolerance,
                needed: highest,
                highest: MAX_ORDER,
            });
        }
        let all = super::orders::Orders {
            spheres: orders.clone(),
            ..super::orders::Orders::all(n, &Medium::Unbounded, 0)
        };
        let neglected = tolerance * neglected(&xi);
        let a = spheres.radii();
        let pairs = neighbours.par_iter().map(|near| {
            let gap = &near.gap;
            let (i, j) = gap.pair;
            let offset = near.offset(spheres);
            let needed = |tolerance: f64| -> PairOrders {
                truncation::for_pair(offset.norm(), a[i], a[j], tolerance).into()
            };
            let (all, some) = (needed(neglected), needed(MORE_NEGLECTED * neglected));
            let of_spheres = [orders[i], orders[j]];
            let own = [0, 1].map(|end| pair_order(all[end], of_spheres[end]));
            let fewer = [0, 1].map(|end| match own[end] < of_spheres[end] {
                true => some[end].min(own[end] - 1),
                false => some[end].min(own[end]),
            });
            let regular = gap
                .xi
                .map(|xi| truncation::order_of_decay(xi, REGULAR * target));
            let [source, target] = if own[0] < own[1] { [1, 0] } else { [0, 1] };
            let sense = if source == 0 { 1.0 } else { -1.0 };
            let ends = [[i, j][source], [i, j][target]];
            PlannedPair {
                ends,
                line: Line::new(ends.map(|sphere| a[sphere]), &(sense * offset)),
                shift: sense * near.shift,
                orders: [own[source], own[target]],
                fewer: [fewer[source], fewer[target]],
                regular: regular[0].max(regular[1]).min(highest),
            }
        });
        let mut pairs: Vec<PlannedPair> = pairs.collect();
        pairs.sort_by_key(|pair| (pair.orders, pair.regular));
        for some in pairs.chunks_mut(ALIKE) {
            let regular = some.iter().map(|pair| pair.regular).max();
            for pair in some {
                pair.regular = regular.unwrap_or_default();
            }
        }
        Ok(Self {
            pairs,
            tail: truncation::tail(&xi, &all),
            orders,
            narrowest: truncation::narrowest(&xi),
            is_periodic: period.is_some(),
        })
    }

    /// Highest degree, and the highest one with all azimuthal numbers.
    fn degrees(&self) -> (usize, usize) {
        let top = self.orders.iter().copied().max();
        let regular = self.pairs.iter().map(|pair| pair.regular).max();
        (top.unwrap_or_default(), regular.unwrap_or_default())
    }

    /// Pairs for the preconditioner, which leaves out the degrees that [`Variant::Lowered`] does.
    fn narrow(&self) -> impl Iterator<Item = NarrowPair<'_>> {
        let narrow = |pair: &&PlannedPair| pair.orders[0] > LOWEST_ORDER + LOWERED;
        self.pairs.iter().filter(narrow).map(|pair| NarrowPair {
            ends: pair.ends,
            line: &pair.line,
            orders: pair.orders.map(|order| order - LOWERED),
            regular: pair.regular.saturating_sub(LOWERED),
        })
    }

    /// Cost of a solution with its error bar to a relative residual.
    fn cost(&self, residual: f64) -> ExpansionCost {
        let modes = self.orders.iter().map(|&order| (Modes { order }).len());
        let dofs = modes.sum();
        let product: usize = self.pairs.chunks(ALIKE).map(operations).sum();
        let of_images = match self.is_periodic {
            true => FarImages::operations(self.orders.len()),
            false => 0.0,
        };
        let for_digit = (ITERATIONS / self.narrowest.min(1.0)).min(MOST_ITERATIONS);
        let iterations = for_digit * -residual.ln();
        let (top, regular) = self.degrees();
        let (of_gaps, to_find) = (self.narrow().map(|pair| pair.cost()))
            .fold((0.0, 0.0), |sum, cost| (sum.0 + cost.0, sum.1 + cost.1));
        let numbers = of_gaps
            + PAIR * self.pairs.len() as f64
            + VECTORS * dofs as f64
            + pair_product::shared_numbers(top, regular);
        ExpansionCost {
            dofs,
            mib: memory::mib(numbers),
            seconds: (SOLUTIONS * iterations * (product as f64 + of_images) + to_find)
                / PRODUCT_RATE,
        }
    }
}

/// Operations of pairs that have the lanes of a register together: the highest orders count.
fn operations(alike: &[PlannedPair]) -> usize {
    let most = |end: usize| alike.iter().map(|pair| pair.orders[end]).max();
    let regular = alike.first().map_or(0, |pair| pair.regular);
    let orders = [most(0), most(1)].map(Option::unwrap_or_default);
    alike.len() * pair_product::operations(orders, regular)
}

/// Numbers of a pair: its gap and shift twice, its orders and its line of centres.
const PAIR: f64 = 27.0;

/// Vectors of all multipoles in an iteration, and the partial sums of a product.
const VECTORS: f64 = 30.0;

/// Number of partial sums of a product, whatever the number of threads.
const PARTS: usize = 16;

/// Pairs that one thread takes, and the places of the harmonics of each sphere in their sums.
///
/// Most pairs are distant, so that most spheres have few harmonics.
struct Part {
    pairs: Range<usize>,
    first: Vec<usize>,
}

impl Part {
    fn new(spheres: usize, all: &[PlannedPair], pairs: Range<usize>) -> Self {
        let mut orders = vec![0; spheres];
        for planned in &all[pairs.clone()] {
            for (sphere, order) in planned.ends.into_iter().zip(planned.orders) {
                orders[sphere] = order.max(orders[sphere]);
            }
        }
        Self {
            pairs,
            first: places(orders.into_iter().map(pair_product::harmonics)),
        }
    }

    fn of_sphere(&self, sphere: usize) -> Range<usize> {
        self.first[sphere]..self.first[sphere + 1]
    }

    /// Parts whose products have about equally many operations.
    fn all(spheres: usize, pairs: &[PlannedPair]) -> Vec<Self> {
        let operations: Vec<usize> = pairs.chunks(ALIKE).map(operations).collect();
        let all: usize = operations.iter().sum();
        let (mut parts, mut first, mut sum) = (Vec::new(), 0, 0);
        for (number, operations) in operations.iter().enumerate() {
            sum += operations;
            if sum * PARTS >= all * (parts.len() + 1) {
                let end = pairs.len().min((number + 1) * ALIKE);
                parts.push(Self::new(spheres, pairs, first..end));
                first = end;
            }
        }
        parts
    }
}

/// Places of lists of these lengths one after the other, and the end.
fn places(lengths: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut places = vec![0];
    places.extend(lengths.scan(0, |sum, length| {
        *sum += length;
        Some(*sum)
    }));
    places
}

/// Mobility of spheres in unbounded fluid or in a periodic box by expansions, with their multipoles
/// as hidden degrees of freedom. Viscosity 1.
///
/// Orders follow from the gaps and the tolerance, without a search: solutions by the
/// [`Variant`]s tell the error. Memory: `O(L^3)` numbers that all pairs share for the highest order
/// `L`, and a few for each pair.
pub struct MultipoleMobility<'a> {
    points: PointMobility<'a>,
    expansions: Vec<Expansion>,
    /// Place of the first mode of each sphere.
    first: Vec<usize>,
    /// The same by degree and azimuthal number.
    harmonics: Vec<usize>,
    units: Vec<f64>,
    couplings: Couplings,
    pairs: Vec<PlannedPair>,
    parts: Vec<Part>,
    /// Distant images in a periodic box.
    far: Option<FarImages>,
    tail: f64,
    narrowest: f64,
    variant: Variant,
    preconditioner: PairPreconditioner,
}

impl<'a> MultipoleMobility<'a> {
    /// Predicted cost of a solution with its error bar to a relative `residual`, in unbounded fluid
    /// or in a periodic box. Cost: some hundred operations for each pair.
    ///
    /// # Errors
    /// As [`MultipoleMobility::new`]; a larger cost than that is allowed is none.
    pub fn cost(
        spheres: &Spheres,
        period: Option<&Vector3<f64>>,
        accuracy: &Accuracy,
        residual: f64,
    ) -> Result<ExpansionCost, HydroError> {
        Ok(Plan::new(spheres, period, accuracy)?.cost(residual))
    }

    /// Plans the couplings of all pairs.
    ///
    /// # Errors
    /// A tolerance that is not between `1e-13` and 1; [`HydroError::TooClose`] for gaps below
    /// 0.001 radii (of the smaller sphere, the larger one at most twice as large) and those that
    /// need higher orders than 560; [`HydroError::TooLarge`],
    /// [`HydroError::TooCostly`] for the cost to a residual of the tolerance.
    pub fn new(spheres: &'a Spheres, accuracy: &Accuracy) -> Result<Self, HydroError> {
        Self::planned(spheres, None, accuracy)
    }

    /// The same in a box with these edges that is repeated in all directions, with zero mean flow
    /// as in [`PointMobility::periodic`].
    ///
    /// Images couple as pairs as far as they need more than four degrees; the flow of all others is
    /// that of low multipoles by Ewald's sums, at a cost of `O(n²)`.
    ///
    /// # Errors
    /// Those of both.
    pub fn periodic(
        spheres: &'a Spheres,
        size: &Vector3<f64>,
        accuracy: &Accuracy,
    ) -> Result<Self, HydroError> {
        Self::planned(spheres, Some(size), accuracy)
    }

    fn planned(
        spheres: &'a Spheres,
        period: Option<&Vector3<f64>>,
        accuracy: &Accuracy,
    ) -> Result<Self, HydroError> {
        let plan = Plan::new(spheres, period, accuracy)?;
        plan.cost(accuracy.tolerance).check()?;
        let radii = spheres.radii();
        let expansions: Vec<Expansion> = (radii.iter().zip(&plan.orders))
            .map(|(&radius, &order)| Expansion {
                radius,
                modes: Modes { order },
            })
            .collect();
        let (top, regular) = plan.degrees();
        let far = period.map(|size| {
            let near = plan.pairs.iter().map(|pair| (pair.ends, pair.shift));
            FarImages::new(spheres, size, near)
        });
        let couplings = Couplings::new(top, regular);
        let narrow: Vec<NarrowPair> = plan.narrow().collect();
        let preconditioner = PairPreconditioner::new(spheres.len(), couplings.quarter(), &narrow);
        Ok(Self {
            preconditioner,
            points: PointMobility::new(PointModel::Rpy, spheres, &Medium::Unbounded)?,
            units: drag_units(radii),
            first: places(expansions.iter().map(|expansion| expansion.modes.len())),
            harmonics: places(plan.orders.into_iter().map(pair_product::harmonics)),
            expansions,
            couplings,
            far: far.transpose()?,
            parts: Part::all(spheres.len(), &plan.pairs),
            pairs: plan.pairs,
            tail: plan.tail,
            narrowest: plan.narrowest,
            variant: Variant::Full,
        })
    }

    /// The same couplings with the expansions of a variant.
    pub fn set_variant(&mut self, variant: Variant) {
        self.variant = variant;
    }

    /// Factor from the change by [`Variant::Lowered`] to the error.
    pub fn tail(&self) -> f64 {
        self.tail
    }

    /// Bispherical coordinate of the narrowest gap: `cosh ξ = 1 + h / 2a` for equal spheres of
    /// radius `a` at a gap of `h`.
    pub fn narrowest(&self) -> f64 {
        self.narrowest
    }

    /// Number of multipoles.
    pub fn dofs(&self) -> usize {
        self.first[self.expansions.len()]
    }

    /// Modes of a sphere, and the place of the first one.
    pub(super) fn of_sphere(&self, sphere: usize) -> (Modes, usize) {
        (self.expansions[sphere].modes, self.first[sphere])
    }

    #[cfg(test)]
    pub(super) fn preconditioner(&self) -> &PairPreconditioner {
        &self.preconditioner
    }

    /// Stresslets of the spheres for the multipoles `hidden` of a solution.
    pub fn stresslets(&self, hidden: &DVector<f64>) -> Vec<Matrix3<f64>> {
        let all = self.expansions.iter().zip(&self.first);
        all.map(|(expansion, &first)| {
            let rows = expansion.modes.shell(Family::Stokeslet, 2);
            let modes: Vec<f64> = rows.map(|row| hidden[first + row]).collect();
            stresslet_of_modes(expansion, &modes)
        })
        .collect()
    }

    /// Rows of the rigid motions of a sphere among all modes, with the places of the velocities.
    fn rigid(&self, sphere: usize) -> impl Iterator<Item = (usize, usize, f64)> {
        let modes = self.expansions[sphere].modes;
        let starts = [Family::Stokeslet, Family::Rotlet].map(|f| modes.shell(f, 1).start);
        let first = self.first[sphere];
        let units = &self.units[6 * sphere..6 * sphere + 6];
        let rows: Vec<_> = (0..6)
            .map(|k| {
                let physical = 6 * sphere + 3 * (k / 3) + AXIS_OF_M[k % 3];
                (first + starts[k / 3] + k % 3, physical, units[k])
            })
            .collect();
        rows.into_iter()
    }

    /// Coefficients of all modes, by degree and azimuthal number.
    fn by_harmonic(&self, x: &[f64]) -> Vec<OfFamilies> {
        let mut all = vec![[0.0; 3]; self.harmonics[self.expansions.len()]];
        for (sphere, expansion) in self.expansions.iter().enumerate() {
            let own = &mut all[self.harmonics[sphere]..];
            let x = &x[self.first[sphere]..];
            for (k, (_, modes)) in expansion.modes.families().enumerate() {
                for (entry, value) in own.iter_mut().zip(&x[modes]) {
                    entry[k] = *value;
                }
            }
        }
        all
    }

    /// The modes of one sphere, given by `x`, and sums over pairs; modes above the order of the
    /// variant are zero.
    fn with_sums(&self, sphere: usize, x: &[f64], sums: &[Vec<OfFamilies>]) -> Vec<f64> {
        let length = self.harmonics[sphere + 1] - self.harmonics[sphere];
        let mut all = vec![[0.0; 3]; length];
        for (part, sum) in self.parts.iter().zip(sums) {
            for (entry, added) in all.iter_mut().zip(&sum[part.of_sphere(sphere)]) {
                for (entry, added) in entry.iter_mut().zip(added) {
                    *entry += added;
                }
            }
        }
        let modes = self.expansions[sphere].modes;
        let used = Modes {
            order: self.order(sphere),
        };
        let mut y = vec![0.0; modes.len()];
        for (k, (family, own)) in modes.families().enumerate() {
            let kept = pair_product::harmonics(used.max_degree(family));
            let values = x[own.clone()].iter().zip(&all).take(kept);
            for (y, (x, sum)) in y[own].iter_mut().zip(values) {
                *y = x + sum[k];
            }
        }
        y
    }

    /// Adds to `y` what distant images do.
    fn add_far_images(&self, x: &[f64], y: &mut DVector<f64>) {
        let Some(far) = &self.far else { return };
        let modes = Modes { order: FAR_ORDER };
        let of_sphere = |sphere: usize| {
            let all = self.expansions[sphere].modes;
            let used = Modes {
                order: match self.variant {
                    Variant::Neglecting => FAR_ORDER - 1,
                    _ => self.order(sphere),
                },
            };
            let shells = modes
                .shells()
                .filter(move |(family, l)| used.contains(*family, *l));
            shells.flat_map(move |(family, l)| {
                let rows = all.shell(family, l);
                modes
                    .shell(family, l)
                    .zip(rows.map(move |row| self.first[sphere] + row))
            })
        };
        let given = (0..self.expansions.len()).map(|sphere| {
            let mut low = vec![0.0; modes.len()];
            of_sphere(sphere).for_each(|(place, row)| low[place] = x[row]);
            low
        });
        let found = far.product(&given.collect::<Vec<_>>());
        for (sphere, found) in found.iter().enumerate() {
            of_sphere(sphere).for_each(|(place, row)| y[row] += found[place]);
        }
    }

    /// The order of a sphere in products.
    fn order(&self, sphere: usize) -> usize {
        let order = self.expansions[sphere].modes.order;
        match self.variant {
            Variant::Lowered => order - LOWERED,
            _ => order,
        }
    }

    /// Orders of a pair in products.
    fn pair_orders(&self, planned: &PlannedPair) -> PairOrders {
        match self.variant {
            Variant::Neglecting => planned.fewer,
            _ => [0, 1].map(|end| planned.orders[end].min(self.order(planned.ends[end]))),
        }
    }
}

/// The couplings of some pairs, with the vector instructions of the processor.
struct OfPairs<'m> {
    all: &'m MultipoleMobility<'m>,
    part: &'m Part,
    x: &'m [OfFamilies],
    y: &'m mut [OfFamilies],
}

impl WithSimd for OfPairs<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut work = Workspace::<S>::default();
        let Self { all, part, x, y } = self;
        let omitted = match all.variant {
            Variant::Lowered => LOWERED,
            _ => 0,
        };
        let pair = |number: usize| {
            let planned = &all.pairs[number];
            Pair {
                line: &planned.line,
                orders: all.pair_orders(planned),
                given: planned.ends.map(|sphere| all.harmonics[sphere]),
                found: planned.ends.map(|sphere| part.first[sphere]),
            }
        };
        let mut pairs = Vec::with_capacity(S::F64_LANES);
        let mut first = part.pairs.start;
        while first < part.pairs.end {
            let end = part.pairs.end.min(first + S::F64_LANES);
            pairs.clear();
            pairs.extend((first..end).map(pair));
            let regular = all.pairs[first].regular.saturating_sub(omitted);
            let some = (&pairs[..], regular);
            all.couplings.add(simd, some, x, y, &mut work);
            first = end;
        }
    }
}

impl Mobility for MultipoleMobility<'_> {
    fn spheres(&self) -> &Spheres {
        self.points.spheres()
    }

    fn hidden(&self) -> usize {
        self.dofs()
    }

    fn product(
        &self,
        forces: &DVector<f64>,
        hidden: &DVector<f64>,
    ) -> Result<[DVector<f64>; 2], HydroError> {
        let n = self.expansions.len();
        check_entries("forces and torques on the spheres", 6 * n, forces.len())?;
        check_entries("multipoles", self.dofs(), hidden.len())?;
        check_finite("a force", forces)?;
        let mut x = hidden.clone();
        for (row, place, unit) in (0..n).flat_map(|sphere| self.rigid(sphere)) {
            x[row] = forces[place] / unit;
        }
        let x = x.as_slice();
        let by_harmonic = self.by_harmonic(x);
        let arch = Arch::new();
        let sums: Vec<Vec<OfFamilies>> = (self.parts.par_iter())
            .map(|part| {
                let mut y = vec![[0.0; 3]; part.first[n]];
                arch.dispatch(OfPairs {
                    all: self,
                    part,
                    x: &by_harmonic,
                    y: &mut y,
                });
                y
            })
            .collect();
        let of_spheres: Vec<Vec<f64>> = (0..n)
            .into_par_iter()
            .map(|sphere| {
                let own = &x[self.first[sphere]..self.first[sphere + 1]];
                self.with_sums(sphere, own, &sums)
            })
            .collect();
        let mut hidden = DVector::from_vec(of_spheres.concat());
        self.add_far_images(x, &mut hidden);
        let mut velocities = DVector::zeros(6 * n);
        for (row, place, unit) in (0..n).flat_map(|sphere| self.rigid(sphere)) {
            velocities[place] = hidden[row] / unit;
            hidden[row] = 0.0;
        }
        Ok([velocities, hidden])
    }

    fn own_block(&self, some: &[usize]) -> DMatrix<f64> {
        self.points.block_without_images(some)
    }

    fn precondition_hidden(&self, x: &mut DVector<f64>) {
        self.preconditioner
            .apply(x, |sphere| self.of_sphere(sphere));
    }

    fn not_positive_definite(&self) -> HydroError {
        HydroError::FactorisationFailed {
            matrix: "Galerkin matrix",
            size: self.dofs(),
        }
    }
}
