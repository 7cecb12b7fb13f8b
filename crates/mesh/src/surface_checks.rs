//! Checks that the functions of a surface agree with each other.

use std::f64::consts::PI;

use crate::{MeshError, Surface, Vec3};

/// Number of directions from the centre in which points are sampled.
const DIRECTIONS: usize = 48;

/// Distances of the samples from the centre, relative to the radius of the bounding ball.
///
/// Those outside come first, because a wrong sign of the distance makes all else contradictory.
const DISTANCES: [f64; 5] = [1.8, 1.1, 0.9, 0.6, 0.25];

/// Largest difference of lengths that should be equal, relative to the radius of the bounding ball.
///
/// That with which meshes take a vertex to lie on its surface.
const LENGTH_TOLERANCE: f64 = 1e-6;

/// Largest length of the difference of two unit vectors that should be equal.
///
/// The direction to a closest point with an error of [`LENGTH_TOLERANCE`], from the nearest points
/// whose direction is checked.
const DIRECTION_TOLERANCE: f64 = 1e-3;

/// Halvings of the bounding cube in the check of the volume.
const OCTREE_LEVELS: u32 = 5;

/// Checks that the distances, closest points and normals of a surface agree.
///
/// For a surface of one's own, before it is meshed. At 240 points inside and around the
/// bounding ball, to `1e-6` of its radius:
///
/// - all numbers are finite, and the closest point is in the bounding ball;
/// - the signed distance is zero at the closest point, and its magnitude is the distance to it;
/// - the closest point of the closest point is itself;
/// - no closest point of another sample is closer;
/// - [`Surface::contains_ball`] has the sign and magnitude of the signed distance;
/// - the signed distance is positive outside the bounding ball;
/// - on smooth surfaces the unit normal is along the line to the closest point, to `1e-3`, and the
///   balls of the radius [`Surface::reach`] fit to both sides of the closest points;
/// - the volume is between those of the cells of an octree that are inside and of those that are
///   not outside, which bounds it to a tenth of the bounding cube.
///
/// The surface is not proved to be right: details between the samples may be wrong, and
/// [`Surface::inradius`], [`Surface::curvature_size`] and the triangulation are not checked. Cost:
/// 240 closest points and normals, and about ten thousand distances.
///
/// ```
/// use mesh::{MeshError, Surface, Vec3, check_surface};
/// /// An ellipsoid whose closest points are those along the radius.
/// struct Egg;
/// impl Surface for Egg {
///     fn signed_distance(&self, x: Vec3) -> f64 {
///         Vec3::new(x.x, x.y, 0.5 * x.z).norm() - 1.0
///     }
///     fn closest_point(&self, x: Vec3) -> Vec3 {
///         x / Vec3::new(x.x, x.y, 0.5 * x.z).norm()
///     }
///     fn bounding_ball(&self) -> (Vec3, f64) {
///         (Vec3::zeros(), 2.0)
///     }
///     fn volume(&self) -> f64 {
///         8.0 / 3.0 * std::f64::consts::PI
///     }
///     fn is_convex(&self) -> bool {
///         true
///     }
///     fn reach(&self) -> f64 {
///         0.5
///     }
/// }
/// let error = check_surface(&Egg).unwrap_err();
/// assert!(matches!(error, MeshError::InconsistentSurface { .. }), "{error}");
/// ```
///
/// # Errors
/// [`MeshError::InconsistentSurface`] with the point and the two contradictory numbers.
pub fn check_surface(surface: &dyn Surface) -> Result<(), MeshError> {
    let (centre, radius) = surface.bounding_ball();
    let scale = [
        ("radius of the bounding ball", radius),
        ("volume", surface.volume()),
    ];
    for (what, value) in scale {
        let is_positive = value > 0.0 && value.is_finite();
        let reason = "or any other positive number";
        agree(
            what,
            reason,
            centre,
            (value, 1.0),
            if is_positive { f64::INFINITY } else { -1.0 },
        )?;
    }
    let mut samples = Vec::new();
    for k in 0..DIRECTIONS {
        // A spiral with equal heights and the golden angle between neighbours.
        let height = 1.0 - (2 * k + 1) as f64 / DIRECTIONS as f64;
        let (sin, cos) = (PI * (3.0 - 5.0_f64.sqrt()) * k as f64).sin_cos();
        let across = (1.0 - height * height).sqrt();
        let direction = Vec3::new(across * cos, across * sin, height);
        for distance in DISTANCES {
            let point = centre + radius * distance * direction;
            let foot = surface.closest_point(point);
            check_sample(surface, (centre, radius), point, foot)?;
            samples.push((point, foot));
        }
    }
    for (point, foot) in &samples {
        let distance = (point - foot).norm();
        let others = samples.iter().map(|(_, other)| (point - other).norm());
        let closest = others.fold(distance, f64::min);
        agree(
            "distance to the closest point",
            "the distance to another point of the surface",
            *point,
            (distance, closest),
            LENGTH_TOLERANCE * radius,
        )?;
    }
    check_volume(surface)
}

