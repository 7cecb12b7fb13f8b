//! Coupling of spheres through their images in a wall, at any position above it.

use faer::Mat;
use nalgebra::{DMatrix, Vector3};

use super::axial_translation::OutgoingTranslation;
use super::coupling::{Expansion, SymmetryClass};
use super::lamb::{LambCoefficients, trace_index};
use super::modes::Family;
use super::reflection::image;
use super::rotation::{Rotation, rotation_to_z};

/// Dense coupling from the image of one sphere to another, or the same, sphere above `z = 0`.
///
/// The reflected multipoles are rotated onto the line from the centre of the image to the centre of
/// the target, translated along it, rotated back, and transformed by Lorentz's reflection there.
/// Cost: `O(L^5)` for order `L`.
pub(crate) fn image_coupling(
    (from, centre_from): (&Expansion, &Vector3<f64>),
    (to, centre): (&Expansion, &Vector3<f64>),
) -> Mat<f64> {
    let image_centre = Vector3::new(centre_from.x, centre_from.y, -centre_from.z);
    let offset = centre - image_centre;
    let top = to.modes.order + 2;
    let rotation = Rotation::new(&rotation_to_z(&offset), from.modes.order.max(top));
    let axial: Vec<OutgoingTranslation> = (0..=from.modes.order.min(top))
        .map(|m| {
            OutgoingTranslation::new(
                m,
                (from.radius, from.modes.order),
                (to.radius, top),
                offset.norm(),
            )
        })
        .collect();
    let mut matrix = Mat::zeros(to.modes.len(), from.modes.len());
    for (family, l) in from.modes.shells() {
        for (index, column) in from.modes.shell(family, l).enumerate() {
            let m = index.abs_diff(l);
            let factor = family.parity(l, m) / from.weight(family, l);
            let rotated = rotation.degree(l).column(index) * factor;
            let mut flow = LambExpansion::zeros(top);
            flow.add(&axial, family, l, rotated.as_slice());
            let flow = flow.rotated_back(&rotation);
            add_reflected(&flow, to, centre.z, matrix.col_as_slice_mut(column));
        }
    }
    matrix
}

/// Lamb's coefficients of all degrees and azimuthal numbers about one centre.
pub(super) struct LambExpansion {
    /// For each degree from 0: columns `phi`, `chi`, `p`, rows `m = -k ..= k`.
    degrees: Vec<DMatrix<f64>>,
}

impl LambExpansion {
    /// Highest degree that affects the velocity of the image flow at the centre.
    pub const MAX_DEGREE_AT_A_POINT: usize = 3;

    /// Zero flow, up to degree `top`.
    pub fn zeros(top: usize) -> Self {
        Self {
            degrees: (0..=top).map(|k| DMatrix::zeros(2 * k + 1, 3)).collect(),
        }
    }

    /// Adds the flow of the modes `m = -l ..= l` of one family and degree, translated along the
    /// axis.
    pub fn add(&mut self, axial: &[OutgoingTranslation], family: Family, l: usize, modes: &[f64]) {
        let top = self.degrees.len() - 1;
        for class in SymmetryClass::all(l.min(top)) {
            let (row, sign) = class.row(family, l);
            let value = sign * modes[row];
            for k in class.m.max(1)..=top {
                let lamb = axial[class.m].coefficients(family, l, k).scaled(value);
                let (row, _) = class.row(Family::Stokeslet, k);
                let (chi_row, sign) = class.row(Family::Rotlet, k);
                self.degrees[k][(row, 0)] += lamb.phi;
                self.degrees[k][(chi_row, 1)] += sign * lamb.chi;
                self.degrees[k][(row, 2)] += lamb.p;
            }
        }
    }

    /// Velocity of the image flow at the centre, as coefficients of `W_1` with `m = -1, 0, 1`.
    ///
    /// `height` as for [`image`].
    pub fn reflected_velocity(&self, height: f64) -> [f64; 3] {
        let mut modes = [0.0; 3];
        for class in SymmetryClass::all(1) {
            let coefficients: Vec<LambCoefficients> = (0..=Self::MAX_DEGREE_AT_A_POINT)
                .map(|k| self.coefficients(class, k))
                .collect();
            let (row, _) = class.row(Family::Stokeslet, 1);
            modes[row] = image(&coefficients, class.m as i32, height, 1)[1].phi;
        }
        modes
    }

    /// The same flow in the axes before the rotation.
    pub fn rotated_back(mut self, rotation: &Rotation) -> Self {
        for (k, degree) in self.degrees.iter_mut().enumerate().skip(1) {
            *degree = rotation.degree(k).tr_mul(degree);
        }
        self
    }

    fn coefficients(&self, class: SymmetryClass, k: usize) -> LambCoefficients {
        if k < class.m {
            return LambCoefficients::default();
        }
        let (row, _) = class.row(Family::Stokeslet, k);
        let (chi_row, sign) = class.row(Family::Rotlet, k);
        let degree = &self.degrees[k];
        LambCoefficients {
            phi: degree[(row, 0)],
            chi: sign * degree[(chi_row, 1)],
            p: degree[(row, 2)],
        }
    }
}

/// Adds the modes of the image flow on a sphere.
fn add_reflected(flow: &LambExpansion, to: &Expansion, height: f64, modes: &mut [f64]) {
    let top = to.modes.order;
    for class in SymmetryClass::all(top) {
        let coefficients: Vec<LambCoefficients> =
            (0..=top + 2).map(|k| flow.coefficients(class, k)).collect();
        let reflected = image(&coefficients, class.m as i32, height / to.radius, top);
        for (family, k) in to.modes.sector(class.m) {
            let (row, sign) = class.row(family, k);
            modes[to.modes.shell(family, k).start + row] +=
                sign * reflected[k].trace(k)[trace_index(family)] * to.weight(family, k);
        }
    }
}
