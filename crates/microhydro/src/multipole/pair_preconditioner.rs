//! Preconditioner of the multipoles of many spheres from the soft flows of narrow gaps.
//!
//! In scaled modes the Galerkin matrix of two spheres is the identity and a coupling `B`,
//! ```text
//! A = | 1  B^T |    B u = σ v,  B^T v = σ u:   A (u, -v) = (1 - σ) (u, -v)
//!     | B   1  |
//! ```
//! so that singular values near one are eigenvalues near zero. The softest flow of a gap
//! with the bispherical coordinate `ξ` has `1 - σ` of about `ξ^2`, and low azimuthal numbers have
//! more of them the narrower the gap is,
//! which without preconditioner makes iterations grow as `1/ξ`. With such unit vectors
//! `w = (u, -v)/√2` of all narrow gaps the preconditioner is
//! ```text
//! 1 + sum σ/(1 - σ) w w^T
//! ```
//! the inverse of the matrix of two spheres in these directions, and positive definite for any
//! number of spheres, which the sum of the inverses of all pairs is not. Two-sphere solutions
//! precondition fast Stokesian dynamics too (Sierou & Brady 2001, J. Fluid Mech. 448, 115).

use std::f64::consts::FRAC_1_SQRT_2;

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::linalg::matmul::matmul;
use faer::{Accum, Col, ColRef, Mat, Par, Spec};
use nalgebra::DVector;
use pulp::Scalar;
use rayon::prelude::*;

use super::axis_turn::{Angles, OfFamilies, QuarterTurn, Turning, multiples};
use super::coupling::{Expansion, SymmetryClass, axial_coupling};
use super::line_of_centres::{Line, PairOrders, harmonics};
use super::modes::{FAMILIES, Family, Modes};
use super::truncation;

/// Least singular value of a soft flow: its eigenvalue rises from a half to one.
const SOFT: f64 = 0.5;

/// Error of soft flows for a bispherical coordinate of one; it falls with its square, as the
/// eigenvalues do. Orders of an error ten times smaller save two of 30 iterations and double the
/// time for the flows, with one ten times larger those of gaps of 0.001 radii double.
const ACCURACY: f64 = 0.1;

/// Largest singular value: what couplings neglect may bring them to one.
const LARGEST: f64 = 1.0 - 1e-9;

/// Two spheres that may have soft flows.
pub(super) struct NarrowPair<'a> {
    pub ends: [usize; 2],
    pub line: &'a Line,
    /// Highest orders.
    pub orders: PairOrders,
    /// Highest degree with azimuthal numbers above one.
    pub regular: usize,
}

/// The soft flows of all narrow gaps.
pub(super) struct PairPreconditioner {
    gaps: Vec<SoftGap>,
    /// Of each sphere its gaps, with the end that it has.
    of_spheres: Vec<Vec<(usize, usize)>>,
}

/// The soft flows of a gap.
struct SoftGap {
    ends: [usize; 2],
    orders: PairOrders,
    /// Highest azimuthal number `m` of a soft flow.
    highest: usize,
    /// The rows `-m ..= m` of the rotation onto the line of centres, for one harmonic of the
    /// spheres after the other.
    rows: Vec<f64>,
    flows: Vec<SoftFlow>,
}

/// A soft flow of one symmetry class.
struct SoftFlow {
    /// Azimuthal number, with the sign of that of each family.
    m: [isize; 3],
    /// `σ/(1 - σ)`.
    weight: f64,
    /// Entries of `w` for both ends, by degree up to the orders of the gap.
    entries: [Vec<OfFamilies>; 2],
}

impl PairPreconditioner {
    /// The soft flows of these pairs. Cost: `O(L^3)` for each azimuthal number and the order `L`
    /// of a gap.
    pub fn new(spheres: usize, quarter: &QuarterTurn, pairs: &[NarrowPair]) -> Self {
        let gaps = (pairs.par_iter())
            .filter(|pair| pair.ends[0] != pair.ends[1])
            .filter_map(|pair| SoftGap::new(pair, quarter));
        let gaps: Vec<SoftGap> = gaps.collect();
        let mut of_spheres = vec![Vec::new(); spheres];
        for (number, gap) in gaps.iter().enumerate() {
            for (end, &sphere) in gap.ends.iter().enumerate() {
                of_spheres[sphere].push((number, end));
            }
        }
        Self { gaps, of_spheres }
    }

