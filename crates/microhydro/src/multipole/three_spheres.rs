//! Modes between the orders of the spheres and those of narrow gaps, to first order.
//!
//! `narrow_gap` eliminates the high degrees of two spheres exactly, and neglects that a high degree
//! of one sphere couples two other ones. With the low degrees `k` and the high ones `h` of the
//! sphere between, that coupling is, to first order,
//! ```text
//! A_jk += -A_jh A_hk   for spheres j != k
//! ```
//! The next two orders of each sphere are taken for `h`, and gaps that need no more. In narrower
//! gaps the two surfaces amplify each other's high degrees, so that the first order is no
//! approximation.

use std::collections::BTreeMap;

use faer::Mat;
use rayon::prelude::*;

use super::coupling::{Coupling, Expansion};
use super::frame::Frame;
use super::modes::Modes;
use super::narrow_gap::Block;
use super::orders::Orders;

/// Accuracy of the couplings: none of the few degrees is neglected.
const COUPLING_TOLERANCE: f64 = 1e-14;

/// Number of spheres whose products are computed at a time.
const SPHERES_PER_BATCH: usize = 32;

/// Blocks between spheres whose gaps with the same third sphere need the next two orders at most.
pub(super) fn blocks(frame: &Frame, radii: &[f64], orders: &Orders) -> Vec<Block> {
    let n = radii.len();
    let mut neighbours = vec![Vec::new(); n];
    for (&(first, second), gap) in &orders.gaps {
        if first >= n || second >= n {
            continue;
        }
        let [of_first, of_second] = gap.singular;
        if of_first <= orders.spheres[first] + 2 && of_second <= orders.spheres[second] + 2 {
            neighbours[first].push(second);
            neighbours[second].push(first);
        }
    }
    let between: Vec<usize> = (0..n).filter(|&i| neighbours[i].len() > 1).collect();
    let mut all: BTreeMap<(usize, usize), Mat<f64>> = BTreeMap::new();
    for batch in between.chunks(SPHERES_PER_BATCH) {
        let products: Vec<Vec<Block>> = batch
            .par_iter()
            .map(|&i| of_sphere(i, &neighbours[i], frame, radii, orders))
            .collect();
        // added in a fixed order, so that the result does not depend on the threads
        for (pair, product) in products.into_iter().flatten() {
            match all.get_mut(&pair) {
                Some(sum) => *sum -= &product,
                None => {
                    all.insert(pair, -product);
                }
            }
        }
    }
    all.into_iter().collect()
}

/// Products `A_jh A_hk` over the high degrees `h` of one sphere, for its neighbours `j > k`.
fn of_sphere(
    sphere: usize,
    neighbours: &[usize],
    frame: &Frame,
    radii: &[f64],
    orders: &Orders,
) -> Vec<Block> {
    let expansion = |index: usize, more: usize| Expansion {
        radius: radii[index],
        modes: Modes {
            order: orders.spheres[index] + more,
        },
    };
    let target = expansion(sphere, 2);
    let low = Modes {
        order: orders.spheres[sphere],
    };
    let high: Vec<usize> = target
        .modes
        .shells()
        .filter(|&(family, l)| !low.contains(family, l))
        .flat_map(|(family, l)| target.modes.shell(family, l))
        .collect();
    let couplings: Vec<Mat<f64>> = neighbours
        .iter()
        .map(|&source| {
            let offset = frame.centres[sphere] - frame.centres[source];
            let pair = (&expansion(source, 0), &target);
            let dense =
                Coupling::between_spheres((source, sphere), pair, &offset, COUPLING_TOLERANCE)
                    .dense();
            Mat::from_fn(high.len(), dense.ncols(), |i, j| dense[(high[i], j)])
        })
        .collect();
    let mut products = Vec::new();
    for (b, &to) in neighbours.iter().enumerate() {
        for (a, &from) in neighbours
            .iter()
            .enumerate()
            .filter(|(_, from)| **from < to)
        {
            products.push(((from, to), couplings[b].transpose() * &couplings[a]));
        }
    }
    products
}
