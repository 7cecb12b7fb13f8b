//! Rewards: displacements of the mean of the bodies when one joint moves.

use models::Hydrodynamics;
use nalgebra::Vector3;
use scene::{Gait, JointValues, Phase, Scene, ShapePath, spans};
use swimmer::{Integrator, Method, choose, mean_of_moving, positions};

use crate::error::{DesignError, DesignProgress, check_interruption};

/// Largest number of joints: their states are all tabulated.
const MAX_JOINTS: usize = 12;

/// Rotation per step, in radians, above which a swimmer counts as turning.
const MIN_ROTATION: f64 = 1e-6;

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
        let is_right = (1..=MAX_JOINTS).contains(&joints)
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
    let refuse = |key: &str, problem: &str| DesignError::not_applicable(scene, key, problem);
    DesignError::check_rheology(scene)?;
    if !scene.is_free() {
        return Err(refuse(
            "learn",
            "learning requires a motion that depends only on the shape: one linkage in unbounded \
             fluid without external loads and passive joints",
        ));
    }
    let ends = ends(scene)?;
    let joints: Vec<usize> = (0..ends.len())
        .filter(|&k| ends[k].0 != ends[k].1)
        .collect();
    if joints.is_empty() {
        return Err(refuse(
            "learn.contracted",
            "no joint has two values; give learn.contracted, for example learn.contracted = 6",
        ));
    }
    if joints.len() > MAX_JOINTS {
        return Err(refuse("learn.contracted", "at most 12 joints can learn"));
    }
    let mut model = choose(scene)?.model;
    let names = joints
        .iter()
        .map(|&k| &scene.articulation().joints()[k].name);
    let mut rewards = Rewards {
        names: names.cloned().collect(),
        table: vec![vec![0.0; joints.len()]; 1 << joints.len()],
        joints,
        model: model.name(),
        error: 0.0,
    };
    let direction = Vector3::from(scene.learn().direction).normalize();
    let mut solves = 0;
    // Each joint can contract in half of the states.
    let all = rewards.joints.len() * rewards.states() / 2;
    let mut done = 0;
    progress.counted("rewards", done, all);
    for state in 0..rewards.states() {
        let mut shape: Vec<f64> = ends.iter().map(|end| end.0).collect();
        for (k, &joint) in rewards.joints.iter().enumerate() {
            if state >> k & 1 == 1 {
                shape[joint] = ends[joint].1;
            }
        }
        for action in (0..rewards.joints.len()).filter(|action| state >> action & 1 == 0) {
            let joint = rewards.joints[action];
            let step = contraction(scene, model.as_mut(), &shape, joint, ends[joint].1)?;
            let reward = step.displacement.dot(&direction);
            rewards.table[state][action] = reward;
            rewards.table[state | 1 << action][action] = -reward;
            rewards.error = rewards.error.max(step.error);
            solves += step.solves;
            done += 1;
            progress.counted("rewards", done, all);
            check_interruption(progress, || format!("{solves} solves of the rewards"))?;
        }
    }
    Ok(rewards)
}

/// The extended and the contracted value of each joint, equal for joints that do not learn.
fn ends(scene: &Scene) -> Result<Vec<(f64, f64)>, DesignError> {
    let values = |key: &str, values: &Option<JointValues>| match values {
        Some(values) => scene.joint_values(key, values),
        None => Ok(vec![None; scene.articulation().joints().len()]),
    };
    let contracted = values("learn.contracted", &scene.learn().contracted)?;
    let extended = values("learn.extended", &scene.learn().extended)?;
    let initial = scene.articulation().initial_shape().iter().enumerate();
    Ok(initial
        .map(|(joint, &initial)| {
            let extended = extended[joint].unwrap_or(initial);
            (extended, contracted[joint].unwrap_or(extended))
        })
        .collect())
}

/// The displacement of the mean of the bodies by the change of one joint.
#[derive(Default)]
struct Contraction {
    displacement: Vector3<f64>,
    error: f64,
    solves: usize,
}

/// Changes one joint of a shape to the value `target`.
///
/// # Errors
/// A swimmer that turns; errors of the model.
fn contraction(
    scene: &Scene,
    model: &mut dyn Hydrodynamics,
    shape: &[f64],
    joint: usize,
    target: f64,
) -> Result<Contraction, DesignError> {
    let (set, start) = (scene.articulation(), scene.initial_state());
    let phase = Phase {
        path: ShapePath::Linear(vec![(joint, target)]),
        duration: 1.0,
    };
    let gait = Gait {
        cycles: 1,
        phases: vec![phase],
    };
    let mut contraction = Contraction::default();
    for span in spans(&gait, shape)? {
        let mut integrator = Integrator::new(scene, model, Method::Collocation);
        let result = integrator.span(&span, &start, &mut |_, _| Ok(()))?;
        let [before, after] = [&start, &result.end].map(|state| state.frames[0].rotation);
        if after.angle_to(&before) > MIN_ROTATION {
            return Err(DesignError::not_applicable(
                scene,
                "learn",
                "the swimmer turns, so that rewards depend on its direction too; use a chain of \
                 bodies on a line",
            ));
        }
        let before = positions(set, &start, &span.from)?;
        let after = positions(set, &result.end, &span.to)?;
        let moved: Vec<_> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
        contraction = Contraction {
            displacement: mean_of_moving(&moved),
            error: result.error_estimate.total(),
            solves: contraction.solves + result.solves,
        };
    }
    Ok(contraction)
}
