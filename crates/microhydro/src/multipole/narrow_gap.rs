//! Narrow gaps off an axis: the high degrees of two close surfaces, eliminated for the pair alone.
//!
//! A gap of a hundredth of a radius needs orders of about 100. Modes of such a high degree act on
//! the other surface of the gap only: at a third sphere their flow is smaller by `e^(-ξ l)` with the
//! wide gap's coordinate `ξ`. Two surfaces have an axis, so their modes decouple by azimuthal
//! number. With the low degrees `k` (those of the expansions of the spheres) and the high ones `h`,
//! the Galerkin matrix of the low degrees becomes
//! ```text
//! A_kk + sum over narrow gaps -A_kh A_hh^(-1) A_hk
//! ```
//! which is exact for two spheres, and for more of them neglects the coupling of high degrees to
//! third spheres: its error falls with the order of the expansions of the spheres. Adding exact
//! two-sphere *resistances* (Durlofsky, Brady & Bossis 1987) is the case of no low degrees but the
//! rigid motions. The same holds for a sphere and its image in a wall, or the container around it.

use faer::Mat;
use nalgebra::DMatrix;
use rayon::prelude::*;

use super::collinear::{self, Dof, Sector};
use super::coupling::SymmetryClass;
use super::elimination::eliminate;
use super::frame::{Frame, Surroundings};
use super::modes::{FAMILIES, Modes};
use super::orders::Orders;
use super::rotation::Rotation;
use crate::{HydroError, Medium, Spheres};

/// Two surfaces of a narrow gap as an arrangement of their own.
pub(super) struct NarrowGap {
    /// The two spheres, or the sphere beside the boundary.
    pub spheres: Spheres,
    /// Their medium: without boundary for two spheres.
    pub medium: Medium,
    /// Indices of the spheres in the whole arrangement.
    pub indices: Vec<usize>,
    /// Orders of the gap.
    pub orders: Orders,
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
        let order = |index: usize| orders.spheres.get(index).copied().unwrap_or(orders.container);
        let mut all = Vec::new();
        for (&(first, second), &[of_first, of_second]) in &orders.gaps {
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
            let mut own = Orders::all(indices.len(), &medium, 0);
            let mut reach = vec![of_first.max(order(first)), of_second.max(order(second))];
            if second == n {
                own.container = match medium {
                    Medium::Ball { .. } => reach[1],
                    _ => 0,
                };
                reach.truncate(1);
            }
            own.spheres = reach;
            all.push(Self {
                spheres: Spheres::new(
                    indices.iter().map(|&k| spheres.centres()[k]).collect(),
                    indices.iter().map(|&k| spheres.radii()[k]).collect(),
                )?,
                medium,
                indices,
                orders: own,
            });
        }
        Ok(all)
    }

    /// Change of the Galerkin matrix by the elimination of the high degrees.
    ///
    /// For the low degrees of `orders`, in `frame`. Cost: `n^3/3` operations for each azimuthal
    /// number up to the highest low order, with three modes per degree and surface.
    ///
    /// # Errors
    /// [`HydroError::FactorisationFailed`].
    pub fn blocks(&self, frame: &Frame, orders: &Orders) -> Result<Vec<Block>, HydroError> {
        let own = Frame::of(&self.spheres, &self.medium);
        // expansions of the pair, in the whole system, with their low modes
        let mut expansions: Vec<(usize, Modes)> = self
            .indices
            .iter()
            .map(|&index| (index, Modes { order: orders.spheres[index] }))
            .collect();
        if matches!(own.surroundings, Surroundings::Ball(_)) {
            expansions.push((orders.spheres.len(), Modes { order: orders.container }));
        }
        let top = expansions.iter().map(|(_, modes)| modes.order).max();
        let top = top.unwrap_or_default();
        let sectors: Vec<(Vec<Dof>, DMatrix<f64>)> = (0..=top)
            .into_par_iter()
            .map(|m| self.sector(&own, m, &expansions))
            .collect::<Result<_, _>>()?;
        let to_own = own.to_axes * frame.to_axes.inverse();
        let rotation = Rotation::new(&to_own, top);
        let mut blocks = Vec::new();
        for (second, &(to, rows)) in expansions.iter().enumerate() {
            for (first, &(from, columns)) in expansions.iter().enumerate().take(second + 1) {
                let mut block = Mat::<f64>::zeros(rows.len(), columns.len());
                for (m, (dofs, change)) in sectors.iter().enumerate() {
                    for class in SymmetryClass::all(m).filter(|class| class.m == m) {
                        let place = |dof: &Dof, modes: Modes| {
                            let (row, sign) = class.row(dof.family, dof.l);
                            (modes.shell(dof.family, dof.l).start + row, sign)
                        };
                        for (j, source) in dofs.iter().enumerate() {
                            for (i, target) in dofs.iter().enumerate() {
                                if (source.expansion, target.expansion) == (first, second) {
                                    let (row, s) = place(target, rows);
                                    let (column, t) = place(source, columns);
                                    block[(row, column)] = s * t * change[(i, j)];
                                }
                            }
                        }
                    }
                }
                blocks.push(((from, to), rotated_back(block, &rotation, rows, columns)));
            }
        }
        Ok(blocks)
    }

    /// Low degrees of freedom of one azimuthal number, and the change of their Galerkin matrix.
    fn sector(
        &self,
        own: &Frame,
        m: usize,
        expansions: &[(usize, Modes)],
    ) -> Result<(Vec<Dof>, DMatrix<f64>), HydroError> {
        let sector = Sector {
            m,
            families: &FAMILIES,
        };
        let (mut dofs, mut low) = (Vec::new(), Vec::new());
        for (expansion, (_, modes)) in expansions.iter().enumerate() {
            for (family, l) in collinear::modes(expansion, &self.orders).sector(m) {
                let dof = Dof {
                    expansion,
                    family,
                    l,
                };
                match modes.contains(family, l) {
                    true => low.push(dof),
                    false => dofs.push(dof),
                }
            }
        }
        let high = dofs.len();
        dofs.extend(&low);
        let z: Vec<f64> = own.centres.iter().map(|x| x.z).collect();
        let radii = self.spheres.radii();
        let matrix = collinear::assemble(&sector, &z, radii, own.surroundings, &self.orders, &dofs);
        let before = DMatrix::from_fn(low.len(), low.len(), |i, j| {
            matrix[(high + i.max(j), high + i.min(j))]
        });
        let [after, _] = eliminate(matrix, low.len(), high)?;
        Ok((low, after - before))
    }
}

/// The block in the frame before the rotation: `D^T B D`, degree by degree.
fn rotated_back(mut block: Mat<f64>, rotation: &Rotation, rows: Modes, columns: Modes) -> Mat<f64> {
    for (family, l) in rows.shells() {
        let shell = rows.shell(family, l);
        let part = block.subrows(shell.start, shell.len());
        let turned = rotation.matrix(l).transpose() * part;
        block.subrows_mut(shell.start, shell.len()).copy_from(&turned);
    }
    for (family, l) in columns.shells() {
        let shell = columns.shell(family, l);
        let part = block.subcols(shell.start, shell.len());
        let turned = part * rotation.matrix(l);
        block.subcols_mut(shell.start, shell.len()).copy_from(&turned);
    }
    block
}
