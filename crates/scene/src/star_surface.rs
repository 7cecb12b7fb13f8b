//! The surfaces of spheres and spheroids with modes that have no axis of symmetry.

use mesh::{Surface, SurfaceMesh};
use nalgebra::{Matrix2, Vector2, Vector3};

use crate::octahedral::{coarse, octahedral};
use crate::radial_profile::RadialProfile;
use crate::surface_modes::{SurfaceModes, stepped, tangents};

/// Divisions of the octants of directions in which a surface is tabulated: the shortest wave has
/// eight of them.
const DIVISIONS: usize = 24;

/// Steps of Newton's method for a closest point, more than it needs.
const MAX_STEPS: usize = 60;

/// Smallest step whose distance is compared with the one before; below it Newton's method
/// converges to rounding.
const SURE_STEP: f64 = 1e-4;

/// Largest distance of points from the closest sample, over the size of the surface.
const MISSED: f64 = 0.06;

/// Rounding of a squared distance, relative to it.
const ROUNDING: f64 = 1e-12;

/// Cosine of the angle between directions from which the closest point is sought, a wave of a high
/// degree; and their number.
const APART: f64 = 0.97;
const MAX_STARTS: usize = 4;

/// A radial function over all directions, stretched along the axis of its modes.
///
/// Its points and directions are in the axes of the modes.
pub(crate) struct StarSurface {
    profile: RadialProfile,
    modes: SurfaceModes,
    /// Lengths along the three axes over those of the radial function.
    stretch: Vector3<f64>,
    /// Directions with their points.
    samples: Vec<(Vector3<f64>, Vector3<f64>)>,
    reach: f64,
    is_convex: bool,
}

/// A point of the surface with its derivatives along two tangents of the unit sphere.
struct Chart {
    tangents: [Vector3<f64>; 2],
    at: Vector3<f64>,
    first: [Vector3<f64>; 2],
    /// Second derivatives: along one, along the other, mixed.
    second: [Vector3<f64>; 3],
}

impl Chart {
    /// The outward unit normal.
    fn normal(&self) -> Vector3<f64> {
        // Of the tangents a and n × a of the sphere the product is n.
        self.first[0].cross(&self.first[1]).normalize()
    }

    /// Principal curvatures, positive where the surface is convex.
    fn curvatures(&self) -> [f64; 2] {
        let [a, b] = self.first;
        let [aa, bb, ab] = self.second.map(|of| -of.dot(&self.normal()));
        let metric = Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b));
        let form = Matrix2::new(aa, ab, ab, bb);
        let inverse = metric.try_inverse().unwrap_or_default();
        let map = inverse * form;
        let (mean, product) = (0.5 * map.trace(), map.determinant());
        let root = (mean * mean - product).max(0.0).sqrt();
        [mean + root, mean - root]
    }
}

impl StarSurface {
    pub(crate) fn new(profile: RadialProfile, modes: SurfaceModes, aspect: f64) -> Self {
        let mut surface = Self {
            profile,
            modes,
            stretch: Vector3::new(1.0, 1.0, aspect),
            samples: Vec::new(),
            reach: 0.0,
            is_convex: true,
        };
        let directions = octahedral(DIVISIONS, |n| n).points;
        let charts: Vec<Chart> = directions.iter().map(|n| surface.chart(n)).collect();
        let curvatures = || charts.iter().flat_map(Chart::curvatures);
        surface.is_convex = curvatures().all(|curvature| curvature >= 0.0);
        let mut ratio = curvatures().fold(0.0, |most: f64, own| most.max(own.abs()));
        // Federer (1959): the reach is the infimum of |y - x|² / (2 |(y - x) · n(x)|).
        for x in &charts {
            let normal = x.normal();
            for y in &charts {
                let arm = y.at - x.at;
                let (squared, height) = (arm.norm_squared(), 2.0 * arm.dot(&normal).abs());
                if height > ratio * squared {
                    ratio = height / squared;
                }
            }
        }
        surface.reach = 1.0 / ratio;
        surface.samples = directions
            .into_iter()
            .zip(charts.iter().map(|chart| chart.at))
            .collect();
        surface
    }

    /// The point in a direction.
    fn point(&self, n: &Vector3<f64>) -> Vector3<f64> {
        (self.profile.at(n) * n).component_mul(&self.stretch)
    }

    fn chart(&self, n: &Vector3<f64>) -> Chart {
        let (r, gradient, curve) = self.profile.jet(n);
        let tangents = tangents(n);
        let [a, b] = tangents;
        let stretched = |x: Vector3<f64>| x.component_mul(&self.stretch);
        // The direction n + u a + v b, normalised, has the second derivatives -n along a and b, 0
        // mixed.
        let slope = [a, b].map(|t| gradient.dot(&t));
        let second = |s: &Vector3<f64>, t: &Vector3<f64>| s.dot(&(curve * t));
        let along = gradient.dot(n);
        let own = |k: usize, t: &Vector3<f64>| {
            stretched((second(t, t) - along - r) * n + 2.0 * slope[k] * t)
        };
        Chart {
            tangents,
            at: stretched(r * n),
            first: [0, 1].map(|k| stretched(slope[k] * n + r * tangents[k])),
            second: [
                own(0, &a),
                own(1, &b),
                stretched(second(&a, &b) * n + slope[0] * b + slope[1] * a),
            ],
        }
    }

