//! The joint values that a gait takes and a stroke may take, and sizes of the bodies.

use std::f64::consts::PI;

use rigid::Freedom;
use scene::{Body, Gait, JointValues, Scene, spans};

use crate::error::DesignError;

/// Largest number of joints of a table: the first grid has 5 points per joint.
const MAX_JOINTS: usize = 5;

/// Gap that is kept by default, relative to the smallest radius: closer spheres need expansions of
/// higher order, and an optimum there depends on it.
const DEFAULT_GAP: f64 = 0.1;

/// Smallest and largest value of each joint.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct StrokeLimits {
    /// One range per joint; of width zero for joints that do not move.
    pub ranges: Vec<(f64, f64)>,
    /// Joints whose range has a width.
    pub variables: Vec<usize>,
}

impl StrokeLimits {
    /// The limits with one range per joint; those of a positive width are variables.
    pub fn new(ranges: Vec<(f64, f64)>) -> Self {
        let variables = (0..ranges.len()).filter(|&k| ranges[k].0 < ranges[k].1);
        Self {
            variables: variables.collect(),
            ranges,
        }
    }

    /// The limits `optimise.lower` and `optimise.upper` of a scene, by default those of its gait,
    /// with the gap `optimise.gap` between spheres that a slide connects.
    ///
    /// # Errors
    /// [`DesignError::NotApplicable`] for limits that leave no room, no joint or too many joints,
    /// and a fixed start outside of them.
    pub fn from_scene(scene: &Scene) -> Result<Self, DesignError> {
        let set = scene.articulation();
        let mut ranges = joint_ranges(scene)?;
        let options = scene.optimise();
        let values = |key: &str, values: &Option<JointValues>| match values {
            Some(values) => scene.joint_values(key, values),
            None => Ok(vec![None; set.joints().len()]),
        };
        let lower = values("optimise.lower", &options.lower)?;
        let upper = values("optimise.upper", &options.upper)?;
        for (range, (lower, upper)) in ranges.iter_mut().zip(lower.into_iter().zip(upper)) {
            *range = (lower.unwrap_or(range.0), upper.unwrap_or(range.1));
        }
        let gap = smallest_gap(scene);
        let of_all = ranges.clone();
        for (joint, range) in set.joints().iter().zip(&mut ranges) {
            let radius = |body: usize| largest_radius(scene, body, &of_all);
            if let (Some(a), Some(b)) = (radius(joint.body), radius(joint.to))
                && joint.kind.freedom() == Freedom::Distance
                && range.0 < range.1
            {
                range.0 = range.0.max(a + b + gap);
            }
        }
        let refuse = |problem| Err(DesignError::not_applicable(scene, "optimise", problem));
        for (number, range) in ranges.iter().enumerate() {
            if range.0 > range.1 {
                let name = &set.joints()[number].name;
                return refuse(format!(
                    "no value of \"{name}\" is allowed: at least {} and at most {}; change \
                     optimise.lower, optimise.upper or optimise.gap",
                    range.0, range.1
                ));
            }
        }
        let limits = Self::new(ranges);
        match limits.variables.len() {
            0 => refuse(
                "no joint may move; give optimise.lower and optimise.upper, or a gait".to_owned(),
            ),
            n if n > MAX_JOINTS => refuse(format!(
                "{n} joints move, and tables have at most {MAX_JOINTS}; give the same value in \
                 optimise.lower and optimise.upper to those that are to rest"
            )),
            _ => Ok(limits),
        }
    }

    /// Names of the joints that move.
    pub fn joint_names(&self, scene: &Scene) -> Vec<String> {
        let joints = scene.articulation().joints();
        let names = self.variables.iter().map(|&k| joints[k].name.clone());
        names.collect()
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

/// The largest radius of a body that is a sphere, or of the ball around one that deforms, with
/// joints in these ranges.
fn largest_radius(scene: &Scene, body: usize, ranges: &[(f64, f64)]) -> Option<f64> {
    let body = &scene.bodies()[body];
    let Some(deformation) = &body.deformation else {
        return body.shape.sphere_radius();
    };
    let joints: Vec<usize> = deformation.joints().collect();
    let mut values: Vec<f64> = ranges.iter().map(|range| range.0).collect();
    // Corners of the box: the radial function is largest at one of them.
    let at_corner = |corner: usize| {
        for (bit, &joint) in joints.iter().enumerate() {
            let (low, high) = ranges[joint];
            values[joint] = if corner >> bit & 1 == 1 { high } else { low };
        }
        deformation.bounding_radius(&values)
    };
    Some(
        (0..1_usize << joints.len())
            .map(at_corner)
            .fold(0.0, f64::max),
    )
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

/// Smallest and largest value of each joint in a cycle of the gait, the start included.
///
/// # Errors
/// A gait that cannot be followed.
pub(super) fn joint_ranges(scene: &Scene) -> Result<Vec<(f64, f64)>, DesignError> {
    let start = scene.articulation().initial_shape();
    let mut ranges: Vec<(f64, f64)> = start.iter().map(|&x| (x, x)).collect();
    // The first cycle may begin elsewhere than all later ones.
    let gait = Gait {
        cycles: scene.gait().cycles.min(2),
        phases: scene.gait().phases.clone(),
    };
    for span in spans(&gait, start)? {
        for (range, part) in ranges.iter_mut().zip(span.ranges()) {
            *range = (range.0.min(part.0), range.1.max(part.1));
        }
    }
    Ok(ranges)
}

/// `6 π μ r` with the sum `r` of the radii, of shapes other than spheres those of the balls around
/// them: the drag of the separate bodies in Lighthill's efficiency `6 π μ r Δ² / (E T)`.
pub(super) fn drag_of_bodies(scene: &Scene) -> f64 {
    let radii = scene.bodies().iter().map(Body::bounding_radius);
    6.0 * PI * scene.viscosity() * radii.sum::<f64>()
}
