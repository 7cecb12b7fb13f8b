//! The drag to which efficiencies are relative.

use std::f64::consts::PI;

use scene::Scene;

/// `6 π μ r` with the sum `r` of the radii, of shapes other than spheres those of the balls around
/// them: the drag of the separate bodies in Lighthill's efficiency `6 π μ r Δ² / (E T)`.
pub fn drag_of_bodies(scene: &Scene) -> f64 {
    let radii = scene.bodies().iter().map(scene::Body::bounding_radius);
    6.0 * PI * scene.viscosity() * radii.sum::<f64>()
}
