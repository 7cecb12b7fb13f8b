//! Several vectors multiplied in one pass over a matrix.

use std::array::from_fn;

/// Number of columns in the next pass if `columns` remain.
///
/// The sums of more than three columns do not fit into the sixteen vector registers of the baseline
/// instruction set: in the V-cycle four columns at once took as long per column as one alone, three
/// took 0.58 of it.
pub(crate) fn width(columns: usize) -> usize {
    match columns {
        4 => 2,
        _ => columns.min(3),
    }
}

/// Panics if a column of `x` does not have `cols` entries, or one of `y` not `rows`.
///
/// The documented panic of [`LinearOperator::apply`](crate::LinearOperator::apply).
pub(crate) fn assert_lengths<const S: usize>(
    x: &[&[f64]; S],
    cols: usize,
    y: &[&mut [f64]; S],
    rows: usize,
) {
    for (x, y) in x.iter().zip(y) {
        assert_eq!((x.len(), y.len()), (cols, rows), "lengths of x and y");
    }
}

/// Calls a method that is generic over the number of columns on `x` and `y`, [`width`] at a time.
macro_rules! in_passes {
    ($owner:ident.$pass:ident($x:expr, $y:expr)) => {{
        use $crate::columns::{first, first_mut, width};
        let (mut x, mut y) = ($x, $y);
        assert_eq!(x.len(), y.len(), "numbers of columns");
        while !x.is_empty() {
            let (now, later) = x.split_at(width(x.len()));
            let (y_now, y_later) = y.split_at_mut(now.len());
            match now.len() {
                1 => $owner.$pass::<1>(first(now), first_mut(y_now)),
                2 => $owner.$pass::<2>(first(now), first_mut(y_now)),
                _ => $owner.$pass::<3>(first(now), first_mut(y_now)),
            }
            (x, y) = (later, y_later);
        }
    }};
}
pub(crate) use in_passes;

/// The first `S` columns, empty where there are fewer.
pub(crate) fn first<'a, const S: usize>(x: &[&'a [f64]]) -> [&'a [f64]; S] {
    from_fn(|s| x.get(s).copied().unwrap_or_default())
}

/// The first `S` columns, empty where there are fewer.
pub(crate) fn first_mut<'a, const S: usize>(y: &'a mut [&mut [f64]]) -> [&'a mut [f64]; S] {
    let mut y = y.iter_mut();
    from_fn(|_| y.next().map(|y| &mut **y).unwrap_or_default())
}

/// Every column split at `at`.
pub(crate) fn split<const S: usize>(x: [&[f64]; S], at: usize) -> ([&[f64]; S], [&[f64]; S]) {
    (x.map(|x| &x[..at]), x.map(|x| &x[at..]))
}

/// Every column split at `at`.
pub(crate) fn split_mut<T, const S: usize>(
    y: [&mut [T]; S],
    at: usize,
) -> ([&mut [T]; S], [&mut [T]; S]) {
    let mut high: [&mut [T]; S] = from_fn(|_| Default::default());
    let mut highs = high.iter_mut();
    let low = y.map(|y| {
        let (low, rest) = y.split_at_mut(at);
        if let Some(high) = highs.next() {
            *high = rest;
        }
        low
    });
    (low, high)
}

/// The columns of a buffer that stores them one after another, `len` entries each.
pub(crate) fn of_buffer<const S: usize>(buffer: &mut [f64], len: usize) -> [&mut [f64]; S] {
    let mut rest = buffer;
    from_fn(|_| {
        let (column, others) = std::mem::take(&mut rest).split_at_mut(len);
        rest = others;
        column
    })
}
