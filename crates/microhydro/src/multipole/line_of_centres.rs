//! Coefficients of pairs of spheres, turned onto their lines of centres and back.
//!
//! The lanes of vector registers are pairs of similar orders, so that all of a product works on
//! whole registers. On the line coefficients are multiplied by powers of the radii over the
//! distance, and `V` is joined with a multiple of `W` ([`Turns`]): products of pairs
//! (`pair_product`) and shifts between a cell and its parts (`cell_shift`) have numbers that all
//! pairs share.

use nalgebra::Vector3;
use pulp::Simd;
use pulp::bytemuck::{cast_slice, cast_slice_mut};

use super::axis_turn::{Angles, Lanes, OfFamilies, QuarterTurn, Turning, multiples, of_lanes};
use super::modes::{FAMILIES, Modes};

/// Orders of a source and of a target.
pub(super) type PairOrders = [usize; 2];

/// Number of [`OfFamilies`] of an expansion up to an order; that of degree `l` and azimuthal number
/// `m` is `l^2 - 1 + l + m`.
pub(super) fn harmonics(order: usize) -> usize {
    order * (order + 2)
}

/// Highest azimuthal number of a degree.
pub(super) fn highest(l: usize, regular: usize) -> usize {
    if l <= regular { l } else { l.min(1) }
}

/// Highest azimuthal number of a coupling.
pub(super) fn last(orders: PairOrders, regular: usize) -> usize {
    orders[0].min(orders[1]).min(regular.max(1))
}

/// How coefficients are turned onto lines of centres.
#[derive(Clone, Copy)]
pub(super) struct Turns<'a> {
    pub quarter: &'a QuarterTurn,
    /// Multiple of `W` that joins `V` onto the line, and of `V` that joins `W` off it, by degree.
    pub v_of_w: &'a [f64],
}

/// The line of centres of two spheres.
pub(super) struct Line {
    /// Direction from the source to the target.
    angles: Angles,
    /// Radii of the source and of the target over the distance.
    ratios: [f64; 2],
}

impl Line {
    /// From the centre of a cell to that of a part of it, with the radii of both; the ratios are
    /// those of the distance and of the radius of the part to the radius of the cell.
    pub fn within([cell, part]: [f64; 2], offset: &Vector3<f64>) -> Self {
        let distance = offset.norm();
        let along_z = Vector3::z();
        Self {
            angles: Angles::new(if distance > 0.0 { offset } else { &along_z }),
            ratios: [distance / cell, part / cell],
        }
    }

    pub fn new(radii: [f64; 2], offset: &Vector3<f64>) -> Self {
        Self {
            angles: Angles::new(offset),
            ratios: radii.map(|radius| radius / offset.norm()),
        }
    }

    pub fn angles(&self) -> &Angles {
        &self.angles
    }

    pub fn ratios(&self) -> [f64; 2] {
        self.ratios
    }
}

/// One pair of a product.
pub(super) struct Pair<'a> {
    pub line: &'a Line,
    /// Modes above these orders are left out, at both ends.
    pub orders: PairOrders,
    /// Whether an end has all families of the highest degrees.
    pub is_complete: [bool; 2],
    /// Places of the source and of the target among the coefficients that are multiplied.
    pub given: [usize; 2],
    /// The same among the products.
    pub found: [usize; 2],
}

/// Coefficients of both symmetry classes.
pub(super) type Classes<S> = [Lanes<S>; 2];

/// Coefficients on the way through the lines of centres.
pub(super) struct Workspace<S: Simd> {
    /// At one end, by degree and azimuthal number.
    pub turned: Vec<Lanes<S>>,
    /// Along the line, by azimuthal number and degree.
    pub given: [Vec<Classes<S>>; 2],
    pub found: [Vec<Classes<S>>; 2],
    /// Radii over the distance to the powers of -1/2 and so on.
    pub powers: [Vec<S::f64s>; 2],
    /// One degree along the line.
    pub degree: Vec<Lanes<S>>,
    turning: Turning<S>,
}

impl<S: Simd> Default for Workspace<S> {
    fn default() -> Self {
        Self {
            turned: Vec::new(),
            given: Default::default(),
            found: Default::default(),
            powers: Default::default(),
            degree: Vec::new(),
            turning: Turning::default(),
        }
    }
}

