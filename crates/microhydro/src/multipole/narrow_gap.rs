//! Narrow gaps off an axis: the high degrees of two close surfaces, eliminated for the pair alone.
//!
//! A gap of a hundredth of a radius needs orders of about 100. Modes of such a high degree act on
//! the other surface of the gap only: at a third sphere their flow is smaller by `e^(-ξ l)` with
//! the wide gap's coordinate `ξ`. Two surfaces have an axis, so their modes decouple by azimuthal
//! number. With the low degrees `k` (those of the expansions of the spheres) and the high ones `h`,
//! the Galerkin matrix of the low degrees becomes
//! ```text
//! A_kk + sum over narrow gaps -A_kh A_hh^(-1) A_hk
//! ```
//! which is exact for two spheres, and for more of them neglects the coupling of high degrees to
//! third spheres: its error falls with the order of the expansions of the spheres. Adding exact
//! two-sphere *resistances* (Durlofsky, Brady & Bossis 1987) is the case of no low degrees but the
//! rigid motions. The same holds for a sphere and its image in a wall, or the container around it.
//! All surfaces on one axis can be treated as one gap: then nothing is neglected.

use faer::Mat;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::collinear::{self, Dof, Sector};
use super::coupling::SymmetryClass;
use super::elimination::GalerkinFactor;
use super::frame::{Frame, Surroundings};
use super::modes::{FAMILIES, Family, Modes};
use super::orders::{GapOrders, Orders};
use super::rotation::Rotation;
use crate::{HydroError, Medium, Spheres};

/// Two surfaces of a narrow gap as an arrangement of their own, or all surfaces on one axis.
pub(super) struct NarrowGap {
    /// The spheres, or the sphere beside the boundary.
    pub spheres: Spheres,
    /// Their medium: without boundary for two spheres.
    pub medium: Medium,
    /// Indices of the spheres in the whole arrangement.
    pub indices: Vec<usize>,
    /// Orders of the gap for the azimuthal numbers 0 and 1.
    pub orders: Orders,
    /// Orders of the gap for higher azimuthal numbers.
    regular: Orders,
}

/// Matrix from the modes of one expansion (columns) to those of another one (rows).
pub(super) type Block = ((usize, usize), Mat<f64>);

impl NarrowGap {
    /// All narrow gaps whose orders exceed those of the spheres.
    ///
    /// # Errors
    /// None for an arrangement that [`Spheres::new`] accepted.
    pub fn all(
        spheres: &Spheres,
        medium: &Medium,
        orders: &Orders,
    ) -> Result<Vec<Self>, HydroError> {
        let n = spheres.len();
        let order = |index: usize| orders.of_expansion(index);
        let mut all = Vec::new();
        for (&(first, second), gap) in &orders.gaps {
            let [of_first, of_second] = gap.singular;
            let beyond = of_first > order(first) || of_second > order(second);
            if first >= n || second > n || !beyond {
                continue;
            }
            let indices = match second == n {
                true => vec![first],
                false => vec![first, second],
            };
            let medium = match second == n {
                true => *medium,
                false => Medium::Unbounded,
            };
            if second == n && medium == Medium::Unbounded {
                continue;
            }
            // at least the orders outside the gap
            let reach = |gap: [usize; 2]| {
                let [of_first, of_second] = [gap[0].max(order(first)), gap[1].max(order(second))];
                let mut own = Orders::all(indices.len(), &medium, 0);
                own.spheres = vec![of_first; indices.len()];
                match medium {
                    Medium::Unbounded => own.spheres[1] = of_second,
                    Medium::Ball { .. } => own.container = of_second,
                    Medium::Wall { .. } => {}
                }
                own
            };
            let (own, regular) = (reach(gap.singular), reach(gap.regular));
            all.push(Self {
                spheres: Spheres::new(
                    indices.iter().map(|&k| spheres.centres()[k]).collect(),
                    indices.iter().map(|&k| spheres.radii()[k]).collect(),
                )?,
                medium,
                indices,
                orders: own,
                regular,
            });
        }
        Ok(all)
    }

