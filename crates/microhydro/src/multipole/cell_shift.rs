//! Expansions of cells by those of their parts, spheres or smaller cells.
//!
//! A cell is a container around its parts. Outside, their flow is that of the modes of the
//! container that have its velocities there, and a flow from farther away is one that the
//! container drives inside. Both are the coupling of a container with a sphere
//! (`axial_translation`), in one direction each: the scaled modes, whose self energies are one,
//! have velocities as their coefficients. Along the line of centres, for a container of the radius
//! `b`, a part of the radius `a` and the distance `c`, it consists of numbers that all share times
//! ```text
//! (a/b)^(l + e) (c/b)^(k - l + e'),   e = -1/2, 1/2, 3/2 for W, X, V of the part
//! e' = 0 within a family, 1 to W from X and to X from V, 2 to W from V
//! ```
//! from degree `k` of the container to `l` of the part, without the `W` that is in a `V` of the
//! container ([`CellShift::remove_w_from_v`]).

use pulp::Simd;

use super::axial_translation::InteriorTranslation;
use super::axis_turn::{OfFamilies, QuarterTurn};
use super::lamb::{c, e};
use super::line_of_centres::{
    Pair, Turns, Workspace, gather, half_powers, highest_orders, of_degree, powers, ratios, scatter,
};
use super::modes::{FAMILIES, Family};
use super::pair_product::weight;

/// Couplings between families that are not zero: `WW`, `XW`, `VW`, `XX`, `VX`, `VV`, from the cell
/// to the part.
const COUPLED: usize = 6;

/// How much higher the order of a part may be than that of its cell, with all that couples: `W` up
/// to the next degree, and `V` to the same, which is two below the order.
pub(super) const HIGHER: usize = 2;

/// The numbers that all parts share.
pub(super) struct CellShift {
    top: usize,
    /// For each azimuthal number the couplings of all degrees, those of a degree of the cell one
    /// after the other.
    axial: Vec<Vec<[f64; COUPLED]>>,
    /// How much of a `W` is in a `V` inside, by degree, in the scaled modes.
    w_in_v: Vec<f64>,
    none: Vec<f64>,
}

/// Direction of a product.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Direction {
    /// From the parts to the cells.
    Up,
    /// From the cells to the parts: the transpose.
    Down,
}

impl CellShift {
    /// Numbers that are stored for degrees up to `top`.
    pub fn stored_numbers(top: usize) -> f64 {
        COUPLED as f64 * (top as f64 + 1.0).powi(3) / 3.0
    }

    /// Couplings up to the degree `top`. Memory: [`CellShift::stored_numbers`].
    pub fn new(top: usize) -> Self {
        let w_in_v = |k: usize| match k {
            0 => 0.0,
            _ => {
                let ratio = weight(Family::Stokeslet, k) / weight(Family::Source, k);
                ((2 * k + 1) as f64 * c(k) / e(k) - 1.0) * ratio
            }
        };
        let w_in_v: Vec<f64> = (0..=top).map(w_in_v).collect();
        let axial = |m: usize| -> Vec<[f64; COUPLED]> {
            // radii and distance 1
            let translation = InteriorTranslation::new(m, (1.0, top), (1.0, top), 1.0);
            let degrees = || m.max(1)..=top;
            let pairs = degrees().flat_map(|k| degrees().map(move |l| (k, l)));
            pairs
                .map(|(k, l)| coupled(&translation, w_in_v[k], k, l))
                .collect()
        };
        Self {
            top,
            axial: (0..=top).map(axial).collect(),
            none: vec![0.0; top + 1],
            w_in_v,
        }
    }

    /// Removes the `W` in each `V` of a cell: from sums over its parts (`Up`), or from a flow from
    /// farther away (`Down`).
    pub fn remove_w_from_v(&self, direction: Direction, cell: &mut [OfFamilies]) {
        for (l, factor) in self.w_in_v.iter().enumerate().skip(1) {
            let Some(degree) = cell.get_mut(of_degree(l)) else {
                break;
            };
            for [w, _, v] in degree {
                match direction {
                    Direction::Up => *v -= factor * *w,
                    Direction::Down => *w -= factor * *v,
                }
            }
        }
    }

