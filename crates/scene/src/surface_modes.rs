//! Modes of the surface of a sphere, and the points that move along it.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix2, Matrix3x2, Unit, UnitQuaternion, Vector2, Vector3};

use crate::harmonics::Harmonic;
use crate::positive_directions::{Sign, sign};
use crate::radial_profile::{bound, second_derivatives};
use crate::words::ModeMotion;

/// Modes of a sphere: spherical harmonics about an axis.
///
/// With the radius `R` and the harmonics `Y` of the undeformed directions `n`
/// ([`Harmonic`]; Legendre polynomials where the order is zero), material points are at
///
/// ```text
/// radial      R (1 + Σ a Y) n
/// isochoric   R (1 + 3 Σ a Y)^(1/3) n, which keeps the volume
/// tangential  R at the angle θ + Σ a sin(n θ) from the axis, for orders of zero
/// gradient    R (cos |v| n + sin |v| v / |v|), v = Σ a ∇Y with the gradient along the sphere
/// curl        the same with v = Σ a n × ∇Y, of which the degree one turns the sphere for small a
/// ```
///
/// Those of a spheroid are these points of the sphere with the radius of its equator, stretched
/// along the axis to its length.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct SurfaceModes {
    /// How material points move.
    pub motion: ModeMotion,
    /// Axis in the initial configuration, a unit vector.
    pub axis: Vector3<f64>,
    /// Direction from which azimuths are counted, a unit vector across the axis.
    pub meridian: Vector3<f64>,
    /// The harmonics, each with the number of the joint whose value is its amplitude.
    pub coordinates: Vec<(Harmonic, usize)>,
}

/// Steps of Newton's method for a material point, more than it needs.
const MAX_STEPS: usize = 50;

/// Smallest length of the tangent of a step that is compared with the one before; below it
/// Newton's method converges to rounding.
const SURE_STEP: f64 = 1e-4;

/// Value of a joint; not a number for one that does not exist.
pub(crate) fn value(values: &[f64], joint: usize) -> f64 {
    values.get(joint).copied().unwrap_or(f64::NAN)
}

/// Two unit vectors that are perpendicular to a unit vector and to each other; one of them along a
/// coordinate axis if the vector has no part along it.
pub(crate) fn tangents(n: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let axis = n.iamin();
    let one = (Vector3::ith(axis, 1.0) - n[axis] * n).normalize();
    [one, n.cross(&one)]
}

/// The direction after a step along the tangents.
pub(crate) fn stepped(
    n: &Vector3<f64>,
    [one, other]: &[Vector3<f64>; 2],
    step: &Vector2<f64>,
) -> Vector3<f64> {
    (n + step.x * one + step.y * other).normalize()
}

impl SurfaceModes {
    /// Whether the deformation is symmetric about the axis, without swirl.
    pub fn is_zonal(&self) -> bool {
        self.motion != ModeMotion::Curl && self.turns_about_axis()
    }

    /// Whether the deformation is the same after rotations about the axis.
    fn turns_about_axis(&self) -> bool {
        let mut orders = self.coordinates.iter().map(|(harmonic, _)| harmonic.order);
        orders.all(|order| order == 0)
    }

    /// Whether points move along the sphere only.
    pub(crate) fn is_tangential(&self) -> bool {
        match self.motion {
            ModeMotion::Radial | ModeMotion::Isochoric => false,
            ModeMotion::Tangential | ModeMotion::Gradient | ModeMotion::Curl => true,
        }
    }

    /// Meridian, the direction across it, and axis.
    fn frame(&self) -> [Vector3<f64>; 3] {
        [self.meridian, self.axis.cross(&self.meridian), self.axis]
    }

    /// Coordinates of a vector along the meridian, across it, and along the axis.
    pub(crate) fn local(&self, x: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from(self.frame().map(|of| of.dot(x)))
    }

