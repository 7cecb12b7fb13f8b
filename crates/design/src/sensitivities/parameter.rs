//! Parameters of a scene, and the same scene with another value of one of them.

use rigid::{JointDrive, JointKind};
use scene::{Scene, ShapePath, Sine};
use serde::Serialize;

use super::with_keys;
use crate::error::DesignError;
use crate::limits::joint_ranges;

/// A quantity of a scene on which its net displacement depends.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Parameter {
    /// The quantity, such as `radius of "left"`.
    #[serde(rename = "parameter")]
    pub name: String,
    /// Its value in the scene.
    pub value: f64,
    #[serde(skip)]
    pub(crate) kind: Kind,
}

/// What a parameter is, with the number of its body or joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Radius(usize),
    Length(usize),
    Amplitude(usize),
    Stiffness(usize),
    Rest(usize),
}

/// The parameters of a scene.
///
/// - the radius of each sphere that moves;
/// - the length of each driven slide at the start, or the mean of harmonics; all lengths of the
///   gait change by the same amount;
/// - the amplitude of each driven joint: half of the difference of its largest and its smallest
///   value in a cycle, for harmonics the root of the sum of their squares. Phases are stretched
///   about the start, harmonics about their mean;
/// - stiffness and rest value of each spring.
///
/// Lengths and amplitudes of a gait from a file are not among them.
///
/// # Errors
/// A gait that cannot be followed.
pub fn parameters(scene: &Scene) -> Result<Vec<Parameter>, DesignError> {
    let mut parameters = Vec::new();
    let mut add = |what: &str, of: &str, value: f64, kind: Kind| {
        parameters.push(Parameter {
            name: format!("{what} of \"{of}\""),
            value,
            kind,
        });
    };
    for (number, body) in scene.bodies().iter().enumerate() {
        if let Some(radius) = body.shape.sphere_radius()
            && !body.fixed
        {
            add("radius", &body.name, radius, Kind::Radius(number));
        }
    }
    let set = scene.articulation();
    let (joints, start) = (set.joints(), set.initial_shape());
    let from_file =
        (scene.gait().phases.iter()).any(|phase| matches!(phase.path, ShapePath::Spline(_)));
    let is_harmonic =
        (scene.gait().phases.iter()).any(|phase| matches!(phase.path, ShapePath::Harmonic { .. }));
    let ranges = joint_ranges(scene)?;
    let is_phase = |joint: usize| scene.periodic_coordinates().any(|(own, _)| own == joint);
    for (number, joint) in joints.iter().enumerate() {
        match joint.drive {
            JointDrive::Passive(passive) if passive.stiffness > 0.0 => {
                // A constant force on a spring shifts its rest.
                let rest = passive.rest + passive.force / passive.stiffness;
                let stiffness = passive.stiffness;
                add("stiffness", &joint.name, stiffness, Kind::Stiffness(number));
                add("rest value", &joint.name, rest, Kind::Rest(number));
            }
            JointDrive::Passive(_) => {}
            _ if from_file => {}
            // A gait turns the phase of a wave by whole turns, or does not close.
            _ if is_phase(number) => {}
            _ => {
                let of_joint = || sines(scene).iter().filter(|sine| sine.joint == number);
                if joint.kind == JointKind::Slide {
                    let mean = start[number] - of_joint().map(at_start).sum::<f64>();
                    add("length", &joint.name, mean, Kind::Length(number));
                }
                let squares: f64 = of_joint().map(|sine| sine.amplitude.powi(2)).sum();
                let amplitude = match squares > 0.0 {
                    true => squares.sqrt(),
                    // A joint of a gait of harmonics that only turns.
                    false if is_harmonic => 0.0,
                    false => 0.5 * (ranges[number].1 - ranges[number].0),
                };
                if amplitude > 0.0 {
                    add("amplitude", &joint.name, amplitude, Kind::Amplitude(number));
                }
            }
        }
    }
    Ok(parameters)
}

impl Parameter {
    /// The scene with another value of the parameter.
    ///
    /// # Errors
    /// A value that the scene cannot have, such as spheres that touch.
    pub fn set(&self, scene: &Scene, value: f64) -> Result<Scene, DesignError> {
        with_values(scene, &[(self, value)])
    }

    /// The keys by which a sweep varies a parameter that no single key of the scene gives:
    /// `links.NAME.length` and `links.NAME.amplitude`, and its path with the number of the link.
    pub(crate) fn keys(&self, scene: &Scene) -> Option<[String; 2]> {
        let (joint, name) = match self.kind {
            Kind::Length(joint) => (joint, "length"),
            Kind::Amplitude(joint) => (joint, "amplitude"),
            Kind::Radius(_) | Kind::Stiffness(_) | Kind::Rest(_) => return None,
        };
        let of_joint = &scene.articulation().joints()[joint].name;
        Some([
            format!("links.{of_joint}.{name}"),
            format!("links[{joint}].{name}"),
        ])
    }

    /// The keys of the scene that change with the parameter.
    ///
    /// # Errors
    /// A shape that has no pose.
    pub(crate) fn changed_keys(&self, scene: &Scene) -> Result<Vec<String>, DesignError> {
        // Another value, which need not be one that the scene can have.
        let assignments = assignments(scene, &[(self, 1.01 * self.value)])?;
        let keys = assignments.iter().filter_map(|text| text.split_once('='));
        Ok(keys.map(|(key, _)| key.to_owned()).collect())
    }
}

/// How the values of a joint change: stretched about the start, then shifted.
#[derive(Clone, Copy)]
struct JointChange {
    factor: f64,
    shift: f64,
}

