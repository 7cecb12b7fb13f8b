//! Velocity field: values on every surface, exact flow of a lone sphere, points outside the fluid.

use microhydro::{Accuracy, HydroError, Medium, Spheres, multipole};
use nalgebra::{DVector, Vector3};

fn spheres() -> Spheres {
    let centres = vec![
        Vector3::new(0.2, 0.0, 0.5),
        Vector3::new(3.1, 0.7, 0.0),
        Vector3::new(-0.5, 3.0, -0.4),
    ];
    Spheres::new(centres, vec![1.0, 0.8, 1.2]).unwrap()
}

fn velocities() -> DVector<f64> {
    DVector::from_fn(18, |k, _| ((3 * k + 1) as f64).sin())
}

fn directions() -> impl Iterator<Item = Vector3<f64>> {
    (0..12).map(|k| {
        let k = f64::from(k);
        Vector3::new(
            (1.7 * k).sin(),
            (2.3 * k + 1.0).cos(),
            (0.9 * k).sin() + 0.1,
        )
        .normalize()
    })
}

#[test]
fn velocity_on_every_surface_is_that_of_the_surface() {
    let media = [
        Medium::Unbounded,
        Medium::Ball {
            centre: Vector3::new(0.5, 0.5, 0.0),
            radius: 8.0,
        },
        Medium::wall(Vector3::new(0.0, 0.0, -3.0), Vector3::new(0.1, -0.2, 1.0)).unwrap(),
    ];
    let (spheres, velocities) = (spheres(), velocities());
    for medium in media {
        let flow = multipole::VelocityField::new(
            &spheres,
            &medium,
            &velocities,
            &Accuracy::relative(1e-4),
        )
        .unwrap();
        for (k, (x, a)) in spheres.centres().iter().zip(spheres.radii()).enumerate() {
            let at = |first: usize| velocities.fixed_rows::<3>(first).into_owned();
            for n in directions() {
                let exact = at(6 * k) + at(6 * k + 3).cross(&(n * *a));
                let found = flow.velocity(&(x + n * *a)).unwrap();
                assert!(
                    (found - exact).norm() < 1e-3,
                    "{medium:?} {k}: {found} {exact}"
                );
            }
        }
        for n in directions() {
            let on_boundary = match medium {
                Medium::Unbounded => continue,
                Medium::Ball { centre, radius } => centre + n * radius,
                Medium::Wall { point, normal } => {
                    let along = 3.0 * n + point;
                    along - medium.distance(&along) * normal.into_inner() * (1.0 - 1e-9)
                }
            };
            if medium.distance(&on_boundary) >= 0.0 {
                assert!(
                    flow.velocity(&on_boundary).unwrap().norm() < 1e-3,
                    "{medium:?}"
                );
            }
        }
    }
}

#[test]
fn a_lone_sphere_has_the_flow_of_stokes() {
    let one = Spheres::new(vec![Vector3::zeros()], vec![2.0]).unwrap();
    let mut u = DVector::zeros(6);
    u[0] = 1.0;
    let flow =
        multipole::VelocityField::new(&one, &Medium::Unbounded, &u, &Accuracy::relative(1e-6))
            .unwrap();
    for n in directions() {
        let r = 3.7;
        let (c, d) = (1.5 / r, 2.0 / (r * r * r));
        let exact = Vector3::x() * (c + d) + n * n.x * (c - 3.0 * d);
        assert!((flow.velocity(&(n * r)).unwrap() - exact).norm() < 1e-12);
    }
    assert!(matches!(
        flow.velocity(&Vector3::zeros()),
        Err(HydroError::NotInFluid { .. })
    ));
}

#[test]
fn bug_the_flow_at_points_of_a_wall_lacked_the_images() {
    // and to the rounding of points below it
    let wall = Medium::wall(Vector3::zeros(), Vector3::z()).unwrap();
    let one = Spheres::new(vec![Vector3::new(0.0, 0.0, 3.0)], vec![1.0]).unwrap();
    let motion = DVector::from_fn(6, |k, _| (k as f64).cos());
    let flow =
        multipole::VelocityField::new(&one, &wall, &motion, &Accuracy::relative(1e-4)).unwrap();
    for n in directions() {
        for height in [0.0, -1e-13] {
            let on_wall = Vector3::new(n.x, n.y, height);
            assert_eq!(flow.velocity(&on_wall).unwrap(), Vector3::zeros());
        }
        let near = flow.velocity(&Vector3::new(n.x, n.y, 1e-9)).unwrap();
        // the gradient at the wall is below one
        assert!(near.norm() < 1e-9, "{near}");
    }
}
