//! The orders of all spheres and pairs of [`MultipoleMobility`], before anything is computed, and
//! what a solution costs.
//!
//! [`MultipoleMobility`]: super::MultipoleMobility

use nalgebra::Vector3;
use rayon::prelude::*;

use super::adaptive::check_width;
use super::cell_shift::{CellShift, HIGHER};
use super::cells::{Cell, CoupledBodies, MAX_CELL_ORDER, SLOWER, Tree};
use super::far_images::{FAR_ORDER, FarImages};
use super::line_of_centres::{Line, PairOrders, harmonics};
use super::memory;
use super::modes::Modes;
use super::orders::{Accuracy, LOWEST_ORDER};
use super::pair_preconditioner::NarrowPair;
use super::pair_product;
use super::slip_expansion::SlipModes;
use super::truncation::{self, Gap, GapCoordinates, Neglected};
use crate::periodic::{check_box, images_within, nearest_image};
use crate::{HydroError, Medium, Spheres};

/// Order of a coupling from the order that its pair needs: with four degrees orders lower by two
/// still contain the stresslets, and the change by them has the geometric decay of others.
fn pair_order(needed: usize, of_sphere: usize) -> usize {
    needed.max(LOWEST_ORDER).min(of_sphere)
}

/// By how much [`Variant::Lowered`] is lower.
pub(super) const LOWERED: usize = 2;

/// Degrees that have all azimuthal numbers: their couplings cost less than the rotations of pairs.
const ALWAYS_REGULAR: usize = 8;

/// Highest order of an expansion: that of a gap of [`NARROWEST`] at a tolerance of 1e-5.
const MAX_ORDER: usize = 560;

/// Bispherical coordinate of the narrowest gap: that of the larger one of two spheres whose radii
/// are 1 and 2 at a gap of 0.001 smaller radii; between equal spheres it is 0.03.
///
/// The lowest eigenvalue falls with the gap. With lower orders the matrix of 27 spheres in a cube
/// at gaps of 0.003 was indefinite at a tolerance of 1e-2, at gaps of 0.01 it was not.
const NARROWEST: f64 = 0.018;

/// Bispherical coordinate of equal spheres at a gap of 0.001 radii, with a margin: that of spheres
/// at narrower gaps is below it.
const NARROWEST_OF_EQUAL: f64 = 0.032;

/// The orders of all spheres and pairs, before anything is computed.
pub(super) struct Plan {
    /// Orders of the spheres.
    pub orders: Vec<usize>,
    /// Pairs with the orders of their coupling, similar ones next to each other.
    pub pairs: Vec<PlannedPair>,
    /// Cells, bodies after the spheres.
    pub cells: Vec<Cell>,
    /// Cells with their parts, such that all parts of a cell are in a list before.
    pub shifts: Vec<Vec<PlannedPair>>,
    /// Factor from the change by [`Variant::Lowered`] to the error, of each sphere.
    pub tails: Vec<f64>,
    /// Relative error of the couplings of spheres.
    pub neglected: f64,
    /// Bispherical coordinate of the narrowest gap.
    pub narrowest: f64,
    pub is_periodic: bool,
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
    /// With these numbers beside the vectors of multipoles, and operations.
    fn new(dofs: usize, numbers: f64, operations: f64) -> Self {
        Self {
            dofs,
            mib: memory::mib(numbers + VECTORS * dofs as f64),
            seconds: operations / PRODUCT_RATE,
        }
    }

    /// Cost of a number of pairs to a relative residual, if they had the lowest orders.
    fn least(spheres: usize, pairs: f64, residual: f64) -> Self {
        let order = LOWEST_ORDER;
        let product = pairs * pair_product::operations([order; 2], order) as f64;
        let dofs = spheres * (Modes { order }).len();
        let iterations = ITERATIONS * -residual.ln();
        Self::new(dofs, PAIR * pairs, SOLUTIONS * iterations * product)
    }

