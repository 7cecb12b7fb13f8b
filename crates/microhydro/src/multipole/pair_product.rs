//! Products of the couplings of many pairs with one vector, without a matrix of any pair.
//!
//! On its line of centres the coupling of two spheres consists of numbers that all pairs share,
//! times powers of the radii `a` and `b` over the distance `d`: from degree `l` at the source to
//! `k` at the target
//! ```text
//! c_lkm (a/d)^(l + e) (b/d)^(k + e'),   e = -1/2, 1/2, 3/2 for W, X, V
//! ```
//! (`axial_translation`, without the self energies). A `W` has a part without pressure, which is
//! that of a `V`: without it, 3 of 9 couplings of two families are zero, and `V` acts on the
//! pressure of the target alone. High degrees of a narrow gap act on the other surface
//! with the azimuthal numbers 0 and 1 about its axis alone, and only these are used.

use pulp::Simd;

use super::axial_translation::{OutgoingTranslation, potential};
use super::axis_turn::{Lanes, OfFamilies, QuarterTurn};
use super::lamb::{LambCoefficients, trace_index};
use super::line_of_centres::{
    Classes, Pair, PairOrders, Turns, Workspace, gather, half_powers, harmonics, highest_orders,
    last, scatter,
};
use super::modes::{FAMILIES, Family};

/// Highest degree of an azimuthal number.
fn top_degree(order: usize, m: usize, regular: usize) -> usize {
    if m <= 1 { order } else { order.min(regular) }
}

/// Multiplications of the products in both directions, and what takes as long.
pub(super) fn operations(orders: PairOrders, regular: usize) -> usize {
    // to the line of centres and back, two quarter turns of blocks with a quarter of the entries
    let of_degree = |l: usize| 3 * (2 * l + 1).pow(2);
    let turned =
        |&order: &usize| (1..=order).map(of_degree).sum::<usize>() + MOVED * harmonics(order);
    let turns: usize = orders.iter().map(turned).sum();
    let coupled = (0..=last(orders, regular)).map(|m| {
        let degrees = |order| (top_degree(order, m, regular) + 1).saturating_sub(m.max(1));
        let classes = if m == 0 { 1 } else { 2 };
        classes * 2 * COUPLED * degrees(orders[0]) * degrees(orders[1])
    });
    turns + coupled.sum::<usize>()
}

/// Multiplications that take as long as moving one harmonic of an end into a lane, onto the line of
/// centres and back: products of the orders 4 and 24 were timed.
const MOVED: usize = 80;

/// Couplings between families that are not zero: `WW`, `WX`, `WV`, `XW`, `XX`, `VW`, from the
/// source to the target.
const COUPLED: usize = 6;

/// Numbers that [`Couplings`] store up to the degree `top`, of azimuthal numbers above one up to
/// `regular`.
pub(super) fn shared_numbers(top: usize, regular: usize) -> f64 {
    let [top, regular] = [top, regular.min(top)].map(|degree| degree as f64);
    let of_turns = 4.0 / 3.0 * top.powi(3) / 4.0 * 2.0;
    let axial = COUPLED as f64 * (2.0 * top.powi(2) + regular.powi(3) / 3.0);
    of_turns + axial
}

/// The numbers that all pairs share.
pub(super) struct Couplings {
    quarter: QuarterTurn,
    /// The part without pressure of `W`, by degree, in the scaled modes: so much of it is `V`.
    potential: Vec<f64>,
    /// Highest degree, and the highest one with all azimuthal numbers.
    top: usize,
    regular: usize,
    /// For each azimuthal number the couplings of all degrees, those of a source one after the
    /// other.
    axial: Vec<Vec<[f64; COUPLED]>>,
}

