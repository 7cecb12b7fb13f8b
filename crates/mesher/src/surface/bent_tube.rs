//! Tubes of a varying radius along bent curves.

use super::tube::{Section, circles_with_poles, intervals};
use super::tube_profile::{MeridianPoint, Piece, TubeProfile};
use mesh::{Surface, SurfaceMesh, Vec3};
use std::f64::consts::FRAC_PI_4;
use std::sync::OnceLock;

/// Sample circles on an arc of the meridian, from which closest points are searched.
const ARC_SAMPLES: usize = 12;

/// Sample circles per length of the centreline over which it turns by one radian, at least.
const SAMPLES_PER_RADIAN: f64 = 12.0;

/// Largest number of sample circles along the centreline.
const MAX_SAMPLES: f64 = 4096.0;

/// Distance from the centreline, relative to the lengths from which it is computed, that is
/// rounding.
const AXIS_ROUNDING: f64 = 1e-13;

/// Width of an interval of the meridian across which a function changes at its maximum by rounding.
const ROOT_OF_ROUNDING: f64 = 1e-9;

/// Steps of the search for a root, more than it needs.
const MAX_STEPS: usize = 80;

/// A point of a curve with a length of arc as parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurvePoint {
    /// Position.
    pub point: Vec3,
    /// The unit tangent, and two unit vectors across it that form a right-handed frame with it.
    pub axes: [Vec3; 3],
    /// Derivative of the tangent with respect to the length of arc.
    pub curvature: Vec3,
}

/// A smooth curve of a finite length, which continues along its tangents beyond its ends.
pub trait Centreline: Send + Sync {
    /// Length of the curve.
    fn length(&self) -> f64;

    /// Least number of equal parts into which no part turns by more than about a radian.
    fn parts(&self) -> f64;

    /// The point at a length of arc from zero to [`Centreline::length`].
    fn at(&self, arc: f64) -> CurvePoint;

    /// The point at any length of arc, beyond the ends on the tangents there.
    fn extended(&self, arc: f64) -> CurvePoint {
        let inside = arc.clamp(0.0, self.length());
        let mut found = self.at(inside);
        if inside != arc {
            found.point += (arc - inside) * found.axes[0];
            found.curvature = Vec3::zeros();
        }
        found
    }
}

/// A tube along a curve: circles across the curve, with the radii of a [`TubeProfile`].
///
/// The tube does not touch itself if [`Surface::reach`] is positive.
#[derive(Clone, Debug)]
pub struct BentTube<C> {
    curve: C,
    profile: TubeProfile,
    /// Sample circles, with their parameters on the meridian.
    samples: Vec<(f64, Circle)>,
    /// Largest distance between neighbouring circles.
    spacing: f64,
    /// [`Surface::reach`], which costs a comparison of all circles; known once it is asked for.
    reach: OnceLock<f64>,
    ball: (Vec3, f64),
}

/// All else follows from the curve and the profile.
impl<C: PartialEq> PartialEq for BentTube<C> {
    fn eq(&self, other: &Self) -> bool {
        self.curve == other.curve && self.profile == other.profile
    }
}

/// A cross-section of the tube.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Circle {
    on_curve: CurvePoint,
    meridian: MeridianPoint,
}

/// A point of the surface of a tube, by coordinates that move with the material.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TubePoint {
    /// Length of arc of the centreline.
    pub arc: f64,
    /// Components of the arm from the centreline along the two axes across it.
    pub across: [f64; 2],
}

impl Circle {
    /// The arm of a point, its part along the tangent, its distance from the tangent and the
    /// direction of the rest.
    fn coordinates(&self, x: &Vec3) -> (f64, f64, Vec3) {
        let [tangent, across, _] = &self.on_curve.axes;
        let arm = x - self.on_curve.point;
        let along = arm.dot(tangent);
        let rest = arm - along * tangent;
        // From a point of the centreline all directions across it are equally short; next to it
        // the rounding of the arm has any direction.
        let rounding = AXIS_ROUNDING * (arm.norm() + self.meridian.radius);
        let direction = rest.try_normalize(rounding).unwrap_or(*across);
        (along, rest.norm(), direction)
    }

