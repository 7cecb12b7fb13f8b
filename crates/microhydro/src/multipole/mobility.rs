//! Mobility of many spheres by multipole expansions without a matrix over all of them.
//!
//! Forces on the spheres are given or multipliers of joints, so that one right-hand side is solved
//! for instead of one for each rigid motion: [`crate::LinkedSpheres`] iterates over all multipoles
//! at once. Each pair couples the modes that its distance needs; near pairs have the orders of
//! their gap, which no elimination lowers, so that the matrix stays positive definite among any
//! number of neighbours.

use std::cmp::Reverse;
use std::ops::Range;

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::axis_turn::OfFamilies;
use super::cell_shift::{CellShift, Direction};
use super::coupling::Expansion;
use super::expansion_plan::{ALIKE, ExpansionCost, LOWERED, Plan, PlannedPair, operations};
use super::far_images::{FAR_ORDER, FarImages};
use super::line_of_centres::{Pair, PairOrders, Workspace, harmonics};
use super::modes::{Family, Modes};
use super::orders::Accuracy;
use super::pair_preconditioner::{NarrowPair, PairPreconditioner};
use super::pair_product::Couplings;
use super::rotation::AXIS_OF_M;
use super::scaled::drag_units;
use super::slip_expansion::SlipModes;
use super::stresslet::stresslet_of_modes;
use crate::error::{check_entries, check_finite};
use crate::{HydroError, Medium, Mobility, PointMobility, PointModel, Spheres};

/// The expansions that a product has: errors are estimated from solutions by fewer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Variant {
    /// All.
    Full,
    /// Orders of spheres lower by two.
    Lowered,
    /// Couplings of spheres that neglect 30 times more, and of cells 10 times more.
    Neglecting,
}

/// Number of partial sums of a product, whatever the number of threads.
const SHARES: usize = 16;

/// Pairs that one thread takes, the spheres and cells in them in ascending order, and the places of
/// their harmonics in the sums.
///
/// Most pairs are distant, so that most spheres have few harmonics.
struct Share {
    pairs: Range<usize>,
    bodies: Vec<usize>,
    first: Vec<usize>,
}

impl Share {
    fn new(all: &[PlannedPair], pairs: Range<usize>) -> Self {
        let ends = |planned: &PlannedPair| {
            let [first, second] = planned.ends;
            let [of_first, of_second] = planned.orders;
            [(first, of_first), (second, of_second)]
        };
        let mut orders: Vec<(usize, usize)> = all[pairs.clone()].iter().flat_map(ends).collect();
        // the highest order of each body comes first
        orders.sort_unstable_by_key(|&(body, order)| (body, Reverse(order)));
        orders.dedup_by_key(|(body, _)| *body);
        Self {
            pairs,
            first: places(orders.iter().map(|(_, order)| harmonics(*order))),
            bodies: orders.into_iter().map(|(body, _)| body).collect(),
        }
    }

    /// Place of the harmonics of a body in the pairs.
    fn place(&self, body: usize) -> usize {
        self.first[self.bodies.partition_point(|&other| other < body)]
    }

    /// Harmonics of all bodies.
    fn len(&self) -> usize {
        self.first[self.bodies.len()]
    }

    /// Adds sums over the pairs to the harmonics of the bodies from `from` on, which begin at
    /// `places`.
    fn add(&self, sum: &[OfFamilies], (from, places): (usize, &[usize]), y: &mut [OfFamilies]) {
        let end = from + places.len() - 1;
        let place = |limit: usize| self.bodies.partition_point(|&body| body < limit);
        for number in place(from)..place(end) {
            let own = &mut y[places[self.bodies[number] - from] - places[0]..];
            let added = &sum[self.first[number]..self.first[number + 1]];
            for (entry, added) in own.iter_mut().zip(added) {
                for (entry, added) in entry.iter_mut().zip(added) {
                    *entry += added;
                }
            }
        }
    }

