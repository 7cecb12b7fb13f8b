//! Vector operations whose results do not depend on the number of threads.

use rayon::prelude::*;

use crate::{LinalgError, SumOverProcesses};

/// Vector entries summed serially: 16 kB of f64, half of a first-level cache.
pub(crate) const CHUNK: usize = 2048;

/// `x · y`, summed by a tree that depends on the length only.
pub(crate) fn dot(x: &[f64], y: &[f64]) -> f64 {
    tree(x.len(), 0, &|lo, hi| lanes_dot(&x[lo..hi], &y[lo..hi]))
}

/// `x · y` in eight partial sums.
///
/// A single sum would wait for each addition, which is longer than a memory access takes.
#[inline]
pub(crate) fn lanes_dot<T: Copy + Into<f64>>(x: &[T], y: &[f64]) -> f64 {
    let (x_lanes, x_rest) = x.as_chunks::<8>();
    let (y_lanes, y_rest) = y.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (x, y) in x_lanes.iter().zip(y_lanes) {
        for lane in 0..8 {
            sums[lane] += x[lane].into() * y[lane];
        }
    }
    let rest: f64 = x_rest.iter().zip(y_rest).map(|(&x, y)| x.into() * y).sum();
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + b) + (c + d)) + ((e + f) + (g + h)) + rest
}

/// `(sum w_i x_i^2)^(1/2)`.
pub(crate) fn weighted_norm(weights: &[f32], x: &[f64]) -> f64 {
    let square = tree(x.len(), 0, &|lo, hi| {
        let mut squares = [0.0; CHUNK];
        for (s, x) in squares.iter_mut().zip(&x[lo..hi]) {
            *s = x * x;
        }
        lanes_dot(&weights[lo..hi], &squares[..hi - lo])
    });
    square.sqrt()
}

/// Euclidean norm.
pub(crate) fn norm(x: &[f64]) -> f64 {
    dot(x, x).sqrt()
}

/// A norm over all processes, from that of the entries of this one.
pub(crate) fn norm_over(sum: Option<&SumOverProcesses<'_>>, norm: f64) -> f64 {
    let Some(sum) = sum else {
        return norm;
    };
    let mut square = [norm * norm];
    sum(&mut square);
    square[0].sqrt()
}

/// Whether all entries are zero, on every process.
pub(crate) fn is_zero(x: &[f64], sum: Option<&SumOverProcesses<'_>>) -> bool {
    let mut nonzero = [f64::from(u8::from(x.iter().any(|v| *v != 0.0)))];
    if let Some(sum) = sum {
        sum(&mut nonzero);
    }
    nonzero[0] == 0.0
}

/// `||b||` of a right-hand side with finite entries; `None` for `b = 0`.
///
/// # Errors
/// [`LinalgError::Parameter`] if squares of the entries overflow or underflow.
pub(crate) fn rhs_norm(
    b: &[f64],
    sum: Option<&SumOverProcesses<'_>>,
) -> Result<Option<f64>, LinalgError> {
    if is_zero(b, sum) {
        return Ok(None);
    }
    let size = norm_over(sum, norm(b));
    if size.is_finite() && size > 0.0 {
        return Ok(Some(size));
    }
    Err(LinalgError::Parameter {
        name: "norm of the right-hand side",
        value: size,
        range: "a normal number; scale the problem",
    })
}

/// Largest magnitude, ignoring NaN.
pub(crate) fn max_abs(x: &[f64]) -> f64 {
    x.par_chunks(CHUNK)
        .map(|c| c.iter().fold(0.0_f64, |m, v| m.max(v.abs())))
        .reduce(|| 0.0, f64::max)
}

/// Calls `f(start, chunk)` for the chunks of [`CHUNK`] entries of `y`, in parallel.
///
/// The function is called by reference, so that rayon's tree of tasks is compiled once per `T`.
pub(crate) fn for_each_chunk<T: Send>(y: &mut [T], f: &(dyn Fn(usize, &mut [T]) + Sync)) {
    let chunks = y.par_chunks_mut(CHUNK).enumerate();
    chunks.for_each(|(chunk, y)| f(chunk * CHUNK, y));
}

/// The numbers `f(i)` for `i` below `n`, computed in parallel.
pub(crate) fn map_rows<T: Send>(n: usize, f: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    (0..n).into_par_iter().map(f).collect()
}

/// `y <- y + alpha x`.
pub(crate) fn axpy(alpha: f64, x: &[f64], y: &mut [f64]) {
    for_each_chunk(y, &|start, y| {
        for (y, x) in y.iter_mut().zip(&x[start..]) {
            *y += alpha * x;
        }
    });
}

/// `y <- x + beta y`.
pub(crate) fn xpby(x: &[f64], beta: f64, y: &mut [f64]) {
    for_each_chunk(y, &|start, y| {
        for (y, x) in y.iter_mut().zip(&x[start..]) {
            *y = x + beta * *y;
        }
    });
}

/// `y <- alpha y`.
pub(crate) fn scale(alpha: f64, y: &mut [f64]) {
    for_each_chunk(y, &|_, y| y.iter_mut().for_each(|y| *y *= alpha));
}

/// `r <- b - r`.
pub(crate) fn subtract_from(b: &[f64], r: &mut [f64]) {
    for_each_chunk(r, &|start, r| {
        for (r, b) in r.iter_mut().zip(&b[start..]) {
            *r = b - *r;
        }
    });
}

/// The largest power of two not above `|x|`, and one for zero, NaN and infinity.
///
/// Scaling by it causes no rounding error.
pub(crate) fn power_of_two_below(x: f64) -> f64 {
    let exponent_bits = x.abs().to_bits() & (0x7ff << 52);
    match exponent_bits >> 52 {
        // the last few exponents are avoided, so that the reciprocal is normal too
        0 | 0x7fd.. => 1.0,
        _ => f64::from_bits(exponent_bits),
    }
}

/// The sum of `part(lo, hi)` over chunks of `[start, start + len)`, halved at chunk boundaries.
fn tree(len: usize, start: usize, part: &(impl Fn(usize, usize) -> f64 + Sync)) -> f64 {
    if len <= CHUNK {
        return part(start, start + len);
    }
    let half = len.div_ceil(CHUNK) / 2 * CHUNK;
    let (a, b) = rayon::join(
        || tree(half, start, part),
        || tree(len - half, start + half, part),
    );
    a + b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dot_is_bitwise_the_same_on_one_and_two_threads() {
        let x: Vec<f64> = (0..100_003).map(|i| (i as f64 * 0.37).sin()).collect();
        let on = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .expect("a pool")
                .install(|| dot(&x, &x).to_bits())
        };
        assert_eq!(on(1), on(2));
    }

    #[test]
    fn power_of_two_scaling_is_exact_and_safe() {
        for (x, p) in [
            (1.0, 1.0),
            (-3.9, 2.0),
            (0.3, 0.25),
            (1e-300, 2f64.powi(-997)),
        ] {
            assert_eq!(power_of_two_below(x), p);
        }
        for x in [0.0, f64::NAN, f64::INFINITY, 5e-324, f64::MAX] {
            assert_eq!(power_of_two_below(x), 1.0, "{x}");
        }
    }
}
