//! Rotations onto lines of centres by matrices that all pairs share.
//!
//! With the polar angles `θ` and `φ` of a direction, `R_y(-θ) R_z(-φ)` takes it to the z axis, and
//! `R_y(-θ) = Q^T R_z(-θ) Q` with the quarter turn `Q` that takes y to z. Rotations about z turn
//! pairs of coefficients, and the matrix of `Q` has one block for each parity along the axes: a
//! quarter of its entries (Pinchon & Hoggan 2007 use the same factors). A pair stores two angles
//! instead of `O(L^3)` numbers, which products with one vector would read from memory each time.

use std::f64::consts::FRAC_PI_2;

use nalgebra::{UnitQuaternion, Vector3};

use super::rotation::Rotation;

/// Coefficients of one `Y_lm` for the families, and a zero that fills a vector register.
///
/// Rotations are the same for all families.
pub(super) type OfFamilies = [f64; 4];

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

    /// Cosines and sines of the multiples of both angles, from zero on.
    pub fn multiples(&self, top: usize, all: &mut Vec<[[f64; 2]; 2]>) {
        all.clear();
        let mut last = [[1.0, 0.0]; 2];
        for _ in 0..=top {
            all.push(last);
            for ([cosine, sine], step) in last.iter_mut().zip([self.polar, self.azimuth]) {
                let (c, s) = (*cosine, *sine);
                *cosine = c * step[0] - s * step[1];
                *sine = s * step[0] + c * step[1];
            }
        }
    }
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

/// Coefficients of one degree between two turns.
#[derive(Default)]
pub(super) struct Turning {
    first: Vec<OfFamilies>,
    second: Vec<OfFamilies>,
}

impl Turning {
    #[inline(always)]
    fn resize(&mut self, l: usize) -> [&mut [OfFamilies]; 2] {
        [&mut self.first, &mut self.second].map(|list| {
            list.resize(2 * l + 1, [0.0; 4]);
            &mut list[..]
        })
    }
}

impl QuarterTurn {
    /// Matrices of degrees `1 ..= top`. Cost: `O(top^3)`.
    pub fn new(top: usize) -> Self {
        let quarter = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), FRAC_PI_2);
        let degrees = |turn: &UnitQuaternion<f64>| {
            let rotation = Rotation::new(turn, top);
            let block = |l: usize, k: usize| -> Vec<f64> {
                let (from, to) = (class(k, l, l), class(turned(k, l), l, l));
                let entry = |n| rotation.degree(l)[(place(to, n % to.2), place(from, n / to.2))];
                (0..to.2 * from.2).map(entry).collect()
            };
            (1..=top)
                .map(|l| std::array::from_fn(|k| block(l, k)))
                .collect()
        };
        Self {
            onto: degrees(&quarter),
            back: degrees(&quarter.inverse()),
        }
    }

    /// Turns the coefficients `x` of degree `l` such that the direction of the angles becomes the z
    /// axis, and writes those up to the azimuthal number `highest` to `y`.
    #[inline(always)]
    pub fn onto_line(
        &self,
        (l, highest): (usize, usize),
        multiples: &[[[f64; 2]; 2]],
        x: &[OfFamilies],
        y: &mut [OfFamilies],
        turning: &mut Turning,
    ) {
        let [first, second] = turning.resize(l);
        let back = |angle: usize| {
            multiples
                .iter()
                .map(move |of| [of[angle][0], -of[angle][1]])
        };
        about_z(x, back(1), first, |y, x| *y = x);
        turn(&self.onto[l - 1], l, (l, l), first, second);
        about_z(second, back(0), first, |y, x| *y = x);
        turn(&self.back[l - 1], l, (l, highest), first, y);
    }

    /// Adds the coefficients `x` of degree `l` up to the azimuthal number `highest`, turned such
    /// that the z axis takes the direction of the angles.
    #[inline(always)]
    pub fn add_from_line(
        &self,
        (l, highest): (usize, usize),
        multiples: &[[[f64; 2]; 2]],
        x: &[OfFamilies],
        y: &mut [OfFamilies],
        turning: &mut Turning,
    ) {
        let [first, second] = turning.resize(l);
        turn(&self.onto[l - 1], l, (highest, l), x, first);
        let forth = |angle: usize| multiples.iter().map(move |of| of[angle]);
        about_z(first, forth(0), second, |y, x| *y = x);
        turn(&self.back[l - 1], l, (l, l), second, first);
        about_z(first, forth(1), y, |y, x| add_multiple(y, 1.0, &x));
    }
}