    /// Parts whose products have about equally many operations.
    fn all(pairs: &[PlannedPair]) -> Vec<Self> {
        let operations: Vec<usize> = pairs.chunks(ALIKE).map(operations).collect();
        let all: usize = operations.iter().sum();
        let (mut shares, mut first, mut sum) = (Vec::new(), 0, 0);
        for (number, operations) in operations.iter().enumerate() {
            sum += operations;
            if sum * SHARES >= all * (shares.len() + 1) {
                let end = pairs.len().min((number + 1) * ALIKE);
                shares.push(Self::new(pairs, first..end));
                first = end;
            }
        }
        shares
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
/// [`Variant`]s tell the error. Distant spheres act together as cells do, whose expansions are made
/// of theirs (a fast multipole method; not in a periodic box), so that the number of pairs grows
/// nearly as that of spheres. Memory: `O(L^3)` numbers that all pairs share for the highest order
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
    shares: Vec<Share>,
    cells: Cells,
    /// Distant images in a periodic box.
    far: Option<FarImages>,
    tails: Vec<f64>,
    neglected: f64,
    narrowest: f64,
    variant: Variant,
    preconditioner: PairPreconditioner,
    slip: Option<SlipDrive>,
}

/// What the slip of the spheres is for the rigid motions and multipoles of a [`MultipoleMobility`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SlipDrive {
    /// Rigid motions in the slip, `(U, ω)` of each sphere: with it a sphere that no force and no
    /// other sphere drives moves with the opposite velocities.
    pub velocities: DVector<f64>,
    /// Right-hand side of the multipoles, see [`crate::LinkedSpheres::with_hidden`].
    pub hidden: DVector<f64>,
    /// Power of the slip on flows with its velocities inside the spheres: its power on the fluid
    /// outside is `f · U + h · x` less this one, with the forces `f` and the multipoles `x`.
    pub inner_power: f64,
    /// Root mean square of the velocities on the sphere where it is largest.
    pub speed: f64,
}

impl SlipDrive {
    /// Power of the slip on the fluid by the forces and multipoles of a solution.
    pub fn power(&self, forces: &DVector<f64>, hidden: &DVector<f64>) -> f64 {
        forces.dot(&self.velocities) + hidden.dot(&self.hidden) - self.inner_power
    }
}

/// The cells of distant spheres, bodies after the spheres.
struct Cells {
    orders: Vec<usize>,
    shift: CellShift,
    /// Cells with their parts, such that all parts of a cell are on a level before.
    levels: Vec<Level>,
}

struct Level {
    pairs: Vec<PlannedPair>,
    shares: Vec<Share>,
    /// The cells.
    bodies: Vec<usize>,
}

impl Cells {
    fn new(orders: Vec<usize>, shifts: Vec<Vec<PlannedPair>>) -> Self {
        let level = |pairs: Vec<PlannedPair>| {
            let mut bodies: Vec<usize> = pairs.iter().map(|pair| pair.ends[0]).collect();
            bodies.sort_unstable();
            bodies.dedup();
            Level {
                shares: Share::all(&pairs),
                pairs,
                bodies,
            }
        };
        let levels: Vec<Level> = shifts.into_iter().map(level).collect();
        let highest = |pair: &PlannedPair| pair.orders[0].max(pair.orders[1]);
        let all = levels.iter().flat_map(|level| &level.pairs);
        Self {
            shift: CellShift::new(all.map(highest).max().unwrap_or_default()),
            levels,
            orders,
        }
    }
}

impl<'a> MultipoleMobility<'a> {
    /// Predicted cost of a solution with its error bar to a relative `residual`, in unbounded fluid
    /// or in a periodic box, with slip or without; the least one where that is larger than is
    /// allowed. Cost: some hundred operations for each pair.
    ///
    /// # Errors
    /// As [`MultipoleMobility::new`]; a larger cost than that is allowed is none.
    pub fn cost(
        spheres: &Spheres,
        period: Option<&Vector3<f64>>,
        accuracy: &Accuracy,
        residual: f64,
        slip: Option<&SlipModes>,
    ) -> Result<ExpansionCost, HydroError> {
        match Plan::new(spheres, period, accuracy, slip) {
            Err(HydroError::TooCostly {
                dofs, mib, seconds, ..
            }) => Ok(ExpansionCost { dofs, mib, seconds }),
            plan => Ok(plan?.cost(residual)),
        }
    }