    fn squared_distance(&self, x: &Vec3) -> f64 {
        let arm = x - self.on_curve.point;
        let along = arm.dot(&self.on_curve.axes[0]);
        let off = (arm.norm_squared() - along * along).max(0.0).sqrt();
        along * along + (off - self.meridian.radius).powi(2)
    }

    /// Half of the derivative of the squared distance with respect to the parameter.
    fn slope(&self, x: &Vec3) -> f64 {
        let (along, off, direction) = self.coordinates(x);
        let MeridianPoint {
            radius, derivative, ..
        } = self.meridian;
        -derivative[0] * along * self.stretch(&direction) - derivative[1] * (off - radius)
    }

    /// Length along the surface per length of arc of the centreline, on one side of a cylinder.
    fn stretch(&self, direction: &Vec3) -> f64 {
        1.0 - self.meridian.radius * direction.dot(&self.on_curve.curvature)
    }

    fn foot(&self, x: &Vec3) -> Vec3 {
        let (_, _, direction) = self.coordinates(x);
        self.on_curve.point + self.meridian.radius * direction
    }

    fn normal(&self, x: &Vec3) -> Vec3 {
        let (_, _, direction) = self.coordinates(x);
        let [cos, sin] = self.meridian.normal;
        (sin * self.stretch(&direction) * direction - cos * self.on_curve.axes[0]).normalize()
    }
}

impl<C: Centreline> BentTube<C> {
    /// The tube of a profile along a curve of its length.
    pub fn new(curve: C, profile: TubeProfile) -> Self {
        let mut tube = Self {
            curve,
            profile,
            samples: Vec::new(),
            spacing: 0.0,
            reach: OnceLock::new(),
            ball: (Vec3::zeros(), 0.0),
        };
        tube.samples = tube.sampled();
        let pairs = tube.samples.windows(2);
        let between = |pair: &[(f64, Circle)]| {
            let [a, b] = [&pair[0].1, &pair[1].1];
            let turn = (a.on_curve.axes[0] - b.on_curve.axes[0]).norm();
            (a.on_curve.point - b.on_curve.point).norm()
                + (a.meridian.radius - b.meridian.radius).abs()
                + turn * a.meridian.radius.max(b.meridian.radius)
        };
        tube.spacing = pairs.map(between).fold(0.0, f64::max);
        tube.ball = tube.around();
        tube
    }

    /// The tube with the cross-sections at samples of the meridian.
    fn sampled(&self) -> Vec<(f64, Circle)> {
        let mut samples = Vec::new();
        for (number, piece) in self.profile.pieces.iter().enumerate() {
            let count = match piece {
                Piece::Arc { .. } => ARC_SAMPLES,
                Piece::Along { .. } => {
                    let radius = self.profile.radii[0].min(self.profile.radii[1]);
                    let least = SAMPLES_PER_RADIAN * self.curve.parts();
                    // A number that is not finite gives the smallest table.
                    (self.profile.length() / radius).max(least).min(MAX_SAMPLES) as usize + 4
                }
            };
            let shares = (0..count).map(|k| number as f64 + k as f64 / count as f64);
            samples.extend(shares.map(|at| (at, self.circle(at))));
        }
        let last = self.profile.pieces.len() as f64;
        samples.push((last, self.circle(last)));
        samples
    }

    fn circle(&self, parameter: f64) -> Circle {
        let meridian = self.profile.at(parameter);
        Circle {
            on_curve: self.curve.extended(meridian.arc),
            meridian,
        }
    }

    /// A ball about the middle of the extents.
    fn around(&self) -> (Vec3, f64) {
        let start = [f64::INFINITY, f64::NEG_INFINITY].map(Vec3::repeat);
        let points = self.samples.iter().map(|(_, circle)| circle.on_curve.point);
        let [low, high] = points.fold(start, |[l, h], x| [l.inf(&x), h.sup(&x)]);
        let centre = 0.5 * (low + high);
        let distance = |(_, circle): &(f64, Circle)| {
            (circle.on_curve.point - centre).norm() + circle.meridian.radius
        };
        let largest = self.samples.iter().map(distance).fold(0.0, f64::max);
        (centre, largest + 0.5 * self.spacing)
    }

