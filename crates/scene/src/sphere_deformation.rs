//! Spheres and spheroids that deform, by their size and by modes, and the material points that they
//! move.

use std::f64::consts::PI;

use nalgebra::Vector3;

use crate::body_check::BodyCheck;
use crate::positive_directions::Sign;
use crate::radial_profile::RadialProfile;
use crate::surface_modes::{SurfaceModes, value};
use crate::words::ModeMotion;

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

/// Volume of the unit ball.
const BALL: f64 = 4.0 / 3.0 * PI;

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
        self.modes.as_ref().is_none_or(SurfaceModes::is_tangential)
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

    /// Axis of the modes in the initial configuration; none without modes.
    pub fn axis(&self) -> Option<Vector3<f64>> {
        self.modes.as_ref().map(|modes| modes.axis)
    }

    /// Whether the deformation is symmetric about the axis of its modes, without swirl.
    pub fn is_axisymmetric(&self) -> bool {
        self.modes.as_ref().is_none_or(SurfaceModes::is_zonal)
    }

    /// A direction in the axes of the modes.
    fn local(&self, n: &Vector3<f64>) -> Vector3<f64> {
        self.modes.as_ref().map_or(*n, |modes| modes.local(n))
    }

    /// Radius `R` at these values of all joints, that of the surface if it is a sphere.
    pub fn sphere_radius(&self, values: &[f64]) -> f64 {
        self.size.map_or(self.radius, |size| size.radius(values))
    }

    /// Rate of the logarithm of this radius; zero if it is constant.
    pub fn growth_rate(&self, values: &[f64], rates: &[f64]) -> f64 {
        self.size.map_or(0.0, |size| {
            let rate = rates.get(size.joint()).copied().unwrap_or(0.0);
            rate * size.radius_rate(values) / size.radius(values)
        })
    }

    /// The radial function before the stretch to a spheroid; that of a sphere for tangential modes.
    pub fn profile(&self, values: &[f64]) -> RadialProfile {
        let mut profile = RadialProfile::sphere(self.sphere_radius(values));
        if let Some(modes) = self.modes.as_ref().filter(|modes| !modes.is_tangential()) {
            profile.terms = modes.terms(values);
            if modes.motion == ModeMotion::Isochoric {
                profile.power = 1.0 / 3.0;
            }
        }
        profile
    }

    /// Distance of the surface before the stretch from the centre in a direction.
    pub(crate) fn distance(&self, n: &Vector3<f64>, values: &[f64]) -> f64 {
        self.profile(values).at(&self.local(n))
    }

    /// Radius of a ball about the centre that contains the body, the smallest one of modes that are
    /// symmetric about their axis.
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
    /// changes by at most `excess / p`. Where `b` may vanish the bound grows by a hundred radii
    /// times the excess.
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
        // x^2 dr is the volume per solid angle, as points move along the radius.
        let of_modes = modes.filter(|(_, of)| *of == joint).map(|(harmonic, _)| {
            profile.integral(|n| profile.at(n).powi(2) * profile.rate(*harmonic, n))
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
        self.check(values, &|_| 0.0).problem()
    }

    /// Whether the surface is that of a body, also at all values that differ from these by at most
    /// the changes.
    pub(crate) fn check(&self, values: &[f64], changes: &dyn Fn(usize) -> f64) -> BodyCheck {
        let radius = self.sphere_radius(values);
        if !(radius > 0.0 && radius.is_finite()) {
            let problem = format!("has the radius {radius}, which must be positive");
            return BodyCheck::Problem(problem);
        }
        let has_size = self.size.is_none_or(|size| {
            let joint = size.joint();
            [-1.0, 1.0].into_iter().all(|sign| {
                let mut values = values.to_vec();
                values[joint] += sign * changes(joint);
                size.radius(&values) > 0.0
            })
        });
        let sign = match &self.modes {
            None => Sign::Within,
            Some(modes) if modes.is_tangential() => modes.fold(values, changes),
            Some(modes) => {
                let [_, changes] = modes.largest_terms(values, changes);
                let sign = self.profile(values).centre_inside(&changes);
                sign.map(|at| modes.global(&at))
            }
        };
        let words = |what: &str, at: Vector3<f64>| {
            let [x, y, z]: [f64; 3] = (self.stretched(radius * at)).into();
            format!(
                "has a surface that {what} at its point [{x:.3}, {y:.3}, {z:.3}] before the \
                 deformation; use smaller amplitudes of its modes"
            )
        };
        let [would, near] = match self.keeps_surface() {
            true => ["would fold", "comes too close to a fold for a mesh"],
            false => [
                "would reach its centre",
                "comes too close to its centre for a mesh",
            ],
        };
        match sign {
            Sign::Within if has_size => BodyCheck::Within,
            Sign::Within | Sign::Here => BodyCheck::Here,
            Sign::Unproven => BodyCheck::Unproven,
            Sign::NotAt(at) => BodyCheck::Problem(words(would, at)),
            Sign::Near(at) => BodyCheck::Near(words(near, at)),
        }
    }

    /// Position relative to the centre of the material point in the direction `n`, a unit vector,
    /// both in the axes of the initial configuration.
    pub fn point(&self, n: &Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        self.stretched(self.sphere_point(n, values))
    }

    /// Position of the material point before the stretch to a spheroid.
    fn sphere_point(&self, n: &Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        match self.modes.as_ref().filter(|modes| modes.is_tangential()) {
            Some(modes) => self.sphere_radius(values) * modes.surface_point(n, values),
            None => self.distance(n, values) * n,
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
        if modes.is_tangential() {
            velocity += self.sphere_radius(values) * modes.surface_velocity(n, values, joint);
        } else {
            let (profile, at) = (self.profile(values), modes.local(n));
            let own = modes.coordinates.iter().filter(|(_, of)| *of == joint);
            let speeds = own.map(|(harmonic, _)| profile.rate(*harmonic, &at));
            velocity += speeds.sum::<f64>() * n;
        }
        self.stretched(velocity)
    }

    /// Direction of the material point at `x`, a position relative to the centre on or near the
    /// surface.
    pub fn material_direction(&self, x: &Vector3<f64>, values: &[f64]) -> Vector3<f64> {
        let n = (self.shortened(*x).try_normalize(0.0)).unwrap_or_else(Vector3::x);
        match self.modes.as_ref().filter(|modes| modes.is_tangential()) {
            Some(modes) => modes.material_direction(&n, values),
            None => n,
        }
    }
}

/// A vector whose part along the axis of the modes is longer by a factor of one plus `elongation`.
fn along_axis(x: Vector3<f64>, elongation: f64, modes: Option<&SurfaceModes>) -> Vector3<f64> {
    let Some(modes) = modes.filter(|_| elongation != 0.0) else {
        return x;
    };
    x + elongation * x.dot(&modes.axis) * modes.axis
}
#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::harmonics::Harmonic;
    use crate::surface_modes::tangents;

    /// A body of radius one with one mode.
    fn with_mode(motion: ModeMotion, degree: usize, order: i32) -> SphereDeformation {
        SphereDeformation {
            radius: 1.0,
            modes: Some(SurfaceModes {
                motion,
                axis: Vector3::z(),
                meridian: Vector3::x(),
                coordinates: vec![(Harmonic { degree, order }, 0)],
            }),
            ..SphereDeformation::default()
        }
    }

    /// Smallest value on a grid of three degrees of what must be positive: the factor of areas by
    /// differences, the slope of the angle of tangential modes, or the distance from the centre;
    /// minus infinity where there is none.
    fn smallest_on_grid(body: &SphereDeformation, values: &[f64]) -> f64 {
        const STEP: f64 = 1e-5;
        let modes = body.modes.as_ref().unwrap();
        let point = |n: Vector3<f64>| body.point(&n.normalize(), values);
        let difference = |n: Vector3<f64>, t: Vector3<f64>| {
            (point(n + STEP * t) - point(n - STEP * t)) / (2.0 * STEP)
        };
        let of_direction = |n: Vector3<f64>| match modes.motion {
            // Not a number where the base of its root is negative.
            ModeMotion::Radial | ModeMotion::Isochoric => body.profile(values).at(&n),
            ModeMotion::Tangential => {
                let along = Vector3::new(n.z, 0.0, -n.x);
                let x = point(n);
                difference(n, along).dot(&Vector3::new(x.z, 0.0, -x.x))
            }
            ModeMotion::Gradient | ModeMotion::Curl => {
                let [a, b] = tangents(&n).map(|t| difference(n, t));
                point(n).dot(&a.cross(&b))
            }
        };
        let azimuths = if modes.motion == ModeMotion::Tangential {
            1
        } else {
            120
        };
        let directions = (0..=60).flat_map(|i| {
            let (across, along) = (PI * f64::from(i) / 60.0).sin_cos();
            (0..azimuths).map(move |k| {
                let (y, x) = (PI * f64::from(k) / 60.0).sin_cos();
                Vector3::new(across * x, across * y, along)
            })
        });
        let number = |x: f64| if x.is_nan() { f64::NEG_INFINITY } else { x };
        directions
            .map(of_direction)
            .map(number)
            .fold(f64::INFINITY, f64::min)
    }

    /// The slope of the radial function was taken for one, which it is for spheres alone: the
    /// farthest points of a long spheroid may be where the sphere was narrowed.
    #[test]
    fn bug_long_spheroids_exceeded_the_bound_of_their_radius() {
        for (aspect, amplitude) in [(1.0, 0.1), (3.0, -0.1), (10.0, -0.15)] {
            let body = SphereDeformation {
                elongation: aspect - 1.0,
                ..with_mode(ModeMotion::Isochoric, 2, 0)
            };
            let bound = body.bounding_radius_within(&[amplitude], 0.02);
            for change in [-0.02, -0.01, 0.01, 0.02] {
                let radius = body.bounding_radius(&[amplitude + change]);
                assert!(radius <= bound, "{aspect} {change}: {radius} {bound}");
            }
        }
    }

    /// Samples of the surface missed the lowest place between them, where it reached the centre.
    #[test]
    fn bug_harmonics_that_reach_the_centre_between_samples_were_accepted() {
        for (motion, amplitude) in [(ModeMotion::Isochoric, 0.6), (ModeMotion::Radial, 1.8)] {
            let harmonic = Harmonic {
                degree: 12,
                order: -12,
            };
            let body = with_mode(motion, 12, -12);
            // The largest value is at the azimuth π/8 on the equator.
            let n = Vector3::new((PI / 8.0).cos(), (PI / 8.0).sin(), 0.0);
            let power = body.profile(&[0.0]).power;
            assert!(1.0 - amplitude * harmonic.at(&n).abs() / power < 0.0);
            assert!(body.problem(&[amplitude]).is_some());
            assert!(body.problem(&[0.8 * amplitude]).is_none());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

        /// What is certain for all values near some is true of those that are tried; small enough
        /// changes are certain unless not even none is, which is said.
        #[test]
        fn no_surface_folds_where_none_may(
            motion in prop_oneof![
                Just(ModeMotion::Radial), Just(ModeMotion::Isochoric), Just(ModeMotion::Tangential),
                Just(ModeMotion::Gradient), Just(ModeMotion::Curl),
            ],
            degrees in (1..=4_usize, 2..=6_usize),
            orders in (-1.0..1.0_f64, -1.0..1.0_f64),
            start in prop::array::uniform2(-1.0..1.0_f64),
            changes in prop::array::uniform2(0.0..0.3_f64),
            tried in prop::collection::vec(prop::array::uniform2(-1.0..1.0_f64), 12),
        ) {
            let order = |share: f64, degree: usize| match motion {
                ModeMotion::Tangential => 0,
                _ => (share * (degree as f64 + 0.5)) as i32,
            };
            let harmonic = |degree, share| Harmonic { degree, order: order(share, degree) };
            let both = [harmonic(degrees.0, orders.0), harmonic(degrees.1, orders.1)];
            prop_assume!(both[0] != both[1]);
            let mut body = with_mode(motion, 2, 0);
            let modes = body.modes.as_mut().unwrap();
            modes.coordinates = both.into_iter().zip(0..).collect();
            // The largest multiple of the start at which a fine grid shows the surface of a body.
            let scaled = |x: f64| start.map(|a| x * a);
            prop_assume!(start.iter().any(|a| a.abs() > 0.1));
            let (mut low, mut high) = (0.0, 64.0);
            for _ in 0..12 {
                let x = 0.5 * (low + high);
                match smallest_on_grid(&body, &scaled(x)) > 0.0 {
                    true => low = x,
                    false => high = x,
                }
            }
            prop_assert_eq!(body.problem(&scaled(0.9 * low)), None);
            prop_assert!(body.problem(&scaled(1.1 * high)).is_some());
            let values = scaled(0.7 * low);
            let found = |least: f64| body.check(&values, &|joint| least * changes[joint]);
            if found(0.0) == BodyCheck::Unproven {
                return Ok(());
            }
            let mut least = 1.0;
            while found(least) != BodyCheck::Within {
                least *= 0.5;
                prop_assert!(least > 1e-6, "{motion:?} {values:?}");
            }
            for tried in tried {
                let moved = [0, 1].map(|k| values[k] + least * tried[k] * changes[k]);
                prop_assert!(smallest_on_grid(&body, &moved) > 0.0, "{motion:?} {moved:?}");
            }
        }
    }

    /// A search without the second derivatives of the factor of areas did not end in its number of
    /// parts, and called these folds, whose smallest factors are from 0.17 to 0.78. The first,
    /// whose factor depends on the angle from the axis alone, was searched on the whole sphere.
    #[test]
    fn bug_modes_that_fold_nowhere_were_refused() {
        use ModeMotion::{Curl, Gradient};
        type Terms = &'static [(usize, i32, f64)];
        let cases: [(ModeMotion, Terms); 7] = [
            (Curl, &[(4, 0, -0.23), (2, 0, 0.285)]),
            (Curl, &[(6, 0, 0.05)]),
            (Curl, &[(8, 3, 0.03)]),
            (Curl, &[(5, 2, 0.06)]),
            (Gradient, &[(4, 2, 0.082)]),
            (Gradient, &[(6, 3, 0.041)]),
            (Gradient, &[(6, 3, 0.02), (8, 4, 0.012)]),
        ];
        for (motion, terms) in cases {
            let mut body = with_mode(motion, 2, 0);
            let harmonics = terms
                .iter()
                .map(|&(degree, order, _)| Harmonic { degree, order });
            body.modes.as_mut().unwrap().coordinates = harmonics.zip(0..).collect();
            let values: Vec<f64> = terms.iter().map(|(.., amplitude)| *amplitude).collect();
            assert!(smallest_on_grid(&body, &values) > 0.15);
            let found = body.check(&values, &|_| 0.0);
            assert_eq!(found, BodyCheck::Within, "{motion:?} {terms:?}");
        }
    }

    /// The place that is named is where the surface folds.
    #[test]
    fn folds_are_named_with_their_place() {
        // The angle θ + a sin 2θ has the slope 1 + 2 a at both poles.
        let text = with_mode(ModeMotion::Tangential, 2, 0)
            .problem(&[-0.51])
            .unwrap();
        assert!(text.contains("fold at its point [0.0"), "{text}");
        let text = with_mode(ModeMotion::Radial, 2, 0).problem(&[2.1]).unwrap();
        assert!(
            text.contains("centre at its point [1.000, 0.000, "),
            "{text}"
        );
    }

    /// A comparison with a number that is none kept the search for a material point going.
    #[test]
    fn bug_material_points_of_missing_values_were_sought_without_end() {
        let body = with_mode(ModeMotion::Gradient, 3, 2);
        let found = body.material_direction(&Vector3::x(), &[]);
        assert!(found.iter().any(|x| x.is_nan()));
    }
}
