//! Work of the bodies of each linkage on the fluid, where it is known apart.

use models::Response;
use rigid::Articulation;
use scene::Scene;

/// Whether the work of each linkage is the integral of [`linkage_powers`].
pub(crate) fn has_linkage_works(scene: &Scene) -> bool {
    let has_slip = scene.bodies().iter().any(|body| body.slip.is_some());
    !has_slip && !scene.has_masses() && !scene.inertia().is_kept()
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

/// Adds numbers to sums, of which there are none before the first.
pub(crate) fn add_each(sums: &mut Vec<f64>, numbers: &[f64]) {
    sums.resize(numbers.len(), 0.0);
    sums.iter_mut().zip(numbers).for_each(|(sum, x)| *sum += x);
}