impl Couplings {
    /// Couplings up to the degree `top`, of azimuthal numbers above one up to `regular`. Memory:
    /// [`shared_numbers`].
    pub fn new(top: usize, regular: usize) -> Self {
        let axial = |m: usize| -> Vec<[f64; COUPLED]> {
            let top = top_degree(top, m, regular);
            // radii and distance 1
            let translation = OutgoingTranslation::new(m, (1.0, top), (1.0, top), 1.0);
            let degrees = || m.max(1)..=top;
            let pairs = degrees().flat_map(|l| degrees().map(move |k| (l, k)));
            pairs.map(|(l, k)| coupled(&translation, l, k)).collect()
        };
        Self {
            quarter: QuarterTurn::new(top),
            potential: (0..=top)
                .map(|l| match l {
                    0 => 0.0,
                    _ => potential(l) * weight(Family::Source, l) / weight(Family::Stokeslet, l),
                })
                .collect(),
            top,
            regular,
            axial: (0..=last([top; 2], regular)).map(axial).collect(),
        }
    }

    pub fn quarter(&self) -> &QuarterTurn {
        &self.quarter
    }

    /// Couplings of degree `l` of the source with those of the target up to the degree `top`.
    #[inline(always)]
    fn row(&self, m: usize, l: usize, top: usize) -> &[[f64; COUPLED]] {
        let lowest = m.max(1);
        let width = top_degree(self.top, m, self.regular) + 1 - lowest;
        let first = (l - lowest) * width;
        &self.axial[m][first..first + top + 1 - lowest]
    }
}

/// Square root of the self energy of a mode on the unit sphere.
pub(super) fn weight(family: Family, l: usize) -> f64 {
    family.energy(l, 1.0).sqrt()
}

/// Couplings of the degrees `l` and `k` without the parts that `W` and `V` share.
fn coupled(translation: &OutgoingTranslation, l: usize, k: usize) -> [f64; COUPLED] {
    let entry = |from: Family, flow: LambCoefficients, to: Family| {
        flow.trace(k)[trace_index(to)] * weight(to, k) / weight(from, l)
    };
    let of_w = translation.with_pressure(l, k);
    let without_pressure = LambCoefficients { p: 0.0, ..of_w };
    let [w, x, v] = FAMILIES;
    let [of_x, of_v] = [x, v].map(|family| translation.coefficients(family, l, k));
    [
        entry(w, without_pressure, w),
        entry(w, of_w, x),
        entry(w, of_w, v),
        entry(x, of_x, w),
        entry(x, of_x, x),
        entry(v, of_v, w),
    ]
}

impl Couplings {
    /// Adds the products of some pairs, one a lane, in both directions: that with the coefficients
    /// of the source to those of the target, and that of the transpose with the coefficients of the
    /// target to those of the source.
    ///
    /// Degrees up to `regular` have all azimuthal numbers. `x` and `y` have [`harmonics`] of the
    /// orders from the places of the pairs on. Degrees and `regular` are at most those of
    /// [`Couplings::new`].
    #[inline(always)]
    pub fn add<S: Simd>(
        &self,
        simd: S,
        (pairs, regular): (&[Pair], usize),
        x: &[OfFamilies],
        y: &mut [OfFamilies],
        work: &mut Workspace<S>,
    ) {
        let Some(tops) = highest_orders(pairs) else {
            return;
        };
        let turns = Turns {
            quarter: &self.quarter,
            v_of_w: &self.potential,
        };
        let last = last(tops, regular);
        work.begin(simd, pairs, tops[0].max(tops[1]));
        for end in 0..2 {
            half_powers(simd, (pairs, end), tops[end] + 3, &mut work.powers[end]);
            work.begin_end(simd, end, (last + 1) * tops[end]);
            gather(simd, (pairs, end, tops[end]), x, &mut work.turned);
            turns.onto_line(simd, (end, tops[end]), (regular, last), work);
        }
        self.couple(simd, tops, (regular, last), work);
        for end in 0..2 {
            turns.off_line(simd, (end, tops[end]), (regular, last), work);
            scatter::<S>((pairs, end), &work.turned, y);
        }
    }

