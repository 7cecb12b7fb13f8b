//! Shapes (values of joints) as functions of time along a phase.

use std::collections::HashSet;
use std::f64::consts::TAU;
use std::fmt;
use std::sync::Arc;

use crate::spline_path::SplinePath;

/// Values of the joints along a phase, as functions of the part `s` of the phase that is over.
#[derive(Clone, Debug, PartialEq)]
pub enum ShapePath {
    /// Joints change their values at constant rates to the given ones; all others keep theirs.
    ///
    /// Without joints all values are constant.
    Linear(Vec<(usize, f64)>),
    /// Part of the cubic splines through the rows of a table.
    Spline(SplinePath),
    /// Part of a period of sums of sines.
    Harmonic {
        /// The terms of all joints.
        sines: Vec<Sine>,
        /// Joints whose values change in proportion to time too, with the change in a period: the
        /// phases of waves turn.
        turns: Vec<(usize, f64)>,
        /// Begin and end of the phase, in periods.
        span: (f64, f64),
    },
    /// A path that a program defines.
    Own(OwnPath),
}

/// One term of a periodic value: `amplitude sin(2 π order t / T + phase)` with the period `T`.
///
/// A joint may have several terms. Their mean is such that the value at `t = 0` is the initial
/// one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sine {
    /// The joint.
    pub joint: usize,
    /// Amplitude.
    pub amplitude: f64,
    /// Phase angle at `t = 0`, in radians.
    pub phase: f64,
    /// Number of oscillations in a period.
    pub order: u32,
}

impl ShapePath {
    /// The joints whose values change, each once, in the order of their first terms.
    pub fn joints(&self) -> Vec<usize> {
        let mut joints = Vec::new();
        let mut known = HashSet::new();
        let mut add = |joint: usize| {
            if known.insert(joint) {
                joints.push(joint);
            }
        };
        match self {
            Self::Linear(changes) => changes.iter().for_each(|(joint, _)| add(*joint)),
            Self::Spline(path) => path.joints().for_each(add),
            Self::Harmonic { sines, turns, .. } => {
                sines.iter().for_each(|sine| add(sine.joint));
                turns.iter().for_each(|(joint, _)| add(*joint));
            }
            Self::Own(path) => path.0.joints().into_iter().for_each(add),
        }
        joints
    }
}

/// The angle `2 π order periods + phase` of an oscillation after a number of periods.
pub(crate) fn angle(order: u32, periods: f64, phase: f64) -> f64 {
    TAU * f64::from(order) * periods + phase
}

impl Sine {
    pub(crate) fn angle(&self, periods: f64) -> f64 {
        angle(self.order, periods, self.phase)
    }

    /// The term after a number of periods.
    pub(crate) fn at(&self, periods: f64) -> f64 {
        self.amplitude * self.angle(periods).sin()
    }

    /// Derivative with respect to the number of periods.
    pub(crate) fn derivative(&self, periods: f64) -> f64 {
        self.amplitude * TAU * f64::from(self.order) * self.angle(periods).cos()
    }
}

/// A force on a passive joint, a torque for joints that turn:
/// `amplitude sin(2 π order t / period + phase)` at the time `t`.
///
/// It acts in addition to the constant part, [`rigid::PassiveDrive::force`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointForce {
    /// The joint, with amplitude, phase and order; a positive force increases the value.
    pub sine: Sine,
    /// Period of a term of the order one.
    pub period: f64,
}

impl JointForce {
    /// The force at a time.
    pub fn at(&self, time: f64) -> f64 {
        self.sine.at(time / self.period)
    }
}

