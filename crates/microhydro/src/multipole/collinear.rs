//! Spheres on an axis of symmetry of their medium.
//!
//! The unknowns decouple by azimuthal number, and rigid motions have only `m = 0` and `m = 1`.

use faer::Mat;

use super::axial_translation::{InteriorTranslation, OutgoingTranslation};
use super::elimination::eliminate;
use super::frame::Surroundings;
use super::lamb::{LambCoefficients, trace_index};
use super::modes::{FAMILIES, Family, Modes};
use super::orders::Orders;
use super::reflection::image;
use super::scaled::ScaledMobility;
use crate::HydroError;

/// Families and azimuthal number of modes that couple to each other.
pub(super) struct Sector {
    pub m: usize,
    pub families: &'static [Family],
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
pub(super) struct Dof {
    pub expansion: usize,
    pub family: Family,
    pub l: usize,
}

/// Scaled mobility matrices of spheres at heights `z` on the axis.
///
/// For the given orders and for orders lower by two.
///
/// Cost: `O((n L)^3)` for `n` spheres of order `L`, with a small constant: the largest sector has
/// `3 n L` degrees of freedom.
pub(crate) fn mobility(
    z: &[f64],
    radii: &[f64],
    surroundings: Surroundings,
    orders: &Orders,
) -> Result<ScaledMobility, HydroError> {
    let n = z.len();
    let mut scaled = ScaledMobility::zeros(n);
    for sector in &SECTORS {
        let dofs = dofs(sector, surroundings, orders);
        let matrix = assemble(sector, z, radii, surroundings, orders, &dofs);
        let lower = dofs
            .iter()
            .take_while(|u| elimination_stage(u, orders) == 0)
            .count();
        let rigid: Vec<Dof> = dofs
            .into_iter()
            .filter(|u| elimination_stage(u, orders) == 2)
            .collect();
        let [full, lower] = eliminate(matrix, rigid.len(), lower)?;
        for (i, a) in rigid.iter().enumerate() {
            for (j, b) in rigid.iter().enumerate() {
                // m = 0 is the second of the three modes of degree 1. m = 1 occurs with the cosine
                // and with the sine; rotlets belong to the opposite symmetry class and change sign.
                let classes: &[i32] = if sector.m == 0 { &[0] } else { &[1, -1] };
                for &class in classes {
                    let at = |u: &Dof| {
                        let rotlet = u.family == Family::Rotlet;
                        let m = if rotlet { -class } else { class };
                        let sign = if rotlet && class < 0 { -1.0 } else { 1.0 };
                        (
                            6 * u.expansion + 3 * usize::from(rotlet) + (m + 1) as usize,
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

pub(super) fn modes(expansion: usize, orders: &Orders) -> Modes {
    Modes {
        order: orders.of_expansion(expansion),
    }
}

/// Position in the elimination: modes of the lower order, then the others, then the rigid motions,
/// which are kept.
fn elimination_stage(u: &Dof, orders: &Orders) -> usize {
    let rigid = u.expansion < orders.spheres.len() && u.l == 1 && u.family != Family::Source;
    match (
        rigid,
        modes(u.expansion, orders).in_lower_order(u.family, u.l),
    ) {
        (true, _) => 2,
        (false, true) => 0,
        (false, false) => 1,
    }
}

fn dofs(sector: &Sector, surroundings: Surroundings, orders: &Orders) -> Vec<Dof> {
    let expansions =
        orders.spheres.len() + usize::from(matches!(surroundings, Surroundings::Ball(_)));
    let mut all: Vec<Dof> = (0..expansions)
        .flat_map(|expansion| {
            modes(expansion, orders)
                .sector(sector.m)
                .into_iter()
                .filter(|(family, _)| sector.families.contains(family))
                .map(move |(family, l)| Dof {
                    expansion,
                    family,
                    l,
                })
        })
        .collect();
    all.sort_by_key(|u| elimination_stage(u, orders));
    all
}

/// Symmetric matrix of a sector, in the lower triangle.
///
/// Ones on the diagonal, couplings below it; the upper triangle stays zero.
pub(super) fn assemble(
    sector: &Sector,
    z: &[f64],
    radii: &[f64],
    surroundings: Surroundings,
    orders: &Orders,
    dofs: &[Dof],
) -> Mat<f64> {
    let mut assembly = Assembly::new(sector.m, z, radii, surroundings, orders, dofs);
    for j in 0..z.len() {
        for i in 0..j {
            assembly.add_pair(i, j);
        }
        match surroundings {
            Surroundings::Unbounded => {}
            Surroundings::Ball(radius) => assembly.add_container(j, radius),
            Surroundings::Wall => (0..=j).for_each(|i| assembly.add_image(i, j)),
        }
    }
    assembly.matrix
}

/// The matrix of a sector while its couplings are added.
struct Assembly<'a> {
    m: usize,
    z: &'a [f64],
    radii: &'a [f64],
    orders: &'a Orders,
    /// Square root of the self energy of each mode.
    weights: Vec<f64>,
    /// For each expansion: degree and index of its modes, by family.
    by_family: Vec<[Vec<(usize, usize)>; 3]>,
    matrix: Mat<f64>,
}

impl<'a> Assembly<'a> {
    fn new(
        m: usize,
        z: &'a [f64],
        radii: &'a [f64],
        surroundings: Surroundings,
        orders: &'a Orders,
        dofs: &[Dof],
    ) -> Self {
        let container = match surroundings {
            Surroundings::Ball(radius) => radius,
            _ => f64::NAN,
        };
        let radius = |expansion: usize| radii.get(expansion).copied().unwrap_or(container);
        let weight = |u: &Dof| u.family.energy(u.l, radius(u.expansion)).sqrt();
        let mut by_family = vec![[const { Vec::new() }; 3]; z.len() + 1];
        for (index, u) in dofs.iter().enumerate() {
            by_family[u.expansion][trace_index(u.family)].push((u.l, index));
        }
        Self {
            m,
            z,
            radii,
            orders,
            weights: dofs.iter().map(weight).collect(),
            by_family,
            matrix: Mat::identity(dofs.len(), dofs.len()),
        }
    }

    /// Highest degree of an expansion.
    fn top(&self, expansion: usize) -> usize {
        self.orders.of_expansion(expansion)
    }

    /// Adds the coupling of two expansions: `flow` are the coefficients about the second one of a
    /// mode of the first, `sign` is a factor of each mode.
    fn couple(
        &mut self,
        (from, to): (usize, usize),
        flow: &dyn Fn(Family, usize) -> Vec<LambCoefficients>,
        sign: &dyn Fn(Family, usize) -> f64,
    ) {
        for family in FAMILIES {
            for &(l, source) in &self.by_family[from][trace_index(family)] {
                let regular = flow(family, l);
                for other in FAMILIES {
                    for &(k, target) in &self.by_family[to][trace_index(other)] {
                        let value = regular[k].trace(k)[trace_index(other)] * self.weights[target]
                            / self.weights[source]
                            * sign(family, l)
                            * sign(other, k);
                        let (row, column) = (source.max(target), source.min(target));
                        // The image of a sphere in the wall couples the sphere to itself: each pair
                        // of modes occurs twice.
                        if from != to || target >= source {
                            self.matrix[(row, column)] += value;
                        }
                    }
                }
            }
        }
    }

    /// Adds the coupling of two spheres.
    fn add_pair(&mut self, i: usize, j: usize) {
        let (z, radii, m) = (self.z, self.radii, self.m);
        let (low, high) = if z[i] < z[j] { (i, j) } else { (j, i) };
        let (top_low, top_high) = (self.top(low), self.top(high));
        let pair = OutgoingTranslation::new(
            m,
            (radii[low], top_low),
            (radii[high], top_high),
            z[high] - z[low],
        );
        let flow = |f: Family, l: usize| {
            coefficients_by_degree(m, top_high, |k| pair.coefficients(f, l, k))
        };
        self.couple((low, high), &flow, &|_, _| 1.0);
    }

    /// Adds the coupling of a sphere and the container.
    fn add_container(&mut self, j: usize, radius: f64) {
        let (z, radii, m) = (self.z, self.radii, self.m);
        let top = self.top(j);
        let interior = InteriorTranslation::new(
            m,
            (radius, self.orders.container),
            (radii[j], top),
            z[j].abs(),
        );
        // below the centre, the axis points the other way
        let sign = |f: Family, l: usize| if z[j] < 0.0 { f.parity(l, m) } else { 1.0 };
        let flow = |f: Family, k: usize| {
            coefficients_by_degree(m, top, |l| interior.coefficients(f, k, l))
        };
        self.couple((z.len(), j), &flow, &sign);
    }

    /// Adds the coupling of the image of sphere `i` in the wall and sphere `j`.
    fn add_image(&mut self, i: usize, j: usize) {
        let (z, radii, m) = (self.z, self.radii, self.m);
        let top = self.top(j);
        let reflected =
            OutgoingTranslation::new(m, (radii[i], self.top(i)), (radii[j], top + 2), z[i] + z[j]);
        let flow = |f: Family, l: usize| {
            let reflected_flow = coefficients_by_degree(m, top + 2, |k| {
                reflected.coefficients(f, l, k).scaled(f.parity(l, m))
            });
            image(&reflected_flow, m as i32, z[j] / radii[j], top)
        };
        self.couple((i, j), &flow, &|_, _| 1.0);
    }
}

/// Coefficients of degrees `0 ..= top`; zero for degree 0 and degrees below `m`.
pub(super) fn coefficients_by_degree(
    m: usize,
    top: usize,
    of: impl Fn(usize) -> LambCoefficients,
) -> Vec<LambCoefficients> {
    (0..=top)
        .map(|k| {
            if k >= m.max(1) {
                of(k)
            } else {
                LambCoefficients::default()
            }
        })
        .collect()
}
