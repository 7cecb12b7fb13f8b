//! Work of the bodies of each linkage on the fluid, where it is known apart.

use models::{ErrorEstimate, InstantaneousSolution, Response};
use rigid::Articulation;
use scene::Scene;
use serde::{Deserialize, Serialize};

/// Work of the bodies of one linkage on the fluid, with what its error bars follow from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[non_exhaustive]
pub struct LinkageWork {
    /// The work.
    pub work: f64,
    /// The estimated discretisation error that was subtracted, its largest relative uncertainty,
    /// and the uncertainty of what may cancel in it.
    mesh: [f64; 3],
    /// Error by the model as far as it has a sign, and its uncertainty.
    model: [f64; 2],
    /// Estimated error of the integration.
    pub(crate) integration: f64,
}

impl LinkageWork {
    /// The works of all linkages in a solution for a time, of whose errors those with a sign count
    /// for `error_time`.
    pub(crate) fn of_solution(
        set: &Articulation,
        solution: &InstantaneousSolution,
        time: f64,
        error_time: f64,
    ) -> Vec<Self> {
        let powers = linkage_powers(set, solution);
        let computed = (solution.mesh_error.as_ref())
            .map(|error| (error, linkage_powers(set, &solution.uncorrected())));
        let exact = (solution.model_error.as_ref())
            .map(|error| linkage_powers(set, &(&solution.response - error)));
        let sizes = linkage_sums(set, solution, f64::abs);
        let of_linkage = |(number, power): (usize, &f64)| {
            let of_linkage = solution
                .linkage_power_error
                .map(|error| error * sizes[number]);
            let bar = of_linkage.or(solution.power_error.model);
            let model = exact.as_ref().map_or(0.0, |exact| power - exact[number]);
            let mesh = computed.as_ref().map_or([0.0; 3], |(error, computed)| {
                let uncertainty = &error.uncertainty;
                [
                    (computed[number] - power) * time,
                    uncertainty.relative,
                    uncertainty.power * time.abs(),
                ]
            });
            Self {
                work: power * time,
                mesh,
                model: [
                    model * error_time,
                    solution.model_uncertainty(bar, model.abs()) * error_time,
                ],
                integration: 0.0,
            }
        };
        powers.iter().enumerate().map(of_linkage).collect()
    }

    /// Adds works of later times to sums; there are none of either before the first step of a span
    /// or a run.
    pub(crate) fn add_each(sums: &mut Vec<Self>, later: &[Self]) {
        sums.resize(sums.len().max(later.len()), Self::default());
        for (sum, later) in sums.iter_mut().zip(later) {
            let ([removed, relative, uncertainty], [error, unsigned]) = (later.mesh, later.model);
            sum.work += later.work;
            sum.mesh[0] += removed;
            sum.mesh[1] = sum.mesh[1].max(relative);
            sum.mesh[2] += uncertainty;
            sum.model[0] += error;
            sum.model[1] += unsigned;
            sum.integration += later.integration;
        }
    }

    /// Error bars by the sources that those of the work of all bodies have, as these
    /// ([`models::AccumulatedError`]); sources without a sum of their own have the bars of all.
    pub(crate) fn bars(&self, of_all: &ErrorEstimate) -> ErrorEstimate {
        let ([removed, relative, uncertainty], [error, unsigned]) = (self.mesh, self.model);
        ErrorEstimate {
            mesh: of_all
                .mesh
                .map(|_| (relative * removed.abs()).max(uncertainty)),
            model: of_all.model.map(|_| error.abs() + unsigned),
            integration: of_all.integration.map(|_| self.integration),
            ..*of_all
        }
    }
}

/// Whether the work of each linkage is the integral of [`linkage_powers`].
///
/// It is not where an exchange of volume couples two linkages, which share the work of its drive;
/// and not where several linkages change their volumes in a container, whose pressure, and with it
/// the work of each alone, is known up to a constant. With thermal noise the work of the random
/// loads, which is the fluid's own, is subtracted in total only.
pub(crate) fn has_linkage_works(scene: &Scene) -> bool {
    let has_slip = scene.bodies().iter().any(|body| body.slip.is_some());
    let is_apart = !has_slip && scene.noise().is_none() && !shares_volume(scene);
    is_apart && !scene.has_masses() && !scene.inertia().is_kept()
}

/// Whether linkages exchange volume, through a joint or through the fluid of a container.
fn shares_volume(scene: &Scene) -> bool {
    let set = scene.articulation();
    let mut growing = Vec::new();
    for (number, joint) in set.joints().iter().enumerate() {
        if !joint.kind.is_deformation() {
            continue;
        }
        let [of_body, of_other] = [joint.body, joint.to].map(|body| set.linkage_of()[body]);
        if of_body != of_other {
            return true;
        }
        // An exchange keeps the volume of its linkage.
        let deformation = scene.bodies()[joint.body].deformation.as_ref();
        if joint.body == joint.to && deformation.is_some_and(|of| of.changes_volume(number)) {
            growing.push(of_body);
        }
    }
    scene.domain().keeps_volume() && growing.iter().any(|linkage| *linkage != growing[0])
}

/// Power of the bodies of each linkage on the fluid, by motion and deformation.
pub(crate) fn linkage_powers(set: &Articulation, response: &Response) -> Vec<f64> {
    linkage_sums(set, response, |power| power)
}

/// The same sums of a function of the power of each force and torque, and of each deformation.
fn linkage_sums(set: &Articulation, response: &Response, of: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut sums = vec![0.0; set.linkages().len()];
    for (body, &linkage) in response.bodies.iter().zip(set.linkage_of()) {
        let powers = [
            body.force.dot(&body.velocity),
            body.torque.dot(&body.angular_velocity),
        ];
        sums[linkage] += of(powers[0]) + of(powers[1]);
    }
    let loads = set.joints().iter().zip(&response.joint_loads);
    for ((joint, load), rate) in loads.zip(&response.amplitude_rates) {
        sums[set.linkage_of()[joint.body]] += of(load.drive * rate);
    }
    sums
}

/// Adds numbers to sums, of which there are none at first.
pub(crate) fn add_each(sums: &mut Vec<f64>, numbers: &[f64]) {
    sums.resize(sums.len().max(numbers.len()), 0.0);
    sums.iter_mut().zip(numbers).for_each(|(sum, x)| *sum += x);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bug_a_run_that_stops_early_lost_the_works_of_its_swimmers() {
        let mut sums = Vec::new();
        let of = |work: f64| LinkageWork {
            work,
            ..LinkageWork::default()
        };
        // A phase, and one that stops before its first step.
        for works in [&[of(1.0), of(2.0)][..], &[]] {
            LinkageWork::add_each(&mut sums, works);
        }
        assert_eq!(sums, [of(1.0), of(2.0)]);
    }
}