    /// Adds the products of some cells, the first ends, and their parts, one a lane.
    #[inline(always)]
    pub fn add<S: Simd>(
        &self,
        simd: S,
        (direction, quarter): (Direction, &QuarterTurn),
        pairs: &[Pair],
        x: &[OfFamilies],
        y: &mut [OfFamilies],
        work: &mut Workspace<S>,
    ) {
        let Some(tops) = highest_orders(pairs) else {
            return;
        };
        let [of_cell, of_part] = tops;
        let (top, last) = (of_cell.max(of_part), of_cell.min(of_part));
        let turns = [&self.none, &self.w_in_v].map(|v_of_w| Turns { quarter, v_of_w });
        let one = simd.splat_f64s(1.0);
        work.begin(simd, pairs, top);
        work.powers[0].clear();
        work.powers[0].resize(of_cell + 3, one);
        half_powers(simd, (pairs, 1), of_part + 3, &mut work.powers[1]);
        let mut distances = Vec::with_capacity(top + HIGHER + 1);
        let distance = ratios(simd, pairs, 0);
        powers(simd, (one, distance), top + HIGHER + 1, &mut distances);
        for end in 0..2 {
            work.begin_end(simd, end, (last + 1) * tops[end]);
        }
        let [from, to] = match direction {
            Direction::Up => [1, 0],
            Direction::Down => [0, 1],
        };
        gather(simd, (pairs, from, tops[from]), x, &mut work.turned);
        turns[from].onto_line(simd, (from, tops[from]), (top, last), work);
        match direction {
            Direction::Up => self.couple::<S, true>(simd, tops, &distances, work),
            Direction::Down => self.couple::<S, false>(simd, tops, &distances, work),
        }
        turns[to].off_line(simd, (to, tops[to]), (top, last), work);
        scatter::<S>((pairs, to), &work.turned, y);
    }

    /// The couplings along the line.
    #[inline(always)]
    fn couple<S: Simd, const UP: bool>(
        &self,
        simd: S,
        tops: [usize; 2],
        distances: &[S::f64s],
        work: &mut Workspace<S>,
    ) {
        let zero = [[simd.splat_f64s(0.0); 3]; 2];
        for m in 0..=tops[0].min(tops[1]) {
            let lowest = m.max(1);
            let width = self.top + 1 - lowest;
            let of_part = m * tops[1] + lowest - 1..(m + 1) * tops[1];
            if !UP {
                work.found[1][of_part.clone()].fill(zero);
            }
            for k in lowest..=tops[0] {
                let row = &self.axial[m][(k - lowest) * width..(k + 1 - lowest) * width];
                let of_cell = m * tops[0] + k - 1;
                // degrees of the part from the lowest one to the next of the cell
                let count = (k + 2 - lowest).min(of_part.len());
                let of_part = of_part.start..of_part.start + count;
                let (given, found) = (&work.given, &mut work.found);
                if UP {
                    let mut sum = zero;
                    let parts = row.iter().zip(&given[1][of_part]);
                    for (l, (numbers, x)) in (lowest..).zip(parts) {
                        let numbers = scaled(simd, numbers, (k, l), distances);
                        for class in 0..2 {
                            add_up(simd, &numbers, &x[class], &mut sum[class]);
                        }
                    }
                    found[0][of_cell] = sum;
                } else {
                    let x = &given[0][of_cell];
                    let parts = row.iter().zip(&mut found[1][of_part]);
                    for (l, (numbers, y)) in (lowest..).zip(parts) {
                        let numbers = scaled(simd, numbers, (k, l), distances);
                        for class in 0..2 {
                            add_down(simd, &numbers, &x[class], &mut y[class]);
                        }
                    }
                }
            }
        }
    }
}

/// Couplings of degree `k` of a cell with `l` of a part, without the `W` in a `V`.
fn coupled(translation: &InteriorTranslation, w_in_v: f64, k: usize, l: usize) -> [f64; COUPLED] {
    let [w, x, v] = FAMILIES;
    let [of_w, of_x, of_v] = FAMILIES.map(|family| translation.coefficients(family, k, l));
    let radial = e(l) / (2 * l + 1) as f64;
    let of_potential = |value: f64, from: Family| value * weight(w, l) / weight(from, k);
    let of_rotation = |value: f64, from: Family| -value * weight(x, l) / weight(from, k);
    let without = w_in_v * weight(v, k) / weight(w, k);
    [
        of_potential(of_w.phi, w),
        of_potential(of_x.phi, x),
        of_potential(of_v.phi + without * of_w.phi, v),
        of_rotation(of_x.chi, x),
        of_rotation(of_v.chi, v),
        radial * of_v.p * weight(v, l) / weight(v, k),
    ]
}

/// The couplings of two degrees times powers of the distance.
#[inline(always)]
fn scaled<S: Simd>(
    simd: S,
    numbers: &[f64; COUPLED],
    (k, l): (usize, usize),
    distances: &[S::f64s],
) -> [S::f64s; COUPLED] {
    // couplings with a negative exponent are zero in the table
    let power = [
        distances[k.saturating_sub(l)],
        distances[(k + 1).saturating_sub(l)],
        distances[(k + 2).saturating_sub(l)],
    ];
    let mut all = [simd.splat_f64s(0.0); COUPLED];
    for (number, exponent) in [0, 1, 2, 0, 1, 0].into_iter().enumerate() {
        all[number] = simd.mul_f64s(simd.splat_f64s(numbers[number]), power[exponent]);
    }
    all
}

#[inline(always)]
fn add_down<S: Simd>(
    simd: S,
    [ww, xw, vw, xx, vx, vv]: &[S::f64s; COUPLED],
    [w, x, v]: &[S::f64s; 3],
    y: &mut [S::f64s; 3],
) {
    y[0] = simd.mul_add_f64s(*vw, *v, y[0]);
    y[0] = simd.mul_add_f64s(*xw, *x, y[0]);
    y[0] = simd.mul_add_f64s(*ww, *w, y[0]);
    y[1] = simd.mul_add_f64s(*vx, *v, y[1]);
    y[1] = simd.mul_add_f64s(*xx, *x, y[1]);
    y[2] = simd.mul_add_f64s(*vv, *v, y[2]);
}

