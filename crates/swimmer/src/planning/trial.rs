//! Trials of the models of spheres: a stroke through a bounded number of shapes, or the start.

use models::{Hydrodynamics, ModelError, SphereModel, SpheresModel};
use nalgebra::{DVector, Vector3};
use scene::{Gait, Phase, Scene, ShapePath, closest_contact, spans};

use crate::error::SwimError;
use crate::integrate::Method;
use crate::simulate::simulate;
use crate::start::solve_start;

/// Largest number of phases of a trial: three quarters of a second by small expansions.
pub(super) const MAX_TRIAL_PHASES: usize = 32;

/// The quantity to which the tolerance refers, computed with one model.
pub(super) struct Evaluation {
    value: DVector<f64>,
    /// Error bar of the value by the model, relative to `scale`.
    pub error_bar: f64,
    /// Scale of the relative error, also where the value vanishes, as the net displacement of a
    /// reciprocal stroke does.
    scale: f64,
    /// The forces that hold bodies whose velocity is given, which no model changes.
    loads: Option<Box<Self>>,
}

impl Evaluation {
    /// Difference from a more accurate evaluation, relative to its scale.
    pub fn difference(&self, reference: &Self) -> f64 {
        (&self.value - &reference.value).norm() / reference.scale
    }

    /// Largest of the error bar of the loads and of their difference from a more accurate
    /// evaluation, relative to their scale; zero without loads.
    pub fn error_of_loads(&self, reference: &Self) -> f64 {
        match (&self.loads, &reference.loads) {
            (Some(loads), Some(exact)) => loads.difference(exact).max(loads.error_bar),
            _ => 0.0,
        }
    }

    /// Forces on bodies; their scale is at least `scale`. None without forces.
    fn of_forces(forces: Vec<Vector3<f64>>, bar: f64, scale: f64) -> Option<Box<Self>> {
        let value = DVector::from_iterator(3 * forces.len(), forces.iter().flatten().copied());
        let scale = scale.max(value.norm());
        (scale > 0.0).then(|| {
            Box::new(Self {
                value,
                error_bar: bar / scale,
                scale,
                loads: None,
            })
        })
    }
}

/// One cycle of the gait through at most [`MAX_TRIAL_PHASES`] of its shapes; none if bodies touch
/// on the way.
///
/// The rows of a long table are points of a path, so the errors of models along it are those along
/// a part of its points: every so many ends of phases, with those of the largest and the smallest
/// value of each joint and of the smallest gap.
pub(super) fn stroke(scene: &Scene) -> Option<Scene> {
    let phases = scene.gait().phases.len();
    if phases <= MAX_TRIAL_PHASES {
        return scene.with_cycles(1).ok();
    }
    let set = scene.articulation();
    let start = set.initial_shape();
    let one_cycle = Gait {
        cycles: 1,
        phases: scene.gait().phases.clone(),
    };
    let ends: Vec<(Vec<f64>, f64)> = (spans(&one_cycle, start).ok()?)
        .map(|span| (span.to, span.duration))
        .collect();
    let last = ends.len() - 1;
    let by = |value: &dyn Fn(&[f64]) -> f64| {
        let least = |best: (usize, f64), (number, (shape, _)): (usize, &(Vec<f64>, f64))| {
            let value = value(shape);
            if value < best.1 {
                (number, value)
            } else {
                best
            }
        };
        ends.iter().enumerate().fold((0, f64::INFINITY), least).0
    };
    let gap = |shape: &[f64]| {
        let poses = set.place(&scene.initial_state(), shape).ok();
        let contact =
            poses.and_then(|p| closest_contact(&scene.bodies_at(shape), scene.domain(), &p));
        contact.map_or(f64::INFINITY, |contact| contact.gap)
    };
    let mut kept = vec![by(&gap), last];
    for joint in (0..start.len()).take(MAX_TRIAL_PHASES / 4) {
        kept.push(by(&|shape| shape[joint]));
        kept.push(by(&|shape| -shape[joint]));
    }
    let stride = ends.len().div_ceil(MAX_TRIAL_PHASES - kept.len());
    kept.extend((stride - 1..ends.len()).step_by(stride));
    kept.sort_unstable();
    kept.dedup();
    let mut phases = Vec::with_capacity(kept.len());
    let (mut first, mut before) = (0, start);
    for end in kept {
        let shape = &ends[end].0;
        let moved = (0..shape.len()).filter(|&joint| shape[joint] != before[joint]);
        phases.push(Phase {
            path: ShapePath::Linear(moved.map(|joint| (joint, shape[joint])).collect()),
            duration: ends[first..=end].iter().map(|(_, duration)| duration).sum(),
        });
        (first, before) = (end + 1, shape);
    }
    scene.with_gait(Gait { cycles: 1, phases }).ok()
}

