//! Spheres and spheroids that deform, by their size and by modes, and the material points that they
//! move.

use std::f64::consts::PI;
use std::sync::LazyLock;

use nalgebra::{Unit, UnitQuaternion, Vector3};

use crate::words::ModeMotion;

/// Highest degree of a mode.
pub const MAX_MODE_DEGREE: usize = 12;

/// Deformation of a sphere or a spheroid about its centre, by shape coordinates.
///
/// The centre stays the origin of the body: the material point that was in the direction `n` is at
/// `x_c + Q S X(n; a)` with the rotation `Q` of the body, so that its velocity is
/// `U + ω × (x - x_c) + Q S Σ (∂X/∂a) da/dt`. Here `X` is a point of a sphere that deforms, and `S`
/// the stretch `1 + e k k` along the axis `k` that makes a spheroid of it, constant in time.
/// Coordinates are numbers of joints of the scene, whose values are the amplitudes `a`.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct SphereDeformation {
    /// Radius of the undeformed sphere, or of the equator of the spheroid.
    pub radius: f64,
    /// `e`: length of the spheroid along the axis of its modes over its length across, minus one;
    /// zero for a sphere.
    pub elongation: f64,
    /// The coordinate that determines the radius; none if it is constant.
    pub size: Option<SizeCoordinate>,
    /// Modes of the surface; none without them.
    pub modes: Option<SurfaceModes>,
}

/// A shape coordinate that determines the radius of a sphere, by the number of its joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SizeCoordinate {
    /// The value is the radius.
    Radius(usize),
    /// The value is the volume of a sphere of the radius.
    Volume(usize),
    /// The volume is what remains of a constant one, which two spheres share.
    Remainder {
        /// The joint, whose value is the volume of the other sphere.
        joint: usize,
        /// The volume of both.
        total: f64,
    },
}

/// Modes of a sphere that are symmetric about an axis.
///
/// With the radius `R`, the angle `θ` between the axis and the direction of a material point, and
/// the Legendre polynomials `P_n`, material points are at
///
/// ```text
/// radial      R (1 + Σ a_n P_n(cos θ)) at the angle θ
/// isochoric   R (1 + 3 Σ a_n P_n(cos θ))^(1/3) at the angle θ, which keeps the volume
/// tangential  R at the angle θ + Σ a_n sin(n θ)
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
    /// Degree `n` of each mode, with the number of the joint whose value is its amplitude.
    pub coordinates: Vec<(usize, usize)>,
}

/// Radial function `R (1 + Σ a_n P_n / p)^p` of a sphere that its modes deform.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct RadialProfile {
    /// `R`.
    pub radius: f64,
    /// `p`: one, or a third for modes that keep the volume.
    pub power: f64,
    /// `a_n` for the degrees from zero to [`MAX_MODE_DEGREE`].
    pub amplitudes: [f64; MAX_MODE_DEGREE + 1],
}

/// Number of angles at which a surface is examined; between them a mode of the highest degree
/// changes by less than a thousandth of its amplitude.
const SAMPLES: usize = 1024;

/// Volume of the unit ball.
const BALL: f64 = 4.0 / 3.0 * PI;

/// Steps of Newton's method for the angle of a material point, more than it needs.
const MAX_STEPS: usize = 50;

impl SizeCoordinate {
    /// Number of the joint.
    pub fn joint(&self) -> usize {
        match *self {
            Self::Radius(joint) | Self::Volume(joint) | Self::Remainder { joint, .. } => joint,
        }
    }

    /// Whether a larger value is a larger radius.
    pub fn grows_with_value(&self) -> bool {
        !matches!(self, Self::Remainder { .. })
    }

    /// Radius at these values of the joints; not a number for a negative volume.
    pub fn radius(&self, values: &[f64]) -> f64 {
        let value = value(values, self.joint());
        match *self {
            Self::Radius(_) => value,
            Self::Volume(_) => (value / BALL).cbrt(),
            Self::Remainder { total, .. } => ((total - value) / BALL).cbrt(),
        }
    }