    /// The vector with such coordinates.
    pub(crate) fn global(&self, x: &Vector3<f64>) -> Vector3<f64> {
        let [a, b, c] = self.frame();
        x.x * a + x.y * b + x.z * c
    }

    /// Whether the plane through the centre normal to a coordinate axis is a symmetry plane,
    /// whatever the amplitudes.
    pub(crate) fn keeps_plane(&self, axis: usize) -> bool {
        if self.is_zonal() && self.axis[axis] == 0.0 {
            return true;
        }
        let is_normal = |n: &Vector3<f64>| (0..3).all(|other| other == axis || n[other] == 0.0);
        let Some(own) = self.frame().iter().position(is_normal) else {
            return false;
        };
        // A curl is mirrored to its opposite.
        let mut harmonics = self.coordinates.iter().map(|(harmonic, _)| harmonic);
        match self.motion {
            ModeMotion::Curl => harmonics.all(|harmonic| harmonic.is_odd(own)),
            ModeMotion::Tangential => false,
            _ => harmonics.all(|harmonic| !harmonic.is_odd(own)),
        }
    }

    /// The harmonics with their amplitudes.
    pub(crate) fn terms(&self, values: &[f64]) -> Vec<(Harmonic, f64)> {
        let term = |&(harmonic, joint): &(Harmonic, usize)| (harmonic, value(values, joint));
        self.coordinates.iter().map(term).collect()
    }

    /// The harmonics with the largest sizes of their amplitudes, and with their changes, where
    /// the values of joints change by at most `changes`.
    pub(crate) fn largest_terms(
        &self,
        values: &[f64],
        changes: &dyn Fn(usize) -> f64,
    ) -> [Vec<(Harmonic, f64)>; 2] {
        let own = self.coordinates.iter();
        let both = own.map(|&(harmonic, joint)| (harmonic, value(values, joint), changes(joint)));
        let both: Vec<_> = both.collect();
        let sizes = both.iter().map(|(of, a, change)| (*of, a.abs() + change));
        let changes = both.iter().map(|(of, _, change)| (*of, *change));
        [sizes.collect(), changes.collect()]
    }

    /// Whether material points that move along the sphere do not fold it, also at values that
    /// differ from these by at most the changes: the sign of the factor `f` by which areas change.
    ///
    /// A map of the sphere to itself that folds nowhere is one to one. With the angle `r = |v|` and
    /// the derivative `A` of `v` along the sphere
    ///
    /// ```text
    /// f = cos r + s(r) (tr A + det A) + c(r) v·Av,   s = sin r / r,   c = s' / r
    /// ```
    ///
    /// (Jacobi's equation on a sphere). Along a great circle, `v` and `A` have components that are
    /// trigonometric polynomials of the degree of a harmonic, so that derivatives are at most that
    /// degree times as large (Bernstein). `s` and `-3 c` are the characteristic functions of the
    /// unit sphere and the unit ball, so that their second derivatives are at most 1/3 and 1/5.
    /// Tangential modes have `f = dΘ/dθ`.
    pub(crate) fn fold(&self, values: &[f64], changes: &dyn Fn(usize) -> f64) -> Sign {
        let terms = self.terms(values);
        let [sizes, changes] = self.largest_terms(values, changes);
        if sizes.iter().any(|(_, size)| !size.is_finite()) {
            return Sign::NotAt(self.axis);
        }
        if self.motion == ModeMotion::Tangential {
            let sum = |terms: &[(Harmonic, f64)], power: i32| -> f64 {
                let own = terms.iter();
                own.map(|(of, a)| (of.degree as f64).powi(power) * a.abs())
                    .sum()
            };
            let stretch = |n: &Vector3<f64>| self.turned(n.x.atan2(n.z), values).1;
            let found = sign(true, &stretch, sum(&terms, 3), sum(&changes, 1));
            return found.map(|n| self.global(&n));
        }
        let largest = self.flow_bounds(&sizes);
        // The stretch of lengths is at least cos |v| - |A|.
        if largest.flow[0] < FRAC_PI_2 && largest.derivative[0] < largest.flow[0].cos() {
            return Sign::Within;
        }
        let change = largest.area_change(&self.flow_bounds(&changes));
        let bend = self.flow_bounds(&terms).area_bend();
        let stretch = |n: &Vector3<f64>| {
            let (x, tangents) = (moved(&self.flow(n, &terms)), tangents(n));
            let [a, b] = tangents.map(|t| moved_rate(&self.flow_rate(n, &t, &terms)));
            x.dot(&a.cross(&b))
        };
        sign(self.turns_about_axis(), &stretch, bend, change).map(|n| self.global(&n))
    }

