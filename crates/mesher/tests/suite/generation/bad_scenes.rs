//! Scenes that cannot be meshed are errors with names and numbers.

use super::{ball, bodies, collinear};
use mesh::{MeshError, Vec3};
use mesher::GenerateError::{BadParameter, BodiesTouch, BodyAtWall, Mesh, TooManyVertices};
use mesher::{BoxSurface, Container, GenerateParams, generate};

#[test]
fn bad_scenes_are_errors_with_the_bodies_and_the_distance() {
    let params = GenerateParams::default();
    let run = |x: &[f64], container: &Container| {
        let shapes = collinear(x);
        generate(&bodies(&shapes, 0.4), container, &params)
    };
    let message = run(&[0.0, 1.5], &ball(40.0)).unwrap_err().to_string();
    assert!(
        message.contains("'a' and 'b'") && message.contains("-5.000e-1"),
        "{message}"
    );
    assert_refused!(run(&[0.0, 2.0], &ball(40.0)), BodiesTouch { .. });
    assert_refused!(run(&[39.5], &ball(40.0)), BodyAtWall { .. });
    assert_refused!(run(&[100.0], &ball(40.0)), BodyAtWall { .. });
    assert_refused!(run(&[0.0], &ball(1.0)), BodyAtWall { .. });
    assert_refused!(run(&[f64::NAN], &ball(40.0)), BadParameter { .. });
    assert_refused!(run(&[0.0], &ball(-1.0)), BadParameter { .. });
    let flat = Container::Box(BoxSurface {
        min: Vec3::repeat(-5.0),
        max: Vec3::new(5.0, 5.0, -5.0),
    });
    assert_refused!(run(&[0.0], &flat), BadParameter { .. });

    let shapes = collinear(&[-5.0, 5.0]);
    let mut twins = bodies(&shapes, 0.4);
    twins[1].name = twins[0].name;
    let twice = generate(&twins, &ball(40.0), &params);
    assert_refused!(twice, Mesh(MeshError::BadTag { .. }));
    let sized = |size: f64| generate(&bodies(&shapes, size), &ball(40.0), &params);
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_refused!(sized(size), BadParameter { .. });
    }
    assert_refused!(sized(1e-9), TooManyVertices { .. });
}