    /// Derivative of the radius with respect to the value.
    pub fn radius_rate(&self, values: &[f64]) -> f64 {
        let area = 4.0 * PI * self.radius(values).powi(2);
        match self {
            Self::Radius(_) => 1.0,
            Self::Volume(_) => 1.0 / area,
            Self::Remainder { .. } => -1.0 / area,
        }
    }
}

/// Value of a joint; not a number for one that does not exist.
fn value(values: &[f64], joint: usize) -> f64 {
    values.get(joint).copied().unwrap_or(f64::NAN)
}

/// Legendre polynomials `P_0 ..= P_12` at `x`.
fn legendre(x: f64) -> [f64; MAX_MODE_DEGREE + 1] {
    let mut p = [1.0; MAX_MODE_DEGREE + 1];
    p[1] = x;
    for n in 2..=MAX_MODE_DEGREE {
        let k = n as f64;
        p[n] = ((2.0 * k - 1.0) * x * p[n - 1] - (k - 1.0) * p[n - 2]) / k;
    }
    p
}

impl RadialProfile {
    /// `1 + Σ a_n P_n / p` at the cosine of an angle.
    fn base(&self, cosine: f64) -> f64 {
        let terms = self.amplitudes.iter().zip(legendre(cosine));
        1.0 + terms.map(|(a, p)| a * p).sum::<f64>() / self.power
    }

    /// Distance of the surface from the centre in the direction at the angle with this cosine.
    pub fn at(&self, cosine: f64) -> f64 {
        self.radius * self.base(cosine).powf(self.power)
    }

    /// Distance of the surface from the centre at an angle with the axis, and its first and second
    /// derivatives with respect to the angle, from its sine and cosine.
    pub(crate) fn with_derivatives(&self, (sine, cosine): (f64, f64)) -> [f64; 3] {
        // b = 1 + Σ a_n P_n / p, with P_n' = n P_(n-1) + x P_(n-1)'
        let polynomials = legendre(cosine);
        let (mut of_cosine, mut slope, mut curve) = ([0.0; 2], 0.0, 0.0);
        for (n, amplitude) in self.amplitudes.iter().enumerate().skip(1) {
            let k = n as f64;
            let [before, curve_before] = of_cosine;
            of_cosine = [
                k * polynomials[n - 1] + cosine * before,
                (k + 1.0) * before + cosine * curve_before,
            ];
            slope += amplitude * of_cosine[0] / self.power;
            curve += amplitude * of_cosine[1] / self.power;
        }
        let by_angle = [-sine * slope, sine * sine * curve - cosine * slope];
        let (base, p) = (self.base(cosine), self.power);
        let factor = self.radius * p * base.powf(p - 1.0);
        [
            self.at(cosine),
            factor * by_angle[0],
            factor * (by_angle[1] + (p - 1.0) * by_angle[0] * by_angle[0] / base),
        ]
    }

    /// Derivative of [`RadialProfile::at`] with respect to the amplitude of a degree.
    pub fn rate(&self, degree: usize, cosine: f64) -> f64 {
        let polynomial = legendre(cosine).get(degree).copied().unwrap_or(0.0);
        self.radius * self.base(cosine).powf(self.power - 1.0) * polynomial
    }

    /// Smallest value of `1 + Σ a_n P_n / p`; the surface is that of a body if it is positive.
    fn smallest_base(&self) -> f64 {
        cosines()
            .map(|x| self.base(x))
            .fold(f64::INFINITY, f64::min)
    }

    /// Largest distance of the surface from the centre, stretched along the axis by this factor.
    fn largest(&self, aspect: f64) -> f64 {
        let stretch = |x: f64| (1.0 + (aspect * aspect - 1.0) * x * x).sqrt();
        let distances = cosines().map(|x| stretch(x) * self.at(x));
        distances.fold(0.0, f64::max)
    }

    /// Volume inside the surface.
    pub fn volume(&self) -> f64 {
        // The integrand is a polynomial of degree 3 * 12 of the cosine, or linear for p = 1/3:
        // the rule is exact up to degree 39.
        let cubes = gauss_20()
            .iter()
            .map(|&(x, weight)| weight * self.at(x).powi(3));
        2.0 * PI / 3.0 * cubes.sum::<f64>()
    }
}

