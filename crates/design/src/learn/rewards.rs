//! Rewards: displacements of the mean of the bodies when one joint moves.

use nalgebra::Vector3;
use scene::{Gait, JointValues, Phase, Scene, ShapePath, spans};

use crate::error::DesignError;
use crate::progress::DesignProgress;
use swimmer::choose;
use swimmer::{Integrator, Method};
use swimmer::{mean_of_moving, positions};

/// Largest number of joints: their states are all tabulated.
const MOST_JOINTS: usize = 12;

/// Rotation per step, in radians, above which a swimmer counts as turning.
const SMALLEST_ROTATION: f64 = 1e-6;

/// Displacements of all steps between states.
#[derive(Clone, Debug)]
pub struct Rewards {
    /// Joints that are contracted and extended.
    pub joints: Vec<usize>,
    /// Names of these joints.
    pub names: Vec<String>,
    /// For each state, the displacement by the change of each joint.
    table: Vec<Vec<f64>>,
    /// Name of the model.
    pub model: &'static str,
    /// Largest error bar of a displacement.
    pub error: f64,
}

impl Rewards {
    /// Rewards from a table with one row per state and one entry per joint.
    ///
    /// # Errors
    /// [`DesignError::NotApplicable`] for a table of another size.
    pub fn new(table: Vec<Vec<f64>>) -> Result<Self, DesignError> {
        let joints = table.first().map_or(0, Vec::len);
        let is_right = (1..=MOST_JOINTS).contains(&joints)
            && table.len() == 1 << joints
            && table.iter().all(|row| row.len() == joints);
        if !is_right {
            return Err(DesignError::NotApplicable {
                place: "rewards".to_owned(),
                problem: "need 2^n rows of n displacements".to_owned(),
            });
        }
        Ok(Self {
            names: (0..joints).map(|k| format!("joint {}", k + 1)).collect(),
            joints: (0..joints).collect(),
            table,
            model: "table",
            error: 0.0,
        })
    }

    /// Number of states.
    pub fn states(&self) -> usize {
        self.table.len()
    }

    /// Displacement when joint number `action` changes in a state.
    pub fn of(&self, state: usize, action: usize) -> f64 {
        self.table[state][action]
    }

    /// A state as one digit per joint: 1 if it is contracted.
    pub fn name(&self, state: usize) -> String {
        let digits = (0..self.joints.len()).map(|k| if state >> k & 1 == 1 { '1' } else { '0' });
        digits.collect()
    }
}

/// Displacements along `learn.direction` of all steps, by the model of the scene.
///
/// Cost: `n 2^(n-1)` phases for `n` joints; the way back has the opposite displacement.
///
/// # Errors
/// A scene whose motion depends on more than the shape, or that turns; values of joints that are
/// missing; errors of the model; [`DesignError::Stopped`].
pub fn rewards(scene: &Scene, progress: &mut dyn DesignProgress) -> Result<Rewards, DesignError> {
    let options = scene.learn();
    let refuse = |key: &str, problem: &str| DesignError::NotApplicable {
        place: scene.place(key),
        problem: problem.to_owned(),
    };
    if !scene.is_free() {
        return Err(refuse(
            "learn",
            "learning requires a motion that depends only on the shape: one linkage in unbounded \
             fluid without external loads and passive joints",
        ));
    }
    let values = |key: &str, values: &Option<JointValues>| match values {
        Some(values) => scene.joint_values(key, values),
        None => Ok(vec![None; scene.articulation().joints().len()]),
    };
    let contracted = values("learn.contracted", &options.contracted)?;
    let extended = values("learn.extended", &options.extended)?;
    let initial = scene.articulation().initial_shape();
    let ends: Vec<(f64, f64)> = (initial.iter().enumerate())
        .map(|(joint, &initial)| {
            let extended = extended[joint].unwrap_or(initial);
            (extended, contracted[joint].unwrap_or(extended))
        })
        .collect();
    let joints: Vec<usize> = (0..ends.len())
        .filter(|&k| ends[k].0 != ends[k].1)
        .collect();
    if joints.is_empty() {
        return Err(refuse(
            "learn.contracted",
            "no joint has two values; give learn.contracted, for example learn.contracted = 6",
        ));
    }
    if joints.len() > MOST_JOINTS {
        return Err(refuse("learn.contracted", "at most 12 joints can learn"));
    }
    let names = joints
        .iter()
        .map(|&k| scene.articulation().joints()[k].name.clone());
    let mut rewards = Rewards {
        names: names.collect(),
        table: vec![vec![0.0; joints.len()]; 1 << joints.len()],
        joints,
        model: "",
        error: 0.0,
    };
    let mut model = choose(scene)?.model;
    rewards.model = model.name();
    let direction = Vector3::from(options.direction).normalize();
    let set = scene.articulation();
    let start = scene.initial_state();
    let mut solves = 0;
    for state in 0..rewards.states() {
        for (action, &joint) in rewards.joints.iter().enumerate() {
            if state >> action & 1 == 1 {
                continue;
            }
            let mut shape: Vec<f64> = ends.iter().map(|end| end.0).collect();
            for (k, &joint) in rewards.joints.iter().enumerate() {
                if state >> k & 1 == 1 {
                    shape[joint] = ends[joint].1;
                }
            }
            let phase = Phase {
                path: ShapePath::Linear(vec![(joint, ends[joint].1)]),
                duration: 1.0,
            };
            let gait = Gait {
                cycles: 1,
                phases: vec![phase],
            };
            for span in spans(&gait, &shape)? {
                let mut integrator = Integrator::new(scene, model.as_mut(), Method::Collocation);
                let result = integrator.span(&span, &start, &mut |_, _| Ok(()))?;
                let turn = result.end.frames[0]
                    .rotation
                    .angle_to(&start.frames[0].rotation);
                if turn > SMALLEST_ROTATION {
                    return Err(refuse(
                        "learn",
                        "the swimmer turns, so that rewards depend on its direction too; use a \
                         chain of bodies on a line",
                    ));
                }
                let (before, after) = (
                    positions(set, &start, &span.from)?,
                    positions(set, &result.end, &span.to)?,
                );
                let moved: Vec<Vector3<f64>> =
                    after.iter().zip(&before).map(|(a, b)| a - b).collect();
                let reward = mean_of_moving(&moved).dot(&direction);
                rewards.table[state][action] = reward;
                rewards.table[state | 1 << action][action] = -reward;
                rewards.error = rewards.error.max(result.error_estimate.total());
                solves += result.solves;
            }
            progress.tabulated(solves);
            if progress.is_interrupted() {
                return Err(DesignError::Stopped {
                    what: format!("{solves} solves of the rewards"),
                });
            }
        }
    }
    Ok(rewards)
}