    /// Multiplies the multipoles `x`, whose modes and first places `of_sphere` tells.
    pub fn apply(&self, x: &mut DVector<f64>, of_sphere: impl Fn(usize) -> (Modes, usize) + Sync) {
        let given = x.as_slice();
        let of_end = |gap: &SoftGap, end: usize| {
            let (modes, first) = of_sphere(gap.ends[end]);
            (modes, &given[first..])
        };
        let amplitudes: Vec<Vec<f64>> = (self.gaps.par_iter())
            .map(|gap| gap.amplitudes(|end| of_end(gap, end)))
            .collect();
        let added: Vec<Vec<f64>> = (self.of_spheres.par_iter().enumerate())
            .map(|(sphere, gaps)| {
                let modes = of_sphere(sphere).0;
                let mut own = vec![0.0; if gaps.is_empty() { 0 } else { modes.len() }];
                for &(number, end) in gaps {
                    self.gaps[number].add(&amplitudes[number], end, modes, &mut own);
                }
                own
            })
            .collect();
        for (sphere, added) in added.iter().enumerate() {
            let first = of_sphere(sphere).1;
            for (entry, added) in x.as_mut_slice()[first..].iter_mut().zip(added) {
                *entry += added;
            }
        }
    }
}

impl SoftGap {
    /// None without soft flows.
    fn new(pair: &NarrowPair, quarter: &QuarterTurn) -> Option<Self> {
        let (flows, orders) = (soft_flows(pair), pair.soft_orders());
        let highest = flows.iter().map(|flow| flow.m[0].unsigned_abs()).max()?;
        let top = orders[0].max(orders[1]);
        Some(Self {
            ends: pair.ends,
            orders,
            highest,
            rows: rows_onto_line(quarter, pair.line.angles(), top, highest),
            flows,
        })
    }

    /// `σ/(1 - σ) w^T x` of all flows.
    fn amplitudes<'x>(&self, of_end: impl Fn(usize) -> (Modes, &'x [f64])) -> Vec<f64> {
        let mut amplitudes = vec![0.0; self.flows.len()];
        let mut along = self.along();
        for end in 0..2 {
            let (modes, x) = of_end(end);
            for l in 1..=self.orders[end] {
                for (family, along) in FAMILIES.into_iter().zip(&mut along) {
                    along.fill(0.0);
                    if modes.contains(family, l) {
                        for (row, x) in self.rows(l).zip(&x[modes.shell(family, l)]) {
                            for (along, entry) in along.iter_mut().zip(row) {
                                *along += entry * x;
                            }
                        }
                    }
                }
                for (amplitude, flow) in amplitudes.iter_mut().zip(&self.flows) {
                    let entries = &flow.entries[end][l - 1];
                    for ((entry, along), m) in entries.iter().zip(&along).zip(flow.m) {
                        *amplitude += flow.weight * entry * along[self.place(m)];
                    }
                }
            }
        }
        amplitudes
    }

    /// Adds the flows with these amplitudes to the modes of one end.
    fn add(&self, amplitudes: &[f64], end: usize, modes: Modes, x: &mut [f64]) {
        let mut along = self.along();
        for l in 1..=self.orders[end] {
            along.iter_mut().for_each(|along| along.fill(0.0));
            for (amplitude, flow) in amplitudes.iter().zip(&self.flows) {
                let entries = &flow.entries[end][l - 1];
                for ((entry, along), m) in entries.iter().zip(&mut along).zip(flow.m) {
                    along[self.place(m)] += amplitude * entry;
                }
            }
            for (family, along) in FAMILIES.into_iter().zip(&along) {
                if modes.contains(family, l) {
                    let shell = &mut x[modes.shell(family, l)];
                    for (entry, row) in shell.iter_mut().zip(self.rows(l)) {
                        let turned = row.iter().zip(along).map(|(row, along)| row * along);
                        *entry += turned.sum::<f64>();
                    }
                }
            }
        }
    }

    /// Zero coefficients of the families along the line, of one degree.
    fn along(&self) -> [Vec<f64>; 3] {
        FAMILIES.map(|_| vec![0.0; self.width()])
    }

    /// Number of azimuthal numbers, with both signs.
    fn width(&self) -> usize {
        2 * self.highest + 1
    }

    /// Rows of the rotation for the harmonics `-l ..= l` of a degree.
    fn rows(&self, l: usize) -> impl Iterator<Item = &[f64]> {
        self.rows[(l * l - 1) * self.width()..].chunks_exact(self.width())
    }

    /// Place of an azimuthal number among `-highest ..= highest`.
    fn place(&self, m: isize) -> usize {
        self.highest.wrapping_add_signed(m)
    }
}

