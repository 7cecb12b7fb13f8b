//! Preconditioner of the multipoles of many spheres from the soft flows of narrow gaps.
//!
//! In scaled modes the Galerkin matrix of two spheres is the identity and a coupling `B`,
//! ```text
//! A = | 1  B^T |    B u = σ v,  B^T v = σ u:   A (u, -v) = (1 - σ) (u, -v)
//!     | B   1  |
//! ```
//! so that singular values near one, which flows in narrow gaps with the azimuthal numbers 0 and 1
//! about their axis have, are eigenvalues near zero. With such unit vectors `w = (u, -v)/√2` of all
//! narrow gaps the preconditioner is
//! ```text
//! 1 + sum σ/(1 - σ) w w^T
//! ```
//! the inverse of the matrix of two spheres in these directions, and positive definite for any
//! number of spheres, which the sum of the inverses of all pairs is not. Two-sphere solutions
//! precondition fast Stokesian dynamics too (Sierou & Brady 2001, J. Fluid Mech. 448, 115).

use nalgebra::DVector;
use pulp::Scalar;
use rayon::prelude::*;

use super::axis_turn::{Angles, OfFamilies, QuarterTurn, Turning, multiples};
use super::coupling::{Expansion, SymmetryClass, axial_coupling};
use super::modes::{FAMILIES, Family, Modes};
use super::pair_product::{PairOrders, harmonics};
use super::truncation;

/// Relative error of the resistance of a pair at the order of its soft flows.
const ACCURACY: f64 = 0.1;

/// Least singular value of a soft flow: its eigenvalue rises from a half to one.
const SOFT: f64 = 0.5;

/// Largest singular value: what couplings neglect may bring them to one.
const LARGEST: f64 = 1.0 - 1e-9;

/// The soft flows of all narrow gaps.
pub(super) struct PairPreconditioner {
    gaps: Vec<SoftGap>,
    /// Of each sphere its gaps, with the end that it has.
    of_spheres: Vec<Vec<(usize, usize)>>,
}

/// The soft flows of a gap.
struct SoftGap {
    ends: [usize; 2],
    /// The rows of the azimuthal numbers -1, 0, 1 of the rotation onto the line of centres: entries
    /// of all harmonics of both spheres up to the higher order.
    rows: Vec<[f64; 3]>,
    flows: Vec<SoftFlow>,
}

/// A soft flow of one symmetry class.
struct SoftFlow {
    class: SymmetryClass,
    /// `σ/(1 - σ)`.
    weight: f64,
    /// Entries of `w` for both ends by degree.
    entries: [Vec<OfFamilies>; 2],
}

impl SoftFlow {
    /// Places of the azimuthal numbers of a family among -1, 0, 1, and signs.
    fn places(&self) -> [(usize, f64); 3] {
        FAMILIES.map(|family| self.class.row(family, 1))
    }
}

impl PairPreconditioner {
    /// The soft flows of pairs with these ends, directions, radii over the distance and highest
    /// orders. Cost: `O(L^3)` for the order `L` of a gap.
    pub fn new(
        spheres: usize,
        quarter: &QuarterTurn,
        pairs: &[([usize; 2], &Angles, [f64; 2], PairOrders)],
    ) -> Self {
        let gaps = pairs
            .par_iter()
            .filter_map(|&(ends, angles, ratios, most)| {
                let (first, second) = truncation::for_pair(1.0, ratios[0], ratios[1], ACCURACY);
                let orders = [first.min(most[0]), second.min(most[1])];
                let flows = soft_flows(ratios, orders);
                let top = orders[0].max(orders[1]);
                let is_soft = ends[0] != ends[1] && !flows.is_empty();
                is_soft.then(|| SoftGap {
                    ends,
                    rows: rows_onto_line(quarter, angles, top),
                    flows,
                })
            });
        let gaps: Vec<SoftGap> = gaps.collect();
        let mut of_spheres = vec![Vec::new(); spheres];
        for (number, gap) in gaps.iter().enumerate() {
            for (end, &sphere) in gap.ends.iter().enumerate() {
                of_spheres[sphere].push((number, end));
            }
        }
        Self { gaps, of_spheres }
    }

    /// Multiplies the multipoles `x`, which have these modes from these places on.
    pub fn apply(&self, x: &mut DVector<f64>, (modes, first): (&[Modes], &[usize])) {
        let given = x.as_slice();
        let amplitudes: Vec<Vec<f64>> = (self.gaps.par_iter())
            .map(|gap| {
                gap.amplitudes(|end| {
                    let sphere = gap.ends[end];
                    (modes[sphere], &given[first[sphere]..])
                })
            })
            .collect();
        let added: Vec<Vec<f64>> = (self.of_spheres.par_iter().zip(modes))
            .map(|(gaps, &modes)| {
                let mut own = vec![0.0; if gaps.is_empty() { 0 } else { modes.len() }];
                for &(number, end) in gaps {
                    self.gaps[number].add(&amplitudes[number], end, modes, &mut own);
                }
                own
            })
            .collect();
        for (first, added) in first.iter().zip(added) {
            for (entry, added) in x.as_mut_slice()[*first..].iter_mut().zip(added) {
                *entry += added;
            }
        }
    }
}

