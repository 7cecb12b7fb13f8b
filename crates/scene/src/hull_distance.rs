//! The distance between convex hulls.

use nalgebra::{UnitQuaternion, Vector3};

use crate::shape::Shape;

/// Largest number of steps of the search for a separating plane.
const STEPS: usize = 200;

/// Relative difference of the bounds on a distance at which the search ends.
const ACCURACY: f64 = 1e-9;

/// Two bodies, each with its rotation from the initial configuration.
pub(crate) type Pair<'a> = [(&'a Shape, &'a UnitQuaternion<f64>); 2];

/// Lower bound of the distance between two bodies, negative if their convex hulls overlap.
///
/// `apart` is the difference of the centres, that of the first minus that of the second. Exact for
/// spheres; for other shapes the search for the plane that separates the hulls best (Gilbert 1966)
/// starts with the direction of `apart` and ends within 1e-9 of the distance, or after 200 steps.
pub(crate) fn distance(bodies: Pair, apart: &Vector3<f64>) -> f64 {
    separation(bodies, apart).0
}

/// Distance of the two planes normal to `normal`, a unit vector towards the first body, that touch
/// the bodies from between; negative if no such plane separates them.
pub(crate) fn distance_along(bodies: Pair, apart: &Vector3<f64>, normal: &Vector3<f64>) -> f64 {
    let [(first, of_first), (second, of_second)] = bodies;
    normal.dot(apart)
        - first.support_distance(of_first, &-normal)
        - second.support_distance(of_second, normal)
}

/// The lower bound of [`distance`], and the normal of the planes that separate the bodies by it.
pub(crate) fn separation(bodies: Pair, apart: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let [(first, of_first), (second, of_second)] = bodies;
    let start = apart.try_normalize(0.0).unwrap_or_else(Vector3::x);
    let along_centres = apart.norm()
        - first.support_distance(of_first, &-start)
        - second.support_distance(of_second, &start);
    if first.is_isotropic() && second.is_isotropic() {
        return (along_centres, start);
    }
    let (near, far) = (first.support(of_first), second.support(of_second));
    search((along_centres, start), apart, |n| {
        apart + near(&-n) - far(n)
    })
}

/// Lower bound of the distance between the convex hull of a body and a triangle, as [`distance`].
pub(crate) fn distance_from_triangle(
    shape: &Shape,
    rotation: &UnitQuaternion<f64>,
    centre: &Vector3<f64>,
    triangle: &[Vector3<f64>; 3],
) -> f64 {
    let apart = centre - triangle.iter().sum::<Vector3<f64>>() / 3.0;
    let farthest = |n: &Vector3<f64>| {
        let [mut farthest, b, c] = *triangle;
        for corner in [b, c] {
            if n.dot(&corner) > n.dot(&farthest) {
                farthest = corner;
            }
        }
        farthest
    };
    let start = apart.try_normalize(0.0).unwrap_or_else(Vector3::x);
    let along = start.dot(&(centre - farthest(&start))) - shape.support_distance(rotation, &-start);
    let support = shape.support(rotation);
    let corner = |n: &Vector3<f64>| centre + support(&-n) - farthest(n);
    search((along, start), &apart, corner).0
}

/// The separating planes that are farthest apart, from those of a first direction.
///
/// `apart` is a point of the difference of the bodies, `corner` the one that is farthest against a
/// direction.
fn search(
    first: (f64, Vector3<f64>),
    apart: &Vector3<f64>,
    corner: impl Fn(&Vector3<f64>) -> Vector3<f64>,
) -> (f64, Vector3<f64>) {
    let (mut bound, mut normal) = first;
    // The point closest to the origin among the convex combinations of some points of the
    // difference of the bodies, which are given with their weights.
    let mut corners = vec![(*apart, 1.0)];
    let mut closest = *apart;
    for _ in 0..STEPS {
        let length = closest.norm();
        let Some(n) = closest.try_normalize(0.0) else {
            break;
        };
        let corner = corner(&n);
        if n.dot(&corner) > bound {
            (bound, normal) = (n.dot(&corner), n);
        }
        if bound >= length * (1.0 - ACCURACY) {
            break;
        }
        corners.push((corner, 0.0));
        closest = closest_combination(&mut corners);
    }
    (bound, normal)
}

