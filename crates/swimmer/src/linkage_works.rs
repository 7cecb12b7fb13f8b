//! Work of the bodies of each linkage on the fluid, where it is known apart.

use models::Response;
use rigid::Articulation;
use scene::Scene;

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
    let mut powers = vec![0.0; set.linkages().len()];
    for (body, &linkage) in response.bodies.iter().zip(set.linkage_of()) {
        powers[linkage] += body.force.dot(&body.velocity) + body.torque.dot(&body.angular_velocity);
    }
    let loads = set.joints().iter().zip(&response.joint_loads);
    for ((joint, load), rate) in loads.zip(&response.amplitude_rates) {
        powers[set.linkage_of()[joint.body]] += load.drive * rate;
    }
    powers
}

/// Adds numbers to sums; there are none of either before the first step of a span or a run.
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
        // A phase, and one that stops before its first step.
        for works in [&[1.0, 2.0][..], &[]] {
            add_each(&mut sums, works);
        }
        assert_eq!(sums, [1.0, 2.0]);
    }
}