    /// Plans the couplings of all pairs, in unbounded fluid or in a box with the edges `period`
    /// that is repeated in all directions, with zero mean flow as in [`PointMobility::periodic`].
    ///
    /// Images couple as pairs as far as they need more than four degrees; the flow of all others is
    /// that of low multipoles by Ewald's sums, at a cost of `O(n²)`. With slip the expansions have
    /// its multipoles: [`MultipoleMobility::slip`] drives them.
    ///
    /// # Errors
    /// A tolerance that is not between `1e-13` and 1; [`HydroError::GapTooNarrow`] for gaps below
    /// 0.001 radii of the smaller sphere; [`HydroError::TooClose`] for wider ones beside a sphere
    /// more than twice as large, and for those that need higher orders than 560;
    /// [`HydroError::TooCostly`] for the cost to a residual of the tolerance; in a box those of
    /// [`PointMobility::periodic`].
    pub fn new(
        spheres: &'a Spheres,
        period: Option<&Vector3<f64>>,
        accuracy: &Accuracy,
        slip: Option<&SlipModes>,
    ) -> Result<Self, HydroError> {
        let plan = Plan::new(spheres, period, accuracy, slip)?;
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
        let of_cells: Vec<usize> = plan.cells.iter().map(|cell| cell.order).collect();
        let preconditioner = PairPreconditioner::new(spheres.len(), couplings.quarter(), &narrow);
        let mut mobility = Self {
            preconditioner,
            slip: None,
            points: PointMobility::new(PointModel::Rpy, spheres, &Medium::Unbounded)?,
            units: drag_units(radii),
            first: places(expansions.iter().map(|expansion| expansion.modes.len())),
            harmonics: places((plan.orders.iter().chain(&of_cells)).map(|&l| harmonics(l))),
            expansions,
            couplings,
            far: far.transpose()?,
            shares: Share::all(&plan.pairs),
            pairs: plan.pairs,
            cells: Cells::new(of_cells, plan.shifts),
            tails: plan.tails,
            neglected: plan.neglected,
            narrowest: plan.narrowest,
            variant: Variant::Full,
        };
        mobility.slip = slip.map(|slip| mobility.drive_of(slip));
        Ok(mobility)
    }

    /// What the slip of the spheres drives; none without slip.
    ///
    /// It is the same for all variants.
    pub fn slip(&self) -> Option<&SlipDrive> {
        self.slip.as_ref()
    }

    fn drive_of(&self, slip: &SlipModes) -> SlipDrive {
        let (traces, inner_power) = slip.traces(&self.expansions);
        let all = traces.iter().flat_map(|of| of.col_as_slice(0));
        let mut hidden = DVector::from_iterator(self.dofs(), all.copied());
        SlipDrive {
            velocities: self.split_rigid(&mut hidden),
            hidden,
            inner_power,
            speed: slip.speed(),
        }
    }

    /// Velocities of the spheres in the coefficients of all modes, which then are without them.
    fn split_rigid(&self, all: &mut DVector<f64>) -> DVector<f64> {
        let n = self.expansions.len();
        let mut velocities = DVector::zeros(6 * n);
        for (row, place, unit) in (0..n).flat_map(|sphere| self.rigid(sphere)) {
            velocities[place] = all[row] / unit;
            all[row] = 0.0;
        }
        velocities
    }

    /// The same couplings with the expansions of a variant.
    pub fn set_variant(&mut self, variant: Variant) {
        self.variant = variant;
    }

