//! Coupling of spheres through their images in a wall, at any position above it.

use faer::Mat;
use nalgebra::{DMatrix, Vector3};

use super::axial_translation::OutgoingTranslation;
use super::coupling::{Coupling, Expansion, SymmetryClass};
use super::lamb::{LambCoefficients, trace_index};
use super::modes::{Family, Modes};
use super::reflection::image;
use super::rotation::Rotation;

/// Degrees of Lamb's solution beyond those of an image that its reflection needs.
const FURTHER_DEGREES: usize = 2;

/// Dense coupling from the image of one sphere to another, or the same, sphere above `z = 0`.
///
/// The reflected multipoles couple to the target as those of any sphere, up to higher degrees, and
/// are transformed by Lorentz's reflection there. Cost: `O(L^4)` for order `L`.
pub(crate) fn image_coupling(
    (from, centre_from): (&Expansion, &Vector3<f64>),
    (to, centre): (&Expansion, &Vector3<f64>),
) -> Mat<f64> {
    let image_centre = Vector3::new(centre_from.x, centre_from.y, -centre_from.z);
    let wide = Expansion {
        radius: to.radius,
        modes: Modes {
            order: to.modes.order + FURTHER_DEGREES + Family::Source.shift(),
        },
    };
    let offset = centre - image_centre;
    let coupling = Coupling::between_spheres((0, 1), (from, &wide), &offset, 0.0).dense();
    let mut parities = vec![0.0; from.modes.len()];
    for (family, l) in from.modes.shells() {
        for (index, column) in from.modes.shell(family, l).enumerate() {
            parities[column] = family.parity(l, index.abs_diff(l));
        }
    }
    let mut matrix = Mat::zeros(to.modes.len(), from.modes.len());
    for m in 0..=to.modes.order {
        let reflection = reflection(&wide, to, m, centre.z / to.radius);
        for class in SymmetryClass::of_azimuthal_number(m) {
            let (sources, targets) = (class.rows(wide.modes), class.rows(to.modes));
            let flow = Mat::from_fn(sources.len(), parities.len(), |i, j| {
                let (row, sign) = sources[i];
                sign * parities[j] * coupling[(row, j)]
            });
            let image = &reflection * flow;
            for (j, column) in image.col_iter().enumerate() {
                for ((row, sign), value) in targets.iter().zip(column.iter()) {
                    matrix[(*row, j)] = sign * value;
                }
            }
        }
    }
    matrix
}

/// Lorentz's reflection of the modes of azimuthal number `m` about a centre at `height` radii above
/// the wall: columns are the modes of `wide`, rows those of `to`, in the order of
/// [`Modes::sector`].
fn reflection(wide: &Expansion, to: &Expansion, m: usize, height: f64) -> Mat<f64> {
    let (columns, rows) = (wide.modes.sector(m), to.modes.sector(m));
    let top = to.modes.order;
    let mut matrix = Mat::zeros(rows.len(), columns.len());
    let mut flow = vec![LambCoefficients::default(); top + FURTHER_DEGREES + 1];
    for (column, &(family, k)) in columns.iter().enumerate() {
        if k >= flow.len() {
            continue;
        }
        flow[k] = LambCoefficients::of_trace(family, k).scaled(1.0 / wide.weight(family, k));
        let image = image(&flow, m as i32, height, top);
        flow[k] = LambCoefficients::default();
        for (row, &(family, k)) in rows.iter().enumerate() {
            matrix[(row, column)] = image[k].trace(k)[trace_index(family)] * to.weight(family, k);
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
