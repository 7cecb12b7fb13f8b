//! Spheres on an axis of symmetry of their medium.
//!
//! The unknowns decouple by azimuthal number, and rigid motions have only `m = 0` and `m = 1`.

use faer::Mat;

use super::Scaled;
use super::axial::{Interior, Outgoing};
use super::elimination::eliminate;
use super::lamb::{Lamb, place};
use super::modes::{FAMILIES, Family, Modes};
use super::order::Orders;
use super::reflection::image;
use crate::HydroError;

/// Boundary of the fluid in the frame of the expansions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Around {
    Nothing,
    /// A container of the given radius about the origin.
    Ball(f64),
    /// The wall `z = 0`, with the fluid above it.
    Wall,
}

/// Families and azimuthal number of modes that couple to each other.
struct Sector {
    m: usize,
    families: &'static [Family],
}

const SECTORS: [Sector; 3] = [
    Sector {
        m: 0,
        families: &[Family::Stokeslet, Family::Source],
    },
    Sector {
        m: 0,
        families: &[Family::Rotlet],
    },
    Sector {
        m: 1,
        families: &FAMILIES,
    },
];

/// One degree of freedom: a mode of a sphere, or of the container, which comes last.
#[derive(Clone, Copy)]
struct Unknown {
    body: usize,
    family: Family,
    l: usize,
}

/// Scaled mobility matrices of spheres at heights `z` on the axis, for `orders` and two orders
/// lower.
///
/// Cost: `O((n L)^3)` for `n` spheres of order `L`, with a small constant: the largest sector has
/// `3 n L` degrees of freedom.
pub(crate) fn mobility(
    z: &[f64],
    radii: &[f64],
    around: Around,
    orders: &Orders,
) -> Result<Scaled, HydroError> {
    let n = z.len();
    let mut scaled = Scaled::zeros(n);
    for sector in &SECTORS {
        let unknowns = unknowns(sector, around, orders);
        let matrix = assemble(sector, z, radii, around, orders, &unknowns);
        let kept = unknowns.iter().take_while(|u| rank(u, orders) == 0).count();
        let rigid: Vec<Unknown> = unknowns
            .into_iter()
            .filter(|u| rank(u, orders) == 2)
            .collect();
        let [full, lower] = eliminate(matrix, rigid.len(), kept)?;
        for (i, a) in rigid.iter().enumerate() {
            for (j, b) in rigid.iter().enumerate() {
                // m = 0 is the second of the three modes of degree 1. m = 1 occurs with the cosine
                // and with the sine; rotlets belong to the opposite symmetry class and change sign.
                let halves: &[i32] = if sector.m == 0 { &[0] } else { &[1, -1] };
                for &half in halves {
                    let at = |u: &Unknown| {
                        let rotlet = u.family == Family::Rotlet;
                        let m = if rotlet { -half } else { half };
                        let sign = if rotlet && half < 0 { -1.0 } else { 1.0 };
                        (
                            6 * u.body + 3 * usize::from(rotlet) + (m + 1) as usize,
                            sign,
                        )
                    };
                    let ((row, s), (column, t)) = (at(a), at(b));
                    scaled.full[(row, column)] = s * t * full[(i, j)];
                    scaled.lower[(row, column)] = s * t * lower[(i, j)];
                }
            }
        }
    }
    Ok(scaled)
}

fn modes(body: usize, orders: &Orders) -> Modes {
    Modes {
        order: orders
            .spheres
            .get(body)
            .copied()
            .unwrap_or(orders.container),
    }
}

/// Position in the elimination: modes of the lower order, then the others, then the rigid motions,
/// which are kept.
fn rank(u: &Unknown, orders: &Orders) -> usize {
    let rigid = u.body < orders.spheres.len() && u.l == 1 && u.family != Family::Source;
    match (rigid, modes(u.body, orders).in_lower_order(u.family, u.l)) {
        (true, _) => 2,
        (false, true) => 0,
        (false, false) => 1,
    }
}

