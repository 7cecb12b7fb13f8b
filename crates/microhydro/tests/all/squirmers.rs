//! Squirmers and spheres in background flows against exact values.

use std::f64::consts::PI;

use microhydro::multipole::{self, SurfaceFlow, VelocityField};
use microhydro::{Accuracy, Medium, Spheres};
use nalgebra::{DVector, Matrix3, Vector3};

type Vec3 = Vector3<f64>;

fn slip(b1: f64, b2: f64, axis: Vec3) -> impl Fn(usize, &Vec3) -> Vec3 + Sync {
    move |_, n| {
        let cosine = n.dot(&axis);
        (axis - cosine * n) * -(b1 + b2 * cosine)
    }
}

fn flow(
    spheres: &Spheres,
    medium: &Medium,
    velocities: &[&multipole::SurfaceVelocity<'_>],
) -> SurfaceFlow {
    let resistance = multipole::resistance(spheres, medium, &Accuracy::relative(1e-9)).unwrap();
    multipole::surface_flow(spheres, medium, resistance.orders(), velocities).unwrap()
}

#[test]
fn squirmers_have_the_speed_and_power_of_lighthill_and_blake() {
    let radius = 1.7;
    let sphere = Spheres::new(vec![Vec3::new(0.2, -3.0, 1.0)], vec![radius]).unwrap();
    let axis = Vec3::new(2.0, -1.0, 2.0) / 3.0;
    let (b1, b2) = (0.8, -1.3);
    let found = flow(&sphere, &Medium::Unbounded, &[&slip(b1, b2, axis)]);
    let velocity = found.velocities.fixed_view::<3, 1>(0, 0).into_owned();
    assert!((velocity - axis * (2.0 * b1 / 3.0)).norm() < 1e-13);
    assert!(found.velocities.fixed_view::<3, 1>(3, 0).norm() < 1e-13);
    let power = 8.0 * PI / 3.0 * radius * (2.0 * b1 * b1 + b2 * b2);
    assert!((found.powers[(0, 0)] / power - 1.0).abs() < 1e-12);
}

#[test]
fn squirmers_in_a_concentric_ball_have_the_exact_speed_and_power() {
    let sphere = Spheres::new(vec![Vec3::zeros()], vec![1.0]).unwrap();
    let axis = Vec3::new(0.6, 0.0, 0.8);
    // U = (2 B1 / 3) (1 - 5 l^3 / 2 + 3 l^5 / 2) / (1 - l^5), P_1 = (16 pi / 3) (1 + 3 l^5 / 2) /
    // (1 - l^5); P_2 by an independent computation
    for (l, power_2) in [(0.5_f64, 1.414_872_798), (0.1, 1.003_668_420)] {
        let ball = Medium::Ball {
            centre: Vec3::zeros(),
            radius: 1.0 / l,
        };
        let found = flow(
            &sphere,
            &ball,
            &[&slip(1.0, 0.0, axis), &slip(0.0, 1.0, axis)],
        );
        let cube = l.powi(3);
        let fifth = l.powi(5);
        let speed = 2.0 / 3.0 * (1.0 - 2.5 * cube + 1.5 * fifth) / (1.0 - fifth);
        let velocity = found.velocities.fixed_view::<3, 1>(0, 0).into_owned();
        assert!((velocity - axis * speed).norm() < 1e-12);
        let power = 16.0 * PI / 3.0 * (1.0 + 1.5 * fifth) / (1.0 - fifth);
        assert!((found.powers[(0, 0)] / power - 1.0).abs() < 1e-12);
        // the reference has ten digits
        assert!((found.powers[(1, 1)] / (8.0 * PI / 3.0 * power_2) - 1.0).abs() < 5e-10);
        assert!(found.powers[(0, 1)].abs() < 1e-12);
    }
}

#[test]
fn free_spheres_follow_faxens_laws() {
    let radius = 0.7;
    let centre = Vec3::new(0.3, -0.4, 0.2);
    let sphere = Spheres::new(vec![centre], vec![radius]).unwrap();
    let gradient = Matrix3::new(0.3, 1.0, -0.2, 0.4, -0.5, 0.7, -1.1, 0.6, 0.2);
    let linear = move |_: usize, n: &Vec3| -(gradient * (centre + radius * n));
    // u = (1 - y^2 - z^2) e_x, Laplacian -4 e_x
    let quadratic = move |_: usize, n: &Vec3| {
        let x = centre + radius * n;
        Vec3::x() * (x.yz().norm_squared() - 1.0)
    };
    let found = flow(&sphere, &Medium::Unbounded, &[&linear, &quadratic]);
    let part = |row: usize, column: usize| {
        found
            .velocities
            .fixed_view::<3, 1>(row, column)
            .into_owned()
    };
    let vorticity = |g: &Matrix3<f64>| {
        Vec3::new(
            g[(2, 1)] - g[(1, 2)],
            g[(0, 2)] - g[(2, 0)],
            g[(1, 0)] - g[(0, 1)],
        )
    };
    assert!((part(0, 0) - gradient * centre).norm() < 1e-13);
    assert!((part(3, 0) - 0.5 * vorticity(&gradient)).norm() < 1e-13);
    let speed = 1.0 - centre.yz().norm_squared() - 4.0 * radius * radius / 6.0;
    assert!((part(0, 1) - Vec3::x() * speed).norm() < 1e-13);
    let spin = Vec3::new(0.0, -2.0 * centre.z, 2.0 * centre.y) * 0.5;
    assert!((part(3, 1) - spin).norm() < 1e-13);
    // The stresslet is (20 pi / 3) a^3 E; the double layer has the part 2 |B| E of it.
    let strain = 0.5 * (gradient + gradient.transpose());
    let power = 4.0 * PI * radius.powi(3) * strain.norm_squared();
    assert!((found.powers[(0, 0)] / power - 1.0).abs() < 1e-12);
}

/// The coefficients in the modes have the signs and orders of the expansions: the velocity on every
/// surface is the prescribed one, in each medium.
#[test]
fn the_flow_has_the_prescribed_velocity_on_every_surface() {
    let centres = vec![Vec3::new(0.1, 0.2, 2.0), Vec3::new(2.0, 1.5, 2.6)];
    let spheres = Spheres::new(centres, vec![1.0, 0.8]).unwrap();
    let ball = Medium::Ball {
        centre: Vec3::zeros(),
        radius: 6.0,
    };
    let wall = Medium::wall(Vec3::zeros(), Vec3::z()).unwrap();
    let squirm = slip(1.0, 2.0, Vec3::new(0.0, 0.6, 0.8));
    let surface = move |sphere: usize, n: &Vec3| match sphere {
        0 => squirm(0, n),
        _ => Vec3::new(n.y * n.y - n.z * n.z, n.x, 0.3 * n.y * n.z),
    };
    for medium in [Medium::Unbounded, ball, wall] {
        let found = flow(&spheres, &medium, &[&surface]);
        let velocities = DVector::from_column_slice(found.velocities.as_slice());
        let field = VelocityField::with_surface_velocity(
            &spheres,
            &medium,
            &velocities,
            Some(&surface),
            &Accuracy::relative(1e-4),
        )
        .unwrap();
        for sphere in 0..2 {
            let part = |row: usize| velocities.fixed_rows::<3>(6 * sphere + row).into_owned();
            for n in [
                Vec3::x(),
                -Vec3::y(),
                Vec3::new(0.6, 0.0, -0.8),
                Vec3::new(-0.48, 0.6, 0.64),
            ] {
                let arm = spheres.radii()[sphere] * n;
                let expected = part(0) + part(3).cross(&arm) + surface(sphere, &n);
                let velocity = field.velocity(&(spheres.centres()[sphere] + arm)).unwrap();
                assert!((velocity - expected).norm() < 3e-3, "{velocity} {expected}");
            }
        }
        // by expansions whose orders are lower by two
        let change = (&found.velocities - &found.coarser_velocities).amax();
        assert!(found.tail * change < 1e-7, "{change:e}");
    }
}