    /// All spheres of an arrangement on one axis, beside expansions of the order `low`, which the
    /// orders of the gaps replace where they are higher.
    pub fn on_axis(spheres: &Spheres, medium: &Medium, orders: &Orders, low: &Orders) -> Self {
        let reach =
            |of: fn(&GapOrders) -> [usize; 2]| orders.with_gaps_in_expansions(of).at_least(low);
        Self {
            spheres: spheres.clone(),
            medium: *medium,
            indices: (0..spheres.len()).collect(),
            orders: reach(|gap| gap.singular),
            regular: reach(|gap| gap.regular),
        }
    }

    /// Changes of the Galerkin matrix by the `wanted` eliminations of the high degrees, in `frame`.
    ///
    /// Azimuthal numbers about the axis of the gap above `highest` are left out: flows that are
    /// symmetric about this axis do not contain them.
    ///
    /// Cost: `n^3/3` operations for each azimuthal number up to the highest low order, with three
    /// modes per degree and surface.
    ///
    /// # Errors
    /// [`HydroError::FactorisationFailed`].
    pub fn blocks<const N: usize>(
        &self,
        frame: &Frame,
        orders: &Orders,
        highest: usize,
        wanted: [Eliminated; N],
    ) -> Result<[Vec<Block>; N], HydroError> {
        let own = Frame::new(&self.spheres, &self.medium);
        let low = self.low_modes(orders, own.surroundings);
        let lowered = self.low_modes(&orders.lowered(), own.surroundings);
        let top = low.iter().map(|(_, modes)| modes.order).max();
        let top = top.unwrap_or_default();
        let sectors: Vec<[Change; N]> = (0..=top.min(highest))
            .into_par_iter()
            .map(|m| self.sector(&own, m, &low, &lowered, wanted))
            .collect::<Result<_, _>>()?;
        let rotation = Rotation::new(&(own.to_axes * frame.to_axes.inverse()), top);
        Ok(std::array::from_fn(|k| {
            let expansions = match wanted[k] {
                Eliminated::LoweredExpansions => &lowered,
                Eliminated::All | Eliminated::LoweredGap => &low,
            };
            let changes = sectors.iter().map(|sector| &sector[k]);
            blocks(expansions, changes, &rotation)
        }))
    }

    /// Expansions of the two surfaces, by their indices in the whole system, with their low modes.
    fn low_modes(&self, orders: &Orders, surroundings: Surroundings) -> Vec<(usize, Modes)> {
        let spheres = self.indices.iter().map(|&k| (k, orders.spheres[k]));
        let container = match surroundings {
            Surroundings::Ball(_) => Some((orders.spheres.len(), orders.container)),
            _ => None,
        };
        let all = spheres.chain(container);
        all.map(|(index, order)| (index, Modes { order })).collect()
    }

