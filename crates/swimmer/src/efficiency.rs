//! Efficiency of swimmers: the power of towing them beside the power of swimming.

use std::f64::consts::PI;

use models::{BodyInertia, Configuration, Hydrodynamics, ModelError, Query};
use nalgebra::{Matrix3, Matrix6, Vector3};
use rigid::ExternalLoad;
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
    /// Its error bar, by those of displacement, work and drag; none if one of them has none.
    pub error: Option<f64>,
    /// The drag `R` per velocity.
    pub drag: f64,
}

impl Efficiency {
    /// The efficiency of a completed run; none of a run that did not swim.
    ///
    /// It swims if all bodies are one swimmer without springs, loads, given velocities, background
    /// flow, inertia and thermal noise, which returned to its shape and moved by more than its
    /// error bar.
    ///
    /// Cost: one solution at the start; two with slip, gravity or a repulsion.
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
        let found = at_start(scene, model, |model, configuration, rates| {
            drag(model, configuration, rates.len(), &direction)
        });
        let (drag, of_drag) = match found {
            Ok(found) => found,
            // What the run has reached does not depend on it.
            Err(SwimError::Model(_)) => return Ok(None),
            Err(error) => return Err(error),
        };
        if !(drag > 0.0 && drag.is_finite()) {
            return Ok(None);
        }
        let value = drag * size * size / (work * scene.gait().duration());
        let bars = (outcome.error_estimate.estimated()).zip(outcome.work_error.estimated());
        let error = bars.zip(of_drag).map(|((of_path, of_work), of_drag)| {
            value * (2.0 * of_path / size + of_work / work + of_drag)
        });
        Ok(Some(Self { value, error, drag }))
    }

    /// The entry of `summary.json`.
    pub fn json(&self) -> Value {
        json!({ "value": self.value, "error": self.error, "drag": self.drag })
    }
}

/// Resistance of what is kept still over that of a sphere around the whole swimmer: what is left
/// of its velocity changes the drag by the order of the inverse.
const HOLD: f64 = 1e6;

/// The drag per velocity of all bodies that move together along `direction`, and its relative error
/// bar.
///
/// Joints stand, and a large resistance of the first body keeps it from rotating and from moving
/// sideways. A load along the direction then changes the velocity by itself over the drag.
fn drag(
    model: &mut dyn Hydrodynamics,
    configuration: Configuration<'_>,
    n_joints: usize,
    direction: &Vector3<f64>,
) -> Result<(f64, Option<f64>), ModelError> {
    let scene = model.scene();
    let radii = scene.bodies().iter().map(scene::Body::bounding_radius);
    let body = radii.clone().position(|radius| radius > 0.0).unwrap_or(0);
    let poses = scene
        .articulation()
        .place(configuration.state, configuration.shape)?;
    let held_at = poses[body].translation.vector;
    let distances = poses
        .iter()
        .map(|pose| (pose.translation.vector - held_at).norm());
    let ends = distances
        .zip(radii.clone())
        .map(|(distance, radius)| distance + radius);
    let extent = ends.fold(0.0, f64::max);
    // What moves the swimmer without a load is subtracted.
    let moves_itself = scene.has_surface_velocity()
        || scene.repulsion().is_some()
        || scene.gravity() != Vector3::zeros();
    let force = 6.0 * PI * scene.viscosity() * extent;
    let sideways = Matrix3::identity() - direction * direction.transpose();
    let mut damping = Matrix6::zeros();
    (damping.fixed_view_mut::<3, 3>(0, 0)).copy_from(&(HOLD * force * sideways));
    (damping.fixed_view_mut::<3, 3>(3, 3)).fill_diagonal(HOLD * force * extent * extent);
    let mut held = vec![BodyInertia::default(); radii.len()];
    held[body].damping = damping;
    let mut loaded = held.clone();
    loaded[body].load = ExternalLoad {
        force: force * direction,
        torque: Vector3::zeros(),
    };
    let rates = [vec![0.0; n_joints]];
    let mut velocity = |inertia: &[BodyInertia]| {
        let query = Query::new(configuration, &rates).with_inertia(inertia);
        let solution = model.solve(&query)?.pop();
        let solution = solution.ok_or(ModelError::NoSolution {
            model: model.name(),
        })?;
        let along = solution.bodies[body].velocity.dot(direction);
        Ok::<_, ModelError>((along, solution.error_estimate.estimated()))
    };
    let (mut speed, mut bar) = velocity(&loaded)?;
    if moves_itself {
        let (own, of_own) = velocity(&held)?;
        speed -= own;
        bar = bar.zip(of_own).map(|(a, b)| a + b);
    }
    Ok((force / speed, bar.map(|bar| bar / speed)))
}

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
        && scene.articulation().passive_joints().next().is_none()
        && scene.bodies().iter().all(is_free)
        && scene.background().is_none()
        && scene.rheology().is_none()
        && scene.noise().is_none()
        && scene.inertia().kind == InertiaKind::None
        && !scene.bodies().iter().any(|body| body.mass > 0.0)
}