impl SoftGap {
    /// `σ/(1 - σ) w^T x` of all flows.
    fn amplitudes<'x>(&self, of_end: impl Fn(usize) -> (Modes, &'x [f64])) -> Vec<f64> {
        let mut amplitudes = vec![0.0; self.flows.len()];
        for end in 0..2 {
            let (modes, x) = of_end(end);
            let degrees = self.flows.first().map_or(0, |flow| flow.entries[end].len());
            for l in 1..=degrees {
                let along = FAMILIES.map(|family| match modes.contains(family, l) {
                    true => self.along(l, &x[modes.shell(family, l)]),
                    false => [0.0; 3],
                });
                for (amplitude, flow) in amplitudes.iter_mut().zip(&self.flows) {
                    for (family, (place, sign)) in flow.places().into_iter().enumerate() {
                        let entry = flow.entries[end][l - 1][family];
                        *amplitude += flow.weight * sign * entry * along[family][place];
                    }
                }
            }
        }
        amplitudes
    }

    /// Coefficients of a degree with the azimuthal numbers -1, 0, 1 about the line.
    fn along(&self, l: usize, x: &[f64]) -> [f64; 3] {
        let mut along = [0.0; 3];
        for (row, x) in self.rows[l * l - 1..].iter().zip(x) {
            for (along, entry) in along.iter_mut().zip(row) {
                *along += entry * x;
            }
        }
        along
    }

    /// Adds the flows with these amplitudes to the modes of one end.
    fn add(&self, amplitudes: &[f64], end: usize, modes: Modes, x: &mut [f64]) {
        let degrees = self.flows.first().map_or(0, |flow| flow.entries[end].len());
        for l in 1..=degrees {
            let mut along = [[0.0; 3]; 3];
            for (amplitude, flow) in amplitudes.iter().zip(&self.flows) {
                for (family, (place, sign)) in flow.places().into_iter().enumerate() {
                    along[family][place] += sign * amplitude * flow.entries[end][l - 1][family];
                }
            }
            for (family, along) in FAMILIES.into_iter().zip(along) {
                if !modes.contains(family, l) {
                    continue;
                }
                let shell = &mut x[modes.shell(family, l)];
                for (entry, row) in shell.iter_mut().zip(&self.rows[l * l - 1..]) {
                    *entry += row[0] * along[0] + row[1] * along[1] + row[2] * along[2];
                }
            }
        }
    }
}

/// The rows of the azimuthal numbers -1, 0, 1: what the inverse rotation makes of unit vectors,
/// that of each number in the place of a family.
fn rows_onto_line(quarter: &QuarterTurn, angles: &Angles, top: usize) -> Vec<[f64; 3]> {
    let simd = Scalar::new();
    let mut turning = Turning::<Scalar>::default();
    multiples(simd, |_| angles, top, &mut turning.multiples);
    let mut rows = vec![[0.0; 3]; harmonics(top)];
    for l in 1..=top {
        let mut units = vec![[0.0; 3]; 2 * l + 1];
        for k in 0..3 {
            units[l + k - 1][k] = 1.0;
        }
        let own = &mut rows[l * l - 1..l * l + 2 * l];
        quarter.off_line(simd, (l, 1), &units, own, &mut turning);
    }
    rows
}

/// Soft flows of two spheres with these radii at the distance 1, without forces and torques.
fn soft_flows(ratios: [f64; 2], orders: PairOrders) -> Vec<SoftFlow> {
    let ends = [0, 1].map(|end| Expansion {
        radius: ratios[end],
        modes: Modes { order: orders[end] },
    });
    let is_rigid = |&(family, l): &(Family, usize)| l == 1 && family != Family::Source;
    let mut flows = Vec::new();
    for m in [0, 1] {
        let coupling = axial_coupling([&ends[0], &ends[1]], 1.0, m);
        let sectors = ends.map(|end| end.modes.sector(m));
        let free = sectors.each_ref().map(|sector| -> Vec<usize> {
            let all = sector.iter().enumerate();
            all.filter(|(_, mode)| !is_rigid(mode))
                .map(|(k, _)| k)
                .collect()
        });
        let coupling = faer::Mat::from_fn(free[1].len(), free[0].len(), |i, j| {
            coupling[(free[1][i], free[0][j])]
        });
        // a pair whose flows cannot be found is left to the iteration
        let Ok(svd) = coupling.thin_svd() else {
            continue;
        };
        for (k, &sigma) in svd.S().column_vector().iter().enumerate() {
            if sigma.is_nan() || sigma < SOFT {
                continue;
            }
            let sigma = sigma.min(LARGEST);
            let of_end = |end: usize, entry: &dyn Fn(usize) -> f64| {
                let mut all = vec![[0.0; 3]; orders[end]];
                for (i, &place) in free[end].iter().enumerate() {
                    let (family, l) = sectors[end][place];
                    all[l - 1][family as usize] = entry(i) / 2.0_f64.sqrt();
                }
                all
            };
            let entries = [
                of_end(0, &|i| svd.V()[(i, k)]),
                of_end(1, &|i| -svd.U()[(i, k)]),
            ];
            let classes = SymmetryClass::all(m).filter(|class| class.m == m);
            flows.extend(classes.map(|class| SoftFlow {
                class,
                weight: sigma / (1.0 - sigma),
                entries: entries.clone(),
            }));
        }
    }
    flows
}
