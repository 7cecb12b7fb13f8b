//! Products of the coupling of two expansions with one vector.
//!
//! The numbers of a [`Coupling`] in one piece of memory: thousands of spheres have half a million
//! pairs, most of them with a hundred numbers. High degrees of a narrow gap act on the other
//! surface with the azimuthal numbers 0 and 1 about its axis alone, and only these are stored.

use super::coupling::Coupling;
use super::modes::{FAMILIES, Family, Modes};

/// Orders of a source and of a target.
pub(super) type PairOrders = [usize; 2];

/// Coupling of two spheres, for products with one vector.
pub(super) struct PairProduct {
    /// Orders of the modes that are stored.
    orders: PairOrders,
    /// Highest degree with all azimuthal numbers; above it there are 0 and 1.
    regular: usize,
    /// Rotations onto the line of centres of the degrees from one, by columns, each of the rows
    /// `-highest(l) ..= highest(l)`; then the matrices of the azimuthal numbers from zero, by
    /// columns.
    numbers: Box<[f64]>,
}

/// Vectors along the line of centres, for each azimuthal number those of both symmetry classes.
#[derive(Default)]
pub(super) struct Workspace {
    source: Vec<f64>,
    target: Vec<f64>,
    /// The modes of one degree.
    rotated: Vec<f64>,
}

/// Highest azimuthal number of a degree.
fn highest(l: usize, regular: usize) -> usize {
    if l <= regular { l } else { l.min(1) }
}

/// Number of numbers in the rotations of all degrees.
fn rotations(orders: PairOrders, regular: usize) -> usize {
    let of_degree = |l| (2 * highest(l, regular) + 1) * (2 * l + 1);
    (1..=orders[0].max(orders[1])).map(of_degree).sum()
}

/// Number of numbers that [`PairProduct`] stores.
pub(super) fn numbers(orders: PairOrders, regular: usize) -> usize {
    let sectors = azimuthal_numbers(orders, regular).map(|m| {
        let [columns, rows] = orders.map(|order| Sector::new(m, order, regular).len);
        columns * rows
    });
    rotations(orders, regular) + sectors.sum::<usize>()
}

/// Multiplications of the products in both directions.
pub(super) fn operations(orders: PairOrders, regular: usize) -> usize {
    let rotations = rotations(orders, regular);
    let sectors = numbers(orders, regular) - rotations;
    // three families at both ends, two classes
    2 * (6 * rotations + 2 * sectors)
}

fn azimuthal_numbers(orders: PairOrders, regular: usize) -> std::ops::RangeInclusive<usize> {
    0..=orders[0].min(orders[1]).min(regular.max(1))
}

/// Modes of an azimuthal number: for each family the place of degree zero and the highest degree.
#[derive(Clone, Copy)]
struct Sector {
    m: usize,
    first: [usize; 3],
    last: [usize; 3],
    len: usize,
}

impl Sector {
    /// The modes of expansions up to an order.
    fn new(m: usize, order: usize, regular: usize) -> Self {
        let mut sector = Self {
            m,
            first: [0; 3],
            last: [0; 3],
            len: 0,
        };
        for (k, family) in FAMILIES.into_iter().enumerate() {
            let top = (Modes { order }).max_degree(family);
            let top = if m <= 1 { top } else { top.min(regular) };
            let lowest = m.max(1);
            // degree `l` is at `first + l - lowest`
            sector.first[k] = sector.len;
            sector.last[k] = top;
            sector.len += (top + 1).saturating_sub(lowest);
        }
        sector
    }

    /// Place of a degree of a family.
    fn place(&self, family: usize, l: usize) -> usize {
        self.first[family] + l - self.m.max(1)
    }

    /// Places of the degrees of a family up to an order, and with higher azimuthal numbers up to
    /// the degree `regular`.
    fn places(&self, family: usize, order: usize, regular: usize) -> std::ops::Range<usize> {
        let top = (Modes { order }).max_degree(FAMILIES[family]);
        let top = top.min(self.last[family]);
        let top = if self.m <= 1 { top } else { top.min(regular) };
        let first = self.first[family];
        first..first + (top + 1).saturating_sub(self.m.max(1))
    }
}

