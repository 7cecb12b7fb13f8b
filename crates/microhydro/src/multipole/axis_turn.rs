//! Rotations onto lines of centres by matrices that all pairs share.
//!
//! With the polar angles `θ` and `φ` of a direction, `R_y(-θ) R_z(-φ)` takes it to the z axis, and
//! `R_y(-θ) = Q^T R_z(-θ) Q` with the quarter turn `Q` that takes y to z. Rotations about z turn
//! pairs of coefficients, and the matrix of `Q` has one block for each parity along the axes: a
//! quarter of its entries (Pinchon & Hoggan 2007 use the same factors). A pair stores two angles
//! instead of `O(L^3)` numbers, which products with one vector would read from memory each time.

use nalgebra::{DMatrix, Vector3};
use pulp::Simd;
use pulp::bytemuck::cast_slice_mut;

/// Coefficients of one `Y_lm` for the families, which rotations treat alike.
pub(super) type OfFamilies = [f64; 3];

/// The same of several pairs, one in each lane of a vector register.
pub(super) type Lanes<S> = [<S as Simd>::f64s; 3];

/// A number of each lane.
#[inline(always)]
pub(super) fn of_lanes<S: Simd>(simd: S, number: impl Fn(usize) -> f64) -> S::f64s {
    let mut all = [simd.splat_f64s(0.0)];
    let lanes: &mut [f64] = cast_slice_mut(&mut all);
    for (lane, entry) in lanes.iter_mut().enumerate() {
        *entry = number(lane);
    }
    all[0]
}

/// Cosines and sines of the polar angles of a direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Angles {
    polar: [f64; 2],
    azimuth: [f64; 2],
}

impl Angles {
    pub fn new(direction: &Vector3<f64>) -> Self {
        let across = direction.x.hypot(direction.y);
        let distance = across.hypot(direction.z);
        Self {
            polar: [direction.z / distance, across / distance],
            azimuth: match across > 0.0 {
                true => [direction.x / across, direction.y / across],
                false => [1.0, 0.0],
            },
        }
    }
}

/// Cosine and sine of a multiple of both angles.
type Multiple<S> = [[<S as Simd>::f64s; 2]; 2];

/// Cosines and sines of the multiples of both angles of some pairs, from zero up to `top`.
#[inline(always)]
pub(super) fn multiples<'a, S: Simd>(
    simd: S,
    of_lane: impl Fn(usize) -> &'a Angles,
    top: usize,
    all: &mut Vec<Multiple<S>>,
) {
    let polar = [
        of_lanes(simd, |lane| of_lane(lane).polar[0]),
        of_lanes(simd, |lane| of_lane(lane).polar[1]),
    ];
    let azimuth = [
        of_lanes(simd, |lane| of_lane(lane).azimuth[0]),
        of_lanes(simd, |lane| of_lane(lane).azimuth[1]),
    ];
    all.clear();
    let mut last = [[simd.splat_f64s(1.0), simd.splat_f64s(0.0)]; 2];
    for _ in 0..=top {
        all.push(last);
        last[0] = rotated(simd, last[0], polar);
        last[1] = rotated(simd, last[1], azimuth);
    }
}

/// A vector of the plane `[x, y]` turned by an angle with this cosine and sine.
#[inline(always)]
fn rotated<S: Simd>(simd: S, [x, y]: [S::f64s; 2], [c, s]: [S::f64s; 2]) -> [S::f64s; 2] {
    let (cx, sx) = (simd.mul_f64s(c, x), simd.mul_f64s(s, x));
    [
        simd.negate_mul_add_f64s(s, y, cx),
        simd.mul_add_f64s(c, y, sx),
    ]
}

/// The four classes of the harmonics of a degree: cosine or sine, even or odd azimuthal number.
const CLASSES: usize = 4;