/// Values of joints along a phase, as smooth functions of the part `s` of the phase that is over.
///
/// Corners belong at the ends of phases: [`ShapePath::Own`](crate::ShapePath::Own) is one phase,
/// and a gait can have several. Inside a phase jumps and corners are refused.
///
/// ```
/// use std::f64::consts::PI;
/// use std::sync::Arc;
///
/// use scene::{Gait, JointPath, ShapePath, OwnPath, Phase, Scene};
///
/// /// Two arms that close to 9 and open again, the right one later.
/// #[derive(Debug)]
/// struct Bump;
///
/// impl JointPath for Bump {
///     fn joints(&self) -> Vec<usize> {
///         vec![0, 1]
///     }
///
///     fn values(&self, s: f64) -> Vec<f64> {
///         let square = |x: f64| x * x;
///         [s, s * s].map(|t| 10.0 - square((PI * t).sin())).to_vec()
///     }
/// }
///
/// let scene = Scene::builder()
///     .sphere("left", 1.0, [-10.0, 0.0, 0.0])
///     .sphere("middle", 1.0, [0.0, 0.0, 0.0])
///     .sphere("right", 1.0, [10.0, 0.0, 0.0])
///     .slide("rear", "left", "middle")
///     .slide("front", "right", "middle")
///     .build()?;
/// let path = ShapePath::Own(OwnPath(Arc::new(Bump)));
/// let gait = Gait { cycles: 2, phases: vec![Phase { path, duration: 5.0 }] };
/// // `swimmer::simulate` moves the bodies along it.
/// let scene = scene.with_gait(gait)?;
/// assert_eq!(scene.gait().duration(), 10.0);
/// # Ok::<(), scene::SceneError>(())
/// ```
pub trait JointPath: fmt::Debug + Send + Sync {
    /// The joints whose values change, each once.
    fn joints(&self) -> Vec<usize>;

    /// Values of these joints at `s` in [0, 1]: lengths of slides, angles of others in radians.
    fn values(&self, s: f64) -> Vec<f64>;

    /// Derivatives of the values with respect to `s`.
    ///
    /// By default the seven-point differences of the values, whose error is about 1e-9 of the
    /// amplitude for up to five oscillations in a phase. Exact ones save six evaluations of the
    /// values; a scene refuses a path whose derivatives contradict its values.
    fn derivatives(&self, s: f64) -> Vec<f64> {
        differences(|s| self.values(s), s, DIFFERENCE_STEP)
    }
}

/// Step of the differences, a part of the phase: it balances the errors of rounding and of the
/// formula, 1e-12 and 2e-10, for five oscillations of amplitude one.
const DIFFERENCE_STEP: f64 = 1.0 / 1024.0;

/// Derivatives of a list of values at `s` in [0, 1], by the polynomial of degree six through seven
/// points of this distance, none of which is outside [0, 1].
fn differences(values: impl Fn(f64) -> Vec<f64>, s: f64, step: f64) -> Vec<f64> {
    let nodes = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0];
    let centre = s.clamp(3.0 * step, 1.0 - 3.0 * step);
    let at = (s - centre) / step;
    let mut sums = Vec::new();
    for (j, node) in nodes.into_iter().enumerate() {
        // Derivative of the Lagrange polynomial of the node.
        let others = || (0..nodes.len()).filter(move |&k| k != j);
        let terms = others().map(|k| {
            let factors = others().filter(|&m| m != k);
            let product: f64 = factors
                .map(|m| (at - nodes[m]) / (node - nodes[m]))
                .product();
            product / (node - nodes[k])
        });
        let weight = terms.sum::<f64>() / step;
        let values = values(centre + node * step);
        sums.resize(values.len().max(sums.len()), 0.0);
        (sums.iter_mut().zip(values)).for_each(|(sum, value)| *sum += weight * value);
    }
    sums
}

/// Rounding of a difference of values of this size, on points at the distance `step`.
///
/// The weights of a formula at an end of the phase have the sum 13 / `step`; values of a few
/// operations have errors of some units in the last place.
fn rounding_of_differences(size: f64, step: f64) -> f64 {
    64.0 * f64::EPSILON * size / step
}

/// A path of a program; two are equal if they are the same object.
#[derive(Clone, Debug)]
pub struct OwnPath(pub Arc<dyn JointPath>);

impl PartialEq for OwnPath {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl OwnPath {
    /// Enters the values at `s` into the list of all joints.
    pub(crate) fn enter_values(&self, s: f64, all: &mut [f64]) {
        enter(&self.0.joints(), self.0.values(s), all);
    }

    /// Enters the derivatives at `s`, times a factor, into the list of all joints.
    pub(crate) fn enter_derivatives(&self, s: f64, factor: f64, all: &mut [f64]) {
        let derivatives = self.0.derivatives(s).into_iter();
        enter(&self.0.joints(), derivatives.map(|d| factor * d), all);
    }

