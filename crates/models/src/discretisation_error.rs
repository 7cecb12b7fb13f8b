//! Signed discretisation errors: of one solution, and accumulated along a stroke.

use nalgebra::Vector3;
use rigid::StateVelocity;
use serde::{Deserialize, Serialize};

use crate::solution::{BodySolution, InstantaneousSolution, for_each_vector};

/// Estimated discretisation error of one solution, in the scene's units.
///
/// Errors have signs, because errors along a stroke partly cancel, as the velocities do. They are
/// what [`InstantaneousSolution::correct`] subtracts: computed minus exact.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscretisationError {
    /// Error of the rate of change of the state.
    pub motion: StateVelocity,
    /// Errors of the velocities and loads of each body.
    pub bodies: Vec<BodySolution>,
    /// Error of the force of each joint.
    pub joint_forces: Vec<Vector3<f64>>,
    /// Error of the power of the slip.
    pub slip_power: f64,
    /// What is uncertain about the estimate: error bars of the corrected solution.
    pub uncertainty: Uncertainty,
}

/// Uncertainty of an estimated discretisation error.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct Uncertainty {
    /// Relative uncertainty of all parts of the estimate.
    pub relative: f64,
    /// Uncertainty of velocities, in which the errors around different bodies do not cancel.
    pub velocity: f64,
    /// Uncertainty of errors of the power that may cancel with others: of straight facets and slip.
    #[serde(default)]
    pub power: f64,
}

impl DiscretisationError {
    /// The difference of two solutions of the same query, such as computed minus corrected.
    pub fn between(
        computed: &InstantaneousSolution,
        corrected: &InstantaneousSolution,
        uncertainty: Uncertainty,
    ) -> Self {
        let difference = |(a, b): (&Vector3<f64>, &Vector3<f64>)| a - b;
        Self {
            motion: &computed.motion + &(&corrected.motion * -1.0),
            bodies: (computed.bodies.iter().zip(&corrected.bodies))
                .map(|(a, b)| BodySolution {
                    velocity: a.velocity - b.velocity,
                    angular_velocity: a.angular_velocity - b.angular_velocity,
                    force: a.force - b.force,
                    torque: a.torque - b.torque,
                })
                .collect(),
            joint_forces: (computed.joint_forces.iter().zip(&corrected.joint_forces))
                .map(difference)
                .collect(),
            slip_power: computed.slip_power - corrected.slip_power,
            uncertainty,
        }
    }

    /// The sum of `terms`, each times its factor, such as an interpolation between configurations
    /// of one arrangement.
    ///
    /// Of the relative uncertainties the largest counts, those of velocities are summed like the
    /// errors. None without terms.
    pub fn combination<'a>(terms: impl IntoIterator<Item = (f64, &'a Self)>) -> Option<Self> {
        let scaled = |factor: f64, error: &Self| {
            let mut term = error.clone();
            for_each_vector(
                &mut term.motion,
                &mut term.bodies,
                &mut term.joint_forces,
                |vector| *vector *= factor,
            );
            (term.motion.joints.iter_mut()).for_each(|rate| *rate *= factor);
            term.slip_power *= factor;
            term.uncertainty.velocity *= factor;
            term.uncertainty.power *= factor;
            term
        };
        let mut terms = terms
            .into_iter()
            .map(|(factor, error)| scaled(factor, error));
        let first = terms.next()?;
        let mut sum = terms.fold(first, |sum, term| sum.plus(&term));
        sum.uncertainty.velocity = sum.uncertainty.velocity.max(0.0);
        sum.uncertainty.power = sum.uncertainty.power.max(0.0);
        Some(sum)
    }

    fn plus(mut self, term: &Self) -> Self {
        self.motion = &self.motion + &term.motion;
        for (sum, term) in self.bodies.iter_mut().zip(&term.bodies) {
            sum.velocity += term.velocity;
            sum.angular_velocity += term.angular_velocity;
            sum.force += term.force;
            sum.torque += term.torque;
        }
        for (sum, term) in self.joint_forces.iter_mut().zip(&term.joint_forces) {
            *sum += term;
        }
        self.slip_power += term.slip_power;
        let (of_sum, of_term) = (&mut self.uncertainty, &term.uncertainty);
        of_sum.relative = of_sum.relative.max(of_term.relative);
        of_sum.velocity += of_term.velocity;
        of_sum.power += of_term.power;
        self
    }

    /// Error bar of the corrected velocities of all bodies.
    pub fn velocity_error_bar(&self) -> f64 {
        (self.uncertainty.relative * self.velocity()).hypot(self.uncertainty.velocity)
    }

    /// Magnitude of the largest error of the velocity of a body.
    pub fn velocity(&self) -> f64 {
        self.largest(|body| body.velocity)
    }

    /// Error bar of the corrected power, if the correction of the power is `removed`.
    pub fn power_error_bar(&self, removed: f64) -> f64 {
        (self.uncertainty.relative * removed.abs()).max(self.uncertainty.power)
    }

    /// Error bar of the corrected forces of all bodies.
    pub fn force_error_bar(&self) -> f64 {
        self.uncertainty.relative * self.largest(|body| body.force)
    }

    fn largest(&self, of: fn(&BodySolution) -> Vector3<f64>) -> f64 {
        (self.bodies.iter()).fold(0.0, |largest, body| largest.max(of(body).norm()))
    }
}

