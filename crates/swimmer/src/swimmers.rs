//! Results of each swimmer of a run with several.

use models::{AccumulatedError, ErrorEstimate};
use nalgebra::Vector3;
use rigid::{Articulation, Freedom, Joint, Linkage};
use scene::Scene;

use crate::outcome::{Outcome, displacement_bars, largest_error_of, mean_of_moving};

/// The result of one swimmer: of a connected set of bodies that joints, deformations or slip move.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SwimmerOutcome {
    /// Its bodies in the order of the scene; the first one gives it its name.
    pub bodies: Vec<usize>,
    /// Mean displacement of the centres of its moving bodies.
    pub displacement: Vector3<f64>,
    /// Error bars of the displacements of its bodies.
    pub error_estimate: ErrorEstimate,
    /// Rotation vector of its root (its first body, or the first one whose velocity is given) in
    /// radians, with full turns ([`Turning::rotation_vector`](crate::Turning::rotation_vector)).
    pub rotation: Vector3<f64>,
    /// Error bars of the rotation, in radians.
    pub rotation_error: ErrorEstimate,
    /// Work of its bodies on the fluid. The works of all bodies add up to that of the run.
    ///
    /// `None` where it is known in total only: with slip, for bodies or fluids with inertia, where
    /// swimmers exchange volume, and where several change theirs in a container.
    pub work: Option<f64>,
    /// Error bars of the work, if it is known.
    pub work_error: Option<ErrorEstimate>,
}

impl SwimmerOutcome {
    /// Name: that of its first body.
    pub fn name<'s>(&self, scene: &'s Scene) -> &'s str {
        &scene.bodies()[self.bodies[0]].name
    }
}

impl Outcome {
    /// Results of all swimmers, in the order of their first bodies; empty for a scene with a single
    /// one, whose results are those of the run.
    pub fn swimmers(&self, scene: &Scene) -> Vec<SwimmerOutcome> {
        let set = scene.articulation();
        let (Some(first), Some(last)) = (self.samples.first(), self.samples.last()) else {
            return Vec::new();
        };
        let swims = swimming(scene);
        let all = set.linkages().iter().enumerate();
        let swimming: Vec<_> = all.filter(|(number, _)| swims[*number]).collect();
        if swimming.len() < 2 {
            return Vec::new();
        }
        let positions: Vec<Vector3<f64>> = (last.poses.iter())
            .map(|pose| pose.translation.vector)
            .collect();
        let result = |(number, linkage): (usize, &Linkage)| {
            let mut bodies = linkage.bodies.clone();
            bodies.sort_unstable();
            let displacements: Vec<_> = bodies.iter().map(|&b| self.displacement[b]).collect();
            let turning = last.turnings.get(linkage.root).copied().unwrap_or_default();
            let [start, end] = [first, last].map(|sample| sample.poses[linkage.root].rotation);
            let work = self.linkage_works.get(number);
            SwimmerOutcome {
                displacement: mean_of_moving(&displacements),
                error_estimate: self.error_of(set, number, &positions),
                rotation: turning.rotation_vector(&(end * start.inverse())),
                rotation_error: self.rotation_error_of(number),
                work: work.map(|own| own.work),
                work_error: work.map(|own| own.bars(&self.work_error)),
                bodies,
            }
        };
        swimming.into_iter().map(result).collect()
    }

    /// Error bars of the rotation of one linkage.
    fn rotation_error_of(&self, number: usize) -> ErrorEstimate {
        let bars = &self.rotation_error;
        let uncorrected = |error: &AccumulatedError| error.uncorrected_rotation_bar_of(number);
        let integration = self.accumulated_integration_error.as_ref();
        let mesh = self.accumulated_error.as_ref();
        ErrorEstimate {
            mesh: mesh.map(|error| error.rotation_error_bar_of(number)),
            model: bars
                .model
                .map(|_| uncorrected(&self.accumulated_model_error)),
            integration: integration.map(uncorrected),
            ..*bars
        }
    }

    /// Error bars of the displacements of the bodies of one linkage.
    fn error_of(
        &self,
        set: &Articulation,
        number: usize,
        positions: &[Vector3<f64>],
    ) -> ErrorEstimate {
        let accumulated = (
            self.accumulated_error.as_ref(),
            &self.accumulated_model_error,
            self.accumulated_integration_error.as_ref(),
        );
        displacement_bars(&self.error_estimate, accumulated, |error| {
            largest_error_of(set, number, error, positions)
        })
    }
}

/// Linkages that can move themselves: by joints or amplitudes that the gait or the flow changes, or
/// by slip. Bodies that rest relative to each other are no swimmer.
fn swimming(scene: &Scene) -> Vec<bool> {
    let set = scene.articulation();
    let mut swims = vec![false; set.linkages().len()];
    let phases = scene.gait().phases.iter();
    let driven = phases.flat_map(|phase| phase.path.joints());
    let is_free = |joint: &&Joint| joint.is_passive() || joint.kind.freedom() == Freedom::Rotation;
    let free = set.joints().iter().filter(is_free);
    for joint in driven.map(|joint| &set.joints()[joint]).chain(free) {
        for body in [joint.body, joint.to] {
            swims[set.linkage_of()[body]] = true;
        }
    }
    for (body, &linkage) in scene.bodies().iter().zip(set.linkage_of()) {
        swims[linkage] |= body.slip.is_some();
    }
    swims
}