/// The point closest to the origin in the convex hull of the corners, whose weights are updated.
///
/// Weight moves from the corner farthest along the point to the one farthest against it, until they
/// are equally far (pairwise Frank-Wolfe steps, which converge linearly; Lacoste-Julien & Jaggi
/// 2015). Corners without weight are removed.
fn closest_combination(corners: &mut Vec<(Vector3<f64>, f64)>) -> Vector3<f64> {
    let mut point = Vector3::zeros();
    for _ in 0..STEPS {
        point = corners.iter().map(|(x, weight)| x * *weight).sum();
        let along = |k: &usize| point.dot(&corners[*k].0);
        let all = 0..corners.len();
        let heavy = all.clone().filter(|&k| corners[k].1 > 0.0);
        let (Some(low), Some(high)) = (
            all.min_by(|i, j| along(i).total_cmp(&along(j))),
            heavy.max_by(|i, j| along(i).total_cmp(&along(j))),
        ) else {
            break;
        };
        let arm = corners[low].0 - corners[high].0;
        if -point.dot(&arm) <= 0.1 * ACCURACY * point.norm_squared() {
            break;
        }
        let part = (-point.dot(&arm) / arm.norm_squared()).min(corners[high].1);
        corners[low].1 += part;
        corners[high].1 -= part;
    }
    corners.retain(|(_, weight)| *weight > 0.0);
    point
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shapes::{
        CapsuleShape, DiskShape, EllipsoidShape, HelixShape, SphereShape, SpheroidShape, TorusShape,
    };

    fn shapes() -> [Shape; 7] {
        let axis = Vector3::new(2.0, -1.0, 2.0) / 3.0;
        let orientation = Vector3::new(30.0, 50.0, -20.0);
        let (radius, half_length, tube_radius) = (1.0, 3.0, 0.2);
        [
            Shape::Sphere(SphereShape { radius }),
            Shape::Ellipsoid(EllipsoidShape {
                semi_axes: Vector3::new(1.0, 2.0, 0.5),
                orientation,
            }),
            Shape::Spheroid(SpheroidShape {
                radius,
                half_length,
                axis,
            }),
            Shape::Capsule(CapsuleShape {
                radius,
                half_length,
                axis,
            }),
            Shape::Disk(DiskShape {
                radius,
                half_length: 0.2,
                axis,
            }),
            Shape::Torus(TorusShape {
                radius,
                tube_radius,
                axis,
            }),
            Shape::Helix(HelixShape {
                radius,
                tube_radius,
                pitch: -1.5,
                turns: 1.8,
                orientation,
            }),
        ]
    }

    fn directions() -> impl Iterator<Item = Vector3<f64>> {
        (0..500).map(|k| {
            let k = f64::from(k);
            Vector3::new((1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k + 0.3).sin()).normalize()
        })
    }

    #[test]
    fn support_distances_of_a_spheroid_along_its_axes_are_its_semi_axes() {
        let shape = Shape::Spheroid(SpheroidShape {
            radius: 1.0,
            half_length: 3.0,
            axis: Vector3::x(),
        });
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::z() * std::f64::consts::FRAC_PI_2);
        for (direction, expected) in [
            (Vector3::x(), 1.0),
            (Vector3::y(), 3.0),
            (Vector3::z(), 1.0),
        ] {
            assert!((shape.support_distance(&rotation, &direction) - expected).abs() < 1e-12);
        }
        assert!((shape.transverse_support_distance(&rotation, &Vector3::x()) - 3.0).abs() < 1e-12);
        assert!((shape.transverse_support_distance(&rotation, &Vector3::y()) - 1.0).abs() < 1e-12);
    }

    /// A support point is a point of the body, and no point of the body is farther.
    #[test]
    fn support_points_are_the_farthest_points() {
        let rotation = UnitQuaternion::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5));
        for shape in shapes() {
            let points: Vec<_> = directions()
                .map(|n| shape.support_point(&rotation, &n))
                .collect();
            for n in directions() {
                let support = shape.support_distance(&rotation, &n);
                let farthest = points.iter().map(|x| x.dot(&n)).fold(f64::MIN, f64::max);
                assert!((farthest - support).abs() < 1e-12, "{shape:?}");
                assert!(support <= shape.bounding_radius() + 1e-12, "{shape:?}");
            }
            let across = Vector3::new(0.6, 0.0, 0.8);
            let shadow = |n: Vector3<f64>| (n - across * n.dot(&across)).normalize();
            let sampled = directions()
                .map(|n| shape.support_distance(&rotation, &shadow(n)))
                .fold(0.0, f64::max);
            let bound = shape.transverse_support_distance(&rotation, &across);
            let exact = !matches!(shape, Shape::Helix(_));
            assert!(bound >= sampled - 1e-12, "{shape:?}");
            assert!(
                !exact || bound < sampled + 1e-3,
                "{shape:?} {bound} {sampled}"
            );
        }
    }

    /// Two crossed capsules: the distance of their axes minus their radii, which is not the gap
    /// along the line of the centres.
    #[test]
    fn distances_of_capsules_and_ellipsoids() {
        let capsule = |axis: Vector3<f64>| {
            Shape::Capsule(CapsuleShape {
                radius: 1.0,
                half_length: 4.0,
                axis,
            })
        };
        let unit = UnitQuaternion::identity();
        let apart = Vector3::new(1.0, 2.0, 2.5);
        let [a, b] = [capsule(Vector3::x()), capsule(Vector3::y())];
        let gap = distance([(&a, &unit), (&b, &unit)], &apart);
        assert!((gap - 0.5).abs() < 1e-6, "{gap}");
        // Capsules on one axis.
        let gap = distance([(&a, &unit), (&a, &unit)], &(8.25 * Vector3::x()));
        assert!((gap - 0.25).abs() < 1e-12, "{gap}");
        assert!(distance([(&a, &unit), (&b, &unit)], &(0.9 * apart / 1.5)) < 0.0);
        // An ellipsoid and a sphere on its normal (1, 1, 1) through the support point.
        let ellipsoid = shapes()[1].clone();
        let n = Vector3::repeat(1.0).normalize();
        let sphere = Shape::sphere(1.0);
        let at = ellipsoid.support_point(&unit, &n) + 1.25 * n;
        let gap = distance([(&sphere, &unit), (&ellipsoid, &unit)], &at);
        assert!((gap - 0.25).abs() < 1e-8, "{gap}");
    }
}
