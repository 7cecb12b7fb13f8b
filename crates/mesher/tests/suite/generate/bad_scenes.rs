//! Scenes that cannot be meshed are errors with names and numbers.

use super::{ball, bodies, collinear};
use mesh::{MeshError, Vec3};
use mesher::{BoxSurface, Container, GenerateError, GenerateParams, Sphere, generate};

#[test]
fn bad_scenes_are_errors_with_the_bodies_and_the_distance() {
    let run = |shapes: &[Sphere], container: &Container| match generate(
        &bodies(shapes, 0.4),
        container,
        &GenerateParams::default(),
    ) {
        Ok(_) => panic!("a mesh of a scene that cannot be meshed"),
        Err(error) => error,
    };
    let message = run(&collinear(&[0.0, 1.5]), &ball(40.0)).to_string();
    assert!(
        message.contains("'a' and 'b'") && message.contains("-5.000e-1"),
        "{message}"
    );
    assert!(matches!(
        run(&collinear(&[0.0, 2.0]), &ball(40.0)),
        GenerateError::BodiesTouch { .. }
    ));
    assert!(matches!(
        run(&collinear(&[39.5]), &ball(40.0)),
        GenerateError::BodyAtWall { .. }
    ));
    assert!(matches!(
        run(&collinear(&[100.0]), &ball(40.0)),
        GenerateError::BodyAtWall { .. }
    ));
    assert!(matches!(
        run(&collinear(&[0.0]), &ball(1.0)),
        GenerateError::BodyAtWall { .. }
    ));
    assert!(matches!(
        run(&collinear(&[f64::NAN]), &ball(40.0)),
        GenerateError::BadParameter { .. }
    ));
    assert!(matches!(
        run(&collinear(&[0.0]), &ball(-1.0)),
        GenerateError::BadParameter { .. }
    ));
    let flat = Container::Box(BoxSurface {
        min: Vec3::repeat(-5.0),
        max: Vec3::new(5.0, 5.0, -5.0),
    });
    assert!(matches!(
        run(&collinear(&[0.0]), &flat),
        GenerateError::BadParameter { .. }
    ));

    let shapes = collinear(&[-5.0, 5.0]);
    let mut twins = bodies(&shapes, 0.4);
    twins[1].name = twins[0].name;
    let params = GenerateParams::default();
    assert!(matches!(
        generate(&twins, &ball(40.0), &params),
        Err(GenerateError::Mesh(MeshError::BadTag { .. }))
    ));
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            generate(&bodies(&shapes, size), &ball(40.0), &params),
            Err(GenerateError::BadParameter { .. })
        ));
    }
    assert!(matches!(
        generate(&bodies(&shapes, 1e-9), &ball(40.0), &params),
        Err(GenerateError::TooManyVertices { .. })
    ));
}
