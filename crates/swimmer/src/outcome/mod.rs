//! The outcome of a gait.

mod displacement_errors;
mod interim;
mod sample;

use models::{AccumulatedError, ErrorEstimate, NewMesh, Seconds, UncorrectedBars};
use nalgebra::{UnitQuaternion, Vector3};
use scene::Scene;
use serde::{Deserialize, Serialize};

pub(crate) use self::displacement_errors::{displacement_bars, largest_error_of};
pub use self::interim::{Interim, positions};
pub use self::sample::Sample;
use crate::added_mass::AddedMassForces;
use crate::holding_loads::HoldingLoads;
use crate::integrate::TABLE_SHARE;
use crate::kinetic_energy::KineticEnergy;
use crate::linkage_works::LinkageWork;
use crate::mean_flow::MeanFlowInTime;
use crate::turning::Turning;

/// Rounding of a net displacement, relative to the longest path: some hundred sums of positions.
const POSITION_ROUNDING: f64 = 1e-13;

/// The outcome of a gait, in the scene's units.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
#[non_exhaustive]
pub struct Outcome {
    /// Displacement of every body, including points.
    pub displacement: Vec<Vector3<f64>>,
    /// Rotation vector of the frame of the first linkage, with full turns
    /// ([`Turning::rotation_vector`]).
    pub rotation: Vector3<f64>,
    /// Rotation of that frame along its path.
    #[serde(default)]
    pub turning: Turning,
    /// Outcome of each phase span.
    pub spans: Vec<SpanOutcome>,
    /// Number of solutions: by a solve, or looked up in a table over shapes.
    pub solves: usize,
    /// Number of these that were looked up.
    #[serde(default)]
    pub lookups: usize,
    /// Number of solves that each of the tables is made of.
    #[serde(default)]
    pub tables: Vec<usize>,
    /// Error bars of the displacements.
    pub error_estimate: ErrorEstimate,
    /// Error bars of the rotation vectors, in radians.
    #[serde(default)]
    pub rotation_error: ErrorEstimate,
    /// Estimated discretisation errors that were subtracted from the displacements, computed minus
    /// exact, one per body.
    pub mesh_error: Option<Vec<Vector3<f64>>>,
    /// Accumulated discretisation error of the phase spans so far; none where a phase span has no
    /// estimate.
    #[serde(rename = "drift")]
    pub accumulated_error: Option<AccumulatedError>,
    /// Accumulated error by the model, computed minus exact; without a sign where solutions have
    /// none.
    #[serde(default)]
    pub accumulated_model_error: AccumulatedError,
    /// Accumulated integration error, computed minus exact; its uncertainty is all that is known
    /// where methods estimate a size. None where a phase span has no estimate.
    #[serde(default, rename = "integration_drift")]
    pub accumulated_integration_error: Option<AccumulatedError>,
    /// The error bar that `model.tolerance` limits, at the end of the gait; none if the integration
    /// error is not estimated.
    ///
    /// It is the sum of all error bars for a model that controls its own error
    /// ([`models::Capabilities::controls_error`]), and that of the integration for other models.
    #[serde(default)]
    pub limited_error: Option<f64>,
    /// Largest value of `limited_error` that meets the tolerance: `model.tolerance` times a length.
    ///
    /// The length is [`Outcome::reference_displacement`] or, if that is longer, `net_arc`; with
    /// slip or a background flow, `longest_arc`. Where all solutions are looked up in tables of a
    /// model that does not control its error, a tenth of its error bar is allowed as well: the
    /// integration asks for no less.
    #[serde(default)]
    pub allowed_error: f64,
    /// Largest distance that a point of a surface covers by the rotation of its body, over the
    /// gait; set at its end.
    #[serde(default)]
    pub longest_arc: f64,
    /// The same by the rotation of a body from the start to the end, with all full turns.
    #[serde(default)]
    pub net_arc: f64,
    /// Whether `limited_error` is at most `allowed_error`.
    pub tolerance_met: bool,
    /// Work of the bodies on the fluid.
    pub work: f64,
    /// Work of the bodies of each linkage on the fluid; empty where it is known in total only
    /// ([`SwimmerOutcome::work`](crate::SwimmerOutcome::work)).
    pub linkage_works: Vec<LinkageWork>,
    /// Error bars of the work.
    #[serde(default)]
    pub work_error: ErrorEstimate,
    /// Impulses of the loads that hold or drive bodies ([`Outcome::mean_holding`]).
    #[serde(default)]
    pub holding: HoldingLoads,
    /// Integral of the mean flow through a periodic box ([`Outcome::mean_flow`]); none in other
    /// domains.
    pub mean_flow_integral: Option<MeanFlowInTime>,
    /// Velocities `(U, ω)` of all bodies at the end, six per body; empty without masses.
    #[serde(default)]
    pub velocities: Vec<f64>,
    /// How the run began in the periodic state of a fluid with inertia; none for other starts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub periodic_start: Option<PeriodicStart>,
    /// Seconds of all solves, added up also where they ran at the same time.
    pub seconds: Seconds,
    /// The meshes that were generated, for models with a mesh.
    #[serde(default)]
    pub meshes: Vec<NewMesh>,
    /// The trajectory at the ends of phase spans and at the solves, in the order of time.
    pub samples: Vec<Sample>,
    /// The trajectory at equal intervals of time, if the scene asks for it (`output.samples`).
    ///
    /// Loads are those of the polynomial through the solves of a step; at the end of a phase, where
    /// rates jump, they are those before it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub uniform_samples: Vec<Sample>,
    /// Why the run stopped before its end, such as contact, in words; none for a completed run.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stopped: Option<String>,
    /// The trajectory between the samples, for plots: times and positions of all bodies.
    pub curve: Vec<(f64, Vec<Vector3<f64>>)>,
}