/// Place of the first harmonic of a class in `-l ..= l`, the step to the next one, and the number
/// of those up to the azimuthal number `highest`.
#[inline(always)]
fn class(k: usize, l: usize, highest: usize) -> (usize, isize, usize) {
    match k {
        0 => (l, 2, highest / 2 + 1),
        1 => (l + 1, 2, highest.div_ceil(2)),
        // the azimuthal number zero has no sine
        2 => (l.wrapping_sub(2), -2, highest / 2),
        _ => (l.wrapping_sub(1), -2, highest.div_ceil(2)),
    }
}

/// Class that the quarter turn makes of a class.
///
/// Parities along x, y, z become those along x, z, y; that along z is `(-1)^l` times both others.
#[inline(always)]
fn turned(k: usize, l: usize) -> usize {
    [[0, 2, 1, 3], [3, 1, 2, 0]][l % 2][k]
}

/// Place of a harmonic of a class.
#[inline(always)]
fn place((first, step, _): (usize, isize, usize), number: usize) -> usize {
    first.wrapping_add_signed(step * number as isize)
}

/// Matrices of one degree, by columns, for each class of what is turned.
type Blocks = [Vec<f64>; CLASSES];

/// Matrices of the quarter turn that takes y to z, and of its inverse, of all degrees from one.
pub(super) struct QuarterTurn {
    onto: Vec<Blocks>,
    back: Vec<Blocks>,
}

/// Coefficients of one degree between two turns, and the multiples of the angles.
pub(super) struct Turning<S: Simd> {
    pub multiples: Vec<Multiple<S>>,
    first: Vec<Lanes<S>>,
    second: Vec<Lanes<S>>,
}

impl<S: Simd> Default for Turning<S> {
    fn default() -> Self {
        Self {
            multiples: Vec::new(),
            first: Vec::new(),
            second: Vec::new(),
        }
    }
}

impl<S: Simd> Turning<S> {
    #[inline(always)]
    fn of_degree(&mut self, simd: S, l: usize) -> (&[Multiple<S>], [&mut [Lanes<S>]; 2]) {
        let none = [simd.splat_f64s(0.0); 3];
        let lists = [&mut self.first, &mut self.second].map(|list| {
            list.resize(2 * l + 1, none);
            &mut list[..]
        });
        (&self.multiples, lists)
    }
}

impl QuarterTurn {
    /// Matrices of degrees `1 ..= top`. Cost: `O(top^3)`.
    pub fn new(top: usize) -> Self {
        let blocks = |l: usize, entry: &dyn Fn(usize, usize) -> f64| -> Blocks {
            std::array::from_fn(|k| {
                let (from, to) = (class(k, l, l), class(turned(k, l), l, l));
                let entry = |n| entry(place(to, n % to.2), place(from, n / to.2));
                (0..to.2 * from.2).map(entry).collect()
            })
        };
        let (mut onto, mut back) = (Vec::with_capacity(top), Vec::with_capacity(top));
        let mut last = DMatrix::identity(1, 1);
        for l in 1..=top {
            last = next_right_angle(l, &last);
            let matrix = about_x(l, &last);
            onto.push(blocks(l, &|row, column| matrix[(row, column)]));
            back.push(blocks(l, &|row, column| matrix[(column, row)]));
        }
        Self { onto, back }
    }

    /// Turns the coefficients `x` of degree `l` such that the directions become the z axis, and
    /// writes those up to the azimuthal number `highest` to `y`.
    #[inline(always)]
    pub fn onto_line<S: Simd>(
        &self,
        simd: S,
        (l, highest): (usize, usize),
        x: &[Lanes<S>],
        y: &mut [Lanes<S>],
        turning: &mut Turning<S>,
    ) {
        let (multiples, [first, second]) = turning.of_degree(simd, l);
        about_z::<S, true>(simd, x, (multiples, 1), first);
        turn(simd, &self.onto[l - 1], l, (l, l), first, second);
        about_z::<S, true>(simd, second, (multiples, 0), first);
        turn(simd, &self.back[l - 1], l, (l, highest), first, y);
    }