/// Cosines of angles from zero to pi.
fn cosines() -> impl Iterator<Item = f64> {
    (0..=SAMPLES).map(|k| (PI * k as f64 / SAMPLES as f64).cos())
}

/// The Gauss-Legendre rule of twenty points on [-1, 1].
fn gauss_20() -> &'static [(f64, f64)] {
    const POINTS: usize = 20;
    static RULE: LazyLock<Vec<(f64, f64)>> = LazyLock::new(|| (0..POINTS).map(point).collect());
    fn point(k: usize) -> (f64, f64) {
        let n = POINTS as f64;
        let mut x = ((k as f64 + 0.75) / (n + 0.5) * PI).cos();
        let polynomials = |x: f64| {
            let (mut before, mut last) = (1.0, x);
            for degree in 2..=POINTS {
                let d = degree as f64;
                let next = ((2.0 * d - 1.0) * x * last - (d - 1.0) * before) / d;
                (before, last) = (last, next);
            }
            (last, n * (before - x * last) / (1.0 - x * x))
        };
        for _ in 0..8 {
            let (value, slope) = polynomials(x);
            x -= value / slope;
        }
        let (_, slope) = polynomials(x);
        (x, 2.0 / ((1.0 - x * x) * slope * slope))
    }
    &RULE
}