impl Outcome {
    /// The net displacement: the distance that the mean of the centres of the moving bodies covers.
    ///
    /// A rotation about that mean is no displacement. Fixed bodies do not count.
    pub fn net(&self) -> f64 {
        self.net_vector().norm()
    }

    /// The mean displacement of the centres of the moving bodies.
    pub fn net_vector(&self) -> Vector3<f64> {
        mean_of_moving(&self.displacement)
    }

    /// The work without the correction of its discretisation error.
    pub fn uncorrected_work(&self) -> f64 {
        self.work
            + self
                .accumulated_error
                .as_ref()
                .map_or(0.0, |error| error.work)
    }

    /// Mean force and torque, over the time of the gait so far, on each body whose velocity is
    /// given; none without such bodies.
    ///
    /// A fixed body that holds a swimmer receives the opposite of its mean thrust. Errors of the
    /// discretisation are those that remain after its correction, without regard to their signs.
    pub fn mean_holding(&self) -> Option<HoldingLoads> {
        let time = self.samples.last()?.time;
        let is_mean = time > 0.0 && !self.holding.bodies.is_empty();
        is_mean.then(|| self.holding.over(time))
    }

    /// Mean flow through a periodic box and mean pressure gradient, over the time of the gait so
    /// far; none in other domains.
    pub fn mean_flow(&self) -> Option<MeanFlowInTime> {
        let time = self.samples.last()?.time;
        let integral = self.mean_flow_integral.filter(|_| time > 0.0)?;
        Some(integral.over(time))
    }

    /// Number of solves of the model, with those of its tables.
    pub fn model_solves(&self) -> usize {
        self.solves - self.lookups + self.tables.iter().sum::<usize>()
    }

    /// Size of net displacements that are rounding.
    pub fn rounding(&self) -> f64 {
        POSITION_ROUNDING * self.longest_path()
    }

    /// The net displacement, or zero if it is rounding.
    pub fn resolved_net(&self) -> f64 {
        let net = self.net();
        if net > self.rounding() { net } else { 0.0 }
    }

    /// The longest displacement of a body in one phase, or `longest_arc` if that is longer.
    fn longest_path(&self) -> f64 {
        let spans = self.spans.iter().flat_map(|span| &span.displacement);
        spans.fold(self.longest_arc.max(self.net()), |longest, d| {
            longest.max(d.norm())
        })
    }

    /// The displacement to which `model.tolerance` is relative: the net displacement.
    ///
    /// If the net displacement cannot be distinguished from zero, by its error bar or by the
    /// rounding of positions, as for reciprocal gaits and bodies that rotate in place, it is the
    /// longest displacement of a body in one phase or, if that is longer, `longest_arc`.
    pub fn reference_displacement(&self) -> f64 {
        let net = self.net();
        match net > self.error_estimate.total().max(self.rounding()) {
            true => net,
            false => self.longest_path(),
        }
    }

    /// The change of the shape over the gait; none if the prescribed joints return to their values.
    pub fn shape_change(&self, scene: &Scene) -> Option<ShapeChange> {
        let (first, last) = self.samples.first().zip(self.samples.last())?;
        let joints = scene.shape_changes(&first.shape, &last.shape);
        let body = scene.articulation().linkages().first()?.root;
        (!joints.is_empty()).then_some(ShapeChange {
            joints,
            body,
            displacement: self.displacement.get(body).copied()?,
            rotation: self.rotation,
        })
    }

    /// Largest distances that a point of a surface covers by the rotation of its body: along the
    /// whole path, and about the axis of the whole rotation.
    fn arcs(&self, scene: &Scene) -> [f64; 2] {
        let turnings = self.samples.last().map_or(&[][..], |last| &last.turnings);
        let largest = |angle: fn(&Turning) -> f64| {
            let bodies = scene.bodies().iter().zip(turnings);
            bodies
                .map(|(body, turning)| angle(turning) * body.bounding_radius())
                .fold(0.0, f64::max)
        };
        [
            largest(|turning| turning.angle),
            largest(|turning| turning.vector.norm()),
        ]
    }

