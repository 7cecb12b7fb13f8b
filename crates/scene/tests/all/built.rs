//! Scenes built or changed by a program pass the same checks as files.

use nalgebra::Vector3;
use scene::{
    ArmsKind, CapsuleShape, DiskShape, Domain, EllipsoidShape, FemOptions, HelixShape, ModelKind,
    Scene, SceneBuilder, SceneError, Shape, SolverKind, SpheroidShape, TorusShape,
};

fn two_spheres() -> SceneBuilder {
    Scene::builder()
        .ball(40.0)
        .sphere("left", 1.0, [-10.0, 0.0, 0.0])
        .sphere("right", 1.0, [0.0; 3])
        .slide("arm", "left", "right")
        .phase("arm", 6.0, 1.0)
        .phase("arm", 10.0, 0.5)
}

#[test]
fn a_built_scene_is_the_scene_of_its_file() {
    let mut fem = FemOptions::default();
    fem.solver = SolverKind::Minres;
    fem.surface_size = Some(0.5);
    let size = Vector3::new(99.0, 98.0, 97.0);
    let built = two_spheres()
        .name("built")
        .viscosity(2.0)
        .domain(&Domain::Box { size })
        .spheroid("obstacle", 1.0, 2.0, [0.0, 0.0, 1.0], [0.0, 20.0, 0.0])
        .point("joint", [0.0, -5.0, 0.0])
        .slide("joint arm", "joint", "right")
        .pause(3.0)
        .cycles(2)
        .arms(ArmsKind::Free)
        .force("left", [0.0, 0.0, 1.0])
        .torque("right", [1.0, 0.0, 0.0])
        .fixed("obstacle")
        .mass("right", 3.0, 4.0)
        .model(ModelKind::Fem)
        .tolerance(1e-4)
        .fem(fem)
        .build()
        .unwrap();
    let text = r#"
        fluid.viscosity = 2
        domain = { kind = "box", size = [99, 98, 97] }
        model = { kind = "fem", tolerance = 1e-4 }
        fem = { solver = "minres", surface_size = 0.5 }
        bodies = [
            { name = "left", radius = 1, position = [-10, 0, 0], force = [0, 0, 1] },
            { name = "right", radius = 1, position = [0, 0, 0], torque = [1, 0, 0], mass = 3, inertia = 4 },
            { name = "obstacle", shape = "spheroid", radius = 1, half_length = 2, axis = [0, 0, 1], position = [0, 20, 0], fixed = true },
            { name = "joint", shape = "point", position = [0, -5, 0] },
        ]
        links = [
            { name = "arm", body = "left", to = "right" },
            { name = "joint arm", body = "joint", to = "right" },
        ]
        [gait]
        arms = "free"
        cycles = 2
        phases = [
            { link = "arm", length = 6 },
            { link = "arm", length = 10, duration = 0.5 },
            { duration = 3 },
        ]
    "#;
    let read = Scene::parse(text).unwrap();
    assert_eq!(built.to_toml().unwrap(), read.to_toml().unwrap());
    assert_eq!(built.name(), "built");
}