    /// Turns the coefficients `x` of degree `l` up to the azimuthal number `highest` such that the
    /// z axis takes the directions, into `y`.
    #[inline(always)]
    pub fn off_line<S: Simd>(
        &self,
        simd: S,
        (l, highest): (usize, usize),
        x: &[Lanes<S>],
        y: &mut [Lanes<S>],
        turning: &mut Turning<S>,
    ) {
        let (multiples, [first, second]) = turning.of_degree(simd, l);
        turn(simd, &self.onto[l - 1], l, (highest, l), x, first);
        about_z::<S, false>(simd, first, (multiples, 0), second);
        turn(simd, &self.back[l - 1], l, (l, l), second, first);
        about_z::<S, false>(simd, first, (multiples, 1), y);
    }
}

/// The matrix `d^l_mn(π/2)` of degree `l` for `m, n >= 0` from that of `l - 1`, which are the turns
/// by a right angle about y but for signs.
///
/// Trapani & Navaza 2006, Acta Cryst. A 62, 262: rows fall from `n = l` to `n = m`, which is stable
/// at all degrees; the other entries follow from symmetry. The recursion of [`Rotation`] loses a
/// digit every twenty degrees.
///
/// [`Rotation`]: super::rotation::Rotation
fn next_right_angle(l: usize, last: &DMatrix<f64>) -> DMatrix<f64> {
    let mut d = DMatrix::zeros(l + 1, l + 1);
    let lf = l as f64;
    for m in 0..=l {
        let mf = m as f64;
        d[(m, l)] = match m {
            0 => -((2.0 * lf - 1.0) / (2.0 * lf)).sqrt() * last[(0, l - 1)],
            _ => {
                let square = lf * (2.0 * lf - 1.0) / (2.0 * (lf + mf) * (lf + mf - 1.0));
                square.sqrt() * last[(m - 1, l - 1)]
            }
        };
        for n in (m..l).rev() {
            let nf = n as f64;
            let below = (lf - nf) * (lf + nf + 1.0);
            let mut entry = 2.0 * mf / below.sqrt() * d[(m, n + 1)];
            if n + 2 <= l {
                let above = (lf - nf - 1.0) * (lf + nf + 2.0);
                entry -= (above / below).sqrt() * d[(m, n + 2)];
            }
            d[(m, n)] = entry;
        }
    }
    for (m, n) in (0..=l).flat_map(|m| (0..m).map(move |n| (m, n))) {
        d[(m, n)] = if (m - n) % 2 == 0 {
            d[(n, m)]
        } else {
            -d[(n, m)]
        };
    }
    d
}

/// The quarter turn about x, `R_z(-π/2) R_y(π/2) R_z(π/2)`, for real harmonics `-l ..= l`.
fn about_x(l: usize, right_angle: &DMatrix<f64>) -> DMatrix<f64> {
    // Cosines and sines with the parity along y: the sums of the entries for m and -m.
    let about_y = |m: isize, n: isize| -> f64 {
        let (a, b) = (m.unsigned_abs(), n.unsigned_abs());
        let is_of_cosines = (l + a + b).is_multiple_of(2);
        let is_of_sines = m < 0;
        if (n < 0) != is_of_sines || is_of_sines == is_of_cosines {
            return 0.0;
        }
        // harmonics of m = 0 have no partner
        let partners = [a, b].iter().filter(|m| **m > 0).count();
        [1.0, 2.0_f64.sqrt(), 2.0][partners] * right_angle[(a, b)]
    };
    // What the turn about z by a right angle makes of a harmonic: another one and its sign.
    let about_z = |m: isize, sense: f64| -> (isize, f64) {
        let sine = sense * [0.0, 1.0, 0.0, -1.0][m.unsigned_abs() % 4];
        match m.unsigned_abs() % 4 {
            0 => (m, 1.0),
            2 => (m, -1.0),
            _ => (-m, if m < 0 { -sine } else { sine }),
        }
    };
    let top = l as isize;
    let place = |m: isize| (m + top) as usize;
    let mut matrix = DMatrix::zeros(2 * l + 1, 2 * l + 1);
    for column in -top..=top {
        let (from, of_column) = about_z(column, 1.0);
        for row in -top..=top {
            let (to, of_row) = about_z(row, -1.0);
            matrix[(place(to), place(column))] = of_row * of_column * about_y(row, from);
        }
    }
    matrix
}