impl JointChange {
    fn of_target(self, target: f64, start: f64) -> f64 {
        let stretched = match self.factor == 1.0 {
            true => target,
            false => start + self.factor * (target - start),
        };
        stretched + self.shift
    }
}

/// The scene with other values of several of its parameters, which stand for file and line in
/// messages.
///
/// # Errors
/// Values that the scene cannot have, such as spheres that touch.
pub(crate) fn with_values(
    scene: &Scene,
    values: &[(&Parameter, f64)],
) -> Result<Scene, DesignError> {
    let words: Vec<String> = (values.iter())
        .map(|(parameter, value)| format!("{} = {value:?}", parameter.name))
        .collect();
    with_values_at(scene, values, &words.join(", "))
}

/// The scene of [`with_values`]; `place` stands for file and line in messages.
pub(crate) fn with_values_at(
    scene: &Scene,
    values: &[(&Parameter, f64)],
    place: &str,
) -> Result<Scene, DesignError> {
    with_keys(scene, &assignments(scene, values)?, place)
}

/// The values of keys for other values of parameters, as for `--set`.
fn assignments(scene: &Scene, values: &[(&Parameter, f64)]) -> Result<Vec<String>, DesignError> {
    let mut keys = Vec::new();
    let joints = scene.articulation().joints();
    let unchanged = JointChange {
        factor: 1.0,
        shift: 0.0,
    };
    let mut changes = vec![unchanged; joints.len()];
    for (parameter, value) in values {
        match parameter.kind {
            Kind::Radius(body) => keys.push(format!("bodies[{body}].radius={value:?}")),
            Kind::Stiffness(joint) => keys.push(format!("links[{joint}].stiffness={value:?}")),
            Kind::Rest(joint) => keys.push(format!("links[{joint}].rest={value:?}")),
            Kind::Length(joint) => changes[joint].shift = value - parameter.value,
            Kind::Amplitude(joint) => changes[joint].factor = value / parameter.value,
        }
    }
    change_targets(scene, &mut keys, &changes);
    let mut shifts: Vec<f64> = changes.iter().map(|change| change.shift).collect();
    for (number, sine) in sines(scene).iter().enumerate() {
        let factor = changes[sine.joint].factor;
        if factor != 1.0 {
            let amplitude = factor * sine.amplitude;
            keys.push(format!("gait.harmonics[{number}].amplitude={amplitude:?}"));
            // The mean of a slide follows from where the bodies are, that of an angle is given.
            if joints[sine.joint].kind == JointKind::Slide {
                shifts[sine.joint] += (factor - 1.0) * at_start(sine);
            }
        }
    }
    if shifts.iter().any(|shift| *shift != 0.0) {
        move_start(scene, &mut keys, &shifts)?;
    }
    Ok(keys)
}

/// The value of a term at the start.
fn at_start(sine: &Sine) -> f64 {
    sine.amplitude * sine.phase.sin()
}

/// The terms of a harmonic gait, in the order of the file.
fn sines(scene: &Scene) -> &[Sine] {
    match scene.gait().phases.first().map(|phase| &phase.path) {
        Some(ShapePath::Harmonic { sines, .. }) => sines,
        _ => &[],
    }
}

/// Moves the bodies to other lengths of slides at the start.
fn move_start(scene: &Scene, keys: &mut Vec<String>, shifts: &[f64]) -> Result<(), DesignError> {
    let set = scene.articulation();
    let state = scene.initial_state();
    // Joints that turn are at zero in the pose of the file.
    let mut lengths = set.initial_shape().to_vec();
    for (length, joint) in lengths.iter_mut().zip(set.joints()) {
        if joint.kind.is_angle() {
            *length = 0.0;
        }
    }
    let before = set.place(&state, &lengths)?;
    for (length, shift) in lengths.iter_mut().zip(shifts) {
        *length += shift;
    }
    let after = set.place(&state, &lengths)?;
    let moved: Vec<_> = (after.iter().zip(&before))
        .map(|(a, b)| a.translation.vector - b.translation.vector)
        .collect();
    for (number, (body, moved)) in scene.bodies().iter().zip(&moved).enumerate() {
        let [x, y, z]: [f64; 3] = (body.position + moved).into();
        keys.push(format!("bodies[{number}].position=[{x:?}, {y:?}, {z:?}]"));
    }
    for (number, joint) in set.joints().iter().enumerate() {
        let joint = joint.kind.translated(&moved[joint.to]);
        if let JointKind::Turn { pivot, .. } | JointKind::Ball { pivot } = joint {
            let [x, y, z]: [f64; 3] = pivot.into();
            keys.push(format!("links[{number}].pivot=[{x:?}, {y:?}, {z:?}]"));
        }
    }
    Ok(())
}

/// Changes the values of joints at the ends of phases.
fn change_targets(scene: &Scene, keys: &mut Vec<String>, changes: &[JointChange]) {
    let set = scene.articulation();
    for (number, phase) in scene.gait().phases.iter().enumerate() {
        let ShapePath::Linear(targets) = &phase.path else {
            continue;
        };
        let start = set.initial_shape();
        let changed: Vec<(usize, f64)> = (targets.iter())
            .map(|&(joint, target)| (joint, changes[joint].of_target(target, start[joint])))
            .collect();
        if changed == *targets {
            continue;
        }
        let has_targets = scene.is_written(&format!("gait.phases[{number}].targets"));
        keys.push(match changed[..] {
            [(_, target)] if !has_targets => format!("gait.phases[{number}].length={target:?}"),
            _ => {
                let text = |&(k, target): &(usize, f64)| {
                    format!("{:?} = {target:?}", set.joints()[k].name)
                };
                let texts: Vec<String> = changed.iter().map(text).collect();
                format!("gait.phases[{number}].targets={{ {} }}", texts.join(", "))
            }
        });
    }
}
