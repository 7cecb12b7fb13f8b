//! Outlines of bodies in a plane.

use std::collections::BTreeMap;

use mesh::SurfaceMesh;
use nalgebra::{Isometry3, Point3};

use super::plane::SlicePlane;

/// The closed curves in which the plane cuts a surface at a pose.
///
/// Points are in coordinates of the window (see [`SlicePlane::coordinates`]). The surface is
/// closed, so that every cut edge belongs to two triangles and the curves are closed.
pub fn section(
    surface: &SurfaceMesh,
    pose: &Isometry3<f64>,
    plane: &SlicePlane,
) -> Vec<Vec<[f64; 2]>> {
    let points: Vec<_> = (surface.points.iter())
        .map(|x| (pose * Point3::from(*x)).coords)
        .collect();
    let normal = plane.normal();
    let heights: Vec<f64> = (points.iter())
        .map(|x| (x - plane.centre).dot(&normal))
        .collect();
    // Vertices in the plane count as above it, so that a curve crosses edges only.
    let is_above = |v: u32| heights[v as usize] >= 0.0;
    let mut next = BTreeMap::new();
    for corners in &surface.triangles {
        // Two of the three edges cross the plane, one in each direction.
        let mut ends = [None; 2];
        for k in 0..3 {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            if is_above(a) != is_above(b) {
                ends[usize::from(is_above(a))] = Some([a.min(b), a.max(b)]);
            }
        }
        if let [Some(from), Some(to)] = ends {
            next.insert(from, to);
        }
    }
    let crossing = |[a, b]: [u32; 2]| {
        let [a, b] = [a, b].map(|v| v as usize);
        let share = heights[a] / (heights[a] - heights[b]);
        plane.coordinates(&(points[a] + share * (points[b] - points[a])))
    };
    let mut curves = Vec::new();
    while let Some((first, mut to)) = next.pop_first() {
        let mut curve = vec![crossing(first)];
        while to != first {
            curve.push(crossing(to));
            let Some(following) = next.remove(&to) else {
                break;
            };
            to = following;
        }
        curves.push(curve);
    }
    curves
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use scene::{Shape, TorusShape};

    use super::super::body_surface;
    use super::*;

    fn area(curve: &[[f64; 2]]) -> f64 {
        let turned = curve.iter().cycle().skip(1);
        let twice: f64 = (curve.iter().zip(turned))
            .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
            .sum();
        0.5 * twice.abs()
    }

    #[test]
    fn a_plane_cuts_a_sphere_in_one_circle_and_a_torus_in_two() {
        let plane = SlicePlane {
            centre: Vector3::new(0.0, 0.0, 0.3),
            right: Vector3::x(),
            up: Vector3::y(),
            width: 1.0,
            height: 1.0,
        };
        let cut = |shape: Shape| {
            let surface = body_surface(&shape).unwrap();
            section(&surface, &Isometry3::identity(), &plane)
        };
        let circles = cut(Shape::sphere(1.0));
        let exact = std::f64::consts::PI * (1.0 - 0.09);
        assert_eq!(circles.len(), 1);
        assert!((area(&circles[0]) / exact - 1.0).abs() < 0.03);
        let axis = Vector3::x();
        let torus = cut(Shape::Torus(TorusShape {
            radius: 1.0,
            tube_radius: 0.25,
            axis,
        }));
        assert_eq!(torus.len(), 2);
    }
}
