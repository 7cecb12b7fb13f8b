//! Resistances in addition to that of the fluid: dashpots of joints, and inertia of a time step.

use nalgebra::{DMatrix, DVector, Matrix6};

use crate::VelocityLayout;

/// A symmetric matrix `D` over all generalised velocities `q`, block-diagonal: the forces `-D q`
/// act in addition to the external loads.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Damping {
    /// Velocities of passive joints, with the coefficients of their dashpots.
    joints: Vec<(usize, f64)>,
    /// First velocities of bodies, with their blocks.
    bodies: Vec<(usize, Matrix6<f64>)>,
}

impl Damping {
    pub fn new(layout: &VelocityLayout, joints: &[f64], bodies: &[(usize, Matrix6<f64>)]) -> Self {
        let joints = layout.joints().zip(joints.iter().copied());
        Self {
            joints: joints
                .filter(|(_, coefficient)| *coefficient != 0.0)
                .collect(),
            bodies: (bodies.iter())
                .filter_map(|(body, block)| Some((layout.body(*body)?, *block)))
                .collect(),
        }
    }

    /// `D q`.
    pub fn times(&self, q: &DVector<f64>) -> DVector<f64> {
        let mut product = DVector::zeros(q.len());
        for &(row, coefficient) in &self.joints {
            product[row] += coefficient * q[row];
        }
        for (first, block) in &self.bodies {
            let part = block * q.fixed_rows::<6>(*first);
            let mut rows = product.fixed_rows_mut::<6>(*first);
            rows += part;
        }
        product
    }

    /// `tests^T D columns`; zero without entries.
    pub fn projected(&self, tests: &DMatrix<f64>, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut sum = DMatrix::zeros(tests.ncols(), columns.ncols());
        for &(row, coefficient) in &self.joints {
            sum += coefficient * tests.row(row).transpose() * columns.row(row);
        }
        for (first, block) in &self.bodies {
            let [left, right] = [tests, columns].map(|m| m.fixed_rows::<6>(*first));
            sum += left.transpose() * (block * right);
        }
        sum
    }
}
