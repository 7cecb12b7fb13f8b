//! Gaits: their phases, and the phase spans that follow from them.

use crate::error::SceneError;
use crate::phase_span::PhaseSpan;
use crate::shape_path::{ShapePath, Sine};

/// Change of the joint values in time (lengths of slides, angles): phases that are repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Gait {
    /// Number of times that the phases are repeated.
    pub cycles: u32,
    /// Phases of one cycle; empty if the scene has no gait.
    pub phases: Vec<Phase>,
}

/// One phase of a gait.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// How the shape changes.
    pub path: ShapePath,
    /// Duration.
    pub duration: f64,
}

/// Number of phases into which a period of sines is divided: a smooth gait is integrated in steps
/// of a quarter of its period.
const PARTS_OF_PERIOD: u32 = 4;

impl Gait {
    /// Gait of smooth, simultaneous oscillations: a period in four phases of equal duration.
    ///
    /// ```
    /// use scene::{Gait, Sine, spans};
    /// use std::f64::consts::FRAC_PI_2;
    /// let sine = |joint, phase| Sine { joint, amplitude: 2.0, phase, order: 1 };
    /// let gait = Gait::harmonic(1, vec![sine(0, 0.0), sine(1, FRAC_PI_2)], 8.0);
    /// let all: Vec<_> = spans(&gait, &[8.0, 10.0])?.collect();
    /// assert_eq!((all.len(), all[0].duration), (4, 2.0));
    /// // Joint 0 starts from its mean, joint 1 from its largest value.
    /// assert_eq!(all[0].to, [10.0, 8.0]);
    /// assert!((all[0].rates(0.0)[0] - 0.5 * FRAC_PI_2 * 2.0).abs() < 1e-15);
    /// # Ok::<(), scene::SceneError>(())
    /// ```
    pub fn harmonic(cycles: u32, sines: Vec<Sine>, period: f64) -> Self {
        Self::harmonic_with_turns(cycles, sines, Vec::new(), period)
    }

    /// The same with values that change in proportion to time too: joints, with their changes in a
    /// period.
    pub fn harmonic_with_turns(
        cycles: u32,
        sines: Vec<Sine>,
        turns: Vec<(usize, f64)>,
        period: f64,
    ) -> Self {
        let part = |k: u32| f64::from(k) / f64::from(PARTS_OF_PERIOD);
        let phase = |k: u32| Phase {
            path: ShapePath::Harmonic {
                sines: sines.clone(),
                turns: turns.clone(),
                span: (part(k), part(k + 1)),
            },
            duration: period * part(1),
        };
        Self {
            cycles,
            phases: (0..PARTS_OF_PERIOD).map(phase).collect(),
        }
    }

    /// Duration of one cycle: the sum over its phases, in the scene's unit of time.
    pub fn cycle_duration(&self) -> f64 {
        self.phases.iter().map(|phase| phase.duration).sum()
    }

    /// Duration of all cycles.
    pub fn duration(&self) -> f64 {
        f64::from(self.cycles) * self.cycle_duration()
    }
}

/// The phase spans of all cycles of a gait in order, from the given initial shape.
///
/// # Errors
/// [`SceneError::BadValue`] for a phase of a joint that has no initial value, for values that are
/// not finite and durations that are not positive and finite. The gait of a [`Scene`](crate::Scene)
/// has none.
///
/// ```
/// use scene::{Gait, ShapePath, Phase, spans};
/// let close = Phase { path: ShapePath::Linear(vec![(0, 6.0)]), duration: 2.0 };
/// let open = Phase { path: ShapePath::Linear(vec![(0, 10.0)]), duration: 2.0 };
/// let gait = Gait { cycles: 3, phases: vec![close, open] };
/// let all: Vec<_> = spans(&gait, &[10.0])?.collect();
/// assert_eq!(all.len(), 6);
/// assert_eq!(all[1].shape(0.5), [8.0]);
/// assert_eq!(all[5].rates(0.5), [2.0]);
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn spans(
    gait: &Gait,
    initial_shape: &[f64],
) -> Result<impl Iterator<Item = PhaseSpan> + use<>, SceneError> {
    check(gait, initial_shape)?;
    let phases = gait.phases.clone();
    let total = phases.len().saturating_mul(gait.cycles as usize);
    let mut shape = initial_shape.to_vec();
    let mut means = initial_shape.to_vec();
    // All phases of a harmonic gait have the same sines.
    if let Some(ShapePath::Harmonic { sines, .. }) = phases.first().map(|phase| &phase.path) {
        for sine in sines {
            means[sine.joint] -= sine.at(0.0);
        }
    }
    let mut time = 0.0;
    Ok((0..total).map(move |number| {
        let phase = number % phases.len();
        let Phase { path, duration } = &phases[phase];
        // Each cycle begins with the turns of those before.
        if let (ShapePath::Harmonic { turns, .. }, 0, 1..) = (path, phase, number) {
            turns
                .iter()
                .for_each(|(joint, change)| means[*joint] += change);
        }
        let mut span = PhaseSpan {
            number,
            phase,
            joints: path.joints(),
            from: shape.clone(),
            to: shape.clone(),
            start: time,
            duration: *duration,
            means: means.clone(),
            path: path.clone(),
        };
        match path {
            ShapePath::Linear(changes) => {
                for &(joint, length) in changes {
                    span.to[joint] = length;
                }
            }
            ShapePath::Spline(path) => path.enter_end(&mut span.to),
            ShapePath::Harmonic { .. } | ShapePath::Own(_) => span.to = span.shape(1.0),
        }
        shape.clone_from(&span.to);
        time += duration;
        span
    }))
}