/// The rows of the azimuthal numbers up to `highest`: what the inverse rotation makes of unit
/// vectors, three of them in the places of the families.
fn rows_onto_line(quarter: &QuarterTurn, angles: &Angles, top: usize, highest: usize) -> Vec<f64> {
    let simd = Scalar::new();
    let mut turning = Turning::<Scalar>::default();
    multiples(simd, |_| angles, top, &mut turning.multiples);
    let width = 2 * highest + 1;
    let mut rows = vec![0.0; harmonics(top) * width];
    for l in 1..=top {
        let own = &mut rows[(l * l - 1) * width..(l * l + 2 * l) * width];
        let last = highest.min(l);
        let mut units = vec![[0.0; 3]; 2 * l + 1];
        let mut turned = units.clone();
        for first in (l - last..=l + last).step_by(3) {
            units.fill([0.0; 3]);
            let some = first..(first + 3).min(l + last + 1);
            some.clone().for_each(|k| units[k][k - first] = 1.0);
            quarter.off_line(simd, (l, last), &units, &mut turned, &mut turning);
            for (row, turned) in own.chunks_exact_mut(width).zip(&turned) {
                for k in some.clone() {
                    row[k + highest - l] = turned[k - first];
                }
            }
        }
    }
    rows
}

impl NarrowPair<'_> {
    /// Orders of soft flows.
    fn soft_orders(&self) -> PairOrders {
        let [a, b] = self.line.ratios();
        let xi = truncation::outside(1.0, a, b);
        let xi = xi.0.min(xi.1).min(1.0);
        let (first, second) = truncation::for_pair(1.0, a, b, ACCURACY * xi.powi(2));
        [first.min(self.orders[0]), second.min(self.orders[1])]
    }

    /// Numbers that the soft flows store, and operations to find them: the eigenvectors of the
    /// azimuthal numbers 0 and 1, whose orders are not limited.
    pub fn cost(&self) -> (f64, f64) {
        let order = self.soft_orders().into_iter().max().unwrap_or_default() as f64;
        (10.0 * order.powi(2), 300.0 * order.powi(3))
    }
}

/// Soft flows of a pair without forces and torques.
fn soft_flows(pair: &NarrowPair) -> Vec<SoftFlow> {
    let (ratios, orders) = (pair.line.ratios(), pair.soft_orders());
    let mut flows = Vec::new();
    for m in 0..=orders[0].min(orders[1]).min(pair.regular.max(1)) {
        let highest = if m < 2 { usize::MAX } else { pair.regular };
        let of_number = flows_of_number(ratios, (orders, highest), m);
        // flows are less soft with each azimuthal number
        if of_number.is_empty() && m > 0 {
            break;
        }
        flows.extend(of_number);
    }
    flows
}

/// Soft flows of two spheres with these radii at the distance 1 and one azimuthal number, up to a
/// highest degree.
fn flows_of_number(
    ratios: [f64; 2],
    (orders, highest): (PairOrders, usize),
    m: usize,
) -> Vec<SoftFlow> {
    let ends = [0, 1].map(|end| Expansion {
        radius: ratios[end],
        modes: Modes { order: orders[end] },
    });
    let coupling = axial_coupling([&ends[0], &ends[1]], 1.0, m);
    let sectors = ends.map(|end| end.modes.sector(m));
    let free = sectors.each_ref().map(|sector| -> Vec<usize> {
        let is_rigid = |(family, l): (Family, usize)| l == 1 && family != Family::Source;
        let is_free = |k: &usize| !is_rigid(sector[*k]) && sector[*k].1 <= highest;
        (0..sector.len()).filter(is_free).collect()
    });
    let coupling = Mat::from_fn(free[1].len(), free[0].len(), |i, j| {
        coupling[(free[1][i], free[0][j])]
    });
    // a pair whose flows are not found is left to the iteration
    let Some((squares, vectors)) = eigenvectors(&coupling) else {
        return Vec::new();
    };
    let mut flows = Vec::new();
    let sigmas = squares.iter().map(|square| square.sqrt());
    for (k, sigma) in sigmas.enumerate().filter(|(_, sigma)| *sigma > SOFT) {
        let u = vectors.col(k);
        let mut v = Col::zeros(coupling.nrows());
        matmul(
            v.as_mat_mut(),
            Accum::Replace,
            &coupling,
            u.as_mat(),
            1.0,
            Par::Seq,
        );
        let bounded = sigma.min(LARGEST);
        for class in SymmetryClass::all(m).filter(|class| class.m == m) {
            // among the harmonics `-m ..= m` of the degree m
            let rows = FAMILIES.map(|family| class.row(family, m));
            let of_end = |end: usize, w: ColRef<f64>, factor: f64| {
                let mut all = vec![[0.0; 3]; orders[end]];
                for (&place, entry) in free[end].iter().zip(w.iter()) {
                    let (family, l) = sectors[end][place];
                    all[l - 1][family as usize] = rows[family as usize].1 * factor * entry;
                }
                all
            };
            flows.push(SoftFlow {
                m: rows.map(|(row, _)| row as isize - m as isize),
                weight: bounded / (1.0 - bounded),
                entries: [
                    of_end(0, u, FRAC_1_SQRT_2),
                    of_end(1, v.as_ref(), -FRAC_1_SQRT_2 / sigma),
                ],
            });
        }
    }
    flows
}