    /// The couplings along the line in both directions.
    #[inline(always)]
    fn couple<S: Simd>(
        &self,
        simd: S,
        tops: PairOrders,
        (regular, last): (usize, usize),
        work: &mut Workspace<S>,
    ) {
        for m in 0..=last {
            let lowest = m.max(1);
            let [sources, targets] = tops.map(|top| top_degree(top, m, regular));
            let of_end = |end: usize, degree: usize| m * tops[end] + degree - 1;
            let targets = of_end(1, lowest)..of_end(1, targets) + 1;
            let [of_source, of_target] = &mut work.found;
            let of_target = &mut of_target[targets.clone()];
            of_target.fill([[simd.splat_f64s(0.0); 3]; 2]);
            for l in lowest..=sources {
                let row = self.row(m, l, lowest + targets.len() - 1);
                let given = &work.given[0][of_end(0, l)];
                let others = &work.given[1][targets.clone()];
                of_source[of_end(0, l)] = match m {
                    0 => couple_degree::<S, 1>(simd, row, given, others, of_target),
                    _ => couple_degree::<S, 2>(simd, row, given, others, of_target),
                };
            }
        }
    }
}

/// Couples one degree of the source with those of the target; returns what acts on the source.
#[inline(always)]
fn couple_degree<S: Simd, const CLASSES: usize>(
    simd: S,
    row: &[[f64; COUPLED]],
    given: &Classes<S>,
    others: &[Classes<S>],
    found: &mut [Classes<S>],
) -> Classes<S> {
    let mut back = [[simd.splat_f64s(0.0); 3]; 2];
    for ((numbers, others), found) in row.iter().zip(others).zip(found) {
        let (ww, wx) = (simd.splat_f64s(numbers[0]), simd.splat_f64s(numbers[1]));
        let (wv, xw) = (simd.splat_f64s(numbers[2]), simd.splat_f64s(numbers[3]));
        let (xx, vw) = (simd.splat_f64s(numbers[4]), simd.splat_f64s(numbers[5]));
        for class in 0..CLASSES {
            let forth = [ww, wx, wv, xw, xx, vw];
            add_coupled(simd, forth, &given[class], &mut found[class]);
            let transposed = [ww, xw, vw, wx, xx, wv];
            add_coupled(simd, transposed, &others[class], &mut back[class]);
        }
    }
    back
}