    /// Compares the error bar that `model.tolerance` limits with it, at the end of the gait.
    ///
    /// `controls_error` says whether the model keeps its own error below its share of the tolerance
    /// ([`models::Capabilities::controls_error`]).
    ///
    /// The rounding of positions, `ε n (x + p)` with the coordinates `x` and the longest path `p`
    /// after `n` phase spans, is added to the bar of the integration.
    pub fn check_tolerance(&mut self, scene: &Scene, controls_error: bool) {
        let poses = self.samples.last().map_or(&[][..], |last| &last.poses);
        let distance = poses
            .iter()
            .fold(0.0_f64, |far, pose| far.max(pose.translation.vector.norm()));
        let sums = self.spans.len() as f64 * (distance + self.longest_path());
        let bars = &mut self.error_estimate;
        bars.integration = bars.integration.map(|bar| bar + f64::EPSILON * sums);
        self.limited_error = bars.integration.map(|error| match controls_error {
            true => bars.total(),
            false => error,
        });
        [self.longest_arc, self.net_arc] = self.arcs(scene);
        let arc = match scene.has_surface_velocity() {
            // Bodies may tumble in place.
            true => self.longest_arc,
            false => self.net_arc,
        };
        self.allowed_error = scene.model().tolerance * self.reference_displacement().max(arc);
        if !controls_error && self.solves > 0 && self.lookups == self.solves {
            let bars = &self.error_estimate;
            let [mesh, integration] = [bars.mesh, bars.integration].map(|bar| bar.unwrap_or(0.0));
            let left = TABLE_SHARE * (bars.total() - mesh - integration);
            self.allowed_error = self.allowed_error.max(left);
        }
        // Methods without an error estimate do not meet a tolerance. With thermal noise there is no
        // exact displacement, and the tolerance limits single solutions.
        let limited = self.limited_error;
        self.tolerance_met = match scene.noise() {
            Some(_) => true,
            None => limited.is_some_and(|error| error <= self.allowed_error),
        };
    }

    /// The samples that `trajectory.csv` shows: those at equal intervals of time, if the scene asks
    /// for them, else all.
    pub fn trajectory(&self) -> &[Sample] {
        match self.uniform_samples.is_empty() {
            true => &self.samples,
            false => &self.uniform_samples,
        }
    }

    /// Kinetic energy of fluid and bodies at the end, for fluids with inertia.
    pub fn kinetic_energy(&self) -> Option<KineticEnergy> {
        self.samples.last()?.kinetic_energy
    }

    /// Forces that accelerate the fluid at the end, for fluids with inertia.
    pub fn added_mass(&self) -> Option<&AddedMassForces> {
        self.samples.last()?.added_mass.as_ref()
    }
}

/// The mean of the nonzero displacements; only those of fixed bodies are exactly zero.
pub fn mean_of_moving(displacement: &[Vector3<f64>]) -> Vector3<f64> {
    let moving = displacement.iter().filter(|d| **d != Vector3::zeros());
    let count = moving.clone().count().max(1);
    moving.sum::<Vector3<f64>>() / count as f64
}

/// The change of the shape over a gait that is not closed.
///
/// The displacements of the bodies, and their mean, then contain the change of the shape, which
/// depends on the joints alone. The rigid part is the motion of the frame in which the shape is
/// described, that of the first body of the first linkage.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ShapeChange {
    /// The joints whose values differ at the end, with the changes.
    pub joints: Vec<(usize, f64)>,
    /// The body whose motion is the rigid part.
    pub body: usize,
    /// Displacement of the rigid part.
    pub displacement: Vector3<f64>,
    /// Rotation vector of the rigid part, with all full turns.
    pub rotation: Vector3<f64>,
}

/// How a run with inertia of the fluid began in its periodic state.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[non_exhaustive]
pub struct PeriodicStart {
    /// Number of cycles before the run.
    pub cycles: usize,
    /// Difference of the displacement since the start of the cycle to that in the cycle before, of
    /// all bodies and ends of phases the largest, with the rotation of the body times its radius,
    /// in the axes of its linkage at the start of the cycle; the larger of the last two.
    pub residual: f64,
    /// Difference of the kinetic energies before and after a cycle, relative to the largest one in
    /// it; the larger of the last two.
    pub energy_residual: f64,
    /// Error bars of displacement, rotation, work and holding impulses in a cycle by what remains
    /// of the start.
    pub remainder: UncorrectedBars,
    /// Rotation of the frame of the first linkage where the run begins.
    pub rotation: UnitQuaternion<f64>,
}

/// The outcome of one phase span.
#[derive(Clone, Debug, Deserialize, Serialize)]
#[non_exhaustive]
pub struct SpanOutcome {
    /// The joints that changed their values.
    pub joints: Vec<usize>,
    /// Displacement of every body.
    pub displacement: Vec<Vector3<f64>>,
    /// Number of solutions.
    pub solves: usize,
    /// Number of these that were looked up in tables.
    #[serde(default)]
    pub lookups: usize,
    /// Error bars of the displacements.
    pub error_estimate: ErrorEstimate,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_bodies_do_not_dilute_the_net_displacement() {
        let [fixed, moving] = [Vector3::zeros(), Vector3::new(3.0, 4.0, 0.0)];
        assert_eq!(mean_of_moving(&[moving, fixed, moving]), moving);
        assert_eq!(mean_of_moving(&[fixed]), fixed);
    }
}
