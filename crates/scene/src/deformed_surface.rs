//! The true surfaces of spheres and spheroids that deform, as the mesh generator sees them.

use std::f64::consts::PI;

use mesh::{Surface, SurfaceMesh};
use mesher::{Placed, Sphere};
use nalgebra::{Isometry3, Vector2, Vector3};

use crate::octahedral::coarse;
use crate::radial_profile::RadialProfile;
use crate::sphere_deformation::SphereDeformation;
use crate::star_surface::StarSurface;
use crate::surface_modes::any_normal;

/// Angles at which a meridian is tabulated: the highest degree of a mode has twenty samples per
/// wave.
const SAMPLES: usize = 256;

/// Steps of Newton's method for a closest point, more than it needs.
const MAX_STEPS: usize = 60;

/// A point of a meridian: the coordinates along the axis and across it.
type Point = Vector2<f64>;

impl SphereDeformation {
    /// The surface at these values of the joints, at a pose relative to the initial configuration.
    ///
    /// `unit` is the length in the surface that is one in the scene.
    pub fn surface(&self, values: &[f64], pose: &Isometry3<f64>, unit: f64) -> Box<dyn Surface> {
        let mut profile = self.profile(values);
        profile.radius *= unit;
        let pose = *pose;
        match self.modes.as_ref().filter(|_| !self.is_sphere()) {
            None => Box::new(Sphere::new(pose.translation.vector, profile.radius)),
            Some(modes) if profile.is_zonal() => Box::new(Placed {
                shape: Revolved::new(profile, modes.axis, self.aspect()),
                pose,
            }),
            Some(modes) => Box::new(Placed {
                shape: StarSurface::new(profile, modes.clone(), self.aspect()),
                pose,
            }),
        }
    }
}

/// The surface of revolution of a radial function about an axis through the origin, stretched along
/// the axis.
struct Revolved {
    profile: RadialProfile,
    /// Factor of the lengths along the axis.
    aspect: f64,
    axis: Vector3<f64>,
    /// A direction across the axis, for points on it.
    across: Vector3<f64>,
    /// Angles with the axis and points of the meridian.
    samples: Vec<(f64, Point)>,
    reach: f64,
    is_convex: bool,
}

/// A point of the meridian with its derivatives with respect to the angle.
struct MeridianPoint {
    at: Point,
    tangent: Point,
    second: Point,
}

impl MeridianPoint {
    /// The outward unit normal.
    fn normal(&self) -> Point {
        Point::new(self.tangent.y, -self.tangent.x).normalize()
    }

    /// Curvatures along the meridian and around the axis; positive where the surface is convex.
    fn curvatures(&self) -> [f64; 2] {
        let along = (self.tangent.y * self.second.x - self.tangent.x * self.second.y)
            / -self.tangent.norm().powi(3);
        let around = self.normal().y / self.at.y;
        // At the poles both are equal.
        [along, if around.is_finite() { around } else { along }]
    }
}

impl Revolved {
    fn new(profile: RadialProfile, axis: Vector3<f64>, aspect: f64) -> Self {
        let mut surface = Self {
            profile,
            aspect,
            axis,
            across: any_normal(&axis),
            samples: Vec::new(),
            reach: 0.0,
            is_convex: true,
        };
        let mut points = Vec::with_capacity(SAMPLES + 1);
        for k in 0..=SAMPLES {
            let angle = PI * k as f64 / SAMPLES as f64;
            let point = surface.meridian(angle);
            surface.samples.push((angle, point.at));
            points.push(point);
        }
        let curvatures = || points.iter().flat_map(MeridianPoint::curvatures);
        surface.is_convex = curvatures().all(|curvature| curvature >= 0.0);
        let largest = curvatures().fold(0.0, |most: f64, own| most.max(own.abs()));
        // Federer (1959): the reach is the infimum of |y - x|² / (2 |(y - x) · n(x)|). For two
        // circles of latitude it is attained where the points are in one plane with the axis.
        let mut ratio: f64 = 0.0;
        for x in &points {
            let normal = x.normal();
            for (other, side) in points.iter().flat_map(|y| [(y, 1.0), (y, -1.0)]) {
                let arm = Point::new(other.at.x, side * other.at.y) - x.at;
                let squared = arm.norm_squared();
                if squared > 0.0 {
                    ratio = ratio.max(2.0 * arm.dot(&normal).abs() / squared);
                }
            }
        }
        surface.reach = 1.0 / largest.max(ratio);
        surface
    }

