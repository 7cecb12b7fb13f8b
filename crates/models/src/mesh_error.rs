//! What a mesh gets wrong: signed estimates for one instant, their sum along a stroke, and independent checks.

use nalgebra::Vector3;
use rigid::{StateVelocity, Twist};
use serde::{Deserialize, Serialize};

/// Estimated errors of an instant by the mesh, in the scene's units.
///
/// Signed, because errors of velocities along a stroke cancel as the velocities do.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshError {
    /// Error of the motion of each linkage's frame, computed less exact.
    pub frames: Vec<Twist>,
    /// The same for the velocity of each body.
    pub bodies: Vec<Vector3<f64>>,
    /// Uncertainty of the estimate for a velocity.
    pub uncertainty: f64,
    /// The same for the force of each body, zero where forces are the loads: those of linked bodies err as their power does, which is
    /// right to first order for the link that moves while others are held.
    pub forces: Vec<Vector3<f64>>,
}

impl MeshError {
    /// Size of the largest error of a force.
    pub fn force(&self) -> f64 {
        self.forces.iter().fold(0.0, |m, f| m.max(f.norm()))
    }
}

/// What the errors by the mesh add up to along a part of a stroke, to first order.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
pub struct AccumulatedError {
    /// Error of the displacement of each linkage's frame, computed less exact.
    pub moved: Vec<Vector3<f64>>,
    /// Error of the rotation vector of each frame.
    pub turned: Vec<Vector3<f64>>,
    /// Uncertainty of these estimates.
    #[serde(rename = "spread")]
    pub uncertainty: f64,
}

impl AccumulatedError {
    /// Adds `time` spent at the velocity `motion` with this error.
    pub fn add(&mut self, time: f64, motion: &StateVelocity, error: &MeshError) {
        let step = Self {
            moved: error.frames.iter().map(|f| f.linear * time).collect(),
            turned: error.frames.iter().map(|f| f.angular * time).collect(),
            uncertainty: 0.0,
        };
        let displacement: Vec<_> = motion.frames.iter().map(|f| f.linear * time).collect();
        self.append(&step, &displacement);
        // One mesh, moved: its accidents stay the same.
        self.uncertainty += error.uncertainty * time;
    }

    /// Appends a later part of the stroke with the frames' displacements in it: what was turned wrongly before moves wrongly now.
    pub fn append(&mut self, later: &Self, displacement: &[Vector3<f64>]) {
        self.moved.resize(later.moved.len(), Vector3::zeros());
        self.turned.resize(later.turned.len(), Vector3::zeros());
        let parts = later.moved.iter().zip(&later.turned).zip(displacement);
        let sums = self.moved.iter_mut().zip(&mut self.turned);
        for ((moved, turned), ((later_moved, later_turned), way)) in sums.zip(parts) {
            *moved += later_moved + turned.cross(way);
            *turned += later_turned;
        }
        // Each part by accidents of its own.
        self.uncertainty = self.uncertainty.hypot(later.uncertainty);
    }

    /// Error of the displacement of a body that is at `arm` from the root of its linkage.
    pub fn of_body(&self, linkage: usize, arm: &Vector3<f64>) -> Vector3<f64> {
        match (self.moved.get(linkage), self.turned.get(linkage)) {
            (Some(moved), Some(turned)) => moved + turned.cross(arm),
            _ => Vector3::zeros(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_cancel_with_their_signs_and_wrong_turns_carry_on() {
        let error = |sign: f64| MeshError {
            frames: vec![Twist {
                linear: sign * Vector3::x(),
                angular: Vector3::zeros(),
            }],
            bodies: vec![],
            uncertainty: 0.5,
            forces: vec![],
        };
        let motion = StateVelocity {
            frames: vec![Twist {
                linear: Vector3::x(),
                angular: Vector3::zeros(),
            }],
            spins: vec![],
        };
        let mut drift = AccumulatedError::default();
        drift.add(2.0, &motion, &error(1.0));
        drift.add(2.0, &motion, &error(-1.0));
        assert_eq!((drift.moved[0], drift.uncertainty), (Vector3::zeros(), 2.0));

        // A small wrong turn about z, then two along x: two times the angle along y.
        let turn = AccumulatedError {
            moved: vec![Vector3::zeros()],
            turned: vec![Vector3::new(0.0, 0.0, 1e-3)],
            uncertainty: 0.0,
        };
        drift.append(&turn, &[Vector3::zeros()]);
        drift.add(2.0, &motion, &error(0.0));
        assert!((drift.moved[0] - Vector3::new(0.0, 2e-3, 0.0)).norm() < 1e-15);
        let tip = drift.of_body(0, &Vector3::new(10.0, 0.0, 0.0));
        assert!((tip - Vector3::new(0.0, 1.2e-2, 0.0)).norm() < 1e-15);
    }
}