impl<S: Simd> Workspace<S> {
    /// Makes room for some pairs with degrees up to `top`.
    #[inline(always)]
    pub fn begin(&mut self, simd: S, pairs: &[Pair], top: usize) {
        let angles = |lane: usize| &of_lane(pairs, lane).angles;
        multiples(simd, angles, top, &mut self.turning.multiples);
        (self.degree).resize(2 * top + 1, [simd.splat_f64s(0.0); 3]);
    }

    /// Makes room for `size` coefficients of one end; what is read of these is written before.
    #[inline(always)]
    pub fn begin_end(&mut self, simd: S, end: usize, size: usize) {
        let zero = simd.splat_f64s(0.0);
        self.given[end].resize(size, [[zero; 3]; 2]);
        self.found[end].resize(size, [[zero; 3]; 2]);
    }
}

/// The highest orders of pairs; none without pairs.
#[inline(always)]
pub(super) fn highest_orders(pairs: &[Pair]) -> Option<PairOrders> {
    let highest = |end: usize| pairs.iter().map(|pair| pair.orders[end]).max();
    Some([highest(0)?, highest(1)?])
}

/// The line of a lane; one without a pair repeats the last one, with coefficients of zero.
#[inline(always)]
fn of_lane<'a>(pairs: &[Pair<'a>], lane: usize) -> &'a Line {
    pairs[lane.min(pairs.len() - 1)].line
}

/// The ratios of the radius of an end.
#[inline(always)]
pub(super) fn ratios<S: Simd>(simd: S, pairs: &[Pair], end: usize) -> S::f64s {
    of_lanes(simd, |lane| of_lane(pairs, lane).ratios[end])
}

/// The places of degree `l` among all harmonics.
#[inline(always)]
pub(super) fn of_degree(l: usize) -> std::ops::Range<usize> {
    l * l - 1..l * l + 2 * l
}

impl Turns<'_> {
    /// Coefficients of one end along the line, times powers of the distance.
    #[inline(always)]
    pub fn onto_line<S: Simd>(
        &self,
        simd: S,
        (end, top): (usize, usize),
        (regular, last): (usize, usize),
        work: &mut Workspace<S>,
    ) {
        for l in 1..=top {
            let highest = highest(l, regular).min(last);
            let degree = &mut work.degree[..2 * l + 1];
            let turned = &work.turned[of_degree(l)];
            (self.quarter).onto_line(simd, (l, highest), turned, degree, &mut work.turning);
            let powers = &work.powers[end][l..l + 3];
            let v_of_w = simd.splat_f64s(self.v_of_w[l]);
            for m in 0..=highest {
                let cosines = scaled(simd, degree[l + m], v_of_w, powers);
                let sines = scaled(simd, degree[l - m], v_of_w, powers);
                // the azimuthal number zero has the first class alone
                work.given[end][m * top + l - 1] = [
                    [cosines[0], sines[1], cosines[2]],
                    [sines[0], simd.neg_f64s(cosines[1]), sines[2]],
                ];
            }
        }
    }

    /// What was found along the line, times powers of the distance, as coefficients of one end.
    #[inline(always)]
    pub fn off_line<S: Simd>(
        &self,
        simd: S,
        (end, top): (usize, usize),
        (regular, last): (usize, usize),
        work: &mut Workspace<S>,
    ) {
        work.turned
            .resize(harmonics(top), [simd.splat_f64s(0.0); 3]);
        for l in 1..=top {
            let highest = highest(l, regular).min(last);
            let powers = &work.powers[end][l..l + 3];
            let v_of_w = simd.splat_f64s(self.v_of_w[l]);
            let degree = &mut work.degree[..2 * l + 1];
            for m in 0..=highest {
                let [first, second] = work.found[end][m * top + l - 1];
                let first = with_v_of_w(simd, first, v_of_w, powers);
                let second = with_v_of_w(simd, second, v_of_w, powers);
                // the azimuthal number zero has one coefficient, of the first class
                degree[l - m] = [second[0], first[1], second[2]];
                degree[l + m] = match m {
                    0 => first,
                    _ => [first[0], simd.neg_f64s(second[1]), first[2]],
                };
            }
            let turned = &mut work.turned[of_degree(l)];
            (self.quarter).off_line(simd, (l, highest), degree, turned, &mut work.turning);
        }
    }
}