/// Error of the configuration along a part of a stroke, computed minus exact, to first order.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct AccumulatedError {
    /// Error of the displacement of each linkage's frame.
    #[serde(rename = "moved")]
    pub displacement: Vec<Vector3<f64>>,
    /// Error of the rotation vector of each linkage's frame.
    #[serde(rename = "turned")]
    pub rotation: Vec<Vector3<f64>>,
    /// Uncertainty of the errors of displacements.
    #[serde(rename = "spread")]
    pub uncertainty: f64,
    /// Error of the work of the bodies on the fluid.
    #[serde(default)]
    pub work: f64,
    /// Uncertainty of the error of the work.
    #[serde(default)]
    pub work_uncertainty: f64,
    /// Largest relative uncertainty of the parts.
    #[serde(default)]
    pub relative_uncertainty: f64,
}

impl AccumulatedError {
    /// Error bar of the corrected work.
    pub fn work_error_bar(&self) -> f64 {
        (self.relative_uncertainty * self.work.abs()).max(self.work_uncertainty)
    }

    /// Error bar of corrected displacements whose largest correction is `correction`.
    pub fn displacement_error_bar(&self, correction: f64) -> f64 {
        (self.relative_uncertainty * correction).hypot(self.uncertainty)
    }

    /// Adds the error that was subtracted from a solution, times its quadrature weight `time`.
    ///
    /// Nothing if the solution was not corrected.
    pub fn add(&mut self, time: f64, solution: &InstantaneousSolution) {
        let Some(error) = &solution.mesh_error else {
            return;
        };
        let motion = &solution.motion;
        let step = Self {
            displacement: error
                .motion
                .frames
                .iter()
                .map(|f| f.linear * time)
                .collect(),
            rotation: error
                .motion
                .frames
                .iter()
                .map(|f| f.angular * time)
                .collect(),
            uncertainty: 0.0,
            work: (solution.uncorrected_power() - solution.power()) * time,
            work_uncertainty: error.uncertainty.power * time.abs(),
            relative_uncertainty: error.uncertainty.relative,
        };
        let displacement: Vec<_> = motion.frames.iter().map(|f| f.linear * time).collect();
        self.append(&step, &displacement);
        // On one moving mesh the discretisation errors of successive shapes are correlated, so
        // their uncertainties are summed.
        self.uncertainty += error.uncertainty.velocity * time;
    }

