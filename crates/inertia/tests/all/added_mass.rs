//! Forces that accelerate the fluid around bodies.

use std::f64::consts::PI;

use fem::TaylorHood;
use inertia::added_mass_forces;
use mesher::{Container, Ellipsoid, GenerateParams, MeshedBody, Sphere, generate};
use nalgebra::Vector6;

use crate::support::{QUARTER, Vec3, sphere_at, sphere_in_ball};

/// `2/3 π a^3 (b^3 + 2 a^3) / (b^3 - a^3)` in a concentric ball (Lamb 1932, section 93).
fn in_ball(b: f64) -> f64 {
    let b3 = b.powi(3);
    2.0 / 3.0 * PI * (b3 + 2.0) / (b3 - 1.0)
}

/// Force on the sphere at `centre` with this acceleration.
fn force(mesh: &mesh::TetMesh, centre: Vec3, acceleration: Vector6<f64>) -> Vector6<f64> {
    let space = TaylorHood::new(mesh).unwrap();
    added_mass_forces(mesh, &space, &[("sphere", centre)], &[acceleration]).unwrap()[0]
}

#[test]
fn the_added_mass_of_a_sphere_in_a_ball_is_that_of_lamb() {
    let along_z = Vector6::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.0);
    for b in [2.0, 5.0] {
        let errors = [0.4, 0.2].map(|size| {
            let found = force(&sphere_in_ball(size, b, QUARTER), Vec3::zeros(), along_z);
            assert!(found.rows(0, 2).amax() == 0.0 && found.rows(3, 3).amax() == 0.0);
            (found.z / in_ball(b) - 1.0).abs()
        });
        println!("{b}: {errors:?}");
        // cells away from the sphere hardly depend on the size of those on it
        assert!(errors[1] < 5e-3 && errors[1] < errors[0], "{b}: {errors:?}");
    }
}

/// On a quarter of the fluid and on all of it.
#[test]
fn forces_on_a_part_of_the_fluid_are_those_on_whole_bodies() {
    let centre = Vec3::new(0.0, 0.0, 0.7);
    let twist = Vector6::new(0.0, 0.0, 1.0, 0.0, 0.0, 0.0);
    let [part, whole] = [QUARTER, [false; 3]]
        .map(|planes| force(&sphere_at(centre, 0.5, 3.0, planes), centre, twist));
    // two meshes of a size with errors of about 5e-3, as above
    assert!(
        (part - whole).norm() < 1e-2 * whole.norm(),
        "{part} {whole}"
    );
    // a sphere that turns moves no fluid without viscosity
    let turning = Vector6::new(0.0, 0.0, 0.0, 1.0, 2.0, 3.0);
    let mesh = sphere_at(centre, 0.5, 3.0, [false; 3]);
    assert!(force(&mesh, centre, turning).norm() < 1e-2 * whole.norm());
}

/// The moment of an ellipsoid with the semi-axes 1, 1/2, 1/2 that turns about an axis across its
/// long one, `4/15 π a b^2 (a^2 - b^2)^2 (γ - α) / (2 (a^2 - b^2) + (a^2 + b^2) (α - γ))` with `α =
/// 2 (1 - e^2) / e^3 (artanh e - e)` and `γ = 1 / e^2 - (1 - e^2) / e^3 artanh e` (Lamb 1932,
/// section 115).
#[test]
fn a_spheroid_that_turns_has_the_moment_of_lamb() {
    let ellipsoid = Ellipsoid {
        semi_axes: Vec3::new(1.0, 0.5, 0.5),
    };
    let ball = Sphere {
        centre: Vec3::zeros(),
        radius: 5.0,
    };
    let body = MeshedBody {
        name: "spheroid",
        surface: &ellipsoid,
        size: 0.12,
    };
    let tets = generate(&[body], &Container::Ball(ball), &GenerateParams::default()).unwrap();
    let surfaces: [mesh::NamedSurface<'_>; 2] = [("spheroid", &ellipsoid), (Container::TAG, &ball)];
    let mesh = mesh::TetMesh::curved(tets.mesh, &surfaces).unwrap();
    let space = TaylorHood::new(&mesh).unwrap();
    let turning = Vector6::new(0.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let found = added_mass_forces(&mesh, &space, &[("spheroid", Vec3::zeros())], &[turning]);
    let torque = found.unwrap()[0][4];
    let (a2, b2): (f64, f64) = (1.0, 0.25);
    let e = f64::sqrt(0.75);
    let alpha = 2.0 * (1.0 - e * e) / e.powi(3) * (e.atanh() - e);
    let gamma = 1.0 / (e * e) - (1.0 - e * e) / e.powi(3) * e.atanh();
    let difference = a2 - b2;
    let exact = 4.0 / 15.0 * PI * b2 * difference.powi(2) * (gamma - alpha)
        / (2.0 * difference + (a2 + b2) * (alpha - gamma));
    // elements of half the smallest radius of curvature, as for the sphere above; the ball changes
    // it by `b^-5`
    assert!((torque / exact - 1.0).abs() < 1e-2, "{torque} {exact}");
}