    /// Bounds of the flow of terms.
    fn flow_bounds(&self, terms: &[(Harmonic, f64)]) -> FlowBounds {
        // Among the harmonics of a degree with L = n (n + 1) and the sum of squares 1, the largest
        // derivative along a great circle is (L / 2)^(1/2); the trace of A is -L Y for gradients.
        let flow = bound(terms, |n| (0.5 * n * (n + 1.0)).sqrt());
        let of_trace = match self.motion {
            ModeMotion::Curl => 0.0,
            _ => 1.0,
        };
        let powers = [0, 1, 2];
        let derivative = powers.map(|k| second_derivatives(terms, |n| n.powi(k)));
        let trace = powers.map(|k| of_trace * bound(terms, |n| n.powi(k + 1) * (n + 1.0)));
        FlowBounds {
            flow: [flow, derivative[0], derivative[1]],
            derivative,
            trace,
        }
    }

    /// Position on the unit sphere of the material point of a direction.
    pub(crate) fn surface_point(&self, n: &Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        if self.motion == ModeMotion::Tangential {
            let (angle, across) = polar(n, &self.axis);
            return at_angle(self.turned(angle, values).0, &self.axis, &across);
        }
        let own = self.local(n);
        self.global(&moved(&self.flow(&own, &self.terms(values))))
    }

    /// Derivative of [`SurfaceModes::surface_point`] with respect to the value of a joint.
    pub(crate) fn surface_velocity(
        &self,
        n: &Vector3<f64>,
        values: &[f64],
        joint: usize,
    ) -> Vector3<f64> {
        let own = self.coordinates.iter().filter(|(_, of)| *of == joint);
        if self.motion == ModeMotion::Tangential {
            let (angle, across) = polar(n, &self.axis);
            let (turned, _) = self.turned(angle, values);
            let along = at_angle(turned + FRAC_PI_2, &self.axis, &across);
            return own
                .map(|(harmonic, _)| (harmonic.degree as f64 * angle).sin() * along)
                .sum();
        }
        let n = self.local(n);
        let flow = self.flow(&n, &self.terms(values));
        let unit: Vec<_> = own.map(|(harmonic, _)| (*harmonic, 1.0)).collect();
        let rate = Rate {
            flow,
            of_direction: Vector3::zeros(),
            of_flow: self.flow(&n, &unit).flow,
        };
        self.global(&moved_rate(&rate))
    }

    /// The direction of the material point at a position on the unit sphere.
    pub(crate) fn material_direction(&self, at: &Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        if self.motion == ModeMotion::Tangential {
            let (angle, across) = polar(at, &self.axis);
            return at_angle(self.material_angle(angle, values), &self.axis, &across);
        }
        let (at, terms) = (self.local(at), self.terms(values));
        let misfit = |n: &Vector3<f64>| at - moved(&self.flow(n, &terms));
        let mut n = at;
        let mut left = misfit(&n);
        for _ in 0..MAX_STEPS {
            let tangents = tangents(&n);
            let columns = tangents.map(|t| moved_rate(&self.flow_rate(&n, &t, &terms)));
            let map = Matrix3x2::from_columns(&columns);
            let normal: Matrix2<f64> = map.tr_mul(&map);
            let Some(mut step) = normal.lu().solve(&map.tr_mul(&left)) else {
                break;
            };
            let after = |step: &Vector2<f64>| {
                let next = stepped(&n, &tangents, step);
                (next, misfit(&next))
            };
            let mut tried = after(&step);
            // The comparisons end with numbers that are none.
            while step.norm() >= SURE_STEP && tried.1.norm() >= left.norm() {
                step *= 0.5;
                tried = after(&step);
            }
            (n, left) = tried;
            if step.norm() <= 1e-14 {
                break;
            }
        }
        self.global(&n)
    }

