//! What a sphere does to the fluid in a periodic box.

use nalgebra::{Matrix3, Vector3, Vector6};

/// Force and torque of a sphere on the fluid, and its slip.
#[derive(Clone, Copy)]
pub(crate) struct Source {
    pub force: Vector3<f64>,
    pub torque: Vector3<f64>,
    /// Dipole and stresslet of a squirmer.
    pub slip: Option<(Vector3<f64>, Matrix3<f64>)>,
}

impl Source {
    pub fn of_load(load: &Vector6<f64>) -> Self {
        Self {
            force: load.fixed_rows::<3>(0).into_owned(),
            torque: load.fixed_rows::<3>(3).into_owned(),
            slip: None,
        }
    }
}

/// A velocity and an angular velocity.
pub(super) fn six_of(velocity: Vector3<f64>, rotation: Vector3<f64>) -> Vector6<f64> {
    let mut both = Vector6::zeros();
    both.fixed_rows_mut::<3>(0).copy_from(&velocity);
    both.fixed_rows_mut::<3>(3).copy_from(&rotation);
    both
}
