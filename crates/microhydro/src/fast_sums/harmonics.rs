//! Solid harmonics, and the matrices that move expansions in them from one centre to another.
//!
//! ```text
//! R_l^m = r^l P_l^m(cos θ) exp(imφ) / (l+m)!        regular
//! I_l^m = (l-m)! P_l^m(cos θ) exp(imφ) / r^(l+1)    irregular
//! 1/|x - y| = Σ conj(R_l^m(y)) I_l^m(x)             |y| < |x|
//! ```
//!
//! (Epton & Dembart 1995). Real functions are stored as real numbers: `R_l^0`, then `√2 Re R_l^m`
//! and `√2 Im R_l^m` for `m = 1 ..= l`, so that the sum above is a product of vectors.

use std::f64::consts::SQRT_2;
use std::sync::LazyLock;

use nalgebra::{Complex, DMatrix, DVector, Vector3};

/// Highest degree of the expansions.
///
/// Errors relative to the largest velocity were 5e-8 to 6e-6 for random forces on 3000 to 30 000
/// spheres in a cube and in two clusters, and 2e-5 for equal ones in three dense clusters on a
/// line; of the degrees 10 and 8 they were 3 and 10 times as large.
pub(super) const ORDER: usize = 12;

/// Numbers of an expansion.
pub(super) const TERMS: usize = (ORDER + 1) * (ORDER + 1);

/// Degrees of moments and local expansions that are needed at an offset between the centres of two
/// cells, in their edges: of cells beside neighbours [`ORDER`], of others fewer.
///
/// The degree `l` of the flow of points at a distance `r` from the centre is like `(r/(d-r))^l`.
/// With `r` = 0.7, the root mean square errors of potentials and of their gradients, by random
/// points in one cell at random points in another one, are below a sixth of those at the smallest
/// offset, 2.
pub(super) fn degree_at(offset: [i64; 3]) -> usize {
    const RADIUS: f64 = 0.7;
    const PART: f64 = 0.03;
    let ratio = |distance: f64| RADIUS / (distance - RADIUS);
    let squared: i64 = offset.iter().map(|d| d * d).sum();
    let most = ratio(2.0).ln() * (ORDER + 1) as f64 + PART.ln();
    let needed = most / ratio((squared as f64).sqrt()).ln();
    (needed as usize).min(ORDER)
}

/// `R_l^m` for `0 <= m <= l <= order`, at the index `l (l + 1)/2 + m`.
fn solid(x: &Vector3<f64>, order: usize) -> Vec<Complex<f64>> {
    let index = |l: usize, m: usize| l * (l + 1) / 2 + m;
    // (l² - m²)^-1: divisions would take most of the time.
    static INVERSES: LazyLock<Vec<f64>> = LazyLock::new(|| {
        let all = (0..=2 * ORDER).flat_map(|l| (0..=l).map(move |m| (l * l - m * m) as f64));
        all.map(|number| 1.0 / number).collect()
    });
    let inverses = &INVERSES[..index(order + 1, 0)];
    let mut all = vec![Complex::default(); index(order + 1, 0)];
    let squared = x.norm_squared();
    let mut diagonal = Complex::new(1.0, 0.0);
    for m in 0..=order {
        if m > 0 {
            diagonal *= Complex::new(x.x, x.y) / (-2.0 * m as f64);
        }
        all[index(m, m)] = diagonal;
        for l in m + 1..=order {
            let below = match l >= m + 2 {
                true => all[index(l - 2, m)],
                false => Complex::default(),
            };
            let sum = all[index(l - 1, m)] * (x.z * (2 * l - 1) as f64) - below * squared;
            all[index(l, m)] = sum * inverses[index(l, m)];
        }
    }
    all
}

/// A value for any sign of `m`, from those for `m >= 0`: `R_l^-m = (-1)^m conj(R_l^m)`.
fn signed(values: &[Complex<f64>], l: usize, m: i64) -> Complex<f64> {
    let value = values[l * (l + 1) / 2 + m.unsigned_abs() as usize];
    match (m < 0, m % 2 == 0) {
        (false, _) => value,
        (true, true) => value.conj(),
        (true, false) => -value.conj(),
    }
}