    /// The direction `n`, in the axes of the modes, with `v`.
    fn flow(&self, n: &Vector3<f64>, terms: &[(Harmonic, f64)]) -> Flow {
        let gradient: Vector3<f64> = (terms.iter())
            .map(|(harmonic, amplitude)| *amplitude * harmonic.jet(n).1)
            .sum();
        let along = gradient - n * n.dot(&gradient);
        let flow = match self.motion {
            ModeMotion::Curl => n.cross(&along),
            _ => along,
        };
        Flow { n: *n, flow }
    }

    /// Derivative of the flow along a tangent `t` of the unit sphere.
    fn flow_rate(&self, n: &Vector3<f64>, t: &Vector3<f64>, terms: &[(Harmonic, f64)]) -> Rate {
        let (mut gradient, mut change) = (Vector3::zeros(), Vector3::zeros());
        for (harmonic, amplitude) in terms {
            let (_, first, second) = harmonic.jet(n);
            gradient += *amplitude * first;
            change += *amplitude * (second * t);
        }
        let along = gradient - n * n.dot(&gradient);
        let across = n * (t.dot(&gradient) + n.dot(&change));
        let of_along = change - t * n.dot(&gradient) - across;
        let (flow, of_flow) = match self.motion {
            ModeMotion::Curl => (n.cross(&along), t.cross(&along) + n.cross(&of_along)),
            _ => (along, of_along),
        };
        Rate {
            flow: Flow { n: *n, flow },
            of_direction: *t,
            of_flow,
        }
    }

    /// Angle to which tangential modes move the angle `θ`, and its derivative.
    fn turned(&self, angle: f64, values: &[f64]) -> (f64, f64) {
        let mut turned = (angle, 1.0);
        for &(harmonic, joint) in &self.coordinates {
            let (amplitude, n) = (value(values, joint), harmonic.degree as f64);
            turned.0 += amplitude * (n * angle).sin();
            turned.1 += amplitude * n * (n * angle).cos();
        }
        turned
    }

    /// The angle that tangential modes move to `turned`: Newton's method within an interval.
    fn material_angle(&self, turned: f64, values: &[f64]) -> f64 {
        let (mut low, mut high) = (0.0, PI);
        let mut angle = turned;
        for _ in 0..MAX_STEPS {
            let (at, slope) = self.turned(angle, values);
            let misfit = at - turned;
            match misfit > 0.0 {
                true => high = angle,
                false => low = angle,
            }
            let next = angle - misfit / slope;
            let next = match next > low && next < high {
                true => next,
                false => 0.5 * (low + high),
            };
            if (next - angle).abs() <= 1e-15 {
                return next;
            }
            angle = next;
        }
        angle
    }
}

/// Bounds of the sizes of the flow `v`, of its derivative `A` and of the trace of it, each with
/// those of their first and second derivatives along great circles.
struct FlowBounds {
    flow: [f64; 3],
    derivative: [f64; 3],
    trace: [f64; 3],
}

impl FlowBounds {
    /// Bound of the change of the factor of areas where `v`, `A` and its trace change by at most
    /// these.
    fn area_change(&self, changes: &Self) -> f64 {
        let [r, s, t] = [self.flow[0], self.derivative[0], self.trace[0]];
        let [of_r, of_s, of_t] = [changes.flow[0], changes.derivative[0], changes.trace[0]];
        r * of_r * (1.0 + (t + s * s) / 3.0 + r * r * s / 15.0)
            + of_t
            + 2.0 * s * of_s
            + (2.0 * r * s * of_r + r * r * of_s) / 3.0
    }