impl PairProduct {
    /// The modes of a coupling, with all azimuthal numbers up to the degree `regular`.
    pub fn new(coupling: &Coupling, regular: usize) -> Self {
        let orders = coupling.orders();
        let regular = regular.max(1);
        let mut all = Vec::with_capacity(numbers(orders, regular));
        for l in 1..=orders[0].max(orders[1]) {
            let rotation = coupling.rotation(l);
            let rows = highest(l, regular);
            for column in 0..2 * l + 1 {
                all.extend((l - rows..=l + rows).map(|row| rotation[(row, column)]));
            }
        }
        for m in azimuthal_numbers(orders, regular) {
            let matrix = coupling.sector(m);
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
        Self {
            orders,
            regular,
            numbers: all.into_boxed_slice(),
        }
    }

    /// Adds the product with the coefficients `x` of one sphere, of the modes `from`, to those of
    /// the other, `y`, of the modes `to`, with orders up to `most`.
    ///
    /// `backward` exchanges source and target: `x` belongs to the target and the product is with
    /// the transpose. Degrees with all azimuthal numbers are lower by `omitted`.
    #[inline(always)]
    pub fn add(
        &self,
        (x, from): (&[f64], Modes),
        (y, to): (&mut [f64], Modes),
        (most, omitted): (PairOrders, usize),
        backward: bool,
        work: &mut Workspace,
    ) {
        let turned = |of: PairOrders| if backward { [of[1], of[0]] } else { of };
        let stored = turned(self.orders);
        let used = [stored[0].min(most[0]), stored[1].min(most[1])];
        let [of_columns, of_rows] = turned(used);
        let regular = self.regular.saturating_sub(omitted);
        let numbers = azimuthal_numbers(self.orders, self.regular);
        let last = *numbers.end();
        let top = self.orders[0].max(self.orders[1]);
        let stride = 3 * (top + 1);
        // two vectors for each azimuthal number
        let place = |m: usize, class: usize| (2 * m + class) * stride;
        let Workspace {
            source,
            target,
            rotated,
        } = work;
        for list in [&mut *source, &mut *target] {
            list.clear();
            list.resize(place(last + 1, 0), 0.0);
        }
        let sector = |m: usize, order: usize| Sector::new(m, order, self.regular);

        let mut first = 0;
        for l in 1..=used[0] {
            let (rows, width) = (highest(l, self.regular), 2 * l + 1);
            let height = 2 * rows + 1;
            let rotation = &self.numbers[first..first + height * width];
            first += height * width;
            for (k, family) in FAMILIES.into_iter().enumerate() {
                if !(Modes { order: used[0] }).contains(family, l) {
                    continue;
                }
                rotated.clear();
                rotated.resize(height, 0.0);
                let own = &x[from.shell(family, l)];
                for (column, &value) in rotation.chunks_exact(height).zip(own) {
                    for (sum, entry) in rotated.iter_mut().zip(column) {
                        *sum += entry * value;
                    }
                }
                for m in 0..=rows.min(last) {
                    let own = sector(m, stored[0]).place(k, l);
                    let (cosine, sine) = (rotated[rows + m], rotated[rows - m]);
                    let of_class = match family {
                        Family::Rotlet => [sine, -cosine],
                        _ => [cosine, sine],
                    };
                    // the azimuthal number zero has one class
                    for (class, value) in of_class.into_iter().enumerate().take(m + 1) {
                        source[place(m, class) + own] = value;
                    }
                }
            }
        }

        let mut first = rotations(self.orders, self.regular);
        for m in numbers {
            let [columns, rows] = self.orders.map(|order| sector(m, order));
            let (height, matrix) = (rows.len, &self.numbers[first..]);
            first += columns.len * height;
            for class in 0..(m + 1).min(2) {
                let at = place(m, class);
                let source = &source[at..at + stride];
                let target = &mut target[at..at + stride];
                for column in (0..3).flat_map(|family| columns.places(family, of_columns, regular))
                {
                    let entries = &matrix[column * height..(column + 1) * height];
                    for own in (0..3).map(|family| rows.places(family, of_rows, regular)) {
                        if backward {
                            target[column] += dot(&entries[own.clone()], &source[own]);
                        } else {
                            let value = source[column];
                            for (sum, entry) in target[own.clone()].iter_mut().zip(&entries[own]) {
                                *sum += entry * value;
                            }
                        }
                    }
                }
            }
        }

        let mut first = 0;
        for l in 1..=used[1] {
            let (rows, width) = (highest(l, self.regular), 2 * l + 1);
            let height = 2 * rows + 1;
            let rotation = &self.numbers[first..first + height * width];
            first += height * width;
            for (k, family) in FAMILIES.into_iter().enumerate() {
                if !(Modes { order: used[1] }).contains(family, l) {
                    continue;
                }
                rotated.clear();
                rotated.resize(height, 0.0);
                for m in 0..=rows.min(last) {
                    let own = sector(m, stored[1]).place(k, l);
                    let of_class = [target[place(m, 0) + own], target[place(m, 1) + own]];
                    let [cosine, sine] = match family {
                        Family::Rotlet => [-of_class[1], of_class[0]],
                        _ => of_class,
                    };
                    rotated[rows + m] = cosine;
                    if m > 0 || family == Family::Rotlet {
                        rotated[rows - m] = sine;
                    }
                }
                let columns = rotation.chunks_exact(height);
                for (column, sum) in columns.zip(&mut y[to.shell(family, l)]) {
                    *sum += dot(column, rotated);
                }
            }
        }
    }
}

/// Number of partial sums: two vectors of the widest instructions.
const LANES: usize = 8;

/// Scalar product, whose partial sums do not depend on the processor.
#[inline(always)]
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; LANES];
    let (a, b) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest = a.remainder().iter().zip(b.remainder());
    let rest: f64 = rest.map(|(x, y)| x * y).sum();
    for (a, b) in a.zip(b) {
        for ((sum, x), y) in sums.iter_mut().zip(a).zip(b) {
            *sum += x * y;
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::coupling::Expansion;
    use super::*;

    fn product(
        pair: &PairProduct,
        x: &[f64],
        modes: [Modes; 2],
        most: PairOrders,
        backward: bool,
    ) -> Vec<f64> {
        let mut y = vec![0.0; modes[1].len()];
        let mut work = Workspace::default();
        pair.add(
            (x, modes[0]),
            (&mut y, modes[1]),
            (most, 0),
            backward,
            &mut work,
        );
        y
    }

    #[test]
    fn products_are_those_of_the_dense_coupling_in_both_directions_and_of_lower_orders() {
        let orders = [7, 4];
        let [from, to] = [6, 4].map(|order| Modes { order });
        let all = [Modes { order: orders[0] }, Modes { order: orders[1] }];
        let ends = [(1.0, from), (0.7, to)].map(|(radius, modes)| Expansion { radius, modes });
        let offset = Vector3::new(1.0, -2.0, 0.8);
        let coupling = Coupling::up_to_azimuthal((0, 1), (&ends[0], &ends[1]), &offset, 10);
        let pair = PairProduct::new(&coupling, 10);
        assert_eq!(pair.numbers.len(), numbers([6, 4], 10));
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
            let forward = product(&pair, &x, [all[0], all[1]], most, false);
            let most = [most[1], most[0]];
            let backward = product(&pair, &x[..to.len()], [all[1], all[0]], most, true);
            let pairs = forward
                .iter()
                .zip(&expected)
                .chain(backward.iter().zip(&back));
            for (found, expected) in pairs {
                assert!((found - expected).abs() < 1e-13, "{found} {expected}");
            }
        }
    }
}