/// Eigenvalues and eigenvectors of `B^T B`, with one thread: the rounding of several depends on
/// their number.
fn eigenvectors(coupling: &Mat<f64>) -> Option<(Vec<f64>, Mat<f64>)> {
    let size = coupling.ncols();
    let mut product = Mat::zeros(size, size);
    let (by, threads) = (coupling.transpose(), Par::Seq);
    matmul(product.as_mut(), Accum::Replace, by, coupling, 1.0, threads);
    let (mut values, mut vectors) = (Diag::zeros(size), Mat::zeros(size, size));
    let need =
        self_adjoint_evd_scratch::<f64>(size, ComputeEigenvectors::Yes, threads, Spec::default());
    let mut memory = MemBuffer::new(need);
    let found = self_adjoint_evd(
        product.as_ref(),
        values.as_mut(),
        Some(vectors.as_mut()),
        threads,
        MemStack::new(&mut memory),
        Spec::default(),
    );
    let values = values.column_vector().iter().copied().collect();
    found.ok().map(|()| (values, vectors))
}

#[cfg(test)]
mod tests {
    use nalgebra::{DVector, Vector3};

    use crate::linked::Mobility;
    use crate::multipole::{Accuracy, MultipoleMobility, Variant};
    use crate::{HydroError, Spheres};

    /// Two spheres off the axes; without their two highest orders, which preconditioners leave out.
    fn with_pair(check: impl Fn(&MultipoleMobility)) -> Result<(), HydroError> {
        let offset = Vector3::new(0.4, -1.3, 0.9).normalize() * 1.71;
        let spheres = Spheres::new(vec![Vector3::zeros(), offset], vec![1.0, 0.7])?;
        // the tolerance limits the orders, not the accuracy of soft flows
        let mut mobility = MultipoleMobility::new(&spheres, None, &Accuracy::relative(0.01), None)?;
        mobility.set_variant(Variant::Lowered);
        check(&mobility);
        Ok(())
    }

    #[test]
    fn soft_flows_of_two_spheres_are_eigenvectors_of_both() {
        with_pair(|mobility| {
            let n = mobility.dofs();
            let image = |x: &DVector<f64>| {
                let [_, image] = mobility.product(&DVector::zeros(12), x).unwrap();
                image
            };
            let gap = &mobility.preconditioner().gaps[0];
            assert!(gap.highest >= 2, "{}", gap.highest);
            for k in 0..gap.flows.len() {
                let mut unit = vec![0.0; gap.flows.len()];
                unit[k] = 1.0;
                let mut w = DVector::zeros(n);
                for end in 0..2 {
                    let (modes, first) = mobility.of_sphere(gap.ends[end]);
                    gap.add(&unit, end, modes, &mut w.as_mut_slice()[first..]);
                }
                // rounding of some hundred additions
                assert!((w.norm() - 1.0).abs() < 1e-12, "{}", w.norm());
                let weight = gap.flows[k].weight;
                let eigenvalue = 1.0 / (1.0 + weight);
                let m = gap.flows[k].m[0];
                let change = (image(&w) - &w * eigenvalue).amax();
                assert!(change < 1e-12, "m = {m}, {eigenvalue}: {change:.1e}");
                let mut inverse = w.clone();
                mobility.precondition_hidden(&mut inverse);
                let change = (inverse * eigenvalue - w).amax();
                assert!(change < 1e-12, "m = {m}, {eigenvalue}: {change:.1e}");
            }
        })
        .unwrap();
    }

    #[test]
    fn it_is_symmetric_and_larger_than_the_identity() {
        with_pair(|mobility| {
            let some = |number: f64| {
                DVector::from_fn(mobility.dofs(), |k, _| (number * (k * k + 1) as f64).sin())
            };
            let [x, y] = [some(1.3), some(0.7)];
            let [mx, my] = [&x, &y].map(|x| {
                let mut product = x.clone();
                mobility.precondition_hidden(&mut product);
                product
            });
            let size = mx.norm() * y.norm();
            assert!((mx.dot(&y) - x.dot(&my)).abs() < 1e-14 * size);
            assert!(mx.dot(&x) > x.dot(&x));
        })
        .unwrap();
    }
}
