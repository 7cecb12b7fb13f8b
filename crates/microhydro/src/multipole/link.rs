//! The coupling of two bodies anywhere in space: rotated onto the axis between them, where it decouples by azimuthal number.

use faer::linalg::matmul::matmul;
use faer::prelude::ReborrowMut;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use nalgebra::{DMatrix, UnitQuaternion, Vector3};

use super::axial::{Interior, Outgoing};
use super::lamb::{Lamb, place};
use super::modes::{Family, Modes};
use super::order;
use super::rotation::Rotation;

/// A sphere or the container, with the modes of its expansion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body {
    pub radius: f64,
    pub modes: Modes,
}

impl Body {
    /// Square root of a mode's self energy: the unknowns are scaled by it, which makes the diagonal of the system one.
    pub fn weight(&self, family: Family, l: usize) -> f64 {
        family.energy(l, self.radius).sqrt()
    }

    /// The same body with its modes cut at an order.
    fn up_to(&self, order: usize) -> Self {
        Self {
            modes: Modes {
                order: self.modes.order.min(order),
            },
            ..*self
        }
    }
}

/// Half of the modes of an azimuthal number: those with the cosine ($X$ with the sine), or the other way round.
#[derive(Clone, Copy)]
pub(crate) struct Half {
    pub m: usize,
    pub cosine: bool,
}

impl Half {
    /// All halves up to an azimuthal number; there is one for `m` = 0.
    pub fn all(top: usize) -> impl Iterator<Item = Self> {
        (0..=top).flat_map(|m| {
            [true, false]
                .into_iter()
                .filter(move |&cosine| cosine || m > 0)
                .map(move |cosine| Self { m, cosine })
        })
    }

    /// Row of a mode of this half within its shell, and the sign that makes the sine half look like the cosine half.
    pub fn row(self, family: Family, l: usize) -> (usize, f64) {
        let rotlet = family == Family::Rotlet;
        let row = if self.cosine == rotlet {
            l - self.m
        } else {
            l + self.m
        };
        (row, if rotlet && !self.cosine { -1.0 } else { 1.0 })
    }

    /// The same for all modes of a body in this half, as [`Modes::sector`] lists them.
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

/// Takes `offset` to the z axis.
pub(crate) fn onto_axis(offset: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between(offset, &Vector3::z()).unwrap_or_else(|| {
        // opposite, or no direction at all, which any turn serves
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    })
}

/// The coupling from one body to another that lies in a direction called the axis; transposed, the other way round.
#[derive(Clone, Debug)]
pub(crate) struct Link {
    /// The bodies: from, to.
    pub ends: (usize, usize),
    /// The modes of the two ends that the coupling takes.
    modes: (Modes, Modes),
    /// All modes of the two ends.
    places: (Modes, Modes),
    rotation: Rotation,
    /// One matrix an azimuthal number: from the modes of one body to those of the other, both as [`Modes::sector`] lists them.
    sectors: Vec<Mat<f64>>,
}

impl Link {
    /// From one sphere to another at `offset`, with no more modes than matter at that distance to `tolerance`.
    pub fn between(
        ends: (usize, usize),
        (from, to): (&Body, &Body),
        offset: &Vector3<f64>,
        tolerance: f64,
    ) -> Self {
        let places = (from.modes, to.modes);
        let needed = order::of_pair(offset.norm(), from.radius, to.radius, tolerance);
        let from = &from.up_to(needed.0);
        let to = &to.up_to(needed.1);
        Self::new(ends, from, to, offset, places, |m, distance| {
            let pair = Outgoing::new(
                m,
                (from.radius, from.modes.order),
                (to.radius, to.modes.order),
                distance,
            );
            move |f, l, k| pair.lamb(f, l, k)
        })
    }

    /// From the container to a sphere at `offset` from its centre.
    pub fn inside(ends: (usize, usize), from: &Body, to: &Body, offset: &Vector3<f64>) -> Self {
        Self::new(
            ends,
            from,
            to,
            offset,
            (from.modes, to.modes),
            |m, distance| {
                let within = Interior::new(
                    m,
                    (from.radius, from.modes.order),
                    (to.radius, to.modes.order),
                    distance,
                );
                move |f, k, l| within.lamb(f, k, l)
            },
        )
    }