/// The real numbers of values for `m >= 0`.
fn packed(values: &[Complex<f64>], order: usize) -> DVector<f64> {
    let mut all = Vec::with_capacity((order + 1) * (order + 1));
    for l in 0..=order {
        all.push(values[l * (l + 1) / 2].re);
        for m in 1..=l {
            let value = values[l * (l + 1) / 2 + m] * SQRT_2;
            all.extend([value.re, value.im]);
        }
    }
    DVector::from_vec(all)
}

/// Regular harmonics at `x`, as real numbers.
pub(super) fn regular(x: &Vector3<f64>) -> DVector<f64> {
    packed(&solid(x, ORDER), ORDER)
}

/// The matrix of a map of real expansions up to a degree, from its action on values for all `m`.
///
/// `map(l, m, value, (degree, order))` is the image at `(l, m)`, `m >= 0`, of the expansion
/// `value(l, m)`, of which only those of this degree and of plus or minus this order are not zero.
fn matrix(
    highest: usize,
    map: impl Fn(usize, i64, &dyn Fn(usize, i64) -> Complex<f64>, (usize, i64)) -> Complex<f64>,
) -> DMatrix<f64> {
    let mut columns = Vec::with_capacity((highest + 1).pow(2));
    for degree in 0..=highest {
        for part in 0..=2 * degree {
            let own = part.div_ceil(2);
            let unit = match (part, part % 2) {
                (0, _) => Complex::new(1.0, 0.0),
                (_, 1) => Complex::new(1.0 / SQRT_2, 0.0),
                _ => Complex::new(0.0, 1.0 / SQRT_2),
            };
            let value = |l: usize, m: i64| match l == degree && m.unsigned_abs() as usize == own {
                false => Complex::default(),
                true if m >= 0 => unit,
                true if m % 2 == 0 => unit.conj(),
                true => -unit.conj(),
            };
            let image = (0..=highest).flat_map(|l| (0..=l).map(move |m| (l, m as i64)));
            let unit = (degree, own as i64);
            let image: Vec<_> = image.map(|(l, m)| map(l, m, &value, unit)).collect();
            columns.push(packed(&image, highest));
        }
    }
    DMatrix::from_columns(&columns)
}

/// Derivatives along an axis: `∂R = D R` for the vector of regular harmonics.
///
/// `∂_z R_l^m = R_(l-1)^m`, `(∂_x ± i∂_y) R_l^m = ±R_(l-1)^(m±1)`.
pub(super) static DERIVATIVES: LazyLock<[Derivative; 3]> = LazyLock::new(|| {
    [0, 1, 2].map(|axis| {
        let dense = matrix(ORDER, |l, m, value, _| {
            let at = |m: i64| match (m.unsigned_abs() as usize) < l {
                true => value(l - 1, m),
                false => Complex::default(),
            };
            match axis {
                0 => (at(m + 1) - at(m - 1)) / 2.0,
                1 => (at(m + 1) + at(m - 1)) / Complex::new(0.0, 2.0),
                _ => at(m),
            }
        });
        let entries = (0..TERMS).flat_map(|i| (0..TERMS).map(move |j| (i, j)));
        let entries = entries.map(|(i, j)| (i, j, dense[(i, j)]));
        Derivative(entries.filter(|(.., value)| *value != 0.0).collect())
    })
});

/// The matrix of a derivative: rows, columns and values of at most two entries per row.
pub(super) struct Derivative(Vec<(usize, usize, f64)>);

impl Derivative {
    /// Adds `factor D x` to `y`: moments of dipoles.
    pub fn add(&self, factor: f64, x: &[f64], y: &mut [f64]) {
        for &(row, column, value) in &self.0 {
            y[row] += factor * value * x[column];
        }
    }