/// Checks the volume against cubes that are surely inside and surely outside.
///
/// # Errors
/// [`MeshError::InconsistentSurface`].
fn check_volume(surface: &dyn Surface) -> Result<(), MeshError> {
    let (centre, radius) = surface.bounding_ball();
    let (mut inside, mut open) = (0.0, vec![centre]);
    let mut half = radius;
    for _ in 0..OCTREE_LEVELS {
        half *= 0.5;
        let signs = (0..8_u8).map(|corner| {
            Vec3::from_fn(|axis, _| if corner >> axis & 1 == 0 { -half } else { half })
        });
        let children: Vec<Vec3> = signs
            .flat_map(|offset| open.iter().map(move |centre| centre + offset))
            .collect();
        open.clear();
        // A distance above half a diagonal means that the cube is on one side.
        let diagonal = 3.0_f64.sqrt() * half;
        for centre in children {
            let distance = surface.signed_distance(centre);
            if distance < -diagonal {
                inside += (2.0 * half).powi(3);
            } else if distance <= diagonal {
                open.push(centre);
            }
        }
    }
    let undecided = open.len() as f64 * (2.0 * half).powi(3);
    let (middle, allowed) = (inside + 0.5 * undecided, 0.5 * undecided);
    let found = surface.volume();
    let allowed = allowed + LENGTH_TOLERANCE * middle;
    let reason = "the volume of the points with a negative signed distance";
    agree("volume", reason, centre, (found, middle), allowed)
}

/// Checks one point and its closest point.
///
/// # Errors
/// [`MeshError::InconsistentSurface`].
fn check_sample(
    surface: &dyn Surface,
    (centre, radius): (Vec3, f64),
    point: Vec3,
    foot: Vec3,
) -> Result<(), MeshError> {
    let tolerance = LENGTH_TOLERANCE * radius;
    let (distance, signed) = ((point - foot).norm(), surface.signed_distance(point));
    let beyond = (foot - centre).norm().max(radius);
    agree(
        "distance of the closest point from the centre of the bounding ball",
        "the radius of the bounding ball",
        point,
        (beyond, radius),
        tolerance,
    )?;
    let at_foot = surface.signed_distance(foot);
    let what = "signed distance at the closest point";
    agree(what, "on the surface", point, (at_foot, 0.0), tolerance)?;
    agree(
        "magnitude of the signed distance",
        "the distance to the closest point",
        point,
        (signed.abs(), distance),
        tolerance,
    )?;
    if (point - centre).norm() > radius + tolerance {
        let what = "signed distance outside the bounding ball";
        let reason = "positive outside the shape";
        agree(what, reason, point, (signed, distance), tolerance)?;
    }
    let again = (surface.closest_point(foot) - foot).norm();
    let what = "distance of the closest point from its own closest point";
    agree(
        what,
        "a point of the surface",
        point,
        (again, 0.0),
        tolerance,
    )?;
    let margin = 2.0 * tolerance;
    let inside = |radius: f64| f64::from(u8::from(surface.contains_ball(point, radius)));
    if signed < -margin {
        let what = "answer of contains_ball (0 for no) for the ball up to the surface";
        agree(
            what,
            "inside the shape",
            point,
            (inside(-signed - margin), 1.0),
            0.0,
        )?;
    }
    let what = "answer of contains_ball (1 for yes) for a ball beyond the surface";
    let larger = (-signed).max(0.0) + margin;
    agree(what, "outside the shape", point, (inside(larger), 0.0), 0.0)?;
    let normal = surface.normal(foot);
    // The normal jumps at edges, which a surface without reach does not name.
    let is_smooth = surface.reach() > 0.0
        && surface
            .closest_on_sharp_edges(foot)
            .is_none_or(|edge| (edge - foot).norm() > 0.1 * radius);
    if !is_smooth || distance < 1e-3 * radius {
        return Ok(());
    }
    let line = (point - foot) * (signed.signum() / distance);
    let what = "difference of the normal from the direction of the closest point";
    let difference = (normal - line).norm();
    agree(
        what,
        "on a smooth surface",
        point,
        (difference, 0.0),
        DIRECTION_TOLERANCE,
    )?;
    if surface.closest_on_sharp_edges(foot).is_some() {
        return Ok(());
    }
    let reach = surface.reach().min(radius);
    for side in [-reach, reach] {
        let found = surface.signed_distance(foot + side * line);
        let what = "signed distance of the centre of a ball of the radius `reach` on the surface";
        agree(what, "fits to both sides", point, (found, side), tolerance)?;
    }
    Ok(())
}