/// Shapes at the ends of the phases of a trial stroke.
pub(super) fn shapes(stroke: &Scene) -> Vec<Vec<f64>> {
    let start = stroke.articulation().initial_shape();
    spans(stroke.gait(), start).map_or(Vec::new(), |all| all.map(|span| span.to).collect())
}

/// Net displacement of a trial stroke by one model; none if it cannot be followed to its end.
///
/// # Errors
/// Those of the model.
pub(super) fn follow(stroke: &Scene, kind: SphereModel) -> Result<Option<Evaluation>, ModelError> {
    // The integration error must be small compared with the differences between the models.
    let tolerance = (0.1 * stroke.working_tolerance()).clamp(1e-12, 1e-4);
    let mut model = SpheresModel::new(stroke, kind)?;
    let Ok(stroke) = stroke.with_tolerance(tolerance) else {
        return Ok(None);
    };
    let outcome = match simulate(&stroke, &mut model, Method::Collocation, &mut ()) {
        Ok(outcome) => outcome,
        Err(SwimError::Model(error)) => return Err(error),
        Err(_) => return Ok(None),
    };
    let bodies = outcome.displacement.len().max(1) as f64;
    let net = outcome.displacement.iter().sum::<Vector3<f64>>() / bodies;
    let longest = outcome
        .spans
        .iter()
        .flat_map(|span| span.displacement.iter().map(|d| d.norm()))
        .fold(0.0, f64::max);
    let scale = if net.norm() > 1e-6 * longest {
        net.norm()
    } else {
        longest
    };
    let scale = if scale > 0.0 { scale } else { 1.0 };
    let loads = outcome.mean_holding().and_then(|means| {
        let forces = means.bodies.iter().map(|load| load.force).collect();
        let solved = (outcome.samples.iter()).filter_map(|sample| sample.bodies.as_deref());
        let largest = solved.flatten().map(|body| body.force.norm());
        // Means that vanish, of reciprocal strokes.
        let least = MEAN_SHARE * largest.fold(0.0, f64::max);
        Evaluation::of_forces(forces, means.force_error.model.unwrap_or(0.0), least)
    });
    Ok(Some(Evaluation {
        value: DVector::from_column_slice(net.as_slice()),
        error_bar: outcome.error_estimate.model.unwrap_or(0.0) / scale,
        scale,
        loads,
    }))
}

/// Least scale of mean forces relative to the largest force along the stroke: means of reciprocal
/// strokes vanish, and no model has them to a part of this.
const MEAN_SHARE: f64 = 1e-3;