    /// Cost of spheres of these orders to a relative residual, if each one coupled with one other.
    fn of_spheres(orders: &[usize], residual: f64) -> Self {
        let product = |&order: &usize| pair_product::operations([order; 2], order) as f64 / 2.0;
        let iterations = ITERATIONS * -residual.ln();
        let product: f64 = orders.iter().map(product).sum();
        Self::new(dofs(orders), 0.0, SOLUTIONS * iterations * product)
    }

    /// # Errors
    /// [`HydroError::TooCostly`].
    pub(super) fn check(&self) -> Result<(), HydroError> {
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

/// A pair with the orders of its coupling, or a cell and a part of it.
pub(super) struct PlannedPair {
    /// Source and target, spheres or cells: the source has the higher order.
    pub ends: [usize; 2],
    /// From the source to the target.
    pub line: Line,
    /// Shift of the target, which is an image.
    pub shift: Vector3<f64>,
    pub orders: PairOrders,
    /// The same of [`Variant::Neglecting`].
    pub fewer: PairOrders,
    /// Highest degree with all azimuthal numbers.
    pub regular: usize,
}

/// Pairs that have the same highest degree with all azimuthal numbers: a multiple of the lanes of
/// all vector registers.
pub(super) const ALIKE: usize = 8;

/// A sphere and another one, or an image, that couple as a pair.
struct Neighbours {
    gap: Gap,
    /// Shift of the second one.
    shift: Vector3<f64>,
}

impl Neighbours {
    /// A pair of spheres.
    fn between(spheres: &Spheres, (i, j): (usize, usize)) -> Self {
        let distance = (spheres.centres()[j] - spheres.centres()[i]).norm();
        Self {
            gap: Gap::between(spheres, (i, j), distance),
            shift: Vector3::zeros(),
        }
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

/// Number of multipoles of spheres of these orders.
fn dofs(orders: &[usize]) -> usize {
    orders.iter().map(|&order| (Modes { order }).len()).sum()
}

/// Orders of spheres with the flow that a number of others reflect.
fn orders_of_spheres(
    xi: &GapCoordinates,
    others: usize,
    tolerance: f64,
    slip: Option<&SlipModes>,
) -> Vec<usize> {
    let target = truncation::first_target(xi, others, tolerance);
    let orders = truncation::for_tolerance(xi, &Medium::Unbounded, target).spheres;
    orders
        .into_iter()
        .enumerate()
        .map(|(sphere, order)| order.max(LOWEST_ORDER).max(order_of_slip(slip, sphere)))
        .collect()
}

/// Lowest order of a sphere with which [`Variant::Lowered`] has its slip; zero without one.
fn order_of_slip(slip: Option<&SlipModes>, sphere: usize) -> usize {
    match slip.map_or(0, |slip| slip.order(sphere)) {
        0 => 0,
        order => order + LOWERED,
    }
}

/// Refuses gaps that are too narrow; `closest` tells the surfaces of the narrowest one and its
/// width over the smaller radius.
fn check_gaps(
    xi: &GapCoordinates,
    orders: &[usize],
    tolerance: f64,
    closest: impl FnOnce() -> Option<(String, f64)>,
) -> Result<(), HydroError> {
    let highest = orders.iter().copied().max().unwrap_or_default();
    let narrowest = truncation::narrowest(xi);
    let meets_orders = highest <= MAX_ORDER && narrowest >= NARROWEST;
    if meets_orders && narrowest >= NARROWEST_OF_EQUAL {
        return Ok(());
    }
    let (surfaces, gap) = closest().unwrap_or((String::new(), f64::INFINITY));
    check_width(&surfaces, gap)?;
    if meets_orders {
        return Ok(());
    }
    Err(HydroError::TooClose {
        surfaces,
        gap,
        tolerance,
        needed: highest,
        highest: MAX_ORDER,
    })
}

/// Sorts pairs such that similar ones are next to each other, and makes the azimuthal numbers equal
/// of those that have the lanes of a register together.
fn sort_alike(pairs: &mut [PlannedPair]) {
    pairs.sort_by_key(|pair| (pair.orders, pair.regular));
    for some in pairs.chunks_mut(ALIKE) {
        let regular = some.iter().map(|pair| pair.regular).max();
        for pair in some {
            pair.regular = regular.unwrap_or_default();
        }
    }
}

/// Cells with the pairs of them.
struct PlannedCells {
    cells: Vec<Cell>,
    pairs: Vec<PlannedPair>,
    shifts: Vec<Vec<PlannedPair>>,
}

/// `orders` are those of the spheres.
fn planned_cells(
    spheres: &Spheres,
    (tree, couples): (Tree, &[CoupledBodies]),
    neglected: Neglected,
    orders: &[usize],
) -> PlannedCells {
    let n = spheres.len();
    let coupled = tree.coupled_cells(couples, neglected);
    let cells = &coupled.cells;
    let ball = |body: usize| match body.checked_sub(n) {
        None => (spheres.centres()[body], spheres.radii()[body]),
        Some(cell) => (cells[cell].centre, cells[cell].radius),
    };
    let highest = |body: usize| orders.get(body).copied().unwrap_or(usize::MAX);
    let pairs = couples.iter().filter_map(|couple| {
        let [Some(first), Some(second)] = couple.ends.map(|body| coupled.bodies[body]) else {
            return None;
        };
        let (ends, (own, less)) = ([first, second], couple.orders?);
        let limited = |orders: PairOrders| [0, 1].map(|end| orders[end].min(highest(ends[end])));
        let (own, less) = (limited(own), limited(less));
        let order = if own[0] < own[1] { [1, 0] } else { [0, 1] };
        let [(x, a), (y, b)] = order.map(|end| ball(ends[end]));
        Some(PlannedPair {
            ends: order.map(|end| ends[end]),
            line: Line::new([a, b], &(y - x)),
            shift: Vector3::zeros(),
            orders: order.map(|end| own[end]),
            fewer: order.map(|end| less[end]),
            // all, also by `Variant::Lowered`
            regular: own[0].max(own[1]) + LOWERED,
        })
    });
    let pairs = pairs.collect();
    let mut heights = vec![0; n];
    let mut shifts: Vec<Vec<PlannedPair>> = Vec::new();
    for (number, cell) in cells.iter().enumerate() {
        let height = cell.parts.iter().map(|&part| heights[part]).max();
        let height = height.unwrap_or_default();
        shifts.resize_with(shifts.len().max(height + 1), Vec::new);
        heights.push(height + 1);
        for &part in &cell.parts {
            let (x, a) = ball(part);
            let own = match part.checked_sub(n) {
                None => coupled.of_spheres[part].min(orders[part]),
                Some(part) => cells[part].order,
            };
            // higher degrees do not couple to those of the cell
            let orders = [cell.order, own.min(cell.order + HIGHER)];
            shifts[height].push(PlannedPair {
                ends: [n + number, part],
                line: Line::within([cell.radius, a], &(x - cell.centre)),
                shift: Vector3::zeros(),
                orders,
                fewer: orders,
                regular: orders[0].max(orders[1]),
            });
        }
    }
    shifts.iter_mut().for_each(|level| sort_alike(level));
    PlannedCells {
        pairs,
        shifts,
        cells: coupled.cells,
    }
}

impl Plan {
    pub fn new(
        spheres: &Spheres,
        period: Option<&Vector3<f64>>,
        accuracy: &Accuracy,
        slip: Option<&SlipModes>,
    ) -> Result<Self, HydroError> {
        accuracy.check()?;
        let (n, tolerance) = (spheres.len(), accuracy.tolerance);
        let (xi, orders, neighbours, cells) = match period {
            None => {
                let tree = Tree::new(spheres);
                let narrowest = (0..n).into_par_iter().map(|sphere| tree.narrowest(sphere));
                let xi = GapCoordinates {
                    spheres: narrowest.collect(),
                    container: f64::INFINITY,
                };
                let orders = orders_of_spheres(&xi, n, tolerance, slip);
                check_gaps(&xi, &orders, tolerance, || {
                    let (i, j) = spheres.closest_pair()?;
                    Some((format!("spheres {i} and {j}"), spheres.relative_gap(i, j)))
                })?;
                // before any list of pairs
                ExpansionCost::of_spheres(&orders, tolerance).check()?;
                let neglected = Neglected::of(&xi, tolerance);
                let (pairs, distant): (Vec<_>, Vec<_>) = (tree.couples(neglected).into_iter())
                    .partition(|couple| couple.orders.is_none());
                ExpansionCost::least(n, pairs.len() as f64, tolerance).check()?;
                let neighbours = (pairs.par_iter())
                    .map(|couple| Neighbours::between(spheres, couple.ends.into()))
                    .collect();
                (xi, orders, neighbours, Some((tree, distant)))
            }
            Some(size) => {
                check_box(spheres, size)?;
                let largest = spheres.radii().iter().fold(0.0_f64, |most, a| most.max(*a));
                let within = |reach: f64| {
                    // 4.2 is a little more than 4π/3
                    let images = (n as f64).powi(2) * 4.2 * reach.powi(3) / size.product();
                    ExpansionCost::least(n, 0.5 * images, tolerance).check()?;
                    Ok(Neighbours::within(reach, spheres, size))
                };
                let coordinates = |near: &[Neighbours]| {
                    let gaps: Vec<Gap> = near.iter().map(|near| near.gap).collect();
                    GapCoordinates::narrowest_of(&gaps, n)
                };
                let nearest = within((NEAR * largest).max(1.001 * size.min()))?;
                let xi = coordinates(&nearest);
                // Beyond it the order of the far images suffices.
                let neglected = Neglected::of(&xi, tolerance).of_spheres;
                let decay = -neglected.ln() / (2.0 * (FAR_ORDER as f64 - 1.0));
                let near = within((2.0 * largest * decay.cosh()).max(1.001 * size.min()))?;
                let xi = coordinates(&near);
                // spheres from which reflections come
                let others = 1 + 2 * near.len() / n.max(1);
                let orders = orders_of_spheres(&xi, others, tolerance, slip);
                check_gaps(&xi, &orders, tolerance, || {
                    let gaps = near
                        .iter()
                        .map(|near| (near.clearance(spheres), near.gap.pair));
                    let (gap, (i, j)) = gaps.min_by(|(a, _), (b, _)| a.total_cmp(b))?;
                    let surfaces = match i == j {
                        true => format!("sphere {i} and its image"),
                        false => format!("spheres {i} and {j}"),
                    };
                    Some((surfaces, gap))
                })?;
                (xi, orders, near, None)
            }
        };
        let highest = orders.iter().copied().max().unwrap_or_default();
        let neglected = Neglected::of(&xi, tolerance);
        let a = spheres.radii();
        let pairs = neighbours.par_iter().map(|near| {
            let gap = &near.gap;
            let (i, j) = gap.pair;
            let offset = near.offset(spheres);
            let needed = |neglected: Neglected| -> PairOrders {
                truncation::for_pair(offset.norm(), a[i], a[j], neglected.of_spheres).into()
            };
            let (all, some) = (needed(neglected), needed(neglected.more()));
            let of_spheres = [orders[i], orders[j]];
            let own = [0, 1].map(|end| pair_order(all[end], of_spheres[end]));
            let fewer = [0, 1].map(|end| match own[end] < of_spheres[end] {
                true => some[end].min(own[end] - 1),
                false => some[end].min(own[end]),
            });
            let is_distant = own[0] < of_spheres[0] && own[1] < of_spheres[1];
            let regular = match is_distant {
                // third spheres drive them: all that are not neglected, also by `Variant::Lowered`
                true => own.map(|order| order + LOWERED),
                // flows of azimuthal numbers above one are less singular in a gap
                false => [0, 1].map(|end| {
                    truncation::order_of_decay(gap.xi[end], tolerance)
                        .max(ALWAYS_REGULAR)
                        .max(order_of_slip(slip, [i, j][end]))
                }),
            };
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
        let (cells, shifts) = match cells {
            Some((tree, distant)) => {
                let planned = planned_cells(spheres, (tree, &distant), neglected, &orders);
                pairs.extend(planned.pairs);
                (planned.cells, planned.shifts)
            }
            None => (Vec::new(), Vec::new()),
        };
        sort_alike(&mut pairs);
        Ok(Self {
            pairs,
            cells,
            shifts,
            tails: truncation::tails_of_spheres(&xi.spheres, &orders),
            neglected: neglected.of_spheres,
            orders,
            narrowest: truncation::narrowest(&xi),
            is_periodic: period.is_some(),
        })
    }

    /// Highest degree, and the highest one with all azimuthal numbers.
    pub fn degrees(&self) -> (usize, usize) {
        let of_cells = self.cells.iter().map(|cell| cell.order);
        let top = self.orders.iter().copied().chain(of_cells).max();
        let regular = self.pairs.iter().map(|pair| pair.regular).max();
        (top.unwrap_or_default(), regular.unwrap_or_default())
    }

    /// Pairs for the preconditioner, which leaves out the degrees that [`Variant::Lowered`] does.
    pub fn narrow(&self) -> impl Iterator<Item = NarrowPair<'_>> {
        let is_sphere = |&body: &usize| body < self.orders.len();
        let narrow = move |pair: &&PlannedPair| {
            pair.orders[0] > LOWEST_ORDER + LOWERED && pair.ends.iter().all(is_sphere)
        };
        self.pairs.iter().filter(narrow).map(|pair| NarrowPair {
            ends: pair.ends,
            line: &pair.line,
            orders: pair.orders.map(|order| order - LOWERED),
            regular: pair.regular.saturating_sub(LOWERED),
        })
    }

    /// Cost of a solution with its error bar to a relative residual.
    pub fn cost(&self, residual: f64) -> ExpansionCost {
        let dofs = dofs(&self.orders);
        let is_cell = |&body: &usize| body >= self.orders.len();
        let slower = |some: &[PlannedPair]| {
            let cells = some.iter().filter(|pair| pair.ends.iter().any(is_cell));
            let operations = operations(some);
            operations + operations / some.len() * cells.count() * (SLOWER - 1)
        };
        let all = self.shifts.iter().chain(Some(&self.pairs));
        let product: usize = all.flat_map(|pairs| pairs.chunks(ALIKE)).map(slower).sum();
        let ([of_images, to_store], stored) = match self.is_periodic {
            true => FarImages::cost(self.orders.len()),
            false => ([0.0; 2], 0.0),
        };
        let for_digit = (ITERATIONS / self.narrowest.min(1.0)).min(MOST_ITERATIONS);
        let iterations = for_digit * -residual.ln();
        let (top, regular) = self.degrees();
        let (of_gaps, to_find) = (self.narrow().map(|pair| pair.cost()))
            .fold((0.0, 0.0), |sum, cost| (sum.0 + cost.0, sum.1 + cost.1));
        let pairs = self.shifts.iter().map(Vec::len).sum::<usize>() + self.pairs.len();
        let of_cells = (self.cells.iter()).map(|cell| CELL_VECTORS * harmonics(cell.order) as f64);
        let numbers = of_gaps
            + stored
            + PAIR * pairs as f64
            + of_cells.sum::<f64>()
            + CellShift::stored_numbers(MAX_CELL_ORDER + HIGHER)
            + pair_product::shared_numbers(top, regular);
        let operations = SOLUTIONS * iterations * (product as f64 + of_images) + to_find + to_store;
        ExpansionCost::new(dofs, numbers, operations)
    }
}

/// Operations of pairs that have the lanes of a register together: the highest orders count.
pub(super) fn operations(alike: &[PlannedPair]) -> usize {
    let most = |end: usize| alike.iter().map(|pair| pair.orders[end]).max();
    let regular = alike.first().map_or(0, |pair| pair.regular);
    let orders = [most(0), most(1)].map(Option::unwrap_or_default);
    alike.len() * pair_product::operations(orders, regular)
}

/// Numbers of a pair: its gap and shift twice, its orders and its line of centres.
const PAIR: f64 = 27.0;

/// Vectors of all multipoles in an iteration, and the partial sums of a product.
const VECTORS: f64 = 30.0;

/// The same of the harmonics of cells, which a product alone has: three families of each in two
/// vectors and some partial sums.
const CELL_VECTORS: f64 = 3.0 * 8.0;