    /// Adds `factor D^T x` to `y`: the local expansion of a derivative.
    pub fn add_transposed(&self, factor: f64, x: &[f64], y: &mut [f64]) {
        for &(row, column, value) in &self.0 {
            y[column] += factor * value * x[row];
        }
    }
}

/// Moments about the centre of a cell from those about the centre of one of its eight parts,
/// lengths in the edges of each: `R(x) = T R(y)` with `x = y/2 + s`.
///
/// Bits 0, 1, 2 of the index are the half along x, y, z. Local expansions go the other way, by
/// half the transposed matrix.
pub(super) static FROM_PART: LazyLock<Vec<DMatrix<f64>>> = LazyLock::new(|| {
    (0..8)
        .map(|octant| {
            let shift = solid(&centre_of_part(octant), ORDER);
            matrix(ORDER, |l, m, value, (j, _)| {
                if j > l {
                    return Complex::default();
                }
                let scale = 0.5_f64.powi(j as i32);
                let range = -(j as i64)..=j as i64;
                let left = (l - j) as i64;
                let terms = range.filter(|k| (m - k).abs() <= left);
                terms
                    .map(|k| value(j, k) * signed(&shift, l - j, m - k) * scale)
                    .sum()
            })
        })
        .collect()
});

/// Centre of an eighth of a cell, from the centre of the cell, in its edges.
pub(super) fn centre_of_part(octant: usize) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| if octant >> axis & 1 == 1 { 0.25 } else { -0.25 })
}

/// Local expansion up to a degree about a centre at `offset` from that of moments, lengths in the
/// edges of the cells: `L_j^k = (-1)^j Σ conj(M_l^m) I_(j+l)^(k+m)(offset)`.
pub(super) fn local_from_moments_to(degree: usize, offset: &Vector3<f64>) -> DMatrix<f64> {
    let highest = 2 * degree;
    let mut irregular = solid(offset, highest);
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    for l in 0..=highest {
        for m in 0..=l {
            irregular[l * (l + 1) / 2 + m] *=
                factorial(l - m) * factorial(l + m) / offset.norm().powi(2 * l as i32 + 1);
        }
    }
    matrix(degree, |j, k, moment, (l, m)| {
        let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
        let term = |m: i64| moment(l, m).conj() * signed(&irregular, j + l, k + m);
        let sum = match m {
            0 => term(0),
            _ => term(-m) + term(m),
        };
        sum * sign
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEAR: Vector3<f64> = Vector3::new(0.11, -0.07, 0.05);

    /// Derivatives against differences.
    #[test]
    fn derivatives_are_those_of_the_harmonics() {
        for axis in 0..3 {
            let step = 1e-4 * Vector3::ith(axis, 1.0);
            let difference = (regular(&(NEAR + step)) - regular(&(NEAR - step))) / 2e-4;
            let mut exact = DVector::zeros(TERMS);
            DERIVATIVES[axis].add(1.0, regular(&NEAR).as_slice(), exact.as_mut_slice());
            assert!((difference - exact).amax() < 1e-8);
        }
    }

    #[test]
    fn moments_about_another_centre_are_those_of_the_source() {
        for octant in 0..8 {
            let about_cell = regular(&(NEAR / 2.0 + centre_of_part(octant)));
            let moved = &FROM_PART[octant] * regular(&NEAR);
            assert!((about_cell - moved).amax() < 1e-15);
        }
    }

    /// The potential of a charge near one centre, at a point near another one.
    #[test]
    fn the_local_expansion_has_the_potential_of_the_moments() {
        let (offset, point) = (Vector3::new(2.0, -3.0, 1.0), Vector3::new(-0.1, 0.2, 0.06));
        let local = local_from_moments_to(ORDER, &offset) * regular(&NEAR);
        let exact = 1.0 / (offset + point - NEAR).norm();
        // (0.23 + 0.14)/3.7 to the power of 11
        assert!((local.dot(&regular(&point)) - exact).abs() < 1e-11);
    }
}