#[inline(always)]
fn add_up<S: Simd>(
    simd: S,
    [ww, xw, vw, xx, vx, vv]: &[S::f64s; COUPLED],
    [w, x, v]: &[S::f64s; 3],
    y: &mut [S::f64s; 3],
) {
    y[0] = simd.mul_add_f64s(*ww, *w, y[0]);
    y[1] = simd.mul_add_f64s(*xw, *w, y[1]);
    y[1] = simd.mul_add_f64s(*xx, *x, y[1]);
    y[2] = simd.mul_add_f64s(*vw, *w, y[2]);
    y[2] = simd.mul_add_f64s(*vx, *x, y[2]);
    y[2] = simd.mul_add_f64s(*vv, *v, y[2]);
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector, Vector3};
    use pulp::{Arch, WithSimd};

    use super::super::coupling::{Coupling, Expansion};
    use super::super::lamb::trace_index;
    use super::super::line_of_centres::{Line, PairOrders, harmonics};
    use super::super::modes::Modes;
    use super::*;

    struct Product<'a> {
        direction: Direction,
        line: &'a Line,
        orders: PairOrders,
        x: &'a [OfFamilies],
    }

    impl WithSimd for Product<'_> {
        type Output = Vec<OfFamilies>;

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let top = self.orders[0].max(self.orders[1]);
            let (shifts, quarter) = (CellShift::new(top + 1), QuarterTurn::new(top + 1));
            let of_end = match self.direction {
                Direction::Up => 1,
                Direction::Down => 0,
            };
            let mut x = self.x.to_vec();
            if self.direction == Direction::Down {
                shifts.remove_w_from_v(Direction::Down, &mut x);
            }
            let pairs: Vec<Pair> = (0..3)
                .map(|_| Pair {
                    line: self.line,
                    orders: self.orders,
                    is_complete: [false; 2],
                    given: [0; 2],
                    found: [0; 2],
                })
                .collect();
            let mut y = vec![[0.0; 3]; harmonics(self.orders[1 - of_end])];
            let mut work = Workspace::<S>::default();
            let way = (self.direction, &quarter);
            shifts.add(simd, way, &pairs[..1], &x, &mut y, &mut work);
            if self.direction == Direction::Up {
                shifts.remove_w_from_v(Direction::Up, &mut y);
            }
            y
        }
    }

    /// Against the coupling of a container and a sphere by dense matrices.
    #[test]
    fn shifts_are_the_coupling_with_a_container_in_each_direction() {
        for (radii, offset, orders) in [
            ([3.0, 0.7], [0.9, -0.8, 0.6], [7, 4]),
            ([2.0, 1.0], [0.0, 0.0, 0.0], [5, 5]),
            ([4.0, 1.5], [0.3, 1.0, -2.0], [6, 8]),
            ([4.0, 0.1], [0.0, 0.0, -3.9], [9, 1]),
        ] {
            let ends: [Expansion; 2] = [0, 1].map(|end| Expansion {
                radius: radii[end],
                modes: Modes { order: orders[end] },
            });
            let offset = Vector3::from(offset);
            // the dense coupling needs a line of centres
            let apart = offset + Vector3::z() * f64::EPSILON;
            let dense = Coupling::with_container((0, 1), &ends[0], &ends[1], &apart).dense();
            let dense = DMatrix::from_fn(dense.nrows(), dense.ncols(), |i, j| dense[(i, j)]);
            let line = Line::within(radii, &offset);
            for (direction, from, to, matrix) in [
                (Direction::Down, 0, 1, dense.clone()),
                (Direction::Up, 1, 0, dense.transpose()),
            ] {
                let modes = ends[from].modes;
                let given = DVector::from_fn(modes.len(), |k, _| (k as f64 + 0.3).sin());
                let mut x = vec![[0.0; 3]; harmonics(modes.order)];
                for (family, l) in modes.shells() {
                    let values = &given.as_slice()[modes.shell(family, l)];
                    for (entry, value) in x[of_degree(l)].iter_mut().zip(values) {
                        entry[trace_index(family)] = *value;
                    }
                }
                let x = &x;
                let line = &line;
                let found = Arch::new().dispatch(Product {
                    direction,
                    line,
                    orders,
                    x,
                });
                let exact = matrix * given;
                let modes = ends[to].modes;
                for (family, l) in modes.shells() {
                    let values = &exact.as_slice()[modes.shell(family, l)];
                    for (entry, value) in found[of_degree(l)].iter().zip(values) {
                        let error = (entry[trace_index(family)] - value).abs();
                        // sums of 300 numbers of the size of the largest entry
                        let bound = 300.0 * f64::EPSILON * exact.amax().max(1.0);
                        assert!(error < bound, "{direction:?} {family:?} {l}: {error:e}");
                    }
                }
            }
        }
    }
}
