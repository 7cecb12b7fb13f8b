//! What drives the flow around a rigid body: loads, strain of the background flow, slip.

use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3};
use scene::{Background, Domain, Scene};

/// Number of orientations from which the basis is chosen.
///
/// With 60, the coefficients of other orientations are below 2.5 in all cases of the unit test.
pub(super) const CANDIDATES: usize = 60;

/// Size of a component of `d`, relative to the largest one, below which orientations differ by
/// rounding only.
const ROUNDING: f64 = 1e-9;

/// Loads, background flow and slip of a scene, in the laboratory axes.
pub(super) struct Drives {
    /// Orthonormal basis of the span of the external forces and torques.
    loads: Vec<Vector3<f64>>,
    pub background: Background,
    has_slip: bool,
    /// Normals of the symmetry planes of the model, which the body keeps.
    symmetry_planes: [bool; 3],
}

impl Drives {
    /// The drives of a scene; `None` if its solutions cannot be superposed.
    pub fn new(scene: &Scene) -> Option<Self> {
        let set = scene.articulation();
        let count = scene.bodies().len();
        let turns_as_one = count == 1 || !(0..count).any(|body| set.has_own_attitude(body));
        // Only then the mesh of finite elements turns with the body.
        let keeps_mesh = scene.has_surface_velocity() || scene.gravity() != Vector3::zeros();
        let is_linear = scene.viscosity_law().is_none();
        let is_alone = is_linear
            && *scene.domain() == Domain::Unbounded
            && keeps_mesh
            && set.linkages().len() == 1
            && turns_as_one
            && set.linkages()[0].bodies.len() == count
            && !scene.has_held_bodies()
            && !scene.bodies().iter().any(scene::Body::is_driven)
            && !scene.has_passive_joints()
            && !scene.has_masses()
            && scene
                .bodies()
                .iter()
                .all(|body| body.bounding_radius() > 0.0);
        let background = match scene.background() {
            None => Background::Uniform {
                velocity: Vector3::zeros(),
            },
            Some(background @ (Background::Uniform { .. } | Background::Linear { .. })) => {
                *background
            }
            Some(Background::Poiseuille { .. } | Background::PressureGradient { .. }) => {
                return None;
            }
        };
        let vectors = (scene.bodies().iter()).flat_map(|body| [body.total_force(), body.torque]);
        let mut loads: Vec<Vector3<f64>> = Vec::new();
        for vector in vectors {
            let rest = loads
                .iter()
                .fold(vector, |rest, d| rest - d * d.dot(&vector));
            // A smaller part is rounding.
            if rest.norm() > 1e-12 * vector.norm() {
                loads.push(rest.normalize());
            }
        }
        let drives = Self {
            loads,
            background,
            has_slip: scene.bodies().iter().any(|body| body.slip.is_some()),
            symmetry_planes: scene.fem_symmetry_planes(),
        };
        (is_alone && drives.count() > 0).then_some(drives)
    }

    /// Rate of strain of the background flow, with unit norm; `None` without strain.
    fn strain(&self) -> Option<Matrix3<f64>> {
        let gradient = self.background.gradient(&Vector3::zeros());
        let strain = 0.5 * (gradient + gradient.transpose());
        (strain.norm() > 1e-12 * gradient.norm()).then(|| strain / strain.norm())
    }

    /// Half of the curl of the background flow.
    pub fn rotation_rate(&self) -> Vector3<f64> {
        let g = self.background.gradient(&Vector3::zeros());
        0.5 * Vector3::new(
            g[(2, 1)] - g[(1, 2)],
            g[(0, 2)] - g[(2, 0)],
            g[(1, 0)] - g[(0, 1)],
        )
    }

    /// Number of independent components of `d`, over the orientations that symmetry planes allow.
    pub fn count(&self) -> usize {
        self.chosen().len()
    }

    /// The vector `d` for a body that is rotated from its initial attitude by `rotation`.
    pub fn data(&self, rotation: &UnitQuaternion<f64>) -> DVector<f64> {
        let back = rotation.inverse();
        let mut data: Vec<f64> = Vec::new();
        data.extend(
            self.loads
                .iter()
                .flat_map(|load| <[f64; 3]>::from(back * load)),
        );
        if let Some(strain) = self.strain() {
            let to_body = back.to_rotation_matrix();
            let e = to_body * strain * to_body.transpose();
            data.extend([e[(0, 0)], e[(1, 1)], e[(0, 1)], e[(0, 2)], e[(1, 2)]]);
        }
        data.extend(self.has_slip.then_some(1.0));
        DVector::from_vec(data)
    }

    /// Element of a sequence of orientations that the symmetry planes allow: all, those about the
    /// normal of one plane, or the initial one only.
    pub fn orientation(&self, number: usize) -> UnitQuaternion<f64> {
        let normals = (0..3).filter(|&axis| self.symmetry_planes[axis]);
        match normals.collect::<Vec<_>>()[..] {
            [] => candidate(number),
            [axis] => candidate_about(axis, number),
            _ => UnitQuaternion::identity(),
        }
    }

