//! Signed discretisation errors: of one solution, and accumulated along a stroke.

use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};
use serde::{Deserialize, Serialize};

/// Estimated discretisation errors of one solution, computed minus exact, in the scene's units.
///
/// They have signs, because errors along a stroke partly cancel, as the velocities do.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshError {
    /// Error of the frame velocity of each linkage.
    pub frames: Vec<Twist>,
    /// Error of the velocity of each body.
    pub bodies: Vec<Vector3<f64>>,
    /// Uncertainty of the estimated errors of velocities.
    pub uncertainty: f64,
    /// Error of the force of each body; zero where no links act and forces are the given loads.
    ///
    /// Forces of linked bodies are assumed to have the relative error of their power. To first
    /// order this is right if one link moves while the others have constant length.
    pub forces: Vec<Vector3<f64>>,
    /// Error of the power of the bodies on the fluid.
    pub power: f64,
}

/// Relative uncertainty of the estimated error of the power.
///
/// Estimated errors of forces and speeds in `cargo xtask validate` are 0.7 to 1.4 of the true ones.
const POWER_UNCERTAINTY: f64 = 0.5;

/// Error bar of a power or work whose error is estimated as `error`.
fn power_error_bar(error: f64) -> f64 {
    error.abs().hypot(POWER_UNCERTAINTY * error)
}

impl MeshError {
    /// Error bar of velocities: the largest error of a body, with its uncertainty.
    pub fn velocity_error_bar(&self) -> f64 {
        let largest = self.bodies.iter().fold(0.0_f64, |m, e| m.max(e.norm()));
        largest.hypot(self.uncertainty)
    }

    /// Error bar of the power of the bodies on the fluid.
    pub fn power_error_bar(&self) -> f64 {
        power_error_bar(self.power)
    }

    /// Magnitude of the largest error of a force.
    pub fn force(&self) -> f64 {
        self.forces.iter().fold(0.0, |m, f| m.max(f.norm()))
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
}

impl AccumulatedError {
    /// Error bar of the work.
    pub fn work_error_bar(&self) -> f64 {
        power_error_bar(self.work)
    }

    /// Adds the error of a motion that lasts for `time`.
    pub fn add(&mut self, time: f64, motion: &StateVelocity, error: &MeshError) {
        let step = Self {
            displacement: error.frames.iter().map(|f| f.linear * time).collect(),
            rotation: error.frames.iter().map(|f| f.angular * time).collect(),
            uncertainty: 0.0,
            work: error.power * time,
        };
        let displacement: Vec<_> = motion.frames.iter().map(|f| f.linear * time).collect();
        self.append(&step, &displacement);
        // On one moving mesh the discretisation errors of successive shapes are correlated, so
        // their uncertainties are summed.
        self.uncertainty += error.uncertainty * time;
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
        // On different meshes the errors are independent, so the squares of their uncertainties
        // are summed.
        self.uncertainty = self.uncertainty.hypot(later.uncertainty);
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
    use super::*;

    #[test]
    fn opposite_errors_cancel_and_rotation_errors_change_later_displacements() {
        let error = |sign: f64| MeshError {
            frames: vec![Twist {
                linear: sign * Vector3::x(),
                angular: Vector3::zeros(),
            }],
            bodies: vec![],
            uncertainty: 0.5,
            forces: vec![],
            power: sign,
        };
        let motion = StateVelocity {
            frames: vec![Twist {
                linear: Vector3::x(),
                angular: Vector3::zeros(),
            }],
            spins: vec![],
        };
        let mut sum = AccumulatedError::default();
        sum.add(2.0, &motion, &error(1.0));
        sum.add(2.0, &motion, &error(-1.0));
        assert_eq!(
            (sum.displacement[0], sum.uncertainty),
            (Vector3::zeros(), 2.0)
        );

        // A small rotation error about z, then a displacement of 2 along x: the error of the
        // displacement along y is twice the angle.
        let rotation_error = AccumulatedError {
            displacement: vec![Vector3::zeros()],
            rotation: vec![Vector3::new(0.0, 0.0, 1e-3)],
            uncertainty: 0.0,
            work: 3.0,
        };
        assert_eq!(sum.work, 0.0);
        sum.append(&rotation_error, &[Vector3::zeros()]);
        sum.add(2.0, &motion, &error(0.0));
        assert!((sum.displacement[0] - Vector3::new(0.0, 2e-3, 0.0)).norm() < 1e-15);
        let tip = sum.of_body(0, &Vector3::new(10.0, 0.0, 0.0));
        assert_eq!(sum.work, 3.0);
        assert!((tip - Vector3::new(0.0, 1.2e-2, 0.0)).norm() < 1e-15);
    }

    #[test]
    fn stored_names_are_those_of_existing_checkpoints() {
        let stored = serde_json::to_value(AccumulatedError::default()).unwrap();
        let names: Vec<&String> = stored.as_object().unwrap().keys().collect();
        assert_eq!(names, ["moved", "spread", "turned", "work"]);
    }
}