/// Turns `x` about z by angles of which these are the multiples, or back, into `y`.
#[inline(always)]
fn about_z<S: Simd, const BACK: bool>(
    simd: S,
    x: &[Lanes<S>],
    (multiples, angle): (&[Multiple<S>], usize),
    y: &mut [Lanes<S>],
) {
    let l = x.len() / 2;
    y[l] = x[l];
    for (m, multiple) in multiples[..l + 1].iter().enumerate().skip(1) {
        let [c, s] = multiple[angle];
        let s = if BACK { simd.neg_f64s(s) } else { s };
        for k in 0..3 {
            [y[l + m][k], y[l - m][k]] = rotated(simd, [x[l + m][k], x[l - m][k]], [c, s]);
        }
    }
}

/// Rows of a block that are computed together: their sums fill twelve of sixteen registers.
const TOGETHER: usize = 4;

/// Turns `x` of degree `l`, with azimuthal numbers up to the highest ones of `x` and `y`.
#[inline(always)]
fn turn<S: Simd>(
    simd: S,
    blocks: &Blocks,
    l: usize,
    highest: (usize, usize),
    x: &[Lanes<S>],
    y: &mut [Lanes<S>],
) {
    for (k, block) in blocks.iter().enumerate() {
        let (from, to) = (class(k, l, highest.0), class(turned(k, l), l, highest.1));
        let height = class(turned(k, l), l, l).2;
        let mut row = 0;
        while row + TOGETHER <= to.2 {
            rows::<S, TOGETHER>(simd, block, (row, height), (from, to), x, y);
            row += TOGETHER;
        }
        match to.2 - row {
            1 => rows::<S, 1>(simd, block, (row, height), (from, to), x, y),
            2 => rows::<S, 2>(simd, block, (row, height), (from, to), x, y),
            3 => rows::<S, 3>(simd, block, (row, height), (from, to), x, y),
            _ => (),
        }
    }
}

