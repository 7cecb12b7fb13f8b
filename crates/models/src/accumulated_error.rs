//! Errors of the discretisation, of the model or of the integration, accumulated along a stroke.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::response::{BodySolution, HoldingLoad};
use crate::solution::InstantaneousSolution;

/// Uncertainty of the sum of a model's errors along a stroke, relative to the sum of their sizes.
///
/// Estimates of truncation are several times too large, by a factor that changes slowly with the
/// shape, so that they cancel along a stroke nearly as the errors do.
const MODEL_UNCERTAINTY: f64 = 0.1;

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
    /// Uncertainty of the errors of rotations.
    #[serde(default)]
    pub rotation_uncertainty: f64,
    /// Error of the work of the bodies on the fluid.
    #[serde(default)]
    pub work: f64,
    /// Uncertainty of the error of the work.
    #[serde(default)]
    pub work_uncertainty: f64,
    /// Largest relative uncertainty of the parts.
    #[serde(default)]
    pub relative_uncertainty: f64,
    /// Errors of the impulses of the loads that hold or drive bodies.
    #[serde(default)]
    pub holding: Vec<HoldingLoad>,
    /// Uncertainties of the errors of these impulses: of forces and of torques.
    #[serde(default)]
    pub holding_uncertainty: [f64; 2],
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

    /// Error bar of corrected rotations of the frames.
    pub fn rotation_error_bar(&self) -> f64 {
        (self.relative_uncertainty * self.largest_rotation()).hypot(self.rotation_uncertainty)
    }

    /// Error bar of the corrected rotation of the frame of one linkage.
    pub fn rotation_error_bar_of(&self, linkage: usize) -> f64 {
        (self.relative_uncertainty * self.rotation_of(linkage)).hypot(self.rotation_uncertainty)
    }

    /// Error bar of the rotation of the frame of one linkage, from which the error was not
    /// subtracted.
    pub fn uncorrected_rotation_bar_of(&self, linkage: usize) -> f64 {
        self.rotation_of(linkage).hypot(self.rotation_uncertainty)
    }

    /// Size of the error of the rotation of the frame of one linkage.
    fn rotation_of(&self, linkage: usize) -> f64 {
        self.rotation.get(linkage).map_or(0.0, Vector3::norm)
    }

    /// The largest error of the displacement of a frame.
    pub fn largest_displacement(&self) -> f64 {
        largest(&self.displacement)
    }

    /// The largest error of the rotation of a frame.
    pub fn largest_rotation(&self) -> f64 {
        largest(&self.rotation)
    }

    /// Error bars of values from which the error was not subtracted: of a displacement whose
    /// largest error is `displacement`, of the rotation, the work, and the impulses that hold
    /// bodies.
    pub fn uncorrected_error_bars(&self, displacement: f64) -> UncorrectedBars {
        let largest = |part: fn(&HoldingLoad) -> &Vector3<f64>| {
            let norms = self.holding.iter().map(|load| part(load).norm());
            norms.fold(0.0, f64::max)
        };
        let holding = [largest(|load| &load.force), largest(|load| &load.torque)];
        UncorrectedBars {
            displacement: displacement.hypot(self.uncertainty),
            rotation: self.largest_rotation().hypot(self.rotation_uncertainty),
            // Errors of a work are all in one direction, and so may be that of their estimate.
            work: self.work.abs() + self.work_uncertainty,
            holding: std::array::from_fn(|k| holding[k].hypot(self.holding_uncertainty[k])),
        }
    }

    /// Adds uncertainties, such as those of what remains of a start.
    pub fn add_uncertainty(&mut self, bars: &UncorrectedBars) {
        self.uncertainty += bars.displacement;
        self.rotation_uncertainty += bars.rotation;
        self.work_uncertainty += bars.work;
        for (sum, bar) in self.holding_uncertainty.iter_mut().zip(bars.holding) {
            *sum += bar;
        }
    }

    /// Adds the error that was subtracted from a solution, times its quadrature weight `time`.
    ///
    /// Nothing if the solution was not corrected.
    pub fn add(&mut self, time: f64, solution: &InstantaneousSolution) {
        let Some(error) = &solution.mesh_error else {
            return;
        };
        let errors = || error.response.motion.frames.iter();
        let step = Self {
            displacement: errors().map(|f| f.linear * time).collect(),
            rotation: errors().map(|f| f.angular * time).collect(),
            uncertainty: 0.0,
            rotation_uncertainty: 0.0,
            work: (solution.uncorrected_power() - solution.power()) * time,
            work_uncertainty: error.uncertainty.power * time.abs(),
            relative_uncertainty: error.uncertainty.relative,
            holding: Vec::new(),
            holding_uncertainty: [0.0; 2],
        };
        let frames = solution.motion.frames.iter();
        let displacement: Vec<_> = frames.map(|f| f.linear * time).collect();
        self.append(&step, &displacement);
        // On one moving mesh the discretisation errors of successive shapes are correlated, so
        // their uncertainties are summed.
        self.uncertainty += error.uncertainty.velocity * time;
        self.rotation_uncertainty += error.uncertainty.angular_velocity * time;
    }

    /// Adds the error by the model in a solution, times its quadrature weight `time`.
    ///
    /// What has no sign, of the error bars of the solution, is uncertainty.
    pub fn add_model_error(&mut self, time: f64, solution: &InstantaneousSolution) {
        let error = solution.model_error.as_ref();
        let size = |part: fn(&BodySolution) -> &Vector3<f64>| {
            let bodies = error.into_iter().flat_map(|error| &error.bodies);
            bodies.fold(0.0_f64, |most, body| most.max(part(body).norm()))
        };
        let uncertainty =
            |bar: Option<f64>, size: f64| time * solution.model_uncertainty(bar, size);
        let power = error.map_or(0.0, |error| {
            solution.power() - (&solution.response - error).power()
        });
        let frames = || error.into_iter().flat_map(|error| &error.motion.frames);
        let step = Self {
            displacement: frames().map(|frame| frame.linear * time).collect(),
            rotation: frames().map(|frame| frame.angular * time).collect(),
            uncertainty: uncertainty(solution.error_estimate.model, size(|body| &body.velocity)),
            rotation_uncertainty: uncertainty(
                solution.angular_velocity_error.model,
                size(|body| &body.angular_velocity),
            ),
            work: power * time,
            work_uncertainty: uncertainty(solution.power_error.model, power.abs()),
            ..Self::default()
        };
        let motion = solution.motion.frames.iter();
        let displacement: Vec<_> = motion.map(|frame| frame.linear * time).collect();
        self.append_correlated(&step, &displacement);
    }

    /// Appends a later part of the stroke, in which the frames move by `frame_displacements`.
    ///
    /// An error of the rotation before changes the direction of these displacements. The errors of
    /// the two parts are independent, as on different meshes, so the squares of their uncertainties
    /// are summed.
    pub fn append(&mut self, later: &Self, frame_displacements: &[Vector3<f64>]) {
        let [displacement, rotation] = [self.uncertainty, self.rotation_uncertainty];
        self.append_correlated(later, frame_displacements);
        self.uncertainty = displacement.hypot(later.uncertainty);
        self.rotation_uncertainty = rotation.hypot(later.rotation_uncertainty);
    }

    /// The same where the errors are correlated, so that their uncertainties are summed.
    pub fn append_correlated(&mut self, later: &Self, frame_displacements: &[Vector3<f64>]) {
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
        self.uncertainty += later.uncertainty;
        self.rotation_uncertainty += later.rotation_uncertainty;
        if self.holding.is_empty() {
            self.holding.clone_from(&later.holding);
        } else {
            for (sum, later) in self.holding.iter_mut().zip(&later.holding) {
                sum.force += later.force;
                sum.torque += later.torque;
            }
        }
        for (sum, later) in (self.holding_uncertainty.iter_mut()).zip(later.holding_uncertainty) {
            *sum += later;
        }
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

impl InstantaneousSolution {
    /// Uncertainty of an error by the model in a sum along a stroke: of one with the error bar
    /// `bar`, of which a part of this size has a sign.
    pub fn model_uncertainty(&self, bar: Option<f64>, size: f64) -> f64 {
        // Values of passive joints have no sum with a sign.
        let relative = match self.motion.joints.is_empty() {
            true => MODEL_UNCERTAINTY,
            false => 1.0,
        };
        let unsigned = (bar.unwrap_or(0.0) - size).max(0.0);
        unsigned + relative * size
    }
}

fn largest(vectors: &[Vector3<f64>]) -> f64 {
    vectors.iter().map(Vector3::norm).fold(0.0, f64::max)
}

/// Error bars that follow from an accumulated error
/// ([`AccumulatedError::uncorrected_error_bars`]).
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct UncorrectedBars {
    /// Error bar of the displacement.
    pub displacement: f64,
    /// Error bar of the rotation vectors of the frames.
    pub rotation: f64,
    /// Error bar of the work.
    pub work: f64,
    /// Error bars of the impulses that hold bodies: of forces and of torques.
    pub holding: [f64; 2],
}

#[cfg(test)]
mod tests {
    use rigid::{StateVelocity, Twist};

    use super::*;
    use crate::discretisation_error::{DiscretisationError, Uncertainty};
    use crate::response::Response;

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
                response: Response {
                    motion: along_x(sign),
                    bodies: vec![BodySolution {
                        velocity: sign * Vector3::x(),
                        ..BodySolution::default()
                    }],
                    joint_loads: vec![],
                    holding: vec![],
                    mean_flow: None,
                    slip_power: 0.0,
                    amplitude_rates: vec![],
                },
                uncertainty: Uncertainty {
                    relative: 0.1,
                    velocity: 0.5,
                    ..Uncertainty::default()
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
                "holding",
                "holding_uncertainty",
                "moved",
                "relative_uncertainty",
                "rotation_uncertainty",
                "spread",
                "turned",
                "work",
                "work_uncertainty"
            ]
        );
    }
}
