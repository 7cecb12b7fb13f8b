//! The joint values that a stroke may take.

use scene::Scene;

use crate::error::DesignError;
use crate::joint_ranges::joint_ranges;

/// Largest number of joints of a table: the first grid has 5 points per joint.
pub const MOST_JOINTS: usize = 5;

/// Gap that is kept by default, relative to the smallest radius: closer spheres need expansions of
/// higher order, and an optimum there depends on it.
const DEFAULT_GAP: f64 = 0.1;

/// Smallest and largest value of each joint.
#[derive(Clone, Debug, PartialEq)]
pub struct StrokeLimits {
    /// One range per joint; of width zero for joints that do not move.
    pub ranges: Vec<(f64, f64)>,
    /// Joints whose range has a width.
    pub variables: Vec<usize>,
}

impl StrokeLimits {
    /// The limits `optimise.lower` and `optimise.upper` of a scene, by default those of its gait,
    /// with the gap `optimise.gap` between spheres that a slide connects.
    ///
    /// # Errors
    /// [`DesignError::NotApplicable`] for limits that leave no room, no joint or too many joints,
    /// and a fixed start outside of them.
    pub fn of_scene(scene: &Scene) -> Result<Self, DesignError> {
        let set = scene.articulation();
        let mut ranges = joint_ranges(scene)?;
        let options = scene.optimise();
        if let Some(lower) = &options.lower {
            for (range, value) in ranges
                .iter_mut()
                .zip(scene.joint_values("optimise.lower", lower)?)
            {
                range.0 = value.unwrap_or(range.0);
            }
        }
        if let Some(upper) = &options.upper {
            for (range, value) in ranges
                .iter_mut()
                .zip(scene.joint_values("optimise.upper", upper)?)
            {
                range.1 = value.unwrap_or(range.1);
            }
        }
        let radius = |body: usize| sphere_radius(scene, body);
        let gap = smallest_gap(scene);
        for (joint, range) in set.joints().iter().zip(&mut ranges) {
            if let (Some(a), Some(b)) = (radius(joint.body), radius(joint.to))
                && !joint.kind.is_angle()
                && range.0 < range.1
            {
                range.0 = range.0.max(a + b + gap);
            }
        }
        let refuse = |key: &str, problem: String| {
            Err(DesignError::NotApplicable {
                place: scene.place(key),
                problem,
            })
        };
        for (number, range) in ranges.iter().enumerate() {
            if range.0 > range.1 {
                let name = &set.joints()[number].name;
                return refuse(
                    "optimise",
                    format!(
                        "no value of \"{name}\" is allowed: at least {} and at most {}; change \
                         optimise.lower, optimise.upper or optimise.gap",
                        range.0, range.1
                    ),
                );
            }
        }
        let variables: Vec<usize> = (0..ranges.len())
            .filter(|&k| ranges[k].0 < ranges[k].1)
            .collect();
        match variables.len() {
            0 => refuse(
                "optimise",
                "no joint may move; give optimise.lower and optimise.upper, or a gait".to_owned(),
            ),
            n if n > MOST_JOINTS => refuse(
                "optimise",
                format!(
                    "{n} joints move, and tables have at most {MOST_JOINTS}; give the same value \
                     in optimise.lower and optimise.upper to those that are to rest"
                ),
            ),
            _ => Ok(Self { ranges, variables }),
        }
    }

    /// The entries of the joints that move, out of one per joint.
    pub fn moving<T: Copy>(&self, of_joints: &[T]) -> Vec<T> {
        self.variables.iter().map(|&k| of_joints[k]).collect()
    }

    /// Values of all joints, from those that move.
    pub fn full_shape(&self, shape: &[f64]) -> Vec<f64> {
        let mut full: Vec<f64> = self.ranges.iter().map(|range| range.0).collect();
        for (&joint, value) in self.variables.iter().zip(shape) {
            full[joint] = *value;
        }
        full
    }
}

/// The radius of a body that is a sphere.
pub(super) fn sphere_radius(scene: &Scene, body: usize) -> Option<f64> {
    scene.bodies()[body].shape.sphere_radius()
}

/// The gap `optimise.gap` between spheres that a slide connects, by default a tenth of the smallest
/// radius.
pub(super) fn smallest_gap(scene: &Scene) -> f64 {
    let radii = (0..scene.bodies().len()).filter_map(|body| sphere_radius(scene, body));
    let smallest = radii.fold(f64::INFINITY, f64::min);
    (scene.optimise().gap).unwrap_or(match smallest.is_finite() {
        true => DEFAULT_GAP * smallest,
        false => 0.0,
    })
}