    /// The point of the meridian that was at an angle with the axis before the stretch.
    fn meridian(&self, angle: f64) -> MeridianPoint {
        // The poles are on the axis exactly, so that they stay on symmetry planes.
        let (sine, cosine) = match angle < PI {
            true => angle.sin_cos(),
            false => (0.0, -1.0),
        };
        let [r, slope, curve] = self.profile.along_meridian((sine, cosine));
        let (out, along) = (Point::new(cosine, sine), Point::new(-sine, cosine));
        let stretched = |x: Point| Point::new(self.aspect * x.x, x.y);
        MeridianPoint {
            at: stretched(r * out),
            tangent: stretched(slope * out + r * along),
            second: stretched((curve - r) * out + 2.0 * slope * along),
        }
    }

    /// Coordinates along the axis and across it, and the direction across it.
    fn coordinates(&self, x: &Vector3<f64>) -> (Point, Vector3<f64>) {
        let along = x.dot(&self.axis);
        let across = x - along * self.axis;
        let direction = across.try_normalize(0.0).unwrap_or(self.across);
        (Point::new(along, across.norm()), direction)
    }

    /// The point of the meridian closest to a point in its plane.
    ///
    /// Newton's method for `(p - x) · p' = 0` beside the closest sample, with bisection where it
    /// leaves the bracket. Two samples are equally close only near the medial axis, farther from
    /// the surface than its reach.
    fn foot(&self, x: &Point) -> MeridianPoint {
        let distance = |k: usize| (self.samples[k].1 - x).norm_squared();
        let closest = (0..=SAMPLES).fold(0, |best, k| match distance(k) < distance(best) {
            true => k,
            false => best,
        });
        let mut low = self.samples[closest.saturating_sub(1)].0;
        let mut high = self.samples[(closest + 1).min(SAMPLES)].0;
        let mut angle = self.samples[closest].0;
        let mut point = self.meridian(angle);
        for _ in 0..MAX_STEPS {
            let arm = point.at - x;
            let slope = arm.dot(&point.tangent);
            match slope > 0.0 {
                true => high = angle,
                false => low = angle,
            }
            let newton = angle - slope / (point.tangent.norm_squared() + arm.dot(&point.second));
            let next = match newton >= low && newton <= high {
                true => newton,
                false => 0.5 * (low + high),
            };
            let change = (next - angle).abs();
            angle = next;
            point = self.meridian(angle);
            if change <= 4.0 * f64::EPSILON {
                break;
            }
        }
        point
    }

    /// Distance of the surface before the stretch from the centre at an angle with this cosine.
    fn distance(&self, cosine: f64) -> f64 {
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        self.profile.at(&Vector3::new(sine, 0.0, cosine))
    }
}

impl Surface for Revolved {
    fn signed_distance(&self, point: Vector3<f64>) -> f64 {
        let (x, _) = self.coordinates(&point);
        let distance = (self.foot(&x).at - x).norm();
        let shortened = Point::new(x.x / self.aspect, x.y);
        let norm = shortened.norm();
        let is_inside = norm == 0.0 || norm < self.distance(shortened.x / norm);
        if is_inside { -distance } else { distance }
    }

    fn closest_point(&self, point: Vector3<f64>) -> Vector3<f64> {
        let (x, across) = self.coordinates(&point);
        let foot = self.foot(&x).at;
        foot.x * self.axis + foot.y * across
    }

    fn normal(&self, point: Vector3<f64>) -> Vector3<f64> {
        let (x, across) = self.coordinates(&point);
        let normal = self.foot(&x).normal();
        normal.x * self.axis + normal.y * across
    }

