//! Coupling of spheres through their images in a wall, at any position above it.

use faer::Mat;
use nalgebra::{DMatrix, Vector3};

use super::axial::Outgoing;
use super::lamb::{Lamb, place};
use super::link::{Body, Half, onto_axis};
use super::modes::Family;
use super::reflection::image;
use super::rotation::Rotation;

/// Dense coupling matrix from the image of one sphere to another (or the same) sphere above `z =
/// 0`.
///
/// The reflected multipoles are rotated onto the line from the centre of the image to the centre of
/// the target, translated along it, rotated back, and transformed by Lorentz's reflection there.
/// Cost: `O(L^5)` for order `L`.
pub(crate) fn coupling(
    (from, below): (&Body, &Vector3<f64>),
    (to, centre): (&Body, &Vector3<f64>),
) -> Mat<f64> {
    let mirrored = Vector3::new(below.x, below.y, -below.z);
    let offset = centre - mirrored;
    let seen = to.modes.order + 2;
    let rotation = Rotation::new(&onto_axis(&offset), from.modes.order.max(seen));
    let axial: Vec<Outgoing> = (0..=from.modes.order.min(seen))
        .map(|m| {
            Outgoing::new(
                m,
                (from.radius, from.modes.order),
                (to.radius, seen),
                offset.norm(),
            )
        })
        .collect();
    let mut matrix = Mat::zeros(to.modes.len(), from.modes.len());
    for (family, l) in from.modes.shells() {
        for (index, column) in from.modes.shell(family, l).enumerate() {
            let m = index.abs_diff(l);
            let factor = family.parity(l, m) / from.weight(family, l);
            let turned = rotation.degree(l).column(index) * factor;
            let mut regular = Regular::zeros(seen);
            regular.add(&axial, family, l, turned.as_slice());
            let regular = regular.turned_back(&rotation);
            add_reflected(&regular, to, centre.z, matrix.col_as_slice_mut(column));
        }
    }
    matrix
}

/// Lamb's coefficients of all degrees and azimuthal numbers about one centre.
pub(super) struct Regular {
    /// For each degree from 0: columns `phi`, `chi`, `p`, rows `m = -k ..= k`.
    degrees: Vec<DMatrix<f64>>,
}

impl Regular {
    /// Highest degree that affects the velocity of the image flow at the centre.
    pub const FOR_A_POINT: usize = 3;

    /// Zero flow, up to degree `top`.
    pub fn zeros(top: usize) -> Self {
        Self {
            degrees: (0..=top).map(|k| DMatrix::zeros(2 * k + 1, 3)).collect(),
        }
    }

    /// Adds the flow of the modes `m = -l ..= l` of one family and degree, translated along the
    /// axis.
    pub fn add(&mut self, axial: &[Outgoing], family: Family, l: usize, modes: &[f64]) {
        let top = self.degrees.len() - 1;
        for half in Half::all(l.min(top)) {
            let (row, sign) = half.row(family, l);
            let value = sign * modes[row];
            for k in half.m.max(1)..=top {
                let lamb = axial[half.m].lamb(family, l, k).scaled(value);
                let (plain, _) = half.row(Family::Stokeslet, k);
                let (other, sign) = half.row(Family::Rotlet, k);
                self.degrees[k][(plain, 0)] += lamb.phi;
                self.degrees[k][(other, 1)] += sign * lamb.chi;
                self.degrees[k][(plain, 2)] += lamb.p;
            }
        }
    }

    /// Velocity of the image flow at the centre, as coefficients of `W_1` with `m = -1, 0, 1`.
    ///
    /// `height` as for [`image`].
    pub fn reflected_velocity(&self, height: f64) -> [f64; 3] {
        let mut modes = [0.0; 3];
        for half in Half::all(1) {
            let coefficients: Vec<Lamb> = (0..=Self::FOR_A_POINT)
                .map(|k| self.lamb(half, k))
                .collect();
            let (plain, _) = half.row(Family::Stokeslet, 1);
            modes[plain] = image(&coefficients, half.m as i32, height, 1)[1].phi;
        }
        modes
    }

    /// The same flow in the axes before the rotation.
    pub fn turned_back(mut self, rotation: &Rotation) -> Self {
        for (k, degree) in self.degrees.iter_mut().enumerate().skip(1) {
            *degree = rotation.degree(k).tr_mul(degree);
        }
        self
    }

    fn lamb(&self, half: Half, k: usize) -> Lamb {
        if k < half.m {
            return Lamb::default();
        }
        let (plain, _) = half.row(Family::Stokeslet, k);
        let (other, sign) = half.row(Family::Rotlet, k);
        let degree = &self.degrees[k];
        Lamb {
            phi: degree[(plain, 0)],
            chi: sign * degree[(other, 1)],
            p: degree[(plain, 2)],
        }
    }
}

/// Adds the modes of the image flow on a sphere.
fn add_reflected(regular: &Regular, to: &Body, height: f64, modes: &mut [f64]) {
    let top = to.modes.order;
    for half in Half::all(top) {
        let coefficients: Vec<Lamb> = (0..=top + 2).map(|k| regular.lamb(half, k)).collect();
        let reflected = image(&coefficients, half.m as i32, height / to.radius, top);
        for (family, k) in to.modes.sector(half.m) {
            let (row, sign) = half.row(family, k);
            modes[to.modes.shell(family, k).start + row] +=
                sign * reflected[k].trace(k)[place(family)] * to.weight(family, k);
        }
    }
}
