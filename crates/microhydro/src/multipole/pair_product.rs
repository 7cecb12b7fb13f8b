//! Products of the coupling of two expansions with one vector.
//!
//! The numbers of a pair are in one piece of memory, and both directions read them once: thousands
//! of spheres have half a million pairs, most of them with two hundred numbers. High degrees of a
//! narrow gap act on the other surface with the azimuthal numbers 0 and 1 about its axis alone, and
//! only these are stored.

use nalgebra::Vector3;

use super::axis_turn::{Angles, OfFamilies, QuarterTurn, Turning};
use super::coupling::{Expansion, axial_coupling};
use super::modes::{FAMILIES, Family, Modes};

/// Orders of a source and of a target.
pub(super) type PairOrders = [usize; 2];

/// Coupling of two spheres, for products with one vector.
pub(super) struct PairProduct {
    /// Orders of the modes that are stored.
    orders: PairOrders,
    /// Highest degree with all azimuthal numbers; above it there are 0 and 1.
    regular: usize,
    /// Direction from the source to the target.
    angles: Angles,
    /// Matrices of the azimuthal numbers from zero, by columns; then zeros that the last rows of a
    /// block may read.
    numbers: Box<[f64]>,
}

/// Number of [`OfFamilies`] of an expansion up to an order; that of degree `l` and azimuthal number
/// `m` is `l^2 - 1 + l + m`.
pub(super) fn harmonics(order: usize) -> usize {
    order * (order + 2)
}

/// Vectors along the line of centres, at the source and the target of the coupling.
#[derive(Default)]
pub(super) struct Workspace {
    /// For each azimuthal number the vectors of both symmetry classes.
    given: [Vec<f64>; 2],
    found: [Vec<f64>; 2],
    /// The modes of each azimuthal number.
    sectors: [Vec<Sector>; 2],
    /// One degree along the line of centres.
    rotated: Vec<OfFamilies>,
    turning: Turning,
    /// Sums of every eighth row, of each column and symmetry class.
    partial: Vec<[[f64; ROWS]; 2]>,
    /// Cosines and sines of the multiples of the angles.
    multiples: Vec<[[f64; 2]; 2]>,
}

/// Highest azimuthal number of a degree.
fn highest(l: usize, regular: usize) -> usize {
    if l <= regular { l } else { l.min(1) }
}

/// Number of numbers that [`PairProduct`] stores beside [`PAIR`].
pub(super) fn numbers(orders: PairOrders, regular: usize) -> usize {
    azimuthal_numbers(orders, regular)
        .map(|m| {
            let [columns, rows] = orders.map(|order| Sector::new(m, order, regular).len);
            columns * rows
        })
        .sum()
}

/// Multiplications of the products in both directions.
pub(super) fn operations(orders: PairOrders, regular: usize) -> usize {
    // two quarter turns for each of three families, to the line of centres and back
    let of_degree = |l: usize| 3 * (2 * l + 1).pow(2);
    let turns: usize = orders
        .map(|order| (1..=order).map(of_degree).sum())
        .iter()
        .sum();
    // two symmetry classes
    turns + 4 * numbers(orders, regular)
}

/// Numbers of a pair without couplings: zeros behind them, angles, orders and the plan.
pub(super) const PAIR: usize = 24;

fn azimuthal_numbers(orders: PairOrders, regular: usize) -> std::ops::RangeInclusive<usize> {
    0..=orders[0].min(orders[1]).min(regular.max(1))
}

/// Modes of an azimuthal number: for each family the place of its lowest degree.
#[derive(Clone, Copy)]
struct Sector {
    first: [usize; 3],
    len: usize,
}

impl Sector {
    /// The modes of expansions up to an order.
    fn new(m: usize, order: usize, regular: usize) -> Self {
        let (mut first, mut len) = ([0; 3], 0);
        for (first, family) in first.iter_mut().zip(FAMILIES) {
            let top = (Modes { order }).max_degree(family);
            let top = if m <= 1 { top } else { top.min(regular) };
            *first = len;
            len += (top + 1).saturating_sub(m.max(1));
        }
        Self { first, len }
    }
}