    /// Radius of the largest balls that fit to both sides of all points; negative if the tube
    /// touches itself.
    fn smallest_ball(&self) -> f64 {
        let [front, end] = self.profile.end_balls();
        let [start, last] = self.profile.radii;
        // The largest second derivative of the radius is 6 |b - a| / L².
        let of_taper = self.profile.length().powi(2) / (6.0 * (start - last).abs());
        let inside = front.1.min(end.1).min(start).min(of_taper);
        let bent = |(_, circle): &(f64, Circle)| {
            1.0 / circle.on_curve.curvature.norm() - circle.meridian.radius
        };
        let outside = self.samples.iter().map(bent).fold(f64::INFINITY, f64::min);
        inside.min(outside).min(0.5 * self.self_distance())
    }

    /// Smallest distance between parts of the tube past which it comes back to itself; infinite if
    /// it does not.
    ///
    /// It is that of the straight segments between samples, which parts that cross each other may
    /// have between them.
    fn self_distance(&self) -> f64 {
        let balls = self.balls();
        let next = |k: usize| balls[(k + 1).min(balls.len() - 1)];
        let mut smallest = f64::INFINITY;
        for (number, (x, own)) in balls.iter().enumerate() {
            let (mut before, mut rising) = (0.0, true);
            for (k, (y, other)) in balls.iter().enumerate().skip(number + 1) {
                let distance = (x - y).norm();
                rising &= distance >= before;
                before = distance;
                // Segments are closer than their starts by their lengths at most.
                if rising || distance - own - other - 2.0 * self.spacing >= smallest {
                    continue;
                }
                let ends = [next(number), next(k)];
                let between = segment_distance([*x, ends[0].0], [*y, ends[1].0]);
                smallest = smallest.min(between - own.max(ends[0].1) - other.max(ends[1].1));
            }
        }
        smallest
    }

    /// The cross-section with the point of the surface closest to `x`.
    fn closest(&self, x: &Vec3) -> Circle {
        let last = self.samples.len() - 1;
        let squares = self.samples.iter().map(|(_, c)| c.squared_distance(x));
        let distances: Vec<f64> = squares.collect();
        let lowest = distances.iter().copied().fold(f64::INFINITY, f64::min);
        // Between neighbours the distance changes by at most that of their circles.
        let limit = (lowest.sqrt() + self.spacing).powi(2);
        let (mut best, mut closest) = (f64::INFINITY, self.samples[0].1);
        for (k, &here) in distances.iter().enumerate() {
            let before = if k > 0 { distances[k - 1] } else { here };
            let after = if k < last { distances[k + 1] } else { here };
            if here <= before && here <= after && here <= limit {
                let low = self.samples[k.saturating_sub(1)];
                let high = self.samples[(k + 1).min(last)];
                let circle = self.root(x, low, high);
                let squared = circle.squared_distance(x);
                if squared < best {
                    (best, closest) = (squared, circle);
                }
            }
        }
        closest
    }

    /// The circle in an interval at which the distance from `x` is stationary, or its nearer end.
    ///
    /// False position with halved weights of an end that stays (Illinois), and bisection where this
    /// does not divide the interval.
    fn root(&self, x: &Vec3, low: (f64, Circle), high: (f64, Circle)) -> Circle {
        let (mut low, mut high) = (
            (low.0, low.1.slope(x), low.1),
            (high.0, high.1.slope(x), high.1),
        );
        if low.1 >= 0.0 {
            return low.2;
        }
        if high.1 <= 0.0 {
            return high.2;
        }
        let mut side = 0;
        let (mut before, mut found) = (low.0, low.2);
        for step in 0..MAX_STEPS {
            let secant = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
            let is_between = secant > low.0 && secant < high.0 && step % 8 != 7;
            let at = match is_between {
                true => secant,
                false => 0.5 * (low.0 + high.0),
            };
            found = self.circle(at);
            let slope = found.slope(x);
            let change = (at - before).abs();
            before = at;
            if slope == 0.0 || change <= 8.0 * f64::EPSILON * (1.0 + high.0) {
                break;
            }
            if slope > 0.0 {
                high = (at, slope, found);
                if side == 1 {
                    low.1 *= 0.5;
                }
                side = 1;
            } else {
                low = (at, slope, found);
                if side == -1 {
                    high.1 *= 0.5;
                }
                side = -1;
            }
        }
        found
    }

