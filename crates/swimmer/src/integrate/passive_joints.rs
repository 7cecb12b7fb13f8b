//! Newton's method for the values of passive joints at the Gauss points of a step.
//!
//! The rate of a joint on a spring falls with its value: `dz/dt = ... - M k z` with the stiffness
//! `k` and the mobility `M` of the joint. Steps longer than `1 / (M k)`, which are usual for stiff
//! springs, need an implicit method. Gauss collocation is A-stable, and its equations
//!
//! ```text
//! z_i = z_0 + h sum_j a_ij f(z_j)
//! ```
//!
//! are solved by Newton's method with `df/dz = -M k` (Hairer & Wanner 1996, IV.8). What the change
//! of the shape does to `f` is left out of the derivative: it is not stiff.

use nalgebra::{DMatrix, DVector};
use rigid::{PassiveDrive, StateVelocity};

use crate::gauss::Gauss;

/// Linear dependence of all velocities on the values of the passive joints, by their springs.
pub(super) struct JointNewton {
    /// For each joint, the change of all velocities per change of its value.
    derivatives: Vec<StateVelocity>,
}

impl JointNewton {
    /// From the velocities for a unit force on each joint.
    pub fn new<'d>(
        responses: &[StateVelocity],
        drives: impl Iterator<Item = &'d PassiveDrive>,
    ) -> Self {
        let pairs = responses.iter().zip(drives);
        Self {
            derivatives: pairs
                .map(|(response, drive)| response * -drive.stiffness)
                .collect(),
        }
    }

    /// One step: corrects the rates at the Gauss points for the change of the values there, and
    /// returns the changes, one list of joints per point.
    ///
    /// `start` are the values at the start of the step and `values` those at which the rates were
    /// computed. Rates are per duration of the step, `duration` long.
    pub fn step(
        &self,
        start: &[f64],
        values: &[Vec<f64>],
        rates: &mut [StateVelocity],
        duration: f64,
    ) -> Vec<Vec<f64>> {
        let (points, joints) = (rates.len(), start.len());
        let gauss = Gauss::new(points);
        let weights: Vec<Vec<f64>> = (gauss.nodes.iter())
            .map(|&t| gauss.integrals(&gauss.nodes, t))
            .collect();
        // Solved for: the changes of joint `a` at point `i`, at the position `i joints + a`.
        let mut matrix = DMatrix::identity(points * joints, points * joints);
        let mut rhs = DVector::zeros(points * joints);
        for i in 0..points {
            for a in 0..joints {
                let row = i * joints + a;
                rhs[row] = start[a] - values[i][a];
                for j in 0..points {
                    rhs[row] += weights[i][j] * rates[j].joints[a];
                    for (b, derivative) in self.derivatives.iter().enumerate() {
                        let change = duration * derivative.joints[a];
                        matrix[(row, j * joints + b)] -= weights[i][j] * change;
                    }
                }
            }
        }
        // The matrix is regular, because Gauss methods are A-stable and mobilities positive.
        let changes = matrix.lu().solve(&rhs).unwrap_or(rhs);
        let changes: Vec<Vec<f64>> = (changes.as_slice().chunks(joints))
            .map(<[f64]>::to_vec)
            .collect();
        for (rate, changes) in rates.iter_mut().zip(&changes) {
            for (derivative, change) in self.derivatives.iter().zip(changes) {
                *rate = &*rate + &(derivative * (change * duration));
            }
        }
        changes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On `dz/dt = -λ z` one step gives the Padé approximation of `exp(-λ h)`, whatever the start
    /// of the iteration: the problem is linear.
    #[test]
    fn one_step_solves_a_linear_problem_of_any_stiffness() {
        for stiffness in [1e-3, 1.0, 1e3, 1e6] {
            let of_joint = |rate: f64| StateVelocity {
                frames: vec![],
                spins: vec![],
                joints: vec![rate],
            };
            let drive = PassiveDrive {
                stiffness,
                ..PassiveDrive::default()
            };
            let newton = JointNewton::new(&[of_joint(1.0)], [&drive].into_iter());
            let (duration, guess) = (0.5, 0.3);
            let values = vec![vec![guess]; 2];
            let mut rates = vec![of_joint(-stiffness * guess * duration); 2];
            newton.step(&[1.0], &values, &mut rates, duration);
            let end = 1.0 + 0.5 * (rates[0].joints[0] + rates[1].joints[0]);
            let z = -stiffness * duration;
            let exact = (12.0 + 6.0 * z + z * z) / (12.0 - 6.0 * z + z * z);
            // Rounding grows with the stiffness, as rates of this size are summed.
            assert!(
                (end - exact).abs() < 1e-14 * (10.0 + stiffness),
                "{stiffness}"
            );
        }
    }
}