/// Powers of the ratios of an end with the exponents `-1/2 + k`.
#[inline(always)]
pub(super) fn half_powers<S: Simd>(
    simd: S,
    (pairs, end): (&[Pair], usize),
    count: usize,
    all: &mut Vec<S::f64s>,
) {
    let ratio = ratios(simd, pairs, end);
    let first = simd.div_f64s(simd.splat_f64s(1.0), simd.sqrt_f64s(ratio));
    powers(simd, (first, ratio), count, all);
}

/// The first power, and its products with those of a ratio.
#[inline(always)]
pub(super) fn powers<S: Simd>(
    simd: S,
    (first, ratio): (S::f64s, S::f64s),
    count: usize,
    powers: &mut Vec<S::f64s>,
) {
    let mut power = first;
    powers.clear();
    for _ in 0..count {
        powers.push(power);
        power = simd.mul_f64s(power, ratio);
    }
}

/// Coefficients with the multiple of `W` that joins `V`, times powers of the distance.
// Vector instructions in closures would be calls: only functions that are always inlined have them.
#[inline(always)]
fn scaled<S: Simd>(simd: S, [w, x, v]: Lanes<S>, v_of_w: S::f64s, powers: &[S::f64s]) -> Lanes<S> {
    let v = simd.mul_add_f64s(v_of_w, w, v);
    [
        simd.mul_f64s(w, powers[0]),
        simd.mul_f64s(x, powers[1]),
        simd.mul_f64s(v, powers[2]),
    ]
}

/// The transpose of [`scaled`].
#[inline(always)]
fn with_v_of_w<S: Simd>(
    simd: S,
    [w, x, v]: Lanes<S>,
    v_of_w: S::f64s,
    powers: &[S::f64s],
) -> Lanes<S> {
    let v = simd.mul_f64s(v, powers[2]);
    [
        simd.mul_add_f64s(w, powers[0], simd.mul_f64s(v_of_w, v)),
        simd.mul_f64s(x, powers[1]),
        v,
    ]
}

/// The families of a degree that an end has.
#[inline(always)]
fn families_of(pair: &Pair, end: usize, l: usize) -> [bool; 3] {
    let modes = Modes {
        order: pair.orders[end],
    };
    FAMILIES.map(|family| pair.is_complete[end] || modes.contains(family, l))
}

/// Coefficients of one end of some pairs in lanes, up to the order `top`; zero above those of a
/// pair.
#[inline(always)]
pub(super) fn gather<S: Simd>(
    simd: S,
    (pairs, end, top): (&[Pair], usize, usize),
    x: &[OfFamilies],
    lanes: &mut Vec<Lanes<S>>,
) {
    lanes.clear();
    lanes.resize(harmonics(top), [simd.splat_f64s(0.0); 3]);
    let width = S::F64_LANES;
    let numbers: &mut [f64] = cast_slice_mut(lanes);
    for (lane, pair) in pairs.iter().enumerate() {
        let x = &x[pair.given[end]..][..harmonics(pair.orders[end])];
        for l in 1..=pair.orders[end] {
            let is_used = families_of(pair, end, l);
            let numbers = numbers[3 * width * of_degree(l).start..].chunks_exact_mut(3 * width);
            for (numbers, x) in numbers.zip(&x[of_degree(l)]) {
                for k in 0..3 {
                    numbers[width * k + lane] = if is_used[k] { x[k] } else { 0.0 };
                }
            }
        }
    }
}

/// Adds coefficients in lanes to those of one end of the pairs.
#[inline(always)]
pub(super) fn scatter<S: Simd>(
    (pairs, end): (&[Pair], usize),
    lanes: &[Lanes<S>],
    y: &mut [OfFamilies],
) {
    let width = S::F64_LANES;
    let numbers: &[f64] = cast_slice(lanes);
    for (lane, pair) in pairs.iter().enumerate() {
        let y = &mut y[pair.found[end]..][..harmonics(pair.orders[end])];
        for l in 1..=pair.orders[end] {
            let is_used = families_of(pair, end, l);
            let numbers = numbers[3 * width * of_degree(l).start..].chunks_exact(3 * width);
            for (numbers, y) in numbers.zip(&mut y[of_degree(l)]) {
                for k in 0..3 {
                    y[k] += if is_used[k] {
                        numbers[width * k + lane]
                    } else {
                        0.0
                    };
                }
            }
        }
    }
}