    /// Bound of the second derivatives of the factor of areas along great circles, by the rules of
    /// products and chains.
    fn area_bend(&self) -> f64 {
        let Self {
            flow: [v, v1, v2],
            derivative: [a, a1, a2],
            trace: [t, t1, t2],
        } = *self;
        // Of a function of v whose second derivatives are at most one and that is stationary at
        // v = 0.
        let [first, second] = [v * v1, v1 * v1 + v * v2];
        let [of_det, of_det_1, of_det_2] = [a * a, 2.0 * a * a1, 2.0 * a * a2 + 2.0 * a1 * a1];
        let product = v * v * a;
        let product_1 = 2.0 * v * a * v1 + v * v * a1;
        let product_2 = 2.0 * a * v1 * v1 + 2.0 * v * a * v2 + 4.0 * v * v1 * a1 + v * v * a2;
        second
            + (second * (t + of_det) + 2.0 * first * (t1 + of_det_1)) / 3.0
            + t2
            + of_det_2
            + (second * product + 2.0 * first * product_1) / 15.0
            + product_2 / 3.0
    }
}

/// A point of the unit sphere and a tangent there.
struct Flow {
    n: Vector3<f64>,
    flow: Vector3<f64>,
}

/// A [`Flow`] with a derivative of both.
struct Rate {
    flow: Flow,
    of_direction: Vector3<f64>,
    of_flow: Vector3<f64>,
}

/// The end of the great circle from `n` with the length and direction of the flow.
fn moved(Flow { n, flow }: &Flow) -> Vector3<f64> {
    let (cosine, [sinc, _]) = (flow.norm().cos(), sincs(flow.norm()));
    (cosine * n + sinc * flow).normalize()
}

/// The derivative of [`moved`].
fn moved_rate(rate: &Rate) -> Vector3<f64> {
    let Flow { n, flow } = &rate.flow;
    let (cosine, [sinc, slope]) = (flow.norm().cos(), sincs(flow.norm()));
    let change = flow.dot(&rate.of_flow);
    cosine * rate.of_direction - sinc * change * n + sinc * rate.of_flow + slope * change * flow
}

/// `sin(s) / s` and the derivative of it over `s`.
fn sincs(s: f64) -> [f64; 2] {
    let square = s * s;
    // The next terms are below rounding.
    if s < 0.03 {
        let sinc = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0));
        return [sinc, -1.0 / 3.0 + square / 30.0 * (1.0 - square / 28.0)];
    }
    [s.sin() / s, (s.cos() - s.sin() / s) / square]
}

/// Angle between a unit vector and the axis, and the unit vector across the axis in their plane.
fn polar(n: &Vector3<f64>, axis: &Vector3<f64>) -> (f64, Vector3<f64>) {
    let along = n.dot(axis);
    let across = n - along * axis;
    let direction = across
        .try_normalize(0.0)
        .unwrap_or_else(|| any_normal(axis));
    (across.norm().atan2(along), direction)
}

/// The unit vector at an angle from the axis, in the plane of the axis and `across`.
fn at_angle(angle: f64, axis: &Vector3<f64>, across: &Vector3<f64>) -> Vector3<f64> {
    angle.cos() * axis + angle.sin() * across
}

/// A unit vector perpendicular to an axis.
pub(crate) fn any_normal(axis: &Vector3<f64>) -> Vector3<f64> {
    let turn =
        UnitQuaternion::rotation_between_axis(&Vector3::x_axis(), &Unit::new_unchecked(*axis));
    // Opposite axes have the same normals.
    turn.unwrap_or_else(UnitQuaternion::identity) * Vector3::y()
}