/// Refuses a gait that was not checked as part of a scene.
fn check(gait: &Gait, initial_shape: &[f64]) -> Result<(), SceneError> {
    let bad = |key: String, problem: String| SceneError::BadValue {
        place: "gait of a program".to_owned(),
        key,
        problem,
    };
    let positive = |key: String, value: f64| match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(bad(key, format!("is {value}; it must be positive"))),
    };
    let finite = |key: String, value: f64| match value.is_finite() {
        true => Ok(()),
        false => Err(bad(key, format!("is {value}; it must be finite"))),
    };
    let joints = initial_shape.len();
    for (joint, &length) in initial_shape.iter().enumerate() {
        finite(format!("links[{joint}].length"), length)?;
    }
    for (number, phase) in gait.phases.iter().enumerate() {
        let key = |key: &str| format!("gait.phases[{number}].{key}");
        positive(key("duration"), phase.duration)?;
        for joint in phase.path.joints() {
            if joint >= joints {
                return Err(bad(key("link"), format!("is link {joint} of {joints}")));
            }
        }
        match &phase.path {
            ShapePath::Linear(changes) => {
                for (_, length) in changes {
                    finite(key("length"), *length)?;
                }
            }
            ShapePath::Spline(path) => {
                if !path.is_finite() {
                    return Err(bad(key("path"), "has a number that is not finite".into()));
                }
            }
            ShapePath::Harmonic { sines, turns, span } => {
                for (_, change) in turns {
                    finite(key("turn"), *change)?;
                }
                for sine in sines {
                    positive(key("amplitude"), sine.amplitude)?;
                    let finite = sine.phase.is_finite() && span.0.is_finite() && span.1.is_finite();
                    if !finite {
                        return Err(bad(key("phase"), "is not finite".to_owned()));
                    }
                }
            }
            ShapePath::Own(path) => {
                if let Some(problem) = path.problem() {
                    return Err(bad(key("path"), problem));
                }
            }
        }
    }
    check_continuity(gait, initial_shape, bad)
}

/// Refuses paths of a program that do not begin where the phase before ends.
fn check_continuity(
    gait: &Gait,
    initial_shape: &[f64],
    bad: impl Fn(String, String) -> SceneError,
) -> Result<(), SceneError> {
    let mut values = initial_shape.to_vec();
    // The second cycle begins with the values at the end of the first one.
    for _ in 0..gait.cycles.min(2) {
        for (number, phase) in gait.phases.iter().enumerate() {
            match &phase.path {
                ShapePath::Own(path) => {
                    if let Some(problem) = path.jump(&values) {
                        return Err(bad(format!("gait.phases[{number}].path"), problem));
                    }
                    path.enter_values(1.0, &mut values);
                }
                ShapePath::Linear(changes) => {
                    changes.iter().for_each(|&(joint, end)| values[joint] = end);
                }
                ShapePath::Spline(path) => path.enter_end(&mut values),
                ShapePath::Harmonic { sines, turns, span } => {
                    for sine in sines {
                        values[sine.joint] += sine.at(span.1) - sine.at(span.0);
                    }
                    for (joint, change) in turns {
                        values[*joint] += change * (span.1 - span.0);
                    }
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_join_and_cycles_repeat() {
        let phase = |joint, length, duration| Phase {
            path: ShapePath::Linear(vec![(joint, length)]),
            duration,
        };
        let gait = Gait {
            cycles: 2,
            phases: vec![
                phase(0, 6.0, 1.0),
                phase(1, 7.0, 0.5),
                phase(0, 10.0, 1.0),
                phase(1, 9.0, 0.5),
            ],
        };
        // The first cycle starts from a value to which the gait never returns.
        let all: Vec<PhaseSpan> = spans(&gait, &[10.0, 8.0]).unwrap().collect();
        for pair in all.windows(2) {
            assert_eq!(pair[0].to, pair[1].from);
            assert_eq!(pair[0].start + pair[0].duration, pair[1].start);
        }
        assert_eq!(all[1].rates(0.0), [0.0, -2.0]);
        assert_eq!(all[5].rates(0.0), [0.0, -4.0]);
        assert_eq!(all[3].time(1.0), gait.cycle_duration());
        assert_eq!(all[7].time(1.0), gait.duration());
    }

    #[test]
    fn a_constant_length_does_not_change_by_rounding() {
        let hold = Phase {
            path: ShapePath::Linear(vec![]),
            duration: 1.0,
        };
        let gait = Gait {
            cycles: 1,
            phases: vec![hold],
        };
        let span = spans(&gait, &[0.1]).unwrap().next().unwrap();
        for k in 0..=100 {
            assert_eq!(span.shape(f64::from(k) / 100.0), [0.1]);
        }
    }

    #[test]
    fn a_gait_without_phases_has_no_spans() {
        let gait = Gait {
            cycles: 5,
            phases: vec![],
        };
        assert_eq!(spans(&gait, &[]).unwrap().count(), 0);
    }
}