    /// Factor from the change by [`Variant::Lowered`] to the error: the largest of
    /// [`MultipoleMobility::tails`].
    pub fn tail(&self) -> f64 {
        self.tails.iter().copied().fold(0.0, f64::max)
    }

    /// The factor of each sphere, which falls with the width of its narrowest gap.
    pub fn tails(&self) -> &[f64] {
        &self.tails
    }

    /// Mean of the factors of all spheres for the multipoles `hidden` of a solution, with the
    /// energies of the degrees that [`Variant::Lowered`] omits as weights.
    ///
    /// The change of the power by lower orders is the sum of these energies, up to reflections: the
    /// mean is the factor from it to the error of the power, also where one gap of many is narrow.
    pub fn mean_tail(&self, hidden: &DVector<f64>) -> f64 {
        let mut sums = [0.0; 2];
        for (sphere, tail) in self.tails.iter().enumerate() {
            let (modes, first) = self.of_sphere(sphere);
            let omitted = modes
                .shells()
                .filter(|&(family, l)| !modes.in_lower_order(family, l));
            let rows = omitted.flat_map(|(family, l)| modes.shell(family, l));
            let energy: f64 = rows.map(|row| hidden[first + row].powi(2)).sum();
            sums[0] += tail * energy;
            sums[1] += energy;
        }
        match sums {
            [sum, all] if all > 0.0 => sum / all,
            _ => self.tail(),
        }
    }

