//! Efficiency of swimmers: the power of towing them beside the power of swimming.

use models::Hydrodynamics;
use nalgebra::Vector3;
use scene::{InertiaKind, Scene};
use serde_json::{Value, json};

use crate::error::SwimError;
use crate::outcome::Outcome;
use crate::start::at_start;

/// Lighthill's efficiency of a run.
///
/// The power of towing the swimmer in its shape at the start, without rotation, at its mean
/// velocity `U = Δ / T` over the mean power of its stroke `W / T` (Lighthill 1952, Comm. Pure
/// Appl. Math. 5, 109; Purcell 1977, Am. J. Phys. 45, 3):
///
/// ```text
/// η = R U² / (W / T) = R Δ² / (W T),   R = e · F(e)
/// ```
///
/// with the net displacement `Δ` along the unit vector `e`, the work `W` on the fluid and the time
/// `T` of the whole run, and the force `F(e)` on the fluid of all bodies that move together with
/// the velocity `e`. Of a sphere in unbounded fluid it is `6 π μ a Δ² / (W T)`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Efficiency {
    /// `η`.
    pub value: f64,
    /// Its error bar, by those of displacement, work and drag; none if displacement or work has
    /// none.
    ///
    /// A drag without a bar, as by elements in space, counts with the relative one of the work:
    /// both are dissipations of flows on meshes of the same sizes.
    pub error: Option<f64>,
    /// The drag `R` per velocity.
    pub drag: f64,
}

impl Efficiency {
    /// The efficiency of a completed run; none of a run that did not swim.
    ///
    /// It swims if all bodies are one swimmer without loads, given velocities, background flow,
    /// inertia and thermal noise, which returned to its shape and moved by more than its error
    /// bar, of at most 50 bodies, and if the model has a grand resistance at the start.
    ///
    /// Cost: six solutions per body on one mesh.
    ///
    /// # Errors
    /// [`SwimError::OtherScene`] for a model of another scene.
    pub fn of_run(
        scene: &Scene,
        model: &mut dyn Hydrodynamics,
        outcome: &Outcome,
    ) -> Result<Option<Self>, SwimError> {
        let (net, bar) = (outcome.net_vector(), outcome.error_estimate.total());
        let [size, work] = [net.norm(), outcome.work];
        let moves = size > bar.max(outcome.rounding()) && work > outcome.work_error.total();
        if !(moves && outcome.stopped.is_none() && swims_freely(scene))
            || outcome.shape_change(scene).is_some()
        {
            return Ok(None);
        }
        let direction = net / size;
        let found = at_start(scene, model, |model, configuration, _| {
            model.resistances()?.resistance(configuration)
        });
        let resistance = match found {
            Ok(resistance) => resistance,
            // What the run has reached does not depend on it.
            Err(SwimError::Model(_)) => return Ok(None),
            Err(error) => return Err(error),
        };
        let drag = along(&resistance.matrix, &direction);
        let value = drag * size * size / (work * scene.gait().duration());
        // Errors of entries are bounds, whose sum is one whatever their signs.
        let of_drag = (resistance.errors).map(|errors| along(&errors, &direction.abs()) / drag);
        let bars = (outcome.error_estimate.estimated()).zip(outcome.work_error.estimated());
        let error = bars.map(|(of_path, of_work)| {
            let of_work = of_work / work;
            value * (2.0 * of_path / size + of_work + of_drag.unwrap_or(of_work))
        });
        Ok(Some(Self { value, error, drag }))
    }

    /// The entry of `summary.json`.
    pub fn json(&self) -> Value {
        json!({ "value": self.value, "error": self.error, "drag": self.drag })
    }
}

/// `Σ e · R_ij e` over the forces of all bodies for the velocities of all bodies.
fn along(resistance: &nalgebra::DMatrix<f64>, direction: &Vector3<f64>) -> f64 {
    let blocks = 0..resistance.nrows() / 6;
    let of_pair = |i: usize, j: usize| {
        let block = resistance.fixed_view::<3, 3>(6 * i, 6 * j);
        direction.dot(&(block * direction))
    };
    let pairs = blocks
        .clone()
        .flat_map(|i| blocks.clone().map(move |j| (i, j)));
    pairs.map(|(i, j)| of_pair(i, j)).sum()
}

/// Largest number of bodies: matrices over more may cost more than the run.
const MAX_BODIES: usize = 50;

/// Whether the bodies are one swimmer that nothing but its stroke moves.
fn swims_freely(scene: &Scene) -> bool {
    let is_free = |body: &scene::Body| {
        body.total_force() == Vector3::zeros()
            && body.torque == Vector3::zeros()
            && !body.is_driven()
            && body.held_velocity().is_none()
            && body.held_angular_velocity().is_none()
    };
    scene.articulation().linkages().len() == 1
        && scene.bodies().len() <= MAX_BODIES
        && scene.bodies().iter().all(is_free)
        && scene.background().is_none()
        && scene.rheology().is_none()
        && scene.noise().is_none()
        && scene.inertia().kind == InertiaKind::None
        && !scene.bodies().iter().any(|body| body.mass > 0.0)
}

#[cfg(test)]
mod tests {
    use nalgebra::DMatrix;

    use super::*;

    #[test]
    fn drags_are_those_of_all_bodies_together() {
        let mut resistance = DMatrix::zeros(12, 12);
        for (row, column, value) in [(0, 0, 3.0), (6, 6, 4.0), (0, 6, -0.5), (6, 0, -0.5)] {
            resistance[(row, column)] = value;
        }
        // Rotations are held.
        resistance[(3, 3)] = 100.0;
        assert_eq!(along(&resistance, &Vector3::x()), 6.0);
        assert_eq!(along(&resistance, &Vector3::y()), 0.0);
    }
}