    /// Numbers of the orientations of the basis.
    ///
    /// They are chosen from [`CANDIDATES`] orientations by a QR factorisation with column pivoting.
    fn chosen(&self) -> Vec<usize> {
        let columns: Vec<DVector<f64>> = (0..CANDIDATES)
            .map(|number| self.data(&self.orientation(number)))
            .collect();
        if columns[0].is_empty() {
            return Vec::new();
        }
        let order = DMatrix::from_columns(&columns).col_piv_qr();
        let mut numbers = DMatrix::from_fn(1, CANDIDATES, |_, k| k as f64);
        order.p().permute_columns(&mut numbers);
        let pivots = order.r();
        let size = |k: usize| pivots[(k, k)].abs();
        (numbers.iter().take(pivots.nrows()).enumerate())
            .take_while(|(k, _)| size(*k) > ROUNDING * size(0))
            .map(|(_, number)| *number as usize)
            .collect()
    }

    /// Orientations whose vectors `d` form a basis, and the inverse of the matrix of these vectors
    /// on their span.
    pub fn basis(&self) -> Option<(Vec<UnitQuaternion<f64>>, DMatrix<f64>)> {
        let rotations: Vec<_> = (self.chosen().into_iter())
            .map(|number| self.orientation(number))
            .collect();
        let columns: Vec<_> = rotations.iter().map(|q| self.data(q)).collect();
        let matrix = DMatrix::from_columns(&columns);
        let inverse = match matrix.is_square() {
            true => matrix.try_inverse()?,
            false => (matrix.tr_mul(&matrix)).try_inverse()? * matrix.transpose(),
        };
        Some((rotations, inverse))
    }
}

/// Element of a sequence of evenly distributed rotations about a coordinate axis; element 0 is the
/// identity.
fn candidate_about(axis: usize, number: usize) -> UnitQuaternion<f64> {
    use std::f64::consts::TAU;
    // The golden ratio minus one.
    const STEP: f64 = 0.618_033_988_749_894_8;
    let angle = TAU * (number as f64 * STEP).fract();
    UnitQuaternion::from_scaled_axis(Vector3::ith(axis, angle))
}

/// Element of a sequence of evenly distributed rotations; element 0 is the identity.
///
/// Shoemake's (1992) map to uniform rotations, at the points of a Kronecker sequence.
pub(super) fn candidate(number: usize) -> UnitQuaternion<f64> {
    use std::f64::consts::TAU;
    if number == 0 {
        return UnitQuaternion::identity();
    }
    // Powers of the inverse of the root of x^4 = x + 1 (Roberts 2018).
    const ROOT: f64 = 1.220_744_084_605_759_5;
    let [u, v, w] = [1, 2, 3].map(|power| (number as f64 / ROOT.powi(power)).fract());
    let (a, b) = ((1.0 - u).sqrt(), u.sqrt());
    let (v, w) = (TAU * v, TAU * w);
    let parts = nalgebra::Quaternion::new(b * w.cos(), a * v.sin(), a * v.cos(), b * w.sin());
    UnitQuaternion::from_quaternion(parts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_orientation_is_a_moderate_combination_of_the_basis() {
        let shear = Matrix3::new(0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
        let linear = Background::Linear {
            kind: scene::BackgroundKind::Shear,
            gradient: shear,
        };
        let still = Background::Uniform {
            velocity: Vector3::x(),
        };
        let axes = [Vector3::z(), Vector3::x(), Vector3::y()];
        // Turned about z, the loads have components of the forms 1, cos and sin; shear in the plane
        // normal to z has two with twice the angle.
        let (all, across, lines) = ([false; 3], [false, false, true], [false, true, true]);
        for (loads, background, has_slip, symmetry_planes, count) in [
            (0, linear, false, all, 5),
            (1, still, false, all, 3),
            (1, linear, true, all, 9),
            (3, linear, true, all, 15),
            (0, still, true, all, 1),
            (0, linear, false, across, 2),
            (3, linear, true, across, 5),
            (1, still, true, lines, 1),
        ] {
            let drives = Drives {
                loads: axes[..loads].to_vec(),
                background,
                has_slip,
                symmetry_planes,
            };
            let (rotations, inverse) = drives.basis().unwrap();
            assert_eq!((rotations.len(), drives.count()), (count, count));
            for number in CANDIDATES..500 {
                let data = drives.data(&drives.orientation(number));
                let coefficients = &inverse * &data;
                assert!(
                    coefficients.amax() < 2.5,
                    "{count}: {}",
                    coefficients.amax()
                );
                let rotations = rotations.iter().zip(&coefficients);
                let sum: DVector<f64> = rotations.map(|(q, c)| drives.data(q) * *c).sum();
                assert!((sum - data).amax() < 1e-13);
            }
        }
    }
}
