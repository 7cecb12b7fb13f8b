//! Gaits: their phases, and the legs of a stroke.

use crate::error::SceneError;

/// Change of the link lengths in time: phases that are repeated.
#[derive(Clone, Debug, PartialEq)]
pub struct Gait {
    /// Number of times that the phases are repeated.
    pub cycles: u32,
    /// Phases of one cycle; empty if the scene has no gait.
    pub phases: Vec<Phase>,
}

/// One phase of a gait: at most one link changes its length, at a constant rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phase {
    /// The link and its length at the end; `None` if all lengths are constant.
    pub change: Option<(usize, f64)>,
    /// Duration.
    pub duration: f64,
}

/// One phase of one cycle, along which all lengths are linear in the parameter `s` from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// Number of the leg over all cycles, from zero.
    pub number: usize,
    /// Number of the phase within its cycle, from zero.
    pub phase: usize,
    /// The link that changes its length, if any.
    pub link: Option<usize>,
    /// Lengths of the links at `s` = 0.
    pub from: Vec<f64>,
    /// Lengths of the links at `s` = 1.
    pub to: Vec<f64>,
    /// Time at `s` = 0.
    pub start: f64,
    /// Duration.
    pub duration: f64,
}

impl Leg {
    /// Lengths of the links at `s`.
    pub fn lengths(&self, s: f64) -> Vec<f64> {
        // In this form a constant length is reproduced to the last bit.
        self.from
            .iter()
            .zip(&self.to)
            .map(|(a, b)| a + s * (b - a))
            .collect()
    }

    /// Rates of change of the lengths in time.
    pub fn rates(&self) -> Vec<f64> {
        self.from
            .iter()
            .zip(&self.to)
            .map(|(a, b)| (b - a) / self.duration)
            .collect()
    }

    /// Time at `s`.
    pub fn time(&self, s: f64) -> f64 {
        self.start + s * self.duration
    }
}

impl Gait {
    /// Duration of all cycles.
    pub fn duration(&self) -> f64 {
        f64::from(self.cycles) * self.phases.iter().map(|phase| phase.duration).sum::<f64>()
    }
}

/// The legs of all cycles of a gait in order, from the given initial lengths.
///
/// # Errors
/// [`SceneError::BadValue`] for a phase of a link that has no initial length, and for lengths and
/// durations that are not positive and finite. The gait of a [`Scene`](crate::Scene) has none.
///
/// ```
/// use scene::{Gait, Phase, legs};
/// let close = Phase { change: Some((0, 6.0)), duration: 2.0 };
/// let open = Phase { change: Some((0, 10.0)), duration: 2.0 };
/// let gait = Gait { cycles: 3, phases: vec![close, open] };
/// let all: Vec<_> = legs(&gait, &[10.0])?.collect();
/// assert_eq!(all.len(), 6);
/// assert_eq!(all[1].lengths(0.5), [8.0]);
/// assert_eq!(all[5].rates(), [2.0]);
/// # Ok::<(), scene::SceneError>(())
/// ```
pub fn legs(
    gait: &Gait,
    initial_lengths: &[f64],
) -> Result<impl Iterator<Item = Leg> + use<>, SceneError> {
    check(gait, initial_lengths)?;
    let phases = gait.phases.clone();
    let total = phases.len().saturating_mul(gait.cycles as usize);
    let mut lengths = initial_lengths.to_vec();
    let mut time = 0.0;
    Ok((0..total).map(move |number| {
        let phase = number % phases.len();
        let from = lengths.clone();
        if let Some((link, length)) = phases[phase].change {
            lengths[link] = length;
        }
        let start = time;
        time += phases[phase].duration;
        Leg {
            number,
            phase,
            link: phases[phase].change.map(|(link, _)| link),
            from,
            to: lengths.clone(),
            start,
            duration: phases[phase].duration,
        }
    }))
}

/// Refuses a gait that was not checked as part of a scene.
fn check(gait: &Gait, initial_lengths: &[f64]) -> Result<(), SceneError> {
    let bad = |key: String, problem: String| SceneError::BadValue {
        place: "gait of a program".to_owned(),
        key,
        problem,
    };
    let positive = |key: String, value: f64| match value > 0.0 && value.is_finite() {
        true => Ok(()),
        false => Err(bad(key, format!("is {value}; it must be positive"))),
    };
    let links = initial_lengths.len();
    for (link, &length) in initial_lengths.iter().enumerate() {
        positive(format!("links[{link}].length"), length)?;
    }
    for (number, phase) in gait.phases.iter().enumerate() {
        let key = |key: &str| format!("gait.phases[{number}].{key}");
        positive(key("duration"), phase.duration)?;
        if let Some((link, length)) = phase.change {
            if link >= links {
                return Err(bad(key("link"), format!("is link {link} of {links}")));
            }
            positive(key("length"), length)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn legs_join_and_cycles_repeat() {
        let phase = |link, length, duration| Phase {
            change: Some((link, length)),
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
        // The first cycle starts from a length to which the gait never returns.
        let all: Vec<Leg> = legs(&gait, &[10.0, 8.0]).unwrap().collect();
        for pair in all.windows(2) {
            assert_eq!(pair[0].to, pair[1].from);
            assert_eq!(pair[0].start + pair[0].duration, pair[1].start);
        }
        assert_eq!(all[1].rates(), [0.0, -2.0]);
        assert_eq!(all[5].rates(), [0.0, -4.0]);
        assert_eq!(all[7].time(1.0), gait.duration());
    }

    #[test]
    fn a_constant_length_does_not_change_by_rounding() {
        let hold = Phase {
            change: None,
            duration: 1.0,
        };
        let gait = Gait {
            cycles: 1,
            phases: vec![hold],
        };
        let leg = legs(&gait, &[0.1]).unwrap().next().unwrap();
        for k in 0..=100 {
            assert_eq!(leg.lengths(f64::from(k) / 100.0), [0.1]);
        }
    }

    #[test]
    fn a_gait_without_phases_has_no_legs() {
        let gait = Gait {
            cycles: 5,
            phases: vec![],
        };
        assert_eq!(legs(&gait, &[]).unwrap().count(), 0);
    }
}
