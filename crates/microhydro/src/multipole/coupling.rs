//! Coupling of two expansions at any relative position.
//!
//! The coefficients are rotated onto the line of centres, where the coupling decouples by azimuthal
//! number.

use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use nalgebra::Vector3;

use super::axial_translation::{InteriorTranslation, OutgoingTranslation};
use super::lamb::{LambCoefficients, trace_index};
use super::modes::{Family, Modes};
use super::rotation::{Rotation, rotation_to_z};
use super::truncation;

/// Expansion on the surface of a sphere or of the container.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Expansion {
    pub radius: f64,
    pub modes: Modes,
}

impl Expansion {
    /// Square root of the self energy of a mode.
    ///
    /// Scaling the degrees of freedom by it makes the diagonal of the system one.
    pub fn weight(&self, family: Family, l: usize) -> f64 {
        family.energy(l, self.radius).sqrt()
    }

    /// The same expansion, limited to an order.
    fn up_to(&self, order: usize) -> Self {
        Self {
            modes: Modes {
                order: self.modes.order.min(order),
            },
            ..*self
        }
    }
}

/// Modes of one azimuthal number and one symmetry under reflection of the azimuth, `φ -> -φ`.
///
/// One class has `W` and `V` with the cosine and `X` with the sine, the other one the reverse.
/// Flows of different classes do not couple along the axis.
#[derive(Clone, Copy)]
pub(crate) struct SymmetryClass {
    pub m: usize,
    pub cosine: bool,
}

impl SymmetryClass {
    /// All classes up to an azimuthal number.
    pub fn all(top: usize) -> impl Iterator<Item = Self> {
        (0..=top).flat_map(Self::of_azimuthal_number)
    }

    /// The classes of an azimuthal number; `m = 0` has one only.
    pub fn of_azimuthal_number(m: usize) -> impl Iterator<Item = Self> {
        [true, false]
            .into_iter()
            .filter(move |&cosine| cosine || m > 0)
            .map(move |cosine| Self { m, cosine })
    }

    /// Row of a mode of this class among the `2l + 1` modes of its family and degree, and its sign.
    ///
    /// With the sign, both classes have the same coupling matrix.
    pub fn row(self, family: Family, l: usize) -> (usize, f64) {
        let rotlet = family == Family::Rotlet;
        let row = if self.cosine == rotlet {
            l - self.m
        } else {
            l + self.m
        };
        (row, if rotlet && !self.cosine { -1.0 } else { 1.0 })
    }

    /// Rows and signs of all modes of this class, in the order of [`Modes::sector`].
    pub fn rows(self, modes: Modes) -> Vec<(usize, f64)> {
        modes
            .sector(self.m)
            .into_iter()
            .map(|(family, l)| {
                let (row, sign) = self.row(family, l);
                (modes.shell(family, l).start + row, sign)
            })
            .collect()
    }
}

/// Coupling of two expansions, stored along their line of centres.
///
/// Its transpose is the coupling in the opposite direction.
#[derive(Clone, Debug)]
pub(crate) struct Coupling {
    /// Indices of the source and of the target.
    pub pair: (usize, usize),
    /// Modes of source and target that the coupling includes.
    used_modes: (Modes, Modes),
    /// All modes of source and target.
    all_modes: (Modes, Modes),
    rotation: Rotation,
    /// One matrix per azimuthal number: columns are the modes of the source, rows those of the
    /// target, in the order of [`Modes::sector`].
    sectors: Vec<Mat<f64>>,
}

impl Coupling {
    /// Coupling of two spheres at `offset`.
    ///
    /// Contains only the modes that an accuracy of `tolerance` requires at this distance.
    pub fn between_spheres(
        pair: (usize, usize),
        (from, to): (&Expansion, &Expansion),
        offset: &Vector3<f64>,
        tolerance: f64,
    ) -> Self {
        let all_modes = (from.modes, to.modes);
        let needed = truncation::for_pair(offset.norm(), from.radius, to.radius, tolerance);
        let (from, to) = (&from.up_to(needed.0), &to.up_to(needed.1));
        let sector = |m| axial_coupling([from, to], offset.norm(), m);
        Self::new(pair, from, to, offset, all_modes, sector)
    }

    /// Coupling of the container with a sphere at `offset` from its centre.
    pub fn with_container(
        pair: (usize, usize),
        from: &Expansion,
        to: &Expansion,
        offset: &Vector3<f64>,
    ) -> Self {
        let sector = |m: usize| {
            let interior = InteriorTranslation::new(
                m,
                (from.radius, from.modes.order),
                (to.radius, to.modes.order),
                offset.norm(),
            );
            weighted([from, to], m, |f, k, l| interior.coefficients(f, k, l))
        };
        Self::new(pair, from, to, offset, (from.modes, to.modes), sector)
    }