/// Velocities at the start of a scene by one model, or forces where nothing moves; none if the
/// start fails for another reason than the model.
///
/// # Errors
/// Those of the model.
pub(super) fn at_start(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
) -> Result<Option<Evaluation>, ModelError> {
    let solution = match solve_start(scene, model) {
        Ok(solution) => solution,
        Err(SwimError::Model(error)) => return Err(error),
        Err(_) => return Ok(None),
    };
    let evaluation = |vectors: Vec<Vector3<f64>>, scale: f64, bar: f64, rounding: f64| {
        (scale > rounding).then(|| Evaluation {
            value: DVector::from_iterator(3 * vectors.len(), vectors.iter().flatten().copied()),
            error_bar: bar / scale,
            scale,
            loads: None,
        })
    };
    let bodies = &solution.bodies;
    let velocities = bodies.iter().map(|body| body.velocity).collect();
    // Points of surfaces move by the rotation too.
    let speeds = scene.bodies().iter().zip(bodies).map(|(body, motion)| {
        let arc = body.bounding_radius() * motion.angular_velocity.norm();
        motion.velocity.norm().hypot(arc)
    });
    let speed = speeds.fold(0.0_f64, f64::hypot);
    let forces: Vec<_> = bodies.iter().map(|body| body.force).collect();
    let force = forces
        .iter()
        .map(|force| force.norm())
        .fold(0.0, f64::hypot);
    let rounding = ROUNDING * surface_speed(scene);
    let loads = (scene.has_held_bodies())
        .then(|| Evaluation::of_forces(forces.clone(), solution.force_error.total(), 0.0))
        .flatten();
    let found = evaluation(velocities, speed, solution.error_estimate.total(), rounding)
        .or_else(|| {
            let size = scene.bodies().iter().map(|body| body.bounding_radius());
            let rounding = scene.viscosity() * size.fold(0.0, f64::max) * rounding;
            evaluation(forces, force, solution.force_error.total(), rounding)
        })
        .or(Some(Evaluation {
            value: DVector::zeros(3 * bodies.len()),
            error_bar: 0.0,
            scale: 1.0,
            loads: None,
        }));
    Ok(found.map(|found| Evaluation { loads, ..found }))
}

/// Rounding of velocities that a surface flow causes, relative to its own.
const ROUNDING: f64 = 1e-12;

/// Largest velocity of slip and of the background flow relative to the centre of a body.
fn surface_speed(scene: &Scene) -> f64 {
    let speeds = scene.bodies().iter().map(|body| {
        let slip = body.slip.as_ref().map_or(0.0, |slip| slip.speed());
        let flow = scene.background().map_or(0.0, |flow| {
            let gradient = flow.gradient(&body.position).norm();
            flow.velocity(&body.position).norm() + gradient * body.bounding_radius()
        });
        slip + flow
    });
    speeds.fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A trial of every phase took 20 ms for each: minutes for tables with 20 000 rows.
    #[test]
    fn bug_a_long_gait_was_tried_along_all_of_its_phases() {
        let scene = Scene::parse(
            "bodies = [{ name = \"l\", radius = 1, position = [-10, 0, 0] }, \
             { name = \"c\", radius = 1, position = [0, 0, 0] }, \
             { name = \"r\", radius = 1, position = [10, 0, 0] }]\n\
             links = [{ name = \"a\", body = \"l\", to = \"c\" }, \
             { name = \"b\", body = \"r\", to = \"c\" }]\n",
        )
        .unwrap();
        let rows = 1000;
        let phases = (1..=rows).map(|row| {
            let angle = std::f64::consts::TAU * f64::from(row) / f64::from(rows);
            // A narrow gap at a single row.
            let dip = if row == 617 { 3.0 } else { 0.0 };
            Phase {
                path: ShapePath::Linear(vec![
                    (0, 8.0 + 2.0 * angle.cos()),
                    (1, 10.0 + 2.0 * angle.sin() - dip),
                ]),
                duration: 0.5,
            }
        });
        let gait = Gait {
            cycles: 7,
            phases: phases.collect(),
        };
        let scene = scene.with_gait(gait).unwrap();
        let trial = stroke(&scene).unwrap();
        assert_eq!(trial.gait().cycles, 1);
        assert!(trial.gait().phases.len() <= MAX_TRIAL_PHASES);
        assert!((trial.gait().duration() - 0.5 * f64::from(rows)).abs() < 1e-9);
        let (mut all, tried) = (shapes(&scene), shapes(&trial));
        all.truncate(scene.gait().phases.len());
        assert!(tried.iter().all(|shape| all.contains(shape)));
        // The end, and the largest and smallest values.
        assert_eq!(tried.last(), all.last());
        for joint in 0..2 {
            let extremes = |of: &[Vec<f64>]| {
                let values = of.iter().map(|shape| shape[joint]);
                values.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)))
            };
            assert_eq!(extremes(&tried), extremes(&all), "joint {joint}");
        }
    }
}