impl PairProduct {
    /// The coupling of two expansions, the target at `offset` from the source, with all azimuthal
    /// numbers up to the degree `regular`.
    pub fn new(ends: [&Expansion; 2], offset: &Vector3<f64>, regular: usize) -> Self {
        let orders = ends.map(|end| end.modes.order);
        let regular = regular.max(1);
        let mut all = Vec::with_capacity(numbers(orders, regular) + ROWS);
        for m in azimuthal_numbers(orders, regular) {
            let matrix = axial_coupling(ends, offset.norm(), m);
            let kept = |order: usize| {
                let modes = (Modes { order }).sector(m).into_iter().enumerate();
                let kept = modes.filter(|(_, (_, l))| m <= highest(*l, regular));
                kept.map(|(place, _)| place).collect::<Vec<_>>()
            };
            let [columns, rows] = orders.map(kept);
            for &column in &columns {
                all.extend(rows.iter().map(|&row| matrix[(row, column)]));
            }
        }
        all.extend([0.0; ROWS]);
        Self {
            orders,
            regular,
            angles: Angles::new(offset),
            numbers: all.into_boxed_slice(),
        }
    }

    /// Adds the products in both directions: that with the coefficients of the source to those of
    /// the target, and that of the transpose with the coefficients of the target to those of the
    /// source.
    ///
    /// `x` and `y` have [`harmonics`] of the source and of the target. Modes above the orders
    /// `most` are left out at both ends, and degrees with all azimuthal numbers are lower by
    /// `omitted`. `quarter` has the degrees of both ends.
    #[inline(always)]
    pub fn add(
        &self,
        x: [&[OfFamilies]; 2],
        y: [&mut [OfFamilies]; 2],
        (most, omitted): (PairOrders, usize),
        quarter: &QuarterTurn,
        work: &mut Workspace,
    ) {
        let used = [0, 1].map(|end| self.orders[end].min(most[end]));
        let regular = self.regular.saturating_sub(omitted);
        let numbers = azimuthal_numbers(self.orders, self.regular);
        let last = *numbers.end();
        let top = self.orders[0].max(self.orders[1]);
        let stride = (3 * top).next_multiple_of(ROWS);
        for end in 0..2 {
            let sector = |m| Sector::new(m, self.orders[end], self.regular);
            work.sectors[end].clear();
            work.sectors[end].extend(numbers.clone().map(sector));
            let size = 2 * stride * (last + 1);
            work.given[end].clear();
            work.given[end].resize(size, 0.0);
            // all that is read is written before
            work.found[end].resize(size, 0.0);
        }
        let highest_used = |l: usize| highest(l, regular).min(last);
        let families_used =
            |end: usize, l: usize| FAMILIES.map(|f| (Modes { order: used[end] }).contains(f, l));

        let top = used[0].max(used[1]);
        self.angles.multiples(top, &mut work.multiples);
        work.rotated.resize(2 * top + 1, [0.0; 4]);
        for l in 1..=top {
            let of_degree = l * l - 1..l * l + 2 * l;
            for end in (0..2).filter(|&end| l <= used[end]) {
                quarter.onto_line(
                    (l, highest_used(l)),
                    &work.multiples,
                    &x[end][of_degree.clone()],
                    &mut work.rotated[..2 * l + 1],
                    &mut work.turning,
                );
                let is_used = families_used(end, l);
                for (m, sector) in work.sectors[end][..=highest_used(l)].iter().enumerate() {
                    let (cosines, sines) = (work.rotated[l + m], work.rotated[l - m]);
                    for k in 0..3 {
                        let place = 2 * stride * m + sector.first[k] + l - m.max(1);
                        let of_class = match FAMILIES[k] {
                            Family::Rotlet => [sines[k], -cosines[k]],
                            _ => [cosines[k], sines[k]],
                        };
                        if is_used[k] {
                            work.given[end][place] = of_class[0];
                            // the azimuthal number zero has one class
                            if m > 0 {
                                work.given[end][place + stride] = of_class[1];
                            }
                        }
                    }
                }
            }
        }

        let mut first = 0;
        for m in numbers {
            let [columns, rows] = [0, 1].map(|end| work.sectors[end][m].len);
            let of_sector = columns * rows;
            let matrix = &self.numbers[first..first + of_sector + ROWS];
            first += of_sector;
            let range = 2 * stride * m..2 * stride * (m + 1);
            let (given, found) = (&work.given, &mut work.found);
            let size = (rows, columns, stride);
            // by columns, as the numbers are read from memory
            backward(
                matrix,
                size,
                &given[1][range.clone()],
                &mut found[0][range.clone()],
                &mut work.partial,
            );
            forward(matrix, size, &given[0][range.clone()], &mut found[1][range]);
        }

        for l in 1..=top {
            let of_degree = l * l - 1..l * l + 2 * l;
            for end in (0..2).filter(|&end| l <= used[end]) {
                let is_used = families_used(end, l);
                for (m, sector) in work.sectors[end][..=highest_used(l)].iter().enumerate() {
                    let (mut cosines, mut sines) = ([0.0; 4], [0.0; 4]);
                    for k in (0..3).filter(|&k| is_used[k]) {
                        let place = 2 * stride * m + sector.first[k] + l - m.max(1);
                        let of_class = [work.found[end][place], work.found[end][place + stride]];
                        [cosines[k], sines[k]] = match FAMILIES[k] {
                            Family::Rotlet => [-of_class[1], of_class[0]],
                            _ => of_class,
                        };
                    }
                    if m == 0 {
                        // one coefficient, of the class that is given
                        cosines[1] = sines[1];
                        sines = cosines;
                    }
                    work.rotated[l - m] = sines;
                    work.rotated[l + m] = cosines;
                }
                quarter.add_from_line(
                    (l, highest_used(l)),
                    &work.multiples,
                    &work.rotated[..2 * l + 1],
                    &mut y[end][of_degree.clone()],
                    &mut work.turning,
                );
            }
        }
    }
}