impl SphereDeformation {
    /// The shape coordinates, by the numbers of their joints.
    pub fn joints(&self) -> impl Iterator<Item = usize> + '_ {
        let modes = self.modes.iter().flat_map(|modes| &modes.coordinates);
        let size = self.size.map(|size| size.joint());
        size.into_iter().chain(modes.map(|(_, joint)| *joint))
    }

    /// Whether the surface stays a sphere.
    pub fn is_sphere(&self) -> bool {
        self.elongation == 0.0 && self.keeps_surface()
    }

    /// Whether points move along the surface only, or with its size.
    fn keeps_surface(&self) -> bool {
        (self.modes.as_ref()).is_none_or(|modes| modes.motion == ModeMotion::Tangential)
    }

    /// Length of the spheroid along its axis over its length across; one for a sphere.
    pub fn aspect(&self) -> f64 {
        1.0 + self.elongation
    }

    /// A vector of the sphere, stretched to the spheroid.
    pub(crate) fn stretched(&self, x: Vector3<f64>) -> Vector3<f64> {
        along_axis(x, self.elongation, self.modes.as_ref())
    }

    /// A vector of the spheroid, shortened to the sphere.
    pub(crate) fn shortened(&self, x: Vector3<f64>) -> Vector3<f64> {
        along_axis(x, 1.0 / self.aspect() - 1.0, self.modes.as_ref())
    }

    /// Axis about which the deformation is symmetric, in the initial configuration; none if it is
    /// about every axis.
    pub fn axis(&self) -> Option<Vector3<f64>> {
        self.modes.as_ref().map(|modes| modes.axis)
    }

    /// Radius `R` at these values of all joints, that of the surface if it is a sphere.
    pub fn sphere_radius(&self, values: &[f64]) -> f64 {
        self.size.map_or(self.radius, |size| size.radius(values))
    }

    /// The radial function before the stretch to a spheroid; that of a sphere for tangential modes.
    pub fn profile(&self, values: &[f64]) -> RadialProfile {
        let mut profile = RadialProfile {
            radius: self.sphere_radius(values),
            power: 1.0,
            amplitudes: [0.0; MAX_MODE_DEGREE + 1],
        };
        if let Some(modes) = &self.modes {
            match modes.motion {
                ModeMotion::Tangential => return profile,
                ModeMotion::Radial => {}
                ModeMotion::Isochoric => profile.power = 1.0 / 3.0,
            }
            for &(degree, joint) in &modes.coordinates {
                profile.amplitudes[degree] += value(values, joint);
            }
        }
        profile
    }

    /// Radius of the smallest ball about the centre that contains the body.
    pub fn bounding_radius(&self, values: &[f64]) -> f64 {
        match self.is_sphere() {
            true => self.sphere_radius(values),
            false => self.profile(values).largest(self.aspect()),
        }
    }

    /// Upper bound of that radius where the amplitudes of the modes differ from these values by no
    /// more than `excess` in sum.
    ///
    /// The radial function changes by `R b^(p-1) P_n` per amplitude, where `b = 1 + Σ a_n P_n / p`
    /// changes by at most `excess / p`. Where `b` may vanish the bound is a hundred radii.
    pub(crate) fn bounding_radius_within(&self, values: &[f64], excess: f64) -> f64 {
        const LEAST_BASE: f64 = 1e-3;
        let profile = self.profile(values);
        let longest = profile.radius * self.aspect().max(1.0);
        let slope = match profile.power < 1.0 {
            true => (profile.smallest_base() - excess / profile.power)
                .max(LEAST_BASE)
                .powf(profile.power - 1.0),
            false => 1.0,
        };
        self.bounding_radius(values) + longest * slope * excess
    }

    /// Volume of the body.
    pub fn volume(&self, values: &[f64]) -> f64 {
        self.aspect() * self.profile(values).volume()
    }

    /// Derivative of the volume with respect to the value of a joint.
    pub fn volume_rate(&self, values: &[f64], joint: usize) -> f64 {
        if self.keeps_surface() {
            let area = 4.0 * PI * self.sphere_radius(values).powi(2);
            let size = self.size.filter(|size| size.joint() == joint);
            let rate = |size: SizeCoordinate| area * size.radius_rate(values);
            return self.aspect() * size.map_or(0.0, rate);
        }
        let profile = self.profile(values);
        let size = self.size.filter(|size| size.joint() == joint);
        // All lengths are proportional to R.
        let of_size = size.map_or(0.0, |size| {
            3.0 * profile.volume() * size.radius_rate(values) / profile.radius
        });
        let modes = self.modes.iter().flat_map(|modes| &modes.coordinates);
        let degrees = modes
            .filter(|(_, of)| *of == joint)
            .map(|(degree, _)| *degree);
        // x^2 dr is the volume per solid angle, as points move along the radius.
        let of_modes = degrees.map(|degree| {
            let rule = gauss_20().iter();
            let flux =
                rule.map(|&(x, weight)| weight * profile.at(x).powi(2) * profile.rate(degree, x));
            2.0 * PI * flux.sum::<f64>()
        });
        self.aspect() * (of_size + of_modes.sum::<f64>())
    }

    /// Whether the value of a joint changes the volume: a size, or a mode with radial motion.
    pub(crate) fn changes_volume(&self, joint: usize) -> bool {
        let of_size = self.size.is_some_and(|size| size.joint() == joint);
        let modes = self.modes.as_ref();
        of_size || modes.is_some_and(|modes| modes.motion == ModeMotion::Radial)
    }

    /// What is wrong with these values; `None` if the surface is that of a body.
    pub fn problem(&self, values: &[f64]) -> Option<String> {
        let radius = self.sphere_radius(values);
        if !(radius > 0.0 && radius.is_finite()) {
            return Some(format!("has the radius {radius}, which must be positive"));
        }
        let modes = self.modes.as_ref()?;
        let (smallest, what) = match modes.motion {
            ModeMotion::Radial | ModeMotion::Isochoric => (
                self.profile(values).smallest_base(),
                "would reach its centre",
            ),
            ModeMotion::Tangential => {
                let slope = |k: usize| modes.turned(PI * k as f64 / SAMPLES as f64, values).1;
                let smallest = (0..=SAMPLES).map(slope).fold(f64::INFINITY, f64::min);
                (smallest, "would fold")
            }
        };
        (smallest.is_nan() || smallest <= 0.0)
            .then(|| format!("has a surface that {what}; use smaller amplitudes of its modes"))
    }

    /// Position relative to the centre of the material point in the direction `n`, a unit vector,
    /// both in the axes of the initial configuration.
    pub fn point(&self, n: &Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        self.stretched(self.sphere_point(n, values))
    }

    /// Position of the material point before the stretch to a spheroid.
    fn sphere_point(&self, n: &Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        let Some(modes) = &self.modes else {
            return self.sphere_radius(values) * n;
        };
        match modes.motion {
            ModeMotion::Tangential => {
                let (angle, across) = polar(n, &modes.axis);
                let (turned, _) = modes.turned(angle, values);
                self.sphere_radius(values) * at_angle(turned, &modes.axis, &across)
            }
            _ => self.profile(values).at(n.dot(&modes.axis)) * n,
        }
    }

    /// Velocity of the material point in the direction `n` for a unit rate of one joint, relative
    /// to the motion of the body.
    pub fn velocity(&self, n: &Vector3<f64>, values: &[f64], joint: usize) -> Vector3<f64> {
        let mut velocity = Vector3::zeros();
        if let Some(size) = self.size.filter(|size| size.joint() == joint) {
            // All lengths are proportional to R.
            let point = self.sphere_point(n, values);
            velocity += point * (size.radius_rate(values) / self.sphere_radius(values));
        }
        let Some(modes) = &self.modes else {
            return velocity;
        };
        let own = modes.coordinates.iter().filter(|(_, of)| *of == joint);
        for &(degree, _) in own {
            velocity += match modes.motion {
                ModeMotion::Tangential => {
                    let (angle, across) = polar(n, &modes.axis);
                    let (turned, _) = modes.turned(angle, values);
                    let along = at_angle(turned + 0.5 * PI, &modes.axis, &across);
                    self.sphere_radius(values) * (degree as f64 * angle).sin() * along
                }
                _ => self.profile(values).rate(degree, n.dot(&modes.axis)) * n,
            };
        }
        self.stretched(velocity)
    }

    /// Direction of the material point at `x`, a position relative to the centre on or near the
    /// surface.
    pub fn material_direction(&self, x: &Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        let n = (self.shortened(*x).try_normalize(0.0)).unwrap_or_else(Vector3::x);
        match &self.modes {
            Some(modes) if modes.motion == ModeMotion::Tangential => {
                let (angle, across) = polar(&n, &modes.axis);
                at_angle(modes.material_angle(angle, values), &modes.axis, &across)
            }
            _ => n,
        }
    }
}