/// Adds the couplings of one degree of a source with one of a target.
#[inline(always)]
fn add_coupled<S: Simd>(
    simd: S,
    [ww, wx, wv, xw, xx, vw]: [S::f64s; COUPLED],
    [w, x, v]: &Lanes<S>,
    y: &mut Lanes<S>,
) {
    y[0] = simd.mul_add_f64s(vw, *v, y[0]);
    y[0] = simd.mul_add_f64s(xw, *x, y[0]);
    y[0] = simd.mul_add_f64s(ww, *w, y[0]);
    y[1] = simd.mul_add_f64s(xx, *x, y[1]);
    y[1] = simd.mul_add_f64s(wx, *w, y[1]);
    y[2] = simd.mul_add_f64s(wv, *w, y[2]);
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector, Vector3};
    use pulp::{Arch, Scalar, WithSimd};

    use super::super::coupling::{Coupling, Expansion, SymmetryClass, axial_coupling};
    use super::super::line_of_centres::{Line, highest, of_degree};
    use super::super::modes::Modes;
    use super::*;

    /// Two expansions, the offset of the target and the orders that are used.
    #[derive(Clone)]
    struct Case {
        ends: [Expansion; 2],
        offset: Vector3<f64>,
        orders: PairOrders,
    }

    impl Case {
        fn new(
            radii: [f64; 2],
            offset: [f64; 3],
            of_spheres: PairOrders,
            orders: PairOrders,
        ) -> Self {
            let ends = [0, 1].map(|end| Expansion {
                radius: radii[end],
                modes: Modes {
                    order: of_spheres[end],
                },
            });
            Self {
                ends,
                offset: Vector3::from(offset),
                orders,
            }
        }

        fn used(&self, end: usize) -> Expansion {
            Expansion {
                modes: Modes {
                    order: self.orders[end],
                },
                ..self.ends[end]
            }
        }

        /// Coefficients of all modes of an end.
        fn coefficients(&self, end: usize) -> DVector<f64> {
            DVector::from_fn(self.ends[end].modes.len(), |k, _| {
                (k as f64 + self.offset.norm() + end as f64).sin()
            })
        }

        /// Places of the modes that are used among all of an end.
        fn places(&self, end: usize) -> Vec<usize> {
            let (used, all) = (self.used(end).modes, self.ends[end].modes);
            let shells = used.shells().flat_map(|(f, l)| all.shell(f, l));
            shells.collect()
        }
    }

    /// Coefficients of the modes by degree and azimuthal number.
    fn by_harmonic(x: &DVector<f64>, modes: Modes) -> Vec<OfFamilies> {
        let mut all = vec![[0.0; 3]; harmonics(modes.order)];
        for (family, l) in modes.shells() {
            let k = trace_index(family);
            let values = &x.as_slice()[modes.shell(family, l)];
            for (entry, value) in all[of_degree(l)].iter_mut().zip(values) {
                entry[k] = *value;
            }
        }
        all
    }

    struct Products<'a>(&'a [Case], usize);

    impl WithSimd for Products<'_> {
        type Output = Vec<[Vec<OfFamilies>; 2]>;

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let Self(cases, regular) = self;
            let top = cases.iter().flat_map(|case| case.orders).max().unwrap();
            let couplings = Couplings::new(top, regular);
            let mut work = Workspace::<S>::default();
            // what another pair left behind is not used
            let nan = [simd.splat_f64s(f64::NAN); 3];
            work.turned.resize(200, nan);
            work.degree.resize(30, nan);
            for list in work.given.iter_mut().chain(&mut work.found) {
                list.resize(200, [nan; 2]);
            }
            let lines: Vec<Line> = (cases.iter())
                .map(|case| Line::new(case.ends.map(|end| end.radius), &case.offset))
                .collect();
            let (mut x, mut places) = (Vec::new(), Vec::new());
            for case in cases {
                places.push([0, 1].map(|end| {
                    let first = x.len();
                    x.extend(by_harmonic(&case.coefficients(end), case.ends[end].modes));
                    first
                }));
            }
            let mut y = vec![[0.0; 3]; x.len()];
            let pairs: Vec<Pair> = (cases.iter().zip(&lines).zip(&places))
                .map(|((case, line), places)| Pair {
                    line,
                    orders: case.orders,
                    is_complete: [false; 2],
                    given: *places,
                    found: *places,
                })
                .collect();
            for some in pairs.chunks(S::F64_LANES) {
                couplings.add(simd, (some, regular), &x, &mut y, &mut work);
            }
            let of_case = |(case, first): (&Case, &[usize; 2])| {
                [0, 1].map(|end| y[first[end]..][..harmonics(case.ends[end].modes.order)].to_vec())
            };
            cases.iter().zip(&places).map(of_case).collect()
        }
    }

    /// Compares products with those of a dense matrix from the used modes of the source to those of
    /// the target.
    fn compare(cases: &[Case], regular: usize, matrix: impl Fn(&Case) -> DMatrix<f64>) {
        for found in [
            Arch::new().dispatch(Products(cases, regular)),
            Products(cases, regular).with_simd(Scalar::new()),
        ] {
            for (case, found) in cases.iter().zip(&found) {
                let matrix = matrix(case);
                for (end, matrix) in [(0, matrix.transpose()), (1, matrix)] {
                    let given = case.coefficients(1 - end);
                    let given = given.select_rows(&case.places(1 - end));
                    let product = matrix * given;
                    let mut expected = DVector::zeros(case.ends[end].modes.len());
                    for (place, value) in case.places(end).into_iter().zip(&product) {
                        expected[place] = *value;
                    }
                    let expected = by_harmonic(&expected, case.ends[end].modes);
                    let pairs = found[end].iter().zip(&expected).enumerate();
                    for (place, (found, expected)) in pairs {
                        for k in 0..3 {
                            // Rows of an orthogonal matrix, a coupling with entries below one and
                            // rows of another one: 3 * 81 numbers of up to one, each of three sums.
                            let bound = 3.0 * 243.0 * f64::EPSILON;
                            let error = (found[k] - expected[k]).abs();
                            assert!(error < bound, "end {end}, {place} {k}: {error:e}");
                        }
                    }
                }
            }
        }
    }

    /// More pairs than a register has lanes, and no multiple of them.
    fn cases() -> Vec<Case> {
        let case = Case::new;
        vec![
            case([1.0, 0.7], [1.0, -2.0, 0.8], [8, 7], [8, 7]),
            case([1.0, 1.0], [0.0, 0.0, 2.1], [9, 9], [9, 5]),
            case([0.4, 2.0], [-3.0, 1.0, 0.2], [4, 6], [2, 4]),
            case([1.0, 1.0], [0.0, 0.0, -4.0], [5, 5], [5, 5]),
            case([1.0, 3.0], [1.0, 40.0, 0.2], [4, 6], [1, 1]),
        ]
    }

    #[test]
    fn products_are_those_of_the_dense_coupling_in_both_directions() {
        compare(&cases(), 9, |case| {
            let ends = [case.used(0), case.used(1)];
            let ends = (&ends[0], &ends[1]);
            let coupling = Coupling::between_spheres((0, 1), ends, &case.offset, 1e-300);
            let dense = coupling.dense();
            DMatrix::from_fn(dense.nrows(), dense.ncols(), |i, j| dense[(i, j)])
        });
    }

    #[test]
    fn high_azimuthal_numbers_and_degrees_are_left_out() {
        for regular in [1, 3, 10] {
            // along z, where rotations are the identity
            let cases = [[6, 4], [5, 5], [4, 6], [6, 1], [1, 1]]
                .map(|orders| Case::new([1.0, 0.7], [0.0, 0.0, 3.0], [6, 6], orders));
            compare(&cases, regular, |case| {
                let ends = [case.used(0), case.used(1)];
                let [from, to] = [ends[0].modes, ends[1].modes];
                let mut matrix = DMatrix::zeros(to.len(), from.len());
                for class in SymmetryClass::all(from.order.min(to.order)) {
                    let m = class.m;
                    let coupling = axial_coupling([&ends[0], &ends[1]], 3.0, m);
                    let [columns, rows] = [from, to].map(|modes| class.rows(modes));
                    let kept = |modes: Modes| {
                        let degrees = modes.sector(m).into_iter();
                        let kept = degrees.map(|(_, l)| m <= highest(l, regular));
                        kept.collect::<Vec<_>>()
                    };
                    let (of_columns, of_rows) = (kept(from), kept(to));
                    for (column, &(place, sign)) in columns.iter().enumerate() {
                        for (row, &(target, of_row)) in rows.iter().enumerate() {
                            if of_columns[column] && of_rows[row] {
                                matrix[(target, place)] = sign * of_row * coupling[(row, column)];
                            }
                        }
                    }
                }
                matrix
            });
        }
    }

    /// Numbers of high degrees are up to 2^300 before they are scaled.
    #[test]
    fn high_degrees_of_a_narrow_gap_are_those_of_the_axial_coupling() {
        let (order, distance) = (150, 2.005);
        let case = Case::new([1.0, 1.0], [0.0, 0.0, distance], [order; 2], [order; 2]);
        let x = by_harmonic(&case.coefficients(0), case.ends[0].modes);
        let of_sector = |x: &[OfFamilies], m: usize| {
            let sector = case.ends[0].modes.sector(m).into_iter();
            let cosine = sector.map(|(family, l)| {
                let class = SymmetryClass { m, cosine: true };
                let (row, sign) = class.row(family, l);
                sign * x[of_degree(l).start + row][trace_index(family)]
            });
            DVector::from_iterator(case.ends[0].modes.sector(m).len(), cosine)
        };
        let cases = [case.clone()];
        let found = Arch::new().dispatch(Products(&cases, 1)).remove(0);
        for m in 0..=1 {
            let matrix = axial_coupling([&case.ends[0], &case.ends[1]], distance, m);
            let given = of_sector(&x, m);
            let expected = DVector::from_fn(given.len(), |row, _| {
                (0..given.len())
                    .map(|column| matrix[(row, column)] * given[column])
                    .sum()
            });
            let error = (of_sector(&found[1], m) - &expected).amax();
            // sums of 450 numbers below one, each a product of as many factors as degrees
            assert!(error < 450.0 * 300.0 * f64::EPSILON, "{m}: {error:e}");
            assert!(expected.amax() > 0.1);
        }
    }
}