    fn new(
        pair: (usize, usize),
        from: &Expansion,
        to: &Expansion,
        offset: &Vector3<f64>,
        all_modes: (Modes, Modes),
        sector: impl Fn(usize) -> Mat<f64>,
    ) -> Self {
        let top = from.modes.order.min(to.modes.order);
        Self {
            pair,
            used_modes: (from.modes, to.modes),
            all_modes,
            rotation: Rotation::new(&rotation_to_z(offset), from.modes.order.max(to.modes.order)),
            sectors: (0..=top).map(sector).collect(),
        }
    }

    /// Dense matrix of the coupling, from all modes of the source to all modes of the target.
    pub fn dense(&self) -> Mat<f64> {
        let (from, to) = (self.all_modes.0.len(), self.all_modes.1.len());
        // fewer columns pass through the rotations
        let backward = to < from;
        let mut matrix = Mat::zeros(from.max(to), from.min(to));
        let columns = Mat::identity(from.min(to), from.min(to));
        self.add(columns.as_ref(), matrix.as_mut(), backward);
        match backward {
            false => matrix,
            true => matrix.transpose().to_owned(),
        }
    }

    /// Adds the coupling times the coefficients `x` of the source to those of the target, `y`.
    ///
    /// `backward` exchanges source and target.
    pub fn add(&self, x: MatRef<f64>, mut y: MatMut<f64>, backward: bool) {
        let ([source, target], [from, to]) = match backward {
            false => (
                [self.used_modes.0, self.used_modes.1],
                [self.all_modes.0, self.all_modes.1],
            ),
            true => (
                [self.used_modes.1, self.used_modes.0],
                [self.all_modes.1, self.all_modes.0],
            ),
        };
        let columns = x.ncols();
        let mut rotated = Mat::zeros(source.len(), columns);
        for (family, l) in source.shells() {
            multiply(
                rows_mut(rotated.as_mut(), source.shell(family, l)),
                Accum::Replace,
                self.rotation.matrix(l),
                x.subrows(from.shell(family, l).start, 2 * l + 1),
            );
        }
        let mut result = Mat::<f64>::zeros(target.len(), columns);
        for class in SymmetryClass::all(source.order.min(target.order)) {
            let (source_rows, target_rows) = (class.rows(source), class.rows(target));
            let gathered = Mat::from_fn(source_rows.len(), columns, |i, j| {
                source_rows[i].1 * rotated[(source_rows[i].0, j)]
            });
            let matrix = match backward {
                false => self.sectors[class.m].as_ref(),
                true => self.sectors[class.m].transpose(),
            };
            let mut product = Mat::zeros(target_rows.len(), columns);
            multiply(product.as_mut(), Accum::Replace, matrix, gathered.as_ref());
            for j in 0..columns {
                for (i, &(row, sign)) in target_rows.iter().enumerate() {
                    result[(row, j)] = sign * product[(i, j)];
                }
            }
        }
        for (family, l) in target.shells() {
            multiply(
                rows_mut(y.rb_mut(), to.shell(family, l)),
                Accum::Add,
                self.rotation.matrix(l).transpose(),
                result
                    .as_ref()
                    .subrows(target.shell(family, l).start, 2 * l + 1),
            );
        }
    }
}

/// Coupling of the modes of azimuthal number `m` of two spheres on an axis: columns are the modes
/// of the source, rows those of the target, in the order of [`Modes::sector`].
pub(super) fn axial_coupling(ends: [&Expansion; 2], distance: f64, m: usize) -> Mat<f64> {
    let [from, to] = ends.map(|end| (end.radius, end.modes.order));
    let outgoing = OutgoingTranslation::new(m, from, to, distance);
    weighted(ends, m, |f, l, k| outgoing.coefficients(f, l, k))
}

/// Matrix of an azimuthal number from the coefficients of its translation, in the scaled modes.
fn weighted(
    [from, to]: [&Expansion; 2],
    m: usize,
    coefficients: impl Fn(Family, usize, usize) -> LambCoefficients,
) -> Mat<f64> {
    let (sources, targets) = (from.modes.sector(m), to.modes.sector(m));
    let mut matrix = Mat::zeros(targets.len(), sources.len());
    for (column, &(family, l)) in sources.iter().enumerate() {
        let weight = 1.0 / from.weight(family, l);
        // All families of one degree come from the same coefficients, but are not adjacent.
        let mut traces = vec![None; to.modes.order + 1];
        for (row, &(other, k)) in targets.iter().enumerate() {
            let trace = *traces[k].get_or_insert_with(|| coefficients(family, l, k).trace(k));
            matrix[(row, column)] = trace[trace_index(other)] * weight * to.weight(other, k);
        }
    }
    matrix
}

fn rows_mut(matrix: MatMut<'_, f64>, rows: std::ops::Range<usize>) -> MatMut<'_, f64> {
    matrix.subrows_mut(rows.start, rows.len())
}

fn multiply(y: MatMut<f64>, accum: Accum, a: MatRef<f64>, x: MatRef<f64>) {
    matmul(y, accum, a, x, 1.0, Par::Seq);
}