/// Rows of a block of a product: two vector registers.
const ROWS: usize = 8;

/// `y = A x` for a matrix by columns and two vectors, each `stride` numbers after the other.
///
/// The last block of rows reads numbers behind its column. What it finds with them is in places of
/// `y` that no mode has.
#[inline(always)]
fn forward(
    matrix: &[f64],
    (rows, columns, stride): (usize, usize, usize),
    x: &[f64],
    y: &mut [f64],
) {
    let (x, y) = (x.split_at(stride), y.split_at_mut(stride));
    let (x0, x1) = (&x.0[..columns], &x.1[..columns]);
    for row in (0..rows).step_by(ROWS) {
        let (mut first, mut second) = ([0.0; ROWS], [0.0; ROWS]);
        for (column, x) in x0.iter().zip(x1).enumerate() {
            if let Some(entries) = matrix[column * rows + row..].first_chunk() {
                add_scaled(&mut first, entries, &[*x.0; ROWS]);
                add_scaled(&mut second, entries, &[*x.1; ROWS]);
            }
        }
        y.0[row..row + ROWS].copy_from_slice(&first);
        y.1[row..row + ROWS].copy_from_slice(&second);
    }
}

#[inline(always)]
fn add_scaled(sums: &mut [f64; ROWS], a: &[f64; ROWS], b: &[f64; ROWS]) {
    for k in 0..ROWS {
        sums[k] += a[k] * b[k];
    }
}