    /// The curve.
    pub fn curve(&self) -> &C {
        &self.curve
    }

    /// Coordinates of the point of the surface that is closest to `x`.
    pub fn coordinates(&self, x: &Vec3) -> TubePoint {
        let circle = self.closest(x);
        let (_, _, direction) = circle.coordinates(x);
        let [_, one, other] = &circle.on_curve.axes;
        let radius = circle.meridian.radius;
        TubePoint {
            arc: circle.meridian.arc,
            across: [radius * direction.dot(one), radius * direction.dot(other)],
        }
    }

    /// The point with these coordinates.
    pub fn point(&self, coordinates: &TubePoint) -> Vec3 {
        let CurvePoint { point, axes, .. } = self.curve.extended(coordinates.arc);
        point + coordinates.across[0] * axes[1] + coordinates.across[1] * axes[2]
    }

    /// The point of the surface farthest along a unit vector.
    pub fn support_point(&self, n: &Vec3) -> Vec3 {
        let distance = |circle: &Circle| {
            let along = circle.on_curve.axes[0].dot(n);
            let across = (1.0 - along * along).max(0.0).sqrt();
            circle.on_curve.point.dot(n) + circle.meridian.radius * across
        };
        let mut best = (f64::NEG_INFINITY, 0);
        for (k, (_, circle)) in self.samples.iter().enumerate() {
            let found = distance(circle);
            if found > best.0 {
                best = (found, k);
            }
        }
        // The distance has one maximum between the neighbours: thirds of the interval.
        let mut low = self.samples[best.1.saturating_sub(1)].0;
        let mut high = self.samples[(best.1 + 1).min(self.samples.len() - 1)].0;
        for _ in 0..MAX_STEPS {
            // The distance is off by the square of the width only.
            if high - low < ROOT_OF_ROUNDING {
                break;
            }
            let third = (high - low) / 3.0;
            let [one, two] = [low + third, high - third];
            match distance(&self.circle(one)) < distance(&self.circle(two)) {
                true => low = one,
                false => high = two,
            }
        }
        let circle = self.circle(0.5 * (low + high));
        let [tangent, across, _] = circle.on_curve.axes;
        let direction = (n - n.dot(&tangent) * tangent).try_normalize(0.0);
        circle.on_curve.point + circle.meridian.radius * direction.unwrap_or(across)
    }

    /// Largest distance of the surface from the line through the origin along a unit vector, or
    /// slightly more.
    pub fn distance_from_axis(&self, n: &Vec3) -> f64 {
        let distance = |(_, circle): &(f64, Circle)| {
            let point = circle.on_curve.point;
            (point - point.dot(n) * n).norm() + circle.meridian.radius
        };
        // Between samples the curve turns by at most 1 / SAMPLES_PER_RADIAN.
        let between = 0.125 * self.spacing / SAMPLES_PER_RADIAN;
        // The equators of the balls at the ends are between samples.
        let of_ends = self.profile.end_balls().map(|(arc, radius)| {
            let point = self.curve.extended(arc).point;
            (point - point.dot(n) * n).norm() + radius
        });
        let of_samples = self.samples.iter().map(distance);
        of_samples.chain(of_ends).fold(0.0, f64::max) + between
    }

    /// Balls about points of the centreline between its ends, and the head.
    pub fn balls(&self) -> Vec<(Vec3, f64)> {
        let (arc, radius) = self.profile.end_balls()[0];
        let mut balls = vec![(self.curve.extended(arc).point, radius)];
        let inner = self.samples.iter().filter(|(_, circle)| {
            let arc = circle.meridian.arc;
            arc >= 0.0 && arc <= self.profile.length()
        });
        balls.extend(inner.map(|(_, circle)| (circle.on_curve.point, circle.meridian.radius)));
        balls
    }
}