fn unknowns(sector: &Sector, around: Around, orders: &Orders) -> Vec<Unknown> {
    let bodies = orders.spheres.len() + usize::from(matches!(around, Around::Ball(_)));
    let mut all: Vec<Unknown> = (0..bodies)
        .flat_map(|body| {
            modes(body, orders)
                .sector(sector.m)
                .into_iter()
                .filter(|(family, _)| sector.families.contains(family))
                .map(move |(family, l)| Unknown { body, family, l })
        })
        .collect();
    all.sort_by_key(|u| rank(u, orders));
    all
}

/// Symmetric matrix of a sector: ones on the diagonal, couplings below it; the upper triangle stays
/// zero.
fn assemble(
    sector: &Sector,
    z: &[f64],
    radii: &[f64],
    around: Around,
    orders: &Orders,
    unknowns: &[Unknown],
) -> Mat<f64> {
    let n = z.len();
    let container = match around {
        Around::Ball(radius) => radius,
        _ => f64::NAN,
    };
    let radius = |body: usize| radii.get(body).copied().unwrap_or(container);
    let weights: Vec<f64> = unknowns
        .iter()
        .map(|u| u.family.energy(u.l, radius(u.body)).sqrt())
        .collect();
    // for each expansion: degree and index of its modes, by family
    let mut places = vec![[const { Vec::new() }; 3]; n + 1];
    for (index, u) in unknowns.iter().enumerate() {
        places[u.body][place(u.family)].push((u.l, index));
    }
    let mut matrix = Mat::<f64>::identity(unknowns.len(), unknowns.len());
    let mut couple = |from: usize,
                      to: usize,
                      flow: &dyn Fn(Family, usize) -> Vec<Lamb>,
                      sign: &dyn Fn(Family, usize) -> f64| {
        for family in FAMILIES {
            for &(l, source) in &places[from][place(family)] {
                let regular = flow(family, l);
                for other in FAMILIES {
                    for &(k, target) in &places[to][place(other)] {
                        let value = regular[k].trace(k)[place(other)] * weights[target]
                            / weights[source]
                            * sign(family, l)
                            * sign(other, k);
                        let (row, column) = (source.max(target), source.min(target));
                        // The image of a sphere in the wall couples the sphere to itself: each pair
                        // of modes occurs twice.
                        if from != to || target >= source {
                            matrix[(row, column)] += value;
                        }
                    }
                }
            }
        }
    };
    let top = |body: usize| modes(body, orders).order;
    let m = sector.m;
    let plain = |_: Family, _: usize| 1.0;
    for j in 0..n {
        for i in 0..j {
            let (low, high) = if z[i] < z[j] { (i, j) } else { (j, i) };
            let pair = Outgoing::new(
                m,
                (radii[low], top(low)),
                (radii[high], top(high)),
                z[high] - z[low],
            );
            couple(
                low,
                high,
                &|f, l| degrees(m, top(high), |k| pair.lamb(f, l, k)),
                &plain,
            );
        }
        match around {
            Around::Nothing => {}
            Around::Ball(radius) => {
                let within = Interior::new(
                    m,
                    (radius, orders.container),
                    (radii[j], top(j)),
                    z[j].abs(),
                );
                // below the centre, the axis points the other way
                let mirror = |f: Family, l: usize| if z[j] < 0.0 { f.parity(l, m) } else { 1.0 };
                couple(
                    n,
                    j,
                    &|f, k| degrees(m, top(j), |l| within.lamb(f, k, l)),
                    &mirror,
                );
            }
            Around::Wall => {
                for i in 0..=j {
                    let reflected =
                        Outgoing::new(m, (radii[i], top(i)), (radii[j], top(j) + 2), z[i] + z[j]);
                    let flow = |f: Family, l: usize| {
                        let mirrored = degrees(m, top(j) + 2, |k| {
                            reflected.lamb(f, l, k).scaled(f.parity(l, m))
                        });
                        image(&mirrored, m as i32, z[j] / radii[j], top(j))
                    };
                    couple(i, j, &flow, &plain);
                }
            }
        }
    }
    matrix
}

/// Coefficients of degrees `0 ..= top`; zero for degree 0 and degrees below `m`.
pub(super) fn degrees(m: usize, top: usize, of: impl Fn(usize) -> Lamb) -> Vec<Lamb> {
    (0..=top)
        .map(|k| {
            if k >= m.max(1) {
                of(k)
            } else {
                Lamb::default()
            }
        })
        .collect()
}