    fn new<F: Fn(Family, usize, usize) -> Lamb>(
        ends: (usize, usize),
        from: &Body,
        to: &Body,
        offset: &Vector3<f64>,
        places: (Modes, Modes),
        flow: impl Fn(usize, f64) -> F,
    ) -> Self {
        let top = from.modes.order.min(to.modes.order);
        let sectors = (0..=top)
            .map(|m| {
                let lamb = flow(m, offset.norm());
                let (sources, targets) = (from.modes.sector(m), to.modes.sector(m));
                let mut matrix = Mat::zeros(targets.len(), sources.len());
                for (column, &(family, l)) in sources.iter().enumerate() {
                    let weight = 1.0 / from.weight(family, l);
                    // all families of one degree come from the same coefficients, but lie apart
                    let mut traces = vec![None; to.modes.order + 1];
                    for (row, &(other, k)) in targets.iter().enumerate() {
                        let trace = *traces[k].get_or_insert_with(|| lamb(family, l, k).trace(k));
                        matrix[(row, column)] = trace[place(other)] * weight * to.weight(other, k);
                    }
                }
                matrix
            })
            .collect();
        Self {
            ends,
            modes: (from.modes, to.modes),
            places,
            rotation: Rotation::new(&onto_axis(offset), from.modes.order.max(to.modes.order)),
            sectors,
        }
    }

    /// The coupling as a matrix from all modes of the first end to all of the second.
    pub fn dense(&self) -> Mat<f64> {
        let (from, to) = (self.places.0.len(), self.places.1.len());
        let mut matrix = Mat::zeros(to, from);
        self.add(Mat::identity(from, from).as_ref(), matrix.as_mut(), false);
        matrix
    }

    /// Adds the coupling times the unknowns `x` of one end to `y` of the other; `backward` is from the second end to the first.
    pub fn add(&self, x: MatRef<f64>, mut y: MatMut<f64>, backward: bool) {
        let ([source, target], [from, to]) = match backward {
            false => ([self.modes.0, self.modes.1], [self.places.0, self.places.1]),
            true => ([self.modes.1, self.modes.0], [self.places.1, self.places.0]),
        };
        let columns = x.ncols();
        let mut turned = Mat::zeros(source.len(), columns);
        for (family, l) in source.shells() {
            multiply(
                rows_mut(turned.as_mut(), source.shell(family, l)),
                Accum::Replace,
                dense(self.rotation.degree(l)),
                x.subrows(from.shell(family, l).start, 2 * l + 1),
            );
        }
        let mut result = Mat::<f64>::zeros(target.len(), columns);
        for half in Half::all(source.order.min(target.order)) {
            let (take, give) = (half.rows(source), half.rows(target));
            let gathered = Mat::from_fn(take.len(), columns, |i, j| {
                take[i].1 * turned[(take[i].0, j)]
            });
            let matrix = match backward {
                false => self.sectors[half.m].as_ref(),
                true => self.sectors[half.m].transpose(),
            };
            let mut product = Mat::zeros(give.len(), columns);
            multiply(product.as_mut(), Accum::Replace, matrix, gathered.as_ref());
            for j in 0..columns {
                for (i, &(row, sign)) in give.iter().enumerate() {
                    result[(row, j)] = sign * product[(i, j)];
                }
            }
        }
        for (family, l) in target.shells() {
            multiply(
                rows_mut(y.rb_mut(), to.shell(family, l)),
                Accum::Add,
                dense(self.rotation.degree(l)).transpose(),
                result
                    .as_ref()
                    .subrows(target.shell(family, l).start, 2 * l + 1),
            );
        }
    }
}

fn rows_mut(matrix: MatMut<'_, f64>, rows: std::ops::Range<usize>) -> MatMut<'_, f64> {
    matrix.subrows_mut(rows.start, rows.len())
}

fn multiply(y: MatMut<f64>, accum: Accum, a: MatRef<f64>, x: MatRef<f64>) {
    matmul(y, accum, a, x, 1.0, Par::Seq);
}

fn dense(matrix: &DMatrix<f64>) -> MatRef<'_, f64> {
    MatRef::from_column_major_slice(matrix.as_slice(), matrix.nrows(), matrix.ncols())
}