impl SurfaceModes {
    /// Angle to which tangential modes move the angle `θ`, and its derivative.
    fn turned(&self, angle: f64, values: &[f64]) -> (f64, f64) {
        let mut turned = (angle, 1.0);
        for &(degree, joint) in &self.coordinates {
            let (amplitude, n) = (value(values, joint), degree as f64);
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

/// A vector whose part along the axis of the modes is longer by a factor of one plus `elongation`.
fn along_axis(x: Vector3<f64>, elongation: f64, modes: Option<&SurfaceModes>) -> Vector3<f64> {
    let Some(modes) = modes.filter(|_| elongation != 0.0) else {
        return x;
    };
    x + elongation * x.dot(&modes.axis) * modes.axis
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The slope of the radial function was taken for one, which it is for spheres alone: the
    /// farthest points of a long spheroid may be where the sphere was narrowed.
    #[test]
    fn bug_long_spheroids_exceeded_the_bound_of_their_radius() {
        for (aspect, amplitude) in [(1.0, 0.1), (3.0, -0.1), (10.0, -0.15)] {
            let body = SphereDeformation {
                radius: 1.0,
                elongation: aspect - 1.0,
                size: None,
                modes: Some(SurfaceModes {
                    motion: ModeMotion::Isochoric,
                    axis: Vector3::z(),
                    coordinates: vec![(2, 0)],
                }),
            };
            let bound = body.bounding_radius_within(&[amplitude], 0.02);
            for change in [-0.02, -0.01, 0.01, 0.02] {
                let radius = body.bounding_radius(&[amplitude + change]);
                assert!(radius <= bound, "{aspect} {change}: {radius} {bound}");
            }
        }
    }
}