/// Turns `x` about z by an angle whose multiples have these cosines and sines, into `y`.
#[inline(always)]
fn about_z(
    x: &[OfFamilies],
    multiples: impl Iterator<Item = [f64; 2]>,
    y: &mut [OfFamilies],
    enter: impl Fn(&mut OfFamilies, OfFamilies),
) {
    let l = x.len() / 2;
    let (x_sines, x_cosines) = x.split_at(l);
    let (y_sines, y_cosines) = y.split_at_mut(l);
    enter(&mut y_cosines[0], x_cosines[0]);
    let from = x_sines.iter().rev().zip(&x_cosines[1..]);
    let to = y_sines.iter_mut().rev().zip(&mut y_cosines[1..]);
    for ((from, to), [c, s]) in from.zip(to).zip(multiples.skip(1)) {
        let (sine, cosine) = (*from.0, *from.1);
        enter(to.1, std::array::from_fn(|k| c * cosine[k] - s * sine[k]));
        enter(to.0, std::array::from_fn(|k| s * cosine[k] + c * sine[k]));
    }
}

/// Rows of a block that are computed together.
const TOGETHER: usize = 4;

/// Turns `x` of degree `l`, with azimuthal numbers up to the highest ones of `x` and `y`.
#[inline(always)]
fn turn(
    blocks: &Blocks,
    l: usize,
    highest: (usize, usize),
    x: &[OfFamilies],
    y: &mut [OfFamilies],
) {
    for (k, block) in blocks.iter().enumerate() {
        let (from, to) = (class(k, l, highest.0), class(turned(k, l), l, highest.1));
        let height = class(turned(k, l), l, l).2;
        let mut row = 0;
        while row + TOGETHER <= to.2 {
            rows::<TOGETHER>(block, (row, height), (from, to), x, y);
            row += TOGETHER;
        }
        match to.2 - row {
            1 => rows::<1>(block, (row, height), (from, to), x, y),
            2 => rows::<2>(block, (row, height), (from, to), x, y),
            3 => rows::<3>(block, (row, height), (from, to), x, y),
            _ => (),
        }
    }
}

/// Some rows of a block.
#[inline(always)]
fn rows<const N: usize>(
    block: &[f64],
    (row, height): (usize, usize),
    (from, to): ((usize, isize, usize), (usize, isize, usize)),
    x: &[OfFamilies],
    y: &mut [OfFamilies],
) {
    let mut sums = [[0.0; 4]; N];
    for (column, entries) in block.chunks_exact(height).take(from.2).enumerate() {
        let x = &x[place(from, column)];
        for (sum, entry) in sums.iter_mut().zip(&entries[row..row + N]) {
            add_multiple(sum, *entry, x);
        }
    }
    for (number, sum) in sums.iter().enumerate() {
        y[place(to, row + number)] = *sum;
    }
}

#[inline(always)]
fn add_multiple(y: &mut OfFamilies, factor: f64, x: &OfFamilies) {
    let sum = *y;
    *y = std::array::from_fn(|k| sum[k] + factor * x[k]);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_rotations_onto_the_direction_and_back() {
        let top = 12;
        let quarter = QuarterTurn::new(top);
        let (mut multiples, mut turning) = (Vec::new(), Turning::default());
        for direction in [
            Vector3::new(0.3, -1.2, 0.7),
            Vector3::new(-2.0, 0.1, -0.4),
            Vector3::z(),
            -Vector3::z(),
            Vector3::new(1e-9, 0.0, -1.0),
        ] {
            Angles::new(&direction).multiples(top, &mut multiples);
            let (x, y) = (direction.x, direction.y);
            let azimuth = if x.hypot(y) > 0.0 { y.atan2(x) } else { 0.0 };
            let polar = x.hypot(y).atan2(direction.z);
            let own = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -polar)
                * UnitQuaternion::from_axis_angle(&Vector3::z_axis(), -azimuth);
            let turned = own * direction - Vector3::z() * direction.norm();
            assert!(turned.norm() < 1e-14 * direction.norm());
            let rotation = Rotation::new(&own, top);
            for l in 1..=top {
                let given: Vec<OfFamilies> = (0..2 * l + 1)
                    .map(|n| [n as f64, (n as f64).cos(), 1.0 / (1.0 + n as f64), 0.0])
                    .collect();
                for highest in [l, 1] {
                    let mut found = vec![[0.0; 4]; 2 * l + 1];
                    quarter.onto_line((l, highest), &multiples, &given, &mut found, &mut turning);
                    let mut back = vec![[1.0; 4]; 2 * l + 1];
                    quarter.add_from_line(
                        (l, highest),
                        &multiples,
                        &found,
                        &mut back,
                        &mut turning,
                    );
                    let matrix = rotation.degree(l);
                    for k in 0..4 {
                        let of = |x: &[OfFamilies]| {
                            nalgebra::DVector::from_iterator(x.len(), x.iter().map(|x| x[k]))
                        };
                        let mut expected = matrix * of(&given);
                        for m in highest + 1..=l {
                            expected[l - m] = 0.0;
                            expected[l + m] = 0.0;
                        }
                        // sums of 25 numbers up to 25
                        assert!((of(&found) - &expected).amax() < 1e-12, "{l} {highest}");
                        let expected = matrix.tr_mul(&expected).add_scalar(1.0);
                        assert!((of(&back) - expected).amax() < 1e-12, "{l} {highest}");
                    }
                }
            }
        }
    }
}