    /// Changes of one azimuthal number, by each of the `wanted` eliminations.
    fn sector<const N: usize>(
        &self,
        own: &Frame,
        m: usize,
        low: &[(usize, Modes)],
        lowered: &[(usize, Modes)],
        wanted: [Eliminated; N],
    ) -> Result<[Change; N], HydroError> {
        let sector = Sector {
            m,
            families: &FAMILIES,
        };
        let orders = if m < 2 { &self.orders } else { &self.regular };
        // the highest degrees come last among the high ones
        let is_highest = |expansion: usize, family: Family, l: usize| {
            !collinear::modes(expansion, orders).in_lower_order(family, l)
        };
        // high degrees, then those between the two low orders, then the lower ones
        let mut stages: [Vec<Dof>; 4] = Default::default();
        for expansion in 0..low.len() {
            for (family, l) in collinear::modes(expansion, orders).sector(m) {
                let contains = |modes: &[(usize, Modes)]| modes[expansion].1.contains(family, l);
                let stage = match (contains(low), contains(lowered)) {
                    (false, _) => usize::from(is_highest(expansion, family, l)),
                    (true, false) => 2,
                    (true, true) => 3,
                };
                stages[stage].push(Dof {
                    expansion,
                    family,
                    l,
                });
            }
        }
        let last = stages[0].len()..stages[0].len() + stages[1].len();
        let (high, between) = (last.end, stages[2].len());
        let dofs = stages.concat();
        let z: Vec<f64> = own.centres.iter().map(|x| x.z).collect();
        let radii = self.spheres.radii();
        let matrix = collinear::assemble(&sector, &z, radii, own.surroundings, orders, &dofs);
        let rows = dofs.len() - high;
        let before = DMatrix::from_fn(rows, rows, |i, j| {
            matrix[(high + i.max(j), high + i.min(j))]
        });
        let factor = GalerkinFactor::new(matrix)?;
        let of_all = |complement: DMatrix<f64>| Change {
            matrix: complement - &before,
            dofs: dofs[high..].to_vec(),
        };
        Ok(wanted.map(|wanted| match wanted {
            Eliminated::All => of_all(factor.complement(rows)),
            Eliminated::LoweredExpansions => {
                let rows = rows - between;
                let before = before.view((between, between), (rows, rows));
                Change {
                    matrix: factor.complement(rows) - before,
                    dofs: stages[3].clone(),
                }
            }
            Eliminated::LoweredGap => {
                of_all(factor.complement(rows) + factor.omitted(rows, last.clone()))
            }
        }))
    }
}

/// High degrees that are eliminated from the matrix of the low ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Eliminated {
    /// Those above the low orders.
    All,
    /// Those above the low orders of [`Orders::lowered`].
    LoweredExpansions,
    /// Those above the low orders, without the two highest orders of the gap.
    LoweredGap,
}

/// Change of the Galerkin matrix of the low modes with one azimuthal number.
struct Change {
    matrix: DMatrix<f64>,
    dofs: Vec<Dof>,
}

/// Blocks of all azimuthal numbers, before the rotation to the axis of the gap.
fn blocks<'a>(
    expansions: &[(usize, Modes)],
    sectors: impl Iterator<Item = &'a Change> + Clone,
    rotation: &Rotation,
) -> Vec<Block> {
    let mut blocks = Vec::new();
    for (second, &(to, rows)) in expansions.iter().enumerate() {
        for (first, &(from, columns)) in expansions.iter().enumerate().take(second + 1) {
            let mut block = Mat::<f64>::zeros(rows.len(), columns.len());
            for (m, change) in sectors.clone().enumerate() {
                for class in SymmetryClass::of_azimuthal_number(m) {
                    let places = |expansion: usize, modes: Modes| -> Vec<(usize, usize, f64)> {
                        let own = change.dofs.iter().enumerate();
                        own.filter(|(_, dof)| dof.expansion == expansion)
                            .map(|(index, dof)| {
                                let (row, sign) = class.row(dof.family, dof.l);
                                (index, modes.shell(dof.family, dof.l).start + row, sign)
                            })
                            .collect()
                    };
                    for (j, column, t) in places(first, columns) {
                        for (i, row, s) in places(second, rows) {
                            block[(row, column)] = s * t * change.matrix[(i, j)];
                        }
                    }
                }
            }
            blocks.push(((from, to), rotated_back(block, rotation, rows, columns)));
        }
    }
    blocks
}

/// The block in the frame before the rotation: `D^T B D`, degree by degree.
fn rotated_back(mut block: Mat<f64>, rotation: &Rotation, rows: Modes, columns: Modes) -> Mat<f64> {
    for (family, l) in rows.shells() {
        let shell = rows.shell(family, l);
        let part = block.subrows(shell.start, shell.len());
        let turned = rotation.matrix(l).transpose() * part;
        block
            .subrows_mut(shell.start, shell.len())
            .copy_from(&turned);
    }
    for (family, l) in columns.shells() {
        let shell = columns.shell(family, l);
        let part = block.subcols(shell.start, shell.len());
        let turned = part * rotation.matrix(l);
        block
            .subcols_mut(shell.start, shell.len())
            .copy_from(&turned);
    }
    block
}