/// Checks that two numbers differ by at most `allowed`.
///
/// # Errors
/// [`MeshError::InconsistentSurface`], also for NaN.
fn agree(
    what: &'static str,
    reason: &'static str,
    at: Vec3,
    (found, expected): (f64, f64),
    allowed: f64,
) -> Result<(), MeshError> {
    if (found - expected).abs() <= allowed {
        return Ok(());
    }
    Err(MeshError::InconsistentSurface {
        what,
        reason,
        at: at.into(),
        found,
        expected,
        allowed: allowed.max(0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit sphere whose functions have the given errors.
    #[derive(Default)]
    struct Wrong {
        foot: f64,
        sideways: f64,
        distance: f64,
        normal: f64,
        ball: f64,
        volume: f64,
        reach: f64,
        is_inside_out: bool,
    }

    impl Surface for Wrong {
        fn signed_distance(&self, x: Vec3) -> f64 {
            let distance = x.norm() - 1.0 + self.distance;
            if self.is_inside_out {
                -distance
            } else {
                distance
            }
        }
        fn closest_point(&self, x: Vec3) -> Vec3 {
            let aside = Vec3::new(-x.y, x.x, 0.0);
            (x.normalize() + self.sideways * aside).normalize() * (1.0 + self.foot)
        }
        fn normal(&self, x: Vec3) -> Vec3 {
            x.normalize() * (1.0 + self.normal)
        }
        fn bounding_ball(&self) -> (Vec3, f64) {
            (Vec3::zeros(), 1.0 + self.ball)
        }
        fn volume(&self) -> f64 {
            4.0 / 3.0 * PI + self.volume
        }
        fn is_convex(&self) -> bool {
            true
        }
        fn reach(&self) -> f64 {
            1.0 + self.reach
        }
    }

    #[test]
    fn each_error_is_named_with_its_numbers() {
        assert!(check_surface(&Wrong::default()).is_ok());
        let small = 1e-4;
        let of = |change: fn(&mut Wrong, f64), value: f64| {
            let mut wrong = Wrong::default();
            change(&mut wrong, value);
            match check_surface(&wrong).unwrap_err() {
                MeshError::InconsistentSurface { what, .. } => what,
                other => panic!("{other}"),
            }
        };
        assert!(of(|s, x| s.foot = x, -small).contains("at the closest point"));
        assert!(of(|s, x| s.sideways = x, 0.1).contains("magnitude"));
        assert!(of(|s, x| s.distance = x, small).contains("at the closest point"));
        assert!(of(|s, x| s.normal = x, 0.01).contains("normal"));
        assert!(of(|s, x| s.ball = x, -0.1).contains("bounding ball"));
        assert!(of(|s, x| s.ball = x, f64::NAN).contains("radius"));
        assert!(of(|s, x| s.volume = x, -5.0).contains("volume"));
        // The cubes that the octree leaves undecided hold 1.4, half of them on either side.
        assert_eq!(of(|s, x| s.volume = x, -0.8), "volume");
        let too_large = |s: &mut Wrong, x: f64| (s.ball, s.reach) = (x, x);
        assert!(of(too_large, 0.1).contains("`reach`"));
        assert!(of(|s, _| s.is_inside_out = true, 0.0).contains("outside the bounding ball"));
        assert!(of(|s, x| s.foot = x, f64::NAN).contains("closest point"));
    }
}
