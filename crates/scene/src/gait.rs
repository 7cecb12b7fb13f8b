//! Gaits: their phases, and the legs of a stroke.

use std::f64::consts::TAU;

use crate::error::SceneError;

/// Change of the link lengths in time: phases that are repeated.
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
    /// How the lengths change.
    pub path: LengthPath,
    /// Duration.
    pub duration: f64,
}

/// Lengths of the links along a phase, as functions of the part `s` of the phase that is over.
#[derive(Clone, Debug, PartialEq)]
pub enum LengthPath {
    /// Links change their lengths at constant rates to the given ones; all others keep theirs.
    ///
    /// Without links all lengths are constant.
    Linear(Vec<(usize, f64)>),
    /// Cubic polynomials, such as the pieces of a spline.
    Cubic(Vec<CubicLength>),
    /// Part of a period of sums of sines.
    Harmonic {
        /// The terms of all links.
        sines: Vec<Sine>,
        /// Begin and end of the phase, in periods.
        span: (f64, f64),
    },
}

/// One term of a periodic length: `amplitude sin(2 π order t / T + phase)` with the period `T`.
///
/// A link may have several terms. Their mean is such that the length at `t = 0` is the initial one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// The link.
    pub link: usize,
    /// Amplitude.
    pub amplitude: f64,
    /// Phase angle at `t = 0`, in radians.
    pub phase: f64,
    /// Number of oscillations in a period.
    pub order: u32,
}

/// Length of a link along a phase, a cubic polynomial in `s`:
///
/// ```text
/// begin + (end - begin) s + square (s^2 - s) + cube (s^3 - s)
/// ```
///
/// It begins with the length at the end of the phase before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicLength {
    /// The link.
    pub link: usize,
    /// Length at the end.
    pub end: f64,
    /// Coefficient of the second degree.
    pub square: f64,
    /// Coefficient of the third degree.
    pub cube: f64,
}

impl LengthPath {
    /// The links whose lengths change, each once, in the order of their first terms.
    pub fn links(&self) -> Vec<usize> {
        let mut links = Vec::new();
        let mut add = |link: usize| {
            if !links.contains(&link) {
                links.push(link);
            }
        };
        match self {
            Self::Linear(changes) => changes.iter().for_each(|(link, _)| add(*link)),
            Self::Cubic(pieces) => pieces.iter().for_each(|piece| add(piece.link)),
            Self::Harmonic { sines, .. } => sines.iter().for_each(|sine| add(sine.link)),
        }
        links
    }
}

/// One phase of one cycle, with the lengths as functions of the parameter `s` from 0 to 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// Number of the leg over all cycles, from zero.
    pub number: usize,
    /// Number of the phase within its cycle, from zero.
    pub phase: usize,
    /// The links that change their lengths.
    pub links: Vec<usize>,
    /// Lengths of the links at `s` = 0.
    pub from: Vec<f64>,
    /// Lengths of the links at `s` = 1.
    pub to: Vec<f64>,
    /// Time at `s` = 0.
    pub start: f64,
    /// Duration.
    pub duration: f64,
    /// Mean lengths of the links, about which those with sines oscillate.
    means: Vec<f64>,
    path: LengthPath,
}

/// Number of parts of a leg at whose ends its lengths are evaluated where their range is needed.
const RANGE_PARTS: usize = 64;

impl Leg {
    /// Lengths of the links at `s`.
    pub fn lengths(&self, s: f64) -> Vec<f64> {
        // In this form a constant length is reproduced to the last bit.
        let linear = || {
            let ends = self.from.iter().zip(&self.to);
            ends.map(|(a, b)| a + s * (b - a)).collect::<Vec<f64>>()
        };
        match &self.path {
            LengthPath::Linear(_) => linear(),
            LengthPath::Cubic(pieces) => {
                let mut lengths = linear();
                for piece in pieces {
                    lengths[piece.link] += s * (s - 1.0) * (piece.square + piece.cube * (s + 1.0));
                }
                lengths
            }
            LengthPath::Harmonic { sines, span } => {
                let mut lengths = self.means.clone();
                for sine in sines {
                    lengths[sine.link] += sine.at(span.0 + s * (span.1 - span.0));
                }
                lengths
            }
        }
    }

    /// Rates of change of the lengths in time at `s`.
    pub fn rates(&self, s: f64) -> Vec<f64> {
        let linear = || {
            let ends = self.from.iter().zip(&self.to);
            ends.map(|(a, b)| (b - a) / self.duration)
                .collect::<Vec<f64>>()
        };
        match &self.path {
            LengthPath::Linear(_) => linear(),
            LengthPath::Cubic(pieces) => {
                let mut rates = linear();
                for piece in pieces {
                    let bend = piece.square * (2.0 * s - 1.0) + piece.cube * (3.0 * s * s - 1.0);
                    rates[piece.link] += bend / self.duration;
                }
                rates
            }
            LengthPath::Harmonic { sines, span } => {
                let width = span.1 - span.0;
                let mut rates = vec![0.0; self.means.len()];
                for sine in sines {
                    rates[sine.link] += sine.derivative(span.0 + s * width) * width / self.duration;
                }
                rates
            }
        }
    }