    /// The point of the surface closest to a point, both in the axes of the modes.
    ///
    /// From the closest sample, and from those far from it that may be as close to a point that no
    /// sample hits.
    fn foot(&self, x: &Vector3<f64>) -> Chart {
        let mut found: Option<(f64, Chart)> = None;
        let mut starts: Vec<Vector3<f64>> = Vec::new();
        let slack = (MISSED * self.profile.largest(self.stretch.z)).powi(2);
        while starts.len() < MAX_STARTS {
            let mut closest = (f64::INFINITY, Vector3::x());
            for (direction, at) in &self.samples {
                let own = (at - x).norm_squared();
                let is_new = || starts.iter().all(|start| start.dot(direction) < APART);
                if own < closest.0 && is_new() {
                    closest = (own, *direction);
                }
            }
            if found
                .as_ref()
                .is_some_and(|(least, _)| closest.0 > least + slack)
            {
                break;
            }
            starts.push(closest.1);
            let mut chart = self.descent(x, &closest.1);
            let mut own = (chart.at - x).norm_squared();
            // A foot on a symmetry plane is found there to the last bit; one on another plane, or
            // a saddle, is farther.
            let in_planes = closest
                .1
                .zip_map(x, |own, x| if x == 0.0 { 0.0 } else { own });
            if let Some(start) = in_planes.try_normalize(0.0).filter(|n| *n != closest.1) {
                let in_planes = self.descent(x, &start);
                let squared = (in_planes.at - x).norm_squared();
                if squared <= own * (1.0 + ROUNDING) {
                    (chart, own) = (in_planes, squared);
                }
            }
            if found.as_ref().is_none_or(|(least, _)| own < *least) {
                found = Some((own, chart));
            }
        }
        found.map_or_else(|| self.chart(&Vector3::x()), |(_, chart)| chart)
    }

    /// The closest point near a direction.
    ///
    /// Newton's method for the squared distance, that of Gauss where its matrix is indefinite, with
    /// steps that reduce the distance.
    fn descent(&self, x: &Vector3<f64>, from: &Vector3<f64>) -> Chart {
        let mut n = *from;
        let mut chart = self.chart(&n);
        for _ in 0..MAX_STEPS {
            let arm = chart.at - x;
            let [a, b] = chart.first;
            let [aa, bb, ab] = chart.second.map(|of| of.dot(&arm));
            let slope = Vector2::new(a.dot(&arm), b.dot(&arm));
            let gauss = Matrix2::new(a.dot(&a), a.dot(&b), a.dot(&b), b.dot(&b));
            let newton = gauss + Matrix2::new(aa, ab, ab, bb);
            let is_minimum = newton.m11 > 0.0 && newton.determinant() > 0.0;
            let matrix = if is_minimum { newton } else { gauss };
            let mut step = matrix
                .try_inverse()
                .map_or_else(Vector2::zeros, |of| -of * slope);
            // Beyond a quarter of a turn the chart has no points.
            step *= (0.5 / step.norm()).min(1.0);
            let before = arm.norm();
            let mut next = stepped(&n, &chart.tangents, &step);
            // The comparisons end with numbers that are none.
            while step.norm() >= SURE_STEP && (self.point(&next) - x).norm() >= before {
                step *= 0.5;
                next = stepped(&n, &chart.tangents, &step);
            }
            n = next;
            chart = self.chart(&n);
            if step.norm() <= 4.0 * f64::EPSILON {
                break;
            }
        }
        chart
    }
}

impl Surface for StarSurface {
    fn signed_distance(&self, point: Vector3<f64>) -> f64 {
        let x = self.modes.local(&point);
        let distance = (self.foot(&x).at - x).norm();
        let shortened = x.component_div(&self.stretch);
        let norm = shortened.norm();
        let is_inside = norm == 0.0 || norm < self.profile.at(&(shortened / norm));
        if is_inside { -distance } else { distance }
    }

    fn closest_point(&self, point: Vector3<f64>) -> Vector3<f64> {
        let foot = self.foot(&self.modes.local(&point));
        self.modes.global(&foot.at)
    }

    fn normal(&self, point: Vector3<f64>) -> Vector3<f64> {
        let foot = self.foot(&self.modes.local(&point));
        self.modes.global(&foot.normal())
    }

    fn bounding_ball(&self) -> (Vector3<f64>, f64) {
        (Vector3::zeros(), self.profile.largest(self.stretch.z))
    }

    fn volume(&self) -> f64 {
        self.stretch.z * self.profile.volume()
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
        // The octants of the body's axes, whose planes may be symmetry planes.
        Some(coarse(radius, self.reach, |n| {
            self.modes.global(&self.point(&self.modes.local(&n)))
        }))
    }
}