#[test]
fn a_built_scene_is_refused_for_the_same_reasons_as_a_file() {
    for (builder, message) in [
        (
            Scene::builder(),
            "scene built by a program: bodies is empty",
        ),
        (
            two_spheres().ball(f64::NAN),
            "domain.radius must be a number greater than zero, not nan",
        ),
        (
            two_spheres().cycles(0),
            "gait.cycles must be a whole number of at least 1, not 0",
        ),
        (
            two_spheres().sphere("left", 1.0, [5.0; 3]),
            "bodies[2].name \"left\" is the name of bodies[0] too",
        ),
        (
            two_spheres().force("lfet", [1.0; 3]),
            "bodies names no body: \"lfet\"; did you mean \"left\"?",
        ),
        (
            two_spheres().phase("amr", 5.0, 1.0),
            "gait.phases[2].link names no link: \"amr\"; did you mean \"arm\"?",
        ),
        (
            two_spheres().phase("arm", 2.0, 1.0),
            "touch or overlap in phase 3",
        ),
        (two_spheres().ball(10.5), "'left' is outside the domain"),
        (
            two_spheres().tolerance(1.0),
            "model.tolerance must be below 1",
        ),
    ] {
        let error = builder.build().expect_err(message).to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn options_that_a_program_sets_are_checked() {
    let scene = two_spheres().build().unwrap();
    let changed = scene.with_size_factor(Some(0.5)).unwrap();
    assert_eq!(changed.fem().size_factor, Some(0.5));
    assert_eq!(changed.with_size_factor(None).unwrap().fem(), scene.fem());
    assert_eq!(scene.with_tolerance(1e-5).unwrap().model().tolerance, 1e-5);
    let mut fem = *scene.fem();
    fem.surface_size = Some(-1.0);
    for (outcome, message) in [
        (
            scene.with_size_factor(Some(11.0)),
            "option set by a program: fem.size_factor must be between 1e-3 and 10, not 11",
        ),
        (
            scene.with_tolerance(f64::NAN),
            "model.tolerance must be a number greater than zero, not nan",
        ),
        (
            scene.with_fem(fem),
            "fem.surface_size must be a number greater than zero, not -1",
        ),
    ] {
        let error = outcome.expect_err(message).to_string();
        assert!(error.contains(message), "{error}");
    }
}

#[test]
fn mass_and_inertia_are_kept_for_the_integrators_of_the_library() {
    for (mass, inertia) in [(0.0, 0.0), (2.0, 0.0), (0.0, 0.5)] {
        let scene = two_spheres().mass("right", mass, inertia).build().unwrap();
        let body = &scene.bodies()[1];
        assert_eq!((body.mass, body.inertia), (mass, inertia));
    }
}

/// Every shape is written and read back as it was, and its orientation means the same in both keys.
#[test]
fn shapes_survive_writing_and_reading() {
    let axis = Vector3::new(2.0, -1.0, 2.0) / 3.0;
    let orientation = Vector3::new(0.5, 0.9, -0.3);
    let (radius, half_length, tube_radius) = (1.0, 2.5, 0.25);
    let shapes = [
        Shape::Ellipsoid(EllipsoidShape {
            semi_axes: Vector3::new(3.0, 2.0, 1.0),
            orientation,
        }),
        Shape::Spheroid(SpheroidShape {
            radius,
            half_length,
            axis,
        }),
        Shape::Capsule(CapsuleShape {
            radius,
            half_length,
            axis,
        }),
        Shape::Disk(DiskShape {
            radius,
            half_length: 0.25,
            axis,
        }),
        Shape::Torus(TorusShape {
            radius,
            tube_radius,
            axis,
        }),
        Shape::Helix(HelixShape {
            radius,
            tube_radius,
            pitch: -2.0,
            turns: 1.5,
            orientation,
        }),
    ];
    let mut builder = Scene::builder();
    for (k, shape) in shapes.iter().enumerate() {
        builder = builder.shaped(&format!("b{k}"), shape.clone(), [10.0 * k as f64, 0.0, 0.0]);
    }
    let scene = builder.build().unwrap();
    let text = scene.to_toml().unwrap();
    let again = Scene::parse(&text).unwrap();
    for ((body, read), shape) in scene.bodies().iter().zip(again.bodies()).zip(&shapes) {
        assert_eq!(body.shape, *shape);
        assert_eq!(read.shape, *shape);
    }
    let turned = Scene::parse(
        r#"bodies = [{ name = "c", shape = "capsule", radius = 1, half_length = 2,
           position = [0, 0, 0], orientation = [0, 0, 1.5707963267948966] }]"#,
    )
    .unwrap();
    let axis = turned.bodies()[0].shape.axis().unwrap();
    assert!((axis - Vector3::y()).norm() < 1e-15, "{axis}");
}

/// Capsules side by side, whose ends pass the line of the centres of their neighbours.
#[test]
fn gaps_of_long_bodies_are_not_those_of_their_balls() {
    let scene = |offset: f64| {
        let capsule = |y: f64, x: f64| {
            format!(
                r#"{{ name = "c{y}", shape = "capsule", radius = 1, half_length = 5, position = [{x}, {y}, 0] }}"#
            )
        };
        Scene::parse(&format!(
            "bodies = [{}, {}]",
            capsule(0.0, 0.0),
            capsule(2.5, offset)
        ))
    };
    for offset in [0.0, 3.0, 9.0] {
        assert!(scene(offset).is_ok(), "{offset}");
    }
    let overlapping = r#"bodies = [
        { name = "a", shape = "capsule", radius = 1, half_length = 5, position = [0, 0, 0] },
        { name = "b", shape = "capsule", radius = 1, half_length = 5, position = [4, 1.9, 0] }]"#;
    assert!(matches!(
        Scene::parse(overlapping),
        Err(SceneError::Touching { .. })
    ));
}
