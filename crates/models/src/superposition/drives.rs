//! What drives the flow around a rigid body: loads, strain of the background flow, slip.

use nalgebra::{DMatrix, DVector, Matrix3, UnitQuaternion, Vector3};
use scene::{Background, Domain, Scene};

/// Number of orientations from which the basis is chosen.
///
/// With 60, the coefficients of other orientations are below 2.5 in all cases of the unit test.
pub(super) const CANDIDATES: usize = 60;

/// Loads, background flow and slip of a scene, in the laboratory axes.
pub(super) struct Drives {
    /// Orthonormal basis of the span of the external forces and torques.
    loads: Vec<Vector3<f64>>,
    pub background: Background,
    has_slip: bool,
}

impl Drives {
    /// The drives of a scene; `None` if its solutions cannot be superposed.
    pub fn of(scene: &Scene) -> Option<Self> {
        let set = scene.articulation();
        let count = scene.bodies().len();
        let turns_as_one = count == 1 || !(0..count).any(|body| set.has_own_attitude(body));
        // Only then the mesh of finite elements turns with the body.
        let keeps_mesh = scene.has_surface_velocity() || scene.gravity() != Vector3::zeros();
        let is_alone = *scene.domain() == Domain::Unbounded
            && keeps_mesh
            && set.linkages().len() == 1
            && turns_as_one
            && set.linkages()[0].bodies.len() == count
            && !set.fixed().contains(&true)
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
            Some(Background::Poiseuille { .. }) => return None,
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

    /// Number of independent components of `d`.
    pub fn count(&self) -> usize {
        let of_strain = if self.strain().is_some() { 5 } else { 0 };
        3 * self.loads.len() + of_strain + usize::from(self.has_slip)
    }

    /// The vector `d` for a body that is rotated from its initial attitude by `rotation`.
    pub fn data(&self, rotation: &UnitQuaternion<f64>) -> DVector<f64> {
        let back = rotation.inverse();
        let mut data: Vec<f64> = Vec::with_capacity(self.count());
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

    /// Orientations whose vectors `d` form a basis, and the inverse of the matrix of these vectors.
    ///
    /// They are chosen from [`CANDIDATES`] orientations by a QR factorisation with column pivoting.
    pub fn basis(&self) -> Option<(Vec<UnitQuaternion<f64>>, DMatrix<f64>)> {
        let candidates: Vec<_> = (0..CANDIDATES).map(candidate).collect();
        let columns: Vec<DVector<f64>> = candidates.iter().map(|q| self.data(q)).collect();
        let order = DMatrix::from_columns(&columns).col_piv_qr();
        let mut numbers = DMatrix::from_fn(1, CANDIDATES, |_, k| k as f64);
        order.p().permute_columns(&mut numbers);
        let chosen: Vec<usize> = (numbers.iter().take(self.count()))
            .map(|number| *number as usize)
            .collect();
        let matrix: Vec<_> = chosen.iter().map(|&k| columns[k].clone()).collect();
        let inverse = DMatrix::from_columns(&matrix).try_inverse()?;
        Some((chosen.iter().map(|&k| candidates[k]).collect(), inverse))
    }
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
        for (loads, background, has_slip, count) in [
            (0, linear, false, 5),
            (1, still, false, 3),
            (1, linear, true, 9),
            (3, linear, true, 15),
            (0, still, true, 1),
        ] {
            let drives = Drives {
                loads: axes[..loads].to_vec(),
                background,
                has_slip,
            };
            let (rotations, inverse) = drives.basis().unwrap();
            assert_eq!((rotations.len(), drives.count()), (count, count));
            for number in CANDIDATES..500 {
                let coefficients = &inverse * drives.data(&candidate(number));
                assert!(
                    coefficients.amax() < 2.5,
                    "{count}: {}",
                    coefficients.amax()
                );
            }
        }
    }
}