    /// What is wrong with the functions of the path, wherever it begins.
    pub(crate) fn problem(&self) -> Option<String> {
        let joints = self.0.joints();
        for s in [0.0, 0.5, 1.0] {
            for (what, list) in [
                ("values", self.0.values(s)),
                ("derivatives", self.0.derivatives(s)),
            ] {
                if list.len() != joints.len() || !list.iter().all(|x| x.is_finite()) {
                    return Some(format!(
                        "returns a list of {} {what} at s = {s} for {} links: not all finite or \
                         not one for each link",
                        list.len(),
                        joints.len()
                    ));
                }
            }
        }
        (self.jump_inside())
            .or_else(|| self.corner_inside())
            .or_else(|| self.wrong_derivative())
    }

    /// A jump of the values or of the derivatives inside the phase.
    ///
    /// Each of the intervals between checked places is halved until it is as short as rounding
    /// allows, always to the half whose ends differ more: the difference at the ends becomes small
    /// unless there is a jump.
    fn jump_inside(&self) -> Option<String> {
        let functions: [(_, &dyn Fn(f64) -> Vec<f64>); 2] = [
            ("value", &|s| self.0.values(s)),
            ("derivative", &|s| self.0.derivatives(s)),
        ];
        for (what, function) in functions {
            for (number, joint) in self.0.joints().into_iter().enumerate() {
                let at = |s: f64| function(s).get(number).copied().unwrap_or(f64::NAN);
                let nodes = (0..=CHECKED_PLACES).map(|k| f64::from(k) / f64::from(CHECKED_PLACES));
                let nodes: Vec<(f64, f64)> = nodes.map(|s| (s, at(s))).collect();
                let largest = nodes.iter().fold(0.0, |max: f64, (_, x)| max.max(x.abs()));
                // Derivatives may be differences of the values.
                let values = nodes.iter().map(|(s, _)| self.0.values(*s));
                let sizes = values.map(|all| all.get(number).map_or(f64::NAN, |x| x.abs()));
                let rounding = rounding_of_differences(sizes.fold(0.0, f64::max), DIFFERENCE_STEP);
                let allowed = MAX_CONTRADICTION * largest + rounding;
                for pair in nodes.windows(2) {
                    let [mut a, mut b] = [pair[0], pair[1]];
                    for _ in 0..HALVINGS {
                        let s = 0.5 * (a.0 + b.0);
                        let middle = (s, at(s));
                        match (middle.1 - a.1).abs() > (b.1 - middle.1).abs() {
                            true => b = middle,
                            false => a = middle,
                        }
                    }
                    if (b.1 - a.1).abs() > allowed {
                        return Some(jump_text(what, joint, a.1, b));
                    }
                }
            }
        }
        None
    }

    /// A corner of the values inside the phase, also one that differences of the values round off.
    ///
    /// Where the slopes over [`SLOPE_STEP`] deviate most from a straight line over two intervals,
    /// the interval is halved to the half in which they deviate more. Four halvings divide the
    /// deviation by 256 if the path is smooth, but leave that of a corner. Among the deviations of
    /// one oscillation in a phase, a corner of 1e-4 of the largest slope is found.
    fn corner_inside(&self) -> Option<String> {
        for (number, joint) in self.0.joints().into_iter().enumerate() {
            let value = |s: f64| self.0.values(s).get(number).copied().unwrap_or(f64::NAN);
            let slope = |s: f64| {
                let s = s.min(1.0 - SLOPE_STEP);
                (s, (value(s + SLOPE_STEP) - value(s)) / SLOPE_STEP)
            };
            let place = |k: u32| f64::from(k) / f64::from(CORNER_PLACES);
            let slopes: Vec<_> = (0..=CORNER_PLACES).map(|k| slope(place(k))).collect();
            let deviation = |[a, m, b]: &[(f64, f64); 3]| (m.1 - 0.5 * (a.1 + b.1)).abs();
            let more = |a: [_; 3], b: [_; 3]| if deviation(&b) > deviation(&a) { b } else { a };
            let mut parts = slopes.windows(3).map(|w| [w[0], w[1], w[2]]);
            let Some(mut part) = parts.next().map(|first| parts.fold(first, more)) else {
                continue;
            };
            let mut deviations = vec![deviation(&part)];
            for _ in 0..CORNER_HALVINGS {
                let [a, m, b] = part;
                let half = |a: (f64, f64), b: (f64, f64)| [a, slope(0.5 * (a.0 + b.0)), b];
                part = more(half(a, m), half(m, b));
                deviations.push(deviation(&part));
            }
            let largest = slopes.iter().fold(0.0, |max: f64, (_, x)| max.max(x.abs()));
            let size =
                (0..=CHECKED_PLACES).map(|k| value(f64::from(k) / f64::from(CHECKED_PLACES)));
            let size = size.fold(0.0, |max: f64, x| max.max(x.abs()));
            let rounding = rounding_of_differences(size, SLOPE_STEP);
            let [.., before, _, _, _, last] = deviations[..] else {
                continue;
            };
            if last > 0.5 * before && last > MAX_CONTRADICTION * largest + rounding {
                return Some(jump_text("slope", joint, part[0].1, part[2]));
            }
        }
        None
    }