/// `y = A^T x`, as [`forward`].
///
/// `x` is zero in the places that no mode has.
#[inline(always)]
fn backward(
    matrix: &[f64],
    (rows, columns, stride): (usize, usize, usize),
    x: &[f64],
    y: &mut [f64],
    partial: &mut Vec<[[f64; ROWS]; 2]>,
) {
    let (x, y) = (x.split_at(stride), y.split_at_mut(stride));
    let padded = rows.next_multiple_of(ROWS);
    let (x0, x1) = (&x.0[..padded], &x.1[..padded]);
    let blocks = || x0.as_chunks().0.iter().zip(x1.as_chunks().0);
    partial.clear();
    partial.extend((0..columns).map(|column| {
        let entries = &matrix[column * rows..][..padded];
        let (mut first, mut second) = ([0.0; ROWS], [0.0; ROWS]);
        for (entries, (x0, x1)) in entries.as_chunks().0.iter().zip(blocks()) {
            add_scaled(&mut first, entries, x0);
            add_scaled(&mut second, entries, x1);
        }
        [first, second]
    }));
    for ((y0, y1), [first, second]) in y.0.iter_mut().zip(y.1).zip(partial) {
        *y0 = sum(first);
        *y1 = sum(second);
    }
}

/// Sum in pairs.
#[inline(always)]
fn sum(x: &[f64; ROWS]) -> f64 {
    let four: [f64; ROWS / 2] = std::array::from_fn(|k| x[k] + x[k + ROWS / 2]);
    (four[0] + four[2]) + (four[1] + four[3])
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::super::coupling::{Coupling, SymmetryClass};
    use super::*;

    /// Coefficients of the modes by degree and azimuthal number.
    fn by_harmonic(x: &[f64], modes: Modes) -> Vec<OfFamilies> {
        let mut all = vec![[0.0; 4]; harmonics(modes.order)];
        for (family, l) in modes.shells() {
            let k = FAMILIES.iter().position(|&f| f == family).unwrap();
            for (entry, value) in all[l * l - 1..].iter_mut().zip(&x[modes.shell(family, l)]) {
                entry[k] = *value;
            }
        }
        all
    }

    fn products(
        pair: &PairProduct,
        x: [&[OfFamilies]; 2],
        most: (PairOrders, usize),
    ) -> [Vec<OfFamilies>; 2] {
        let [mut source, mut target] = x.map(|x| vec![[0.0; 4]; x.len()]);
        let mut work = Workspace::default();
        let quarter = QuarterTurn::new(6);
        // what another pair left behind is not used
        for list in work.given.iter_mut().chain(&mut work.found) {
            list.resize(1000, f64::NAN);
        }
        pair.add(x, [&mut source, &mut target], most, &quarter, &mut work);
        [source, target]
    }

    /// The coupling on the line of centres without what a product leaves out.
    fn dense(
        ends: [&Expansion; 2],
        kept: impl Fn(usize, Family, usize, usize) -> bool,
    ) -> DMatrix<f64> {
        let [from, to] = ends.map(|end| end.modes);
        let mut matrix = DMatrix::zeros(to.len(), from.len());
        for class in SymmetryClass::all(from.order.min(to.order)) {
            let m = class.m;
            let coupling = axial_coupling(ends, 3.0, m);
            let [columns, rows] = [from, to].map(|modes| class.rows(modes));
            for (column, (&(family, l), &(place, sign))) in
                from.sector(m).iter().zip(&columns).enumerate()
            {
                for (row, (&(other, k), &(target, of_row))) in
                    to.sector(m).iter().zip(&rows).enumerate()
                {
                    if kept(0, family, l, m) && kept(1, other, k, m) {
                        matrix[(target, place)] = sign * of_row * coupling[(row, column)];
                    }
                }
            }
        }
        matrix
    }

    #[test]
    fn products_leave_out_high_azimuthal_numbers_and_degrees() {
        for orders in [[6, 4], [5, 5], [4, 6]] {
            let ends = [(1.0, orders[0]), (0.7, orders[1])].map(|(radius, order)| Expansion {
                radius,
                modes: Modes { order },
            });
            let ends = [&ends[0], &ends[1]];
            for regular in [1, 3, 10] {
                // along z, where rotations are the identity
                let pair = PairProduct::new(ends, &Vector3::new(0.0, 0.0, 3.0), regular);
                for (most, omitted) in [([6, 6], 0), ([6, 6], 2), ([3, 4], 0), ([1, 1], 2)] {
                    let matrix = dense(ends, |end, family, l, m| {
                        let used = Modes {
                            order: orders[end].min(most[end]),
                        };
                        let of_degree = highest(l, regular.saturating_sub(omitted));
                        used.contains(family, l) && m <= of_degree
                    });
                    let [x, y] = [matrix.ncols(), matrix.nrows()]
                        .map(|n| DVector::from_fn(n, |k, _| (k as f64 + 1.0).sin()));
                    let given = [(&x, 0), (&y, 1)].map(|(x, end): (&DVector<f64>, usize)| {
                        by_harmonic(x.as_slice(), ends[end].modes)
                    });
                    let found = products(&pair, [&given[0], &given[1]], (most, omitted));
                    let expected = [(matrix.tr_mul(&y), 0), (&matrix * &x, 1)]
                        .map(|(x, end)| by_harmonic(x.as_slice(), ends[end].modes));
                    for (found, expected) in found.iter().zip(&expected) {
                        for (found, expected) in
                            found.iter().flatten().zip(expected.iter().flatten())
                        {
                            // sums of a hundred numbers below one
                            assert!(
                                (found - expected).abs() < 1e-13,
                                "{orders:?} {regular} {most:?}"
                            );
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn products_are_those_of_the_dense_coupling_in_both_directions_and_of_lower_orders() {
        let orders = [7, 4];
        let [from, to] = [6, 4].map(|order| Modes { order });
        let all = [Modes { order: orders[0] }, Modes { order: orders[1] }];
        let ends = [(1.0, from), (0.7, to)].map(|(radius, modes)| Expansion { radius, modes });
        let offset = Vector3::new(1.0, -2.0, 0.8);
        let coupling = Coupling::between_spheres((0, 1), (&ends[0], &ends[1]), &offset, 1e-300);
        let pair = PairProduct::new([&ends[0], &ends[1]], &offset, 10);
        assert_eq!(pair.numbers.len(), numbers([6, 4], 10) + ROWS);
        let dense = coupling.dense();
        // a row of the dense matrix belongs to a mode up to order 4, a column to one up to 6
        let x: Vec<f64> = (0..all[0].len()).map(|k| (k as f64).sin()).collect();
        for most in [[7, 4], [5, 3], [2, 2]] {
            let mut expected = vec![0.0; to.len()];
            let mut back = vec![0.0; all[0].len()];
            for (family, l) in from
                .shells()
                .filter(|&(f, l)| (Modes { order: most[0] }).contains(f, l))
            {
                for (other, k) in to
                    .shells()
                    .filter(|&(f, k)| (Modes { order: most[1] }).contains(f, k))
                {
                    let places = from.shell(family, l).zip(all[0].shell(family, l));
                    for (column, own) in places {
                        for row in to.shell(other, k) {
                            expected[row] += dense[(row, column)] * x[own];
                            back[own] += dense[(row, column)] * x[row];
                        }
                    }
                }
            }
            let x = [by_harmonic(&x, all[0]), by_harmonic(&x[..to.len()], all[1])];
            let [found_back, found] = products(&pair, [&x[0], &x[1]], (most, 0));
            let expected = by_harmonic(&expected, all[1]);
            let back = by_harmonic(&back, all[0]);
            let pairs = found
                .iter()
                .zip(&expected)
                .chain(found_back.iter().zip(&back));
            let pairs = pairs.flat_map(|(found, expected)| found.iter().zip(expected));
            for (found, expected) in pairs {
                assert!((found - expected).abs() < 1e-13, "{found} {expected}");
            }
        }
    }
}