    /// Intervals that contain the lengths of the links along the leg.
    ///
    /// Those of linear paths are sharp. Others are too wide by at most 3e-5 of the largest second
    /// derivative with respect to `s`, for a sine 8e-5 of the amplitude times the order squared.
    pub fn ranges(&self) -> Vec<(f64, f64)> {
        let mut ranges: Vec<(f64, f64)> = (self.from.iter().zip(&self.to))
            .map(|(&a, &b)| (a.min(b), a.max(b)))
            .collect();
        // Largest second derivatives with respect to `s`.
        let bends: Vec<(usize, f64)> = match &self.path {
            LengthPath::Linear(_) => return ranges,
            LengthPath::Cubic(pieces) => (pieces.iter())
                .map(|piece| {
                    (
                        piece.link,
                        2.0 * piece.square.abs() + 6.0 * piece.cube.abs(),
                    )
                })
                .collect(),
            LengthPath::Harmonic { sines, span } => {
                let angle = |sine: &Sine| TAU * f64::from(sine.order) * (span.1 - span.0);
                let bend = |sine: &Sine| (sine.link, sine.amplitude * angle(sine).powi(2));
                sines.iter().map(bend).collect()
            }
        };
        for k in 1..RANGE_PARTS {
            let lengths = self.lengths(k as f64 / RANGE_PARTS as f64);
            for (range, length) in ranges.iter_mut().zip(lengths) {
                *range = (range.0.min(length), range.1.max(length));
            }
        }
        for (link, bend) in bends {
            // Between two points a function leaves the interval of its values there by at most an
            // eighth of the largest second derivative times the square of their distance.
            let excess = 0.125 * bend / (RANGE_PARTS * RANGE_PARTS) as f64;
            ranges[link] = (ranges[link].0 - excess, ranges[link].1 + excess);
        }
        ranges
    }

    /// Whether lengths are linear in `s`.
    pub fn is_linear(&self) -> bool {
        matches!(self.path, LengthPath::Linear(_))
    }

    /// Time at `s`.
    pub fn time(&self, s: f64) -> f64 {
        self.start + s * self.duration
    }
}

impl Sine {
    fn angle(&self, periods: f64) -> f64 {
        TAU * f64::from(self.order) * periods + self.phase
    }

    /// The term after a number of periods.
    pub(crate) fn at(&self, periods: f64) -> f64 {
        self.amplitude * self.angle(periods).sin()
    }

    /// Derivative with respect to the number of periods.
    fn derivative(&self, periods: f64) -> f64 {
        self.amplitude * TAU * f64::from(self.order) * self.angle(periods).cos()
    }
}

/// Number of phases into which a period of sines is divided: a smooth gait is integrated in steps of
/// a quarter of its period.
const PARTS_OF_PERIOD: u32 = 4;