    /// Appends a later part of the stroke, in which the frames move by `frame_displacements`.
    ///
    /// An error of the rotation before changes the direction of these displacements.
    pub fn append(&mut self, later: &Self, frame_displacements: &[Vector3<f64>]) {
        // A sum without frames has no error yet.
        for (sum, later) in [
            (&mut self.displacement, &later.displacement),
            (&mut self.rotation, &later.rotation),
        ] {
            sum.resize(sum.len().max(later.len()), Vector3::zeros());
        }
        let later_errors = later.displacement.iter().zip(&later.rotation);
        let sums = self.displacement.iter_mut().zip(&mut self.rotation);
        for ((sum, later), path) in sums.zip(later_errors).zip(frame_displacements) {
            let (displacement, rotation) = sum;
            let (later_displacement, later_rotation) = later;
            *displacement += later_displacement + rotation.cross(path);
            *rotation += later_rotation;
        }
        self.work += later.work;
        self.work_uncertainty += later.work_uncertainty;
        // On different meshes the errors are independent, so the squares of their uncertainties
        // are summed.
        self.uncertainty = self.uncertainty.hypot(later.uncertainty);
        self.relative_uncertainty = self.relative_uncertainty.max(later.relative_uncertainty);
    }

    /// Error of the displacement of a body at the position `arm` relative to its linkage's root.
    pub fn of_body(&self, linkage: usize, arm: &Vector3<f64>) -> Vector3<f64> {
        match (self.displacement.get(linkage), self.rotation.get(linkage)) {
            (Some(displacement), Some(rotation)) => displacement + rotation.cross(arm),
            _ => Vector3::zeros(),
        }
    }
}

#[cfg(test)]
mod tests {
    use rigid::Twist;

    use super::*;

    #[test]
    fn opposite_errors_cancel_and_rotation_errors_change_later_displacements() {
        let along_x = |speed: f64| StateVelocity {
            frames: vec![Twist {
                linear: speed * Vector3::x(),
                angular: Vector3::zeros(),
            }],
            spins: vec![],
            joints: vec![],
        };
        // One body with a unit force, so that the error of its velocity is that of its power.
        let corrected = |sign: f64| {
            let body = BodySolution {
                force: Vector3::x(),
                ..BodySolution::default()
            };
            let mut solution = InstantaneousSolution::new(vec![body], vec![], along_x(1.0 + sign));
            solution.correct(DiscretisationError {
                motion: along_x(sign),
                bodies: vec![BodySolution {
                    velocity: sign * Vector3::x(),
                    ..BodySolution::default()
                }],
                joint_forces: vec![],
                slip_power: 0.0,
                uncertainty: Uncertainty {
                    relative: 0.1,
                    velocity: 0.5,
                    power: 0.0,
                },
            });
            assert_eq!(solution.motion, along_x(1.0));
            solution
        };
        let mut sum = AccumulatedError::default();
        sum.add(2.0, &corrected(1.0));
        assert_eq!((sum.work, sum.work_error_bar()), (2.0, 0.2));
        sum.add(2.0, &corrected(-1.0));
        assert_eq!(
            (sum.displacement[0], sum.uncertainty),
            (Vector3::zeros(), 2.0)
        );

        // A small rotation error about z, then a displacement of 2 along x: the error of the
        // displacement along y is twice the angle.
        let rotation_error = AccumulatedError {
            displacement: vec![Vector3::zeros()],
            rotation: vec![Vector3::new(0.0, 0.0, 1e-3)],
            work: 3.0,
            ..AccumulatedError::default()
        };
        assert_eq!(sum.work, 0.0);
        sum.append(&rotation_error, &[Vector3::zeros()]);
        sum.add(2.0, &corrected(0.0));
        assert!((sum.displacement[0] - Vector3::new(0.0, 2e-3, 0.0)).norm() < 1e-15);
        let tip = sum.of_body(0, &Vector3::new(10.0, 0.0, 0.0));
        assert_eq!(sum.work, 3.0);
        assert!((tip - Vector3::new(0.0, 1.2e-2, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn stored_names_are_those_of_existing_checkpoints() {
        let stored = serde_json::to_value(AccumulatedError::default()).unwrap();
        let names: Vec<&String> = stored.as_object().unwrap().keys().collect();
        assert_eq!(
            names,
            [
                "moved",
                "relative_uncertainty",
                "spread",
                "turned",
                "work",
                "work_uncertainty"
            ]
        );
    }
}