    /// A jump from the values `from` of all joints to the begin of the path.
    pub(crate) fn jump(&self, from: &[f64]) -> Option<String> {
        let starts = self.0.joints().into_iter().zip(self.0.values(0.0));
        for (joint, start) in starts {
            if (start - from[joint]).abs() > CONTINUITY * from[joint].abs().max(1.0) {
                return Some(format!(
                    "begins with {start} for link {joint}, but the value before it is {}",
                    from[joint]
                ));
            }
        }
        None
    }

    /// A derivative that contradicts the values.
    fn wrong_derivative(&self) -> Option<String> {
        let joints = self.0.joints();
        let values = |s: f64| self.0.values(s);
        let found: Vec<_> = (0..=CHECKED_PLACES)
            .map(|place| {
                let s = f64::from(place) / f64::from(CHECKED_PLACES);
                let fine = differences(values, s, DIFFERENCE_STEP);
                let coarse = differences(values, s, 2.0 * DIFFERENCE_STEP);
                (s, self.0.derivatives(s), fine, coarse, values(s))
            })
            .collect();
        for (number, joint) in joints.into_iter().enumerate() {
            let at = |list: &[f64]| list.get(number).copied().unwrap_or(f64::NAN);
            let rates = found.iter().map(|(_, _, fine, _, _)| at(fine).abs());
            let largest = rates.fold(0.0, f64::max);
            for (s, given, fine, coarse, values) in &found {
                let (given, fine, coarse) = (at(given), at(fine), at(coarse));
                let rounding = rounding_of_differences(at(values).abs(), DIFFERENCE_STEP);
                let allowed = MAX_CONTRADICTION * largest + (fine - coarse).abs() + rounding;
                let difference = (given - fine).abs();
                if difference.is_nan() || difference > allowed {
                    return Some(format!(
                        "has the derivative {given} of link {joint} at s = {s}, but its values \
                         change at the rate {fine}; correct `derivatives` or leave it out"
                    ));
                }
            }
        }
        None
    }
}

/// The description of a jump from `before` to the value at a place.
fn jump_text(what: &str, joint: usize, before: f64, (s, after): (f64, f64)) -> String {
    format!(
        "has a {what} of link {joint} that jumps from {before} to {after} at s = {s}; corners and \
         jumps belong between two phases"
    )
}

/// Intervals of a phase at whose ends the derivatives are compared with differences.
const CHECKED_PLACES: u32 = 32;

/// Largest difference between a derivative and the differences of the values, relative to the
/// largest derivative along the phase, beyond the error of the differences.
const MAX_CONTRADICTION: f64 = 1e-6;

/// Halvings of such an interval in the search for jumps: to 3e-11 of the phase, over which the
/// derivative of 200 oscillations changes by less than [`MAX_CONTRADICTION`].
const HALVINGS: u32 = 30;

/// Intervals of a phase between the slopes that are compared in the search for a corner.
const CORNER_PLACES: u32 = 1024;

/// Halvings of two such intervals in the search for a corner, to 2^-19 of the phase: still many
/// steps of the slopes.
const CORNER_HALVINGS: usize = 10;

/// Step of the slopes, a part of the phase: much shorter than the shortest interval, with a
/// rounding error of 4e-9 of the values.
const SLOPE_STEP: f64 = 1.0 / 16_777_216.0;

/// Largest jump of a value between phases, relative to a value above one: digits of a number that
/// was written and read.
const CONTINUITY: f64 = 1e-9;

fn enter(joints: &[usize], values: impl IntoIterator<Item = f64>, all: &mut [f64]) {
    for (&joint, value) in joints.iter().zip(values) {
        all[joint] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gait::{Gait, Phase, spans};

    /// A straight line from 10 to an end.
    #[derive(Debug)]
    struct Line(f64);

    impl JointPath for Line {
        fn joints(&self) -> Vec<usize> {
            vec![1]
        }

        fn values(&self, s: f64) -> Vec<f64> {
            vec![10.0 + s * (self.0 - 10.0)]
        }

        fn derivatives(&self, _: f64) -> Vec<f64> {
            vec![self.0 - 10.0]
        }
    }

    /// `sin(2 π n s) + s` with its derivatives times a factor, or without any.
    #[derive(Debug)]
    struct Wave {
        oscillations: f64,
        factor: Option<f64>,
    }

    impl JointPath for Wave {
        fn joints(&self) -> Vec<usize> {
            vec![0]
        }

        fn values(&self, s: f64) -> Vec<f64> {
            vec![(TAU * self.oscillations * s).sin() + s]
        }

        fn derivatives(&self, s: f64) -> Vec<f64> {
            let rate = TAU * self.oscillations;
            match self.factor {
                Some(factor) => vec![factor * (rate * (rate * s).cos() + 1.0)],
                None => differences(|s| self.values(s), s, DIFFERENCE_STEP),
            }
        }
    }

    #[test]
    fn default_derivatives_are_those_of_the_values() {
        for oscillations in [0.5, 1.0, 5.0] {
            let [exact, default] = [Some(1.0), None].map(|factor| Wave {
                oscillations,
                factor,
            });
            for place in 0..=100 {
                let s = f64::from(place) / 100.0;
                let error = (exact.derivatives(s)[0] - default.derivatives(s)[0]).abs();
                // Truncation: h^6 / 7 times the seventh derivative at an end; rounding: the sum of
                // the weights of a formula at an end, 13, times eps / h.
                let rate = TAU * oscillations;
                let truncation = DIFFERENCE_STEP.powi(6) / 7.0 * rate.powi(7);
                let rounding = 13.0 * 4.0 * f64::EPSILON / DIFFERENCE_STEP;
                assert!(
                    error < truncation + rounding,
                    "{oscillations} {s}: {error:e}"
                );
            }
        }
    }

    #[test]
    fn bug_derivatives_that_contradict_the_values_are_refused() {
        let problem = |oscillations, factor| {
            OwnPath(Arc::new(Wave {
                oscillations,
                factor,
            }))
            .problem()
        };
        for oscillations in [0.5, 1.0, 20.0, 200.0] {
            assert_eq!(problem(oscillations, Some(1.0)), None);
            assert_eq!(problem(oscillations, None), None);
        }
        for wrong in [-1.0, 0.0, 1.01, 1.00001] {
            let text = problem(2.0, Some(wrong)).unwrap();
            assert!(text.contains("link 0 at s = 0"), "{text}");
        }
    }

    /// `10 + a sin(π s)`, a joint that hardly moves, or does not.
    #[derive(Debug)]
    struct Still(f64);

    impl JointPath for Still {
        fn joints(&self) -> Vec<usize> {
            vec![0]
        }

        fn values(&self, s: f64) -> Vec<f64> {
            vec![10.0 + self.0 * (std::f64::consts::PI * s).sin()]
        }
    }

    /// The rounding of the differences counted as a jump of the derivative.
    #[test]
    fn bug_joints_that_hardly_move_had_jumps() {
        for amplitude in [0.0, 1e-10, 1e-8, 1e-6] {
            assert_eq!(
                OwnPath(Arc::new(Still(amplitude))).problem(),
                None,
                "{amplitude}"
            );
        }
    }

    /// `|s - 0.3|`, or its sign: a corner and a jump inside the phase.
    #[derive(Debug)]
    struct Corner {
        is_jump: bool,
        has_derivatives: bool,
    }

    impl JointPath for Corner {
        fn joints(&self) -> Vec<usize> {
            vec![0]
        }

        fn values(&self, s: f64) -> Vec<f64> {
            let sign = (s - 0.3).signum();
            vec![if self.is_jump { sign } else { sign * (s - 0.3) }]
        }

        fn derivatives(&self, s: f64) -> Vec<f64> {
            match (self.has_derivatives, self.is_jump) {
                (true, true) => vec![0.0],
                (true, false) => vec![(s - 0.3).signum()],
                (false, _) => differences(|s| self.values(s), s, DIFFERENCE_STEP),
            }
        }
    }

    #[test]
    fn bug_corners_and_jumps_inside_a_phase_are_refused() {
        for is_jump in [true, false] {
            for has_derivatives in [true, false] {
                let corner = Corner {
                    is_jump,
                    has_derivatives,
                };
                let text = OwnPath(Arc::new(corner)).problem().unwrap();
                let place = text.contains("at s = 0.3") || text.contains("at s = 0.29999");
                assert!(place && text.contains("jumps"), "{text}");
            }
        }
    }

    /// A corner without derivatives was rounded off by the differences.
    #[test]
    fn bug_a_scene_refuses_corners_of_paths_without_derivatives() {
        let scene = crate::Scene::builder()
            .sphere("a", 1.0, [0.0; 3])
            .sphere("b", 1.0, [10.0, 0.0, 0.0])
            .slide("arm", "b", "a")
            .build()
            .unwrap();
        let with = |height: f64, power: i32| {
            let path = ShapePath::Own(OwnPath(Arc::new(Kink { height, power })));
            let phases = vec![Phase {
                path,
                duration: 1.0,
            }];
            scene.with_gait(Gait { cycles: 1, phases })
        };
        for height in [1.0, -0.1, 1e-2, 1e-3] {
            let error = with(height, 1).unwrap_err().to_string();
            assert!(error.contains("corners"), "{height}: {error}");
            // Jumps of higher derivatives are allowed.
            assert!(with(height, 2).is_ok() && with(height, 3).is_ok());
        }
    }

    /// An arm of length 10 that oscillates by 1, and leaves the sine after a third of the phase.
    #[derive(Debug)]
    struct Kink {
        height: f64,
        power: i32,
    }

    impl JointPath for Kink {
        fn joints(&self) -> Vec<usize> {
            vec![0]
        }

        fn values(&self, s: f64) -> Vec<f64> {
            let rest = (s - 1.0 / 3.0).max(0.0);
            vec![10.0 + (TAU * s).sin() + self.height * rest.powi(self.power)]
        }
    }

    fn gait(cycles: u32, end: f64) -> Gait {
        let path = ShapePath::Own(OwnPath(Arc::new(Line(end))));
        Gait {
            cycles,
            phases: vec![Phase {
                path,
                duration: 2.0,
            }],
        }
    }

    #[test]
    fn a_path_of_a_program_is_a_span() {
        let span = spans(&gait(1, 6.0), &[3.0, 10.0]).unwrap().next().unwrap();
        assert_eq!(span.joints, [1]);
        assert_eq!(
            (span.shape(0.5), span.rates(0.5)),
            (vec![3.0, 8.0], vec![0.0, -2.0])
        );
        assert_eq!((&span.to[..], span.is_linear()), (&[3.0, 6.0][..], false));
        assert_eq!(span.ranges(), [(3.0, 3.0), (6.0, 10.0)]);
    }

    #[test]
    fn jumps_and_wrong_joints_are_refused() {
        let problem = |gait: &Gait, initial: &[f64]| match spans(gait, initial) {
            Err(error) => error.to_string(),
            Ok(_) => panic!("{initial:?}"),
        };
        assert!(problem(&gait(1, 6.0), &[3.0, 9.0]).contains("the value before it is 9"));
        // The second cycle begins where the first one does not end.
        assert!(problem(&gait(2, 6.0), &[3.0, 10.0]).contains("the value before it is 6"));
        assert!(problem(&gait(1, 6.0), &[3.0]).contains("link 1 of 1"));
        assert!(problem(&gait(1, f64::NAN), &[3.0, 10.0]).contains("finite"));
    }
}