impl Gait {
    /// Gait of smooth, simultaneous oscillations: a period in four phases of equal duration.
    ///
    /// ```
    /// use scene::{Gait, Sine, legs};
    /// use std::f64::consts::FRAC_PI_2;
    /// let sine = |link, phase| Sine { link, amplitude: 2.0, phase, order: 1 };
    /// let gait = Gait::harmonic(1, vec![sine(0, 0.0), sine(1, FRAC_PI_2)], 8.0);
    /// let all: Vec<_> = legs(&gait, &[8.0, 10.0])?.collect();
    /// assert_eq!((all.len(), all[0].duration), (4, 2.0));
    /// // Link 0 starts from its mean, link 1 from its largest length.
    /// assert_eq!(all[0].to, [10.0, 8.0]);
    /// assert!((all[0].rates(0.0)[0] - 0.5 * FRAC_PI_2 * 2.0).abs() < 1e-15);
    /// # Ok::<(), scene::SceneError>(())
    /// ```
    pub fn harmonic(cycles: u32, sines: Vec<Sine>, period: f64) -> Self {
        let part = |k: u32| f64::from(k) / f64::from(PARTS_OF_PERIOD);
        let phase = |k: u32| Phase {
            path: LengthPath::Harmonic {
                sines: sines.clone(),
                span: (part(k), part(k + 1)),
            },
            duration: period * part(1),
        };
        Self {
            cycles,
            phases: (0..PARTS_OF_PERIOD).map(phase).collect(),
        }
    }

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
/// use scene::{Gait, LengthPath, Phase, legs};
/// let close = Phase { path: LengthPath::Linear(vec![(0, 6.0)]), duration: 2.0 };
/// let open = Phase { path: LengthPath::Linear(vec![(0, 10.0)]), duration: 2.0 };
/// let gait = Gait { cycles: 3, phases: vec![close, open] };
/// let all: Vec<_> = legs(&gait, &[10.0])?.collect();
/// assert_eq!(all.len(), 6);
/// assert_eq!(all[1].lengths(0.5), [8.0]);
/// assert_eq!(all[5].rates(0.5), [2.0]);
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
    let mut means = initial_lengths.to_vec();
    // All phases of a harmonic gait have the same sines.
    if let Some(LengthPath::Harmonic { sines, .. }) = phases.first().map(|phase| &phase.path) {
        for sine in sines {
            means[sine.link] -= sine.at(0.0);
        }
    }
    let mut time = 0.0;
    Ok((0..total).map(move |number| {
        let phase = number % phases.len();
        let Phase { path, duration } = &phases[phase];
        let mut leg = Leg {
            number,
            phase,
            links: path.links(),
            from: lengths.clone(),
            to: lengths.clone(),
            start: time,
            duration: *duration,
            means: means.clone(),
            path: path.clone(),
        };
        match path {
            LengthPath::Linear(changes) => {
                for &(link, length) in changes {
                    leg.to[link] = length;
                }
            }
            LengthPath::Cubic(pieces) => {
                for piece in pieces {
                    leg.to[piece.link] = piece.end;
                }
            }
            LengthPath::Harmonic { .. } => leg.to = leg.lengths(1.0),
        }
        lengths.clone_from(&leg.to);
        time += duration;
        leg
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
        for link in phase.path.links() {
            if link >= links {
                return Err(bad(key("link"), format!("is link {link} of {links}")));
            }
        }
        match &phase.path {
            LengthPath::Linear(changes) => {
                for (_, length) in changes {
                    positive(key("length"), *length)?;
                }
            }
            LengthPath::Cubic(pieces) => {
                for piece in pieces {
                    positive(key("length"), piece.end)?;
                    if !(piece.square.is_finite() && piece.cube.is_finite()) {
                        return Err(bad(
                            key("length"),
                            "has a coefficient that is not finite".into(),
                        ));
                    }
                }
            }
            LengthPath::Harmonic { sines, span } => {
                for sine in sines {
                    positive(key("amplitude"), sine.amplitude)?;
                    let finite = sine.phase.is_finite() && span.0.is_finite() && span.1.is_finite();
                    if !finite {
                        return Err(bad(key("phase"), "is not finite".to_owned()));
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
    fn legs_join_and_cycles_repeat() {
        let phase = |link, length, duration| Phase {
            path: LengthPath::Linear(vec![(link, length)]),
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
        assert_eq!(all[1].rates(0.0), [0.0, -2.0]);
        assert_eq!(all[5].rates(0.0), [0.0, -4.0]);
        assert_eq!(all[7].time(1.0), gait.duration());
    }

    #[test]
    fn a_constant_length_does_not_change_by_rounding() {
        let hold = Phase {
            path: LengthPath::Linear(vec![]),
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

    #[test]
    fn sines_of_several_orders_close_and_their_ranges_contain_them() {
        let sine = |link, amplitude, phase, order| Sine {
            link,
            amplitude,
            phase,
            order,
        };
        let sines = vec![
            sine(0, 2.0, 0.3, 1),
            sine(0, 0.5, 1.0, 3),
            sine(2, 1.0, 2.0, 2),
        ];
        let gait = Gait::harmonic(2, sines, 6.0);
        let initial = [8.0, 5.0, 7.0];
        let all: Vec<Leg> = legs(&gait, &initial).unwrap().collect();
        assert_eq!(all.len(), 8);
        assert_eq!(all[0].links, [0, 2]);
        assert_eq!(gait.duration(), 12.0);
        for (a, b) in initial.iter().zip(&all[7].to) {
            assert!((a - b).abs() < 1e-14);
        }
        for leg in &all {
            let ranges = leg.ranges();
            for k in 0..=1000 {
                let s = f64::from(k) / 1000.0;
                let lengths = leg.lengths(s);
                assert_eq!(lengths[1], 5.0);
                for (length, range) in lengths.iter().zip(&ranges) {
                    assert!((range.0..=range.1).contains(length));
                }
                // Central differences with d = 1e-5: rounding 1e-15 / d and d^2 times the third derivative.
                let d = 1e-5;
                let [before, after] = [leg.lengths(s - d), leg.lengths(s + d)];
                for (link, rate) in leg.rates(s).iter().enumerate() {
                    let expected = (after[link] - before[link]) / (2.0 * d * leg.duration);
                    assert!((rate - expected).abs() < 1e-8, "{rate} {expected}");
                }
            }
            // The true extremes are at most 8e-5 of the amplitudes times the orders squared away.
            let lengths: Vec<f64> = (0..=1000)
                .map(|k| leg.lengths(1e-3 * f64::from(k))[0])
                .collect();
            let (low, high) = lengths
                .iter()
                .fold((f64::MAX, f64::MIN), |(low, high), &length| {
                    (low.min(length), high.max(length))
                });
            let allowed = 8e-5 * (2.0 + 0.5 * 9.0);
            assert!(low - ranges[0].0 < allowed && ranges[0].1 - high < allowed);
        }
    }
}