/// Distance between two straight segments, by their ends.
fn segment_distance(one: [Vec3; 2], other: [Vec3; 2]) -> f64 {
    let (along, across, between) = (one[1] - one[0], other[1] - other[0], one[0] - other[0]);
    let [aa, bb, ab] = [along.dot(&along), across.dot(&across), along.dot(&across)];
    let share = |over: f64, under: f64| match under > 0.0 {
        true => (over / under).clamp(0.0, 1.0),
        false => 0.0,
    };
    let (from_one, from_other) = (along.dot(&between), across.dot(&between));
    // The closest points of the lines; each is then moved into its segment, the other one follows.
    let s = share(ab * from_other - bb * from_one, aa * bb - ab * ab);
    let t = share(ab * s + from_other, bb);
    let s = share(ab * t - from_one, aa);
    (between + s * along - t * across).norm()
}

impl<C: Centreline> Surface for BentTube<C> {
    fn signed_distance(&self, point: Vec3) -> f64 {
        let circle = self.closest(&point);
        let arm = point - circle.foot(&point);
        let outwards = arm.dot(&circle.normal(&point));
        arm.norm().copysign(outwards)
    }

    fn closest_point(&self, point: Vec3) -> Vec3 {
        self.closest(&point).foot(&point)
    }

    fn normal(&self, point: Vec3) -> Vec3 {
        self.closest(&point).normal(&point)
    }

    fn bounding_ball(&self) -> (Vec3, f64) {
        self.ball
    }

    fn volume(&self) -> f64 {
        self.profile.volume_and_moment()[0]
    }

    fn is_convex(&self) -> bool {
        false
    }

    fn reach(&self) -> f64 {
        *self.reach.get_or_init(|| self.smallest_ball())
    }

    fn inradius(&self) -> f64 {
        let [front, end] = self.profile.end_balls();
        front.1.max(end.1)
    }