/// Some rows of a block.
#[inline(always)]
fn rows<S: Simd, const N: usize>(
    simd: S,
    block: &[f64],
    (row, height): (usize, usize),
    (from, to): ((usize, isize, usize), (usize, isize, usize)),
    x: &[Lanes<S>],
    y: &mut [Lanes<S>],
) {
    let mut sums = [[simd.splat_f64s(0.0); 3]; N];
    for (column, entries) in block.chunks_exact(height).take(from.2).enumerate() {
        let x = x[place(from, column)];
        for (sum, entry) in sums.iter_mut().zip(&entries[row..row + N]) {
            let entry = simd.splat_f64s(*entry);
            for k in 0..3 {
                sum[k] = simd.mul_add_f64s(entry, x[k], sum[k]);
            }
        }
    }
    for (number, sum) in sums.iter().enumerate() {
        y[place(to, row + number)] = *sum;
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{DVector, UnitQuaternion};
    use pulp::bytemuck::cast_slice;
    use pulp::{Arch, Scalar, WithSimd};

    use super::super::rotation::Rotation;
    use super::*;

    /// The recursion of general rotations has an error of 3e-3 at degree 150.
    #[test]
    fn quarter_turns_of_high_degrees_are_orthogonal() {
        let mut last = DMatrix::identity(1, 1);
        for l in 1..=250 {
            last = next_right_angle(l, &last);
            if [1, 2, 60, 250].contains(&l) {
                let matrix = about_x(l, &last);
                let identity = DMatrix::identity(2 * l + 1, 2 * l + 1);
                let error = (matrix.tr_mul(&matrix) - identity).amax();
                // rounding of each step of the recursion
                assert!(
                    error < 4.0 * (l as f64 + 1.0) * f64::EPSILON,
                    "{l}: {error:e}"
                );
            }
        }
    }

    /// Turns onto lines and back, for as many directions as there are lanes.
    struct Turns<'a>(&'a QuarterTurn, &'a [Vector3<f64>], (usize, usize));

    /// The harmonic `n` of a degree.
    fn given(n: usize) -> OfFamilies {
        [n as f64, (n as f64).cos(), 1.0 / (1.0 + n as f64)]
    }

    impl WithSimd for Turns<'_> {
        /// For each direction and family, the coefficients on the line and those turned back.
        type Output = Vec<[[DVector<f64>; 2]; 3]>;

        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let Self(quarter, directions, (l, highest)) = self;
            let angles: Vec<Angles> = directions.iter().map(Angles::new).collect();
            let mut all = Vec::new();
            for angles in angles.chunks(S::F64_LANES) {
                let mut turning = Turning::<S>::default();
                let of_lane = |lane: usize| &angles[lane.min(angles.len() - 1)];
                multiples(simd, of_lane, l, &mut turning.multiples);
                let x: Vec<Lanes<S>> = (0..2 * l + 1)
                    .map(|n| given(n).map(|number| simd.splat_f64s(number)))
                    .collect();
                let none = vec![[simd.splat_f64s(0.0); 3]; 2 * l + 1];
                let (mut line, mut back) = (none.clone(), none);
                quarter.onto_line(simd, (l, highest), &x, &mut line, &mut turning);
                quarter.off_line(simd, (l, highest), &line, &mut back, &mut turning);
                let of = |list: &[Lanes<S>], k: usize, lane: usize| {
                    let numbers: &[f64] = cast_slice(list);
                    let of_family = numbers.iter().skip(k * S::F64_LANES + lane);
                    let own = of_family.step_by(3 * S::F64_LANES).copied();
                    DVector::from_iterator(2 * l + 1, own)
                };
                let of_pair = |lane| [0, 1, 2].map(|k| [of(&line, k, lane), of(&back, k, lane)]);
                all.extend((0..angles.len()).map(of_pair));
            }
            all
        }
    }

    #[test]
    fn turns_are_rotations_onto_the_direction_and_back() {
        let top = 12;
        let quarter = QuarterTurn::new(top);
        let directions = [
            Vector3::new(0.3, -1.2, 0.7),
            Vector3::new(-2.0, 0.1, -0.4),
            Vector3::z(),
            -Vector3::z(),
            Vector3::new(1e-9, 0.0, -1.0),
        ];
        let rotations = directions.map(|direction: Vector3<f64>| {
            let (x, y) = (direction.x, direction.y);
            let azimuth = if x.hypot(y) > 0.0 { y.atan2(x) } else { 0.0 };
            let polar = x.hypot(y).atan2(direction.z);
            let own = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -polar)
                * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -azimuth);
            let turned = own * direction - Vector3::z() * direction.norm();
            assert!(turned.norm() < 1e-14 * direction.norm());
            Rotation::new(&own, top)
        });
        for (l, highest) in (1..=top).flat_map(|l| [(l, l), (l, 1)]) {
            for found in [
                Arch::new().dispatch(Turns(&quarter, &directions, (l, highest))),
                Turns(&quarter, &directions, (l, highest)).with_simd(Scalar::new()),
            ] {
                assert_eq!(found.len(), directions.len());
                for (rotation, found) in rotations.iter().zip(&found) {
                    let matrix = rotation.degree(l);
                    for (k, [line, back]) in found.iter().enumerate() {
                        let x = DVector::from_fn(2 * l + 1, |n, _| given(n)[k]);
                        let mut expected = matrix * x;
                        for m in highest + 1..=l {
                            expected[l - m] = 0.0;
                            expected[l + m] = 0.0;
                        }
                        // sums of 25 numbers up to 25
                        assert!((line - &expected).amax() < 1e-12, "{l} {highest}");
                        let expected = matrix.tr_mul(&expected);
                        assert!((back - expected).amax() < 1e-12, "{l} {highest}");
                    }
                }
            }
        }
    }
}