    fn bounding_ball(&self) -> (Vector3<f64>, f64) {
        let distances = self.samples.iter().map(|(_, x)| x.norm());
        let largest = distances.fold(0.0, f64::max);
        // Between samples the distance exceeds theirs by at most the sagitta of its curve.
        let step = PI / SAMPLES as f64;
        (Vector3::zeros(), largest * (1.0 + step * step))
    }

    fn volume(&self) -> f64 {
        self.aspect * self.profile.volume()
    }

    fn is_convex(&self) -> bool {
        self.is_convex
    }

    fn reach(&self) -> f64 {
        self.reach
    }

    fn inradius(&self) -> f64 {
        let distances = self.samples.iter().map(|(_, x)| x.norm());
        distances.fold(f64::INFINITY, f64::min)
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        if self.is_convex {
            return None;
        }
        let (_, radius) = self.bounding_ball();
        Some(coarse(radius, self.reach, |n| {
            let point = self.distance(n.dot(&self.axis)) * n;
            point + (self.aspect - 1.0) * point.dot(&self.axis) * self.axis
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::harmonics::Harmonic;
    use crate::octahedral::octahedral;
    use crate::surface_modes::SurfaceModes;
    use crate::words::ModeMotion;

    fn deformation(motion: ModeMotion) -> SphereDeformation {
        SphereDeformation {
            radius: 1.3,
            elongation: 0.0,
            size: None,
            modes: Some(SurfaceModes {
                motion,
                axis: Vector3::new(2.0, -1.0, 2.0) / 3.0,
                meridian: Vector3::new(1.0, 2.0, 0.0) / 5.0_f64.sqrt(),
                coordinates: of_orders([0; 3]),
            }),
        }
    }

    fn of_orders(orders: [i32; 3]) -> Vec<(Harmonic, usize)> {
        let harmonic = |(joint, (degree, order))| (Harmonic { degree, order }, joint);
        let both = [2, 3, 7].into_iter().zip(orders);
        both.enumerate().map(harmonic).collect()
    }

    /// Distances, normals, volume and reach agree, at convex shapes and at others, which a stretch
    /// leaves what they are.
    #[test]
    fn surfaces_of_modes_pass_the_checks_of_surfaces() {
        let pose = Isometry3::new(Vector3::new(0.3, -2.0, 1.0), Vector3::new(0.4, 1.0, -0.2));
        let motions = [ModeMotion::Radial, ModeMotion::Isochoric];
        let aspects = [1.0, 2.5, 0.4];
        let orders = [[0, 0, 0], [1, -3, 4]];
        let cases = aspects.map(|aspect| orders.map(|orders| (aspect, orders)));
        for (motion, (aspect, orders)) in motions
            .iter()
            .flat_map(|m| cases.as_flattened().iter().map(|case| (*m, *case)))
        {
            let mut deformation = deformation(motion);
            deformation.elongation = aspect - 1.0;
            deformation.modes.as_mut().unwrap().coordinates = of_orders(orders);
            for (values, is_convex) in [([0.1, -0.05, 0.0], true), ([0.2, 0.3, 0.05], false)] {
                let surface = deformation.surface(&values, &pose, 0.5);
                assert_eq!(surface.is_convex(), is_convex);
                mesh::check_surface(&*surface).unwrap();
                let volume = 0.125 * deformation.volume(&values);
                assert!((surface.volume() / volume - 1.0).abs() < 1e-13);
            }
        }
    }

    /// All orders of a degree are the mode about another axis: two surfaces with one shape.
    #[test]
    fn surfaces_without_an_axis_are_those_about_another_one() {
        let own = Vector3::new(2.0, -1.0, 2.0) / 3.0;
        let modes = &mut deformation(ModeMotion::Isochoric).modes.unwrap();
        (modes.axis, modes.meridian) = (Vector3::z(), Vector3::x());
        let orders = (2..=3_i32).flat_map(|n| (-n..=n).map(move |m| (n as usize, m)));
        let harmonics: Vec<_> = orders
            .map(|(degree, order)| Harmonic { degree, order })
            .collect();
        for amplitudes in [[0.1, -0.05], [0.2, 0.25]] {
            let amplitude = |of: &Harmonic| amplitudes[of.degree - 2] * of.at(&own);
            let values: Vec<f64> = harmonics.iter().map(amplitude).collect();
            modes.coordinates = harmonics.iter().copied().zip(0..).collect();
            let mut profile = deformation(ModeMotion::Isochoric).profile(&[0.0; 3]);
            profile.terms = modes.terms(&values);
            let spatial = StarSurface::new(profile, modes.clone(), 1.0);
            let tilted = deformation(ModeMotion::Isochoric);
            let values = [amplitudes[0], amplitudes[1], 0.0];
            let revolved = Revolved::new(tilted.profile(&values), own, 1.0);
            assert_eq!(spatial.is_convex(), revolved.is_convex());
            // Between samples a fiftieth of a radius apart the reach is larger by as much.
            let reaches = spatial.reach() / revolved.reach();
            assert!((1.0 - 1e-3..1.05).contains(&reaches), "{reaches}");
            assert!((spatial.volume() / revolved.volume() - 1.0).abs() < 1e-13);
            for x in [
                [0.3, 2.0, -1.0],
                [-5.0, 0.5, 0.2],
                [1.0, -1.0, 0.4],
                [0.9, 0.0, 0.8],
            ] {
                let x = Vector3::from(x);
                let apart = spatial.closest_point(x) - revolved.closest_point(x);
                assert!(apart.norm() < 1e-13, "{x}: {apart}");
                let turned = spatial.normal(x) - revolved.normal(x);
                assert!(turned.norm() < 1e-12, "{x}: {turned}");
                let distances = [spatial.signed_distance(x), revolved.signed_distance(x)];
                assert!((distances[0] - distances[1]).abs() < 1e-13, "{distances:?}");
            }
        }
    }

    /// The tips of a spheroid-like mode have the curvature `(r - r'') / r²`.
    #[test]
    fn the_reach_is_at_most_the_smallest_radius_of_curvature() {
        let deformation = deformation(ModeMotion::Radial);
        let surface = deformation.surface(&[0.2, 0.0, 0.0], &Isometry3::identity(), 1.0);
        // r = 1.3 (1 + 0.2 P_2), r'' = -3 * 0.2 * 1.3 at the poles
        let curvature: f64 = (1.2 + 0.6) / (1.3 * 1.2 * 1.2);
        assert!((surface.reach() * curvature - 1.0).abs() < 1e-3);
    }

    /// Poles and points of planes through the axis stay on the planes to the last bit.
    #[test]
    fn closest_points_stay_on_planes_through_the_axis() {
        let mut deformation = deformation(ModeMotion::Isochoric);
        deformation.modes.as_mut().unwrap().axis = Vector3::z();
        let surface = deformation.surface(&[0.1, 0.2, 0.0], &Isometry3::identity(), 1.0);
        for (x, z) in [
            (0.0, 2.0),
            (0.0, -2.0),
            (0.0, -0.9),
            (0.3, 1.0),
            (1e-17, -1.3),
        ] {
            let foot = surface.closest_point(Vector3::new(x, 0.0, z));
            assert_eq!(foot.y, 0.0);
            assert!(foot.x.abs() < 1e-15 || x > 1e-16);
        }
    }

    /// The same where the planes mirror harmonics without an axis, also in turned frames.
    #[test]
    fn closest_points_stay_on_planes_that_mirror_harmonics() {
        let mut deformation = deformation(ModeMotion::Radial);
        let modes = deformation.modes.as_mut().unwrap();
        modes.coordinates = of_orders([2, 1, 4]);
        for axis in [[1.0, 0.0, 0.0], [0.6, 0.0, 0.8]] {
            modes.axis = Vector3::from(axis);
            modes.meridian = Vector3::y().cross(&modes.axis);
            assert!(modes.keeps_plane(1));
            let values = [0.1, -0.1, 0.05];
            let profile = {
                let mut profile = RadialProfile::sphere(1.3);
                profile.terms = modes.terms(&values);
                profile
            };
            let surface = StarSurface::new(profile, modes.clone(), 1.7);
            let coarse = octahedral(5, |n| n).points;
            for n in coarse.iter().filter(|n| n.y == 0.0) {
                // Deep inside the foot is beside the plane.
                let at = surface.closest_point(2.5 * n);
                for scale in [0.98, 1.0, 1.02] {
                    assert_eq!(surface.closest_point(scale * at).y, 0.0, "{scale} {n}");
                }
            }
        }
    }

    /// Points of a coordinate plane had their foot on it, also at the bottom of a valley.
    #[test]
    fn bug_distances_from_valleys_were_those_to_their_bottom() {
        let harmonic = Harmonic {
            degree: 8,
            order: 8,
        };
        let mut deformation = deformation(ModeMotion::Radial);
        let modes = deformation.modes.as_mut().unwrap();
        (modes.axis, modes.meridian) = (Vector3::z(), Vector3::x());
        modes.coordinates = vec![(harmonic, 0)];
        let mut profile = RadialProfile::sphere(1.0);
        profile.terms = vec![(harmonic, -0.19 / harmonic.at(&Vector3::x()))];
        let surface = StarSurface::new(profile.clone(), modes.clone(), 1.0);
        let points = octahedral(60, |n| profile.at(&n) * n).points;
        for distance in [1.5, 3.0] {
            let x = Vector3::new(distance, 0.0, 0.0);
            let least = points
                .iter()
                .map(|at| (at - x).norm())
                .fold(f64::INFINITY, f64::min);
            let found = surface.signed_distance(x);
            // The foot is no farther than the closest of these points, by less than their spacing
            // squared over the radius of curvature.
            assert!(found <= least && found > least - 0.01, "{found} {least}");
        }
    }

    /// Without modes, and with tangential ones, the surface is that of a rigid spheroid.
    #[test]
    fn spheroids_are_those_without_a_deformation() {
        let mut deformation = deformation(ModeMotion::Tangential);
        deformation.modes.as_mut().unwrap().axis = Vector3::x();
        for aspect in [3.0, 0.3] {
            deformation.elongation = aspect - 1.0;
            let surface = deformation.surface(&[0.1, 0.0, 0.02], &Isometry3::identity(), 1.0);
            // The smallest radius of curvature: at a pole, or at the equator along the meridian.
            let smallest = 1.3 * (1.0 / aspect).min(aspect * aspect);
            assert!((surface.reach() / smallest - 1.0).abs() < 1e-3);
            let semi_axes = Vector3::new(1.3 * aspect, 1.3, 1.3);
            let rigid = mesher::Ellipsoid { semi_axes };
            for x in [[0.3, 2.0, -1.0], [-5.0, 0.5, 0.2], [1.0, -1.0, 0.4]] {
                let x = Vector3::from(x);
                // The rounding of angles, and the accuracy to which normals of ellipsoids are
                // tested.
                let apart = surface.closest_point(x) - rigid.closest_point(x);
                assert!(apart.norm() < 1e-13, "{aspect}: {apart}");
                let turned = surface.normal(x) - rigid.normal(x);
                assert!(turned.norm() < 1e-12, "{aspect}: {turned}");
            }
            assert_eq!(deformation.volume_rate(&[0.1, 0.0, 0.02], 0), 0.0);
        }
    }

    /// Tangential modes leave a sphere, whatever their amplitudes.
    #[test]
    fn tangential_modes_leave_a_sphere() {
        let deformation = deformation(ModeMotion::Tangential);
        let surface = deformation.surface(&[0.1, 0.1, 0.02], &Isometry3::identity(), 2.0);
        assert_eq!(surface.bounding_ball(), (Vector3::zeros(), 2.6));
        assert_eq!(surface.reach(), 2.6);
    }
}