    fn triangulation(&self) -> Option<SurfaceMesh> {
        let radius = self.profile.radii[0].min(self.profile.radii[1]);
        // At least eight circles per turn of the curve.
        let along = intervals(
            self.profile.length(),
            radius,
            (1.3 * self.curve.parts()).ceil() as usize,
        );
        let mut parameters = Vec::new();
        for (number, piece) in self.profile.pieces.iter().enumerate() {
            let count = match piece {
                Piece::Arc { angles, .. } => {
                    ((angles[1] - angles[0]).abs() / FRAC_PI_4).ceil().max(1.0) as usize
                }
                Piece::Along { .. } => along,
            };
            parameters.extend((0..count).map(|k| number as f64 + k as f64 / count as f64));
        }
        let last = self.profile.pieces.len() as f64;
        let pole = |parameter: f64| self.circle(parameter).on_curve.point;
        let section = |parameter: f64| {
            let circle = self.circle(parameter);
            let [_, one, other] = circle.on_curve.axes;
            let section = Section {
                centre: circle.on_curve.point,
                across: [one, other],
            };
            (section, circle.meridian.radius)
        };
        // The first parameter is that of a pole.
        let sections: Vec<_> = parameters.into_iter().skip(1).map(section).collect();
        Some(circles_with_poles([pole(0.0), pole(last)], &sections))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    /// An arc of a circle in the plane z = 0, from the origin along x.
    #[derive(Clone, Debug)]
    struct Bow {
        length: f64,
        curvature: f64,
    }

    impl Centreline for Bow {
        fn length(&self) -> f64 {
            self.length
        }

        fn parts(&self) -> f64 {
            self.length * self.curvature
        }

        fn at(&self, arc: f64) -> CurvePoint {
            let k = self.curvature;
            let (sin, cos) = (k * arc).sin_cos();
            let normal = Vec3::new(-sin, cos, 0.0);
            CurvePoint {
                point: Vec3::new(sin / k, (1.0 - cos) / k, 0.0),
                axes: [Vec3::new(cos, sin, 0.0), normal, Vec3::z()],
                curvature: k * normal,
            }
        }
    }

    /// A line along x, three quarters of a circle and a line across the first one above it.
    #[derive(Clone, Debug)]
    struct Loop {
        line: f64,
        radius: f64,
        slope: f64,
    }

    impl Loop {
        /// Length over that of its projection.
        fn stretch(&self) -> f64 {
            self.slope.hypot(1.0)
        }
    }

    impl Centreline for Loop {
        fn length(&self) -> f64 {
            (2.0 * self.line + 1.5 * PI * self.radius) * self.stretch()
        }

        fn parts(&self) -> f64 {
            1.5 * PI
        }

        fn at(&self, arc: f64) -> CurvePoint {
            let along = arc / self.stretch() - self.line;
            let on_circle = along.clamp(0.0, 1.5 * PI * self.radius);
            let rest = along - on_circle;
            let (sin, cos) = (on_circle / self.radius).sin_cos();
            let curvature = match rest == 0.0 {
                true => 1.0 / (self.radius * self.stretch().powi(2)),
                false => 0.0,
            };
            let normal = Vec3::new(-sin, cos, 0.0);
            let tangent = Vec3::new(cos, sin, self.slope) / self.stretch();
            let circle = self.radius * Vec3::new(sin, 1.0 - cos, 0.0);
            CurvePoint {
                point: circle + rest * Vec3::new(cos, sin, 0.0) + along * self.slope * Vec3::z(),
                axes: [tangent, normal, tangent.cross(&normal)],
                curvature: curvature * normal,
            }
        }
    }

    /// The distance of samples was taken for that between them: parts that cross at right angles
    /// touched each other, and had a reach of a sixteenth of the radius.
    #[test]
    fn bug_parts_that_cross_were_farther_than_they_are() {
        let radius = 5.0_f64;
        for gap in [0.05_f64, -0.05] {
            for line in [8.0, 8.23, 8.41, 8.67] {
                // Two lines of slope c that cross at this height are (1 + 2 c²)^(-1/2) of it apart.
                let way = radius * (2.0 + 1.5 * PI);
                let slope = (2.0 + gap) / (way.powi(2) - 2.0 * (2.0 + gap).powi(2)).sqrt();
                let curve = Loop {
                    line,
                    radius,
                    slope,
                };
                let profile = TubeProfile::new(curve.length(), [1.0; 2], None);
                let reach = BentTube::new(curve, profile).reach();
                assert!((reach - 0.5 * gap).abs() < 1e-9, "{line}: {reach} {gap}");
            }
        }
    }

    fn bow(curvature: f64, radii: [f64; 2], head: Option<f64>) -> BentTube<Bow> {
        let length = 8.0;
        BentTube::new(
            Bow { length, curvature },
            TubeProfile::new(length, radii, head),
        )
    }

    #[test]
    fn tubes_pass_the_checks_of_surfaces() {
        for curvature in [1e-3, 0.2, 0.5] {
            for (radii, head) in [
                ([0.4, 0.4], None),
                ([0.5, 0.2], None),
                ([0.3, 0.3], Some(1.0)),
                ([0.4, 0.2], Some(0.8)),
            ] {
                let tube = bow(curvature, radii, head);
                assert!(tube.reach() > 0.0);
                mesh::check_surface(&tube).unwrap_or_else(|error| {
                    panic!("{curvature}, {radii:?}, {head:?}: {error}");
                });
            }
        }
    }

    /// The volume inside a fine triangulation, by the divergence theorem.
    #[test]
    fn the_volume_is_that_inside_the_surface() {
        for (radii, head) in [([0.4, 0.4], None), ([0.4, 0.2], Some(0.8))] {
            let tube = bow(0.4, radii, head);
            let mesh = tube.triangulation().expect("a triangulation");
            let corners = |triangle: &[u32; 3]| triangle.map(|v| mesh.points[v as usize]);
            let mut triangles: Vec<[Vec3; 3]> = mesh.triangles.iter().map(corners).collect();
            for _ in 0..4 {
                let quarters = |[a, b, c]: [Vec3; 3]| {
                    let middle = |x: Vec3, y: Vec3| tube.closest_point((x + y) * 0.5);
                    let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
                    [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
                };
                triangles = triangles.into_iter().flat_map(quarters).collect();
            }
            let part = |[a, b, c]: &[Vec3; 3]| a.dot(&b.cross(c)) / 6.0;
            let volume: f64 = triangles.iter().map(part).sum();
            // 128 facets around the tube lose (2π / 128)² / 6 of its volume, 4e-4, everywhere.
            assert!((volume / tube.volume() - 1.0).abs() < 1e-3);
        }
    }

    /// A tube of a constant radius is that of a capsule: `π a² L + 4/3 π a³`.
    #[test]
    fn straight_tubes_have_the_moments_of_capsules_and_cones() {
        let [volume, moment] = TubeProfile::new(8.0, [0.5, 0.5], None).volume_and_moment();
        let expected = PI * 0.25 * (8.0 + 4.0 / 3.0 * 0.5);
        assert!((volume / expected - 1.0).abs() < 1e-14);
        assert!((moment / volume - 4.0).abs() < 1e-14);
    }

    /// A ring that closes up to a gap of one radius; a tube bent beyond its radius.
    #[test]
    fn the_reach_is_half_the_gap_and_what_bending_leaves() {
        // The ends of an arc of 5 radians about a circle of radius 1.6 are 2 · 1.6 sin(2.5) apart.
        let ring = bow(5.0 / 8.0, [0.2, 0.2], None);
        let gap = 3.2 * 2.5_f64.sin() - 0.4;
        assert!(ring.reach() <= 0.5 * gap + 1e-12 || ring.reach() == 0.2);
        assert!(bow(0.5, [1.5, 1.5], None).reach() <= 0.5 + 1e-12);
        assert!(bow(0.7, [1.5, 1.5], None).reach() < 0.0);
        // The tube has come round and covers its start.
        assert!(bow(0.8, [0.2, 0.2], None).reach() < 0.0);
    }

    /// The head of a straight tube is the widest about its axis; about a line across it the end of
    /// the head is, or that of the tube. It was left out between two samples.
    #[test]
    fn the_distance_from_an_axis_contains_the_head() {
        let (head, radius) = (1.0, 0.3);
        let tube = bow(1e-9, [radius, radius], Some(head));
        let centre = ((head + radius) * (head + radius) - 4.0 * radius * radius).sqrt();
        for (n, exact) in [
            (Vec3::x(), head),
            (Vec3::y(), (centre + head).max(8.0 + radius)),
        ] {
            let found = tube.distance_from_axis(&n);
            assert!(found >= exact - 1e-9, "{found} of {exact}");
            // The ball about each circle exceeds that about the end by (√2 - 1) radii at most.
            assert!(found < exact + 0.5 * radius, "{found} of {exact}");
        }
        // All points of a bent one, by their support points along directions across the line.
        let bent = bow(0.4, [radius, radius], Some(head));
        let farthest = (0..360).map(|k| {
            let (sin, cos) = (PI * f64::from(k) / 180.0).sin_cos();
            let across = Vec3::new(0.0, cos, sin);
            bent.support_point(&across).dot(&across)
        });
        let farthest = farthest.fold(0.0, f64::max);
        let found = bent.distance_from_axis(&Vec3::x());
        assert!(found >= farthest - 1e-9 && found < farthest + 0.5 * radius);
    }

    /// Points keep their coordinates while the curve bends.
    #[test]
    fn coordinates_are_those_of_the_point() {
        let [straight, bent] = [1e-9, 0.4].map(|k| bow(k, [0.4, 0.2], Some(0.8)));
        for arc in [-1.6, -0.5, 0.0, 3.0, 7.9, 8.1] {
            let at = TubePoint {
                arc,
                across: [0.3, -0.2],
            };
            let foot = straight.coordinates(&straight.point(&at));
            let again = bent.coordinates(&bent.point(&foot));
            assert!((again.arc - foot.arc).abs() < 1e-9);
            assert!((again.across[0] - foot.across[0]).abs() < 1e-9);
        }
    }
}