    /// Relative error of the couplings of spheres that the orders of pairs are chosen for.
    pub fn neglected(&self) -> f64 {
        self.neglected
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

    /// Coefficients of all modes, by degree and azimuthal number; zero for cells.
    fn by_harmonic(&self, x: &[f64]) -> Vec<OfFamilies> {
        let mut all = vec![[0.0; 3]; self.harmonics[self.harmonics.len() - 1]];
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

    /// Adds the modes of one sphere, given by `x`, to the sums over pairs; modes above the order of
    /// the variant are zero.
    fn with_sums(&self, sphere: usize, x: &[f64], sums: &[OfFamilies]) -> Vec<f64> {
        let modes = self.expansions[sphere].modes;
        let used = Modes {
            order: self.order(sphere),
        };
        let mut y = vec![0.0; modes.len()];
        for (k, (family, own)) in modes.families().enumerate() {
            let kept = harmonics(used.max_degree(family));
            let values = x[own.clone()].iter().zip(sums).take(kept);
            for (y, (x, sum)) in y[own].iter_mut().zip(values) {
                *y = x + sum[k];
            }
        }
        y
    }

    /// Adds the products of some pairs to `y`, both by degree and azimuthal number.
    fn add_pairs(
        &self,
        (pairs, shares): (&[PlannedPair], &[Share]),
        direction: Option<Direction>,
        x: &[OfFamilies],
        y: &mut [OfFamilies],
    ) {
        let arch = Arch::new();
        let sums: Vec<Vec<OfFamilies>> = (shares.par_iter())
            .map(|share| {
                let mut y = vec![[0.0; 3]; share.len()];
                arch.dispatch(OfPairs {
                    all: self,
                    direction,
                    pairs: &pairs[share.pairs.clone()],
                    share,
                    x,
                    y: &mut y,
                });
                y
            })
            .collect();
        // ranges of bodies, with the places of their harmonics
        let bodies = self.harmonics.len() - 1;
        let most = bodies.div_ceil(SHARES).max(1);
        let (mut ranges, mut rest) = (Vec::new(), y);
        for from in (0..bodies).step_by(most) {
            let places = &self.harmonics[from..=bodies.min(from + most)];
            let (own, others) = rest.split_at_mut(places[places.len() - 1] - places[0]);
            ranges.push(((from, places), own));
            rest = others;
        }
        ranges.into_par_iter().for_each(|(range, y)| {
            for (share, sum) in shares.iter().zip(&sums) {
                share.add(sum, range, y);
            }
        });
    }

    /// The couplings of all spheres with each other.
    fn couplings(&self, mut x: Vec<OfFamilies>) -> Vec<OfFamilies> {
        let Cells { shift, levels, .. } = &self.cells;
        let mut y = vec![[0.0; 3]; x.len()];
        for Level {
            pairs,
            shares,
            bodies,
        } in levels
        {
            self.add_pairs((pairs, shares), Some(Direction::Up), &x, &mut y);
            for &cell in bodies {
                let own = self.harmonics[cell]..self.harmonics[cell + 1];
                x[own.clone()].swap_with_slice(&mut y[own.clone()]);
                shift.remove_w_from_v(Direction::Up, &mut x[own]);
            }
        }
        self.add_pairs((&self.pairs, &self.shares), None, &x, &mut y);
        for Level {
            pairs,
            shares,
            bodies,
        } in levels.iter().rev()
        {
            // of the cells what acts on them
            for &cell in bodies {
                let own = self.harmonics[cell]..self.harmonics[cell + 1];
                x[own.clone()].copy_from_slice(&y[own.clone()]);
                shift.remove_w_from_v(Direction::Down, &mut x[own]);
            }
            self.add_pairs((pairs, shares), Some(Direction::Down), &x, &mut y);
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

    /// The order of a sphere or cell in products.
    fn order(&self, body: usize) -> usize {
        let Some(sphere) = self.expansions.get(body) else {
            return self.cells.orders[body - self.expansions.len()];
        };
        match self.variant {
            Variant::Lowered => sphere.modes.order - LOWERED,
            _ => sphere.modes.order,
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
    /// The direction between cells and their parts; none for couplings.
    direction: Option<Direction>,
    pairs: &'m [PlannedPair],
    share: &'m Share,
    x: &'m [OfFamilies],
    y: &'m mut [OfFamilies],
}

impl WithSimd for OfPairs<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let mut work = Workspace::<S>::default();
        let Self {
            all, share, x, y, ..
        } = self;
        let omitted = match all.variant {
            Variant::Lowered => LOWERED,
            _ => 0,
        };
        let quarter = all.couplings.quarter();
        let mut pairs = Vec::with_capacity(S::F64_LANES);
        for some in self.pairs.chunks(S::F64_LANES) {
            pairs.clear();
            pairs.extend(some.iter().map(|planned| Pair {
                line: &planned.line,
                orders: all.pair_orders(planned),
                is_complete: planned.ends.map(|body| body >= all.expansions.len()),
                given: planned.ends.map(|body| all.harmonics[body]),
                found: planned.ends.map(|body| share.place(body)),
            }));
            match self.direction {
                None => {
                    let regular = some[0].regular.saturating_sub(omitted);
                    (all.couplings).add(simd, (&pairs, regular), x, y, &mut work);
                }
                Some(direction) => {
                    (all.cells.shift).add(simd, (direction, quarter), &pairs, x, y, &mut work);
                }
            }
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
        let sums = self.couplings(self.by_harmonic(x));
        let of_spheres: Vec<Vec<f64>> = (0..n)
            .into_par_iter()
            .map(|sphere| {
                let own = &x[self.first[sphere]..self.first[sphere + 1]];
                self.with_sums(sphere, own, &sums[self.harmonics[sphere]..])
            })
            .collect();
        let mut hidden = DVector::from_vec(of_spheres.concat());
        self.add_far_images(x, &mut hidden);
        let velocities = self.split_rigid(&mut hidden);
        Ok([velocities, hidden])
    }

    fn own_block(&self, some: &[usize]) -> DMatrix<f64> {
        self.points.block_without_images(some)
    }

    fn precondition_hidden(&self, x: &mut DVector<f64>) {
        self.preconditioner
            .apply(x, |sphere| self.of_sphere(sphere));
    }

    fn clear_places_of_forces(&self, x: &mut DVector<f64>) {
        self.split_rigid(x);
    }

    fn not_positive_definite(&self) -> HydroError {
        HydroError::FactorisationFailed {
            matrix: "Galerkin matrix",
            size: self.dofs(),
        }
    }
}
